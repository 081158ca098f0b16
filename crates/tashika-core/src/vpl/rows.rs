//! Storage of lights, which can be read one by one or as vectors of several.

use std::ops::Range;

use glam::Vec3;

use super::light::{Vpl, VplKind};
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::math::simd::MOST_LANES;

/// Number of values that every light has: position, direction, intensity.
const NUMBERS: usize = 9;

/// Several lights, one array for each value: position, direction, intensity. Unused lanes are zero.
pub(crate) type Columns = [[f32; MOST_LANES]; NUMBERS];

/// Lights, sorted by instant and, within an instant, by kind. Each light has a row of 36 bytes, so
/// that reading a random light takes one or two cache lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightRows {
    rows: Vec<[f32; NUMBERS]>,
    /// Kinds of the lights of each instant.
    kinds: Vec<Kinds>,
    /// Cones of the spots and images, in order.
    cones: Vec<VplKind>,
    /// Phase functions of the lights in media, in order.
    phases: Vec<HenyeyGreenstein>,
}

/// Ranges of the kinds of lights within an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Kinds {
    /// Index after the last light of each kind, by [number](VplKind::number).
    ends: [usize; VplKind::COUNT],
    /// Index of a spot or image minus the index of its cone.
    before_cones: usize,
    /// Index of a light in a medium minus the index of its phase function.
    before_phases: usize,
}

impl LightRows {
    /// Stores the lights of one instant, sorted by the [numbers](VplKind::number) of their kinds.
    ///
    /// # Panics
    /// If the lights are not sorted.
    pub fn new(lights: impl ExactSizeIterator<Item = Vpl>) -> Self {
        let mut rows = Self::with_capacity(lights.len());
        rows.push_instant(lights);
        rows
    }

    /// Returns empty storage with room for `lights` lights.
    pub fn with_capacity(lights: usize) -> Self {
        Self { rows: Vec::with_capacity(lights), ..Self::default() }
    }

    /// Adds the lights of the next instant, sorted like those of [`Self::new`].
    pub fn push_instant(&mut self, lights: impl Iterator<Item = Vpl>) {
        let Self { rows, cones, phases, .. } = self;
        let mut ends = [rows.len(); VplKind::COUNT];
        let (cones_before, phases_before) = (cones.len(), phases.len());
        let mut last = 0;
        for light in lights {
            let kind = light.kind.number();
            assert!(kind >= last, "lights stand kind by kind");
            last = kind;
            let [[px, py, pz], [dx, dy, dz]] = [light.position, light.direction].map(|v| v.to_array());
            let [r, g, b] = light.intensity.to_array();
            rows.push([px, py, pz, dx, dy, dz, r, g, b]);
            ends[kind..].fill(rows.len());
            match light.kind {
                VplKind::Spot(_) | VplKind::Image(_) => cones.push(light.kind),
                VplKind::Volume(phase) => phases.push(phase),
                VplKind::Omni | VplKind::Oriented | VplKind::Directional => {}
            }
        }
        let [_, oriented, _, directional, _] = ends;
        // Neither difference is negative, since each earlier cone or phase function belongs to an
        // earlier light.
        let kinds =
            Kinds { ends, before_cones: oriented - cones_before, before_phases: directional - phases_before };
        self.kinds.push(kinds);
    }

    /// Returns the number of lights.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Returns true if there are no lights.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Returns one light.
    #[inline]
    pub fn get(&self, light: usize) -> Vpl {
        let [px, py, pz, dx, dy, dz, r, g, b] = self.rows[light];
        Vpl {
            position: Vec3::new(px, py, pz),
            direction: Vec3::new(dx, dy, dz),
            intensity: Rgb::new(r, g, b),
            kind: self.kind(light),
        }
    }

