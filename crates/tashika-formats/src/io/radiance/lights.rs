//! Lights whose intensity depends on the direction: spotlights and luminaires.
//!
//! The surface of such a light is replaced by points on it. With the area `A` of the surface seen
//! from a direction `ω`, a point that stands for the share `w` of the surface has the intensity
//!
//! ```text
//! I(ω) = w L A(ω) p(ω)        (W·sr⁻¹)
//! ```
//!
//! for the radiance `L` of the material and its pattern `p`. For a spotlight `p` is 1 within the
//! cone around its direction, else 0. For a luminaire it is the value of the data times the
//! correction that `source.cal` makes:
//!
//! | correction | `p` for the value `v` |
//! |---|---|
//! | `corr` | `A₁ v` |
//! | `flatcorr` | `A₁ v / ω·n` |
//! | `boxcorr` | `A₁ v` over the area of a box `A₂ × A₃ × A₄` (m) seen from `ω` |
//! | `cylcorr` | the same for a cylinder of diameter `A₂` and height `A₃` (m) |
//!
//! Without its first argument, `A₁` is 1. These are the patterns that `ies2rad` writes.
//!
//! Source: Radiance, `source.cal`, and the reference manual, "Spotlight". Held to this by the tests
//! in `tests`.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec3, Mat3, Vec3};

use super::data::Grid;
use super::definitions::Definition;
use super::outlines::{Outline, outline};
use super::surfaces::Geometry;
use super::transforms::{Similarity, Transforms};
use super::words::Primitive;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::io::SceneFiles;
use crate::io::lights::{BYTES_OF_TEXEL, add_image_light};
use crate::io::limits::Budget;
use crate::math::elementary::{atan2_f64, sin_cos_f64};
use crate::scene::{
    Image, IntensityMap, Lookup, NoteKind, Pixels, Sampling, SceneBuilder, SphereMap, Spread, Wrap,
};

/// Focal length of a spotlight up to which it is a point (m); chosen.
pub(super) const SHORT: f64 = 0.01;

/// Columns and rows of the intensities of a light.
const SIZE: [u32; 2] = [360, 360];

/// Parts of a row, over which the rim of a spotlight is averaged.
const PARTS: u32 = 4;

/// Memory for intensities of all lights of a scene (bytes).
const MAX_BYTES: u64 = 1 << 30;

/// Directions into which a spotlight shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    /// Unit direction of its axis, in the coordinates of its file.
    axis: DVec3,
    /// Cosine of half of its angle.
    cos_half: f64,
    pub(super) focal_length: f64,
}

/// Correction of the value of a luminaire's data.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Correction {
    None,
    Flat,
    Box([f64; 3]),
    Cylinder([f64; 2]),
}

