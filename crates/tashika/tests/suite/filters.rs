//! Pixel filters in images: images of a straight edge, and images without an edge.
//!
//! The radiance is `2 L` left of an edge at `e`, and zero right of it. A pixel of centre `c` is
//! then the filter's step response,
//!
//! ```text
//! 2 L F(e − c)        F the cumulative distribution of the filter along the edge's normal
//! ```
//!
//! This is tested with gather points and with path tracing, on visible lamps and on lit floors. It
//! also holds in pixels at the border of the image, although some of their samples are outside the
//! image.

use std::f64::consts::PI;

use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::film::{Film, Window};
use tashika::gather::{Filter, GatherOptions, View};
use tashika::integrator::{FullSum, Integrator, PathStop, PathTracer};
use tashika::math::Vec3;
use tashika::math::elementary::{erfc, sin_cos_f64};
use tashika::scene::{Camera, Emitter, Environment, Material, Projection};
use tashika::vpl::{Provenance, VplOptions, VplSet};

use crate::cases::{builder, film_of, glowing, lambert, luminances, parallelogram, place, tracer, view};

/// Width and height of the images (pixels). A pixel is a square of 1 m.
const SIDE: u32 = 6;
/// Positions of the edge (pixels from the left, or from the top): in the first pixel, in the middle
/// of the image, and outside the image.
const EDGES: [f32; 3] = [0.3, 2.625, -0.25];
/// Number of gather points a pixel.
const POINTS: u32 = 1024;
/// Number of paths a pixel.
const PATHS: u32 = 2048;

#[derive(Clone, Copy, Debug)]
enum Seen {
    /// A lamp of radiance 2 before the edge, black behind it.
    Lamp,
    /// Floors of reflectance 0.8 before the edge and 0.2 behind it, under a sun of irradiance 5.
    Floor,
}

impl Seen {
    /// Radiance before and behind the edge.
    fn radiances(self) -> [f64; 2] {
        match self {
            Self::Lamp => [2.0, 0.0],
            Self::Floor => [0.8, 0.2].map(|reflectance| reflectance * 5.0 / PI),
        }
    }

    /// The plane z = 0 with an edge at this distance from the left (axis 0) or from the top (axis
    /// 1), seen straight from above.
    fn tracer(self, edge: f32, axis: usize) -> Tracer {
        const FAR: f32 = 50.0;
        let half = 0.5 * SIDE as f32;
        let mut b = builder();
        let materials = match self {
            Self::Lamp => [glowing("lamp", lambert(0.0), 2.0), Material::new("dark", lambert(0.0))],
            Self::Floor => [Material::new("light", lambert(0.8)), Material::new("dark", lambert(0.2))],
        };
        let spans = [(-FAR, edge - half), (edge - half, FAR)];
        for ((from, to), material) in spans.into_iter().zip(materials) {
            let [corner, a, c] = match axis {
                0 => [Vec3::new(from, -FAR, 0.0), Vec3::X * (to - from), Vec3::Y * (2.0 * FAR)],
                _ => [Vec3::new(-FAR, -to, 0.0), Vec3::X * (2.0 * FAR), Vec3::Y * (to - from)],
            };
            place(&mut b, parallelogram(corner, a, c), material);
        }
        if matches!(self, Self::Floor) {
            let (direction, irradiance) = (Vec3::NEG_Z, Rgb::gray(5.0));
            b.add_emitter(Emitter::Directional { direction, irradiance }).unwrap();
        }
        let mut camera = Camera::look_at("above", Vec3::Z * 5.0, Vec3::ZERO, Vec3::Y, 1.0);
        camera.projection = Projection::Orthographic { height: SIDE as f32 };
        b.add_camera(camera).unwrap();
        tracer(b)
    }
}

/// Step response `F` of a filter.
fn cumulative(filter: Filter, x: f64) -> f64 {
    match filter {
        Filter::Box => (x + 0.5).clamp(0.0, 1.0),
        Filter::Tent => {
            let beyond = 0.5 * (1.0 - x.abs().min(1.0)) * (1.0 - x.abs().min(1.0));
            if x < 0.0 { beyond } else { 1.0 - beyond }
        }
        Filter::Gaussian => 0.5 * erfc(-x * std::f64::consts::SQRT_2),
        Filter::BlackmanHarris => {
            let t = (x / 1.5).clamp(-1.0, 1.0);
            let term = |(k, a): (f64, f64)| a * sin_cos_f64(k * PI * t).0 / (k * PI);
            let waves: f64 = [(1.0, 0.488_29), (2.0, 0.141_28), (3.0, 0.011_68)].into_iter().map(term).sum();
            0.5 + (0.358_75 * t + waves) / (2.0 * 0.358_75)
        }
    }
}

/// Largest error of the distribution from which samples of a filter are drawn, as stated in
/// `gather::filter`.
fn drawn_within(filter: Filter) -> f64 {
    if filter == Filter::Gaussian { 5e-4 } else { 1.0 / f64::from(1 << 24) }
}

