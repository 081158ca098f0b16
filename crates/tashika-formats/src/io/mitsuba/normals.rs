//! Vertex normals of meshes that have none.
//!
//! Mitsuba gives smooth normals to meshes without any, unless `face_normals` is set. The normal of
//! a vertex is the mean of the normals of its triangles, weighted with their angles at the vertex,
//!
//! ```text
//!   n = Σ αᵢ nᵢ / ‖Σ αᵢ nᵢ‖
//! ```
//!
//! (Thürmer and Wüthrich 1998, equation 1). Vertices are not merged: an edge between faces that
//! share no vertices stays sharp. Sums run in `f64`, in the order of the file.
//!
//! Held to this by the tests below.

use glam::{DVec3, Vec3};

use crate::math::elementary::acos;

/// Returns a unit normal for each vertex; zero if its triangles define none.
pub(super) fn of_vertices(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let corners = triangle.map(|i| positions[i as usize].as_dvec3());
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        for i in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
            let cosine = (b - a).normalize_or_zero().dot((c - a).normalize_or_zero());
            sums[triangle[i] as usize] += normal * f64::from(acos(cosine as f32));
        }
    }
    sums.into_iter().map(|sum| sum.normalize_or_zero().as_vec3()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A corner of a cube. One of its three faces has two triangles at the vertex, the others have
    /// one each. The normal lies along the diagonal.
    #[test]
    fn how_a_face_is_cut_does_not_matter() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(1.0, 1.0, 0.0)];
        let triangles = [[0, 2, 4], [0, 4, 1], [0, 1, 3], [0, 3, 2]];
        let normal = of_vertices(&positions, &triangles)[0];
        assert!((normal - Vec3::splat(-1.0).normalize()).length() < 1e-5, "{normal}");
    }

    #[test]
    fn vertices_without_a_triangle_have_none() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let normals = of_vertices(&positions, &[[0, 1, 2]]);
        assert_eq!(normals, [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::ZERO]);
    }
}
