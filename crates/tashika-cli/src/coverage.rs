//! `tashika coverage`.

use tashika::experiment::{Column, Ground, Pixels};
use tashika::film::Window;
use tashika::render::with_threads;

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{Bench, Findings, Lit, about_intervals, quantities, scenery};
use crate::plan::CoveragePlan;
use crate::progress::Meter;
use crate::stage::{Stage, light_tree, stored_lights};
use crate::summary::{Seconds, counted};

const COLUMNS: &[Column] = &[
    Column::Method,
    Column::Error,
    Column::Within,
    Column::Confidence,
    Column::Claims,
    Column::Median,
    Column::Worst,
    Column::Budget,
    Column::Rays,
    Column::Pairs,
    Column::Seconds,
];

/// Measures, and tells the rows.
pub fn run(plan: &CoveragePlan) -> Result<Outcome, Failure> {
    interrupt::listen();
    with_threads(plan.measure.common.threads, || work(plan))?
}

fn work(plan: &CoveragePlan) -> Result<Outcome, Failure> {
    let common = &plan.measure.common;
    let meter = Meter::new(common.quiet);
    let mut seconds = Seconds::default();
    let stored = stored_lights(Some(&plan.lights), &meter, &mut seconds)?;
    let stage = Stage::load(&plan.measure.stage, &meter, &mut seconds)?;
    let pixels = Pixels::of(Window::full(stage.size), Some(plan.pixels), plan.measure.seed)?;
    let set = stage.lights(&plan.lights, stored, &meter, &mut seconds)?;
    let lit = Lit { tree: light_tree(&set, &meter, &mut seconds), set };
    let setting = stage.setting(plan.gather, plan.measure.seed);
    let cells = &plan.measure.cells;
    let mut findings = Findings {
        above: vec![
            scenery(&stage, &pixels),
            format!(
                "{}; {}",
                quantities(lit.set.len() as u64, plan.gather.points),
                counted(cells[0].seeds, "seed", "seeds")
            ),
        ],
        rows: Vec::new(),
        of: cells.len(),
        columns: COLUMNS,
        below: about_intervals(),
    };
    interrupt::with_flag(|cancel| -> Result<(), Failure> {
        let bench = Bench { meter: &meter, cancel };
        let Some(reference) = bench.exact(&setting, &lit, &pixels)? else { return Ok(()) };
        let ground = Ground { setting, lit_by: lit.by(), pixels: &pixels, reference: &reference };
        for cell in cells {
            let Some(row) = bench.run(&ground, cell)? else { break };
            findings.rows.push(row);
        }
        Ok(())
    })?;
    findings.finish(common, None, &meter)
}
