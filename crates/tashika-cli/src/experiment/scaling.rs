//! `tashika experiment scaling`: rays a pixel against the numbers of lights and of gather points.

use tashika::experiment::{Column, Ground, Pixels};
use tashika::film::Window;

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{Bench, Findings, Lit, about_intervals, scenery};
use crate::plan::ScalingPlan;
use crate::progress::Meter;
use crate::stage::{Stage, light_tree};
use crate::summary::Seconds;

const COLUMNS: &[Column] = &[
    Column::Method,
    Column::Vpls,
    Column::Gather,
    Column::Rays,
    Column::Pairs,
    Column::Seconds,
    Column::Within,
    Column::P95,
    Column::Worst,
    Column::Budget,
];

/// Measures every number of lights with every number of gather points.
pub fn work(plan: &ScalingPlan, meter: &Meter) -> Result<Outcome, Failure> {
    let measure = &plan.measure;
    let mut seconds = Seconds::default();
    let stage = Stage::load(&measure.stage, meter, &mut seconds)?;
    let pixels = Pixels::of(Window::full(stage.size), Some(plan.pixels), measure.seed)?;
    let mut findings = Findings {
        title: format!(
            "{}: what pixels cost by the number of lights and of gather points",
            stage.scene.name()
        ),
        above: vec![scenery(&stage, &pixels)],
        rows: Vec::new(),
        of: plan.lights.len() * plan.gather.len() * measure.cells.len(),
        columns: COLUMNS,
        below: about_intervals(),
        images: Vec::new(),
        reference: None,
    };
    interrupt::with_flag(|cancel| -> Result<(), Failure> {
        let bench = Bench { meter, cancel };
        for options in &plan.lights {
            if bench.interrupted() {
                break;
            }
            let set = stage.trace(options, meter, &mut seconds)?;
            let lit = Lit { tree: light_tree(&set, meter, &mut seconds), set };
            for gather in &plan.gather {
                let setting = stage.setting(*gather, measure.seed);
                let Some(reference) = bench.exact(&setting, &lit, &pixels)? else { return Ok(()) };
                let ground =
                    Ground { setting, lit_by: lit.by(), pixels: &pixels, reference: &reference, groups: &[] };
                for cell in &measure.cells {
                    let Some(row) = bench.row(&ground, cell)? else { return Ok(()) };
                    findings.rows.push(row);
                }
            }
        }
        Ok(())
    })?;
    // By method, so that each is one curve after the other.
    let order = |method: &str| measure.cells.iter().position(|cell| cell.method.name() == method);
    findings.rows.sort_by_key(|row| order(row.method));
    findings.finish(&measure.common, Some(&plan.folder), meter)
}
