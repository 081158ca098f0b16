//! Transforms of `xform`.
//!
//! | option | map |
//! |---|---|
//! | `-t x y z` | translation (m) |
//! | `-rx a`, `-ry a`, `-rz a` | rotation about an axis by `a` degrees, right-handed |
//! | `-s f` | scale by `f`; a negative `f` also mirrors |
//! | `-mx`, `-my`, `-mz` | mirrors one coordinate |
//! | `-i n` | applies the options that follow, up to the next `-i` or `-a`, `n` times |
//! | `-a n` | `n` copies: `-i 0` to `-i n−1` |
//!
//! Options are applied in the order in which they are written: `p ↦ Tₙ … T₂ T₁ p`. Arrays nest: the
//! copies of a second `-a` are made of each copy of the first. Every map is a similarity. Quarter
//! turns are exact.
//!
//! Source: manual page xform(1) of Radiance. Held to this by the tests below, whose points were
//! also compared with the program.

use glam::{DAffine3, DMat3, DVec3};

use crate::error::{Error, Location, Result};
use crate::io::notes::quoted;
use crate::math::elementary::sin_cos_f64;

/// Largest absolute number of an option: products of a few stay in the range of numbers.
const MAX_NUMBER: f64 = 1e15;

/// Largest number of repetitions and of copies of one array.
const MAX_COPIES: f64 = 1e9;

/// A similarity: rotation, uniform scale, reflection and translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Similarity {
    pub(super) map: DAffine3,
    /// Factor on lengths, above 0.
    pub(super) scale: f64,
}

impl Similarity {
    pub(super) const IDENTITY: Self = Self { map: DAffine3::IDENTITY, scale: 1.0 };

    fn new(matrix: DMat3, translation: DVec3, scale: f64) -> Self {
        Self { map: DAffine3 { matrix3: matrix, translation }, scale }
    }

    /// Map that applies `self` first and `next` to the result.
    pub(super) fn then(&self, next: &Self) -> Self {
        Self { map: next.map * self.map, scale: self.scale * next.scale }
    }

    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        self.map.transform_point3(point)
    }

    /// The direction of a vector after the map, with the length of the vector.
    pub(super) fn direction(&self, vector: DVec3) -> DVec3 {
        self.map.transform_vector3(vector) / self.scale
    }

    /// Returns true if the map turns left hands into right hands.
    pub(super) fn mirrors(&self) -> bool {
        self.map.matrix3.determinant() < 0.0
    }
}

/// Part of a list of options: a map, applied a number of times, or as often as the copy's number.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    map: Similarity,
    repeats: Repeats,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Repeats {
    Times(u64),
    Copies(u64),
}

/// Options of one call of `xform`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Transforms {
    /// Parts that are finished, and the one that options are added to.
    parts: Vec<Part>,
}

impl Default for Transforms {
    fn default() -> Self {
        Self { parts: vec![Part { map: Similarity::IDENTITY, repeats: Repeats::Times(1) }] }
    }
}

impl Transforms {
    /// Reads one option at the start of `words`. Returns the number of words that belong to it; 0
    /// if it is no transform.
    ///
    /// # Errors
    /// [`Error::Invalid`] for numbers that are missing or out of range.
    pub(super) fn option(&mut self, words: &[String], at: &Location) -> Result<usize> {
        let Some(option) = words.first() else { return Ok(0) };
        let number = |k: usize| number(words, k, at);
        let count = |what: &str| {
            let n = number(1)?;
            let whole = n.fract() == 0.0 && (0.0..=MAX_COPIES).contains(&n);
            let expected = format!("{what}, 0 to {MAX_COPIES}");
            if whole {
                Ok(n as u64)
            } else {
                Err(Error::invalid(at.clone(), format!("{option} {n}"), expected))
            }
        };
        let (map, taken) = match option.as_str() {
            "-t" => {
                let by = DVec3::new(number(1)?, number(2)?, number(3)?);
                (Similarity::new(DMat3::IDENTITY, by, 1.0), 4)
            }
            "-rx" => (rotation(0, number(1)?), 2),
            "-ry" => (rotation(1, number(1)?), 2),
            "-rz" => (rotation(2, number(1)?), 2),
            "-s" => {
                let factor = number(1)?;
                if factor.abs() < 1.0 / MAX_NUMBER {
                    let found = format!("-s {factor}");
                    return Err(Error::invalid(at.clone(), found, "a scale other than 0"));
                }
                let matrix = DMat3::from_diagonal(DVec3::splat(factor));
                (Similarity::new(matrix, DVec3::ZERO, factor.abs()), 2)
            }
            "-mx" => (mirror(DVec3::new(-1.0, 1.0, 1.0)), 1),
            "-my" => (mirror(DVec3::new(1.0, -1.0, 1.0)), 1),
            "-mz" => (mirror(DVec3::new(1.0, 1.0, -1.0)), 1),
            "-i" => {
                let times = count("a number of repetitions")?;
                self.parts.push(Part { map: Similarity::IDENTITY, repeats: Repeats::Times(times) });
                return Ok(2);
            }
            "-a" => {
                let copies = count("a number of copies")?;
                self.parts.push(Part { map: Similarity::IDENTITY, repeats: Repeats::Copies(copies) });
                return Ok(2);
            }
            _ => return Ok(0),
        };
        if let Some(last) = self.parts.last_mut() {
            last.map = last.map.then(&map);
        }
        Ok(taken)
    }

