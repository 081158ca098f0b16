//! How visible clusters of lights are from parts of the image: what pilot segments, drawn for no estimate, tell.
//!
//! The image is divided into cells of [`CELL`] × [`CELL`] pixels, the lights into up to [`CLUSTERS`] clusters of the light tree. For every cell
//! and cluster [`TRIALS`] segments are traced, from gather points of random pixels of the cell to random lights of the cluster. Around a
//! pixel, those of its own and the eight cells about it count:
//!
//! ```text
//! p = (½ + Σ V) / (1 + trials)
//! ```
//!
//! The cost is `CLUSTERS · TRIALS / CELL²` = 16 segments a pixel at most. Cells are measured when they are first asked for.
//!
//! # Independence
//! Pilot points, lights and pixels come from streams of their own ([`Purpose::Guidance`]); a cell is a function of the image and its place,
//! not of who asks first. So what a pixel learns here is independent of all samples of its estimate.

use std::sync::OnceLock;

use super::clusters::{Clusters, Pair};
use super::refinement::{Expectation, Order};
use crate::accel::{SegmentBatch, Tracer};
use crate::bounds::UpperMaterial;
use crate::gather::{GatherOptions, View};
use crate::rng::{self, Purpose, Stream};
use crate::transport::Transport;
use crate::tree::LightTree;

/// Side of a cell (pixels).
const CELL: u32 = 16;
/// Clusters of lights.
const CLUSTERS: usize = 512;
/// Segments for each cell and cluster.
const TRIALS: u64 = 8;
/// Visibility below which none is taken: what no pilot segment has seen may still be seen by the pixel.
const LEAST_VISIBILITY: f64 = 0.02;
/// `c`, the variance of an unoccluded term in units of `R²`. A quarter is the most that it can be; larger values trust visibility less.
const UNOCCLUDED_VARIANCE: f64 = 0.5;
/// Terms up to which a pair is evaluated as a whole: as many as would be drawn from it.
const FINEST: u64 = 2;
/// Nodes of the light tree that no cluster holds.
const ABOVE: u32 = u32::MAX;

/// Pilot visibility of an image.
#[derive(Debug)]
pub struct PilotVisibility {
    /// Nodes of the light tree.
    clusters: Vec<u32>,
    /// By node of the light tree.
    cluster_of: Vec<u32>,
    /// Row by row.
    cells: Vec<OnceLock<Vec<Tally>>>,
    columns: u32,
    rows: u32,
    seed: u64,
}

/// Trials of a cell and a cluster.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    visible: f32,
    trials: f32,
}

/// What is needed to trace pilot segments.
#[derive(Clone, Copy, Debug)]
pub struct Pilot<'a> {
    /// Rays.
    pub tracer: &'a Tracer,
    /// Gather points.
    pub view: View<'a>,
    /// Lights.
    pub lights: &'a LightTree,
    /// Which lights can light a point at all.
    pub transport: Transport,
}

impl PilotVisibility {
    /// For an image of `size` pixels lit by these lights; traces nothing yet.
    pub fn new(lights: &LightTree, size: [u32; 2], seed: u64) -> Self {
        let clusters = clusters(lights);
        let mut cluster_of = vec![ABOVE; lights.nodes().len()];
        for (number, &node) in (0..).zip(&clusters) {
            // Nodes are in depth-first order: a subtree over n lights is 2n − 1 nodes in a row.
            let length = 2 * lights.nodes()[node as usize].count - 1;
            cluster_of[node as usize..(node + length) as usize].fill(number);
        }
        let [columns, rows] = size.map(|side| side.div_ceil(CELL));
        let cells = (0..columns as usize * rows as usize).map(|_| OnceLock::new()).collect();
        Self { clusters, cluster_of, cells, columns, rows, seed }
    }

