//! pbrt's cameras that see all directions: every point of the film has the direction of pbrt's
//! formula.
//!
//! The formulas are written out here from the format's description, in its left-handed frame. They
//! share no code with the library, except the known directions of the octahedron.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use tashika::math::elementary::sin_cos;
use tashika::scene::{CameraSample, NoteKind, Projection, Scene, SphereMap};

use crate::pbrt::{TRIANGLE, notes, scene};

const FILM: &str = "Film \"image\" \"integer xresolution\" 400 \"integer yresolution\" 200 ";

/// Direction through a point of the film, given in fractions from the top left.
fn direction(scene: &Scene, u: f32, v: f32) -> Vec3 {
    let camera = &scene.cameras()[0];
    let size = camera.resolution.expect("the film's");
    let film = Vec2::new(u, v) * Vec2::new(size[0] as f32, size[1] as f32);
    camera.ray(&CameraSample { film, lens: [0.5; 2], time: 0.5 }, size).expect("a ray everywhere").direction
}

/// pbrt's direction in its camera's frame: x to the right, y up, z ahead.
fn by_angles(u: f32, v: f32) -> Vec3 {
    let ((sin_theta, cos_theta), (sin_phi, cos_phi)) = (sin_cos(PI * v), sin_cos(2.0 * PI * u));
    Vec3::new(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi)
}

fn camera(before: &str, camera: &str) -> Scene {
    scene(&format!("{FILM} {before} Camera {camera} WorldBegin {TRIANGLE} WorldEnd"))
}

#[test]
fn latitudes_and_longitudes_are_those_of_pbrt() {
    for words in ["\"environment\"", "\"spherical\" \"string mapping\" \"equirectangular\""] {
        let plain = camera("", words);
        for (u, v) in [(0.0, 0.5), (0.25, 0.5), (0.5, 0.5), (0.1, 0.3), (0.7, 0.8), (0.95, 0.1)] {
            let (found, expected) = (direction(&plain, u, v), by_angles(u, v));
            assert!((found - expected).length() < 1e-5, "{words} at {u}, {v}: {found} for {expected}");
        }
        // A camera at (1, 2, 3) that looks along −z. pbrt's x, which is to the right in its
        // perspective picture, is −x of the world here.
        let placed = camera("LookAt 1 2 3  1 2 -7  0 1 0", words);
        assert_eq!(placed.cameras()[0].position(), Vec3::new(1.0, 2.0, 3.0));
        for (u, v, expected) in [(0.25, 0.5, Vec3::NEG_Z), (0.0, 0.5, Vec3::NEG_X), (0.4, 0.0, Vec3::Y)] {
            let found = direction(&placed, u, v);
            assert!((found - expected).length() < 2e-5, "{words} at {u}, {v}: {found}");
        }
        assert!(plain.notes().first_departure().is_none(), "{:?}", notes(&plain));
    }
}

#[test]
fn equal_areas_are_those_of_pbrt() {
    for words in ["\"spherical\"", "\"spherical\" \"string mapping\" \"equalarea\""] {
        let plain = camera("", words);
        // Points of pbrt's octahedron, with z up before y and z are swapped: the centre, midpoints
        // of edges, a corner.
        for (u, v, expected) in [
            (0.5, 0.5, Vec3::Y),
            (1.0, 0.5, Vec3::X),
            (0.0, 0.5, Vec3::NEG_X),
            (0.5, 1.0, Vec3::Z),
            (0.5, 0.0, Vec3::NEG_Z),
            (1.0, 1.0, Vec3::NEG_Y),
        ] {
            let found = direction(&plain, u, v);
            assert!((found - expected).length() < 2e-3, "{words} at {u}, {v}: {found} for {expected}");
        }
        assert!(plain.notes().first_departure().is_none(), "{:?}", notes(&plain));
    }
}

#[test]
fn what_spherical_cameras_do_not_use_is_taken_and_unknown_mappings_are_told() {
    let unused =
        "\"environment\" \"float lensradius\" 2 \"float focaldistance\" 3 \"float screenwindow\" [0 1 0 1]";
    let taken = camera("", unused);
    assert!(taken.notes().first_departure().is_none(), "{:?}", notes(&taken));
    assert_eq!(taken.cameras()[0].lens.radius, 0.0);
    let odd = camera("", "\"spherical\" \"string mapping\" \"mercator\"");
    assert_eq!(odd.cameras()[0].projection, Projection::Spherical { map: SphereMap::EqualArea });
    let (kind, message) = &notes(&odd)[0];
    assert!(*kind == NoteKind::Repaired && message.contains("equirectangular"), "{message}");
}
