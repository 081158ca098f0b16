//! Extremes of the angles that a lobe depends on, over a cone of light directions and cones of
//! normals and viewers.
//!
//! Let `m` be the mirror direction of `ω_o` about the normal `n`, `h` the direction of `ω_o + ω_i`,
//! `a` the axis of the lights and `δ` their half-angle. A bar marks the axis of the cone around a
//! set of points' directions; `ω`, `ν` and `μ` are the half-angles around `ō`, `n̄` and `m̄`.
//!
//! ```text
//! ∠(ω_i, m) ≥ ∠(a, m̄) − δ − μ
//! ∠(h, n)   ≥ ½ ∠(ω_i, m)                                          reflecting at h, then back at n, turns by twice their angle
//! ∠(h, n)   ≥ ∠(ō + a, n̄) − ν − arcsin(r / ‖ō + a‖)                r = 2 sin(δ/2) + 2 sin(ω/2): ω_o + ω_i lies in a ball about ō + a
//! ∠(ω_i, ω_o) ≤ min(∠(ō, a) + δ + ω, θ_o + π/2)
//! ```
//!
//! Both bounds of `∠(h, n)` hold, and the larger is used. The first is exact if `ω_i` leaves the
//! mirror direction in the plane of incidence, the second if it leaves orthogonally to that plane.
//! The second matters at grazing angles, where the lobe is long and narrow.
//!
//! Light from below the horizon is not reflected, so only the part above the horizon has to be
//! bounded. If `z = a·n̄ < 0`, then `ω_i·n̄ ≥ −sin ν` and `ω_i·a ≥ cos δ` imply
//! `ω_i·a_t ≥ cos δ − |z| sin ν`, where `a_t` is the projection of `a` onto the plane. This is a
//! cone around `a_t`.
//!
//! # Guarantee
//! The angles and the cosines of incidence are at most those of any members, in the `f32`
//! arithmetic of [`contribution`](crate::contribution). Directions in that arithmetic are of length
//! 1 to 10⁻⁶, which rotates `h` by up to [`LENGTHS`]` / ‖ω_o + ω_i‖`.
//!
//! # Held to this by
//! The tests below, `bounds::tests::reflector`, `bounds::tests::analytic`.

use glam::DVec3;

use super::angle::{Angle, TURN};
use crate::math::Cone;

/// Largest distance between the sum of two directions and the sum of the corresponding unit
/// vectors: 10⁻⁶ for the rounding of each, plus some room.
pub(super) const LENGTHS: f64 = 3e-6;

/// A cone of directions in double precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bundle {
    axis: DVec3,
    half_angle: Angle,
}

impl Bundle {
    /// Bundle of the single unit vector `axis`.
    pub(super) fn one(axis: DVec3) -> Self {
        Self { axis, half_angle: Angle::ZERO }
    }

    /// Directions of a cone that is not empty.
    pub(super) fn of(cone: &Cone) -> Self {
        Self { axis: cone.axis.as_dvec3(), half_angle: Angle::half_angle(cone) }
    }

    /// Directions within `half_angle` of the unit vector `axis`, widened for rounding.
    pub(super) fn about(axis: DVec3, half_angle: Angle) -> Self {
        Self { axis, half_angle: half_angle.plus(TURN) }
    }

    /// Lower bound of the angle between a member of `self` and one of `other`.
    pub(super) fn least_angle(&self, other: &Self) -> Angle {
        Angle::between(self.axis, other.axis).minus(self.half_angle).minus(other.half_angle)
    }

    /// Upper bound of the angle between a member of `self` and one of `other`.
    pub(super) fn widest_angle(&self, other: &Self) -> Angle {
        Angle::between(self.axis, other.axis).plus(self.half_angle).plus(other.half_angle)
    }

    /// Returns a narrower bundle that contains those members that are above the plane of at least
    /// one normal; `None` if no such bundle is known.
    ///
    /// The result may contain directions that are not in `self`.
    pub(super) fn above(&self, normals: &Self) -> Option<Self> {
        let tilt = normals.half_angle.plus(TURN);
        if tilt.cos <= 0.0 {
            return None;
        }
        // A right angle plus ν.
        let hemisphere = Angle { sin: tilt.cos, cos: -tilt.sin };
        if self.half_angle.cos < hemisphere.cos {
            return Some(Self { axis: normals.axis, half_angle: hemisphere });
        }
        let z = self.axis.dot(normals.axis);
        if z >= 0.0 {
            return None;
        }
        let across = self.axis - normals.axis * z;
        let length = across.length();
        // The axis is of length 1 only to 10⁻⁷, an error as large as `1 − cos δ` of narrow bundles.
        let projected = self.half_angle.cos * self.axis.length() + z * tilt.sin;
        (projected > self.half_angle.cos * length)
            .then(|| Self { axis: across / length, half_angle: Angle::of_cos(projected / length) })
    }
}