/// Intensities of a luminaire, relative to its radiance and area.
#[derive(Clone, Debug)]
pub(super) struct Luminaire {
    grid: Arc<Grid>,
    correction: Correction,
    factor: f64,
    /// Names of the coordinates of the data.
    coordinates: Vec<Coordinate>,
    /// Map from the coordinates of the pattern to those of its file.
    map: Similarity,
    /// Name of the file with the data.
    file: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Coordinate {
    Theta,
    Phi,
    /// `φ` folded at 180°.
    Phi2,
    /// `φ` folded at 90°.
    Phi4,
}

/// Dependence on the direction.
#[derive(Clone, Debug)]
pub(super) enum Pattern {
    Cone(Cone),
    Luminaire(Luminaire),
}

/// Reads the cone of a spotlight, whose arguments are `R G B angle x y z`.
///
/// # Errors
/// [`Error::Invalid`] for a direction of length 0 and an angle that is not above 0.
pub(super) fn cone(primitive: &Primitive, map: &Similarity, at: &Location) -> Result<Cone> {
    let (degrees, along) = (primitive.reals[3], DVec3::from_slice(&primitive.reals[4..]));
    let axis = map.direction(along).try_normalize().filter(|_| degrees > 0.0);
    let Some(axis) = axis else {
        let found = format!("a spotlight of {degrees}° along {along}");
        return Err(Error::invalid(at.clone(), found, "an angle above 0, and a direction"));
    };
    let cos_half = sin_cos_f64(0.5 * degrees.min(360.0).to_radians()).1;
    Ok(Cone { axis, cos_half, focal_length: along.length() * map.scale })
}

/// Reads a pattern as the data of a luminaire; none if it is another pattern.
///
/// # Errors
/// As [`Grid::read`].
pub(super) fn luminaire(definition: &Definition, files: &SceneFiles) -> Result<Option<Pattern>> {
    let Primitive { kind, strings, reals, .. } = &definition.primitive;
    let [function, file, calculation, rest @ ..] = &strings[..] else { return Ok(None) };
    if kind != "brightdata" || calculation != "source.cal" {
        return Ok(None);
    }
    let factor = reals.first().copied().unwrap_or(1.0);
    let correction = match (function.as_str(), &reals[..]) {
        ("corr", _) => Correction::None,
        ("flatcorr", _) => Correction::Flat,
        ("boxcorr", [_, x, y, z, ..]) => Correction::Box([*x, *y, *z]),
        ("cylcorr", [_, diameter, height, ..]) => Correction::Cylinder([*diameter, *height]),
        _ => return Ok(None),
    };
    let mut coordinates = Vec::new();
    for name in rest.iter().take_while(|word| !word.starts_with('-')) {
        coordinates.push(match name.as_str() {
            "src_theta" => Coordinate::Theta,
            "src_phi" => Coordinate::Phi,
            "src_phi2" => Coordinate::Phi2,
            "src_phi4" => Coordinate::Phi4,
            _ => return Ok(None),
        });
    }
    let (mut transforms, mut options) = (Transforms::default(), &rest[coordinates.len()..]);
    while !options.is_empty() {
        match transforms.option(options, &definition.at)? {
            0 => return Ok(None),
            taken => options = &options[taken..],
        }
    }
    let grid = Grid::read(file, coordinates.len(), files, &definition.at)?;
    let map = transforms.copy(0).0.then(&definition.map);
    let file = file.clone();
    Ok(Some(Pattern::Luminaire(Luminaire {
        grid: Arc::new(grid),
        correction,
        factor,
        coordinates,
        map,
        file,
    })))
}

impl Luminaire {
    /// Value of the pattern in a unit direction `ω` of its own coordinates, on a surface that is
    /// seen from there with the cosine `cos`.
    fn at(&self, direction: DVec3, cos: f64) -> f64 {
        let d = -direction;
        let theta = atan2_f64((d.x * d.x + d.y * d.y).sqrt(), d.z).to_degrees();
        let phi = atan2_f64(-d.y, -d.x).to_degrees().rem_euclid(360.0);
        let folded = |n: f64, at: f64| (at - (n - at).rem_euclid(2.0 * at)).abs();
        let place: Vec<f64> = self
            .coordinates
            .iter()
            .map(|coordinate| match coordinate {
                Coordinate::Theta => theta,
                Coordinate::Phi => phi,
                Coordinate::Phi2 => folded(phi, 180.0),
                Coordinate::Phi4 => folded(phi, 90.0),
            })
            .collect();
        let d = d.abs();
        let seen = match self.correction {
            Correction::None => 1.0,
            Correction::Flat => cos,
            Correction::Box([x, y, z]) => d.x * y * z + d.y * x * z + d.z * x * y,
            Correction::Cylinder([diameter, height]) => {
                let side = diameter * height * (1.0 - d.z * d.z).max(0.0).sqrt();
                side + 0.25 * PI * diameter * diameter * d.z
            }
        };
        if seen > 0.0 { self.factor * self.grid.at(&place) / seen } else { 0.0 }
    }
}

/// Key of an intensity map: pattern and outline.
type Key = (String, Vec<u64>, [i64; 4]);

/// Intensity maps of the scene's spotlights and luminaires.
pub(super) struct Points {
    maps: BTreeMap<Key, Option<Arc<IntensityMap>>>,
    budget: Budget,
}

impl Points {
    pub(super) fn new() -> Self {
        Self { maps: BTreeMap::new(), budget: Budget::new(MAX_BYTES, "intensities of lights") }
    }

