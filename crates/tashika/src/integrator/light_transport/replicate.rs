//! One repetition of a pixel: other VPLs, other gather points, other paths.

use smallvec::SmallVec;

use super::super::Setting;
use super::sets::LightSet;
use crate::accel::Glass;
use crate::bounds::UpperAnalytic;
use crate::bsdf::{Bsdf, Lambert};
use crate::color::{Controlled, Rgb, RgbSum};
use crate::cut::{ByUpper, Clusters, CutMemory, InheritedCut, StrataOptions, gather_tree};
use crate::gather::{Features, GatherPoint, PixelSum, View};
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;
use crate::stats::stratified::Spread;
use crate::transport::Transport;
use crate::tree::GatherTree;
use crate::uncarried::{Lit, Uncarried};
use crate::vpl::EmitterSampler;

/// Terms up to which a pair is evaluated as a whole: as many as would be drawn from it.
const FINEST: u64 = 2;
/// Lobes narrower than that of this GGX roughness are left to paths: a mirror image of so few VPLs would be spots. Chosen.
const NARROW: f32 = 0.25;

/// A pixel in the light of one set.
pub(super) struct Repetition<'a> {
    set: &'a LightSet,
    lit: Lit<'a>,
    pixel: PixelSum,
    /// The gather points as they are summed: without narrow lobes.
    summed: Vec<GatherPoint>,
    /// One for each gather point that was looked for; those behind mirrors and glass take more, which are not counted.
    camera_rays: u64,
    key: u64,
}

/// What a repetition says of each part of what is controlled.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known {
    /// Variance of the sum over VPLs, given the VPLs.
    pub clustering: f64,
    /// About the largest contribution that no sample may have shown.
    pub rare: f64,
    /// Of single paths.
    pub paths: Moments,
    /// Of the whole.
    pub value: Moments,
}

/// By what a pixel is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// A sum over VPLs, and paths of what these do not carry.
    Vpls,
    /// Paths alone.
    Paths,
}

/// What a repetition is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Recipe {
    pub estimator: Estimator,
    /// Pairs of the cut.
    pub pairs: u64,
    /// Paths, which are spread over the gather points.
    pub paths: u32,
}

/// How far a cut was refined.
pub(super) struct Planned {
    pub pairs: u64,
    /// What it came to then, with the background.
    pub sum: RgbSum,
    pub rays: u64,
}

/// What a repetition says.
pub(super) struct Repeated {
    pub sum: RgbSum,
    pub known: SmallVec<[Known; 3]>,
    pub features: Features,
    pub pairs: u64,
    pub rays: u64,
}

/// The BSDF that VPLs are summed with.
fn summed_with(point: &GatherPoint) -> Bsdf {
    if point.bsdf.roughness().is_some_and(|alpha| alpha < NARROW) {
        Bsdf::Lambert(Lambert { reflectance: point.bsdf.vpl_reflectance(point.wo) })
    } else {
        point.bsdf
    }
}

impl<'a> Repetition<'a> {
    /// Of a pixel, with gather points of its own; `key` is that of all its random numbers. Only where what VPLs do not carry is put back are narrow
    /// lobes left to paths.
    pub(super) fn new(
        setting: &Setting<'a>,
        emitters: &'a EmitterSampler<'a>,
        set: &'a LightSet,
        pixel: [u32; 2],
        key: u64,
        compensated: bool,
    ) -> Self {
        let view = View { seed: rng::key(key, Purpose::Gather, 0), ..setting.view };
        let pixel = view.pixel(setting.tracer, pixel);
        let summed = pixel
            .points
            .iter()
            .map(|p| if compensated { GatherPoint { bsdf: summed_with(p), ..*p } } else { *p })
            .collect();
        let transport = Transport::new(set.provenance.clamp_distance).with_glass(Glass::SolidStops);
        let lit = Lit {
            tracer: setting.tracer,
            emitters,
            lights: Some(&set.tree),
            transport,
            max_depth: set.provenance.max_depth,
        };
        Self { set, lit, pixel, summed, camera_rays: view.gather.points.into(), key }
    }

