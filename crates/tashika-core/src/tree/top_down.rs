//! Builds a light tree top-down: Alejandro Conty Estévez, Christopher Kulla. "Importance Sampling
//! of Many Lights with Adaptive Tree Splitting." Proc. ACM on Computer Graphics and Interactive
//! Techniques 1(2), 2018, doi:10.1145/3233305; section 4.
//!
//! A node is split at the plane between bins that minimises
//!
//! ```text
//! k_r · (Φ_l M_A(l) M_Ω(l) + Φ_r M_A(r) M_Ω(r))        k_r = longest extent / extent along the axis (keeps clusters from growing thin)
//! ```
//!
//! ([`saoh`](super::saoh)). The time is `O(n log n)`, since the depth is limited: below a certain
//! depth nodes are halved.
//!
//! # Differences from the source
//! Planes across the directions of lights are tried as well as planes across their positions. The
//! full range of a direction counts as half the diagonal of the box. Small nodes, and nodes whose
//! lights are at one position, are split in the middle of their longest extent. Each leaf contains
//! one light.
//!
//! # Held to this by
//! `tree::tests::trees` (structure, degenerate input, threads) and `tree::tests::quality`.

use rayon::prelude::*;

use super::build::{Item, Span};
use super::saoh::{Bounds6, Emission};

/// Maximum number of bins on an axis.
const BINS: usize = 16;
/// Number of bins on an axis in nodes with few items.
const FEW_BINS: usize = 8;
/// Number of items from which [`BINS`] bins are used.
const MANY_ITEMS: usize = 256;
/// Largest number of items of a node that is split in the middle. Chosen: with larger values
/// building is faster and the cost of the tree grows slowly.
const SMALL: usize = 8;
/// An axis is tried only if its length is at least this share of the longest axis.
const SHORTEST: f32 = 0.25;
/// Depth from which nodes are halved; at most 31 more levels follow.
const MAX_UNEVEN_DEPTH: u32 = 64;
/// Number of items above which the two children of a node are built in parallel.
const PARALLEL_SIDES: usize = 1 << 12;
/// Number of items that are binned as one parallel task.
const CHUNK: usize = 1 << 15;

/// Sorts `items` into the tree `spans` (see [`build`](super::build)); `first` is the index of the
/// first item in the sorted order.
pub(super) fn build(items: &mut [Item], spans: &mut [Span], first: u32, emission: &Emission) {
    grow(items, spans, first, 0, emission);
}

/// Builds the node over `items` and its descendants. Recursion ends when nodes are small. Its depth
/// is at most [`MAX_UNEVEN_DEPTH`] plus one for each bit of the number of items.
fn grow(items: &mut [Item], spans: &mut [Span], first: u32, depth: u32, emission: &Emission) {
    if items.len() <= PARALLEL_SIDES {
        return grow_small(items, spans, first, depth, emission);
    }
    spans[0] = Span { first, count: items.len() as u32 };
    let middle = split(items, depth, emission);
    let (left, right) = items.split_at_mut(middle);
    let (left_spans, right_spans) = spans[1..].split_at_mut(2 * middle - 1);
    rayon::join(
        || grow(left, left_spans, first, depth + 1, emission),
        || grow(right, right_spans, first + middle as u32, depth + 1, emission),
    );
}

fn grow_small(items: &mut [Item], spans: &mut [Span], first: u32, depth: u32, emission: &Emission) {
    // Node, first item, number of items, depth.
    let mut waiting = vec![(0, 0, items.len(), depth)];
    while let Some((node, begin, count, depth)) = waiting.pop() {
        spans[node] = Span { first: first + begin as u32, count: count as u32 };
        if count > 1 {
            let middle = split(&mut items[begin..begin + count], depth, emission);
            waiting.push((node + 2 * middle, begin + middle, count - middle, depth + 1));
            waiting.push((node + 1, begin, middle, depth + 1));
        }
    }
}

/// Moves the items of the left child to the front and returns their number, which is between 1 and
/// `items.len() - 1`.
#[inline(never)]
fn split(items: &mut [Item], depth: u32, emission: &Emission) -> usize {
    let count = items.len();
    if count == 2 {
        return 1;
    }
    let bounds = bounds_of(items);
    let lengths = lengths(&bounds, emission);
    let longest = longest_axis(&lengths);
    if lengths[longest] <= 0.0 {
        return count / 2;
    }
    let plane = if depth >= MAX_UNEVEN_DEPTH {
        None
    } else if count <= SMALL || bounds.diagonal() <= 0.0 {
        Some(Plane::new(&bounds, longest, 2, 0))
    } else {
        best_plane(items, &bounds, &lengths, emission)
    };
    let middle = plane.map_or(0, |plane| partition(items, |item| plane.is_left(item)));
    if middle > 0 && middle < count {
        return middle;
    }
    let key = |item: &Item| item.key[longest];
    items.select_nth_unstable_by(count / 2, |a, b| key(a).total_cmp(&key(b)).then(a.light.cmp(&b.light)));
    count / 2
}

/// Lengths of the axes of positions and directions, in units of the box's diagonal. The full range
/// of a direction has the length [`DIRECTION_WEIGHT`].
fn lengths(bounds: &Bounds6, emission: &Emission) -> [f32; 6] {
    let extent = bounds.extent();
    let diagonal = bounds.diagonal();
    let inverse = if diagonal > 0.0 { 1.0 / diagonal } else { 0.0 };
    std::array::from_fn(|axis| match axis {
        0..3 => extent[axis] * inverse,
        _ if emission.directed => 0.5 * DIRECTION_WEIGHT * extent[axis],
        _ => 0.0,
    })
}

