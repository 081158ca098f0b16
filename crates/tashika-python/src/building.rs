//! Scenes built from arrays: meshes, lights, a sky, a camera.
//!
//! The parts are a subset of those that files can have. Lengths are in metres, colours are linear
//! Rec. 709 as three numbers or as one for gray, angles are in degrees.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat4, DVec3, Mat3, Vec2, Vec3, Vec4};
use pyo3::prelude::*;
use tashika::color::Rgb;
use tashika::error::{Error, Location};
use tashika::math::elementary;
use tashika::scene::{
    self, Blades, Emitter, Environment, Falloff, FalloffShape, Interface, Lens, MeshData, Pixels, Projection,
    SceneBuilder, SphereMap,
};

use crate::arrays::{Array, Content, float_rows, index_rows, wide_numbers, wide_rows};
use crate::errors::{option, raised};
use crate::materials::{Color, Material, Palette, image};
use crate::media::{Media, Medium};

/// Triangles of one material. `vertices` has shape (n, 3), in metres, and `triangles` shape (m, 3),
/// with indices of vertices. Each vertex may have a normal, `normals` (n, 3), and texture
/// coordinates, `uvs` (n, 2): (0, 0) is the top left of an image and (1, 1) its bottom right.
/// `material` is a `Material`, or the name of a material of the scene. `transforms` of shape (k, 4,
/// 4) place the mesh k times, by matrices whose columns are the images of the axes and of the
/// origin. Without `transforms` the mesh is placed once, untransformed. The arrays are copied.
/// `inside` and `outside` are the media (`Medium`) of the two sides; triangles run
/// counter-clockwise as seen from the outside. If only one is given, the medium of the other side
/// is vacuum. If none is given, the surrounding medium is on both sides.
///
/// ```python
/// >>> import numpy as np
/// >>> right = np.eye(4)
/// >>> right[0, 3] = 2
/// >>> triangle = tashika.Mesh(np.eye(3), [[0, 1, 2]], material=tashika.Material.diffuse(0.8), transforms=[np.eye(4), right])
/// >>> tashika.Scene.build([triangle]).triangles
/// {'stored': 1, 'instanced': 2}
/// ```
#[pyclass(frozen, module = "tashika")]
pub struct Mesh {
    data: MeshData,
    material: Py<PyAny>,
    /// Transforms to the world, one for each placement.
    places: Vec<DAffine3>,
    /// Media inside and outside, if given.
    media: [Option<Py<Medium>>; 2],
}

#[pymethods]
impl Mesh {
    #[new]
    #[pyo3(signature = (vertices, triangles, *, material, normals=None, uvs=None, transforms=None, inside=None, outside=None, name=""))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
    fn new(
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        material: Py<PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
        transforms: Option<&Bound<'_, PyAny>>,
        inside: Option<Py<Medium>>,
        outside: Option<Py<Medium>>,
        name: &str,
    ) -> PyResult<Self> {
        let vectors = |name, rows: Option<&Bound<'_, PyAny>>| -> PyResult<Vec<Vec3>> {
            let rows = rows.map_or(Ok(Vec::new()), |rows| float_rows::<3>(name, rows))?;
            Ok(rows.into_iter().map(Vec3::from).collect())
        };
        let uvs = uvs.map_or(Ok(Vec::new()), |rows| float_rows::<2>("uvs", rows))?;
        let mut data = MeshData {
            name: name.to_owned(),
            normals: vectors("normals", normals)?,
            uvs: uvs.into_iter().map(Vec2::from).collect(),
            triangles: index_rows("triangles", triangles)?,
            ..MeshData::default()
        };
        let vertices: Vec<DVec3> = wide_rows("vertices", vertices)?.into_iter().map(DVec3::from).collect();
        data.place(&vertices);
        let places =
            transforms.map_or(Ok(vec![DAffine3::IDENTITY]), |rows| placements("transforms", rows))?;
        Ok(Self { data, material, places, media: [inside, outside] })
    }

    fn __repr__(&self) -> String {
        let MeshData { name, triangles, positions, .. } = &self.data;
        format!("<tashika.Mesh {name:?}: {} triangles, {} vertices>", triangles.len(), positions.len())
    }
}

