//! Paths of light transport that draw VPLs. The caller sets the number of paths of each pixel.
//!
//! Each path begins at its own gather point. There and at each later surface, emitters and VPLs are
//! drawn by learned probabilities ([`Choices`](crate::compensation::Choices)): a few at the first
//! surface, one of each at later surfaces. VPLs represent all light that diffuse surfaces reflect;
//! the path estimates the rest. Most paths are therefore short, and no pixel needs a cut.
//!
//! The [clamp distance](CLAMP) is longer than that of sums over VPLs. This reduces the variance
//! from set to set, and hardly changes the variance of single paths.
//!
//! # Guarantee
//! The mean of a pixel is unbiased over sets of VPLs, as that of
//! [`LightTransport`](super::LightTransport) is. `paths::tests` check the mean and the estimated
//! variance over sets; the suite's `hard_light` checks the estimate of unsampled light.

use super::estimate::{Common, Estimator, summed_with};
use super::nearby::{MIN_SAMPLED_SHARE, PATHS};
use super::{LightTransport, Truth};
use crate::color::Controlled;
use crate::compensation::{Compensation, Draws, Numbers};
use crate::film::Window;
use crate::integrator::{PathSampler, PathSamples, Setting};
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;

/// Numbers of lights drawn at a gather point. Together they cost about as much as the path. Chosen.
const DRAWS: Draws = Draws { emitters: 2, vpls: 4 };

/// Index of the clamp distance. A quarter of that distance raises the standard deviation over sets
/// from 1.2 to 3.0 % (Cornell box) and from 1.6 to 2.5 % (room) in the hardest quarter of the
/// pixels; with four times that distance, paths vary by half as much again.
const CLAMP: usize = 1;

/// A sampler of paths for the pixels of one view.
struct LightTransportSampler<'v> {
    method: &'v LightTransport<'v>,
    setting: Setting<'v>,
}

impl LightTransport<'_> {
    /// Returns a sampler of paths for this view, with these lights.
    pub fn path_sampler<'v>(&'v self, setting: Setting<'v>) -> impl PathSampler + use<'v> {
        LightTransportSampler { method: self, setting }
    }
}

impl PathSampler for LightTransportSampler<'_> {
    fn setting(&self) -> &Setting<'_> {
        &self.setting
    }

    fn tile(&self, tile: &Window, seed: u64, count: &dyn Fn([u32; 2]) -> u32) -> Vec<PathSamples> {
        let common = Common {
            setting: &self.setting,
            emitters: &self.method.emitters,
            lights: self.method.lights,
            compensates: self.method.lights.truth() == Truth::Transport,
            controlled: Controlled::Luminance,
        };
        let mut compensation =
            Compensation::new(common.lit(Estimator::Vpls, self.method.clamp_distance(CLAMP)));
        let of_pixel = |(x, y)| pixel(&common, &mut compensation, [x, y], seed, count([x, y]));
        tile.pixels().map(of_pixel).collect()
    }

    fn telling(&self) -> u32 {
        if self.method.lights.caustics().is_some() { PATHS as u32 } else { 1 }
    }
}

