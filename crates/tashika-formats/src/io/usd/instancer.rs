//! Point instancers: many placements of a few prims.
//!
//! Point `i` shows prototype `protoIndices[i]` with the transform `M T_i R_i S_i P`, where `M` is
//! the transform of the instancer and `P` the prototype's own transform. A prototype inherits
//! materials, display colours and purpose from the prims above it in the scene, but not their
//! visibility.
//!
//! Held to this by `usd_meshes::points_place_their_prototypes`.

use std::rc::Rc;

use glam::{DAffine3, DQuat, DVec3};

use super::Stage;
use super::features::met;
use super::prim::Prim;
use super::value::Text;
use super::walk::{Placed, State};
use crate::error::{Error, Location, Result};
use crate::scene::{Instance, NoteKind};

impl Stage<'_> {
    /// Places the instances of a point instancer.
    pub fn instance_points(&mut self, prim: &Prim, state: &State, placed: &mut Vec<Placed>) -> Result<()> {
        let at = self.at(prim);
        if state.is_prototype {
            return met("prim", "PointInstancer in a PointInstancer", at, &mut self.builder);
        }
        let mut prototypes = Vec::new();
        for path in self.targets(prim, "prototypes") {
            prototypes.push(self.prototype(&path, &at)?);
        }
        let which = self.value(prim, "protoIndices")?;
        let which = which.as_ref().and_then(|value| value.numbers()).unwrap_or_default();
        let positions = self.value(prim, "positions")?;
        let positions = positions.as_ref().and_then(|value| value.array::<3>()).unwrap_or_default();
        let mut turns = self.value(prim, "orientationsf")?;
        if turns.is_none() {
            turns = self.value(prim, "orientations")?;
        }
        let turns = turns.as_ref().and_then(|value| value.array::<4>()).unwrap_or_default();
        let scales = self.value(prim, "scales")?;
        let scales = scales.as_ref().and_then(|value| value.array::<3>()).unwrap_or_default();
        for (name, found) in
            [("positions", positions.len()), ("orientations", turns.len()), ("scales", scales.len())]
        {
            if found != which.len() && (found != 0 || name == "positions") {
                let found = format!("{found} {name} of {} points", which.len());
                return Err(Error::invalid(at, found, "one a point"));
            }
        }
        let ids = self.value(prim, "ids")?;
        let ids = ids.as_ref().and_then(|value| value.numbers()).unwrap_or_default();
        let hidden = self.value(prim, "invisibleIds")?;
        let mut hidden = hidden.as_ref().and_then(|value| value.numbers()).unwrap_or_default().to_vec();
        hidden.extend(self.inactive_ids(prim).iter().map(|&id| id as f64));
        hidden.sort_by(f64::total_cmp);
        for (i, &prototype) in which.iter().enumerate() {
            let id = ids.get(i).copied().unwrap_or(i as f64);
            if hidden.binary_search_by(|other| other.total_cmp(&id)).is_ok() {
                continue;
            }
            let index = if prototype >= 0.0 { prototype as usize } else { usize::MAX };
            let Some(meshes) = prototypes.get(index) else {
                let expected = format!("a number below {}", prototypes.len());
                return Err(Error::invalid(at, format!("prototype {prototype}"), expected));
            };
            let place = placement(positions[i], turns.get(i), scales.get(i));
            let Some(place) = place.filter(DAffine3::is_finite) else {
                let message = "instances that are not finite or have no orientation: left out";
                self.builder.note(NoteKind::Repaired, message, at.clone());
                continue;
            };
            self.geometry_budget.take(
                (meshes.len() * size_of::<Instance>()) as u64,
                &self.composer.layers,
                &at,
            )?;
            let to_world = state.to_world * place;
            placed.extend(meshes.iter().map(|placed| Placed {
                object: prim.path.clone(),
                mesh: placed.mesh,
                to_world: to_world * placed.to_world,
            }));
        }
        Ok(())
    }

    /// Returns the meshes of a prototype, with its own transform but without those of the prims
    /// above it. A missing prototype gives a note at `at`. The prototype is read once for all
    /// instancers.
    fn prototype(&mut self, path: &Text, at: &Location) -> Result<Rc<Vec<Placed>>> {
        if let Some(known) = self.prototypes.get(path) {
            return Ok(Rc::clone(known));
        }
        let placed = Rc::new(self.read_prototype(path, at)?);
        self.prototypes.insert(path.clone(), Rc::clone(&placed));
        Ok(placed)
    }

    fn read_prototype(&mut self, path: &str, at: &Location) -> Result<Vec<Placed>> {
        let (mut placed, mut node) = (Vec::new(), self.composer.root());
        let mut state = State::new(DAffine3::IDENTITY);
        let mut names = path.split('/').filter(|name| !name.is_empty()).peekable();
        while let Some(name) = names.next() {
            let Some(child) = self.composer.child(&node, name, &mut self.builder)? else {
                let message = "prototypes that are not there: left out";
                self.builder.note(NoteKind::Repaired, message, at.clone());
                break;
            };
            if names.peek().is_none() {
                self.visit(&child, &state.of_prototype(), &mut placed)?;
                break;
            }
            let prim = self.composer.flat(&child);
            let type_name = self.type_name(&prim);
            self.note_unread(&prim, &type_name)?;
            state = self.state(&prim, &type_name, &state)?;
            node = if self.is_instance(&prim) { self.composer.shared(&child) } else { child };
        }
        Ok(placed)
    }
}

fn placement(position: [f64; 3], turn: Option<&[f64; 4]>, scale: Option<&[f64; 3]>) -> Option<DAffine3> {
    let turn = match turn {
        Some(&[w, x, y, z]) => {
            let quaternion = DQuat::from_xyzw(x, y, z, w);
            let length = quaternion.length();
            if !(length.is_finite() && length > 1e-6) {
                return None;
            }
            quaternion / length
        }
        None => DQuat::IDENTITY,
    };
    let scale = scale.map_or(DVec3::ONE, |&s| DVec3::from_array(s));
    Some(DAffine3::from_scale_rotation_translation(scale, turn, DVec3::from_array(position)))
}
