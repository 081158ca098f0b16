//! `tashika render`.

use std::thread::available_parallelism;

use tashika::accel::Tracer;
use tashika::integrator::{Integrator, LitBy, Path};
use tashika::io::{write_exr, write_png};
use tashika::render::{RenderOptions, Totals, render, with_threads};
use tashika::tree::LightTree;
use tashika::vpl::{VplOptions, VplSet};

use crate::audit::{Audit, Subject, audit};
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::plan::{Integration, Lights, RenderPlan};
use crate::progress::Meter;
use crate::stage::{Stage, light_tree, stored_lights, timed};
use crate::summary::{LightsReport, RenderReport, Seconds, Triangles, write_json};

/// Renders and writes the files.
pub fn run(plan: &RenderPlan) -> Result<Outcome, Failure> {
    interrupt::listen();
    with_threads(plan.common.threads, || work(plan))?
}

fn work(plan: &RenderPlan) -> Result<Outcome, Failure> {
    let meter = Meter::new(plan.common.quiet);
    for option in &plan.unused {
        meter.note(&format!("{option} means nothing to this method and is not used"));
    }
    let mut seconds = Seconds::default();
    let stored = stored_lights(plan.lights(), &meter, &mut seconds)?;
    let stage = Stage::load(&plan.stage, &meter, &mut seconds)?;
    let lights = match plan.lights() {
        Some(lights) => Some(stage.lights(lights, stored, &meter, &mut seconds)?),
        None => None,
    };
    let tree = match (&plan.integration, &lights) {
        (Integration::ManyLights { method, .. }, Some(set)) if method.needs_tree() => {
            Some(light_tree(set, &meter, &mut seconds))
        }
        _ => None,
    };
    let integrator = integrator(plan, lights.as_ref(), tree.as_ref(), &stage.tracer)?;

    let window = stage.window;
    let setting = stage.setting(plan.gather, plan.seed);
    let options = RenderOptions { window, share: plan.share };
    let mut rendered = timed(&mut seconds.render, || {
        interrupt::with_flag(|cancel| {
            meter.phase(&format!("rendering {}x{}, {}", window.width, window.height, integrator.name()));
            render(&setting, integrator.as_ref(), &options, &|p| meter.update(p), cancel)
        })
    })?;
    let progress = meter.finish();
    let audit = match (plan.audit, &plan.integration, &lights) {
        (Some(count), Integration::ManyLights { options, .. }, Some(set)) if rendered.complete => {
            let subject = Subject { film: &rendered.film, window, setting, set, options: *options };
            timed(&mut seconds.audit, || {
                interrupt::with_flag(|cancel| audit(count, &subject, &meter, cancel))
            })?
        }
        _ => None,
    };
    if let Some(audit) = &audit {
        meter.finish();
        let metadata = rendered.film.metadata_mut();
        metadata.set("audit.kept", audit.kept);
        metadata.set("audit.of", audit.of);
    }
    let contradicted = audit.as_ref().is_some_and(|audit| audit.contradicts);
    let exposure_stops = timed(&mut seconds.write, || -> Result<f32, Failure> {
        write_exr(&plan.exr, &rendered.film)?;
        Ok(write_png(&plan.png, &rendered.film, &plan.tone_map)?)
    })?;

    let done = Done {
        stage: &stage,
        lights: lights.as_ref(),
        method: integrator.name(),
        totals: rendered.totals,
        // Nothing was told if no tile was finished; then only the window is known.
        pixels_asked: if progress.of > 0 { progress.of } else { window.area() },
        complete: rendered.complete,
        audit,
        exposure_stops,
    };
    let (complete, budget_hit) = (done.complete, done.totals.budget_hit);
    let report = report(plan, done, seconds);
    if let Some(path) = &plan.common.json {
        write_json(path, &report)?;
    }
    if !plan.common.quiet {
        report.rows().print()?;
    }
    Ok(match (complete, budget_hit) {
        (false, _) => Outcome::Interrupted,
        (true, _) if contradicted => Outcome::Contradicted,
        (true, 0) => Outcome::Done,
        (true, _) => Outcome::BudgetHit,
    })
}

fn integrator<'a>(
    plan: &RenderPlan,
    lights: Option<&'a VplSet>,
    tree: Option<&'a LightTree>,
    tracer: &'a Tracer,
) -> Result<Box<dyn Integrator + 'a>, Failure> {
    Ok(match &plan.integration {
        Integration::ManyLights { method, options, .. } => {
            let set = lights.expect("this method's lights were made");
            method.integrator(LitBy { set, tree }, options)
        }
        Integration::Path(paths) => Box::new(Path::new(tracer, *paths, VplOptions::default().max_depth)?),
    })
}

/// A finished render.
struct Done<'a> {
    stage: &'a Stage,
    lights: Option<&'a VplSet>,
    method: &'static str,
    totals: Totals,
    pixels_asked: u64,
    complete: bool,
    audit: Option<Audit>,
    exposure_stops: f32,
}

fn report(plan: &RenderPlan, done: Done<'_>, seconds: Seconds) -> RenderReport {
    let Done { stage, totals, .. } = &done;
    let Stage { scene, camera, size, window, .. } = stage;
    let mean = |sum: u64| if totals.pixels > 0 { sum as f64 / totals.pixels as f64 } else { 0.0 };
    RenderReport {
        version: env!("CARGO_PKG_VERSION"),
        scene: scene.name().to_owned(),
        triangles: Triangles { stored: scene.stored_triangles(), instanced: scene.instanced_triangles() },
        notes: scene.notes().iter().count(),
        camera: camera.name.clone(),
        size: *size,
        window: [window.x, window.y, window.width, window.height],
        tiles: plan.share.to_string(),
        method: done.method,
        paths: if let Integration::Path(paths) = plan.integration { Some(paths) } else { None },
        gather: done.lights.map(|_| plan.gather.points),
        lights: done.lights.map(|set| LightsReport {
            count: set.len() as u64,
            direct: set.provenance().direct,
            indirect: set.provenance().indirect,
            clamp_m: set.provenance().clamp_distance,
            seed: set.provenance().seed,
            file: plan.lights().and_then(Lights::file).map(ToOwned::to_owned),
        }),
        seed: plan.seed,
        pixels: totals.pixels,
        pixels_asked: done.pixels_asked,
        complete: done.complete,
        promise_met: totals.promise_met,
        budget_hit: totals.budget_hit,
        rays_per_pixel: mean(totals.rays),
        pairs_per_pixel: mean(totals.pairs),
        mean_radiance: totals.mean.to_array(),
        rays_per_second: totals.rays as f64 / seconds.render.max(1e-9),
        threads: match plan.common.threads {
            0 => available_parallelism().map_or(1, usize::from),
            threads => threads,
        },
        seconds,
        audit: done.audit,
        exposure_stops: done.exposure_stops,
        files: vec![plan.exr.clone(), plan.png.clone()],
    }
}
