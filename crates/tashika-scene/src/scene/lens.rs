//! The lens of a camera: a round opening, or the polygon between the blades of a diaphragm.
//!
//! In the image, a point of light that is out of focus has the shape of the opening. Points of the
//! opening are sampled uniformly by area. The opening between `n` blades is a regular polygon with
//! its corners on the circle of the lens' radius, as in Blender's Cycles. Its area is
//!
//! ```text
//! A = n/2 · sin(2π / n) · radius²          n = 5: 0.757 of the disk, 6: 0.827, 8: 0.900
//! ```
//!
//! # Held to this by
//! `tests`; `warp::polygon` by those of `warp`.

use glam::Vec2;

use crate::warp;

/// A lens with an opening; it blurs objects away from the focus distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the opening (m); zero is a pinhole.
    pub radius: f32,
    /// Distance along the axis at which the image is sharp (m).
    pub focus_distance: f32,
    /// Blades around the opening; if `None`, the opening is a disk.
    pub blades: Option<Blades>,
}

/// The blades of a diaphragm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blades {
    /// Number of blades: [`Blades::FEWEST`] to [`Blades::MOST`].
    pub count: u32,
    /// Rotation of the polygon (radians), counter-clockwise as seen by the camera; at zero a corner
    /// is up.
    pub rotation: f32,
}

impl Blades {
    /// Smallest number of blades that leave an opening.
    pub const FEWEST: u32 = 3;
    /// Largest number of blades; more would look like a disk.
    pub const MOST: u32 = 100;
}

impl Lens {
    /// A pinhole: everything is sharp.
    pub const PINHOLE: Self = Self { radius: 0.0, focus_distance: 1.0, blades: None };

    /// A round opening of `radius` (m), sharp at `focus_distance` (m).
    pub fn round(radius: f32, focus_distance: f32) -> Self {
        Self { radius, focus_distance, blades: None }
    }

    /// Maps two uniform numbers to a point of the opening (m; x to the right, y up), uniform by
    /// area.
    pub fn point(&self, u: [f32; 2]) -> Vec2 {
        match self.blades {
            None => warp::disk(u) * self.radius,
            Some(Blades { count, rotation }) => warp::polygon(u, count, rotation) * self.radius,
        }
    }

    /// Returns true if its parameters are in range.
    pub(super) fn is_valid(&self) -> bool {
        let focus = self.focus_distance;
        let blades = self.blades.is_none_or(|blades| {
            (Blades::FEWEST..=Blades::MOST).contains(&blades.count) && blades.rotation.is_finite()
        });
        self.radius >= 0.0
            && self.radius.is_finite()
            && (self.radius == 0.0 || (focus > 0.0 && focus.is_finite()))
            && blades
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::sin_cos;
    use crate::rng::{Purpose, Stream};

    #[test]
    fn openings_of_blades_have_their_corners_on_the_circle_and_the_first_up() {
        for count in [3, 5, 6, 8] {
            for rotation in [0.0, 0.4] {
                let lens = Lens { blades: Some(Blades { count, rotation }), ..Lens::round(0.2, 1.0) };
                let mut s = Stream::new(1, Purpose::Test, 0);
                // Towards a corner, the opening extends to the radius; towards the middle of a
                // blade, to cos(π/n) times the radius.
                let turn = |k: f32| {
                    let angle = rotation + std::f32::consts::TAU * k / count as f32;
                    Vec2::new(-sin_cos(angle).0, sin_cos(angle).1)
                };
                let (mut corner, mut blade) = (0.0f32, 0.0f32);
                for _ in 0..40_000 {
                    let p = lens.point(s.uniform_2());
                    corner = corner.max(p.dot(turn(1.0)));
                    blade = blade.max(p.dot(turn(0.5)));
                }
                let inner = sin_cos(std::f32::consts::PI / count as f32).1;
                assert!((0.197..=0.200_001).contains(&corner), "{count}: {corner}");
                assert!((0.995..=1.000_01).contains(&(blade / (0.2 * inner))), "{count}: {blade}");
            }
        }
    }

    #[test]
    fn lenses_out_of_range_are_not_valid() {
        let blades =
            |count, rotation| Lens { blades: Some(Blades { count, rotation }), ..Lens::round(0.1, 1.0) };
        assert!(Lens::PINHOLE.is_valid() && Lens::round(0.1, 2.0).is_valid() && blades(3, -7.0).is_valid());
        assert!(!Lens::round(-0.1, 2.0).is_valid() && !Lens::round(f32::NAN, 2.0).is_valid());
        assert!(!Lens::round(0.1, 0.0).is_valid() && !Lens::round(0.1, f32::INFINITY).is_valid());
        assert!(
            !blades(2, 0.0).is_valid() && !blades(101, 0.0).is_valid() && !blades(6, f32::NAN).is_valid()
        );
    }
}