    /// Number of copies that the arrays make.
    pub(super) fn copies(&self) -> u64 {
        self.arrays().fold(1, u64::saturating_mul)
    }

    fn arrays(&self) -> impl Iterator<Item = u64> + '_ {
        self.parts.iter().filter_map(|part| match part.repeats {
            Repeats::Copies(n) => Some(n),
            Repeats::Times(_) => None,
        })
    }

    /// Map of a copy by its number, below [`Self::copies`], and the copy's numbers in the arrays,
    /// separated by points. Without arrays the text is empty. The number in the last array changes
    /// fastest.
    pub(super) fn copy(&self, number: u64) -> (Similarity, String) {
        let sizes: Vec<u64> = self.arrays().collect();
        let mut numbers = vec![0; sizes.len()];
        let mut rest = number;
        for (digit, size) in numbers.iter_mut().zip(&sizes).rev() {
            *digit = rest % size.max(&1);
            rest /= size.max(&1);
        }
        let mut digits = numbers.iter();
        let mut total = Similarity::IDENTITY;
        for part in &self.parts {
            let times = match part.repeats {
                Repeats::Times(times) => times,
                Repeats::Copies(_) => digits.next().copied().unwrap_or(0),
            };
            total = total.then(&power(part.map, times));
        }
        let digits: Vec<String> = numbers.iter().map(u64::to_string).collect();
        (total, digits.join("."))
    }
}

/// A map applied `times` times, by repeated squaring.
fn power(map: Similarity, times: u64) -> Similarity {
    let (mut total, mut square, mut rest) = (Similarity::IDENTITY, map, times);
    while rest > 0 {
        if rest & 1 == 1 {
            total = total.then(&square);
        }
        square = square.then(&square);
        rest >>= 1;
    }
    total
}

fn number(words: &[String], k: usize, at: &Location) -> Result<f64> {
    let word = words.get(k).map_or("", String::as_str);
    let value = word.parse::<f64>().ok().filter(|v| v.abs() <= MAX_NUMBER);
    value.ok_or_else(|| {
        let found = if word.is_empty() { "no number".to_owned() } else { quoted(word) };
        let expected = format!("number {k} of xform's {}, at most {MAX_NUMBER:e}", words[0]);
        Error::invalid(at.clone(), found, expected)
    })
}

fn mirror(diagonal: DVec3) -> Similarity {
    Similarity::new(DMat3::from_diagonal(diagonal), DVec3::ZERO, 1.0)
}

