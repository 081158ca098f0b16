//! Sides on which surfaces of Mitsuba's files reflect, compared with Mitsuba 3.9.1 for directions
//! behind a surface (`eval` with both cosines negative).

use tashika::math::Vec3;
use tashika::rng::{Purpose, Stream};
use tashika::scene::Scene;

use crate::mitsuba::{load_in, xml};

/// A rectangle with the given bsdf.
fn scene(bsdf: &str) -> Scene {
    let text = xml("3.0.0", &format!("<shape type=\"rectangle\">{bsdf}</shape>"));
    load_in(&[("scene.xml", text.as_bytes())]).1.unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Mean red reflectance of the front and of the back of the rectangle, over the parts that are
/// visible from there; to a hundredth of a percent.
fn reflectances(bsdf: &str) -> [f32; 2] {
    let scene = scene(bsdf);
    let instance = scene.instance_ids().next().unwrap();
    let point = scene.surface_point(instance, 0, [0.3, 0.3, 0.4]);
    let mut s = Stream::new(1, Purpose::Test, 0);
    [Vec3::Z, -Vec3::Z].map(|side| {
        let outgoing = (side + Vec3::X).normalize();
        let parts = (0..1000).map(|_| scene.part(&point, outgoing, s.uniform()));
        let mean: f32 = parts.map(|part| part.bsdf.albedo().r * part.weight / 1000.0).sum();
        (mean * 1e4).round() / 1e4
    })
}

fn diffuse(reflectance: f32) -> String {
    format!("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"{reflectance} 0 0\"/></bsdf>")
}

#[test]
fn opaque_surfaces_are_black_behind() {
    let plain = ["diffuse", "plastic", "roughplastic", "conductor", "roughconductor", "principled"];
    for plugin in plain {
        let bsdf = format!("<bsdf type=\"{plugin}\"/>");
        let [front, back] = reflectances(&bsdf);
        assert!(front > 0.3 && back == 0.0, "{plugin}: {front} {back}");
        let [front, back] = reflectances(&format!("<bsdf type=\"twosided\">{bsdf}</bsdf>"));
        assert!(front > 0.3 && (back - front).abs() < 0.03, "twosided {plugin}: {front} {back}");
    }
    for plugin in ["dielectric", "thindielectric", "roughdielectric", "principledthin"] {
        let [front, back] = reflectances(&format!("<bsdf type=\"{plugin}\"/>"));
        assert!(front > 0.1 && back > 0.1, "{plugin}: {front} {back}");
    }
}

#[test]
fn two_sides_have_a_material_each() {
    let [front, back] =
        reflectances(&format!("<bsdf type=\"twosided\">{}{}</bsdf>", diffuse(0.7), diffuse(0.2)));
    assert_eq!((front, back), (0.7, 0.2));
}

/// A wrapper reflects on the sides of the BSDF in it; a mix reflects on those of its parts if they
/// agree.
#[test]
fn wrappers_have_the_sides_of_what_they_wrap() {
    let wrap = |plugin: &str, inside: &str| format!("<bsdf type=\"{plugin}\">{inside}</bsdf>");
    let [one, other] = [diffuse(0.7), diffuse(0.3)];
    let both = format!("<float name=\"weight\" value=\"0.5\"/>{one}{other}");
    let mixed = |found: f32| (found - 0.5).abs() < 0.03;
    let [front, back] = reflectances(&wrap("blendbsdf", &both));
    assert!(mixed(front) && back == 0.0, "{front} {back}");
    let [front, back] = reflectances(&wrap("twosided", &wrap("blendbsdf", &both)));
    assert!(mixed(front) && mixed(back), "{front} {back}");
    for wrapper in ["mask", "bumpmap"] {
        assert_eq!(reflectances(&wrap(wrapper, &one)), [0.7, 0.0], "{wrapper}");
        assert_eq!(reflectances(&wrap("twosided", &wrap(wrapper, &one))), [0.7, 0.7], "{wrapper}");
    }
}
