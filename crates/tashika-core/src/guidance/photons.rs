//! Photons on surfaces: an estimate of the light that arrives there, by light paths alone.
//!
//! Camera paths may miss light that light paths find, and light paths may miss light that camera
//! paths find. The two are independent estimates of the same light. The VPLs of light paths are a
//! photon map (Jensen 1996). The radiance that a surface sends out is approximately
//!
//! ```text
//! L(x) = (Σ_i I_i − 2 √(Σ_i I_i²)) / (π r²)      over the photons within r of x that face the same way
//! ```
//!
//! The estimate is lowered by two standard errors, so that one bright light path counts for
//! nothing. It is too blurred for a picture. If another estimate finds much less light, however,
//! that estimate cannot be trusted.

use crate::math::{Aabb, Vec3};
use crate::vpl::{Clamp, Vpl, VplKind};

/// Ratio of the radius to the automatic clamp distance of the photons. A disk whose radius is the
/// clamp distance holds about 4 photons, a disk of this radius about 25.
const RADIUS: f32 = 2.5;
/// Least cosine between normals that count as facing the same way.
const SAME_WAY: f32 = 0.7;

/// Integer coordinates of a cell of a lattice.
pub(super) type Cell = [i32; 3];

/// Returns the cell of a position in a lattice of cells of the given size (m). Positions out of
/// range are in the cells at the ends.
pub(super) fn cell(position: Vec3, size: f32) -> Cell {
    (position / size).floor().to_array().map(|at| at as i32)
}

/// Cell, with the signed axis that is nearest to a normal: it separates the two sides of a thin
/// wall.
pub(super) type Side = (Cell, u8);

/// Returns the side of a surface at a position; in media `normal` is the direction in which light
/// arrived.
pub(super) fn side(position: Vec3, normal: Vec3, size: f32) -> Side {
    let axis = normal.abs().max_position() as u8;
    (cell(position, size), 2 * axis + u8::from(normal[usize::from(axis)] < 0.0))
}

/// Photon: the VPL that a light path leaves on a surface.
#[derive(Clone, Copy, Debug)]
struct Photon {
    cell: Cell,
    position: Vec3,
    /// Unit normal on the side that receives light.
    normal: Vec3,
    /// Luminance of the intensity (W·sr⁻¹).
    intensity: f32,
}

/// Photons on surfaces, by cells of a lattice.
#[derive(Clone, Debug)]
pub struct Photons {
    /// Sorted by cell.
    photons: Vec<Photon>,
    radius: f32,
}

impl Photons {
    /// Makes photons of the VPLs on surfaces, each with the number of its VPL; `None` if there are
    /// too few to estimate their spacing.
    pub(super) fn new(lights: &[Vpl], bounds: &Aabb, seed: u64) -> Option<(Self, Vec<usize>)> {
        let on_surfaces: Vec<Vpl> =
            lights.iter().filter(|light| light.kind == VplKind::Oriented).copied().collect();
        let radius = RADIUS * Clamp::Auto.distance(&on_surfaces, bounds, seed);
        (radius > 0.0).then(|| Self::within(lights, radius))
    }

    /// Makes photons of the VPLs on surfaces, each with the number of its VPL; they count within
    /// this radius (m).
    pub(super) fn within(lights: &[Vpl], radius: f32) -> (Self, Vec<usize>) {
        let photon = |light: &Vpl| Photon {
            cell: cell(light.position, radius),
            position: light.position,
            normal: light.direction,
            intensity: light.intensity.luminance(),
        };
        let on_surfaces = lights.iter().enumerate().filter(|(_, light)| light.kind == VplKind::Oriented);
        let mut photons: Vec<(usize, Photon)> = on_surfaces.map(|(k, light)| (k, photon(light))).collect();
        photons.sort_by_key(|(_, photon)| photon.cell);
        let (numbers, photons) = photons.into_iter().unzip();
        (Self { photons, radius }, numbers)
    }

    /// Returns the radius within which photons count (m).
    pub(super) fn radius(&self) -> f32 {
        self.radius
    }

    /// Returns the approximate luminance that a surface sends out, less two standard errors
    /// (W·m⁻²·sr⁻¹).
    pub fn importance_radiance(&self, position: Vec3, normal: Vec3) -> f64 {
        self.each_near(position, normal, |_| {})
    }

    /// Calls `see` with the index of each photon that counts. Returns
    /// [`importance_radiance`](Self::importance_radiance).
    pub(super) fn each_near(&self, position: Vec3, normal: Vec3, mut see: impl FnMut(usize)) -> f64 {
        let [mut sum, mut squares] = [0.0; 2];
        let [x, y, z] = cell(position, self.radius);
        let around = |at: i32| at.saturating_sub(1)..=at.saturating_add(1);
        for (x, y) in around(x).flat_map(|x| around(y).map(move |y| (x, y))) {
            let of_column = [x, y, z.saturating_sub(1)]..=[x, y, z.saturating_add(1)];
            let first = self.photons.partition_point(|photon| photon.cell < *of_column.start());
            let column = self.photons[first..].iter().take_while(|photon| of_column.contains(&photon.cell));
            for (number, photon) in (first..).zip(column) {
                let is_near = photon.position.distance_squared(position) < self.radius * self.radius;
                if is_near && photon.normal.dot(normal) > SAME_WAY {
                    let intensity = f64::from(photon.intensity);
                    sum += intensity;
                    squares += intensity * intensity;
                    see(number);
                }
            }
        }
        let least = f64::max(sum - 2.0 * squares.sqrt(), 0.0);
        least / (std::f64::consts::PI * f64::from(self.radius) * f64::from(self.radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::rng::{Purpose, Stream};

    /// The luminance of an evenly lit wall is found on its lit side, and zero elsewhere.
    #[test]
    fn the_lit_side_of_a_wall_has_the_account() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let (n, side) = (20_000, 4.0);
        let mut light = || Vpl {
            position: Vec3::new(side * s.uniform(), side * s.uniform() - 2.0, 1.0),
            direction: Vec3::Z,
            intensity: Rgb::gray(1.0 / n as f32),
            kind: VplKind::Oriented,
        };
        let lights: Vec<Vpl> = (0..n).map(|_| light()).collect();
        let (photons, numbers) = Photons::within(&lights, 0.2);
        let at = |x: f32, z: f32, normal| photons.importance_radiance(Vec3::new(x, 0.1, z), normal);
        // 157 photons, less two standard errors of 8 % each.
        let expected = 0.84 / f64::from(side * side);
        let found = at(1.7, 1.01, Vec3::Z);
        assert!((found / expected - 1.0).abs() < 0.35, "{found} for {expected}");
        let single = Photons::within(&[light()], 9.0).0;
        assert_eq!(single.importance_radiance(Vec3::Z, Vec3::Z), 0.0);
        assert_eq!([at(1.7, 1.01, Vec3::NEG_Z), at(1.7, 1.3, Vec3::Z), at(-0.3, 1.0, Vec3::Z)], [0.0; 3]);
        for (photon, number) in photons.photons.iter().zip(numbers) {
            assert_eq!(photon.position, lights[number].position);
        }
    }
}
