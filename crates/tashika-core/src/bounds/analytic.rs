//! Bound of the material term from ranges of the quantities that Phong and facet lobes depend on.
//!
//! ```text
//! M ≤ min( K c_i , K_c )  +  min( P , max( ρ (n + 2)/2π cosⁿα · c_i ,  F D G₂ / (4 c_o) ) )  +  min( P_c , coat )          (sr⁻¹)
//! ```
//!
//! Here `c_i` is the largest cosine between lights and normals, `K` the largest diffuse part, and
//! `K_c` the largest diffuse part times the cosine. Each factor of the lobes is at its largest over
//! the points and the lights. `α` is the least angle between the cone of mirror directions and the
//! lights; the exponent and the roughness are those in their range for which the lobe is brightest
//! at this angle; `F` is taken at the widest angle of incidence ([`lobes`](super::lobes),
//! [`spans`](super::spans)). `P` is the largest value of any point's lobe times the cosine, over
//! all directions, and `P_c` that of any point's coat. Both combine the parameters of one point,
//! whereas ranges combine those of different points. Points with different BSDFs may be merged;
//! each point has at most one lobe and one coat.
//!
//! # Guarantee
//! The bound is at least `M` of every point merged, in the `f32` arithmetic of
//! [`contribution`](crate::contribution). It is zero where all lights are below the plane of every
//! shading normal.
//!
//! # Limits
//! The bounds of half vectors use the cone around a box of lights instead of the box. Cones contain
//! more directions than the points have. For points whose directions differ by more than the width
//! of their lobes, the bound is hardly better than `P`.
//!
//! # Held to this by
//! `bounds::tests::analytic`.

use super::angle::{Angle, TURN};
use super::lobes::clearcoat::{Coats, Light};
use super::lobes::facets::{self, FacetKind, Ring, Seen, Widths};
use super::lobes::fresnel::Reflected;
use super::lobes::{Lobe, Parts, phong, round_up};
use super::spans::{Bundle, Directions, HalfVectors, LENGTHS, least_from_mirror};
use super::{Reflector, Towards, UpperMaterial};
use crate::bsdf::{CoatModel, MIN_COSINE};
use crate::math::{Cone, Vec3};

/// Number of cosines of incidence at which reflectances are stored. With more of them `F` is
/// tighter, by at most the ratio of neighbouring values, and nodes are larger. Chosen so that this
/// ratio is below 1.5 for surfaces that reflect 0.04 and more at normal incidence.
const KNOTS: usize = 16;

/// Ranges over a set of points.
#[derive(Clone, Copy, Debug)]
pub struct UpperAnalytic {
    /// Shading normals on the side of the viewer.
    normals: Cone,
    /// `K` (sr⁻¹).
    diffuse: f32,
    /// `K_c` (sr⁻¹).
    diffuse_cos: f32,
    /// Directions to the viewer, of all points with a lobe or a coat.
    viewers: Cone,
    /// Mirror directions, of all points with a lobe or a coat.
    mirrors: Cone,
    /// Smallest cosine between normal and viewer, over all points with a lobe or a coat.
    min_cos_o: f32,
    /// Largest value of a lobe times the cosine, over all directions (sr⁻¹).
    peak: f32,
    phong: PhongRange,
    facets: FacetRange,
    /// Largest value of a coat times the cosine, over all directions (sr⁻¹).
    coat_peak: f32,
    /// Ranges of the coats of each model, in the order of [`CoatModel::ALL`].
    coats: [Coats; CoatModel::ALL.len()],
}

/// Ranges of the parameters of Phong lobes.
#[derive(Clone, Copy, Debug)]
struct PhongRange {
    /// Largest factor of the lobe; zero if no point has a Phong lobe.
    scale: f32,
    /// Smallest and largest exponent.
    exponents: [f32; 2],
}

/// Ranges of the parameters of facet lobes.
#[derive(Clone, Copy, Debug)]
struct FacetRange {
    /// Upper bounds of the largest channel of `F`: entry `k` holds for cosines of incidence of at
    /// least `k / KNOTS`. Zeros if no point has a facet lobe.
    reflected: [f32; KNOTS],
    /// Roughnesses of each model, in the order of [`FacetKind::ALL`]; [`Widths::NONE`] if no point
    /// has a lobe of that model.
    widths: [Widths; FacetKind::ALL.len()],
}

