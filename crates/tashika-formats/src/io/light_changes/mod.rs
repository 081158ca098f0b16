//! Lights that a user adds to a scene (`--light`), and an environment that replaces the scene's
//! (`--environment`):
//!
//! ```text
//! environment   FILE[,scale=S][,rotate=DEG][,up=z]          a latitude-longitude image, instead of the scene's environment
//!               sky:elevation=DEG,azimuth=DEG[,turbidity=T][,scale=S][,up=z]
//!               cie:TYPE[,illuminance=LX][,elevation=DEG,azimuth=DEG][,ground=R][,scale=S][,up=z]
//!               perez:… and epw:…                             skies by measured irradiance, with their sun (module `weather`)
//! light         sun:elevation=DEG,azimuth=DEG[,turbidity=T][,scale=S][,up=z]
//!               point:X,Y,Z,WATTS
//!               ies:FILE@X,Y,Z[,scale=S][,rotate=DEG][,up=z]
//! ```
//!
//! Up is `+y` and north `−z`; with `up=z`, up is `+z` and north `+y`. East is `+x`. The azimuth of
//! the sun grows from north to east. The middle of an image is north, and its right half is east;
//! `rotate` turns an image or a lamp counterclockwise as seen from above. Sun and sky are those of
//! [`scene::sky`](crate::scene::sky), with turbidity 3 by default. A lamp is read by
//! [`ies`](super::ies) (an EULUMDAT file, too), with `C = 0°` to the east. `cie` is one of the
//! sixteen skies of ISO 15469 ([`CieSky`]), by its number or as `overcast` (16), `uniform` (5) or
//! `clear` (12). It has a horizontal illuminance of 10,000 lx by default; the ground is black by
//! default. `perez` and `epw` are the all-weather sky of Perez et al. 1993
//! ([`PerezSky`](crate::scene::PerezSky)) by irradiances and the position of the sun, or by an hour
//! of a weather file; they add a directional light for the sun.
//!
//! Held to this by the tests below and by `suite::light_changes`.

mod options;
mod weather;

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use glam::{Mat3, Vec3};

use self::options::{Options, wide_number};
use self::weather::{EPW_FORM, EPW_NAMES, PEREZ_FORM, Weather};
use super::files::digest;
use super::images::{Encoding, decode};
use super::{LoadOptions, SceneFiles, ies};
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::math::elementary::sin_cos;
use crate::scene::sky::Sky;
use crate::scene::{CieSky, Emitter, Environment, Lamp, NoteKind, Notes, Scene, below_zero_message};

/// Size of a sky's image (texels).
const SKY_RESOLUTION: [u32; 2] = [512, 256];

/// Changes that a user makes to the lights of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightChanges {
    /// Replacement for the scene's environment.
    pub environment: Option<AskedEnvironment>,
    /// Lights added to those of the scene.
    pub lights: Vec<AskedLight>,
}

/// Environment requested by a user.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedEnvironment {
    source: Source,
    turned: Turned,
}

/// Light requested by a user.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedLight(LightKind);

#[derive(Clone, Debug, PartialEq)]
enum Source {
    File(PathBuf),
    Sky(Sun),
    Cie(Cie),
    Weather(Box<Weather>),
}

/// Sky of ISO 15469.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cie {
    kind: u32,
    /// Position of the sun (degrees); `None` for types without a sun.
    sun: Option<[f32; 2]>,
    /// Light of the sky on a horizontal plane (lx).
    illuminance: f32,
    /// Share of the light that the ground reflects.
    ground: f32,
}

#[derive(Clone, Debug, PartialEq)]
enum LightKind {
    Sun(Sun, Turned),
    Point { position: [f64; 3], power: f32 },
    Ies { file: PathBuf, position: [f64; 3], turned: Turned },
}

/// Position of the sun (degrees) and turbidity of the air.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sun {
    elevation: f32,
    azimuth: f32,
    turbidity: f32,
}

/// Scale, rotation (degrees) and up axis of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turned {
    scale: f32,
    rotate: f32,
    z_is_up: bool,
}

impl Turned {
    /// Rotation to the world from a frame with `+y` up.
    fn to_world(self) -> Mat3 {
        let (sin, cos) = sin_cos(self.rotate.to_radians());
        let about_up = Mat3::from_cols(Vec3::new(cos, 0.0, -sin), Vec3::Y, Vec3::new(sin, 0.0, cos));
        let upright = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y);
        if self.z_is_up { upright * about_up } else { about_up }
    }
}

