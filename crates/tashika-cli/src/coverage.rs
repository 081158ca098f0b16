//! `tashika coverage`.

use tashika::experiment::{Column, Ground, Group};

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{Bench, Findings, about_intervals, prepare, quantities, scenery};
use crate::plan::CoveragePlan;
use crate::progress::{Meter, metered};
use crate::summary::counted;

const COLUMNS: &[Column] = &[
    Column::Method,
    Column::Group,
    Column::Trials,
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
    interrupt::listen(&plan.measure.common);
    metered(&plan.measure.common, |meter| work(plan, meter))
}

fn work(plan: &CoveragePlan, meter: &Meter) -> Result<Outcome, Failure> {
    let common = &plan.measure.common;
    let (stage, pixels, lit) = prepare(&plan.measure, &plan.lights, plan.pixels, meter)?;
    let setting = stage.setting(plan.gather, plan.measure.seed);
    let cells = &plan.measure.cells;
    let mut findings = Findings {
        title: format!(
            "{}: how often methods keep to their tolerance and to their intervals",
            stage.scene.name()
        ),
        above: vec![
            scenery(&stage, &pixels),
            format!(
                "{}; {}",
                quantities(lit.set.len() as u64, &plan.gather),
                counted(cells[0].seeds, "seed", "seeds")
            ),
        ],
        rows: Vec::new(),
        of: cells.len(),
        columns: COLUMNS,
        below: about_intervals(),
        images: Vec::new(),
        reference: None,
    };
    interrupt::with_flag(|cancel| -> Result<(), Failure> {
        let bench = Bench { meter, cancel };
        let Some(reference) = bench.exact(&setting, &lit, &pixels)? else { return Ok(()) };
        let groups: Vec<Group> =
            plan.by.iter().flat_map(|grouping| grouping.groups(&reference, &setting)).collect();
        findings.of = cells.len() * (1 + groups.len());
        let ground =
            Ground { setting, lit_by: lit.by(), pixels: &pixels, reference: &reference, groups: &groups };
        for cell in cells {
            let Some(rows) = bench.run(&ground, cell)? else { break };
            findings.rows.extend(rows);
        }
        Ok(())
    })?;
    findings.write(plan.html.as_deref(), plan.csv.as_deref())?;
    findings.finish(common, None, meter)
}
