//! Pairs of a light cluster and a gather cluster: their bounds, splits and draws.
//!
//! ```text
//! R = I_C W_G M_ub G_ub T_ub     ≥ luminance of I_C W_G · M G V for every member (W·m⁻²·sr⁻¹)
//! ```
//!
//! `I_C` is the sum of the luminances of the cluster's lights, and `W_G` the sum over its points of
//! the largest channel of the weight. `M_ub` bounds the largest channel of the material term,
//! `G_ub` the geometric term, and `T_ub` the transmittance of homogeneous fog (1 without fog).
//! Suppose that a member `(i, j)` is drawn with probability `I_i / I_C · w_j / W_G` and divided by
//! that probability. Its luminance is then at most `R`, since visibility is at most 1.
//!
//! # Guarantee
//! The bound `M_ub G_ub` of a pair is the smaller of the one computed for the pair and that of its
//! parent. Therefore it never grows towards the leaves, and every bound still holds. Tested by
//! `cut::tests::bounds`.

use std::ops::Range;

use super::terms::Term;
use crate::bounds::{
    Reflector, Towards, UpperMaterial, UpperScattering, upper_geometric, upper_transmittance,
};
use crate::contribution::ContributionKernel;
use crate::gather::GatherPoint;
use crate::math::Vec3;
use crate::rng::Stream;
use crate::tree::{GatherTree, LightCluster, LightTree};

/// Least distance (m). It keeps pairs at the same position comparable if there is no clamp.
const LEAST_DISTANCE: f64 = 1e-6;

/// The clusters of one pixel's sum.
#[derive(Debug)]
pub struct Clusters<'a, B> {
    /// Tree whose nodes are clusters of lights.
    pub lights: &'a LightTree,
    /// Tree whose nodes are clusters of gather points.
    pub points: &'a GatherTree<UpperScattering<B>>,
    /// Kernel that evaluates terms.
    pub contribution: ContributionKernel<'a>,
}

impl<B> Clone for Clusters<'_, B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B> Copy for Clusters<'_, B> {}

/// `M_ub G_ub`, an upper bound of `M G` for all terms of a pair (m⁻²·sr⁻¹; sr⁻¹ for directional
/// lights).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct KernelBound(pub f32);

/// `R`, an upper bound of the luminance of a drawn term of a pair (W·m⁻²·sr⁻¹).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct RadianceBound(pub f64);

/// A pair of a light cluster and a gather cluster, which stands for the terms `Σ_{j∈G} Σ_{i∈C}`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Cluster of the light tree.
    pub light: LightCluster,
    /// Node of the gather tree.
    pub points: u32,
    /// The smaller of the bound computed for the pair and its parent's bound.
    pub upper: KernelBound,
}

/// Builds the tree over the gather points of a pixel, with bounds of their materials at its nodes.
pub fn gather_tree<B: UpperMaterial>(points: &[GatherPoint]) -> GatherTree<UpperScattering<B>> {
    let bound_of = |point: &GatherPoint| match point.phase {
        None => UpperScattering::of_surface(&Reflector {
            bsdf: point.bsdf,
            frame: point.frame,
            wo: point.wo,
            geometric_normal: point.geometric_normal,
        }),
        Some(phase) => UpperScattering::of_medium(point.before(), phase),
    };
    GatherTree::build(points, bound_of, UpperScattering::merge)
}

