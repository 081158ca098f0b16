//! One large set of VPLs, guided to one view.

use super::super::Truth;
use super::estimate::{Estimator, summed_with};
use crate::accel::{Glass, Tracer};
use crate::compensation::{Choices, LightingContext, VplSource};
use crate::contribution::ContributionKernel;
use crate::error::{Error, Result};
use crate::gather::{GatherPoint, View};
use crate::guidance::{
    Caustics, Guided, LightAccount, LightOnSurfaces, Photons, SeenLight, Sky, importance_correlation,
    learn_light_guide,
};
use crate::math::Vec3;
use crate::rng::{self, Purpose};
use crate::scene::Abilities;
use crate::tree::{LightTree, LightTreeBuilder};
use crate::vpl::{
    Clamp, Emission, EmitterSampler, LightTracer, Provenance, Vpl, VplKind, VplOptions, VplSet,
};

/// VPLs of a scene in their tree, guided to a view. They are unbiased for other views as well, but
/// may be placed badly for them.
#[derive(Clone, Debug)]
pub struct GuidedLights {
    tree: LightTree,
    provenance: Provenance,
    options: VplOptions,
    truth: Truth,
    /// Directions of the scene's directional lights.
    given_directions: Vec<Vec3>,
    importance_brightness: f64,
    importance_correlation: f64,
    source: VplSource,
    choices: Option<Box<Choices>>,
    on_surfaces: Option<LightOnSurfaces>,
    lamps: Option<SeenLight>,
    sky: Option<Sky>,
}

/// Factor on the clamp distance where paths add the light that clamping removes. The variance due
/// to a nearby VPL, relative to the light of a wall covered with VPLs, falls with the square of
/// this factor. The variance of the paths that find such walls hardly grows.
const COMPENSATED: f32 = 4.0;

/// Further factor on the clamp distance of VPLs by which an audit estimates true pixel values. The
/// factor halves the variation from set to set, which no number of paths reduces; single paths vary
/// up to twice as much.
const OF_TRUTHS: f32 = 4.0;

/// Factor on the clamp distance of a set.
fn farther(truth: Truth, clamp: Clamp) -> f32 {
    if (truth, clamp) == (Truth::Transport, Clamp::Auto) { COMPENSATED } else { 1.0 }
}

/// Learns which emission contributes to the view. Returns the options with [`Emission::ByUse`], and
/// the guided tracer.
fn learn<'t>(tracer: &'t Tracer, options: &VplOptions, view: &View<'_>) -> Result<(VplOptions, Guided<'t>)> {
    tracer.scene().check_method("tashika", Abilities::STILL)?;
    let options = VplOptions { emission: Emission::ByUse, ..options.clone() };
    let tracing = LightTracer::new(tracer, &options)?;
    let guided = learn_light_guide(tracing, view, rng::key(options.seed, Purpose::Guidance, 0));
    Ok((options, guided))
}

/// Traces a set that is guided to the view, with the clamp that belongs to the truth.
fn traced<'t>(
    tracer: &'t Tracer,
    options: &VplOptions,
    truth: Truth,
    view: &View<'_>,
) -> Result<(VplSet, VplOptions, Guided<'t>)> {
    // VPLs are assumed to carry both direct and indirect light.
    if !(options.direct_share > 0.0 && options.direct_share < 1.0) {
        return Err(Error::option("direct_share", options.direct_share, "above 0 and below 1"));
    }
    let (options, guided) = learn(tracer, options, view)?;
    let set = guided.tracing.trace(options.seed).clamped(farther(truth, options.clamp));
    Ok((set, options, guided))
}

impl GuidedLights {
    /// Traces about `options.count` VPLs for a truth, guided to the points that a view sees
    /// ([`learn_light_guide`]). Runs on the current thread pool.
    ///
    /// # Errors
    /// Options out of range; a `direct_share` of 0 or 1; [`Truth::Vpl`].
    pub fn trace(tracer: &Tracer, options: &VplOptions, truth: Truth, view: &View<'_>) -> Result<Self> {
        let (set, options, guided) = traced(tracer, options, truth, view)?;
        Self::new(&set, options, truth, view, &guided)
    }

    /// Traces VPLs that represent only light reflected by surfaces, for a [path
    /// sampler](super::LightTransport::path_sampler). The sampler draws a few VPLs and a few
    /// emitter samples at each gather point. The truth is light transport.
    ///
    /// # Errors
    /// Options out of range.
    pub fn to_draw(tracer: &Tracer, options: &VplOptions, view: &View<'_>) -> Result<Self> {
        Ok(Self::drawn_from(tracer, options, view, 1.0)?.0)
    }

