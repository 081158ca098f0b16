//! Tests of the pipeline: films compared with those of its parts combined by hand, observers, and
//! audits.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use super::*;
use crate::film::{Film, Plane};
use crate::gather::GatherOptions;
use crate::integrator::{
    ControlOptions, FullSum, Integrator, LightTransport, PathStop, PathTracer, Promise, Setting, SumMethod,
};
use crate::render::{Begun, Finished, RenderOptions, render};
use crate::scene::builtin;
use crate::vpl::VplOptions;

const SIZE: [u32; 2] = [15, 10];

fn tiny() -> Renderer<'static> {
    Renderer::new(builtin::tiny()).size(SIZE).vpls(3000).seed(7)
}

fn samples<'f>(film: &'f Film, plane: &str) -> &'f [f32] {
    film.plane(plane).and_then(Plane::f32_samples).expect("a plane of every film")
}

/// Records the phases, and can cancel the work after `most` tiles.
#[derive(Default)]
struct Witness {
    phases: Mutex<Vec<String>>,
    tiles: Mutex<u64>,
    most: Option<u64>,
    stop: AtomicBool,
}

impl Witness {
    fn phases(&self) -> String {
        self.phases.lock().unwrap().join(" ")
    }

    fn write(&self, word: &str, phase: &Phase) {
        let name = match phase {
            Phase::Vpls { .. } => "vpls",
            Phase::LightTree => "tree",
            Phase::Pixels { .. } => "pixels",
            Phase::Reconstruction => "reconstruction",
            Phase::Mattes => "mattes",
            Phase::FirstSurfaces => "first surfaces",
            Phase::Audit { .. } => "audit",
            Phase::OtherSet => "other",
        };
        self.phases.lock().unwrap().push(format!("{word}{name}"));
    }
}

impl Observer for Witness {
    fn begin(&self, phase: &Phase) {
        self.write("", phase);
    }

    fn end(&self, phase: &Phase) {
        self.write("/", phase);
    }

    fn tile(&self, _done: &Finished<'_>) {
        let mut tiles = self.tiles.lock().unwrap();
        *tiles += 1;
        self.stop.store(self.most.is_some_and(|most| *tiles >= most), Ordering::Relaxed);
    }

    fn cancel(&self) -> &AtomicBool {
        &self.stop
    }
}

/// The same film is rendered by the pipeline and by its parts, combined by hand. Both have the same
/// samples.
#[test]
fn films_are_those_of_the_parts() {
    let tracer = Tracer::new(Arc::new(builtin::tiny()));
    let (camera, gather) = (&tracer.scene().cameras()[0], GatherOptions::default());
    let options = RenderOptions { window: Window::full(SIZE), share: TileShare::default() };
    let of = |integrator: &dyn Integrator, gather| {
        let setting = Setting { tracer: &tracer, view: View { camera, size: SIZE, gather, seed: 7 } };
        render(&setting, integrator, &options, &|_| (), &AtomicBool::new(false)).unwrap().film
    };
    let lights = VplOptions { count: 3000, seed: 7, ..VplOptions::default() };
    let told = ControlOptions { error: 0.3, seed: 7, ..ControlOptions::default() };

    let path = PathTracer::new(&tracer, PathStop::Count(9), VplOptions::default().path_depth()).unwrap();
    assert_eq!(tiny().method(MethodName::Path).paths(9).render().unwrap().film, of(&path, gather));

    let set = VplSet::trace(&tracer, &lights).unwrap();
    assert_eq!(tiny().method(SumMethod::Exact).render().unwrap().film, of(&FullSum::new(&set), gather));
    let mdlc = SumMethod::Mdlc.integrator(&set.clone().into(), &told).map(|one| of(one.as_ref(), gather));
    assert_eq!(tiny().method(SumMethod::Mdlc).error(0.3).render().unwrap().film, mdlc.unwrap());

    let asked = Request { error: Some(0.3), ..Request::default() };
    let points = asked.gather_options().unwrap();
    let view = View { camera, size: SIZE, gather: points, seed: 7 };
    let guided = GuidedLights::trace(&tracer, &lights, Truth::Transport, &view).unwrap();
    let transport = of(&LightTransport::new(&tracer, &guided, &told), points);
    assert_eq!(tiny().error(0.3).render().unwrap().film, transport);
}

