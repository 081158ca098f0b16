//! Light that comes to a surface from an emitter by a bent way, over mirrors or through solid
//! glass: how much there is, as light paths tell.
//!
//! Sums over VPLs do not carry it, and paths from the eye meet the emitter only by chance: hardly
//! ever, if it is small, and never, if it is a point. Light paths that begin at the emitter know
//! how much there is. Their first VPLs, where the way was bent, are a photon map of it (Jensen
//! 1996): the radiance that a surface sends out of it is about
//!
//! ```text
//! L(x) = (Σ_i I_i − 2 √(Σ_i I_i²)) / (π r²)          over the VPLs within r of x that face the same way
//! ```
//!
//! less two standard errors, so that one bright light path says nothing. It is too blurred for a
//! picture, but enough to tell that paths which found much less of it cannot be believed.

use crate::math::Vec3;
use crate::vpl::{Clamp, LightTracer, Vpl};

/// Light paths that are traced.
const PATHS: u64 = 1 << 16;
/// Automatic clamp distances of such VPLs, each of which holds about four, within which they are
/// counted: so there are 25.
const RADIUS: f32 = 2.5;
/// Least cosine between normals that face the same way.
const SAME_WAY: f32 = 0.7;

/// Light that emitters throw over mirrors and through solid glass.
#[derive(Clone, Debug)]
pub struct BentLight {
    /// In the order of their cells.
    lights: Vec<([i32; 3], Vpl)>,
    radius: f32,
}

impl BentLight {
    /// Traces light paths; none if no light comes that way. Runs on the current thread pool.
    pub fn learn(tracing: &LightTracer<'_>, seed: u64) -> Option<Self> {
        let lights = tracing.after_bent_ways(PATHS, seed);
        let radius = RADIUS * Clamp::Auto.distance(&lights, &tracing.tracer().scene().bounds(), seed);
        (radius > 0.0).then(|| Self::of(lights, radius))
    }

    fn of(lights: Vec<Vpl>, radius: f32) -> Self {
        let mut lights: Vec<([i32; 3], Vpl)> =
            lights.into_iter().map(|light| (cell(light.position, radius), light)).collect();
        lights.sort_by_key(|(cell, _)| *cell);
        Self { lights, radius }
    }

    /// About the least luminance that a surface sends out of it (W·m⁻²·sr⁻¹).
    pub fn importance_radiance(&self, position: Vec3, normal: Vec3) -> f64 {
        let [x, y, z] = cell(position, self.radius);
        let around = |at: i32| at.saturating_sub(1)..=at.saturating_add(1);
        let [mut sum, mut squares] = [0.0; 2];
        for (x, y) in around(x).flat_map(|x| around(y).map(move |y| (x, y))) {
            let of_column = [x, y, z.saturating_sub(1)]..=[x, y, z.saturating_add(1)];
            let first = self.lights.partition_point(|(cell, _)| cell < of_column.start());
            for (_, light) in self.lights[first..].iter().take_while(|(cell, _)| of_column.contains(cell)) {
                let is_near = light.position.distance_squared(position) < self.radius * self.radius;
                if is_near && light.direction.dot(normal) > SAME_WAY {
                    let intensity = f64::from(light.intensity.luminance());
                    sum += intensity;
                    squares += intensity * intensity;
                }
            }
        }
        let least = f64::max(sum - 2.0 * squares.sqrt(), 0.0);
        least / (std::f64::consts::PI * f64::from(self.radius) * f64::from(self.radius))
    }
}

/// Where a place lies in a lattice; what is out of its range is at its end.
fn cell(position: Vec3, size: f32) -> [i32; 3] {
    (position / size).floor().to_array().map(|at| at as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::rng::{Purpose, Stream};
    use crate::vpl::VplKind;

    /// A wall that all of it falls on evenly.
    #[test]
    fn light_on_a_wall_is_told_on_its_lit_side() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let (n, side) = (20_000, 4.0);
        let light = |s: &mut Stream| Vpl {
            position: Vec3::new(side * s.uniform(), side * s.uniform() - 2.0, 1.0),
            direction: Vec3::Z,
            intensity: Rgb::gray(1.0 / n as f32),
            kind: VplKind::Oriented,
        };
        let lights: Vec<Vpl> = (0..n).map(|_| light(&mut s)).collect();
        let bent = BentLight::of(lights, 0.2);
        let at = |x: f32, z: f32, normal| bent.importance_radiance(Vec3::new(x, 0.1, z), normal);
        // 157 of them, less two standard errors of 8 % each.
        let expected = 0.84 / f64::from(side * side);
        let found = at(1.7, 1.01, Vec3::Z);
        assert!((found / expected - 1.0).abs() < 0.35, "{found} for {expected}");
        assert_eq!(BentLight::of(vec![light(&mut s)], 9.0).importance_radiance(Vec3::Z, Vec3::Z), 0.0);
        assert_eq!([at(1.7, 1.01, Vec3::NEG_Z), at(1.7, 1.3, Vec3::Z), at(-0.3, 1.0, Vec3::Z)], [0.0; 3]);
    }
}
