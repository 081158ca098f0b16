//! The gather tree: a binary tree over the gather points of one pixel. If the points belong to
//! several instants, there is one tree for each.
//!
//! Points are split in six dimensions (Walter 2006, section 4.1): position (m), and a direction
//! that is scaled by the diagonal of the box around all points. Thus a rotation by one radian
//! counts as much as the extent of the whole pixel's footprint. The direction is the shading normal
//! for diffuse surfaces and the mirror direction for other surfaces. In media it is the direction
//! of the incoming path, multiplied by the mean cosine of the phase function. A node is split in
//! the middle of its longest extent. If all points would be on one side, or beyond a depth that
//! only degenerate input reaches, it is split into halves of equal count.
//!
//! Every node has a bound of the material of its points: leaves have the bound of their point,
//! other nodes the merged bounds of their children. Nodes are in depth-first order, and each node
//! is a range of the sorted points, as in the light tree.
//!
//! # Held to this by
//! `tree::tests::gather`.

use super::prefix::PrefixSums;
use crate::bsdf::Bsdf;
use crate::gather::GatherPoint;
use crate::math::{Aabb, Vec3};

/// Depth from which nodes are split into halves of equal count.
const MAX_UNEVEN_DEPTH: u32 = 32;

/// A cluster of gather points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GatherNode {
    /// Box around the positions (m).
    pub aabb: Aabb,
    /// Sum over the points of the largest channel of the weight; above zero.
    pub weight: f32,
    /// First point, in sorted order.
    pub first: u32,
    /// Number of points; one in a leaf.
    pub count: u32,
    /// Children, in the order of their points; `None` in a leaf.
    pub children: Option<[u32; 2]>,
}

/// A tree over the gather points of a pixel, with a bound `B` of the material at each node.
#[derive(Clone, Debug)]
pub struct GatherTree<B> {
    pub(super) nodes: Vec<GatherNode>,
    /// Bounds of the nodes' materials, in reverse order of the nodes.
    materials: Vec<B>,
    pub(super) points: Vec<GatherPoint>,
    /// Index of each point in the input.
    sources: Vec<u32>,
    pub(super) sums: PrefixSums,
    /// Instant and root of each tree, in the order of instants.
    roots: Vec<(u16, u32)>,
}

/// Position and scaled direction of a point, by which it is sorted.
#[derive(Clone, Copy)]
struct Item {
    key: [f32; 6],
    point: u32,
}

impl<B: Clone> GatherTree<B> {
    /// Builds the tree over those of `points` whose weight is positive; other points contribute
    /// nothing and are omitted.
    ///
    /// * `bound_of`: bound of the material of one point; called once per point.
    /// * `merge`: extends the first bound to the points of the second.
    pub fn build(
        points: &[GatherPoint],
        bound_of: impl Fn(&GatherPoint) -> B,
        merge: impl Fn(&mut B, &B),
    ) -> Self {
        let mut items = items(points);
        // The trees of all instants follow one another.
        items.sort_by_key(|item| points[item.point as usize].instant);
        let (mut spans, mut roots, mut first) = (Vec::new(), Vec::new(), 0);
        for of_instant in
            items.chunk_by_mut(|a, b| points[a.point as usize].instant == points[b.point as usize].instant)
        {
            roots.push((points[of_instant[0].point as usize].instant, spans.len() as u32));
            sort(of_instant, first, &mut spans);
            first += of_instant.len();
        }
        let points: Vec<GatherPoint> = items.iter().map(|item| points[item.point as usize]).collect();
        let sums = PrefixSums::new(points.iter().map(|point| point.weight.max_channel()));
        let mut nodes: Vec<GatherNode> = Vec::with_capacity(spans.len());
        nodes.extend(spans.iter().enumerate().map(|(k, &[first, count])| GatherNode {
            aabb: Aabb::EMPTY,
            weight: 0.0,
            first,
            count,
            children: (count > 1).then(|| [k as u32 + 1, k as u32 + 2 * spans[k + 1][1]]),
        }));
        // Sums are in double precision until they are complete.
        let mut weights = vec![0.0f64; nodes.len()];
        let mut materials: Vec<B> = Vec::with_capacity(nodes.len());
        let last = nodes.len().saturating_sub(1);
        for k in (0..nodes.len()).rev() {
            if let Some(children) = nodes[k].children {
                let [a, b] = children.map(|child| child as usize);
                nodes[k].aabb = nodes[a].aabb.union(nodes[b].aabb);
                weights[k] = weights[a] + weights[b];
                let mut material = materials[last - a].clone();
                merge(&mut material, &materials[last - b]);
                materials.push(material);
            } else {
                let point = &points[nodes[k].first as usize];
                nodes[k].aabb = Aabb { lo: point.position, hi: point.position };
                weights[k] = f64::from(point.weight.max_channel());
                materials.push(bound_of(point));
            }
            nodes[k].weight = weights[k] as f32;
        }
        let sources = items.into_iter().map(|item| item.point).collect();
        Self { nodes, materials, points, sources, sums, roots }
    }
}

