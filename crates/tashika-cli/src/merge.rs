//! `tashika merge`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use tashika::film::{PictureClaim, RenderFilm, Tally, keys};
use tashika::io::{read_exr, write_exr_as, write_file, write_png};
use tashika::render::{Merged, Merger};
use tashika::renderer::finish_merged;
use tashika::report::{
    RenderFacts, about_light_not_found, about_not_finite, about_truth, count, luminance_image, render_page,
};

use crate::exit::{Failure, Outcome};
use crate::plan::MergePlan;
use crate::progress::{Meter, metered};
use crate::summary::{Rows, counted, typed_command, write_json};

/// Summary of a merge, as JSON.
#[derive(Debug, Serialize)]
struct Report {
    parts: usize,
    /// Number of pixels that were rendered.
    pixels: u64,
    /// Rendered pixels by their claims, and the number of pixels that were not rendered.
    tally: Tally,
    /// Claim about the picture as a whole, if there is one.
    picture_claim: Option<PictureClaim>,
    /// Truth that the claims are about; none if there are no claims.
    truth: Option<String>,
    /// Counts of `tally`, by the names of earlier versions.
    promise_met: u64,
    budget_hit: u64,
    not_found: u64,
    /// Shares that are missing, from 1; `of` is the number of all shares.
    missing: Vec<u32>,
    of: u32,
    missing_pixels: u64,
    complete: bool,
    files: Vec<PathBuf>,
}

/// Reads the parts and writes the image.
pub fn run(plan: &MergePlan) -> Result<Outcome, Failure> {
    metered(&plan.common, |meter| work(plan, meter))
}

fn work(plan: &MergePlan, meter: &Meter) -> Result<Outcome, Failure> {
    let mut merged = joined(&plan.parts, meter)?;
    if merged.missing_pixels > 0 && !plan.partial {
        let message = format!("{}; --partial writes the image without them", describe_missing(&merged));
        return Err(Failure::file(message));
    }
    meter.phase("making the picture of what is joined");
    finish_merged(&mut merged, plan.smoother.as_deref())?;
    if plan.smoother.is_some() && PictureClaim::of(merged.film.metadata()).is_none() {
        meter.note("--denoiser is not used: these are not all parts of an audited picture");
    }
    write_exr_as(&plan.exr, &merged.film, &plan.layout)?;
    write_png(&plan.png, &merged.film, &plan.tone_map)?;
    let report = report(plan, &merged);
    let facts = RenderFacts {
        name: plan.exr.display().to_string(),
        rows: rows(&report, &merged).for_page(),
        command: Some(typed_command()),
        tone: plan.tone_map.tone,
        luminance: plan.luminance.as_ref().map(|(_, scale)| *scale),
    };
    if let Some((path, scale)) = &plan.luminance
        && let Some(picture) = luminance_image(&merged.film, scale)
    {
        write_file(path, &picture.png())?;
    }
    write_file(&plan.html, render_page(&merged.film, &facts).as_bytes())?;
    meter.finish();
    if let Some(path) = &plan.common.json {
        write_json(path, &report)?;
    }
    if plan.common.prints_rows() {
        rows(&report, &merged).print()?;
    }
    let tally = &report.tally;
    let falls_short = tally.out_of_budget + tally.not_found > 0 && !plan.accept_budget;
    Ok(match tally.not_finite {
        0 if falls_short => Outcome::BudgetHit,
        0 => Outcome::Done,
        _ => Outcome::NotFinite,
    })
}

/// Reads the parts and joins them, one after the other.
fn joined(parts: &[PathBuf], meter: &Meter) -> Result<Merged, Failure> {
    let read = |path: &Path| {
        meter.phase(&format!("reading {}", path.display()));
        read_exr(path)
    };
    let (first, others) =
        parts.split_first().ok_or_else(|| Failure::option("parts", 0, "at least one film"))?;
    let mut merger = Merger::new(first, &read(first)?)?;
    for path in others {
        merger.add(path, &read(path)?)?;
    }
    Ok(merger.finish()?)
}

fn describe_missing(merged: &Merged) -> String {
    let pixels = counted(merged.missing_pixels, "pixel is", "pixels are");
    let shares: Vec<String> = merged.missing.iter().map(u32::to_string).collect();
    if shares.is_empty() {
        format!("{pixels} in no part: a part was not finished")
    } else {
        format!("{pixels} in no part: of {} shares these are missing: {}", merged.of, shares.join(", "))
    }
}

fn report(plan: &MergePlan, merged: &Merged) -> Report {
    let tally = RenderFilm::of(&merged.film).tally();
    let claims = tally.claiming() + tally.wider > 0 || PictureClaim::of(merged.film.metadata()).is_some();
    Report {
        parts: plan.parts.len(),
        pixels: tally.rendered(),
        tally,
        picture_claim: PictureClaim::of(merged.film.metadata()),
        truth: merged.film.metadata().text(keys::TRUTH).map(str::to_owned).filter(|_| claims),
        promise_met: tally.claiming(),
        budget_hit: tally.out_of_budget,
        not_found: tally.not_found,
        missing: merged.missing.clone(),
        of: merged.of,
        missing_pixels: merged.missing_pixels,
        complete: merged.missing_pixels == 0,
        files: [&plan.exr, &plan.png]
            .into_iter()
            .chain(plan.luminance.as_ref().map(|(path, _)| path))
            .chain([&plan.html])
            .cloned()
            .collect(),
    }
}

fn rows(report: &Report, merged: &Merged) -> Rows {
    let mut rows = Rows::default();
    rows.push("parts", count(report.parts as u64));
    rows.push("pixels", format!("{}, {} with a claim", count(report.pixels), count(report.tally.claiming())));
    if let Some(claim) = &report.picture_claim {
        rows.push("claim", claim.to_string());
        if !claim.reached {
            rows.push("", format!("{} % were asked for", 100.0 * claim.share));
        }
    } else if report.tally.out_of_budget > 0 {
        rows.push("", format!("{} of them ran out of budget", count(report.tally.out_of_budget)));
    }
    if report.tally.not_found > 0 {
        rows.push("", about_light_not_found(report.tally.not_found));
    }
    if report.tally.not_finite > 0 {
        rows.push("NOT FINITE", about_not_finite(report.tally.not_finite));
    }
    if let Some(truth) = &report.truth {
        rows.push("truth", about_truth(truth));
    }
    if !report.complete {
        rows.push("", format!("NOT COMPLETE: {}", describe_missing(merged)));
    }
    let files: Vec<String> = report.files.iter().map(|f| f.display().to_string()).collect();
    rows.push("files", files.join(", "));
    rows
}
