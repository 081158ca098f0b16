//! A plane: one quantity for each pixel of a film.

use super::Window;
use crate::color::Rgb;

/// Storage type of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleKind {
    /// 32-bit floating point.
    F32,
    /// 32-bit unsigned integer: counts and codes.
    U32,
}

/// Description of a plane; those of renders are in [`planes`](super::planes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneSpec {
    /// Name in lower case, without a point; empty for the main plane.
    pub name: &'static str,
    /// Names of the channels, at least one: `["R", "G", "B"]`, `["Y"]`.
    pub channels: &'static [&'static str],
    /// Unit of all channels: `W·m⁻²·sr⁻¹`, or `1` for counts.
    pub unit: &'static str,
    /// Storage type of the samples.
    pub kind: SampleKind,
    /// Meaning of the numbers, in one sentence.
    pub doc: &'static str,
}

/// The name, by which planes are looked up.
impl AsRef<str> for PlaneSpec {
    fn as_ref(&self) -> &str {
        self.name
    }
}

/// Samples of a plane: pixel by pixel in rows, the channels of a pixel adjacent.
#[derive(Clone, Debug)]
pub enum Samples {
    /// Floating point.
    F32(Vec<f32>),
    /// Unsigned integers: counts and codes.
    U32(Vec<u32>),
}

impl PartialEq for Samples {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::F32(a), Self::F32(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
            }
            (Self::U32(a), Self::U32(b)) => a == b,
            (Self::F32(_) | Self::U32(_), _) => false,
        }
    }
}

/// Returns the full name of a channel: `half_width.Y`, or `R` if the plane has no name.
pub fn channel_name(plane: &str, channel: &str) -> String {
    if plane.is_empty() { channel.to_owned() } else { format!("{plane}.{channel}") }
}

/// One quantity for each pixel of a window.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    name: String,
    channels: Vec<String>,
    unit: String,
    doc: String,
    window: Window,
    samples: Samples,
}

impl Plane {
    /// A plane whose samples are zero.
    pub(super) fn zeros(spec: &PlaneSpec, window: Window) -> Self {
        let count = window.area() as usize * spec.channels.len();
        let samples = match spec.kind {
            SampleKind::F32 => Samples::F32(vec![0.0; count]),
            SampleKind::U32 => Samples::U32(vec![0; count]),
        };
        let channels = spec.channels.iter().map(|&c| c.to_owned()).collect();
        Self::from_samples([spec.name, spec.unit, spec.doc].map(str::to_owned), channels, window, samples)
    }

    /// A plane of zeros like this one, for another window.
    pub(super) fn blank(&self, window: Window) -> Self {
        let count = window.area() as usize * self.channels.len();
        let samples = match self.samples {
            Samples::F32(_) => Samples::F32(vec![0.0; count]),
            Samples::U32(_) => Samples::U32(vec![0; count]),
        };
        let words = [&self.name, &self.unit, &self.doc].map(Clone::clone);
        Self::from_samples(words, self.channels.clone(), window, samples)
    }

    /// Copies `count` pixels of a row of another plane. The leftmost of them is read at `at` and
    /// written at `to`.
    pub(super) fn copy(&mut self, to: [u32; 2], from: &Self, at: [u32; 2], count: u32) {
        let range = |plane: &Self, [x, y]: [u32; 2]| {
            let start = plane.range(x, y).start;
            start..plane.range(x + count - 1, y).end
        };
        let (to, at) = (range(self, to), range(from, at));
        match (&mut self.samples, &from.samples) {
            (Samples::F32(own), Samples::F32(other)) => own[to].copy_from_slice(&other[at]),
            (Samples::U32(own), Samples::U32(other)) => own[to].copy_from_slice(&other[at]),
            _ => panic!("plane {:?} holds samples of another kind", self.name),
        }
    }

    /// A plane of given samples, one for each channel of each pixel of the window. `words`: name,
    /// unit, doc.
    pub fn from_samples(words: [String; 3], channels: Vec<String>, window: Window, samples: Samples) -> Self {
        let [name, unit, doc] = words;
        let count = match &samples {
            Samples::F32(s) => s.len(),
            Samples::U32(s) => s.len(),
        };
        assert!(!channels.is_empty(), "plane {name:?} has no channels");
        assert_eq!(count as u64, window.area() * channels.len() as u64, "samples of plane {name:?}");
        Self { name, channels, unit, doc, window, samples }
    }

