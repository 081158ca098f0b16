//! Experiments: methods held against the exact sum of chosen pixels.
//!
//! The truth of every experiment is `L = B + Σ_j Σ_i w_j M_ji G_ji V_ji I_i` of one pixel: one
//! given set of VPLs and one given set of gather points. It does not depend on a method's seed, so
//! that it is computed once ([`Pixels::render`] with the exact integrator) and the methods are run
//! against it as often as is asked for.
//!
//! * [`Pixels`]: all of a window, or some of it at random.
//! * [`Ground`]: setting, lights, pixels and their truth; it runs a [`Cell`], one method with one
//!   setting and several seeds.
//! * [`Group`]: pixels that have something in common, judged by themselves.
//! * [`converged()`]: which pixels of a path-traced truth can be judged by, where the truth is
//!   light transport.
//! * [`OtherSet`]: by how much another set of VPLs would change a picture.
//! * [`Pool`]: what all seeds and pixels say together.
//! * [`Row`]: the same as it is written down, and [`Table`] as it is shown.
//! * [`Search`]: the setting at which a method just does what is asked of it.
//!
//! Seconds are told by a clock of the caller's, since the library reads none; no other number
//! depends on it.
//!
//! # Held to this by
//! `experiment::tests`.

mod converged;
mod coverage;
mod groups;
mod other_set;
mod page;
mod pool;
mod rows;
mod search;
mod subset;
mod table;

#[cfg(test)]
mod tests;

pub use converged::{converged, until_converged};
pub use coverage::{Cell, Ground, Watch};
pub use groups::{Group, Grouping};
pub use other_set::OtherSet;
pub use page::{page, plots};
pub use pool::{Pool, Share};
pub use rows::{Row, Subject, Told};
pub use search::Search;
pub use subset::{Pixels, subset};
pub use table::{Column, Table};
