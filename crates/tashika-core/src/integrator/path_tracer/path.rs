//! A path from the camera: its beginning, its state between two surfaces, and the light it found.

use crate::accel::Hit;
use crate::color::Rgb;
use crate::gather::{Beginning, FirstSurface, GatherPoint, Passage, View};
use crate::math::{Ray, Vec3};
use crate::media::{Leg, MAX_SURVIVAL_IN_MEDIUM, MOST_PASSED};
use crate::rng::{Purpose, Stream};
use crate::scene::{Camera, LightGroups, LightId, SurfacePoint};
use crate::vpl::{EmitterSampler, LightSample, VplKind};
use crate::warp::balance;

/// Surfaces after which a path may end by Russian roulette.
const CERTAIN_DEPTH: u32 = 3;
/// Highest survival probability at surfaces. Without this limit, paths in a closed white room would
/// never end.
const MAX_SURVIVAL: f32 = 0.98;

/// Beginning of a path.
#[derive(Clone, Debug)]
pub(super) struct Start {
    pub beginning: Beginning,
    /// Key of the decisions at partly opaque surfaces.
    pub key: u64,
    /// Time of the path, as a share of the time that the shutter is open.
    pub share: f32,
    /// Random numbers of the path.
    pub stream: Stream,
}

impl Start {
    /// Beginning of the path of `key` through a random place of a pixel, at a random time if
    /// `moves` is true.
    pub fn random(view: &View<'_>, pixel: [u32; 2], key: u64, moves: bool) -> Self {
        let mut stream = Stream::new(key, Purpose::CameraPath, 0);
        let [u, v] = stream.uniform_2();
        let [s, t] = stream.uniform_2();
        let share = if moves { Stream::new(key, Purpose::Shutter, 0).uniform() } else { 0.0 };
        let beginning = view.beginning_of(pixel, [u, v, s, t], || share);
        Self { beginning, key, share, stream }
    }

    /// Beginning of path `index` of a pixel, whose places within the pixel and times are spread
    /// evenly.
    ///
    /// * `seed`: seed of the random numbers after the camera ray.
    pub fn even(view: &View<'_>, pixel: [u32; 2], index: u32, seed: u64, moves: bool) -> Self {
        let (beginning, key) = view.beginning(pixel, index);
        let share = if moves { view.time(pixel, index) } else { 0.0 };
        Self { beginning, key, share, stream: Stream::new(seed, Purpose::Picture, index.into()) }
    }
}

/// A path between two surfaces or scatterings.
pub(super) struct Path {
    pub leg: Leg,
    key: u64,
    /// Time, as a share of the time that the shutter is open.
    pub share: f32,
    pub stream: Stream,
    /// Throughput, for basic radiance.
    pub weight: Rgb,
    /// Product of `SpecularPoint::squared_ratio` over the boundaries of glass that the path has
    /// crossed.
    pub ratio: f64,
    /// Last drawn direction; `None` at first.
    pub drawn: Option<DrawnDirection>,
    /// Number of surfaces that the path has met.
    pub depth: u32,
    /// Number of scatterings, at surfaces and in media.
    scattered: u32,
    /// Number of boundaries passed since the last scattering.
    passed: u32,
}

impl Path {
    /// A path at its beginning.
    pub fn new(camera: &Camera, ray: Ray, key: u64, share: f32, stream: Stream) -> Self {
        Self {
            leg: Leg { ray, medium: camera.medium },
            key,
            share,
            stream,
            weight: Rgb::gray(camera.squared_index()),
            ratio: 1.0,
            drawn: None,
            depth: 0,
            scattered: 0,
            passed: 0,
        }
    }

    /// Key of the decisions at partly opaque surfaces. It is the same along a straight line, and so
    /// are the holes in surfaces.
    pub fn key(&self) -> u64 {
        self.key.wrapping_add(self.scattered.into())
    }

    /// Counts a boundary of media. Returns true if the path goes on.
    pub fn passes(&mut self) -> bool {
        self.passed += 1;
        self.passed <= MOST_PASSED && !self.weight.is_black()
    }

    /// Sends the path on from a gather point, in a direction of the given density (sr⁻¹).
    pub fn turn(&mut self, point: &GatherPoint, direction: Vec3, density: f32) {
        self.leg = Leg { ray: Ray::new(point.position, direction), medium: point.medium };
        self.drawn = Some(DrawnDirection::new(&self.leg.ray, density));
    }

    /// Counts a surface, and applies Russian roulette. Returns true if the path goes on.
    pub fn goes_on_from_surface(&mut self) -> bool {
        self.depth += 1;
        self.survives(self.depth, MAX_SURVIVAL)
    }

