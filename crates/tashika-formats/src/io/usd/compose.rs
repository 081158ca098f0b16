//! Prims of the scene, composed from the opinions of layers.
//!
//! The opinions about a prim form a tree of sites. A site is a path in a stack of layers. Its
//! children in the tree are the sites that it is composed of, strongest first: inherited classes,
//! chosen variants, references, payloads, specialised classes. Among sites of one kind, a site that
//! the prim itself names is stronger than a site that comes from a reference (or other arc) of a
//! prim above it. A [`Prim`] lists all opinions in depth-first order of the tree, and within a site
//! in the order of its layers.
//!
//! # Guarantee
//! A prim that is composed of itself is refused. The total number of sites is bounded by the bytes
//! of the layers ([`work`](super::work)), and the depth of prims by [`MAX_DEPTH`].
//!
//! # Differences from USD
//! If a prim of a referenced file inherits a class, only that file's opinions about the class
//! count; opinions of the referencing file about it are ignored. Specialised classes are weaker
//! than all opinions of the site that names them, but not weaker than the opinions of every other
//! site. Shifted times, relocations and clips are ignored.
//!
//! Held to this by `usd` of the suite, which compares with Pixar's own library.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::features::met;
use super::layer::{PrimSpec, Specifier};
use super::layers::{LayerId, Layers, StackId};
use super::prim::Prim;
use super::sites::{Arc, Mapping, Node, has_specs, identity};
use super::value::{ListOp, Reference, Text};
use super::work::Steps;
use crate::error::{Error, Location, Result};
use crate::io::notes::shown;
use crate::scene::{NoteKind, SceneBuilder};

/// Largest depth of a prim (names in its path).
pub(super) const MAX_DEPTH: usize = 200;

/// Largest length of a chain of prims composed of each other.
const MAX_CHAIN: usize = 50;

/// Largest number of variant sets of a prim.
const MAX_VARIANTS: usize = 1000;

/// Composes prims from sites.
pub(super) struct Composer<'f> {
    pub layers: Layers<'f>,
    pub steps: Steps,
}

impl<'f> Composer<'f> {
    pub fn new(layers: Layers<'f>) -> Self {
        Self { layers, steps: Steps::default() }
    }

    /// Node of the pseudo-root, the parent of all top-level prims.
    pub fn root(&self) -> Node {
        self.top(0, Arc::Own, identity())
    }

    fn top(&self, stack: StackId, arc: Arc, mapping: Rc<Mapping>) -> Node {
        let specs = self.layers.stack(stack).iter().map(|&layer| (layer, 0)).collect();
        Node {
            arc,
            stack,
            path: "/".into(),
            specs,
            mapping,
            below: Vec::new(),
            depth: 0,
            chosen: BTreeSet::new(),
        }
    }

    /// Prim at a path of the scene, if there is one.
    pub fn prim(&mut self, path: &str, builder: &mut SceneBuilder) -> Result<Option<Prim>> {
        Ok(self.node(path, builder)?.map(|(_, prim)| prim))
    }

    /// Prim at a path of the scene, with its sites.
    pub fn node(&mut self, path: &str, builder: &mut SceneBuilder) -> Result<Option<(Node, Prim)>> {
        let mut node = self.root();
        for name in path.split('/').filter(|name| !name.is_empty()) {
            match self.child(&node, name, builder)? {
                Some(child) => node = child,
                None => return Ok(None),
            }
        }
        let prim = self.flat(&node);
        Ok((&*node.path != "/").then_some((node, prim)))
    }

    /// Opinions about the prim of a node, in order of strength.
    pub fn flat(&self, node: &Node) -> Prim {
        fn collect(node: &Node, all: &mut Vec<(LayerId, u32, Rc<Mapping>)>) {
            all.extend(node.specs.iter().map(|&(layer, prim)| (layer, prim, Rc::clone(&node.mapping))));
            node.below.iter().for_each(|below| collect(below, all));
        }
        let mut opinions = Vec::new();
        collect(node, &mut opinions);
        Prim::new(node.path.clone(), opinions)
    }

