//! Light tracing: from the emitters over the surfaces and through media, leaving a VPL wherever light
//! is reflected diffusely or scattered.
//!
//! # What is computed
//! *Direct* VPLs: every point, spot and directional emitter is one, exactly; surfaces and the
//! environment are sampled in proportion to power. *Indirect* VPLs: `P` light paths start on
//! emitters; where one with flux `Φ` (W) meets a surface with diffuse reflectance `ρ`, it leaves an
//! oriented VPL of intensity
//!
//! ```text
//! I = Φ ρ / (π P) · |n_s·ω| / |n_g·ω|        W·sr⁻¹
//! ```
//!
//! (`n_s`, `n_g` shading and geometric normal, `ω` towards where the light came from: Veach 1997,
//! section 5.3), and goes on by sampling the *whole* BSDF, as a viewer in the direction that it
//! takes would see it, with Russian roulette by the flux that is left. The expected sum over the
//! VPLs, unclamped, is the light transported by all paths whose last surface before the receiver
//! reflects diffusely, or whose last place before it is in a medium. Surfaces whose diffuse part depends on the outgoing direction (coats) leave
//! a VPL of the same flux with a plain cosine lobe.
//!
//! Where a path of flux `Φ` is scattered in a medium, it leaves a VPL that shines by the phase
//! function `p` of the medium about the direction `ω` that the light came along,
//!
//! ```text
//! I(ω') = Φ/P · p(ω·ω')        W·sr⁻¹
//! ```
//!
//! and goes on by drawing from it ([`walk_in_media`](super::walk_in_media)).
//!
//! # Number
//! Stopping at a number would bias the set: a long last path would be cut more often than a short
//! one. So the VPLs left by a path are counted on an independent pilot, and `P` is fixed from that
//! before tracing. The set then has the number that was asked for to within a few percent, where it
//! is more than half sampled: points, spots and directional emitters are VPLs each, however many.
//!
//! # Guarantee
//! The set is a function of scene and options; threads do not enter. Unbiased but for paths longer
//! than `max_depth`. Held to this by `vpl::tests` and `furnace`.

use rayon::prelude::*;

use super::walk::{Trail, trace_paths};
use super::{Clamp, EmitterSampler, LightGuide, Provenance, Vpl, VplKind, VplSet};
use crate::accel::Tracer;
use crate::error::{Error, Result};
use crate::math::Aabb;
use crate::media::Outside;
use crate::rng::{Purpose, Stream};
use crate::scene::Abilities;

/// Which emitters light paths start from, and how many direct VPLs each has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Emission {
    /// In proportion to power. Light from infinity has the power of all that enters the sphere
    /// about the scene, most of which may miss what can be seen of it.
    #[default]
    ByPower,
    /// Emitters in the scene, and light from infinity, by how much light of either reaches surfaces
    /// as a pilot finds it; among those of a kind by power. Where few light paths leave VPLs, on
    /// metals say, the set stays smaller sooner.
    ByUse,
}

impl Emission {
    /// Most light paths for each VPL that was asked for: where nearly all light misses the scene,
    /// the set stays smaller.
    fn max_paths_per_vpl(self) -> u64 {
        match self {
            Self::ByPower => 256,
            Self::ByUse => 4,
        }
    }
}

/// How a set of VPLs is made.
#[derive(Clone, Debug, PartialEq)]
pub struct VplOptions {
    /// How many VPLs, to within a few percent; 1 to 10⁸. Higher: less noise and less clamping.
    /// Default: 5000.
    pub count: u64,
    /// Seed of the light paths.
    pub seed: u64,
    /// Longest light path, in surfaces met; 0 to 1000. Zero: direct light only. Being scattered in a
    /// medium does not count. Default: 64.
    pub max_depth: u32,
    /// Share of the VPLs that is placed on surfaces that emit and towards the environment, 0 to 1:
    /// at 0 their direct light is left out, at 1 all indirect light. Default: 0.25.
    pub direct_share: f32,
    /// Which emitters have them. Default: by power.
    pub emission: Emission,
    /// Distance below which the geometric term no longer grows.
    pub clamp: Clamp,
}

impl Default for VplOptions {
    fn default() -> Self {
        Self {
            count: 5000,
            seed: 1,
            max_depth: 64,
            direct_share: 0.25,
            emission: Emission::ByPower,
            clamp: Clamp::Auto,
        }
    }
}

