//! Estimate of a pixel: gather points, a cut of VPLs over them, and paths. It grows until it is
//! precise enough.

use super::super::Setting;
use super::GuidedLights;
use super::nearby::Nearby;
use crate::accel::Glass;
use crate::bounds::{UpperAnalytic, UpperScattering};
use crate::bsdf::{Bsdf, Lambert};
use crate::color::{Controlled, Rgb, RgbSum};
use crate::compensation::{Compensation, LightingContext};
use crate::contribution::ContributionKernel;
use crate::cut::{Clusters, CutMemory, InheritedCut, Rank, StrataOptions, VisibilityPrior, gather_tree};
use crate::gather::{GatherPoint, PixelSum, SeenSample};
use crate::math::elementary::ln_f64;
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;
use crate::stats::stratified::Spread;
use crate::tree::GatherTree;
use crate::vpl::EmitterSampler;

/// GGX roughness below which lobes are left to paths: a few VPLs would appear as spots in a mirror.
/// Chosen.
const NARROW: f32 = 0.25;
/// Share of the light that is projected onto a pixel. An estimate below this share is taken to have
/// missed that light. An estimate that did not miss the light may still be somewhat below the
/// projection, by chance, by the pixel filter or by geometry in front of the light.
pub(super) const MIN_PROJECTED_SHARE: f64 = 0.25;
/// Least number of trial samples that meet emission for which the camera samples of the gather
/// points suffice to estimate it. Chosen: if four are expected to meet emission, the probability
/// that none does is 1/50.
pub(super) const MIN_EMISSION_HITS: usize = 4;
/// Standard error due to the choice of VPLs, over the tolerance, below which that error need not be
/// estimated more precisely. Chosen.
const SMALL: f64 = 0.1;
/// Number of camera samples that are drawn in one batch to begin paths.
const POINTS_AT_ONCE: u32 = 32;

/// Method of estimating a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// A sum over VPLs, and paths of the light that VPLs do not carry.
    Vpls,
    /// Paths of all light, without VPLs.
    Paths,
}

/// Shared data of all estimates of an image.
#[derive(Clone, Copy)]
pub(super) struct Common<'a> {
    pub setting: &'a Setting<'a>,
    pub emitters: &'a EmitterSampler<'a>,
    pub lights: &'a GuidedLights,
    /// True if paths add the light that VPLs do not carry.
    pub compensates: bool,
    pub controlled: Controlled,
}

impl<'a> Common<'a> {
    /// Context of the paths of an estimator; `clamp_distance` is the clamp distance of the VPLs.
    pub(super) fn lit(&self, estimator: Estimator, clamp_distance: f32) -> LightingContext<'a> {
        LightingContext {
            tracer: self.setting.tracer,
            emitters: self.emitters,
            lights: (estimator == Estimator::Vpls).then(|| self.lights.tree()),
            vpl_source: self.lights.source(),
            choices: self.lights.choices(),
            contribution: ContributionKernel::new(clamp_distance)
                .with_glass(Glass::SolidStops)
                .within(self.setting.tracer.scene()),
            max_depth: self.lights.provenance().max_depth,
            caustics: self.lights.caustics(),
        }
    }

    /// Returns true if lamps are seen in a pixel.
    pub(super) fn sees_lamps(&self, pixel: [u32; 2]) -> bool {
        self.lights.lamps().is_some_and(|lamps| lamps.importance_radiance(pixel) > 0.0)
    }

    /// Luminance of a pixel due to lamps and sky that it sees, less two standard errors of its
    /// projection, if these camera samples have met hardly any of that light; else 0
    /// (W·m⁻²·sr⁻¹).
    pub(super) fn unsampled_emission(&self, pixel: [u32; 2], seen: &PixelSum) -> f64 {
        // A single point of a lamp that is drawn rarely is no evidence.
        let of_lamps = self.lights.lamps().map_or(0.0, |lamps| lamps.importance_least(pixel));
        let of_sky = self.lights.sky().map_or(0.0, |sky| sky.importance_least(seen));
        let there = of_lamps.max(of_sky);
        let met = f64::from(seen.background.luminance());
        if met < MIN_PROJECTED_SHARE * there { there } else { 0.0 }
    }

    /// Returns true if the light of the sky in a pixel comes from a part of it that hardly any of
    /// these camera samples met. A sample that meets such a part is brighter than the pixel.
    pub(super) fn is_sky_rare(&self, seen: &PixelSum) -> bool {
        let of_pixel = self.lights.sky().map_or(0.0, |sky| sky.importance_least(seen));
        let count = seen.samples.len() as f64;
        let is_brighter = |sample: &&SeenSample| f64::from(sample.background.luminance()) * count > of_pixel;
        of_pixel > 0.0 && seen.samples.iter().filter(is_brighter).count() < MIN_EMISSION_HITS
    }

    /// Approximate lower bound on the luminance of the surfaces that camera samples met, from light
    /// paths alone (W·m⁻²·sr⁻¹).
    pub(super) fn by_light_paths(&self, seen: &PixelSum) -> f64 {
        let Some(photons) = self.lights.photons() else { return 0.0 };
        let of_point = |p: &GatherPoint| {
            f64::from(p.weight.luminance()) * photons.importance_radiance(p.position, p.geometric_normal)
        };
        seen.points.iter().filter(|p| p.phase.is_none()).map(of_point).sum()
    }

    /// Draws `count` camera samples of a pixel by the random numbers of `key`.
    pub(super) fn samples(&self, pixel: [u32; 2], count: u32, key: u64) -> PixelSum {
        let seed = rng::key(key, Purpose::Gather, 0);
        self.setting.view.samples(self.setting.tracer, pixel, count, seed)
    }
}

