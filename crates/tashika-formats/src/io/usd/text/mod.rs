//! `.usda`: layers as text.
//!
//! | module | purpose |
//! |---|---|
//! | [`cursor`] | position in the text; words, strings, numbers |
//! | [`values`] | values of attributes |
//! | [`metadata`] | fields between parentheses |
//! | this one | prims, properties, variants |
//!
//! # Guarantee
//! Any bytes give a layer, or an error with its line. Prims and values are nested at most
//! [`MAX_DEPTH`] deep; memory is proportional to the text.
//!
//! # Differences from the format
//! Only the syntax is checked: values may have another type than the declared one, and a name may
//! stand in place of a string.
//!
//! Held to this by `usd` and `damaged_usd` of the suite.

mod cursor;
mod metadata;
mod values;

use std::path::Path;

use self::cursor::Cursor;
use super::layer::{Layer, Metadata, PrimSpec, Property, Specifier, Stored, absolute};
use super::value::{Edit, Text, Value};
use crate::error::Result;

/// Largest depth of nested prims and values.
const MAX_DEPTH: usize = 100;

/// Reads a text.
pub(super) fn parse(bytes: &[u8], name: &Path) -> Result<Layer> {
    let mut layer = Layer {
        name: name.to_owned(),
        prims: vec![PrimSpec::default()],
        metadata: Metadata::default(),
        binary: None,
    };
    let mut cursor = Cursor::new(bytes, name);
    if !(bytes.starts_with(b"#usda ") || bytes.starts_with(b"#sdf ")) {
        return Err(cursor.invalid("a file that begins otherwise", "#usda 1.0"));
    }
    cursor.skip_blank();
    let mut parser = Parser { cursor, layer: &mut layer };
    if parser.cursor.eat(b'(') {
        parser.layer_metadata()?;
    }
    while !parser.cursor.is_at_end() {
        parser.statement(0, "", 0)?;
    }
    Ok(layer)
}

/// A text, and the layer read from it so far.
struct Parser<'a, 'l> {
    cursor: Cursor<'a>,
    layer: &'l mut Layer,
}

impl Parser<'_, '_> {
    /// Parses one statement in the braces of prim `owner`.
    fn statement(&mut self, owner: u32, path: &str, depth: usize) -> Result<()> {
        if self.cursor.eat(b';') {
            return Ok(());
        }
        let line = self.cursor.line();
        let word = self.cursor.word("a prim or a property")?;
        match word {
            "def" => self.prim(owner, path, Specifier::Def, line, depth),
            "over" => self.prim(owner, path, Specifier::Over, line, depth),
            "class" => self.prim(owner, path, Specifier::Class, line, depth),
            "variantSet" => self.variant_set(owner, path, depth),
            _ if path.is_empty() && word != "reorder" => {
                Err(self.cursor.invalid(&format!("{word:?} outside of a prim"), "def, over or class"))
            }
            word => self.property(owner, path, word, line),
        }
    }

    fn prim(&mut self, owner: u32, path: &str, specifier: Specifier, line: u32, depth: usize) -> Result<()> {
        let type_name = match self.cursor.peek() {
            Some(b'"' | b'\'') => None,
            _ => Some(Text::from(self.cursor.word("a type or a name")?)),
        };
        let name: Text = self.cursor.string()?.as_str().into();
        if name.is_empty() || name.contains(['/', '.']) {
            return Err(self.cursor.invalid(&format!("a prim named {name:?}"), "a name"));
        }
        let path = format!("{path}/{name}");
        let prim = PrimSpec { line: Some(line), specifier, type_name, ..PrimSpec::default() };
        let index = self.layer.push(prim);
        self.layer.prims[owner as usize].add_child(&name, index);
        self.body(index, &path, depth)
    }

    /// Parses the metadata and the braces of a prim or a variant.
    fn body(&mut self, index: u32, path: &str, depth: usize) -> Result<()> {
        if depth >= MAX_DEPTH {
            let found = format!("more than {MAX_DEPTH} prims in each other");
            return Err(self.cursor.invalid(&found, "fewer"));
        }
        if self.cursor.eat(b'(') {
            self.prim_metadata(index, path)?;
        }
        self.cursor.expect(b'{')?;
        while !self.cursor.eat(b'}') {
            self.statement(index, path, depth + 1)?;
        }
        Ok(())
    }

    fn variant_set(&mut self, owner: u32, path: &str, depth: usize) -> Result<()> {
        let set: Text = self.cursor.string()?.as_str().into();
        self.cursor.expect(b'=')?;
        self.cursor.expect(b'{')?;
        while !self.cursor.eat(b'}') {
            if self.cursor.eat(b';') {
                continue;
            }
            let line = self.cursor.line();
            let name: Text = self.cursor.string()?.as_str().into();
            let index = self.layer.push(PrimSpec { line: Some(line), ..PrimSpec::default() });
            let variants = self.layer.prims[owner as usize].variants.entry(set.clone()).or_default();
            variants.entry(name).or_insert(index);
            self.body(index, path, depth)?;
        }
        Ok(())
    }

