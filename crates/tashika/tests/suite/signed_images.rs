//! Floating-point images with values below zero. As data the values are used as stored; as colours
//! they are at least zero.
//!
//! A bump map turns the normal by its slopes. A constant offset of all heights, of either sign,
//! therefore has no effect. Heights of at most [`MOST`] are interpolated with at most eight
//! roundings, and slopes are differences over a step of 5·10⁻⁴. Their error is at most
//! `2 · 8 · MOST · 2⁻²⁴ / 5·10⁻⁴`.

use tashika::color::Rgb;
use tashika::math::{Vec2, Vec3};
use tashika::scene::{NormalInput, NoteKind, Scene, Surface};

use super::cases::lenient;
use super::textures::load;
use super::usd;

/// Largest height of the maps in these tests.
const MOST: f32 = 2.5;

/// Largest difference of a unit normal between two maps that differ by a constant.
const ROUNDED: f32 = 2.0 * 8.0 * MOST / (1 << 24) as f32 / 5e-4;

/// Returns a grey float map of 4 × 4 heights, each 0.25 or 0.5 above the last.
fn heights(offset: f32) -> Vec<u8> {
    let height = |i: u8| offset + f32::from(i % 3) * 0.25;
    let numbers = (0..16).flat_map(|i| height(i).to_le_bytes());
    b"Pf 4 4 -1\n".iter().copied().chain(numbers).collect()
}

/// Returns a square with a bump map and with the given reflectance.
fn bumped(format: &str, reflectance: &str, offset: f32) -> Scene {
    let map = heights(offset);
    let files: &[(&str, &[u8])] = &[("h.pfm", &map)];
    if format == "Mitsuba" {
        let text = format!(
            "<scene version=\"3.0.0\"><shape type=\"rectangle\"><bsdf type=\"bumpmap\">\
             <texture type=\"bitmap\" name=\"arbitrary\"><boolean name=\"raw\" value=\"true\"/>\
             <string name=\"filename\" value=\"h.pfm\"/></texture>\
             <bsdf type=\"diffuse\">{reflectance}</bsdf></bsdf></shape></scene>"
        );
        return load("a.xml", &text, files, &lenient()).unwrap();
    }
    let (material, parameter) =
        if format == "pbrt-v3" { ("matte", "bumpmap") } else { ("diffuse", "displacement") };
    let text = format!(
        "WorldBegin Texture \"h\" \"float\" \"imagemap\" \"string filename\" \"h.pfm\"\n\
         Texture \"raised\" \"float\" \"scale\" \"texture tex1\" \"h\" \"float tex2\" 1\n\
         Material \"{material}\" \"texture {parameter}\" \"h\"\n\
         Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]\n\
         \"point2 uv\" [0 0 1 0 0 1]\n{}",
        if format == "pbrt-v3" { "WorldEnd" } else { "" }
    );
    load("a.pbrt", &text, files, &lenient()).unwrap()
}

/// Normals at some points of the first triangle.
fn normals(scene: &Scene) -> Vec<Vec3> {
    let instance = scene.instance_ids().next().unwrap();
    let places = [[0.2, 0.3, 0.5], [0.6, 0.3, 0.1], [0.3, 0.6, 0.1], [0.34, 0.33, 0.33]];
    places.map(|b| scene.surface_point(instance, 0, b).shading_normal).to_vec()
}

fn repairs(scene: &Scene) -> Vec<(String, u64)> {
    let notes = scene.notes().iter().filter(|note| note.kind == NoteKind::Repaired);
    notes.map(|note| (note.message, note.count)).collect()
}

