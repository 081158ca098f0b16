//! From a setting and an integrator to a film: tiles or chosen pixels, threads, progress, cancellation.
//!
//! Tiles are independent and the estimate of a pixel depends on neither, so films are equal bit by bit for any number of threads,
//! any window and any share of the tiles.

mod tiles;

#[cfg(test)]
mod tests;

pub use tiles::TileShare;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::color::{Rgb, RgbSum};
use crate::error::{Error, Result};
use crate::film::{Film, PlaneSpec, SampleKind, Window};
use crate::integrator::{ErrorClaim, Integrator, PixelEstimate, Setting, StopReason};

/// What is rendered of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderOptions {
    /// The part of the image.
    pub window: Window,
    /// The share of its tiles.
    pub share: TileShare,
}

/// How far a render is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Pixels finished.
    pub pixels: u64,
    /// Pixels to do in all.
    pub of: u64,
    /// Of the finished pixels, those whose estimate is exact or keeps what it claims.
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
    /// Pixels whose estimate is exact or keeps what it claims.
    pub promise_met: u64,
    /// Pixels that ran out of budget.
    pub budget_hit: u64,
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
        "why work ended: 0 not rendered, 1 complete, 2 sample count, 3 rule met, 4 budget",
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

/// Renders on the current thread pool.
///
/// `watch` is called after each tile, from any thread, one call at a time; other threads wait with their tiles meanwhile. When
/// `cancel` becomes true no further tile is begun; the film then holds what is finished.
///
/// # Errors
/// A window outside the image, a share out of range, unusable gather options.
pub fn render(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    options: &RenderOptions,
    watch: &(dyn Fn(&Finished<'_>) + Sync),
    cancel: &AtomicBool,
) -> Result<Rendered> {
    setting.view.gather.validate()?;
    let mut film = Film::new(setting.view.size, options.window, PLANES)?;
    let tiles = options.share.tiles(&options.window, setting.view.gather.points)?;
    film.metadata_mut().set("tiles", options.share.to_string());
    Ok(render_tiles(setting, integrator, film, &tiles, watch, cancel))
}

/// Renders only these pixels, into a film of the whole image; each estimate is the one that [`render`] gives.
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
    let tiles: Vec<Window> = pixels.iter().map(|&[x, y]| Window { x, y, width: 1, height: 1 }).collect();
    Ok(render_tiles(setting, integrator, film, &tiles, &|done| progress(&done.progress), cancel))
}

/// What the threads write to.
struct Shared {
    film: Film,
    progress: Progress,
    totals: Totals,
    sum: RgbSum,
}

fn render_tiles(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    mut film: Film,
    tiles: &[Window],
    watch: &(dyn Fn(&Finished<'_>) + Sync),
    cancel: &AtomicBool,
) -> Rendered {
    let of = tiles.iter().map(Window::area).sum();
    describe(setting, integrator, &mut film);
    let shared = Mutex::new(Shared {
        film,
        progress: Progress { of, ..Progress::default() },
        totals: Totals::default(),
        sum: RgbSum::default(),
    });
    let sums: Vec<Option<RgbSum>> = tiles
        .par_iter()
        .map(|tile| {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let estimates = integrator.estimate(setting, tile);
            let mut sum = RgbSum::default();
            let mut shared = shared.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            for ((x, y), e) in tile.pixels().zip(&estimates) {
                store(&mut shared.film, x, y, e);
                sum.add(e.radiance);
                let t = &mut shared.totals;
                t.pixels += 1;
                let kept = u64::from(e.claim != ErrorClaim::None);
                t.promise_met += kept;
                t.budget_hit += u64::from(e.stop == StopReason::Budget);
                t.pairs += e.pairs;
                t.rays += e.rays;
                shared.progress.pixels += 1;
                shared.progress.promise_met += kept;
                shared.progress.rays += e.rays;
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
    m.set("camera", setting.view.camera.name.as_str());
    m.set("method", integrator.name());
    m.set("seed", setting.view.seed);
    m.set("gather.points", setting.view.gather.points);
    m.set("gather.filter", format!("{:?}", setting.view.gather.filter).to_lowercase());
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
