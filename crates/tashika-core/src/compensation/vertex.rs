//! Vertices of paths, on surfaces or in media, and the two kernels of their scattering.
//!
//! If there are VPLs, VPLs in a medium carry all scattering of that medium, so the rest of a phase
//! function is zero.

use glam::Vec3;

use super::places::Receiver;
use crate::bsdf::{Bsdf, Lambert, glossy_probability};
use crate::color::Rgb;
use crate::gather::GatherPoint;
use crate::scene::{MediumId, SurfacePoint};
use crate::vpl::carried_cos;

/// Kernel of the scattering at a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kernel {
    /// `c`: the kernel by which VPLs are summed, or by which VPLs send out light.
    Carried,
    /// `g`: the rest of the scattering.
    Rest,
}

/// Definition of `c` at a vertex.
#[derive(Clone, Copy, Debug)]
enum Carried {
    /// At the gather point: the BSDF of the sum over VPLs.
    Summed(Bsdf),
    /// At a surface that sends out light by VPLs.
    BySurface(SurfacePoint),
    /// In a medium that sends out light by VPLs.
    ByMedium,
    /// Without VPLs: zero.
    Nothing,
}

/// Vertex of a path, where one of two kernels scatters it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    point: GatherPoint,
    carried: Carried,
    /// Share of `c` that is left for paths.
    amplitude: f32,
    has_rest: bool,
}

/// Cosine above which two shading normals count as equal.
const SAME: f32 = 1.0 - 1e-6;
/// Least assumed albedo of a gloss: the light that it mirrors may be bright.
const LEAST_GLOSS: f32 = 0.04;

impl Vertex {
    /// Returns the vertex of a gather point. `summed` is the BSDF with which VPLs are summed there,
    /// if there are any.
    pub(super) fn first(point: &GatherPoint, summed: Option<&Bsdf>) -> Self {
        Self {
            point: *point,
            carried: summed.map_or(Carried::Nothing, |summed| Carried::Summed(*summed)),
            amplitude: 1.0,
            has_rest: summed.is_none() || (point.phase.is_none() && summed != Some(&point.bsdf)),
        }
    }

    /// Returns a later vertex in a medium. If there are VPLs, the share `left` of `c` is left for
    /// paths.
    pub(super) fn next_in_medium(point: &GatherPoint, left: Option<f32>) -> Self {
        let Some(amplitude) = left else { return Self::first(point, None) };
        Self { point: *point, carried: Carried::ByMedium, amplitude, has_rest: false }
    }

    /// Returns a later vertex on a surface. If there are VPLs, the share `left` of `c` is left for
    /// paths.
    pub(super) fn next(point: &GatherPoint, surface: &SurfacePoint, left: Option<f32>) -> Self {
        let Some(amplitude) = left else { return Self::first(point, None) };
        // At silhouettes, the shading normal for the viewer differs from the one for light.
        let (_, lit) = surface.normals_towards(point.geometric_normal);
        let same = point.frame.n.dot(lit) > SAME;
        let has_rest = !(same && matches!(point.bsdf, Bsdf::Lambert(_)));
        Self { point: *point, carried: Carried::BySurface(*surface), amplitude, has_rest }
    }

    /// Returns true at the gather point, if its light from VPLs is summed elsewhere.
    pub(super) fn sums_vpls(&self) -> bool {
        matches!(self.carried, Carried::Summed(_))
    }

    pub(super) fn position(&self) -> Vec3 {
        self.point.position
    }

    /// Returns the vertex as a receiver of light.
    pub(super) fn receiver(&self) -> Receiver {
        let GatherPoint { position, geometric_normal, medium, phase, .. } = self.point;
        Receiver { position, normal: phase.is_none().then_some(geometric_normal), medium }
    }

    /// Returns true in a medium, false on a surface.
    pub(super) fn is_in_medium(&self) -> bool {
        self.point.phase.is_some()
    }

