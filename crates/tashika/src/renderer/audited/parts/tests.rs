//! Tests of joined shares, of the claims about them, and of faults that merging has to notice.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use super::super::tests::Flat;
use super::draw::{count, draw};
use super::finish_merged;
use crate::film::{Claim, Film, PictureClaim, RenderFilm, Stop, Window, keys, planes};
use crate::integrator::{ControlOptions, PathSampler, PathSamples, PathStop, PathTracer, Setting};
use crate::reconstruction::Smoother;
use crate::render::{Begun, Finished, Merged, Merger, Progress, RenderOptions, Rendered, TileShare, render};
use crate::render::{picture_tiles, with_threads};
use crate::renderer::{AuditedJob, Job, Observer, Prepared, Renderer};
use crate::request::{AuditTerms, ClaimName, MethodName, Request};
use crate::scene::builtin;
use crate::stats::{Moments, upper_share_outside};

/// Size of the image: six tiles, some of them cut by the border.
const SIZE: [u32; 2] = [70, 40];
const ERROR: f64 = 0.35;
const TERMS: AuditTerms = AuditTerms { share: 0.9, assurance: 0.9, pixels: 60, looks: 1, population: None };

fn request(seed: u64, error: f64) -> Request {
    Request {
        method: MethodName::Path,
        claim: Some(ClaimName::Audited),
        error: Some(error),
        share: Some(TERMS.share),
        assurance: Some(TERMS.assurance),
        audit: Some(TERMS.pixels),
        seed,
        ..Request::default()
    }
}

fn renderer<'a>(request: Request) -> Renderer<'a> {
    Renderer::new(builtin::tiny()).request(request).size(SIZE)
}

fn share(number: u32, of: u32) -> TileShare {
    TileShare::new(number, of).unwrap()
}

/// Renders the parts of `of` shares, except the shares in `but`.
fn parts(renderer: &Renderer<'_>, of: u32, but: &[u32]) -> Vec<Film> {
    let numbers = (1..=of).filter(|number| !but.contains(number));
    numbers.map(|number| renderer.clone().tiles(share(number, of)).render().unwrap().film).collect()
}

fn joined(parts: &[Film]) -> Merged {
    let name = Path::new("part.exr");
    let mut merger = Merger::new(name, &parts[0]).unwrap();
    parts[1..].iter().for_each(|part| merger.add(name, part).unwrap());
    merger.finish().unwrap()
}

fn merged(parts: &[Film]) -> Film {
    let mut merged = joined(parts);
    finish_merged(&mut merged, None).unwrap();
    merged.film
}

fn claim(film: &Film) -> PictureClaim {
    PictureClaim::of(film.metadata()).expect("an audit has an answer")
}

/// The picture is rendered in several numbers of shares, with several numbers of threads. The
/// merged pictures are equal.
#[test]
fn any_number_of_shares_is_the_same_picture() {
    let renderer = renderer(request(3, ERROR));
    let of = |shares, threads| with_threads(threads, || merged(&parts(&renderer, shares, &[]))).unwrap();
    let two = of(2, 1);
    assert!(two == of(3, 2) && two == of(5, 3));
    assert_eq!(two.metadata().text(keys::TILES), Some("1/1"));
    for plane in [planes::HALVES, planes::TRUTH] {
        assert!(two.plane(plane).is_none(), "{}: only merging needs it", plane.name);
    }
    // With more than sixteen shares, the film of a share covers only a part of the window, and some
    // shares have no tile.
    assert!(two == of(17, 2));
}

/// The same for a picture whose paths draw VPLs, as the pilot chooses for this scene.
#[test]
fn shares_of_a_picture_by_vpls_are_the_same_picture() {
    let request = Request { method: MethodName::default(), vpls: Some(5000), ..request(3, 0.5) };
    let renderer = Renderer::new(builtin::room()).request(request).size([24, 18]);
    let [two, one] = [&[][..], &[1]].map(|but| parts(&renderer, 2, but));
    let whole = merged(&two);
    assert!(whole == merged(&[one, parts(&renderer, 2, &[2])].concat()));
    assert!(claim(&whole).audited > 10 && whole.metadata().text(keys::METHOD) == Some("tashika"));
}

