//! The rows of a PLY file as vertices and faces.

use glam::{DVec3, Vec2, Vec3};

use super::header::{Element, Scalar};
use super::numbers::{Numbers, Wrong};
use crate::error::{Error, Location, Result};
use crate::math::LocalPlaces;

/// Names of the properties of a vertex, by meaning. The last two properties have several names.
const VERTEX_PROPERTIES: [&[&str]; 8] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx"],
    &["ny"],
    &["nz"],
    &["u", "s", "texture_u", "texture_s"],
    &["v", "t", "texture_v", "texture_t"],
];

/// Refuses more rows than the file has bytes for, before memory is allocated for them.
pub(super) fn check_count(element: &Element, numbers: &impl Numbers, at: &Location) -> Result<()> {
    let Some(smallest) =
        element.properties.iter().map(|p| p.count.unwrap_or(p.value)).min_by_key(|s| s.size())
    else {
        return Ok(());
    };
    let values = element.rows.saturating_mul(element.properties.len() as u64);
    let most = numbers.capacity(smallest);
    if values > most {
        let found = format!("a truncated file: {} rows of element {:?}", element.rows, element.name);
        let expected =
            format!("at most {} in the bytes that are there", most / element.properties.len() as u64);
        return Err(Error::invalid(at.clone(), found, expected));
    }
    Ok(())
}

/// Skips the rows of an element.
pub(super) fn skip(element: &Element, numbers: &mut impl Numbers, at: &Location) -> Result<()> {
    if !element.properties.is_empty() {
        for row in 0..element.rows {
            for property in &element.properties {
                let skipped = match property.count {
                    None => numbers.skip(property.value, 1),
                    Some(count) => {
                        list_length(numbers, count).and_then(|length| numbers.skip(property.value, length))
                    }
                };
                skipped.map_err(|wrong| wrong.error(numbers.place(at), &element.name, row))?;
            }
        }
    }
    Ok(())
}

fn list_length(numbers: &mut impl Numbers, scalar: Scalar) -> Result<u64, Wrong> {
    let length = numbers.next(scalar)?;
    let valid = length >= 0.0 && length.fract() == 0.0 && length <= f64::from(u32::MAX);
    if valid { Ok(length as u64) } else { Err(Wrong::Word(format!("a list of length {length}"))) }
}

/// The element `vertex`.
pub(super) struct Vertices {
    /// Positions of the vertices relative to `origin`.
    pub positions: Vec<Vec3>,
    pub origin: DVec3,
    /// One for each vertex; empty if the file has none.
    pub normals: Vec<Vec3>,
    /// One for each vertex; empty if the file has none.
    pub uvs: Vec<Vec2>,
}

impl Vertices {
    /// Reads the element; its number of rows must have been checked.
    pub(super) fn read(element: &Element, numbers: &mut impl Numbers, at: &Location) -> Result<Self> {
        let mut taken = [false; VERTEX_PROPERTIES.len()];
        let uses: Vec<Option<usize>> = element
            .properties
            .iter()
            .map(|property| {
                let names = |names: &&[&str]| names.contains(&property.name.as_str());
                let place = VERTEX_PROPERTIES.iter().position(names)?;
                let free = property.count.is_none() && !std::mem::replace(&mut taken[place], true);
                free.then_some(place)
            })
            .collect();
        if !taken[..3].iter().all(|t| *t) {
            let found = "vertices without coordinates x, y and z";
            return Err(Error::invalid(at.clone(), found, "properties x, y and z"));
        }
        let has_normals = taken[3..6].iter().all(|t| *t);
        let has_uvs = taken[6..].iter().all(|t| *t);
        let rows = element.rows as usize;
        let mut vertices = Self {
            positions: Vec::new(),
            origin: DVec3::ZERO,
            normals: Vec::with_capacity(if has_normals { rows } else { 0 }),
            uvs: Vec::with_capacity(if has_uvs { rows } else { 0 }),
        };
        let mut places = Vec::with_capacity(rows);
        for row in 0..element.rows {
            let mut values = [0.0_f64; VERTEX_PROPERTIES.len()];
            for (property, place) in element.properties.iter().zip(&uses) {
                let read = match (property.count, place) {
                    (None, Some(place)) => numbers.next(property.value).map(|v| values[*place] = v),
                    (None, None) => numbers.skip(property.value, 1),
                    (Some(count), _) => {
                        list_length(numbers, count).and_then(|length| numbers.skip(property.value, length))
                    }
                };
                read.map_err(|wrong| wrong.error(numbers.place(at), &element.name, row))?;
            }
            let [nx, ny, nz, u, v] = [3, 4, 5, 6, 7].map(|k| values[k] as f32);
            places.push(DVec3::new(values[0], values[1], values[2]));
            if has_normals {
                vertices.normals.push(Vec3::new(nx, ny, nz));
            }
            if has_uvs {
                vertices.uvs.push(Vec2::new(u, v));
            }
        }
        LocalPlaces { origin: vertices.origin, places: vertices.positions } = LocalPlaces::of(&places);
        Ok(vertices)
    }
}

/// The element `face`: polygons of any number of corners.
pub(super) struct Faces {
    /// Vertices of all polygons, one after the other; each is below the number of vertices.
    pub corners: Vec<u32>,
    /// Number of corners of each polygon.
    pub sizes: Vec<u32>,
    /// True if corners have texture coordinates, which are skipped.
    pub has_uvs: bool,
}

impl Faces {
    /// Reads the element. Its indices must be below `vertices`; its number of rows must have been
    /// checked.
    pub(super) fn read(
        element: &Element,
        vertices: u64,
        numbers: &mut impl Numbers,
        at: &Location,
    ) -> Result<Self> {
        let is_corners = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
        let list = element.properties.iter().position(|p| p.count.is_some() && is_corners(&p.name));
        let Some(list) = list else {
            let found = "faces without a list of vertices";
            return Err(Error::invalid(at.clone(), found, "a list property vertex_indices"));
        };
        let has_uvs = element.properties.iter().any(|p| p.count.is_some() && p.name == "texcoord");
        let rows = element.rows as usize;
        let mut faces = Self { corners: Vec::with_capacity(rows), sizes: Vec::with_capacity(rows), has_uvs };
        for row in 0..element.rows {
            for (i, property) in element.properties.iter().enumerate() {
                let read = match property.count {
                    None => numbers.skip(property.value, 1),
                    Some(count) => list_length(numbers, count).and_then(|length| {
                        if i == list {
                            faces.add(numbers, property.value, length, vertices)
                        } else {
                            numbers.skip(property.value, length)
                        }
                    }),
                };
                read.map_err(|wrong| wrong.error(numbers.place(at), &element.name, row))?;
            }
        }
        Ok(faces)
    }

    fn add(
        &mut self,
        numbers: &mut impl Numbers,
        scalar: Scalar,
        length: u64,
        vertices: u64,
    ) -> Result<(), Wrong> {
        for _ in 0..length {
            let index = numbers.next(scalar)?;
            if !(index >= 0.0 && index.fract() == 0.0 && index < vertices as f64) {
                return Err(Wrong::Index(index, vertices));
            }
            self.corners.push(index as u32);
        }
        // Not above `u32::MAX`, see `list_length`.
        self.sizes.push(length as u32);
        Ok(())
    }
}
