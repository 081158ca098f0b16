//! Texels of a cube as sets of directions.
//!
//! Face `2a` points along the axis `a`, face `2a + 1` in the opposite direction. Let `b = a + 1`
//! and `c = a + 2` (modulo 3). A vector `d` belongs to the face if its longest component is along
//! the axis of the face. It then has the coordinates
//!
//! ```text
//! u = d_b / |d_a|,    v = d_c / |d_a|        both in [−1, 1]
//! ```
//!
//! Texel `(v, u)` of `N × N` contains the directions with `u` in `[−1 + 2u/N, −1 + 2(u+1)/N]`, and
//! likewise for `v`. A direction on an edge belongs to the texels on both sides.
//!
//! # Guarantee
//! The bounding cone of a texel contains every direction within [`WIDENING`] radians of the texel.
//! [`Faces::BELOW`] and [`Faces::ABOVE`] are outside the edges by that amount in `u`. Tested below.

use crate::math::{Cone, Vec3};

/// Amount by which bounding cones are wider than their texels (rad) and by which edges are moved.
///
/// `contribution` computes a unit vector by dividing three differences by one length. The relative
/// error of each component is `2⁻²⁴`, so the direction is off by at most that many radians.
/// `WIDENING` is sixteen times that.
const WIDENING: f64 = 1.0 / (1 << 20) as f64;

/// Bounding cones of a row of texels of the face along the third axis; `u` is along the first axis
/// and `v` along the second.
#[derive(Clone, Copy)]
pub struct Row<const N: usize> {
    /// First components of the unit axes.
    pub x: [f32; N],
    /// Second components of the unit axes.
    pub y: [f32; N],
    /// Third components of the unit axes.
    pub z: [f32; N],
    /// Cosines of the half-angles.
    pub cos: [f32; N],
}

/// Tables of a cube of `N × N` texels a face.
pub struct Faces<const N: usize>;

impl<const N: usize> Faces<N> {
    /// `1 / u` at the lower edge of each column, after the edge is moved down.
    pub const BELOW: [f32; N] = Self::reciprocal_edges(0, -WIDENING);
    /// `1 / u` at the upper edge of each column, after the edge is moved up.
    pub const ABOVE: [f32; N] = Self::reciprocal_edges(1, WIDENING);
    /// Bounding cones of all texels of the face along the third axis.
    pub const ROWS: [Row<N>; N] = Self::rows();

    /// The bounding cone of a texel.
    pub fn cone(face: usize, v: usize, u: usize) -> Cone {
        let row = &Self::ROWS[v];
        let (x, y) = (row.x[u], row.y[u]);
        let z = if face.is_multiple_of(2) { row.z[u] } else { -row.z[u] };
        let axis = match face / 2 {
            0 => Vec3::new(z, x, y),
            1 => Vec3::new(y, z, x),
            _ => Vec3::new(x, y, z),
        };
        Cone { axis, cos: row.cos[u] }
    }

    /// Components of `w` along the `u`, `v` and normal directions of a face. Scalar products of the
    /// result with the axes in [`Faces::ROWS`] equal those of `w` with the axes of the face's
    /// bounding cones.
    pub fn turned(face: usize, w: Vec3) -> Vec3 {
        let side = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        match face / 2 {
            0 => Vec3::new(w.y, w.z, side * w.x),
            1 => Vec3::new(w.z, w.x, side * w.y),
            _ => Vec3::new(w.x, w.y, side * w.z),
        }
    }

    const fn edge(k: usize) -> f64 {
        2.0 * k as f64 / N as f64 - 1.0
    }

    const fn reciprocal_edges(side: usize, moved: f64) -> [f32; N] {
        let mut reciprocals = [0.0; N];
        let mut k = 0;
        while k < N {
            // An edge at zero becomes `moved`, so nothing is divided by zero.
            reciprocals[k] = (1.0 / (Self::edge(k + side) + moved)) as f32;
            k += 1;
        }
        reciprocals
    }

    const fn rows() -> [Row<N>; N] {
        let mut rows = [Row { x: [0.0; N], y: [0.0; N], z: [0.0; N], cos: [0.0; N] }; N];
        let mut v = 0;
        while v < N {
            let mut u = 0;
            while u < N {
                let ([x, y, z], cos) = Self::bounding_cone(u, v);
                (rows[v].x[u], rows[v].y[u], rows[v].z[u], rows[v].cos[u]) = (x, y, z, cos);
                u += 1;
            }
            v += 1;
        }
        rows
    }