/// The image with a filter, by any integrator.
fn image(tracer: &Tracer, integrator: &dyn Integrator, filter: Filter, points: u32, seed: u64) -> Film {
    let size = [SIDE; 2];
    let scene = tracer.scene().clone();
    film_of(
        tracer,
        integrator,
        View { gather: GatherOptions { points, filter }, ..view(&scene, size, points, seed) },
    )
}

/// Compares each pixel with its step response; `tolerance` is a function of that response.
fn assert_steps(
    seen: Seen,
    film: &Film,
    filter: Filter,
    edge: f32,
    axis: usize,
    tolerance: impl Fn(f64) -> f64,
) {
    let [before, behind] = seen.radiances();
    for ((x, y), found) in Window::full([SIDE; 2]).pixels().zip(luminances(film)) {
        let centre = f64::from([x, y][axis]) + 0.5;
        let expected = cumulative(filter, f64::from(edge) - centre);
        let share = (found - behind) / (before - behind);
        let off = (share - expected).abs();
        assert!(
            off <= tolerance(expected),
            "{seen:?}, {filter}, edge {edge} of axis {axis}, pixel {x},{y}: {share} for {expected}"
        );
    }
}

/// Set of VPLs of the sun. Empty for a lamp, which is visible itself and lights no visible surface.
fn lights(tracer: &Tracer, seen: Seen) -> VplSet {
    match seen {
        Seen::Lamp => VplSet::new(Vec::new(), Provenance::default()),
        Seen::Floor => {
            let options = VplOptions { count: 4, max_depth: 1, ..VplOptions::default() };
            VplSet::trace(tracer, &options).unwrap()
        }
    }
}

#[test]
fn an_edge_is_the_step_response_of_the_filter_by_gather_points() {
    for seen in [Seen::Lamp, Seen::Floor] {
        for axis in [0, 1] {
            for edge in EDGES {
                let tracer = seen.tracer(edge, axis);
                let set = lights(&tracer, seen);
                for filter in Filter::ALL {
                    let film = image(&tracer, &FullSum::new(&set), filter, POINTS, 11);
                    assert_eq!(film.metadata().text("gather.filter"), Some(filter.name()));
                    // In each coordinate, 2ⁿ points of a scrambled Sobol' sequence have one point
                    // in each of 2ⁿ equal parts. Only the point in the part that the edge cuts may
                    // be on either side; rounding of rays, 10⁻⁶ pixels, may move one more. The last
                    // term allows for rounding of sums.
                    let tolerance = 2.0 / f64::from(POINTS) + drawn_within(filter) + 1e-5;
                    assert_steps(seen, &film, filter, edge, axis, |_| tolerance);
                }
            }
        }
    }
}

#[test]
fn the_path_tracer_has_the_same_filter() {
    for seen in [Seen::Lamp, Seen::Floor] {
        for (axis, edge) in [(0, EDGES[0]), (1, EDGES[1])] {
            let tracer = seen.tracer(edge, axis);
            let path = PathTracer::new(&tracer, PathStop::Count(PATHS), 4).unwrap();
            for filter in Filter::ALL {
                let film = image(&tracer, &path, filter, 1, 12);
                // Bernstein's inequality for shares of independent paths. A pixel fails by chance
                // with a probability below 2·10⁻⁷, the test with 10⁻⁴.
                let level = 16.0;
                let n = f64::from(PATHS);
                let tolerance = |p: f64| {
                    let variance = p * (1.0 - p);
                    (2.0 * variance * level / n).sqrt()
                        + 2.0 * level / (3.0 * n)
                        + drawn_within(filter)
                        + 1e-5
                };
                assert_steps(seen, &film, filter, edge, axis, tolerance);
            }
        }
    }
}

#[test]
fn what_is_the_same_everywhere_stays_so_up_to_the_border() {
    let mut b = builder();
    b.set_environment(Environment::constant(Rgb::new(0.7, 0.5, 0.1))).unwrap();
    b.add_camera(Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 0.9)).unwrap();
    let tracer = tracer(b);
    let set = VplSet::new(Vec::new(), Provenance::default());
    let path = PathTracer::new(&tracer, PathStop::Count(16), 4).unwrap();
    let exact = FullSum::new(&set);
    for filter in Filter::ALL {
        for integrator in [&exact as &dyn Integrator, &path] {
            let film = image(&tracer, integrator, filter, 16, 13);
            for color in film.colors().unwrap() {
                // The tolerance allows for rounding of each of the sixteen terms of a sum. Their
                // weights are powers of two.
                let off = (color - Rgb::new(0.7, 0.5, 0.1)).to_array().map(f32::abs);
                assert!(
                    off.iter().all(|e| *e <= 16.0 * f32::EPSILON),
                    "{filter}, {}: {color:?}",
                    integrator.name()
                );
            }
        }
    }
}
