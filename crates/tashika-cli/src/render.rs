//! `tashika render`.

use std::sync::atomic::AtomicBool;
use std::thread::available_parallelism;

use tashika::accel::Tracer;
use tashika::experiment::{OtherSet, until_converged};
use tashika::film::{Film, keys, planes};
use tashika::integrator::{
    ControlOptions, Exact, GuidedLights, Integrator, LightTransport, LitBy, Path, PathStop, Setting,
};
use tashika::io::{save_vpls, write_exr, write_file, write_png};
use tashika::render::{Finished, RenderOptions, Totals, blank, resume};
use tashika::report::{ErrorBudget, RenderFacts, error_budget, render_page};
use tashika::request::Integration;
use tashika::vpl::{VplOptions, VplSet};

use crate::audit::{Audit, MOST_PATHS, Subject, audit};
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::kept::Kept;
use crate::lit::Lit;
use crate::plan::{Lights, Outputs, RenderPlan};
use crate::progress::{Meter, metered};
use crate::serve::LivePage;
use crate::stage::{Stage, stored_lights, timed};
use crate::summary::{self, RenderReport, Seconds, Triangles, counted, typed_command, write_json};
use crate::tev::Viewer;
use crate::vpl;

/// Renders and writes the files.
pub fn run(plan: &RenderPlan) -> Result<Outcome, Failure> {
    interrupt::listen(&plan.common);
    metered(&plan.common, |meter| work(plan, meter))
}

fn work(plan: &RenderPlan, meter: &Meter) -> Result<Outcome, Failure> {
    for option in &plan.unused {
        meter.note(&format!("{option} means nothing to this method and is not used"));
    }
    let mut page = plan.serve.as_ref().map(|serving| LivePage::open(plan, serving, meter)).transpose()?;
    let exr = &plan.outputs.exr;
    let mut viewer = plan.tev.as_deref().map(|address| Viewer::connect(address, exr)).transpose()?;
    let mut seconds = Seconds::default();
    let mut stored = stored_lights(plan.lights.as_ref(), meter, &mut seconds)?;
    let stages = Stage::load_all(&plan.stage, meter, &mut seconds)?;
    if let (Some(path), [stage]) = (&plan.write_vpls, stages.as_slice()) {
        let set = traced_set(plan, stage, meter, &mut seconds)?;
        meter.finish();
        save_vpls(path, &set)?;
        return vpl::tell(&plan.common, &set, seconds.vpls, Some(path));
    }
    let outputs = if plan.stage.cameras.several() {
        let names: Vec<&str> = stages.iter().map(|stage| stage.camera.name.as_str()).collect();
        plan.outputs.of_cameras(&names)?
    } else {
        vec![plan.outputs.clone()]
    };
    let mut worst = Outcome::Done;
    for (k, (stage, outputs)) in stages.iter().zip(&outputs).enumerate() {
        let mut seconds = seconds.clone();
        // Read again rather than kept beside the trees over it.
        let stored = match stored.take() {
            None => stored_lights(plan.lights.as_ref(), meter, &mut seconds)?,
            read => read,
        };
        if k > 0 && !plan.common.quiet {
            summary::print("\n")?;
        }
        let (page, viewer) = (page.take(), viewer.take());
        worst = worst.max(image(plan, stage, outputs, stored, (page, viewer), seconds, meter)?);
        if worst == Outcome::Interrupted {
            break;
        }
    }
    Ok(worst)
}

