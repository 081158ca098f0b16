//! Shading normals turned by textures: normal maps and bump maps.
//!
//! With the derivatives `p_u`, `p_v` of the position and the normal `n` of the surface:
//!
//! ```text
//! map:   n' ∝ s·r t + s·g b + a n        (r, g, a) = 2 · texel − 1, t, b: p_u, −p_v (v up) made orthogonal to n, unit length
//! bump:  n' ∝ p_u' × p_v'                p_u' = p_u + h_u n, p_v' = p_v + h_v n              (Blinn 1978)
//! ```
//!
//! `h_u` and `h_v` are the derivatives of the height, by forward differences with the step
//! [`STEP`].
//!
//! # Limits
//! If the new normal would make an angle with the geometric normal whose cosine is below
//! [`MIN_COSINE`], it is moved to that cosine. The derivatives are those of the flat triangle.

use glam::{Vec2, Vec3};

use super::{NormalInput, Textures};

/// Step of texture coordinates for the derivatives of a height. Chosen: finer than a texel of a
/// 1024² image.
const STEP: f32 = 5e-4;

/// Smallest cosine between the new normal and the geometric one.
const MIN_COSINE: f32 = 0.05;

/// A triangle's corners (world) with their texture coordinates.
pub(super) struct Corners {
    pub positions: [Vec3; 3],
    pub uvs: [Vec2; 3],
}

impl Corners {
    /// `∂p/∂u` and `∂p/∂v` (m); `None` where the coordinates do not span the plane.
    pub(super) fn derivatives(&self) -> Option<(Vec3, Vec3)> {
        let (p, t) = (self.positions, self.uvs);
        let (e1, e2) = (p[1] - p[0], p[2] - p[0]);
        let (t1, t2) = (t[1] - t[0], t[2] - t[0]);
        let determinant = t1.x * t2.y - t1.y * t2.x;
        let (u, v) = ((e1 * t2.y - e2 * t1.y) / determinant, (e2 * t1.x - e1 * t2.x) / determinant);
        (u.is_finite() && v.is_finite() && u != Vec3::ZERO && v != Vec3::ZERO).then_some((u, v))
    }
}

/// Returns the shading normal after perturbation.
///
/// * `normal`: unit shading normal; `geometric`: unit geometric normal, in the same hemisphere.
pub(super) fn perturbed(
    input: &NormalInput,
    textures: Textures<'_>,
    uv: Vec2,
    corners: &Corners,
    normal: Vec3,
    geometric: Vec3,
) -> Vec3 {
    let Some((du, dv)) = corners.derivatives() else { return normal };
    let turned = match input {
        NormalInput::Map { texture, scale } => {
            let t = textures.numbers(*texture, uv).0;
            let tangent = (du - normal * normal.dot(du)).normalize_or_zero();
            // `v` runs down, but the green channel of the map runs up.
            let up = -dv;
            let bitangent = (up - normal * normal.dot(up) - tangent * tangent.dot(up)).normalize_or_zero();
            tangent * ((2.0 * t.r - 1.0) * scale)
                + bitangent * ((2.0 * t.g - 1.0) * scale)
                + normal * (2.0 * t.b - 1.0)
        }
        NormalInput::Bump { height } => {
            let at = |offset: Vec2| height.at(textures, uv + offset);
            let middle = at(Vec2::ZERO);
            let slope_u = (at(Vec2::new(STEP, 0.0)) - middle) / STEP;
            let slope_v = (at(Vec2::new(0.0, STEP)) - middle) / STEP;
            // The derivatives are projected to the plane at right angles to the shading normal, so
            // that a constant height changes nothing.
            let du = du - normal * normal.dot(du);
            let dv = dv - normal * normal.dot(dv);
            let turned = (du + normal * slope_u).cross(dv + normal * slope_v);
            if turned.dot(normal) < 0.0 { -turned } else { turned }
        }
    };
    let unit = turned.normalize_or(normal);
    let cos = unit.dot(geometric);
    if cos >= MIN_COSINE {
        return unit;
    }
    let flat = unit - geometric * cos;
    (flat + geometric * (MIN_COSINE * flat.length().max(f32::MIN_POSITIVE))).normalize_or(normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::scene::{FloatInput, Image, ImageId, ImageTexture, Pixels, Texture, TextureId, Wrap};

    /// A 2 m × 2 m square in z = 0 seen from +z, `u` along +x, `v` along −y.
    fn corners() -> Corners {
        let uvs = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(0.0, 0.0)];
        let positions = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0)];
        Corners { positions, uvs }
    }

    #[test]
    fn red_turns_to_u_and_green_up() {
        let input = NormalInput::Map { texture: TextureId(0), scale: 1.0 };
        let turned = |r, g, b| {
            let nodes = [Texture::Constant(Rgb::new(r, g, b))];
            let textures = Textures { images: &[], nodes: &nodes, tile_sets: &[] };
            perturbed(&input, textures, Vec2::splat(0.5), &corners(), Vec3::Z, Vec3::Z)
        };
        assert!((turned(0.5, 0.5, 1.0) - Vec3::Z).length() < 1e-6);
        assert!((turned(0.8, 0.5, 0.9) - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6);
        assert!((turned(0.5, 0.8, 0.9) - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
        assert!(turned(1.0, 0.5, 0.0).z > 0.04, "never below the surface");
    }

    #[test]
    fn a_slope_turns_the_normal_back_by_its_angle() {
        // A ramp of two texels: between their centres, which are half the image or 1 m apart, the
        // height rises by 0.75 m.
        let pixels = vec![[0.0; 3], [0.75; 3]];
        let image = Image { name: "ramp".into(), width: 2, height: 1, pixels: Pixels::Float(pixels) };
        let mut ramp = ImageTexture::new(ImageId(0));
        ramp.wrap = [Wrap::Clamp; 2];
        let nodes = [Texture::Image(ramp)];
        let textures = Textures { images: &[image], nodes: &nodes, tile_sets: &[] };
        let height = FloatInput { factor: 1.0, texture: Some((TextureId(0), crate::scene::Channel::R)) };
        let input = NormalInput::Bump { height };
        let n = perturbed(&input, textures, Vec2::splat(0.5), &corners(), Vec3::Z, Vec3::Z);
        assert!((n - Vec3::new(-0.6, 0.0, 0.8)).length() < 1e-3, "{n}");
    }
}
