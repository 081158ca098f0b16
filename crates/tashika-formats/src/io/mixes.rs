//! Mixed surfaces that several formats share.
//!
//! The parts of a mix are separate materials. At each point, one of them is chosen at random. If
//! the mix stands for a sum of two lobes, the colour of each is divided by the share of its part.
//!
//! Held to this by the formats' tests, and by the suite's `formula_materials`.

use crate::color::Rgb;
use crate::error::Result;
use crate::scene::{ColorInput, FloatInput, Material, SceneBuilder, Surface};

/// Reflectance of surfaces whose properties are unknown; chosen.
pub(super) const GREY: f32 = 0.5;

/// A diffuse surface of the reflectance [`GREY`].
pub(super) fn grey() -> Surface {
    Surface::Lambert { reflectance: Rgb::gray(GREY).into() }
}

/// Mix of two named surfaces, of which the second is chosen with probability `amount`.
pub(super) fn mix(
    builder: &mut SceneBuilder,
    parts: [(String, Surface); 2],
    amount: FloatInput,
) -> Result<Surface> {
    let [first, second] = parts.map(|(name, surface)| builder.add_material(Material::new(name, surface)));
    Ok(Surface::Mix { first: first?, second: second?, amount })
}

/// Mix of two surfaces, named as parts of `of`.
pub(super) fn either(
    builder: &mut SceneBuilder,
    of: &str,
    [first, second]: [Surface; 2],
    amount: impl Into<FloatInput>,
) -> Result<Surface> {
    let parts = [(format!("{of}: first part"), first), (format!("{of}: second part"), second)];
    mix(builder, parts, amount.into())
}

/// Divides a colour by the share of its part in a mix. The factor of the result is at most 1.
pub(super) fn of_share(color: ColorInput, share: f32) -> ColorInput {
    ColorInput { factor: (color.factor * (1.0 / share)).map(|v| v.min(1.0)), ..color }
}

/// Diffuse reflection beside a lobe; `lobe` makes the lobe from its colour. Together they reflect
/// at most 1.
pub(super) fn beside(
    builder: &mut SceneBuilder,
    names: [String; 2],
    [diffuse, specular]: [ColorInput; 2],
    lobe: impl FnOnce(ColorInput) -> Surface,
) -> Result<Surface> {
    let weights = [diffuse, specular].map(|c| c.factor.max_channel());
    let sum = weights[0] + weights[1];
    if weights[1] <= 0.0 {
        return Ok(Surface::Lambert { reflectance: diffuse });
    }
    let amount = weights[1] / sum;
    let share = |color, share: f32| of_share(color, share * sum.max(1.0));
    let lobe = lobe(share(specular, amount));
    if amount >= 1.0 {
        return Ok(lobe);
    }
    let base = Surface::Lambert { reflectance: share(diffuse, 1.0 - amount) };
    let [first, second] = names;
    mix(builder, [(first, base), (second, lobe)], amount.into())
}