/// Length of the full range of a direction, in units of the box's diagonal.
const DIRECTION_WEIGHT: f32 = 0.5;

fn longest_axis(lengths: &[f32; 6]) -> usize {
    (1..6).fold(0, |best, axis| if lengths[axis] > lengths[best] { axis } else { best })
}

/// A plane between two bins on an axis.
#[derive(Clone, Copy)]
struct Plane {
    axis: usize,
    lo: f32,
    /// Bins per unit of length.
    scale: f32,
    /// Index of the last bin.
    last: usize,
    /// Index of the last bin on the left side.
    bin: usize,
}

impl Plane {
    fn new(bounds: &Bounds6, axis: usize, bins: usize, bin: usize) -> Self {
        let extent = bounds.hi[axis] - bounds.lo[axis];
        Self { axis, lo: bounds.lo[axis], scale: bins as f32 / extent, last: bins - 1, bin }
    }

    #[inline]
    fn bin_of(&self, item: &Item) -> usize {
        (((item.key[self.axis] - self.lo) * self.scale) as u32 as usize).min(self.last)
    }

    fn is_left(&self, item: &Item) -> bool {
        self.bin_of(item) <= self.bin
    }
}

/// Bounds and luminance of the items in one bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds6,
    luminance: f64,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Bounds6::EMPTY, luminance: 0.0 };

    #[inline]
    fn unite(&mut self, other: &Self) {
        self.bounds.unite(&other.bounds);
        self.luminance += other.luminance;
    }

    /// Returns true if the bin contains no items; every item has positive luminance.
    fn is_empty(&self) -> bool {
        self.luminance <= 0.0
    }

    fn cost(&self, emission: &Emission) -> f32 {
        self.luminance as f32 * emission.cost(&self.bounds)
    }
}

type Histogram = [[Bin; BINS]; 6];

/// The plane of least cost; `None` if no plane has a finite cost.
fn best_plane(items: &[Item], bounds: &Bounds6, lengths: &[f32; 6], emission: &Emission) -> Option<Plane> {
    let bins = if items.len() < MANY_ITEMS { FEW_BINS } else { BINS };
    let longest = lengths[longest_axis(lengths)];
    let mut axes = [Plane::new(bounds, 0, bins, 0); 6];
    let mut tried = 0;
    for (axis, &length) in lengths.iter().enumerate() {
        if length >= SHORTEST * longest {
            axes[tried] = Plane::new(bounds, axis, bins, 0);
            tried += 1;
        }
    }
    let axes = &axes[..tried];
    let histogram = histogram(items, axes);
    let mut best = (f32::INFINITY, None);
    for (plane, row) in axes.iter().zip(&histogram) {
        let regularity = longest / lengths[plane.axis];
        let mut right_costs = [f32::INFINITY; BINS];
        let mut right = Bin::EMPTY;
        for bin in (1..bins).rev() {
            right.unite(&row[bin]);
            if !right.is_empty() {
                right_costs[bin] = right.cost(emission);
            }
        }
        let mut left = Bin::EMPTY;
        for bin in 0..bins - 1 {
            left.unite(&row[bin]);
            if left.is_empty() {
                continue;
            }
            let cost = regularity * (left.cost(emission) + right_costs[bin + 1]);
            if cost < best.0 {
                best = (cost, Some(Plane { bin, ..*plane }));
            }
        }
    }
    best.1
}

/// Bins on each axis. The items of large nodes are binned in chunks, whose bins are merged in the
/// order of the chunks.
fn histogram(items: &[Item], axes: &[Plane]) -> Histogram {
    let mut sum = [[Bin::EMPTY; BINS]; 6];
    if items.len() <= CHUNK {
        fill(&mut sum, items, axes);
        return sum;
    }
    let of_chunk = |chunk: &[Item]| {
        let mut bins = Box::new([[Bin::EMPTY; BINS]; 6]);
        fill(&mut bins, chunk, axes);
        bins
    };
    let chunks: Vec<Box<Histogram>> = items.par_chunks(CHUNK).map(of_chunk).collect();
    for chunk in &chunks {
        for (row, of_chunk) in sum.iter_mut().zip(chunk.iter()) {
            for (bin, of_chunk) in row.iter_mut().zip(of_chunk) {
                bin.unite(of_chunk);
            }
        }
    }
    sum
}

fn fill(histogram: &mut Histogram, items: &[Item], axes: &[Plane]) {
    for item in items {
        for (row, plane) in histogram.iter_mut().zip(axes) {
            let bin = &mut row[plane.bin_of(item)];
            bin.bounds.insert(item);
            bin.luminance += f64::from(item.luminance);
        }
    }
}

fn bounds_of(items: &[Item]) -> Bounds6 {
    let of_chunk = |chunk: &[Item]| {
        let mut bounds = Bounds6::EMPTY;
        chunk.iter().for_each(|item| bounds.insert(item));
        bounds
    };
    if items.len() <= CHUNK {
        return of_chunk(items);
    }
    let unite = |mut a: Bounds6, b: Bounds6| {
        a.unite(&b);
        a
    };
    items.par_chunks(CHUNK).map(of_chunk).reduce(|| Bounds6::EMPTY, unite)
}

/// Moves the items for which `left` is true to the front and returns their number. There are no
/// branches, since half of them would be mispredicted.
fn partition(items: &mut [Item], left: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        let is_left = left(&items[i]);
        // If item `i` belongs to the right, the swap exchanges two items of the right.
        items.swap(count, i);
        count += usize::from(is_left);
    }
    count
}
