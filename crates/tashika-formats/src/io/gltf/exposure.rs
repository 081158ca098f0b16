//! What moves while the shutter is open: the tracks of cameras, and whether anything else does.
//!
//! glTF moves translation, rotation and scale of nodes apart from each other, by curves of three
//! kinds, and a camera by all nodes above it. So its pose is taken at [`STEPS`] + 1 times, the same
//! time apart, and is between two of these as [`Track`](crate::math::motion::Track) has it: what
//! turns or moves evenly, or in steps longer than a thirty-second of the shutter's time, is met.
//!
//! Held to this by `gltf_animations::cameras_move_while_the_shutter_is_open`.

use std::collections::{BTreeMap, BTreeSet};

use glam::DAffine3;

use super::animations::{self, Pose};
use super::nodes;
use super::source::Source;
use crate::error::{Location, Result};
use crate::scene::{NoteKind, SceneBuilder};

/// Parts that the time is cut into; chosen.
const STEPS: u32 = 32;

/// Where nodes are while the shutter is open.
pub(super) struct Exposure {
    /// From when to when it is open (s).
    pub shutter: [f64; 2],
    parents: Vec<Option<usize>>,
    /// Times (s), and the poses of the nodes above cameras.
    moments: Vec<(f64, BTreeMap<usize, Pose>)>,
}

impl Exposure {
    /// Looks at the animations between two times (s), if these differ. Notes that nodes with a mesh
    /// or a light move meanwhile.
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
        // What is odd about the animations was told when they were read for the scene itself.
        let mut unheard = SceneBuilder::new("", Location::default());
        let mut at = |seconds: f64, only: Option<&BTreeSet<usize>>| {
            animations::at(source, animated, seconds, only, &mut unheard)
        };
        let ends = [at(open, None)?, at(open + 0.5 * (close - open), None)?, at(close, None)?];
        let stands = |node: &usize| ends.iter().all(|poses| poses.get(node) == ends[0].get(node));
        let moving: BTreeSet<usize> = ends[0].keys().copied().filter(|node| !stands(node)).collect();
        let above = |node: usize| std::iter::successors(Some(node), |&node| parents[node]);
        let root = &source.root.nodes;
        for (node, json) in root.iter().enumerate() {
            let lights = json.extensions.as_ref().is_some_and(|e| e.khr_lights_punctual.is_some());
            if (json.mesh.is_some() || lights) && above(node).any(|node| moving.contains(&node)) {
                let message =
                    "nodes that move: where they are in the middle of the time that the shutter is open";
                builder.note(NoteKind::Approximated, message, source.at(format!("nodes[{node}]")));
            }
        }
        let cameras = (0..root.len()).filter(|&node| root[node].camera.is_some());
        let only: BTreeSet<usize> = cameras.flat_map(above).collect();
        let time = |k: u32| open + f64::from(k) / f64::from(STEPS) * (close - open);
        let moments = (0..=STEPS).map(|k| Ok((time(k), at(time(k), Some(&only))?)));
        let moments = moments.collect::<Result<_>>()?;
        Ok(Some(Self { shutter, parents, moments }))
    }

    /// Times (s) and the transforms of a node to the world.
    pub fn of(&self, source: &Source<'_>, node: usize) -> Vec<(f64, DAffine3)> {
        let to_world = |poses: &BTreeMap<usize, Pose>| {
            let above = std::iter::successors(Some(node), |&node| self.parents[node]);
            above.fold(DAffine3::IDENTITY, |below, node| {
                nodes::placed(&source.root.nodes[node], poses.get(&node)) * below
            })
        };
        self.moments.iter().map(|(seconds, poses)| (*seconds, to_world(poses))).collect()
    }
}
