//! Tests of claims about pictures, of reports to observers, and of faults that an audit has to
//! notice.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use super::truth::Around;
use super::truths::{Source, Truths};
use super::verdict::{AuditedPixel, Tolerance};
use crate::color::Rgb;
use crate::error::Result;
use crate::film::{Claim, Film, PictureClaim, RenderFilm, Stop, Window, keys, planes};
use crate::integrator::{ControlOptions, PathStop, PathTracer, Truth};
use crate::reconstruction::Smoother;
use crate::render::{Finished, Progress, RenderOptions, Rendered, TileShare, render, with_threads};
use crate::renderer::{Observer, Prepared, Renderer};
use crate::request::{AuditTerms, ClaimName, MethodName, Request};
use crate::scene::builtin;

const SIZE: [u32; 2] = [32, 24];
const ERROR: f64 = 0.25;
const TERMS: AuditTerms =
    AuditTerms { share: 0.9, assurance: 0.9, pixels: 60, looks: AuditTerms::LOOKS, population: None };

fn renderer<'a>(seed: u64) -> Renderer<'a> {
    let request = Request {
        claim: Some(ClaimName::Audited),
        error: Some(ERROR),
        share: Some(TERMS.share),
        assurance: Some(TERMS.assurance),
        audit: Some(TERMS.pixels),
        vpls: Some(5000),
        seed,
        ..Request::default()
    };
    Renderer::new(builtin::tiny()).request(request).size(SIZE)
}

/// Path-traced film with many paths of each pixel.
fn truth(prepared: &Prepared<'_>) -> Film {
    let tracer = PathTracer::new(&prepared.tracer, PathStop::Count(1024), 16).unwrap();
    let options = RenderOptions { window: prepared.window, share: TileShare::default() };
    render(&prepared.setting(), &tracer, &options, &|_| {}, &AtomicBool::new(false)).unwrap().film
}

/// All pixels are compared with a film of independent paths. At least the claimed share is within
/// the error, and the requested share is within its half-widths.
#[test]
fn what_is_claimed_is_so() {
    is_so(renderer(1));
}

/// The same test for a picture by path tracing alone.
#[test]
fn what_is_claimed_is_so_without_vpls() {
    let image = is_so(renderer(1).method(MethodName::Path));
    let metadata = image.film.metadata();
    assert_eq!(metadata.text(keys::METHOD), Some("path"));
    assert!(metadata.get(keys::VPLS).is_none() && metadata.get(keys::PATHS_MOST).is_none());
}

fn is_so(renderer: Renderer<'_>) -> Rendered {
    let prepared = renderer.prepare().unwrap();
    let image = prepared.render().unwrap();
    let claim = PictureClaim::of(image.film.metadata()).expect("an audit has an answer");
    assert!(image.complete && claim.reached, "{claim}");
    assert!([TERMS.pixels, TERMS.more_pixels()].contains(&claim.audited), "{claim}");
    assert_eq!((claim.share, claim.error), (TERMS.share, ERROR));
    let (read, truth) = (RenderFilm::of(&image.film), truth(&prepared));
    let (mut within, mut in_map, mut of) = (0, 0, 0);
    for ((x, y), truth) in Window::full(SIZE).pixels().zip(truth.colors().unwrap()) {
        let record = read.at(x, y);
        if record.claim != Claim::Audited {
            continue;
        }
        assert_eq!(record.stop, Stop::RuleMet);
        let [value, truth] = [record.radiance, truth].map(|color| f64::from(color.luminance()));
        of += 1;
        within += u32::from((value - truth).abs() <= ERROR * truth);
        in_map += u32::from((value - truth).abs() <= f64::from(record.half_width));
    }
    assert_eq!(of, claim.population);
    let [within, in_map] = [within, in_map].map(|count| f64::from(count) / of as f64);
    assert!(within >= claim.lower_within(), "{within} for {claim}");
    assert!(in_map >= TERMS.share, "{in_map} of the half-widths hold");
    let audited = image.film.plane(planes::AUDITED).unwrap().f32_samples().unwrap();
    let verdicts = audited.chunks(3).filter(|pixel| pixel[2] > 0.0).count() as u64;
    assert_eq!(verdicts, claim.audited);
    image
}

