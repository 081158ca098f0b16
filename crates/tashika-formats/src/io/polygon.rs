//! Triangulation of polygons.
//!
//! The polygon `p₀ … p₍ₙ₋₁₎` is projected along the axis of the largest component of its vector
//! area
//!
//! ```text
//! A = ½ Σ (pᵢ − p₀) × (pᵢ₊₁ − p₀)
//! ```
//!
//! in `f64`. A strictly convex projection is cut into a fan, any other by ear clipping (crate
//! `earcut`).
//!
//! # Guarantee
//! * Triangles use the polygon's own vertices and run in its direction.
//! * For a simple polygon, the areas of the triangles add up to that of the polygon. If they do
//!   not, the polygon crosses itself and [`Coverage::Crossing`] is returned.
//! * Time is bounded by the size of the input. Ear clipping is quadratic for polygons that cross
//!   themselves. Therefore at most [`MAX_CORNERS`] corners are clipped at a time, and
//!   [`CROSSING_BUDGET`] limits all such polygons of a file together. Beyond either limit, the
//!   polygon is cut into a fan.
//!
//! # Assumption
//! Polygons are nearly flat. If a polygon is bent so far that its projection crosses itself, it is
//! not simple.
//!
//! Held to this by the tests below and `suite::obj::concave_polygons_keep_their_area`.

use earcut::Earcut;
use glam::{DVec3, Vec3};

/// Largest number of corners up to which a polygon that is not convex is clipped; chosen, so that
/// the worst polygon takes about a second.
const MAX_CORNERS: usize = 10_000;

/// Bound on the sum of the squared corner counts of polygons that cross themselves, without small
/// ones; chosen, some seconds of work.
const CROSSING_BUDGET: u64 = 1 << 28;

/// Largest number of corners for which a polygon is always clipped: the quadratic cost is no more
/// than that of parsing it.
const SMALL: usize = 32;

/// Smallest sine of the angle of a corner in a fan. Below it, a fan could contain a triangle that
/// is too thin to render.
const MIN_SINE: f64 = 1e-5;

/// Relative difference of areas above which the triangles do not cover the polygon exactly once.
/// Rounding stays below `n · 2⁻⁵²` for `n ≤` [`MAX_CORNERS`].
const AREA_TOLERANCE: f64 = 1e-9;

/// Coverage of a polygon by its triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::io) enum Coverage {
    /// Every part is covered once, if the polygon is simple.
    Whole,
    /// The polygon crosses itself: parts may be missing or covered twice.
    Crossing,
    /// The polygon is too large for ear clipping. It became a fan, which is correct only for convex
    /// polygons.
    Fan,
}

/// Twice the vector area of a polygon (m²). Seen against this vector, the polygon runs
/// counter-clockwise.
pub(super) fn double_area(points: &[Vec3]) -> DVec3 {
    let Some((first, rest)) = points.split_first() else { return DVec3::ZERO };
    let first = first.as_dvec3();
    rest.windows(2).map(|e| (e[0].as_dvec3() - first).cross(e[1].as_dvec3() - first)).sum()
}

/// Triangulates one polygon after the other.
pub(in crate::io) struct Triangulator {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    clipped: Vec<u32>,
    budget: u64,
}

