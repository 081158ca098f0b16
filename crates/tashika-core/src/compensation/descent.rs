//! Draws of one VPL for a receiver, approximately in proportion to its unoccluded contribution.
//!
//! The light tree is descended from the root. At each cluster, one child is chosen in proportion to
//! its importance
//!
//! ```text
//! I cos⁺(θ) cos⁺(θ') / max(d² + s², d_c²)
//! ```
//!
//! with the luminance `I` of the child, the distance `d` of the centre of its box, the spread `s`
//! of its lights around the centre, and two cosines. The cosine at the receiver is the greatest
//! height of the box above the tangent plane, divided by `d`; in a medium it is 1. The cosine at
//! the lights is the greatest between a normal in the cone of their normals and a direction from
//! the ball around the box to the receiver. If a cluster is small relative to its distance and its
//! lights face nearly the same way, the descent ends, and one of its lights is drawn in proportion
//! to luminance.
//!
//! # Guarantee
//! Every light that can contribute has a probability above zero. Held to this by the tests of
//! [`VplChoice`](super::VplChoice) and by `what_can_give_light_can_be_drawn`.

use super::places::Receiver;
use crate::bounds::{LightBounds, LightShape, Towards, upper_geometric};
use crate::math::{Aabb, Cone, Vec3};
use crate::tree::{LightCluster, LightTree};

/// Root mean square distance of lights from the centre of their box, as a share of its diagonal.
/// Chosen.
const SPREAD: f32 = 0.25;
/// Ratio of the diagonal of a box to its distance below which the positions of lights in the box do
/// not matter. Chosen.
const SMALL: f32 = 0.5;
/// Cosine of the widest cone of normals that counts as one direction. Chosen.
const ONE_WAY: f32 = 0.8;
/// Allowance for the rounding error of a cosine, far more than the error itself.
const ROUNDING: f32 = 1e-5;

/// Light tree as seen from one receiver.
pub(super) struct Descent<'a> {
    pub lights: &'a LightTree,
    pub clamp_distance: f32,
    pub receiver: &'a Receiver,
}

/// Importance of a cluster: its approximate unoccluded contribution.
struct Importance {
    value: f64,
    /// True if lights of the cluster may be drawn by luminance.
    is_small: bool,
}

