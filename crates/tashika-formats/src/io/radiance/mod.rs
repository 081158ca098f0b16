//! Radiance scene descriptions.
//!
//! Input: a text file of primitives and, beside it, files that its command lines name, and data of
//! luminaires. Output: a [`Scene`] in the file's own coordinates, taken as metres. In most files
//! `+z` is up. Radiances are in W·m⁻²·sr⁻¹, as here.
//!
//! | module | content |
//! |---|---|
//! | [`words`] | text to primitives, aliases and commands |
//! | [`features`] | support of each type, for notes and the guide |
//! | [`commands`] | `!xform` and `!cat`; no command is run |
//! | [`transforms`] | transforms and arrays of `xform` |
//! | [`definitions`] | materials and patterns by their names |
//! | [`surfaces`], [`holes`] | polygons and quadrics to meshes |
//! | [`materials`], [`pane`] | materials to surfaces |
//! | [`sources`], [`skies`] | light from infinitely far away |
//! | [`lights`], [`outlines`], [`data`] | spotlights, and luminaires by their data |
//!
//! # Guarantee
//! Any bytes give a scene or an error with file and line. No command is run. Memory and time are
//! bounded by the sizes of the files, a constant number of copies aside. The same files give the
//! same scene.
//!
//! # Assumption
//! Names of files in commands are relative to the folder of the scene file: Radiance is run there.
//!
//! # Limits
//! Ignored features are listed in the table [`FEATURES`] and noted. The format has no views.
//!
//! Sources: [^ward1994]; [^radiance]. Held to this by the tests in `tests` and by
//! `scripts/radiance_sensors.py`.

mod commands;
mod data;
mod definitions;
mod features;
mod holes;
mod lights;
mod materials;
mod outlines;
mod pane;
mod skies;
mod sources;
mod surfaces;
#[cfg(test)]
mod tests;
mod transforms;
mod words;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use super::SceneFiles;
use super::features::Feature;
use super::limits::Includes;
use super::text;
use crate::error::{Error, Location, Result};
use crate::scene::{NoteKind, Scene, SceneBuilder};
use commands::Change;
use definitions::{Definitions, is_surface};
pub(super) use features::FEATURES;
use features::SURFACE;
use lights::Points;
use materials::SurfaceMaterial;
use sources::Sources;
use surfaces::Surfaces;
use transforms::Similarity;
use words::{Primitive, Statement};

/// Largest number of copies of files.
const MAX_COPIES: usize = 1 << 20;

/// Largest number of files that include each other.
const MAX_DEPTH: usize = 32;

/// Numbers of a primitive that count as one more primitive.
const NUMBERS: usize = 16;

/// Reads a Radiance scene and the files that it includes.
///
/// # Errors
/// [`Error::Io`] if the file itself cannot be read; otherwise errors with their file and line:
/// primitives that are not complete, types and modifiers that do not exist, commands other than
/// `!xform` and `!cat`.
pub(super) fn load(files: &SceneFiles) -> Result<Scene> {
    let path = files.path().to_owned();
    let mut reading = Reading {
        files,
        builder: SceneBuilder::new(files.name(), Location::file(&path)),
        definitions: Definitions::default(),
        looks: BTreeMap::new(),
        surfaces: Surfaces::new(),
        sources: Sources::default(),
        points: Points::new(),
        includes: Includes::new(MAX_COPIES, MAX_DEPTH),
        parsed: BTreeMap::new(),
        done: 0,
    };
    let bytes = files.read_scene()?;
    let statements = words::parse(&text::utf8_or_latin1(&text::decoded(&bytes)), &path)?;
    drop(bytes);
    let context = Context { path, ..Context::default() };
    reading.run(&statements, &context)?;
    let Reading { mut builder, surfaces, sources, .. } = reading;
    builder.set_most_instances(files.most_instances());
    surfaces.finish(&mut builder)?;
    sources.finish(&mut builder)?;
    builder.build()
}

/// Changes of the primitives of a file by the commands that include it.
#[derive(Clone, Debug)]
struct Context {
    map: Similarity,
    /// Text before each identifier, with a point between.
    prefix: Option<String>,
    /// Modifier of all surfaces.
    modifier: Option<String>,
    inverts: bool,
    /// File, for messages.
    path: PathBuf,
    /// Number of files that are being read.
    open: usize,
}

impl Default for Context {
    fn default() -> Self {
        let map = Similarity::IDENTITY;
        Self { map, prefix: None, modifier: None, inverts: false, path: PathBuf::new(), open: 1 }
    }
}

impl Context {
    /// Context of the primitives in a copy that `change` makes in this context.
    fn within(&self, change: &Change, copy: u64) -> Self {
        let (map, digits) = change.transforms.copy(copy);
        let own = match (&change.prefix, digits.is_empty()) {
            (prefix, true) => prefix.clone(),
            (Some(prefix), false) => Some(format!("{prefix}.{digits}")),
            (None, false) => Some(format!("a{digits}")),
        };
        let prefix = match (&self.prefix, own) {
            (Some(outer), Some(own)) => Some(format!("{outer}.{own}")),
            (outer, own) => own.or(outer.clone()),
        };
        Self {
            map: map.then(&self.map),
            prefix,
            modifier: self.modifier.clone().or(change.modifier.clone()),
            inverts: self.inverts != change.inverts,
            path: self.path.clone(),
            open: self.open,
        }
    }

