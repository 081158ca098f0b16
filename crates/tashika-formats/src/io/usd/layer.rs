//! A layer: the opinions of one file about prims, before composition with other layers.
//!
//! All encodings are read into layers. Values of a binary file are decoded when they are needed
//! ([`Stored`]).

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::binary::{Binary, Rep};
use super::value::{ListOp, Reference, Text, Value};
use crate::error::{Error, Location, Result};
use crate::io::notes::excerpt;

/// Largest number of characters of a path in messages; chosen.
const LONGEST_PATH: usize = 500;

/// Contents of a file.
#[derive(Debug)]
pub(super) struct Layer {
    /// File name that messages give.
    pub name: PathBuf,
    /// All prims and variants. The first stands for the file: its children are the top-level prims.
    pub prims: Vec<PrimSpec>,
    pub metadata: Metadata,
    /// The bytes of a binary file.
    pub binary: Option<Binary>,
}

/// Fields of a file itself, apart from its prims.
#[derive(Debug, Default)]
pub(super) struct Metadata {
    pub default_prim: Option<Text>,
    pub sublayers: Vec<Text>,
    /// True if the times of a sublayer are shifted or scaled.
    pub has_offsets: bool,
    /// True if the layer renames prims of other layers.
    pub has_relocates: bool,
    pub meters_per_unit: Option<f64>,
    pub up_axis: Option<Text>,
    pub time_codes_per_second: Option<f64>,
    pub frames_per_second: Option<f64>,
}

/// Kind of a spec: a definition, opinions about a prim that is defined elsewhere, or a class.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Specifier {
    Def,
    #[default]
    Over,
    Class,
}

/// Opinions of a file about a prim.
#[derive(Debug, Default)]
pub(super) struct PrimSpec {
    /// Line in a text file.
    pub line: Option<u32>,
    pub specifier: Specifier,
    pub type_name: Option<Text>,
    pub active: Option<bool>,
    pub instanceable: Option<bool>,
    pub schemas: ListOp<Text>,
    pub references: ListOp<Reference>,
    pub payloads: ListOp<Reference>,
    pub inherits: ListOp<Text>,
    pub specializes: ListOp<Text>,
    pub selections: Vec<(Text, Text)>,
    /// Inactive instances of a point instancer.
    pub inactive_ids: ListOp<i64>,
    /// True if values come from a series of other files.
    pub has_clips: bool,
    pub properties: BTreeMap<Text, Property>,
    /// Names and indices of the prims below it, in order.
    pub children: Vec<(Text, u32)>,
    /// Indices of the prims below it, by name.
    pub by_name: BTreeMap<Text, u32>,
    /// Indices of the variants by set and name. The opinions of each variant are stored as a
    /// separate prim.
    pub variants: BTreeMap<Text, BTreeMap<Text, u32>>,
}

/// Opinions of a file about an attribute or a relationship.
#[derive(Debug, Default)]
pub(super) struct Property {
    pub line: Option<u32>,
    pub value: Option<Stored>,
    /// Time codes and values, in ascending order of time.
    pub samples: Vec<(f64, Stored)>,
    pub has_spline: bool,
    /// True if the file declares the property `custom`, that is, as part of no schema.
    pub is_custom: bool,
    /// True if each value holds until the next sample, as with integers and booleans.
    pub is_held: bool,
    /// Paths that a relationship names.
    pub targets: ListOp<Text>,
    /// Paths of the properties that an attribute takes its value from.
    pub connections: ListOp<Text>,
    pub interpolation: Option<Text>,
    pub element_size: Option<f64>,
    pub color_space: Option<Text>,
    /// Binding strength, if the property is a material binding.
    pub strength: Option<Text>,
}

/// A value, or its place in a binary file.
#[derive(Clone, Debug)]
pub(super) enum Stored {
    Value(Value),
    In(Rep),
}

impl Layer {
    /// Decodes a value of this layer. `at` is the location of its property, for messages.
    ///
    /// # Errors
    /// If the bytes of the value in a binary file are damaged.
    pub fn value(&self, stored: &Stored, at: &Location) -> Result<Value> {
        match (stored, &self.binary) {
            (Stored::Value(value), _) => Ok(value.clone()),
            (Stored::In(rep), Some(binary)) => binary
                .value(*rep)
                .map_err(|wrong| Error::invalid(at.clone(), wrong, "a value inside the file's bytes")),
            (Stored::In(_), None) => Ok(Value::Other),
        }
    }

    /// Adds a prim or a variant and returns its index.
    pub fn push(&mut self, prim: PrimSpec) -> u32 {
        self.prims.push(prim);
        self.prims.len() as u32 - 1
    }

    /// Finds the path of a prim, without names of variants, by a search of all prims.
    pub fn path(&self, index: u32) -> String {
        let mut above: BTreeMap<u32, (u32, Option<&Text>)> = BTreeMap::new();
        for (owner, prim) in self.prims.iter().enumerate() {
            let children = prim.children.iter().map(|(name, child)| (*child, Some(name)));
            let variants = prim.variants.values().flat_map(BTreeMap::values).map(|child| (*child, None));
            above.extend(children.chain(variants).map(|(child, name)| (child, (owner as u32, name))));
        }
        let (mut names, mut index) = (Vec::new(), index);
        while let Some(&(owner, name)) = above.get(&index).filter(|_| names.len() < self.prims.len()) {
            names.extend(name.map(|name| &**name));
            index = owner;
        }
        names.reverse();
        format!("/{}", names.join("/"))
    }

