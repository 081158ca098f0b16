//! From radiance to what a display shows: exposure, then one of several tone mappings.
//!
//! With radiance `c`, luminance `L(c)` and exposure `e` in stops, the exposed colour is `c′ = 2ᵉ c`,
//! whose channels below zero are zero, and a pixel becomes `8 bits = round(255 · sRGB(c″))`, where
//! `c″` in `[0, 1]` is, of `L′ = L(c′)`,
//!
//! | tone | display-linear colour `c″` | 0.18 becomes |
//! |---|---|---|
//! | [`Natural`](Tone::Natural) | `c′ f(L′)/L′`, moved towards the gray `f(L′)` until no channel exceeds 1 | 0.18 |
//! | [`Linear`](Tone::Linear) | `c′`, each channel cut off at 1 | 0.18 |
//! | [`Filmic`](Tone::Filmic) | a curve for each channel (Hable 2010) | 0.128 |
//! | [`Aces`](Tone::Aces) | a curve between two matrices (Hill 2016) | 0.106 |
//! | [`Agx`](Tone::Agx) | a curve of the logarithm between two matrices (Sobotka 2022) | 0.215 |
//!
//! ```text
//! f(L′) = L′                                        up to the knee K = 0.6
//! f(L′) = K + (1 − K)(1 − exp(−(L′ − K)/(1 − K)))   above
//! ```
//!
//! so that natural pictures are proportional to radiance up to the knee, which the shoulder meets with
//! the same slope, and hue and luminance are those of the radiance where the gamut allows. The others
//! are in [`Published`].
//!
//! # Guarantee
//! Black stays black, a brighter gray is never darker, infinite radiance is white; of any numbers,
//! NaN and negative ones among them, all channels are in `[0, 1]`.
//!
//! # Held to this by
//! The tests below and those of `io::png`; `scripts/page.py` holds the pages to the same colours.

mod published;
#[cfg(test)]
mod tests;

pub use published::{Curve, Published};

use std::fmt;
use std::str::FromStr;

use super::exposure::automatic_stops;
use crate::color::{Rgb, srgb_encode};
use crate::error::{Error, Result};
use crate::math::elementary::{exp, powf};

/// Luminance up to which natural pictures are proportional to radiance; chosen so that a white wall
/// at three times middle gray is still in proportion.
const KNEE: f32 = 0.6;
/// Brighter than this is white whatever the hue, and sums of channels stay finite.
const BRIGHTEST: f32 = 1e30;

/// Which tone mapping; formulas and sources are in the table of the module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tone {
    /// In proportion up to a knee; hue and luminance as far as the gamut allows.
    #[default]
    Natural,
    /// In proportion, cut off at 1.
    Linear,
    /// Hable's curve, of each channel.
    Filmic,
    /// Hill's fit of the reference rendering transform of ACES with its output for sRGB.
    Aces,
    /// AgX with its default contrast.
    Agx,
}

impl Tone {
    /// All, as users choose among them.
    pub const ALL: [Self; 5] = [Self::Natural, Self::Linear, Self::Filmic, Self::Aces, Self::Agx];

    /// As it is typed.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Natural => "natural",
            Self::Linear => "linear",
            Self::Filmic => "filmic",
            Self::Aces => "aces",
            Self::Agx => "agx",
        }
    }

    /// Its matrices and its curve, where it is made of such.
    pub const fn published(self) -> Option<&'static Published> {
        match self {
            Self::Natural | Self::Linear => None,
            Self::Filmic => Some(&published::FILMIC),
            Self::Aces => Some(&published::ACES),
            Self::Agx => Some(&published::AGX),
        }
    }

    /// Radiance times `scale` as display-linear colour in `[0, 1]`.
    pub fn display(self, radiance: Rgb, scale: f32) -> Rgb {
        let exposed = radiance.map(|v| if v > 0.0 { (v * scale).min(BRIGHTEST) } else { 0.0 });
        let shown = match self {
            Self::Natural => return natural(exposed),
            Self::Linear => exposed,
            Self::Filmic => published::FILMIC.of(exposed),
            Self::Aces => published::ACES.of(exposed),
            Self::Agx => published::AGX.of(exposed),
        };
        shown.map(|v| v.clamp(0.0, 1.0))
    }
}

impl fmt::Display for Tone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Tone {
    type Err = Error;

    /// # Errors
    /// [`Error::Option`] naming `tonemap` if no tone has that name.
    fn from_str(text: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|tone| tone.name() == text.trim())
            .ok_or_else(|| Error::option("tonemap", text, Self::ALL.map(Self::name).join(", ")))
    }
}

/// How bright the picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Exposure {
    /// By the log-average of the film, which goes to middle gray ([`automatic_stops`]).
    #[default]
    Auto,
    /// Radiance times two to this power. Higher values are brighter; at 0, radiance 1 is near
    /// white. Accepted: −64 to 64.
    Stops(f32),
}

/// How radiance becomes a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMap {
    /// How bright the picture is. Default: automatic.
    pub exposure: Exposure,
    /// What is done with what is too bright, and with contrast. Default: natural.
    pub tone: Tone,
}

impl ToneMap {
    /// # Errors
    /// [`Error::Option`] for an exposure out of range.
    pub fn validate(&self) -> Result<()> {
        match self.exposure {
            Exposure::Stops(stops) if stops.is_nan() || stops.abs() > 64.0 => {
                Err(Error::option("exposure", stops, "auto, or stops from -64 to 64"))
            }
            Exposure::Auto | Exposure::Stops(_) => Ok(()),
        }
    }

    /// Red, green, blue and opacity of each pixel as bytes, and the exposure used (stops). Pixels
    /// that were not rendered, by the second of each pair, are transparent and have no say in the
    /// exposure.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn picture(&self, pixels: &[(Rgb, bool)]) -> Result<(Vec<u8>, f32)> {
        self.validate()?;
        let stops = match self.exposure {
            Exposure::Auto => {
                let shown = pixels.iter().filter(|(_, rendered)| *rendered);
                automatic_stops(shown.map(|(color, _)| color.luminance()))
            }
            Exposure::Stops(stops) => stops,
        };
        let scale = powf(2.0, stops);
        let bytes = |&(color, rendered): &(Rgb, bool)| {
            let shown = self.tone.display(color, scale);
            let [r, g, b] = shown.to_array().map(|v| to_8_bits(srgb_encode(v)));
            [r, g, b, if rendered { 255 } else { 0 }]
        };
        Ok((pixels.iter().flat_map(bytes).collect(), stops))
    }
}

fn natural(c: Rgb) -> Rgb {
    let luminance = c.luminance();
    if luminance <= 0.0 {
        return Rgb::BLACK;
    }
    let shown = shoulder(luminance);
    let c = c * (shown / luminance);
    let largest = c.max_channel();
    if largest <= 1.0 {
        return c;
    }
    let towards_gray = (largest - 1.0) / (largest - shown);
    c.lerp(Rgb::gray(shown), towards_gray).map(|v| v.clamp(0.0, 1.0))
}

/// `f` of the module's formula.
fn shoulder(luminance: f32) -> f32 {
    if luminance <= KNEE {
        luminance
    } else {
        KNEE + (1.0 - KNEE) * (1.0 - exp(-(luminance - KNEE) / (1.0 - KNEE)))
    }
}

fn to_8_bits(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}
