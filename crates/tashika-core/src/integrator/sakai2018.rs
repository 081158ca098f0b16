//! Pairs of clusters as strata: a confidence interval for supersampled effects, with diffuse
//! bounds.
//!
//! Hirokazu Sakai, Kosuke Nabata, Shinya Yasuaki, Kei Iwasaki. "Error Estimation for Many-Light
//! Rendering with Supersampling." SIGGRAPH Asia 2018 Technical Briefs.
//!
//! ```text
//! L̂ = Σ_CG ½ (y₁ + y₂)               y = W_G I_C M G V of a light and a gather point drawn with probability I_i / I_C · w_j / W_G
//! ΔL̂ = t_α √(Σ_CG s_CG²) ≤ ε L̂        s_CG² = ¼ (y₁ − y₂)²
//! σ_CG² ≈ ¼ (W_G I_C M_ub G_ub)²     predicted for the choice of the pair that is split
//! ```
//!
//! # Differences
//! Details that the source leaves open, and deviations from it:
//! * The source bounds diffuse materials only. [`UpperConstant`] bounds any BRDF by its maximum
//!   over all directions. For diffuse materials this is the bound of the source. For glossy
//!   materials the bounds hold as well, but do not depend on the direction of reflection.
//! * The degrees of freedom of `t` are the number of pairs. The rule is applied from 32 pairs on
//!   (`min_pairs` in the metadata).
//! * Both terms are redrawn for both children of a split. A pair that is a single term is
//!   evaluated, without variance.
//! * Lights from infinity are split before gather points. The bound of a pair is the smaller of the
//!   bound computed for it and the bound of its parent.
//! * The interval is about luminance, without emission seen directly.
//!
//! Tested by the suite's `cuts`.

use super::{ControlOptions, Estimates, Integrator, Lights, MANY_PAIRS, Published, Scope, Setting};
use crate::bounds::UpperConstant;
use crate::cut::FreshStrata;
use crate::film::Metadata;
use crate::scene::Abilities;

/// Confidence intervals for supersampled effects (Sakai 2018).
#[derive(Clone, Copy, Debug)]
pub(super) struct Sakai2018<'a>(Published<'a>);

impl<'a> Sakai2018<'a> {
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

impl Integrator for Sakai2018<'_> {
    fn name(&self) -> &'static str {
        "sakai2018"
    }

    fn abilities(&self) -> Abilities {
        Abilities::ALL
    }

    fn describe(&self, metadata: &mut Metadata) {
        self.0.describe(metadata);
    }

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        self.0.begin::<UpperConstant, FreshStrata>(setting)
    }
}
