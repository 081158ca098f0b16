//! An experiment on one page: its settings, the images of all methods, the table, plots.

use super::{Row, Table};
use crate::report::{Images, Measured, Page, Plot, Shown, count, percent_of_error, percent_of_tolerance};

/// Returns the page of an experiment.
///
/// * `above`, `below`: sentences about the rows.
/// * `images`: one for each method, with its reference, all of the same window. Empty if only some
///   pixels of the window were rendered.
pub fn page<'a>(
    title: &str,
    above: Vec<String>,
    (rows, table): (&[Row], &Table),
    below: Vec<String>,
    images: Vec<Shown<'a>>,
) -> Page<'a> {
    let mut page = Page::new(title, title);
    page.lines = above;
    page.below = below;
    page.tolerance = rows.first().map(|row| row.error);
    page.tables = vec![table.sheet()];
    page.plots = plots(rows);
    if !images.is_empty() {
        page.images = Images::Embedded(images);
    }
    page
}

/// Returns plots of the rows: shares against errors, claims against promises, quality against cost,
/// cost against size.
pub fn plots(rows: &[Row]) -> Vec<Plot> {
    let mut plots = Vec::new();
    let whole: Vec<&Row> = rows.iter().filter(|row| row.group.is_none()).collect();
    let several = |number: fn(&Row) -> f64| whole.windows(2).any(|two| number(two[0]) != number(two[1]));
    let mut confidences = whole.iter().filter_map(|row| row.confidence);
    let first_confidence = confidences.next();
    let several_confidences = confidences.any(|c| Some(c) != first_confidence);
    let label = |row: &Row| match row.confidence {
        Some(confidence) if several_confidences => {
            format!("{} at {}", row.method, percent_of_tolerance(confidence))
        }
        _ => row.method.to_owned(),
    };
    let mut labels: Vec<String> = Vec::new();
    for row in &whole {
        let label = label(row);
        if !labels.contains(&label) {
            labels.push(label);
        }
    }
    let series = |row: &Row| labels.iter().position(|known| *known == label(row)).unwrap_or(0);
    let within = |x: fn(&Row) -> f64| -> Vec<Measured> {
        whole
            .iter()
            .map(|row| Measured {
                label: label(row),
                series: series(row),
                x: x(row),
                share: row.within_tolerance,
                low: row.low,
                high: row.high,
            })
            .collect()
    };
    if several(|row| row.error) {
        plots.push(Plot::measured(
            "within",
            "Share of pixels within the error that methods were told",
            ("error", &percent_of_error),
            &within(|row| row.error),
            None,
        ));
    }
    plots.push(Plot::measured(
        "quality-and-cost",
        "Share of pixels within the error, against what a pixel costs",
        ("rays a pixel", &rounded),
        &within(|row| row.rays_per_pixel.max(1.0)),
        None,
    ));
    let claimed: Vec<Measured> = whole
        .iter()
        .filter_map(|row| {
            let (share, low, high) = (row.claims_kept?, row.claims_low?, row.claims_high?);
            Some(Measured {
                label: label(row),
                series: series(row),
                x: row.rays_per_pixel.max(1.0),
                share,
                low,
                high,
            })
        })
        .collect();
    if !claimed.is_empty() {
        let promised = first_confidence.filter(|_| !several_confidences);
        plots.push(Plot::measured(
            "claims",
            "Share of the claimed intervals that hold the exact sum; the line is what was promised",
            ("rays a pixel", &rounded),
            &claimed,
            promised,
        ));
    }
    for (name, caption, x, size) in [
        (
            "cost-by-lights",
            "Cost against the number of VPLs",
            "VPLs",
            (|row: &Row| row.vpls as f64) as fn(&Row) -> f64,
        ),
        ("cost-by-gather", "Cost against the number of gather points", "gather points a pixel", |row| {
            f64::from(row.gather)
        }),
    ] {
        if several(size) {
            let curve = |row: &Row| match name {
                "cost-by-lights" if several(|row| f64::from(row.gather)) => {
                    format!("{}, {} gather", row.method, row.gather)
                }
                "cost-by-gather" if several(|row| row.vpls as f64) => {
                    format!("{}, {} VPLs", row.method, count(row.vpls))
                }
                _ => row.method.to_owned(),
            };
            let points: Vec<(String, f64, f64)> =
                whole.iter().map(|row| (curve(row), size(row), row.rays_per_pixel.max(1.0))).collect();
            plots.push(Plot::growth(name, caption, x, "rays a pixel", &points));
        }
    }
    plots
}

fn rounded(n: f64) -> String {
    count(n.round() as u64)
}
