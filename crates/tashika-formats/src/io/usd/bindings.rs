//! Materials that are bound to prims.
//!
//! A binding holds for a prim and those below it, until they are bound themselves; one
//! `strongerThanDescendants` is not replaced. Bindings for final renders (`material:binding:full`)
//! count before those for all purposes, wherever they stand. A binding to what is no material
//! counts as none.
//!
//! Held to this by `usd_scope` of the suite.

use super::Stage;
use super::prim::Prim;
use super::value::Text;
use crate::error::Result;
use crate::scene::NoteKind;

/// Bound materials, for final renders and for all purposes.
#[derive(Clone, Debug, Default)]
pub(super) struct Bindings([Option<Binding>; 2]);

#[derive(Clone, Debug)]
struct Binding {
    material: Text,
    is_strong: bool,
}

/// The relationships, in their order.
const NAMES: [&str; 2] = ["material:binding:full", "material:binding"];

impl Bindings {
    /// The material that counts.
    pub fn material(&self) -> Option<&Text> {
        self.0.iter().flatten().map(|binding| &binding.material).next()
    }
}

impl Stage<'_> {
    /// Takes over the bindings of a prim below those that are there.
    pub fn bind(&mut self, prim: &Prim, bindings: &mut Bindings) -> Result<()> {
        for (bound, name) in bindings.0.iter_mut().zip(NAMES) {
            let Some(material) = self.targets(prim, name).into_iter().next() else { continue };
            if bound.as_ref().is_some_and(|binding| binding.is_strong) {
                continue;
            }
            let strength = self.field(prim, name, |property| property.strength.clone());
            let is_strong = strength.is_some_and(|s| &*s == "strongerThanDescendants");
            *bound = Some(Binding { material, is_strong });
        }
        Ok(())
    }

    /// The material of a subset of a mesh, if it is another one than the mesh has; none,
    /// with a note, if it is not there.
    pub fn own_material(&mut self, subset: &Prim, of_mesh: &Bindings) -> Result<Option<Text>> {
        let mut bindings = of_mesh.clone();
        self.bind(subset, &mut bindings)?;
        let Some(material) = bindings.material().filter(|own| Some(*own) != of_mesh.material()) else {
            return Ok(None);
        };
        if self.is_material(material)? {
            return Ok(Some(material.clone()));
        }
        let message = "subsets bound to materials that are not there: the mesh's is used";
        let at = self.at(subset);
        self.builder.note(NoteKind::Repaired, message, at);
        Ok(None)
    }

    /// Returns true if a prim of the scene is a material.
    fn is_material(&mut self, path: &Text) -> Result<bool> {
        if let Some(&known) = self.materials.known.get(path) {
            return Ok(known);
        }
        let prim = self.composer.prim(path, &mut self.builder)?;
        let is_material = prim.is_some_and(|prim| &*self.type_name(&prim) == "Material");
        self.materials.known.insert(path.clone(), is_material);
        Ok(is_material)
    }
}
