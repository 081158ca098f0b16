//! The page of a render: claims of its pixels, their half-widths, and reasons why work ended.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::{Images, Page, Plot, Provenance, Shown};
use crate::color::Controlled;
use crate::film::{Claim, Film, PictureClaim, Plane, RenderFilm, Stop, Tally, Tone, keys, planes};
use crate::{
    LuminanceScale, about_light_not_found, about_not_finite, about_truth, count, luminance_image,
    percent_of_error, percent_of_share, percent_of_tolerance, truth_in_short,
};

/// Contents of the page of a render beyond its film.
#[derive(Clone, Debug, Default)]
pub struct RenderFacts {
    /// Name of the image, as title and label.
    pub name: String,
    /// Labels and texts of the summary.
    pub rows: Vec<(String, String)>,
    /// Command line that was typed, if known.
    pub command: Option<String>,
    /// Tone mapping that the page begins with.
    pub tone: Tone,
    /// Scale of the picture of luminances in false colours, if the page shows one.
    pub luminance: Option<LuminanceScale>,
}

/// Returns the page of a film as HTML.
pub fn render_page(film: &Film, facts: &RenderFacts) -> String {
    let pixels = Counts::of(film);
    let mut page = Page::new(&facts.name, pixels.headline(film));
    page.lines = pixels.lines(film);
    page.images = Images::Embedded(vec![Shown { label: facts.name.clone(), film, reference: None }]);
    page.tone = facts.tone;
    page.rows = facts.rows.clone();
    page.plots = plots(film);
    page.plots.extend(facts.luminance.and_then(|scale| luminance_plot(film, &scale)));
    page.command = facts.command.clone();
    page.provenance = vec![Provenance::of(&facts.name, film.metadata())];
    page.html()
}

/// Picture of luminances, as a plot.
fn luminance_plot(film: &Film, scale: &LuminanceScale) -> Option<Plot> {
    let picture = luminance_image(film, scale)?;
    let [width, height] = picture.size();
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\">\
         <image width=\"{width}\" height=\"{height}\" href=\"data:image/png;base64,{}\"/></svg>\n",
        STANDARD.encode(picture.png())
    );
    let [r, g, b] = scale.efficacies;
    Some(Plot {
        name: "luminance".to_owned(),
        caption: "Luminance in false colours (cd/m²); lines are at the numbers of the scale".to_owned(),
        svg,
        csv: format!("channel,efficacy (lm/W)\nr,{r}\ng,{g}\nb,{b}\n"),
    })
}

/// Text for an audited picture whose half-widths are not known.
const NO_MAP: &str = "There is no map of half-widths: too few truths of the audited pixels are known. The view \
                      “relative standard error” has what is foreseen, of which nothing is claimed.";

/// Formats a positive number with at least two significant digits.
fn two_digits(number: f64) -> String {
    // The exponent of `d.de-4` has the number of decimals before the digits.
    let scientific = format!("{number:.1e}");
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    let decimals = (1 - exponent.unwrap_or(0)).max(0) as usize;
    format!("{number:.decimals$}")
}

/// Returns one sentence with the claim of a film and the share of its pixels that make it.
pub fn headline(film: &Film) -> String {
    Counts::of(film).headline(film)
}

/// Numbers of pixels by claim.
struct Counts {
    tally: Tally,
    /// Relative half-widths of the pixels that ran out of budget and claim an interval
    /// nevertheless, sorted.
    wider: Vec<f64>,
    /// Pixels with an interval from an audited map, for any result of the audit.
    audited: u64,
}

impl Counts {
    fn of(film: &Film) -> Self {
        let read = RenderFilm::of(film);
        let pixels = 0..film.window().area() as usize;
        let out = pixels.filter(|pixel| read.stop(*pixel) == Stop::Budget);
        let mut wider: Vec<f64> = out.filter_map(|pixel| read.relative_half_width(pixel)).collect();
        wider.sort_by(f64::total_cmp);
        let audited = (0..read.pixels()).filter(|pixel| read.claim(*pixel) == Claim::Audited).count();
        Self { tally: read.tally(), wider, audited: audited as u64 }
    }

