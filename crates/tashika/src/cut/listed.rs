//! Small pairs, term by term: what each would contribute if nothing were in the way.
//!
//! ```text
//! u_ij = luminance of w_j M_ji G_ji I_i          U = Σ u_ij over the terms of the pair
//! ```
//!
//! A term drawn with probability `u_ij / U` has, divided by that probability, the luminance `U V_ij`: within `[0, U]`, and of a variance
//! that only visibility makes. `U` is the smallest bound that a pair can have without a ray; bounds of clusters are some times larger,
//! and cost as much as a dozen terms.
//!
//! Terms are evaluated once, when a pair becomes small enough; what is split from it later takes its values from there.

use super::clusters::{Clusters, Pair};
use super::terms::Term;
use crate::bounds::UpperMaterial;
use crate::transport::Transport;

/// Above the rounding of `f32` in products of a dozen factors: keeps `U` above what rounded terms come to.
const ROUNDING: f64 = 1.0 + 1.0 / 262_144.0;

/// Which pairs are listed.
#[derive(Clone, Copy, Debug)]
pub struct Listing {
    /// Evaluates terms.
    pub transport: Transport,
    /// Terms up to which a pair is listed.
    pub most: u64,
}

/// What is known of a listed pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Listed {
    block: u32,
    /// Terms above zero.
    pub lit: u32,
    /// `U` (W·m⁻²·sr⁻¹).
    pub total: f64,
}

impl Listed {
    /// `U`, rounded up: no drawn term has a higher luminance (W·m⁻²·sr⁻¹).
    pub fn upper(&self) -> f64 {
        self.total * ROUNDING
    }
}

/// Where the values of a pair are, of which others are parts: light by light.
#[derive(Clone, Copy, Debug)]
struct Block {
    values: u32,
    first_light: u32,
    first_point: u32,
    points: u32,
}

/// The values of all pairs that have been listed.
#[derive(Clone, Debug)]
pub struct ListedTerms {
    listing: Listing,
    values: Vec<f32>,
    blocks: Vec<Block>,
}

impl ListedTerms {
    /// No pair yet.
    pub fn new(listing: Listing) -> Self {
        Self { listing, values: Vec::new(), blocks: Vec::new() }
    }

    /// Lists a pair if it is small enough; `parent` is what is known of the pair it is a half of.
    pub fn list<B: UpperMaterial>(
        &mut self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        parent: Option<Listed>,
    ) -> Option<Listed> {
        if let Some(parent) = parent {
            return Some(self.sum(clusters, pair, parent.block));
        }
        if clusters.terms(pair) > self.listing.most {
            return None;
        }
        let points = &clusters.points.nodes()[pair.points as usize];
        let (block, values) = (self.blocks.len() as u32, self.values.len() as u32);
        for term in clusters.all_terms(pair) {
            let (light, point) = (clusters.lights.light(term.light), clusters.points.point(term.point));
            self.values.push(self.listing.transport.unoccluded(point, light).luminance());
        }
        self.blocks.push(Block {
            values,
            first_light: clusters.lights.nodes()[pair.light as usize].first,
            first_point: points.first,
            points: points.count,
        });
        Some(self.sum(clusters, pair, block))
    }

    fn sum<B: UpperMaterial>(&self, clusters: &Clusters<'_, B>, pair: &Pair, block: u32) -> Listed {
        let mut listed = Listed { block, lit: 0, total: 0.0 };
        for term in clusters.all_terms(pair) {
            let value = self.unoccluded(&listed, term);
            listed.total += value;
            listed.lit += u32::from(value > 0.0);
        }
        listed
    }

    /// `u` of a term of a listed pair (W·m⁻²·sr⁻¹).
    pub fn unoccluded(&self, listed: &Listed, term: Term) -> f64 {
        let block = &self.blocks[listed.block as usize];
        let place =
            block.values + (term.light - block.first_light) * block.points + term.point - block.first_point;
        f64::from(self.values[place as usize])
    }

    /// A term of a pair with something above zero, for the uniform number `x` in `[0, 1)`; its probability is `u / Σ u`.
    pub fn draw<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        listed: &Listed,
        x: f64,
    ) -> Term {
        let mut left = x * listed.total;
        let mut drawn = None;
        for term in clusters.all_terms(pair) {
            let value = self.unoccluded(listed, term);
            if value > 0.0 {
                drawn = Some(term);
                left -= value;
                if left < 0.0 {
                    break;
                }
            }
        }
        // Where rounding leaves a rest, it is the last one's.
        drawn.expect("something of the pair is above zero")
    }
}
