//! The pbrt loader: lights, colours, materials and textures, in numbers; the feature table.
//!
//! Directives and shapes are in `pbrt`.

use glam::{Vec2, Vec3};
use image::{DynamicImage, ImageBuffer, Rgb as Texel, Rgba};
use tashika::bsdf::{ConductorFresnel, FacetModel};
use tashika::color::Rgb;
use tashika::io::{Feature, Support, features};
use tashika::math::elementary::sin_cos;
use tashika::scene::{
    Channel, ColorInput, Emitter, FacetInput, FalloffShape, FloatInput, NormalInput, NoteKind, Scene,
    Surface, Texture, Wrap,
};

use super::pbrt::{Folder, TRIANGLE, V3, V4, noted, notes, nvdb, scene};
use super::textures;

fn close(a: Rgb, b: [f32; 3], tolerance: f32) -> bool {
    a.to_array().iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance * (1.0 + b.abs()))
}

fn same(a: Vec3, b: [f32; 3]) -> bool {
    (a - Vec3::from(b)).length() < 1e-5 * (1.0 + a.length())
}

#[test]
fn lights_without_extent_follow_their_parameters() {
    let only = |head: &str, text: &str| {
        let scene = scene(&format!("{head} {text}"));
        assert_eq!(scene.emitters().len(), 1, "{text}");
        scene.emitters()[0]
    };
    let Emitter::Point { position, intensity } = only(
        V4,
        "Translate 1 2 3 LightSource \"point\" \"point3 from\" [1 0 0] \"rgb I\" [1 2 3] \"float scale\" 2",
    ) else {
        panic!()
    };
    assert!(same(position, [2.0, 2.0, 3.0]) && close(intensity, [2.0, 4.0, 6.0], 0.0));
    let Emitter::Point { intensity, .. } = only(V4, "LightSource \"point\" \"float power\" 100") else {
        panic!()
    };
    assert!(close(intensity, [100.0 / 12.566_371; 3], 1e-5));
    let Emitter::Point { intensity, .. } = only(V3, "LightSource \"point\" \"rgb scale\" [1 2 3] WorldEnd")
    else {
        panic!()
    };
    assert!(close(intensity, [1.0, 2.0, 3.0], 0.0));

    let spot = "LightSource \"spot\" \"point3 from\" [0 0 5] \"point3 to\" [0 0 0] \"float coneangle\" 60 \
        \"float conedeltaangle\" 30";
    let Emitter::Spot { position, axis, falloff, .. } = only(V4, spot) else { panic!() };
    assert!(same(position, [0.0, 0.0, 5.0]) && same(axis, [0.0, 0.0, -1.0]));
    assert!((falloff.cos_outer - 0.5).abs() < 1e-6 && (falloff.cos_inner - 0.866_025_4).abs() < 1e-6);
    assert_eq!(falloff.shape, FalloffShape::Smoothstep);
    let Emitter::Spot { intensity, .. } = only(V4, &format!("{spot} \"float power\" 10")) else { panic!() };
    // 2π ((1 − cos 30°) + (cos 30° − cos 60°) / 2)
    assert!(close(intensity, [10.0 / 1.991_787; 3], 1e-4), "{intensity:?}");
    let Emitter::Spot { falloff: old, .. } = only(V3, &format!("{spot} WorldEnd")) else { panic!() };
    assert_eq!(old.shape, FalloffShape::Fourth);
    // At the midpoint between the two cosines.
    assert!((old.at(0.683_012_7) - 0.0625).abs() < 1e-5, "{}", old.at(0.683_012_7));

    let distant = "Rotate 90 0 0 1 LightSource \"distant\" \"point3 from\" [1 0 0] \"point3 to\" [0 0 0] \"rgb L\" [3 2 1]";
    let Emitter::Directional { direction, irradiance } = only(V4, distant) else { panic!() };
    assert!(
        same(direction, [0.0, -1.0, 0.0]) && close(irradiance, [3.0, 2.0, 1.0], 0.0),
        "light travels from to to"
    );
    let Emitter::Directional { irradiance, .. } = only(V4, &format!("{distant} \"float illuminance\" 7"))
    else {
        panic!()
    };
    assert!(close(irradiance, [21.0, 14.0, 7.0], 1e-6));
}

