//! Prims of the scene, and the values that result from their opinions.
//!
//! The strongest opinion counts. If the scene is loaded without a time, the value is the default,
//! or the first sample if there is no default. At a time `t`, the value is interpolated linearly
//! between the two samples around `t`, if both consist of numbers and have the same shape.
//! Integers, booleans and all other values are those of the last sample that is not after `t`.
//!
//! Held to this by `usd` of the suite.

use std::rc::Rc;

use super::Stage;
use super::features::met;
use super::layer::{Property, Stored};
use super::layers::LayerId;
use super::sites::Mapping;
use super::value::{ListOp, Text, Value};
use crate::error::{Location, Result};

/// An opinion about a prim: layer, prim in the layer, and the map from paths of the layer to paths
/// of the scene.
type Opinion = (LayerId, u32, Rc<Mapping>);

/// A prim of the scene.
#[derive(Clone, Debug)]
pub(super) struct Prim {
    pub path: Text,
    opinions: Vec<Opinion>,
}

impl Prim {
    pub fn new(path: Text, opinions: Vec<Opinion>) -> Self {
        Self { path, opinions }
    }

    pub fn opinions(&self) -> &[Opinion] {
        &self.opinions
    }

    /// Last name of the path.
    pub fn name(&self) -> &str {
        self.path.rsplit('/').next().unwrap_or_default()
    }

    /// Key that prims share if they have the same opinions.
    pub fn identity(&self) -> Vec<(LayerId, u32)> {
        self.opinions.iter().map(|&(layer, prim, _)| (layer, prim)).collect()
    }
}

