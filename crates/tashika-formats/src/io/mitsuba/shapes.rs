//! Conversion of `<shape>`s to meshes and their placements.
//!
//! Spheres, disks, cylinders, rectangles and cubes of one material share one mesh of unit size. A
//! shape group is a list of meshes, which each of its instances places. Positions of mesh files are
//! not transformed: the transform belongs to the instance.
//!
//! Mitsuba transforms the vertices of a mesh file first and then computes normals from their order.
//! A transform with a reflection therefore turns a mesh without normals inside out, in Mitsuba and
//! here.
//!
//! Held to this by `suite::mitsuba`.

use std::f32::consts::TAU;

use glam::{DAffine3, DMat3, DMat4, DVec3, Vec2};

use super::object::{Class, Object};
use super::{Translation, materials, normals, paths, serialized, transforms};
use crate::error::{Error, Location, Result};
use crate::io::assets::{kind, reason};
use crate::io::notes::shown;
use crate::io::{mesh_files, shapes};
use crate::math::motion::Track;
use crate::scene::{Emission, Interface, MaterialId, MeshData, MeshId, NoteKind};

/// Most placements of meshes, each instance counted. A moving placement counts by its memory, in
/// units of a static one.
const MAX_PLACEMENTS: usize = 1 << 21;

/// Approximate memory of a static placement (bytes).
const PLACEMENT_BYTES: usize = 150;

/// Most triangles that are stored; a mesh that is read again for another material counts again.
const MAX_TRIANGLES: usize = 1 << 30;

/// Limit of `max_smooth_angle` (degrees): smaller angles give flat faces.
const FLAT_BELOW: f64 = 30.0;

/// A mesh with its transform.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    mesh: MeshId,
    to_world: DMat4,
}

/// Key of equal meshes: source, settings of its reader, material and media.
pub(super) type MeshKey = (String, MadeOf);

/// Material, and media on both sides.
type MadeOf = (MaterialId, Option<Interface>);

impl<'a> Translation<'a> {
    /// Adds a shape of the scene.
    pub(super) fn add_shape(&mut self, object: &Object) -> Result<()> {
        if object.plugin == "shapegroup" {
            // Only its instances are placed.
            return Ok(());
        }
        let motion = self.motion(object);
        let placements = self.placements(object)?;
        match &object.id {
            Some(id) => self.builder.begin_object(id),
            None => self.builder.begin_unnamed_object(&object.plugin),
        }
        for placement in placements {
            // `placement.to_world` contains the animation's current transform, which is divided
            // out.
            let track = motion.as_ref().and_then(|(track, now, _)| {
                track.after(now.inverse() * transforms::affine_f64(&placement.to_world))
            });
            self.placed += 1 + track.as_ref().map_or(0, Track::bytes) as usize / PLACEMENT_BYTES;
            if self.placed > MAX_PLACEMENTS {
                return Err(Error::unsupported(
                    object.place(),
                    format!("more than {MAX_PLACEMENTS} placements of meshes"),
                    "use larger shape groups or fewer instances",
                ));
            }
            match (track, &motion) {
                (Some(track), Some((.., shutter))) if track.can_place() => {
                    self.builder.add_moving_instance(placement.mesh, track, *shutter)?;
                }
                _ => {
                    let to_world = transforms::affine_f64(&placement.to_world);
                    self.builder.add_instance(placement.mesh, to_world)?;
                }
            }
        }
        Ok(())
    }

    /// Motion of a shape while the shutter is open, its current transform, and the times at which
    /// the shutter opens and closes (s). None if the shape stands still or cannot be placed at all
    /// times.
    fn motion(&mut self, object: &Object) -> Option<(Track, DAffine3, [f64; 2])> {
        let (track, at) = object.track("to_world")?;
        let shutter = self.files.options().exposure(Some(self.shutter()))?;
        let now = transforms::affine_f64(&object.transform("to_world")?);
        // A shape that stands still at the requested time needs no motion: its transform already
        // places it.
        let stands = self.files.options().time().is_some() && !track.moves_between(shutter);
        if stands || !track.can_place() || now.matrix3.determinant() == 0.0 {
            return None;
        }
        self.blurred.push(at.clone());
        Some((track.clone(), now, shutter))
    }

