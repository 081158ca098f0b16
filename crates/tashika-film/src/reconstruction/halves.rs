//! Reconstruction of two independent halves of a picture, which predicts its own error.
//!
//! ```text
//! y_A = means of A over pixels that are alike by B      y_B = means of B … by A      y = (y_A + y_B)/2
//! ẑ = y + λ (u′ − y)      u = (A + B)/2      λ = Σ (A − y)(B − y)/n² / Σ (u − y)²/n²  in [0, 1], over a block
//! e²/n² = (1 − λ)² max(0, mean (A − y)(B − y)/n²) + ((1 − λ) s_y + λ s_u)²/n² + mean (y_A − y_B)²/4n²
//! ```
//!
//! All quantities are luminances. `u′` is `u` with outliers clamped; `s_y` and `s_u` are the
//! standard errors of `y` and `u` due to the noise of the pixels; `n` is the size of the pixel,
//! which errors are relative to. Means are over a block. They are of errors relative to `n`, so
//! that a dark pixel beside a bright one has a smaller error. The standard errors are those of the
//! pixel itself, not means over the block, so that a pixel without similar pixels keeps its noise.
//!
//! The weights for one half come from the other half. They are independent of the noise of the
//! pixels that they average, and so cannot select pixels by it (Rousselle, Knaus, Zwicker 2012).
//! The mean of the products `(A − y)(B − y)` is the squared bias of `y`, since the noises of the
//! two halves are independent. So `λ` is a step of James and Stein (1961) towards the unbiased
//! picture. It tends to 1 as the number of samples grows, so that more work always helps.
//!
//! # Guarantee
//! None: `e` guides work; only an audit can make a claim about a picture.

use std::fmt;

use rayon::prelude::*;

use super::alike::{self, Mean};
use super::conserve::conserve;
use super::outliers::{self, ClampedPixel};
use super::pixels::Pixels;
use crate::color::Rgb;
use crate::error::Result;
use crate::film::{Film, planes};

/// Pixels from the middle of a block to its edge.
const BLOCK: usize = 3;
/// Smallest size `n` of a pixel, which its errors are relative to, as a share of the mean luminance
/// of the picture.
pub const LEAST_SIZE: f64 = 0.01;

/// Two independent films of one picture, each with the features of both.
#[derive(Clone, Debug)]
pub struct Halves {
    /// First half.
    pub a: Film,
    /// Second half.
    pub b: Film,
}

/// A denoiser that replaces the means of similar pixels.
pub trait Smoother: fmt::Debug + Send + Sync {
    /// Name of the denoiser, with its version.
    fn name(&self) -> String;

    /// Denoises a picture, row by row.
    ///
    /// * `radiance`: the noisy picture; `film`: its features.
    ///
    /// # Errors
    /// Any error of the denoiser.
    fn smooth(&self, radiance: &[Rgb], film: &Film) -> Result<Vec<Rgb>>;
}

/// A reconstruction, row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reconstructed {
    /// Reconstructed radiance (W·m⁻²·sr⁻¹).
    pub radiance: Vec<Rgb>,
    /// Predicted root mean square of the luminance's error (W·m⁻²·sr⁻¹). A heuristic.
    pub importance_error: Vec<f32>,
}

impl Reconstructed {
    /// Median of the relative errors that are finite; 0 without any. A heuristic.
    pub fn importance_median(&self) -> f64 {
        let relative = |(radiance, error): (&Rgb, &f32)| f64::from(error / radiance.luminance());
        let errors = self.radiance.iter().zip(&self.importance_error).map(relative);
        let mut errors: Vec<f64> = errors.filter(|error| error.is_finite()).collect();
        let middle = errors.len() / 2;
        if errors.is_empty() { 0.0 } else { *errors.select_nth_unstable_by(middle, f64::total_cmp).1 }
    }
}

impl Halves {
    /// Reconstructs the picture; `None` if a film lacks a plane that is needed. Runs on the current
    /// thread pool.
    ///
    /// * `smoother`: a denoiser instead of means of similar pixels.
    ///
    /// # Errors
    /// Errors of the denoiser.
    pub fn reconstruct(&self, smoother: Option<&dyn Smoother>) -> Result<Option<Reconstructed>> {
        let Some(read) = Read::of(self) else { return Ok(None) };
        let smooth = match smoother {
            Some(smoother) => Smooth::by(smoother, &read, &self.a)?,
            None => Smooth::by_similarity(&read),
        };
        Ok(Some(read.reconstruct(&smooth)))
    }
}

