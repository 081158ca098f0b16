//! All-weather skies of an environment: the options of `perez:` and `epw:`, and their sky and sun.
//!
//! ```text
//! perez:dni=E,dhi=E,elevation=DEG,azimuth=DEG[,date=YYYY-MM-DD]…
//! perez:dni=E,dhi=E,latitude=DEG,longitude=DEG,zone=H,date=YYYY-MM-DD,time=HH:MM…
//! epw:FILE,date=MM-DD,time=HH:MM…
//!     …[,ground=R][,dewpoint=C][,unit=lx|W][,sun=on|off]
//! ```
//!
//! Irradiances are in W·m⁻². `zone` is the number of hours by which the clock is ahead of universal
//! time. Without a date, the sun is at its mean distance. With `unit=lx`, the default, radiances of
//! the sky are luminances (cd·m⁻²) by the luminous efficacies of [`SkyCondition`]; with `unit=W`,
//! they are radiances of the whole solar spectrum (W·m⁻²·sr⁻¹). The dew point of `epw:` is that of
//! the file.

use std::fmt;
use std::path::PathBuf;

use glam::Vec3;

use super::options::Options;
use crate::error::{Error, Location, Result};
use crate::io::epw;
use crate::scene::{CalendarDate, PerezSky, SkyCondition, SunPosition};

/// Accepted forms, for messages.
pub(super) const PEREZ_FORM: &str = "perez:dni=W/M2,dhi=W/M2, then elevation=DEG,azimuth=DEG[,date=YYYY-MM-DD] or \
    latitude=DEG,longitude=DEG,zone=HOURS,date=YYYY-MM-DD,time=HH:MM, \
    then [,ground=R][,dewpoint=C][,unit=lx|W][,sun=on|off][,scale=S][,up=z]";
pub(super) const EPW_FORM: &str =
    "epw:FILE,date=MM-DD,time=HH:MM[,ground=R][,unit=lx|W][,sun=on|off][,scale=S][,up=z]";

/// Options that may follow the file of `epw:`.
pub(super) const EPW_NAMES: [&str; 7] = ["date", "time", "ground", "unit", "sun", "scale", "up"];

/// Ranges of direct normal and diffuse horizontal irradiance (W·m⁻²), and of dew points (°C).
const IRRADIANCES: [f32; 2] = [0.0, 2000.0];
const DEW_POINTS: [f32; 2] = [-80.0, 50.0];

/// All-weather sky with its sun, as requested.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Weather {
    given: Given,
    /// Share of the light that the ground reflects.
    ground: f32,
    /// Dew point (°C), if given.
    dew_point: Option<f32>,
    is_radiometric: bool,
    has_sun: bool,
}

/// Source of irradiances and of the position of the sun.
#[derive(Clone, Debug, PartialEq)]
enum Given {
    Values { direct_normal: f32, diffuse_horizontal: f32, sun: SunGiven },
    Epw { file: PathBuf, month: u32, day: u32, minutes: u32 },
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum SunGiven {
    /// Degrees.
    Angles {
        elevation: f32,
        azimuth: f32,
        date: Option<CalendarDate>,
    },
    Place {
        latitude: f64,
        longitude: f64,
        zone: f64,
        date: CalendarDate,
        minutes: u32,
    },
}

/// Sky and sun of a weather.
pub(super) struct Daylight {
    pub sky: PerezSky,
    /// Unit direction to the sun, `+y` up.
    pub to_sun: Vec3,
    /// Illuminance or irradiance by the sun on a plane that faces it; 0 without a sun.
    pub direct_normal: f64,
    /// Position of the sun, state of the sky and illuminances, in words.
    pub summary: String,
}

/// Irradiance and sun of an hour.
struct Hour {
    direct_normal: f64,
    diffuse_horizontal: f64,
    sun: SunPosition,
    dew_point: Option<f64>,
}

impl Weather {
    /// Takes the options of `perez:`.
    pub(super) fn perez(options: &mut Options<'_>) -> Result<Self, String> {
        let direct_normal = options.number("dni", IRRADIANCES, None)?;
        let diffuse_horizontal = options.number("dhi", IRRADIANCES, None)?;
        let sun = if options.has("latitude") || options.has("longitude") {
            SunGiven::Place {
                latitude: options.wide("latitude", [-90.0, 90.0])?,
                longitude: options.wide("longitude", [-180.0, 180.0])?,
                zone: options.wide("zone", [-14.0, 14.0])?,
                date: options.date()?.ok_or("no date")?,
                minutes: options.minutes()?,
            }
        } else {
            if !options.has("elevation") {
                return Err("no elevation and azimuth, and no latitude and longitude".to_owned());
            }
            SunGiven::Angles {
                elevation: options.number("elevation", [0.0, 90.0], None)?,
                azimuth: options.number("azimuth", [-360.0, 360.0], None)?,
                date: options.date()?,
            }
        };
        let dew_point = options.has("dewpoint").then(|| options.number("dewpoint", DEW_POINTS, None));
        let dew_point = dew_point.transpose()?;
        let given = Given::Values { direct_normal, diffuse_horizontal, sun };
        let weather = Self::of(given, dew_point, options)?;
        weather.hour(None).map_err(|error| match error {
            Error::Invalid { found, expected, .. } => format!("{found}; expected {expected}"),
            other => other.to_string(),
        })?;
        Ok(weather)
    }

