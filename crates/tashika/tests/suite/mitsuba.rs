//! Mitsuba files: every element has the meaning that the format gives it, tested by numbers.
//!
//! Conventions of textures, cameras, environments and shapes come from Mitsuba 3.9 itself. A test
//! that names Mitsuba 3.9 uses its numbers as expected values.

use std::fs;
use std::sync::OnceLock;

use tashika::bsdf::{CoatModel, FacetModel};
use tashika::color::Rgb;
use tashika::error::Result;
use tashika::io::{Support, features, load_scene};
use tashika::math::{Vec2, Vec3};
use tashika::scene::{
    Alpha, Channel, CoatBase, ColorInput, Emitter, FacetInput, FloatInput, InstanceId, Material, NormalInput,
    NoteKind, Scene, Surface, Texture, TextureId,
};
use tempfile::TempDir;

use crate::cases::lenient;
use crate::textures;

pub type Files<'a> = &'a [(&'a str, &'a [u8])];

/// Creates a folder with `files` and loads its `scene.xml`.
pub fn load_in(files: Files<'_>) -> (TempDir, Result<Scene>) {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    let scene = load_scene(&folder.path().join("scene.xml"), &lenient());
    (folder, scene)
}

/// A scene file with the given body.
pub fn xml(version: &str, body: &str) -> String {
    format!("<scene version=\"{version}\">\n{body}\n</scene>\n")
}

pub fn load_version(version: &str, body: &str, files: Files<'_>) -> Scene {
    let text = xml(version, body);
    let mut all = vec![("scene.xml", text.as_bytes())];
    all.extend_from_slice(files);
    load_in(&all).1.unwrap_or_else(|e| panic!("{e}\n{text}"))
}

pub fn load(body: &str) -> Scene {
    load_version("3.0.0", body, FILES_WITHOUT_IMAGES)
}

/// A volume file in the box from (1, 2, 3) to (2, 4, 6).
pub fn vol(counts: [u32; 3], channels: u32, values: &[f32]) -> Vec<u8> {
    let mut bytes = b"VOL\x03\x01\0\0\0".to_vec();
    counts.iter().chain([&channels]).for_each(|n| bytes.extend(n.to_le_bytes()));
    [1.0, 2.0, 3.0, 2.0, 4.0, 6.0].iter().chain(values).for_each(|v: &f32| bytes.extend(v.to_le_bytes()));
    bytes
}

/// Parameter with the name of such a file.
pub const VOL: &str = "<string name=\"filename\" value=\"a.vol\"/>";

/// The notes that are not about defaults.
pub fn notes(scene: &Scene) -> Vec<(NoteKind, String)> {
    let notes = scene.notes().iter().filter(|n| n.kind != NoteKind::Defaulted);
    notes.map(|n| (n.kind, n.message)).collect()
}

const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
const PLY: &[u8] =
    b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";
const FILES_WITHOUT_IMAGES: Files<'static> = &[("m.obj", OBJ), ("m.ply", PLY)];

/// A PNG of two by two texels, row by row from the top.
pub fn png(texels: [[u8; 4]; 4]) -> Vec<u8> {
    let picture = image::RgbaImage::from_raw(2, 2, texels.concat()).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Four texels: red, green; blue, white.
pub fn four_colours() -> Vec<u8> {
    png([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]])
}

