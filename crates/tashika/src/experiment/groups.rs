//! Pixels in groups, so that the average of all pixels cannot hide a group with bad results.
//!
//! | by | groups |
//! |---|---|
//! | brightness | quarters of the pixels, by the luminance of their exact sums; black ones apart |
//! | material | surfaces of a pixel's gather points: diffuse, others, both, or none |
//!
//! # Held to this by
//! `experiment::tests`.

use std::fmt;

use crate::bsdf::Bsdf;
use crate::film::{Film, Plane, RenderFilm, Stop, planes};
use crate::integrator::Setting;

/// Property by which pixels are grouped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Grouping {
    /// Luminance of their exact sums.
    Brightness,
    /// Materials of their gather points.
    Material,
}

impl Grouping {
    /// All groupings, by brightness and by material.
    pub const ALL: [Self; 2] = [Self::Brightness, Self::Material];
}

impl fmt::Display for Grouping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Brightness => "brightness",
            Self::Material => "material",
        })
    }
}

/// Some of the pixels, with a common property.
#[derive(Clone, Debug)]
pub struct Group {
    /// Name of the common property.
    pub name: &'static str,
    /// Number of pixels in the group.
    pub pixels: u64,
    /// Film of the exact sums of these pixels; all other pixels are marked as not rendered.
    pub reference: Film,
}

impl Grouping {
    /// Returns the non-empty groups of the pixels of a reference, in order.
    ///
    /// # Panics
    /// If the film is not of [`render`](crate::render).
    pub fn groups(self, reference: &Film, setting: &Setting<'_>) -> Vec<Group> {
        let read = RenderFilm::of(reference);
        let pixels = reference.window().pixels().enumerate();
        let held: Vec<[u32; 2]> =
            pixels.filter(|(pixel, _)| read.is_rendered(*pixel)).map(|(_, (x, y))| [x, y]).collect();
        let (names, classes): (&[&str], Vec<usize>) = match self {
            Self::Brightness => (BRIGHTNESS, by_brightness(reference, &held)),
            Self::Material => (MATERIAL, held.iter().map(|pixel| material(setting, *pixel)).collect()),
        };
        let group = |(class, name): (usize, &&'static str)| {
            let members: Vec<[u32; 2]> =
                held.iter().zip(&classes).filter(|(_, of)| **of == class).map(|(pixel, _)| *pixel).collect();
            (!members.is_empty()).then(|| Group {
                name,
                pixels: members.len() as u64,
                reference: only(reference, &members),
            })
        };
        names.iter().enumerate().filter_map(group).collect()
    }
}

const BRIGHTNESS: &[&str] =
    &["black", "darkest quarter", "darker quarter", "brighter quarter", "brightest quarter"];
const MATERIAL: &[&str] = &["nothing", "diffuse", "glossy", "diffuse and glossy"];

/// Returns the reference with all other pixels marked as not rendered.
fn only(reference: &Film, members: &[[u32; 2]]) -> Film {
    let mut film = reference.clone();
    let all: Vec<(u32, u32)> = film.window().pixels().collect();
    let stop = film.plane_mut(planes::STOP).expect("a film of `render`");
    let kept: Vec<u32> = members.iter().map(|&[x, y]| stop.u32_at(x, y)[0]).collect();
    for (x, y) in all {
        stop.set_u32(x, y, &[Stop::NotRendered.id()]);
    }
    for (&[x, y], kept) in members.iter().zip(kept) {
        stop.set_u32(x, y, &[kept]);
    }
    film
}

fn by_brightness(reference: &Film, held: &[[u32; 2]]) -> Vec<usize> {
    let color: &Plane = &reference.planes()[0];
    let luminance = |&[x, y]: &[u32; 2]| {
        let c = color.f32_at(x, y);
        crate::color::Rgb::new(c[0], c[1], c[2]).luminance()
    };
    let luminances: Vec<f32> = held.iter().map(luminance).collect();
    let mut sorted: Vec<f32> = luminances.iter().copied().filter(|l| *l > 0.0).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let class = |l: f32| {
        if l > 0.0 {
            // Pixels of equal luminance get into the same group.
            1 + sorted.partition_point(|other| *other < l) * 4 / sorted.len()
        } else {
            0
        }
    };
    luminances.into_iter().map(class).collect()
}

fn material(setting: &Setting<'_>, pixel: [u32; 2]) -> usize {
    let points = setting.view.pixel(setting.tracer, pixel).points;
    let diffuse = points.iter().filter(|point| matches!(point.bsdf, Bsdf::Lambert(_))).count();
    match (diffuse, points.len() - diffuse) {
        (0, 0) => 0,
        (_, 0) => 1,
        (0, _) => 2,
        _ => 3,
    }
}
