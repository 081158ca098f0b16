//! Positions far from zero, stored as an origin in double precision and offsets in single
//! precision.
//!
//! Numbers of single precision at a distance `d` from zero are `2⁻²⁴ d` to `2⁻²³ d` apart. Rounding
//! moves an object of size `s` at this distance by `2⁻²⁴ d/s` of its size. Relative to an origin
//! within the object, rounding moves it by `2⁻²⁴` of its size only.
//!
//! # Guarantee
//! An origin is zero, or each of its coordinates is a multiple of a power of two. That power is no
//! larger than the size of the set of positions, or than the spacing of single precision there if
//! the spacing is larger. The coordinates of an origin are therefore numbers of single precision.
//! For positions given in single precision, the offset along an axis is exact if the coordinate of
//! the position is within a factor of two of that of the origin (Sterbenz 1974). Along the other
//! axes it is rounded like any number of single precision.
//!
//! # Held to this by
//! The tests below.

use glam::{DVec3, Vec3};

/// Distance from zero, in half sizes of the bounding box, from which positions are stored relative
/// to an origin other than zero. Below it, rounding moves positions by less than 10⁻⁴ of the half
/// size. Chosen: objects in ordinary rooms are nearer to zero, so their coordinates are stored
/// unchanged.
const FAR: f64 = 1024.0;

/// As [`FAR`], for coordinates beyond [`LARGE`]: wide objects may have small parts. Chosen.
const FAR_IF_LARGE: f64 = 8.0;

/// Coordinate (m) that most scenes built around zero do not exceed. Chosen.
const LARGE: f64 = 65536.0;

/// Positions in single precision relative to an origin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocalPlaces {
    /// Point that the offsets are relative to (m).
    pub origin: DVec3,
    /// Positions relative to the origin (m).
    pub places: Vec<Vec3>,
}

impl LocalPlaces {
    /// Stores positions relative to their [`local_origin`].
    pub fn of(places: &[DVec3]) -> Self {
        let origin = local_origin(places.iter().copied());
        Self { origin, places: places.iter().map(|&place| (place - origin).as_vec3()).collect() }
    }
}

/// Returns an origin for positions (m): zero unless they are far from zero in relation to their
/// bounding box. Positions that are not finite are ignored.
pub fn local_origin(places: impl IntoIterator<Item = DVec3>) -> DVec3 {
    let (mut lo, mut hi) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for place in places {
        if place.is_finite() {
            (lo, hi) = (lo.min(place), hi.max(place));
        }
    }
    if lo.x > hi.x {
        return DVec3::ZERO;
    }
    let half = 0.5 * (hi - lo).max_element();
    let far = lo.abs().max(hi.abs()).max_element();
    if far <= FAR_IF_LARGE * half || (far < LARGE && far <= FAR * half) {
        return DVec3::ZERO;
    }
    origin_near(0.5 * (lo + hi), half)
}

/// Returns the multiple of a power of two nearest to a position (m). The power is the largest that
/// is no larger than `size` (m), or than the spacing of single precision at the position if that is
/// larger.
pub fn origin_near(place: DVec3, size: f64) -> DVec3 {
    let least = place.abs().max_element() * f64::from(f32::EPSILON);
    let step = power_of_two_below(size.max(least));
    let origin = (place / step).round() * step;
    if origin.is_finite() { origin } else { DVec3::ZERO }
}

/// Returns the distance (m) between neighbouring numbers of single precision as large as `length`
/// (m).
pub fn spacing_at(length: f64) -> f64 {
    power_of_two_below(length.abs()) * f64::from(f32::EPSILON)
}

/// Returns the largest power of two that is no larger than a positive number.
fn power_of_two_below(number: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    f64::from_bits(number.max(f64::MIN_POSITIVE).to_bits() & EXPONENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ordinary_places_keep_their_bits() {
        for places in [
            vec![DVec3::ZERO, DVec3::ONE],
            vec![DVec3::splat(100.0), DVec3::splat(100.3)],
            vec![DVec3::splat(5e6), DVec3::splat(7e6)],
            vec![DVec3::new(f64::NAN, 1e9, 0.0), DVec3::ONE, DVec3::ZERO],
            vec![DVec3::ZERO],
            vec![],
        ] {
            assert_eq!(local_origin(places.iter().copied()), DVec3::ZERO, "{places:?}");
        }
        let local = LocalPlaces::of(&[DVec3::splat(0.1), DVec3::splat(0.7)]);
        assert_eq!(local.places, [Vec3::splat(0.1), Vec3::splat(0.7)]);
    }

    /// Positions in single precision, far from zero along some axes. Along these axes, the offsets
    /// from the origin are exact.
    #[test]
    fn places_of_single_precision_lose_nothing_about_their_origin() {
        for size in [1e-3_f32, 0.7, 300.0, 4e4] {
            for away in [1e4_f32, 5.3e6, -1e9] {
                let places: Vec<Vec3> = (0..9)
                    .map(|k| Vec3::new(away + size * k as f32 / 7.0, size * k as f32, 3.0 * away))
                    .collect();
                let wide: Vec<DVec3> = places.iter().map(|p| p.as_dvec3()).collect();
                let LocalPlaces { origin, places } = LocalPlaces::of(&wide);
                for (wide, local) in wide.iter().zip(places) {
                    let lost = (local.as_dvec3() + origin - *wide).abs();
                    let allowed = f64::from(size) * 8.0 * 2f64.powi(-24);
                    assert!(lost.max_element() <= allowed, "{size} at {away}: {lost}");
                }
            }
        }
    }

    #[test]
    fn origins_are_near_and_on_a_coarse_lattice() {
        let centre = DVec3::new(5e6 + 0.3, -1e7, 0.0);
        let places = [centre - 1.5, centre + 1.5];
        let origin = local_origin(places);
        assert!((origin - centre).abs().max_element() <= 0.5 && origin == origin.round(), "{origin}");
        assert_eq!(local_origin([DVec3::splat(1e6); 2]), DVec3::splat(1e6), "of no size");
        assert_eq!((spacing_at(5e6), spacing_at(-1e6)), (0.5, 0.0625));
    }
}