    /// Takes the options of `epw:`.
    pub(super) fn epw(file: PathBuf, options: &mut Options<'_>) -> Result<Self, String> {
        let (month, day) = options.month_and_day()?;
        let given = Given::Epw { file, month, day, minutes: options.minutes()? };
        Self::of(given, None, options)
    }

    fn of(given: Given, dew_point: Option<f32>, options: &mut Options<'_>) -> Result<Self, String> {
        Ok(Self {
            given,
            dew_point,
            ground: options.number("ground", [0.0, 1.0], Some(0.0))?,
            is_radiometric: options.choice("unit", ["lx", "W"])? == "W",
            has_sun: options.choice("sun", ["on", "off"])? == "on",
        })
    }

    /// Returns the path of the weather file, if there is one.
    pub(super) fn file(&self) -> Option<&PathBuf> {
        match &self.given {
            Given::Epw { file, .. } => Some(file),
            Given::Values { .. } => None,
        }
    }

    /// Returns the weather with another path of its file, if it has one.
    pub(super) fn with_file(&self, other: PathBuf) -> Self {
        let mut weather = self.clone();
        if let Given::Epw { file, .. } = &mut weather.given {
            *file = other;
        }
        weather
    }

    /// Returns the irradiance and the sun, which is at or above the horizon.
    fn hour(&self, bytes: Option<&[u8]>) -> Result<Hour> {
        let (hour, at) = match &self.given {
            Given::Values { direct_normal, diffuse_horizontal, sun } => {
                let hour = Hour {
                    direct_normal: (*direct_normal).into(),
                    diffuse_horizontal: (*diffuse_horizontal).into(),
                    sun: sun.position(),
                    dew_point: self.dew_point.map(f64::from),
                };
                (hour, Location::default())
            }
            Given::Epw { file, month, day, minutes } => {
                let at = Location::file(file);
                let found = epw::hour(bytes.unwrap_or_default(), *month, *day, minutes / 60, &at)?;
                let hour = Hour {
                    direct_normal: found.direct_normal,
                    diffuse_horizontal: found.diffuse_horizontal,
                    sun: SunPosition::at(
                        found.latitude,
                        found.longitude,
                        found.zone,
                        found.date,
                        found.middle,
                    ),
                    dew_point: found.dew_point,
                };
                (hour, Location::line(file, found.line))
            }
        };
        let SunPosition { elevation, azimuth, .. } = hour.sun;
        if elevation < 0.0 {
            let found = format!("the sun is {:.2}° below the horizon, at azimuth {azimuth:.1}°", -elevation);
            return Err(Error::invalid(at, found, "a time between sunrise and sunset"));
        }
        if hour.direct_normal == 0.0 && hour.diffuse_horizontal == 0.0 {
            return Err(Error::invalid(at, "no irradiance", "direct or diffuse irradiance above 0"));
        }
        Ok(hour)
    }

