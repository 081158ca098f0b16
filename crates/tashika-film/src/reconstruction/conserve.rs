//! Restoration of the light that a reconstruction lacks.
//!
//! The total light of a reconstruction differs from that of the estimates: clamped outliers lose
//! light, and a dark pixel may average over brighter pixels that do not average over it in turn.
//! Let `R` be the reconstruction of estimates `u` with standard errors `s`. Its deficit
//! `L = Σ u − Σ R` has the variance `V = Σ s²`, in the whole picture and in squares of 64, 32 and
//! 16 pixels. Let the square `c` lie in the next larger square (or the picture) `p`. The light
//! `D_c` that is given to `c` is
//!
//! ```text
//! D_c = S_c + V_c / Σ V (D_p − Σ S)        S = L (1 − κ V/L²)₊        L = Σ u − Σ R
//! ```
//!
//! with sums over the squares in `p`. The whole picture is given `D = S` with `κ = 1`: only the
//! part of a deficit that exceeds its noise is restored (the step of James and Stein 1961). So the
//! light of one lucky path is not restored, and the light of many is. Squares have `κ = 4`, since
//! noise on the scale of 16 pixels would be visible. The rest of `D_p` is divided among the squares
//! in proportion to their variances. Pixels are multiplied by `1 + D / Σ R`, interpolated between
//! the centres of the smallest squares.
//!
//! Exact pixels and pixels that are not finite are ignored and stay unchanged. A black pixel is not
//! exact: its paths may have missed the light that similar pixels found.

use crate::color::Rgb;

/// Sides of the squares (pixels); each is divided by the next.
const SIDES: [usize; 3] = [64, 32, 16];
/// Factor `κ` of squares. Chosen.
const KAPPA: f64 = 4.0;
/// Smallest and largest factor of a square.
const FACTORS: [f32; 2] = [0.5, 2.0];

/// Scales a reconstruction to the light of the estimates, row by row.
///
/// * `variances`: variance of the luminance of each estimate; zero if exact, or black.
pub fn conserve(radiance: &mut [Rgb], estimates: &[Rgb], variances: &[f32], width: usize) {
    let counts = |p: usize| {
        let is_exact = variances[p] <= 0.0 && estimates[p] != Rgb::BLACK;
        !is_exact && variances[p].is_finite() && estimates[p].is_finite() && radiance[p].is_finite()
    };
    let counted: Vec<usize> = (0..radiance.len()).filter(|p| counts(*p)).collect();
    let height = radiance.len() / width.max(1);
    let levels = SIDES.map(|side| {
        let mut squares = Squares::new([width, height], side);
        for p in &counted {
            let light = Light {
                deficit: f64::from(estimates[*p].luminance()) - f64::from(radiance[*p].luminance()),
                variance: variances[*p].into(),
                found: radiance[*p].luminance().into(),
            };
            squares.of[p / width / side * squares.across + p % width / side].add(light);
        }
        squares
    });
    let mut whole = Light::default();
    levels[0].of.iter().for_each(|square| whole.add(*square));
    // The picture is the largest square.
    let (mut given, mut across, mut side) = (vec![whole.certain_deficit(1.0)], 1, width.max(height).max(1));
    for squares in &levels {
        given = squares.given(&given, across, side);
        (across, side) = (squares.across, squares.side);
    }
    let smallest = &levels[SIDES.len() - 1];
    let factor = |(square, given): (&Light, &f64)| {
        let factor = (1.0 + given / square.found) as f32;
        if factor.is_nan() { 1.0 } else { factor.clamp(FACTORS[0], FACTORS[1]) }
    };
    let factors: Vec<f32> = smallest.of.iter().zip(&given).map(factor).collect();
    for p in counted {
        radiance[p] *= smallest.interpolated(&factors, [p % width, p / width]);
    }
}

/// Light of the pixels of a square (luminance).
#[derive(Clone, Copy, Debug, Default)]
struct Light {
    /// Light `L` that the reconstruction lacks.
    deficit: f64,
    /// Variance `V` of the deficit, by the standard errors of the estimates.
    variance: f64,
    /// Light `Σ R` of the reconstruction.
    found: f64,
}

impl Light {
    fn add(&mut self, other: Self) {
        self.deficit += other.deficit;
        self.variance += other.variance;
        self.found += other.found;
    }

    /// Certain part `S` of the deficit.
    fn certain_deficit(&self, kappa: f64) -> f64 {
        let share = 1.0 - kappa * self.variance / (self.deficit * self.deficit);
        if share > 0.0 { share * self.deficit } else { 0.0 }
    }
}

/// Squares of one side that cover the picture, row by row.
struct Squares {
    of: Vec<Light>,
    side: usize,
    across: usize,
    down: usize,
}

impl Squares {
    fn new(size: [usize; 2], side: usize) -> Self {
        let [across, down] = size.map(|pixels| pixels.div_ceil(side).max(1));
        Self { of: vec![Light::default(); across * down], side, across, down }
    }

