//! A pixel from its first analysis to its last: estimates that grow, and restarts where growth is
//! not enough.

use super::super::looks::Looks;
use super::super::{Claim, HalfWidths, LuminanceParts, PixelRecord, Setting, Stop};
use super::estimate::{Common, Estimate, Estimator, MIN_EMISSION_HITS, MIN_PROJECTED_SHARE, Points};
use super::interval::{Finding, Source};
use super::nearby::MIN_SAMPLED_SHARE;
use super::{CLAMPS, LightTransport, LightTransportView, Visibility};
use crate::cut::CutMemory;
use crate::gather::{Features, GatherPoint, PixelSum};
use crate::rng::{self, Purpose};
use crate::stats::Moments;

/// Pairs and paths at the first analysis.
const FIRST: [f64; 2] = [64.0, 32.0];
/// Least growth between analyses, as a factor.
const LEAST_GROWTH: f64 = 1.1;
/// Most growth of pairs and paths between analyses.
const MOST_GROWTH: [f64; 2] = [2.0, 4.0];
/// Work of a pair, with its samples, bounds and lists, in rays of a path. Chosen.
const RAYS_PER_PAIR: f64 = 4.0;
/// Factor by which the number of camera samples grows where they limit a pixel.
const MORE_SAMPLES: u32 = 8;
/// Most camera samples of a sum over VPLs.
const MOST_SAMPLES: u32 = 8192;
/// Share of the tolerance. If a source of error that does not fall as the estimate grows exceeds
/// this share, the pixel is restarted to reduce that source.
const ENOUGH: f64 = 0.7;
/// Share of the tolerance. If such sources together exceed this share, the sum over VPLs ends:
/// meeting the rest of the tolerance would take a very large number of pairs and paths.
const GIVE_UP_THRESHOLD: f64 = 0.87;
/// Share of the tolerance. A restart reduces every such source that exceeds this share.
const JOINT_RESTART_THRESHOLD: f64 = 0.4;
/// Share of the permitted work after which a pixel is not restarted: the remaining work would not
/// reach the same precision.
const MAX_RESTART_WORK_SHARE: f64 = 0.25;
/// Share of the tolerance that unsampled light may have.
const MAX_UNSAMPLED_SHARE: f64 = 0.25;
/// Camera samples for features where there are only paths.
const SAMPLES_OF_FEATURES: u32 = 16;

/// A pixel in progress, over all of its restarts.
pub(super) struct Pixel<'a, 'v> {
    of_view: &'a LightTransportView<'a>,
    method: &'a LightTransport<'a>,
    common: Common<'a>,
    visibility: &'a Visibility<'v>,
    at: [u32; 2],
    key: u64,
    /// Result of the last analysis.
    finding: Option<Finding>,
    /// True if the last analysis met the tolerance and may claim its interval.
    is_met: bool,
    /// True if the last analysis was planned before its samples were drawn, so that its interval
    /// may be stated however wide it is.
    may_claim: bool,
    features: Features,
    /// True if the pixel sees a lamp so small that most camera samples and most paths miss it.
    sees_small_lamp: bool,
    /// Approximate luminance of unsampled light.
    importance_not_found: f64,
    /// True if a camera sample met a surface or a medium that scatters light.
    may_be_lit: bool,
    /// Approximate lower bound on the luminance from light paths, where paths from the camera found
    /// much less.
    by_light_paths: f64,
    /// Analyses of all restarts together.
    looks: Looks,
    /// Pairs and paths of estimates that have ended.
    given_up: u64,
    pairs: u64,
    rays: u64,
    /// True if the full paths of the neighbourhood are counted in `rays`.
    knows_whole: bool,
    /// Approximate luminance of surfaces that may be in the pixel though no camera sample met one.
    importance_unmet: Option<f64>,
}

/// The next larger number of camera samples.
fn more(samples: u32) -> u32 {
    (samples * MORE_SAMPLES).clamp(MORE_SAMPLES, MOST_SAMPLES)
}

/// Reason for which work on an estimate ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ended {
    Met,
    OutOfBudget,
    /// A source of error does not fall as the estimate grows. The flags, for lights and for points,
    /// are true if the pixel is to be restarted with better ones.
    Limited([bool; 2]),
}

