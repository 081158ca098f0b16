//! Mitsuba scenes, `.xml`: versions 0.4 to 0.6[^mitsuba06], 2 and 3[^mitsuba3].
//!
//! Axes and units are taken as they are. The table [`FEATURES`] lists the counterpart of each
//! plugin; a plugin without a row is noted and replaced by the plainest plugin of its kind. Unused
//! parameters are noted.
//!
//! | module | content |
//! |---|---|
//! | [`reader`], [`steps`], [`text`] | XML to objects: defaults, includes, references, transforms |
//! | [`object`], [`known`] | objects, their parameters and children; the parameters that exist |
//! | [`values`], [`transforms`], [`paths`] | text into numbers, matrices, places of files |
//! | [`inputs`] | colours, numbers and textures |
//! | [`materials`], [`surfaces`] | bsdfs |
//! | [`shapes`], [`serialized`], [`normals`] | shapes and mesh files |
//! | [`media`], [`volumes`], [`vol`] | participating media |
//! | [`lights`], [`sun`] | emitters |
//! | [`sensors`] | cameras |
//!
//! # Guarantee
//! Any bytes give a scene or an error with file, line and column. Many objects may refer to one
//! object, and references may be nested or circular: each object is converted once, at most
//! [`MAX_DEPTH`] levels deep. The same files give the same scene.
//!
//! # Limits
//! Without `twosided`, the back of an opaque surface is black. Polarization is not supported;
//! spectra become colours.
//!
//! Held to this by `suite::mitsuba`, `suite::damaged_mitsuba`.
//!
//! [^mitsuba06]: Wenzel Jakob. 2014. "Mitsuba Documentation." Version 0.5, valid for 0.6.
//! [^mitsuba3]: Wenzel Jakob and others. "Mitsuba 3 Renderer." Documentation, version 3.9.

mod features;
mod inputs;
mod known;
mod lights;
mod materials;
mod media;
mod metals;
mod normals;
mod object;
mod paths;
mod principled;
mod reader;
mod sensors;
mod serialized;
mod shapes;
mod slides;
mod steps;
mod sun;
mod surfaces;
mod text;
mod transforms;
mod values;
mod vol;
mod volumes;

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use self::inputs::{Quantity, Textured};
use self::object::{Class, Document, Object};
use self::shapes::{MeshKey, Placement};
use super::SceneFiles;
use super::assets::ImageCache;
use super::features::{Feature, Support};
use super::lights::Surroundings;
use super::limits::Budget;
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::notes::shown;
use crate::scene::{
    Material, MaterialId, MediumId, MeshId, NoteKind, Notes, Scene, SceneBuilder, TurnedAway,
};

pub(super) use features::FEATURES;

/// Deepest nesting of references between objects.
const MAX_DEPTH: usize = 64;

/// Number of undefined references that are compared with ids; chosen.
const MAX_SLIPS: usize = 100;

/// Largest number of ids that a reference is compared with; chosen.
const MAX_COMPARED: usize = 10_000;

/// Reads a scene file and the files that it refers to.
///
/// # Errors
/// [`Error::Io`] if the scene file or an included file cannot be read; otherwise errors of the
/// text, with line and column.
pub(super) fn load(files: &SceneFiles) -> Result<Scene> {
    let mut notes = Notes::default();
    let document = reader::read(files, &mut notes)?;
    let mut builder = SceneBuilder::new(files.name(), Location::file(files.path()));
    builder.extend_notes(notes.iter());
    document.animated.iter().for_each(|&span| builder.add_animated_seconds(span));
    builder.set_turned_away(TurnedAway::Opposite);
    let mut translation = Translation {
        files,
        document: &document,
        builder,
        images: ImageCache::new(files),
        textures: Made(BTreeMap::new()),
        materials: Made(BTreeMap::new()),
        media: Made(BTreeMap::new()),
        shape_materials: BTreeMap::new(),
        boundary: None,
        shapes: Made(BTreeMap::new()),
        meshes: BTreeMap::new(),
        last_file: None,
        placed: 0,
        triangles: 0,
        environments: Surroundings::default(),
        slides: Budget::new(files.options().max_file_bytes, "images of lights"),
        volumes: Budget::new(files.options().max_file_bytes, "volumes"),
        camera_names: BTreeSet::new(),
        blurred: Vec::new(),
        depth: 0,
    };
    translation.note_missing()?;
    for &root in &document.roots {
        translation.add(&document.objects[root])?;
    }
    translation.finish_environments()?;
    translation.finish_media();
    translation.note_stopped();
    translation.note_unused()?;
    translation.builder.build()
}

/// Results that are computed once for each object. A result is none while it is being computed; a
/// second request during that time means that references form a cycle.
struct Made<K, T>(BTreeMap<K, Option<T>>);

impl<K: Ord + Copy, T: Clone> Made<K, T> {
    /// Returns the result for `object`; none if the caller is to make it now.
    fn begin(&mut self, key: K, object: &Object) -> Result<Option<T>> {
        match self.0.get(&key) {
            Some(Some(made)) => Ok(Some(made.clone())),
            Some(None) => {
                let found = "an object that refers to itself";
                Err(Error::invalid(object.place(), found, "references without a cycle"))
            }
            None => {
                self.0.insert(key, None);
                Ok(None)
            }
        }
    }

    fn finish(&mut self, key: K, made: T) -> T {
        self.0.insert(key, Some(made.clone()));
        made
    }
}

