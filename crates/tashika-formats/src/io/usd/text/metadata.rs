//! Metadata between parentheses: fields of layers, prims and properties.

use super::super::layer::absolute;
use super::super::value::{Edit, Reference, Text, Value};
use super::{Parser, edit_of};
use crate::error::Result;

impl Parser<'_, '_> {
    /// Parses all fields up to the closing parenthesis; `take` reads the value of each.
    pub(super) fn metadata(
        &mut self,
        mut take: impl FnMut(&mut Self, Edit, &str) -> Result<()>,
    ) -> Result<()> {
        while !self.cursor.eat(b')') {
            if self.cursor.eat(b';') || self.cursor.eat(b',') {
                continue;
            }
            if matches!(self.cursor.peek(), Some(b'"' | b'\'')) {
                // A string without a key is a comment.
                self.cursor.string()?;
                continue;
            }
            let mut key = self.cursor.word("a field")?.to_owned();
            let mut edit = Edit::Explicit;
            if let Some(found) = edit_of(&key)
                && self.cursor.peek() != Some(b'=')
            {
                edit = found;
                key = self.cursor.word("a field")?.to_owned();
            }
            self.cursor.expect(b'=')?;
            take(self, edit, &key)?;
        }
        Ok(())
    }

    /// Parses references, payloads or sublayers. Their paths are relative to `prim`.
    pub(super) fn references(&mut self, prim: &str) -> Result<Vec<Reference>> {
        if !self.cursor.eat(b'[') {
            return Ok(self.reference(prim)?.into_iter().collect());
        }
        let mut all = Vec::new();
        while !self.cursor.eat(b']') {
            all.extend(self.reference(prim)?);
            self.cursor.eat(b',');
        }
        Ok(all)
    }

    /// Parses `@file@</prim> (offset = 1)`; none for `None`.
    fn reference(&mut self, prim: &str) -> Result<Option<Reference>> {
        let mut reference = Reference::default();
        let mut is_any = false;
        if self.cursor.peek() == Some(b'@') {
            reference.asset = self.cursor.asset()?.as_str().into();
            is_any = true;
        }
        if self.cursor.peek() == Some(b'<') {
            let path = self.cursor.path()?;
            reference.prim = if path.is_empty() { path.into() } else { absolute(path, prim) };
            is_any = true;
        }
        if !is_any {
            let word = self.cursor.word("a file or a prim")?;
            if word != "None" {
                return Err(self.cursor.invalid(&format!("{word:?}"), "@file@, </prim> or None"));
            }
            return Ok(None);
        }
        if self.cursor.eat(b'(') {
            self.metadata(|parser, _, key| {
                let value = parser.value(0)?;
                let without = if key == "scale" { 1.0 } else { 0.0 };
                reference.has_offset |= matches!(key, "offset" | "scale") && value.number() != Some(without);
                Ok(())
            })?;
        }
        Ok(Some(reference))
    }

    /// Parses `{ string set = "choice" … }`.
    pub(super) fn selections(&mut self) -> Result<Vec<(Text, Text)>> {
        let mut all = Vec::new();
        self.cursor.expect(b'{')?;
        while !self.cursor.eat(b'}') {
            if self.cursor.eat(b';') || self.cursor.eat(b',') {
                continue;
            }
            self.cursor.word("string")?;
            let set: Text = match self.cursor.peek() {
                Some(b'"' | b'\'') => self.cursor.string()?.as_str().into(),
                _ => self.cursor.word("a variant set")?.into(),
            };
            self.cursor.expect(b'=')?;
            if let Value::Text(choice) = self.value(0)? {
                all.push((set, choice));
            }
        }
        Ok(all)
    }
}
