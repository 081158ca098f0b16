//! Unoccluded contributions of many lights at one gather point, several at a time.
//!
//! The arithmetic is that of [`ContributionKernel::unoccluded`], operation by operation, with
//! identical bits. The tests below check this.

use std::ops::Range;

use glam::Vec3;

use super::{ContributionKernel, SMALLEST_SQUARED_DISTANCE};
use crate::color::LUMINANCE_WEIGHTS;
use crate::gather::GatherPoint;
use crate::math::simd::{Level, Vector, Vectors, Work, each};
use crate::vpl::{LightRows, VplKind};

/// Positions, directions and intensities of several lights, one light per lane.
type Several<F> = [[F; 3]; 3];

impl ContributionKernel<'_> {
    /// Appends the luminance of [`ContributionKernel::unoccluded`] of each pair of a point and a
    /// light (W·m⁻²·sr⁻¹), with all lights of the first point first.
    pub fn list(
        &self,
        points: &[GatherPoint],
        lights: &LightRows,
        range: Range<usize>,
        luminances: &mut Vec<f32>,
    ) {
        Level::best().run(List { contribution: self, points, lights, range, luminances });
    }

    #[inline(always)]
    fn list_with<F: Vector>(
        &self,
        points: &[GatherPoint],
        lights: &LightRows,
        range: Range<usize>,
        luminances: &mut Vec<f32>,
    ) {
        let begin = luminances.len();
        luminances.resize(begin + points.len() * range.len(), 0.0);
        let rows = &mut luminances[begin..];
        for (kind, run) in lights.runs(range.clone()) {
            let (begin, end) = (run.start - range.start, run.end - range.start);
            let by_one = |point: &GatherPoint, row: &mut [f32]| {
                for (value, light) in row[begin..end].iter_mut().zip(run.clone()) {
                    *value = self.unoccluded(point, &lights.get(light)).luminance();
                }
            };
            if let VplKind::Spot(_) | VplKind::Image(_) | VplKind::Volume(_) = kind {
                points.iter().zip(rows.chunks_mut(range.len())).for_each(|(point, row)| by_one(point, row));
                continue;
            }
            // In most pixels either few points or all of them lie in media, so points in media are
            // evaluated one by one.
            for (point, row) in points.iter().zip(rows.chunks_mut(range.len())) {
                if point.phase.is_some() {
                    by_one(point, row);
                }
            }
            for first in (begin..end).step_by(F::LANES) {
                let columns = lights.columns(range.start + first..run.end);
                let several: Several<F> =
                    each!(|vector| each!(|axis| F::load_from(&columns[3 * vector + axis])));
                for (point, row) in points.iter().zip(rows.chunks_mut(range.len())) {
                    if point.phase.is_some() {
                        continue;
                    }
                    let values = &mut row[first..end.min(first + F::LANES)];
                    self.luminances(point, kind, &several).store_to(values);
                }
            }
        }
    }

    /// Luminances of several lights of one kind at a point on a surface. The kind must not have
    /// parameters that differ between its lights.
    #[inline(always)]
    fn luminances<F: Vector>(&self, point: &GatherPoint, kind: VplKind, lights: &Several<F>) -> F {
        let (zero, one) = (F::splat(0.0), F::splat(1.0));
        let [position, direction, intensity] = lights;
        let (towards, geometric) = if let VplKind::Directional = kind {
            (each!(|axis| zero - direction[axis]), one)
        } else {
            let smallest = F::splat(SMALLEST_SQUARED_DISTANCE);
            let d = each!(|axis| position[axis] - F::splat(point.position[axis]));
            let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            let apart = squared.gt(smallest);
            let distance = squared.sqrt();
            let towards = each!(|axis| F::select(apart, d[axis] / distance, zero));
            let shape = if let VplKind::Oriented = kind {
                let along = direction[0] * towards[0] + direction[1] * towards[1] + direction[2] * towards[2];
                (zero - along).max(zero)
            } else {
                one
            };
            (towards, shape / squared.max(F::splat(self.clamp_squared)).max(smallest))
        };
        let height = along(towards, point.geometric_normal);
        // All lights of a group are often behind the surface, or turned away from it.
        let lit = F::and(height.gt(zero), geometric.gt(zero));
        if !F::any(lit) {
            return zero;
        }
        let frame = &point.frame;
        let wi = [along(towards, frame.t), along(towards, frame.b), along(towards, frame.n)];
        let material = point.bsdf.eval_cos_of(point.wo, wi);
        let weight = point.weight.to_array();
        let [r, g, b] = each!(|channel| {
            let value = F::splat(weight[channel]) * material[channel] * intensity[channel] * geometric;
            F::splat(LUMINANCE_WEIGHTS[channel]) * value
        });
        F::select(lit, r + g + b, zero)
    }
}

/// Scalar products of several vectors with one vector.
#[inline(always)]
fn along<F: Vector>(v: [F; 3], axis: Vec3) -> F {
    v[0] * F::splat(axis.x) + v[1] * F::splat(axis.y) + v[2] * F::splat(axis.z)
}