impl<B> GatherTree<B> {
    /// All nodes, one tree after another. Each tree starts with its root, and parents come before
    /// their children. Empty if no point has weight.
    pub fn nodes(&self) -> &[GatherNode] {
        &self.nodes
    }

    /// Index of the root of the first tree, which is the only one if nothing moves; `None` if there
    /// are no points.
    pub fn root(&self) -> Option<u32> {
        self.roots.first().map(|(_, root)| *root)
    }

    /// Roots of all trees, each with the number of its instant.
    pub fn roots(&self) -> &[(u16, u32)] {
        &self.roots
    }

    /// Bound of the material of a node's points.
    pub fn material(&self, node: u32) -> &B {
        &self.materials[self.nodes.len() - 1 - node as usize]
    }

    /// The point at an index in the sorted order.
    pub fn point(&self, sorted: u32) -> &GatherPoint {
        &self.points[sorted as usize]
    }

    /// Index in the input of the point at an index in the sorted order.
    pub fn source(&self, sorted: u32) -> u32 {
        self.sources[sorted as usize]
    }

    /// All points in sorted order.
    pub fn points(&self) -> &[GatherPoint] {
        &self.points
    }

    /// Draws a point of a node by the uniform number `u` in `[0, 1)`, and returns its index in the
    /// sorted order. The probability of a point is its weight divided by the node's.
    pub fn draw(&self, node: u32, u: f64) -> u32 {
        let node = &self.nodes[node as usize];
        self.sums.draw(node.first, node.count, u)
    }
}

/// Points that have weight, as items in the space that is split.
fn items(points: &[GatherPoint]) -> Vec<Item> {
    let has_weight = |point: &GatherPoint| point.weight.max_channel() > 0.0;
    let positions = points.iter().filter(|point| has_weight(point)).map(|point| point.position);
    let scale = Aabb::of_points(positions).diagonal();
    let mut items = Vec::with_capacity(points.len());
    for (point, of_point) in (0..).zip(points) {
        if has_weight(of_point) {
            let (p, d) = (of_point.position, direction(of_point));
            // If the points of a pixel coincide, they are split by direction alone.
            let d = if scale > 0.0 { d * scale } else { d };
            items.push(Item { key: [p.x, p.y, p.z, d.x, d.y, d.z], point });
        }
    }
    items
}

/// Direction around which a point reflects or scatters.
fn direction(point: &GatherPoint) -> Vec3 {
    if let Some(phase) = point.phase {
        // The axis of the phase function's lobe. The weaker the lobe, the less the direction
        // matters.
        return point.before() * phase.asymmetry;
    }
    match point.bsdf {
        Bsdf::Lambert(_) => point.frame.n,
        _ => point.frame.to_world(Vec3::new(-point.wo.x, -point.wo.y, point.wo.z)),
    }
}

/// Sorts items into a tree, and appends the first item and the number of items of each node in
/// depth-first order. `begin` is the index of the first item.
fn sort(items: &mut [Item], begin: usize, spans: &mut Vec<[u32; 2]>) {
    spans.reserve((2 * items.len()).saturating_sub(1));
    let mut waiting = Vec::with_capacity(64);
    if !items.is_empty() {
        waiting.push((0, items.len(), 0));
    }
    while let Some((first, count, depth)) = waiting.pop() {
        spans.push([(begin + first) as u32, count as u32]);
        if count > 1 {
            let left = split(&mut items[first..first + count], depth);
            waiting.push((first + left, count - left, depth + 1));
            waiting.push((first, left, depth + 1));
        }
    }
}

/// Moves the items of the left child to the front and returns their number, which is between 1 and
/// `items.len() - 1`.
fn split(items: &mut [Item], depth: u32) -> usize {
    let count = items.len();
    if count == 2 {
        return 1;
    }
    let (mut lo, mut hi) = (items[0].key, items[0].key);
    for item in &items[1..] {
        for axis in 0..6 {
            lo[axis] = lo[axis].min(item.key[axis]);
            hi[axis] = hi[axis].max(item.key[axis]);
        }
    }
    let extent = |axis: usize| hi[axis] - lo[axis];
    let axis = (1..6).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best });
    if extent(axis) <= 0.0 {
        return count / 2;
    }
    if depth < MAX_UNEVEN_DEPTH {
        let middle = 0.5 * lo[axis] + 0.5 * hi[axis];
        let mut left = 0;
        for i in 0..count {
            if items[i].key[axis] < middle {
                items.swap(i, left);
                left += 1;
            }
        }
        if left > 0 && left < count {
            return left;
        }
    }
    let by_key = |a: &Item, b: &Item| a.key[axis].total_cmp(&b.key[axis]).then(a.point.cmp(&b.point));
    items.select_nth_unstable_by(count / 2, by_key);
    count / 2
}
