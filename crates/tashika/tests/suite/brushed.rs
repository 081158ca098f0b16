//! Direction of brushed (anisotropic) materials, by the rules of each format.

use serde_json::json;
use tashika::math::Vec3;
use tashika::scene::Scene;

use crate::gltf::{Document, notes};
use crate::mitsuba::{load_in, xml};
use crate::pbrt;

const BRUSHED: &str = "<bsdf type=\"roughconductor\"><float name=\"alpha_u\" value=\"0.1\"/>\
    <float name=\"alpha_v\" value=\"0.4\"/></bsdf>";

/// Returns a position inside a triangle, and the first axis of the frame around the shading normal
/// there. `None` if the surface needs no tangent.
fn tangent(scene: &Scene, triangle: u32) -> Option<(Vec3, Vec3)> {
    let point = scene.surface_point(scene.instance_ids().next().unwrap(), triangle, [0.3, 0.3, 0.4]);
    point.tangent.map(|_| (point.position, point.frame(point.shading_normal).t))
}

fn mitsuba(shape: &str) -> Scene {
    load_in(&[("scene.xml", xml("3.0.0", shape).as_bytes())]).1.unwrap()
}

/// A rectangle is brushed along its first texture coordinate, with and without a transformation.
#[test]
fn rectangles_of_mitsuba_are_brushed_along_u() {
    let turned =
        "<transform name=\"to_world\"><scale x=\"3\" y=\"0.2\"/><rotate y=\"1\" angle=\"90\"/></transform>";
    for (transform, expected) in [("", Vec3::X), (turned, Vec3::NEG_Z)] {
        let scene = mitsuba(&format!("<shape type=\"rectangle\">{transform}{BRUSHED}</shape>"));
        let (_, t) = tangent(&scene, 0).unwrap();
        assert!((t - expected).length() < 1e-6, "{t}");
    }
    let even = BRUSHED.replace("0.4", "0.1");
    assert!(tangent(&mitsuba(&format!("<shape type=\"rectangle\">{even}</shape>")), 0).is_none());
    // A mix of materials needs a tangent if one of them does.
    let mix = format!(
        "<shape type=\"rectangle\"><bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.5\"/>\
         <bsdf type=\"diffuse\"/>{BRUSHED}</bsdf></shape>"
    );
    assert!(tangent(&mitsuba(&mix), 0).is_some());
}

/// Spheres are brushed around their axis, disks along the radius, within half a step of their
/// meshes.
#[test]
fn round_shapes_of_mitsuba_are_brushed_along_u() {
    let of = |shape: &str| mitsuba(&format!("<shape type=\"{shape}\">{BRUSHED}</shape>"));
    let step = std::f32::consts::TAU / 64.0;
    let (sphere, disk) = (of("sphere"), of("disk"));
    for triangle in (64 * 10..64 * 50).step_by(37) {
        let (p, t) = tangent(&sphere, triangle).unwrap();
        let expected = Vec3::new(-p.y, p.x, 0.0).normalize();
        assert!(t.angle_between(expected) < step, "{p}: {t}");
    }
    for triangle in (0..64).step_by(7) {
        let (p, t) = tangent(&disk, triangle).unwrap();
        assert!(t.angle_between(p) < step, "{p}: {t}");
    }
}

/// A mesh without texture coordinates is brushed along the first axis of the frame that Mitsuba
/// builds around the geometric normal.
#[test]
fn meshes_without_texture_coordinates_have_some_direction() {
    let ply =
        b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n0 1 0\n0 0 1\n3 0 1 2\n";
    let body = format!("<shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/>{BRUSHED}</shape>");
    let scene = load_in(&[("scene.xml", xml("3.0.0", &body).as_bytes()), ("a.ply", ply)]).1.unwrap();
    let (_, t) = tangent(&scene, 0).unwrap();
    assert!((t - Vec3::NEG_Z).length() < 1e-6, "{t}");
}

#[test]
fn meshes_of_pbrt_are_brushed_along_u() {
    let material = "Material \"conductor\" \"float uroughness\" 0.1 \"float vroughness\" 0.4";
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0  0 2 0  -1 0 0] \"integer indices\" [0 1 2]";
    let of =
        |more: &str| tangent(&pbrt::scene(&format!("WorldBegin {material} {mesh} {more}")), 0).unwrap().1;
    let t = of("\"point2 uv\" [0 0  0 1  1 0]");
    assert!((t - Vec3::NEG_X).length() < 1e-6, "{t}");
    // Without texture coordinates, a triangle is brushed along its first edge.
    let t = of("");
    assert!((t - Vec3::Y).length() < 1e-6, "{t}");
}

/// In glTF, the rotation is counter-clockwise from the tangent. It needs texture coordinates, but
/// no texture.
#[test]
fn primitives_of_gltf_are_brushed_along_their_rotation() {
    let load = |has_uvs: bool, rotation: f32| {
        let mut d = Document::triangle();
        if has_uvs {
            d.add_uvs("TEXCOORD_0");
        }
        let brushed = json!({ "anisotropyStrength": 0.5, "anisotropyRotation": rotation });
        d.json["materials"][0] = json!({ "extensions": { "KHR_materials_anisotropy": brushed } });
        d.json["extensionsUsed"] = json!(["KHR_materials_anisotropy"]);
        d.load().unwrap()
    };
    // The texture coordinates equal the positions. Since the second coordinate runs down, the
    // mapping is mirrored, and the rotation appears clockwise.
    for (rotation, expected) in [(0.0, Vec3::X), (0.6435011, Vec3::new(0.8, -0.6, 0.0))] {
        let scene = load(true, rotation);
        let (_, t) = tangent(&scene, 0).unwrap();
        assert!((t - expected).length() < 1e-5, "{t}");
        assert_eq!(notes(&scene), []);
    }
    let scene = load(false, 0.0);
    assert!(tangent(&scene, 0).is_some() && notes(&scene).len() == 1, "{:?}", notes(&scene));
}
