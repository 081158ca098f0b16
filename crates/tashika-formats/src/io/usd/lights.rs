//! Lights: colour, strength and shape.
//!
//! The radiance of a light is
//!
//! ```text
//! L = color · intensity · 2^exposure · blackbody(colorTemperature) / sizeFactor
//! ```
//!
//! with the numbers unchanged: a nit counts as one W·m⁻²·sr⁻¹. The factor between the units is the
//! same for all lights of a scene and is left to exposure. `blackbody` has luminance 1.
//! `sizeFactor` is 1 unless `normalize` is on; then it is the light's area in squares of the
//! scene's unit, so that pictures do not depend on the length of the unit. For a distant light it
//! is `π sin²(angle / 2)`.
//!
//! | light | becomes |
//! |---|---|
//! | `RectLight`, `DiskLight` | a surface that shines along its `−z` |
//! | `SphereLight`, `CylinderLight` | a surface that shines outward |
//! | `SphereLight` as a point | a point or a spot of intensity `L A / 4`, with `A` its area |
//! | `DistantLight` | parallel light of irradiance `L π sin²(angle / 2)` |
//! | `DomeLight` | the environment |
//!
//! A cylinder has its axis along `x` and no ends. A `SphereLight` is a point if it has
//! `treatAsPoint`, a cone, a profile or no radius.
//!
//! Held to this by `usd_lights` of the suite.

use std::f32::consts::PI;

use glam::{DAffine3, DMat3, DVec3, Mat3, Vec3};

use super::Stage;
use super::features::met;
use super::prim::Prim;
use super::shapes::{unit_cylinder, unit_disk, unit_sphere};
use super::walk::{Placed, State};
use crate::color::Rgb;
use crate::color::spectrum::blackbody_rgb;
use crate::error::{Location, Result};
use crate::io::assets::reason;
use crate::io::images::Encoding;
use crate::io::lights::{NOT_FINITE, add_image_light};
use crate::io::{ies, shapes};
use crate::math::elementary::{powf, sin_cos};
use crate::scene::{
    ColorInput, Emission, Emitter, Environment, Falloff, FalloffShape, Material, MeshData, NoteKind, Surface,
};

/// Smallest difference between the cosines of the two angles between which a spot fades.
const MIN_FADING: f32 = 1e-4;

/// Note on lights without a direction.
const NO_DIRECTION: &str = "lights whose transform loses their direction: left out";

/// Radiance of a light.
struct Shine {
    /// Radiance before the division by the size factor.
    radiance: Rgb,
    is_normalized: bool,
}

