//! Tests of the structure of light trees, for various inputs and numbers of threads.

use super::{BUILDERS, mixed, oriented, point, room, set};
use crate::bounds::LightShape;
use crate::color::Rgb;
use crate::math::elementary::powf;
use crate::math::{Cone, Instants, Vec3};
use crate::rng::{Purpose, Stream};
use crate::tree::{LightCluster, LightTree, LightTreeBuilder};
use crate::vpl::{LightRows, Provenance, Vpl, VplKind, VplSet};
use crate::warp;

/// Number of levels below the root.
fn depth(tree: &LightTree) -> usize {
    let mut depths = vec![0; tree.clusters()];
    for cluster in tree.depth_first() {
        for child in tree.children(&cluster).into_iter().flatten() {
            depths[child.number()] = depths[cluster.number()] + 1;
        }
    }
    depths.into_iter().max().unwrap_or(0)
}

fn sorted_bits(lights: impl Iterator<Item = Vpl>) -> Vec<[u32; 9]> {
    let bits = |l: Vpl| {
        let (p, d, i) = (l.position.to_array(), l.direction.to_array(), l.intensity.to_array());
        std::array::from_fn(|k| [p, d, i][k / 3][k % 3].to_bits())
    };
    let mut all: Vec<[u32; 9]> = lights.map(bits).collect();
    all.sort_unstable();
    all
}

/// Inputs that could make builders fail, each with a name.
fn degenerate() -> Vec<(&'static str, Vec<Vpl>)> {
    let n = 3000;
    let mut s = Stream::new(11, Purpose::Test, 0);
    let mut of =
        |f: &mut dyn FnMut(usize, &mut Stream) -> Vpl| -> Vec<Vpl> { (0..n).map(|i| f(i, &mut s)).collect() };
    vec![
        ("one position and normal", of(&mut |_, _| oriented(Vec3::ONE, Vec3::Z, 1.0))),
        ("one position", of(&mut |_, s| oriented(Vec3::ONE, warp::sphere(s.uniform_2()), s.uniform() + 0.1))),
        ("two positions", of(&mut |i, _| oriented(Vec3::ONE * (i % 2) as f32, Vec3::Z, 1.0))),
        (
            "one position but for one light",
            of(&mut |i, _| oriented(Vec3::X * f32::from(i == 77), Vec3::Z, 1.0)),
        ),
        ("a plane", of(&mut |_, s| oriented(point(s) * Vec3::new(1.0, 0.0, 1.0), Vec3::Y, 1.0))),
        ("a line", of(&mut |i, _| oriented(Vec3::X * i as f32, Vec3::Y, 1.0))),
        (
            "a line, each brighter than all before",
            of(&mut |i, _| oriented(Vec3::X * i as f32, Vec3::Y, powf(2.0, (i % 200) as f32 - 100.0))),
        ),
        (
            "a line, each as far as all before",
            of(&mut |i, _| oriented(Vec3::X * powf(2.0, (i % 250) as f32 - 125.0), Vec3::Y, 1.0)),
        ),
        (
            "a short line, each as far as all before",
            (0..250).map(|i| oriented(Vec3::X * powf(2.0, i as f32 - 125.0), Vec3::Y, 1.0)).collect(),
        ),
        ("huge", of(&mut |_, s| oriented((point(s) - 0.5) * 3e38 * 2.0, warp::sphere(s.uniform_2()), 1e37))),
        ("tiny", of(&mut |_, s| oriented(point(s) * 1e-42, Vec3::Y, 1e-40))),
        ("far away", of(&mut |_, s| oriented(point(s) * 1e-3 + 1e6, Vec3::Y, 1.0))),
        (
            "opposite normals",
            of(&mut |i, s| oriented(point(s), if i % 2 == 0 { Vec3::Y } else { -Vec3::Y }, 1.0)),
        ),
        (
            "one omni among suns",
            of(&mut |i, s| {
                let direction = warp::sphere(s.uniform_2());
                let sun = Vpl { kind: VplKind::Directional, ..oriented(Vec3::ZERO, direction, 1e5) };
                if i == 5 {
                    Vpl { kind: VplKind::Omni, ..oriented(Vec3::ONE, Vec3::ZERO, 1e-6) }
                } else {
                    sun
                }
            }),
        ),
        ("black but for three", of(&mut |i, s| oriented(point(s), Vec3::Y, f32::from(i % 1000 == 7)))),
    ]
}

#[test]
fn trees_are_valid_and_hold_every_light_once() {
    let cases = [0, 1, 2, 3, 5, 9, 17, 300, 20_000].map(|n| ("mixed", mixed(n, 3)));
    let walls = [("room", room(5000, 1))];
    for (name, lights) in cases.into_iter().chain(walls).chain(degenerate()) {
        for builder in BUILDERS {
            let tree = LightTree::build(&set(lights.clone()), builder);
            tree.validate().unwrap_or_else(|e| panic!("{builder:?}, {} {name}: {e}", lights.len()));
            let lit: Vec<Vpl> = lights.iter().filter(|l| !l.intensity.is_black()).copied().collect();
            assert_eq!(
                sorted_bits(tree.lights().iter()),
                sorted_bits(lit.iter().copied()),
                "{builder:?}, {name}"
            );
            assert_eq!(tree.dropped(), lights.len() - lit.len());
            assert_eq!(tree.root().is_some(), !lit.is_empty());
            let limit = 64 + lit.len().max(1).ilog2() as usize;
            assert!(depth(&tree) <= limit, "{builder:?}, {name}: {} levels", depth(&tree));
        }
    }
}