/// Returns the transforms of an array of shape (k, 4, 4), or of one of shape (4, 4).
///
/// * `name`: name of the argument.
pub fn placements(name: &str, transforms: &Bound<'_, PyAny>) -> PyResult<Vec<DAffine3>> {
    let array = Array::read(name, transforms)?;
    if matches!(array.content, Content::Bytes(_)) {
        return Err(option(name, "an array of uint8", "an array of other numbers"));
    }
    if !matches!(array.shape[..], [4, 4] | [_, 4, 4]) {
        return Err(option(name, format!("an array of the shape {:?}", array.shape), "the shape (k, 4, 4)"));
    }
    let place = |rows: &[f64; 16]| {
        let matrix = DMat4::from_cols_array(rows).transpose();
        let last = matrix.row(3).as_vec4();
        if last == Vec4::W {
            Ok(DAffine3::from_mat4(matrix))
        } else {
            Err(option(name, format!("the last row {last}"), "0, 0, 0, 1"))
        }
    };
    wide_numbers(transforms)?.as_chunks::<16>().0.iter().map(place).collect()
}

/// A light without a surface, made by `Light.point`, `Light.spot` or `Light.directional`. Surfaces
/// emit light by their material.
#[pyclass(frozen, module = "tashika")]
pub struct Light(Emitter, DVec3);

#[pymethods]
impl Light {
    /// Equal intensity (W/sr) in all directions from a position.
    #[staticmethod]
    fn point(position: [f64; 3], intensity: Color) -> Self {
        let place = DVec3::from(position);
        Self(Emitter::Point { position: place.as_vec3(), intensity: intensity.into() }, place)
    }

    /// Light in a cone around a direction. The intensity (W/sr) is constant up to `inner` degrees
    /// from the direction, and falls to zero at `outer` degrees: with the square of a linear
    /// function of the angle's cosine, as in glTF.
    #[staticmethod]
    #[pyo3(signature = (position, direction, intensity, *, inner=0.0, outer=45.0))]
    fn spot(
        position: [f64; 3],
        direction: [f32; 3],
        intensity: Color,
        inner: f32,
        outer: f32,
    ) -> PyResult<Self> {
        if !(0.0 <= inner && inner < outer && outer <= 180.0) {
            return Err(option(
                "outer",
                format!("{outer} with inner = {inner}"),
                "0 <= inner < outer <= 180",
            ));
        }
        let cos = |degrees: f32| elementary::sin_cos(degrees.to_radians()).1;
        let place = DVec3::from(position);
        let emitter = Emitter::Spot {
            position: place.as_vec3(),
            axis: Vec3::from(direction).normalize_or_zero(),
            intensity: intensity.into(),
            falloff: Falloff { cos_inner: cos(inner), cos_outer: cos(outer), shape: FalloffShape::Squared },
        };
        Ok(Self(emitter, place))
    }

    /// Parallel light that travels in the given direction, such as the sun's, with the irradiance
    /// (W/m²) of a surface that faces it.
    #[staticmethod]
    fn directional(direction: [f32; 3], irradiance: Color) -> Self {
        let direction = Vec3::from(direction).normalize_or_zero();
        Self(Emitter::Directional { direction, irradiance: irradiance.into() }, DVec3::ZERO)
    }

    fn __repr__(&self) -> String {
        format!("<tashika.Light {:?}>", self.0)
    }
}

/// A camera at `eye` that looks at `target`: a pinhole, or a thin lens of `lens_radius` (m) that is
/// sharp at `focus_distance` (m; by default the distance of the target). The lens is round, or a
/// polygon of `blades` corners (3 to 100) on the circle of `lens_radius`, turned by
/// `blade_rotation` (degrees, counter-clockwise as the camera sees it; at 0 a corner is up).
/// `vertical_fov` is in degrees. `size` is the (width, height) in pixels of its images unless a
/// render sets another.
#[pyclass(frozen, module = "tashika")]
pub struct Camera {
    camera: scene::Camera,
    /// Position (m).
    eye: DVec3,
    /// Medium in which the camera stands.
    medium: Option<Py<Medium>>,
}