/// Quantities of two halves.
struct Read {
    /// Pixels of half A, without those that half B excludes; the features are those of both halves.
    pixels: Pixels,
    tamed: [Vec<ClampedPixel>; 2],
    radiance: [Vec<Rgb>; 2],
    /// Standard errors of the luminance of each half.
    errors: [Vec<f32>; 2],
}

/// Reconstructions before the step towards the unbiased picture.
struct Smooth {
    /// `y_A` and `y_B`.
    halves: [Vec<Rgb>; 2],
    /// Their mean, `y`, or the denoised mean of both halves.
    both: Vec<Rgb>,
    /// Variance of the luminance of `y`, by the noise of the averaged pixels; zeros if that is
    /// unknown.
    variance: Vec<f32>,
}

impl Smooth {
    /// Averages similar pixels of each half; their similarity is measured in the other half.
    fn by_similarity(read: &Read) -> Self {
        let Read { pixels, tamed: [a, b], .. } = read;
        let means = [alike::means(pixels, b, a), alike::means(pixels, a, b)];
        let of_half = |half: usize| -> Vec<Mean> {
            let exact = |radiance: &Rgb| Mean { radiance: *radiance, variance: 0.0 };
            let pixels = means[half].iter().zip(&read.radiance[half]);
            pixels.map(|(mean, plain)| mean.unwrap_or_else(|| exact(plain))).collect()
        };
        let [a, b] = [of_half(0), of_half(1)];
        let radiance = |half: &[Mean]| half.iter().map(|mean| mean.radiance).collect();
        Self {
            both: a.iter().zip(&b).map(|(a, b)| (a.radiance + b.radiance) * 0.5).collect(),
            variance: a.iter().zip(&b).map(|(a, b)| 0.25 * (a.variance + b.variance)).collect(),
            halves: [radiance(&a), radiance(&b)],
        }
    }

    /// Denoises with the given smoother. Pixels that are not finite are black in its input, and
    /// keep their values.
    fn by(smoother: &dyn Smoother, read: &Read, film: &Film) -> Result<Self> {
        let [a, b] = &read.radiance;
        let both: Vec<Rgb> = a.iter().zip(b).map(|(a, b)| (*a + *b) * 0.5).collect();
        let smooth = |radiance: &[Rgb]| -> Result<Vec<Rgb>> {
            let finite = |color: &Rgb| if color.is_finite() { *color } else { Rgb::BLACK };
            let mut smooth = smoother.smooth(&radiance.iter().map(finite).collect::<Vec<_>>(), film)?;
            for (smooth, plain) in smooth.iter_mut().zip(radiance) {
                if !plain.is_finite() {
                    *smooth = *plain;
                }
            }
            Ok(smooth)
        };
        Ok(Self { halves: [smooth(a)?, smooth(b)?], both: smooth(&both)?, variance: vec![0.0; both.len()] })
    }
}

impl Read {
    /// Reads two halves; `None` if a film lacks a plane that is needed.
    fn of(halves: &Halves) -> Option<Self> {
        let Halves { a, b } = halves;
        let [mut pixels, mut other] = [Pixels::of(a)?, Pixels::of(b)?];
        pixels.without_those_of(&other);
        other.without_those_of(&pixels);
        let errors = |film: &Film| Some(film.plane(planes::STANDARD_ERROR)?.f32_samples()?.to_vec());
        Some(Self {
            tamed: [outliers::clamp_all(&pixels), outliers::clamp_all(&other)],
            radiance: [a.colors()?.collect(), b.colors()?.collect()],
            errors: [errors(a)?, errors(b)?],
            pixels,
        })
    }

