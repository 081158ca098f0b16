//! `Camera` and `Film`.
//!
//! The current transform is world to camera, with `+z` forward, `+y` up and `+x` right, so that
//!
//! ```text
//! to_world = C⁻¹ · diag(1, 1, −1)
//! ```
//!
//! for a camera that looks along `−z`. A reflection in `C` is intended and kept. `fov` is the angle
//! along the shorter side of the image. The screen window is `[x₀, x₁] × [y₀, y₁]`; by default it
//! spans `±1` along the shorter side, and the other side follows from the image's proportions. With
//! `t = tan(fov / 2)`:
//!
//! ```text
//! vertical_fov = 2 atan(t (y₁ − y₀)/2),   shift = ((x₀ + x₁)/2 / (x₁ − x₀), (y₀ + y₁)/2 / (y₁ − y₀))
//! ```
//!
//! At the fraction `u` of the image from the left and `v` from the top, `environment` of pbrt-v3
//! and `spherical` of pbrt-v4 look along
//!
//! ```text
//! (sin θ cos φ, cos θ, sin θ sin φ)   θ = π v, φ = 2π u        mapping "equirectangular", and v3
//! (x, z, y)                           (x, y, z) the octahedral  mapping "equalarea", v4's own
//!                                     direction of (u, v)       choice
//! ```
//!
//! in the frame of `C`. The equirectangular mapping looks along `+x` at `u = 0`, ahead at `u = 1/4`
//! and to the left at `u = 1/2`: compared with a perspective view it is mirrored. It becomes a
//! [`Projection::Spherical`] whose axes are `(−z, y, x)` in terms of the axes of a perspective
//! camera. The equal-area mapping becomes the equal-area projection, without a change of axes. Both
//! cover the whole film and ignore `fov` and `screenwindow`, as pbrt does.
//!
//! A camera whose transform moves is blurred while its shutter is open, from `shutteropen` (0) to
//! `shutterclose` (1 s), unless another time is requested.
//!
//! A film's sensor, ISO and exposure are ignored: the output has an exposure of its own.
//!
//! Source: Pharr et al. 2023, sections 5.2 and 5.4. Tested by `suite::pbrt::cameras_*`.

use glam::{DAffine3, DMat3, DVec3, Vec2};

use super::loading::Loading;
use super::parameters::Parameters;
use super::version::Version;
use crate::error::Result;
use crate::film::Window;
use crate::math::elementary::{atan2, tan};
use crate::math::motion::Track;
use crate::scene::{Camera, Lens, MediumId, NoteKind, Projection, SphereMap};

/// Range that fields of view are clamped to (degrees).
const FOV: (f32, f32) = (0.01, 179.0);

/// Field of view assumed for lens systems (degrees); chosen.
const REALISTIC_FOV: f32 = 45.0;

/// Largest side of an image that a file may request (pixels).
const MAX_SIDE: i32 = 1 << 16;

/// Relative difference between the aspect ratios of screen window and image up to which none is
/// noted.
const TOLERANCE: f32 = 1e-3;

/// Default times at which the shutter opens and closes (s).
pub(super) const SHUTTER: [f64; 2] = [0.0, 1.0];

/// Times at which a camera's shutter opens and closes (s), from its parameters.
pub(super) fn shutter(p: &Parameters) -> [f64; 2] {
    let [open, close] = [("shutteropen", SHUTTER[0]), ("shutterclose", SHUTTER[1])]
        .map(|(name, own)| p.float(name).map_or(own, f64::from));
    [open.min(close), open.max(close)]
}

/// Pose, motion and medium of a camera.
#[derive(Clone, Debug)]
pub(super) struct Stand {
    /// Camera to world.
    pub(super) pose: DAffine3,
    /// Inverse of the file's transform at all times, if it moves.
    pub(super) track: Option<Track>,
    /// Medium that the camera stands in.
    pub(super) medium: Option<MediumId>,
}

/// Resolution and crop of a `Film`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Film {
    resolution: [u32; 2],
    crop: Option<Window>,
}

impl Film {
    /// Film of a scene that names none.
    pub(super) fn new(version: Version) -> Self {
        let resolution = if version == Version::V3 { [640, 480] } else { [1280, 720] };
        Self { resolution, crop: None }
    }

