//! Lightcuts: one representative for each cluster of lights, one gather point at a time.
//!
//! Bruce Walter, Sebastian Fernandez, Adam Arbree, Kavita Bala, Michael Donikian, Donald P.
//! Greenberg. "Lightcuts: A Scalable Approach to Illumination." ACM Transactions on Graphics 24(3),
//! 2005, 1098–1107. doi:10.1145/1073204.1073318
//!
//! ```text
//! L_C ≈ M_j G_j V_j Σ I_i           j: representative of cluster C      (equation 2)
//! error ≤ M_ub G_ub V_ub Σ I_i      V_ub = 1                            (equation 3)
//! ```
//!
//! From the root on, the cluster with the largest bound is split, until no bound exceeds `ε` times
//! the estimate (section 3.3) or the cut has 1000 clusters. A child that holds its parent's
//! representative takes over its value.
//!
//! # Differences
//! Details that the source leaves open, and deviations from it:
//! * Representatives are drawn in proportion to intensity, as in the source, but for each gather
//!   point instead of once for the image. Each pixel is then an unbiased estimate, and errors are
//!   noise instead of patterns.
//! * Intensities may differ in colour; their luminances are compared.
//! * The light tree is shared by all methods: one tree over all kinds of light, built by separate
//!   options. The source has one tree for each kind, built by greedy clustering.
//! * Every gather point has its own cut. The estimates of a pixel's points are added with the
//!   weights of the points. There are no reconstruction cuts.
//! * Materials are bounded by [`UpperAnalytic`], which also bounds GGX lobes. The bound of a
//!   cluster is the smaller of the bound computed for it and the bound of its parent.
//! * "The estimate" is that of the gather point, without emission seen directly.
//! * No claim is made about the error.
//!
//! Tested by the suite's `cuts`.

use super::{ControlOptions, Estimates, Integrator, Lights, Published, Scope, Setting};
use crate::bounds::UpperAnalytic;
use crate::cut::Representatives;
use crate::film::Metadata;
use crate::scene::Abilities;

/// Default for the largest cut, in clusters.
const MAX_CUT: u64 = 1000;

/// Lightcuts, a cut for each gather point (Walter 2005).
#[derive(Clone, Copy, Debug)]
pub(super) struct Lightcuts<'a>(Published<'a>);

impl<'a> Lightcuts<'a> {
    /// Returns the method for these lights.
    pub(super) fn new(lights: Lights<'a>, options: &ControlOptions) -> Self {
        Self(Published {
            lights,
            scope: Scope::Point,
            rule: options.largest_upper(),
            max_pairs: options.max_pairs.unwrap_or(MAX_CUT),
            seed: options.seed,
        })
    }
}

impl Integrator for Lightcuts<'_> {
    fn name(&self) -> &'static str {
        "lightcuts"
    }

    fn abilities(&self) -> Abilities {
        Abilities::ALL
    }

    fn describe(&self, metadata: &mut Metadata) {
        self.0.describe(metadata);
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        self.0.begin::<UpperAnalytic, Representatives>(setting)
    }
}
