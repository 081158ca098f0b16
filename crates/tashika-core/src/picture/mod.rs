//! A picture made in passes and reconstructed. Each pass spends more paths where the error is
//! predicted to be large.
//!
//! ```text
//! pass 0: n₀ paths of each pixel       pass r: g times as many as all before, by (e/t)²       t = max(ε L, ε_abs)
//! ```
//!
//! The paths of every pixel are divided into two independent halves. From the halves, the picture
//! is [reconstructed](Halves) and its error `e` is predicted. A tenth of the paths of a pass is
//! spread evenly over the pixels, so that errors that were not predicted are found as well.
//!
//! # Guarantee
//! A picture claims nothing about its error. It is a function of the view, the lights, the seed and
//! the number of passes. It does not depend on threads or tiles.

mod single;

pub use single::{Wanted, paths_of};

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::color::{Rgb, RgbSum};
use crate::error::Result;
use crate::film::{Film, PixelRecord, Stop, Window};
use crate::gather::Features;
use crate::integrator::{PathSampler, PathSamples};
use crate::reconstruction::{Halves, LEAST_SIZE, Reconstructed, Smoother};
use crate::rng::{self, Purpose};
use crate::stats::Moments;

/// Paths of each half of a pixel in the first pass: the fewest that have a variance, so that a
/// picture is soon visible, and a time limit is soon met.
const FIRST: u32 = 2;
/// Share of the paths of a later pass that is spread evenly.
const UNIFORM_SHARE: f64 = 0.1;
/// Most paths of a pixel in a pass, as a multiple of the mean.
const MOST: f64 = 32.0;
/// Largest predicted error, over the tolerance of the pixel.
const LARGEST: f64 = 8.0;
/// Side of the tiles that threads take (pixels).
const TILE: u32 = 16;
/// Radius of the neighbourhood from which the variance of a pixel's paths is estimated (pixels).
/// Chosen.
const RADIUS: u32 = 8;

/// Accumulated paths of one half of a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Half {
    sum: RgbSum,
    luminance: Moments,
}

/// Accumulated paths of a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    halves: [Half; 2],
    /// Means over the paths of both halves.
    features: Features,
    rays: u64,
}

impl Pixel {
    fn paths(&self) -> u64 {
        self.halves.iter().map(|half| half.luminance.count()).sum()
    }

    fn add(&mut self, half: usize, found: &PathSamples) {
        let count = found.luminance.count();
        if count == 0 {
            return;
        }
        let before = self.paths() as f32;
        let share = count as f32 / (before + count as f32);
        let (features, new) = (&mut self.features, &found.features);
        // Depth and normal are means over the paths that met a surface.
        let [met, new_met] = [before * features.coverage, count as f32 * new.coverage];
        let share_of_met = if new_met > 0.0 { new_met / (met + new_met) } else { 0.0 };
        features.depth += (new.depth - features.depth) * share_of_met;
        features.normal += (new.normal - features.normal) * share_of_met;
        features.albedo = features.albedo.lerp(new.albedo, share);
        features.coverage += (new.coverage - features.coverage) * share;
        self.rays += found.rays;
        self.halves[half].sum.merge(&found.sum);
        self.halves[half].luminance.merge(&found.luminance);
    }

    /// Record of the given halves.
    fn record(&self, halves: &[Half]) -> PixelRecord {
        let (mut sum, mut luminance) = (RgbSum::default(), Moments::default());
        for half in halves {
            sum.merge(&half.sum);
            luminance.merge(&half.luminance);
        }
        let count = luminance.count();
        PixelRecord {
            radiance: sum.scaled(1.0 / count.max(1) as f64).total(),
            standard_error: luminance.standard_error() as f32,
            stop: if count > 0 { Stop::SampleCount } else { Stop::NotRendered },
            pairs: count,
            rays: self.rays,
            ..self.features.into()
        }
    }
}

/// A picture in progress, with its paths so far.
pub struct Picture<'v> {
    sampler: Box<dyn PathSampler + 'v>,
    window: Window,
    pixels: Vec<Pixel>,
    /// Mean luminances of the halves of each pixel, from the last pass alone.
    last: Vec<[f64; 2]>,
    passes: u32,
    seed: u64,
}

