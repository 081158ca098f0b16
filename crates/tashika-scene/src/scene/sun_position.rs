//! Position of the sun by place and time.
//!
//! ```text
//! λ = L₀ + C(M) − 0.00569° − 0.00478° sin Ω           apparent longitude
//! tan α = cos ε sin λ / cos λ                          right ascension
//! sin δ = sin ε sin λ                                  declination
//! H = θ₀ + longitude − α                               hour angle; θ₀ is the sidereal time of Greenwich
//! sin h = sin φ sin δ + cos φ cos δ cos H              elevation h at the latitude φ
//! tan A = −cos δ sin H / (cos φ sin δ − sin φ cos δ cos H)
//! R = 1.000001018 (1 − e²) / (1 + e cos(M + C))        distance (astronomical units)
//! ```
//!
//! The series of `L₀`, `M`, `C`, `Ω`, `e`, `ε` and `θ₀` in the time are those of Meeus 1998
//! (chapters 12, 22 and 25, the sun with low accuracy), which NOAA's solar calculator uses, too.
//!
//! # Accuracy
//! 0.01° from 1900 to 2100 (Meeus 1998). The position is geometric: refraction raises the visible
//! sun by 0.03° at an elevation of 30°, and by 0.6° at the horizon. Parallax (0.0024°) and the
//! difference between universal and terrestrial time (0.001° in longitude) are ignored.
//!
//! # Held to this by
//! The tests below: positions published by Meeus 1998 and by Reda and Andreas 2004.

use glam::Vec3;

use crate::math::elementary::{atan2_f64, sin_cos_f64};

/// First and last year of a [`CalendarDate`].
const YEARS: [i32; 2] = [1900, 2100];

/// Day of the Gregorian calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CalendarDate {
    year: i32,
    month: u32,
    day: u32,
}

impl CalendarDate {
    /// Returns the day if it exists and its year is from 1900 to 2100.
    pub fn new(year: i32, month: u32, day: u32) -> Option<Self> {
        let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        let days = match month {
            1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
            4 | 6 | 9 | 11 => 30,
            2 if leap => 29,
            2 => 28,
            _ => return None,
        };
        let exists = (1..=days).contains(&day) && (YEARS[0]..=YEARS[1]).contains(&year);
        exists.then_some(Self { year, month, day })
    }

    /// Year, month and day.
    pub fn parts(self) -> (i32, u32, u32) {
        (self.year, self.month, self.day)
    }

    /// Days from 2000-01-01, 12 h, to the beginning of this day, both in Greenwich.
    fn days_from_2000(self) -> f64 {
        // Years begin in March, so that a leap day is the last of its year (Meeus 1998, equation
        // 7.1, for the Gregorian calendar).
        let (year, month) =
            if self.month > 2 { (self.year, self.month) } else { (self.year - 1, self.month + 12) };
        let century = year / 100;
        let whole = (1461 * (year + 4716)) / 4 + (306_001 * (month as i32 + 1)) / 10_000;
        f64::from(whole + self.day as i32 + 2 - century + century / 4) - 1524.5 - 2_451_545.0
    }
}

/// Position of the sun in the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    /// Angle above the horizon (degrees), without refraction; negative at night.
    pub elevation: f64,
    /// Angle from north to east (degrees), from 0 to 360.
    pub azimuth: f64,
    /// Distance from the earth (astronomical units).
    pub distance: f64,
}

impl SunPosition {
    /// Returns the position at a place and time.
    ///
    /// * `latitude`, `longitude`: degrees, positive to the north and to the east.
    /// * `zone`: hours by which the clock is ahead of universal time.
    /// * `hours`: time of the clock since the beginning of the day.
    pub fn at(latitude: f64, longitude: f64, zone: f64, date: CalendarDate, hours: f64) -> Self {
        let days = date.days_from_2000() + (hours - zone) / 24.0;
        let apparent = Apparent::at(days);
        let turn = 280.460_618_37 + 360.985_647_366_29 * days;
        let hour_angle = (turn + longitude - apparent.right_ascension).rem_euclid(360.0);
        let (sin_h, cos_h) = sin_cos_f64(hour_angle.to_radians());
        let (sin_lat, cos_lat) = sin_cos_f64(latitude.to_radians());
        let (sin_d, cos_d) = (apparent.sin_declination, apparent.cos_declination);
        let up = sin_lat * sin_d + cos_lat * cos_d * cos_h;
        let north = cos_lat * sin_d - sin_lat * cos_d * cos_h;
        let east = -cos_d * sin_h;
        Self {
            elevation: atan2_f64(up, (north * north + east * east).sqrt()).to_degrees(),
            azimuth: atan2_f64(east, north).to_degrees().rem_euclid(360.0),
            distance: apparent.distance,
        }
    }

    /// Unit direction to the sun in the frame of skies: `+y` is up, north `−z`, east `+x`.
    pub fn direction(&self) -> Vec3 {
        let (sin_up, cos_up) = sin_cos_f64(self.elevation.to_radians());
        let (sin, cos) = sin_cos_f64(self.azimuth.to_radians());
        Vec3::new((sin * cos_up) as f32, sin_up as f32, (-cos * cos_up) as f32)
    }
}

/// Apparent place of the sun, as seen from the centre of the earth.
struct Apparent {
    /// Degrees.
    right_ascension: f64,
    sin_declination: f64,
    cos_declination: f64,
    /// Astronomical units.
    distance: f64,
}

