//! Independent sets of VPLs, guided to one view.

use super::super::Truth;
use crate::accel::Tracer;
use crate::error::{Error, Result};
use crate::gather::View;
use crate::guidance::learn_light_guide;
use crate::rng::{self, Purpose};
use crate::tree::{LightTree, LightTreeBuilder};
use crate::vpl::{Clamp, Emission, LightTracer, Provenance, VplOptions};

/// Sets of VPLs of one scene that have nothing in common but how they were made and the view that they are guided to, each in its
/// tree. For another view they are unbiased as well, but their lights may be elsewhere.
#[derive(Clone, Debug)]
pub struct LightSets {
    sets: Vec<LightSet>,
    options: VplOptions,
    truth: Truth,
}

/// One of them.
#[derive(Clone, Debug)]
pub(super) struct LightSet {
    pub(super) tree: LightTree,
    pub(super) provenance: Provenance,
}

/// How many times as far VPLs are clamped where what that costs is put back. The variance of a VPL near by, in units of the light of a wall of them,
/// falls with the square of this, that of the paths which find such walls hardly grows.
const COMPENSATED: f32 = 4.0;
/// Sets that only plan.
const PLANNING: usize = 4;
/// Fewest sets: those that plan, and as many as an interval needs.
const FEWEST: u32 = PLANNING as u32 + 8;
/// Most sets.
const MOST: u32 = 1024;

impl LightSets {
    /// How many sets there are if nobody says.
    pub const DEFAULT_COUNT: u32 = PLANNING as u32 + 64;

    /// Traces `count` sets, 12 to 1024, of `options.count` VPLs each, with seeds that are functions of `options.seed`, for this truth, guided to
    /// what this view sees ([`learn_light_guide`]). All have one clamp distance. Runs on the current thread pool.
    ///
    /// # Errors
    /// Options out of range; no direct VPLs or no others; the truth of a single set.
    pub fn trace(
        tracer: &Tracer,
        options: &VplOptions,
        count: u32,
        truth: Truth,
        view: &View<'_>,
    ) -> Result<Self> {
        Self::check(count)?;
        if truth == Truth::Vpl {
            return Err(Error::option("truth", truth, "clamped or transport, which need many sets"));
        }
        // Both kinds of light are taken for carried by VPLs.
        if !(options.direct_share > 0.0 && options.direct_share < 1.0) {
            return Err(Error::option("direct share", options.direct_share, "above 0 and below 1"));
        }
        let options = VplOptions { emission: Emission::ByUse, ..options.clone() };
        let tracing = LightTracer::new(tracer, &options)?;
        let seed = rng::key(options.seed, Purpose::Guidance, 0);
        let tracing = learn_light_guide(tracing, view, seed);
        let set = |tracing: &LightTracer<'_>, number: u32| {
            let set = tracing.trace(rng::key(options.seed, Purpose::Replicate, number.into()));
            let tree = LightTree::build(&set, LightTreeBuilder::default());
            LightSet { tree, provenance: set.provenance().clone() }
        };
        let mut first = set(&tracing, 0);
        if (truth, options.clamp) == (Truth::Transport, Clamp::Auto) {
            first.provenance.clamp_distance *= COMPENSATED;
        }
        // Sets are alike: the spacing of one is that of all, and looked for once.
        let clamp_distance = first.provenance.clamp_distance;
        let tracing = tracing.clamped(Clamp::Off);
        let others = (1..count).map(|number| {
            let other = set(&tracing, number);
            LightSet { provenance: Provenance { clamp_distance, ..other.provenance }, ..other }
        });
        let sets = std::iter::once(first).chain(others).collect();
        Ok(Self { sets, options, truth })
    }

    /// # Errors
    /// If `count` sets are too few or too many.
    pub fn check(count: u32) -> Result<()> {
        if !(FEWEST..=MOST).contains(&count) {
            return Err(Error::option("sets", count, format!("{FEWEST} to {MOST}")));
        }
        Ok(())
    }

    /// How many sets.
    pub fn count(&self) -> u32 {
        self.sets.len() as u32
    }

    /// VPLs of all of them.
    pub fn lights(&self) -> u64 {
        self.sets.iter().map(|set| set.provenance.direct + set.provenance.indirect).sum()
    }

    /// VPLs on or towards emitters, of all of them.
    pub fn direct(&self) -> u64 {
        self.sets.iter().map(|set| set.provenance.direct).sum()
    }

    /// Their clamp distance (m).
    pub fn clamp_distance(&self) -> f32 {
        self.sets[0].provenance.clamp_distance
    }

    /// What their mean is to be.
    pub fn truth(&self) -> Truth {
        self.truth
    }

    /// How they were traced, but for the seed and the clamp of each.
    pub fn options(&self) -> &VplOptions {
        &self.options
    }

    /// Those that only plan.
    pub(super) fn planning(&self) -> &[LightSet] {
        &self.sets[..PLANNING]
    }

    /// Those that estimates are made of.
    pub(super) fn estimating(&self) -> &[LightSet] {
        &self.sets[PLANNING..]
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::gather::GatherOptions;
    use crate::scene::builtin;

    fn trace(lights: &VplOptions, count: u32, truth: Truth) -> Result<LightSets> {
        let tracer = Tracer::new(Arc::new(builtin::tiny()));
        let camera = &tracer.scene().cameras()[0];
        let view = View { camera, size: [16, 16], gather: GatherOptions::default(), seed: 1 };
        LightSets::trace(&tracer, lights, count, truth, &view)
    }

    #[test]
    fn no_two_sets_have_a_light_in_common() {
        let lights = VplOptions { count: 50, ..VplOptions::default() };
        let sets = trace(&lights, 33, Truth::Transport).unwrap();
        let places = |set: &LightSet| {
            let bits = |light: &crate::vpl::Vpl| light.position.to_array().map(f32::to_bits);
            set.tree.lights().iter().map(|light| bits(&light)).collect::<Vec<_>>()
        };
        let mut all: Vec<_> = sets.sets.iter().flat_map(places).collect();
        let count = all.len();
        assert!(count > 33 * 30, "{count}");
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count, "lights that are in two sets");
        let clamped = trace(&lights, 12, Truth::Clamped).unwrap().clamp_distance();
        assert_eq!(sets.clamp_distance(), COMPENSATED * clamped);
    }

    #[test]
    fn sets_that_could_not_have_that_mean_are_refused() {
        let lights = VplOptions { count: 50, ..VplOptions::default() };
        let refused = |lights: &VplOptions, count, truth, what: &str| {
            let message = trace(lights, count, truth).unwrap_err().to_string();
            assert!(message.contains(what), "{message}");
        };
        refused(&lights, 11, Truth::Transport, "12 to 1024");
        refused(&lights, 12, Truth::Vpl, "clamped or transport");
        for direct_share in [0.0, 1.0] {
            refused(&VplOptions { direct_share, ..lights.clone() }, 12, Truth::Transport, "direct share");
        }
    }
}
