//! Sites: a path in a stack of layers, with those that it is made of.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::layers::{LayerId, StackId};
use super::value::Text;

/// Why a site is part of a prim, the strongest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Arc {
    Own,
    Inherit,
    Variant,
    Reference,
    Payload,
    Specialize,
}

/// Where paths of a site are in the scene.
#[derive(Debug)]
pub(super) struct Mapping {
    pub from: Text,
    pub to: Text,
    /// Whether what is outside of `from` keeps its path, as within the same layers.
    pub keeps_others: bool,
    pub above: Option<Rc<Mapping>>,
}

impl Mapping {
    /// The path in the scene; none for what the scene does not have.
    pub fn scene_path(&self, path: &str) -> Option<Text> {
        let rest = path
            .strip_prefix(&*self.from)
            .filter(|rest| &*self.from == "/" || rest.is_empty() || rest.starts_with(['/', '.']));
        let mapped: Text = match rest {
            Some(_) if &*self.from == "/" && &*self.to == "/" => path.into(),
            Some(rest) if &*self.from == "/" => format!("{}/{rest}", self.to).into(),
            Some(rest) => format!("{}{rest}", self.to).into(),
            None if self.keeps_others => path.into(),
            None => return None,
        };
        match &self.above {
            Some(above) => above.scene_path(&mapped),
            None => Some(mapped),
        }
    }
}

/// A site and those that it is made of.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub arc: Arc,
    pub stack: StackId,
    pub path: Text,
    /// Layer and prim, the strongest first.
    pub specs: Vec<(LayerId, u32)>,
    pub mapping: Rc<Mapping>,
    pub below: Vec<Node>,
    /// Names in the path of the prim that named this; more are stronger.
    pub depth: usize,
    /// Variant sets that have been chosen from.
    pub chosen: BTreeSet<Text>,
}

impl Node {
    /// Returns the strongest layer and prim with an opinion.
    pub fn first_spec(&self) -> Option<(LayerId, u32)> {
        self.specs.first().copied().or_else(|| self.below.iter().find_map(Self::first_spec))
    }

    /// Returns the number of names of the path.
    pub fn names(&self) -> usize {
        self.path.bytes().filter(|b| *b == b'/').count()
    }
}

/// Whether anything is said.
pub(super) fn has_specs(node: &Node) -> bool {
    !node.specs.is_empty() || node.below.iter().any(has_specs)
}

pub(super) fn identity() -> Rc<Mapping> {
    Rc::new(Mapping { from: "/".into(), to: "/".into(), keeps_others: true, above: None })
}