#[pymethods]
impl Camera {
    #[new]
    #[pyo3(signature = (
        eye, target, *, up=[0.0, 1.0, 0.0], vertical_fov=40.0, size=None, name="camera", lens_radius=0.0, focus_distance=None,
        blades=None, blade_rotation=0.0
    ))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
    fn new(
        eye: [f64; 3],
        target: [f64; 3],
        up: [f32; 3],
        vertical_fov: f32,
        size: Option<[u32; 2]>,
        name: &str,
        lens_radius: f32,
        focus_distance: Option<f32>,
        blades: Option<u32>,
        blade_rotation: f32,
    ) -> PyResult<Self> {
        let (eye, target) = (DVec3::from(eye), DVec3::from(target));
        let distance = eye.distance(target) as f32;
        // Refuses NaN as well.
        if distance.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return Err(option("target", target, "a point other than the eye"));
        }
        let ahead = (target - eye).as_vec3();
        let camera = scene::Camera::look_at(name, Vec3::ZERO, ahead, up.into(), vertical_fov.to_radians());
        let blades = blades.map(|count| Blades { count, rotation: blade_rotation.to_radians() });
        let lens = Lens { blades, ..Lens::round(lens_radius, focus_distance.unwrap_or(distance)) };
        Ok(Self { camera: scene::Camera { lens, resolution: size, ..camera }, eye, medium: None })
    }

    /// This camera, placed in a medium.
    fn within(&self, medium: Py<Medium>) -> Self {
        Self { camera: self.camera.clone(), eye: self.eye, medium: Some(medium) }
    }

    /// A camera without perspective, whose film is `height` metres high; it looks in the direction
    /// from `eye` to `target`.
    #[staticmethod]
    #[pyo3(signature = (eye, target, height, *, up=[0.0, 1.0, 0.0], size=None, name="camera"))]
    fn orthographic(
        eye: [f64; 3],
        target: [f64; 3],
        height: f32,
        up: [f32; 3],
        size: Option<[u32; 2]>,
        name: &str,
    ) -> PyResult<Self> {
        Self::with_projection(eye, target, up, size, name, Projection::Orthographic { height })
    }

    /// An equidistant fisheye: a circle that touches the longer sides of the image, `fov` degrees
    /// across (at most 360), black outside.
    #[staticmethod]
    #[pyo3(signature = (eye, target, *, fov=180.0, up=[0.0, 1.0, 0.0], size=None, name="camera"))]
    fn fisheye(
        eye: [f64; 3],
        target: [f64; 3],
        fov: f32,
        up: [f32; 3],
        size: Option<[u32; 2]>,
        name: &str,
    ) -> PyResult<Self> {
        // 360° in radians may round to more than 2π.
        let angle = fov.to_radians().min(if fov <= 360.0 { std::f32::consts::TAU } else { f32::INFINITY });
        Self::with_projection(eye, target, up, size, name, Projection::Fisheye { angle })
    }

    /// A camera that sees all directions: by latitude and longitude, with `target` in the middle of
    /// the image; or, with `equal_area`, in a square whose middle is up and whose lower edge has
    /// `target` in its middle.
    #[staticmethod]
    #[pyo3(signature = (eye, target, *, equal_area=false, up=[0.0, 1.0, 0.0], size=None, name="camera"))]
    fn spherical(
        eye: [f64; 3],
        target: [f64; 3],
        equal_area: bool,
        up: [f32; 3],
        size: Option<[u32; 2]>,
        name: &str,
    ) -> PyResult<Self> {
        let map = if equal_area { SphereMap::EqualArea } else { SphereMap::LatLong };
        Self::with_projection(eye, target, up, size, name, Projection::Spherical { map })
    }

    fn __repr__(&self) -> String {
        format!("<tashika.Camera {:?} at {}>", self.camera.name, self.eye)
    }
}

