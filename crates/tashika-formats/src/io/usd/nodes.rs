//! Nodes of shading networks: values of their outputs.
//!
//! | nodes | values |
//! |---|---|
//! | `UsdUVTexture`, `ND_image_*`, `ND_tiledimage_*`, `ND_gltf_image_*` | textures |
//! | `ND_constant_*`, `ND_convert_*`, `ND_dot_*` | the input |
//! | `ND_multiply_*` | products |
//! | `ND_mix_*` | `(1 − mix) bg + mix fg` |
//! | `ND_invert_*` | `1 − in` |
//! | `ND_extract_*`, `ND_separate*` | one channel |
//! | `UsdPrimvarReader_*` | the fallback |
//!
//! Names with `ND_` are MaterialX's node definitions, as in `usd_materialx` of the suite.

use std::collections::BTreeSet;

use super::Stage;
use super::features::met;
use super::inputs::Reading;
use super::network::Source;
use super::prim::Prim;
use super::textures::{Content, Found, channel_of};
use super::value::Value;
use crate::color::Rgb;
use crate::error::Result;
use crate::io::textures::{between, mix, node, product};
use crate::scene::{Channel, ColorInput, TextureId};

/// Largest number of nodes that a material evaluates.
const MOST_NODES: u32 = 256;

/// Value of an output: a factor for each channel, and possibly a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Given {
    pub factor: [f32; 4],
    pub texture: Option<TextureId>,
    /// Channel that is read if a number is needed.
    pub channel: Channel,
    /// True if the value consists of that channel alone.
    pub is_one_channel: bool,
}

impl From<Rgb> for Given {
    fn from(Rgb { r, g, b }: Rgb) -> Self {
        Self { factor: [r, g, b, 1.0], texture: None, channel: Channel::R, is_one_channel: false }
    }
}

impl From<ColorInput> for Given {
    fn from(ColorInput { factor, texture }: ColorInput) -> Self {
        Self { texture, ..factor.into() }
    }
}

impl Given {
    fn of_value(value: &Value) -> Option<Self> {
        let numbers = |all: &[f64]| {
            let mut factor = [1.0; 4];
            factor.iter_mut().zip(all).for_each(|(to, n)| *to = *n as f32);
            Self { factor, ..Rgb::WHITE.into() }
        };
        match (value.tuple::<4>(), value.tuple::<3>(), value.tuple::<2>(), value.number()) {
            (Some(all), ..) => Some(numbers(&all)),
            (_, Some(all), ..) => Some(numbers(&all)),
            (_, _, Some(all), _) => Some(numbers(&all)),
            (.., Some(n)) => Some(numbers(&[n; 4])),
            _ => None,
        }
    }

    /// The value as a number.
    pub fn number(&self) -> f32 {
        self.factor[match self.channel {
            Channel::G => 1,
            Channel::B => 2,
            Channel::A => 3,
            Channel::R | Channel::Luminance => 0,
        }]
    }

    /// The value as a colour; if there is a texture, the factor on its colours.
    pub fn color(&self) -> Rgb {
        let [r, g, b, _] = self.factor;
        if self.is_one_channel && self.texture.is_none() {
            Rgb::gray(self.number())
        } else {
            Rgb::new(r, g, b)
        }
    }

    fn input(&self) -> ColorInput {
        ColorInput { factor: self.color(), texture: self.texture }
    }

    fn only(self, channel: Channel) -> Self {
        Self { channel, is_one_channel: true, ..self }
    }
}

