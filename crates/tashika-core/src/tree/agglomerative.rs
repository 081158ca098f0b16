//! Builds a light tree bottom-up, by joining clusters whose union has a low cost.
//!
//! The cost of a cluster is that of Walter 2005, section 3.2:
//!
//! ```text
//! I_C (d² + c² (1 − cos β)²)     I_C: luminance   d: diagonal of the box (m)   β: half-angle of the cone about the normals
//!                                c: diagonal of the box of all lights (m); 0 for lights without normals
//! ```
//!
//! Finding the cheapest of all pairs takes quadratic time. Instead, clusters are listed along a
//! space-filling curve. Each cluster finds its cheapest partner within
//! [`WINDOW`](super::partners::WINDOW) places of the list, and all pairs whose members chose each
//! other are joined at once: Daniel Meister, Jiří Bittner. "Parallel Locally-Ordered Clustering for
//! Bounding Volume Hierarchy Construction." IEEE TVCG 24(3), 2018, doi:10.1109/TVCG.2017.2669983.
//! Directional lights are treated as points on the unit sphere.
//!
//! # Differences from the sources
//! The curve (Morton order) visits coarse cells one by one. Within each it visits the faces of the
//! cube of normals one by one, so that the two sides of a wall are far apart in the list. Ties are
//! broken in such a way that equal lights form pairs. If only few clusters chose each other (as in
//! rows of lights of growing intensity), clusters also join partners that chose another. Thus each
//! pass joins at least a fixed share of the clusters, and the time is `O(n log n)` for any input.
//!
//! # Held to this by
//! `tree::tests::trees` (structure, degenerate input, threads) and `tree::tests::quality`.

use glam::Vec3;
use rayon::prelude::*;

use super::build::{Item, Span};
use super::partners::best_partners;
use super::saoh::{Bounds6, Emission};
use crate::math::Cone;

/// Number of bits per coordinate in the Morton order.
const BITS: u32 = 20;
/// Number of the leading bits per coordinate that come before the face of the normal.
const COARSE_BITS: u32 = 2;
/// If there are more clusters than this for each pair that chose each other, other clusters are
/// joined, too.
const FEW_PAIRS: usize = 16;

/// A cluster of lights while the tree is built.
#[derive(Clone, Copy)]
pub(super) struct Cluster {
    pub(super) lo: Vec3,
    pub(super) hi: Vec3,
    pub(super) cone: Cone,
    /// Cosine and sine of half the cone's half-angle.
    pub(super) half: [f32; 2],
    pub(super) luminance: f32,
    /// Index of the item; for joined clusters, the number of items plus the index in [`Joined`].
    id: u32,
}

impl Cluster {
    pub(super) fn of_item(item: &Item, id: u32) -> Self {
        let at = item.position();
        let cone = Cone::of(item.direction());
        Self { lo: at, hi: at, cone, half: [1.0, 0.0], luminance: item.luminance, id }
    }

    pub(super) fn join(&self, other: &Self, directed: bool, id: u32) -> Self {
        let cone = if directed { self.cone.union(other.cone) } else { self.cone };
        Self {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
            cone,
            half: [cone.cos_half(), cone.sin_half()],
            luminance: self.luminance + other.luminance,
            id,
        }
    }

    /// Walter's cost of the union of two clusters; the same bits in either order.
    pub(super) fn cost(&self, other: &Self, c2: f32) -> f32 {
        let diagonal = (self.hi.max(other.hi) - self.lo.min(other.lo)).length_squared();
        let narrow = 1.0 - if c2 > 0.0 { self.cos_together(other) } else { 1.0 };
        (self.luminance + other.luminance) * (diagonal + c2 * narrow * narrow)
    }

