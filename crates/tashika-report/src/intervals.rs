//! Comparison of the intervals of two films, which tests claims without any reference.
//!
//! At a pixel that both films [claim](super::Claims), their intervals are `a ± h_a` and `b ± h_b`
//! (W·m⁻²·sr⁻¹), of the luminance, or of each channel if channels were controlled. If both films
//! estimate one truth `T`, both intervals hold only if `|a − T| ≤ h_a` and `|b − T| ≤ h_b`, hence
//! `|a − b| ≤ h_a + h_b`. The intervals are disjoint, and at least one of them is wrong, if
//!
//! ```text
//! |a − b| > h_a + h_b + 2⁻²³ (|b| + |a − b|)        channels: of any of the three; |b| and |a − b| the largest of them
//! ```
//!
//! where the last term bounds the rounding of the four numbers to single precision. The rounding
//! is at most `2⁻²⁴ (|a| + |b| + h_a + h_b)`, where `|a| ≤ |b| + |a − b|`, and
//! `h_a + h_b ≤ |a − b|`, because otherwise the intervals are not disjoint. An exact pixel has the
//! half-width 0.
//!
//! # Expected number
//! If each interval holds with probability `c` and the errors of the films are independent, both
//! hold with probability `c²`. So at most a share `1 − c²` of the pairs is disjoint: 9.75 % at
//! 95 %. Most shares are far smaller. Normal errors of standard deviations `σ_a` and `σ_b` have
//! half-widths `z σ_a` and `z σ_b`, where `P(|Z| ≤ z) = c`. The difference is normal too, of
//! variance `σ_a² + σ_b²`, and so
//!
//! ```text
//! P(disjoint) = P(|Z| > z (σ_a + σ_b) / √(σ_a² + σ_b²))
//!             = P(|Z₁ − Z₂|/√2 > √2 z)  if σ_a = σ_b:  0.56 % at 95 %, with z = 1.96
//!             = 1 − c                   if one of them is 0, as it is where a film is exact
//! ```
//!
//! and between the last two otherwise. A share far above this probability shows claims that do not
//! hold. A share below it proves nothing: the intervals of two films with equal errors overlap.
//!
//! # Guarantee
//! For colours that are not negative: if both intervals held before they were rounded to single
//! precision, they are never counted as disjoint.
//!
//! # Assumption
//! Both films estimate one truth. So nothing is reported if their metadata name different truths or
//! different error metrics. Films of two seeds have one truth if it is light transport; sums over
//! VPLs and gather points differ by seed. The longest path is taken to be equal. The interval of
//! the share takes pixels for independent trials, and the expected number takes the errors of the
//! two films for independent. If films share VPLs, or all of their random numbers, fewer intervals
//! are disjoint.
//!
//! # Held to this by
//! The tests below, on films whose intervals are known, and on normal errors.

use super::claims::{Claims, rounding};
use super::truths::Truths;
use crate::film::{Film, RenderFilm};
use crate::stats::{Interval, clopper_pearson};

/// Number of pixels at which the intervals of two films about one truth are disjoint. Values `a`
/// and `b` with half-widths `h_a` and `h_b` have disjoint intervals if `|a − b|` exceeds
/// `h_a + h_b` by more than a rounding bound. At least one of two disjoint intervals is wrong,
/// whatever the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    /// Pixels that are finite and claimed in both films; at least one.
    pub claimed_in_both: u64,
    /// Pixels among them whose two intervals have no number in common.
    pub disjoint: u64,
    /// Clopper–Pearson interval of the share that is disjoint, at [`Intervals::CONFIDENCE`].
    pub interval: Interval,
}

impl Intervals {
    /// Confidence of the interval of the share.
    pub const CONFIDENCE: f64 = Claims::CONFIDENCE;

    /// Share of disjoint intervals among the pixels that both films claim.
    pub fn share(&self) -> f64 {
        self.disjoint as f64 / self.claimed_in_both as f64
    }
}

/// Counter of pairs of intervals that have no value in common.
pub(super) struct DisjointCounter<'f> {
    films: [RenderFilm<'f>; 2],
    claimed_in_both: u64,
    disjoint: u64,
}

