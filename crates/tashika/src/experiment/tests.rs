//! Tests of subsets by counting, of pools by numbers computed by hand, and of runs by comparison
//! with single renders.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use super::*;
use crate::accel::Tracer;
use crate::film::{Film, PlaneSpec, SampleKind, Window};
use crate::gather::{GatherOptions, View};
use crate::integrator::{ControlOptions, FullSum, Setting, SumMethod};
use crate::render::{Progress, render_pixels, with_threads};
use crate::report::Tolerance;
use crate::scene::builtin;
use crate::tree::LightSet;
use crate::vpl::{VplOptions, VplSet};

const WINDOW: Window = Window { x: 3, y: 7, width: 5, height: 4 };

#[test]
fn a_subset_has_each_pixel_once_in_rows() {
    let all: Vec<[u32; 2]> = WINDOW.pixels().map(|(x, y)| [x, y]).collect();
    assert_eq!(subset(20, &WINDOW, 1).unwrap(), all);
    for count in 1..20 {
        let chosen = subset(count, &WINDOW, count).unwrap();
        assert_eq!(chosen.len() as u64, count);
        let places: Vec<usize> = chosen.iter().map(|[x, y]| WINDOW.index(*x, *y)).collect();
        assert!(places.is_sorted_by(|a, b| a < b), "{chosen:?}");
    }
    assert_ne!(subset(5, &WINDOW, 1).unwrap(), subset(5, &WINDOW, 2).unwrap());
    for count in [0, 21] {
        let said = subset(count, &WINDOW, 1).unwrap_err().to_string();
        assert!(said.starts_with(&format!("pixels = {count}; expected 1 to 20")), "{said}");
    }
}

#[test]
fn every_pixel_and_every_pair_is_as_probable() {
    let (trials, count) = (20_000, 7);
    let mut together = [[0_u32; 20]; 20];
    for seed in 0..trials {
        let chosen = subset(count, &WINDOW, seed).unwrap();
        let places: Vec<usize> = chosen.iter().map(|[x, y]| WINDOW.index(*x, *y)).collect();
        for &a in &places {
            for &b in &places {
                together[a][b] += 1;
            }
        }
    }
    let n = trials as f64;
    for (a, counts) in together.iter().enumerate() {
        for (b, found) in counts.iter().enumerate() {
            let p = if a == b { 7.0 / 20.0 } else { 7.0 * 6.0 / (20.0 * 19.0) };
            // Five standard errors; of 210 comparisons one in 8,000 runs fails by chance.
            let allowed = 5.0 * f64::sqrt(n * p * (1.0 - p));
            let found = f64::from(*found);
            assert!((found - n * p).abs() < allowed, "{a}, {b}: {found} of {n}, expected {}", n * p);
        }
    }
}

