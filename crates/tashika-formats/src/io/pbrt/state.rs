//! The graphics state: the current transform and attributes, saved states, and named coordinate
//! systems.
//!
//! pbrt keeps two transforms, for the two times that `TransformTimes` names (0 and 1 s);
//! `ActiveTransform` selects the ones that directives change. Without a requested time, the scene
//! is loaded with the first transform. At a requested time, [`Track`] interpolates between the two.
//!
//! `AttributeBegin`, `TransformBegin` and `ObjectBegin` save the state, their counterparts restore
//! it. As in pbrt-v3 they need not be nested by kind: each end restores the state that was saved
//! last. An end without a beginning is ignored. Both cases are noted.
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
/// copy of these parameters.
pub(super) const MAX_DEFAULTS: usize = 1 << 15;

/// State that directives read and change.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// The current transform, at the first and the second time.
    transforms: [DMat4; 2],
    /// Flags of the first and the second transform, true if directives change it.
    active: [bool; 2],
    /// `ReverseOrientation`.
    pub(super) reverse: bool,
    /// Material of the shapes that follow.
    pub(super) material: DefinitionId,
    /// `MediumInterface`.
    pub(super) media: Sides,
    /// Light of the shapes that follow.
    pub(super) area_light: Option<AreaLight>,
    /// Colour space of `rgb` values, by `ColorSpace`.
    pub(super) primaries: Primaries,
    /// Default parameters by `Attribute`, for shapes, lights, materials and textures.
    pub(super) defaults: BTreeMap<String, Vec<Parameter>>,
}

/// Directive that saved a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SavedBy {
    /// `AttributeBegin`
    Attribute,
    /// `TransformBegin`
    Transform,
    /// `ObjectBegin`
    Object,
}

/// Current state, saved states and named coordinate systems.
#[derive(Debug)]
pub(super) struct States {
    /// State that the next directive sees.
    pub(super) current: State,
    saved: Vec<(SavedBy, State)>,
    coordinate_systems: BTreeMap<String, [DMat4; 2]>,
    /// `TransformTimes` (s).
    times: [f64; 2],
    /// Time at which things are loaded (s), if one is requested.
    at: Option<f64>,
}

impl States {
    /// Identity transforms, and `material` as the current one; `at` is the requested time (s).
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

    /// Saves the current state; returns false if too many are saved.
    pub(super) fn save(&mut self, by: SavedBy) -> bool {
        self.saved.push((by, self.current.clone()));
        self.saved.len() <= MAX_SAVED
    }

    /// Restores the state that was saved last; returns the directive that saved it, if there is
    /// one.
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

    /// Number of saved states.
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

    /// Applies `f` to the index and the matrix of each current transform that is active.
    fn change(&mut self, f: impl Fn(usize, DMat4) -> DMat4) {
        let current = &mut self.current;
        for (i, transform) in current.transforms.iter_mut().enumerate().filter(|(i, _)| current.active[*i]) {
            *transform = f(i, *transform);
        }
    }

    /// Executes `ActiveTransform`; returns false if `which` is none of the three words.
    pub(super) fn activate(&mut self, which: &[u8]) -> bool {
        self.current.active = match which {
            b"StartTime" => [true, false],
            b"EndTime" => [false, true],
            b"All" => [true, true],
            _ => return false,
        };
        true
    }

    /// Executes `TransformTimes`; changes nothing and returns false if the second time is not after
    /// the first.
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

    /// Current transform at the requested time; none if it is not affine, or if it is interpolated
    /// between two transforms of which one cannot be inverted.
    pub(super) fn affine(&self) -> Option<DAffine3> {
        self.between(|m| Some(*m))
    }

    /// Inverse of the current transform. If it moves, the inverses are interpolated, as for
    /// cameras.
    pub(super) fn inverse(&self) -> Option<DAffine3> {
        self.between(|m| Some(DMat4::from(inverted(transform::affine(m)?)?)))
    }

    /// [`Self::inverse`] as a function of time, if the transform moves and both ends can be
    /// inverted.
    pub(super) fn inverses(&self) -> Option<Track> {
        let [from, to] = self.moves()?;
        let [first, second] = &self.current.transforms;
        let inverse = |m: &DMat4| inverted(transform::affine(m)?);
        Track::new([(from, inverse(first)?), (to, inverse(second)?)])
    }

    /// Current transform as a function of time, if it moves and both ends can be inverted.
    pub(super) fn track(&self) -> Option<Track> {
        let [from, to] = self.moves()?;
        let [first, second] = &self.current.transforms;
        Track::new([(from, transform::affine(first)?), (to, transform::affine(second)?)])
    }

    /// Applies `make` to both current transforms and interpolates the results at the requested
    /// time.
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

    /// Gives a name to the current transform.
    pub(super) fn name_system(&mut self, name: &str) {
        self.coordinate_systems.insert(name.to_owned(), self.current.transforms);
    }

    /// Gives a name to the inverse of the current transform.
    pub(super) fn name_inverse(&mut self, name: &str) {
        let inverse = |m: &DMat4| transform::affine(m).and_then(inverted).map(DMat4::from);
        let [first, second] = self.current.transforms.each_ref().map(inverse);
        if let Some(first) = first {
            self.coordinate_systems.insert(name.to_owned(), [first, second.unwrap_or(first)]);
        }
    }

    /// Replaces the current transform by the named one; returns false if there is none.
    pub(super) fn replace_by_system(&mut self, name: &str) -> bool {
        let named = self.coordinate_systems.get(name).copied();
        if let Some(named) = named {
            self.change(|i, _| named[i]);
        }
        named.is_some()
    }

    /// Executes `WorldBegin`: resets the transforms to the identity, without motion, and names it
    /// `world`.
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
