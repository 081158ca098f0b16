//! Readings of sensors.

use crate::film::{Claim, PixelRecord, RenderFilm, Stop};
use crate::scene::Sensor;

use super::Photometry;

/// Irradiance and illuminance of a sensor, with the interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Irradiance by channel (W·m⁻²).
    pub irradiance: [f64; 3],
    /// Estimate of the illuminance (lx).
    pub illuminance: f64,
    /// Half-width of the interval of the illuminance (lx), 0 if it is exact; `None` if nothing is
    /// claimed.
    pub half_width: Option<f64>,
    /// Justification of the interval.
    pub claim: Claim,
    /// Reason why work on the sensor ended.
    pub stop: Stop,
    /// Rays that were traced for this sensor.
    pub rays: u64,
}

impl Reading {
    /// Reading of a sensor that was not measured.
    pub(super) const NONE: Self = Self {
        irradiance: [0.0; 3],
        illuminance: 0.0,
        half_width: None,
        claim: Claim::None,
        stop: Stop::NotRendered,
        rays: 0,
    };

    /// Returns true if the sensor was measured, with a finite illuminance.
    pub fn is_measured(&self) -> bool {
        self.stop != Stop::NotRendered && self.illuminance.is_finite()
    }

    /// Ends of the interval (lx), the lower one at least 0; `None` if nothing is claimed.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let half_width = self.half_width?;
        Some([(self.illuminance - half_width).max(0.0), self.illuminance + half_width])
    }
}

/// Reading of a pixel `(x, y)`: its radiance times π.
pub(super) fn reading(film: &RenderFilm<'_>, [x, y]: [u32; 2], photometry: Photometry) -> Reading {
    let PixelRecord { radiance, half_width, claim, stop, rays, .. } = film.at(x, y);
    let irradiance = radiance.to_array().map(|value| Sensor::IRRADIANCE_PER_RADIANCE * f64::from(value));
    let to_illuminance = Sensor::IRRADIANCE_PER_RADIANCE * photometry.efficacy();
    Reading {
        irradiance,
        illuminance: photometry.illuminance(irradiance),
        half_width: claim.is_some().then_some(to_illuminance * f64::from(half_width)),
        claim,
        stop,
        rays,
    }
}
