//! Validation of trees: checks the properties that all readers of a tree rely on.
//!
//! For each node: its range consists of the ranges of its two children, one after the other, and
//! neither is empty. Its sums are the sums of its children's. Its bounds contain the children's
//! bounds and every single light or point below. The time is `O(n log n)` for trees of logarithmic
//! depth.

use super::build;
use super::gather_tree::GatherTree;
use super::light_tree::{LightCluster, LightNode, LightTree};
use super::prefix::PrefixSums;
use crate::bounds::{LightBounds, LightShape};
use crate::math::{Aabb, Cone};
use crate::vpl::{Vpl, VplKind};

/// Allowed relative error of the sum of two numbers: a few roundings of `f64`.
const SUM_ERROR: f64 = 1e-14;
/// Share of the total weight that sums may lose to rounding: 2⁻¹⁰⁰.
const SMALLEST_SHARE: f64 = 1.0 / (1u128 << 100) as f64;
/// Allowed error of a cosine computed in `f64` when cones are compared.
const COSINE_ERROR: f64 = 1e-12;

/// Structure of a node of either tree.
#[derive(Clone, Copy)]
struct Shape {
    first: u32,
    count: u32,
    children: Option<[u32; 2]>,
}

impl LightTree {
    /// Checks the structure, the sums and the bounds of the tree.
    ///
    /// # Errors
    /// The first node found to be wrong, and its fault.
    pub fn validate(&self) -> Result<(), String> {
        let expected = self.lights.len() - self.roots().count();
        if self.nodes.len() != expected {
            return Err(format!("{} inner nodes; expected {expected}", self.nodes.len()));
        }
        validate_sums(&self.sums, self.lights.luminances(0..self.lights.len()))?;
        let mut end = 0;
        for (instant, root) in self.roots() {
            if root.first != end {
                return Err(format!("the lights of instant {instant} begin at {}, not {end}", root.first));
            }
            end += root.count;
        }
        if end as usize != self.lights.len() {
            return Err(format!("{end} lights under roots, of {}", self.lights.len()));
        }
        let mut waiting: Vec<LightCluster> = self.roots().map(|(_, root)| root).collect();
        while let Some(cluster) = waiting.pop() {
            let wrong = |what: &str| Err(format!("{cluster:?}: {what}"));
            let bounds = self.bounds(&cluster);
            let mut lights = cluster.lights().map(|light| self.light(light as u32));
            if let Some(light) = lights.find(|light| !holds(&bounds, light)) {
                return wrong(&format!("{bounds:?} does not hold {light:?}"));
            }
            if let Some(LightNode { left, .. }) = self.nodes.get(cluster.number())
                && !(1..cluster.count).contains(left)
            {
                return wrong(&format!("{left} lights in its first half"));
            }
            let Some(children) = self.children(&cluster) else { continue };
            if !children.iter().all(|child| nests(&bounds, &self.bounds(child))) {
                return wrong("bounds do not hold those of its children");
            }
            let luminance: f64 = children.iter().map(|child| self.luminance(child)).sum();
            if self.luminance(&cluster) != luminance || luminance <= 0.0 {
                return wrong(&format!("luminance should be {luminance}"));
            }
            waiting.extend(children);
        }
        Ok(())
    }
}

impl<B> GatherTree<B> {
    /// Checks the structure, the boxes and the weights of the tree.
    ///
    /// # Errors
    /// The first node found to be wrong, and its fault.
    pub fn validate(&self) -> Result<(), String> {
        let shapes = self.nodes.iter().map(|node| Shape {
            first: node.first,
            count: node.count,
            children: node.children,
        });
        validate_shape(shapes, self.roots().iter().map(|(_, root)| *root), self.points.len())?;
        for &(instant, root) in self.roots() {
            let node = &self.nodes[root as usize];
            let points = &self.points[node.first as usize..(node.first + node.count) as usize];
            if let Some(point) = points.iter().find(|point| point.instant != instant) {
                return Err(format!("a point of instant {} in the tree of {instant}", point.instant));
            }
        }
        validate_sums(&self.sums, self.points.iter().map(|point| point.weight.max_channel()))?;
        for (k, node) in self.nodes.iter().enumerate() {
            let points = &self.points[node.first as usize..node.first as usize + node.count as usize];
            if node.aabb != Aabb::of_points(points.iter().map(|point| point.position)) {
                return Err(format!("node {k}: not the box of its points: {node:?}"));
            }
            let weight: f64 = points.iter().map(|point| f64::from(point.weight.max_channel())).sum();
            if !((f64::from(node.weight) - weight).abs() <= f64::from(f32::EPSILON) * weight && weight > 0.0)
            {
                return Err(format!("node {k}: weight should be {weight}: {node:?}"));
            }
        }
        Ok(())
    }
}

