//! Bounds on the work and the memory of a scene, in proportion to the bytes of its layers.
//!
//! If each prim of a chain references the next one twice, the work doubles at every level: a file
//! of 3 kB can require as much work as a file of a gigabyte. With `n` bytes of layers, the limit of
//! each resource is
//!
//! ```text
//! limit = first + each · n
//! ```
//!
//! The constants are chosen. They permit a layout of a few lines to reference an asset a thousand
//! times. A scene whose work doubles at every level is refused after about one second, plus two
//! seconds for each megabyte of layers.
//!
//! Held to this by `damaged_usd` of the suite.

use std::cell::Cell;
use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::layers::{LayerId, Layers};
use crate::error::{Error, Location, Result};
use crate::io::notes::shown;

/// A budget of bytes.
#[derive(Debug)]
pub(super) struct Allowance {
    used: Cell<u64>,
    first: u64,
    each: u64,
    most: u64,
    purpose: &'static str,
}

impl Allowance {
    /// Creates the budget of values. Each copy of an array is counted.
    pub fn of_values(most: u64) -> Self {
        Self::new([1 << 30, 1 << 9], most, "values")
    }

    /// Creates the budget of meshes and instances.
    pub fn of_geometry(most: u64) -> Self {
        Self::new([1 << 28, 1 << 8], most, "geometry")
    }

    fn new([first, each]: [u64; 2], most: u64, purpose: &'static str) -> Self {
        Self { used: Cell::new(0), first, each, most, purpose }
    }

    /// Takes an amount from the budget, for the item at `at`.
    ///
    /// # Errors
    /// If the rest of the budget is smaller.
    pub fn take(&self, amount: u64, layers: &Layers<'_>, at: &Location) -> Result<()> {
        let used = self.used.get().saturating_add(amount);
        let limit = self.first.saturating_add(self.each.saturating_mul(layers.bytes())).min(self.most);
        if used > limit {
            let found = format!("{amount} more bytes of {}", self.purpose);
            let expected = format!("at most {limit} bytes of a scene whose layers have {}", layers.bytes());
            return Err(Error::invalid(at.clone(), found, expected));
        }
        self.used.set(used);
        Ok(())
    }
}

/// Steps of composition: sites, and items of lists.
#[derive(Debug, Default)]
pub(super) struct Steps {
    used: Cell<u64>,
    /// Steps of sites that are reached through a chain of more than [`NESTED`] other sites.
    nested: Cell<u64>,
    /// Number of times that each prim's references were followed.
    followed: BTreeMap<(LayerId, u32), u64>,
}

/// Steps permitted in every scene; chosen: about a second.
const FIRST: u64 = 1 << 20;

/// Further steps for each byte of the layers.
const EACH: u64 = 2;

/// Further steps for each byte, up to [`MOST_COPIES`] in all, which deeply nested sites may not
/// use. With them, a layout of a few lines may reference an asset a thousand times.
const EACH_COPY: u64 = 62;

/// Largest number of further steps for sites that are not nested deeply.
const MOST_COPIES: u64 = 7 << 20;

/// Largest length of a chain of sites that does not count as deeply nested. Over this length, work
/// that doubles at each site grows 128-fold.
const NESTED: usize = 7;

impl Steps {
    /// Counts steps of a site that is reached through a chain of `nested` other sites.
    pub fn add(&self, steps: u64, nested: usize) {
        self.used.set(self.used.get().saturating_add(steps));
        if nested > NESTED {
            self.nested.set(self.nested.get().saturating_add(steps));
        }
    }

    /// Counts one more time that the references of a layer's prim are followed.
    pub fn follow(&mut self, site: (LayerId, u32)) {
        *self.followed.entry(site).or_insert(0) += 1;
    }

    /// Checks the number of steps.
    ///
    /// # Errors
    /// If there were too many steps. The error names the prim whose references were followed most
    /// often, or else `at`.
    pub fn check(&self, layers: &Layers<'_>, at: impl FnOnce() -> Location) -> Result<()> {
        let bytes = layers.bytes();
        let nested = FIRST.saturating_add(EACH.saturating_mul(bytes));
        let all = nested.saturating_add(EACH_COPY.saturating_mul(bytes).min(MOST_COPIES));
        let is_nested = self.nested.get() > nested;
        if !is_nested && self.used.get() <= all {
            return Ok(());
        }
        let limit = if is_nested { nested } else { all };
        let expected = format!("at most {limit} prims and items of lists from layers of {bytes} bytes");
        // The prim whose references were followed most often; the first of several.
        let most = self.followed.iter().max_by_key(|&(&site, &times)| (times, Reverse(site)));
        let Some((&site, times)) = most.filter(|(_, times)| **times > 1) else {
            return Err(Error::invalid(at(), "more prims, targets and items of lists than that", expected));
        };
        let named = layers.spec(site).named().map_or_else(|| "a prim".to_owned(), |name| shown(name));
        let how = if is_nested { "references in references that double" } else { "references" };
        let found = format!("{named} read {times} times, by {how}");
        Err(Error::invalid(layers.at(site, &layers.path(site)), found, expected))
    }
}
