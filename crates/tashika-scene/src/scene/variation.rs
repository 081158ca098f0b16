//! Variation of a medium from place to place: its density, and the share of light that it scatters.
//!
//! ```text
//! σ_t(x) = σ_t D(x)          σ_s(x) = σ_s D(x), or albedo(x) σ_t(x), or a grid of its own
//! ```
//!
//! with `D = 0` outside of its box. In media that vary, free flights are sampled by tentative
//! collisions. These need an upper bound on the extinction along the ray, a *majorant* (Woodcock et
//! al. 1965). With one bound for the whole box, a ray through empty space would have as many
//! tentative collisions as one through the densest part. A [`Density`] therefore stores bounds for
//! each block of cells, and a ray is followed from block to block ([`Density::walk`]).
//!
//! # Guarantee
//! [`Density::at`] is within the bounds of the [`Span`] that contains its argument, rounding
//! included. The spans of a walk follow each other without gaps, up to the end of the box or the
//! given distance.
//!
//! # Held to this by
//! The tests below; the suite's `grid_media`.

use super::volume_grid::{VolumeEdges, VolumeGrid};
use crate::color::Rgb;
use crate::math::{DVec3, Ray};

/// Smallest number of cells along an edge of a block.
const MIN_SIDE: u32 = 4;
/// Largest number of blocks along an axis.
const MAX_BLOCKS: u32 = 64;
/// Share by which bounds are wider than the values in the block. The rounding of an interpolation
/// of eight values is at most 7 ε, that of a product with a coefficient at most one more.
const ROUNDING: f32 = 12.0 * f32::EPSILON;

/// Variation of a medium from place to place.
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    density: Option<Density>,
    scattered: Scattered,
}

/// Share of the extinction that is scattering, by place.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Scattered {
    /// The share `σ_s / σ_t` of the medium's coefficients.
    #[default]
    Evenly,
    /// The share of the extinction by this grid, from 0 to 1. Outside of its box, the share is
    /// defined by its [`VolumeEdges`].
    Albedo(VolumeGrid),
    /// The scattering coefficient by this grid (m⁻¹), which must nowhere exceed the extinction.
    Coefficient(VolumeGrid),
}

impl Variation {
    /// Creates a variation from `density`, a factor on the coefficients, and the scattered share.
    /// The factor is zero outside of its box; without a grid it is 1 everywhere.
    pub fn new(density: Option<VolumeGrid>, scattered: Scattered) -> Self {
        Self { density: density.map(Density::new), scattered }
    }

    /// Factor on the coefficients; `None` if it is 1 everywhere.
    #[inline]
    pub fn density(&self) -> Option<&Density> {
        self.density.as_ref()
    }

    /// Makes positions relative to `origin` (m).
    pub(super) fn move_by(&mut self, origin: DVec3) {
        if let Some(density) = &mut self.density {
            density.grid.move_by(origin);
        }
        if let Scattered::Albedo(grid) | Scattered::Coefficient(grid) = &mut self.scattered {
            grid.move_by(origin);
        }
    }

    /// Share of the extinction that is scattering.
    #[inline]
    pub fn scattered(&self) -> &Scattered {
        &self.scattered
    }
}

/// Factor on the extinction by place, with bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    grid: VolumeGrid,
    blocks: Blocks,
    most: Rgb,
}

/// Bounds on the values in blocks of cells.
#[derive(Clone, Debug, PartialEq)]
struct Blocks {
    /// Number of cells along an edge of a block.
    side: u32,
    counts: [u32; 3],
    /// Least and largest values; the index along the first axis runs fastest.
    bounds: Vec<[Rgb; 2]>,
}

/// A part of a ray with bounds on the density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Distance at which it begins (in lengths of the ray's direction).
    pub from: f64,
    /// Distance at which it ends, at least `from`.
    pub to: f64,
    /// Lower bound, by channel.
    pub least: Rgb,
    /// Upper bound, by channel.
    pub most: Rgb,
}

