//! HTML for notebooks: a line of text over pictures, without any other file.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// A line of text, and PNG files side by side below it.
pub fn html(line: &str, pictures: &[Vec<u8>]) -> String {
    let mut out = format!("<figure><figcaption>{}</figcaption>", escaped(line));
    for picture in pictures {
        let data = STANDARD.encode(picture);
        let style = "max-width:48%;min-width:256px;image-rendering:pixelated;vertical-align:top";
        let _ = write!(out, "<img style=\"{style}\" src=\"data:image/png;base64,{data}\">");
    }
    out + "</figure>"
}

/// Escapes text: names of scenes come from files, and are no markup.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
