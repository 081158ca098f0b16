//! Wavefronts: the direction of light near a place, to first order.
//!
//! Let `δ` be the slope of a direction relative to the direction of the photon, and `d` the offset
//! at which the ray of that direction crosses the plane through the photon. Then
//!
//! ```text
//! δ(d) = −K d        K symmetric, 2 × 2 (m⁻¹)
//! ```
//!
//! `K` is zero for light from infinity, and `1/D` times the identity for light from a point at the
//! distance `D`, also if flat mirrors reflect it; curved surfaces bend the two axes differently
//! (Igehy 1999, ray differentials). `K` is fitted to the photons near by.

use crate::math::{Frame, Vec2, Vec3};

/// Least number of neighbours to which a wavefront is fitted.
const FEWEST: usize = 4;
/// Share of the neighbours that a wavefront has to predict: others may belong to other wavefronts.
const PREDICTED: f32 = 0.25;
/// Radius of the disk that holds a quarter of a Gaussian in two dimensions, over its standard
/// deviation: `√(−2 ln (1 − ¼))`.
const RADIUS_OF_QUARTER: f32 = 0.758_528;
/// Range of the spread (rad). Smaller spreads are raised to the least, since no lamp is narrower;
/// wavefronts of greater spread are discarded.
const SPREADS: [f32; 2] = [2e-4, 0.5];
/// Slope beyond which a direction is too far off to be predicted.
const FAR_OFF: f32 = 4.0;
/// Determinant up to which a place counts as lying in a focus.
const IN_FOCUS: f32 = 0.1;

/// Another photon that came over the same surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct Neighbour {
    /// Position relative to the photon (m).
    pub(super) offset: Vec3,
    /// Unit direction towards the origin of its light.
    pub(super) towards: Vec3,
}

/// Predicted direction of light near a photon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wavefront {
    towards: Vec3,
    curvature: Curvature,
    /// Standard deviation of directions from the predicted one (rad).
    pub(super) spread: f32,
}

/// `K`: the elements `xx`, `xy`, `yy`, in the [frame about](Frame::about) the direction (m⁻¹).
#[derive(Clone, Copy, Debug)]
struct Curvature([f32; 3]);

/// Crossing of the ray of a neighbour with the plane through the photon: place and slope.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    at: Vec2,
    slope: Vec2,
}

impl Curvature {
    fn times(&self, d: Vec2) -> Vec2 {
        let [xx, xy, yy] = self.0;
        Vec2::new(xx * d.x + xy * d.y, xy * d.x + yy * d.y)
    }

    /// Returns the distance between a neighbour's slope and the predicted slope.
    fn residual(&self, crossing: &Crossing) -> f32 {
        (crossing.slope + self.times(crossing.at)).length()
    }

    /// Returns the curvature with the least sum of squared residuals.
    fn least_squares(crossings: &[Crossing]) -> Option<Self> {
        let (mut m, mut v) = ([[0.0_f64; 3]; 3], [0.0_f64; 3]);
        for Crossing { at, slope } in crossings {
            // Both components of δ = −K d, as rows over xx, xy, yy.
            for (row, value) in [([at.x, at.y, 0.0], slope.x), ([0.0, at.x, at.y], slope.y)] {
                for i in 0..3 {
                    v[i] -= f64::from(row[i] * value);
                    (0..3).for_each(|j| m[i][j] += f64::from(row[i]) * f64::from(row[j]));
                }
            }
        }
        let ridge = 1e-3 * (m[0][0] + m[2][2]);
        (0..3).for_each(|i| m[i][i] += ridge);
        solve(m, v).map(|k| Self(k.map(|k| k as f32))).filter(|k| k.0.iter().all(|k| k.is_finite()))
    }
}

impl Wavefront {
    /// Fits a wavefront to neighbours, for light that comes from the unit direction `towards` over
    /// `distance` (m); `None` if neighbours are too few or their directions too scattered.
    pub(super) fn fit(towards: Vec3, distance: f32, neighbours: &[Neighbour]) -> Option<Self> {
        if neighbours.len() < FEWEST {
            return None;
        }
        let frame = Frame::about(towards);
        let mut crossings: Vec<Crossing> = neighbours.iter().map(|near| crossing(&frame, near)).collect();
        let predicted = ((crossings.len() as f32 * PREDICTED) as usize).max(FEWEST - 1);
        let mut spread_of = |curvature: Curvature| {
            crossings.sort_by(|a, b| curvature.residual(a).total_cmp(&curvature.residual(b)));
            let spread = curvature.residual(&crossings[predicted - 1]) / RADIUS_OF_QUARTER;
            (spread, curvature, Curvature::least_squares(&crossings[..(2 * predicted).min(crossings.len())]))
        };
        let from_there = Curvature([1.0 / distance, 0.0, 1.0 / distance]);
        let mut best = [Curvature([0.0; 3]), from_there].map(&mut spread_of);
        best.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [(mut spread, mut curvature, fitted), _] = best;
        if let Some(fitted) = fitted {
            let (of_fitted, ..) = spread_of(fitted);
            if of_fitted < spread {
                (spread, curvature) = (of_fitted, fitted);
            }
        }
        let [least, most] = SPREADS;
        (spread < most).then(|| Self { towards, curvature, spread: spread.max(least) })
    }

