//! Small pairs, term by term: what each would contribute if nothing were in the way.
//!
//! ```text
//! u_ij = luminance of w_j M_ji G_ji I_i          U = Σ u_ij over the terms of the pair
//! ```
//!
//! A term drawn with probability `u_ij / U` has, divided by that probability, the luminance `U V_ij`: within `[0, U]`, and of a variance
//! that only visibility makes. `U` is the smallest bound that a pair can have without a ray; bounds of clusters are some times larger,
//! and cost as much as a hundred terms.
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

/// Where the values of a pair are, of which others are parts: point by point, and for each all lights.
#[derive(Clone, Copy, Debug)]
struct Block {
    values: u32,
    first_light: u32,
    first_point: u32,
    lights: u32,
}

/// The values of all pairs that have been listed.
#[derive(Clone, Debug, Default)]
pub struct ListedTerms {
    values: Vec<f32>,
    blocks: Vec<Block>,
}

impl ListedTerms {
    /// Forgets all pairs but keeps the memory.
    pub fn clear(&mut self) {
        self.values.clear();
        self.blocks.clear();
    }

    /// Lists a pair if it is small enough; `parent` is what is known of the pair it is a half of.
    pub fn list<B: UpperMaterial>(
        &mut self,
        listing: &Listing,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        parent: Option<Listed>,
    ) -> Option<Listed> {
        if let Some(parent) = parent {
            return Some(self.sum(clusters, pair, parent.block));
        }
        if clusters.terms(pair) > listing.most {
            return None;
        }
        let (points, lights) = clusters.members(pair);
        let (block, values) = (self.blocks.len() as u32, self.values.len() as u32);
        let members = (&clusters.points.points()[points.clone()], &clusters.lights.lights()[lights.clone()]);
        listing.transport.list(members.0, members.1, &mut self.values);
        self.blocks.push(Block {
            values,
            first_light: lights.start as u32,
            first_point: points.start as u32,
            lights: lights.len() as u32,
        });
        Some(self.sum(clusters, pair, block))
    }

    fn sum<B: UpperMaterial>(&self, clusters: &Clusters<'_, B>, pair: &Pair, block: u32) -> Listed {
        let mut listed = Listed { block, lit: 0, total: 0.0 };
        for (_, row) in self.rows(clusters, pair, block) {
            let (sum, lit) = sum_of(row);
            listed.total += sum;
            listed.lit += lit;
        }
        listed
    }

    /// The largest `u_ij / (I_i w_j)` of a listed pair (m⁻²·sr⁻¹).
    pub fn largest_share<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        listed: &Listed,
    ) -> f64 {
        let lights = &clusters.lights.lights()[clusters.members(pair).1];
        let mut largest = 0.0_f64;
        for (point, row) in self.rows(clusters, pair, listed.block) {
            let weight = f64::from(clusters.points.point(point).weight.max_channel());
            for (&value, light) in row.iter().zip(lights) {
                let share = f64::from(value) / (f64::from(light.intensity.luminance()) * weight);
                largest = largest.max(share);
            }
        }
        largest
    }

    /// The values of a pair that is part of a block: for each point, its number and one value a light.
    fn rows<B: UpperMaterial>(
        &self,
        clusters: &Clusters<'_, B>,
        pair: &Pair,
        block: u32,
    ) -> impl Iterator<Item = (u32, &[f32])> {
        let block = &self.blocks[block as usize];
        let (points, lights) = clusters.members(pair);
        points.map(move |point| {
            let row = block.values as usize + (point - block.first_point as usize) * block.lights as usize;
            let first = row + lights.start - block.first_light as usize;
            (point as u32, &self.values[first..first + lights.len()])
        })
    }

    /// `u` of a term of a listed pair (W·m⁻²·sr⁻¹).
    pub fn unoccluded(&self, listed: &Listed, term: Term) -> f64 {
        let block = &self.blocks[listed.block as usize];
        let row = block.values + (term.point - block.first_point) * block.lights;
        let place = row + term.light - block.first_light;
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
        let first_light = clusters.members(pair).1.start as u32;
        let mut left = x * listed.total;
        let mut last = None;
        for (point, row) in self.rows(clusters, pair, listed.block) {
            for (some, first) in row.chunks(SKIPPED).zip((first_light..).step_by(SKIPPED)) {
                let (sum, lit) = sum_of(some);
                if lit == 0 {
                    continue;
                }
                last = Some((point, first, some));
                if left < sum {
                    return drawn_of(point, first, some, left);
                }
                left -= sum;
            }
        }
        // Where rounding leaves a rest, it is the last one's.
        let (point, first, some) = last.expect("something of the pair is above zero");
        drawn_of(point, first, some, f64::INFINITY)
    }
}

/// Values that a draw skips together.
const SKIPPED: usize = 32;

/// The sum of values, and how many are above zero.
fn sum_of(values: &[f32]) -> (f64, u32) {
    // Eight sums that do not wait for each other.
    let mut sums = [0.0; 8];
    let (eights, rest) = values.as_chunks::<8>();
    for eight in eights {
        for i in 0..8 {
            sums[i] += f64::from(eight[i]);
        }
    }
    for (sum, &value) in sums.iter_mut().zip(rest) {
        *sum += f64::from(value);
    }
    let lit = values.iter().map(|&value| u32::from(value > 0.0)).sum();
    (((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7])), lit)
}

/// The term of one of `values`, of lights from `first` on, at which their running sum exceeds `left`, or else the last above zero.
fn drawn_of(point: u32, first: u32, values: &[f32], mut left: f64) -> Term {
    let mut drawn = first;
    for (light, &value) in (first..).zip(values) {
        if value > 0.0 {
            drawn = light;
            left -= f64::from(value);
            if left < 0.0 {
                break;
            }
        }
    }
    Term { light: drawn, point }
}