/// Largest number of VPLs (4.8 GB).
const MAX_COUNT: u64 = 100_000_000;
/// Light paths of the first pilot.
const PILOT_PATHS: u64 = 4096;
/// VPLs from which a pilot knows the number to about 6 %.
const PILOT_LIGHTS: usize = 256;
/// Light paths of the last pilot: what one path in 250,000 does not meet is left out.
const MAX_PILOT_PATHS: u64 = PILOT_PATHS * 8 * 8;

impl VplOptions {
    /// Surfaces that a path of light meets at most, that which the camera sees included.
    pub fn path_depth(&self) -> u32 {
        self.max_depth + 1
    }

    /// # Errors
    /// Names the option that is out of range, and the range.
    pub fn validate(&self) -> Result<()> {
        if !(1..=MAX_COUNT).contains(&self.count) {
            return Err(Error::option("vpls", self.count, format!("1 to {MAX_COUNT}")));
        }
        if self.max_depth > 1000 {
            return Err(Error::option("max_depth", self.max_depth, "0 to 1000"));
        }
        if !(0.0..=1.0).contains(&self.direct_share) {
            return Err(Error::option("direct_share", self.direct_share, "0 to 1"));
        }
        self.clamp.validate()
    }
}

impl VplSet {
    /// Traces a set from the emitters of the tracer's scene, in parallel on the current thread
    /// pool.
    ///
    /// # Errors
    /// Options out of range; cameras that do not agree on the medium [outside](Outside) of all
    /// interfaces.
    pub fn trace(tracer: &Tracer, options: &VplOptions) -> Result<Self> {
        Ok(LightTracer::new(tracer, options)?.trace(options.seed))
    }
}

/// What sets of VPLs are traced with: one after the other, by seeds of their own, all alike.
#[derive(Debug)]
pub struct LightTracer<'s> {
    tracer: &'s Tracer,
    options: VplOptions,
    emitters: EmitterSampler<'s>,
    guide: LightGuide,
    /// VPLs that a light path leaves on average, by a pilot.
    per_path: f64,
}

impl<'s> LightTracer<'s> {
    /// Without a guide.
    ///
    /// # Errors
    /// As [`VplSet::trace`].
    pub fn new(tracer: &'s Tracer, options: &VplOptions) -> Result<Self> {
        options.validate()?;
        tracer.scene().check_method("one of VPLs", Abilities::STILL_MEDIA)?;
        if tracer.scene().has_media() {
            Outside::check(tracer)?;
        }
        let emitters = match options.emission {
            Emission::ByPower => EmitterSampler::new(tracer.scene()),
            Emission::ByUse => EmitterSampler::by_use(tracer, options),
        };
        let tracing =
            Self { tracer, options: options.clone(), emitters, guide: LightGuide::default(), per_path: 0.0 };
        Ok(Self { per_path: tracing.lights_per_path(), ..tracing })
    }

    /// By this guide, which must not depend on the random numbers of light paths and direct VPLs.
    #[must_use]
    pub fn guided(self, guide: LightGuide) -> Self {
        let guided = Self { guide, ..self };
        Self { per_path: guided.lights_per_path(), ..guided }
    }

    /// The same with another clamp, which is told in the provenance and changes no light.
    #[must_use]
    pub fn clamped(self, clamp: Clamp) -> Self {
        Self { options: VplOptions { clamp, ..self.options }, ..self }
    }

