//! Reduction of large films: of each block of pixels, the least certain one is shown.
//!
//! A mean of pixels has no half-width, claim or stop reason, and hides a single pixel of the block
//! that makes no claim. So a film is made smaller by choosing pixels, not by mixing them: a block
//! is shown as one of its pixels with the complete record of that pixel.
//!
//! Order, least certain first: pixels that claim nothing, then the others by relative half-width,
//! the wider first, and last the pixels that were not rendered. Among equals, and in films that
//! make no claims, the first in reading order is chosen.
//!
//! # Guarantee
//! If rendered pixels of a block claim nothing, one of them is chosen. Choosing in two steps, by
//! factors `a` and then `b`, gives the pixels of one step by `a·b`, up to ties.
//!
//! # Held to this by
//! The tests below.

use crate::film::{Film, RenderFilm, Window};

/// Returns the least certain pixel of each block of `factor × factor` pixels of `part`, block by
/// block in rows, in coordinates of the full image. Blocks at the right and at the bottom may be
/// smaller.
///
/// # Panics
/// If `factor` is zero, or `part` is not inside the film's window.
pub fn least_certain(film: &Film, part: Window, factor: u32) -> Vec<[u32; 2]> {
    assert!(factor > 0, "a block has pixels");
    let (read, window) = (RenderFilm::of(film), film.window());
    let doubt_at = |x, y| doubt(&read, window.index(x, y));
    let mut chosen =
        Vec::with_capacity((part.width.div_ceil(factor) * part.height.div_ceil(factor)) as usize);
    for top in (part.y..part.y + part.height).step_by(factor as usize) {
        for left in (part.x..part.x + part.width).step_by(factor as usize) {
            let block = Window {
                x: left,
                y: top,
                width: factor.min(part.x + part.width - left),
                height: factor.min(part.y + part.height - top),
            };
            let mut pick = ([left, top], doubt_at(left, top));
            for (x, y) in block.pixels().skip(1) {
                let here = doubt_at(x, y);
                if here > pick.1 {
                    pick = ([x, y], here);
                }
            }
            chosen.push(pick.0);
        }
    }
    chosen
}

/// Relative half-width of a pixel; infinite if nothing is claimed, −1 if the pixel was not
/// rendered.
fn doubt(film: &RenderFilm<'_>, pixel: usize) -> f64 {
    if !film.is_rendered(pixel) {
        -1.0
    } else if !film.claim(pixel).is_some() && film.has_claims() {
        f64::INFINITY
    } else {
        // An interval around black is still more certain than no claim.
        film.relative_half_width(pixel).map_or(0.0, |width| width.min(f64::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PlaneSpec, SampleKind, planes};

    const fn spec(name: &'static str, channels: &'static [&'static str], kind: SampleKind) -> PlaneSpec {
        PlaneSpec { name, channels, unit: "1", kind, doc: "" }
    }
    const SPECS: &[PlaneSpec] = &[
        spec("", &["R", "G", "B"], SampleKind::F32),
        spec("half_width", &["Y"], SampleKind::F32),
        spec("claim", &["id"], SampleKind::U32),
        spec("stop", &["id"], SampleKind::U32),
    ];
    const WINDOW: Window = Window { x: 3, y: 1, width: 5, height: 4 };

    /// Gray pixels of radiance 2, all calibrated, with these half-widths.
    fn film(half_width: impl Fn(u32, u32) -> f32) -> Film {
        let mut film = Film::new([10, 10], WINDOW, SPECS).unwrap();
        for (x, y) in WINDOW.pixels() {
            film.plane_mut(planes::RADIANCE).unwrap().set_f32(x, y, &[2.0; 3]);
            film.plane_mut(planes::HALF_WIDTH).unwrap().set_f32(x, y, &[half_width(x, y)]);
            film.plane_mut(planes::CLAIM).unwrap().set_u32(x, y, &[3]);
            film.plane_mut(planes::STOP).unwrap().set_u32(x, y, &[3]);
        }
        film
    }

    #[test]
    fn the_widest_interval_of_each_block_is_shown_and_blocks_cover_the_part() {
        let film = film(|x, y| (x * 7 + y * 5) as f32 % 11.0 + 1.0);
        let chosen = least_certain(&film, WINDOW, 2);
        assert_eq!(chosen.len(), 3 * 2);
        for (i, &[x, y]) in chosen.iter().enumerate() {
            let (left, top) = (3 + 2 * (i as u32 % 3), 1 + 2 * (i as u32 / 3));
            let block = Window { x: left, y: top, width: 2.min(8 - left), height: 2 };
            assert!(block.contains(x, y), "{x},{y} is not in block {i}");
            let width = |x, y| film.plane(planes::HALF_WIDTH).unwrap().f32_at(x, y)[0];
            assert!(block.pixels().all(|(a, b)| width(a, b) <= width(x, y)), "block {i}");
        }
        assert_eq!(least_certain(&film, WINDOW, 1), WINDOW.pixels().map(|(x, y)| [x, y]).collect::<Vec<_>>());
    }

    #[test]
    fn pixels_without_a_claim_are_never_hidden_and_those_not_rendered_always_if_they_can_be() {
        let mut film = film(|_, _| 1e30);
        film.plane_mut(planes::CLAIM).unwrap().set_u32(6, 3, &[0]);
        film.plane_mut(planes::CLAIM).unwrap().set_u32(4, 1, &[0]);
        film.plane_mut(planes::STOP).unwrap().set_u32(4, 1, &[0]);
        assert_eq!(least_certain(&film, WINDOW, 8), [[6, 3]]);
        for (x, y) in WINDOW.pixels().filter(|p| *p != (7, 4)) {
            film.plane_mut(planes::STOP).unwrap().set_u32(x, y, &[0]);
        }
        assert_eq!(least_certain(&film, WINDOW, 8), [[7, 4]], "the only one that was rendered");
    }

    #[test]
    fn films_without_claims_show_the_first_of_each_block() {
        let film = Film::new([10, 10], WINDOW, &SPECS[..1]).unwrap();
        assert_eq!(least_certain(&film, WINDOW, 4), [[3, 1], [7, 1]]);
    }
}