const fn plane(name: &'static str, channels: &'static [&'static str], kind: SampleKind) -> PlaneSpec {
    PlaneSpec { name, channels, unit: "1", kind, doc: "" }
}

/// Planes that a pool reads.
const SPECS: &[PlaneSpec] = &[
    plane("", &["R", "G", "B"], SampleKind::F32),
    plane("half_width", &["Y"], SampleKind::F32),
    plane("claim", &["id"], SampleKind::U32),
    plane("stop", &["id"], SampleKind::U32),
    plane("pairs", &["n"], SampleKind::F32),
    plane("rays", &["n"], SampleKind::F32),
];

/// One pixel: gray value, half-width, claim, stop, pairs, rays.
type Made = (f32, f32, u32, u32, f32, f32);

fn film(pixels: &[Made]) -> Film {
    let window = Window::full([pixels.len() as u32, 1]);
    let mut film = Film::new([window.width, 1], window, SPECS).unwrap();
    for (x, (gray, half_width, claim, stop, pairs, rays)) in (0..).zip(pixels) {
        let [color, width, claims, stops, pair_counts, ray_counts] = film.planes_mut() else { panic!() };
        color.set_f32(x, 0, &[*gray; 3]);
        width.set_f32(x, 0, &[*half_width]);
        claims.set_u32(x, 0, &[*claim]);
        stops.set_u32(x, 0, &[*stop]);
        pair_counts.set_f32(x, 0, &[*pairs]);
        ray_counts.set_f32(x, 0, &[*rays]);
    }
    film
}

#[test]
fn trials_of_all_seeds_are_pooled() {
    let reference = film(&[(1.0, 0.0, 1, 1, 9.0, 9.0); 4]);
    // By pixel: off by 1 % and covered; off by 3 %, not covered; out of budget; not rendered.
    let first = film(&[
        (1.01, 0.02, 2, 3, 10.0, 5.0),
        (0.97, 0.02, 2, 3, 20.0, 7.0),
        (2.0, 0.0, 0, 4, 30.0, 9.0),
        (0.0, 0.0, 0, 0, 0.0, 0.0),
    ]);
    // Exact; off by 2.5 % and covered; not finite; off by 1.5 % and covered.
    let second = film(&[
        (1.0, 0.0, 2, 1, 2.0, 1.0),
        (1.025, 0.03, 2, 3, 4.0, 2.0),
        (f32::INFINITY, 0.0, 2, 3, 6.0, 3.0),
        (1.015, 0.02, 2, 3, 8.0, 1.0),
    ]);
    let mut pool = Pool::new(Tolerance::default());
    assert_eq!((pool.trials(), pool.within().value(), pool.quantile(100)), (0, None, f64::INFINITY));
    assert_eq!(pool.add(&first, &reference).unwrap().pixels, 3);
    pool.add(&second, &reference).unwrap();
    assert_eq!(pool.trials(), 7);
    assert_eq!(pool.within(), Share { count: 3, of: 7 });
    assert_eq!(pool.claims(), Share { count: 4, of: 6 }, "what is not finite keeps no claim");
    assert_eq!(pool.budget_hit(), 1);
    assert_eq!((pool.pairs_per_pixel(), pool.rays_per_pixel()), (80.0 / 7.0, 28.0 / 7.0));
    // Sorted: 0, 1, 1.5, 2.5, 3, 100 %, infinite. Luminances are stored in single precision.
    let near =
        |found: f64, expected: f64| assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
    near(pool.mean(), 1.08 / 6.0);
    near(pool.quantile(50), 0.025);
    near(pool.quantile(72), 1.0);
    assert_eq!((pool.quantile(95), pool.quantile(100)), (f64::INFINITY, f64::INFINITY));

    let options = ControlOptions { error: 0.01, ..ControlOptions::default() };
    let cell = Cell { method: SumMethod::Iwasaki2019, options, tolerance: 0.02, seeds: 2 };
    let subject = Subject { scene: "made".to_owned(), vpls: 1234, gather: 4, pixels: 4, group: None };
    let row = Row::new(&subject, (&cell).into(), &pool, 1.5);
    assert_eq!((row.within_tolerance, row.claims_kept, row.claims), (3.0 / 7.0, Some(4.0 / 6.0), 6));
    // Ends of the intervals as computed by an independent program, to four digits.
    let ends = [row.low, row.high, row.claims_low.unwrap(), row.claims_high.unwrap()];
    let expected = [0.0990, 0.8159, 0.2228, 0.9567];
    assert!(ends.iter().zip(expected).all(|(end, e)| (end - e).abs() < 5e-5), "{ends:?}");
    let json = serde_json::to_value(&row).unwrap();
    assert!(json["worst"].is_null() && json["confidence"] == 0.95 && json["method_error"] == 0.01, "{json}");
}

#[test]
fn methods_without_intervals_have_no_confidence() {
    let common = Cell {
        method: SumMethod::Exact,
        options: ControlOptions { max_pairs: Some(7), ..ControlOptions::default() },
        tolerance: 0.0,
        seeds: 3,
    };
    let cells = Cell::grid(&[SumMethod::Mdlc, SumMethod::Sakai2018], &[0.01, 0.05], &[0.5, 0.9], &common);
    let told: Vec<_> = cells.iter().map(|c| (c.method, c.tolerance, c.confidence())).collect();
    let (mdlc, sakai) = (SumMethod::Mdlc, SumMethod::Sakai2018);
    let expected = [
        (mdlc, 0.01, None),
        (mdlc, 0.05, None),
        (sakai, 0.01, Some(0.5)),
        (sakai, 0.01, Some(0.9)),
        (sakai, 0.05, Some(0.5)),
        (sakai, 0.05, Some(0.9)),
    ];
    assert_eq!(told, expected);
    for cell in cells {
        assert_eq!((cell.options.error, cell.options.max_pairs, cell.seeds), (cell.tolerance, Some(7), 3));
    }
}

/// Calls `work` with the tiny scene. There are few lights and the tolerance is loose, so that
/// methods are quick and some trials miss the tolerance.
fn on_ground<T>(pixels: &Pixels, work: impl FnOnce(&Ground<'_>) -> T) -> T {
    let tracer = Tracer::new(Arc::new(builtin::tiny()));
    let lights = VplOptions { count: 300, ..VplOptions::default() };
    let lights = LightSet::new(VplSet::trace(&tracer, &lights).unwrap());
    let camera = &tracer.scene().cameras()[0];
    let view = View { camera, size: [24, 16], gather: GatherOptions::default(), seed: 3 };
    let setting = Setting { tracer: &tracer, view };
    let go = AtomicBool::new(false);
    let reference = pixels.render(&setting, &FullSum::new(lights.set()), &|_| {}, &go).unwrap().film;
    work(&Ground { setting, lights: &lights, pixels, reference: &reference, groups: &[] })
}

#[test]
fn a_cell_is_what_its_renders_are() {
    let pixels = Pixels::of(Window::full([24, 16]), Some(30), 5).unwrap();
    let Pixels::Chosen(chosen) = &pixels else { panic!("a subset was asked for") };
    on_ground(&pixels, |ground| {
        let go = AtomicBool::new(false);
        let options = ControlOptions { error: 0.2, confidence: 0.5, ..ControlOptions::default() };
        let cell = Cell { method: SumMethod::Iwasaki2019, options, tolerance: 0.05, seeds: 2 };
        let told = std::sync::Mutex::new(Progress::default());
        // A clock that advances by a second at each reading.
        let looks = AtomicU32::new(0);
        let watch = Watch {
            progress: &|p| *told.lock().unwrap() = *p,
            cancel: &go,
            clock: &|| f64::from(looks.fetch_add(1, Ordering::Relaxed)),
        };
        let (pools, seconds) = ground.run(&cell, &watch).unwrap().unwrap();
        let [pool] = &pools[..] else { panic!("no groups were asked for") };
        assert_eq!(seconds, 2.0, "one for each seed");
        let (mut within, mut kept, mut rays) = (0, 0, 0);
        for seed in [1, 2] {
            let method = cell.method.integrator(ground.lights, &ControlOptions { seed, ..options }).unwrap();
            let single = render_pixels(&ground.setting, method.as_ref(), chosen, &|_| {}, &go).unwrap();
            rays += single.totals.rays;
            for &[x, y] in chosen {
                let luminance = |film: &Film| -> f64 {
                    let [r, g, b] = film.plane("").unwrap().f32_at(x, y) else { panic!("three channels") };
                    0.2126 * f64::from(*r) + 0.7152 * f64::from(*g) + 0.0722 * f64::from(*b)
                };
                let (found, truth) = (luminance(&single.film), luminance(ground.reference));
                within += u64::from((found - truth).abs() <= 0.05 * truth);
                let half_width = f64::from(single.film.plane("half_width").unwrap().f32_at(x, y)[0]);
                kept += u64::from((found - truth).abs() <= half_width + 1e-6 * truth);
            }
        }
        assert_eq!(pool.within(), Share { count: within, of: 60 });
        assert_eq!(pool.claims(), Share { count: kept, of: 60 });
        assert_eq!(pool.rays_per_pixel(), rays as f64 / 60.0);
        assert!(within > 0 && within < 60 && kept < 60, "the case tells: {within} within, {kept} kept");
        let told = *told.lock().unwrap();
        assert_eq!((told.tally.rendered(), told.of, told.rays), (60, 60, rays));

        let numbers = |pool: &Pool| (pool.within(), pool.claims(), pool.mean(), pool.quantile(95));
        for threads in [1, 2] {
            let again = with_threads(threads, || ground.run(&cell, &watch).unwrap().unwrap()).unwrap();
            assert_eq!(numbers(&again.0[0]), numbers(pool), "{threads} threads");
        }
        let cancelled = ground.run(&cell, &Watch { cancel: &AtomicBool::new(true), ..watch }).unwrap();
        assert!(cancelled.is_none());
    });
}

#[test]
fn the_exact_method_is_always_within() {
    let all = Pixels::of(Window::full([24, 16]), None, 5).unwrap();
    on_ground(&all, |ground| {
        let options = ControlOptions::default();
        let cell = Cell { method: SumMethod::Exact, options, tolerance: 1e-6, seeds: 1 };
        let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false), clock: &|| 0.0 };
        let pool = &ground.run(&cell, &watch).unwrap().unwrap().0[0];
        let every = Share { count: 384, of: 384 };
        assert_eq!((pool.within(), pool.claims(), pool.quantile(100)), (every, every, 0.0));
    });
}

