//! Traversal of the scene: the prims that are drawn, with their transforms and materials.
//!
//! A prim is drawn if it is defined, active, not invisible, and of the purpose `default` or
//! `render`. A prim without a type has no transform, visibility or purpose. A `Scope` has no
//! transform.
//!
//! Held to this by `usd` and `usd_scope` of the suite.

use glam::DAffine3;

use super::Stage;
use super::bindings::Bindings;
use super::compose::MAX_DEPTH;
use super::features::{is_known, met, unknown};
use super::prim::Prim;
use super::primvars::Shown;
use super::sites::Node;
use super::value::Text;
use crate::error::{Error, Result};
use crate::scene::{Instance, MeshId};

/// Number of composition steps that the visit of a prim counts as.
const STEPS: u64 = 2;

/// State that a prim inherits from the prims above it.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub to_world: DAffine3,
    pub is_visible: bool,
    /// True if prims of the purpose `render` are visible.
    shows_render: bool,
    purpose: Text,
    pub bindings: Bindings,
    /// Colour and opacity of the prim, if no material is bound.
    pub shown: Shown,
    /// Colour and opacity that prims below inherit.
    shown_below: Shown,
    /// True for a prototype of a point instancer and the prims below it.
    pub is_prototype: bool,
    depth: usize,
}

/// A mesh with its transform.
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
            shows_render: true,
            purpose: "default".into(),
            bindings: Bindings::default(),
            shown: Shown::default(),
            shown_below: Shown::default(),
            is_prototype: false,
            depth: 0,
        }
    }

    /// Returns the state of a prototype: without transforms of its ancestors, and visible even if
    /// they are hidden.
    pub fn of_prototype(&self) -> Self {
        Self { to_world: DAffine3::IDENTITY, is_prototype: true, is_visible: true, ..self.clone() }
    }

    fn is_drawn(&self) -> bool {
        let is_shown = match &*self.purpose {
            "default" => true,
            "render" => self.shows_render,
            _ => false,
        };
        self.is_visible && is_shown
    }
}

impl Stage<'_> {
    /// Visits all prims below a prim.
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

    /// Visits a prim and all prims below it.
    pub fn visit(&mut self, node: &Node, above: &State, placed: &mut Vec<Placed>) -> Result<()> {
        let prim = self.composer.flat(node);
        if !self.composer.is_defined(&prim) || !self.is_active(&prim) {
            return Ok(());
        }
        self.composer.steps.add(STEPS, 0);
        self.composer.check(node)?;
        if above.depth > MAX_DEPTH {
            let expected = format!("at most {MAX_DEPTH} prims in each other");
            return Err(Error::invalid(self.at(&prim), "a prim too deep in others", expected));
        }
        let type_name = self.type_name(&prim);
        if matches!(&*type_name, "Material" | "Shader" | "NodeGraph" | "GeomSubset") {
            return Ok(());
        }
        if self.has_clips(&prim) {
            met("composition", "clips", self.at(&prim), &mut self.builder)?;
        }
        let state = self.state(&prim, &type_name, above)?;
        let below = if self.is_instance(&prim) { self.composer.shared(node) } else { node.clone() };
        let is_drawn = state.is_drawn();
        if self.time.is_some() && (type_name.ends_with("Light") || &*type_name == "DomeLight_1") {
            self.builder.set_dark_now();
        }
        if is_drawn || &*type_name == "Camera" {
            self.note_unread(&prim, &type_name)?;
        }
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
                // Prims below the instancer may be its prototypes, which are drawn only as
                // instances.
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

    /// Adds the collected meshes to the scene, unless they belong to a prototype.
    fn place(&mut self, placed: &mut Vec<Placed>, state: &State) -> Result<()> {
        if state.is_prototype {
            return Ok(());
        }
        self.builder.set_most_instances(self.composer.layers.files.most_instances());
        let mut last = None;
        for Placed { object, mesh, to_world } in placed.drain(..) {
            if last.as_ref() != Some(&object) {
                self.builder.begin_object(&*object);
            }
            self.geometry_budget.take(size_of::<Instance>() as u64, &self.composer.layers, &self.origin)?;
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

    /// Returns the state of a prim of the given type.
    pub fn state(&mut self, prim: &Prim, type_name: &str, above: &State) -> Result<State> {
        let mut state = above.clone();
        state.depth += 1;
        if !matches!(type_name, "" | "Scope") {
            let local = self.local(prim)?;
            let parent = if local.resets && !above.is_prototype { self.to_world } else { above.to_world };
            state.to_world = parent * local.to_parent;
        } else if self.value(prim, "xformOpOrder")?.is_some() {
            let at = self.at_property(prim, "xformOpOrder");
            met("attribute", "xformOpOrder without Xform", at, &mut self.builder)?;
        }
        if !type_name.is_empty() {
            self.see(prim, &mut state)?;
        }
        self.show(prim, [&mut state.shown, &mut state.shown_below])?;
        self.bind(prim, &mut state.bindings)?;
        Ok(state)
    }

    /// Reads visibility and purpose of a prim.
    fn see(&mut self, prim: &Prim, state: &mut State) -> Result<()> {
        if self.word(prim, "visibility")?.is_some_and(|word| &*word == "invisible") {
            state.is_visible = false;
        }
        if self.has_schema(prim, "VisibilityAPI") {
            match self.word(prim, "renderVisibility")?.as_deref() {
                Some("invisible") => state.shows_render = false,
                Some("visible") => state.shows_render = true,
                _ => {}
            }
        }
        if let Some(purpose) = self.word(prim, "purpose")? {
            state.purpose = purpose;
        }
        Ok(())
    }
}
