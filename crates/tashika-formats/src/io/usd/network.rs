//! Shading networks: sources of the values of inputs.

use super::Stage;
use super::prim::Prim;
use super::value::{Text, Value};
use crate::error::Result;

/// Largest length of a chain of connections.
const MAX_STEPS: usize = 64;

/// Source of the value of an input.
pub(super) enum Source {
    Value(Value),
    /// An output of a shader.
    Output(Prim, Text),
}

/// End of a chain of connections: a property with a value, or a shader and its output.
enum End {
    Value(Prim, Text),
    Output(Prim, Text),
}

impl Stage<'_> {
    /// Source of a property of a material or a shader. Connections are followed through node graphs
    /// and their inputs.
    pub fn source(&mut self, prim: &Prim, name: &str) -> Result<Option<Source>> {
        Ok(match self.end(prim, name)? {
            None => None,
            Some(End::Value(prim, name)) => self.value(&prim, &name)?.map(Source::Value),
            Some(End::Output(prim, output)) => Some(Source::Output(prim, output)),
        })
    }

    /// Returns the prim and the property with the value of an input: the input itself, or an input
    /// of the material.
    pub fn owner(&mut self, prim: &Prim, name: &str) -> Result<(Prim, Text)> {
        Ok(match self.end(prim, name)? {
            Some(End::Value(prim, name)) => (prim, name),
            _ => (prim.clone(), name.into()),
        })
    }

    fn end(&mut self, prim: &Prim, name: &str) -> Result<Option<End>> {
        let (mut prim, mut name) = (prim.clone(), Text::from(name));
        for _ in 0..MAX_STEPS {
            let Some(path) = self.connections(&prim, &name).into_iter().next() else {
                return Ok(Some(End::Value(prim, name)));
            };
            let next = match path.rsplit_once('.') {
                Some((owner, property)) => {
                    let owner = self.composer.prim(owner, &mut self.builder)?;
                    owner.map(|owner| (owner, Text::from(property)))
                }
                None => None,
            };
            let Some((owner, property)) = next else { return Ok(Some(End::Value(prim, name))) };
            if &*self.type_name(&owner) == "Shader" && property.starts_with("outputs:") {
                let output = property.strip_prefix("outputs:").unwrap_or_default().into();
                return Ok(Some(End::Output(owner, output)));
            }
            (prim, name) = (owner, property);
        }
        Ok(None)
    }

    /// Shader id of a prim; empty if it has none.
    pub fn shader(&mut self, prim: &Prim) -> Result<Text> {
        Ok(self.word(prim, "info:id")?.unwrap_or_default())
    }

    /// Value of an input, unless a shader computes it.
    pub fn plain_input(&mut self, prim: &Prim, name: &str) -> Result<Option<Value>> {
        Ok(match self.source(prim, name)? {
            Some(Source::Value(value)) => Some(value),
            _ => None,
        })
    }

    pub fn input_number(&mut self, prim: &Prim, name: &str, fallback: f64) -> Result<f64> {
        let number = self.plain_input(prim, name)?.and_then(|value| value.number());
        Ok(number.filter(|n| n.is_finite()).unwrap_or(fallback))
    }

    pub fn input_tuple<const N: usize>(
        &mut self,
        prim: &Prim,
        name: &str,
        fallback: [f64; N],
    ) -> Result<[f64; N]> {
        let tuple = self.plain_input(prim, name)?.and_then(|value| value.tuple::<N>());
        Ok(tuple.filter(|all| all.iter().all(|n| n.is_finite())).unwrap_or(fallback))
    }

    pub fn input_word(&mut self, prim: &Prim, name: &str) -> Result<Option<Text>> {
        Ok(self.plain_input(prim, name)?.and_then(|value| value.text().cloned()))
    }
}
