//! `ObjectBegin`, `ObjectEnd`, `ObjectInstance`, and the placing of meshes.
//!
//! In pbrt-v4 an instance may precede its object: such instances are placed at the end of the file.
//! Tested by `suite::pbrt::objects_*`, `suite::pbrt_names`.

use glam::DAffine3;

use super::Interpreter;
use crate::error::{Error, Location, Result};
use crate::io::notes::excerpt;
use crate::io::pbrt::names::Named;
use crate::io::pbrt::place::Place;
use crate::io::pbrt::shapes::Part;
use crate::io::pbrt::state::SavedBy;
use crate::io::pbrt::transform;
use crate::io::pbrt::version::Version;
use crate::math::motion::Track;
use crate::scene::NoteKind;

/// Most placements of meshes, since a small text can request a product of large numbers. A moving
/// placement counts by its memory, in units of a static one.
const MAX_INSTANCES: usize = 1 << 22;

/// Approximate memory of a static placement (bytes).
const INSTANCE_BYTES: usize = 150;

/// An `ObjectInstance` directive.
pub(super) struct Instance {
    name: String,
    to_world: DAffine3,
    /// Motion of `to_world`, if it moves.
    track: Option<Track>,
    at: Location,
}

impl Interpreter<'_> {
    /// Places a part in the world. `track` is the motion of `to_world`, if it moves.
    pub(super) fn add_instance(
        &mut self,
        part: &Part,
        to_world: &DAffine3,
        track: Option<&Track>,
        at: &Location,
    ) -> Result<()> {
        let track = transform::product([to_world, &part.to_object], [track, part.track.as_ref()]);
        self.instances += 1 + track.as_ref().map_or(0, Track::bytes) as usize / INSTANCE_BYTES;
        if self.instances > MAX_INSTANCES {
            let found = format!("{} placements of shapes", self.instances);
            return Err(Error::invalid(at.clone(), found, format!("at most {MAX_INSTANCES}")));
        }
        if let Some(track) = track
            && let Some(shutter) = self.shutter()
        {
            return self.loading.builder.add_moving_instance(part.mesh, track, shutter).map(|_| ());
        }
        let placed = *to_world * part.to_object;
        match transform::placeable(&placed) {
            Some(_) => self.loading.builder.add_instance(part.mesh, placed).map(|_| ()),
            None => {
                self.note(
                    NoteKind::Repaired,
                    "instances with a transform that cannot be inverted: left out",
                    at.clone(),
                );
                Ok(())
            }
        }
    }

    pub(super) fn begin_object(&mut self, name: String, place: &Place) -> Result<()> {
        self.save(SavedBy::Object, place)?;
        if let Some((outer, parts)) = self.object.take() {
            self.note(NoteKind::Repaired, "objects in objects: the outer one ends there", place.location());
            self.objects.insert(outer, parts);
        }
        self.object = Some((name, Vec::new()));
        Ok(())
    }

    pub(super) fn end_object(&mut self, at: Location) {
        match self.object.take() {
            Some((name, parts)) => {
                self.objects.insert(name, parts);
                self.restore(SavedBy::Object, at);
            }
            None => self.note(NoteKind::Repaired, "ObjectEnd without ObjectBegin: passed over", at),
        }
    }

    pub(super) fn instance(&mut self, name: &str, at: Location) -> Result<()> {
        if self.object.is_some() {
            self.note(NoteKind::Ignored, "instances inside objects, which pbrt does not allow: left out", at);
            return Ok(());
        }
        let track = self.motion(false, &at);
        let Some(to_world) = self.place(&at)? else { return Ok(()) };
        let instance = Instance { name: name.to_owned(), to_world, track, at };
        if self.loading.version == Version::V4 && !self.objects.contains_key(name) {
            self.waiting.push(instance);
            return Ok(());
        }
        self.place_object(&instance)
    }

    /// Places the instances that precede their objects.
    pub(super) fn place_waiting(&mut self) -> Result<()> {
        let waiting = std::mem::take(&mut self.waiting);
        waiting.iter().try_for_each(|instance| self.place_object(instance))
    }

    fn place_object(&mut self, instance: &Instance) -> Result<()> {
        let Instance { name, to_world, track, at } = instance;
        // The object is removed while its parts are placed, to avoid a copy.
        let Some(parts) = self.objects.remove(name) else {
            self.loading.names.miss(Named::Object, name, at);
            let message = format!("object {:?} is not defined: left out", excerpt(name, 60));
            self.loading.note_named(NoteKind::Repaired, message, "objects are not defined", at.clone());
            return Ok(());
        };
        self.loading.builder.begin_unnamed_object(name);
        for part in &parts {
            self.add_instance(part, to_world, track.as_ref(), at)?;
        }
        self.objects.insert(name.clone(), parts);
        Ok(())
    }
}
