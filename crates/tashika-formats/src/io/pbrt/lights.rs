//! `LightSource` and `AreaLightSource`.
//!
//! With `L`, `I` and `scale` as the file gives them:
//!
//! ```text
//! point, spot     intensity   I · scale           · power / 4π,  power / ∫ falloff dω
//! distant         irradiance  L · scale           · illuminance
//! infinite        radiance    L · scale · map     · illuminance / π
//! diffuse         radiance    L · scale           · power / (π · area · sides)
//! ```
//!
//! The last factor applies in pbrt-v4 if its parameter is given. Latitude-longitude maps of pbrt-v3
//! have their pole at `+z` and `u = 0` at `+x`, turning towards `+y`. Octahedral maps of pbrt-v4
//! have the scene's own convention (Clarberg 2008). Constant environments add up; there is at most
//! one environment map.
//!
//! Source: Pharr et al. 2023, chapter 12; the format descriptions. Tested by
//! `suite::pbrt_appearance::lights_*`.

use glam::{DAffine3, DVec3, Mat3, Vec3};

use super::image_lights;
use super::loading::Loading;
use super::parameters::{Kind, Parameters};
use super::spectra::{self, Quantity};
use super::version::Version;
use crate::color::Rgb;
use crate::error::Result;
use crate::io::images::Encoding;
use crate::io::lights::{NOT_FINITE, Surroundings};
use crate::math::elementary::sin_cos;
use crate::scene::{ColorInput, Emitter, Environment, Falloff, FalloffShape, NoteKind};

/// Solid angle of the sphere (sr).
pub(super) const FOUR_PI: f32 = 4.0 * std::f32::consts::PI;

/// Range that half-angles of spots are clamped to (degrees). `LEAST_FADE` is the least difference
/// between the outer and the inner one.
const CONE: (f32, f32) = (0.1, 179.0);
const LEAST_FADE: f32 = 0.05;

/// Frame of the scene's latitude-longitude images to pbrt-v3's: `+y ↦ +z`, `+z ↦ +x`, `+x ↦ −y`.
pub(super) const LAT_LONG_OF_PBRT: Mat3 = Mat3::from_cols(Vec3::NEG_Y, Vec3::Z, Vec3::X);

/// Emission of a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct AreaLight {
    /// Radiance before the factor of `power`.
    pub(super) radiance: ColorInput,
    /// True if both sides emit.
    pub(super) two_sided: bool,
    /// Total power of the shape (W), if given.
    pub(super) power: Option<f32>,
}

/// `AreaLightSource class`.
pub(super) fn area_light(
    loading: &mut Loading<'_>,
    class: &str,
    p: &Parameters,
) -> Result<Option<AreaLight>> {
    let class = if class == "area" { "diffuse" } else { class };
    loading.met("area light", class, "left out", &p.at())?;
    if class != "diffuse" {
        return Ok(None);
    }
    p.accept(&["nsamples", "samples"]);
    let factor = colored(loading, p, "L")? * scale(loading, p)?;
    let mut radiance = ColorInput::from(factor);
    if loading.version == Version::V4
        && let Some(name) = p.string("filename")
    {
        let at = p.place_of("filename");
        if let Some(image) = loading.images.load(name, Encoding::Srgb, &at, &mut loading.builder)? {
            let texture = loading.builder.add_texture(image.texture(|all| all))?;
            radiance.texture = Some(texture);
        }
    }
    let power = if loading.version == Version::V4 { p.float("power").filter(|&p| p > 0.0) } else { None };
    let two_sided = p.boolean("twosided").unwrap_or(false);
    loading.note_unused("area light", "diffuse", p)?;
    Ok(Some(AreaLight { radiance, two_sided, power }))
}

