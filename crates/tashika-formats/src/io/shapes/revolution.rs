//! Surfaces of revolution about the z axis.
//!
//! A profile of points `p(v)` is turned by angles from 0 to `φ_max`:
//!
//! ```text
//! p(u, v) = R_z(u φ_max) p(v),   n = ∂p/∂u × ∂p/∂v
//! ```
//!
//! with [`COLUMNS`] steps per full turn. Flat triangles between points of a curved surface have
//! less area than the surface, and the power of a light is proportional to its area. Therefore
//! spheres are scaled, and disks and cylinders widened, until the area is exact; this changes the
//! radius by 0.1 %. Other shapes are widened until the circumference is exact, which leaves an
//! error below 0.2 % of the area. Held to this by the tests below.
//!
//! All angles are in radians.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::require;
use crate::error::{Location, Result};
use crate::math::elementary::{acos, sin_cos};
use crate::scene::MeshData;

/// Steps per full turn: the polygon is within 0.12 % of the circle's radius.
const COLUMNS: f32 = 64.0;
/// Steps per half turn from pole to pole.
const ROWS: f32 = 32.0;
/// Steps of a curved profile that is not a circle.
const PROFILE_STEPS: u32 = 32;

/// One point of a profile.
struct Point {
    position: Vec3,
    normal: Vec3,
    v: f32,
}

/// Power of the scale factor with which the area of a mesh grows.
#[derive(Clone, Copy)]
enum Growth {
    Linear,
    Squared,
}

/// A sphere around the origin, cut at two heights that are clamped to it; `v` runs from the lower
/// to the upper height.
pub(in crate::io) fn sphere(radius: f32, z_range: [f32; 2], phi_max: f32, at: &Location) -> Result<MeshData> {
    check_length("radius", radius, at)?;
    let [low, high] = ordered(z_range, at)?.map(|z| z.clamp(-radius, radius));
    require(low < high, "height range from", format!("{low} to {high}"), "a part of the sphere", at)?;
    let [first, last] = [low, high].map(|z| acos(-z / radius));
    let steps = ((last - first) / PI * ROWS).ceil().max(2.0) as u32;
    let profile = profile(steps, |v| {
        let (sin, cos) = sin_cos(first + (last - first) * v);
        // A pole lies exactly on the axis, however π is rounded.
        let on_axis = (v == 0.0 && low == -radius) || (v == 1.0 && high == radius);
        let normal = Vec3::new(if on_axis { 0.0 } else { sin }, 0.0, -cos);
        (normal * radius, normal)
    });
    let mut mesh = revolve(&profile, phi_max, at)?;
    let exact = f64::from(phi_max.min(TAU)) * f64::from(radius) * (f64::from(high) - f64::from(low));
    let scale = scale_to(&mesh, exact, Growth::Squared);
    mesh.positions.iter_mut().for_each(|p| *p *= scale);
    Ok(mesh)
}

/// A disk or ring at a height, facing up; `v` runs inward.
pub(in crate::io) fn disk(
    height: f32,
    radius: f32,
    inner_radius: f32,
    phi_max: f32,
    at: &Location,
) -> Result<MeshData> {
    check_length("radius", radius, at)?;
    require(height.is_finite(), "height", height, "a finite number", at)?;
    let valid = (0.0..radius).contains(&inner_radius);
    require(valid, "inner radius", inner_radius, "0 up to less than the radius", at)?;
    let profile = profile(1, |v| (Vec3::new(radius + (inner_radius - radius) * v, 0.0, height), Vec3::Z));
    let mut mesh = revolve(&profile, phi_max, at)?;
    let squares = f64::from(radius) * f64::from(radius) - f64::from(inner_radius) * f64::from(inner_radius);
    widen(&mut mesh, 0.5 * f64::from(phi_max.min(TAU)) * squares, Growth::Squared);
    Ok(mesh)
}

/// A cylinder without its ends; `v` runs up.
pub(in crate::io) fn cylinder(
    radius: f32,
    z_range: [f32; 2],
    phi_max: f32,
    at: &Location,
) -> Result<MeshData> {
    check_length("radius", radius, at)?;
    let [low, high] = ordered(z_range, at)?;
    require(low < high, "height range from", format!("{low} to {high}"), "two different heights", at)?;
    let profile = profile(1, |v| (Vec3::new(radius, 0.0, low + (high - low) * v), Vec3::X));
    let mut mesh = revolve(&profile, phi_max, at)?;
    let exact = f64::from(phi_max.min(TAU)) * f64::from(radius) * (f64::from(high) - f64::from(low));
    widen(&mut mesh, exact, Growth::Linear);
    Ok(mesh)
}