    /// Identifier of a surface.
    fn name(&self, own: &str) -> String {
        self.prefix.as_ref().map_or(own.to_owned(), |prefix| format!("{prefix}.{own}"))
    }
}

/// A scene that is being read.
struct Reading<'f> {
    files: &'f SceneFiles,
    builder: SceneBuilder,
    definitions: Definitions,
    /// Materials of surfaces, by the number of the modifier; none if there is no material.
    looks: BTreeMap<usize, Option<SurfaceMaterial>>,
    surfaces: Surfaces,
    sources: Sources,
    points: Points,
    includes: Includes,
    /// Statements of included files.
    parsed: BTreeMap<PathBuf, Arc<Vec<Statement>>>,
    /// Number of primitives so far, those of copies included.
    done: usize,
}

impl Reading<'_> {
    fn run(&mut self, statements: &[Statement], context: &Context) -> Result<()> {
        for statement in statements {
            let at = |line: &u32| Location::line(&context.path, *line);
            match statement {
                Statement::Primitive(primitive) => {
                    let at = at(&primitive.line);
                    self.count(primitive, &at)?;
                    if is_surface(&primitive.kind) == Some(true) {
                        self.surface(primitive, context, &at)?;
                    } else {
                        self.definitions.define(primitive, &context.map, &at)?;
                    }
                }
                Statement::Alias { modifier, name, reference, line } => {
                    self.definitions.alias([modifier, name, reference], &at(line))?;
                }
                Statement::Command { text, line } => self.command(text, context, &at(line))?,
            }
        }
        Ok(())
    }

    /// Counts a primitive. Copies of copies can be far more than a file has bytes.
    fn count(&mut self, primitive: &Primitive, at: &Location) -> Result<()> {
        self.done += 1 + primitive.reals.len() / NUMBERS;
        let most = self.files.most_instances();
        if self.done <= most {
            return Ok(());
        }
        let expected = format!("at most {most} in a scene whose files are as small as these");
        Err(Error::invalid(at.clone(), "one more primitive", expected))
    }

    fn command(&mut self, text: &str, context: &Context, at: &Location) -> Result<()> {
        let command = commands::parse(text, self.files, at)?;
        for file in &command.files {
            let path = self.files.resolve(file, at)?;
            let statements = match self.parsed.get(&path) {
                Some(known) => Arc::clone(known),
                None => {
                    let bytes = self.files.read(file, at)?;
                    let text = text::decoded(&bytes);
                    let text = text::utf8_or_latin1(&text);
                    let parsed = Arc::new(words::parse(&text, &self.files.beside(file))?);
                    self.parsed.insert(path, Arc::clone(&parsed));
                    parsed
                }
            };
            self.copies(&command.changes, (file, &statements), context, at)?;
        }
        Ok(())
    }

    /// Reads the copies of a file that `changes` make, the last of which is applied last.
    fn copies(
        &mut self,
        changes: &[Vec<Change>],
        (file, statements): (&str, &[Statement]),
        context: &Context,
        at: &Location,
    ) -> Result<()> {
        let Some((last, before)) = changes.split_last() else {
            self.includes.enter(file, context.open, at)?;
            let (path, open) = (self.files.beside(file), context.open + 1);
            return self.run(statements, &Context { path, open, ..context.clone() });
        };
        for change in last {
            for copy in 0..change.transforms.copies() {
                let context = context.within(change, copy);
                self.copies(before, (file, statements), &context, at)?;
            }
        }
        Ok(())
    }

    fn surface(&mut self, primitive: &Primitive, context: &Context, at: &Location) -> Result<()> {
        Feature::look_up(FEATURES, [SURFACE, &primitive.kind], at, self.builder.notes_mut())?;
        let modifier = context.modifier.as_ref().unwrap_or(&primitive.modifier);
        let modifier = self.definitions.find(modifier, at)?;
        let name = context.name(&primitive.name);
        if primitive.kind == "source" {
            let chain = modifier.map(|number| self.definitions.chain(number)).transpose()?.flatten();
            let light = match &chain {
                Some(chain) => materials::source(chain, &mut self.builder)?,
                None => None,
            };
            let Some(light) = light else {
                self.builder.note(NoteKind::Ignored, "sources that are no lights: left out", at.clone());
                return Ok(());
            };
            let primitive = (primitive, &context.map, name.as_str());
            return self.sources.add(primitive, light, at, &mut self.builder);
        }
        let geometry = surfaces::geometry(primitive, &context.map, context.inverts, at, &mut self.builder)?;
        // Surfaces of void are invisible.
        let (Some(geometry), Some(modifier)) = (geometry, modifier) else { return Ok(()) };
        if !self.looks.contains_key(&modifier) {
            let chain = self.definitions.chain(modifier)?;
            let look =
                chain.map(|chain| materials::look(&chain, self.files, &mut self.builder)).transpose()?;
            self.looks.insert(modifier, look);
        }
        match &self.looks[&modifier] {
            Some(SurfaceMaterial::Coated(coating)) => {
                self.surfaces.add(&name, geometry, *coating, at, &mut self.builder)
            }
            Some(SurfaceMaterial::Points(radiance, pattern)) => {
                self.points.add(&name, &geometry, (*radiance, pattern), at, &mut self.builder)
            }
            None => {
                self.builder.note(NoteKind::Repaired, "surfaces without a material: invisible", at.clone());
                Ok(())
            }
        }
    }
}