/// Returns true if a surface mirrors too sharply for VPLs.
pub(super) fn is_near_specular(bsdf: &Bsdf) -> bool {
    bsdf.roughness().is_some_and(|alpha| alpha < NARROW)
}

/// BSDF that VPLs are summed with, if any are.
pub(super) fn summed_with(point: &GatherPoint, estimator: Estimator) -> Bsdf {
    if estimator == Estimator::Vpls && is_near_specular(&point.bsdf) {
        Bsdf::Lambert(Lambert { reflectance: point.bsdf.vpl_reflectance(point.wo) })
    } else {
        point.bsdf
    }
}

/// The gather points of an estimate, with their camera samples.
pub(super) struct Points {
    pub pixel: PixelSum,
    /// True if emission that the camera sees is averaged over all camera samples of the estimate,
    /// those of paths included. False if it is averaged only over the camera samples of the gather
    /// points, which are spread evenly.
    is_emission_rare: bool,
    /// Tree of the points as they are summed: without narrow lobes.
    tree: GatherTree<UpperScattering<UpperAnalytic>>,
    /// Indices of the camera samples, sorted along a Hilbert curve over the pixel.
    by_place: Vec<u32>,
}

impl Points {
    /// Draws `samples` camera samples by the random numbers of `key`. Narrow lobes are left to
    /// paths only where paths add the light that VPLs do not carry.
    pub(super) fn new(
        common: &Common<'_>,
        pixel: [u32; 2],
        samples: u32,
        is_emission_rare: bool,
        key: u64,
    ) -> Self {
        let pixel = common.samples(pixel, samples, key);
        let as_summed = |p: &GatherPoint| {
            if common.compensates { GatherPoint { bsdf: summed_with(p, Estimator::Vpls), ..*p } } else { *p }
        };
        let summed: Vec<GatherPoint> = pixel.points.iter().map(as_summed).collect();
        let tree = gather_tree::<UpperAnalytic>(&summed);
        let mut by_place: Vec<u32> = (0..pixel.samples.len() as u32).collect();
        by_place.sort_by_cached_key(|k| along_curve(pixel.samples[*k as usize].place));
        Self { pixel, is_emission_rare, tree, by_place }
    }

    /// Approximate luminance of unsampled light on specular paths (W·m⁻²·sr⁻¹). Zero where the
    /// camera sees no surface that gathers light, whatever the neighbourhood sees.
    pub(super) fn not_found(&self, common: &Common<'_>, nearby: &Nearby) -> f64 {
        if self.pixel.points.is_empty() {
            return 0.0;
        }
        let Some((caustics, (share, beyond))) = common.lights.caustics().zip(nearby.not_found()) else {
            return 0.0;
        };
        let of_point = |p: &GatherPoint| {
            f64::from(p.weight.luminance()) * caustics.importance_radiance(p.position, p.geometric_normal)
        };
        share * (self.pixel.points.iter().map(of_point).sum::<f64>() + beyond)
    }

    /// Returns true if a point mirrors too sharply for VPLs.
    pub(super) fn are_narrow(&self) -> bool {
        self.pixel.points.iter().any(|point| is_near_specular(&point.bsdf))
    }
}