impl Triangulator {
    pub(in crate::io) fn new() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), clipped: Vec::new(), budget: CROSSING_BUDGET }
    }

    /// Appends the triangles of the polygon with corners `points` (m) to `triangles`, as indices
    /// into `points`.
    ///
    /// Polygons without area or with corners that are not finite become fans, which
    /// [`SceneBuilder`](crate::scene::SceneBuilder) repairs.
    pub(in crate::io) fn triangulate(&mut self, points: &[Vec3], triangles: &mut Vec<[u32; 3]>) -> Coverage {
        if points.len() > 3 {
            let normal = double_area(points);
            if normal.is_finite() && normal != DVec3::ZERO {
                self.project(points, normal);
                if !is_convex(&self.flat) {
                    return self.clip(triangles);
                }
            }
        }
        fan(points.len(), triangles);
        Coverage::Whole
    }

    /// Fills `flat` with the projection in which the polygon runs counter-clockwise.
    fn project(&mut self, points: &[Vec3], normal: DVec3) {
        let first = points[0].as_dvec3();
        let size = normal.abs();
        let axes = if size.x >= size.y && size.x >= size.z {
            [1, 2, 0]
        } else if size.y >= size.z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let [u, v] = if normal[axes[2]] > 0.0 { [axes[0], axes[1]] } else { [axes[1], axes[0]] };
        self.flat.clear();
        self.flat.extend(points.iter().map(|p| {
            let p = p.as_dvec3() - first;
            [p[u], p[v]]
        }));
    }

    fn clip(&mut self, triangles: &mut Vec<[u32; 3]>) -> Coverage {
        let flat = &self.flat;
        let n = flat.len();
        if n > MAX_CORNERS || (n > SMALL && self.budget == 0) {
            fan(n, triangles);
            return Coverage::Fan;
        }
        self.earcut.earcut(flat.iter().copied(), &[], &mut self.clipped);
        let mut covered = 0.0;
        for t in self.clipped.chunks_exact(3) {
            let corners = [t[0], t[1], t[2]];
            let area = signed_double_area(corners.map(|i| flat[i as usize]));
            covered += area.abs();
            // Ear clipping chooses the direction of its triangles, and may cut off triangles
            // without area.
            if area > 0.0 {
                triangles.push(corners);
            } else if area < 0.0 {
                triangles.push([corners[0], corners[2], corners[1]]);
            }
        }
        let area: f64 = flat.windows(2).map(|e| signed_double_area([flat[0], e[0], e[1]])).sum();
        if (covered - area).abs() <= AREA_TOLERANCE * area {
            return Coverage::Whole;
        }
        if n > SMALL {
            self.budget = self.budget.saturating_sub(n as u64 * n as u64);
        }
        Coverage::Crossing
    }
}

fn fan(corners: usize, triangles: &mut Vec<[u32; 3]>) {
    triangles.extend((2..corners as u32).map(|i| [0, i - 1, i]));
}

