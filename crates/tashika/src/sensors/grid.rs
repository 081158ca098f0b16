//! Grids of sensors: over an object of a scene, or over a rectangle.
//!
//! ```text
//! OBJECT:SPACING[,height=H][,up=z]                    over the faces of an object that look up
//! X0,Y0,Z0..X1,Y1,Z1:SPACING[,height=H]               over a rectangle at right angles to an axis
//! ```
//!
//! The sensors of a grid are `SPACING` metres apart, in rows along two axes, with equal margins on
//! opposite sides. Over an object, a sensor is `H` metres (default 0) above each grid point at
//! which a vertical line meets a face of the object whose normal points up (any face, if there is
//! none); its own normal is vertical. Up is `+y`, or `+z` with `up=z`. Over a rectangle, the normal
//! is the positive axis, along which a sensor is `H` metres from the rectangle.
//!
//! # Held to this by
//! The tests below.

use std::str::FromStr;

use glam::{DVec3, Vec3};

use crate::accel::Tracer;
use crate::error::{Error, Result, nearest_name};
use crate::math::{Aabb, Ray};
use crate::scene::{InstanceId, Scene, SensorPoint};

/// Most grid points.
const MAX_POINTS: f64 = 4_194_304.0;
/// Most surfaces that a vertical line passes before it meets the object.
const MAX_PASSED: u32 = 256;
/// Syntax of a grid, for messages.
const FORMS: &str = "OBJECT:SPACING[,height=H][,up=z] or X0,Y0,Z0..X1,Y1,Z1:SPACING[,height=H]";

/// Surface that a grid lies over.
#[derive(Clone, Debug, PartialEq)]
pub enum GridOver {
    /// Faces of the object of this name that look up.
    Object(String),
    /// Rectangle with these opposite corners (m), equal in one coordinate.
    Rectangle([DVec3; 2]),
}

/// Grid of sensors that a user asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorGridRequest {
    /// Surface below the grid.
    pub over: GridOver,
    /// Distance between neighbouring sensors (m), above 0.
    pub spacing: f64,
    /// Distance of the sensors from the surface (m).
    pub height: f64,
    /// True if `+z` is up, rather than `+y`.
    pub z_is_up: bool,
}

impl SensorGridRequest {
    /// Returns the sensors of the grid in the scene of a tracer, row by row.
    ///
    /// # Errors
    /// [`Error::Option`] if no object has the name, if no face of it looks up at a grid point, or
    /// if there are more than four million grid points.
    pub fn points(&self, tracer: &Tracer) -> Result<Vec<SensorPoint>> {
        let scene = tracer.scene();
        match &self.over {
            GridOver::Rectangle(corners) => self.over_rectangle(*corners),
            GridOver::Object(name) => {
                let of_object: Vec<InstanceId> =
                    scene.instance_ids().filter(|id| scene.object_name(*id) == name).collect();
                if of_object.is_empty() {
                    return Err(unknown(scene, name));
                }
                self.over_object(tracer, name, &of_object)
            }
        }
    }

    fn over_rectangle(&self, [a, b]: [DVec3; 2]) -> Result<Vec<SensorPoint>> {
        let (lo, hi) = (a.min(b), a.max(b));
        let size = hi - lo;
        let axis = size.min_position();
        let normal = DVec3::AXES[axis];
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let [along, across] = [u, v].map(|k| self.steps(lo[k], hi[k]));
        self.check_count(along.len() as f64 * across.len() as f64)?;
        let mut points = Vec::with_capacity(along.len() * across.len());
        for y in &across {
            for x in &along {
                let mut position = lo + normal * self.height;
                (position[u], position[v]) = (*x, *y);
                points.push(SensorPoint::plane(position, normal));
            }
        }
        Ok(points)
    }

    fn over_object(&self, tracer: &Tracer, name: &str, object: &[InstanceId]) -> Result<Vec<SensorPoint>> {
        let scene = tracer.scene();
        let up = usize::from(self.z_is_up) + 1;
        let [u, v] = if self.z_is_up { [0, 1] } else { [0, 2] };
        let bounds = object.iter().fold(Aabb::EMPTY, |bounds, id| bounds.union(bounds_of(scene, *id)));
        let [along, across] = [u, v].map(|k| self.steps(bounds.lo[k].into(), bounds.hi[k].into()));
        self.check_count(along.len() as f64 * across.len() as f64)?;
        let normal = DVec3::AXES[up];
        let over = |turned: Turned| {
            let mut points = Vec::new();
            for y in &across {
                for x in &along {
                    let mut from = bounds.hi;
                    (from[u], from[v]) = (*x as f32, *y as f32);
                    from[up] += bounds.diagonal().max(1.0) * CLEARANCE;
                    let ray = Ray::new(from, -normal.as_vec3());
                    if let Some(place) = below(tracer, ray, object, turned) {
                        let position = scene.place_in_file(place) + normal * self.height;
                        points.push(SensorPoint::plane(position, normal));
                    }
                }
            }
            points
        };
        let mut points = over(Turned::Up);
        if points.is_empty() {
            // Many files have floors whose normals point down.
            points = over(Turned::Any);
        }
        if points.is_empty() {
            let expected = format!("an object with faces that look up, at points {} m apart", self.spacing);
            return Err(Error::option("grid", name, expected));
        }
        Ok(points)
    }

