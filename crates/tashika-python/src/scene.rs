//! Scenes: loaded, built in, or built from arrays.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyType};
use tashika::accel::Tracer;
use tashika::error::{Error, Result};
use tashika::io::{AskedEnvironment, AskedLight, LightChanges, LoadOptions, open_scene};
use tashika::renderer::{LightCache, Renderer};
use tashika::request::Request;
use tashika::scene::{self, builtin as made};

use crate::building::{Camera, Light, Mesh, Parts, build};
use crate::errors::{in_python, option, raised};
use crate::materials::Material;

/// A scene: surfaces, lights and cameras, ready to be rendered.
///
/// Made by `tashika.load`, `tashika.builtin` or `Scene.build`; it does not change afterwards.
///
/// ```python
/// >>> scene = tashika.builtin("tiny")
/// >>> scene.name, scene.triangles, scene.cameras
/// ('tiny', {'stored': 36, 'instanced': 36}, {'main': (32, 32)})
/// ```
#[pyclass(frozen, module = "tashika")]
pub struct Scene {
    scene: Arc<scene::Scene>,
    tracer: OnceLock<Tracer>,
    /// Of its last render of light transport, so that shares of an image have them in common.
    lights: LightCache,
    /// Where it was read from, and how.
    source: Option<Source>,
}

/// What a scene is read from.
struct Source {
    path: PathBuf,
    changes: LightChanges,
    options: LoadOptions,
    /// Whether what departs from the file is refused.
    strict: bool,
}

impl Source {
    fn read(self, py: Python<'_>) -> PyResult<Scene> {
        let scene = py.detach(|| open_scene(&self.path, &self.changes, &self.options)).map_err(raised)?;
        if let (true, Some(note)) = (self.strict, scene.notes().first_departure()) {
            let expected = "nothing that departs from the file, because of strict=True";
            return Err(raised(Error::invalid(note.first, note.message, expected)));
        }
        Ok(Scene { source: Some(self), ..Scene::new(scene) })
    }
}

impl Scene {
    pub(crate) fn new(scene: scene::Scene) -> Self {
        Self { scene: Arc::new(scene), tracer: OnceLock::new(), lights: LightCache::default(), source: None }
    }

    /// Rays; the tree for them is built when it is first needed, on the current pool.
    pub(crate) fn tracer(&self) -> &Tracer {
        self.tracer.get_or_init(|| Tracer::new(Arc::clone(&self.scene)))
    }

    /// What is asked for, as this scene can be rendered.
    pub(crate) fn in_scene(&self, request: &Request) -> Request {
        request.in_scene(&self.scene)
    }

    /// Returns the names of the options of a request that have no effect in this scene only.
    pub(crate) fn unused(&self, request: &Request) -> Result<Vec<&'static str>> {
        request.check_in(&self.scene)
    }

    /// What is asked for of this scene, with the VPLs of its last render; for the pool of the work.
    pub(crate) fn renderer(&self, camera: &scene::Camera, request: &Request) -> Renderer<'_> {
        Renderer::on(self.tracer()).camera(camera.clone()).request(request.clone()).light_cache(&self.lights)
    }

    /// The camera of that name, or the first.
    pub(crate) fn camera(&self, name: Option<&str>) -> PyResult<&scene::Camera> {
        let Some(name) = name else { return Ok(&self.scene.cameras()[0]) };
        self.scene.camera(name).ok_or_else(|| {
            let names: Vec<&str> = self.scene.cameras().iter().map(|c| c.name.as_str()).collect();
            option("camera", name, format!("one of the scene's: {}", names.join(", ")))
        })
    }
}