#[test]
fn observers_are_told_of_every_phase_and_can_end_it() {
    let told = Witness::default();
    let prepared = tiny().method(SumMethod::Mdlc).error(0.5).observer(&told).prepare().unwrap();
    assert_eq!(told.phases(), "vpls /vpls tree /tree");
    let rendered = prepared.render().unwrap();
    let audit = prepared.audit(&rendered.film, 5).unwrap().unwrap();
    let other = prepared.other_set(&rendered).unwrap().unwrap();
    assert_eq!((audit.of, other.pixels), (5, 64));
    let rest = "pixels /pixels audit /audit other /other";
    assert_eq!(told.phases(), format!("vpls /vpls tree /tree {rest}"));

    let told = Witness { most: Some(1), ..Witness::default() };
    let ended = tiny().size([64, 64]).method(SumMethod::Exact).vpls(50).observer(&told);
    let prepared = ended.prepare().unwrap();
    let rendered = prepared.render().unwrap();
    assert!(!rendered.complete);
    let part = rendered.totals.tally.rendered();
    assert!(part > 0 && part < 64 * 64, "{part} pixels");
    assert!(prepared.other_set(&rendered).unwrap().is_none(), "of a part");
    assert!(prepared.audit(&rendered.film, 5).unwrap().is_none(), "cancelled");
    assert!(!told.phases().contains("tree"), "whole sums need none");
    let share = tiny().method(SumMethod::Exact).tiles("1/2".parse().unwrap()).prepare().unwrap();
    assert!(share.other_set(&share.render().unwrap()).unwrap().is_none(), "of a share");
}

/// A render is cancelled after one tile and then resumed. Finished tiles are not rendered again,
/// and the film is that of an uninterrupted render.
#[test]
fn renders_go_on_from_finished_tiles() {
    let renderer = tiny().size([64, 40]).method(SumMethod::Exact).vpls(50);
    let whole = renderer.render().unwrap();
    let told = Witness { most: Some(1), ..Witness::default() };
    let part = renderer.clone().observer(&told).prepare().unwrap();
    let tiles = Mutex::new(Vec::new());
    let setting = part.setting();
    let options = RenderOptions { window: part.window(), share: TileShare::default() };
    let watch = |done: &Finished<'_>| {
        tiles.lock().unwrap().push(done.tile);
        told.tile(done);
    };
    let begun = render(&setting, part.integrator().unwrap().as_ref(), &options, &watch, told.cancel());
    let (film, tiles) = (begun.unwrap().film, tiles.into_inner().unwrap());

    let told = Witness::default();
    let prepared = renderer.observer(&told).prepare().unwrap();
    let finished = prepared
        .render_from(|blank| {
            let mut begun = film.clone();
            *begun.metadata_mut() = blank.metadata().clone();
            Ok(Begun { film: begun, tiles: tiles.clone() })
        })
        .unwrap();
    assert_eq!(finished.film, whole.film);
    assert_eq!(finished.totals, whole.totals);
    let failed = prepared.render_from(|_| Err(Error::option("film", "this", "another")));
    assert!(failed.unwrap_err().to_string().contains("expected another"));
}

/// The second render of a view takes its lights from the cache. With another seed, size or number
/// of VPLs, lights are traced again.
#[test]
fn cached_lights_are_those_of_the_view() {
    let (cache, told) = (LightCache::default(), Witness::default());
    let renderer = tiny().error(0.5).light_cache(&cache).observer(&told);
    let traced = renderer.render().unwrap().film;
    assert!(told.phases().contains("vpls"));
    let count = || told.phases().split(' ').filter(|phase| *phase == "vpls").count();
    let again = renderer.render().unwrap().film;
    assert_eq!((count(), &again), (1, &traced));
    for other in [renderer.clone().seed(8), renderer.clone().size([10, 10]), renderer.clone().vpls(2000)] {
        renderer.render().unwrap();
        let before = count();
        other.render().unwrap();
        assert_eq!(count(), before + 1);
    }
}

/// A set from `trace_lights` is passed to a second render. It gives the same image as a render that
/// traces its own set.
#[test]
fn lights_alone_are_those_of_the_render() {
    let transport = tiny().error(0.5);
    let set = transport.trace_lights().unwrap();
    let given = transport.clone().lights(LightSet::new(set)).truth(Truth::Transport);
    let (ours, theirs) = (transport.render().unwrap(), given.render().unwrap());
    assert_eq!(samples(&ours.film, ""), samples(&theirs.film, ""));

    let sum = tiny().method(SumMethod::Sakai2018);
    let given = sum.clone().lights(LightSet::new(sum.trace_lights().unwrap()));
    assert_eq!(sum.render().unwrap().film, given.render().unwrap().film);
    assert!(given.prepare().unwrap().other_set(&given.render().unwrap()).unwrap().is_none(), "given");
    let none = tiny().method(MethodName::Path).trace_lights().unwrap_err().to_string();
    assert!(none.contains("method = path; expected one that traces lights"), "{none}");
}

