//! Names that a scene defines: textures, materials, media.
//!
//! In pbrt-v3 a name stands for what was defined last before it is used. pbrt-v4 makes textures,
//! media and materials after it has read all files, so that a name may be used before it is
//! defined. Such a scene is read twice: the first time tells which names are used too early, the
//! second time begins with their definitions and with what these use.
//!
//! A name that is defined nowhere is noted where it is used, and refused if it is a slip of one
//! that is. Held to this by `suite::pbrt_names`.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use glam::DAffine3;

use super::parameters::{Kind, Parameters};
use crate::error::{Error, Location, Result, nearest_name};

/// After so many different names that are defined nowhere, slips are not looked for; chosen.
const MAX_SLIPS: usize = 100;

/// A slip is looked for among so many names at most; chosen.
const MAX_COMPARED: usize = 10_000;

/// Kind of thing that a name is of.
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
    /// The word for it in messages.
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
    /// Type of a texture; others have it among their parameters.
    pub(super) class: String,
    pub(super) parameters: Rc<Parameters>,
    /// Of a medium.
    pub(super) to_world: Option<DAffine3>,
}

impl Definition {
    fn key(&self) -> (Named, String) {
        (self.of, self.name.clone())
    }

    /// The names that it uses.
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

/// The names that a reading has met.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// The first definition of each, where a name may be used before it.
    defined: BTreeMap<(Named, String), Definition>,
    /// Used while not defined, and where first.
    undefined: BTreeMap<(Named, String), Location>,
    /// Defined before the reading, and not met since.
    ahead: BTreeSet<(Named, String)>,
}

impl Names {
    /// A name is used that is not defined.
    pub(super) fn miss(&mut self, of: Named, name: &str, at: &Location) {
        self.undefined.entry((of, name.to_owned())).or_insert_with(|| at.clone());
    }

    /// Keeps a definition for names that are used before it.
    pub(super) fn keep(&mut self, definition: Definition) {
        self.defined.entry(definition.key()).or_insert(definition);
    }

    /// True, once, for a definition that was carried out before the reading.
    pub(super) fn was_ahead(&mut self, definition: &Definition) -> bool {
        self.ahead.remove(&definition.key())
    }

    /// The definitions that a second reading has to begin with, each after those that it uses;
    /// empty if no name was used before its definition. Names that use themselves stay undefined.
    pub(super) fn needed_ahead(&self) -> Vec<Definition> {
        let mut ahead = Vec::new();
        let mut begun = BTreeSet::new();
        for wanted in self.undefined.keys() {
            // Those that are begun, with whether what they use stands above them.
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

    /// Definitions that are carried out before the reading.
    pub(super) fn begin_with(&mut self, ahead: &[Definition]) {
        self.ahead = ahead.iter().map(Definition::key).collect();
    }

    /// Refuses a name that is defined nowhere and is a slip of one that is; `known` has the names of
    /// a kind that are defined at the end.
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