impl<'f> DisjointCounter<'f> {
    /// Counter for two films; `None` unless both have half-widths, in one error metric and about
    /// one truth.
    pub(super) fn of(image: &'f Film, reference: &'f Film) -> Option<Self> {
        let films = [image, reference].map(RenderFilm::of);
        let [a, b] = &films;
        let can_meet = a.has_half_widths()
            && b.has_half_widths()
            && Truths::of(image, reference) == Truths::Same
            && a.controlled() == b.controlled();
        can_meet.then_some(Self { films, claimed_in_both: 0, disjoint: 0 })
    }

    /// Counts a pixel, given the distance of the films and the size of the reference.
    pub(super) fn take(&mut self, pixel: usize, distance: f64, size: f64) {
        let [Some(h_a), Some(h_b)] = self.films.map(|film| film.half_width(pixel).map(f64::from)) else {
            return;
        };
        self.claimed_in_both += 1;
        let allowed = h_a + h_b + rounding(distance, size);
        // A half-width that is not a number contains no value.
        let may_both_hold = distance <= allowed;
        self.disjoint += u64::from(!may_both_hold);
    }

    /// Returns the counts; `None` if no pixel is claimed in both films.
    pub(super) fn intervals(self) -> Option<Intervals> {
        let Self { claimed_in_both, disjoint, .. } = self;
        let interval = clopper_pearson(disjoint, claimed_in_both, Intervals::CONFIDENCE);
        (claimed_in_both > 0).then_some(Intervals { claimed_in_both, disjoint, interval })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::film::{Claim, PlaneSpec, SampleKind, Window};
    use crate::rng::{Purpose, Stream};
    use crate::stats::normal_quantile;
    use crate::{Comparison, Named, Tolerance, compare, summary};

    const fn spec(name: &'static str, channels: &'static [&'static str], kind: SampleKind) -> PlaneSpec {
        PlaneSpec { name, channels, unit: "1", kind, doc: "" }
    }

    const COLOR: PlaneSpec = spec("", &["R", "G", "B"], SampleKind::F32);
    const HALF_WIDTH: PlaneSpec = spec("half_width", &["Y"], SampleKind::F32);
    const CLAIM: PlaneSpec = spec("claim", &["id"], SampleKind::U32);
    const NONE: u32 = Claim::None.id();
    const EXACT: u32 = Claim::Exact.id();
    const PUBLISHED: u32 = Claim::Published.id();
    const CALIBRATED: u32 = Claim::Calibrated.id();
    const CERTIFIED: u32 = Claim::Certified.id();

    /// A row of pixels with gray, half-width and claim.
    fn film(pixels: &[(f32, f32, u32)]) -> Film {
        let size = [pixels.len() as u32, 1];
        let mut film = Film::new(size, Window::full(size), &[COLOR, HALF_WIDTH, CLAIM]).unwrap();
        for (x, &(gray, half_width, claim)) in (0..).zip(pixels) {
            film.plane_mut("").unwrap().set_f32(x, 0, &[gray; 3]);
            film.plane_mut("half_width").unwrap().set_f32(x, 0, &[half_width]);
            film.plane_mut("claim").unwrap().set_u32(x, 0, &[claim]);
        }
        film.metadata_mut().set("truth", "transport");
        film
    }

    fn compared(image: &Film, reference: &Film) -> Comparison {
        let named = |name, film| Named { name: Path::new(name), film };
        compare(named("a.exr", image), named("b.exr", reference), &Tolerance::default()).unwrap()
    }

    /// Returns the numbers of pixels claimed in both and of disjoint ones; asserts that films can
    /// be swapped.
    #[track_caller]
    fn found(a: &Film, b: &Film) -> Option<(u64, u64)> {
        let counts = |a, b| compared(a, b).intervals.map(|found| (found.claimed_in_both, found.disjoint));
        assert_eq!(counts(a, b), counts(b, a), "one film is as good as the other");
        counts(a, b)
    }

    #[test]
    fn intervals_without_a_common_number_are_disjoint() {
        let one = |gray: f32, half_width: f32, claim: u32| film(&[(gray, half_width, claim)]);
        let cases = [
            ("overlapping", one(1.0, 0.25, CALIBRATED), one(1.375, 0.25, CALIBRATED), Some((1, 0))),
            ("disjoint", one(1.0, 0.25, CALIBRATED), one(1.625, 0.25, CERTIFIED), Some((1, 1))),
            ("one inside the other", one(1.0, 5.0, PUBLISHED), one(1.5, 0.25, CALIBRATED), Some((1, 0))),
            (
                "wide enough only together",
                one(1.0, 0.5, CALIBRATED),
                one(1.625, 0.25, PUBLISHED),
                Some((1, 0)),
            ),
            ("exact inside", one(1.25, 0.0, EXACT), one(1.0, 0.5, CALIBRATED), Some((1, 0))),
            ("exact outside", one(1.75, 0.0, EXACT), one(1.0, 0.5, CALIBRATED), Some((1, 1))),
            ("both exact, and the same", one(1.75, 0.0, EXACT), one(1.75, 0.0, EXACT), Some((1, 0))),
            ("both exact", one(1.75, 0.0, EXACT), one(1.5, 0.0, EXACT), Some((1, 1))),
            ("no claim in one", one(1.0, 0.0, NONE), one(9.0, 0.25, CALIBRATED), None),
            ("no claim in any", one(1.0, 0.0, NONE), one(9.0, 0.0, NONE), None),
            ("no limit", one(1.0, f32::INFINITY, CALIBRATED), one(9.0, 0.25, CALIBRATED), Some((1, 0))),
        ];
        for (case, a, b, expected) in cases {
            assert_eq!(found(&a, &b), expected, "{case}");
        }
    }

    #[test]
    fn intervals_that_touch_are_not_disjoint_however_they_were_stored() {
        let touching = |centre: f64, h_a: f64, h_b: f64| {
            let (a, b) = (film(&[(centre as f32, h_a as f32, CALIBRATED)]), (centre + h_a + h_b) as f32);
            (a, film(&[(b, h_b as f32, CALIBRATED)]))
        };
        let (a, b) = touching(1.0, 0.25, 0.5);
        assert_eq!(found(&a, &b), Some((1, 0)), "without any rounding");
        let (mut outside, mut s) = (0, Stream::new(5, Purpose::Test, 1));
        for _ in 0..300 {
            let (centre, h_a, h_b) = (s.uniform_f64(), 0.3 * s.uniform_f64(), 0.3 * s.uniform_f64());
            let (a, b) = touching(centre, h_a, h_b);
            assert_eq!(found(&a, &b), Some((1, 0)), "{centre} {h_a} {h_b}");
            let stored = |film: &Film, name| f64::from(film.plane(name).unwrap().f32_samples().unwrap()[0]);
            let distance = stored(&b, "") - stored(&a, "");
            outside += u32::from(distance > stored(&a, "half_width") + stored(&b, "half_width"));
            // Four times the allowed distance is detected: 2⁻²¹ of at most (centre + 2 · 0.6).
            let apart = f64::from(f32::EPSILON) * 4.0 * (centre + 2.0 * (h_a + h_b));
            let (_, b) = touching(centre + apart, h_a, h_b);
            assert_eq!(found(&a, &b), Some((1, 1)), "{centre} {h_a} {h_b}");
        }
        assert!(outside > 50, "{outside}: storing them moves many apart");
    }

    #[test]
    fn pixels_are_counted_where_both_films_claim_and_have_an_error() {
        let a = film(&[
            (1.0, 0.1, CALIBRATED),
            (1.0, 0.1, CALIBRATED),
            (1.0, 0.1, CALIBRATED),
            (f32::INFINITY, 0.1, CALIBRATED),
            (1.0, 0.1, CALIBRATED),
            (1.0, 0.0, EXACT),
        ]);
        let b = film(&[
            (1.1, 0.1, CALIBRATED),
            (2.0, 0.1, CALIBRATED),
            (2.0, 0.0, NONE),
            (1.0, 0.1, CALIBRATED),
            (2.0, 0.1, CERTIFIED),
            (1.0, 0.1, PUBLISHED),
        ]);
        let c = compared(&a, &b);
        let intervals = c.intervals.clone().unwrap();
        assert_eq!((intervals.claimed_in_both, intervals.disjoint, intervals.share()), (4, 2, 0.5));
        // Exact limits of 2 of 4, from published tables.
        let Interval { low, high } = intervals.interval;
        assert!((low - 0.0676).abs() < 5e-5 && (high - 0.9324).abs() < 5e-5, "{low} {high}");
        let row = |c: &Comparison| summary(c).into_iter().find(|(label, _)| *label == "intervals");
        assert_eq!(
            row(&c).unwrap().1,
            "2 of 4 that both films claim are disjoint: 50.0 % (6.76 % to 93.2 % at 95 %)"
        );
        // A reference that claims nothing, and one without half-widths.
        let silent = film(&[(1.0, 0.0, NONE); 6]);
        let plain = Film::new([6, 1], Window::full([6, 1]), &[COLOR]).unwrap();
        for reference in [silent, plain] {
            assert_eq!(found(&a, &reference), None);
            assert!(row(&compared(&a, &reference)).is_none());
        }
    }

    #[test]
    fn films_of_different_truths_are_not_held_against_each_other() {
        let (a, b) = (film(&[(1.0, 0.1, CALIBRATED)]), film(&[(2.0, 0.1, CALIBRATED)]));
        let with = |film: &Film, facts: &[(&str, &str)]| {
            let mut film = film.clone();
            for (name, value) in facts {
                film.metadata_mut().set(name, *value);
            }
            film
        };
        assert_eq!(found(&a, &with(&b, &[("method", "path"), ("seed", "2")])), Some((1, 1)), "another seed");
        for facts in [("truth", "clamped"), ("scene", "room"), ("camera", "top"), ("control", "channels")] {
            assert_eq!(found(&a, &with(&b, &[facts])), None, "{facts:?}");
            assert_eq!(found(&with(&a, &[facts]), &with(&b, &[facts])), Some((1, 1)), "{facts:?}");
        }
        assert_eq!(found(&a, &with(&b, &[("control", "luminance")])), Some((1, 1)), "as if it said nothing");
        // Sums over VPLs are equal only for equal VPLs and gather points.
        let [a, b] = [a, b].map(|film| with(&film, &[("truth", "vpl"), ("seed", "1"), ("vpls.seed", "1")]));
        assert_eq!(found(&a, &b), Some((1, 1)));
        for name in ["seed", "vpls.seed", "gather.points"] {
            assert_eq!(found(&a, &with(&b, &[(name, "2")])), None, "{name}");
        }
    }

    #[test]
    fn any_channel_may_be_disjoint_where_channels_are_controlled() {
        let [mut a, mut b] = [film(&[(1.0, 0.1, CALIBRATED)]), film(&[(1.0, 0.1, CALIBRATED)])];
        // 0.25 of blue is 0.018 of luminance.
        b.plane_mut("").unwrap().set_f32(0, 0, &[1.0, 1.0, 1.25]);
        assert_eq!(found(&a, &b), Some((1, 0)));
        for film in [&mut a, &mut b] {
            film.metadata_mut().set("control", "channels");
        }
        assert_eq!(found(&a, &b), Some((1, 1)));
    }

    /// Share of disjoint intervals among 40,000 pairs. Their errors are normal, their half-widths
    /// are `widths` standard deviations.
    fn share_of_normal(sigma_a: f64, sigma_b: f64, widths: f64) -> f64 {
        let row = |sigma: f64, key: u64| {
            let mut s = Stream::new(3, Purpose::Test, key);
            let mut pixel = || {
                let error = sigma * normal_quantile(s.uniform_f64().max(f64::MIN_POSITIVE));
                ((10.0 + error) as f32, (widths * sigma) as f32, if sigma > 0.0 { CALIBRATED } else { EXACT })
            };
            film(&(0..40_000).map(|_| pixel()).collect::<Vec<_>>())
        };
        compared(&row(sigma_a, 1), &row(sigma_b, 2)).intervals.unwrap().share()
    }

    #[test]
    fn disjoint_intervals_are_as_rare_as_true_claims_have_them() {
        let z = normal_quantile(0.975);
        // P(|Z| > x) for x = √2 z, 1.4/√1.16 z and z, and for √2 z/2 if half-widths are half of the
        // correct ones.
        for (sigma_a, sigma_b, widths, expected) in [
            (1.0, 1.0, z, 0.005_575),
            (1.0, 0.4, z, 0.010_844),
            (1.0, 0.0, z, 0.05),
            (1.0, 1.0, 0.5 * z, 0.165_776),
        ] {
            let found = share_of_normal(sigma_a, sigma_b, widths);
            let standard_error = (expected * (1.0 - expected) / 40_000.0_f64).sqrt();
            let case = (sigma_a, sigma_b, widths);
            assert!((found - expected).abs() < 5.0 * standard_error, "{case:?}: {found}, not {expected}");
        }
    }
}
