//! The pipeline from a scene and a request to a film, and to judgements of that film.
//!
//! [`Renderer`] holds the request. [`Renderer::prepare`] plans it for the scene and traces the
//! lights of one view. [`Prepared`] renders the view and judges the film. The program, the Python
//! package, experiments and benchmarks only make these calls; all of the work is done here.
//!
//! ```text
//! Renderer ── prepare ─► Prepared ── render ─► Rendered { film, totals }
//!  scene, camera,         view, Job        ├─ audit ─► Audit          share of the pixels within the error
//!  Request ─ plan ─► Plan  (method, lights) └─ other_set ─► OtherSet   change by other VPLs
//! ```
//!
//! # Guarantee
//! A film is a function of scene, camera, size and [`Request`], bit for bit. The number of threads,
//! the window, the share of tiles and the [`Observer`] do not change a pixel.
//!
//! # Held to this by
//! `renderer::tests`; the program's tests `parts`, and the package's `test_program.py`, which
//! compares planes from Python with those of the program.

mod audit;
mod audited;
mod job;
mod light_cache;
mod observer;
mod prepared;

#[cfg(test)]
mod tests;

pub use audit::Audit;
pub use audited::finish_merged;
pub use job::{AuditedJob, Job};
pub use light_cache::LightCache;
pub use observer::{Observer, Phase, Silent};
pub use prepared::Prepared;

use std::sync::Arc;

use prepared::Grouped;

use crate::accel::Tracer;
use crate::color::Controlled;
use crate::error::{Error, Result};
use crate::film::{Matte, Window};
use crate::gather::{Filter, View};
use crate::integrator::{GuidedLights, Truth};
use crate::reconstruction::Smoother;
use crate::render::{Rendered, TileShare};
use crate::request::{CameraChange, ClaimName, Framed, Framing, Method, MethodName, Plan, Quality, Request};
use crate::scene::{Camera, LightGrouping, LightGroups, Scene};
use crate::tree::LightSet;
use crate::vpl::{Clamp, VplOptions, VplSet};

/// A scene, and the options of its render.
///
/// Unset options have the defaults of [`Request`]: an audited picture of light transport, by our
/// own method. A time limit is the [observer's](Observer::seconds_left); without one, the picture
/// takes up to 64 million paths. [`prepare`](Self::prepare) checks all values at once. Work runs on
/// the current thread pool ([`with_threads`](crate::render::with_threads) makes another).
///
/// ```
/// use tashika::{Renderer, scene::builtin};
///
/// let image = Renderer::new(builtin::tiny()).error(0.2).size([16, 12]).vpls(20_000).render()?;
/// let claims = image.totals.tally;
/// println!("{} of {} pixels claim to be within 20 %", claims.claiming(), claims.rendered());
/// # assert!(image.complete && claims.claiming() > 96);
/// # Ok::<(), tashika::error::Error>(())
/// ```
#[derive(Clone)]
pub struct Renderer<'a> {
    tracer: Tracer,
    request: Request,
    camera: Option<Camera>,
    change: CameraChange,
    framing: Framing,
    share: TileShare,
    mattes: Option<u32>,
    motion: bool,
    groups: Option<LightGrouping>,
    lights: Option<Arc<LightSet>>,
    cache: Option<&'a LightCache>,
    smoother: Option<Arc<dyn Smoother>>,
    observer: &'a dyn Observer,
}

impl<'a> Renderer<'a> {
    /// Returns a renderer of a scene; builds the tree for rays.
    pub fn new(scene: impl Into<Arc<Scene>>) -> Self {
        Self::on(&Tracer::new(scene.into()))
    }

    /// Returns a renderer that shares an existing tree for rays.
    pub fn on(tracer: &Tracer) -> Self {
        Self {
            tracer: tracer.clone(),
            request: Request::default(),
            camera: None,
            change: CameraChange::default(),
            framing: Framing::default(),
            share: TileShare::default(),
            mattes: None,
            motion: false,
            groups: None,
            lights: None,
            cache: None,
            smoother: None,
            observer: &Silent,
        }
    }

    /// Sets the observer, which receives progress and may cancel the work. Default: none.
    #[must_use]
    pub fn observer(self, observer: &'a dyn Observer) -> Self {
        Self { observer, ..self }
    }

