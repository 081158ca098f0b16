//! Tightness and cost of the bounds of the material term, as tables in Markdown.
//!
//!     cargo run --release --example bound_tables
//!
//! The gather points of a cluster have the same material and viewer, and normals within a given
//! angle of a common one. Each cluster is bounded against boxes of lights in random directions
//! above it; every second box is near a mirror direction. "tight" is the ratio of the bound to the
//! largest `M` found among pairs of a point of the cluster and a direction of the box, many of
//! which are as close to the mirror direction as the box allows. A row states the median and the
//! ninth decile over clusters and boxes. Times are the minimum of many repetitions, since other
//! load on the machine can only increase them.

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::hint::black_box;
use std::time::Instant;

use tashika::bounds::{Reflector, Towards, UpperAnalytic, UpperConstant, UpperCubeMap, UpperMaterial};
use tashika::bsdf::{Bsdf, Conductor, ConductorFresnel, Lambert, Phong, Plastic};
use tashika::color::Rgb;
use tashika::math::elementary::powf;
use tashika::math::{Aabb, Frame, Vec3};
use tashika::rng::{Purpose, Stream};
use tashika::warp;

/// Clusters of a row, and boxes for each.
const CLUSTERS: usize = 60;
const BOXES: usize = 20;
/// Directions tried for each box.
const MEMBERS: usize = 400;
/// Repetitions of a timed call.
const REPETITIONS: usize = 30;

fn materials() -> Vec<(String, Bsdf)> {
    let (diffuse, specular) = (Rgb::gray(0.3), Rgb::gray(0.4));
    let mut list = vec![("Lambert".to_owned(), Bsdf::Lambert(Lambert { reflectance: diffuse }))];
    for exponent in [10.0, 100.0, 1000.0] {
        list.push((format!("Phong, n = {exponent}"), Bsdf::Phong(Phong { diffuse, specular, exponent })));
    }
    for alpha in [0.3, 0.1, 0.03] {
        let plastic = Plastic { diffuse, specular: Rgb::gray(0.7), ior: 1.5, facets: alpha.into() };
        list.push((format!("Plastic, α = {alpha}"), Bsdf::Plastic(plastic)));
    }
    for alpha in [0.3, 0.1, 0.03] {
        let fresnel = ConductorFresnel::Exact { eta: Rgb::new(0.2, 0.9, 1.1), k: Rgb::new(3.9, 2.4, 2.2) };
        let metal = Conductor { fresnel, specular: Rgb::WHITE, facets: alpha.into() };
        list.push((format!("Metal, α = {alpha}"), Bsdf::Conductor(metal)));
    }
    list
}

/// Points of one material with normals within `spread` (rad) of a common one.
fn cluster(bsdf: Bsdf, size: usize, spread: f32, s: &mut Stream) -> Vec<Reflector> {
    let about = Frame::about(warp::sphere(s.uniform_2()).normalize());
    let viewer = about.to_world(warp::cosine_hemisphere(s.uniform_2())).normalize();
    let mut points = Vec::new();
    while points.len() < size {
        let tilt = warp::sphere(s.uniform_2()) * spread * s.uniform();
        let n = (about.n + tilt).normalize();
        let frame = Frame::about(n);
        let wo = frame.to_local(viewer);
        if wo.z > 0.0 || spread == 0.0 {
            points.push(Reflector {
                bsdf,
                frame,
                wo: Vec3::new(wo.x, wo.y, wo.z.abs()),
                geometric_normal: n,
            });
        }
    }
    points
}

fn mirror(p: &Reflector) -> Vec3 {
    p.frame.to_world(Vec3::new(-p.wo.x, -p.wo.y, p.wo.z))
}

/// Box of difference vectors around a vector of length 1. Each edge is a random share of a common
/// length between 0.002 and 2.
fn vectors(points: &[Reflector], about_mirror: bool, s: &mut Stream) -> Aabb {
    let p = &points[s.below(points.len() as u64) as usize];
    let anywhere = p.frame.to_world(warp::cosine_hemisphere(s.uniform_2()));
    let center = if about_mirror { mirror(p) } else { anywhere };
    let half = Vec3::from(s.uniform_3()) * powf(10.0, -3.0 * s.uniform());
    Aabb { lo: center - half, hi: center + half }
}

/// The largest `M` found in the box.
fn largest(points: &[Reflector], b: &Aabb, s: &mut Stream) -> f32 {
    let mut largest = 0.0_f32;
    for k in 0..MEMBERS {
        let p = &points[k % points.len()];
        let inside = b.lo + Vec3::from(s.uniform_3()) * b.size();
        let aim = mirror(p) + warp::sphere(s.uniform_2()) * powf(10.0, -4.0 * s.uniform());
        let along = b.center().dot(aim) + (s.uniform() - 0.5) * b.diagonal();
        let d = match k / points.len() % 4 {
            0 => inside,
            1 => inside.clamp(b.center(), b.hi),
            _ => (aim * along.max(0.0)).clamp(b.lo, b.hi),
        };
        let wi = p.frame.to_local(d.normalize_or_zero());
        largest = largest.max(p.bsdf.eval_cos(p.wo, wi).max_channel());
    }
    largest
}

/// One bound over the clusters of a row.
struct Column {
    name: &'static str,
    /// By cluster and box.
    upper: Vec<Vec<f32>>,
    build_us: f64,
    query_ns: f64,
}

fn least_ns(calls: usize, mut f: impl FnMut()) -> f64 {
    let once = || {
        let start = Instant::now();
        f();
        start.elapsed().as_secs_f64() * 1e9 / calls as f64
    };
    std::iter::repeat_with(once).take(REPETITIONS).fold(f64::INFINITY, f64::min)
}