    /// Sentence with the claim. No claim was compared with a reference here, so none is called
    /// kept.
    fn headline(&self, film: &Film) -> String {
        let metadata = film.metadata();
        let scene = metadata.text(keys::SCENE).unwrap_or("an image");
        if let Some(claim) = PictureClaim::of(metadata) {
            return format!("{scene}: {claim}");
        }
        let (rendered, claiming) = (self.tally.rendered(), self.tally.claiming());
        let of = format!("{} pixels", count(rendered));
        let who = if claiming == rendered {
            format!("all {of}")
        } else {
            format!("{} of {of}", percent_of_share(claiming as f64 / rendered.max(1) as f64))
        };
        let published = self.tally.of(Claim::Published) > 0;
        match (metadata.number(keys::ERROR), metadata.number(keys::CONFIDENCE)) {
            _ if claiming == 0 && self.tally.wider == 0 => {
                format!("{scene}: {of}, about whose error nothing is claimed")
            }
            _ if self.tally.of(Claim::Exact) == rendered => format!("{scene}: all {of} are exact"),
            (Some(error), Some(confidence)) => {
                let claim = if published { "claim, as their method was published," } else { "claim" };
                let dark = match metadata.number(keys::ERROR_ABSOLUTE) {
                    Some(absolute) if absolute > 0.0 => {
                        format!(", or {} W·m⁻²·sr⁻¹ where it is dark,", two_digits(absolute))
                    }
                    _ => String::new(),
                };
                let channels = match RenderFilm::of(film).controlled() {
                    Controlled::Luminance => "",
                    Controlled::Channels => " in each channel",
                };
                let truth = metadata
                    .text(keys::TRUTH)
                    .map_or_else(String::new, |truth| format!(" of {}", truth_in_short(truth)));
                let others = self.wider.get(self.wider.len() / 2).map_or_else(String::new, |half_width| {
                    format!(", half of the others to be within {}", percent_of_error(*half_width))
                });
                format!(
                    "{scene}: {who} {claim} to be within {}{truth}{dark}{channels} at {} confidence{others}",
                    percent_of_tolerance(error),
                    percent_of_tolerance(confidence)
                )
            }
            _ => format!("{scene}: {who} claim an interval"),
        }
    }

    fn lines(&self, film: &Film) -> Vec<String> {
        let (metadata, tally) = (film.metadata(), &self.tally);
        let mut lines = Vec::new();
        if (tally.claiming() > 0 || tally.wider > 0)
            && let Some(truth) = metadata.text(keys::TRUTH)
        {
            lines.push(format!("The claim is about the distance from {}.", about_truth(truth)));
        }
        if let (Some(within), Some(of)) =
            (metadata.number(keys::AUDIT_WITHIN), metadata.number(keys::AUDIT_OF))
        {
            lines.push(format!("An audit found {within} of {of} pixels at random within the error."));
        }
        let is_audited = PictureClaim::of(metadata).is_some();
        for claim in Claim::ALL {
            let n = match claim {
                // In an audited picture these are background, or pixels without a map.
                Claim::Exact | Claim::None if is_audited => 0,
                Claim::None => tally.silent(),
                Claim::Audited => self.audited,
                _ => tally.of(claim),
            };
            if n > 0 && (claim.is_some() || tally.claiming() > 0) {
                let [one, many] = claim.sentences();
                lines.push(format!("{} {}", count(n), if n == 1 { one } else { many }));
            }
        }
        if let Some(claim) = PictureClaim::of(metadata) {
            if !claim.reached {
                let share = percent_of_tolerance(claim.share);
                lines.push(format!("The aim is {share} of the pixels: more time or passes certify more."));
            }
            if self.audited == 0 {
                lines.push(NO_MAP.to_owned());
            }
        } else if tally.out_of_budget > 0 {
            let n = count(tally.out_of_budget);
            let wider = match tally.wider {
                0 => String::new(),
                with => format!(", {} with a wider interval", count(with)),
            };
            lines.push(format!("{n} ran out of budget{wider}; the view “why work stopped” shows where."));
        }
        if tally.not_found > 0 {
            lines.push(about_light_not_found(tally.not_found));
        }
        if tally.not_finite > 0 {
            lines.push(format!("NOT FINITE: {}.", about_not_finite(tally.not_finite)));
        }
        if tally.not_rendered > 0 {
            let (rendered, all) = (count(tally.rendered()), count(tally.pixels()));
            lines.push(format!("NOT COMPLETE: {rendered} of {all} pixels were rendered."));
        }
        lines
    }
}

