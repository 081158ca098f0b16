//! Cameras of Mitsuba files, compared with rays of Mitsuba 3.9 and with the formulas of Mitsuba
//! 0.6.

use tashika::film::Window;
use tashika::math::elementary::sin_cos;
use tashika::math::{Vec2, Vec3};
use tashika::scene::{Camera, CameraSample};

use crate::mitsuba::{load, notes};

fn camera(body: &str) -> Camera {
    let scene = load(body);
    assert_eq!(notes(&scene), []);
    scene.cameras()[0].clone()
}

/// Direction of the ray through a point of the film, scaled to depth 1. `x` and `y` are fractions
/// of the film.
fn looks(camera: &Camera, x: f32, y: f32) -> [f32; 3] {
    let size = camera.resolution.unwrap();
    let film = Vec2::new(x * size[0] as f32, y * size[1] as f32);
    let d = camera.ray(&CameraSample { film, lens: [0.5; 2], time: 0.5 }, size).unwrap().direction;
    (d / d.z.abs()).to_array()
}

#[test]
fn cameras_look_where_mitsuba_looks() {
    let perspective = |inside: &str, film: &str| {
        camera(&format!(
            "<sensor type=\"perspective\"><float name=\"fov\" value=\"90\"/>{inside}<film type=\"hdrfilm\">\
             <integer name=\"width\" value=\"200\"/><integer name=\"height\" value=\"100\"/>{film}</film></sensor>"
        ))
    };
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3);
    // Mitsuba 3.9: directions of rays through the film, for a camera at the origin.
    let c = perspective("", "");
    assert!(near(looks(&c, 0.0, 0.5), [1.0, 0.0, 1.0]) && near(looks(&c, 0.5, 0.0), [0.0, 0.5, 1.0]));
    for (axis, corner) in [
        ("x", [1.0, 0.5]),
        ("y", [2.0, 1.0]),
        ("smaller", [2.0, 1.0]),
        ("larger", [1.0, 0.5]),
        ("diagonal", [0.8944, 0.4472]),
    ] {
        let c = perspective(&format!("<string name=\"fov_axis\" value=\"{axis}\"/>"), "");
        assert!(near(looks(&c, 0.0, 0.0), [corner[0], corner[1], 1.0]), "{axis}");
    }
    let offset = perspective(
        "<float name=\"principal_point_offset_x\" value=\"0.1\"/><float name=\"principal_point_offset_y\" value=\"0.1\"/>",
        "",
    );
    assert!(near(looks(&offset, 0.5, 0.5), [-0.2, -0.1, 1.0]));
    let window = "<integer name=\"crop_width\" value=\"50\"/><integer name=\"crop_height\" value=\"40\"/>\
                  <integer name=\"crop_offset_x\" value=\"10\"/><integer name=\"crop_offset_y\" value=\"20\"/>";
    let c = perspective("", window);
    assert_eq!(
        (c.resolution, c.crop),
        (Some([200, 100]), Some(Window { x: 10, y: 20, width: 50, height: 40 }))
    );
    let moved = perspective(
        "<transform name=\"to_world\"><lookat origin=\"0 0 -5\" target=\"0 0 0\" up=\"0 1 0\"/></transform>",
        "",
    );
    assert!(
        (moved.position() - Vec3::Z * -5.0).length() < 1e-6 && near(looks(&moved, 0.5, 0.5), [0.0, 0.0, 1.0])
    );
    let focal = camera(
        "<sensor type=\"perspective\"><string name=\"focal_length\" value=\"50mm\"/><film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/><integer name=\"height\" value=\"100\"/></film></sensor>",
    );
    assert!(near(looks(&focal, 0.0, 0.0), [0.387, 0.1935, 1.0]));
}

#[test]
fn lenses_and_parallel_cameras_are_read() {
    let lens = camera(
        "<sensor type=\"thinlens\"><float name=\"fov\" value=\"40\"/><float name=\"aperture_radius\" value=\"0.25\"/><float name=\"focus_distance\" value=\"7\"/></sensor>",
    );
    assert_eq!((lens.lens.radius, lens.lens.focus_distance), (0.25, 7.0));
    let parallel = camera(
        "<sensor type=\"orthographic\" id=\"plan\"><film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/><integer name=\"height\" value=\"100\"/></film></sensor>",
    );
    let ray =
        parallel.ray(&CameraSample { film: Vec2::ZERO, lens: [0.5; 2], time: 0.5 }, [200, 100]).unwrap();
    // Mitsuba 3.9: the film is two units wide, with its left side at +x.
    assert!(
        (ray.origin - Vec3::new(1.0, 0.5, 0.0)).length() < 1e-5 && (ray.direction - Vec3::Z).length() < 1e-6
    );
    assert_eq!(parallel.name, "plan");
}

/// A turned camera; expected directions are computed by Mitsuba 0.6's formula.
#[test]
fn spherical_cameras_look_where_mitsuba_looks() {
    let c = camera(
        "<sensor type=\"spherical\"><transform name=\"toWorld\"><lookat origin=\"1 2 3\" target=\"1 2 4\" up=\"0 1 0\"/></transform>\
         <film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/><integer name=\"height\" value=\"100\"/></film></sensor>",
    );
    assert_eq!(c.position(), Vec3::new(1.0, 2.0, 3.0));
    for (u, v) in [(0.5f32, 0.5f32), (0.25, 0.5), (0.1, 0.2), (0.8, 0.9), (0.6, 0.35)] {
        let (phi, theta) = (2.0 * std::f32::consts::PI * u, std::f32::consts::PI * v);
        let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (sin_cos(phi), sin_cos(theta));
        let expected = Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
        let film = Vec2::new(200.0 * u, 100.0 * v);
        let found = c.ray(&CameraSample { film, lens: [0.5; 2], time: 0.5 }, [200, 100]).unwrap().direction;
        assert!((found - expected).length() < 1e-5, "{u}, {v}: {found} for {expected}");
    }
}
