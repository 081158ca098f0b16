//! From a setting and an integrator to a film: tiles or chosen pixels, threads, progress,
//! cancellation.
//!
//! The estimate of a pixel does not depend on its tile or on threads. Films are therefore equal,
//! bit by bit, for any number of threads, any window and any share of the tiles.

mod fill;
mod first_surfaces;
mod mattes;
mod merge;
mod pictures;
mod tiles;

#[cfg(test)]
mod tests;

pub use first_surfaces::{add_motion, add_time, add_transmittance};
pub use mattes::add_mattes;
pub use merge::{Merged, Merger};
pub use pictures::{begin_pictures, picture_tiles, resume_pictures};
pub use tiles::TileShare;

use std::sync::atomic::AtomicBool;

use crate::color::{Rgb, RgbSum};
use crate::error::{Error, Result};
use crate::film::{Film, PixelRecord, Plane, RenderFilm, Samples, Stop, Tally, Window, keys, planes};
use crate::integrator::{Integrator, PlaneBeside, Setting};
use fill::fill;

/// Part of an image that is rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Window of the image (pixels).
    pub window: Window,
    /// Shares of the window's tiles.
    pub share: TileShare,
}

/// Finished pixels of a render, and the work for them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Finished pixels, by claim.
    pub tally: Tally,
    /// Number of all pixels to render.
    pub of: u64,
    /// Number of rays and segments traced for the finished pixels.
    pub rays: u64,
}

/// Report of a tile that was just finished.
#[derive(Clone, Copy, Debug)]
pub struct Finished<'a> {
    /// State of the render after this tile.
    pub progress: Progress,
    /// Film of the render; pixels of unfinished tiles are zero.
    pub film: &'a Film,
    /// Window of the finished tile (pixels).
    pub tile: Window,
}

/// Sums over the rendered pixels of a film.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Rendered pixels, by claim.
    pub tally: Tally,
    /// Sum of the plane [`PAIRS`](crate::film::planes::PAIRS).
    pub pairs: u64,
    /// Sum of the plane [`RAYS`](crate::film::planes::RAYS).
    pub rays: u64,
    /// Mean radiance of the finite pixels (W·m⁻²·sr⁻¹).
    pub mean: Rgb,
}

impl Totals {
    /// Returns the totals of a film.
    pub fn of(film: &Film) -> Self {
        let (read, mut totals, mut sum) = (RenderFilm::of(film), Self::default(), RgbSum::default());
        for (x, y) in film.window().pixels() {
            let record = read.at(x, y);
            add_finite(&mut sum, &record);
            totals.tally.count(record.claim, record.stop);
            totals.pairs += record.pairs;
            totals.rays += record.rays;
        }
        Self { mean: mean(&sum, &totals.tally), ..totals }
    }
}

/// Adds the radiance of a pixel to a sum, if it is finite.
fn add_finite(sum: &mut RgbSum, record: &PixelRecord) {
    if record.stop != Stop::NotFinite {
        sum.add(record.radiance);
    }
}

/// Returns the mean of a sum over the finite pixels of a tally; black if there are none.
fn mean(sum: &RgbSum, tally: &Tally) -> Rgb {
    let pixels = tally.rendered() - tally.not_finite;
    if pixels == 0 {
        return Rgb::BLACK;
    }
    let [r, g, b] = sum.channels().map(|channel| (channel / pixels as f64) as f32);
    Rgb::new(r, g, b)
}

/// Result of a render.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// Planes ([`PixelRecord::PLANES`]) of the render; pixels that were not rendered are zero, also
    /// in the plane `stop`.
    pub film: Film,
    /// True if every requested pixel was rendered.
    pub complete: bool,
    /// Sums over the rendered pixels.
    pub totals: Totals,
}

/// Runs `work` on a pool of `threads` threads; 0 stands for one thread per core.
///
/// # Errors
/// If more than 4096 threads are requested, or the system does not grant them.
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

/// Render that has begun: its film, and the tiles that are finished.
#[derive(Clone, Debug)]
pub struct Begun {
    /// Film as [`blank`] makes it, with the finished tiles.
    pub film: Film,
    /// Windows of the finished tiles, each complete.
    pub tiles: Vec<Window>,
}

/// Returns the film with which a render begins: pixels of zero, and all inputs of the film as
/// metadata. If there are more than 16 shares, the film covers only the part of the window that
/// contains the share's tiles; the metadata `window` has the whole window.
///
/// # Errors
/// A window outside the image, unusable gather options, media where the integrator renders none.
pub fn blank(setting: &Setting<'_>, integrator: &dyn Integrator, options: &RenderOptions) -> Result<Film> {
    begin(setting, integrator, options, setting.view.points_of_tiles())
}

/// Returns the film with which a render begins, for tiles of `points` gather points a pixel.
fn begin(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    options: &RenderOptions,
    points: u32,
) -> Result<Film> {
    check(setting, integrator)?;
    Film::check(setting.view.size, options.window)?;
    let part = options.share.part(&options.window, points);
    let mut film = Film::new(setting.view.size, part, PixelRecord::PLANES)?;
    for PlaneBeside { name, channels, doc } in integrator.planes_beside() {
        let samples = Samples::F32(vec![0.0; part.area() as usize * channels.len()]);
        let words = [name, planes::RADIANCE.unit.to_owned(), doc];
        let channels = channels.iter().map(|&channel| channel.to_owned()).collect();
        film.take_plane(Plane::from_samples(words, channels, part, samples));
    }
    film.metadata_mut().set(keys::TILES, options.share.to_string());
    film.metadata_mut().set(keys::WINDOW, options.window.to_string());
    describe(setting, integrator, &mut film);
    Ok(film)
}

