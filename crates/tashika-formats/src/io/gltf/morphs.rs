//! Morph targets: offsets of the vertices of a mesh, times weights (glTF 2.0 section 3.7.2.2),
//!
//! ```text
//! p = p₀ + Σ wᵢ Δpᵢ     n ∥ n₀ + Σ wᵢ Δnᵢ
//! ```
//!
//! The weights are those of an animation, else the node's, else the mesh's, else zero. Targets that
//! move tangents only have no effect: tangents follow the texture coordinates of the deformed
//! surface.
//!
//! # Guarantee
//! Targets whose weight is zero are not read. Others count toward the scene's geometry budget each
//! time that they are referred to.
//!
//! # Held to this by
//! The test module `gltf_shapes`.

use std::collections::BTreeMap;

use glam::Vec3;
use gltf::json;
use gltf::json::accessor::Type;

use super::features::met;
use super::shapes::Wanted;
use super::source::Source;
use crate::error::{Error, Location, Result};
use crate::io::notes::shown;
use crate::scene::{MeshShape, NoteKind, SceneBuilder};

/// Notes attributes of targets that have no effect, such as texture coordinates and colours.
pub(super) fn tell_others(
    file: &Location,
    others: BTreeMap<String, String>,
    builder: &mut SceneBuilder,
) -> Result<()> {
    for (name, place) in others {
        let row = ["TEXCOORD_", "COLOR_"].into_iter().find(|set| name.starts_with(set));
        let row = row.map_or_else(|| shown(&name), |set| format!("{set}0"));
        met("target", &row, file.clone().item(place), builder)?;
    }
    Ok(())
}

/// Largest number of morph targets that a primitive of the mesh has.
pub(super) fn targets(mesh: &json::Mesh) -> usize {
    mesh.primitives.iter().map(|p| p.targets.as_ref().map_or(0, Vec::len)).max().unwrap_or(0)
}

/// Weights of the targets of a node's mesh, one for each, without animation.
pub(super) fn weights(source: &Source<'_>, node: usize, builder: &mut SceneBuilder) -> Result<Vec<f32>> {
    let Some(mesh) = source.root.nodes[node].mesh.map(|mesh| mesh.value()) else { return Ok(Vec::new()) };
    let document = &source.root.meshes[mesh];
    let count = targets(document);
    let (given, item) = match (&source.root.nodes[node].weights, &document.weights) {
        (Some(weights), _) => (weights, format!("nodes[{node}].weights")),
        (None, Some(weights)) => (weights, format!("meshes[{mesh}].weights")),
        (None, None) => return Ok(vec![0.0; count]),
    };
    if let Some(wrong) = given.iter().find(|weight| !weight.is_finite()) {
        return Err(Error::invalid(source.at(item), format!("the weight {wrong}"), "finite numbers"));
    }
    if given.len() != count {
        let message =
            "weights that are not as many as the morph targets: missing ones are 0, others left out";
        builder.note(NoteKind::Repaired, message, source.at(item));
    }
    // One for each target, however many weights the file lists.
    Ok((0..count).map(|target| given.get(target).copied().unwrap_or(0.0)).collect())
}

/// Moves the vertices of a primitive; weights beyond its own targets have no effect.
pub(super) fn apply(
    source: &Source<'_>,
    wanted: &Wanted<'_>,
    weights: &[f32],
    vertices: &mut MeshShape,
) -> Result<()> {
    let targets = wanted.primitive.targets.iter().flatten();
    for (i, (target, &weight)) in targets.zip(weights).enumerate().filter(|(_, (_, weight))| **weight != 0.0)
    {
        let add = |index: Option<json::Index<json::Accessor>>, name: &str, to: &mut [Vec3]| -> Result<()> {
            let Some(index) = index.filter(|_| !to.is_empty()) else { return Ok(()) };
            let at = source.at(format!("{}.targets[{i}].{name}", wanted.item));
            source.geometry_budget.take(size_of_val(to) as u64, &at)?;
            let moves = source.accessor_beside(index, Type::Vec3, wanted.count, at)?;
            let moves = moves.expect_count(wanted.count)?.vectors(wanted.range.clone())?;
            to.iter_mut().zip(moves).for_each(|(v, d)| *v += Vec3::from_array(d) * weight);
            Ok(())
        };
        add(target.positions, "POSITION", &mut vertices.positions)?;
        add(target.normals, "NORMAL", &mut vertices.normals)?;
    }
    Ok(())
}
