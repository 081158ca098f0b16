//! Geometry of surfaces: polygons to triangles, quadrics to instances of shared meshes.
//!
//! | surface | arguments | normal |
//! |---|---|---|
//! | polygon | corners | the corners run counter-clockwise around it |
//! | sphere, bubble | centre, radius | outward; inward |
//! | cone, cup | two ends, two radii | outward; inward |
//! | cylinder, tube | two ends, radius | outward; inward |
//! | ring | centre, normal, two radii | as given |
//!
//! Polygons of the same name and material are one mesh. Quadrics are instances of a mesh of size 1,
//! which all quadrics of the same shape and material share.
//!
//! Where Radiance warns and leaves a surface out, it is left out with a note: radii of zero, axes
//! and normals without direction, polygons without area. A negative radius turns a sphere or
//! cylinder inside out, as there.
//!
//! Source: the Radiance reference manual, "Surfaces". Held to this by the tests in `tests`.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::holes;
use super::transforms::Similarity;
use super::words::Primitive;
use crate::error::{Error, Location, Result};
use crate::io::polygon::{Coverage, Triangulator, double_area};
use crate::io::shapes;
use crate::scene::{Interface, MaterialId, MeshData, MeshId, NoteKind, SceneBuilder};

/// Angle of a surface of revolution (radians).
const TURN: f32 = std::f32::consts::TAU;

/// Shape of a quadric, of size 1 around the z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Quadric {
    Sphere,
    Cylinder,
    /// Radii at the heights 0 and 1, the larger of which is 1.
    Cone([f32; 2]),
    /// Inner radius; the outer one is 1.
    Ring(f32),
}

/// Geometry of a surface in the world.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Geometry {
    /// Corners, counter-clockwise around the normal (m).
    Polygon(Vec<DVec3>),
    Quadric {
        shape: Quadric,
        to_world: DAffine3,
        faces_inward: bool,
    },
}

impl Quadric {
    /// Mesh of the shape, with normals outward, or up for a ring.
    pub(super) fn mesh(self, at: &Location) -> Result<MeshData> {
        match self {
            Self::Sphere => shapes::sphere(1.0, [-1.0, 1.0], TURN, at),
            Self::Cylinder => shapes::cylinder(1.0, [0.0, 1.0], TURN, at),
            Self::Cone([bottom, top]) => {
                shapes::hyperboloid([Vec3::new(bottom, 0.0, 0.0), Vec3::new(top, 0.0, 1.0)], TURN, at)
            }
            Self::Ring(inner) => shapes::disk(0.0, 1.0, inner, TURN, at),
        }
    }

    /// Number that is equal for equal shapes only.
    fn key(self) -> [u32; 3] {
        match self {
            Self::Sphere => [0, 0, 0],
            Self::Cylinder => [1, 0, 0],
            Self::Cone([bottom, top]) => [2, bottom.to_bits(), top.to_bits()],
            Self::Ring(inner) => [3, inner.to_bits(), 0],
        }
    }
}

