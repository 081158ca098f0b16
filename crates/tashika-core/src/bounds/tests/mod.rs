//! Tests of bounds against random members.

mod analytic;
mod brushed;
pub(super) mod cases;
mod cube_map;
mod geometry;
mod reflector;
mod scattering;

/// Returns the given number of rounds, or in the slow suite (`TASHIKA_SLOW_TESTS=1`) thirty times
/// as many. There each bound is compared with more than 10⁷ members.
pub(crate) fn many(rounds: usize) -> usize {
    if std::env::var_os("TASHIKA_SLOW_TESTS").is_some() { 30 * rounds } else { rounds }
}
