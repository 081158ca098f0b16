//! Normals and heights of triangles in the world, computed once.

use glam::{DVec3, Vec3};

use super::{Instance, Mesh};

/// Quantities of a triangle that are the same at all of its points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Face {
    /// Unit normal on the side on which the corners run anticlockwise.
    pub normal: Vec3,
    /// Reciprocal of the least height (m⁻¹).
    pub per_height: f32,
}

impl Face {
    /// Computes the quantities of a triangle from its corners (m), in double precision, since the
    /// fourth power of a length can leave the range of `f32`.
    #[inline]
    pub fn of(corners: &[Vec3; 3]) -> Self {
        let [v0, v1, v2] = corners.map(Vec3::as_dvec3);
        let e = [v2 - v1, v0 - v2, v1 - v0];
        let longest = e[0].length_squared().max(e[1].length_squared()).max(e[2].length_squared()).sqrt();
        // Twice the area, as a vector.
        let area = e[2].cross(-e[1]);
        let normal = area.normalize_or(DVec3::Z).as_vec3();
        Self { normal, per_height: (longest / area.length()) as f32 }
    }
}

/// Faces of the [baked](Instance::is_baked) instances of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Faces {
    faces: Vec<Face>,
    /// First face of each instance; `None` if the instance is not baked.
    first: Vec<Option<usize>>,
}

impl Faces {
    /// Computes the faces of the baked ones of `instances`.
    pub fn new(instances: &[Instance], meshes: &[Mesh]) -> Self {
        let mut faces = Vec::new();
        let mut of_instance = |instance: &Instance| {
            let first = faces.len();
            let mesh = &meshes[instance.mesh.index()];
            let corners = |triangle| instance.corners(mesh.corners(triangle));
            instance.baked.then(|| {
                faces.extend((0..mesh.triangles.len() as u32).map(|t| Face::of(&corners(t))));
                first
            })
        };
        let first = instances.iter().map(&mut of_instance).collect();
        Self { faces, first }
    }

    /// Memory that the faces use (bytes).
    pub fn bytes(&self) -> u64 {
        size_of_val(&self.faces[..]) as u64
    }

    /// Face of a triangle; `None` if the instance is not baked.
    #[inline]
    pub fn get(&self, instance: usize, triangle: u32) -> Option<&Face> {
        let first = (*self.first.get(instance)?)?;
        Some(&self.faces[first + triangle as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle with sides of 3, 4 and 5 has the least height 12/5, at every scale.
    #[test]
    fn normal_and_height_are_those_of_the_triangle() {
        for scale in [1e-15_f32, 1.0, 1e9] {
            let [a, b, c] = [[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]].map(|[x, y]| Vec3::new(x, y, 1.0) * scale);
            let face = Face::of(&[a, b, c]);
            assert_eq!(face.normal, Vec3::Z);
            assert!((face.per_height * scale * 12.0 / 5.0 - 1.0).abs() < 1e-6, "{face:?} at {scale}");
            assert_eq!(Face::of(&[a, c, b]).normal, Vec3::NEG_Z);
        }
    }
}
