//! Surfaces of several parts, as formats describe them.
//!
//! Parts of a mix are materials of their own, of which each point is one at random. A lobe that
//! stands for a sum of two is divided by the share of the part that has it.
//!
//! Held to this by the formats' tests, and by the suite's `formula_materials`.

use crate::color::Rgb;
use crate::error::Result;
use crate::scene::{ColorInput, FloatInput, Material, SceneBuilder, Surface};

/// Reflectance of what nothing is known of: a middling value.
pub(super) const GREY: f32 = 0.5;

/// A surface of that reflectance.
pub(super) fn grey() -> Surface {
    Surface::Lambert { reflectance: Rgb::gray(GREY).into() }
}

/// One of two surfaces at each point: the second on the share `amount`, each with its name.
pub(super) fn mix(
    builder: &mut SceneBuilder,
    parts: [(String, Surface); 2],
    amount: FloatInput,
) -> Result<Surface> {
    let [first, second] = parts.map(|(name, surface)| builder.add_material(Material::new(name, surface)));
    Ok(Surface::Mix { first: first?, second: second?, amount })
}

/// The same, with names after that `of` which they are parts.
pub(super) fn either(
    builder: &mut SceneBuilder,
    of: &str,
    [first, second]: [Surface; 2],
    amount: impl Into<FloatInput>,
) -> Result<Surface> {
    let parts = [(format!("{of}: first part"), first), (format!("{of}: second part"), second)];
    mix(builder, parts, amount.into())
}

/// A colour, divided by the share of the part of a mix that it belongs to.
pub(super) fn of_share(color: ColorInput, share: f32) -> ColorInput {
    ColorInput { factor: (color.factor * (1.0 / share)).map(|v| v.min(1.0)), ..color }
}

/// Diffuse reflection and a lobe of that colour side by side; together they reflect no more than 1.
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
