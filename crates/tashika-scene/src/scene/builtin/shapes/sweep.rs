//! Outlines swept along curves.
//!
//! The frames along the curve rotate around it as little as possible (double reflection; Wang,
//! Jüttler, Zheng, Liu 2008, "Computation of Rotation Minimizing Frames", ACM TOG 27(1)). On a
//! closed curve the remaining angle between first and last frame is spread evenly.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::{Ends, Shape, grid};
use crate::math::elementary::{atan2, powf, rotation, sin_cos};

/// Outline that is swept along a curve.
#[derive(Clone, Debug)]
pub struct Section {
    /// Points counter-clockwise around the origin (m): first coordinate along `up`, second along
    /// `tangent × up`.
    pub outline: Vec<Vec2>,
    /// Direction of the first coordinate at the start of the curve; not along its tangent.
    pub up: Vec3,
}

impl Section {
    /// Creates a superellipse of half axes `half` (m): exponent 1 is an ellipse, towards 0 a
    /// rectangle.
    pub fn superellipse(half: Vec2, exponent: f32, sides: usize, up: Vec3) -> Self {
        let power = |x: f32| if x.abs() < 1e-6 { 0.0 } else { powf(x.abs(), exponent).copysign(x) };
        let outline = (0..sides)
            .map(|i| {
                let (sin, cos) = sin_cos(TAU * i as f32 / sides as f32);
                half * Vec2::new(power(cos), power(sin))
            })
            .collect();
        Self { outline, up }
    }
}

/// Sweeps `section`, scaled by `scale(t)` with `t` from 0 to 1 by index, along `path` (at least 2
/// points, no two neighbours equal). Open ends get flat caps; joined ends do not repeat the first
/// point.
pub fn sweep(path: &[Vec3], ends: Ends, section: &Section, scale: impl Fn(f32) -> f32) -> Shape {
    let frames = frames(path, ends, section.up);
    let sides = section.outline.len();
    let count = path.len();
    let ring = |i: usize, k: usize| {
        let (tangent, up) = frames[k];
        let o = section.outline[i] * scale(k as f32 / (count - 1) as f32);
        path[k] + up * o.x + tangent.cross(up) * o.y
    };
    match ends {
        Ends::Joined => grid([sides, count], [Ends::Joined; 2], ring),
        // The rows are: the centre of the first cap; its rim, twice, which makes a crease; the
        // points of the curve; and likewise the rim and the centre of the last cap.
        Ends::Open => grid([sides, count + 3], [Ends::Joined, Ends::Open], |i, j| match j {
            0 => path[0],
            j if j == count + 3 => path[count - 1],
            j => ring(i, j.saturating_sub(2).min(count - 1)),
        }),
    }
}

/// Creates a round tube of `radius(t)` (m), `t` from 0 to 1 by index, along `path`.
pub fn tube(path: &[Vec3], ends: Ends, sides: usize, radius: impl Fn(f32) -> f32) -> Shape {
    let tangent = (path[1] - path[0]).normalize();
    let up = tangent.any_orthonormal_vector();
    sweep(path, ends, &Section::superellipse(Vec2::ONE, 1.0, sides, up), radius)
}

/// Creates a `(p, q)` torus knot around the `y` axis: a tube of radius `tube_radius` around a curve
/// on a torus of radii `major` and `minor` (m).
pub fn torus_knot(windings: [u32; 2], radii: [f32; 2], tube_radius: f32, cells: [usize; 2]) -> Shape {
    let [p, q] = windings.map(|w| w as f32);
    let [major, minor] = radii;
    let path: Vec<Vec3> = (0..cells[0])
        .map(|k| {
            let t = TAU * k as f32 / cells[0] as f32;
            let (sin_p, cos_p) = sin_cos(p * t);
            let (sin_q, cos_q) = sin_cos(q * t);
            let r = major + minor * cos_q;
            Vec3::new(r * cos_p, minor * sin_q, r * sin_p)
        })
        .collect();
    tube(&path, Ends::Joined, cells[1], |_| tube_radius)
}

/// Returns unit tangent and `up` at each point of `path`.
fn frames(path: &[Vec3], ends: Ends, up: Vec3) -> Vec<(Vec3, Vec3)> {
    let count = path.len();
    let tangent = |k: usize| {
        let (before, after) = match ends {
            Ends::Open => (k.saturating_sub(1), (k + 1).min(count - 1)),
            Ends::Joined => ((k + count - 1) % count, (k + 1) % count),
        };
        (path[after] - path[before]).normalize()
    };
    let first = tangent(0);
    let up = (up - first * up.dot(first)).normalize();
    let mut frames = vec![(first, up)];
    for k in 1..count {
        frames.push(transported(path[k] - path[k - 1], frames[k - 1], tangent(k)));
    }
    if ends == Ends::Joined {
        let (tangent, back) = transported(path[0] - path[count - 1], frames[count - 1], first);
        let angle = atan2(back.cross(up).dot(tangent), back.dot(up));
        for (k, (tangent, up)) in frames.iter_mut().enumerate() {
            *up = rotation(*tangent, angle * k as f32 / count as f32) * *up;
        }
    }
    frames
}

/// Moves a frame by `step` to a point with the tangent `tangent`, by two reflections.
fn transported(step: Vec3, (old_tangent, old_up): (Vec3, Vec3), tangent: Vec3) -> (Vec3, Vec3) {
    let reflect = |v: Vec3, across: Vec3| v - across * (2.0 * v.dot(across) / across.length_squared());
    let (t, up) = (reflect(old_tangent, step), reflect(old_up, step));
    let across = tangent - t;
    let up = if across.length_squared() > 1e-12 { reflect(up, across) } else { up };
    (tangent, (up - tangent * up.dot(tangent)).normalize())
}
