//! Integrals over directions, in `f64`, for comparison with sampling and closed forms.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::Vec3;

/// Nodes and weights of the four-point Gauss–Legendre rule on `[0, 1]`.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Largest number of refinements of a cell.
const MAX_LEVELS: u32 = 8;

/// Rectangle in the two parameters of a [`PolarGrid`].
#[derive(Clone, Copy)]
struct Rectangle {
    low: [f64; 2],
    high: [f64; 2],
}

impl Rectangle {
    fn quarters(self) -> [Self; 4] {
        let middle = [0, 1].map(|axis| 0.5 * (self.low[axis] + self.high[axis]));
        [0, 1, 2, 3].map(|quarter| {
            let upper = [quarter & 1 == 1, quarter & 2 == 2];
            let pick = |axis: usize, a: [f64; 2], b: [f64; 2]| if upper[axis] { a[axis] } else { b[axis] };
            Self {
                low: [pick(0, middle, self.low), pick(1, middle, self.low)],
                high: [pick(0, self.high, middle), pick(1, self.high, middle)],
            }
        })
    }
}

/// The sphere of directions cut into `rings × sectors` cells around an axis.
///
/// Rings are uniform in `q ∈ [0, 1]`, where `1 − cos θ = width (exp(c q) − 1)` reaches the opposite
/// pole at `q = 1`. They are nearly uniform in `1 − cos θ` where it is below `width`, and in its
/// logarithm where it is above. A lobe of any width around the axis, its tail, and a second, wide
/// lobe are therefore all resolved.
pub struct PolarGrid {
    axes: [DVec3; 3],
    width: f64,
    rings: usize,
    sectors: usize,
    min_levels: u32,
}

impl PolarGrid {
    /// Creates a grid around `axis` for a lobe of this width.
    pub fn about(axis: Vec3, width: f64, rings: usize, sectors: usize) -> Self {
        let axis = axis.as_dvec3().normalize();
        let (t, b) = axis.any_orthonormal_pair();
        Self { axes: [t, b, axis], width, rings, sectors, min_levels: 0 }
    }

    /// Sets the least number of refinements of a cell. It is needed for a narrow lobe with nothing
    /// around it, which may lie between the first nodes.
    pub fn refined(self, min_levels: u32) -> Self {
        Self { min_levels, ..self }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.rings * self.sectors
    }

    /// Factor `c`, the logarithm of the range of rings.
    fn logarithm(&self) -> f64 {
        (2.0 / self.width).ln_1p()
    }

    /// Returns the index of the cell that contains direction `w`.
    pub fn cell(&self, w: Vec3) -> usize {
        let w = w.as_dvec3().normalize();
        // Computed from the distance to the axis, because 1 − cos would subtract nearly equal
        // numbers.
        let versine = 0.5 * (w - self.axes[2]).length_squared();
        let q = (versine / self.width).ln_1p() / self.logarithm();
        let phi = w.dot(self.axes[1]).atan2(w.dot(self.axes[0])) / (2.0 * PI);
        let index = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
        index(q, self.rings) * self.sectors + index(phi.rem_euclid(1.0), self.sectors)
    }

    /// Returns the direction of parameters `(q, φ / 2π)` and the solid angle per unit area of the
    /// parameters (sr).
    fn direction(&self, parameters: [f64; 2]) -> (Vec3, f64) {
        let versine = self.width * (self.logarithm() * parameters[0]).exp_m1();
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (2.0 * PI * parameters[1]).sin_cos();
        let [t, b, axis] = self.axes;
        let w = t * (sin * cos_phi) + b * (sin * sin_phi) + axis * (1.0 - versine);
        let solid_angle = 2.0 * PI * self.logarithm() * (self.width + versine);
        (w.as_vec3(), solid_angle)
    }

    /// Integrates `f` over one cell by recursive refinement, each step to within `tolerance`.
    pub fn integrate_cell(&self, cell: usize, tolerance: f64, f: &dyn Fn(Vec3) -> f64) -> f64 {
        let (ring, sector) = (cell / self.sectors, cell % self.sectors);
        let corner = |r: usize, s: usize| [r as f64 / self.rings as f64, s as f64 / self.sectors as f64];
        let whole = Rectangle { low: corner(ring, sector), high: corner(ring + 1, sector + 1) };
        self.refine(whole, self.gauss(whole, f), tolerance, 0, f)
    }

    /// Integrates `f` over the sphere.
    pub fn integrate(&self, tolerance: f64, f: &dyn Fn(Vec3) -> f64) -> f64 {
        (0..self.len()).map(|cell| self.integrate_cell(cell, tolerance, f)).sum()
    }

    fn gauss(&self, r: Rectangle, f: &dyn Fn(Vec3) -> f64) -> f64 {
        let size = [r.high[0] - r.low[0], r.high[1] - r.low[1]];
        let mut sum = 0.0;
        for (x, wx) in GAUSS {
            for (y, wy) in GAUSS {
                let (w, solid_angle) = self.direction([r.low[0] + size[0] * x, r.low[1] + size[1] * y]);
                sum += wx * wy * solid_angle * f(w);
            }
        }
        sum * size[0] * size[1]
    }

    fn refine(
        &self,
        r: Rectangle,
        estimate: f64,
        tolerance: f64,
        depth: u32,
        f: &dyn Fn(Vec3) -> f64,
    ) -> f64 {
        let quarters = r.quarters().map(|quarter| (quarter, self.gauss(quarter, f)));
        let refined: f64 = quarters.iter().map(|(_, value)| value).sum();
        if depth == MAX_LEVELS || depth >= self.min_levels && (refined - estimate).abs() <= tolerance {
            return refined;
        }
        quarters.into_iter().map(|(q, value)| self.refine(q, value, tolerance, depth + 1, f)).sum()
    }
}

/// Integrates `f` over the upper hemisphere, for functions without peaks.
pub fn hemisphere(f: &dyn Fn(Vec3) -> f64) -> f64 {
    // For width → ∞, rings are uniform in the cosine, and 8 of 16 cover the upper half.
    let grid = PolarGrid::about(Vec3::Z, 1e9, 16, 16);
    (0..grid.len() / 2).map(|cell| grid.integrate_cell(cell, 1e-8, f)).sum()
}

#[test]
fn solid_angles_and_moments_are_right() {
    assert!((hemisphere(&|_| 1.0) - 2.0 * PI).abs() < 1e-6);
    assert!((hemisphere(&|w| f64::from(w.z)) - PI).abs() < 1e-6);
    let grid = PolarGrid::about(Vec3::new(0.6, 0.0, 0.8), 1e-3, 16, 8);
    assert!((grid.integrate(1e-9, &|_| 1.0) - 4.0 * PI).abs() < 1e-6);
    let mut stream = super::stream(1);
    for cell in (0..grid.len()).step_by(7) {
        // A direction from the interior of a cell is counted in that cell.
        let parameters = [
            ((cell / 8) as f64 + 0.1 + 0.8 * stream.uniform_f64()) / 16.0,
            ((cell % 8) as f64 + 0.1 + 0.8 * stream.uniform_f64()) / 8.0,
        ];
        assert_eq!(grid.cell(grid.direction(parameters).0), cell);
    }
}
