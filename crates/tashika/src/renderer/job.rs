//! The work of a render: a method with its lights.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::integrator::{ControlOptions, GuidedLights, PathStop, SumMethod, Truth};
use crate::request::AuditTerms;
use crate::tree::LightSet;
use crate::vpl::{Provenance, VplOptions};

/// A method with its options and its lights.
#[derive(Clone, Debug)]
pub enum Job {
    /// A sum over one set of VPLs.
    Sum {
        /// Estimator of the sum.
        method: SumMethod,
        /// Error, confidence and budget of a pixel.
        options: ControlOptions,
        /// The VPLs, in a tree if the method needs one.
        lights: Arc<LightSet>,
        /// Options with which the VPLs were traced; `None` if they were given.
        traced: Option<VplOptions>,
    },
    /// An estimate of a truth about all sets of VPLs, from one large set.
    Transport {
        /// Light transport, or the part of it that clamped VPLs carry.
        truth: Truth,
        /// Error, confidence and budget of a pixel.
        options: ControlOptions,
        /// The VPLs, guided to the view.
        lights: Arc<GuidedLights>,
    },
    /// A reconstructed picture of light transport, audited as a whole.
    Audited(AuditedJob),
    /// Paths from the camera, without VPLs.
    Path {
        /// Condition under which a pixel has enough paths.
        stop: PathStop,
    },
}

/// An audited picture.
#[derive(Clone, Debug)]
pub struct AuditedJob {
    /// Error allowed in a pixel.
    pub options: ControlOptions,
    /// Share, assurance and size of the audit.
    pub terms: AuditTerms,
    /// Number of passes; `None` if the audit or a time limit ends them.
    pub passes: Option<u32>,
    /// VPLs, guided to the view, that the paths may draw; `None` if there are paths alone.
    pub lights: Option<Arc<GuidedLights>>,
}

impl Job {
    /// Origin of the VPLs, if there are any.
    pub fn provenance(&self) -> Option<&Provenance> {
        match self {
            Self::Sum { lights, .. } => Some(lights.provenance()),
            Self::Transport { lights, .. } | Self::Audited(AuditedJob { lights: Some(lights), .. }) => {
                Some(lights.provenance())
            }
            Self::Audited(AuditedJob { lights: None, .. }) | Self::Path { .. } => None,
        }
    }

    /// Returns the set of VPLs of a sum.
    ///
    /// # Errors
    /// [`Error::Option`] if the work is not a sum over one set.
    pub fn light_set(&self) -> Result<&Arc<LightSet>> {
        match self {
            Self::Sum { lights, .. } => Ok(lights),
            _ => Err(Error::option("truth", Truth::Transport, Truth::Vpl.to_string())),
        }
    }

    /// Returns the guided VPLs of an estimate of light transport.
    ///
    /// # Errors
    /// [`Error::Option`] if the work is another.
    pub fn guided_lights(&self) -> Result<&Arc<GuidedLights>> {
        match self {
            Self::Transport { lights, .. } | Self::Audited(AuditedJob { lights: Some(lights), .. }) => {
                Ok(lights)
            }
            Self::Sum { .. } => Err(Error::option("truth", Truth::Vpl, Truth::Transport.to_string())),
            _ => Err(Error::option("method", "path", "one that works with VPLs")),
        }
    }

    /// Returns true if pixels may claim something about their error. Returns false for
    /// [`SumMethod::Lightcuts`] and [`SumMethod::Mdlc`], whose bound is no claim, and for a fixed
    /// number of paths.
    pub fn promises(&self) -> bool {
        match self {
            Self::Sum { method, .. } => *method == SumMethod::Exact || method.states_interval(),
            Self::Transport { .. } | Self::Audited(_) => true,
            Self::Path { stop } => stop.options().is_some(),
        }
    }

    /// Returns true if the estimated quantity is a sum over one set of VPLs.
    pub fn is_of_a_sum(&self) -> bool {
        matches!(self, Self::Sum { .. })
    }

    /// Returns true if the picture is audited as a whole.
    pub fn is_audited(&self) -> bool {
        matches!(self, Self::Audited(_))
    }

    /// Options that state the promised distance of each pixel from its truth, if there is such a
    /// promise.
    pub fn options_of_pixels(&self) -> Option<&ControlOptions> {
        match self {
            Self::Sum { options, .. } | Self::Transport { options, .. } => Some(options),
            Self::Path { stop } => stop.options(),
            Self::Audited(_) => None,
        }
    }
}
