//! Names that a scene defines: textures, materials, media.
//!
//! In pbrt-v3 a name refers to the last definition before its use. pbrt-v4 makes textures, media
//! and materials after it has read all files, so that a use may precede the definition. Such a
//! scene is read twice. The first reading finds the names that are used before they are defined.
//! The second reading begins with their definitions, and with the definitions that these use.
//!
//! An undefined name is noted where it is used, and refused if it is a slip of a defined name. Held
//! to this by `suite::pbrt_names`.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use glam::DAffine3;

use super::parameters::{Kind, Parameters};
use crate::error::{Error, Location, Result, nearest_name};

/// Number of undefined names that are compared with defined ones; chosen.
const MAX_SLIPS: usize = 100;

/// Largest number of names that an undefined name is compared with; chosen.
const MAX_COMPARED: usize = 10_000;

/// Kind of a named thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Named {
    /// A texture of numbers.
    Float,
    /// A texture of colours.
    Color,
    Material,
    Medium,
    Object,
}

impl Named {
    /// Returns the word for the kind in messages.
    fn word(self) -> &'static str {
        match self {
            Self::Float | Self::Color => "texture",
            Self::Material => "material",
            Self::Medium => "medium",
            Self::Object => "object",
        }
    }
}

/// A definition as the file gives it.
#[derive(Clone, Debug)]
pub(super) struct Definition {
    pub(super) of: Named,
    pub(super) name: String,
    /// Type of a texture; other kinds have their type among their parameters.
    pub(super) class: String,
    pub(super) parameters: Rc<Parameters>,
    /// Transform of a medium.
    pub(super) to_world: Option<DAffine3>,
}

impl Definition {
    fn key(&self) -> (Named, String) {
        (self.of, self.name.clone())
    }

    /// Returns the names that the definition uses.
    fn uses(&self) -> Vec<(Named, String)> {
        let textures = self.parameters.of_kind(Kind::Texture).flat_map(|p| {
            let names = p.strings().iter();
            names.flat_map(|name| [(Named::Float, name.clone()), (Named::Color, name.clone())])
        });
        let parts = self.parameters.of_kind(Kind::String).filter(|p| p.name == "materials");
        let parts = parts.flat_map(|p| p.strings().iter().map(|name| (Named::Material, name.clone())));
        textures.chain(parts).collect()
    }
}

/// Names that were defined or used in a reading.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// First definition of each name that may be used before its definition.
    defined: BTreeMap<(Named, String), Definition>,
    /// Location of the first use of each undefined name.
    undefined: BTreeMap<(Named, String), Location>,
    /// Names whose definition was executed ahead of this reading and has not been met in it yet.
    ahead: BTreeSet<(Named, String)>,
}

impl Names {
    /// Records a use of an undefined name.
    pub(super) fn miss(&mut self, of: Named, name: &str, at: &Location) {
        self.undefined.entry((of, name.to_owned())).or_insert_with(|| at.clone());
    }

    /// Records a definition, in case its name is used before it.
    pub(super) fn keep(&mut self, definition: Definition) {
        self.defined.entry(definition.key()).or_insert(definition);
    }

    /// Returns true if the definition was executed ahead of this reading, the first time that its
    /// name is met.
    pub(super) fn was_ahead(&mut self, definition: &Definition) -> bool {
        self.ahead.remove(&definition.key())
    }

    /// Returns the definitions that a second reading begins with, each after the definitions that
    /// it uses; empty if no name was used before its definition. A name whose definition uses
    /// itself stays undefined.
    pub(super) fn needed_ahead(&self) -> Vec<Definition> {
        let mut ahead = Vec::new();
        let mut begun = BTreeSet::new();
        for wanted in self.undefined.keys() {
            // Names in progress; true if the names that they use are above them on the stack.
            let mut stack = vec![(wanted.clone(), false)];
            while let Some((key, is_expanded)) = stack.pop() {
                let Some(definition) = self.defined.get(&key) else { continue };
                if is_expanded {
                    definition.parameters.forget_uses();
                    ahead.push(definition.clone());
                } else if begun.insert(key.clone()) {
                    stack.push((key, true));
                    stack.extend(definition.uses().into_iter().map(|used| (used, false)));
                }
            }
        }
        ahead
    }

    /// Records the definitions that are executed before the reading.
    pub(super) fn begin_with(&mut self, ahead: &[Definition]) {
        self.ahead = ahead.iter().map(Definition::key).collect();
    }

    /// Refuses an undefined name that is a slip of a defined one. `known` returns the names of a
    /// kind that are defined at the end.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the name that was probably meant.
    pub(super) fn refuse_slips(&self, known: impl Fn(Named) -> Vec<String>) -> Result<()> {
        for ((of, name), at) in self.undefined.iter().take(MAX_SLIPS) {
            let known = known(*of);
            if known.contains(name) {
                continue;
            }
            let candidates = known.iter().take(MAX_COMPARED).map(String::as_str);
            if let Some(near) = nearest_name(name, candidates) {
                return Err(Error::misspelt(at.clone(), of.word(), name, near));
            }
        }
        Ok(())
    }
}