impl<'v> Picture<'v> {
    /// Returns a picture of this window before its first pass.
    pub fn new(sampler: impl PathSampler + 'v, window: Window, seed: u64) -> Self {
        let pixels = vec![Pixel::default(); window.area() as usize];
        let sampler = Box::new(sampler);
        Self { sampler, window, last: vec![[0.0; 2]; pixels.len()], pixels, passes: 0, seed }
    }

    /// Part of the image that the picture covers.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Number of passes so far.
    pub fn passes(&self) -> u32 {
        self.passes
    }

    /// Number of paths so far, of all pixels.
    pub fn paths(&self) -> u64 {
        self.pixels.iter().map(Pixel::paths).sum()
    }

    /// Number of rays so far, of all pixels.
    pub fn rays(&self) -> u64 {
        self.pixels.iter().map(|pixel| pixel.rays).sum()
    }

    /// Makes one more pass. Returns false, with nothing changed, if cancelled. Runs on the current
    /// thread pool.
    ///
    /// * `importance`: predicted error of each pixel over its tolerance; `None` for the first pass.
    /// * `growth`: paths of this pass, over the paths so far: 1 doubles the work.
    pub fn pass(&mut self, importance: Option<&[f32]>, growth: f64, cancel: &AtomicBool) -> bool {
        let counts = match importance {
            None => vec![FIRST; self.pixels.len()],
            Some(importance) => self.spread(importance, growth),
        };
        let (window, pass) = (self.window, u64::from(self.passes));
        let seeds = [0, 1].map(|half| rng::key(self.seed, Purpose::Picture, 2 * pass + half));
        let tiles: Vec<Window> = tiles(&window).collect();
        let found: Vec<Option<[Vec<PathSamples>; 2]>> = tiles
            .par_iter()
            .map(|tile| {
                let of_half = |seed| self.sampler.tile(tile, seed, &|[x, y]| counts[window.index(x, y)]);
                (!cancel.load(Ordering::Relaxed)).then(|| seeds.map(of_half))
            })
            .collect();
        if found.iter().any(Option::is_none) {
            return false;
        }
        for (tile, halves) in tiles.iter().zip(found.into_iter().flatten()) {
            for (half, found) in halves.iter().enumerate() {
                for ((x, y), found) in tile.pixels().zip(found) {
                    let k = window.index(x, y);
                    self.pixels[k].add(half, found);
                    self.last[k][half] = found.luminance.mean();
                }
            }
        }
        self.passes += 1;
        true
    }

    /// Unbiased estimate of the mean of `(y − t)²/n²` over the pixels, with the luminances `y` of a
    /// picture from before the last pass, the true luminances `t`, and sizes `n` that depend only
    /// on `y`. The estimate may be below zero by chance.
    ///
    /// ```text
    /// mean (A − y)(B − y)/n²      A, B: the halves of the last pass      n = max(y, mean of y/100)
    /// ```
    ///
    /// The noise in `A` is independent of that in `B`, and both are independent of `y`.
    ///
    /// * `radiance`: picture whose luminances are `y`, row by row, from the passes before the last.
    pub fn squared_error(&self, radiance: &[Rgb]) -> f64 {
        let luminances = || radiance.iter().map(|radiance| f64::from(radiance.luminance()));
        let count = radiance.len().max(1) as f64;
        let least = (LEAST_SIZE * luminances().map(f64::abs).sum::<f64>() / count).max(f64::MIN_POSITIVE);
        let product = |(y, [a, b]): (f64, &[f64; 2])| {
            let size = y.abs().max(least);
            (a - y) * (b - y) / (size * size)
        };
        luminances().zip(&self.last).map(product).sum::<f64>() / count
    }

