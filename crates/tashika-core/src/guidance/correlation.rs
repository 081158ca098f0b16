//! How much more a sum over VPLs varies because light paths leave several of them: learned where a
//! view looks.
//!
//! ```text
//! Var Σ_i c_i ≤ Σ_p (Σ_{i ∈ p} c_i)² = K Σ_i c_i²
//! ```
//!
//! with the contributions `c_i` of VPLs to a gather point, and the groups `p` of those that are
//! drawn together ([`LightTracer::drawn_together`]). What enters a room by a door that is ajar
//! leaves VPLs of which all or none light the room: there `K` is as much as 4, and less where paths
//! are short or surfaces dark. `K` hardly depends on how many VPLs there are, so a small set tells
//! it.

use rayon::prelude::*;

use crate::accel::Glass;
use crate::contribution::ContributionKernel;
use crate::gather::{GatherPoint, View};
use crate::media::Shadows;
use crate::rng::{self, Purpose, Stream};
use crate::vpl::{LightTracer, Provenance, Vpl};

/// VPLs of the set that tells.
const VPLS: u64 = 8192;
/// Gather points that are looked at.
const POINTS: u64 = 48;
/// Share of these that have no greater `K`.
const MOST: f64 = 0.75;

/// About `K` of the upper quarter of what the view sees; at least 1.
///
/// * `set`: the set it is told of. Distances between VPLs on surfaces fall with the square root of
///   their number, so the few that tell are clamped as much farther away.
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
        let pixel = view.size.map(|side| stream.below(side.into()) as u32);
        let point = view.samples(tracing.tracer(), pixel, 1, key).points.into_iter().next()?;
        correlation_at(tracing, &contribution, &point, &groups)
    };
    let mut found: Vec<f64> = (0..POINTS).into_par_iter().filter_map(of_point).collect();
    found.sort_by(f64::total_cmp);
    found.get((MOST * found.len() as f64) as usize).copied().unwrap_or(1.0).max(1.0)
}

/// `K` of a point; none if it gets no light.
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
