//! Signs of edge functions and signed volumes without rounding errors.
//!
//! Vector code decides most signs by an error bound ([`triangle`](super::triangle)). The remaining
//! signs are decided here: first in double precision with an error bound; if that is not certain,
//! exactly.
//!
//! # Exact signs
//! A determinant of three vectors is a sum of six products `x y z` of single-precision numbers.
//! `x y` has at most 48 bits and is exact in double precision. It is split into its upper 26 bits
//! and the rest of at most 22. Each part times `z` has at most 50 bits and is exact again: the
//! smallest and largest exponents, −447 and 384, are far from the limits of `f64`. These products
//! are summed as a nonoverlapping expansion (Shewchuk 1997, theorem 10), whose sign is the sign of
//! its last nonzero component. Held to this by `exact::tests`, against another implementation.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};

/// Maximum number of terms of a sum: four determinants of twelve terms.
const TERMS: usize = 48;

/// An exact sum of doubles, as nonoverlapping components of increasing magnitude.
struct Expansion {
    parts: [f64; TERMS],
    count: usize,
}

impl Expansion {
    const ZERO: Self = Self { parts: [0.0; TERMS], count: 0 };

    /// Adds a number.
    fn add(&mut self, number: f64) {
        let mut carried = number;
        for part in &mut self.parts[..self.count] {
            // The sum and its rounding error (Knuth).
            let sum = carried + *part;
            let of_part = sum - carried;
            *part = (carried - (sum - of_part)) + (*part - of_part);
            carried = sum;
        }
        self.parts[self.count] = carried;
        self.count += 1;
    }

    /// Adds the determinant `x · (y × z)`.
    fn add_determinant(&mut self, x: Vec3, y: Vec3, z: Vec3) {
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            self.add_product(x[i], y[j], z[k]);
            self.add_product(-x[i], y[k], z[j]);
        }
    }

    /// Adds a product of three numbers.
    fn add_product(&mut self, x: f32, y: f32, z: f32) {
        const LOWER: u64 = (1 << 27) - 1;
        let (product, z) = (f64::from(x) * f64::from(y), f64::from(z));
        let upper = f64::from_bits(product.to_bits() & !LOWER);
        self.add(upper * z);
        self.add((product - upper) * z);
    }

    fn sign(&self) -> Ordering {
        let last = self.parts[..self.count].iter().rev().find(|part| **part != 0.0);
        last.map_or(Ordering::Equal, |part| part.total_cmp(&0.0))
    }
}

/// `γ₁₀` in double precision.
const GAMMA_10: f64 = 10.0 * (f64::EPSILON * 0.5) / (1.0 - 10.0 * (f64::EPSILON * 0.5));

/// Sign of the edge function `d · ((p − o) × (q − o))`: the side on which the line from `o` along
/// `d` passes the edge from `p` to `q`.
///
/// The double-precision value is `(d × (p − o)) · (q − p)`, with an error of at most
/// `γ₇ (|d| × |p − o|) · |q − p|`, where the cross product of absolute values has sums in place of
/// differences. Nothing underflows, since all factors are zero or at least 2⁻¹⁴⁹.
fn edge(p: Vec3, q: Vec3, o: Vec3, d: Vec3) -> Ordering {
    let [p64, q64, o64, d64] = [p, q, o, d].map(Vec3::as_dvec3);
    let (a, e) = (p64 - o64, q64 - p64);
    certain(d64.cross(a).dot(e), permanent(d64.abs(), a.abs()).dot(e.abs())).unwrap_or_else(|| {
        let mut sum = Expansion::ZERO;
        sum.add_determinant(d, p, q);
        sum.add_determinant(d, q, o);
        sum.add_determinant(d, o, p);
        sum.sign()
    })
}

/// Sign of a number whose error is at most `γ₁₀` times `size`; `None` if that error leaves the sign
/// open.
fn certain(number: f64, size: f64) -> Option<Ordering> {
    (number.abs() > GAMMA_10 * size).then(|| number.total_cmp(&0.0))
}

/// The cross product with sums in place of differences.
fn permanent(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)
}

/// The plane of a triangle, in double precision.
struct Plane<'a> {
    v: &'a [Vec3; 3],
    n: DVec3,
    /// Sums of absolute products: the error of `n` is at most `γ₄` times this.
    size: DVec3,
}

impl<'a> Plane<'a> {
    fn new(v: &'a [Vec3; 3]) -> Self {
        let [v0, v1, v2] = v.map(Vec3::as_dvec3);
        let (e1, e2) = (v1 - v0, v2 - v0);
        Self { v, n: e1.cross(e2), size: permanent(e1.abs(), e2.abs()) }
    }

    /// `(v₀ − p) · n`.
    fn volume(&self, p: Vec3) -> f64 {
        (self.v[0].as_dvec3() - p.as_dvec3()).dot(self.n)
    }

    /// Sign of `(v₀ − p) · n`, which gives the side of the plane on which `p` lies.
    ///
    /// In double precision the error of this product is at most `γ₈ |v₀ − p| · (|e₁| × |e₂|)`,
    /// where the cross product of absolute values has sums in place of differences.
    fn side(&self, p: Vec3) -> Ordering {
        let a = self.v[0].as_dvec3() - p.as_dvec3();
        certain(a.dot(self.n), a.abs().dot(self.size)).unwrap_or_else(|| {
            let mut sum = self.exact_product(-p);
            sum.add_determinant(self.v[0], self.v[1], self.v[2]);
            sum.sign()
        })
    }