    /// Names of the prims below a prim.
    pub fn children(&self, prim: &Prim) -> Vec<Text> {
        let mut names = Vec::new();
        let mut seen = BTreeSet::new();
        // Layers are visited from the weakest up, so prims that stronger layers add come later.
        for (layer, spec, _) in prim.opinions().iter().rev() {
            for (name, _) in &self.layers.spec((*layer, *spec)).children {
                if seen.insert(name.clone()) {
                    names.push(name.clone());
                }
            }
        }
        names
    }

    /// The prim `name` below another, with the sites that it is composed of.
    pub fn child(&mut self, parent: &Node, name: &str, builder: &mut SceneBuilder) -> Result<Option<Node>> {
        self.steps.check(&self.layers, || self.at(parent))?;
        let mut node = self.step(parent, name, 0)?;
        if !has_specs(&node) {
            return Ok(None);
        }
        let chain = &mut Vec::new();
        self.name_arcs(&mut node, chain, builder)?;
        self.choose_variants(&mut node, builder)?;
        Ok(Some(node))
    }

    /// Returns the child `name` of a node, without the sites that the child itself names. `nested`
    /// is the length of the chain of sites that leads to the node.
    fn step(&self, parent: &Node, name: &str, nested: usize) -> Result<Node> {
        let path: Text = if &*parent.path == "/" {
            format!("/{name}").into()
        } else {
            format!("{}/{name}", parent.path).into()
        };
        let specs = parent.specs.iter().filter_map(|&(layer, prim)| {
            let prim = *self.layers.spec((layer, prim)).by_name.get(name)?;
            Some((layer, prim))
        });
        let specs: Vec<_> = specs.collect();
        // Each step copies the path, which may be long.
        self.steps.add(1 + path.len() as u64 / 64, nested);
        let depth = parent.depth;
        if parent.names() > MAX_DEPTH {
            let expected = format!("at most {MAX_DEPTH} names");
            return Err(Error::invalid(self.at(parent), "a prim too deep in others", expected));
        }
        let below =
            parent.below.iter().map(|node| self.step(node, name, nested + 1)).collect::<Result<Vec<_>>>()?;
        // A site without opinions about a prim has none about the prims below it.
        let below = below.into_iter().filter(has_specs).collect();
        Ok(Node {
            arc: parent.arc,
            stack: parent.stack,
            path,
            specs,
            mapping: Rc::clone(&parent.mapping),
            below,
            depth,
            chosen: BTreeSet::new(),
        })
    }

    /// Refuses a prim that exceeds the permitted work of the scene.
    pub fn check(&self, node: &Node) -> Result<()> {
        self.steps.check(&self.layers, || self.at(node))
    }

    /// Returns the location of a node's prim.
    fn at(&self, node: &Node) -> Location {
        match node.first_spec() {
            Some(site) => self.layers.at(site, &node.path),
            None => Location::default().item(&*node.path),
        }
    }

    /// Adds, for `node` and every site below it, the sites that each of them names, except
    /// variants.
    fn name_arcs(
        &mut self,
        node: &mut Node,
        chain: &mut Vec<(StackId, Text)>,
        builder: &mut SceneBuilder,
    ) -> Result<()> {
        chain.push((node.stack, node.path.clone()));
        let mut result = Ok(());
        for below in &mut node.below {
            result = result.and_then(|()| self.name_arcs(below, chain, builder));
        }
        result?;
        self.own_arcs(node, chain, builder)?;
        chain.pop();
        Ok(())
    }

    /// Adds the sites that `node` itself names, except variants.
    fn own_arcs(
        &mut self,
        node: &mut Node,
        chain: &mut Vec<(StackId, Text)>,
        builder: &mut SceneBuilder,
    ) -> Result<()> {
        let specs = node.specs.clone();
        let depth = node.names();
        for (arc, select) in [
            (Arc::Inherit, (|p| &p.inherits) as fn(&PrimSpec) -> &ListOp<Text>),
            (Arc::Specialize, |p| &p.specializes),
        ] {
            for (path, site) in self.listed(&specs, select) {
                let reference = Reference { prim: path, ..Reference::default() };
                self.add_site(node, arc, (&reference, site, depth), chain, builder)?;
            }
        }
        for (arc, select) in [
            (Arc::Reference, (|p| &p.references) as fn(&PrimSpec) -> &ListOp<Reference>),
            (Arc::Payload, |p| &p.payloads),
        ] {
            for (reference, site) in self.listed(&specs, select) {
                self.add_site(node, arc, (&reference, site, depth), chain, builder)?;
            }
        }
        node.below.sort_by_key(|n| (n.arc, std::cmp::Reverse(n.depth)));
        Ok(())
    }

