//! Glare of synthetic fisheye images, by closed forms.

use std::f64::consts::PI;

use super::*;
use crate::color::Rgb;
use crate::film::{PixelRecord, Stop, Window};
use crate::math::elementary::atan2_f64;

/// Film of a square fisheye of 180° whose luminance is a function of the direction (line of sight
/// `−z`); each pixel has a half-width relative to it.
fn film(side: u32, relative: f32, luminance: impl Fn(DVec3) -> f32) -> Film {
    let size = [side, side];
    let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
    for (x, y) in film.window().pixels() {
        let place = [x, y].map(|v| (f64::from(v) + 0.5) / f64::from(side) - 0.5);
        let distance = (place[0] * place[0] + place[1] * place[1]).sqrt();
        let (sin, cos) = sin_cos_f64(PI * distance);
        let scale = if distance > 0.0 { sin / distance } else { 0.0 };
        let value = luminance(DVec3::new(place[0] * scale, -place[1] * scale, -cos));
        PixelRecord {
            radiance: Rgb::gray(value),
            half_width: relative * value,
            claim: Claim::Calibrated,
            stop: Stop::RuleMet,
            ..PixelRecord::default()
        }
        .store(&mut film, x, y);
    }
    film
}

/// Discs: direction, half of the angle across (radians), luminance; on a background.
fn discs(discs: &[(DVec3, f64, f32)], background: f32) -> impl Fn(DVec3) -> f32 {
    move |direction| {
        let inside = discs.iter().find(|(center, radius, _)| direction.dot(*center) > sin_cos_f64(*radius).1);
        inside.map_or(background, |(.., luminance)| *luminance)
    }
}

/// Direction at angles up and to the right of the line of sight (degrees).
fn towards(up: f64, right: f64) -> DVec3 {
    let [(sin_up, cos_up), (sin, cos)] = [up, right].map(|angle| sin_cos_f64(angle.to_radians()));
    DVec3::new(sin * cos_up, sin_up, -cos * cos_up)
}

fn glare(film: &Film) -> Glare {
    Glare::of(film, &GlareOptions::default()).unwrap()
}

/// A uniform field of luminance `L` has `E_v = π L`, no source, and `DGP = 5.87·10⁻⁵ E_v + 0.16`.
/// The rim of the circle is resolved to a pixel, where the cosine is small.
#[test]
fn a_uniform_field_has_its_illuminance() {
    let found = glare(&film(200, 0.0, |_| 1000.0));
    let vertical = found.vertical_illuminance.value;
    assert!((vertical / (1000.0 * PI) - 1.0).abs() < 1e-4, "{vertical}");
    assert!(found.ugr.is_none() && found.sources.is_empty() && found.silent == 0);
    assert!((found.dgp.value - (5.87e-5 * vertical + 0.16)).abs() < 1e-12);
    assert!((found.background.value - vertical / PI).abs() < 1e-9);
    assert!((found.pixels as f64 / (200.0 * 200.0 * PI / 4.0) - 1.0).abs() < 0.01);
}

/// One disc on a uniform background has indices in closed form: `ω = 2π (1 − cos r)`, `p` of its
/// centre, `E_v = π L_b (1 − cos θ sin² r) + π L cos θ sin² r`. A disc of 20° on an image of 500
/// pixels has about 2400 pixels, so that one pixel in seven of its rim is 1 % of its area.
#[test]
fn one_disc_on_a_uniform_background_has_its_indices() {
    let (radius, luminance, background) = (10f64.to_radians(), 20_000.0, 200.0);
    for (up, right) in [(20.0, 0.0), (10.0, 30.0), (-25.0, 10.0)] {
        let center = towards(up, right);
        let found = glare(&film(500, 0.0, discs(&[(center, radius, luminance)], background)));
        let [source] = found.sources[..] else { panic!("{:?}", found.sources) };
        let (sin, cos) = sin_cos_f64(radius);
        let solid_angle = 2.0 * PI * (1.0 - cos);
        assert!((source.solid_angle / solid_angle - 1.0).abs() < 0.01, "{source:?}");
        assert!((source.position_index / position_index(center) - 1.0).abs() < 2e-3, "{source:?}");
        assert!(
            (source.luminance - f64::from(luminance)).abs() < 1e-6 && source.limits == [source.luminance; 2]
        );
        let projected = PI * sin * sin * -center.z;
        let vertical = f64::from(background) * (PI - projected) + f64::from(luminance) * projected;
        let found_vertical = found.vertical_illuminance.value;
        assert!((found_vertical / vertical - 1.0).abs() < 0.01, "{found_vertical} {vertical}");
        let term = f64::from(luminance) * f64::from(luminance) * solid_angle
            / (position_index(center) * position_index(center));
        let indirect = f64::from(background) * (PI - projected) / PI;
        // 1 % of the sum is 0.035 of UGR and 0.0004 of DGP.
        let ugr = 8.0 * log10(0.25 / indirect * term);
        assert!((found.ugr.unwrap().value - ugr).abs() < 0.05, "{found:?} {ugr}");
        let dgp = 5.87e-5 * vertical + 0.0918 * log10(1.0 + term / powf_f64(vertical, 1.87)) + 0.16;
        assert!((found.dgp.value - dgp).abs() < 3e-3, "{} {dgp}", found.dgp.value);
    }
}