impl<'a, 'v> Pixel<'a, 'v> {
    pub(super) fn new(
        of_view: &'a LightTransportView<'a>,
        common: Common<'a>,
        visibility: &'a Visibility<'v>,
        at: [u32; 2],
    ) -> Self {
        let number = u64::from(at[1]) << 32 | u64::from(at[0]);
        let method = of_view.method;
        Self {
            of_view,
            method,
            common,
            visibility,
            at,
            key: rng::key(method.options.seed, Purpose::Replicate, number),
            finding: None,
            is_met: false,
            may_claim: false,
            features: Features::default(),
            sees_small_lamp: false,
            importance_not_found: 0.0,
            may_be_lit: false,
            by_light_paths: 0.0,
            looks: Looks::new(&method.options),
            given_up: 0,
            pairs: 0,
            rays: 0,
            knows_whole: false,
            importance_unmet: None,
        }
    }

    /// Estimates the pixel until the tolerance is met or no further work is predicted to help.
    pub(super) fn estimate(mut self, memory: &mut CutMemory) -> PixelRecord {
        let only = self.method.only.filter(|_| self.common.compensates);
        let begins_with_paths = only.map_or_else(|| self.are_vpls_in_vain(), |only| only == Estimator::Paths);
        let is_met_by_vpls = !begins_with_paths && self.by_vpls(memory);
        let may_follow_paths =
            self.common.compensates && only != Some(Estimator::Vpls) && !self.sees_small_lamp;
        if !is_met_by_vpls && may_follow_paths && (only.is_some() || self.are_full_paths_sufficient()) {
            self.by_paths();
        }
        self.stated()
    }

    /// Estimates by sums over VPLs. Returns true if full paths need not be tried.
    fn by_vpls(&mut self, memory: &mut CutMemory) -> bool {
        let mut samples = self.samples_for_emission(self.common.setting.view.gather.points);
        if self.misses_surfaces(samples) {
            samples = MOST_SAMPLES;
        }
        let is_emission_rare = self.is_emission_rare(samples);
        let (mut clamp, mut caustics) = (0, 0.0);
        let visibility = self.visibility.get();
        self.rays += visibility.segments_per_pixel;
        for attempt in 0.. {
            // Each attempt has its own random numbers: its estimate is independent of the earlier
            // ones.
            let key = rng::key(self.key, Purpose::Replicate, attempt);
            let (method, common) = (self.method, self.common);
            let points = Points::new(&common, self.at, samples, is_emission_rare, key);
            self.features = points.pixel.features;
            let nearby = common.compensates.then(|| self.of_view.nearby(&common, self.at, clamp));
            if attempt == 0 {
                caustics = nearby.map_or(0.0, |nearby| points.not_found(&common, nearby));
                self.rays += nearby.map_or(0, |nearby| nearby.rays_per_pixel(Estimator::Vpls));
            }
            self.importance_not_found = caustics + common.unsampled_emission(self.at, &points.pixel);
            self.look_at(&points.pixel);
            let moments = nearby.map(|nearby| nearby.compensation(points.are_narrow()));
            let (prior, clamp_distance) = (visibility.prior(), method.clamp_distance(clamp));
            let estimate = Estimate::of_vpls(common, prior, &points, clamp_distance, self.at, key, memory);
            let can_mend = [common.compensates && clamp + 1 < CLAMPS, samples < MOST_SAMPLES];
            match self.refine(estimate, moments.unwrap_or_default(), can_mend) {
                Ended::Met | Ended::OutOfBudget => return true,
                Ended::Limited([false, false]) => return false,
                Ended::Limited([lights, points]) => {
                    clamp += usize::from(lights);
                    samples = if points { more(samples) } else { samples };
                }
            }
        }
        false
    }

    /// Number of camera samples that are likely to meet the lamps and the sky that the pixel sees,
    /// at least `few`. Separate samples decide, since a decision by the samples of the estimate
    /// would bias it.
    fn samples_for_emission(&mut self, few: u32) -> u32 {
        let mut samples = few;
        while samples < MOST_SAMPLES && self.misses_emission(samples) {
            self.sees_small_lamp = true;
            samples = more(samples);
        }
        if self.sees_small_lamp { more(samples) } else { few }
    }

