//! The graphics state: the current transform and attributes, what is saved of them, and named
//! coordinate systems.
//!
//! pbrt keeps two transforms, for the start and the end of the exposure; `ActiveTransform` says
//! which ones directives change. This picture is that of the start.
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
use super::parameters::Parameter;
use super::transform;
use crate::color::Primaries;

/// Deepest nesting of saved states.
pub(super) const MAX_SAVED: usize = 10_000;

/// What directives see and change.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// The current transform, at the start of the exposure.
    transform: DMat4,
    /// Whether directives change the transform of the start, and of the end.
    active: [bool; 2],
    /// Whether the two transforms have been told apart.
    pub(super) moves: bool,
    /// `ReverseOrientation`.
    pub(super) reverse: bool,
    /// Current material.
    pub(super) material: DefinitionId,
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
    coordinate_systems: BTreeMap<String, DMat4>,
}

impl States {
    /// Nothing transformed, `material` current.
    pub(super) fn new(material: DefinitionId) -> Self {
        let current = State {
            transform: DMat4::IDENTITY,
            active: [true; 2],
            moves: false,
            reverse: false,
            material,
            area_light: None,
            primaries: Primaries::REC709,
            defaults: BTreeMap::new(),
        };
        Self { current, saved: Vec::new(), coordinate_systems: BTreeMap::new() }
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
            self.current.transform = state.transform;
            self.current.active = state.active;
            self.current.moves = state.moves;
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
        self.change(|current| current * m);
    }

    /// Replaces the current transform.
    pub(super) fn replace(&mut self, m: DMat4) {
        self.change(|_| m);
    }

    fn change(&mut self, f: impl Fn(DMat4) -> DMat4) {
        let current = &mut self.current;
        if current.active[0] {
            current.transform = f(current.transform);
        }
        current.moves |= current.active[0] != current.active[1];
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

    /// The current transform; nothing if it is no affine one.
    pub(super) fn affine(&self) -> Option<DAffine3> {
        transform::affine(&self.current.transform)
    }

    /// Names the current transform.
    pub(super) fn name_system(&mut self, name: &str) {
        self.coordinate_systems.insert(name.to_owned(), self.current.transform);
    }

    /// Names a transform.
    pub(super) fn name_transform(&mut self, name: &str, m: DMat4) {
        self.coordinate_systems.insert(name.to_owned(), m);
    }

    /// The transform of that name.
    pub(super) fn system(&self, name: &str) -> Option<DMat4> {
        self.coordinate_systems.get(name).copied()
    }

    /// `WorldBegin`: the identity, and no motion.
    pub(super) fn begin_world(&mut self) {
        self.current.transform = DMat4::IDENTITY;
        self.current.active = [true; 2];
        self.current.moves = false;
        self.name_system("world");
    }
}
