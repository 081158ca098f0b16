//! `tashika compare`.

use std::path::PathBuf;

use serde::Serialize;
use tashika::film::{PictureClaim, Plane};
use tashika::io::{read_exr, write_file};
use tashika::report::{
    Claims, CompareFacts, Comparison, Intervals, Named, Tolerance, ToleranceFrom, Verdict, compare,
    compare_page, error_image, summary,
};

use crate::exit::{Failure, Outcome};
use crate::plan::ComparePlan;
use crate::progress::{Meter, metered};
use crate::summary::{Rows, typed_command, write_json};

/// Result of a comparison, as JSON. Shares are in 0 to 1, errors are relative, and infinite numbers
/// are `null`.
#[derive(Debug, Serialize)]
struct Report {
    image: PathBuf,
    reference: PathBuf,
    /// Tolerance, relative.
    error: f64,
    /// Origin of the tolerance: `asked`, `image` (rendered to this tolerance), or `default`.
    error_from: &'static str,
    /// Tolerance for dark pixels, luminance.
    absolute: f64,
    /// Number of pixels that have an error. All shares are relative to this number.
    pixels: u64,
    /// Pixels among them whose radiance is not finite in the image.
    failed: u64,
    within_tolerance: f64,
    /// Mean of the finite errors.
    mean: f64,
    median: f64,
    p95: f64,
    worst: f64,
    /// Pixel of the worst error.
    worst_at: [u32; 2],
    bias: f64,
    /// Median over pixels of the relative error of the reference, at a confidence of 99.9 %. None
    /// if the reference does not state its error, or is exact.
    reference_error: Option<f64>,
    /// Mean distance over mean reference.
    relative_l1: f64,
    /// RMSE of linear RGB, in the unit of the images. This measure and the five below are none if
    /// all pixels failed.
    rmse: Option<f64>,
    relmse: Option<f64>,
    /// PSNR of the display picture (dB).
    psnr: Option<f64>,
    /// SSIM of the display picture; also none if a side of the images has fewer than 11 pixels.
    ssim: Option<f64>,
    flip: Option<f64>,
    /// Exposure of the display picture (stops).
    exposure_stops: Option<f64>,
    /// Number of pixels that have not failed but whose error is infinite.
    infinite: u64,
    left_out: LeftOut,
    /// Share of the claims that are certainly true; none if the image makes no claims.
    claims_kept: Option<f64>,
    claims: Option<ClaimsReport>,
    /// Verdict on the claim about the whole picture; none if there is no such claim.
    picture: Option<PictureReport>,
    /// Agreement between the intervals of both films. None if no pixel has an interval in both, or
    /// if the films have different truths or error metrics.
    intervals: Option<IntervalsReport>,
    files: Vec<PathBuf>,
}

#[derive(Debug, Serialize)]
struct LeftOut {
    not_rendered: u64,
    not_finite: u64,
}

#[derive(Debug, Serialize)]
struct ClaimsReport {
    /// Number of claims that are certainly true; then, certainly false; then, undecidable because
    /// of the error of the reference.
    kept: u64,
    broken: u64,
    undecidable: u64,
    of: u64,
    /// Number of claims whose interval contains the value of the reference.
    inside: u64,
    /// Number of claims that are consistent with the reference, if the errors of both images are
    /// normally distributed.
    consistent: u64,
    /// Lower and upper bound of the share of true claims. Undecidable claims widen the interval.
    low: f64,
    high: f64,
    confidence: f64,
    /// Share of the claims that is promised to be true; none if the image states no confidence.
    promised: Option<f64>,
    /// `kept`, `not_kept`, `reference_too_noisy` or `too_few_pixels`. None if nothing is promised,
    /// or if the reference estimates another truth.
    verdict: Option<&'static str>,
    /// True if the metadata of both films name the same truth.
    same_truth: bool,
}

#[derive(Debug, Serialize)]
struct PictureReport {
    claim: PictureClaim,
    /// Number of pixels within the claimed error of the reference; number outside even if the
    /// reference's own error is allowed for; number of pixels in all.
    within: u64,
    outside: u64,
    of: u64,
    held: bool,
    /// True if the reference is too noisy for a verdict.
    open: bool,
}

#[derive(Debug, Serialize)]
struct IntervalsReport {
    /// Pixels that have an interval in both films.
    claimed_in_both: u64,
    /// Pixels among them whose two intervals have no number in common.
    disjoint: u64,
    share: f64,
    /// Ends of the Clopper–Pearson interval of the share.
    low: f64,
    high: f64,
    confidence: f64,
}

/// Compares the images, writes the requested files, and prints the numbers.
pub fn run(plan: &ComparePlan) -> Result<Outcome, Failure> {
    metered(&plan.common, |meter| work(plan, meter))
}

