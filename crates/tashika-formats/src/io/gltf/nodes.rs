//! The node graph: which nodes are in the scene, and where.
//!
//! A node's world transform is the product of the local ones from the root down to it (glTF 2.0
//! section 3.5.2), each a matrix or `T · R · S`; products are formed in `f64`. Animated values at
//! the given time replace the node's own.
//!
//! # Guarantee
//! The graph is a forest: a node with two parents, or one that is its own ancestor, is an error.
//! Depth is limited by memory only; nothing here recurses. Nodes that `KHR_node_visibility` hides
//! are omitted, with all nodes below.
//!
//! # Held to this by
//! `gltf::nodes_multiply_from_the_root_down`,
//! `damaged_gltf::nodes_that_form_no_forest_are_refused`,
//! `damaged_gltf::a_deep_chain_of_nodes_is_no_problem`.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use gltf::json;

use super::animations::Pose;
use super::features::met;
use super::source::Source;
use crate::error::{Error, Result};
use crate::scene::{NoteKind, SceneBuilder};

/// A node of the scene.
pub(super) struct PlacedNode {
    /// Index in the document's list of nodes.
    pub index: usize,
    /// Transform from node space to world space.
    pub to_world: DAffine3,
}

/// Transforms of all nodes of the document to the world, for the given poses. Nodes on or below a
/// cycle are at the origin; `place` reports them.
pub(super) fn everywhere(source: &Source<'_>, poses: &BTreeMap<usize, Pose>) -> Result<Vec<DAffine3>> {
    let nodes = &source.root.nodes;
    let parents = parents(source)?;
    let mut to_world = vec![DAffine3::IDENTITY; nodes.len()];
    let mut to_visit: Vec<usize> = (0..nodes.len()).filter(|&i| parents[i].is_none()).collect();
    while let Some(index) = to_visit.pop() {
        let parent = parents[index].map_or(DAffine3::IDENTITY, |parent| to_world[parent]);
        to_world[index] = parent * placed(source, index, poses.get(&index));
        to_visit.extend(children(&nodes[index]));
    }
    Ok(to_world)
}

/// The nodes of the scene to be rendered, parents before children, in the order of the file: the
/// default scene, else the first, else everything.
pub(super) fn place(
    source: &Source<'_>,
    poses: &BTreeMap<usize, Pose>,
    builder: &mut SceneBuilder,
) -> Result<Vec<PlacedNode>> {
    let root = &source.root;
    let parents = parents(source)?;
    let roots = (0..root.nodes.len()).filter(|&i| parents[i].is_none());
    refuse_cycles(source, roots.clone())?;
    let chosen = chosen_scene(root);
    for other in (0..root.scenes.len()).filter(|&i| Some(i) != chosen) {
        let at = source.at(format!("scenes[{other}]"));
        met("scene", "scenes", at, builder)?;
    }
    let first: Vec<usize> = match chosen {
        Some(scene) => {
            let mut listed = vec![false; root.nodes.len()];
            for (i, node) in root.scenes[scene].nodes.iter().enumerate() {
                let (node, at) = (node.value(), || source.at(format!("scenes[{scene}].nodes[{i}]")));
                if let Some(parent) = parents[node] {
                    let found = format!("{node}, a child of node {parent}");
                    return Err(Error::invalid(at(), found, "a node without parent"));
                }
                if std::mem::replace(&mut listed[node], true) {
                    return Err(Error::invalid(at(), format!("{node}, listed before"), "each node once"));
                }
            }
            root.scenes[scene].nodes.iter().map(|n| n.value()).collect()
        }
        None => roots.collect(),
    };
    let mut placed = Vec::new();
    let mut to_visit: Vec<(usize, DAffine3)> = first.iter().rev().map(|&i| (i, DAffine3::IDENTITY)).collect();
    while let Some((index, parent)) = to_visit.pop() {
        if is_hidden(&root.nodes[index]) {
            continue;
        }
        let to_world = parent * local(source, index, poses.get(&index), builder);
        placed.push(PlacedNode { index, to_world });
        to_visit.extend(children(&root.nodes[index]).rev().map(|child| (child, to_world)));
    }
    Ok(placed)
}

