//! Texture statements of MTL files: `map_Kd -option arguments … file name`.
//!
//! Options come before the name, which is the rest of the line and may contain blanks; some
//! exporters put options after the name. The options `-s u v w` and `-o u v w` give the scale `s`
//! and the offset `o` in
//!
//! ```text
//! u′ = s_u u + o_u,   v′ = s_v v + o_v        (v up)
//! ```
//!
//! This is how exporters use the options. The specification describes the inverse scale, which no
//! exporter writes. With `ṽ = 1 − v`, which runs down, the second formula becomes
//! `ṽ′ = s_v ṽ + (1 − s_v − o_v)`, see [`Map::transform`].
//!
//! Tested by the tests below and `suite::obj::texture_options_*`.

use super::text::{name, number, split_keyword, trim, words};
use crate::io::textures::upward;
use crate::scene::{Channel, UvTransform, Wrap};

/// Line of a statement. All lines compare equal, so that statements compare by their contents
/// alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line(pub(super) u32);

impl PartialEq for Line {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A texture statement with its options.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// Name of the file, as it is written.
    pub(super) name: String,
    /// Line of the statement, from 1.
    pub(super) line: Line,
    /// `-o`.
    offset: [f32; 2],
    /// `-s`.
    scale: [f32; 2],
    /// `-clamp on`.
    clamp: bool,
    /// `-imfchan`, if it names a channel of an image.
    pub(super) channel: Option<Channel>,
    /// True if `-mm`, `-t`, `-bm`, `-boost` or `-cc` would change values; they are ignored.
    pub(super) modified: bool,
}

impl Map {
    /// Parses the text after the keyword; none if it has no name.
    pub(super) fn parse(rest: &[u8], line: u32) -> Option<Self> {
        let mut map = Self {
            name: String::new(),
            line: Line(line),
            offset: [0.0; 2],
            scale: [1.0; 2],
            clamp: false,
            channel: None,
            modified: false,
        };
        let mut rest = trim(rest);
        while let Some(after) = map.option(rest, true) {
            rest = after;
        }
        map.name = file_name(map.trailing_options(rest));
        (!map.name.is_empty()).then_some(map)
    }

    /// Reads one option with its arguments; returns the text after them, or none if there is no
    /// option.
    fn option<'a>(&mut self, text: &'a [u8], name_follows: bool) -> Option<&'a [u8]> {
        let (option, rest) = split_keyword(text);
        let (word, after_word) = split_keyword(rest);
        match option {
            b"-blendu" | b"-blendv" | b"-texres" | b"-type" | b"-colorspace" => {}
            b"-cc" => self.modified |= word.eq_ignore_ascii_case(b"on"),
            b"-clamp" => self.clamp = word.eq_ignore_ascii_case(b"on"),
            b"-imfchan" => {
                self.channel = match word {
                    b"r" | b"R" => Some(Channel::R),
                    b"g" | b"G" => Some(Channel::G),
                    b"b" | b"B" => Some(Channel::B),
                    b"m" | b"M" => Some(Channel::A),
                    _ => None,
                }
            }
            b"-bm" | b"-boost" => return Some(numbers(rest, 1, name_follows, |_, _| self.modified = true)),
            b"-mm" => {
                let mut range = [0.0, 1.0];
                let after = numbers(rest, 2, name_follows, |i, value| range[i] = value);
                self.modified |= range != [0.0, 1.0];
                return Some(after);
            }
            b"-t" => {
                return Some(numbers(rest, 3, name_follows, |_, value| self.modified |= value != 0.0));
            }
            b"-o" | b"-s" => {
                let target = if option == b"-o" { &mut self.offset } else { &mut self.scale };
                return Some(numbers(rest, 3, name_follows, |i, value| {
                    if let Some(slot) = target.get_mut(i) {
                        *slot = value;
                    }
                }));
            }
            _ => return None,
        }
        Some(after_word)
    }

    /// Reads options after the name, if they reach to the end of the text; returns the name.
    fn trailing_options<'a>(&mut self, text: &'a [u8]) -> &'a [u8] {
        let mut rest = split_keyword(text).1;
        while !rest.is_empty() {
            let start = text.len() - rest.len();
            let mut with_options = self.clone();
            let mut after = rest;
            while let Some(next) = with_options.option(after, false) {
                after = next;
            }
            if after.is_empty() {
                *self = with_options;
                return trim(&text[..start]);
            }
            rest = split_keyword(after).1;
        }
        text
    }

    /// Transform of coordinates that run down.
    pub(super) fn transform(&self) -> UvTransform {
        upward(self.scale, self.offset)
    }

    /// Wrapping of coordinates outside `[0, 1]`.
    pub(super) fn wrap(&self) -> [Wrap; 2] {
        [if self.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2]
    }
}