/// The claim is computed again, by its formulas, from the truths in the parts and the merged
/// picture. The results are equal.
#[test]
fn the_claim_is_that_of_one_look_at_the_whole() {
    let parts = parts(&renderer(request(1, ERROR)), 3, &[]);
    let film = merged(&parts);
    let (claim, read) = (claim(&film), RenderFilm::of(&film));
    let absolute = film.metadata().number(keys::ERROR_ABSOLUTE).unwrap();
    let (mut audited, mut outside, mut rays, mut shown) = (0, 0, 0.0, 0);
    for part in &parts {
        assert_eq!(PictureClaim::of(part.metadata()), None);
        assert_eq!(part.metadata().bool(keys::COMPLETE), Some(true));
        let truths = part.plane(planes::TRUTH).unwrap();
        for (x, y) in part.window().pixels() {
            let part = RenderFilm::of(part).at(x, y);
            assert_eq!(part.claim, Claim::None);
            assert!(matches!(part.stop, Stop::SampleCount | Stop::NotRendered));
            shown += u64::from(part.coverage > 0.0 || part.standard_error > 0.0);
            let [low, high, stage, of_pixel] = *truths.f32_at(x, y) else { panic!("four channels") };
            if stage > 0.0 {
                let value = f64::from(read.at(x, y).radiance.luminance());
                let is_within = |t: f32| (value - f64::from(t)).abs() <= (ERROR * f64::from(t)).max(absolute);
                audited += 1;
                outside += u64::from(!(is_within(low) && is_within(high)));
                rays += f64::from(of_pixel);
            }
        }
    }
    assert_eq!((claim.audited, claim.outside, claim.looks), (audited, outside, 1));
    assert!(audited.abs_diff(TERMS.pixels) < 25, "{claim}: binomial, as the box is half of the image");
    assert_eq!(claim.population, shown);
    let upper = upper_share_outside(outside, audited, 1.0 - TERMS.assurance, 1.0 - AuditTerms::CONFIDENCE);
    assert!((claim.upper_outside - upper).abs() < 1e-12, "all the risk is that of one look");
    assert_eq!(claim.reached, upper <= 1.0 - TERMS.share);
    assert_eq!(film.metadata().number(keys::AUDIT_RAYS), Some(rays));
    let verdicts = film.plane(planes::AUDITED).unwrap().f32_samples().unwrap();
    assert_eq!(verdicts.chunks(3).filter(|pixel| pixel[2] == 2.0).count() as u64, outside);
}

/// Parts are rendered with mattes. The merged picture has the planes of the mattes, but not the
/// planes that only merging needs.
#[test]
fn planes_beside_are_kept() {
    let of = |renderer: Renderer<'_>| merged(&parts(&renderer, 2, &[]));
    let plain = of(renderer(request(1, 0.5)));
    let with_mattes = of(renderer(request(1, 0.5)).mattes(2));
    let names = |film: &Film| film.planes().iter().map(|plane| plane.name().to_owned()).collect::<Vec<_>>();
    assert!(names(&plain).iter().all(|name| *name != planes::HALVES.name && *name != planes::TRUTH.name));
    let beside = names(&with_mattes).into_iter().filter(|name| !names(&plain).contains(name));
    assert_eq!(
        beside.collect::<Vec<_>>(),
        ["object_id", "CryptoObject00", "material_id", "CryptoMaterial00"]
    );
    let ids = with_mattes.plane(planes::OBJECT_ID).unwrap().u32_samples().unwrap();
    let objects = ids.iter().filter(|id| **id != 0).collect::<std::collections::BTreeSet<_>>().len();
    assert!(objects > 1, "{objects} objects are seen");
}

