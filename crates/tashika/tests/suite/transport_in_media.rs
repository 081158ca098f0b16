//! The default method's estimate of light transport in media and inside glass, against the path
//! tracer, which uses no VPLs. It consists of sums, compensation by paths, and drawn lights in
//! pictures.

use tashika::color::Rgb;
use tashika::integrator::{ControlOptions, Estimator, GuidedLights, LightTransport, Truth};
use tashika::math::Vec3;
use tashika::scene::{Camera, Environment, Material, MediumId, Scattered, SceneBuilder, Surface};
use tashika::vpl::VplOptions;

use crate::cases::{
    add_ceiling_lamp, builder, cuboid, diffuse_walls, film, lambert, luminances, place, room_camera, tracer,
    view,
};
use crate::grid_media;
use crate::light_transport::transport_agrees;
use crate::media::{add, bounding};

fn glass() -> Surface {
    Surface::Glass { ior: 1.5, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets: 0.0.into() }
}

/// A room with a lamp and the objects that `add` places. The camera is in the medium that `add`
/// returns.
fn room_with(add: impl FnOnce(&mut SceneBuilder) -> Option<MediumId>) -> SceneBuilder {
    let mut b = diffuse_walls();
    add_ceiling_lamp(&mut b, 5.0);
    let medium = add(&mut b);
    b.add_camera(Camera { medium, ..room_camera() }).unwrap();
    b
}

/// White milk in glass, under a sky of equal radiance. It is invisible, because VPLs of light paths
/// inside glass contribute `1/η²` of their flux to a viewer outside. Two-sided level 10⁻⁵ for each
/// of 16 pixels.
#[test]
fn white_milk_in_glass_is_invisible_in_a_furnace() {
    let mut b = builder();
    let milk = Some(add(&mut b, [0.0; 3], [3.0; 3], 0.0));
    bounding(&mut b, cuboid(Vec3::splat(-0.5), Vec3::splat(0.5), false), glass(), [milk, None]);
    b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
    b.add_camera(Camera::look_at("c", Vec3::new(0.9, 0.8, 2.0), Vec3::ZERO, Vec3::Y, 0.25)).unwrap();
    let tracer = tracer(b);
    let lights = VplOptions { count: 100_000, ..VplOptions::default() };
    let view = view(tracer.scene(), [4, 4], 64, 3);
    let lights = GuidedLights::trace(&tracer, &lights, Truth::Transport, &view).unwrap();
    let options = ControlOptions { error: 0.02, ..ControlOptions::default() };
    let ours = LightTransport::new(&tracer, &lights, &options).only_by(Estimator::Vpls);
    let film = film(&tracer, &ours, [4, 4], 64, 3);
    let errors = film.plane("standard_error").unwrap().f32_samples().unwrap();
    for (l, e) in luminances(&film).into_iter().zip(errors) {
        let e = f64::from(*e);
        assert!((l - 1.0).abs() < 4.42 * e && e < 0.03, "{l} ± {e}");
    }
}

/// Absorbing glass and absorbing air, with surfaces in both.
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

/// Milk in glass, and smoke behind an invisible boundary; transmittances are drawn.
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