    /// The axis is the mean of the unit vectors to the corners; the half-angle is the largest angle
    /// between the axis and a corner. A cone of less than a right angle intersects a plane in a
    /// convex set, so it contains the texel if it contains the corners.
    const fn bounding_cone(u: usize, v: usize) -> ([f32; 3], f32) {
        let corners = [
            unit([Self::edge(u), Self::edge(v), 1.0]),
            unit([Self::edge(u + 1), Self::edge(v), 1.0]),
            unit([Self::edge(u), Self::edge(v + 1), 1.0]),
            unit([Self::edge(u + 1), Self::edge(v + 1), 1.0]),
        ];
        let mut sum = [0.0; 3];
        let mut k = 0;
        while k < 4 {
            sum = [sum[0] + corners[k][0], sum[1] + corners[k][1], sum[2] + corners[k][2]];
            k += 1;
        }
        let [x, y, z] = unit(sum);
        let axis = [x as f32, y as f32, z as f32];
        // The angle is measured from the rounded axis.
        let [x, y, z] = unit([axis[0] as f64, axis[1] as f64, axis[2] as f64]);
        let mut cos: f64 = 1.0;
        k = 0;
        while k < 4 {
            cos = cos.min(x * corners[k][0] + y * corners[k][1] + z * corners[k][2]);
            k += 1;
        }
        // cos(β + w) ≥ cos β − w
        (axis, ((cos - WIDENING) as f32).next_down())
    }
}

/// Divides a vector by its length.
const fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = root(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    [v[0] / length, v[1] / length, v[2] / length]
}

/// Square root of a number from 10⁻⁶ to 16, by Newton's iteration, since constant functions cannot
/// call `sqrt`.
const fn root(square: f64) -> f64 {
    let mut root = 0.5 * (1.0 + square);
    let mut k = 0;
    // Converges from above. Each step at least halves the error, and squares it once it is small.
    while k < 20 {
        root = 0.5 * (root + square / root);
        k += 1;
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::acos;
    use crate::rng::{Purpose, Stream};

    /// Random directions of each texel, corners included, are moved outwards by [`WIDENING`]. The
    /// bounding cone contains them and is no wider than needed.
    fn cones_hold_their_texels<const N: usize>() {
        let mut s = Stream::new(3, Purpose::Test, N as u64);
        for face in 0..6usize {
            let a = face / 2;
            for v in 0..N {
                for u in 0..N {
                    let cone = Faces::<N>::cone(face, v, u);
                    assert!((cone.axis.length() - 1.0).abs() < 2e-7);
                    let mut widest: f64 = 1.0;
                    for round in 0..20 {
                        let mut at = |k: usize, bit: u32| {
                            let inside =
                                if round < 4 { f64::from(round >> bit & 1) } else { s.uniform_f64() };
                            2.0 * (k as f64 + inside) / N as f64 - 1.0
                        };
                        let mut d = glam::DVec3::ZERO;
                        d[a] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
                        d[(a + 1) % 3] = at(u, 0);
                        d[(a + 2) % 3] = at(v, 1);
                        let w = Faces::<N>::turned(face, d.as_vec3());
                        assert_eq!(w.z, 1.0);
                        assert_eq!([w.x, w.y], [d[(a + 1) % 3] as f32, d[(a + 2) % 3] as f32]);
                        let d = d.normalize();
                        let axis = cone.axis.as_dvec3().normalize();
                        let outwards = (d - axis * axis.dot(d)).normalize();
                        let moved = (d + outwards * WIDENING).normalize();
                        assert!(axis.dot(moved) >= f64::from(cone.cos), "texel {face} {v} {u}");
                        widest = widest.min(axis.dot(d));
                    }
                    assert!(f64::from(cone.cos) > widest - 2.0 * WIDENING, "texel {face} {v} {u}");
                }
            }
        }
        let widest = Faces::<N>::ROWS.iter().flat_map(|row| row.cos).map(acos).fold(0.0, f32::max);
        // The largest texels are those in the middle of a face. Their half-angle is half a diagonal
        // of √2 · 2/N at distance 1.
        assert!(widest < 1.01 * std::f32::consts::SQRT_2 / N as f32, "{widest}");
    }

    #[test]
    fn bounding_cones_hold_their_texels_and_little_more() {
        cones_hold_their_texels::<2>();
        cones_hold_their_texels::<4>();
        cones_hold_their_texels::<8>();
        cones_hold_their_texels::<16>();
    }

    #[test]
    fn edges_are_moved_outwards() {
        for k in 0..8 {
            let edge = |k: usize| 0.25 * k as f64 - 1.0;
            let (below, above) =
                (1.0 / f64::from(Faces::<8>::BELOW[k]), 1.0 / f64::from(Faces::<8>::ABOVE[k]));
            assert!(below < edge(k) - 0.5 * WIDENING && below > edge(k) - 2.0 * WIDENING);
            assert!(above > edge(k + 1) + 0.5 * WIDENING && above < edge(k + 1) + 2.0 * WIDENING);
        }
    }
}
