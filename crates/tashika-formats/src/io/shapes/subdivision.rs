//! Loop's subdivision surfaces.
//!
//! Each level splits triangles into four. With `n` neighbours `pᵢ` of a vertex `p`,
//!
//! ```text
//! new vertex on the edge a b, between c and d:   3/8 (a + b) + 1/8 (c + d)
//! inside:       p ↦ (1 − n β) p + β Σ pᵢ         β = 3/16 for n = 3, 3 / (8 n) otherwise
//! boundary:     p ↦ 3/4 p + 1/8 (p₁ + p₂),       new vertex (a + b) / 2
//! ```
//!
//! After the last level, vertices move to their limit under infinitely many further levels:
//!
//! ```text
//! inside:       (1 − n γ) p + γ Σ pᵢ             γ = 1 / (n + 3 / (8 β))
//! boundary:     2/3 p + 1/6 (p₁ + p₂)
//! ```
//!
//! The normals are those of the limit surface: the cross product of the tangents `Σ cos(2πi/n) pᵢ`
//! and `Σ sin(2πi/n) pᵢ`, or of the boundary's tangents at a boundary.
//!
//! # Guarantee
//! Any triangles whose indices are in range give a surface. An edge of one triangle, or of more
//! than two, is a boundary. A vertex on one boundary edge, or on more than two, stays where it is.
//! If the triangles around a vertex form no fan, its normal is the mean of their normals.
//!
//! Sources: Loop 1987; Warren 2002 for `β`; Biermann 2000 for tangents on boundaries. Held to this
//! by the tests below.

use glam::{DVec3, Vec3};

use super::require;
use crate::error::{Error, Location, Result};
use crate::math::elementary::sin_cos;
use crate::scene::MeshData;

/// Most triangles that a surface may have after the last level; chosen.
const MAX_TRIANGLES: u64 = 1 << 23;

/// Subdivides a mesh `levels` times and moves its vertices to the limit surface. The result has no
/// texture coordinates.
pub(in crate::io) fn loop_subdivision(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    levels: u32,
    at: &Location,
) -> Result<MeshData> {
    let count = 4_u64.checked_pow(levels).and_then(|parts| parts.checked_mul(triangles.len() as u64));
    let few =
        levels <= 16 && count.is_some_and(|n| n <= MAX_TRIANGLES) && positions.len() as u64 <= MAX_TRIANGLES;
    let expected = format!("few enough for {MAX_TRIANGLES} triangles");
    require(few, "subdivision levels", format!("{levels} of {} triangles", triangles.len()), &expected, at)?;
    if let Some(wrong) = triangles.iter().flatten().find(|i| **i as usize >= positions.len()) {
        let expected = format!("one of {} vertices, from 0", positions.len());
        return Err(Error::invalid(at.clone(), format!("vertex {wrong}"), expected));
    }
    let mut positions: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3()).collect();
    let mut triangles = triangles.to_vec();
    for _ in 0..levels {
        (positions, triangles) = split(&positions, &triangles);
    }
    let around = Neighbourhoods::new(&positions, &Edges::new(&triangles));
    let limits = (0..positions.len()).map(|i| around.limit(i, positions[i]).as_vec3()).collect();
    let normals = normals(&positions, &triangles);
    Ok(MeshData { positions: limits, normals, triangles, ..MeshData::default() })
}

/// An edge, with the vertices opposite to it in its triangles.
struct Edge {
    ends: [u32; 2],
    /// Opposite vertices in the first two triangles; equal if the edge has only one triangle.
    opposite: [u32; 2],
    triangles: u32,
}

impl Edge {
    fn is_boundary(&self) -> bool {
        self.triangles != 2
    }
}

struct Edges {
    edges: Vec<Edge>,
    /// Edges of each triangle; entry `i` is the edge from corner `i` to the next.
    of_corner: Vec<[u32; 3]>,
}

