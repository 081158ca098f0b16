//! Tests of pairs, their bounds and their order, on random lights and points.

mod distances;
mod pilot;
mod population;
mod table;

use super::{Clusters, Pair, Refinement, RefinementMemory, RefinementOptions, gather_tree};
use crate::bounds::tests::many;
use crate::bounds::{UpperAnalytic, UpperConstant, UpperCubeMap, UpperMaterial};
use crate::bsdf::{Bsdf, Conductor, ConductorFresnel, HenyeyGreenstein, Lambert, MetallicRoughness, Phong};
use crate::color::Rgb;
use crate::contribution::ContributionKernel;
use crate::gather::GatherPoint;
use crate::math::elementary::exp;
use crate::math::{Frame, Vec3};
use crate::media::Scattering;
use crate::rng::{Purpose, Stream};
use crate::scene::{Falloff, FalloffShape, MediumId};
use crate::tree::{LightTree, LightTreeBuilder};
use crate::vpl::{Provenance, Vpl, VplKind, VplSet};
use crate::warp;

/// Distance below which the geometric term of the tests no longer grows (m).
const CLAMP: f32 = 0.05;
const TRANSPORT: ContributionKernel = ContributionKernel::new(CLAMP);

/// Lights of all kinds in a room with sides of 4 m.
fn lights(n: usize, s: &mut Stream) -> LightTree {
    let falloff = Falloff { cos_inner: 0.9, cos_outer: 0.4, shape: FalloffShape::Smoothstep };
    let light = |s: &mut Stream| {
        let (position, direction) = (Vec3::from(s.uniform_3()) * 4.0, warp::sphere(s.uniform_2()));
        let intensity = Rgb::from(s.uniform_3()).map(|c| c + 0.01);
        match s.below(8) {
            0 => Vpl { position, direction: Vec3::ZERO, intensity, kind: VplKind::Omni },
            1 => Vpl { position, direction, intensity, kind: VplKind::Spot(falloff) },
            2 => Vpl { position: Vec3::ZERO, direction, intensity, kind: VplKind::Directional },
            _ => Vpl { position, direction, intensity, kind: VplKind::Oriented },
        }
    };
    let lights = (0..n).map(|_| light(s)).collect();
    tree(lights)
}

fn tree(lights: Vec<Vpl>) -> LightTree {
    LightTree::build(&VplSet::new(lights, Provenance::default()), LightTreeBuilder::default())
}

/// Points on a bumpy floor in the middle of the room, with four materials, seen from one side.
fn points(n: usize, s: &mut Stream) -> Vec<GatherPoint> {
    let point = |s: &mut Stream| {
        let [x, y] = s.uniform_2();
        let normal = (Vec3::Z + 0.3 * warp::sphere(s.uniform_2())).normalize();
        let frame = Frame::about(normal);
        let bsdf = match s.below(4) {
            0 => Bsdf::Lambert(Lambert { reflectance: Rgb::new(0.8, 0.2, 0.4) }),
            1 => Bsdf::Phong(Phong { diffuse: Rgb::gray(0.1), specular: Rgb::gray(0.8), exponent: 200.0 }),
            2 => Bsdf::Conductor(Conductor {
                fresnel: ConductorFresnel::Exact { eta: Rgb::gray(0.2), k: Rgb::gray(3.0) },
                specular: Rgb::WHITE,
                facets: 0.05.into(),
            }),
            _ => Bsdf::MetallicRoughness(MetallicRoughness {
                diffuse: Rgb::gray(0.3),
                f0: Rgb::gray(0.04),
                dielectric_f0: Rgb::gray(0.04),
                facets: 0.2.into(),
            }),
        };
        GatherPoint {
            position: Vec3::new(1.8 + 0.4 * x, 1.8 + 0.4 * y, 0.5),
            geometric_normal: Vec3::Z,
            frame,
            wo: frame.to_local(Vec3::new(0.6, 0.1, 0.79).normalize()),
            bsdf,
            weight: Rgb::from(s.uniform_3()).map(|c| 0.1 + c),
            medium: None,
            phase: None,
            instant: 0,
        }
    };
    (0..n).map(|_| point(s)).collect()
}

