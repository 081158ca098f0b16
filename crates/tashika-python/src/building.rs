//! Scenes built from arrays: meshes, materials, lights, a camera.
//!
//! What a scene may be made of is a part of what files may say: untextured materials, one camera. Lengths in metres, colours linear
//! Rec. 709 as three numbers or as one for gray, angles in degrees.

use std::collections::BTreeMap;

use glam::{Affine3A, Vec2, Vec3};
use pyo3::prelude::*;
use tashika::bsdf::ConductorFresnel;
use tashika::color::Rgb;
use tashika::error::{Error, Location};
use tashika::scene::{self, CoatBase, Emission, Emitter, Environment, Lens, MeshData, SceneBuilder, Surface};

use crate::arrays::{float_rows, index_rows};
use crate::errors::{option, raised};
use crate::scene::Scene;

/// Three numbers, or one for gray.
#[derive(FromPyObject)]
pub enum Color {
    #[pyo3(transparent)]
    Gray(f32),
    #[pyo3(transparent)]
    Channels([f32; 3]),
}

impl From<Color> for Rgb {
    fn from(color: Color) -> Self {
        match color {
            Color::Gray(gray) => Self::gray(gray),
            Color::Channels(channels) => channels.into(),
        }
    }
}

/// What a mesh is made of; made by `Material.diffuse` and its like.
///
/// ```python
/// >>> tashika.Material.diffuse(0.8), tashika.Material.diffuse(0).emitting((5, 5, 4))
/// (<tashika.Material lambert>, <tashika.Material lambert, emitting>)
/// ```
#[pyclass(frozen, module = "tashika")]
#[derive(Clone)]
pub struct Material {
    surface: Surface,
    emission: Option<Emission>,
}

impl Material {
    fn of(surface: Surface) -> Self {
        Self { surface, emission: None }
    }
}

#[pymethods]
impl Material {
    /// Ideal diffuse reflection; `reflectance` 0 to 1.
    #[staticmethod]
    fn diffuse(reflectance: Color) -> Self {
        Self::of(Surface::Lambert { reflectance: Rgb::from(reflectance).into() })
    }

    /// Diffuse plus a modified Phong lobe of that exponent about the mirror direction.
    #[staticmethod]
    fn phong(diffuse: Color, specular: Color, exponent: f32) -> Self {
        let [diffuse, specular] = [diffuse, specular].map(|color| Rgb::from(color).into());
        Self::of(Surface::Phong { diffuse, specular, exponent })
    }

    /// Metal with GGX microfacets of roughness `alpha` (0: smooth) that reflects `f0` at normal incidence.
    #[staticmethod]
    fn conductor(f0: Color, alpha: f32) -> Self {
        Self::of(Surface::Conductor {
            fresnel: ConductorFresnel::Schlick { f0: f0.into() },
            specular: Rgb::gray(1.0).into(),
            alpha: alpha.into(),
        })
    }

    /// A dielectric coat of that refractive index and GGX roughness (0: smooth) over a diffuse base.
    #[staticmethod]
    #[pyo3(signature = (reflectance, *, ior=1.5, alpha=0.1))]
    fn coated(reflectance: Color, ior: f32, alpha: f32) -> Self {
        Self::of(Surface::Coated {
            reflectance: Rgb::from(reflectance).into(),
            base: CoatBase::default(),
            specular: Rgb::gray(1.0).into(),
            ior,
            alpha: alpha.into(),
        })
    }

    /// Perfect mirror.
    #[staticmethod]
    fn mirror(reflectance: Color) -> Self {
        Self::of(Surface::Mirror { reflectance: Rgb::from(reflectance).into() })
    }

    /// Smooth solid glass.
    #[staticmethod]
    #[pyo3(signature = (*, ior=1.5))]
    fn glass(ior: f32) -> Self {
        let white = Rgb::gray(1.0);
        Self::of(Surface::Glass { ior, reflectance: white, transmittance: white })
    }

    /// The same material, sending out light of that radiance (W/m²/sr) on the side from which its triangles run counter-clockwise, or on
    /// both sides.
    #[pyo3(signature = (radiance, *, two_sided=false))]
    fn emitting(&self, radiance: Color, two_sided: bool) -> Self {
        let emission = Emission { radiance: Rgb::from(radiance).into(), two_sided };
        Self { emission: Some(emission), ..self.clone() }
    }

    fn __repr__(&self) -> String {
        let emits = if self.emission.is_some() { ", emitting" } else { "" };
        format!("<tashika.Material {}{emits}>", self.surface.kind())
    }
}

/// Triangles of one material: `vertices` of shape (n, 3) in metres, `triangles` of shape (m, 3) with indices of vertices, and for each
/// vertex, if they are given, `normals` (n, 3) and texture coordinates `uvs` (n, 2). `material` is a `Material`, or the name of one of the
/// scene's. The arrays are copied.
#[pyclass(frozen, module = "tashika")]
pub struct Mesh {
    data: MeshData,
    material: Py<PyAny>,
}

