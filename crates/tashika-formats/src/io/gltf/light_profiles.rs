//! Lamps of the extension `EXT_lights_ies`: IES files at nodes.
//!
//! A lamp points down the `−z` axis of its node, and `C` grows from 0° at `+x` towards `+y`; the
//! node's scale has no effect on it. Intensities in candela are taken as W·sr⁻¹, as for other
//! lights, and multiplied by `multiplier` and `color`. [`ies`] decodes the files.
//!
//! A profile that is missing or cannot be read is noted, and its lamps are ignored. A map takes the
//! same memory whatever the size of its file, and counts toward the budget of images.
//!
//! # Held to this by
//! `suite::gltf_profiles`.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DMat3, DVec3, Mat3};
use gltf::json;
use serde_json::Value;

use super::lights::NEGATIVE;
use super::nodes::PlacedNode;
use super::source::Source;
use super::uri;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::io::assets::{kind, reason};
use crate::io::ies;
use crate::io::notes::shown;
use crate::scene::{IntensityMap, NoteKind, SceneBuilder};

const NAME: &str = "EXT_lights_ies";

/// Bytes of a map: its texels of three numbers.
const MAP_BYTES: u64 = ies::SIZE[0] as u64 * ies::SIZE[1] as u64 * 12;

/// Profiles decoded so far, by index; none for those that are dark or could not be read.
#[derive(Default)]
pub(super) struct Profiles(BTreeMap<usize, Option<Arc<IntensityMap>>>);

impl Profiles {
    /// Adds the node's lamp, if it has one.
    pub(super) fn add(
        &mut self,
        source: &Source<'_>,
        placed: &PlacedNode,
        builder: &mut SceneBuilder,
    ) -> Result<()> {
        let node = &source.root.nodes[placed.index];
        let Some(lamp) = node.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(()) };
        let at = |field: &str| source.at(format!("nodes[{}].extensions.{NAME}{field}", placed.index));
        builder.begin_light(node.name.as_deref().unwrap_or_default());
        let (index, profile) = chosen(source, NAME, lamp, "light profiles", at(".light"))?;
        let multiplier = match lamp.get("multiplier") {
            Some(given) => number(given, &at(".multiplier"), builder)?,
            None => 1.0,
        };
        let color = match lamp.get("color").map(|v| (v, v.as_array().map(Vec::as_slice))) {
            Some((_, Some([r, g, b]))) => {
                let mut channel = |v| Ok(number(v, &at(".color"), builder)?.min(1.0));
                Rgb::new(channel(r)?, channel(g)?, channel(b)?)
            }
            Some((other, _)) => {
                return Err(Error::invalid(at(".color"), shown(&other.to_string()), "three numbers"));
            }
            None => Rgb::WHITE,
        };
        let position = placed.to_world.translation.as_vec3();
        let (true, Some(to_world)) = (position.is_finite(), turned(placed.to_world.matrix3)) else {
            let at = source.at(format!("nodes[{}]", placed.index));
            let message = "lights with a transform that loses their place or direction: left out";
            builder.note(NoteKind::Repaired, message, at);
            return Ok(());
        };
        let map = self.0.entry(index).or_insert_with(|| {
            let at = source.at(format!("extensions.{NAME}.lights[{index}]"));
            decode(source, profile, index, &at).unwrap_or_else(|error| {
                let message =
                    format!("light profile {index} could not be read ({}): left out", reason(&error));
                builder.note(kind(&error), message, at);
                None
            })
        });
        match map {
            Some(map) => {
                builder.add_image_light(map, placed.to_world.translation, color * multiplier, to_world)
            }
            None => Ok(()),
        }
    }
}

fn decode(
    source: &Source<'_>,
    profile: &Value,
    index: usize,
    at: &Location,
) -> Result<Option<Arc<IntensityMap>>> {
    let bytes = match (profile.get("uri"), profile.get("bufferView")) {
        (_, Some(view)) => {
            let views = source.root.buffer_views.len();
            let view = view.as_u64().filter(|&view| view < views as u64);
            let view = view.ok_or_else(|| {
                let found = shown(&profile["bufferView"].to_string());
                Error::invalid(at.clone(), found, format!("the index of one of {views} buffer views"))
            })?;
            source.view(json::Index::new(view as u32))?.0.into()
        }
        (Some(Value::String(name)), None) => source.file(name, at)?,
        _ => return Err(Error::invalid(at.clone(), "neither uri nor bufferView", "one of them")),
    };
    source.image_budget.take(MAP_BYTES, at)?;
    let name = match profile.get("uri") {
        Some(Value::String(name)) if !uri::is_data(name) => shown(name),
        _ => format!("lights[{index}]"),
    };
    Ok(ies::decode(&bytes, &name, at)?.map(Arc::new))
}

/// Light that the field `light` of `user` selects from the list of an extension. `at` is the place
/// of `user` in the file.
pub(super) fn chosen<'s>(
    source: &'s Source<'_>,
    extension: &str,
    user: &Value,
    what: &str,
    at: Location,
) -> Result<(usize, &'s Value)> {
    let of_root = source.root.extensions.as_ref().and_then(|e| e.others.get(extension));
    let all = of_root.and_then(|e| e.get("lights")?.as_array()).map_or(&[][..], Vec::as_slice);
    let named = user.get("light");
    let index = named.and_then(Value::as_u64).and_then(|index| usize::try_from(index).ok());
    index.and_then(|index| Some((index, all.get(index)?))).ok_or_else(|| {
        let found = named.map_or("nothing".to_owned(), |v| shown(&v.to_string()));
        Error::invalid(at, found, format!("the index of one of {} {what}", all.len()))
    })
}

/// Reads a finite number; a number below 0 becomes 0, with a note.
pub(super) fn number(value: &Value, at: &Location, builder: &mut SceneBuilder) -> Result<f32> {
    let number = value.as_f64().map(|v| v as f32).filter(|v| v.is_finite());
    let number = number.ok_or_else(|| {
        Error::invalid(at.clone(), shown(&value.to_string()), "finite numbers of at least 0")
    })?;
    if number < 0.0 {
        builder.note(NoteKind::Repaired, NEGATIVE, at.clone());
    }
    Ok(number.max(0.0))
}

/// Rotation from the map's frame (`+y` up, `+x` at `C = 0°`) to the world, by the node without its
/// scale; none if the node's transform leaves no direction.
fn turned(node: DMat3) -> Option<Mat3> {
    let z = node.z_axis.try_normalize()?;
    let x = (node.x_axis - z * z.dot(node.x_axis)).try_normalize()?;
    let y: DVec3 = z.cross(x) * node.determinant().signum();
    Some(DMat3::from_cols(x, z, -y).as_mat3())
}
