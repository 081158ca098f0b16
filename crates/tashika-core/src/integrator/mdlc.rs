//! Multidimensional Lightcuts: one representative for each pair of clusters, and one cut for all
//! gather points of a pixel.
//!
//! Bruce Walter, Adam Arbree, Kavita Bala, Donald P. Greenberg. "Multidimensional Lightcuts." ACM
//! Transactions on Graphics 25(3), 2006, 1081–1088. doi:10.1145/1141911.1141997
//!
//! ```text
//! L_CG ≈ M_rs G_rs V_rs Σ I_i Σ w_j      (r, s): representatives of light cluster C and gather cluster G
//! error ≤ M_ub G_ub V_ub Σ I_i Σ w_j
//! ```
//!
//! The product graph of the light tree and the gather tree is refined from the pair of roots on.
//! Each step splits the pair with the largest bound, until no bound exceeds `ε` times the estimate
//! or the cut has 1000 pairs.
//!
//! # Differences
//! Details that the source leaves open, and deviations from it:
//! * Representatives are drawn in proportion to intensity and weight, for each pixel; the source
//!   keeps 32 for each light node, and one for each gather node. A child pair that holds its
//!   parent's representatives takes over their value.
//! * The node to split is the one with the longer diagonal of its box, as in Iwasaki 2019; the
//!   source uses another heuristic.
//! * Gather points are split in the middle of a coordinate of the position, or of the normal or
//!   mirror direction. In media, the direction is that in which the path arrived, times the mean
//!   cosine of the phase function. There is no dimension of time.
//! * Gather points and VPLs in media are the points at which paths scatter, drawn by free flights.
//!   If one homogeneous medium fills the scene, transmittance is bounded by its value at the
//!   shortest distance; else by 1.
//! * Materials are bounded by [`UpperAnalytic`]; the source bounds them over cube maps of
//!   directions. The bound of a pair is the smaller of the bound computed for it and the bound of
//!   its parent.
//! * Lights from infinity are split before gather points. Bounds and estimates are compared by
//!   luminance.
//! * "The estimate" excludes emission seen directly. No claim is made about the error.
//!
//! Tested by the suite's `cuts` and `volume_lights`.

use super::{ControlOptions, Estimates, Integrator, Lights, Published, Scope, Setting};
use crate::bounds::UpperAnalytic;
use crate::cut::Representatives;
use crate::film::Metadata;
use crate::scene::Abilities;

/// Default for the largest cut, in pairs.
const MAX_CUT: u64 = 1000;

/// Multidimensional Lightcuts (Walter 2006).
#[derive(Clone, Copy, Debug)]
pub(super) struct Mdlc<'a>(Published<'a>);

impl<'a> Mdlc<'a> {
    /// Returns the method for these lights.
    pub(super) fn new(lights: Lights<'a>, options: &ControlOptions) -> Self {
        Self(Published {
            lights,
            scope: Scope::Pixel,
            rule: options.largest_upper(),
            max_pairs: options.max_pairs.unwrap_or(MAX_CUT),
            seed: options.seed,
        })
    }
}

impl Integrator for Mdlc<'_> {
    fn name(&self) -> &'static str {
        "mdlc"
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
