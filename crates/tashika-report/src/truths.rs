//! Truths that two films say they are about: the same, others, or nothing said.

use crate::film::keys::{self, About};
use crate::film::{Film, Metadata, Value};

/// What the metadata of an image and of its reference say of the truths that these estimate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Truths {
    /// The same: of the same scene and camera and, unless it is light transport, of the same VPLs and
    /// gather points.
    Same,
    /// The reference does not say.
    Unsaid,
    /// Different quantities: a sum over VPLs and light transport, say. Names by the key
    /// [`TRUTH`](keys::TRUTH), of the image and of the reference.
    Quantities([String; 2]),
    /// Sums over other VPLs or gather points.
    Sums,
    /// Different views; the name of the first value of the metadata that differs.
    Views(String),
}

impl Truths {
    /// Of an image and its reference.
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

    /// Returns true if the films say that they are about different truths.
    pub fn differ(&self) -> bool {
        !matches!(self, Self::Same | Self::Unsaid)
    }
}

/// What the metadata say of the truth that a film estimates: scene, camera, and, unless it is light
/// transport, what VPLs and gather points were drawn from.
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
