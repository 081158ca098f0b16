//! `tashika coverage`.

use tashika::experiment::{Column, Ground, Group};

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{Bench, Findings, Subjects, about_intervals, prepare, quantities, scenery};
use crate::plan::CoveragePlan;
use crate::progress::{Meter, metered};
use crate::summary::{Seconds, counted};
use crate::watcher::Watcher;

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

/// Runs the measurement and prints its rows.
pub fn run(plan: &CoveragePlan) -> Result<Outcome, Failure> {
    interrupt::listen(&plan.measure.common);
    metered(&plan.measure.common, |meter| work(plan, meter))
}

fn work(plan: &CoveragePlan, meter: &Meter) -> Result<Outcome, Failure> {
    let common = &plan.measure.common;
    let watcher = Watcher::new(meter, Seconds::default());
    let (stage, subjects) = prepare(&plan.measure, &plan.asked, Some(plan.pixels), meter, &watcher)?;
    let Subjects { prepared, pixels, lights } = &subjects;
    let setting = prepared.setting();
    let cells = &plan.measure.cells;
    let mut findings = Findings {
        title: format!(
            "{}: how often methods keep to their tolerance and to their intervals",
            stage.scene.name()
        ),
        above: vec![
            scenery(&stage, pixels),
            format!(
                "{}; {}",
                quantities(lights.set().len() as u64, &setting.view.gather),
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
        let Some(reference) = bench.exact(&setting, lights, pixels)? else { return Ok(()) };
        let groups: Vec<Group> =
            plan.by.iter().flat_map(|grouping| grouping.groups(&reference, &setting)).collect();
        findings.of = cells.len() * (1 + groups.len());
        let ground = Ground { setting, lights, pixels, reference: &reference, groups: &groups };
        for cell in cells {
            let Some(rows) = bench.run(&ground, cell)? else { break };
            findings.rows.extend(rows);
        }
        Ok(())
    })?;
    findings.write(plan.html.as_deref(), plan.csv.as_deref())?;
    findings.finish(common, None, meter)
}
