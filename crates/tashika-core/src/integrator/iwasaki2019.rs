//! Pairs of clusters as strata, with cube maps that bound glossy BRDFs: the paper from which this
//! project grew.
//!
//! R. Iwasaki, Kosuke Nabata, Hirokazu Sakai, Kei Iwasaki. 2019. "Error Estimation for Many-Light
//! Rendering of Glossy Materials." Two pages.
//!
//! ```text
//! L̂ = Σ_CG ½ (y₁ + y₂)               y = W_G I_C M G V of a light and a gather point drawn with probability I_i / I_C · w_j / W_G
//! ΔL̂ = t_α √(Σ_CG s_CG²) ≤ ε L̂        s_CG² = ¼ (y₁ − y₂)²                    (equation 2)
//! σ_CG² ≈ ¼ (W_G I_C M_ub G_ub)²     predicted for the choice of the pair that is split   (equation 3)
//! ```
//!
//! Each pair has two sampled terms. If `ΔL̂ ≤ ε L̂`, the method stops. Else the pair with the
//! largest predicted variance is split along the cluster with the longer diagonal, and two fresh
//! terms are drawn for each child.
//!
//! # Where it is
//!
//! | symbol | here |
//! |---|---|
//! | `y₁`, `y₂`, `s_CG²` | [`FreshStrata`] |
//! | `ΔL̂ ≤ ε L̂` (equation 2), `t_α` | [`StoppingRule::Interval`](crate::cut::StoppingRule) |
//! | `W_G I_C M_ub G_ub` (equation 3) | [`Clusters`](crate::cut::Clusters) |
//! | the choice of the pair | [`Cut`](crate::cut::Cut) |
//! | `M_ub`, its cube map | [`UpperCubeMap`] |
//! | `G_ub` | [`upper_geometric`](crate::bounds::upper_geometric) |
//!
//! # Differences
//! Details that the source leaves open, and deviations from it:
//! * Equation 3 is printed without the squares on `M_ub` and `G_ub`, which must be a misprint: the
//!   units would differ. With the squares it is the bound of Popoviciu for a variable in `[0, R]`,
//!   where `R = W_G I_C M_ub G_ub`. Pairs have the same order by `R`, so the code compares `R`.
//! * The source does not state the degrees of freedom of `t`. They are the number of pairs here.
//! * The source does not state the first cut. The rule is applied here from 32 pairs on
//!   (`min_pairs` in the metadata): at the root, two terms in shadow would end the pixel as black.
//! * The source projects the cluster of lights onto the cube from one point, which gives no bound
//!   for gather clusters that have an extent. Here the box of all differences between lights and
//!   gather points is projected. Texels, resolution and format: see [`UpperCubeMap`].
//! * The bound of a pair is the smaller of the bound computed for it and the bound of its parent. A
//!   pair that is a single term is evaluated, without variance.
//! * Lights from infinity are split before gather points.
//! * The interval is about luminance, without emission seen directly.
//!
//! Tested by the suite's `cuts`.

use super::{ControlOptions, Estimates, Integrator, Lights, MANY_PAIRS, Published, Scope, Setting};
use crate::bounds::UpperCubeMap;
use crate::cut::FreshStrata;
use crate::film::Metadata;
use crate::scene::Abilities;

/// Error estimation for glossy materials (Iwasaki 2019).
#[derive(Clone, Copy, Debug)]
pub(super) struct Iwasaki2019<'a>(Published<'a>);

impl<'a> Iwasaki2019<'a> {
    /// Returns the method for these lights.
    pub(super) fn new(lights: Lights<'a>, options: &ControlOptions) -> Self {
        Self(Published {
            lights,
            scope: Scope::Pixel,
            rule: options.interval(),
            max_pairs: options.max_pairs.unwrap_or(MANY_PAIRS),
            seed: options.seed,
        })
    }
}

impl Integrator for Iwasaki2019<'_> {
    fn name(&self) -> &'static str {
        "iwasaki2019"
    }

    fn abilities(&self) -> Abilities {
        Abilities::ALL
    }

    fn describe(&self, metadata: &mut Metadata) {
        self.0.describe(metadata);
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        self.0.begin::<UpperCubeMap, FreshStrata>(setting)
    }
}