    /// Converts a shape to placed meshes.
    fn placements(&mut self, object: &Object) -> Result<Vec<Placement>> {
        if let Some(known) = self.shapes.begin(object.index, object)? {
            return Ok(known);
        }
        let placements = self.nested(object, |inside| inside.convert_shape(object))?;
        // The result is stored only if another object may refer to this one.
        if object.id.is_some() {
            return Ok(self.shapes.finish(object.index, placements));
        }
        self.shapes.0.remove(&object.index);
        Ok(placements)
    }

    fn convert_shape(&mut self, object: &Object) -> Result<Vec<Placement>> {
        if !self.meet("shape", object, "left out")? {
            object.accept_all();
            return Ok(Vec::new());
        }
        if self.is_left_out("shape", object) {
            object.accept_known();
            return Ok(Vec::new());
        }
        let to_world = object.transform("to_world").unwrap_or(DMat4::IDENTITY);
        match object.plugin.as_str() {
            "shapegroup" | "merge" => return self.group(object, to_world),
            "instance" => return self.instance(object, to_world),
            _ => {}
        }
        let document = self.document;
        let bsdf = document.children(object, Class::Bsdf).next().map(|(_, o)| o);
        let light = self.area_light(object)?;
        let interface = self.interface(object)?;
        let is_invisible = match bsdf {
            Some(bsdf) if light.is_none() => materials::is_invisible(&self.material(bsdf)?),
            _ => false,
        };
        if is_invisible && interface.is_none() {
            object.accept_known();
            return Ok(Vec::new());
        }
        let material = if is_invisible { self.boundary()? } else { self.shape_material(bsdf, light)? };
        let made_of = (material, interface);
        let placement = match object.plugin.as_str() {
            "obj" | "ply" | "serialized" => self.mesh_file(object, made_of, to_world)?,
            _ => self.primitive(object, made_of, to_world)?,
        };
        Ok(placement.into_iter().collect())
    }

    /// Light that makes a shape emit.
    fn area_light(&mut self, object: &Object) -> Result<Option<(&'a Object, Emission)>> {
        let document = self.document;
        for (_, light) in document.children(object, Class::Emitter) {
            if matches!(light.plugin.as_str(), "area" | "directionalarea") {
                self.meet("light", light, "left out")?;
                let emission = self.emission(light)?;
                light.note_unused(self.builder.notes_mut())?;
                return Ok(Some((light, emission)));
            }
            let message = format!("light {:?} on a shape: left out", shown(&light.plugin));
            self.builder.note(NoteKind::Ignored, message, light.at.clone());
            light.accept_all();
        }
        Ok(None)
    }

    fn group(&mut self, object: &Object, to_world: DMat4) -> Result<Vec<Placement>> {
        let mut all = Vec::new();
        let document = self.document;
        for (_, part) in document.children(object, Class::Shape) {
            if matches!(part.plugin.as_str(), "instance" | "shapegroup") {
                let message = "instances and groups inside of a shape group: left out";
                self.builder.note(NoteKind::Ignored, message, part.at.clone());
                continue;
            }
            all.extend(self.placements(part)?);
            if all.len() > MAX_PLACEMENTS {
                let what = format!("a group of more than {MAX_PLACEMENTS} shapes");
                return Err(Error::unsupported(object.place(), what, "split it"));
            }
        }
        Ok(all.into_iter().map(|p| Placement { to_world: to_world * p.to_world, ..p }).collect())
    }

    fn instance(&mut self, object: &Object, to_world: DMat4) -> Result<Vec<Placement>> {
        let document = self.document;
        let Some((_, group)) = document.children(object, Class::Shape).next() else {
            let message = "instance without a shape group: left out";
            self.builder.note(NoteKind::Repaired, message, object.at.clone());
            return Ok(Vec::new());
        };
        if group.plugin == "instance" {
            let message = "instance of an instance: left out";
            self.builder.note(NoteKind::Ignored, message, object.at.clone());
            return Ok(Vec::new());
        }
        let placed = self.placements(group)?;
        Ok(placed.into_iter().map(|p| Placement { to_world: to_world * p.to_world, ..p }).collect())
    }