/// The pixels show a box surrounded by sky. Each is in one group, and the trials within the
/// tolerance in all groups add up to those of all pixels.
#[test]
fn groups_hold_every_pixel_once_and_are_judged_by_themselves() {
    let all = Pixels::of(Window::full([24, 16]), None, 5).unwrap();
    on_ground(&all, |ground| {
        for grouping in Grouping::ALL {
            let groups = grouping.groups(ground.reference, &ground.setting);
            assert_eq!(groups.iter().map(|g| g.pixels).sum::<u64>(), 384, "{grouping}");
            assert!(groups.len() > 1, "{grouping}: {:?}", groups.iter().map(|g| g.name).collect::<Vec<_>>());
            let options = ControlOptions { error: 0.2, confidence: 0.5, ..ControlOptions::default() };
            let cell = Cell { method: SumMethod::Iwasaki2019, options, tolerance: 0.05, seeds: 1 };
            let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false), clock: &|| 0.0 };
            let (pools, _) = Ground { groups: &groups, ..*ground }.run(&cell, &watch).unwrap().unwrap();
            let of_groups = pools[1..].iter().map(|pool| pool.within());
            assert!(of_groups.clone().zip(&groups).all(|(share, group)| share.of == group.pixels));
            let sum = of_groups.map(|share| share.count).sum::<u64>();
            assert_eq!(Share { count: sum, of: 384 }, pools[0].within(), "{grouping}");
            assert!(sum > 0 && sum < 384);
        }
        let quarters = Grouping::Brightness.groups(ground.reference, &ground.setting);
        let lit: Vec<u64> = quarters.iter().filter(|g| g.name != "black").map(|g| g.pixels).collect();
        let (least, most) = (lit.iter().min().unwrap(), lit.iter().max().unwrap());
        assert!(lit.len() == 4 && most - least <= 1, "{lit:?}");
    });
}

