//! Learned choice of lights: the emitters and VPLs that are worth drawing at each place of a view.

use rayon::prelude::*;

use super::emitter_choice::EmitterChoice;
use super::places::Receiver;
use super::vpl_choice::VplChoice;
use super::{Compensation, LightingContext};
use crate::bsdf::Bsdf;
use crate::film::Window;
use crate::gather::{GatherPoint, View};
use crate::rng::{self, Purpose, Stream};

/// Number of camera paths for each pixel from which the choices are learned.
const PATHS_OF_PIXEL: u64 = 2;
/// Least and greatest number of these paths.
const PATHS: [u64; 2] = [1 << 12, 1 << 17];
/// Paths followed as one piece of parallel work.
const CHUNK: u64 = 1024;

/// Learned distributions of VPLs and emitters, by place.
#[derive(Clone, Debug)]
pub struct Choices {
    pub(super) vpls: Option<VplChoice>,
    pub(super) emitters: EmitterChoice,
}

/// Receivers that paths met, by the kind of light that is drawn for them.
#[derive(Debug, Default)]
pub(super) struct Met {
    /// Receivers for which a VPL is drawn.
    pub by_vpls: Vec<Receiver>,
    /// All receivers, since an emitter is drawn for each.
    pub by_emitters: Vec<Receiver>,
    /// True if VPLs are drawn at gather points too.
    pub draws_at_points: bool,
}

impl Choices {
    /// Learns the distributions from paths through random pixels of a view. Runs on the current
    /// thread pool.
    ///
    /// * `by_vpls`: the BSDF with which a gather point scatters light of VPLs.
    /// * `draws_at_points`: true if VPLs are drawn at gather points, false if they are summed
    ///   there.
    pub fn learn(
        lit: &LightingContext<'_>,
        view: &View<'_>,
        by_vpls: impl Fn(&GatherPoint) -> Bsdf + Sync,
        draws_at_points: bool,
        seed: u64,
    ) -> Self {
        let paths = PATHS_OF_PIXEL.saturating_mul(view.guided_pixels()).clamp(PATHS[0], PATHS[1]);
        let chunks = (0..paths / CHUNK).into_par_iter().map(|chunk| {
            let mut compensation = Compensation {
                met: Some(Met { draws_at_points, ..Met::default() }),
                ..Compensation::new(*lit)
            };
            for path in chunk * CHUNK..(chunk + 1) * CHUNK {
                let key = rng::key(seed, Purpose::Guidance, path);
                let mut stream = Stream::new(key, Purpose::Guidance, 0);
                let pixel = view.random_pixel(&Window::full(view.size), &mut stream);
                for point in view.samples(lit.tracer, pixel, 1, key).points {
                    compensation.estimate(&point, &by_vpls(&point), key, &mut stream);
                }
            }
            compensation.met.unwrap_or_default()
        });
        let mut met = Met::default();
        for of_chunk in chunks.collect::<Vec<_>>() {
            met.by_vpls.extend(of_chunk.by_vpls);
            met.by_emitters.extend(of_chunk.by_emitters);
        }
        let compensation = Compensation::new(*lit);
        // If VPLs are also drawn at gather points, most are drawn there, so the clamp distance of
        // gather points is used.
        let beyond = compensation.contribution(draws_at_points);
        let learn_vpls = |lights| VplChoice::learn(lights, lit.tracer, beyond, met.by_vpls, seed);
        let vpls = lit.lights.and_then(learn_vpls);
        let key = rng::key(seed, Purpose::Guidance, paths);
        Self { vpls, emitters: EmitterChoice::learn(lit, met.by_emitters, key) }
    }
}