#[test]
fn lights_of_shapes_have_the_radiance_or_the_power_asked_for() {
    let radiance = |head: &str, light: &str, shape: &str| {
        let scene = scene(&format!("{head} AreaLightSource \"diffuse\" {light} {shape}"));
        let (_, emission) = scene.area_emitters().next().expect("it emits");
        emission.radiance.factor
    };
    assert!(close(radiance(V4, "\"rgb L\" [17 12 4]", TRIANGLE), [17.0, 12.0, 4.0], 0.0));
    assert!(close(radiance(V4, "\"rgb L\" [1 2 3] \"float scale\" 10", TRIANGLE), [10.0, 20.0, 30.0], 0.0));
    assert!(close(
        radiance(V3, "\"rgb L\" [1 2 3] \"rgb scale\" [1 10 100]", TRIANGLE),
        [1.0, 20.0, 300.0],
        0.0
    ));
    // The triangle has an area of 1/2. In a world that is scaled by two its area is 2.
    let power = "\"float power\" 10";
    let expected = 10.0 / (0.5 * std::f32::consts::PI);
    assert!(close(radiance(V4, power, TRIANGLE), [expected; 3], 1e-6));
    assert!(close(radiance(V4, power, &format!("Scale 2 2 2 {TRIANGLE}")), [expected / 4.0; 3], 1e-6));
    assert!(close(
        radiance(V4, &format!("{power} \"bool twosided\" true"), TRIANGLE),
        [expected / 2.0; 3],
        1e-6
    ));
    // Light and alpha belong to the shape: each combination becomes a material.
    let text = format!("{V4} {TRIANGLE} AreaLightSource \"diffuse\" {TRIANGLE} {TRIANGLE}");
    assert_eq!(scene(&text).materials().len(), 2);
    let black = scene(&format!("{V4} AreaLightSource \"diffuse\" \"rgb L\" [0 0 0] {TRIANGLE}"));
    assert_eq!(black.area_emitters().count(), 0);
}

#[test]
fn spectra_become_the_colours_that_pixels_show() {
    let light = |head: &str, text: &str| {
        let scene = scene(&format!("{head} LightSource \"point\" {text}"));
        match scene.emitters()[0] {
            Emitter::Point { intensity, .. } => intensity,
            other => panic!("{other:?}"),
        }
    };
    // pbrt-v4 divides by the luminance of the spectrum; pbrt-v3 sets its largest value to 1.
    let warm = light(V4, "\"blackbody I\" 2800");
    assert!((warm.luminance() - 1.0).abs() < 1e-3 && warm.r > warm.g && warm.g > warm.b, "{warm:?}");
    let (one, three) = (light(V3, "\"blackbody I\" [6500 1]"), light(V3, "\"blackbody I\" [6500 3]"));
    assert!(close(three, (one * 3.0).to_array(), 1e-5) && (0.85..1.0).contains(&one.luminance()), "{one:?}");
    let flat = light(V4, "\"spectrum I\" [400 5 700 5]");
    assert!((flat.luminance() - 1.0).abs() < 1e-3);
    let flat = light(V3, "\"spectrum I\" [300 5 900 5]");
    assert!((flat.luminance() - 5.0).abs() < 0.02, "{flat:?}");
    // White of Rec. 709 is D65: X Y Z = 0.9505 1 1.089.
    assert!(close(light(V3, "\"xyz I\" [0.9505 1 1.089]"), [1.0; 3], 1e-3));
    // A reflectance of 1 is white in every space; light of ACES keeps its warmer white.
    let reflectance = |space: &str, rgb: &str| {
        let text = format!(
            "ColorSpace \"{space}\" Material \"diffuse\" \"rgb reflectance\" {rgb} ColorSpace \"srgb\""
        );
        let Surface::Lambert { reflectance } = material(V4, &text).1 else { panic!() };
        color(reflectance).to_array()
    };
    for space in ["srgb", "rec2020", "dci-p3", "aces2065-1"] {
        assert!(close(Rgb::from(reflectance(space, "[0.5 0.5 0.5]")), [0.5; 3], 1e-5), "{space}");
    }
    // By the inverse of the matrix of ITU-R BT.2087-0.
    let green = Rgb::from(reflectance("rec2020", "[0.3 0.4 0.3]"));
    assert!(close(green, [0.2412, 0.4133, 0.2899], 2e-4), "{green:?}");
    let warm = light(V4, "\"rgb I\" [1 1 1]");
    assert_eq!(warm, Rgb::WHITE);
    let warm = light(&format!("{V4} ColorSpace \"aces2065-1\""), "\"rgb I\" [1 1 1]");
    assert!(warm.r > 1.02 && warm.b < 0.98 && (warm.luminance() - 1.0).abs() < 1e-3, "{warm:?}");
    let negative = scene(&format!("{V4} LightSource \"point\" \"rgb I\" [1 -2 3]"));
    assert!(noted(&negative, NoteKind::Repaired, "colours with negative channels"));

    let folder = Folder::new();
    folder.write("s/flat.spd", "# wavelength value\n400 0.25\n700, 0.25 # end\n");
    let text = format!("{V4} Material \"diffuse\" \"spectrum reflectance\" \"s/flat.spd\" {TRIANGLE}");
    let scene = folder.load(&text).unwrap();
    let Surface::Lambert { reflectance } = scene.materials()[0].surface else { panic!() };
    assert!(close(reflectance.factor, [0.25; 3], 1e-3));
    for wrong in ["\"spectrum reflectance\" [400]", "\"blackbody reflectance\" -5"] {
        let error = folder.load(&format!("{V4} Material \"diffuse\" {wrong}")).unwrap_err().to_string();
        assert!(error.contains("that gives no colour"), "{error}");
    }
}

