//! Maps from uniform squares to the shapes that a renderer samples, and the balance heuristic.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};

use crate::math::elementary::{atan2, sin_cos};

/// Weight of a strategy with density `this` that is combined with one of density `other`, by the
/// balance heuristic (Veach 1997, section 9.2). It is 1 if `this` is infinite, and 1/2 if both
/// densities underflow to zero.
#[inline]
pub fn balance(this: f32, other: f32) -> f32 {
    let sum = this + other;
    match sum {
        _ if this.is_infinite() => 1.0,
        0.0 => 0.5,
        // Both densities are finite, but their sum overflows.
        f32::INFINITY if other < f32::INFINITY => 0.25 * this / (0.25 * this + 0.25 * other),
        _ => this / sum,
    }
}

/// Unit disk, uniform, by the concentric map of Shirley and Chiu (1997). Density `1/π`.
#[inline]
pub fn disk(u: [f32; 2]) -> Vec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if a == 0.0 && b == 0.0 {
        return Vec2::ZERO;
    }
    let (r, phi) =
        if a.abs() > b.abs() { (a, PI / 4.0 * (b / a)) } else { (b, PI / 2.0 - PI / 4.0 * (a / b)) };
    {
        let (sin, cos) = sin_cos(phi);
        Vec2::new(r * cos, r * sin)
    }
}

/// Regular polygon with `n = corners` corners (at least 3) on the unit circle, uniform by area. It
/// is turned by `rotation` (radians) counter-clockwise from the position with a corner at `+y`.
/// Density `1 / (n/2 · sin(2π/n))`.
pub fn polygon(u: [f32; 2], corners: u32, rotation: f32) -> Vec2 {
    let n = corners as f32;
    // The integer part chooses a triangle between the centre and a side; the fraction is used
    // again.
    let scaled = u[0] * n;
    let side = scaled.floor().min(n - 1.0);
    let [_, to_first, to_second] = triangle([scaled - side, u[1]]);
    let corner = |k: f32| {
        let (sin, cos) = sin_cos(rotation + 2.0 * PI * k / n);
        Vec2::new(-sin, cos)
    };
    corner(side) * to_first + corner(side + 1.0) * to_second
}

/// Inverse of [`disk`]: the two numbers for a point of the unit disk.
#[inline]
pub fn disk_inverse(p: Vec2) -> [f32; 2] {
    let r = p.length();
    if r == 0.0 {
        return [0.5; 2];
    }
    // The sector that contains the point decides which of the two square coordinates holds the
    // radius.
    let (a, b) = if p.x.abs() > p.y.abs() {
        let r = r.copysign(p.x);
        (r, r * (4.0 / PI) * atan2(p.y.copysign(p.y * p.x), p.x.abs()))
    } else {
        let r = r.copysign(p.y);
        (r * (4.0 / PI) * atan2(p.x.copysign(p.x * p.y), p.y.abs()), r)
    };
    [a, b].map(|x| unit(0.5 * (x + 1.0)))
}

/// Clamps a number to `[0, 1)`, from which rounding may have moved it.
#[inline]
fn unit(u: f32) -> f32 {
    u.clamp(0.0, 1.0 - f32::EPSILON)
}

/// Upper hemisphere around `+z`, density `cos θ / π` per steradian.
#[inline]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let d = disk(u);
    // The lower limit keeps grazing directions above the plane, where the density is zero.
    d.extend((1.0 - d.length_squared()).max(1e-12).sqrt())
}

/// Density of [`cosine_hemisphere`] (sr⁻¹).
#[inline]
pub fn cosine_hemisphere_pdf(cos: f32) -> f32 {
    cos.max(0.0) * FRAC_1_PI
}

/// Whole sphere, uniform. Density `1/4π` per steradian.
#[inline]
pub fn sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = sin_cos(2.0 * PI * u[1]);
    Vec3::new(r * cos, r * sin, z)
}

/// Inverse of [`sphere`]: the two numbers for a unit vector.
#[inline]
pub fn sphere_inverse(d: Vec3) -> [f32; 2] {
    let turn = atan2(d.y, d.x) / (2.0 * PI);
    [unit(0.5 - 0.5 * d.z), unit(if turn < 0.0 { turn + 1.0 } else { turn })]
}

/// Cone around `+z` with half-angle `acos(cos_max)`, uniform. Density `1/(2π(1 − cos_max))`.
#[inline]
pub fn cone(u: [f32; 2], cos_max: f32) -> Vec3 {
    let z = 1.0 - u[0] * (1.0 - cos_max);
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = sin_cos(2.0 * PI * u[1]);
    Vec3::new(r * cos, r * sin, z)
}

/// Inverse of [`cone`]: the two numbers for a unit vector inside the cone.
#[inline]
pub fn cone_inverse(d: Vec3, cos_max: f32) -> [f32; 2] {
    [unit((1.0 - d.z) / (1.0 - cos_max)), sphere_inverse(d)[1]]
}

/// Barycentric coordinates of a triangle, uniform by area.
#[inline]
pub fn triangle(u: [f32; 2]) -> [f32; 3] {
    let r = u[0].sqrt();
    [1.0 - r, r * (1.0 - u[1]), r * u[1]]
}

