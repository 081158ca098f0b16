//! Animations: poses of nodes at a time, and the weights of their morph targets.
//!
//! All animations of a file start at time zero and run once. If two animate the same property of a
//! node, the first one counts. Let `Δ` be the time between the keys `k` and `k + 1`, and `u` the
//! fraction of it that has passed. A property then has the value (glTF 2.0, appendix C)
//!
//! ```text
//! STEP          v_k
//! LINEAR        (1 − u) v_k + u v_{k+1}, rotations at constant speed by the shorter way
//! CUBICSPLINE   (2u³ − 3u² + 1) v_k + Δ (u³ − 2u² + u) b_k + (3u² − 2u³) v_{k+1} + Δ (u³ − u²) a_{k+1}
//! ```
//!
//! where `a` is the tangent into a key and `b` the tangent out of it. Interpolated rotations are
//! normalized to unit quaternions. Before the first key, a property has the value of that key, and
//! after the last key the value of the last. Weights have a number for each morph target at each
//! key (section 3.11).
//!
//! # Guarantee
//! If a file is loaded without a time, nothing of its animations is read except their first and
//! last times, as the file declares them. Keys that are read count toward the scene's geometry
//! budget each time that they are referred to, so that work is bounded by the bytes that may be
//! read.
//!
//! # Held to this by
//! The test modules `gltf_animations` and `gltf_shapes`.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DQuat, DVec3, DVec4};
use gltf::json::Index;
use gltf::json::accessor::Type;
use serde::Deserialize;

use super::features::met;
use super::morphs;
use super::nodes::unit_quaternion;
use super::source::Source;
use crate::error::{Error, Location, Result};
use crate::io::notes::shown;
use crate::math::motion::turned_between;
use crate::scene::{NoteKind, SceneBuilder};

/// Animated pose of a node at a time; absent values are those of the node itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Pose {
    pub translation: Option<DVec3>,
    pub rotation: Option<DQuat>,
    pub scale: Option<DVec3>,
}

/// Animated poses and weights at a time.
#[derive(Clone, Debug, Default)]
pub(super) struct Poses {
    /// Poses, by node.
    pub places: BTreeMap<usize, Pose>,
    /// Weights by node, one for each morph target.
    pub weights: BTreeMap<usize, Vec<f32>>,
}

