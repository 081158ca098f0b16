//! Sets of virtual point lights: traced, read, or made of arrays.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyType;
use tashika::io::{load_vpls, save_vpls};
use tashika::math::{DVec3, LocalPlaces};
use tashika::request::Request;
use tashika::tree::LightSet;
use tashika::vpl::{self, Provenance, Vpl, VplKind};

use crate::arrays::{array, float_rows, index_column, vectors, wide_rows, wide_vectors};
use crate::attended::attended;
use crate::errors::{option, raised};
use crate::json::from_json;
use crate::scene::Scene;
use crate::words;

/// A set of virtual point lights (VPLs), with its provenance.
///
/// Arrays are copies, one row a light.
///
/// ```python
/// >>> lights = tashika.vpls(tashika.builtin("tiny"), count=200)
/// >>> lights.positions.shape, lights.intensities.dtype, lights.provenance["scene"]
/// ((210, 3), dtype('float32'), 'tiny')
/// ```
#[pyclass(frozen, module = "tashika")]
pub struct VplSet(Arc<LightSet>);

impl VplSet {
    pub(crate) fn new(set: vpl::VplSet) -> Self {
        Self(Arc::new(set.into()))
    }

    /// The set, with the tree over it once that is built.
    pub(crate) fn shared(&self) -> Arc<LightSet> {
        Arc::clone(&self.0)
    }
}

#[pymethods]
impl VplSet {
    /// Names of the kinds, by the numbers in `kinds`.
    #[classattr]
    const KINDS: [&str; VplKind::COUNT] = ["omni", "oriented", "spot", "directional", "volume"];

    /// A set of lights given by arrays of `n` rows: positions (m), unit normals, intensities
    /// (W/sr). `kinds` are numbers of `KINDS`, all "oriented" if not given; oriented lights emit
    /// their intensity times the cosine to the normal. Omni lights have the normal zero. The normal
    /// of directional lights is the direction of their light, and their intensity an irradiance
    /// (W/m²). Lights in media and spots cannot be given; lights that emit by an image are spots.
    /// `scene` names the scene that the set belongs to; `clamp` is the distance (m) below which a
    /// light grows no brighter, 0 for none.
    ///
    /// ```python
    /// >>> lamp = tashika.VplSet.from_arrays([[0, 1, 0]], [[0, -1, 0]], [[5, 5, 5]])
    /// >>> len(lamp), tashika.VplSet.KINDS[lamp.kinds[0]]
    /// (1, 'oriented')
    /// ```
    #[classmethod]
    #[pyo3(signature = (positions, normals, intensities, kinds=None, *, scene="", clamp=0.0))]
    fn from_arrays(
        _class: &Bound<'_, PyType>,
        positions: &Bound<'_, PyAny>,
        normals: &Bound<'_, PyAny>,
        intensities: &Bound<'_, PyAny>,
        kinds: Option<&Bound<'_, PyAny>>,
        scene: &str,
        clamp: f32,
    ) -> PyResult<Self> {
        let positions: Vec<DVec3> =
            wide_rows::<3>("positions", positions)?.into_iter().map(DVec3::from).collect();
        let LocalPlaces { origin, places: positions } = LocalPlaces::of(&positions);
        let count = positions.len();
        let normals = as_many("normals", float_rows::<3>("normals", normals)?, count)?;
        let intensities = as_many("intensities", float_rows::<3>("intensities", intensities)?, count)?;
        let oriented = VplKind::Oriented.number() as u32;
        let kinds = kinds.map_or(Ok(vec![oriented; count]), |kinds| index_column("kinds", kinds))?;
        let kinds = as_many("kinds", kinds, count)?;
        if !(clamp >= 0.0 && clamp.is_finite()) {
            return Err(option("clamp", clamp, "a distance of 0 or more metres"));
        }
        let light = |i: usize| {
            let plain = [VplKind::Omni, VplKind::Oriented, VplKind::Directional];
            let kind = plain.into_iter().find(|kind| kind.number() as u32 == kinds[i]);
            let kind =
                kind.ok_or_else(|| option("kinds", kinds[i], "0 (omni), 1 (oriented) or 3 (directional)"))?;
            let light = Vpl {
                position: positions[i],
                direction: normals[i].into(),
                intensity: intensities[i].into(),
                kind,
            };
            light.is_sound().then_some(light).ok_or_else(|| {
                let expected =
                    "finite positions, unit normals (zero for omni lights), intensities of at least 0";
                option("lights", format!("{light:?} in row {i}"), expected)
            })
        };
        let lights: Vec<Vpl> = (0..count).map(light).collect::<PyResult<_>>()?;
        let provenance = Provenance {
            scene: scene.to_owned(),
            requested: count as u64,
            direct: count as u64,
            clamp_distance: clamp,
            origin: origin.to_array(),
            ..Provenance::default()
        };
        Ok(Self::new(vpl::VplSet::new(lights, provenance)))
    }

    /// Reads a set that `save` or `tashika vpl` wrote. Raises `FileError` or `InputError`.
    #[classmethod]
    fn load(_class: &Bound<'_, PyType>, py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| load_vpls(&path)).map(Self::new).map_err(raised)
    }