/// The claim is true of all pixels, by paths that are independent of the picture, and the map
/// holds.
#[test]
fn what_is_claimed_is_so() {
    let renderer = renderer(request(1, ERROR));
    let film = merged(&parts(&renderer, 2, &[]));
    let claim = claim(&film);
    assert!(claim.reached, "{claim}");
    let prepared = renderer.prepare().unwrap();
    let tracer = PathTracer::new(&prepared.tracer, PathStop::Count(1024), 16).unwrap();
    let options = RenderOptions { window: prepared.window, share: TileShare::default() };
    let truth = render(&prepared.setting(), &tracer, &options, &|_| {}, &AtomicBool::new(false)).unwrap();
    let (mut within, mut in_map, mut of) = (0, 0, 0);
    for ((x, y), truth) in film.window().pixels().zip(truth.film.colors().unwrap()) {
        let record = RenderFilm::of(&film).at(x, y);
        if record.claim != Claim::Audited {
            assert_eq!((record.claim, record.stop), (Claim::Exact, Stop::Complete), "it shows nothing");
            continue;
        }
        assert_eq!(record.stop, Stop::RuleMet);
        of += 1;
        let [value, truth] = [record.radiance, truth].map(|color| f64::from(color.luminance()));
        within += u32::from((value - truth).abs() <= ERROR * truth);
        in_map += u32::from((value - truth).abs() <= f64::from(record.half_width));
    }
    assert_eq!(of, claim.population);
    let [within, in_map] = [within, in_map].map(|count| f64::from(count) / of as f64);
    assert!(within >= claim.lower_within(), "{within} for {claim}");
    assert!(in_map >= TERMS.share, "{in_map} of the half-widths hold");
}

/// Sampler that draws paths with another sampler and changes the results.
struct Changed<'s, F> {
    sampler: &'s dyn PathSampler,
    change: F,
}

impl<F: Fn([u32; 2], PathSamples) -> PathSamples + Send + Sync> PathSampler for Changed<'_, F> {
    fn setting(&self) -> &Setting<'_> {
        self.sampler.setting()
    }

    fn tile(&self, tile: &Window, seed: u64, count: &dyn Fn([u32; 2]) -> u32) -> Vec<PathSamples> {
        let found = self.sampler.tile(tile, seed, count);
        tile.pixels().zip(found).map(|((x, y), found)| (self.change)([x, y], found)).collect()
    }
}

/// Returns both parts of a picture whose paths are changed by `change`.
fn changed(
    prepared: &Prepared<'_>,
    change: impl Fn([u32; 2], PathSamples) -> PathSamples + Copy + Send + Sync,
) -> Vec<Film> {
    let Job::Audited(AuditedJob { options, .. }) = prepared.job() else { panic!("an audited picture") };
    let options = ControlOptions { absolute_error: 0.01, ..*options };
    let method = prepared.path_tracer(prepared.of_audited(&options).unwrap()).unwrap();
    let sampler = method.path_sampler(prepared.setting());
    let changed = Changed { sampler: &sampler, change };
    let part = |number| {
        let prepared = Prepared { share: share(number, 2), ..prepared.clone() };
        let begin = |film| Ok(Begun { film, tiles: Vec::new() });
        super::render(&prepared, &method, &changed, &options, &TERMS, begin).unwrap().film
    };
    vec![part(1), part(2)]
}

/// Pixels of a film that have truths.
fn audited(film: &Film) -> Vec<(u32, u32)> {
    let truths = film.plane(planes::TRUTH).unwrap();
    film.window().pixels().filter(|(x, y)| truths.f32_at(*x, *y)[2] > 0.0).collect()
}

fn is_shown(part: &Film, x: u32, y: u32) -> bool {
    let record = RenderFilm::of(part).at(x, y);
    record.coverage > 0.0 || record.standard_error > 0.0
}

