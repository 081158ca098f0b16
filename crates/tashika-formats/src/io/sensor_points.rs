//! Lists of sensors.
//!
//! ```text
//! points of Radiance (.pts)      x y z nx ny nz          one sensor a line; # begins a comment
//! table (.csv)                   x,y,z[,nx,ny,nz][,name][,shape]
//! ```
//!
//! A table has the names of its columns in its first line, in any order; columns are separated by
//! commas, semicolons or tabs, and lines that begin with `#` are comments. Positions are in metres,
//! in the coordinates of the scene's file. Normals may have any length above zero; without columns
//! for them, they point along `+z`. The shape is `plane` (the default), `cylinder` or `sphere`. The
//! kind of file is recognised by its first line: a table begins with a name, points with a number.
//!
//! # Held to this by
//! The tests below.

use std::path::Path;

use glam::DVec3;

use super::text::{decoded, utf8_or_latin1};
use super::{LoadOptions, SceneFiles};
use crate::error::{Error, Location, Result};
use crate::scene::{SensorPoint, SensorShape};

/// Most sensors of a file.
const MAX_SENSORS: usize = 1 << 22;

/// Names that a header may have, for messages.
const COLUMNS: &str = "x, y, z, nx, ny, nz, name, shape";

/// Reads a list of sensors.
///
/// # Errors
/// [`Error::Io`]; [`Error::Invalid`] with the line of a value that is not a finite number, of a
/// normal of length zero, or of an unknown column.
pub fn load_sensor_points(path: &Path, options: &LoadOptions) -> Result<Vec<SensorPoint>> {
    decode_sensor_points(&SceneFiles::open(path, options)?.read_scene()?, path)
}

/// Reads a list of sensors from the bytes of a file; `path` names it in errors.
///
/// # Errors
/// As [`load_sensor_points`].
pub fn decode_sensor_points(bytes: &[u8], path: &Path) -> Result<Vec<SensorPoint>> {
    let bytes = decoded(bytes);
    let text = utf8_or_latin1(&bytes);
    let is_content = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let first = text.lines().find(is_content).ok_or_else(|| {
        Error::invalid(Location::file(path), "no sensor", "lines x y z nx ny nz, or a table with a header")
    })?;
    let is_table = first.trim_start().starts_with(|c: char| c.is_alphabetic() || c == '"');
    let points = if is_table { table(&text, first, path)? } else { lines(&text, path)? };
    if points.is_empty() {
        return Err(Error::invalid(Location::file(path), "no sensor", "a line for each sensor"));
    }
    Ok(points)
}

/// Reads lines of six numbers.
fn lines(text: &str, path: &Path) -> Result<Vec<SensorPoint>> {
    let mut points = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = line.split([' ', '\t', ',', ';']).filter(|word| !word.is_empty()).collect();
        if words.is_empty() {
            continue;
        }
        let at = Location::line(path, number);
        let [x, y, z, nx, ny, nz] = words[..] else {
            let found = format!("{} words", words.len());
            return Err(Error::invalid(at, found, "six numbers: x y z nx ny nz"));
        };
        let position = vector([x, y, z], ["x", "y", "z"], &at)?;
        let normal = vector([nx, ny, nz], ["nx", "ny", "nz"], &at)?;
        push(&mut points, SensorPoint::plane(position, normal), &at)?;
    }
    Ok(points)
}

/// Reads a table with a header.
fn table(text: &str, header: &str, path: &Path) -> Result<Vec<SensorPoint>> {
    let delimiter = [b';', b'\t', b','].into_iter().find(|d| header.contains(char::from(*d))).unwrap_or(b',');
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let invalid = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line) as u32;
        let found = match error.kind() {
            csv::ErrorKind::UnequalLengths { len, .. } => format!("{len} columns"),
            _ => error.to_string(),
        };
        Error::invalid(Location::line(path, line), found, "as many columns as the header has")
    };
    let names: Vec<String> = reader.headers().map_err(invalid)?.iter().map(str::to_lowercase).collect();
    let at = Location::line(path, reader.position().line().saturating_sub(1).max(1) as u32);
    let known: Vec<&str> = COLUMNS.split(", ").collect();
    for (k, name) in names.iter().enumerate() {
        if !known.contains(&name.as_str()) {
            return Err(Error::invalid(at, format!("column {name:?}"), format!("columns {COLUMNS}")));
        }
        if names[..k].contains(name) {
            return Err(Error::invalid(at, format!("column {name:?} twice"), "each column once"));
        }
    }
    let column = |name: &str| names.iter().position(|known| known == name);
    let three = |names: [&str; 3]| {
        let found = names.map(column);
        match found {
            [Some(a), Some(b), Some(c)] => Ok(Some([a, b, c])),
            [None, None, None] => Ok(None),
            _ => {
                Err(Error::invalid(at.clone(), "a part of a vector", format!("columns {}", names.join(", "))))
            }
        }
    };
    let Some(of_position) = three(["x", "y", "z"])? else {
        return Err(Error::invalid(at, "no position", "columns x, y, z"));
    };
    let (of_normal, of_name, of_shape) = (three(["nx", "ny", "nz"])?, column("name"), column("shape"));
    let mut points = Vec::new();
    for record in reader.records() {
        let record = record.map_err(invalid)?;
        let at = Location::line(path, record.position().map_or(1, csv::Position::line) as u32);
        let words = |columns: [usize; 3]| columns.map(|k| record.get(k).unwrap_or_default());
        let normal = match of_normal {
            Some(columns) => vector(words(columns), ["nx", "ny", "nz"], &at)?,
            None => DVec3::Z,
        };
        let point = SensorPoint {
            name: of_name.and_then(|k| record.get(k)).unwrap_or_default().to_owned(),
            position: vector(words(of_position), ["x", "y", "z"], &at)?,
            normal,
            shape: of_shape
                .and_then(|k| record.get(k))
                .map_or(Ok(SensorShape::Plane), |word| shape(word, &at))?,
        };
        push(&mut points, point, &at)?;
    }
    Ok(points)
}