/// Several instants, some with no light or one. Each has the same tree as its lights would have
/// alone.
#[test]
fn instants_have_their_own_trees() {
    let counts = [40, 0, 1, 300, 1, 5000, 0];
    let of_instants = counts.map(|n| mixed(n, 4));
    let lights = of_instants.concat();
    let shares: Vec<f32> = (0..7u8).map(|k| f32::from(k) / 7.0).collect();
    let counts = counts.map(|n| n as u64);
    let set_at = |counts: &[u64]| {
        let instants = Instants::new(shares.clone()).unwrap();
        VplSet::at_instants(lights.clone(), instants, counts, Provenance::default())
    };
    assert!(set_at(&counts[..6]).is_none() && set_at(&[1; 7]).is_none());
    let all = set_at(&counts).unwrap();
    for builder in BUILDERS {
        let tree = LightTree::build(&all, builder);
        tree.validate().unwrap();
        assert_eq!(tree.roots().count(), 5);
        let mut clusters = 0;
        for (instant, of_instant) in (0..).zip(&of_instants) {
            let alone = LightTree::build(&set(of_instant.clone()), builder);
            let (root, own) = (tree.root_at(instant), alone.root());
            assert_eq!(root.map(|root| root.count), own.map(|root| root.count));
            let mut waiting: Vec<_> = root.into_iter().zip(own).collect();
            while let Some((a, b)) = waiting.pop() {
                clusters += 1;
                assert_eq!(tree.bounds(&a), alone.bounds(&b), "{builder:?}, {instant}");
                assert_eq!(tree.luminance(&a).to_bits(), alone.luminance(&b).to_bits());
                assert_eq!(tree.light(a.first), alone.light(b.first));
                let halves = tree.children(&a).into_iter().flatten();
                waiting.extend(halves.zip(alone.children(&b).into_iter().flatten()));
            }
        }
        assert_eq!(clusters, tree.clusters());
        assert_eq!(tree.depth_first().count(), clusters);
        assert_eq!(tree.split(9, |cluster| f64::from(cluster.count)).len(), 9);
        assert_eq!(tree.split(3, |_| 1.0).len(), 5, "each instant has one");
    }
}

/// Enough lights that nodes are split, binned and merged in parallel. The number of threads does
/// not change the tree.
#[test]
fn threads_do_not_enter() {
    let lights = set(mixed(200_000, 5));
    for builder in BUILDERS {
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| LightTree::build(&lights, builder))
        };
        let (one, many) = (build(1), build(7));
        assert!(one == many, "{builder:?}");
        one.validate().unwrap();
    }
}

#[test]
fn kinds_have_their_own_subtrees() {
    for builder in BUILDERS {
        let tree = LightTree::build(&set(mixed(1000, 9)), builder);
        let is_mixed = |c: &LightCluster| matches!(tree.bounds(c).shape, LightShape::Mixed { .. });
        assert_eq!(tree.depth_first().filter(is_mixed).count(), 4, "five kinds are joined by four nodes");
        let alone = LightTree::build(&set(room(1000, 9)), builder);
        assert!(matches!(alone.bounds(&alone.root().unwrap()).shape, LightShape::Oriented(_)));
    }
}

/// The lights, with one of them changed.
fn with(lights: &LightRows, which: usize, change: fn(&mut Vpl)) -> LightRows {
    let mut lights: Vec<Vpl> = lights.iter().collect();
    change(&mut lights[which]);
    LightRows::new(lights.into_iter())
}

/// Each possible defect of a tree is found.
#[test]
fn validation_finds_what_is_wrong() {
    let good = LightTree::build(&set(mixed(500, 2)), LightTreeBuilder::TopDown);
    let inner = good
        .depth_first()
        .find(|c| (6..100).contains(&c.count) && matches!(good.bounds(c).shape, LightShape::Oriented(_)));
    let inner = inner.unwrap().number();
    type Damage<'a> = &'a dyn Fn(&mut LightTree);
    let damages: [(&str, Damage); 10] = [
        ("a node less", &|t| _ = t.nodes.pop()),
        ("a node more", &|t| t.nodes.push(t.nodes[inner])),
        ("nothing in the first half", &|t| t.nodes[inner].left = 0),
        ("nothing in the second half", &|t| t.nodes[inner].left = 4_000_000_000),
        ("halves of other sizes", &|t| t.nodes[inner].left ^= 1),
        ("luminance", &|t| t.nodes[inner].luminance *= 1.000_001),
        ("box", &|t| t.nodes[inner].bounds.aabb.hi.x = t.nodes[inner].bounds.aabb.lo.x),
        ("cone", &|t| t.nodes[inner].bounds.shape = LightShape::Oriented(Cone::of(Vec3::Z))),
        ("a light", &|t| t.lights = with(&t.lights, 17, |l| l.intensity = Rgb::gray(3.0))),
        ("a light's place", &|t| t.lights = with(&t.lights, 17, |l| l.position.x += 10.0)),
    ];
    good.validate().unwrap();
    for (name, damage) in damages {
        let mut tree = good.clone();
        damage(&mut tree);
        assert!(tree.validate().is_err(), "{name}");
    }
}
