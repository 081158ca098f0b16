//! The planes of a rendered film: one table, from which the record of a pixel, the film's planes,
//! their documentation and their presentation on pages are made.
//!
//! A plane is added as a row of this table, with a [`Sample`] as the type of its samples. The code
//! that computes the value sets the field of the row's name; a field that is not set is zero.

use serde::Serialize;

use super::claim::{Claim, Code, Stop};
use crate::color::Rgb;
use crate::film::{Film, Plane, PlaneSpec, SampleKind};
use crate::math::Vec3;

/// Presentation of a plane on pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shown {
    /// As colours: radiances with exposure, shares as they are.
    Color,
    /// Each channel relative to the radiance: errors and half-widths.
    Relative,
    /// As one of these codes.
    Code(&'static [Code]),
    /// Logarithmic: counts.
    Count,
    /// By its value, on a linear scale.
    Value,
    /// As a direction, each channel from −1 to 1.
    Direction,
    /// As numbers that stand for names, with a colour for each number.
    Id,
}

/// A row of [`SCHEMA`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneRow {
    /// Name of the row, by which programs request the plane; the plane itself may have no name.
    pub key: &'static str,
    /// Name, channels, unit and meaning of the plane.
    pub spec: PlaneSpec,
    /// Name of the plane in lists for people.
    pub label: &'static str,
    /// Presentation of the plane on pages.
    pub shown: Shown,
    /// True if pages with embedded samples contain this plane.
    pub in_pages: bool,
}

/// Type that holds all samples of a plane at one pixel.
trait Sample: Sized {
    /// Storage type of the samples.
    const KIND: SampleKind;
    /// Writes the samples of a pixel.
    fn put(self, plane: &mut Plane, x: u32, y: u32);
    /// Reads the samples of a pixel; `None` if the plane holds samples of another type or number.
    fn get(plane: &Plane, x: u32, y: u32) -> Option<Self>;
}

/// Reads `N` floating-point samples.
fn floats<const N: usize>(plane: &Plane, x: u32, y: u32) -> Option<[f32; N]> {
    (plane.kind() == SampleKind::F32).then(|| plane.f32_at(x, y).try_into().ok())?
}

fn number(plane: &Plane, x: u32, y: u32) -> Option<u32> {
    let numbers = (plane.kind() == SampleKind::U32).then(|| plane.u32_at(x, y))?;
    <[u32; 1]>::try_from(numbers).ok().map(|[number]| number)
}

impl Sample for f32 {
    const KIND: SampleKind = SampleKind::F32;
    fn put(self, plane: &mut Plane, x: u32, y: u32) {
        plane.set_f32(x, y, &[self]);
    }
    fn get(plane: &Plane, x: u32, y: u32) -> Option<Self> {
        floats(plane, x, y).map(|[value]| value)
    }
}

/// A count, rounded to the 24 bits of an `f32`.
impl Sample for u64 {
    const KIND: SampleKind = SampleKind::F32;
    fn put(self, plane: &mut Plane, x: u32, y: u32) {
        plane.set_f32(x, y, &[self as f32]);
    }
    fn get(plane: &Plane, x: u32, y: u32) -> Option<Self> {
        floats(plane, x, y).map(|[value]| value as Self)
    }
}

impl Sample for Rgb {
    const KIND: SampleKind = SampleKind::F32;
    fn put(self, plane: &mut Plane, x: u32, y: u32) {
        plane.set_f32(x, y, &self.to_array());
    }
    fn get(plane: &Plane, x: u32, y: u32) -> Option<Self> {
        floats(plane, x, y).map(|[r, g, b]| Self::new(r, g, b))
    }
}

impl Sample for Vec3 {
    const KIND: SampleKind = SampleKind::F32;
    fn put(self, plane: &mut Plane, x: u32, y: u32) {
        plane.set_f32(x, y, &self.to_array());
    }
    fn get(plane: &Plane, x: u32, y: u32) -> Option<Self> {
        floats(plane, x, y).map(Self::from_array)
    }
}

impl Sample for HalfWidths {
    const KIND: SampleKind = SampleKind::F32;
    fn put(self, plane: &mut Plane, x: u32, y: u32) {
        plane.set_f32(x, y, &[self.clustering, self.lights, self.compensation]);
    }
    fn get(plane: &Plane, x: u32, y: u32) -> Option<Self> {
        floats(plane, x, y).map(|[clustering, lights, compensation]| Self {
            clustering,
            lights,
            compensation,
        })
    }
}

