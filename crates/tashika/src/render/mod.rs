//! From a setting and an integrator to a film: tiles or chosen pixels, threads, progress,
//! cancellation.
//!
//! Tiles are independent and the estimate of a pixel depends on neither, so films are equal bit by
//! bit for any number of threads, any window and any share of the tiles.

mod merge;
mod tiles;

#[cfg(test)]
mod tests;

pub use merge::{Merged, Merger};
pub use tiles::TileShare;

use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::color::{Rgb, RgbSum};
use crate::error::{Error, Result};
use crate::film::{Film, PlaneSpec, SampleKind, Window};
use crate::integrator::{ErrorClaim, Integrator, PixelEstimate, Setting, StopReason};

/// What is rendered of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// The part of the image.
    pub window: Window,
    /// The shares of its tiles.
    pub share: TileShare,
}

/// How far a render is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Pixels finished.
    pub pixels: u64,
    /// Pixels to do in all.
    pub of: u64,
    /// Of the finished pixels, those whose estimate is exact or as good as was asked for.
    pub promise_met: u64,
    /// Rays and segments traced for them.
    pub rays: u64,
}

/// A tile that was finished just now.
#[derive(Clone, Copy, Debug)]
pub struct Finished<'a> {
    /// How far the render is.
    pub progress: Progress,
    /// Its film; pixels of tiles that are not finished are zero.
    pub film: &'a Film,
    /// The tile.
    pub tile: Window,
}

/// Sums over the pixels that were rendered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Pixels.
    pub pixels: u64,
    /// Pixels whose estimate is exact or as good as was asked for.
    pub promise_met: u64,
    /// Pixels that ran out of budget.
    pub budget_hit: u64,
    /// Pixels of which too much light cannot be found.
    pub not_found: u64,
    /// Terms of sums that were looked at, or paths.
    pub pairs: u64,
    /// Rays and segments traced.
    pub rays: u64,
    /// Mean radiance (W·m⁻²·sr⁻¹).
    pub mean: Rgb,
}

/// A film and how it came to be.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The planes; pixels that were not rendered are zero and say so in `stop`.
    pub film: Film,
    /// Whether every pixel that was asked for was rendered.
    pub complete: bool,
    /// Sums over the rendered pixels.
    pub totals: Totals,
}

const PLANES: &[PlaneSpec] = &[
    plane("", &["R", "G", "B"], "W·m⁻²·sr⁻¹", SampleKind::F32, "estimated radiance, linear Rec. 709"),
    plane(
        "standard_error",
        &["Y"],
        "W·m⁻²·sr⁻¹",
        SampleKind::F32,
        "standard error of the luminance, 0 if exact",
    ),
    plane(
        "half_width",
        &["Y"],
        "W·m⁻²·sr⁻¹",
        SampleKind::F32,
        "half-width of the interval that is claimed for the luminance, 0 if exact or nothing is claimed",
    ),
    plane(
        "half_width_parts",
        &["clustering", "lights", "compensation"],
        "W·m⁻²·sr⁻¹",
        SampleKind::F32,
        "what the half-width would be if one source of error were all: few terms drawn, few VPLs, few paths of what VPLs do not carry",
    ),
    plane(
        "claim",
        &["id"],
        "1",
        SampleKind::U32,
        "what is claimed: 0 nothing, 1 exact, 2 published, 3 calibrated, 4 certified",
    ),
    plane(
        "stop",
        &["id"],
        "1",
        SampleKind::U32,
        "why work ended: 0 not rendered, 1 complete, 2 sample count, 3 rule met, 4 budget, 5 light not found",
    ),
    plane("pairs", &["n"], "1", SampleKind::F32, "terms of the sum that were looked at, or paths"),
    plane("rays", &["n"], "1", SampleKind::F32, "rays and segments traced"),
    plane("depth", &["Z"], "m", SampleKind::F32, "mean distance to the first surface, 0 where there is none"),
    plane(
        "normal",
        &["X", "Y", "Z"],
        "1",
        SampleKind::F32,
        "mean shading normal of the first surface, world",
    ),
    plane(
        "albedo",
        &["R", "G", "B"],
        "1",
        SampleKind::F32,
        "mean rough reflectance of the surface that gathers",
    ),
    plane("coverage", &["A"], "1", SampleKind::F32, "share of camera samples that met a surface"),
];

const fn plane(
    name: &'static str,
    channels: &'static [&'static str],
    unit: &'static str,
    kind: SampleKind,
    doc: &'static str,
) -> PlaneSpec {
    PlaneSpec { name, channels, unit, kind, doc }
}

/// Runs `work` on a pool of that many threads; zero is one a core.
///
/// # Errors
/// If the system gives no threads, or more are asked for than make sense.
pub fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> Result<T> {
    const MOST: usize = 4096;
    if threads > MOST {
        return Err(Error::option("threads", threads, format!("0 (one a core) to {MOST}")));
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| Error::option("threads", threads, format!("a number that the system allows ({e})")))?;
    Ok(pool.install(work))
}

