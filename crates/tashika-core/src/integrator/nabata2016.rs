//! Clusters of lights as strata: the estimate of a shading point with a confidence interval.
//!
//! Kosuke Nabata, Kei Iwasaki, Yoshinori Dobashi, Tomoyuki Nishita. "An Error Estimation Framework
//! for Many-Light Rendering." Computer Graphics Forum 35(7) (Pacific Graphics 2016), 431–439.
//! doi:10.1111/cgf.13040
//!
//! ```text
//! L̂ = Σ_C ½ (y₁ + y₂)               y = M G V I_C of a light drawn from cluster C with probability I_i / I_C
//! ΔL̂ = t_α √(Σ_C s_C²) ≤ ε L̂         s_C² = ¼ (y₁ − y₂)²
//! σ_C² ≈ ¼ (M_ub G_ub I_C)²          predicted for the choice of the cluster that is split
//! ```
//!
//! # Differences
//! Details that the source leaves open, and deviations from it:
//! * The source does not state the degrees of freedom of `t`. They are the number of clusters here.
//! * The source does not state the first cut. The rule is applied here from 32 clusters on
//!   (`min_pairs` in the metadata): at the root, two lights in shadow would end the pixel as black.
//! * Both terms are redrawn for both children of a split. A cluster of one light is evaluated,
//!   without variance.
//! * Clusters have the same order by the prediction and by `M_ub G_ub I_C`, so the code compares
//!   the latter. The bound of a cluster is the smaller of the bound computed for it and the bound
//!   of its parent; materials are bounded by [`UpperAnalytic`].
//! * No visibility caching: every term traces its own segment.
//! * The interval is about luminance.
//! * The source renders one shading point for each pixel. If there are several here, each has its
//!   own cut and meets the rule; the half-width of the pixel is `√Σ ΔL̂²`.
//! * "The estimate" excludes emission seen directly.
//!
//! Tested by the suite's `cuts`.

use super::{ControlOptions, Estimates, Integrator, Lights, MANY_PAIRS, Published, Scope, Setting};
use crate::bounds::UpperAnalytic;
use crate::cut::FreshStrata;
use crate::film::Metadata;
use crate::scene::Abilities;

/// The error estimation framework of Nabata 2016.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nabata2016<'a>(Published<'a>);

impl<'a> Nabata2016<'a> {
    /// Returns the method for these lights.
    pub(super) fn new(lights: Lights<'a>, options: &ControlOptions) -> Self {
        Self(Published {
            lights,
            scope: Scope::Point,
            rule: options.interval(),
            max_pairs: options.max_pairs.unwrap_or(MANY_PAIRS),
            seed: options.seed,
        })
    }
}

impl Integrator for Nabata2016<'_> {
    fn name(&self) -> &'static str {
        "nabata2016"
    }

    fn abilities(&self) -> Abilities {
        Abilities::ALL
    }

    fn describe(&self, metadata: &mut Metadata) {
        self.0.describe(metadata);
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        self.0.begin::<UpperAnalytic, FreshStrata>(setting)
    }
}
