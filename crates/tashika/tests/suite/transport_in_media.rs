//! Our estimate of light transport in media and inside glass, against the path tracer, which knows no
//! VPLs: what is summed, what paths put back, and what is drawn for pictures.

use tashika::color::Rgb;
use tashika::math::Vec3;
use tashika::scene::{Camera, Material, MediumId, Scattered, SceneBuilder, Surface};

use crate::cases::{add_ceiling_lamp, cuboid, diffuse_walls, lambert, place, room_camera};
use crate::grid_media;
use crate::light_transport::transport_agrees;
use crate::media::{add, bounding};

fn glass() -> Surface {
    Surface::Glass { ior: 1.5, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets: 0.0.into() }
}

/// A lamp in a room, with what is added, and the camera in the medium that this says.
fn room_with(add: impl FnOnce(&mut SceneBuilder) -> Option<MediumId>) -> SceneBuilder {
    let mut b = diffuse_walls();
    add_ceiling_lamp(&mut b, 5.0);
    let medium = add(&mut b);
    b.add_camera(Camera { medium, ..room_camera() }).unwrap();
    b
}

/// Glass and air that absorb. What light paths leave inside glass is seen as basic radiance, `1/η²` of
/// it.
#[test]
fn glass_and_air_that_absorb_and_surfaces_in_them() {
    let b = room_with(|b| {
        let air = Some(add(b, [0.05, 0.1, 0.2], [0.0; 3], 0.0));
        let tint = Some(add(b, [0.3, 1.0, 2.0], [0.0; 3], 0.0));
        let block = cuboid(Vec3::new(-0.7, 0.1, -0.5), Vec3::new(0.7, 1.2, 0.5), false);
        bounding(b, block, glass(), [tint, air]);
        let inside = cuboid(Vec3::new(-0.5, 0.2, -0.3), Vec3::new(0.5, 0.9, 0.3), false);
        place(b, inside, Material::new("inside", lambert(0.8)));
        air
    });
    transport_agrees(b, 0.02, "what absorbs");
}

#[test]
fn fog_about_the_camera() {
    let b = room_with(|b| Some(add(b, [0.01; 3], [0.05, 0.1, 0.15], 0.4)));
    transport_agrees(b, 0.02, "fog");
}

/// Beyond a boundary that is not seen and in glass; transmittances that are drawn.
#[test]
fn milk_and_smoke_in_the_room() {
    let b = room_with(|b| {
        let milk = Some(add(b, [0.0, 0.1, 0.2], [4.0; 3], 0.3));
        let block = cuboid(Vec3::new(-0.8, 0.2, -0.2), Vec3::new(-0.2, 0.9, 0.5), false);
        bounding(b, block, glass(), [milk, None]);
        let box_ = [Vec3::new(0.1, 0.2, -0.7), Vec3::new(0.8, 1.6, 0.3)];
        let density = grid_media::grid([2, 5, 3], box_, |[x, y, _]| [0.2 + 2.0 * y * y + x; 3]);
        let smoke =
            grid_media::add(b, [[0.1, 0.2, 0.3], [0.8, 0.6, 0.4]], -0.3, Some(density), Scattered::Evenly);
        bounding(b, cuboid(box_[0], box_[1], false), Surface::Boundary, [Some(smoke), None]);
        None
    });
    transport_agrees(b, 0.02, "milk and smoke");
}
