//! Tests of gather trees: structure, draws, merged bounds.

use crate::bsdf::{Bsdf, Lambert, Phong};
use crate::color::Rgb;
use crate::gather::GatherPoint;
use crate::math::{Frame, Vec3};
use crate::rng::{Purpose, Stream};
use crate::tree::GatherTree;
use crate::warp;

fn gather_point(position: Vec3, normal: Vec3, weight: f32) -> GatherPoint {
    GatherPoint {
        position,
        geometric_normal: normal,
        frame: Frame::about(normal),
        wo: Vec3::new(0.6, 0.0, 0.8),
        bsdf: Bsdf::Lambert(Lambert { reflectance: Rgb::gray(0.5) }),
        weight: Rgb::gray(weight),
        medium: None,
        phase: None,
        instant: 0,
    }
}

fn random(n: usize, seed: u64) -> Vec<GatherPoint> {
    let mut s = Stream::new(seed, Purpose::Test, n as u64);
    (0..n)
        .map(|_| {
            let (p, d) = (Vec3::from(s.uniform_3()), warp::sphere(s.uniform_2()));
            gather_point(p, d, 0.1 + s.uniform())
        })
        .collect()
}

/// A tree in which the "material" of a node is the list of the first coordinates of its points.
fn tree_of(points: &[GatherPoint]) -> GatherTree<Vec<u32>> {
    GatherTree::build(points, |p| vec![p.position.x.to_bits()], |a, b| a.extend(b))
}

fn depth<B>(tree: &GatherTree<B>) -> usize {
    let mut depths = vec![0; tree.nodes().len()];
    for (k, node) in tree.nodes().iter().enumerate() {
        for child in node.children.into_iter().flatten() {
            depths[child as usize] = depths[k] + 1;
        }
    }
    depths.into_iter().max().unwrap_or(0)
}

#[test]
fn trees_are_valid_and_merge_the_materials_of_their_points() {
    let mut cases: Vec<Vec<GatherPoint>> = [0, 1, 2, 3, 4, 16, 256, 1024].map(|n| random(n, 1)).to_vec();
    let of = |f: &dyn Fn(usize) -> GatherPoint| (0..1024).map(f).collect::<Vec<_>>();
    cases.push(of(&|_| gather_point(Vec3::ONE, Vec3::Z, 1.0)));
    cases.push(of(&|i| gather_point(Vec3::X * f32::from(i == 9), Vec3::Z, 1.0)));
    cases.push(of(&|i| {
        gather_point(Vec3::X * crate::math::elementary::powf(2.0, (i % 250) as f32 - 125.0), Vec3::Z, 1.0)
    }));
    cases.push(of(&|i| gather_point(Vec3::splat(i as f32 * 3e35), Vec3::Z, 1.0)));
    cases.push(of(&|i| gather_point(Vec3::X * i as f32, Vec3::Z, f32::from(i % 3 == 0))));
    for (case, points) in cases.iter().enumerate() {
        let tree = tree_of(points);
        tree.validate().unwrap_or_else(|e| panic!("case {case}: {e}"));
        let with_weight = points.iter().filter(|p| !p.weight.is_black()).count();
        assert_eq!(tree.points().len(), with_weight, "case {case}");
        assert_eq!(tree.root().is_some(), with_weight > 0);
        assert!(depth(&tree) <= 32 + 11, "case {case}: {} levels", depth(&tree));
        for (k, node) in (0u32..).zip(tree.nodes()) {
            let range = node.first..node.first + node.count;
            let expected: Vec<u32> = range.map(|i| tree.point(i).position.x.to_bits()).collect();
            assert_eq!(tree.material(k), &expected, "case {case}, node {k}");
        }
    }
}

