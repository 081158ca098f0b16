//! Summary of a measurement, as JSON and as rows.

use std::path::PathBuf;

use indicatif::HumanCount;
use serde::Serialize;
use tashika::film::Tally;
use tashika::sensors::GridSummary;

use super::words::{short, summary_rows};
use crate::notes::NoteReport;
use crate::summary::{Rows, Seconds, counted};

/// Summary of the sensors, as JSON.
#[derive(Debug, Serialize)]
pub struct SensorsReport {
    /// Version of the program, such as `0.3.0`.
    pub version: &'static str,
    /// Command that reproduces the values.
    pub command: String,
    /// Name of the measured scene, usually that of its file.
    pub scene: String,
    /// Items that were repaired, approximated, ignored or defaulted.
    pub notes: Vec<NoteReport>,
    /// Method and claim in words.
    pub about: String,
    /// Estimator of the sensors, by its name in options.
    pub method: String,
    /// Conversion to illuminance.
    pub photometry: &'static str,
    /// Confidence of each interval, or of all together.
    pub confidence: f64,
    /// True if the intervals hold together.
    pub jointly: bool,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Share of the sensors, such as `1/2`.
    pub tiles: String,
    /// False if the work was interrupted.
    pub complete: bool,
    /// Exit code of the program.
    pub exit_code: u8,
    /// Numbers of sensors by claim.
    pub tally: Tally,
    /// Illuminance of an unobstructed horizontal plane (lx).
    pub outdoors_lx: Option<f64>,
    /// Summary of all sensors (lx); none for a share or after an interruption.
    pub summary: Option<GridSummary>,
    /// Mean number of rays of a sensor.
    pub rays_per_sensor: f64,
    /// Number of threads of the measurement.
    pub threads: usize,
    /// Time of each part of the work.
    pub seconds: Seconds,
    /// One entry for each sensor of the share.
    pub sensors: Vec<SensorReport>,
    /// Table and page, as far as they were written.
    pub files: Vec<PathBuf>,
}

#[derive(Debug, Serialize)]
pub struct SensorReport {
    pub sensor: usize,
    pub name: String,
    pub shape: &'static str,
    pub position: [f64; 3],
    pub normal: [f64; 3],
    pub illuminance_lx: f64,
    pub half_width_lx: Option<f64>,
    pub claim: &'static str,
    pub stop: &'static str,
    pub rays: u64,
    pub irradiance: [f64; 3],
    pub daylight_factor_percent: Option<f64>,
}

impl SensorsReport {
    /// Labels and texts of the summary, as they are printed.
    pub fn rows(&self) -> Rows {
        let mut rows = Rows::default();
        rows.push("scene", self.scene.clone());
        let claiming = format!(
            "{}, {} within the error",
            counted(self.tally.rendered(), "sensor", "sensors"),
            HumanCount(self.tally.rendered() - self.tally.out_of_budget - self.tally.not_found)
        );
        rows.push("sensors", claiming);
        rows.push("claim", self.about.clone());
        if let Some(summary) = &self.summary {
            for (label, value) in summary_rows(summary) {
                rows.push(label, value);
            }
        }
        if let Some(outdoors) = self.outdoors_lx {
            rows.push("outdoors", format!("{} lx on a horizontal plane", short(outdoors)));
        }
        rows.push("rays", format!("{:.0} a sensor", self.rays_per_sensor));
        let Seconds { load, ray_tree, vpls, trees, render, .. } = self.seconds;
        rows.push(
            "time",
            format!("{:.1} s, lights {:.1} s", load + ray_tree + vpls + trees + render, vpls + trees),
        );
        let files: Vec<String> = self.files.iter().map(|path| path.display().to_string()).collect();
        if !files.is_empty() {
            rows.push("files", files.join(", "));
        }
        rows
    }
}
