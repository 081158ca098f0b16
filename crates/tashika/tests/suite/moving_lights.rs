//! Sums over VPLs of moving scenes, in which each instant has separate lights and gather points.

use glam::DVec3;
use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::gather::{GatherOptions, View};
use tashika::integrator::FullSum;
use tashika::math::{Instants, Vec3};
use tashika::scene::{Camera, Emitter, Falloff, FalloffShape, Material};
use tashika::stats::Moments;
use tashika::tree::LightSet;
use tashika::vpl::{Clamp, Vpl, VplKind, VplOptions, VplSet};

use crate::cases::{builder, film, lambert, luminances, parallelogram, place, tracer, view};
use crate::moving_objects::{pushed, send, workshop};
use crate::sums::{
    assert_cuts_keep_their_claims, assert_finest_cuts_are_whole, assert_same_bits,
    assert_sums_are_what_paths_find, set,
};

fn moving(fog: bool) -> Tracer {
    Tracer::new(workshop(None, fog).into())
}

fn set_at(tracer: &Tracer, count: u64, instants: u32) -> VplSet {
    VplSet::trace(tracer, &VplOptions { count, instants, seed: 4, ..VplOptions::default() }).unwrap()
}

/// A room with a turning blade, a lamp that swings and grows, a pane, and a cloud that shrinks.
/// Lights or gather points of a wrong time would see other shadows and lamps, and the sum would
/// differ from the result of paths.
#[test]
fn sums_over_instants_are_what_paths_find() {
    for fog in [false, true] {
        assert_sums_are_what_paths_find(&format!("fog {fog}"), &moving(fog), 0.02, 8);
    }
}

/// A spot lights a patch of the floor, and the patch lights the ceiling. A black board passes under
/// the spot for three fifths of the time. The light at the ceiling is two fifths of that without
/// the board, because light paths are traced at the time of their instant.
#[test]
fn light_that_is_reflected_comes_for_its_share_of_the_time() {
    let lit = |has_board: bool| {
        let mut b = builder();
        let side = |z: f32| parallelogram(Vec3::new(-9.0, -9.0, z), Vec3::X * 18.0, Vec3::Y * 18.0);
        place(&mut b, side(0.0), Material::new("floor", lambert(0.8)));
        place(&mut b, side(3.0), Material::new("ceiling", lambert(0.5)));
        let falloff = Falloff { cos_inner: 0.9999, cos_outer: 0.999, shape: FalloffShape::Squared };
        let spot =
            Emitter::Spot { position: Vec3::Z * 2.0, axis: Vec3::NEG_Z, intensity: Rgb::WHITE, falloff };
        b.add_emitter(spot).unwrap();
        // The board crosses the axis of the spot, but not the segments between the patch and the
        // visible point.
        let way = if has_board { DVec3::Y * -5.0 } else { DVec3::Z * 0.01 };
        let x = if has_board { -0.3 } else { 8.0 };
        let board = parallelogram(Vec3::new(x, 1.0, 1.5), Vec3::X * 0.6, Vec3::Y * 3.0);
        send(&mut b, board, Material::new("board", lambert(0.0)), &pushed(way));
        let (eye, seen) = (Vec3::new(3.0, 0.0, 2.9), Vec3::new(3.0, 0.0, 3.0));
        b.add_camera(Camera::look_at("c", eye, seen, Vec3::Y, 1e-4)).unwrap();
        let tracer = tracer(b);
        let mut m = Moments::default();
        for seed in 1..=20 {
            let options = VplOptions {
                count: 4000,
                instants: 128,
                seed,
                direct_share: 0.0,
                max_depth: 1,
                clamp: Clamp::Off,
                ..VplOptions::default()
            };
            let lights = VplSet::trace(&tracer, &options).unwrap();
            let found = luminances(&film(&tracer, &FullSum::new(&lights), [4, 4], 64, seed));
            m.push(found.iter().sum::<f64>() / found.len() as f64);
        }
        m
    };
    let (with, without) = (lit(true), lit(false));
    let error = with.standard_error() / without.mean() + 0.4 * without.standard_error() / without.mean();
    assert!(error < 0.004, "not sharp: {error}");
    let share = with.mean() / without.mean();
    assert!((share - 0.4).abs() < 7.5 * error, "{share} ± {error} of the light");
}

#[test]
fn the_finest_cut_is_the_whole_sum() {
    let tracer = moving(true);
    // There are few instants, so that nodes with several points are split.
    let lights = LightSet::new(set_at(&tracer, 150, 3));
    let in_media = lights.set().lights().iter().filter(|l| matches!(l.kind, VplKind::Volume(_))).count();
    assert!(in_media > 3 && lights.set().instants().len() == 3, "{in_media}");
    assert_finest_cuts_are_whole(&tracer, &lights);
}

#[test]
fn cuts_estimate_the_sum_and_keep_their_claims() {
    let tracer = moving(true);
    assert_cuts_keep_their_claims(&tracer, &LightSet::new(set(&tracer, 20_000, 4, Clamp::Auto)));
}

#[test]
fn threads_and_tiles_change_no_bit() {
    assert_same_bits(|| moving(true));
}

/// Each instant has about the same number of lights, and they represent all of the light: every
/// emitter emits at every instant.
#[test]
fn each_instant_has_all_of_the_light() {
    let tracer = moving(false);
    for count in [1, 5, 32] {
        assert_eq!(set_at(&tracer, 300, count).instants().len(), count as usize);
        let options = VplOptions { count: 32_000, instants: count, max_depth: 0, ..VplOptions::default() };
        let lights = VplSet::trace(&tracer, &options).unwrap();
        assert_eq!(lights.provenance().requested, 32_000);
        assert!((30_000..34_000).contains(&lights.len()), "{}", lights.len());
        let direct = |instant: usize| {
            let of_instant = &lights.lights()[lights.at(instant)];
            let from_lamp = |l: &&Vpl| (1.89..1.91).contains(&l.position.y) && l.direction.y < -0.99;
            of_instant.iter().filter(from_lamp).map(|l| f64::from(l.intensity.luminance())).sum::<f64>()
        };
        // The light of the static lamp at the ceiling is exact, because its draws are stratified.
        let of_lamp = (0..count as usize).map(direct).collect::<Vec<_>>();
        let expected = 4.0 * 0.8 * 0.8;
        assert!(of_lamp.iter().all(|sum| (sum / expected - 1.0).abs() < 0.2), "{count}: {of_lamp:?}");
    }
}

/// Camera samples have the time of their instant. Together the instants have all samples, in about
/// equal numbers.
#[test]
fn gather_points_are_of_the_instants() {
    let tracer = moving(false);
    let scene = tracer.scene().clone();
    let instants = Instants::spread(4, || 0.3);
    let view = view(&scene, [8, 8], 64, 3);
    for pixel in [[2, 3], [4, 5]] {
        let sum = view.pixel_at(&tracer, pixel, &instants);
        let mut counts = [0; 4];
        for point in &sum.points {
            counts[usize::from(point.instant)] += 1;
        }
        assert!(counts.iter().all(|count| (12..=16).contains(count)), "{counts:?}");
        for instant in 0..4 {
            // If only one instant is selected, it has all samples.
            let gather = GatherOptions { points: 16, ..view.gather };
            let alone = View { gather, ..view }.pixel_at(&tracer, pixel, &instants.only(instant));
            assert!(alone.points.len() > 12 && alone.points.iter().all(|p| p.instant == instant));
        }
    }
}