    /// Returns the medium around the vertex; for a surface, the medium on the side to which it
    /// scatters.
    pub(super) fn medium(&self) -> Option<MediumId> {
        self.point.medium
    }

    /// Returns the share of `c` that is left for paths.
    pub(super) fn amplitude(&self) -> f32 {
        self.amplitude
    }

    /// Returns the approximate albedos of the part of `c` that is left for paths, and of `g`.
    fn importance_albedos(&self) -> [f32; 2] {
        if self.is_in_medium() {
            return if self.has_rest { [0.0, 1.0] } else { [self.amplitude, 0.0] };
        }
        let bsdf = &self.point.bsdf;
        let diffuse = bsdf.vpl_reflectance(self.point.wo).max_channel();
        let all = bsdf.albedo().max_channel();
        let carried = match &self.carried {
            Carried::Nothing => return [0.0, all],
            Carried::Summed(summed) if summed == bsdf => all,
            Carried::Summed(_) | Carried::BySurface(_) | Carried::ByMedium => diffuse,
        };
        let rest = if self.has_rest { bsdf.importance_gloss(self.point.wo).max(LEAST_GLOSS) } else { 0.0 };
        [self.amplitude * carried, rest]
    }

    /// Returns the approximate albedo of all scattering that is left for paths.
    pub(super) fn importance_albedo(&self) -> f32 {
        self.importance_albedos().iter().sum()
    }

    /// Returns the probability with which a path continues by `g`; `None` if no scattering is left.
    pub(super) fn probability_of_rest(&self) -> Option<f32> {
        let [carried, rest] = self.importance_albedos();
        glossy_probability(rest, carried)
    }

    fn is_above(&self, direction: Vec3) -> bool {
        self.is_in_medium() || self.point.geometric_normal.dot(direction) > 0.0
    }

    /// Returns the whole scattering of light from a unit direction, with the cosine of a surface
    /// (sr⁻¹).
    fn scattered(&self, direction: Vec3) -> Rgb {
        let point = &self.point;
        match point.phase {
            Some(phase) => Rgb::gray(phase.density(point.before().dot(direction))),
            None => point.bsdf.eval_cos(point.wo, point.frame.to_local(direction)),
        }
    }

    /// Returns the part of `c` that is left for paths, for light from a unit direction (sr⁻¹).
    pub(super) fn carried_cos(&self, direction: Vec3) -> Rgb {
        if !self.is_above(direction) {
            return Rgb::BLACK;
        }
        self.whole_carried_cos(direction) * self.amplitude
    }

    /// Returns all of `c` for light from a unit direction (sr⁻¹).
    fn whole_carried_cos(&self, direction: Vec3) -> Rgb {
        let point = &self.point;
        match &self.carried {
            Carried::Nothing => Rgb::BLACK,
            _ if self.is_in_medium() => self.scattered(direction),
            Carried::Summed(summed) => summed.eval_cos(point.wo, point.frame.to_local(direction)),
            Carried::BySurface(surface) => carried_cos(surface, &point.bsdf, direction),
            Carried::ByMedium => unreachable!("only in media"),
        }
    }

    /// Returns `g` for light from a unit direction (sr⁻¹).
    fn rest_cos(&self, direction: Vec3) -> Rgb {
        if !self.is_above(direction) {
            return Rgb::BLACK;
        }
        self.scattered(direction) - self.whole_carried_cos(direction)
    }

    /// Returns a kernel for light from a unit direction (sr⁻¹).
    pub(super) fn value(&self, kernel: Kernel, direction: Vec3) -> Rgb {
        match kernel {
            Kernel::Carried => self.carried_cos(direction),
            Kernel::Rest => self.rest_cos(direction),
        }
    }

