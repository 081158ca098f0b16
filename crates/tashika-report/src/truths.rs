//! Comparison of the truths that two films estimate, by their metadata.

use crate::film::keys::{self, About};
use crate::film::{Film, Metadata, Value};

/// Result of comparing the truths in the metadata of an image and of its reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Truths {
    /// Equal truths: scene and camera agree. Unless the truth is light transport, VPLs and gather
    /// points agree as well.
    Same,
    /// The metadata differ, and one of the films does not name its truth.
    Unsaid,
    /// Different quantities, such as a sum over VPLs and light transport. The strings are the
    /// values of [`TRUTH`](keys::TRUTH) of the image and of the reference.
    Quantities([String; 2]),
    /// Sums over different VPLs or gather points.
    Sums,
    /// Different views: name of the first metadata value that differs.
    Views(String),
}

impl Truths {
    /// Compares an image and its reference.
    pub(super) fn of(image: &Film, reference: &Film) -> Self {
        let [a, b] = [image, reference].map(Film::metadata);
        if truth_of(a).eq(truth_of(b)) {
            return Self::Same;
        }
        let [ours, theirs] = [a, b].map(|metadata| metadata.text(keys::TRUTH).map(str::to_owned));
        let Some((ours, theirs)) = ours.zip(theirs) else { return Self::Unsaid };
        if ours != theirs {
            return Self::Quantities([ours, theirs]);
        }
        let names = |metadata: &Metadata| -> Vec<String> {
            let of_truth = metadata.iter().filter(|(name, _)| keys::about(name) == About::Truth);
            of_truth.map(|(name, _)| name.to_owned()).collect()
        };
        let differs = |name: &String| a.get(name.as_str()) != b.get(name.as_str());
        match names(a).into_iter().chain(names(b)).find(differs) {
            Some(name) => Self::Views(name),
            None => Self::Sums,
        }
    }

    /// Returns true if the films estimate different truths, by their metadata.
    pub fn differ(&self) -> bool {
        !matches!(self, Self::Same | Self::Unsaid)
    }
}

/// Returns the metadata that define the truth of a film: scene, camera and, except for light
/// transport, the parameters of VPLs and gather points.
fn truth_of(metadata: &Metadata) -> impl Iterator<Item = (&str, &Value)> {
    let is_transport = metadata.text(keys::TRUTH) == Some("transport");
    metadata.iter().filter(move |(name, _)| match keys::about(name) {
        About::Truth => true,
        About::Sum => !is_transport,
        About::Making | About::Part => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Window, planes};

    #[test]
    fn what_differs_is_named() {
        let film = |facts: &[(&str, &str)]| {
            let mut film = Film::new([1, 1], Window::full([1, 1]), &[planes::RADIANCE]).unwrap();
            facts.iter().for_each(|(name, value)| film.metadata_mut().set(*name, *value));
            film
        };
        let sum = film(&[("truth", "vpl"), ("scene", "a"), ("seed", "1")]);
        let found = |reference: &[(&str, &str)]| Truths::of(&sum, &film(reference));
        assert_eq!(
            found(&[("truth", "vpl"), ("scene", "a"), ("seed", "1"), ("method", "mdlc")]),
            Truths::Same
        );
        assert_eq!(found(&[("truth", "vpl"), ("scene", "a"), ("seed", "2")]), Truths::Sums);
        assert_eq!(
            found(&[("truth", "vpl"), ("scene", "b"), ("seed", "1")]),
            Truths::Views("scene".to_owned())
        );
        let quantities = Truths::Quantities(["vpl", "transport"].map(str::to_owned));
        assert_eq!(found(&[("truth", "transport"), ("scene", "a"), ("seed", "2")]), quantities);
        assert_eq!(found(&[]), Truths::Unsaid);
        assert_eq!(Truths::of(&film(&[]), &film(&[])), Truths::Same, "neither says of what");
        assert!(!found(&[]).differ() && quantities.differ());
    }
}
