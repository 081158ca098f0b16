//! Photometric data of lamps: IES files (LM-63 of 1986 to 2019), photometry of type C, and the map
//! of [`eulumdat`](super::eulumdat) files.
//!
//! A file gives the luminous intensity at a grid of angles: vertical angles `γ` from straight down
//! (0°) to straight up (180°), and horizontal angles `C`. For symmetric lamps, files list only half
//! or a quarter of the horizontal angles, or a single one. Between the angles, intensities are
//! interpolated linearly; beyond the vertical angles of the file, they are 0. The intensities are
//! stored in a latitude-longitude map of [`SIZE`] texels, with one row for each half degree. Finer
//! detail is lost. In the map's frame `+y` is up, and `C` grows from 0° at `+x` towards `−z`,
//! counterclockwise as seen from above.
//!
//! Intensities in candela are taken as W·sr⁻¹ and multiplied by the file's multiplier and ballast
//! factors. The factor between the units is the same for all lights and is left to exposure.
//!
//! # Limits
//! The size of the luminaire is ignored: it becomes a point light. Losses by the tilt of a lamp are
//! ignored as well. Photometry of types A and B is refused.
//!
//! # Guarantee
//! Any bytes give a map or an error; memory is proportional to the bytes that are there. Held to
//! this by the tests below.

use std::path::Path;

use super::eulumdat;
use crate::error::{Error, Location, Result};
use crate::scene::{Image, IntensityMap, Lookup, Pixels, Sampling, SphereMap, Spread, Wrap};

/// Columns and rows of the map.
pub const SIZE: [u32; 2] = [360, 360];

/// Intensities (cd) at a grid of angles (degrees).
#[derive(Debug, PartialEq)]
pub(super) struct Photometry {
    pub(super) vertical: Vec<f32>,
    pub(super) horizontal: Vec<f32>,
    /// Row by row, one row for each horizontal angle.
    pub(super) candela: Vec<f32>,
}

/// The map of an IES file, or of an EULUMDAT file if the name ends in `.ldt`; none if it is dark.
///
/// # Errors
/// [`Error::Invalid`] with the place if the bytes are no photometry of type C.
pub(super) fn decode(bytes: &[u8], name: &str, at: &Location) -> Result<Option<IntensityMap>> {
    let is_eulumdat = Path::new(name).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ldt"));
    let photometry = if is_eulumdat { eulumdat::parse(bytes, at)? } else { parse(bytes, at)? };
    let [width, height] = SIZE;
    let texel = |i: u32| {
        let azimuth = ((i % width) as f32 + 0.5) * 360.0 / width as f32;
        let polar = ((i / width) as f32 + 0.5) * 180.0 / height as f32;
        // In latitude-longitude maps, +x is at three quarters of the width, −z at a half.
        [photometry.at(180.0 - polar, (azimuth + 90.0) % 360.0); 3]
    };
    let pixels = Pixels::Float((0..width * height).map(texel).collect());
    let image = Image { name: name.to_owned(), width, height, pixels };
    let lookup = Lookup { sampling: Sampling::Bilinear, wrap: [Wrap::Repeat, Wrap::Clamp] };
    Ok(IntensityMap::new(image, Spread::Sphere(SphereMap::LatLong), lookup))
}