impl Descent<'_> {
    /// Draws a light. Returns its place in the sorted order and its probability; `None` if no light
    /// can contribute.
    pub fn draw(&self, u: f64) -> Option<(u32, f64)> {
        self.draw_from(self.lights.root()?, 1.0, u)
    }

    /// Draws a light from a cluster that was itself chosen with the given probability.
    pub fn draw_from(
        &self,
        mut cluster: LightCluster,
        mut probability: f64,
        mut u: f64,
    ) -> Option<(u32, f64)> {
        let mut is_small = self.of(&cluster).is_small;
        while !is_small && let Some(children) = self.lights.children(&cluster) {
            let [a, b] = children.map(|child| self.of(&child));
            let both = a.value + b.value;
            if both <= 0.0 {
                return None;
            }
            let p = a.value / both;
            if u < p {
                (cluster, is_small) = (children[0], a.is_small);
                probability *= p;
                u /= p;
            } else {
                (cluster, is_small) = (children[1], b.is_small);
                probability *= 1.0 - p;
                u = (u - p) / (1.0 - p);
            }
        }
        if cluster.count == 1 {
            return Some((cluster.first, probability));
        }
        let light = self.lights.draw(&cluster, u);
        Some((light, probability * self.lights.luminance_of(light) / self.lights.luminance(&cluster)))
    }

    /// Returns the approximate unoccluded contribution of a cluster; zero only if no light of it
    /// can contribute.
    pub fn importance(&self, cluster: &LightCluster) -> f64 {
        self.of(cluster).value
    }

    fn of(&self, cluster: &LightCluster) -> Importance {
        let bounds = self.lights.bounds(cluster);
        let normals = match bounds.shape {
            LightShape::Oriented(normals) => Some(normals),
            LightShape::Omni => None,
            LightShape::Spot { .. }
            | LightShape::Directional(_)
            | LightShape::Volume { .. }
            | LightShape::Mixed { .. } => {
                return self.of_others(cluster, &bounds);
            }
        };
        let Receiver { position, normal, .. } = *self.receiver;
        let half = 0.5 * bounds.aabb.size();
        let to = bounds.aabb.lo + half - position;
        let (squared, radius_squared) = (to.length_squared(), half.length_squared());
        let distance = squared.sqrt().max(f32::MIN_POSITIVE);
        let radius = radius_squared.sqrt();
        // Greatest height of the box above the tangent plane (m).
        let in_front = |normal: Vec3| normal.dot(to) + normal.abs().dot(half);
        let at_surface = normal.map_or(1.0, |normal| {
            (in_front(normal) / distance + ROUNDING * (1.0 + radius / distance)).clamp(0.0, 1.0)
        });
        let of_normals = |cone: Cone| upper_cos(-cone.axis.dot(to) / distance, cone.cos, radius / distance);
        let at_lights = normals.map_or(1.0, |cone| of_normals(cone) + ROUNDING);
        let spread = 4.0 * SPREAD * SPREAD * radius_squared;
        let apart = (squared + spread).max(self.clamp_distance * self.clamp_distance).max(f32::MIN_POSITIVE);
        Importance {
            value: self.lights.luminance(cluster) * f64::from(at_surface * at_lights / apart),
            is_small: 2.0 * radius < SMALL * distance && normals.is_none_or(|cone| cone.cos > ONE_WAY),
        }
    }

    /// Returns the importance of a cluster of spots, directional lights, volume lights or mixed
    /// kinds.
    fn of_others(&self, cluster: &LightCluster, bounds: &LightBounds) -> Importance {
        let at = self.receiver.position;
        let towards = Towards::between(bounds, &Aabb { lo: at, hi: at });
        // Lights are around the centre of their box, seldom at its nearest corner.
        let about = if bounds.reaches_infinity() {
            0.0
        } else {
            let spread = SPREAD * bounds.aabb.diagonal();
            (bounds.aabb.center().distance_squared(at) + spread * spread).sqrt()
        };
        let geometric = upper_geometric(bounds, &towards, self.clamp_distance.max(about));
        let cos = self.receiver.normal.map_or(1.0, |normal| towards.upper_cos(&Cone::of(normal)));
        let value = self.lights.luminance(cluster) * f64::from(geometric * cos);
        Importance { value, is_small: false }
    }
}

