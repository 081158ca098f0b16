//! Features of first surfaces, for denoisers and compositing.

use glam::Vec3;

use crate::color::Rgb;
use crate::film::PixelRecord;

/// Averages over a pixel's camera samples for denoisers and compositing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Features {
    /// Mean distance to the first surface (m), over the samples that met one.
    pub depth: f32,
    /// Mean shading normal of the first surface (world), over the samples that met one.
    pub normal: Vec3,
    /// Mean rough reflectance over all samples: white in media, black for samples without a gather
    /// point.
    pub albedo: Rgb,
    /// Share of samples that met a surface.
    pub coverage: f32,
}

/// Record of a pixel with these features alone.
impl From<Features> for PixelRecord {
    fn from(features: Features) -> Self {
        let Features { depth, normal, albedo, coverage } = features;
        Self { depth, normal, albedo, coverage, ..Self::default() }
    }
}

/// First surface of a camera path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstSurface {
    /// Length of the path to the surface (m).
    pub distance: f32,
    /// Unit shading normal on the side of the viewer.
    pub normal: Vec3,
}

/// Features of a pixel in progress.
#[derive(Clone, Copy, Debug)]
pub struct FeatureSums {
    sums: Features,
    samples: u32,
    added: u32,
    met: u32,
}

impl FeatureSums {
    /// No samples yet, of the given number.
    pub fn new(samples: u32) -> Self {
        Self { sums: Features::default(), samples, added: 0, met: 0 }
    }

    /// Number of samples that are missing.
    pub fn missing(&self) -> u32 {
        self.samples - self.added
    }

    /// Adds a sample: the rough reflectance of its gather point, and its first surface, if there
    /// are such.
    pub fn add(&mut self, first: Option<&FirstSurface>, albedo: Option<Rgb>) {
        self.added += 1;
        if let Some(albedo) = albedo {
            self.sums.albedo += albedo * (1.0 / self.samples as f32);
        }
        if let Some(first) = first {
            self.met += 1;
            self.sums.depth += first.distance;
            self.sums.normal += first.normal;
        }
    }

    /// Features of the samples, all of which have been added.
    pub fn mean(self) -> Features {
        let Self { sums, met, samples, .. } = self;
        if met == 0 {
            return sums;
        }
        let (depth, normal) = (sums.depth / met as f32, sums.normal / met as f32);
        Features { depth, normal, coverage: met as f32 / samples as f32, ..sums }
    }
}
