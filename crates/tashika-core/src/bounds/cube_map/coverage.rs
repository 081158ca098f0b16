//! Texels that contain a direction of a box or of a cone.
//!
//! Let `x = d_a > 0` be the longest component of a vector `d`. The vector falls into column
//! `[s, t]` if `s x ≤ d_b ≤ t x`. In a box, `d_b` can be any number in `[lo, hi]`, so the column is
//! met for those `x` that satisfy
//!
//! ```text
//! s x ≤ hi  and  t x ≥ lo:    an interval X_u of x
//! ```
//!
//! Likewise a row is met for an interval `X_v`, since for a given `x` the components `d_b` and
//! `d_c` are independent. A texel is met if and only if `X_u`, `X_v` and the range `[lo_a, hi_a]`
//! of the box have a common `x`. The result is the exact perspective image of the box, texel by
//! texel; the product of the ranges of `u` and of `v` would be its bounding rectangle.
//!
//! The texels of a cone are those of the smallest box around its unit vectors, except texels whose
//! bounding cones do not intersect the cone.
//!
//! # Guarantee
//! Every direction falls into a covered texel, except for vectors whose components are all at most
//! [`SHORTEST`] in magnitude. The edges of texels are moved outwards by more than the rounding of
//! the products here. Tested below.

use super::faces::Faces;
use super::texel::Texel;
use crate::bounds::Towards;
use crate::math::{Aabb, Cone, Vec3};

/// Vectors whose longest component is at most this are ignored: `2⁻⁶¹`, less than 10⁻¹⁷ / √3 (m).
///
/// Without this limit a flat box through the origin would cover all texels, since the origin, which
/// has no direction, lies on all edges.
const SHORTEST: f32 = 1.0 / (1u64 << 61) as f32;

/// Amount by which quantities computed from a cone are moved outwards. It exceeds their rounding
/// error of about `10 · 2⁻²⁴`.
const CONE_ROUNDING: f32 = 1e-6;

/// Returns the largest of the texels that contain a direction of `towards`.
pub fn upper<const N: usize>(towards: &Towards, texels: &[[[Texel; N]; N]; 6]) -> Texel {
    let (vectors, cone) = match towards {
        Towards::Box(vectors) => (*vectors, None),
        Towards::Cone(cone) if !cone.is_all() => (box_of(cone), Some(cone)),
        Towards::Cone(_) | Towards::Any => (Aabb { lo: Vec3::NEG_ONE, hi: Vec3::ONE }, None),
    };
    let mut upper = [Texel::ZERO; N];
    for (number, rows) in texels.iter().enumerate() {
        let Some(face) = Face::<N>::of(number, &vectors) else { continue };
        for (v, row) in rows.iter().enumerate() {
            if face.misses_row(v) {
                continue;
            }
            let mut values = *row;
            for (value, met) in values.iter_mut().zip(face.row(v)) {
                *value = if met { *value } else { Texel::ZERO };
            }
            if let Some(cone) = cone {
                for (u, value) in values.iter_mut().enumerate() {
                    if *value > Texel::ZERO && !meets(cone, &Faces::<N>::cone(number, v, u)) {
                        *value = Texel::ZERO;
                    }
                }
            }
            for (largest, value) in upper.iter_mut().zip(values) {
                *largest = value.max(*largest);
            }
        }
    }
    upper.into_iter().fold(Texel::ZERO, Texel::max)
}

/// The part of a box that projects onto one face, as the intervals in which columns and rows are
/// met.
struct Face<const N: usize> {
    columns: Intervals<N>,
    rows: Intervals<N>,
}

/// For each column, or each row, the interval of the component along the face's axis in which it is
/// met. Empty if `lo > hi`.
struct Intervals<const N: usize> {
    lo: [f32; N],
    hi: [f32; N],
}

impl<const N: usize> Face<N> {
    /// Projects a box onto a face; `None` if no vector of the box points to the face's side.
    #[inline]
    fn of(number: usize, vectors: &Aabb) -> Option<Self> {
        let (a, against) = (number / 2, number % 2 == 1);
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        let (lo, hi) = (vectors.lo, vectors.hi);
        let [near, far] = if against { [-hi[a], -lo[a]] } else { [lo[a], hi[a]] };
        let along = [near.max(SHORTEST), far];
        (along[0] <= along[1]).then(|| Self {
            columns: Intervals::of(along, [lo[b], hi[b]]),
            rows: Intervals::of(along, [lo[c], hi[c]]),
        })
    }

