//! How pixels are computed: the methods as they are called, and a method with all that it needs.

use std::fmt;
use std::str::FromStr;

use super::AuditTerms;
use crate::error::{Error, Result};
use crate::film::{Film, Metadata, keys};
use crate::integrator::{ControlOptions, PathStop, Promise, SumMethod, Truth};
use crate::reconstruction::reconstruct;
use crate::scene::Abilities;
use crate::vpl::VplOptions;

/// Pairs and paths of all pixels, at most, where nobody asks for an error: a picture in minutes, of
/// which each pixel says what it is worth.
const PICTURE_WORK: u64 = 50_000_000;
/// Fewest and most of these a pixel: with fewer it would be noise, and more is for who asks for an
/// error.
const PIXEL_WORK: [u64; 2] = [128, 4096];
/// Terms of a pixel up to which ours is the whole sum: that takes no longer than to know it to 2 %.
/// Measured.
const SHORT_SUM: u64 = 16_000;

/// A method as users call it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MethodName {
    /// One that works with VPLs. Ours is of light transport, unless a [`Truth`] is said that is
    /// about one set of them.
    ManyLights(SumMethod),
    /// Path tracing.
    Path,
}

impl MethodName {
    /// Name of path tracing.
    const PATH: &'static str = "path";

    /// All of them, in the order of their years, path tracing last.
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

    /// The method that works with VPLs, if it is one.
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

/// How pixels are computed, with all that this method needs and nothing else.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// A sum over one set of VPLs.
    Sum {
        /// How the sum is found.
        method: SumMethod,
        /// How the set is traced; nothing if it is given.
        lights: Option<VplOptions>,
        /// What methods that control their error are told.
        options: ControlOptions,
    },
    /// One large set of VPLs, as one of all that there could be.
    Transport {
        /// How it is traced; nothing if it is given.
        lights: Option<VplOptions>,
        /// Light transport, or what is left of it without what VPLs do not carry.
        truth: Truth,
        /// What is promised.
        options: ControlOptions,
        /// Whether nobody asked for an error, so that pixels may run out of budget.
        is_picture: bool,
    },
    /// A picture of light transport that is reconstructed, and audited as a whole.
    Audited {
        /// How the VPLs of the picture are traced, the audit has others; nothing if both are by path
        /// tracing alone.
        lights: Option<VplOptions>,
        /// The error that pixels may have.
        options: ControlOptions,
        /// What the audit is to find out.
        terms: AuditTerms,
    },
    /// Path tracing.
    Path {
        /// When a pixel has paths enough.
        stop: PathStop,
        /// Whether nobody asked for an error, so that pixels may run out of budget.
        is_picture: bool,
    },
}

impl Method {
    /// Whether pixels may claim something about their error: the bound by which
    /// [`SumMethod::Lightcuts`] and [`SumMethod::Mdlc`] stop is no claim, nor is a number of paths.
    pub fn promises(&self) -> bool {
        match self {
            Self::Sum { method, .. } => *method == SumMethod::Exact || method.states_interval(),
            Self::Transport { .. } | Self::Audited { .. } => true,
            Self::Path { stop, .. } => stop.options().is_some(),
        }
    }

    /// What it renders beside what stands still.
    pub fn abilities(&self) -> Abilities {
        match self {
            Self::Audited { lights: None, .. } | Self::Path { .. } => Abilities::ALL,
            Self::Sum { .. } => Abilities::ALL,
            Self::Transport { .. } | Self::Audited { lights: Some(_), .. } => Abilities::STILL,
        }
    }

    /// Whether what is promised, or computed, is a sum over one set of VPLs.
    pub fn is_of_a_sum(&self) -> bool {
        matches!(self, Self::Sum { .. })
    }

    /// Whether pixels may run out of budget without anybody's being disappointed.
    pub fn is_picture(&self) -> bool {
        matches!(self, Self::Transport { is_picture: true, .. } | Self::Path { is_picture: true, .. })
    }

    /// Whether the metadata are those of a film that was rendered so.
    pub fn was_picture(metadata: &Metadata) -> bool {
        metadata.bool(keys::PICTURE) == Some(true)
    }

    /// Does with a finished film what was asked for beyond its estimates: a picture is
    /// [reconstructed](reconstruct), unless it has planes of what lights give, which add up to it as it
    /// is. Whoever joins parts of a film calls it for the whole, with what the parts say. Runs on the
    /// current thread pool.
    pub fn finish(film: &mut Film) {
        let has_groups = film.metadata().get(keys::LIGHT_GROUPS).is_some();
        if Self::was_picture(film.metadata()) && !has_groups {
            reconstruct(film);
        }
    }

    /// Writes what a film says of the request beyond what its integrator does.
    pub fn describe(&self, metadata: &mut Metadata) {
        if self.is_picture() {
            metadata.set(keys::PICTURE, true);
        }
    }

    /// The same over so many VPLs at so many gather points a pixel: by our method, a sum of at most
    /// 16,000 terms is computed whole, unless it was said how large its cuts may be.
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

    /// The same for an image of that size (pixels). A picture for which nobody asked for an error
    /// has so much work in all that it takes minutes, whatever its size: 50 million pairs and
    /// paths, 128 to 4096 a pixel.
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