/// Runs a search in which settings up to `limit` succeed. Returns its result and the settings that
/// were tried.
fn searched(start: f64, limit: f64) -> (Option<f64>, Vec<f64>) {
    let (mut search, mut tried) = (Search::new(start), Vec::new());
    while let Some(setting) = search.next_trial() {
        assert!(tried.len() < 30, "no end: {tried:?}");
        search.tell(setting, setting <= limit);
        tried.push(setting);
    }
    (search.found(), tried)
}

#[test]
fn a_search_ends_just_below_the_limit() {
    for limit in [3e-5, 1.234e-4, 0.004, 0.0199, 0.02, 0.021, 0.05, 0.39, 0.97] {
        let (found, tried) = searched(0.02, limit);
        let found = found.expect("a setting that does it");
        assert!(found <= limit && limit <= 1.1 * found, "{found} for {limit}");
        assert_eq!(tried[0], 0.02, "the tolerance itself is tried first");
    }
    assert_eq!(searched(0.02, 2.0).0, Some(1.0), "nothing above 1 is tried");
    let (found, tried) = searched(0.02, 0.0);
    assert_eq!((found, tried.len()), (None, 11), "it gives up");
}

#[test]
fn tables_are_aligned_and_pages_escape() {
    let pool = {
        let mut pool = Pool::new(Tolerance::default());
        let made = (1.01, 0.0, 0, 4, 2000.0, 1.0);
        pool.add(&film(&[made; 3]), &film(&[(1.0, 0.0, 1, 1, 9.0, 9.0); 3])).unwrap();
        pool
    };
    let subject = Subject { scene: "made".to_owned(), vpls: 55_000, gather: 4, pixels: 3, group: None };
    let options = ControlOptions::default();
    let cell = Cell { method: SumMethod::Mdlc, options, tolerance: 0.02, seeds: 1 };
    let row = Row::new(&subject, (&cell).into(), &pool, 0.25);
    let columns = [Column::Method, Column::Vpls, Column::Confidence, Column::Within, Column::Claims];
    let table = Table::new(std::slice::from_ref(&row), &columns);
    let expected = "\
| method |   VPLs | confidence |        within the error | claims kept |
|--------|-------:|-----------:|------------------------:|------------:|
| mdlc   | 55,000 |          - | 100.0 % (29.2 to 100.0 %) |           - |
";
    let squeezed = |text: &str| text.replace([' ', '-'], "");
    assert_eq!(squeezed(&table.markdown()), squeezed(expected));
    let widths: Vec<usize> = table.markdown().lines().map(str::len).collect();
    assert!(widths.windows(2).all(|two| two[0] == two[1]), "{widths:?}");

    let html = page("<made>", vec!["1 < 2".to_owned()], (&[row], &table), Vec::new(), Vec::new()).html();
    for words in ["<h1>&lt;made&gt;</h1>", "1 &lt; 2</p>", "<td>55,000</td>", "quality-and-cost.svg"] {
        assert!(html.contains(words), "{words}: {html}");
    }
    assert!(!html.contains("id=\"stage\""), "no image, no viewer");
}