    /// Approximate variance of single paths of a pixel (luminance²), from all paths in its
    /// neighbourhood. Their standard deviation is taken to be proportional to the luminance of the
    /// pixel.
    ///
    /// ```text
    /// y² mean (σ_q/y_q)²        over the paths of the pixels q within 8 of it
    /// ```
    ///
    /// * `radiance`: picture whose luminances are `y`, row by row; `least`: lower bound on `y`.
    pub fn importance_variance(&self, [x, y]: [u32; 2], radiance: &[Rgb], least: f64) -> f64 {
        let size = |k: usize| f64::from(radiance[k].luminance()).max(least).max(f64::MIN_POSITIVE);
        let Window { x: left, y: top, width, height } = self.window;
        let around = |at: u32, first: u32, side: u32| {
            at.saturating_sub(RADIUS).max(first)..(at + RADIUS + 1).min(first + side)
        };
        let (mut sum, mut paths) = (0.0, 0.0);
        for (x, y) in around(y, top, height).flat_map(|y| around(x, left, width).map(move |x| (x, y))) {
            let k = self.window.index(x, y);
            for Half { luminance, .. } in &self.pixels[k].halves {
                let count = luminance.count() as f64;
                // If the paths of a pixel are not finite, they are ignored in the estimate for
                // other pixels.
                if !luminance.variance().is_finite() {
                    continue;
                }
                sum += count * luminance.variance() / (size(k) * size(k));
                paths += count;
            }
        }
        let own = size(self.window.index(x, y));
        own * own * sum / f64::max(paths, 1.0)
    }

    /// Number of paths of each half of each pixel in the next pass.
    fn spread(&self, importance: &[f32], growth: f64) -> Vec<u32> {
        let mean = growth * self.paths() as f64 / 2.0 / self.pixels.len() as f64;
        // Errors fall with the square root of the number of paths.
        let wanted = |importance: &f32| f64::from(*importance) * f64::from(*importance);
        let sum: f64 = importance.iter().map(wanted).sum();
        let of_one =
            if sum > 0.0 { (1.0 - UNIFORM_SHARE) * mean * importance.len() as f64 / sum } else { 0.0 };
        let count = |importance: &f32| {
            let count = UNIFORM_SHARE * mean + of_one * wanted(importance);
            count.clamp(1.0, MOST * mean.max(1.0)).round() as u32
        };
        importance.iter().map(count).collect()
    }

    /// Film of the estimates, not reconstructed.
    ///
    /// # Errors
    /// A window outside the image.
    pub fn film(&self) -> Result<Film> {
        self.film_of(|pixel| pixel.record(&pixel.halves))
    }

    /// Reconstructs the picture.
    ///
    /// * `smoother`: replacement of our own smoother.
    ///
    /// # Errors
    /// A window outside the image; any error of the given smoother.
    pub fn reconstruct(&self, smoother: Option<&dyn Smoother>) -> Result<Reconstructed> {
        Ok(self.halves()?.reconstruct(smoother)?.expect("films of records have all planes"))
    }

    /// The two halves from which the picture is reconstructed.
    ///
    /// # Errors
    /// A window outside the image.
    pub fn halves(&self) -> Result<Halves> {
        let half = |half: usize| self.film_of(move |pixel| pixel.record(&pixel.halves[half..=half]));
        Ok(Halves { a: half(0)?, b: half(1)? })
    }

    fn film_of(&self, record: impl Fn(&Pixel) -> PixelRecord) -> Result<Film> {
        let mut film = Film::new(self.sampler.setting().view.size, self.window, PixelRecord::PLANES)?;
        for ((x, y), pixel) in self.window.pixels().zip(&self.pixels) {
            record(pixel).store(&mut film, x, y);
        }
        Ok(film)
    }
}

/// Predicted error of each pixel over its tolerance; at most 8.
pub fn importance(reconstructed: &Reconstructed, tolerance: impl Fn(Rgb) -> f64) -> Vec<f32> {
    let of_pixel = |(radiance, error): (&Rgb, &f32)| {
        let share = f64::from(*error) / tolerance(*radiance).max(f64::from(f32::MIN_POSITIVE));
        if share.is_finite() { share.min(LARGEST) as f32 } else { LARGEST as f32 }
    };
    reconstructed.radiance.iter().zip(&reconstructed.importance_error).map(of_pixel).collect()
}

