//! Polygons with several holes.
//!
//! The format has no holes: a polygon runs along a seam to a hole, around it, and back along the
//! seam. If seams share a corner, such a polygon cannot be clipped as one ring. It is then taken
//! apart into rings at the corners that it comes back to. A ring in the direction of the whole is
//! an outline; the others are holes.
//!
//! Held to this by the tests in `tests`.

use std::collections::BTreeMap;

use earcut::Earcut;
use glam::DVec3;

/// Most corners of a polygon that is taken apart; chosen: clipping is quadratic at worst.
const MAX_CORNERS: usize = 1024;

/// Largest relative difference between the areas of the triangles and of the polygon.
const AREA_TOLERANCE: f64 = 1e-6;

/// Triangles of a polygon with one outline and holes, as indices of its corners; none if it is
/// something else.
pub(super) fn triangulate(corners: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    if corners.len() > MAX_CORNERS {
        return None;
    }
    let rings = rings(corners);
    let normals: Vec<DVec3> = rings.iter().map(|ring| double_area(corners, ring)).collect();
    let whole: DVec3 = normals.iter().sum();
    let (outlines, holes): (Vec<usize>, Vec<usize>) =
        (0..rings.len()).partition(|k| normals[*k].dot(whole) > 0.0);
    let [outline] = outlines[..] else { return None };
    let mut indices = rings[outline].clone();
    let mut starts = Vec::new();
    for hole in holes {
        starts.push(indices.len() as u32);
        indices.extend(&rings[hole]);
    }
    let size = whole.abs();
    let [u, v] = if size.x >= size.y && size.x >= size.z {
        [1, 2]
    } else if size.y >= size.z {
        [2, 0]
    } else {
        [0, 1]
    };
    let flat = indices.iter().map(|i| {
        let p = corners[*i as usize] - corners[0];
        [p[u], p[v]]
    });
    let mut clipped: Vec<u32> = Vec::new();
    Earcut::new().earcut(flat, &starts, &mut clipped);
    let (mut triangles, mut covered) = (Vec::new(), 0.0);
    for t in clipped.chunks_exact(3) {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| indices[i as usize]);
        let along = double_area(corners, &[a, b, c]).dot(whole) / whole.length();
        covered += along.abs();
        if along != 0.0 {
            triangles.push(if along > 0.0 { [a, b, c] } else { [a, c, b] });
        }
    }
    ((covered / whole.length() - 1.0).abs() < AREA_TOLERANCE).then_some(triangles)
}

/// Twice the vector area of a ring (m²).
fn double_area(corners: &[DVec3], ring: &[u32]) -> DVec3 {
    let at = |i: u32| corners[i as usize] - corners[ring[0] as usize];
    ring.windows(2).map(|e| at(e[0]).cross(at(e[1]))).sum()
}

/// Rings of at least three corners, between the visits of one place.
fn rings(corners: &[DVec3]) -> Vec<Vec<u32>> {
    // Zero is added because it has two signs.
    let key = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
    let mut open: Vec<u32> = Vec::new();
    let mut places: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    let mut rings = Vec::new();
    for (i, corner) in corners.iter().enumerate() {
        if let Some(place) = places.get(&key(*corner)).copied() {
            let ring = open.split_off(place);
            for corner in &ring {
                places.remove(&key(corners[*corner as usize]));
            }
            if ring.len() > 2 {
                rings.push(ring);
            }
        }
        places.insert(key(*corner), open.len());
        open.push(i as u32);
    }
    if open.len() > 2 {
        rings.push(open);
    }
    rings
}
