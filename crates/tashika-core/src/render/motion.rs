//! How far what a pixel shows goes on the film while the shutter is open, as a plane.
//!
//! It is made after the film, from one ray a pixel ([`View::motion`](crate::gather::View::motion)),
//! whatever made its radiance: a film without it has the same bits. A pixel has the vector of one
//! surface, never a mean, since a mean of two motions is one that nothing has.
//!
//! Vectors are those of compositing programs: to the right and up, in pixels, from where the shutter
//! opens to where it closes, as Nuke's layer `forward` has them.
//!
//! # Guarantee
//! The same bits for any number of threads, any window and any share of the tiles. Of a scene and a
//! camera that stand all is exactly 0.
//!
//! # Held to this by
//! The suite's `motion_vectors`, by closed forms.

use rayon::prelude::*;

use crate::film::{Film, RenderFilm, Samples, planes};
use crate::integrator::Setting;

/// Adds the plane [`planes::MOTION`] to a film of this view. Pixels that were not rendered are 0.
///
/// # Panics
/// If the film has such a plane.
pub fn add_motion(setting: &Setting<'_>, film: &mut Film) {
    let pixels: Vec<(u32, u32)> = film.window().pixels().collect();
    let read = RenderFilm::of(film);
    let of_pixel = |(place, &(x, y)): (usize, &(u32, u32))| {
        if !read.is_rendered(place) {
            return [0.0; 2];
        }
        let way = setting.view.motion(setting.tracer, [x, y]);
        // Not −0 where nothing moves.
        [way.x + 0.0, 0.0 - way.y]
    };
    let vectors: Vec<[f32; 2]> = pixels.par_iter().enumerate().map(of_pixel).collect();
    film.add_plane(&planes::MOTION, Samples::F32(vectors.into_flattened()));
}
