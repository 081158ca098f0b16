//! `tashika experiment ablation`: cost of our method and share of its claims that hold, for the
//! whole method and without each of its ingredients.

use tashika::experiment::{Column, Ground};

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{Bench, Findings, Subjects, about_intervals, prepare, quantities, scenery};
use crate::plan::AblationPlan;
use crate::progress::Meter;
use crate::summary::Seconds;
use crate::watcher::Watcher;

const COLUMNS: &[Column] = &[
    Column::Method,
    Column::Within,
    Column::Claims,
    Column::Median,
    Column::Worst,
    Column::Rays,
    Column::Pairs,
    Column::Seconds,
];

/// Runs the whole method, then the method without each ingredient.
pub fn work(plan: &AblationPlan, meter: &Meter) -> Result<Outcome, Failure> {
    let measure = &plan.measure;
    let watcher = Watcher::new(meter, Seconds::default());
    let (stage, subjects) = prepare(measure, &plan.asked, Some(plan.pixels), meter, &watcher)?;
    let Subjects { prepared, pixels, lights } = &subjects;
    let setting = prepared.setting();
    let mut findings = Findings {
        title: format!("{}: what each ingredient is worth", stage.scene.name()),
        above: vec![scenery(&stage, pixels), quantities(lights.set().len() as u64, &setting.view.gather)],
        rows: Vec::new(),
        of: measure.cells.len(),
        columns: COLUMNS,
        below: about_intervals(),
        images: Vec::new(),
        reference: None,
    };
    interrupt::with_flag(|cancel| -> Result<(), Failure> {
        let bench = Bench { meter, cancel };
        let Some(reference) = bench.exact(&setting, lights, pixels)? else { return Ok(()) };
        let ground = Ground { setting, lights, pixels, reference: &reference, groups: &[] };
        for cell in &measure.cells {
            let Some(row) = bench.row(&ground, cell)? else { break };
            findings.rows.push(row);
        }
        Ok(())
    })?;
    findings.finish(&measure.common, Some(&plan.folder), meter)
}