/// The paths of a second picture are made too bright. The audited pixels and their truths are the
/// same as in the right picture.
#[test]
fn truths_know_nothing_of_the_picture() {
    let prepared = renderer(request(1, ERROR)).prepare().unwrap();
    let right = changed(&prepared, |_, found| found);
    let bright = changed(&prepared, |_, found| {
        let (count, mean) = (found.luminance.count(), found.luminance.mean());
        let deviation = found.luminance.variance().sqrt();
        let mut luminance = Moments::default();
        (0..count)
            .for_each(|k| luminance.push(1.6 * (mean + if k % 2 == 0 { deviation } else { -deviation })));
        PathSamples { sum: found.sum.scaled(1.6), luminance, ..found }
    });
    let [of_right, of_bright] = [&right, &bright].map(|parts| claim(&merged(parts)));
    assert!(of_right.reached && of_right.outside <= 3, "{of_right}");
    assert!(!of_bright.reached && of_bright.outside > of_bright.audited * 4 / 5, "too bright: {of_bright}");
    let film = merged(&bright);
    // All pixels are out of budget, except those that show only a constant background: these are
    // exact.
    let tally = RenderFilm::of(&film).tally();
    assert_eq!(tally.out_of_budget + tally.of(Claim::Exact), film.window().area());
    let [right, bright] = [right, bright].map(|parts| joined(&parts).film);
    assert_eq!(audited(&right), audited(&bright));
    let drawn = draw(&right.window(), right.metadata().number(keys::AUDIT_DRAWN).unwrap() as u64, 1);
    let shown = drawn.iter().map(|[x, y]| (*x, *y)).filter(|(x, y)| is_shown(&right, *x, *y));
    let mut sorted: Vec<(u32, u32)> = shown.collect();
    sorted.sort_unstable_by_key(|(x, y)| (*y, *x));
    assert_eq!(audited(&right), sorted, "those that the seed draws");
}

/// Four fifths of the image are made a constant background. Such pixels are not audited; more
/// pixels are drawn to make up for them, and all parts draw the same number.
#[test]
fn what_shows_nothing_is_drawn_and_not_audited() {
    let prepared = renderer(request(1, 0.5)).prepare().unwrap();
    let nothing_beside = |[x, _]: [u32; 2], found: PathSamples| match x {
        28..42 => found,
        // A fifth of the image is left.
        _ => {
            let black = |count: u64| {
                (0..count).fold(PathSamples::default(), |mut sum, _| {
                    sum.luminance.push(0.0);
                    sum
                })
            };
            black(found.luminance.count())
        }
    };
    let parts = changed(&prepared, nothing_beside);
    let drawn = parts[0].metadata().number(keys::AUDIT_DRAWN).unwrap();
    // A fifth of the pilots shows something, so about 300 pixels are drawn for 60. The number of
    // such pilots, of 1024, is binomial.
    assert!((drawn / 300.0 - 1.0).abs() < 0.3, "{drawn}");
    let film = merged(&parts);
    let claim = claim(&film);
    let is_left = |x: u32| (28..42).contains(&x);
    let plain = joined(&parts).film;
    let left = film.window().pixels().filter(|(x, y)| is_left(*x) && is_shown(&plain, *x, *y));
    assert_eq!(claim.population, left.count() as u64);
    assert!(claim.audited.abs_diff(TERMS.pixels) < 30, "{claim}");
    let audited = film.plane(planes::AUDITED).unwrap();
    for (x, y) in film.window().pixels() {
        let is_shown = RenderFilm::of(&film).at(x, y).claim == Claim::Audited;
        assert!(is_shown <= is_left(x) && (is_shown || audited.f32_at(x, y)[2] == 0.0));
    }
    let all_black = changed(&prepared, |pixel, found| nothing_beside([99, pixel[1]], found));
    assert_eq!(PictureClaim::of(merged(&all_black).metadata()), None, "there is nothing to audit");
}