#[test]
fn pixels_whose_truth_is_not_known_well_enough_are_left_out() {
    let spec = |name, channels, kind| PlaneSpec { name, channels, unit: "1", kind, doc: "" };
    let specs = [
        spec("", &["R", "G", "B"], SampleKind::F32),
        spec("standard_error", &["Y"], SampleKind::F32),
        spec("stop", &["id"], SampleKind::U32),
    ];
    let mut film = Film::new([4, 1], Window::full([4, 1]), &specs).unwrap();
    // The largest standard error is a quarter of the tolerance: 0.025 for a luminance of 1, and
    // 0.01 for dark pixels, where the absolute tolerance 0.04 applies.
    for (x, (luminance, error)) in (0..).zip([(1.0, 0.024), (1.0, 0.026), (0.1, 0.009), (0.1, 0.011)]) {
        film.plane_mut("").unwrap().set_f32(x, 0, &[luminance; 3]);
        film.plane_mut("standard_error").unwrap().set_f32(x, 0, &[error]);
        film.plane_mut("stop").unwrap().set_u32(x, 0, &[3]);
    }
    let found = converged(&film, &Tolerance { relative: 0.1, absolute: 0.04 });
    assert_eq!(found.plane("stop").unwrap().u32_samples().unwrap(), [3, 0, 3, 0]);
    assert_eq!(found.plane("").unwrap(), film.plane("").unwrap());
}
