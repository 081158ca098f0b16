//! Mattes of a film: the objects and materials that its pixels show, and the share of each.
//!
//! Mattes are computed after the film, from camera samples of its view, independently of the method
//! that estimated its radiance. All other planes have the same bits, and cost the same work, with
//! and without them. If pixels have gather points, a matte uses the camera samples of these points,
//! so that its edges are those of the picture.
//!
//! # Guarantee
//! The same bits for any number of threads, any window and any share of the tiles. Each share of a
//! pixel is a number of samples divided by the number of all samples. The shares add up to the
//! share of samples that met a surface, at most 1.
//!
//! # Held to this by
//! The tests of `render`; the suite's `mattes`, with an edge in closed form; the program's tests of
//! parts.

use rayon::prelude::*;

use crate::film::{Film, Matte, MatteOf, RenderFilm};
use crate::integrator::Setting;
use crate::scene::{InstanceId, Scene};

/// Adds planes of mattes to a film of this view, of objects and of materials.
///
/// * `samples`: camera samples for each pixel, at least 1.
/// * `ranks`: maximum number of objects, and of materials, that a pixel stores; 1 to
///   [`Matte::MOST_RANKS`].
///
/// Pixels that were not rendered are empty.
///
/// # Panics
/// If the film has such planes.
pub fn add_mattes(setting: &Setting<'_>, film: &mut Film, samples: u32, ranks: u32) {
    let scene = setting.tracer.scene();
    let samples = samples.max(1);
    let of_pixel = 2 * ranks.clamp(1, Matte::MOST_RANKS).next_multiple_of(2) as usize;
    let pixels: Vec<(u32, u32)> = film.window().pixels().collect();
    let mattes = MatteOf::ALL.map(|of| Matte::new(of, names(scene, of)));
    let read = RenderFilm::of(film);
    let [mut objects, mut materials] = [(); 2].map(|()| vec![0.0; pixels.len() * of_pixel]);
    let of_pixels = objects.par_chunks_exact_mut(of_pixel).zip(materials.par_chunks_exact_mut(of_pixel));
    of_pixels.zip(&pixels).enumerate().filter(|(place, _)| read.is_rendered(*place)).for_each(
        |(_, ((objects, materials), &(x, y)))| {
            let of_sample = |index| setting.view.first_instance(setting.tracer, [x, y], index);
            let met: Vec<usize> = (0..samples).filter_map(of_sample).map(InstanceId::index).collect();
            mattes.iter().zip([objects, materials]).for_each(|(matte, to)| matte.rank(&met, samples, to));
        },
    );
    mattes.iter().zip([objects, materials]).for_each(|(matte, ranks)| matte.add_to(film, &ranks));
}

/// Returns the names of the objects, or materials, of a scene's instances.
fn names(scene: &Scene, of: MatteOf) -> impl Iterator<Item = &str> {
    scene.instance_ids().map(move |instance| match of {
        MatteOf::Objects => scene.object_name(instance),
        MatteOf::Materials => scene.material_of(instance).name.as_str(),
    })
}
