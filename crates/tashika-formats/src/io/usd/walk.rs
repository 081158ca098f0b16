//! The way through the scene: which prims are drawn, where, and of what.
//!
//! Drawn is what is defined, active, not invisible, and of the purpose `default` or `render`.
//! What is bound to a prim holds for those below it, until they are bound themselves; a binding
//! `strongerThanDescendants` is not replaced.

use glam::DAffine3;

use super::Stage;
use super::compose::MAX_DEPTH;
use super::features::{is_known, met, unknown};
use super::prim::Prim;
use super::sites::Node;
use super::value::Text;
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::scene::{Instance, MeshId};

/// What a prim has from those above it.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub to_world: DAffine3,
    pub is_visible: bool,
    purpose: Text,
    /// Bound for final renders, and for all purposes.
    bindings: [Option<Binding>; 2],
    pub display_color: Option<Rgb>,
    /// Whether this is below what a point instancer repeats.
    pub is_prototype: bool,
    depth: usize,
}

#[derive(Clone, Debug)]
struct Binding {
    material: Text,
    is_strong: bool,
}

/// A mesh in its place.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub object: Text,
    pub mesh: MeshId,
    pub to_world: DAffine3,
}

impl State {
    pub fn new(to_world: DAffine3) -> Self {
        Self {
            to_world,
            is_visible: true,
            purpose: "default".into(),
            bindings: [None, None],
            display_color: None,
            is_prototype: false,
            depth: 0,
        }
    }

    /// The material that is bound.
    pub fn material(&self) -> Option<Text> {
        self.bindings.iter().flatten().map(|b| b.material.clone()).next()
    }

    /// The same for what is repeated: as it stands by itself.
    pub fn of_prototype(&self) -> Self {
        Self { to_world: DAffine3::IDENTITY, is_prototype: true, ..self.clone() }
    }

    fn is_drawn(&self) -> bool {
        self.is_visible && matches!(&*self.purpose, "default" | "render")
    }
}

impl Stage<'_> {
    /// Everything below a prim.
    pub fn walk(&mut self, node: &Node, state: &State, placed: &mut Vec<Placed>) -> Result<()> {
        let names = {
            let prim = self.composer.flat(node);
            self.composer.children(&prim)
        };
        for name in names {
            if let Some(child) = self.composer.child(node, &name, &mut self.builder)? {
                self.visit(&child, state, placed)?;
            }
        }
        Ok(())
    }

    /// A prim and everything below it.
    pub fn visit(&mut self, node: &Node, above: &State, placed: &mut Vec<Placed>) -> Result<()> {
        let prim = self.composer.flat(node);
        if !self.composer.is_defined(&prim) || !self.is_active(&prim) {
            return Ok(());
        }
        if above.depth > MAX_DEPTH {
            let expected = format!("at most {MAX_DEPTH} prims in each other");
            return Err(Error::invalid(self.at(&prim), "a prim too deep in others", expected));
        }
        let type_name = self.type_name(&prim);
        if matches!(&*type_name, "Material" | "Shader" | "NodeGraph" | "GeomSubset") {
            return Ok(());
        }
        let state = self.state(&prim, above)?;
        let below = if self.is_instance(&prim) { self.composer.shared(node) } else { node.clone() };
        let is_drawn = state.is_drawn();
        match &*type_name {
            "" | "Xform" | "Scope" => {}
            "Camera" => self.add_camera(&prim, &state)?,
            "Mesh" if is_drawn => {
                self.note_mesh_light(&prim)?;
                for mesh in self.meshes_of(node, &prim, &state)? {
                    placed.push(Placed { object: prim.path.clone(), mesh, to_world: state.to_world });
                }
            }
            "Cube" | "Sphere" | "Cylinder" | "Cone" | "Capsule" | "Plane" if is_drawn => {
                self.note_mesh_light(&prim)?;
                if let Some((mesh, to_prim)) = self.shape_of(&prim, &type_name, &state)? {
                    let to_world = state.to_world * to_prim;
                    placed.push(Placed { object: prim.path.clone(), mesh, to_world });
                }
            }
            "DistantLight" | "SphereLight" | "RectLight" | "DiskLight" | "CylinderLight" | "DomeLight"
            | "DomeLight_1"
                if is_drawn =>
            {
                self.add_light(&prim, &type_name, &state, placed)?;
            }
            "PointInstancer" => {
                // What it repeats may be below it, and is not drawn by itself.
                if is_drawn {
                    self.instance_points(&prim, &state, placed)?;
                }
                return self.place(placed, &state);
            }
            known if is_drawn && is_known("prim", known) => {
                met("prim", known, self.at(&prim), &mut self.builder)?;
            }
            _ if is_drawn => {
                let at = self.at(&prim);
                unknown(&type_name, at, &mut self.named, &mut self.builder);
            }
            _ => {}
        }
        self.walk(&below, &state, placed)?;
        self.place(placed, &state)
    }

    /// Puts what was collected into the scene, unless it is to be repeated.
    fn place(&mut self, placed: &mut Vec<Placed>, state: &State) -> Result<()> {
        if state.is_prototype {
            return Ok(());
        }
        let mut last = None;
        for Placed { object, mesh, to_world } in placed.drain(..) {
            if last.as_ref() != Some(&object) {
                self.builder.begin_object(&*object);
            }
            self.geometry_budget.take(size_of::<Instance>() as u64, &self.origin)?;
            self.builder.add_instance(mesh, to_world)?;
            last = Some(object);
        }
        Ok(())
    }

    fn note_mesh_light(&mut self, prim: &Prim) -> Result<()> {
        if self.has_schema(prim, "MeshLightAPI") || self.has_schema(prim, "LightAPI") {
            met("light", "MeshLightAPI", self.at(prim), &mut self.builder)?;
        }
        Ok(())
    }

    /// What a prim and those below it have.
    fn state(&mut self, prim: &Prim, above: &State) -> Result<State> {
        let mut state = above.clone();
        state.depth += 1;
        let local = self.local(prim)?;
        let parent = if local.resets && !above.is_prototype { self.to_world } else { above.to_world };
        state.to_world = parent * local.to_parent;
        if self.word(prim, "visibility")?.is_some_and(|word| &*word == "invisible") {
            state.is_visible = false;
        }
        if let Some(purpose) = self.word(prim, "purpose")? {
            state.purpose = purpose;
        }
        if let Some(color) = self.inherited_color(prim)? {
            state.display_color = Some(color);
        }
        for (i, name) in ["material:binding:full", "material:binding"].into_iter().enumerate() {
            let Some(material) = self.targets(prim, name).into_iter().next() else { continue };
            if state.bindings[i].as_ref().is_some_and(|binding| binding.is_strong) {
                continue;
            }
            let strength = self.field(prim, name, |property| property.strength.clone());
            let is_strong = strength.is_some_and(|s| &*s == "strongerThanDescendants");
            state.bindings[i] = Some(Binding { material, is_strong });
        }
        for name in self.properties(prim) {
            if name.starts_with("material:binding:collection") {
                met(
                    "material",
                    "material:binding:collection",
                    self.at_property(prim, &name),
                    &mut self.builder,
                )?;
            }
        }
        Ok(state)
    }
}