/// The film is the same with one thread and with three.
#[test]
fn the_same_request_gives_the_same_bits() {
    for method in [MethodName::default(), MethodName::Path] {
        let small = || renderer(3).method(method).size([16, 12]).error(0.5);
        let with = |threads: usize| with_threads(threads, || small().render().unwrap().film).unwrap();
        assert!(with(1) == with(3), "{method}");
    }
}

/// Tolerance for the built-in box, whose luminance is about 1.
fn tolerance() -> Tolerance {
    Tolerance { error: ERROR, absolute: 0.01 }
}

/// Estimates about the paths of a pixel, from a film of many paths.
fn around(film: &Film) -> impl Fn([u32; 2]) -> Around {
    let records: Vec<_> = Window::full(SIZE).pixels().map(|(x, y)| RenderFilm::of(film).at(x, y)).collect();
    move |[x, y]| {
        let record = &records[Window::full(SIZE).index(x, y)];
        let error = f64::from(record.standard_error);
        Around {
            luminance: record.radiance.luminance().into(),
            variance: error * error * record.pairs as f64,
        }
    }
}

fn truths<'p>(prepared: &'p Prepared<'p>, film: &Film) -> Truths<'p> {
    truths_of(prepared, film, film)
}

/// Truths of pixels of a picture, with the paths of another film around them.
fn truths_of<'p>(prepared: &'p Prepared<'p>, picture: &Film, film: &Film) -> Truths<'p> {
    let options = ControlOptions { error: ERROR, ..ControlOptions::default() };
    let source = Source::of(prepared, &options, &tolerance()).unwrap();
    Truths::compute(source, picture, &around(film), &TERMS, true, None).unwrap().unwrap()
}

/// The audit rejects a picture that is too bright and one in which all pixels are equal. It accepts
/// the right picture.
#[test]
fn faults_of_a_picture_are_noticed() {
    are_noticed(&renderer(1).prepare().unwrap());
    are_noticed(&renderer(1).method(MethodName::Path).prepare().unwrap());
}

fn are_noticed(prepared: &Prepared<'_>) {
    let right = truth(prepared);
    let mut truths = truths(prepared, &right);
    let window = Window::full(SIZE);
    let radiance: Vec<Rgb> = right.colors().unwrap().collect();
    assert!(truths.refine(&window, &radiance, |_, _| false).unwrap());
    let outside = |change: &dyn Fn(Rgb) -> Rgb| {
        let radiance: Vec<Rgb> = right.colors().unwrap().map(change).collect();
        truths.look(&window, &radiance, &vec![1.0; radiance.len()]).outside
    };
    let colors: Vec<Rgb> = right.colors().unwrap().collect();
    let mean = colors.iter().fold(Rgb::BLACK, |sum, color| sum + *color) / colors.len() as f32;
    assert!(outside(&|color| color) <= 2, "{}", outside(&|color| color));
    assert!(outside(&|color| color * 1.4) > 45, "too bright: {}", outside(&|color| color * 1.4));
    assert!(outside(&|_| mean) >= 30, "flat: {}", outside(&|_| mean));
}