/// Tiles of a render that are finished already.
#[derive(Clone, Debug)]
pub struct Begun {
    /// A film like [`blank`]'s, with these tiles.
    pub film: Film,
    /// The tiles, whole.
    pub tiles: Vec<Window>,
}

/// The film with which a render begins: zeros, and everything that it is a function of. For a share
/// of more than 16 it is for the part of the window that the share has tiles in; the metadata
/// `window` says what the window is.
///
/// # Errors
/// A window outside the image, unusable gather options.
pub fn blank(setting: &Setting<'_>, integrator: &dyn Integrator, options: &RenderOptions) -> Result<Film> {
    setting.view.gather.validate()?;
    Film::check(setting.view.size, options.window)?;
    let part = options.share.part(&options.window, setting.view.gather.points);
    let mut film = Film::new(setting.view.size, part, PLANES)?;
    film.metadata_mut().set("tiles", options.share.to_string());
    film.metadata_mut().set("window", options.window.to_string());
    describe(setting, integrator, &mut film);
    Ok(film)
}

/// Renders on the current thread pool.
///
/// `watch` is called after each tile, from any thread, one call at a time; other threads wait with
/// their tiles meanwhile. When `cancel` becomes true no further tile is begun; the film then holds
/// what is finished.
///
/// # Errors
/// A window outside the image, unusable gather options.
pub fn render(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    options: &RenderOptions,
    watch: &(dyn Fn(&Finished<'_>) + Sync),
    cancel: &AtomicBool,
) -> Result<Rendered> {
    let film = blank(setting, integrator, options)?;
    resume(setting, integrator, options, Begun { film, tiles: Vec::new() }, watch, cancel)
}

/// Goes on with a render of which some tiles are finished; `watch` is called for these first. The
/// film is the one that [`render`] gives.
///
/// Tiles of `begun` that are none of this render's are rendered again.
///
/// # Errors
/// As [`render`].
pub fn resume(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    options: &RenderOptions,
    begun: Begun,
    watch: &(dyn Fn(&Finished<'_>) + Sync),
    cancel: &AtomicBool,
) -> Result<Rendered> {
    setting.view.gather.validate()?;
    let tiles = options.share.tiles(&options.window, setting.view.gather.points);
    Ok(render_tiles(setting, integrator, begun, &tiles, watch, cancel))
}

/// Renders only these pixels, into a film of the whole image; each estimate is the one that
/// [`render`] gives.
///
/// `progress` and `cancel` as there, with a pixel for a tile.
///
/// # Errors
/// A pixel outside the image or named twice, unusable gather options.
pub fn render_pixels(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    pixels: &[[u32; 2]],
    progress: &(dyn Fn(&Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<Rendered> {
    setting.view.gather.validate()?;
    let size = setting.view.size;
    let mut film = Film::new(size, Window::full(size), PLANES)?;
    let mut sorted = pixels.to_vec();
    sorted.sort_unstable();
    let outside = sorted.iter().find(|[x, y]| !film.window().contains(*x, *y));
    let twice = sorted.windows(2).find(|two| two[0] == two[1]).map(|two| &two[0]);
    if let Some([x, y]) = outside.or(twice) {
        let [width, height] = size;
        let expected = format!("pixels of the image of {width}x{height}, each once");
        return Err(Error::option("pixels", format!("{x},{y}"), expected));
    }
    film.metadata_mut().set("pixels", pixels.len() as u64);
    describe(setting, integrator, &mut film);
    let tiles: Vec<Window> = pixels.iter().map(|&[x, y]| Window { x, y, width: 1, height: 1 }).collect();
    let begun = Begun { film, tiles: Vec::new() };
    Ok(render_tiles(setting, integrator, begun, &tiles, &|done| progress(&done.progress), cancel))
}

/// What the threads write to.
struct Shared {
    film: Film,
    progress: Progress,
    totals: Totals,
    sum: RgbSum,
}

impl Shared {
    /// Counts a pixel that is finished.
    fn count(&mut self, claims: bool, stop: u32, pairs: u64, rays: u64) {
        self.totals.pixels += 1;
        let out_of_budget = stop == StopReason::Budget.id();
        let keeps = claims && !out_of_budget;
        self.totals.promise_met += u64::from(keeps);
        self.totals.budget_hit += u64::from(out_of_budget);
        self.totals.not_found += u64::from(stop == StopReason::NotFound.id());
        self.totals.pairs += pairs;
        self.totals.rays += rays;
        self.progress.pixels += 1;
        self.progress.promise_met += u64::from(keeps);
        self.progress.rays += rays;
    }

    /// Counts a tile that the film has already; its colours are summed.
    fn count_finished(&mut self, tile: &Window) -> RgbSum {
        let mut sum = RgbSum::default();
        for (x, y) in tile.pixels() {
            let code = |name: &str| self.film.plane(name).map_or(0, |p| p.u32_at(x, y)[0]);
            let number = |name: &str| self.film.plane(name).map_or(0.0, |p| p.f32_at(x, y)[0]) as u64;
            let (claim, stop) = (code("claim"), code("stop"));
            let (pairs, rays) = (number("pairs"), number("rays"));
            let color = self.film.plane("").expect("the film was made from PLANES").f32_at(x, y);
            sum.add(Rgb::new(color[0], color[1], color[2]));
            self.count(claim != ErrorClaim::None.id(), stop, pairs, rays);
        }
        sum
    }
}

fn render_tiles(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    begun: Begun,
    tiles: &[Window],
    watch: &(dyn Fn(&Finished<'_>) + Sync),
    cancel: &AtomicBool,
) -> Rendered {
    let of = tiles.iter().map(Window::area).sum();
    let mut shared = Shared {
        film: begun.film,
        progress: Progress { of, ..Progress::default() },
        totals: Totals::default(),
        sum: RgbSum::default(),
    };
    let place = |tile: &Window| (tile.y, tile.x, tile.height, tile.width);
    let known: BTreeSet<_> = begun.tiles.iter().map(place).collect();
    let finished: Vec<Option<RgbSum>> = tiles
        .iter()
        .map(|tile| {
            let sum = known.contains(&place(tile)).then(|| shared.count_finished(tile))?;
            watch(&Finished { progress: shared.progress, film: &shared.film, tile: *tile });
            Some(sum)
        })
        .collect();
    let shared = Mutex::new(shared);
    let sums: Vec<Option<RgbSum>> = tiles
        .par_iter()
        .zip(finished)
        .map(|(tile, finished)| {
            if finished.is_some() || cancel.load(Ordering::Relaxed) {
                return finished;
            }
            let estimates = integrator.estimate(setting, tile);
            let mut sum = RgbSum::default();
            let mut shared = shared.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            for ((x, y), e) in tile.pixels().zip(&estimates) {
                store(&mut shared.film, x, y, e);
                sum.add(e.radiance);
                shared.count(e.claim != ErrorClaim::None, e.stop.id(), e.pairs, e.rays);
            }
            watch(&Finished { progress: shared.progress, film: &shared.film, tile: *tile });
            Some(sum)
        })
        .collect();
    let Shared { mut film, mut totals, mut sum, .. } =
        shared.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    // In the order of the tiles: the sum must not depend on which thread was faster.
    for s in sums.iter().flatten() {
        sum.merge(s);
    }
    totals.mean = if totals.pixels > 0 {
        let n = totals.pixels as f64;
        let [r, g, b] = sum.channels().map(|c| (c / n) as f32);
        Rgb::new(r, g, b)
    } else {
        Rgb::BLACK
    };
    let complete = sums.iter().all(Option::is_some);
    film.metadata_mut().set("complete", complete);
    Rendered { film, complete, totals }
}

/// Everything that the film is a function of, as far as this layer knows it.
fn describe(setting: &Setting<'_>, integrator: &dyn Integrator, film: &mut Film) {
    let m = film.metadata_mut();
    m.set("version", env!("CARGO_PKG_VERSION"));
    m.set("scene", setting.tracer.scene().name());
    if let Some(digest) = setting.tracer.scene().digest() {
        m.set("scene.digest", format!("{digest:016x}"));
    }
    let scene = setting.tracer.scene();
    if !scene.changes().is_empty() {
        m.set("scene.changes", scene.changes().join("; "));
    }
    if scene.has_default_light() {
        m.set("scene.light", "default");
    }
    m.set("camera", setting.view.camera.name.as_str());
    m.set("method", integrator.name());
    m.set("seed", setting.view.seed);
    m.set("gather.points", setting.view.gather.points);
    m.set("gather.filter", setting.view.gather.filter.name());
    integrator.describe(m);
}

fn store(film: &mut Film, x: u32, y: u32, e: &PixelEstimate) {
    let f = &e.features;
    // In the order of PLANES.
    let [color, error, half_width, half_widths, claim, stop, pairs, rays, depth, normal, albedo, coverage] =
        film.planes_mut()
    else {
        unreachable!("the film was made from PLANES")
    };
    color.set_f32(x, y, &e.radiance.to_array());
    error.set_f32(x, y, &[e.standard_error]);
    half_width.set_f32(x, y, &[e.claim.half_width()]);
    let parts = e.half_widths;
    half_widths.set_f32(x, y, &[parts.clustering, parts.lights, parts.compensation]);
    claim.set_u32(x, y, &[e.claim.id()]);
    stop.set_u32(x, y, &[e.stop.id()]);
    pairs.set_f32(x, y, &[e.pairs as f32]);
    rays.set_f32(x, y, &[e.rays as f32]);
    depth.set_f32(x, y, &[f.depth]);
    normal.set_f32(x, y, &f.normal.to_array());
    albedo.set_f32(x, y, &f.albedo.to_array());
    coverage.set_f32(x, y, &[f.coverage]);
}