/// The scene that is rendered: the default one, else the first.
pub(super) fn chosen_scene(root: &json::Root) -> Option<usize> {
    root.scene.map(|s| s.value()).or_else(|| (!root.scenes.is_empty()).then_some(0))
}

/// Returns true if `KHR_node_visibility` hides the node and all nodes below.
fn is_hidden(node: &json::Node) -> bool {
    let visibility = node.extensions.as_ref().and_then(|e| e.others.get("KHR_node_visibility"));
    visibility.and_then(|v| v.get("visible")).is_some_and(|v| v.as_bool() == Some(false))
}

fn children(node: &json::Node) -> impl DoubleEndedIterator<Item = usize> {
    node.children.iter().flatten().map(|c| c.value())
}

/// The parent of each node.
pub(super) fn parents(source: &Source<'_>) -> Result<Vec<Option<usize>>> {
    let nodes = &source.root.nodes;
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        for child in children(node) {
            if let Some(other) = parents[child].replace(parent) {
                let at = source.at(format!("nodes[{child}]"));
                let found = format!("a child of node {other} and again of node {parent}");
                return Err(Error::invalid(at, found, "at most one parent"));
            }
        }
    }
    Ok(parents)
}

/// Refuses cycles. Each node has at most one parent, so exactly the nodes on or below a cycle
/// cannot be reached from any root.
fn refuse_cycles(source: &Source<'_>, roots: impl Iterator<Item = usize>) -> Result<()> {
    let nodes = &source.root.nodes;
    let mut reached = vec![false; nodes.len()];
    let mut to_visit: Vec<usize> = roots.collect();
    while let Some(node) = to_visit.pop() {
        reached[node] = true;
        to_visit.extend(children(&nodes[node]));
    }
    match reached.iter().position(|&r| !r) {
        Some(node) => {
            let at = source.at(format!("nodes[{node}]"));
            Err(Error::invalid(at, "a node on or below a cycle of nodes", "a tree"))
        }
        None => Ok(()),
    }
}

/// Transform from a node to its parent, with notes of repairs.
fn local(source: &Source<'_>, index: usize, pose: Option<&Pose>, builder: &mut SceneBuilder) -> DAffine3 {
    checked(source, index, pose, |field, message| {
        builder.note(NoteKind::Repaired, message, source.at(format!("nodes[{index}].{field}")));
    })
}

/// Transform from a node to its parent, without notes.
pub(super) fn placed(source: &Source<'_>, index: usize, pose: Option<&Pose>) -> DAffine3 {
    checked(source, index, pose, |_, _| ())
}

fn checked(
    source: &Source<'_>,
    index: usize,
    pose: Option<&Pose>,
    mut repaired: impl FnMut(&str, &str),
) -> DAffine3 {
    let node = &source.root.nodes[index];
    let [translation, of_matrix] = source.translations(index);
    if let Some(m) = node.matrix {
        let column =
            |c: usize| DVec3::new(f64::from(m[4 * c]), f64::from(m[4 * c + 1]), f64::from(m[4 * c + 2]));
        if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
            repaired("matrix", "node matrices whose last row is not 0 0 0 1: taken as if it were");
        }
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        return DAffine3 { matrix3, translation: of_matrix.unwrap_or(DVec3::ZERO) };
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let pose = pose.copied().unwrap_or_default();
    let translation = pose.translation.or(translation).unwrap_or(DVec3::ZERO);
    let scale = pose.scale.unwrap_or_else(|| vector(node.scale.unwrap_or([1.0; 3])));
    let rotation = pose.rotation.unwrap_or_else(|| {
        let xyzw = node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |q| q.0);
        unit_quaternion(DQuat::from_array(xyzw.map(f64::from))).unwrap_or_else(|| {
            repaired("rotation", "node rotations that are no quaternion: left out");
            DQuat::IDENTITY
        })
    });
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

/// The unit quaternion along a quaternion of any length; none if the length is near zero or not
/// finite.
pub(super) fn unit_quaternion(rotation: DQuat) -> Option<DQuat> {
    let length = rotation.length();
    (length.is_finite() && length > 1e-6).then(|| rotation / length)
}
