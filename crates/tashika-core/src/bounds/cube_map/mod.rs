//! Upper bounds of the BRDF on a cube of directions, merged up the gather tree.
//!
//! Each texel `T` of a cube with `6 × N × N` texels stores an upper bound over the gather points
//! `j` of a cluster and the light directions `ω_i` of the texel's bounding cone:
//!
//! ```text
//! U_T ≥ max_j max_ω_i f_r,j(ω_o,j, ω_i)                 (sr⁻¹, largest channel)
//! M   ≤ max_{T met by D} U_T · max cos⁺∠(D, normals)    (sr⁻¹)
//! ```
//!
//! Here `D` contains all vectors from the points to the lights, and `normals` is a cone around the
//! shading normals. Two clusters are merged texel by texel. The cube is aligned with the world's
//! axes, so that a texel stands for the same directions at all points.
//!
//! # Guarantee
//! [`UpperMaterial::upper_material`] is at least the largest channel of `M` as `contribution`
//! computes it in `f32`, for every point merged and every light in `towards`.
//!
//! # Assumption
//! A light and a point are either at the same place or at least 10⁻¹⁷ m apart. At smaller distances
//! the square of the distance underflows, and `contribution` computes no unit vector.
//!
//! # Source
//! Iwasaki 2019, "Error Estimation for Many-Light Rendering of Glossy Materials": a cube map of the
//! largest BRDF for each gather point, texel-wise maxima up the tree, and the lights' box projected
//! onto the cube.
//!
//! # Differences from the source
//! * The projected box is the box of all differences between the positions of the two clusters. The
//!   box of the lights alone, seen from one point, gives no bound if the points are apart.
//! * The texels that are read are exactly those that contain a direction of the box ([`coverage`]);
//!   the source does not state how it finds them. A pyramid of maxima would read at most four
//!   texels per face. However, its bounds of wide boxes are many times larger, and rows of texels
//!   are read nearly as fast.
//! * The source states neither resolution nor format. Here `N = 8` by default, and a texel is 16
//!   bits wide ([`texel`]).
//! * The source bounds Phong lobes. Here every [`Bsdf`](crate::bsdf::Bsdf) is bounded ([`fill`]).
//! * `FOLDED` is an alternative of our own. The texels store the lobe *times* the cosine. The
//!   diffuse part is stored in two separate numbers, `M ≤ min(K max cos⁺, K_c) + max U_T`. Without
//!   the cosine, GGX lobes grow towards the horizon, so their product with the largest cosine of a
//!   cluster can be many times too large. For the diffuse part, the product with the largest cosine
//!   is only slightly too large.
//!
//! # Held to this by
//! `bounds::tests::cube_map`, and the tests beside each part.

mod coverage;
mod faces;
mod fill;
mod spans;
mod texel;

use super::lobes::{Parts, round_up};
use super::{Reflector, Towards, UpperMaterial};
use crate::bsdf::MIN_COSINE;
use crate::math::{Cone, UNIT_ROUNDOFF};
use fill::Bounded;
use texel::Texel;

/// Relative excess of the computed value over the product of a bound and a cosine that is allowed
/// for.
///
/// [`Towards::upper_cos`] is at most 1, but a cosine computed in `f32` can exceed 1 by up to 10
/// roundings: four of the length of the direction, three of the length of the normal, three of the
/// scalar product. The remaining roundings are those of a sum and of products in `contribution` and
/// here.
const ROUNDING: f32 = 16.0 * UNIT_ROUNDOFF;

/// Upper bounds of the BRDF by direction, on a cube of `6 N²` texels. `M` is at most the largest
/// texel that contains a direction to a light, times the largest cosine (Iwasaki 2019).
///
/// * `N`: texels along an edge, 2 to 16. Higher values bound sharp lobes better and cost memory
///   (`12 N²` bytes) and time.
/// * `FOLDED`: true if texels hold lobes times cosines, which is tighter; false if they hold BRDFs,
///   as published.
#[derive(Clone, Debug)]
pub struct UpperCubeMap<const N: usize = 8, const FOLDED: bool = false> {
    /// Shading normals, on the sides of the viewers.
    normals: Cone,
    /// Largest diffuse part that is not in the texels, without and with the cosine (sr⁻¹).
    diffuse: [f32; 2],
    /// `texels[face][v][u]` (sr⁻¹).
    texels: Box<[[[Texel; N]; N]; 6]>,
}

