//! Directions from a box of points to the lights of a cluster, and an upper bound of their
//! geometric term.
//!
//! The vectors `d = y − x` from points `x` of a box `P` to lights `y` of a box `L` form a box
//! again, the Minkowski difference
//!
//! ```text
//! D = [L.lo − P.hi, L.hi − P.lo]        G ≤ cos⁺(max(0, θ − β)) / max(|nearest point of D|², d_c², 10⁻²⁰)
//! ```
//!
//! Here `θ` is the least angle between a vector of `D` and the axis of the cone of directions from
//! which the lights are seen at their brightest, `β` the half-angle of that cone and `d_c` the
//! clamp distance (Walter et al. 2005, and 2006 for boxes on both sides). For lights without a
//! cosine the numerator is 1. For a spot it is 0 if no part of `D` is in its light. For a light in
//! a medium it is the largest `4π p` of its phase function. Lengths are in metres; `G` is in m⁻²,
//! or 1 for directional lights.
//!
//! # The angle between a box and an axis
//! Let `a` be the axis, `t` any unit vector orthogonal to it, `z = d·a` and `u = d·t`.
//!
//! * If `z < 0` for the whole box: the directions within `γ < π/2` of `−a` form a convex cone. A
//!   box is in that cone if its corners are, so the largest `cos θ = z/|d|` occurs at a corner.
//! * Otherwise, if `u > 0` for the whole box: `|d|² ≥ z² + u²`, hence `cot θ ≤ z/u`. As a quotient
//!   of linear functions, `z/u` is also largest at a corner.
//! * In any case `cos θ ≤ max(z) / min(|d|)`.
//!
//! `t` points to the centre of the box. The second bound would be exact if `t` pointed to the
//! vector of `D` that is nearest to the axis, which seldom differs. The sources instead bound `D`
//! by a box in a frame around `a`. That is looser, since `max(z)` and `min(u)` come from different
//! corners.
//!
//! # Guarantee
//! [`upper_geometric`] is at least the `G` of every member, in real arithmetic and in the `f32`
//! arithmetic of [`contribution`](crate::contribution). Sums of products are rounded outward by
//! [`ALONG`]; all other roundings are covered by [`COSINE`].
//!
//! # Assumptions
//! Boxes are not empty, except for directional lights. Axes of cones and directions of lights are
//! unit vectors to four roundings of `f32`. The distance between a point and a light is either zero
//! or between 10⁻¹⁷ m and 10¹⁸ m, so that its square neither underflows nor overflows.
//!
//! # Limits
//! Distance and cosine are bounded separately, although the nearest vector need not be the one with
//! the smallest angle. A child's bound can exceed its parent's if the parent's `t` happens to fit
//! better. Both bounds hold, so callers may take the smaller. If the boxes overlap, only the clamp
//! bounds `G`.
//!
//! # Held to this by
//! `bounds::tests::geometry`.

use glam::Vec4;

use super::light::upper_relative;
use super::{LightBounds, LightShape};
use crate::math::elementary::exp;
use crate::math::{Aabb, Cone, UNIT_ROUNDOFF, Vec3};

/// Vectors or directions from the points of a box to the lights of a cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Towards {
    /// The vectors from points to lights (m), not normalised, lie in this box.
    Box(Aabb),
    /// Directions to the lights.
    Cone(Cone),
    /// All directions.
    Any,
}

/// Error of the component of a corner along a vector, relative to the product of both lengths: 3
/// roundings of the dot product. A vector that should be orthogonal to an axis has 13 more because
/// of its component along the axis (3 of a dot product, 2 of a product and a difference, 8 of the
/// axis' squared length). A quotient of squares has 5 more.
const ALONG: f32 = 24.0 * UNIT_ROUNDOFF;

/// Error of a cosine. In `contribution`: 7 roundings of the unit direction and dot product, 4 of
/// the length of the light's direction. Here: 4 of the length of the axis, 8 of quotients and
/// roots, 9 of the addition theorem and of the sines that it uses.
const COSINE: f32 = 48.0 * UNIT_ROUNDOFF;

/// Relative error of a squared distance, in `contribution` and here.
const SQUARED_DISTANCE: f32 = 8.0 * UNIT_ROUNDOFF;

/// Least squared distance (m²): closer points are treated as 10⁻¹⁰ m apart, as in `contribution`.
const SMALLEST_SQUARED_DISTANCE: f32 = 1e-20;

