//! Splits a range of boxes in two by the surface area heuristic. The expected work of a ray that
//! meets the box of the range is
//!
//! ```text
//! (A_l n_l + A_r n_r) / A        A: areas of boxes   n: items
//! ```
//!
//! The centres of boxes are counted in bins along each axis, and the planes between bins are
//! compared: Ingo Wald. "On fast Construction of SAH-based Bounding Volume Hierarchies." Symposium
//! on Interactive Ray Tracing, 2007, doi:10.1109/RT.2007.4342588.
//!
//! # Guarantee
//! The two sides depend only on the set of items: boxes and counts of bins do not depend on the
//! order in which items are counted, and hence not on threads. The order of items after a split
//! depends only on their order before. Held to this by the tests below and `accel::tests`.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::math::Aabb;

/// Maximum number of bins along an axis.
const BINS: usize = 16;
/// Number of bins along an axis in ranges of few items.
const FEW_BINS: usize = 8;
/// Number of items from which [`BINS`] bins are used.
const MANY_ITEMS: usize = 128;
/// Number of items that are counted as one parallel task.
const CHUNK: usize = 1 << 15;

/// A box and two numbers, which are stored in the fourth components of its corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Lower corner (m).
    lo: Vec4,
    /// Upper corner (m).
    hi: Vec4,
}

/// Offset that is added to the numbers of an item: the bits of the smallest normal float. As bits
/// of a float, small integers would be subnormal. Arithmetic with subnormals is many times slower,
/// even if its result is unused.
const NORMAL: u32 = 0x0080_0000;

impl Item {
    /// Creates an item; `numbers` are below 2³⁰.
    pub fn new(b: &Aabb, numbers: [u32; 2]) -> Self {
        debug_assert!(numbers.iter().all(|number| *number < 1 << 30), "{numbers:?}");
        let [lo, hi] = numbers.map(|number| f32::from_bits(number + NORMAL));
        Self { lo: b.lo.extend(lo), hi: b.hi.extend(hi) }
    }

    /// The two numbers passed to [`Item::new`].
    pub fn numbers(&self) -> [u32; 2] {
        [self.lo.w, self.hi.w].map(|number| number.to_bits() - NORMAL)
    }

    /// Returns true if the box is empty.
    pub fn is_empty(&self) -> bool {
        self.lo.x > self.hi.x
    }

    /// Twice the centre of the box.
    #[inline(always)]
    fn center(&self) -> Vec4 {
        self.lo + self.hi
    }
}

/// A box; the fourth components are unused.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    lo: Vec4,
    hi: Vec4,
}

impl Bounds {
    const EMPTY: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    /// Box around all items.
    pub fn of(items: &[Item]) -> Self {
        gathered(items, |items| items.iter().fold(Self::EMPTY, |all, i| all.with(i.lo, i.hi)))
    }

    /// Box around the doubled centres of all items.
    fn of_centers(items: &[Item]) -> Self {
        gathered(items, |items| items.iter().fold(Self::EMPTY, |all, i| all.with(i.center(), i.center())))
    }

    #[inline(always)]
    fn with(self, lo: Vec4, hi: Vec4) -> Self {
        Self { lo: self.lo.min(lo), hi: self.hi.max(hi) }
    }

    #[inline(always)]
    fn union(self, other: Self) -> Self {
        self.with(other.lo, other.hi)
    }

    pub fn aabb(&self) -> Aabb {
        Aabb { lo: self.lo.truncate(), hi: self.hi.truncate() }
    }

    /// Half the area of the box (m²); zero if it is empty.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let e = (self.hi - self.lo).max(Vec4::ZERO);
        e.x * (e.y + e.z) + e.y * e.z
    }
}

/// Union of the bounds of pieces, which are processed in parallel if there are several.
fn gathered(items: &[Item], of_piece: impl Fn(&[Item]) -> Bounds + Sync + Send) -> Bounds {
    if items.len() <= CHUNK {
        return of_piece(items);
    }
    items.par_chunks(CHUNK).map(of_piece).reduce(|| Bounds::EMPTY, Bounds::union)
}

/// Moves the items of the first side to the front. Returns their number, which is between 1 and
/// `items.len() - 1`, and the boxes of both sides.
///
/// There must be at least two items.
pub(super) fn split(items: &mut [Item]) -> (usize, [Bounds; 2]) {
    let bins = Bins::of(items);
    let Some((plane, sides)) = bins.and_then(|bins| bins.best_plane()) else { return halve(items) };
    let limit = plane.limit();
    (partition(items, |item| plane.mapping.places(item).cmplt(limit).any()), sides)
}