    /// Sign of `d · n`.
    fn slope(&self, d: Vec3) -> Ordering {
        let d64 = d.as_dvec3();
        certain(d64.dot(self.n), d64.abs().dot(self.size)).unwrap_or_else(|| self.exact_product(d).sign())
    }

    /// `d · n`.
    fn exact_product(&self, d: Vec3) -> Expansion {
        let [v0, v1, v2] = *self.v;
        let mut sum = Expansion::ZERO;
        for (a, b) in [(v0, v1), (v1, v2), (v2, v0)] {
            sum.add_determinant(d, a, b);
        }
        sum
    }
}

/// Returns true if a triangle blocks the segment from `o` along `d`, by the two rules of
/// [`accel`](crate::accel).
///
/// * `end`: the end of the segment; `None` if it goes to infinity.
#[inline(never)]
pub(super) fn segment_meets(v: &[Vec3; 3], o: Vec3, d: Vec3, end: Option<Vec3>) -> bool {
    let plane = Plane::new(v);
    let start = plane.side(o);
    let end = || end.map_or_else(|| plane.slope(d).reverse(), |end| plane.side(end));
    start != Ordering::Equal && opposite(start, end()) && line_meets(v, o, d)
}

/// Parameter `t ≥ 0` at which the ray from `o` along `d` meets the triangle; `None` if it misses.
#[inline(never)]
pub(super) fn ray_meets(v: &[Vec3; 3], o: Vec3, d: Vec3) -> Option<f32> {
    let plane = Plane::new(v);
    let start = plane.side(o);
    let meets = start != Ordering::Equal && start == plane.slope(d) && line_meets(v, o, d);
    // Unlike the signs, the quotient has rounding errors.
    meets.then(|| (plane.volume(o) / d.as_dvec3().dot(plane.n)).max(0.0) as f32)
}

/// Returns true if the line from `o` along `d` meets the triangle, edges and corners included. The
/// plane of the triangle must not be parallel to the line.
fn line_meets(v: &[Vec3; 3], o: Vec3, d: Vec3) -> bool {
    let first = edge(v[1], v[2], o, d);
    let second = edge(v[2], v[0], o, d);
    if opposite(first, second) {
        return false;
    }
    let third = edge(v[0], v[1], o, d);
    !opposite(first, third) && !opposite(second, third)
}

/// Returns true if one sign is positive and the other negative.
fn opposite(a: Ordering, b: Ordering) -> bool {
    a != Ordering::Equal && a == b.reverse()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::scales::{orientation, random_exponent};
    use crate::rng::{Purpose, Stream};

    /// Signs agree with those of the crate `robust`, which sums doubles by another algorithm.
    /// Points are random, or so close to a plane that rounding decides most signs.
    #[test]
    fn signs_agree_with_another_exact_predicate() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let mut signs = [0; 3];
        for round in 0..200_000 {
            let mut point = |scale: f32| (Vec3::from(s.uniform_3()) - 0.5) * scale;
            let (o, p, d) = (point(2.0), point(2.0), point(2.0));
            let along = point(1.0);
            let off = [0.0, 1e-9, 1e-6, 1.0][round % 4];
            // On the plane of the line and `p`, or near it.
            let q = match round % 3 {
                0 => o + (p - o) * along.x + d * along.y + point(off),
                1 => Vec3::new(p.x, p.y, p.z + off),
                _ => p + d * along.x,
            };
            let exact = orientation([o.as_dvec3() + d.as_dvec3(), p.as_dvec3(), q.as_dvec3()], o.as_dvec3());
            // If `o + d` is rounded, the predicate of `robust` sees another line: such rounds are
            // skipped.
            if o.as_dvec3() + d.as_dvec3() - o.as_dvec3() != d.as_dvec3()
                || o.as_dvec3() + d.as_dvec3() - d.as_dvec3() != o.as_dvec3()
            {
                continue;
            }
            assert_eq!(edge(p, q, o, d), exact, "round {round}: {o} {d} {p} {q}");
            assert_eq!(edge(q, p, o, d), exact.reverse());
            let mut sum = Expansion::ZERO;
            sum.add_determinant(d, p, q);
            sum.add_determinant(d, q, o);
            sum.add_determinant(d, o, p);
            assert_eq!(sum.sign(), exact, "without the bound");
            signs[(exact as i8 + 1) as usize] += 1;
        }
        assert!(signs.iter().all(|count| *count > 5000), "{signs:?}");
    }

    /// Points and directions are scaled by powers of two, from the smallest numbers to the largest.
    /// The signs do not change.
    #[test]
    fn signs_do_not_depend_on_the_scale() {
        let mut s = Stream::new(2, Purpose::Test, 0);
        for _ in 0..20_000 {
            let mut point = || (Vec3::from(s.uniform_3()) * 64.0).round() - 32.0;
            let (o, p, q, d) = (point(), point(), point(), point());
            let exact = edge(p, q, o, d);
            let (of_points, of_line) =
                (random_exponent(&mut s, -149, 120), random_exponent(&mut s, -149, 120));
            let [o, p, q] = [o, p, q].map(|v| v * of_points);
            assert_eq!(edge(p, q, o, d * of_line), exact, "{of_points:e} {of_line:e}");
        }
    }
}