impl Density {
    fn new(grid: VolumeGrid) -> Self {
        let blocks = Blocks::of(&grid);
        let most = blocks.bounds.iter().fold(Rgb::BLACK, |most, [_, m]| most.zip(*m, f32::max));
        Self { grid, blocks, most }
    }

    /// The values on a grid.
    pub fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    /// Upper bound on all values, by channel.
    pub fn most(&self) -> Rgb {
        self.most
    }

    /// Transforms a ray to the coordinates of cells. Distances along the ray are unchanged, in
    /// lengths of its world direction.
    #[inline]
    pub fn ray(&self, ray: &Ray) -> CellRay {
        let to_cells = self.grid.to_cells();
        CellRay {
            origin: to_cells.transform_point3(ray.origin.as_dvec3()),
            direction: to_cells.transform_vector3(ray.direction.as_dvec3()),
        }
    }

    /// Factor on the coefficients at a point in the box, in cells.
    #[inline]
    pub fn at(&self, place: DVec3) -> Rgb {
        self.grid.at(place)
    }

    /// Returns the spans of a ray in the box, up to `distance`, which may be infinite.
    #[inline]
    pub fn walk(&self, ray: &CellRay, distance: f64) -> Walk<'_> {
        Walk::new(&self.blocks, self.grid.bounds(), ray, distance)
    }
}

/// A ray in the coordinates of cells.
#[derive(Clone, Copy, Debug)]
pub struct CellRay {
    origin: DVec3,
    direction: DVec3,
}

impl CellRay {
    /// Returns the point at a distance.
    #[inline]
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }
}

impl Blocks {
    fn of(grid: &VolumeGrid) -> Self {
        let cells = grid.counts();
        let side = cells.map(|n| n.div_ceil(MAX_BLOCKS)).into_iter().fold(MIN_SIDE, u32::max);
        let counts = cells.map(|n| n.div_ceil(side));
        let mut bounds = Vec::with_capacity(counts.map(|n| n as usize).into_iter().product());
        for z in 0..counts[2] {
            for y in 0..counts[1] {
                bounds.extend((0..counts[0]).map(|x| bounds_of(grid, [x, y, z], side)));
            }
        }
        Self { side, counts, bounds }
    }

    fn get(&self, [x, y, z]: [u32; 3]) -> [Rgb; 2] {
        let [nx, ny, _] = self.counts.map(|n| n as usize);
        self.bounds[(z as usize * ny + y as usize) * nx + x as usize]
    }
}

/// Bounds on the interpolated values in a block: the extremes of its own cells and of the cells
/// around it.
fn bounds_of(grid: &VolumeGrid, block: [u32; 3], side: u32) -> [Rgb; 2] {
    let [nx, ny, nz] = grid.counts();
    let reach =
        |block: u32, n: u32| (block * side).saturating_sub(1)..(block * side).saturating_add(side + 1).min(n);
    let [x, y, z] = [reach(block[0], nx), reach(block[1], ny), reach(block[2], nz)];
    let is_outermost =
        [(&x, nx), (&y, ny), (&z, nz)].into_iter().zip(block).any(|((reach, n), k)| k == 0 || reach.end == n);
    let fades = grid.edges() == VolumeEdges::Zero && is_outermost;
    let (mut least, mut most) = (Rgb::gray(if fades { 0.0 } else { f32::INFINITY }), Rgb::BLACK);
    for k in z {
        for j in y.clone() {
            let row = (k as usize * ny as usize + j as usize) * nx as usize;
            for i in x.clone() {
                let value = grid.values().get(row + i as usize);
                (least, most) = (least.zip(value, f32::min), most.zip(value, f32::max));
            }
        }
    }
    [least * (1.0 - ROUNDING), most * (1.0 + ROUNDING)]
}

/// Iterator over the [`Span`]s of a ray, one per block.
#[derive(Clone, Debug)]
pub struct Walk<'a> {
    blocks: &'a Blocks,
    /// Origin of the ray, in blocks.
    origin: DVec3,
    direction: DVec3,
    /// Block of the next span.
    block: [u32; 3],
    from: f64,
    end: f64,
}