    /// Parses a property that begins with `word`.
    fn property(&mut self, owner: u32, path: &str, word: &str, line: u32) -> Result<()> {
        let (mut edit, mut is_custom) = (Edit::Explicit, false);
        let mut word = word.to_owned();
        loop {
            match word.as_str() {
                "custom" => is_custom = true,
                "uniform" | "varying" | "config" => {}
                word => match edit_of(word) {
                    Some(found) => edit = found,
                    None => break,
                },
            }
            self.word_into(&mut word)?;
            if edit == Edit::Reorder && matches!(word.as_str(), "nameChildren" | "properties" | "rootPrims") {
                self.cursor.expect(b'=')?;
                self.value(0)?;
                return Ok(());
            }
        }
        let is_relationship = word == "rel";
        let is_held = is_whole(&word);
        if self.cursor.eat(b'[') {
            self.cursor.expect(b']')?;
        }
        let name: Text = self.cursor.word("the name of a property")?.into();
        let part = if self.cursor.eat_at_once(b'.') { self.cursor.word("a part of a property")? } else { "" };
        let part = part.to_owned();
        let mut property = self.layer.prims[owner as usize].properties.remove(&name).unwrap_or_default();
        property.line.get_or_insert(line);
        property.is_held |= is_held;
        property.is_custom |= is_custom;
        if self.cursor.eat(b'=') {
            match part.as_str() {
                "connect" => property.connections.edit(edit, self.paths(path)?),
                "timeSamples" => property.samples = self.samples()?,
                "spline" => {
                    self.cursor.skip_block()?;
                    property.has_spline = true;
                }
                _ if is_relationship => property.targets.edit(edit, self.paths(path)?),
                _ => property.value = Some(Stored::Value(self.value(0)?)),
            }
        }
        if self.cursor.eat(b'(') {
            self.property_metadata(&mut property)?;
        }
        self.layer.prims[owner as usize].properties.insert(name, property);
        Ok(())
    }

    fn word_into(&mut self, word: &mut String) -> Result<()> {
        word.clear();
        word.push_str(self.cursor.word("a property")?);
        Ok(())
    }

    /// Parses the paths of a relationship or of connections; `None` stands for an empty list.
    fn paths(&mut self, prim: &str) -> Result<Vec<Text>> {
        let paths = match self.value(0)? {
            Value::Text(path) => vec![path],
            Value::Texts(paths) => paths,
            _ => Vec::new(),
        };
        Ok(paths.iter().map(|path| absolute(path, prim)).collect())
    }

    /// Parses `{ time: value, … }`, sorted by time.
    fn samples(&mut self) -> Result<Vec<(f64, Stored)>> {
        let mut samples = Vec::new();
        self.cursor.expect(b'{')?;
        while !self.cursor.eat(b'}') {
            let time = self.cursor.number()?;
            self.cursor.expect(b':')?;
            samples.push((time, Stored::Value(self.value(0)?)));
            self.cursor.eat(b',');
        }
        if samples.iter().any(|(time, _)| !time.is_finite()) {
            return Err(self.cursor.invalid("a time that is not finite", "time codes"));
        }
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(samples)
    }
}

/// Returns true if values of the type are integers or booleans.
fn is_whole(type_name: &str) -> bool {
    let rest =
        ["int64", "uint64", "uint", "int", "bool", "uchar"].iter().find_map(|t| type_name.strip_prefix(t));
    rest.is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
}

/// Kind of list edit with the keyword `word`, if it is one.
fn edit_of(word: &str) -> Option<Edit> {
    Some(match word {
        "prepend" => Edit::Prepend,
        "append" | "add" => Edit::Append,
        "delete" => Edit::Delete,
        "reorder" => Edit::Reorder,
        _ => return None,
    })
}

impl Parser<'_, '_> {
    fn prim_metadata(&mut self, index: u32, path: &str) -> Result<()> {
        // The prim is taken out of the layer while its metadata are read. Metadata add no prims.
        let mut prim = std::mem::take(&mut self.layer.prims[index as usize]);
        let result = self.metadata(|parser, edit, key| {
            match key {
                "references" => prim.references.edit(edit, parser.references(path)?),
                "payload" => prim.payloads.edit(edit, parser.references(path)?),
                "inherits" => prim.inherits.edit(edit, parser.paths(path)?),
                "specializes" => prim.specializes.edit(edit, parser.paths(path)?),
                "apiSchemas" => {
                    let value = parser.value(0)?;
                    prim.schemas.edit(edit, value.texts().map(<[Text]>::to_vec).unwrap_or_default());
                }
                "inactiveIds" => {
                    let ids = parser.value(0)?;
                    let ids = ids.numbers().unwrap_or_default().iter().map(|&id| id as i64).collect();
                    prim.inactive_ids.edit(edit, ids);
                }
                "variants" => prim.selections = parser.selections()?,
                key => prim.set(key, &parser.value(0)?),
            }
            Ok(())
        });
        self.layer.prims[index as usize] = prim;
        result
    }

    fn property_metadata(&mut self, property: &mut Property) -> Result<()> {
        self.metadata(|parser, _, key| {
            property.set(key, &parser.value(0)?);
            Ok(())
        })
    }

    fn layer_metadata(&mut self) -> Result<()> {
        self.metadata(|parser, _, key| {
            if key == "subLayers" {
                let sublayers = parser.references("")?;
                let metadata = &mut parser.layer.metadata;
                metadata.has_offsets |= sublayers.iter().any(|layer| layer.has_offset);
                metadata.sublayers = sublayers.into_iter().map(|layer| layer.asset).collect();
            } else if key == "relocates" {
                parser.cursor.skip_block()?;
                parser.layer.metadata.has_relocates = true;
            } else {
                let value = parser.value(0)?;
                parser.layer.metadata.set(key, &value);
            }
            Ok(())
        })
    }
}
