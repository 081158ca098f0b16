//! Light tracing: light paths run from the emitters over surfaces and through media, and create a
//! VPL wherever light is diffusely reflected or scattered.
//!
//! # Computation
//! *Direct* VPLs: every point, spot and directional emitter is exactly one VPL; emitting surfaces
//! and the environment are sampled in proportion to power. *Indirect* VPLs: `P` light paths start
//! on emitters. Where a path of flux `Φ` (W) meets a surface of diffuse reflectance `ρ`, it creates
//! an oriented VPL of intensity
//!
//! ```text
//! I = Φ ρ / (π P) · |n_s·ω| / |n_g·ω|        W·sr⁻¹
//! ```
//!
//! Here `n_s` is the shading normal, `n_g` the geometric normal, and `ω` the direction from which
//! the light arrives (Veach 1997, section 5.3). The path continues by sampling the *whole* BSDF, as
//! a viewer in the path's new direction would see it, with Russian roulette by the remaining flux.
//! The expected sum over the VPLs, without clamp, is the light transported by all paths whose last
//! surface before the receiver reflects diffusely, or whose last vertex before the receiver is in a
//! medium. On surfaces whose diffuse part depends on the outgoing direction (coats), the VPL has
//! the same flux and a plain cosine lobe. Inside glass of index `η` the intensity of VPLs is
//! `I/η²`, which is how viewers outside see them.
//!
//! Where a path of flux `Φ` is scattered in a medium, it creates a VPL that emits by the phase
//! function `p` of the medium around the direction `ω` in which the light arrived,
//!
//! ```text
//! I(ω') = Φ/P · p(ω·ω')        W·sr⁻¹
//! ```
//!
//! and continues in a direction drawn from `p` ([`walk`](super::walk)).
//!
//! # Time
//! If anything moves while the shutter is open, each of several [`Instants`] has a separate set
//! with an equal share of the VPLs. Each such set represents all light at its time.
//!
//! # Number
//! Stopping at a given number of VPLs would bias the set, since a long last path would be cut more
//! often than a short one. Instead, an independent pilot counts the VPLs that a path creates, and
//! `P` is fixed from this count before tracing. The number of VPLs is then the requested one to
//! within a few percent, provided that more than half of them are sampled: points, spots and
//! directional emitters are one VPL each, regardless of their number.
//!
//! # Guarantee
//! The set depends only on the scene and the options, not on threads. It is unbiased except for
//! paths longer than `max_depth`. Held to this by `vpl::tests` and `furnace`.

use rayon::prelude::*;

use super::caustic::{self, ArrivedLight};
use super::order::sort_by_place;
use super::walk::{LightPaths, Trail};
use super::{Clamp, Emission, EmitterSampler, LightGuide, Provenance, Vpl, VplOptions, VplSet};
use crate::accel::Tracer;
use crate::error::Result;
use crate::math::Instants;
use crate::media::Outside;
use crate::rng::{self, Purpose, Stream};
use crate::stats::Weighted;

/// Number of light paths of the first pilot.
const PILOT_PATHS: u64 = 4096;
/// Number of VPLs from which a pilot estimates the mean number per path to about 6 %.
const PILOT_LIGHTS: usize = 256;
/// Number of light paths of the last pilot. It misses surfaces that fewer than one in 250,000 paths
/// meets.
const MAX_PILOT_PATHS: u64 = PILOT_PATHS * 8 * 8;

/// Maximum number of passes of light paths that search for caustics.
const MOST_PASSES: u64 = 4;

impl VplSet {
    /// Traces a set from the emitters of the tracer's scene, in parallel on the current thread
    /// pool.
    ///
    /// # Errors
    /// Options out of range, or cameras that disagree on the medium [outside](Outside) of all
    /// interfaces.
    pub fn trace(tracer: &Tracer, options: &VplOptions) -> Result<Self> {
        Ok(LightTracer::new(tracer, options)?.trace(options.seed))
    }
}

/// Tracer of sets of VPLs: each seed gives an independent set of the same distribution.
#[derive(Debug)]
pub struct LightTracer<'s> {
    tracer: &'s Tracer,
    options: VplOptions,
    emitters: EmitterSampler<'s>,
    guide: LightGuide,
    /// Mean number of VPLs that a light path creates, estimated by a pilot.
    per_path: f64,
}