/// Checks the ranges of nodes in depth-first order over `items` items; there is one tree below each
/// root.
fn validate_shape(
    nodes: impl Iterator<Item = Shape>,
    roots: impl Iterator<Item = u32>,
    items: usize,
) -> Result<(), String> {
    let all: Vec<Shape> = nodes.collect();
    // Nodes that come next in depth-first order: their index, first item, and number of items
    // according to their parent.
    let mut waiting: Vec<(u32, u32, u32)> = Vec::new();
    let (mut expected, mut end) = (0, 0);
    for root in roots {
        let Some(node) = all.get(root as usize) else { return Err(format!("no node {root}, a root")) };
        waiting.push((root, end, node.count));
        expected += 2 * node.count as usize - 1;
        end += node.count;
    }
    if end as usize != items || all.len() != expected {
        return Err(format!("{} nodes over {end} of {items} items; expected {expected}", all.len()));
    }
    waiting.reverse();
    for (k, node) in (0u32..).zip(&all) {
        let wrong = |what: String| Err(format!("node {k}: {what}"));
        let Some((number, first, count)) = waiting.pop() else {
            return wrong("is nobody's child".into());
        };
        if (number, first, count) != (k, node.first, node.count) {
            return wrong(format!("{count} items from {first} at node {number} are what its parent expects"));
        }
        match node.children {
            None if count == 1 => {}
            None => return wrong(format!("a leaf of {count} items")),
            Some([a, b]) => {
                let (Some(left), Some(right)) = (all.get(a as usize), all.get(b as usize)) else {
                    return wrong(format!("children {a} and {b} are not in the tree"));
                };
                if left.count == 0 || right.count == 0 || left.count.checked_add(right.count) != Some(count) {
                    return wrong(format!("{} and {} items below, {count} in all", left.count, right.count));
                }
                waiting.push((b, first + left.count, right.count));
                waiting.push((a, first, left.count));
            }
        }
    }
    match waiting.pop() {
        None => Ok(()),
        Some((number, ..)) => Err(format!("node {number} is missing")),
    }
}

fn validate_sums(sums: &PrefixSums, weights: impl ExactSizeIterator<Item = f32>) -> Result<(), String> {
    if sums.len() != weights.len() {
        return Err(format!("sums of {} weights, not of {}", sums.len(), weights.len()));
    }
    let lost = SMALLEST_SHARE * sums.weight(0, sums.len() as u32);
    for (i, weight) in (0..).zip(weights) {
        let (found, expected) = (sums.weight(i, 1), f64::from(weight));
        if !((found - expected).abs() <= SUM_ERROR * expected + lost && expected > 0.0) {
            return Err(format!("item {i}: weight {found}, should be {expected}"));
        }
    }
    Ok(())
}

/// Returns true if bounds contain a light.
fn holds(bounds: &LightBounds, light: &Vpl) -> bool {
    let direction = light.direction;
    let in_shape = match (bounds.shape, light.kind) {
        (LightShape::Mixed { peak }, _) => peak >= build::leaf(light).0.shape.upper_peak(),
        (LightShape::Omni, VplKind::Omni) => true,
        (LightShape::Volume { directions, asymmetry: [least, largest] }, VplKind::Volume(phase)) => {
            directions.contains(direction) && (least..=largest).contains(&phase.asymmetry)
        }
        (LightShape::Oriented(cone), VplKind::Oriented)
        | (LightShape::Directional(cone), VplKind::Directional) => cone.contains(direction),
        (LightShape::Spot { axes, cos_outer }, VplKind::Spot(falloff)) => {
            axes.contains(direction) && cos_outer <= falloff.cos_outer
        }
        (LightShape::Spot { axes, cos_outer }, VplKind::Image(beam)) => {
            axes.contains(direction) && cos_outer <= beam.cos_outer
        }
        _ => false,
    };
    in_shape && (light.kind == VplKind::Directional || bounds.aabb.contains(light.position))
}

/// Returns true if the bounds of a cluster contain those of one of its halves.
fn nests(parent: &LightBounds, child: &LightBounds) -> bool {
    let (outer, inner) = (parent.aabb, child.aabb);
    let box_nests = outer.union(inner) == outer;
    box_nests
        && match (parent.shape, child.shape) {
            (LightShape::Mixed { peak }, inner) => peak >= inner.upper_peak(),
            (LightShape::Omni, LightShape::Omni) => true,
            (
                LightShape::Volume { directions: outer, asymmetry: [a, b] },
                LightShape::Volume { directions: inner, asymmetry: [c, d] },
            ) => cone_nests(outer, inner) && a <= c && d <= b,
            (LightShape::Oriented(outer), LightShape::Oriented(inner))
            | (LightShape::Directional(outer), LightShape::Directional(inner)) => cone_nests(outer, inner),
            (
                LightShape::Spot { axes: outer, cos_outer: a },
                LightShape::Spot { axes: inner, cos_outer: b },
            ) => cone_nests(outer, inner) && a <= b,
            _ => false,
        }
}

/// Returns true if the angle between the axes plus the half-angle of `inner` is at most that of
/// `outer`, up to the rounding of cosines.
fn cone_nests(outer: Cone, inner: Cone) -> bool {
    if outer.cos <= -1.0 || inner.is_empty() {
        return true;
    }
    let (a, b) = (outer.axis.as_dvec3().normalize(), inner.axis.as_dvec3().normalize());
    let (cos_between, sin_between) = (a.dot(b), a.cross(b).length());
    let cos_inner = f64::from(inner.cos);
    let sin_inner = ((1.0 - cos_inner) * (1.0 + cos_inner)).max(0.0).sqrt();
    let beyond_half = sin_between * cos_inner + cos_between * sin_inner < 0.0;
    let cos_sum = cos_between * cos_inner - sin_between * sin_inner;
    !beyond_half && cos_sum >= f64::from(outer.cos) - COSINE_ERROR
}
