//! Tone mapping: from radiance to display colours, by exposure and one of several curves.
//!
//! With radiance `c`, luminance `L(c)` and exposure `e` in stops, the exposed colour is
//! `c′ = 2ᵉ c`, with negative channels set to zero. A pixel becomes
//! `8 bits = round(255 · sRGB(c″))`, where `c″` in `[0, 1]` is, with `L′ = L(c′)`,
//!
//! | tone | display-linear colour `c″` | 0.18 becomes |
//! |---|---|---|
//! | [`Tone::Natural`] | `c′ f(L′)/L′`, mixed with gray `f(L′)` until no channel exceeds 1 | 0.18 |
//! | [`Tone::Linear`] | `c′`, each channel clamped to 1 | 0.18 |
//! | [`Tone::Filmic`] | a curve for each channel (Hable 2010) | 0.128 |
//! | [`Tone::Aces`] | a curve between two matrices (Hill 2016) | 0.106 |
//! | [`Tone::Agx`] | a curve of the logarithm between two matrices (Sobotka 2022) | 0.215 |
//!
//! ```text
//! f(L′) = L′                                        up to the knee K = 0.6
//! f(L′) = K + (1 − K)(1 − exp(−(L′ − K)/(1 − K)))   above
//! ```
//!
//! So natural pictures are proportional to radiance up to the knee, where the shoulder continues
//! with the same slope. Hue and luminance are those of the radiance where the gamut allows. The
//! last three tone mappings are defined by the matrices and the curve of a [`Published`].
//!
//! # Guarantee
//! Black stays black, a brighter gray is never darker, infinite radiance is white. For any input,
//! including NaN and negative numbers, all channels are in `[0, 1]`.
//!
//! # Held to this by
//! The tests below and those of `io::png`; `scripts/page.py` compares the colours of pages with
//! these.

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
/// at three times middle gray is still proportional.
const KNEE: f32 = 0.6;
/// Upper clamp of exposed channels: any brighter colour is white, and sums of channels stay finite.
const BRIGHTEST: f32 = 1e30;

/// Tone mapping; formulas and sources are in the table of the module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tone {
    /// Proportional up to a knee; hue and luminance as far as the gamut allows.
    #[default]
    Natural,
    /// Proportional, clamped to 1.
    Linear,
    /// Hable's curve for each channel.
    Filmic,
    /// Hill's fit of the reference rendering transform of ACES with its output for sRGB.
    Aces,
    /// AgX with its default contrast.
    Agx,
}

impl Tone {
    /// All tone mappings, in the order in which they are listed to users.
    pub const ALL: [Self; 5] = [Self::Natural, Self::Linear, Self::Filmic, Self::Aces, Self::Agx];

    /// Name by which options select it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Natural => "natural",
            Self::Linear => "linear",
            Self::Filmic => "filmic",
            Self::Aces => "aces",
            Self::Agx => "agx",
        }
    }

    /// Matrices and curve of a published tone mapping; `None` for the others.
    pub const fn published(self) -> Option<&'static Published> {
        match self {
            Self::Natural | Self::Linear => None,
            Self::Filmic => Some(&published::FILMIC),
            Self::Aces => Some(&published::ACES),
            Self::Agx => Some(&published::AGX),
        }
    }

    /// Converts radiance times `scale` to display-linear colour in `[0, 1]`.
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

    /// Returns the tone mapping of this name.
    ///
    /// # Errors
    /// [`Error::Option`] naming `tonemap` if no tone has that name.
    fn from_str(text: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|tone| tone.name() == text.trim())
            .ok_or_else(|| Error::option("tonemap", text, Self::ALL.map(Self::name).join(", ")))
    }
}

/// Brightness of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Exposure {
    /// Automatic: the log-average of the film becomes middle gray ([`automatic_stops`]).
    #[default]
    Auto,
    /// Stops: radiance is multiplied by two to this power. Higher values are brighter; at 0,
    /// radiance 1 is near white. Accepted: −64 to 64.
    Stops(f32),
}

/// Conversion of radiance to a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMap {
    /// Brightness of the picture. Default: automatic.
    pub exposure: Exposure,
    /// Treatment of contrast and of radiances that are too bright. Default: natural.
    pub tone: Tone,
}

impl ToneMap {
    /// Checks the range of the exposure.
    ///
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

    /// Returns red, green, blue and opacity of each pixel as bytes, and the exposure used (stops).
    /// Each of `pixels` is a radiance, and true if the pixel was rendered. Pixels that were not
    /// rendered are transparent and do not enter the exposure.
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

/// The shoulder `f` of the module's formula.
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
