//! Motion while the shutter is open: tracks of cameras and meshes, and notes of moving lights.
//!
//! glTF animates translation, rotation and scale of nodes separately, by curves of three kinds, and
//! all nodes above a camera or a mesh contribute to its pose. The pose is therefore sampled at
//! [`STEPS`] + 1 equidistant times and interpolated by [`Track`]. Uniform rotations and
//! translations, and poses held for more than a thirty-second of the shutter's time, are
//! reproduced. Motion around a point follows chords: for a whole turn while the shutter is open,
//! the error is at most half a percent of the radius.
//!
//! [Shapes](super::shapes) are evaluated when the shutter opens and when it closes; vertices move
//! in straight lines between. Rotations of joints thus follow chords, and a deformation that
//! appears and disappears between these two times is lost.
//!
//! Held to this by `gltf_animations::cameras_move_while_the_shutter_is_open`,
//! `gltf_animations::meshes_move_while_the_shutter_is_open`,
//! `gltf_shapes::shapes_change_while_the_shutter_is_open`.

use std::collections::{BTreeMap, BTreeSet};

use glam::DAffine3;

use super::animations::{self, Pose, Poses};
use super::nodes;
use super::source::Source;
use crate::error::{Location, Result};
use crate::scene::{NoteKind, SceneBuilder};

/// Number of equal intervals of the shutter's time; chosen.
const STEPS: u32 = 32;

/// Poses of nodes while the shutter is open.
pub(super) struct Exposure {
    /// Times at which the shutter opens and closes (s).
    pub shutter: [f64; 2],
    parents: Vec<Option<usize>>,
    /// Times (s), each with the poses of all nodes that have a camera, a mesh or a light, and of
    /// the nodes above them.
    moments: Vec<(f64, BTreeMap<usize, Pose>)>,
    /// Poses of the nodes of `moments` and of joints, when the shutter opens and when it closes.
    pub ends: [Poses; 2],
    /// Nodes of `moments` whose pose changes.
    moving: BTreeSet<usize>,
}

impl Exposure {
    /// Evaluates the animations between two times (s). Returns none if the times are equal or
    /// nothing is animated. Notes nodes with a light that move.
    pub fn new(
        source: &Source<'_>,
        animated: &[serde_json::Value],
        shutter: [f64; 2],
        builder: &mut SceneBuilder,
    ) -> Result<Option<Self>> {
        let [open, close] = shutter;
        if open == close || animated.is_empty() {
            return Ok(None);
        }
        let parents = nodes::parents(source)?;
        // Problems of the animations were noted when they were read for the scene itself.
        let mut unheard = SceneBuilder::new("", Location::default());
        let mut at = |seconds: f64, only: Option<&BTreeSet<usize>>| {
            animations::at(source, animated, seconds, only, &mut unheard)
        };
        let above = |node: usize| std::iter::successors(Some(node), |&node| parents[node]);
        let root = &source.root.nodes;
        let lights =
            |node: &usize| root[*node].extensions.as_ref().is_some_and(|e| e.khr_lights_punctual.is_some());
        let is_seen =
            |node: &usize| root[*node].camera.is_some() || root[*node].mesh.is_some() || lights(node);
        // Adds a node with all nodes above it; the walk ends at a node that was added before.
        let add = |node: usize, all: &mut BTreeSet<usize>| {
            above(node).take_while(|&node| all.insert(node)).for_each(drop);
        };
        let mut only = BTreeSet::new();
        (0..root.len()).filter(is_seen).for_each(|node| add(node, &mut only));
        let mut with_joints = only.clone();
        let skins = (0..root.len()).filter_map(|node| root[node].skin.map(|skin| skin.value()));
        for skin in skins.collect::<BTreeSet<_>>() {
            source.root.skins[skin].joints.iter().for_each(|joint| add(joint.value(), &mut with_joints));
        }
        let ends = [at(open, Some(&with_joints))?, at(close, Some(&with_joints))?];
        let time = |k: u32| open + f64::from(k) / f64::from(STEPS) * (close - open);
        let moments = (0..=STEPS).map(|k| Ok((time(k), at(time(k), Some(&only))?.places)));
        let moments: Vec<(f64, BTreeMap<usize, Pose>)> = moments.collect::<Result<_>>()?;
        let stands =
            |node: &usize| moments.iter().all(|(_, poses)| poses.get(node) == moments[0].1.get(node));
        let moving: BTreeSet<usize> = only.iter().copied().filter(|node| !stands(node)).collect();
        for node in (0..root.len()).filter(lights) {
            if above(node).any(|node| moving.contains(&node)) {
                let message =
                    "lights that move: where they are in the middle of the time that the shutter is open";
                builder.note(NoteKind::Approximated, message, source.at(format!("nodes[{node}]")));
            }
        }
        Ok(Some(Self { shutter, parents, moments, ends, moving }))
    }

    /// Times (s) and transforms to the world of a node that moves; none if it does not.
    pub fn of_moving(&self, source: &Source<'_>, node: usize) -> Option<Vec<(f64, DAffine3)>> {
        let mut above = std::iter::successors(Some(node), |&node| self.parents[node]);
        above.any(|node| self.moving.contains(&node)).then(|| self.of(source, node))
    }

    /// Times (s) and the transforms of a node to the world.
    pub fn of(&self, source: &Source<'_>, node: usize) -> Vec<(f64, DAffine3)> {
        let to_world = |poses: &BTreeMap<usize, Pose>| {
            let above = std::iter::successors(Some(node), |&node| self.parents[node]);
            above
                .fold(DAffine3::IDENTITY, |below, node| nodes::placed(source, node, poses.get(&node)) * below)
        };
        self.moments.iter().map(|(seconds, poses)| (*seconds, to_world(poses))).collect()
    }
}
