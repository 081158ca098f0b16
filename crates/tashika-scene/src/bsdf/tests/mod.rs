//! Tests of every property for every case.
//!
//! [`cases::all`] lists the BSDFs: each variant at the corners of its parameters, and a random
//! sweep. [`OUTGOING`] lists the directions of incidence. A new variant is added by lines in
//! `cases.rs`. Random numbers come from fixed streams; each test states its level.

mod cases;
mod energy;
mod limits;
mod quadrature;
mod rough_glass;
mod sampling;
mod textbook;

use crate::math::Vec3;
use crate::math::elementary::sin_cos;
use crate::rng::{Purpose, Stream};

/// Cosines of `ω_o`, from normal to grazing.
const OUTGOING: [f32; 5] = [1.0, 0.8, 0.5, 0.1, 0.01];

/// Direction of cosine `cos` at an azimuth away from the axes.
fn outgoing(cos: f32) -> Vec3 {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (sin_phi, cos_phi) = sin_cos(0.8);
    Vec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// Stream number `index` of the tests of BSDFs.
fn stream(index: u64) -> Stream {
    Stream::new(0xb5df, Purpose::Test, index)
}

/// Uniform direction of the upper hemisphere.
fn direction_above(stream: &mut Stream) -> Vec3 {
    let v = crate::warp::sphere(stream.uniform_2());
    Vec3::new(v.x, v.y, v.z.abs())
}
