//! Origin of the coordinates of a scene.
//!
//! Files may place a room millions of metres from zero, where numbers of single precision are half
//! a metre apart. A [`SceneBuilder`] therefore accepts positions in double precision. When the
//! scene is built, they are made relative to an origin near the visible objects: coordinates of a
//! [`Scene`] are those of its file minus [`Scene::origin`].
//!
//! Rounding moves an object of half size `s` at a distance `d` from the origin by a share `ρ ε` of
//! its size, with `ρ = 1 + d/s`. The loss of an origin is the mean of `ρ` over all objects,
//! weighted by their apparent sizes:
//!
//! ```text
//! w = Σ_cameras min(1, s / distance)²          loss(origin) = Σ w ρ / Σ w
//! ```
//!
//! The candidates are zero, the positions of the first cameras, the object with the largest
//! apparent size, and the middle of all objects. Zero is used unless another origin lowers the loss
//! by a factor of [`MIN_LOSS_RATIO`], so that the coordinates of scenes near zero do not change.
//!
//! # Guarantee
//! Coordinates relative to the origin are differences in double precision, rounded once. With an
//! origin of zero, no coordinate is changed.
//!
//! # Held to this by
//! The tests below; the suite's `far_from_zero`.

use std::sync::Arc;

use glam::{Affine3A, DAffine3, DVec3, Vec3};

use super::motion::inverse;
use super::{Instance, MeshData, MeshShape, NoteKind, Scene, SceneBuilder};
use crate::math::{local_origin, origin_near, spacing_at};

/// Factor by which an origin other than zero must lower the loss. Chosen by a measurement with the
/// origin at zero: a closed room whose distance from zero is 30 times its size is 0.03 % too
/// bright.
const MIN_LOSS_RATIO: f64 = 32.0;

/// Largest number of cameras in the loss.
const CAMERAS: usize = 8;

/// Distance from the origin, in half sizes of the object, from which a note reports the object:
/// neighbouring numbers there are more than a thousandth of the half size apart. Chosen.
const NOTED: f64 = 16384.0;

/// Pose of an object in the world: an affine map of either precision.
pub trait Placement {
    /// Returns the map in double precision.
    fn in_double(&self) -> DAffine3;
}

impl Placement for DAffine3 {
    #[inline]
    fn in_double(&self) -> DAffine3 {
        *self
    }
}

impl Placement for Affine3A {
    #[inline]
    fn in_double(&self) -> DAffine3 {
        self.as_daffine3()
    }
}

/// Positions and poses of a scene in the coordinates of the file, in double precision.
#[derive(Debug, Default)]
pub(super) struct Places {
    /// Origin of each mesh's positions, in object space (m).
    pub meshes: Vec<DVec3>,
    /// Object-to-world map of each instance, without the mesh's own origin.
    pub instances: Vec<DAffine3>,
    /// Position of each emitter (m); without meaning if the emitter has none.
    pub emitters: Vec<DVec3>,
    /// Camera-to-world map of each static camera.
    pub cameras: Vec<DAffine3>,
}

/// Box in the coordinates of the file: its centre and its largest half size (m).
#[derive(Clone, Copy)]
struct Extent {
    center: DVec3,
    half: f64,
}

impl Extent {
    /// Returns `ρ` for an origin: 1 plus the largest difference of coordinates from it, in half
    /// sizes.
    fn distance(&self, place: DVec3) -> f64 {
        1.0 + (self.center - place).abs().max_element() / self.half
    }

    /// Returns the squared ratio of the half size to the distance from a position, at most 1:
    /// roughly the share of the view that the object covers.
    fn seen_from(&self, place: DVec3) -> f64 {
        let share = (self.half / (self.center - place).length()).min(1.0);
        share * share
    }
}