    pub(super) fn renamed(self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self }
    }

    /// Colours in the order of [`Window::pixels`]: channels `R`, `G`, `B`, or one channel as gray;
    /// `None` if the plane has neither, or its samples are not floating point.
    pub fn colors(&self) -> Option<impl Iterator<Item = Rgb> + '_> {
        let (samples, [r, g, b]) = (self.f32_samples()?, self.color_channels()?);
        Some(samples.chunks_exact(self.channels.len()).map(move |p| Rgb::new(p[r], p[g], p[b])))
    }

    /// Indices of the red, green and blue channels, all 0 if the plane has one channel. `None` if
    /// it has other channels, or its samples are not floating point.
    pub(super) fn color_channels(&self) -> Option<[usize; 3]> {
        self.f32_samples()?;
        let channel = |name: &str| self.channels.iter().position(|c| c == name);
        match (channel("R"), channel("G"), channel("B")) {
            (Some(r), Some(g), Some(b)) => Some([r, g, b]),
            _ => (self.channels.len() == 1).then_some([0; 3]),
        }
    }

    /// Name in lower case; empty for the main plane.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Names of the channels, in their order.
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// Unit of all channels: `W·m⁻²·sr⁻¹`, or `1` for counts.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Meaning of the numbers, in one sentence.
    pub fn doc(&self) -> &str {
        &self.doc
    }

    /// All samples, pixel by pixel in rows.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Storage type of the samples.
    pub fn kind(&self) -> SampleKind {
        match self.samples {
            Samples::F32(_) => SampleKind::F32,
            Samples::U32(_) => SampleKind::U32,
        }
    }

    /// All samples, if they are floating point.
    pub fn f32_samples(&self) -> Option<&[f32]> {
        match &self.samples {
            Samples::F32(samples) => Some(samples),
            Samples::U32(_) => None,
        }
    }

    /// All samples, if they are counts or codes.
    pub fn u32_samples(&self) -> Option<&[u32]> {
        match &self.samples {
            Samples::U32(samples) => Some(samples),
            Samples::F32(_) => None,
        }
    }

    /// The channels of one pixel.
    ///
    /// # Panics
    /// If the pixel is outside the window or the plane holds counts.
    pub fn f32_at(&self, x: u32, y: u32) -> &[f32] {
        let range = self.range(x, y);
        &self.f32_samples().expect("a plane of floating point samples")[range]
    }

    /// The channels of one pixel.
    ///
    /// # Panics
    /// If the pixel is outside the window or the plane holds floating point samples.
    pub fn u32_at(&self, x: u32, y: u32) -> &[u32] {
        let range = self.range(x, y);
        &self.u32_samples().expect("a plane of counts or codes")[range]
    }

    /// Sets the channels of one pixel.
    ///
    /// # Panics
    /// If the pixel is outside the window, the plane holds counts, or the number of channels
    /// differs.
    pub fn set_f32(&mut self, x: u32, y: u32, channels: &[f32]) {
        let range = self.range(x, y);
        match &mut self.samples {
            Samples::F32(samples) => samples[range].copy_from_slice(channels),
            Samples::U32(_) => panic!("plane {:?} holds counts or codes", self.name),
        }
    }

    /// Sets the channels of one pixel.
    ///
    /// # Panics
    /// If the pixel is outside the window, the plane holds floating point samples, or the number of
    /// channels differs.
    pub fn set_u32(&mut self, x: u32, y: u32, channels: &[u32]) {
        let range = self.range(x, y);
        match &mut self.samples {
            Samples::U32(samples) => samples[range].copy_from_slice(channels),
            Samples::F32(_) => panic!("plane {:?} holds floating point samples", self.name),
        }
    }

    fn range(&self, x: u32, y: u32) -> std::ops::Range<usize> {
        let start = self.window.index(x, y) * self.channels.len();
        start..start + self.channels.len()
    }
}
