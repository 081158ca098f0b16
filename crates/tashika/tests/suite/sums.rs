//! Tests of sums over VPLs, for any scene. The whole sum equals the result of paths, cuts are
//! estimates of the whole sum, and the bits of a result depend only on the request.

use tashika::accel::Tracer;
use tashika::film::{Claim, Film, Window};
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{
    ControlOptions, FullSum, PathStop, PathTracer, PixelRecord, Promise, Setting, Stop, SumMethod,
};
use tashika::render::with_threads;
use tashika::stats::Moments;
use tashika::tree::LightSet;
use tashika::vpl::{Clamp, VplOptions, VplSet};

use crate::cases::{film, view};
use crate::media::colors;

pub fn set(tracer: &Tracer, count: u64, seed: u64, clamp: Clamp) -> VplSet {
    VplSet::trace(tracer, &VplOptions { count, seed, clamp, ..VplOptions::default() }).unwrap()
}

/// Whole sum over VPLs on emitters, without indirect light.
pub fn directly_lit(tracer: &Tracer, direct: u64, size: [u32; 2], points: u32, seed: u64) -> Film {
    let options =
        VplOptions { count: direct, seed, max_depth: 0, clamp: Clamp::Off, ..VplOptions::default() };
    let lights = VplSet::trace(tracer, &options).unwrap();
    film(tracer, &FullSum::new(&lights), size, points, seed)
}

/// Mean of each channel over the lower half of several images, with its standard error. The lower
/// half does not show the lamp at the ceiling.
fn means(images: impl Iterator<Item = Film>) -> [Moments; 3] {
    let mut means = [Moments::default(); 3];
    for image in images {
        let pixels = colors(&image);
        let pixels = &pixels[pixels.len() / 2..];
        for (k, of_channel) in means.iter_mut().enumerate() {
            let sum: f64 = pixels.iter().map(|c| f64::from(c[k])).sum();
            of_channel.push(sum / pixels.len() as f64);
        }
    }
    means
}

/// Asserts that the sum over VPLs equals the result of paths. The mean over several VPL sets and
/// that over paths agree within 4.4 standard errors, and within the share `taken_away` by a clamp
/// of 2 cm.
///
/// * `points`: gather points per pixel; many if a small lamp is visible.
pub fn assert_sums_are_what_paths_find(name: &str, tracer: &Tracer, taken_away: f64, points: u32) {
    let size = [8, 6];
    let is_slow = std::env::var_os("TASHIKA_SLOW_TESTS").is_some();
    let (count, sets, sharp) = if is_slow { (2000, 60, 0.03) } else { (400, 8, 0.12) };
    let path = PathTracer::new(tracer, PathStop::Count(count), 1000).unwrap();
    let truth = means((0..8).map(|seed| film(tracer, &path, size, 1, 100 + seed)));
    let sum = |seed| {
        let lights = set(tracer, 6000, seed, Clamp::Distance(0.02));
        film(tracer, &FullSum::new(&lights), size, points, seed)
    };
    let sums = means((1..=sets).map(sum));
    for (k, (truth, sum)) in truth.iter().zip(&sums).enumerate() {
        let error = truth.standard_error().hypot(sum.standard_error());
        let (truth, sum) = (truth.mean(), sum.mean());
        assert!(error < sharp * truth, "{name}, {k}: not sharp: {sum} for {truth} ± {error}");
        let (low, high) = (truth * (1.0 - taken_away) - 4.4 * error, truth + 4.4 * error);
        assert!(low <= sum && sum <= high, "{name}, {k}: {sum} for {truth} ± {error}");
    }
}

fn estimate(
    tracer: &Tracer,
    lights: &LightSet,
    method: SumMethod,
    options: &ControlOptions,
) -> Vec<PixelRecord> {
    let scene = tracer.scene().clone();
    let view = View {
        camera: &scene.cameras()[0],
        size: [12, 8],
        gather: GatherOptions { points: 6, ..GatherOptions::default() },
        seed: 2,
    };
    let integrator = method.integrator(lights, options).unwrap();
    integrator.estimate(&Setting { tracer, view }, &Window::full([12, 8]))
}

fn luminance(record: &PixelRecord) -> f64 {
    f64::from(record.radiance.luminance())
}