impl Photometry {
    /// The intensity (cd) at the vertical angle `gamma` and the horizontal angle `column`
    /// (degrees). `column` grows with the map's columns, opposite to `C`.
    pub(super) fn at(&self, gamma: f32, column: f32) -> f32 {
        // `column` is 0 at +x, which is at 270° of the map, and grows towards +z, opposite to `C`.
        let c = (360.0 - column).rem_euclid(360.0);
        let (first, last) = (self.horizontal[0], self.horizontal[self.horizontal.len() - 1]);
        let mirrored = |c: f32, about: f32| if c > about { 2.0 * about - c } else { c };
        let c = match (first, last) {
            _ if self.horizontal.len() == 1 => first,
            (0.0, 90.0) => mirrored(mirrored(c, 180.0), 90.0),
            (0.0, 180.0) => mirrored(c, 180.0),
            // Symmetric with respect to the plane from 90° to 270°.
            (90.0, 270.0) => {
                if c < 90.0 {
                    180.0 - c
                } else if c > 270.0 {
                    540.0 - c
                } else {
                    c
                }
            }
            _ => c,
        };
        let Some((row, across)) = interval(&self.horizontal, c) else { return 0.0 };
        let Some((column, along)) = interval(&self.vertical, gamma) else { return 0.0 };
        let value = |row: usize, column: usize| {
            let (row, column) = (row.min(self.horizontal.len() - 1), column.min(self.vertical.len() - 1));
            self.candela[row * self.vertical.len() + column]
        };
        let of_row = |row: usize| {
            let (a, b) = (value(row, column), value(row, column + 1));
            a + (b - a) * along
        };
        let (a, b) = (of_row(row), of_row(row + 1));
        (a + (b - a) * across).max(0.0)
    }
}

/// Index of the last angle that is not above `x`, and the fraction of the way from it to the next
/// angle; none if `x` is outside the range of the angles.
fn interval(angles: &[f32], x: f32) -> Option<(usize, f32)> {
    if angles.len() == 1 {
        return Some((0, 0.0));
    }
    let next = angles.partition_point(|a| *a <= x);
    if next == angles.len() {
        return (x <= angles[next - 1]).then_some((next - 1, 0.0));
    }
    let before = next.checked_sub(1)?;
    Some((before, (x - angles[before]) / (angles[next] - angles[before])))
}

/// Numbers of a text, each with its line.
struct Numbers<'t> {
    words: Box<dyn Iterator<Item = (u32, &'t str)> + 't>,
    at: &'t Location,
    line: u32,
}

impl Numbers<'_> {
    fn next(&mut self, what: &str) -> Result<f32> {
        let Some((line, word)) = self.words.next() else {
            return Err(self.wrong("the end of the file", what));
        };
        self.line = line;
        let number = word.parse::<f32>().ok().filter(|v| v.is_finite());
        number.ok_or_else(|| {
            let shown: String = word.chars().take(20).collect();
            self.wrong(format!("{shown:?}"), what)
        })
    }

    fn count(&mut self, what: &str) -> Result<u32> {
        let number = self.next(what)?;
        let is_count = number.fract() == 0.0 && (1.0..=1e6).contains(&number);
        if is_count { Ok(number as u32) } else { Err(self.wrong(number.to_string(), what)) }
    }

    /// Reads `count` angles, each above the one before.
    fn angles(&mut self, count: u32, what: &str) -> Result<Vec<f32>> {
        let mut angles: Vec<f32> = Vec::new();
        for _ in 0..count {
            let angle = self.next(what)?;
            if angles.last().is_some_and(|last| angle <= *last) || !(0.0..=360.0).contains(&angle) {
                return Err(self.wrong(angle.to_string(), &format!("{what} that rise from 0 to 360")));
            }
            angles.push(angle);
        }
        Ok(angles)
    }

    fn wrong(&self, found: impl Into<String>, expected: &str) -> Error {
        let Location { file, .. } = self.at;
        Error::invalid(Location::line(file.clone(), self.line), found, expected)
    }
}