/// A `.serialized` file of version 4 with one triangle, in `f32`.
pub fn serialized() -> Vec<u8> {
    use std::io::Write;
    let mut raw = 0x1000_u32.to_le_bytes().to_vec();
    raw.push(0);
    [3_u64, 1].iter().for_each(|n| raw.extend_from_slice(&n.to_le_bytes()));
    [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .for_each(|v| raw.extend_from_slice(&v.to_le_bytes()));
    [0_u32, 1, 2].iter().for_each(|i| raw.extend_from_slice(&i.to_le_bytes()));
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(&raw).unwrap();
    let mut bytes = vec![0x1c, 0x04, 4, 0];
    bytes.extend(encoder.finish().unwrap());
    bytes.extend_from_slice(&[0; 8]);
    bytes.extend_from_slice(&1_u32.to_le_bytes());
    bytes
}

/// A rectangle with the given bsdf.
fn with_bsdf(version: &str, bsdf: &str) -> Scene {
    let picture = four_colours();
    load_version(version, &format!("<shape type=\"rectangle\">{bsdf}</shape>"), &[("a.png", &picture)])
}

/// Material of a rectangle with the given bsdf.
#[track_caller]
fn material(bsdf: &str) -> Material {
    let scene = with_bsdf("3.0.0", bsdf);
    assert_eq!(notes(&scene), [], "{bsdf}");
    scene.material_of(first_instance()).clone()
}

/// The first instance of any scene. An id can only be obtained from a scene.
fn first_instance() -> InstanceId {
    static FIRST: OnceLock<InstanceId> = OnceLock::new();
    *FIRST.get_or_init(|| {
        let scene = load("<shape type=\"rectangle\"><emitter type=\"area\"/></shape>");
        scene.area_emitters().next().unwrap().0
    })
}

fn color(factor: Rgb) -> ColorInput {
    ColorInput::from(factor)
}

fn texture_of(scene: &Scene) -> TextureId {
    match &scene.material_of(first_instance()).surface {
        Surface::Lambert { reflectance } => reflectance.texture.expect("a texture"),
        other => panic!("{other:?}"),
    }
}

/// Reflectance of a diffuse rectangle's texture at the given coordinates.
fn looked_up(version: &str, texture: &str, at: &[[f32; 2]]) -> Vec<[f32; 3]> {
    let scene = with_bsdf(version, &format!("<bsdf type=\"diffuse\">{texture}</bsdf>"));
    let texture = texture_of(&scene);
    let look = |uv: &[f32; 2]| scene.textures().lookup(texture, Vec2::from_array(*uv)).0.to_array();
    at.iter().map(look).collect()
}

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const GREEN: [f32; 3] = [0.0, 1.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

#[test]
fn images_have_v_down_and_to_uv_is_applied_to_coordinates() {
    let bitmap = |inside: &str| {
        format!(
            "<texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"a.png\"/>\
             <string name=\"filter_type\" value=\"nearest\"/>{inside}</texture>"
        )
    };
    // Mitsuba 3.9: `eval` of the same two by two texels.
    assert_eq!(
        looked_up("3.0.0", &bitmap(""), &[[0.25, 0.25], [0.75, 0.25], [0.25, 0.75]]),
        [RED, GREEN, BLUE]
    );
    let scaled = bitmap("<transform name=\"to_uv\"><scale x=\"2\" y=\"2\"/></transform>");
    assert_eq!(looked_up("3.0.0", &scaled, &[[0.3, 0.1]]), [GREEN]);
    let moved = bitmap("<transform name=\"to_uv\"><translate x=\"0.5\"/></transform>");
    assert_eq!(looked_up("3.0.0", &moved, &[[0.1, 0.1]]), [GREEN]);
    let old = bitmap("<float name=\"uscale\" value=\"2\"/><float name=\"voffset\" value=\"0.5\"/>");
    assert_eq!(looked_up("0.6.0", &old, &[[0.1, 0.1], [0.1, 0.6]]), [BLUE, RED]);
    let clamped = bitmap("<string name=\"wrap_mode\" value=\"clamp\"/>");
    assert_eq!(looked_up("3.0.0", &clamped, &[[1.3, 0.1]]), [GREEN]);
}

#[test]
fn checkerboards_have_two_squares_a_side() {
    let board = "<texture type=\"checkerboard\" name=\"reflectance\">\
                 <rgb name=\"color0\" value=\"1 0 0\"/><rgb name=\"color1\" value=\"0 0 1\"/></texture>";
    let places = [[0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [1.25, 0.25]];
    assert_eq!(looked_up("3.0.0", board, &places), [RED, BLUE, RED, RED]);
}

#[test]
fn raw_images_are_linear() {
    let grey = png([[128, 128, 128, 255]; 4]);
    for (raw, expected) in [("true", 128.0 / 255.0), ("false", 0.215_86)] {
        let body = format!(
            "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">\
             <string name=\"filename\" value=\"a.png\"/><boolean name=\"raw\" value=\"{raw}\"/></texture></bsdf></shape>"
        );
        let scene = load_version("3.0.0", &body, &[("a.png", &grey)]);
        let seen = scene.textures().lookup(texture_of(&scene), Vec2::splat(0.5)).0.g;
        assert!((seen - expected).abs() < 1e-4, "raw {raw}: {seen}");
    }
}

#[test]
fn both_spellings_and_all_forms_of_colours_are_read() {
    let lambert = |value: &str| material(&format!("<bsdf type=\"diffuse\">{value}</bsdf>")).surface;
    let expected = |c: [f32; 3]| Surface::Lambert { reflectance: color(c.into()) };
    assert_eq!(lambert("<rgb name=\"reflectance\" value=\"0.5, 0.2, 0.1\"/>"), expected([0.5, 0.2, 0.1]));
    assert_eq!(lambert("<rgb name=\"reflectance\" value=\"0.25\"/>"), expected([0.25; 3]));
    assert_eq!(lambert("<rgb name=\"reflectance\" value=\"#00ff00\"/>"), expected(GREEN));
    assert_eq!(lambert("<spectrum name=\"diffuseReflectance\" value=\"0.75\"/>"), expected([0.75; 3]));
    let Surface::Lambert { reflectance } =
        lambert("<spectrum name=\"reflectance\" value=\"400:0.5, 700:0.5\"/>")
    else {
        panic!("Lambertian");
    };
    assert!((reflectance.factor.g - 0.5).abs() < 1e-5, "flat spectra are grey: {reflectance:?}");
}

#[test]
fn materials_become_surfaces_with_their_parameters() {
    let glass = material(
        "<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"diamond\"/><float name=\"extIOR\" value=\"1\"/></bsdf>",
    );
    assert_eq!(
        glass.surface,
        Surface::Glass { ior: 2.419, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets: 0.0.into() }
    );
    let plastic = material(
        "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.3\"/><string name=\"distribution\" value=\"ggx\"/>\
         <float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/>\
         <boolean name=\"nonlinear\" value=\"true\"/><rgb name=\"diffuse_reflectance\" value=\"0.2\"/></bsdf>",
    );
    let expected = Surface::Coated {
        reflectance: color(Rgb::gray(0.2)),
        base: CoatBase::Saturating,
        specular: color(Rgb::WHITE),
        ior: 1.5,
        facets: FacetInput::even(0.3.into(), FacetModel::GgxIndependent),
    };
    assert_eq!(plastic.surface, expected);
    let phong = material("<bsdf type=\"phong\"><float name=\"exponent\" value=\"50\"/></bsdf>");
    let expected =
        Surface::Phong { diffuse: color(Rgb::gray(0.5)), specular: color(Rgb::gray(0.2)), exponent: 50.0 };
    assert_eq!(phong.surface, expected);
    let leaf = material("<bsdf type=\"difftrans\"><rgb name=\"transmittance\" value=\"0.25\"/></bsdf>");
    let expected =
        Surface::Translucent { reflectance: color(Rgb::BLACK), transmittance: color(Rgb::gray(0.25)) };
    assert_eq!(leaf.surface, expected);
}

#[test]
fn linear_plastic_is_as_bright_as_mitsuba_makes_it() {
    let Surface::Coated { reflectance, base, facets, .. } = material("<bsdf type=\"plastic\"/>").surface
    else {
        panic!("coated")
    };
    assert_eq!(
        (reflectance.factor, base, facets.alpha),
        (Rgb::gray(0.5), CoatBase::Proportional, FloatInput::from(0.0))
    );
}

#[test]
fn metals_are_known_by_name_and_by_constants() {
    let gold = material("<bsdf type=\"conductor\"><string name=\"material\" value=\"Au\"/></bsdf>").surface;
    let Surface::Conductor { fresnel: tashika::bsdf::ConductorFresnel::Exact { eta, k }, .. } = gold else {
        panic!("{gold:?}");
    };
    // Mitsuba 3.9: eta 0.143, 0.375, 1.442; k 3.98, 2.39, 1.60.
    assert!(eta.r < 0.3 && eta.b > 1.0 && k.r > 3.0 && k.b < 2.2, "{eta:?} {k:?}");
    let none = material("<bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/></bsdf>").surface;
    assert_eq!(none, Surface::Mirror { reflectance: color(Rgb::WHITE) });
    assert_eq!(material("<bsdf type=\"conductor\"/>").surface, none, "the default of Mitsuba 3");
    let old = with_bsdf("0.6.0", "<bsdf type=\"conductor\"/>");
    let copper =
        with_bsdf("0.6.0", "<bsdf type=\"conductor\"><string name=\"material\" value=\"Cu\"/></bsdf>");
    assert_eq!(old.materials()[0].surface, copper.materials()[0].surface, "the default of Mitsuba 0.6");
    let own = material(
        "<bsdf type=\"conductor\"><rgb name=\"eta\" value=\"2\"/><rgb name=\"k\" value=\"4\"/><float name=\"ext_eta\" value=\"2\"/></bsdf>",
    );
    let Surface::Conductor { fresnel: tashika::bsdf::ConductorFresnel::Exact { eta, k }, .. } = own.surface
    else {
        panic!("{own:?}");
    };
    assert_eq!((eta, k), (Rgb::gray(1.0), Rgb::gray(2.0)));
}

#[test]
fn masks_null_and_blends_become_opacity() {
    let opacity = |m: &Material| m.alpha.map(|a: Alpha| a.value);
    let half = material(
        "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.25\"/><bsdf type=\"diffuse\"/></bsdf>",
    );
    assert_eq!(opacity(&half), Some(0.25.into()));
    let blend = |first: &str, second: &str| {
        material(&format!(
            "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.25\"/><bsdf type=\"{first}\"/><bsdf type=\"{second}\"/></bsdf>"
        ))
    };
    assert_eq!(opacity(&blend("null", "diffuse")), Some(0.25.into()));
    assert_eq!(opacity(&blend("diffuse", "null")), Some(0.75.into()));
    let Surface::Mix { amount, .. } = blend("diffuse", "plastic").surface else { panic!("a mix") };
    assert_eq!(amount, 0.25.into());
    let gone = with_bsdf("3.0.0", "<bsdf type=\"null\"/>");
    assert_eq!((gone.instances().len(), notes(&gone)), (0, vec![]));
}

#[test]
fn mixtures_keep_the_shares_of_their_parts() {
    let scene = with_bsdf(
        "0.6.0",
        "<bsdf type=\"mixturebsdf\"><string name=\"weights\" value=\"0.5, 0.25, 0.25\"/><bsdf type=\"diffuse\"/>\
         <bsdf type=\"dielectric\"/><bsdf type=\"conductor\"/></bsdf>",
    );
    let last = scene.materials().last().unwrap();
    let Surface::Mix { first, amount, .. } = last.surface else { panic!("{last:?}") };
    assert_eq!(amount, 0.25.into());
    let Surface::Mix { amount, .. } = scene.materials()[first.index()].surface else { panic!("nested") };
    assert!((amount.factor - 1.0 / 3.0).abs() < 1e-6);
}

#[test]
fn bumps_and_normal_maps_perturb_normals() {
    let nested = "<texture type=\"bitmap\" name=\"normalmap\"><string name=\"filename\" value=\"a.png\"/>\
                  <boolean name=\"raw\" value=\"true\"/></texture><bsdf type=\"diffuse\"/>";
    let map = material(&format!("<bsdf type=\"normalmap\">{nested}</bsdf>"));
    assert!(matches!(map.normal, Some(NormalInput::Map { scale: 1.0, .. })));
    let bump =
        material(&format!("<bsdf type=\"bumpmap\"><float name=\"scale\" value=\"3\"/>{nested}</bsdf>"));
    assert!(matches!(bump.normal, Some(NormalInput::Bump { height }) if height.factor == 3.0));
}

#[test]
fn principled_materials_have_the_reflectance_of_their_specular() {
    let scene = with_bsdf(
        "3.0.0",
        "<bsdf type=\"principled\"><float name=\"specular\" value=\"0.5\"/><float name=\"metallic\" value=\"0.25\"/></bsdf>",
    );
    let Surface::Principled { metallic, roughness, ior, .. } = scene.materials()[0].surface else {
        panic!("{:?}", scene.materials());
    };
    assert_eq!((metallic, roughness), (0.25.into(), 0.5.into()));
    assert!((ior - 1.5).abs() < 1e-6, "reflects 0.04 at normal incidence: {ior}");
    let glass = with_bsdf(
        "3.0.0",
        "<bsdf type=\"principled\"><float name=\"spec_trans\" value=\"1\"/><float name=\"eta\" value=\"1.5\"/></bsdf>",
    );
    assert!(matches!(glass.materials()[0].surface, Surface::Glass { ior: 1.5, .. }));
}

/// The coat lies on every part except glass. Its `α` falls with its gloss, also if the gloss is a
/// texture.
#[test]
fn clear_coats_have_the_roughness_of_their_gloss() {
    let principled = |inside: &str| {
        let coat = "<float name=\"clearcoat\" value=\"0.8\"/>";
        with_bsdf("3.0.0", &format!("<bsdf type=\"principled\">{coat}{inside}</bsdf>"))
    };
    let gloss = |value: &str| principled(&format!("<float name=\"clearcoat_gloss\" value=\"{value}\"/>"));
    for (scene, expected) in [(principled(""), 0.1), (gloss("0.5"), 0.0505), (gloss("1"), 0.001)] {
        let Surface::Clearcoat { base, amount, alpha, model } = scene.materials().last().unwrap().surface
        else {
            panic!("{:?}", scene.materials());
        };
        assert_eq!((amount, model), (0.8.into(), CoatModel::Mitsuba));
        assert!((alpha.factor - expected).abs() < 1e-6, "{alpha:?} for {expected}");
        assert!(matches!(scene.materials()[base.index()].surface, Surface::Principled { .. }));
    }
    let textured = "<texture type=\"bitmap\" name=\"clearcoat_gloss\"><string name=\"filename\" value=\"a.png\"/>\
                    <boolean name=\"raw\" value=\"true\"/></texture>";
    let scene = principled(textured);
    let Surface::Clearcoat { alpha, .. } = scene.materials().last().unwrap().surface else { panic!() };
    let (texture, channel) = alpha.texture.unwrap();
    let Texture::Mix { first, second, amount } = scene.textures().nodes[texture.index()] else { panic!() };
    let value = |id| scene.textures().channel(id, Vec2::new(0.3, 0.6), channel);
    assert!((value(first) - 0.1).abs() < 1e-6 && (value(second) - 0.001).abs() < 1e-6);
    let expected = 0.1 - 0.099 * value(amount);
    assert!((alpha.at(scene.textures(), Vec2::new(0.3, 0.6)) - expected).abs() < 1e-6);

    let sheet = "<bsdf type=\"principledthin\"><float name=\"clearcoat\" value=\"1\"/></bsdf>";
    let notes_of_sheet = notes(&with_bsdf("3.0.0", sheet));
    assert!(
        notes_of_sheet.iter().any(|(_, m)| m.contains("\"clearcoat\" is not used")),
        "{notes_of_sheet:?}"
    );

    let glass = principled("<float name=\"spec_trans\" value=\"0.5\"/><float name=\"eta\" value=\"1.5\"/>");
    let Surface::Mix { first, second, .. } = glass.materials().last().unwrap().surface else { panic!() };
    let kinds = [first, second].map(|id| glass.materials()[id.index()].surface.kind());
    assert_eq!(kinds, ["clear coat", "glass"]);
    assert!(matches!(notes(&glass).as_slice(), [(NoteKind::Approximated, m)] if m.contains("clearcoat")));
}

#[test]
fn transforms_apply_in_the_order_of_the_file() {
    let scene = load(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"2\"/>\
         <rotate x=\"1\" angle=\"90\"/><translate x=\"10\" y=\"20\"/></transform></shape>",
    );
    let b = scene.bounds();
    let close = |a: Vec3, b: Vec3| (a - b).length() < 1e-5;
    assert!(close(b.lo, Vec3::new(8.0, 20.0, -2.0)) && close(b.hi, Vec3::new(12.0, 20.0, 2.0)), "{b:?}");
    let matrix = load(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><matrix value=\"1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1\"/></transform></shape>",
    );
    assert!(close(matrix.bounds().lo, Vec3::new(4.0, 5.0, 7.0)));
}

/// World normal of the first triangle of the only instance.
fn normal(scene: &Scene) -> Vec3 {
    scene.surface_point(first_instance(), 0, [0.3, 0.3, 0.4]).geometric_normal
}

#[test]
fn meshes_face_the_side_that_mitsuba_lets_them_face() {
    let facing = |kind: &str, inside: &str| {
        let name = if kind == "rectangle" {
            String::new()
        } else {
            format!("<string name=\"filename\" value=\"m.{kind}\"/>")
        };
        normal(&load(&format!("<shape type=\"{kind}\">{name}{inside}</shape>"))).z
    };
    let mirror = "<transform name=\"to_world\"><scale x=\"-1\" y=\"1\" z=\"1\"/></transform>";
    let flip = "<boolean name=\"flip_normals\" value=\"true\"/>";
    let flat = "<boolean name=\"face_normals\" value=\"true\"/>";
    for kind in ["obj", "ply"] {
        for extra in ["", flat] {
            assert_eq!(facing(kind, extra), 1.0, "{kind}");
            assert_eq!(facing(kind, &format!("{flip}{extra}")), -1.0, "{kind}");
            assert_eq!(
                facing(kind, &format!("{mirror}{extra}")),
                -1.0,
                "{kind}: by the order of its vertices in the world"
            );
        }
    }
    assert_eq!(
        (facing("rectangle", ""), facing("rectangle", mirror), facing("rectangle", flip)),
        (1.0, 1.0, -1.0)
    );
}

#[test]
fn coordinates_of_obj_files_are_turned_over_and_others_are_not() {
    let uvs = |kind: &str, inside: &str| {
        let shape =
            format!("<shape type=\"{kind}\"><string name=\"filename\" value=\"m.{kind}\"/>{inside}</shape>");
        load(&shape).meshes()[0].uvs()[0]
    };
    let off = "<boolean name=\"flip_tex_coords\" value=\"false\"/>";
    assert_eq!((uvs("obj", ""), uvs("obj", off), uvs("ply", "")), (Vec2::Y, Vec2::ZERO, Vec2::ZERO));
}

#[test]
fn primitives_have_mitsubas_place_and_coordinates() {
    let scene = |shape: &str| load(&format!("<shape {shape}</shape>"));
    let sphere = scene(
        "type=\"sphere\"><point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/><float name=\"radius\" value=\"2\"/>",
    );
    let b = sphere.bounds();
    assert!(
        (b.lo - Vec3::new(-1.0, 0.0, 1.0)).length() < 0.02
            && (b.hi - Vec3::new(3.0, 4.0, 5.0)).length() < 0.02
    );
    let cylinder = scene(
        "type=\"cylinder\"><point name=\"p0\" value=\"0 0 1\"/><point name=\"p1\" value=\"4 0 1\"/><float name=\"radius\" value=\"0.5\"/>",
    );
    let b = cylinder.bounds();
    assert!(
        (b.lo - Vec3::new(0.0, -0.5, 0.5)).length() < 0.02
            && (b.hi - Vec3::new(4.0, 0.5, 1.5)).length() < 0.02,
        "{b:?}"
    );
    // Mitsuba 3.9: coordinates where rays meet the shapes.
    for (shape, place, expected) in [
        ("sphere", [0.3, 0.2, 0.933], [0.094, 0.117]),
        ("sphere", [0.933, 0.2, 0.3], [0.034, 0.403]),
        ("disk", [0.3, 0.2, 0.0], [0.361, 0.094]),
        ("cylinder", [0.98, 0.2, 0.3], [0.032, 0.3]),
        ("rectangle", [0.3, 0.2, 0.0], [0.65, 0.6]),
        ("cube", [0.3, 0.2, 1.0], [0.6, 0.65]),
        ("cube", [1.0, 0.2, 0.3], [0.6, 0.35]),
    ] {
        let scene = scene(&format!("type=\"{shape}\">"));
        let uv = uv_at(&scene, Vec3::from_array(place));
        assert!((uv - Vec2::from_array(expected)).length() < 0.01, "{shape} {place:?}: {uv}");
    }
}

/// Texture coordinates at the point of the first mesh that is nearest to `place`.
fn uv_at(scene: &Scene, place: Vec3) -> Vec2 {
    let mesh = &scene.meshes()[0];
    let steps = (100_000 / mesh.triangles().len()).isqrt() as u32;
    let mut best = (f32::INFINITY, Vec2::ZERO);
    for t in 0..mesh.triangles().len() as u32 {
        for i in 0..=steps {
            for j in 0..=steps - i {
                let (b, c) = (i as f32 / steps as f32, j as f32 / steps as f32);
                let point = scene.surface_point(first_instance(), t, [1.0 - b - c, b, c]);
                let distance = (point.position - place).length();
                if distance < best.0 {
                    best = (distance, point.uv);
                }
            }
        }
    }
    best.1
}

#[test]
fn groups_are_stored_once_and_placed_often() {
    let scene = load(
        "<shape type=\"shapegroup\" id=\"g\"><shape type=\"cube\"><transform name=\"to_world\"><scale value=\"0.5\"/></transform></shape>\
         <shape type=\"ply\"><string name=\"filename\" value=\"m.ply\"/></shape></shape>\
         <shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\"><translate x=\"10\"/></transform></shape>\
         <shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\"><translate x=\"20\"/></transform></shape>",
    );
    assert_eq!((scene.meshes().len(), scene.instances().len()), (2, 4));
    assert_eq!((scene.bounds().lo.x, scene.bounds().hi.x), (9.5, 21.0));
    assert_eq!(notes(&scene), []);
    let shared = load(
        "<bsdf type=\"diffuse\" id=\"m\"/><shape type=\"sphere\"><ref id=\"m\"/></shape><shape type=\"sphere\"><ref id=\"m\"/><point name=\"center\" x=\"5\" y=\"0\" z=\"0\"/></shape>",
    );
    assert_eq!((shared.meshes().len(), shared.instances().len()), (1, 2));
}

#[test]
fn shapes_emit_and_lights_are_placed() {
    let scene = load(
        "<shape type=\"rectangle\"><emitter type=\"area\"><rgb name=\"radiance\" value=\"18, 11, 3\"/></emitter></shape>\
         <emitter type=\"point\"><point name=\"position\" x=\"1\" y=\"2\" z=\"3\"/><rgb name=\"intensity\" value=\"4\"/></emitter>\
         <emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"40\"/><float name=\"beam_width\" value=\"20\"/>\
         <transform name=\"to_world\"><lookat origin=\"0 0 2\" target=\"0 0 0\" up=\"0 1 0\"/></transform></emitter>\
         <emitter type=\"directional\"><vector name=\"direction\" x=\"0\" y=\"-2\" z=\"0\"/><rgb name=\"irradiance\" value=\"2\"/></emitter>",
    );
    assert_eq!(notes(&scene), []);
    let (_, emission) = scene.area_emitters().next().unwrap();
    assert_eq!(emission.radiance.factor, Rgb::new(18.0, 11.0, 3.0));
    let [point, spot, directional] = scene.emitters() else { panic!("{:?}", scene.emitters()) };
    assert_eq!(*point, Emitter::Point { position: Vec3::new(1.0, 2.0, 3.0), intensity: Rgb::gray(4.0) });
    assert_eq!(*directional, Emitter::Directional { direction: Vec3::NEG_Y, irradiance: Rgb::gray(2.0) });
    let Emitter::Spot { position, axis, falloff, .. } = *spot else { panic!("{spot:?}") };
    assert!((position - Vec3::Z * 2.0).length() < 1e-6 && (axis - Vec3::NEG_Z).length() < 1e-6);
    // Mitsuba 3.9: `sample_direction` at points below the light, by their distance from its axis.
    for (x, expected) in [(0.6, 1.0), (0.8, 0.909_93), (0.9, 0.788_61), (1.2, 0.451_81), (1.5, 0.156_51)] {
        let cos = 2.0 / (4.0_f32 + x * x).sqrt();
        assert!((falloff.at(cos) - expected).abs() < 2e-3, "{x}: {}", falloff.at(cos));
    }
}

#[test]
fn emission_spectra_keep_their_unit() {
    let radiance = |value: &str| {
        let scene = load(&format!("<emitter type=\"constant\">{value}</emitter>"));
        scene.environment().unwrap().mean().to_array()
    };
    let near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 0.02);
    assert_eq!(radiance("<float name=\"radiance\" value=\"2\"/>"), [2.0; 3]);
    assert_eq!(radiance("<rgb name=\"radiance\" value=\"1 2 3\"/>"), [1.0, 2.0, 3.0]);
    // Mitsuba 3.9 in its RGB mode, and Planck's law at 555 nm and 5000 K: 12.4 kW·m⁻²·sr⁻¹·nm⁻¹.
    let samples = radiance("<spectrum name=\"radiance\" value=\"400:0, 500:8, 600:15.6, 700:18.4\"/>");
    assert!(near(samples, [20.71, 10.85, 2.77]), "{samples:?}");
    let hot = radiance("<blackbody name=\"radiance\" temperature=\"5000K\" scale=\"0.001\"/>");
    assert!((hot[1] / 12.2 - 1.0).abs() < 0.05 && hot[0] > hot[1] && hot[1] > hot[2], "{hot:?}");
}

#[test]
fn environment_maps_have_mitsubas_axes() {
    // A map of 16 × 8 with one bright texel; the directions are those in which Mitsuba 3.9 sees it.
    for (row, column, direction) in
        [(1, 2, [0.356, 0.903, -0.24]), (4, 5, [0.808, -0.224, 0.545]), (6, 13, [-0.356, -0.903, -0.24])]
    {
        let mut picture = image::RgbImage::new(16, 8);
        picture.put_pixel(column, row, image::Rgb([255; 3]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        let body = "<emitter type=\"envmap\"><string name=\"filename\" value=\"e.png\"/><float name=\"scale\" value=\"2\"/></emitter>";
        let scene = load_version("3.0.0", body, &[("e.png", &bytes.into_inner())]);
        let seen = scene.environment().unwrap().radiance(Vec3::from_array(direction).normalize()).g;
        assert!(seen > 1.0, "{row} {column}: {seen}");
    }
}

/// A turned map of 16×8 whose texel in row 2 and column 5 is bright. Expected directions are those
/// in which Mitsuba 3.9.1 sees its centre. Mitsuba's rows reach from pole to pole, so that they are
/// up to half a row nearer to the poles than here.
#[test]
fn environment_maps_are_turned_as_mitsuba_turns_them() {
    let mut bytes = b"PF\n16 8\n-1.0\n".to_vec();
    for i in 0..16 * 8 {
        let texel = if i == 5 * 16 + 5 { [100.0f32, 50.0, 25.0] } else { [0.0; 3] };
        bytes.extend(texel.iter().flat_map(|v| v.to_le_bytes()));
    }
    for (transform, direction) in [
        ("", [0.6607, 0.6071, 0.4415]),
        ("<rotate x=\"1\" angle=\"90\"/>", [0.6607, -0.4415, 0.6071]),
        ("<rotate y=\"1\" angle=\"40\"/>", [0.79, 0.6071, -0.0858]),
        ("<scale x=\"-1\"/><rotate z=\"1\" angle=\"30\"/>", [-0.8757, 0.1955, 0.4415]),
    ] {
        let body = format!(
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"e.pfm\"/><float name=\"scale\" value=\"2\"/>\
             <transform name=\"to_world\">{transform}</transform></emitter>"
        );
        let scene = load_version("3.0.0", &body, &[("e.pfm", &bytes)]);
        let seen = scene.environment().unwrap().radiance(Vec3::from(direction).normalize());
        assert!(seen.r > 160.0 && (seen.g / seen.r - 0.5).abs() < 1e-4, "{transform:?}: {seen:?}");
    }
}

#[test]
fn skies_have_their_up_where_the_version_has_it() {
    for (version, up, side) in [("3.0.0", Vec3::Z, Vec3::X), ("0.6.0", Vec3::Y, Vec3::X)] {
        let to_sun = (up + side).normalize();
        let body = format!(
            "<emitter type=\"sunsky\"><float name=\"turbidity\" value=\"3\"/><vector name=\"sun_direction\" x=\"{}\" y=\"{}\" z=\"{}\"/></emitter>",
            to_sun.x, to_sun.y, to_sun.z
        );
        let scene = load_version(version, &body, &[]);
        let sky = scene.environment().unwrap();
        assert!(sky.radiance(to_sun).luminance() > 2.0 * sky.radiance((up - side).normalize()).luminance());
        assert!(sky.radiance(-up).is_black());
        let [Emitter::Directional { direction, irradiance }] = scene.emitters() else { panic!("a sun") };
        assert!((*direction + to_sun).length() < 1e-5 && irradiance.r > irradiance.b);
    }
}

#[test]
fn defaults_includes_and_aliases_are_followed() {
    let part = xml(
        "3.0.0",
        "<default name=\"r\" value=\"0.75\"/><bsdf type=\"diffuse\" id=\"m\"><rgb name=\"reflectance\" value=\"$r\"/></bsdf><alias id=\"m\" as=\"n\"/>",
    );
    let body = "<default name=\"r\" value=\"0.25\"/><default name=\"kind\" value=\"path\"/><integrator type=\"$kind\"/>\
                <include filename=\"parts/part.xml\"/><shape type=\"rectangle\"><ref id=\"n\"/></shape>";
    let scene = load_version("3.0.0", body, &[("parts/part.xml", part.as_bytes())]);
    assert_eq!(notes(&scene), []);
    let expected = Surface::Lambert { reflectance: color(Rgb::gray(0.25)) };
    assert_eq!(scene.materials()[0].surface, expected, "what is set first counts");
    let missing = load(
        "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"$r\"/></bsdf></shape>",
    );
    assert_eq!(missing.materials()[0].surface, Surface::Lambert { reflectance: color(Rgb::gray(0.5)) });
    assert!(
        matches!(notes(&missing).as_slice(), [(NoteKind::Repaired, m)] if m.contains("$r has no default"))
    );
}

#[test]
fn files_are_found_beside_the_scene_and_in_paths() {
    let part = xml("3.0.0", "<shape type=\"ply\"><string name=\"filename\" value=\"p.ply\"/></shape>");
    let body = "<path value=\"data\"/><include filename=\"parts/part.xml\"/>\
                <shape type=\"obj\"><string name=\"filename\" value=\"q.obj\"/></shape>";
    let files: Files<'_> = &[("parts/part.xml", part.as_bytes()), ("parts/p.ply", PLY), ("data/Q.OBJ", OBJ)];
    let scene = load_version("3.0.0", body, files);
    assert_eq!((scene.meshes().len(), notes(&scene)), (2, vec![]));
    let none = load(
        "<shape type=\"obj\"><string name=\"filename\" value=\"none.obj\"/></shape><shape type=\"cube\"/>",
    );
    assert_eq!(none.meshes().len(), 1);
    assert!(
        matches!(notes(&none).as_slice(), [(NoteKind::Missing, m)] if m.contains("none.obj") && m.contains("left out"))
    );
}

#[test]
fn what_is_not_used_is_noted() {
    let scene = load(
        "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><float name=\"shine\" value=\"1\"/></bsdf><float name=\"weight\" value=\"1\"/></shape>",
    );
    let expected = [
        "bsdf \"diffuse\": parameter \"shine\" is not used",
        "shape \"rectangle\": parameter \"weight\" is not used",
    ];
    assert_eq!(notes(&scene), expected.map(|m| (NoteKind::Ignored, m.to_owned())));
    let first = scene.notes().iter().find(|n| n.message.contains("shine")).unwrap().first;
    assert_eq!((first.line, first.column), (Some(2), Some(46)));
    let unknown = load(
        "<shape type=\"rectangle\"><bsdf type=\"velvet\"/></shape><shape type=\"teapot\"/><emitter type=\"torch\"/>",
    );
    let all = notes(&unknown);
    assert_eq!(all.len(), 3, "{all:?}");
    assert!(all.iter().all(|(kind, m)| *kind == NoteKind::Ignored && m.contains("is unknown")));
}

/// The files of [`example`].
pub fn files_of_examples() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("a.png", four_colours()),
        ("alpha.png", png([[9, 9, 9, 0]; 4])),
        ("wide.png", textures::wide()),
        ("a.tx", textures::TX.to_vec()),
        ("u.1001.png", four_colours()),
        ("m.obj", OBJ.to_vec()),
        ("m.ply", PLY.to_vec()),
        ("m.serialized", serialized()),
        ("a.vol", vol([1, 2, 1], 1, &[0.5, 0.25])),
    ]
}

/// Body of a scene with the feature that a row describes.
pub fn example(kind: &str, name: &str) -> String {
    let bitmap = |slot: &str, inside: &str| {
        format!(
            "<texture type=\"bitmap\" name=\"{slot}\"><string name=\"filename\" value=\"a.png\"/>{inside}</texture>"
        )
    };
    let shape = |bsdf: String| format!("<shape type=\"rectangle\">{bsdf}</shape>");
    let diffuse = "<bsdf type=\"diffuse\"/>";
    let ggx = "<string name=\"distribution\" value=\"ggx\"/>";
    let bsdf = |plugin: &str, inside: &str| shape(format!("<bsdf type=\"{plugin}\">{inside}</bsdf>"));
    let textured = |texture: String| bsdf("diffuse", &texture);
    let film = |plugin: &str| format!("<sensor type=\"perspective\"><film type=\"{plugin}\"/></sensor>");
    let medium = |plugin: &str, inside: &str| {
        let medium = shape(format!("<medium type=\"{plugin}\" name=\"interior\">{inside}</medium>"));
        format!("<integrator type=\"volpath\"/>{medium}")
    };
    match (kind, name) {
        ("material", "anisotropic roughness") => {
            bsdf("roughplastic", &format!("{ggx}<float name=\"alpha_u\" value=\"0.1\"/><float name=\"alpha_v\" value=\"0.2\"/>"))
        }
        ("material", "principled anisotropic") => {
            let textured = bitmap("anisotropic", "");
            bsdf("principled", &format!("<float name=\"spec_trans\" value=\"1\"/>{textured}"))
        }
        ("material", "twosided" | "mask" | "bumpmap" | "coating") => bsdf(name, diffuse),
        ("material", "roughcoating") => bsdf(name, &format!("{ggx}{diffuse}")),
        ("material", "normalmap") => bsdf(name, &format!("{}{diffuse}", bitmap("normalmap", ""))),
        ("material", "blendbsdf") => bsdf(name, &format!("<float name=\"weight\" value=\"0.5\"/>{}", diffuse.repeat(2))),
        ("material", "mixturebsdf") => bsdf(name, &format!("<string name=\"weights\" value=\"0.5 0.5\"/>{}", diffuse.repeat(2))),
        ("material", "roughconductor" | "roughplastic") => bsdf(name, ggx),
        ("material", distribution) if distribution.starts_with("distribution ") => {
            let name = &distribution["distribution ".len()..];
            bsdf("roughplastic", &format!("<string name=\"distribution\" value=\"{name}\"/>"))
        }
        ("material", _) => bsdf(name, ""),
        ("texture", "bitmap") => textured(bitmap("reflectance", "")),
        ("texture", "bitmap of 16 bits") => textured(bitmap("reflectance", "").replace("a.png", "wide.png")),
        ("texture", "bitmap <UDIM>") => {
            textured(bitmap("reflectance", "").replace("a.png", "u.&lt;UDIM&gt;.png"))
        }
        ("texture", "bitmap .tx") => textured(bitmap("reflectance", "").replace("a.png", "a.tx")),
        ("texture", "filter ewa") => textured(bitmap("reflectance", "<string name=\"filter_type\" value=\"ewa\"/>")),
        ("texture", "wrap one") => textured(bitmap("reflectance", "<string name=\"wrap_mode\" value=\"one\"/>")).replace("wrap_mode", "wrap_mode_u"),
        ("texture", "opacity of an image with alpha") => {
            let opacity = "<texture type=\"bitmap\" name=\"opacity\"><string name=\"filename\" value=\"alpha.png\"/></texture>";
            bsdf("mask", &format!("{opacity}{diffuse}"))
        }
        ("texture", "scale") => {
            let inner = bitmap("", "");
            textured(format!("<texture type=\"scale\" name=\"reflectance\"><float name=\"scale\" value=\"0.5\"/>{inner}</texture>"))
        }
        ("texture", "regular") => textured("<spectrum type=\"regular\" name=\"reflectance\"><string name=\"values\" value=\"0.5 0.6\"/></spectrum>".into()),
        ("texture", "irregular") => textured(
            "<spectrum type=\"irregular\" name=\"reflectance\"><string name=\"wavelengths\" value=\"400 700\"/><string name=\"values\" value=\"0.5 0.6\"/></spectrum>".into(),
        ),
        ("texture", "blackbody") => "<emitter type=\"constant\"><spectrum type=\"blackbody\" name=\"radiance\"/></emitter>".into(),
        ("texture", _) => textured(format!("<texture type=\"{name}\" name=\"reflectance\"/>")),
        ("shape", "obj" | "ply" | "serialized") => {
            format!("<shape type=\"{name}\"><string name=\"filename\" value=\"m.{name}\"/></shape>")
        }
        ("shape", "max_smooth_angle") => {
            "<shape type=\"ply\"><string name=\"filename\" value=\"m.ply\"/><float name=\"max_smooth_angle\" value=\"10\"/></shape>".into()
        }
        ("shape", "shapegroup" | "instance") => {
            "<shape type=\"shapegroup\" id=\"g\"><shape type=\"cube\"/></shape><shape type=\"instance\"><ref id=\"g\"/></shape>".into()
        }
        ("shape", "merge") => "<shape type=\"merge\"><shape type=\"cube\"/></shape>".into(),
        ("shape", _) => format!("<shape type=\"{name}\"/>"),
        ("light", "area" | "directionalarea") => shape(format!("<emitter type=\"{name}\"/>")),
        ("light", "spot texture") => format!("<emitter type=\"spot\">{}</emitter>", bitmap("texture", "")),
        ("light", "envmap") => "<emitter type=\"envmap\"><string name=\"filename\" value=\"a.png\"/></emitter>".into(),
        ("light", "second environment") => {
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"a.png\"/></emitter>".repeat(2)
        }
        ("light", _) => format!("<emitter type=\"{name}\"/>"),
        ("camera", _) => format!("<sensor type=\"{name}\"/>"),
        ("film", _) => film(name),
        ("medium", "dipole" | "singlescatter") => shape(format!("<subsurface type=\"{name}\"/>")),
        ("medium", "homogeneous material") => medium("homogeneous", "<string name=\"material\" value=\"Skimmilk\"/>"),
        ("medium", _) => medium(name, ""),
        ("volume", _) => {
            let (plugin, asked) = name.split_once(' ').unwrap_or((name, ""));
            let inside = match (plugin, asked) {
                ("constvolume", _) => "<float name=\"value\" value=\"0.5\"/>".to_owned(),
                (_, "") => VOL.to_owned(),
                (_, "nearest") => format!("{VOL}<string name=\"filter_type\" value=\"nearest\"/>"),
                (_, wrap) => format!("{VOL}<string name=\"wrap_mode\" value=\"{wrap}\"/>"),
            };
            medium("homogeneous", &format!("<volume type=\"{plugin}\" name=\"albedo\">{inside}</volume>"))
        }
        ("phase function", _) => medium("homogeneous", &format!("<phase type=\"{name}\"/>")),
        _ => panic!("no example of {kind} {name:?}"),
    }
}

#[test]
fn every_feature_gives_the_note_that_its_row_promises() {
    let files = files_of_examples();
    let files: Vec<_> = files.iter().map(|(name, bytes)| (*name, &bytes[..])).collect();
    let table = features().into_iter().find(|f| f.format == "Mitsuba").unwrap();
    assert!(table.rows.len() > 100);
    for row in table.rows {
        let (kind, name) = (row.kind, row.name);
        // Only the older versions have media of a named substance.
        let version = if name == "homogeneous material" { "0.6.0" } else { "3.0.0" };
        let scene = load_version(version, &example(kind, name), &files);
        let promised = match row.support {
            Support::Full => None,
            Support::Approximated => Some(NoteKind::Approximated),
            Support::Ignored => Some(NoteKind::Ignored),
            Support::Refused => panic!("{kind} {name:?}: nothing is refused"),
        };
        let promised: Vec<_> =
            promised.map(|note| (note, format!("{kind} {name:?}: {}", row.how))).into_iter().collect();
        assert_eq!(notes(&scene), promised, "{kind} {name:?}");
    }
}

#[test]
fn channels_of_images_are_chosen_by_name() {
    let scene = with_bsdf(
        "0.6.0",
        "<bsdf type=\"mask\"><texture type=\"bitmap\" name=\"opacity\"><string name=\"filename\" value=\"a.png\"/>\
         <string name=\"channel\" value=\"g\"/></texture><bsdf type=\"diffuse\"/></bsdf>",
    );
    let alpha = scene.materials()[0].alpha.unwrap();
    assert!(matches!(alpha.value.texture, Some((_, Channel::G))));
}

#[test]
fn names_and_places_of_one_long_line_are_read_in_time() {
    // A hundred thousand elements in one line. If the column of each were counted from the start of
    // the line, a second would become an hour.
    let line = "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.5\"/></bsdf>".repeat(50_000);
    let scene = load(&format!("{line}<shape type=\"cube\"><bsdf type=\"velvet\"/></shape>"));
    let first = scene.notes().iter().find(|n| n.message.contains("velvet")).unwrap().first;
    assert_eq!((first.line, first.column), (Some(2), Some(line.len() as u32 + 20)));
}

/// Shapes without a bsdf are grey in Mitsuba 3 and 0.6, and lamps black. With grey lamps, the
/// picture of a simple room would be 1 % brighter.
#[test]
fn shapes_without_a_bsdf_are_grey_and_lamps_black() {
    let lamp = "<emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter>";
    for (inside, reflectance) in [("", 0.5), (lamp, 0.0)] {
        let scene = load(&format!("<shape type=\"rectangle\">{inside}</shape>"));
        let material = &scene.materials()[scene.meshes()[0].material.index()];
        assert_eq!(material.surface, Surface::Lambert { reflectance: color(Rgb::gray(reflectance)) });
    }
}

/// Expected numbers are those of the RGB variants of Mitsuba 3.9.1, to four digits.
#[test]
fn a_spectrum_of_one_number_is_equal_energy_in_emitters_since_version_3() {
    let spectrum = "<spectrum name=\"radiance\" value=\"2\"/>";
    let float = "<float name=\"radiance\" value=\"2\"/>";
    for (version, value, expected) in [
        ("3.0.0", spectrum, [1.2048, 0.9483, 0.9089]),
        ("3.0.0", float, [1.0; 3]),
        ("2.0.0", spectrum, [1.0; 3]),
        ("0.6.0", spectrum, [1.0; 3]),
    ] {
        let body = format!("<shape type=\"rectangle\"><emitter type=\"area\">{value}</emitter></shape>");
        let scene = load_version(version, &body, &[]);
        let found = scene.materials()[0].emission.unwrap().radiance.factor.to_array();
        for (found, expected) in found.iter().zip(expected) {
            assert!((0.5 * found - expected).abs() < 1e-4, "{version} {value}: {found} for {expected}");
        }
    }
    // A reflectance is adapted to white; a plain number stays as it is.
    let body = "<shape type=\"rectangle\"><bsdf type=\"roughplastic\"><spectrum name=\"diffuse_reflectance\" value=\"0.25\"/>\
                <spectrum name=\"alpha\" value=\"0.5\"/></bsdf></shape>";
    let Surface::Coated { reflectance, facets, .. } = load(body).materials()[0].surface else { panic!() };
    assert!(reflectance.factor == Rgb::gray(0.25) && (facets.alpha.factor - 0.5).abs() < 1e-6);
}

#[test]
fn a_missing_image_is_told_at_the_line_that_names_it() {
    let body = "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">\n\
                <string name=\"filename\" value=\"gone.png\"/></texture></bsdf></shape>";
    let scene = load(body);
    let note = scene.notes().iter().find(|n| n.kind == NoteKind::Missing).unwrap();
    assert_eq!(note.first.line, Some(3), "{}", note.message);
}
