//! Sources of an image's half-widths.

use serde::Serialize;

use crate::film::{Film, HalfWidths, RenderFilm, planes};

/// Half-widths by source of error: medians over the pixels that claim an interval, relative to the
/// pixel's size in the error metric. Each part is the half-width that its source alone would give.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorBudget {
    /// Median of the whole half-width.
    pub total: f64,
    /// Part due to drawing few terms of the sums over VPLs.
    pub clustering: f64,
    /// Part due to using a finite sample of VPLs and gather points.
    pub lights: f64,
    /// Part due to estimating by few paths the light that VPLs do not carry.
    pub compensation: f64,
}

/// Returns the error budget of a film with the planes `half_width` and `half_width_parts`; `None`
/// if the film lacks them, or if no lit pixel claims an interval.
pub fn error_budget(film: &Film) -> Option<ErrorBudget> {
    let read = RenderFilm::of(film);
    film.plane(planes::HALF_WIDTH_PARTS).filter(|_| read.has_half_widths())?;
    let mut relative: [Vec<f64>; 4] = Default::default();
    for (pixel, (x, y)) in film.window().pixels().enumerate() {
        let total = read.relative_half_width(pixel).filter(|total| *total > 0.0 && total.is_finite());
        let Some(total) = total else { continue };
        let record = read.at(x, y);
        // Parts are relative to the same size as the whole.
        let scale = total / f64::from(record.half_width);
        let HalfWidths { clustering, lights, compensation } = record.half_widths;
        let parts = [clustering, lights, compensation].map(|part| scale * f64::from(part));
        for (all, part) in relative.iter_mut().zip([total, parts[0], parts[1], parts[2]]) {
            all.push(part);
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
