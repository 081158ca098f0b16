//! Directly visible light, projected onto the image.
//!
//! A lamp that covers a thousandth of a pixel, or the focus of a lens, may outshine all else in the
//! pixel, yet most sets of a hundred camera samples miss it. VPLs that represent the light can be
//! projected onto the pixel instead, and cannot miss it. Let the points `i` in a pixel have the
//! intensity `I_i` and the visibility `V_i`, and let the pixel cover the area `A_i` at the distance
//! of a point, at right angles to the ray. Their luminance is
//!
//! ```text
//! L = Σ_i I_i cos θ_i V_i / A_i
//! ```
//!
//! If a lamp covers many pixels, camera samples meet it and give a more precise estimate. The
//! projection shows where camera samples are too few.
//!
//! # Held to this by
//! The tests below, and the suite's `unseen_lamps` and `caustics`.

use super::paths_for;
use crate::accel::{Glass, Tracer};
use crate::gather::View;
use crate::math::Vec3;
use crate::media::Shadows;
use crate::scene::CameraSample;
use crate::vpl::{LightTracer, Origin, Route, Vpl, VplKind, Way};

/// Maximum number of VPLs from which the account of an image is made.
const MOST_IN_ACCOUNT: usize = 1 << 17;

/// Approximate luminance of directly visible lamps or caustics in each pixel.
#[derive(Clone, Debug)]
pub struct SeenLight {
    /// `Σ L_i` and `Σ L_i²` over the points of a pixel, row by row (W·m⁻²·sr⁻¹ and its square).
    pixels: Vec<[f32; 2]>,
    width: u32,
}

impl SeenLight {
    /// Returns the lamps that the camera sees. Runs on the current thread pool.
    ///
    /// `None` if no lamp is seen, or if the camera has a lens or moves: both blur lamps.
    pub fn lamps(tracing: &LightTracer<'_>, view: &View<'_>, seed: u64) -> Option<Self> {
        Self::of(&tracing.on_emitters(paths_for(view), seed), tracing.tracer(), view)
    }

    /// Returns the light that these VPLs send to the camera. `None` if the camera sees none of
    /// them, has a lens or moves.
    pub(super) fn of(lights: &[Vpl], tracer: &Tracer, view: &View<'_>) -> Option<Self> {
        let [width, height] = view.size;
        let mut pixels = vec![[0.0; 2]; width as usize * height as usize];
        for Seen { pixel, luminance, .. } in project(lights, tracer, view) {
            let [sum, squares] = &mut pixels[pixel];
            *sum += luminance;
            *squares += luminance * luminance;
        }
        pixels.iter().any(|[sum, _]| *sum > 0.0).then_some(Self { pixels, width })
    }

    fn at(&self, pixel: [u32; 2]) -> [f64; 2] {
        self.pixels[pixel[1] as usize * self.width as usize + pixel[0] as usize].map(f64::from)
    }

    /// Returns the approximate luminance in a pixel (W·m⁻²·sr⁻¹).
    pub fn importance_radiance(&self, pixel: [u32; 2]) -> f64 {
        self.at(pixel)[0]
    }

    /// Returns the approximate luminance in a pixel less two standard errors, at least zero
    /// (W·m⁻²·sr⁻¹).
    pub fn importance_least(&self, pixel: [u32; 2]) -> f64 {
        let [sum, squares] = self.at(pixel);
        (sum - 2.0 * squares.sqrt()).max(0.0)
    }
}

/// Account of the light that surfaces in view send to the camera, estimated by light paths alone.
/// Its shares are approximate; emission that the camera sees directly is not included.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightAccount {
    /// Mean luminance of the image without directly visible emission (W·m⁻²·sr⁻¹).
    pub luminance: f64,
    /// Shares of this luminance by [`Way`].
    pub by_way: [f64; Way::COUNT],
    /// Shares of this luminance by [`Origin`].
    pub by_origin: [f64; Origin::COUNT],
}

impl LightAccount {
    /// Returns the account of these VPLs, whose routes are given in their order. `None` if the
    /// camera sees none of them, has a lens or moves.
    pub(super) fn of(lights: &[Vpl], routes: &[Route], tracer: &Tracer, view: &View<'_>) -> Option<Self> {
        let step = lights.len().div_ceil(MOST_IN_ACCOUNT).max(1);
        let thinned: Vec<Vpl> = lights.iter().step_by(step).copied().collect();
        let mut account = Self::default();
        for Seen { light, luminance, .. } in project(&thinned, tracer, view) {
            let Route { origin, way } = routes[light * step];
            account.luminance += f64::from(luminance);
            account.by_way[way as usize] += f64::from(luminance);
            account.by_origin[origin as usize] += f64::from(luminance);
        }
        let whole = account.luminance;
        let pixels = f64::from(view.size[0]) * f64::from(view.size[1]);
        (whole > 0.0).then(|| Self {
            luminance: whole * step as f64 / pixels,
            by_way: account.by_way.map(|part| part / whole),
            by_origin: account.by_origin.map(|part| part / whole),
        })
    }
}