impl<const N: usize, const FOLDED: bool> UpperMaterial for UpperCubeMap<N, FOLDED> {
    fn of_point(point: &Reflector) -> Self {
        let mut map =
            Self { normals: Cone::EMPTY, diffuse: [0.0; 2], texels: Box::new([[[Texel::ZERO; N]; N]; 6]) };
        let cos_o = point.wo.z.abs();
        // Nothing is reflected if the viewer is in the plane of the surface.
        if cos_o > MIN_COSINE {
            map.normals = Cone::of(point.normal());
            let bounded = if FOLDED { Bounded::LobeCosine } else { Bounded::Brdf };
            fill::fill(&mut map.texels, point, bounded);
            if FOLDED {
                let parts = Parts::of(&point.bsdf, cos_o, 1.0);
                map.diffuse = [parts.diffuse, parts.diffuse_cos].map(round_up);
            }
        }
        map
    }

    fn merge(&mut self, other: &Self) {
        self.normals = self.normals.union(other.normals);
        let [diffuse, diffuse_cos] = self.diffuse;
        self.diffuse = [diffuse.max(other.diffuse[0]), diffuse_cos.max(other.diffuse[1])];
        let mine = self.texels.as_flattened_mut().as_flattened_mut();
        for (a, b) in mine.iter_mut().zip(other.texels.as_flattened().as_flattened()) {
            *a = (*a).max(*b);
        }
    }

    fn upper_material(&self, towards: &Towards) -> f32 {
        let cos = towards.upper_cos(&self.normals);
        if cos <= 0.0 {
            return 0.0;
        }
        let upper = coverage::upper(towards, &self.texels).value();
        let upper = if FOLDED { (self.diffuse[0] * cos).min(self.diffuse[1]) + upper } else { upper * cos };
        upper * (1.0 + ROUNDING)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Aabb, Vec3};
    use crate::rng::{Purpose, Stream};

    fn map(s: &mut Stream) -> UpperCubeMap<4> {
        let mut texels = Box::new([[[Texel::ZERO; 4]; 4]; 6]);
        for texel in texels.as_flattened_mut().as_flattened_mut() {
            *texel = Texel::at_least(s.uniform() / s.uniform());
        }
        UpperCubeMap { normals: Cone::of(crate::warp::sphere(s.uniform_2())), diffuse: [0.0; 2], texels }
    }

    #[test]
    fn merging_is_the_maximum_texel_by_texel_in_any_order() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let maps: Vec<_> = (0..9).map(|_| map(&mut s)).collect();
        let merged = |order: &[usize]| {
            let mut sum = maps[order[0]].clone();
            order[1..].iter().for_each(|&k| sum.merge(&maps[k]));
            sum
        };
        let all = merged(&[0, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(all.texels, merged(&[8, 3, 5, 1, 0, 7, 7, 2, 6, 4]).texels);
        for face in 0..6 {
            for v in 0..4 {
                for u in 0..4 {
                    let largest = maps.iter().map(|m| m.texels[face][v][u].value()).fold(0.0, f32::max);
                    assert_eq!(all.texels[face][v][u].value(), largest);
                }
            }
        }
        assert!(maps.iter().all(|m| all.normals.contains(m.normals.axis)));
    }

    /// The bound for a single direction reads the texel that contains this direction, and no other.
    #[test]
    fn a_bound_is_a_texel_times_a_cosine() {
        let mut s = Stream::new(1, Purpose::Test, 1);
        for _ in 0..1000 {
            let mut map = map(&mut s);
            map.normals = Cone::ALL;
            let d = crate::warp::sphere(s.uniform_2());
            let a = (0..3).max_by(|&i, &j| d[i].abs().total_cmp(&d[j].abs())).expect("three");
            let column = |k: usize| ((d[(a + k) % 3] / d[a].abs() + 1.0) * 2.0) as usize;
            let expected = map.texels[2 * a + usize::from(d[a] < 0.0)][column(2)][column(1)].value();
            let bound = map.upper_material(&Towards::Box(Aabb { lo: d, hi: d }));
            assert!(bound >= expected && bound <= expected * (1.0 + 2.0 * ROUNDING), "{d}");
            let towards_all = map.upper_material(&Towards::Any);
            assert_eq!(towards_all, map.upper_material(&Towards::Cone(Cone::ALL)));
            assert_eq!(
                towards_all,
                map.upper_material(&Towards::Box(Aabb { lo: Vec3::NEG_ONE, hi: Vec3::ONE }))
            );
        }
    }

    #[test]
    fn nothing_is_reflected_towards_nothing_or_by_nothing() {
        let mut s = Stream::new(1, Purpose::Test, 2);
        let mut map = map(&mut s);
        assert_eq!(map.upper_material(&Towards::Cone(Cone::EMPTY)), 0.0);
        assert_eq!(map.upper_material(&Towards::Box(Aabb::EMPTY)), 0.0);
        *map.texels = [[[Texel::ZERO; 4]; 4]; 6];
        assert_eq!(map.upper_material(&Towards::Any), 0.0);
    }
}
