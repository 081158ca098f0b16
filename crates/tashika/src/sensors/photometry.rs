//! Luminous efficacy: illuminance from irradiance.

use std::fmt;
use std::str::FromStr;

use crate::color::{Controlled, Rgb};
use crate::error::{Error, Result};

/// Conversion of irradiance by channel to illuminance.
///
/// ```text
/// scene       E_v = 1 · (0.2126 R + 0.7152 G + 0.0722 B)        the scene is in photometric units
/// cie         E_v = 683 · (0.2126 R + 0.7152 G + 0.0722 B)      lm·W⁻¹, luminosity of Rec. 709
/// radiance    E_v = 179 · (0.265 R + 0.670 G + 0.065 B)         Radiance's `WHTEFFICACY` and weights
/// ```
///
/// The default is `scene`, since IES files and the lamps of glTF state candela and lumen, which are
/// read as W·sr⁻¹ and W without a factor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Photometry {
    /// The numbers of the scene are photometric: radiance is luminance in cd·m⁻².
    #[default]
    Scene,
    /// The numbers of the scene are radiometric, in the working primaries.
    Cie,
    /// The numbers of the scene are radiometric, as in Radiance.
    Radiance,
}

impl Photometry {
    /// Every conversion, the default first.
    pub const ALL: [Self; 3] = [Self::Scene, Self::Cie, Self::Radiance];

    /// Name in options and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Cie => "cie",
            Self::Radiance => "radiance",
        }
    }

    /// Illuminance of white light over its irradiance (lm·W⁻¹).
    pub fn efficacy(self) -> f64 {
        match self {
            Self::Scene => 1.0,
            Self::Cie => 683.0,
            Self::Radiance => 179.0,
        }
    }

    /// Weights of the channels; they sum to 1.
    pub fn weights(self) -> [f64; 3] {
        let of_channel = |channel: [f32; 3]| f64::from(Rgb::from(channel).luminance());
        match self {
            Self::Scene | Self::Cie => {
                [of_channel([1.0, 0.0, 0.0]), of_channel([0.0, 1.0, 0.0]), of_channel([0.0, 0.0, 1.0])]
            }
            Self::Radiance => [0.265, 0.670, 0.065],
        }
    }

    /// Luminous efficacies of the channels (lm·W⁻¹): the weights times the efficacy of white.
    pub fn efficacies(self) -> [f64; 3] {
        self.weights().map(|weight| weight * self.efficacy())
    }

    /// Returns the illuminance (lx) of an irradiance by channel (W·m⁻²).
    pub fn illuminance(self, irradiance: [f64; 3]) -> f64 {
        let weighted = irradiance.iter().zip(self.weights()).map(|(value, weight)| value * weight);
        self.efficacy() * weighted.sum::<f64>()
    }

    /// Error metric whose half-width bounds the error of the illuminance. The half-width of the
    /// worst channel bounds the error of every weighted mean of the channels.
    pub fn controlled(self) -> Controlled {
        match self {
            Self::Scene | Self::Cie => Controlled::Luminance,
            Self::Radiance => Controlled::Channels,
        }
    }
}

impl fmt::Display for Photometry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Photometry {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let known = Self::ALL.into_iter().find(|photometry| photometry.name() == text);
        known.ok_or_else(|| Error::option("photometry", text, Self::ALL.map(Self::name).join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_has_the_efficacy_and_green_its_weight() {
        for photometry in Photometry::ALL {
            let white = photometry.illuminance([2.0; 3]);
            assert!((white - 2.0 * photometry.efficacy()).abs() < 1e-3, "{photometry}: {white}");
            assert_eq!(photometry.name().parse::<Photometry>().unwrap(), photometry);
        }
        assert!((Photometry::Radiance.illuminance([0.0, 1.0, 0.0]) - 119.93).abs() < 1e-9);
        assert!((Photometry::Cie.illuminance([0.0, 1.0, 0.0]) - 488.48).abs() < 0.01);
        assert!("lux".parse::<Photometry>().unwrap_err().to_string().contains("scene, cie, radiance"));
    }
}
