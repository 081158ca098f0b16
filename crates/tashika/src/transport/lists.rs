//! Many lights at one gather point: what each would contribute if nothing were in the way, eight at a time.
//!
//! The same arithmetic as [`Transport::unoccluded`], number by number, and the same bits; held to it by the tests below.

use glam::Vec3;

use super::{SMALLEST_SQUARED_DISTANCE, Transport};
use crate::color::LUMINANCE_WEIGHTS;
use crate::gather::GatherPoint;
use crate::math::simd::{F32x8, Level, Portable, WIDTH, each, on_level};
use crate::vpl::{Vpl, VplKind};

/// Eight lights, component by component.
struct Lights8 {
    position: [[f32; WIDTH]; 3],
    direction: [[f32; WIDTH]; 3],
    intensity: [[f32; WIDTH]; 3],
    /// 1 if as bright in all directions.
    omni: [f32; WIDTH],
    /// 1 if infinitely far away.
    directional: [f32; WIDTH],
}

impl Lights8 {
    /// Of at most eight lights; none if one of them shines otherwise than vectors know.
    fn new(lights: &[Vpl]) -> Option<Self> {
        let zero = [[0.0; WIDTH]; 3];
        let (omni, directional) = ([0.0; WIDTH], [0.0; WIDTH]);
        let mut all = Self { position: zero, direction: zero, intensity: zero, omni, directional };
        for (i, light) in lights.iter().enumerate() {
            match light.kind {
                VplKind::Omni => all.omni[i] = 1.0,
                VplKind::Oriented => {}
                VplKind::Directional => all.directional[i] = 1.0,
                VplKind::Spot(_) => return None,
            }
            for (channel, intensity) in light.intensity.to_array().into_iter().enumerate() {
                all.position[channel][i] = light.position[channel];
                all.direction[channel][i] = light.direction[channel];
                all.intensity[channel][i] = intensity;
            }
        }
        Some(all)
    }
}

impl Transport {
    /// Appends the luminance of [`Transport::unoccluded`] of each pair (W·m⁻²·sr⁻¹): point by point, and for each all lights.
    pub fn list(&self, points: &[GatherPoint], lights: &[Vpl], luminances: &mut Vec<f32>) {
        on_level!(
            Level::best(),
            portable: self.list_with::<Portable>(points, lights, luminances),
            avx2: x86::list(self, points, lights, luminances)
        );
    }