impl Sun {
    fn sky(self) -> Sky {
        Sky::new(self.turbidity, to_sun([self.elevation, self.azimuth]))
    }
}

impl Cie {
    fn sky(self) -> CieSky {
        let to_sun = self.sun.map_or(Vec3::Y, to_sun);
        CieSky::new(self.kind, to_sun, self.illuminance.into(), self.ground.into())
    }
}

/// Unit direction to the sun, `+y` up, from its elevation and azimuth (degrees).
fn to_sun([elevation, azimuth]: [f32; 2]) -> Vec3 {
    let (sin_up, cos_up) = sin_cos(elevation.to_radians());
    let (sin, cos) = sin_cos(azimuth.to_radians());
    Vec3::new(sin * cos_up, sin_up, -cos * cos_up)
}

impl LightChanges {
    /// Returns true if there is no change.
    pub fn is_empty(&self) -> bool {
        self.environment.is_none() && self.lights.is_empty()
    }

    /// Returns the files of all changes.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let of_environment = self.environment.iter().filter_map(AskedEnvironment::file);
        of_environment.chain(self.lights.iter().filter_map(AskedLight::file))
    }

    /// Returns the scene with these changes.
    ///
    /// Returns an error if a file cannot be read, is not an image or not a lamp, or if a light is
    /// not finite.
    pub fn apply(&self, scene: Scene, options: &LoadOptions) -> Result<Scene> {
        let mut sum = 0u64;
        let mut words = Vec::new();
        let mut read = |file: &Path| -> Result<Vec<u8>> {
            let bytes = SceneFiles::open(file, options)?.read_scene()?;
            sum = sum.rotate_left(1).wrapping_add(digest(&bytes));
            Ok(bytes)
        };
        let (mut environment, mut notes) = (None, Notes::default());
        let mut lamps = Vec::new();
        if let Some(asked) = &self.environment {
            words.push(format!("environment {}", asked.named_by_file()));
            let scale = Rgb::gray(asked.turned.scale);
            let image = match &asked.source {
                Source::File(file) => {
                    let at = Location::file(file);
                    let decoded = decode(&read(file)?, &file_name(file), Encoding::Srgb, options, &at)?;
                    decoded.note(&mut notes, &at);
                    let (message, count) =
                        (below_zero_message(&decoded.image.name), decoded.image.texels_below_zero());
                    notes.push_many(NoteKind::Repaired, message, at.clone(), count);
                    decoded.image
                }
                Source::Sky(sun) => sun.sky().image(SKY_RESOLUTION[0], SKY_RESOLUTION[1]),
                Source::Cie(cie) => cie.sky().image(SKY_RESOLUTION[0], SKY_RESOLUTION[1]),
                Source::Weather(weather) => {
                    let bytes = weather.file().map(|file| read(file)).transpose()?;
                    let daylight = weather.daylight(bytes.as_deref())?;
                    words.push(daylight.summary);
                    if daylight.direct_normal > 0.0 {
                        let direction = -(asked.turned.to_world() * daylight.to_sun).normalize();
                        let irradiance = scale * daylight.direct_normal as f32;
                        lamps.push(Lamp::Emitter(Emitter::Directional { direction, irradiance }));
                    }
                    daylight.sky.image(SKY_RESOLUTION[0], SKY_RESOLUTION[1])
                }
            };
            environment = Some(Environment::lat_long(image, scale, asked.turned.to_world()));
        }
        for light in &self.lights {
            words.push(format!("light {}", light.named_by_file()));
            match &light.0 {
                LightKind::Sun(sun, turned) => {
                    let sky = sun.sky();
                    let direction = -(turned.to_world() * sky.to_sun()).normalize();
                    let irradiance = sky.sun_irradiance() * turned.scale;
                    lamps.push(Lamp::Emitter(Emitter::Directional { direction, irradiance }));
                }
                LightKind::Point { position, power } => {
                    let intensity = Rgb::gray(power / (4.0 * std::f32::consts::PI));
                    lamps.push(Lamp::Point { position: (*position).into(), intensity });
                }
                LightKind::Ies { file, position, turned } => {
                    let map = ies::decode(&read(file)?, &file_name(file), &Location::file(file))?;
                    lamps.extend(map.map(|map| Lamp::Image {
                        map: Arc::new(map),
                        position: (*position).into(),
                        intensity: Rgb::gray(turned.scale),
                        to_world: turned.to_world(),
                    }));
                }
            }
        }
        let sum = sum.rotate_left(1).wrapping_add(digest(words.join("\n").as_bytes()));
        Ok(scene.relit(environment, lamps, words, sum)?.with_notes(&notes))
    }
}