    /// Returns the sky and the sun.
    ///
    /// * `bytes`: content of the file, if the weather has one.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the sun is below the horizon or all irradiance is 0, and for files as
    /// [`epw::hour`].
    pub(super) fn daylight(&self, bytes: Option<&[u8]>) -> Result<Daylight> {
        let Hour { direct_normal, diffuse_horizontal, sun, dew_point } = self.hour(bytes)?;
        let SunPosition { elevation, azimuth, distance } = sun;
        let to_sun = sun.direction();
        // Without diffuse light the sky is black; its state matters to the efficacy of the sun.
        let condition = SkyCondition::new(to_sun, direct_normal, diffuse_horizontal.max(1e-3), distance);
        let dew_point = dew_point.unwrap_or(PerezSky::DEW_POINT);
        let efficacies = if self.is_radiometric {
            [1.0; 2]
        } else {
            [condition.diffuse_efficacy(dew_point), condition.direct_efficacy(dew_point)]
        };
        let diffuse = efficacies[0] * diffuse_horizontal;
        let direct_normal = if self.has_sun { efficacies[1] * direct_normal } else { 0.0 };
        let sky = PerezSky::new(&condition, to_sun, diffuse, direct_normal, self.ground.into());
        let unit = if self.is_radiometric { "W/m2" } else { "lx" };
        let summary = format!(
            "sun at elevation {elevation:.2} azimuth {azimuth:.2}, clearness {:.3}, brightness {:.3}, diffuse horizontal \
             {diffuse:.0} {unit}, direct normal {direct_normal:.0} {unit}",
            condition.clearness, condition.brightness
        );
        Ok(Daylight { sky, to_sun, direct_normal, summary })
    }
}

impl SunGiven {
    fn position(&self) -> SunPosition {
        match *self {
            Self::Angles { elevation, azimuth, date } => SunPosition {
                elevation: elevation.into(),
                azimuth: azimuth.into(),
                // The distance at noon in Greenwich.
                distance: date.map_or(1.0, |date| SunPosition::at(0.0, 0.0, 0.0, date, 12.0).distance),
            },
            Self::Place { latitude, longitude, zone, date, minutes } => {
                SunPosition::at(latitude, longitude, zone, date, f64::from(minutes) / 60.0)
            }
        }
    }
}

impl fmt::Display for Weather {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.given {
            Given::Values { direct_normal, diffuse_horizontal, sun } => {
                write!(f, "perez:dni={direct_normal},dhi={diffuse_horizontal}")?;
                match *sun {
                    SunGiven::Angles { elevation, azimuth, date } => {
                        write!(f, ",elevation={elevation},azimuth={azimuth}")?;
                        if let Some(date) = date {
                            write!(f, ",date={}", written(date))?;
                        }
                    }
                    SunGiven::Place { latitude, longitude, zone, date, minutes } => write!(
                        f,
                        ",latitude={latitude},longitude={longitude},zone={zone},date={},time={}",
                        written(date),
                        clock(minutes)
                    )?,
                }
            }
            Given::Epw { file, month, day, minutes } => {
                write!(f, "epw:{},date={month:02}-{day:02},time={}", file.display(), clock(*minutes))?;
            }
        }
        if self.ground > 0.0 {
            write!(f, ",ground={}", self.ground)?;
        }
        if let Some(dew_point) = self.dew_point {
            write!(f, ",dewpoint={dew_point}")?;
        }
        if self.is_radiometric {
            f.write_str(",unit=W")?;
        }
        if self.has_sun { Ok(()) } else { f.write_str(",sun=off") }
    }
}

fn clock(minutes: u32) -> String {
    format!("{:02}:{:02}", minutes / 60, minutes % 60)
}