    /// Sets the smoother of audited pictures. Default: our own.
    #[must_use]
    pub fn smoother(self, smoother: Arc<dyn Smoother>) -> Self {
        Self { smoother: Some(smoother), ..self }
    }

    /// Sets all options at once, except for the lights of [`lights`](Self::lights).
    #[must_use]
    pub fn request(self, request: Request) -> Self {
        Self { request, ..self }
    }

    /// Sets the camera. Default: the scene's first camera.
    #[must_use]
    pub fn camera(self, camera: Camera) -> Self {
        Self { camera: Some(camera), ..self }
    }

    /// Sets changes to the camera.
    #[must_use]
    pub fn camera_change(self, change: CameraChange) -> Self {
        Self { change, ..self }
    }

    /// Sets the size of the image and its rendered part.
    #[must_use]
    pub fn framing(self, framing: Framing) -> Self {
        Self { framing, ..self }
    }

    /// Sets the size of the full image: width, height (pixels). Default: the camera's, or 640×360.
    #[must_use]
    pub fn size(mut self, size: [u32; 2]) -> Self {
        self.framing.size = Some(size);
        self
    }

    /// Sets the rendered part of the image (pixels). Default: all.
    #[must_use]
    pub fn crop(mut self, window: Window) -> Self {
        self.framing.crop = Some(window);
        self
    }

    /// Sets the share of the tiles that is rendered, for several machines. Default: all.
    #[must_use]
    pub fn tiles(self, share: TileShare) -> Self {
        Self { share, ..self }
    }

    /// Adds mattes of objects and materials to the film, with `ranks` ranks (1 to
    /// [`Matte::MOST_RANKS`]): see [`add_mattes`](crate::render::add_mattes). Default: none.
    #[must_use]
    pub fn mattes(self, ranks: u32) -> Self {
        Self { mattes: Some(ranks), ..self }
    }

    /// Adds the plane `motion`: displacement on the film, while the shutter is open, of the
    /// surfaces that a pixel shows; see [`add_motion`](crate::render::add_motion). Default: none.
    #[must_use]
    pub fn motion_vectors(self) -> Self {
        Self { motion: true, ..self }
    }

    /// Adds planes of the radiance of each group of lights, by path tracing (see
    /// [`PathTracer::with_groups`](crate::integrator::PathTracer::with_groups)). Path tracing uses
    /// the paths of the pixels for these planes; the default method traces [separate
    /// paths](Request::paths_of_groups). Default: none.
    #[must_use]
    pub fn light_groups(self, grouping: LightGrouping) -> Self {
        Self { groups: Some(grouping), ..self }
    }

    /// Sets the method. Default: our own.
    #[must_use]
    pub fn method(mut self, method: impl Into<MethodName>) -> Self {
        self.request.method = method.into();
        self
    }

    /// Sets the relative error `ε` allowed in a pixel; in (0, 1].
    #[must_use]
    pub fn error(mut self, error: f64) -> Self {
        self.request.error = Some(error);
        self
    }

    /// Sets the absolute error that suffices in dark pixels (W·m⁻²·sr⁻¹); at least 0.
    #[must_use]
    pub fn absolute(mut self, error: f64) -> Self {
        self.request.absolute = Some(error);
        self
    }

    /// Sets the error metric.
    #[must_use]
    pub fn control(mut self, controlled: Controlled) -> Self {
        self.request.control = Some(controlled);
        self
    }

    /// Sets the confidence of the intervals; in (0, 1).
    #[must_use]
    pub fn confidence(mut self, confidence: f64) -> Self {
        self.request.confidence = Some(confidence);
        self
    }

    /// Sets the kind of claim: about each pixel, justified by measurement or by a theorem, or about
    /// the picture as a whole.
    #[must_use]
    pub fn claim(mut self, claim: impl Into<ClaimName>) -> Self {
        self.request.claim = Some(claim.into());
        self
    }

    /// Sets the claim and the error to those of a quality preset, unless they are set already.
    #[must_use]
    pub fn quality(mut self, quality: Quality) -> Self {
        self.request = self.request.of_quality(quality);
        self
    }

