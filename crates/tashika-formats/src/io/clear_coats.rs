//! The clear coat of Disney's material, as Mitsuba and pbrt-v3 read it: `α = 0.1 + (0.001 − 0.1) gloss`
//! (Burley 2012, section 5.4).
//!
//! Held to this by `mitsuba::clear_coats_*` and the suite's `mitsuba_materials` and
//! `formula_materials`.

use crate::bsdf::{MAX_GTR1_ALPHA, MIN_ALPHA};
use crate::color::Rgb;
use crate::error::Result;
use crate::scene::{FloatInput, SceneBuilder, Texture};

/// `α` of a gloss; of a textured one a texture.
///
/// * `gloss`: 0 to 1.
pub(super) fn alpha_of_gloss(builder: &mut SceneBuilder, gloss: FloatInput) -> Result<FloatInput> {
    let alpha = |gloss: f32| MAX_GTR1_ALPHA + (MIN_ALPHA - MAX_GTR1_ALPHA) * gloss.clamp(0.0, 1.0);
    let Some((amount, channel)) = gloss.texture else { return Ok(alpha(gloss.factor).into()) };
    let [first, second] = [0.0, gloss.factor].map(|gloss| Texture::Constant(Rgb::gray(alpha(gloss))));
    let (first, second) = (builder.add_texture(first)?, builder.add_texture(second)?);
    let texture = builder.add_texture(Texture::Mix { first, second, amount })?;
    Ok(FloatInput { factor: 1.0, texture: Some((texture, channel)) })
}
