//! Summary of a comparison as text.

use super::claims::{Claims, Verdict};
use super::compare::Comparison;
use super::intervals::Intervals;
use super::measures::Measures;
use super::own_error::OwnError;
use super::truths::Truths;
use crate::film::{count, percent_of_error, percent_of_share, percent_of_tolerance, truth_in_short};

/// Returns rows of a label and a text; an empty label continues the row above.
pub fn summary(c: &Comparison) -> Vec<(&'static str, String)> {
    let mut rows = vec![
        ("within", within(c)),
        (
            "error",
            format!(
                "mean {}, median {}, 95th percentile {}",
                percent_of_error(c.mean),
                percent_of_error(c.median),
                percent_of_error(c.p95)
            ),
        ),
        ("worst", format!("{} at pixel {},{}", percent_of_error(c.worst), c.worst_at[0], c.worst_at[1])),
    ];
    if c.infinite > 0 {
        rows.push(("", format!("{} lit where the reference is black, not in the mean", pixels(c.infinite))));
    }
    if c.failed > 0 {
        rows.push((
            "failed",
            format!("{}: not finite, outside of any tolerance and in no mean", pixels(c.failed)),
        ));
    }
    rows.push(("bias", percent_of_error(c.bias)));
    if let Some(own) = c.own_error {
        let confidence = percent_of_tolerance(OwnError::CONFIDENCE);
        rows.push((
            "reference",
            format!("may itself be {} off, the median pixel at {confidence}", percent_of_error(own)),
        ));
    }
    if let Some(measures) = &c.measures {
        rows.push(("measures", measured(measures)));
        rows.push(("", displayed(measures)));
    }
    if let Some(claims) = &c.claims {
        rows.push(("claims", told(claims)));
        if claims.of > 0
            && let Some(truths) = other(&claims.truths)
        {
            rows.push(("", format!("{truths}: what these differ by is judged too")));
        }
    }
    if let Some(picture) = &c.picture {
        let verdict = match picture.verdict() {
            Some(true) => "held",
            Some(false) => "NOT held",
            None => "open, the reference is too noisy to tell",
        };
        let [share, claimed] = [picture.share(), picture.claim.lower_within()].map(percent_of_share);
        let error = percent_of_tolerance(picture.claim.error);
        let pixels = pixels(picture.of);
        rows.push((
            "picture",
            format!(
                "{share} of {pixels} within {error} of the reference, at least {claimed} claimed: {verdict}"
            ),
        ));
    }
    if let Some(intervals) = &c.intervals {
        rows.push(("intervals", disjoint(intervals)));
        if intervals.disjoint > 0 {
            rows.push(("", "of two that are disjoint at least one is wrong, whatever the truth".to_owned()));
        }
    }
    if c.left_out() > 0 {
        let (rendered, finite) = (count(c.not_rendered), count(c.not_finite));
        rows.push((
            "left out",
            format!(
                "{}: {rendered} not rendered, {finite} where the reference is not finite",
                pixels(c.left_out())
            ),
        ));
    }
    rows
}

fn within(c: &Comparison) -> String {
    let tolerance = percent_of_tolerance(c.tolerance.relative);
    let dark = match c.tolerance.absolute {
        0.0 => String::new(),
        absolute => format!(", or {absolute} where it is dark"),
    };
    format!(
        "{tolerance} of the reference{dark}: {} of {}",
        percent_of_share(c.within_share()),
        pixels(c.pixels)
    )
}

fn measured(measures: &Measures) -> String {
    let Measures { rmse, relmse, .. } = measures;
    format!("RMSE {}, relMSE {} of linear RGB", digits(*rmse), digits(*relmse))
}

fn displayed(measures: &Measures) -> String {
    let Measures { psnr, ssim, flip, exposure_stops, .. } = measures;
    let psnr = if psnr.is_finite() { format!("{psnr:.2} dB") } else { "infinite".to_owned() };
    let ssim = ssim.map_or(String::new(), |ssim| format!(", SSIM {ssim:.4}"));
    format!("PSNR {psnr}{ssim}, FLIP {flip:.4} of the picture at {exposure_stops:+.2} stops")
}

/// Formats a number of any size with four digits.
fn digits(value: f64) -> String {
    if value == 0.0 || (1e-3..1e4).contains(&value) {
        let whole = [1.0, 10.0, 100.0, 1000.0].into_iter().filter(|&least| value >= least).count();
        format!("{value:.*}", 4 - whole)
    } else {
        format!("{value:.3e}")
    }
}

fn told(claims: &Claims) -> String {
    let Some(share) = claims.share() else { return "none".to_owned() };
    let [low, high] = [claims.interval.low, claims.interval.high].map(percent_of_share);
    let confidence = percent_of_tolerance(Claims::CONFIDENCE);
    let kept = percent_of_share(share);
    let kept = match claims.undecidable() {
        0 => kept,
        undecidable => {
            let share = |n: u64| percent_of_share(n as f64 / claims.of as f64);
            format!("{kept}, broken {}, undecidable {}", share(claims.broken), share(undecidable))
        }
    };
    let verdict = claims.promised.zip(claims.verdict()).map_or_else(String::new, |(promised, verdict)| {
        let share = |n: u64| percent_of_share(n as f64 / claims.of as f64);
        let why = match verdict {
            Verdict::TooNoisy => {
                format!(" ({} are consistent if all errors are normal)", share(claims.consistent))
            }
            Verdict::Kept if claims.inside > claims.kept => {
                format!(
                    ", as {} hold the reference itself, whose noise only takes away",
                    share(claims.inside)
                )
            }
            Verdict::Kept | Verdict::NotKept | Verdict::TooFew => String::new(),
        };
        format!("; {} claimed: {}{why}", percent_of_share(promised), verdict.words())
    });
    format!("kept {kept} of {} ({low} to {high} at {confidence}){verdict}", count(claims.of))
}

/// Returns a description of the reference's truth, if it differs from that of the image.
fn other(truths: &Truths) -> Option<String> {
    Some(match truths {
        Truths::Same => return None,
        Truths::Unsaid => "by a reference that does not say of what truth it is".to_owned(),
        Truths::Quantities([image, reference]) => format!(
            "these are about {}, the reference is of {}",
            truth_in_short(image),
            truth_in_short(reference)
        ),
        Truths::Sums => "by a reference of other VPLs or gather points".to_owned(),
        Truths::Views(name) => format!("by a reference of another view (its {name} differs)"),
    })
}

/// Describes disjoint intervals. They should be rare, so their share is formatted with three
/// digits, as errors are.
fn disjoint(intervals: &Intervals) -> String {
    let Intervals { claimed_in_both, disjoint, interval } = intervals;
    let [share, low, high] = [intervals.share(), interval.low, interval.high].map(percent_of_error);
    let confidence = percent_of_tolerance(Intervals::CONFIDENCE);
    let [disjoint, of] = [*disjoint, *claimed_in_both].map(count);
    format!(
        "{disjoint} of {of} that both films claim are disjoint: {share} ({low} to {high} at {confidence})"
    )
}

fn pixels(n: u64) -> String {
    format!("{} {}", count(n), if n == 1 { "pixel" } else { "pixels" })
}