fn tiles(window: &Window) -> impl Iterator<Item = Window> + '_ {
    let [columns, rows] = [window.width, window.height].map(|side| side.div_ceil(TILE));
    (0..columns * rows).map(move |k| {
        let [x, y] = [k % columns * TILE, k / columns * TILE];
        Window {
            x: window.x + x,
            y: window.y + y,
            width: TILE.min(window.width - x),
            height: TILE.min(window.height - y),
        }
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::Tracer;
    use crate::film::planes;
    use crate::gather::{GatherOptions, View};
    use crate::integrator::{ControlOptions, GuidedLights, LightTransport, Setting};
    use crate::scene::builtin;
    use crate::vpl::VplOptions;

    const SIZE: [u32; 2] = [40, 24];
    static NEVER: AtomicBool = AtomicBool::new(false);

    pub(super) fn with_sampler<T>(work: impl FnOnce(&dyn PathSampler) -> T) -> T {
        with_picture(Window::full(SIZE), |picture| work(&*picture.sampler))
    }

    /// All pixels have the same paths. The estimated variance is that of these paths; if the
    /// luminance of one pixel is halved, it falls to about a quarter there. Paths outside the
    /// neighbourhood have no effect.
    #[test]
    fn how_paths_vary_is_told_by_those_around() {
        with_picture(Window::full(SIZE), |mut picture| {
            let mut half = Half::default();
            // Eight paths of mean 2.
            (0..8).for_each(|k| half.luminance.push(if k % 2 == 0 { 1.0 } else { 3.0 }));
            let variance = half.luminance.variance();
            for pixel in &mut picture.pixels {
                pixel.halves = [half; 2];
            }
            let mut radiance = vec![Rgb::gray(2.0); picture.pixels.len()];
            let of = |picture: &Picture<'_>, radiance: &[Rgb]| {
                picture.importance_variance([10, 10], radiance, 0.5)
            };
            let alike = of(&picture, &radiance);
            assert!((alike - variance).abs() < 1e-6, "{alike} for {variance}");
            radiance[picture.window.index(10, 10)] = Rgb::gray(1.0);
            let darker = of(&picture, &radiance);
            // The neighbourhood of 289 pixels includes the pixel itself. Halving its radiance
            // quadruples the relative variance of its own paths.
            assert!((darker / (variance / 4.0 * (1.0 + 3.0 / 289.0)) - 1.0).abs() < 1e-4, "{darker}");
            // Pixels beyond the neighbourhood have no effect.
            let far = picture.window.index(19, 10);
            picture.pixels[far].halves[0].luminance.push(1e6);
            assert_eq!(of(&picture, &radiance), darker);
            let near = picture.window.index(18, 10);
            picture.pixels[near].halves[0].luminance.push(1e6);
            assert!(of(&picture, &radiance) > 1e3 * darker);
        });
    }

    fn with_picture<T>(window: Window, work: impl FnOnce(Picture<'_>) -> T) -> T {
        let tracer = Tracer::new(Arc::new(builtin::tiny()));
        let camera = tracer.scene().cameras()[0].clone();
        let view = View { camera: &camera, size: SIZE, gather: GatherOptions::default(), seed: 1 };
        let options = VplOptions { count: 2000, ..VplOptions::default() };
        let lights = GuidedLights::to_draw(&tracer, &options, &view).unwrap();
        let method = LightTransport::new(&tracer, &lights, &ControlOptions::default());
        work(Picture::new(method.path_sampler(Setting { tracer: &tracer, view }), window, 1))
    }

    /// A second pass of growth 1, with importance 1 in the left half of the image and 0 in the
    /// right half. The number of paths doubles, and most new paths are in the left half.
    #[test]
    fn paths_go_where_errors_are_foreseen() {
        let window = Window::full(SIZE);
        with_picture(window, |mut picture| {
            assert!(picture.pass(None, 1.0, &NEVER));
            let first = picture.paths();
            assert_eq!(first, 2 * u64::from(FIRST) * window.area());
            let left: Vec<f32> = window.pixels().map(|(x, _)| if x < 20 { 1.0 } else { 0.0 }).collect();
            assert!(picture.pass(Some(&left), 1.0, &NEVER));
            let of_all = picture.paths() as f64 / first as f64;
            // Each half has at least one path.
            assert!((2.0..2.4).contains(&of_all), "{of_all}");
            let film = picture.film().unwrap();
            let paths = |x: u32| film.plane(planes::PAIRS).unwrap().f32_at(x, 7)[0];
            // On average, each half of a pixel has two new paths, of which 0.2 are spread evenly,
            // and the others in the left half of the image.
            assert_eq!((paths(3), paths(30)), (4.0 + 2.0 * 4.0, 4.0 + 2.0));
        });
    }

    /// A picture with known errors is compared with eight independent passes. The mean of the
    /// estimates agrees with its mean squared error.
    #[test]
    fn the_squared_error_is_unbiased() {
        let window = Window { x: 10, y: 6, width: 20, height: 12 };
        with_picture(window, |mut picture| {
            for _ in 0..9 {
                let importance = vec![1.0; window.area() as usize];
                assert!(picture.pass((picture.passes > 0).then_some(&importance), 1.0, &NEVER));
            }
            let truth: Vec<Rgb> = picture.film().unwrap().colors().unwrap().collect();
            let off = |k: usize| if k.is_multiple_of(2) { 1.2 } else { 0.9 };
            let off: Vec<Rgb> = truth.iter().enumerate().map(|(k, truth)| *truth * off(k)).collect();
            // Errors are relative to the picture: 0.2/1.2 for a pixel of 1.2 times the truth.
            let expected = 0.5 * (0.04 / 1.44 + 0.01 / 0.81);
            with_picture(window, |mut other| {
                other.seed = 2;
                let mut mean = 0.0;
                for _ in 0..8 {
                    let importance = vec![1.0; window.area() as usize];
                    assert!(other.pass((other.passes > 0).then_some(&importance), 1.0, &NEVER));
                    mean += other.squared_error(&off) / 8.0;
                }
                assert!((mean - expected).abs() < 0.25 * expected, "{mean} for {expected}");
            });
        });
    }

    #[test]
    fn neither_threads_nor_the_window_enter() {
        let of = |threads: usize, window: Window| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            with_picture(window, |mut picture| {
                pool.install(|| picture.pass(None, 1.0, &NEVER));
                picture.film().unwrap()
            })
        };
        let (whole, part) = (Window::full(SIZE), Window { x: 9, y: 5, width: 20, height: 11 });
        let all = of(1, whole);
        assert!(all == of(3, whole));
        assert!(all.cropped(part).unwrap() == of(2, part));
    }

    #[test]
    fn a_pass_that_is_cancelled_changes_nothing() {
        with_picture(Window::full(SIZE), |mut picture| {
            assert!(!picture.pass(None, 1.0, &AtomicBool::new(true)));
            assert_eq!((picture.paths(), picture.passes()), (0, 0));
        });
    }

    /// Features are means over the paths of all passes.
    #[test]
    fn what_passes_find_adds_up() {
        let found = |depth: f32, coverage: f32, values: &[f64]| {
            let mut found = PathSamples { rays: 3, ..PathSamples::default() };
            found.features = Features { depth, coverage, albedo: Rgb::gray(depth), ..Features::default() };
            for value in values {
                found.luminance.push(*value);
                found.sum.add(Rgb::gray(*value as f32));
            }
            found
        };
        let mut pixel = Pixel::default();
        pixel.add(0, &found(2.0, 0.5, &[1.0, 1.0]));
        pixel.add(1, &found(5.0, 1.0, &[4.0]));
        pixel.add(1, &PathSamples::default());
        let record = pixel.record(&pixel.halves);
        assert_eq!((record.radiance, record.pairs, record.rays), (Rgb::gray(2.0), 3, 6));
        assert!((record.depth - 3.5).abs() < 1e-6, "one path of each pass met a surface: {}", record.depth);
        assert!((record.albedo.r - 3.0).abs() < 1e-6 && (record.coverage - 2.0 / 3.0).abs() < 1e-6);
        assert_eq!(pixel.record(&pixel.halves[1..]).radiance, Rgb::gray(4.0));
    }
}