impl<'a> Walk<'a> {
    fn new(blocks: &'a Blocks, [lo, hi]: [DVec3; 2], ray: &CellRay, distance: f64) -> Self {
        let (mut from, mut end) = (0.0_f64, distance);
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.direction[axis]);
            if d == 0.0 {
                if o < lo[axis] || o > hi[axis] {
                    end = 0.0;
                }
                continue;
            }
            let [a, b] = [(lo[axis] - o) / d, (hi[axis] - o) / d];
            from = from.max(a.min(b));
            end = end.min(a.max(b));
        }
        let scale = f64::from(blocks.side).recip();
        let (origin, direction) = (ray.origin * scale, ray.direction * scale);
        let start = origin + direction * from;
        // By rounding, the start may be just outside of the blocks.
        let block = [0, 1, 2].map(|axis| (start[axis].max(0.0) as u32).min(blocks.counts[axis] - 1));
        Self { blocks, origin, direction, block, from, end }
    }
}

impl Iterator for Walk<'_> {
    type Item = Span;

    fn next(&mut self) -> Option<Span> {
        if self.from >= self.end {
            return None;
        }
        // Finds the face through which the ray leaves the block.
        let (mut exit, mut by) = (f64::INFINITY, 0);
        for axis in 0..3 {
            let d = self.direction[axis];
            let face = f64::from(self.block[axis] + u32::from(d > 0.0));
            let at = if d == 0.0 { f64::INFINITY } else { (face - self.origin[axis]) / d };
            if at < exit {
                (exit, by) = (at, axis);
            }
        }
        let to = exit.clamp(self.from, self.end);
        let [least, most] = self.blocks.get(self.block);
        let span = Span { from: self.from, to, least, most };
        let next = if self.direction[by] > 0.0 {
            Some(self.block[by] + 1).filter(|&k| k < self.blocks.counts[by])
        } else {
            self.block[by].checked_sub(1)
        };
        match next {
            Some(next) if exit < self.end => (self.block[by], self.from) = (next, to),
            _ => self.from = self.end,
        }
        Some(span)
    }
}

#[cfg(test)]
mod tests {
    use super::super::volume_grid::tests::{data, grid};
    use super::super::volume_grid::{VolumeData, VolumeSamples, VolumeValues};
    use super::*;
    use crate::math::{Affine3A, Vec3};
    use crate::rng::{Purpose, Stream};

    fn random(stream: &mut Stream, counts: [u32; 3], edges: VolumeEdges, samples: VolumeSamples) -> Density {
        let len = counts.iter().product::<u32>();
        // Half of the values are zero, so that bounds differ from block to block.
        let mut value = || (stream.uniform() - 0.5).max(0.0) * 4.0;
        let values = (0..len).map(|_| Rgb::new(value(), value(), 1.0)).collect();
        let to_world = Affine3A::from_scale_rotation_translation(
            Vec3::new(1.0, 2.0, -0.5),
            crate::math::elementary::rotation(Vec3::new(0.0, 0.6, 0.8), 1.1),
            Vec3::new(0.3, -2.0, 5.0),
        );
        let values = VolumeValues::Colors(values);
        Density::new(grid(VolumeData { counts, values, to_world: to_world.as_daffine3(), samples, edges }))
    }