/// Squared distance below which underflow may lose digits (m²).
const UNDERFLOW: f32 = 1e-34;

/// A box whose [`reach`] is below this is treated as having no direction (m), since squares of the
/// rounding errors of its vectors may underflow.
const NO_REACH: f32 = 1e-12;

impl Towards {
    /// Vectors or directions from the points of a box to the lights of a cluster.
    ///
    /// The box of differences is rounded outward: it contains the exact differences and those
    /// computed in `f32`.
    pub fn between(lights: &LightBounds, points: &Aabb) -> Self {
        match lights.shape {
            LightShape::Omni
            | LightShape::Oriented(_)
            | LightShape::Spot { .. }
            | LightShape::Volume { .. } => {
                let (lo, hi) = (lights.aabb.lo - points.hi, lights.aabb.hi - points.lo);
                // At least the rounding error of a difference. A difference that is subnormal or
                // zero is exact.
                Self::Box(Aabb { lo: lo - lo.abs() * f32::EPSILON, hi: hi + hi.abs() * f32::EPSILON })
            }
            LightShape::Directional(travelling) => Self::Cone(travelling.reversed()),
            LightShape::Mixed { .. } => Self::Any,
        }
    }

    /// Upper bound of `cos⁺` of the angle between any direction of `self` and any axis in `cone`; 0
    /// to 1.
    ///
    /// The bound holds for the true angle, and for cosines evaluated in `f32` unless rounding makes
    /// these exceed 1.
    pub fn upper_cos(&self, cone: &Cone) -> f32 {
        let cos = match self {
            _ if cone.is_empty() => 0.0,
            Self::Box(differences) => upper_cos_of_box(differences, cone),
            Self::Cone(directions) if directions.is_empty() => 0.0,
            Self::Cone(directions) => upper_cos_of_cone(directions, cone),
            Self::Any => 1.0,
        };
        cos.clamp(0.0, 1.0)
    }

    /// Lower and upper bound of the cosine of the angle between any direction of `self` and any
    /// axis in `cone`, both in `[-1, 1]`. The guarantee is that of [`upper_cos`](Self::upper_cos),
    /// also for angles of more than 90°.
    pub fn bounds_of_cos(&self, cone: &Cone) -> [f32; 2] {
        let upper = |cone: &Cone| match self {
            Self::Box(differences) if !cone.is_empty() => upper_cos_of_box(differences, cone),
            Self::Cone(directions) if !directions.is_empty() && !cone.is_empty() => {
                upper_cos_of_cone(directions, cone)
            }
            Self::Box(_) | Self::Cone(_) | Self::Any => 1.0,
        };
        [-upper(&cone.reversed()), upper(cone)].map(|cos| cos.clamp(-1.0, 1.0))
    }

    /// Cone that contains all directions; the whole sphere if the box contains the origin.
    pub fn cone(&self) -> Cone {
        match self {
            Self::Box(differences) => cone_of_box(differences),
            Self::Cone(directions) => *directions,
            Self::Any => Cone::ALL,
        }
    }

    /// Lower bound of the squared distance between a point and a light (m²).
    fn lower_squared_distance(&self) -> f32 {
        match self {
            Self::Box(differences) => nearest(differences).length_squared() * (1.0 - SQUARED_DISTANCE),
            Self::Cone(_) | Self::Any => 0.0,
        }
    }
}

/// Upper bound of `G` over all pairs of a light and a point (m⁻², 1 for directional lights), as
/// `contribution` evaluates it.
///
/// * `towards`: vectors or directions from the points to `lights`, by [`Towards::between`].
/// * `clamp_distance`: the distance below which `G` no longer grows (m); zero for no clamp.
pub fn upper_geometric(lights: &LightBounds, towards: &Towards, clamp_distance: f32) -> f32 {
    let shape = match lights.shape {
        LightShape::Directional(_) => return 1.0,
        LightShape::Omni => 1.0,
        LightShape::Mixed { peak } => peak,
        LightShape::Oriented(normals) => match towards {
            _ if normals.is_empty() => 0.0,
            Towards::Box(differences) => upper_cos_of_box(differences, &normals.reversed()).max(0.0),
            Towards::Cone(_) | Towards::Any => 1.0 + COSINE,
        },
        LightShape::Spot { axes, cos_outer } => match towards {
            _ if axes.is_empty() => 0.0,
            // Zero only beyond the rim by more than the error of angles computed from cosines,
            // since some fall-offs are linear in the angle.
            Towards::Box(differences)
                if upper_cos_of_box(differences, &axes.reversed()) < cos_outer - COSINE =>
            {
                0.0
            }
            // Where the fall-off is 1, its error is less than that of a cosine.
            Towards::Box(_) | Towards::Cone(_) | Towards::Any => 1.0 + COSINE,
        },
        // `directions` point along the light before it is scattered, hence the reversal.
        LightShape::Volume { directions, asymmetry } => {
            upper_relative(towards.bounds_of_cos(&directions.reversed()), asymmetry)
        }
    };
    let squared = towards.lower_squared_distance().max(clamp_distance * clamp_distance);
    let geometric = shape / squared.max(SMALLEST_SQUARED_DISTANCE);
    if matches!(lights.shape, LightShape::Mixed { .. }) { geometric.max(1.0) } else { geometric }
}

