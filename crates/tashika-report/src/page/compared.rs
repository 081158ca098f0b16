//! The page of a comparison: errors of an image against its reference, and a test of its claims.

use super::{Images, Page, Plot, Provenance, Shown};
use crate::compare::{Comparison, Named, Tolerance, ToleranceFrom};
use crate::film::{Tone, percent_of_share, percent_of_tolerance};
use crate::summary::summary;

/// Contents of the page of a comparison beyond its results.
#[derive(Clone, Debug)]
pub struct CompareFacts {
    /// Origin of the tolerance.
    pub tolerance_from: ToleranceFrom,
    /// Command line that was typed, if known.
    pub command: Option<String>,
    /// Tone mapping that the page begins with.
    pub tone: Tone,
}

/// Returns the page of a comparison of these two films as HTML.
pub fn compare_page(
    comparison: &Comparison,
    image: Named<'_>,
    reference: Named<'_>,
    facts: &CompareFacts,
) -> String {
    let [name, reference_name] = [image, reference].map(|n| n.name.display().to_string());
    let Tolerance { relative: tolerance, absolute } = comparison.tolerance;
    let headline = format!(
        "{} of the pixels are within {} of the reference",
        percent_of_share(comparison.within_share()),
        percent_of_tolerance(tolerance)
    );
    let mut page = Page::new(format!("{name} against {reference_name}"), headline);
    let dark = if absolute > 0.0 {
        format!(", or {absolute} W·m⁻²·sr⁻¹ where it is dark,")
    } else {
        String::new()
    };
    page.lines = vec![
        format!("{name} against {reference_name} (reference)"),
        format!(
            "The tolerance of {}{dark} is {}.",
            percent_of_tolerance(tolerance),
            facts.tolerance_from.words()
        ),
    ];
    page.images = Images::Embedded(vec![Shown {
        label: name.clone(),
        film: image.film,
        reference: Some(reference.film),
    }]);
    page.tone = facts.tone;
    page.tolerance = Some(tolerance);
    page.rows = summary(comparison).into_iter().map(|(label, text)| (label.to_owned(), text)).collect();
    page.plots = vec![Plot::shares(
        "errors",
        "Share of pixels whose true relative error is at most x; the line is the tolerance",
        "true relative error",
        &[(name.clone(), comparison.errors.clone())],
        Some(tolerance),
    )];
    page.command.clone_from(&facts.command);
    page.provenance = [(name, image), (reference_name, reference)]
        .into_iter()
        .map(|(name, named)| Provenance::of(name, named.film.metadata()))
        .filter(|p| !p.rows.is_empty())
        .collect();
    page.html()
}
