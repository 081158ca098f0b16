//! Tests of draws against the weights to which they should be proportional.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{mixed, oriented, point, set};
use crate::math::Vec3;
use crate::math::elementary::powf;
use crate::rng::{Purpose, Stream};
use crate::tree::prefix::PrefixSums;
use crate::tree::{LightTree, LightTreeBuilder};

/// χ² test of one million draws from each of four nodes at a level of 10⁻⁴ each.
#[test]
fn lights_are_drawn_in_proportion_to_luminance() {
    let mut s = Stream::new(4, Purpose::Test, 0);
    let lights = (0..400).map(|_| oriented(point(&mut s), Vec3::Y, 0.2 + s.uniform() * 3.0)).collect();
    let tree = LightTree::build(&set(lights), LightTreeBuilder::TopDown);
    let smaller = |most: u32| tree.depth_first().find(|c| c.count > 2 && c.count < most).unwrap();
    let draws = 1_000_000;
    for node in [tree.root().unwrap(), smaller(200), smaller(60), smaller(10)] {
        let mut counts = vec![0u32; node.count as usize];
        for _ in 0..draws {
            counts[(tree.draw(&node, s.uniform_f64()) - node.first) as usize] += 1;
        }
        let statistic: f64 = (node.first..)
            .zip(&counts)
            .map(|(i, &count)| {
                let share = f64::from(tree.light(i).intensity.luminance()) / tree.luminance(&node);
                let expected = share * f64::from(draws);
                (f64::from(count) - expected).powi(2) / expected
            })
            .sum();
        let limit = ChiSquared::new(f64::from(node.count - 1)).unwrap().inverse_cdf(1.0 - 1e-4);
        assert!(statistic < limit, "{node:?}: {statistic} > {limit}");
    }
}

#[test]
fn every_draw_is_in_its_node() {
    let tree = LightTree::build(&set(mixed(3000, 8)), LightTreeBuilder::Agglomerative);
    for node in tree.depth_first() {
        for u in [0.0, 1e-300, 0.5, 1.0f64.next_down()] {
            assert!(
                (node.first..node.first + node.count).contains(&tree.draw(&node, u)),
                "{node:?}, u = {u}"
            );
        }
        assert_eq!(tree.draw(&node, 0.0), node.first);
        assert_eq!(tree.draw(&node, 1.0f64.next_down()), node.first + node.count - 1);
    }
}

#[test]
fn items_of_no_weight_are_never_drawn() {
    let weights = [0.0, 0.0, 2.0, 0.0, 1e-30, 0.0, 3.0, 0.0];
    let sums = PrefixSums::new(weights.into_iter());
    for first in 0..8u32 {
        for count in 1..=8 - first {
            if weights[first as usize..(first + count) as usize].iter().all(|&w| w == 0.0) {
                continue;
            }
            for u in [0.0, 1e-31, 0.3, 0.4, 0.400_000_1, 0.999_999, 1.0f64.next_down(), 1.0] {
                let i = sums.draw(first, count, u);
                assert!(
                    (first..first + count).contains(&i) && weights[i as usize] > 0.0,
                    "{first}+{count}, {u}: {i}"
                );
            }
        }
    }
}

/// Weights differ by many orders of magnitude. The item drawn is the one found by a linear search
/// over all items.
#[test]
fn draws_are_those_of_a_search_of_all_items() {
    let mut s = Stream::new(9, Purpose::Test, 0);
    for orders in [0.0, 1.0, 12.0] {
        let weight = |s: &mut Stream| if s.below(4) == 0 { 0.0 } else { powf(10.0, orders * s.uniform()) };
        let weights: Vec<f32> = (0..500).map(|_| weight(&mut s)).collect();
        let sums = PrefixSums::new(weights.iter().copied());
        for _ in 0..20_000 {
            let first = s.below(499) as u32;
            let count = 1 + s.below(u64::from(500 - first)) as u32;
            if sums.weight(first, count) == 0.0 {
                continue;
            }
            let u = s.uniform_f64();
            let x = u * sums.weight(first, count);
            let item = (0..count).rfind(|&k| sums.weight(first, k) <= x).unwrap();
            assert_eq!(sums.draw(first, count, u), first + item, "{first}+{count}, {u}");
        }
    }
}

/// Two dim lights follow a light that is 10²⁵ times as bright. Their shares are exact, whereas sums
/// in a single `f64` would lose them.
#[test]
fn dim_lights_beside_bright_ones_keep_their_shares() {
    let sums = PrefixSums::new([1e20f32, 1e-5, 3e-5, 1e20].into_iter());
    let pair = sums.weight(1, 2);
    assert!((pair / (f64::from(1e-5f32) + f64::from(3e-5f32)) - 1.0).abs() < 1e-12, "{pair}");
    let n = 4000;
    let first = (0..n).filter(|&k| sums.draw(1, 2, (f64::from(k) + 0.5) / f64::from(n)) == 1).count();
    assert!((first as i32 - 1000).abs() <= 1, "{first} of 4000");
    assert_eq!(sums.draw(0, 4, 0.25), 0);
    assert_eq!(sums.draw(0, 4, 0.75), 3);
}
