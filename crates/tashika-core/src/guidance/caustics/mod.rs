//! Caustics: light that reaches a surface from an emitter over specular surfaces, as found by light
//! paths.
//!
//! Sums over VPLs do not carry this light, and a camera path meets a small emitter only by chance.
//! Light paths begin at the emitter. They therefore find both the amount of light ([`Photons`]) and
//! its directions: each photon stores its [`Wavefront`], which predicts the direction of the light
//! at places near by. [`Directions`] guide camera paths by these predictions.
//!
//! # Held to this by
//! The tests below, and the suite's `caustics`.

mod directions;
mod wavefront;

use rayon::prelude::*;

use super::photons::{Photons, Side, side};
use crate::math::{Aabb, Vec3};
use crate::vpl::{CausticPhoton, Vpl};

pub use directions::Directions;
use wavefront::{Neighbour, Wavefront};

/// Maximum number of photons whose wavefronts guide a path at one place.
const MOST_KERNELS: usize = 24;
/// Maximum number of neighbours to which a wavefront is fitted.
const MOST_NEIGHBOURS: usize = 256;

/// Origin of the light of a photon.
#[derive(Clone, Copy, Debug)]
struct Source {
    position: Vec3,
    /// Luminance of the intensity of its VPL (W·sr⁻¹).
    intensity: f32,
    /// Share of caustics in the flux of all light paths around the photon.
    share: f32,
    /// Predicted directions near the photon. `None` if too few neighbours came over the same
    /// surfaces, and for light through panes, which is found by drawing emitters.
    wavefront: Option<Wavefront>,
}

/// Caustics of a scene, as photons.
#[derive(Clone, Debug)]
pub struct Caustics {
    photons: Photons,
    /// Origins of the light, in the order of the photons.
    sources: Vec<Source>,
}

impl Caustics {
    /// Returns the caustics of these photons, among all VPLs that the light paths left; `None` if
    /// the photons are too few. Runs on the current thread pool.
    pub(super) fn learn(found: &[CausticPhoton], lights: &[Vpl], bounds: &Aabb, seed: u64) -> Option<Self> {
        let of_photons: Vec<Vpl> = found.iter().map(|photon| photon.light).collect();
        Some(Self::of(found, lights, Photons::new(&of_photons, bounds, seed)?))
    }

    fn of(found: &[CausticPhoton], lights: &[Vpl], (photons, numbers): (Photons, Vec<usize>)) -> Self {
        let found: Vec<&CausticPhoton> = numbers.iter().map(|number| &found[*number]).collect();
        let of_all = flux_by_side(lights, photons.radius());
        let of_caustics = flux_by_side(found.iter().map(|photon| &photon.light), photons.radius());
        let source = |photon: &&CausticPhoton| {
            let at = side(photon.light.position, photon.light.direction, photons.radius());
            Source {
                position: photon.light.position,
                intensity: photon.light.intensity.luminance(),
                share: (flux_in(&of_caustics, at) / flux_in(&of_all, at)).min(1.0) as f32,
                wavefront: wavefront(photon, &found, &photons),
            }
        };
        let sources = found.par_iter().map(source).collect();
        Self { photons, sources }
    }

    /// Returns the approximate luminance that a surface sends out from caustics, less two standard
    /// errors (W·m⁻²·sr⁻¹).
    pub fn importance_radiance(&self, position: Vec3, normal: Vec3) -> f64 {
        self.photons.importance_radiance(position, normal)
    }

    /// Adds the directions from which caustics reach a surface. Returns
    /// [`importance_radiance`](Self::importance_radiance) there.
    pub fn look_for_directions(&self, position: Vec3, normal: Vec3, directions: &mut Directions) -> f64 {
        let mut near = std::mem::take(&mut directions.near);
        near.clear();
        let radiance = self.photons.each_near(position, normal, |number| {
            if self.sources[number].wavefront.is_some() {
                near.push(number);
            }
        });
        for number in thinned(&near, MOST_KERNELS) {
            let source = &self.sources[number];
            let Some(wavefront) = &source.wavefront else { continue };
            if let Some(towards) = wavefront.towards_at(position - source.position)
                && normal.dot(towards) > 0.0
            {
                directions.add(towards, wavefront.spread, source.intensity, source.share);
            }
        }
        directions.near = near;
        radiance
    }
}