    /// Sets the truth, the quantity from which errors are measured.
    #[must_use]
    pub fn truth(mut self, truth: Truth) -> Self {
        self.request.truth = Some(truth);
        self
    }

    /// Sets the largest cut (pairs of clusters); at least 1.
    #[must_use]
    pub fn max_pairs(mut self, pairs: u64) -> Self {
        self.request.max_pairs = Some(pairs);
        self
    }

    /// Sets the number of passes of an audited picture, 1 to 13: a fixed amount of work.
    #[must_use]
    pub fn passes(mut self, passes: u64) -> Self {
        self.request.passes = Some(passes);
        self
    }

    /// Sets the paths a pixel of path tracing.
    #[must_use]
    pub fn paths(mut self, paths: u64) -> Self {
        self.request.paths = Some(paths);
        self
    }

    /// Sets the approximate number of VPLs to trace.
    #[must_use]
    pub fn vpls(mut self, count: u64) -> Self {
        self.request.vpls = Some(count);
        self
    }

    /// Sets the VPLs to render with, instead of tracing them. The default truth is then the sum
    /// over them.
    #[must_use]
    pub fn lights(self, lights: impl Into<Arc<LightSet>>) -> Self {
        Self { lights: Some(lights.into()), ..self }
    }

    /// Sets a cache of guided VPLs, which is searched before VPLs are traced, and stores them for
    /// the next render.
    #[must_use]
    pub fn light_cache(self, cache: &'a LightCache) -> Self {
        Self { cache: Some(cache), ..self }
    }

    /// Sets the distance below which the contribution of a VPL is clamped.
    #[must_use]
    pub fn clamp(mut self, clamp: Clamp) -> Self {
        self.request.clamp = Some(clamp);
        self
    }

    /// Sets the gather points a pixel; 1 to 1024.
    #[must_use]
    pub fn gather_points(mut self, points: u64) -> Self {
        self.request.gather = Some(points);
        self
    }

    /// Sets the pixel filter. Default: the box.
    #[must_use]
    pub fn filter(mut self, filter: Filter) -> Self {
        self.request.filter = Some(filter);
        self
    }