/// State of the conversion of a document to a scene.
struct Translation<'a> {
    files: &'a SceneFiles,
    document: &'a Document,
    builder: SceneBuilder,
    images: ImageCache<'a>,
    textures: Made<(usize, Quantity), Textured>,
    materials: Made<usize, Material>,
    /// Media by object; none for vacuum.
    media: Made<usize, Option<MediumId>>,
    /// Materials by bsdf and light.
    shape_materials: BTreeMap<(Option<usize>, Option<usize>), MaterialId>,
    boundary: Option<MaterialId>,
    shapes: Made<usize, Vec<Placement>>,
    meshes: BTreeMap<MeshKey, MeshId>,
    /// Name and bytes of the mesh file that was read last.
    last_file: Option<(String, Rc<Vec<u8>>)>,
    placed: usize,
    triangles: usize,
    environments: Surroundings,
    /// Budget for images of lights.
    slides: Budget,
    /// Budget for grids of media: a file counts each time that it is read.
    volumes: Budget,
    camera_names: BTreeSet<String>,
    /// Locations of animations that blur something.
    blurred: Vec<Location>,
    depth: usize,
}

impl<'a> Translation<'a> {
    fn add(&mut self, object: &'a Object) -> Result<()> {
        match object.class {
            Class::Shape => self.add_shape(object),
            Class::Emitter => self.add_light(object),
            Class::Sensor => self.add_sensor(object),
            // Sampling and output are settings of the user.
            Class::Integrator | Class::Film | Class::Sampler | Class::Filter => self.without_effect(object),
            // Converted when an object refers to it.
            Class::Bsdf | Class::Texture | Class::Medium => Ok(()),
        }
    }

    /// Notes animations that are loaded at a single time.
    fn note_stopped(&mut self) {
        let message = match self.files.options().shutter {
            Some(_) => "animations: shown in the middle of the time that the shutter is open",
            None => "animations: the first key is shown",
        };
        for at in self.document.stopped.iter().filter(|at| !self.blurred.contains(at)) {
            self.builder.note(NoteKind::Approximated, message, at.clone());
        }
    }

    /// Notes a plugin by its row in the table, or else that it is unknown; returns true if it has a
    /// row.
    fn meet(&mut self, kind: &str, object: &Object, instead: &str) -> Result<bool> {
        if self.feature(kind, &object.plugin, &object.at)? {
            return Ok(true);
        }
        Feature::refuse_slip(FEATURES, [kind, &object.plugin], &object.at)?;
        let message = Feature::unknown([kind, &object.plugin], instead);
        self.builder.note(NoteKind::Ignored, message, object.at.clone());
        Ok(false)
    }

    /// Notes unknown parameters of an object that has no effect on the picture.
    fn without_effect(&mut self, object: &Object) -> Result<()> {
        object.accept_known();
        object.note_unused(self.builder.notes_mut())
    }

    /// Notes a name by its row in the table; returns true if it has one.
    fn feature(&mut self, kind: &str, name: &str, at: &Location) -> Result<bool> {
        Feature::look_up(FEATURES, [kind, name], at, self.builder.notes_mut())
    }

    /// Returns true if the table ignores a plugin.
    fn is_left_out(&self, kind: &str, object: &Object) -> bool {
        Feature::find(FEATURES, kind, &object.plugin).is_some_and(|f| f.support == Support::Ignored)
    }

    /// Calls `make` one level of nesting deeper.
    fn nested<T>(&mut self, object: &Object, make: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        if self.depth >= MAX_DEPTH {
            let found = format!("objects more than {MAX_DEPTH} deep in each other");
            return Err(Error::invalid(object.place(), found, "a flatter scene"));
        }
        self.depth += 1;
        let made = make(self);
        self.depth -= 1;
        made
    }

    /// Notes references to ids that are not defined.
    ///
    /// # Errors
    /// If one of them is a slip of a defined id.
    fn note_missing(&mut self) -> Result<()> {
        let mut missing = 0;
        for child in self.document.objects.iter().flat_map(|o| &o.children) {
            if let object::Target::Id(id) = &child.target
                && self.document.resolve(child).is_none()
            {
                missing += 1;
                let known = self.document.ids.keys().take(MAX_COMPARED).map(String::as_str);
                let near = if missing > MAX_SLIPS { None } else { nearest_name(id, known) };
                if let Some(near) = near {
                    return Err(Error::misspelt(child.at.clone(), "reference to", &shown(id), near));
                }
                let message = format!("reference to {:?}, which is not defined: left out", shown(id));
                self.builder.note(NoteKind::Repaired, message, child.at.clone());
            }
        }
        Ok(())
    }

    /// Notes unused parameters of the objects in use.
    fn note_unused(&mut self) -> Result<()> {
        for object in &self.document.objects {
            if self.was_used(object) {
                object.note_unused(self.builder.notes_mut())?;
            }
        }
        Ok(())
    }

    fn was_used(&self, object: &Object) -> bool {
        let textured = || {
            let quantities = [Quantity::Reflectance, Quantity::Radiance, Quantity::Number];
            quantities.iter().any(|q| self.textures.0.contains_key(&(object.index, *q)))
        };
        match object.class {
            Class::Bsdf => self.materials.0.contains_key(&object.index),
            Class::Texture => textured(),
            Class::Emitter => !Self::is_shape_light(object),
            Class::Shape => object.plugin != "shapegroup" || self.shapes.0.contains_key(&object.index),
            Class::Sensor => true,
            _ => false,
        }
    }
}