impl SceneBuilder {
    /// Chooses the origin, makes all positions relative to it, and rounds them.
    pub(super) fn settle(&mut self) {
        let origin = self.choose_origin();
        self.note_lost(origin);
        let places = std::mem::take(&mut self.places);
        let scene = &mut self.scene;
        scene.origin = origin;
        for (instance, to_world) in scene.instances.iter_mut().zip(&places.instances) {
            let local = places.meshes[instance.mesh.index()];
            if origin == DVec3::ZERO && local == DVec3::ZERO {
                continue;
            }
            match instance.motion {
                None => {
                    instance.to_world = placed(to_world, local, origin).as_affine3a();
                    instance.to_object = inverse(&instance.to_world);
                }
                Some(motion) => {
                    let motion = &mut scene.motions[motion as usize];
                    motion.track = motion.track.clone().about(local).relative_to(origin);
                    instance.to_world = motion.pose(0.5);
                    instance.to_object = inverse(&instance.to_world);
                }
            }
        }
        if origin == DVec3::ZERO {
            return;
        }
        for (camera, to_world) in scene.cameras.iter_mut().zip(&places.cameras) {
            camera.to_world = match &mut camera.motion {
                None => placed(to_world, DVec3::ZERO, origin).as_affine3a(),
                Some(motion) => {
                    motion.track = motion.track.clone().relative_to(origin);
                    motion.pose(0.5)
                }
            };
        }
        for (emitter, place) in scene.emitters.iter_mut().zip(&places.emitters) {
            emitter.move_to((*place - origin).as_vec3());
        }
        for variation in scene.media.iter_mut().filter_map(|medium| medium.variation.as_mut()) {
            Arc::make_mut(variation).move_by(origin);
        }
    }

    fn choose_origin(&self) -> DVec3 {
        let mut cameras: Vec<DVec3> =
            self.places.cameras.iter().take(CAMERAS).map(|camera| camera.translation).collect();
        cameras.retain(|place| place.is_finite());
        let weight = |extent: &Extent| {
            let seen: f64 = cameras.iter().map(|&camera| extent.seen_from(camera)).sum();
            if cameras.is_empty() { 1.0 } else { seen }
        };
        let loss = |origin: DVec3| {
            let (mut lost, mut all) = (0.0, 0.0);
            for extent in self.extents() {
                let weight = weight(&extent);
                lost += weight * extent.distance(origin);
                all += weight;
            }
            if all > 0.0 { lost / all } else { 1.0 }
        };
        let at_zero = loss(DVec3::ZERO);
        // The loss is at least 1.
        if at_zero <= MIN_LOSS_RATIO || at_zero.is_nan() {
            return DVec3::ZERO;
        }
        let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut largest: Option<(f64, Extent)> = None;
        for extent in self.extents() {
            (lo, hi) = (lo.min(extent.center - extent.half), hi.max(extent.center + extent.half));
            let weight = weight(&extent);
            if largest.is_none_or(|(most, other)| (weight, -extent.half) > (most, -other.half)) {
                largest = Some((weight, extent));
            }
        }
        let Some((_, largest)) = largest else { return DVec3::ZERO };
        let candidates = cameras.iter().copied().chain([largest.center, 0.5 * (lo + hi)]);
        let mut best = (at_zero / MIN_LOSS_RATIO, DVec3::ZERO);
        for candidate in candidates.map(|place| origin_near(place, largest.half)) {
            let lost = loss(candidate);
            if lost < best.0 {
                best = (lost, candidate);
            }
        }
        best.1
    }

    /// Notes objects that are far from the origin.
    fn note_lost(&mut self, origin: DVec3) {
        let (mut count, mut furthest) = (0, 0.0_f64);
        for extent in self.extents().filter(|extent| extent.distance(origin) > NOTED) {
            count += 1;
            furthest = furthest.max((extent.center - origin).abs().max_element());
        }
        if count == 0 {
            return;
        }
        let about = if origin == DVec3::ZERO { "zero".to_owned() } else { format!("{origin}") };
        let message = format!(
            "objects so far from {about} that places there are rounded to {} m or less, more than a thousandth \
             of their half size: light in them may be wrong by as much as their distance is large",
            spacing_at(furthest)
        );
        let at = self.origin.clone();
        self.scene.notes.push_many(NoteKind::Approximated, message, at, count);
    }

