//! Numbers or colours on a lattice in a box, for media that vary from place to place.
//!
//! An affine map places the unit cube in the world; its image is the box. Along each axis, the box
//! has `n` cells, with a sample in the middle of each ([`VolumeSamples::Centers`]). Between
//! samples, values are interpolated trilinearly. The coordinates of a place are counted in cells,
//!
//! ```text
//! cell(x) = n · to_world⁻¹(x)          sample k is at k + ½          k = 0 … n − 1
//! ```
//!
//! so that rays and blocks of cells share one coordinate system. Values beyond the outermost
//! samples are defined by [`VolumeEdges`].
//!
//! # Guarantee
//! There is one value for each sample; all are finite and at least 0. The affine map can be
//! inverted.
//!
//! # Held to this by
//! The tests below.

use std::ops::{Add, Mul};

use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::math::{DAffine3, DMat3, DVec3};

/// Values of a [`VolumeGrid`]; the index along the first axis runs fastest.
#[derive(Clone, Debug, PartialEq)]
pub enum VolumeValues {
    /// One number per sample, for all channels.
    Numbers(Vec<f32>),
    /// One colour per sample.
    Colors(Vec<Rgb>),
}

impl VolumeValues {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Colors(values) => values.len(),
        }
    }

    /// Returns true if there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Value of a sample, by its index.
    #[inline]
    pub fn get(&self, index: usize) -> Rgb {
        match self {
            Self::Numbers(values) => Rgb::gray(values[index]),
            Self::Colors(values) => values[index],
        }
    }
}

/// Positions of the samples in the box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VolumeSamples {
    /// In the middle of `n` cells.
    #[default]
    Centers,
    /// At the corners of `n − 1` cells, so that the outermost samples lie on the faces of the box.
    /// Along an axis with only one sample, the sample is in the middle.
    Corners,
}

/// Values beyond the outermost samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VolumeEdges {
    /// The value of the nearest sample.
    #[default]
    Held,
    /// Zero, reached linearly within one cell.
    Zero,
}

/// Input of [`VolumeGrid::new`].
#[derive(Clone, Debug)]
pub struct VolumeData {
    /// Samples along each axis, at least 1.
    pub counts: [u32; 3],
    /// One value for each sample.
    pub values: VolumeValues,
    /// Map from the unit cube to the world (m).
    pub to_world: DAffine3,
    /// Positions of the samples in the unit cube.
    pub samples: VolumeSamples,
    /// Values beyond the outermost samples.
    pub edges: VolumeEdges,
}

/// Numbers or colours on a lattice in a box.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeGrid {
    counts: [u32; 3],
    values: VolumeValues,
    edges: VolumeEdges,
    /// Map from the world to cells.
    to_cells: DAffine3,
    /// The box, in cells.
    bounds: [DVec3; 2],
    /// Sum of the lengths of the box's three edges (m): no segment in the box is longer.
    longest: f64,
}

impl VolumeGrid {
    /// Creates the grid of `data`; `at` is the location that error messages name.
    ///
    /// # Errors
    /// [`Error::Invalid`] if there is no sample, if the numbers of values and samples differ, if
    /// values are negative or not finite, or if the box has no volume.
    pub fn new(data: VolumeData, at: &Location) -> Result<Self> {
        let VolumeData { counts, values, to_world, samples, edges } = data;
        let invalid = |found: String, expected: &str| Err(Error::invalid(at.clone(), found, expected));
        let [nx, ny, nz] = counts;
        let needed = u128::from(nx) * u128::from(ny) * u128::from(nz);
        if needed == 0 || needed != values.len() as u128 {
            let found = format!("{} values for a grid of {nx}×{ny}×{nz}", values.len());
            return invalid(found, "one value for each of at least one cell");
        }
        if let Some(wrong) = (0..values.len()).find(|&i| !values.get(i).is_valid()) {
            let (x, y, z) =
                (wrong % nx as usize, wrong / nx as usize % ny as usize, wrong / (nx as usize * ny as usize));
            let found = match &values {
                VolumeValues::Numbers(values) => format!("{}", values[wrong]),
                VolumeValues::Colors(values) => format!("{:?}", values[wrong].to_array()),
            };
            return invalid(
                format!("a grid with {found} in cell ({x}, {y}, {z})"),
                "finite values of at least 0",
            );
        }
        let m = to_world.matrix3;
        let axes = [m.x_axis, m.y_axis, m.z_axis];
        let inverse = to_world.inverse();
        let has_volume = to_world.is_finite() && m.determinant() != 0.0 && inverse.is_finite();
        if !has_volume {
            let edges = axes.map(|axis| axis.length() as f32);
            return invalid(format!("a grid in a box with edges of {edges:?} m that has no volume"), "a box");
        }
        let [mut scale, mut shift, mut bounds] = [DVec3::ONE, DVec3::ZERO, DVec3::ZERO];
        for (axis, &count) in counts.iter().enumerate() {
            let corners = samples == VolumeSamples::Corners && count > 1;
            scale[axis] = f64::from(if corners { count - 1 } else { count });
            shift[axis] = if corners { 0.5 } else { 0.0 };
            bounds[axis] = scale[axis] + shift[axis];
        }
        let to_cells = DAffine3::from_mat3_translation(DMat3::from_diagonal(scale), shift) * inverse;
        let longest = axes.iter().map(|axis| axis.length()).sum();
        Ok(Self { counts, values, edges, to_cells, bounds: [shift, bounds], longest })
    }

