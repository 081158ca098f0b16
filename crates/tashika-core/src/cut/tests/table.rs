//! Tests of tabulated pairs: their sums, draws from them, and descendants that read their values
//! from the same table.

use super::{TRANSPORT, lights, points, tree};
use crate::bounds::{UpperAnalytic, UpperScattering};
use crate::color::Rgb;
use crate::cut::{
    Clusters, KernelBound, Pair, Rank, Refinement, RefinementMemory, RefinementOptions, TermTable,
    gather_tree,
};
use crate::math::Vec3;
use crate::rng::{Purpose, Stream};
use crate::tree::{GatherTree, LightTree};
use crate::vpl::{Vpl, VplKind};

const OPTIONS: RefinementOptions<'_> = RefinementOptions { rank: Rank::Upper, finest: 2, tabulated: 40 };

fn world() -> (LightTree, GatherTree<UpperScattering<UpperAnalytic>>) {
    let mut s = Stream::new(9, Purpose::Test, 7);
    (lights(120, &mut s), gather_tree(&points(10, &mut s)))
}

/// Splits until no pair can be split. Returns the parents of all pairs except the first, in order.
fn split_all(refinement: &mut Refinement<'_, UpperAnalytic>) -> Vec<Pair> {
    let mut parents = Vec::new();
    while let Some(split) = refinement.split_next() {
        assert_eq!(split.children as usize, parents.len() + 1);
        parents.extend([refinement.pairs()[split.parent as usize]; 2]);
    }
    parents
}

/// Values of the terms of a pair, evaluated directly.
fn terms(clusters: &Clusters<'_, UpperAnalytic>, pair: &Pair) -> Vec<f64> {
    let value = |term: crate::cut::Term| {
        let (light, point) = (clusters.lights.light(term.light), clusters.points.point(term.point));
        f64::from(TRANSPORT.unoccluded(point, &light).luminance())
    };
    clusters.all_terms(pair).map(value).collect()
}

#[test]
fn halves_of_small_pairs_are_known_by_their_terms_and_others_by_bounds() {
    let (lights, points) = world();
    let clusters = Clusters { lights: &lights, points: &points, contribution: TRANSPORT };
    let mut memory = RefinementMemory::default();
    let mut refinement = Refinement::new(clusters, OPTIONS, &mut memory).unwrap();
    let parents = split_all(&mut refinement);
    let (mut tabulated, mut dark, mut tighter) = (0, 0, 0);
    for (number, pair) in refinement.pairs().iter().enumerate() {
        let known = refinement.info(number);
        let bound = clusters.upper(pair).0;
        let Some(of) = &known.table else {
            assert!(number == 0 || clusters.terms(&parents[number - 1]) > OPTIONS.tabulated);
            assert_eq!(known.upper.0, bound);
            continue;
        };
        assert!(clusters.terms(&parents[number - 1]) <= OPTIONS.tabulated, "{pair:?}");
        let values = terms(&clusters, pair);
        let sum: f64 = values.iter().sum();
        assert!((known.upper.0 >= sum) && known.upper.0 <= sum * (1.0 + 1e-5), "{sum} {known:?}");
        assert!(known.upper.0 <= bound * (1.0 + 1e-5), "{bound} {known:?}");
        assert_eq!(of.lit as usize, values.iter().filter(|v| **v > 0.0).count());
        for (term, value) in clusters.all_terms(pair).zip(values) {
            assert_eq!(refinement.table().unoccluded(of, term), value, "{pair:?} {term:?}");
        }
        tabulated += 1;
        dark += u32::from(of.lit == 0);
        tighter += u32::from(known.upper.0 < 0.5 * bound);
    }
    assert!(
        tabulated > 300 && dark > 0 && tighter > 30,
        "{tabulated} tabulated, {dark} dark, {tighter} tighter"
    );
}

