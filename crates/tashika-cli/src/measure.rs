//! Common parts of `coverage` and the experiments: exact sums, rows with their times, and the
//! output at the end.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use tashika::experiment::{
    Cell, Column, Ground, Group, Pixels, Pool, Row, Subject, Table, Watch, page, plots,
};
use tashika::film::{Film, Window};
use tashika::gather::GatherOptions;
use tashika::integrator::{FullSum, Setting};
use tashika::io::write_file;
use tashika::renderer::Prepared;
use tashika::report::{Claims, Page, Shown, percent_of_error, percent_of_share, percent_of_tolerance};
use tashika::tree::LightSet;

use crate::exit::{Failure, Outcome};
use crate::plan::{Asked, Common, Folder, MeasurePlan};
use crate::progress::Meter;
use crate::stage::{Stage, stored_lights};
use crate::summary::{Seconds, counted, filter_unless_box, print, typed_command, write_json};
use crate::watcher::Watcher;

/// Pixels of one view, and the lights that they are summed over.
pub struct Subjects<'m> {
    /// View of the scene, with its lights.
    pub prepared: Prepared<'m>,
    /// All pixels of the view, or some at random.
    pub pixels: Pixels,
    /// Set of VPLs that pixels are summed over.
    pub lights: Arc<LightSet>,
}

/// Loads the scene, chooses the pixels, and traces the lights of a measurement.
///
/// * `pixels`: number of pixels, drawn at random; `None` for all.
pub fn prepare<'m>(
    plan: &MeasurePlan,
    asked: &Asked,
    pixels: Option<u64>,
    meter: &Meter,
    watcher: &'m Watcher<'m>,
) -> Result<(Stage, Subjects<'m>), Failure> {
    let mut seconds = Seconds::default();
    let stored = stored_lights(asked.vpl_file(), meter, &mut seconds)?;
    let stage = Stage::load(&plan.stage, meter, &mut seconds)?;
    let pixels = Pixels::of(Window::full(stage.framed.size), pixels, plan.seed)?;
    let prepared = stage.prepare(asked, stored, meter, watcher)?;
    let lights = Arc::clone(prepared.job().light_set()?);
    Ok((stage, Subjects { prepared, pixels, lights }))
}

/// Runner of measurements, which Ctrl-C stops.
pub struct Bench<'a> {
    /// Meter that receives the progress.
    pub meter: &'a Meter,
    /// True once the measurement is to stop.
    pub cancel: &'a AtomicBool,
}

impl Bench<'_> {
    /// Returns true if the measurement is to stop.
    pub fn interrupted(&self) -> bool {
        self.cancel.load(Ordering::SeqCst)
    }

    /// Computes the exact sums of `pixels`; `None` if interrupted.
    pub fn exact(
        &self,
        setting: &Setting<'_>,
        lights: &LightSet,
        pixels: &Pixels,
    ) -> Result<Option<Film>, Failure> {
        let of = counted(pixels.count(), "pixel", "pixels");
        self.meter.phase(&format!("exact sums of {of}"));
        let exact = FullSum::new(lights.set());
        let rendered = pixels.render(setting, &exact, &|p| self.meter.update(p), self.cancel)?;
        Ok(rendered.complete.then_some(rendered.film))
    }

    /// Runs a cell and returns the row of all pixels; `None` if interrupted.
    pub fn row(&self, ground: &Ground<'_>, cell: &Cell) -> Result<Option<Row>, Failure> {
        Ok(self.run(ground, cell)?.and_then(|rows| rows.into_iter().next()))
    }

    /// Runs a cell and returns the row of all pixels, then those of groups; `None` if interrupted.
    pub fn run(&self, ground: &Ground<'_>, cell: &Cell) -> Result<Option<Vec<Row>>, Failure> {
        let trials = counted(ground.pixels.count(), "pixel", "pixels");
        let seeds = counted(cell.seeds, "seed", "seeds");
        self.meter.phase(&format!("{}: {trials}, {seeds}", told(cell)));
        let begun = Instant::now();
        let watch = Watch {
            progress: &|p| self.meter.update(p),
            cancel: self.cancel,
            clock: &|| begun.elapsed().as_secs_f64(),
        };
        let all = subject(&ground.setting, ground.lights, ground.pixels);
        let group = |group: &Group| Subject { pixels: group.pixels, group: Some(group.name), ..all.clone() };
        let groups: Vec<Subject> = ground.groups.iter().map(group).collect();
        let found = ground.run(cell, &watch)?;
        Ok(found.map(|(pools, seconds)| {
            let subjects = std::iter::once(&all).chain(&groups);
            let row = |(subject, pool): (&Subject, &Pool)| Row::new(subject, cell.into(), pool, seconds);
            subjects.zip(&pools).map(row).collect()
        }))
    }
}

/// Description of a cell by method, error and confidence.
pub fn told(cell: &Cell) -> String {
    let confidence = cell.confidence();
    let confidence =
        confidence.map_or(String::new(), |c| format!(", confidence {}", percent_of_tolerance(c)));
    format!("{}, error {}{confidence}", cell.method, percent_of_error(cell.options.error))
}

/// Scene, lights and pixels that cells are run on.
pub fn subject(setting: &Setting<'_>, lights: &LightSet, pixels: &Pixels) -> Subject {
    Subject {
        scene: setting.tracer.scene().name().to_owned(),
        vpls: lights.set().len() as u64,
        gather: setting.view.gather.points,
        pixels: pixels.count(),
        group: None,
    }
}

