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
    /// VPLs of the last render of light transport, which shares of an image have in common.
    lights: LightCache,
    /// File and options of a scene that was loaded.
    source: Option<Source>,
}

/// File of a scene, and the options of reading it.
struct Source {
    path: PathBuf,
    changes: LightChanges,
    options: LoadOptions,
    /// True if departures from the file are refused.
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

    /// Tracer of rays; its tree is built at the first use, on the current pool.
    pub(crate) fn tracer(&self) -> &Tracer {
        self.tracer.get_or_init(|| Tracer::new(Arc::clone(&self.scene)))
    }

    /// Request with a method that can render this scene.
    pub(crate) fn in_scene(&self, request: &Request) -> Request {
        request.in_scene(&self.scene)
    }

    /// Returns the names of the options of a request that have an effect in other scenes, but not
    /// in this one.
    pub(crate) fn unused(&self, request: &Request) -> Result<Vec<&'static str>> {
        request.check_in(&self.scene)
    }

    /// Renderer of a request, with the VPLs of the last render. Call it on the thread pool that
    /// does the work.
    pub(crate) fn renderer(&self, camera: &scene::Camera, request: &Request) -> Renderer<'_> {
        Renderer::on(self.tracer()).camera(camera.clone()).request(request.clone()).light_cache(&self.lights)
    }

    /// Camera of that name, or the first.
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
    /// A scene of meshes, lights and a camera; `materials` are the materials that meshes refer to
    /// by name. `sky` is a constant radiance (W/m²/sr), or a map of it by latitude and longitude:
    /// an array of shape (height, width, 3) whose top row is up (+y) and whose middle column is -z,
    /// with +x to the right of it.
    ///
    /// A scene without a camera gets one that sees all of it, and a line in `notes`; a scene
    /// without light is dark. Raises `InputError` for a scene that cannot be rendered.
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

    /// The cameras by name, each with the size in pixels that the file requests, or None. The first
    /// is the default.
    #[getter]
    fn cameras<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let cameras = PyDict::new(py);
        for camera in self.scene.cameras() {
            // Of equal names the first one is used.
            if !cameras.contains(&camera.name)? {
                cameras.set_item(&camera.name, camera.resolution.map(|[w, h]| (w, h)))?;
            }
        }
        Ok(cameras)
    }

    /// Number of triangles without area that were omitted; they would be invisible.
    #[getter]
    fn triangles_without_area(&self) -> u64 {
        self.scene.triangles_without_area()
    }

    /// Beginning and end of the motion in its file (s); None if nothing moves.
    #[getter]
    fn animated_seconds(&self) -> Option<[f64; 2]> {
        self.scene.animated_seconds()
    }

    /// Time of the scene (s), if one was requested and anything in its file moves.
    #[getter]
    fn time(&self) -> Option<f64> {
        self.scene.time()
    }

    /// The scene at another time, in seconds, read again from its file with the other options of
    /// `load`. `shutter` is the beginning and end of the time that the shutter is open, in seconds
    /// from `seconds`. Raises the exceptions of `load`, and `OptionError` for a scene that was not
    /// loaded from a file.
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

    /// Changes of the lights that were passed to `load`.
    #[getter]
    fn light_changes(&self) -> Vec<String> {
        self.scene.changes().to_vec()
    }

    /// Notes on missing, repaired, approximated, ignored or added parts, a line each.
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

/// Reads a scene file: `.gltf`, `.glb`, `.usda`, `.usdc`, `.usd`, `.usdz`, `.obj`, `.pbrt`, or
/// Mitsuba's `.xml`; or makes `"builtin:room"` or `"builtin:tiny"`.
///
/// `at` is the time of the scene in seconds, if anything in its file moves;
/// `Scene.animated_seconds` is the interval of that motion. `shutter` is the beginning and end of
/// the time that the shutter of cameras is open, in seconds from `at` or 0: cameras that move in
/// this time are blurred. Moving objects are blurred by path tracing and in sums over one set of
/// lights. `environment` replaces the environment of the scene, and `lights` are added to its
/// lights. Both have the syntax of the program's options `--environment` and `--light`;
/// `Scene.light_changes` lists both. `allow_outside` permits files outside the folder of the scene,
/// `allow_missing` continues without missing files; `strict` refuses a scene that cannot be
/// rendered as in its file. Raises `FileError`, `InputError` or `UnsupportedError`.
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