impl Edges {
    fn new(triangles: &[[u32; 3]]) -> Self {
        let mut sides: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * triangles.len());
        for (index, t) in triangles.iter().enumerate() {
            for corner in 0..3 {
                let (a, b) = (t[corner], t[(corner + 1) % 3]);
                // There are no more triangles than `MAX_TRIANGLES`, so indices fit.
                sides.push(([a.min(b), a.max(b)], index as u32, corner as u8));
            }
        }
        sides.sort_unstable();
        let mut edges: Vec<Edge> = Vec::with_capacity(sides.len() / 2 + 1);
        let mut of_corner = vec![[0; 3]; triangles.len()];
        for (ends, triangle, corner) in sides {
            let across = triangles[triangle as usize][(usize::from(corner) + 2) % 3];
            match edges.last_mut() {
                Some(edge) if edge.ends == ends => {
                    if edge.triangles == 1 {
                        edge.opposite[1] = across;
                    }
                    edge.triangles += 1;
                }
                _ => edges.push(Edge { ends, opposite: [across; 2], triangles: 1 }),
            }
            of_corner[triangle as usize][usize::from(corner)] = edges.len() as u32 - 1;
        }
        Self { edges, of_corner }
    }
}

/// Sums over the neighbours of each vertex.
#[derive(Clone, Copy, Default)]
struct Neighbours {
    count: u32,
    sum: DVec3,
    boundary_count: u32,
    boundary_sum: DVec3,
}

struct Neighbourhoods(Vec<Neighbours>);

impl Neighbourhoods {
    fn new(positions: &[DVec3], edges: &Edges) -> Self {
        let mut all = vec![Neighbours::default(); positions.len()];
        for edge in &edges.edges {
            let [a, b] = edge.ends;
            for (own, other) in [(a, b), (b, a)] {
                let (around, other) = (&mut all[own as usize], positions[other as usize]);
                around.count += 1;
                around.sum += other;
                if edge.is_boundary() {
                    around.boundary_count += 1;
                    around.boundary_sum += other;
                }
            }
        }
        Self(all)
    }

    /// Position of the vertex after one level.
    fn smoothed(&self, i: usize, p: DVec3) -> DVec3 {
        self.weighted(i, p, beta, 1.0 / 8.0)
    }

    /// Position of the vertex after all further levels.
    fn limit(&self, i: usize, p: DVec3) -> DVec3 {
        self.weighted(i, p, |n| 1.0 / (n + 3.0 / (8.0 * beta(n))), 1.0 / 6.0)
    }

    fn weighted(&self, i: usize, p: DVec3, inside: impl Fn(f64) -> f64, boundary: f64) -> DVec3 {
        let around = &self.0[i];
        let n = f64::from(around.count);
        match around.boundary_count {
            0 if around.count > 0 => p * (1.0 - n * inside(n)) + around.sum * inside(n),
            2 => p * (1.0 - 2.0 * boundary) + around.boundary_sum * boundary,
            _ => p,
        }
    }
}

fn beta(n: f64) -> f64 {
    if n == 3.0 { 3.0 / 16.0 } else { 3.0 / (8.0 * n) }
}

/// Subdivides a mesh by one level.
fn split(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let edges = Edges::new(triangles);
    let around = Neighbourhoods::new(positions, &edges);
    let mut new: Vec<DVec3> = positions.iter().enumerate().map(|(i, p)| around.smoothed(i, *p)).collect();
    new.extend(edges.edges.iter().map(|edge| {
        let sum = |of: [u32; 2]| positions[of[0] as usize] + positions[of[1] as usize];
        if edge.is_boundary() {
            sum(edge.ends) * 0.5
        } else {
            sum(edge.ends) * 0.375 + sum(edge.opposite) * 0.125
        }
    }));
    let first = positions.len() as u32;
    let mut split = Vec::with_capacity(4 * triangles.len());
    for (&[a, b, c], sides) in triangles.iter().zip(&edges.of_corner) {
        let [ab, bc, ca] = sides.map(|edge| first + edge);
        split.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    (new, split)
}

/// Unit normals of the limit surface.
fn normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    // For each vertex, the sides of its triangles that are opposite to it; one list for all
    // vertices.
    let mut starts = vec![0_u32; positions.len() + 1];
    for i in triangles.iter().flatten() {
        starts[*i as usize + 1] += 1;
    }
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut free = starts.clone();
    let mut sides = vec![[0_u32; 2]; 3 * triangles.len()];
    for t in triangles {
        for corner in 0..3 {
            let place = &mut free[t[corner] as usize];
            sides[*place as usize] = [t[(corner + 1) % 3], t[(corner + 2) % 3]];
            *place += 1;
        }
    }
    let mut ring = Vec::new();
    let normal = |i: usize| {
        let sides = &mut sides[starts[i] as usize..starts[i + 1] as usize];
        let p = positions[i];
        // Positions are relative to the vertex. Otherwise rounding errors of sines would be
        // multiplied by its coordinates.
        let at = |vertex: u32| positions[vertex as usize] - p;
        let mean: DVec3 = sides.iter().map(|s| at(s[0]).cross(at(s[1]))).sum();
        let exact = match order(sides, &mut ring) {
            Ring::Closed => inside_normal(ring.iter().map(|v| at(*v))),
            Ring::Open => boundary_normal(&ring, at),
            Ring::Broken => mean,
        };
        // Where the surface is folded, the cross product of the tangents may point inward or
        // vanish.
        let exact = if exact.dot(mean) < 0.0 { -exact } else { exact };
        let unit = exact.normalize_or_zero();
        (if unit == DVec3::ZERO { mean.normalize_or(DVec3::Z) } else { unit }).as_vec3()
    };
    (0..positions.len()).map(normal).collect()
}

