//! Properties of a file that no reader uses.
//!
//! Properties of schemas are treated as [`properties`](super::properties) prescribes. Of all other
//! properties, those without a namespace and inputs of lights are noted, unless the file declares
//! them `custom`. All properties in namespaces of other renderers share one note. Primvars, custom
//! attributes and properties in unknown namespaces are data of other programs and are not noted.
//!
//! Each prim of a layer is checked once, even if many prims of the scene are composed of it.
//!
//! Held to this by `usd_unread` of the suite.

use super::Stage;
use super::features::met;
use super::prim::Prim;
use super::properties::{Fate, Without, fate};
use super::value::{Text, Value};
use crate::error::Result;
use crate::io::notes::quoted;
use crate::scene::NoteKind;

/// Namespaces that other renderers use in files.
const RENDERERS: [&str; 12] = [
    "arnold", "cycles", "houdini", "karma", "mitsuba", "moonray", "octane", "omni", "prman", "redshift",
    "ri", "vray",
];

impl Stage<'_> {
    /// Notes the properties of a prim that have a value and are not read.
    pub fn note_unread(&mut self, prim: &Prim, type_name: &str) -> Result<()> {
        for &(layer, spec, _) in prim.opinions() {
            if !self.looked_at.insert((layer, spec)) {
                continue;
            }
            let properties = &self.composer.layers.spec((layer, spec)).properties;
            let names: Vec<(Text, bool)> =
                properties.iter().map(|(name, property)| (name.clone(), property.is_custom)).collect();
            for (name, is_custom) in names {
                let Some(fate) = fate(type_name, &name) else { return Ok(()) };
                match fate {
                    Some(Fate::Read | Fate::NoEffect(_)) => {}
                    Some(Fate::Noted([kind, row], without)) => {
                        if self.is_given(prim, &name, without)? {
                            met(kind, row, self.at_property(prim, &name), &mut self.builder)?;
                        }
                    }
                    None => self.note_unknown(prim, type_name, &name, is_custom)?,
                }
            }
        }
        Ok(())
    }

    /// Returns true if the value of a property differs from its fallback.
    fn is_given(&mut self, prim: &Prim, name: &str, without: Without) -> Result<bool> {
        if !self.targets(prim, name).is_empty() {
            return Ok(true);
        }
        Ok(match (self.value(prim, name)?, without) {
            (None, _) => false,
            (Some(Value::Array { numbers, .. }), _) => !numbers.is_empty(),
            (Some(Value::Texts(texts)), _) => !texts.is_empty(),
            (Some(Value::Number(number)), Without::Number(usual)) => number != usual,
            (Some(Value::Text(word)), Without::Word(usual)) => !word.is_empty() && &*word != usual,
            (Some(Value::Text(word)), _) => !word.is_empty(),
            (Some(_), _) => true,
        })
    }

    fn note_unknown(&mut self, prim: &Prim, type_name: &str, name: &str, is_custom: bool) -> Result<()> {
        let own = name.strip_prefix("primvars:").unwrap_or(name);
        let is_of_renderer = own.split_once(':').is_some_and(|(space, _)| RENDERERS.contains(&space));
        let at = self.at_property(prim, name);
        if is_of_renderer {
            return met("attribute", "of other renderers", at, &mut self.builder);
        }
        let is_light = type_name.ends_with("Light") || type_name == "DomeLight_1";
        let is_input = is_light && name.starts_with("inputs:");
        if !is_custom && (is_input || !name.contains(':')) {
            let message = format!("attribute {} is unknown: not read", quoted(name));
            let rest = "other unknown attributes: not read";
            self.named.add(NoteKind::Ignored, message, rest, at, self.builder.notes_mut());
        }
        Ok(())
    }
}