impl<'s> LightTracer<'s> {
    /// Returns a light tracer without a guide.
    ///
    /// # Errors
    /// As [`VplSet::trace`].
    pub fn new(tracer: &'s Tracer, options: &VplOptions) -> Result<Self> {
        options.validate()?;
        if tracer.scene().has_media() {
            Outside::check(tracer)?;
        }
        let emitters = match options.emission {
            Emission::ByPower => EmitterSampler::new(tracer),
            Emission::ByUse => EmitterSampler::by_use(tracer, options),
        };
        let tracing =
            Self { tracer, options: options.clone(), emitters, guide: LightGuide::default(), per_path: 0.0 };
        Ok(Self { per_path: tracing.lights_per_path(), ..tracing })
    }

    /// Returns the light tracer with a guide, which must not depend on the random numbers of light
    /// paths and direct VPLs.
    #[must_use]
    pub fn guided(self, guide: LightGuide) -> Self {
        let guided = Self { guide, ..self };
        Self { per_path: guided.lights_per_path(), ..guided }
    }

    /// Returns the light tracer with another clamp. The clamp is stored in the provenance and does
    /// not change the lights.
    #[must_use]
    pub fn clamped(self, clamp: Clamp) -> Self {
        Self { options: VplOptions { clamp, ..self.options }, ..self }
    }

