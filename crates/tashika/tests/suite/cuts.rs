//! The published methods against the exact sum of the same lights and gather points.

use std::sync::Arc;

use tashika::accel::Tracer;
use tashika::film::Window;
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{Claim, ControlOptions, PixelRecord, Setting, Stop, SumMethod};
use tashika::scene::builtin;
use tashika::tree::LightSet;
use tashika::vpl::{Vpl, VplOptions, VplSet};

const SIZE: [u32; 2] = [12, 8];

/// A scene with glossy surfaces, its lights, and their tree.
struct World {
    tracer: Arc<Tracer>,
    lights: LightSet,
}

impl World {
    fn new(vpls: u64) -> Self {
        let tracer = Arc::new(Tracer::new(Arc::new(builtin::tiny())));
        let set =
            VplSet::trace(&tracer, &VplOptions { count: vpls, seed: 4, ..VplOptions::default() }).unwrap();
        Self { tracer, lights: set.into() }
    }

    fn estimate(
        &self,
        method: SumMethod,
        options: &ControlOptions,
        points: u32,
        tile: Window,
    ) -> Vec<PixelRecord> {
        let scene = self.tracer.scene().clone();
        let view = View {
            camera: &scene.cameras()[0],
            size: SIZE,
            gather: GatherOptions { points, ..GatherOptions::default() },
            seed: 2,
        };
        let integrator = method.integrator(&self.lights, options).unwrap();
        integrator.estimate(&Setting { tracer: &self.tracer, view }, &tile)
    }
}

const PUBLISHED: [SumMethod; 5] = [
    SumMethod::Lightcuts,
    SumMethod::Mdlc,
    SumMethod::Nabata2016,
    SumMethod::Sakai2018,
    SumMethod::Iwasaki2019,
];
const WITH_INTERVAL: [SumMethod; 3] = [SumMethod::Nabata2016, SumMethod::Sakai2018, SumMethod::Iwasaki2019];

fn luminance(e: &PixelRecord) -> f64 {
    f64::from(e.radiance.luminance())
}

#[test]
fn the_finest_cut_is_the_whole_sum() {
    let world = World::new(150);
    let all = Window::full(SIZE);
    let exact = world.estimate(SumMethod::Exact, &ControlOptions::default(), 3, all);
    let options = ControlOptions { error: 1e-12, max_pairs: Some(1 << 20), ..ControlOptions::default() };
    for method in PUBLISHED {
        let finest = world.estimate(method, &options, 3, all);
        let mut complete = 0;
        for (a, b) in finest.iter().zip(&exact) {
            assert_ne!(a.stop, Stop::Budget, "{method}");
            // An interval of zero width, where all samples are alike, does not make a whole sum; a
            // bound of zero does.
            if a.stop == Stop::RuleMet && WITH_INTERVAL.contains(&method) {
                continue;
            }
            complete += 1;
            // Pair by pair terms are rounded to f32, after their probability was divided out and
            // multiplied in again.
            let allowed = 8.0 * f64::from(f32::EPSILON) * luminance(b);
            assert!((luminance(a) - luminance(b)).abs() <= allowed, "{method}: {a:?} {b:?}");
            // Variances that were added and subtracted again leave a rounding, 10⁻¹⁶ of the
            // largest; as an error, its root. Methods without samples state none.
            let is_unknown = a.standard_error.is_nan() && !WITH_INTERVAL.contains(&method);
            assert!(is_unknown || f64::from(a.standard_error) <= 1e-6 * luminance(b), "{method}: {a:?}");
        }
        // A pixel of three points is complete only if all of them are.
        assert!(complete > 20, "{method}: {complete} of 96");
    }
    assert!(exact.iter().map(luminance).sum::<f64>() > 0.0);
}

/// Means over many seeds of a cut that is stopped by its size alone, so that the stop cannot bias
/// them; and the strata's estimates of their own variance. Five standard errors of 96 pixels and 5
/// methods: false alarms once in 3000 sets of seeds.
#[test]
fn estimates_of_a_fixed_cut_are_unbiased() {
    let world = World::new(400);
    let all = Window::full(SIZE);
    let exact = world.estimate(SumMethod::Exact, &ControlOptions::default(), 4, all);
    let runs = 400;
    for method in PUBLISHED {
        let mut moments = vec![tashika::stats::Moments::default(); exact.len()];
        let mut said = 0.0;
        for seed in 0..runs {
            let options =
                ControlOptions { error: 1e-12, max_pairs: Some(40), seed, ..ControlOptions::default() };
            for (m, e) in moments.iter_mut().zip(world.estimate(method, &options, 4, all)) {
                assert!(matches!(e.stop, Stop::Budget | Stop::Complete));
                assert!(e.claim == Claim::None || e.stop == Stop::Complete, "{e:?}");
                m.push(luminance(&e));
                said += f64::from(e.standard_error).powi(2) / runs as f64;
            }
        }
        for (m, e) in moments.iter().zip(&exact) {
            let allowed = 5.0 * m.standard_error() + 1e-6 * luminance(e);
            assert!((m.mean() - luminance(e)).abs() <= allowed, "{method}: {m:?} {}", luminance(e));
        }
        if WITH_INTERVAL.contains(&method) {
            let measured: f64 = moments.iter().map(tashika::stats::Moments::variance).sum();
            // Sums over 96 pixels of 400 runs each: heavy tails leave a few percent.
            assert!((said / measured - 1.0).abs() < 0.1, "{method}: says {said}, is {measured}");
        }
    }
}