/// Renders on the current thread pool.
///
/// `watch` is called after each tile, from any thread, one call at a time; other threads wait with
/// their tiles meanwhile. When `cancel` becomes true no further tile is begun; the film then holds
/// the finished tiles.
///
/// # Errors
/// A window outside the image, unusable gather options, media where the integrator renders none.
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

/// Continues a render of which some tiles are finished. First, `watch` is called for the finished
/// tiles. The film equals the one that [`render`] returns.
///
/// Pixels of tiles in `begun` that are not tiles of this render are rendered again.
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
    check(setting, integrator)?;
    let tiles = options.share.tiles(&options.window, setting.view.points_of_tiles());
    Ok(render_tiles(setting, integrator, begun, &tiles, watch, cancel))
}

/// Renders only these pixels, into a film of the whole image; each estimate equals that of
/// [`render`].
///
/// `progress` and `cancel` correspond to `watch` and `cancel` of [`render`], with a pixel in place
/// of a tile.
///
/// # Errors
/// A pixel outside the image or named twice, unusable gather options, media where the integrator
/// renders none.
pub fn render_pixels(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    pixels: &[[u32; 2]],
    progress: &(dyn Fn(&Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<Rendered> {
    check(setting, integrator)?;
    let size = setting.view.size;
    let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES)?;
    let mut sorted = pixels.to_vec();
    sorted.sort_unstable();
    let outside = sorted.iter().find(|[x, y]| !film.window().contains(*x, *y));
    let twice = sorted.windows(2).find(|two| two[0] == two[1]).map(|two| &two[0]);
    if let Some([x, y]) = outside.or(twice) {
        let [width, height] = size;
        let expected = format!("pixels of the image of {width}x{height}, each once");
        return Err(Error::option("pixels", format!("{x},{y}"), expected));
    }
    film.metadata_mut().set(keys::PIXELS, pixels.len() as u64);
    describe(setting, integrator, &mut film);
    let tiles: Vec<Window> = pixels.iter().map(|&[x, y]| Window { x, y, width: 1, height: 1 }).collect();
    let begun = Begun { film, tiles: Vec::new() };
    Ok(render_tiles(setting, integrator, begun, &tiles, &|done| progress(&done.progress), cancel))
}

fn render_tiles(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    begun: Begun,
    tiles: &[Window],
    watch: &(dyn Fn(&Finished<'_>) + Sync),
    cancel: &AtomicBool,
) -> Rendered {
    let beside: Vec<PlaneBeside> = integrator.planes_beside();
    let beside: Vec<PlaneBeside> =
        beside.into_iter().filter(|plane| begun.film.plane(&plane.name).is_some()).collect();
    let of_view = integrator.begin(*setting);
    let store = |film: &mut Film, tile: &Window, (records, samples): &(Vec<PixelRecord>, Vec<f32>)| {
        tile.pixels().zip(records).for_each(|((x, y), record)| record.store(film, x, y));
        store_beside(&beside, tile, samples, film);
    };
    fill(begun, tiles, &|tile| Some(of_view.tile_with_beside(tile)), &store, watch, cancel)
}

/// Stores the samples of a tile in the planes that an integrator fills in addition to its records.
fn store_beside(beside: &[PlaneBeside], tile: &Window, mut samples: &[f32], film: &mut Film) {
    if beside.is_empty() {
        return;
    }
    for (x, y) in tile.pixels() {
        for PlaneBeside { name, channels, .. } in beside {
            let (own, rest) = samples.split_at(channels.len());
            film.plane_mut(name).expect("a film of these planes").set_f32(x, y, own);
            samples = rest;
        }
    }
}

/// Checks that an integrator can render the setting.
fn check(setting: &Setting<'_>, integrator: &dyn Integrator) -> Result<()> {
    let scene = setting.tracer.scene();
    setting.view.gather.validate()?;
    scene.check_camera(setting.view.camera)?;
    scene.check_method(integrator.name(), integrator.abilities())
}

/// Stores in the metadata all inputs of the film that this layer knows.
fn describe(setting: &Setting<'_>, integrator: &dyn Integrator, film: &mut Film) {
    let m = film.metadata_mut();
    m.set(keys::VERSION, env!("CARGO_PKG_VERSION"));
    m.set(keys::SCENE, setting.tracer.scene().name());
    if let Some(digest) = setting.tracer.scene().digest() {
        m.set(keys::SCENE_DIGEST, format!("{digest:016x}"));
    }
    let scene = setting.tracer.scene();
    if !scene.changes().is_empty() {
        m.set(keys::SCENE_CHANGES, scene.changes().join("; "));
    }
    if let Some(time) = scene.time() {
        m.set(keys::SCENE_TIME, time);
    }
    if scene.has_default_light() {
        m.set(keys::SCENE_LIGHT, "default");
    }
    m.set(keys::CAMERA, setting.view.camera.name.as_str());
    let of_camera = setting.view.camera.motion.as_ref().map(|motion| motion.shutter);
    if let Some([open, close]) = of_camera.or(scene.shutter()) {
        m.set(keys::CAMERA_SHUTTER, format!("{open},{close}"));
    }
    m.set(keys::METHOD, integrator.name());
    m.set(keys::SEED, setting.view.seed);
    m.set(keys::GATHER_POINTS, setting.view.gather.points);
    m.set(keys::GATHER_FILTER, setting.view.gather.filter.name());
    integrator.describe(m);
}
