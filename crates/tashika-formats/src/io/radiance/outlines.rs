//! Area of a surface as it is seen from a direction, and points that stand for equal shares of the
//! surface.
//!
//! A polygon is divided into triangles, a ring into two circles of equal area, a cylinder along its
//! axis; a sphere is its centre.
//!
//! Held to this by the tests in `tests`.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::surfaces::{Geometry, Quadric, triangulate};
use crate::io::polygon::Triangulator;
use crate::math::elementary::sin_cos_f64;

/// Longest side of the triangles that a point stands for, in the size of the surface.
const COARSE: f64 = 0.3;

/// Form of a surface: the area that is seen from a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Outline {
    Flat(DVec3),
    Ball,
    Tube(DVec3),
}

impl Outline {
    /// Share of the surface's largest visible area that is seen from the unit direction `ω`.
    pub(super) fn seen(self, direction: DVec3) -> f64 {
        match self {
            Self::Flat(normal) => normal.dot(direction).max(0.0),
            Self::Ball => 1.0,
            Self::Tube(axis) => (1.0 - axis.dot(direction) * axis.dot(direction)).max(0.0).sqrt(),
        }
    }

    pub(super) fn turned(self, turn: DMat3) -> Self {
        match self {
            Self::Flat(normal) => Self::Flat(turn * normal),
            Self::Ball => Self::Ball,
            Self::Tube(axis) => Self::Tube(turn * axis),
        }
    }

    /// Numbers that are equal for outlines that are equal within rounding.
    pub(super) fn key(self) -> [i64; 4] {
        let of = |kind: i64, v: DVec3| {
            let [x, y, z] = (v * 1e4).round().to_array().map(|v| v as i64);
            [kind, x, y, z]
        };
        match self {
            Self::Flat(normal) => of(0, normal),
            Self::Ball => of(1, DVec3::ZERO),
            Self::Tube(axis) => of(2, axis),
        }
    }
}

/// Largest visible area of a surface (m²), its outline, and points that stand for equal shares.
pub(super) fn outline(geometry: &Geometry) -> Option<(f64, Outline, Vec<DVec3>)> {
    match geometry {
        Geometry::Polygon(corners) => {
            let (triangles, _) = triangulate(&mut Triangulator::new(), corners);
            let corners_of = |t: [u32; 3]| t.map(|i| corners[i as usize]);
            let double = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
            let normal: DVec3 = triangles.iter().map(|t| double(corners_of(*t))).sum();
            let area = 0.5 * normal.length();
            let coarse = COARSE * area.sqrt();
            let mut weighted = Vec::new();
            for t in triangles {
                divide(corners_of(t), coarse, 6, &mut weighted);
            }
            Some((area, Outline::Flat(normal.try_normalize()?), equal_shares(&weighted)))
        }
        Geometry::Quadric { shape, to_world, faces_inward } => {
            let [x, y, z] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis, to_world.matrix3.z_axis];
            let radius = x.length();
            match shape {
                Quadric::Ring(inner) => {
                    let inner = f64::from(*inner);
                    let area = PI * radius * radius * (1.0 - inner * inner);
                    let point = |i: u32| {
                        let (sin, cos) = sin_cos_f64(f64::from(i % 8) * PI / 4.0 + f64::from(i / 8) * 0.4);
                        // Two circles, each in the middle of half the area.
                        let share = 0.25 + 0.5 * f64::from(i / 8);
                        let r = (inner * inner + (1.0 - inner * inner) * share).sqrt();
                        to_world.translation + (x * cos + y * sin) * r
                    };
                    let normal = if *faces_inward { -z } else { z };
                    Some((area, Outline::Flat(normal.try_normalize()?), (0..16).map(point).collect()))
                }
                Quadric::Sphere if !faces_inward => {
                    Some((PI * radius * radius, Outline::Ball, vec![to_world.translation]))
                }
                Quadric::Cylinder if !faces_inward => {
                    let points = (0..8).map(|i| to_world.translation + z * ((f64::from(i) + 0.5) / 8.0));
                    Some((2.0 * radius * z.length(), Outline::Tube(z.try_normalize()?), points.collect()))
                }
                _ => None,
            }
        }
    }
}

/// Divides a triangle until its sides are at most `coarse` long, `depth` times at most; adds the
/// centre and the area of each part.
fn divide([a, b, c]: [DVec3; 3], coarse: f64, depth: u32, parts: &mut Vec<(DVec3, f64)>) {
    let sides = [(b - a).length(), (c - b).length(), (a - c).length()];
    let longest = sides.iter().copied().fold(0.0, f64::max);
    if depth == 0 || longest <= coarse {
        parts.push(((a + b + c) / 3.0, 0.5 * (b - a).cross(c - a).length()));
        return;
    }
    let [p, q, r] = if sides[0] == longest {
        [a, b, c]
    } else if sides[1] == longest {
        [b, c, a]
    } else {
        [c, a, b]
    };
    let middle = 0.5 * (p + q);
    divide([p, middle, r], coarse, depth - 1, parts);
    divide([middle, q, r], coarse, depth - 1, parts);
}

/// Most points that stand for a polygon.
const MAX_POINTS: usize = 32;

/// Centres of parts whose areas differ little, each for an equal share of the total area.
fn equal_shares(parts: &[(DVec3, f64)]) -> Vec<DVec3> {
    let total: f64 = parts.iter().map(|part| part.1).sum();
    let count = parts.len().min(MAX_POINTS);
    let (mut points, mut passed) = (Vec::new(), 0.0);
    for (center, area) in parts {
        passed += area;
        // The next point is due when half of its share has passed.
        while points.len() < count && passed >= (points.len() as f64 + 0.5) * total / count as f64 {
            points.push(*center);
        }
    }
    points
}