    #[inline]
    fn misses_row(&self, v: usize) -> bool {
        self.rows.lo[v] > self.rows.hi[v]
    }

    /// Returns for each texel of a row whether it is met.
    #[inline]
    fn row(&self, v: usize) -> [bool; N] {
        let (lo, hi) = (self.rows.lo[v], self.rows.hi[v]);
        std::array::from_fn(|u| self.columns.lo[u].max(lo) <= self.columns.hi[u].min(hi))
    }
}

impl<const N: usize> Intervals<N> {
    /// * `along`: range of the component along the axis of the face, above zero.
    /// * `across`: range of the component that is divided by it.
    #[inline]
    fn of(along: [f32; 2], across: [f32; 2]) -> Self {
        let mut intervals = Self { lo: [0.0; N], hi: [0.0; N] };
        for k in 0..N {
            let (below, above) = (Faces::<N>::BELOW[k], Faces::<N>::ABOVE[k]);
            // s x ≤ hi and t x ≥ lo each bound x from below or from above, depending on the sign of
            // the edge.
            let (from_s, from_t) = (across[1] * below, across[0] * above);
            intervals.lo[k] = along[0].max(if below < 0.0 { from_s } else { 0.0 }).max(if above > 0.0 {
                from_t
            } else {
                0.0
            });
            intervals.hi[k] = along[1]
                .min(if below > 0.0 { from_s } else { f32::INFINITY })
                .min(if above < 0.0 { from_t } else { f32::INFINITY });
        }
        intervals
    }
}

/// A box around the unit vectors of a cone.
fn box_of(cone: &Cone) -> Aabb {
    if cone.is_empty() {
        return Aabb::EMPTY;
    }
    let sin = sin_of(cone.cos);
    // Largest cosine between a direction of the cone and a coordinate axis, where z is the cosine
    // between that axis and the cone's: cos(θ − β), or 1 if the coordinate axis is in the cone.
    let farthest = |z: f32| if z >= cone.cos { 1.0 } else { z * cone.cos + sin_of(z) * sin };
    let of_axis = |v: Vec3| Vec3::new(farthest(v.x), farthest(v.y), farthest(v.z)) + CONE_ROUNDING;
    Aabb { lo: -of_axis(-cone.axis), hi: of_axis(cone.axis) }
}

/// Returns true if the cones have a common direction, or nearly. The half-angle of `texel` must be
/// less than a right angle.
fn meets(cone: &Cone, texel: &Cone) -> bool {
    let (sin, texel_sin) = (sin_of(cone.cos), sin_of(texel.cos));
    // If the half-angles sum to more than π, the cones intersect for any axes.
    let reaches_all = sin * texel.cos + cone.cos * texel_sin < 0.0;
    reaches_all || cone.axis.dot(texel.axis) >= cone.cos * texel.cos - sin * texel_sin - CONE_ROUNDING
}

