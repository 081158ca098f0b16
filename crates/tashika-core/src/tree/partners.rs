//! Finds the cheapest partner of each cluster among its neighbours in a list, eight candidates at a
//! time.
//!
//! The arithmetic is that of [`Cluster::cost`], with identical bits. The tests below check this.

use std::ops::Range;

use rayon::prelude::*;

use super::agglomerative::Cluster;
use crate::math::simd::{F32x8, Level, Vectors, WIDTH, Work, each};

/// Number of list positions on each side that are searched for a partner. Larger windows build
/// better trees, and the time is proportional to the size.
pub(super) const WINDOW: usize = 11;
/// Number of vectors that cover the window, which includes the cluster itself, and one position
/// beyond.
const VECTORS: usize = (2 * WINDOW + 2) / WIDTH;
/// Number of clusters that one parallel task processes.
const GRAIN: usize = 1024;

/// A piece of the list of clusters, component by component.
struct Columns {
    /// Index in the list of the first cluster of the piece.
    begin: usize,
    lo: [Vec<f32>; 3],
    hi: [Vec<f32>; 3],
    axis: [Vec<f32>; 3],
    cos: Vec<f32>,
    cos_half: Vec<f32>,
    sin_half: Vec<f32>,
    luminance: Vec<f32>,
}

impl Columns {
    fn new(list: &[Cluster], piece: Range<usize>) -> Self {
        let clusters = &list[piece.clone()];
        let column = |f: &dyn Fn(&Cluster) -> f32| clusters.iter().map(f).collect::<Vec<f32>>();
        let columns = |f: &dyn Fn(&Cluster, usize) -> f32| [0, 1, 2].map(|axis| column(&|c| f(c, axis)));
        Self {
            begin: piece.start,
            lo: columns(&|c, axis| c.lo[axis]),
            hi: columns(&|c, axis| c.hi[axis]),
            axis: columns(&|c, axis| c.cone.axis[axis]),
            cos: column(&|c| c.cone.cos),
            cos_half: column(&|c| c.half[0]),
            sin_half: column(&|c| c.half[1]),
            luminance: column(&|c| c.luminance),
        }
    }

    /// Costs of joining cluster `i` with each of the eight clusters from `first` on; both are
    /// indices in the list.
    #[inline(always)]
    fn costs<F: F32x8>(&self, i: usize, first: usize, c2: f32) -> F {
        let (i, first) = (i - self.begin, first - self.begin);
        let (zero, one, half) = (F::splat(0.0), F::splat(1.0), F::splat(0.5));
        let size = each!(|axis| {
            let hi = F::splat(self.hi[axis][i]).max(eight(&self.hi[axis], first));
            hi - F::splat(self.lo[axis][i]).min(eight(&self.lo[axis], first))
        });
        let diagonal = size[0] * size[0] + size[1] * size[1] + size[2] * size[2];
        let narrow = if c2 > 0.0 {
            let product = each!(|axis| F::splat(self.axis[axis][i]) * eight(&self.axis[axis], first));
            let dot = (product[0] + product[1] + product[2]).max(F::splat(-1.0)).min(one);
            let (cd, sd) = ((half + half * dot).sqrt(), (half - half * dot).sqrt());
            let (ca, sa) = (F::splat(self.cos_half[i]), F::splat(self.sin_half[i]));
            let (cb, sb) = (eight::<F>(&self.cos_half, first), eight::<F>(&self.sin_half, first));
            let (c, s) = (ca * cb - sa * sb, sa * cb + ca * sb);
            let (cos, sin) = (c * cd - s * sd, s * cd + c * sd);
            let cos = F::select(zero.gt(sin), F::splat(-1.0), cos);
            one - cos.min(F::splat(self.cos[i])).min(eight(&self.cos, first))
        } else {
            zero
        };
        let luminance = F::splat(self.luminance[i]) + eight(&self.luminance, first);
        luminance * (diagonal + F::splat(c2) * narrow * narrow)
    }

    /// Finds the best partners of clusters whose entire window is inside the list.
    #[inline(always)]
    fn inside<F: F32x8>(&self, first: usize, c2: f32, best: &mut [u32]) {
        for (i, best) in (first..).zip(best) {
            let begin = i - WINDOW;
            let mut costs = [[0.0; WIDTH]; VECTORS];
            for (v, costs) in costs.iter_mut().enumerate() {
                *costs = self.costs::<F>(i, begin + v * WIDTH, c2).array();
            }
            *best = cheapest(i, (begin..=i + WINDOW).zip(costs.into_iter().flatten()));
        }
    }
}

