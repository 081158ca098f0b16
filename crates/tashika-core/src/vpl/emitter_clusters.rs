//! Clusters of emitters that are close to each other and face approximately the same way.
//!
//! The sources of an [`EmitterSampler`] (triangles, points, spots, directions) are divided by
//! repeated halving. Each step halves the cluster of the largest probability, along the coordinate
//! of position or direction with the largest variance. The environment is divided into blocks of
//! directions.

use std::collections::BinaryHeap;

use super::emitters::{About, towards_environment};
use super::{EmitterSampler, LightSample};
use crate::math::Vec3;
use crate::scene::{EnvironmentBlocks, InstanceId};
use crate::stats::{Discrete, Moments};

/// Maximum number of clusters of sources.
const OF_SOURCES: usize = 128;
/// Maximum number of blocks of the environment.
const OF_ENVIRONMENT: usize = 512;

/// Clusters of an [`EmitterSampler`]. All methods must be given the sampler that the clusters were
/// made from.
#[derive(Clone, Debug)]
pub struct EmitterClusters {
    of_sources: Vec<Sources>,
    /// Cluster of each source; `None` for the environment, and for sources that are never drawn.
    cluster_of: Vec<Option<u32>>,
    environment: Option<Blocks>,
}

/// A cluster of sources, and the distribution over them.
#[derive(Clone, Debug)]
struct Sources {
    sources: Vec<u32>,
    /// Distribution over `sources`, by their probabilities in the sampler.
    within: Discrete,
}

#[derive(Clone, Debug)]
struct Blocks {
    blocks: EnvironmentBlocks,
    /// Probability of the environment in the sampler.
    probability: f64,
}

/// Source to be put into a cluster: its number, its probability, and its position and direction.
#[derive(Clone, Copy)]
struct Placed {
    source: u32,
    probability: f64,
    place: [f32; 6],
}

impl EmitterClusters {
    /// Divides the sources of a sampler into clusters. There are none if no source shines.
    pub fn new(emitters: &EmitterSampler<'_>) -> Self {
        let radius = emitters.sphere().1.max(f32::MIN_POSITIVE);
        let [mut near, mut far] = [(); 2].map(|()| Vec::new());
        let mut environment = None;
        let mut cluster_of = Vec::new();
        for (source, probability) in emitters.probabilities().enumerate() {
            cluster_of.push(None);
            if probability <= 0.0 {
                continue;
            }
            let source = source as u32;
            let placed = |at: Vec3, direction: Vec3| {
                let [at, direction] = [(at / radius).to_array(), direction.to_array()];
                let place = [at[0], at[1], at[2], direction[0], direction[1], direction[2]];
                Placed { source, probability, place }
            };
            match emitters.about(source as usize) {
                About::Near(at, direction) => near.push(placed(at, direction)),
                About::Far(direction) => far.push(placed(Vec3::ZERO, direction)),
                About::Everywhere => {
                    let blocks = emitters.environment().map(|e| EnvironmentBlocks::new(e, OF_ENVIRONMENT));
                    environment = blocks.map(|blocks| Blocks { blocks, probability });
                }
            }
        }
        let mut of_sources = Vec::new();
        for sources in divide([near, far]) {
            for placed in &sources {
                cluster_of[placed.source as usize] = Some(of_sources.len() as u32);
            }
            let within = Discrete::new(sources.iter().map(|placed| placed.probability));
            of_sources.push(Sources {
                sources: sources.iter().map(|placed| placed.source).collect(),
                within: within.expect("each has a probability above zero"),
            });
        }
        Self { of_sources, cluster_of, environment }
    }

    /// Returns the number of clusters.
    pub fn count(&self) -> usize {
        self.of_sources.len() + self.environment.as_ref().map_or(0, |e| e.blocks.count())
    }

    /// Returns the probability with which the sampler draws from a cluster.
    pub fn probability(&self, cluster: usize) -> f64 {
        match self.of_sources.get(cluster) {
            Some(sources) => sources.within.total(),
            None => self
                .environment
                .as_ref()
                .map_or(0.0, |e| e.probability * e.blocks.probability(cluster - self.of_sources.len())),
        }
    }

