//! What is learned about a view before paths are followed in it: which light to draw on which
//! surface.

use rayon::prelude::*;

use super::emitter_choice::EmitterChoice;
use super::places::Receiver;
use super::vpl_choice::VplChoice;
use super::{Compensation, LightingContext};
use crate::bsdf::Bsdf;
use crate::gather::{GatherPoint, View};
use crate::rng::{self, Purpose, Stream};

/// Camera paths whose surfaces are learned from: so many a pixel, and at least and at most.
const PATHS_OF_PIXEL: u64 = 2;
/// See [`PATHS_OF_PIXEL`].
const PATHS: [u64; 2] = [1 << 12, 1 << 17];
/// Paths followed as one piece of parallel work.
const CHUNK: u64 = 1024;

/// What was learned about which lights are worth drawing where.
#[derive(Clone, Debug)]
pub struct Choices {
    pub(super) vpls: Option<VplChoice>,
    pub(super) emitters: EmitterChoice,
}

/// Surfaces that paths met.
#[derive(Debug, Default)]
pub(super) struct Met {
    /// Those that have a VPL drawn.
    pub by_vpls: Vec<Receiver>,
    /// Those that have an emitter drawn: all.
    pub by_emitters: Vec<Receiver>,
    /// Whether VPLs are drawn at gather points, too.
    pub draws_at_points: bool,
}

impl Choices {
    /// Learns on the surfaces that paths from a view meet. Runs on the current thread pool.
    ///
    /// * `by_vpls`: the BSDF that light of VPLs is scattered with at a gather point.
    /// * `draws_at_points`: whether VPLs are drawn there, or summed.
    pub fn learn(
        lit: &LightingContext<'_>,
        view: &View<'_>,
        by_vpls: impl Fn(&GatherPoint) -> Bsdf + Sync,
        draws_at_points: bool,
        seed: u64,
    ) -> Self {
        let pixels: u64 = view.size.iter().map(|side| u64::from(*side)).product();
        let paths = (PATHS_OF_PIXEL * pixels).clamp(PATHS[0], PATHS[1]);
        let chunks = (0..paths / CHUNK).into_par_iter().map(|chunk| {
            let mut compensation = Compensation {
                met: Some(Met { draws_at_points, ..Met::default() }),
                ..Compensation::new(*lit)
            };
            for path in chunk * CHUNK..(chunk + 1) * CHUNK {
                let key = rng::key(seed, Purpose::Guidance, path);
                let mut stream = Stream::new(key, Purpose::Guidance, 0);
                let pixel = view.size.map(|side| stream.below(side.into()) as u32);
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
        // Most are drawn at gather points, if any are there.
        let beyond = compensation.contribution(draws_at_points);
        let learn_vpls = |lights| VplChoice::learn(lights, lit.tracer, beyond, met.by_vpls, seed);
        let vpls = lit.lights.and_then(learn_vpls);
        let key = rng::key(seed, Purpose::Guidance, paths);
        Self { vpls, emitters: EmitterChoice::learn(lit, met.by_emitters, key) }
    }
}