/// With all pixels 10 % uncertain, the ends of the intervals are the indices of the images in which
/// sources are 10 % darker and the rest 10 % brighter, and the other way; those of images within
/// the intervals are inside.
#[test]
fn intervals_are_the_worst_of_the_pixels() {
    let of = |source: f32, background: f32, relative: f32| {
        glare(&film(100, relative, discs(&[(towards(15.0, 5.0), 0.1, source)], background)))
    };
    let found = of(30_000.0, 150.0, 0.1);
    let [low, high] = found.ugr.unwrap().interval.unwrap();
    let [darker, brighter] = [of(27_000.0, 165.0, 0.0), of(33_000.0, 135.0, 0.0)];
    assert!((darker.ugr.unwrap().value - low).abs() < 1e-4, "{low}");
    assert!((brighter.ugr.unwrap().value - high).abs() < 1e-4, "{high}");
    let [least, most] = found.vertical_illuminance.interval.unwrap();
    let value = found.vertical_illuminance.value;
    assert!((least / value - 0.9).abs() < 1e-6 && (most / value - 1.1).abs() < 1e-6);
    let [low, high] = found.dgp.interval.unwrap();
    for (source, background) in
        [(27_000.0, 135.0), (27_000.0, 165.0), (33_000.0, 135.0), (33_000.0, 165.0), (3e4, 150.0)]
    {
        let dgp = of(source, background, 0.0).dgp.value;
        assert!(low <= dgp && dgp <= high, "{low} {dgp} {high}");
    }
    assert!(high - low < 0.12, "{low} {high}");
    assert_eq!(of(30_000.0, 150.0, 0.0).dgp.interval, Some([of(30_000.0, 150.0, 0.0).dgp.value; 2]));
}

/// Discs 0.08 rad apart are one source, discs 0.13 rad apart are two, and a peak inside a source is
/// one of its own.
#[test]
fn near_pixels_are_one_source() {
    let pair = |gap: f64| {
        let half = (0.5 * gap + 0.05).to_degrees();
        let both = [(towards(0.0, half), 0.05, 5000.0), (towards(0.0, -half), 0.05, 5000.0)];
        glare(&film(300, 0.0, discs(&both, 10.0))).sources.len()
    };
    assert_eq!((pair(0.08), pair(0.13)), (1, 2));
    let peak = [(towards(0.0, 0.0), 0.03, 60_000.0), (towards(0.0, 0.0), 0.1, 5000.0)];
    let found = glare(&film(300, 0.0, discs(&peak, 10.0))).sources;
    assert!(found.len() == 2 && found[0].luminance > 50_000.0, "{found:?}");
    // A ring is one source whose centre is on the line of sight, where the index is 1.
    let ring = glare(&film(200, 0.0, |direction| {
        let theta = atan2_f64((1.0 - direction.z * direction.z).sqrt(), -direction.z);
        if (0.8..1.0).contains(&theta) { 3000.0 } else { 10.0 }
    }));
    assert!(ring.sources.len() == 1 && ring.sources[0].position_index < 1.05, "{:?}", ring.sources);
}

#[test]
fn images_without_an_interval_or_a_view_are_recognised() {
    let mut image = film(40, 0.1, |_| 500.0);
    let radiance = GlareOptions { photometry: Photometry::Radiance, ..GlareOptions::default() };
    // The half-width of luminance says nothing about Radiance's weights.
    let found = Glare::of(&image, &radiance).unwrap();
    assert!(found.silent == found.pixels && found.dgp.interval.is_none());
    let mut silent = PixelRecord { claim: Claim::None, stop: Stop::Budget, ..PixelRecord::default() };
    silent.store(&mut image, 20, 20);
    let found = glare(&image);
    assert!(
        found.silent == 1 && found.dgp.interval.is_none() && found.vertical_illuminance.interval.is_none()
    );
    silent.radiance = Rgb::gray(f32::NAN);
    silent.store(&mut image, 20, 20);
    let refused = |film: &Film, options: &GlareOptions| Glare::of(film, options).unwrap_err().to_string();
    let default = GlareOptions::default();
    assert!(refused(&image, &default).contains("pixel 20,20 without a finite luminance"));
    let mut image = film(40, 0.1, |_| 500.0);
    image.metadata_mut().set(keys::CAMERA_PROJECTION, "perspective");
    assert!(refused(&image, &default).contains("projection perspective"));
    for angle in [0.0, -5.0, 361.0, f64::NAN] {
        assert!(refused(&image, &GlareOptions { angle: Some(angle), ..default }).contains("angle = "));
    }
    assert!(refused(&image, &GlareOptions { threshold: 0.0, ..default }).contains("threshold = 0"));
    let part = Film::new([8, 8], Window { x: 0, y: 0, width: 8, height: 4 }, PixelRecord::PLANES).unwrap();
    assert!(refused(&part, &default).contains("a part of an image"));
}
