//! Values that vary over a mesh: normals, texture coordinates, colours.
//!
//! A value is that of the mesh (`constant`), of a face (`uniform`), of a point (`vertex`,
//! `varying`) or of a corner (`faceVarying`), perhaps through a list of indices.
//!
//! Held to this by `usd_meshes` of the suite.

use super::Stage;
use super::features::met;
use super::prim::Prim;
use crate::color::Rgb;
use crate::error::Result;
use crate::scene::NoteKind;

/// What a value belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Constant,
    Uniform,
    Vertex,
    Corner,
}

/// How many of each a mesh has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counts {
    pub faces: usize,
    pub points: usize,
    pub corners: usize,
}

/// A place on a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub face: usize,
    pub point: usize,
    /// Among all corners.
    pub corner: usize,
}

/// Values of `N` numbers.
#[derive(Clone, Debug)]
pub(super) struct Primvar<const N: usize> {
    interpolation: Interpolation,
    values: Vec<[f32; N]>,
    indices: Option<Vec<usize>>,
}

impl<const N: usize> Primvar<N> {
    /// Number of the value at a corner.
    pub fn index(&self, at: Corner) -> u32 {
        let index = match self.interpolation {
            Interpolation::Constant => 0,
            Interpolation::Uniform => at.face,
            Interpolation::Vertex => at.point,
            Interpolation::Corner => at.corner,
        };
        self.indices.as_ref().map_or(index, |indices| indices[index]) as u32
    }

    pub fn value(&self, index: u32) -> [f32; N] {
        self.values[index as usize]
    }
}

impl Stage<'_> {
    /// The values of an attribute over a mesh; nothing, with a note, if they do not fit it.
    pub fn primvar<const N: usize>(
        &mut self,
        prim: &Prim,
        name: &str,
        fallback: &str,
        counts: Counts,
    ) -> Result<Option<Primvar<N>>> {
        let Some(value) = self.value(prim, name)? else { return Ok(None) };
        let said = self.field(prim, name, |property| property.interpolation.clone());
        let said = said.unwrap_or_else(|| fallback.into());
        let (interpolation, wanted) = match &*said {
            "uniform" => (Interpolation::Uniform, counts.faces),
            "vertex" | "varying" => (Interpolation::Vertex, counts.points),
            "faceVarying" => (Interpolation::Corner, counts.corners),
            _ => (Interpolation::Constant, 1),
        };
        let values =
            value.array::<N>().map(|all| all.iter().map(|v| v.map(|n| n as f32)).collect::<Vec<_>>());
        let indices = self.value(prim, &format!("{name}:indices"))?;
        let indices = indices.as_ref().and_then(|value| value.numbers());
        // What is not a number of a value has the largest index, which no value has.
        let indices: Option<Vec<usize>> =
            indices.map(|all| all.iter().map(|&i| if i >= 0.0 { i as usize } else { usize::MAX }).collect());
        let fits = values.as_ref().is_some_and(|values| match &indices {
            Some(indices) => indices.len() >= wanted && indices.iter().all(|&i| i < values.len()),
            None => values.len() >= wanted,
        });
        match values.filter(|_| fits && wanted > 0) {
            Some(values) => Ok(Some(Primvar { interpolation, values, indices })),
            None => {
                let message = "normals and texture coordinates that do not fit their mesh: left out";
                let at = self.at_property(prim, name);
                self.builder.note(NoteKind::Repaired, message, at);
                Ok(None)
            }
        }
    }

    /// The colour that a prim shows where no material is bound; the mean, with a note, if it varies.
    pub fn inherited_color(&mut self, prim: &Prim) -> Result<Option<Rgb>> {
        let name = "primvars:displayColor";
        let Some(value) = self.value(prim, name)? else { return Ok(None) };
        let Some(all) = value.array::<3>().filter(|all| !all.is_empty()) else { return Ok(None) };
        let mut sum = [0.0; 3];
        for color in all {
            for (sum, channel) in sum.iter_mut().zip(color) {
                *sum += channel;
            }
        }
        let mean = sum.map(|sum| (sum / all.len() as f64) as f32);
        if all.iter().any(|color| *color != all[0]) {
            met("primvar", "displayColor", self.at_property(prim, name), &mut self.builder)?;
        }
        let color = Rgb::from(mean).map(|v| v.clamp(0.0, 1.0));
        Ok(color.is_valid().then_some(color))
    }
}