impl Camera {
    fn with_projection(
        eye: [f64; 3],
        target: [f64; 3],
        up: [f32; 3],
        size: Option<[u32; 2]>,
        name: &str,
        projection: Projection,
    ) -> PyResult<Self> {
        let Self { camera, eye, medium } =
            Self::new(eye, target, up, 40.0, size, name, 0.0, None, None, 0.0)?;
        Ok(Self { camera: scene::Camera { projection, ..camera }, eye, medium })
    }
}

/// Arguments of `Scene.build`.
pub struct Parts<'py> {
    pub meshes: Vec<Bound<'py, Mesh>>,
    pub materials: BTreeMap<String, Bound<'py, Material>>,
    pub lights: Vec<Bound<'py, Light>>,
    pub camera: Option<Bound<'py, Camera>>,
    pub sky: Option<Bound<'py, PyAny>>,
}

/// Builds the scene of these parts.
pub fn build(name: &str, parts: Parts<'_>) -> PyResult<scene::Scene> {
    let Parts { meshes, materials, lights, camera, sky } = parts;
    let mut builder = SceneBuilder::new(name, Location::file(name));
    let mut palette = Palette::new(&mut builder);
    let mut media = Media::default();
    let mut ids = BTreeMap::new();
    for (name, material) in materials {
        let id = palette.add(&name, material.get()).map_err(raised)?;
        ids.insert(name, id);
    }
    for mesh in meshes {
        let Mesh { data, material, places, media: sides } = mesh.get();
        let material = material.bind(mesh.py());
        let id = if let Ok(material) = material.cast::<Material>() {
            palette.add(&data.name, material.get()).map_err(raised)?
        } else {
            let known = material.extract::<String>().ok().and_then(|name| ids.get(&name));
            *known.ok_or_else(|| {
                let names: Vec<&str> = ids.keys().map(String::as_str).collect();
                let expected = format!("a Material, or one of the scene's: {}", names.join(", "));
                let at = Location::file(name).item(format!("mesh {}", data.name));
                raised(Error::invalid(at, format!("material = {material}"), expected))
            })?
        };
        let id = palette.builder().add_mesh(data.clone(), id).map_err(raised)?;
        if sides.iter().any(Option::is_some) {
            let mut of_side = |side: &Option<Py<Medium>>| {
                media
                    .add(side.as_ref().map(|medium| medium.bind(mesh.py())), palette.builder())
                    .map_err(raised)
            };
            let interface = Interface { inside: of_side(&sides[0])?, outside: of_side(&sides[1])? };
            palette.builder().set_interface(id, interface).map_err(raised)?;
        }
        for place in places {
            palette.builder().add_instance(id, *place).map_err(raised)?;
        }
    }
    for light in lights {
        let Light(emitter, place) = light.get();
        builder.add_emitter_at(*emitter, *place).map_err(raised)?;
    }
    if let Some(sky) = sky {
        builder.set_environment(environment(&sky)?).map_err(raised)?;
    }
    if let Some(camera) = camera {
        let Camera { camera: standing, eye, medium } = camera.get();
        let medium = medium.as_ref().map(|medium| medium.bind(camera.py()));
        let medium = media.add(medium, &mut builder).map_err(raised)?;
        let to_world = DAffine3 { translation: *eye, ..standing.to_world.as_daffine3() };
        builder.add_camera_at(scene::Camera { medium, ..standing.clone() }, to_world).map_err(raised)?;
    }
    // Merges and checkpoints compare this digest to detect a changed scene.
    builder.build().map(scene::Scene::with_digest_of_contents).map_err(raised)
}

/// Sky of constant radiance, or a map of the radiance.
fn environment(sky: &Bound<'_, PyAny>) -> PyResult<Environment> {
    if let Some(color) = Color::of(sky) {
        return Ok(Environment::constant(color.into()));
    }
    let image = image("sky", sky, Pixels::Srgb8)?;
    Ok(Environment::lat_long(image, Rgb::WHITE, Mat3::IDENTITY))
}
