//! Facets of rough surfaces, and the tangent of brushed ones.
//!
//! A brushed surface has one roughness along a tangent and another across it. The tangent is
//! `∂p/∂u` of the triangle, made orthogonal to the shading normal `n`, as in pbrt and Mitsuba:
//!
//! ```text
//! t ∝ p_u − n (n·p_u)
//! ```
//!
//! If the material has a [`TangentInput`], the tangent is then rotated by it. If the texture
//! coordinates do not span the plane of a triangle, the tangent is that of [`Frame::about`] the
//! geometric normal, as in Mitsuba.
//!
//! The tangent is computed only for points of brushed materials. At all other points, the shading
//! frame is that of [`Frame::about`].
//!
//! Checked by the tests below, and by the suite's `mitsuba_materials`, `formula_materials` and
//! `brushed`.

use glam::{Vec2, Vec3};

use super::normal_map::Corners;
use super::{FloatInput, Surface, TextureId, Textures};
use crate::bsdf::{FacetModel, MAX_ALPHA, MIN_ALPHA, Microfacets};
use crate::math::Frame;
use crate::math::elementary::sin_cos;

/// Facets of a rough surface, whose roughness may be textured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetInput {
    /// Roughness `α`, 0 to 1; 0 is smooth. Roughness along the tangent if the surface is brushed.
    pub alpha: FloatInput,
    /// Roughness across the tangent, 0 to 1, if the surface is brushed. The surface is smooth only
    /// if both roughnesses are 0.
    pub across: Option<FloatInput>,
    /// Distribution of the facets.
    pub model: FacetModel,
}

impl FacetInput {
    /// Facets with the same roughness in all directions.
    pub fn even(alpha: FloatInput, model: FacetModel) -> Self {
        Self { alpha, across: None, model }
    }

    /// Facets of the principled material: `α/a` along the tangent and `α a` across it, with
    /// `a = √(1 − 0.9 s)` (Burley 2012, section 5.4).
    ///
    /// * `alpha`: the square of the material's roughness.
    /// * `anisotropic`: `s`, in `[0, 1]`.
    pub fn of_aspect(alpha: FloatInput, anisotropic: f32, model: FacetModel) -> Self {
        let aspect = aspect(anisotropic);
        let by = |factor: f32| FloatInput { factor: alpha.factor * factor, ..alpha };
        Self { alpha: by(1.0 / aspect), across: (aspect < 1.0).then(|| by(aspect)), model }
    }

    /// Returns the facets at `uv`; `None` where the surface is smooth.
    pub(super) fn at(&self, textures: Textures<'_>, uv: Vec2) -> Option<Microfacets> {
        let along = self.alpha.at(textures, uv);
        let across = self.across.map_or(along, |across| across.at(textures, uv));
        let limited = |alpha: f32| alpha.clamp(MIN_ALPHA, 1.0);
        (along > 0.0 || across > 0.0)
            .then(|| Microfacets { alpha: [limited(along), limited(across)], model: self.model })
    }
}

impl From<FloatInput> for FacetInput {
    fn from(alpha: FloatInput) -> Self {
        Self::even(alpha, FacetModel::default())
    }
}

impl From<f32> for FacetInput {
    fn from(alpha: f32) -> Self {
        FloatInput::from(alpha).into()
    }
}

/// `α` along and across the tangent of glTF's material: `α + (1 − α) s²` and `α`
/// (`KHR_materials_anisotropy`, Khronos).
///
/// * `alpha`: in `[0, 1]`.
/// * `strength`: `s`, in `[0, 1]`.
pub(super) fn anisotropic_alphas(alpha: f32, strength: f32) -> [f32; 2] {
    let along = alpha + (1.0 - alpha) * strength * strength;
    [along, alpha].map(|alpha| alpha.clamp(MIN_ALPHA, 1.0))
}

fn aspect(anisotropic: f32) -> f32 {
    (1.0 - 0.9 * anisotropic).sqrt()
}

/// `α` along and across the tangent of the principled material: `r²/a` and `r² a` with
/// `a = √(1 − 0.9 s)` (Burley 2012, section 5.4).
///
/// * `roughness`: `r`, in `[0, 1]`.
/// * `anisotropic`: `s`, in `[0, 1]`.
pub(super) fn of_aspect(roughness: f32, anisotropic: f32) -> [f32; 2] {
    let (alpha, aspect) = (roughness * roughness, aspect(anisotropic));
    [(alpha / aspect).clamp(MIN_ALPHA, MAX_ALPHA), (alpha * aspect).clamp(MIN_ALPHA, 1.0)]
}

