//! Scene, cameras, tree for rays, and lights from a file. Each is made once, and the time is
//! measured.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use tashika::accel::Tracer;
use tashika::error::Error;
use tashika::io::load_vpls;
use tashika::renderer::{Observer, Prepared, Renderer};
use tashika::request::{CameraChange, Framed, Framing};
use tashika::scene::{Camera, Scene};
use tashika::tree::LightSet;
use tashika::vpl::VplSet;

use crate::exit::Failure;
use crate::plan::{Asked, StagePlan};
use crate::progress::Meter;
use crate::summary::{Seconds, counted};

/// A scene that is ready for rays, and one of its cameras.
pub struct Stage {
    /// Scene, shared with the tracer.
    pub scene: Arc<Scene>,
    /// The camera as the scene has it.
    camera: Camera,
    change: CameraChange,
    /// The camera, the size and the part of the image, as they are rendered.
    pub framed: Framed,
    /// Ray tracer over the scene.
    pub tracer: Tracer,
}

/// Adds the file of the scene to an error about a camera.
fn of_scene(plan: &StagePlan, error: Error) -> Error {
    match error {
        Error::Invalid { mut at, found, expected } => {
            at.file = plan.scene.label().into();
            Error::Invalid { at, found, expected }
        }
        error => error,
    }
}

impl Stage {
    /// Reads the scene and builds the tree for rays, for the only chosen camera; an error if
    /// several are chosen.
    pub fn load(plan: &StagePlan, meter: &Meter, seconds: &mut Seconds) -> Result<Self, Failure> {
        let mut stages = Self::load_all(plan, meter, seconds)?;
        match (stages.pop(), stages.is_empty()) {
            (Some(stage), true) => Ok(stage),
            _ => Err(Failure::option("camera", plan.cameras.typed(), "one camera with this command")),
        }
    }

    /// Reads the scene and builds the tree for rays, once for all the cameras that were chosen; at
    /// least one.
    pub fn load_all(plan: &StagePlan, meter: &Meter, seconds: &mut Seconds) -> Result<Vec<Self>, Failure> {
        meter.phase(&format!("reading {}", plan.scene.label()));
        let scene = Arc::new(timed(&mut seconds.load, || plan.scene.load())?);
        report_notes(plan, &scene, meter)?;
        // Errors about a camera are reported before the work on the trees.
        let mut seen = Vec::new();
        for camera in plan.cameras.of(&scene)? {
            let framed = plan.framing.of(&plan.change.of(camera)?);
            seen.push((camera.clone(), framed.map_err(|error| of_scene(plan, error))?));
        }
        meter.phase("building the tree for rays");
        let tracer = timed(&mut seconds.ray_tree, || Tracer::new(Arc::clone(&scene)));
        let stage = |(camera, framed)| {
            let (scene, tracer) = (Arc::clone(&scene), tracer.clone());
            Self { scene, camera, change: plan.change, framed, tracer }
        };
        Ok(seen.into_iter().map(stage).collect())
    }

    /// Makes the renderer of a request, with the lights of the file if there is one.
    pub fn renderer<'o>(
        &self,
        asked: &Asked,
        stored: Option<Arc<LightSet>>,
        observer: &'o dyn Observer,
    ) -> Renderer<'o> {
        let Framed { size, window, .. } = self.framed;
        let renderer = Renderer::on(&self.tracer)
            .camera(self.camera.clone())
            .camera_change(self.change)
            .framing(Framing { size: Some(size), crop: Some(window) })
            .request(asked.request.clone())
            .tiles(asked.share.clone())
            .observer(observer);
        let renderer = match &asked.smoother {
            Some(smoother) => renderer.smoother(Arc::clone(smoother)),
            None => renderer,
        };
        let renderer = asked.mattes.into_iter().fold(renderer, Renderer::mattes);
        let renderer = if asked.motion_vectors { renderer.motion_vectors() } else { renderer };
        let renderer = asked.groups.iter().cloned().fold(renderer, Renderer::light_groups);
        match stored {
            Some(lights) => renderer.lights(lights),
            None => renderer,
        }
    }

    /// Prepares a render; reports peculiarities of its lights.
    pub fn prepare<'o>(
        &self,
        asked: &Asked,
        stored: Option<VplSet>,
        meter: &Meter,
        observer: &'o dyn Observer,
    ) -> Result<Prepared<'o>, Failure> {
        let prepared = self.renderer(asked, stored.map(|set| Arc::new(set.into())), observer).prepare()?;
        let Some(lights) = prepared.job().provenance() else { return Ok(prepared) };
        if lights.direct + lights.indirect == 0 {
            meter.note("nothing in the scene sends out light; only what is seen directly will show");
        }
        let (theirs, ours) = (&lights.scene, self.scene.name());
        if let (Some(path), true) = (asked.vpl_file(), theirs != ours) {
            let path = path.display();
            meter.note(&format!("{path} was traced in the scene {theirs}, not in {ours}"));
        }
        Ok(prepared)
    }
}

/// Reads the lights from a file, if one is given. The file is smaller than most scenes and is read
/// first, so that its errors are reported early.
pub fn stored_lights(
    path: Option<&Path>,
    meter: &Meter,
    seconds: &mut Seconds,
) -> Result<Option<VplSet>, Failure> {
    let Some(path) = path else { return Ok(None) };
    meter.phase(&format!("reading {}", path.display()));
    Ok(Some(timed(&mut seconds.vpls, || load_vpls(path))?))
}

/// Largest number of notes on the scene that are printed; `info` prints all.
const NOTES_TOLD: usize = 3;

/// Prints notes on how the picture may differ from the scene's file. With `--strict`, such a
/// difference is an error.
fn report_notes(plan: &StagePlan, scene: &Scene, meter: &Meter) -> Result<(), Failure> {
    if let (true, Some(first)) = (plan.strict, scene.notes().first_departure()) {
        let (at, what) = (&first.first, &first.message);
        return Err(Failure::file(format!("{at}: {what}; not rendered because of --strict")));
    }
    for note in scene.notes().iter().take(NOTES_TOLD) {
        meter.note(&format!("{}: {}", note.first, note.message));
    }
    // Default light is always reported, however many notes there are.
    if scene.has_default_light() && scene.notes().iter().count() > NOTES_TOLD {
        meter.note("no light in the scene: the program's own sky and sun are used; --environment and --light give others");
    }
    let more = scene.notes().iter().count().saturating_sub(NOTES_TOLD) as u64;
    if more > 0 {
        let notes = counted(more, "more note", "more notes");
        meter.note(&format!("{notes}; `tashika info {}` lists all", plan.scene.label()));
    }
    Ok(())
}

/// Runs `work` and adds its time.
pub fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let begun = Instant::now();
    let result = work();
    *seconds += begun.elapsed().as_secs_f64();
    result
}
