//! Choice of a VPL for a surface on a path: by possible contributions of VPLs, and by learned
//! contributions to similar surfaces.
//!
//! At each surface of a path, one of millions of VPLs is drawn, and most VPLs that could contribute
//! much are occluded. In each [place](super::places), the probability of a cluster of VPLs is
//! therefore a mixture
//!
//! ```text
//! P(c) = β q_c + ½ (1 − β) (p_c + l_c)          P(i) = P(c) p(i | c)
//! ```
//!
//! of the distribution learned there by [trial](super::trials) (`q_c`), of the possible
//! contributions of clusters to some receivers of the place (`p_c`), and of the luminance of
//! clusters (`l_c`). Within a cluster, the light tree is descended by possible contributions to the
//! surface itself.
//!
//! # Guarantee
//! A VPL that can contribute has a probability of at least `½ (1 − β) l_c` times its probability
//! within the cluster, and the distribution is learned from separate random numbers. So the
//! estimate is unbiased whatever was learned. Held to this by the test below.

use super::descent::Descent;
use super::places::{Places, Receiver};
use super::trials::{Drawn, Trials};
use crate::accel::Tracer;
use crate::contribution::ContributionKernel;
use crate::stats::Discrete;
use crate::tree::{LightCluster, LightTree};

/// Maximum number of clusters into which the VPLs are divided.
const CLUSTERS: usize = 256;
/// Maximum number of receivers used to divide VPLs into clusters, by the importance of VPLs for
/// them.
const PROBES: usize = 64;
/// Number of lights tried for each place and cluster.
const TRIALS: usize = 8;
/// Maximum number of receivers of a place from which `p_c` is computed.
const PROBES_OF_PLACE: usize = 4;
/// `β`: weight of the learned distribution. Importance alone ignores visibility; the learned
/// distribution resolves nothing smaller than a place.
const LEARNED: f64 = 0.9;

/// Learned distributions of VPLs, by place.
#[derive(Clone, Debug)]
pub struct VplChoice {
    clusters: Vec<LightCluster>,
    places: Places,
    /// `P` by place; `None` where no VPL contributes.
    tables: Vec<Option<Discrete>>,
}

impl VplChoice {
    /// Learns the distributions from these receivers. Runs on the current thread pool.
    ///
    /// Returns `None` if there are no lights, or no receivers.
    ///
    /// * `contribution`: contribution kernel, with the clamp distance at these receivers.
    pub(super) fn learn(
        lights: &LightTree,
        tracer: &Tracer,
        contribution: ContributionKernel<'_>,
        receivers: Vec<Receiver>,
        seed: u64,
    ) -> Option<Self> {
        if lights.lights().is_empty() || receivers.is_empty() {
            return None;
        }
        let step = receivers.len().div_ceil(PROBES);
        let probes: Vec<Receiver> = receivers.iter().copied().step_by(step).collect();
        let clamp_distance = contribution.clamp_distance();
        let could_give = |cluster: &LightCluster, receiver: &Receiver| {
            Descent { lights, clamp_distance, receiver }.importance(cluster)
        };
        let clusters = lights.split(CLUSTERS, |cluster| probes.iter().map(|r| could_give(cluster, r)).sum());
        let (places, of_places) = Places::divide(receivers);
        let trials = Trials { tracer, contribution, clusters: clusters.len(), lights: TRIALS, seed };
        let learned = trials.learn(&of_places, |cluster, stream| {
            let cluster = &clusters[cluster];
            let light = lights.light(lights.draw(cluster, stream.uniform_f64()));
            Some(Drawn { light, luminance: lights.luminance(cluster) })
        });
        let by_luminance = shares(clusters.iter().map(|cluster| lights.luminance(cluster)));
        let table = |(learned, receivers): (Option<Discrete>, &Vec<Receiver>)| {
            let learned = learned?;
            let probes = || receivers.iter().step_by(receivers.len().div_ceil(PROBES_OF_PLACE));
            let of_cluster = |cluster| probes().map(|receiver| could_give(cluster, receiver)).sum();
            let by_importance = shares(clusters.iter().map(of_cluster));
            let shares = by_luminance.iter().zip(by_importance).enumerate();
            Discrete::new(shares.map(|(cluster, (by_luminance, by_importance))| {
                let unlearned = 0.5 * (by_luminance + by_importance);
                LEARNED * learned.probability(cluster) + (1.0 - LEARNED) * unlearned
            }))
        };
        let tables = learned.into_iter().zip(&of_places).map(table).collect();
        Some(Self { clusters, places, tables })
    }

    /// Draws a light from the mixture, as [`Descent::draw`] does by importance alone.
    pub(super) fn draw(&self, descent: &Descent<'_>, u: f64) -> Option<(u32, f64)> {
        let Some(table) = self.places.of(descent.receiver).and_then(|place| self.tables[place].as_ref())
        else {
            return descent.draw(u);
        };
        let (cluster, probability, u) = table.sample(u);
        descent.draw_from(self.clusters[cluster], probability, u)
    }
}