    /// Reads `Film class`.
    pub(super) fn read(loading: &mut Loading<'_>, class: &str, p: &Parameters) -> Result<Self> {
        loading.met("film", class, "taken as an image", &p.at())?;
        let mut film = Self::new(loading.version);
        for (side, name) in film.resolution.iter_mut().zip(["xresolution", "yresolution"]) {
            let Some(value) = p.integer(name) else { continue };
            if !(1..=MAX_SIDE).contains(&value) {
                let message = format!("{name} outside 1 to {MAX_SIDE}: the nearer end");
                loading.note(NoteKind::Repaired, message, p.at());
            }
            *side = value.clamp(1, MAX_SIDE) as u32;
        }
        film.crop = film.crop(loading, p);
        p.accept(&["filename", "diagonal", "savefp16", "coordinatesystem"]);
        if p.string("sensor").is_some_and(|sensor| sensor != "cie1931") {
            loading.note(NoteKind::Ignored, "sensors of films: linear light", p.at());
        }
        for (name, default) in [("iso", 100.0), ("exposuretime", 1.0), ("whitebalance", 0.0)] {
            if p.float(name).is_some_and(|value| value != default) {
                let message = format!("{name} of films: left to the picture's exposure");
                loading.note(NoteKind::Ignored, message, p.at());
            }
        }
        for (name, default) in
            [("scale", 1.0), ("maxsampleluminance", f32::MAX), ("maxcomponentvalue", f32::MAX)]
        {
            if p.float(name).is_some_and(|value| value != default && value.is_finite() && value < 1e30) {
                loading.note(NoteKind::Ignored, format!("{name} of films: left out"), p.at());
            }
        }
        loading.note_unused("film", class, p)?;
        Ok(film)
    }

    /// Camera that exposes this film.
    fn camera(&self, pose: DAffine3, projection: Projection) -> Camera {
        let resolution = Some(self.resolution);
        Camera { resolution, crop: self.crop, ..Camera::new("camera", pose.as_affine3a(), projection) }
    }

    /// Reads the crop window. It is given in fractions of the image, which are rounded up to whole
    /// pixels as in pbrt, or in pixels.
    fn crop(&self, loading: &mut Loading<'_>, p: &Parameters) -> Option<Window> {
        let [width, height] = self.resolution;
        let (x, y) = if let Some(&[x0, x1, y0, y1]) = p.integers("pixelbounds") {
            let part = |a: i32, b: i32, size: u32| {
                let inside = |v: i32| u32::try_from(v).unwrap_or(0).min(size);
                [inside(a.min(b)), inside(a.max(b))]
            };
            (part(x0, x1, width), part(y0, y1, height))
        } else {
            let &[x0, x1, y0, y1] = p.floats("cropwindow")? else { return None };
            let part = |a: f32, b: f32, size: u32| {
                let inside = |v: f32| ((size as f32 * v.clamp(0.0, 1.0)).ceil() as u32).min(size);
                [inside(a.min(b)), inside(a.max(b))]
            };
            (part(x0, x1, width), part(y0, y1, height))
        };
        let crop = Window { x: x[0], y: y[0], width: x[1] - x[0], height: y[1] - y[0] };
        if crop.width == 0 || crop.height == 0 {
            loading.note(NoteKind::Repaired, "crops without pixels: the whole image", p.at());
            return None;
        }
        (crop != Window { x: 0, y: 0, width, height }).then_some(crop)
    }
}

/// Pose of a camera, from the inverse of the current transform, `C⁻¹`; none if `C⁻¹` is singular.
pub(super) fn to_world(inverse: &DAffine3) -> Option<DAffine3> {
    let mirrored = DMat3::from_cols(inverse.matrix3.x_axis, inverse.matrix3.y_axis, -inverse.matrix3.z_axis);
    let pose = DAffine3 { matrix3: mirrored, translation: inverse.translation };
    let rounded = pose.as_affine3a();
    (rounded.is_finite() && rounded.matrix3.determinant() != 0.0).then_some(pose)
}

/// Adds `Camera class`, with the pose and the motion of `stand` and the size of `film`.
pub(super) fn add(
    loading: &mut Loading<'_>,
    class: &str,
    p: &Parameters,
    stand: &Stand,
    film: &Film,
) -> Result<()> {
    loading.met("camera", class, "perspective", &p.at())?;
    if matches!(class, "environment" | "spherical") {
        return add_spherical(loading, class, p, stand, film);
    }
    let [width, height] = film.resolution.map(|side| side as f32);
    let aspect = p.float("frameaspectratio").filter(|a| *a > 0.0).unwrap_or(width / height);
    let mut screen =
        if aspect > 1.0 { [-aspect, aspect, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect] };
    if let Some(&[x0, x1, y0, y1]) = p.floats("screenwindow") {
        if x0 < x1 && y0 < y1 {
            screen = [x0, x1, y0, y1];
        } else {
            loading.note(NoteKind::Repaired, "screen windows without area: the whole screen", p.at());
        }
    }
    let [x0, x1, y0, y1] = screen;
    let size = Vec2::new(x1 - x0, y1 - y0);
    if (size.x / size.y / (width / height) - 1.0).abs() > TOLERANCE {
        let message = "screens of other proportions than the image: square pixels, by the height";
        loading.note(NoteKind::Approximated, message, p.at());
    }
    let given = match p.float("halffov") {
        Some(half) => 2.0 * half,
        None => p.float("fov").unwrap_or(90.0),
    };
    let (projection, lens) = match class {
        "orthographic" => (Projection::Orthographic { height: size.y }, lens(p)),
        "realistic" => {
            p.accept_known();
            let height = size.y / size.x.min(size.y) * 2.0;
            (perspective(loading, p, REALISTIC_FOV, height), Lens::PINHOLE)
        }
        _ => (perspective(loading, p, given, size.y), lens(p)),
    };
    p.accept(&["hither", "yon"]);
    let shift = Vec2::new(0.5 * (x0 + x1), 0.5 * (y0 + y1)) / size;
    let camera = Camera { shift, lens, medium: stand.medium, ..film.camera(stand.pose, projection) };
    let camera = exposed(loading, p, camera, stand, DAffine3::IDENTITY);
    loading.note_unused("camera", class, p)?;
    loading.builder.add_camera_at(camera, stand.pose)
}

