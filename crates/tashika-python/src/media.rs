//! Participating media built from arrays: fog, smoke, milk.

use std::collections::BTreeMap;
use std::sync::Arc;

use pyo3::prelude::*;
use tashika::bsdf::HenyeyGreenstein;
use tashika::color::Rgb;
use tashika::error::{Location, Result};
use tashika::math::DAffine3;
use tashika::scene::{
    self, MediumId, Scattered, SceneBuilder, Variation, VolumeData, VolumeEdges, VolumeGrid, VolumeSamples,
    VolumeValues,
};

use crate::arrays::{Array, Content};
use crate::building::placements;
use crate::errors::{option, raised};
use crate::materials::Color;

/// A medium that fills a space. `absorption` and `scattering` are coefficients (m⁻¹), a colour
/// each; `g` (-1 to 1) is the asymmetry of the phase function of Henyey and Greenstein, 0 for
/// scattering in all directions alike.
///
/// `density` is a factor of both coefficients that varies in space: an array of shape (depth,
/// height, width), or (depth, height, width, 3) by channel. Its samples are at the middles of the
/// cells of a box, with the width along x. The box is the unit cube, placed by `transform`, a
/// matrix of shape (4, 4); beyond it the medium is clear. `albedo` is an array of the same kind:
/// the share of the extinction that is scattering, 0 to 1. It replaces the share that follows from
/// the coefficients. Arrays are copied.
///
/// A mesh may have a medium `inside` and one `outside`, a camera may stand `within` one. By
/// default, scenes with media that scatter are rendered by paths.
///
/// ```python
/// >>> import numpy as np
/// >>> fog = tashika.Medium(absorption=0.01, scattering=(0.2, 0.2, 0.25), g=0.5)
/// >>> smoke = tashika.Medium(0, 5, density=np.random.default_rng(1).random((4, 8, 8)))
/// >>> smoke
/// <tashika.Medium "medium", varying>
/// ```
#[pyclass(frozen, module = "tashika")]
pub struct Medium(scene::Medium);

#[pymethods]
impl Medium {
    #[new]
    #[pyo3(signature = (absorption, scattering, *, g=0.0, density=None, albedo=None, transform=None, name="medium"))]
    fn new(
        absorption: Color,
        scattering: Color,
        g: f32,
        density: Option<&Bound<'_, PyAny>>,
        albedo: Option<&Bound<'_, PyAny>>,
        transform: Option<&Bound<'_, PyAny>>,
        name: &str,
    ) -> PyResult<Self> {
        let to_world = match transform.map(|matrix| placements("transform", matrix)).transpose()?.as_deref() {
            None => DAffine3::IDENTITY,
            Some([to_world]) => *to_world,
            Some(several) => {
                return Err(option("transform", format!("{} matrices", several.len()), "one"));
            }
        };
        let grid = |name, array: Option<&Bound<'_, PyAny>>, edges| {
            array.map(|array| grid(name, array, to_world, edges)).transpose()
        };
        let density = grid("density", density, VolumeEdges::Zero)?;
        let albedo = grid("albedo", albedo, VolumeEdges::Held)?;
        let varies = density.is_some() || albedo.is_some();
        let scattered = albedo.map_or(Scattered::Evenly, Scattered::Albedo);
        let medium = scene::Medium {
            name: name.to_owned(),
            absorption: absorption.into(),
            scattering: scattering.into(),
            phase: HenyeyGreenstein { asymmetry: g },
            variation: varies.then(|| Arc::new(Variation::new(density, scattered))),
        };
        medium.validate(Location::default()).map_err(raised)?;
        Ok(Self(medium))
    }

    fn __repr__(&self) -> String {
        let varies = if self.0.variation.is_some() { ", varying" } else { "" };
        format!("<tashika.Medium {:?}{varies}>", self.0.name)
    }
}

/// Grid of numbers or of colours in the box that `to_world` places.
fn grid(
    name: &str,
    array: &Bound<'_, PyAny>,
    to_world: DAffine3,
    edges: VolumeEdges,
) -> PyResult<VolumeGrid> {
    let Array { shape, content } = Array::read(name, array)?;
    let Content::Floats(numbers) = content else {
        return Err(option(name, "an array of uint8", "an array of other numbers"));
    };
    let (counts, values) = match shape[..] {
        [depth, height, width] => ([width, height, depth], VolumeValues::Numbers(numbers)),
        [depth, height, width, 3] => {
            let colors = numbers.as_chunks::<3>().0.iter().map(|rgb| Rgb::from(*rgb)).collect();
            ([width, height, depth], VolumeValues::Colors(colors))
        }
        _ => {
            let expected = "(depth, height, width), or (depth, height, width, 3)";
            return Err(option(name, format!("an array of the shape {shape:?}"), expected));
        }
    };
    let counts = counts.map(|count| count as u32);
    let data = VolumeData { counts, values, to_world, samples: VolumeSamples::Centers, edges };
    VolumeGrid::new(data, &Location::default().item(name)).map_err(raised)
}

/// Adds media to a scene, each once.
#[derive(Default)]
pub struct Media {
    /// Media by the address of their Python object.
    known: BTreeMap<usize, MediumId>,
}

impl Media {
    /// Returns the number of a medium in the scene; none for no medium.
    pub fn add(
        &mut self,
        medium: Option<&Bound<'_, Medium>>,
        builder: &mut SceneBuilder,
    ) -> Result<Option<MediumId>> {
        let Some(medium) = medium else { return Ok(None) };
        let address = medium.as_ptr() as usize;
        if let Some(id) = self.known.get(&address) {
            return Ok(Some(*id));
        }
        let id = builder.add_medium(medium.get().0.clone())?;
        self.known.insert(address, id);
        Ok(Some(id))
    }
}
