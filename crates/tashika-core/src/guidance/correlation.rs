//! Correlation of VPLs: the factor by which the variance of a sum over VPLs grows because a light
//! path leaves several of them, measured at surfaces in view.
//!
//! ```text
//! Var Σ_i c_i ≤ Σ_p (Σ_{i ∈ p} c_i)² = K Σ_i c_i²
//! ```
//!
//! with the contributions `c_i` of VPLs to a gather point, and the groups `p` of VPLs that are
//! drawn together ([`LightTracer::drawn_together`]). Light that enters a room by a door that is
//! ajar leaves groups in which either all VPLs illuminate the room, or none. There `K` is as much
//! as 4; it is less where paths are short or surfaces dark. `K` hardly depends on the number of
//! VPLs, so it is measured with a small set.

use rayon::prelude::*;

use crate::accel::Glass;
use crate::contribution::ContributionKernel;
use crate::film::Window;
use crate::gather::{GatherPoint, View};
use crate::media::Shadows;
use crate::rng::{self, Purpose, Stream};
use crate::vpl::{LightTracer, Provenance, Vpl};

/// Number of VPLs of the small set.
const VPLS: u64 = 8192;
/// Number of gather points at which `K` is computed.
const POINTS: u64 = 48;
/// Quantile of the values of `K` at these points that is returned as the result.
const MOST: f64 = 0.75;

/// Returns the approximate upper quartile of `K` over surfaces in view; at least 1.
///
/// * `set`: provenance of the set that `K` is for. Distances between VPLs on surfaces fall with the
///   square root of their number, so the clamp distance of the small set is longer by the root of
///   the ratio of these numbers.
pub fn importance_correlation(
    tracing: &LightTracer<'_>,
    view: &View<'_>,
    set: &Provenance,
    seed: u64,
) -> f64 {
    let groups = tracing.drawn_together(VPLS, seed);
    let lights = groups.iter().map(Vec::len).sum::<usize>().max(1);
    let farther = ((set.direct + set.indirect) as f64 / lights as f64).sqrt() as f32;
    let contribution = ContributionKernel::new(farther * set.clamp_distance)
        .with_glass(Glass::SolidStops)
        .within(tracing.tracer().scene());
    let of_point = |number: u64| {
        let key = rng::key(seed, Purpose::Guidance, number);
        let mut stream = Stream::new(key, Purpose::Guidance, 0);
        let pixel = view.random_pixel(&Window::full(view.size), &mut stream);
        let point = view.samples(tracing.tracer(), pixel, 1, key).points.into_iter().next()?;
        correlation_at(tracing, &contribution, &point, &groups)
    };
    let mut found: Vec<f64> = (0..POINTS).into_par_iter().filter_map(of_point).collect();
    found.sort_by(f64::total_cmp);
    found.get((MOST * found.len() as f64) as usize).copied().unwrap_or(1.0).max(1.0)
}

/// Returns `K` at a point; `None` if it receives no light.
fn correlation_at(
    tracing: &LightTracer<'_>,
    contribution: &ContributionKernel<'_>,
    point: &GatherPoint,
    groups: &[Vec<Vpl>],
) -> Option<f64> {
    let mut shadows = Shadows::new(contribution.glass());
    let unoccluded = |light: &Vpl| f64::from(contribution.unoccluded(point, light).luminance());
    for light in groups.iter().flatten().filter(|light| unoccluded(light) > 0.0) {
        shadows.push((point.position, point.medium), light.apex());
    }
    let mut passing = shadows.trace(tracing.tracer()).iter();
    let (mut together, mut apart) = (0.0, 0.0);
    for group in groups {
        let mut sum = 0.0;
        for value in group.iter().map(unoccluded).filter(|value| *value > 0.0) {
            let passing = passing.next().expect("one for each that is not zero");
            let value = value * f64::from(passing.max_channel());
            sum += value;
            apart += value * value;
        }
        together += sum * sum;
    }
    (apart > 0.0).then(|| together / apart)
}