/// [`ContributionKernel::list`] with its arguments.
struct List<'a> {
    contribution: &'a ContributionKernel<'a>,
    points: &'a [GatherPoint],
    lights: &'a LightRows,
    range: Range<usize>,
    luminances: &'a mut Vec<f32>,
}

impl Work for List<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        let Self { contribution, points, lights, range, luminances } = self;
        contribution.list_with::<V::Widest>(points, lights, range, luminances);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{
        AshikhminShirley, Bsdf, Coated, Conductor, ConductorFresnel, FacetModel, HenyeyGreenstein, Lambert,
        MetallicRoughness, Microfacets, Phong, Plastic,
    };
    use crate::color::Rgb;
    use crate::math::Frame;
    use crate::media::Scattering;
    use crate::rng::{Purpose, Stream};
    use crate::scene::{Falloff, MediumId};
    use crate::vpl::Vpl;
    use crate::warp;

    fn bsdf(s: &mut Stream) -> Bsdf {
        let mut color = || Rgb::new(s.uniform(), s.uniform(), s.uniform()) * 0.5;
        let (a, b, c) = (color(), color(), color());
        let (alpha, ior) = (0.001 + 0.999 * s.uniform() * s.uniform(), 1.0 + s.uniform());
        let across = if s.below(2) == 0 { alpha } else { 0.3 };
        let facets = Microfacets { alpha: [alpha, across], model: FacetModel::ALL[s.below(3) as usize] };
        match s.below(8) {
            0 => Bsdf::Lambert(Lambert { reflectance: a }),
            1 => {
                let exponent = crate::math::elementary::powf(10.0, 6.0 * s.uniform());
                Bsdf::Phong(Phong { diffuse: a, specular: b, exponent })
            }
            2 => Bsdf::Plastic(Plastic { diffuse: a, specular: b, ior, facets }),
            3 => Bsdf::Conductor(Conductor {
                fresnel: ConductorFresnel::Schlick { f0: a },
                specular: b,
                facets,
            }),
            4 => {
                let fresnel = ConductorFresnel::Exact { eta: a + Rgb::gray(0.1), k: b };
                Bsdf::Conductor(Conductor { fresnel, specular: c, facets })
            }
            5 => Bsdf::Coated(Coated { reflectance: a, specular: b, ior, facets }),
            6 => {
                let facets = Microfacets { model: FacetModel::Ggx, ..facets };
                Bsdf::AshikhminShirley(AshikhminShirley { diffuse: a, f0: b, facets })
            }
            _ => Bsdf::MetallicRoughness(MetallicRoughness { diffuse: a, f0: b, dielectric_f0: c, facets }),
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
            medium: None,
            phase: None,
            instant: 0,
        }
    }

    fn point_in_medium(s: &mut Stream) -> GatherPoint {
        let phase = HenyeyGreenstein { asymmetry: 1.8 * s.uniform() - 0.9 };
        let (place, before) = (Vec3::from(s.uniform_3()), warp::sphere(s.uniform_2()).normalize());
        let at = Scattering { place, before, medium: MediumId::at(0), phase };
        GatherPoint::in_medium(&at, Rgb::from(s.uniform_3()))
    }

    fn light(s: &mut Stream, shaped: bool) -> Vpl {
        let direction = warp::sphere(s.uniform_2()).normalize();
        let position = 3.0 * Vec3::from(s.uniform_3()) - 1.0;
        let intensity = Rgb::new(s.uniform(), s.uniform(), s.uniform());
        let (position, direction, kind) = match s.below(if shaped { 5 } else { 3 }) {
            0 => (position, Vec3::ZERO, VplKind::Omni),
            1 => (position, direction, VplKind::Oriented),
            2 => (Vec3::ZERO, direction, VplKind::Directional),
            3 => {
                let phase = HenyeyGreenstein { asymmetry: 1.8 * s.uniform() - 0.9 };
                (position, direction, VplKind::Volume(phase))
            }
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
            let mut lights: Vec<Vpl> = (0..=s.below(60)).map(|_| light(&mut s, round % 3 == 0)).collect();
            if round % 2 == 0 {
                points.push(point_in_medium(&mut s));
            }
            if round % 5 == 0 {
                // A light at the position of a point, and a point seen from behind.
                lights[0].position = points[0].position;
                points[0].wo.z = -points[0].wo.z;
            }
            let contribution = ContributionKernel::new([0.0, 0.2][round % 2]);
            lights.sort_by_key(|light| light.kind.number());
            let first = s.below(lights.len() as u64) as usize;
            let range = first..lights.len() - s.below((lights.len() - first) as u64) as usize;
            let expected: Vec<f32> = points
                .iter()
                .flat_map(|p| lights[range.clone()].iter().map(|l| contribution.unoccluded(p, l).luminance()))
                .collect();
            let lights = LightRows::new(lights.into_iter());
            for level in Level::all() {
                let mut luminances = Vec::new();
                level.run(List {
                    contribution: &contribution,
                    points: &points,
                    lights: &lights,
                    range: range.clone(),
                    luminances: &mut luminances,
                });
                assert_eq!(luminances, expected, "{level:?}");
            }
            lit += expected.iter().filter(|v| **v > 0.0).count();
        }
        assert!(lit > 10_000, "{lit}");
    }
}