    /// Returns the unit direction of the light at an offset from the photon; `None` in a focus.
    pub(super) fn towards_at(&self, offset: Vec3) -> Option<Vec3> {
        let frame = Frame::about(self.towards);
        let d = frame.to_local(offset);
        // The crossing is at d − d_z δ: (1 − d_z K) δ = −K d.
        let [xx, xy, yy] = self.curvature.0;
        let (a, b, c) = (1.0 - d.z * xx, -d.z * xy, 1.0 - d.z * yy);
        let determinant = a * c - b * b;
        let right = -self.curvature.times(d.truncate());
        let slope = Vec2::new(c * right.x - b * right.y, a * right.y - b * right.x) / determinant;
        (determinant > IN_FOCUS).then(|| frame.to_world(slope.extend(1.0)).normalize())
    }
}

fn crossing(frame: &Frame, near: &Neighbour) -> Crossing {
    let (offset, towards) = (frame.to_local(near.offset), frame.to_local(near.towards));
    let slope = towards.truncate() / towards.z;
    let is_far_off = towards.z <= 0.0 || slope.length() > FAR_OFF;
    let slope = if is_far_off { Vec2::new(2.0 * FAR_OFF, 0.0) } else { slope };
    Crossing { at: offset.truncate() - offset.z * slope, slope }
}

/// Solves `M k = v` for a symmetric positive definite matrix by elimination.
fn solve(mut m: [[f64; 3]; 3], mut v: [f64; 3]) -> Option<[f64; 3]> {
    for i in 0..3 {
        if m[i][i] <= 0.0 {
            return None;
        }
        for below in i + 1..3 {
            let factor = m[below][i] / m[i][i];
            (i..3).for_each(|j| m[below][j] -= factor * m[i][j]);
            v[below] -= factor * v[i];
        }
    }
    for i in (0..3).rev() {
        let of_others: f64 = (i + 1..3).map(|j| m[i][j] * v[j]).sum();
        v[i] = (v[i] - of_others) / m[i][i];
    }
    Some(v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// Returns photons on a tilted plane; `towards` is the direction of the light at each place.
    fn neighbours(s: &mut Stream, towards: &dyn Fn(&mut Stream, Vec3) -> Vec3) -> Vec<Neighbour> {
        let one = |s: &mut Stream| {
            let [x, y] = s.uniform_2().map(|u| 0.2 * (u - 0.5));
            let offset = Vec3::new(x, y, 0.4 * x);
            Neighbour { offset, towards: towards(s, offset) }
        };
        (0..40).map(|_| one(s)).collect()
    }

    /// For light from a point, the predicted direction at every place leads to that point. The
    /// distance of the point is learned from the photons, even if a different distance is passed.
    #[test]
    fn light_of_a_point_is_predicted_at_other_places() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let point = Vec3::new(0.5, -0.3, 1.0);
        let towards = |_: &mut Stream, offset: Vec3| (point - offset).normalize();
        for stated in [point.length(), 0.7 * point.length(), f32::INFINITY] {
            let near = neighbours(&mut s, &towards);
            let found = Wavefront::fit(point.normalize(), stated, &near).unwrap();
            let offset = Vec3::new(-0.05, 0.08, -0.02);
            let error = found.towards_at(offset).unwrap().distance(towards(&mut s, offset));
            assert!(error < 2e-3 && found.spread < 2e-3, "{error}, {}", found.spread);
        }
        // Without curvature, the predicted direction is off by the angle of the offset.
        let flat = Wavefront { towards: point.normalize(), curvature: Curvature([0.0; 3]), spread: 0.1 };
        let offset = Vec3::new(-0.05, 0.08, -0.02);
        assert!(flat.towards_at(offset).unwrap().distance(towards(&mut s, offset)) > 0.05);
    }

    /// Photons of a small sun and of a wide sky come over the same surfaces. If at least a quarter
    /// of the photons are from the sun, the spread is that of the sun.
    #[test]
    fn a_sun_in_a_sky_keeps_its_own_spread() {
        let mut s = Stream::new(2, Purpose::Test, 0);
        let sun = Vec3::new(0.0, 0.6, 0.8);
        let spread = 0.005;
        let towards = |s: &mut Stream, _| {
            if s.uniform() < 0.4 {
                (sun + spread * crate::warp::sphere(s.uniform_2())).normalize()
            } else {
                crate::warp::cosine_hemisphere(s.uniform_2())
            }
        };
        let near = neighbours(&mut s, &towards);
        let found = Wavefront::fit(sun, f32::INFINITY, &near).unwrap();
        assert!((0.3 * spread..3.0 * spread).contains(&found.spread), "{}", found.spread);
        assert!(Wavefront::fit(sun, f32::INFINITY, &near[..FEWEST - 1]).is_none());
    }
}