/// Arrangement of the neighbours of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ring {
    Closed,
    Open,
    Broken,
}

/// Fills `ring` with the neighbours of a vertex in their order around it. `sides` are the sides of
/// its triangles that are opposite to it.
fn order(sides: &mut [[u32; 2]], ring: &mut Vec<u32>) -> Ring {
    ring.clear();
    sides.sort_unstable();
    if sides.is_empty() || sides.windows(2).any(|s| s[0][0] == s[1][0]) {
        return Ring::Broken;
    }
    let mut ends: Vec<u32> = sides.iter().map(|s| s[1]).collect();
    ends.sort_unstable();
    let mut loose = sides.iter().map(|s| s[0]).filter(|start| ends.binary_search(start).is_err());
    let first = loose.next();
    let open = first.is_some();
    let first = first.unwrap_or(sides[0][0]);
    let mut vertex = first;
    loop {
        ring.push(vertex);
        let Ok(side) = sides.binary_search_by_key(&vertex, |s| s[0]) else { break };
        vertex = sides[side][1];
        if vertex == first || ring.len() > sides.len() {
            break;
        }
    }
    match ring.len().checked_sub(sides.len()) {
        Some(0) if !open => Ring::Closed,
        Some(1) if open => Ring::Open,
        _ => Ring::Broken,
    }
}

/// Normal of a vertex inside the surface, of any length; `ring` gives its neighbours relative to
/// it.
fn inside_normal(ring: impl ExactSizeIterator<Item = DVec3>) -> DVec3 {
    let step = std::f32::consts::TAU / ring.len() as f32;
    let (mut s, mut t) = (DVec3::ZERO, DVec3::ZERO);
    for (i, p) in ring.enumerate() {
        let (sin, cos) = sin_cos(i as f32 * step);
        s += p * f64::from(cos);
        t += p * f64::from(sin);
    }
    s.cross(t)
}

/// Normal of a vertex on a boundary, of any length; `at` gives neighbours relative to the vertex.
fn boundary_normal(ring: &[u32], at: impl Fn(u32) -> DVec3) -> DVec3 {
    let last = ring.len() - 1;
    let ends = at(ring[0]) + at(ring[last]);
    let along = at(ring[last]) - at(ring[0]);
    let across = match ring {
        [_, _] => ends,
        [_, middle, _] => at(*middle),
        [_, inner @ .., _] => {
            let step = std::f32::consts::PI / last as f32;
            let (sin, cos) = sin_cos(step);
            let inner = inner
                .iter()
                .enumerate()
                .map(|(i, v)| at(*v) * f64::from((2.0 * cos - 2.0) * sin_cos((i + 1) as f32 * step).0));
            ends * f64::from(sin) + inner.sum::<DVec3>()
        }
        _ => DVec3::ZERO,
    };
    along.cross(across)
}

#[cfg(test)]
mod tests {
    use super::super::tests::checked_area;
    use super::*;

    fn at() -> Location {
        Location::line("a.pbrt", 7)
    }