/// The radiance of all pixels is doubled after the render, and the audit contradicts the claims. A
/// film without claims is not audited.
#[test]
fn audits_find_false_claims() {
    let prepared = tiny().truth(Truth::Vpl).error(0.1).max_pairs(1 << 20).prepare().unwrap();
    let mut rendered = prepared.render().unwrap();
    let audit = prepared.audit(&rendered.film, 60).unwrap().unwrap();
    assert!(audit.claiming == 60 && !audit.contradicts && audit.low > 0.8, "{audit:?}");
    let plane = rendered.film.plane_mut("").unwrap();
    for (x, y) in Window::full(SIZE).pixels() {
        let doubled: Vec<f32> = plane.f32_at(x, y).iter().map(|value| 2.0 * value).collect();
        plane.set_f32(x, y, &doubled);
    }
    let audit = prepared.audit(&rendered.film, 60).unwrap().unwrap();
    // Doubling leaves black pixels black, and therefore within the tolerance.
    assert!(audit.contradicts && audit.within < audit.of / 2, "{audit:?}");

    let path = tiny().method(MethodName::Path).paths(4).prepare().unwrap();
    assert!(path.audit(&path.render().unwrap().film, 5).unwrap().is_none());
}

/// A path-traced film with claims is audited by other paths. With a fixed number of paths there is
/// no claim and no audit.
#[test]
fn paths_are_audited_by_other_paths() {
    let paths = tiny().method(MethodName::Path).size([6, 4]);
    let prepared = paths.clone().error(0.2).prepare().unwrap();
    let image = prepared.render().unwrap();
    let audit = prepared.audit(&image.film, 24).unwrap().unwrap();
    assert!(audit.of > 20 && audit.within + 4 > audit.of && !audit.contradicts, "{audit:?}");
    let promise = prepared.promise(Some(0.5)).unwrap();
    assert_eq!((promise.error, promise.absolute_error), (0.2, 0.5), "a film says what is enough in the dark");
    let (_, setting) = prepared.truth(&promise).unwrap();
    assert_ne!(setting.view.seed, prepared.setting().view.seed);
    let counted = paths.paths(8).prepare().unwrap();
    assert!(!counted.can_be_audited());
    assert_eq!(counted.audit(&image.film, 24).unwrap(), None);
}

#[test]
fn what_cannot_be_is_refused_before_any_work() {
    let told = Witness::default();
    let refused =
        |renderer: Renderer<'_>| renderer.observer(&told).prepare().err().expect("it cannot be").to_string();
    assert!(refused(tiny().error(0.0)).contains("error = 0"));
    assert!(refused(tiny().size([0, 5])).contains("0x5"));
    assert!(refused(tiny().crop(Window { x: 14, y: 0, width: 9, height: 1 })).contains("14"));
    assert!(refused(tiny().claim(ClaimName::Certified).truth(Truth::Transport)).contains("certified"));
    assert_eq!(told.phases(), "");
    let unused = tiny().method(MethodName::Path).claim(ClaimName::Certified).prepare().unwrap();
    assert_eq!(unused.unused(), ["vpls", "claim"]);
}

/// Work with a bound that is no claim, and a fixed number of paths, promise nothing.
#[test]
fn jobs_promise_what_their_methods_claim() {
    let promises = |renderer: Renderer<'_>| renderer.prepare().unwrap().job().promises();
    for method in [SumMethod::Lightcuts, SumMethod::Mdlc] {
        assert!(!promises(tiny().method(method)), "{method}");
    }
    for method in [SumMethod::Exact, SumMethod::Nabata2016, SumMethod::Tashika(Promise::Certified)] {
        assert!(promises(tiny().method(method)), "{method}");
    }
    assert!(
        !promises(tiny().method(MethodName::Path)) && promises(tiny().method(MethodName::Path).error(0.1))
    );
    assert!(promises(tiny().error(0.2)) && promises(tiny()));
}

/// Work has the lights of its kind; other lights are an error that names the option.
#[test]
fn lights_of_another_kind_are_an_error() {
    let sum = tiny().truth(Truth::Vpl).prepare().unwrap();
    let transport = tiny().error(0.2).prepare().unwrap();
    let path = tiny().method(MethodName::Path).prepare().unwrap();
    let named = |error: Option<Error>| match error {
        Some(Error::Option { option, .. }) => option,
        other => panic!("{other:?}"),
    };
    assert!(sum.job().light_set().is_ok() && transport.job().guided_lights().is_ok());
    assert_eq!(named(transport.job().light_set().err()), "truth");
    assert_eq!(named(sum.job().guided_lights().err()), "truth");
    assert_eq!(named(path.job().guided_lights().err()), "method");
    // A request for given lights, without any.
    let request = Request { lights_given: true, ..Request::of_a_sum() };
    assert_eq!(named(tiny().request(request).prepare().err()), "lights");
}

/// An integrator of one's own renders the film that the pipeline renders with the same integrator,
/// mattes included. A picture that is audited as a whole is no work of an integrator.
#[test]
fn an_integrator_of_ones_own_renders_the_view() {
    let prepared = tiny().method(SumMethod::Exact).mattes(2).prepare().unwrap();
    let own = FullSum::new(prepared.job().light_set().unwrap().set());
    let (ours, theirs) = (prepared.render().unwrap(), prepared.render_with(&own).unwrap());
    assert!(theirs.complete && theirs.film.planes() == ours.film.planes());
    assert!(tiny().prepare().unwrap().render_with(&own).is_err());
}
