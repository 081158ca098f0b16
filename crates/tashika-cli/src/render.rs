//! `tashika render`.

use std::path::Path;

use tashika::error::Error;
use tashika::experiment::OtherSet;
use tashika::film::{FoundLight, PictureClaim, RenderFilm, Tally, keys};
use tashika::gather::GatherOptions;
use tashika::integrator::PathStop;
use tashika::io::{KeptTiles, save_vpls, write_exr_as, write_file, write_png};
use tashika::render::Rendered;
use tashika::renderer::{Audit, Job, Prepared};
use tashika::report::{RenderFacts, error_budget, luminance_image, render_page};
use tashika::vpl::VplSet;

use crate::exit::{Failure, Outcome, typed};
use crate::interrupt;
use crate::notes::notes;
use crate::plan::{Outputs, RenderPlan, StagePlan};
use crate::progress::{Meter, metered};
use crate::rescue::rescued;
use crate::serve::LivePage;
use crate::stage::{Stage, stored_lights};
use crate::summary::{self, LightsReport, RenderReport, Seconds, Triangles, typed_command, write_json};
use crate::tev::Viewer;
use crate::vpl;
use crate::watcher::Watcher;

/// Renders and writes the files.
pub fn run(plan: &RenderPlan) -> Result<Outcome, Failure> {
    interrupt::listen(&plan.common);
    metered(&plan.common, |meter| work(plan, meter))
}

fn work(plan: &RenderPlan, meter: &Meter) -> Result<Outcome, Failure> {
    let Some(frames) = plan.frames else {
        return pictures(plan, &plan.stage, None, meter);
    };
    let mut worst = Outcome::Done;
    for (number, seconds) in frames.all() {
        if number > frames.first() && plan.common.prints_rows() {
            summary::print("\n")?;
        }
        worst = worst.max(pictures(plan, &plan.stage.at(seconds), Some(number), meter)?);
        if worst == Outcome::Interrupted {
            break;
        }
    }
    Ok(worst)
}

/// Reports the options that have no effect in this scene, and the option that changes the truth.
fn tell_options(plan: &RenderPlan, stage: &Stage, meter: &Meter) -> Result<(), Failure> {
    let (request, scene) = (&plan.asked.request, stage.tracer.scene());
    for name in request.check_in(scene)? {
        let (option, method) = (typed(name), request.in_scene(scene).method);
        meter.note(&format!(
            "--{option} means nothing to method {method}, which this scene needs, and is not used"
        ));
    }
    if let (Some(file), None) = (plan.asked.vpl_file(), request.truth) {
        let file = file.display();
        meter.note(&format!(
            "what is rendered is the sum over the lights of {file}; --truth transport has light transport by them"
        ));
    }
    Ok(())
}

