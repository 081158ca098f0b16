//! Places of a scene: groups of surfaces that are close together and face the same way, and parts
//! of media.
//!
//! The places are the leaves of a k-d tree (Bentley 1975) over position and normal of the receivers
//! that paths met; the normal is zero in media. A node is halved at the median of the coordinate
//! that varies most, with positions in units of the spread of all positions.

use glam::Vec3;

use crate::scene::MediumId;

/// Approximate number of places, if there are enough receivers.
const PLACES: usize = 512;
/// Number of receivers up to which a place is not divided: smaller places would show nothing new.
const FEWEST: usize = 32;

/// Receiver of light: a surface, or a place in a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Position on the surface or in the medium (m).
    pub position: Vec3,
    /// Unit normal of a surface, on the side that receives light; `None` in media, which receive it
    /// from all directions.
    pub normal: Option<Vec3>,
    /// Medium that light passes last on its way to the receiver, if there is one.
    pub medium: Option<MediumId>,
}

impl Receiver {
    /// Returns the cosine of a unit direction with the normal, at least 0; in a medium 1.
    pub fn cosine(&self, direction: Vec3) -> f32 {
        self.normal.map_or(1.0, |normal| normal.dot(direction).max(0.0))
    }

    fn coordinate(&self, axis: usize) -> f32 {
        if axis < 3 { self.position[axis] } else { self.normal.map_or(0.0, |normal| normal[axis - 3]) }
    }
}

/// Division of receivers into places.
#[derive(Clone, Debug, Default)]
pub(super) struct Places {
    /// Nodes of the tree, depth first; empty if there are no places.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    /// Receivers below `at` on the axis are under the next node, others under the node `second`.
    Split {
        axis: u8,
        at: f32,
        second: u32,
    },
    Place(u32),
}

impl Places {
    /// Divides receivers into places. Also returns the receivers of each place.
    pub(super) fn divide(mut met: Vec<Receiver>) -> (Self, Vec<Vec<Receiver>>) {
        let mut places = Self::default();
        let mut of_places = Vec::new();
        let spread = spread_of_positions(&met);
        let most = (met.len() / PLACES).max(FEWEST);
        if !met.is_empty() {
            places.add(&mut met, spread, most, &mut of_places);
        }
        (places, of_places)
    }

    fn add(&mut self, met: &mut [Receiver], spread: f32, most: usize, of_places: &mut Vec<Vec<Receiver>>) {
        let at = self.nodes.len();
        let variance = |axis: usize| {
            let variance = variance(met, axis);
            if axis < 3 { variance / (spread * spread) } else { variance }
        };
        let widest = (0..6).map(|axis| (variance(axis), axis)).max_by(|a, b| a.0.total_cmp(&b.0));
        let axis = widest.filter(|(variance, _)| *variance > 0.0 && met.len() > most).map(|(_, axis)| axis);
        let Some(axis) = axis else {
            self.nodes.push(Node::Place(of_places.len() as u32));
            of_places.push(met.to_vec());
            return;
        };
        met.sort_by(|a, b| a.coordinate(axis).total_cmp(&b.coordinate(axis)));
        let half = met.len() / 2;
        let middle = met[half].coordinate(axis);
        // Equal coordinates stay together, so that `of` finds their receivers.
        let below = met.partition_point(|receiver| receiver.coordinate(axis) < middle);
        let below = if below > 0 { below } else { met.partition_point(|r| r.coordinate(axis) <= middle) };
        let split = met[below].coordinate(axis);
        let (first, second) = met.split_at_mut(below);
        self.nodes.push(Node::Split { axis: axis as u8, at: split, second: 0 });
        self.add(first, spread, most, of_places);
        let next = self.nodes.len() as u32;
        if let Node::Split { second, .. } = &mut self.nodes[at] {
            *second = next;
        }
        self.add(second, spread, most, of_places);
    }

    /// Returns the place of a receiver; `None` if there are no places.
    pub(super) fn of(&self, receiver: &Receiver) -> Option<usize> {
        let mut at = 0;
        loop {
            match *self.nodes.get(at)? {
                Node::Place(place) => return Some(place as usize),
                Node::Split { axis, at: split, second } => {
                    let is_first = receiver.coordinate(axis.into()) < split;
                    at = if is_first { at + 1 } else { second as usize };
                }
            }
        }
    }
}

fn variance(met: &[Receiver], axis: usize) -> f32 {
    let mut moments = crate::stats::Moments::default();
    met.iter().for_each(|receiver| moments.push(receiver.coordinate(axis).into()));
    moments.variance() as f32
}

/// Root mean square distance from the mean position; positive.
fn spread_of_positions(met: &[Receiver]) -> f32 {
    (0..3).map(|axis| variance(met, axis)).sum::<f32>().sqrt().max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// 10,000 receivers in a square, with two normals or none. Each is found in the place that it
    /// was put into; places are small, and all receivers of a place have the same normal.
    #[test]
    fn surfaces_are_found_in_their_places() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let mut one = || {
            let normal = [Some(Vec3::Z), Some(Vec3::NEG_Z), None][s.below(3) as usize];
            let position = Vec3::new(s.uniform(), s.uniform(), 0.0);
            Receiver { position, normal, medium: None }
        };
        let met: Vec<Receiver> = (0..10_000).map(|_| one()).collect();
        let (places, of_places) = Places::divide(met.clone());
        assert_eq!(of_places.iter().map(Vec::len).sum::<usize>(), met.len());
        assert!((100..1000).contains(&of_places.len()), "{} places", of_places.len());
        for (number, inside) in of_places.iter().enumerate() {
            assert!((1..=FEWEST).contains(&inside.len()));
            assert!(inside.iter().all(|receiver| places.of(receiver) == Some(number)));
            assert!(inside.iter().all(|receiver| receiver.normal == inside[0].normal));
        }
        assert_eq!(Places::default().of(&met[0]), None);
    }

    /// Equal receivers stay in one place, however many there are.
    #[test]
    fn the_same_surface_many_times_is_one_place() {
        let one = Receiver { position: Vec3::ONE, normal: Some(Vec3::X), medium: None };
        let (places, of_places) = Places::divide(vec![one; 1000]);
        assert_eq!((of_places.len(), places.of(&one)), (1, Some(0)));
    }
}
