//! Lights of the extension `KHR_lights_punctual`.
//!
//! A light shines along the `−z` axis of its node; the node's scale has no effect on it. Colour
//! times intensity becomes radiant intensity (point, spot) or irradiance (directional), with the
//! numbers unchanged. The extension's units are photometric (cd, lx), those of this program
//! radiometric. The factor between them is the same for all lights of a scene and is left to
//! exposure.
//!
//! A spot has the falloff that the extension recommends, in which the difference of the cosines is
//! at least 0.001.
//!
//! # Held to this by
//! `gltf::lights_have_position_direction_and_intensity`.

use std::f32::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;

use super::features::met;
use super::nodes::PlacedNode;
use super::source::Source;
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::math::elementary::sin_cos;
use crate::scene::{Emitter, Falloff, FalloffShape, NoteKind, SceneBuilder};

/// Smallest difference of the cosines of a spot's two angles; from the extension's sample code.
const MIN_COS_DIFFERENCE: f32 = 1e-3;

/// Note about lights of negative intensity or colour.
pub(super) const NEGATIVE: &str = "lights of a negative intensity or colour: 0 in its place";

/// Adds the node's light, if it has one.
pub(super) fn add(source: &Source<'_>, placed: &PlacedNode, builder: &mut SceneBuilder) -> Result<()> {
    let node = &source.root.nodes[placed.index];
    let of_node = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let all = source.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let (Some(of_node), Some(all)) = (of_node, all) else { return Ok(()) };
    let index = of_node.light.value();
    let light = &all.lights[index];
    let at = |field: &str| source.at(format!("extensions.KHR_lights_punctual.lights[{index}]{field}"));
    let mut color = Rgb::from(light.color) * light.intensity;
    if !color.is_finite() {
        let found = format!("color {:?} of intensity {}", light.color, light.intensity);
        return Err(Error::invalid(at(""), found, "finite numbers"));
    }
    if !color.is_valid() {
        builder.note(NoteKind::Repaired, NEGATIVE, at(""));
        color = color.map(|v| v.max(0.0));
    }
    if light.range.is_some() {
        met("KHR_lights_punctual", "range", at(".range"), builder)?;
    }
    let position = placed.to_world.translation.as_vec3();
    let axis = placed.to_world.transform_vector3(DVec3::NEG_Z).try_normalize().map(|a| a.as_vec3());
    let is_turned = !matches!(light.type_, Checked::Valid(Type::Point));
    if !position.is_finite() || (is_turned && axis.is_none()) {
        let at = source.at(format!("nodes[{}]", placed.index));
        let message = "lights with a transform that loses their place or direction: left out";
        builder.note(NoteKind::Repaired, message, at);
        return Ok(());
    }
    let axis = axis.unwrap_or(Vec3::NEG_Z);
    let emitter = match light.type_ {
        Checked::Valid(Type::Point) => Emitter::Point { position, intensity: color },
        Checked::Valid(Type::Directional) => Emitter::Directional { direction: axis, irradiance: color },
        Checked::Valid(Type::Spot) => {
            let (falloff, in_order) = falloff(light);
            if !in_order {
                let message = "spot lights whose inner angle is not below the outer one, or that reach beyond 90°: brought into order";
                builder.note(NoteKind::Repaired, message, at(".spot"));
            }
            Emitter::Spot { position, axis, intensity: color, falloff }
        }
        Checked::Invalid => {
            return Err(Error::invalid(at(".type"), "an unknown type", "point, spot or directional"));
        }
    };
    let named = [node.name.as_deref(), light.name.as_deref()].into_iter().flatten();
    builder.begin_light(named.into_iter().find(|name| !name.is_empty()).unwrap_or_default());
    builder.add_emitter_at(emitter, placed.to_world.translation)
}

/// Returns the falloff, and true if the angles are as the extension requires:
/// `0 ≤ inner < outer ≤ π/2`.
fn falloff(light: &Light) -> (Falloff, bool) {
    let (inner, outer) =
        light.spot.as_ref().map_or((0.0, FRAC_PI_2 / 2.0), |s| (s.inner_cone_angle, s.outer_cone_angle));
    // Exporters write π/2 rounded either way.
    let in_order = 0.0 <= inner && inner < outer && outer <= FRAC_PI_2 + 1e-5;
    let outer = outer.clamp(0.0, FRAC_PI_2);
    let inner = inner.clamp(0.0, outer);
    let cos_outer = sin_cos(outer).1.min(1.0 - MIN_COS_DIFFERENCE);
    let cos_inner = sin_cos(inner).1.max(cos_outer + MIN_COS_DIFFERENCE);
    (Falloff { cos_inner, cos_outer, shape: FalloffShape::Squared }, in_order)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(inner: f32, outer: f32) -> (Falloff, bool) {
        let json =
            format!(r#"{{"type":"spot","spot":{{"innerConeAngle":{inner},"outerConeAngle":{outer}}}}}"#);
        falloff(&gltf::json::deserialize::from_str(&json).unwrap())
    }

    #[test]
    fn a_falloff_has_its_inner_cone_inside_the_outer_whatever_the_file_says() {
        let (f, in_order) = spot(0.3, 0.6);
        assert!(in_order && (f.cos_inner - 0.955_336).abs() < 1e-6 && (f.cos_outer - 0.825_336).abs() < 1e-6);
        for (inner, outer) in [(0.6, 0.3), (0.5, 0.5), (0.0, 0.0), (-1.0, 9.0), (9.0, -1.0), (3e38, 3e38)] {
            let (f, in_order) = spot(inner, outer);
            assert!(!in_order && f.cos_outer < f.cos_inner && f.cos_inner <= 1.0, "{inner} {outer}: {f:?}");
            assert!(f.at(1.0) == 1.0 && f.at(-1.0) == 0.0);
        }
    }
}