/// An empty range.
const NONE: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

const EMPTY: UpperAnalytic = UpperAnalytic {
    normals: Cone::EMPTY,
    diffuse: 0.0,
    diffuse_cos: 0.0,
    viewers: Cone::EMPTY,
    mirrors: Cone::EMPTY,
    peak: 0.0,
    phong: PhongRange { scale: 0.0, exponents: NONE },
    min_cos_o: f32::INFINITY,
    facets: FacetRange { reflected: [0.0; KNOTS], widths: [Widths::NONE; FacetKind::ALL.len()] },
    coat_peak: 0.0,
    coats: [Coats::none(CoatModel::ALL[0]), Coats::none(CoatModel::ALL[1]), Coats::none(CoatModel::ALL[2])],
};

impl UpperMaterial for UpperAnalytic {
    fn of_point(point: &Reflector) -> Self {
        let cos_o = point.wo.z.abs();
        if cos_o <= MIN_COSINE {
            return EMPTY;
        }
        let parts = Parts::of(&point.bsdf, cos_o, 1.0);
        let [diffuse, diffuse_cos] = [parts.diffuse, parts.diffuse_cos].map(round_up);
        let plain = Self { normals: Cone::of(point.normal()), diffuse, diffuse_cos, ..EMPTY };
        let Vec3 { x, y, z } = point.wo;
        let world = |local: Vec3| Cone::of(point.frame.to_world(local).normalize());
        if parts.is_diffuse() {
            return plain;
        }
        let over_all = point.upper_over_all();
        let of_model = |model| {
            let coat = parts.coat.filter(|coat| coat.model() == model);
            coat.unwrap_or(Coats::none(model))
        };
        let glossy = || Self {
            viewers: world(point.wo),
            mirrors: world(Vec3::new(-x, -y, z)),
            min_cos_o: cos_o,
            peak: round_up(over_all.lobe_cos),
            coat_peak: round_up(over_all.coat_cos),
            coats: CoatModel::ALL.map(of_model),
            ..plain
        };
        match parts.lobe {
            Lobe::None => glossy(),
            Lobe::Phong { scale, exponent } => {
                let phong = PhongRange { scale: scale as f32, exponents: [exponent as f32; 2] };
                Self { phong, ..glossy() }
            }
            Lobe::Facets { kind, facets, reflected } => {
                let widths =
                    FacetKind::ALL.map(|k| if k == kind { Widths::of(&facets) } else { Widths::NONE });
                let facets = FacetRange { reflected: table(&reflected), widths };
                Self { facets, ..glossy() }
            }
        }
    }

    fn merge(&mut self, other: &Self) {
        self.normals = self.normals.union(other.normals);
        self.diffuse = self.diffuse.max(other.diffuse);
        self.diffuse_cos = self.diffuse_cos.max(other.diffuse_cos);
        if other.mirrors.is_empty() {
            return;
        }
        self.viewers = self.viewers.union(other.viewers);
        self.mirrors = self.mirrors.union(other.mirrors);
        self.min_cos_o = self.min_cos_o.min(other.min_cos_o);
        self.peak = self.peak.max(other.peak);
        self.phong.scale = self.phong.scale.max(other.phong.scale);
        self.phong.exponents = hull(self.phong.exponents, other.phong.exponents);
        for (mine, others) in self.facets.reflected.iter_mut().zip(other.facets.reflected) {
            *mine = mine.max(others);
        }
        for (mine, others) in self.facets.widths.iter_mut().zip(other.facets.widths) {
            *mine = mine.union(others);
        }
        self.coat_peak = self.coat_peak.max(other.coat_peak);
        for (mine, others) in self.coats.iter_mut().zip(other.coats) {
            *mine = mine.union(others);
        }
    }

