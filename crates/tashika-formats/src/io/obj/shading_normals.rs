//! Normals for corners that have none in the file.
//!
//! * A corner of a face with a smoothing group gets the mean of the normals of the group's faces at
//!   its vertex, weighted with their angles there. Corners that have a normal in the file are not
//!   included. The mean does not depend on how the surface is cut into faces:
//!
//! ```text
//!   n = Σ αᵢ nᵢ / ‖Σ αᵢ nᵢ‖
//! ```
//!
//!   (Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets", JGT 3(1), 1998,
//!   equation 1.)
//! * Any other corner is flat. If other faces of its material have normals, it gets the normal of
//!   its face, because a mesh has normals at all of its vertices or at none.
//!
//! Sums run in `f64`, in the order of the file. Tested by `suite::obj::smoothing_*`.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::parse::{Geometry, NONE};
use crate::error::{Error, Location, Result};
use crate::io::polygon::double_area;
use crate::math::elementary::atan2;

/// Computes normals for corners without one, where their smoothing group or their mesh needs one.
pub(super) fn complete(geometry: &mut Geometry, file: &Path) -> Result<()> {
    smooth(geometry, file)?;
    flatten(geometry, file)
}

fn smooth(geometry: &mut Geometry, file: &Path) -> Result<()> {
    let Geometry { positions, normals, corners, faces, .. } = geometry;
    let given = normals.len();
    let mut sums: Vec<DVec3> = Vec::new();
    let mut of_vertex: HashMap<(u32, u32), u32> = HashMap::new();
    let mut points: Vec<Vec3> = Vec::new();
    for face in faces.iter().filter(|face| face.smoothing != 0) {
        let corners = &mut corners[face.range()];
        if corners.iter().all(|c| c.normal != NONE) {
            continue;
        }
        points.clear();
        points.extend(corners.iter().map(|c| positions[c.position as usize]));
        let normal = unit_normal(&points);
        for (i, corner) in corners.iter_mut().enumerate().filter(|(_, c)| c.normal == NONE) {
            let next = *of_vertex.entry((corner.position, face.smoothing)).or_insert(sums.len() as u32);
            if next as usize == sums.len() {
                sums.push(DVec3::ZERO);
            }
            sums[next as usize] += normal * interior_angle(&points, i, normal);
            corner.normal = checked(given + next as usize, file)?;
        }
    }
    normals.extend(sums.into_iter().map(|sum| sum.normalize_or_zero().as_vec3()));
    Ok(())
}

fn flatten(geometry: &mut Geometry, file: &Path) -> Result<()> {
    let Geometry { positions, normals, corners, faces, materials, .. } = geometry;
    let mut has_normals = vec![false; materials.len()];
    for face in faces.iter() {
        has_normals[face.material as usize] |= corners[face.range()].iter().any(|c| c.normal != NONE);
    }
    let mut points: Vec<Vec3> = Vec::new();
    for face in faces.iter().filter(|face| has_normals[face.material as usize]) {
        let corners = &mut corners[face.range()];
        if corners.iter().all(|c| c.normal != NONE) {
            continue;
        }
        points.clear();
        points.extend(corners.iter().map(|c| positions[c.position as usize]));
        let normal = checked(normals.len(), file)?;
        normals.push(unit_normal(&points).as_vec3());
        for corner in corners.iter_mut().filter(|c| c.normal == NONE) {
            corner.normal = normal;
        }
    }
    Ok(())
}

/// Unit normal of a polygon; zero if it has no area or corners that are not finite.
fn unit_normal(points: &[Vec3]) -> DVec3 {
    double_area(points).normalize_or_zero()
}

/// Interior angle of a polygon at corner `i`, between 0 and 2π, given the polygon's unit normal;
/// zero if that normal is zero.
fn interior_angle(points: &[Vec3], i: usize, normal: DVec3) -> f64 {
    let at = |k: usize| points[k % points.len()].as_dvec3();
    let (next, before) = (at(i + 1) - at(i), at(i + points.len() - 1) - at(i));
    let sine = next.cross(before).dot(normal);
    let cosine = next.dot(before);
    if normal == DVec3::ZERO {
        return 0.0;
    }
    // Both are scaled to the range of `f32` together.
    let scale = sine.abs().max(cosine.abs());
    if scale == 0.0 {
        return 0.0;
    }
    let angle = f64::from(atan2((sine / scale) as f32, (cosine / scale) as f32));
    if angle < 0.0 { angle + TAU } else { angle }
}

/// Converts `index` to the stored type; fails if it is too large.
fn checked(index: usize, file: &Path) -> Result<u32> {
    u32::try_from(index).ok().filter(|&i| i != NONE).ok_or_else(|| {
        Error::unsupported(Location::file(file), "more than 4294967295 vertex normals", "split the file")
    })
}