/// One light is far brighter than all others together. The sum of the others, obtained as a
/// remainder, is as exact as a direct sum.
#[test]
fn halves_are_exact_beside_a_bright_one() {
    halves_are_exact(30, |number| [1.0, 1e15][usize::from(number == 11)]);
}

/// Each light is far brighter than all dimmer lights together, so that remainders are computed from
/// remainders. The halves are still exact.
#[test]
fn halves_are_exact_beside_ever_brighter_ones() {
    halves_are_exact(12, |number| crate::math::elementary::powf(10.0, number as f32 * 5.8 - 32.0));
}

/// Tests `count` lights next to each other; the intensity of each is multiplied by `factor`.
fn halves_are_exact(count: usize, factor: impl Fn(usize) -> f32) {
    let mut s = Stream::new(9, Purpose::Test, 7);
    let points = gather_tree::<UpperAnalytic>(&points(1, &mut s));
    let light = |number: usize| Vpl {
        position: Vec3::new(1.2, 1.9, 2.5) + 0.1 * Vec3::from(s.uniform_3()),
        direction: Vec3::ZERO,
        intensity: Rgb::gray(factor(number)),
        kind: VplKind::Omni,
    };
    let lights = tree((0..count).map(light).collect());
    let clusters = Clusters { lights: &lights, points: &points, contribution: TRANSPORT };
    let mut memory = RefinementMemory::default();
    let mut refinement = Refinement::new(clusters, OPTIONS, &mut memory).unwrap();
    assert!(!split_all(&mut refinement).is_empty());
    let (mut largest, mut smallest) = (0.0, f64::INFINITY);
    // All pairs except the first, which is tabulated only when it is split.
    for (number, pair) in refinement.pairs().iter().enumerate().skip(1) {
        let entry = refinement.info(number).table.unwrap();
        let sum: f64 = terms(&clusters, pair).iter().sum();
        assert!((entry.total - sum).abs() <= 1e-9 * sum, "{} of {sum}: {pair:?}", entry.total);
        if sum > 0.0 {
            (largest, smallest) = (f64::max(largest, sum), f64::min(smallest, sum));
        }
    }
    assert!(largest > 1e14 * smallest, "{largest} {smallest}");
}

/// χ² test of the frequencies of 20,000 draws against their probabilities. With about 20 degrees of
/// freedom χ² exceeds 60 once in 100,000 runs.
#[test]
fn terms_are_drawn_in_proportion_to_their_values() {
    let (lights, points) = world();
    let clusters = Clusters { lights: &lights, points: &points, contribution: TRANSPORT };
    let mut s = Stream::new(3, Purpose::Test, 1);
    let mut tested = 0;
    let leaf_points = points.root().unwrap();
    for light in lights.depth_first() {
        let pair = Pair { light, points: leaf_points, upper: KernelBound(1.0) };
        if clusters.terms(&pair) > OPTIONS.tabulated {
            continue;
        }
        let mut table = TermTable::default();
        let entry = table.add(&clusters, &pair);
        if entry.lit < 15 {
            continue;
        }
        let values = terms(&clusters, &pair);
        let (sum, draws) = (values.iter().sum::<f64>(), 20_000);
        let mut counts = vec![0; values.len()];
        let all: Vec<_> = clusters.all_terms(&pair).collect();
        for _ in 0..draws {
            let drawn = table.draw(&clusters, &pair, &entry, s.uniform_f64());
            counts[all.iter().position(|term| *term == drawn).unwrap()] += 1;
        }
        let mut chi = 0.0;
        for (count, value) in counts.iter().zip(&values) {
            let expected = f64::from(draws) * value / sum;
            if *value == 0.0 {
                assert_eq!(*count, 0, "nothing dark is drawn");
            } else {
                chi += (f64::from(*count) - expected).powi(2) / expected;
            }
        }
        assert!(chi < 3.0 * values.len() as f64 + 30.0, "{chi} of {} terms", entry.lit);
        tested += 1;
    }
    assert!(tested > 5, "{tested}");
}