/// Passes up to `most` leading numbers of `text` to `take` and returns the rest. If a name must
/// follow, at least one word is left for it. Numbers that are not finite are skipped.
fn numbers(text: &[u8], most: usize, name_follows: bool, mut take: impl FnMut(usize, f32)) -> &[u8] {
    let mut rest = text;
    for i in 0..most {
        let (word, after) = split_keyword(rest);
        let Some(value) = number(word) else { break };
        if name_follows && after.is_empty() {
            break;
        }
        if value.is_finite() {
            take(i, value);
        }
        rest = after;
    }
    rest
}

/// Name of a file, without quotation marks around it.
fn file_name(text: &[u8]) -> String {
    let inner = match text {
        [b'"', inner @ .., b'"'] => inner,
        _ => text,
    };
    if words(inner).next().is_none() { String::new() } else { name(inner) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Map {
        Map::parse(text.as_bytes(), 1).unwrap()
    }

    #[test]
    fn names_are_the_rest_of_the_line() {
        for (text, name) in [
            ("wood.png", "wood.png"),
            ("texture 01.png  ", "texture 01.png"),
            ("-bm 2 bump 01.png", "bump 01.png"),
            ("-imfchan r bumpmap2.jpg -bm 1.5", "bumpmap2.jpg"),
            ("a -b c.png -clamp on -s 1 2", "a -b c.png"),
            ("a -clamp on b.png", "a -clamp on b.png"),
            ("\"C:\\my textures\\a.png\"", "C:\\my textures\\a.png"),
            ("-s 1 1 1 a.png", "a.png"),
            ("-s 1 1 42", "42"),
            ("-o a.png", "a.png"),
            ("-blendu on -blendv off -cc on -texres 512 -type cube_top -colorspace sRGB -boost 2 x", "x"),
            ("-mm 0.1 0.3 spec.jpg", "spec.jpg"),
            ("-t 0.1 0.2 0.3 spec.jpg", "spec.jpg"),
            ("-5.png", "-5.png"),
        ] {
            assert_eq!(parse(text).name, name, "{text}");
        }
        for empty in ["", "  ", "-clamp on", "\"\"", "-s"] {
            assert_eq!(Map::parse(empty.as_bytes(), 1), None, "{empty:?}");
        }
    }

    #[test]
    fn options_mean_what_they_say() {
        let map = parse("-clamp on -imfchan m -o 0.25 -s 2 3 4 a.png");
        assert_eq!(
            (map.offset, map.scale, map.clamp, map.channel),
            ([0.25, 0.0], [2.0, 3.0], true, Some(Channel::A))
        );
        assert!(!map.modified && !parse("-mm 0 1 -t 0 0 -cc off a.png").modified);
        for changed in ["-mm 0 2 a", "-t 0 0.1 a", "-cc on a", "-bm 2 a", "-boost 1 a"] {
            assert!(parse(changed).modified, "{changed}");
        }
        assert_eq!(parse("-s nan 2 a").scale, [1.0, 2.0]);
    }

    #[test]
    fn a_long_line_of_options_takes_linear_time() {
        let text = "x ".to_owned() + &"-bm ".repeat(300_000) + "y -clamp on";
        assert!(parse(&text).clamp);
    }
}
