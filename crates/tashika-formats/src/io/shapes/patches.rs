//! Shapes over a square: rectangle, cube, bilinear patch, height field.

use glam::{Vec2, Vec3};

use super::require;
use crate::error::{Location, Result};
use crate::scene::MeshData;

/// Most steps of a side of a bilinear patch.
const MAX_STEPS: u32 = 256;

/// Relative deviation from a parallelogram below which a patch is treated as one.
const FLAT: f32 = 1e-6;

/// The square `[−1, 1]²` at height 0, facing up, with texture coordinates from `(0, 0)` at its
/// least corner.
pub(in crate::io) fn rectangle() -> MeshData {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from);
    MeshData {
        positions: corners.map(|uv| (2.0 * uv - 1.0).extend(0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        uvs: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    }
}

/// The cube `[−1, 1]³` with flat sides, each of which shows the whole texture as in Mitsuba.
pub(in crate::io) fn cube() -> MeshData {
    // Normal and direction of `u`. `v` grows along `u × n`, so that an image whose first row is at
    // `v = 0` is upright and not mirrored.
    let sides = [
        (Vec3::NEG_Y, Vec3::Z),
        (Vec3::Y, Vec3::NEG_X),
        (Vec3::X, Vec3::Y),
        (Vec3::Z, Vec3::Y),
        (Vec3::NEG_X, Vec3::Y),
        (Vec3::NEG_Z, Vec3::NEG_Y),
    ];
    let mut mesh = MeshData::default();
    for (normal, right) in sides {
        let down = right.cross(normal);
        let first = mesh.positions.len() as u32;
        for [u, v] in [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]] {
            mesh.positions.push(normal + right * (2.0 * u - 1.0) + down * (2.0 * v - 1.0));
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(u, v));
        }
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
}

/// The patch `p(u, v) = (1 − u)(1 − v) p₀₀ + u (1 − v) p₁₀ + (1 − u) v p₀₁ + u v p₁₁`, with corners
/// in this order. It is divided into `steps · steps` cells; a parallelogram needs only one. Texture
/// coordinates are interpolated in the same way.
pub(in crate::io) fn bilinear_patch(
    corners: [Vec3; 4],
    uvs: [Vec2; 4],
    steps: u32,
    at: &Location,
) -> Result<MeshData> {
    require((1..=MAX_STEPS).contains(&steps), "steps", steps, "1 to 256 steps", at)?;
    let finite = corners.iter().all(|c| c.is_finite()) && uvs.iter().all(|c| c.is_finite());
    require(finite, "corners", format!("{corners:?}, {uvs:?}"), "finite numbers", at)?;
    let [p00, p10, p01, p11] = corners;
    let (along_u, along_v, twist) = (p10 - p00, p01 - p00, p00 - p10 - p01 + p11);
    let uv_twist = uvs[0] - uvs[1] - uvs[2] + uvs[3];
    let is_flat = twist.length() <= FLAT * (along_u.length() + along_v.length())
        && uv_twist.length() <= FLAT * (uvs[1] - uvs[0]).length().max((uvs[2] - uvs[0]).length());
    let steps = if is_flat { 1 } else { steps };
    let mut mesh = MeshData::default();
    let normal = |u: f32, v: f32| (along_u + twist * v).cross(along_v + twist * u).normalize_or_zero();
    for j in 0..=steps {
        for i in 0..=steps {
            let (u, v) = (i as f32 / steps as f32, j as f32 / steps as f32);
            mesh.positions.push((p00.lerp(p10, u)).lerp(p01.lerp(p11, u), v));
            mesh.uvs.push(uvs[0].lerp(uvs[1], u).lerp(uvs[2].lerp(uvs[3], u), v));
            // Where two corners coincide there is no normal; that of a nearby point is used.
            let inward = |t: f32| if t < 0.5 { t + 1e-3 } else { t - 1e-3 };
            let own = Some(normal(u, v)).filter(|n| *n != Vec3::ZERO);
            mesh.normals.push(own.unwrap_or_else(|| normal(inward(u), inward(v))));
        }
    }
    mesh.triangles = grid(steps + 1, steps + 1);
    Ok(mesh)
}

