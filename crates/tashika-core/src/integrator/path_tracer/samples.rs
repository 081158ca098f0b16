//! Whole paths for pictures that are reconstructed.
//!
//! Camera samples are those of the [view](View::beginning) under another seed, spread evenly over
//! the pixel. After the camera ray, each path has its own stream of random numbers. The features of
//! first surfaces are means over the first few samples.

use super::path::Start;
use super::{OF_FEATURES, PathTracer};
use crate::film::Window;
use crate::gather::{FeatureSums, View};
use crate::integrator::{PathSampler, PathSamples, Setting};
use crate::rng::{self, Purpose, Stream};
use crate::stats::Moments;

/// Paths from which the brightness of a view is estimated.
const OF_BRIGHTNESS: u64 = 4096;

/// A sampler of paths for the pixels of one view.
struct PathTracerSampler<'v> {
    method: &'v PathTracer<'v>,
    setting: Setting<'v>,
}

impl PathTracer<'_> {
    /// Returns a sampler of paths for this view.
    pub fn path_sampler<'v>(&'v self, setting: Setting<'v>) -> impl PathSampler + use<'v> {
        PathTracerSampler { method: self, setting }
    }

    /// Approximate mean luminance of a view (W·m⁻²·sr⁻¹), from paths that no estimate uses.
    pub fn importance_brightness(&self, setting: &Setting<'_>) -> f64 {
        let View { size, seed, .. } = setting.view;
        let mut stream = Stream::new(seed, Purpose::Guidance, 0);
        let mut tracing = self.tracing(setting);
        let moves = tracing.moves;
        let starts = (0..OF_BRIGHTNESS).map(|number| {
            let pixel = setting.view.random_pixel(&Window::full(size), &mut stream);
            let key = rng::key(seed, Purpose::Guidance, 1 + number);
            Start::random(&setting.view, pixel, key, moves)
        });
        let mut luminance = Moments::default();
        tracing.follow(starts, |found| luminance.push(found.radiance.luminance().into()));
        luminance.mean()
    }
}

/// Random numbers of the paths of one pixel.
struct OfPixel {
    pixel: [u32; 2],
    count: u32,
    key: u64,
    /// Seed of the camera samples.
    of_samples: u64,
}

impl PathSampler for PathTracerSampler<'_> {
    fn setting(&self) -> &Setting<'_> {
        &self.setting
    }

    fn tile(&self, tile: &Window, seed: u64, count: &dyn Fn([u32; 2]) -> u32) -> Vec<PathSamples> {
        let Setting { tracer, view } = &self.setting;
        let mut tracing = self.method.tracing(&self.setting);
        let moves = tracing.moves;
        let of_pixel = |(x, y): (u32, u32)| {
            let number = u64::from(y) << 32 | u64::from(x);
            let key = rng::key(seed, Purpose::Picture, number);
            let of_samples = rng::key(key, Purpose::Gather, 0);
            OfPixel { pixel: [x, y], count: count([x, y]), key, of_samples }
        };
        let pixels: Vec<_> = tile.pixels().map(of_pixel).collect();
        let starts = pixels.iter().flat_map(|&OfPixel { pixel, count, key, of_samples }| {
            let view = View { seed: of_samples, ..*view };
            (0..count).map(move |index| Start::even(&view, pixel, index, key, moves))
        });
        let has_media = tracing.has_media;
        let of_features = |count: u32| FeatureSums::new(count.min(OF_FEATURES));
        let mut samples: Vec<_> =
            pixels.iter().map(|p| (PathSamples::default(), of_features(p.count))).collect();
        let mut of_paths = pixels.iter().zip(0..).flat_map(|(p, number)| (0..p.count).map(move |_| number));
        tracing.follow(starts, |found| {
            let number: usize = of_paths.next().expect("a path of a pixel");
            let (of_pixel, features) = &mut samples[number];
            of_pixel.sum.add(found.radiance);
            of_pixel.luminance.push(found.radiance.luminance().into());
            of_pixel.rays += found.rays;
            if features.missing() > 0 {
                features.add(found.first.as_ref(), found.albedo);
            }
        });
        let finish = |((mut of_pixel, features), pixel): ((PathSamples, FeatureSums), &OfPixel)| {
            of_pixel.features = features.mean();
            let few = pixel.count.min(OF_FEATURES);
            if has_media && few > 0 {
                of_pixel.features = view.features(tracer, pixel.pixel, few, pixel.of_samples);
                of_pixel.rays += u64::from(few);
            }
            of_pixel
        };
        samples.into_iter().zip(&pixels).map(finish).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::Tracer;
    use crate::gather::GatherOptions;
    use crate::integrator::{Integrator, PathStop};
    use crate::scene::builtin;

    const SIZE: [u32; 2] = [16, 12];

    fn with_paths(work: impl FnOnce(&PathTracer<'_>, Setting<'_>)) {
        let tracer = Tracer::new(Arc::new(builtin::tiny()));
        let view = View {
            camera: &tracer.scene().cameras()[0],
            size: SIZE,
            gather: GatherOptions::default(),
            seed: 1,
        };
        let method = PathTracer::new(&tracer, PathStop::Count(4096), 16).unwrap();
        work(&method, Setting { tracer: &tracer, view });
    }

    /// The mean over an image agrees with the image of the integrator, and so does the estimated
    /// brightness.
    #[test]
    fn the_mean_is_that_of_the_integrator() {
        with_paths(|method, setting| {
            let window = Window::full(SIZE);
            let area = window.area() as f64;
            let truth = method.estimate(&setting, &window);
            let of_truth = truth.iter().map(|p| f64::from(p.radiance.luminance())).sum::<f64>() / area;
            let sampler = method.path_sampler(setting);
            let mut means = Moments::default();
            for seed in 1..=8 {
                let found = sampler.tile(&window, seed, &|_| 128);
                assert!(found.iter().all(|pixel| pixel.rays >= 128));
                let covered = found.iter().filter(|pixel| pixel.features.coverage > 0.9).count();
                assert!(covered > found.len() / 2, "{covered}");
                means.push(found.iter().map(|pixel| pixel.luminance.mean()).sum::<f64>() / area);
            }
            let error = means.standard_error();
            assert!(error < 0.01 * of_truth, "{error} of {of_truth}");
            let off = (means.mean() - of_truth).abs();
            assert!(off < 4.0 * error + 0.003 * of_truth, "{} for {of_truth}", means.mean());
            let brightness = method.importance_brightness(&setting);
            assert!((brightness / of_truth - 1.0).abs() < 0.15, "{brightness} for {of_truth}");
        });
    }

    /// Sampling a part of a tile returns the same pixels as sampling the whole tile. A pixel whose
    /// count is zero has no paths.
    #[test]
    fn tiles_do_not_enter() {
        with_paths(|method, setting| {
            let sampler = method.path_sampler(setting);
            let count = |[x, y]: [u32; 2]| (x + y) % 4;
            let (whole, part) = (Window::full(SIZE), Window { x: 5, y: 3, width: 4, height: 5 });
            let of_whole = sampler.tile(&whole, 7, &count);
            for ((x, y), of_part) in part.pixels().zip(sampler.tile(&part, 7, &count)) {
                let pixel = &of_whole[whole.index(x, y)];
                assert_eq!(pixel.luminance, of_part.luminance);
                assert_eq!(pixel.luminance.count(), u64::from(count([x, y])));
            }
        });
    }
}
