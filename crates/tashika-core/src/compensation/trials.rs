//! Contributions of clusters of lights to a place, estimated by trial.
//!
//! ```text
//! q_c ∝ √(m_c v_c)      m_c = mean (I_c G cos θ)²      v_c = (s + Σ V) / (s + n)
//! ```
//!
//! A trial is a light drawn from the cluster `c` and a receiver drawn from the place. `m_c` is a
//! mean over all trials of the cluster. `v_c` is a mean over the `n` trials whose unoccluded
//! contribution is not zero; `V` is the transmittance of such a trial. So `q_c` approximates the
//! root of the second moment of the cluster, which is the best choice (least variance: Vévoda,
//! Kondapaneni, Křivánek 2018). `s` is the weight, in trials, of the assumption that everything is
//! visible. In media `cos θ` is 1.

use rayon::prelude::*;

use super::places::Receiver;
use crate::accel::{Glass, Tracer};
use crate::contribution::ContributionKernel;
use crate::media::Shadows;
use crate::rng::{Purpose, Stream};
use crate::stats::Discrete;
use crate::vpl::{Vpl, VplKind};

/// `s`: weight, in trials, of the assumption that a cluster is visible.
const PRIOR_TRIALS: f64 = 0.25;

/// Light drawn from a cluster.
pub(super) struct Drawn {
    pub light: Vpl,
    /// Luminance of its intensity, divided by its probability within the cluster.
    pub luminance: f64,
}

/// Settings for trials of clusters at places.
pub(super) struct Trials<'a> {
    pub tracer: &'a Tracer,
    pub contribution: ContributionKernel<'a>,
    /// Number of clusters that are tried at each place.
    pub clusters: usize,
    /// Number of lights tried for each place and cluster.
    pub lights: usize,
    pub seed: u64,
}

impl Trials<'_> {
    /// Tests the visibility of lights that `draw` draws from every cluster, from random receivers
    /// of each place. Returns `q` by place; `None` where no light contributes. Runs on the current
    /// thread pool.
    pub fn learn(
        &self,
        places: &[Vec<Receiver>],
        draw: impl Fn(usize, &mut Stream) -> Option<Drawn> + Sync,
    ) -> Vec<Option<Discrete>> {
        let learned = places.par_iter().enumerate().map(|(place, receivers)| {
            let mut stream = Stream::new(self.seed, Purpose::Guidance, place as u64);
            self.try_out(receivers, &draw, &mut stream)
        });
        learned.collect()
    }

    fn try_out(
        &self,
        receivers: &[Receiver],
        draw: &impl Fn(usize, &mut Stream) -> Option<Drawn>,
        stream: &mut Stream,
    ) -> Option<Discrete> {
        // Light from infinity may be drawn through panes, so glass does not stop its segments.
        let mut shadows = [self.contribution.glass(), Glass::Passes].map(Shadows::new);
        let batch_of = |light: &Vpl| usize::from(light.kind == VplKind::Directional);
        let mut batches = Vec::with_capacity(self.clusters * self.lights);
        let mut squares = Vec::with_capacity(self.clusters * self.lights);
        for cluster in 0..self.clusters {
            for _ in 0..self.lights {
                let receiver = &receivers[stream.below(receivers.len() as u64) as usize];
                let mut value = 0.0;
                if let Some(Drawn { light, luminance }) = draw(cluster, stream) {
                    let link = self.contribution.link(receiver.position, &light);
                    value = luminance * f64::from(link.geometric * receiver.cosine(link.towards_light));
                    // The value is not finite if the light lies at the position of the receiver and
                    // nothing is clamped.
                    value = if value.is_finite() { value } else { 0.0 };
                    if value > 0.0 {
                        batches.push(batch_of(&light));
                        shadows[batch_of(&light)].push((receiver.position, receiver.medium), light.apex());
                    }
                }
                squares.push(value * value);
            }
        }
        let mut of_batches = shadows.each_mut().map(|shadows| shadows.trace(self.tracer).iter());
        let mut passing = batches.into_iter().map(|batch| of_batches[batch].next());
        let share = |squares: &[f64]| {
            let mut unoccluded = 0.0;
            let (mut seen, mut trials) = (0.0, 0.0);
            for square in squares.iter().filter(|square| **square > 0.0) {
                unoccluded += square;
                let passing = passing.next().flatten().expect("one for each that is not zero");
                seen += f64::from(passing.max_channel());
                trials += 1.0;
            }
            (unoccluded / squares.len() as f64 * (PRIOR_TRIALS + seen) / (PRIOR_TRIALS + trials)).sqrt()
        };
        let shares: Vec<f64> = squares.chunks_exact(self.lights).map(share).collect();
        Discrete::new(shares)
    }
}