impl Sample for LuminanceParts {
    const KIND: SampleKind = SampleKind::F32;
    fn put(self, plane: &mut Plane, x: u32, y: u32) {
        plane.set_f32(x, y, &[self.emission, self.vpls, self.paths, self.missing]);
    }
    fn get(plane: &Plane, x: u32, y: u32) -> Option<Self> {
        floats(plane, x, y).map(|[emission, vpls, paths, missing]| Self { emission, vpls, paths, missing })
    }
}

impl Sample for Claim {
    const KIND: SampleKind = SampleKind::U32;
    fn put(self, plane: &mut Plane, x: u32, y: u32) {
        plane.set_u32(x, y, &[self.id()]);
    }
    fn get(plane: &Plane, x: u32, y: u32) -> Option<Self> {
        number(plane, x, y).map(Self::of_id)
    }
}

impl Sample for Stop {
    const KIND: SampleKind = SampleKind::U32;
    fn put(self, plane: &mut Plane, x: u32, y: u32) {
        plane.set_u32(x, y, &[self.id()]);
    }
    fn get(plane: &Plane, x: u32, y: u32) -> Option<Self> {
        number(plane, x, y).map(Self::of_id)
    }
}

/// Half-width by source of error, if known: each field is the half-width that this source alone
/// would give (W·m⁻²·sr⁻¹).
///
/// Errors of independent sources add up in squares, so the half-width of the pixel is less than the
/// sum of these parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HalfWidths {
    /// Error of drawing few terms of the sums over VPLs.
    pub clustering: f32,
    /// Error of using a finite sample of VPLs and gather points.
    pub lights: f32,
    /// Error of the few paths that estimate the light that VPLs do not carry.
    pub compensation: f32,
}

/// Luminance of a pixel by estimator, where a method has several (W·m⁻²·sr⁻¹).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LuminanceParts {
    /// Emission that the camera sees, straight or over specular surfaces, if VPLs are summed.
    pub emission: f32,
    /// Sum over VPLs, at all gather points.
    pub vpls: f32,
    /// Mean over paths: the compensation, or all light if no VPLs are summed.
    pub paths: f32,
    /// Approximate luminance that the estimate lacks, measured by light paths. It is not included
    /// in the radiance.
    pub missing: f32,
}

impl HalfWidths {
    /// Half-widths of a pixel that claims nothing.
    const UNKNOWN: Self = Self { clustering: f32::NAN, lights: f32::NAN, compensation: f32::NAN };
}

impl PixelRecord {
    fn without_half_widths(&self) -> Self {
        Self { half_width: f32::NAN, half_widths: HalfWidths::UNKNOWN, ..*self }
    }
}