/// Renders the image of one camera and writes its files.
fn image(
    plan: &RenderPlan,
    stage: &Stage,
    outputs: &Outputs,
    stored: Option<VplSet>,
    (page, viewer): (Option<LivePage>, Option<Viewer>),
    mut seconds: Seconds,
    meter: &Meter,
) -> Result<Outcome, Failure> {
    let lit = Lit::new(plan, stage, stored, meter, &mut seconds)?;
    let integration = lit.integration(&plan.integration.sized(stage.size), plan.gather.points);
    let integrator = integrator(&integration, &lit, &stage.tracer)?;

    let window = stage.window;
    let setting = stage.setting(plan.gather, plan.seed);
    let options = RenderOptions { window, share: plan.share.clone() };
    let mut film = blank(&setting, integrator.as_ref(), &options)?;
    plan.integration.describe(film.metadata_mut());
    plan.stage.change.describe(film.metadata_mut());
    let (kept, begun) = Kept::open(plan.checkpoint.as_deref(), film, meter)?;
    let mut rendered = timed(&mut seconds.render, || {
        interrupt::with_flag(|cancel| {
            let about = if plan.integration.is_of_a_sum() { " of the sum over these VPLs" } else { "" };
            let what = format!("rendering {}x{}, {}{about}", window.width, window.height, integrator.name());
            if plan.integration.promises() {
                meter.promising_phase(&what);
            } else {
                meter.phase(&what);
            }
            let watch = |done: &Finished<'_>| {
                meter.update(&done.progress);
                kept.add(done, meter);
                if let Some(trouble) = viewer.as_ref().and_then(|viewer| viewer.show(done)) {
                    meter.note(&trouble);
                }
                if let Some(page) = &page {
                    page.show(done, meter.words());
                }
            };
            resume(&setting, integrator.as_ref(), &options, begun, &watch, cancel)
        })
    })?;
    let progress = meter.finish();
    let audit = match (plan.audit, truth(plan, &lit, &stage.tracer)?) {
        (Some(count), Some((truth, promise))) if rendered.complete => {
            let subject = Subject { film: &rendered.film, setting, truth, promise };
            timed(&mut seconds.audit, || {
                interrupt::with_flag(|cancel| audit(count, &subject, meter, cancel))
            })?
        }
        _ => None,
    };
    if let Some(audit) = &audit {
        meter.finish();
        let metadata = rendered.film.metadata_mut();
        metadata.set(keys::AUDIT_WITHIN, audit.within);
        metadata.set(keys::AUDIT_KEPT, audit.within);
        metadata.set(keys::AUDIT_OF, audit.of);
    }
    if rendered.complete && plan.share.is_whole() {
        timed(&mut seconds.reconstruction, || Integration::finish(&mut rendered.film));
    }
    let contradicted = audit.as_ref().is_some_and(|audit| audit.contradicts);
    let exposure_stops = timed(&mut seconds.write, || -> Result<f32, Failure> {
        write_exr(&outputs.exr, &rendered.film)?;
        Ok(write_png(&outputs.png, &rendered.film, &plan.tone_map)?)
    })?;
    // After the image is safe: another set takes as much memory as the first.
    let other_set = if rendered.complete && plan.share.is_whole() {
        timed(&mut seconds.other_set, || {
            interrupt::with_flag(|cancel| {
                by_other_set(plan, &integration, &rendered.film, &setting, meter, cancel)
            })
        })?
    } else {
        None
    };
    if other_set.is_some() {
        meter.finish();
    }
    if let Some(trouble) = viewer.and_then(Viewer::finish) {
        meter.note(&trouble);
    }

    let done = Done {
        stage,
        outputs,
        lit: &lit,
        method: integrator.name(),
        totals: rendered.totals,
        // Nothing was told if no tile was finished; then only the window is known.
        pixels_asked: if progress.of > 0 { progress.of } else { window.area() },
        complete: rendered.complete,
        truth: rendered
            .film
            .metadata()
            .text(keys::TRUTH)
            .filter(|_| plan.integration.promises())
            .map(str::to_owned),
        pairs_are: rendered.film.metadata().text(keys::PAIRS_ARE).map(str::to_owned),
        error_budget: error_budget(&rendered.film),
        other_set,
        audit,
        reconstructed: rendered.film.plane(planes::RECONSTRUCTION).is_some(),
        exposure_stops,
    };
    let tally = done.totals.tally;
    let (complete, fallen_short) = (done.complete, tally.out_of_budget + tally.not_found);
    let report = report(plan, done, seconds);
    let facts = RenderFacts {
        name: outputs.exr.display().to_string(),
        rows: report.rows().for_page(),
        command: Some(typed_command()),
    };
    write_file(&outputs.html, render_page(&rendered.film, &facts).as_bytes())?;
    kept.end(rendered.complete, meter)?;
    if let Some(path) = &outputs.json {
        write_json(path, &report)?;
    }
    if !plan.common.quiet {
        report.rows().print()?;
    }
    if let Some(page) = page {
        page.end(rendered.film, meter);
    }
    Ok(match (complete, fallen_short) {
        (false, _) => Outcome::Interrupted,
        (true, _) if contradicted => Outcome::Contradicted,
        (true, 0) => Outcome::Done,
        (true, _) if plan.accept_budget => Outcome::Done,
        (true, _) => Outcome::BudgetHit,
    })
}

/// The lights that are traced for a render.
fn traced_set(
    plan: &RenderPlan,
    stage: &Stage,
    meter: &Meter,
    seconds: &mut Seconds,
) -> Result<VplSet, Failure> {
    match (&plan.integration, &plan.lights) {
        (Integration::Transport { lights: Some(lights), truth, .. }, _) => {
            meter.phase(&format!("tracing about {}", counted(lights.count, "VPL", "VPLs")));
            let view = stage.setting(plan.gather, plan.seed).view;
            let trace = || GuidedLights::trace_set(&stage.tracer, lights, *truth, &view);
            Ok(timed(&mut seconds.vpls, trace)?)
        }
        (_, Some(Lights::Trace(options))) => stage.trace(options, meter, seconds),
        _ => unreachable!("the plan refuses what has no lights to trace"),
    }
}

