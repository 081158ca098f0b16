//! Meshes: triangles, PLY files, bilinear patches, subdivision surfaces, height fields.

use glam::{Vec2, Vec3};

use crate::error::{Error, Location, Result};
use crate::io::assets::{kind, reason};
use crate::io::notes::excerpt;
use crate::io::pbrt::loading::Loading;
use crate::io::pbrt::parameters::{Kind, Parameters};
use crate::io::{mesh_files, shapes};
use crate::math::LocalPlaces;
use crate::scene::{MeshData, NoteKind};

/// Most triangles made by subdivision; chosen.
const MAX_SUBDIVIDED: usize = 1 << 20;

/// Steps along each side of a patch that is not flat; chosen.
const PATCH_STEPS: u32 = 8;

/// Texture coordinates of the corners of triangles that have none.
const DEFAULT_UVS: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::ONE];

/// Flatness limit of a patch: volume that its corners span, relative to the cube of the largest
/// distance of a corner from the first.
const FLATNESS: f32 = 1e-4;

/// Returns the triangles of a shape, with pbrt's texture coordinates; none if it is ignored.
pub(super) fn mesh(loading: &mut Loading<'_>, class: &str, p: &Parameters) -> Result<Option<MeshData>> {
    match class {
        "trianglemesh" => triangle_mesh(loading, p),
        "plymesh" => ply_mesh(loading, p),
        "bilinearmesh" => bilinear_mesh(loading, p),
        "loopsubdiv" => loop_subdivision(loading, p),
        "heightfield" | "heightfield2" => height_field(p),
        _ => {
            p.accept_known();
            Ok(None)
        }
    }
}

/// Reads vertex indices and checks their range.
fn indices(p: &Parameters, vertices: usize, corners: usize) -> Result<Option<Vec<u32>>> {
    let Some(indices) = p.integers("indices") else { return Ok(None) };
    let at = || p.find(&[Kind::Integer], "indices").map_or_else(|| p.at(), |found| found.at());
    if indices.len() % corners != 0 {
        let found = format!("{} indices", indices.len());
        return Err(Error::invalid(at(), found, format!("a multiple of {corners}")));
    }
    let in_range = |&i: &i32| u32::try_from(i).ok().filter(|&i| (i as usize) < vertices);
    match indices.iter().map(in_range).collect() {
        Some(checked) => Ok(Some(checked)),
        None => {
            let wrong = indices.iter().find(|i| in_range(i).is_none()).copied().unwrap_or(0);
            let expected = format!("an index from 0 to below {vertices}, the number of points");
            Err(Error::invalid(at(), format!("vertex index {wrong}"), expected))
        }
    }
}

/// Returns the points; none, with a note, if there are no points.
fn points(loading: &mut Loading<'_>, p: &Parameters) -> Option<LocalPlaces> {
    let points = p.points("P");
    if points.is_empty() {
        loading.note(NoteKind::Repaired, "meshes without points \"P\": left out", p.at());
        return None;
    }
    Some(LocalPlaces::of(&points))
}

/// Returns one value for each vertex; none, with a note, if their number is wrong.
fn of_vertices<T>(
    loading: &mut Loading<'_>,
    values: Vec<T>,
    vertices: usize,
    what: &str,
    at: Location,
) -> Vec<T> {
    if values.is_empty() || values.len() == vertices {
        return values;
    }
    let message = format!("meshes with another number of {what} than of points: without {what}");
    loading.note(NoteKind::Repaired, message, at);
    Vec::new()
}

/// Reads texture coordinates under any of their names.
fn uvs(p: &Parameters) -> Vec<Vec2> {
    ["uv", "st", "UV"].iter().map(|name| p.pairs(name)).find(|uvs| !uvs.is_empty()).unwrap_or_default()
}

fn triangle_mesh(loading: &mut Loading<'_>, p: &Parameters) -> Result<Option<MeshData>> {
    let Some(LocalPlaces { origin, places: positions }) = points(loading, p) else { return Ok(None) };
    let triangles = match indices(p, positions.len(), 3)? {
        Some(indices) => indices.as_chunks().0.to_vec(),
        None if positions.len() == 3 => vec![[0, 1, 2]],
        None => {
            let found = format!("a mesh of {} points without \"indices\"", positions.len());
            return Err(Error::invalid(p.at(), found, "\"integer indices\", three a triangle"));
        }
    };
    let normals = p.vectors(&[Kind::Normal], "N");
    let normals = of_vertices(loading, normals, positions.len(), "normals", p.at());
    let uvs = of_vertices(loading, uvs(p), positions.len(), "texture coordinates", p.at());
    // Tangents and face numbers have no counterpart.
    p.accept(&["S", "faceIndices", "discarddegenerateUVs"]);
    let name = "trianglemesh".to_owned();
    Ok(Some(MeshData { name, positions, origin, normals, uvs, triangles }))
}

