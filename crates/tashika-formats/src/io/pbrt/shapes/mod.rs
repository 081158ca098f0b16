//! `Shape`: meshes with their material.
//!
//! A shape becomes a mesh in its own space, placed by the current transform. Quadrics and mesh
//! files share one mesh if their parameters, material, orientation and media are equal, however
//! often a file repeats them.
//!
//! A shape emits on the side of pbrt's surface normal. For triangles with vertex normals, this is
//! the side of these normals. For other triangles it is the side from which the corners run
//! counter-clockwise *in the space of the shape*. (In pbrt the triangles are in world space; an
//! exclusive or with the handedness of the transform has the same effect.) `ReverseOrientation`
//! reverses the side, except for triangles with vertex normals in pbrt-v3. For quadrics it is the
//! side of their own normals, which `ReverseOrientation` reverses too.
//!
//! Alpha textures cut holes in pbrt-v3 (where they are 0) and transmit a fraction of the light in
//! pbrt-v4. An emitter of alpha 0 is invisible and emits fully; an emitter of fractional alpha
//! emits that fraction. Area lights of shapes inside objects are ignored, as in pbrt.
//!
//! Source: Pharr et al. 2023, chapter 6. Tested by `suite::pbrt::shapes_*`.

mod meshes;
mod quadrics;

use std::collections::BTreeMap;

use glam::{DAffine3, Vec3};

use super::lights::AreaLight;
use super::loading::Loading;
use super::materials::Materials;
use super::parameters::Parameters;
use super::state::State;
use super::textures::Textures;
use super::version::Version;
use crate::error::Result;
use crate::math::motion::Track;
use crate::scene::{Emission, FloatInput, Interface, MaterialId, MeshData, MeshId, NoteKind};

/// A mesh with its place in the world, or in the object that it belongs to.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Mesh in the space of the shape.
    pub(super) mesh: MeshId,
    /// Transform from shape to object.
    pub(super) to_object: DAffine3,
    /// Motion of `to_object`, if it moves while the shutter is open.
    pub(super) track: Option<Track>,
}

/// A `Shape` directive.
pub(super) struct Request<'a> {
    /// Type of the shape.
    pub(super) class: &'a str,
    /// Parameters of the directive, defaults included.
    pub(super) parameters: &'a Parameters,
    /// Graphics state at the directive.
    pub(super) state: &'a State,
    /// True if the shape belongs to an object.
    pub(super) in_object: bool,
    /// Transform of the shape to the world.
    pub(super) to_world: &'a DAffine3,
}

/// Effect of `ReverseOrientation` on a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Orientation {
    /// Reversed, but in pbrt-v3 not if there are vertex normals.
    Triangles,
    /// Always reversed.
    Quadric,
}

/// Parameters that identify a shape: its type with its numbers, or the name of its file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Prototype {
    Quadric(&'static str, Vec<u32>),
    File(String),
}

/// Meshes that later shapes may share.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    /// Meshes by prototype, material, orientation, and media on both sides.
    known: BTreeMap<(Prototype, MaterialId, bool, Option<Interface>), Option<MeshId>>,
}

impl Shapes {
    /// Returns the mesh of a shape; none if it is invisible or ignored.
    pub(super) fn make(
        &mut self,
        loading: &mut Loading<'_>,
        textures: &Textures,
        materials: &mut Materials,
        request: &Request<'_>,
    ) -> Result<Option<MeshId>> {
        let Request { class, parameters, .. } = request;
        loading.met("shape", class, "left out", &parameters.at())?;
        let mesh = self.made(loading, textures, materials, request)?;
        if Loading::knows("shape", class) {
            if mesh.is_none() {
                parameters.accept_known();
            }
            parameters.accept(&["shadowalpha", "alpha"]);
            loading.note_unused("shape", class, parameters)?;
        }
        Ok(mesh)
    }

