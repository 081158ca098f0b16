//! The page of a comparison: where an image is how far from its reference, and whether it knew.

use super::{Images, Page, Plot, Provenance, Shown};
use crate::compare::{Comparison, Named};
use crate::film::{percent_of_share, percent_of_tolerance};
use crate::summary::summary;

/// The page of a comparison of these two films.
pub fn compare_page(
    comparison: &Comparison,
    image: Named<'_>,
    reference: Named<'_>,
    command: Option<String>,
) -> String {
    let [name, reference_name] = [image, reference].map(|n| n.name.display().to_string());
    let tolerance = comparison.tolerance.relative;
    let headline = format!(
        "{} of the pixels are within {} of the reference",
        percent_of_share(comparison.within_share()),
        percent_of_tolerance(tolerance)
    );
    let mut page = Page::new(format!("{name} against {reference_name}"), headline);
    page.lines = vec![format!("{name} against {reference_name} (reference)")];
    page.images = Images::Embedded(vec![Shown {
        label: name.clone(),
        film: image.film,
        reference: Some(reference.film),
    }]);
    page.tolerance = Some(tolerance);
    page.rows = summary(comparison).into_iter().map(|(label, text)| (label.to_owned(), text)).collect();
    page.plots = vec![Plot::shares(
        "errors",
        "Share of pixels whose true relative error is at most x; the line is the tolerance",
        "true relative error",
        &[(name.clone(), comparison.errors.clone())],
        Some(tolerance),
    )];
    page.command = command;
    page.provenance = [(name, image), (reference_name, reference)]
        .into_iter()
        .map(|(name, named)| Provenance::of(name, named.film.metadata()))
        .filter(|p| !p.rows.is_empty())
        .collect();
    page.html()
}