/// Rotation about a coordinate axis by an angle in degrees.
fn rotation(axis: usize, degrees: f64) -> Similarity {
    let turn = degrees.rem_euclid(360.0);
    let (sin, cos) = if turn % 90.0 == 0.0 {
        [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(turn / 90.0) as usize % 4]
    } else {
        sin_cos_f64(turn.to_radians())
    };
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut columns = [DVec3::ZERO; 3];
    columns[axis][axis] = 1.0;
    (columns[next][next], columns[next][last]) = (cos, sin);
    (columns[last][next], columns[last][last]) = (-sin, cos);
    let [x, y, z] = columns;
    Similarity::new(DMat3::from_cols(x, y, z), DVec3::ZERO, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transforms(text: &str) -> Result<Transforms> {
        let words: Vec<String> = text.split(' ').map(str::to_owned).collect();
        let (mut transforms, mut k) = (Transforms::default(), 0);
        while k < words.len() {
            let taken = transforms.option(&words[k..], &Location::line("a.rad", 3))?;
            assert!(taken > 0, "{}", words[k]);
            k += taken;
        }
        Ok(transforms)
    }

    /// Places of the point (1, 0, 0) in all copies, with the names of the copies.
    fn places(text: &str) -> Vec<(DVec3, String)> {
        let transforms = transforms(text).unwrap();
        let place = |k| {
            let (map, name) = transforms.copy(k);
            (map.point(DVec3::X), name)
        };
        (0..transforms.copies()).map(place).collect()
    }

    fn at(text: &str) -> DVec3 {
        let all = places(text);
        assert_eq!((all.len(), all[0].1.as_str()), (1, ""), "{text}");
        all[0].0
    }

    #[test]
    fn options_are_applied_in_the_order_in_which_they_are_written() {
        let v = DVec3::new;
        assert_eq!(at("-t 1 2 3"), v(2.0, 2.0, 3.0));
        assert_eq!(at("-s 2 -t 1 0 0"), v(3.0, 0.0, 0.0));
        assert_eq!(at("-t 1 0 0 -s 2"), v(4.0, 0.0, 0.0));
        assert_eq!(at("-rz 90"), v(0.0, 1.0, 0.0));
        assert_eq!(at("-ry 90"), v(0.0, 0.0, -1.0));
        assert_eq!(at("-rz 90 -rx 90"), v(0.0, 0.0, 1.0));
        assert_eq!(at("-mx -t 0 0 1"), v(-1.0, 0.0, 1.0));
        assert_eq!(at("-s -2"), v(-2.0, 0.0, 0.0));
        assert!((at("-rz 30") - v(0.75_f64.sqrt(), 0.5, 0.0)).length() < 1e-15);
    }

    #[test]
    fn repetitions_apply_to_the_options_up_to_the_next_one() {
        // The points are those of the program xform.
        assert_eq!(at("-t 1 0 0 -i 2 -s 2 -rz 90"), DVec3::new(-8.0, 0.0, 0.0));
        assert_eq!(at("-i 0 -t 1 0 0"), DVec3::X);
        assert_eq!(at("-i 3 -t 1 0 0 -i 1 -t 0 5 0"), DVec3::new(4.0, 5.0, 0.0));
        assert_eq!(at("-i 1000000000 -t 0.5 0 0").x, 5e8 + 1.0);
    }

    #[test]
    fn arrays_count_their_copies_from_zero_and_nest() {
        let of = |text: &str| -> Vec<([f64; 3], String)> {
            places(text).into_iter().map(|(p, name)| (p.to_array(), name)).collect()
        };
        let row = |p: [f64; 3], name: &str| (p, name.to_owned());
        assert_eq!(of("-s 2 -a 2 -t 1 0 0 -rz 90"), [row([2.0, 0.0, 0.0], "0"), row([0.0, 3.0, 0.0], "1")]);
        assert_eq!(
            of("-rz 90 -a 2 -t 0 0 1 -a 2 -t 10 0 0 -i 1 -s 2"),
            [
                row([0.0, 2.0, 0.0], "0.0"),
                row([20.0, 2.0, 0.0], "0.1"),
                row([0.0, 2.0, 2.0], "1.0"),
                row([20.0, 2.0, 2.0], "1.1")
            ]
        );
        assert!(places("-a 0 -t 1 0 0").is_empty());
        assert_eq!(transforms("-a 1000000000 -a 1000000000 -a 1000000000").unwrap().copies(), u64::MAX);
    }

    #[test]
    fn lengths_and_handedness_are_known() {
        let (map, _) = transforms("-s -2 -mx -mz -rx 10 -s 3").unwrap().copy(0);
        assert!((map.scale - 6.0).abs() < 1e-12 && map.mirrors());
        assert!(!transforms("-mx -mz").unwrap().copy(0).0.mirrors());
        assert!((map.direction(DVec3::Y).length() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn numbers_are_checked() {
        for (text, found) in [
            ("-t 1 2", "a.rad:3: no number; expected number 3 of xform's -t"),
            ("-t 1 2 x", "\"x\"; expected number 3"),
            ("-rx nan", "\"nan\""),
            ("-s 0", "-s 0; expected a scale other than 0"),
            ("-s 1e99", "\"1e99\""),
            ("-i -1", "-i -1; expected a number of repetitions"),
            ("-a 1.5", "-a 1.5; expected a number of copies"),
        ] {
            let error = transforms(text).unwrap_err().to_string();
            assert!(error.contains(found), "{error}");
        }
        assert_eq!(Transforms::default().option(&["-n".to_owned()], &Location::default()).unwrap(), 0);
    }
}