    /// Adds the points of a surface with a light material of radiance `radiance`.
    pub(super) fn add(
        &mut self,
        name: &str,
        geometry: &Geometry,
        (radiance, pattern): (Rgb, &Pattern),
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<()> {
        let Some((area, outline, points)) = outline(geometry) else {
            let message = "spotlights and luminaires on surfaces other than polygons, rings, spheres and cylinders: left out";
            builder.note(NoteKind::Ignored, message, at.clone());
            return Ok(());
        };
        // The map has its pole, +y, along the pattern's z axis, or along the axis of the cone.
        let (frame, key) = match pattern {
            Pattern::Cone(cone) => {
                let x = cone.axis.any_orthonormal_vector();
                (
                    DMat3::from_cols(x, cone.axis, x.cross(cone.axis)),
                    (String::new(), vec![cone.cos_half.to_bits()]),
                )
            }
            Pattern::Luminaire(data) => {
                let turn = data.map.map.matrix3 * (1.0 / data.map.scale);
                let frame = turn * DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);
                (frame, (data.file.clone(), data.key()))
            }
        };
        let local = outline.turned(frame.transpose());
        let key = (key.0, key.1, local.key());
        let map = match self.maps.get(&key) {
            Some(known) => known.clone(),
            None => {
                let bytes = u64::from(SIZE[0]) * u64::from(SIZE[1]) * BYTES_OF_TEXEL;
                self.budget.take(bytes, at)?;
                let made = intensities(pattern, local).map(Arc::new);
                self.maps.insert(key, made.clone());
                made
            }
        };
        let Some(map) = map else { return Ok(()) };
        builder.begin_light(name);
        let columns = frame.to_cols_array().map(|v| v as f32);
        let to_world = Mat3::from_cols_array(&columns);
        let intensity = radiance * ((area / points.len() as f64) as f32);
        for point in points {
            add_image_light(builder, &map, (point, to_world), intensity, at.clone())?;
        }
        Ok(())
    }
}

impl Luminaire {
    fn key(&self) -> Vec<u64> {
        let (kind, sizes) = match self.correction {
            Correction::None => (0.0, [0.0; 3]),
            Correction::Flat => (1.0, [0.0; 3]),
            Correction::Box(sizes) => (2.0, sizes),
            Correction::Cylinder([d, h]) => (3.0, [d, h, 0.0]),
        };
        let coordinates = self.coordinates.iter().map(|c| f64::from(*c as u32));
        [self.factor, kind].into_iter().chain(sizes).chain(coordinates).map(f64::to_bits).collect()
    }
}

/// Intensities of a surface whose largest visible area is 1, in the frame of the map; none if they
/// are dark.
fn intensities(pattern: &Pattern, outline: Outline) -> Option<IntensityMap> {
    let [width, height] = SIZE;
    let value = |direction: DVec3| {
        let seen = outline.seen(direction);
        seen * match pattern {
            // The axis of the cone is the pole of the map.
            Pattern::Cone(cone) => f64::from(u8::from(direction.y >= cone.cos_half)),
            Pattern::Luminaire(data) => data.at(DVec3::new(direction.x, -direction.z, direction.y), seen),
        }
    };
    let texel = |i: u32| {
        let part = |k: u32| {
            let row = f64::from(i / width) + (f64::from(k) + 0.5) / f64::from(PARTS);
            let place = [(i % width) as f32 + 0.5, row as f32];
            let place = [place[0] / width as f32, place[1] / height as f32];
            let direction: Vec3 = SphereMap::LatLong.direction(place);
            value(direction.as_dvec3())
        };
        [((0..PARTS).map(part).sum::<f64>() / f64::from(PARTS)) as f32; 3]
    };
    let pixels = Pixels::Float((0..width * height).map(texel).collect());
    let image = Image { name: "light".to_owned(), width, height, pixels };
    let lookup = Lookup { sampling: Sampling::Bilinear, wrap: [Wrap::Repeat, Wrap::Clamp] };
    IntensityMap::new(image, Spread::Sphere(SphereMap::LatLong), lookup)
}