    fn reconstruct(&self, smooth: &Smooth) -> Reconstructed {
        let Self { pixels, tamed, radiance: [of_a, of_b], errors } = self;
        let Smooth { halves: [y_a, y_b], both: smoothed, variance: of_smooth } = smooth;
        let sizes = smoothed.iter().map(|color| f64::from(color.luminance().abs()));
        let mean = sizes.filter(|size| size.is_finite()).sum::<f64>();
        let least = (LEAST_SIZE * mean / smoothed.len().max(1) as f64) as f32;
        let products: Vec<Products> = (0..smoothed.len())
            .map(|p| {
                let [y, a, b] = [smoothed[p], of_a[p], of_b[p]].map(Rgb::luminance);
                let size = y.abs().max(least).max(f32::MIN_POSITIVE);
                let (a, b) = ((a - y) / size, (b - y) / size);
                let spread = 0.5 * (y_a[p].luminance() - y_b[p].luminance()) / size;
                let whole = 0.5 * (a + b);
                Products { size, bias: a * b, square: whole * whole, spread: spread * spread }
            })
            .collect();
        let [width, height] = [pixels.width, pixels.height];
        let pixel = |(x, y): (usize, usize)| {
            let block = Products::mean(&products, [x, y], [width, height]);
            let step = if block.square > 0.0 { (block.bias / block.square).clamp(0.0, 1.0) } else { 0.0 };
            let p = y * width + x;
            // `u′`, with outliers clamped: the excess of a rare bright path enters only through the
            // means.
            let plain = pixels.albedo[p] * (tamed[0][p].irradiance + tamed[1][p].irradiance) * 0.5;
            let size = products[p].size;
            let variance: f32 = errors.iter().map(|e| 0.25 * e[p] * e[p] / (size * size)).sum();
            let smooth = of_smooth[p] / (size * size);
            let noise = (1.0 - step) * smooth.sqrt() + step * variance.sqrt();
            let rest = (1.0 - step) * (1.0 - step) * block.bias.max(0.0);
            let error = size * (rest + noise * noise + block.spread).sqrt();
            (smoothed[p].lerp(plain, step), error)
        };
        let rows = (0..height).into_par_iter();
        let (mut radiance, importance_error): (Vec<Rgb>, _) =
            rows.flat_map_iter(|y| (0..width).map(move |x| (x, y))).map(pixel).unzip();
        let estimates: Vec<Rgb> = of_a.iter().zip(of_b).map(|(a, b)| (*a + *b) * 0.5).collect();
        let of_both = |(a, b): (&f32, &f32)| 0.25 * (a * a + b * b);
        let variances: Vec<f32> = errors[0].iter().zip(&errors[1]).map(of_both).collect();
        conserve(&mut radiance, &estimates, &variances, width);
        Reconstructed { radiance, importance_error }
    }
}

/// Contribution of a pixel to the means over a block.
#[derive(Clone, Copy, Debug, Default)]
struct Products {
    /// Luminance `n` that errors are relative to.
    size: f32,
    /// `(A − y)(B − y)/n²`.
    bias: f32,
    /// `(u − y)²/n²`.
    square: f32,
    /// `(y_A − y_B)²/4n²`.
    spread: f32,
}

impl Products {
    /// Means over the block of a pixel, without values that are not finite.
    fn mean(of: &[Self], [x, y]: [usize; 2], [width, height]: [usize; 2]) -> Self {
        let (mut sum, mut count) = (Self::default(), 0.0f32);
        for y in y.saturating_sub(BLOCK)..(y + BLOCK + 1).min(height) {
            for of_pixel in &of[y * width..][x.saturating_sub(BLOCK)..(x + BLOCK + 1).min(width)] {
                if (of_pixel.square + of_pixel.spread + of_pixel.bias).is_finite() {
                    sum.bias += of_pixel.bias;
                    sum.square += of_pixel.square;
                    sum.spread += of_pixel.spread;
                    count += 1.0;
                }
            }
        }
        let count = count.max(1.0);
        Self { size: 0.0, bias: sum.bias / count, square: sum.square / count, spread: sum.spread / count }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PixelRecord, Window};
    use crate::math::Vec3;
    use crate::rng::{Purpose, Stream};

    const SIZE: [u32; 2] = [64, 48];

    /// Luminance of a flat wall at the middle of a pixel. The wall is bright to the right of a soft
    /// edge, and has stripes that no feature shows.
    fn truth(x: u32) -> f32 {
        let edge = ((x as f32 - 28.0) / 8.0).clamp(0.0, 1.0);
        1.0 + 2.0 * edge + if x % 8 < 4 { 0.2 } else { 0.0 }
    }

    /// A deviate of variance 1, approximately normal.
    fn normal(s: &mut Stream) -> f32 {
        (0..12).map(|_| s.uniform()).sum::<f32>() - 6.0
    }

    /// Half a picture of that wall with relative noise.
    fn half(noise: f32, seed: u64) -> Film {
        let mut film = Film::new(SIZE, Window::full(SIZE), PixelRecord::PLANES).unwrap();
        let mut s = Stream::new(seed, Purpose::Test, 0);
        for (x, y) in Window::full(SIZE).pixels() {
            let record = PixelRecord {
                radiance: Rgb::gray(truth(x) * (1.0 + noise * normal(&mut s))),
                standard_error: noise * truth(x),
                depth: 3.0,
                normal: Vec3::Z,
                albedo: Rgb::gray(0.5),
                coverage: 1.0,
                ..PixelRecord::default()
            };
            record.store(&mut film, x, y);
        }
        film
    }