    fn octahedron() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let positions = vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        let triangles =
            vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        (positions, triangles)
    }

    /// A sheet of `n · n` cells in the plane `z = 0`.
    fn sheet(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mesh =
            super::super::heightfield([n + 1; 2], &vec![0.0; ((n + 1) * (n + 1)) as usize], &at()).unwrap();
        (mesh.positions, mesh.triangles)
    }

    #[test]
    fn limits_do_not_depend_on_the_level_at_which_they_are_taken() {
        let (positions, triangles) = octahedron();
        let meshes: Vec<MeshData> =
            (0..5).map(|levels| loop_subdivision(&positions, &triangles, levels, &at()).unwrap()).collect();
        for (level, mesh) in meshes.iter().enumerate() {
            assert_eq!(mesh.triangles.len(), 8 << (2 * level));
            checked_area(mesh);
            for (i, axis) in positions.iter().enumerate() {
                assert!((mesh.positions[i] - meshes[0].positions[i]).length() < 1e-6, "{level} {i}");
                assert!((mesh.normals[i] - axis).length() < 1e-6, "by symmetry");
            }
        }
        // n = 4: β = 3/32, γ = 1/8; the sum of a vertex's neighbours is 0.
        assert!((meshes[0].positions[0] - Vec3::X * 0.5).length() < 1e-6);
        let areas: Vec<f64> = meshes.iter().map(checked_area).collect();
        assert!((areas[4] - areas[3]).abs() < 0.3 * (areas[3] - areas[2]).abs(), "{areas:?}");
    }

    #[test]
    fn normals_are_those_of_the_limit_surface() {
        // The triangles around a vertex of the finest level approach its tangent plane.
        let (positions, triangles) = octahedron();
        let coarse = loop_subdivision(&positions, &triangles, 1, &at()).unwrap();
        let fine = loop_subdivision(&positions, &triangles, 6, &at()).unwrap();
        for i in 0..coarse.positions.len() {
            let around = fine.triangles.iter().filter(|t| t.contains(&(i as u32)));
            let mean: Vec3 = around
                .map(|t| {
                    let [a, b, c] = t.map(|i| fine.positions[i as usize]);
                    (b - a).cross(c - a)
                })
                .sum();
            assert!(coarse.normals[i].dot(mean.normalize()) > 0.9998, "{i}");
        }
    }

    #[test]
    fn flat_sheets_stay_flat_and_keep_their_corners_off_the_limit_curve() {
        let (positions, triangles) = sheet(3);
        for levels in [0, 3] {
            let mesh = loop_subdivision(&positions, &triangles, levels, &at()).unwrap();
            assert!(mesh.positions.iter().all(|p| p.z == 0.0));
            assert!(mesh.normals.iter().all(|n| (*n - Vec3::Z).length() < 1e-6));
            // Midpoint of a side, whose neighbours lie on a straight and evenly divided boundary.
            assert!((mesh.positions[1] - Vec3::new(1.0 / 3.0, 0.0, 0.0)).length() < 1e-6);
            // The corner: 2/3 p + 1/6 (p₁ + p₂).
            assert!((mesh.positions[0] - Vec3::new(1.0, 1.0, 0.0) / 18.0).length() < 1e-6);
        }
    }

    #[test]
    fn boundary_normals_follow_a_bent_boundary() {
        // A sheet is bent into a parabolic channel z = x². Subdivision preserves its slope along x.
        let (mut positions, triangles) = sheet(8);
        positions.iter_mut().for_each(|p| p.z = p.x * p.x);
        let mesh = loop_subdivision(&positions, &triangles, 2, &at()).unwrap();
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            // Vertices away from the sides, where the channel ends and the surface straightens.
            if (0.2..0.8).contains(&p.x) {
                let expected = Vec3::new(-2.0 * p.x, 0.0, 1.0).normalize();
                assert!((*n - expected).length() < 0.02, "{p}: {n} {expected}");
            }
        }
    }

    #[test]
    fn meshes_that_are_no_surface_are_survived() {
        let p = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE, Vec3::NAN, Vec3::X];
        for triangles in [
            &[][..],
            &[[0, 0, 0]],
            &[[0, 1, 1], [1, 1, 0]],
            &[[0, 1, 2], [0, 1, 3], [0, 1, 4], [1, 0, 4]],
            &[[0, 1, 2], [0, 2, 1]],
            &[[0, 1, 2], [0, 1, 2]],
            &[[0, 1, 2], [0, 3, 4]],
            &[[0, 1, 5], [1, 2, 5]],
        ] {
            let mesh = loop_subdivision(&p, triangles, 2, &at()).unwrap();
            assert_eq!(mesh.triangles.len(), 16 * triangles.len());
            assert!(mesh.triangles.iter().flatten().all(|i| (*i as usize) < mesh.positions.len()));
        }
        for (triangles, levels, expected) in [
            ([[0, 1, 2]], 30, "subdivision levels 30 of 1 triangles"),
            ([[0, 1, 2]], u32::MAX, "subdivision levels 4294967295"),
            ([[0, 1, 7]], 1, "vertex 7; expected one of 7 vertices"),
        ] {
            let error = loop_subdivision(&p, &triangles, levels, &at()).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
