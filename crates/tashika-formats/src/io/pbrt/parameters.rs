//! Parameter lists: `"type name" value` or `"type name" [ values ]`, any number of them.
//!
//! Values are read by the declared type. A parameter that is looked up is marked as used, so that
//! unused ones can be noted: as in pbrt, a parameter is found only under its exact name and type.
//!
//! # Guarantee
//! A list has a whole number of values of its type, numbers are finite, and memory is proportional
//! to the length of the text.
//!
//! Tested by the tests below and `suite::pbrt`.

use std::cell::Cell;

use glam::{DVec3, Vec2, Vec3};

use super::lexer::{Lexer, Token, integer, number, unescape, wide_number};
use super::place::Place;
use crate::color::Primaries;
use crate::error::{Error, Location, Result};
use crate::io::notes::excerpt;
use crate::io::text::utf8_or_latin1;

/// The declared type of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// `integer`
    Integer,
    /// `float`
    Float,
    /// `point2`
    Point2,
    /// `point3`, `point`
    Point3,
    /// `vector2`
    Vector2,
    /// `vector3`, `vector`
    Vector3,
    /// `normal`, `normal3`
    Normal,
    /// `bool`
    Boolean,
    /// `string`
    String,
    /// `texture`
    Texture,
    /// `rgb`, `color`
    Rgb,
    /// `xyz`
    Xyz,
    /// `blackbody`
    Blackbody,
    /// `spectrum`
    Spectrum,
}

impl Kind {
    fn of(word: &str) -> Option<Self> {
        Some(match word {
            "integer" => Self::Integer,
            "float" => Self::Float,
            "point2" => Self::Point2,
            "point3" | "point" => Self::Point3,
            "vector2" => Self::Vector2,
            "vector3" | "vector" => Self::Vector3,
            "normal" | "normal3" => Self::Normal,
            "bool" => Self::Boolean,
            "string" => Self::String,
            "texture" => Self::Texture,
            "rgb" | "color" => Self::Rgb,
            "xyz" => Self::Xyz,
            "blackbody" => Self::Blackbody,
            "spectrum" => Self::Spectrum,
            _ => return None,
        })
    }

    /// Count of numbers in one value; the numbers of a spectrum are counted where they are read.
    fn width(self) -> usize {
        match self {
            Self::Point2 | Self::Vector2 => 2,
            Self::Point3 | Self::Vector3 | Self::Normal | Self::Rgb | Self::Xyz => 3,
            _ => 1,
        }
    }
}

/// The values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    /// Numbers of all types except integers and positions.
    Numbers(Vec<f32>),
    /// Coordinates of `point3` and `vector3`.
    Places(Vec<f64>),
    /// Values of `integer`.
    Integers(Vec<i32>),
    /// Values of `string`, `texture`, and of `spectrum` by name.
    Strings(Vec<String>),
    /// Values of `bool`.
    Booleans(Vec<bool>),
}

/// A declared parameter with its values.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    /// Declared type.
    pub(super) kind: Kind,
    /// Name after the type in the declaration.
    pub(super) name: String,
    /// Values in their order; empty only for an empty list.
    pub(super) values: Values,
    /// Declaration as it is spelt in the file.
    pub(super) declaration: String,
    /// Colour space of `rgb` values.
    pub(super) primaries: Primaries,
    place: Place,
    used: Cell<bool>,
}

impl Parameter {
    /// Location of the declaration.
    pub(super) fn at(&self) -> Location {
        self.place.location()
    }

    /// Returns the approximate size of a copy (bytes).
    pub(super) fn bytes(&self) -> usize {
        let values = match &self.values {
            Values::Numbers(values) => 4 * values.len(),
            Values::Places(values) => 8 * values.len(),
            Values::Integers(values) => 4 * values.len(),
            Values::Strings(values) => values.iter().map(|value| size_of::<String>() + value.len()).sum(),
            Values::Booleans(values) => values.len(),
        };
        size_of::<Self>() + self.name.len() + self.declaration.len() + values
    }

    /// Numbers; none if the values are of another type.
    pub(super) fn numbers(&self) -> &[f32] {
        match &self.values {
            Values::Numbers(numbers) => numbers,
            _ => &[],
        }
    }

    /// Strings; none if the values are of another type.
    pub(super) fn strings(&self) -> &[String] {
        match &self.values {
            Values::Strings(strings) => strings,
            _ => &[],
        }
    }
}

/// The parameters of a directive.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    list: Vec<Parameter>,
    /// Parameters that apply unless the list has one of the same name.
    defaults: Vec<Parameter>,
    place: Place,
    accepts_known: Cell<bool>,
}

