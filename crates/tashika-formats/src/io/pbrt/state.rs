//! The graphics state: the current transform and attributes, what is saved of them, and named
//! coordinate systems.
//!
//! pbrt keeps two transforms, for the two times that `TransformTimes` names (0 and 1 s);
//! `ActiveTransform` says which ones directives change. A picture without a time is that of the
//! first; at a time the transform is between them as [`Track`] has it.
//!
//! `AttributeBegin`, `TransformBegin` and `ObjectBegin` save, their counterparts restore. As in
//! pbrt-v3 they need not be nested by kind: each end takes back what was saved last. Ends without
//! beginning are passed over. Both are noted.
//!
//! Tested by `suite::pbrt::transforms_*`, `suite::pbrt::attributes_*`.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat4};

use super::lights::AreaLight;
use super::materials::DefinitionId;
use super::media::Sides;
use super::parameters::Parameter;
use super::transform;
use crate::color::Primaries;
use crate::math::motion::Track;

/// Deepest nesting of saved states.
pub(super) const MAX_SAVED: usize = 10_000;

/// Most bytes of the parameters given by `Attribute`; chosen. Each saved state and each shape has a
/// copy of them.
pub(super) const MAX_DEFAULTS: usize = 1 << 15;

/// What directives see and change.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// The current transform, at the first and the second time.
    transforms: [DMat4; 2],
    /// Whether directives change the first, and the second.
    active: [bool; 2],
    /// `ReverseOrientation`.
    pub(super) reverse: bool,
    /// Current material.
    pub(super) material: DefinitionId,
    /// `MediumInterface`.
    pub(super) media: Sides,
    /// Current light of shapes.
    pub(super) area_light: Option<AreaLight>,
    /// `ColorSpace`: of `rgb` parameters.
    pub(super) primaries: Primaries,
    /// Defaults by `Attribute`, for shapes, lights, materials and textures.
    pub(super) defaults: BTreeMap<String, Vec<Parameter>>,
}

/// What saved a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SavedBy {
    /// `AttributeBegin`
    Attribute,
    /// `TransformBegin`
    Transform,
    /// `ObjectBegin`
    Object,
}

/// The states.
#[derive(Debug)]
pub(super) struct States {
    /// The current one.
    pub(super) current: State,
    saved: Vec<(SavedBy, State)>,
    coordinate_systems: BTreeMap<String, [DMat4; 2]>,
    /// `TransformTimes` (s).
    times: [f64; 2],
    /// When things are to be as they are (s), if that is not the first of the times.
    at: Option<f64>,
}

impl States {
    /// Nothing transformed, `material` current; `at` is the time that is asked for (s).
    pub(super) fn new(material: DefinitionId, at: Option<f64>) -> Self {
        let current = State {
            transforms: [DMat4::IDENTITY; 2],
            active: [true; 2],
            reverse: false,
            material,
            media: Sides::default(),
            area_light: None,
            primaries: Primaries::REC709,
            defaults: BTreeMap::new(),
        };
        Self { current, saved: Vec::new(), coordinate_systems: BTreeMap::new(), times: [0.0, 1.0], at }
    }

    /// Saves the current state; false if there are too many.
    pub(super) fn save(&mut self, by: SavedBy) -> bool {
        self.saved.push((by, self.current.clone()));
        self.saved.len() <= MAX_SAVED
    }

    /// Takes back what was saved last; what saved it, if anything did.
    pub(super) fn restore(&mut self, by: SavedBy) -> Option<SavedBy> {
        let (saved_by, state) = self.saved.pop()?;
        if by == SavedBy::Transform && saved_by == SavedBy::Transform {
            self.current.transforms = state.transforms;
            self.current.active = state.active;
        } else {
            self.current = state;
        }
        Some(saved_by)
    }

    /// How many states are saved.
    pub(super) fn depth(&self) -> usize {
        self.saved.len()
    }

    /// Multiplies the current transform by `m` from the right.
    pub(super) fn concatenate(&mut self, m: DMat4) {
        self.change(|_, current| current * m);
    }

    /// Replaces the current transform.
    pub(super) fn replace(&mut self, m: DMat4) {
        self.change(|_, _| m);
    }