fn sin_of(cos: f32) -> f32 {
    ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::elementary::powf;
    use crate::rng::{Purpose, Stream};
    use crate::warp;

    const N: usize = 8;

    /// Texels by face, row and column.
    type Set = [[[bool; N]; N]; 6];

    /// Texels that `upper` reads: each is set alone.
    fn covered(towards: &Towards) -> Set {
        let mut texels = [[[Texel::ZERO; N]; N]; 6];
        let one = Texel::at_least(1.0);
        std::array::from_fn(|face| {
            std::array::from_fn(|v| {
                std::array::from_fn(|u| {
                    texels[face][v][u] = one;
                    let seen = upper(towards, &texels) == one;
                    texels[face][v][u] = Texel::ZERO;
                    seen
                })
            })
        })
    }

    fn count(set: &Set) -> usize {
        set.as_flattened().as_flattened().iter().filter(|&&met| met).count()
    }

    /// Texels that contain the direction of `d`, edges included. Edges are multiples of 1/4, so the
    /// products are exact in `f64`.
    fn texels_of(d: Vec3) -> Vec<(usize, usize, usize)> {
        let d = d.as_dvec3();
        let mut found = Vec::new();
        for face in 0..6usize {
            let a = face / 2;
            let along = if face.is_multiple_of(2) { d[a] } else { -d[a] };
            let (b, c) = (d[(a + 1) % 3], d[(a + 2) % 3]);
            let within = |k: usize, across: f64| {
                let edge = |k: usize| 2.0 * k as f64 / N as f64 - 1.0;
                edge(k) * along <= across && across <= edge(k + 1) * along
            };
            for v in (0..N).filter(|&v| along > 0.0 && within(v, c)) {
                found.extend((0..N).filter(|&u| within(u, b)).map(|u| (face, v, u)));
            }
        }
        found
    }

    /// A box of random size and position: it may be apart from the origin, contain or touch it, be
    /// flat, or lie on edges and corners of the cube.
    fn random_box(s: &mut Stream) -> Aabb {
        let mut center = warp::sphere(s.uniform_2()) * powf(10.0, 24.0 * s.uniform() - 14.0);
        match s.below(6) {
            0 => center.y = center.x,
            1 => center = Vec3::splat(center.x) * Vec3::ONE.copysign(center),
            2 => center.z = 0.0,
            _ => {}
        }
        let scale = center.length() * powf(10.0, 7.0 * s.uniform() - 6.0);
        let mut half = Vec3::from(s.uniform_3()) * scale;
        for axis in 0..3 {
            if s.below(4) == 0 {
                half[axis] = 0.0;
            }
        }
        if s.below(4) == 0 {
            half = half.min(center.abs());
            let axis = s.below(3) as usize;
            half[axis] = center[axis].abs();
        }
        Aabb { lo: center - half, hi: center + half }
    }

    /// A vector of a box: a corner, or a point on an edge, on a face, or inside.
    fn member(b: &Aabb, s: &mut Stream) -> Vec3 {
        let [x, y, z] = std::array::from_fn(|axis| match s.below(4) {
            0 => b.lo[axis],
            1 => b.hi[axis],
            _ => (b.lo[axis] + s.uniform() * (b.hi[axis] - b.lo[axis])).clamp(b.lo[axis], b.hi[axis]),
        });
        Vec3::new(x, y, z)
    }

    /// Unit vector with the rounding of `contribution`.
    fn unit(d: Vec3) -> Vec3 {
        d / d.length_squared().sqrt().max(f32::MIN_POSITIVE)
    }

    #[test]
    fn every_direction_of_a_box_falls_into_covered_texels() {
        let mut s = Stream::new(2, Purpose::Test, 0);
        for _ in 0..3000 {
            let vectors = random_box(&mut s);
            let set = covered(&Towards::Box(vectors));
            for _ in 0..50 {
                let d = member(&vectors, &mut s);
                if d.length() < 1e-17 {
                    continue;
                }
                let texels = texels_of(d);
                assert!(!texels.is_empty());
                for (face, v, u) in texels {
                    assert!(set[face][v][u], "{d:?} of {vectors:?} in texel {face} {v} {u}");
                    assert!(Faces::<N>::cone(face, v, u).contains(unit(d)), "{d:?} in texel {face} {v} {u}");
                }
            }
        }
    }

    /// Returns true if the ray from the origin along `d` meets the box; computed in `f64`.
    fn ray_meets(b: &Aabb, d: DVec3) -> bool {
        let (mut near, mut far) = (f64::from(SHORTEST), f64::INFINITY);
        for axis in 0..3 {
            let (lo, hi) = (f64::from(b.lo[axis]), f64::from(b.hi[axis]));
            if d[axis] == 0.0 {
                if lo > 0.0 || hi < 0.0 {
                    return false;
                }
            } else {
                let (p, q) = (lo / d[axis], hi / d[axis]);
                near = near.max(p.min(q));
                far = far.min(p.max(q));
            }
        }
        near <= far
    }

    /// Texels in which some ray satisfies `meets`. Each texel has a grid of `RAYS × RAYS` rays,
    /// which includes its edges and corners.
    fn met_by_rays(meets: impl Fn(DVec3) -> bool) -> Set {
        const RAYS: usize = 33;
        std::array::from_fn(|face| {
            let a = face / 2;
            let at = |k: usize, i: usize| 2.0 * (k as f64 + i as f64 / (RAYS - 1) as f64) / N as f64 - 1.0;
            std::array::from_fn(|v| {
                std::array::from_fn(|u| {
                    (0..RAYS * RAYS).any(|i| {
                        let mut d = DVec3::ZERO;
                        d[a] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
                        d[(a + 1) % 3] = at(u, i % RAYS);
                        d[(a + 2) % 3] = at(v, i / RAYS);
                        meets(d)
                    })
                })
            })
        })
    }

    /// Returns the number of texels in both sets and the number in `covered` alone. No texel may be
    /// in `met` alone.
    fn compare(covered: &Set, met: &Set, what: &Towards) -> [usize; 2] {
        let mut counts = [0; 2];
        for face in 0..6usize {
            for v in 0..N {
                for u in 0..N {
                    let (covered, met) = (covered[face][v][u], met[face][v][u]);
                    assert!(covered || !met, "{what:?} falls into texel {face} {v} {u}");
                    counts[usize::from(!met)] += usize::from(covered);
                }
            }
        }
        counts
    }

    /// Compares with ray tracing. A texel may be covered without being met if the box has only a
    /// part smaller than the grid's step in one of its corners.
    #[test]
    fn hardly_a_texel_is_covered_that_no_direction_of_the_box_falls_into() {
        let mut s = Stream::new(2, Purpose::Test, 1);
        let mut counts = [0; 2];
        for _ in 0..300 {
            let vectors = random_box(&mut s);
            if vectors.size().min_element() < 0.1 * vectors.center().length() {
                continue;
            }
            let towards = Towards::Box(vectors);
            let [both, more] =
                compare(&covered(&towards), &met_by_rays(|d| ray_meets(&vectors, d)), &towards);
            counts = [counts[0] + both, counts[1] + more];
        }
        assert!(counts[0] > 2000 && counts[1] * 100 < counts[0], "{counts:?}");
    }

    /// A single direction covers its texel, or all texels that meet at its edge or corner.
    #[test]
    fn a_single_direction_covers_one_texel() {
        let mut s = Stream::new(2, Purpose::Test, 2);
        for _ in 0..1000 {
            let d = warp::sphere(s.uniform_2());
            for towards in [Towards::Box(Aabb { lo: d, hi: d }), Towards::Cone(Cone::of(d))] {
                let set = covered(&towards);
                // If the direction is within 4·10⁻⁶ of an edge, the texel beyond is covered, too.
                // The probability of this is 10⁻⁴ for each direction.
                let (face, v, u) = texels_of(d)[0];
                assert!(set[face][v][u] && count(&set) <= 4, "{d:?} {}", count(&set));
            }
        }
        let counts = |d: Vec3| count(&covered(&Towards::Box(Aabb { lo: d, hi: d })));
        // The centre of a texel, an edge between two, and a corner of four; then an edge and a
        // corner of the cube.
        assert_eq!(counts(Vec3::new(8.0, 1.0, 1.0)), 1);
        assert_eq!(counts(Vec3::new(8.0, 2.0, 1.0)), 2);
        assert_eq!(counts(Vec3::new(-8.0, 0.0, 2.0)), 4);
        assert_eq!(counts(Vec3::new(-8.0, 8.0, 1.0)), 2);
        assert_eq!(counts(Vec3::new(1.0, -1.0, 1.0)), 3);
    }

    /// A flat box through the origin covers the texels of directions in its plane, and no others.
    #[test]
    fn a_flat_box_through_the_origin_covers_a_ring() {
        let flat = Aabb { lo: Vec3::new(-1.0, -2.0, 0.0), hi: Vec3::new(3.0, 1.0, 0.0) };
        // Two rows of texels on each of four faces.
        assert_eq!(count(&covered(&Towards::Box(flat))), 4 * 2 * N);
        let touching = Aabb { lo: Vec3::ZERO, hi: Vec3::ONE };
        // A quarter of each of three faces, and the neighbouring texels that share an edge with it.
        assert_eq!(count(&covered(&Towards::Box(touching))), 3 * (N / 2 + 1) * (N / 2 + 1));
    }

    #[test]
    fn directions_of_a_cone_fall_into_covered_texels_and_few_others_are_covered() {
        let mut s = Stream::new(2, Purpose::Test, 3);
        let mut counts = [0; 2];
        for round in 0..200 {
            let cone = Cone {
                axis: warp::sphere(s.uniform_2()),
                cos: if round % 2 == 0 {
                    1.0 - 2.0 * s.uniform()
                } else {
                    1.0 - powf(10.0, -6.0 * s.uniform())
                },
            };
            let towards = Towards::Cone(cone);
            let axis = cone.axis.as_dvec3();
            let inside = |d: DVec3| axis.dot(d) >= f64::from(cone.cos) * axis.length() * d.length();
            let [both, more] = compare(&covered(&towards), &met_by_rays(inside), &towards);
            counts = [counts[0] + both, counts[1] + more];
        }
        // The bounding cones of texels reach beyond their edges.
        assert!(counts[0] > 10_000 && counts[1] * 10 < counts[0], "{counts:?}");
    }
}
