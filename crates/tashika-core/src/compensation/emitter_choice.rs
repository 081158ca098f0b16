//! Choice of an emitter for a surface on a path: by power, and by learned contributions to similar
//! surfaces.
//!
//! The probability of a cluster of emitters, or of directions of the environment, is a mixture
//!
//! ```text
//! P(c) = β q_c + (1 − β) p_c
//! ```
//!
//! of the distribution learned for the [place](super::places) of the surface (`q_c`, by
//! [trial](super::trials)) and of the plain distribution (`p_c`). Within a cluster, lights are
//! drawn by the plain distribution. Every density is therefore the density of the
//! [`EmitterSampler`] times
//!
//! ```text
//! f_c = P(c) / p_c ≥ 1 − β
//! ```
//!
//! # Guarantee
//! Every emitter has at least `1 − β` times its plain probability, and the distribution is learned
//! from separate random numbers. So the estimate is unbiased whatever was learned. Held to this by
//! the test below.

use super::LightingContext;
use super::places::{Places, Receiver};
use super::trials::{Drawn, Trials};
use crate::math::Vec3;
use crate::scene::InstanceId;
use crate::stats::Discrete;
use crate::vpl::{EmitterClusters, EmitterSampler, LightSample};

/// Number of lights tried for each place and cluster.
const TRIALS: usize = 4;
/// `β`: probability of a draw by the learned distribution.
const LEARNED: f64 = 0.9;

/// Learned distributions of emitters, by place.
#[derive(Clone, Debug)]
pub struct EmitterChoice {
    clusters: EmitterClusters,
    places: Places,
    /// `q` by place; `None` where no emitter contributes.
    tables: Vec<Option<Discrete>>,
}

impl EmitterChoice {
    /// Learns the distributions from these receivers. Runs on the current thread pool.
    pub(super) fn learn(lit: &LightingContext<'_>, receivers: Vec<Receiver>, seed: u64) -> Self {
        let LightingContext { emitters, tracer, contribution, .. } = *lit;
        let clusters = EmitterClusters::new(emitters);
        let (places, of_places) = Places::divide(receivers);
        let trials = Trials { tracer, contribution, clusters: clusters.count(), lights: TRIALS, seed };
        let tables = trials.learn(&of_places, |cluster, stream| {
            let probability = clusters.probability(cluster);
            let (u, v) = (stream.uniform_f64(), stream.uniform_2());
            let sample = (probability > 0.0).then(|| clusters.sample_from(emitters, cluster, u, v));
            let light = sample??.light;
            Some(Drawn { light, luminance: probability * f64::from(light.intensity.luminance()) })
        });
        Self { clusters, places, tables }
    }

    /// Returns `f_c` of a cluster.
    fn factor(&self, table: &Discrete, cluster: usize) -> f32 {
        let plain = self.clusters.probability(cluster);
        (LEARNED * table.probability(cluster) / plain + (1.0 - LEARNED)) as f32
    }
}

/// Distribution of emitter samples for one receiver.
#[derive(Clone, Copy, Debug)]
pub(super) struct EmittersAt<'a> {
    emitters: &'a EmitterSampler<'a>,
    /// Learned distribution `q` of the receiver's place, with its clusters.
    learned: Option<(&'a EmitterChoice, &'a Discrete)>,
}

impl<'a> EmittersAt<'a> {
    pub fn new(
        emitters: &'a EmitterSampler<'a>,
        choice: Option<&'a EmitterChoice>,
        receiver: &Receiver,
    ) -> Self {
        let learned = choice.and_then(|choice| {
            let place = choice.places.of(receiver)?;
            Some((choice, choice.tables[place].as_ref()?))
        });
        Self { emitters, learned }
    }

    /// Draws a sample from the mixture, as [`EmitterSampler::sample`] does from the plain
    /// distribution.
    pub fn sample(&self, u: f64, v: [f32; 2]) -> Option<LightSample> {
        let Some((choice, table)) = self.learned else { return self.emitters.sample(u, v) };
        let EmitterChoice { clusters, .. } = choice;
        let (cluster, mut sample) = if u < LEARNED {
            let (cluster, _, rest) = table.sample(u / LEARNED);
            (cluster, clusters.sample_from(self.emitters, cluster, rest, v)?)
        } else {
            clusters.sample(self.emitters, (u - LEARNED) / (1.0 - LEARNED), v)?
        };
        let factor = choice.factor(table, cluster);
        sample.light.intensity = sample.light.intensity / factor;
        sample.pdf = sample.pdf.map(|pdf| pdf * factor);
        Some(sample)
    }

    /// Returns the density with which [`EmittersAt::sample`] draws a point on one emitting side of
    /// a triangle (m⁻²).
    pub fn pdf_on_triangle(&self, instance: InstanceId, triangle: u32) -> f32 {
        let learned = self.learned.and_then(|(choice, table)| {
            let cluster = choice.clusters.of_triangle(self.emitters, instance, triangle)?;
            Some(choice.factor(table, cluster))
        });
        self.emitters.pdf_on_triangle(instance, triangle) * learned.unwrap_or(1.0)
    }