/// Operation of a node on its inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    UsdTexture,
    Image,
    /// Passes the value of the named input through.
    Through(&'static str),
    Product,
    Mix,
    Invert,
    Extract,
    Separate,
    /// Fallback of a primvar, from the named input.
    Reader(&'static str),
}

impl Kind {
    /// Operation of the shader `id`; none if it is not supported.
    fn of(id: &str) -> Option<Self> {
        let starts = |prefixes: &[&str]| prefixes.iter().any(|prefix| id.starts_with(prefix));
        Some(match id {
            _ if starts(&["UsdUVTexture", "ND_UsdUVTexture"]) => Self::UsdTexture,
            _ if starts(&["ND_image_", "ND_tiledimage_", "ND_gltf_image_"]) => Self::Image,
            _ if starts(&["ND_constant_"]) => Self::Through("inputs:value"),
            _ if starts(&["ND_convert_", "ND_dot_"]) => Self::Through("inputs:in"),
            _ if starts(&["ND_multiply_"]) => Self::Product,
            _ if starts(&["ND_mix_"]) => Self::Mix,
            _ if starts(&["ND_invert_"]) => Self::Invert,
            _ if starts(&["ND_extract_"]) => Self::Extract,
            _ if starts(&["ND_separate"]) => Self::Separate,
            _ if starts(&["UsdPrimvarReader", "ND_UsdPrimvarReader"]) => Self::Reader("inputs:fallback"),
            _ if starts(&["ND_geompropvalue_"]) => Self::Reader("inputs:default"),
            _ => return None,
        })
    }
}

/// Returns true for supported nodes: those that have values, map coordinates, or give a normal.
fn is_known(id: &str) -> bool {
    const OTHERS: [&str; 7] = [
        "UsdTransform2d",
        "ND_UsdTransform2d",
        "ND_texcoord_",
        "ND_place2d_",
        "ND_normalmap",
        "ND_normalize_",
        "ND_normal_",
    ];
    Kind::of(id).is_some() || OTHERS.iter().any(|prefix| id.starts_with(prefix))
}

impl Stage<'_> {
    /// Value of an input; none if it has no value, or if its source is not supported.
    pub fn given(
        &mut self,
        r: &mut Reading,
        shader: &Prim,
        input: &str,
        content: Content,
    ) -> Result<Option<Given>> {
        match self.source(shader, input)? {
            None => Ok(None),
            Some(Source::Value(value)) => Ok(Given::of_value(&value)),
            Some(Source::Output(node, output)) => self.evaluated(r, &node, &output, content),
        }
    }

    /// Value of an output of a node; none, with a note, if the node is not supported.
    pub fn evaluated(
        &mut self,
        r: &mut Reading,
        shader: &Prim,
        output: &str,
        content: Content,
    ) -> Result<Option<Given>> {
        r.nodes += 1;
        let id = self.shader(shader)?;
        let at = self.at(shader);
        let Some(kind) = Kind::of(&id).filter(|_| r.nodes <= MOST_NODES) else {
            met("UsdPreviewSurface", "another shader", at, &mut self.builder)?;
            return Ok(None);
        };
        match kind {
            Kind::UsdTexture => Ok(match self.texture(shader, output, content)? {
                Found::Texture(lookup) => {
                    self.wants(r, &lookup.uv)?;
                    let is_one_channel = output.len() == 1;
                    let (factor, channel) = (lookup.scale, lookup.channel);
                    Some(Given { factor, texture: Some(lookup.texture), channel, is_one_channel })
                }
                Found::Fallback(factor) => {
                    let given = Given { factor, ..Rgb::WHITE.into() };
                    Some(Given { is_one_channel: false, ..given.only(channel_of(output)) })
                }
            }),
            Kind::Image => Ok(match self.image(shader, content)? {
                Found::Texture(lookup) => {
                    self.wants(r, &lookup.uv)?;
                    let given = Given { texture: Some(lookup.texture), ..Rgb::WHITE.into() };
                    let factor = self.given(r, shader, "inputs:factor", content)?;
                    Some(factor.map_or(given, |factor| Given { factor: factor.factor, ..given }))
                }
                Found::Fallback(factor) => Some(Given { factor, ..Rgb::WHITE.into() }),
            }),
            Kind::Through(input) => self.given(r, shader, input, content),
            Kind::Product => {
                let one = self.given(r, shader, "inputs:in1", content)?;
                let other = self.given(r, shader, "inputs:in2", content)?;
                let (Some(one), Some(other)) = (one, other) else { return Ok(one.or(other)) };
                self.product(one, other, shader)
            }
            Kind::Mix => {
                let [background, foreground, amount] = ["inputs:bg", "inputs:fg", "inputs:mix"]
                    .map(|input| self.given(r, shader, input, content));
                let or_black = |given: Option<Given>| given.map_or(Rgb::BLACK.into(), |g| g.input());
                let ends = [or_black(background?), or_black(foreground?)];
                mix(&mut self.builder, ends, or_black(amount?)).map(|mixed| Some(mixed.into()))
            }
            Kind::Invert => {
                let Some(given) = self.given(r, shader, "inputs:in", content)? else { return Ok(None) };
                if given.texture.is_none() {
                    let factor = given.factor.map(|v| 1.0 - v);
                    return Ok(Some(Given { factor, ..given }));
                }
                let whole = node(&mut self.builder, given.input())?;
                let rest = between(&mut self.builder, [Rgb::WHITE, Rgb::BLACK], whole)?;
                Ok(Some(Given { factor: [1.0; 4], texture: Some(rest), ..given }))
            }
            Kind::Extract => {
                let index = self.input_number(shader, "inputs:index", 0.0)?.clamp(0.0, 3.0);
                let channel = [Channel::R, Channel::G, Channel::B, Channel::A][index as usize];
                let given = self.given(r, shader, "inputs:in", content)?;
                Ok(given.map(|given| given.only(channel)))
            }
            Kind::Separate => {
                let given = self.given(r, shader, "inputs:in", content)?;
                Ok(given.map(|given| given.only(channel_of(output))))
            }
            Kind::Reader(fallback) => {
                met("UsdPreviewSurface", "UsdPrimvarReader as a value", at, &mut self.builder)?;
                Ok(self.plain_input(shader, fallback)?.as_ref().and_then(Given::of_value))
            }
        }
    }

    /// Product of two values. Two textures must have the same channel; otherwise the first value is
    /// used, with a note.
    fn product(&mut self, one: Given, other: Given, shader: &Prim) -> Result<Option<Given>> {
        if one.texture.is_some() && other.texture.is_some() {
            if one.channel != other.channel {
                let at = self.at(shader);
                met("UsdPreviewSurface", "another shader", at, &mut self.builder)?;
                return Ok(Some(one));
            }
            let both = product(&mut self.builder, one.input(), other.input())?;
            return Ok(Some(Given {
                channel: one.channel,
                is_one_channel: one.is_one_channel,
                ..both.into()
            }));
        }
        let (textured, factor) = if one.texture.is_some() { (one, other) } else { (other, one) };
        let mut all = factor.factor;
        if factor.is_one_channel {
            all = [factor.number(); 4];
        }
        let factor = std::array::from_fn(|channel| textured.factor[channel] * all[channel]);
        Ok(Some(Given { factor, ..textured }))
    }

    /// Returns true if all nodes that a shader's inputs depend on are supported. Tangents, which
    /// are not used, do not count.
    pub fn is_understood(&mut self, shader: &Prim) -> Result<bool> {
        let mut seen = BTreeSet::new();
        let mut waiting = vec![shader.clone()];
        while let Some(prim) = waiting.pop() {
            if !seen.insert(prim.path.clone()) {
                continue;
            }
            let inputs = self.properties(&prim);
            for input in
                inputs.iter().filter(|name| name.starts_with("inputs:") && !name.ends_with("tangent"))
            {
                if let Some(Source::Output(next, _)) = self.source(&prim, input)? {
                    if seen.len() >= MOST_NODES as usize || !is_known(&self.shader(&next)?) {
                        return Ok(false);
                    }
                    waiting.push(next);
                }
            }
        }
        Ok(true)
    }
}
