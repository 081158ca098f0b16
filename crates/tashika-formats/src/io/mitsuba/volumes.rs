//! `<volume>`s: coefficients of media.
//!
//! A `constvolume` is one value, constant in space. A `gridvolume` is a file of numbers or colours
//! ([`vol`]) that fills the unit cube, placed by `to_world`. Its values are at the centres of
//! cells; the outermost values extend to the faces. With `use_grid_bbox` the box of the file
//! replaces the unit cube. Files of version 0.x always use the box of the file, and there values
//! are at the corners of cells.
//!
//! Held to this by `suite::media_files`.

use glam::{DMat4, DVec3};

use super::inputs::{Quantity, rgb_of};
use super::object::{Class, Object};
use super::vol::{self, Vol};
use super::{Translation, transforms};
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::io::assets::{kind, reason};
use crate::io::notes::shown;
use crate::scene::{NoteKind, VolumeData, VolumeEdges, VolumeGrid, VolumeSamples};

/// A coefficient or an albedo.
pub(super) enum Volume {
    /// One value everywhere.
    Constant(Rgb),
    Grid(VolumeGrid),
}

impl<'a> Translation<'a> {
    /// Reads a coefficient or an albedo: a number, a colour, a spectrum, or a volume of these. A
    /// grid that cannot be read is replaced by `missing`; if `missing` is none, the parameter
    /// counts as not given.
    pub(super) fn volume(
        &mut self,
        object: &'a Object,
        name: &str,
        missing: Option<Rgb>,
    ) -> Result<Option<Volume>> {
        let document = self.document;
        let volume = document.children(object, Class::Medium).find(|(of, _)| *of == name).map(|(_, v)| v);
        let (holder, name) = match volume {
            None => (object, name),
            Some(volume) if volume.plugin == "constvolume" => (volume, "value"),
            Some(volume) if volume.plugin == "gridvolume" => {
                let grid = self.grid(volume, missing)?;
                return Ok(grid.map(Volume::Grid).or(missing.map(Volume::Constant)));
            }
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
        if let Some(volume) = volume {
            volume.note_unused(self.builder.notes_mut())?;
        }
        match color {
            Some(color) if color.is_finite() => {
                if !color.is_valid() {
                    let message = "negative coefficients and albedos of media: 0";
                    self.builder.note(NoteKind::Repaired, message, holder.place_of(name));
                }
                Ok(Some(Volume::Constant(color.map(|v| v.max(0.0)))))
            }
            _ => {
                let found = match color {
                    Some(color) => format!("{name} = {:?}", color.to_array()),
                    None => format!("{name} that is no number and no colour"),
                };
                Err(Error::invalid(holder.place_of(name), found, "finite numbers"))
            }
        }
    }

    /// Reads a `gridvolume`; none, with a note, if its file cannot be read.
    fn grid(&mut self, object: &'a Object, missing: Option<Rgb>) -> Result<Option<VolumeGrid>> {
        self.meet("volume", object, "")?;
        object.accept(&["raw", "accel"]);
        for (parameter, own) in [("filter_type", "trilinear"), ("wrap_mode", "clamp")] {
            if let Some(asked) = object.text(parameter).filter(|asked| *asked != own) {
                self.feature("volume", &format!("gridvolume {asked}"), &object.at)?;
            }
        }
        let is_old = self.document.is_old();
        let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
        let in_own_box = object.boolean("use_grid_bbox").unwrap_or(false) || is_old;
        let own_box = ["min", "max"].map(|name| object.vector(name).filter(|_| is_old));
        let instead = if missing.is_some() { "nothing is there" } else { "the medium's own value" };
        let Some(reference) = object.text("filename") else {
            let message = format!("volume \"gridvolume\" without a file: {instead}");
            self.builder.note(NoteKind::Repaired, message, object.at.clone());
            object.accept_known();
            object.note_unused(self.builder.notes_mut())?;
            return Ok(None);
        };
        let reference = self.find(reference, object);
        let at = object.place();
        let bytes = match self.files.read(&reference, &at) {
            Ok(bytes) => bytes,
            Err(error @ (Error::Io { .. } | Error::Outside { .. })) => {
                let why = reason(&error);
                let message = format!("volume {:?} could not be read ({why}): {instead}", shown(&reference));
                self.builder.note(kind(&error), message, object.line_of("filename").clone());
                object.accept_known();
                object.note_unused(self.builder.notes_mut())?;
                return Ok(None);
            }
            Err(other) => return Err(other),
        };
        self.volumes.take(bytes.len() as u64, &at)?;
        let file = Location::file(self.files.beside(&reference));
        let Vol { counts, values, bounds } = vol::read(&bytes, &file)?;
        drop(bytes);
        let mut placed = to_world;
        if in_own_box {
            let [lo, hi] = [0, 1]
                .map(|end| own_box[end].unwrap_or_else(|| DVec3::from_array(bounds[end].map(f64::from))));
            placed = to_world * DMat4::from_translation(lo) * DMat4::from_scale(hi - lo);
        }
        let box_to_world = transforms::affine(&placed);
        if !transforms::is_affine(&placed)
            || box_to_world.matrix3.determinant() == 0.0
            || !box_to_world.inverse().is_finite()
        {
            let message = format!("grids of media in a box without volume: {instead}");
            self.builder.note(NoteKind::Repaired, message, at);
            return Ok(None);
        }
        let data = VolumeData {
            counts,
            values,
            to_world: transforms::affine_f64(&placed),
            samples: if is_old { VolumeSamples::Corners } else { VolumeSamples::Centers },
            edges: VolumeEdges::Held,
        };
        object.note_unused(self.builder.notes_mut())?;
        VolumeGrid::new(data, &file).map(Some)
    }
}