    /// Returns true if `samples` camera samples, drawn only for this test, miss a lamp, or meet a
    /// bright part of the sky by chance at most.
    fn misses_emission(&mut self, samples: u32) -> bool {
        if !self.common.sees_lamps(self.at) && !self.may_see_sky() {
            return false;
        }
        let seen = self.try_samples(samples);
        self.common.unsampled_emission(self.at, &seen) > 0.0 || self.common.is_sky_rare(&seen)
    }

    /// Returns true if the pixel may see a sky whose radiance varies.
    fn may_see_sky(&self) -> bool {
        let common = self.common;
        let sees_emission = || self.of_view.nearby(&common, self.at, 0).sees_emission();
        common.compensates && common.lights.sky().is_some() && sees_emission()
    }

    /// Returns true if a surface may be in the pixel, and `samples` camera samples, drawn only for
    /// this test, all miss it.
    fn misses_surfaces(&mut self, samples: u32) -> bool {
        let common = self.common;
        let may_be = common.compensates && self.of_view.nearby(&common, self.at, 0).has_missed_samples();
        may_be && self.try_samples(samples).points.is_empty() && self.importance_unmet() > 0.0
    }

    /// Returns true if `samples` camera samples are likely to miss emission that the camera sees.
    /// The image of a window in a reflective rim, for example, fills a thousandth of the pixel.
    fn is_emission_rare(&mut self, samples: u32) -> bool {
        let common = self.common;
        if !common.compensates {
            return false;
        }
        // Through a scattering medium, it is chance whether a sample meets emission.
        if common.setting.tracer.scene().scatters() {
            return true;
        }
        if common.sees_lamps(self.at) {
            return false;
        }
        // Where no neighbour has met emission there is hardly any.
        if !self.of_view.nearby(&common, self.at, 0).sees_emission() {
            return true;
        }
        let seen = self.try_samples(samples);
        seen.samples.iter().filter(|sample| !sample.background.is_black()).count() < MIN_EMISSION_HITS
    }

    /// Draws camera samples to plan the estimate. Planning by the samples of the estimate would
    /// bias it.
    fn try_samples(&mut self, samples: u32) -> PixelSum {
        self.rays += u64::from(samples);
        self.common.samples(self.at, samples, rng::key(self.key, Purpose::Guidance, samples.into()))
    }

    /// Estimates the pixel by full paths.
    fn by_paths(&mut self) {
        let key = rng::key(self.key, Purpose::CameraPath, 0);
        if self.finding.is_none() {
            let seen = self.common.samples(self.at, SAMPLES_OF_FEATURES, key);
            self.features = seen.features;
            self.look_at(&seen);
        }
        let common = self.common;
        let moments = self.nearby_whole();
        self.refine(Estimate::of_paths(common, self.at, key), moments, [false; 2]);
    }

    /// Returns true if paths of the neighbourhood show that VPLs would be of no use or are not
    /// needed. If light may be unsampled in the pixel, VPLs are used, since only their estimate
    /// states the amount of unsampled light.
    fn are_vpls_in_vain(&mut self) -> bool {
        let common = self.common;
        if !common.compensates || common.sees_lamps(self.at) {
            return false;
        }
        let nearby = self.of_view.nearby(&common, self.at, 0);
        if nearby.not_found().is_some() || self.misses_emission(common.setting.view.gather.points) {
            return false;
        }
        self.nearby_whole();
        let are_in_vain = nearby.are_vpls_in_vain(&common)
            || (nearby.are_full_paths_cheaper(&common) && !self.is_background());
        if are_in_vain {
            // If VPLs are used, `by_vpls` counts these rays.
            self.rays += nearby.rays_per_pixel(Estimator::Vpls);
        }
        are_in_vain
    }

    /// Returns true if the pixel is likely to see no surface. The pixel is then the mean of its
    /// camera samples, and exact if these have one colour.
    fn is_background(&mut self) -> bool {
        let sees_emission = self.of_view.nearby(&self.common, self.at, 0).sees_emission();
        sees_emission && self.try_samples(SAMPLES_OF_FEATURES).points.is_empty()
    }