    #[inline(always)]
    fn list_with<F: F32x8>(&self, points: &[GatherPoint], lights: &[Vpl], luminances: &mut Vec<f32>) {
        let begin = luminances.len();
        luminances.resize(begin + points.len() * lights.len(), 0.0);
        let rows = &mut luminances[begin..];
        for (chunk, first) in lights.chunks(WIDTH).zip((0..).step_by(WIDTH)) {
            let together = Lights8::new(chunk);
            for (point, row) in points.iter().zip(rows.chunks_mut(lights.len())) {
                let row = &mut row[first..first + chunk.len()];
                match &together {
                    Some(lights) => {
                        let values = self.luminances::<F>(point, lights).array();
                        match row.first_chunk_mut() {
                            Some(whole) => *whole = values,
                            None => row.copy_from_slice(&values[..chunk.len()]),
                        }
                    }
                    None => {
                        for (value, light) in row.iter_mut().zip(chunk) {
                            *value = self.unoccluded(point, light).luminance();
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn luminances<F: F32x8>(&self, point: &GatherPoint, lights: &Lights8) -> F {
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        let smallest = F::splat(SMALLEST_SQUARED_DISTANCE);
        let direction = each!(|axis| F::load(&lights.direction[axis]));
        let d = each!(|axis| F::load(&lights.position[axis]) - F::splat(point.position[axis]));
        let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        let apart = squared.gt(smallest);
        let distance = squared.sqrt();
        let is_directional = F::load(&lights.directional).gt(zero);
        let towards = each!(|axis| {
            let unit = F::select(apart, d[axis] / distance, zero);
            F::select(is_directional, zero - direction[axis], unit)
        });
        let cos = zero - (direction[0] * towards[0] + direction[1] * towards[1] + direction[2] * towards[2]);
        let shape = F::select(F::load(&lights.omni).gt(zero), one, cos.max(zero));
        let near = squared.max(F::splat(self.clamp_squared)).max(smallest);
        let geometric = F::select(is_directional, one, shape / near);

        let height = along(towards, point.geometric_normal);
        let frame = &point.frame;
        let wi = [along(towards, frame.t), along(towards, frame.b), along(towards, frame.n)];
        let material = point.bsdf.eval_cos_of(point.wo, wi);
        let weight = point.weight.to_array();
        let [r, g, b] = each!(|channel| {
            let intensity = F::load(&lights.intensity[channel]);
            let value = F::splat(weight[channel]) * material[channel] * intensity * geometric;
            F::splat(LUMINANCE_WEIGHTS[channel]) * value
        });
        F::select(height.gt(zero), r + g + b, zero)
    }
}

/// Scalar products with one vector.
#[inline(always)]
fn along<F: F32x8>(v: [F; 3], axis: Vec3) -> F {
    v[0] * F::splat(axis.x) + v[1] * F::splat(axis.y) + v[2] * F::splat(axis.z)
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{GatherPoint, Transport, Vpl};
    use crate::math::simd::{Avx2, for_avx2};

    for_avx2! {
        pub fn list(transport: &Transport, points: &[GatherPoint], lights: &[Vpl], luminances: &mut Vec<f32>) {
            transport.list_with::<Avx2>(points, lights, luminances);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{
        Bsdf, Coated, Conductor, ConductorFresnel, Lambert, MetallicRoughness, Phong, Plastic,
    };
    use crate::color::Rgb;
    use crate::math::Frame;
    use crate::rng::{Purpose, Stream};
    use crate::scene::Falloff;
    use crate::warp;

    fn bsdf(s: &mut Stream) -> Bsdf {
        let mut color = || Rgb::new(s.uniform(), s.uniform(), s.uniform()) * 0.5;
        let (a, b, c) = (color(), color(), color());
        let (alpha, ior) = (0.001 + 0.999 * s.uniform() * s.uniform(), 1.0 + s.uniform());
        match s.below(7) {
            0 => Bsdf::Lambert(Lambert { reflectance: a }),
            1 => {
                let exponent = crate::math::elementary::powf(10.0, 6.0 * s.uniform());
                Bsdf::Phong(Phong { diffuse: a, specular: b, exponent })
            }
            2 => Bsdf::Plastic(Plastic { diffuse: a, specular: b, ior, alpha }),
            3 => Bsdf::Conductor(Conductor {
                fresnel: ConductorFresnel::Schlick { f0: a },
                specular: b,
                alpha,
            }),
            4 => {
                let fresnel = ConductorFresnel::Exact { eta: a + Rgb::gray(0.1), k: b };
                Bsdf::Conductor(Conductor { fresnel, specular: c, alpha })
            }
            5 => Bsdf::Coated(Coated { reflectance: a, specular: b, ior, alpha }),
            _ => Bsdf::MetallicRoughness(MetallicRoughness { diffuse: a, f0: b, dielectric_f0: c, alpha }),
        }
    }

    fn point(s: &mut Stream) -> GatherPoint {
        let frame = Frame::about(warp::sphere(s.uniform_2()).normalize());
        let tilted = (frame.n + 0.3 * warp::sphere(s.uniform_2())).normalize();
        GatherPoint {
            position: Vec3::from(s.uniform_3()),
            geometric_normal: tilted,
            frame,
            wo: warp::cosine_hemisphere(s.uniform_2()),
            bsdf: bsdf(s),
            weight: Rgb::new(s.uniform(), s.uniform(), s.uniform()),
        }
    }

    fn light(s: &mut Stream, spots: bool) -> Vpl {
        let direction = warp::sphere(s.uniform_2()).normalize();
        let position = 3.0 * Vec3::from(s.uniform_3()) - 1.0;
        let intensity = Rgb::new(s.uniform(), s.uniform(), s.uniform());
        let (position, direction, kind) = match s.below(if spots { 4 } else { 3 }) {
            0 => (position, Vec3::ZERO, VplKind::Omni),
            1 => (position, direction, VplKind::Oriented),
            2 => (Vec3::ZERO, direction, VplKind::Directional),
            _ => (
                position,
                direction,
                VplKind::Spot(Falloff {
                    cos_inner: 0.9,
                    cos_outer: 0.1,
                    shape: crate::scene::FalloffShape::Squared,
                }),
            ),
        };
        Vpl { position, direction, intensity, kind }
    }

    #[test]
    fn lists_are_single_evaluations_to_the_bit() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let mut lit = 0;
        for round in 0..3000 {
            let mut points: Vec<GatherPoint> = (0..=s.below(4)).map(|_| point(&mut s)).collect();
            let mut lights: Vec<Vpl> = (0..=s.below(20)).map(|_| light(&mut s, round % 3 == 0)).collect();
            if round % 5 == 0 {
                // A light where the point is, and a point that is seen from behind.
                lights[0].position = points[0].position;
                points[0].wo.z = -points[0].wo.z;
            }
            let transport = Transport::new([0.0, 0.2][round % 2]);
            let expected: Vec<f32> = points
                .iter()
                .flat_map(|p| lights.iter().map(|l| transport.unoccluded(p, l).luminance()))
                .collect();
            let (mut best, mut portable) = (Vec::new(), Vec::new());
            transport.list(&points, &lights, &mut best);
            transport.list_with::<Portable>(&points, &lights, &mut portable);
            assert_eq!(best, expected);
            assert_eq!(portable, expected);
            lit += expected.iter().filter(|v| **v > 0.0).count();
        }
        assert!(lit > 10_000, "{lit}");
    }
}
