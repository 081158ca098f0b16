//! Groups of lights. Their planes add up to the picture, and each plane is the picture by the
//! lights of that group alone. In pixels with claims the planes are estimated by separate paths.

use tashika::Renderer;
use tashika::bsdf::HenyeyGreenstein;
use tashika::color::Rgb;
use tashika::film::{Film, Plane};
use tashika::integrator::Truth;
use tashika::math::Vec3;
use tashika::render::{TileShare, with_threads};
use tashika::request::{ClaimName, MethodName, Request};
use tashika::scene::{
    Emitter, Environment, Interface, LightGrouping, Material, Medium, Scene, SceneBuilder, Surface, builtin,
};
use tashika::stats::Moments;

use crate::cases::{add_ceiling_lamp, cuboid, diffuse_room, place};
use crate::gltf::Document;
use crate::mitsuba;

const SIZE: [u32; 2] = [16, 12];
/// Names of the lights of [`room`].
const LIGHTS: [&str; 4] = ["lamp", "bulb", "sun", "environment"];

/// A diffuse room with a mirror, optionally with fog. The flags select a lamp, a bulb, a sun and
/// light from outside.
fn room(lights: [bool; 4], in_fog: bool) -> Scene {
    let mut b: SceneBuilder = diffuse_room();
    let [lamp, bulb, sun, environment] = lights;
    if in_fog {
        let medium = Medium {
            name: "fog".into(),
            absorption: Rgb::gray(0.02),
            scattering: Rgb::new(0.1, 0.2, 0.3),
            phase: HenyeyGreenstein::default(),
            variation: None,
        };
        let fog = b.add_medium(medium).unwrap();
        let boundary = b.add_material(Material::new("boundary", Surface::Boundary)).unwrap();
        let bounds = b.bounds();
        let mesh = b.add_mesh(cuboid(bounds.lo - Vec3::ONE, bounds.hi - 0.4, false), boundary).unwrap();
        b.set_interface(mesh, Interface { inside: Some(fog), outside: None }).unwrap();
        b.add_instance(mesh, glam::Affine3A::IDENTITY).unwrap();
    }
    let center = b.bounds().center();
    let mirror = cuboid(center - 0.2, center + 0.1, false);
    place(&mut b, mirror, Material::new("silver", Surface::Mirror { reflectance: Rgb::gray(0.8).into() }));
    // A lamp that is switched off still occludes.
    b.begin_object("lamp");
    add_ceiling_lamp(&mut b, if lamp { 5.0 } else { 0.0 });
    if bulb {
        b.begin_light("bulb");
        let position = center + Vec3::new(0.3, 0.2, 0.4);
        b.add_emitter(Emitter::Point { position, intensity: Rgb::new(1.0, 0.5, 0.25) }).unwrap();
    }
    if sun {
        b.begin_light("sun");
        let direction = Vec3::new(0.2, -1.0, -0.4).normalize();
        b.add_emitter(Emitter::Directional { direction, irradiance: Rgb::new(2.0, 2.0, 1.0) }).unwrap();
    }
    if environment {
        b.set_environment(Environment::constant(Rgb::new(0.2, 0.3, 0.5))).unwrap();
    }
    b.build().unwrap()
}

fn by_paths(scene: Scene, paths: u64, seed: u64) -> Renderer<'static> {
    Renderer::new(scene).method("path".parse::<MethodName>().unwrap()).paths(paths).size(SIZE).seed(seed)
}

fn plane<'f>(film: &'f Film, group: &str) -> &'f Plane {
    film.plane(format!("light_{group}")).unwrap_or_else(|| panic!("no plane of {group}"))
}

fn grouped(words: &[&str]) -> LightGrouping {
    LightGrouping::parse(words.iter().copied()).unwrap()
}