/// `LightSource class`, placed by `to_world`.
pub(super) fn light(
    loading: &mut Loading<'_>,
    class: &str,
    p: &Parameters,
    to_world: &DAffine3,
    sky: &mut Surroundings,
) -> Result<()> {
    // pbrt-v2 also has `exinfinite` as a name of `infinite`.
    let class = if class == "exinfinite" { "infinite" } else { class };
    loading.met("light", class, "left out", &p.at())?;
    p.accept(&["nsamples", "samples"]);
    match class {
        "point" => {
            let intensity = intensity(loading, p, FOUR_PI)?;
            let place = point(to_world, p.vector("from").unwrap_or(DVec3::ZERO));
            add(loading, p, Emitter::Point { position: place.as_vec3(), intensity }, place)?;
        }
        "spot" => spot(loading, p, to_world)?,
        "distant" => {
            let mut irradiance = colored(loading, p, "L")? * scale(loading, p)?;
            if let Some(illuminance) = positive(p, "illuminance", loading.version) {
                irradiance *= illuminance;
            }
            let from = p.vector("from").unwrap_or(DVec3::ZERO);
            let to = p.vector("to").unwrap_or(DVec3::Z);
            let direction = direction(loading, p, to_world, to - from);
            add(loading, p, Emitter::Directional { direction, irradiance }, DVec3::ZERO)?;
        }
        "infinite" => infinite(loading, p, to_world, sky)?,
        "goniometric" => image_lights::goniometric(loading, p, to_world)?,
        "projection" => image_lights::projection(loading, p, to_world)?,
        _ => return Ok(()),
    }
    loading.note_unused("light", class, p)
}

/// Adds an emitter at a position, if position and colour are finite.
pub(super) fn add(loading: &mut Loading<'_>, p: &Parameters, emitter: Emitter, place: DVec3) -> Result<()> {
    let (position, color) = match emitter {
        Emitter::Point { position, intensity } | Emitter::Spot { position, intensity, .. } => {
            (position, intensity)
        }
        Emitter::Image { position, intensity, .. } => (position, intensity),
        Emitter::Directional { irradiance, .. } => (Vec3::ZERO, irradiance),
    };
    if !position.is_finite() || !color.is_finite() {
        loading.note(NoteKind::Repaired, NOT_FINITE, p.at());
        return Ok(());
    }
    loading.builder.add_emitter_at(emitter, place)
}

fn spot(loading: &mut Loading<'_>, p: &Parameters, to_world: &DAffine3) -> Result<()> {
    let outer = p.float("coneangle").unwrap_or(30.0).clamp(CONE.0 + LEAST_FADE, CONE.1);
    let fade = p.float("conedeltaangle").unwrap_or(5.0).max(LEAST_FADE);
    let shape = match loading.version {
        Version::V4 => FalloffShape::Smoothstep,
        Version::V3 => FalloffShape::Fourth,
    };
    let falloff = falloff(outer, (outer - fade).max(0.0), shape);
    let from = p.vector("from").unwrap_or(DVec3::ZERO);
    let to = p.vector("to").unwrap_or(DVec3::Z);
    let intensity = intensity(loading, p, falloff.solid_angle())?;
    let place = point(to_world, from);
    let position = place.as_vec3();
    let axis = direction(loading, p, to_world, to - from);
    add(loading, p, Emitter::Spot { position, axis, intensity, falloff }, place)
}

/// Fall-off between two angles from the axis (degrees).
fn falloff(outer: f32, inner: f32, shape: FalloffShape) -> Falloff {
    let cos = |degrees: f32| sin_cos(degrees.to_radians()).1;
    let cos_inner = cos(inner);
    Falloff { cos_inner, cos_outer: cos(outer).min(cos_inner.next_down()), shape }
}