    /// Returns all lights, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Vpl> {
        (0..self.len()).map(|light| self.get(light))
    }

    /// Returns the luminances of the intensities of a range of lights, in order.
    pub fn luminances(&self, lights: Range<usize>) -> impl ExactSizeIterator<Item = f32> {
        self.rows[lights].iter().map(|row| Rgb::new(row[6], row[7], row[8]).luminance())
    }

    /// Returns the memory of the lights (bytes).
    pub fn bytes(&self) -> usize {
        self.rows.capacity() * size_of::<[f32; NUMBERS]>()
            + self.cones.capacity() * size_of::<VplKind>()
            + self.phases.capacity() * size_of::<HenyeyGreenstein>()
    }

    /// Divides a range of lights of one instant into parts with lights of one kind. Each part is
    /// returned with the kind of its first light.
    pub(crate) fn runs(&self, lights: Range<usize>) -> impl Iterator<Item = (VplKind, Range<usize>)> {
        let mut first = lights.start;
        self.kinds_about(first).ends.into_iter().filter_map(move |end| {
            let run = first..end.clamp(first, lights.end);
            first = run.end;
            (!run.is_empty()).then(|| (self.kind(run.start), run))
        })
    }

    /// Returns the first [`MOST_LANES`] lights of a range as columns.
    #[inline(always)]
    pub(crate) fn columns(&self, lights: Range<usize>) -> Columns {
        let mut columns = [[0.0; MOST_LANES]; NUMBERS];
        for (lane, row) in self.rows[lights].iter().take(MOST_LANES).enumerate() {
            for (column, number) in columns.iter_mut().zip(row) {
                column[lane] = *number;
            }
        }
        columns
    }

    /// Returns the ranges of kinds at the instant of a light.
    #[inline]
    fn kinds_about(&self, light: usize) -> &Kinds {
        if let [only] = &self.kinds[..] {
            return only;
        }
        let instant = self.kinds.partition_point(|kinds| kinds.ends[VplKind::COUNT - 1] <= light);
        &self.kinds[instant.min(self.kinds.len() - 1)]
    }

    #[inline]
    fn kind(&self, light: usize) -> VplKind {
        let &Kinds { ends, before_cones, before_phases } = self.kinds_about(light);
        let [omni, oriented, spots, directional, _] = ends;
        match light {
            _ if light < omni => VplKind::Omni,
            _ if light < oriented => VplKind::Oriented,
            _ if light < spots => self.cones[light - before_cones],
            _ if light < directional => VplKind::Directional,
            _ => VplKind::Volume(self.phases[light - before_phases]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::scene::{Beam, Falloff, FalloffShape};

    /// Returns lights in the required order; `counts` is the number of each kind.
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
        let image = |k: usize| Beam { map: k as u32, cos_outer: 0.01 * k as f32 };
        all.extend(
            (0..counts[2])
                .map(|k| light(if k % 2 == 0 { VplKind::Spot(spot(k)) } else { VplKind::Image(image(k)) })),
        );
        all.extend((0..counts[3]).map(|_| light(VplKind::Directional)));
        let phase = |k: usize| HenyeyGreenstein { asymmetry: 0.1 * k as f32 };
        all.extend((0..counts[4]).map(|k| light(VplKind::Volume(phase(k)))));
        all
    }

    #[test]
    fn lights_come_back_as_they_were() {
        for counts in
            [[3, 20, 5, 2, 4], [0, 9, 0, 0, 0], [0, 0, 4, 1, 0], [2, 0, 0, 3, 1], [0, 0, 0, 0, 3], [0; 5]]
        {
            let lights = lights(counts);
            let rows = LightRows::new(lights.iter().copied());
            assert!(rows.iter().eq(lights.iter().copied()), "{counts:?}");
            let luminances: Vec<f32> = rows.luminances(0..rows.len()).collect();
            assert!(lights.iter().map(|l| l.intensity.luminance()).eq(luminances), "{counts:?}");
        }
    }

    #[test]
    fn runs_are_of_one_kind_and_leave_nothing_out() {
        let lights = lights([3, 6, 5, 2, 4]);
        let rows = LightRows::new(lights.iter().copied());
        for range in [0..20, 0..3, 2..4, 5..15, 8..16, 14..18, 16..20, 7..7] {
            let mut next = range.start;
            for (kind, run) in rows.runs(range.clone()) {
                assert_eq!(run.start, next);
                assert!(lights[run.clone()].iter().all(|l| l.kind.number() == kind.number()), "{run:?}");
                next = run.end;
            }
            assert_eq!(next, range.end);
            assert!(rows.runs(range.clone()).count() <= VplKind::COUNT);
        }
    }

    #[test]
    #[should_panic(expected = "kind by kind")]
    fn other_orders_are_refused() {
        let mut lights = lights([1, 1, 0, 0, 0]);
        lights.reverse();
        LightRows::new(lights.into_iter());
    }
}
