//! `tashika experiment scaling`: rays a pixel against the numbers of lights and of gather points.

use std::sync::Arc;

use tashika::experiment::{Column, Ground, Pixels};
use tashika::film::Window;
use tashika::tree::LightSet;

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{Bench, Findings, about_intervals, scenery};
use crate::plan::ScalingPlan;
use crate::progress::Meter;
use crate::stage::Stage;
use crate::summary::Seconds;
use crate::watcher::Watcher;

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
    let pixels = Pixels::of(Window::full(stage.framed.size), Some(plan.pixels), measure.seed)?;
    let watcher = Watcher::new(meter, seconds);
    let mut findings = Findings {
        title: format!(
            "{}: what pixels cost by the number of lights and of gather points",
            stage.scene.name()
        ),
        above: vec![scenery(&stage, &pixels)],
        rows: Vec::new(),
        of: plan.asked.iter().map(Vec::len).sum::<usize>() * measure.cells.len(),
        columns: COLUMNS,
        below: about_intervals(),
        images: Vec::new(),
        reference: None,
    };
    interrupt::with_flag(|cancel| -> Result<(), Failure> {
        let bench = Bench { meter, cancel };
        for of_lights in &plan.asked {
            // Traced once for all numbers of gather points.
            let mut traced: Option<Arc<LightSet>> = None;
            for asked in of_lights {
                if bench.interrupted() {
                    return Ok(());
                }
                let prepared = stage.renderer(asked, traced.clone(), &watcher).prepare()?;
                let lights = traced.insert(Arc::clone(prepared.job().light_set()?));
                let setting = prepared.setting();
                let Some(reference) = bench.exact(&setting, lights, &pixels)? else { return Ok(()) };
                let ground = Ground { setting, lights, pixels: &pixels, reference: &reference, groups: &[] };
                for cell in &measure.cells {
                    let Some(row) = bench.row(&ground, cell)? else { return Ok(()) };
                    findings.rows.push(row);
                }
            }
        }
        Ok(())
    })?;
    // Sorted by method, so that each curve has consecutive rows.
    let order = |method: &str| measure.cells.iter().position(|cell| cell.method.name() == method);
    findings.rows.sort_by_key(|row| order(row.method));
    findings.finish(&measure.common, Some(&plan.folder), meter)
}