    /// Sets the seed of all random numbers.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        self.request.seed = seed;
        self
    }

    /// Prepares the camera, the lights, and the light trees of a render.
    ///
    /// # Errors
    /// [`Error::Option`] naming an option that is out of range or contradicts other options or the
    /// scene, such as a method without motion in a scene that moves; lights of another scene.
    pub fn prepare(&self) -> Result<Prepared<'a>> {
        let (Plan { method, gather, unused }, Framed { camera, size, window }) = self.plan()?;
        let groups = self.groups.as_ref().map(|grouping| self.grouped(grouping, &method)).transpose()?;
        let seed = self.request.seed;
        let job = self.job(method, &View { camera: &camera, size, gather, seed })?;
        Ok(Prepared {
            tracer: self.tracer.clone(),
            camera,
            change: self.change,
            size,
            window,
            share: self.share.clone(),
            mattes: self.mattes.map(|ranks| Matte::ranks(ranks.into())).transpose()?,
            motion: self.motion,
            groups,
            gather,
            seed,
            job,
            unused,
            smoother: self.smoother.clone(),
            observer: self.observer,
        })
    }

    /// Prepares the view and renders it.
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare).
    pub fn render(&self) -> Result<Rendered> {
        self.prepare()?.render()
    }

    /// Traces the set of VPLs that [`prepare`](Self::prepare) would trace, and does nothing else.
    /// Stored as a file, the set can be shared by the parts of a picture.
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare); also a method that traces no VPLs.
    pub fn trace_lights(&self) -> Result<VplSet> {
        let (Plan { method, gather, .. }, Framed { camera, size, .. }) = self.plan()?;
        let view = View { camera: &camera, size, gather, seed: self.request.seed };
        match &method {
            Method::Sum { lights: Some(options), .. } => {
                self.tell(options.count, || VplSet::trace(&self.tracer, options))
            }
            Method::Transport { lights: Some(options), truth, .. } => {
                self.tell(options.count, || GuidedLights::trace_set(&self.tracer, options, *truth, &view))
            }
            _ => Err(Error::option("method", self.request.method, "one that traces lights")),
        }
    }

    fn plan(&self) -> Result<(Plan, Framed)> {
        let scene = self.tracer.scene();
        let request = Request {
            lights_given: self.lights.is_some() || self.request.lights_given,
            groups_asked: self.groups.is_some(),
            ..self.request.clone()
        };
        let first = &scene.cameras()[0];
        let camera = self.change.of(self.camera.as_ref().unwrap_or(first))?;
        let plan = request.plan(scene)?;
        request.check_passes(self.observer.seconds_left().is_some(), self.share.is_whole())?;
        let mut framed = self.framing.of(&camera)?;
        framed.camera.index = self.tracer.index_around_camera(&framed.camera);
        Ok((plan, framed))
    }

    /// Groups of the scene's lights, for a method that can separate their contributions.
    fn grouped(&self, grouping: &LightGrouping, method: &Method) -> Result<Grouped> {
        let paths = match method {
            Method::Path { .. } => None,
            Method::Transport { truth: Truth::Transport, .. } => Some(self.request.paths_of_groups()?),
            _ => {
                let expected = "none but with a picture of light transport, by the default method or by method path, \
                                that is not audited: others are not the sum of what lights give";
                return Err(Error::option("groups", grouping, expected));
            }
        };
        let groups = LightGroups::new(self.tracer.scene(), grouping)?;
        Ok(Grouped { grouping: grouping.clone(), groups, paths })
    }

    /// Returns the work of a method, with the lights that it needs.
    fn job(&self, method: Method, view: &View<'_>) -> Result<Job> {
        let tracer = &self.tracer;
        Ok(match method {
            Method::Sum { method, lights: traced, options } => {
                let lights = match &traced {
                    Some(of_lights) => Arc::new(LightSet::new(
                        self.tell(of_lights.count, || VplSet::trace(tracer, of_lights))?,
                    )),
                    None => self.given_about_origin()?,
                };
                lights.set().validate_for(tracer.scene())?;
                let terms = lights.set().len() as u64 * u64::from(view.gather.points);
                let method = method.for_terms(terms, options.max_pairs);
                if method.needs_tree() {
                    observer::during(self.observer, Phase::LightTree, || lights.tree());
                }
                Job::Sum { method, options, lights, traced }
            }
            Method::Transport { lights: Some(of_lights), truth, options } => {
                let trace = || {
                    self.tell(of_lights.count, || {
                        GuidedLights::trace(tracer, &of_lights, truth, view).map(Arc::new)
                    })
                };
                let lights = match self.cache {
                    Some(cache) => cache.lights(&of_lights, truth, view, trace)?,
                    None => trace()?,
                };
                Job::Transport { truth, options, lights }
            }
            Method::Transport { lights: None, truth, options } => {
                let set = self.given()?.set();
                let guided = || GuidedLights::given(tracer, set, truth, view);
                let lights = Arc::new(observer::during(self.observer, Phase::LightTree, guided)?);
                Job::Transport { truth, options, lights }
            }
            Method::Audited { lights, options, terms, passes } => {
                let trace = |of_lights: &VplOptions| {
                    self.tell(of_lights.count, || GuidedLights::to_draw(tracer, of_lights, view))
                };
                let lights = lights.as_ref().map(trace).transpose()?.map(Arc::new);
                Job::Audited(AuditedJob { options, terms, passes, lights })
            }
            Method::Path { stop } => Job::Path { stop },
        })
    }

    /// VPLs of [`lights`](Self::lights), which the request says are there.
    fn given(&self) -> Result<&Arc<LightSet>> {
        self.lights.as_ref().ok_or_else(|| Error::option("lights", "none", "a set of VPLs, as requested"))
    }

    /// The given VPLs, relative to the origin of the scene.
    fn given_about_origin(&self) -> Result<Arc<LightSet>> {
        let (given, origin) = (self.given()?, self.tracer.scene().origin());
        if given.set().origin() == origin {
            return Ok(Arc::clone(given));
        }
        Ok(Arc::new(LightSet::new(given.set().clone().relative_to(origin))))
    }

    fn tell<T>(&self, count: u64, trace: impl FnOnce() -> T) -> T {
        observer::during(self.observer, Phase::Vpls { count }, trace)
    }
}
