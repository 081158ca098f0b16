//! `<medium>`s and phase functions.
//!
//! ```text
//! σ_t = sigma_t · scale, σ_s = albedo σ_t, σ_a = σ_t − σ_s          or          sigma_a · scale, sigma_s · scale (0.6)
//! ```
//!
//! in m⁻¹, if a unit of the file is a metre. A shape's `interior` medium is on the side that its
//! normals point away from, its `exterior` medium on the other side; a side without a medium is
//! vacuum, as in Mitsuba. The medium of a sensor surrounds it. Only some integrators render media:
//! if the file's integrator does not, media are ignored here, too. The extinction and the albedo
//! may be [`volumes`](super::volumes); beyond a grid of the extinction (`density` in version 0.x)
//! is vacuum.
//!
//! Held to this by `suite::media_files`.

use std::sync::Arc;

use super::Translation;
use super::object::{Class, Object};
use super::volumes::Volume;
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::io::notes::shown;
use crate::scene::{Interface, Medium, MediumId, NoteKind, Scattered, Variation};

/// Mitsuba's defaults of extinction (m⁻¹), albedo and asymmetry.
const EXTINCTION: f32 = 1.0;
const ALBEDO: f32 = 0.75;
const ASYMMETRY: f64 = 0.8;

/// Integrators of Mitsuba that render media.
const VOLUMETRIC: [&str; 8] =
    ["volpath", "volpathmis", "prbvolpath", "volpath_simple", "bdpt", "mlt", "pssmlt", "erpt"];

impl<'a> Translation<'a> {
    /// Ignores media, with a note, if the file's integrator does.
    pub(super) fn finish_media(&mut self) {
        let mut integrators = self.document.objects.iter().filter(|o| o.class == Class::Integrator);
        let is_volumetric = integrators.any(|o| VOLUMETRIC.contains(&o.plugin.as_str()));
        if !is_volumetric && self.builder.leave_out_media() {
            let message = "media: left out, as the integrator of the file does";
            self.builder.note(NoteKind::Ignored, message, Location::file(self.files.path()));
        }
    }

    /// Media on both sides of a shape; none if it has no media, or media are ignored.
    pub(super) fn interface(&mut self, object: &Object) -> Result<Option<Interface>> {
        let document = self.document;
        let mut interface = Interface::default();
        for (name, medium) in document.children(object, Class::Medium) {
            let made = self.medium(medium)?;
            match name {
                "exterior" => interface.outside = made,
                "interior" => interface.inside = made,
                _ if made.is_some() => {
                    let message = "media of shapes that are neither interior nor exterior: left out";
                    self.builder.note(NoteKind::Repaired, message, object.at.clone());
                }
                // Subsurface models, which are nested without a name.
                _ => {}
            }
        }
        Ok((interface != Interface::default()).then_some(interface))
    }

    /// Medium around a sensor.
    pub(super) fn medium_about(&mut self, object: &Object) -> Result<Option<MediumId>> {
        let document = self.document;
        let mut about = None;
        for (_, medium) in document.children(object, Class::Medium) {
            about = self.medium(medium)?;
        }
        Ok(about)
    }

    /// Converts a medium; none for vacuum.
    fn medium(&mut self, object: &'a Object) -> Result<Option<MediumId>> {
        if let Some(known) = self.media.begin(object.index, object)? {
            return Ok(known);
        }
        let is_known = self.meet("medium", object, "vacuum")?;
        let made = if is_known && ["homogeneous", "heterogeneous"].contains(&object.plugin.as_str()) {
            let medium = self.made_of(object)?;
            object.note_unused(self.builder.notes_mut())?;
            Some(self.builder.add_medium(medium)?)
        } else {
            if is_known {
                self.without_effect(object)?;
            }
            None
        };
        Ok(self.media.finish(object.index, made))
    }

