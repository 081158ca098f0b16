//! Wavefront OBJ with MTL materials.
//!
//! Input: a text file of polygons and, beside it, material libraries and images. Output: a
//! [`Scene`] in the file's own coordinates, taken as metres, with one mesh per material.
//!
//! | module | content |
//! |---|---|
//! | [`text`] | encodings, lines, words, numbers |
//! | [`features`] | support of each statement, for notes and the guide |
//! | [`parse`] | OBJ statements to lists, indices checked |
//! | [`shading_normals`] | smoothing groups, flat faces |
//! | [`polygon`](super::polygon) | polygons to triangles |
//! | [`meshes`] | faces to meshes by material |
//! | [`mtl`], [`map`] | MTL statements to lists |
//! | [`references`] | finding libraries and images |
//! | [`materials`] | MTL definitions to materials |
//! | [`tally`] | counts of notes |
//!
//! # Guarantee
//! Any bytes give a scene or an error with file and line; memory and time are bounded by a multiple
//! of the sizes of the files. The same files give the same scene.
//!
//! # Limits
//! Ignored features are listed in the table [`FEATURES`] and noted. The format has no cameras, and
//! no lights except emitting materials.
//!
//! Sources: the Wavefront Advanced Visualizer manual, appendix B1 (OBJ); the MTL specification,
//! version 4.2 (1995). Held to this by `suite::obj`, `suite::damaged_obj`.

mod features;
mod map;
mod materials;
mod meshes;
mod mtl;
mod parse;
mod references;
mod shading_normals;
mod tally;
mod text;

use std::path::Path;

use glam::Affine3A;

use super::SceneFiles;
use super::mixes::{GREY, grey};
use super::notes::Named;
use crate::error::{Error, Location, Result, nearest_name};
use crate::scene::{Material, MeshData, NoteKind, Notes, Scene, SceneBuilder};
pub(super) use features::FEATURES;
use mtl::Definitions;
use parse::Reference;
use references::Textures;

/// Largest number of names that an undefined name is compared with; chosen.
const MAX_COMPARED: usize = 10_000;

/// Most different undefined materials that notes name.
const MAX_UNDEFINED: usize = 100;

/// Reads an OBJ file and the files that it refers to.
///
/// # Errors
/// [`Error::Io`](crate::error::Error::Io) if the file itself cannot be read; otherwise errors of
/// the text, with their line: words that are no numbers, indices out of range, bytes that are not
/// text.
pub(super) fn load(files: &SceneFiles) -> Result<Scene> {
    let path = files.path();
    let mut notes = Notes::default();
    let mut geometry = {
        let bytes = files.read_scene()?;
        parse::parse(&text::decode(&bytes, path)?, path, &mut notes)?
    };
    shading_normals::complete(&mut geometry, path)?;
    let definitions = references::read_libraries(files, &geometry.libraries, &mut notes)?;
    let meshes = meshes::build(&geometry, path, &mut notes);
    let names = std::mem::take(&mut geometry.materials);
    drop(geometry);

    let mut builder = SceneBuilder::new(files.name(), Location::file(path));
    builder.extend_notes(notes.iter());
    let mut materials = Materials {
        definitions,
        textures: Textures::new(files),
        undefined: Named::new(MAX_UNDEFINED),
        missing: 0,
        files,
    };
    for mesh in meshes {
        let reference = &names[mesh.material as usize];
        let material = materials.material(reference, &mut builder)?;
        let material = builder.add_material(material)?;
        let mesh = builder.add_mesh(mesh.data, material)?;
        builder.add_instance(mesh, Affine3A::IDENTITY)?;
    }
    builder.build()
}

/// Reads the polygons of an OBJ file as a single mesh, regardless of material, group and smoothing
/// group.
///
/// Corners without a normal get the zero vector; if no corner has one, the mesh has no normals.
/// Texture coordinates run down, as they do everywhere here.
///
/// # Errors
/// As [`load`].
pub(super) fn read_mesh(bytes: &[u8], path: &Path, notes: &mut Notes) -> Result<MeshData> {
    let mut geometry = parse::parse(&text::decode(bytes, path)?, path, notes)?;
    geometry.faces.iter_mut().for_each(|face| face.material = 0);
    Ok(meshes::build(&geometry, path, notes).pop().map(|mesh| mesh.data).unwrap_or_default())
}

struct Materials<'a> {
    definitions: Definitions,
    textures: Textures<'a>,
    undefined: Named,
    /// Number of undefined names.
    missing: usize,
    files: &'a SceneFiles,
}

impl Materials<'_> {
    /// Returns the material of a name.
    ///
    /// # Errors
    /// If no library defines the name, and it is a slip of a defined one.
    fn material(&mut self, used: &Reference, builder: &mut SceneBuilder) -> Result<Material> {
        let Reference { name, line } = used;
        if let Some(definition) = self.definitions.get(name) {
            return Ok(materials::convert(name, definition, &mut self.textures, builder));
        }
        let at = Location::line(self.files.path(), *line);
        if name.is_empty() {
            let message = format!("faces without material: grey of reflectance {GREY}");
            builder.note(NoteKind::Defaulted, message, at);
            return Ok(Material::new("without material", grey()));
        }
        self.missing += 1;
        if self.missing <= MAX_UNDEFINED {
            let mut known: Vec<&str> = self.definitions.keys().map(String::as_str).collect();
            known.sort_unstable();
            if let Some(near) = nearest_name(name, known.into_iter().take(MAX_COMPARED)) {
                return Err(Error::misspelt(at, "material", name, near));
            }
        }
        let message = format!("material {name:?} is not defined: grey of reflectance {GREY}");
        let further = "further materials are not defined: grey";
        self.undefined.add(NoteKind::Repaired, message, further, at, builder.notes_mut());
        Ok(Material::new(name.as_str(), grey()))
    }
}