/// A cone without its base; `v` runs from the base at height 0 to the tip at `height`.
pub(in crate::io) fn cone(height: f32, radius: f32, phi_max: f32, at: &Location) -> Result<MeshData> {
    check_length("radius", radius, at)?;
    require(height.is_finite() && height != 0.0, "height", height, "a finite number other than 0", at)?;
    let normal = Vec3::new(height, 0.0, radius).normalize_or(Vec3::X);
    let profile = profile(1, |v| (Vec3::new(radius * (1.0 - v), 0.0, height * v), normal));
    revolve_widened(&profile, phi_max, at)
}

/// The paraboloid `z = z_max (x² + y²) / radius²` between two heights, of which negative ones are
/// clamped to 0; `v` runs up.
pub(in crate::io) fn paraboloid(
    radius: f32,
    z_range: [f32; 2],
    phi_max: f32,
    at: &Location,
) -> Result<MeshData> {
    check_length("radius", radius, at)?;
    let [low, high] = ordered(z_range, at)?.map(|z| z.max(0.0));
    require(
        low < high,
        "height range from",
        format!("{low} to {high}"),
        "two different heights above 0",
        at,
    )?;
    let inner = radius * (low / high).sqrt();
    // Steps are equal in the radius: equal steps in the height would be far apart near the tip.
    let mut profile = profile(PROFILE_STEPS, |t| {
        let r = inner + (radius - inner) * t;
        let slope = 2.0 * high * (r / radius) / radius;
        let normal = Vec3::new(slope, 0.0, -1.0).normalize_or(Vec3::NEG_Z);
        (Vec3::new(r, 0.0, high * (r / radius) * (r / radius)), normal)
    });
    for point in &mut profile {
        point.v = ((point.position.z - low) / (high - low)).clamp(0.0, 1.0);
    }
    revolve_widened(&profile, phi_max, at)
}

/// The hyperboloid that the segment between two points sweeps; `v` runs from the first point to the
/// second.
pub(in crate::io) fn hyperboloid(ends: [Vec3; 2], phi_max: f32, at: &Location) -> Result<MeshData> {
    let [first, last] = ends;
    let along = last - first;
    require(along.is_finite() && along != Vec3::ZERO, "segment along", along, "two different points", at)?;
    let profile = profile(PROFILE_STEPS, |v| {
        let point = first + along * v;
        let normal_at = |p: Vec3| Vec3::new(-p.y, p.x, 0.0).cross(along).normalize_or_zero();
        // On the axis `∂p/∂u` is 0 and there is no normal; that of a nearby point is used.
        let inward = if v < 0.5 { v + 1e-3 } else { v - 1e-3 };
        let normal = Some(normal_at(point)).filter(|n| *n != Vec3::ZERO);
        (point, normal.unwrap_or_else(|| normal_at(first + along * inward)))
    });
    let turns = profile.iter().all(|p| p.normal != Vec3::ZERO);
    require(turns, "segment along", along, "a segment that is not on the axis", at)?;
    revolve_widened(&profile, phi_max, at)
}

fn check_length(name: &str, length: f32, at: &Location) -> Result<()> {
    require(length.is_finite() && length > 0.0, name, length, "a finite number above 0", at)
}

/// Two heights, the lower first.
fn ordered([a, b]: [f32; 2], at: &Location) -> Result<[f32; 2]> {
    require(
        a.is_finite() && b.is_finite(),
        "height range from",
        format!("{a} to {b}"),
        "finite numbers",
        at,
    )?;
    Ok([a.min(b), a.max(b)])
}

fn profile(steps: u32, point: impl Fn(f32) -> (Vec3, Vec3)) -> Vec<Point> {
    let step = |i: u32| {
        let v = i as f32 / steps as f32;
        let (position, normal) = point(v);
        Point { position, normal, v }
    };
    (0..=steps).map(step).collect()
}

/// Turns a profile around the z axis, by a full turn at most.
fn revolve(profile: &[Point], phi_max: f32, at: &Location) -> Result<MeshData> {
    require(phi_max > 0.0, "angle", phi_max, "an angle above 0", at)?;
    let phi_max = phi_max.min(TAU);
    let columns = columns(phi_max);
    let rows = profile.len() as u32;
    let mut mesh = MeshData::default();
    for i in 0..=columns {
        let u = i as f32 / columns as f32;
        // A full turn ends at exactly the points at which it begins.
        let angle = if i == columns && phi_max == TAU { 0.0 } else { u * phi_max };
        let (sin, cos) = sin_cos(angle);
        let turned = |p: Vec3| Vec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z);
        for point in profile {
            mesh.positions.push(turned(point.position));
            mesh.normals.push(turned(point.normal));
            mesh.uvs.push(Vec2::new(u, point.v));
        }
    }
    let on_axis = |j: u32| profile[j as usize].position.truncate() == Vec2::ZERO;
    for i in 0..columns {
        for j in 0..rows - 1 {
            let (here, next) = (i * rows + j, (i + 1) * rows + j);
            if !on_axis(j) {
                mesh.triangles.push([here, next, next + 1]);
            }
            if !on_axis(j + 1) {
                mesh.triangles.push([here, next + 1, here + 1]);
            }
        }
    }
    Ok(mesh)
}

