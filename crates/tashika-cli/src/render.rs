//! `tashika render`.

use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::Instant;

use tashika::accel::Tracer;
use tashika::film::Window;
use tashika::gather::View;
use tashika::integrator::{Exact, Integrator, Path, Setting};
use tashika::io::{load_vpls, write_exr, write_png};
use tashika::render::{RenderOptions, Totals, render, with_threads};
use tashika::scene::{Camera, Scene};
use tashika::vpl::{VplOptions, VplSet};

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::plan::{Integration, Lights, RenderPlan};
use crate::progress::Meter;
use crate::summary::{LightsReport, RenderReport, Seconds, Triangles, counted, write_json};

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
    // A file of lights is small beside most scenes: what is wrong with it is told first.
    let stored = timed(&mut seconds.vpls, || stored_lights(plan, &meter))?;
    meter.phase(&format!("reading {}", plan.scene.label()));
    let scene = Arc::new(timed(&mut seconds.load, || plan.scene.load())?);
    tell_notes(plan, &scene, &meter)?;
    let camera = choose_camera(plan, &scene)?;
    let (size, window) = plan.window(camera)?;
    meter.phase("building the tree for rays");
    let tracer = timed(&mut seconds.ray_tree, || Tracer::new(Arc::clone(&scene)));
    let lights = match stored {
        Some(set) => Some(set),
        None => timed(&mut seconds.vpls, || traced_lights(plan, &tracer, &meter))?,
    };
    tell_lights(plan, lights.as_ref(), &scene, &meter);
    let integrator = integrator(plan, lights.as_ref(), &tracer)?;

    let view = View { camera, size, gather: plan.gather, seed: plan.seed };
    let options = RenderOptions { window, share: plan.share };
    let rendered = timed(&mut seconds.render, || {
        let setting = Setting { tracer: &tracer, view };
        interrupt::with_flag(|cancel| {
            meter.phase(&format!("rendering {}x{}, {}", window.width, window.height, integrator.name()));
            render(&setting, integrator.as_ref(), &options, &|p| meter.update(p), cancel)
        })
    })?;
    let progress = meter.finish();
    let exposure_stops = timed(&mut seconds.write, || -> Result<f32, Failure> {
        write_exr(&plan.exr, &rendered.film)?;
        Ok(write_png(&plan.png, &rendered.film, &plan.tone_map)?)
    })?;

    let done = Done {
        scene: &scene,
        view,
        window,
        lights: lights.as_ref(),
        method: integrator.name(),
        totals: rendered.totals,
        // Nothing was told if no tile was finished; then only the window is known.
        pixels_asked: if progress.of > 0 { progress.of } else { window.area() },
        complete: rendered.complete,
        exposure_stops,
    };
    let report = report(plan, &done, seconds);
    if let Some(path) = &plan.common.json {
        write_json(path, &report)?;
    }
    if !plan.common.quiet {
        report.rows().print()?;
    }
    Ok(match (done.complete, done.totals.budget_hit) {
        (false, _) => Outcome::Interrupted,
        (true, 0) => Outcome::Done,
        (true, _) => Outcome::BudgetHit,
    })
}

/// Notes on the scene that are told by a render; `info` tells all.
const NOTES_TOLD: usize = 3;

/// Says how the picture may differ from what the file's author saw, or refuses.
fn tell_notes(plan: &RenderPlan, scene: &Scene, meter: &Meter) -> Result<(), Failure> {
    if let (true, Some(first)) = (plan.strict, scene.notes().first_departure()) {
        let (at, what) = (&first.first, &first.message);
        return Err(Failure::file(format!("{at}: {what}; not rendered because of --strict")));
    }
    for note in scene.notes().iter().take(NOTES_TOLD) {
        meter.note(&format!("{}: {}", note.first, note.message));
    }
    let more = scene.notes().iter().count().saturating_sub(NOTES_TOLD) as u64;
    if more > 0 {
        let notes = counted(more, "more note", "more notes");
        meter.note(&format!("{notes}; `tashika info {}` lists all", plan.scene.label()));
    }
    Ok(())
}

fn choose_camera<'s>(plan: &RenderPlan, scene: &'s Scene) -> Result<&'s Camera, Failure> {
    match &plan.camera {
        None => Ok(&scene.cameras()[0]),
        Some(name) => scene.camera(name).ok_or_else(|| {
            let names: Vec<&str> = scene.cameras().iter().map(|c| c.name.as_str()).collect();
            Failure::option("camera", name, format!("one of the scene's: {}", names.join(", ")))
        }),
    }
}

/// The lights of a file, if they come from one.
fn stored_lights(plan: &RenderPlan, meter: &Meter) -> Result<Option<VplSet>, Failure> {
    let Integration::Exact(Lights::File(path)) = &plan.integration else { return Ok(None) };
    meter.phase(&format!("reading {}", path.display()));
    Ok(Some(load_vpls(path)?))
}

/// Lights traced for this render, if its method has lights.
fn traced_lights(plan: &RenderPlan, tracer: &Tracer, meter: &Meter) -> Result<Option<VplSet>, Failure> {
    let Integration::Exact(Lights::Trace(options)) = &plan.integration else { return Ok(None) };
    meter.phase(&format!("tracing about {}", counted(options.count, "VPL", "VPLs")));
    Ok(Some(VplSet::trace(tracer, options)?))
}

/// Says what is odd about the lights.
fn tell_lights(plan: &RenderPlan, lights: Option<&VplSet>, scene: &Scene, meter: &Meter) {
    let Some(set) = lights else { return };
    if set.is_empty() {
        meter.note("nothing in the scene sends out light; only what is seen directly will show");
    }
    let theirs = &set.provenance().scene;
    if let (Some(path), true) = (plan.lights_file(), theirs != scene.name()) {
        let (path, ours) = (path.display(), scene.name());
        meter.note(&format!("{path} was traced in the scene {theirs}, not in {ours}"));
    }
}

fn integrator<'a>(
    plan: &RenderPlan,
    lights: Option<&'a VplSet>,
    tracer: &'a Tracer,
) -> Result<Box<dyn Integrator + 'a>, Failure> {
    Ok(match plan.integration {
        Integration::Exact(_) => Box::new(Exact::new(lights.expect("this method's lights were made"))),
        Integration::Path(paths) => Box::new(Path::new(tracer, paths, VplOptions::default().max_depth)?),
    })
}

/// A finished render.
struct Done<'a> {
    scene: &'a Scene,
    view: View<'a>,
    window: Window,
    lights: Option<&'a VplSet>,
    method: &'static str,
    totals: Totals,
    pixels_asked: u64,
    complete: bool,
    exposure_stops: f32,
}

fn report(plan: &RenderPlan, done: &Done<'_>, seconds: Seconds) -> RenderReport {
    let Done { scene, view, window, totals, .. } = done;
    let mean = |sum: u64| if totals.pixels > 0 { sum as f64 / totals.pixels as f64 } else { 0.0 };
    RenderReport {
        version: env!("CARGO_PKG_VERSION"),
        scene: scene.name().to_owned(),
        triangles: Triangles { stored: scene.stored_triangles(), instanced: scene.instanced_triangles() },
        notes: scene.notes().iter().count(),
        camera: view.camera.name.clone(),
        size: view.size,
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
            file: plan.lights_file().map(ToOwned::to_owned),
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
        audit: None,
        exposure_stops: done.exposure_stops,
        files: vec![plan.exr.clone(), plan.png.clone()],
    }
}

/// Runs `work` and adds the seconds it took.
fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let begun = Instant::now();
    let result = work();
    *seconds += begun.elapsed().as_secs_f64();
    result
}