/// Index of the cell of a place in the unit square along a Hilbert curve. Consecutive cells are
/// adjacent.
fn along_curve(place: [f32; 2]) -> u32 {
    const SIDE: u32 = 256;
    let [mut x, mut y] = place.map(|v| (v * SIDE as f32) as u32);
    let (mut along, mut side) = (0, SIDE / 2);
    while side > 0 {
        let [right, upper] = [x, y].map(|v| u32::from(v & side > 0));
        along += side * side * ((3 * right) ^ upper);
        // Each quarter holds a smaller curve, in the lower quarters reflected about a diagonal.
        if upper == 0 {
            if right == 1 {
                (x, y) = (SIDE - 1 - x, SIDE - 1 - y);
            }
            (x, y) = (y, x);
        }
        side /= 2;
    }
    along
}

/// Errors due to the choice of VPLs and camera samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ByDraws {
    /// `V_lights`.
    pub lights: f64,
    /// `V_lights²/ν_lights = Σ_p T_p⁴/2`, for groups `p` of VPLs that are drawn together, with the
    /// total contribution `T_p`.
    pub square_of_lights: f64,
    /// Largest contribution of such a group.
    pub largest_of_lights: f64,
    /// `V_points`.
    pub points: f64,
}

/// An estimate of a pixel, which grows.
pub(super) struct Estimate<'a> {
    common: Common<'a>,
    pixel: [u32; 2],
    key: u64,
    /// Gather points, if there are VPLs.
    points: Option<&'a Points>,
    cut: Option<InheritedCut<'a, UpperAnalytic>>,
    compensation: Compensation<'a>,
    /// Sum of the radiances of paths.
    of_paths: RgbSum,
    paths: u32,
    /// Number of paths whose camera sample reached a gather point.
    met: u32,
    /// Moments of single paths, by part of the error metric.
    moments: [Moments; Controlled::MOST_PARTS],
    /// Emission seen by all camera samples, those at which paths begin included; `None` unless
    /// [`Points`] counts such emission as rare.
    rare_emission: Option<RareEmission>,
    camera_rays: u64,
    /// Approximate luminance of surfaces that no camera sample met.
    importance_unmet: f64,
}

/// Emission seen by camera samples.
#[derive(Clone, Copy, Debug, Default)]
struct RareEmission {
    sum: RgbSum,
    /// Moments of single samples, by part of the error metric.
    moments: [Moments; Controlled::MOST_PARTS],
}

impl RareEmission {
    /// Adds the emission seen by camera samples of the pixel.
    fn add(&mut self, seen: &PixelSum, controlled: Controlled) {
        let count = seen.samples.len() as f32;
        for sample in &seen.samples {
            let emission = sample.background * count;
            self.sum.add(emission);
            for (part, moments) in controlled.parts().iter().zip(&mut self.moments) {
                moments.push(part.of(emission));
            }
        }
    }
}

impl<'a> Estimate<'a> {
    /// Estimate by a sum over VPLs and compensation paths. Only the first pair is drawn so far.
    pub(super) fn of_vpls(
        common: Common<'a>,
        prior: VisibilityPrior<'a>,
        points: &'a Points,
        clamp_distance: f32,
        pixel: [u32; 2],
        key: u64,
        memory: &'a mut CutMemory,
    ) -> Self {
        let lit = common.lit(Estimator::Vpls, clamp_distance);
        let contribution = lit.contribution;
        let clusters = Clusters { lights: common.lights.tree(), points: &points.tree, contribution };
        let samples = Stream::new(key, Purpose::Cut, 0);
        let (controlled, tracer) = (common.controlled, common.setting.tracer);
        let options = StrataOptions { inherits: true, tabulates: true, corrects: true, controlled, prior };
        let cut = InheritedCut::new(clusters, Rank::Deviation(prior), options, tracer, samples, memory);
        let camera_rays = points.pixel.samples.len() as u64;
        let mut rare_emission = points.is_emission_rare.then(RareEmission::default);
        if let Some(emission) = &mut rare_emission {
            emission.add(&points.pixel, common.controlled);
        }
        Self { points: Some(points), cut, rare_emission, camera_rays, ..Self::new(common, lit, pixel, key) }
    }

    /// Estimate by full paths, none of which are drawn yet.
    pub(super) fn of_paths(common: Common<'a>, pixel: [u32; 2], key: u64) -> Self {
        Self::new(common, common.lit(Estimator::Paths, 0.0), pixel, key)
    }

    fn new(common: Common<'a>, lit: LightingContext<'a>, pixel: [u32; 2], key: u64) -> Self {
        Self {
            common,
            pixel,
            key,
            points: None,
            cut: None,
            compensation: Compensation::new(lit),
            of_paths: RgbSum::default(),
            paths: 0,
            met: 0,
            moments: [Moments::default(); Controlled::MOST_PARTS],
            rare_emission: None,
            camera_rays: 0,
            importance_unmet: 0.0,
        }
    }