/// Returns true if each point of the scene has one place in the image, since the camera has no lens
/// radius and does not move.
fn is_sharp(view: &View<'_>) -> bool {
    view.camera.lens.radius == 0.0 && view.camera.motion.is_none()
}

/// Luminance that one light adds to a pixel.
struct Seen {
    /// Index among the given lights.
    light: usize,
    /// Index of the pixel, row by row.
    pixel: usize,
    /// Luminance that the light adds to the pixel (W·m⁻²·sr⁻¹).
    luminance: f32,
}

/// Projects lights onto the image, in their order. Occluded lights have the luminance 0; those
/// outside the image are omitted. Empty unless the camera is [sharp](is_sharp).
fn project(lights: &[Vpl], tracer: &Tracer, view: &View<'_>) -> Vec<Seen> {
    if !is_sharp(view) {
        return Vec::new();
    }
    let mut shadows = Shadows::new(Glass::SolidStops);
    let mut seen = Vec::new();
    for (number, light) in lights.iter().enumerate() {
        if let Some((pixel, luminance, eye)) = from_eye(light, view) {
            shadows.push((eye, view.camera.medium), light.apex());
            seen.push(Seen { light: number, pixel, luminance });
        }
    }
    for (seen, passing) in seen.iter_mut().zip(shadows.trace(tracer)) {
        seen.luminance *= passing.max_channel();
    }
    seen
}

/// Returns the index of the pixel in which a light lies, its unoccluded luminance there, and the
/// origin of its camera ray. `None` if the light is outside the image, turned away, or of another
/// kind than [`VplKind::Oriented`].
fn from_eye(light: &Vpl, view: &View<'_>) -> Option<(usize, f32, Vec3)> {
    if light.kind != VplKind::Oriented {
        return None;
    }
    let (film, area) = view.camera.project(light.position, view.size)?;
    let ray = view.camera.ray(&CameraSample { film, lens: [0.5; 2], time: 0.5 }, view.size)?;
    let cos = -light.direction.dot(ray.direction);
    let pixel = film.floor().as_ivec2();
    let [width, height] = view.size.map(|side| side as i32);
    let is_inside = cos > 0.0 && (0..width).contains(&pixel.x) && (0..height).contains(&pixel.y);
    let luminance = light.intensity.luminance() * cos / area;
    is_inside.then_some(((pixel.y * width + pixel.x) as usize, luminance, ray.origin))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, DVec3};

    use super::*;
    use crate::accel::Tracer;
    use crate::gather::GatherOptions;
    use crate::math::motion::Track;
    use crate::scene::{Camera, Lens, builtin};
    use crate::vpl::VplOptions;

    /// The light of one point is no evidence; that of a hundred is known to a fifth.
    #[test]
    fn single_points_are_no_evidence() {
        let [one, many] = [1.0, 100.0].map(|points| [5.0, 25.0 / points]);
        let seen = SeenLight { pixels: vec![one, many], width: 2 };
        let least = [0, 1].map(|x| seen.importance_least([x, 0]));
        assert!(least[0] == 0.0 && (least[1] - 4.0).abs() < 1e-6, "{least:?}");
    }

    /// For a still pinhole camera, lamps are found, and a pixel that the lamp fills has the lamp's
    /// luminance. For a camera with a lens or in motion, no lamps are returned.
    #[test]
    fn lamps_are_known_to_cameras_that_stand_and_have_no_lens() {
        let tracer = Tracer::new(Arc::new(builtin::tiny()));
        let tracing = LightTracer::new(&tracer, &VplOptions::default()).unwrap();
        let camera = Camera::look_at("c", Vec3::new(1.0, 0.5, 2.5), Vec3::new(1.0, 2.0, 1.0), Vec3::Y, 0.7);
        let learn = |camera: &Camera| {
            let view = View { camera, size: [8, 8], gather: GatherOptions::default(), seed: 1 };
            SeenLight::lamps(&tracing, &view, 2)
        };
        let seen = learn(&camera).expect("the lamp is in the picture");
        let brightest = (0..64).map(|i| seen.importance_radiance([i % 8, i / 8])).fold(0.0, f64::max);
        assert!((10.0..20.0).contains(&brightest), "{brightest}: a pixel that the lamp fills");
        assert!(learn(&Camera { lens: Lens::round(0.1, 2.0), ..camera.clone() }).is_none());
        let linear = camera.to_world.matrix3.as_dmat3();
        let at = |x: f64| DAffine3 {
            matrix3: linear,
            translation: camera.to_world.translation.as_dvec3() + DVec3::X * x,
        };
        let moving =
            camera.clone().moving(Track::new([(0.0, at(-0.1)), (1.0, at(0.1))]).unwrap(), [0.0, 1.0]);
        assert!(moving.motion.is_some() && learn(&moving).is_none());
    }
}
