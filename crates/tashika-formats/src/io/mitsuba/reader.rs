//! Conversion of XML to a [`Document`]: defaults, includes, aliases, references, parameters.
//!
//! # Guarantee
//! * Elements nest at most [`MAX_NESTING`] deep, files include each other at most
//!   [`MAX_INCLUDE_DEPTH`] deep and [`MAX_INCLUDES`] times in all: the depth of the stack and the
//!   work are bounded.
//! * Document types are refused, so that entities cannot multiply. Attributes with replaced
//!   `$name`s have at most [`MAX_REPLACED`] bytes in all.
//! * Every error has the file, line and column of its element.
//!
//! # Limits
//! An `<animation>` is read as its first key or, if a time is requested, as the transform that
//! [`Track`](crate::math::motion::Track) interpolates at that time. Its keys are stored for cameras
//! and shapes with motion blur.
//!
//! Sources: [^mitsuba06], chapter 6 (scene file format); [^mitsuba3].
//! Held to this by `suite::mitsuba`, `suite::damaged_mitsuba`.

use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use roxmltree::Node;

use super::object::{Child, Class, Document, Object, Parameter, Target, Value};
use super::paths;
use super::text::{MAX_ATTRIBUTE, Unreplaced, substitute};
use super::values::{self, Spectrum};
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::SceneFiles;
use crate::io::files::folder_of;
use crate::io::limits::{Budget, Includes};
use crate::io::notes::shown;
use crate::io::text::{decoded, utf8_or_latin1};
use crate::io::xml;
use crate::scene::{NoteKind, Notes};

/// Deepest nesting of elements.
pub(super) const MAX_NESTING: usize = 64;
/// Deepest nesting of files, including the scene file.
const MAX_INCLUDE_DEPTH: usize = 17;
/// Most included files in all; a file that is included twice counts twice.
const MAX_INCLUDES: usize = 4096;
/// Most bytes of all attributes with replaced names; chosen.
const MAX_REPLACED: u64 = 1 << 26;
/// Elements other than the root and the steps of transforms, for the detection of slips.
const ELEMENTS: [&str; 32] = [
    "alias",
    "animation",
    "blackbody",
    "boolean",
    "bsdf",
    "camera",
    "default",
    "emitter",
    "film",
    "float",
    "include",
    "integer",
    "integrator",
    "luminaire",
    "medium",
    "path",
    "phase",
    "point",
    "ref",
    "rfilter",
    "rgb",
    "sampler",
    "sensor",
    "shape",
    "spectrum",
    "srgb",
    "string",
    "subsurface",
    "texture",
    "transform",
    "vector",
    "volume",
];

/// Most folders that are searched for files.
const MAX_PATHS: usize = 64;

/// Reads the scene file and all included files.
pub(super) fn read(files: &SceneFiles, notes: &mut Notes) -> Result<Document> {
    let includes = Includes::new(MAX_INCLUDES, MAX_INCLUDE_DEPTH);
    let mut reader = Reader {
        files,
        notes,
        document: Document::default(),
        defaults: BTreeMap::new(),
        replaced: Budget::new(MAX_REPLACED, "attributes with replaced names"),
        includes,
    };
    let bytes = files.read_scene()?;
    let roots = reader.file(&bytes, files.path(), "", 1)?;
    reader.document.roots = roots;
    Ok(reader.document)
}

/// State of the reading of a scene's files.
pub(super) struct Reader<'a> {
    pub(super) files: &'a SceneFiles,
    pub(super) notes: &'a mut Notes,
    pub(super) document: Document,
    defaults: BTreeMap<String, String>,
    replaced: Budget,
    includes: Includes,
}

/// One file while it is read.
pub(super) struct Source<'a> {
    path: &'a Path,
    /// Folder of the file, relative to the scene's folder.
    folder: &'a str,
    text: &'a str,
    /// Byte at which each line begins.
    lines: Vec<usize>,
    /// Last byte that was located, and the number of characters before it in its line.
    last: Cell<(usize, usize)>,
    /// Number of files that are being read, including this one.
    open: usize,
}

impl Source<'_> {
    /// Location of a byte.
    pub(super) fn at(&self, position: usize) -> Location {
        let line = self.lines.partition_point(|&start| start <= position).max(1);
        let start = self.lines.get(line - 1).copied().unwrap_or(0);
        // Locations are requested in the order of the file. Counting from the last one keeps a file
        // of one long line linear.
        let (known, columns) = self.last.get();
        let (from, before) = if (start..=position).contains(&known) { (known, columns) } else { (start, 0) };
        let columns = before + self.text.get(from..position).map_or(0, |part| part.chars().count());
        self.last.set((position, columns));
        Location::line(self.path, line as u32).column(columns as u32 + 1)
    }
}