    /// A mesh of unit size and the transform that gives it its size.
    fn primitive(&mut self, object: &Object, made_of: MadeOf, to_world: DMat4) -> Result<Option<Placement>> {
        let at = object.place();
        let radius = object.float_in("radius", 0.0..=1e30).unwrap_or(1.0);
        let flipped = object.boolean("flip_normals").unwrap_or(false);
        let (make, size): (fn(&Location) -> Result<MeshData>, DMat4) = match object.plugin.as_str() {
            "sphere" => {
                let center = object.vector("center").unwrap_or(DVec3::ZERO);
                (unit_sphere, DMat4::from_translation(center) * DMat4::from_scale(DVec3::splat(radius)))
            }
            "cylinder" => {
                let p0 = object.vector("p0").unwrap_or(DVec3::ZERO);
                let p1 = object.vector("p1").unwrap_or(DVec3::Z);
                // A cylinder of length 0 has no surface.
                (unit_cylinder, cylinder_frame(p0, p1, radius).unwrap_or(DMat4::ZERO))
            }
            "disk" => (unit_disk, DMat4::from_scale(DVec3::splat(radius))),
            "cube" => (|_| Ok(shapes::cube()), DMat4::IDENTITY),
            _ => (|_| Ok(shapes::rectangle()), DMat4::IDENTITY),
        };
        if size.determinant() == 0.0 {
            let message = format!("shapes {:?} without extent: left out", object.plugin);
            self.builder.note(NoteKind::Repaired, message, object.at.clone());
            return Ok(None);
        }
        let key = (format!("{} {flipped}", object.plugin), made_of);
        let mesh = match self.meshes.get(&key) {
            Some(&mesh) => mesh,
            None => {
                let mut data = make(&at)?;
                shown(object.label()).clone_into(&mut data.name);
                if flipped {
                    data.turn_around();
                }
                self.add_mesh(key, data, &at)?
            }
        };
        Ok(Some(Placement { mesh, to_world: to_world * size }))
    }

