//! The page of a render: which pixels to trust, how much, and why.

use super::{Images, Page, Plot, Provenance, Shown};
use crate::color::Rgb;
use crate::film::{Film, Plane};
use crate::reconstruction::{ABOUT, RECONSTRUCTION};
use crate::report::{
    about_light_not_found, about_truth, count, percent_of_error, percent_of_share, percent_of_tolerance,
};

/// What the page of a render says beyond its film.
#[derive(Clone, Debug, Default)]
pub struct RenderFacts {
    /// Name of the image.
    pub name: String,
    /// Labels and what is to say of them.
    pub rows: Vec<(String, String)>,
    /// What was typed.
    pub command: Option<String>,
}

/// The page of a film.
pub fn render_page(film: &Film, facts: &RenderFacts) -> String {
    let pixels = Counts::of(film);
    let mut page = Page::new(&facts.name, pixels.headline(film));
    page.lines = pixels.lines(film);
    page.images = Images::Embedded(vec![Shown { label: facts.name.clone(), film, reference: None }]);
    page.rows = facts.rows.clone();
    page.plots = plots(film);
    page.command = facts.command.clone();
    page.provenance = vec![Provenance::of(&facts.name, film.metadata())];
    page.html()
}

/// What is promised of how many pixels of a film, in a sentence.
pub fn headline(film: &Film) -> String {
    Counts::of(film).headline(film)
}

/// How many pixels are of which kind.
struct Counts {
    rendered: u64,
    all: u64,
    /// By the number of the claim, of pixels that did not run out of budget; the first is of pixels
    /// that claim nothing, out of budget or not.
    claims: [u64; 5],
    out_of_budget: u64,
    /// Of which too much light cannot be found.
    not_found: u64,
    /// Half-widths relative to the pixel that those out of budget claim all the same.
    wider: Vec<f64>,
}

impl Counts {
    fn of(film: &Film) -> Self {
        let all = film.window().area();
        let mut found =
            Self { rendered: 0, all, claims: [0; 5], out_of_budget: 0, not_found: 0, wider: Vec::new() };
        let plane = |name| film.plane(name).filter(|p| p.channels().len() == 1).and_then(Plane::u32_samples);
        if let (Some(stops), Some(claims)) = (plane("stop"), plane("claim")) {
            let half_widths = film.plane("half_width").and_then(Plane::f32_samples);
            let luminances = film.colors().map(|colors| colors.map(Rgb::luminance).collect::<Vec<f32>>());
            for (pixel, (stop, claim)) in
                stops.iter().zip(claims).enumerate().filter(|(_, (stop, _))| **stop != 0)
            {
                found.rendered += 1;
                let is_out = *stop == 4;
                found.out_of_budget += u64::from(is_out);
                found.not_found += u64::from(*stop == 5);
                if !is_out || *claim == 0 {
                    found.claims[(*claim as usize).min(4)] += 1;
                } else if let (Some(half_widths), Some(luminances)) = (half_widths, &luminances) {
                    found
                        .wider
                        .push(f64::from(half_widths[pixel] / luminances[pixel].max(f32::MIN_POSITIVE)));
                }
            }
            found.wider.sort_by(f64::total_cmp);
        }
        found
    }

    fn kept(&self) -> u64 {
        self.claims[1..].iter().sum()
    }

    /// What is promised of how many pixels.
    fn headline(&self, film: &Film) -> String {
        let metadata = film.metadata();
        let scene = metadata.text("scene").unwrap_or("an image");
        let of = format!("{} pixels", count(self.rendered));
        let who = if self.kept() == self.rendered {
            format!("all {of} keep")
        } else {
            format!("{} of {of} keep", percent_of_share(self.kept() as f64 / self.rendered.max(1) as f64))
        };
        match (metadata.number("error"), metadata.number("confidence")) {
            _ if self.kept() == 0 && self.wider.is_empty() => {
                format!("{scene}: {of}, about whose error nothing is promised")
            }
            _ if self.claims[1] == self.rendered => format!("{scene}: all {of} are exact"),
            (Some(error), Some(confidence)) => {
                let others = self.wider.get(self.wider.len() / 2).map_or_else(String::new, |half_width| {
                    format!(", half of the others to be within {}", percent_of_error(*half_width))
                });
                format!(
                    "{scene}: {who} the promise to be within {} at {} confidence{others}",
                    percent_of_tolerance(error),
                    percent_of_tolerance(confidence)
                )
            }
            _ => format!("{scene}: {who} what they claim"),
        }
    }