    /// Approximate luminance of surfaces that may be in the pixel. Zero where no ray of the pixel
    /// can meet a surface, and where VPLs alone are the truth.
    fn importance_unmet(&mut self) -> f64 {
        if let Some(known) = self.importance_unmet {
            return known;
        }
        let Setting { tracer, view } = *self.common.setting;
        let is_empty = view.pyramid(self.at).is_some_and(|pyramid| tracer.is_empty_within(&pyramid));
        let luminance = if is_empty || !self.common.compensates {
            0.0
        } else {
            self.nearby_whole();
            let nearby = self.of_view.nearby(&self.common, self.at, 0);
            let of_view = self.common.lights.importance_brightness();
            nearby.importance_brightness(&self.common).max(of_view)
        };
        self.importance_unmet = Some(luminance);
        luminance
    }

    /// Determines from camera samples whether the pixel may be lit. Where paths of the
    /// neighbourhood found much less light than light paths did, also sets the lower bound on the
    /// luminance from light paths.
    fn look_at(&mut self, seen: &PixelSum) {
        if !self.common.compensates {
            return;
        }
        let reflects = |p: &GatherPoint| p.phase.is_some() || !p.bsdf.albedo().is_black();
        self.may_be_lit = self.common.lights.count() > 0 && seen.points.iter().any(reflects);
        self.nearby_whole();
        let nearby = self.of_view.nearby(&self.common, self.at, 0);
        let is_unmet = nearby.is_light_undersampled(&self.common);
        self.by_light_paths = if is_unmet { self.common.by_light_paths(seen) } else { 0.0 };
    }

    /// Approximate luminance that the estimate lacks: of caustics, of lamps, and of light that
    /// light paths find around the pixel or project onto it.
    fn importance_missing(&self, found: &Finding) -> f64 {
        let most = f64::from(found.mean.total().luminance()) + found.half_width;
        let lacks = |share: f64, there: f64| if most < share * there { there - most } else { 0.0 };
        let seen = self.common.lights.seen_caustics().filter(|_| self.common.compensates);
        let seen = seen.map_or(0.0, |caustics| caustics.importance_least(self.at));
        self.importance_not_found
            + lacks(MIN_SAMPLED_SHARE, self.by_light_paths).max(lacks(MIN_PROJECTED_SHARE, seen))
    }