    /// Reads the mesh of a file; `None`, with a note, if the file cannot be read.
    fn mesh_file(&mut self, object: &Object, made_of: MadeOf, to_world: DMat4) -> Result<Option<Placement>> {
        object.accept(&["collapse", "max_error", "shape_name"]);
        let Some(reference) = object.text("filename") else {
            let message = format!("shape {:?} without a file: left out", object.plugin);
            self.builder.note(NoteKind::Repaired, message, object.at.clone());
            return Ok(None);
        };
        let reference = self.find(reference, object);
        let flipped = object.boolean("flip_normals").unwrap_or(false);
        let flat = object.boolean("face_normals").unwrap_or(false) | self.max_smooth_angle(object)?;
        // By default, Mitsuba flips the texture coordinates of OBJ files, but not those of other
        // files.
        let flip_v = object.boolean("flip_tex_coords").unwrap_or(object.plugin == "obj");
        let shape_index = object.integer("shape_index").unwrap_or(0);
        let mirrored = to_world.determinant() < 0.0;
        let how = format!("{} {reference} {shape_index} {flipped} {flat} {flip_v} {mirrored}", object.plugin);
        let key = (how, made_of);
        if let Some(&mesh) = self.meshes.get(&key) {
            return Ok(Some(Placement { mesh, to_world }));
        }
        let at = object.place();
        let bytes = match self.mesh_bytes(&reference, &at) {
            Ok(bytes) => bytes,
            Err(error @ (Error::Io { .. } | Error::Outside { .. })) => {
                let why = reason(&error);
                let message = format!("mesh {:?} could not be read ({why}): left out", shown(&reference));
                self.builder.note(kind(&error), message, object.line_of("filename").clone());
                return Ok(None);
            }
            Err(other) => return Err(other),
        };
        let path = self.files.beside(&reference);
        let (mut data, mut flat) = match object.plugin.as_str() {
            // The reader of OBJ files flips the coordinates.
            "obj" => (turned(mesh_files::read_obj(&bytes, &path, self.builder.notes_mut())?, !flip_v), flat),
            "ply" => {
                let options = self.files.options();
                (
                    turned(
                        mesh_files::read_ply(
                            &bytes,
                            options,
                            self.builder.notes_mut(),
                            &Location::file(path),
                        )?,
                        flip_v,
                    ),
                    flat,
                )
            }
            _ => {
                let mesh = serialized::read(&bytes, shape_index, &Location::file(path))?;
                (turned(mesh.data, flip_v), flat || mesh.face_normals)
            }
        };
        flat |= data.triangles.is_empty();
        if mirrored && data.normals.is_empty() {
            data.turn_around();
        }
        if flat {
            if mirrored && !data.normals.is_empty() {
                data.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            data.normals = Vec::new();
        } else if data.normals.is_empty() {
            data.normals = normals::of_vertices(&data.positions, &data.triangles);
        }
        if flipped {
            data.turn_around();
        }
        shown(object.id.as_deref().unwrap_or(&reference)).clone_into(&mut data.name);
        Ok(Some(Placement { mesh: self.add_mesh(key, data, &at)?, to_world }))
    }

    /// Reads the bytes of a mesh file. The bytes of the last file are stored, because many shapes
    /// may come from one file.
    fn mesh_bytes(&mut self, reference: &str, at: &Location) -> Result<std::rc::Rc<Vec<u8>>> {
        if let Some((name, bytes)) = &self.last_file
            && name == reference
        {
            return Ok(std::rc::Rc::clone(bytes));
        }
        let bytes = std::rc::Rc::new(self.files.read(reference, at)?);
        self.last_file = Some((reference.to_owned(), std::rc::Rc::clone(&bytes)));
        Ok(bytes)
    }

    fn add_mesh(&mut self, key: MeshKey, data: MeshData, at: &Location) -> Result<MeshId> {
        self.triangles += data.triangles.len();
        if self.triangles > MAX_TRIANGLES {
            let what = format!("more than {MAX_TRIANGLES} triangles");
            return Err(Error::unsupported(at.clone(), what, "use instances of shape groups"));
        }
        let (material, interface) = key.1;
        let mesh = self.builder.add_mesh(data, material)?;
        if let Some(interface) = interface {
            self.builder.set_interface(mesh, interface)?;
        }
        self.meshes.insert(key, mesh);
        Ok(mesh)
    }

    /// Returns true if an angle is given that makes nearly all edges sharp.
    fn max_smooth_angle(&mut self, object: &Object) -> Result<bool> {
        let Some(angle) = object.float("max_smooth_angle") else { return Ok(false) };
        self.feature("shape", "max_smooth_angle", &object.at)?;
        Ok(angle < FLAT_BELOW)
    }

    /// Finds a file of an object: beside the scene, beside the included file, or in a folder of
    /// `<path>`.
    pub(super) fn find(&self, reference: &str, object: &Object) -> String {
        let document = self.document;
        let folders =
            ["", object.folder.as_str()].into_iter().chain(document.paths.iter().map(String::as_str));
        let candidates = paths::candidates(reference, folders);
        paths::first_there(self.files, &candidates, &object.at).to_owned()
    }
}

/// Texture coordinates: azimuth, and angle from `+z`.
fn unit_sphere(at: &Location) -> Result<MeshData> {
    Ok(turned(shapes::sphere(1.0, [-1.0, 1.0], TAU, at)?, true))
}

/// Texture coordinates: azimuth, and height.
fn unit_cylinder(at: &Location) -> Result<MeshData> {
    shapes::cylinder(1.0, [0.0, 1.0], TAU, at)
}

/// Texture coordinates: distance from the centre, and azimuth.
fn unit_disk(at: &Location) -> Result<MeshData> {
    let mut data = shapes::disk(0.0, 1.0, 0.0, TAU, at)?;
    data.uvs.iter_mut().for_each(|uv| *uv = Vec2::new(1.0 - uv.y, uv.x));
    Ok(data)
}

/// Map of the unit cylinder along `z` to the cylinder from `p0` to `p1`.
fn cylinder_frame(p0: DVec3, p1: DVec3, radius: f64) -> Option<DMat4> {
    let axis = p1 - p0;
    let (x, y) = axis.try_normalize()?.any_orthonormal_pair();
    let axes = DMat3::from_cols(x * radius, y * radius, axis);
    Some(DMat4::from_translation(p0) * DMat4::from_mat3(axes))
}

/// Flips `v` of a mesh if `turn` is true.
fn turned(mut data: MeshData, turn: bool) -> MeshData {
    if turn {
        data.flip_v();
    }
    data
}