impl AskedEnvironment {
    fn file(&self) -> Option<&Path> {
        match &self.source {
            Source::File(file) => Some(file),
            Source::Weather(weather) => weather.file().map(PathBuf::as_path),
            Source::Sky(_) | Source::Cie(_) => None,
        }
    }

    /// Returns the environment with the absolute path of its file, so that it is valid in any
    /// current folder.
    ///
    /// # Errors
    /// [`Error::Io`] if there is no current folder.
    pub fn with_absolute_path(&self) -> Result<Self> {
        self.with_file(absolute)
    }

    fn with_file(&self, of: impl FnOnce(&Path) -> Result<PathBuf>) -> Result<Self> {
        let source = match (&self.source, self.file()) {
            (Source::Weather(weather), Some(file)) => Source::Weather(Box::new(weather.with_file(of(file)?))),
            (_, Some(file)) => Source::File(of(file)?),
            (sky, None) => sky.clone(),
        };
        Ok(Self { source, ..*self })
    }

    /// Text of the environment with the name of its file but without the folder, which differs
    /// between machines.
    fn named_by_file(&self) -> String {
        let named = self.with_file(|file| Ok(file_name(file).into()));
        named.as_ref().unwrap_or(self).to_string()
    }
}

impl AskedLight {
    fn file(&self) -> Option<&Path> {
        match &self.0 {
            LightKind::Ies { file, .. } => Some(file),
            LightKind::Sun(..) | LightKind::Point { .. } => None,
        }
    }

    fn with_file(&self, of: impl FnOnce(&Path) -> Result<PathBuf>) -> Result<Self> {
        let mut light = self.clone();
        if let LightKind::Ies { file, .. } = &mut light.0 {
            *file = of(file)?;
        }
        Ok(light)
    }

    /// As [`AskedEnvironment::with_absolute_path`].
    ///
    /// # Errors
    /// [`Error::Io`] if there is no current folder.
    pub fn with_absolute_path(&self) -> Result<Self> {
        self.with_file(absolute)
    }

    fn named_by_file(&self) -> String {
        let named = self.with_file(|file| Ok(file_name(file).into()));
        named.as_ref().unwrap_or(self).to_string()
    }
}

fn absolute(file: &Path) -> Result<PathBuf> {
    std::path::absolute(file).map_err(|e| Error::io(file, e))
}

fn file_name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Accepted forms of an environment, for messages.
const ENVIRONMENTS: &str = "FILE[,scale=S][,rotate=DEG][,up=z], sky:elevation=DEG,azimuth=DEG[,turbidity=T][,scale=S][,up=z], \
    cie:TYPE[,illuminance=LX][,elevation=DEG,azimuth=DEG][,ground=R][,scale=S][,up=z], perez:... or epw:FILE,...";

/// Accepted forms of a light, for messages.
const LIGHTS: &str = "sun:elevation=DEG,azimuth=DEG[,turbidity=T][,scale=S][,up=z], point:X,Y,Z,WATTS or \
    ies:FILE@X,Y,Z[,scale=S][,rotate=DEG][,up=z]";

impl FromStr for AskedEnvironment {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = |why: String| Error::option("environment", text, format!("{ENVIRONMENTS} ({why})"));
        let (source, turned) = if let Some(rest) = text.strip_prefix("sky:") {
            let mut options = Options::of(rest.split(',')).map_err(wrong)?;
            let sun = options.sun().map_err(wrong)?;
            (Source::Sky(sun), options.turned(false).map_err(wrong)?)
        } else if let Some(rest) = text.strip_prefix("cie:") {
            let mut words = rest.split(',');
            let kind = cie_kind(words.next().unwrap_or_default()).map_err(wrong)?;
            let mut options = Options::of(words).map_err(wrong)?;
            let cie = options.cie(kind).map_err(wrong)?;
            (Source::Cie(cie), options.turned(false).map_err(wrong)?)
        } else if let Some(rest) = text.strip_prefix("perez:") {
            let wrong = |why: String| Error::option("environment", text, format!("{PEREZ_FORM} ({why})"));
            let mut options = Options::of(rest.split(',')).map_err(wrong)?;
            let weather = Weather::perez(&mut options).map_err(wrong)?;
            (Source::Weather(Box::new(weather)), options.turned(false).map_err(wrong)?)
        } else if let Some(rest) = text.strip_prefix("epw:") {
            let wrong = |why: String| Error::option("environment", text, format!("{EPW_FORM} ({why})"));
            let (file, options) = Options::behind_file(rest, &EPW_NAMES);
            if file.is_empty() {
                return Err(wrong("no file".to_owned()));
            }
            let mut options = Options::of(options).map_err(wrong)?;
            let weather = Weather::epw(file.into(), &mut options).map_err(wrong)?;
            (Source::Weather(Box::new(weather)), options.turned(false).map_err(wrong)?)
        } else {
            let (file, options) = Options::behind(text);
            if file.is_empty() {
                return Err(wrong("no file".to_owned()));
            }
            (Source::File(file.into()), Options::of(options).and_then(|mut o| o.turned(true)).map_err(wrong)?)
        };
        Ok(Self { source, turned })
    }
}

