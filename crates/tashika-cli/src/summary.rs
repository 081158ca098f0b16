//! Summary of a command, as rows for people and as JSON for scripts. Both state the same numbers.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use indicatif::HumanCount;
use serde::{Serialize, Serializer};
use tashika::error::visible;
use tashika::experiment::OtherSet;
use tashika::film::{Claim, FoundLight, MeanInterval, PictureClaim, Tally, Tone};
use tashika::gather::Filter;
use tashika::io::write_file;
use tashika::renderer::Audit;
use tashika::report::{ErrorBudget, about_light_not_found, about_not_finite, about_truth, percent_of_error};
use tashika::request::MethodName;

use crate::exit::Failure;
use crate::notes::NoteReport;
use crate::plan::is_standard_stream;
use crate::progress::rate;

/// Rows of a label and a text.
#[derive(Default)]
pub struct Rows(Vec<(&'static str, String)>);

impl Rows {
    /// Adds a row; an empty label continues the row above.
    pub fn push(&mut self, label: &'static str, text: impl Into<String>) {
        self.0.push((label, text.into()));
    }

    /// Rows for a page; a row that continues another is joined to it.
    pub fn for_page(self) -> Vec<(String, String)> {
        let mut rows: Vec<(String, String)> = Vec::new();
        for (label, text) in self.0 {
            match rows.last_mut() {
                Some(above) if label.is_empty() => {
                    above.1.push_str("; ");
                    above.1.push_str(&text);
                }
                _ => rows.push((label.to_owned(), text)),
            }
        }
        rows
    }

    /// Prints the rows to standard output, labels in a column.
    pub fn print(&self) -> Result<(), Failure> {
        let width = self.0.iter().map(|(label, _)| label.len()).max().unwrap_or(0);
        // Names of cameras, materials and files are untrusted.
        let line = |(label, text): &(_, String)| format!("{label:width$}  {}\n", visible(text));
        let lines: String = self.0.iter().map(line).collect();
        print(&lines)
    }
}

/// Quotes a word for a shell, if necessary.
pub fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,%+@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// Command that started the program, quoted for a shell.
pub fn typed_command() -> String {
    let words = std::env::args_os().skip(1).map(|word| shell_word(&word.to_string_lossy()));
    std::iter::once("tashika".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Prints to standard output.
pub fn print(text: &str) -> Result<(), Failure> {
    match std::io::stdout().write_all(text.as_bytes()) {
        // A closed pipe is not an error: `tashika info | head`.
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::file(format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}

/// Writes a report for scripts, to standard output if the file is `-`.
pub fn write_json(path: &Path, report: &impl Serialize) -> Result<(), Failure> {
    let mut json = serde_json::to_string_pretty(report).expect("reports are plain data");
    json.push('\n');
    if is_standard_stream(path) {
        return print(&json);
    }
    Ok(write_file(path, json.as_bytes())?)
}

/// Formats a count with separators, followed by the singular or plural of its noun.
pub fn counted(n: u64, one: &str, many: &str) -> String {
    format!("{} {}", HumanCount(n), if n == 1 { one } else { many })
}

/// Names the filter, unless it is the default.
pub fn filter_unless_box(filter: Filter) -> String {
    if filter == Filter::default() { String::new() } else { format!(", {filter} filter") }
}

/// Origin of the lights of a render.
#[derive(Clone, Debug, Serialize)]
pub struct LightsReport {
    /// Number of VPLs in all.
    pub count: u64,
    /// VPLs on or towards emitters.
    pub direct: u64,
    /// VPLs of indirect light, at the vertices of light paths.
    pub indirect: u64,
    /// Distance below which the contribution of a light is clamped (m); zero for no clamp.
    pub clamp_m: f32,
    /// Seed of the light paths.
    pub seed: u64,
    /// File that the lights were read from, if they were.
    pub file: Option<PathBuf>,
}

/// Numbers of triangles of a scene.
#[derive(Debug, Serialize)]
pub struct Triangles {
    /// Number in memory.
    pub stored: u64,
    /// Number in the picture.
    pub instanced: u64,
    /// Number of triangles without area. They are ignored, since they cannot be seen.
    pub without_area: u64,
}

impl Triangles {
    /// Counts the triangles of a scene.
    pub fn of(scene: &tashika::scene::Scene) -> Self {
        Self {
            stored: scene.stored_triangles(),
            instanced: scene.instanced_triangles(),
            without_area: scene.triangles_without_area(),
        }
    }
}

/// Time of each part of the work (s).
#[derive(Clone, Debug, Default, Serialize)]
pub struct Seconds {
    /// Reading the scene.
    pub load: f64,
    /// Building the tree for rays.
    pub ray_tree: f64,
    /// Tracing or reading the VPLs.
    pub vpls: f64,
    /// Building the trees over VPLs.
    pub trees: f64,
    /// Rendering.
    pub render: f64,
    /// Tracing another set of VPLs, and rendering pixels with it.
    pub other_set: f64,
    /// Exact sums of the audit.
    pub audit: f64,
    /// The reconstruction of a picture.
    pub reconstruction: f64,
    /// Adding mattes, and planes of the first surfaces of camera rays.
    pub mattes: f64,
    /// Writing the files.
    pub write: f64,
}

fn by_name<S: Serializer>(filter: &Filter, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(filter.name())
}

/// Summary of a render.
#[derive(Debug, Serialize)]
pub struct RenderReport {
    /// Version of the program, such as `0.3.0`.
    pub version: &'static str,
    /// Name of the rendered scene.
    pub scene: String,
    /// Number of triangles in memory and in the picture.
    pub triangles: Triangles,
    /// Items that were repaired, approximated, ignored or defaulted.
    pub notes: Vec<NoteReport>,
    /// True if the scene has no light and is lit by the program's own sky and sun.
    pub default_light: bool,
    /// Requested changes to the light of the file.
    pub light_changes: Vec<String>,
    /// Time of the rendered scene (s), if a time was given and anything in it moves.
    pub time_seconds: Option<f64>,
    /// Times at which the shutter opens and closes (s), if the camera or anything else moves
    /// meanwhile.
    pub shutter_seconds: Option<[f64; 2]>,
    /// Name of the scene's camera.
    pub camera: String,
    /// Size of the full image (pixels).
    pub size: [u32; 2],
    /// The part that was rendered: x, y, width, height.
    pub window: [u32; 4],
    /// Share of the tiles, such as `1/2`.
    pub tiles: String,
    /// Name of the method that was used.
    pub method: String,
    /// Paths a pixel, if the method traces them.
    pub paths: Option<u32>,
    /// Gather points a pixel, if the method has them.
    pub gather: Option<u32>,
    /// Distribution of gather points, or paths, around a pixel.
    #[serde(serialize_with = "by_name")]
    pub filter: Filter,
    /// The lights, if the method has them.
    pub lights: Option<LightsReport>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of pixels that were rendered.
    pub pixels: u64,
    /// Number of pixels that were to be rendered.
    pub pixels_asked: u64,
    /// True if all `pixels_asked` pixels were rendered.
    pub complete: bool,
    /// Exit code of the program for this image.
    pub exit_code: u8,
    /// Rendered pixels by their claims.
    pub tally: Tally,
    /// True if a claim about the picture as a whole was requested.
    #[serde(skip)]
    pub is_audited: bool,
    /// Denoiser of an audited picture; `None` for the renderer's own reconstruction.
    pub denoiser: Option<String>,
    /// Claim about the picture as a whole, if there is one.
    pub picture_claim: Option<PictureClaim>,
    /// Pixels that claim something within their budget, by the name of earlier versions.
    pub promise_met: u64,
    /// Pixels that ran out of budget, by the name of earlier versions.
    pub budget_hit: u64,
    /// Pixels that claim nothing because too much of their light is unsampled, by the name of
    /// earlier versions.
    pub not_found: u64,
    /// Name of the terms that the method counts as pairs.
    pub pairs_are: Option<String>,
    /// Truth that the claims are about, if there are claims.
    pub truth: Option<String>,
    /// Parts of the half-widths, if intervals are claimed.
    pub error_budget: Option<ErrorBudget>,
    /// Mean number of rays of a rendered pixel.
    pub rays_per_pixel: f64,
    /// Mean number of pairs of a rendered pixel.
    pub pairs_per_pixel: f64,
    /// Mean radiance, RGB (W·m⁻²·sr⁻¹).
    pub mean_radiance: [f32; 3],
    /// Interval of the mean luminance, if every pixel claims one.
    pub mean_luminance: Option<MeanInterval>,
    /// Light by estimator and by route, if the method has several estimators.
    pub light: Option<FoundLight>,
    /// Rays a second while rendering.
    pub rays_per_second: f64,
    /// Number of threads that were used.
    pub threads: usize,
    /// Time of each part of the work.
    pub seconds: Seconds,
    /// Change of pixels by another set of VPLs, if one was traced.
    pub other_set: Option<OtherSet>,
    /// Result of the audit, if one was requested.
    pub audit: Option<Audit>,
    /// Exposure of the picture (stops).
    pub exposure_stops: f32,
    /// Tone mapping of the picture.
    pub tonemap: &'static str,
    /// Files that the render wrote.
    pub files: Vec<PathBuf>,
}

impl RenderReport {
    /// Rows with the summary for people.
    pub fn rows(&self) -> Rows {
        let mut rows = Rows::default();
        let Triangles { stored, instanced, .. } = self.triangles;
        let stored =
            if stored == instanced { String::new() } else { format!(" ({} stored)", HumanCount(stored)) };
        rows.push(
            "scene",
            format!("{}: {}{stored}", self.scene, counted(instanced, "triangle", "triangles")),
        );
        if self.default_light {
            rows.push("", "without light: the program's own sky and sun");
        }
        if !self.light_changes.is_empty() {
            rows.push("", format!("with {}", self.light_changes.join("; ")));
        }
        if let Some(time) = self.time_seconds {
            rows.push("", format!("at {time:.3} s"));
        }
        let [width, height] = self.size;
        let [x, y, w, h] = self.window;
        let part = if [w, h] == self.size { String::new() } else { format!(", part {x},{y},{w},{h}") };
        rows.push("image", format!("{width}x{height}{part}, camera {}", self.camera));
        if let Some([open, close]) = self.shutter_seconds {
            rows.push("", format!("with its shutter open from {open:.4} to {close:.4} s"));
        }
        if let Some(lights) = &self.lights {
            let clamp =
                if lights.clamp_m > 0.0 { format!("{:.3} m", lights.clamp_m) } else { "off".to_owned() };
            let unused = if self.is_audited && self.method == MethodName::Path.name() {
                "; the picture is by paths alone, which are cheaper here"
            } else {
                ""
            };
            rows.push(
                "lights",
                format!(
                    "{}, {} direct and {} indirect; clamp {clamp}{unused}",
                    counted(lights.count, "VPL", "VPLs"),
                    HumanCount(lights.direct),
                    HumanCount(lights.indirect)
                ),
            );
        }
        let samples = match (self.gather, self.paths) {
            (Some(n), _) => format!(", {} a pixel", counted(n.into(), "gather point", "gather points")),
            (_, Some(n)) => format!(", {} a pixel", counted(n.into(), "path", "paths")),
            (None, None) => String::new(),
        };
        rows.push(
            "method",
            format!("{}{samples}{}, seed {}", self.method, filter_unless_box(self.filter), self.seed),
        );
        let state = if self.complete {
            String::new()
        } else {
            format!(" of {}: NOT COMPLETE", HumanCount(self.pixels_asked))
        };
        let share = if self.tiles == "1/1" { String::new() } else { format!(" (tiles {})", self.tiles) };
        rows.push("pixels", format!("{}{share}{state}", HumanCount(self.pixels)));
        if let Some(claim) = &self.picture_claim {
            rows.push("claim", claim.to_string());
            if !claim.reached {
                let aim = 100.0 * claim.share;
                rows.push("", format!("more time or passes certify more pixels, up to the aim of {aim} %"));
            }
            if self.tally.of(Claim::Audited) + self.tally.wider == 0 {
                rows.push("", "no map of half-widths: too few truths of the audited pixels are known");
            }
        } else if self.is_audited && self.tiles != "1/1" {
            rows.push("claim", "none of a part; `tashika merge` audits the picture when all parts are there");
        } else if self.tally.out_of_budget > 0 {
            rows.push("", format!("{} of them ran out of budget", HumanCount(self.tally.out_of_budget)));
        }
        if self.is_audited {
            let own = "the renderer's own reconstruction";
            rows.push("denoiser", self.denoiser.clone().unwrap_or_else(|| own.to_owned()));
        }
        if self.tally.not_found > 0 {
            rows.push("", about_light_not_found(self.tally.not_found));
        }
        if self.tally.not_finite > 0 {
            rows.push("NOT FINITE", about_not_finite(self.tally.not_finite));
        }
        if let Some(truth) = &self.truth {
            rows.push("truth", about_truth(truth));
        }
        if let Some(ErrorBudget { total, clustering, lights, compensation }) = self.error_budget {
            let [total, clustering, lights, compensation] =
                [total, clustering, lights, compensation].map(percent_of_error);
            let made_of = if self.picture_claim.is_some() {
                "as the audit scaled the map".to_owned()
            } else if self.truth.as_deref() == Some("vpl") {
                "all of it from clustering".to_owned()
            } else {
                format!("alone: clustering {clustering}, lights {lights}, compensation {compensation}")
            };
            rows.push("half-width", format!("median {total}; {made_of}"));
        }
        if let Some(other_set) = &self.other_set {
            rows.push("other VPLs", other_set.words());
        }
        if let Some(audit) = &self.audit {
            let Audit { within, of, low, high, claiming, claiming_within, contradicts, .. } = audit;
            let claims = if claiming == of || *claiming == 0 {
                String::new()
            } else {
                format!(", {claiming_within} of the {claiming} that claim to be")
            };
            let verdict = if *contradicts { ": LESS than claimed" } else { "" };
            rows.push(
                "audit",
                format!(
                    "{within} of {of} pixels at random are within the error ({:.1} to {:.1} % at 95 %){claims}{verdict}",
                    100.0 * low,
                    100.0 * high
                ),
            );
        }
        let [r, g, b] = self.mean_radiance;
        rows.push("radiance", format!("mean {r:.4} {g:.4} {b:.4} W/m2/sr (R G B)"));
        if let Some(MeanInterval { mean, half_width }) = self.mean_luminance {
            rows.push("", format!("mean luminance {mean:.4} +- {half_width:.4} W/m2/sr, if the claims hold"));
        }
        if let Some(light) = &self.light {
            rows.push("light", light.to_string());
            if let Some(routes) = &light.by_light_paths {
                rows.push("", routes.to_string());
            }
        }
        rows.push(
            "work",
            format!(
                "a pixel: {} {}, {} rays; {}",
                HumanCount(self.pairs_per_pixel.round() as u64),
                self.pairs_are.as_deref().unwrap_or("pairs"),
                HumanCount(self.rays_per_pixel.round() as u64),
                rate(self.rays_per_second)
            ),
        );
        let s = &self.seconds;
        rows.push(
            "seconds",
            format!(
                "load {:.2}, ray tree {:.2}, VPLs {:.2}, light tree {:.2}, render {:.2}; {}",
                s.load,
                s.ray_tree,
                s.vpls,
                s.trees,
                s.render,
                counted(self.threads as u64, "thread", "threads")
            ),
        );
        let files: Vec<String> = self.files.iter().map(|f| f.display().to_string()).collect();
        let toned = match self.tonemap {
            tone if tone == Tone::default().name() => String::new(),
            other => format!(", {other}"),
        };
        let (files, stops) = (files.join(", "), self.exposure_stops);
        rows.push("files", format!("{files} (picture at {stops:+.2} stops{toned})"));
        rows
    }
}