/// In a picture that is expensive compared with its truths, twice the number of pixels is audited.
#[test]
fn large_pictures_have_more_pixels_audited() {
    let prepared = renderer(request(1, ERROR)).prepare().unwrap();
    let method = prepared.path_tracer(PathStop::Count(1)).unwrap();
    let sampler = method.path_sampler(prepared.setting());
    let of = |terms: AuditTerms| count(&sampler, &prepared.window(), &terms, 1);
    let [sixty, seven] = [TERMS, AuditTerms { pixels: 7, ..TERMS }].map(of);
    // Up to rounding to whole pixels. A picture of 2,800 pixels is expensive compared with seven
    // truths, so 14 pixels are audited.
    assert!((60.0 * seven as f64 / sixty as f64 - 14.0).abs() < 1.0, "{sixty} {seven}");
    assert!(sixty > 60 && sixty < 180, "{sixty}: about half of the image shows nothing");
    assert_eq!(of(AuditTerms { pixels: 9000, ..TERMS }), prepared.window().area());
}

/// A truth is moved to another pixel, or removed. Merging refuses both.
#[test]
fn truths_of_other_pixels_are_refused() {
    let right = joined(&parts(&renderer(request(1, 0.5)), 2, &[]));
    let places = audited(&right.film);
    let (from, other) = (places[7], (places[7].0 ^ 1, places[7].1));
    assert!(!places.contains(&other));
    let refused = |change: &dyn Fn(&mut Film)| {
        let mut wrong = right.clone();
        change(&mut wrong.film);
        finish_merged(&mut wrong, None).unwrap_err().to_string()
    };
    let set = |film: &mut Film, (x, y): (u32, u32), truth: &[f32]| {
        film.plane_mut(planes::TRUTH).unwrap().set_f32(x, y, truth);
    };
    let left_out = refused(&|film| set(film, from, &[0.0; 4]));
    assert!(
        left_out.contains("part.exr: no truth at pixel") && left_out.contains("the seed draws"),
        "{left_out}"
    );
    let added = refused(&|film| set(film, other, &[0.0, 1.0, 1.0, 9.0]));
    assert!(added.contains("a truth at pixel"), "{added}");
    let turned = refused(&|film| set(film, from, &[1.0, 0.5, 1.0, 9.0]));
    assert!(turned.contains("no truth"), "{turned}");
    let seed = refused(&|film| film.metadata_mut().set(keys::SEED, 2_u32));
    assert!(seed.contains("truth at pixel"), "{seed}");
    let fewer = refused(&|film| film.metadata_mut().set(keys::AUDIT_DRAWN, 40_u32));
    assert!(fewer.contains("a truth at pixel"), "{fewer}");
}

/// A pixel whose truth is unknown counts as outside.
#[test]
fn what_is_not_known_is_outside() {
    let mut unknown = joined(&parts(&renderer(request(1, 0.5)), 2, &[]));
    let mut known = unknown.clone();
    finish_merged(&mut known, None).unwrap();
    for (x, y) in audited(&unknown.film) {
        // The lower end of the interval is the value of the picture; the upper end is infinite.
        let low = RenderFilm::of(&known.film).at(x, y).radiance.luminance();
        unknown.film.plane_mut(planes::TRUTH).unwrap().set_f32(x, y, &[low, f32::INFINITY, 3.0, 9.0]);
    }
    finish_merged(&mut unknown, None).unwrap();
    let [unknown, known] = [claim(&unknown.film), claim(&known.film)];
    assert!(unknown.outside == known.audited && known.outside < 6, "{unknown}; {known}");
}

