//! Texture coordinates: a set of the mesh, and a map from it to the coordinates of the texture.
//!
//! A primvar reader names the set; nodes between the reader and the texture may map the
//! coordinates. `UsdTransform2d` scales, rotates counter-clockwise and translates, in this order.
//! MaterialX's `place2d` with pivot `p` is
//!
//! ```text
//! operationorder 0    p + R (u − p)/s − o
//! operationorder 1    p + (R (u − p − o))/s        R = [cos sin; −sin cos] of `rotate`
//! ```
//!
//! where `v` runs up.
//!
//! Held to this by `usd_materials` and `usd_materialx` of the suite.

use glam::{Mat3, Vec2, Vec3};

use super::Stage;
use super::features::met;
use super::network::Source;
use super::prim::Prim;
use super::value::Text;
use crate::error::Result;
use crate::math::elementary::sin_cos;
use crate::scene::{NoteKind, UvTransform};

/// Largest number of consecutive maps.
const MAX_MAPS: usize = 8;

/// Largest coefficient of a texture transform.
const MAX_COEFFICIENT: f32 = 1e6;

/// Name of the default set of texture coordinates.
const USUAL: &str = "st";

fn scaled(Vec2 { x, y }: Vec2) -> Mat3 {
    Mat3::from_diagonal(Vec3::new(x, y, 1.0))
}

fn moved(Vec2 { x, y }: Vec2) -> Mat3 {
    Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::new(x, y, 1.0))
}

/// Rotation, counter-clockwise.
fn turned(degrees: f32) -> Mat3 {
    let (sin, cos) = sin_cos(degrees.to_radians());
    Mat3::from_cols(Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0), Vec3::Z)
}

impl Stage<'_> {
    /// Returns the set of coordinates that is connected to a texture's `input`, and the map from
    /// the set to the texture. The last step of the map is `last`, the texture's own map. In the
    /// result, `v` runs down.
    pub fn coordinates(&mut self, shader: &Prim, input: &str, last: Mat3) -> Result<(Text, UvTransform)> {
        let mut map = last;
        let mut at = (shader.clone(), Text::from(input));
        for _ in 0..MAX_MAPS {
            let Some(Source::Output(prim, _)) = self.source(&at.0, &at.1)? else { break };
            let name = self.shader(&prim)?;
            let next = match &*name {
                "UsdTransform2d" | "ND_UsdTransform2d" => {
                    map *= self.transform_2d(&prim)?;
                    "inputs:in"
                }
                "ND_place2d_vector2" => {
                    map *= self.place_2d(&prim, false)?;
                    "inputs:texcoord"
                }
                "ND_multiply_vector2" => {
                    map *= scaled(self.pair(&prim, "inputs:in2", 1.0)?);
                    "inputs:in1"
                }
                "UsdPrimvarReader_float2" | "ND_UsdPrimvarReader_vector2" => {
                    let uv = self.input_word(&prim, "inputs:varname")?;
                    return Ok((uv.unwrap_or_else(|| USUAL.into()), self.downward(map, shader)));
                }
                "ND_geompropvalue_vector2" => {
                    let uv = self.input_word(&prim, "inputs:geomprop")?;
                    return Ok((uv.unwrap_or_else(|| USUAL.into()), self.downward(map, shader)));
                }
                "ND_texcoord_vector2" => {
                    let index = self.input_number(&prim, "inputs:index", 0.0)?;
                    let uv = if index > 0.0 { format!("{USUAL}{index}").into() } else { USUAL.into() };
                    return Ok((uv, self.downward(map, shader)));
                }
                _ => {
                    let place = self.at(&prim);
                    met("UsdUVTexture", "st from another shader", place, &mut self.builder)?;
                    break;
                }
            };
            at = (prim, next.into());
        }
        Ok((USUAL.into(), self.downward(map, shader)))
    }

    /// Map that a MaterialX texture node applies to its coordinates.
    pub fn placed(&mut self, shader: &Prim) -> Result<Mat3> {
        let name = self.shader(shader)?;
        if name.starts_with("ND_gltf_image_") {
            return self.place_2d(shader, true);
        }
        if !name.starts_with("ND_tiledimage_") {
            return Ok(Mat3::IDENTITY);
        }
        let [image, tile] = [
            self.pair(shader, "inputs:realworldimagesize", 1.0)?,
            self.pair(shader, "inputs:realworldtilesize", 1.0)?,
        ];
        let offset = self.pair(shader, "inputs:uvoffset", 0.0)?;
        Ok(scaled(tile / image) * moved(-offset) * scaled(self.pair(shader, "inputs:uvtiling", 1.0)?))
    }

    fn transform_2d(&mut self, prim: &Prim) -> Result<Mat3> {
        let degrees = self.input_number(prim, "inputs:rotation", 0.0)? as f32;
        let moved = moved(self.pair(prim, "inputs:translation", 0.0)?);
        Ok(moved * turned(degrees) * scaled(self.pair(prim, "inputs:scale", 1.0)?))
    }

    /// Map of a `place2d` node; with `of_gltf`, scale, offset and rotation are as in glTF's texture
    /// transforms.
    fn place_2d(&mut self, prim: &Prim, of_gltf: bool) -> Result<Mat3> {
        let pivot = if of_gltf { Vec2::Y } else { Vec2::ZERO };
        let pivot = self.input_tuple(prim, "inputs:pivot", pivot.to_array().map(f64::from))?;
        let pivot = Vec2::from(pivot.map(|n| n as f32));
        let scale = self.pair(prim, "inputs:scale", 1.0)?;
        let offset = self.pair(prim, "inputs:offset", 0.0)?;
        let degrees = self.input_number(prim, "inputs:rotate", 0.0)? as f32;
        let (scale, offset, degrees) = if of_gltf {
            (scale, Vec2::new(offset.x, -offset.y), degrees)
        } else {
            (scale.recip(), -offset, -degrees)
        };
        let (about, back) = (moved(-pivot), moved(pivot));
        Ok(if self.input_number(prim, "inputs:operationorder", 0.0)? == 0.0 {
            back * moved(offset) * turned(degrees) * scaled(scale) * about
        } else {
            back * scaled(scale) * turned(degrees) * moved(offset) * about
        })
    }

    fn pair(&mut self, prim: &Prim, name: &str, fallback: f64) -> Result<Vec2> {
        let both = match self.plain_input(prim, name)?.and_then(|value| value.number()) {
            Some(n) => [n; 2],
            None => self.input_tuple(prim, name, [fallback; 2])?,
        };
        Ok(Vec2::from(both.map(|n| n as f32)))
    }

    /// Converts a map for `v` up to one for `v` down. Returns the identity, with a note, if a
    /// coefficient is too large or not finite.
    fn downward(&mut self, map: Mat3, shader: &Prim) -> UvTransform {
        let flip = Mat3::from_cols(Vec3::X, Vec3::NEG_Y, Vec3::new(0.0, 1.0, 1.0));
        let map = flip * map * flip;
        if map.is_finite() && map.to_cols_array().iter().all(|c| c.abs() <= MAX_COEFFICIENT) {
            return UvTransform(map);
        }
        let message = "texture transforms that are not finite or huge: left out";
        let at = self.at(shader);
        self.builder.note(NoteKind::Repaired, message, at);
        UvTransform::default()
    }
}
