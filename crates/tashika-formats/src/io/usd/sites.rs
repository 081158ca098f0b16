//! Sites: paths in stacks of layers, with the sites that they are composed of.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::layers::{LayerId, StackId};
use super::value::Text;

/// Reasons for which a site is part of a prim, strongest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Arc {
    Own,
    Inherit,
    Variant,
    Reference,
    Payload,
    Specialize,
}

/// Map from the paths of a site to paths of the scene.
#[derive(Debug)]
pub(super) struct Mapping {
    pub from: Text,
    pub to: Text,
    /// True if paths outside of `from` stay unchanged, as within one stack of layers. Otherwise the
    /// scene does not have them.
    pub keeps_others: bool,
    pub above: Option<Rc<Mapping>>,
}

impl Mapping {
    /// Path in the scene; none if the scene does not have that path.
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

/// A site with the sites that it is composed of.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub arc: Arc,
    pub stack: StackId,
    pub path: Text,
    /// Opinions of the site itself as layer and prim, strongest first.
    pub specs: Vec<(LayerId, u32)>,
    pub mapping: Rc<Mapping>,
    pub below: Vec<Node>,
    /// Number of names in the path of the prim that names this site. A larger number is stronger.
    pub depth: usize,
    /// Variant sets for which a variant was chosen.
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

/// Returns true if the site, or one below it, has an opinion.
pub(super) fn has_specs(node: &Node) -> bool {
    !node.specs.is_empty() || node.below.iter().any(has_specs)
}

pub(super) fn identity() -> Rc<Mapping> {
    Rc::new(Mapping { from: "/".into(), to: "/".into(), keeps_others: true, above: None })
}
