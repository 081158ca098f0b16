//! Lamps that the camera sees straight: how bright they make each pixel, as points drawn on the
//! lamps tell.
//!
//! A lamp of a thousandth of a pixel is missed by most choices of a hundred camera samples, and may
//! outshine all else in the pixel. Points that are drawn on the lamps, each of which has a share of
//! them, cannot miss it:
//!
//! ```text
//! L = Σ_i I_i cos θ_i V_i / A_i          over the points in the pixel, which covers the area A_i there, at right angles to the ray
//! ```
//!
//! A lamp of many pixels is seen by any sample, and told more exactly so; this is to know where
//! samples are too few.

use crate::accel::Glass;
use crate::gather::View;
use crate::math::Vec3;
use crate::media::Shadows;
use crate::scene::CameraSample;
use crate::vpl::{LightTracer, Vpl, VplKind};

/// Points drawn on lamps.
const POINTS: u64 = 1 << 16;

/// About how bright lamps make each pixel.
#[derive(Clone, Debug)]
pub struct SeenLamps {
    /// Luminances (W·m⁻²·sr⁻¹), row by row.
    pixels: Vec<f32>,
    width: u32,
}

impl SeenLamps {
    /// Looks at all lamps from the camera. Runs on the current thread pool.
    ///
    /// None if no lamp is seen, or the camera has a lens, through which lamps are blurred, or moves,
    /// which blurs them too.
    pub fn learn(tracing: &LightTracer<'_>, view: &View<'_>, seed: u64) -> Option<Self> {
        if view.camera.lens.radius > 0.0 || view.camera.motion.is_some() {
            return None;
        }
        let mut shadows = Shadows::new(Glass::SolidStops);
        let mut seen = Vec::new();
        for light in tracing.on_emitters(POINTS, seed) {
            if let Some((pixel, luminance, eye)) = from_eye(&light, view) {
                shadows.push((eye, view.camera.medium), light.apex());
                seen.push((pixel, luminance));
            }
        }
        let [width, height] = view.size;
        let mut pixels = vec![0.0; width as usize * height as usize];
        for ((pixel, luminance), passing) in seen.into_iter().zip(shadows.trace(tracing.tracer())) {
            pixels[pixel] += luminance * passing.max_channel();
        }
        pixels.iter().any(|luminance| *luminance > 0.0).then_some(Self { pixels, width })
    }

    /// About how bright lamps make a pixel (luminance, W·m⁻²·sr⁻¹).
    pub fn importance_radiance(&self, pixel: [u32; 2]) -> f64 {
        self.pixels[pixel[1] as usize * self.width as usize + pixel[0] as usize].into()
    }
}

/// The pixel that a point on a lamp lies in, as its place in the image, what it adds to it, and
/// where its camera ray starts; none if it is not in the image or turned away.
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

    /// The lamp of the box lies in the upper half of its picture, at the same place for all times.
    #[test]
    fn lamps_are_known_to_cameras_that_stand_and_have_no_lens() {
        let tracer = Tracer::new(Arc::new(builtin::tiny()));
        let tracing = LightTracer::new(&tracer, &VplOptions::default()).unwrap();
        let camera = Camera::look_at("c", Vec3::new(1.0, 0.5, 2.5), Vec3::new(1.0, 2.0, 1.0), Vec3::Y, 0.7);
        let learn = |camera: &Camera| {
            let view = View { camera, size: [8, 8], gather: GatherOptions::default(), seed: 1 };
            SeenLamps::learn(&tracing, &view, 2)
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