    fn made(
        &mut self,
        loading: &mut Loading<'_>,
        textures: &Textures,
        materials: &mut Materials,
        request: &Request<'_>,
    ) -> Result<Option<MeshId>> {
        let Request { class, parameters, state, .. } = request;
        let at = parameters.at();
        let alpha = alpha(loading, textures, parameters);
        let mut light = light(loading, request);
        let interface = state.media.interface();
        let is_boundary = materials.is_interface(state.material);
        if is_boundary {
            if light.take().is_some() {
                loading.note(NoteKind::Ignored, "area lights of invisible interfaces: left out", at.clone());
            }
            if interface.is_none() {
                return Ok(None);
            }
        }
        let invisible = alpha.is_some_and(|a| a.texture.is_none() && a.factor <= 0.0);
        if invisible && light.is_none() {
            return Ok(None);
        }
        let textured = materials.is_textured(state.material)
            || alpha.is_some_and(|a| a.texture.is_some())
            || light.is_some_and(|l| l.radiance.texture.is_some());
        let prototype = match quadrics::prototype(class, parameters) {
            Some(quadric) => Some(quadric),
            None if *class == "plymesh" => {
                parameters.string("filename").map(|name| Prototype::File(name.to_owned()))
            }
            None => None,
        };
        let mut data = None;
        // The radiance of a light that is given by its power depends on the mesh's area.
        if light.is_some_and(|light| light.power.is_some()) {
            data = self.data(loading, request, prototype.as_ref(), textured)?;
            if data.is_none() {
                return Ok(None);
            }
        }
        let emission = light.map(|light| emission(&light, data.as_ref(), request.to_world));
        let material = if is_boundary {
            materials.boundary(loading)?
        } else {
            materials.material(loading, state.material, emission, alpha)?
        };
        let key = prototype.clone().map(|prototype| (prototype, material, state.reverse, interface));
        if let Some(key) = &key
            && let Some(known) = self.known.get(key)
        {
            parameters.accept_known();
            return Ok(*known);
        }
        if data.is_none() {
            data = self.data(loading, request, prototype.as_ref(), textured)?;
        }
        let mesh = match data {
            Some(data) => {
                loading.geometry.take(bytes(&data) as u64, &at)?;
                let mesh = loading.builder.add_mesh(data, material)?;
                if let Some(interface) = interface {
                    loading.builder.set_interface(mesh, interface)?;
                }
                Some(mesh)
            }
            None => None,
        };
        if let Some(key) = key {
            self.known.insert(key, mesh);
        }
        Ok(mesh)
    }

    /// Returns the triangles of a shape, oriented, with `v` down.
    fn data(
        &self,
        loading: &mut Loading<'_>,
        request: &Request<'_>,
        prototype: Option<&Prototype>,
        textured: bool,
    ) -> Result<Option<MeshData>> {
        let Request { class, parameters, state, .. } = request;
        let made = match prototype {
            Some(Prototype::Quadric(..)) => {
                quadrics::mesh(loading, class, parameters)?.map(|data| (data, Orientation::Quadric))
            }
            _ => meshes::mesh(loading, class, parameters)?.map(|data| (data, Orientation::Triangles)),
        };
        let Some((mut data, orientation)) = made else { return Ok(None) };
        if data.triangles.is_empty() {
            return Ok(None);
        }
        if textured && data.uvs.is_empty() {
            data = meshes::with_default_uvs(data);
        }
        data.flip_v();
        // In pbrt-v3, vertex normals alone decide the side of triangles that have them.
        let stays = orientation == Orientation::Triangles
            && !data.normals.is_empty()
            && loading.version == Version::V3;
        if state.reverse && !stays {
            data.turn_around();
        }
        Ok(Some(data))
    }
}

/// Alpha of a shape, if it is not opaque everywhere.
fn alpha(loading: &mut Loading<'_>, textures: &Textures, p: &Parameters) -> Option<FloatInput> {
    let mut alpha = textures.float(loading, p, "alpha")?;
    alpha.factor = alpha.factor.max(0.0);
    let opaque = match (alpha.texture, loading.version) {
        (Some(_), _) => false,
        // pbrt-v3 tests only if alpha is 0.
        (None, Version::V3) => alpha.factor > 0.0,
        (None, Version::V4) => alpha.factor >= 1.0,
    };
    (!opaque).then_some(alpha)
}

/// Light of a shape, if it has one that is not black.
fn light(loading: &mut Loading<'_>, request: &Request<'_>) -> Option<AreaLight> {
    let light = request.state.area_light?;
    if request.in_object {
        let message = "area lights of shapes in objects, which pbrt leaves out too: left out";
        loading.note(NoteKind::Ignored, message, request.parameters.at());
        return None;
    }
    (!light.radiance.factor.is_black()).then_some(light)
}

/// Emission of a light; a light with a power needs the mesh `data` for its area.
fn emission(light: &AreaLight, data: Option<&MeshData>, to_world: &DAffine3) -> Emission {
    let mut radiance = light.radiance;
    if let (Some(power), Some(data)) = (light.power, data) {
        let sides = if light.two_sided { 2.0 } else { 1.0 };
        let area = sides * std::f64::consts::PI * area(data, to_world);
        let factor = (f64::from(power) / area) as f32;
        if factor.is_finite() {
            radiance.factor *= factor;
        }
    }
    Emission { radiance, two_sided: light.two_sided }
}

/// Area of a mesh in the world (m²).
fn area(data: &MeshData, to_world: &DAffine3) -> f64 {
    let corner = |i: u32| data.positions.get(i as usize).copied().unwrap_or(Vec3::ZERO).as_dvec3();
    let twice = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| to_world.transform_point3(corner(i)));
        (b - a).cross(c - a).length()
    };
    0.5 * data.triangles.iter().map(twice).sum::<f64>()
}

/// Memory of a mesh (bytes).
fn bytes(data: &MeshData) -> usize {
    size_of_val(&data.positions[..])
        + size_of_val(&data.normals[..])
        + size_of_val(&data.uvs[..])
        + size_of_val(&data.triangles[..])
}