    fn reconstructed(noise: f32) -> Reconstructed {
        Halves { a: half(noise, 1), b: half(noise, 2) }.reconstruct(None).unwrap().unwrap()
    }

    /// Root of the mean squared relative error.
    fn error(radiance: &[Rgb]) -> f64 {
        let of = |((x, _), color): ((u32, u32), &Rgb)| f64::from(color.luminance() / truth(x) - 1.0).powi(2);
        (Window::full(SIZE).pixels().zip(radiance).map(of).sum::<f64>() / radiance.len() as f64).sqrt()
    }

    /// The plain mean of two halves has the error `noise/√2`. At noise 0.4 the reconstruction has
    /// less than 0.4 of this error. At weaker noise it has at most 1.1 times this error, although
    /// no feature shows the stripes.
    #[test]
    fn more_work_always_helps() {
        let errors =
            [0.4, 0.1, 0.02, 0.002].map(|noise| error(&reconstructed(noise).radiance) / f64::from(noise));
        let plain = 0.5_f64.sqrt();
        assert!(errors[0] < 0.4 * plain, "{errors:?}");
        assert!(errors[1..].iter().all(|error| *error < 1.1 * plain), "{errors:?}");
    }

    /// Predicted errors are close to actual ones, where noise is left and where the stripes are
    /// smeared.
    #[test]
    fn errors_are_foreseen() {
        for noise in [0.4, 0.2, 0.05] {
            let found = reconstructed(noise);
            let squares = Window::full(SIZE).pixels().zip(&found.radiance).zip(&found.importance_error);
            let (mut off, mut foreseen) = (0.0, 0.0);
            for (((x, _), color), error) in squares {
                off += f64::from(color.luminance() - truth(x)).powi(2);
                foreseen += f64::from(*error).powi(2);
            }
            let ratio = (foreseen / off).sqrt();
            assert!((0.6..1.6).contains(&ratio), "noise {noise}: foreseen over found {ratio}");
        }
    }

    /// Smoother that doubles the picture.
    #[derive(Debug)]
    struct Twice;

    impl Smoother for Twice {
        fn name(&self) -> String {
            "twice".into()
        }

        fn smooth(&self, radiance: &[Rgb], _: &Film) -> Result<Vec<Rgb>> {
            assert!(radiance.iter().all(|color| color.is_finite()), "it is not handed what is no number");
            Ok(radiance.iter().map(|color| *color * 2.0).collect())
        }
    }

    /// A pixel that is not finite in one half stays so; no other pixel becomes darker or loses its
    /// finite value because of it.
    #[test]
    fn pixels_that_are_not_finite_do_not_spread() {
        let at = Window::full(SIZE).index(30, 20);
        for smoother in [None, Some(&Twice as &dyn Smoother)] {
            for value in [f32::NAN, f32::INFINITY] {
                let whole = Halves { a: half(0.2, 1), b: half(0.2, 2) };
                let mut broken = whole.clone();
                let record = PixelRecord {
                    radiance: Rgb::new(1.0, value, 1.0),
                    standard_error: f32::NAN,
                    stop: crate::film::Stop::SampleCount,
                    ..PixelRecord::default()
                };
                record.store(&mut broken.b, 30, 20);
                let [whole, broken] =
                    [whole, broken].map(|halves| halves.reconstruct(smoother).unwrap().unwrap());
                for (p, [before, found]) in
                    whole.radiance.iter().zip(&broken.radiance).map(|(a, b)| [*a, *b]).enumerate()
                {
                    if p == at {
                        assert!(!found.is_finite());
                        continue;
                    }
                    // One pixel of some fifty similar ones is missing; noise of 0.2 changes the
                    // mean by a similar amount.
                    let off = (found.luminance() / before.luminance() - 1.0).abs();
                    assert!(off < 0.1, "pixel {p}: {found:?} for {before:?}");
                    assert!(broken.importance_error[p].is_finite());
                }
            }
        }
    }

    #[test]
    fn the_median_is_that_of_pixels_that_are_not_black() {
        let radiance = [1.0, 2.0, 0.0, 4.0].map(Rgb::gray).to_vec();
        let found = Reconstructed { radiance, importance_error: vec![0.1, 0.6, 0.0, 0.4] };
        assert!((found.importance_median() - 0.1).abs() < 1e-6, "{}", found.importance_median());
        assert_eq!(Reconstructed::default().importance_median(), 0.0);
    }

    #[test]
    fn threads_do_not_enter() {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| reconstructed(0.3))
        };
        assert!(with(1) == with(3));
    }
}
