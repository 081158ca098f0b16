//! Values that vary over a mesh: normals, texture coordinates, colours.
//!
//! A primvar has one value for the mesh (`constant`), or one for each face (`uniform`), point
//! (`vertex`, `varying`) or corner (`faceVarying`). A list of indices may select the values.
//!
//! Tested by `usd_meshes` of the suite.

use std::collections::BTreeMap;

use super::Stage;
use super::features::met;
use super::layers::LayerId;
use super::prim::Prim;
use super::value::Value;
use crate::color::Rgb;
use crate::error::Result;
use crate::scene::NoteKind;

/// Colour and opacity of prims without a material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shown {
    pub color: Option<Rgb>,
    pub opacity: Option<f32>,
}

/// Means of primvars, each with a flag that is true if the primvar is constant. The key is the
/// layer and prim of the values, the layer and prim of the indices, and the primvar's name.
pub(super) type MeansOf =
    BTreeMap<((LayerId, u32), Option<(LayerId, u32)>, &'static str), Option<(Vec<f32>, bool)>>;

/// Elements of a mesh to which values belong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Constant,
    Uniform,
    Vertex,
    Corner,
}

/// Numbers of elements of a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counts {
    pub faces: usize,
    pub points: usize,
    pub corners: usize,
}

/// A corner of a face, with an index for each kind of interpolation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub face: usize,
    pub point: usize,
    /// Index among all corners of the mesh.
    pub corner: usize,
}

/// Values of a primvar, `N` numbers each.
#[derive(Clone, Debug)]
pub(super) struct Primvar<const N: usize> {
    interpolation: Interpolation,
    values: Vec<[f32; N]>,
    indices: Option<Vec<usize>>,
}

impl<const N: usize> Primvar<N> {
    /// Index of the value at a corner.
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
    /// Returns the values of an attribute over a mesh. If they do not fit the mesh, returns `None`
    /// and adds a note.
    ///
    /// * `fallback`: the interpolation of an attribute that does not state one.
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
        // Negative indices become `usize::MAX`, which is out of range.
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

    /// Reads the display colour and opacity of a prim. Prims below inherit them only if they are
    /// constant over the prim.
    pub fn show(&mut self, prim: &Prim, [own, below]: [&mut Shown; 2]) -> Result<()> {
        *own = *below;
        if let Some(([r, g, b], is_inherited)) = self.mean::<3>(prim, "displayColor")? {
            let color = Rgb::new(r, g, b).map(|v| v.clamp(0.0, 1.0));
            own.color = color.is_valid().then_some(color).or(own.color);
            below.color = own.color.filter(|_| is_inherited);
        }
        if let Some(([opacity], is_inherited)) = self.mean::<1>(prim, "displayOpacity")? {
            own.opacity = Some(opacity.clamp(0.0, 1.0)).filter(|o| !o.is_nan()).or(own.opacity);
            below.opacity = own.opacity.filter(|_| is_inherited);
        }
        Ok(())
    }

    /// Returns the mean of a primvar over a prim, and true if its interpolation is `constant`. Adds
    /// a note if its values differ.
    fn mean<const N: usize>(&mut self, prim: &Prim, name: &'static str) -> Result<Option<([f32; N], bool)>> {
        let attribute = format!("primvars:{name}");
        let indexed = format!("{attribute}:indices");
        let opinion = |name: &str| self.speaker(prim, name);
        let Some(first) = opinion(&attribute) else { return Ok(None) };
        let key = (first, opinion(&indexed), name);
        let mean = match self.shown.get(&key) {
            Some(known) => known.clone(),
            None => {
                let mean = self.read_mean::<N>(prim, [&attribute, &indexed], name)?;
                let mean = mean.map(|(mean, is_constant)| (mean.to_vec(), is_constant));
                self.shown.insert(key, mean.clone());
                mean
            }
        };
        Ok(mean.and_then(|(mean, is_constant)| Some((mean.try_into().ok()?, is_constant))))
    }

    fn read_mean<const N: usize>(
        &mut self,
        prim: &Prim,
        [attribute, indexed]: [&str; 2],
        name: &str,
    ) -> Result<Option<([f32; N], bool)>> {
        let Some(value) = self.value(prim, attribute)? else { return Ok(None) };
        // A single value may be written without brackets.
        let value = match value {
            Value::Tuple(numbers) => Value::Array { width: numbers.len().max(1), numbers },
            Value::Number(number) => Value::Array { width: 1, numbers: vec![number] },
            value => value,
        };
        let Some(values) = value.array::<N>().filter(|all| !all.is_empty()) else { return Ok(None) };
        let indices = self.value(prim, indexed)?;
        let indices = indices.as_ref().and_then(|indices| indices.numbers()).unwrap_or_default();
        let indexed: Vec<[f64; N]> =
            indices.iter().filter_map(|&i| values.get(i as usize).copied()).collect();
        let all = if indexed.is_empty() { values } else { &indexed };
        let mut sum = [0.0; N];
        for value in all {
            for (sum, number) in sum.iter_mut().zip(value) {
                *sum += number;
            }
        }
        if all.iter().any(|value| *value != all[0]) {
            met("primvar", name, self.at_property(prim, attribute), &mut self.builder)?;
        }
        let interpolation = self.field(prim, attribute, |property| property.interpolation.clone());
        let is_constant = interpolation.is_none_or(|interpolation| &*interpolation == "constant");
        Ok(Some((sum.map(|sum| (sum / all.len() as f64) as f32), is_constant)))
    }
}
