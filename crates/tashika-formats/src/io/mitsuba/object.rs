//! Objects of a Mitsuba file: plugins with named parameters and nested objects.
//!
//! All objects of a scene and its included files are in one list. A child is a position in it, or
//! an id to be looked up, so that an object may refer to a later one. Each parameter records if it
//! was used. Unused parameters are noted, and so are parameters whose value has the wrong type.
//!
//! Tested by `suite::mitsuba::what_is_not_used_is_noted` and the tests of the formats' parts.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use glam::{DMat4, DVec3};

use super::known;
use super::values::{self, Spectrum};
use crate::color::Rgb;
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::notes::shown;
use crate::math::motion::Track;
use crate::scene::{NoteKind, Notes};

/// Kind of plugin, by its element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Class {
    Integrator,
    Sensor,
    Film,
    Sampler,
    Filter,
    Bsdf,
    /// Also spectra that are objects.
    Texture,
    Emitter,
    Shape,
    /// Also volumes, phase functions and subsurface models.
    Medium,
}

impl Class {
    /// Class of an element, by its current or an older name.
    pub(super) fn of_element(tag: &str) -> Option<Self> {
        Some(match tag {
            "integrator" => Self::Integrator,
            "sensor" | "camera" => Self::Sensor,
            "film" => Self::Film,
            "sampler" => Self::Sampler,
            "rfilter" => Self::Filter,
            "bsdf" => Self::Bsdf,
            "texture" | "spectrum" => Self::Texture,
            "emitter" | "luminaire" => Self::Emitter,
            "shape" => Self::Shape,
            "medium" | "volume" | "phase" | "subsurface" => Self::Medium,
            _ => return None,
        })
    }

    /// Name of the element in messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Integrator => "integrator",
            Self::Sensor => "sensor",
            Self::Film => "film",
            Self::Sampler => "sampler",
            Self::Filter => "rfilter",
            Self::Bsdf => "bsdf",
            Self::Texture => "texture",
            Self::Emitter => "emitter",
            Self::Shape => "shape",
            Self::Medium => "medium",
        }
    }
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Text(String),
    Rgb(Rgb),
    Spectrum(Spectrum),
    /// Temperature (K) and scale.
    Blackbody(f64, f64),
    Vector(DVec3),
    Transform(DMat4),
    /// Keys, and the transform without a time or at the requested time.
    Animation(Track, DMat4),
}

/// A named value of an object.
#[derive(Debug)]
pub(super) struct Parameter {
    /// In snake case.
    pub(super) name: String,
    pub(super) value: Value,
    pub(super) at: Location,
    used: Cell<bool>,
}

impl Parameter {
    pub(super) fn new(name: String, value: Value, at: Location) -> Self {
        Self { name, value, at, used: Cell::new(false) }
    }
}

/// A nested object.
#[derive(Debug)]
pub(super) struct Child {
    /// In snake case; empty if the child has none.
    pub(super) name: String,
    pub(super) target: Target,
    pub(super) at: Location,
    used: Cell<bool>,
}

impl Child {
    pub(super) fn new(name: String, target: Target, at: Location) -> Self {
        Self { name, target, at, used: Cell::new(false) }
    }
}

/// Object that a child refers to.
#[derive(Debug)]
pub(super) enum Target {
    /// Position in the list.
    Object(usize),
    /// Id, which may be defined later.
    Id(String),
}

/// A plugin with its parameters.
#[derive(Debug)]
pub(super) struct Object {
    /// Position in the list.
    pub(super) index: usize,
    pub(super) class: Class,
    /// Type of the object, in lower case.
    pub(super) plugin: String,
    pub(super) id: Option<String>,
    pub(super) at: Location,
    /// Folder of the object's file, relative to the scene's folder; empty if they are the same.
    pub(super) folder: String,
    pub(super) parameters: Vec<Parameter>,
    pub(super) children: Vec<Child>,
    pub(super) accepts_known: Cell<bool>,
    /// Notes about parameters that were moved into their range.
    pub(super) repairs: RefCell<Vec<(String, Location)>>,
}

impl Object {
    /// Id, or else the plugin: for names of meshes and materials.
    pub(super) fn label(&self) -> &str {
        self.id.as_deref().unwrap_or(&self.plugin)
    }

