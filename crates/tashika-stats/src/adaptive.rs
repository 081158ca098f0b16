//! A density over a unit cube, learned from weighted points. It is constant in each leaf cell of a
//! binary tree.
//!
//! Along each axis, a cell is cut into four equal quarters, and the sums of the weights in the
//! quarters are compared. The cell is halved along the axis on which the four sums differ most, if
//! they differ by more than chance. With the weight `W_c` and the volume `V_c` of a cell, its
//! probability and density are
//!
//! ```text
//! P_c = (1 − λ) W_c / W + λ V_c          p = P_c / V_c ≥ λ
//! ```
//!
//! For any learned points, the value of a function at a drawn point, divided by `p`, is an unbiased
//! estimate of the function's integral. The estimate is at most `1/λ` times the one by a uniform
//! density. Held to this by the tests below.

use super::Discrete;
use crate::math::elementary::ln_f64;

/// `λ`: the share of the probability that is spread evenly.
const EVEN_SHARE: f64 = 0.3;
/// Largest number of cells of the tree.
const MOST_CELLS: usize = 4096;
/// Smallest number of points of a cell that may be halved: with fewer, differences between quarters
/// are noise.
const FEWEST_POINTS: usize = 24;
/// Largest depth of the tree.
const MOST_DEPTH: u32 = 40;
/// Limit of the weight of a point, in units of the mean weight: a single bright point is weak
/// evidence of the distribution of light.
const LARGEST_OVER_MEAN: f64 = 64.0;
/// Smallest divergence of the quarters at which a cell is halved, in units of the divergence
/// expected by chance.
const MIN_SPLIT_SIGNIFICANCE: f64 = 4.0;

/// A density over `[0, 1)^D`.
#[derive(Clone, Debug)]
pub struct AdaptiveDensity<const D: usize> {
    cells: Vec<Cell<D>>,
    /// Distribution over the cells: `P_c`.
    choice: Discrete,
}

#[derive(Clone, Copy, Debug)]
struct Cell<const D: usize> {
    lo: [f64; D],
    size: [f64; D],
}

impl<const D: usize> Cell<D> {
    fn volume(&self) -> f64 {
        self.size.iter().product()
    }

    fn half(mut self, axis: usize, second: bool) -> Self {
        self.size[axis] *= 0.5;
        if second {
            self.lo[axis] += self.size[axis];
        }
        self
    }
}

/// A point of the cube, and its weight.
pub type Weighted<const D: usize> = ([f32; D], f32);

impl<const D: usize> AdaptiveDensity<D> {
    /// Learns a density from points of `[0, 1)^D` with weights that are finite and not negative;
    /// without points it is uniform.
    pub fn learn(mut points: Vec<Weighted<D>>) -> Self {
        points.retain(|(_, weight)| *weight > 0.0);
        let mean = points.iter().map(|(_, w)| f64::from(*w)).sum::<f64>() / points.len().max(1) as f64;
        let largest = (LARGEST_OVER_MEAN * mean) as f32;
        points.iter_mut().for_each(|(_, weight)| *weight = weight.min(largest));
        let total: f64 = points.iter().map(|(_, w)| f64::from(*w)).sum();
        let mut cells = Vec::new();
        let mut shares = Vec::new();
        let whole = Cell { lo: [0.0; D], size: [1.0; D] };
        let mut waiting = vec![(whole, &mut points[..], 0)];
        while let Some((cell, inside, depth)) = waiting.pop() {
            let is_last = depth == MOST_DEPTH || cells.len() + waiting.len() + 2 > MOST_CELLS;
            let Some(axis) = (!is_last).then(|| axis_of_contrast(&cell, inside)).flatten() else {
                let weight: f64 = inside.iter().map(|(_, w)| f64::from(*w)).sum();
                let learned = if total > 0.0 { weight / total } else { cell.volume() };
                shares.push((1.0 - EVEN_SHARE) * learned + EVEN_SHARE * cell.volume());
                cells.push(cell);
                continue;
            };
            let halves = [cell.half(axis, false), cell.half(axis, true)];
            inside.sort_by(|a, b| a.0[axis].total_cmp(&b.0[axis]));
            let middle = inside.partition_point(|(at, _)| f64::from(at[axis]) < halves[1].lo[axis]);
            let (first, second) = inside.split_at_mut(middle);
            waiting.push((halves[1], second, depth + 1));
            waiting.push((halves[0], first, depth + 1));
        }
        let choice = Discrete::new(shares).expect("each cell has a share of what is spread evenly");
        Self { cells, choice }
    }

