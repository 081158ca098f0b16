//! Savings and errors of mip levels for textures that are far away.
//!
//!     cargo bench -p tashika-bench --bench texture_filtering
//!
//! The scene is a floor of a repeated picture, seen from eye height at a grazing angle. For each
//! pixel, `T` is the mean of the picture over 4096 camera samples with point lookups: the true
//! value of the pixel. Means over few gather points are compared with `T`, with point lookups and
//! with mip levels (trilinear, box-filtered; Williams 1983). The level is chosen by the size of a
//! footprint on the floor, in texels:
//!
//! ```text
//! distance · angle of a pixel · texels a metre · (1, 1/√cos or 1/cos)      [ / √n ]
//! ```
//!
//! The three factors in parentheses give the footprint's width, the square root of its area, and
//! its length. `/ √n` divides the footprint among `n` points. Errors are root mean squares over
//! pixels, relative to the mean of the picture, by distance. *Change* is the error of the mean of
//! filtered lookups over all 4096 samples, which more gather points do not reduce.

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::error::Error;
use std::sync::Arc;

use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::error::Location;
use tashika::gather::{GatherOptions, View};
use tashika::math::elementary::ln;
use tashika::math::{Affine3A, Vec2, Vec3};
use tashika::scene::{Camera, Image, Material, MeshData, Pixels, SceneBuilder, Surface, Wrap};

/// Columns and rows of the image.
const SIZE: [u32; 2] = [96, 96];
/// Vertical field of view (rad).
const FIELD: f32 = 0.7;
/// Height of the eye above the floor (m).
const HEIGHT: f32 = 1.6;
/// Texels a side of the picture, which covers a square metre.
const SIDE: u32 = 64;
/// Camera samples a pixel for the truth.
const TRUTH: u32 = 4096;
/// Ranges of distance (m) by which pixels are sorted.
const BANDS: [[f32; 2]; 5] = [[2.0, 4.0], [4.0, 8.0], [8.0, 16.0], [16.0, 32.0], [32.0, 64.0]];
const POINTS: [u32; 3] = [4, 16, 64];

/// Mip levels, the largest first, each half as wide as the one before.
struct Pyramid(Vec<Image>);

impl Pyramid {
    fn of(value: impl Fn(u32, u32) -> f32) -> Self {
        let image = |side: u32, texels: Vec<f32>| Image {
            name: "level".into(),
            width: side,
            height: side,
            pixels: Pixels::Float(texels.into_iter().map(|v| [v; 3]).collect()),
        };
        let mut levels = vec![image(SIDE, (0..SIDE * SIDE).map(|i| value(i % SIDE, i / SIDE)).collect())];
        while let Some(last) = levels.last().filter(|level| level.width > 1) {
            let side = last.width / 2;
            let mean = |i: u32| {
                let corners = [[0, 0], [1, 0], [0, 1], [1, 1]];
                let of = |[x, y]: [u32; 2]| last.texel(2 * (i % side) + x, 2 * (i / side) + y).0.r;
                corners.map(of).iter().sum::<f32>() / 4.0
            };
            let level = image(side, (0..side * side).map(mean).collect());
            levels.push(level);
        }
        Self(levels)
    }

    fn at_point(&self, uv: Vec2) -> f32 {
        self.0[0].bilinear(uv, [Wrap::Repeat; 2]).0.r
    }

    /// Interpolates between the two levels around a footprint of `footprint` texels.
    fn filtered(&self, uv: Vec2, footprint: f32) -> f32 {
        let level = (ln(footprint.max(1.0)) / std::f32::consts::LN_2).min((self.0.len() - 1) as f32);
        let (fine, share) = (level as usize, level.fract());
        let of = |level: usize| self.0[level.min(self.0.len() - 1)].bilinear(uv, [Wrap::Repeat; 2]).0.r;
        of(fine) * (1.0 - share) + of(fine + 1) * share
    }
}

/// A hit of the floor: texture coordinates, and width and length of a pixel's footprint in texels.
struct Seen {
    uv: Vec2,
    width: f32,
    length: f32,
}

/// Sums of squares over the pixels of one band.
#[derive(Default)]
struct Band {
    pixels: u32,
    deviation: f64,
    /// Squared errors of means over few points, by point lookups.
    points: [f64; 3],
    /// For each footprint: squared change of the mean, then squared errors of means over few
    /// points.
    filtered: [[f64; 4]; 5],
}

