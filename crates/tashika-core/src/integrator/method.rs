//! Methods by name: a closed list, to choose from at run time.

use std::fmt;
use std::str::FromStr;

use super::{
    ControlOptions, FullSum, Ingredient, Integrator, Iwasaki2019, Lightcuts, Lights, Mdlc, Nabata2016,
    Promise, Sakai2018, Tashika,
};
use crate::error::{Error, Result};
use crate::tree::LightSet;

/// Terms of a pixel up to which our method computes the whole sum, which takes no longer than an
/// estimate to 2 %. Measured.
const SHORT_SUM: u64 = 16_000;

/// A method that estimates the sum over a set of VPLs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SumMethod {
    /// The whole sum, without sampling.
    Exact,
    /// Walter 2005.
    Lightcuts,
    /// Walter 2006.
    Mdlc,
    /// Nabata 2016.
    Nabata2016,
    /// Sakai 2018.
    Sakai2018,
    /// Iwasaki 2019.
    Iwasaki2019,
    /// Our method.
    Tashika(Promise),
    /// Our calibrated method without one of its ingredients.
    Without(Ingredient),
}

impl SumMethod {
    /// All methods that render images, in the order of their years.
    pub const ALL: [Self; 8] = [
        Self::Exact,
        Self::Lightcuts,
        Self::Mdlc,
        Self::Nabata2016,
        Self::Sakai2018,
        Self::Iwasaki2019,
        Self::Tashika(Promise::Calibrated),
        Self::Tashika(Promise::Certified),
    ];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Lightcuts => "lightcuts",
            Self::Mdlc => "mdlc",
            Self::Nabata2016 => "nabata2016",
            Self::Sakai2018 => "sakai2018",
            Self::Iwasaki2019 => "iwasaki2019",
            Self::Tashika(promise) => promise.method_name(),
            Self::Without(ingredient) => ingredient.left_out(),
        }
    }

    /// Returns true if the method states an interval for each pixel.
    pub fn states_interval(self) -> bool {
        match self {
            Self::Exact | Self::Lightcuts | Self::Mdlc => false,
            Self::Nabata2016 | Self::Sakai2018 | Self::Iwasaki2019 | Self::Tashika(_) | Self::Without(_) => {
                true
            }
        }
    }

    /// Returns the method for a sum of `terms` terms a pixel. Our method computes a sum of at most
    /// 16,000 terms whole, unless `max_pairs` sets the size of its cuts.
    #[must_use]
    pub fn for_terms(self, terms: u64, max_pairs: Option<u64>) -> Self {
        let is_short = terms <= SHORT_SUM && max_pairs.is_none();
        if matches!(self, Self::Tashika(_)) && is_short { Self::Exact } else { self }
    }

    /// Returns true if the method uses a light tree.
    pub fn needs_tree(self) -> bool {
        self != Self::Exact
    }

    /// Returns the integrator of the method for these lights. Builds the tree of the lights if the
    /// method needs one.
    ///
    /// # Errors
    /// As [`ControlOptions::validate`].
    pub fn integrator<'a>(
        self,
        lights: &'a LightSet,
        options: &ControlOptions,
    ) -> Result<Box<dyn Integrator + 'a>> {
        options.validate()?;
        let in_tree = || Lights { tree: lights.tree(), provenance: lights.provenance() };
        Ok(match self {
            Self::Exact => Box::new(FullSum::new(lights.set())),
            Self::Lightcuts => Box::new(Lightcuts::new(in_tree(), options)),
            Self::Mdlc => Box::new(Mdlc::new(in_tree(), options)),
            Self::Nabata2016 => Box::new(Nabata2016::new(in_tree(), options)),
            Self::Sakai2018 => Box::new(Sakai2018::new(in_tree(), options)),
            Self::Iwasaki2019 => Box::new(Iwasaki2019::new(in_tree(), options)),
            Self::Without(ingredient) => Box::new(Tashika::without(in_tree(), options, ingredient)),
            Self::Tashika(promise) => Box::new(Tashika::new(in_tree(), options, promise)),
        })
    }
}

impl fmt::Display for SumMethod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for SumMethod {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::option("method", name, format!("one of {names}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Our method computes a short sum whole, with any claim. Long sums are estimated, and other
    /// methods stay as requested.
    #[test]
    fn short_sums_are_whole() {
        for promise in [Promise::Calibrated, Promise::Certified] {
            let ours = SumMethod::Tashika(promise);
            assert_eq!(ours.for_terms(16_000, None), SumMethod::Exact);
            assert_eq!(ours.for_terms(16_001, None), ours);
            assert_eq!(ours.for_terms(400, Some(99)), ours);
        }
        assert_eq!(SumMethod::Lightcuts.for_terms(400, None), SumMethod::Lightcuts);
    }

    #[test]
    fn names_are_read_back() {
        for method in SumMethod::ALL {
            assert_eq!(method.name().parse::<SumMethod>().unwrap(), method);
        }
        let message = "iwasaki".parse::<SumMethod>().unwrap_err().to_string();
        assert!(message.contains("iwasaki2019"), "{message}");
    }
}
