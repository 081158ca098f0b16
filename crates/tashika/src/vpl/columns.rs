//! Lights component by component, as vectors read them.

use std::ops::Range;

use glam::Vec3;

use super::light::{Vpl, VplKind};
use crate::color::{LUMINANCE_WEIGHTS, Rgb};
use crate::math::simd::MOST_LANES;
use crate::scene::Falloff;

/// Numbers that all lights have: position, direction, intensity.
const COLUMNS: usize = 9;

/// Lights that stand kind by kind, each of their numbers in a column of its own: 36 bytes a light, and neighbours are read at once.
#[derive(Clone, Debug, PartialEq)]
pub struct LightColumns {
    /// One column after the other, each with [`MOST_LANES`] zeros at its end.
    numbers: Vec<f32>,
    len: usize,
    /// Where each kind ends, by [number](VplKind::number).
    ends: [usize; VplKind::COUNT],
    /// Of the spots.
    falloffs: Vec<Falloff>,
}

impl LightColumns {
    /// Of lights that stand in the order of the [numbers](VplKind::number) of their kinds.
    ///
    /// # Panics
    /// If they do not.
    pub fn new(lights: &[Vpl]) -> Self {
        assert!(lights.is_sorted_by_key(|light| light.kind.number()), "lights stand kind by kind");
        let mut numbers = vec![0.0; COLUMNS * (lights.len() + MOST_LANES)];
        let mut columns = numbers.chunks_exact_mut(lights.len() + MOST_LANES);
        let vectors: [fn(&Vpl) -> [f32; 3]; 3] =
            [|l| l.position.to_array(), |l| l.direction.to_array(), |l| l.intensity.to_array()];
        for vector in vectors {
            for axis in 0..3 {
                let column = columns.next().expect("three vectors of three numbers");
                for (number, light) in column.iter_mut().zip(lights) {
                    *number = vector(light)[axis];
                }
            }
        }
        let falloff = |light: &Vpl| match light.kind {
            VplKind::Spot(falloff) => Some(falloff),
            VplKind::Omni | VplKind::Oriented | VplKind::Directional => None,
        };
        Self {
            numbers,
            len: lights.len(),
            ends: std::array::from_fn(|kind| lights.partition_point(|light| light.kind.number() <= kind)),
            falloffs: lights.iter().filter_map(falloff).collect(),
        }
    }

    /// How many lights there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// One light.
    #[inline]
    pub fn get(&self, light: usize) -> Vpl {
        let vector = |v: usize| Vec3::from(self.numbers(v, light));
        Vpl {
            position: vector(0),
            direction: vector(1),
            intensity: self.intensity(light),
            kind: self.kind(light),
        }
    }

    /// Intensity of one light (W·sr⁻¹, or W·m⁻² from infinity).
    #[inline]
    pub fn intensity(&self, light: usize) -> Rgb {
        Rgb::from(self.numbers(2, light))
    }

    /// All lights, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Vpl> {
        (0..self.len).map(|light| self.get(light))
    }

    /// Luminances of the intensities of some lights, in order.
    pub fn luminances(&self, lights: Range<usize>) -> impl ExactSizeIterator<Item = f32> {
        let [r, g, b] = self.vector(2).map(|column| &column[lights.clone()]);
        let [of_r, of_g, of_b] = LUMINANCE_WEIGHTS;
        r.iter().zip(g).zip(b).map(move |((r, g), b)| of_r * r + of_g * g + of_b * b)
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        self.numbers.capacity() * size_of::<f32>() + self.falloffs.capacity() * size_of::<Falloff>()
    }

    /// Parts of a range whose lights are of one kind, each with the kind of its first.
    pub(crate) fn runs(&self, lights: Range<usize>) -> impl Iterator<Item = (VplKind, Range<usize>)> {
        let mut first = lights.start;
        self.ends.into_iter().filter_map(move |end| {
            let run = first..end.clamp(first, lights.end);
            first = run.end;
            (!run.is_empty()).then(|| (self.kind(run.start), run))
        })
    }

    /// The columns of the positions (0), directions (1) or intensities (2), with [`MOST_LANES`] zeros at their ends.
    pub(crate) fn vector(&self, vector: usize) -> [&[f32]; 3] {
        let length = self.len + MOST_LANES;
        let column = |axis: usize| &self.numbers[(3 * vector + axis) * length..][..length];
        [column(0), column(1), column(2)]
    }

    #[inline]
    fn numbers(&self, vector: usize, light: usize) -> [f32; 3] {
        let length = self.len + MOST_LANES;
        let first = 3 * vector * length + light;
        [self.numbers[first], self.numbers[first + length], self.numbers[first + 2 * length]]
    }

    #[inline]
    fn kind(&self, light: usize) -> VplKind {
        let [omni, oriented, spots, _] = self.ends;
        match light {
            _ if light < omni => VplKind::Omni,
            _ if light < oriented => VplKind::Oriented,
            _ if light < spots => VplKind::Spot(self.falloffs[light - oriented]),
            _ => VplKind::Directional,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::scene::FalloffShape;

    /// `counts` lights of each kind.
    fn lights(counts: [usize; VplKind::COUNT]) -> Vec<Vpl> {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let mut light = |kind| {
            let [position, direction] = [s.uniform_3(), s.uniform_3()].map(Vec3::from);
            Vpl { position, direction, intensity: Rgb::from(s.uniform_3()), kind }
        };
        let spot =
            |k: usize| Falloff { cos_inner: 0.9, cos_outer: 0.01 * k as f32, shape: FalloffShape::Squared };
        let mut all = Vec::new();
        all.extend((0..counts[0]).map(|_| light(VplKind::Omni)));
        all.extend((0..counts[1]).map(|_| light(VplKind::Oriented)));
        all.extend((0..counts[2]).map(|k| light(VplKind::Spot(spot(k)))));
        all.extend((0..counts[3]).map(|_| light(VplKind::Directional)));
        all
    }

    #[test]
    fn lights_come_back_as_they_were() {
        for counts in [[3, 20, 5, 2], [0, 9, 0, 0], [0, 0, 4, 1], [2, 0, 0, 3], [0; 4]] {
            let lights = lights(counts);
            let columns = LightColumns::new(&lights);
            assert!(columns.iter().eq(lights.iter().copied()), "{counts:?}");
            let luminances: Vec<f32> = columns.luminances(0..columns.len()).collect();
            assert!(lights.iter().map(|l| l.intensity.luminance()).eq(luminances), "{counts:?}");
        }
    }

    #[test]
    fn runs_are_of_one_kind_and_leave_nothing_out() {
        let lights = lights([3, 6, 5, 2]);
        let columns = LightColumns::new(&lights);
        for range in [0..16, 0..3, 2..4, 5..15, 8..16, 14..16, 7..7] {
            let mut next = range.start;
            for (kind, run) in columns.runs(range.clone()) {
                assert_eq!(run.start, next);
                assert!(lights[run.clone()].iter().all(|l| l.kind.number() == kind.number()), "{run:?}");
                next = run.end;
            }
            assert_eq!(next, range.end);
            assert!(columns.runs(range.clone()).count() <= VplKind::COUNT);
        }
    }

    #[test]
    #[should_panic(expected = "kind by kind")]
    fn other_orders_are_refused() {
        let mut lights = lights([1, 1, 0, 0]);
        lights.reverse();
        LightColumns::new(&lights);
    }
}