    /// Location of an item in the file.
    pub fn at(&self, line: Option<u32>, item: &str) -> Location {
        // A path may be as long as the file.
        Location { line, ..Location::file(&self.name) }.item(excerpt(item, LONGEST_PATH))
    }
}

impl PrimSpec {
    /// Path of the first prim that this prim is composed of, or the name of its file if only the
    /// file is named.
    pub fn named(&self) -> Option<&Text> {
        let paths = [&self.inherits, &self.specializes].map(ListOp::first);
        let references = [&self.references, &self.payloads].map(ListOp::first);
        let references =
            references.map(|found| found.map(|r| if r.prim.is_empty() { &r.asset } else { &r.prim }));
        paths.into_iter().chain(references).flatten().next()
    }

    /// Adds a child. If several children have the same name, the first counts.
    pub fn add_child(&mut self, name: &Text, index: u32) {
        if !self.by_name.contains_key(name) {
            self.by_name.insert(name.clone(), index);
            self.children.push((name.clone(), index));
        }
    }
}

impl Metadata {
    /// Sets the field `name`, if the layer stores it.
    pub fn set(&mut self, name: &str, value: &Value) {
        match name {
            "defaultPrim" => self.default_prim = value.text().cloned(),
            "metersPerUnit" => self.meters_per_unit = value.number(),
            "upAxis" => self.up_axis = value.text().cloned(),
            "timeCodesPerSecond" => self.time_codes_per_second = value.number(),
            "framesPerSecond" => self.frames_per_second = value.number(),
            "subLayers" => self.sublayers = value.texts().map(<[Text]>::to_vec).unwrap_or_default(),
            _ => {}
        }
    }
}

impl PrimSpec {
    /// Sets the field `name`, if the prim stores it.
    pub fn set(&mut self, name: &str, value: &Value) {
        let truth = |value: &Value| value.number().map(|n| n != 0.0);
        match (name, value) {
            ("active", value) => self.active = truth(value),
            ("instanceable", value) => self.instanceable = truth(value),
            ("variants" | "variantSelection", Value::Selections(all)) => self.selections.clone_from(all),
            ("apiSchemas", Value::Paths(op)) => self.schemas = op.clone(),
            ("references", Value::References(op)) => self.references = op.clone(),
            ("payload", Value::References(op)) => self.payloads = op.clone(),
            ("inherits" | "inheritPaths", Value::Paths(op)) => self.inherits = op.clone(),
            ("specializes", Value::Paths(op)) => self.specializes = op.clone(),
            ("inactiveIds", Value::Ids(op)) => self.inactive_ids = op.clone(),
            ("clips" | "clipSets", _) => self.has_clips = true,
            ("typeName", value) => {
                self.type_name = value.text().filter(|t| !t.is_empty() && &***t != "__AnyType__").cloned();
            }
            _ => {}
        }
    }
}

impl Property {
    /// Sets the field `name`, if the property stores it.
    pub fn set(&mut self, name: &str, value: &Value) {
        match name {
            "interpolation" => self.interpolation = value.text().cloned(),
            "elementSize" => self.element_size = value.number(),
            "colorSpace" => self.color_space = value.text().cloned(),
            "bindMaterialAs" => self.strength = value.text().cloned(),
            _ => {}
        }
    }
}

/// Makes a path relative to `prim` absolute: `../B` relative to `/A/C` is `/A/B`.
pub(super) fn absolute(path: &str, prim: &str) -> Text {
    if path.starts_with('/') {
        return path.into();
    }
    let (steps, property) = path.split_once('.').map_or((path, None), |(a, b)| {
        // The dots of `..` do not begin the name of a property.
        if path.starts_with("..") { (path, None) } else { (a, Some(b)) }
    });
    let mut names: Vec<&str> = prim.split('/').filter(|n| !n.is_empty()).collect();
    for step in steps.split('/').filter(|s| !s.is_empty()) {
        match step.strip_prefix("..") {
            Some(rest) => {
                names.pop();
                if let Some(property) = rest.strip_prefix('.') {
                    return format!("/{}.{property}", names.join("/")).into();
                }
            }
            None => names.push(step),
        }
    }
    match property {
        Some(property) => format!("/{}.{property}", names.join("/")).into(),
        None => format!("/{}", names.join("/")).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_below_a_prim_become_absolute() {
        for (path, expected) in [
            ("/X/Y", "/X/Y"),
            ("../B", "/A/B"),
            ("D", "/A/C/D"),
            (".inputs:a", "/A/C.inputs:a"),
            ("../B.out", "/A/B.out"),
            ("..", "/A"),
            ("../../../..", "/"),
        ] {
            assert_eq!(&*absolute(path, "/A/C"), expected, "{path}");
        }
    }
}