#[pymethods]
impl Mesh {
    #[new]
    #[pyo3(signature = (vertices, triangles, *, material, normals=None, uvs=None, name=""))]
    fn new(
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        material: Py<PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
        name: &str,
    ) -> PyResult<Self> {
        let vectors = |name, rows: Option<&Bound<'_, PyAny>>| -> PyResult<Vec<Vec3>> {
            let rows = rows.map_or(Ok(Vec::new()), |rows| float_rows::<3>(name, rows))?;
            Ok(rows.into_iter().map(Vec3::from).collect())
        };
        let uvs = uvs.map_or(Ok(Vec::new()), |rows| float_rows::<2>("uvs", rows))?;
        let data = MeshData {
            name: name.to_owned(),
            positions: vectors("vertices", Some(vertices))?,
            normals: vectors("normals", normals)?,
            uvs: uvs.into_iter().map(Vec2::from).collect(),
            triangles: index_rows("triangles", triangles)?,
        };
        Ok(Self { data, material })
    }

    fn __repr__(&self) -> String {
        let MeshData { name, triangles, positions, .. } = &self.data;
        format!("<tashika.Mesh {name:?}: {} triangles, {} vertices>", triangles.len(), positions.len())
    }
}

/// A light without surface; made by `Light.point` or `Light.directional`. Surfaces shine by their material.
#[pyclass(frozen, module = "tashika")]
pub struct Light(Emitter);

#[pymethods]
impl Light {
    /// Equal intensity (W/sr) in all directions from a position.
    #[staticmethod]
    fn point(position: [f32; 3], intensity: Color) -> Self {
        Self(Emitter::Point { position: position.into(), intensity: intensity.into() })
    }

    /// Parallel light that goes in that direction, such as the sun's, with the irradiance (W/m²) of a surface that faces it.
    #[staticmethod]
    fn directional(direction: [f32; 3], irradiance: Color) -> Self {
        let direction = Vec3::from(direction).normalize_or_zero();
        Self(Emitter::Directional { direction, irradiance: irradiance.into() })
    }

    fn __repr__(&self) -> String {
        format!("<tashika.Light {:?}>", self.0)
    }
}

/// A camera at `eye` that looks at `target`: a pinhole, or a thin lens of `lens_radius` (m) that is sharp at `focus_distance` (m; that of
/// the target if not said). `vertical_fov` is in degrees, `size` the (width, height) in pixels of its images unless a render says another.
#[pyclass(frozen, module = "tashika")]
pub struct Camera(scene::Camera);

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (
        eye, target, *, up=[0.0, 1.0, 0.0], vertical_fov=40.0, size=None, name="camera", lens_radius=0.0, focus_distance=None
    ))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
    fn new(
        eye: [f32; 3],
        target: [f32; 3],
        up: [f32; 3],
        vertical_fov: f32,
        size: Option<[u32; 2]>,
        name: &str,
        lens_radius: f32,
        focus_distance: Option<f32>,
    ) -> PyResult<Self> {
        let (eye, target) = (Vec3::from(eye), Vec3::from(target));
        // Also refuses what is not a number.
        if eye.distance(target).partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return Err(option("target", target, "a point other than the eye"));
        }
        let camera = scene::Camera::look_at(name, eye, target, up.into(), vertical_fov.to_radians());
        let lens =
            Lens { radius: lens_radius, focus_distance: focus_distance.unwrap_or(eye.distance(target)) };
        Ok(Self(scene::Camera { lens, resolution: size, ..camera }))
    }

    fn __repr__(&self) -> String {
        format!("<tashika.Camera {:?} at {}>", self.0.name, self.0.position())
    }
}

/// What `Scene.build` was given.
pub struct Parts<'py> {
    pub meshes: Vec<Bound<'py, Mesh>>,
    pub materials: BTreeMap<String, Bound<'py, Material>>,
    pub lights: Vec<Bound<'py, Light>>,
    pub camera: Option<Bound<'py, Camera>>,
    pub sky: Option<Color>,
}

/// The scene of these parts.
pub fn build(name: &str, parts: Parts<'_>) -> PyResult<Scene> {
    let Parts { meshes, materials, lights, camera, sky } = parts;
    let mut builder = SceneBuilder::new(name, Location::file(name));
    let mut ids = BTreeMap::new();
    for (name, material) in materials {
        let id = builder.add_material(named(&name, material.get())).map_err(raised)?;
        ids.insert(name, id);
    }
    for mesh in meshes {
        let Mesh { data, material } = mesh.get();
        let material = material.bind(mesh.py());
        let id = if let Ok(material) = material.cast::<Material>() {
            builder.add_material(named(&data.name, material.get())).map_err(raised)?
        } else {
            let known = material.extract::<String>().ok().and_then(|name| ids.get(&name));
            *known.ok_or_else(|| {
                let names: Vec<&str> = ids.keys().map(String::as_str).collect();
                let expected = format!("a Material, or one of the scene's: {}", names.join(", "));
                let at = Location::file(name).item(format!("mesh {}", data.name));
                raised(Error::invalid(at, format!("material = {material}"), expected))
            })?
        };
        let id = builder.add_mesh(data.clone(), id).map_err(raised)?;
        builder.add_instance(id, Affine3A::IDENTITY).map_err(raised)?;
    }
    for light in lights {
        builder.add_emitter(light.get().0).map_err(raised)?;
    }
    if let Some(sky) = sky {
        builder.set_environment(Environment::constant(sky.into())).map_err(raised)?;
    }
    if let Some(camera) = camera {
        builder.add_camera(camera.get().0.clone()).map_err(raised)?;
    }
    builder.build().map(Scene::new).map_err(raised)
}

fn named(name: &str, material: &Material) -> scene::Material {
    let Material { surface, emission } = *material;
    scene::Material { emission, ..scene::Material::new(name, surface) }
}