    /// Number of samples along each axis.
    pub fn counts(&self) -> [u32; 3] {
        self.counts
    }

    /// Values of the samples, one for each.
    pub fn values(&self) -> &VolumeValues {
        &self.values
    }

    /// Values beyond the outermost samples.
    pub fn edges(&self) -> VolumeEdges {
        self.edges
    }

    /// The largest value of each channel.
    pub fn most(&self) -> Rgb {
        (0..self.values.len()).map(|i| self.values.get(i)).fold(Rgb::BLACK, |a, b| a.zip(b, f32::max))
    }

    /// Upper bound on the length of a segment in the box (m).
    pub fn longest(&self) -> f64 {
        self.longest
    }

    /// The box in cells: its lowest and highest corner.
    #[inline]
    pub fn bounds(&self) -> [DVec3; 2] {
        self.bounds
    }

    /// Map from the world (m) to cells.
    #[inline]
    pub fn to_cells(&self) -> &DAffine3 {
        &self.to_cells
    }

    /// Makes positions relative to `origin` (m).
    pub(super) fn move_by(&mut self, origin: DVec3) {
        self.to_cells.translation = self.to_cells.transform_point3(origin);
    }

    /// Value at a place (in cells), which may be outside of the box.
    #[inline]
    pub fn at(&self, place: DVec3) -> Rgb {
        let corners = [0, 1, 2].map(|axis| self.neighbours(axis, place[axis]));
        match &self.values {
            VolumeValues::Numbers(values) => Rgb::gray(self.blend(corners, 0.0, values)),
            VolumeValues::Colors(values) => self.blend(corners, Rgb::BLACK, values),
        }
    }

    /// Indices of the two samples next to a place along an axis, with their weights.
    #[inline]
    fn neighbours(&self, axis: usize, place: f64) -> [(usize, f32); 2] {
        let below = (place - 0.5).floor();
        let share = (place - 0.5 - below) as f32;
        let last = i64::from(self.counts[axis]) - 1;
        [(below as i64, 1.0 - share), ((below as i64).saturating_add(1), share)].map(|(k, weight)| {
            let inside = k.clamp(0, last);
            let fades = self.edges == VolumeEdges::Zero && inside != k;
            (inside as usize, if fades { 0.0 } else { weight })
        })
    }

