//! `.mtlx`: MaterialX documents, which stages reference for their materials, as layers.
//!
//! A document becomes the prims that USD's own reader makes: a material `/MaterialX/Materials/NAME`
//! for each `surfacematerial`, with the nodes and node graphs that it uses below it. A node is a
//! `Shader` whose `info:id` is the node definition, or `ND_CATEGORY_TYPE` where the file names
//! none. Looks are ignored: stages bind materials themselves.
//!
//! # Guarantee
//! Any bytes give a layer, or an error with its line. Within a material, each node is made at most
//! once; all materials together have at most [`MAX_NODES`] nodes.
//!
//! # Differences from the format
//! Included files (`xi:include`) are not read; their nodes count as unsupported.
//!
//! Source: [^materialx2024]. Held to this by `usd_materialx` and `damaged_usd` of the suite.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

use roxmltree::Node;

use super::layer::{Layer, Metadata, PrimSpec, Property, Specifier, Stored};
use super::value::{ListOp, Text, Value};
use crate::color::srgb_decode;
use crate::error::{Error, Location, Result};
use crate::io::text::{decoded, utf8_or_latin1};
use crate::io::xml;

/// Largest number of nodes of all materials together.
const MAX_NODES: usize = 1 << 16;

/// Longest name of a material, a graph or a node (bytes); chosen.
const MAX_NAME: usize = 1024;

/// Returns true if a file begins like a document of MaterialX.
pub(super) fn is_document(bytes: &[u8]) -> bool {
    let bytes = decoded(bytes);
    let start = bytes.trim_ascii_start();
    start.starts_with(b"<?xml") || start.starts_with(b"<materialx") || start.starts_with(b"<!--")
}

/// Reads a document.
pub(super) fn parse(bytes: &[u8], name: &Path) -> Result<Layer> {
    let bytes = decoded(bytes);
    let text = utf8_or_latin1(&bytes);
    let document = xml::parse(&text, name)?;
    let root = document.root_element();
    if root.tag_name().name() != "materialx" {
        let found = format!("the root element <{}>", root.tag_name().name());
        return Err(Error::invalid(Location::file(name), found, "<materialx version=\"…\">"));
    }
    let layer = Layer {
        name: name.to_owned(),
        prims: vec![PrimSpec::default()],
        metadata: Metadata { default_prim: Some("MaterialX".into()), ..Metadata::default() },
        binary: None,
    };
    let lines = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
    let scopes = elements(root).filter(|node| is(node, "nodegraph")).chain([root]);
    let all = scopes.flat_map(|scope| elements(scope).map(move |node| (scope, node)));
    let by_name = all
        .filter_map(|(scope, node)| Some(((scope.range().start, node.attribute("name")?), node)))
        .collect();
    let mut making = Making { root, layer, lines, by_name };
    let top = making.prim(0, "MaterialX", None, None);
    let materials = making.prim(top, "Materials", None, None);
    for material in elements(root).filter(|node| is(node, "surfacematerial")) {
        making.material(materials, material)?;
    }
    Ok(making.layer)
}

fn elements<'a, 'd>(of: Node<'a, 'd>) -> impl Iterator<Item = Node<'a, 'd>> {
    of.children().filter(Node::is_element)
}

fn is(node: &Node<'_, '_>, tag: &str) -> bool {
    node.tag_name().name() == tag
}

/// Attribute of an element, or of the nearest element around it that has the attribute.
fn inherited<'a>(node: Node<'a, '_>, attribute: &str) -> Option<&'a str> {
    node.ancestors().find_map(|about| about.attribute(attribute))
}

struct Making<'a, 'd> {
    root: Node<'a, 'd>,
    layer: Layer,
    /// Byte offsets of the beginnings of lines.
    lines: Vec<usize>,
    /// Elements by name, and by the byte offset of the enclosing document or graph.
    by_name: BTreeMap<(usize, &'a str), Node<'a, 'd>>,
}

/// A node or graph that is still to be made. Fields: enclosing element, parent prim, path of the
/// parent, and the name of the node or graph.
struct Waiting<'a, 'd> {
    scope: Node<'a, 'd>,
    below: u32,
    path: String,
    name: String,
}

impl<'a, 'd> Making<'a, 'd> {
    fn line(&self, node: Node<'_, '_>) -> u32 {
        self.lines.partition_point(|&start| start <= node.range().start) as u32
    }

    /// Refuses a long name, because every input below an element of this name stores the whole
    /// path.
    fn check_name(&self, name: &str, of: Node<'_, '_>) -> Result<()> {
        if name.len() <= MAX_NAME {
            return Ok(());
        }
        let at = Location::line(&self.layer.name, self.line(of));
        Err(Error::invalid(at, format!("a name of {} bytes", name.len()), format!("at most {MAX_NAME}")))
    }

    fn named(&self, scope: Node<'a, 'd>, name: &str) -> Option<Node<'a, 'd>> {
        self.by_name.get(&(scope.range().start, name)).copied()
    }

    fn prim(&mut self, below: u32, name: &str, type_name: Option<&str>, of: Option<Node<'_, '_>>) -> u32 {
        let line = of.map(|node| self.line(node));
        let type_name = type_name.map(Text::from);
        let index =
            self.layer.push(PrimSpec { line, specifier: Specifier::Def, type_name, ..PrimSpec::default() });
        self.layer.prims[below as usize].add_child(&name.into(), index);
        index
    }

    fn property(&mut self, prim: u32, name: &str, property: Property) {
        self.layer.prims[prim as usize].properties.insert(name.into(), property);
    }