/// Every pixel is set to the border of its tolerance, so that nearly every truth is open. These
/// truths are refined, each only once.
#[test]
fn what_is_open_is_computed_once_more() {
    let prepared = renderer(1).prepare().unwrap();
    let film = truth(&prepared);
    let mut truths = truths(&prepared, &film);
    let window = Window::full(SIZE);
    // The value of the pixel is exactly at the border of the tolerance of the truth in the middle
    // of the interval.
    let mut radiance: Vec<Rgb> = film.colors().unwrap().collect();
    for truth in &truths.pixels {
        let [low, high] = truth.interval.unwrap();
        let at = window.index(truth.pixel[0], truth.pixel[1]);
        radiance[at] = Rgb::gray((0.5 * (low + high) * (1.0 + ERROR)) as f32);
    }
    let width = |truths: &Truths<'_>| {
        truths
            .pixels
            .iter()
            .map(|truth| truth.interval.map_or(9.0, |[low, high]| (high - low) / high.max(1e-3)))
            .sum::<f64>()
    };
    let (before, rays) = (width(&truths), truths.rays);
    let told = std::cell::Cell::new((0, 0));
    let is_decided = |outside, may_be| {
        told.set((outside, may_be));
        true
    };
    assert!(truths.refine(&window, &radiance, is_decided).unwrap());
    assert_eq!((width(&truths), truths.rays), (before, rays), "nobody wants to know more");
    // Nearly every pixel may be outside; no pixel is certainly outside.
    let is_within = |truth: &&AuditedPixel| {
        let [x, y] = truth.pixel;
        truth.is_within(radiance[window.index(x, y)].luminance().into(), &tolerance())
    };
    let within = truths.pixels.iter().filter(is_within).count() as u64;
    assert!(within < 10, "{within}");
    assert_eq!(told.get(), (0, TERMS.pixels - within));
    assert!(truths.refine(&window, &radiance, |_, _| false).unwrap());
    assert!(width(&truths) < 0.8 * before && truths.rays > rays, "{} of {before}", width(&truths));
    let again = truths.pixels.clone();
    assert!(truths.refine(&window, &radiance, |_, _| false).unwrap());
    assert_eq!(again, truths.pixels);
}

/// `extend` audits pixels from the same draw that were not among the first.
#[test]
fn more_pixels_are_audited_beside_the_first() {
    let prepared = renderer(1).prepare().unwrap();
    let film = truth(&prepared);
    let mut truths = truths(&prepared, &film);
    let (first, rays) = (truths.pixels.clone(), truths.rays);
    assert!(truths.extend().unwrap());
    assert_eq!(
        (truths.pixels.len() as u64, &truths.pixels[..first.len()]),
        (TERMS.more_pixels(), &first[..])
    );
    assert!(truths.rays > rays && truths.pixels.iter().all(|truth| truth.interval.is_some()));
    let mut places: Vec<[u32; 2]> = truths.pixels.iter().map(|truth| truth.pixel).collect();
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), truths.pixels.len(), "none is audited twice");
    let (all, rays) = (truths.pixels.clone(), truths.rays);
    assert!(truths.extend().unwrap());
    assert_eq!((all, rays), (truths.pixels, truths.rays), "there are no more");
}

/// If time is short, few pixels are audited, and they are the first ones of the draw.
#[test]
fn as_many_pixels_are_audited_as_there_is_time_for() {
    let prepared = renderer(1).prepare().unwrap();
    let film = truth(&prepared);
    let drawn = |prepared: &Prepared<'_>| -> Vec<[u32; 2]> {
        truths(prepared, &film).pixels.iter().map(|truth| truth.pixel).collect()
    };
    let without_end = drawn(&prepared);
    // Twenty seconds are left, and truths may take five of them. The first 32 of them take the
    // given time, in the first of their stages, which are assumed to take four times as long.
    // The mean number of paths of all drawn pixels is not quite that of the first ones.
    for (seconds, counts) in [(0.1, 60..=60), (1.0, 34..=48), (8.0, 32..=32)] {
        // The first question decides the number of VPLs.
        let clock = Clock { left: Mutex::new(20.0 + seconds), step: seconds };
        let prepared = Prepared { observer: &clock, ..prepared.clone() };
        let pixels = drawn(&prepared);
        assert!(counts.contains(&pixels.len()), "{seconds} s: {}", pixels.len());
        assert_eq!(pixels, without_end[..pixels.len()]);
    }
}

