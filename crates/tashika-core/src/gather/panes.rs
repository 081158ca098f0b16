//! Light from infinitely far away through panes of solid glass.
//!
//! A body of glass with parallel faces shifts a path and keeps its direction. So a path that starts
//! at a point `x` towards a light in the direction `d`, and is refracted at every face, reaches the
//! light:
//!
//! ```text
//! L(x, d) = Π_k (1 − F_k) τ_k · L_∞(d)          over the faces k that it meets, for light that no face reflects
//! ```
//!
//! with the Fresnel reflectance `F` and the tint `τ` of a face. The solid angle is the same on both
//! sides, so there is no other factor. Light that a face reflects, and light whose direction the
//! glass changes, are found only by paths that draw their directions.
//!
//! # Two strategies
//! A path to the light is the same whether its direction at `x` is drawn towards the light or by
//! the BSDF. The two strategies are weighted by their densities of the direction at `x`
//! ([`balance`](crate::warp::balance)). So a path records whether it reached the environment
//! [through panes](Passage).
//!
//! # Held to this by
//! The suite's `panes`.

use crate::accel::Tracer;
use crate::color::Rgb;
use crate::math::Vec3;
use crate::media::{Leg, MOST_PASSED};
use crate::rng::Stream;

use super::{Scatter, SpecularPoint};

/// Largest difference between unit directions that count as equal: the rounding errors of the
/// normals of two faces amount to a hundredth of it.
const SAME: f32 = 1e-4;

/// Passage of a path through surfaces, since its direction was drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passage {
    /// The direction is unchanged, perhaps through thin glass.
    Straight,
    /// Smooth faces of glass, and nothing else, have refracted the path.
    Refracted,
    /// The path was reflected, or refracted by rough glass.
    Bent,
}

impl Passage {
    /// Returns the passage beyond a specular surface that the path leaves along `direction`.
    #[must_use]
    pub fn beyond(self, surface: &SpecularPoint, direction: Vec3) -> Self {
        match self {
            _ if surface.passes_straight(direction) => self,
            Self::Straight | Self::Refracted if surface.refracts(direction) => Self::Refracted,
            _ => Self::Bent,
        }
    }

    /// Returns true if the direction is unchanged.
    pub fn is_straight(self) -> bool {
        self == Self::Straight
    }

    /// Returns true if a path came through panes: after refractions, its unit `direction` equals
    /// the direction `drawn` at its start.
    pub fn is_through_panes(self, drawn: Vec3, direction: Vec3) -> bool {
        self == Self::Refracted && drawn.distance_squared(direction) < SAME * SAME
    }
}

/// Returns the transmittance of the faces and media along the ray of `leg` to a light that is
/// infinitely far away; `None` if the ray meets no pane, or is blocked.
///
/// * `key`, `share`: key for the decisions of rays at partly opaque surfaces, and time as a share
///   of the shutter interval.
/// * `most`: one more than the number of specular surfaces that a path may meet.
/// * `rays`: increased by the number of rays traced.
///
/// The transmittance of media is an unbiased estimate ([`Leg::fly`]).
pub fn through_panes(
    tracer: &Tracer,
    mut leg: Leg,
    (key, share): (u64, f32),
    most: u32,
    stream: &mut Stream,
    rays: &mut u64,
) -> Option<Rgb> {
    let scene = tracer.scene();
    let drawn = leg.ray.direction;
    let (mut weight, mut ratio, mut passage) = (Rgb::WHITE, 1.0, Passage::Straight);
    let (mut step, mut passed) = (0, 0);
    while step < most && passed < MOST_PASSED {
        *rays += 1;
        let hit = tracer.closest_hit_at(&leg.ray, key.wrapping_add(step.into()), share);
        let (left, scattering) = leg.fly(scene, hit.as_ref(), weight, stream);
        if scattering.is_some() || left.is_black() {
            return None;
        }
        weight = left;
        let Some(hit) = hit else {
            // A single boundary that is met at a right angle changes no direction, and is no pane.
            let is_outside = f64::abs(ratio - 1.0) < 1e-3;
            let arrives = is_outside && passage.is_through_panes(drawn, leg.ray.direction);
            return arrives.then_some(weight);
        };
        let surface = scene.surface_point_at(share, hit.instance, hit.triangle, hit.barycentric);
        if scene.is_boundary(&surface) {
            leg = leg.beyond(scene, &surface);
            passed += 1;
            continue;
        }
        let Scatter::Specular(face) = Scatter::at(scene, &surface, -leg.ray.direction, stream.uniform())
        else {
            return None;
        };
        let (next, factor) = face.transmit()?;
        passage = passage.beyond(&face, next.direction);
        weight *= factor;
        ratio *= face.squared_ratio(next.direction);
        leg = leg.onward(scene, &surface, next);
        step += 1;
        passed = 0;
    }
    None
}