/// Meaning of an element for its parent.
enum Item {
    Parameter(Parameter),
    Child(Child),
    Children(Vec<usize>),
    Nothing,
}

impl Reader<'_> {
    /// Reads one file; returns its objects.
    fn file(&mut self, bytes: &[u8], path: &Path, folder: &str, open: usize) -> Result<Vec<usize>> {
        let bytes = decoded(bytes);
        let text = utf8_or_latin1(&bytes);
        let lines =
            std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect::<Vec<_>>();
        let xml = xml::parse(&text, path)?;
        let source = Source { path, folder, text: &text, lines, last: Cell::new((0, 0)), open };
        let root = xml.root_element();
        let at = source.at(root.range().start);
        let tag = root.tag_name().name();
        if tag != "scene" {
            let found = format!("the root element <{}>: this is not a Mitsuba scene", shown(tag));
            return Err(Error::invalid(at, found, "<scene version=\"…\">"));
        }
        if open == 1 {
            self.version(root, &at)?;
        }
        let mut roots = Vec::new();
        for element in root.children().filter(Node::is_element) {
            match self.element(element, &source, 1)? {
                Item::Child(child) => roots.extend(self.document.resolve(&child).map(|o| o.index)),
                Item::Children(children) => roots.extend(children),
                Item::Parameter(_) | Item::Nothing => {}
            }
        }
        Ok(roots)
    }

    fn version(&mut self, root: Node<'_, '_>, at: &Location) -> Result<()> {
        let Some(text) = root.attribute("version") else {
            let message = "the scene has no version: read as Mitsuba 3";
            self.notes.push(NoteKind::Repaired, message, at.clone());
            self.document.version = (3, 0);
            return Ok(());
        };
        let mut parts = text.trim().split('.').map(str::parse::<u32>);
        let (Some(Ok(major)), minor) = (parts.next(), parts.next().unwrap_or(Ok(0)).unwrap_or(0)) else {
            let found = format!("version {:?}", shown(text));
            return Err(Error::invalid(at.clone(), found, "a version such as \"3.0.0\""));
        };
        if (major, minor) < (0, 4) || major > 3 {
            let message =
                format!("version {major}.{minor}: read as {}", if major == 0 { "0.6" } else { "3" });
            self.notes.push(NoteKind::Approximated, message, at.clone());
        }
        self.document.version = (major, minor);
        Ok(())
    }

    fn element(&mut self, node: Node<'_, '_>, source: &Source<'_>, depth: usize) -> Result<Item> {
        let at = source.at(node.range().start);
        if depth > MAX_NESTING {
            let found = format!("elements more than {MAX_NESTING} deep in each other");
            return Err(Error::invalid(at, found, "a flatter file"));
        }
        let tag = node.tag_name().name();
        // Elements that are neither parameters nor objects.
        match tag {
            "default" => return self.default(node, &at),
            "include" => return self.include(node, source, &at),
            "path" => return self.path(node, source, &at),
            "alias" => return self.alias(node, &at),
            "ref" => return self.reference(node, at),
            _ => {}
        }
        let is_value = tag == "spectrum" && node.attribute("type").is_none();
        if let Some(class) = Class::of_element(tag).filter(|_| !is_value) {
            return self.object(node, class, source, depth, at);
        }
        let Some(value) = self.value(node, tag, source, depth, &at)? else { return Ok(Item::Nothing) };
        let Some(name) = self.attribute(node, "name", &at)? else {
            let found = format!("<{tag}> without a name");
            return Err(Error::invalid(at, found, "the attribute name"));
        };
        Ok(Item::Parameter(Parameter::new(values::snake_case(&name), value, at)))
    }

    fn object(
        &mut self,
        node: Node<'_, '_>,
        class: Class,
        source: &Source<'_>,
        depth: usize,
        at: Location,
    ) -> Result<Item> {
        let plugin = self.attribute(node, "type", &at)?.unwrap_or_default();
        let id = self.attribute(node, "id", &at)?.filter(|id| !id.is_empty());
        let name = self.attribute(node, "name", &at)?.unwrap_or_default();
        let (mut parameters, mut children) = (Vec::new(), Vec::new());
        for element in node.children().filter(Node::is_element) {
            match self.element(element, source, depth + 1)? {
                Item::Parameter(p) => parameters.push(p),
                Item::Child(c) => children.push(c),
                Item::Children(included) => {
                    children.extend(
                        included
                            .into_iter()
                            .map(|i| Child::new(String::new(), Target::Object(i), at.clone())),
                    );
                }
                Item::Nothing => {}
            }
        }
        let index = self.document.objects.len();
        let plugin = plugin.trim().to_ascii_lowercase();
        let folder = source.folder.to_owned();
        if let Some(id) = &id {
            self.name(id.clone(), index, &at);
        }
        self.document.objects.push(Object {
            index,
            class,
            plugin,
            id,
            at: at.clone(),
            folder,
            parameters,
            children,
            accepts_known: Cell::new(false),
            repairs: RefCell::default(),
        });
        Ok(Item::Child(Child::new(values::snake_case(&name), Target::Object(index), at)))
    }

    /// Gives an object an id. An id that is already in use stays with its first object.
    fn name(&mut self, id: String, index: usize, at: &Location) {
        match self.document.ids.entry(id) {
            Entry::Vacant(free) => {
                free.insert(index);
            }
            Entry::Occupied(taken) => {
                let message =
                    format!("the id {:?} is given twice: the first object keeps it", shown(taken.key()));
                self.notes.push(NoteKind::Repaired, message, at.clone());
            }
        }
    }

    fn default(&mut self, node: Node<'_, '_>, at: &Location) -> Result<Item> {
        let name = self.required(node, "name", at)?;
        let value = self.required(node, "value", at)?;
        // An existing default was set by a file that includes this one, and takes precedence.
        self.defaults.entry(name).or_insert(value);
        Ok(Item::Nothing)
    }

    fn include(&mut self, node: Node<'_, '_>, source: &Source<'_>, at: &Location) -> Result<Item> {
        let reference = self.required(node, "filename", at)?;
        self.includes.enter(&reference, source.open, at)?;
        let candidates = paths::candidates(&reference, [source.folder, ""]);
        let (bytes, found) = paths::read_first(self.files, &candidates, at)?;
        self.includes.count(&found, bytes.len() as u64, at)?;
        let folder = folder_of(&found).to_owned();
        let path = self.files.beside(&found);
        Ok(Item::Children(self.file(&bytes, &path, &folder, source.open + 1)?))
    }

    fn path(&mut self, node: Node<'_, '_>, source: &Source<'_>, at: &Location) -> Result<Item> {
        let folder = self.required(node, "value", at)?;
        if self.document.paths.len() < MAX_PATHS {
            self.document.paths.push(paths::join(source.folder, &folder));
        } else {
            let message = format!("more than {MAX_PATHS} paths: left out");
            self.notes.push(NoteKind::Ignored, message, at.clone());
        }
        Ok(Item::Nothing)
    }

    fn alias(&mut self, node: Node<'_, '_>, at: &Location) -> Result<Item> {
        let (id, new) = (self.required(node, "id", at)?, self.required(node, "as", at)?);
        if let Some(&index) = self.document.ids.get(&id) {
            self.name(new, index, at);
        } else {
            let message = format!("alias of {:?}, which is not defined before: left out", shown(&id));
            self.notes.push(NoteKind::Repaired, message, at.clone());
        }
        Ok(Item::Nothing)
    }

    fn reference(&mut self, node: Node<'_, '_>, at: Location) -> Result<Item> {
        let id = self.required(node, "id", &at)?;
        let name = self.attribute(node, "name", &at)?.unwrap_or_default();
        Ok(Item::Child(Child::new(values::snake_case(&name), Target::Id(id), at)))
    }

    /// Value of a parameter; `None`, with a note, if the element is unknown or uses a `$name`
    /// without a default.
    fn value(
        &mut self,
        node: Node<'_, '_>,
        tag: &str,
        source: &Source<'_>,
        depth: usize,
        at: &Location,
    ) -> Result<Option<Value>> {
        let lower = tag.to_ascii_lowercase();
        match lower.as_str() {
            "transform" => return Ok(Some(Value::Transform(self.transform(node, source, depth, at)?))),
            "animation" => return self.animation(node, source, depth, at),
            "blackbody" => {
                let temperature = self.number(node, "temperature", at)?.or(self.number(node, "value", at)?);
                let Some(temperature) = temperature else { return Ok(None) };
                return Ok(Some(Value::Blackbody(
                    temperature,
                    self.number(node, "scale", at)?.unwrap_or(1.0),
                )));
            }
            "point" | "vector" if node.attribute("value").is_none() => {
                let [x, y, z] = self.coordinates(node, 0.0, at)?;
                return Ok(Some(Value::Vector(glam::DVec3::new(x, y, z))));
            }
            "integer" | "float" | "boolean" | "string" | "rgb" | "srgb" | "spectrum" | "point" | "vector" => {
            }
            _ => {
                if let Some(near) = nearest_name(tag, ELEMENTS) {
                    return Err(Error::misspelt(at.clone(), "element", &shown(tag), near));
                }
                let message = format!("element <{}> is unknown: left out", shown(tag));
                self.notes.push(NoteKind::Ignored, message, at.clone());
                return Ok(None);
            }
        }
        if lower == "spectrum"
            && let Some(reference) = self.attribute(node, "filename", at)?
        {
            return self.spectrum_file(&reference, source, at).map(Some);
        }
        let Some(text) = self.attribute(node, "value", at)? else {
            if node.attribute("value").is_some() {
                return Ok(None);
            }
            return Err(Error::invalid(
                at.clone(),
                format!("<{tag}> without a value"),
                "the attribute value",
            ));
        };
        let (value, expected) = match lower.as_str() {
            "integer" => (values::integer(&text).map(Value::Integer), "a whole number"),
            "float" => (values::number(&text).map(Value::Float), "a finite number"),
            "boolean" => (values::boolean(&text).map(Value::Boolean), "true or false"),
            "string" => (Some(Value::Text(text.clone())), ""),
            "rgb" => (values::rgb(&text).map(Value::Rgb), "one or three finite numbers, or #rrggbb"),
            "srgb" => (values::srgb(&text).map(Value::Rgb), "one or three finite numbers, or #rrggbb"),
            "spectrum" if text.to_ascii_lowercase().ends_with(".spd") => {
                return self.spectrum_file(&text, source, at).map(Some);
            }
            "spectrum" => (
                values::spectrum(&text).map(|s| match s {
                    // In Mitsuba 3 a number is equal energy, in earlier versions white.
                    Ok(Spectrum::Constant(value)) if self.document.version.0 >= 3 => {
                        Value::Spectrum(Spectrum::Uniform(value))
                    }
                    other => other.map_or_else(Value::Rgb, Value::Spectrum),
                }),
                "a finite number, \"wavelength:value, …\", or the name of a .spd file",
            ),
            _ => (values::vector(&text).map(Value::Vector), "three finite numbers"),
        };
        let invalid = || Error::invalid(at.clone(), format!("<{tag}> of value {:?}", shown(&text)), expected);
        value.map(Some).ok_or_else(invalid)
    }

    fn spectrum_file(&mut self, reference: &str, source: &Source<'_>, at: &Location) -> Result<Value> {
        let candidates = paths::candidates(reference, [source.folder, ""]);
        let (bytes, name) = paths::read_first(self.files, &candidates, at)?;
        values::spectrum_file(&bytes).map(Value::Spectrum).ok_or_else(|| {
            let found = format!("the spectrum {:?}", shown(&name));
            Error::invalid(at.clone(), found, "lines of a wavelength (nm) and a value")
        })
    }

    fn required(&mut self, node: Node<'_, '_>, name: &str, at: &Location) -> Result<String> {
        self.attribute(node, name, at)?.ok_or_else(|| {
            let found = format!("<{}> without {name}", shown(node.tag_name().name()));
            Error::invalid(at.clone(), found, format!("the attribute {name}"))
        })
    }

    /// The text of an attribute with `$name` and `${name}` replaced; `None`, with a note, if one
    /// has no default.
    pub(super) fn attribute(
        &mut self,
        node: Node<'_, '_>,
        name: &str,
        at: &Location,
    ) -> Result<Option<String>> {
        let Some(text) = node.attribute(name) else { return Ok(None) };
        match substitute(text, &self.defaults) {
            Ok(Cow::Borrowed(text)) => Ok(Some(text.to_owned())),
            Ok(Cow::Owned(text)) => {
                self.replaced.take(text.len() as u64, at)?;
                Ok(Some(text))
            }
            Err(Unreplaced::TooLong(default)) => {
                let (tag, default) = (shown(node.tag_name().name()), shown(&default));
                let found = format!(
                    "the attribute {name} of <{tag}>, more than {MAX_ATTRIBUTE} bytes long where ${default} is replaced"
                );
                Err(Error::invalid(at.clone(), found, "a shorter text: does one default double another?"))
            }
            Err(Unreplaced::Missing(missing)) => {
                let missing = shown(&missing);
                let message = format!("${missing} has no default: what would be set by it keeps its own");
                self.notes.push(NoteKind::Repaired, message, at.clone());
                Ok(None)
            }
        }
    }
}