/// Reads the geometry of a surface that is not a `source`; none, with a note, if it has no area.
///
/// # Errors
/// [`Error::Invalid`] for a wrong number of arguments.
pub(super) fn geometry(
    primitive: &Primitive,
    map: &Similarity,
    inverts: bool,
    at: &Location,
    builder: &mut SceneBuilder,
) -> Result<Option<Geometry>> {
    let reals = &primitive.reals[..];
    let kind = primitive.kind.as_str();
    let point = |k: usize| DVec3::from_slice(&reals[k..]);
    let mut leave_out = |why: &str| {
        builder.note(NoteKind::Repaired, format!("{kind}s with {why}: left out"), at.clone());
        Ok(None)
    };
    let expected = match kind {
        "polygon" => {
            if reals.len() < 9 || !reals.len().is_multiple_of(3) {
                let found = format!("a polygon of {} numbers", reals.len());
                return Err(Error::invalid(
                    at.clone(),
                    found,
                    "three for each corner, and at least three corners",
                ));
            }
            0
        }
        "sphere" | "bubble" => 4,
        "cylinder" | "tube" => 7,
        _ => 8,
    };
    check_count(primitive, expected, at)?;
    let is_inner = matches!(kind, "bubble" | "cup" | "tube");
    let (shape, local, is_inner) = match kind {
        "polygon" => {
            let mut corners: Vec<DVec3> =
                reals.chunks_exact(3).map(|p| map.point(DVec3::from_slice(p))).collect();
            // The normal is mirrored as a vector is, so that the order of corners changes.
            if map.mirrors() != inverts {
                corners.reverse();
            }
            let first = corners[0];
            let relative: Vec<Vec3> = corners.iter().map(|p| (p - first).as_vec3()).collect();
            if double_area(&relative) == DVec3::ZERO {
                return leave_out("no area");
            }
            return Ok(Some(Geometry::Polygon(corners)));
        }
        "sphere" | "bubble" => {
            let radius = reals[3];
            if radius == 0.0 {
                return leave_out("a radius of 0");
            }
            let local = scaled(point(0), DMat3::IDENTITY, DVec3::splat(radius.abs()));
            (Quadric::Sphere, local, is_inner != (radius < 0.0))
        }
        "cylinder" | "tube" => {
            let (radius, along) = (reals[6], point(3) - point(0));
            if radius == 0.0 {
                return leave_out("a radius of 0");
            }
            let Some(axes) = axes_along(along) else { return leave_out("two ends at one point") };
            let size = DVec3::new(radius.abs(), radius.abs(), along.length());
            (Quadric::Cylinder, scaled(point(0), axes, size), is_inner != (radius < 0.0))
        }
        "ring" => {
            let radii = [reals[6].min(reals[7]), reals[6].max(reals[7])];
            if radii[0] < 0.0 || radii[0] == radii[1] {
                return leave_out("radii that enclose no area");
            }
            let Some(axes) = axes_along(point(3)) else { return leave_out("a normal of length 0") };
            let inner = (radii[0] / radii[1]) as f32;
            (
                Quadric::Ring(inner.min(1.0 - f32::EPSILON)),
                scaled(point(0), axes, DVec3::splat(radii[1])),
                false,
            )
        }
        _ => {
            let (radii, along) = ([reals[6], reals[7]], point(3) - point(0));
            let most = radii[0].max(radii[1]);
            if radii[0].min(radii[1]) < 0.0 || most == 0.0 {
                return leave_out("radii below 0, or of 0 at both ends");
            }
            let Some(axes) = axes_along(along) else { return leave_out("two ends at one point") };
            let shape = Quadric::Cone(radii.map(|r| (r / most) as f32));
            (shape, scaled(point(0), axes, DVec3::new(most, most, along.length())), is_inner)
        }
    };
    Ok(Some(Geometry::Quadric { shape, to_world: map.map * local, faces_inward: is_inner != inverts }))
}

/// Refuses a primitive whose number of real arguments is not `expected`; 0 accepts any.
pub(super) fn check_count(primitive: &Primitive, expected: usize, at: &Location) -> Result<()> {
    let found = primitive.reals.len();
    if expected == 0 || found == expected {
        return Ok(());
    }
    let (kind, name) = (&primitive.kind, crate::io::notes::quoted(&primitive.name));
    let expected = format!("{expected} of them");
    Err(Error::invalid(at.clone(), format!("{found} real arguments of {kind} {name}"), expected))
}

/// Right-handed axes whose third is along `axis`.
fn axes_along(axis: DVec3) -> Option<DMat3> {
    let z = axis.try_normalize()?;
    let x = z.any_orthonormal_vector();
    Some(DMat3::from_cols(x, z.cross(x), z))
}

fn scaled(origin: DVec3, axes: DMat3, size: DVec3) -> DAffine3 {
    DAffine3 { matrix3: axes * DMat3::from_diagonal(size), translation: origin }
}

/// Material of a surface as the scene has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coating {
    pub(super) material: MaterialId,
    pub(super) interface: Option<Interface>,
    /// True if the material is that of the surface turned inside out.
    pub(super) is_turned: bool,
}

