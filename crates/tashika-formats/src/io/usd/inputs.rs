//! Inputs of surface shaders: colours, numbers and normals, from values or from networks of nodes.
//!
//! Held to this by `usd_materials` and `usd_materialx` of the suite.

use super::Stage;
use super::features::met;
use super::network::Source;
use super::prim::Prim;
use super::textures::Content;
use super::value::Text;
use crate::color::Rgb;
use crate::error::Result;
use crate::scene::{ColorInput, FloatInput, NormalInput, NoteKind};

/// Largest number of consecutive nodes before a normal map that pass the normal on unchanged.
const MOST_NORMALS: usize = 8;

/// A material being read.
pub(super) struct Reading {
    pub shader: Prim,
    pub name: String,
    /// Name of the texture coordinates that its textures use.
    pub uv: Option<Text>,
    /// Number of nodes evaluated so far.
    pub nodes: u32,
}

impl Reading {
    pub fn new(shader: Prim, name: String) -> Self {
        Self { shader, name, uv: None, nodes: 0 }
    }
}

impl Stage<'_> {
    /// Value of a colour input, clamped to the range from 0 to `most`.
    pub fn color(&mut self, r: &mut Reading, name: &str, fallback: Rgb, most: f32) -> Result<ColorInput> {
        let input = format!("inputs:{name}");
        let shader = r.shader.clone();
        let Some(given) = self.given(r, &shader, &input, Content::Color)? else { return Ok(fallback.into()) };
        if given.is_one_channel && given.texture.is_some() {
            let at = self.at_property(&shader, &input);
            met("UsdUVTexture", "one channel as a colour", at, &mut self.builder)?;
        }
        let factor = self.in_range(r, &input, given.color(), most);
        Ok(ColorInput { factor, texture: given.texture })
    }

    /// Value of a number input, clamped to the range from 0 to `most`.
    pub fn float(&mut self, r: &mut Reading, name: &str, fallback: f32, most: f32) -> Result<FloatInput> {
        let input = format!("inputs:{name}");
        let shader = r.shader.clone();
        let Some(given) = self.given(r, &shader, &input, Content::Number)? else {
            return Ok(fallback.into());
        };
        let factor = self.in_range(r, &input, Rgb::gray(given.number()), most).r;
        Ok(FloatInput { factor, texture: given.texture.map(|texture| (texture, given.channel)) })
    }

    /// The normal map of an input, if it has one.
    pub fn normal(&mut self, r: &mut Reading, name: &str) -> Result<Option<NormalInput>> {
        let mut at = (r.shader.clone(), format!("inputs:{name}"));
        for _ in 0..MOST_NORMALS {
            let Some(Source::Output(node, output)) = self.source(&at.0, &at.1)? else { return Ok(None) };
            let id = self.shader(&node)?;
            if id.starts_with("ND_normalize_") {
                at = (node, "inputs:in".to_owned());
                continue;
            }
            // The node returns the surface's own normal, without a map.
            if id.starts_with("ND_normal_") {
                return Ok(None);
            }
            let (given, scale) = if id.starts_with("ND_normalmap") {
                let scale = self.input_number(&node, "inputs:scale", 1.0)?;
                (self.given(r, &node, "inputs:in", Content::Normal)?, scale as f32)
            } else {
                (self.evaluated(r, &node, &output, Content::Normal)?, 1.0)
            };
            let texture = given.and_then(|given| given.texture);
            return Ok(texture.map(|texture| NormalInput::Map { texture, scale }));
        }
        Ok(None)
    }

    /// Records the texture coordinates that a texture uses. A second set is noted, because a mesh
    /// has only one.
    pub fn wants(&mut self, r: &mut Reading, uv: &Text) -> Result<()> {
        if r.uv.get_or_insert_with(|| uv.clone()) != uv {
            let at = self.at(&r.shader);
            met("UsdUVTexture", "second set of coordinates", at, &mut self.builder)?;
        }
        Ok(())
    }

    /// Clamps a colour to its range, with a note if it was outside.
    fn in_range(&mut self, r: &Reading, input: &str, color: Rgb, most: f32) -> Rgb {
        let within = color.map(|v| if v.is_nan() { 0.0 } else { v.clamp(0.0, most) });
        if within != color {
            let message = "inputs of materials that are out of range: the nearest allowed is used";
            let at = self.at_property(&r.shader, input);
            self.builder.note(NoteKind::Repaired, message, at);
        }
        within
    }
}