/// Fields of an animation that are read.
#[derive(Deserialize)]
#[serde(default)]
#[derive(Default)]
struct Animation {
    channels: Vec<Channel>,
    samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
struct Channel {
    sampler: usize,
    target: Target,
}

#[derive(Deserialize)]
struct Target {
    node: Option<usize>,
    path: String,
}

#[derive(Deserialize)]
struct Sampler {
    input: u32,
    output: u32,
    #[serde(default)]
    interpolation: Interpolation,
}

#[derive(Clone, Copy, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "UPPERCASE")]
enum Interpolation {
    Step,
    #[default]
    Linear,
    CubicSpline,
}

/// Position of a time among the keys of a sampler.
#[derive(Clone, Copy)]
struct Moment {
    /// Number of keys of the sampler's input.
    keys: usize,
    /// Index of the key before the time, or of the first.
    before: usize,
    /// Index of the key after the time, the elapsed fraction of the interval between both keys, and
    /// the length of that interval (s); none before the first key and after the last.
    after: Option<(usize, f64, f64)>,
}

/// Adds the first and last times of the file's animations to the scene, where the file declares
/// them.
pub(super) fn add_time_span(
    source: &Source<'_>,
    animations: &[serde_json::Value],
    builder: &mut SceneBuilder,
) {
    for animation in animations {
        let Ok(animation) = Animation::deserialize(animation) else { continue };
        for sampler in &animation.samplers {
            let Some(input) = source.root.accessors.get(sampler.input as usize) else { continue };
            let number = |value: &Option<serde_json::Value>| {
                let value = value.as_ref()?;
                value.get(0).unwrap_or(value).as_f64()
            };
            if let (Some(first), Some(last)) = (number(&input.min), number(&input.max)) {
                builder.add_animated_seconds([first, last]);
            }
        }
    }
}

/// Animated poses and weights at a time (s), of all nodes or of the nodes `only`.
pub(super) fn at(
    source: &Source<'_>,
    animations: &[serde_json::Value],
    seconds: f64,
    only: Option<&BTreeSet<usize>>,
    builder: &mut SceneBuilder,
) -> Result<Poses> {
    let mut reading =
        Reading { source, seconds, only, builder, moments: BTreeMap::new(), poses: Poses::default() };
    for (i, animation) in animations.iter().enumerate() {
        let item = format!("animations[{i}]");
        let animation = Animation::deserialize(animation).map_err(|e| {
            let found = format!("an animation that cannot be read ({})", shown(&e.to_string()));
            Error::invalid(source.at(&item), found, "channels and samplers as of glTF 2.0")
        })?;
        for (k, channel) in animation.channels.iter().enumerate() {
            reading.channel(&animation, channel, &format!("{item}.channels[{k}]"))?;
        }
    }
    Ok(reading.poses)
}

struct Reading<'r, 'a> {
    source: &'r Source<'a>,
    seconds: f64,
    only: Option<&'r BTreeSet<usize>>,
    builder: &'r mut SceneBuilder,
    /// Moments by accessor of times; none for accessors without keys.
    moments: BTreeMap<u32, Option<Moment>>,
    poses: Poses,
}

impl Reading<'_, '_> {
    fn channel(&mut self, animation: &Animation, channel: &Channel, item: &str) -> Result<()> {
        let at = |field: &str| self.source.at(format!("{item}{field}"));
        let Some(sampler) = animation.samplers.get(channel.sampler) else {
            let expected = format!("an index below {}", animation.samplers.len());
            return Err(Error::invalid(at(".sampler"), format!("sampler {}", channel.sampler), expected));
        };
        let path = channel.target.path.as_str();
        met("animation", path, at(".target.path"), self.builder)?;
        // The specification leaves targets without a node to extensions.
        let is_read = matches!(path, "translation" | "rotation" | "scale" | "weights");
        let Some(node) = channel.target.node.filter(|_| is_read) else { return Ok(()) };
        let nodes = &self.source.root.nodes;
        let Some(target) = nodes.get(node) else {
            let expected = format!("an index below {}", nodes.len());
            return Err(Error::invalid(at(".target.node"), format!("node {node}"), expected));
        };
        if self.only.is_some_and(|only| !only.contains(&node)) {
            return Ok(());
        }
        if path != "weights" && target.matrix.is_some() {
            let message = "animations of nodes with a matrix: left out";
            self.builder.note(NoteKind::Repaired, message, at(".target.node"));
            return Ok(());
        }
        let targets = target.mesh.map_or(0, |mesh| morphs::targets(&self.source.root.meshes[mesh.value()]));
        if path == "weights" && targets == 0 {
            let message = "animated weights of nodes without morph targets: left out";
            self.builder.note(NoteKind::Repaired, message, at(".target.node"));
            return Ok(());
        }
        let pose = self.poses.places.get(&node).copied().unwrap_or_default();
        let is_taken = match path {
            "translation" => pose.translation.is_some(),
            "rotation" => pose.rotation.is_some(),
            "scale" => pose.scale.is_some(),
            _ => self.poses.weights.contains_key(&node),
        };
        if is_taken {
            let message = "animations of what another one moves already: left out";
            self.builder.note(NoteKind::Ignored, message, at(".target"));
            return Ok(());
        }
        let Some(moment) = self.moment(sampler.input, at(".sampler"))? else { return Ok(()) };
        let place = at(".sampler");
        let pose = match path {
            "weights" => {
                let weights = self.weights(sampler, moment, targets, &place)?;
                self.poses.weights.insert(node, weights);
                return Ok(());
            }
            "rotation" => {
                let rotation = self.rotation(sampler, moment, &place)?;
                Pose { rotation: Some(rotation), ..pose }
            }
            _ => {
                let [x, y, z] = self.value::<3>(sampler, moment, Type::Vec3, &place)?;
                let vector = Some(DVec3::new(x, y, z));
                match path {
                    "translation" => Pose { translation: vector, ..pose },
                    _ => Pose { scale: vector, ..pose },
                }
            }
        };
        self.poses.places.insert(node, pose);
        Ok(())
    }

