//! Directions of paths, from the kernel of a vertex and from caustics learned by light paths.
//!
//! ```text
//! p(ω) = (1 − α) p_kernel(ω) + α p_caustics(ω)        α ≤ ½, by the share of caustics in the light around
//! ```
//!
//! Both strategies together have one density. Weights against drawn emitters use this density, so
//! estimates are unbiased whatever was learned.

use glam::Vec3;

use super::Compensation;
use super::places::Receiver;
use super::vertex::{Kernel, Vertex};
use crate::color::Rgb;

impl Compensation<'_> {
    /// Looks up the directions of caustics at a receiver.
    pub(super) fn look_for_caustics(&mut self, receiver: &Receiver) {
        let Some(caustics) = self.lit.caustics else { return };
        self.directions.clear();
        let look = |normal| caustics.look_for_directions(receiver.position, normal, &mut self.directions);
        self.importance_caustic = receiver.normal.map_or(0.0, look);
    }

    /// Returns the share of directions for a kernel that is drawn from caustics.
    fn share_of_caustics(&self, vertex: &Vertex, kernel: Kernel) -> f32 {
        let share = self.directions.share();
        if share > 0.0 && vertex.is_diffuse(kernel) { share } else { 0.0 }
    }

    /// Draws a direction for a kernel, from the kernel and from caustics. Returns the direction,
    /// its density (sr⁻¹), and the kernel divided by that density; `None` if the path ends.
    pub(super) fn direction(
        &self,
        vertex: &Vertex,
        kernel: Kernel,
        [u, v @ ..]: [f32; 3],
    ) -> Option<(Vec3, f32, Rgb)> {
        let share = self.share_of_caustics(vertex, kernel);
        if share == 0.0 {
            return vertex.sample(kernel, [u, v[0], v[1]]);
        }
        let direction = if u < share {
            self.directions.sample([u / share, v[0], v[1]])?
        } else {
            let left = ((u - share) / (1.0 - share)).min(1.0_f32.next_down());
            vertex.sample(kernel, [left, v[0], v[1]])?.0
        };
        let (density, value) = (self.density(vertex, kernel, direction), vertex.value(kernel, direction));
        Some((direction, density, value / density)).filter(|_| !value.is_black())
    }

    /// Returns the density with which [`direction`](Self::direction) draws a unit direction (sr⁻¹).
    pub(super) fn density(&self, vertex: &Vertex, kernel: Kernel, direction: Vec3) -> f32 {
        let of_kernel = vertex.density(kernel, direction);
        match self.share_of_caustics(vertex, kernel) {
            0.0 => of_kernel,
            share => (1.0 - share) * of_kernel + share * self.directions.density(direction),
        }
    }
}
