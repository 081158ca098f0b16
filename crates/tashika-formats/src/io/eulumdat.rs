//! Photometric data of lamps: EULUMDAT files (`.ldt`), as European makers of luminaires publish
//! them (Stockmar 1990).
//!
//! A file has one value a line. Intensities are stated in candela per 1000 lm, for planes `C` and
//! angles `γ` from straight down. They are multiplied by the luminous flux of the first set of
//! lamps and by the file's conversion factor. By the symmetry of the luminaire, a file lists only
//! some of its planes:
//!
//! | symmetry | planes in the file |
//! |---|---|
//! | 0, none | all |
//! | 1, about the vertical axis | one |
//! | 2, about the plane C0–C180 | from C0 to C180 |
//! | 3, about the plane C90–C270 | from C270 by C0 to C90 |
//! | 4, about both | from C0 to C90 |
//!
//! # Limits
//! As of [`ies`](super::ies): a luminaire is a point.
//!
//! # Held to this by
//! The tests below.

use super::ies::Photometry;
use super::text::{decoded, utf8_or_latin1};
use crate::error::{Error, Location, Result};

/// Most planes, and most angles of a plane.
const MAX_COUNTS: [usize; 2] = [721, 361];
/// Line of the number of sets of lamps, from 0, and lines of a set.
const SETS: usize = 25;
const LINES_OF_SET: usize = 6;
/// Lines of the direct ratios, which precede the angles.
const RATIOS: usize = 10;

/// Lines of a file, each with one value.
struct Lines<'t> {
    lines: Vec<&'t str>,
    at: &'t Location,
}

impl Lines<'_> {
    fn wrong(&self, line: usize, found: impl Into<String>, expected: &str) -> Error {
        Error::invalid(Location::line(self.at.file.clone(), line as u32 + 1), found, expected)
    }

    /// Number in a line, counted from 0; the decimal sign is a point or a comma.
    fn number(&self, line: usize, what: &str) -> Result<f32> {
        let Some(text) = self.lines.get(line) else {
            return Err(self.wrong(self.lines.len(), "the end of the file", what));
        };
        let number = text.trim().replace(',', ".").parse::<f32>().ok().filter(|v| v.is_finite());
        number.ok_or_else(|| {
            let shown: String = text.trim().chars().take(20).collect();
            self.wrong(line, format!("{shown:?}"), what)
        })
    }

    fn count(&self, line: usize, range: [usize; 2], what: &str) -> Result<usize> {
        let number = self.number(line, what)?;
        let [least, most] = range;
        let is_count = number.fract() == 0.0 && (least as f32..=most as f32).contains(&number);
        let expected = || format!("{what}, {least} to {most}");
        if is_count { Ok(number as usize) } else { Err(self.wrong(line, number.to_string(), &expected())) }
    }

    /// Rising angles (degrees) in consecutive lines.
    fn angles(&self, first: usize, count: usize, most: f32, what: &str) -> Result<Vec<f32>> {
        let mut angles: Vec<f32> = Vec::with_capacity(count.min(self.lines.len()));
        for line in first..first + count {
            let angle = self.number(line, what)?;
            if angles.last().is_some_and(|last| angle <= *last) || !(0.0..=most).contains(&angle) {
                let expected = format!("{what} that rise from 0 to {most}");
                return Err(self.wrong(line, angle.to_string(), &expected));
            }
            angles.push(angle);
        }
        Ok(angles)
    }
}