fn column<B: UpperMaterial>(
    name: &'static str,
    clusters: &[Vec<Reflector>],
    towards: &[Vec<Towards>],
) -> Column {
    let build = |points: &Vec<Reflector>| {
        let mut bound = B::of_point(&points[0]);
        points[1..].iter().for_each(|p| bound.merge(&B::of_point(p)));
        bound
    };
    let bounds: Vec<B> = clusters.iter().map(build).collect();
    let upper = bounds.iter().zip(towards).map(|(b, t)| t.iter().map(|t| b.upper_material(t)).collect());
    let upper = upper.collect();
    let build_ns = least_ns(CLUSTERS, || {
        for points in clusters {
            black_box(B::of_point(&points[0]));
        }
    });
    let query_ns = least_ns(CLUSTERS * BOXES, || {
        for (b, t) in bounds.iter().zip(towards) {
            for t in t {
                black_box(b.upper_material(t));
            }
        }
    });
    Column { name, upper, build_us: build_ns / 1e3, query_ns }
}

/// The smaller of two bounds, at the cost of both.
fn smaller(name: &'static str, a: &Column, b: &Column) -> Column {
    let pairs = a.upper.iter().flatten().zip(b.upper.iter().flatten());
    let upper = vec![pairs.map(|(a, b)| a.min(*b)).collect()];
    Column { name, upper, build_us: a.build_us + b.build_us, query_ns: a.query_ns + b.query_ns }
}

/// Median and ninth decile of the ratio of bound to largest member, over cases in which the latter
/// is not zero.
fn tightness(column: &Column, largest: &[Vec<f32>]) -> String {
    let mut quotients = Vec::new();
    for (upper, largest) in column.upper.iter().flatten().zip(largest.iter().flatten()) {
        assert!(upper >= largest, "{}: {upper} below {largest}", column.name);
        if *largest > 0.0 {
            quotients.push(f64::from(*upper) / f64::from(*largest));
        }
    }
    quotients.sort_by(f64::total_cmp);
    let at = |share: f64| quotients[((quotients.len() - 1) as f64 * share) as usize];
    let short = |x: f64| if x < 100.0 { format!("{x:.2}") } else { format!("{x:.0}") };
    format!("{} / {}", short(at(0.5)), short(at(0.9)))
}

/// One row of both tables.
fn row(
    size: usize,
    spread: f32,
    about_mirror: bool,
    bsdf: Bsdf,
    s: &mut Stream,
) -> (Vec<Column>, Vec<Vec<f32>>) {
    let clusters: Vec<_> = (0..CLUSTERS).map(|_| cluster(bsdf, size, spread, s)).collect();
    let mut boxes = Vec::new();
    let mut largest_members = Vec::new();
    for points in &clusters {
        let list: Vec<Aabb> = (0..BOXES).map(|_| vectors(points, about_mirror, s)).collect();
        largest_members.push(list.iter().map(|b| largest(points, b, s)).collect());
        boxes.push(list.into_iter().map(Towards::Box).collect::<Vec<_>>());
    }
    let mut columns = vec![
        column::<UpperConstant>("constant", &clusters, &boxes),
        column::<UpperAnalytic>("analytic", &clusters, &boxes),
        column::<UpperCubeMap<4>>("map 4²", &clusters, &boxes),
        column::<UpperCubeMap<8>>("map 8²", &clusters, &boxes),
        column::<UpperCubeMap<16>>("map 16²", &clusters, &boxes),
        column::<UpperCubeMap<8, true>>("folded 8²", &clusters, &boxes),
    ];
    columns.push(smaller("analytic, map 8²", &columns[1], &columns[3]));
    columns.push(smaller("analytic, folded 8²", &columns[1], &columns[5]));
    (columns, largest_members)
}

fn main() {
    let clusters = [
        (1, 0.0, true),
        (1, 0.0, false),
        (16, 0.03, true),
        (16, 0.03, false),
        (16, 0.3, true),
        (16, 0.3, false),
    ];
    let mut costs = Vec::new();
    for (number, (size, spread, about_mirror)) in clusters.into_iter().enumerate() {
        for (name, bsdf) in materials() {
            let mut s = Stream::new(7, Purpose::Test, number as u64);
            let (columns, largest) = row(size, spread, about_mirror, bsdf, &mut s);
            if costs.is_empty() {
                let names: Vec<&str> = columns.iter().map(|c| c.name).collect();
                println!("Bound over largest member, median / ninth decile:\n");
                println!("| points | normals within | lights about | material | {} |", names.join(" | "));
                println!("|{}", "---|".repeat(columns.len() + 4));
                costs.push(format!("| points | material | {} |", names.join(" | ")));
                costs.push(format!("|{}", "---|".repeat(columns.len() + 2)));
            }
            let cells: Vec<String> = columns.iter().map(|c| tightness(c, &largest)).collect();
            let lights = if about_mirror { "mirror" } else { "any" };
            println!("| {size} | {spread} | {lights} | {name} | {} |", cells.join(" | "));
            if about_mirror && spread < 0.1 {
                let cost = columns.iter().map(|c| format!("{:.1} / {:.0}", c.build_us, c.query_ns));
                costs.push(format!("| {size} | {name} | {} |", cost.collect::<Vec<_>>().join(" | ")));
            }
        }
    }
    println!("\nBuilding the bound of one point (µs) / a query (ns):\n\n{}", costs.join("\n"));
}