/// Relative error that is allowed for in an optical thickness and in its exponential. It is far
/// above the few roundings of a distance, a product and [`exp`].
const TRANSMITTANCE: f32 = 64.0 * UNIT_ROUNDOFF;

/// Upper bound of the transmittance between a light and a point in any channel, `exp(−σ d_min)`.
/// The extinction of the medium must be at least `σ` everywhere; `d_min` is a lower bound of the
/// distance.
///
/// * `least_extinction`: `σ`, the minimum over all channels (m⁻¹).
pub fn upper_transmittance(least_extinction: f32, towards: &Towards) -> f32 {
    let thickness = least_extinction * towards.lower_squared_distance().sqrt();
    (exp(-thickness * (1.0 - TRANSMITTANCE)) * (1.0 + TRANSMITTANCE)).min(1.0)
}

/// The point of a box nearest to the origin.
fn nearest(b: &Aabb) -> Vec3 {
    b.lo.max(Vec3::ZERO) + b.hi.min(Vec3::ZERO)
}

/// Sum over the axes of the largest magnitude of a component in a box. It is at least the distance
/// of the farthest corner from the origin.
fn reach(b: &Aabb) -> f32 {
    let largest = b.lo.abs().max(b.hi.abs());
    largest.x + largest.y + largest.z
}

/// A number for each of the eight corners of a box.
#[derive(Clone, Copy)]
struct Corners([Vec4; 2]);

impl Corners {
    /// `x + y + z` at each corner, given the terms of the lower and of the upper corner.
    #[inline(always)]
    fn sums(lo: Vec3, hi: Vec3) -> Self {
        let plane = Vec4::new(lo.x, hi.x, lo.x, hi.x) + Vec4::new(lo.y, lo.y, hi.y, hi.y);
        Self([plane + lo.z, plane + hi.z])
    }

    /// Dot products with a vector.
    #[inline(always)]
    fn along(b: &Aabb, v: Vec3) -> Self {
        Self::sums(b.lo * v, b.hi * v)
    }

    /// Squared distances from the origin.
    #[inline(always)]
    fn squared_lengths(b: &Aabb) -> Self {
        Self::sums(b.lo * b.lo, b.hi * b.hi)
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(Vec4, Vec4) -> Vec4) -> Self {
        Self([f(self.0[0], other.0[0]), f(self.0[1], other.0[1])])
    }

    #[inline(always)]
    fn smallest(self) -> f32 {
        self.0[0].min(self.0[1]).min_element()
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        self.0[0].max(self.0[1]).max_element()
    }
}

/// The cosine and sine of an angle in `[0, π]`.
#[derive(Clone, Copy)]
struct Angle {
    cos: f32,
    sin: f32,
}

impl Angle {
    const ZERO: Self = Self { cos: 1.0, sin: 0.0 };

    /// Angle of cosine `cos`; its sine has a small relative error.
    fn of_cos(cos: f32) -> Self {
        Self { cos, sin: ((1.0 - cos) * (1.0 + cos)).sqrt() }
    }

    /// `max(0, self − arccos cos)`.
    fn less(self, cos: f32) -> Self {
        if self.cos >= cos {
            return Self::ZERO;
        }
        let other = Self::of_cos(cos.max(-1.0));
        Self {
            cos: self.cos * other.cos + self.sin * other.sin,
            sin: self.sin * other.cos - self.cos * other.sin,
        }
    }
}

