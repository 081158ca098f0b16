//! How much of an image's half-widths comes from where.

use serde::Serialize;

use crate::film::{Film, Plane};

/// What half-widths are made of: medians over the pixels that claim an interval, relative to their
/// luminance. Each says how wide the interval would be if its source of error were all.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorBudget {
    /// Of the whole half-width.
    pub total: f64,
    /// That few terms of the sums over VPLs were drawn.
    pub clustering: f64,
    /// That the VPLs, and the gather points, are some of all that there could be.
    pub lights: f64,
    /// That what VPLs do not carry is estimated by few paths.
    pub compensation: f64,
}

/// Of a film with the planes `half_width` and `half_width_parts`; none if it has none, or no lit
/// pixel claims an interval.
pub fn error_budget(film: &Film) -> Option<ErrorBudget> {
    let totals = film.plane("half_width").and_then(Plane::f32_samples)?;
    let parts = film.plane("half_width_parts").filter(|p| p.channels().len() == 3)?.f32_samples()?;
    let mut relative: [Vec<f64>; 4] = Default::default();
    for (color, (total, parts)) in film.colors()?.zip(totals.iter().zip(parts.chunks_exact(3))) {
        let luminance = color.luminance();
        if *total > 0.0 && luminance > 0.0 {
            for (all, part) in relative.iter_mut().zip([*total, parts[0], parts[1], parts[2]]) {
                all.push(f64::from(part / luminance));
            }
        }
    }
    if relative[0].is_empty() {
        return None;
    }
    let [total, clustering, lights, compensation] = relative.map(|mut all| {
        let middle = all.len() / 2;
        *all.select_nth_unstable_by(middle, f64::total_cmp).1
    });
    Some(ErrorBudget { total, clustering, lights, compensation })
}
