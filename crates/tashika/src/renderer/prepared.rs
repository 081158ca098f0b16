//! One view with its lights, ready to be rendered and judged.

use std::sync::Arc;

use super::observer::{Observer, Phase, during};
use super::{Audit, AuditedJob, Job, audit, audited};
use crate::accel::Tracer;
use crate::error::{Error, Result};
use crate::experiment::{OtherSet, until_converged};
use crate::film::{Film, Window, keys};
use crate::gather::{GatherOptions, View};
use crate::integrator::{
    ControlOptions, FullSum, Integrator, LightTransport, PathStop, PathTracer, Setting, WithPlanes,
};
use crate::reconstruction::Smoother;
use crate::render::{
    Begun, Finished, RenderOptions, Rendered, TileShare, add_mattes, add_motion, add_time, add_transmittance,
    blank, resume,
};
use crate::request::{CameraChange, ClaimName};
use crate::rng::{self, Purpose};
use crate::scene::{Camera, LightGrouping, LightGroups};
use crate::vpl::VplOptions;

/// Number of the key of a pilot among those of guidance.
const PILOT: u64 = 0x1e57;

/// Groups of lights with planes of their contributions.
#[derive(Clone)]
pub(super) struct Grouped {
    pub grouping: LightGrouping,
    pub groups: LightGroups,
    /// Number of separate paths a pixel for these planes; `None` if they use the paths of the
    /// pixels.
    pub paths: Option<u32>,
}

/// One view of a scene with its lights, ready to be rendered: the result of
/// [`Renderer::prepare`](super::Renderer::prepare).
///
/// ```
/// use tashika::{Renderer, scene::builtin};
///
/// let prepared = Renderer::new(builtin::tiny()).error(0.2).size([16, 12]).vpls(20_000).prepare()?;
/// let image = prepared.render()?;
/// let audit = prepared.audit(&image.film, 20)?.expect("there is a claim, and nobody cancels");
/// assert!(!audit.contradicts, "{} of {} are within the error", audit.within, audit.of);
/// # Ok::<(), tashika::error::Error>(())
/// ```
#[derive(Clone)]
pub struct Prepared<'a> {
    pub(super) tracer: Tracer,
    pub(super) camera: Camera,
    pub(super) change: CameraChange,
    pub(super) size: [u32; 2],
    pub(super) window: Window,
    pub(super) share: TileShare,
    pub(super) mattes: Option<u32>,
    pub(super) motion: bool,
    pub(super) groups: Option<Grouped>,
    pub(super) gather: GatherOptions,
    pub(super) seed: u64,
    pub(super) job: Job,
    pub(super) unused: Vec<&'static str>,
    pub(super) smoother: Option<Arc<dyn Smoother>>,
    pub(super) observer: &'a dyn Observer,
}

