//! Stopping rules of a pixel's paths.
//!
//! * After a given number of paths ([`PathStop::Count`]), without a claim.
//! * By the rule that a careful user would write ([`PathStop::Until`]): as soon as Student's
//!   interval of the mean is within the tolerance. It is the baseline for our own rule, and its
//!   intervals have the claim of a published method. If samples have heavy tails, it often stops
//!   before a rare bright path is met.
//! * By our own rule ([`PathStop::Calibrated`]): the interval accounts for paths of the
//!   neighbourhood and for light brighter than all observed ([`PathSpread`]). Interim analyses are
//!   few, planned, and share the error probability ([`Looks`]).
//!
//! ```text
//! h = t_ν √V + κ b ln(2/δ_j) + B ln(1/δ_j)/n
//! ```
//!
//! The last term is only for pixels in which none of the `n` paths met a surface although one may
//! be there, of about the luminance `B` ([`Scattering::Unmet`]). All paths miss a surface that
//! covers the share `c` of the pixel with probability `(1 − c)ⁿ`, which is below `δ_j` if
//! `c ≥ ln(1/δ_j)/n`.
//!
//! # Guarantee
//! The coverage of the calibrated interval is measured, not proven. Held to this by the suite's
//! `paths_alone`; the record has the measurements.

use crate::color::{Controlled, RgbSum};
use crate::error::{Error, Result};
use crate::film::{Metadata, keys};
use crate::integrator::looks::{AIM, Looks};
use crate::integrator::path_spread::{KAPPA_OF_PATHS, PathSpread};
use crate::integrator::{Claim, ControlOptions, Stop};
use crate::math::elementary::ln_f64;
use crate::stats::{Moments, student_t_two_sided};

/// Condition under which a pixel has enough paths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathStop {
    /// A fixed number of paths, at least 1.
    Count(u32),
    /// `first` paths, then repeatedly half as many again, until Student's interval of the error
    /// metric is within the tolerance or there are `most` paths.
    Until {
        /// Tolerance, confidence and error metric.
        options: ControlOptions,
        /// Paths at the first analysis, at least 2.
        first: u32,
        /// Paths at which a pixel is out of budget.
        most: u32,
    },
    /// As many paths as are predicted to bring our own interval within the tolerance, at most
    /// `most`.
    Calibrated {
        /// Tolerance, confidence and error metric.
        options: ControlOptions,
        /// Paths at which a pixel is out of budget, at least 2.
        most: u32,
    },
}

/// Paths at the first analysis, enough for a meaningful interval. Chosen.
const FIRST: u32 = 64;
/// Most growth between analyses of our own rule: predictions from few paths are far off.
const MOST_GROWTH: f64 = 4.0;
/// Least growth between analyses, as a factor.
const LEAST_GROWTH: f64 = 1.1;

impl PathStop {
    /// The rule that a careful user of a path tracer stops by: the interval is tested from 64 paths
    /// on, or from `most` (at least 2).
    pub fn until(options: ControlOptions, most: u32) -> Self {
        let most = most.max(2);
        Self::Until { options, first: FIRST.min(most), most }
    }

    /// Options of the interval, if the rule uses one.
    pub fn options(&self) -> Option<&ControlOptions> {
        match self {
            Self::Count(_) => None,
            Self::Until { options, .. } | Self::Calibrated { options, .. } => Some(options),
        }
    }

    /// Claim of pixels that meet the rule.
    pub(super) fn claim(&self) -> Claim {
        match self {
            Self::Count(_) => Claim::None,
            Self::Until { .. } => Claim::Published,
            Self::Calibrated { .. } => Claim::Calibrated,
        }
    }

    pub(super) fn controlled(&self) -> Controlled {
        self.options().map(|options| options.controlled).unwrap_or_default()
    }

    /// Checks that all values are in range.
    ///
    /// # Errors
    /// No paths, a first analysis at fewer than two, options out of range.
    pub(super) fn validate(&self) -> Result<()> {
        let fewest = match *self {
            Self::Count(0) => return Err(Error::option("paths", 0, "at least 1")),
            Self::Count(_) => return Ok(()),
            Self::Until { first, most, .. } => [first, most],
            Self::Calibrated { most, .. } => [2, most],
        };
        let [first, most] = fewest;
        if first < 2 || most < first {
            let paths = format!("{first}, then {most}");
            return Err(Error::option("paths", paths, "at least 2 at first, and no fewer in the end"));
        }
        self.options().map_or(Ok(()), ControlOptions::validate)
    }

