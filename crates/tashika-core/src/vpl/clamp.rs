//! Clamp distance, below which the geometric term of a VPL no longer grows.

use glam::Vec3;

use super::{Vpl, VplKind};
use crate::bsdf::HenyeyGreenstein;
use crate::error::{Error, Result};
use crate::math::Aabb;
use crate::math::elementary::powf;
use crate::rng::{Purpose, Stream};

/// Limit of the factor `1/d²` of a VPL near a receiver, which is needed because a VPL represents a
/// patch of surface, not a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Clamp {
    /// Chosen from the spacing of the VPLs, so that it vanishes as their number grows: twice the
    /// radius of the disk that a VPL on a surface represents. At that distance, a VPL of a
    /// uniformly bright wall adds at most a quarter of the light of the whole wall. If VPLs in
    /// media give a larger distance, that one is used: twice the radius of the ball that such a VPL
    /// represents. It is computed only from VPLs in the box around all surfaces, since most VPLs of
    /// unbounded fog are out of view.
    #[default]
    Auto,
    /// No clamp: unbiased, with bright spots where VPLs are close to surfaces.
    Off,
    /// A given distance (m), above zero.
    Distance(f32),
}

/// Number of VPLs whose nearest neighbour is searched.
const PROBES: usize = 512;
/// Number of VPLs among which neighbours are searched.
const CANDIDATES: usize = 1 << 16;
/// Ratio of the clamp distance to the median distance of nearest neighbours. For random points of
/// density `λ` on a surface, the median is `√(ln 2 / πλ)`, and the radius of the disk of area `1/λ`
/// is `√(1/πλ)`. The clamp distance is two such radii.
const CLAMP_PER_MEDIAN: f32 = 2.0 * 1.201_122;
/// The ratio in a volume, where median and radius are the cube roots of `3 ln 2 / 4πλ` and of
/// `3 / 4πλ`.
const CLAMP_PER_MEDIAN_IN_VOLUMES: f32 = 2.0 * 1.129_997;

impl Clamp {
    /// Checks that a given distance is a positive number.
    ///
    /// # Errors
    /// A distance that is not a positive number.
    pub fn validate(&self) -> Result<()> {
        match *self {
            Self::Distance(d) if !(d > 0.0 && d.is_finite()) => {
                Err(Error::option("clamp", d, "auto, off, or a distance above 0 in metres"))
            }
            Self::Auto | Self::Off | Self::Distance(_) => Ok(()),
        }
    }

    /// Returns the distance (m) for the lights of a scene whose surfaces are in the box `surfaces`;
    /// zero means no clamp.
    pub(crate) fn distance(&self, lights: &[Vpl], surfaces: &Aabb, seed: u64) -> f32 {
        match *self {
            Self::Off => 0.0,
            Self::Distance(d) => d,
            Self::Auto => {
                let of = |kind: VplKind| lights.iter().filter(move |l| l.kind.number() == kind.number());
                let places = of(VplKind::Oriented).map(|l| l.position).collect();
                let on_surfaces = median_spacing(places, 2, seed);
                let volume = VplKind::Volume(HenyeyGreenstein::default());
                let places = of(volume).map(|l| l.position).filter(|p| surfaces.contains(*p)).collect();
                let in_volumes = median_spacing(places, 3, seed);
                let on_surfaces = on_surfaces.map_or(0.0, |d| d * CLAMP_PER_MEDIAN);
                in_volumes.map_or(0.0, |d| d * CLAMP_PER_MEDIAN_IN_VOLUMES).max(on_surfaces)
            }
        }
    }
}