    #[inline]
    fn blend<T>(&self, [x, y, z]: [[(usize, f32); 2]; 3], zero: T, values: &[T]) -> T
    where
        T: Copy + Add<Output = T> + Mul<f32, Output = T>,
    {
        let [nx, ny, _] = self.counts.map(|n| n as usize);
        let mut sum = zero;
        for (k, of_z) in z {
            for (j, of_y) in y {
                let row = (k * ny + j) * nx;
                let along = values[row + x[0].0] * x[0].1 + values[row + x[1].0] * x[1].1;
                sum = sum + along * (of_y * of_z);
            }
        }
        sum
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::math::Vec3;

    pub(in crate::scene) fn data(counts: [u32; 3], value: impl Fn([u32; 3]) -> f32) -> VolumeData {
        let [nx, ny, nz] = counts;
        let cells = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        VolumeData {
            counts,
            values: VolumeValues::Numbers(cells.map(value).collect()),
            to_world: DAffine3::IDENTITY,
            samples: VolumeSamples::Centers,
            edges: VolumeEdges::Held,
        }
    }

    pub(in crate::scene) fn grid(data: VolumeData) -> VolumeGrid {
        VolumeGrid::new(data, &Location::file("g")).unwrap()
    }

    fn value(grid: &VolumeGrid, place: Vec3) -> f32 {
        grid.at(grid.to_cells().transform_point3(place.as_dvec3())).g
    }

    /// A grid with the samples of a function that is linear in each coordinate. Between samples,
    /// the grid reproduces the function, for every placement of the box.
    #[test]
    fn values_are_trilinear_between_the_samples_of_the_box() {
        let slope = |x: f32, y: f32, z: f32| 1.0 + 2.0 * x + 3.0 * y + 5.0 * z + x * y * z;
        let counts = [4, 3, 5];
        let turned = crate::math::Affine3A::from_scale_rotation_translation(
            Vec3::new(2.0, -3.0, 0.5),
            crate::math::elementary::rotation(Vec3::new(0.6, 0.0, 0.8), 0.7),
            Vec3::new(7.0, -1.0, 0.25),
        );
        for samples in [VolumeSamples::Centers, VolumeSamples::Corners] {
            for to_world in [DAffine3::IDENTITY, turned.as_daffine3()] {
                let is_center = samples == VolumeSamples::Centers;
                let unit = move |k: u32, n: u32| {
                    if is_center { (k as f32 + 0.5) / n as f32 } else { k as f32 / (n - 1) as f32 }
                };
                let at = move |c: [u32; 3]| slope(unit(c[0], 4), unit(c[1], 3), unit(c[2], 5));
                let grid = grid(VolumeData { to_world, samples, ..data(counts, at) });
                // These places are between samples for both kinds of sample positions.
                for place in [[0.3, 0.4, 0.5], [0.2, 0.7, 0.15], [0.8, 0.5, 0.88]].map(Vec3::from) {
                    let found = value(&grid, to_world.transform_point3(place.as_dvec3()).as_vec3());
                    let expected = slope(place.x, place.y, place.z);
                    assert!((found - expected).abs() < 1e-5 * expected, "{found} for {expected}");
                }
                assert!(
                    (grid.longest() - if to_world != DAffine3::IDENTITY { 5.5 } else { 3.0 }).abs() < 1e-6
                );
            }
        }
    }

    #[test]
    fn edges_hold_the_outermost_value_or_fall_to_zero() {
        let of = |edges| grid(VolumeData { edges, ..data([2, 1, 1], |[x, ..]| 1.0 + x as f32) });
        let [held, zero] = [VolumeEdges::Held, VolumeEdges::Zero].map(of);
        let at = |grid: &VolumeGrid, x: f64| grid.at(DVec3::new(x, 0.5, 0.5)).r;
        for (x, of_held, of_zero) in [
            (-9.0, 1.0, 0.0),
            (0.0, 1.0, 0.5),
            (0.5, 1.0, 1.0),
            (1.0, 1.5, 1.5),
            (2.0, 2.0, 1.0),
            (1e30, 2.0, 0.0),
        ] {
            assert_eq!([at(&held, x), at(&zero, x)], [of_held, of_zero], "{x}");
        }
        let colors = VolumeValues::Colors(vec![Rgb::new(1.0, 2.0, 3.0), Rgb::new(3.0, 2.0, 1.0)]);
        let colors = grid(VolumeData { values: colors, ..data([2, 1, 1], |_| 0.0) });
        assert_eq!(colors.at(DVec3::new(1.0, 0.5, 0.5)), Rgb::gray(2.0));
        assert_eq!(colors.most(), Rgb::new(3.0, 2.0, 3.0));
    }

    #[test]
    fn wrong_grids_are_refused_with_what_is_expected() {
        let said =
            |data: VolumeData| VolumeGrid::new(data, &Location::file("g.vol")).unwrap_err().to_string();
        let fine = || data([2, 3, 1], |_| 1.0);
        let short = said(VolumeData { counts: [2, 3, 2], ..fine() });
        assert_eq!(
            short,
            "g.vol: 6 values for a grid of 2×3×2; expected one value for each of at least one cell"
        );
        for counts in [[0, 3, 1], [u32::MAX; 3]] {
            assert!(said(VolumeData { counts, ..fine() }).contains("6 values for a grid of"));
        }
        for (wrong, shown) in [(-1.0, "-1"), (f32::NAN, "NaN"), (f32::INFINITY, "inf")] {
            let said = said(data([2, 3, 1], |c| if c == [1, 2, 0] { wrong } else { 1.0 }));
            assert_eq!(
                said,
                format!("g.vol: a grid with {shown} in cell (1, 2, 0); expected finite values of at least 0")
            );
        }
        for flat in [Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), Vec3::new(f32::NAN, 1.0, 1.0), Vec3::splat(1e-30)]
        {
            let to_world = crate::math::Affine3A::from_scale(flat).as_daffine3();
            let error = VolumeGrid::new(VolumeData { to_world, ..fine() }, &Location::file("g"));
            if flat.x == 1e-30 {
                assert!(error.is_ok(), "small is not flat");
            } else {
                assert!(error.unwrap_err().to_string().contains("has no volume"), "{flat}");
            }
        }
    }
}