impl Stage<'_> {
    fn strongest<T>(&self, prim: &Prim, mut of: impl FnMut(LayerId, u32) -> Option<T>) -> Option<T> {
        prim.opinions.iter().find_map(|&(layer, spec, _)| of(layer, spec))
    }

    pub fn type_name(&self, prim: &Prim) -> Text {
        let layers = &self.composer.layers;
        self.strongest(prim, |l, s| layers.spec((l, s)).type_name.clone()).unwrap_or_default()
    }

    pub fn is_active(&self, prim: &Prim) -> bool {
        let layers = &self.composer.layers;
        self.strongest(prim, |l, s| layers.spec((l, s)).active).unwrap_or(true)
    }

    pub fn is_instance(&self, prim: &Prim) -> bool {
        let layers = &self.composer.layers;
        self.strongest(prim, |l, s| layers.spec((l, s)).instanceable).unwrap_or(false)
    }

    /// Returns true if a schema is applied to the prim.
    pub fn has_schema(&self, prim: &Prim, name: &str) -> bool {
        let mut all: Vec<Text> = Vec::new();
        for &(layer, spec, _) in prim.opinions.iter().rev() {
            self.composer.layers.spec((layer, spec)).schemas.apply(&mut all);
        }
        all.iter().any(|schema| &**schema == name)
    }

    /// Returns true if values of the prim come from a series of other files.
    pub fn has_clips(&self, prim: &Prim) -> bool {
        prim.opinions.iter().any(|&(layer, spec, _)| self.composer.layers.spec((layer, spec)).has_clips)
    }

    /// Returns the inactive instances of a point instancer.
    pub fn inactive_ids(&self, prim: &Prim) -> Vec<i64> {
        let mut all = Vec::new();
        for &(layer, spec, _) in prim.opinions.iter().rev() {
            self.composer.layers.spec((layer, spec)).inactive_ids.apply(&mut all);
        }
        all
    }

    /// Location of a prim.
    pub fn at(&self, prim: &Prim) -> Location {
        match prim.opinions.first() {
            Some(&(layer, spec, _)) => self.composer.layers.at((layer, spec), &prim.path),
            None => Location::default().item(&*prim.path),
        }
    }

    /// Location of a property, or of its prim if no layer has the property.
    pub fn at_property(&self, prim: &Prim, name: &str) -> Location {
        let layers = &self.composer.layers;
        let found = self.strongest(prim, |l, s| {
            let line = layers.spec((l, s)).properties.get(name)?.line;
            Some(layers.layer(l).at(line, &format!("{}.{name}", prim.path)))
        });
        found.unwrap_or_else(|| self.at(prim))
    }

    /// Returns the strongest layer and prim that have a property.
    pub fn speaker(&self, prim: &Prim, name: &str) -> Option<(LayerId, u32)> {
        let layers = &self.composer.layers;
        self.strongest(prim, |l, s| layers.spec((l, s)).properties.contains_key(name).then_some((l, s)))
    }

    /// Field of a property, by the strongest opinion that has the field.
    pub fn field<T>(&self, prim: &Prim, name: &str, of: impl Fn(&Property) -> Option<T>) -> Option<T> {
        let layers = &self.composer.layers;
        self.strongest(prim, |l, s| layers.spec((l, s)).properties.get(name).and_then(&of))
    }

    /// Names of the properties with opinions, sorted.
    pub fn properties(&self, prim: &Prim) -> Vec<Text> {
        let layers = &self.composer.layers;
        let all = prim.opinions.iter().flat_map(|&(l, s, _)| layers.spec((l, s)).properties.keys().cloned());
        let mut all: Vec<Text> = all.collect();
        all.sort();
        all.dedup();
        all
    }

    /// Value of an attribute at the time of the scene.
    pub fn value(&mut self, prim: &Prim, name: &str) -> Result<Option<Value>> {
        // Strongest spec with samples, if any.
        let mut changing: Option<(LayerId, u32)> = None;
        for &(layer, spec, _) in &prim.opinions {
            let layers = &self.composer.layers;
            let Some(property) = layers.spec((layer, spec)).properties.get(name) else { continue };
            let span = [property.samples.first(), property.samples.last()];
            let span = span.map(|sample| sample.map(|(code, _)| code / self.codes_per_second));
            let (own, has_spline) = (property.value.clone(), property.has_spline);
            if let [Some(first), Some(last)] = span {
                self.builder.add_animated_seconds([first, last]);
                if self.time.is_some() {
                    changing = Some((layer, spec));
                    break;
                }
                changing = changing.or(Some((layer, spec)));
            }
            if has_spline {
                met("attribute", "spline", self.at_property(prim, name), &mut self.builder)?;
            }
            if let Some(stored) = own {
                return self.stored(layer, &stored, prim, name).map(not_blocked);
            }
        }
        let Some((layer, spec)) = changing else { return Ok(None) };
        if self.time.is_none() {
            met("attribute", "timeSamples", self.at_property(prim, name), &mut self.builder)?;
        }
        let time = self.time.unwrap_or(f64::NEG_INFINITY);
        let property = &self.composer.layers.spec((layer, spec)).properties[name];
        let samples = &property.samples;
        let after = samples.partition_point(|(t, _)| *t <= time);
        let before = samples[after.saturating_sub(1)].clone();
        let next = samples.get(after).filter(|_| after > 0 && !property.is_held).cloned();
        let value = self.stored(layer, &before.1, prim, name)?;
        if let Some((code, next)) = next {
            let other = self.stored(layer, &next, prim, name)?;
            if let Some(between) = value.between(&other, (time - before.0) / (code - before.0)) {
                return Ok(Some(between));
            }
        }
        Ok(not_blocked(value))
    }

    fn stored(&mut self, layer: LayerId, stored: &Stored, prim: &Prim, name: &str) -> Result<Value> {
        let at = self.at_property(prim, name);
        let value = self.composer.layers.layer(layer).value(stored, &at)?;
        self.value_budget.take(value.bytes(), &self.composer.layers, &at)?;
        Ok(value)
    }

    /// A finite number, if there is one.
    pub fn number(&mut self, prim: &Prim, name: &str) -> Result<Option<f64>> {
        Ok(self.value(prim, name)?.and_then(|value| value.number()).filter(|n| n.is_finite()))
    }

    /// A finite number, or the fallback.
    pub fn number_or(&mut self, prim: &Prim, name: &str, fallback: f64) -> Result<f64> {
        Ok(self.number(prim, name)?.unwrap_or(fallback))
    }

    pub fn is_true(&mut self, prim: &Prim, name: &str) -> Result<bool> {
        Ok(self.number(prim, name)?.is_some_and(|n| n != 0.0))
    }

    /// A word, if there is one.
    pub fn word(&mut self, prim: &Prim, name: &str) -> Result<Option<Text>> {
        Ok(self.value(prim, name)?.and_then(|value| value.text().cloned()))
    }

    /// A vector of finite numbers.
    pub fn tuple<const N: usize>(&mut self, prim: &Prim, name: &str) -> Result<Option<[f64; N]>> {
        let tuple = self.value(prim, name)?.and_then(|value| value.tuple::<N>());
        Ok(tuple.filter(|numbers| numbers.iter().all(|n| n.is_finite())))
    }

    /// Name of a file, and the layer that gives it.
    pub fn asset(&mut self, prim: &Prim, name: &str) -> Result<Option<(Text, LayerId)>> {
        let layers = &self.composer.layers;
        let layer = self.strongest(prim, |l, s| {
            let property = layers.spec((l, s)).properties.get(name)?;
            (property.value.is_some() || !property.samples.is_empty()).then_some(l)
        });
        let word = self.word(prim, name)?.filter(|word| !word.is_empty());
        Ok(word.zip(layer))
    }

    /// Targets of a relationship, as paths of the scene.
    pub fn targets(&self, prim: &Prim, name: &str) -> Vec<Text> {
        self.paths(prim, name, |property| &property.targets)
    }

    /// Sources of an attribute's value, as paths of the scene.
    pub fn connections(&self, prim: &Prim, name: &str) -> Vec<Text> {
        self.paths(prim, name, |property| &property.connections)
    }

    fn paths(&self, prim: &Prim, name: &str, of: fn(&Property) -> &ListOp<Text>) -> Vec<Text> {
        let mut all = Vec::new();
        for (layer, spec, mapping) in prim.opinions.iter().rev() {
            let Some(property) = self.composer.layers.spec((*layer, *spec)).properties.get(name) else {
                continue;
            };
            let mapped = |list: &Vec<Text>| -> Vec<Text> {
                list.iter().filter_map(|path| mapping.scene_path(path)).collect()
            };
            let op = of(property);
            let items = op.explicit.iter().flatten().count() + op.prepended.len();
            self.composer.steps.add(items as u64, 0);
            let op = ListOp {
                explicit: op.explicit.as_ref().map(mapped),
                prepended: mapped(&op.prepended),
                appended: mapped(&op.appended),
                deleted: mapped(&op.deleted),
            };
            op.apply(&mut all);
        }
        all
    }
}

fn not_blocked(value: Value) -> Option<Value> {
    (value != Value::Blocked).then_some(value)
}
