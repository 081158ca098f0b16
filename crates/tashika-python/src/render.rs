//! Rendering: `tashika.render`.

use std::ffi::CString;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use tashika::color::Controlled;
use tashika::error::Result;
use tashika::film::{Film, Window};
use tashika::integrator::Truth;
use tashika::io::KeptTiles;
use tashika::render::{Begun, Finished, Progress, TileShare};
use tashika::renderer::{Observer, Renderer};
use tashika::request::{CameraChange, Framing, ProjectionName, Request};
use tashika_oidn::Oidn;

use crate::attended::{Watch, attended};
use crate::denoiser;
use crate::errors::{option, raised};
use crate::image::Image;
use crate::scene::Scene;
use crate::vpls;
use crate::words;

/// Renders an image; other Python threads run meanwhile.
///
/// Arguments, with the defaults of the program `tashika render`, so that the planes are the same
/// bit for bit:
///
/// - `camera`: name, by default the first; `size`: (width, height) in pixels, by default the
///   camera's or (640, 360); `crop`: (x, y, width, height) in pixels from the top left; `tiles`:
///   "K/N" or (K, N), the K-th of N shares of the image; with more than 16 shares, the returned
///   image covers only the part that contains the share (`window`).
/// - `projection`: replaces the camera's: "perspective", "fisheye", "spherical" or "equal-area";
///   `fov` in degrees, of a perspective (vertical) or a fisheye (across its circle); `lens_radius`
///   and `focus_distance` in metres, `blades` and `blade_rotation` (degrees) of a perspective's
///   lens, as in `Camera`.
/// - `method`: "tashika", "exact", "lightcuts", "mdlc", "nabata2016", "sakai2018", "iwasaki2019" or
///   "path".
/// - `error`: relative error allowed in a pixel; each pixel is then rendered until it is within it.
///   Without `error` and `claim`, the picture is audited as a whole (below), within 0.1 and about
///   30 s for 640×360 pixels. With `method` "path", 64 `paths` a pixel are traced. `absolute`:
///   error that suffices in dark pixels (W/m²/sr); by default 0 for a sum, and `error` times a
///   hundredth of the view's mean for light transport. `control`: "luminance" or "channels";
///   `confidence` of the intervals, 0.95; `claim`: "calibrated" (within 0.05) or "certified", or
///   "audited": of the picture as a whole (below); `truth`: "transport" (light in the scene, the
///   default), "vpl" (the sum over one set, the default for certified claims and for a `VplSet`) or
///   "clamped"; `max_pairs`: largest cut of a pixel; with "transport", largest number of pairs and
///   paths.
/// - `vpls`: a `VplSet`, or the number to trace (a million at 0.05, 2.5 million at 0.02; 5000 with
///   `truth` "vpl"); `clamp`: "auto", "off" or metres; `instants`: number of times at which the
///   VPLs sample moving objects (32); `gather`: gather points a pixel (51 at 0.05, 128 at 0.02; 4
///   with `truth` "vpl"); `filter`: "box", "tent", "gaussian" or "blackman-harris", the pixel
///   filter of gather points or paths.
/// - `quality`: "draft" and "good" are audited pictures, within 0.1 and 0.05, "final" has each
///   pixel within 0.02. An audited picture is reconstructed, and the reference values of `audit`
///   (600) of its pixels are computed. The claim is that `share` (0.95) of the pixels are within
///   `error` (0.1), with the confidence `assurance` (0.99); `Image.picture_claim` has the result.
///   Rendering takes about `time` seconds at most; the result is then the claim that was reached.
///   `passes` (1 to 13) instead is a fixed amount of work, whose bits are the same on any machine.
///   Parts (`tiles`) claim nothing; `merge` audits the whole.
/// - `denoiser`: smoother of audited pictures: "own", "oidn" (Open Image Denoise 2, from
///   `pip install tashika[oidn]`, or as named by TASHIKA_OIDN or the system), "auto" (oidn where it
///   is found, else own; the default without `passes` and `tiles`), or the file of that library.
///   With the library, bits may differ between machines.
/// - `cryptomatte`: True, or the number of names that a pixel distinguishes (6), adds the planes
///   "CryptoObject00" and "CryptoMaterial00", "…01", "…02" of Cryptomatte, whose manifests are in
///   the metadata, and "object_id" and "material_id", the numbers of the object and the material
///   that cover most of a pixel.
/// - `motion_vectors`: True adds the plane "motion", the displacement on the film of the visible
///   surface while the shutter is open: pixels to the right, and up. Scenes in motion have the
///   plane "time", the mean time at which the object in front is there. Scenes with media have the
///   plane "transmittance", the transmittance between the first surface and the camera.
/// - `groups`: "each", or {"key": ["lamp", …], …}, names of objects or materials that emit, of
///   lights, or "environment": planes "light_key" with the contribution of each group, and
///   "light_key_standard_error". Lights that are not named are "light_rest". With `method` "path"
///   the planes add up to the radiance; with the default method they are estimated by separate
///   paths, `paths` (64) a pixel, so that their sum differs from the radiance by the errors of
///   both.
/// - `seed` of all random numbers; `threads`: 0 is one a core, the image does not depend on it.
/// - `checkpoint`: a file that stores finished tiles. If it exists from an earlier call with the
///   same arguments, however that call ended, the render continues from it, and the result has the
///   same bits. The file stays: remove it when the image is saved. Damaged tiles cause a warning
///   and are rendered again; the file of another render is an `InputError`.
/// - `progress`: called as `progress(pixels, of, claiming, rays)` about ten times a second. An
///   exception from it ends the render and is raised again, and so is Ctrl-C.
///
/// A scene stores the VPLs of its last render of light transport, for the next one with equal
/// options.
///
/// Raises `OptionError` for values out of range, and for arguments that contradict each other. The
/// default method of scenes with motion or scattering media is path tracing. Arguments that have no
/// effect on the chosen method are ignored, with a warning.
///
/// ```python
/// >>> image = tashika.render(tashika.builtin("tiny"), size=(8, 6), vpls=200)
/// >>> image["radiance"].shape, image.metadata["claim"]
/// ((6, 8, 3), 'audited')
/// ```
#[pyfunction]
#[pyo3(signature = (
    scene, *, camera=None, size=None, crop=None, method="tashika", error=None, confidence=None, claim=None, truth=None,
    vpls=None, gather=None, seed=1, threads=0, max_pairs=None, absolute=None, control=None, tiles=None, clamp=None,
    paths=None, filter=None, checkpoint=None, progress=None, projection=None, fov=None, lens_radius=None,
    focus_distance=None, blades=None, blade_rotation=None, quality=None, share=None, assurance=None, audit=None,
    time=None, denoiser=None, cryptomatte=None, groups=None, motion_vectors=false, instants=None, passes=None
))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub fn render(
    py: Python<'_>,
    scene: &Bound<'_, Scene>,
    camera: Option<&str>,
    size: Option<[u32; 2]>,
    crop: Option<[u32; 4]>,
    method: &str,
    error: Option<f64>,
    confidence: Option<f64>,
    claim: Option<&str>,
    truth: Option<&str>,
    vpls: Option<&Bound<'_, PyAny>>,
    gather: Option<u64>,
    seed: u64,
    threads: usize,
    max_pairs: Option<u64>,
    absolute: Option<f64>,
    control: Option<&str>,
    tiles: Option<&Bound<'_, PyAny>>,
    clamp: Option<&Bound<'_, PyAny>>,
    paths: Option<u64>,
    filter: Option<&str>,
    checkpoint: Option<PathBuf>,
    progress: Option<&Bound<'_, PyAny>>,
    projection: Option<&str>,
    fov: Option<f32>,
    lens_radius: Option<f32>,
    focus_distance: Option<f32>,
    blades: Option<u32>,
    blade_rotation: Option<f32>,
    quality: Option<&str>,
    share: Option<f64>,
    assurance: Option<f64>,
    audit: Option<u64>,
    time: Option<f64>,
    denoiser: Option<PathBuf>,
    cryptomatte: Option<&Bound<'_, PyAny>>,
    groups: Option<&Bound<'_, PyAny>>,
    motion_vectors: bool,
    instants: Option<u64>,
    passes: Option<u64>,
) -> PyResult<Image> {
    let scene = scene.get();
    let (given, of_lights) = vpls::said(vpls, clamp, instants)?;
    let request = Request {
        groups_asked: groups.is_some(),
        method: words::method(method)?,
        claim: claim.map(words::claim).transpose()?,
        truth: truth.map(|name| words::named("truth", name, &Truth::ALL)).transpose()?,
        error,
        control: control.map(|name| words::named("control", name, &Controlled::ALL)).transpose()?,
        absolute,
        confidence,
        max_pairs,
        paths,
        gather,
        filter: filter.map(words::filter).transpose()?,
        seed,
        share,
        assurance,
        audit,
        passes,
        ..of_lights
    };
    let request = match quality.map(words::quality).transpose()? {
        Some(quality) => request.with_quality(quality).map_err(raised)?,
        None => request,
    };
    let projection =
        projection.map(|name| words::named("projection", name, &ProjectionName::ALL)).transpose()?;
    let crop = crop.map(|[x, y, width, height]| Window { x, y, width, height });
    let change = CameraChange { projection, fov, lens_radius, focus_distance, blades, blade_rotation };
    let (camera, framing) = (scene.camera(camera)?, Framing { size, crop });
    // Unusable values are raised before the work begins.
    let framed = framing.of(&change.of(camera).map_err(raised)?).map_err(raised)?;
    let share = tiles.map_or(Ok(TileShare::default()), words::tiles)?;
    let said = [
        ("audit", audit.map(|count| count.to_string())),
        ("time", time.map(|seconds| seconds.to_string())),
        ("denoiser", denoiser.as_ref().map(|name| name.display().to_string())),
    ];
    for (name, value) in said {
        value.map_or(Ok(()), |value| request.check_audited(name, value)).map_err(raised)?;
    }
    let unused = scene.unused(&request).map_err(raised)?;
    let in_scene = scene.in_scene(&request);
    // Errors of the options are raised before the work begins.
    in_scene.plan_for_still_scene().map_err(raised)?;
    let is_audited = request.is_audited();
    if let (true, true, Some(path)) = (is_audited, share.is_whole(), &checkpoint) {
        let expected = "none of a picture that is audited as a whole, which is made in passes; one with an error, or \
                        parts (tiles), can be kept";
        return Err(option("checkpoint", path.display(), expected));
    }
    if let (true, false, Some(seconds)) = (is_audited, share.is_whole(), time) {
        let expected = "none of a part (tiles) of an audited picture, which is a fixed amount of work";
        return Err(option("time", seconds, expected));
    }
    if let Some(seconds) = time.filter(|seconds| !(*seconds > 0.0 && seconds.is_finite())) {
        return Err(option("time", seconds, "seconds, above 0"));
    }
    for name in unused {
        let name = if name == "lights" { "vpls" } else { name };
        let method = in_scene.method;
        warn(
            py,
            &format!("{name} means nothing to method {method}, which this scene needs, and is not used"),
        )?;
    }
    request.check_passes(time.is_some(), share.is_whole()).map_err(raised)?;
    let time = time.or_else(|| request.default_seconds(framed.window.area()).filter(|_| share.is_whole()));
    let is_fixed = passes.is_some() || !share.is_whole();
    let name = denoiser.unwrap_or_else(|| if is_fixed { Oidn::OWN } else { Oidn::AUTO }.into());
    let smoother = if is_audited { denoiser::of(py, &name, threads)? } else { None };
    let mattes = cryptomatte.map(words::ranks).transpose()?.flatten();
    let groups = groups.map(words::groups).transpose()?;
    let given = given.map(|set| set.get().shared());
    let kept = KeptTiles::new(checkpoint);
    let troubles = Mutex::new(Vec::new());
    let trouble = |what| troubles.lock().unwrap_or_else(PoisonError::into_inner).push(what);
    let (film, other_set) = attended(py, threads, progress, |watch| {
        let end = time.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
        let watch = Keeping { watch, kept: &kept, trouble: &trouble, end };
        let renderer = scene.renderer(camera, &request).observer(&watch);
        let renderer = renderer.camera_change(change).framing(framing).tiles(share);
        let renderer = smoother.into_iter().fold(renderer, Renderer::smoother);
        let renderer = mattes.into_iter().fold(renderer, Renderer::mattes);
        let renderer = if motion_vectors { renderer.motion_vectors() } else { renderer };
        let renderer = groups.into_iter().fold(renderer, Renderer::light_groups);
        let prepared = given.into_iter().fold(renderer, Renderer::lights).prepare()?;
        let rendered = prepared.render_from(|film| watch.begin(film))?;
        let other_set = prepared.other_set(&rendered)?;
        Ok((rendered.film, other_set))
    })?;
    for trouble in troubles.into_inner().unwrap_or_else(PoisonError::into_inner) {
        warn(py, &trouble)?;
    }
    Ok(Image::new(film).beside(other_set))
}

fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &CString::new(message)?, 1)
}

/// Watches a render, and stores its finished tiles.
struct Keeping<'a> {
    watch: &'a Watch,
    kept: &'a KeptTiles,
    trouble: &'a (dyn Fn(String) + Sync),
    /// Time at which an audited picture is to be done.
    end: Option<Instant>,
}

impl Keeping<'_> {
    /// Stored tiles that the render of this film continues from.
    fn begin(&self, film: Film) -> Result<Begun> {
        let (begun, damage) = self.kept.begin(film)?;
        if let (Some(path), Some(damage)) = (self.kept.path(), damage) {
            (self.trouble)(format!("{}: {damage}; it was rendered again", path.display()));
        }
        Ok(begun)
    }
}

impl Observer for Keeping<'_> {
    fn tile(&self, done: &Finished<'_>) {
        if let Err(trouble) = self.kept.add(done) {
            (self.trouble)(format!("not all tiles were kept: {trouble}"));
        }
        self.progress(&done.progress);
    }

    fn progress(&self, progress: &Progress) {
        self.watch.tell(progress);
    }

    fn seconds_left(&self) -> Option<f64> {
        self.end.map(|end| end.saturating_duration_since(Instant::now()).as_secs_f64())
    }

    fn cancel(&self) -> &AtomicBool {
        self.watch.cancel()
    }
}