    /// Location with the object's kind and id, for messages.
    pub(super) fn place(&self) -> Location {
        let id = self.id.as_ref().map_or(String::new(), |id| format!(" {:?}", shown(id)));
        self.at.clone().item(format!("{} {}{id}", self.class.name(), shown(&self.plugin)))
    }

    /// Returns the value of a parameter if `take` accepts it, and marks it as used.
    pub(super) fn take<'a, T>(&'a self, name: &str, take: impl FnOnce(&'a Value) -> Option<T>) -> Option<T> {
        // If a name is repeated, its last value counts.
        let parameter = self.parameters.iter().rev().find(|p| p.name == name)?;
        let value = take(&parameter.value)?;
        parameter.used.set(true);
        Some(value)
    }

    /// Returns the line of a parameter, or of the object if it has no parameter of that name.
    pub(super) fn line_of(&self, name: &str) -> &Location {
        self.parameters.iter().rev().find(|p| p.name == name).map_or(&self.at, |p| &p.at)
    }

    /// Location of a parameter, or of the object if it has no parameter of that name.
    pub(super) fn place_of(&self, name: &str) -> Location {
        let parameter = self.parameters.iter().rev().find(|p| p.name == name);
        parameter
            .map_or_else(|| self.place(), |p| p.at.clone().item(format!("{} {name:?}", self.class.name())))
    }

    pub(super) fn float(&self, name: &str) -> Option<f64> {
        self.take(name, as_float)
    }

    /// Reads a number; a number outside of the range is moved into it, with a note.
    pub(super) fn float_in(&self, name: &str, range: std::ops::RangeInclusive<f64>) -> Option<f64> {
        let value = self.float(name)?;
        let moved = value.clamp(*range.start(), *range.end());
        if moved != value {
            let (class, plugin) = (self.class.name(), shown(&self.plugin));
            self.repaired(name, format!("{class} {plugin:?}: {name} = {value} is out of range: {moved}"));
        }
        Some(moved)
    }

    /// Records a note about a parameter until [`note_unused`](Self::note_unused) is called.
    pub(super) fn repaired(&self, name: &str, message: String) {
        let repair = (message, self.line_of(name).clone());
        let mut repairs = self.repairs.borrow_mut();
        if !repairs.contains(&repair) {
            repairs.push(repair);
        }
    }

    pub(super) fn integer(&self, name: &str) -> Option<i64> {
        self.take(name, |v| match v {
            Value::Integer(i) => Some(*i),
            Value::Float(f) if f.fract() == 0.0 && f.abs() < 1e15 => Some(*f as i64),
            Value::Text(text) => values::integer(text),
            _ => None,
        })
    }

    pub(super) fn boolean(&self, name: &str) -> Option<bool> {
        self.take(name, |v| match v {
            Value::Boolean(b) => Some(*b),
            Value::Text(text) => values::boolean(text),
            _ => None,
        })
    }

    pub(super) fn text(&self, name: &str) -> Option<&str> {
        self.take(name, |v| match v {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        })
    }

    pub(super) fn vector(&self, name: &str) -> Option<DVec3> {
        self.take(name, |v| match v {
            Value::Vector(v) => Some(*v),
            Value::Text(text) => values::vector(text),
            _ => None,
        })
    }

    pub(super) fn transform(&self, name: &str) -> Option<DMat4> {
        self.take(name, |v| match v {
            Value::Transform(m) | Value::Animation(_, m) => Some(*m),
            _ => None,
        })
    }

    /// Keys of a transform that moves, and their location.
    pub(super) fn track(&self, name: &str) -> Option<(&Track, &Location)> {
        let parameter = self.parameters.iter().rev().find(|p| p.name == name)?;
        match &parameter.value {
            Value::Animation(track, _) => Some((track, &parameter.at)),
            _ => None,
        }
    }

    /// Marks parameters that have no effect here as used.
    pub(super) fn accept(&self, names: &[&str]) {
        for parameter in self.parameters.iter().filter(|p| names.contains(&p.name.as_str())) {
            parameter.used.set(true);
        }
    }

    /// Marks the nested objects and all known parameters of an ignored object as used, because they
    /// have no effect.
    pub(super) fn accept_known(&self) {
        self.accepts_known.set(true);
        self.children.iter().for_each(|c| c.used.set(true));
    }

    /// Marks everything as used: the contents of an unknown object need no notes of their own.
    pub(super) fn accept_all(&self) {
        self.parameters.iter().for_each(|p| p.used.set(true));
        self.children.iter().for_each(|c| c.used.set(true));
    }