fn work(plan: &ComparePlan, meter: &Meter) -> Result<Outcome, Failure> {
    let [image, reference] = [&plan.image, &plan.reference].map(|path| {
        meter.phase(&format!("reading {}", path.display()));
        read_exr(path)
    });
    let (mut image, reference) = (image?, reference?);
    if let Some(layer) = &plan.layer {
        image = image.only(layer).ok_or_else(|| {
            let names: Vec<&str> = image.planes().iter().map(Plane::name).filter(|n| !n.is_empty()).collect();
            Failure::option("layer", layer, format!("one of {}: {}", plan.image.display(), names.join(", ")))
        })?;
    }
    let image = Named { name: &plan.image, film: &image };
    let reference = Named { name: &plan.reference, film: &reference };
    meter.phase("comparing");
    let (tolerance, from) = Tolerance::asked_or_of(plan.error, plan.absolute, image.film);
    let comparison = compare(image, reference, &tolerance)?;
    if let Some(path) = &plan.picture {
        write_file(path, &error_image(&comparison).png())?;
    }
    if let Some(path) = &plan.html {
        let facts = CompareFacts { tolerance_from: from, command: Some(typed_command()), tone: plan.tone };
        let page = compare_page(&comparison, image, reference, &facts);
        write_file(path, page.as_bytes())?;
    }
    meter.finish();
    let report = report(plan, &comparison, from);
    if let Some(path) = &plan.common.json {
        write_json(path, &report)?;
    }
    if plan.common.prints_rows() {
        rows(&report, &comparison, from).print()?;
    }
    Ok(Outcome::Done)
}

fn report(plan: &ComparePlan, c: &Comparison, from: ToleranceFrom) -> Report {
    let measures = c.measures.as_ref();
    Report {
        image: plan.image.clone(),
        reference: plan.reference.clone(),
        error: c.tolerance.relative,
        error_from: from.name(),
        absolute: c.tolerance.absolute,
        pixels: c.pixels,
        failed: c.failed,
        within_tolerance: c.within_share(),
        mean: c.mean,
        median: c.median,
        p95: c.p95,
        worst: c.worst,
        worst_at: c.worst_at,
        bias: c.bias,
        reference_error: c.own_error,
        relative_l1: c.relative_l1,
        rmse: measures.map(|m| m.rmse),
        relmse: measures.map(|m| m.relmse),
        psnr: measures.map(|m| m.psnr),
        ssim: measures.and_then(|m| m.ssim),
        flip: measures.map(|m| m.flip),
        exposure_stops: measures.map(|m| m.exposure_stops),
        infinite: c.infinite,
        left_out: LeftOut { not_rendered: c.not_rendered, not_finite: c.not_finite },
        claims_kept: c.claims.as_ref().and_then(Claims::share),
        claims: c.claims.as_ref().map(|claims| ClaimsReport {
            kept: claims.kept,
            broken: claims.broken,
            undecidable: claims.undecidable(),
            of: claims.of,
            inside: claims.inside,
            consistent: claims.consistent,
            low: claims.interval.low,
            high: claims.interval.high,
            confidence: Claims::CONFIDENCE,
            promised: claims.promised,
            verdict: claims.verdict().map(Verdict::name),
            same_truth: claims.same_truth(),
        }),
        picture: c.picture.as_ref().map(|picture| PictureReport {
            claim: picture.claim,
            within: picture.within,
            outside: picture.outside,
            of: picture.of,
            held: picture.held(),
            open: picture.verdict().is_none(),
        }),
        intervals: c.intervals.as_ref().map(|intervals| IntervalsReport {
            claimed_in_both: intervals.claimed_in_both,
            disjoint: intervals.disjoint,
            share: intervals.share(),
            low: intervals.interval.low,
            high: intervals.interval.high,
            confidence: Intervals::CONFIDENCE,
        }),
        files: plan.picture.iter().chain(&plan.html).cloned().collect(),
    }
}

fn rows(report: &Report, comparison: &Comparison, from: ToleranceFrom) -> Rows {
    let mut rows = Rows::default();
    rows.push("image", report.image.display().to_string());
    rows.push("reference", report.reference.display().to_string());
    let why = match from {
        ToleranceFrom::Image => format!("{}; --error sets another", from.words()),
        ToleranceFrom::Asked | ToleranceFrom::Default => String::new(),
    };
    for (label, text) in summary(comparison) {
        rows.push(label, text);
        if label == "within" && !why.is_empty() {
            rows.push("", why.as_str());
        }
    }
    if !report.files.is_empty() {
        let files: Vec<String> = report.files.iter().map(|f| f.display().to_string()).collect();
        rows.push("files", files.join(", "));
    }
    rows
}
