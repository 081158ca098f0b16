//! Surface area orientation heuristic: the cost of a cluster of lights.
//!
//! ```text
//! cost = Φ · M_A · M_Ω        Φ: luminance   M_A: surface area of the box (m²)   M_Ω: solid angle reached (sr)
//! M_Ω  = 2π (1 − cos θ_o) + π/2 (2 θ_w sin θ_o − cos(θ_o − 2 θ_w) − 2 θ_o sin θ_o + cos θ_o),   θ_w = min(θ_o + θ_e, π)
//! ```
//!
//! from Conty Estévez, Kulla 2018, section 4.2. `θ_o` is the half-angle of the cone around the
//! normals, and `θ_e` the half-angle around its normal into which a light shines.
//!
//! # Differences from the source
//! `θ_o` is estimated from the box of the unit normals. Let `h` be half its diagonal. For `h ≤ 1`,
//! `sin θ_o = h` (exact for two normals); beyond, `cos θ_o` falls linearly in `h²` to the whole
//! sphere at `h² = 3`. The union of two boxes takes six comparisons, whereas the union of cones
//! needs trigonometry. The estimate is used only for costs, never for bounds.

use std::f32::consts::{FRAC_PI_2, PI};

use super::build::Item;
use crate::math::elementary::{acos, sin_cos};
use crate::vpl::{Vpl, VplKind};

/// Number of intervals of the table of `M_Ω`.
const STEPS: usize = 256;
/// Area of a line of unit length. Lights in a row have no area, but shorter rows are better
/// clusters. The value is too small to matter if there is area.
const AREA_OF_LINES: f32 = 1e-6;
/// Asymmetry above which a phase function is treated as shining to one side.
const LOBE: f32 = 0.1;
/// Largest `h²` of a box of unit vectors.
const MAX_SPREAD: f32 = 3.0;

/// `M_Ω` for one kind of light, tabulated over `h²`.
pub(super) struct Emission {
    table: Vec<f32>,
    /// True if the lights have directions in addition to their positions.
    pub(super) directed: bool,
}

impl Emission {
    /// Emission of the lights of a kind. All spots are treated as having the widest cone among
    /// them, and lights in media as emitting with a cosine.
    pub(super) fn of_kind(kind: usize, lights: &[Vpl]) -> Self {
        let cos_emission = lights
            .iter()
            .filter(|light| light.kind.number() == kind)
            .filter_map(|light| match light.kind {
                VplKind::Spot(falloff) => Some(falloff.cos_outer),
                VplKind::Image(beam) => Some(beam.cos_outer),
                VplKind::Oriented => Some(0.0),
                // Only the half-space into which a lobe shines matters.
                VplKind::Volume(phase) => (phase.asymmetry.abs() > LOBE).then_some(0.0),
                VplKind::Omni | VplKind::Directional => None,
            })
            .reduce(f32::min);
        let Some(cos_emission) = cos_emission else {
            return Self { table: vec![1.0; STEPS + 2], directed: false };
        };
        let emission = acos(cos_emission.clamp(-1.0, 1.0));
        let table = (0..STEPS + 2).map(|k| solid_angle(k as f32 * (MAX_SPREAD / STEPS as f32), emission));
        Self { table: table.collect(), directed: true }
    }

    /// Cost of a cluster for one unit of luminance (m²·sr).
    pub(super) fn cost(&self, bounds: &Bounds6) -> f32 {
        let e = bounds.extent();
        let spread = 0.25 * (e[3] * e[3] + e[4] * e[4] + e[5] * e[5]);
        let x = spread.clamp(0.0, MAX_SPREAD) * (STEPS as f32 / MAX_SPREAD);
        let k = x as usize;
        let solid_angle = self.table[k] + (x - k as f32) * (self.table[k + 1] - self.table[k]);
        let area = e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
        let squared_diagonal = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
        (area + AREA_OF_LINES * squared_diagonal) * solid_angle
    }
}

/// `M_Ω` (sr) of normals in a box with squared half diagonal `spread`.
fn solid_angle(spread: f32, emission: f32) -> f32 {
    let cosine = if spread <= 1.0 { (1.0 - spread).sqrt() } else { ((1.0 - spread) * 0.5).max(-1.0) };
    let normals = acos(cosine);
    let reached = (normals + emission).min(PI);
    let (sine, cosine) = sin_cos(normals);
    let (_, inner) = sin_cos(normals - 2.0 * reached);
    let rim = 2.0 * (reached - normals) * sine - inner + cosine;
    2.0 * PI * (1.0 - cosine) + FRAC_PI_2 * rim
}

/// A box of positions (m) and unit directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds6 {
    pub(super) lo: [f32; 6],
    pub(super) hi: [f32; 6],
}

impl Bounds6 {
    pub(super) const EMPTY: Self = Self { lo: [f32::INFINITY; 6], hi: [f32::NEG_INFINITY; 6] };

    /// Extends the box to contain an item.
    #[inline]
    pub(super) fn insert(&mut self, item: &Item) {
        for axis in 0..6 {
            self.lo[axis] = least(self.lo[axis], item.key[axis]);
            self.hi[axis] = most(self.hi[axis], item.key[axis]);
        }
    }

    /// Extends the box to contain another box.
    #[inline]
    pub(super) fn unite(&mut self, other: &Self) {
        for axis in 0..6 {
            self.lo[axis] = least(self.lo[axis], other.lo[axis]);
            self.hi[axis] = most(self.hi[axis], other.hi[axis]);
        }
    }

    pub(super) fn extent(&self) -> [f32; 6] {
        std::array::from_fn(|axis| self.hi[axis] - self.lo[axis])
    }

    /// Diagonal of the box of positions (m).
    pub(super) fn diagonal(&self) -> f32 {
        let e = self.extent();
        (e[0] * e[0] + e[1] * e[1] + e[2] * e[2]).sqrt()
    }
}

/// The smaller of two numbers, in one instruction; `f32::min` needs more instructions because of
/// NaN.
#[inline]
fn least(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline]
fn most(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solid_angle_has_its_known_values() {
        // A plane of lights with a cosine: π sr. Lights whose normals point everywhere: 4π sr. A
        // thin beam: 0 sr.
        assert!((solid_angle(0.0, FRAC_PI_2) - PI).abs() < 1e-5);
        assert!((solid_angle(MAX_SPREAD, FRAC_PI_2) - 4.0 * PI).abs() < 1e-4);
        assert!(solid_angle(0.0, 0.0).abs() < 1e-5);
        let table: Vec<f32> = (0..=60).map(|k| solid_angle(k as f32 * 0.05, FRAC_PI_2)).collect();
        assert!(table.is_sorted(), "wider cones cost more: {table:?}");
    }
}
