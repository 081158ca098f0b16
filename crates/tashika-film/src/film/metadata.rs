//! Provenance of a film as named values: its content and the way it was made.
//!
//! The names that this program uses are the rows of [`keys`](super::keys). Values are sorted by
//! name, so that equal films become equal files. In OpenEXR the value named `seed` is the attribute
//! `tashika:seed`; [`crate::io`] lists the attribute type of each value. No time, thread count or
//! host name belongs here: the film is a function of scene, options and seed.

use std::collections::BTreeMap;
use std::fmt;

/// A value of the metadata.
#[derive(Clone, Debug)]
pub enum Value {
    /// A string in UTF-8.
    Text(String),
    /// A whole number.
    Int(i64),
    /// A real number. If it has a unit, its name ends with the unit.
    Float(f64),
    /// Yes or no.
    Bool(bool),
}

/// Equality of bits: a film that was written and read again equals the original.
impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Text(a), Self::Text(b)) => a == b,
            (Self::Int(a), Self::Int(b)) => a == b,
            (Self::Float(a), Self::Float(b)) => a.to_bits() == b.to_bits(),
            (Self::Bool(a), Self::Bool(b)) => a == b,
            (Self::Text(_) | Self::Int(_) | Self::Float(_) | Self::Bool(_), _) => false,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Int(number) => number.fmt(f),
            Self::Float(number) => number.fmt(f),
            Self::Bool(yes) => yes.fmt(f),
        }
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<i64> for Value {
    fn from(number: i64) -> Self {
        Self::Int(number)
    }
}

impl From<u32> for Value {
    fn from(number: u32) -> Self {
        Self::Int(number.into())
    }
}

/// A number above `i64::MAX` is stored as text, in decimal digits. Only seeds can be that large.
impl From<u64> for Value {
    fn from(number: u64) -> Self {
        i64::try_from(number).map_or_else(|_| Self::Text(number.to_string()), Self::Int)
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Float(number)
    }
}

impl From<bool> for Value {
    fn from(yes: bool) -> Self {
        Self::Bool(yes)
    }
}

/// Named values, sorted by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata(BTreeMap<String, Value>);

impl Metadata {
    /// Longest name (bytes): an OpenEXR attribute name has at most 255, prefix included.
    pub const MAX_NAME_BYTES: usize = 200;

    /// Sets a value, replacing an earlier one of that name.
    ///
    /// # Panics
    /// If the name is empty, longer than [`Self::MAX_NAME_BYTES`] or not printable ASCII.
    pub fn set(&mut self, name: impl AsRef<str>, value: impl Into<Value>) {
        let name = name.as_ref();
        assert!(
            !name.is_empty()
                && name.len() <= Self::MAX_NAME_BYTES
                && name.bytes().all(|b| b.is_ascii_graphic()),
            "{name:?} cannot name a value"
        );
        self.0.insert(name.to_owned(), value.into());
    }

    /// Removes the value of that name, if there is one.
    pub fn remove(&mut self, name: impl AsRef<str>) {
        self.0.remove(name.as_ref());
    }

    /// The value of that name.
    pub fn get(&self, name: impl AsRef<str>) -> Option<&Value> {
        self.0.get(name.as_ref())
    }

    /// The value of that name, if it is text.
    pub fn text(&self, name: impl AsRef<str>) -> Option<&str> {
        match self.get(name) {
            Some(Value::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// The value of that name, if it is a boolean.
    pub fn bool(&self, name: impl AsRef<str>) -> Option<bool> {
        match self.get(name) {
            Some(Value::Bool(yes)) => Some(*yes),
            _ => None,
        }
    }

    /// The value of that name, if it is an integer or a real number.
    pub fn number(&self, name: impl AsRef<str>) -> Option<f64> {
        match self.get(name) {
            Some(Value::Int(number)) => Some(*number as f64),
            Some(Value::Float(number)) => Some(*number),
            _ => None,
        }
    }

    /// All values, sorted by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.0.iter().map(|(name, value)| (name.as_str(), value))
    }

    /// Returns true if there are no values.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_keep_their_type_and_the_order_is_that_of_names() {
        let mut metadata = Metadata::default();
        metadata.set("seed", u64::MAX);
        metadata.set("complete", false);
        metadata.set("clamp_m", 0.25);
        metadata.set("vpls", 55_000_u32);
        metadata.set("complete", true);
        let names: Vec<&str> = metadata.iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["clamp_m", "complete", "seed", "vpls"]);
        assert_eq!(metadata.bool("complete"), Some(true));
        assert_eq!(metadata.text("seed"), Some("18446744073709551615"), "no digit of a seed is lost");
        assert_eq!((metadata.number("vpls"), metadata.number("clamp_m")), (Some(55_000.0), Some(0.25)));
        assert_eq!((metadata.text("vpls"), metadata.bool("absent")), (None, None));
    }

    #[test]
    fn equality_is_that_of_bits() {
        assert_ne!(Value::Float(0.0), Value::Float(-0.0));
        assert_ne!(Value::Int(1), Value::Float(1.0));
    }

    #[test]
    #[should_panic(expected = "cannot name a value")]
    fn a_name_with_a_space_is_a_bug() {
        Metadata::default().set("half width", 1.0);
    }
}