fn main() -> Result<(), Box<dyn Error>> {
    let checks = Pyramid::of(|x, y| f32::from(u8::from((x / 8 + y / 8) % 2 == 0)) * 0.8 + 0.1);
    // Cells with hashed values: a picture that does not repeat within the metre and has the range
    // of the checks.
    let gravel = Pyramid::of(|x, y| {
        let mut z = (u64::from(y / 2) << 32 | u64::from(x / 2)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        0.1 + 0.8 * ((z >> 40) as f32 / (1 << 24) as f32)
    });
    for (name, picture) in [("checks of 12.5 cm", checks), ("gravel of 3 cm", gravel)] {
        measure(name, &picture)?;
    }
    Ok(())
}

fn measure(name: &str, picture: &Pyramid) -> Result<(), Box<dyn Error>> {
    let mut builder = SceneBuilder::new("floor", Location::default());
    let grey = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
    let material = builder.add_material(Material::new("floor", grey))?;
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let positions = corners.map(|[x, z]: [f32; 2]| Vec3::new(500.0 * x, 0.0, 500.0 * z)).to_vec();
    let mesh = MeshData { positions, triangles: vec![[0, 2, 1], [0, 3, 2]], ..MeshData::default() };
    let mesh = builder.add_mesh(mesh, material)?;
    builder.add_instance(mesh, Affine3A::IDENTITY)?;
    // Turned a little, so that the checks are not aligned with the columns of pixels.
    let (eye, target) = (Vec3::new(0.3, HEIGHT, 0.2), Vec3::new(2.0, HEIGHT - 1.8, -8.0));
    builder.add_camera(Camera::look_at("eye", eye, target, Vec3::Y, FIELD))?;
    let tracer = Tracer::new(Arc::new(builder.build()?));
    let gather = GatherOptions { points: TRUTH, ..GatherOptions::default() };
    let view = View { camera: &tracer.scene().cameras()[0], size: SIZE, gather, seed: 1 };
    let angle = FIELD / SIZE[1] as f32;
    let seen = |points: u32, pixel: [u32; 2]| -> Vec<Seen> {
        let sum = View { gather: GatherOptions { points, ..gather }, ..view }.pixel(&tracer, pixel);
        let hit = |p: Vec3| {
            let distance = p.distance(eye);
            let width = distance * angle * SIDE as f32;
            Seen { uv: Vec2::new(p.x, p.z), width, length: width * distance / HEIGHT }
        };
        sum.points.iter().map(|point| hit(point.position)).collect()
    };
    let mean = |seen: &[Seen], value: &dyn Fn(&Seen) -> f32| {
        seen.iter().map(|s| f64::from(value(s))).sum::<f64>() / seen.len() as f64
    };
    let mut bands: [Band; 5] = Default::default();
    for pixel in (0..SIZE[0] * SIZE[1]).map(|i| [i % SIZE[0], i / SIZE[0]]) {
        let all = seen(TRUTH, pixel);
        if all.len() < TRUTH as usize {
            continue;
        }
        let distance = mean(&all, &|s| s.width) as f32 / (angle * SIDE as f32);
        let Some(band) = BANDS.iter().position(|[near, far]| (near..far).contains(&&distance)) else {
            continue;
        };
        let band = &mut bands[band];
        let at_point = |s: &Seen| picture.at_point(s.uv);
        let truth = mean(&all, &at_point);
        band.pixels += 1;
        band.deviation += mean(&all, &|s| (at_point(s) - truth as f32).powi(2));
        let few = POINTS.map(|points| seen(points, pixel));
        for (sum, few) in band.points.iter_mut().zip(&few) {
            *sum += (mean(few, &at_point) - truth).powi(2);
        }
        for (way, sums) in band.filtered.iter_mut().enumerate() {
            let value = |s: &Seen, points: u32| {
                let area = (s.width * s.length).sqrt();
                let footprint = match way {
                    0 => s.length,
                    1 => area,
                    2 => s.width,
                    3 => area / (points as f32).sqrt(),
                    _ => s.width / (points as f32).sqrt(),
                };
                picture.filtered(s.uv, footprint)
            };
            // For footprints with `/ √n`, the change is measured at `n` = 16.
            sums[0] += (mean(&all, &|s| value(s, 16)) - truth).powi(2);
            for ((sum, few), points) in sums[1..].iter_mut().zip(&few).zip(POINTS) {
                *sum += (mean(few, &|s| value(s, points)) - truth).powi(2);
            }
        }
    }
    println!("\n{name}, mean 0.5; root mean squares in % of it\n");
    println!("| distance (m) | pixels | σ of points | way | change | error, 4 points | 16 | 64 |");
    println!("|---|---:|---:|---|---:|---:|---:|---:|");
    for ([near, far], band) in BANDS.iter().zip(&bands) {
        let percent = |sum: f64| 100.0 * (sum / f64::from(band.pixels)).sqrt() / 0.5;
        let row = |way: &str, change: String, errors: &[f64]| {
            let errors: Vec<String> = errors.iter().map(|e| format!("{:.1}", percent(*e))).collect();
            let (pixels, deviation) = (band.pixels, percent(band.deviation));
            println!(
                "| {near} to {far} | {pixels} | {deviation:.0} | {way} | {change} | {} |",
                errors.join(" | ")
            );
        };
        row("points", "0".into(), &band.points);
        let ways = ["length", "root of area", "width", "root of area / √n", "width / √n"];
        for (way, sums) in ways.iter().zip(&band.filtered) {
            row(way, format!("{:.1}", percent(sums[0])), &sums[1..]);
        }
    }
    Ok(())
}
