//! The environment of the extension `EXT_lights_image_based`: a cube map.
//!
//! The first level of the map, six pictures in the order `+x −x +y −y +z −z`, is the radiance; its
//! numbers times `intensity` count as W·m⁻²·sr⁻¹. The other data of the extension, blurred levels
//! for rough surfaces and coefficients of irradiance, are not used: they are integrals of the same
//! radiance, which light transport computes. PNG images with opacity are in RGBD: the radiance is
//! the colour, decoded by the sRGB curve, divided by the opacity.
//!
//! The extension turns each of OpenGL's faces around its vertical axis. The faces are therefore
//! pictures as seen from inside the cube: `−x` is to the right of `+z`, the upper edge of the `+y`
//! face is towards `−z`, and the upper edge of the `−y` face is towards `+z`. The faces become a
//! latitude-longitude map, four faces wide and two high, whose texels are means of 2 × 2 bilinear
//! lookups in the faces.
//!
//! # Held to this by
//! The tests below; `suite::gltf_environment`.

use glam::{Mat3, Quat, Vec2, Vec3};
use serde_json::Value;

use super::light_profiles::{chosen, number};
use super::nodes;
use super::source::Source;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::io::assets::{decode_colors, kind, reason};
use crate::io::images::Encoding;
use crate::io::notes::shown;
use crate::scene::{Environment, Image, Pixels, SceneBuilder, SphereMap, Wrap};

const NAME: &str = "EXT_lights_image_based";

/// Sets the environment of the rendered scene, if it has one.
pub(super) fn add(source: &Source<'_>, builder: &mut SceneBuilder) -> Result<()> {
    let root = &source.root;
    let Some(scene) = nodes::chosen_scene(root) else { return Ok(()) };
    let given = root.scenes[scene].extensions.as_ref().and_then(|e| e.others.get(NAME));
    let Some(given) = given else { return Ok(()) };
    let place = source.at(format!("scenes[{scene}].extensions.{NAME}.light"));
    let (index, light) = chosen(source, NAME, given, "lights", place)?;
    let at = |field: &str| source.at(format!("extensions.{NAME}.lights[{index}]{field}"));
    let intensity = light.get("intensity").map_or(Ok(1.0), |v| number(v, &at(".intensity"), builder))?;
    let rotation = light.get("rotation").map_or(Some(Quat::IDENTITY), quaternion).ok_or_else(|| {
        let found = shown(&light["rotation"].to_string());
        Error::invalid(at(".rotation"), found, "four numbers that are not all 0")
    })?;
    let faces = images_of_faces(light, root.images.len()).ok_or_else(|| {
        let found = light.get("specularImages").map_or("nothing".to_owned(), |v| shown(&v.to_string()));
        let expected = format!("levels of six indices, each of one of {} images", root.images.len());
        Error::invalid(at(".specularImages"), found, expected)
    })?;
    let mut read = 0;
    match map(source, faces, &mut read, builder, &at("")) {
        Ok(map) => {
            let turned = Mat3::from_quat(rotation);
            builder.set_environment(Environment::lat_long(map, Rgb::gray(intensity), turned))
        }
        Err(error) => {
            let (image, why) = (faces[read], reason(&error));
            let message = format!("environment of which images[{image}] could not be read ({why}): left out");
            builder.note(kind(&error), message, at(".specularImages"));
            Ok(())
        }
    }
}

fn quaternion(value: &Value) -> Option<Quat> {
    let numbers: Option<Vec<f32>> = value.as_array()?.iter().map(|v| v.as_f64().map(|v| v as f32)).collect();
    let [x, y, z, w] = numbers?[..] else { return None };
    let quaternion = Quat::from_xyzw(x, y, z, w);
    let length = quaternion.length();
    (length.is_finite() && length > 0.0).then(|| quaternion.normalize())
}

/// Indices of the six images of the first level; none unless there are six indices below `images`.
fn images_of_faces(light: &Value, images: usize) -> Option<[usize; 6]> {
    let first = light.get("specularImages")?.as_array()?.first()?.as_array()?;
    let index = |v: &Value| usize::try_from(v.as_u64()?).ok().filter(|&i| i < images);
    first.iter().map(index).collect::<Option<Vec<usize>>>()?.try_into().ok()
}

/// Map of the six face images. `read` is set to the index of the face being read, for messages.
fn map(
    source: &Source<'_>,
    images: [usize; 6],
    read: &mut usize,
    builder: &mut SceneBuilder,
    at: &Location,
) -> Result<Image> {
    let mut faces = Vec::with_capacity(6);
    let mut side = 1;
    for (i, index) in images.into_iter().enumerate() {
        *read = i;
        let face = face(source, index, builder)?;
        side = side.max(face.width).max(face.height);
        faces.push(face);
    }
    let texels = 8 * u64::from(side) * u64::from(side);
    let limit = source.options().max_image_texels;
    if texels > limit {
        let found = format!("a cube of faces of {side}² texels");
        return Err(Error::invalid(at.clone(), found, format!("at most {limit} texels of its map")));
    }
    source.image_budget.take(12 * texels, at)?;
    Ok(unrolled(&faces, side))
}

