//! Experiments: methods compared with the exact sum of chosen pixels.
//!
//! The truth of every experiment is `L = B + Σ_j Σ_i w_j M_ji G_ji V_ji I_i`, the exact sum of a
//! pixel over one given set of VPLs and one given set of gather points. This sum does not depend on
//! a method's seed. It is therefore computed once ([`Pixels::render`] with the exact integrator),
//! and any number of methods are compared with it.
//!
//! * [`Pixels`]: all pixels of a window, or some at random.
//! * [`Ground`]: setting, lights, pixels and their truth; it runs a [`Cell`], one method with one
//!   setting and several seeds.
//! * [`Group`]: pixels with a common property, judged separately.
//! * [`converged()`]: if the truth is light transport, the pixels whose path-traced truth is
//!   precise enough to judge by.
//! * [`OtherSet`]: differences between a picture and the same picture rendered with another set of
//!   VPLs.
//! * [`Pool`]: results of all seeds and pixels together.
//! * [`Row`]: the form in which a pool is stored, and [`Table`] the form in which it is shown.
//! * [`Search`]: the setting at which a method just reaches a goal.
//!
//! The library reads no clock: seconds come from a clock that the caller provides. No other number
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