/// With a fixed number of paths, the pixels are the first ones of the draw, and no stage has more
/// paths than are left.
#[test]
fn as_many_pixels_are_audited_as_there_are_paths_for() {
    let prepared = renderer(1).prepare().unwrap();
    let film = truth(&prepared);
    let options = ControlOptions { error: ERROR, ..ControlOptions::default() };
    let with = |paths: Option<u64>| {
        let source = Source::of(&prepared, &options, &tolerance()).unwrap();
        Truths::compute(source, &film, &around(&film), &TERMS, false, paths).unwrap().unwrap()
    };
    let [all, none] = [None, Some(1)].map(with);
    assert_eq!((all.pixels.len(), none.pixels.len()), (60, 32));
    // A truth of this scene has about 450 paths in its first stage.
    let few = with(Some(4 * 45 * 450));
    assert!((33..60).contains(&few.pixels.len()), "{}", few.pixels.len());
    assert_eq!(few.pixels, all.pixels[..few.pixels.len()]);
    // A picture that is off by the tolerance leaves pixels open; without paths they stay so.
    let window = Window::full(SIZE);
    let radiance: Vec<Rgb> = film.colors().unwrap().map(|color| color * (1.0 + ERROR as f32)).collect();
    let rays = |mut truths: Truths<'_>| {
        let before = truths.rays;
        assert!(truths.refine(&window, &radiance, |_, _| false).unwrap());
        truths.rays - before
    };
    let [all, few, none] = [all, few, none].map(rays);
    assert!(none == 0 && few > 0 && few < all, "{none} {few} {all}");
}

/// Observer with a time limit, of which each question takes `step` seconds.
struct Clock {
    left: Mutex<f64>,
    step: f64,
}

impl Observer for Clock {
    fn seconds_left(&self) -> Option<f64> {
        let mut left = self.left.lock().unwrap();
        *left -= self.step;
        Some(*left + self.step)
    }
}

/// The same pixels are audited in a picture and in a darkened copy. Truths depend on the picture
/// only by their numbers of paths and the smallest width of their intervals, and their seed is not
/// that of the picture.
#[test]
fn the_audit_knows_nothing_of_the_picture() {
    let prepared = renderer(1).prepare().unwrap();
    let film = truth(&prepared);
    let mut darker = film.clone();
    for (x, y) in Window::full(SIZE).pixels() {
        darker.plane_mut(planes::RADIANCE).unwrap().set_f32(x, y, &[0.0; 3]);
    }
    let of = |picture: &Film| truths_of(&prepared, picture, &film);
    let [of_film, of_darker] = [&film, &darker].map(of);
    assert_eq!(of_film.pixels, of_darker.pixels);
    let chosen = |truths: &Truths| truths.pixels.iter().map(|truth| truth.pixel).collect::<Vec<_>>();
    let mut sorted = chosen(&of_film);
    sorted.sort_unstable();
    assert_ne!(sorted, chosen(&of_film), "pixels are drawn in no order of the image");
    assert!(of_film.pixels.iter().all(|truth| truth.interval.is_some()));
}

/// The lights of the truths differ from the lights of the picture.
#[test]
fn the_audit_has_lights_of_its_own() {
    let prepared = renderer(1).prepare().unwrap();
    let truths = truths(&prepared, &truth(&prepared));
    let of_picture = prepared.job().guided_lights().unwrap();
    assert_ne!(truths.lights().provenance().seed, of_picture.provenance().seed);
}

/// Smoother that sets every pixel to the mean of the picture.
#[derive(Debug)]
pub(super) struct Flat;

impl Smoother for Flat {
    fn name(&self) -> String {
        "flat".to_owned()
    }

    fn smooth(&self, radiance: &[Rgb], _: &Film) -> Result<Vec<Rgb>> {
        let sum = radiance.iter().fold(Rgb::BLACK, |sum, color| sum + *color);
        Ok(vec![sum / radiance.len() as f32; radiance.len()])
    }
}

/// A smoother that is wrong everywhere is not used: the picture consists of its unsmoothed samples,
/// and the audit reports how few pixels are within the error.
#[test]
fn a_smoother_that_returns_the_mean_is_noticed() {
    let of = |smoother: Option<Arc<dyn Smoother>>| {
        let renderer = renderer(1).error(0.1).passes(6);
        let image = smoother.into_iter().fold(renderer, Renderer::smoother).render().unwrap();
        let name = image.film.metadata().text(keys::DENOISER).map(str::to_owned);
        (PictureClaim::of(image.film.metadata()).unwrap(), name)
    };
    let ((own, of_own), (flat, of_flat)) = (of(None), of(Some(Arc::new(Flat))));
    assert_eq!((of_own, of_flat.as_deref()), (None, Some("flat")));
    assert!(
        !flat.reached && flat.outside * own.audited > own.outside * flat.audited,
        "{flat}; our own: {own}"
    );
}