    fn upper_material(&self, towards: &Towards) -> f32 {
        if self.normals.is_empty() {
            return 0.0;
        }
        let cos = f64::from(towards.upper_cos(&self.normals));
        if cos <= 0.0 {
            return 0.0;
        }
        let diffuse = (f64::from(self.diffuse) * cos).min(f64::from(self.diffuse_cos));
        if self.mirrors.is_empty() {
            return round_up(diffuse);
        }
        let lights = towards.cone();
        if lights.is_empty() {
            return 0.0;
        }
        let points = Directions {
            normals: Bundle::of(&self.normals),
            viewers: Bundle::of(&self.viewers),
            mirrors: Bundle::of(&self.mirrors),
            widest_viewer: Angle::of_cos(f64::from(self.min_cos_o) * (1.0 - LENGTHS)).plus(TURN),
        };
        let lights = Bundle::about(lights.axis.as_dvec3(), Angle::half_angle(&lights));
        let lights = [Some(lights), lights.above(&points.normals)];
        let mut from_mirror = least_from_mirror(&points, &lights);
        if let Towards::Box(_) = towards {
            // The box itself gives a larger angle than the cone around it.
            let of_box = Angle::of_cos(f64::from(towards.upper_cos(&self.mirrors))).minus(TURN);
            from_mirror = from_mirror.max(of_box);
        }
        let phong = self.phong.upper(from_mirror, cos);
        let facets = self.facets.upper(&points, &lights, from_mirror, [f64::from(self.min_cos_o), cos]);
        let coat =
            if self.coat_peak > 0.0 { self.upper_coat(&points, &lights, from_mirror, cos) } else { 0.0 };
        let lobe = phong.max(facets).min(f64::from(self.peak));
        round_up(diffuse + lobe + coat.min(f64::from(self.coat_peak)))
    }
}

impl UpperAnalytic {
    /// Upper bound of coats times the cosine, for lights at cosines of at most `max_cos_i`.
    fn upper_coat(
        &self,
        points: &Directions,
        lights: &[Option<Bundle>],
        from_mirror: Angle,
        max_cos_i: f64,
    ) -> f64 {
        let half = HalfVectors::new(points, lights, from_mirror);
        let (least, viewer) = (half.least_from_normal, points.widest_viewer);
        let (min_cos_o, light) = (f64::from(self.min_cos_o), Light::UpTo(max_cos_i));
        let bounds = self.coats.iter().map(|c| c.upper(least, viewer, half.cos_incidence, min_cos_o, light));
        bounds.fold(0.0, f64::max)
    }
}

impl PhongRange {
    /// Upper bound of Phong lobes times the cosine. Lights are at least `from_mirror` from mirror
    /// directions and at cosines of at most `max_cos_i`.
    fn upper(&self, from_mirror: Angle, max_cos_i: f64) -> f64 {
        if self.scale <= 0.0 {
            return 0.0;
        }
        f64::from(self.scale) * phong::upper_power(self.exponents.map(f64::from), from_mirror) * max_cos_i
    }
}

impl FacetRange {
    /// Upper bound of facet lobes times the cosine. Viewers are at cosines of at least `min_cos_o`,
    /// lights at cosines of at most `max_cos_i`.
    fn upper(
        &self,
        points: &Directions,
        lights: &[Option<Bundle>],
        from_mirror: Angle,
        [min_cos_o, max_cos_i]: [f64; 2],
    ) -> f64 {
        // The first entry, the bound for all cosines, is the largest.
        if self.reflected[0] <= 0.0 {
            return 0.0;
        }
        let half = HalfVectors::new(points, lights, from_mirror);
        let all = Ring { cos_incidence: half.cos_incidence, cos_light: 1.0 };
        let reflected = |ring: Ring| {
            let knot = (ring.cos_incidence * KNOTS as f64) as usize;
            f64::from(self.reflected[knot.min(KNOTS - 1)])
        };
        let (least, viewer) = (half.least_from_normal, points.widest_viewer);
        let kinds = FacetKind::ALL.into_iter().zip(self.widths).filter(|(_, widths)| *widths != Widths::NONE);
        let bounds = kinds.map(|(kind, widths)| {
            let distribution = |least| facets::upper_distribution(kind, widths, least);
            facets::upper_reflection(distribution, widths.cuts(), least, viewer, all, |ring| {
                let seen = Seen {
                    alpha: f64::from(widths.narrowest),
                    cos_o: min_cos_o,
                    cos_i: max_cos_i,
                    cos_incidence: ring.cos_incidence,
                };
                reflected(ring) * facets::upper_visibility_cos(kind, &seen)
            })
        });
        bounds.fold(0.0, f64::max)
    }
}

/// Upper bounds of the reflectance of facets from each knot on, rounded up.
fn table(reflected: &Reflected) -> [f32; KNOTS] {
    std::array::from_fn(|k| round_up(reflected.upper(k as f64 / KNOTS as f64)))
}

/// The smallest range that contains both ranges.
fn hull(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}