    /// Counts a scattering in a medium, and applies Russian roulette. Returns true if the path goes
    /// on.
    pub fn goes_on_from_medium(&mut self) -> bool {
        self.survives(self.scattered.saturating_add(1), MAX_SURVIVAL_IN_MEDIUM)
    }

    fn survives(&mut self, met: u32, most: f32) -> bool {
        self.scattered = self.scattered.saturating_add(1);
        self.passed = 0;
        if met > CERTAIN_DEPTH {
            let survival = self.weight.max_channel().min(most);
            if self.stream.uniform() >= survival {
                return false;
            }
            self.weight = self.weight / survival;
        }
        !self.weight.is_black()
    }
}

/// Light that a path found, and its work.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// All light found (W·m⁻²·sr⁻¹).
    pub radiance: Rgb,
    /// Radiance found before the path first scattered.
    pub seen: Rgb,
    /// True if the path met a surface or medium that scatters light.
    pub gathers: bool,
    /// Number of rays and segments that were traced.
    pub rays: u64,
    /// Radiance by group of lights; empty unless requested.
    pub by_group: Vec<Rgb>,
    /// First surface of the path, if it met one; unused in scenes with media.
    pub first: Option<FirstSurface>,
    /// Rough reflectance at the first gather point, if there is one; unused in scenes with media.
    pub albedo: Option<Rgb>,
}

impl Found {
    /// Clears everything; keeps the allocated memory.
    pub fn clear(&mut self, groups: Option<&LightGroups>) {
        let mut by_group = std::mem::take(&mut self.by_group);
        by_group.clear();
        by_group.resize(groups.map_or(0, LightGroups::count), Rgb::BLACK);
        *self = Self { by_group, ..Self::default() };
    }

    /// Adds the contribution of a light.
    #[inline]
    pub fn add(&mut self, groups: Option<&LightGroups>, light: LightId, given: Rgb) {
        if given.is_black() {
            return;
        }
        self.radiance += given;
        if !self.gathers {
            self.seen += given;
        }
        if let Some(groups) = groups {
            self.by_group[groups.of(light)] += given;
        }
    }
}

/// A direction in which a path was scattered.
#[derive(Clone, Copy, Debug)]
pub(super) struct DrawnDirection {
    /// Origin of the direction.
    at: Vec3,
    direction: Vec3,
    /// Density of the direction (sr⁻¹).
    density: f32,
    /// Passage of the path since the direction was drawn.
    pub passage: Passage,
}

impl DrawnDirection {
    /// Direction of a ray, with its density (sr⁻¹).
    pub fn new(ray: &Ray, density: f32) -> Self {
        Self { at: ray.origin, direction: ray.direction, density, passage: Passage::Straight }
    }

    /// MIS weight of the environment in the direction `met`, against drawing it from the emitters.
    pub fn weight_of_environment(&self, emitters: &EmitterSampler<'_>, met: Vec3) -> f32 {
        let is_drawn = self.passage.is_straight() || self.passage.is_through_panes(self.direction, met);
        if is_drawn { balance(self.density, emitters.pdf_of_environment(met)) } else { 1.0 }
    }

    /// MIS weight of an emitter met at time `share`, against drawing it from the emitters.
    pub fn weight_of_hit(
        &self,
        emitters: &EmitterSampler<'_>,
        share: f32,
        surface: &SurfacePoint,
        hit: &Hit,
        outgoing: Vec3,
    ) -> f32 {
        if !self.passage.is_straight() {
            return 1.0;
        }
        let distance = self.at.distance_squared(surface.position);
        let cos = surface.geometric_normal.dot(outgoing).abs();
        let on_area = emitters.pdf_on_triangle_at(share, hit.instance, hit.triangle);
        balance(self.density, on_area * distance / cos.max(f32::MIN_POSITIVE))
    }
}

/// MIS weight of a light drawn from the emitters, against meeting it along a direction from
/// `position` of density `pdf` (sr⁻¹).
pub(super) fn weight_of_light(sample: &LightSample, position: Vec3, pdf: impl FnOnce(Vec3) -> f32) -> f32 {
    let light = &sample.light;
    sample.pdf.map_or(1.0, |of_light| {
        let (towards, jacobian) = if light.kind == VplKind::Directional {
            (-light.direction, 1.0)
        } else {
            let d = light.position - position;
            let towards = d.normalize();
            (towards, d.length_squared() / -light.direction.dot(towards))
        };
        balance(of_light * jacobian, pdf(towards))
    })
}