    /// Moments of full paths in the neighbourhood; counts their rays at the first call.
    fn nearby_whole(&mut self) -> &'a [Moments] {
        let common = self.common;
        let nearby = self.of_view.nearby(&common, self.at, 0);
        let whole = nearby.whole(&common);
        if !self.knows_whole {
            self.knows_whole = true;
            self.rays += nearby.rays_per_pixel(Estimator::Paths);
        }
        whole
    }

    /// Returns true if full paths are likely to meet the tolerance within the remaining work. If
    /// the pixel is darker than its neighbours, their variance is scaled by the squared ratio.
    fn are_full_paths_sufficient(&mut self) -> bool {
        let Some(found) = self.finding else { return true };
        let Some(theirs) = self.nearby_whole().first().filter(|theirs| theirs.mean() > 0.0) else {
            return true;
        };
        let darker = (found.mean.total().luminance() as f64 / theirs.mean()).clamp(0.0, 1.0);
        theirs.variance() * darker * darker <= found.tolerated_variance() * self.left() as f64
    }

    /// Permitted pairs and paths that are left.
    fn left(&self) -> u64 {
        self.method.most_work().saturating_sub(self.given_up)
    }

    /// Grows an estimate until its interval is narrow enough, or until growth cannot make it so.
    ///
    /// * `nearby`: moments of paths of the neighbourhood, by part of the error metric.
    /// * `can_mend`: flags for lights and for points; true if a restart could improve them.
    fn refine(&mut self, mut estimate: Estimate<'_>, nearby: &[Moments], can_mend: [bool; 2]) -> Ended {
        let most = self.left() as f64;
        let [mut pairs, mut paths] = FIRST;
        // The first analysis only plans the next, unless the budget is used up by then.
        let mut is_planned = pairs + paths >= most;
        let ended = loop {
            estimate.grow(pairs as u64, paths as u32);
            if !estimate.samples_meet_surface() {
                estimate.expect_unmet(self.importance_unmet());
            }
            let found = Finding::of(&estimate, nearby, &self.method.options, self.looks.delta());
            self.may_claim = is_planned || found.is_exact();
            self.is_met = self.may_claim && found.is_narrow_enough();
            self.finding = Some(found);
            if self.is_met {
                break Ended::Met;
            }
            if !found.mean.total().is_finite() {
                // More samples cannot make the pixel finite.
                break Ended::OutOfBudget;
            }
            // The cut may have fewer pairs than requested.
            let used = pairs + paths;
            if used >= most {
                break Ended::OutOfBudget;
            }
            let is_early = used <= MAX_RESTART_WORK_SHARE * most;
            let can_mend = can_mend.map(|can| can && is_early);
            let sources = [Source::Lights, Source::Points];
            let stands_in_the_way = [0, 1].map(|k| can_mend[k] && found.is_limited_by(sources[k], ENOUGH));
            if stands_in_the_way != [false; 2] || found.is_limited_by(Source::Both, GIVE_UP_THRESHOLD) {
                // The estimate ends because its interval is wide. This does not favour intervals
                // that are too narrow, so the interval may be stated.
                self.may_claim = true;
                // One restart reduces all sources with a considerable share of the error.
                break Ended::Limited(
                    [0, 1].map(|k| can_mend[k] && found.share_of(sources[k]) > JOINT_RESTART_THRESHOLD),
                );
            }
            let found = if is_planned {
                self.looks.next();
                Finding::of(&estimate, nearby, &self.method.options, self.looks.delta())
            } else {
                found
            };
            let of_pairs = if estimate.is_whole() { 0.0 } else { RAYS_PER_PAIR * estimate.pairs() as f64 };
            let of_paths = estimate.rays_per_path() * f64::from(estimate.paths());
            let (mut growth, is_enough) = found.growth([of_pairs, of_paths], MOST_GROWTH);
            if !is_enough && growth == [1.0; 2] {
                break Ended::Limited([false; 2]);
            }
            growth = growth.map(|growth| growth.max(LEAST_GROWTH));
            let wanted = pairs * growth[0] + paths * growth[1];
            if wanted > most {
                growth = growth.map(|growth| 1.0 + (growth - 1.0) * (most - used) / (wanted - used));
            }
            is_planned = is_enough || wanted > most;
            pairs = (pairs * growth[0]).ceil();
            paths = (paths * growth[1]).ceil();
        };
        self.given_up += estimate.pairs() + u64::from(estimate.paths());
        self.pairs += if estimate.pairs() > 0 { estimate.pairs() } else { estimate.paths().into() };
        self.rays += estimate.rays();
        ended
    }

    /// Record of the pixel.
    fn stated(&self) -> PixelRecord {
        let found = self.finding.expect("each pixel is looked at");
        // If no sample found light, the variance is zero, although light may have been missed.
        let is_nothing_found = self.may_be_lit && found.is_exact() && found.mean.total().is_black();
        let missing = self.importance_missing(&found);
        let is_found = !is_nothing_found && missing <= MAX_UNSAMPLED_SHARE * found.tolerance;
        let stop = match self.is_met {
            _ if !is_found => Stop::NotFound,
            true => Stop::RuleMet,
            false => Stop::Budget,
        };
        let claim = if is_found && self.may_claim { Claim::Calibrated } else { Claim::None };
        let [clustering, lights, compensation] = found.parts().map(|h| h as f32);
        let [vpls, paths] = found.by_estimator;
        let emission = (found.mean.total().luminance() - vpls - paths).max(0.0);
        PixelRecord {
            radiance: found.mean.total(),
            standard_error: found.standard_error() as f32,
            claim,
            half_width: claim.stated(found.half_width),
            half_widths: HalfWidths { clustering, lights, compensation },
            luminance_parts: LuminanceParts { emission, vpls, paths, missing: missing as f32 },
            stop,
            pairs: self.pairs,
            rays: self.rays,
            ..self.features.into()
        }
    }
}