/// A face with linear colours, divided by opacity; black where the opacity is 0.
fn face(source: &Source<'_>, index: usize, builder: &mut SceneBuilder) -> Result<Image> {
    let at = source.at(format!("images[{index}]"));
    let bytes = source.image(index)?;
    let (name, options) = (format!("images[{index}]"), source.options());
    let image = decode_colors(&bytes, &name, Encoding::Srgb, options, &at, builder)?;
    source.image_budget.take(12 * image.pixels.len() as u64, &at)?;
    let texels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    let radiance = texels.map(|(x, y)| match image.texel(x, y) {
        (color, opacity) if opacity > 0.0 => (color / opacity).to_array(),
        _ => [0.0; 3],
    });
    Ok(Image { pixels: Pixels::Float(radiance.collect()), ..image })
}

/// The latitude-longitude map of `4 side × 2 side` texels.
fn unrolled(faces: &[Image], side: u32) -> Image {
    let [width, height] = [4 * side, 2 * side];
    let radiance = |x: f32, y: f32| {
        let direction = SphereMap::LatLong.direction([x / width as f32, y / height as f32]);
        let (face, place) = place(direction);
        faces[face].bilinear(place, [Wrap::Clamp; 2]).0
    };
    let texel = |i: u32| {
        let (x, y) = ((i % width) as f32, (i / width) as f32);
        let upper = radiance(x + 0.25, y + 0.25) + radiance(x + 0.75, y + 0.25);
        let lower = radiance(x + 0.25, y + 0.75) + radiance(x + 0.75, y + 0.75);
        ((upper + lower) * 0.25).to_array()
    };
    let pixels = Pixels::Float((0..width * height).map(texel).collect());
    Image { name: "environment".to_owned(), width, height, pixels }
}

/// Face through which a direction goes, and the place in its picture, from the upper left, 0 to 1.
fn place(d: Vec3) -> (usize, Vec2) {
    let a = d.abs();
    let (face, right, down, ahead) = if a.x >= a.y && a.x >= a.z {
        if d.x > 0.0 { (0, d.z, -d.y, a.x) } else { (1, -d.z, -d.y, a.x) }
    } else if a.y >= a.z {
        if d.y > 0.0 { (2, -d.x, d.z, a.y) } else { (3, -d.x, -d.z, a.y) }
    } else if d.z > 0.0 {
        (4, -d.x, -d.y, a.z)
    } else {
        (5, d.x, -d.y, a.z)
    };
    (face, Vec2::new(right, down) / ahead * 0.5 + 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks up directions along the axes and half-way to the edges of faces. Each must lie where a
    /// viewer inside the cube sees it.
    #[test]
    fn faces_are_pictures_seen_from_inside() {
        let at = |d: [f32; 3]| place(Vec3::from(d).normalize());
        let near = |found: (usize, Vec2), face: usize, place: [f32; 2]| {
            assert!(found.0 == face && (found.1 - Vec2::from(place)).length() < 1e-4, "{found:?}");
        };
        for (face, axis) in
            [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]].iter().enumerate()
        {
            near(at(axis.map(|v: i32| v as f32)), face, [0.5, 0.5]);
        }
        // Looking along −z with +y up, +x is to the right.
        near(at([0.5, 0.0, -1.0]), 5, [0.75, 0.5]);
        near(at([0.0, 0.5, -1.0]), 5, [0.5, 0.25]);
        near(at([-1.0, 0.0, -0.5]), 1, [0.75, 0.5]);
        near(at([1.0, 0.0, 0.5]), 0, [0.75, 0.5]);
        near(at([-0.5, 0.0, 1.0]), 4, [0.75, 0.5]);
        // The upper edge of the upper picture is towards −z and its right edge towards −x; the
        // upper edge of the lower picture is towards +z.
        near(at([0.0, 1.0, -0.5]), 2, [0.5, 0.25]);
        near(at([-0.5, 1.0, 0.0]), 2, [0.75, 0.5]);
        near(at([0.0, -1.0, 0.5]), 3, [0.5, 0.25]);
        near(at([-0.5, -1.0, 0.0]), 3, [0.75, 0.5]);
    }

    /// The faces store the direction of each texel, with 64 texels a side: a texel is 1/32 of half
    /// a side of the cube. The map must return each direction `d` within 0.02. The mean over a
    /// texel of the map and the linear interpolation in a face each differ from `d` by its
    /// curvature over half a texel.
    #[test]
    fn the_map_shows_what_the_faces_show() {
        let side = 64;
        // Each face shows the direction of each texel, offset by 1 so that no component is
        // negative.
        let face = |number: usize| {
            let texel = |i: u32| {
                let at =
                    Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32 * 2.0 - 1.0;
                let (r, d) = (at.x, at.y);
                let direction = match number {
                    0 => [1.0, -d, r],
                    1 => [-1.0, -d, -r],
                    2 => [-r, 1.0, d],
                    3 => [-r, -1.0, -d],
                    4 => [-r, -d, 1.0],
                    _ => [r, -d, -1.0],
                };
                (Vec3::from(direction).normalize() + Vec3::ONE).to_array()
            };
            let pixels = Pixels::Float((0..side * side).map(texel).collect());
            Image { name: "f".into(), width: side, height: side, pixels }
        };
        let faces: Vec<Image> = (0..6).map(face).collect();
        let environment = Environment::lat_long(unrolled(&faces, side), Rgb::WHITE, Mat3::IDENTITY);
        for i in 0..1000 {
            let u = [(i as f32 * 0.618_034).fract(), (i as f32 + 0.5) / 1000.0];
            let direction = crate::warp::sphere(u);
            let found = Vec3::from(environment.radiance(direction).to_array()) - Vec3::ONE;
            assert!((found - direction).length() < 0.02, "{direction}: {found}");
        }
    }
}
