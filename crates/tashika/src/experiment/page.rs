//! An experiment as an HTML page, beside the pictures that it shows.

use std::fmt::Write;

use super::Table;

/// A picture of the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Its file, in the folder of the page; a name without characters that mean something in HTML.
    pub file: String,
    /// What it shows.
    pub caption: String,
}

const STYLE: &str = "\
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 120rem; padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { text-align: right; padding: .1rem 1.5rem .1rem 0; }
th:first-child, td:first-child { text-align: left; }
section { display: flex; flex-wrap: wrap; gap: 1.5rem; align-items: flex-start; margin-bottom: 1.5rem; }
figure { margin: 0; }
img { image-rendering: pixelated; min-width: 256px; max-width: 100%; }
@media (prefers-color-scheme: dark) { body { background: #181818; color: #ddd; } }
";

/// The page: a title, lines of text, the table, and rows of figures.
pub fn page(title: &str, text: &[String], table: &Table, figures: &[Vec<Figure>]) -> String {
    let title = escaped(title);
    let mut body = format!("<h1>{title}</h1>\n");
    for line in text {
        let _ = writeln!(body, "<p>{}</p>", escaped(line));
    }
    body.push_str(&table.html());
    for row in figures {
        body.push_str("<section>\n");
        for Figure { file, caption } in row {
            let caption = escaped(caption);
            let _ = writeln!(
                body,
                "<figure><figcaption>{caption}</figcaption><img alt=\"{caption}\" src=\"{file}\"></figure>"
            );
        }
        body.push_str("</section>\n");
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    )
}

/// Text that HTML shows as it is.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
