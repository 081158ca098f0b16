//! `tashika sensors`.

mod page;
mod report;
mod table;
mod words;

use tashika::film::{Stop, Tally};
use tashika::io::write_file;
use tashika::math::DVec3;
use tashika::render::Rendered;
use tashika::report::{percent_of_error, percent_of_tolerance};
use tashika::scene::SensorPoint;
use tashika::sensors::{GridSummary, Reading, SensorSet, horizontal_irradiance};

use self::report::{SensorReport, SensorsReport};
use self::words::shape;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::notes::notes;
use crate::plan::{Asked, SensorsFrom, SensorsPlan, is_standard_stream};
use crate::progress::{Meter, metered};
use crate::render::outcome;
use crate::stage::Stage;
use crate::summary::{Seconds, counted, print, typed_command, write_json};
use crate::watcher::Watcher;

/// Measures the sensors and writes the files.
pub fn run(plan: &SensorsPlan) -> Result<Outcome, Failure> {
    interrupt::listen(&plan.common);
    metered(&plan.common, |meter| work(plan, meter))
}

fn work(plan: &SensorsPlan, meter: &Meter) -> Result<Outcome, Failure> {
    let mut seconds = Seconds::default();
    let stage = Stage::load(&plan.stage, meter, &mut seconds)?;
    let points = match &plan.sensors {
        SensorsFrom::Points(points) => points.clone(),
        SensorsFrom::Grid(grid) => grid.points(&stage.tracer)?,
    };
    let set = SensorSet::new(&stage.scene, points)?;
    let outdoors = plan.daylight_up.map(|up| outdoors(plan, &stage, up)).transpose()?;
    let asked = Asked { request: plan.request.of(set.points().len())?, ..plan.asked.clone() };
    let watcher = Watcher::new(meter, seconds);
    let rendered = {
        let prepared = stage.renderer(&asked, None, &watcher).sensors(&set).prepare()?;
        prepared.render()?
    };
    meter.finish();
    let measured = Measured::new(plan, &stage, &set, outdoors, &rendered);
    measured.note_dark(meter);
    let table = measured.table();
    if is_standard_stream(&plan.csv) {
        if !plan.common.quiet {
            print(&table)?;
        }
    } else {
        write_file(&plan.csv, table.as_bytes())?;
    }
    let report = measured.report(watcher.seconds());
    if let Some(html) = &plan.html {
        write_file(html, measured.page(&report, table).html().as_bytes())?;
    }
    if let Some(path) = &plan.common.json {
        write_json(path, &report)?;
    }
    if plan.common.prints_rows() && !is_standard_stream(&plan.csv) {
        report.rows().print()?;
    }
    Ok(measured.outcome)
}

/// Readings of a set of sensors.
struct Measured<'a> {
    plan: &'a SensorsPlan,
    stage: &'a Stage,
    set: &'a SensorSet,
    readings: Vec<Reading>,
    method: String,
    complete: bool,
    tally: Tally,
    outcome: Outcome,
    summary: Option<GridSummary>,
    /// Illuminance of an unobstructed horizontal plane (lx), if daylight factors are computed.
    outdoors: Option<f64>,
}

impl<'a> Measured<'a> {
    fn new(
        plan: &'a SensorsPlan,
        stage: &'a Stage,
        set: &'a SensorSet,
        outdoors: Option<f64>,
        rendered: &Rendered,
    ) -> Self {
        let readings = set.readings(&rendered.film, plan.request.photometry);
        let mut tally = Tally::default();
        let measured = readings.iter().filter(|reading| reading.stop != Stop::NotRendered);
        measured.for_each(|reading| tally.count(reading.claim, reading.stop));
        let is_whole = rendered.complete && plan.asked.share.is_whole();
        let summary = is_whole
            .then(|| GridSummary::of(&readings, plan.request.confidence(), plan.request.jointly))
            .flatten();
        let method =
            rendered.film.metadata().text(tashika::film::keys::METHOD).unwrap_or_default().to_owned();
        Self {
            plan,
            stage,
            set,
            readings,
            method,
            complete: rendered.complete,
            outcome: outcome(plan.accept_budget, rendered.complete, false, &tally),
            tally,
            summary,
            outdoors,
        }
    }