/// Description of the scene, its size, the camera and the pixels.
pub fn scenery(stage: &Stage, pixels: &Pixels) -> String {
    let [width, height] = stage.framed.size;
    let chosen = match pixels {
        Pixels::All(_) => "all pixels".to_owned(),
        Pixels::Chosen(pixels) => format!("{} at random", counted(pixels.len() as u64, "pixel", "pixels")),
    };
    format!("{}, {width}x{height}, camera {}: {chosen}", stage.scene.name(), stage.framed.camera.name)
}

/// Rows of a measurement, with the lines and images that are shown with them.
pub struct Findings<'a> {
    /// Name of the measurement, in a few words.
    pub title: String,
    /// Lines of text above the table.
    pub above: Vec<String>,
    /// Rows of the finished cells.
    pub rows: Vec<Row>,
    /// Number of rows of the whole measurement.
    pub of: usize,
    /// Columns that the table shows.
    pub columns: &'a [Column],
    /// Lines of text below the table.
    pub below: Vec<String>,
    /// Whole images, one a method, if there are any.
    pub images: Vec<(String, Film)>,
    /// Image that `images` are compared with.
    pub reference: Option<Film>,
}

impl Findings<'_> {
    /// Table of the finished rows.
    pub fn table(&self) -> Table {
        Table::new(&self.rows, self.columns)
    }

    /// Lines below the table, with a warning if rows are missing.
    fn below(&self) -> Vec<String> {
        let missing = self.of - self.rows.len();
        let of = counted(self.of as u64, "row", "rows");
        let not_complete = (missing > 0).then(|| format!("NOT COMPLETE: {missing} of {of} are missing"));
        self.below.iter().cloned().chain(not_complete).collect()
    }

    fn markdown(&self) -> String {
        let above: String = self.above.iter().map(|line| format!("{line}\n")).collect();
        let mut out = format!("{above}\n{}", self.table().markdown());
        let below = self.below();
        if !below.is_empty() {
            out.push('\n');
            out.extend(below.iter().map(|line| format!("{line}\n")));
        }
        out
    }

    fn page(&self) -> Page<'_> {
        let shown =
            |(label, film)| Shown { label: String::clone(label), film, reference: self.reference.as_ref() };
        let images = self.images.iter().map(|(label, film)| shown((label, film))).collect();
        let mut page =
            page(&self.title, self.above.clone(), (&self.rows, &self.table()), self.below(), images);
        page.command = Some(typed_command());
        page
    }

    /// Rows as a CSV file, for spreadsheets.
    fn csv(&self) -> Vec<u8> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in &self.rows {
            writer.serialize(row).expect("rows are numbers and words");
        }
        writer.into_inner().expect("memory takes all bytes")
    }

    /// Writes the page and the CSV file, each if a path is given.
    pub fn write(&self, html: Option<&Path>, csv: Option<&Path>) -> Result<(), Failure> {
        if let Some(path) = html {
            write_file(path, self.page().html().as_bytes())?;
        }
        if let Some(path) = csv {
            write_file(path, &self.csv())?;
        }
        Ok(())
    }

    /// Writes the rows to the folder and the JSON file, prints them, and returns the outcome of the
    /// program.
    pub fn finish(
        &self,
        common: &Common,
        folder: Option<&Folder>,
        meter: &Meter,
    ) -> Result<Outcome, Failure> {
        meter.finish();
        let scripts: Vec<PathBuf> = common.json.iter().cloned().chain(folder.map(Folder::json)).collect();
        for path in &scripts {
            write_json(path, &self.rows)?;
        }
        let markdown = self.markdown();
        if let Some(folder) = folder {
            write_file(&folder.markdown(), markdown.as_bytes())?;
            self.write(Some(&folder.html()), Some(&folder.csv()))?;
            for plot in plots(&self.rows) {
                write_file(&folder.file(&format!("{}.svg", plot.name)), plot.svg.as_bytes())?;
                write_file(&folder.file(&format!("{}.csv", plot.name)), plot.csv.as_bytes())?;
            }
        }
        if common.prints_rows() {
            print(&markdown)?;
        }
        Ok(if self.rows.len() < self.of { Outcome::Interrupted } else { Outcome::Done })
    }
}

/// Explanation of the intervals in parentheses.
pub fn about_intervals() -> Vec<String> {
    let confidence = percent_of_tolerance(Claims::CONFIDENCE);
    vec![format!(
        "In parentheses: the binomial interval of the share at {confidence}, its trials taken for independent."
    )]
}

/// Sentence about a method that does not reach the share.
pub fn not_reached(row: &Row, share: f64) -> String {
    format!(
        "{} was not brought to {} within {}: it is at {} when told {}.",
        row.method,
        percent_of_share(share),
        percent_of_tolerance(row.error),
        percent_of_share(row.within_tolerance),
        percent_of_error(row.method_error)
    )
}

/// Numbers of VPLs and of gather points, and the filter unless it is the box.
pub fn quantities(vpls: u64, gather: &GatherOptions) -> String {
    format!(
        "{}, {} a pixel{}",
        counted(vpls, "VPL", "VPLs"),
        counted(gather.points.into(), "gather point", "gather points"),
        filter_unless_box(gather.filter)
    )
}