impl Parameters {
    /// Reads parameters up to the next directive.
    ///
    /// * `primaries`: colour space of `rgb` values.
    /// * `place`: place of the directive that the parameters belong to.
    pub(super) fn read(lexer: &mut Lexer<'_>, primaries: Primaries, place: Place) -> Result<Self> {
        let mut list = Vec::new();
        while lexer.peek() == Some(b'"') {
            let Some(Token::Quoted(declaration)) = lexer.next()? else { break };
            let place = lexer.place();
            list.push(parameter(lexer, &utf8_or_latin1(declaration), primaries, place)?);
        }
        Ok(Self { list, defaults: Vec::new(), place, accepts_known: Cell::new(false) })
    }

    /// Location of the directive.
    pub(super) fn at(&self) -> Location {
        self.place.location()
    }

    /// Returns the location of a parameter, or of the directive if it has no parameter of that
    /// name.
    pub(super) fn place_of(&self, name: &str) -> Location {
        let named = self.defaults.iter().chain(&self.list).rev().find(|p| p.name == name);
        named.map_or_else(|| self.at(), Parameter::at)
    }

    /// Adds defaults for parameters that the list lacks; unused defaults are not noted.
    pub(super) fn extend_defaults(&mut self, defaults: &[Parameter]) {
        self.defaults.extend_from_slice(defaults);
    }

    /// Returns the list itself, as defaults of later directives.
    pub(super) fn into_list(self) -> Vec<Parameter> {
        self.list
    }

    /// Returns the parameter of that name and one of those types, and marks it as used; the last
    /// one, as in pbrt-v3, if there are several.
    pub(super) fn find(&self, kinds: &[Kind], name: &str) -> Option<&Parameter> {
        let mut found = None;
        for parameter in self.defaults.iter().chain(&self.list) {
            if parameter.name == name && kinds.contains(&parameter.kind) {
                parameter.used.set(true);
                found = Some(parameter);
            }
        }
        found
    }

    /// Marks parameters that have no effect here as used.
    pub(super) fn accept(&self, names: &[&str]) {
        self.list.iter().filter(|p| names.contains(&p.name.as_str())).for_each(|p| p.used.set(true));
    }

    /// Marks all parameters in [`known`](super::known) as having no effect here.
    pub(super) fn accept_known(&self) {
        self.accepts_known.set(true);
    }

    /// Returns true if unused known parameters have no effect here.
    pub(super) fn accepts_known(&self) -> bool {
        self.accepts_known.get()
    }

    /// Marks every parameter as unused.
    pub(super) fn forget_uses(&self) {
        self.list.iter().chain(&self.defaults).for_each(|p| p.used.set(false));
        self.accepts_known.set(false);
    }

    /// Returns all parameters of a declared type, without marking them as used.
    pub(super) fn of_kind(&self, kind: Kind) -> impl Iterator<Item = &Parameter> {
        self.defaults.iter().chain(&self.list).filter(move |p| p.kind == kind)
    }

    /// Returns true if any parameter is a texture.
    pub(super) fn has_textures(&self) -> bool {
        self.list.iter().chain(&self.defaults).any(|p| p.kind == Kind::Texture)
    }

    /// Returns the parameters that were not looked up, in the order of the file.
    pub(super) fn unused(&self) -> impl Iterator<Item = &Parameter> {
        self.list.iter().filter(|p| !p.used.get())
    }

    /// Numbers of a parameter, if it exists.
    pub(super) fn numbers(&self, kinds: &[Kind], name: &str) -> Option<&[f32]> {
        self.find(kinds, name).map(Parameter::numbers)
    }

    /// A `float`.
    pub(super) fn float(&self, name: &str) -> Option<f32> {
        self.numbers(&[Kind::Float], name)?.first().copied()
    }

    /// All numbers of a `float`.
    pub(super) fn floats(&self, name: &str) -> Option<&[f32]> {
        self.numbers(&[Kind::Float], name)
    }

    /// All numbers of an `integer`.
    pub(super) fn integers(&self, name: &str) -> Option<&[i32]> {
        match &self.find(&[Kind::Integer], name)?.values {
            Values::Integers(values) => Some(values),
            _ => None,
        }
    }

    /// An `integer`.
    pub(super) fn integer(&self, name: &str) -> Option<i32> {
        self.integers(name)?.first().copied()
    }

    /// A `bool`.
    pub(super) fn boolean(&self, name: &str) -> Option<bool> {
        match &self.find(&[Kind::Boolean], name)?.values {
            Values::Booleans(values) => values.first().copied(),
            _ => None,
        }
    }

    /// A `string`.
    pub(super) fn string(&self, name: &str) -> Option<&str> {
        self.find(&[Kind::String], name)?.strings().first().map(String::as_str)
    }

