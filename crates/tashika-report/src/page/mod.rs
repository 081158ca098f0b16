//! One self-contained HTML page: images to inspect, numbers, tables, plots, provenance.
//!
//! The page opens from disk and fetches nothing. Its images are the samples themselves, compressed,
//! so that the value under the pointer is the value of the film, bit by bit; scripts in the page
//! turn them into colours. If a film has too many pixels for a page, the page holds [the least
//! certain pixel](super::least_certain) of each block, and a note says so.
//!
//! Without scripts the page shows its first image as a picture, and everything else except the
//! controls.
//!
//! The same page without samples is the viewer that a program serves ([`Images::Served`]). Its
//! scripts then request tiles, a state, and single pixels below the page's own address.
//!
//! The template is `assets/page.html` (minijinja, which escapes all values), the scripts are
//! `assets/*.js`, the plots are SVG by plotters. `record_script` passes the tables of claims,
//! reasons, planes, metadata and tone mappings to the scripts.
//!
//! # Guarantee
//! Equal contents give equal bytes. Text from outside, such as names of files and scenes, never
//! becomes markup or script.
//!
//! # Held to this by
//! `report::page::tests` for the contents of pages, `scripts/page.py` in a browser for their
//! behaviour.

mod compared;
mod embedded;
mod plan;
mod plots;
mod record_script;
mod rendered;

pub use compared::{CompareFacts, compare_page};
pub use plan::PlanCell;
pub use plots::{Measured, Plot};
pub use rendered::{RenderFacts, headline, render_page};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use minijinja::{Environment, Value, context};

use super::color_scale::ColorScale;
use crate::film::{Film, Metadata, Tone};

const TEMPLATE: &str = include_str!("assets/page.html");
const STYLE: &str = include_str!("assets/style.css");
/// Scripts in the order of their dependencies, after [`record_script`].
const SCRIPTS: [&str; 4] = [
    include_str!("assets/planes.js"),
    include_str!("assets/views.js"),
    include_str!("assets/stage.js"),
    include_str!("assets/main.js"),
];

/// An image of a page.
#[derive(Clone, Debug)]
pub struct Shown<'a> {
    /// Name of the image among several.
    pub label: String,
    /// Film with the image's planes.
    pub film: &'a Film,
    /// Reference that errors are measured from.
    pub reference: Option<&'a Film>,
}

/// Source of the images of a page.
#[derive(Clone, Debug)]
pub enum Images<'a> {
    /// No images.
    None,
    /// Images embedded in the page; all show the same window of the same image.
    Embedded(Vec<Shown<'a>>),
    /// Images that the page requests from the program that serves it.
    Served {
        /// Marks the page's own scripts and styles in the program's content security policy.
        nonce: String,
    },
}

/// Table of text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sheet {
    /// Headings of the columns.
    pub head: Vec<String>,
    /// Rows of cells.
    pub lines: Vec<Vec<String>>,
}

/// Names and values of a film's metadata.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance {
    /// Name of the film.
    pub label: String,
    /// Names and values of the metadata.
    pub rows: Vec<(String, String)>,
}

impl Provenance {
    /// Provenance by the film's metadata.
    pub fn of(label: impl Into<String>, metadata: &Metadata) -> Self {
        let rows = metadata.iter().map(|(name, value)| (name.to_owned(), value.to_string())).collect();
        Self { label: label.into(), rows }
    }
}

/// Contents of a page from top to bottom; empty parts are omitted.
#[derive(Clone, Debug)]
pub struct Page<'a> {
    /// Title of the browser's window.
    pub title: String,
    /// Main result in one sentence.
    pub headline: String,
    /// Sentences below the headline.
    pub lines: Vec<String>,
    /// Images to inspect, embedded or served.
    pub images: Images<'a>,
    /// Tone mapping that the page begins with.
    pub tone: Tone,
    /// Relative error of one step of the colour scale, which has five steps. Default: the tolerance
    /// of the images.
    pub tolerance: Option<f64>,
    /// Labels and texts of the summary.
    pub rows: Vec<(String, String)>,
    /// Tables, shown below the summary.
    pub tables: Vec<Sheet>,
    /// Sentences, shown below the tables.
    pub below: Vec<String>,
    /// Plots, shown with links to their files.
    pub plots: Vec<Plot>,
    /// Command that reproduces the page.
    pub command: Option<String>,
    /// Metadata of the films that the page shows.
    pub provenance: Vec<Provenance>,
}

impl<'a> Page<'a> {
    /// A page with a title and a headline, otherwise empty.
    pub fn new(title: impl Into<String>, headline: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            headline: headline.into(),
            lines: Vec::new(),
            images: Images::None,
            tone: Tone::default(),
            tolerance: None,
            rows: Vec::new(),
            tables: Vec::new(),
            below: Vec::new(),
            plots: Vec::new(),
            command: None,
            provenance: Vec::new(),
        }
    }

    /// Returns the page as the text of an HTML file.
    pub fn html(&self) -> String {
        let (nonce, served) = match &self.images {
            Images::Served { nonce } => (nonce.as_str(), true),
            Images::None | Images::Embedded(_) => ("tashika", false),
        };
        let embedded = match &self.images {
            Images::Embedded(images) => embedded::embed(images, self.tone),
            Images::None | Images::Served { .. } => embedded::Embedded::default(),
        };
        let scale = ColorScale::new();
        let data = serde_json::json!({
            "served": served,
            "tolerance": self.tolerance,
            "scale": (0..=255).map(|i| hex(scale.color(f64::from(i) / 255.0))).collect::<Vec<_>>(),
            "beyond": hex(super::color_scale::BEYOND),
            "no_value": hex(super::color_scale::NO_VALUE),
            "images": embedded.images,
        });
        // Inside a script element only `<` could end the element or begin a comment.
        let data = data.to_string().replace('<', "\\u003c");
        let mut environment = Environment::new();
        environment.add_template("page.html", TEMPLATE).expect("the template is part of the program");
        let template = environment.get_template("page.html").expect("it was added");
        let scripts: Vec<Value> = std::iter::once(record_script::text())
            .chain(SCRIPTS.map(str::to_owned))
            .map(Value::from_safe_string)
            .collect();
        let filled = template.render(context! {
            title => &self.title,
            headline => &self.headline,
            lines => &self.lines,
            has_images => !matches!(self.images, Images::None),
            served,
            nonce,
            tones => Tone::ALL.map(Tone::name),
            tone => self.tone.name(),
            still => embedded.still.map(Value::from_safe_string),
            note => &embedded.note,
            rows => &self.rows,
            tables => self.tables.iter().map(|t| context! { head => &t.head, lines => &t.lines }).collect::<Vec<_>>(),
            below => &self.below,
            plots => self.plots.iter().map(filled_plot).collect::<Vec<_>>(),
            command => &self.command,
            provenance => self.provenance.iter().map(|p| context! { label => &p.label, rows => &p.rows }).collect::<Vec<_>>(),
            style => Value::from_safe_string(STYLE.to_owned()),
            scripts => scripts,
            data => Value::from_safe_string(data),
        });
        filled.expect("the template names only what is filled in")
    }
}

fn filled_plot(plot: &Plot) -> Value {
    let link = |kind: &str, text: &str| format!("data:{kind};base64,{}", STANDARD.encode(text));
    context! {
        name => &plot.name,
        caption => &plot.caption,
        svg => Value::from_safe_string(plot.svg.clone()),
        svg_link => link("image/svg+xml", &plot.svg),
        csv_link => link("text/csv", &plot.csv),
    }
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests;