fn written(date: CalendarDate) -> String {
    let (year, month, day) = date.parts();
    format!("{year}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::color::Rgb;
    use crate::io::{AskedEnvironment, LightChanges, LoadOptions};
    use crate::scene::{Emitter, Scene, builtin, hemispherical_irradiance};

    const NOON: &str = "perez:dni=800,dhi=100,elevation=60,azimuth=90";
    const BERLIN: &str = "latitude=52.47,longitude=13.4,zone=1";

    fn lit(text: &str) -> Result<Scene> {
        let environment = Some(text.parse::<AskedEnvironment>()?);
        LightChanges { environment, lights: Vec::new() }.apply(builtin::tiny(), &LoadOptions::default())
    }

    /// Light of the sky on a horizontal plane, and light of the sun on a plane that faces it with
    /// the direction of the sun.
    fn light(scene: &Scene, up: Vec3) -> (f64, Option<(f64, Vec3)>) {
        let environment = scene.environment().unwrap();
        let sky = hemispherical_irradiance(up.as_dvec3(), |direction| {
            [environment.radiance(direction.as_vec3().normalize()).g.into()]
        })[0];
        let mut suns = scene.emitters().iter().filter_map(|emitter| match emitter {
            Emitter::Directional { direction, irradiance } => Some((irradiance.g.into(), -*direction)),
            _ => None,
        });
        (sky, suns.next_back())
    }

    /// Sky and sun have the given irradiances in watts, and those times the efficacies in lux. The
    /// tolerance is that of the image of 512 × 256 texels.
    #[test]
    fn sky_and_sun_have_the_given_irradiances() {
        let (sky, sun) = light(&lit(&format!("{NOON},unit=W,scale=2")).unwrap(), Vec3::Y);
        let (direct, to_sun) = sun.unwrap();
        assert!((sky / 200.0 - 1.0).abs() < 2e-3, "{sky}");
        assert!((direct / 1600.0 - 1.0).abs() < 1e-6, "{direct}");
        // East is +x.
        assert!((to_sun - Vec3::new(0.5, 0.75f32.sqrt(), 0.0)).length() < 1e-5, "{to_sun}");
        let scene = lit(&format!("{NOON},up=z")).unwrap();
        let (sky, sun) = light(&scene, Vec3::Z);
        let (direct, to_sun) = sun.unwrap();
        let condition = SkyCondition::new(Vec3::new(0.5, 0.75f32.sqrt(), 0.0), 800.0, 100.0, 1.0);
        let efficacies =
            [condition.diffuse_efficacy(PerezSky::DEW_POINT), condition.direct_efficacy(PerezSky::DEW_POINT)];
        assert!((sky / (100.0 * efficacies[0]) - 1.0).abs() < 2e-3, "{sky} {efficacies:?}");
        assert!((direct / (800.0 * efficacies[1]) - 1.0).abs() < 1e-6, "{direct} {efficacies:?}");
        assert!((to_sun - Vec3::new(0.5, 0.0, 0.75f32.sqrt())).length() < 1e-5, "{to_sun}");
        assert!(scene.changes()[1].contains("clearness 7.96"), "{:?}", scene.changes());
        // `builtin::tiny` has no directional light of its own.
        let without = lit(&format!("{NOON},sun=off,ground=0.5")).unwrap();
        assert!(light(&without, Vec3::Y).1.is_none());
        let ground = without.environment().unwrap().radiance(Vec3::NEG_Y);
        let expected = 0.5 * 100.0 * efficacies[0] / std::f64::consts::PI;
        assert!((f64::from(ground.g) / expected - 1.0).abs() < 1e-4 && ground == Rgb::gray(ground.g));
    }

    /// An hour of a weather file is the same light as its irradiances at the middle of the hour.
    #[test]
    fn a_weather_file_is_its_hour() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a, b.epw");
        let record = "1991,6,21,15,60,?,20.0,12.5,50,101325,0,1300,330,500,640,180,0,0\n";
        let header = "LOCATION,Berlin,-,DEU,IWEC,103840,52.47,13.4,1.0,49.0\n";
        fs::write(&path, format!("{header}{record}")).unwrap();
        let asked = |hour: &str| format!("epw:{},date=06-21,time={hour},ground=0.2", path.display());
        let from_file = lit(&asked("14:05")).unwrap();
        let values =
            format!("perez:dni=640,dhi=180,{BERLIN},date=1991-06-21,time=14:30,dewpoint=12.5,ground=0.2");
        assert_eq!(light(&from_file, Vec3::Y), light(&lit(&values).unwrap(), Vec3::Y));
        assert!(from_file.changes()[0].starts_with("environment epw:a, b.epw,date=06-21,time=14:05"));
        let missing = lit(&asked("13:59")).unwrap_err().to_string();
        assert!(missing.contains("a, b.epw: no record of 06-21, hour 14"), "{missing}");
        fs::write(&path, format!("{header}{}", record.replace(",15,", ",24,"))).unwrap();
        let night = lit(&asked("23:00")).unwrap_err().to_string();
        assert!(night.contains("a, b.epw:2: the sun is") && night.contains("below the horizon"), "{night}");
    }

    #[test]
    fn errors_name_the_accepted_forms() {
        let night = format!("perez:dni=0,dhi=5,{BERLIN},date=2026-12-21,time=22:00");
        for (text, why) in [
            ("perez:dhi=1,elevation=5,azimuth=1", "no dni"),
            ("perez:dni=-1,dhi=1,elevation=5,azimuth=1", "dni from 0 to 2000"),
            ("perez:dni=1,dhi=nan,elevation=5,azimuth=1", "no number"),
            ("perez:dni=0,dhi=0,elevation=5,azimuth=1", "no irradiance"),
            ("perez:dni=1,dhi=1", "no elevation and azimuth, and no latitude and longitude"),
            ("perez:dni=1,dhi=1,elevation=-5,azimuth=1", "elevation from 0 to 90"),
            ("perez:dni=1,dhi=1,elevation=5,azimuth=1,haze=3", "haze is no option here"),
            ("perez:dni=1,dhi=1,elevation=5,azimuth=1,unit=cd", "unit is lx or W"),
            ("perez:dni=1,dhi=1,latitude=52,longitude=13,date=2026-06-21,time=12:00", "no zone"),
            (
                "perez:dni=1,dhi=1,latitude=52,longitude=13,zone=1,date=2026-02-30,time=12:00",
                "no day YYYY-MM-DD",
            ),
            ("perez:dni=1,dhi=1,latitude=52,longitude=13,zone=1,date=2026-06-21,time=24:00", "no time HH:MM"),
            ("perez:dni=1,dhi=1,latitude=91,longitude=13,zone=1,date=2026-06-21,time=12:00", "latitude from"),
            (&night, "below the horizon"),
        ] {
            let message = text.parse::<AskedEnvironment>().unwrap_err().to_string();
            assert!(message.contains(why) && message.contains("perez:dni=W/M2"), "{message}");
        }
        for (text, why) in [
            ("epw:,date=06-21,time=12:00", "no file"),
            ("epw:a.epw", "no date"),
            ("epw:a.epw,date=06-21", "no time"),
            ("epw:a.epw,date=06-31,time=12:00", "no day MM-DD"),
            ("epw:a.epw,date=06-21,time=noon", "no time HH:MM"),
            ("epw:a.epw,date=06-21,time=12:00,time=13:00", "time twice"),
        ] {
            let message = text.parse::<AskedEnvironment>().unwrap_err().to_string();
            assert!(message.contains(why) && message.contains("epw:FILE"), "{message}");
        }
        let absent = lit("epw:absent.epw,date=06-21,time=12:00").unwrap_err().to_string();
        assert!(absent.contains("absent.epw"), "{absent}");
        for text in [
            "perez:dni=800,dhi=100,elevation=60,azimuth=90,date=2026-06-21,ground=0.2,dewpoint=9,unit=W,sun=off,up=z",
            "perez:dni=1,dhi=1,latitude=52,longitude=13,zone=1,date=2026-06-21,time=09:05",
            "epw:a.epw,date=06-21,time=12:00,ground=0.2,scale=2",
        ] {
            assert_eq!(text.parse::<AskedEnvironment>().unwrap().to_string(), text);
        }
    }
}
