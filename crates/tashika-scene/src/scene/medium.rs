//! Participating media between surfaces.
//!
//! A homogeneous medium of absorption `σ_a` and scattering `σ_s` (m⁻¹, by channel) has the
//! extinction `σ_t = σ_a + σ_s`. Over a distance of `d` metres, it transmits the share
//!
//! ```text
//! T(d) = exp(−σ_t d)
//! ```
//!
//! of the light (Beer and Lambert). The share `σ_s / σ_t` of the extinguished light is scattered,
//! according to a phase function. A [`Variation`] makes the coefficients vary from place to place.
//!
//! Surfaces and cameras define where a medium is. A mesh may have an [`Interface`], which names the
//! medium on each of its two sides; the geometric normal points to the outside. A camera names the
//! medium around it. A path that crosses a mesh without an interface stays in its medium, so that
//! objects in fog need no interface. A path through a hole of a surface stays in its medium, too.
//! Space without a medium is vacuum.
//!
//! # Guarantee
//! In a scene that [`SceneBuilder::build`](super::SceneBuilder::build) returns, coefficients are
//! finite and not negative, extinctions are at most [`MAX_EXTINCTION`], absolute asymmetries are
//! below 1, albedos are at most 1, and optical thicknesses of grids are at most
//! [`MAX_OPTICAL_THICKNESS`]. Every medium that is named exists.
//!
//! # Held to this by
//! The tests below; the suite's `media` and `grid_media`.

use std::sync::Arc;

use super::{Camera, MediumId, Mesh, MeshId, Scene, SceneBuilder, Surface, SurfacePoint, Variation};
use super::{Density, Scattered};
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::math::elementary::exp;
use crate::math::{DVec3, Vec3};

/// Largest extinction (m⁻¹): the mean free path is a nanometre.
pub const MAX_EXTINCTION: f32 = 1e9;

/// Largest number of mean free paths across the box of a varying medium, at its largest density. A
/// ray through the box may need that many tentative collisions.
pub const MAX_OPTICAL_THICKNESS: f64 = 1e6;

/// Medium that fills a space.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Name that identifies it in messages.
    pub name: String,
    /// Absorption coefficient `σ_a`, by channel (m⁻¹).
    pub absorption: Rgb,
    /// Scattering coefficient `σ_s`, by channel (m⁻¹).
    pub scattering: Rgb,
    /// Phase function of the scattering.
    pub phase: HenyeyGreenstein,
    /// Variation of the coefficients from place to place; `None` if they are constant.
    pub variation: Option<Arc<Variation>>,
}

impl Medium {
    /// Extinction `σ_t` where the density is 1, by channel (m⁻¹).
    #[inline]
    pub fn extinction(&self) -> Rgb {
        self.absorption + self.scattering
    }

    /// Transmittance of a distance (m), which may be infinite, by channel, where the density is 1.
    #[inline]
    pub fn transmittance(&self, distance: f32) -> Rgb {
        self.extinction().map(|sigma| if sigma > 0.0 { exp(-sigma * distance) } else { 1.0 })
    }

    /// Factor on the coefficients by place, if they vary.
    #[inline]
    pub fn density(&self) -> Option<&Density> {
        self.variation.as_deref()?.density()
    }

    #[inline]
    fn scattered(&self) -> &Scattered {
        self.variation.as_deref().map_or(&Scattered::Evenly, Variation::scattered)
    }

    /// Scattering `σ_s` at a point (m) where the density is `factor`, by channel (m⁻¹).
    #[inline]
    pub fn scattering_at(&self, place: DVec3, factor: Rgb) -> Rgb {
        match self.scattered() {
            Scattered::Evenly => self.scattering * factor,
            Scattered::Albedo(albedo) => {
                self.extinction() * factor * albedo.at(albedo.to_cells().transform_point3(place))
            }
            Scattered::Coefficient(grid) => grid.at(grid.to_cells().transform_point3(place)),
        }
    }

    /// Returns true if the medium scatters light.
    #[inline]
    pub fn scatters(&self) -> bool {
        !self.scattering.is_black() || !matches!(self.scattered(), Scattered::Evenly)
    }

    /// Returns true if the medium neither absorbs nor scatters light.
    #[inline]
    pub fn is_clear(&self) -> bool {
        (self.extinction() * self.density().map_or(Rgb::WHITE, Density::most)).is_black()
    }

    /// Checks that its parameters are in range.
    ///
    /// # Errors
    /// [`Error::Invalid`] at `at`: coefficients that are negative, not finite, or more than
    /// [`MAX_EXTINCTION`]; an absolute asymmetry of 1 or more; an albedo of more than 1; an optical
    /// thickness of more than [`MAX_OPTICAL_THICKNESS`] across the box.
    pub fn validate(&self, at: Location) -> Result<()> {
        self.validate_coefficients(at.clone())?;
        let at = at.item(format!("medium {}", self.name));
        if let Scattered::Albedo(albedo) = self.scattered()
            && albedo.most().max_channel() > 1.0
        {
            let found = format!("an albedo of {}", albedo.most().max_channel());
            return Err(Error::invalid(at, found, "albedos from 0 to 1"));
        }
        let Some(density) = self.density() else { return Ok(()) };
        let extinction = (self.extinction() * density.most()).max_channel();
        let thickness = f64::from(extinction) * density.grid().longest();
        if extinction <= MAX_EXTINCTION && thickness <= MAX_OPTICAL_THICKNESS {
            return Ok(());
        }
        Err(Error::invalid(
            at,
            format!("an extinction of {extinction:e} m⁻¹, {thickness:e} mean free paths across its grid"),
            format!("at most {MAX_EXTINCTION:e} m⁻¹, and {MAX_OPTICAL_THICKNESS:e} mean free paths"),
        ))
    }