/// Directions of a set of gather points; none of the cones is empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directions {
    /// Shading normals of the points.
    pub(super) normals: Bundle,
    /// Directions to the viewer.
    pub(super) viewers: Bundle,
    /// Mirror directions of the viewers.
    pub(super) mirrors: Bundle,
    /// Upper bound of the angle between a normal and its viewer.
    pub(super) widest_viewer: Angle,
}

impl Directions {
    /// Directions of one point in its own frame.
    pub(super) fn of_point(viewer: DVec3) -> Self {
        let mirror = DVec3::new(-viewer.x, -viewer.y, viewer.z);
        Self {
            normals: Bundle::one(DVec3::Z),
            viewers: Bundle::one(viewer),
            mirrors: Bundle::one(mirror),
            widest_viewer: Angle::between(viewer, DVec3::Z).plus(TURN),
        }
    }
}

impl Directions {
    /// Lower bound of the angle between any normal and any mirror direction.
    pub(super) fn least_mirror(&self) -> Angle {
        self.mirrors.least_angle(&self.normals)
    }
}

/// Lower bound of the angle between any mirror direction and any light that is in all of `lights`.
pub(super) fn least_from_mirror(points: &Directions, lights: &[Option<Bundle>]) -> Angle {
    let lights = lights.iter().flatten();
    lights.fold(Angle::ZERO, |least, lights| least.max(lights.least_angle(&points.mirrors)))
}

/// Bounds of the angles of half vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfVectors {
    /// Lower bound of the angle between a half vector and its normal.
    pub(super) least_from_normal: Angle,
    /// Lower bound of the cosine of the angle of incidence on a facet.
    pub(super) cos_incidence: f64,
}

impl HalfVectors {
    /// Bounds for lights that are in all of `lights` and at least `from_mirror` from any mirror
    /// direction.
    pub(super) fn new(points: &Directions, lights: &[Option<Bundle>], from_mirror: Angle) -> Self {
        let nothing = Self { least_from_normal: Angle::ZERO, cos_incidence: 0.0 };
        let known = lights.iter().flatten().fold(nothing, |known, lights| {
            let other = Self::over(points, lights);
            Self {
                least_from_normal: known.least_from_normal.max(other.least_from_normal),
                cos_incidence: known.cos_incidence.max(other.cos_incidence),
            }
        });
        let by_mirror = minus_arcsin(|| from_mirror.half(), LENGTHS, 2.0 * known.cos_incidence);
        Self { least_from_normal: known.least_from_normal.max(by_mirror), ..known }
    }

    /// Bounds for one bundle of lights, ignoring their angle from mirror directions.
    fn over(points: &Directions, lights: &Bundle) -> Self {
        let Directions { normals, viewers, widest_viewer, .. } = points;
        let horizon = Angle { sin: widest_viewer.cos.max(0.0), cos: -widest_viewer.sin };
        let widest = lights.widest_angle(viewers).min(horizon.plus(TURN));
        let cos_incidence = (widest.half().cos - LENGTHS).max(0.0);
        let sum = viewers.axis + lights.axis;
        let length = sum.length();
        let radius = lights.half_angle.chord() + viewers.half_angle.chord() + LENGTHS;
        let angle = || Angle::between(sum / length, normals.axis).minus(normals.half_angle).minus(TURN);
        Self { least_from_normal: minus_arcsin(angle, radius, length), cos_incidence }
    }
}

/// `max(0, angle − arcsin(radius / distance))`; zero if the ball of that radius contains the
/// origin.
fn minus_arcsin(angle: impl Fn() -> Angle, radius: f64, distance: f64) -> Angle {
    if radius >= distance { Angle::ZERO } else { angle().minus(Angle::of_sin(radius / distance)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::microfacet::HalfVector;
    use crate::math::Vec3;
    use crate::math::elementary::powf;
    use crate::rng::{Purpose, Stream};
    use crate::warp;

    /// Single directions without slack, whose lengths are not exactly 1. The bounds hold.
    #[test]
    fn lengths_of_directions_are_allowed_for() {
        let mut s = Stream::new(43, Purpose::Test, 0);
        for _ in 0..200_000 {
            let mut grazing = || {
                let local = warp::cone(s.uniform_2(), 0.0);
                Vec3::new(local.x, local.y, local.z * powf(1e-4, s.uniform())).normalize()
            };
            let (wo, other) = (grazing(), grazing());
            let wide = powf(1e-4, s.uniform());
            let wi = (Vec3::new(-wo.x, -wo.y, wo.z) * (1.0 - wide) + other * wide).normalize();
            let points = Directions::of_point(wo.as_dvec3());
            let lights = [Some(Bundle::one(wi.as_dvec3()))];
            let known = HalfVectors::new(&points, &lights, least_from_mirror(&points, &lights));
            let half = HalfVector::between(wo, wi.to_array());
            assert!(f64::from(half.cos_incidence()) >= known.cos_incidence, "{wo} {wi}");
            let tan = f64::from(half.tangential2 / half.axial2).sqrt();
            let Angle { sin, cos } = known.least_from_normal;
            assert!(cos > 0.0 && tan * (1.0 + 1e-6) >= sin / cos, "{wo} {wi}: {tan} below {}", sin / cos);
        }
    }
}