fn shape(word: &str, at: &Location) -> Result<SensorShape> {
    match word {
        "" | "plane" => Ok(SensorShape::Plane),
        "cylinder" => Ok(SensorShape::Cylinder),
        "sphere" => Ok(SensorShape::Sphere),
        _ => Err(Error::invalid(at.clone(), format!("shape {word:?}"), "plane, cylinder or sphere")),
    }
}

fn vector(words: [&str; 3], names: [&str; 3], at: &Location) -> Result<DVec3> {
    let mut numbers = [0.0; 3];
    for ((word, name), number) in words.into_iter().zip(names).zip(&mut numbers) {
        let parsed = word.parse::<f64>().ok().filter(|number| number.is_finite());
        *number = parsed
            .ok_or_else(|| Error::invalid(at.clone(), format!("{name} = {word:?}"), "a finite number"))?;
    }
    Ok(numbers.into())
}

/// Adds a sensor whose normal has a direction.
fn push(points: &mut Vec<SensorPoint>, point: SensorPoint, at: &Location) -> Result<()> {
    if point.shape != SensorShape::Sphere && point.normal.try_normalize().is_none() {
        return Err(Error::invalid(at.clone(), "a normal of length zero", "a direction"));
    }
    if points.len() == MAX_SENSORS {
        return Err(Error::invalid(at.clone(), "one more sensor", format!("at most {MAX_SENSORS}")));
    }
    points.push(point);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<SensorPoint>> {
        decode_sensor_points(text.as_bytes(), Path::new("desk.pts"))
    }

    #[test]
    fn points_of_radiance_are_read() {
        let points = read("# desk\n0 0 0.8 0 0 1\n\n 1.5 -2 8e-1\t0 0 2 # taller\n").unwrap();
        assert_eq!(points.len(), 2);
        assert_eq!(points[1], SensorPoint::plane(DVec3::new(1.5, -2.0, 0.8), DVec3::new(0.0, 0.0, 2.0)));
        // Numbers of single precision would move a sensor of a scene in map coordinates.
        let far = read("691608.123456 5334710.5 520 0 0 1").unwrap();
        assert_eq!(far[0].position.x, 691_608.123_456);
    }

    #[test]
    fn tables_have_columns_in_any_order() {
        let points = read("# by hand\nname;Z;x;y;shape\nwest;0.8;1;2;\n\"e;st\";1.2;3;4;cylinder\n").unwrap();
        assert_eq!(points[0].name, "west");
        assert_eq!((points[0].position, points[0].normal), (DVec3::new(1.0, 2.0, 0.8), DVec3::Z));
        assert_eq!((points[1].name.as_str(), points[1].shape), ("e;st", SensorShape::Cylinder));
        let points = read("x,y,z,nx,ny,nz\n1,2,3,0,-1,0").unwrap();
        assert_eq!(points[0].normal, DVec3::NEG_Y);
    }

    /// Each message names the line, the fault and the accepted form.
    #[test]
    fn faults_are_reported_with_their_line() {
        let cases = [
            ("", "desk.pts: no sensor"),
            ("# only a comment\n", "no sensor"),
            ("0 0 0 0 0 1\n0 0 0 0 1\n", "desk.pts:2: 5 words; expected six numbers"),
            ("0 0 0 0 0 1\n0 0 NaN 0 0 1\n", "desk.pts:2: z = \"NaN\"; expected a finite number"),
            ("0 0 0 0 0 1\n0 x 0 0 0 1\n", "desk.pts:2: y = \"x\""),
            ("0 0 0 0 0 0\n", "desk.pts:1: a normal of length zero"),
            ("x,y,z,u\n1,2,3,4\n", "desk.pts:1: column \"u\"; expected columns x, y, z"),
            ("x,y,x\n1,2,3\n", "column \"x\" twice"),
            ("x,y,nx,ny,nz\n1,2,3,4,5\n", "a part of a vector; expected columns x, y, z"),
            ("name\ndesk\n", "no position"),
            ("x,y,z\n1,2,3\n1,2\n", "desk.pts:3: 2 columns"),
            ("x,y,z\n1,2,inf\n", "desk.pts:2: z = \"inf\""),
            ("x,y,z,shape\n1,2,3,cube\n", "desk.pts:2: shape \"cube\""),
        ];
        for (text, expected) in cases {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text:?}: {message} for {expected}");
        }
    }
}