    /// Cosine of the half-angle `β = max(β_a, β_b, (δ + β_a + β_b) / 2)` of the cone around both
    /// cones, where `δ` is the angle between their axes.
    fn cos_together(&self, other: &Self) -> f32 {
        let ([ca, sa], [cb, sb]) = (self.half, other.half);
        let dot = self.cone.axis.dot(other.cone.axis).clamp(-1.0, 1.0);
        let (cd, sd) = ((0.5 + 0.5 * dot).sqrt(), (0.5 - 0.5 * dot).sqrt());
        let (c, s) = (ca * cb - sa * sb, sa * cb + ca * sb);
        let (cos, sin) = (c * cd - s * sd, s * cd + c * sd);
        let cos = if sin < 0.0 { -1.0 } else { cos };
        cos.min(self.cone.cos).min(other.cone.cos)
    }
}

/// Inner nodes in the order of their creation: the ids of the two joined clusters, and the total
/// number of items.
type Joined = Vec<([u32; 2], u32)>;

/// Sorts `items` into the tree `spans` (see [`build`](super::build)); `first` is the index of the
/// first item in the sorted order.
pub(super) fn build(items: &mut [Item], spans: &mut [Span], first: u32, emission: &Emission) {
    let mut bounds = Bounds6::EMPTY;
    items.iter().for_each(|item| bounds.insert(item));
    sort_along_curve(items, &bounds);
    let c2 = if emission.directed { bounds.diagonal() * bounds.diagonal() } else { 0.0 };
    let count = items.len() as u32;
    let mut clusters: Vec<Cluster> =
        items.par_iter().enumerate().map(|(i, item)| Cluster::of_item(item, i as u32)).collect();
    let mut joined: Joined = Vec::with_capacity(items.len() - 1);
    let size = |joined: &Joined, id: u32| if id < count { 1 } else { joined[(id - count) as usize].1 };
    while clusters.len() > 1 {
        let pairs = pairs(&clusters, c2);
        let next_id = count + joined.len() as u32;
        for &[a, b] in &pairs {
            let ids = [clusters[a as usize].id, clusters[b as usize].id];
            joined.push((ids, size(&joined, ids[0]) + size(&joined, ids[1])));
        }
        join(&mut clusters, &pairs, next_id, emission.directed);
    }
    flatten(items, spans, first, clusters[0].id, &joined);
}

/// Returns disjoint pairs of positions to join, at least one. Each pair is in ascending order, and
/// so is the list of pairs.
fn pairs(clusters: &[Cluster], c2: f32) -> Vec<[u32; 2]> {
    let n = clusters.len();
    let best = best_partners(clusters, c2);
    let mutual = |i: usize| best[best[i] as usize] as usize == i;
    let mut pairs: Vec<[u32; 2]> =
        (0..n).filter(|&i| i < best[i] as usize && mutual(i)).map(|i| [i as u32, best[i]]).collect();
    if pairs.len() * FEW_PAIRS < n {
        let mut taken = vec![false; n];
        pairs.iter().flatten().for_each(|&i| taken[i as usize] = true);
        for i in 0..n {
            let j = best[i] as usize;
            if !taken[i] && !taken[j] {
                (taken[i], taken[j]) = (true, true);
                pairs.push([i.min(j) as u32, i.max(j) as u32]);
            }
        }
        pairs.sort_unstable();
    }
    pairs
}

/// Joins the pairs of a list; the union takes the position of the pair's first cluster.
fn join(clusters: &mut Vec<Cluster>, pairs: &[[u32; 2]], next_id: u32, directed: bool) {
    let joined: Vec<Cluster> = pairs
        .par_iter()
        .enumerate()
        .map(|(k, &[a, b])| clusters[a as usize].join(&clusters[b as usize], directed, next_id + k as u32))
        .collect();
    let mut gone = vec![false; clusters.len()];
    pairs.iter().for_each(|&[_, b]| gone[b as usize] = true);
    for (&[a, _], joined) in pairs.iter().zip(joined) {
        clusters[a as usize] = joined;
    }
    let mut gone = gone.into_iter();
    clusters.retain(|_| !gone.next().expect("one for each cluster"));
    // Frees memory that other parts of the build need.
    clusters.shrink_to_fit();
}