/// Lights of which half are on surfaces of the room and half in its fog, with two phase functions.
fn lights_in_media(n: usize, s: &mut Stream) -> LightTree {
    let light = |s: &mut Stream| {
        let (position, direction) = (Vec3::from(s.uniform_3()) * 4.0, warp::sphere(s.uniform_2()));
        let phase = HenyeyGreenstein { asymmetry: [0.8, -0.3][s.below(2) as usize] };
        let intensity = Rgb::from(s.uniform_3()).map(|c| c + 0.01);
        Vpl { position, direction: direction.normalize(), intensity, kind: VplKind::Volume(phase) }
    };
    let on_surfaces = lights(n / 2, s);
    let in_media = (0..n - n / 2).map(|_| light(s));
    tree(on_surfaces.lights().iter().chain(in_media).collect())
}

/// Points on the floor, and points on the viewer's way to it.
fn points_in_media(n: usize, s: &mut Stream) -> Vec<GatherPoint> {
    let mut points = points(n, s);
    let before = Vec3::new(-0.6, -0.1, -0.79).normalize();
    for point in points.iter_mut().skip(n / 2) {
        let phase = HenyeyGreenstein { asymmetry: [0.7, -0.5, 0.0][s.below(3) as usize] };
        let place = point.position - before * s.uniform();
        let at = Scattering { place, before, medium: MediumId::at(0), phase };
        *point = GatherPoint::in_medium(&at, point.weight);
    }
    points
}

/// The pairs of the cut after `splits` splits.
fn cut<B: UpperMaterial>(refinement: &mut Refinement<'_, B>, splits: usize) -> Vec<Pair> {
    let mut in_cut = vec![true];
    for _ in 0..splits {
        let Some(split) = refinement.split_next() else { break };
        in_cut[split.parent as usize] = false;
        in_cut.extend([true, true]);
    }
    refinement.pairs().iter().zip(in_cut).filter(|(_, inside)| *inside).map(|(pair, _)| *pair).collect()
}

/// Draws terms of all pairs from the roots down. None is brighter than the bound of its pair.
fn terms_are_within_bounds<B: UpperMaterial>() {
    for round in 0..many(8) {
        let mut s = Stream::new(round as u64, Purpose::Test, 7);
        let (lights, points) = match round % 2 {
            0 => (lights(200, &mut s), points(12, &mut s)),
            _ => (lights_in_media(200, &mut s), points_in_media(12, &mut s)),
        };
        let points = gather_tree::<B>(&points);
        // Homogeneous fog whose extinction is smallest in the last channel.
        let sigma = if round % 4 == 1 { Rgb::new(1.5, 0.7, 0.4) } else { Rgb::BLACK };
        let contribution = TRANSPORT.dimmed(sigma.b);
        let clusters = Clusters { lights: &lights, points: &points, contribution };
        let mut memory = RefinementMemory::default();
        let mut refinement = Refinement::new(clusters, RefinementOptions::PUBLISHED, &mut memory).unwrap();
        cut(&mut refinement, 1500);
        let (mut checked, mut lit) = (0, 0);
        for pair in refinement.pairs() {
            let (c, g) = (&pair.light, &points.nodes()[pair.points as usize]);
            for i in c.first..c.first + c.count {
                for j in g.first..g.first + g.count {
                    let (light, point) = (lights.light(i), points.point(j));
                    let metres = match light.kind {
                        VplKind::Directional => f32::INFINITY,
                        _ => light.position.distance(point.position),
                    };
                    let left = sigma.map(|sigma| if sigma > 0.0 { exp(-sigma * metres) } else { 1.0 });
                    let term = f64::from((TRANSPORT.unoccluded(point, &light) * left).luminance());
                    let drawn_from = f64::from(light.intensity.luminance())
                        * f64::from(point.weight.max_channel())
                        / (lights.luminance(c) * f64::from(g.weight));
                    // Luminance and weights have a few roundings that are not part of the bounded
                    // product.
                    assert!(
                        term / drawn_from <= clusters.upper(pair).0 * (1.0 + 8.0 * f64::from(f32::EPSILON)),
                        "{pair:?}: {} > {}: {light:?} {point:?}",
                        term / drawn_from,
                        clusters.upper(pair).0
                    );
                    checked += 1;
                    lit += u32::from(term > 0.0);
                }
            }
        }
        assert!(checked > 10_000 && lit > 1000, "{checked} terms, {lit} lit");
    }
}