/// Polygons of one name and material.
#[derive(Debug, Default)]
struct Polygons {
    places: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

/// Meshes and instances that surfaces become.
pub(super) struct Surfaces {
    triangulator: Triangulator,
    /// Number of a name and material in `polygons`.
    numbers: BTreeMap<(String, u32), usize>,
    polygons: Vec<(String, Coating, Polygons)>,
    /// Meshes of quadrics, by shape, side and material.
    shared: BTreeMap<([u32; 3], bool, u32), MeshId>,
}

impl Surfaces {
    pub(super) fn new() -> Self {
        Self {
            triangulator: Triangulator::new(),
            numbers: BTreeMap::new(),
            polygons: Vec::new(),
            shared: BTreeMap::new(),
        }
    }

    /// Adds a surface under its name.
    pub(super) fn add(
        &mut self,
        name: &str,
        geometry: Geometry,
        coating: Coating,
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<()> {
        match geometry {
            Geometry::Polygon(corners) => self.add_polygon(name, corners, coating, at, builder),
            Geometry::Quadric { shape, to_world, faces_inward } => {
                let turn = faces_inward != coating.is_turned;
                let key = (shape.key(), turn, coating.material.index() as u32);
                let mesh = match self.shared.get(&key) {
                    Some(mesh) => *mesh,
                    None => {
                        let mut data = shape.mesh(at)?;
                        data.name = name.to_owned();
                        if turn {
                            data.turn_around();
                        }
                        let mesh = add_mesh(data, coating, builder)?;
                        self.shared.insert(key, mesh);
                        mesh
                    }
                };
                builder.begin_object(name);
                builder.add_instance(mesh, to_world).map(drop)
            }
        }
    }

    fn add_polygon(
        &mut self,
        name: &str,
        mut corners: Vec<DVec3>,
        coating: Coating,
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<()> {
        if coating.is_turned {
            corners.reverse();
        }
        let key = (name.to_owned(), coating.material.index() as u32);
        let number = *self.numbers.entry(key).or_insert_with(|| {
            self.polygons.push((name.to_owned(), coating, Polygons::default()));
            self.polygons.len() - 1
        });
        let polygons = &mut self.polygons[number].2;
        let (triangles, coverage) = triangulate(&mut self.triangulator, &corners);
        let first = polygons.places.len() as u32;
        polygons.triangles.extend(triangles.iter().map(|t| t.map(|i| first + i)));
        polygons.places.extend(corners);
        let message = match coverage {
            Coverage::Whole => return Ok(()),
            Coverage::Crossing => "polygons that cross themselves: parts may be missing or covered twice",
            Coverage::Fan => "polygons of too many corners: cut as if they were convex",
        };
        builder.note(NoteKind::Approximated, message, at.clone());
        Ok(())
    }

    /// Adds the meshes of all polygons to the scene.
    pub(super) fn finish(self, builder: &mut SceneBuilder) -> Result<()> {
        for (name, coating, Polygons { places, triangles }) in self.polygons {
            let mut data = MeshData { name: name.clone(), triangles, ..MeshData::default() };
            data.place(&places);
            let mesh = add_mesh(data, coating, builder)?;
            builder.begin_object(name);
            builder.add_instance(mesh, DAffine3::IDENTITY)?;
        }
        Ok(())
    }
}

/// Triangles of a polygon, as indices of its corners.
pub(super) fn triangulate(triangulator: &mut Triangulator, corners: &[DVec3]) -> (Vec<[u32; 3]>, Coverage) {
    let relative: Vec<Vec3> = corners.iter().map(|p| (p - corners[0]).as_vec3()).collect();
    let mut triangles = Vec::new();
    let coverage = triangulator.triangulate(&relative, &mut triangles);
    if coverage == Coverage::Crossing
        && let Some(triangles) = holes::triangulate(corners)
    {
        return (triangles, Coverage::Whole);
    }
    (triangles, coverage)
}

fn add_mesh(data: MeshData, coating: Coating, builder: &mut SceneBuilder) -> Result<MeshId> {
    let mesh = builder.add_mesh(data, coating.material)?;
    if let Some(interface) = coating.interface {
        builder.set_interface(mesh, interface)?;
    }
    Ok(mesh)
}
