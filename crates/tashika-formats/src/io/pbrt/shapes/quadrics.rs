//! Quadrics, by their parameters.

use super::Prototype;
use crate::error::Result;
use crate::io::pbrt::loading::Loading;
use crate::io::pbrt::parameters::Parameters;
use crate::io::shapes;
use crate::math::Vec3;
use crate::scene::{MeshData, NoteKind};

/// Names of quadrics and of their parameters, with defaults, in the order of pbrt's documentation.
const QUADRICS: &[(&str, &[(&str, f32)])] = &[
    // Without bounds the sphere is whole: see `numbers`.
    ("sphere", &[("radius", 1.0), ("zmin", f32::MIN), ("zmax", f32::MAX), ("phimax", 360.0)]),
    ("disk", &[("height", 0.0), ("radius", 1.0), ("innerradius", 0.0), ("phimax", 360.0)]),
    ("cylinder", &[("radius", 1.0), ("zmin", -1.0), ("zmax", 1.0), ("phimax", 360.0)]),
    ("cone", &[("height", 1.0), ("radius", 1.0), ("phimax", 360.0)]),
    ("paraboloid", &[("radius", 1.0), ("zmin", 0.0), ("zmax", 1.0), ("phimax", 360.0)]),
    ("hyperboloid", &[("phimax", 360.0)]),
];

/// Prototype of a shape, if it is a quadric.
pub(super) fn prototype(class: &str, p: &Parameters) -> Option<Prototype> {
    let (name, _) = QUADRICS.iter().find(|(name, _)| *name == class)?;
    let bits = numbers(class, p).into_iter().map(f32::to_bits).collect();
    Some(Prototype::Quadric(name, bits))
}

/// Parameters in the order of the table. For hyperboloids the two points follow.
fn numbers(class: &str, p: &Parameters) -> Vec<f32> {
    let parameters = QUADRICS.iter().find(|(name, _)| *name == class).map_or(&[][..], |q| q.1);
    let mut values: Vec<f32> =
        parameters.iter().map(|(name, default)| p.float(name).unwrap_or(*default)).collect();
    match class {
        "sphere" => {
            let radius = values[0].abs();
            values[1] = values[1].clamp(-radius, radius);
            values[2] = values[2].clamp(-radius, radius);
        }
        "hyperboloid" => {
            let point = |name, default: Vec3| p.vector(name).map_or(default, |v| v.as_vec3());
            values.extend(point("p1", Vec3::ZERO).to_array());
            values.extend(point("p2", Vec3::ONE).to_array());
        }
        _ => {}
    }
    values
}

/// Returns the triangles of a quadric; none, with a note, if its parameters give no surface.
pub(super) fn mesh(loading: &mut Loading<'_>, class: &str, p: &Parameters) -> Result<Option<MeshData>> {
    let at = p.at();
    let n = numbers(class, p);
    let made = match (class, &n[..]) {
        ("sphere", &[radius, low, high, phi]) => shapes::sphere(radius, [low, high], radians(phi), &at),
        ("disk", &[height, radius, inner, phi]) => shapes::disk(height, radius, inner, radians(phi), &at),
        ("cylinder", &[radius, low, high, phi]) => shapes::cylinder(radius, [low, high], radians(phi), &at),
        ("cone", &[height, radius, phi]) => shapes::cone(height, radius, radians(phi), &at),
        ("paraboloid", &[radius, low, high, phi]) => {
            shapes::paraboloid(radius, [low, high], radians(phi), &at)
        }
        ("hyperboloid", &[phi, a, b, c, d, e, f]) => {
            shapes::hyperboloid([Vec3::new(a, b, c), Vec3::new(d, e, f)], radians(phi), &at)
        }
        _ => return Ok(None),
    };
    Ok(match made {
        Ok(data) => Some(data),
        Err(_) => {
            loading.note(NoteKind::Repaired, "quadrics whose parameters give no surface: left out", at);
            None
        }
    })
}

/// Converts an angle of the file to radians, clamped to 0 to a whole turn.
fn radians(degrees: f32) -> f32 {
    degrees.clamp(0.0, 360.0).to_radians()
}
