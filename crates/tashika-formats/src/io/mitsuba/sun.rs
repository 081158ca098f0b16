//! Position of the sun at a place and time.
//!
//! Blanco-Muriel, Alarcón-Padilla, López-Moratalla and Lara-Coira 2001, "Computing the Solar
//! Vector". The days since noon of the first day of 2000 give ecliptic coordinates; from these
//! follow celestial coordinates, local coordinates and the parallax. Accurate to a hundredth of a
//! degree between 1999 and 2015, and to a few hundredths for decades before and after.
//!
//! Held to this by the test below.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::math::elementary::{acos, atan2, sin_cos};

/// A place on the earth and a local time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaceAndTime {
    /// Latitude, positive in the north (degrees).
    pub(super) latitude: f64,
    /// Longitude, positive in the east (degrees).
    pub(super) longitude: f64,
    /// Difference between local and universal time (hours), positive in the east.
    pub(super) timezone: f64,
    pub(super) year: i64,
    pub(super) month: i64,
    pub(super) day: i64,
    /// Hour of the day, with fraction.
    pub(super) hour: f64,
}

/// Mitsuba's default place and time: Tokyo.
pub(super) const DEFAULT: PlaceAndTime = PlaceAndTime {
    latitude: 35.6894,
    longitude: 139.6917,
    timezone: 9.0,
    year: 2010,
    month: 7,
    day: 10,
    hour: 15.0,
};

/// Earth's mean radius over the distance of the sun.
const PARALLAX: f64 = 6371.01 / 149_597_890.0;

fn sin_cos_of(angle: f64) -> (f64, f64) {
    let (sin, cos) = sin_cos(angle.rem_euclid(TAU) as f32);
    (f64::from(sin), f64::from(cos))
}

/// Angle from the zenith, and azimuth from north towards east (radians).
pub(super) fn position(p: &PlaceAndTime) -> (f64, f64) {
    let hour = p.hour - p.timezone;
    let days = julian_day(p.year, p.month, p.day) - 0.5 + hour / 24.0 - 2_451_545.0;

    let (sin_omega, cos_omega) = sin_cos_of(2.1429 - 0.001_039_459_4 * days);
    let mean_longitude = 4.895_063_0 + 0.017_202_791_698 * days;
    let mean_anomaly = 6.240_060_0 + 0.017_201_969_9 * days;
    let longitude = mean_longitude
        + 0.033_416_07 * sin_cos_of(mean_anomaly).0
        + 0.000_348_94 * sin_cos_of(2.0 * mean_anomaly).0
        - 0.000_113_4
        - 0.000_020_3 * sin_omega;
    let obliquity = 0.409_092_8 - 6.214_0e-9 * days + 0.000_039_6 * cos_omega;

    let (sin_longitude, cos_longitude) = sin_cos_of(longitude);
    let (sin_obliquity, cos_obliquity) = sin_cos_of(obliquity);
    let right_ascension = f64::from(atan2((cos_obliquity * sin_longitude) as f32, cos_longitude as f32));
    let sin_declination = sin_obliquity * sin_longitude;
    let cos_declination = (1.0 - sin_declination * sin_declination).max(0.0).sqrt();

    let greenwich = 6.697_424_324_2 + 0.065_709_828_3 * days + hour;
    let local = (greenwich * 15.0 + p.longitude).to_radians();
    let (sin_hour, cos_hour) = sin_cos_of(local - right_ascension);
    let (sin_latitude, cos_latitude) = sin_cos_of(p.latitude.to_radians());
    let cos_zenith = cos_latitude * cos_hour * cos_declination + sin_declination * sin_latitude;
    let zenith = f64::from(acos(cos_zenith as f32));
    let east = -sin_hour * cos_declination;
    let north = sin_declination * cos_latitude - sin_latitude * cos_hour * cos_declination;
    (zenith + PARALLAX * sin_cos_of(zenith).0, f64::from(atan2(east as f32, north as f32)))
}

/// Direction to the sun with `+y` up, north at `−z`, east at `+x`.
pub(super) fn direction(p: &PlaceAndTime) -> DVec3 {
    let (zenith, azimuth) = position(p);
    let ((sin_zenith, cos_zenith), (sin, cos)) = (sin_cos_of(zenith), sin_cos_of(azimuth));
    DVec3::new(sin * sin_zenith, cos_zenith, -cos * sin_zenith)
}

/// Julian day number of a date of the Gregorian calendar.
fn julian_day(year: i64, month: i64, day: i64) -> f64 {
    let shift = (month - 14) / 12;
    let days = (1461 * (year + 4800 + shift)) / 4 + (367 * (month - 2 - 12 * shift)) / 12
        - (3 * ((year + 4900 + shift) / 100)) / 4
        + day
        - 32075;
    days as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noon_at_the_equinox_is_where_the_almanac_says() {
        assert_eq!(julian_day(2000, 1, 1), 2_451_545.0);
        // The equinox of 2010 was on 20 March at 17:32 UT, when the equation of time is −7.4
        // minutes: the sun then stands overhead where the mean solar time is 12:07.4, at a
        // longitude of −81.2°.
        let p = PlaceAndTime {
            latitude: 0.0,
            longitude: -81.2,
            timezone: 0.0,
            year: 2010,
            month: 3,
            day: 20,
            hour: 17.0 + 32.0 / 60.0,
        };
        assert!(position(&p).0.to_degrees() < 0.2, "{}", position(&p).0.to_degrees());
        let (zenith, azimuth) = position(&PlaceAndTime { latitude: 50.0, ..p });
        assert!(
            (zenith.to_degrees() - 50.0).abs() < 0.2 && azimuth.to_degrees().abs() > 179.0,
            "in the south"
        );
        let (_, azimuth) = position(&PlaceAndTime { hour: p.hour - 5.0, latitude: 30.0, ..p });
        assert!((45.0..135.0).contains(&azimuth.to_degrees()), "mornings are in the east");
    }

    #[test]
    fn afternoons_mornings_and_the_south_are_those_of_another_program() {
        // Mitsuba 3.9's `sunsky`, which gives (south, west, up); to a twentieth of a degree.
        let winter = PlaceAndTime {
            latitude: 50.0,
            longitude: 10.0,
            timezone: 1.0,
            year: 2020,
            month: 12,
            day: 5,
            hour: 10.5,
        };
        let south = PlaceAndTime {
            latitude: -30.0,
            longitude: 20.0,
            timezone: 2.0,
            year: 2015,
            month: 2,
            day: 5,
            hour: 7.0,
        };
        for (place, [s, w, up]) in [
            (DEFAULT, [0.051_385_4, 0.691_748, 0.720_308]),
            (winter, [0.886_149, -0.393_432, 0.244_85]),
            (south, [0.226_104, -0.960_894, 0.159_875]),
        ] {
            let (d, expected) = (direction(&place), DVec3::new(-w, up, s));
            assert!((d - expected).length() < 1e-3, "{d} {expected}");
        }
    }
}