/// Height field over the unit square. Heights are listed row by row; each cell becomes two flat
/// triangles without normals.
pub(in crate::io) fn heightfield(size: [u32; 2], heights: &[f32], at: &Location) -> Result<MeshData> {
    let [columns, rows] = size;
    require(columns >= 2 && rows >= 2, "height field of", format!("{columns}×{rows}"), "at least 2×2", at)?;
    let count = u64::from(columns) * u64::from(rows);
    let fits = count == heights.len() as u64 && count <= u64::from(u32::MAX);
    require(fits, "number of heights", heights.len(), &format!("{columns}×{rows} heights"), at)?;
    let mut mesh = MeshData::default();
    for (row, heights) in heights.chunks_exact(columns as usize).enumerate() {
        for (column, &height) in heights.iter().enumerate() {
            let uv = Vec2::new(column as f32 / (columns - 1) as f32, row as f32 / (rows - 1) as f32);
            mesh.positions.push(uv.extend(height));
            mesh.uvs.push(uv);
        }
    }
    mesh.triangles = grid(columns, rows);
    Ok(mesh)
}

/// Two triangles for each cell of a grid of vertices.
fn grid(columns: u32, rows: u32) -> Vec<[u32; 3]> {
    let cell = |row: u32, column: u32| {
        let here = row * columns + column;
        let above = here + columns;
        [[here, here + 1, above + 1], [here, above + 1, above]]
    };
    (0..rows - 1).flat_map(|row| (0..columns - 1).flat_map(move |column| cell(row, column))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::checked_area;
    use super::*;

    fn at() -> Location {
        Location::line("a.pbrt", 7)
    }

    const SQUARE: [Vec2; 4] = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];

    #[test]
    fn rectangle_and_cube_have_their_areas_and_face_outward() {
        assert_eq!(checked_area(&rectangle()), 4.0);
        let cube = cube();
        assert_eq!(checked_area(&cube), 24.0);
        assert_eq!((cube.positions.len(), cube.triangles.len()), (24, 12));
        for (p, n) in cube.positions.iter().zip(&cube.normals) {
            assert_eq!((p.abs(), p.dot(*n)), (Vec3::ONE, 1.0));
        }
        // First side in Mitsuba's table of the cube.
        let (p, uv) = (&cube.positions[..2], &cube.uvs[..2]);
        assert_eq!(
            (p, uv),
            (&[Vec3::new(1., -1., -1.), Vec3::new(1., -1., 1.)][..], &[Vec2::Y, Vec2::ONE][..])
        );
    }

    #[test]
    fn patches_interpolate_their_corners() {
        let flat = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y, Vec3::new(2.0, 1.0, 0.0)];
        let mesh = bilinear_patch(flat, SQUARE, 16, &at()).unwrap();
        assert_eq!((checked_area(&mesh), mesh.triangles.len()), (2.0, 2));
        // z = x y over the unit square: ∫∫ √(1 + x² + y²) = 1.280789….
        let saddle = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE];
        let mesh = bilinear_patch(saddle, SQUARE, 16, &at()).unwrap();
        assert!((checked_area(&mesh) - 1.280_789).abs() < 1e-3);
        for ((p, n), uv) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs) {
            assert!((*p - Vec3::new(uv.x, uv.y, uv.x * uv.y)).length() < 1e-6);
            assert!(n.dot(Vec3::new(-uv.y, -uv.x, 1.0).normalize()) > 0.999_999);
        }
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Y];
        let mesh = bilinear_patch(triangle, SQUARE, 4, &at()).unwrap();
        assert!(mesh.normals.iter().all(|n| (*n - Vec3::Z).length() < 1e-3));
    }

    #[test]
    fn height_fields_run_over_the_unit_square() {
        let mesh = heightfield([3, 2], &[0.0, 0.0, 0.0, 1.0, 1.0, 5.0], &at()).unwrap();
        assert_eq!((mesh.positions[5], mesh.uvs[4]), (Vec3::new(1.0, 1.0, 5.0), Vec2::new(0.5, 1.0)));
        assert_eq!(mesh.triangles, [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]);
        assert!(mesh.normals.is_empty());
    }

    #[test]
    fn unusable_parameters_are_named() {
        for (mesh, expected) in [
            (bilinear_patch([Vec3::NAN; 4], SQUARE, 4, &at()), "finite numbers"),
            (bilinear_patch([Vec3::ONE; 4], SQUARE, 0, &at()), "steps 0"),
            (bilinear_patch([Vec3::ONE; 4], SQUARE, 100_000, &at()), "steps 100000"),
            (heightfield([1, 5], &[0.0; 5], &at()), "height field of 1×5"),
            (heightfield([2, 3], &[0.0; 5], &at()), "number of heights 5; expected 2×3"),
            (heightfield([u32::MAX; 2], &[0.0; 5], &at()), "number of heights 5"),
        ] {
            let text = mesh.unwrap_err().to_string();
            assert!(text.starts_with("a.pbrt:7: ") && text.contains(expected), "{text}");
        }
    }
}