/// Splits items in two halves along the axis in which their centres spread most.
pub(super) fn halve(items: &mut [Item]) -> (usize, [Bounds; 2]) {
    let size = Bounds::of_centers(items).aabb().size();
    let axis = size.max_position();
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        a.center()[axis].total_cmp(&b.center()[axis]).then(a.numbers().cmp(&b.numbers()))
    });
    let (first, second) = items.split_at(middle);
    (middle, [Bounds::of(first), Bounds::of(second)])
}

/// Map from twice a centre to the index of its bin on each axis.
#[derive(Clone, Copy)]
struct Mapping {
    origin: Vec4,
    /// Bins per unit of length; zero along axes on which all centres agree.
    scale: Vec4,
    /// Number of bins along each axis.
    bins: usize,
}

/// `1.5 · 2²³`: floats of this size are integers. If a small number is added, its bits are the low
/// bits of the sum.
const TO_INTEGER: f32 = 12_582_912.0;

impl Mapping {
    /// Bin numbers along the axes, as integers above [`TO_INTEGER`].
    #[inline(always)]
    fn places(&self, item: &Item) -> Vec4 {
        // Subtracting half a bin and rounding to the nearest rounds down.
        ((item.center() - self.origin) * self.scale - Vec4::splat(0.5)) + Vec4::splat(TO_INTEGER)
    }

    #[inline(always)]
    fn bins_of(&self, item: &Item) -> [usize; 3] {
        let x = self.places(item);
        [x.x, x.y, x.z].map(|x| x.to_bits() as usize & (BINS - 1))
    }
}

/// A plane between two bins of an axis.
struct Plane {
    mapping: Mapping,
    axis: usize,
    /// First bin behind the plane.
    bin: usize,
}

impl Plane {
    /// Exclusive upper limit of the [places](Mapping::places) of items on the first side.
    fn limit(&self) -> Vec4 {
        let mut limit = [f32::NEG_INFINITY; 4];
        limit[self.axis] = TO_INTEGER + self.bin as f32;
        Vec4::from_array(limit)
    }
}

