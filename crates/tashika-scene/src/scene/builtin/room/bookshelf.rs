//! A bookshelf with about 250 books of different sizes and colours.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::BOOKSHELF;
use super::FLOOR;
use super::materials::{Palette, glossy};
use crate::color::Rgb;
use crate::error::Result;
use crate::math::elementary::{powf, rotation, sin_cos};
use crate::rng::{Purpose, Stream};
use crate::scene::builtin::shapes::{Ends, Shape, bevelled_box, box_between, grid, lathe, sphere};
use crate::scene::builtin::stage::Stage;

const WIDTH: f32 = 1.5;
const DEEP: f32 = 0.30;
const TALL: f32 = 2.10;
const BOARD: f32 = 0.024;
const SHELVES: usize = 6;

/// Covers of cloth, card and leather: colour, specular share and Phong exponent.
const COVERS: [(Rgb, f32, f32); 9] = [
    (Rgb::new(0.30, 0.04, 0.03), 0.08, 30.0),
    (Rgb::new(0.04, 0.10, 0.22), 0.10, 60.0),
    (Rgb::new(0.05, 0.17, 0.10), 0.06, 20.0),
    (Rgb::new(0.55, 0.36, 0.08), 0.05, 15.0),
    (Rgb::new(0.62, 0.57, 0.46), 0.03, 10.0),
    (Rgb::new(0.05, 0.05, 0.055), 0.15, 120.0),
    (Rgb::new(0.50, 0.17, 0.05), 0.08, 40.0),
    (Rgb::new(0.14, 0.34, 0.36), 0.06, 30.0),
    (Rgb::new(0.24, 0.12, 0.07), 0.12, 80.0),
];

/// Adds the shelf, its books, and three ornaments between them.
pub fn build(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let board =
        |lo: [f32; 3], hi: [f32; 3]| bevelled_box(Vec3::from(lo), Vec3::from(hi), 0.002).at(BOOKSHELF);
    let mut frame = Shape::merged([
        board([0.0, FLOOR, 0.0], [BOARD, TALL, DEEP]),
        board([WIDTH - BOARD, FLOOR, 0.0], [WIDTH, TALL, DEEP]),
        board([BOARD, FLOOR, 0.0], [WIDTH - BOARD, TALL, 0.008]),
    ]);
    let pitch = (TALL - BOARD - 0.07) / SHELVES as f32;
    let floor_of = |k: usize| 0.07 + pitch * k as f32;
    for k in 0..=SHELVES {
        let y = floor_of(k);
        frame.append(board([BOARD, y, 0.008], [WIDTH - BOARD, y + BOARD, DEEP - 0.004]));
    }
    stage.put("bookshelf", palette.paint, frame)?;

    let mut pages = Shape::default();
    let mut covers: [Shape; COVERS.len()] = Default::default();
    let mut stream = Stream::new(0, Purpose::Modelling, 2);
    for k in 0..SHELVES {
        let base = floor_of(k) + BOARD;
        // On every other shelf, the row ends early, to leave a gap for an ornament.
        let end = WIDTH - BOARD - if k % 2 == 1 { 0.30 } else { 0.05 };
        let mut x = BOARD + 0.004;
        while x < end - 0.05 {
            let u = stream.uniform_3();
            let book = Book {
                thick: 0.016 + 0.036 * u[0] * u[0],
                tall: (pitch - BOARD) * (0.62 + 0.30 * u[1]),
                deep: 0.14 + 0.09 * u[2],
            };
            // Books near the end of a row may lean against their neighbours.
            let leans = x > end - 0.16 && stream.uniform() < 0.7;
            let angle = if leans { 0.10 + 0.10 * stream.uniform() } else { 0.0 };
            let (sin, cos) = sin_cos(angle);
            let foot = if leans { book.tall * sin } else { 0.0 };
            let front = DEEP - 0.03 - 0.03 * stream.uniform();
            let place = |shape: Shape| {
                // A leaning book is rotated to the left around its lower left edge.
                let turned = shape.turned(rotation(Vec3::Z, angle));
                turned.at(BOOKSHELF + Vec3::new(x + foot + 0.0005, base + 0.0005, front))
            };
            covers[stream.below(COVERS.len() as u64) as usize].append(place(book.cover()));
            pages.append(place(book.pages()));
            x += foot + book.thick * cos + 0.001;
        }
    }
    stage.put("pages", palette.paper, pages)?;
    for (i, (shape, (color, specular, exponent))) in covers.into_iter().zip(COVERS).enumerate() {
        let name = format!("covers {i}");
        let material = stage.material(&name, glossy(color, specular, exponent))?;
        stage.put(&name, material, shape)?;
    }
    ornaments(stage, palette, |k| BOOKSHELF + Vec3::new(WIDTH - 0.17, floor_of(k) + BOARD, 0.16))
}

/// Size of a book (m) that stands at the origin: spine towards `+z`, thickness along `+x`.
struct Book {
    thick: f32,
    tall: f32,
    deep: f32,
}

impl Book {
    /// Creates two boards and a rounded spine.
    fn cover(&self) -> Shape {
        let Self { thick, tall, deep } = *self;
        const CARD: f32 = 0.0025;
        let board = |x: f32| box_between(Vec3::new(x, 0.0, -deep), Vec3::new(x + CARD, tall, 0.0));
        // Half an ellipse of cloth from one board to the other.
        let half = 0.5 * thick;
        let spine = grid([10, 1], [Ends::Open; 2], |i, j| {
            let (sin, cos) = sin_cos(PI * i as f32 / 10.0);
            Vec3::new(half - half * cos, tall * j as f32, 0.3 * half * sin)
        });
        Shape::merged([board(0.0), board(thick - CARD), spine])
    }

    /// Creates the block of paper, slightly smaller than the cover.
    fn pages(&self) -> Shape {
        let lo = Vec3::new(0.0026, 0.002, 0.004 - self.deep);
        box_between(lo, Vec3::new(self.thick - 0.0026, self.tall - 0.003, -0.001))
    }
}

/// Adds an urn, a ball and a vase in the gaps of shelves 1, 3 and 5.
fn ornaments(stage: &mut Stage, palette: &Palette, place: impl Fn(usize) -> Vec3) -> Result<()> {
    let turned = |scale: [f32; 2], shape: &dyn Fn(f32) -> f32| {
        let mut profile = vec![Vec2::ZERO];
        profile.extend((0..=24).map(|k| {
            let t = k as f32 / 24.0;
            Vec2::new(scale[0] * shape(t), scale[1] * t)
        }));
        profile.insert(1, profile[1]);
        profile.push(profile[profile.len() - 1]);
        profile.push(Vec2::new(0.0, scale[1] - 0.01));
        lathe(&profile, 40)
    };
    let vase = turned([0.07, 0.24], &|t| 0.45 + 0.55 * sin_cos(PI * powf(t, 0.7)).0 * (1.0 - 0.35 * t));
    let urn = turned([0.08, 0.17], &|t| 0.5 + 0.5 * sin_cos(PI * t).0);
    stage.put("urn", palette.black, urn.at(place(1)))?;
    stage.put("ball", palette.brass, sphere(0.075, 48, 24).at(place(3) + Vec3::Y * 0.0755))?;
    stage.put("shelf vase", palette.porcelain, vase.at(place(5)))
}