    /// Position of the time among the times of an accessor. Each accessor is read once.
    fn moment(&mut self, input: u32, at: Location) -> Result<Option<Moment>> {
        if let Some(&known) = self.moments.get(&input) {
            return Ok(known);
        }
        let times = self.vectors::<1>(input, Type::Scalar, None, &at)?;
        let times: Vec<f32> = times.into_iter().flatten().collect();
        if let Some(wrong) = times.iter().find(|time| !time.is_finite()) {
            let found = format!("accessors[{input}] with the time {wrong}");
            return Err(Error::invalid(at, found, "finite times"));
        }
        let mut order: Vec<usize> = (0..times.len()).collect();
        if !times.is_sorted_by(|a, b| a < b) {
            let message = "animations whose times do not rise: their keys are sorted";
            self.builder.note(NoteKind::Repaired, message, at.clone());
            order.sort_by(|&a, &b| times[a].total_cmp(&times[b]));
        }
        let moment = match (order.first(), order.last()) {
            (Some(&first), Some(&last)) => {
                let time = |key: usize| f64::from(times[key]);
                self.builder.add_animated_seconds([time(first), time(last)]);
                let after = order.partition_point(|&key| time(key) <= self.seconds);
                let before = order[after.saturating_sub(1)];
                let after = order.get(after).filter(|_| after > 0).map(|&after| {
                    let between = time(after) - time(before);
                    (after, (self.seconds - time(before)) / between, between)
                });
                Some(Moment { keys: times.len(), before, after })
            }
            _ => {
                let message = "animations without keys: left out";
                self.builder.note(NoteKind::Repaired, message, at);
                None
            }
        };
        self.moments.insert(input, moment);
        Ok(moment)
    }

    /// Elements of an accessor. If `count` is given, the accessor must have this number of
    /// elements.
    fn vectors<const N: usize>(
        &self,
        index: u32,
        expected: Type,
        count: Option<usize>,
        at: &Location,
    ) -> Result<Vec<[f32; N]>> {
        let accessors = self.source.root.accessors.len();
        if index as usize >= accessors {
            let expected = format!("an index below {accessors}");
            return Err(Error::invalid(at.clone(), format!("accessor {index}"), expected));
        }
        let accessor = self.source.accessor(Index::new(index), expected, at.clone())?;
        let found = accessor.count();
        if let Some(count) = count.filter(|&count| count != found) {
            let found = format!("accessors[{index}] of {found} elements");
            return Err(Error::invalid(at.clone(), found, format!("{count}, as the keys need")));
        }
        self.source.geometry_budget.take((found as u64).saturating_mul(size_of::<[f32; N]>() as u64), at)?;
        accessor.vectors(0..found)
    }

    /// Values of a sampler at the two keys around the time, with the tangents out of the first key
    /// and into the second.
    fn values<const N: usize>(
        &self,
        sampler: &Sampler,
        moment: Moment,
        expected: Type,
        at: &Location,
    ) -> Result<Values<N>> {
        let count = moment.keys.saturating_mul(sampler.each());
        let all = self.vectors::<N>(sampler.output, expected, Some(count), at)?;
        sampler.values(moment, |element| all[element], at)
    }

    fn value<const N: usize>(
        &self,
        sampler: &Sampler,
        moment: Moment,
        expected: Type,
        at: &Location,
    ) -> Result<[f64; N]> {
        Ok(self.values::<N>(sampler, moment, expected, at)?.between(sampler, moment))
    }