fn infinite(
    loading: &mut Loading<'_>,
    p: &Parameters,
    to_world: &DAffine3,
    sky: &mut Surroundings,
) -> Result<()> {
    let radiance = colored(loading, p, "L")? * scale(loading, p)?;
    let illuminance = positive(p, "illuminance", loading.version);
    let name = match loading.version {
        Version::V3 => p.string("mapname"),
        Version::V4 => p.string("filename"),
    };
    if p.find(&[Kind::Point3], "portal").is_some() {
        loading.note(NoteKind::Ignored, "portals of infinite lights: the whole map shines", p.at());
    }
    let Some(name) = name.filter(|name| !name.is_empty()) else {
        sky.constant += radiance * illuminance.map_or(1.0, |e| e / std::f32::consts::PI);
        return Ok(());
    };
    if illuminance.is_some() {
        loading.note(
            NoteKind::Ignored,
            "illuminance of infinite lights with a map: the map as it is",
            p.at(),
        );
    }
    let at = p.at();
    if sky.map.is_some() {
        loading.note(NoteKind::Ignored, "further maps of infinite lights: left out", at);
        return Ok(());
    }
    let named = p.place_of(if loading.version == Version::V3 { "mapname" } else { "filename" });
    let image = loading.images.read(name, Encoding::Srgb, &named, &mut loading.builder)?;
    let Some(image) = image else {
        let message = "infinite lights whose map cannot be read: a constant of their L";
        loading.note(NoteKind::Repaired, message, at);
        sky.constant += radiance;
        return Ok(());
    };
    let turn = orthonormal(loading, p, to_world);
    let square = image.width == image.height;
    sky.map = Some(if loading.version == Version::V4 && square {
        Environment::octahedral(image, radiance, turn)
    } else {
        if loading.version == Version::V4 {
            let message = "maps of infinite lights that are not square: taken as latitude-longitude ones";
            loading.note(NoteKind::Repaired, message, p.at());
        }
        Environment::lat_long(image, radiance, turn * LAT_LONG_OF_PBRT)
    });
    Ok(())
}

/// Rotation or reflection of a transform, without its scale.
pub(super) fn orthonormal(loading: &mut Loading<'_>, p: &Parameters, to_world: &DAffine3) -> Mat3 {
    let m = to_world.matrix3;
    let frame = m.x_axis.try_normalize().and_then(|x| {
        let y = (m.y_axis - x * x.dot(m.y_axis)).try_normalize()?;
        let z = x.cross(y);
        Some((x, y, if z.dot(m.z_axis) < 0.0 { -z } else { z }))
    });
    match frame.filter(|(x, y, z)| x.is_finite() && y.is_finite() && z.is_finite()) {
        Some((x, y, z)) => Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()),
        None => {
            let message = "infinite lights with a transform that cannot be inverted: not turned";
            loading.note(NoteKind::Repaired, message, p.at());
            Mat3::IDENTITY
        }
    }
}

/// Colour of a light, 1 by default.
pub(super) fn colored(loading: &mut Loading<'_>, p: &Parameters, name: &str) -> Result<Rgb> {
    Ok(spectra::color(loading, p, name, Quantity::Light)?.unwrap_or(Rgb::WHITE))
}

/// `scale`: a number, or in pbrt-v3 a colour.
pub(super) fn scale(loading: &mut Loading<'_>, p: &Parameters) -> Result<Rgb> {
    if let Some(scale) = p.float("scale") {
        if scale < 0.0 {
            loading.note(NoteKind::Repaired, "negative scales of lights: 0", p.at());
        }
        return Ok(Rgb::gray(scale.max(0.0)));
    }
    Ok(spectra::color(loading, p, "scale", Quantity::Factor)?.unwrap_or(Rgb::WHITE))
}

/// Returns `I · scale`, times `power` over `solid_angle` if that is given.
pub(super) fn intensity(loading: &mut Loading<'_>, p: &Parameters, solid_angle: f32) -> Result<Rgb> {
    let intensity = colored(loading, p, "I")? * scale(loading, p)?;
    let power = positive(p, "power", loading.version);
    Ok(intensity * power.map_or(1.0, |power| power / solid_angle))
}

/// Value of a parameter of pbrt-v4, if it is above 0.
pub(super) fn positive(p: &Parameters, name: &str, version: Version) -> Option<f32> {
    if version == Version::V4 { p.float(name).filter(|&value| value > 0.0) } else { None }
}

pub(super) fn point(to_world: &DAffine3, p: DVec3) -> DVec3 {
    to_world.transform_point3(p)
}

/// Unit vector in the world; `+z`, with a note, if `local` has no direction there.
fn direction(loading: &mut Loading<'_>, p: &Parameters, to_world: &DAffine3, local: DVec3) -> Vec3 {
    let found = to_world.transform_vector3(local).try_normalize().map(|d| d.as_vec3().normalize());
    found.filter(|d| d.is_finite()).unwrap_or_else(|| {
        loading.note(NoteKind::Repaired, "lights without direction: along +z", p.at());
        Vec3::Z
    })
}
