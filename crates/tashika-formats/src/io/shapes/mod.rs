//! Shapes of scene formats, as triangles.
//!
//! Output: meshes with unit normals and texture coordinates, in the shape's own coordinates (m).
//! Seen from the side that their normals point to, triangles run counter-clockwise. The normals are
//! `∂p/∂u × ∂p/∂v` of pbrt's parametrisation: outward for closed shapes.
//!
//! # Guarantee
//! Each parameter is checked: the result is a mesh of bounded size, or an error that names the
//! parameter. The number of triangles depends on angles and steps, not on sizes.
//!
//! | module | shapes |
//! |---|---|
//! | [`revolution`] | sphere, disk, cylinder, cone, paraboloid, hyperboloid |
//! | [`patches`] | rectangle, cube, bilinear patch, height field |
//! | [`subdivision`] | Loop's subdivision surfaces |
//!
//! Sources: Pharr 2023, chapter 6, for the parametrisations. Held to this by the tests in the
//! modules.

mod patches;
mod revolution;
mod subdivision;

pub(super) use patches::{bilinear_patch, cube, heightfield, rectangle};
pub(super) use revolution::{cone, cylinder, disk, hyperboloid, paraboloid, sphere};
pub(super) use subdivision::loop_subdivision;

use std::fmt::Display;

use crate::error::{Error, Location, Result};

/// Refuses a parameter unless it is `accepted`.
fn require(accepted: bool, name: &str, value: impl Display, expected: &str, at: &Location) -> Result<()> {
    if accepted { Ok(()) } else { Err(Error::invalid(at.clone(), format!("{name} {value}"), expected)) }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::scene::MeshData;

    /// Returns the area (m²) of a mesh. Checks that its normals are unit vectors on the front side
    /// of the triangles.
    pub(super) fn checked_area(mesh: &MeshData) -> f64 {
        assert_eq!(mesh.normals.len(), mesh.positions.len());
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5), "unit normals");
        mesh.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
                let double = (b - a).cross(c - a);
                let normal: Vec3 = t.iter().map(|&i| mesh.normals[i as usize]).sum();
                assert!(double.dot(normal.as_dvec3()) > 0.0, "triangle {t:?} faces away from its normals");
                0.5 * double.length()
            })
            .sum()
    }
}
