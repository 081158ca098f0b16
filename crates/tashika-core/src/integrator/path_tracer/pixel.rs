//! The paths of one pixel, and the statement about its error.

use std::ops::Range;

use super::groups::PathsByGroup;
use super::nearby::Nearby;
use super::path::{Found, Start};
use super::stopping::{Looking, Next, Scattering};
use super::{OF_FEATURES, PathView};
use crate::color::RgbSum;
use crate::film::{Claim, Stop};
use crate::gather::{FeatureSums, View};
use crate::integrator::{HalfWidths, PixelRecord};
use crate::rng::{self, Purpose};
use crate::stats::Moments;

/// Paths that a pixel needs for its next analysis.
pub(super) struct Missing {
    pixel: [u32; 2],
    /// Key of the random numbers of the pixel's paths.
    key: u64,
    paths: Range<u32>,
}

impl Missing {
    pub fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    pub fn len(&self) -> usize {
        self.paths.len()
    }

    /// Beginnings of the paths; `moves` is true if they depend on time.
    pub fn starts<'a>(&self, view: &'a View<'a>, moves: bool) -> impl Iterator<Item = Start> + use<'a> {
        let Self { pixel, key, .. } = *self;
        self.paths.clone().map(move |path| {
            Start::random(view, pixel, rng::key(key, Purpose::CameraPath, path.into()), moves)
        })
    }
}

/// A pixel in progress.
pub(super) struct PixelPaths<'v> {
    view: &'v PathView<'v>,
    pixel: [u32; 2],
    /// Key of the random numbers of its paths.
    key: u64,
    nearby: Option<&'v Nearby>,
    looking: Looking<'v>,
    /// Number of paths at the next analysis.
    wanted: u32,
    sum: RgbSum,
    /// Moments of single paths, by part of the error metric.
    moments: Vec<Moments>,
    by_group: PathsByGroup,
    /// Features of the first paths; unused in scenes with media.
    features: FeatureSums,
    has_media: bool,
    rays: u64,
    /// True if a path met a surface or medium that scatters light.
    gathers: bool,
    /// Approximate luminance of surfaces that no path met; `None` until an analysis asks for it.
    unmet: Option<f64>,
    /// Claim, half-width and reason of the end.
    end: Option<(Claim, f64, Stop)>,
}

impl<'v> PixelPaths<'v> {
    pub fn new(view: &'v PathView<'v>, pixel: [u32; 2], has_media: bool) -> Self {
        let (method, nearby) = (view.method, view.nearby(pixel));
        let number = u64::from(pixel[1]) << 32 | u64::from(pixel[0]);
        let (looking, wanted) = Looking::new(method.stop, nearby.map_or(&[], Nearby::moments));
        let parts = method.stop.controlled().parts().len();
        Self {
            view,
            pixel,
            key: rng::key(view.setting.view.seed, Purpose::CameraPath, number),
            nearby,
            looking,
            wanted,
            sum: RgbSum::default(),
            moments: vec![Moments::default(); parts],
            by_group: PathsByGroup::new(method.groups.map_or(0, |groups| groups.count())),
            features: FeatureSums::new(OF_FEATURES.min(wanted)),
            has_media,
            rays: 0,
            gathers: false,
            unmet: None,
            end: None,
        }
    }

    fn done(&self) -> u32 {
        self.moments[0].count() as u32
    }

    /// Paths that the pixel needs for its next analysis; none if it has ended.
    pub fn missing(&self) -> Missing {
        let done = self.done();
        let wanted = if self.end.is_none() { self.wanted } else { done };
        Missing { pixel: self.pixel, key: self.key, paths: done..wanted }
    }

    /// Adds the next path.
    pub fn add(&mut self, found: &Found) {
        let parts = self.view.method.stop.controlled().parts();
        self.sum.add(found.radiance);
        parts.iter().zip(&mut self.moments).for_each(|(part, m)| m.push(part.of(found.radiance)));
        self.by_group.add(&found.by_group);
        if self.features.missing() > 0 {
            self.features.add(found.first.as_ref(), found.albedo);
        }
        self.rays += found.rays;
        self.gathers |= found.gathers;
    }

    /// Analyses the paths, unless the pixel has ended.
    pub fn analyse(&mut self) {
        if self.end.is_some() {
            return;
        }
        let scattering = match self.nearby {
            _ if self.gathers => Scattering::Met,
            // Outside the film's image no ray leaves the camera.
            Some(nearby) if self.rays > 0 => {
                let unmet = || self.view.importance_unmet(self.pixel, nearby);
                Scattering::Unmet(*self.unmet.get_or_insert_with(unmet))
            }
            _ => Scattering::Unmet(0.0),
        };
        match self.looking.look(&self.moments, &self.mean(), scattering) {
            Next::Follow(more) => self.wanted = more,
            Next::End { claim, half_width, stop } => self.end = Some((claim, half_width, stop)),
        }
    }

    fn mean(&self) -> RgbSum {
        self.sum.scaled(1.0 / f64::from(self.done()))
    }

    /// Record of the pixel, which must have ended.
    pub fn record(&self) -> PixelRecord {
        let (claim, half_width, stop) = self.end.expect("the last analysis ended the pixel");
        let view = &self.view.setting.view;
        let of_features = if self.has_media { OF_FEATURES.min(self.done()) } else { 0 };
        let features = match of_features {
            0 => self.features.mean(),
            count => view.features(self.view.setting.tracer, self.pixel, count, self.key),
        };
        let half_width = claim.stated(half_width);
        let standard_error = match self.done() {
            // A single path has no estimate of its error.
            1 => f64::NAN,
            _ => self.moments.iter().map(Moments::standard_error).fold(0.0, f64::max),
        };
        PixelRecord {
            radiance: self.mean().total(),
            standard_error: standard_error as f32,
            claim,
            half_width,
            half_widths: HalfWidths { compensation: half_width, ..HalfWidths::default() },
            stop,
            pairs: u64::from(self.done()),
            rays: self.rays + u64::from(of_features) + self.nearby.map_or(0, Nearby::rays_per_pixel),
            ..features.into()
        }
    }

    /// Appends the samples of the planes of groups.
    pub fn samples_by_group(&self, to: &mut Vec<f32>) {
        self.by_group.samples(to);
    }
}
