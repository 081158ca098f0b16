//! Quality and cost of light trees, as a table in Markdown.
//!
//!     cargo run --release --example tree_quality [LIGHTS]
//!
//! Lights are the VPLs of the built-in room. They are repeated with small shifts until there are
//! `LIGHTS` (default 10⁶).
//!
//! * "bound": mean over random points of the room of `Σ_k I_k G_ub / Σ_i I_i G_i` for the cut of
//!   256 clusters with the largest bounds: the ratio of the bounds of that cut to the light that
//!   they bound, without visibility and material.
//! * "area": `Σ I_C (d² + c² (1 − cos β)²)` over inner nodes, over that of the root (Walter et al.
//!   2005).

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::sync::Arc;
use std::time::Instant;

use tashika::accel::Tracer;
use tashika::bounds::{LightShape, Towards, upper_geometric};
use tashika::math::{Aabb, Vec3};
use tashika::rng::{Purpose, Stream};
use tashika::scene::builtin;
use tashika::tree::{LightCluster, LightTree, LightTreeBuilder};
use tashika::vpl::{Provenance, Vpl, VplKind, VplOptions, VplSet};

/// Number of random points, and number of clusters in the cut for each point.
const POINTS: usize = 100;
const CLUSTERS: usize = 256;

fn main() {
    let count: usize = std::env::args().nth(1).map_or(1_000_000, |n| n.parse().expect("a number of lights"));
    let tracer = Tracer::new(Arc::new(builtin::room()));
    let options = VplOptions { count: 100_000, ..VplOptions::default() };
    let traced = VplSet::trace(&tracer, &options).expect("the room has lamps");
    let mut stream = Stream::new(1, Purpose::Test, 0);
    let lights: Vec<Vpl> = (0..count)
        .map(|i| {
            let light = traced.lights()[i % traced.len()];
            let shift = (Vec3::from(stream.uniform_3()) - 0.5) * 0.05;
            if light.kind == VplKind::Oriented && i >= traced.len() {
                // Along the surface.
                let along = shift - light.direction * shift.dot(light.direction);
                Vpl { position: light.position + along, ..light }
            } else {
                light
            }
        })
        .collect();
    let set = VplSet::new(lights, Provenance::default());
    println!("| builder | lights | seconds | bytes a light | bound | area |");
    println!("|---|---:|---:|---:|---:|---:|");
    for builder in [LightTreeBuilder::TopDown, LightTreeBuilder::Agglomerative] {
        let begun = Instant::now();
        let tree = LightTree::build(&set, builder);
        let seconds = begun.elapsed().as_secs_f64();
        tree.validate().expect("trees are valid");
        let bytes = tree.bytes() as f64 / set.len() as f64;
        let (bound, area) = (bound(&tree), area(&tree));
        println!("| {builder:?} | {count} | {seconds:.2} | {bytes:.0} | {bound:.2} | {area:.1} |");
    }
}

fn bound(tree: &LightTree) -> f64 {
    let mut stream = Stream::new(2, Purpose::Test, 0);
    let root = tree.root().expect("there are lights");
    let room = tree.bounds(&root).aabb;
    let sum: f64 = (0..POINTS)
        .map(|_| {
            let at = room.lo + room.size() * (Vec3::from(stream.uniform_3()) * 0.8 + 0.1);
            let point = Aabb { lo: at, hi: at };
            let upper = |cluster: &LightCluster| {
                let bounds = tree.bounds(cluster);
                let towards = Towards::between(&bounds, &point);
                tree.luminance(cluster) * f64::from(upper_geometric(&bounds, &towards, 0.1))
            };
            let mut cut = vec![(upper(&root), root)];
            while cut.len() < CLUSTERS {
                let splits = |(_, (_, cluster)): &(usize, (f64, LightCluster))| cluster.count > 1;
                let largest =
                    cut.iter().copied().enumerate().filter(splits).max_by(|a, b| a.1.0.total_cmp(&b.1.0));
                let Some((place, (_, cluster))) = largest else { break };
                cut.swap_remove(place);
                let children = tree.children(&cluster).expect("it splits");
                cut.extend(children.map(|child| (upper(&child), child)));
            }
            let value: f64 = tree.lights().iter().map(|light| f64::from(geometric(&light, at))).sum();
            cut.iter().map(|c| c.0).sum::<f64>() / value
        })
        .sum();
    sum / POINTS as f64
}

/// `I G` without visibility, clamped at 0.1 m.
fn geometric(light: &Vpl, at: Vec3) -> f32 {
    let d = light.position - at;
    let shape = match light.kind {
        VplKind::Oriented => -light.direction.dot(d.normalize()),
        VplKind::Omni => 1.0,
        VplKind::Image(_) | VplKind::Volume(_) => 1.0,
        VplKind::Spot(falloff) => falloff.at(-light.direction.dot(d.normalize())),
        VplKind::Directional => return light.intensity.luminance(),
    };
    light.intensity.luminance() * shape.max(0.0) / d.length_squared().max(0.01)
}

fn area(tree: &LightTree) -> f64 {
    let root = tree.root().expect("there are lights");
    let c2 = f64::from(tree.bounds(&root).aabb.diagonal()).powi(2);
    let cost = |cluster: LightCluster| {
        let bounds = tree.bounds(&cluster);
        let narrow = match bounds.shape {
            LightShape::Oriented(cone) => 1.0 - f64::from(cone.cos.clamp(-1.0, 1.0)),
            _ => 2.0,
        };
        let diagonal = f64::from(bounds.aabb.diagonal());
        tree.luminance(&cluster) * (diagonal * diagonal + c2 * narrow * narrow)
    };
    let inner = tree.depth_first().filter(|cluster| cluster.count > 1);
    inner.map(cost).sum::<f64>() / cost(root)
}
