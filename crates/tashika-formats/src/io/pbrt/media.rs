//! `MakeNamedMedium` and `MediumInterface`.
//!
//! ```text
//! σ_a, σ_s = "sigma_a", "sigma_s" times "scale"          (m⁻¹, if a unit of the file is a metre)
//! ```
//!
//! `MediumInterface` sets the media inside and outside of the shapes that follow; the outside is
//! also the medium of the camera. A single name sets both. As in pbrt, a shape with the same medium
//! on both sides is no interface, so that objects in fog do not change it. The surface normal
//! points away from the inside. A name refers to a definition before it; in pbrt-v4 the definition
//! may also follow. Only some integrators render media: if the file's integrator does not, media
//! are ignored here, too.
//!
//! In grid media (`uniformgrid`; `heterogeneous` in version 3), the coefficients are multiplied by
//! a density. The density has `nx · ny · nz` cells that fill the box from `p0` to `p1`; the current
//! transform places the box as it places shapes. Media of `rgbgrid` have coefficients for each
//! cell. As in pbrt, values fall to zero within half a cell of the faces. A `nanovdb` medium has
//! the grid named `density` of its file; the file's own map is applied before the current
//! transform.
//!
//! Source: Pharr et al. 2023, chapter 11. Tested by `suite::media_files`.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::loading::Loading;
use super::names::Named;
use super::parameters::Parameters;
use super::spectra::{self, Quantity};
use super::transform;
use super::version::Version;
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::io::assets::{kind, reason};
use crate::io::nanovdb;
use crate::io::notes::excerpt;
use crate::scene::{
    Interface, Medium, MediumId, NoteKind, Scattered, Variation, VolumeData, VolumeEdges, VolumeGrid,
    VolumeSamples, VolumeValues,
};

/// pbrt's default coefficients (m⁻¹).
const ABSORPTION: Rgb = Rgb::new(0.0011, 0.0024, 0.014);
const SCATTERING: Rgb = Rgb::new(2.55, 3.21, 3.77);

/// Integrators that render media.
const VOLUMETRIC: [&str; 4] = ["volpath", "simplevolpath", "bdpt", "mlt"];

/// Ignores media, with a note, if the file's integrator does. The default integrator is `path` in
/// version 3 and `volpath` in version 4.
pub(super) fn finish(loading: &mut Loading<'_>, integrator: Option<&str>) {
    let own = if loading.version == Version::V3 { "path" } else { "volpath" };
    if !VOLUMETRIC.contains(&integrator.unwrap_or(own)) && loading.builder.leave_out_media() {
        let at = Location::file(loading.files.path());
        loading.note(NoteKind::Ignored, "media: left out, as the integrator of the file does", at);
    }
}

/// Media that the file has named.
#[derive(Debug, Default)]
pub(super) struct Media {
    /// Media by name; none stands for vacuum.
    named: BTreeMap<String, Option<MediumId>>,
}

/// Media of the last `MediumInterface`; none is vacuum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sides {
    inside: Option<MediumId>,
    /// Medium outside of shapes, and around the camera.
    pub(super) outside: Option<MediumId>,
}

impl Sides {
    /// Interface of shapes, if both sides differ.
    pub(super) fn interface(self) -> Option<Interface> {
        let Self { inside, outside } = self;
        (inside != outside).then_some(Interface { inside, outside })
    }
}

impl Media {
    /// Returns the names of all media.
    pub(super) fn names(&self) -> Vec<String> {
        self.named.keys().cloned().collect()
    }

    /// Executes `MakeNamedMedium name`; a grid is placed by `to_world`.
    ///
    /// # Errors
    /// Coefficients that are too large; a grid without cells, or whose number of values differs
    /// from its number of cells.
    pub(super) fn define(
        &mut self,
        loading: &mut Loading<'_>,
        name: &str,
        p: &Parameters,
        to_world: Option<DAffine3>,
    ) -> Result<()> {
        let Some(class) = p.string("type").map(str::to_owned) else {
            loading.note(NoteKind::Repaired, "media without type: vacuum", p.at());
            p.accept_known();
            loading.note_unused("medium", "", p)?;
            self.named.insert(name.to_owned(), None);
            return Ok(());
        };
        loading.met("medium", &class, "vacuum", &p.at())?;
        let medium = match class.as_str() {
            "homogeneous" | "heterogeneous" | "uniformgrid" | "rgbgrid" | "nanovdb" => {
                match made_of(loading, &class, name, p, to_world)? {
                    Some(medium) => Some(loading.builder.add_medium(medium)?),
                    None => None,
                }
            }
            _ => None,
        };
        if Loading::knows("medium", &class) {
            if medium.is_none() {
                p.accept_known();
            }
            loading.note_unused("medium", &class, p)?;
        }
        self.named.insert(name.to_owned(), medium);
        Ok(())
    }