/// Number in `[−1, 1]` with the tent density `1 − |x|`.
#[inline]
pub fn tent(u: f32) -> f32 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    fn mean(n: u32, mut f: impl FnMut([f32; 2]) -> f32) -> f64 {
        let mut s = Stream::new(11, Purpose::Test, 0);
        (0..n).map(|_| f64::from(f(s.uniform_2()))).sum::<f64>() / f64::from(n)
    }

    /// Weights of two strategies sum to 1 and are never NaN, even for the smallest and largest
    /// numbers.
    #[test]
    fn weights_of_two_strategies_sum_to_one() {
        let densities = [0.0, f32::from_bits(1), f32::MIN_POSITIVE, 1e-20, 0.3, 7.0, 1e20, f32::MAX];
        for (one, other) in densities.iter().flat_map(|one| densities.map(|other| (*one, other))) {
            let weights = [balance(one, other), balance(other, one)];
            assert!((weights[0] + weights[1] - 1.0).abs() < 1e-6, "{one} {other}: {weights:?}");
        }
        assert_eq!((balance(f32::INFINITY, 1.0), balance(1.0, f32::INFINITY)), (1.0, 0.0));
    }

    /// Each side's triangle of the polygon is divided into rings and sectors of equal area.
    /// Pearson's statistic of the counts of samples in these cells is within 4.5 standard
    /// deviations of its mean.
    #[test]
    fn polygons_are_filled_evenly() {
        const CELLS: usize = 8;
        for corners in [3u32, 5, 6, 9] {
            let rotation = 0.3;
            let (n, k) = (100_000, corners as usize);
            let mut counts = vec![0.0f64; k * CELLS * CELLS];
            let mut s = Stream::new(4, Purpose::Test, u64::from(corners));
            for _ in 0..n {
                let p = polygon(s.uniform_2(), corners, rotation);
                // The cell is computed without the map: the side from the angle, the ring from the
                // distance along the side's normal.
                let angle = 2.0 * PI / corners as f32;
                let from_corner = (atan2(-p.x, p.y) - rotation).rem_euclid(2.0 * PI);
                let side = ((from_corner / angle) as usize).min(k - 1);
                let (sin, cos) = sin_cos(rotation + angle * (side as f32 + 0.5));
                let (along, across) = (p.dot(Vec2::new(-sin, cos)), p.dot(Vec2::new(cos, sin)));
                let (half_sin, half_cos) = sin_cos(0.5 * angle);
                let ring = (along / half_cos) * (along / half_cos);
                let sector = 0.5 + 0.5 * across / along * half_cos / half_sin;
                assert!(ring <= 1.0 + 1e-5 && (-1e-3..=1.001).contains(&sector), "{corners}: {p} is outside");
                let cell = |x: f32| ((x * CELLS as f32) as usize).min(CELLS - 1);
                counts[(side * CELLS + cell(ring)) * CELLS + cell(sector)] += 1.0;
            }
            let expected = f64::from(n) / counts.len() as f64;
            let chi_squared: f64 = counts.iter().map(|c| (c - expected) * (c - expected) / expected).sum();
            // With k degrees of freedom the statistic has mean k and standard deviation √2k.
            let freedom = counts.len() as f64 - 1.0;
            let deviations = (chi_squared - freedom) / (2.0 * freedom).sqrt();
            assert!(deviations.abs() < 4.5, "{corners} corners: {deviations} standard deviations");
        }
    }

    #[test]
    fn inverses_lead_back() {
        let mut s = Stream::new(3, Purpose::Test, 0);
        for _ in 0..2000 {
            let u = s.uniform_2();
            let near = |found: [f32; 2], what: &str| {
                // The angle of a vector of length r is known to about 2⁻²²/r.
                let off = (found[0] - u[0]).abs().max((found[1] - u[1]).abs());
                assert!(off < 1e-3, "{what}: {found:?} for {u:?}");
            };
            let turned = |v: Vec3| v.truncate().length() > 1e-2;
            near(disk_inverse(disk(u)), "disk");
            if turned(sphere(u)) {
                near(sphere_inverse(sphere(u)), "sphere");
            }
            if turned(cone(u, 0.3)) {
                near(cone_inverse(cone(u, 0.3), 0.3), "cone");
            }
        }
    }

    /// First and second moments of samples agree with their integrals to within 0.004; standard
    /// errors are below 0.001.
    #[test]
    fn moments_agree_with_the_densities() {
        let n = 400_000;
        assert!((mean(n, |u| cosine_hemisphere(u).z) - 2.0 / 3.0).abs() < 0.004);
        assert!((mean(n, |u| sphere(u).z * sphere(u).z) - 1.0 / 3.0).abs() < 0.004);
        assert!((mean(n, |u| cone(u, 0.5).z) - 0.75).abs() < 0.004);
        assert!((mean(n, |u| disk(u).length_squared()) - 0.5).abs() < 0.004);
        assert!((mean(n, |u| triangle(u)[1]) - 1.0 / 3.0).abs() < 0.004);
        assert!((mean(n, |u| tent(u[0]) * tent(u[0])) - 1.0 / 6.0).abs() < 0.004);
    }
}