/// Writes the tree in depth-first order, and sorts the items into the order of its leaves.
fn flatten(items: &mut [Item], spans: &mut [Span], first: u32, root: u32, joined: &Joined) {
    let unsorted = items.to_vec();
    let mut waiting = vec![root];
    let mut sorted = 0;
    for span in spans {
        let id = waiting.pop().expect("a tree over n items has 2n − 1 nodes") as usize;
        let at = first + sorted as u32;
        if id < unsorted.len() {
            items[sorted] = unsorted[id];
            sorted += 1;
            *span = Span { first: at, count: 1 };
        } else {
            let ([a, b], count) = joined[id - unsorted.len()];
            waiting.extend([b, a]);
            *span = Span { first: at, count };
        }
    }
}

/// Sorts items along a space-filling curve.
fn sort_along_curve(items: &mut [Item], bounds: &Bounds6) {
    let longest = bounds.extent()[..3].iter().copied().fold(0.0, f32::max);
    let cells = (1u32 << BITS) as f32;
    let scale = if longest > 0.0 { cells / longest } else { 0.0 };
    let key = |item: &Item| {
        let cell = |axis: usize| (((item.key[axis] - bounds.lo[axis]) * scale) as u64).min((1 << BITS) - 1);
        let place = spread(cell(0)) << 2 | spread(cell(1)) << 1 | spread(cell(2));
        let fine_bits = 3 * (BITS - COARSE_BITS);
        let fine = place & ((1 << fine_bits) - 1);
        (place >> fine_bits << 3 | face(item.direction())) << fine_bits | fine
    };
    let mut places: Vec<_> = items.par_iter().map(key).zip(0u32..items.len() as u32).collect();
    places.par_sort_unstable();
    let sorted: Vec<Item> = places.par_iter().map(|&(_, place)| items[place as usize]).collect();
    items.copy_from_slice(&sorted);
}

/// Face of the axis-aligned cube around the origin through which a direction passes.
fn face(direction: Vec3) -> u64 {
    let axis = direction.abs().max_position();
    2 * axis as u64 + u64::from(direction[axis] < 0.0)
}

/// Spreads the bits of a number of up to 21 bits: two zeros follow each bit.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a row of lights with growing gaps, each light's best partner is the one before it. Only
    /// the first two lights choose each other, and still a share of the clusters is joined.
    #[test]
    fn every_pass_joins_a_share_of_the_clusters() {
        let row: Vec<Cluster> = (0..2000u32)
            .map(|i| {
                let key = [(i * i) as f32, 0.0, 0.0, 0.0, 1.0, 0.0];
                Cluster::of_item(&Item { key, luminance: 1.0, light: i }, i)
            })
            .collect();
        let pairs = pairs(&row, 1.0);
        assert!(pairs.len() >= 500, "{} pairs of 2000 lights", pairs.len());
        let mut places: Vec<u32> = pairs.iter().flatten().copied().collect();
        places.sort_unstable();
        assert!(places.is_sorted_by(|a, b| a < b), "no cluster is joined twice");
        assert!(pairs.iter().all(|[a, b]| a < b) && pairs.is_sorted());
    }

    #[test]
    fn cosines_of_cones_together_are_those_of_their_union() {
        let mut s = crate::rng::Stream::new(1, crate::rng::Purpose::Test, 0);
        for _ in 0..2000 {
            let mut cluster = || {
                let (axis, cos) = (crate::warp::sphere(s.uniform_2()), 1.0 - 2.0 * s.uniform() * s.uniform());
                let cone = Cone { axis, cos };
                let at = Cluster::of_item(&Item { key: [0.0; 6], luminance: 1.0, light: 0 }, 0);
                Cluster { cone, half: [cone.cos_half(), cone.sin_half()], ..at }
            };
            let (a, b) = (cluster(), cluster());
            let (found, expected) = (a.cos_together(&b), a.cone.union(b.cone).cos.max(-1.0));
            assert!((found - expected).abs() < 1e-5, "{found} for {expected}");
            assert_eq!(found.to_bits(), b.cos_together(&a).to_bits());
        }
    }
}