    /// Returns the tracer of rays.
    pub fn tracer(&self) -> &'s Tracer {
        self.tracer
    }

    /// Returns the distribution over the emitters.
    pub fn emitters(&self) -> &EmitterSampler<'s> {
        &self.emitters
    }

    /// Traces the set of a seed, in parallel on the current thread pool.
    pub fn trace(&self, seed: u64) -> VplSet {
        self.sets(seed, |count, moment| {
            let mut direct: Vec<Vpl> = self.emitters.punctual().collect();
            let (drawn, trail, paths) = self.draw(count, moment, direct.len() as u64);
            direct.extend(drawn);
            (direct, trail, paths)
        })
    }

    /// Traces the set of a seed without direct VPLs, in parallel on the current thread pool.
    pub fn trace_indirect(&self, seed: u64) -> VplSet {
        self.sets(seed, |count, moment| {
            let paths = self.paths(count, count);
            (Vec::new(), self.follow(moment, Purpose::LightPath, paths), paths)
        })
    }

    /// Returns the times of the sets of a seed.
    fn instants(&self, seed: u64) -> Instants {
        if self.tracer.scene().moves() {
            let mut stream = Stream::new(seed, Purpose::Shutter, 0);
            Instants::spread(self.options.instants, || stream.uniform_f64())
        } else {
            Instants::default()
        }
    }

    /// Returns the set of all instants.
    ///
    /// * `at`: returns the direct VPLs, the trail and the number of light paths of one instant, for
    ///   approximately the given number of VPLs.
    fn sets(&self, seed: u64, at: impl Fn(u64, Moment) -> (Vec<Vpl>, Trail, u64)) -> VplSet {
        let Self { tracer, options, .. } = self;
        let scene = tracer.scene();
        let instants = self.instants(seed);
        let count = options.count.div_ceil(instants.len() as u64);
        let mut provenance = Provenance {
            scene: scene.name().to_owned(),
            seed,
            requested: options.count,
            max_depth: options.max_depth,
            origin: scene.origin().to_array(),
            ..Provenance::default()
        };
        let (mut all, mut counts) = (Vec::new(), Vec::with_capacity(instants.len()));
        let (mut clamp, mut diffuse, mut reflected) = (0.0, 0.0, 0.0);
        for (number, &share) in (0..).zip(instants.shares()) {
            let seed = if number == 0 { seed } else { rng::key(seed, Purpose::Shutter, number) };
            let (mut lights, trail, paths) = at(count, Moment { seed, share });
            lights.retain(|l| !l.intensity.is_black());
            provenance.direct += lights.len() as u64;
            provenance.indirect += trail.lights.len() as u64;
            provenance.paths += paths;
            (diffuse, reflected) = (diffuse + trail.diffuse, reflected + trail.reflected);
            lights.extend(trail.lights);
            sort_by_place(&mut lights, scene.bounds());
            debug_assert!(lights.iter().all(|l| l.intensity.is_valid()));
            clamp += options.clamp.distance(&lights, &scene.bounds(), seed);
            counts.push(lights.len() as u64);
            if all.is_empty() {
                all = lights;
            } else {
                all.append(&mut lights);
            }
        }
        provenance.clamp_distance = clamp / instants.len() as f32;
        if reflected > 0.0 {
            provenance.glossy_share = (1.0 - diffuse / reflected).clamp(0.0, 1.0) as f32;
        }
        VplSet::at_instants(all, instants, &counts, provenance).expect("lights were counted")
    }

    /// Returns the VPLs of a set of approximately `count` VPLs, grouped by the random numbers from
    /// which they are drawn. A direct VPL is a separate group; the VPLs of a light path form one
    /// group. Points, spots and directional emitters, which are in every set, are not included.
    pub fn drawn_together(&self, count: u64, seed: u64) -> Vec<Vec<Vpl>> {
        let moment = Moment { seed, share: Instants::STILL };
        let (direct, trail, _) = self.draw(count, moment, self.emitters.punctual().count() as u64);
        let mut groups: Vec<Vec<Vpl>> = direct.into_iter().map(|light| vec![light]).collect();
        let mut lights = trail.lights.into_iter();
        groups.extend(trail.counts.into_iter().map(|count| lights.by_ref().take(count as usize).collect()));
        groups
    }

    /// Returns `count` direct VPLs: on emitting surfaces, and towards the environment.
    pub fn on_emitters(&self, count: u64, seed: u64) -> Vec<Vpl> {
        self.on_emitters_at(Moment { seed, share: Instants::STILL }, count)
    }

    fn on_emitters_at(&self, Moment { seed, share }: Moment, count: u64) -> Vec<Vpl> {
        if !self.emitters.has_extended() {
            return Vec::new();
        }
        let light = |i: u64| {
            let mut s = Stream::new(seed, Purpose::DirectLight, i);
            let u = (i as f64 + s.uniform_f64()) / count as f64;
            let mut light = self.guide.place(&self.emitters, share, u, &mut s)?;
            light.intensity = light.intensity / count as f32;
            Some(light)
        };
        (0..count).into_par_iter().filter_map(light).collect()
    }

    /// Traces up to four passes of `paths` light paths each. A further pass follows if the passes
    /// so far found some, but fewer than `enough`, caustic photons that draws from the emitters
    /// miss. Its emission is guided to these photons. Runs on the current thread pool.
    pub fn arrived_light(&self, paths: u64, enough: usize, seed: u64) -> ArrivedLight {
        let moment = Moment { seed, share: Instants::STILL };
        let mut all = self.follow(moment, Purpose::LightPath, paths);
        let mut passes = 1;
        while passes < MOST_PASSES && caustic::to_guide(&all) > 0 && caustic::to_guide(&all) < enough {
            let (guide, seed) = (caustic::guide(&all), rng::key(seed, Purpose::Guidance, passes));
            let guided = LightPaths { guide: &guide, seed, ..self.paths_at(moment) };
            all = all.followed_by(guided.follow(Purpose::LightPath, paths));
            passes += 1;
        }
        all.lights.iter_mut().for_each(|light| light.intensity = light.intensity / passes as f32);
        let caustics = all.caustics.iter().map(|arrival| arrival.photon(&all.lights)).collect();
        ArrivedLight { caustics, routes: all.routes(), lights: all.lights }
    }

    /// Traces `paths` light paths with a guide. For each path, sums `worth` over its VPLs. If the
    /// sum is positive, returns it with the numbers from which the path's emission was drawn. Runs
    /// on the current thread pool.
    pub fn worth_of_emission(
        &self,
        guide: &LightGuide,
        paths: u64,
        seed: u64,
        worth: impl Fn(&Vpl) -> f32,
    ) -> Vec<Weighted<5>> {
        let moment = Moment { seed, share: Instants::STILL };
        let paths_of_guide = LightPaths { guide, keeps_numbers: true, ..self.paths_at(moment) };
        let trail = paths_of_guide.follow(Purpose::LightPath, paths);
        let mut lights = trail.lights.iter();
        let of_path = |(numbers, count): (&[f32; 5], &u32)| {
            let of_lights = lights.by_ref().take(*count as usize).map(&worth).sum::<f32>();
            (of_lights > 0.0).then_some((*numbers, of_lights))
        };
        trail.numbers.iter().zip(&trail.counts).filter_map(of_path).collect()
    }

    /// Returns direct VPLs, the trail of the light paths, and the number of these, for a set that
    /// also contains `punctual` points, spots and directional emitters.
    fn draw(&self, count: u64, moment: Moment, punctual: u64) -> (Vec<Vpl>, Trail, u64) {
        let Self { options, emitters, .. } = self;
        // At least half of the count is sampled, however many punctual emitters there are.
        let rest = count.saturating_sub(punctual).max(count.div_ceil(2));
        let has_extended = emitters.has_extended();
        let share = f64::from(options.direct_share);
        // Neither kind of VPL is omitted, however small the count, unless the share demands it.
        let mut direct =
            if has_extended && share > 0.0 { ((rest as f64 * share).round() as u64).max(1) } else { 0 };
        let paths = self.paths(count, rest - direct);
        if paths == 0 && has_extended {
            direct = rest;
        }
        (self.on_emitters_at(moment, direct), self.follow(moment, Purpose::LightPath, paths), paths)
    }

    /// Returns the number of light paths that create approximately `wanted` VPLs. It is at least
    /// one if there may be indirect light: a pilot that met no surface does not prove that there is
    /// none.
    fn paths(&self, count: u64, wanted: u64) -> u64 {
        let options = &self.options;
        if options.max_depth == 0 || options.direct_share >= 1.0 || self.emitters.is_empty() {
            return 0;
        }
        let most = count.saturating_mul(options.emission.max_paths_per_vpl());
        let paths = if self.per_path > 0.0 { wanted as f64 / self.per_path } else { wanted as f64 };
        (paths.round() as u64).max(1).min(most)
    }

    /// Returns the mean number of VPLs that a light path creates. The pilot grows until the mean is
    /// precise enough.
    fn lights_per_path(&self) -> f64 {
        let options = &self.options;
        if options.max_depth == 0 {
            return 0.0;
        }
        // The pilot need not have more paths than will be traced.
        let most = options.count.saturating_mul(options.emission.max_paths_per_vpl()).min(MAX_PILOT_PATHS);
        let mut paths = PILOT_PATHS;
        loop {
            let moment = Moment { seed: options.seed, share: Instants::STILL };
            let left = self.follow(moment, Purpose::LightPathPilot, paths).lights.len();
            if left >= PILOT_LIGHTS || paths >= most {
                return left as f64 / paths as f64;
            }
            paths *= 8;
        }
    }

    fn follow(&self, moment: Moment, purpose: Purpose, paths: u64) -> Trail {
        self.paths_at(moment).follow(purpose, paths)
    }

    fn paths_at(&self, Moment { seed, share }: Moment) -> LightPaths<'_> {
        let Self { tracer, emitters, guide, .. } = self;
        let max_depth = self.options.max_depth;
        LightPaths { tracer, emitters, guide, max_depth, seed, share, keeps_numbers: false }
    }
}

