//! The pyramid of the camera rays of a pixel.

use glam::Vec2;

use super::View;
use crate::accel::Pyramid;
use crate::scene::{CameraSample, Projection};

impl View<'_> {
    /// Returns the pyramid of all camera rays of pixel `(x, y)`; `None` for cameras whose rays form
    /// no pyramid: with a lens, in motion, or with a projection other than perspective.
    pub fn pyramid(&self, pixel: [u32; 2]) -> Option<Pyramid> {
        let camera = self.camera;
        let is_pyramid = matches!(camera.projection, Projection::Perspective { .. });
        if !is_pyramid || camera.lens.radius > 0.0 || camera.motion.is_some() {
            return None;
        }
        let ray = |film: Vec2| camera.ray(&CameraSample { film, lens: [0.5; 2], time: 0.0 }, self.size);
        let center = Vec2::new(pixel[0] as f32 + 0.5, pixel[1] as f32 + 0.5);
        let [width, height] = self.size.map(|side| side as f32);
        let reach = self.gather.filter.reach();
        let direction = |x: f32, y: f32| Some(ray(Vec2::new(x, y))?.direction);
        let column = |x: f32| Some([direction(x, 0.0)?, direction(x, height)?]);
        let row = |y: f32| Some([direction(0.0, y)?, direction(width, y)?]);
        let sides = [
            column(center.x - reach)?,
            column(center.x + reach)?,
            row(center.y - reach)?,
            row(center.y + reach)?,
        ];
        let axis = ray(center)?;
        Some(Pyramid::new(axis.origin, axis.direction, sides))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, Quat, Vec3};

    use super::*;
    use crate::accel::Tracer;
    use crate::color::Rgb;
    use crate::error::Location;
    use crate::gather::GatherOptions;
    use crate::math::elementary::rotation;
    use crate::rng::{Purpose, Stream};
    use crate::scene::{Camera, Material, MeshData, SceneBuilder, Surface};

    /// Small triangles around the origin, some of which are placed twice, turned and scaled.
    fn scattered_triangles(s: &mut Stream) -> Tracer {
        let mut b = SceneBuilder::new("test", Location::default());
        let lambert = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
        let material = b.add_material(Material::new("matt", lambert)).unwrap();
        let place = |s: &mut Stream| Vec3::from(s.uniform_3()) * 2.0 - 1.0;
        for number in 0..40 {
            let corner = place(s);
            let positions = vec![corner, corner + 0.1 * place(s), corner + 0.1 * place(s)];
            let data = MeshData { positions, triangles: vec![[0, 1, 2]], ..MeshData::default() };
            let mesh = b.add_mesh(data, material).unwrap();
            b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
            if number % 2 == 0 {
                let turned: Quat = rotation(place(s).normalize(), 3.0 * s.uniform());
                let scale = Vec3::splat(0.2) + Vec3::from(s.uniform_3());
                let at = Affine3A::from_scale_rotation_translation(scale, turned, place(s));
                b.add_instance(mesh, at).unwrap();
            }
        }
        Tracer::new(Arc::new(b.build().unwrap()))
    }

    /// No ray meets anything in pixels that are reported as empty. Most pixels that all rays miss
    /// are reported.
    #[test]
    fn what_is_said_to_be_empty_is_met_by_no_ray() {
        const SIZE: [u32; 2] = [24, 16];
        let mut s = Stream::new(1, Purpose::Test, 0);
        let (mut missed, mut certain) = (0, 0);
        for _ in 0..20 {
            let tracer = scattered_triangles(&mut s);
            let eye = (Vec3::from(s.uniform_3()) * 2.0 - 1.0).normalize() * (1.0 + 3.0 * s.uniform());
            let camera = Camera::look_at("c", eye, Vec3::ZERO, Vec3::new(0.1, 1.0, 0.2), 0.9);
            let view = View { camera: &camera, size: SIZE, gather: GatherOptions::default(), seed: 1 };
            for pixel in (0..SIZE[0] * SIZE[1]).map(|k| [k % SIZE[0], k / SIZE[0]]) {
                let is_empty = tracer.is_empty_within(&view.pyramid(pixel).unwrap());
                let is_met = (0..200).any(|_| {
                    let [a, b] = s.uniform_2();
                    let ray = view.beginning_of(pixel, [a, b, 0.5, 0.5], || 0.0).ray().unwrap();
                    tracer.closest_hit(&ray, 0).is_some()
                });
                assert!(!(is_empty && is_met), "{pixel:?} from {eye}");
                missed += u32::from(!is_met);
                certain += u32::from(is_empty);
            }
        }
        assert!(certain * 3 > missed * 2, "{certain} of {missed} that no ray meets");
    }
}