    /// Returns the BSDF from which directions for a kernel are drawn at a surface.
    fn drawn_from(&self, kernel: Kernel) -> Bsdf {
        match (kernel, &self.carried) {
            (Kernel::Rest, Carried::Nothing) => self.point.bsdf,
            (Kernel::Rest, _) => self.point.bsdf.mostly_gloss(),
            (Kernel::Carried, Carried::Summed(summed)) => *summed,
            (Kernel::Carried, Carried::BySurface(_) | Carried::ByMedium | Carried::Nothing) => {
                Bsdf::Lambert(Lambert { reflectance: Rgb::WHITE })
            }
        }
    }

    /// Returns true if the kernel scatters diffusely, so that light from all directions matters.
    pub(super) fn is_diffuse(&self, kernel: Kernel) -> bool {
        let of_all = || !self.point.bsdf.vpl_reflectance(self.point.wo).is_black();
        kernel == Kernel::Carried || (matches!(self.carried, Carried::Nothing) && of_all())
    }

    /// Returns the density with which [`Vertex::sample`] draws a unit direction (sr⁻¹).
    pub(super) fn density(&self, kernel: Kernel, direction: Vec3) -> f32 {
        match self.point.phase {
            Some(phase) => phase.density(self.point.before().dot(direction)),
            None => self.drawn_from(kernel).pdf(self.point.wo, self.point.frame.to_local(direction)),
        }
    }

    /// Draws a direction for a kernel from three uniform numbers. Returns the direction, its
    /// density (sr⁻¹), and the kernel divided by that density; `None` if the path ends.
    pub(super) fn sample(&self, kernel: Kernel, u: [f32; 3]) -> Option<(Vec3, f32, Rgb)> {
        let Self { point, .. } = self;
        let (direction, density) = match point.phase {
            Some(phase) => phase.sample(point.before(), [u[0], u[1]]),
            None => {
                let sample = self.drawn_from(kernel).sample(point.wo, u)?;
                (point.frame.to_world(sample.wi).normalize(), sample.pdf)
            }
        };
        let value = self.value(kernel, direction);
        Some((direction, density, value / density)).filter(|_| !value.is_black())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Plastic;
    use crate::math::Frame;
    use crate::rng::{Purpose, Stream};

    /// With VPLs, only the gloss of a plastic is left for paths. More than 70 % of the directions
    /// for the rest are in the mirror lobe, and the returned factors are value over density.
    #[test]
    fn directions_of_the_gloss_are_drawn_from_the_gloss() {
        let bsdf = Bsdf::Plastic(Plastic {
            diffuse: Rgb::gray(0.6),
            specular: Rgb::gray(0.4),
            ior: 1.5,
            facets: 0.1.into(),
        });
        let normal = Vec3::Z;
        let point = GatherPoint {
            position: Vec3::ZERO,
            geometric_normal: normal,
            frame: Frame::about(normal),
            wo: Vec3::new(0.6, 0.0, 0.8),
            bsdf,
            weight: Rgb::WHITE,
            medium: None,
            phase: None,
            instant: 0,
        };
        let summed = Bsdf::Lambert(Lambert { reflectance: bsdf.vpl_reflectance(point.wo) });
        let vertex = Vertex::first(&point, Some(&summed));
        let mirrored = point.frame.to_world(Vec3::new(-0.6, 0.0, 0.8));
        let mut s = Stream::new(1, Purpose::Test, 0);
        let mut in_the_lobe = 0;
        for _ in 0..1000 {
            let Some((direction, density, factor)) = vertex.sample(Kernel::Rest, s.uniform_3()) else {
                continue;
            };
            let value = vertex.value(Kernel::Rest, direction);
            assert!((factor.luminance() * density / value.luminance() - 1.0).abs() < 1e-3);
            in_the_lobe += u32::from(direction.dot(mirrored) > 0.9);
        }
        // Of directions drawn from the whole BSDF, about a fifth would be in the lobe.
        assert!(in_the_lobe > 700, "{in_the_lobe} of 1000");
    }
}
