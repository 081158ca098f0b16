//! Skins: vertices that follow several joints, each by a weight (glTF 2.0 section 3.7.3),
//!
//! ```text
//! J_k = M_k B_k     M = Σ w_k J_k / Σ w_k     p = M p₀     n ∥ cof(M) n₀ = det(M) M⁻ᵀ n₀
//! ```
//!
//! with the transform `M_k` of joint `k` to the world at the scene's time, and its inverse bind
//! matrix `B_k`, in `f64`. `cof(M)` exists even where `M` has no inverse; where `M` mirrors, the
//! sign of `det(M)` is removed. The result is in world space: the transform of the node with the
//! skin has no effect.
//!
//! # Guarantee
//! A vertex that follows a joint that the skin does not have is an error. Weights are at least zero
//! and add up to one.
//!
//! # Held to this by
//! The test module `gltf_shapes`.

use glam::{DAffine3, DMat3, DVec3, Vec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;

use super::shapes::Wanted;
use super::source::Source;
use crate::error::{Error, Result};
use crate::scene::{MeshShape, NoteKind, SceneBuilder};

/// Transforms of the joints of a skin from bind space to the world, given the transforms of all
/// nodes.
pub(super) fn joints(
    source: &Source<'_>,
    skin: usize,
    nodes_to_world: &[DAffine3],
    builder: &mut SceneBuilder,
) -> Result<Vec<DAffine3>> {
    let document = &source.root.skins[skin];
    let count = document.joints.len();
    let at = |field: &str| source.at(format!("skins[{skin}].{field}"));
    source
        .geometry_budget
        .take((count as u64).saturating_mul(size_of::<DAffine3>() as u64), &at("joints"))?;
    let to_world = document.joints.iter().map(|joint| nodes_to_world[joint.value()]);
    let Some(index) = document.inverse_bind_matrices else { return Ok(to_world.collect()) };
    let at = || at("inverseBindMatrices");
    let accessor = source.accessor(index, Type::Mat4, at())?;
    if accessor.count() < count {
        let found = format!("accessors[{index}] of {} matrices", accessor.count());
        return Err(Error::invalid(at(), found, format!("{count}, one for each joint")));
    }
    let matrices = accessor.vectors::<16>(0..count)?;
    let mut of_joint = Vec::with_capacity(count);
    for (to_world, m) in to_world.zip(matrices) {
        if let Some(wrong) = m.iter().find(|number| !number.is_finite()) {
            let found = format!("accessors[{index}] with the number {wrong}");
            return Err(Error::invalid(at(), found, "finite numbers"));
        }
        if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
            let message = "inverse bind matrices whose last row is not 0 0 0 1: taken as if it were";
            builder.note(NoteKind::Repaired, message, at());
        }
        let column = |c: usize| DVec3::new(m[4 * c].into(), m[4 * c + 1].into(), m[4 * c + 2].into());
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        of_joint.push(to_world * DAffine3 { matrix3, translation: column(3) });
    }
    Ok(of_joint)
}

/// Joints and weights of the vertices of a primitive: each set has four of them for each vertex.
pub(super) struct Influences {
    /// Joint and weight, by set and vertex.
    sets: Vec<Vec<[(u32, f32); 4]>>,
}