    /// Applies the edits that the layers of a site make to a list. Returns the items, each with the
    /// strongest spec that names it.
    fn listed<T: Clone + Ord>(
        &self,
        specs: &[(LayerId, u32)],
        select: fn(&PrimSpec) -> &ListOp<T>,
    ) -> Vec<(T, (LayerId, u32))> {
        let mut list = Vec::new();
        let mut sites: BTreeMap<T, (LayerId, u32)> = BTreeMap::new();
        for &site in specs.iter().rev() {
            let op = select(self.layers.spec(site));
            op.apply(&mut list);
            self.steps.add(list.len() as u64, 0);
            let named = op.explicit.iter().flatten().chain(&op.prepended).chain(&op.appended);
            sites.extend(named.map(|item| (item.clone(), site)));
        }
        let site_of = |item: &T| sites.get(item).copied();
        list.into_iter().filter_map(|item| site_of(&item).map(|site| (item, site))).collect()
    }

    fn add_site(
        &mut self,
        node: &mut Node,
        arc: Arc,
        (reference, site, depth): (&Reference, (LayerId, u32), usize),
        chain: &mut Vec<(StackId, Text)>,
        builder: &mut SceneBuilder,
    ) -> Result<()> {
        let at = self.layers.at(site, &node.path);
        self.steps.follow(site);
        self.steps.add(1, chain.len());
        self.steps.check(&self.layers, || at.clone())?;
        if reference.has_offset {
            met("composition", "layer offset", at.clone(), builder)?;
        }
        let is_inside = reference.asset.is_empty();
        let stack = if is_inside {
            node.stack
        } else {
            match self.layers.stack_at(&reference.asset, site.0, &at, builder)? {
                Some(stack) => stack,
                None => return Ok(()),
            }
        };
        let target = if reference.prim.is_empty() {
            let root = self.layers.layer(self.layers.stack(stack)[0]);
            match &root.metadata.default_prim {
                Some(name) => Text::from(format!("/{}", name.trim_start_matches('/'))),
                None => {
                    let message = "references to files without a default prim: left out";
                    builder.note(NoteKind::Repaired, message, at);
                    return Ok(());
                }
            }
        } else {
            reference.prim.clone()
        };
        let is_within = |a: &str, b: &str| {
            a.strip_prefix(b).is_some_and(|rest| rest.is_empty() || rest.starts_with('/') || b == "/")
        };
        let is_cycle = |(s, path): &(StackId, Text)| {
            *s == stack && (is_within(path, &target) || is_within(&target, path))
        };
        if chain.iter().any(is_cycle) || chain.len() >= MAX_CHAIN {
            let found = format!("{:?} made of {}, itself", arc, shown(&target));
            return Err(Error::invalid(at, found, format!("at most {MAX_CHAIN} prims made of each other")));
        }
        let mapping = Rc::new(Mapping {
            from: target.clone(),
            to: node.path.clone(),
            keeps_others: is_inside,
            above: Some(Rc::clone(&node.mapping)),
        });
        let mut found = self.top(stack, arc, mapping);
        let mut names = target.split('/').filter(|name| !name.is_empty()).peekable();
        while let Some(name) = names.next() {
            found = self.step(&found, name, chain.len())?;
            self.name_arcs(&mut found, chain, builder)?;
            // Variants of the target prim are chosen later, because all opinions about it may
            // select them.
            if names.peek().is_some() {
                self.choose_variants(&mut found, builder)?;
            }
        }
        if !has_specs(&found) {
            if !matches!(arc, Arc::Inherit | Arc::Specialize) {
                let message = "references to prims that are not there: left out";
                builder.note(NoteKind::Repaired, message, at);
            }
            return Ok(());
        }
        found.depth = depth;
        node.below.push(found);
        Ok(())
    }