    fn check_count(&self, count: f64) -> Result<()> {
        if count <= MAX_POINTS {
            return Ok(());
        }
        Err(Error::option("grid", format!("{count} points"), format!("at most {MAX_POINTS}")))
    }

    /// Coordinates between two ends, `spacing` apart, in the middle of the ends; at least one, and
    /// no more than one axis may have.
    fn steps(&self, lo: f64, hi: f64) -> Vec<f64> {
        let count = ((hi - lo) / self.spacing + ROUNDING).floor().clamp(1.0, MAX_POINTS + 1.0);
        let first = 0.5 * (lo + hi) - 0.5 * (count - 1.0) * self.spacing;
        (0..count as u64).map(|k| first + k as f64 * self.spacing).collect()
    }
}

/// Share of a step by which an extent may be shorter than a whole number of steps.
const ROUNDING: f64 = 1e-6;
/// Distance above the box of an object at which vertical lines begin, as a share of its diagonal.
const CLEARANCE: f32 = 1e-3;

/// Orientation of the faces that a grid lies over.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Turned {
    /// Faces whose normals point up, so that a ceiling is passed from behind.
    Up,
    /// All faces.
    Any,
}

/// Returns the point at which a vertical line first meets a face of an object from above.
fn below(tracer: &Tracer, mut ray: Ray, object: &[InstanceId], turned: Turned) -> Option<Vec3> {
    for _ in 0..MAX_PASSED {
        let hit = tracer.closest_hit(&ray, 0)?;
        let surface = tracer.scene().surface_point(hit.instance, hit.triangle, hit.barycentric);
        let looks_up = surface.geometric_normal.dot(ray.direction) < 0.0;
        if object.contains(&hit.instance) && (looks_up || turned == Turned::Any) {
            return Some(surface.position);
        }
        ray = Ray::new(surface.leave(ray.direction), ray.direction);
    }
    None
}

/// Box of an instance (m).
fn bounds_of(scene: &Scene, id: InstanceId) -> Aabb {
    let instance = &scene.instances()[id.index()];
    let corners = scene.mesh_of(id).positions();
    Aabb::of_points(corners.iter().map(|corner| instance.to_world.transform_point3(*corner)))
}

/// Most names of objects that a message lists.
const LISTED: usize = 12;

/// Error for a name that no object has.
fn unknown(scene: &Scene, name: &str) -> Error {
    let mut names: Vec<&str> = scene.instance_ids().map(|id| scene.object_name(id)).collect();
    names.sort_unstable();
    names.dedup();
    let expected = match nearest_name(name, names.iter().copied()) {
        Some(near) => format!("the name of an object, such as {near}"),
        None if names.len() <= LISTED => format!("the name of an object: {}", names.join(", ")),
        None => format!("the name of one of the scene's {} objects, such as {}", names.len(), names[0]),
    };
    Error::option("grid", name, expected)
}

impl FromStr for SensorGridRequest {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = |why: &str| Error::option("grid", text, format!("{FORMS} ({why})"));
        let (over, options) = text.rsplit_once(':').ok_or_else(|| wrong("no spacing"))?;
        let mut options = options.split(',');
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        let spacing = options.next().and_then(|text| number(text.trim_end_matches('m')));
        let spacing = spacing.filter(|spacing| *spacing > 0.0).ok_or_else(|| wrong("a spacing above 0 m"))?;
        let (mut height, mut z_is_up) = (0.0, false);
        for option in options {
            match option.split_once('=') {
                Some(("height", value)) => {
                    height =
                        number(value.trim_end_matches('m')).ok_or_else(|| wrong("a height in metres"))?;
                }
                Some(("up", axis @ ("y" | "z"))) => z_is_up = axis == "z",
                _ => return Err(wrong("height=H and up=z alone")),
            }
        }
        let corner = |text: &str| -> Option<DVec3> {
            let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
            <[f64; 3]>::try_from(numbers?).ok().map(DVec3::from)
        };
        let over = match over.split_once("..").map(|(a, b)| (corner(a), corner(b))) {
            Some((Some(a), Some(b))) => {
                if (a - b).abs().min_element() > 0.0 {
                    return Err(wrong("corners that are equal in one coordinate"));
                }
                GridOver::Rectangle([a, b])
            }
            _ if over.is_empty() => return Err(wrong("no object")),
            _ => GridOver::Object(over.to_owned()),
        };
        Ok(Self { over, spacing, height, z_is_up })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::color::Rgb;
    use crate::error::Location;
    use crate::scene::{Material, MeshData, SceneBuilder, Surface};

