//! Participating media: what light meets between surfaces.
//!
//! A homogeneous medium of absorption `σ_a` and scattering `σ_s` (m⁻¹, by channel) has the
//! extinction `σ_t = σ_a + σ_s`. Along `d` metres of it a share
//!
//! ```text
//! T(d) = exp(−σ_t d)
//! ```
//!
//! of the light goes on (Beer and Lambert); of what does not, `σ_s / σ_t` is scattered, by a phase
//! function.
//!
//! Where which medium is, is said by surfaces and cameras: a mesh may have an [`Interface`], which
//! names the medium on either side, and a camera names the one that it stands in. A mesh without an
//! interface changes nothing, so that things may stand in fog without a word about it. No medium is
//! vacuum. The sides are those of the geometric normal: it points outside. Holes of a surface are
//! not met, and change no medium either.
//!
//! # Guarantee
//! Past [`SceneBuilder::build`](super::SceneBuilder::build) coefficients are finite and not
//! negative, extinctions at most [`MAX_EXTINCTION`], asymmetries below 1, and every medium that is
//! named is there.
//!
//! # Held to this by
//! The tests below; the suite's `media`.

use super::{Camera, MediumId, Mesh, MeshId, Scene, SceneBuilder, Surface, SurfacePoint};
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::math::Vec3;
use crate::math::elementary::exp;

/// Largest extinction (m⁻¹): light goes a nanometre.
pub const MAX_EXTINCTION: f32 = 1e9;

/// What fills a space.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Name for messages.
    pub name: String,
    /// Absorption `σ_a`, by channel (m⁻¹).
    pub absorption: Rgb,
    /// Scattering `σ_s`, by channel (m⁻¹).
    pub scattering: Rgb,
    /// How it scatters.
    pub phase: HenyeyGreenstein,
}

impl Medium {
    /// Extinction `σ_t`, by channel (m⁻¹).
    #[inline]
    pub fn extinction(&self) -> Rgb {
        self.absorption + self.scattering
    }

    /// The share of light that goes on after a distance (m), which may be infinite, by channel.
    #[inline]
    pub fn transmittance(&self, distance: f32) -> Rgb {
        self.extinction().map(|sigma| if sigma > 0.0 { exp(-sigma * distance) } else { 1.0 })
    }

    /// Whether it does nothing to light.
    #[inline]
    pub fn is_clear(&self) -> bool {
        self.extinction().is_black()
    }

    /// Whether its numbers are in range.
    ///
    /// # Errors
    /// [`Error::Invalid`] at `at`: coefficients that are negative, not finite, or more than
    /// [`MAX_EXTINCTION`]; an asymmetry of 1 or more.
    pub fn validate(&self, at: Location) -> Result<()> {
        let Self { name, absorption, scattering, phase } = self;
        let is_valid = absorption.is_valid()
            && scattering.is_valid()
            && self.extinction().max_channel() <= MAX_EXTINCTION
            && phase.is_valid();
        if is_valid {
            return Ok(());
        }
        let [absorption, scattering] = [absorption, scattering].map(|c| c.to_array());
        Err(Error::invalid(
            at.item(format!("medium {name}")),
            format!("absorption {absorption:?}, scattering {scattering:?}, g = {}", phase.asymmetry),
            format!(
                "finite coefficients of at least 0 and at most {MAX_EXTINCTION:e} m⁻¹ together, and g between -1 and 1"
            ),
        ))
    }
}

/// What is on either side of a surface; nothing is vacuum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Interface {
    /// On the side that the geometric normal points away from.
    pub inside: Option<MediumId>,
    /// On the side that it points to.
    pub outside: Option<MediumId>,
}

impl Interface {
    fn media(&self) -> impl Iterator<Item = MediumId> {
        [self.inside, self.outside].into_iter().flatten()
    }
}

impl SceneBuilder {
    /// Adds a medium.
    ///
    /// # Errors
    /// As [`Medium::validate`].
    pub fn add_medium(&mut self, medium: Medium) -> Result<MediumId> {
        medium.validate(self.origin.clone())?;
        self.scene.media.push(medium);
        Ok(MediumId::at(self.scene.media.len() as u32 - 1))
    }

    /// Says what is on either side of a mesh, wherever it is placed.
    ///
    /// # Errors
    /// A mesh or a medium that was not added before.
    pub fn set_interface(&mut self, mesh: MeshId, interface: Interface) -> Result<()> {
        let at = self.origin.clone().item(format!("mesh {}", mesh.index()));
        if let Some(wrong) = interface.media().find(|medium| medium.index() >= self.scene.media.len()) {
            let found = format!("medium {}", wrong.index());
            return Err(Error::invalid(at, found, "a medium of this scene"));
        }
        let Some(mesh) = self.scene.meshes.get_mut(mesh.index()) else {
            return Err(Error::invalid(at, "no such mesh", "a mesh of this scene"));
        };
        mesh.interface = Some(interface);
        Ok(())
    }
}

impl SceneBuilder {
    /// Leaves all media out, as renderers do that know none; whether anything was in one.
    pub fn leave_out_media(&mut self) -> bool {
        let interfaces = self.scene.meshes.iter_mut().filter_map(|mesh| mesh.interface.take());
        let of_meshes = interfaces.flat_map(|interface| interface.media().collect::<Vec<_>>()).count();
        let of_cameras = self.scene.cameras.iter_mut().filter_map(|camera| camera.medium.take()).count();
        of_meshes + of_cameras > 0
    }
}

