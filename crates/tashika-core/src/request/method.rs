//! Methods by name, and a method with all of its options.

use std::fmt;
use std::str::FromStr;

use super::AuditTerms;
use crate::error::{Error, Result};
use crate::integrator::{ControlOptions, PathStop, Promise, SumMethod, Truth};
use crate::scene::Abilities;
use crate::vpl::VplOptions;

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
        /// Number of passes; `None` if the audit or a time limit ends them.
        passes: Option<u32>,
    },
    /// Unidirectional path tracing, without VPLs.
    Path {
        /// Condition under which a pixel has enough paths.
        stop: PathStop,
    },
}

impl Method {
    /// Features of scenes that the method renders in addition to still surfaces.
    pub fn abilities(&self) -> Abilities {
        match self {
            Self::Audited { lights: None, .. } | Self::Path { .. } => Abilities::ALL,
            Self::Sum { .. } => Abilities::ALL,
            Self::Transport { .. } | Self::Audited { lights: Some(_), .. } => Abilities::STILL,
        }
    }
}