    /// Notes unused parameters, and parameters that were moved into their range.
    ///
    /// # Errors
    /// If an unused name is a slip of a parameter of the plugin.
    pub(super) fn note_unused(&self, notes: &mut Notes) -> Result<()> {
        for (message, at) in self.repairs.take() {
            notes.push(NoteKind::Repaired, message, at);
        }
        let (class, plugin) = (self.class.name(), shown(&self.plugin));
        for parameter in self.parameters.iter().filter(|p| !p.used.get()) {
            if self.accepts_known.get() && known::has(self.class, &self.plugin, &parameter.name) {
                continue;
            }
            self.refuse_slip("parameter", &parameter.name, &parameter.at)?;
            let name = shown(&parameter.name);
            let message = format!("{class} {plugin:?}: parameter {name:?} is not used");
            notes.push(NoteKind::Ignored, message, parameter.at.clone());
        }
        for child in self.children.iter().filter(|c| !c.used.get()) {
            self.refuse_slip("nested object", &child.name, &child.at)?;
            let name =
                if child.name.is_empty() { String::new() } else { format!(" {:?}", shown(&child.name)) };
            let message = format!("{class} {plugin:?}: nested object{name} is not used");
            notes.push(NoteKind::Ignored, message, child.at.clone());
        }
        Ok(())
    }

    fn refuse_slip(&self, what: &str, name: &str, at: &Location) -> Result<()> {
        let near = if known::is_name(name) {
            None
        } else {
            nearest_name(name, known::names(self.class, &self.plugin))
        };
        let Some(near) = near else { return Ok(()) };
        let what = format!("{} {:?}: {what}", self.class.name(), shown(&self.plugin));
        Err(Error::misspelt(at.clone(), &what, &shown(name), near))
    }
}

fn as_float(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(i) => Some(*i as f64),
        Value::Float(f) | Value::Spectrum(Spectrum::Constant(f) | Spectrum::Uniform(f)) => Some(*f),
        Value::Text(text) => values::number(text),
        Value::Rgb(c) if c.r == c.g && c.g == c.b => Some(f64::from(c.r)),
        _ => None,
    }
}

/// Contents of the scene file and its included files.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub(super) objects: Vec<Object>,
    /// Positions of objects by their ids.
    pub(super) ids: BTreeMap<String, usize>,
    /// Children of the scene, in the order of the file.
    pub(super) roots: Vec<usize>,
    /// Folders of `<path>`, relative to the scene's folder.
    pub(super) paths: Vec<String>,
    /// First two numbers of the version.
    pub(super) version: (u32, u32),
    /// Beginning and end of each animation (s).
    pub(super) animated: Vec<[f64; 2]>,
    /// Locations of animations. Those that blur nothing are noted as loaded at a single time.
    pub(super) stopped: Vec<Location>,
}

impl Document {
    /// Returns true for a file of Mitsuba 0.x.
    pub(super) fn is_old(&self) -> bool {
        self.version.0 == 0
    }

    /// Object that a child refers to; `None` if no object has that id.
    pub(super) fn resolve(&self, child: &Child) -> Option<&Object> {
        match &child.target {
            Target::Object(index) => Some(&self.objects[*index]),
            Target::Id(id) => self.ids.get(id).map(|&index| &self.objects[index]),
        }
    }

    /// Children of a class with their names; they are marked as used.
    pub(super) fn children<'s, 'o>(
        &'s self,
        object: &'o Object,
        class: Class,
    ) -> impl Iterator<Item = (&'o str, &'s Object)> + use<'s, 'o> {
        object.children.iter().filter_map(move |child| {
            let target = self.resolve(child).filter(|o| o.class == class)?;
            child.used.set(true);
            Some((child.name.as_str(), target))
        })
    }

    /// Nested texture of the given name.
    pub(super) fn texture<'s>(&'s self, object: &Object, name: &str) -> Option<&'s Object> {
        let named = object.children.iter().filter(|c| c.name == name);
        let (child, target) =
            named.filter_map(|c| Some((c, self.resolve(c)?))).find(|(_, o)| o.class == Class::Texture)?;
        child.used.set(true);
        Some(target)
    }

    /// First texture, of any name.
    pub(super) fn any_texture<'s>(&'s self, object: &Object) -> Option<&'s Object> {
        self.children(object, Class::Texture).next().map(|(_, o)| o)
    }
}
