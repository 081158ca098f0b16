//! `Shape`: meshes with their material.
//!
//! A shape becomes a mesh in its own space, placed by the transform that was current. Meshes of the
//! same parameters, material and orientation are kept once, however often a file repeats them.
//!
//! Light leaves on the side of pbrt's surface normal. For triangles that is the side of the vertex
//! normals, or else the side from which the corners run counter-clockwise *in the space of the
//! shape*: the exclusive or with the handedness of the transform in pbrt makes up for its triangles
//! being in the world. `ReverseOrientation` turns it around, where there are vertex normals only in
//! pbrt-v4. For quadrics it is the side of their own normals, which it turns around too.
//!
//! Alpha textures cut holes in pbrt-v3 (where they are 0) and transmit a fraction in pbrt-v4. An
//! emitter of alpha 0 is invisible and emits in full; an emitter of fractional alpha emits that
//! fraction. Area lights of shapes inside objects are left out, as in pbrt.
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

/// A mesh and where it is in the space of the world, or of the object that it belongs to.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// What is placed.
    pub(super) mesh: MeshId,
    /// Shape to object.
    pub(super) to_object: DAffine3,
    /// The same at all times, if it moves while the shutter is open.
    pub(super) track: Option<Track>,
}

/// A `Shape` directive.
pub(super) struct Request<'a> {
    /// Type of the shape.
    pub(super) class: &'a str,
    /// Its parameters.
    pub(super) parameters: &'a Parameters,
    /// The state that it is met in.
    pub(super) state: &'a State,
    /// Whether it belongs to an object.
    pub(super) in_object: bool,
    /// Where it is.
    pub(super) to_world: &'a DAffine3,
}

/// How `ReverseOrientation` acts on a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Orientation {
    /// As on triangles.
    Triangles,
    /// As on quadrics.
    Quadric,
}

/// A shape by its parameters: its type with numbers, or the name of a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Prototype {
    Quadric(&'static str, Vec<u32>),
    File(String),
}

/// The meshes that can be met again.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    /// By prototype, material, orientation, and what is on either side.
    known: BTreeMap<(Prototype, MaterialId, bool, Option<Interface>), Option<MeshId>>,
}

impl Shapes {
    /// The mesh of a shape; nothing if it is invisible or left out.
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
        // The radiance of a power depends on the mesh's area.
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

    /// The triangles of a shape, oriented, with `v` down.
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
        // Vertex normals decide for triangles in pbrt-v3.
        let stays = orientation == Orientation::Triangles
            && !data.normals.is_empty()
            && loading.version == Version::V3;
        if state.reverse && !stays {
            data.turn_around();
        }
        Ok(Some(data))
    }
}

/// The alpha of a shape, if it is not opaque everywhere.
fn alpha(loading: &mut Loading<'_>, textures: &Textures, p: &Parameters) -> Option<FloatInput> {
    let mut alpha = textures.float(loading, p, "alpha")?;
    alpha.factor = alpha.factor.max(0.0);
    let opaque = match (alpha.texture, loading.version) {
        (Some(_), _) => false,
        // pbrt-v3 asks only whether it is 0.
        (None, Version::V3) => alpha.factor > 0.0,
        (None, Version::V4) => alpha.factor >= 1.0,
    };
    (!opaque).then_some(alpha)
}

/// The light of a shape, if it has one that is black nowhere.
fn light(loading: &mut Loading<'_>, request: &Request<'_>) -> Option<AreaLight> {
    let light = request.state.area_light?;
    if request.in_object {
        let message = "area lights of shapes in objects, which pbrt leaves out too: left out";
        loading.note(NoteKind::Ignored, message, request.parameters.at());
        return None;
    }
    (!light.radiance.factor.is_black()).then_some(light)
}

/// What a light emits from a mesh of that area.
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

/// Bytes that a mesh holds.
fn bytes(data: &MeshData) -> usize {
    size_of_val(&data.positions[..])
        + size_of_val(&data.normals[..])
        + size_of_val(&data.uvs[..])
        + size_of_val(&data.triangles[..])
}
