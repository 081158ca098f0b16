//! Radiance of a pixel by group of lights.
//!
//! Each contribution to a path comes from one emitter. It is added to the group of that emitter as
//! well as to the radiance of the pixel. The planes of all groups are estimates by the same paths,
//! so that they add up to the radiance. Each plane is the mean of independent paths: an unbiased
//! estimate of the image that the lights of the group alone would give. Emitters are chosen by a
//! distribution over all groups, so that the emitters of a faint group are drawn rarely, and its
//! relative error is large.
//!
//! # Held to this by
//! The suite's `light_groups`.

use crate::color::{Rgb, RgbSum};
use crate::integrator::PlaneBeside;
use crate::scene::LightGroups;
use crate::stats::Moments;

/// Sums over the paths of a pixel, by groups.
#[derive(Clone, Debug)]
pub(super) struct PathsByGroup {
    sums: Vec<RgbSum>,
    /// Moments of the luminance of single paths.
    moments: Vec<Moments>,
}

impl PathsByGroup {
    /// No paths, of `count` groups.
    pub fn new(count: usize) -> Self {
        Self { sums: vec![RgbSum::default(); count], moments: vec![Moments::default(); count] }
    }

    /// Adds a path, by the radiance that each group gave to it.
    pub fn add(&mut self, by_group: &[Rgb]) {
        for ((given, sum), moments) in by_group.iter().zip(&mut self.sums).zip(&mut self.moments) {
            sum.add(*given);
            moments.push(given.luminance().into());
        }
    }

    /// Appends the samples of the pixel, in the order of [`planes`].
    pub fn samples(&self, to: &mut Vec<f32>) {
        for (sum, moments) in self.sums.iter().zip(&self.moments) {
            to.extend(sum.scaled(1.0 / moments.count().max(1) as f64).total().to_array());
            to.push(moments.standard_error() as f32);
        }
    }
}

/// A plane of radiance for each group, each followed by the standard error of its luminance.
pub(super) fn planes(groups: &LightGroups) -> Vec<PlaneBeside> {
    let of_group = |(layer, name): (String, &String)| {
        let doc = format!("what the lights of the group {name:?} give of the radiance");
        let of_error = format!("standard error of the luminance of the group {name:?}");
        [
            PlaneBeside { name: format!("light_{layer}"), channels: &["R", "G", "B"], doc },
            PlaneBeside { name: format!("light_{layer}_standard_error"), channels: &["Y"], doc: of_error },
        ]
    };
    groups.layers().into_iter().zip(groups.names()).flat_map(of_group).collect()
}
