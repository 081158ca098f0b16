//! Images of 16 bits and `.tx` files in every format, compared with exact values.

use base64::Engine as _;
use image::{DynamicImage, ImageBuffer, ImageFormat, Rgba};
use serde_json::json;
use tashika::error::Result;
use tashika::io::{LoadOptions, load_scene};
use tashika::scene::{Pixels, Scene};

use super::cases::lenient;
use super::gltf::Document;

/// Output of `maketx` for a ramp of 7 × 5 texels: tiles of 64 × 64, three levels.
pub const TX: &[u8] = include_bytes!("../../../../fuzz/seeds/image/tiled.tx");

/// A PNG with 16 bits per channel: one opaque texel, whose values cannot be stored in 8 bits.
pub fn wide() -> Vec<u8> {
    let picture = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgba([1_u16, 300, 0xfffe, 0xffff])));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Loads a text from a folder with the given files.
pub fn load(name: &str, text: &str, files: &[(&str, &[u8])], options: &LoadOptions) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files.iter().chain([&(name, text.as_bytes())]) {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    load_scene(&folder.path().join(name), options)
}

/// The only image of a scene that uses the image `file`, as colours or as numbers.
fn image_of(format: &str, file: &str, bytes: &[u8], colors: bool) -> tashika::scene::Image {
    let scene = match format {
        "Mitsuba" => {
            let text = format!(
                "<scene version=\"3.0.0\"><shape type=\"rectangle\"><bsdf type=\"diffuse\">\
                 <texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"{file}\"/>\
                 <boolean name=\"raw\" value=\"{}\"/></texture></bsdf></shape></scene>",
                !colors
            );
            load("a.xml", &text, &[(file, bytes)], &lenient())
        }
        "pbrt" => {
            let gamma = if colors { "true" } else { "false" };
            let text = format!(
                "WorldBegin Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\" \"bool gamma\" \"{gamma}\"\n\
                 Material \"matte\" \"texture Kd\" \"t\" Shape \"sphere\" WorldEnd"
            );
            load("a.pbrt", &text, &[(file, bytes)], &lenient())
        }
        "OBJ" => {
            let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
            let map = if colors { "map_Kd" } else { "norm" };
            let mtl = format!("newmtl m\nKd 1 1 1\n{map} {file}\n");
            load("a.obj", obj, &[(file, bytes), ("a.mtl", mtl.as_bytes())], &lenient())
        }
        _ => {
            let mut d = Document::triangle();
            d.add_uvs("TEXCOORD_0");
            let data = base64::prelude::BASE64_STANDARD.encode(bytes);
            let image = d.push("images", json!({ "uri": format!("data:image/png;base64,{data}") }));
            let texture = d.push("textures", json!({ "source": image }));
            d.json["materials"][0] = if colors {
                json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } })
            } else {
                json!({ "normalTexture": { "index": texture } })
            };
            d.load()
        }
    };
    let scene = scene.unwrap();
    let [image] = scene.images() else { panic!("{format}: {} images", scene.images().len()) };
    image.clone()
}

#[test]
fn every_format_keeps_sixteen_bits_in_either_encoding() {
    for format in ["Mitsuba", "pbrt", "OBJ", "glTF"] {
        for colors in [true, false] {
            let image = image_of(format, "wide.png", &wide(), colors);
            let texels = match (image.pixels, colors) {
                (Pixels::Srgb16(t), true) | (Pixels::Linear16(t), false) => t,
                (other, _) => panic!("{format}, {colors}: {other:?}"),
            };
            assert_eq!(texels, [[1, 300, 0xfffe, 0xffff]], "{format}");
        }
    }
}

#[test]
fn every_format_reads_the_largest_level_of_tx_files() {
    for format in ["Mitsuba", "pbrt", "OBJ", "glTF"] {
        for colors in [true, false] {
            let image = image_of(format, "ramp.tx", TX, colors);
            assert_eq!([image.width, image.height], [7, 5]);
            let texels = match (image.pixels, colors) {
                (Pixels::Srgb8(t), true) | (Pixels::Linear8(t), false) => t,
                (other, _) => panic!("{format}, {colors}: {other:?}"),
            };
            for (i, texel) in texels.into_iter().enumerate() {
                // Sample k of texel i was (3 i + k) / 105, to the nearest of 255.
                let expected = [0, 1, 2].map(|k| (((3 * i + k) * 510 + 105) / 210) as u8);
                assert_eq!(texel, [expected[0], expected[1], expected[2], 255], "{format}, texel {i}");
            }
        }
    }
}