/// Adds a camera that sees all directions.
fn add_spherical(
    loading: &mut Loading<'_>,
    class: &str,
    p: &Parameters,
    stand: &Stand,
    film: &Film,
) -> Result<()> {
    // pbrt accepts these parameters and ignores them.
    p.accept(&["hither", "yon"]);
    p.accept(&["lensradius", "focaldistance", "frameaspectratio", "screenwindow", "fov", "halffov"]);
    let map = match (class, p.string("mapping")) {
        ("environment", _) | (_, Some("equirectangular" | "equirect")) => SphereMap::LatLong,
        (_, None | Some("equalarea" | "equiarea")) => SphereMap::EqualArea,
        (_, Some(other)) => {
            let message =
                format!("mapping {other:?} is unknown, there are equalarea and equirectangular: equalarea");
            loading.note(NoteKind::Repaired, message, p.at());
            SphereMap::EqualArea
        }
    };
    let axes = match map {
        SphereMap::LatLong => DAffine3::from_mat3(DMat3::from_cols(DVec3::Z, DVec3::Y, DVec3::X)),
        SphereMap::EqualArea => DAffine3::IDENTITY,
    };
    let to_world = stand.pose * axes;
    let camera = Camera { medium: stand.medium, ..film.camera(to_world, Projection::Spherical { map }) };
    let camera = exposed(loading, p, camera, stand, axes);
    loading.note_unused("camera", class, p)?;
    loading.builder.add_camera_at(camera, to_world)
}

/// Sets the motion of a camera while its shutter is open. The shutter times are those that the user
/// requests, or else those in the file. `axes` are the camera's axes relative to those of a
/// perspective camera.
fn exposed(
    loading: &mut Loading<'_>,
    p: &Parameters,
    camera: Camera,
    stand: &Stand,
    axes: DAffine3,
) -> Camera {
    if let (Some(open), Some(close)) = (p.float("shutteropen"), p.float("shutterclose"))
        && open > close
    {
        let message = "shutters that close before they open: the other way around";
        loading.note(NoteKind::Repaired, message, p.at());
    }
    let shutter = shutter(p);
    let Some(track) = &stand.track else { return camera };
    let options = loading.files.options();
    let mirror = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
    match (options.exposure(Some(shutter)), track.after(mirror * axes)) {
        (Some(shutter), Some(track)) if track.keeps_sides() => camera.moving(track, shutter),
        (Some(_), _) => {
            let message = "cameras that turn into their mirror image: where they are in the middle";
            loading.note(NoteKind::Approximated, message, p.at());
            camera
        }
        (None, _) => {
            if options.at.is_none() {
                loading.note(NoteKind::Approximated, "cameras that move: where they are first", p.at());
            }
            camera
        }
    }
}

/// Perspective projection in which the interval `±1` of the screen window subtends `fov` degrees.
/// `height` is the height of the screen window.
fn perspective(loading: &mut Loading<'_>, p: &Parameters, fov: f32, height: f32) -> Projection {
    if !(FOV.0..=FOV.1).contains(&fov) {
        loading.note(NoteKind::Repaired, "fields of view outside 0° to 180°: the nearer end", p.at());
    }
    let half = tan(0.5 * fov.clamp(FOV.0, FOV.1).to_radians());
    let vertical_fov = 2.0 * atan2(half * 0.5 * height, 1.0);
    Projection::Perspective { vertical_fov: vertical_fov.clamp(FOV.0.to_radians(), FOV.1.to_radians()) }
}

fn lens(p: &Parameters) -> Lens {
    let radius = p.float("lensradius").unwrap_or(0.0).max(0.0);
    let focus_distance = p.float("focaldistance").filter(|d| *d > 0.0).unwrap_or(1e6);
    if radius > 0.0 { Lens::round(radius, focus_distance) } else { Lens::PINHOLE }
}
