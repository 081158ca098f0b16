//! Images made by formula: wood grain, a woven rug, two paintings.
//!
//! All images are reflectances, or factors on reflectances, so every texel is a colour in `[0, 1]`.

use std::f32::consts::TAU;

use glam::Vec2;

use crate::color::{Rgb, srgb_encode};
use crate::math::elementary::sin_cos;
use crate::rng::{Purpose, Stream};
use crate::scene::{Image, Pixels};

/// Value noise of period 1: uniform numbers on a torus of lattice points, interpolated smoothly.
struct Noise {
    size: [usize; 2],
    lattice: Vec<f32>,
}

impl Noise {
    fn new(seed: u64, size: [usize; 2]) -> Self {
        let mut stream = Stream::new(seed, Purpose::Modelling, 0);
        Self { size, lattice: (0..size[0] * size[1]).map(|_| stream.uniform()).collect() }
    }

    /// Value in `[0, 1)`.
    fn at(&self, uv: Vec2) -> f32 {
        let cell = |c: f32, n: usize| {
            let x = c * n as f32;
            let i = x.floor();
            let t = x - i;
            let i = (i as i64).rem_euclid(n as i64) as usize;
            (i, (i + 1) % n, t * t * (3.0 - 2.0 * t))
        };
        let (x0, x1, s) = cell(uv.x, self.size[0]);
        let (y0, y1, t) = cell(uv.y, self.size[1]);
        let at = |x: usize, y: usize| self.lattice[y * self.size[0] + x];
        let row = |y| at(x0, y) * (1.0 - s) + at(x1, y) * s;
        row(y0) * (1.0 - t) + row(y1) * t
    }
}

/// Creates an image of linear colours, stored with the sRGB curve.
fn image(name: &str, size: [u32; 2], color: impl Fn(Vec2) -> Rgb) -> Image {
    let [width, height] = size;
    let byte = |v: f32| (srgb_encode(v.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
    let texel = |x: u32, y: u32| {
        let uv = Vec2::new((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
        let c = color(uv);
        [byte(c.r), byte(c.g), byte(c.b), 255]
    };
    let pixels =
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
    Image { name: name.into(), width, height, pixels: Pixels::Srgb8(pixels) }
}

/// Creates a grain along `u`: growth bands bent by noise, and fine fibres. Texels are factors from
/// about 0.4 to 1, redder where they are darker.
pub fn wood_grain() -> Image {
    let (bend, fibre) = (Noise::new(1, [3, 8]), Noise::new(2, [16, 96]));
    image("wood grain", [256, 256], |uv| {
        let phase = 7.0 * uv.y + 2.2 * bend.at(uv);
        let band = 0.5 + 0.5 * sin_cos(TAU * phase).0;
        let dark = 0.38 * band * band * band + 0.22 * fibre.at(uv);
        Rgb::new(1.0 - 0.85 * dark, 1.0 - dark, (1.0 - 1.1 * dark).max(0.0))
    })
}

/// Creates the pattern of the whole rug: 4 × 6 diamonds within borders, in three colours.
pub fn rug() -> Image {
    const CREAM: Rgb = Rgb::new(0.64, 0.57, 0.44);
    const NAVY: Rgb = Rgb::new(0.035, 0.07, 0.16);
    const RUST: Rgb = Rgb::new(0.44, 0.12, 0.05);
    let speckle = Noise::new(3, [128, 192]);
    image("rug", [256, 384], |uv| {
        let edge = uv.min(Vec2::ONE - uv) * Vec2::new(1.0, 1.5);
        let border = edge.min_element();
        let diamond = {
            let cell = (uv * Vec2::new(4.0, 6.0)).fract() - 0.5;
            cell.x.abs() + cell.y.abs()
        };
        let color = if border < 0.03 || (0.09..0.105).contains(&border) {
            NAVY
        } else if border < 0.09 {
            if (24.0 * (uv.x + 1.5 * uv.y)).fract() < 0.5 { RUST } else { CREAM }
        } else if diamond < 0.16 {
            RUST
        } else if (0.30..0.37).contains(&diamond) {
            NAVY
        } else {
            CREAM
        };
        color * (0.75 + 0.25 * speckle.at(uv))
    })
}

/// Creates a landscape of hills under a sun, for a wide frame.
pub fn landscape() -> Image {
    let (far, near, brush) = (Noise::new(4, [5, 1]), Noise::new(5, [4, 1]), Noise::new(6, [24, 60]));
    image("landscape", [192, 128], |uv| {
        let hill = |noise: &Noise, base: f32, height: f32| uv.y > base - height * noise.at(uv);
        let sun = (uv - Vec2::new(0.68, 0.30)) * Vec2::new(1.5, 1.0);
        let color = if hill(&near, 0.86, 0.28) {
            Rgb::new(0.05, 0.13, 0.15)
        } else if hill(&far, 0.72, 0.30) {
            Rgb::new(0.12, 0.30, 0.33)
        } else if sun.length() < 0.13 {
            Rgb::new(0.75, 0.36, 0.10)
        } else {
            Rgb::new(0.70, 0.55, 0.38).lerp(Rgb::new(0.62, 0.32, 0.20), uv.y)
        };
        color * (0.85 + 0.15 * brush.at(uv))
    })
}

/// Creates overlapping disks on a pale ground, for a tall frame.
pub fn disks() -> Image {
    const GROUND: Rgb = Rgb::new(0.72, 0.67, 0.57);
    let brush = Noise::new(7, [40, 40]);
    let marks = [
        (Vec2::new(0.40, 0.40), 0.24, Rgb::new(0.05, 0.20, 0.28)),
        (Vec2::new(0.62, 0.62), 0.20, Rgb::new(0.66, 0.40, 0.06)),
        (Vec2::new(0.34, 0.82), 0.11, Rgb::new(0.50, 0.11, 0.06)),
        (Vec2::new(0.68, 0.24), 0.08, Rgb::new(0.04, 0.04, 0.05)),
    ];
    image("disks", [128, 176], |uv| {
        let inside = |center: Vec2, radius: f32| ((uv - center) * Vec2::new(1.0, 1.4)).length() < radius;
        let color = marks.iter().filter(|m| inside(m.0, m.1)).fold(GROUND, |below, m| {
            // Where disks overlap, the upper colour covers most of the lower.
            m.2.lerp(below * m.2, 0.25)
        });
        color * (0.88 + 0.12 * brush.at(uv))
    })
}
