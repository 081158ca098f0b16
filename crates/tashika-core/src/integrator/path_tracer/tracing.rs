//! Scene, camera and emitters of paths, and the light that paths meet.

use super::PathTracer;
use super::path::{DrawnDirection, Found, Start};
use super::stream::Stream;
use crate::accel::{Apex, Glass, Hit, SegmentBatch, Tracer};
use crate::color::Rgb;
use crate::gather::through_panes;
use crate::integrator::Setting;
use crate::math::{Ray, Vec3};
use crate::media::Leg;
use crate::rng;
use crate::scene::{Camera, LightGroups, SurfacePoint};
use crate::vpl::{EmitterSampler, Vpl, VplKind};

/// Scene, camera and emitters of paths, and memory that they share.
pub(super) struct Tracing<'a> {
    pub tracer: &'a Tracer,
    pub camera: &'a Camera,
    pub emitters: &'a EmitterSampler<'a>,
    pub max_depth: u32,
    /// Groups of lights by which radiance is also summed, if requested.
    pub groups: Option<&'a LightGroups>,
    /// True if the scene or the camera depends on time.
    pub moves: bool,
    /// True if paths may scatter between surfaces.
    pub has_media: bool,
    batch: SegmentBatch,
    visibility: Vec<f32>,
}

impl PathTracer<'_> {
    pub(super) fn tracing<'a>(&'a self, setting: &Setting<'a>) -> Tracing<'a> {
        let camera = setting.view.camera;
        let scene = setting.tracer.scene();
        Tracing {
            tracer: setting.tracer,
            camera,
            emitters: &self.emitters,
            max_depth: self.max_depth,
            groups: self.groups,
            moves: scene.moves() || camera.motion.is_some(),
            has_media: scene.has_media() || camera.medium.is_some(),
            batch: SegmentBatch::new(Glass::SolidStops),
            visibility: Vec::new(),
        }
    }
}

impl Tracing<'_> {
    /// Follows paths. Calls `of_path` with the light that each path found, in the order of the
    /// paths.
    pub fn follow(&mut self, starts: impl IntoIterator<Item = Start>, mut of_path: impl FnMut(&Found)) {
        let mut starts = starts.into_iter();
        let mut stream = Stream::default();
        while stream.fill(self, &mut starts) {
            stream.follow(self);
            stream.found().for_each(&mut of_path);
        }
    }

    /// Light of the environment along a ray that leaves the scene, with the MIS weight of its
    /// direction; black without an environment.
    ///
    /// * `weight`, `ratio`: throughput for basic radiance, and product of
    ///   `SpecularPoint::squared_ratio` over the boundaries of glass that the path has crossed.
    #[inline]
    pub fn light_of_environment(
        &self,
        ray: &Ray,
        drawn: Option<&DrawnDirection>,
        weight: Rgb,
        ratio: f64,
    ) -> Rgb {
        let Some(e) = self.tracer.scene().environment() else { return Rgb::BLACK };
        let d = ray.direction.normalize();
        let mis = drawn.map_or(1.0, |drawn| drawn.weight_of_environment(self.emitters, d));
        weight * (e.radiance(d) * self.camera.basic_of_infinity(ratio)) * mis
    }

    /// Light that a surface emits towards a path, with the MIS weight of its direction.
    ///
    /// * `weight`: throughput for basic radiance.
    #[inline]
    pub fn light_of_surface(
        &self,
        (surface, hit, share): (&SurfacePoint, &Hit, f32),
        outgoing: Vec3,
        drawn: Option<&DrawnDirection>,
        weight: Rgb,
    ) -> Rgb {
        let emitted = self.tracer.emitted(surface, outgoing);
        if emitted.is_black() {
            return Rgb::BLACK;
        }
        let of_drawn =
            |drawn: &DrawnDirection| drawn.weight_of_hit(self.emitters, share, surface, hit, outgoing);
        weight * emitted * drawn.map_or(1.0, of_drawn)
    }

    /// Returns basic radiance over radiance of a sampled light: 1 except for light from infinitely
    /// far away.
    ///
    /// * `ratio`: product of `SpecularPoint::squared_ratio` over the boundaries of glass that the
    ///   path has crossed.
    #[inline]
    pub fn basic_of(&self, light: &Vpl, ratio: f64) -> f32 {
        if light.kind == VplKind::Directional { self.camera.basic_of_infinity(ratio) } else { 1.0 }
    }

    /// Visibility of a light from a point.
    pub fn visible(&mut self, apex: Apex, target: Vec3, share: f32) -> f32 {
        self.batch.clear();
        self.batch.push_fan(apex, [target]);
        self.tracer.visibility_at(&self.batch, share, &mut self.visibility);
        self.visibility[0]
    }

    /// Transmittance by channel from a light through panes, in addition to the straight visibility
    /// `free`; black unless the light is infinitely far away.
    ///
    /// * `begun`: ray from the point to the light.
    /// * `key`, `share`: key for the decisions of rays at partly opaque surfaces, and time.
    /// * `depth`: number of surfaces that the path has met before the point.
    /// * `rays`: increased by the number of rays traced.
    #[inline]
    pub fn through_panes(
        &self,
        free: f32,
        begun: Leg,
        light: &Vpl,
        (key, share, depth): (u64, f32, u32),
        stream: &mut rng::Stream,
        rays: &mut u64,
    ) -> Rgb {
        if free >= 1.0 || light.kind != VplKind::Directional || !self.tracer.scene().refracts() {
            return Rgb::BLACK;
        }
        let most = self.max_depth.saturating_sub(depth);
        through_panes(self.tracer, begun, (key, share), most, stream, rays).unwrap_or(Rgb::BLACK)
    }
}
