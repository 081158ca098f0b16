//! Error metrics of colours: the luminance, or the worst channel.

use std::fmt;

use super::{LUMINANCE_WEIGHTS, Rgb, RgbSum};

/// Error metric, by which errors are controlled and judged.
///
/// | | error of `a` against `b` | relative to |
/// |---|---|---|
/// | luminance | `|Y(a) − Y(b)|` | `Y(b)` |
/// | channels | the largest `|a_c − b_c|` of the three channels | the largest `b_c` |
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Controlled {
    /// Error of the luminance, relative to the luminance.
    #[default]
    Luminance,
    /// Error of the worst of the three channels.
    Channels,
}

/// A weighted sum of a colour's channels, with weights that are not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    weights: [f64; 3],
    /// Largest value for colours of luminance 1.
    pub per_luminance: f64,
}

const RED: f64 = LUMINANCE_WEIGHTS[0] as f64;
const GREEN: f64 = LUMINANCE_WEIGHTS[1] as f64;
const BLUE: f64 = LUMINANCE_WEIGHTS[2] as f64;

impl Controlled {
    /// Both metrics, in the order in which they are listed to users.
    pub const ALL: [Self; 2] = [Self::Luminance, Self::Channels];

    /// Largest number of [parts](Controlled::parts) of a metric.
    pub const MOST_PARTS: usize = 3;

    /// The metric of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|controlled| controlled.to_string() == name)
    }

    /// Weighted sums of the channels; the metric's error is the largest of their errors.
    #[inline]
    pub fn parts(self) -> &'static [Part] {
        match self {
            Self::Luminance => &[Part { weights: [RED, GREEN, BLUE], per_luminance: 1.0 }],
            Self::Channels => &[
                Part { weights: [1.0, 0.0, 0.0], per_luminance: 1.0 / RED },
                Part { weights: [0.0, 1.0, 0.0], per_luminance: 1.0 / GREEN },
                Part { weights: [0.0, 0.0, 1.0], per_luminance: 1.0 / BLUE },
            ],
        }
    }

    /// Size of a sum of colours; errors of the sum are relative to it.
    #[inline]
    pub fn size(self, sum: &RgbSum) -> f64 {
        self.parts().iter().map(|part| part.of_sum(sum)).fold(0.0, f64::max)
    }

    /// Returns the size of `truth`, which errors are relative to, and the error of `other`.
    #[inline]
    pub fn size_and_distance(self, truth: Rgb, other: Rgb) -> (f64, f64) {
        let of = |part: &Part| {
            let (a, b) = (part.of(truth), part.of(other));
            (a.abs(), (a - b).abs())
        };
        self.parts()
            .iter()
            .map(of)
            .fold((0.0, 0.0), |(s, d), (size, distance)| (s.max(size), d.max(distance)))
    }
}

impl Part {
    /// Value for a colour.
    #[inline]
    pub fn of(&self, color: Rgb) -> f64 {
        let [r, g, b] = self.weights;
        r * f64::from(color.r) + g * f64::from(color.g) + b * f64::from(color.b)
    }

    /// Value for a sum of colours.
    #[inline]
    pub fn of_sum(&self, sum: &RgbSum) -> f64 {
        self.weights.iter().zip(sum.channels()).map(|(w, c)| w * c).sum()
    }
}

impl fmt::Display for Controlled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Luminance => "luminance",
            Self::Channels => "channels",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_part_of_a_color_exceeds_its_bound_by_luminance() {
        for color in [Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 3.0), Rgb::new(0.2, 0.7, 0.1)] {
            for part in Controlled::Channels.parts().iter().chain(Controlled::Luminance.parts()) {
                let bound = part.per_luminance * f64::from(color.luminance());
                assert!(part.of(color) <= bound * (1.0 + 1e-6), "{part:?} {color:?}");
            }
        }
    }

    #[test]
    fn the_worst_channel_counts_against_the_largest() {
        let (truth, other) = (Rgb::new(1.0, 4.0, 0.0), Rgb::new(1.0, 3.0, 2.0));
        assert_eq!(Controlled::Channels.size_and_distance(truth, other), (4.0, 2.0));
        let (size, distance) = Controlled::Luminance.size_and_distance(truth, other);
        assert!((size - (0.2126 + 4.0 * 0.7152)).abs() < 1e-6);
        assert!((distance - (0.7152 - 2.0 * 0.0722)).abs() < 1e-6);
    }
}
