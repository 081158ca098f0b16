//! Experiments: methods compared with the exact sum of chosen pixels.
//!
//! The truth of every experiment is `L = B + Σ_j Σ_i w_j M_ji G_ji V_ji I_i` of one pixel: one
//! given set of VPLs and one given set of gather points. It does not depend on a method's seed. So
//! it is computed once ([`Pixels::render`] with the exact integrator), and any number of methods
//! are compared with it.
//!
//! * [`Pixels`]: all of a window, or some of it at random.
//! * [`Ground`]: setting, lights, pixels and their truth; it runs a [`Cell`], one method with one
//!   setting and several seeds.
//! * [`Group`]: pixels with a common property, judged by themselves.
//! * [`converged()`]: the pixels of a path-traced truth that are precise enough to judge by, where
//!   the truth is light transport.
//! * [`OtherSet`]: differences between a picture and one by another set of VPLs.
//! * [`Pool`]: results of all seeds and pixels together.
//! * [`Row`]: the stored form of a pool, and [`Table`] the shown one.
//! * [`Search`]: the setting at which a method just reaches a goal.
//!
//! Seconds come from a clock of the caller, since the library reads none; no other number depends
//! on that clock.
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
