//! The material of one gather point, and upper bounds of its BRDF over a cone of light directions.
//!
//! ```text
//! upper_brdf      ≥ max over ω_i in the cone of f_r(ω_o, ω_i)             (sr⁻¹, largest channel)
//! upper_brdf_cos  ≥ max over ω_i in the cone of f_r(ω_o, ω_i) cos⁺θ_i
//! ```
//!
//! Both are sums of bounds of the diffuse part, the lobe and the coat ([`lobes`](super::lobes)).
//! The extremes of angles over the cone are computed by [`spans`](super::spans).
//!
//! # Guarantee
//! The bounds are at least every value in the `f32` arithmetic of
//! [`contribution`](crate::contribution), for any unit direction (to rounding) in the cone. They
//! are zero if the cone is certainly below the plane of either normal, and always finite.
//!
//! # Held to this by
//! `bounds::tests::reflector`.

use glam::DVec3;

use super::angle::Angle;
use super::lobes::clearcoat::{Coats, Light};
use super::lobes::facets::{self, Ring, Seen, Widths};
use super::lobes::{Lobe, Parts, phong, round_up};
use super::spans::{Bundle, Directions, HalfVectors, least_from_mirror};
use crate::bsdf::{Bsdf, MIN_COSINE};
use crate::math::{Cone, Frame, Vec3};

/// Material and viewing direction of one gather point.
#[derive(Clone, Copy, Debug)]
pub struct Reflector {
    /// Scattering distribution of the surface.
    pub bsdf: Bsdf,
    /// Shading frame, whose third axis is the shading normal.
    pub frame: Frame,
    /// Unit direction to the viewer, in the frame.
    pub wo: Vec3,
    /// Unit geometric normal on the side of the viewer.
    pub geometric_normal: Vec3,
}

/// Factor by which the BRDF is multiplied.
#[derive(Clone, Copy, PartialEq)]
enum Factor {
    One,
    Cosine,
}

/// Upper bounds over all light directions (sr⁻¹).
#[derive(Clone, Copy, Debug)]
pub(super) struct OverAll {
    /// Bound of the diffuse part and the sheen.
    pub(super) diffuse: f64,
    /// Bound of the lobe times the cosine.
    pub(super) lobe_cos: f64,
    /// Bound of the coat times the cosine.
    pub(super) coat_cos: f64,
}

impl Reflector {
    /// Upper bound of the largest channel of `f_r` (sr⁻¹) over all light directions in `cone`
    /// (world).
    pub fn upper_brdf(&self, cone: &Cone) -> f32 {
        let [diffuse, rest] = self.upper(cone, Factor::One);
        round_up(diffuse + rest)
    }

    /// Upper bound of the largest channel of `f_r cos⁺θ` (sr⁻¹) over all light directions in `cone`
    /// (world).
    pub fn upper_brdf_cos(&self, cone: &Cone) -> f32 {
        let [diffuse, rest] = self.upper(cone, Factor::Cosine);
        round_up(diffuse + rest)
    }

    /// [`Reflector::upper_brdf_cos`] without the diffuse part and the sheen.
    pub(super) fn upper_lobe_cos(&self, cone: &Cone) -> f32 {
        let [_, rest] = self.upper(cone, Factor::Cosine);
        round_up(rest)
    }

    /// The shading normal on the side of the viewer.
    pub fn normal(&self) -> Vec3 {
        self.frame.n * self.side()
    }

    /// Bounds over all directions of the parts of [`Reflector::upper_brdf_cos`]. The bound of the
    /// diffuse part is without the cosine.
    pub(super) fn upper_over_all(&self) -> OverAll {
        let cos_o = self.wo.z * self.side();
        let parts = Parts::of(&self.bsdf, cos_o, 1.0);
        let directions = Directions::of_point(Vec3::new(self.wo.x, self.wo.y, cos_o).as_dvec3());
        let half = HalfVectors::new(&directions, &[Some(Bundle::of(&Cone::ALL))], Angle::ZERO);
        let lobe_cos = match parts.lobe {
            Lobe::None => 0.0,
            Lobe::Phong { scale, exponent } => scale * phong::upper_peak(exponent, directions.least_mirror()),
            Lobe::Facets { kind, facets: of_lobe, reflected } => {
                let widths = Widths::of(&of_lobe);
                let narrowest = f64::from(widths.narrowest);
                let all = Ring { cos_incidence: half.cos_incidence, cos_light: 1.0 };
                let viewer = directions.widest_viewer;
                let distribution = |least| facets::upper_distribution(kind, widths, least);
                facets::upper_reflection(distribution, widths.cuts(), Angle::ZERO, viewer, all, |ring| {
                    let cos_incidence = ring.cos_incidence;
                    let seen = Seen { alpha: narrowest, cos_o: f64::from(cos_o), cos_i: 1.0, cos_incidence };
                    reflected.upper(cos_incidence) * facets::upper_visibility_cos(kind, &seen)
                })
            }
        };
        let coat_cos = parts.coat.map_or(0.0, |coat| {
            let (viewer, cos_o) = (directions.widest_viewer, f64::from(cos_o));
            coat.upper(Angle::ZERO, viewer, half.cos_incidence, cos_o, Light::UpTo(1.0))
        });
        OverAll { diffuse: parts.diffuse, lobe_cos, coat_cos }
    }

