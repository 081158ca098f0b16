//! Shapes with flat faces.

use glam::{Vec2, Vec3};

use super::Shape;

/// Creates the parallelogram `corner + s · edges[0] + t · edges[1]`; its front is the side of
/// `edges[0] × edges[1]`.
pub fn quad(corner: Vec3, edges: [Vec3; 2]) -> Shape {
    let [e, f] = edges;
    Shape {
        positions: vec![corner, corner + e, corner + e + f, corner + f],
        normals: vec![e.cross(f).normalize(); 4],
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// Creates the box from corner `lo` to corner `hi` with sharp edges.
pub fn box_between(lo: Vec3, hi: Vec3) -> Shape {
    let size = hi - lo;
    Shape::merged((0..3).flat_map(|axis| {
        // Edges of a face at right angles to `axis`, in the order for which their cross product
        // points along the axis.
        let e = Vec3::AXES[(axis + 1) % 3] * size;
        let f = Vec3::AXES[(axis + 2) % 3] * size;
        [quad(lo, [f, e]), quad(lo + Vec3::AXES[axis] * size, [e, f])]
    }))
}

/// Creates the box from `lo` to `hi` with edges cut at 45° by `bevel` (m), shaded as if rounded.
///
/// Its volume is `abc − 2β²(a + b + c − 6β) − 20β³/3` for edges `a, b, c` and bevel `β`.
pub fn bevelled_box(lo: Vec3, hi: Vec3, bevel: f32) -> Shape {
    let center = 0.5 * (lo + hi);
    let half = 0.5 * (hi - lo);
    let mut shape = Shape::default();
    // Three vertices per corner, one on each adjacent face. Bit `k` of a corner's number is its
    // side along axis `k`.
    let vertex = |corner: usize, axis: usize| (corner * 3 + axis) as u32;
    for corner in 0..8usize {
        let sign = Vec3::from_array([0, 1, 2].map(|k| if corner >> k & 1 == 1 { 1.0 } else { -1.0 }));
        for axis in 0..3 {
            let inset = (Vec3::ONE - Vec3::AXES[axis]) * bevel;
            let p = center + sign * (half - inset);
            shape.positions.push(p);
            shape.normals.push(Vec3::AXES[axis] * sign[axis]);
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            shape.uvs.push(Vec2::new(p[u], p[v]));
        }
    }
    // Each polygon is listed by its corners and turned to face outwards.
    let mut polygon = |corners: &[u32]| {
        let p = |i: usize| shape.positions[corners[i] as usize];
        let normal = (p(1) - p(0)).cross(p(2) - p(0));
        let outwards = normal.dot(p(0) + p(1) + p(2) - 3.0 * center) > 0.0;
        for i in 1..corners.len() - 1 {
            let [a, b, c] = [corners[0], corners[i], corners[i + 1]];
            shape.triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
        }
    };
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for side in [0, 1 << axis] {
            polygon(&[side, side | u, side | u | v, side | v].map(|c| vertex(c, axis)));
        }
        // The four edges along `axis`, each between a face across `u` and one across `v`.
        let (fu, fv) = ((axis + 1) % 3, (axis + 2) % 3);
        for corner in [0, u, v, u | v] {
            let far = corner | 1 << axis;
            polygon(&[vertex(corner, fu), vertex(far, fu), vertex(far, fv), vertex(corner, fv)]);
        }
    }
    for corner in 0..8 {
        polygon(&[0, 1, 2].map(|axis| vertex(corner, axis)));
    }
    shape
}
