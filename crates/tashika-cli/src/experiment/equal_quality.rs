//! `tashika experiment equal-quality`: cost of each method at equal quality.

use tashika::experiment::{Cell, Column, Ground, Row, Search};
use tashika::integrator::ControlOptions;
use tashika::report::{percent_of_share, percent_of_tolerance};

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{Bench, Findings, Subjects, about_intervals, not_reached, prepare, quantities, scenery};
use crate::plan::EqualQualityPlan;
use crate::progress::Meter;
use crate::summary::Seconds;
use crate::watcher::Watcher;

const COLUMNS: &[Column] = &[
    Column::Method,
    Column::MethodError,
    Column::Within,
    Column::P95,
    Column::Worst,
    Column::Budget,
    Column::Rays,
    Column::Pairs,
    Column::Seconds,
];

/// Searches the largest target error of each method in turn.
pub fn work(plan: &EqualQualityPlan, meter: &Meter) -> Result<Outcome, Failure> {
    let measure = &plan.measure;
    let watcher = Watcher::new(meter, Seconds::default());
    let (stage, subjects) = prepare(measure, &plan.asked, Some(plan.pixels), meter, &watcher)?;
    let Subjects { prepared, pixels, lights } = &subjects;
    let setting = prepared.setting();
    let asked = format!(
        "Asked of each method: {} of the pixels within {} of the exact sum.",
        percent_of_share(plan.share),
        percent_of_tolerance(measure.cells[0].tolerance)
    );
    let mut findings = Findings {
        title: format!("{}: what the same quality costs", stage.scene.name()),
        above: vec![
            scenery(&stage, pixels),
            quantities(lights.set().len() as u64, &setting.view.gather),
            asked,
        ],
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
            let Some(row) = search(&bench, &ground, cell, plan.share)? else { break };
            if row.within_tolerance < plan.share {
                findings.below.push(not_reached(&row, plan.share));
            }
            findings.rows.push(row);
        }
        Ok(())
    })?;
    findings.finish(&measure.common, Some(&plan.folder), meter)
}

/// Returns the row of the largest target error at which `share` of the pixels are within the
/// tolerance. If there is none, returns the row of the last target error tried. `None` if
/// interrupted.
fn search(bench: &Bench<'_>, ground: &Ground<'_>, cell: &Cell, share: f64) -> Result<Option<Row>, Failure> {
    let mut search = Search::new(cell.tolerance);
    let mut best: Option<Row> = None;
    while let Some(error) = search.next_trial() {
        let cell = Cell { options: ControlOptions { error, ..cell.options }, ..*cell };
        let Some(row) = bench.row(ground, &cell)? else { return Ok(None) };
        let reached = row.within_tolerance >= share;
        search.tell(error, reached);
        if reached || search.found().is_none() {
            best = Some(row);
        }
    }
    Ok(best)
}