    pub(super) fn describe(&self, metadata: &mut Metadata) {
        match *self {
            Self::Count(count) => metadata.set(keys::PATHS, count),
            Self::Until { first, most, .. } => {
                metadata.set(keys::PATHS_FIRST, first);
                metadata.set(keys::PATHS_MOST, most);
            }
            Self::Calibrated { most, .. } => {
                metadata.set(keys::PATHS_MOST, most);
                metadata.set(keys::CLAIM, self.claim().code().name);
            }
        }
        if let Some(options) = self.options() {
            metadata.set(keys::ERROR, options.error);
            metadata.set(keys::CONTROL, options.controlled.to_string());
            metadata.set(keys::ERROR_ABSOLUTE, options.absolute_error);
            metadata.set(keys::CONFIDENCE, options.confidence);
        }
    }
}

/// Surfaces and media of a pixel that scatter light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scattering {
    /// At least one path was scattered.
    Met,
    /// No path was scattered, though surfaces of about this luminance may be there; zero if the
    /// pixel is certainly empty (W·m⁻²·sr⁻¹).
    Unmet(f64),
}

/// Decision of an interim analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Next {
    /// Number of paths of the pixel at the next analysis.
    Follow(u32),
    /// End of the pixel, with its statement.
    End { claim: Claim, half_width: f64, stop: Stop },
}

/// The interim analyses of one pixel.
pub(super) struct Looking<'a> {
    stop: PathStop,
    /// Moments of paths of the neighbourhood, by part of the error metric; empty if the rule does
    /// not use them.
    nearby: &'a [Moments],
    looks: Looks,
    /// True if it was decided before the paths were followed that this analysis may state an
    /// interval.
    is_planned: bool,
}

impl<'a> Looking<'a> {
    /// State before the first analysis, with the number of paths for it.
    pub fn new(stop: PathStop, nearby: &'a [Moments]) -> (Self, u32) {
        let first = match stop {
            PathStop::Count(count) => count,
            PathStop::Until { first, .. } => first,
            PathStop::Calibrated { most, .. } => FIRST.min(most),
        };
        let is_planned = matches!(stop, PathStop::Calibrated { most, .. } if most <= FIRST);
        let looks = Looks::new(stop.options().unwrap_or(&ControlOptions::default()));
        (Self { stop, nearby, looks, is_planned }, first)
    }

    /// Analyses the paths of a pixel.
    ///
    /// * `moments`: moments of the paths, by part of the error metric; `mean`: mean of their
    ///   radiances.
    /// * `scattering`: surfaces and media that the paths met.
    pub fn look(&mut self, moments: &[Moments], mean: &RgbSum, scattering: Scattering) -> Next {
        // More paths cannot make the pixel finite.
        if !mean.total().is_finite() {
            return Next::End { claim: Claim::None, half_width: f64::NAN, stop: Stop::NotFinite };
        }
        match self.stop {
            PathStop::Count(_) => Next::End { claim: Claim::None, half_width: 0.0, stop: Stop::SampleCount },
            PathStop::Until { options, most, .. } => {
                let half_width = student_half_width(moments, options.confidence);
                let done = moments[0].count() as u32;
                if half_width <= options.tolerance(mean) {
                    Next::End { claim: self.stop.claim(), half_width, stop: Stop::RuleMet }
                } else if done >= most {
                    Next::End { claim: Claim::None, half_width: 0.0, stop: Stop::Budget }
                } else {
                    Next::Follow(done.saturating_add(done / 2).min(most))
                }
            }
            PathStop::Calibrated { options, most } => {
                self.look_calibrated(&options, most, moments, mean, scattering)
            }
        }
    }

    fn look_calibrated(
        &mut self,
        options: &ControlOptions,
        most: u32,
        moments: &[Moments],
        mean: &RgbSum,
        scattering: Scattering,
    ) -> Next {
        // Where nothing scatters, the camera sees all light directly, and paths of the
        // neighbourhood do not matter.
        let (nearby, unmet) = match scattering {
            Scattering::Met => (self.nearby, 0.0),
            Scattering::Unmet(luminance) => (&[][..], luminance),
        };
        let interval = |delta| Interval::of(moments, nearby, unmet, delta);
        let (tolerance, done) = (options.tolerance(mean), moments[0].count() as f64);
        if self.is_planned {
            let half_width = interval(self.looks.delta()).half_width();
            let is_met = half_width <= tolerance;
            if is_met || done >= f64::from(most) {
                let stop = if is_met { Stop::RuleMet } else { Stop::Budget };
                return Next::End { claim: self.stop.claim(), half_width, stop };
            }
            self.looks.next();
        }
        let growth = interval(self.looks.delta()).growth(AIM * tolerance);
        let wanted = (done * growth.clamp(LEAST_GROWTH, MOST_GROWTH)).ceil();
        self.is_planned = growth <= MOST_GROWTH || wanted >= f64::from(most);
        Next::Follow(wanted.min(most.into()) as u32)
    }
}