    fn validate_coefficients(&self, at: Location) -> Result<()> {
        let Self { name, absorption, scattering, phase, variation: _ } = self;
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

/// Media on the two sides of a surface; `None` is vacuum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Interface {
    /// Medium on the side that the geometric normal points away from.
    pub inside: Option<MediumId>,
    /// Medium on the side that the geometric normal points to.
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

    /// Sets the media on the two sides of a mesh, for all its instances.
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
    /// Removes all media, for renderers that do not support them. Returns true if any mesh or
    /// camera named a medium.
    pub fn leave_out_media(&mut self) -> bool {
        let interfaces = self.scene.meshes.iter_mut().filter_map(|mesh| mesh.interface.take());
        let of_meshes = interfaces.flat_map(|interface| interface.media().collect::<Vec<_>>()).count();
        let of_cameras = self.scene.cameras.iter_mut().filter_map(|camera| camera.medium.take()).count();
        of_meshes + of_cameras > 0
    }
}

impl Scene {
    /// All media, in the order of their ids.
    pub fn media(&self) -> &[Medium] {
        &self.media
    }

    /// Returns true if the interface of any instance, or any camera, names a medium that absorbs or
    /// scatters light.
    #[inline]
    pub fn has_media(&self) -> bool {
        self.has_media
    }

    /// Returns true if [`Self::has_media`] and any medium scatters light.
    pub fn scatters(&self) -> bool {
        self.has_media && self.media.iter().any(Medium::scatters)
    }

    /// Returns true if any material is solid glass, which may form a pane.
    #[inline]
    pub fn refracts(&self) -> bool {
        self.refracts
    }

    /// Returns true if any instance has an interface.
    #[inline]
    pub fn has_interfaces(&self) -> bool {
        self.has_interfaces
    }

    /// Lower bound on the extinction (m⁻¹) along every segment of the scene, for a camera in the
    /// medium `about`. If this medium has constant coefficients and fills the whole scene, the
    /// bound is its least extinction in any channel; otherwise zero.
    pub fn least_extinction(&self, about: Option<MediumId>) -> f32 {
        match about.map(|medium| &self.media[medium.index()]) {
            Some(medium) if !self.has_interfaces && medium.density().is_none() => {
                let Rgb { r, g, b } = medium.extinction();
                r.min(g).min(b)
            }
            _ => 0.0,
        }
    }

    /// Sets the results of [`Self::has_media`] and [`Self::has_interfaces`].
    pub(super) fn count_media(&mut self) {
        let is_placed = |mesh: usize| self.instances.iter().any(|i| i.mesh.index() == mesh);
        let of_mesh = |(mesh, m): (usize, &Mesh)| m.interface.filter(|_| is_placed(mesh));
        let interfaces: Vec<Interface> = self.meshes.iter().enumerate().filter_map(of_mesh).collect();
        let of_cameras = self.cameras.iter().filter_map(|camera| camera.medium);
        let mut named = interfaces.iter().flat_map(Interface::media).chain(of_cameras);
        self.has_media = named.any(|medium| !self.media[medium.index()].is_clear());
        self.has_interfaces = !interfaces.is_empty();
    }

    /// Returns the medium of a path that leaves a surface along `direction`. `before` is the medium
    /// through which the path arrived.
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

    /// Returns true if a surface is only the boundary of a medium.
    #[inline]
    pub fn is_boundary(&self, surface: &SurfacePoint) -> bool {
        matches!(self.material_of(surface.instance).surface, Surface::Boundary)
    }

    /// Checks that the medium of a camera exists.
    ///
    /// # Errors
    /// [`Error::Option`] if the camera names a medium that is not of this scene.
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
    use super::super::volume_grid::VolumeData;
    use super::super::volume_grid::tests::{data, grid};
    use super::*;

    fn medium(absorption: Rgb, scattering: Rgb, asymmetry: f32) -> Medium {
        let phase = HenyeyGreenstein { asymmetry };
        Medium { name: "fog".into(), absorption, scattering, phase, variation: None }
    }

    fn varying(scattering: f32, density: f32, size: f32, albedo: Option<f32>) -> Medium {
        let of = |value: f32| {
            let to_world = crate::math::DAffine3::from_scale(DVec3::splat(f64::from(size)));
            grid(VolumeData { to_world, ..data([2, 2, 2], |c| if c == [1, 1, 0] { value } else { 0.0 }) })
        };
        let scattered = albedo.map_or(Scattered::Evenly, |albedo| Scattered::Albedo(of(albedo)));
        let variation = Some(Arc::new(Variation::new(Some(of(density)), scattered)));
        Medium { variation, ..medium(Rgb::BLACK, Rgb::gray(scattering), 0.0) }
    }

    #[test]
    fn grids_are_held_to_what_paths_can_cross() {
        let said = |m: Medium| m.validate(Location::file("s.xml")).unwrap_err().to_string();
        assert!(varying(1.0, 1e5, 1.0, Some(1.0)).validate(Location::default()).is_ok());
        let thick = said(varying(1.0, 1e5, 10.0, None));
        assert!(
            thick.contains("s.xml: medium fog: an extinction of 1.00") && thick.contains("mean free paths"),
            "{thick}"
        );
        assert!(said(varying(1e9, 1e9, 1e-13, None)).contains("at most 1e9 m⁻¹"));
        let bright = said(varying(1.0, 1.0, 1.0, Some(1.5)));
        assert_eq!(bright, "s.xml: medium fog: an albedo of 1.5; expected albedos from 0 to 1");
        assert!(varying(1.0, 0.0, 1.0, None).is_clear() && !varying(1.0, 1e-3, 1.0, None).is_clear());
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
