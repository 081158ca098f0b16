//! Surfaces of revolution and similar shapes.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Vec2, Vec3};

use super::{Ends, Shape, grid};
use crate::math::elementary::{powf, sin_cos};

/// Revolves `profile`, points (radius, height) in metres from bottom to top, about the `y` axis.
///
/// The front is the outside for a profile that runs upwards. A point given twice is a crease; a
/// radius of 0 at an end closes the surface there.
pub fn lathe(profile: &[Vec2], segments: usize) -> Shape {
    grid([segments, profile.len() - 1], [Ends::Joined, Ends::Open], |i, j| {
        // Angles run clockwise as seen from above, so that the front is outside.
        let (sin, cos) = sin_cos(-TAU * i as f32 / segments as f32);
        let Vec2 { x: radius, y: height } = profile[j];
        // Adding zero turns −0 into 0, so that all vertices of a pole compare as equal.
        Vec3::new(radius * cos + 0.0, height, radius * sin + 0.0)
    })
}

/// Returns the profile with a crease at every point except its ends.
pub fn creased(points: &[[f32; 2]]) -> Vec<Vec2> {
    let last = points.len() - 1;
    points
        .iter()
        .enumerate()
        .flat_map(|(i, &p)| vec![p.into(); if i == 0 || i == last { 1 } else { 2 }])
        .collect()
}

/// Creates a closed cylinder around the `y` axis from height 0 to `height`, with sharp rims.
pub fn cylinder(radius: f32, height: f32, segments: usize) -> Shape {
    lathe(&creased(&[[0.0, 0.0], [radius, 0.0], [radius, height], [0.0, height]]), segments)
}

/// Creates a flat disk centred at the origin; its front is `+y`.
pub fn disk(radius: f32, segments: usize) -> Shape {
    lathe(&[Vec2::new(radius, 0.0), Vec2::ZERO], segments)
}

/// Creates a sphere centred at the origin.
pub fn sphere(radius: f32, segments: usize, rows: usize) -> Shape {
    let profile: Vec<Vec2> = (0..=rows)
        .map(|j| {
            let (sin, cos) = sin_cos(PI * j as f32 / rows as f32);
            let pole = j == 0 || j == rows;
            Vec2::new(if pole { 0.0 } else { radius * sin }, -radius * cos)
        })
        .collect();
    lathe(&profile, segments)
}

/// Creates a torus around the `y` axis: a circle of radius `minor` around one of radius `major`
/// (m).
pub fn torus(major: f32, minor: f32, segments: usize, sides: usize) -> Shape {
    grid([segments, sides], [Ends::Joined; 2], |i, j| {
        let (sin, cos) = sin_cos(-TAU * i as f32 / segments as f32);
        let (up, out) = sin_cos(TAU * j as f32 / sides as f32);
        let radius = major + minor * out;
        Vec3::new(radius * cos, minor * up, radius * sin)
    })
}

/// Creates a superellipsoid centred at the origin (Barr 1981), half axes `half` (m).
///
/// `exponents` are those of the profile and of the horizontal section: 1 is an ellipse, towards 0 a
/// rectangle, 2 a rhombus.
pub fn superellipsoid(half: Vec3, exponents: [f32; 2], segments: usize, rows: usize) -> Shape {
    // The computed cosine of a right angle is tiny but not zero. With a small exponent its power
    // would be far from zero.
    let power = |x: f32, e: f32| if x.abs() < 1e-6 { 0.0 } else { powf(x.abs(), e).copysign(x) };
    grid([segments, rows], [Ends::Joined, Ends::Open], |i, j| {
        let (sin_v, cos_v) = sin_cos(PI * j as f32 / rows as f32 - FRAC_PI_2);
        let (sin_u, cos_u) = sin_cos(-TAU * i as f32 / segments as f32);
        let ring = power(cos_v, exponents[0]);
        let unit = Vec3::new(
            ring * power(cos_u, exponents[1]) + 0.0,
            power(sin_v, exponents[0]),
            ring * power(sin_u, exponents[1]) + 0.0,
        );
        half * unit
    })
}