    fn request(text: &str) -> SensorGridRequest {
        text.parse().unwrap()
    }

    /// A grid over a closed object, whose ceiling has normals that point down, lies over its floor.
    #[test]
    fn ceilings_are_passed_from_behind() {
        let mut b = SceneBuilder::new("room", Location::default());
        let grey = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
        let material = b.add_material(Material::new("grey", grey)).unwrap();
        let corners = [[0.0, 0.0], [0.0, 2.0], [2.0, 2.0], [2.0, 0.0]];
        let at = |height: f32| corners.map(move |[x, z]| Vec3::new(x, height, z));
        let positions: Vec<Vec3> = at(0.0).into_iter().chain(at(2.5)).collect();
        let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]];
        let data = MeshData { name: "room".into(), positions, triangles, ..MeshData::default() };
        let mesh = b.add_mesh(data, material).unwrap();
        b.add_instance(mesh, glam::Affine3A::IDENTITY).unwrap();
        let tracer = Tracer::new(Arc::new(b.build().unwrap()));
        let points = request("room:1,height=0.5").points(&tracer).unwrap();
        assert!(points.len() == 4 && points.iter().all(|p| (p.position.y - 0.5).abs() < 1e-5), "{points:?}");
    }

    /// A floor of 4 m × 3 m at `y = 0`, a desk above one half of it, and a ceiling.
    fn room() -> Tracer {
        let mut b = SceneBuilder::new("room", Location::default());
        let grey = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
        let material = b.add_material(Material::new("grey", grey)).unwrap();
        for (name, width, height) in [("floor", 4.0, 0.0), ("desk", 2.0, 0.75), ("ceiling", 4.0, 2.5)] {
            let positions = [[0.0, 0.0], [0.0, 3.0], [width, 3.0], [width, 0.0]];
            let positions = positions.map(|[x, z]| Vec3::new(x, height, z)).to_vec();
            let triangles = vec![[0, 1, 2], [0, 2, 3]];
            let data = MeshData { name: name.into(), positions, triangles, ..MeshData::default() };
            let mesh = b.add_mesh(data, material).unwrap();
            b.add_instance(mesh, glam::Affine3A::IDENTITY).unwrap();
        }
        Tracer::new(Arc::new(b.build().unwrap()))
    }

    /// The grid over the floor is below the desk and the ceiling, and that over the desk is half as
    /// large.
    #[test]
    fn grids_lie_over_objects() {
        let tracer = room();
        let points = request("floor:0.5,height=0.8").points(&tracer).unwrap();
        assert_eq!(points.len(), 8 * 6);
        assert!(points.iter().all(|p| (p.position.y - 0.8).abs() < 1e-5 && p.normal == DVec3::Y));
        assert!((points[0].position.x - 0.25).abs() < 1e-6 && (points[0].position.z - 0.25).abs() < 1e-6);
        let of_desk = request("desk:0.5m").points(&tracer).unwrap();
        assert_eq!(of_desk.len(), 4 * 6);
        assert!(of_desk.iter().all(|p| (p.position.y - 0.75).abs() < 1e-5));
        let message = request("flor:0.5").points(&tracer).unwrap_err().to_string();
        assert!(message.contains("such as floor"), "{message}");
        let message = request("floor:0.0001").points(&tracer).unwrap_err().to_string();
        assert!(message.contains("at most 4194304"), "{message}");
    }

    #[test]
    fn grids_lie_over_rectangles() {
        let tracer = room();
        let points = request("0,1,0..4,1,3:1,height=0.5").points(&tracer).unwrap();
        assert_eq!(points.len(), 12);
        assert!(points.iter().all(|p| p.normal == DVec3::Y && p.position.y == 1.5));
        let wall = request("1,0,-1..1,2,1:0.8").points(&tracer).unwrap();
        assert_eq!(wall.len(), 4);
        assert!(wall.iter().all(|p| p.normal == DVec3::X && (p.position.y - 1.0).abs() < 0.41));
    }

    #[test]
    fn wrong_grids_are_refused_with_their_forms() {
        for (text, why) in [
            ("floor", "no spacing"),
            ("floor:0", "a spacing above 0 m"),
            ("floor:x", "a spacing above 0 m"),
            (":1", "no object"),
            ("floor:1,depth=2", "height=H and up=z alone"),
            ("floor:1,height=x", "a height in metres"),
            ("0,0,0..1,1,1:1", "equal in one coordinate"),
        ] {
            let message = text.parse::<SensorGridRequest>().unwrap_err().to_string();
            assert!(message.contains(FORMS) && message.contains(why), "{text}: {message}");
        }
    }
}