/// A Radiance file of `width` × `height` linear texels.
fn hdr(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 3]) -> Vec<u8> {
    let picture = DynamicImage::from(ImageBuffer::from_fn(width, height, |x, y| Texel(texel(x, y))));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Hdr).unwrap();
    bytes.into_inner()
}

/// A PNG of two columns and two rows. The top left texel is bright, the others are black; the
/// opacity is 255 or 128.
fn png(opacity: u8) -> Vec<u8> {
    let picture = DynamicImage::from(ImageBuffer::from_fn(2, 2, |x, y| {
        let v = if (x, y) == (0, 0) { 255 } else { 0 };
        Rgba([v, v, v, opacity])
    }));
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

#[test]
fn lights_at_infinity_are_turned_as_each_format_turns_them() {
    let folder = Folder::new();
    // pbrt-v3: rows begin at the pole +z, columns at +x and turn towards +y. The bright texel is at
    // φ = 90°, θ = 90°.
    folder.write("lat.hdr", hdr(16, 9, |x, y| if (x, y) == (4, 4) { [1.0, 0.5, 0.25] } else { [0.0; 3] }));
    let radiance = |text: &str, direction: [f32; 3]| {
        let scene = folder.load(text).unwrap();
        scene.environment().unwrap().radiance(Vec3::from(direction).normalize())
    };
    // Direction of the texel's centre, half a texel beyond 90°.
    let (sin, cos) = sin_cos(4.5 / 16.0 * std::f32::consts::TAU);
    let map = "LightSource \"infinite\" \"string mapname\" \"lat.hdr\" \"rgb L\" [2 2 2] WorldEnd";
    assert!(close(radiance(&format!("{V3} {map}"), [cos, sin, 0.0]), [2.0, 1.0, 0.5], 0.02));
    assert!(radiance(&format!("{V3} {map}"), [-cos, -sin, 0.0]).is_black());
    assert!(close(radiance(&format!("{V3} Rotate 90 0 0 1 {map}"), [-sin, cos, 0.0]), [2.0, 1.0, 0.5], 0.02));
    assert!(close(radiance(&format!("{V3} Scale -2 2 2 {map}"), [-cos, sin, 0.0]), [2.0, 1.0, 0.5], 0.02));
    // The top of the picture is +z.
    folder.write("up.hdr", hdr(8, 4, |_, y| [f32::from(u8::from(y == 0)); 3]));
    let up = "LightSource \"infinite\" \"string mapname\" \"up.hdr\" WorldEnd";
    assert!(close(radiance(&format!("{V3} {up}"), [0.01, 0.0, 1.0]), [1.0; 3], 0.02));
    // pbrt-v4: the centre of the square is +z.
    folder.write("oct.hdr", hdr(9, 9, |x, y| [f32::from(u8::from((x, y) == (4, 4))); 3]));
    let square = "LightSource \"infinite\" \"string filename\" \"oct.hdr\" \"float scale\" 3";
    assert!(close(radiance(&format!("{V4} {square}"), [0.0, 0.0, 1.0]), [3.0; 3], 0.02));
    assert!(close(radiance(&format!("{V4} Rotate -90 1 0 0 {square}"), [0.0, 1.0, 0.0]), [3.0; 3], 0.02));
    let scene =
        folder.load(&format!("{V4} LightSource \"infinite\" \"string filename\" \"lat.hdr\"")).unwrap();
    assert!(noted(&scene, NoteKind::Repaired, "maps of infinite lights that are not square"));

    let constants = "LightSource \"infinite\" \"rgb L\" [1 2 3] LightSource \"infinite\" \"float scale\" 2";
    assert!(close(radiance(&format!("{V4} {constants}"), [0.0, 1.0, 0.0]), [3.0, 4.0, 5.0], 0.0));
    let lux = "LightSource \"infinite\" \"float illuminance\" 6.2831855";
    assert!(close(radiance(&format!("{V4} {lux}"), [0.0, 1.0, 0.0]), [2.0; 3], 1e-6));
    let scene = folder.load(&format!("{V4} {constants} {square} {square}")).unwrap();
    assert!(noted(&scene, NoteKind::Ignored, "constant infinite lights beside a map"));
    assert!(noted(&scene, NoteKind::Ignored, "further maps"));
}

/// The only material of a text. Its folder has the images `a.png` (opaque) and `b.png` (half
/// transparent).
fn material(head: &str, text: &str) -> (Scene, Surface) {
    let folder = Folder::new();
    folder.write("a.png", png(255));
    folder.write("b.png", png(128));
    let text = format!("{head} {text} {TRIANGLE}");
    let scene = folder.load(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let surface = scene.materials().last().unwrap().surface;
    (scene, surface)
}

fn value(input: impl Into<FloatInput>) -> f32 {
    let input = input.into();
    assert!(input.texture.is_none());
    input.factor
}

fn color(input: ColorInput) -> Rgb {
    assert!(input.texture.is_none());
    input.factor
}

#[test]
fn materials_of_pbrt_v3_become_surfaces() {
    let v3 = |text: &str| material(V3, &format!("Material {text}")).1;
    let Surface::Lambert { reflectance } = v3("\"matte\" \"rgb Kd\" [1 0.5 0]") else { panic!() };
    assert_eq!(color(reflectance), Rgb::new(1.0, 0.5, 0.0));
    let Surface::Plastic { diffuse, specular, ior, facets } = v3("\"plastic\" \"rgb Kd\" [0.1 0.2 0.3]")
    else {
        panic!()
    };
    assert_eq!((color(diffuse), color(specular), ior), (Rgb::new(0.1, 0.2, 0.3), Rgb::gray(0.25), 1.5));
    assert!((value(facets.alpha) - 0.4618).abs() < 1e-3, "roughness 0.1, remapped");
    let Surface::Plastic { facets, .. } = v3("\"plastic\" \"bool remaproughness\" \"false\"") else {
        panic!()
    };
    assert_eq!(value(facets.alpha), 0.1);
    let Surface::Conductor { fresnel: ConductorFresnel::Exact { eta, k }, .. } =
        v3("\"metal\" \"rgb eta\" [1 2 3] \"rgb k\" [4 5 6]")
    else {
        panic!()
    };
    assert_eq!((eta, k), (Rgb::new(1.0, 2.0, 3.0), Rgb::new(4.0, 5.0, 6.0)));
    let Surface::Conductor { fresnel: copper, .. } = v3("\"metal\"") else { panic!() };
    let reflected = copper.at(1.0);
    assert!(reflected.r > 0.9 && reflected.b < 0.7, "copper: {reflected:?}");
    assert!(
        matches!(v3("\"mirror\""), Surface::Mirror { reflectance } if color(reflectance) == Rgb::gray(0.9))
    );
    let Surface::Glass { ior, transmittance, .. } = v3("\"glass\" \"float index\" 1.3 \"rgb Kt\" [1 0.5 1]")
    else {
        panic!()
    };
    assert_eq!((ior, transmittance), (1.3, Rgb::new(1.0, 0.5, 1.0)));
    let Surface::Translucent { reflectance, transmittance } =
        v3("\"translucent\" \"rgb Kd\" [0.8 0.4 0.4] \"rgb Ks\" [0 0 0] \"rgb reflect\" [0.5 0.5 0.5] \
         \"rgb transmit\" [0.25 0.25 0.25]")
    else {
        panic!()
    };
    assert!(
        close(color(reflectance), [0.4, 0.2, 0.2], 1e-6)
            && close(color(transmittance), [0.2, 0.1, 0.1], 1e-6)
    );
    let Surface::AshikhminShirley { diffuse, specular_f0, facets } =
        v3("\"substrate\" \"rgb Ks\" [0.04 0.04 0.04] \"float uroughness\" 0.25 \"float vroughness\" 0.25 \
            \"bool remaproughness\" \"false\"")
    else {
        panic!()
    };
    assert_eq!(
        (color(diffuse), color(specular_f0), facets),
        (Rgb::gray(0.5), Rgb::gray(0.04), FacetInput::even(0.25.into(), FacetModel::Ggx))
    );
}

#[test]
fn materials_made_of_parts_keep_their_sum() {
    let (scene, surface) = material(
        V3,
        "Material \"uber\" \"rgb Kd\" [0.3 0.3 0.3] \"rgb Ks\" [0.1 0.1 0.1] \"rgb Kr\" [0.1 0.1 0.1] \
         \"rgb Kt\" [0.5 0.5 0.5] \"rgb opacity\" [0.25 0.25 0.25]",
    );
    let Surface::Mix { first, second, amount } = surface else { panic!("{surface:?}") };
    let share = value(amount);
    assert!((share - 5.0 / 9.0).abs() < 1e-6);
    let Surface::Plastic { diffuse, specular, .. } = scene.materials()[first.index()].surface else {
        panic!()
    };
    let Surface::Glass { reflectance, transmittance, .. } = scene.materials()[second.index()].surface else {
        panic!()
    };
    assert!(close(color(diffuse) * (1.0 - share), [0.3; 3], 1e-6));
    assert!(close(color(specular) * (1.0 - share), [0.1; 3], 1e-6));
    assert!(close(transmittance * share, [0.5; 3], 1e-6) && close(reflectance * share, [0.1; 3], 1e-6));
    let alpha = scene.materials().last().unwrap().alpha.unwrap();
    assert!((value(alpha.value) - 0.25).abs() < 1e-6);

    // The amount is the share of the first material in pbrt-v3 and of the second in pbrt-v4.
    let named = |name: &str, class: &str| format!("MakeNamedMaterial \"{name}\" \"string type\" \"{class}\"");
    let (scene, surface) = material(
        V3,
        &format!(
            "{} {} Material \"mix\" \"string namedmaterial1\" \"a\" \"string namedmaterial2\" \"b\" \"rgb amount\" [0.9 0.9 0.9]",
            named("a", "matte"),
            named("b", "mirror")
        ),
    );
    let Surface::Mix { second, amount, .. } = surface else { panic!() };
    let kind = |id: tashika::scene::MaterialId| {
        matches!(scene.materials()[id.index()].surface, Surface::Lambert { .. })
    };
    assert!(kind(second) && (value(amount) - 0.9).abs() < 1e-6);
    let (scene, surface) = material(
        V4,
        &format!(
            "{} {} Material \"mix\" \"string materials\" [\"a\" \"b\"] \"float amount\" 0.9",
            named("a", "diffuse"),
            named("b", "conductor")
        ),
    );
    let Surface::Mix { first, amount, .. } = surface else { panic!() };
    assert!(
        matches!(scene.materials()[first.index()].surface, Surface::Lambert { .. }) && value(amount) == 0.9
    );
    let (scene, surface) = material(V4, "Material \"mix\" \"string materials\" [\"a\" \"b\"]");
    assert!(
        matches!(surface, Surface::Lambert { .. }) && noted(&scene, NoteKind::Repaired, "mixes of materials")
    );
}

#[test]
fn materials_of_pbrt_v4_become_surfaces() {
    let v4 = |text: &str| material(V4, &format!("Material {text}")).1;
    let Surface::Coated { reflectance, ior, facets, .. } =
        v4("\"coateddiffuse\" \"rgb reflectance\" [1 0.5 0] \"float eta\" 1.4 \"float roughness\" 0.25")
    else {
        panic!()
    };
    assert_eq!((color(reflectance), ior, value(facets.alpha)), (Rgb::new(1.0, 0.5, 0.0), 1.4, 0.5));
    let Surface::Coated { facets, .. } = v4("\"coateddiffuse\"") else { panic!() };
    assert_eq!(value(facets.alpha), 0.0, "smooth unless the file says otherwise");
    let Surface::Conductor { fresnel, facets, .. } = v4(
        "\"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" \"float uroughness\" 0.04 \
            \"float vroughness\" 0.01",
    ) else {
        panic!()
    };
    let gold = fresnel.at(1.0);
    assert!(gold.r > 0.9 && gold.b < 0.6, "{gold:?}");
    assert_eq!((value(facets.alpha), facets.across.map(value)), (0.2, Some(0.1)), "along and across");
    let Surface::Conductor { fresnel, .. } = v4("\"conductor\" \"rgb reflectance\" [0.9 0.5 0.1]") else {
        panic!()
    };
    assert!(close(fresnel.at(1.0), [0.9, 0.5, 0.1], 1e-4));
    let Surface::Glass { ior, .. } = v4("\"dielectric\" \"float eta\" 2") else { panic!() };
    assert_eq!(ior, 2.0);
    let Surface::Glass { ior, .. } = v4("\"dielectric\" \"spectrum eta\" \"glass-BK7\"") else { panic!() };
    assert!((1.50..1.53).contains(&ior), "{ior}");
    assert!(
        matches!(v4("\"thindielectric\" \"float eta\" 1.2"), Surface::ThinGlass { ior, .. } if ior == 1.2)
    );
    let Surface::Translucent { reflectance, transmittance } =
        v4("\"diffusetransmission\" \"rgb reflectance\" [0.2 0.2 0.2] \"float scale\" 2")
    else {
        panic!()
    };
    assert_eq!((color(reflectance), color(transmittance)), (Rgb::gray(0.4), Rgb::gray(0.5)));
    let Surface::Glass { facets, .. } = v4("\"dielectric\" \"float roughness\" 0.25") else { panic!() };
    assert_eq!(value(facets.alpha), 0.5);
    let (scene, surface) = material(V4, "NamedMaterial \"none\"");
    assert!(matches!(surface, Surface::Lambert { .. }));
    assert!(noted(&scene, NoteKind::Repaired, "material \"none\" is not defined"));
    for invisible in ["\"interface\"", "\"none\"", "\"\""] {
        let scene = self::scene(&format!("{V4} Material {invisible} AreaLightSource \"diffuse\" {TRIANGLE}"));
        assert!(scene.instances().is_empty() && noted(&scene, NoteKind::Ignored, "area lights of invisible"));
    }
}

/// Value of a colour's texture at pbrt's texture coordinates, `t` up.
fn lookup(scene: &Scene, input: ColorInput, s: f32, t: f32) -> Rgb {
    input.at(scene.textures(), Vec2::new(s, 1.0 - t))
}

fn textured(head: &str, texture: &str) -> (Scene, ColorInput) {
    let class = if head == V3 { "\"matte\" \"texture Kd\"" } else { "\"diffuse\" \"texture reflectance\"" };
    let (scene, surface) =
        material(head, &format!("Texture \"t\" \"spectrum\" {texture} Material {class} \"t\""));
    let Surface::Lambert { reflectance } = surface else { panic!() };
    (scene, reflectance)
}

#[test]
fn textures_of_images_have_their_first_row_at_the_top() {
    for head in [V3, V4] {
        let (scene, t) = textured(head, "\"imagemap\" \"string filename\" \"a.png\"");
        assert!(close(lookup(&scene, t, 0.25, 0.75), [1.0; 3], 1e-6), "top left");
        assert!(lookup(&scene, t, 0.25, 0.25).is_black() && lookup(&scene, t, 0.75, 0.75).is_black());
        // s = 2u + 0.5, t = v − 0.25: the top left texel is met at u = 0.875 − 1 + …, v = 1.
        let mapped = "\"imagemap\" \"string filename\" \"a.png\" \"float uscale\" 2 \"float udelta\" 0.5 \"float vdelta\" -0.25";
        let (scene, t) = textured(head, mapped);
        assert!(close(lookup(&scene, t, 0.375, 1.0), [1.0; 3], 1e-6), "s = 1.25, t = 0.75");
        assert!(lookup(&scene, t, 0.375, 0.5).is_black());
    }
    let (scene, t) = textured(V4, "\"imagemap\" \"string filename\" \"a.png\" \"string wrap\" \"black\"");
    assert!(lookup(&scene, t, -3.0, 0.75).is_black());
    let Texture::Image(image) = scene.textures().nodes[t.texture.unwrap().index()] else { panic!() };
    assert_eq!(image.wrap, [Wrap::Black; 2]);
    let (scene, t) =
        textured(V4, "\"imagemap\" \"string filename\" \"a.png\" \"float scale\" 0.5 \"bool invert\" true");
    assert!(
        close(lookup(&scene, t, 0.25, 0.75), [0.5; 3], 1e-6)
            && close(lookup(&scene, t, 0.75, 0.75), [1.0; 3], 1e-6)
    );
    let (scene, t) = textured(V4, "\"imagemap\" \"string filename\" \"none.png\"");
    assert!(
        close(lookup(&scene, t, 0.3, 0.3), [0.5; 3], 0.0) && !notes(&scene).is_empty(),
        "{:?}",
        notes(&scene)
    );
}

#[test]
fn textures_are_decoded_as_each_format_says() {
    use tashika::scene::Pixels;
    let is_srgb = |head: &str, parameters: &str| {
        let (scene, _) = textured(head, &format!("\"imagemap\" \"string filename\" \"a.png\" {parameters}"));
        matches!(scene.images()[0].pixels, Pixels::Srgb8(_))
    };
    assert!(is_srgb(V3, "") && !is_srgb(V3, "\"bool gamma\" \"false\"") && is_srgb(V4, ""));
    assert!(!is_srgb(V4, "\"string encoding\" \"linear\"") && is_srgb(V4, "\"string encoding\" \"sRGB\""));
    // In pbrt-v4, a number from an image with opacity is the opacity.
    let channel = |head: &str, image: &str| {
        let text = format!("Texture \"a\" \"float\" \"imagemap\" \"string filename\" \"{image}\"");
        let folder = Folder::new();
        folder.write("a.png", png(255));
        folder.write("b.png", png(128));
        let scene =
            folder.load(&format!("{head} {text} {} \"texture alpha\" \"a\"", TRIANGLE.trim_end())).unwrap();
        scene.materials()[0].alpha.unwrap().value.texture.unwrap().1
    };
    assert_eq!(channel(V4, "b.png"), Channel::A);
    assert_eq!([channel(V4, "a.png"), channel(V3, "b.png")], [Channel::Luminance; 2]);
}

#[test]
fn textures_combine() {
    let board = "Texture \"b\" \"spectrum\" \"checkerboard\" \"float uscale\" 2 \"float vscale\" 2 \
        \"rgb tex1\" [1 0 0] \"rgb tex2\" [0 1 0]";
    let combined = |texture: &str| {
        let (scene, surface) = material(
            V4,
            &format!(
                "{board} Texture \"t\" \"spectrum\" {texture} Material \"diffuse\" \"texture reflectance\" \"t\""
            ),
        );
        let Surface::Lambert { reflectance } = surface else { panic!() };
        [(0.1, 0.1), (0.6, 0.1)].map(|(s, t)| lookup(&scene, reflectance, s, t).to_array())
    };
    let plain = combined("\"scale\" \"texture tex\" \"b\"");
    assert_eq!(
        plain,
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        "tex1 where the sum of the squares' indices is even"
    );
    assert_eq!(
        combined("\"scale\" \"texture tex\" \"b\" \"float scale\" 0.5"),
        [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0]]
    );
    assert_eq!(
        combined("\"mix\" \"texture tex1\" \"b\" \"rgb tex2\" [0 0 1] \"float amount\" 0.25"),
        [[0.75, 0.0, 0.25], [0.0, 0.75, 0.25]]
    );
    assert_eq!(combined("\"constant\" \"rgb value\" [0.1 0.2 0.3]"), [[0.1, 0.2, 0.3]; 2]);
    assert_eq!(
        combined("\"mix\" \"rgb tex1\" [0 0 0] \"rgb tex2\" [1 1 0] \"float amount\" 0.5"),
        [[0.5, 0.5, 0.0]; 2]
    );
    // Textures of colours and of numbers may have the same name.
    let (scene, surface) = material(
        V4,
        "Texture \"t\" \"float\" \"constant\" \"float value\" 0.1 Material \"diffuse\" \"texture reflectance\" \"t\"",
    );
    assert!(matches!(surface, Surface::Lambert { reflectance } if color(reflectance) == Rgb::gray(0.5)));
    assert!(noted(&scene, NoteKind::Repaired, "texture \"t\" is not defined"));
}

#[test]
fn materials_have_textured_roughness_bumps_and_normal_maps() {
    let board = "Texture \"r\" \"float\" \"checkerboard\" \"float tex1\" 0.25 \"float tex2\" 1";
    let alpha = |head: &str, text: &str| {
        let (scene, surface) =
            material(head, &format!("{board} Material {text} \"texture roughness\" \"r\""));
        let (Surface::Coated { facets, .. } | Surface::Plastic { facets, .. }) = surface else { panic!() };
        facets.alpha.at(scene.textures(), Vec2::new(0.5, 0.5))
    };
    assert!((alpha(V4, "\"coateddiffuse\"") - 0.5).abs() < 1e-6);
    assert_eq!(alpha(V4, "\"coateddiffuse\" \"bool remaproughness\" false"), 0.25);
    // The polynomial at 0.25 is 0.7665.
    assert!((alpha(V3, "\"plastic\"") / 0.7665 - 1.0).abs() < 0.06);
    let bumped = |head: &str, text: &str| {
        let (scene, _) = material(head, &format!("{board} Material {text}"));
        scene.materials().last().unwrap().normal
    };
    assert!(matches!(bumped(V3, "\"matte\" \"texture bumpmap\" \"r\""), Some(NormalInput::Bump { .. })));
    assert!(matches!(
        bumped(V4, "\"diffuse\" \"texture displacement\" \"r\""),
        Some(NormalInput::Bump { .. })
    ));
    assert!(matches!(
        bumped(V4, "\"diffuse\" \"string normalmap\" \"a.png\""),
        Some(NormalInput::Map { .. })
    ));
    assert_eq!(bumped(V4, "\"diffuse\""), None);
}

/// Parameter of a medium with a grid of one cell.
const ONE_CELL: &str = "\"float density\" 2";

/// A scene with one feature of the table. All of its other features are fully supported.
pub fn scene_with(feature: &Feature) -> String {
    let Feature { kind, name, .. } = feature;
    let of_v3 = [
        "matte",
        "plastic",
        "metal",
        "mirror",
        "glass",
        "uber",
        "substrate",
        "translucent",
        "disney",
        "kdsubsurface",
        "fourier",
    ];
    let head = if of_v3.contains(name) || *name == "heightfield" { V3 } else { V4 };
    let end = if head == V3 { "WorldEnd" } else { "" };
    let points = "\"point3 P\" [0 0 0 1 0 0 0 1 0]";
    let body = match (*kind, *name) {
        ("camera", _) => return format!("Film \"rgb\" Camera \"{name}\" WorldBegin {TRIANGLE}"),
        ("film", "image") => {
            return format!("Film \"image\" Camera \"perspective\" WorldBegin {TRIANGLE} WorldEnd");
        }
        ("film", _) => return format!("Film \"{name}\" Camera \"perspective\" WorldBegin {TRIANGLE}"),
        ("shape", "trianglemesh" | "loopsubdiv") => {
            format!("Shape \"{name}\" \"integer indices\" [0 1 2] {points}")
        }
        ("shape", "plymesh") => "Shape \"plymesh\" \"string filename\" \"a.ply\"".to_owned(),
        ("shape", "bilinearmesh") => {
            "Shape \"bilinearmesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]".to_owned()
        }
        ("shape", "heightfield") => {
            "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0 0]".to_owned()
        }
        ("shape", "hyperboloid") => {
            "Shape \"hyperboloid\" \"point3 p1\" [1 0 0] \"point3 p2\" [1 0 1]".to_owned()
        }
        ("shape", _) => format!("Shape \"{name}\""),
        ("light", "goniometric" | "projection") => {
            format!("LightSource \"{name}\" \"string filename\" \"a.png\"")
        }
        ("light", _) => format!("LightSource \"{name}\""),
        ("area light", _) => format!("AreaLightSource \"{name}\""),
        ("material", "mix") => "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \
            Material \"mix\" \"string materials\" [\"a\" \"a\"]"
            .to_owned(),
        ("material", _) => format!("Material \"{name}\""),
        ("texture", image) if image.starts_with("imagemap") => {
            let file = match image {
                "imagemap of 16 bits" => "wide.png",
                "imagemap .tx" => "a.tx",
                "imagemap <UDIM>" => "u.<UDIM>.png",
                _ => "a.png",
            };
            format!("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\"")
        }
        ("texture", _) => format!("Texture \"t\" \"spectrum\" \"{name}\""),
        ("mapping", _) => {
            format!("Texture \"t\" \"spectrum\" \"checkerboard\" \"string mapping\" \"{name}\"")
        }
        ("color space", _) => format!("ColorSpace \"{name}\""),
        ("directive", "MakeNamedMedium") => {
            "MakeNamedMedium \"m\" \"string type\" \"homogeneous\"".to_owned()
        }
        ("directive", "MediumInterface") => "MediumInterface \"\"".to_owned(),
        ("directive", "Volume") => "Volume \"exponential\"".to_owned(),
        ("medium", "homogeneous preset") => {
            "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"string preset\" \"Wholemilk\"".to_owned()
        }
        ("medium", "homogeneous Le") => {
            "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"rgb Le\" [1 1 1] \"float Lescale\" 2"
                .to_owned()
        }
        ("medium", "uniformgrid Le") => {
            format!(
                "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" {ONE_CELL} \"float temperature\" 900"
            )
        }
        ("medium", "uniformgrid" | "heterogeneous") => {
            format!("MakeNamedMedium \"m\" \"string type\" \"{name}\" {ONE_CELL}")
        }
        ("medium", "rgbgrid") => {
            "MakeNamedMedium \"m\" \"string type\" \"rgbgrid\" \"rgb sigma_s\" [1 2 3]".to_owned()
        }
        ("medium", "nanovdb") => {
            "MakeNamedMedium \"m\" \"string type\" \"nanovdb\" \"string filename\" \"a.nvdb\"".to_owned()
        }
        ("medium", _) => format!("MakeNamedMedium \"m\" \"string type\" \"{name}\""),
        other => panic!("write a scene for {other:?}"),
    };
    format!("{head} {body} {TRIANGLE} {end}")
}

/// A folder with the files of [`scene_with`].
pub fn folder_of_features() -> Folder {
    let folder = Folder::new();
    folder.write("a.png", png(255));
    folder.write("wide.png", textures::wide());
    folder.write("a.tx", textures::TX);
    folder.write("a.nvdb", nvdb());
    folder.write("u.1001.png", png(255));
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    folder.write("a.ply", ply);
    folder
}

#[test]
fn every_feature_gives_the_note_of_its_row() {
    let folder = folder_of_features();
    let rows = features().into_iter().find(|format| format.format == "pbrt").unwrap().rows;
    assert!(rows.len() > 60);
    for row in rows {
        let text = scene_with(row);
        let scene = folder.load(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let kind = match row.support {
            Support::Full => None,
            Support::Approximated => Some(NoteKind::Approximated),
            Support::Ignored => Some(NoteKind::Ignored),
            Support::Refused => panic!("nothing is refused"),
        };
        let expected: Vec<_> = kind
            .map(|kind| (kind, format!("{} {:?}: {}", row.kind, row.name, row.how)))
            .into_iter()
            .collect();
        assert_eq!(notes(&scene), expected, "{text}");
    }
    for unknown in [
        "Shape \"blob\"",
        "LightSource \"torch\"",
        "Material \"velvet\"",
        "Texture \"t\" \"float\" \"noise\"",
    ] {
        let scene = folder.load(&format!("{V4} {unknown} {TRIANGLE}")).unwrap();
        assert_eq!(notes(&scene).len(), 1, "{unknown}: {:?}", notes(&scene));
        assert!(notes(&scene)[0].1.contains("is unknown"));
    }
}

#[test]
fn a_missing_file_is_told_at_the_line_that_names_it() {
    for (text, line) in [
        ("Texture \"t\" \"spectrum\" \"imagemap\"\n\"string filename\" \"gone.png\"", 3),
        ("Shape \"plymesh\"\n\n\"string filename\" \"gone.ply\"", 4),
        ("LightSource \"infinite\"\n\"string filename\" \"gone.exr\"", 3),
        ("LightSource \"goniometric\"\n\"string filename\" \"gone.exr\"", 3),
        ("AreaLightSource \"diffuse\"\n\"string filename\" \"gone.exr\"", 3),
        ("Material \"diffuse\"\n\"string normalmap\" \"gone.png\"", 3),
        ("MakeNamedMedium \"m\" \"string type\" \"nanovdb\"\n\"string filename\" \"gone.nvdb\"", 3),
    ] {
        let scene = scene(&format!("{V4}{text}"));
        let note = scene.notes().iter().find(|n| n.kind == NoteKind::Missing).unwrap();
        assert_eq!(note.first.line, Some(line), "{text}: {}", note.message);
    }
    let scene = scene(&format!("{V4}Material \"diffuse\"\n\"texture reflectance\" \"gone\""));
    let note = scene.notes().iter().find(|n| n.message.contains("is not defined")).unwrap();
    assert_eq!(note.first.line, Some(3));
}
