//! Materials that are bound to prims.
//!
//! A binding holds for a prim and its descendants. A descendant's own binding replaces an inherited
//! one, unless the inherited one is `strongerThanDescendants`. A binding for final renders
//! (`material:binding:full`) takes precedence over a binding for all purposes, even if an ancestor
//! has the former and the prim itself the latter. A binding to a prim that is not a material is
//! ignored.
//!
//! Held to this by `usd_scope` of the suite.

use super::Stage;
use super::prim::Prim;
use super::value::Text;
use crate::error::Result;
use crate::scene::NoteKind;

/// Bindings that hold for a prim: for final renders, and for all purposes.
#[derive(Clone, Debug, Default)]
pub(super) struct Bindings([Option<Binding>; 2]);

#[derive(Clone, Debug)]
struct Binding {
    material: Text,
    is_strong: bool,
}

/// Names of the relationships, in the order of `Bindings`.
const NAMES: [&str; 2] = ["material:binding:full", "material:binding"];

impl Bindings {
    /// Returns the material that is used.
    pub fn material(&self) -> Option<&Text> {
        self.0.iter().flatten().map(|binding| &binding.material).next()
    }
}

impl Stage<'_> {
    /// Replaces inherited bindings by those of a prim, except where the inherited one is
    /// `strongerThanDescendants`.
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

    /// Returns the material of a subset, if it differs from that of the mesh; none, with a note, if
    /// the material is missing.
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
