//! What a picture is made of, made once and timed: scene, camera, rays, lights, light tree.

use std::sync::Arc;
use std::time::Instant;

use tashika::accel::Tracer;
use tashika::film::Window;
use tashika::gather::{GatherOptions, View};
use tashika::integrator::Setting;
use tashika::io::load_vpls;
use tashika::request::Framed;
use tashika::scene::{Camera, Scene};
use tashika::tree::{LightTree, LightTreeBuilder};
use tashika::vpl::{VplOptions, VplSet};

use crate::exit::Failure;
use crate::plan::{Lights, StagePlan};
use crate::progress::Meter;
use crate::summary::{Seconds, counted};

/// A scene that is ready for rays, and who looks at it.
pub struct Stage {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The camera.
    pub camera: Camera,
    /// Size of the full image (pixels).
    pub size: [u32; 2],
    /// The part that the user or the camera asks for.
    pub window: Window,
    /// Rays.
    pub tracer: Arc<Tracer>,
}

impl Stage {
    /// Reads the scene and builds the tree for rays, for the one camera that was chosen.
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
        tell_notes(plan, &scene, meter)?;
        let mut framed = Vec::new();
        for camera in plan.cameras.of(&scene)? {
            framed.push(plan.framing.of(&plan.change.of(camera)?)?);
        }
        meter.phase("building the tree for rays");
        let tracer = Arc::new(timed(&mut seconds.ray_tree, || Tracer::new(Arc::clone(&scene))));
        let stage = |Framed { camera, size, window }| {
            let (scene, tracer) = (Arc::clone(&scene), Arc::clone(&tracer));
            Self { scene, camera, size, window, tracer }
        };
        Ok(framed.into_iter().map(stage).collect())
    }

    /// What integrators need.
    pub fn setting(&self, gather: GatherOptions, seed: u64) -> Setting<'_> {
        Setting { tracer: &self.tracer, view: View { camera: &self.camera, size: self.size, gather, seed } }
    }

    /// The lights, `stored` if they come from a file; says what is odd about them.
    pub fn lights(
        &self,
        plan: &Lights,
        stored: Option<VplSet>,
        meter: &Meter,
        seconds: &mut Seconds,
    ) -> Result<VplSet, Failure> {
        let set = match (stored, plan) {
            (Some(set), _) => set,
            (None, Lights::Trace(options)) => self.trace(options, meter, seconds)?,
            (None, Lights::File(path)) => timed(&mut seconds.vpls, || load_vpls(path))?,
        };
        set.validate_for(&self.scene)?;
        if set.is_empty() {
            meter.note("nothing in the scene sends out light; only what is seen directly will show");
        }
        let (theirs, ours) = (&set.provenance().scene, self.scene.name());
        if let (Some(path), true) = (plan.file(), theirs != ours) {
            let path = path.display();
            meter.note(&format!("{path} was traced in the scene {theirs}, not in {ours}"));
        }
        Ok(set)
    }

    /// Traces lights.
    pub fn trace(
        &self,
        options: &VplOptions,
        meter: &Meter,
        seconds: &mut Seconds,
    ) -> Result<VplSet, Failure> {
        meter.phase(&format!("tracing about {}", counted(options.count, "VPL", "VPLs")));
        Ok(timed(&mut seconds.vpls, || VplSet::trace(&self.tracer, options))?)
    }
}

/// The lights of a file, if they come from one: it is small beside most scenes, so that what is
/// wrong with it is told first.
pub fn stored_lights(
    plan: Option<&Lights>,
    meter: &Meter,
    seconds: &mut Seconds,
) -> Result<Option<VplSet>, Failure> {
    let Some(path) = plan.and_then(Lights::file) else { return Ok(None) };
    meter.phase(&format!("reading {}", path.display()));
    Ok(Some(timed(&mut seconds.vpls, || load_vpls(path))?))
}

/// The tree over the lights.
pub fn light_tree(set: &VplSet, meter: &Meter, seconds: &mut Seconds) -> LightTree {
    meter.phase("building the light tree");
    timed(&mut seconds.trees, || LightTree::build(set, LightTreeBuilder::default()))
}

/// Notes on the scene that are told; `info` tells all.
const NOTES_TOLD: usize = 3;

/// Says how the picture may differ from what the file's author saw, or refuses.
fn tell_notes(plan: &StagePlan, scene: &Scene, meter: &Meter) -> Result<(), Failure> {
    if let (true, Some(first)) = (plan.strict, scene.notes().first_departure()) {
        let (at, what) = (&first.first, &first.message);
        return Err(Failure::file(format!("{at}: {what}; not rendered because of --strict")));
    }
    for note in scene.notes().iter().take(NOTES_TOLD) {
        meter.note(&format!("{}: {}", note.first, note.message));
    }
    // Whoever did not ask for light is told of it, whatever else there is.
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

/// Runs `work` and adds the seconds it took.
pub fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let begun = Instant::now();
    let result = work();
    *seconds += begun.elapsed().as_secs_f64();
    result
}