/// Asserts that the finest cut equals the whole sum, for every method of clusters, bounds and
/// order.
pub fn assert_finest_cuts_are_whole(tracer: &Tracer, lights: &LightSet) {
    let exact = estimate(tracer, lights, SumMethod::Exact, &ControlOptions::default());
    assert!(exact.iter().all(|record| record.claim == Claim::Exact));
    let options = ControlOptions { error: 1e-12, max_pairs: Some(1 << 20), ..ControlOptions::default() };
    let has_interval = |method| [SumMethod::Sakai2018, SumMethod::Iwasaki2019].contains(&method);
    for method in [
        SumMethod::Lightcuts,
        SumMethod::Mdlc,
        SumMethod::Sakai2018,
        SumMethod::Iwasaki2019,
        SumMethod::Tashika(Promise::Calibrated),
        SumMethod::Tashika(Promise::Certified),
    ] {
        let mut complete = 0;
        for (found, exact) in estimate(tracer, lights, method, &options).iter().zip(&exact) {
            assert_ne!(found.stop, Stop::Budget, "{method}");
            // The samples were all alike, so the pixel stopped before its cut was complete.
            if found.stop == Stop::RuleMet && has_interval(method) {
                continue;
            }
            complete += 1;
            // Terms by pairs are divided and multiplied by their probability, with rounding;
            // samples of tables are rounded once more.
            let off = (luminance(found) - luminance(exact)).abs();
            assert!(
                off <= 2e-6 * luminance(exact),
                "{method}: {} for {}",
                luminance(found),
                luminance(exact)
            );
        }
        assert!(complete > if has_interval(method) { 30 } else { 80 }, "{method}: {complete}");
    }
}

/// Asserts that cuts estimate the whole sum: without bias at a fixed cut if the method is unbiased,
/// and within their intervals if the method claims any.
pub fn assert_cuts_keep_their_claims(tracer: &Tracer, lights: &LightSet) {
    let exact = estimate(tracer, lights, SumMethod::Exact, &ControlOptions::default());
    let mean = |records: &[PixelRecord]| records.iter().map(luminance).sum::<f64>();
    let options = |seed| ControlOptions { error: 0.05, seed, ..ControlOptions::default() };
    let mut ratio = Moments::default();
    for seed in 1..=12 {
        ratio.push(mean(&estimate(tracer, lights, SumMethod::Mdlc, &options(seed))) / mean(&exact));
    }
    assert!(ratio.standard_error() < 0.01, "{} ± {}", ratio.mean(), ratio.standard_error());
    let off = (ratio.mean() - 1.0).abs();
    assert!(off < 4.4 * ratio.standard_error(), "{} ± {}", ratio.mean(), ratio.standard_error());
    for (promise, kept_at_least) in [(Promise::Calibrated, 0.9), (Promise::Certified, 1.0)] {
        let (mut claimed, mut kept) = (0.0, 0.0);
        for seed in 1..=3 {
            let found = estimate(tracer, lights, SumMethod::Tashika(promise), &options(seed));
            for (found, exact) in found.iter().zip(&exact).filter(|(found, _)| found.claim == promise.claim())
            {
                claimed += 1.0;
                let off = (luminance(found) - luminance(exact)).abs();
                kept += f64::from(u8::from(off <= f64::from(found.half_width) + 1e-6 * luminance(exact)));
            }
        }
        assert!(claimed > 200.0, "{promise}: {claimed}");
        // Claims have a confidence of 95 %.
        assert!(kept >= kept_at_least * claimed, "{promise}: {kept} of {claimed}");
    }
}

pub fn assert_same_bits(tracer: impl Fn() -> Tracer + Sync) {
    let run = |threads: usize, parts: bool| {
        with_threads(threads, || {
            let tracer = tracer();
            let lights = LightSet::new(set(&tracer, 3000, 4, Clamp::Auto));
            let scene = tracer.scene().clone();
            let setting = Setting { tracer: &tracer, view: view(&scene, [12, 8], 4, 2) };
            let options = ControlOptions::default();
            let methods = [SumMethod::Exact, SumMethod::Mdlc, SumMethod::Tashika(Promise::Calibrated)];
            let tiles = if parts { 4 } else { 1 };
            let radiance = |method: SumMethod| {
                let integrator = method.integrator(&lights, &options).unwrap();
                let mut pixels = Vec::new();
                for y in (0..8).step_by(8 / tiles as usize) {
                    let tile = Window { x: 0, y, width: 12, height: 8 / tiles };
                    pixels.extend(
                        integrator.estimate(&setting, &tile).into_iter().map(|r| (r.radiance, r.rays)),
                    );
                }
                pixels
            };
            (lights.set().clone(), methods.map(radiance))
        })
        .unwrap()
    };
    let one = run(1, false);
    assert!(one == run(3, false) && one == run(2, true));
}