/// The group planes add up to the radiance. All other planes equal those of a render without
/// groups.
#[test]
fn planes_add_up_to_the_picture() {
    for (in_fog, words) in
        [(false, &["each"][..]), (true, &["each"]), (true, &["out=sun,environment", "in=bulb"])]
    {
        let renderer = || by_paths(room([true; 4], in_fog), 16, 3);
        let plain = renderer().render().unwrap().film;
        let film = renderer().light_groups(grouped(words)).render().unwrap().film;
        assert!(plain.planes().iter().all(|plane| film.plane(plane.name()) == Some(plane)), "{words:?}");
        let groups = if words == ["each"] { LIGHTS.to_vec() } else { vec!["out", "in", "rest"] };
        assert_eq!(film.planes().len(), plain.planes().len() + 2 * groups.len());
        let of_all = film.plane("").unwrap();
        for (x, y) in film.window().pixels() {
            let of_pixel = groups.iter().map(|group| plane(&film, group).f32_at(x, y));
            for channel in 0..3 {
                let sum: f32 = of_pixel.clone().map(|samples| samples[channel]).sum();
                let whole = of_all.f32_at(x, y)[channel];
                assert!((sum - whole).abs() <= 1e-5 * whole, "{words:?} {x},{y}: {sum} for {whole}");
            }
        }
        for group in groups {
            assert!(plane(&film, group).f32_samples().unwrap().iter().any(|v| *v > 0.0), "{group} is dark");
        }
    }
}

/// The default method with groups: its pixels are those of a render without groups, and its planes
/// those of path tracing with the same number of paths. Both have the same mean, within their
/// errors.
#[test]
fn planes_beside_claims_are_those_of_paths() {
    let renderer = |paths| {
        let renderer = Renderer::new(room([true; 4], false)).size(SIZE).seed(5).error(0.1).vpls(20_000);
        if paths > 0 { renderer.paths(paths).light_groups(LightGrouping::Each) } else { renderer }
    };
    let [plain, film] = [0, 256].map(|paths| renderer(paths).render().unwrap().film);
    let prepared = renderer(256).prepare().unwrap();
    assert!(prepared.unused().is_empty(), "{:?}", prepared.unused());
    assert_eq!(film.planes()[..plain.planes().len()], *plain.planes());
    assert_eq!(film.metadata().number("light.groups.paths"), Some(256.0));
    assert_eq!(film.metadata().text("method"), Some("tashika"));
    let by_paths =
        by_paths(room([true; 4], false), 256, 5).light_groups(LightGrouping::Each).render().unwrap().film;
    let (mut sums, mut whole, mut variance) = (0.0, 0.0, 0.0);
    for light in LIGHTS {
        assert_eq!(plane(&film, light), plane(&by_paths, light));
        assert!(by_paths.metadata().get("light.groups.paths").is_none());
    }
    for (x, y) in film.window().pixels() {
        let luminance = |plane: &Plane| {
            let [r, g, b] = plane.f32_at(x, y).try_into().unwrap();
            f64::from(Rgb::new(r, g, b).luminance())
        };
        sums += LIGHTS.iter().map(|light| luminance(plane(&film, light))).sum::<f64>();
        whole += luminance(film.plane("").unwrap());
        let error = |film: &Film| f64::from(film.plane("standard_error").unwrap().f32_at(x, y)[0]);
        variance += error(&film).powi(2) + error(&by_paths).powi(2);
    }
    assert!((sums - whole).abs() < 5.0 * variance.sqrt(), "{sums} for {whole}, {variance}");
    assert!(variance.sqrt() < 0.02 * whole, "{whole} ± {}", variance.sqrt());
}

/// The mean of a plane over the image and several seeds equals that of pictures by that light
/// alone.
#[test]
fn a_plane_is_the_picture_by_its_lights_alone() {
    const SEEDS: u64 = 6;
    for in_fog in [false, true] {
        let mean = |plane: &Plane| {
            let samples = plane.f32_samples().unwrap();
            samples.iter().map(|v| f64::from(*v)).sum::<f64>() / samples.len() as f64
        };
        let films = |scene: &dyn Fn() -> Scene, each: bool, from: u64| -> Vec<Film> {
            let render = |seed| {
                let renderer = by_paths(scene(), 64, seed);
                if each { renderer.light_groups(LightGrouping::Each) } else { renderer }
                    .render()
                    .unwrap()
                    .film
            };
            (from..from + SEEDS).map(render).collect()
        };
        let of_all = films(&|| room([true; 4], in_fog), true, 1);
        for (k, light) in LIGHTS.iter().enumerate() {
            let alone = films(&|| room([0, 1, 2, 3].map(|other| other == k), in_fog), false, 100);
            let [mut a, mut b] = [Moments::default(); 2];
            of_all.iter().for_each(|film| a.push(mean(plane(film, light))));
            alone.iter().for_each(|film| b.push(mean(film.plane("").unwrap())));
            let error = a.standard_error().hypot(b.standard_error());
            // The errors come from means of six and have an uncertainty of a third.
            assert!(
                (a.mean() - b.mean()).abs() < 6.0 * error,
                "{light}: {} for {}, ± {error}",
                a.mean(),
                b.mean()
            );
            assert!(error < 0.05 * b.mean(), "{light}: {} ± {error} says little", b.mean());
        }
    }
}