    /// Returns the boxes of all instances whose box is not a point. Moving instances are taken in
    /// the middle of their motion.
    fn extents(&self) -> impl Iterator<Item = Extent> {
        self.scene
            .instances
            .iter()
            .zip(&self.places.instances)
            .filter_map(|(instance, to_world)| self.extent(instance, to_world))
    }

    fn extent(&self, instance: &Instance, to_world: &DAffine3) -> Option<Extent> {
        let bounds = self.scene.meshes[instance.mesh.index()].bounds();
        if bounds.is_empty() {
            return None;
        }
        let center = bounds.center().as_dvec3() + self.places.meshes[instance.mesh.index()];
        let half = (0.5 * bounds.size()).as_dvec3();
        let [x, y, z] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis, to_world.matrix3.z_axis];
        let half = (x.abs() * half.x + y.abs() * half.y + z.abs() * half.z).max_element();
        let extent = Extent { center: to_world.transform_point3(center), half };
        (half > 0.0 && extent.center.is_finite() && half.is_finite()).then_some(extent)
    }
}

/// Returns `T(−origin) · to_world · T(local)`.
fn placed(to_world: &DAffine3, local: DVec3, origin: DVec3) -> DAffine3 {
    DAffine3 { translation: to_world.transform_point3(local) - origin, ..*to_world }
}

impl Scene {
    /// Returns the origin of the scene's coordinates, in the coordinates of the file (m): zero for
    /// scenes near zero.
    #[inline]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Converts a position of the scene to the coordinates of the file (m).
    #[inline]
    pub fn place_in_file(&self, place: Vec3) -> DVec3 {
        place.as_dvec3() + self.origin
    }

    /// Converts a position of the file to the coordinates of the scene (m).
    #[inline]
    pub fn place_in_scene(&self, place: DVec3) -> Vec3 {
        (place - self.origin).as_vec3()
    }

    /// Returns the lowest and highest corner of [`Self::bounds`] in the coordinates of the file
    /// (m).
    pub fn bounds_in_file(&self) -> [DVec3; 2] {
        [self.bounds.lo, self.bounds.hi].map(|corner| self.place_in_file(corner))
    }
}

impl SceneBuilder {
    /// If the positions of a mesh are far from zero, makes them, and those of its second shape,
    /// relative to an origin near them. The positions are given in single precision: a note is
    /// added if neighbouring numbers there are far apart compared to the size of the mesh.
    pub(super) fn localize(&mut self, data: &mut MeshData, other: Option<&mut MeshShape>) {
        if data.origin != DVec3::ZERO {
            return;
        }
        let shapes = || data.positions.iter().chain(other.iter().flat_map(|shape| &shape.positions));
        let origin = local_origin(shapes().map(|place| place.as_dvec3()));
        if origin == DVec3::ZERO {
            return;
        }
        let from_origin = |place: &mut Vec3| *place = (place.as_dvec3() - origin).as_vec3();
        data.positions.iter_mut().for_each(from_origin);
        if let Some(shape) = other {
            shape.positions.iter_mut().for_each(from_origin);
        }
        data.origin = origin;
        let half = data.positions.iter().fold(0.0_f32, |half, place| half.max(place.abs().max_element()));
        let far = origin.abs().max_element();
        if far > NOTED * f64::from(half) {
            let message = format!(
                "positions of single precision far from zero: they are {} m apart in a mesh of half size {half} m",
                spacing_at(far)
            );
            let at = self.origin.clone().item(format!("mesh {}", data.name));
            self.note(NoteKind::Approximated, message, at);
        }
    }
}
