//! Polygon meshes in PLY, the Stanford triangle format: text, binary in either byte order, or any
//! of these compressed with gzip.
//!
//! Input: the bytes of a file. Output: positions from the element `vertex` (`x y z`), normals
//! (`nx ny nz`) and texture coordinates (`u v`, `s t`, `texture_u texture_v`,
//! `texture_s texture_t`) where present, unchanged; triangles from the lists `vertex_indices` or
//! `vertex_index` of the element `face`. Other elements and properties are skipped, as pbrt and
//! Mitsuba skip them; texture coordinates that belong to the corners of faces get a note.
//!
//! # Guarantee
//! Any bytes give a mesh whose indices are in range, or an error with line or row. Memory is
//! bounded by a multiple of the bytes of the file, regardless of the numbers of elements in the
//! header. Time is bounded by the bytes of the file and the limits of [`polygon`](super::polygon).
//!
//! | module | purpose |
//! |---|---|
//! | [`header`] | formats, elements, properties |
//! | [`numbers`] | the numbers after the header |
//! | [`rows`] | vertices and faces |
//!
//! Sources: Turk 1994. Held to this by the tests below.

mod header;
mod numbers;
mod rows;

use std::borrow::Cow;
use std::io::Read;

use super::LoadOptions;
use super::polygon::{Coverage, Triangulator};
use crate::error::{Error, Location, Result};
use crate::scene::{MeshData, NoteKind, Notes};
use header::{Format, Header};
use numbers::{Binary, Numbers, Text};
use rows::{Faces, Vertices};

/// Largest number of unpacked bytes for each compressed byte. Meshes need far less: the text of a
/// regular grid reaches 30.
const MAX_EXPANSION: u64 = 256;

/// Reads a mesh.
///
/// `at` is the file, for messages; repairs are added to `notes`. Normals and texture coordinates
/// are present for all vertices or none.
///
/// # Errors
/// [`Error::Invalid`] for a file that is not PLY, has no vertices, or contradicts itself. A cloud
/// of points without faces is an empty mesh, with a note.
pub(super) fn read(
    bytes: &[u8],
    options: &LoadOptions,
    notes: &mut Notes,
    at: &Location,
) -> Result<MeshData> {
    let bytes = unpacked(bytes, options, at)?;
    let header = Header::parse(&bytes, at)?;
    let body = &bytes[header.length..];
    let (vertices, faces) = match header.format {
        Format::Text => elements(&header, Text::new(body, header.lines), at)?,
        Format::LittleEndian => elements(&header, Binary::<false>::new(body), at)?,
        Format::BigEndian => elements(&header, Binary::<true>::new(body), at)?,
    };
    let Some(faces) = faces else {
        notes.push(NoteKind::Ignored, "meshes of points without faces: left out", at.clone());
        return Ok(MeshData::default());
    };
    if vertices.uvs.is_empty() && faces.has_uvs {
        let message = "texture coordinates of the corners of faces: left out, those of vertices are read";
        notes.push(NoteKind::Ignored, message, at.clone());
    }
    let triangles = triangles(&vertices, &faces, notes, at);
    let Vertices { positions, origin, normals, uvs } = vertices;
    Ok(MeshData { name: String::new(), positions, origin, normals, uvs, triangles })
}

/// The bytes without their compression, if there is one.
fn unpacked<'a>(bytes: &'a [u8], options: &LoadOptions, at: &Location) -> Result<Cow<'a, [u8]>> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(Cow::Borrowed(bytes));
    }
    let limit = options.max_file_bytes.min((bytes.len() as u64).saturating_mul(MAX_EXPANSION));
    let mut unpacked = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes)
        .take(limit.saturating_add(1))
        .read_to_end(&mut unpacked)
        .map_err(|e| {
            let is_truncated = e.kind() == std::io::ErrorKind::UnexpectedEof;
            let how = if is_truncated { "truncated" } else { "damaged" };
            Error::invalid(at.clone(), format!("{how} compression ({e})"), "a gzip file")
        })?;
    if unpacked.len() as u64 > limit {
        let found = format!("more than {limit} bytes when unpacked");
        return Err(Error::invalid(at.clone(), found, "a smaller file"));
    }
    Ok(Cow::Owned(unpacked))
}

/// Reads all elements in the order of the file. Without an element `face`, the second value is
/// none.
fn elements<N: Numbers>(header: &Header, mut numbers: N, at: &Location) -> Result<(Vertices, Option<Faces>)> {
    let missing = || {
        let found = "a header without element \"vertex\"";
        Error::invalid(at.clone(), found, "elements \"vertex\" and \"face\"")
    };
    let (mut vertices, mut faces) = (None, None);
    let points = header.elements.iter().find(|e| e.name == "vertex").ok_or_else(missing)?.rows;
    for element in &header.elements {
        rows::check_count(element, &numbers, at)?;
        match element.name.as_str() {
            "vertex" if vertices.is_none() => vertices = Some(Vertices::read(element, &mut numbers, at)?),
            "face" if faces.is_none() => {
                faces = Some(Faces::read(element, points.min(u64::from(u32::MAX)), &mut numbers, at)?)
            }
            // Elements after both the vertices and the faces are not used.
            _ if vertices.is_some() && faces.is_some() => break,
            _ => rows::skip(element, &mut numbers, at)?,
        }
    }
    Ok((vertices.ok_or_else(missing)?, faces))
}

/// Returns the triangles of the faces whose corners are existing vertices.
fn triangles(vertices: &Vertices, faces: &Faces, notes: &mut Notes, at: &Location) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(faces.sizes.len());
    let mut triangulator = Triangulator::new();
    let (mut points, mut local) = (Vec::new(), Vec::new());
    let (mut small, mut crossing, mut fans) = (0, 0, 0);
    let mut corners = faces.corners.as_slice();
    for &size in &faces.sizes {
        let (own, rest) = corners.split_at(size as usize);
        corners = rest;
        match *own {
            [] | [_] | [_, _] => small += 1,
            [a, b, c] => triangles.push([a, b, c]),
            _ => {
                points.clear();
                points.extend(own.iter().map(|&i| vertices.positions[i as usize]));
                local.clear();
                match triangulator.triangulate(&points, &mut local) {
                    Coverage::Whole => {}
                    Coverage::Crossing => crossing += 1,
                    Coverage::Fan => fans += 1,
                }
                triangles.extend(local.iter().map(|t| t.map(|i| own[i as usize])));
            }
        }
    }
    let (repaired, approximated) = (NoteKind::Repaired, NoteKind::Approximated);
    for (kind, message, count) in [
        (repaired, "faces with fewer than three corners: left out", small),
        (repaired, "polygons that cross themselves: parts may be missing", crossing),
        (approximated, "polygons too large to triangulate exactly: cut into a fan", fans),
    ] {
        notes.push_many(kind, message, at.clone(), count);
    }
    triangles
}

#[cfg(test)]
mod tests;