/// Points of several instants. No node contains points of different instants.
#[test]
fn instants_have_their_own_trees() {
    let mut points = random(100, 5);
    for (number, point) in points.iter_mut().enumerate() {
        point.instant = [7, 2, 0, 2][number % 4];
    }
    points[8].instant = 9;
    let tree = tree_of(&points);
    tree.validate().unwrap();
    let mut seen = Vec::new();
    for &(instant, root) in tree.roots() {
        let node = &tree.nodes()[root as usize];
        assert!((0..node.count).all(|k| tree.point(node.first + k).instant == instant));
        let of_instant = points.iter().filter(|p| p.instant == instant && !p.weight.is_black());
        assert_eq!(node.count as usize, of_instant.count());
        seen.push(instant);
    }
    assert_eq!(seen, [0, 2, 7, 9]);
}

#[test]
fn points_are_drawn_in_proportion_to_weight() {
    let tree = tree_of(&random(50, 3));
    let n = 1 << 20;
    for k in [0, 1, tree.nodes()[0].children.unwrap()[1]] {
        let node = &tree.nodes()[k as usize];
        let mut counts = vec![0u32; node.count as usize];
        for j in 0..n {
            counts[(tree.draw(k, (f64::from(j) + 0.5) / f64::from(n)) - node.first) as usize] += 1;
        }
        for (i, &count) in (node.first..).zip(&counts) {
            // Equidistant numbers can miss a share by one number at each end.
            let expected = f64::from(tree.point(i).weight.max_channel() / node.weight) * f64::from(n);
            assert!(
                (f64::from(count) - expected).abs() < 2.0 + 1e-6 * f64::from(n),
                "{count} for {expected}"
            );
        }
        assert_eq!(tree.draw(k, 1.0f64.next_down()), node.first + node.count - 1);
    }
}

/// Two walls that meet in a corner. Near the corner, normals separate the points where positions do
/// not.
#[test]
fn points_are_split_by_position_and_by_direction() {
    let mut s = Stream::new(2, Purpose::Test, 0);
    let corner: Vec<GatherPoint> = (0..200)
        .map(|i| {
            let along = Vec3::new(0.01 * s.uniform(), s.uniform() * 0.01, s.uniform() * 0.01);
            gather_point(along, if i % 2 == 0 { Vec3::X } else { Vec3::Y }, 1.0)
        })
        .collect();
    let one_normal = |tree: &GatherTree<Vec<u32>>, k: u32| {
        let node = &tree.nodes()[k as usize];
        let normal = |i| tree.point(i).frame.n;
        (node.first..node.first + node.count).all(|i| normal(i) == normal(node.first))
    };
    let tree = tree_of(&corner);
    assert!(tree.nodes()[0].children.unwrap().iter().all(|&child| one_normal(&tree, child)));

    // Glossy points are split by mirror direction: the normals are equal, but the points are seen
    // from two sides.
    let seen: Vec<GatherPoint> = (0..200)
        .map(|i| {
            let side = if i % 2 == 0 { 0.8 } else { -0.8 };
            GatherPoint {
                wo: Vec3::new(side, 0.0, 0.6),
                bsdf: Bsdf::Phong(Phong {
                    diffuse: Rgb::gray(0.2),
                    specular: Rgb::gray(0.5),
                    exponent: 50.0,
                }),
                ..gather_point(Vec3::from(s.uniform_3()) * 0.01, Vec3::Z, 1.0)
            }
        })
        .collect();
    let tree = tree_of(&seen);
    for child in tree.nodes()[0].children.unwrap() {
        let node = &tree.nodes()[child as usize];
        let side = |i| tree.point(i).wo.x;
        assert!((node.first..node.first + node.count).all(|i| side(i) == side(node.first)));
    }
}

#[test]
fn validation_finds_what_is_wrong() {
    let good = tree_of(&random(64, 7));
    type Damage<'a> = &'a dyn Fn(&mut GatherTree<Vec<u32>>);
    let damages: [(&str, Damage); 4] = [
        ("range", &|t| t.nodes[3].first += 1),
        ("box", &|t| t.nodes[1].aabb.lo.x -= 1.0),
        ("weight", &|t| t.nodes[2].weight *= 1.001),
        ("points", &|t| t.points.swap(3, 60)),
    ];
    good.validate().unwrap();
    for (name, damage) in damages {
        let mut tree = good.clone();
        damage(&mut tree);
        assert!(tree.validate().is_err(), "{name}");
    }
}
