//! `tashika experiment transport`: what is promised of light transport, and what a path tracer's own interval makes of the same promise.

use std::time::Instant;

use tashika::experiment::{Column, Pixels, Pool, Row, Subject, Told, converged, until_converged};
use tashika::film::{Film, Window};
use tashika::integrator::{ControlOptions, GuidedLights, Integrator, LightTransport, Path, Setting, Truth};
use tashika::io::{read_exr, write_exr};
use tashika::report::{Tolerance, percent_of_tolerance};

use crate::args::TransportMethod;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{Bench, Findings, about_intervals, quantities, scenery};
use crate::plan::TransportPlan;
use crate::progress::Meter;
use crate::stage::Stage;
use crate::summary::{Seconds, counted};

const COLUMNS: &[Column] = &[
    Column::Method,
    Column::Error,
    Column::Confidence,
    Column::Trials,
    Column::Within,
    Column::Claims,
    Column::Median,
    Column::P95,
    Column::Worst,
    Column::Budget,
    Column::Rays,
    Column::Seconds,
];

/// Tells the truth from the estimates.
const OTHER_SEED: u64 = 0x7_2074;

/// Runs both with every error.
pub fn work(plan: &TransportPlan, meter: &Meter) -> Result<Outcome, Failure> {
    let mut seconds = Seconds::default();
    // A file that cannot be read is told before any work.
    let stored = plan.reference.as_ref().map(|file| read_exr(file)).transpose()?;
    let stage = Stage::load(&plan.stage, meter, &mut seconds)?;
    let pixels = Pixels::of(Window::full(stage.size), Some(plan.pixels), plan.seed)?;
    meter.phase(&format!("tracing about {}", counted(plan.lights.count, "VPL", "VPLs")));
    let view = stage.setting(plan.gather, plan.seed).view;
    let begun = Instant::now();
    let lights = GuidedLights::trace(&stage.tracer, &plan.lights, Truth::Transport, &view)?;
    let traced = begun.elapsed().as_secs_f64();
    let depth = plan.lights.path_depth();
    let of = plan.methods.len() * plan.options.len();
    let mut findings = Findings {
        title: format!("{}: light transport, by two methods", stage.scene.name()),
        above: vec![
            scenery(&stage, &pixels),
            format!("{}, traced in {traced:.1} s", quantities(lights.count(), &plan.gather)),
        ],
        rows: Vec::new(),
        of,
        columns: COLUMNS,
        below: about_intervals(),
        images: Vec::new(),
        reference: None,
    };
    interrupt::with_flag(|cancel| -> Result<(), Failure> {
        let bench = Bench { meter, cancel };
        let setting = stage.setting(plan.gather, plan.seed);
        let truth = match &stored {
            Some(film) => Some(film.clone()),
            None => truth(plan, &bench, &stage, &pixels)?,
        };
        let Some(truth) = truth else { return Ok(()) };
        for method in &plan.methods {
            for options in &plan.options {
                let integrator: Box<dyn Integrator> = match method {
                    TransportMethod::Tashika => {
                        Box::new(LightTransport::new(&stage.tracer, &lights, options))
                    }
                    TransportMethod::Path => {
                        Box::new(Path::new(&stage.tracer, plan.stops_by_itself(options), depth)?)
                    }
                };
                let subject = Subject {
                    scene: stage.scene.name().to_owned(),
                    vpls: lights.count(),
                    gather: plan.gather.points,
                    pixels: pixels.count(),
                    group: None,
                };
                let found = row(&bench, &setting, integrator.as_ref(), options, &pixels, &truth, subject)?;
                let Some((film, row)) = found else { return Ok(()) };
                let name = format!("{}-{}.exr", integrator.name(), options.error);
                write_exr(&plan.folder.file(&name), &film)?;
                findings.rows.push(row);
            }
        }
        Ok(())
    })?;
    findings.finish(&plan.common, Some(&plan.folder), meter)
}

/// The truth of the pixels; none if interrupted.
fn truth(
    plan: &TransportPlan,
    bench: &Bench<'_>,
    stage: &Stage,
    pixels: &Pixels,
) -> Result<Option<Film>, Failure> {
    let strictest =
        plan.options.iter().min_by(|a, b| a.error.total_cmp(&b.error)).expect("there is an error");
    let length = until_converged(strictest, plan.most_paths);
    let path = Path::new(&stage.tracer, length, plan.lights.path_depth())?;
    bench.meter.phase(&format!("path tracing the truth of {}", counted(pixels.count(), "pixel", "pixels")));
    let setting = stage.setting(plan.gather, plan.seed ^ OTHER_SEED);
    let rendered = pixels.render(&setting, &path, &|p| bench.meter.update(p), bench.cancel)?;
    if !rendered.complete {
        return Ok(None);
    }
    write_exr(&plan.folder.file("reference.exr"), &rendered.film)?;
    Ok(Some(rendered.film))
}

/// What one of them makes of the promise, as an image of the pixels and as a row; none if interrupted.
fn row(
    bench: &Bench<'_>,
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    options: &ControlOptions,
    pixels: &Pixels,
    truth: &Film,
    subject: Subject,
) -> Result<Option<(Film, Row)>, Failure> {
    let name = integrator.name();
    bench.meter.phase(&format!("{name}, error {}", percent_of_tolerance(options.error)));
    let begun = Instant::now();
    let rendered = pixels.render(setting, integrator, &|p| bench.meter.update(p), bench.cancel)?;
    let seconds = begun.elapsed().as_secs_f64();
    if !rendered.complete {
        return Ok(None);
    }
    let tolerance = Tolerance { relative: options.error, absolute: options.absolute_error };
    let mut pool = Pool::new(tolerance);
    pool.add(&rendered.film, &converged(truth, &tolerance))?;
    let told = Told {
        method: name,
        tolerance: options.error,
        error: options.error,
        confidence: Some(options.confidence),
        max_pairs: None,
        seeds: 1,
    };
    let subject = Subject { pixels: pool.trials(), ..subject };
    Ok(Some((rendered.film, Row::new(&subject, told, &pool, seconds))))
}