    /// Returns the media that `MediumInterface` names, inside first.
    pub(super) fn sides(&self, loading: &mut Loading<'_>, names: [&str; 2], at: &Location) -> Sides {
        let [inside, outside] = names.map(|name| match self.named.get(name) {
            _ if name.is_empty() => None,
            Some(known) => *known,
            None => {
                loading.names.miss(Named::Medium, name, at);
                let message = format!("medium {:?} is not defined: vacuum", excerpt(name, 60));
                loading.note_named(NoteKind::Repaired, message, "media are not defined", at.clone());
                None
            }
        });
        Sides { inside, outside }
    }
}

/// Medium of the parameters; none, with a note, if a file cannot be read or a grid has no volume.
fn made_of(
    loading: &mut Loading<'_>,
    class: &str,
    name: &str,
    p: &Parameters,
    to_world: Option<DAffine3>,
) -> Result<Option<Medium>> {
    let at = p.at();
    if class == "homogeneous" && p.string("preset").is_some() {
        loading.met("medium", "homogeneous preset", "", &at)?;
    }
    let glow = ["Le", "Lescale", "temperature", "temperaturescale", "temperatureoffset", "temperaturecutoff"];
    let is_glow = |name: &str| glow.contains(&name);
    if p.unused().any(|parameter| is_glow(&parameter.name)) {
        loading.met(
            "medium",
            if class == "homogeneous" { "homogeneous Le" } else { "uniformgrid Le" },
            "",
            &at,
        )?;
        p.accept(&glow);
    }
    let scale = scale(loading, p);
    let asymmetry = p.float("g").unwrap_or(0.0);
    let phase = HenyeyGreenstein::nearest(asymmetry);
    if phase.asymmetry != asymmetry {
        let message = "asymmetries of media outside -1 to 1: the nearer end";
        loading.note(NoteKind::Repaired, message, p.place_of("g"));
    }
    let name = excerpt(name, 60);
    let medium = if class == "rgbgrid" {
        let [absorption, scattering] = of_cells(loading, p, scale)?;
        let all = absorption.iter().zip(&scattering).map(|(a, s)| *a + *s).collect();
        let mut grid = |values| grid(loading, p, VolumeValues::Colors(values), to_world);
        let (Some(all), Some(scattering)) = (grid(all)?, grid(scattering)?) else { return Ok(None) };
        let variation = Variation::new(Some(all), Scattered::Coefficient(scattering));
        let (absorption, scattering, variation) = (Rgb::BLACK, Rgb::WHITE, Some(Arc::new(variation)));
        Medium { name, absorption, scattering, phase, variation }
    } else {
        let is_new_grid = ["uniformgrid", "nanovdb"].contains(&class);
        let own = if is_new_grid { [Rgb::WHITE; 2] } else { [ABSORPTION, SCATTERING] };
        let absorption = coefficient(loading, p, "sigma_a")?.unwrap_or(own[0]) * scale;
        let scattering = coefficient(loading, p, "sigma_s")?.unwrap_or(own[1]) * scale;
        let variation = if class == "homogeneous" {
            None
        } else {
            let density = if class == "nanovdb" {
                grid_of_file(loading, p, to_world)?
            } else {
                let density = VolumeValues::Numbers(p.floats("density").unwrap_or_default().to_vec());
                grid(loading, p, density, to_world)?
            };
            let Some(density) = density else { return Ok(None) };
            Some(Arc::new(Variation::new(Some(density), Scattered::Evenly)))
        };
        Medium { name, absorption, scattering, phase, variation }
    };
    medium.validate(at)?;
    Ok(Some(medium))
}

/// Factor on the coefficients.
fn scale(loading: &mut Loading<'_>, p: &Parameters) -> f32 {
    let scale = p.float("scale").unwrap_or(1.0);
    if scale < 0.0 {
        loading.note(NoteKind::Repaired, "negative scales of media: 0", p.place_of("scale"));
        return 0.0;
    }
    scale
}

/// Returns the transform of a grid if its box has a volume; none, with a note, otherwise.
fn placed(loading: &mut Loading<'_>, p: &Parameters, to_world: Option<DAffine3>) -> Option<DAffine3> {
    let placed = to_world.filter(|t| transform::placeable(t).is_some());
    if placed.is_none() {
        loading.note(NoteKind::Repaired, "grids of media in a box without volume: vacuum", p.at());
        p.accept_known();
    }
    placed
}