    /// The name of a `texture`.
    pub(super) fn texture(&self, name: &str) -> Option<&str> {
        self.find(&[Kind::Texture], name)?.strings().first().map(String::as_str)
    }

    /// A `point3` or `vector3`.
    pub(super) fn vector(&self, name: &str) -> Option<DVec3> {
        match &self.find(&[Kind::Point3, Kind::Vector3], name)?.values {
            Values::Places(numbers) => numbers.first_chunk::<3>().map(|v| DVec3::from_array(*v)),
            _ => None,
        }
    }

    /// Returns all positions of a `point3`.
    pub(super) fn points(&self, name: &str) -> Vec<DVec3> {
        match self.find(&[Kind::Point3], name).map(|parameter| &parameter.values) {
            Some(Values::Places(numbers)) => numbers.as_chunks::<3>().0.iter().map(|&v| v.into()).collect(),
            _ => Vec::new(),
        }
    }

    /// All vectors of one of those types.
    pub(super) fn vectors(&self, kinds: &[Kind], name: &str) -> Vec<Vec3> {
        let numbers = self.numbers(kinds, name).unwrap_or_default();
        numbers.as_chunks::<3>().0.iter().map(|&v| v.into()).collect()
    }

    /// Texture coordinates: `point2`, or pairs of `float`.
    pub(super) fn pairs(&self, name: &str) -> Vec<Vec2> {
        let kinds = [Kind::Point2, Kind::Vector2, Kind::Float];
        let numbers = self.numbers(&kinds, name).unwrap_or_default();
        numbers.as_chunks::<2>().0.iter().map(|&v| v.into()).collect()
    }
}

fn parameter(
    lexer: &mut Lexer<'_>,
    declaration: &str,
    primaries: Primaries,
    place: Place,
) -> Result<Parameter> {
    const LONGEST: usize = 60;
    let shown = excerpt(declaration, LONGEST);
    let mut words = declaration.split_ascii_whitespace();
    let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
        return Err(Error::invalid(place.location(), format!("{shown:?}"), "a parameter: \"type name\""));
    };
    let Some(kind) = Kind::of(kind) else {
        let expected = "a type: integer, float, point2, point3, vector2, vector3, normal, bool, string, texture, rgb, \
             xyz, blackbody or spectrum";
        return Err(Error::invalid(place.location(), format!("parameter {shown:?}"), expected));
    };
    let values = values(lexer, kind, &shown)?;
    let numbers = match &values {
        Values::Numbers(numbers) => numbers.len(),
        Values::Places(numbers) => numbers.len(),
        _ => 0,
    };
    if !numbers.is_multiple_of(kind.width()) {
        let found = format!("{numbers} numbers for parameter {shown:?}");
        let expected = format!("{} for each value", kind.width());
        return Err(Error::invalid(place.location(), found, expected));
    }
    let (name, used) = (name.to_owned(), Cell::new(false));
    Ok(Parameter { kind, name, values, declaration: shown, primaries, place, used })
}

/// The values after a declaration: one, or a list in brackets.
fn values(lexer: &mut Lexer<'_>, kind: Kind, declaration: &str) -> Result<Values> {
    let mut values = match kind {
        Kind::Integer => Values::Integers(Vec::new()),
        Kind::Boolean => Values::Booleans(Vec::new()),
        Kind::String | Kind::Texture => Values::Strings(Vec::new()),
        Kind::Spectrum if lexer.peek() == Some(b'"') => Values::Strings(Vec::new()),
        Kind::Point3 | Kind::Vector3 => Values::Places(Vec::new()),
        _ => Values::Numbers(Vec::new()),
    };
    let missing = |lexer: &Lexer<'_>, expected: &str| {
        let found = format!("the end of the file after parameter {declaration:?}");
        Error::invalid(lexer.place().location(), found, expected)
    };
    let mut token = lexer.next()?.ok_or_else(|| missing(lexer, "a value"))?;
    if token != Token::Open {
        push(&mut values, token, lexer, declaration)?;
        return Ok(values);
    }
    if kind == Kind::Spectrum && lexer.peek() == Some(b'"') {
        values = Values::Strings(Vec::new());
    }
    loop {
        token = lexer.next()?.ok_or_else(|| missing(lexer, "\"]\""))?;
        if token == Token::Close {
            return Ok(values);
        }
        push(&mut values, token, lexer, declaration)?;
    }
}