/// The variance that a plane reports, averaged over the image, equals the variance between
/// independent renders.
#[test]
fn standard_errors_are_those_of_other_seeds() {
    const SEEDS: u64 = 24;
    let render = |seed| by_paths(room([true; 4], false), 16, seed).light_groups(LightGrouping::Each).render();
    let films: Vec<Film> = (1..=SEEDS).map(|seed| render(seed).unwrap().film).collect();
    for light in LIGHTS {
        let (mut found, mut told) = (0.0, 0.0);
        for (x, y) in films[0].window().pixels() {
            let mut of_seeds = Moments::default();
            for film in &films {
                let [r, g, b] = plane(film, light).f32_at(x, y).try_into().unwrap();
                of_seeds.push(Rgb::new(r, g, b).luminance().into());
                let error = plane(film, &format!("{light}_standard_error")).f32_at(x, y)[0];
                told += f64::from(error).powi(2) / SEEDS as f64;
            }
            found += of_seeds.variance();
        }
        assert!((told / found - 1.0).abs() < 0.25, "{light}: {told} told, {found} found");
    }
}

#[test]
fn groups_are_the_same_for_threads_and_shares_and_other_methods_refuse_them() {
    let renderer = || by_paths(room([true; 4], false), 4, 1).light_groups(grouped(&["key=lamp"])).mattes(2);
    let whole = renderer().render().unwrap().film;
    assert_eq!(whole.metadata().text("light.groups"), Some("key=lamp"));
    assert_eq!(with_threads(3, || renderer().render().unwrap().film).unwrap(), whole);
    let parts = [1, 2].map(|k| renderer().tiles(TileShare::new(k, 2).unwrap()).render().unwrap().film);
    let [first, second] =
        parts.map(|film| (film.plane("stop").unwrap().clone(), plane(&film, "key").clone()));
    for (x, y) in whole.window().pixels() {
        let (stop, key) = if first.0.u32_at(x, y) == [0] { &second } else { &first };
        assert!(stop.u32_at(x, y) != [0]);
        assert_eq!(key.f32_at(x, y), plane(&whole, "key").f32_at(x, y));
    }
    let refusal = |request: Request| {
        let renderer = Renderer::new(builtin::tiny()).request(request).light_groups(LightGrouping::Each);
        renderer.size(SIZE).render().unwrap_err().to_string()
    };
    let audited = Some(ClaimName::Audited);
    for request in [
        Request::of_a_sum(),
        Request { truth: Some(Truth::Clamped), ..Request::default() },
        Request { claim: audited, ..Request::default() },
        Request { method: "path".parse().unwrap(), claim: audited, ..Request::default() },
    ] {
        let said = refusal(request);
        assert!(
            said.starts_with("groups = each; expected none but with a picture of light transport"),
            "{said}"
        );
    }
}

#[test]
fn lights_are_called_as_files_call_them() {
    let names = |scene: &Scene| -> Vec<String> {
        (0..scene.emitters().len()).map(|k| scene.light_name(k).into_owned()).collect()
    };
    let mut d = Document::triangle();
    let lights = serde_json::json!([{ "type": "point", "name": "bulb" }, { "type": "point" }]);
    d.json["extensionsUsed"] = serde_json::json!(["KHR_lights_punctual"]);
    d.json["extensions"] = serde_json::json!({ "KHR_lights_punctual": { "lights": lights } });
    let node = |light: u32, name: &str| serde_json::json!({ "name": name, "extensions": { "KHR_lights_punctual": { "light": light } } });
    d.json["nodes"] = serde_json::json!([{ "mesh": 0 }, node(0, "over the table"), node(0, ""), node(1, "")]);
    d.json["scenes"] = serde_json::json!([{ "nodes": [0, 1, 2, 3] }]);
    assert_eq!(names(&d.load().unwrap()), ["over the table", "bulb", "light 3"]);
    let scene = mitsuba::load(
        r#"<emitter type="point" id="bulb"/><emitter type="point"/><emitter type="spot" id="spot"/>"#,
    );
    assert_eq!(names(&scene), ["bulb", "light 2", "spot"]);
}