    fn material(&mut self, materials: u32, material: Node<'a, 'd>) -> Result<()> {
        let Some(name) = material.attribute("name") else { return Ok(()) };
        self.check_name(name, material)?;
        let path = format!("/MaterialX/Materials/{name}");
        let prim = self.prim(materials, name, Some("Material"), Some(material));
        let mut waiting = VecDeque::new();
        let scope = self.root;
        for input in elements(material).filter(|input| is(input, "input")) {
            let of = Waiting { scope, below: prim, path: path.clone(), name: name.to_owned() };
            let property = self.input(input, &of, &mut waiting);
            if input.attribute("name") == Some("surfaceshader") {
                self.property(prim, "outputs:mtlx:surface", property);
            }
        }
        while let Some(node) = waiting.pop_front() {
            self.node(&node, &mut waiting)?;
        }
        Ok(())
    }

    /// Makes a node or a graph, unless its material already has it.
    fn node(&mut self, waiting: &Waiting<'a, 'd>, more: &mut VecDeque<Waiting<'a, 'd>>) -> Result<()> {
        let Waiting { scope, below, path, name } = waiting;
        if self.layer.prims[*below as usize].by_name.contains_key(name.as_str()) {
            return Ok(());
        }
        if self.layer.prims.len() >= MAX_NODES {
            let found = format!("more than {MAX_NODES} nodes");
            return Err(Error::invalid(Location::file(&self.layer.name), found, "fewer"));
        }
        let node = self.named(*scope, name);
        self.check_name(name, node.unwrap_or(*scope))?;
        if let Some(graph) = node.filter(|node| is(node, "nodegraph")) {
            self.graph(graph, waiting, more);
            return Ok(());
        }
        let prim = self.prim(*below, name, Some("Shader"), node);
        let Some(node) = node else { return Ok(()) };
        let kind = node.attribute("type").unwrap_or_default();
        let id = match node.attribute("nodedef") {
            Some(definition) => definition.to_owned(),
            None => format!("ND_{}_{kind}", node.tag_name().name()),
        };
        let id = Stored::Value(Value::Text(id.into()));
        self.property(prim, "info:id", Property { value: Some(id), ..Property::default() });
        for input in elements(node).filter(|input| is(input, "input")) {
            let Some(input_name) = input.attribute("name") else { continue };
            let of = Waiting { scope: *scope, below: *below, path: path.clone(), name: name.clone() };
            let mut property = self.input(input, &of, more);
            if kind.starts_with("color") && input.attribute("type") == Some("filename") {
                property.color_space = inherited(input, "colorspace").map(Text::from);
            }
            self.property(prim, &format!("inputs:{input_name}"), property);
        }
        Ok(())
    }

    /// Value of an input, or its connection to a node, which is then queued.
    fn input(
        &mut self,
        input: Node<'a, 'd>,
        of: &Waiting<'a, 'd>,
        more: &mut VecDeque<Waiting<'a, 'd>>,
    ) -> Property {
        let line = Some(self.line(input));
        let output = input.attribute("output").unwrap_or("out");
        let from = |path: String| Property {
            line,
            connections: ListOp { explicit: Some(vec![path.into()]), ..ListOp::default() },
            ..Property::default()
        };
        if let Some(node) = input.attribute("nodegraph").or(input.attribute("nodename")) {
            let Waiting { scope, below, ref path, .. } = *of;
            more.push_back(Waiting { scope, below, path: path.clone(), name: node.to_owned() });
            return from(format!("{path}/{node}.outputs:{output}"));
        }
        if let Some(name) = input.attribute("interfacename") {
            return from(format!("{}.inputs:{name}", of.path));
        }
        let value = input.attribute("value").map(|text| Stored::Value(value(text, input)));
        Property { line, value, ..Property::default() }
    }

    /// Makes a node graph with its inputs and outputs.
    fn graph(
        &mut self,
        graph: Node<'a, 'd>,
        waiting: &Waiting<'a, 'd>,
        more: &mut VecDeque<Waiting<'a, 'd>>,
    ) {
        let Waiting { scope, below, path, name } = waiting;
        let prim = self.prim(*below, name, Some("NodeGraph"), Some(graph));
        let inside = format!("{path}/{name}");
        for port in elements(graph) {
            let Some(port_name) = port.attribute("name") else { continue };
            let (scope, below, path, prefix) = match port.tag_name().name() {
                // Inputs connect to elements beside the graph, outputs to elements in it.
                "input" => (*scope, *below, path, "inputs"),
                "output" => (graph, prim, &inside, "outputs"),
                _ => continue,
            };
            let of = Waiting { scope, below, path: path.clone(), name: port_name.to_owned() };
            let property = self.input(port, &of, more);
            self.property(prim, &format!("{prefix}:{port_name}"), property);
        }
    }
}

/// Value of an input, of the type that the input declares.
fn value(text: &str, input: Node<'_, '_>) -> Value {
    let kind = input.attribute("type").unwrap_or_default();
    let numbers = || {
        let all = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|word| !word.is_empty());
        all.map(|word| word.parse::<f64>().ok()).collect::<Option<Vec<f64>>>()
    };
    match kind {
        "filename" => {
            Value::Text(format!("{}{text}", inherited(input, "fileprefix").unwrap_or_default()).into())
        }
        "boolean" => Value::Number(f64::from(u8::from(text.trim() == "true"))),
        "float" | "integer" => text.trim().parse().map_or(Value::Other, Value::Number),
        _ if kind.starts_with("color") => numbers().map_or(Value::Other, |mut all| {
            if inherited(input, "colorspace").is_some_and(|space| space.starts_with("srgb")) {
                all.iter_mut().take(3).for_each(|v| *v = f64::from(srgb_decode(*v as f32)));
            }
            Value::Tuple(all)
        }),
        _ if kind.starts_with("vector") => numbers().map_or(Value::Other, Value::Tuple),
        _ => Value::Text(text.into()),
    }
}