    /// Refines the cut to `pairs` pairs, and follows paths until there are `paths`.
    pub(super) fn grow(&mut self, pairs: u64, paths: u32) {
        if let Some(cut) = &mut self.cut {
            cut.grow(pairs);
        }
        if self.common.compensates {
            self.follow(paths);
        }
    }

    /// Follows paths, each from a new camera sample. Paths from the gather points of the sum would
    /// not show the variance due to the choice of these points.
    fn follow(&mut self, paths: u32) {
        let estimator = if self.points.is_some() { Estimator::Vpls } else { Estimator::Paths };
        while self.paths < paths {
            let samples = (paths - self.paths).min(POINTS_AT_ONCE);
            let key = rng::key(self.key, Purpose::Compensation, self.paths.into());
            let seen = self.common.samples(self.pixel, samples, key);
            self.camera_rays += u64::from(samples);
            if let Some(emission) = &mut self.rare_emission {
                emission.add(&seen, self.common.controlled);
            }
            for (number, sample) in seen.samples.iter().enumerate() {
                let mut value = if estimator == Estimator::Paths { sample.background } else { Rgb::BLACK };
                if let Some(point) = sample.point.map(|k| &seen.points[k as usize]) {
                    self.met += 1;
                    let number = number as u64;
                    let mut stream = Stream::new(key, Purpose::Compensation, number);
                    let key = rng::key(key, Purpose::Opacity, number);
                    let summed = summed_with(point, estimator);
                    value += self.compensation.estimate(point, &summed, key, &mut stream);
                }
                self.tell(value * samples as f32);
            }
            self.paths += samples;
        }
    }

    fn tell(&mut self, value: Rgb) {
        self.of_paths.add(value);
        for (part, moments) in self.common.controlled.parts().iter().zip(&mut self.moments) {
            moments.push(part.of(value));
        }
    }

    /// Estimate of the sum over VPLs.
    pub(super) fn gathered(&self) -> RgbSum {
        self.cut.as_ref().map_or_else(RgbSum::default, InheritedCut::estimate)
    }

    /// Mean of the paths.
    pub(super) fn by_paths(&self) -> RgbSum {
        self.of_paths.scaled(1.0 / f64::from(self.paths.max(1)))
    }

    /// Estimate of the truth.
    pub(super) fn value(&self) -> RgbSum {
        let mut value = self.gathered();
        if let Some(emission) = &self.rare_emission {
            value.merge(&emission.sum.scaled(1.0 / emission.moments[0].count() as f64));
        } else if let Some(points) = self.points {
            value.add(points.pixel.background);
        }
        value.merge(&self.by_paths());
        value
    }

    /// Spread of the sum over VPLs, by its strata, for a part of the error metric.
    ///
    /// * `gathered`: the estimate of the sum, which gives the ratio of the part to the luminance.
    pub(super) fn spread(&self, part: usize, gathered: &RgbSum) -> Spread {
        self.cut.as_ref().map_or_else(Spread::default, |cut| cut.spread(part, gathered))
    }

