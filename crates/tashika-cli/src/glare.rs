//! `tashika glare`.

use std::path::PathBuf;

use serde::Serialize;
use tashika::error::Error;
use tashika::glare::Glare;
use tashika::io::{read_exr, write_file};
use tashika::report::{LuminanceScale, count, luminance_image};
use tashika::sensors::Bounds;

use crate::exit::{Failure, Outcome};
use crate::plan::GlarePlan;
use crate::progress::{Meter, metered};
use crate::summary::{Rows, counted, typed_command, write_json};

/// Least vertical illuminance at which the daylight glare probability was studied (lx).
const LEAST_STUDIED: f64 = 380.0;

/// Glare of an image, as JSON.
#[derive(Debug, Serialize)]
struct Report {
    version: &'static str,
    command: String,
    image: PathBuf,
    photometry: &'static str,
    threshold_cd_m2: f64,
    #[serde(flatten)]
    glare: Glare,
    files: Vec<PathBuf>,
}

/// Evaluates the image, writes the requested files, and prints the numbers.
pub fn run(plan: &GlarePlan) -> Result<Outcome, Failure> {
    metered(&plan.common, |meter| work(plan, meter))
}

fn work(plan: &GlarePlan, meter: &Meter) -> Result<Outcome, Failure> {
    meter.phase(&format!("reading {}", plan.image.display()));
    let film = read_exr(&plan.image)?;
    meter.phase("measuring glare");
    let glare = Glare::of(&film, &plan.options).map_err(|error| match error {
        Error::Invalid { mut at, found, expected } => {
            at.file = plan.image.clone();
            Error::Invalid { at, found, expected }
        }
        other => other,
    })?;
    if let Some(path) = &plan.picture {
        let efficacies = plan.options.photometry.efficacies();
        let scale = LuminanceScale { efficacies, end: Some(plan.options.threshold) };
        if let Some(picture) = luminance_image(&film, &scale) {
            write_file(path, &picture.png())?;
        }
    }
    meter.finish();
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        command: typed_command(),
        image: plan.image.clone(),
        photometry: plan.options.photometry.name(),
        threshold_cd_m2: plan.options.threshold,
        glare,
        files: plan.picture.iter().cloned().collect(),
    };
    if let Some(path) = &plan.common.json {
        write_json(path, &report)?;
    }
    if plan.common.prints_rows() {
        rows(&report).print()?;
    }
    Ok(Outcome::Done)
}

fn rows(report: &Report) -> Rows {
    let glare = &report.glare;
    let mut rows = Rows::default();
    rows.push("image", report.image.display().to_string());
    let field = format!(
        "fisheye of {} degrees, {} in view, photometry {}",
        glare.angle,
        counted(glare.pixels as u64, "pixel", "pixels"),
        report.photometry
    );
    rows.push("view", field);
    rows.push("illuminance", bounded(&glare.vertical_illuminance, 4, " lx at the eye"));
    rows.push("background", bounded(&glare.background, 4, " cd/m2"));
    let of = format!("above {} cd/m2", report.threshold_cd_m2);
    let sources = match glare.sources.first() {
        None => format!("none {of}"),
        Some(first) => format!(
            "{} {of}; the worst has {} cd/m2, {:.2e} sr, position index {:.2}, at {:.0},{:.0}",
            count(glare.sources.len() as u64),
            significant(first.luminance, 4),
            first.solid_angle,
            first.position_index,
            first.center[0],
            first.center[1]
        ),
    };
    rows.push("sources", sources);
    rows.push("UGR", glare.ugr.as_ref().map_or_else(|| "none".to_owned(), |ugr| bounded(ugr, 3, "")));
    let low = glare.vertical_illuminance.value < LEAST_STUDIED;
    let below = format!("; studied from {LEAST_STUDIED} lx at the eye only");
    rows.push("DGP", format!("{}{}", bounded(&glare.dgp, 3, ""), if low { &below } else { "" }));
    if glare.silent > 0 {
        let silent = counted(glare.silent as u64, "pixel states", "pixels state");
        rows.push("no interval", format!("{silent} no interval of this luminance"));
    }
    if !report.files.is_empty() {
        let files: Vec<String> = report.files.iter().map(|file| file.display().to_string()).collect();
        rows.push("files", files.join(", "));
    }
    rows
}

/// Writes a value with its interval.
fn bounded(bounds: &Bounds, digits: i32, unit: &str) -> String {
    let value = significant(bounds.value, digits);
    match bounds.interval {
        Some([low, high]) => {
            format!("{value}{unit}, between {} and {}", significant(low, digits), significant(high, digits))
        }
        None => format!("{value}{unit}"),
    }
}

/// Formats a number with some significant digits, and no fewer than those before the point.
fn significant(value: f64, digits: i32) -> String {
    // The exponent of `d.de-4` has the number of decimals before the digits.
    let scientific = format!("{value:.*e}", (digits - 1).max(0) as usize);
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    let decimals = (digits - 1 - exponent.unwrap_or(0)).clamp(0, 12) as usize;
    format!("{value:.decimals$}")
}