/// Metadata and samples of parts are damaged. Merging refuses the parts and names the fault.
#[test]
fn parts_that_are_damaged_are_refused_with_what_is_wrong() {
    let right = joined(&parts(&renderer(request(1, 0.5)), 2, &[]));
    let refused = |change: &dyn Fn(&mut Film)| {
        let mut wrong = right.clone();
        change(&mut wrong.film);
        finish_merged(&mut wrong, None).unwrap_err().to_string()
    };
    for key in [
        keys::AUDIT_SHARE,
        keys::AUDIT_ASSURANCE,
        keys::AUDIT_MOST_LOOKS,
        keys::AUDIT_DRAWN,
        keys::ERROR,
        keys::ERROR_ABSOLUTE,
        keys::SEED,
    ] {
        let missing = refused(&|film| film.metadata_mut().remove(key));
        assert!(missing.contains(&format!("`{key}` is missing")), "{missing}");
        let odd = refused(&|film| film.metadata_mut().set(key, f64::NAN));
        assert!(odd.contains(&format!("`{key}` is NaN")), "{odd}");
    }
    for share in [0.0, 1.0, -3.0] {
        assert!(refused(&|film| film.metadata_mut().set(keys::AUDIT_SHARE, share)).contains("a share of 1"));
    }
    let without = refused(&|film| {
        let all = film.planes().iter().filter(|plane| plane.name() != planes::TRUTH.name).cloned().collect();
        *film = Film::from_planes(film.size(), film.window(), all, film.metadata().clone());
    });
    assert!(without.contains(planes::TRUTH.name), "{without}");
    // Samples that are NaN are not refused; their pixels count as outside.
    let mut odd = right.clone();
    let halves = odd.film.plane_mut(planes::HALVES).unwrap();
    Window::full(SIZE).pixels().for_each(|(x, y)| halves.set_f32(x, y, &[f32::NAN; 9]));
    finish_merged(&mut odd, None).unwrap();
    assert!(claim(&odd.film).outside == claim(&odd.film).audited && !claim(&odd.film).reached);
}

#[test]
fn a_share_that_is_missing_can_come_later() {
    let renderer = renderer(request(1, 0.5));
    let [first, second, third] = &parts(&renderer, 3, &[])[..] else { panic!("three parts") };
    let whole = merged(&[first, second, third].map(Clone::clone));
    let some = merged(&[first.clone(), third.clone()]);
    assert_eq!(PictureClaim::of(some.metadata()), None);
    assert_eq!(RenderFilm::of(&some).tally().of(Claim::Audited), 0);
    assert!(some.plane(planes::HALVES).is_some() && some.plane(planes::AUDITED).is_none());
    assert!(merged(&[second.clone(), some.clone()]) == whole && merged(&[some, second.clone()]) == whole);
}

#[test]
fn parts_of_other_renders_are_refused() {
    let of = |request: Request| renderer(request).tiles(share(1, 2)).render().unwrap().film;
    let first = of(request(1, 0.5));
    let refused = |other: Request| {
        let part = renderer(other).tiles(share(2, 2)).render().unwrap().film;
        let mut merger = Merger::new(Path::new("a.exr"), &first).unwrap();
        merger.add(Path::new("b.exr"), &part).unwrap_err().to_string()
    };
    assert!(refused(request(2, 0.5)).contains("seed = 2"));
    assert!(refused(request(1, 0.4)).contains("error = 0.4"));
    let terms = [
        (Request { share: Some(0.8), ..request(1, 0.5) }, "audit.share"),
        (Request { assurance: Some(0.8), ..request(1, 0.5) }, "audit.assurance"),
        (Request { audit: Some(70), ..request(1, 0.5) }, "audit.drawn"),
    ];
    for (other, said) in terms {
        assert!(refused(other).contains(said), "{said}");
    }
    // A crop of the merged picture claims nothing, and the merged picture is not accepted as a
    // part.
    let whole = merged(&parts(&renderer(request(1, 0.5)), 2, &[]));
    let crop = whole.cropped(Window { x: 3, y: 3, width: 9, height: 9 }).unwrap();
    assert_eq!(PictureClaim::of(crop.metadata()), None);
    assert!(Merger::new(Path::new("a.exr"), &first).unwrap().add(Path::new("w.exr"), &whole).is_err());
}

