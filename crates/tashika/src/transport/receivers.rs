//! Many gather points against one light: which of them can receive anything from it.

use glam::Vec3;
use multiversion::multiversion;

use crate::gather::GatherPoint;
use crate::vpl::{Vpl, VplKind};

/// Points judged at once.
const LANES: usize = 16;

/// The geometry of gather points, component by component, in groups of sixteen.
#[derive(Clone, Debug, Default)]
pub struct Receivers {
    groups: Vec<Group>,
}

/// Three coordinates of each lane.
type Vectors = [[f32; LANES]; 3];

#[derive(Clone, Copy, Debug)]
struct Group {
    position: Vectors,
    geometric_normal: Vectors,
    shading_normal: Vectors,
}

impl Receivers {
    /// The geometry of `points`.
    pub fn new(points: &[GatherPoint]) -> Self {
        let groups = points
            .chunks(LANES)
            .map(|chunk| {
                let gathered = |f: fn(&GatherPoint) -> Vec3| {
                    let mut v = [[0.0; LANES]; 3];
                    for (lane, p) in chunk.iter().enumerate() {
                        for (axis, component) in v.iter_mut().enumerate() {
                            component[lane] = f(p)[axis];
                        }
                    }
                    v
                };
                Group {
                    position: gathered(|p| p.position),
                    geometric_normal: gathered(|p| p.geometric_normal),
                    shading_normal: gathered(|p| p.frame.n),
                }
            })
            .collect();
        Self { groups }
    }

    /// Appends the numbers of the points that face `light` and are faced by it, in order. The others
    /// receive nothing, but for what rounding may add at grazing angles.
    pub fn facing(&self, light: &Vpl, out: &mut Vec<u32>) {
        let from = match light.kind {
            VplKind::Directional => {
                Source { position: -light.direction, at_infinity: 1.0, normal: Vec3::ZERO, oriented: false }
            }
            VplKind::Oriented => {
                Source { position: light.position, at_infinity: 0.0, normal: light.direction, oriented: true }
            }
            VplKind::Omni | VplKind::Spot(_) => {
                Source { position: light.position, at_infinity: 0.0, normal: Vec3::ZERO, oriented: false }
            }
        };
        facing(&self.groups, from, out);
    }
}

/// A light as far as facing it goes.
#[derive(Clone, Copy)]
struct Source {
    /// Position, or the direction to the light if it is at infinity.
    position: Vec3,
    /// One at infinity, else zero: the homogeneous coordinate's complement.
    at_infinity: f32,
    normal: Vec3,
    /// Whether it shines to the side of its normal only.
    oriented: bool,
}

/// Component of `d` along the vector of one lane.
#[inline(always)]
fn along(n: &Vectors, lane: usize, d: [f32; 3]) -> f32 {
    n[0][lane] * d[0] + n[1][lane] * d[1] + n[2][lane] * d[2]
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx512bw+avx2", "x86_64+avx2", "x86_64+sse4.2"))]
fn facing(groups: &[Group], from: Source, out: &mut Vec<u32>) {
    let finite = 1.0 - from.at_infinity;
    for (number, g) in groups.iter().enumerate() {
        let mut mask = 0u32;
        for i in 0..LANES {
            let d = [
                from.position.x - finite * g.position[0][i],
                from.position.y - finite * g.position[1][i],
                from.position.z - finite * g.position[2][i],
            ];
            let lit = from.normal.x * d[0] + from.normal.y * d[1] + from.normal.z * d[2];
            let faces = (along(&g.geometric_normal, i, d) > 0.0)
                & (along(&g.shading_normal, i, d) > 0.0)
                & ((lit < 0.0) | !from.oriented);
            // A selection of constants vectorises where a shift by the lane does not.
            mask |= if faces { 1 << i } else { 0 };
        }
        let first = number * LANES;
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            // Lanes beyond the last point have zero normals and never face anything.
            out.push((first + lane) as u32);
        }
    }
}