    /// Draws a point and returns it with its density. `u` chooses the cell and the first coordinate
    /// in it, `v[1..]` the others; all are uniform in `[0, 1)`.
    pub fn sample(&self, u: f64, v: [f32; D]) -> ([f64; D], f64) {
        let (number, probability, rest) = self.choice.sample(u);
        let cell = &self.cells[number];
        let at = std::array::from_fn(|axis| {
            let within = if axis == 0 { rest } else { f64::from(v[axis]) };
            (cell.lo[axis] + cell.size[axis] * within).min(1.0 - f64::EPSILON)
        });
        (at, probability / cell.volume())
    }

    /// Number of cells of the tree.
    pub fn cells(&self) -> usize {
        self.cells.len()
    }
}

/// The axis along which the weights of a cell's quarters differ most; `None` if they differ by no
/// more than chance.
fn axis_of_contrast<const D: usize>(cell: &Cell<D>, inside: &[Weighted<D>]) -> Option<usize> {
    if inside.len() < FEWEST_POINTS {
        return None;
    }
    let mut quarters = [[0.0; 4]; D];
    let (mut sum, mut squares) = (0.0, 0.0);
    for (at, weight) in inside {
        let weight = f64::from(*weight);
        sum += weight;
        squares += weight * weight;
        for axis in 0..D {
            let within = (f64::from(at[axis]) - cell.lo[axis]) / cell.size[axis];
            quarters[axis][((4.0 * within) as usize).min(3)] += weight;
        }
    }
    // Kullback and Leibler's divergence from even quarters; its mean by chance is about 3/(2n) for
    // n equal weights.
    let divergence = |of: &[f64; 4]| -> f64 {
        let term = |w: f64| if w > 0.0 { w / sum * ln_f64(4.0 * w / sum) } else { 0.0 };
        of.iter().map(|w| term(*w)).sum()
    };
    let by_chance = 1.5 * squares / (sum * sum);
    let contrasts = quarters.iter().map(divergence).enumerate();
    let best = contrasts.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
    best.filter(|(_, contrast)| *contrast > MIN_SPLIT_SIGNIFICANCE * by_chance).map(|(axis, _)| axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Moments;
    use crate::rng::{Purpose, Stream};

    /// Points of a small bright box among a few others.
    fn spot(count: usize) -> Vec<Weighted<3>> {
        let mut s = Stream::new(5, Purpose::Test, 0);
        let mut point = |bright: bool| {
            let [x, y, z] = s.uniform_3();
            if bright { ([0.61 + 0.02 * x, 0.3 + 0.01 * y, z], 1.0) } else { ([x, y, z], 0.05) }
        };
        (0..count).map(|i| point(i % 4 != 0)).collect()
    }

    /// Densities learned from a bright box, from no points, and from a hundred equal points. For
    /// each, the mean of `f(x)/p(x)` is the integral of `f`.
    #[test]
    fn what_is_drawn_is_weighted_by_its_density() {
        for points in [spot(20_000), Vec::new(), vec![([0.1, 0.9, 0.5], 3.0); 100]] {
            let density = AdaptiveDensity::learn(points);
            let mut s = Stream::new(1, Purpose::Test, 0);
            let [mut ones, mut product] = [Moments::default(); 2];
            for _ in 0..200_000 {
                let (at, p) = density.sample(s.uniform_f64(), s.uniform_3());
                assert!(at.iter().all(|x| (0.0..1.0).contains(x)) && p > 0.999 * EVEN_SHARE);
                ones.push(1.0 / p);
                product.push(at[0] * at[1] * at[1] / p);
            }
            for (found, expected) in [(ones, 1.0), (product, 1.0 / 6.0)] {
                let error = found.standard_error();
                assert!(error < 0.01 * expected, "sharp: {error}");
                assert!((found.mean() - expected).abs() < 4.5 * error + 1e-9, "{} {error}", found.mean());
            }
        }
    }

    #[test]
    fn most_draws_are_where_the_weights_are() {
        let density = AdaptiveDensity::learn(spot(20_000));
        assert!(density.cells() > 20, "{}", density.cells());
        let mut s = Stream::new(2, Purpose::Test, 0);
        let draws = 10_000;
        let hits = (0..draws).filter(|_| {
            let (at, _) = density.sample(s.uniform_f64(), s.uniform_3());
            (0.6..0.64).contains(&at[0]) && (0.29..0.32).contains(&at[1])
        });
        // The learned share of the probability is 0.7. The even points of the background take a
        // sixtieth of it.
        let hits = hits.count();
        assert!(hits * 100 > 60 * draws, "{hits} of {draws}");
        // Points without a pattern need few cells.
        let mut even = |_| (s.uniform_3(), 1.0);
        let cells = AdaptiveDensity::learn((0..4000).map(&mut even).collect()).cells();
        assert!(cells <= 8, "{cells} cells of noise");
    }
}
