//! Methods by name, and a method with all of its options.

use std::fmt;
use std::str::FromStr;

use super::AuditTerms;
use crate::error::{Error, Result};
use crate::film::{Film, Metadata, keys};
use crate::integrator::{ControlOptions, PathStop, Promise, SumMethod, Truth};
use crate::reconstruction::reconstruct;
use crate::scene::Abilities;
use crate::vpl::VplOptions;

/// Most pairs and paths of all pixels where no error is requested. A picture then takes minutes,
/// and each pixel states its own error.
const PICTURE_WORK: u64 = 50_000_000;
/// Fewest and most pairs or paths a pixel: fewer would leave noise, and more are used only if an
/// error is set.
const PIXEL_WORK: [u64; 2] = [128, 4096];
/// Terms of a pixel up to which our method computes the whole sum, which takes no longer than an
/// estimate to 2 %. Measured.
const SHORT_SUM: u64 = 16_000;

/// A method, as users name it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MethodName {
    /// A method that works with VPLs. Ours estimates light transport, unless the request names a
    /// [`Truth`] about one set of VPLs.
    ManyLights(SumMethod),
    /// Unidirectional path tracing, without VPLs.
    Path,
}

impl MethodName {
    const PATH: &'static str = "path";

    /// All methods, in the order of publication, path tracing last.
    pub fn all() -> impl Iterator<Item = Self> {
        SumMethod::ALL.into_iter().map(Self::ManyLights).chain([Self::Path])
    }

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::ManyLights(method) => method.name(),
            Self::Path => Self::PATH,
        }
    }

    /// Returns the method that works with VPLs, or `None` for path tracing.
    pub fn of_lights(self) -> Option<SumMethod> {
        match self {
            Self::ManyLights(method) => Some(method),
            Self::Path => None,
        }
    }
}

impl Default for MethodName {
    fn default() -> Self {
        Self::ManyLights(SumMethod::Tashika(Promise::Calibrated))
    }
}

impl From<SumMethod> for MethodName {
    fn from(method: SumMethod) -> Self {
        Self::ManyLights(method)
    }
}

impl fmt::Display for MethodName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for MethodName {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::all().find(|method| method.name() == name).ok_or_else(|| {
            let names: Vec<&str> = Self::all().map(Self::name).collect();
            Error::option("method", name, format!("one of {}", names.join(", ")))
        })
    }
}

/// A method with all options that it needs, and no others.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// A sum over one set of VPLs.
    Sum {
        /// Estimator of the sum.
        method: SumMethod,
        /// Options for tracing the VPLs; `None` if they are given.
        lights: Option<VplOptions>,
        /// Options of methods that control their error.
        options: ControlOptions,
    },
    /// An estimate of a truth about all sets of VPLs, from one large set.
    Transport {
        /// Options for tracing the VPLs; `None` if they are given.
        lights: Option<VplOptions>,
        /// Light transport, or the part of it that clamped VPLs carry.
        truth: Truth,
        /// Error, confidence and budget of a pixel.
        options: ControlOptions,
        /// True if no error was requested, so that pixels may run out of budget.
        is_picture: bool,
    },
    /// A reconstructed picture of light transport, audited as a whole.
    Audited {
        /// Options for tracing the VPLs of the picture (the audit has others); `None` if picture
        /// and audit use only path tracing.
        lights: Option<VplOptions>,
        /// Error allowed in a pixel.
        options: ControlOptions,
        /// Share, assurance and size of the audit.
        terms: AuditTerms,
    },
    /// Unidirectional path tracing, without VPLs.
    Path {
        /// Condition under which a pixel has enough paths.
        stop: PathStop,
        /// True if no error was requested, so that pixels may run out of budget.
        is_picture: bool,
    },
}

impl Method {
    /// Returns true if pixels may claim something about their error. Returns false for
    /// [`SumMethod::Lightcuts`] and [`SumMethod::Mdlc`], whose bound is no claim, and for a fixed
    /// number of paths.
    pub fn promises(&self) -> bool {
        match self {
            Self::Sum { method, .. } => *method == SumMethod::Exact || method.states_interval(),
            Self::Transport { .. } | Self::Audited { .. } => true,
            Self::Path { stop, .. } => stop.options().is_some(),
        }
    }

    /// Features of scenes that the method renders in addition to still surfaces.
    pub fn abilities(&self) -> Abilities {
        match self {
            Self::Audited { lights: None, .. } | Self::Path { .. } => Abilities::ALL,
            Self::Sum { .. } => Abilities::ALL,
            Self::Transport { .. } | Self::Audited { lights: Some(_), .. } => Abilities::STILL,
        }
    }

    /// Returns true if the estimated quantity is a sum over one set of VPLs.
    pub fn is_of_a_sum(&self) -> bool {
        matches!(self, Self::Sum { .. })
    }

    /// Returns true if no error was requested, so that pixels may run out of budget.
    pub fn is_picture(&self) -> bool {
        matches!(self, Self::Transport { is_picture: true, .. } | Self::Path { is_picture: true, .. })
    }

    /// Returns true if a film with this metadata was made by a method for which
    /// [`is_picture`](Self::is_picture) is true.
    pub fn was_picture(metadata: &Metadata) -> bool {
        metadata.bool(keys::PICTURE) == Some(true)
    }

    /// Finishes a film. A picture without a requested error is [reconstructed](reconstruct). If it
    /// has planes of light groups, the film stays unchanged, since these planes add up to the
    /// radiance before reconstruction. Films of parts are finished after they are joined, with the
    /// metadata of the parts. Runs on the current thread pool.
    pub fn finish(film: &mut Film) {
        let has_groups = film.metadata().get(keys::LIGHT_GROUPS).is_some();
        if Self::was_picture(film.metadata()) && !has_groups {
            reconstruct(film);
        }
    }

    /// Writes metadata about the request that the integrator does not write.
    pub fn describe(&self, metadata: &mut Metadata) {
        if self.is_picture() {
            metadata.set(keys::PICTURE, true);
        }
    }

    /// Returns the method for `lights` VPLs and `points` gather points a pixel. Our method computes
    /// a sum of at most 16,000 terms whole, unless the request sets the size of its cuts.
    #[must_use]
    pub fn over(&self, lights: usize, points: u32) -> Self {
        let mut chosen = self.clone();
        if let Self::Sum { method: method @ SumMethod::Tashika(_), options, .. } = &mut chosen
            && options.max_pairs.is_none()
            && lights as u64 * u64::from(points) <= SHORT_SUM
        {
            *method = SumMethod::Exact;
        }
        chosen
    }

    /// Returns the method for an image of `size` (pixels). A picture without a requested error
    /// takes minutes, whatever its size: 50 million pairs and paths in all, 128 to 4096 a pixel.
    #[must_use]
    pub fn sized(&self, size: [u32; 2]) -> Self {
        let mut sized = self.clone();
        let pixels = size.map(u64::from).iter().product::<u64>().max(1);
        let [fewest, most] = PIXEL_WORK;
        let of_pixel = (PICTURE_WORK / pixels).clamp(fewest, most);
        match &mut sized {
            Self::Transport { options, is_picture: true, .. } => {
                options.max_pairs.get_or_insert(of_pixel);
            }
            Self::Path { stop: PathStop::Calibrated { most, .. }, is_picture: true } => {
                *most = of_pixel as u32;
            }
            _ => {}
        }
        sized
    }
}