/// Renders the images of the chosen cameras in one scene; `frame` is the number of a frame, if any.
fn pictures(
    plan: &RenderPlan,
    stage: &StagePlan,
    frame: Option<u32>,
    meter: &Meter,
) -> Result<Outcome, Failure> {
    let mut page = plan.serve.as_ref().map(|serving| LivePage::open(plan, serving, meter)).transpose()?;
    let exr = &plan.outputs.exr;
    let mut viewer = plan.tev.as_deref().map(|address| Viewer::connect(address, exr)).transpose()?;
    let mut seconds = Seconds::default();
    let mut stored = stored_lights(plan.asked.vpl_file(), meter, &mut seconds)?;
    let stages = Stage::load_all(stage, meter, &mut seconds)?;
    if plan.frames.is_none_or(|frames| frame == Some(frames.first())) {
        tell_options(plan, &stages[0], meter)?;
    }
    if let (Some(path), [stage]) = (&plan.write_vpls, stages.as_slice()) {
        let watcher = Watcher::new(meter, seconds);
        let set = stage.renderer(&plan.asked, None, &watcher).trace_lights()?;
        meter.finish();
        save_vpls(path, &set)?;
        return vpl::tell(&plan.common, &set, watcher.seconds().vpls, Some(path));
    }
    let mut outputs = if stage.cameras.several() {
        let names: Vec<&str> = stages.iter().map(|stage| stage.framed.camera.name.as_str()).collect();
        plan.outputs.of_cameras(&names)?
    } else {
        vec![plan.outputs.clone()]
    };
    if let Some(number) = frame {
        outputs.iter_mut().for_each(|files| *files = files.of_frame(number));
    }
    outputs.iter().try_for_each(Outputs::check)?;
    let mut worst = Outcome::Done;
    for (k, (stage, outputs)) in stages.iter().zip(&outputs).enumerate() {
        let mut seconds = seconds.clone();
        // The file is read again for each camera, so that the set need not stay in memory beside
        // the trees built from it.
        let stored = match stored.take() {
            None => stored_lights(plan.asked.vpl_file(), meter, &mut seconds)?,
            read => read,
        };
        if k > 0 && plan.common.prints_rows() {
            summary::print("\n")?;
        }
        let kept = KeptTiles::new(plan.checkpoint.clone());
        let watcher = Watcher::new(meter, seconds)
            .with(kept, viewer.take(), page.take())
            .ending_in(plan.time_limit(stage.framed.window));
        worst = worst.max(image(plan, stage, outputs, stored, watcher, meter)?);
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
    mut watcher: Watcher<'_>,
    meter: &Meter,
) -> Result<Outcome, Failure> {
    let done = {
        let prepared = stage.prepare(&plan.asked, stored, meter, &watcher)?;
        let mut rendered = prepared.render_from(|film| watcher.begin_film(film))?;
        let pixels_asked = meter.finish().of;
        let audit = match plan.audit {
            Some(count) if rendered.complete => prepared.audit(&rendered.film, count)?,
            _ => None,
        };
        if plan.audit.is_some() && !prepared.can_be_audited() {
            meter.note("--audit: this image promises nothing, so that there is nothing to audit");
        }
        if let Some(audit) = &audit {
            meter.finish();
            audit.describe(rendered.film.metadata_mut());
        }
        let write = || -> Result<f32, Failure> {
            let film = &rendered.film;
            write_exr_as(&outputs.exr, film, &plan.layout).map_err(|trouble| {
                rescued(film, &plan.layout, &outputs.exr, &trouble, watcher.checkpoint())
            })?;
            if let (Some(path), Some(scale)) = (&outputs.luminance, &plan.luminance)
                && let Some(picture) = luminance_image(film, scale)
            {
                write_file(path, &picture.png()).map_err(|trouble| beside(&outputs.exr, &trouble))?;
            }
            write_png(&outputs.png, film, &plan.tone_map).map_err(|trouble| beside(&outputs.exr, &trouble))
        };
        let exposure_stops = watcher.timed(|seconds| &mut seconds.write, write)?;
        // This follows after the image is written, because the other set needs as much memory as
        // the first.
        let other_set = prepared.other_set(&rendered)?;
        if other_set.is_some() {
            meter.finish();
        }
        Done {
            lights: lights_report(plan, &prepared),
            job: prepared.job().clone(),
            gather: prepared.setting().view.gather,
            // If no tile is finished, there is no progress, and the number of pixels is that of the
            // window.
            pixels_asked: if pixels_asked > 0 { pixels_asked } else { prepared.window().area() },
            rendered,
            other_set,
            audit,
            exposure_stops,
        }
    };
    watcher.close_viewer();
    let tally = done.rendered.totals.tally;
    let contradicted = done.audit.as_ref().is_some_and(|audit| audit.contradicts);
    // Only an audited picture has a limit on its work. It ends with the precision that is reached.
    let has_limit = plan.asked.request.passes.is_some() || plan.time_limit(stage.framed.window).is_some();
    let accepts_budget = plan.accept_budget || has_limit;
    let ended = match outcome(accepts_budget, done.rendered.complete, contradicted, &tally) {
        // In a share of a job this exit code is suppressed; merging returns it.
        Outcome::NotFinite if plan.accept_budget && !plan.asked.share.is_whole() => Outcome::Done,
        ended => ended,
    };
    let report = report(plan, stage, outputs, &done, ended, watcher.seconds());
    let facts = RenderFacts {
        name: outputs.exr.display().to_string(),
        rows: report.rows().for_page(),
        command: Some(typed_command()),
        tone: plan.tone_map.tone,
        luminance: plan.luminance,
    };
    let Rendered { film, complete, .. } = done.rendered;
    write_file(&outputs.html, render_page(&film, &facts).as_bytes())
        .map_err(|trouble| beside(&outputs.exr, &trouble))?;
    let page = watcher.end(complete)?;
    if let Some(path) = &outputs.json {
        write_json(path, &report)?;
    }
    if plan.common.prints_rows() {
        report.rows().print()?;
    }
    if let Some(page) = page {
        page.end(film, meter);
    }
    Ok(ended)
}

/// Failure to write a file beside the image, after the image itself was written.
fn beside(exr: &Path, trouble: &Error) -> Failure {
    Failure::file(format!("cannot write {trouble}; the image is in {}", exr.display()))
}

pub fn outcome(accepts_budget: bool, complete: bool, contradicted: bool, tally: &Tally) -> Outcome {
    let fallen_short = tally.out_of_budget + tally.not_found;
    match (complete, fallen_short) {
        (false, _) => Outcome::Interrupted,
        (true, _) if tally.not_finite > 0 => Outcome::NotFinite,
        (true, _) if contradicted => Outcome::Contradicted,
        (true, 0) => Outcome::Done,
        (true, _) if accepts_budget => Outcome::Done,
        (true, _) => Outcome::BudgetHit,
    }
}

/// A finished render.
struct Done {
    rendered: Rendered,
    /// Work in this scene; its method may differ from the requested one.
    job: Job,
    lights: Option<LightsReport>,
    gather: GatherOptions,
    pixels_asked: u64,
    other_set: Option<OtherSet>,
    audit: Option<Audit>,
    exposure_stops: f32,
}

/// Description of the lights; `None` if the method has no VPLs.
fn lights_report(plan: &RenderPlan, prepared: &Prepared<'_>) -> Option<LightsReport> {
    let of = prepared.job().provenance()?;
    Some(LightsReport {
        count: of.direct + of.indirect,
        direct: of.direct,
        indirect: of.indirect,
        clamp_m: of.clamp_distance,
        seed: of.seed,
        file: plan.asked.vpl_file.clone(),
    })
}

fn report(
    plan: &RenderPlan,
    stage: &Stage,
    outputs: &Outputs,
    done: &Done,
    ended: Outcome,
    seconds: Seconds,
) -> RenderReport {
    let Done { rendered, lights, job, .. } = done;
    let (totals, metadata, scene) = (&rendered.totals, rendered.film.metadata(), &stage.scene);
    let said = |key| metadata.text(key).map(str::to_owned);
    let (tally, pixels) = (totals.tally, totals.tally.rendered());
    let mean = |sum: u64| if pixels > 0 { sum as f64 / pixels as f64 } else { 0.0 };
    let window = stage.framed.window;
    RenderReport {
        version: env!("CARGO_PKG_VERSION"),
        scene: scene.name().to_owned(),
        triangles: Triangles::of(scene),
        notes: notes(scene),
        default_light: scene.has_default_light(),
        light_changes: scene.changes().to_vec(),
        time_seconds: scene.time(),
        shutter_seconds: stage.framed.camera.motion.as_ref().map(|motion| motion.shutter).or(scene.shutter()),
        camera: stage.framed.camera.name.clone(),
        size: stage.framed.size,
        window: [window.x, window.y, window.width, window.height],
        tiles: plan.asked.share.to_string(),
        method: said(keys::METHOD).unwrap_or_default(),
        paths: match job {
            Job::Path { stop: PathStop::Count(paths) } => Some(*paths),
            _ => None,
        },
        gather: lights.as_ref().map(|_| done.gather.points),
        filter: done.gather.filter,
        lights: lights.clone(),
        seed: plan.asked.request.seed,
        pixels,
        pixels_asked: done.pixels_asked,
        complete: rendered.complete,
        exit_code: ended.code(),
        tally,
        is_audited: job.is_audited(),
        denoiser: said(keys::DENOISER),
        picture_claim: PictureClaim::of(metadata),
        promise_met: tally.claiming(),
        budget_hit: tally.out_of_budget,
        not_found: tally.not_found,
        pairs_are: said(keys::PAIRS_ARE),
        truth: said(keys::TRUTH).filter(|_| job.promises()),
        error_budget: error_budget(&rendered.film),
        rays_per_pixel: mean(totals.rays),
        pairs_per_pixel: mean(totals.pairs),
        mean_radiance: totals.mean.to_array(),
        mean_luminance: RenderFilm::of(&rendered.film).mean_interval(),
        light: FoundLight::of(&rendered.film),
        rays_per_second: totals.rays as f64 / seconds.render.max(1e-9),
        threads: plan.common.thread_count(),
        seconds,
        other_set: done.other_set,
        audit: done.audit.clone(),
        exposure_stops: done.exposure_stops,
        tonemap: plan.tone_map.tone.name(),
        files: outputs.images().cloned().collect(),
    }
}