fn pixel(
    common: &Common<'_>,
    compensation: &mut Compensation<'_>,
    pixel: [u32; 2],
    seed: u64,
    count: u32,
) -> PathSamples {
    if count == 0 {
        return PathSamples::default();
    }
    let number = u64::from(pixel[1]) << 32 | u64::from(pixel[0]);
    let key = rng::key(seed, Purpose::Picture, number);
    let seen = common.samples(pixel, count, key);
    let (before, whole) = (compensation.rays(), f64::from(count));
    let (mut caustic, mut expected, mut squares) = (Moments::default(), 0.0, 0.0);
    let mut found = PathSamples { features: seen.features, ..PathSamples::default() };
    for (number, sample) in (0..).zip(&seen.samples) {
        let (mut value, mut found_caustic) = (sample.background, 0.0);
        if let Some(point) = sample.point.map(|k| &seen.points[k as usize]) {
            let mut stream = Stream::new(key, Purpose::Picture, number);
            let of_rays = rng::key(key, Purpose::Opacity, number);
            let by_vpls = summed_with(point, Estimator::Vpls);
            let numbers = Numbers::new(number as u32, key);
            value += compensation.whole(point, &by_vpls, DRAWS, numbers, of_rays, &mut stream);
            squares += whole * whole * compensation.squares_of_vpls();
            found_caustic = whole * compensation.caustic().found;
            expected += compensation.caustic().expected.iter().sum::<f64>();
        }
        caustic.push(found_caustic);
        let value = value * count as f32;
        found.sum.add(value);
        found.luminance.push(value.luminance().into());
    }
    found.rays = u64::from(count) + compensation.rays() - before;
    found.importance_of_set = common.lights.importance_correlation() * squares;
    let is_found = caustic.mean() + 2.0 * caustic.standard_error() >= MIN_SAMPLED_SHARE * expected;
    let not_found = if is_found { 0.0 } else { expected - caustic.mean() };
    found.importance_not_found = whole * (not_found + common.unsampled_emission(pixel, &seen));
    found
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use crate::accel::Tracer;
    use crate::film::Window;
    use crate::gather::{GatherOptions, View};
    use crate::integrator::{
        ControlOptions, GuidedLights, Integrator, LightTransport, PathSampler, PathStop, PathTracer, Setting,
    };
    use crate::scene::builtin;
    use crate::stats::Moments;
    use crate::vpl::{Clamp, VplOptions};

    /// The mean over an image, averaged over eight seeds of the lights, agrees with the path
    /// tracer. Half of the light is indirect, so that the test would fail without it.
    #[test]
    fn the_mean_is_that_of_the_path_tracer() {
        let tracer = Tracer::new(Arc::new(builtin::tiny()));
        let size = [16, 12];
        let view = |seed| View {
            camera: &tracer.scene().cameras()[0],
            size,
            gather: GatherOptions::default(),
            seed,
        };
        let window = Window::full(size);
        let setting = Setting { tracer: &tracer, view: view(1) };
        let truth = PathTracer::new(&tracer, PathStop::Count(4096), 16).unwrap();
        let truth = truth.estimate(&setting, &window);
        let of_truth: f64 = truth.iter().map(|pixel| f64::from(pixel.radiance.luminance())).sum();
        let mut sums = Moments::default();
        for seed in 1..=8 {
            let options = VplOptions { count: 20_000, seed, ..VplOptions::default() };
            let lights = GuidedLights::to_draw(&tracer, &options, &view(seed)).unwrap();
            let method = LightTransport::new(&tracer, &lights, &ControlOptions::default());
            let sampler = method.path_sampler(Setting { tracer: &tracer, view: view(seed) });
            let found = sampler.tile(&window, seed, &|_| 256);
            sums.push(found.iter().map(|pixel| pixel.luminance.mean()).sum());
        }
        let error = sums.standard_error();
        assert!(error < 0.01 * of_truth, "{error} of {of_truth}");
        assert!(
            (sums.mean() - of_truth).abs() < 4.0 * error + 0.003 * of_truth,
            "{} for {of_truth}",
            sums.mean()
        );
    }

    /// The variance from set to set, which paths by one set do not show, agrees with its estimate.
    #[test]
    fn how_light_varies_by_sets_is_told() {
        const SETS: u64 = 24;
        const PATHS: u32 = 1024;
        let tracer = Tracer::new(Arc::new(builtin::tiny()));
        // Small pixels: the estimate is for one gather point.
        let size = [256, 192];
        let at = |(x, y): (u32, u32)| Window { x: 32 + 64 * x, y: 32 + 64 * y, width: 1, height: 1 };
        let windows: Vec<Window> = (0..12).map(|k| at((k % 4, k / 4))).collect();
        let gather = GatherOptions::default();
        let view = |seed| View { camera: &tracer.scene().cameras()[0], size, gather, seed };
        let setting = Setting { tracer: &tracer, view: view(1) };
        let mut by_sets = vec![Moments::default(); 12];
        let (mut told, mut of_paths) = (vec![0.0; 12], vec![0.0; 12]);
        for seed in 1..=SETS {
            let options =
                VplOptions { count: 500, clamp: Clamp::Distance(0.01), seed, ..VplOptions::default() };
            let lights = GuidedLights::to_audit(&tracer, &options, &view(seed)).unwrap();
            let method = LightTransport::new(&tracer, &lights, &ControlOptions::default());
            let sampler = method.path_sampler(setting);
            for (k, window) in windows.iter().enumerate() {
                let found = &sampler.tile(window, seed, &|_| PATHS)[0];
                by_sets[k].push(found.luminance.mean());
                told[k] += found.importance_of_set / f64::from(PATHS) / SETS as f64;
                of_paths[k] += found.luminance.variance() / f64::from(PATHS) / SETS as f64;
            }
        }
        // Pixels in which the variance over sets is at least twice that of the mean of paths.
        let clear: Vec<usize> = (0..12).filter(|k| told[*k] > 2.0 * of_paths[*k]).collect();
        assert!(clear.len() >= 4, "{told:?} {of_paths:?}");
        let ratio = |k: &usize| (by_sets[*k].variance() - of_paths[*k]) / told[*k];
        let mean = clear.iter().map(ratio).sum::<f64>() / clear.len() as f64;
        // The values of the pixels are correlated, so that the mean ratio is no more precise than a
        // variance of 24 values: to a third at best.
        assert!((0.4..1.6).contains(&mean), "{mean}");
    }

    /// Sampling a part of a tile returns the same pixels as sampling the whole tile. A pixel whose
    /// count is zero has no paths.
    #[test]
    fn tiles_do_not_enter() {
        let tracer = Tracer::new(Arc::new(builtin::tiny()));
        let size = [16, 12];
        let view =
            View { camera: &tracer.scene().cameras()[0], size, gather: GatherOptions::default(), seed: 1 };
        let options = VplOptions { count: 2000, ..VplOptions::default() };
        let lights = GuidedLights::to_draw(&tracer, &options, &view).unwrap();
        let method = LightTransport::new(&tracer, &lights, &ControlOptions::default());
        let sampler = method.path_sampler(Setting { tracer: &tracer, view });
        let count = |[x, y]: [u32; 2]| (x + y) % 4;
        let (whole, part) = (Window::full(size), Window { x: 5, y: 3, width: 4, height: 5 });
        let of_whole = sampler.tile(&whole, 7, &count);
        for ((x, y), of_part) in part.pixels().zip(sampler.tile(&part, 7, &count)) {
            let pixel = &of_whole[whole.index(x, y)];
            assert_eq!(pixel.luminance, of_part.luminance);
            assert_eq!(pixel.luminance.count(), u64::from(count([x, y])));
        }
    }
}