/// Eight consecutive numbers of a column.
#[inline(always)]
fn eight<F: F32x8>(column: &[f32], first: usize) -> F {
    F::load_from(&column[first..])
}

/// Index of the least cost. Among equal costs, the index that differs from `i` in the lowest bit is
/// taken; two such clusters always choose each other.
#[inline(always)]
fn cheapest(i: usize, costs: impl Iterator<Item = (usize, f32)>) -> u32 {
    let mut best = (f32::INFINITY, usize::MAX);
    for (j, cost) in costs {
        // Costs that overflow `f32` count as equal.
        let cost = if cost < f32::MAX { cost } else { f32::MAX };
        if i != j && (cost < best.0 || (cost == best.0 && i ^ j < best.1)) {
            best = (cost, i ^ j);
        }
    }
    (i ^ best.1) as u32
}

/// Best partner of each cluster; there must be at least two. `c2` is the weight of differences
/// between normals (m²).
pub(super) fn best_partners(clusters: &[Cluster], c2: f32) -> Vec<u32> {
    best_with(Level::best(), clusters, c2)
}

fn best_with(level: Level, clusters: &[Cluster], c2: f32) -> Vec<u32> {
    let n = clusters.len();
    let scalar = |i: usize| {
        let window = i.saturating_sub(WINDOW)..n.min(i + WINDOW + 1);
        cheapest(i, window.map(|j| (j, clusters[i].cost(&clusters[j], c2))))
    };
    let mut best = vec![0; n];
    // The vectors read one position beyond the window.
    let inside = WINDOW..n.saturating_sub(WINDOW + 1).max(WINDOW);
    if inside.is_empty() {
        best.iter_mut().enumerate().for_each(|(i, best)| *best = scalar(i));
        return best;
    }
    for i in (0..inside.start).chain(inside.end..n) {
        best[i] = scalar(i);
    }
    best[inside.clone()].par_chunks_mut(GRAIN).enumerate().for_each(|(chunk, best)| {
        let first = inside.start + chunk * GRAIN;
        let columns = Columns::new(clusters, first - WINDOW..first + best.len() + WINDOW + 1);
        level.run(Inside { columns: &columns, first, c2, best });
    });
    best
}

/// Arguments of [`Columns::inside`] for a piece of the list.
struct Inside<'a> {
    columns: &'a Columns,
    first: usize,
    c2: f32,
    best: &'a mut [u32],
}

impl Work for Inside<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        self.columns.inside::<V::Eight>(self.first, self.c2, self.best);
    }
}

#[cfg(test)]
mod tests {
    use super::super::build::Item;
    use super::*;
    use crate::math::simd::{Portable, Vector};
    use crate::rng::{Purpose, Stream};
    use crate::warp;

    #[test]
    fn vectors_choose_what_single_costs_choose() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        for count in [2, 3, 12, 22, 23, 24, 25, 26, 40, 5000] {
            for c2 in [0.0, 50.0] {
                let mut cluster = |id: u32| {
                    let d = warp::sphere(s.uniform_2()).normalize();
                    // Positions are on a coarse grid, so that equal costs occur.
                    let [x, y, z] = s.uniform_3().map(|x| (x * 8.0).floor());
                    let key = [x, y, z, d.x, d.y, d.z];
                    Cluster::of_item(&Item { key, luminance: 1.0 + s.below(3) as f32, light: id }, id)
                };
                let mut list: Vec<Cluster> = (0..count).map(&mut cluster).collect();
                for i in (1..list.len()).step_by(2) {
                    list[i] = list[i].join(&list[i - 1], c2 > 0.0, i as u32);
                }
                let n = list.len();
                let expected: Vec<u32> = (0..n)
                    .map(|i| {
                        let window = i.saturating_sub(WINDOW)..n.min(i + WINDOW + 1);
                        cheapest(i, window.map(|j| (j, list[i].cost(&list[j], c2))))
                    })
                    .collect();
                let columns = Columns::new(&list, 0..n);
                for i in 0..n.saturating_sub(WIDTH) {
                    let costs = columns.costs::<Portable<WIDTH>>(i, i + 1, c2).array();
                    for (j, cost) in (i + 1..).zip(costs) {
                        assert_eq!(cost, list[i].cost(&list[j], c2), "{i} with {j}");
                    }
                }
                for level in Level::all() {
                    assert_eq!(best_with(level, &list, c2), expected, "{level:?}, {count} clusters");
                }
            }
        }
    }
}