/// Boxes and counts of the items in each bin, for each axis.
struct Bins {
    mapping: Mapping,
    bounds: [[Bounds; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    /// Counts items in bins; `None` if all centres coincide.
    fn of(items: &[Item]) -> Option<Self> {
        let centers = Bounds::of_centers(items);
        let extent = centers.aabb().size();
        let bins = if items.len() < MANY_ITEMS { FEW_BINS } else { BINS };
        // Slightly less than `bins`, so that the last centre is in the last bin.
        let scale = Vec3::splat(bins as f32 * (1.0 - 1e-3)) / extent;
        let scale = Vec3::select(scale.is_finite_mask(), scale, Vec3::ZERO);
        if scale == Vec3::ZERO {
            return None;
        }
        let mapping = Mapping { origin: centers.lo, scale: scale.extend(0.0), bins };
        if items.len() <= CHUNK {
            return Some(Self::counted(items, mapping));
        }
        let pieces = items.par_chunks(CHUNK).map(|piece| Box::new(Self::counted(piece, mapping)));
        pieces.reduce_with(Self::united).map(|bins| *bins)
    }

    fn counted(items: &[Item], mapping: Mapping) -> Self {
        let mut all = Self { mapping, bounds: [[Bounds::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };
        for item in items {
            for (axis, bin) in mapping.bins_of(item).into_iter().enumerate() {
                let bounds = &mut all.bounds[axis][bin];
                *bounds = bounds.with(item.lo, item.hi);
                all.counts[axis][bin] += 1;
            }
        }
        all
    }

    fn united(mut a: Box<Self>, b: Box<Self>) -> Box<Self> {
        for axis in 0..3 {
            for bin in 0..BINS {
                a.bounds[axis][bin] = a.bounds[axis][bin].union(b.bounds[axis][bin]);
                a.counts[axis][bin] += b.counts[axis][bin];
            }
        }
        a
    }

    /// The plane of least cost, and the boxes of its two sides; `None` if no plane separates the
    /// items.
    fn best_plane(&self) -> Option<(Plane, [Bounds; 2])> {
        let cost = |bounds: &Bounds, count: u32| bounds.half_area() * count as f32;
        let mut best = (f32::INFINITY, None);
        for axis in 0..3 {
            if self.mapping.scale[axis] == 0.0 {
                continue;
            }
            let (bounds, counts) = (&self.bounds[axis], &self.counts[axis]);
            let mut behind = [(Bounds::EMPTY, 0.0); BINS];
            let (mut side, mut count) = (Bounds::EMPTY, 0);
            for bin in (1..self.mapping.bins).rev() {
                side = side.union(bounds[bin]);
                count += counts[bin];
                behind[bin] = (side, cost(&side, count));
            }
            let all = count + counts[0];
            let (mut side, mut count) = (Bounds::EMPTY, 0);
            for bin in 1..self.mapping.bins {
                side = side.union(bounds[bin - 1]);
                count += counts[bin - 1];
                let sum = cost(&side, count) + behind[bin].1;
                if sum < best.0 && 0 < count && count < all {
                    let plane = Plane { mapping: self.mapping, axis, bin };
                    best = (sum, Some((plane, [side, behind[bin].0])));
                }
            }
        }
        best.1
    }
}

/// Moves the items of the first side to the front and returns their number. There are no branches,
/// since half of them would be mispredicted.
fn partition(items: &mut [Item], is_first: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        let first = is_first(&items[i]);
        // If item `i` is on the second side, the swap exchanges two items of that side.
        items.swap(count, i);
        count += usize::from(first);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// Random boxes of very different sizes, with centres on a coarse grid if `coarse`.
    fn items(count: u32, coarse: bool) -> Vec<Item> {
        let mut s = Stream::new(u64::from(count), Purpose::Test, 0);
        let mut item = |number: u32| {
            let at = Vec3::from(s.uniform_3()) * 20.0 - 10.0;
            let at = if coarse { at.round() } else { at };
            let half = Vec3::from(s.uniform_3()) * s.uniform().powi(4);
            Item::new(&Aabb { lo: at - half, hi: at + half }, [number, count - number])
        };
        (0..count).map(&mut item).collect()
    }

    fn numbers(items: &[Item]) -> Vec<[u32; 2]> {
        let mut numbers: Vec<_> = items.iter().map(Item::numbers).collect();
        numbers.sort_unstable();
        numbers
    }

    #[test]
    fn sides_hold_what_their_boxes_say_and_nothing_is_lost() {
        for count in [2, 3, 9, 127, 128, 1000, 3 * CHUNK as u32] {
            for coarse in [false, true] {
                let mut items = items(count, coarse);
                let before = numbers(&items);
                for work in [split, halve] {
                    let (middle, sides) = work(&mut items);
                    assert!(0 < middle && middle < items.len(), "{middle} of {count}");
                    assert_eq!(numbers(&items), before);
                    let (first, second) = items.split_at(middle);
                    for (side, bounds) in [first, second].into_iter().zip(sides) {
                        assert_eq!(bounds.aabb(), Bounds::of(side).aabb(), "{count}, {coarse}");
                    }
                }
            }
        }
    }

    #[test]
    fn sides_do_not_depend_on_the_order_of_items() {
        let mut one = items(3000, false);
        let mut other: Vec<Item> = one.iter().rev().copied().collect();
        let (middle, _) = split(&mut one);
        assert_eq!(split(&mut other).0, middle);
        assert_eq!(numbers(&one[..middle]), numbers(&other[..middle]));
    }

    /// Two clusters are far apart along an axis. The split separates them.
    #[test]
    fn the_plane_is_where_nothing_is() {
        for axis in 0..3 {
            let mut items = items(600, false);
            for item in &mut items[..200] {
                item.lo[axis] += 100.0;
                item.hi[axis] += 100.0;
            }
            let (middle, [first, _]) = split(&mut items);
            assert_eq!(middle, 400, "axis {axis}");
            assert!(first.hi[axis] < 20.0);
        }
    }

    #[test]
    fn boxes_about_one_centre_are_halved() {
        let mut items: Vec<Item> = (1..10)
            .map(|k| Item::new(&Aabb { lo: Vec3::splat(-(k as f32)), hi: Vec3::splat(k as f32) }, [k, 0]))
            .collect();
        assert_eq!(split(&mut items).0, 4);
    }
}