fn ply_mesh(loading: &mut Loading<'_>, p: &Parameters) -> Result<Option<MeshData>> {
    let at = p.at();
    let Some(name) = p.string("filename") else {
        return Err(Error::invalid(at, "a plymesh without filename", "\"string filename\""));
    };
    if p.texture("displacement").is_some() || p.string("displacement").is_some() {
        loading.note(NoteKind::Ignored, "displacement of meshes: left out", at.clone());
    }
    p.accept(&["displacement.edgelength", "edgelength"]);
    let (files, options) = (loading.files, loading.files.options());
    let bytes = match files.read(name, &at) {
        Ok(bytes) => bytes,
        Err(error) => {
            let shown = excerpt(name, 60);
            let message = format!("mesh file {shown:?} could not be read ({}): left out", reason(&error));
            let at = p.place_of("filename");
            loading.note_named(kind(&error), message, "mesh files could not be read", at);
            return Ok(None);
        }
    };
    let mut data = mesh_files::read_ply(&bytes, options, loading.builder.notes_mut(), &at)?;
    if data.name.is_empty() {
        data.name = name.to_owned();
    }
    Ok(Some(data))
}

fn bilinear_mesh(loading: &mut Loading<'_>, p: &Parameters) -> Result<Option<MeshData>> {
    let Some(LocalPlaces { origin, places: positions }) = points(loading, p) else { return Ok(None) };
    let indices = match indices(p, positions.len(), 4)? {
        Some(indices) => indices,
        None if positions.len() == 4 => vec![0, 1, 2, 3],
        None => {
            let found = format!("a mesh of {} points without \"indices\"", positions.len());
            return Err(Error::invalid(p.at(), found, "\"integer indices\", four a patch"));
        }
    };
    p.accept(&["N", "faceIndices", "emissionfilename"]);
    let given = uvs(p);
    let mut data = MeshData { name: "bilinearmesh".to_owned(), origin, ..MeshData::default() };
    for patch in indices.as_chunks::<4>().0 {
        let corners = patch.map(|i| positions[i as usize]);
        let corner_uvs = if given.len() == positions.len() {
            patch.map(|i| given[i as usize])
        } else {
            [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE]
        };
        let steps = if is_flat(&corners) { 1 } else { PATCH_STEPS };
        let Ok(piece) = shapes::bilinear_patch(corners, corner_uvs, steps, &p.at()) else { continue };
        let Ok(base) = u32::try_from(data.positions.len()) else { break };
        data.triangles.extend(piece.triangles.iter().map(|t| t.map(|i| i + base)));
        data.positions.extend(piece.positions);
        data.normals.extend(piece.normals);
        data.uvs.extend(piece.uvs);
    }
    Ok(Some(data))
}

fn is_flat([a, b, c, d]: &[Vec3; 4]) -> bool {
    let (u, v, w) = (*b - *a, *c - *a, *d - *a);
    let volume = u.cross(v).dot(w).abs();
    let longest = u.length().max(v.length()).max(w.length());
    volume <= FLATNESS * longest * longest * longest
}

fn loop_subdivision(loading: &mut Loading<'_>, p: &Parameters) -> Result<Option<MeshData>> {
    let Some(LocalPlaces { origin, places: positions }) = points(loading, p) else { return Ok(None) };
    let Some(indices) = indices(p, positions.len(), 3)? else {
        return Err(Error::invalid(
            p.at(),
            "a loopsubdiv without \"indices\"",
            "\"integer indices\", three a triangle",
        ));
    };
    let triangles = indices.as_chunks().0;
    let asked = p.integer("levels").or(p.integer("nlevels")).unwrap_or(3).max(0);
    p.accept(&["scheme"]);
    let mut levels = 0;
    let mut count = triangles.len();
    while levels < asked && count <= MAX_SUBDIVIDED / 4 {
        count *= 4;
        levels += 1;
    }
    if levels < asked {
        let message = format!("subdivision into more than {MAX_SUBDIVIDED} triangles: fewer levels");
        loading.note(NoteKind::Approximated, message, p.at());
    }
    let data = shapes::loop_subdivision(&positions, triangles, levels as u32, &p.at())?;
    Ok(Some(MeshData { origin, ..data }))
}

fn height_field(p: &Parameters) -> Result<Option<MeshData>> {
    let size = [p.integer("nu"), p.integer("nv")].map(|n| n.and_then(|n| u32::try_from(n).ok()).unwrap_or(0));
    let heights = p.floats("Pz").or(p.floats("z")).unwrap_or_default();
    let wanted = u64::from(size[0]) * u64::from(size[1]);
    if size[0] < 2 || size[1] < 2 || wanted != heights.len() as u64 {
        let found = format!("a heightfield of {}×{} with {} heights", size[0], size[1], heights.len());
        return Err(Error::invalid(p.at(), found, "nu, nv of at least 2 and nu · nv values \"Pz\""));
    }
    shapes::heightfield(size, heights, &p.at()).map(Some)
}

/// Gives a mesh pbrt's default texture coordinates for triangles. Corners are no longer shared:
/// each becomes a separate vertex.
pub(super) fn with_default_uvs(data: MeshData) -> MeshData {
    let corners = data.triangles.iter().flatten().map(|&i| i as usize);
    let positions: Vec<Vec3> = corners.clone().map(|i| data.positions[i]).collect();
    let normals =
        if data.normals.is_empty() { Vec::new() } else { corners.map(|i| data.normals[i]).collect() };
    let uvs = DEFAULT_UVS.iter().copied().cycle().take(positions.len()).collect();
    let corner_count = u32::try_from(positions.len()).unwrap_or(u32::MAX);
    let triangles = (0..corner_count / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    MeshData { name: data.name, positions, origin: data.origin, normals, uvs, triangles }
}