    /// The order of refinement that it suggests for a pixel.
    pub fn order_at(&self, pilot: &Pilot<'_>, [x, y]: [u32; 2]) -> ByVisibility<'_> {
        let (column, row) = (x / CELL, y / CELL);
        let mut sums = vec![Tally { visible: 0.5, trials: 1.0 }; self.clusters.len()];
        for row in row.saturating_sub(1)..(row + 2).min(self.rows) {
            for column in column.saturating_sub(1)..(column + 2).min(self.columns) {
                let cell = &self.cells[(row * self.columns + column) as usize];
                let tallies = cell.get_or_init(|| self.measure(pilot, [column, row]));
                for (sum, tally) in sums.iter_mut().zip(tallies) {
                    sum.visible += tally.visible;
                    sum.trials += tally.trials;
                }
            }
        }
        let visibility = sums.iter().map(|t| t.visible / t.trials).collect();
        ByVisibility { cluster_of: &self.cluster_of, visibility }
    }

    fn measure(&self, pilot: &Pilot<'_>, [column, row]: [u32; 2]) -> Vec<Tally> {
        let [width, height] = pilot.view.size;
        let key = rng::key(self.seed, Purpose::Guidance, u64::from(row) << 32 | u64::from(column));
        let mut stream = Stream::new(key, Purpose::Guidance, 0);
        let gather = GatherOptions { points: 1, ..pilot.view.gather };
        let mut tallies = vec![Tally::default(); self.clusters.len()];
        let mut batch = SegmentBatch::default();
        let mut asked = Vec::new();
        for trial in 0..TRIALS {
            let within =
                |first: u32, end: u32, s: &mut Stream| first + s.below(u64::from(end - first)) as u32;
            let x = within(column * CELL, ((column + 1) * CELL).min(width), &mut stream);
            let y = within(row * CELL, ((row + 1) * CELL).min(height), &mut stream);
            let view = View { gather, seed: key.wrapping_add(trial), ..pilot.view };
            let pixel = view.pixel(pilot.tracer, [x, y]);
            let Some(point) = pixel.points.first() else { continue };
            for (number, &node) in (0u32..).zip(&self.clusters) {
                let light = pilot.lights.light(pilot.lights.draw(node, stream.uniform_f64()));
                if !pilot.transport.unoccluded(point, light).is_black() {
                    asked.push(number);
                    batch.push_fan(light.apex(), [point.position]);
                }
            }
        }
        let mut visibility = Vec::new();
        pilot.tracer.visibility(&batch, &mut visibility);
        for (&number, &v) in asked.iter().zip(&visibility) {
            let tally = &mut tallies[number as usize];
            tally.visible += v;
            tally.trials += 1.0;
        }
        tallies
    }
}

/// Up to [`CLUSTERS`] nodes that hold every light once: always the node of most luminance times extent is split.
fn clusters(lights: &LightTree) -> Vec<u32> {
    let importance = |node: u32| {
        let node = &lights.nodes()[node as usize];
        match node.children {
            None => -1.0,
            Some(_) if node.bounds.reaches_infinity() => f64::INFINITY,
            Some(_) => node.luminance * f64::from(node.bounds.aabb.diagonal()),
        }
    };
    let mut nodes: Vec<(f64, u32)> = lights.root().into_iter().map(|root| (importance(root), root)).collect();
    while nodes.len() < CLUSTERS {
        let Some((at, _)) = nodes.iter().enumerate().max_by(|a, b| a.1.0.total_cmp(&b.1.0)) else { break };
        let Some(children) = lights.nodes()[nodes[at].1 as usize].children else { break };
        nodes.swap_remove(at);
        nodes.extend(children.map(|child| (importance(child), child)));
    }
    let mut nodes: Vec<u32> = nodes.into_iter().map(|(_, node)| node).collect();
    nodes.sort_unstable();
    nodes
}

/// An order by the standard deviation that pairs are expected to have, from their bounds and from pilot visibility `p`.
///
/// ```text
/// rank = R √(p (1 − p) + c p)          importance_range = R √p
/// ```
///
/// A term is `V u` with `0 ≤ u ≤ R`: `p (1 − p) R²` is its variance if `u = R` throughout, `c p R²` stands for that of `u`.
#[derive(Clone, Debug)]
pub struct ByVisibility<'a> {
    cluster_of: &'a [u32],
    /// By cluster.
    visibility: Vec<f32>,
}

impl Order for ByVisibility<'_> {
    fn expect<B: UpperMaterial>(&mut self, clusters: &Clusters<'_, B>, pair: &Pair) -> Expectation {
        let upper = clusters.upper(pair);
        let cluster = self.cluster_of[pair.light as usize];
        if cluster == ABOVE {
            return Expectation { rank: upper, importance_range: upper };
        }
        let p = f64::from(self.visibility[cluster as usize]).max(LEAST_VISIBILITY);
        Expectation {
            rank: upper * (p * (1.0 - p) + UNOCCLUDED_VARIANCE * p).sqrt(),
            importance_range: upper * p.sqrt(),
        }
    }

    fn finest(&self) -> u64 {
        FINEST
    }
}