fn integrator<'a>(
    integration: &Integration,
    lit: &'a Lit,
    tracer: &'a Tracer,
) -> Result<Box<dyn Integrator + 'a>, Failure> {
    Ok(match (integration, lit) {
        (Integration::ManyLights { method, options, .. }, Lit::Set(set, tree)) => {
            method.integrator(LitBy { set, tree: tree.as_ref() }, options)
        }
        (Integration::Transport { options, .. }, Lit::Guided(lights)) => {
            Box::new(LightTransport::new(tracer, lights, options))
        }
        (Integration::Path(length), _) => {
            Box::new(Path::new(tracer, *length, VplOptions::default().path_depth())?)
        }
        _ => unreachable!("lights are made for the plan"),
    })
}

/// What tells the truth about a render, and what was promised about it.
type Judged<'a> = (Box<dyn Integrator + 'a>, ControlOptions);

/// By what a render can be judged; none if nothing was promised.
fn truth<'a>(plan: &RenderPlan, lit: &'a Lit, tracer: &'a Tracer) -> Result<Option<Judged<'a>>, Failure> {
    Ok(match (&plan.integration, lit) {
        (Integration::ManyLights { options, .. }, Lit::Set(set, _)) => {
            Some((Box::new(Exact::new(set)), *options))
        }
        (Integration::Transport { options, .. }, _) => {
            let depth = VplOptions::default().path_depth();
            Some((Box::new(Path::new(tracer, until_converged(options, MOST_PATHS), depth)?), *options))
        }
        _ => None,
    })
}

/// What another set of VPLs than the one that was traced would change; none if none was, or if
/// interrupted.
fn by_other_set(
    plan: &RenderPlan,
    integration: &Integration,
    film: &Film,
    setting: &Setting<'_>,
    meter: &Meter,
    cancel: &AtomicBool,
) -> Result<Option<OtherSet>, Failure> {
    let (Integration::ManyLights { method, options, .. }, Some(Lights::Trace(lights))) =
        (integration, &plan.lights)
    else {
        return Ok(None);
    };
    meter.phase("another set of VPLs");
    Ok(OtherSet::of(film, setting, *method, options, lights, cancel)?)
}

/// A finished render.
struct Done<'a> {
    stage: &'a Stage,
    outputs: &'a Outputs,
    lit: &'a Lit,
    method: &'static str,
    totals: Totals,
    pixels_asked: u64,
    complete: bool,
    truth: Option<String>,
    pairs_are: Option<String>,
    error_budget: Option<ErrorBudget>,
    other_set: Option<OtherSet>,
    audit: Option<Audit>,
    reconstructed: bool,
    exposure_stops: f32,
}

fn report(plan: &RenderPlan, done: Done<'_>, seconds: Seconds) -> RenderReport {
    let Done { stage, outputs, .. } = done;
    let totals = &done.totals;
    let Stage { scene, camera, size, window, .. } = stage;
    let lights = done.lit.report(plan);
    let (tally, pixels) = (totals.tally, totals.tally.rendered());
    let mean = |sum: u64| if pixels > 0 { sum as f64 / pixels as f64 } else { 0.0 };
    RenderReport {
        version: env!("CARGO_PKG_VERSION"),
        scene: scene.name().to_owned(),
        triangles: Triangles::of(scene),
        notes: scene.notes().iter().count(),
        default_light: scene.has_default_light(),
        light_changes: scene.changes().to_vec(),
        camera: camera.name.clone(),
        size: *size,
        window: [window.x, window.y, window.width, window.height],
        tiles: plan.share.to_string(),
        method: done.method,
        paths: match plan.integration {
            Integration::Path(PathStop::Count(paths)) => Some(paths),
            _ => None,
        },
        gather: lights.as_ref().map(|_| plan.gather.points),
        filter: plan.gather.filter,
        lights,
        seed: plan.seed,
        pixels,
        pixels_asked: done.pixels_asked,
        complete: done.complete,
        tally,
        promise_met: tally.claiming(),
        picture: plan.integration.is_picture(),
        reconstructed: done.reconstructed,
        budget_hit: tally.out_of_budget,
        not_found: tally.not_found,
        pairs_are: done.pairs_are,
        truth: done.truth.clone(),
        error_budget: done.error_budget,
        rays_per_pixel: mean(totals.rays),
        pairs_per_pixel: mean(totals.pairs),
        mean_radiance: totals.mean.to_array(),
        rays_per_second: totals.rays as f64 / seconds.render.max(1e-9),
        threads: match plan.common.threads {
            0 => available_parallelism().map_or(1, usize::from),
            threads => threads,
        },
        seconds,
        other_set: done.other_set,
        audit: done.audit,
        exposure_stops: done.exposure_stops,
        files: vec![outputs.exr.clone(), outputs.png.clone(), outputs.html.clone()],
    }
}
