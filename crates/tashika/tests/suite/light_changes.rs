//! Lights that a user adds to a scene, or that replace the scene's lights.

use std::fs;
use std::path::Path;

use tashika::color::Rgb;
use tashika::error::Location;
use tashika::io::{AskedEnvironment, AskedLight, LightChanges, LoadOptions};
use tashika::math::Vec3;
use tashika::scene::{Emitter, Environment, Material, Scene, builtin};

use crate::cases::{add_ceiling_lamp, builder, cuboid, diffuse_room, lambert, place};

fn asked(environment: Option<&str>, lights: &[&str]) -> LightChanges {
    LightChanges {
        environment: environment.map(|text| text.parse().unwrap()),
        lights: lights.iter().map(|text| text.parse().unwrap()).collect(),
    }
}

fn lit(scene: Scene, environment: Option<&str>, lights: &[&str]) -> Scene {
    asked(environment, lights).apply(scene, &LoadOptions::default()).unwrap()
}

/// A block without light.
fn dark() -> Scene {
    let mut b = builder();
    place(&mut b, cuboid(Vec3::ZERO, Vec3::ONE, false), Material::new("m", lambert(0.5)));
    b.build().unwrap()
}

/// A map of 8 × 4 texels. One texel is bright: second row, seventh column, which is east and up.
fn write_map(folder: &Path) -> String {
    let mut bytes = b"PF\n8 4\n-1.0\n".to_vec();
    for y in (0..4).rev() {
        for x in 0..8 {
            let value: f32 = if (x, y) == (6, 1) { 5.0 } else { 0.0 };
            bytes.extend([value; 3].iter().flat_map(|v| v.to_le_bytes()));
        }
    }
    let path = folder.join("map, of a=sky.pfm");
    fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().to_owned()
}

fn brightest(environment: &Environment) -> (Vec3, f32) {
    let directions = (0..200 * 400).map(|i| {
        let (polar, azimuth) = ((i / 400) as f32 * 0.0157, (i % 400) as f32 * 0.0157);
        let [(sin, cos), (east, north)] = [polar, azimuth].map(tashika::math::elementary::sin_cos);
        Vec3::new(sin * east, cos, sin * north)
    });
    let of = |d: Vec3| (d, environment.radiance(d).g);
    directions.map(of).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

#[test]
fn an_environment_takes_the_place_of_the_scenes_and_is_turned_and_scaled() {
    let folder = tempfile::tempdir().unwrap();
    let map = write_map(folder.path());
    // The texel is centred at u = 13/16, which is a sixteenth of a turn from east towards south,
    // and 3/8 of the way down.
    let across = (22.5f32).to_radians();
    let (sin, cos) = tashika::math::elementary::sin_cos(across);
    let up = tashika::math::elementary::sin_cos(67.5f32.to_radians());
    let flat = up.0;
    for (options, direction, scale) in [
        ("", [cos * flat, up.1, sin * flat], 5.0),
        // A quarter turn counterclockwise as seen from above takes east to north, which is −z.
        (",scale=2,rotate=90", [sin * flat, up.1, -cos * flat], 10.0),
        (",up=z", [cos * flat, -sin * flat, up.1], 5.0),
        (",up=z,rotate=90", [sin * flat, cos * flat, up.1], 5.0),
    ] {
        let mut b = diffuse_room();
        b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
        add_ceiling_lamp(&mut b, 1.0);
        let scene = lit(b.build().unwrap(), Some(&format!("{map}{options}")), &[]);
        let (found, value) = brightest(scene.environment().unwrap());
        assert!((found - Vec3::from(direction)).length() < 0.03, "{options}: {found}, {direction:?}");
        assert!((value / scale - 1.0).abs() < 0.02, "{options}: {value}");
        assert!(scene.area_emitters().count() == 1 && scene.emitters().is_empty());
        let said = options.replace(",up=z,rotate=90", ",rotate=90,up=z");
        assert_eq!(scene.changes(), [format!("environment map, of a=sky.pfm{said}")]);
    }
}

#[test]
fn suns_and_lamps_are_beside_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let ies = folder.path().join("a@b.ies");
    fs::write(&ies, "TILT=NONE\n1 -1 1 3 1 1 2 0 0 0 1 1 50\n0 60 90\n0\n10 10 0\n").unwrap();
    let lamp = format!("ies:{}@1,2,3,scale=3", ies.display());
    let own = builtin::room();
    let count = own.emitters().len();
    let scene = lit(own, None, &["sun:elevation=30,azimuth=90,scale=2", "point:1,2,-3,100", &lamp]);
    let [sun, point, lamp] = &scene.emitters()[count..] else { panic!("{:?}", scene.emitters()) };
    let Emitter::Directional { direction, irradiance } = sun else { panic!("{sun:?}") };
    // The light comes from the east, 30° high.
    assert!((*direction - Vec3::new(-0.75f32.sqrt(), -0.5, 0.0)).length() < 1e-5, "{direction}");
    let Emitter::Point { position, intensity } = point else { panic!("{point:?}") };
    assert!(*position == Vec3::new(1.0, 2.0, -3.0) && (intensity.g - 7.957_747).abs() < 1e-4);
    let Emitter::Image { position, intensity, beam, .. } = lamp else { panic!("{lamp:?}") };
    let map = &scene.intensity_maps()[beam.map as usize];
    assert_eq!(*position, Vec3::new(1.0, 2.0, 3.0));
    assert!((*intensity * map.relative(Vec3::NEG_Y)).g == 30.0 && map.relative(Vec3::Y).is_black());
    let plain = lit(builtin::room(), None, &["sun:elevation=30,azimuth=180,up=z"]);
    let Emitter::Directional { direction, irradiance: half } = plain.emitters()[count] else { panic!() };
    // The light comes from the south, which is −y if z is up.
    assert!((direction - Vec3::new(0.0, 0.75f32.sqrt(), -0.5)).length() < 1e-5, "{direction}");
    assert!((irradiance.r / half.r - 2.0).abs() < 1e-6);
}