    /// What it traces rays with.
    pub fn tracer(&self) -> &'s Tracer {
        self.tracer
    }

    /// The emitters, as they are drawn from.
    pub fn emitters(&self) -> &EmitterSampler<'s> {
        &self.emitters
    }

    /// The set of this seed, traced in parallel on the current thread pool.
    pub fn trace(&self, seed: u64) -> VplSet {
        let mut direct: Vec<Vpl> = self.emitters.punctual().collect();
        let (drawn, trail, paths) = self.draw(self.options.count, seed, direct.len() as u64);
        direct.extend(drawn);
        self.set(direct, trail, paths, seed)
    }

    /// The same without direct VPLs: what surfaces reflect.
    pub fn trace_indirect(&self, seed: u64) -> VplSet {
        let paths = self.paths(self.options.count, self.options.count);
        self.set(Vec::new(), self.trace_paths(seed, Purpose::LightPath, paths), paths, seed)
    }

    fn set(&self, mut lights: Vec<Vpl>, trail: Trail, paths: u64, seed: u64) -> VplSet {
        let Self { tracer, options, .. } = self;
        lights.retain(|l| !l.intensity.is_black());
        let direct = lights.len() as u64;
        lights.extend(trail.lights);
        let scene = tracer.scene();
        sort_by_place(&mut lights, scene.bounds());
        debug_assert!(lights.iter().all(|l| l.intensity.is_valid()));

        let provenance = Provenance {
            scene: scene.name().to_owned(),
            seed,
            requested: options.count,
            direct,
            indirect: lights.len() as u64 - direct,
            paths,
            max_depth: options.max_depth,
            clamp_distance: options.clamp.distance(&lights, seed),
            glossy_share: if trail.reflected > 0.0 {
                (1.0 - trail.diffuse / trail.reflected).clamp(0.0, 1.0) as f32
            } else {
                0.0
            },
        };
        VplSet::new(lights, provenance)
    }

    /// The VPLs of a set of about `count` by what they are drawn with: each direct VPL by itself,
    /// and those that a light path leaves together; without emitters that are points, which are in
    /// every set.
    pub fn drawn_together(&self, count: u64, seed: u64) -> Vec<Vec<Vpl>> {
        let (direct, trail, _) = self.draw(count, seed, self.emitters.punctual().count() as u64);
        let mut groups: Vec<Vec<Vpl>> = direct.into_iter().map(|light| vec![light]).collect();
        let mut lights = trail.lights.into_iter();
        groups.extend(trail.counts.into_iter().map(|count| lights.by_ref().take(count as usize).collect()));
        groups
    }

    /// So many direct VPLs: on emitting surfaces, and directions of the environment.
    pub fn on_emitters(&self, count: u64, seed: u64) -> Vec<Vpl> {
        if self.emitters.sample_extended(0.0, [0.5; 2]).is_none() {
            return Vec::new();
        }
        let light = |i: u64| {
            let mut s = Stream::new(seed, Purpose::DirectLight, i);
            let u = (i as f64 + s.uniform_f64()) / count as f64;
            let mut light = self.guide.place(&self.emitters, u, &mut s)?;
            light.intensity = light.intensity / count as f32;
            Some(light)
        };
        (0..count).into_par_iter().filter_map(light).collect()
    }

    /// The first VPL of each of so many light paths that came to it from an emitter over mirrors or
    /// through solid glass.
    pub fn after_bent_ways(&self, paths: u64, seed: u64) -> Vec<Vpl> {
        let trail = self.trace_paths(seed, Purpose::LightPath, paths);
        trail.bent.into_iter().map(|number| trail.lights[number as usize]).collect()
    }

    /// Direct VPLs, what light paths leave, and how many paths there are, beside so many emitters
    /// that are points.
    fn draw(&self, count: u64, seed: u64, punctual: u64) -> (Vec<Vpl>, Trail, u64) {
        let Self { options, emitters, .. } = self;
        // However many lights are points: half of the count goes to what has to be sampled.
        let rest = count.saturating_sub(punctual).max(count.div_ceil(2));
        let has_extended = emitters.sample_extended(0.0, [0.5; 2]).is_some();
        let share = f64::from(options.direct_share);
        // However small the count: neither kind of light is left out, unless the share says so.
        let mut direct =
            if has_extended && share > 0.0 { ((rest as f64 * share).round() as u64).max(1) } else { 0 };
        let paths = self.paths(count, rest - direct);
        if paths == 0 && has_extended {
            direct = rest;
        }
        (self.on_emitters(direct, seed), self.trace_paths(seed, Purpose::LightPath, paths), paths)
    }

    /// How many light paths leave about `wanted` VPLs: at least one where there may be indirect
    /// light, as a pilot that met nothing does not prove that there is none.
    fn paths(&self, count: u64, wanted: u64) -> u64 {
        let options = &self.options;
        if options.max_depth == 0 || options.direct_share >= 1.0 || self.emitters.is_empty() {
            return 0;
        }
        let most = count.saturating_mul(options.emission.max_paths_per_vpl());
        let paths = if self.per_path > 0.0 { wanted as f64 / self.per_path } else { wanted as f64 };
        (paths.round() as u64).max(1).min(most)
    }

    /// VPLs that a light path leaves on average, from a pilot that grows until it knows.
    fn lights_per_path(&self) -> f64 {
        let options = &self.options;
        if options.max_depth == 0 {
            return 0.0;
        }
        // More than will be traced would tell nothing that can be used.
        let most = options.count.saturating_mul(options.emission.max_paths_per_vpl()).min(MAX_PILOT_PATHS);
        let mut paths = PILOT_PATHS;
        loop {
            let left = self.trace_paths(options.seed, Purpose::LightPathPilot, paths).lights.len();
            if left >= PILOT_LIGHTS || paths >= most {
                return left as f64 / paths as f64;
            }
            paths *= 8;
        }
    }

    fn trace_paths(&self, seed: u64, purpose: Purpose, paths: u64) -> Trail {
        let Self { tracer, emitters, guide, .. } = self;
        trace_paths(tracer, emitters, guide, &VplOptions { seed, ..self.options.clone() }, purpose, paths)
    }
}