impl Stage<'_> {
    /// Adds a light.
    pub fn add_light(
        &mut self,
        prim: &Prim,
        kind: &str,
        state: &State,
        placed: &mut Vec<Placed>,
    ) -> Result<()> {
        let at = self.at(prim);
        for name in ["inputs:diffuse", "inputs:specular"] {
            if self.number_or(prim, name, 1.0)? != 1.0 {
                met("light", name, self.at_property(prim, name), &mut self.builder)?;
            }
        }
        for (name, row) in [
            ("light:filters", "light:filters"),
            ("collection:lightLink:includes", "collection:lightLink"),
            ("collection:lightLink:excludes", "collection:lightLink"),
            ("collection:shadowLink:includes", "collection:lightLink"),
            ("collection:shadowLink:excludes", "collection:lightLink"),
        ] {
            if !self.targets(prim, name).is_empty() {
                met("light", row, self.at_property(prim, name), &mut self.builder)?;
            }
        }
        for link in ["collection:lightLink", "collection:shadowLink"] {
            let (root, expression) = (format!("{link}:includeRoot"), format!("{link}:membershipExpression"));
            let is_linked = self.number_or(prim, &root, 1.0)? == 0.0
                || self.word(prim, &expression)?.is_some_and(|words| !words.is_empty());
            if is_linked {
                met("light", "collection:lightLink", self.at_property(prim, &root), &mut self.builder)?;
            }
        }
        if self.tuple::<3>(prim, "inputs:shadow:color")?.is_some_and(|color| color != [0.0; 3]) {
            met("light", "inputs:shadow", self.at_property(prim, "inputs:shadow:color"), &mut self.builder)?;
        }
        let shine = self.shine(prim)?;
        let Some(radiance) = self.valid(shine.radiance, &at) else { return Ok(()) };
        let shine = Shine { radiance, ..shine };
        match kind {
            "DistantLight" => self.distant(prim, &shine, state),
            "DomeLight" | "DomeLight_1" => self.dome(prim, kind, &shine, state),
            "SphereLight" => self.sphere(prim, &shine, state, placed),
            kind => {
                if self.shaping(prim)?.is_some() {
                    met("light", "shaping of other lights", at, &mut self.builder)?;
                }
                self.area(prim, kind, &shine, state, placed)
            }
        }
    }

    /// Returns a radiance with negative channels replaced by 0, with a note. Returns none, with a
    /// note, if a channel is not finite, or if some are negative and none is positive.
    fn valid(&mut self, radiance: Rgb, at: &Location) -> Option<Rgb> {
        if radiance.is_valid() {
            return Some(radiance);
        }
        let positive = radiance.map(|v| v.max(0.0));
        let is_any = radiance.to_array().iter().all(|v| v.is_finite()) && !positive.is_black();
        let message = if is_any {
            "lights whose colour is partly below 0: 0 is used"
        } else {
            "lights of negative or infinite radiance: left out"
        };
        self.builder.note(NoteKind::Repaired, message, at.clone());
        is_any.then_some(positive)
    }

    /// An input of a light, by its current name or its former one.
    fn light_number(&mut self, prim: &Prim, name: &str, fallback: f64) -> Result<f64> {
        match self.number(prim, &format!("inputs:{name}"))? {
            Some(number) => Ok(number),
            None => self.number_or(prim, name, fallback),
        }
    }

    fn shine(&mut self, prim: &Prim) -> Result<Shine> {
        let is_distant = &*self.type_name(prim) == "DistantLight";
        let intensity = self.light_number(prim, "intensity", if is_distant { 50_000.0 } else { 1.0 })?;
        let exposure = self.light_number(prim, "exposure", 0.0)?;
        let color = match self.tuple::<3>(prim, "inputs:color")? {
            Some(color) => Some(color),
            None => self.tuple::<3>(prim, "color")?,
        };
        let mut radiance = Rgb::from(color.unwrap_or([1.0; 3]).map(|c| c as f32));
        radiance *= intensity as f32 * powf(2.0, exposure as f32);
        if self.light_number(prim, "enableColorTemperature", 0.0)? != 0.0 {
            let kelvin = self.light_number(prim, "colorTemperature", 6500.0)?.clamp(1000.0, 10_000.0);
            radiance *= blackbody_rgb(kelvin as f32).unwrap_or(Rgb::WHITE);
        }
        Ok(Shine { radiance, is_normalized: self.light_number(prim, "normalize", 0.0)? != 0.0 })
    }

    fn distant(&mut self, prim: &Prim, shine: &Shine, state: &State) -> Result<()> {
        if state.is_prototype {
            return met("light", "light of a prototype", self.at(prim), &mut self.builder);
        }
        let angle = self.light_number(prim, "angle", 0.53)?.clamp(0.0, 360.0) as f32;
        let (sin, _) = sin_cos(0.5 * angle.to_radians());
        let size = if angle <= 180.0 { PI * sin * sin } else { PI * (2.0 - sin * sin) };
        if angle > 0.0 {
            met("light", "inputs:angle", self.at(prim), &mut self.builder)?;
        }
        let irradiance =
            if shine.is_normalized || angle == 0.0 { shine.radiance } else { shine.radiance * size };
        let Some(direction) = self.axis(prim, state) else { return Ok(()) };
        self.builder.begin_light(&*prim.path);
        self.builder.add_emitter(Emitter::Directional { direction, irradiance })
    }

    /// Returns the direction of a light; none, with a note, if its transform has none.
    fn axis(&mut self, prim: &Prim, state: &State) -> Option<Vec3> {
        let axis = state.to_world.transform_vector3(DVec3::NEG_Z).try_normalize();
        if axis.is_none() {
            let at = self.at(prim);
            self.builder.note(NoteKind::Repaired, NO_DIRECTION, at);
        }
        axis.map(|axis| axis.as_vec3().normalize())
    }

    fn dome(&mut self, prim: &Prim, kind: &str, shine: &Shine, state: &State) -> Result<()> {
        let at = self.at(prim);
        if state.is_prototype {
            return met("light", "light of a prototype", at, &mut self.builder);
        }
        let texture = match self.asset(prim, "inputs:texture:file")? {
            Some(texture) => Some(texture),
            None => self.asset(prim, "texture:file")?,
        };
        let format = self.word(prim, "inputs:texture:format")?;
        let Some((file, layer)) = texture else {
            self.surroundings.constant += shine.radiance;
            return Ok(());
        };
        if !matches!(format.as_deref(), None | Some("automatic" | "latlong")) {
            met("light", "inputs:texture:format", at, &mut self.builder)?;
            self.surroundings.constant += shine.radiance;
            return Ok(());
        }
        if self.surroundings.map.is_some() {
            return met("light", "second DomeLight texture", at, &mut self.builder);
        }
        let place = self.at_property(prim, "inputs:texture:file");
        let Some(image) = self.picture_itself(&file, layer, &place)? else { return Ok(()) };
        // The pole of the map is the light's y axis, and the middle of the map is at z. If a
        // `DomeLight_1` has its pole at z, the middle is at −y.
        let pole = self.word(prim, "poleAxis")?;
        let is_z_up = match pole.as_deref() {
            Some("Y") => false,
            Some("Z") => true,
            _ => self.is_z_up,
        };
        let frame = if kind == "DomeLight_1" && is_z_up {
            Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y)
        } else {
            Mat3::IDENTITY
        };
        let Some(turn) = rotation(&state.to_world) else {
            self.builder.note(NoteKind::Repaired, NO_DIRECTION, at);
            return Ok(());
        };
        let half_turn = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, -1.0));
        self.surroundings.map = Some(Environment::lat_long(image, shine.radiance, turn * frame * half_turn));
        Ok(())
    }

    fn sphere(&mut self, prim: &Prim, shine: &Shine, state: &State, placed: &mut Vec<Placed>) -> Result<()> {
        let at = self.at(prim);
        let radius = self.light_number(prim, "radius", 0.5)?;
        let profile = match self.asset(prim, "inputs:shaping:ies:file")? {
            Some(profile) => Some(profile),
            None => self.asset(prim, "shaping:ies:file")?,
        };
        let is_point = self.is_true(prim, "treatAsPoint")?;
        let cone = self.shaping(prim)?;
        if !is_point && radius > 0.0 && profile.is_none() && cone.is_none() {
            return self.area(prim, "SphereLight", shine, state, placed);
        }
        if state.is_prototype {
            return met("light", "light of a prototype", at, &mut self.builder);
        }
        if profile.is_some() {
            met("light", "inputs:shaping:ies:file", at.clone(), &mut self.builder)?;
        } else if cone.is_some() {
            met("light", "inputs:shaping:cone:angle", at.clone(), &mut self.builder)?;
        }
        // A sphere of area A and radiance L has the intensity L A / 4. `normalize` divides the
        // radiance by the area in squares of the scene's unit, which leaves one such square in
        // place of `A`.
        let units = self.meters_per_unit * self.meters_per_unit;
        let area = if radius > 0.0 {
            area_of(&unit_sphere(&at)?, state.to_world.matrix3 * DMat3::from_diagonal(DVec3::splat(radius)))
        } else {
            units
        };
        let area = if shine.is_normalized || radius <= 0.0 { units } else { area };
        let intensity = shine.radiance * (0.25 * area) as f32;
        let centre = state.to_world.translation;
        let position = centre.as_vec3();
        if !(position.is_finite() && intensity.is_valid()) {
            self.builder.note(NoteKind::Repaired, NOT_FINITE, at);
            return Ok(());
        }
        self.builder.begin_light(&*prim.path);
        if let Some((file, layer)) = profile {
            let at = self.at_property(prim, "inputs:shaping:ies:file");
            let place = self.composer.layers.place(&file, layer);
            let map =
                self.composer.layers.read(&place, &at).and_then(|bytes| ies::decode(bytes.get(), &file, &at));
            let map = match map {
                Ok(Some(map)) => std::sync::Arc::new(map),
                Ok(None) => return Ok(()),
                Err(error) => {
                    let message =
                        format!("light profile {file:?} could not be read ({}): left out", reason(&error));
                    self.builder.note(crate::io::assets::kind(&error), message, at);
                    return Ok(());
                }
            };
            // Lamps point along −y in the map's frame, but along −z in USD.
            let frame = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y);
            let turn = rotation(&state.to_world).unwrap_or(Mat3::IDENTITY) * frame;
            return add_image_light(&mut self.builder, &map, (centre, turn), intensity, at);
        }
        match cone {
            Some(falloff) => {
                let Some(axis) = self.axis(prim, state) else { return Ok(()) };
                self.builder.add_emitter_at(Emitter::Spot { position, axis, intensity, falloff }, centre)
            }
            None => self.builder.add_emitter_at(Emitter::Point { position, intensity }, centre),
        }
    }

    /// Cone of a light, if its angle is below 180°.
    fn shaping(&mut self, prim: &Prim) -> Result<Option<Falloff>> {
        if self.light_number(prim, "shaping:focus", 0.0)? != 0.0 {
            met("light", "inputs:shaping:focus", self.at(prim), &mut self.builder)?;
        }
        // The default of the schema, if it is applied. Otherwise there is no cone.
        let usual = if self.has_schema(prim, "ShapingAPI") { 90.0 } else { 180.0 };
        let angle = self.light_number(prim, "shaping:cone:angle", usual)?;
        if angle >= 180.0 {
            return Ok(None);
        }
        let softness = self.light_number(prim, "shaping:cone:softness", 0.0)?.clamp(0.0, 1.0);
        let cos = |degrees: f64| sin_cos(degrees.to_radians() as f32).1;
        let cos_outer = cos(angle.max(0.0)).clamp(-1.0, 1.0 - MIN_FADING);
        let cos_inner = cos(angle.max(0.0) * (1.0 - softness)).clamp(cos_outer + MIN_FADING, 1.0);
        Ok(Some(Falloff { cos_inner, cos_outer, shape: FalloffShape::Smoothstep }))
    }

    /// Adds a light that is a surface.
    fn area(
        &mut self,
        prim: &Prim,
        kind: &str,
        shine: &Shine,
        state: &State,
        placed: &mut Vec<Placed>,
    ) -> Result<()> {
        let at = self.at(prim);
        let names: [(&str, f64); 2] = match kind {
            "RectLight" => [("width", 1.0), ("height", 1.0)],
            "CylinderLight" => [("radius", 0.5), ("length", 1.0)],
            _ => [("radius", 0.5); 2],
        };
        let Some([first, second]) = self.sizes(prim, "inputs:", names)? else { return Ok(()) };
        // The meshes face +z. Half a turn around y lets them shine along −z.
        let down = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0));
        let (data, to_light) = match kind {
            "RectLight" => {
                let mut data = shapes::rectangle();
                data.flip_v();
                (data, down * DMat3::from_diagonal(DVec3::new(0.5 * first, 0.5 * second, 1.0)))
            }
            "DiskLight" => (unit_disk(&at)?, down * DMat3::from_diagonal(DVec3::new(first, first, 1.0))),
            "CylinderLight" => {
                let along_x = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
                (unit_cylinder(&at)?, along_x * DMat3::from_diagonal(DVec3::new(first, first, 0.5 * second)))
            }
            _ => (unit_sphere(&at)?, DMat3::from_diagonal(DVec3::splat(first))),
        };
        let to_world = state.to_world * DAffine3::from_mat3(to_light);
        let mut factor = shine.radiance;
        if shine.is_normalized {
            let units = self.meters_per_unit * self.meters_per_unit;
            factor *= (units / area_of(&data, to_world.matrix3)) as f32;
        }
        if !factor.is_valid() {
            self.builder.note(NoteKind::Repaired, NOT_FINITE, at);
            return Ok(());
        }
        let texture = match self.asset(prim, "inputs:texture:file")? {
            Some((file, layer)) if kind == "RectLight" => {
                let place = self.at_property(prim, "inputs:texture:file");
                self.whole_texture(&file, layer, Encoding::Srgb, &place)?
            }
            _ => None,
        };
        let emission = Emission { radiance: ColorInput { factor, texture }, two_sided: false };
        let surface = Surface::Lambert { reflectance: Rgb::BLACK.into() };
        let material = Material { emission: Some(emission), ..Material::new(prim.path.to_string(), surface) };
        let material = self.builder.add_material(material)?;
        let mesh = self.builder.add_mesh(MeshData { name: prim.path.to_string(), ..data }, material)?;
        placed.push(Placed { object: prim.path.clone(), mesh, to_world });
        Ok(())
    }
}

/// Rotation of a transform: its axes, made orthonormal in an order that keeps the direction of the
/// third.
fn rotation(to_world: &DAffine3) -> Option<Mat3> {
    let axes = to_world.matrix3;
    let z = axes.z_axis.try_normalize()?;
    let y = (axes.y_axis - z * axes.y_axis.dot(z)).try_normalize()?;
    let x = (axes.x_axis - z * axes.x_axis.dot(z) - y * axes.x_axis.dot(y)).try_normalize()?;
    Some(DMat3::from_cols(x, y, z).as_mat3())
}

/// Area of a mesh after a linear map.
fn area_of(mesh: &MeshData, map: DMat3) -> f64 {
    let corner = |i: u32| map * mesh.positions[i as usize].as_dvec3();
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(corner);
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles.iter().map(of).sum()
}