/// Our own interval of a mean: `h = t_ν √V + κ b ln(2/δ) + B ln(1/δ)/n`.
#[derive(Clone, Copy, Debug)]
struct Interval {
    by_variance: f64,
    /// The other terms, which are inversely proportional to the number of paths.
    by_rare: f64,
}

impl Interval {
    /// Widest interval among the parts of the error metric, which share `δ` evenly.
    ///
    /// * `unmet`: `B`.
    fn of(moments: &[Moments], nearby: &[Moments], unmet: f64, delta: f64) -> Self {
        let delta = delta / moments.len() as f64;
        let of_part = |(part, own): (usize, &Moments)| {
            let spread = PathSpread::of(own, &nearby.get(part).copied().unwrap_or_default());
            let by_variance = student_t_two_sided(1.0 - delta, spread.freedom) * spread.variance.sqrt();
            let by_unmet = unmet * ln_f64(delta.recip()) / own.count() as f64;
            Self { by_variance, by_rare: KAPPA_OF_PATHS * spread.largest * ln_f64(2.0 / delta) + by_unmet }
        };
        let all = moments.iter().enumerate().map(of_part);
        all.max_by(|a, b| a.half_width().total_cmp(&b.half_width())).expect("something is controlled")
    }

    fn half_width(&self) -> f64 {
        self.by_variance + self.by_rare
    }

    /// Factor on the number of paths that brings the interval to `half_width`: with
    /// `x = 1/√growth`, `by_rare x² + by_variance x = half_width`.
    fn growth(&self, half_width: f64) -> f64 {
        let Self { by_variance, by_rare } = *self;
        let root = (by_variance * by_variance + 4.0 * by_rare * half_width).sqrt();
        let growth_root = (by_variance + root) / (2.0 * half_width);
        // Without light the interval is empty, and no paths are needed.
        if growth_root.is_nan() { 1.0 } else { growth_root * growth_root }
    }
}

