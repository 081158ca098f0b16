//! The only tessellator: a rectangle of vertices, whose opposite ends may be joined.
//!
//! Vertex `(i, j)` of `(columns + 1) × (rows + 1)` is `position(i, j)`; its texture coordinates are
//! `(i / columns, j / rows)`. The front is the side of `∂p/∂i × ∂p/∂j`. The unit normal of a cell
//! is the direction of the cross product of its diagonals. A vertex normal is the normalised sum of
//! the unit normals of the cells around it. Where neighbouring cells have equal sizes, its error is
//! of second order in their size.

use glam::{Vec2, Vec3};

use super::Shape;

/// Treatment of the two ends of a row or column of vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// Both ends are edges of the surface.
    Open,
    /// The last vertex is the first again.
    Joined,
}

/// Tessellates a surface over `cells = [columns, rows]`, with `ends` for each of the two
/// directions.
///
/// Where ends are joined, `position` is not called for the last index. Two consecutive rows with
/// equal positions make a crease: the normals on its two sides are not averaged. A row whose
/// positions are all equal is a pole.
pub fn grid(cells: [usize; 2], ends: [Ends; 2], position: impl Fn(usize, usize) -> Vec3) -> Shape {
    let [columns, rows] = cells;
    // Maps an index to itself; if the ends are joined, maps the last index to the first.
    let own = |i: usize, n: usize, ends: Ends| if ends == Ends::Joined && i == n { 0 } else { i };
    let at = |i: usize, j: usize| j * (columns + 1) + i;
    let source = |i: usize, j: usize| (own(i, columns, ends[0]), own(j, rows, ends[1]));

    let mut shape = Shape::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let (a, b) = source(i, j);
            shape.positions.push(position(a, b));
            shape.uvs.push(Vec2::new(i as f32 / columns as f32, j as f32 / rows as f32));
        }
    }
    let mut sums = vec![Vec3::ZERO; shape.positions.len()];
    for j in 0..rows {
        for i in 0..columns {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let p = corners.map(|(i, j)| shape.positions[at(i, j)]);
            // A cell without area, as at a crease, does not contribute.
            let normal = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
            for (i, j) in corners {
                let (a, b) = source(i, j);
                sums[at(a, b)] += normal;
            }
            let index = corners.map(|(i, j)| at(i, j) as u32);
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                if p[a] != p[b] && p[b] != p[c] && p[c] != p[a] {
                    shape.triangles.push([index[a], index[b], index[c]]);
                }
            }
        }
    }
    for j in [0, rows] {
        let row = at(0, j)..at(columns, j) + 1;
        let first = shape.positions[row.start];
        if shape.positions[row.clone()].iter().all(|&p| p == first) {
            let total: Vec3 = sums[row.clone()].iter().sum();
            sums[row].fill(total);
        }
    }
    for j in 0..=rows {
        for i in 0..=columns {
            let (a, b) = source(i, j);
            shape.normals.push(sums[at(a, b)].normalize_or(Vec3::Y));
        }
    }
    shape
}