/// Fits the wavefront of a photon to its neighbours among all photons, `found`, which are in the
/// order of `photons`.
fn wavefront(photon: &CausticPhoton, found: &[&CausticPhoton], photons: &Photons) -> Option<Wavefront> {
    if photon.is_through_panes {
        return None;
    }
    let Vpl { position, direction, .. } = photon.light;
    let mut near = Vec::new();
    photons.each_near(position, direction, |number| near.push(number));
    let same_chain = thinned(&near, MOST_NEIGHBOURS).map(|number| found[number]);
    let neighbours = same_chain
        .filter(|other| other.chain == photon.chain)
        .map(|other| Neighbour { offset: other.light.position - position, towards: other.towards });
    Wavefront::fit(photon.towards, photon.distance, &neighbours.collect::<Vec<_>>())
}

/// Returns at most `most` of the numbers, evenly spread.
fn thinned(numbers: &[usize], most: usize) -> impl Iterator<Item = usize> {
    numbers.iter().copied().step_by(numbers.len().div_ceil(most).max(1))
}

/// Returns the flux on each [`Side`] that receives any (luminance, W·sr⁻¹), sorted.
fn flux_by_side<'l>(lights: impl IntoIterator<Item = &'l Vpl>, size: f32) -> Vec<(Side, f64)> {
    let of_light =
        |light: &Vpl| (side(light.position, light.direction, size), f64::from(light.intensity.luminance()));
    let mut flux: Vec<(Side, f64)> = lights.into_iter().map(of_light).collect();
    flux.sort_by_key(|(side, _)| *side);
    flux.dedup_by(|next, kept| {
        let is_same = next.0 == kept.0;
        if is_same {
            kept.1 += next.1;
        }
        is_same
    });
    flux
}

fn flux_in(flux: &[(Side, f64)], side: Side) -> f64 {
    flux.binary_search_by_key(&side, |(side, _)| *side).map_or(0.0, |k| flux[k].1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::rng::{Purpose, Stream};
    use crate::vpl::VplKind;

    /// Position of a point light that illuminates a wall evenly.
    const POINT: Vec3 = Vec3::new(2.0, 0.0, 4.0);

    fn photon(position: Vec3, intensity: f32) -> CausticPhoton {
        CausticPhoton {
            light: Vpl {
                position,
                direction: Vec3::Z,
                intensity: Rgb::gray(intensity),
                kind: VplKind::Oriented,
            },
            towards: (POINT - position).normalize(),
            distance: POINT.distance(position),
            chain: 1,
            is_through_panes: false,
        }
    }

    fn on_wall(change: impl Fn(&mut CausticPhoton)) -> Caustics {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let (n, side) = (20_000, 4.0);
        let mut one = || {
            let position = Vec3::new(side * s.uniform(), side * s.uniform() - 2.0, 1.0);
            let mut photon = photon(position, 1.0 / n as f32);
            change(&mut photon);
            photon
        };
        let photons: Vec<CausticPhoton> = (0..n).map(|_| one()).collect();
        let lights: Vec<Vpl> = photons.iter().map(|photon| photon.light).collect();
        Caustics::of(&photons, &lights, Photons::within(&lights, 0.2))
    }

    /// Directions at a place on the wall lead to the point light, and half of a path's directions
    /// are drawn from them where all light is of caustics. No directions are found on the other
    /// side of the wall, from photons of other chains, or for light through panes.
    #[test]
    fn directions_lead_to_where_the_light_is() {
        let mut directions = Directions::default();
        let mut look = |caustics: &Caustics, normal: Vec3| {
            let place = Vec3::new(1.7, 0.1, 1.0);
            directions.clear();
            caustics.look_for_directions(place, normal, &mut directions);
            let drawn = directions.sample([0.4, 0.5, 0.2]);
            (directions.share(), drawn.map(|drawn| drawn.distance((POINT - place).normalize())))
        };
        let (share, distance) = look(&on_wall(|_| {}), Vec3::Z);
        assert!((share - 0.5).abs() < 1e-3 && distance.unwrap() < 2e-3, "{share} {distance:?}");
        assert_eq!(look(&on_wall(|_| {}), Vec3::NEG_Z), (0.0, None));
        assert_eq!(look(&on_wall(|photon| photon.is_through_panes = true), Vec3::Z), (0.0, None));
        let each_its_own =
            |photon: &mut CausticPhoton| photon.chain = photon.light.position.x.to_bits().into();
        assert_eq!(look(&on_wall(each_its_own), Vec3::Z), (0.0, None));
    }
}