    fn made_of(&mut self, object: &'a Object) -> Result<Medium> {
        object.accept(&["sample_emitters", "has_spectral_extinction", "method"]);
        if self.document.is_old() && object.text("material").is_some() {
            self.feature("medium", "homogeneous material", &object.at)?;
        }
        let mut scale = object.float("scale").unwrap_or(1.0) as f32;
        if scale < 0.0 {
            self.builder.note(NoteKind::Repaired, "negative scales of media: 0", object.place_of("scale"));
            scale = 0.0;
        }
        let [absorption, scattering] =
            [self.coefficient(object, "sigma_a")?, self.coefficient(object, "sigma_s")?];
        let ([absorption, scattering], variation) = if absorption.is_some() || scattering.is_some() {
            ([absorption, scattering].map(|c| c.unwrap_or(Rgb::BLACK) * scale), None)
        } else {
            let name = if self.document.is_old() && object.plugin == "heterogeneous" {
                "density"
            } else {
                "sigma_t"
            };
            let (extinction, density) = match self.volume(object, name, Some(Rgb::BLACK))? {
                None => (Rgb::gray(EXTINCTION), None),
                Some(Volume::Constant(extinction)) => (extinction, None),
                Some(Volume::Grid(density)) => (Rgb::WHITE, Some(density)),
            };
            let (mut albedo, scattered) = match self.volume(object, "albedo", None)? {
                None => (Rgb::gray(ALBEDO), Scattered::Evenly),
                Some(Volume::Constant(albedo)) => (albedo, Scattered::Evenly),
                Some(Volume::Grid(albedos)) => (Rgb::WHITE, Scattered::Albedo(albedos)),
            };
            if albedo.max_channel() > 1.0 {
                let message = "albedos of media above 1: 1";
                self.builder.note(NoteKind::Repaired, message, object.place_of("albedo"));
                albedo = albedo.map(|v| v.min(1.0));
            }
            let extinction = extinction * scale;
            let varies = density.is_some() || scattered != Scattered::Evenly;
            let variation = varies.then(|| Arc::new(Variation::new(density, scattered)));
            ([extinction * (Rgb::WHITE + albedo * -1.0), extinction * albedo], variation)
        };
        let phase = self.phase(object)?;
        let medium = Medium { name: shown(object.label()), absorption, scattering, phase, variation };
        medium.validate(object.place())?;
        Ok(medium)
    }

    /// Reads a coefficient that is constant in space.
    fn coefficient(&mut self, object: &'a Object, name: &str) -> Result<Option<Rgb>> {
        match self.volume(object, name, Some(Rgb::BLACK))? {
            Some(Volume::Grid(_)) => {
                let found = format!("a grid for {name}");
                Err(Error::invalid(object.place(), found, "grids for sigma_t and albedo"))
            }
            Some(Volume::Constant(color)) => Ok(Some(color)),
            None => Ok(None),
        }
    }

    fn phase(&mut self, object: &'a Object) -> Result<HenyeyGreenstein> {
        let document = self.document;
        let phases = ["", "phase", "phase_function"];
        let mut found = document.children(object, Class::Medium).filter(|(name, _)| phases.contains(name));
        let Some((_, phase)) = found.next() else { return Ok(HenyeyGreenstein::default()) };
        let is_known = self.meet("phase function", phase, "isotropic")?;
        if !is_known {
            return Ok(HenyeyGreenstein::default());
        }
        if phase.plugin != "hg" {
            self.without_effect(phase)?;
            return Ok(HenyeyGreenstein::default());
        }
        let asymmetry = phase.float("g").unwrap_or(ASYMMETRY) as f32;
        let nearest = HenyeyGreenstein::nearest(asymmetry);
        if nearest.asymmetry != asymmetry {
            let message = "asymmetries of media outside -1 to 1: the nearer end";
            self.builder.note(NoteKind::Repaired, message, phase.place_of("g"));
        }
        phase.note_unused(self.builder.notes_mut())?;
        Ok(nearest)
    }
}