    /// Replaces those of the two current transforms that are active.
    fn change(&mut self, f: impl Fn(usize, DMat4) -> DMat4) {
        let current = &mut self.current;
        for (i, transform) in current.transforms.iter_mut().enumerate().filter(|(i, _)| current.active[*i]) {
            *transform = f(i, *transform);
        }
    }

    /// `ActiveTransform`; false if `which` is none of the three.
    pub(super) fn activate(&mut self, which: &[u8]) -> bool {
        self.current.active = match which {
            b"StartTime" => [true, false],
            b"EndTime" => [false, true],
            b"All" => [true, true],
            _ => return false,
        };
        true
    }

    /// `TransformTimes`; false, and nothing is changed, if the second is not after the first.
    pub(super) fn set_times(&mut self, times: [f64; 2]) -> bool {
        let rise = times[0] < times[1];
        if rise {
            self.times = times;
        }
        rise
    }

    /// The two times of the current transforms (s), if these differ.
    pub(super) fn moves(&self) -> Option<[f64; 2]> {
        let [first, second] = self.current.transforms;
        (first != second).then_some(self.times)
    }

    /// The current transform, at the time that is asked for; nothing if it is no affine one, or is
    /// between two of which one cannot be inverted.
    pub(super) fn affine(&self) -> Option<DAffine3> {
        self.between(|m| Some(*m))
    }

    /// The inverse of the current transform; for things that move between the inverses, as cameras
    /// do.
    pub(super) fn inverse(&self) -> Option<DAffine3> {
        self.between(|m| Some(DMat4::from(inverted(transform::affine(m)?)?)))
    }

    /// What [`Self::inverse`] is at all times, if it moves and both can be inverted.
    pub(super) fn inverses(&self) -> Option<Track> {
        let [from, to] = self.moves()?;
        let [first, second] = &self.current.transforms;
        let inverse = |m: &DMat4| inverted(transform::affine(m)?);
        Track::new([(from, inverse(first)?), (to, inverse(second)?)])
    }

    /// The current transform at all times, if it moves and both can be inverted.
    pub(super) fn track(&self) -> Option<Track> {
        let [from, to] = self.moves()?;
        let [first, second] = &self.current.transforms;
        Track::new([(from, transform::affine(first)?), (to, transform::affine(second)?)])
    }

    /// What is made of the current transform, at the time that is asked for.
    fn between(&self, make: impl Fn(&DMat4) -> Option<DMat4>) -> Option<DAffine3> {
        let [first, second] = &self.current.transforms;
        let affine = |m: &DMat4| transform::affine(&make(m)?);
        match (self.at, self.moves()) {
            (Some(at), Some([from, to])) if at > from => {
                Some(Track::new([(from, affine(first)?), (to, affine(second)?)])?.at(at))
            }
            _ => affine(first),
        }
    }

    /// Names the current transform.
    pub(super) fn name_system(&mut self, name: &str) {
        self.coordinate_systems.insert(name.to_owned(), self.current.transforms);
    }

    /// Names the inverse of the current transform.
    pub(super) fn name_inverse(&mut self, name: &str) {
        let inverse = |m: &DMat4| transform::affine(m).and_then(inverted).map(DMat4::from);
        let [first, second] = self.current.transforms.each_ref().map(inverse);
        if let Some(first) = first {
            self.coordinate_systems.insert(name.to_owned(), [first, second.unwrap_or(first)]);
        }
    }

    /// Takes the transform of that name for the current one; false if there is none.
    pub(super) fn replace_by_system(&mut self, name: &str) -> bool {
        let named = self.coordinate_systems.get(name).copied();
        if let Some(named) = named {
            self.change(|i, _| named[i]);
        }
        named.is_some()
    }

    /// `WorldBegin`: the identity, and no motion.
    pub(super) fn begin_world(&mut self) {
        self.current.transforms = [DMat4::IDENTITY; 2];
        self.current.active = [true; 2];
        self.name_system("world");
    }
}

fn inverted(map: DAffine3) -> Option<DAffine3> {
    let inverse = map.inverse();
    inverse.is_finite().then_some(inverse)
}
