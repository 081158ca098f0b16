//! Planes of the first surfaces along camera rays: their motion over the film while the shutter is
//! open, the time at which they are in front, and the transmittance of the media before them.
//!
//! The planes are computed after the film ([`View::motion`](crate::gather::View::motion),
//! [`View::time_in_front`](crate::gather::View::time_in_front),
//! [`View::transmittance`](crate::gather::View::transmittance)), independently of the method that
//! estimated its radiance. All other planes have the same bits with and without them. Pixels that
//! were not rendered are 0.
//!
//! A pixel has the motion of one surface, never a mean, since nothing moves by the mean of two
//! motions. Vectors follow the convention of compositing programs, as in Nuke's layer `forward`:
//! they point right and up, in pixels, from the position when the shutter opens to the position
//! when it closes.
//!
//! # Guarantee
//! The same bits for any number of threads, any window and any share of the tiles. If neither scene
//! nor camera moves, all motion is exactly 0.
//!
//! # Held to this by
//! The suite's `motion_vectors` and `first_surfaces`, by closed forms.

use rayon::prelude::*;

use crate::film::{Film, PlaneSpec, RenderFilm, Samples, planes};
use crate::integrator::Setting;

/// Adds the plane [`planes::MOTION`] to a film of this view.
///
/// # Panics
/// If the film has such a plane.
pub fn add_motion(setting: &Setting<'_>, film: &mut Film) {
    add(film, &planes::MOTION, |pixel| {
        let way = setting.view.motion(setting.tracer, pixel);
        // Adding to 0 avoids −0 where nothing moves.
        [way.x + 0.0, 0.0 - way.y]
    });
}

/// Adds the plane [`planes::TIME`] to a film of this view, from `samples` camera samples a pixel.
///
/// # Panics
/// If the film has such a plane.
pub fn add_time(setting: &Setting<'_>, film: &mut Film, samples: u32) {
    add(film, &planes::TIME, |pixel| {
        [setting.view.time_in_front(setting.tracer, pixel, samples).unwrap_or_default()]
    });
}

/// Adds the plane [`planes::TRANSMITTANCE`] to a film of this view, from `samples` camera samples a
/// pixel.
///
/// # Panics
/// If the film has such a plane.
pub fn add_transmittance(setting: &Setting<'_>, film: &mut Film, samples: u32) {
    add(film, &planes::TRANSMITTANCE, |pixel| {
        setting.view.transmittance(setting.tracer, pixel, samples).to_array()
    });
}

/// Adds a plane with a value for each rendered pixel.
fn add<const N: usize>(film: &mut Film, plane: &PlaneSpec, of_pixel: impl Fn([u32; 2]) -> [f32; N] + Sync) {
    let pixels: Vec<(u32, u32)> = film.window().pixels().collect();
    let read = RenderFilm::of(film);
    let of_place = |(place, &(x, y)): (usize, &(u32, u32))| {
        if read.is_rendered(place) { of_pixel([x, y]) } else { [0.0; N] }
    };
    let samples: Vec<[f32; N]> = pixels.par_iter().enumerate().map(of_place).collect();
    film.add_plane(plane, Samples::F32(samples.into_flattened()));
}