macro_rules! schema {
    (
        record { $(
            $field:ident: $sample:ty => $key:ident $name:literal [$($channel:literal),+] $unit:literal,
                $shown:expr, in_pages $in_pages:literal, $label:literal, $doc:literal;
        )+ }
        beside { $(
            $other:ident $kind:ident $other_name:literal [$($other_channel:literal),+] $other_unit:literal,
                $other_shown:expr, in_pages $other_in_pages:literal, $other_label:literal, $other_doc:literal;
        )* }
    ) => {
        /// Record of a pixel in a film, or an integrator's estimate of a pixel. It has a field for
        /// each plane of the [`SCHEMA`] that a render writes.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct PixelRecord { $(
            #[doc = concat!("In ", $unit, ": ", $doc, ".")]
            pub $field: $sample,
        )+ }

        /// All planes as constants, by name.
        pub mod planes {
            use super::*;
            $(
                #[doc = $doc]
                pub const $key: PlaneSpec = PlaneSpec {
                    name: $name,
                    channels: &[$($channel),+],
                    unit: $unit,
                    kind: <$sample as Sample>::KIND,
                    doc: $doc,
                };
            )+
            $(
                #[doc = $other_doc]
                pub const $other: PlaneSpec = PlaneSpec {
                    name: $other_name,
                    channels: &[$($other_channel),+],
                    unit: $other_unit,
                    kind: SampleKind::$kind,
                    doc: $other_doc,
                };
            )*
        }

        /// All planes that this program writes or shows, in their order in a film.
        pub const SCHEMA: &[PlaneRow] = &[
            $(PlaneRow {
                key: stringify!($key),
                spec: planes::$key,
                label: $label,
                shown: $shown,
                in_pages: $in_pages,
            },)+
            $(PlaneRow {
                key: stringify!($other),
                spec: planes::$other,
                label: $other_label,
                shown: $other_shown,
                in_pages: $other_in_pages,
            },)*
        ];

        impl PixelRecord {
            /// The planes of a film that holds records, in the order that [`store`](Self::store)
            /// requires.
            pub const PLANES: &[PlaneSpec] = &[$(planes::$key),+];

            /// Applies [`Self::as_told`] and writes the result to a pixel of a film with
            /// [`Self::PLANES`]. If nothing is claimed, half-widths are stored as NaN: in a film,
            /// zero means exact.
            ///
            /// # Panics
            /// If these planes are not the film's first, or the pixel is outside.
            pub fn store(&self, film: &mut Film, x: u32, y: u32) {
                let told = self.as_told();
                let record = if told.claim.is_some() { told } else { told.without_half_widths() };
                let mut planes = film.planes_mut().iter_mut();
                $(
                    let plane = planes.next().filter(|plane| plane.name() == $name);
                    record.$field.put(plane.expect("a film of PLANES"), x, y);
                )+
            }

            /// Reads the record of a pixel from a film; a field whose plane the film lacks is zero.
            ///
            /// # Panics
            /// If the pixel is outside.
            pub(super) fn load(film: &Film, x: u32, y: u32) -> Self {
                Self { $(
                    $field: film
                        .plane(planes::$key)
                        .and_then(|plane| Sample::get(plane, x, y))
                        .unwrap_or_default(),
                )+ }
            }
        }
    };
}