/// A scene without light gets a default sky and sun only if no light is requested.
#[test]
fn a_scene_without_light_is_dark_until_it_is_shown() {
    let shown = |scene: Scene| scene.with_default_light(Location::default());
    assert!(!dark().has_light() && dark().environment().is_none() && dark().emitters().is_empty());
    let own = shown(dark());
    assert!(own.has_default_light() && own.environment().is_some() && own.emitters().len() == 1);
    let scene = shown(lit(dark(), None, &["sun:elevation=30,azimuth=90"]));
    assert!(!scene.has_default_light() && scene.environment().is_none() && scene.emitters().len() == 1);
    assert!(scene.notes().iter().all(|note| !note.message.contains("no light")));
    let scene = shown(lit(dark(), Some("sky:elevation=50,azimuth=10"), &[]));
    assert!(scene.emitters().is_empty() && scene.environment().unwrap().resolution().is_some());
    let count = builtin::tiny().emitters().len();
    let own = shown(builtin::tiny());
    assert!(!own.has_default_light() && own.environment().is_none() && own.emitters().len() == count);
}

/// Every change of the lights changes the digest by which parts of a picture are matched; the
/// folder of a file does not.
#[test]
fn other_light_is_another_scene() {
    let [a, b] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let [map, elsewhere] = [&a, &b].map(|folder| write_map(folder.path()));
    let digest = |environment: Option<&str>, lights: &[&str]| {
        let scene = lit(builtin::tiny(), environment, lights);
        (scene.digest(), scene.changes().to_vec())
    };
    let first = digest(Some(&map), &["point:1,2,3,4"]);
    assert_eq!(first, digest(Some(&elsewhere), &["point:1,2,3,4"]));
    let turned = format!("{map},rotate=1");
    let others = [
        digest(None, &[]),
        digest(Some(&map), &[]),
        digest(Some(&map), &["point:1,2,3,5"]),
        digest(Some(&turned), &["point:1,2,3,4"]),
    ];
    assert!(others.iter().all(|other| other.0 != first.0));
    assert_eq!(others[0].0, None, "nothing asked for, nothing changed");
    let mut bytes = fs::read(&map).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&map, bytes).unwrap();
    assert_ne!(digest(Some(&map), &["point:1,2,3,4"]).0, first.0);
}

#[test]
fn what_cannot_be_is_refused_with_what_can() {
    for (text, why) in [
        ("", "no file"),
        ("a.hdr,scale=-1", "scale from 0"),
        ("a.hdr,scale=nan", "no number"),
        ("a.hdr,up=x", "up is y or z"),
        ("a.hdr,azimuth=3", "azimuth is no option here"),
        ("a.hdr,scale=1,scale=2", "scale twice"),
        ("sky:azimuth=1", "no elevation"),
        ("sky:elevation=91,azimuth=1", "elevation from 0 to 90"),
        ("sky:elevation=9,azimuth=1,rotate=4", "rotate is no option here"),
        ("cie:17", "no type from 1 to 16"),
        ("cie:cloudy", "no type from 1 to 16"),
        ("cie:clear", "no elevation"),
        ("cie:overcast,elevation=40", "elevation is no option here"),
        ("cie:3,ground=2", "ground from 0 to 1"),
    ] {
        let message = text.parse::<AskedEnvironment>().unwrap_err().to_string();
        assert!(message.contains(why) && message.contains("FILE[,scale=S]"), "{message}");
    }
    for (text, why) in [
        ("moon", "it begins with"),
        ("sun:", "is no NAME=VALUE"),
        ("sun:elevation=5,azimuth=1,turbidity=99", "turbidity from"),
        ("point:1,2,3", "watts"),
        ("point:1,2,3,-4", "watts"),
        ("point:1,2,x,4", "\"x\" is no number"),
        ("ies:a.ies", "after @"),
        ("ies:a.ies@1,2", "three coordinates"),
        ("ies:a.ies@1,2,3,azimuth=4", "azimuth is no option here"),
    ] {
        let message = text.parse::<AskedLight>().unwrap_err().to_string();
        assert!(message.contains(why) && message.contains("point:X,Y,Z,WATTS"), "{message}");
    }
    let missing = asked(Some("absent.hdr"), &[]).apply(dark(), &LoadOptions::default()).unwrap_err();
    assert!(missing.to_string().contains("absent.hdr"), "{missing}");
    for text in
        ["cie:16,illuminance=8000,ground=0.2,up=z", "cie:12,illuminance=10000,elevation=40,azimuth=90"]
    {
        assert_eq!(text.parse::<AskedEnvironment>().unwrap().to_string(), text);
    }
    for text in [
        "sun:elevation=30,azimuth=90,turbidity=3,scale=2,up=z",
        "point:1,2,3,4",
        "ies:a,b.ies@1,2,3,rotate=4",
    ] {
        assert_eq!(text.parse::<AskedLight>().unwrap().to_string(), text);
    }
}