    /// `1` if the viewer is above the frame, otherwise `−1`. Surfaces are two-sided.
    fn side(&self) -> f32 {
        1.0_f32.copysign(self.wo.z)
    }

    /// Upper bounds of the diffuse part with the sheen, and of the lobe with the coat.
    fn upper(&self, cone: &Cone, factor: Factor) -> [f64; 2] {
        let cos_o = self.wo.z * self.side();
        if cos_o <= MIN_COSINE || cone.is_empty() {
            return [0.0; 2];
        }
        let lights = Bundle::about(self.in_frame(cone.axis), Angle::half_angle(cone));
        let geometric_normal = Bundle::one(self.in_frame(self.geometric_normal));
        let normal = Bundle::one(DVec3::Z);
        if lights.least_angle(&geometric_normal).cos <= 0.0 {
            return [0.0; 2];
        }
        let max_cos_i = lights.least_angle(&normal).cos;
        if max_cos_i <= 0.0 {
            return [0.0; 2];
        }
        let min_cos_i = lights.widest_angle(&normal).cos.max(f64::from(MIN_COSINE));
        let parts = Parts::of(&self.bsdf, cos_o, max_cos_i);
        let directions = || Directions::of_point(Vec3::new(self.wo.x, self.wo.y, cos_o).as_dvec3());
        // Every light direction above both planes is in all three bundles.
        let lights = [Some(lights), lights.above(&normal), lights.above(&geometric_normal)];
        let lobe = match parts.lobe {
            Lobe::None => 0.0,
            Lobe::Phong { scale, exponent } => {
                let least = least_from_mirror(&directions(), &lights);
                scale * phong::upper_power([exponent; 2], least) * cosine(factor, max_cos_i)
            }
            Lobe::Facets { kind, facets: of_lobe, reflected } => {
                let widths = Widths::of(&of_lobe);
                let narrowest = f64::from(widths.narrowest);
                let directions = directions();
                let least = least_from_mirror(&directions, &lights);
                let half = HalfVectors::new(&directions, &lights, least);
                let cos_light = match factor {
                    Factor::One => min_cos_i,
                    Factor::Cosine => 1.0,
                };
                let all = Ring { cos_incidence: half.cos_incidence, cos_light };
                let cos_o = f64::from(cos_o);
                let viewer = directions.widest_viewer;
                let distribution = |least| facets::upper_distribution(kind, widths, least);
                let (cuts, least) = (widths.cuts(), half.least_from_normal);
                facets::upper_reflection(distribution, cuts, least, viewer, all, |ring| {
                    let seen =
                        |cos_i| Seen { alpha: narrowest, cos_o, cos_i, cos_incidence: ring.cos_incidence };
                    let visibility = match factor {
                        Factor::One => facets::upper_visibility(kind, &seen(ring.cos_light)),
                        Factor::Cosine => facets::upper_visibility_cos(kind, &seen(max_cos_i)),
                    };
                    reflected.upper(ring.cos_incidence) * visibility
                })
            }
        };
        let coat = parts.coat.map_or(0.0, |coat| {
            let light = match factor {
                Factor::One => Light::From(min_cos_i),
                Factor::Cosine => Light::UpTo(max_cos_i),
            };
            upper_coat(&coat, &directions(), &lights, f64::from(cos_o), light)
        });
        let diffuse = match factor {
            Factor::One => parts.diffuse,
            Factor::Cosine => parts.diffuse_cos,
        };
        [diffuse, lobe + coat]
    }

    /// Transforms a world direction to the frame turned to the viewer's side, without rounding to
    /// `f32`.
    fn in_frame(&self, v: Vec3) -> DVec3 {
        let Frame { t, b, n } = self.frame;
        let v = v.as_dvec3();
        DVec3::new(v.dot(t.as_dvec3()), v.dot(b.as_dvec3()), v.dot(n.as_dvec3()) * f64::from(self.side()))
    }
}

/// Upper bound of a point's coat for light directions that are in all of `lights`.
fn upper_coat(
    coat: &Coats,
    directions: &Directions,
    lights: &[Option<Bundle>],
    cos_o: f64,
    light: Light,
) -> f64 {
    let half = HalfVectors::new(directions, lights, least_from_mirror(directions, lights));
    let viewer = directions.widest_viewer;
    coat.upper(half.least_from_normal, viewer, half.cos_incidence, cos_o, light)
}

fn cosine(factor: Factor, max_cos_i: f64) -> f64 {
    match factor {
        Factor::One => 1.0,
        Factor::Cosine => max_cos_i,
    }
}