/// Time and seed of one set.
#[derive(Clone, Copy)]
struct Moment {
    seed: u64,
    /// Time as a share of the shutter interval, 0 to 1.
    share: f32,
}

/// Least share of the light paths for each kind of emitter.
const LEAST_SHARE: f64 = 0.05;

/// Share of the draws that is distributed equally over the emitters.
const SHARE_FOR_EACH: f64 = 0.1;

impl<'s> EmitterSampler<'s> {
    /// Creates a sampler for [`Emission::ByUse`]. It draws each kind of emitter in proportion to
    /// the flux that a pilot's paths bring to surfaces, and gives each emitter a minimum share.
    pub fn by_use(tracer: &'s Tracer, options: &VplOptions) -> Self {
        let reflected = |kinds: [f64; 2]| {
            let emitters = EmitterSampler::new(tracer).weighted(kinds);
            let paths = LightPaths {
                tracer,
                emitters: &emitters,
                guide: &LightGuide::default(),
                max_depth: options.max_depth,
                seed: options.seed,
                share: Instants::STILL,
                keeps_numbers: false,
            };
            let trail = paths.follow(Purpose::LightPathPilot, PILOT_PATHS);
            trail.diffuse + trail.reflected
        };
        let fluxes = [reflected([1.0, 0.0]), reflected([0.0, 1.0])];
        let sum: f64 = fluxes.iter().sum();
        let shares = fluxes.map(|flux| if sum > 0.0 { (flux / sum).max(LEAST_SHARE) } else { 0.5 });
        EmitterSampler::new(tracer).weighted(shares).with_share_for_each(SHARE_FOR_EACH)
    }
}