/// Reads the densities of a NanoVDB file.
fn grid_of_file(
    loading: &mut Loading<'_>,
    p: &Parameters,
    to_world: Option<DAffine3>,
) -> Result<Option<VolumeGrid>> {
    let at = p.at();
    let Some(reference) = p.string("filename").map(str::to_owned) else {
        loading.note(NoteKind::Repaired, "medium \"nanovdb\" without a file: vacuum", at);
        p.accept_known();
        return Ok(None);
    };
    let file = Location::file(loading.files.beside(&reference));
    let read = loading.files.read(&reference, &at).and_then(|bytes| {
        loading.geometry.take(bytes.len() as u64, &at)?;
        nanovdb::read(&bytes, "density", loading.geometry.left(), &file)
    });
    let nano = match read {
        Ok(nano) => nano,
        Err(error @ (Error::Io { .. } | Error::Outside { .. } | Error::Unsupported { .. })) => {
            let why = reason(&error);
            let message = format!("grid {:?} could not be read ({why}): vacuum", excerpt(&reference, 60));
            let at = p.place_of("filename");
            loading.note_named(kind(&error), message, "grids that could not be read", at);
            p.accept_known();
            return Ok(None);
        }
        Err(error) => return Err(error),
    };
    loading.geometry.take(4 * nano.values.len() as u64, &at)?;
    let [lowest, size] =
        [nano.lowest.map(f64::from), nano.counts.map(|n| f64::from(n - 1))].map(DVec3::from_array);
    let indices = DAffine3::from_translation(lowest) * DAffine3::from_scale(size);
    let to_world = to_world.map(|t| t * nano.to_world * indices);
    let Some(to_world) = placed(loading, p, to_world) else { return Ok(None) };
    let data = VolumeData {
        counts: nano.counts,
        values: VolumeValues::Numbers(nano.values),
        to_world,
        samples: VolumeSamples::Corners,
        edges: VolumeEdges::Held,
    };
    VolumeGrid::new(data, &file).map(Some)
}

/// Grid of the cells that the parameters list, in the box from `p0` to `p1`.
fn grid(
    loading: &mut Loading<'_>,
    p: &Parameters,
    values: VolumeValues,
    to_world: Option<DAffine3>,
) -> Result<Option<VolumeGrid>> {
    let at = p.at();
    // Counted for each medium: values that come from `Attribute` are copied to any number of them.
    let bytes = if matches!(values, VolumeValues::Numbers(_)) { 4 } else { 12 };
    loading.geometry.take(bytes * values.len() as u64, &at)?;
    let counts = ["nx", "ny", "nz"].map(|name| p.integer(name).unwrap_or(1));
    let [Ok(nx), Ok(ny), Ok(nz)] = counts.map(u32::try_from) else {
        return Err(Error::invalid(
            at,
            format!("a grid of {counts:?} cells"),
            "at least one along each axis",
        ));
    };
    let corner = |name, own| p.points(name).first().copied().unwrap_or(own);
    let [p0, p1] = [corner("p0", DVec3::ZERO), corner("p1", DVec3::ONE)];
    let to_world = to_world.map(|t| t * DAffine3::from_translation(p0) * DAffine3::from_scale(p1 - p0));
    let Some(to_world) = placed(loading, p, to_world) else { return Ok(None) };
    let data = VolumeData {
        counts: [nx, ny, nz],
        values,
        to_world,
        samples: VolumeSamples::Centers,
        edges: VolumeEdges::Zero,
    };
    VolumeGrid::new(data, &at).map(Some)
}

/// Absorption and scattering coefficients of each cell. If only one of the two is given, the other
/// is 1 before scaling.
fn of_cells(loading: &mut Loading<'_>, p: &Parameters, scale: f32) -> Result<[Vec<Rgb>; 2]> {
    let given = ["sigma_a", "sigma_s"].map(|name| spectra::colors(loading, p, name));
    let cells = given.iter().flatten().map(Vec::len).max().unwrap_or(0);
    if given.iter().flatten().any(|colors| colors.len() != cells) {
        let found = given.map(|colors| colors.map_or(0, |c| c.len()));
        let found = format!("{} colours for absorption and {} for scattering", found[0], found[1]);
        return Err(Error::invalid(p.at(), found, "as many of each"));
    }
    let scaled = |color: Rgb| color * scale;
    Ok(given.map(|colors| match colors {
        Some(colors) => colors.into_iter().map(scaled).collect(),
        None => vec![scaled(Rgb::WHITE); cells],
    }))
}

/// Coefficient before it is scaled.
fn coefficient(loading: &mut Loading<'_>, p: &Parameters, name: &str) -> Result<Option<Rgb>> {
    spectra::color(loading, p, name, Quantity::Factor)
}