/// Merging accepts only the smoother for which the parts were rendered.
#[test]
fn there_is_one_smoother_to_choose_and_one_look() {
    let own = joined(&parts(&renderer(request(1, 0.5)), 2, &[]));
    let flat = joined(&parts(&renderer(request(1, 0.5)).smoother(Arc::new(Flat)), 2, &[]));
    let refused = |merged: &Merged, smoother: Option<&dyn Smoother>| {
        finish_merged(&mut merged.clone(), smoother).unwrap_err().to_string()
    };
    assert!(refused(&own, Some(&Flat)).contains("denoiser = flat; expected own"));
    assert!(refused(&flat, None).contains("denoiser = own; expected flat"));
    let mut merged = flat;
    finish_merged(&mut merged, Some(&Flat)).unwrap();
    assert_eq!(merged.film.metadata().text(keys::DENOISER), Some("flat"));
    assert!(claim(&merged.film).audited > 30);
}

/// Observer that cancels the work after `most[0]` tiles, or after `most[1]` calls of `cancel`.
struct Ending {
    tiles: AtomicU32,
    asked: AtomicU32,
    most: [u32; 2],
    cancel: AtomicBool,
}

impl Ending {
    fn new(tiles: u32, asked: u32) -> Self {
        let most = [tiles, asked];
        Self { tiles: AtomicU32::new(0), asked: AtomicU32::new(0), most, cancel: AtomicBool::new(false) }
    }

    fn count(&self, counter: &AtomicU32, most: u32) {
        if counter.fetch_add(1, Ordering::SeqCst) + 1 == most {
            self.cancel.store(true, Ordering::SeqCst);
        }
    }
}

impl Observer for Ending {
    fn tile(&self, _: &Finished<'_>) {
        self.count(&self.tiles, self.most[0]);
    }

    fn progress(&self, _: &Progress) {}

    fn cancel(&self) -> &AtomicBool {
        self.count(&self.asked, self.most[1]);
        &self.cancel
    }
}

/// The render of a part is cancelled. Its finished tiles have all samples and truths, and a later
/// render continues from them.
#[test]
fn what_is_finished_of_a_part_that_is_cancelled_stays() {
    let ending = Ending::new(1, u32::MAX);
    let of = renderer(request(1, 0.5)).tiles(share(1, 2));
    let whole = of.render().unwrap().film;
    let broken: Rendered = with_threads(1, || of.clone().observer(&ending).render().unwrap()).unwrap();
    assert!(!broken.complete && broken.film.metadata().bool(keys::COMPLETE) == Some(false));
    let options = RenderOptions { window: Window::full(SIZE), share: share(1, 2) };
    let is_done = |tile: &Window| RenderFilm::of(&broken.film).at(tile.x, tile.y).stop == Stop::SampleCount;
    let tiles: Vec<Window> = picture_tiles(&options).into_iter().filter(is_done).collect();
    assert_eq!(tiles.len(), 1);
    let part = tiles[0];
    assert!(whole.cropped(part).unwrap().planes() == broken.film.cropped(part).unwrap().planes());
    // The work is cancelled at many different points, during passes and during truths.
    let mut ended = 0;
    for asked in (2..).step_by(15) {
        let ending = Ending::new(u32::MAX, asked);
        let broken = with_threads(1, || of.clone().observer(&ending).render().unwrap()).unwrap();
        if broken.complete {
            break;
        }
        ended += 1;
        for tile in picture_tiles(&options) {
            let [of_whole, of_broken] = [&whole, &broken.film].map(|film| film.cropped(tile).unwrap());
            let is_done = RenderFilm::of(&of_broken).at(tile.x, tile.y).stop == Stop::SampleCount;
            assert!(!is_done || of_whole.planes() == of_broken.planes(), "{asked}: {tile}");
        }
    }
    assert!(ended > 3, "{ended}");
    let begun = Begun { film: broken.film.clone(), tiles };
    let again = of.prepare().unwrap().render_from(|_| Ok(begun)).unwrap();
    assert!(again.complete && again.film == whole);
    let other = parts(&renderer(request(1, 0.5)), 2, &[1]);
    let missing = joined(&[broken.film, other[0].clone()]);
    assert!(missing.missing.is_empty() && missing.missing_pixels > 0);
}
