//! A comparison as one HTML page that needs nothing else: pictures are `data:` URIs, there are no scripts.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::compare::{Comparison, Named};
use super::error_image::error_image;
use super::picture::Picture;
use super::radiance::radiance_pictures;
use super::summary::summary;
use super::words::{percent_of_share, percent_of_tolerance};
use crate::error::Result;

/// Pictures narrower than this are shown larger (CSS pixels).
const LEAST_WIDTH: u32 = 256;
const STYLE: &str = "\
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 120rem; padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; }
th { text-align: left; font-weight: 600; padding-right: 1.5rem; vertical-align: top; }
div { display: flex; flex-wrap: wrap; gap: 1.5rem; align-items: flex-start; }
figure { margin: 0; }
figcaption { padding-bottom: .3rem; overflow-wrap: anywhere; }
img { image-rendering: pixelated; max-width: 100%; }
@media (prefers-color-scheme: dark) { body { background: #181818; color: #ddd; } }
";

/// The page of a comparison of these two films.
///
/// # Errors
/// As [`compare`](super::compare()), if these films were not those compared.
pub fn page(comparison: &Comparison, image: Named<'_>, reference: Named<'_>) -> Result<String> {
    let [name, reference_name] = [image, reference].map(|n| escaped(&n.name.display().to_string()));
    let [picture, reference_picture] = radiance_pictures(image, reference)?;
    let mut rows = String::new();
    for (label, text) in summary(comparison) {
        let _ = writeln!(rows, "<tr><th>{label}</th><td>{}</td></tr>", escaped(&text));
    }
    let figures: String = [
        (&picture, &name),
        (&reference_picture, &format!("{reference_name} (reference)")),
        (&error_image(comparison), &"relative error".to_owned()),
    ]
    .map(|(picture, caption)| figure(picture, caption))
    .concat();
    let headline = format!(
        "{} of the pixels are within {} of the reference",
        percent_of_share(comparison.within_share()),
        percent_of_tolerance(comparison.tolerance.relative)
    );
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{name} against {reference_name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>{headline}</h1>\n<p>{name} against {reference_name}</p>\n<table>\n{rows}</table>\n\
         <div>\n{figures}</div>\n</body>\n</html>\n"
    ))
}

/// A picture with what it is above it.
fn figure(picture: &Picture, caption: &str) -> String {
    let width = picture.size()[0];
    let shown = width * LEAST_WIDTH.div_ceil(width).max(1);
    let data = STANDARD.encode(picture.png());
    format!(
        "<figure><figcaption>{caption}</figcaption>\
         <img width=\"{shown}\" alt=\"{caption}\" src=\"data:image/png;base64,{data}\"></figure>\n"
    )
}

/// Text that HTML shows as it is, in elements and in attributes.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}