fn signed_double_area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns true if a counter-clockwise polygon is strictly convex. Then every corner turns left,
/// and the edges turn around once: their direction changes between the two half planes twice.
fn is_convex(flat: &[[f64; 2]]) -> bool {
    let edge = |from: [f64; 2], to: [f64; 2]| [to[0] - from[0], to[1] - from[1]];
    let upper = |e: [f64; 2]| e[1] > 0.0 || (e[1] == 0.0 && e[0] > 0.0);
    let n = flat.len();
    let mut before = edge(flat[n - 1], flat[0]);
    let mut changes = 0;
    for (i, &from) in flat.iter().enumerate() {
        let e = edge(from, flat[(i + 1) % n]);
        let turn = before[0] * e[1] - before[1] * e[0];
        let squares = (before[0] * before[0] + before[1] * before[1]) * (e[0] * e[0] + e[1] * e[1]);
        if turn <= 0.0 || turn * turn < MIN_SINE * MIN_SINE * squares {
            return false;
        }
        changes += u32::from(upper(before) != upper(e));
        before = e;
    }
    changes == 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::sin_cos;
    use crate::rng::{Purpose, Stream};

    fn run(points: &[Vec3]) -> (Vec<[u32; 3]>, Coverage) {
        let mut triangles = Vec::new();
        let coverage = Triangulator::new().triangulate(points, &mut triangles);
        (triangles, coverage)
    }

    /// Sum of the triangles' double areas along the polygon's normal. It equals the double area of
    /// the polygon only if all triangles run in its direction.
    fn covered(points: &[Vec3], triangles: &[[u32; 3]]) -> f64 {
        let normal = double_area(points).normalize();
        triangles
            .iter()
            .map(|t| {
                let area = double_area(&t.map(|i| points[i as usize])).dot(normal);
                assert!(area > 0.0, "triangle {t:?} is turned over");
                area
            })
            .sum()
    }

    /// A star-shaped polygon around the origin, in a plane with normal `n`.
    fn star(n: usize, frame: &crate::math::Frame, stream: &mut Stream) -> Vec<Vec3> {
        (0..n)
            .map(|i| {
                let (sin, cos) = sin_cos(i as f32 / n as f32 * std::f32::consts::TAU);
                frame.to_world(Vec3::new(cos, sin, 0.0) * (0.2 + stream.uniform()))
            })
            .collect()
    }

    #[test]
    fn simple_polygons_in_any_plane_are_covered_once_and_keep_their_direction() {
        let mut stream = Stream::new(1, Purpose::Test, 0);
        for round in 0..300 {
            let n = 4 + stream.below(60) as usize;
            let axis = Vec3::from(stream.uniform_3()) - 0.5;
            let points = star(n, &crate::math::Frame::about(axis.normalize()), &mut stream);
            let (triangles, coverage) = run(&points);
            assert_eq!(coverage, Coverage::Whole, "round {round}");
            let area = double_area(&points).length();
            // The points lie in their plane to 2⁻²³; the summation in f64 adds no visible error.
            assert!((covered(&points, &triangles) - area).abs() < 1e-6 * area, "round {round}");
        }
    }

    #[test]
    fn convex_polygons_become_fans() {
        let points: Vec<Vec3> = (0..7)
            .map(|i| {
                let (sin, cos) = sin_cos(i as f32);
                Vec3::new(cos, 0.0, sin)
            })
            .collect();
        let (triangles, coverage) = run(&points[..6]);
        assert_eq!(
            (triangles.as_slice(), coverage),
            (&[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]][..], Coverage::Whole)
        );
    }

    #[test]
    fn straight_corners_and_repeated_points_leave_no_thin_triangle() {
        let p = |x: f32, y: f32| Vec3::new(x, y, 3.0);
        let square = [p(0., 0.), p(1., 0.), p(2., 0.), p(2., 2.), p(2., 2.), p(1., 2.), p(0., 2.), p(0., 1.)];
        let (triangles, coverage) = run(&square);
        assert_eq!((covered(&square, &triangles), coverage), (8.0, Coverage::Whole));
    }

    #[test]
    fn a_hole_cut_open_by_a_bridge_stays_a_hole() {
        let p = |x: f32, y: f32| Vec3::new(x, 1.0, -y);
        let corners = [
            (0., 0.),
            (4., 0.),
            (4., 4.),
            (0., 4.),
            (0., 0.),
            (1., 1.),
            (1., 2.),
            (2., 2.),
            (2., 1.),
            (1., 1.),
        ];
        let points = corners.map(|(x, y)| p(x, y));
        let (triangles, coverage) = run(&points);
        assert_eq!((covered(&points, &triangles), coverage), (30.0, Coverage::Whole));
    }

    #[test]
    fn crossing_polygons_are_told() {
        let p = |x: f32, y: f32| Vec3::new(x, y, 0.0);
        let (_, pentagram) = run(&[0, 2, 4, 1, 3].map(|i| {
            let (sin, cos) = sin_cos(i as f32 * std::f32::consts::TAU / 5.0);
            p(cos, sin)
        }));
        assert_eq!(pentagram, Coverage::Crossing);
        let (_, bow_tie) = run(&[p(0., 0.), p(3., 0.), p(0., 1.), p(1., 1.)]);
        assert_eq!(bow_tie, Coverage::Crossing);
    }

    #[test]
    fn polygons_beyond_the_limits_are_fans() {
        let zigzag = |n: usize| -> Vec<Vec3> {
            let height = |i: usize| if i == 0 || i == n - 1 { -1.0 } else { (i % 2) as f32 };
            (0..n).map(|i| Vec3::new(i as f32, height(i), 0.0)).collect()
        };
        let (triangles, coverage) = run(&zigzag(MAX_CORNERS + 2));
        assert_eq!((triangles.len(), coverage), (MAX_CORNERS, Coverage::Fan));

        let mut triangulator = Triangulator { budget: 3 * 200 * 200 - 1, ..Triangulator::new() };
        let mut stream = Stream::new(2, Purpose::Test, 0);
        let crossing: Vec<Vec3> =
            (0..200).map(|_| Vec3::new(stream.uniform(), stream.uniform(), 0.0)).collect();
        let outcomes = [(); 5].map(|()| triangulator.triangulate(&crossing, &mut Vec::new()));
        let (c, f) = (Coverage::Crossing, Coverage::Fan);
        assert_eq!(outcomes, [c, c, c, f, f]);
        let small = triangulator.triangulate(&zigzag(SMALL), &mut Vec::new());
        assert_eq!(small, Coverage::Whole, "small ones are clipped");
    }

    #[test]
    fn polygons_without_area_or_finite_corners_are_fans() {
        for bad in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
            let (triangles, coverage) = run(&[Vec3::X, bad, bad, bad, Vec3::X]);
            assert_eq!((triangles.len(), coverage), (3, Coverage::Whole));
        }
    }
}