    /// Light `D` given to each square. `larger`: light given to each of the larger squares, which
    /// have the given `side` (pixels) and of which `across` lie in a row.
    fn given(&self, larger: &[f64], across: usize, side: usize) -> Vec<f64> {
        let larger_of = |square: usize| {
            let [x, y] = [square % self.across, square / self.across];
            y * self.side / side * across + x * self.side / side
        };
        let mut rest = larger.to_vec();
        let mut variances = vec![0.0; larger.len()];
        for (number, square) in self.of.iter().enumerate() {
            rest[larger_of(number)] -= square.certain_deficit(KAPPA);
            variances[larger_of(number)] += square.variance;
        }
        let of_square = |(number, square): (usize, &Light)| {
            let of = larger_of(number);
            let share = if variances[of] > 0.0 { square.variance / variances[of] } else { 0.0 };
            square.certain_deficit(KAPPA) + share * rest[of]
        };
        self.of.iter().enumerate().map(of_square).collect()
    }

    /// Value at a pixel: linear between the centres of squares, constant beyond the outermost.
    fn interpolated(&self, values: &[f32], [x, y]: [usize; 2]) -> f32 {
        let along = |at: usize, count: usize| {
            let place = ((at as f32 + 0.5) / self.side as f32 - 0.5).clamp(0.0, (count - 1) as f32);
            let low = (place as usize).min(count - 1);
            (low, (low + 1).min(count - 1), place - low as f32)
        };
        let ((left, right, s), (top, bottom, t)) = (along(x, self.across), along(y, self.down));
        let at = |x: usize, y: usize| values[y * self.across + x];
        let row = |y: usize| at(left, y) + s * (at(right, y) - at(left, y));
        row(top) + t * (row(bottom) - row(top))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    const WIDTH: usize = 128;
    const PIXELS: usize = WIDTH * 96;

    fn mean(colors: &[Rgb]) -> f32 {
        (colors.iter().map(|color| f64::from(color.luminance())).sum::<f64>() / colors.len() as f64) as f32
    }

    /// A reconstruction that is a tenth too dark on its left half gets back its light there.
    #[test]
    fn light_is_given_back_where_it_lacks() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let noise = 0.3;
        // Of variance 1, about normal.
        let mut normal = || (0..12).map(|_| s.uniform()).sum::<f32>() - 6.0;
        let estimates: Vec<Rgb> = (0..PIXELS).map(|_| Rgb::gray(1.0 + noise * normal())).collect();
        let is_left = |p: usize| p % WIDTH < WIDTH / 2;
        let mut radiance: Vec<Rgb> =
            (0..PIXELS).map(|p| Rgb::gray(if is_left(p) { 0.9 } else { 1.0 })).collect();
        conserve(&mut radiance, &estimates, &vec![noise * noise; PIXELS], WIDTH);
        assert!((mean(&radiance) / mean(&estimates) - 1.0).abs() < 2e-3);
        for (p, color) in radiance.iter().enumerate().filter(|(p, _)| p % WIDTH < 32 || p % WIDTH >= 96) {
            // A tenth lacked; the noise of a square of 16 pixels is 1.9 %.
            assert!((color.luminance() - 1.0).abs() < 0.05, "pixel {p}: {color:?}");
        }
    }

    /// A reconstruction that lacks the light of 1 or of 64 outliers. The light of one is not
    /// restored; the light of 64 is distributed over all pixels. Exact pixels and pixels that are
    /// not finite are ignored and stay unchanged.
    #[test]
    fn the_light_of_many_outliers_is_given_back() {
        for (outliers, share) in [(1, 0.0), (64, 1.0 - 1.0 / 64.0)] {
            let mut estimates = vec![Rgb::WHITE; PIXELS];
            let mut variances = vec![1e-6; PIXELS];
            for k in 0..outliers {
                let outlier = (40 + 7 * k) * WIDTH % PIXELS + 40;
                estimates[outlier] = Rgb::gray(11.0);
                variances[outlier] = 100.0;
            }
            variances[5] = 0.0;
            estimates[7] = Rgb::gray(f32::NAN);
            let mut radiance = vec![Rgb::WHITE; PIXELS];
            radiance[5] = Rgb::gray(3.0);
            radiance[7] = Rgb::gray(f32::NAN);
            conserve(&mut radiance, &estimates, &variances, WIDTH);
            assert!(radiance[5] == Rgb::gray(3.0) && !radiance[7].is_finite());
            radiance.swap_remove(7);
            radiance.swap_remove(5);
            let expected = 1.0 + share * 10.0 * outliers as f32 / (PIXELS - 2) as f32;
            assert!((mean(&radiance) - expected).abs() < 2e-3, "{} of {expected}", mean(&radiance));
        }
    }
}