#[test]
fn terms_are_within_constant_bounds() {
    terms_are_within_bounds::<UpperConstant>();
}

#[test]
fn terms_are_within_analytic_bounds() {
    terms_are_within_bounds::<UpperAnalytic>();
}

#[test]
fn terms_are_within_bounds_from_cube_maps() {
    terms_are_within_bounds::<UpperCubeMap>();
}

/// A point with a share of 2⁻²⁵ is drawn. With random numbers of 24 bits it never would be.
#[test]
fn points_of_hardly_any_weight_are_drawn() {
    let mut s = Stream::new(5, Purpose::Test, 0);
    let mut points = points(2, &mut s);
    points[0].weight = Rgb::WHITE;
    points[1].weight = Rgb::gray(1.0 / (1 << 25) as f32);
    let (lights, tree) = (lights(1, &mut s), gather_tree::<UpperConstant>(&points));
    let clusters = Clusters { lights: &lights, points: &tree, contribution: TRANSPORT };
    let root = clusters.roots().next().unwrap();
    // The probability that none of 2²⁹ draws returns the faint point is e⁻¹⁶, whether it is the
    // first or the last.
    let is_faint = |point: u32| tree.source(point) == 1;
    assert!((0..1_u64 << 29).any(|_| is_faint(clusters.draw(&root, &mut s).point)));
}

#[test]
fn a_cut_holds_every_term_once() {
    let mut s = Stream::new(5, Purpose::Test, 7);
    let (lights, points) = (lights(60, &mut s), gather_tree::<UpperAnalytic>(&points(9, &mut s)));
    let mut memory = RefinementMemory::default();
    for splits in [1_000_000, 0, 1, 10, 100] {
        let clusters = Clusters { lights: &lights, points: &points, contribution: TRANSPORT };
        let mut held = vec![0; 60 * 9];
        // The memory is reused; its earlier contents must not matter.
        let mut refinement = Refinement::new(clusters, RefinementOptions::PUBLISHED, &mut memory).unwrap();
        for pair in cut(&mut refinement, splits) {
            let (c, g) = (&pair.light, &points.nodes()[pair.points as usize]);
            for i in c.first..c.first + c.count {
                for j in g.first..g.first + g.count {
                    held[(i * 9 + j) as usize] += 1;
                }
            }
        }
        assert!(held.iter().all(|&times| times == 1), "after {splits} splits");
    }
}

#[test]
fn bounds_never_grow_on_the_way_down() {
    let mut s = Stream::new(6, Purpose::Test, 7);
    let (lights, points) = (lights(300, &mut s), gather_tree::<UpperAnalytic>(&points(16, &mut s)));
    let clusters = Clusters { lights: &lights, points: &points, contribution: TRANSPORT };
    let mut memory = RefinementMemory::default();
    let mut refinement = Refinement::new(clusters, RefinementOptions::PUBLISHED, &mut memory).unwrap();
    let mut last = f64::INFINITY;
    let mut splits = 0;
    while let Some(split) = refinement.split_next() {
        let parent = refinement.pairs()[split.parent as usize];
        let children = &refinement.pairs()[split.children as usize..];
        assert!(children.iter().all(|child| child.upper <= parent.upper));
        assert!(split.rank <= last, "the largest bound of a cut falls: {} after {last}", split.rank);
        last = split.rank;
        splits += 1;
    }
    assert!(splits > 100);
    assert_eq!(refinement.highest_rank(), None);
}

#[test]
fn nothing_times_anything_is_no_sum() {
    let mut s = Stream::new(6, Purpose::Test, 8);
    let (no_lights, no_points) = (lights(0, &mut s), gather_tree::<UpperAnalytic>(&[]));
    let (lights, points) = (lights(3, &mut s), gather_tree::<UpperAnalytic>(&points(3, &mut s)));
    let root = |lights, points| Clusters { lights, points, contribution: TRANSPORT }.roots().next();
    assert!(root(&no_lights, &points).is_none() && root(&lights, &no_points).is_none());
    assert!(root(&lights, &points).is_some());
}
