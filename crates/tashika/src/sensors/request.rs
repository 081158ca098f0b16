//! Requests for sensors: options in lux, and their defaults.

use crate::error::{Error, Result};
use crate::integrator::ControlOptions;
use crate::request::{ClaimName, MethodName, Request};
use crate::scene::Sensor;

use super::{GridSummary, Photometry};

/// Default relative error of light transport.
const DEFAULT_ERROR: f64 = 0.05;

/// Options of a measurement by sensors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorRequest {
    /// Options as for an image, with the absolute error in lux. Default claim: calibrated, within
    /// 5 %. The error metric and the gather points follow from the sensors.
    pub request: Request,
    /// Conversion to illuminance.
    pub photometry: Photometry,
    /// True if the intervals of all sensors are to hold together with the confidence.
    pub jointly: bool,
}

impl SensorRequest {
    /// Returns the request by which `sensors` sensors are rendered.
    ///
    /// # Errors
    /// [`Error::Option`] for an audited claim; as [`Request::validate`].
    pub fn of(&self, sensors: usize) -> Result<Request> {
        if self.request.claim == Some(ClaimName::Audited) {
            let expected = "calibrated or certified: an audited claim is about a picture";
            return Err(Error::option("claim", ClaimName::Audited, expected));
        }
        let claim = self.request.claim.unwrap_or(ClaimName::Calibrated);
        let is_about_transport = claim == ClaimName::Calibrated
            && (self.request.method == MethodName::default() || self.request.method == MethodName::Path);
        let states_claim = self.request.method == MethodName::default() || self.request.claim.is_some();
        let is_of_paths = self.request.method == MethodName::Path;
        let confidence = match self.jointly {
            true => Some(GridSummary::joint_confidence(self.confidence(), sensors)),
            false => self.request.confidence,
        };
        let to_radiance = 1.0 / (Sensor::IRRADIANCE_PER_RADIANCE * self.photometry.efficacy());
        let request = Request {
            claim: (states_claim || is_of_paths).then_some(claim),
            error: self.request.error.or(is_about_transport.then_some(DEFAULT_ERROR)),
            absolute: self.request.absolute.map(|lux| lux * to_radiance),
            control: Some(self.photometry.controlled()).filter(|_| is_about_transport || states_claim),
            confidence,
            ..self.request.clone()
        };
        request.validate()?;
        Ok(request)
    }

    /// Confidence of each interval, or of all together: the given one, or the default.
    pub fn confidence(&self) -> f64 {
        self.request.confidence.unwrap_or(ControlOptions::default().confidence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Controlled;
    use crate::integrator::SumMethod;

    #[test]
    fn lux_become_radiance_and_claims_have_defaults() {
        let lux = Request { absolute: Some(100.0), ..Request::default() };
        let asked = SensorRequest { request: lux, photometry: Photometry::Radiance, jointly: false };
        let found = asked.of(10).unwrap();
        assert_eq!((found.claim, found.error), (Some(ClaimName::Calibrated), Some(0.05)));
        assert_eq!(found.control, Some(Controlled::Channels));
        let radiance = found.absolute.unwrap();
        assert!((radiance * std::f64::consts::PI * 179.0 - 100.0).abs() < 1e-9);
        assert_eq!(found.confidence, None);
        let jointly = SensorRequest { jointly: true, ..asked.clone() }.of(10).unwrap();
        assert!((jointly.confidence.unwrap() - 0.995).abs() < 1e-12);
        let certified = Request { claim: Some(ClaimName::Certified), ..Request::default() };
        let certified = SensorRequest { request: certified, ..SensorRequest::default() }.of(1).unwrap();
        assert_eq!((certified.claim, certified.error), (Some(ClaimName::Certified), None));
        let paths = Request { method: MethodName::Path, ..Request::default() };
        let paths = SensorRequest { request: paths, ..SensorRequest::default() }.of(1).unwrap();
        assert_eq!((paths.claim, paths.error), (Some(ClaimName::Calibrated), Some(0.05)));
        let exact = Request { method: SumMethod::Exact.into(), ..Request::default() };
        let exact = SensorRequest { request: exact, ..SensorRequest::default() }.of(1).unwrap();
        assert_eq!((exact.claim, exact.error), (None, None));
    }

    #[test]
    fn audited_sensors_are_refused() {
        let audited = Request { claim: Some(ClaimName::Audited), ..Request::default() };
        let refused = SensorRequest { request: audited, ..SensorRequest::default() }.of(1);
        assert!(refused.unwrap_err().to_string().contains("calibrated or certified"));
    }
}