impl<B: UpperMaterial> Clusters<'_, B> {
    /// Returns the pair of all terms of each instant.
    pub fn roots(&self) -> impl Iterator<Item = Pair> {
        self.points.roots().iter().filter_map(|&(instant, points)| {
            let light = self.lights.root_at(instant)?;
            Some(self.bounded(Pair { light, points, upper: KernelBound(f32::INFINITY) }))
        })
    }

    /// The bound `R` of the luminance of a drawn term.
    pub fn upper(&self, pair: &Pair) -> RadianceBound {
        RadianceBound(if pair.upper.0 > 0.0 { self.weight(pair) * f64::from(pair.upper.0) } else { 0.0 })
    }

    /// Approximate ratio of the root mean square of a drawn term to its bound. It takes into
    /// account only that terms differ by distance.
    ///
    /// ```text
    /// √(mean G²) / G_ub = a/b
    /// ```
    ///
    /// The mean is over lights that are spread evenly over a plane, from the nearest distance `a`
    /// of the pair to the farthest `b`: `∫ 2 d dd / d⁴ = 1/a² − 1/b²` over an area of `b² − a²`.
    /// Both distances are at least the clamp distance.
    pub fn importance_of_bound(&self, pair: &Pair) -> f64 {
        let lights = self.lights.bounds(&pair.light);
        if lights.reaches_infinity() {
            return 1.0;
        }
        let (lights, points) = (lights.aabb, &self.points.nodes()[pair.points as usize].aabb);
        let between = (lights.lo - points.hi).max(points.lo - lights.hi).max(Vec3::ZERO);
        let across = (lights.hi - points.lo).max(points.hi - lights.lo);
        let clamp_distance = self.contribution.clamp_distance();
        let [nearest, farthest] =
            [between, across].map(|d| f64::from(d.length().max(clamp_distance)).max(LEAST_DISTANCE));
        nearest / farthest
    }

    /// Number of terms of the pair.
    pub fn terms(&self, pair: &Pair) -> u64 {
        u64::from(pair.light.count) * u64::from(self.points.nodes()[pair.points as usize].count)
    }

    /// Ranges of a pair's gather points and lights in the sorted orders of their trees.
    pub fn members(&self, pair: &Pair) -> (Range<usize>, Range<usize>) {
        let points = &self.points.nodes()[pair.points as usize];
        (points.first as usize..(points.first + points.count) as usize, pair.light.lights())
    }

    /// All terms of a pair, light by light.
    pub fn all_terms(&self, pair: &Pair) -> impl Iterator<Item = Term> + use<B> {
        let light = pair.light;
        let points = &self.points.nodes()[pair.points as usize];
        let (first, end) = (points.first, points.first + points.count);
        (light.first..light.first + light.count)
            .flat_map(move |light| (first..end).map(move |point| Term { light, point }))
    }

    /// Returns true if the pair is a single term.
    pub fn is_single(&self, pair: &Pair) -> bool {
        self.terms(pair) == 1
    }

    /// Returns true if the term belongs to the pair.
    pub fn holds(&self, pair: &Pair, term: Term) -> bool {
        let points = &self.points.nodes()[pair.points as usize];
        pair.light.holds(term.light) && term.point.wrapping_sub(points.first) < points.count
    }

    /// Draws a term of a pair with probability `I_i / I_C · w_j / W_G`.
    pub fn draw(&self, pair: &Pair, stream: &mut Stream) -> Term {
        let light = self.lights.draw(&pair.light, stream.uniform_f64());
        Term { light, point: self.points.draw(pair.points, stream.uniform_f64()) }
    }

    /// `I_C W_G`.
    pub fn weight(&self, pair: &Pair) -> f64 {
        let points = &self.points.nodes()[pair.points as usize];
        self.lights.luminance(&pair.light) * f64::from(points.weight)
    }

    /// Inverse of the probability of [drawing](Clusters::draw) a term of a pair.
    pub fn inverse_probability(&self, pair: &Pair, term: Term) -> f64 {
        self.weight(pair) / self.weight_of_term(term)
    }

    /// `I_i w_j`.
    pub fn weight_of_term(&self, term: Term) -> f64 {
        let point = self.points.point(term.point);
        self.lights.luminance_of(term.light) * f64::from(point.weight.max_channel())
    }

    /// Splits a pair, which must not be single. The cluster whose box has the longer diagonal is
    /// split. Both halves inherit the bound of the whole.
    ///
    /// Lights at infinity have no box. They count as infinitely far apart, and are split before the
    /// points.
    pub fn split(&self, pair: &Pair) -> [Pair; 2] {
        let points = &self.points.nodes()[pair.points as usize];
        let light_is_longer = || {
            let bounds = self.lights.bounds(&pair.light);
            bounds.reaches_infinity() || bounds.aabb.diagonal() >= points.aabb.diagonal()
        };
        let cut_lights = |lights: [LightCluster; 2]| lights.map(|light| Pair { light, ..*pair });
        match (self.lights.children(&pair.light), points.children) {
            (Some(lights), None) => cut_lights(lights),
            (Some(lights), Some(_)) if light_is_longer() => cut_lights(lights),
            (_, Some(points)) => points.map(|points| Pair { points, ..*pair }),
            (None, None) => unreachable!("a single term is not split"),
        }
    }

    /// Computes the bound of the pair and keeps the smaller of it and the pair's present bound.
    pub fn bounded(&self, pair: Pair) -> Pair {
        let lights = self.lights.bounds(&pair.light);
        let towards = Towards::between(&lights, &self.points.nodes()[pair.points as usize].aabb);
        let geometric = upper_geometric(&lights, &towards, self.contribution.clamp_distance());
        // If no light arrives, the material term may be infinite, and 0 · ∞ would be NaN.
        let mut own = if geometric > 0.0 {
            (geometric * self.points.material(pair.points).upper_material(&towards)).next_up()
        } else {
            0.0
        };
        let extinction = self.contribution.least_extinction();
        if extinction > 0.0 {
            own = (own * upper_transmittance(extinction, &towards)).next_up();
        }
        Pair { upper: KernelBound(own.min(pair.upper.0)), ..pair }
    }
}