/// Divides numbers by their sum; returns zeros if the sum is zero.
fn shares(numbers: impl Iterator<Item = f64>) -> Vec<f64> {
    let numbers: Vec<f64> = numbers.collect();
    let sum: f64 = numbers.iter().sum();
    numbers.into_iter().map(|number| if sum > 0.0 { number / sum } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::accel::{Glass, SegmentBatch};
    use crate::color::Rgb;
    use crate::error::Location;
    use crate::math::{Affine3A, Vec3};
    use crate::rng::{Purpose, Stream};
    use crate::scene::{Material, MeshData, SceneBuilder, Surface};
    use crate::stats::Moments;
    use crate::tree::LightTreeBuilder;
    use crate::vpl::{Provenance, Vpl, VplKind, VplSet};

    /// A wall at `x = 0`, which divides a floor at `z = 0`.
    fn two_halves() -> Tracer {
        let wall = [Vec3::new(0.0, -9.0, -9.0), Vec3::new(0.0, 9.0, -9.0), Vec3::new(0.0, 0.0, 30.0)];
        let data = MeshData { positions: wall.to_vec(), triangles: vec![[0, 1, 2]], ..MeshData::default() };
        let mut b = SceneBuilder::new("test", Location::default());
        let surface = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
        let material = b.add_material(Material::new("wall", surface)).unwrap();
        let mesh = b.add_mesh(data, material).unwrap();
        b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        Tracer::new(Arc::new(b.build().unwrap()))
    }

    fn lights(s: &mut Stream) -> LightTree {
        let light = |s: &mut Stream| {
            let [x, y, z] = s.uniform_3();
            // Lights at `x > 0` are the brighter ones.
            let intensity = Rgb::gray(if x < 0.5 { 1.0 } else { 50.0 });
            let position = Vec3::new(4.0 * x - 2.0, 4.0 * y - 2.0, 1.0 + z);
            Vpl { position, direction: Vec3::NEG_Z, intensity, kind: VplKind::Oriented }
        };
        let lights = (0..4000).map(|_| light(s)).collect();
        LightTree::build(&VplSet::new(lights, Provenance::default()), LightTreeBuilder::default())
    }

    /// One receiver is in a learned place, another is elsewhere. For both, draws estimate the whole
    /// sum without bias. In the learned place the variance is far smaller, since most of the light
    /// is behind a wall.
    #[test]
    fn what_was_learned_is_drawn_more_often_and_nothing_is_left_out() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let (tracer, lights) = (two_halves(), lights(&mut s));
        let contribution = ContributionKernel::new(0.1).with_glass(Glass::SolidStops);
        let on_floor =
            |x: f32, y: f32| Receiver { position: Vec3::new(x, y, 0.0), normal: Some(Vec3::Z), medium: None };
        let met = (0..2000).map(|_| on_floor(-2.0 * s.uniform() - 0.01, 4.0 * s.uniform() - 2.0)).collect();
        let choice = VplChoice::learn(&lights, &tracer, contribution, met, 3).unwrap();
        for (receiver, is_known) in [(on_floor(-0.7, 0.4), true), (on_floor(0.9, -0.3), false)] {
            let mut batch = SegmentBatch::new(contribution.glass());
            let mut visibility = Vec::new();
            let mut value = |light: u32| {
                let light = lights.light(light);
                let link = contribution.link(receiver.position, &light);
                batch.clear();
                batch.push_fan(light.apex(), [receiver.position]);
                tracer.visibility(&batch, &mut visibility);
                let cos = receiver.cosine(link.towards_light);
                f64::from(light.intensity.luminance() * link.geometric * cos * visibility[0])
            };
            let truth: f64 = (0..4000).map(&mut value).sum();
            let [mut learned, mut unlearned] = [Moments::default(); 2];
            for _ in 0..20_000 {
                let u = s.uniform_f64();
                let descent = Descent {
                    lights: &lights,
                    clamp_distance: contribution.clamp_distance(),
                    receiver: &receiver,
                };
                let by = |drawn: Option<(u32, f64)>| drawn.expect("all can give light");
                let (light, p) = by(choice.draw(&descent, u));
                learned.push(value(light) / p);
                let (light, p) = by(descent.draw(u));
                unlearned.push(value(light) / p);
            }
            for found in [&learned, &unlearned] {
                let error = (found.variance() / found.count() as f64).sqrt();
                assert!((found.mean() - truth).abs() < 4.0 * error, "{} ± {error}: {truth}", found.mean());
                assert!(error < 0.1 * truth, "{error} of {truth}");
            }
            let ratio = unlearned.variance() / learned.variance();
            assert!(ratio > 5.0 || !is_known, "{ratio}");
        }
    }
}