/// Number of a sky of ISO 15469.
fn cie_kind(word: &str) -> Result<u32, String> {
    let known = match word {
        "overcast" => Some(CieSky::OVERCAST),
        "uniform" => Some(CieSky::UNIFORM),
        "clear" => Some(CieSky::CLEAR),
        _ => word.parse().ok().filter(|kind| (1..=CieSky::OVERCAST).contains(kind)),
    };
    known.ok_or_else(|| format!("{word:?} is no type from 1 to 16, overcast, uniform or clear"))
}

impl FromStr for AskedLight {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = |why: String| Error::option("light", text, format!("{LIGHTS} ({why})"));
        let numbers = |text: &str| text.split(',').map(wide_number).collect::<Result<Vec<f64>, String>>();
        Ok(Self(match text.split_once(':') {
            Some(("sun", rest)) => {
                let mut options = Options::of(rest.split(',')).map_err(wrong)?;
                let sun = options.sun().map_err(wrong)?;
                LightKind::Sun(sun, options.turned(false).map_err(wrong)?)
            }
            Some(("point", rest)) => match numbers(rest).map_err(wrong)?[..] {
                [x, y, z, power] if power >= 0.0 => {
                    LightKind::Point { position: [x, y, z], power: power as f32 }
                }
                _ => return Err(wrong("three coordinates in metres, and watts of at least 0".to_owned())),
            },
            Some(("ies", rest)) => {
                let Some((file, place)) = rest.rsplit_once('@').filter(|(file, _)| !file.is_empty()) else {
                    return Err(wrong("a file and its place, after @".to_owned()));
                };
                let (place, options) = Options::behind(place);
                let [x, y, z] = numbers(place).map_err(wrong)?[..] else {
                    return Err(wrong("three coordinates in metres".to_owned()));
                };
                let turned = Options::of(options).and_then(|mut o| o.turned(true)).map_err(wrong)?;
                LightKind::Ies { file: file.into(), position: [x, y, z], turned }
            }
            _ => return Err(wrong("it begins with sun:, point: or ies:".to_owned())),
        }))
    }
}

impl fmt::Display for Sun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { elevation, azimuth, turbidity } = self;
        write!(f, "elevation={elevation},azimuth={azimuth},turbidity={turbidity}")
    }
}

impl fmt::Display for Cie {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, sun, illuminance, ground } = self;
        write!(f, "{kind},illuminance={illuminance}")?;
        if let Some([elevation, azimuth]) = sun {
            write!(f, ",elevation={elevation},azimuth={azimuth}")?;
        }
        if *ground > 0.0 { write!(f, ",ground={ground}") } else { Ok(()) }
    }
}

impl fmt::Display for Turned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scale, rotate, z_is_up } = *self;
        if scale != 1.0 {
            write!(f, ",scale={scale}")?;
        }
        if rotate != 0.0 {
            write!(f, ",rotate={rotate}")?;
        }
        if z_is_up { f.write_str(",up=z") } else { Ok(()) }
    }
}

impl fmt::Display for AskedEnvironment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.source {
            Source::File(file) => write!(f, "{}{}", file.display(), self.turned),
            Source::Sky(sun) => write!(f, "sky:{sun}{}", self.turned),
            Source::Cie(cie) => write!(f, "cie:{cie}{}", self.turned),
            Source::Weather(weather) => write!(f, "{weather}{}", self.turned),
        }
    }
}

impl fmt::Display for AskedLight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            LightKind::Sun(sun, turned) => write!(f, "sun:{sun}{turned}"),
            LightKind::Point { position: [x, y, z], power } => write!(f, "point:{x},{y},{z},{power}"),
            LightKind::Ies { file, position: [x, y, z], turned } => {
                write!(f, "ies:{}@{x},{y},{z}{turned}", file.display())
            }
        }
    }
}
