//! Table of the sensors, as CSV.

use super::Measured;
use super::words::{digits, shape, summary_rows};
use crate::summary::typed_command;

impl Measured<'_> {
    /// Table of the sensors, after comments with the command, the units and the summary.
    pub(super) fn table(&self) -> String {
        let mut text = String::new();
        let mut comment = |line: String| text.push_str(&format!("# {}\n", line.replace(['\n', '\r'], " ")));
        comment(typed_command());
        comment(self.about());
        comment(format!(
            "illuminance in lx (photometry {}), irradiance in W/m2, lengths in m",
            self.plan.request.photometry
        ));
        if let Some(outdoors) = self.outdoors {
            comment(format!("daylight factors in %, of {} lx outdoors", digits(outdoors)));
        }
        if !self.complete {
            comment("NOT COMPLETE: sensors that are missing were not measured".to_owned());
        }
        if let Some(summary) = &self.summary {
            for (label, value) in summary_rows(summary) {
                comment(format!("{label} {value}"));
            }
        }
        let mut head =
            vec!["sensor", "name", "shape", "x", "y", "z", "nx", "ny", "nz", "illuminance", "half_width"];
        head.extend(["claim", "stop", "rays", "irradiance_r", "irradiance_g", "irradiance_b"]);
        if self.outdoors.is_some() {
            head.extend(["daylight_factor", "daylight_factor_half_width"]);
        }
        let mut writer = csv::Writer::from_writer(Vec::new());
        let mut write = |cells: &[String]| writer.write_record(cells).expect("a table in memory is written");
        write(&head.iter().map(|&name| name.to_owned()).collect::<Vec<_>>());
        for (number, point, reading) in self.rows() {
            let mut cells = vec![number.to_string(), point.name.clone(), shape(point.shape).to_owned()];
            cells
                .extend(point.position.to_array().iter().chain(&point.normal.to_array()).map(f64::to_string));
            cells.push(digits(reading.illuminance));
            cells.push(reading.half_width.map(digits).unwrap_or_default());
            cells.extend([reading.claim.code().name, reading.stop.code().name].map(str::to_owned));
            cells.push(reading.rays.to_string());
            cells.extend(reading.irradiance.map(digits));
            if self.outdoors.is_some() {
                let factor = |lux: f64| self.daylight_factor(lux).map(digits).unwrap_or_default();
                cells.extend([
                    factor(reading.illuminance),
                    reading.half_width.map(factor).unwrap_or_default(),
                ]);
            }
            write(&cells);
        }
        let table = writer.into_inner().expect("a table in memory is written");
        text.push_str(&String::from_utf8(table).expect("cells are text"));
        text
    }
}