/// Reads the intensities of a file.
///
/// # Errors
/// [`Error::Invalid`] with the line of a value that is missing or out of range.
pub(super) fn parse(bytes: &[u8], at: &Location) -> Result<Photometry> {
    let bytes = decoded(bytes);
    let text = utf8_or_latin1(&bytes);
    let file = Lines { lines: text.lines().collect(), at };
    let symmetry = file.count(2, [0, 4], "a symmetry")?;
    let planes = file.count(3, [1, MAX_COUNTS[0]], "the number of planes")?;
    let angles = file.count(5, [1, MAX_COUNTS[1]], "the number of angles of a plane")?;
    let conversion = file.number(23, "the conversion factor of intensities")?;
    let sets = file.count(SETS, [1, 20], "the number of sets of lamps")?;
    let flux = file.number(SETS + 3, "the luminous flux of the lamps in lumen")?;
    let factor = conversion * flux / 1000.0;
    if !(factor >= 0.0 && factor.is_finite()) {
        return Err(file.wrong(
            SETS + 3,
            format!("a factor of {factor}"),
            "a flux and a conversion of at least 0",
        ));
    }
    let first = SETS + 1 + sets * LINES_OF_SET + RATIOS;
    let all = file.angles(first, planes, 360.0, "planes C")?;
    let vertical = file.angles(first + planes, angles, 180.0, "angles γ")?;
    let listed = match symmetry {
        1 => 1,
        2 | 3 => planes / 2 + 1,
        4 => planes / 4 + 1,
        _ => planes,
    };
    let first = first + planes + angles;
    let mut rows = Vec::with_capacity(listed.min(file.lines.len()));
    for plane in 0..listed {
        let mut row = Vec::with_capacity(angles);
        for angle in 0..angles {
            let line = first + plane * angles + angle;
            let value = file.number(line, "an intensity")? * factor;
            if !(value >= 0.0 && value.is_finite()) {
                return Err(file.wrong(line, value.to_string(), "an intensity of at least 0"));
            }
            row.push(value);
        }
        rows.push(row);
    }
    let horizontal = match symmetry {
        1 => vec![0.0],
        2 | 4 => all[..listed].to_vec(),
        3 => {
            // The plane C and the plane 180° − C are equal: the planes from C270 by C0 to C90 are
            // those from C270 down to C90.
            rows.reverse();
            let step = 180.0 / (listed - 1).max(1) as f32;
            (0..listed).map(|k| 90.0 + k as f32 * step).collect()
        }
        _ => {
            // The first plane closes the circle.
            rows.extend(rows.first().cloned());
            all.iter().copied().chain([360.0]).collect()
        }
    };
    let ends = [horizontal[0], horizontal[horizontal.len() - 1]];
    let expected = match symmetry {
        2 => [0.0, 180.0],
        4 => [0.0, 90.0],
        _ => ends,
    };
    if ends != expected || (symmetry == 0 && all[planes - 1] >= 360.0) {
        let found = format!("planes from {} to {} with symmetry {symmetry}", ends[0], ends[1]);
        return Err(file.wrong(2, found, "evenly spaced planes below 360"));
    }
    Ok(Photometry { vertical, horizontal, candela: rows.concat() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with planes every `360 / planes` degrees, the angles 0, 90 and 180, and one lamp of
    /// 2000 lm. The intensity of listed plane `k` is `value(k)` cd per 1000 lm at all angles.
    fn file(symmetry: usize, planes: usize, value: impl Fn(usize) -> f32) -> String {
        let step = 360.0 / planes as f32;
        let mut lines: Vec<String> = ["maker", "1"].map(str::to_owned).to_vec();
        lines.extend([symmetry.to_string(), planes.to_string(), step.to_string(), "3".into(), "90".into()]);
        lines.extend(["report", "lamp", "7", "lamp.ldt", "today"].map(str::to_owned));
        lines.extend(["600"; 9].map(str::to_owned));
        lines.extend(["100", "80", "1,0", "0", "1"].map(str::to_owned));
        lines.extend(["1", "LED", "2000", "4000 K", "80", "20"].map(str::to_owned));
        lines.extend(["0.5"; RATIOS].map(str::to_owned));
        lines.extend((0..planes).map(|k| (k as f32 * step).to_string()));
        lines.extend(["0", "90", "180"].map(str::to_owned));
        let listed = [planes, 1, planes / 2 + 1, planes / 2 + 1, planes / 4 + 1][symmetry];
        lines.extend(
            (0..listed).flat_map(|k| [value(k).to_string(), value(k).to_string(), value(k).to_string()]),
        );
        lines.join("\r\n")
    }

    fn read(text: &str) -> Result<Photometry> {
        parse(text.as_bytes(), &Location::file("lamp.ldt"))
    }

    /// Intensity at a plane `C` (cd), horizontally.
    fn at(photometry: &Photometry, c: f32) -> f32 {
        photometry.at(90.0, 360.0 - c)
    }

    /// Each symmetry gives the intensities of the planes that the file leaves out.
    #[test]
    fn planes_that_are_left_out_follow_from_the_symmetry() {
        // Of 8 planes, the intensity of plane k is 100 (k + 1) cd per 1000 lm, and the flux 2000
        // lm.
        let value = |k: usize| 100.0 * (k + 1) as f32;
        let none = read(&file(0, 8, value)).unwrap();
        for k in 0..8 {
            assert!((at(&none, 45.0 * k as f32) - 2.0 * value(k)).abs() < 0.1, "{k}");
        }
        assert!((at(&none, 337.5) - 0.5 * (2.0 * value(7) + 2.0 * value(0))).abs() < 0.1, "across C360");
        let axis = read(&file(1, 8, value)).unwrap();
        assert!([0.0, 77.0, 300.0].iter().all(|c| at(&axis, *c) == 200.0));
        let about_0 = read(&file(2, 8, value)).unwrap();
        assert!((at(&about_0, 45.0) - 400.0).abs() < 0.1 && (at(&about_0, 315.0) - 400.0).abs() < 0.1);
        let both = read(&file(4, 8, value)).unwrap();
        for c in [45.0, 135.0, 225.0, 315.0] {
            assert!((at(&both, c) - 400.0).abs() < 0.1, "{c}");
        }
        // From C270 (k = 0) by C0 (k = 2) to C90 (k = 4).
        let about_90 = read(&file(3, 8, value)).unwrap();
        for (c, k) in [(270.0, 0), (315.0, 1), (0.0, 2), (45.0, 3), (90.0, 4), (135.0, 3), (225.0, 1)] {
            assert!((at(&about_90, c) - 2.0 * value(k)).abs() < 0.1, "{c}: {}", at(&about_90, c));
        }
    }

    /// Damaged files are refused with the line of the fault.
    #[test]
    fn faults_are_reported_with_their_line() {
        let good = file(0, 4, |_| 10.0);
        let change = |line: usize, word: &str| {
            let mut lines: Vec<&str> = good.lines().collect();
            lines[line - 1] = word;
            lines.join("\n")
        };
        let cut = good.lines().take(60).collect::<Vec<_>>().join("\n");
        for (text, expected) in [
            (String::new(), "lamp.ldt:1: the end of the file"),
            (change(3, "5"), "lamp.ldt:3: 5; expected a symmetry, 0 to 4"),
            (change(4, "1e9"), "the number of planes, 1 to 721"),
            (change(6, "x"), "lamp.ldt:6: \"x\""),
            (change(26, "0"), "lamp.ldt:26: 0; expected the number of sets of lamps"),
            (change(29, "-5"), "a flux and a conversion of at least 0"),
            (change(44, "0"), "planes C that rise"),
            (change(51, "-1"), "lamp.ldt:51: -2; expected an intensity of at least 0"),
            (cut, "the end of the file; expected an intensity"),
        ] {
            let message = read(&text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message} for {expected}");
        }
    }
}