impl Influences {
    /// Influences of a skin with `joints` joints on a primitive; none, with a note, if the
    /// primitive has none.
    pub fn of(
        source: &Source<'_>,
        wanted: &Wanted<'_>,
        joints: usize,
        builder: &mut SceneBuilder,
    ) -> Result<Option<Self>> {
        let at = |name: &str| source.at(format!("{}.attributes.{name}", wanted.item));
        let attribute = |semantic| wanted.primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let mut sets = Vec::new();
        for set in 0.. {
            let (numbers, weights) = match [Semantic::Joints(set), Semantic::Weights(set)].map(attribute) {
                [Some(numbers), Some(weights)] => (numbers, weights),
                [None, None] => break,
                _ => {
                    let message = "joints without weights, or weights without joints: left out";
                    builder.note(NoteKind::Repaired, message, at(&format!("JOINTS_{set}")));
                    break;
                }
            };
            let (of_numbers, of_weights) = (at(&format!("JOINTS_{set}")), at(&format!("WEIGHTS_{set}")));
            let bytes = (wanted.range.len() as u64).saturating_mul(size_of::<[(u32, f32); 4]>() as u64);
            source.geometry_budget.take(bytes, &of_numbers)?;
            let numbers = source.accessor(numbers, Type::Vec4, of_numbers.clone())?;
            let numbers = numbers.expect_count(wanted.count)?.index_vectors::<4>(wanted.range.clone())?;
            let weights = source.accessor(weights, Type::Vec4, of_weights.clone())?;
            let weights = weights.expect_count(wanted.count)?.vectors::<4>(wanted.range.clone())?;
            let mut of_set = Vec::with_capacity(wanted.range.len());
            for (numbers, weights) in numbers.into_iter().zip(weights) {
                let mut all = [(0, 0.0); 4];
                for ((one, number), weight) in all.iter_mut().zip(numbers).zip(weights) {
                    if !(weight >= 0.0 && weight.is_finite()) {
                        let message = "joint weights that are negative or not finite: 0";
                        builder.note(NoteKind::Repaired, message, of_weights.clone());
                    } else if weight > 0.0 && number as usize >= joints {
                        let found = format!("joint {number} of a skin of {joints}");
                        let expected = format!("an index below {joints}");
                        return Err(Error::invalid(of_numbers, found, expected));
                    } else {
                        *one = (number, weight);
                    }
                }
                of_set.push(all);
            }
            sets.push(of_set);
        }
        if sets.is_empty() {
            let message = "primitives without joints and weights in a mesh with a skin: where their node is";
            builder.note(NoteKind::Repaired, message, at("JOINTS_0"));
            return Ok(None);
        }
        let lost =
            (0..wanted.range.len()).filter(|&v| !sets.iter().any(|set| set[v].iter().any(|i| i.1 > 0.0)));
        let lost: Vec<usize> = lost.collect();
        if !lost.is_empty() {
            if joints == 0 {
                return Err(Error::invalid(at("JOINTS_0"), "a skin without joints", "one joint or more"));
            }
            let message = "vertices without weights of joints: they follow the first that they name";
            builder.note(NoteKind::Repaired, message, at("WEIGHTS_0"));
            for vertex in lost {
                let first = &mut sets[0][vertex][0];
                *first = (first.0.min(joints as u32 - 1), 1.0);
            }
        }
        Ok(Some(Self { sets }))
    }

    /// Moves the vertices with the joints. Returns their positions; normals are changed in place.
    pub fn apply(&self, joints: &[DAffine3], vertices: &mut MeshShape) -> Vec<DVec3> {
        let mut places = Vec::with_capacity(vertices.positions.len());
        for v in 0..vertices.positions.len() {
            let m = self.map(joints, v);
            places.push(m.transform_point3(vertices.positions[v].as_dvec3()));
            if let Some(normal) = vertices.normals.get_mut(v) {
                *normal = turned(&m.matrix3, *normal);
            }
        }
        places
    }

    /// Weighted mean of the transforms of a vertex's joints.
    fn map(&self, joints: &[DAffine3], vertex: usize) -> DAffine3 {
        let (mut matrix3, mut translation, mut sum) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        for &(joint, weight) in self.sets.iter().flat_map(|set| &set[vertex]).filter(|(_, w)| *w > 0.0) {
            let (map, weight) = (&joints[joint as usize], f64::from(weight));
            matrix3 += map.matrix3 * weight;
            translation += map.translation * weight;
            sum += weight;
        }
        DAffine3 { matrix3: matrix3 * (1.0 / sum), translation: translation / sum }
    }
}

/// Unit normal after a linear map; zero if the map leaves none.
fn turned(map: &DMat3, normal: Vec3) -> Vec3 {
    let (a, b, c) = (map.x_axis, map.y_axis, map.z_axis);
    let cofactors = DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b));
    let n = cofactors * normal.as_dvec3();
    let n = if map.determinant() < 0.0 { -n } else { n };
    n.normalize_or_zero().as_vec3()
}