fn parse(bytes: &[u8], at: &Location) -> Result<Photometry> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = (1..).zip(text.lines());
    let tilt = lines.by_ref().find_map(|(line, text)| Some((line, text.trim().strip_prefix("TILT=")?)));
    let Some((line, tilt)) = tilt else {
        return Err(Error::invalid(at.clone(), "no line TILT=", "an IES file (LM-63)"));
    };
    let words = lines.flat_map(|(line, text)| {
        let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
        words.map(move |word| (line, word))
    });
    let mut numbers = Numbers { words: Box::new(words), at, line };
    match tilt.trim() {
        "NONE" => {}
        "INCLUDE" => {
            numbers.next("the geometry of the lamp")?;
            let pairs = numbers.count("the number of tilts, 1 to 1000000")?;
            for _ in 0..2 * pairs {
                numbers.next("a tilt or its factor")?;
            }
        }
        _ => return Err(numbers.wrong("TILT= with a file", "TILT=NONE or TILT=INCLUDE")),
    }
    numbers.next("the number of lamps")?;
    numbers.next("lumens of each lamp")?;
    let multiplier = numbers.next("the multiplier of candela")?;
    let vertical = numbers.count("the number of vertical angles, 1 to 1000000")?;
    let horizontal = numbers.count("the number of horizontal angles, 1 to 1000000")?;
    let kind = numbers.next("the type of photometry")?;
    if kind != 1.0 {
        return Err(numbers.wrong(format!("photometry of type {kind}"), "1: type C"));
    }
    for what in ["the unit of length", "the width", "the length", "the height"] {
        numbers.next(what)?;
    }
    let ballast = numbers.next("the ballast factor")?;
    let photometric = numbers.next("the ballast-lamp factor, or 1")?;
    numbers.next("the input in watts")?;
    let factor = multiplier * ballast * photometric;
    let vertical = numbers.angles(vertical, "vertical angles")?;
    if vertical.iter().any(|angle| *angle > 180.0) {
        return Err(numbers.wrong("vertical angles above 180", "0 to 180"));
    }
    let horizontal = numbers.angles(horizontal, "horizontal angles")?;
    let mut candela = Vec::new();
    for _ in 0..vertical.len() * horizontal.len() {
        let value = numbers.next("candela")? * factor;
        if !(value >= 0.0 && value.is_finite()) {
            return Err(numbers.wrong(value.to_string(), "candela of at least 0"));
        }
        candela.push(value);
    }
    Ok(Photometry { vertical, horizontal, candela })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at() -> Location {
        Location::file("lamp.ies")
    }

    fn file(angles: &str, candela: &str) -> String {
        let counts = format!(
            "{} {}",
            angles.lines().next().unwrap().split(' ').count(),
            angles.lines().nth(1).unwrap().split(' ').count()
        );
        format!(
            "IESNA:LM-63-2002\n[TEST] x\nTILT=NONE\n1 1000 2 {counts} 1 2 0 0 0\n0.5 1 60\n{angles}\n{candela}\n"
        )
    }

    #[test]
    fn intensities_are_interpolated_and_lamps_are_as_symmetric_as_they_say() {
        let of = |horizontal: &str, candela: &str| {
            parse(file(&format!("0 45 90\n{horizontal}"), candela).as_bytes(), &at()).unwrap()
        };
        // The horizontal angle of `at` grows with the map's columns, opposite to C.
        let read = |p: &Photometry, gamma: f32, c: f32| p.at(gamma, 360.0 - c);
        let round = of("0", "10 8 0");
        for c in [0.0, 77.0, 359.0] {
            assert_eq!([0.0, 22.5, 67.5, 90.0, 91.0].map(|g| read(&round, g, c)), [10.0, 9.0, 4.0, 0.0, 0.0]);
        }
        let quarter = of("0 90", "10 8 0,\n20 18 10");
        for c in [30.0, 150.0, 210.0, 330.0] {
            assert!((read(&quarter, 0.0, c) - 10.0 - 10.0 / 3.0).abs() < 1e-4, "{c}");
        }
        let half = of("0 180", "10 10 10 19 19 19");
        assert!(
            [(20.0, 11.0), (340.0, 11.0), (160.0, 18.0), (200.0, 18.0)].iter().all(|(c, v)| (read(
                &half, 0.0, *c
            ) - v)
                .abs()
                < 1e-4)
        );
        let other_half = of("90 270", "10 10 10 19 19 19");
        assert!(
            [(110.0, 11.0), (70.0, 11.0), (250.0, 18.0), (290.0, 18.0), (0.0, 14.5)]
                .iter()
                .all(|(c, v)| (read(&other_half, 0.0, *c) - v).abs() < 1e-4)
        );
        let whole = of("0 90 180 270 360", "1 1 1 2 2 2 3 3 3 4 4 4 1 1 1");
        assert_eq!([0.0, 45.0, 180.0, 315.0].map(|c| read(&whole, 10.0, c)), [1.0, 1.5, 3.0, 2.5]);
    }

    /// A lamp of constant intensity 1 in the lower hemisphere must have `∫ I dω` = 2π. A lamp with
    /// different intensities at `C` = 0°, 90°, 180° and 270° must have them at `+x`, `−z`, `−x` and
    /// `+z`.
    #[test]
    fn the_map_has_the_power_and_the_axes_of_the_file() {
        let bytes = file("0 90\n0", "1 1");
        let map = decode(bytes.as_bytes(), "lamp", &at()).unwrap().unwrap();
        assert!((map.integral().g / (2.0 * std::f32::consts::PI) - 1.0).abs() < 1e-3, "{:?}", map.integral());
        let bytes = file("0 90 180\n0 90 180 270 360", "1 1 1 2 2 2 3 3 3 4 4 4 1 1 1");
        let map = std::sync::Arc::new(decode(bytes.as_bytes(), "lamp", &at()).unwrap().unwrap());
        let mut builder = crate::scene::SceneBuilder::new("s", at());
        let white = crate::color::Rgb::WHITE;
        builder.add_image_light(&map, glam::Vec3::ZERO, white, glam::Mat3::IDENTITY).unwrap();
        let scene = builder.build().unwrap();
        let of = |x: f32, z: f32| {
            let d = glam::Vec3::new(x, 0.1, z).normalize();
            scene.intensity_maps()[0].relative(d).r * map.brightest().r
        };
        // C = 0 is +x, 90 is −z, 180 is −x, 270 is +z.
        let found = [of(1.0, 0.0), of(0.0, -1.0), of(-1.0, 0.0), of(0.0, 1.0)];
        assert!(found.iter().zip([1.0, 2.0, 3.0, 4.0]).all(|(a, b)| (a - b).abs() < 0.02), "{found:?}");
    }

    #[test]
    fn what_is_no_photometry_is_refused_with_its_line() {
        let message = |text: &str| parse(text.as_bytes(), &at()).unwrap_err().to_string();
        let good = file("0 90\n0", "1 1");
        for (damaged, expected) in [
            (String::new(), "no line TILT="),
            (good.replace("TILT=NONE", "TILT=lamp.txt"), "lamp.ies:3: TILT= with a file"),
            (good.replace("2 1 1 2 0", "2 1 3 2 0"), "photometry of type 3"),
            (good.replace("2 1 1 2 0", "2 4000000000 1 2 0"), "4000000000"),
            (good.replace("2 1 1 2 0", "2 900000 1 2 0"), "horizontal angles"),
            (good.replace("0 90\n", "90 0\n"), "that rise"),
            (good.replace("1 1\n", "1 -1\n"), "candela of at least 0"),
            (good.replace("1 1\n", "1\n"), "the end of the file; expected candela"),
            (good.replace("1 1\n", "1 x\n"), "\"x\"; expected candela"),
            (good.replace("0.5 1 60", "nan 1 60"), "ballast factor"),
        ] {
            let said = message(&damaged);
            assert!(said.contains(expected), "{said}: {expected}");
        }
        // A file that is cut off anywhere gives a lamp or an error.
        for end in 0..good.len() {
            let _ = decode(&good.as_bytes()[..end], "lamp", &at());
        }
    }
}
