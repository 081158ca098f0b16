//! Tests of trees over random and over degenerate input.

mod drawing;
mod gather;
mod quality;
mod trees;

use super::LightTreeBuilder;
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::math::Vec3;
use crate::rng::{Purpose, Stream};
use crate::scene::{Falloff, FalloffShape};
use crate::vpl::{Provenance, Vpl, VplKind, VplSet};
use crate::warp;

const BUILDERS: [LightTreeBuilder; 2] = [LightTreeBuilder::TopDown, LightTreeBuilder::Agglomerative];

fn set(lights: Vec<Vpl>) -> VplSet {
    VplSet::new(lights, Provenance::default())
}

fn oriented(position: Vec3, direction: Vec3, intensity: f32) -> Vpl {
    Vpl { position, direction, intensity: Rgb::gray(intensity), kind: VplKind::Oriented }
}

fn point(s: &mut Stream) -> Vec3 {
    Vec3::from(s.uniform_3())
}

/// `n` lights of all kinds in a cube of 1 m; intensities span six orders of magnitude.
fn mixed(n: usize, seed: u64) -> Vec<Vpl> {
    let mut s = Stream::new(seed, Purpose::Test, n as u64);
    let falloff = |cos_outer| Falloff { cos_inner: 0.9, cos_outer, shape: FalloffShape::Smoothstep };
    (0..n)
        .map(|_| {
            let (position, direction) = (point(&mut s), warp::sphere(s.uniform_2()));
            let dim = [1.0, 1e-2, 1e-4, 1e-6][s.below(4) as usize];
            let intensity = Rgb::from(s.uniform_3()).map(|c| (c + 0.01) * dim);
            match s.below(8) {
                0 => Vpl { position, direction: Vec3::ZERO, intensity, kind: VplKind::Omni },
                1 => Vpl { position, direction, intensity, kind: VplKind::Spot(falloff(0.8 * s.uniform())) },
                2 => Vpl { position: Vec3::ZERO, direction, intensity, kind: VplKind::Directional },
                3 => {
                    let phase = HenyeyGreenstein { asymmetry: [0.6, 0.0, -0.4][s.below(3) as usize] };
                    Vpl { position, direction, intensity, kind: VplKind::Volume(phase) }
                }
                _ => Vpl { position, direction, intensity, kind: VplKind::Oriented },
            }
        })
        .collect()
}

/// `n` lights on the walls of a room of 4 m × 3 m × 5 m, facing inwards.
fn room(n: usize, seed: u64) -> Vec<Vpl> {
    let mut s = Stream::new(seed, Purpose::Test, n as u64);
    let size = Vec3::new(4.0, 3.0, 5.0);
    (0..n)
        .map(|_| {
            let mut position = point(&mut s) * size;
            let axis = s.below(3) as usize;
            let far = s.below(2) == 1;
            position[axis] = if far { size[axis] } else { 0.0 };
            let mut normal = Vec3::ZERO;
            normal[axis] = if far { -1.0 } else { 1.0 };
            oriented(position, normal, 0.1 + s.uniform())
        })
        .collect()
}
