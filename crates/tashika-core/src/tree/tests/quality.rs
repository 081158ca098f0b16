//! Tests of the quality of trees: clusters are compact and face one way.

use super::{BUILDERS, oriented, point, room, set};
use crate::bounds::LightShape;
use crate::math::Vec3;
use crate::rng::{Purpose, Stream};
use crate::tree::{LightCluster, LightTree, LightTreeBuilder};
use crate::vpl::Vpl;
use crate::warp;

/// `c²` (m²).
fn c2(tree: &LightTree) -> f64 {
    f64::from(tree.bounds(&tree.root().unwrap()).aabb.diagonal()).powi(2)
}

/// Sum over inner nodes of `I_C (d² + c² (1 − cos β)²)` (Walter 2005).
fn cost(tree: &LightTree) -> f64 {
    let c2 = c2(tree);
    let of_cluster = |cluster: LightCluster| {
        let bounds = tree.bounds(&cluster);
        let LightShape::Oriented(cone) = bounds.shape else { panic!("oriented lights only") };
        let (d, narrow) = (f64::from(bounds.aabb.diagonal()), 1.0 - f64::from(cone.cos.clamp(-1.0, 1.0)));
        tree.luminance(&cluster) * (d * d + c2 * narrow * narrow)
    };
    tree.depth_first().filter(|cluster| cluster.count > 1).map(of_cluster).sum()
}

/// If squares are halved level by level, each level costs half as much as the one above. All levels
/// below a wall therefore cost about as much as two walls; the remaining cost arises where walls
/// meet. Measured, in units of the root's cost: 7.4 (top-down), 5.7 (agglomerative; 8.2 without
/// normals).
#[test]
fn clusters_are_compact_and_face_one_way() {
    let lights = room(20_000, 6);
    for (builder, most) in BUILDERS.into_iter().zip([8.5, 7.0]) {
        let tree = LightTree::build(&set(lights.clone()), builder);
        let relative = cost(&tree) / (tree.luminance(&tree.root().unwrap()) * 2.0 * c2(&tree));
        assert!(relative < most, "{builder:?}: {relative}");
    }
}

/// Lights of two opposite normals, mixed in space. Nodes with a hundredth of the lights contain
/// only one normal.
#[test]
fn opposite_normals_are_told_apart() {
    let mut s = Stream::new(3, Purpose::Test, 1);
    let lights: Vec<Vpl> = (0..4000)
        .map(|i| oriented(point(&mut s), if i % 2 == 0 { Vec3::Y } else { -Vec3::Y }, 1.0))
        .collect();
    for builder in BUILDERS {
        let tree = LightTree::build(&set(lights.clone()), builder);
        let small = tree.depth_first().filter(|cluster| cluster.count <= 40);
        let one_normal =
            |c: &LightCluster| matches!(tree.bounds(c).shape, LightShape::Oriented(c) if c.cos == 1.0);
        let (pure, all) = small.fold((0, 0), |(p, n), cluster| (p + u32::from(one_normal(&cluster)), n + 1));
        assert!(pure == all, "{builder:?}: {pure} of {all}");
    }
}

/// Lights in a row, or at one position, have boxes without area. Halving them is optimal.
#[test]
fn rows_and_heaps_are_halved() {
    let mut s = Stream::new(3, Purpose::Test, 2);
    let row: Vec<Vpl> = (0..4096).map(|i| oriented(Vec3::X * i as f32, Vec3::Y, 1.0)).collect();
    let heap = (0..4096).map(|_| oriented(Vec3::ONE, warp::sphere(s.uniform_2()), 1.0)).collect();
    for lights in [row, heap] {
        let tree = LightTree::build(&set(lights), LightTreeBuilder::TopDown);
        let [left, right] = tree.children(&tree.root().unwrap()).unwrap().map(|half| half.count);
        assert!(left.min(right) > 1500, "{left} {right}");
    }
}

/// The order of the input lights does not affect the quality.
#[test]
fn shuffled_lights_give_trees_as_good() {
    let ordered = room(5000, 2);
    let mut shuffled: Vec<Vpl> = ordered.clone();
    let mut s = Stream::new(1, Purpose::Test, 0);
    for i in (1..shuffled.len()).rev() {
        shuffled.swap(i, s.below(i as u64 + 1) as usize);
    }
    for builder in BUILDERS {
        let [a, b] = [&ordered, &shuffled].map(|l| cost(&LightTree::build(&set(l.clone()), builder)));
        assert!((a / b - 1.0).abs() < 1e-3, "{builder:?}: {a} {b}");
    }
}