#[test]
fn a_height_map_means_the_same_wherever_its_zero_is() {
    for format in ["Mitsuba", "pbrt-v3", "pbrt-v4"] {
        let from_zero = bumped(format, "", 0.0);
        let expected = normals(&from_zero);
        assert!(expected.iter().any(|n| n.truncate().length() > 0.1), "{format} is flat: {expected:?}");
        for offset in [-0.25, -2.0, 2.0] {
            let scene = bumped(format, "", offset);
            for (found, expected) in normals(&scene).into_iter().zip(&expected) {
                let difference = (found - *expected).length();
                assert!(difference < ROUNDED, "{format}, {offset}: {found} instead of {expected}");
            }
            assert_eq!(repairs(&scene), [], "{format}");
        }
    }
}

#[test]
fn one_image_may_be_a_height_and_a_colour() {
    let reflectance = "<texture type=\"bitmap\" name=\"reflectance\"><boolean name=\"raw\" value=\"true\"/>\
                       <string name=\"filename\" value=\"h.pfm\"/></texture>";
    // The heights are −0.25, 0 and 0.25; six of sixteen are below zero.
    let scene = bumped("Mitsuba", reflectance, -0.25);
    for (found, expected) in normals(&scene).into_iter().zip(normals(&bumped("Mitsuba", "", 0.0))) {
        assert!((found - expected).length() < ROUNDED, "{found} instead of {expected}");
    }
    let mesh = &scene.meshes()[0];
    let Surface::Lambert { reflectance } = scene.materials()[mesh.material.index()].surface else { panic!() };
    let at = |x: u8| reflectance.at(scene.textures(), Vec2::new((f32::from(x) + 0.5) / 4.0, 0.125));
    // The top row of the image is the last row of the file: heights 12 to 15.
    assert_eq!([at(0), at(1), at(2)], [0.0, 0.0, 0.25].map(Rgb::gray));
    let said = "image \"h.pfm\" has texels below zero, which no colour is: taken as 0";
    assert_eq!(repairs(&scene), [(said.to_owned(), 6)]);
}

/// The normal of a texel `t` is `scale · t + bias`. Tested for the usual map from 0 to 1, for
/// texels that are the normal's components, and for other maps.
#[test]
fn normals_of_usd_have_the_scale_and_the_bias_that_they_are_stored_by() {
    let normal = [0.6_f32, 0.0, 0.8];
    for (scale, bias) in [(2.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (4.0, -2.0)] {
        let texel = normal.map(|v| (v - bias) / scale);
        // One additional texel below zero, far away.
        let texels: Vec<u8> =
            [texel, texel, texel, [-1.0; 3]].iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let map = [b"PF 4 1 -1\n".as_slice(), &texels].concat();
        let words = |v: f32, last: f32| format!("({v}, {v}, {v}, {last})");
        let text = usd::quad(
            "W",
            "rel material:binding = </M>\n texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = \"vertex\" )",
        ) + &format!(
            "def Material \"M\" {{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader \"S\" {{
        uniform token info:id = \"UsdPreviewSurface\"
        normal3f inputs:normal.connect = </M/T.outputs:rgb>
        token outputs:surface
    }}
    def Shader \"T\" {{
        uniform token info:id = \"UsdUVTexture\"
        asset inputs:file = @n.pfm@
        float4 inputs:scale = {}
        float4 inputs:bias = {}
        token inputs:sourceColorSpace = \"raw\"
    }}
}}",
            words(scale, 1.0),
            words(bias, 0.0)
        );
        let scene = usd::load_with(&text, &[("n.pfm", &map)], &lenient()).unwrap();
        let material = scene.material_of(scene.instance_ids().next().unwrap());
        let Some(NormalInput::Map { texture, .. }) = material.normal else { panic!("{material:?}") };
        let texel = scene.textures().numbers(texture, Vec2::new(0.3, 0.5)).0;
        let found = texel.map(|v| 2.0 * v - 1.0).to_array();
        let difference = found.iter().zip(normal).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // Tolerance for a few roundings of numbers up to 2.
        assert!(difference < 1e-6, "{scale} t + {bias}: {found:?}");
        assert_eq!(repairs(&scene), []);
    }
}
