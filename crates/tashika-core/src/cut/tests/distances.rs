//! Tests with lights all around the points: effect of distances on the order of refinement.

use super::super::{Rank, VisibilityPrior};
use super::*;

/// Visibility of each light.
const SEEN: f64 = 0.5;

/// Approximate distance between neighbours among `lights` lights on the floor (m).
fn clamp_distance(lights: usize) -> f32 {
    4.0 / (lights as f32).sqrt()
}

/// Lights on a square of 4 m with a total power of one.
fn on_floor(lights: usize) -> Vec<Vpl> {
    let mut s = Stream::new(5, Purpose::Test, 0);
    let intensity = Rgb::gray(1.0 / lights as f32);
    let light = |_| {
        let position = Vec3::new(4.0 * s.uniform() - 2.0, 4.0 * s.uniform() - 2.0, 0.0);
        Vpl { position, direction: Vec3::ZERO, intensity, kind: VplKind::Omni }
    };
    (0..lights).map(light).collect()
}

fn matt(position: Vec3) -> GatherPoint {
    GatherPoint {
        position,
        geometric_normal: Vec3::NEG_Z,
        frame: Frame::about(Vec3::NEG_Z),
        wo: Vec3::Z,
        bsdf: Bsdf::Lambert(Lambert { reflectance: Rgb::gray(0.5) }),
        weight: Rgb::WHITE,
        medium: None,
        phase: None,
        instant: 0,
    }
}

#[test]
fn the_mean_square_over_a_plane_is_told() {
    let (lights, clamp_distance) = (tree(on_floor(4000)), clamp_distance(4000));
    let contribution = ContributionKernel::new(clamp_distance);
    for height in [0.001, 0.3, 3.0] {
        let points = gather_tree::<UpperAnalytic>(&[matt(Vec3::new(0.0, 0.0, height))]);
        let clusters = Clusters { lights: &lights, points: &points, contribution };
        let pair = clusters.roots().next().unwrap();
        let squared = |d: f32| d.max(clamp_distance * clamp_distance);
        let square_of = |light: usize| {
            let geometric =
                1.0 / squared(lights.light(light as u32).position.distance_squared(points.point(0).position));
            f64::from(geometric * geometric)
        };
        let mean_square = (0..4000).map(square_of).sum::<f64>() / 4000.0;
        let expected = mean_square.sqrt() * f64::from(squared(height * height));
        let ratio = clusters.importance_of_bound(&pair) / expected;
        assert!((0.5..2.0).contains(&ratio), "{ratio} of {expected} at {height} m");
    }
}

/// Relative standard deviation of an estimate by strata of two samples, after `splits` splits. The
/// points are on a floor of lights under a sky, and every second light is visible.
fn error_after(splits: usize, lights: usize, rank: Rank<'_>) -> f64 {
    let mut s = Stream::new(6, Purpose::Test, 0);
    let in_sky = |s: &mut Stream| {
        let direction = -warp::sphere(s.uniform_2());
        let intensity = Rgb::gray(3.0 / 1000.0);
        Vpl { position: Vec3::ZERO, direction, intensity, kind: VplKind::Directional }
    };
    let sky = (0..1000).map(|_| in_sky(&mut s));
    let lights = tree(sky.chain(on_floor(lights)).collect());
    let points: Vec<GatherPoint> =
        (0..32).map(|_| matt(Vec3::new(s.uniform() - 0.5, s.uniform() - 0.5, 0.02))).collect();
    let points = gather_tree::<UpperAnalytic>(&points);
    let contribution = ContributionKernel::new(clamp_distance(lights.lights().len()));
    let clusters = Clusters { lights: &lights, points: &points, contribution };
    let mut memory = RefinementMemory::default();
    let options = RefinementOptions { rank, finest: 2, tabulated: 0 };
    let mut refinement = Refinement::new(clusters, options, &mut memory).unwrap();
    let mut in_cut = vec![true];
    for _ in 0..splits {
        let split = refinement.split_next().unwrap();
        in_cut[split.parent as usize] = false;
        in_cut.extend([true, true]);
    }
    let (mut sum, mut variance) = (0.0, 0.0);
    for (pair, _) in refinement.pairs().iter().zip(in_cut).filter(|(_, inside)| *inside) {
        let (mut first, mut second) = (0.0, 0.0);
        for term in clusters.all_terms(pair) {
            let light = lights.light(term.light);
            let value = f64::from(contribution.unoccluded(points.point(term.point), &light).luminance());
            first += SEEN * value;
            second += SEEN * value * value / clusters.weight_of_term(term);
        }
        sum += first;
        variance += 0.5 * (clusters.weight(pair) * second - first * first);
    }
    variance.sqrt() / sum
}

/// Bounds assume that every light of a cluster around a point is as near as the nearest. A cut that
/// is refined by bounds alone would leave the sky unsplit.
#[test]
fn pairs_are_not_spent_on_bounds_that_no_light_comes_up_to() {
    let place_of = vec![0; 2 * 65_000];
    let prior = VisibilityPrior::new(&place_of, &[SEEN as f32]);
    let by_size = error_after(125, 64_000, Rank::Deviation(prior));
    let by_bound = error_after(125, 64_000, Rank::Upper);
    assert!(1.4 * by_size < by_bound, "{by_size} and {by_bound}");
}
