//! Results of several seeds for the same pixels, together.
//!
//! A trial is one pixel with one seed. Of all trials of a pool, with the error
//! `e = |L − L_r| / L_r` of the luminance:
//!
//! ```text
//! within = #(e ≤ ε) / #trials          kept = #(claims whose interval holds L_r) / #claims
//! ```
//!
//! Each share has its Clopper–Pearson interval. Quantiles of `e` use the nearest rank.
//! [`report::compare`](crate::report::compare()) computes the errors and judges the claims. A trial
//! whose estimate is not finite has an infinite error.
//!
//! # Assumption
//! The interval assumes that trials are independent. With one seed, the trials are pixels drawn at
//! random, and the interval applies to the whole image. With more seeds, it applies to *these
//! pixels* only: their trials are independent, and pixels of different difficulty only make the
//! interval too wide. The interval of a pool with one seed shows how far the drawn pixels may
//! differ from the rest of the image.
//!
//! # Held to this by
//! `experiment::tests`.

use std::path::Path;

use crate::error::Result;
use crate::film::{Film, RenderFilm, Stop, keys};
use crate::report::{Claims, Comparison, Named, Tolerance, compare};
use crate::stats::{Interval, clopper_pearson};

/// Number of trials with a property, among those that could have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Number of trials with the property.
    pub count: u64,
    /// Number of trials that could have the property.
    pub of: u64,
}

impl Share {
    /// Share of the trials; `None` without trials.
    pub fn value(&self) -> Option<f64> {
        (self.of > 0).then(|| self.count as f64 / self.of as f64)
    }

    /// Clopper–Pearson interval of the share at [`Claims::CONFIDENCE`].
    pub fn interval(&self) -> Interval {
        clopper_pearson(self.count, self.of, Claims::CONFIDENCE)
    }
}

/// Trials of a cell, with their errors, claims and costs.
#[derive(Clone, Debug)]
pub struct Pool {
    tolerance: Tolerance,
    errors: Vec<f64>,
    claims: Share,
    claiming: Share,
    budget_hit: u64,
    pairs: f64,
    rays: f64,
}

impl Pool {
    /// Returns a pool without trials, for a tolerance.
    pub fn new(tolerance: Tolerance) -> Self {
        let none = Share { count: 0, of: 0 };
        Self {
            tolerance,
            errors: Vec::new(),
            claims: none,
            claiming: none,
            budget_hit: 0,
            pairs: 0.0,
            rays: 0.0,
        }
    }

    /// Adds the pixels that are rendered in both films. Returns the comparison of the films.
    ///
    /// # Errors
    /// As [`compare`](crate::report::compare()).
    pub fn add(&mut self, film: &Film, reference: &Film) -> Result<Comparison> {
        let name = film.metadata().text(keys::METHOD).unwrap_or("estimate");
        let image = Named { name: Path::new(name), film };
        let reference = Named { name: Path::new("the reference"), film: reference };
        let comparison = compare(image, reference, &self.tolerance)?;
        if let Some(claims) = &comparison.claims {
            // References of experiments are exact or converged.
            self.claims.count += claims.inside;
            self.claims.of += claims.of;
        }
        let (read, truth) = (RenderFilm::of(film), RenderFilm::of(reference.film));
        for (i, ((x, y), error)) in film.window().pixels().zip(&comparison.errors).enumerate() {
            if !(read.is_rendered(i) && truth.is_rendered(i)) {
                continue;
            }
            let record = read.at(x, y);
            if record.claim.is_some() && record.stop != Stop::Budget {
                self.claiming.of += 1;
                self.claiming.count += u64::from(*error <= self.tolerance.relative);
            }
            self.errors.push(if error.is_nan() { f64::INFINITY } else { *error });
            self.budget_hit += u64::from(record.stop == Stop::Budget);
            self.pairs += record.pairs as f64;
            self.rays += record.rays as f64;
        }
        Ok(comparison)
    }

    /// Number of trials: pixels times seeds.
    pub fn trials(&self) -> u64 {
        self.errors.len() as u64
    }

    /// Number of trials within the tolerance, of all trials.
    pub fn within(&self) -> Share {
        let count = self.errors.iter().filter(|error| **error <= self.tolerance.relative).count() as u64;
        Share { count, of: self.trials() }
    }

    /// Number of trials within the tolerance, among the trials that claim something within their
    /// budget.
    pub fn claiming_within(&self) -> Share {
        self.claiming
    }

    /// Number of claims whose interval covers the reference, among all claims.
    pub fn claims(&self) -> Share {
        self.claims
    }

    /// Trials that ran out of budget.
    pub fn budget_hit(&self) -> u64 {
        self.budget_hit
    }

    /// Mean of the errors that are finite; infinite if none is.
    pub fn mean(&self) -> f64 {
        let finite = self.errors.iter().filter(|error| error.is_finite());
        let count = finite.clone().count();
        if count > 0 { finite.sum::<f64>() / count as f64 } else { f64::INFINITY }
    }

    /// The error that `percent` of the trials do not exceed, 1 to 100: 100 is the worst. Infinite
    /// without trials.
    pub fn quantile(&self, percent: u64) -> f64 {
        let mut errors = self.errors.clone();
        if errors.is_empty() {
            return f64::INFINITY;
        }
        let rank = (self.trials() * percent).div_ceil(100).max(1);
        *errors.select_nth_unstable_by(rank as usize - 1, f64::total_cmp).1
    }

    /// Mean number of pairs of a trial.
    pub fn pairs_per_pixel(&self) -> f64 {
        self.pairs / self.trials().max(1) as f64
    }

    /// Mean number of rays of a trial.
    pub fn rays_per_pixel(&self) -> f64 {
        self.rays / self.trials().max(1) as f64
    }
}