/// Distributions of half-widths, of errors of audited pixels, and of costs.
pub(super) fn plots(film: &Film) -> Vec<Plot> {
    let mut plots = Vec::new();
    let half_widths = half_widths(film);
    if half_widths.iter().any(|h| *h > 0.0) {
        plots.push(Plot::shares(
            "half-widths",
            "How narrow the intervals are: share of pixels whose relative half-width is at most x; the line is the tolerance",
            "relative half-width",
            &[("pixels that claim an interval".to_owned(), half_widths)],
            film.metadata().number(keys::ERROR),
        ));
    }
    let ratios = audited_ratios(film);
    if !ratios.is_empty() {
        plots.push(Plot::shares(
            "audited",
            "How far audited pixels may be from their truths: share of them that is at most x times the half-width away; the line is the half-width itself",
            "distance over half-width",
            &[("audited pixels".to_owned(), ratios)],
            Some(1.0),
        ));
    }
    let pairs = film.metadata().text(keys::PAIRS_ARE).unwrap_or("what was looked at");
    for (spec, caption) in [(planes::RAYS, planes::RAYS.doc), (planes::PAIRS, pairs)] {
        let plane = film.plane(spec).filter(|p| p.channels().len() == 1).and_then(Plane::f32_samples);
        let values: Vec<f64> = plane.into_iter().flatten().map(|v| f64::from(*v)).collect();
        if values.iter().any(|v| *v > 0.0) {
            let (caption, x) = (format!("What pixels cost: {caption}"), format!("{} a pixel", spec.name));
            plots.push(Plot::histogram(spec.name, &caption, &x, &values, &|v: f64| count(v.round() as u64)));
        }
    }
    plots
}

/// Largest possible distance of each audited pixel from its truth, over the pixel's half-width.
fn audited_ratios(film: &Film) -> Vec<f64> {
    let read = RenderFilm::of(film);
    let Some(audited) = film.plane(planes::AUDITED).and_then(Plane::f32_samples) else { return Vec::new() };
    let ratio = |((x, y), audited): ((u32, u32), &[f32])| {
        let record = read.at(x, y);
        let luminance = record.radiance.luminance();
        let distance = (luminance - audited[0]).abs().max((audited[1] - luminance).abs());
        let is_known = audited[2] > 0.0 && audited[1] > audited[0] && record.half_width > 0.0;
        is_known.then(|| f64::from(distance / record.half_width))
    };
    let pixels = film.window().pixels().zip(audited.chunks_exact(planes::AUDITED.channels.len()));
    pixels.filter_map(ratio).collect()
}

/// Relative half-widths of the pixels that claim an interval.
fn half_widths(film: &Film) -> Vec<f64> {
    let read = RenderFilm::of(film);
    let pixels = (0..film.window().area() as usize).filter(|pixel| read.claim(*pixel).states_interval());
    pixels.filter_map(|pixel| read.relative_half_width(pixel)).filter(|h| !h.is_nan()).collect()
}

#[cfg(test)]
mod tests {
    use super::two_digits;

    #[test]
    fn numbers_in_sentences_have_two_digits() {
        for (number, text) in [(0.000_218_278, "0.00022"), (0.5, "0.50"), (3.26, "3.3"), (271.8, "272")] {
            assert_eq!(two_digits(number), text);
        }
    }
}