    /// Traces VPLs by which an audit estimates true pixel values. They are those of
    /// [`to_draw`](Self::to_draw) with four times the clamp distance. In addition, unsampled light
    /// and the variance from set to set are estimated.
    ///
    /// # Errors
    /// Options out of range.
    pub fn to_audit(tracer: &Tracer, options: &VplOptions, view: &View<'_>) -> Result<Self> {
        let (mut lights, guided) = Self::drawn_from(tracer, options, view, OF_TRUTHS)?;
        lights.learn_limits(&guided.tracing, view);
        Ok(lights)
    }

    fn drawn_from<'t>(
        tracer: &'t Tracer,
        options: &VplOptions,
        view: &View<'_>,
        times: f32,
    ) -> Result<(Self, Guided<'t>)> {
        let (options, guided) = learn(tracer, options, view)?;
        let truth = Truth::Transport;
        let farther = times * farther(truth, options.clamp);
        let set = guided.tracing.trace_indirect(options.seed).clamped(farther);
        let mut lights = Self::of(&set, options, truth, &guided);
        lights.source = VplSource::Surfaces;
        lights.learn_choices(&guided, view, true);
        Ok((lights, guided))
    }

    /// Traces only the set of VPLs of [`trace`](Self::trace), which can be stored in a file and
    /// shared by the parts of a picture. From this set, [`given`](Self::given) makes the same
    /// lights as `trace`, bit for bit, if all options except count, clamp and seed are the
    /// defaults.
    ///
    /// # Errors
    /// As [`trace`](Self::trace).
    pub fn trace_set(tracer: &Tracer, options: &VplOptions, truth: Truth, view: &View<'_>) -> Result<VplSet> {
        Ok(traced(tracer, options, truth, view)?.0)
    }

    /// Makes the lights of a set that was traced before, with the clamp distance of that set. The
    /// VPLs are guided to the view only if the set was traced with that guidance. Runs on the
    /// current thread pool.
    ///
    /// The guarantee of [`LightTransport`](super::LightTransport) holds for sets from an unbiased
    /// tracing of this scene, as by [`VplSet::trace`] and [`trace_set`](Self::trace_set).
    ///
    /// # Errors
    /// A set without direct VPLs, though the scene has emitters; a set with images of another
    /// scene; [`Truth::Vpl`].
    pub fn given(tracer: &Tracer, set: &VplSet, truth: Truth, view: &View<'_>) -> Result<Self> {
        set.validate_for(tracer.scene())?;
        let provenance = set.provenance();
        if provenance.direct == 0 && !EmitterSampler::new(tracer).is_empty() {
            let expected = format!("a set with direct VPLs where the truth is {truth}");
            return Err(Error::option("lights", "indirect VPLs alone", expected));
        }
        let mut options = VplOptions { seed: provenance.seed, ..VplOptions::default() };
        if provenance.requested > 0 {
            options.count = provenance.requested;
        }
        let (options, guided) = learn(tracer, &options, view)?;
        Self::new(set, options, truth, view, &guided)
    }

    fn new(
        set: &VplSet,
        options: VplOptions,
        truth: Truth,
        view: &View<'_>,
        guided: &Guided<'_>,
    ) -> Result<Self> {
        if truth == Truth::Vpl {
            return Err(Error::option("truth", truth, "clamped or transport, which are about all sets"));
        }
        let mut lights = Self::of(set, options, truth, guided);
        if truth == Truth::Transport {
            lights.learn_choices(guided, view, false);
        }
        lights.learn_limits(&guided.tracing, view);
        Ok(lights)
    }

    /// Learns two properties that estimates by these VPLs do not show: the correlation of the VPLs,
    /// and the lamps and the sky that the camera sees.
    fn learn_limits(&mut self, tracing: &LightTracer<'_>, view: &View<'_>) {
        self.importance_correlation = importance_correlation(tracing, view, &self.provenance, self.key(2));
        self.lamps = SeenLight::lamps(tracing, view, self.key(4));
        let environment = tracing.tracer().scene().environment();
        self.sky = environment.and_then(|environment| Sky::new(environment, self.key(5)));
    }

    /// The set in a tree, before anything is learned.
    fn of(set: &VplSet, options: VplOptions, truth: Truth, guided: &Guided<'_>) -> Self {
        let given = EmitterSampler::new(guided.tracing.tracer());
        let directional = given.punctual().filter(|light| light.kind == VplKind::Directional);
        Self {
            tree: LightTree::build(set, LightTreeBuilder::default()),
            source: VplSource::EmittersAndSurfaces,
            choices: None,
            on_surfaces: None,
            lamps: None,
            sky: None,
            provenance: set.provenance().clone(),
            truth,
            given_directions: directional.map(|light| light.direction).collect(),
            importance_brightness: guided.importance_brightness,
            importance_correlation: 1.0,
            options,
        }
    }

    /// Learns which lights to draw at a place, the light on surfaces, and the origins of caustics.
    fn learn_choices(&mut self, guided: &Guided<'_>, view: &View<'_>, draws_at_points: bool) {
        self.on_surfaces = LightOnSurfaces::learn(&guided.tracing, view, self.key(3));
        let tracer = guided.tracing.tracer();
        let lit = LightingContext {
            tracer,
            emitters: &EmitterSampler::by_use(tracer, &self.options),
            lights: Some(&self.tree),
            vpl_source: self.source,
            choices: None,
            contribution: ContributionKernel::new(self.provenance.clamp_distance)
                .with_glass(Glass::SolidStops)
                .within(tracer.scene()),
            max_depth: self.provenance.max_depth,
            caustics: None,
        };
        let by_vpls = |point: &GatherPoint| summed_with(point, Estimator::Vpls);
        self.choices = Some(Box::new(Choices::learn(&lit, view, by_vpls, draws_at_points, self.key(1))));
    }

    /// Key of the random numbers for learning.
    fn key(&self, number: u64) -> u64 {
        rng::key(self.options.seed, Purpose::Guidance, number)
    }

    /// Number of VPLs in the set.
    pub fn count(&self) -> u64 {
        self.provenance.direct + self.provenance.indirect
    }

    /// Light tree over the set.
    pub(super) fn tree(&self) -> &LightTree {
        &self.tree
    }

    /// Origin of the light that the VPLs carry: emitters and surfaces, or surfaces alone.
    pub(super) fn source(&self) -> VplSource {
        self.source
    }

    /// Learned probabilities of VPLs and emitters at a surface on a path.
    pub(super) fn choices(&self) -> Option<&Choices> {
        self.choices.as_deref()
    }

    /// Caustics, which the VPLs do not carry.
    pub(super) fn caustics(&self) -> Option<&Caustics> {
        self.on_surfaces.as_ref()?.caustics.as_ref()
    }

    /// Light on surfaces, from light paths that are independent of the VPLs and of paths from the
    /// camera.
    pub(super) fn photons(&self) -> Option<&Photons> {
        self.on_surfaces.as_ref().map(|light| &light.all)
    }

    /// Lamps that the camera sees.
    pub(super) fn lamps(&self) -> Option<&SeenLight> {
        self.lamps.as_ref()
    }

    /// Sky that the camera may see, if its radiance varies.
    pub(super) fn sky(&self) -> Option<&Sky> {
        self.sky.as_ref()
    }

    /// Caustics that the camera sees, in the pixels.
    pub(super) fn seen_caustics(&self) -> Option<&SeenLight> {
        self.on_surfaces.as_ref()?.seen_caustics.as_ref()
    }

    /// Account of the light in view, from light paths alone; `None` if the camera has a lens or
    /// moves.
    pub fn account(&self) -> Option<LightAccount> {
        self.on_surfaces.as_ref()?.account
    }

    /// Origin of the VPLs, with the clamp that belongs to them.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Quantity that estimates by these VPLs approximate.
    pub fn truth(&self) -> Truth {
        self.truth
    }

    /// Options by which the VPLs were traced.
    pub fn options(&self) -> &VplOptions {
        &self.options
    }

    /// Approximate mean luminance of the view (W·m⁻²·sr⁻¹).
    pub fn importance_brightness(&self) -> f64 {
        self.importance_brightness
    }

    /// Approximate ratio of the variance of a sum over these VPLs to that over independent VPLs. It
    /// exceeds 1 if VPLs that one light path leaves are correlated.
    pub(super) fn importance_correlation(&self) -> f64 {
        self.importance_correlation
    }

    /// Returns true if a light is in every set, as point lights and directional lights are.
    pub(super) fn is_given(&self, light: &Vpl) -> bool {
        match light.kind {
            VplKind::Omni | VplKind::Spot(_) | VplKind::Image(_) => true,
            VplKind::Oriented | VplKind::Volume(_) => false,
            VplKind::Directional => self.given_directions.contains(&light.direction),
        }
    }
}