#[pymethods]
impl Scene {
    /// A scene of meshes, lights and a camera; `materials` are those that meshes name. `sky` is a
    /// radiance (W/m²/sr) from everywhere, or a map of it by latitude and longitude: an array of
    /// shape (height, width, 3) whose top row is up (+y), whose middle column is -z and the next to
    /// the right towards +x.
    ///
    /// Without a camera it gets one that sees all of it, and `notes` tells; without light it is dark. Raises `InputError` for what cannot be rendered.
    ///
    /// ```python
    /// >>> square = [[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]
    /// >>> floor = tashika.Mesh(square, [[0, 1, 2], [0, 2, 3]], material="white")
    /// >>> scene = tashika.Scene.build(
    /// ...     meshes=[floor],
    /// ...     materials={"white": tashika.Material.diffuse(0.8)},
    /// ...     lights=[tashika.Light.point((0, 1, 0), 5)],
    /// ...     camera=tashika.Camera((0, 3, 0.1), (0, 0, 0)),
    /// ... )
    /// >>> scene.triangles["stored"], scene.notes
    /// (2, [])
    /// ```
    #[classmethod]
    #[pyo3(signature = (meshes, *, materials=None, lights=Vec::new(), camera=None, sky=None, name="scene"))]
    fn build<'py>(
        _class: &Bound<'py, PyType>,
        meshes: Vec<Bound<'py, Mesh>>,
        materials: Option<BTreeMap<String, Bound<'py, Material>>>,
        lights: Vec<Bound<'py, Light>>,
        camera: Option<Bound<'py, Camera>>,
        sky: Option<Bound<'py, PyAny>>,
        name: &str,
    ) -> PyResult<Self> {
        let materials = materials.unwrap_or_default();
        build(name, Parts { meshes, materials, lights, camera, sky }).map(Self::new)
    }

    /// Name, usually that of the file.
    #[getter]
    fn name(&self) -> &str {
        self.scene.name()
    }

    /// Numbers of triangles: `stored` in memory, `instanced` in the picture.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counts = PyDict::new(py);
        counts.set_item("stored", self.scene.stored_triangles())?;
        counts.set_item("instanced", self.scene.instanced_triangles())?;
        Ok(counts)
    }

    /// The cameras by name, each with the size in pixels that the file asks for, or None. The first
    /// is the default.
    #[getter]
    fn cameras<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let cameras = PyDict::new(py);
        for camera in self.scene.cameras() {
            // Of equal names the first is the one that is found.
            if !cameras.contains(&camera.name)? {
                cameras.set_item(&camera.name, camera.resolution.map(|[w, h]| (w, h)))?;
            }
        }
        Ok(cameras)
    }

    /// How many triangles without area were left out: no picture shows them.
    #[getter]
    fn triangles_without_area(&self) -> u64 {
        self.scene.triangles_without_area()
    }

    /// From when to when anything in its file moves (s), if anything does.
    #[getter]
    fn animated_seconds(&self) -> Option<[f64; 2]> {
        self.scene.animated_seconds()
    }

    /// When the scene is as it is (s), if a time was asked for and anything in its file moves.
    #[getter]
    fn time(&self) -> Option<f64> {
        self.scene.time()
    }

    /// The scene as it is at another time, in seconds, with the shutter open from and to the seconds
    /// from then that `shutter` says: read anew from its file, all else as it was loaded. Raises what
    /// `load` does, and `OptionError` for a scene that is of no file.
    ///
    /// ```python
    /// >>> scene = tashika.load("builtin:tiny")
    /// >>> scene.at(2).time is None  # nothing in it moves
    /// True
    /// ```
    #[pyo3(signature = (seconds, *, shutter=None))]
    fn at(&self, py: Python<'_>, seconds: f64, shutter: Option<[f64; 2]>) -> PyResult<Self> {
        let Some(Source { path, changes, options, strict }) = &self.source else {
            return Err(option("at", seconds, "a scene that was loaded: this one was built"));
        };
        let options = LoadOptions { at: Some(seconds), shutter, ..options.clone() };
        Source { path: path.clone(), changes: changes.clone(), options, strict: *strict }.read(py)
    }

    /// The lights that `load` was asked for in place of what the file says.
    #[getter]
    fn light_changes(&self) -> Vec<String> {
        self.scene.changes().to_vec()
    }

    /// What was missing, repaired, approximated, ignored or added, a line each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        let line = |note: scene::Note| {
            let times = if note.count == 1 { String::new() } else { format!(" ({} times)", note.count) };
            in_python(&format!("{}: {}{times}", note.first, note.message))
        };
        self.scene.notes().iter().map(line).collect()
    }

    fn __repr__(&self) -> String {
        let (triangles, cameras) = (self.scene.instanced_triangles(), self.scene.cameras().len());
        let plural = if cameras == 1 { "" } else { "s" };
        format!("<tashika.Scene {:?}: {triangles} triangles, {cameras} camera{plural}>", self.scene.name())
    }
}

/// Reads a scene file: `.gltf`, `.glb`, `.usda`, `.usdc`, `.usd`, `.usdz`, `.obj`, `.pbrt`, or Mitsuba's `.xml`; or makes
/// `"builtin:room"` or `"builtin:tiny"`.
///
/// `at` is the time in seconds that a scene is loaded as it is at, if anything in its file moves;
/// `Scene.animated_seconds` says from when to when it does. `shutter` is from when to when the
/// shutter of cameras is open, in seconds from `at` or 0: those that move meanwhile are blurred, and
/// so are things that move, by path tracing and in sums over one set of lights.
/// `environment` takes the place of the scene's, each of `lights` is beside its own, in the words
/// of the program's options `--environment` and `--light`; `Scene.light_changes` has them.
/// `allow_outside` lets it read files outside the folder of the scene, `allow_missing` go on
/// without files that are not there; `strict` refuses a scene that cannot be rendered as its file
/// says. Raises `FileError`, `InputError` or `UnsupportedError`.
///
/// ```python
/// >>> tashika.load("builtin:tiny")
/// <tashika.Scene "tiny": 36 triangles, 1 camera>
/// >>> tashika.load("builtin:tiny", lights=["sun:elevation=40,azimuth=120"]).light_changes
/// ['light sun:elevation=40,azimuth=120,turbidity=3']
/// >>> tashika.load("absent.glb")
/// Traceback (most recent call last):
/// tashika.FileError: absent.glb: No such file or directory (os error 2)
/// ```
#[pyfunction]
#[pyo3(signature = (path, *, at=None, shutter=None, environment=None, lights=Vec::new(), allow_outside=false, allow_missing=false, strict=false))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub fn load(
    py: Python<'_>,
    path: PathBuf,
    at: Option<f64>,
    shutter: Option<[f64; 2]>,
    environment: Option<&str>,
    lights: Vec<String>,
    allow_outside: bool,
    allow_missing: bool,
    strict: bool,
) -> PyResult<Scene> {
    let parse = |text: &str| text.parse::<AskedEnvironment>();
    let changes = LightChanges {
        environment: environment.map(parse).transpose().map_err(raised)?,
        lights: lights
            .iter()
            .map(|text| text.parse::<AskedLight>())
            .collect::<Result<_>>()
            .map_err(raised)?,
    };
    let options = LoadOptions { allow_outside, allow_missing, at, shutter, ..LoadOptions::default() };
    Source { path, changes, options, strict }.read(py)
}

/// A scene that needs no file: `"room"`, furnished and glossy, or `"tiny"`, a box with two blocks
/// and one light.
#[pyfunction]
pub fn builtin(name: &str) -> PyResult<Scene> {
    made::by_name(name).map(|scene| Scene::new(scene())).map_err(raised)
}