    /// Rays between random points. The spans of a ray follow each other from the point at which it
    /// enters the box to the one at which it leaves. The values along a span are within its bounds,
    /// and often near the upper one.
    #[test]
    fn spans_cover_the_box_and_bound_what_is_in_them() {
        let mut stream = Stream::new(3, Purpose::Test, 0);
        let (mut close, mut spans) = (0, 0);
        for counts in [[1, 1, 1], [9, 4, 13], [3, 40, 2], [70, 5, 300]] {
            for edges in [VolumeEdges::Held, VolumeEdges::Zero] {
                for samples in [VolumeSamples::Centers, VolumeSamples::Corners] {
                    let density = random(&mut stream, counts, edges, samples);
                    let to_world = density.grid().to_cells().inverse();
                    let [lo, hi] = density.grid().bounds();
                    let is_in = |place: DVec3| {
                        let slack = 1e-4;
                        (0..3).all(|k| place[k] >= lo[k] - slack && place[k] <= hi[k] + slack)
                    };
                    for number in 0..60 {
                        let mut anywhere = |spread: f64| {
                            let [x, y, z] = stream.uniform_3().map(f64::from);
                            let within = lo + (hi - lo) * ((DVec3::new(x, y, z) - 0.5) * spread + 0.5);
                            to_world.transform_point3(within).as_vec3()
                        };
                        let (from, to) = (anywhere(2.0), anywhere(1.0));
                        let mut direction = (to - from).normalize();
                        if number % 10 == 0 {
                            direction = to_world.transform_vector3(DVec3::Y).as_vec3().normalize();
                        }
                        let end = if number % 3 == 0 { f64::INFINITY } else { f64::from(from.distance(to)) };
                        let ray = density.ray(&Ray::new(from, direction));
                        let mut reached = None;
                        for Span { from, to, least, most } in density.walk(&ray, end) {
                            assert!(from >= 0.0 && to >= from && to <= end);
                            assert!(reached.is_none_or(|reached| reached == from), "a gap");
                            // Just before the first span, the ray is outside of the box.
                            assert!(reached.is_some() || from == 0.0 || !is_in(ray.at(from - 0.01)));
                            reached = Some(to);
                            spans += 1;
                            let mut highest = Rgb::BLACK;
                            for k in 0..=16 {
                                let place = ray.at(from + (to - from) * f64::from(k) / 16.0);
                                let found = density.at(place);
                                assert!(is_in(place));
                                for c in 0..3 {
                                    assert!(
                                        found[c] >= least[c] && found[c] <= most[c],
                                        "{found:?} in {least:?} to {most:?}"
                                    );
                                }
                                highest = highest.zip(found, f32::max);
                            }
                            close += u32::from(highest.r >= 0.4 * most.r);
                        }
                        let end_of_box = reached.map_or(0.0, |reached| reached + 0.01);
                        assert!(end_of_box >= end || !is_in(ray.at(end_of_box)), "ends too early");
                    }
                }
            }
        }
        // A block has at least 64 cells, of which a ray meets few: for a quarter of the spans, at
        // least, the largest value on the ray must be near the bound.
        assert!(close * 4 > spans && spans > 5000, "{close} of {spans} are close");
    }

    #[test]
    fn empty_blocks_are_bounded_by_zero_and_even_ones_by_their_value() {
        let half = data([16, 4, 4], |[x, ..]| if x < 6 { 0.0 } else { 2.0 });
        let density = Density::new(grid(half));
        let ray = density.ray(&Ray::new(Vec3::new(-1.0, 0.5, 0.5), Vec3::X));
        let spans: Vec<Span> = density.walk(&ray, f64::INFINITY).collect();
        let of = |span: &Span| (span.from, span.to, span.least.r.round(), span.most.r.round());
        assert_eq!(
            spans.iter().map(of).collect::<Vec<_>>(),
            [(1.0, 1.25, 0.0, 0.0), (1.25, 1.5, 0.0, 2.0), (1.5, 1.75, 2.0, 2.0), (1.75, 2.0, 2.0, 2.0)]
        );
        assert_eq!(density.most().r.round(), 2.0);
        // A ray that passes beside the box, one that points away from it, and one that ends before
        // it have no spans.
        for (from, to, end) in [
            (Vec3::Y * 2.0, Vec3::X, f64::INFINITY),
            (Vec3::X * 2.0, Vec3::X, 9.0),
            (Vec3::NEG_X, Vec3::X, 0.5),
        ] {
            assert_eq!(density.walk(&density.ray(&Ray::new(from, to)), end).next(), None);
        }
    }
}