    fn lines(&self, film: &Film) -> Vec<String> {
        let mut lines = Vec::new();
        if (self.kept() > 0 || !self.wider.is_empty())
            && let Some(truth) = film.metadata().text("truth")
        {
            lines.push(format!("The promise is about the distance from {}.", about_truth(truth)));
        }
        if film.plane(RECONSTRUCTION.name).is_some() {
            lines.push(format!("The picture is {ABOUT}; the view “image” has the estimates."));
        }
        for (id, (one, many)) in KINDS.into_iter().enumerate() {
            let n = self.claims[id];
            if n > 0 && (id > 0 || self.kept() > 0) {
                lines.push(format!("{} {}", count(n), if n == 1 { one } else { many }));
            }
        }
        if self.out_of_budget > 0 {
            let n = count(self.out_of_budget);
            let wider = match self.wider.len() as u64 {
                0 => String::new(),
                with => format!(", {} with a wider interval", count(with)),
            };
            lines.push(format!("{n} ran out of budget{wider}; the view “why work stopped” shows where."));
        }
        if self.not_found > 0 {
            lines.push(about_light_not_found(self.not_found));
        }
        if self.rendered < self.all {
            let (rendered, all) = (count(self.rendered), count(self.all));
            lines.push(format!("NOT COMPLETE: {rendered} of {all} pixels were rendered."));
        }
        lines
    }
}

/// What is said of pixels of each claim: of one, and of several.
const KINDS: [(&str, &str); 5] = [
    ("claims nothing: do not rely on it.", "claim nothing: do not rely on them."),
    ("is the whole sum, exact up to rounding.", "are the whole sum, exact up to rounding."),
    (
        "carries an interval as its method was published, not checked by this program.",
        "carry intervals as their method was published, not checked by this program.",
    ),
    (
        "carries a calibrated interval: it holds at least as often as the confidence says, by measurement on other scenes.",
        "carry calibrated intervals: they hold at least as often as the confidence says, by measurement on other scenes.",
    ),
    (
        "carries a certified interval: it holds by a theorem.",
        "carry certified intervals: they hold by a theorem.",
    ),
];

/// Distributions of what is claimed and of what it cost.
fn plots(film: &Film) -> Vec<Plot> {
    let mut plots = Vec::new();
    let half_widths = half_widths(film);
    if half_widths.iter().any(|h| *h > 0.0) {
        plots.push(Plot::shares(
            "half-widths",
            "How narrow the intervals are: share of pixels whose relative half-width is at most x; the line is the tolerance",
            "relative half-width",
            &[("pixels that claim an interval".to_owned(), half_widths)],
            film.metadata().number("error"),
        ));
    }
    for (name, caption) in [
        ("rays", "What pixels cost: rays and segments traced"),
        ("pairs", "What pixels cost: terms of the sum that were looked at"),
    ] {
        let plane = film.plane(name).filter(|p| p.channels().len() == 1).and_then(Plane::f32_samples);
        let values: Vec<f64> = plane.into_iter().flatten().map(|v| f64::from(*v)).collect();
        if values.iter().any(|v| *v > 0.0) {
            let x = format!("{name} a pixel");
            plots.push(Plot::histogram(name, caption, &x, &values, &|v: f64| count(v.round() as u64)));
        }
    }
    plots
}

/// Relative half-widths of the pixels that claim an interval.
fn half_widths(film: &Film) -> Vec<f64> {
    let single = |name| film.plane(name).filter(|p: &&Plane| p.channels().len() == 1);
    let (Some(half), Some(claims), Some(colors)) = (
        single("half_width").and_then(Plane::f32_samples),
        single("claim").and_then(Plane::u32_samples),
        film.colors(),
    ) else {
        return Vec::new();
    };
    let claimed = colors.zip(half.iter().zip(claims)).filter(|(_, (_, claim))| **claim > 1);
    claimed
        .map(|(color, (half, _))| if *half > 0.0 { f64::from(half / color.luminance()) } else { 0.0 })
        .filter(|h| !h.is_nan())
        .collect()
}
