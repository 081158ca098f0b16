//! Shapes of meshes at a time, by the weights of their [morph targets](super::morphs) and the
//! joints of their [skins](super::skins).
//!
//! Nodes of one mesh with equal weights and the same skin share its shape. An exposure has two
//! shapes, when the shutter opens and when it closes; vertices move in straight lines between.
//!
//! Held to this by the test module `gltf_shapes`.

use std::collections::BTreeMap;
use std::ops::Range;
use std::rc::Rc;

use glam::{DAffine3, DVec3};
use gltf::json;

use super::animations::Poses;
use super::morphs;
use super::nodes;
use super::skins::{self, Influences};
use super::source::Source;
use crate::error::Result;
use crate::math::local_origin;
use crate::scene::{MeshShape, SceneBuilder};

/// Vertices that are to be read from a primitive.
pub(super) struct Wanted<'w> {
    pub primitive: &'w json::mesh::Primitive,
    /// Place of the primitive in the file.
    pub item: &'w str,
    /// Number of vertices of the primitive.
    pub count: usize,
    /// Vertices that triangles use.
    pub range: Range<usize>,
}

/// Key of a shape of one mesh: the skin, and the bits of the weights at each moment; no weights
/// where all are zero.
pub(super) type ShapeKey = (Option<usize>, Vec<Vec<u32>>);

/// Weights and skin of a mesh at each moment.
#[derive(Default)]
pub(super) struct Shape {
    /// Weights by moment; empty if all weights are zero.
    weights: Vec<Vec<f32>>,
    skin: Option<Skin>,
}

struct Skin {
    index: usize,
    /// Transforms to the world, by moment and joint.
    joints: Rc<[Vec<DAffine3>]>,
}

/// Weights and transforms at a time.
struct Moment {
    /// Weights that are animated, by node.
    weights: BTreeMap<usize, Vec<f32>>,
    /// Transforms of all nodes to the world, if there are skins.
    places: Vec<DAffine3>,
}

/// The shapes of a document's nodes.
pub(super) struct Shapes {
    moments: Vec<Moment>,
    /// Joints of the skins in use so far, by skin.
    skins: BTreeMap<usize, Rc<[Vec<DAffine3>]>>,
}

impl Shapes {
    /// Shapes for the given poses, at one moment or several.
    pub fn new(source: &Source<'_>, moments: &[&Poses]) -> Result<Self> {
        let has_skins = !source.root.skins.is_empty();
        let moment = |poses: &&Poses| {
            let places = if has_skins { nodes::everywhere(source, &poses.places)? } else { Vec::new() };
            Ok(Moment { weights: poses.weights.clone(), places })
        };
        let moments = moments.iter().map(moment).collect::<Result<Vec<_>>>()?;
        Ok(Self { moments, skins: BTreeMap::new() })
    }

    /// The shape of the mesh of a node.
    pub fn of(&mut self, source: &Source<'_>, node: usize, builder: &mut SceneBuilder) -> Result<Shape> {
        let still = morphs::weights(source, node, builder)?;
        let weights = |moment: &Moment| moment.weights.get(&node).unwrap_or(&still).clone();
        let mut weights: Vec<Vec<f32>> = self.moments.iter().map(weights).collect();
        if weights.iter().flatten().all(|weight| *weight == 0.0) {
            weights.clear();
        }
        let Some(index) = source.root.nodes[node].skin.map(|skin| skin.value()) else {
            return Ok(Shape { weights, skin: None });
        };
        let joints = match self.skins.get(&index) {
            Some(joints) => Rc::clone(joints),
            None => {
                let of = |moment: &Moment| skins::joints(source, index, &moment.places, builder);
                let joints: Rc<[_]> = self.moments.iter().map(of).collect::<Result<Vec<_>>>()?.into();
                self.skins.insert(index, Rc::clone(&joints));
                joints
            }
        };
        Ok(Shape { weights, skin: Some(Skin { index, joints }) })
    }
}

impl Shape {
    pub fn key(&self) -> ShapeKey {
        let bits = |weights: &Vec<f32>| weights.iter().map(|weight| weight.to_bits()).collect();
        (self.skin.as_ref().map(|skin| skin.index), self.weights.iter().map(bits).collect())
    }

    /// Returns the vertices of a primitive at each moment (once if they are equal at all moments),
    /// their origin (m), and true if they are in world space.
    pub fn applied(
        &self,
        source: &Source<'_>,
        wanted: &Wanted<'_>,
        vertices: MeshShape,
        builder: &mut SceneBuilder,
    ) -> Result<(Vec<MeshShape>, DVec3, bool)> {
        let influences = match &self.skin {
            Some(skin) => Influences::of(source, wanted, skin.joints.first().map_or(0, Vec::len), builder)?,
            None => None,
        };
        let moments = self.weights.len().max(self.skin.as_ref().map_or(0, |skin| skin.joints.len()));
        if moments == 0 {
            return Ok((vec![vertices], DVec3::ZERO, false));
        }
        let mut all: Vec<MeshShape> = Vec::with_capacity(moments);
        let mut origin = None;
        let bytes = size_of_val(&vertices.positions[..]) + size_of_val(&vertices.normals[..]);
        for moment in 0..moments {
            if moment > 0 {
                source.geometry_budget.take(bytes as u64, &source.at(wanted.item))?;
            }
            let mut moved = vertices.clone();
            if let Some(weights) = self.weights.get(moment) {
                morphs::apply(source, wanted, weights, &mut moved)?;
            }
            if let (Some(influences), Some(skin)) = (&influences, &self.skin) {
                let places = influences.apply(&skin.joints[moment], &mut moved);
                let origin = *origin.get_or_insert_with(|| local_origin(places.iter().copied()));
                moved.positions = places.into_iter().map(|place| (place - origin).as_vec3()).collect();
            }
            all.push(moved);
        }
        if all.iter().all(|vertices| *vertices == all[0]) {
            all.truncate(1);
        }
        Ok((all, origin.unwrap_or(DVec3::ZERO), influences.is_some()))
    }
}