fn push(values: &mut Values, token: Token<'_>, lexer: &Lexer<'_>, declaration: &str) -> Result<()> {
    let expected = match (&mut *values, token) {
        (Values::Numbers(list), Token::Word(word)) => {
            if let Some(value) = number(word) {
                list.push(value);
                return Ok(());
            }
            "a finite number"
        }
        (Values::Places(list), Token::Word(word)) => {
            if let Some(value) = wide_number(word) {
                list.push(value);
                return Ok(());
            }
            "a finite number"
        }
        (Values::Integers(list), Token::Word(word)) => {
            if let Some(value) = integer(word) {
                list.push(value);
                return Ok(());
            }
            "a whole number of 32 bits"
        }
        (Values::Booleans(list), Token::Word(word) | Token::Quoted(word)) => {
            if let Some(value) = [&b"false"[..], b"true"].iter().position(|name| *name == word) {
                list.push(value == 1);
                return Ok(());
            }
            "true or false"
        }
        (Values::Strings(list), Token::Quoted(bytes)) => {
            list.push(unescape(bytes));
            return Ok(());
        }
        (Values::Numbers(_) | Values::Places(_), _) => "a number",
        (Values::Integers(_), _) => "a whole number",
        (Values::Booleans(_), _) => "true or false",
        (Values::Strings(_), _) => "a string",
    };
    let found = format!("{} for parameter {declaration:?}", token.shown());
    Err(Error::invalid(lexer.place().location(), found, expected))
}

#[cfg(test)]
mod tests {
    use super::super::place::Source;
    use super::*;

    fn read(text: &str) -> Result<Parameters> {
        let mut lexer = Lexer::new(text.as_bytes(), Source::new("a.pbrt".as_ref()));
        let place = lexer.place();
        Parameters::read(&mut lexer, Primaries::REC709, place)
    }

    #[test]
    fn values_are_found_by_name_and_type() {
        let p = read(
            "\"float fov\" 45 \"integer n\" [3 4] \"bool b\" \"true\" \"bool c\" false\n\
             \"string s\" [\"a b\"] \"point2 uv\" [0 1 2 3] \" vector  v\" [1 2 3] \"spectrum eta\" \"metal-Au-eta\" Next",
        )
        .unwrap();
        assert_eq!(
            (p.float("fov"), p.integer("fov"), p.integers("n")),
            (Some(45.0), None, Some(&[3, 4][..]))
        );
        assert_eq!((p.boolean("b"), p.boolean("c"), p.string("s")), (Some(true), Some(false), Some("a b")));
        assert_eq!(p.pairs("uv"), [Vec2::new(0.0, 1.0), Vec2::new(2.0, 3.0)]);
        assert_eq!(p.unused().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["v", "eta"]);
        assert_eq!(p.vector("v"), Some(DVec3::new(1.0, 2.0, 3.0)));
        assert_eq!(p.find(&[Kind::Spectrum], "eta").unwrap().strings(), ["metal-Au-eta"]);
        assert_eq!(p.unused().count(), 0);
    }

    #[test]
    fn the_last_of_several_holds_and_defaults_give_way() {
        let mut p = read("\"float x\" 1 \"float x\" 2").unwrap();
        p.extend_defaults(&read("\"float x\" 3 \"float y\" 4 \"float z\" 5").unwrap().into_list());
        assert_eq!((p.float("x"), p.float("y"), p.unused().count()), (Some(2.0), Some(4.0), 0));
    }

    #[test]
    fn what_cannot_be_read_is_an_error_with_its_place() {
        for (text, error) in [
            ("\"float\" 1", "a.pbrt:1:1: \"float\"; expected a parameter"),
            ("\"flaot x\" 1", "a.pbrt:1:1: parameter \"flaot x\"; expected a type"),
            (
                "\"float x\" [1\n nan]",
                "a.pbrt:2:2: \"nan\" for parameter \"float x\"; expected a finite number",
            ),
            ("\"float x\"", "a.pbrt:1:10: the end of the file after parameter \"float x\"; expected a value"),
            (
                "\"float x\" [1",
                "a.pbrt:1:13: the end of the file after parameter \"float x\"; expected \"]\"",
            ),
            ("\"rgb x\" [1 2]", "a.pbrt:1:1: 2 numbers for parameter \"rgb x\"; expected 3 for each value"),
            ("\"bool x\" 1", "a.pbrt:1:10: \"1\" for parameter \"bool x\"; expected true or false"),
            (
                "\"integer x\" 1e10",
                "a.pbrt:1:13: \"1e10\" for parameter \"integer x\"; expected a whole number of",
            ),
            ("\"string x\" 1", "a.pbrt:1:12: \"1\" for parameter \"string x\"; expected a string"),
            ("\"float x\" [[1]]", "a.pbrt:1:12: \"[\" for parameter \"float x\"; expected a number"),
        ] {
            let found = read(text).unwrap_err().to_string();
            assert!(found.starts_with(error), "{found}");
        }
    }
}