    /// Sensors that were measured, in the order in which they were given.
    fn rows(&self) -> impl Iterator<Item = (usize, &SensorPoint, &Reading)> {
        let all = self.set.points().iter().zip(&self.readings).enumerate();
        all.filter(|(_, (_, reading))| reading.stop != Stop::NotRendered)
            .map(|(k, (point, reading))| (k + 1, point, reading))
    }

    /// Reports sensors that receive no light, which may be inside something.
    fn note_dark(&self, meter: &Meter) {
        let mut dark = self.rows().filter(|(.., reading)| reading.illuminance == 0.0);
        let Some((number, point, _)) = dark.next() else { return };
        let count = counted(1 + dark.count() as u64, "sensor receives", "sensors receive");
        let DVec3 { x, y, z } = point.position;
        meter.note(&format!(
            "{count} no light, first sensor {number} at {x:.3} {y:.3} {z:.3}: a sensor inside an object, or with its normal \
             into a wall, is dark"
        ));
    }

    fn daylight_factor(&self, lux: f64) -> Option<f64> {
        self.outdoors.map(|outdoors| 100.0 * lux / outdoors)
    }

    /// Claim of the sensors, in words.
    fn about(&self) -> String {
        let request = &self.plan.asked.request;
        let error =
            request.error.map_or(String::new(), |error| format!(", error {}", percent_of_error(error)));
        let jointly = if self.plan.request.jointly { " for all sensors together" } else { "" };
        format!(
            "method {}{error}, confidence {}{jointly}, seed {}",
            self.method,
            percent_of_tolerance(self.plan.request.confidence()),
            request.seed
        )
    }

    fn report(&self, seconds: Seconds) -> SensorsReport {
        let sensors = self.rows().map(|(number, point, reading)| SensorReport {
            sensor: number,
            name: point.name.clone(),
            shape: shape(point.shape),
            position: point.position.to_array(),
            normal: point.normal.to_array(),
            illuminance_lx: reading.illuminance,
            half_width_lx: reading.half_width,
            claim: reading.claim.code().name,
            stop: reading.stop.code().name,
            rays: reading.rays,
            irradiance: reading.irradiance,
            daylight_factor_percent: self.daylight_factor(reading.illuminance),
        });
        let rays: u64 = self.readings.iter().map(|reading| reading.rays).sum();
        let files = [Some(&self.plan.csv).filter(|path| !is_standard_stream(path)), self.plan.html.as_ref()];
        SensorsReport {
            version: env!("CARGO_PKG_VERSION"),
            command: typed_command(),
            scene: self.stage.scene.name().to_owned(),
            notes: notes(&self.stage.scene),
            about: self.about(),
            method: self.method.clone(),
            photometry: self.plan.request.photometry.name(),
            confidence: self.plan.request.confidence(),
            jointly: self.plan.request.jointly,
            seed: self.plan.asked.request.seed,
            tiles: self.plan.asked.share.to_string(),
            complete: self.complete,
            exit_code: self.outcome.code(),
            tally: self.tally,
            outdoors_lx: self.outdoors,
            summary: self.summary,
            rays_per_sensor: rays as f64 / self.tally.rendered().max(1) as f64,
            threads: self.plan.common.thread_count(),
            seconds,
            sensors: sensors.collect(),
            files: files.into_iter().flatten().cloned().collect(),
        }
    }
}

/// Illuminance of an unobstructed horizontal plane under the environment (lx).
fn outdoors(plan: &SensorsPlan, stage: &Stage, up: DVec3) -> Result<f64, Failure> {
    let environment = stage.scene.environment().map(|e| horizontal_irradiance(e, up));
    let lux = environment.map_or(0.0, |irradiance| plan.request.photometry.illuminance(irradiance));
    if lux > 0.0 {
        return Ok(lux);
    }
    Err(Failure::usage(
        "--daylight-factor: the scene has no light from the sky; --environment cie:overcast has",
    ))
}
