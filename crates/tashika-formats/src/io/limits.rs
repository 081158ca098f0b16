//! Limits on the memory and the included files of a scene.
//!
//! A small file can use the same bytes a million times, or include itself. Such a mistake must not
//! fill the memory or the stack.
//!
//! Held to this by the tests below, and by the suite's `damaged_*` tests of the formats.

use std::cell::Cell;
use std::collections::BTreeSet;

use super::notes::quoted;
use crate::error::{Error, Location, Result};

/// Bytes permitted and left for one purpose.
#[derive(Debug)]
pub(super) struct Budget {
    left: Cell<u64>,
    limit: u64,
    purpose: &'static str,
}

impl Budget {
    /// Permits `limit` bytes.
    pub(super) fn new(limit: u64, purpose: &'static str) -> Self {
        Self { left: Cell::new(limit), limit, purpose }
    }

    /// Bytes that have not been taken.
    pub(super) fn left(&self) -> u64 {
        self.left.get()
    }

    /// Takes `bytes`, or refuses the item at `at`.
    pub(super) fn take(&self, bytes: u64, at: &Location) -> Result<()> {
        match self.left().checked_sub(bytes) {
            Some(left) => {
                self.left.set(left);
                Ok(())
            }
            None => Err(Error::invalid(
                at.clone(),
                format!("{bytes} more bytes of {}", self.purpose),
                format!("at most {} bytes in the whole scene", self.limit),
            )),
        }
    }
}

/// Limits on files that include each other: the depth of the stack and the work are bounded.
#[derive(Debug)]
pub(super) struct Includes {
    /// Largest number of inclusions in all.
    files: usize,
    /// Largest number of files nested in each other, the scene's own included.
    depth: usize,
    included: usize,
    /// Names of the files included so far. `bytes` is the sum of their lengths, each file counted
    /// once; `repeated` is the sum over all repeated inclusions.
    known: BTreeSet<String>,
    bytes: u64,
    repeated: u64,
}

/// Bytes of repeated files permitted in every scene; chosen.
const FREE_REPETITIONS: u64 = 1 << 25;

/// Further bytes of repeated files for each byte of the different files; chosen.
const MAX_REPETITIONS: u64 = 8;

impl Includes {
    /// Permits `files` inclusions in all, and `depth` files nested in each other.
    pub(super) fn new(files: usize, depth: usize) -> Self {
        Self { files, depth, included: 0, known: BTreeSet::new(), bytes: 0, repeated: 0 }
    }

    /// Counts one more file, named at `at` while `open` files are being read.
    pub(super) fn enter(&mut self, name: &str, open: usize, at: &Location) -> Result<()> {
        self.included += 1;
        if open < self.depth && self.included <= self.files {
            return Ok(());
        }
        let found = format!("include of {}, file {} at depth {open}", quoted(name), self.included);
        let (files, most) = (self.files, self.depth);
        let expected =
            format!("at most {files} included files, {most} deep in each other: does it include itself?");
        Err(Error::invalid(at.clone(), found, expected))
    }

    /// Counts the bytes of an included file. This bounds the time for a small file that includes a
    /// large one a thousand times.
    pub(super) fn count(&mut self, name: &str, bytes: u64, at: &Location) -> Result<()> {
        if self.known.insert(name.to_owned()) {
            self.bytes += bytes;
            return Ok(());
        }
        self.repeated = self.repeated.saturating_add(bytes);
        let most = FREE_REPETITIONS.saturating_add(self.bytes.saturating_mul(MAX_REPETITIONS));
        if self.repeated <= most {
            return Ok(());
        }
        let found =
            format!("include of {}, with {} bytes of files included again", quoted(name), self.repeated);
        let expected = format!("at most {most} of them in a scene of {} bytes", self.bytes);
        Err(Error::invalid(at.clone(), found, expected))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_is_gone_and_what_is_refused_is_not() {
        let (budget, at) = (Budget::new(10, "texels"), Location::file("a"));
        assert!(budget.take(7, &at).is_ok());
        let error = budget.take(4, &at).unwrap_err().to_string();
        assert_eq!(error, "a: 4 more bytes of texels; expected at most 10 bytes in the whole scene");
        assert!(budget.take(3, &at).is_ok() && budget.left() == 0);
    }

    #[test]
    fn files_are_counted_and_may_not_nest_too_deep() {
        let (mut includes, at) = (Includes::new(2, 2), Location::file("a"));
        assert!(includes.enter("b", 1, &at).is_ok());
        let error = includes.enter("c", 2, &at).unwrap_err().to_string();
        let expected = "a: include of \"c\", file 2 at depth 2; expected at most 2 included files, 2 deep in each other: does it include itself?";
        assert_eq!(error, expected);
        assert!(includes.enter("b", 1, &at).is_err());
    }

    #[test]
    fn the_same_file_again_and_again_is_refused_before_it_takes_long() {
        let (mut includes, at) = (Includes::new(10_000, 2), Location::line("a", 1));
        let size = 1 << 20;
        // The first inclusion, and 32 + 8 repetitions.
        let times = (0..1000).take_while(|_| includes.count("b", size, &at).is_ok()).count();
        assert_eq!(times, 41);
        let error = includes.count("b", size, &at).unwrap_err().to_string();
        assert!(
            error.starts_with("a:1: include of \"b\", with 44040192 bytes of files included again"),
            "{error}"
        );
        assert!((0..1000).all(|i| includes.count(&format!("c{i}"), size, &at).is_ok()), "others");
    }
}
