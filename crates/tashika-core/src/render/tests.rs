//! Tests of chosen pixels against the whole image, and of the calls of observers.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use super::*;
use crate::accel::Tracer;
use crate::gather::{GatherOptions, View};
use crate::integrator::FullSum;
use crate::scene::builtin;
use crate::vpl::{VplOptions, VplSet};

fn with_setting<T>(work: impl FnOnce(&Setting<'_>, &FullSum<'_>) -> T) -> T {
    let tracer = Tracer::new(Arc::new(builtin::tiny()));
    let lights = VplSet::trace(&tracer, &VplOptions { count: 50, ..VplOptions::default() }).unwrap();
    let camera = &tracer.scene().cameras()[0];
    let view = View { camera, size: [40, 9], gather: GatherOptions::default(), seed: 3 };
    work(&Setting { tracer: &tracer, view }, &FullSum::new(&lights))
}

#[test]
fn chosen_pixels_are_those_of_the_image_and_no_others_are_rendered() {
    with_setting(|setting, exact| {
        let go = AtomicBool::new(false);
        let options = RenderOptions { window: Window::full(setting.view.size), share: TileShare::default() };
        let whole = render(setting, exact, &options, &|_| {}, &go).unwrap().film;
        let chosen = [[39, 8], [0, 0], [7, 3]];
        let told = Mutex::new(Vec::new());
        let some = render_pixels(setting, exact, &chosen, &|p| told.lock().unwrap().push(*p), &go).unwrap();
        assert!(some.complete && some.film.window() == whole.window());
        for (x, y) in whole.window().pixels() {
            let is_chosen = chosen.contains(&[x, y]);
            assert_eq!(some.film.plane("stop").unwrap().u32_at(x, y)[0] != 0, is_chosen, "{x},{y}");
            for name in ["", "rays", "normal"] {
                let here = some.film.plane(name).unwrap().f32_at(x, y);
                let there = whole.plane(name).unwrap().f32_at(x, y);
                let expected = if is_chosen { there.to_vec() } else { vec![0.0; there.len()] };
                assert_eq!(here, expected, "{name:?} at {x},{y}");
            }
        }
        let told = told.into_inner().unwrap();
        assert_eq!(
            told.iter().map(|p| (p.tally.rendered(), p.of)).collect::<Vec<_>>(),
            [(1, 3), (2, 3), (3, 3)]
        );
        assert_eq!((told[2].rays, some.totals.tally.rendered()), (some.totals.rays, 3));
    });
}

#[test]
fn pixels_outside_or_named_twice_are_refused_and_none_is_begun_when_cancelled() {
    with_setting(|setting, exact| {
        let said = |pixels: &[[u32; 2]]| {
            let go = AtomicBool::new(false);
            render_pixels(setting, exact, pixels, &|_| {}, &go).unwrap_err().to_string()
        };
        assert!(said(&[[1, 1], [40, 0]]).starts_with("pixels = 40,0; expected pixels of the image of 40x9"));
        assert!(said(&[[1, 2], [3, 4], [1, 2]]).starts_with("pixels = 1,2;"));
        let stopped = render_pixels(setting, exact, &[[1, 1]], &|_| {}, &AtomicBool::new(true)).unwrap();
        assert!(!stopped.complete && stopped.totals.tally.rendered() == 0);
    });
}

#[test]
fn who_watches_is_shown_each_tile_once_with_its_pixels_done() {
    with_setting(|setting, exact| {
        let options = RenderOptions { window: Window::full(setting.view.size), share: TileShare::default() };
        let seen = Mutex::new(Film::new(setting.view.size, options.window, PixelRecord::PLANES).unwrap());
        let told = Mutex::new(Vec::new());
        let watch = |done: &Finished<'_>| {
            let mut seen = seen.lock().unwrap();
            for (x, y) in done.tile.pixels() {
                assert_eq!(seen.plane("stop").unwrap().u32_at(x, y), [0], "{x},{y} is shown twice");
                let pixel = |name| done.film.plane(name).unwrap();
                seen.plane_mut("stop").unwrap().set_u32(x, y, pixel("stop").u32_at(x, y));
                seen.plane_mut("").unwrap().set_f32(x, y, pixel("").f32_at(x, y));
            }
            told.lock().unwrap().push(done.progress);
        };
        let rendered = render(setting, exact, &options, &watch, &AtomicBool::new(false)).unwrap();
        let (seen, told) = (seen.into_inner().unwrap(), told.into_inner().unwrap());
        for name in ["stop", ""] {
            assert_eq!(seen.plane(name), rendered.film.plane(name), "{name:?}");
        }
        let last = told.last().unwrap();
        assert!(
            told.len() > 1 && told.windows(2).all(|two| two[0].tally.rendered() < two[1].tally.rendered())
        );
        assert_eq!((last.tally, last.of, last.tally.claiming()), (rendered.totals.tally, 360, 360));
    });
}
