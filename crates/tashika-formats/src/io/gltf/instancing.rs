//! Instances of `EXT_mesh_gpu_instancing`: many placements of one node's mesh.
//!
//! Instance `i` has the transform `M · T_i · R_i · S_i`. `M` is the transform of the node; the
//! other factors are element `i` of the accessors `TRANSLATION`, `ROTATION` and `SCALE`. Each
//! accessor may be missing; the others must have equal numbers of elements.
//!
//! # Guarantee
//! Nothing is allocated for instances beyond the scene's budget of geometry.
//!
//! # Held to this by
//! `gltf_structure::instances_of_a_node_follow_its_transform`,
//! `gltf_structure::instances_that_do_not_fit_together_are_refused`.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3};
use gltf::json::Index;
use gltf::json::accessor::Type;
use serde::Deserialize;

use super::accessor::Accessor;
use super::nodes::{PlacedNode, unit_quaternion};
use super::source::Source;
use crate::error::{Error, Result};
use crate::io::notes::shown;
use crate::scene::{Instance, NoteKind, SceneBuilder};

const NAME: &str = "EXT_mesh_gpu_instancing";

/// Fields of the extension.
#[derive(Deserialize)]
struct Instancing {
    #[serde(default)]
    attributes: BTreeMap<String, u32>,
}

/// Returns the transforms of the node's mesh, which has `meshes` primitives; without the extension,
/// only the node's own transform.
pub(super) fn placements(
    source: &Source<'_>,
    placed: &PlacedNode,
    meshes: usize,
    builder: &mut SceneBuilder,
) -> Result<Vec<DAffine3>> {
    let item = format!("nodes[{}]", placed.index);
    let budget = |places: usize| {
        let bytes =
            (places as u64).saturating_mul(meshes as u64).saturating_mul(size_of::<Instance>() as u64);
        source.geometry_budget.take(bytes, &source.at(format!("{item}.mesh")))
    };
    let extensions = source.root.nodes[placed.index].extensions.as_ref();
    let Some(value) = extensions.and_then(|e| e.others.get(NAME)) else {
        budget(1)?;
        return Ok(vec![placed.to_world]);
    };
    let item = format!("nodes[{}].extensions.{NAME}", placed.index);
    let instancing = Instancing::deserialize(value).map_err(|e| {
        let found = format!("{NAME} that cannot be read ({})", shown(&e.to_string()));
        Error::invalid(source.at(&item), found, "attributes with the indices of accessors")
    })?;
    let mut count = None;
    let mut accessor = |name: &str, expected: Type| -> Result<Option<Accessor<'_>>> {
        let Some(&index) = instancing.attributes.get(name) else { return Ok(None) };
        let at = source.at(format!("{item}.attributes.{name}"));
        if index as usize >= source.root.accessors.len() {
            let expected = format!("an index below {}", source.root.accessors.len());
            return Err(Error::invalid(at, format!("accessor {index}"), expected));
        }
        let accessor = source.accessor(Index::new(index), expected, at.clone())?;
        let found = accessor.count();
        let expected = *count.get_or_insert(found);
        if found != expected {
            let expected = format!("{expected}, as the attribute before it");
            return Err(Error::invalid(at, format!("{found} elements"), expected));
        }
        Ok(Some(accessor))
    };
    let translations = accessor("TRANSLATION", Type::Vec3)?;
    let rotations = accessor("ROTATION", Type::Vec4)?;
    let scales = accessor("SCALE", Type::Vec3)?;
    let Some(count) = count else {
        budget(1)?;
        return Ok(vec![placed.to_world]);
    };
    budget(count)?;
    let vectors = |accessor: Option<Accessor<'_>>, default: f32| -> Result<Vec<[f32; 3]>> {
        accessor.map_or_else(|| Ok(vec![[default; 3]; count]), |a| a.vectors(0..count))
    };
    let (translations, scales) = (vectors(translations, 0.0)?, vectors(scales, 1.0)?);
    let rotations: Vec<[f32; 4]> =
        rotations.map_or_else(|| Ok(vec![[0.0, 0.0, 0.0, 1.0]; count]), |a| a.vectors(0..count))?;
    let mut places = Vec::with_capacity(count);
    for ((t, r), s) in translations.into_iter().zip(rotations).zip(scales) {
        let rotation = unit_quaternion(DQuat::from_array(r.map(f64::from))).unwrap_or_else(|| {
            let message = "instance rotations that are no quaternion: left out";
            builder.note(NoteKind::Repaired, message, source.at(format!("{item}.attributes.ROTATION")));
            DQuat::IDENTITY
        });
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        places.push(
            placed.to_world * DAffine3::from_scale_rotation_translation(vector(s), rotation, vector(t)),
        );
    }
    Ok(places)
}