    /// Returns the cluster of an emitting triangle.
    pub fn of_triangle(
        &self,
        emitters: &EmitterSampler<'_>,
        instance: InstanceId,
        triangle: u32,
    ) -> Option<usize> {
        let source = emitters.source_of(instance, triangle)?;
        self.cluster_of[source].map(|cluster| cluster as usize)
    }

    /// Returns the cluster of a unit direction of the environment.
    pub fn of_direction(&self, emitters: &EmitterSampler<'_>, direction: Vec3) -> Option<usize> {
        let blocks = &self.environment.as_ref()?.blocks;
        Some(self.of_sources.len() + blocks.of(emitters.environment()?, direction))
    }

    /// Draws a sample like [`EmitterSampler::sample`], and returns it with its cluster.
    pub fn sample(&self, emitters: &EmitterSampler<'_>, u: f64, v: [f32; 2]) -> Option<(usize, LightSample)> {
        let (source, sample) = emitters.sample_source(u, v)?;
        let cluster = match self.cluster_of[source] {
            Some(cluster) => cluster as usize,
            None => self.of_direction(emitters, -sample.light.direction)?,
        };
        Some((cluster, sample))
    }

    /// Draws a sample from one cluster, whose probability must be above zero. The density of the
    /// sample, and the density by which its intensity is divided, are those of the whole sampler.
    pub fn sample_from(
        &self,
        emitters: &EmitterSampler<'_>,
        cluster: usize,
        u: f64,
        v: [f32; 2],
    ) -> Option<LightSample> {
        if let Some(Sources { sources, within }) = self.of_sources.get(cluster) {
            let (number, _, rest) = within.sample(u);
            let source = sources[number] as usize;
            let probability = within.probability(number) * within.total();
            return Some(emitters.draw_from(source, probability, rest, v));
        }
        let (Blocks { blocks, probability }, environment) =
            self.environment.as_ref().zip(emitters.environment())?;
        let towards = blocks.sample(environment, cluster - self.of_sources.len(), v);
        let pdf = *probability as f32 * environment.pdf(towards);
        Some(towards_environment(environment, towards, pdf))
    }
}

/// Halves groups of sources until there are [`OF_SOURCES`] clusters, or none can be halved.
fn divide(groups: [Vec<Placed>; 2]) -> Vec<Vec<Placed>> {
    let mut clusters: Vec<Vec<Placed>> = groups.into_iter().filter(|group| !group.is_empty()).collect();
    // The order of non-negative numbers is that of their bits.
    let often = |cluster: &[Placed]| cluster.iter().map(|placed| placed.probability).sum::<f64>().to_bits();
    let mut waiting: BinaryHeap<(u64, usize)> = clusters.iter().map(|c| often(c)).zip(0..).collect();
    while clusters.len() < OF_SOURCES {
        let Some((_, number)) = waiting.pop() else { break };
        let Some(half) = halve(&mut clusters[number]) else { continue };
        waiting.push((often(&clusters[number]), number));
        waiting.push((often(&half), clusters.len()));
        clusters.push(half);
    }
    clusters
}

/// Splits off half of a cluster by probability; `None` if all its sources have the same position
/// and direction.
fn halve(cluster: &mut Vec<Placed>) -> Option<Vec<Placed>> {
    let variance = |axis: usize| {
        let mut moments = Moments::default();
        cluster.iter().for_each(|placed| moments.push(placed.place[axis].into()));
        moments.variance()
    };
    let widest = (0..6).map(|axis| (variance(axis), axis)).max_by(|a, b| a.0.total_cmp(&b.0));
    let axis = widest.filter(|(variance, _)| *variance > 0.0)?.1;
    cluster.sort_by(|a, b| a.place[axis].total_cmp(&b.place[axis]));
    let whole: f64 = cluster.iter().map(|placed| placed.probability).sum();
    let mut below = 0.0;
    let half = cluster.iter().position(|placed| {
        below += placed.probability;
        below >= 0.5 * whole
    });
    Some(cluster.split_off((half? + 1).clamp(1, cluster.len() - 1)))
}