impl Scene {
    /// All media.
    pub fn media(&self) -> &[Medium] {
        &self.media
    }

    /// Whether any light of the scene, or any view of it, may meet a medium that does something to
    /// light.
    #[inline]
    pub fn has_media(&self) -> bool {
        self.has_media
    }

    /// Whether any surface has an interface.
    #[inline]
    pub fn has_interfaces(&self) -> bool {
        self.has_interfaces
    }

    /// Looks what there is.
    pub(super) fn count_media(&mut self) {
        let is_placed = |mesh: usize| self.instances.iter().any(|i| i.mesh.index() == mesh);
        let of_mesh = |(mesh, m): (usize, &Mesh)| m.interface.filter(|_| is_placed(mesh));
        let interfaces: Vec<Interface> = self.meshes.iter().enumerate().filter_map(of_mesh).collect();
        let of_cameras = self.cameras.iter().filter_map(|camera| camera.medium);
        let mut named = interfaces.iter().flat_map(Interface::media).chain(of_cameras);
        self.has_media = named.any(|medium| !self.media[medium.index()].is_clear());
        self.has_interfaces = !interfaces.is_empty();
    }

    /// The medium that a path is in which leaves a surface along `direction`, having come to it
    /// through `before`.
    #[inline]
    pub fn medium_beyond(
        &self,
        surface: &SurfacePoint,
        direction: Vec3,
        before: Option<MediumId>,
    ) -> Option<MediumId> {
        match self.mesh_of(surface.instance).interface {
            None => before,
            Some(Interface { inside, outside }) => {
                if surface.geometric_normal.dot(direction) < 0.0 {
                    inside
                } else {
                    outside
                }
            }
        }
    }

    /// Whether a surface is the boundary of a medium and nothing else.
    #[inline]
    pub fn is_boundary(&self, surface: &SurfacePoint) -> bool {
        matches!(self.material_of(surface.instance).surface, Surface::Boundary)
    }

    /// # Errors
    /// A camera that stands in a medium which is not of this scene.
    pub fn check_camera(&self, camera: &Camera) -> Result<()> {
        match camera.medium {
            Some(medium) if medium.index() >= self.media.len() => {
                let media = self.media.len();
                Err(Error::option("camera medium", medium.index(), format!("one of the scene's {media}")))
            }
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn medium(absorption: Rgb, scattering: Rgb, asymmetry: f32) -> Medium {
        Medium { name: "fog".into(), absorption, scattering, phase: HenyeyGreenstein { asymmetry } }
    }

    #[test]
    fn light_is_extinguished_by_channel() {
        let m = medium(Rgb::new(0.1, 0.0, 0.0), Rgb::new(0.2, 0.5, 0.0), 0.0);
        let t = m.transmittance(2.0);
        let expected = [(-0.6_f64), -1.0, 0.0].map(crate::math::elementary::exp_f64);
        for (found, expected) in t.to_array().into_iter().zip(expected) {
            assert!((f64::from(found) - expected).abs() < 1e-6, "{found} for {expected}");
        }
        assert_eq!(m.transmittance(f32::INFINITY), Rgb::new(0.0, 0.0, 1.0), "no NaN of 0 · ∞");
        assert!(!m.is_clear() && medium(Rgb::BLACK, Rgb::BLACK, 0.5).is_clear());
    }

    #[test]
    fn media_that_are_left_out_are_nowhere() {
        let mut b = SceneBuilder::new("s", Location::default());
        assert!(!b.leave_out_media());
        let fog = b.add_medium(medium(Rgb::WHITE, Rgb::WHITE, 0.0)).unwrap();
        assert!(!b.leave_out_media(), "nothing is in it");
        let camera = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 1.0);
        b.add_camera(Camera { medium: Some(fog), ..camera }).unwrap();
        assert!(b.leave_out_media() && !b.leave_out_media());
        assert!(b.scene.cameras[0].medium.is_none());
    }

    #[test]
    fn wrong_media_are_refused_with_what_is_allowed() {
        let mut b = SceneBuilder::new("s", Location::file("s.pbrt"));
        let gray = Rgb::gray;
        let wrong = [
            medium(gray(-1.0), gray(1.0), 0.0),
            medium(gray(0.0), gray(f32::NAN), 0.0),
            medium(gray(6e8), gray(6e8), 0.0),
            medium(gray(0.0), gray(1.0), 1.0),
            medium(gray(0.0), gray(1.0), f32::NAN),
        ];
        for m in wrong {
            let said = b.add_medium(m).unwrap_err().to_string();
            assert!(said.contains("medium fog") && said.contains("g between -1 and 1"), "{said}");
        }
        let fog = b.add_medium(medium(gray(0.0), gray(1e9), -0.99)).unwrap();
        let outside = Interface { inside: Some(fog), outside: Some(MediumId::at(1)) };
        let said = b.set_interface(MeshId::at(0), outside).unwrap_err().to_string();
        assert!(said.contains("medium 1"), "{said}");
        let said = b.set_interface(MeshId::at(0), Interface::default()).unwrap_err().to_string();
        assert!(said.contains("no such mesh"), "{said}");
        let camera = Camera::look_at("c", Vec3::Z, Vec3::ZERO, Vec3::Y, 0.5);
        let camera = Camera { medium: Some(MediumId::at(1)), ..camera };
        let said = b.add_camera(camera).unwrap_err().to_string();
        assert!(said.contains("camera medium = 1"), "{said}");
    }
}
