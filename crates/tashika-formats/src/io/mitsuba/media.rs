//! `<medium>`s and phase functions.
//!
//! ```text
//! σ_t = sigma_t · scale, σ_s = albedo σ_t, σ_a = σ_t − σ_s          or          sigma_a · scale, sigma_s · scale (0.6)
//! ```
//!
//! in m⁻¹, if a unit of the file is a metre. A medium of a shape is `interior`, where its normals
//! point away from, or `exterior`; a side that is not named is vacuum, as in Mitsuba. A medium of a
//! sensor is what it stands in. Only some integrators look at media: where that of the file does not,
//! they are left out here, too. A volume that is the same everywhere (`constvolume`) counts as its
//! value.
//!
//! Held to this by `suite::media_files`.

use super::Translation;
use super::inputs::{Quantity, rgb_of};
use super::object::{Class, Object};
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::io::notes::shown;
use crate::scene::{Interface, Medium, MediumId, NoteKind};

/// Mitsuba's extinction (m⁻¹), albedo and asymmetry, if the file gives none.
const EXTINCTION: f32 = 1.0;
const ALBEDO: f32 = 0.75;
const ASYMMETRY: f64 = 0.8;

/// Integrators of Mitsuba that render media.
const VOLUMETRIC: [&str; 8] =
    ["volpath", "volpathmis", "prbvolpath", "volpath_simple", "bdpt", "mlt", "pssmlt", "erpt"];

impl<'a> Translation<'a> {
    /// Leaves media out where the integrator of the file does.
    pub(super) fn finish_media(&mut self) {
        let mut integrators = self.document.objects.iter().filter(|o| o.class == Class::Integrator);
        let is_volumetric = integrators.any(|o| VOLUMETRIC.contains(&o.plugin.as_str()));
        if !is_volumetric && self.builder.leave_out_media() {
            let message = "media: left out, as the integrator of the file does";
            self.builder.note(NoteKind::Ignored, message, Location::file(self.files.path()));
        }
    }

    /// The media on the two sides of a shape, if it has any that are not left out.
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
                // Subsurface models, which have no name.
                _ => {}
            }
        }
        Ok((interface != Interface::default()).then_some(interface))
    }

    /// What a sensor stands in.
    pub(super) fn medium_about(&mut self, object: &Object) -> Result<Option<MediumId>> {
        let document = self.document;
        let mut about = None;
        for (_, medium) in document.children(object, Class::Medium) {
            about = self.medium(medium)?;
        }
        Ok(about)
    }

    /// What a medium becomes; nothing for vacuum.
    fn medium(&mut self, object: &'a Object) -> Result<Option<MediumId>> {
        if let Some(known) = self.media.begin(object.index, object)? {
            return Ok(known);
        }
        let is_known = self.meet("medium", object, "vacuum")?;
        let made = if is_known && object.plugin == "homogeneous" {
            let medium = self.homogeneous(object)?;
            object.note_unused(self.builder.notes_mut());
            Some(self.builder.add_medium(medium)?)
        } else {
            object.accept_all();
            None
        };
        Ok(self.media.finish(object.index, made))
    }

    fn homogeneous(&mut self, object: &'a Object) -> Result<Medium> {
        object.accept(&["sample_emitters", "has_spectral_extinction"]);
        if self.document.is_old() && object.text("material").is_some() {
            self.feature("medium", "homogeneous material", &object.at)?;
        }
        let scale = object.float("scale").unwrap_or(1.0) as f32;
        let [absorption, scattering] =
            [self.coefficient(object, "sigma_a")?, self.coefficient(object, "sigma_s")?];
        let [absorption, scattering] = if absorption.is_some() || scattering.is_some() {
            [absorption, scattering].map(|c| c.unwrap_or(Rgb::BLACK) * scale)
        } else {
            let extinction = self.coefficient(object, "sigma_t")?.unwrap_or(Rgb::gray(EXTINCTION)) * scale;
            let albedo = self.coefficient(object, "albedo")?.unwrap_or(Rgb::gray(ALBEDO));
            if albedo.max_channel() > 1.0 {
                let found = format!("albedo = {:?}", albedo.to_array());
                return Err(Error::invalid(object.place_of("albedo"), found, "an albedo from 0 to 1"));
            }
            [extinction * (Rgb::WHITE + albedo * -1.0), extinction * albedo]
        };
        let phase = self.phase(object)?;
        let medium = Medium { name: shown(object.label()), absorption, scattering, phase, variation: None };
        medium.validate(object.place())?;
        Ok(medium)
    }

    /// A coefficient or an albedo: a number, a colour, a spectrum, or a constant volume of these.
    fn coefficient(&mut self, object: &'a Object, name: &str) -> Result<Option<Rgb>> {
        let document = self.document;
        let volume = document.children(object, Class::Medium).find(|(of, _)| *of == name).map(|(_, v)| v);
        let (holder, name) = match volume {
            None => (object, name),
            Some(volume) if volume.plugin == "constvolume" => (volume, "value"),
            Some(volume) => {
                volume.accept_all();
                self.meet("volume", volume, "the medium's own value")?;
                return Ok(None);
            }
        };
        if holder.parameters.iter().all(|p| p.name != name) {
            return Ok(None);
        }
        let color = holder.take(name, |value| rgb_of(value, Quantity::Number));
        match color {
            Some(color) if color.is_valid() => Ok(Some(color)),
            _ => {
                let found = match color {
                    Some(color) => format!("{name} = {:?}", color.to_array()),
                    None => format!("{name} that is no number and no colour"),
                };
                Err(Error::invalid(holder.place_of(name), found, "finite numbers of at least 0"))
            }
        }
    }

    fn phase(&mut self, object: &'a Object) -> Result<HenyeyGreenstein> {
        let document = self.document;
        let phases = ["", "phase", "phase_function"];
        let mut found = document.children(object, Class::Medium).filter(|(name, _)| phases.contains(name));
        let Some((_, phase)) = found.next() else { return Ok(HenyeyGreenstein::default()) };
        let is_known = self.meet("phase function", phase, "isotropic")?;
        if !is_known || phase.plugin != "hg" {
            phase.accept_all();
            return Ok(HenyeyGreenstein::default());
        }
        let asymmetry = HenyeyGreenstein { asymmetry: phase.float("g").unwrap_or(ASYMMETRY) as f32 };
        if !asymmetry.is_valid() {
            let found = format!("g = {}", asymmetry.asymmetry);
            return Err(Error::invalid(phase.place_of("g"), found, "a number between -1 and 1"));
        }
        phase.note_unused(self.builder.notes_mut());
        Ok(asymmetry)
    }
}