fn columns(phi_max: f32) -> u32 {
    (phi_max / TAU * COLUMNS).ceil().max(3.0) as u32
}

/// As [`revolve`], widened until arcs have their exact length.
fn revolve_widened(profile: &[Point], phi_max: f32, at: &Location) -> Result<MeshData> {
    let mut mesh = revolve(profile, phi_max, at)?;
    let half = 0.5 * phi_max.min(TAU) / columns(phi_max.min(TAU)) as f32;
    scale_radii(&mut mesh, half / sin_cos(half).0);
    Ok(mesh)
}

/// Widens the mesh until its area is `area` (m²).
fn widen(mesh: &mut MeshData, area: f64, growth: Growth) {
    let scale = scale_to(mesh, area, growth);
    scale_radii(mesh, scale);
}

fn scale_radii(mesh: &mut MeshData, scale: f32) {
    let scale = Vec3::new(scale, scale, 1.0);
    mesh.positions.iter_mut().for_each(|p| *p *= scale);
}

/// Factor on coordinates that gives the mesh the area `area` (m²).
fn scale_to(mesh: &MeshData, area: f64, growth: Growth) -> f32 {
    let double_area: f64 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
            (b - a).cross(c - a).length()
        })
        .sum();
    let ratio = 2.0 * area / double_area;
    let scale = match growth {
        Growth::Linear => ratio,
        Growth::Squared => ratio.sqrt(),
    };
    // An area beyond the range of numbers is not corrected.
    if scale.is_finite() { scale as f32 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI as PI64;

    use super::super::tests::checked_area;
    use super::*;

    const QUARTER: f32 = TAU / 4.0;

    fn at() -> Location {
        Location::line("a.pbrt", 7)
    }

    #[test]
    fn areas_of_spheres_disks_and_cylinders_are_exact() {
        for (mesh, exact) in [
            (sphere(2.0, [-2.0, 2.0], TAU, &at()), 16.0 * PI64),
            (sphere(2.0, [9.0, 0.5], QUARTER, &at()), 0.5 * PI64 * 2.0 * 1.5),
            (disk(3.0, 2.0, 0.0, TAU, &at()), 4.0 * PI64),
            (disk(3.0, 2.0, 1.0, 0.1, &at()), 0.1 * 1.5),
            (cylinder(0.5, [2.0, -1.0], 9.0, &at()), 3.0 * PI64),
            (cylinder(0.5, [-1.0, 2.0], QUARTER, &at()), 0.75 * PI64),
        ] {
            let area = checked_area(&mesh.unwrap());
            // The remaining error comes from rounding coordinates and angles to f32.
            assert!((area / exact - 1.0).abs() < 1e-6, "{area} {exact}");
        }
    }

    #[test]
    fn areas_of_other_shapes_are_within_two_thousandths() {
        let slant = 5.0_f64.sqrt();
        // z = x² + y² up to z = 1 has the area (π / 6) (5^{3/2} − 1). Up to z = 1/4 it has (π / 6)
        // (2^{3/2} − 1), which is subtracted if the surface begins there.
        let bowl = PI64 / 6.0 * (5.0 * slant - 1.0);
        let rim = PI64 / 6.0 * (5.0 * slant - 2.0 * 2.0_f64.sqrt());
        // The segment from (1, −1, −1) to (1, 1, 1) sweeps x² + y² = 1 + z²:
        // 2π ∫ √(1 + 2z²) dz = 2π (√3 + asinh(√2) / √2).
        let waist = 2.0 * PI64 * (3.0_f64.sqrt() + 2.0_f64.sqrt().asinh() / 2.0_f64.sqrt());
        for (mesh, exact) in [
            (cone(2.0, 1.0, TAU, &at()), PI64 * slant),
            (cone(-2.0, 1.0, QUARTER, &at()), 0.25 * PI64 * slant),
            (paraboloid(1.0, [0.0, 1.0], TAU, &at()), bowl),
            (paraboloid(1.0, [1.0, 0.25], TAU, &at()), rim),
            (hyperboloid([Vec3::new(1.0, -1.0, -1.0), Vec3::ONE], TAU, &at()), waist),
        ] {
            let area = checked_area(&mesh.unwrap());
            assert!((area / exact - 1.0).abs() < 2e-3, "{area} {exact}");
        }
    }

    #[test]
    fn vertices_lie_where_their_coordinates_say_with_normals_outward() {
        let mesh = sphere(2.0, [-1.0, 2.0], QUARTER, &at()).unwrap();
        for ((p, n), uv) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs) {
            assert!((p.length() - 2.0).abs() < 0.004 && n.angle_between(*p) < 1e-3);
            let (sin, cos) = sin_cos(uv.x * QUARTER);
            let direction = Vec2::new(cos, sin);
            assert!((p.truncate() - direction * p.truncate().length()).length() < 1e-5);
            // θ from the south pole: 60° at z = −1, 180° at the top.
            let z = -2.0 * sin_cos(PI / 3.0 + uv.y * PI * 2.0 / 3.0).1;
            assert!((p.z - z).abs() < 0.004, "{p} {uv}");
        }
        let up = disk(3.0, 2.0, 1.0, TAU, &at()).unwrap();
        assert!(up.normals.iter().all(|n| *n == Vec3::Z));
        let (outer, inner) = (up.positions[0], up.positions[1]);
        assert!((outer.x - 2.0).abs() < 0.01 && (inner.x - 1.0).abs() < 0.01 && outer.z == 3.0);
        assert_eq!((up.uvs[0], up.uvs[1]), (Vec2::ZERO, Vec2::Y));
        let tip = cone(2.0, 1.0, TAU, &at()).unwrap();
        assert_eq!((tip.positions[1], tip.uvs[1]), (Vec3::new(0.0, 0.0, 2.0), Vec2::Y));
        assert!(tip.normals[0].dot(Vec3::new(1.0, 0.0, 0.0)) > 0.8);
        let bowl = paraboloid(1.0, [0.0, 1.0], TAU, &at()).unwrap();
        assert_eq!((bowl.positions[0], bowl.normals[0]), (Vec3::ZERO, Vec3::NEG_Z));
    }

    #[test]
    fn full_turns_close_without_a_gap() {
        let mesh = sphere(1.0, [-1.0, 1.0], TAU, &at()).unwrap();
        let rows = ROWS as usize + 1;
        let (first, last) = (&mesh.positions[..rows], &mesh.positions[mesh.positions.len() - rows..]);
        assert_eq!(first, last);
        assert_eq!((mesh.uvs[0].x, mesh.uvs.last().unwrap().x), (0.0, 1.0));
        assert_eq!(mesh.triangles.len(), 64 * (2 * 32 - 2), "none at the poles without area");
    }

    #[test]
    fn unusable_parameters_are_named() {
        let (nan, z) = (f32::NAN, [-1.0, 1.0]);
        for (mesh, expected) in [
            (sphere(nan, z, TAU, &at()), "radius NaN; expected a finite number above 0"),
            (sphere(-1.0, z, TAU, &at()), "radius -1"),
            (sphere(1.0, z, 0.0, &at()), "angle 0"),
            (sphere(1.0, z, nan, &at()), "angle NaN"),
            (sphere(1.0, [2.0, 3.0], TAU, &at()), "height range from 1 to 1"),
            (sphere(1.0, [nan, 3.0], TAU, &at()), "height range from NaN to 3"),
            (disk(0.0, 1.0, 1.0, TAU, &at()), "inner radius 1"),
            (disk(nan, 1.0, 0.0, TAU, &at()), "height NaN"),
            (cylinder(1.0, [1.0, 1.0], TAU, &at()), "height range from 1 to 1"),
            (cone(0.0, 1.0, TAU, &at()), "height 0"),
            (paraboloid(1.0, [-1.0, 0.0], TAU, &at()), "two different heights above 0"),
            (hyperboloid([Vec3::ONE; 2], TAU, &at()), "two different points"),
            (hyperboloid([Vec3::Z, Vec3::ZERO], TAU, &at()), "not on the axis"),
        ] {
            let text = mesh.unwrap_err().to_string();
            assert!(text.starts_with("a.pbrt:7: ") && text.contains(expected), "{text}");
        }
        for huge in [f32::MAX, f32::MIN_POSITIVE] {
            assert!(sphere(huge, [-huge, huge], TAU, &at()).is_ok());
            assert!(cylinder(huge, z, TAU, &at()).is_ok());
        }
    }
}
