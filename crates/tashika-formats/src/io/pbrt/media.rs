//! `MakeNamedMedium` and `MediumInterface`.
//!
//! ```text
//! σ_a, σ_s = "sigma_a", "sigma_s" times "scale"          (m⁻¹, if a unit of the file is a metre)
//! ```
//!
//! `MediumInterface` says what is inside and outside of the shapes that follow, and its second name
//! what the camera stands in; one name alone is both. As in pbrt, a shape with the same on both
//! sides is no interface, so that what stands in fog changes nothing; the inside is where the
//! surface normal points away from. A name stands for what was defined before. Only some integrators
//! look at media: where that of the file does not, they are left out here, too.
//!
//! Source: Pharr et al. 2023, chapter 11. Tested by `suite::media_files`.

use std::collections::BTreeMap;

use super::loading::Loading;
use super::parameters::{Parameters, Values};
use super::spectra::{self, Quantity};
use super::version::Version;
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::io::notes::excerpt;
use crate::scene::{Interface, Medium, MediumId, NoteKind};

/// pbrt's own coefficients, if the file gives none (m⁻¹).
const ABSORPTION: Rgb = Rgb::new(0.0011, 0.0024, 0.014);
const SCATTERING: Rgb = Rgb::new(2.55, 3.21, 3.77);

/// Integrators that render media.
const VOLUMETRIC: [&str; 4] = ["volpath", "simplevolpath", "bdpt", "mlt"];

/// Leaves media out where the integrator of the file does; without one, it is `path` in version 3 and
/// `volpath` in version 4.
pub(super) fn finish(loading: &mut Loading<'_>, integrator: Option<&str>) {
    let own = if loading.version == Version::V3 { "path" } else { "volpath" };
    if !VOLUMETRIC.contains(&integrator.unwrap_or(own)) && loading.builder.leave_out_media() {
        let at = Location::file(loading.files.path());
        loading.note(NoteKind::Ignored, "media: left out, as the integrator of the file does", at);
    }
}

/// The media that the file has named.
#[derive(Debug, Default)]
pub(super) struct Media {
    /// Nothing for what is taken as vacuum.
    named: BTreeMap<String, Option<MediumId>>,
}

/// What `MediumInterface` has said last; nothing is vacuum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sides {
    inside: Option<MediumId>,
    /// Also about the camera.
    pub(super) outside: Option<MediumId>,
}

impl Sides {
    /// Of shapes that separate one from another.
    pub(super) fn interface(self) -> Option<Interface> {
        let Self { inside, outside } = self;
        (inside != outside).then_some(Interface { inside, outside })
    }
}

impl Media {
    /// `MakeNamedMedium name`.
    ///
    /// # Errors
    /// Coefficients that are negative or too large, an asymmetry that is not between −1 and 1.
    pub(super) fn define(&mut self, loading: &mut Loading<'_>, name: &str, p: &Parameters) -> Result<()> {
        let Some(class) = p.string("type").map(str::to_owned) else {
            loading.note(NoteKind::Repaired, "media without type: vacuum", p.at());
            p.accept_all();
            self.named.insert(name.to_owned(), None);
            return Ok(());
        };
        loading.met("medium", &class, "vacuum", &p.at())?;
        let medium = if class == "homogeneous" { Some(homogeneous(loading, name, p)?) } else { None };
        if medium.is_some() {
            loading.note_unused("medium \"homogeneous\"", p);
        }
        self.named.insert(name.to_owned(), medium);
        Ok(())
    }

    /// `MediumInterface`: the names of the inside and the outside.
    pub(super) fn sides(&self, loading: &mut Loading<'_>, names: [&str; 2], at: &Location) -> Sides {
        let [inside, outside] = names.map(|name| match self.named.get(name) {
            _ if name.is_empty() => None,
            Some(known) => *known,
            None => {
                let message = format!("medium {:?} is not defined: vacuum", excerpt(name, 60));
                loading.note_named(NoteKind::Repaired, message, "media are not defined", at.clone());
                None
            }
        });
        Sides { inside, outside }
    }
}

fn homogeneous(loading: &mut Loading<'_>, name: &str, p: &Parameters) -> Result<MediumId> {
    let at = p.at();
    if p.string("preset").is_some() {
        loading.met("medium", "homogeneous preset", "", &at)?;
    }
    let glows = ["Le", "Lescale"].into_iter().any(|name| p.unused().any(|parameter| parameter.name == name));
    if glows {
        loading.met("medium", "homogeneous Le", "", &at)?;
        p.accept(&["Le", "Lescale"]);
    }
    let scale = p.float("scale").unwrap_or(1.0);
    let absorption = coefficient(loading, p, "sigma_a")?.unwrap_or(ABSORPTION) * scale;
    let scattering = coefficient(loading, p, "sigma_s")?.unwrap_or(SCATTERING) * scale;
    let phase = HenyeyGreenstein { asymmetry: p.float("g").unwrap_or(0.0) };
    let medium = Medium { name: excerpt(name, 60), absorption, scattering, phase, variation: None };
    medium.validate(at)?;
    loading.builder.add_medium(medium)
}

/// A coefficient before it is scaled.
fn coefficient(loading: &mut Loading<'_>, p: &Parameters, name: &str) -> Result<Option<Rgb>> {
    let negative = p.find(spectra::SPECTRAL, name).filter(
        |parameter| matches!(&parameter.values, Values::Numbers(numbers) if numbers.iter().any(|v| *v < 0.0)),
    );
    if let Some(parameter) = negative {
        let found = format!("parameter {:?} with a negative number", parameter.declaration);
        return Err(Error::invalid(parameter.at(), found, "coefficients of at least 0"));
    }
    spectra::color(loading, p, name, Quantity::Factor)
}
