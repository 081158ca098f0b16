//! Motion of cameras and instances while the shutter is open.
//!
//! A camera or an instance that moves has a [`Motion`]. All times at which the shutter is open have
//! equal weight. They are given as *shares*: 0 when it opens, 1 when it closes. Each path has one
//! time, at which it meets all instances, whether or not the camera moves.
//!
//! Rays are transformed into the space of a moving instance's mesh, by the motion at the time of
//! the ray. The corners of the instance are never stored in world space, unlike those of
//! [baked](Instance::is_baked) instances. Functions without a time argument use the middle of the
//! time, except those that return boxes, which contain the instance at all times. An instance of a
//! mesh that [deforms](super::deformation) counts as moving even if its transform is constant.
//!
//! # Guarantee
//! In a scene that [`SceneBuilder::build`] returns, all moving instances have the same shutter
//! times, their transforms can be inverted at all times, and they are inside [`Scene::bounds`] at
//! all times.
//!
//! # Held to this by
//! The tests below; the suite's `moving_objects`.

use glam::{Affine3A, DAffine3, DMat3};

use super::{Instance, InstanceId, Mesh, MeshId, NoteKind, Scene, SceneBuilder};
use crate::error::{Error, Result};
use crate::math::Aabb;
use crate::math::motion::Track;

/// Transform to the world while the shutter is open; all times have equal weight.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Transform to the world by time (s).
    pub track: Track,
    /// Times at which the shutter opens and closes (s).
    pub shutter: [f64; 2],
}

impl Motion {
    /// Creates the motion between two times (s); `None` if the track is constant between them.
    pub fn between(track: Track, shutter: [f64; 2]) -> Option<Self> {
        track.moves_between(shutter).then_some(Self { track, shutter })
    }

    /// Transform after a share of the time that the shutter is open, 0 to 1.
    pub fn pose(&self, share: f32) -> Affine3A {
        let [open, close] = self.shutter;
        self.track.at(open + f64::from(share) * (close - open)).as_affine3a()
    }

    pub(super) fn is_valid(&self) -> bool {
        let [open, close] = self.shutter;
        open.is_finite() && close.is_finite() && open <= close && self.track.keeps_sides()
    }

    /// Returns an instance that has this motion, in its pose after a share of the time.
    fn placed(&self, instance: &Instance, share: f32) -> Instance {
        if self.track.is_still() {
            return *instance;
        }
        let to_world = self.pose(share);
        Instance { to_world, to_object: inverse(&to_world), ..*instance }
    }
}

/// Inverse of a map, computed in double precision and rounded once.
pub(super) fn inverse(map: &Affine3A) -> Affine3A {
    let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(|c| c.as_dvec3());
    let [x, y, z] = columns;
    let matrix3 = DMat3::from_cols(x, y, z);
    DAffine3 { matrix3, translation: map.translation.as_dvec3() }.inverse().as_affine3a()
}

impl SceneBuilder {
    /// Adds an instance that moves while the shutter is open; if the track is constant in that
    /// time, the instance is [static](Self::add_instance). An instance is omitted and noted if its
    /// transform cannot be inverted at some time, or mirrors at some times only.
    ///
    /// # Errors
    /// No such mesh; a shutter that does not open at a finite time and close at a later one;
    /// shutter times that differ from those of moving instances added before, or from those of the
    /// mesh, if it deforms.
    pub fn add_moving_instance(
        &mut self,
        mesh: MeshId,
        track: Track,
        shutter: [f64; 2],
    ) -> Result<Option<InstanceId>> {
        let at = || self.origin.clone().item(format!("instance {}", self.scene.instances.len()));
        let [open, close] = shutter;
        let found = || format!("a shutter that is open from {open} to {close} s");
        if !(open <= close && open.is_finite() && close.is_finite()) {
            return Err(Error::invalid(at(), found(), "finite times, the first not after the second"));
        }
        if let Some([open, close]) = self.scene.shutter().filter(|other| *other != shutter) {
            let expected = format!("{open} to {close} s, as for the instances before");
            return Err(Error::invalid(at(), found(), expected));
        }
        let deforms = self.scene.meshes.get(mesh.index()).and_then(Mesh::deforms);
        if let Some([open, close]) = deforms.filter(|other| *other != shutter) {
            let expected = format!("{open} to {close} s, as the mesh deforms");
            return Err(Error::invalid(at(), found(), expected));
        }
        if !track.can_place() {
            let message =
                "instances that move with a transform that cannot be inverted at all times: left out";
            let at = at();
            self.note(NoteKind::Repaired, message, at);
            return Ok(None);
        }
        let middle = track.at(open + 0.5 * (close - open));
        let placed = self.place(mesh, middle)?;
        let motion = match deforms {
            Some(_) => Some(Motion { track, shutter }),
            None => Motion::between(track, shutter),
        };
        if let (Some(id), Some(motion)) = (placed, motion) {
            let instance = &mut self.scene.instances[id.index()];
            instance.motion = Some(self.scene.motions.len() as u32);
            instance.to_object = inverse(&instance.to_world);
            self.scene.motions.push(motion);
        }
        Ok(placed)
    }
}

