//! Named shapes: cubes, spheres, cylinders, cones, planes.
//!
//! They are centred on the origin. Cylinders and cones have their axis along `axis` and are closed;
//! planes are at right angles to `axis`. Curved shapes are meshes that have the area of the true
//! shape (cones nearly).
//!
//! Held to this by `usd_meshes::shapes_have_their_areas_and_axes`.

use glam::{DAffine3, DMat3, DVec3};

use super::Stage;
use super::features::met;
use super::materials::MeshAppearance;
use super::prim::Prim;
use super::walk::State;
use crate::error::{Location, Result};
use crate::io::shapes;
use crate::scene::{MeshData, MeshId, NoteKind};

impl Stage<'_> {
    /// Mesh of a shape, and its transform in the prim; none, with a note, if the shape is ignored.
    pub fn shape_of(&mut self, prim: &Prim, kind: &str, state: &State) -> Result<Option<(MeshId, DAffine3)>> {
        let at = self.at(prim);
        if kind == "Capsule" {
            met("prim", "Capsule", at, &mut self.builder)?;
            return Ok(None);
        }
        let names: [(&str, f64); 2] = match kind {
            "Cube" => [("size", 2.0); 2],
            "Plane" => [("width", 2.0), ("length", 2.0)],
            "Sphere" => [("radius", 1.0); 2],
            _ => [("radius", 1.0), ("height", 2.0)],
        };
        let Some([first, second]) = self.sizes(prim, "", names)? else { return Ok(None) };
        let (data, scale) = match kind {
            "Cube" => (shapes::cube(), DVec3::splat(0.5 * first)),
            "Plane" => (shapes::rectangle(), DVec3::new(0.5 * first, 0.5 * second, 1.0)),
            "Sphere" => (unit_sphere(&at)?, DVec3::splat(first)),
            kind => {
                let data = if kind == "Cone" { closed_cone(&at)? } else { closed_cylinder(&at)? };
                (data, DVec3::new(first, first, 0.5 * second))
            }
        };
        let axis = self.word(prim, "axis")?;
        let turn = match (kind, axis.as_deref()) {
            ("Cube" | "Sphere", _) => DMat3::IDENTITY,
            // The width of a plane is along z or x. The axes form a rotation without a reflection.
            ("Plane", Some("X")) => DMat3::from_cols(DVec3::Z, DVec3::NEG_Y, DVec3::X),
            ("Plane", Some("Y")) => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
            (_, Some("X")) => DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
            (_, Some("Y")) => DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y),
            _ => DMat3::IDENTITY,
        };
        let look = MeshAppearance { is_double_sided: self.is_true(prim, "doubleSided")?, shown: state.shown };
        let material = self.material(state.bindings.material(), look)?;
        let key = (kind.to_owned(), material.id);
        let mesh = match self.shapes.get(&key) {
            Some(mesh) => *mesh,
            None => {
                let mesh = self.builder.add_mesh(MeshData { name: kind.to_owned(), ..data }, material.id)?;
                *self.shapes.entry(key).or_insert(mesh)
            }
        };
        Ok(Some((mesh, DAffine3::from_mat3(turn) * DAffine3::from_scale(scale))))
    }
}

impl Stage<'_> {
    /// Returns the sizes of a shape or a light, given the prefix of their names, the names and the
    /// fallbacks; none, with a note, if a size is not above 0.
    pub fn sizes<const N: usize>(
        &mut self,
        prim: &Prim,
        prefix: &str,
        names: [(&str, f64); N],
    ) -> Result<Option<[f64; N]>> {
        let mut sizes = [0.0; N];
        for (size, (name, fallback)) in sizes.iter_mut().zip(names) {
            let full = format!("{prefix}{name}");
            *size = match self.number(prim, &full)? {
                Some(number) => number,
                // Older files write the names of lights without the prefix.
                None => self.number_or(prim, name, fallback)?,
            };
            if *size <= 0.0 {
                let message = "shapes and lights whose size is not above 0: left out";
                let at = self.at_property(prim, &full);
                self.builder.note(NoteKind::Repaired, message, at);
                return Ok(None);
            }
        }
        Ok(Some(sizes))
    }
}

/// Sphere of radius 1.
pub(super) fn unit_sphere(at: &Location) -> Result<MeshData> {
    shapes::sphere(1.0, [-1.0, 1.0], std::f32::consts::TAU, at)
}

/// Cylinder of radius 1 between the heights −1 and 1, without its ends.
pub(super) fn unit_cylinder(at: &Location) -> Result<MeshData> {
    shapes::cylinder(1.0, [-1.0, 1.0], std::f32::consts::TAU, at)
}

/// Disk of radius 1, facing up.
pub(super) fn unit_disk(at: &Location) -> Result<MeshData> {
    shapes::disk(0.0, 1.0, 0.0, std::f32::consts::TAU, at)
}

/// A disk at a height, facing up or down.
fn lid(height: f32, is_up: bool, at: &Location) -> Result<MeshData> {
    let mut lid = shapes::disk(height, 1.0, 0.0, std::f32::consts::TAU, at)?;
    if !is_up {
        lid.turn_around();
    }
    Ok(lid)
}

fn closed_cylinder(at: &Location) -> Result<MeshData> {
    let with_top = joined(unit_cylinder(at)?, lid(1.0, true, at)?);
    Ok(joined(with_top, lid(-1.0, false, at)?))
}

fn closed_cone(at: &Location) -> Result<MeshData> {
    let mut cone = shapes::cone(2.0, 1.0, std::f32::consts::TAU, at)?;
    cone.positions.iter_mut().for_each(|p| p.z -= 1.0);
    Ok(joined(cone, lid(-1.0, false, at)?))
}

/// Joins two meshes.
fn joined(mut a: MeshData, b: MeshData) -> MeshData {
    let first = a.positions.len() as u32;
    a.positions.extend(b.positions);
    a.normals.extend(b.normals);
    a.uvs.extend(b.uvs);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|i| i + first)));
    a
}