    /// Weights of `targets` morph targets. The sampler's output has `targets` numbers in place of
    /// each value or tangent.
    fn weights(&self, sampler: &Sampler, moment: Moment, targets: usize, at: &Location) -> Result<Vec<f32>> {
        let count = moment.keys.saturating_mul(sampler.each()).saturating_mul(targets);
        let all = self.vectors::<1>(sampler.output, Type::Scalar, Some(count), at)?;
        let weight = |target: usize| {
            let values = sampler.values(moment, |element| all[element * targets + target], at)?;
            let [weight] = values.between(sampler, moment);
            Ok(weight as f32)
        };
        (0..targets).map(weight).collect()
    }

    fn rotation(&mut self, sampler: &Sampler, moment: Moment, at: &Location) -> Result<DQuat> {
        let unit = |xyzw: [f64; 4]| unit_quaternion(DQuat::from_vec4(DVec4::from_array(xyzw)));
        let rotation = match (sampler.interpolation, moment.after) {
            (Interpolation::Linear, Some((_, u, _))) => {
                let [before, after] = self.values::<4>(sampler, moment, Type::Vec4, at)?.ends.map(unit);
                before.zip(after).map(|(before, after)| turned_between(before, after, u))
            }
            _ => unit(self.value::<4>(sampler, moment, Type::Vec4, at)?),
        };
        Ok(rotation.unwrap_or_else(|| {
            let message = "animated rotations that are no quaternion: left out";
            self.builder.note(NoteKind::Repaired, message, at.clone());
            DQuat::IDENTITY
        }))
    }
}

/// Values of a sampler at two keys.
struct Values<const N: usize> {
    ends: [[f64; N]; 2],
    /// Tangent out of the first key, and tangent into the second.
    tangents: [[f64; N]; 2],
}

impl Sampler {
    /// Number of elements of the output for each key: 1 for the value alone, 3 for the value
    /// between its two tangents.
    fn each(&self) -> usize {
        if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 }
    }

    /// Values and tangents at the two keys around a moment. All must be finite.
    fn values<const N: usize>(
        &self,
        moment: Moment,
        element: impl Fn(usize) -> [f32; N],
        at: &Location,
    ) -> Result<Values<N>> {
        let value = |key: usize, which: usize| -> Result<[f64; N]> {
            let value = element(self.each() * key + which);
            if value.iter().all(|x| x.is_finite()) {
                return Ok(value.map(f64::from));
            }
            let found = format!("accessors[{}] with the value {value:?}", self.output);
            Err(Error::invalid(at.clone(), found, "finite numbers"))
        };
        let last = moment.after.map_or(moment.before, |(after, ..)| after);
        let is_spline = self.interpolation == Interpolation::CubicSpline;
        let tangents = if is_spline { [value(moment.before, 2)?, value(last, 0)?] } else { [[0.0; N]; 2] };
        let own = usize::from(is_spline);
        Ok(Values { ends: [value(moment.before, own)?, value(last, own)?], tangents })
    }
}

impl<const N: usize> Values<N> {
    /// The value at the moment.
    fn between(&self, sampler: &Sampler, moment: Moment) -> [f64; N] {
        match (sampler.interpolation, moment.after) {
            (Interpolation::Step, _) | (_, None) => self.ends[0],
            (Interpolation::Linear, Some((_, u, _))) => self.combined([1.0 - u, u, 0.0, 0.0]),
            (Interpolation::CubicSpline, Some((_, u, between))) => self.spline(u, between),
        }
    }

    /// The sum of ends and tangents with these weights.
    fn combined(&self, weights: [f64; 4]) -> [f64; N] {
        let [w0, w1, w2, w3] = weights;
        let ([a, b], [c, d]) = (self.ends, self.tangents);
        std::array::from_fn(|i| w0 * a[i] + w1 * b[i] + w2 * c[i] + w3 * d[i])
    }

    fn spline(&self, u: f64, between: f64) -> [f64; N] {
        let (u2, u3) = (u * u, u * u * u);
        let end = 3.0 * u2 - 2.0 * u3;
        self.combined([1.0 - end, end, between * (u3 - 2.0 * u2 + u), between * (u3 - u2)])
    }
}