/// Upper bound of the signed cosine of the angle between a vector of the box and an axis in the
/// cone, which must not be empty.
fn upper_cos_of_box(b: &Aabb, cone: &Cone) -> f32 {
    angle_to_box(b, cone.axis).less(cone.cos).cos + COSINE
}

/// Lower bound of the angle between the vectors of a box and an axis.
fn angle_to_box(b: &Aabb, axis: Vec3) -> Angle {
    let reach = reach(b);
    if reach < NO_REACH {
        return Angle::ZERO;
    }
    let slack = ALONG * reach;
    let z = Corners::along(b, axis);
    let highest = z.largest() + slack;
    if highest < 0.0 {
        return angle_behind(b, z, slack);
    }
    let nearest_squared = nearest(b).length_squared();
    if nearest_squared < UNDERFLOW {
        return Angle::ZERO;
    }
    let mut cos_squared = (highest * highest / nearest_squared).min(1.0);
    let center = b.center();
    // `across` is not of unit length. Its residual component along the axis scales with the length
    // of the centre, and so does the slack.
    let across = center - axis * center.dot(axis);
    let u = Corners::along(b, across);
    let slack_across = slack * reach;
    if u.smallest() > slack_across {
        let cot = z.zip(u, |z, u| (z + slack) / (u - slack_across)).largest();
        let cot_squared = cot * cot * across.length_squared();
        // If the square overflows, the result is NaN, and `min` keeps the other bound.
        cos_squared = cos_squared.min(cot_squared / (1.0 + cot_squared));
    }
    Angle { cos: cos_squared.sqrt(), sin: (1.0 - cos_squared).sqrt() }
}

/// [`angle_to_box`] for a box that lies entirely behind the plane orthogonal to the axis. `z` are
/// the components of its corners along the axis.
fn angle_behind(b: &Aabb, z: Corners, slack: f32) -> Angle {
    let cos_squared = z.zip(Corners::squared_lengths(b), |z, squared| (z + slack) * (z + slack) / squared);
    // The sine is computed from the rounded square: near the opposite of the axis, one rounding of
    // the cosine would be a large angle.
    let cos_squared = cos_squared.smallest().min(1.0);
    Angle { cos: -cos_squared.sqrt(), sin: (1.0 - cos_squared).sqrt() }
}

/// Upper bound of the cosine of the angle between a direction of one cone and an axis of the other;
/// neither cone is empty.
fn upper_cos_of_cone(directions: &Cone, cone: &Cone) -> f32 {
    // The cosine is rounded up before the sine is computed from it, so that the angle is rounded
    // down as well.
    let between = Angle::of_cos((directions.axis.dot(cone.axis) + COSINE).min(1.0));
    between.less(directions.cos).less(cone.cos).cos + COSINE
}

/// Cone that contains the vectors of a box.
fn cone_of_box(b: &Aabb) -> Cone {
    let near = nearest(b);
    if near.length_squared() < UNDERFLOW {
        return Cone::ALL;
    }
    let squared = Corners::squared_lengths(b);
    let reach = reach(b);
    // The smallest squared cosine between a corner and the vector `v`; `None` if a corner may be
    // behind the plane orthogonal to `v`.
    let about = |v: Vec3| {
        let z = Corners::along(b, v);
        let slack = ALONG * reach * v.abs().element_sum();
        let scale = (1.0 - 16.0 * UNIT_ROUNDOFF) / v.length_squared();
        let least = z.zip(squared, |z, squared| (z - slack) / squared * ((z - slack) * scale)).smallest();
        (z.smallest() > slack).then_some(least)
    };
    let center = b.center();
    if let Some(cos_squared) = about(center) {
        let center_squared = center.length_squared();
        // The cone around the sphere of a small box is narrower than the cone of its corners with
        // their slack. For the rounding of the axis, 8 roundings are added to the sine: (s + 8u)² ≤
        // (1 + 2⁻¹⁰) s² + (1 + 2¹⁰) (8u)².
        let sine_squared = (0.25 * b.size().length_squared()) / center_squared;
        let of_sphere = 1.0 - (sine_squared * 1.001 + 2.4e-10);
        let cos = cos_squared.max(of_sphere).sqrt().next_down();
        return Cone { axis: center / center_squared.sqrt(), cos };
    }
    // The nearest vector has no component whose sign is opposite to that of a vector in the box.
    // Therefore no vector of the box is behind it.
    let cos = about(near).map_or(0.0, |cos_squared| cos_squared.sqrt().next_down());
    Cone { axis: near.normalize(), cos }
}