/// Least share of the light paths that a kind of emitters has.
const LEAST_SHARE: f64 = 0.05;

/// Share of the draws that is spread evenly over the emitters.
const SHARE_FOR_EACH: f64 = 0.1;

impl<'s> EmitterSampler<'s> {
    /// The emitters of the tracer's scene, either kind in proportion to the flux that a pilot's
    /// paths bring to surfaces, and each emitter with a share ([`Emission::ByUse`]).
    pub fn by_use(tracer: &'s Tracer, options: &VplOptions) -> Self {
        let reflected = |kinds: [f64; 2]| {
            let emitters = EmitterSampler::new(tracer.scene()).weighted(kinds);
            let trail = trace_paths(
                tracer,
                &emitters,
                &LightGuide::default(),
                options,
                Purpose::LightPathPilot,
                PILOT_PATHS,
            );
            trail.diffuse + trail.reflected
        };
        let fluxes = [reflected([1.0, 0.0]), reflected([0.0, 1.0])];
        let sum: f64 = fluxes.iter().sum();
        let shares = fluxes.map(|flux| if sum > 0.0 { (flux / sum).max(LEAST_SHARE) } else { 0.5 });
        EmitterSampler::new(tracer.scene()).weighted(shares).with_share_for_each(SHARE_FOR_EACH)
    }
}

/// Sorts lights by kind, then along a Z-order curve through `bounds` (directional ones through the
/// directions).
fn sort_by_place(lights: &mut [Vpl], bounds: Aabb) {
    let size = bounds.size().max_element().max(f32::MIN_POSITIVE);
    let code = |l: &Vpl| {
        let (kind, unit) = match l.kind {
            VplKind::Omni => (0, (l.position - bounds.lo) / size),
            VplKind::Spot(_) | VplKind::Image(_) => (1, (l.position - bounds.lo) / size),
            VplKind::Directional => (2, l.direction * 0.5 + 0.5),
            VplKind::Oriented => (3, (l.position - bounds.lo) / size),
            VplKind::Volume(_) => (4, (l.position - bounds.lo) / size),
        };
        (kind, morton(unit.to_array()))
    };
    let mut places: Vec<_> = lights.par_iter().map(code).zip(0..lights.len() as u32).collect();
    places.par_sort_unstable();
    // In place: a second list of lights would be most of what is in memory by then.
    let mut from: Vec<u32> = places.into_iter().map(|(_, from)| from).collect();
    for first in 0..lights.len() {
        let moved = lights[first];
        let mut to = first;
        loop {
            let source = std::mem::replace(&mut from[to], to as u32) as usize;
            if source == first {
                lights[to] = moved;
                break;
            }
            lights[to] = lights[source];
            to = source;
        }
    }
}

/// 20 bits of each coordinate in `[0, 1]`, interleaved.
fn morton(unit: [f32; 3]) -> u64 {
    let spread = |v: f32| {
        let mut x = (v.clamp(0.0, 1.0) * ((1 << 20) - 1) as f32) as u64;
        x = (x | x << 32) & 0x001f_0000_0000_ffff;
        x = (x | x << 16) & 0x001f_0000_ff00_00ff;
        x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
        x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
        (x | x << 2) & 0x1249_2492_4924_9249
    };
    spread(unit[0]) | spread(unit[1]) << 1 | spread(unit[2]) << 2
}
