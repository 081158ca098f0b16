//! Materials and modifiers by their names.
//!
//! A name stands for the last primitive of that name before it. The modifier of a surface is the
//! first of a chain, `surface → pattern → material → texture → void`: the first material in it is
//! that of the surface, and all patterns and textures in it apply.
//!
//! Held to this by `radiance::tests`.

use std::collections::BTreeMap;

use super::features::{FEATURES, MATERIAL, MODIFIER, SURFACE};
use super::transforms::Similarity;
use super::words::Primitive;
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::features::Feature;
use crate::io::notes::quoted;

/// Name of no modifier.
const VOID: &str = "void";

/// Modifier of an alias that keeps the modifiers of the definition it stands for.
const INHERIT: &str = "inherit";

/// Types whose arguments have directions or lengths. Others are the same in every copy of a file.
const PLACED: &[&str] = &["spotlight", "dielectric", "interface", "brightdata", "brightfunc"];

/// Most modifiers of a surface.
const MAX_CHAIN: usize = 64;

/// Largest number of names that an undefined name is compared with; chosen.
const MAX_COMPARED: usize = 10_000;

/// A material, pattern, texture or mixture.
#[derive(Clone, Debug)]
pub(super) struct Definition {
    pub(super) primitive: Primitive,
    /// Its own modifier, as a number in [`Definitions`].
    below: Option<usize>,
    /// Map from the coordinates of its file to the world.
    pub(super) map: Similarity,
    pub(super) at: Location,
}

/// The material of a surface, with the patterns and textures that change it.
#[derive(Clone, Debug)]
pub(super) struct Chain<'d> {
    pub(super) material: &'d Definition,
    pub(super) modifiers: Vec<&'d Definition>,
}

/// Materials and modifiers that were read, in the order of the files.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    all: Vec<Definition>,
    names: BTreeMap<String, usize>,
}

/// Returns true if a primitive of this type is a surface; `None` if there is no such type.
pub(super) fn is_surface(kind: &str) -> Option<bool> {
    let has = |row: &str| Feature::find(FEATURES, row, kind).is_some();
    if has(SURFACE) { Some(true) } else { (has(MATERIAL) || has(MODIFIER)).then_some(false) }
}

/// Checks that a type exists.
///
/// # Errors
/// [`Error::Invalid`] with the type that was probably meant.
pub(super) fn check_type(kind: &str, name: &str, at: Location) -> Result<()> {
    if is_surface(kind).is_some() {
        return Ok(());
    }
    let kinds = [SURFACE, MATERIAL, MODIFIER];
    let known = FEATURES.iter().filter(|row| kinds.contains(&row.kind) && !row.name.contains(' '));
    Err(match nearest_name(kind, known.map(|row| row.name)) {
        Some(near) => Error::misspelt(at, "type", kind, near),
        None => {
            let found = format!("type {} of {}", quoted(kind), quoted(name));
            let expected =
                "a type of the reference manual; has the primitive before it more arguments than it counts?";
            Error::invalid(at, found, expected)
        }
    })
}

impl Definitions {
    /// Adds a definition. One that equals the last of its name changes nothing.
    ///
    /// # Errors
    /// [`Error::Invalid`] if its modifier is not defined.
    pub(super) fn define(&mut self, primitive: &Primitive, map: &Similarity, at: &Location) -> Result<()> {
        let below = self.find(&primitive.modifier, at)?;
        let map = if PLACED.contains(&primitive.kind.as_str()) { map } else { &Similarity::IDENTITY };
        self.insert(Definition { primitive: primitive.clone(), below, map: *map, at: at.clone() });
        Ok(())
    }

    /// Adds another name of a definition, with the modifier `modifier` in place of its own, unless
    /// that is `inherit`.
    ///
    /// # Errors
    /// As [`Self::find`].
    pub(super) fn alias(&mut self, [modifier, name, reference]: [&str; 3], at: &Location) -> Result<()> {
        let of = self.find(reference, at)?;
        let Some(number) = of else {
            self.names.remove(name);
            return Ok(());
        };
        let below = if modifier == INHERIT { self.all[number].below } else { self.find(modifier, at)? };
        if below == self.all[number].below {
            self.names.insert(name.to_owned(), number);
        } else {
            let of = &self.all[number];
            let primitive = Primitive { name: name.to_owned(), ..of.primitive.clone() };
            self.insert(Definition { primitive, below, map: of.map, at: of.at.clone() });
        }
        Ok(())
    }

    /// Adds a definition, unless it equals the last of its name.
    fn insert(&mut self, new: Definition) {
        let name = &new.primitive.name;
        let is_known = self.names.get(name).map(|k| &self.all[*k]).is_some_and(|known| {
            let (a, b) = (&known.primitive, &new.primitive);
            let same = a.kind == b.kind && a.strings == b.strings && a.reals == b.reals;
            same && known.below == new.below && known.map == new.map
        });
        if !is_known {
            self.names.insert(name.clone(), self.all.len());
            self.all.push(new);
        }
    }

    /// Number of the definition of a name; none for `void`.
    ///
    /// # Errors
    /// [`Error::Invalid`] if there is none.
    pub(super) fn find(&self, name: &str, at: &Location) -> Result<Option<usize>> {
        if name == VOID {
            return Ok(None);
        }
        if let Some(number) = self.names.get(name) {
            return Ok(Some(*number));
        }
        let known = self.names.keys().take(MAX_COMPARED).map(String::as_str);
        Err(match nearest_name(name, known) {
            Some(near) => Error::misspelt(at.clone(), "modifier", name, near),
            None => {
                let expected = "a name that a primitive before it defines, or void";
                Error::invalid(at.clone(), format!("modifier {}", quoted(name)), expected)
            }
        })
    }

    /// The newest definition.
    #[cfg(test)]
    pub(super) fn last(&self) -> &Definition {
        self.all.last().expect("a definition")
    }

    /// The material that a surface with the modifier `number` has; none if the chain has none.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a chain that is too long.
    pub(super) fn chain(&self, number: usize) -> Result<Option<Chain<'_>>> {
        let (mut material, mut modifiers) = (None, Vec::new());
        let mut next = Some(number);
        while let Some(definition) = next.map(|k| &self.all[k]) {
            if Feature::find(FEATURES, MATERIAL, &definition.primitive.kind).is_some() {
                if material.is_some() {
                    break;
                }
                material = Some(definition);
            } else {
                modifiers.push(definition);
            }
            if modifiers.len() > MAX_CHAIN {
                let found = format!("more than {MAX_CHAIN} patterns and textures of one material");
                return Err(Error::invalid(definition.at.clone(), found, format!("at most {MAX_CHAIN}")));
            }
            next = definition.below;
        }
        Ok(material.map(|material| Chain { material, modifiers }))
    }
}