schema! {
    record {
        radiance: Rgb => RADIANCE "" ["R", "G", "B"] "W·m⁻²·sr⁻¹",
            Shown::Color, in_pages true, "image",
            "estimated radiance, linear Rec. 709";
        standard_error: f32 => STANDARD_ERROR "standard_error" ["Y"] "W·m⁻²·sr⁻¹",
            Shown::Relative, in_pages false, "relative standard error",
            "standard error of what is controlled (the luminance, or the worst channel if `control` says channels), 0 if exact, NaN if it is not known";
        half_width: f32 => HALF_WIDTH "half_width" ["Y"] "W·m⁻²·sr⁻¹",
            Shown::Relative, in_pages true, "relative half-width",
            "half-width of the interval that is claimed for what is controlled (the luminance, or each channel if `control` says channels), 0 if exact, NaN if nothing is claimed";
        half_widths: HalfWidths => HALF_WIDTH_PARTS "half_width_parts" ["clustering", "lights", "compensation"] "W·m⁻²·sr⁻¹",
            Shown::Relative, in_pages false, "relative half-width by source",
            "what the half-width would be if one source of error were all: few terms drawn, few VPLs, few paths of what VPLs do not carry; NaN if nothing is claimed";
        luminance_parts: LuminanceParts => LUMINANCE_PARTS "luminance_parts" ["emission", "vpls", "paths", "missing"] "W·m⁻²·sr⁻¹",
            Shown::Relative, in_pages false, "share of the luminance by estimator",
            "luminance by estimator, where a method has several: emission that the camera sees, sum over VPLs, paths; and the luminance that light paths know to be missing";
        claim: Claim => CLAIM "claim" ["id"] "1",
            Shown::Code(Claim::CODES), in_pages true, "claim",
            "what is claimed: 0 nothing, 1 exact, 2 published, 3 calibrated, 4 certified, 5 audited";
        stop: Stop => STOP "stop" ["id"] "1",
            Shown::Code(Stop::CODES), in_pages true, "why work stopped",
            "why work ended: 0 not rendered, 1 complete, 2 sample count, 3 rule met, 4 out of budget, 5 light not found, 6 not finite";
        pairs: u64 => PAIRS "pairs" ["n"] "1",
            Shown::Count, in_pages true, "pairs a pixel",
            "how much was looked at: terms, pairs of clusters or paths, as `pairs.are` says";
        rays: u64 => RAYS "rays" ["n"] "1",
            Shown::Count, in_pages true, "rays a pixel",
            "rays and segments traced";
        depth: f32 => DEPTH "depth" ["Z"] "m",
            Shown::Value, in_pages false, "depth",
            "mean distance to the first surface, 0 where there is none";
        normal: Vec3 => NORMAL "normal" ["X", "Y", "Z"] "1",
            Shown::Direction, in_pages false, "normal",
            "mean shading normal of the first surface, world";
        albedo: Rgb => ALBEDO "albedo" ["R", "G", "B"] "1",
            Shown::Color, in_pages false, "albedo",
            "mean rough reflectance of the surface that gathers";
        coverage: f32 => COVERAGE "coverage" ["A"] "1",
            Shown::Value, in_pages false, "coverage",
            "share of camera samples that met a surface";
    }
    beside {
        AUDITED F32 "audited" ["low", "high", "verdict"] "W·m⁻²·sr⁻¹",
            Shown::Value, in_pages true, "audited pixels",
            "luminance that an audit found of a pixel, from and to, NaN if it is not known, and its verdict: 1 within the error, 2 outside or not known well enough, 0 not audited";
        HALVES F32 "picture_halves" ["A_R", "A_G", "A_B", "A_error", "B_R", "B_G", "B_B", "B_error", "passes"] "W·m⁻²·sr⁻¹",
            Shown::Value, in_pages false, "halves of a part",
            "of a part of an audited picture: mean radiance of each of two independent halves with the standard error of its luminance, and passes; merging makes the picture of it";
        TRUTH F32 "audit_truth" ["low", "high", "stage", "rays"] "W·m⁻²·sr⁻¹",
            Shown::Value, in_pages false, "truths of a part",
            "of a part of an audited picture: luminance that an audit found of a pixel, from and to (infinity if it is not known), how often it was computed (0: the pixel is not audited), and rays; merging judges the picture by it";
        OBJECT_ID U32 "object_id" ["id"] "1",
            Shown::Id, in_pages false, "object",
            "number of the object that covers most of a pixel, 0 where there is none; the manifest of `CryptoObject` has its name";
        MATERIAL_ID U32 "material_id" ["id"] "1",
            Shown::Id, in_pages false, "material",
            "number of the material that covers most of a pixel, 0 where there is none; the manifest of `CryptoMaterial` has its name";
        MOTION F32 "motion" ["x", "y"] "pixel",
            Shown::Value, in_pages false, "motion",
            "how far the surface at the pixel's centre goes on the film from shutter open to shutter close: pixels to the right, and up";
        TIME F32 "time" ["t"] "1",
            Shown::Value, in_pages true, "time in front",
            "when the object in front is there: the mean time of the camera samples that meet it, as a share of the time that the shutter is open; 0 where there is none";
        TRANSMITTANCE F32 "transmittance" ["R", "G", "B"] "1",
            Shown::Color, in_pages true, "transmittance",
            "what media leave of the light of the first surface on its way to the camera";
        REFERENCE F32 "reference" ["R", "G", "B"] "W·m⁻²·sr⁻¹",
            Shown::Color, in_pages false, "reference",
            "what errors are measured from";
        REFERENCE_HALF_WIDTH F32 "reference_half_width" ["Y"] "W·m⁻²·sr⁻¹",
            Shown::Relative, in_pages false, "relative half-width of the reference",
            "how far what errors are measured from may be off itself, at 99.9 %";
    }
}

