//! Page of the sensors.

use tashika::math::DVec3;
use tashika::report::{Page, PlanCell, Plot, Sheet};
use tashika::scene::SensorPoint;
use tashika::sensors::Reading;

use super::Measured;
use super::report::SensorsReport;
use super::words::{bounded, interval_of};
use crate::summary::{counted, typed_command};

/// Number of sensors in the table of the widest intervals.
const WORST: usize = 10;

impl Measured<'_> {
    /// Page with the plan, the summary and the least certain sensors.
    pub(super) fn page(&self, report: &SensorsReport, csv: String) -> Page<'static> {
        let headline = match &self.summary {
            Some(summary) => {
                format!("{}: on average {}", self.stage.scene.name(), bounded(&summary.mean, " lx"))
            }
            None => format!(
                "{}: {}",
                self.stage.scene.name(),
                counted(self.tally.rendered(), "sensor", "sensors")
            ),
        };
        let cells = self.cells();
        let places: Vec<[f64; 2]> = cells.iter().map(|cell| cell.place).collect();
        let mut page = Page::new(format!("{}: sensors", self.stage.scene.name()), headline);
        page.rows = report.rows().for_page();
        page.plots = vec![Plot::plan("sensors", "Illuminance", &cells, spacing(&places), "lx", csv)];
        page.lines = vec!["Each square is a sensor; under the pointer it shows its interval.".to_owned()];
        page.tables = vec![self.worst()];
        page.command = Some(typed_command());
        page
    }

    /// Places of the sensors in the plane in which they are spread most.
    fn cells(&self) -> Vec<PlanCell> {
        let positions = || self.rows().map(|(_, point, _)| point.position);
        let lo = positions().fold(DVec3::INFINITY, DVec3::min);
        let hi = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
        let [a, b] = match (hi - lo).min_position() {
            0 => [2, 1],
            1 => [0, 2],
            _ => [0, 1],
        };
        // Heights grow upwards on a plan of a wall; on a plan of a floor, `z` grows downwards.
        let down = if b == 1 { -1.0 } else { 1.0 };
        let cell = |(number, point, reading): (usize, &SensorPoint, &Reading)| PlanCell {
            place: [point.position[a], down * point.position[b]],
            value: if reading.is_measured() { reading.illuminance } else { f64::NAN },
            title: {
                let DVec3 { x, y, z } = point.position;
                let name = if point.name.is_empty() { number.to_string() } else { point.name.clone() };
                format!("{name} at {x:.3} {y:.3} {z:.3}: {}", interval_of(reading))
            },
        };
        self.rows().map(cell).collect()
    }

    /// Table of the sensors with the widest intervals, relative to their values.
    fn worst(&self) -> Sheet {
        let width = |reading: &Reading| match reading.half_width {
            Some(0.0) => 0.0,
            Some(half_width) => half_width / reading.illuminance,
            None => f64::INFINITY,
        };
        let mut rows: Vec<_> = self.rows().collect();
        rows.sort_by(|a, b| width(b.2).total_cmp(&width(a.2)));
        let line = |(number, point, reading): &(usize, &SensorPoint, &Reading)| {
            let DVec3 { x, y, z } = point.position;
            vec![
                number.to_string(),
                point.name.clone(),
                format!("{x:.3} {y:.3} {z:.3}"),
                interval_of(reading),
                reading.stop.code().label.to_owned(),
            ]
        };
        Sheet {
            head: ["least certain", "name", "place (m)", "illuminance", "stop"].map(str::to_owned).to_vec(),
            lines: rows.iter().take(WORST).map(line).collect(),
        }
    }
}

/// Smallest distance of neighbouring places, 1 if there is only one.
fn spacing(places: &[[f64; 2]]) -> f64 {
    let mut least = f64::INFINITY;
    for axis in 0..2 {
        let mut along: Vec<f64> = places.iter().map(|place| place[axis]).collect();
        along.sort_by(f64::total_cmp);
        for pair in along.windows(2) {
            let step = pair[1] - pair[0];
            // Rows of a grid differ by rounding.
            if step > 1e-4 * (along[along.len() - 1] - along[0]) {
                least = least.min(step);
            }
        }
    }
    if least.is_finite() { least } else { 1.0 }
}