impl Surface {
    /// Returns true if the facets have a tangent. The parts of a mix and the base of a layer are
    /// not examined.
    pub(super) fn is_brushed(&self) -> bool {
        match self {
            Self::Plastic { facets, .. }
            | Self::Conductor { facets, .. }
            | Self::Coated { facets, .. }
            | Self::AshikhminShirley { facets, .. }
            | Self::Glass { facets, .. }
            | Self::ThinGlass { facets, .. } => facets.across.is_some(),
            Self::MetallicRoughness { anisotropy: strength, .. }
            | Self::Principled { anisotropic: strength, .. } => *strength != 0.0.into(),
            Self::Lambert { .. }
            | Self::Translucent { .. }
            | Self::Phong { .. }
            | Self::Mirror { .. }
            | Self::Sheen { .. }
            | Self::Clearcoat { .. }
            | Self::Boundary
            | Self::Mix { .. } => false,
        }
    }
}

/// Rotation of the tangent of brushed facets around the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentInput {
    /// Angle (rad), counter-clockwise as seen in an upright image on the surface.
    pub rotation: f32,
    /// Direction before the rotation, `2 · texel − 1`: red along `u`, green along `v` **up**; not
    /// decoded by the sRGB curve. If `None`, the direction of `u`.
    pub direction: Option<TextureId>,
}

/// Unit tangent of a surface point with this shading normal.
///
/// * `corners`: none if the mesh has no texture coordinates.
pub(super) fn tangent(
    input: Option<&TangentInput>,
    textures: Textures<'_>,
    uv: Vec2,
    corners: Option<&Corners>,
    normal: Vec3,
    geometric: Vec3,
) -> Vec3 {
    let Some((du, dv)) = corners.and_then(Corners::derivatives) else {
        return Frame::about(geometric).t;
    };
    let Some(input) = input else { return du.normalize_or(Vec3::X) };
    let plane = Frame::along(normal, du);
    // `v` runs down, but the second axis must run up.
    let up = plane.b * 1.0_f32.copysign(-plane.b.dot(dv));
    let direction = input.direction.map_or(Vec2::X, |texture| {
        let texel = textures.numbers(texture, uv).0;
        Vec2::new(2.0 * texel.r - 1.0, 2.0 * texel.g - 1.0).normalize_or(Vec2::X)
    });
    let (sin, cos) = sin_cos(input.rotation);
    let turned = Vec2::new(cos * direction.x - sin * direction.y, sin * direction.x + cos * direction.y);
    (plane.t * turned.x + up * turned.y).normalize_or(plane.t)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use super::*;
    use crate::color::Rgb;
    use crate::scene::Texture;

    /// A triangle in the plane z = 0. Seen from +z, `u` runs along +x and `v` along −y, as in an
    /// upright image.
    fn corners() -> Corners {
        let uvs = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(0.0, 0.0)];
        let positions = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0)];
        Corners { positions, uvs }
    }

    #[test]
    fn tangents_turn_counter_clockwise_from_u() {
        let nodes = [Texture::Constant(Rgb::new(0.5, 1.0, 0.0))];
        let textures = Textures { images: &[], nodes: &nodes, tile_sets: &[] };
        let of = |input: Option<TangentInput>, corners: &Corners, normal: Vec3| {
            tangent(input.as_ref(), textures, Vec2::ZERO, Some(corners), normal, Vec3::Z)
        };
        let turned = |rotation| Some(TangentInput { rotation, direction: None });
        let is = |found: Vec3, expected: Vec3| assert!((found - expected).length() < 1e-6, "{found}");
        is(of(None, &corners(), Vec3::Z), Vec3::X);
        is(of(turned(FRAC_PI_2), &corners(), Vec3::Z), Vec3::Y);
        // Seen from behind, the image is mirrored, but the tangent is the same line on the surface.
        is(of(turned(FRAC_PI_2), &corners(), Vec3::NEG_Z), Vec3::Y);
        let textured = TangentInput { rotation: 0.0, direction: Some(TextureId(0)) };
        is(of(Some(textured), &corners(), Vec3::Z), Vec3::Y);
        is(of(Some(TangentInput { rotation: FRAC_PI_2, ..textured }), &corners(), Vec3::Z), Vec3::NEG_X);
        // Texture coordinates for which the image is mirrored on the surface.
        let Corners { positions, mut uvs } = corners();
        uvs.iter_mut().for_each(|uv| uv.y = 1.0 - uv.y);
        is(of(turned(FRAC_PI_2), &Corners { positions, uvs }, Vec3::Z), Vec3::NEG_Y);
        let flat = Corners { positions: corners().positions, uvs: [Vec2::ZERO; 3] };
        is(of(turned(1.0), &flat, Vec3::Z), Frame::about(Vec3::Z).t);
    }
}