impl PixelRecord {
    /// Returns the record. If the radiance of a rendered pixel is infinite or not a number, the
    /// result has no claim, half-widths of NaN and [`Stop::NotFinite`].
    #[must_use]
    pub fn as_told(self) -> Self {
        if self.radiance.is_finite() || self.stop == Stop::NotRendered {
            return self;
        }
        Self { claim: Claim::None, stop: Stop::NotFinite, ..self.without_half_widths() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Window;

    /// A record whose fields all differ from zero and from each other.
    fn record() -> PixelRecord {
        PixelRecord {
            radiance: Rgb::new(1.0, 2.0, 3.0),
            standard_error: 4.0,
            half_width: 5.0,
            half_widths: HalfWidths { clustering: 6.0, lights: 7.0, compensation: 8.0 },
            luminance_parts: LuminanceParts { emission: 8.25, vpls: 8.5, paths: 8.75, missing: 8.875 },
            claim: Claim::Calibrated,
            stop: Stop::Budget,
            pairs: 9,
            rays: 10,
            depth: 11.0,
            normal: Vec3::new(12.0, 13.0, 14.0),
            albedo: Rgb::new(15.0, 16.0, 17.0),
            coverage: 18.0,
        }
    }

    /// Pixels with an infinite or NaN radiance. They are stored without a claim and with the reason
    /// `NotFinite`, whatever the method claimed. A pixel that was not rendered stays unchanged.
    #[test]
    fn a_pixel_that_is_not_finite_claims_nothing_and_says_so() {
        let size = [3, 1];
        let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
        for (x, radiance) in [(0, f32::NAN), (1, f32::INFINITY)] {
            let radiance = Rgb::new(1.0, radiance, 1.0);
            PixelRecord { radiance, ..record() }.store(&mut film, x, 0);
            let found = PixelRecord::load(&film, x, 0);
            assert_eq!((found.claim, found.stop), (Claim::None, Stop::NotFinite));
            let HalfWidths { clustering, lights, compensation } = found.half_widths;
            assert!([found.half_width, clustering, lights, compensation].iter().all(|h| h.is_nan()));
            assert_eq!((found.pairs, found.depth, found.radiance.r), (9, 11.0, 1.0));
        }
        let unknown = PixelRecord { radiance: Rgb::gray(f32::NAN), ..PixelRecord::default() };
        assert_eq!(unknown.as_told().stop, Stop::NotRendered);
    }

    #[test]
    fn a_record_comes_back_from_a_film() {
        let size = [3, 2];
        let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
        record().store(&mut film, 2, 1);
        assert_eq!(PixelRecord::load(&film, 2, 1), record());
        assert_eq!(PixelRecord::load(&film, 1, 1), PixelRecord::default());
        assert_eq!(film.plane(planes::HALF_WIDTH_PARTS).unwrap().f32_at(2, 1), [6.0, 7.0, 8.0]);
        assert_eq!(film.plane(planes::STOP).unwrap().u32_at(2, 1), [4]);
    }

    /// Three pixels of half-width 0: without a claim, exact, audited. Only the first is stored as
    /// NaN, since zero would mean exact.
    #[test]
    fn a_film_has_no_half_width_where_nothing_is_claimed() {
        let size = [3, 1];
        let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
        for (x, claim) in (0..).zip([Claim::None, Claim::Exact, Claim::Audited]) {
            PixelRecord { claim, half_width: 0.0, ..PixelRecord::default() }.store(&mut film, x, 0);
        }
        for name in ["half_width", "half_width_parts"] {
            let is_known = |x| film.plane(name).unwrap().f32_at(x, 0).iter().all(|h| *h == 0.0);
            assert_eq!([0, 1, 2].map(is_known), [false, true, true], "{name}");
            assert!(film.plane(name).unwrap().f32_at(0, 0).iter().all(|h| h.is_nan()), "{name}");
        }
    }

    #[test]
    fn what_a_film_lacks_is_zero() {
        let size = [1, 1];
        let specs = [planes::RADIANCE, PlaneSpec { kind: SampleKind::F32, ..planes::CLAIM }];
        let mut film = Film::new(size, Window::full(size), &specs).unwrap();
        film.plane_mut(planes::CLAIM).unwrap().set_f32(0, 0, &[3.0]);
        let found = PixelRecord::load(&film, 0, 0);
        assert_eq!((found.claim, found.rays), (Claim::None, 0), "a claim is no real number");
    }

    #[test]
    fn planes_of_codes_say_what_each_code_means() {
        for row in SCHEMA {
            let Shown::Code(codes) = row.shown else { continue };
            let told = row.spec.doc.split_once(": ").unwrap().1;
            let expected: Vec<String> =
                codes.iter().map(|code| format!("{} {}", code.id, code.label)).collect();
            assert_eq!(told.replace("0 nothing,", "0 nothing is claimed,"), expected.join(", "));
        }
    }

    #[test]
    fn names_and_keys_are_there_once() {
        for (i, row) in SCHEMA.iter().enumerate() {
            let mut before = SCHEMA[..i].iter();
            assert!(before.all(|other| other.spec.name != row.spec.name && other.key != row.key), "{row:?}");
        }
    }
}
