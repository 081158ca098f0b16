//! The same seed gives the same bits for any number of threads, in any window, and in any share.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use tashika::accel::Tracer;
use tashika::film::{Film, Window};
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{
    ControlOptions, FullSum, GuidedLights, Integrator, LightTransport, PathStop, PathTracer, Setting,
    SumMethod, Truth,
};
use tashika::render::{RenderOptions, TileShare, render, with_threads};
use tashika::scene::builtin;
use tashika::tree::LightSet;
use tashika::vpl::{VplOptions, VplSet};

const SIZE: [u32; 2] = [37, 23];
const METHODS: [&str; 8] = [
    "exact",
    "path",
    "lightcuts",
    "nabata2016",
    "iwasaki2019",
    "tashika",
    "tashika-certified",
    "light transport",
];

/// Makes the tracer, the lights and the film on a pool of `threads` threads.
fn run(threads: usize, method: &str, window: Window, share: TileShare) -> (Film, VplSet) {
    with_threads(threads, || {
        let tracer = Tracer::new(Arc::new(builtin::tiny()));
        let lights = VplOptions { count: 3000, seed: 9, ..VplOptions::default() };
        let lights = LightSet::new(VplSet::trace(&tracer, &lights).unwrap());
        let scene = tracer.scene().clone();
        let view = View {
            camera: &scene.cameras()[0],
            size: SIZE,
            gather: GatherOptions { points: 3, ..GatherOptions::default() },
            seed: 5,
        };
        let published = ControlOptions { error: 0.1, ..ControlOptions::default() };
        let options = RenderOptions { window, share };
        let render = |integrator: Box<dyn Integrator + '_>| {
            let setting = Setting { tracer: &tracer, view };
            render(&setting, &*integrator, &options, &|_| (), &AtomicBool::new(false)).unwrap().film
        };
        let film = match method.parse::<SumMethod>() {
            Err(_) if method == "light transport" => {
                let lights = VplOptions { count: 2000, seed: 9, ..VplOptions::default() };
                let guided = GuidedLights::trace(&tracer, &lights, Truth::Transport, &view).unwrap();
                let options = ControlOptions { error: 0.5, ..published };
                render(Box::new(LightTransport::new(&tracer, &guided, &options)))
            }
            Ok(method) => render(method.integrator(&lights, &published).unwrap()),
            Err(_) => render(Box::new(PathTracer::new(&tracer, PathStop::Count(8), 16).unwrap())),
        };
        (film, lights.set().clone())
    })
    .unwrap()
}

#[test]
fn threads_do_not_change_a_bit() {
    for method in METHODS {
        let all = Window::full(SIZE);
        let (one, lights) = run(1, method, all, TileShare::default());
        for threads in [2, 5] {
            let (film, set) = run(threads, method, all, TileShare::default());
            assert_eq!(set, lights, "VPLs with {threads} threads");
            assert_eq!(film, one, "{method} with {threads} threads");
        }
        assert!(one.colors().unwrap().any(|c| !c.is_black()));
    }
}

#[test]
fn windows_and_shares_are_parts_of_the_same_image() {
    for method in METHODS {
        let (whole, _) = run(2, method, Window::full(SIZE), TileShare::default());
        let window = Window { x: 5, y: 3, width: 18, height: 13 };
        let (part, _) = run(2, method, window, TileShare::default());
        let at = |f: &Film, x, y| f.plane("").unwrap().f32_at(x, y).to_vec();
        for (x, y) in window.pixels() {
            assert_eq!(at(&part, x, y), at(&whole, x, y), "{method} at {x}, {y}");
        }
        let mut covered = 0;
        for number in 1..=3 {
            let (share, _) = run(1, method, Window::full(SIZE), TileShare::new(number, 3).unwrap());
            for (x, y) in share.window().pixels() {
                if share.plane("stop").unwrap().u32_at(x, y) != [0] {
                    covered += 1;
                    assert_eq!(at(&share, x, y), at(&whole, x, y));
                }
            }
        }
        assert_eq!(covered, 37 * 23);
    }
}

#[test]
fn a_cancelled_render_says_which_pixels_it_has() {
    let tracer = Tracer::new(Arc::new(builtin::tiny()));
    let set = VplSet::trace(&tracer, &VplOptions { count: 100, ..VplOptions::default() }).unwrap();
    let scene = tracer.scene().clone();
    let view =
        View { camera: &scene.cameras()[0], size: [96, 96], gather: GatherOptions::default(), seed: 5 };
    let cancel = AtomicBool::new(false);
    let options = RenderOptions { window: Window::full([96, 96]), share: TileShare::default() };
    let stop_after_first =
        |_: &tashika::render::Finished<'_>| cancel.store(true, std::sync::atomic::Ordering::Relaxed);
    let r =
        render(&Setting { tracer: &tracer, view }, &FullSum::new(&set), &options, &stop_after_first, &cancel)
            .unwrap();
    assert!(!r.complete && r.film.metadata().bool("complete") == Some(false));
    let done =
        r.film.plane("stop").unwrap().u32_samples().unwrap().iter().filter(|s| **s != 0).count() as u64;
    assert!(done > 0 && done < 96 * 96 && done == r.totals.tally.rendered(), "{done}");
}