/// Returns the median distance (m) from a point to its nearest neighbour, estimated from subsets;
/// `None` for fewer than two points.
///
/// * `dimensions`: 2 for points on surfaces, 3 for points in volumes.
fn median_spacing(mut candidates: Vec<Vec3>, dimensions: u32, seed: u64) -> Option<f32> {
    let n = candidates.len();
    if n < 2 {
        return None;
    }
    let mut stream = Stream::new(seed, Purpose::Subset, 0);
    let kept = n.min(CANDIDATES);
    for i in 0..kept {
        let j = i + stream.below((n - i) as u64) as usize;
        candidates.swap(i, j);
    }
    candidates.truncate(kept);
    let mut nearest: Vec<f32> = (0..kept.min(PROBES))
        .map(|i| {
            let others = candidates.iter().enumerate().filter(|(j, _)| *j != i);
            others.map(|(_, p)| p.distance_squared(candidates[i])).fold(f32::INFINITY, f32::min).sqrt()
        })
        .collect();
    let middle = nearest.len() / 2;
    let median = *nearest.select_nth_unstable_by(middle, f32::total_cmp).1;
    // Distances between `n` points shrink as `1/√n` on surfaces, and as `1/∛n` in volumes.
    let kept = kept as f32 / n as f32;
    Some(median * if dimensions == 2 { kept.sqrt() } else { powf(kept, 1.0 / 3.0) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;

    fn wall(n: usize) -> Vec<Vpl> {
        let mut s = Stream::new(1, Purpose::Test, 0);
        (0..n)
            .map(|_| Vpl {
                position: Vec3::new(s.uniform() * 2.0, s.uniform() * 3.0, 0.0),
                direction: Vec3::Z,
                intensity: Rgb::WHITE,
                kind: VplKind::Oriented,
            })
            .collect()
    }

    /// VPLs in a box of fog.
    fn fog(n: usize) -> Vec<Vpl> {
        let mut s = Stream::new(2, Purpose::Test, 0);
        let kind = VplKind::Volume(HenyeyGreenstein { asymmetry: 0.5 });
        let position = |s: &mut Stream| Vec3::from(s.uniform_3()) * Vec3::new(2.0, 3.0, 1.0);
        let mut light =
            || Vpl { position: position(&mut s), direction: Vec3::Z, intensity: Rgb::WHITE, kind };
        (0..n).map(|_| light()).collect()
    }

    #[test]
    fn in_volumes_it_is_two_radii_of_a_vpls_ball() {
        let room = Aabb { lo: Vec3::ZERO, hi: Vec3::new(2.0, 3.0, 1.0) };
        for n in [2_000, 50_000, 200_000] {
            let expected = 2.0 * powf(6.0 * 0.75 / (std::f32::consts::PI * n as f32), 1.0 / 3.0);
            // Most VPLs are far from all surfaces.
            let far = fog(3 * n).into_iter().map(|l| Vpl { position: 100.0 * l.position - 50.0, ..l });
            let far: Vec<Vpl> = far.filter(|l| !room.contains(l.position)).collect();
            assert!(far.len() > 2 * n);
            let found = Clamp::Auto.distance(&[fog(n), far].concat(), &room, 3);
            // The relative standard error of the median of 512 distances is about 2 %. In addition,
            // balls at the border reach beyond the fog.
            assert!((found / expected - 1.0).abs() < 0.12, "{n}: {found} for {expected}");
            let of_both = Clamp::Auto.distance(&[fog(n), wall(n)].concat(), &room, 3);
            let of_fog = Clamp::Auto.distance(&fog(n), &room, 3);
            assert_eq!(of_both, of_fog.max(Clamp::Auto.distance(&wall(n), &room, 3)));
        }
    }

    #[test]
    fn the_automatic_clamp_is_two_radii_of_a_vpls_disk() {
        let nowhere = Aabb { lo: Vec3::ZERO, hi: Vec3::ZERO };
        for n in [2_000, 50_000, 200_000] {
            let expected = 2.0 * (6.0 / (std::f32::consts::PI * n as f32)).sqrt();
            let found = Clamp::Auto.distance(&wall(n), &nowhere, 3);
            // The relative standard error of the median of 512 distances is about 3 %.
            assert!((found / expected - 1.0).abs() < 0.12, "{n}: {found} for {expected}");
        }
        assert_eq!(Clamp::Auto.distance(&wall(1), &nowhere, 3), 0.0);
        assert_eq!(Clamp::Distance(0.3).distance(&wall(9), &nowhere, 3), 0.3);
        assert!(Clamp::Distance(-1.0).validate().is_err() && Clamp::Distance(f32::NAN).validate().is_err());
    }
}