    /// Chooses variants until every variant set is settled, including the sets inside of chosen
    /// variants.
    fn choose_variants(&mut self, root: &mut Node, builder: &mut SceneBuilder) -> Result<()> {
        for _ in 0..MAX_VARIANTS {
            let mut selections = BTreeMap::new();
            self.selections(root, &mut selections);
            self.steps.check(&self.layers, || self.at(root))?;
            let mut chain = Vec::new();
            if !self.choose_one(root, &selections, &mut chain, builder)? {
                return Ok(());
            }
        }
        let found = format!("more than {MAX_VARIANTS} variant sets of {}", shown(&root.path));
        Err(Error::unsupported(self.at(root), found, "use fewer"))
    }

    /// Collects the selected variant of each set, by the strongest opinion.
    fn selections(&self, node: &Node, all: &mut BTreeMap<Text, Text>) {
        self.steps.add(1, 0);
        for &site in &node.specs {
            let chosen = &self.layers.spec(site).selections;
            self.steps.add(chosen.len() as u64 / 8, 0);
            for (set, choice) in chosen {
                all.entry(set.clone()).or_insert_with(|| choice.clone());
            }
        }
        node.below.iter().for_each(|below| self.selections(below, all));
    }

    /// Chooses a variant of the first set that is not yet settled; returns false if all are
    /// settled.
    fn choose_one(
        &mut self,
        node: &mut Node,
        selections: &BTreeMap<Text, Text>,
        chain: &mut Vec<(StackId, Text)>,
        builder: &mut SceneBuilder,
    ) -> Result<bool> {
        let sets = node.specs.iter().flat_map(|&site| self.layers.spec(site).variants.keys());
        let set = sets.filter(|set| !node.chosen.contains(*set)).min().cloned();
        if let Some(set) = set {
            node.chosen.insert(set.clone());
            let choice = selections.get(&set);
            let specs: Vec<(LayerId, u32)> = choice
                .into_iter()
                .flat_map(|choice| {
                    let of = |&(layer, prim): &(LayerId, u32)| {
                        let index = *self.layers.spec((layer, prim)).variants.get(&set)?.get(choice)?;
                        Some((layer, index))
                    };
                    node.specs.iter().filter_map(of).collect::<Vec<_>>()
                })
                .collect();
            if !specs.is_empty() {
                let depth = node.names();
                let mut variant = Node {
                    arc: Arc::Variant,
                    stack: node.stack,
                    path: node.path.clone(),
                    specs,
                    mapping: Rc::clone(&node.mapping),
                    below: Vec::new(),
                    depth,
                    chosen: BTreeSet::new(),
                };
                self.name_arcs(&mut variant, chain, builder)?;
                node.below.push(variant);
                node.below.sort_by_key(|n| (n.arc, std::cmp::Reverse(n.depth)));
            }
            return Ok(true);
        }
        self.steps.add(1, chain.len());
        chain.push((node.stack, node.path.clone()));
        let mut result = Ok(false);
        for below in &mut node.below {
            result = self.choose_one(below, selections, chain, builder);
            if !matches!(result, Ok(false)) {
                break;
            }
        }
        chain.pop();
        result
    }

    /// Returns true if a prim is defined and not a class.
    pub fn is_defined(&self, prim: &Prim) -> bool {
        let mut is_defined = false;
        for &(layer, spec, _) in prim.opinions() {
            match self.layers.spec((layer, spec)).specifier {
                Specifier::Over => {}
                Specifier::Def => is_defined = true,
                Specifier::Class if !is_defined => return false,
                Specifier::Class => {}
            }
        }
        is_defined
    }

    /// Node from which the prims below an instance are composed. If the instance names any site
    /// other than a variant, only the sites that it names itself count. Otherwise all sites count.
    pub fn shared(&self, node: &Node) -> Node {
        let is_own = |n: &Node| n.depth == node.names();
        if !node.below.iter().any(|n| is_own(n) && n.arc != Arc::Variant) {
            return node.clone();
        }
        let below = node.below.iter().filter(|n| is_own(n)).cloned().collect();
        Node { specs: Vec::new(), below, ..node.clone() }
    }
}
