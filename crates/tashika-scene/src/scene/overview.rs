//! Camera for scenes without a camera. It shows the whole bounding box of the scene, in images of
//! any proportions.
//!
//! The camera looks from the front, the right and above. Let `(x, y, z)` be a corner of the box,
//! relative to its centre and in the camera's axes, with `z` towards the camera. Let `s_x` and
//! `s_y` be the slopes from the axis to the film's sides, less the margin. All corners are inside
//! if
//!
//! ```text
//! |x − a| ≤ s_x (d − z),   |y − b| ≤ s_y (d − z)
//! ```
//!
//! for the camera at `(a, b, d)`. Along x these are `P ≤ s d + a` and `N ≤ s d − a` with
//! `P = max(x + s z)` and `N = max(−x + s z)`; hence the nearest position has
//!
//! ```text
//! d = max of (P + N) / 2s over both axes,   a = (P − N) / 2
//! ```
//!
//! Along the axis with the larger `(P + N) / 2s`, the box then touches the margin on both sides.
//! Along the other axis, `s` is replaced by the smaller slope that needs the same `d`. It is found
//! by bisection, since `(P + N) / 2s` falls with `s`. The box is then centred along this axis, too.
//!
//! # Held to this by
//! `tests`; `request::framing` ensures that the program and the package call [`Camera::of_size`].

use glam::{Mat3, Vec2, Vec3};

use super::{Camera, Projection};
use crate::math::Aabb;
use crate::math::elementary::tan;

/// Direction from the scene to the camera, before normalisation: from the front, the right and
/// above.
const FROM: Vec3 = Vec3::new(0.45, 0.35, 1.0);

/// Vertical field of view (radians).
const FOV: f32 = 0.7;

/// Width of the margin at each side, as a share of the film.
const MARGIN: f32 = 0.025;

/// Smallest distance from the centre (m), for boxes without extent.
const NEAREST: f32 = 1e-6;

impl Camera {
    /// Creates a camera that shows all of `bounds` in a square image; [`Camera::of_size`] adapts it
    /// to an image of any size.
    pub fn overview(bounds: Aabb) -> Self {
        // Only the orientation of this camera matters, since `of_size` moves it. It is placed near
        // zero: far from zero, the two points passed to `look_at` would be rounded to the same
        // point.
        let camera = Self::look_at("overview", FROM.normalize(), Vec3::ZERO, Vec3::Y, FOV);
        Self { shows: Some(bounds), ..camera }.of_size([1, 1])
    }

    /// Returns the camera for an image of `size` pixels. A perspective camera with a box in
    /// [`Camera::shows`] is moved to the nearest position from which it sees the whole box. Other
    /// cameras are returned unchanged.
    pub fn of_size(&self, size: [u32; 2]) -> Self {
        let (Some(bounds), Projection::Perspective { vertical_fov }) = (self.shows, self.projection) else {
            return self.clone();
        };
        let free = (1.0 - 2.0 * MARGIN) * tan(0.5 * vertical_fov);
        let slopes = Vec2::new(free * size[0] as f32 / size[1] as f32, free);
        let axes = Mat3::from(self.to_world.matrix3);
        let half = 0.5 * bounds.size();
        // P or N of an axis. Since a box is symmetric, the maximum over its corners is a sum of
        // absolute values.
        let reach = |axis: Vec3, slope: f32| half.dot((axis + slope * axes.z_axis).abs());
        let nearest = |axis: Vec3, slope: f32| 0.5 * (reach(axis, slope) + reach(-axis, slope)) / slope;
        let both = [(axes.x_axis, slopes.x), (axes.y_axis, slopes.y)];
        let distance = both.iter().fold(NEAREST, |d, (axis, slope)| d.max(nearest(*axis, *slope)));
        let aside = both.map(|(axis, slope)| {
            // Bisection for the smallest slope for which the distance suffices, to within 2⁻²⁴ of
            // the film's slope.
            let (mut low, mut high) = (0.0, slope);
            for _ in 0..24 {
                let middle = 0.5 * (low + high);
                if nearest(axis, middle) > distance { low = middle } else { high = middle }
            }
            0.5 * (reach(axis, high) - reach(-axis, high))
        });
        let aside = Vec2::from(aside);
        let eye = bounds.center() + axes * aside.extend(distance);
        let mut camera = self.clone();
        camera.to_world.translation = eye.into();
        if camera.lens.radius == 0.0 {
            camera.lens.focus_distance = distance;
        }
        camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(b: Aabb) -> impl Iterator<Item = Vec3> {
        (0..8).map(move |k| {
            let pick = |bit: i32, axis: usize| if k & bit == 0 { b.lo[axis] } else { b.hi[axis] };
            Vec3::new(pick(1, 0), pick(2, 1), pick(4, 2))
        })
    }

    /// Boxes and films of various proportions. Every corner of the box is on the film, and no
    /// nearer to its edge than the margin. Along one axis, the box touches the margin on both
    /// sides.
    #[test]
    fn the_box_fills_the_film_up_to_the_margin_in_any_proportions() {
        let boxes = [[3.0, 0.2, 0.1], [0.1, 90.0, 2.0], [1e-3, 1e-3, 5e-3], [2.0, 2.0, 2.0], [0.0, 4.0, 0.0]];
        for extent in boxes {
            let extent = Vec3::from(extent);
            let lo = Vec3::new(2.0, -1.0, 0.5) * extent.max_element();
            let bounds = Aabb { lo, hi: lo + extent };
            for size in [[640, 360], [100, 100], [300, 900], [2000, 100], [40, 1000]] {
                let camera = Camera::overview(bounds).of_size(size);
                let side = Vec2::new(size[0] as f32, size[1] as f32);
                let on_film = corners(bounds).map(|c| camera.project(c, size).expect("in front").0 / side);
                let seen: Vec<Vec2> = on_film.collect();
                let lo = seen.iter().copied().fold(Vec2::INFINITY, Vec2::min);
                let hi = seen.iter().copied().fold(Vec2::NEG_INFINITY, Vec2::max);
                let free = lo.min(1.0 - hi);
                assert!(free.min_element() > MARGIN - 1e-3, "{extent:?} in {size:?}: {lo} to {hi}");
                let aside = (lo - (1.0 - hi)).abs().max_element();
                assert!(aside < 2e-3, "{extent:?} in {size:?}: {lo} to {hi} is not in the middle");
                let both = lo.max(1.0 - hi).min_element();
                assert!(
                    both < MARGIN + 2e-3,
                    "{extent:?} in {size:?}: {lo} to {hi} leaves more than the margin"
                );
            }
        }
    }

    #[test]
    fn it_looks_from_the_front_the_right_and_above() {
        let bounds = Aabb { lo: Vec3::splat(-1.0), hi: Vec3::ONE };
        for size in [[640, 360], [300, 900]] {
            let camera = Camera::overview(bounds).of_size(size);
            let towards = -camera.to_world.transform_vector3(Vec3::NEG_Z);
            assert!(towards.x > 0.3 && towards.y > 0.2 && towards.z > 0.8, "{towards}");
            assert!(camera.to_world.transform_vector3(Vec3::Y).y > 0.9, "up is up");
        }
    }

    #[test]
    fn cameras_that_were_placed_stay() {
        let placed = Camera::look_at("c", Vec3::ONE, Vec3::ZERO, Vec3::Y, 0.5);
        assert_eq!(placed.of_size([10, 300]), placed);
    }
}