/// Returns `cos⁺ max(0, θ − α − β)`, given the cosines of `θ` and `β`, and the sine of `α`, which
/// is at most a right angle; 1 for a sine of 1 or more.
fn upper_cos(cos_theta: f32, cos_beta: f32, sin_alpha: f32) -> f32 {
    if sin_alpha >= 1.0 {
        return 1.0;
    }
    let other = |v: f32| (1.0 - v * v).max(0.0).sqrt();
    let (cos_alpha, sin_beta) = (other(sin_alpha), other(cos_beta));
    let cos = cos_alpha * cos_beta - sin_alpha * sin_beta;
    let sin = sin_alpha * cos_beta + cos_alpha * sin_beta;
    // Beyond a half turn, the sine of `α + β` is negative.
    if sin < 0.0 || cos_theta >= cos { 1.0 } else { (cos_theta * cos + other(cos_theta) * sin).max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::HenyeyGreenstein;
    use crate::color::Rgb;
    use crate::contribution::ContributionKernel;
    use crate::rng::{Purpose, Stream};
    use crate::tree::LightTreeBuilder;
    use crate::vpl::{Provenance, Vpl, VplKind, VplSet};

    /// Random lights. Many of them lie in planes in which receivers lie as well.
    fn lights(s: &mut Stream, kind: VplKind) -> LightTree {
        let light = |s: &mut Stream| {
            let at = Vec3::from(s.uniform_3());
            let (position, direction) = match s.below(3) {
                0 => (at, (Vec3::from(s.uniform_3()) - 0.5).normalize()),
                1 => (Vec3::new(at.x, at.y, 0.0), Vec3::Z),
                _ => (Vec3::new(0.0, at.y, at.z), Vec3::X),
            };
            Vpl { position, direction, intensity: Rgb::gray(s.uniform() + 0.1), kind }
        };
        let lights = (0..300).map(|_| light(s)).collect();
        LightTree::build(&VplSet::new(lights, Provenance::default()), LightTreeBuilder::default())
    }

    fn receiver(s: &mut Stream) -> Receiver {
        let at = Vec3::from(s.uniform_3());
        let (position, normal) = match s.below(4) {
            0 => (at, Some((Vec3::from(s.uniform_3()) - 0.5).normalize())),
            1 => (Vec3::new(at.x, at.y, 0.0), Some(Vec3::Z)),
            // Just in front of a plane of lights, almost in it.
            2 => (Vec3::new(1e-7, at.y, at.z), Some(Vec3::NEG_X)),
            _ => (at, None),
        };
        Receiver { position, normal, medium: None }
    }

    #[test]
    fn what_can_give_light_can_be_drawn() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let contribution = ContributionKernel::new(0.05);
        let mut given = 0;
        let volume = VplKind::Volume(HenyeyGreenstein { asymmetry: 0.6 });
        for kind in [VplKind::Oriented, VplKind::Omni, volume] {
            let lights = lights(&mut s, kind);
            for _ in 0..200 {
                let receiver = receiver(&mut s);
                let descent = Descent { lights: &lights, clamp_distance: 0.05, receiver: &receiver };
                let gives = |light: u32| {
                    let link = contribution.link(receiver.position, &lights.light(light));
                    link.geometric * receiver.cosine(link.towards_light) > 0.0
                };
                let giving: Vec<bool> = (0..300).map(gives).collect();
                given += giving.iter().filter(|gives| **gives).count();
                for cluster in lights.depth_first() {
                    let can_give = giving[cluster.lights()].contains(&true);
                    assert!(!can_give || descent.importance(&cluster) > 0.0, "{receiver:?} {cluster:?}");
                }
            }
        }
        assert!(given > 20_000, "{given}");
    }

    /// The share of each light among many draws agrees with the probability that `draw` returns.
    #[test]
    fn lights_are_drawn_as_often_as_is_said() {
        const DRAWS: usize = 200_000;
        let mut s = Stream::new(2, Purpose::Test, 0);
        let lights = lights(&mut s, VplKind::Oriented);
        // One receiver is so far away that clusters are small, another is near.
        let far = Vec3::new(0.5, 0.5, 4.0);
        for (position, normal) in
            [(far, Some(Vec3::NEG_Z)), (Vec3::splat(0.5), Some(Vec3::NEG_Z)), (far, None)]
        {
            let receiver = Receiver { position, normal, medium: None };
            let descent = Descent { lights: &lights, clamp_distance: 0.05, receiver: &receiver };
            let mut found = vec![(0.0, 0.0); 300];
            for _ in 0..DRAWS {
                let (light, probability) = descent.draw(s.uniform_f64()).unwrap();
                let (times, said) = &mut found[light as usize];
                *times += 1.0 / DRAWS as f64;
                assert!(*said == 0.0 || *said == probability, "{probability} after {said}");
                *said = probability;
            }
            let all: f64 = found.iter().map(|(_, said)| said).sum();
            assert!((0.99..1.000_01).contains(&all), "{all}");
            for (times, said) in found {
                let error = (said / DRAWS as f64).sqrt();
                // A light that hardly contributes may be drawn once although 0.02 draws are
                // expected.
                let rare = 3.0 / DRAWS as f64;
                assert!((times - said).abs() <= 5.0 * error + rare, "{times} ± {error}: {said}");
            }
        }
    }
}