impl Prepared<'_> {
    /// Scene with its tree for rays, and view.
    pub fn setting(&self) -> Setting<'_> {
        let Self { camera, size, gather, seed, .. } = self;
        Setting { tracer: &self.tracer, view: View { camera, size: *size, gather: *gather, seed: *seed } }
    }

    /// Part of the image that is rendered.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Work of this view: its method, with the lights.
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// Names of the given options that have no effect on the method (see
    /// [`Plan::unused`](crate::request::Plan::unused)).
    pub fn unused(&self) -> &[&'static str] {
        &self.unused
    }

    /// Returns this view with another tracer for the same scene, such as one with a
    /// [listener](Tracer::with_listener) or the [scalar twin](Tracer::plain).
    #[must_use]
    pub fn on(&self, tracer: &Tracer) -> Self {
        Self { tracer: tracer.clone(), ..self.clone() }
    }

    /// Returns the integrator of this view.
    ///
    /// # Errors
    /// Options out of range.
    pub fn integrator(&self) -> Result<Box<dyn Integrator + '_>> {
        Ok(match &self.job {
            Job::Sum { method, options, lights, .. } => method.integrator(lights, options)?,
            Job::Transport { options, lights, .. }
            | Job::Audited(AuditedJob { options, lights: Some(lights), .. }) => {
                let transport = LightTransport::new(&self.tracer, lights, options);
                match &self.groups {
                    Some(Grouped { groups, paths: Some(paths), .. }) => {
                        let tracer = self.path_tracer(PathStop::Count(*paths))?;
                        Box::new(WithPlanes::new(transport, tracer.with_groups(groups)))
                    }
                    _ => Box::new(transport),
                }
            }
            Job::Audited(AuditedJob { options, lights: None, .. }) => {
                Box::new(self.path_tracer(self.of_audited(options)?)?)
            }
            Job::Path { stop } => {
                let tracer = self.path_tracer(self.in_view(*stop)?)?;
                Box::new(match &self.groups {
                    Some(Grouped { groups, .. }) => tracer.with_groups(groups),
                    None => tracer,
                })
            }
        })
    }

    /// Returns the stopping rule. If it stops at our own interval, its absolute error is replaced
    /// by the one for this view.
    fn in_view(&self, stop: PathStop) -> Result<PathStop> {
        let PathStop::Calibrated { options, most } = stop else { return Ok(stop) };
        let brightness = self.path_tracer(PathStop::Count(1))?.importance_brightness(&self.setting());
        Ok(PathStop::Calibrated { options: options.in_view_of(brightness), most })
    }

    /// Key of the random numbers of a pilot.
    pub(super) fn pilot_key(&self) -> u64 {
        rng::key(self.seed, Purpose::Guidance, PILOT)
    }

    /// Stopping rule with which path tracing would bring each single pixel of an audited picture
    /// within the tolerance.
    pub(super) fn of_audited(&self, options: &ControlOptions) -> Result<PathStop> {
        const MOST_PATHS: u32 = 1 << 17;
        self.in_view(PathStop::Calibrated { options: *options, most: MOST_PATHS })
    }

    pub(super) fn path_tracer(&self, stop: PathStop) -> Result<PathTracer<'_>> {
        PathTracer::new(&self.tracer, stop, VplOptions::default().path_depth())
    }

    /// Renders the view.
    ///
    /// # Errors
    /// Options out of range.
    pub fn render(&self) -> Result<Rendered> {
        self.render_from(|film| Ok(Begun { film, tiles: Vec::new() }))
    }

    /// Renders the view with another integrator, such as a method of one's own.
    ///
    /// # Errors
    /// [`Error::Option`](crate::error::Error::Option) if the integrator cannot render the scene, or
    /// if a picture of this view is audited as a whole.
    pub fn render_with(&self, integrator: &dyn Integrator) -> Result<Rendered> {
        if self.job.is_audited() {
            return Err(Error::option("claim", ClaimName::Audited, "a claim about each pixel, or an error"));
        }
        let phase = self.phase_of_pixels(integrator, false);
        let rendered =
            self.render_radiance(integrator, phase, |film| Ok(Begun { film, tiles: Vec::new() }))?;
        Ok(self.with_first_surfaces(rendered))
    }

    /// Renders the tiles that are not finished. `begin` receives the empty film, whose metadata
    /// identifies the render. It returns the film and the tiles that are finished already, as
    /// [`KeptTiles::begin`](crate::io::KeptTiles::begin) does.
    ///
    /// # Errors
    /// Options out of range; any error of `begin`.
    pub fn render_from(&self, begin: impl FnOnce(Film) -> Result<Begun>) -> Result<Rendered> {
        let rendered = if let Job::Audited(job) = &self.job {
            audited::render(self, job, begin)?
        } else {
            let integrator = self.integrator()?;
            let phase = self.phase_of_pixels(integrator.as_ref(), self.job.promises());
            self.render_radiance(integrator.as_ref(), phase, begin)?
        };
        Ok(self.with_first_surfaces(rendered))
    }

    /// Adds the planes of first surfaces that are requested, or that the scene needs.
    fn with_first_surfaces(&self, mut rendered: Rendered) -> Rendered {
        if let Some(ranks) = self.mattes {
            let samples = self.seen_samples();
            during(self.observer, Phase::Mattes, || {
                add_mattes(&self.setting(), &mut rendered.film, samples, ranks);
            });
        }
        let scene = self.tracer.scene();
        let blurs = scene.moves() || self.camera.motion.is_some();
        if self.motion || blurs || scene.has_media() {
            let (setting, samples) = (self.setting(), self.seen_samples());
            during(self.observer, Phase::FirstSurfaces, || {
                if self.motion {
                    add_motion(&setting, &mut rendered.film);
                }
                if blurs {
                    add_time(&setting, &mut rendered.film, samples);
                }
                if scene.has_media() {
                    add_transmittance(&setting, &mut rendered.film, samples);
                }
            });
        }
        rendered
    }

    /// Number of camera samples a pixel for mattes, times and transmittances. These are the samples
    /// of the gather points, if the method has any.
    fn seen_samples(&self) -> u32 {
        const OF_PATHS: u32 = 64;
        match self.job {
            Job::Sum { .. } | Job::Transport { .. } => self.gather.points,
            Job::Path { .. } | Job::Audited(_) => OF_PATHS,
        }
    }

    fn phase_of_pixels(&self, integrator: &dyn Integrator, promises: bool) -> Phase {
        let (method, is_of_a_sum) = (integrator.name(), self.job.is_of_a_sum());
        Phase::Pixels { method, window: self.window, is_of_a_sum, promises }
    }

    fn render_radiance(
        &self,
        integrator: &dyn Integrator,
        phase: Phase,
        begin: impl FnOnce(Film) -> Result<Begun>,
    ) -> Result<Rendered> {
        let setting = self.setting();
        let options = RenderOptions { window: self.window, share: self.share.clone() };
        let mut film = blank(&setting, integrator, &options)?;
        self.change.describe(film.metadata_mut());
        if let Some(Grouped { grouping, paths, .. }) = &self.groups {
            film.metadata_mut().set(keys::LIGHT_GROUPS, grouping.to_string());
            if let Some(paths) = paths {
                film.metadata_mut().set(keys::LIGHT_GROUPS_PATHS, *paths);
            }
        }
        let begun = begin(film)?;
        let watch = |done: &Finished<'_>| self.observer.tile(done);
        during(self.observer, phase, || {
            resume(&setting, integrator, &options, begun, &watch, self.observer.cancel())
        })
    }

    /// Returns true if there is a promise about each pixel that [`audit`](Self::audit) can judge.
    pub fn can_be_audited(&self) -> bool {
        self.promise(None).is_some()
    }

    /// Computes the truth of `count` random pixels of a finished film of this view, and counts the
    /// pixels within the error. The truths are exact sums if the promise is about a sum, and
    /// otherwise path-traced with random numbers that the film did not use. In dark pixels the
    /// tolerance is the absolute error of the film. `None` if there is no promise to judge, or if
    /// the audit was cancelled.
    ///
    /// # Errors
    /// A film of another view.
    pub fn audit(&self, film: &Film, count: u64) -> Result<Option<Audit>> {
        let absolute = film.metadata().number(keys::ERROR_ABSOLUTE);
        let Some(promise) = self.promise(absolute) else { return Ok(None) };
        let (truth, setting) = self.truth(&promise)?;
        audit::of(film, count, &setting, truth.as_ref(), &promise, self.observer)
    }

    /// Compares a finished film of this view with one rendered with another set of equally many
    /// VPLs. `None` if the VPLs were given, if the truth does not depend on one set, if only a part
    /// was rendered, or if cancelled.
    ///
    /// # Errors
    /// A film of another view.
    pub fn other_set(&self, rendered: &Rendered) -> Result<Option<OtherSet>> {
        let Job::Sum { method, options, traced: Some(lights), .. } = &self.job else { return Ok(None) };
        if !self.is_whole(rendered) {
            return Ok(None);
        }
        during(self.observer, Phase::OtherSet, || {
            OtherSet::of(&rendered.film, &self.setting(), *method, options, lights, self.observer.cancel())
        })
    }

    fn is_whole(&self, rendered: &Rendered) -> bool {
        rendered.complete && self.share.is_whole()
    }

    /// Returns the options that state the promised distance from the truth, if there is a promise.
    ///
    /// * `absolute`: absolute error that suffices in dark pixels, if a film states one
    ///   (W·m⁻²·sr⁻¹).
    pub(super) fn promise(&self, absolute: Option<f64>) -> Option<ControlOptions> {
        let options = self.job.options_of_pixels()?;
        Some(ControlOptions { absolute_error: absolute.unwrap_or(options.absolute_error), ..*options })
    }

    /// Returns an integrator and a setting for the truth of this view, accurate enough to judge the
    /// promise.
    pub(super) fn truth(&self, promise: &ControlOptions) -> Result<(Box<dyn Integrator + '_>, Setting<'_>)> {
        /// Offset added to the seed if the film itself is path-traced.
        const OTHER_PATHS: u64 = 0x7a_a0d1_7000;
        let mut setting = self.setting();
        match &self.job {
            Job::Sum { lights, .. } => return Ok((Box::new(FullSum::new(lights.set())), setting)),
            Job::Path { .. } => setting.view.seed = setting.view.seed.wrapping_add(OTHER_PATHS),
            Job::Transport { .. } | Job::Audited(_) => {}
        }
        let stop = until_converged(promise, Audit::MOST_PATHS);
        Ok((Box::new(self.path_tracer(stop)?), setting))
    }
}