#[test]
fn an_interval_is_stated_only_where_the_rule_is_met() {
    let world = World::new(1000);
    let all = Window::full(SIZE);
    for method in WITH_INTERVAL {
        for max_pairs in [64, 1 << 20] {
            let options = ControlOptions {
                error: 0.05,
                confidence: 0.9,
                max_pairs: Some(max_pairs),
                ..ControlOptions::default()
            };
            let estimates = world.estimate(method, &options, 2, all);
            let stopped = |stop| estimates.iter().filter(|e| e.stop == stop).count();
            if max_pairs == 64 {
                assert!(stopped(Stop::Budget) > 0, "{method}");
            } else {
                assert!(stopped(Stop::RuleMet) > 48, "{method}");
                assert_eq!(stopped(Stop::Budget), 0, "{method}");
            }
            for e in &estimates {
                match e.claim {
                    Claim::None => assert_eq!(e.stop, Stop::Budget),
                    Claim::Published => {
                        assert_ne!(e.stop, Stop::Budget);
                        let allowed = 0.05 * luminance(e) * (1.0 + 1e-5);
                        assert!(f64::from(e.half_width) <= allowed, "{method}: {e:?}");
                    }
                    Claim::Exact | Claim::Calibrated | Claim::Certified | Claim::Audited => {
                        panic!("{method} cannot know")
                    }
                }
            }
        }
    }
}

/// Lower tolerances and higher confidences never make a method cheaper on the whole.
#[test]
fn promising_more_costs_more() {
    let world = World::new(1000);
    let all = Window::full(SIZE);
    let cost = |method, error, confidence| {
        let options = ControlOptions { error, confidence, ..ControlOptions::default() };
        world.estimate(method, &options, 2, all).iter().map(|e| e.pairs).sum::<u64>()
    };
    for method in PUBLISHED {
        assert!(cost(method, 0.1, 0.95) < cost(method, 0.02, 0.95), "{method}");
    }
    for method in WITH_INTERVAL {
        assert!(cost(method, 0.1, 0.5) < cost(method, 0.1, 0.99), "{method}");
    }
}

/// Intensities times a power of two change no mantissa: the same terms are drawn, and every number
/// is doubled.
#[test]
fn twice_the_light_is_twice_the_picture_to_the_bit() {
    let world = World::new(500);
    let doubled: Vec<Vpl> =
        world.lights.set().lights().iter().map(|l| Vpl { intensity: l.intensity * 2.0, ..*l }).collect();
    let lights = VplSet::new(doubled, world.lights.provenance().clone()).into();
    let all = Window::full(SIZE);
    let bright = World { tracer: Arc::clone(&world.tracer), lights };
    // Directly visible light is not doubled; the film's background is subtracted.
    let lights = VplSet::new(Vec::new(), world.lights.provenance().clone()).into();
    let dark = World { tracer: Arc::clone(&world.tracer), lights };
    let options = ControlOptions::default();
    let background = dark.estimate(SumMethod::Exact, &options, 2, all);
    let mut compared = 0;
    for method in PUBLISHED {
        let (once, twice) =
            (world.estimate(method, &options, 2, all), bright.estimate(method, &options, 2, all));
        for ((a, b), seen) in once.iter().zip(&twice).zip(&background) {
            if seen.radiance.is_black() {
                assert_eq!(a.radiance * 2.0, b.radiance, "{method}");
                // Compared by bits, since an unknown error is NaN.
                let errors = [a.standard_error * 2.0, b.standard_error].map(f32::to_bits);
                assert_eq!((errors[0], a.pairs, a.rays), (errors[1], b.pairs, b.rays), "{method}");
                assert_eq!(a.half_width * 2.0, b.half_width, "{method}");
                compared += 1;
            }
        }
    }
    assert!(compared > 5 * 48, "{compared}");
}

#[test]
fn a_pixel_is_the_same_in_any_tile() {
    let world = World::new(500);
    let options = ControlOptions::default();
    for method in PUBLISHED {
        let all = world.estimate(method, &options, 2, Window::full(SIZE));
        for (x, y) in [(0, 0), (7, 3), (11, 7)] {
            let alone = world.estimate(method, &options, 2, Window { x, y, width: 1, height: 1 });
            // Compared as texts, in which NaN equals itself.
            let texts = [alone[0], all[(y * SIZE[0] + x) as usize]].map(|record| format!("{record:?}"));
            assert_eq!(texts[0], texts[1], "{method}");
        }
    }
}