/// Observer that ends the work after `most` pictures: by an expired time limit if `is_late`, else
/// by cancelling.
struct Ending {
    pictures: AtomicU32,
    most: u32,
    cancel: AtomicBool,
    is_late: bool,
}

impl Ending {
    fn new(most: u32, is_late: bool) -> Self {
        Self { pictures: AtomicU32::new(0), most, cancel: AtomicBool::new(false), is_late }
    }
}

impl Observer for Ending {
    fn tile(&self, done: &Finished<'_>) {
        assert_eq!(done.tile, Window::full(SIZE), "whole pictures are shown");
        if self.pictures.fetch_add(1, Ordering::SeqCst) + 1 == self.most && !self.is_late {
            self.cancel.store(true, Ordering::SeqCst);
        }
    }

    fn progress(&self, _: &Progress) {}

    fn seconds_left(&self) -> Option<f64> {
        // Each picture takes ten seconds.
        self.is_late.then(|| 10.0 * f64::from(self.most.saturating_sub(self.pictures.load(Ordering::SeqCst))))
    }

    fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }
}

/// The time limit expires before the requested error is reached. The film still states a claim,
/// about a smaller share.
#[test]
fn there_is_an_answer_when_the_time_is_up() {
    let ending = Ending::new(2, true);
    let image = renderer(1).error(0.001).observer(&ending).render().unwrap();
    let claim = PictureClaim::of(image.film.metadata()).unwrap();
    assert!(image.complete && !claim.reached && claim.looks == 1, "{claim}");
    assert!(claim.lower_within() < 0.5, "{claim}");
    assert_eq!(ending.pictures.load(Ordering::SeqCst), 2, "a third picture would be late");
    assert!(image.totals.tally.out_of_budget > 0);
    is_a_map_or_none(&image.film);
    // If no time is left for truths, the fewest are computed.
    let image = renderer(1).error(0.001).observer(&Ending::new(1, true)).render().unwrap();
    let claim = PictureClaim::of(image.film.metadata()).unwrap();
    assert!(claim.audited == 32 && claim.looks == 1, "{claim}");
    is_a_map_or_none(&image.film);
    let audited = image.film.plane(planes::AUDITED).unwrap().f32_samples().unwrap();
    let is_unknown = |pixel: &[f32]| pixel[..2].iter().all(|end| end.is_nan());
    assert!(audited.chunks(3).filter(|pixel| pixel[2] == 0.0).all(is_unknown), "zero would be black");
}

/// Checks that audited half-widths are positive, those of the background zero, and all others NaN.
fn is_a_map_or_none(film: &Film) {
    let mut exact = 0;
    for (x, y) in Window::full(SIZE).pixels() {
        let record = RenderFilm::of(film).at(x, y);
        match record.claim {
            Claim::Audited => assert!(record.half_width > 0.0, "{x} {y}: {record:?}"),
            Claim::Exact => {
                assert_eq!((record.half_width, record.coverage, record.stop), (0.0, 0.0, Stop::Complete));
                exact += 1;
            }
            _ => assert!(record.half_width.is_nan(), "{x} {y}: {record:?}"),
        }
    }
    assert!(exact > 0, "some of the image shows nothing");
}

#[test]
fn what_is_cancelled_claims_nothing() {
    let ending = Ending::new(1, false);
    let image = renderer(1).observer(&ending).render().unwrap();
    assert!(!image.complete);
    assert_eq!(PictureClaim::of(image.film.metadata()), None);
    assert!(RenderFilm::of(&image.film).tally().of(Claim::Audited) == 0);
    assert!(image.totals.mean.luminance() > 0.0, "there is a picture");
}

#[test]
fn what_does_not_go_with_it_is_refused() {
    let refused = |renderer: Renderer<'_>| renderer.prepare().err().expect("refused").to_string();
    assert!(refused(renderer(1).truth(Truth::Vpl)).contains("transport"));
    let few = Request { claim: Some(ClaimName::Audited), audit: Some(20), ..Request::default() };
    let few = refused(Renderer::new(builtin::tiny()).request(few));
    assert!(few.contains("256 are enough"), "{few}");
}