    /// Has a look at cuts of growing size until `enough` says so of the sum with background and its spread.
    pub(super) fn plan(
        &self,
        controlled: Controlled,
        sizes: impl Iterator<Item = u64>,
        enough: impl Fn(&RgbSum, &Spread) -> bool,
    ) -> Planned {
        let mut sum = RgbSum::default();
        sum.add(self.pixel.background);
        let points = gather_tree::<UpperAnalytic>(&self.summed);
        let mut memory = CutMemory::default();
        let Some(mut cut) = self.cut(&points, controlled, &mut memory) else {
            return Planned { pairs: 0, sum, rays: self.camera_rays };
        };
        for size in sizes {
            cut.grow(size);
            let gathered = cut.estimate();
            sum = gathered;
            sum.add(self.pixel.background);
            if cut.is_whole() || enough(&sum, &cut.spread(0, &gathered)) {
                break;
            }
        }
        Planned { pairs: cut.pairs(), sum, rays: self.camera_rays + cut.segments() }
    }

    fn cut<'c>(
        &'c self,
        points: &'c GatherTree<UpperAnalytic>,
        controlled: Controlled,
        memory: &'c mut CutMemory,
    ) -> Option<InheritedCut<'c, UpperAnalytic, ByUpper>> {
        let clamp_distance = self.set.provenance.clamp_distance;
        let clusters = Clusters { lights: &self.set.tree, points, clamp_distance };
        let samples = Stream::new(self.key, Purpose::Cut, 0);
        let order = ByUpper { finest: FINEST };
        let options = StrataOptions { inherits: true, lists: true, corrects: true, controlled };
        InheritedCut::new(clusters, order, options, self.lit.tracer, self.lit.transport, samples, memory)
    }

    pub(super) fn estimate(
        &self,
        controlled: Controlled,
        recipe: &Recipe,
        memory: &mut CutMemory,
    ) -> Repeated {
        let mut sum = RgbSum::default();
        sum.add(self.pixel.background);
        let mut known: SmallVec<[Known; 3]> = SmallVec::new();
        let mut repeated_pairs = 0;
        let mut rays = self.camera_rays;
        let points = gather_tree::<UpperAnalytic>(&self.summed);
        let parts = controlled.parts();
        known.resize(parts.len(), Known::default());
        if let (Estimator::Vpls, Some(mut cut)) = (recipe.estimator, self.cut(&points, controlled, memory)) {
            cut.grow(recipe.pairs);
            let gathered = cut.estimate();
            for (part, known) in known.iter_mut().enumerate() {
                let spread = cut.spread(part, &gathered);
                known.clustering = spread.reckoned_variance();
                known.rare = spread.importance_largest();
            }
            sum.merge(&gathered);
            repeated_pairs = cut.pairs();
            rays += cut.segments();
        }
        rays += self.paths(recipe.estimator, recipe.paths, |value, of| {
            sum.add(value / of as f32);
            for (part, known) in parts.iter().zip(&mut known) {
                known.paths.push(part.of(value));
            }
        });
        for (part, known) in parts.iter().zip(&mut known) {
            known.value.push(part.of_sum(&sum));
        }
        Repeated { sum, known, features: self.pixel.features, pairs: repeated_pairs, rays }
    }

    /// Follows `count` paths, rounded up to as many from each gather point; each is told as an estimate of all that such paths have to find, with how many
    /// there are. Returns the rays.
    pub(super) fn paths(&self, estimator: Estimator, count: u32, mut tell: impl FnMut(Rgb, u32)) -> u64 {
        let points = self.pixel.points.len() as u32;
        if points == 0 {
            return 0;
        }
        let lights = self.lit.lights.filter(|_| estimator == Estimator::Vpls);
        let mut uncarried = Uncarried::new(Lit { lights, ..self.lit });
        let each = count.div_ceil(points);
        let of = each * points;
        for (number, (point, summed)) in self.pixel.points.iter().zip(&self.summed).enumerate() {
            for path in 0..each {
                let index = (number as u64) << 32 | u64::from(path);
                let mut stream = Stream::new(self.key, Purpose::Uncarried, index);
                let key = rng::key(self.key, Purpose::Opacity, index);
                let value = uncarried.estimate(point, &summed.bsdf, key, &mut stream);
                tell(value * points as f32, of);
            }
        }
        uncarried.rays()
    }
}