impl Apparent {
    /// Returns the place at a time in days from 2000-01-01, 12 h.
    fn at(days: f64) -> Self {
        let t = days / 36525.0;
        let mean_longitude = 280.46646 + t * (36000.76983 + t * 0.0003032);
        let anomaly = 357.52911 + t * (35999.05029 - t * 0.0001537);
        let eccentricity = 0.016708634 - t * (0.000042037 + t * 0.0000001267);
        let sin_of = |degrees: f64| sin_cos_f64(degrees.rem_euclid(360.0).to_radians()).0;
        let center = (1.914602 - t * (0.004817 + t * 0.000014)) * sin_of(anomaly)
            + (0.019993 - t * 0.000101) * sin_of(2.0 * anomaly)
            + 0.000289 * sin_of(3.0 * anomaly);
        let node = 125.04 - 1934.136 * t;
        let longitude = mean_longitude + center - 0.00569 - 0.00478 * sin_of(node);
        let obliquity = 23.439291 - 0.013004 * t + 0.00256 * sin_of(node + 90.0);
        let (sin_l, cos_l) = sin_cos_f64(longitude.rem_euclid(360.0).to_radians());
        let (sin_o, cos_o) = sin_cos_f64(obliquity.to_radians());
        let sin_declination = sin_o * sin_l;
        let cos_true_anomaly = sin_of(anomaly + center + 90.0);
        Self {
            right_ascension: atan2_f64(cos_o * sin_l, cos_l).to_degrees(),
            sin_declination,
            cos_declination: (1.0 - sin_declination * sin_declination).sqrt(),
            distance: 1.000_001_018 * (1.0 - eccentricity * eccentricity)
                / (1.0 + eccentricity * cos_true_anomaly),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn date(year: i32, month: u32, day: u32) -> CalendarDate {
        CalendarDate::new(year, month, day).unwrap()
    }

    /// Julian days published by Meeus 1998, chapter 7.
    #[test]
    fn days_are_those_of_the_calendar() {
        for (day, julian) in [
            (date(2000, 1, 1), 2_451_544.5),
            (date(1999, 1, 1), 2_451_179.5),
            (date(1987, 1, 27), 2_446_822.5),
            (date(1988, 6, 19), 2_447_331.5),
            (date(1900, 1, 1), 2_415_020.5),
        ] {
            assert_eq!(day.days_from_2000() + 2_451_545.0, julian, "{day:?}");
        }
        assert!(CalendarDate::new(2100, 2, 29).is_none() && CalendarDate::new(2000, 2, 29).is_some());
        for (year, month, day) in [(2023, 2, 29), (2023, 4, 31), (2023, 0, 1), (2023, 13, 1), (1899, 1, 1)] {
            assert_eq!(CalendarDate::new(year, month, day), None);
        }
    }

    /// Example 25.a of Meeus 1998: 1992-10-13, 0 h terrestrial time, right ascension 198.38083°
    /// and declination −7.78507° by the series used here, distance 0.99766.
    #[test]
    fn the_apparent_place_is_that_of_the_published_example() {
        let found = Apparent::at(date(1992, 10, 13).days_from_2000());
        let right_ascension = found.right_ascension.rem_euclid(360.0);
        assert!((right_ascension - 198.38083).abs() < 2e-5, "{right_ascension}");
        let declination = atan2_f64(found.sin_declination, found.cos_declination).to_degrees();
        assert!((declination + 7.78507).abs() < 2e-5, "{declination}");
        assert!((found.distance - 0.99766).abs() < 1e-5, "{}", found.distance);
    }

    /// Example of Reda and Andreas 2004 (accuracy 0.0003°): 2003-10-17, 12:30:30 in the zone
    /// −7 h, at 39.742476° N, 105.1786° W: elevation 39.872046° without refraction, azimuth
    /// 194.340241°, distance 0.9965422974.
    #[test]
    fn the_position_is_that_of_the_published_example() {
        let hours = 12.0 + 30.5 / 60.0;
        let found = SunPosition::at(39.742476, -105.1786, -7.0, date(2003, 10, 17), hours);
        assert!((found.elevation - 39.872046).abs() < 0.01, "{found:?}");
        assert!((found.azimuth - 194.340241).abs() < 0.01, "{found:?}");
        assert!((found.distance - 0.9965422974).abs() < 1e-4, "{found:?}");
        let direction = found.direction();
        assert!(direction.is_normalized() && direction.x < 0.0 && direction.z > 0.0, "{direction}");
    }

    /// The sun rises in the east, is in the north at noon of the southern hemisphere, and stands in
    /// the zenith at noon of an equinox on the equator.
    #[test]
    fn the_sun_moves_as_seen_from_the_earth() {
        let morning = SunPosition::at(0.0, 0.0, 0.0, date(2026, 3, 20), 6.5);
        assert!((morning.azimuth - 90.0).abs() < 1.0 && morning.elevation > 0.0, "{morning:?}");
        let sydney = SunPosition::at(-33.87, 151.21, 10.0, date(2026, 6, 21), 12.0);
        assert!(sydney.azimuth < 5.0 || sydney.azimuth > 355.0, "{sydney:?}");
        let noon = SunPosition::at(0.0, 0.0, 0.0, date(2026, 3, 20), 12.12);
        assert!(noon.elevation > 89.0, "{noon:?}");
        assert!(SunPosition::at(52.5, 13.4, 1.0, date(2026, 12, 21), 22.0).elevation < -40.0);
    }
}