impl Scene {
    /// Motion of an instance while the shutter is open, if it moves.
    #[inline]
    pub fn motion_of(&self, instance: InstanceId) -> Option<&Motion> {
        self.instances[instance.index()].motion.map(|motion| &self.motions[motion as usize])
    }

    /// Returns true if any instance moves or deforms while the shutter is open.
    #[inline]
    pub fn moves(&self) -> bool {
        !self.motions.is_empty()
    }

    /// Times at which the shutter opens and closes (s), if any instance moves in between.
    pub fn shutter(&self) -> Option<[f64; 2]> {
        self.motions.first().map(|motion| motion.shutter)
    }

    /// Returns a moving instance in its pose after a share of the time that the shutter is open, 0
    /// to 1; `None` if the instance is static.
    #[inline]
    pub fn moved(&self, instance: InstanceId, share: f32) -> Option<Instance> {
        Some(self.motion_of(instance)?.placed(&self.instances[instance.index()], share))
    }

    /// World box that contains an instance at all times (m); for a moving instance, with a margin
    /// for rounding.
    pub fn box_of(&self, instance: &Instance) -> Aabb {
        let bounds = self.meshes[instance.mesh.index()].bounds();
        match instance.motion {
            None => bounds.transformed(&instance.to_world),
            Some(motion) => {
                let Motion { track, shutter } = &self.motions[motion as usize];
                track.swept(&bounds, *shutter)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::color::Rgb;
    use crate::error::Location;
    use crate::scene::{Material, MeshData, Surface};

    fn builder() -> (SceneBuilder, MeshId) {
        let mut b = SceneBuilder::new("s", Location::file("s.pbrt"));
        let material = Material::new("m", Surface::Lambert { reflectance: Rgb::gray(0.5).into() });
        let material = b.add_material(material).unwrap();
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)];
        let data = MeshData { positions, triangles: vec![[0, 1, 2]], ..MeshData::default() };
        let mesh = b.add_mesh(data, material).unwrap();
        (b, mesh)
    }

    fn track(ends: [DAffine3; 2]) -> Track {
        Track::new([(1.0, ends[0]), (3.0, ends[1])]).unwrap()
    }

    #[test]
    fn what_moves_is_where_its_track_is_and_in_the_middle_without_a_time() {
        let (mut b, mesh) = builder();
        let place = |x: f64| DAffine3 { matrix3: DMat3::IDENTITY * 2.0, translation: DVec3::X * x };
        let moving = track([place(0.0), place(8.0)]);
        let id = b.add_moving_instance(mesh, moving, [1.5, 2.5]).unwrap().unwrap();
        let still = b.add_instance(mesh, Affine3A::from_translation(Vec3::X * 4.0)).unwrap().unwrap();
        let scene = b.build().unwrap();
        assert!(scene.moves() && scene.shutter() == Some([1.5, 2.5]));
        for (share, x) in [(0.0, 2.0), (0.25, 3.0), (1.0, 6.0)] {
            let moved = scene.moved(id, share).unwrap();
            assert_eq!(Vec3::from(moved.to_world.translation), Vec3::X * x);
            let back = moved.to_object.transform_point3(Vec3::new(x + 2.0, 0.0, 0.0));
            assert_eq!(back, Vec3::X, "the inverse is of the same time");
        }
        let instance = &scene.instances()[id.index()];
        assert_eq!(instance.to_world.translation.x, 4.0, "the middle");
        assert!(!instance.is_baked() && scene.instances()[still.index()].is_baked());
        assert!(scene.moved(still, 0.5).is_none());
        let b = scene.bounds();
        assert!((b.lo.x - 2.0).abs() < 1e-4 && (b.hi.x - 8.0).abs() < 1e-4, "at all times: {b:?}");
        assert!(b.contains(Vec3::new(2.0, 0.0, 0.0)) && b.contains(Vec3::new(8.0, 2.0, 0.0)));
    }

    #[test]
    fn what_cannot_be_placed_at_all_times_is_left_out_or_refused() {
        let (mut b, mesh) = builder();
        let (one, mirror) = (DAffine3::IDENTITY, DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)));
        assert!(b.add_moving_instance(mesh, track([one, mirror]), [1.0, 3.0]).unwrap().is_none());
        let said: Vec<String> = b.notes_mut().iter().map(|note| note.message).collect();
        assert!(said.iter().any(|note| note.contains("inverted at all times")), "{said:?}");
        let moving = || track([one, DAffine3::from_translation(DVec3::X)]);
        for shutter in [[3.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            let said = b.add_moving_instance(mesh, moving(), shutter).unwrap_err().to_string();
            assert!(said.contains("s.pbrt") && said.contains("finite times"), "{said}");
        }
        assert!(b.add_moving_instance(mesh, moving(), [5.0, 6.0]).unwrap().is_some());
        assert!(!b.scene.moves(), "it has stopped before");
        b.add_moving_instance(mesh, moving(), [1.0, 3.0]).unwrap();
        let said = b.add_moving_instance(mesh, moving(), [1.0, 2.0]).unwrap_err().to_string();
        assert!(said.contains("from 1 to 2 s") && said.contains("1 to 3 s, as for the instances"), "{said}");
        assert!(b.add_moving_instance(MeshId::at(7), moving(), [1.0, 3.0]).is_err());
    }
}