    /// Returns the density with which [`EmittersAt::sample`] draws a direction of the environment
    /// (sr⁻¹).
    pub fn pdf_of_environment(&self, direction: Vec3) -> f32 {
        let plain = self.emitters.pdf_of_environment(direction);
        let learned = self.learned.filter(|_| plain > 0.0).and_then(|(choice, table)| {
            let cluster = choice.clusters.of_direction(self.emitters, direction)?;
            Some(choice.factor(table, cluster))
        });
        plain * learned.unwrap_or(1.0)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{SegmentBatch, Tracer};
    use crate::color::Rgb;
    use crate::compensation::VplSource;
    use crate::contribution::ContributionKernel;
    use crate::error::Location;
    use crate::math::Affine3A;
    use crate::rng::{Purpose, Stream};
    use crate::scene::{Emission, Environment, Material, MeshData, SceneBuilder, Surface};
    use crate::stats::Moments;
    use crate::vpl::VplKind;

    /// A wall at `x = 0` with a lamp on each side, the brighter one at `x > 0`, and a faint
    /// environment.
    fn two_halves() -> Tracer {
        let mut b = SceneBuilder::new("test", Location::default());
        let mut add = |positions: [Vec3; 3], radiance: f32| {
            let data =
                MeshData { positions: positions.to_vec(), triangles: vec![[0, 1, 2]], ..MeshData::default() };
            let surface = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
            let emission = Emission { radiance: Rgb::gray(radiance).into(), two_sided: true };
            let emission = (radiance > 0.0).then_some(emission);
            let material = b.add_material(Material { emission, ..Material::new("test", surface) }).unwrap();
            let mesh = b.add_mesh(data, material).unwrap();
            b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        };
        let wall = [Vec3::new(0.0, -9.0, -9.0), Vec3::new(0.0, 9.0, -9.0), Vec3::new(0.0, 0.0, 30.0)];
        add(wall, 0.0);
        for (x, radiance) in [(-1.0, 1.0), (1.0, 500.0)] {
            add([Vec3::new(x, 0.0, 1.0), Vec3::new(x + 0.1, 0.0, 1.0), Vec3::new(x, 0.1, 1.0)], radiance);
        }
        b.set_environment(Environment::constant(Rgb::gray(0.001))).unwrap();
        Tracer::new(Arc::new(b.build().unwrap()))
    }

    /// One receiver is in a learned place, another is elsewhere. For both, the estimate of the
    /// light of all emitters is unbiased, and the density of a sample is the one by which hits are
    /// weighted. In the learned place the variance is far smaller, since the bright lamp is behind
    /// a wall.
    #[test]
    fn emitters_that_are_seen_are_drawn_more_often_and_none_is_left_out() {
        let tracer = two_halves();
        let emitters = EmitterSampler::new(&tracer);
        let lit = LightingContext {
            tracer: &tracer,
            emitters: &emitters,
            lights: None,
            vpl_source: VplSource::Surfaces,
            choices: None,
            contribution: ContributionKernel::default(),
            max_depth: 2,
            caustics: None,
        };
        let mut s = Stream::new(1, Purpose::Test, 0);
        let on_floor =
            |x: f32, y: f32| Receiver { position: Vec3::new(x, y, 0.0), normal: Some(Vec3::Z), medium: None };
        let met = (0..2000).map(|_| on_floor(-2.0 * s.uniform() - 0.01, 4.0 * s.uniform() - 2.0)).collect();
        let choice = EmitterChoice::learn(&lit, met, 3);
        let mut batch = SegmentBatch::new(lit.contribution.glass());
        let mut visibility = Vec::new();
        for (receiver, is_known) in [(on_floor(-0.7, 0.4), true), (on_floor(0.9, -0.3), false)] {
            let mut moments = [Moments::default(); 2];
            for (choice, moments) in [None, Some(&choice)].into_iter().zip(&mut moments) {
                let at = EmittersAt::new(&emitters, choice, &receiver);
                for _ in 0..20_000 {
                    let sample = at.sample(s.uniform_f64(), s.uniform_2()).expect("there are lamps");
                    let light = sample.light;
                    if light.kind == VplKind::Directional {
                        let density = at.pdf_of_environment(-light.direction);
                        assert!((sample.pdf.unwrap() / density - 1.0).abs() < 1e-3);
                    }
                    let link = lit.contribution.link(receiver.position, &light);
                    let cos = receiver.cosine(link.towards_light);
                    batch.clear();
                    batch.push_fan(light.apex(), [receiver.position]);
                    tracer.visibility(&batch, &mut visibility);
                    let value = light.intensity.luminance() * link.geometric * cos * visibility[0];
                    moments.push(f64::from(value));
                }
            }
            let [plain, learned] = moments;
            let error = plain.standard_error().hypot(learned.standard_error());
            let difference = (learned.mean() - plain.mean()).abs();
            assert!(difference < 4.0 * error, "{} ± {error}: {}", learned.mean(), plain.mean());
            let ratio = plain.variance() / learned.variance();
            assert!(ratio > 5.0 || !is_known, "{ratio}");
        }
        let triangles = [1, 2].map(|instance| {
            let at = EmittersAt::new(&emitters, Some(&choice), &on_floor(-0.7, 0.4));
            let instance = InstanceId::at(instance);
            f64::from(at.pdf_on_triangle(instance, 0) / emitters.pdf_on_triangle(instance, 0))
        });
        assert!(triangles[0] > 10.0 * triangles[1], "{triangles:?}");
    }
}
