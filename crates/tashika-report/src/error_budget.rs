//! How much of an image's half-widths comes from where.

use serde::Serialize;

use crate::film::{Film, HalfWidths, RenderFilm, planes};

/// What half-widths are made of: medians over the pixels that claim an interval, relative to the
/// pixels by what was controlled. Each says how wide the interval would be if its source of error were all.
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
    let read = RenderFilm::of(film);
    film.plane(planes::HALF_WIDTH_PARTS).filter(|_| read.has_half_widths())?;
    let mut relative: [Vec<f64>; 4] = Default::default();
    for (pixel, (x, y)) in film.window().pixels().enumerate() {
        let total = read.relative_half_width(pixel).filter(|total| *total > 0.0 && total.is_finite());
        let Some(total) = total else { continue };
        let record = read.at(x, y);
        // What the whole is relative to, its parts are.
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
