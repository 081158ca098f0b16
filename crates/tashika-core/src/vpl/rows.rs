//! Lights as they are read: one where it was drawn, or several as vectors.

use std::ops::Range;

use glam::Vec3;

use super::light::{Vpl, VplKind};
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::math::simd::MOST_LANES;

/// Numbers that all lights have: position, direction, intensity.
const NUMBERS: usize = 9;

/// Several lights, number by number: positions, directions, intensities; zeros where there are
/// fewer.
pub(crate) type Columns = [[f32; MOST_LANES]; NUMBERS];

/// Lights that stand instant by instant, and of each kind by kind, each in a row of 36 bytes: one that is
/// drawn among millions takes a line or two of a cache.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightRows {
    rows: Vec<[f32; NUMBERS]>,
    /// By instant.
    kinds: Vec<Kinds>,
    /// Of the spots and images.
    cones: Vec<VplKind>,
    /// Of the lights in media.
    phases: Vec<HenyeyGreenstein>,
}

/// Where the kinds of the lights of an instant are.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Kinds {
    /// Where each kind ends, by [number](VplKind::number).
    ends: [usize; VplKind::COUNT],
    /// What has to be taken from the place of a spot or image to find its cone.
    before_cones: usize,
    /// The same of the lights in media.
    before_phases: usize,
}

impl LightRows {
    /// Of lights of one instant, in the order of the [numbers](VplKind::number) of their kinds.
    ///
    /// # Panics
    /// If they are in another.
    pub fn new(lights: impl ExactSizeIterator<Item = Vpl>) -> Self {
        let mut rows = Self::with_capacity(lights.len());
        rows.push_instant(lights);
        rows
    }

    /// Room for so many lights.
    pub fn with_capacity(lights: usize) -> Self {
        Self { rows: Vec::with_capacity(lights), ..Self::default() }
    }

    /// Adds the lights of the next instant, as [`Self::new`].
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
        // Wherever there is one, it stands behind as many lights as cones, or phases, before it.
        let kinds =
            Kinds { ends, before_cones: oriented - cones_before, before_phases: directional - phases_before };
        self.kinds.push(kinds);
    }

    /// How many lights there are.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// One light.
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

    /// All lights, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Vpl> {
        (0..self.len()).map(|light| self.get(light))
    }

    /// Luminances of the intensities of some lights, in order.
    pub fn luminances(&self, lights: Range<usize>) -> impl ExactSizeIterator<Item = f32> {
        self.rows[lights].iter().map(|row| Rgb::new(row[6], row[7], row[8]).luminance())
    }

    /// Memory (bytes).
    pub fn bytes(&self) -> usize {
        self.rows.capacity() * size_of::<[f32; NUMBERS]>()
            + self.cones.capacity() * size_of::<VplKind>()
            + self.phases.capacity() * size_of::<HenyeyGreenstein>()
    }

    /// Parts of a range of one instant whose lights are of one kind, each with the kind of its first.
    pub(crate) fn runs(&self, lights: Range<usize>) -> impl Iterator<Item = (VplKind, Range<usize>)> {
        let mut first = lights.start;
        self.kinds_about(first).ends.into_iter().filter_map(move |end| {
            let run = first..end.clamp(first, lights.end);
            first = run.end;
            (!run.is_empty()).then(|| (self.kind(run.start), run))
        })
    }

    /// Lights of a range, of which the first [`MOST_LANES`] are given.
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

    /// The kinds of the instant of a light.
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