/// Widest of Student's intervals of means that share the error probability evenly.
fn student_half_width(moments: &[Moments], confidence: f64) -> f64 {
    let delta = (1.0 - confidence) / moments.len() as f64;
    let of = |m: &Moments| student_t_two_sided(1.0 - delta, (m.count() - 1) as f64) * m.standard_error();
    moments.iter().map(of).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::rng::{Purpose, Stream};

    fn options(error: f64) -> ControlOptions {
        ControlOptions { error, ..ControlOptions::default() }
    }

    fn interval(by_variance: f64, by_rare: f64) -> Interval {
        Interval { by_variance, by_rare }
    }

    #[test]
    fn growth_is_what_brings_the_interval_there() {
        for found in [interval(3.0, 0.0), interval(0.0, 3.0), interval(2.0, 1.0)] {
            let growth = found.growth(0.5);
            let after = found.by_variance / growth.sqrt() + found.by_rare / growth;
            assert!((after - 0.5).abs() < 1e-9, "{found:?}: {growth} brings it to {after}");
        }
        assert_eq!(interval(0.0, 0.0).growth(0.0), 1.0);
    }

    /// Claim, half-width, reason, mean and number of paths at the end of a pixel whose paths have
    /// the values of `sample`.
    fn ended(
        stop: PathStop,
        nearby: &[Moments],
        sample: &mut dyn FnMut() -> f64,
    ) -> (Claim, f64, Stop, f64, u64) {
        let (mut looking, mut wanted) = Looking::new(stop, nearby);
        let mut moments = [Moments::default()];
        loop {
            while moments[0].count() < u64::from(wanted) {
                moments[0].push(sample());
            }
            let mut mean = RgbSum::default();
            mean.add(Rgb::gray(moments[0].mean() as f32));
            match looking.look(&moments, &mean, Scattering::Met) {
                Next::Follow(more) => {
                    assert!(u64::from(more) > moments[0].count());
                    wanted = more;
                }
                Next::End { claim, half_width, stop } => {
                    return (claim, half_width, stop, moments[0].mean(), moments[0].count());
                }
            }
        }
    }

    /// One path of the first batch is NaN or infinite. Every rule stops after this batch, without a
    /// claim.
    #[test]
    fn a_mean_that_is_not_finite_ends_at_once() {
        let (options, most) = (options(0.1), 1 << 20);
        for stop in
            [PathStop::Count(9), PathStop::until(options, most), PathStop::Calibrated { options, most }]
        {
            for value in [f64::NAN, f64::INFINITY] {
                let (mut looking, first) = Looking::new(stop, &[]);
                let mut moments = Moments::default();
                (0..first).for_each(|k| moments.push(if k == 3 { value } else { 1.0 }));
                let mut mean = RgbSum::default();
                mean.add(Rgb::gray(value as f32));
                let Next::End { claim, half_width, stop } = looking.look(&[moments], &mean, Scattering::Met)
                else {
                    panic!("{value} is looked at again");
                };
                assert!(claim == Claim::None && half_width.is_nan() && stop == Stop::NotFinite);
            }
        }
    }

    /// One path in 200 carries half of the light; 1024 paths of the neighbourhood are given. Our
    /// interval covers the mean in at least 95 % of 400 pixels, Student's in less than 90 %, since
    /// it often stops before a bright path.
    #[test]
    fn light_that_is_met_rarely_is_reckoned_with() {
        let holds = |of: &dyn Fn(ControlOptions) -> PathStop| {
            let held = (0..400).filter(|trial| {
                let mut stream = Stream::new(*trial, Purpose::CameraPath, 0);
                let mut sample = || 0.5 + if stream.uniform() < 0.005 { 100.0 } else { 0.0 };
                let mut nearby = Moments::default();
                (0..1024).for_each(|_| nearby.push(sample()));
                let (claim, half_width, stop, mean, _) = ended(of(options(0.2)), &[nearby], &mut sample);
                assert_eq!(stop, Stop::RuleMet);
                assert_ne!(claim, Claim::None);
                (mean - 1.0).abs() <= half_width
            });
            held.count()
        };
        let ours = holds(&|options| PathStop::Calibrated { options, most: 1 << 20 });
        let student = holds(&|options| PathStop::until(options, 1 << 20));
        assert!(ours >= 380, "{ours} of 400 hold");
        assert!(student < 360, "{student} of 400 hold: the test would not tell them apart");
    }

    /// A pixel that runs out of paths states its interval by our own rule, even after few paths.
    #[test]
    fn a_pixel_out_of_budget_states_its_interval() {
        for most in [16, 1000] {
            let stop = PathStop::Calibrated { options: options(0.001), most };
            let mut stream = Stream::new(1, Purpose::CameraPath, 0);
            let (claim, half_width, stop, mean, paths) = ended(stop, &[], &mut || stream.uniform().into());
            assert_eq!((claim, stop, paths), (Claim::Calibrated, Stop::Budget, most.into()));
            assert!(half_width > 0.001 * mean && (mean - 0.5).abs() < half_width, "{mean} ± {half_width}");
        }
    }

    /// In an empty pixel all paths are black. If a surface of luminance 2 may be there, the
    /// interval at 95 % allows for it on the share of the pixel that `n` paths miss with a
    /// probability of 5 %.
    #[test]
    fn surfaces_that_no_path_met_are_reckoned_with() {
        let mut moments = Moments::default();
        (0..300).for_each(|_| moments.push(0.0));
        let half_width = |unmet: f64| Interval::of(&[moments], &[], unmet, 0.05).half_width();
        assert_eq!(half_width(0.0), 0.0);
        assert!((half_width(2.0) / 2.0 - 0.009_986).abs() < 1e-6, "{}", half_width(2.0));
        let options = ControlOptions { absolute_error: 1e-3, ..options(1e-3) };
        let stop = PathStop::Calibrated { options, most: 1 << 20 };
        let second = |scattering| {
            let (mut looking, _) = Looking::new(stop, &[]);
            looking.look(&[moments], &RgbSum::default(), scattering);
            looking.look(&[moments], &RgbSum::default(), scattering)
        };
        assert!(matches!(second(Scattering::Unmet(0.0)), Next::End { half_width: 0.0, .. }));
        assert!(matches!(second(Scattering::Unmet(2.0)), Next::Follow(_)));
    }

    /// A mean of small variance needs few paths. The predicted analyses end it before 128 paths.
    #[test]
    fn few_paths_do_where_little_varies() {
        let mut stream = Stream::new(2, Purpose::CameraPath, 0);
        let stop = PathStop::Calibrated { options: options(0.02), most: 1 << 20 };
        let mut sample = || 1.0 + 0.1 * f64::from(stream.uniform());
        let (_, half_width, _, _, paths) = ended(stop, &[], &mut sample);
        assert!(half_width > 0.0 && paths < 128, "{paths}");
    }
}