    /// Approximate errors due to the choice of VPLs and of camera samples.
    ///
    /// Samples are spread evenly over the pixel. Two neighbouring samples are treated as
    /// independent draws from one region. Their sum then has the variance `E (v_a − v_b)²`.
    /// Neighbours are consecutive samples along a Hilbert curve (successive differences, Wolter
    /// 2007, section 8.2). If a pixel has bright and dark samples, some of its neighbours differ.
    ///
    /// * `tolerance`: errors below a small share of it need not be estimated precisely.
    pub(super) fn by_draws(&self, part: usize, tolerance: f64) -> ByDraws {
        let Some(points) = self.points else { return ByDraws::default() };
        let of = &self.common.controlled.parts()[part];
        let lights = self.common.lights;
        let k = lights.importance_correlation();
        let small = SMALL * tolerance;
        let of_cut = |cut: &InheritedCut<'_, _>| {
            cut.population(part, |light| lights.is_given(light), small * small / k)
        };
        let population = self.cut.as_ref().map(of_cut);
        let population = population.unwrap_or_default();
        let mut by_point = vec![Default::default(); points.pixel.points.len()];
        for (sorted, of_point) in (0..).zip(&population.points) {
            by_point[points.tree.source(sorted) as usize] = *of_point;
        }
        let of_sample = |k: &u32| {
            let sample = &points.pixel.samples[*k as usize];
            let mut gathered = sample.point.map(|k| by_point[k as usize]).unwrap_or_default();
            if self.rare_emission.is_none() {
                gathered.value += of.of(sample.background);
            }
            gathered
        };
        let mut by_samples = 0.0;
        for next_to in points.by_place.windows(2) {
            let [a, b] = [of_sample(&next_to[0]), of_sample(&next_to[1])];
            let difference = a.value - b.value;
            by_samples += difference * difference - a.noise - b.noise;
        }
        let samples = points.by_place.len() as f64;
        by_samples *= 0.5 * samples / f64::max(samples - 1.0, 1.0);
        // The powers of `K` hold for groups of `K` VPLs that are drawn together and contribute
        // equally.
        ByDraws {
            lights: k * population.importance_by_lights,
            square_of_lights: 0.5 * k * k * k * population.importance_fourth,
            largest_of_lights: k * population.importance_largest,
            points: f64::max(by_samples, 0.0),
        }
    }

    /// Moments of single paths, by part of the error metric.
    pub(super) fn moments(&self) -> &[Moments] {
        &self.moments[..self.common.controlled.parts().len()]
    }

    /// Moments of the emission seen by single camera samples, by part of the error metric; `None`
    /// unless such emission is rare.
    pub(super) fn rare_emission(&self) -> Option<&[Moments]> {
        self.rare_emission.as_ref().map(|emission| &emission.moments[..self.common.controlled.parts().len()])
    }

    /// Returns true if the estimate is a sum over gather points, whose number of camera samples is
    /// fixed.
    pub(super) fn has_points(&self) -> bool {
        self.points.is_some()
    }

    pub(super) fn paths(&self) -> u32 {
        self.paths
    }

    pub(super) fn pairs(&self) -> u64 {
        self.cut.as_ref().map_or(0, InheritedCut::pairs)
    }

    /// Returns true if refining the sum gains nothing.
    pub(super) fn is_whole(&self) -> bool {
        self.cut.as_ref().is_none_or(InheritedCut::is_whole)
    }

    /// Sets the luminance of surfaces that may be in the pixel though no camera sample met one
    /// (W·m⁻²·sr⁻¹).
    pub(super) fn expect_unmet(&mut self, importance_luminance: f64) {
        self.importance_unmet = importance_luminance;
    }

    /// Approximate bound, with probability `1 − δ`, on the error due to surfaces that no camera
    /// sample met.
    ///
    /// The probability that `n` samples all miss a surface that covers the share `c` of the pixel
    /// is `(1 − c)ⁿ`. It is below `δ` if `c ≥ ln(1/δ) / n`. For a sum over VPLs, `n` counts the
    /// camera samples of the gather points.
    pub(super) fn unmet(&self, part: usize, delta: f64) -> f64 {
        if self.importance_unmet == 0.0 || self.samples_meet_surface() {
            return 0.0;
        }
        let of_surface = self.common.controlled.parts()[part].of(Rgb::gray(self.importance_unmet as f32));
        let samples = self.points.map_or(self.camera_rays, |points| points.pixel.samples.len() as u64);
        of_surface * ln_f64(delta.recip()) / samples.max(1) as f64
    }

    /// Returns true if any of the camera samples that [`unmet`](Self::unmet) counts met a surface.
    pub(super) fn samples_meet_surface(&self) -> bool {
        self.points.map_or(self.met > 0, |points| !points.pixel.points.is_empty())
    }

    /// Returns true if any camera sample met a surface that gathers light.
    pub(super) fn meets_surfaces(&self) -> bool {
        self.met > 0 || self.points.is_some_and(|points| !points.pixel.points.is_empty())
    }

    /// Mean number of rays of a path.
    pub(super) fn rays_per_path(&self) -> f64 {
        1.0 + self.compensation.rays() as f64 / f64::from(self.paths.max(1))
    }

    pub(super) fn rays(&self) -> u64 {
        self.camera_rays + self.compensation.rays() + self.cut.as_ref().map_or(0, InheritedCut::segments)
    }
}

#[cfg(test)]
mod tests {
    use super::along_curve;

    /// All cells of the square are sorted by their index on the curve. Consecutive cells share an
    /// edge.
    #[test]
    fn steps_along_the_curve_lead_to_the_next_cell() {
        let place = |cell: u32| [(cell % 256) as f32 / 256.0, (cell / 256) as f32 / 256.0];
        let mut cells: Vec<u32> = (0..256 * 256).collect();
        cells.sort_by_key(|cell| along_curve(place(*cell)));
        for step in cells.windows(2) {
            let [a, b] = [0, 1].map(|k| [step[k] % 256, step[k] / 256]);
            assert_eq!(a[0].abs_diff(b[0]) + a[1].abs_diff(b[1]), 1, "{a:?} {b:?}");
        }
    }
}