    /// Writes the set to a file, whole or not at all. Raises `FileError`.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| save_vpls(&path, self.0.set())).map_err(raised)
    }

    /// Positions (m), float32 of shape (n, 3), or float64 for scenes far from zero; zero for
    /// directional lights.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (origin, lights) = (self.0.set().origin(), self.0.set().lights().iter());
        if origin == DVec3::ZERO {
            return vectors(py, lights.map(|light| light.position.to_array()));
        }
        let place = |light: &Vpl| match light.kind {
            VplKind::Directional => DVec3::ZERO,
            _ => light.position.as_dvec3() + origin,
        };
        wide_vectors(py, lights.map(|light| place(light).to_array()))
    }

    /// Unit normals or axes, float32 of shape (n, 3); zero for omni lights.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vectors(py, self.0.set().lights().iter().map(|light| light.direction.to_array()))
    }

    /// Intensities (W/sr), or irradiances (W/m²) of directional lights, float32 of shape (n, 3).
    #[getter]
    fn intensities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vectors(py, self.0.set().lights().iter().map(|light| light.intensity.to_array()))
    }

    /// Numbers of `KINDS`, uint32 of shape (n,).
    #[getter]
    fn kinds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.0.set().lights().iter().map(|light| light.kind.number() as u32), &[self.0.set().len()])
    }

    /// Times of the lights: shares of the time that the shutter is open, float32; a single one in a
    /// scene that does not move.
    #[getter]
    fn instants<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let shares = self.0.set().instants().shares();
        array(py, shares.iter().copied(), &[shares.len()])
    }

    /// Index into `instants` of each light, uint32 of shape (n,).
    #[getter]
    fn instant<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let set = self.0.set();
        let number = |instant: usize| std::iter::repeat_n(instant as u32, set.at(instant).len());
        array(py, (0..set.instants().len()).flat_map(number).collect::<Vec<_>>().into_iter(), &[set.len()])
    }

    /// Provenance of the set: scene, seed, counts, clamp distance (m).
    #[getter]
    fn provenance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        from_json(py, self.0.set().provenance())
    }

    fn __len__(&self) -> usize {
        self.0.set().len()
    }

    fn __repr__(&self) -> String {
        format!("<tashika.VplSet of {:?}: {} lights>", self.0.set().provenance().scene, self.0.set().len())
    }
}

fn as_many<T>(name: &str, rows: Vec<T>, count: usize) -> PyResult<Vec<T>> {
    let found = rows.len();
    if found == count {
        Ok(rows)
    } else {
        Err(option(name, format!("{found} rows"), format!("{count}, one a light")))
    }
}

/// Traces the virtual point lights of a scene, about `count` of them. `clamp` is `"auto"`, `"off"`
/// or a distance in metres; `instants` is the number of times at which the lights sample moving
/// objects (32).
///
/// Equal arguments give equal lights; `threads` (0: one a core) do not matter.
#[pyfunction]
#[pyo3(signature = (scene, *, count=None, seed=1, clamp=None, instants=None, threads=0))]
pub fn vpls(
    py: Python<'_>,
    scene: &Bound<'_, Scene>,
    count: Option<u64>,
    seed: u64,
    clamp: Option<&Bound<'_, PyAny>>,
    instants: Option<u64>,
    threads: usize,
) -> PyResult<VplSet> {
    let clamp = clamp.map(words::clamp).transpose()?;
    let options =
        Request { vpls: count, clamp, instants, seed, ..Request::default() }.lights().map_err(raised)?;
    let scene = scene.get();
    attended(py, threads, None, |_| vpl::VplSet::trace(scene.tracer(), &options)).map(VplSet::new)
}

/// Options of the lights, as part of a request, and the set if one is given: `vpls` is a set, a
/// number of lights to trace, or nothing.
pub fn said(
    vpls: Option<&Bound<'_, PyAny>>,
    clamp: Option<&Bound<'_, PyAny>>,
    instants: Option<u64>,
) -> PyResult<(Option<Py<VplSet>>, Request)> {
    let given = vpls.and_then(|value| value.cast::<VplSet>().ok()).map(|set| set.clone().unbind());
    if let (Some(_), Some(clamp)) = (&given, clamp) {
        return Err(option("clamp", clamp.str()?, "nothing beside a VplSet, which has its own"));
    }
    if let (Some(_), Some(instants)) = (&given, instants) {
        return Err(option("instants", instants, "nothing beside a VplSet, which has its own"));
    }
    let number = |value: &Bound<'_, PyAny>| {
        let expected = "a VplSet, or a number of lights to trace";
        value.extract().or_else(|_| Err(option("vpls", value.str()?, expected)))
    };
    let request = Request {
        lights_given: given.is_some(),
        vpls: vpls.filter(|_| given.is_none()).map(number).transpose()?,
        clamp: clamp.map(words::clamp).transpose()?,
        instants,
        ..Request::default()
    };
    Ok((given, request))
}
