//! Materials of glTF files beyond the core: textures, layers, vertex colours, in numbers.

use glam::{Vec2, Vec3};
use serde_json::{Value, json};
use tashika::bsdf::CoatModel;
use tashika::color::Rgb;
use tashika::scene::{
    Channel, ColorInput, FloatInput, Material, NormalInput, NoteKind, Pixels, Sampling, Scene, Surface,
    TangentInput, Texture,
};

use super::gltf::{CORNERS, Document, notes, only_note, surface_of};

/// Left and right texel of the texture of [`textured`].
const TEXELS: [[u8; 4]; 2] = [[51, 102, 204, 153], [255, 255, 0, 255]];

/// A triangle whose material uses texture 0 with nearest-texel sampling. The texels are centred at
/// u = 0.25 and 0.75.
fn textured(material: Value) -> Scene {
    let mut d = Document::triangle();
    d.add_uvs("TEXCOORD_0");
    let texture = d.add_texture(TEXELS);
    d.json["samplers"] = json!([{ "magFilter": 9728 }]);
    d.json["textures"][texture]["sampler"] = json!(0);
    d.json["materials"][0] = material;
    d.load().unwrap()
}

fn used(scene: &Scene) -> &Material {
    &scene.materials()[scene.meshes()[0].material.index()]
}

const LEFT: Vec2 = Vec2::new(0.25, 0.5);
const RIGHT: Vec2 = Vec2::new(0.75, 0.5);

fn number(scene: &Scene, input: FloatInput) -> [f32; 2] {
    [LEFT, RIGHT].map(|uv| input.at(scene.textures(), uv))
}

fn color(scene: &Scene, input: ColorInput) -> [Rgb; 2] {
    [LEFT, RIGHT].map(|uv| input.at(scene.textures(), uv))
}

#[track_caller]
fn near(a: [f32; 2], b: [f32; 2]) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5), "{a:?} for {b:?}");
}

/// Linear value of an 8-bit sRGB code.
fn linear(byte: u8) -> f32 {
    tashika::color::srgb_decode(f32::from(byte) / 255.0)
}

/// A dielectric of the given roughness with the given extensions.
fn dielectric(roughness: f32, extensions: Value) -> Value {
    let base =
        json!({ "baseColorFactor": [0.5, 0.6, 0.7, 1], "metallicFactor": 0, "roughnessFactor": roughness });
    json!({ "pbrMetallicRoughness": base, "extensions": extensions })
}

const BASE: Rgb = Rgb::new(0.5, 0.6, 0.7);

#[test]
fn normal_maps_turn_the_normal_up_where_green_is_bright() {
    let mut d = Document::empty();
    d.push("nodes", json!({ "mesh": 0 }));
    // A wall in z = 0 seen from +z; v runs down, as in glTF.
    let positions = d.vec3(&CORNERS);
    let bytes: Vec<u8> =
        [[0.0_f32, 1.0], [1.0, 1.0], [0.0, 0.0]].iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    let view = d.view(&bytes);
    let uvs =
        d.push("accessors", json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC2" }));
    let texture = d.add_texture([[128, 204, 204, 255]; 2]);
    d.push(
        "materials",
        json!({ "normalTexture": { "index": texture, "scale": 0.5 }, "emissiveFactor": [1, 1, 1] }),
    );
    let attributes = json!({ "POSITION": positions, "TEXCOORD_0": uvs });
    d.push("meshes", json!({ "primitives": [{ "attributes": attributes, "material": 0 }] }));
    let scene = d.load().unwrap();
    assert!(notes(&scene).is_empty(), "{:?}", notes(&scene));
    let Some(NormalInput::Map { scale, .. }) = used(&scene).normal else { panic!("{:?}", used(&scene)) };
    assert_eq!(scale, 0.5);
    assert!(matches!(&scene.images()[0].pixels, Pixels::Linear8(_)), "numbers, not colours");
    let instance = scene.area_emitters().next().unwrap().0;
    let normal = scene.surface_point(instance, 0, [1.0 / 3.0; 3]).shading_normal;
    // Green 0.6 is halved, blue is 0.6: the normal turns upward by atan(0.5).
    assert!((normal - Vec3::new(0.0, 1.0, 2.0).normalize()).length() < 0.01, "{normal}");
}

#[test]
fn samplers_choose_the_nearest_texel_or_four() {
    let base = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } });
    let scene = textured(base);
    let image = |scene: &Scene| match scene.textures().nodes[0] {
        Texture::Image(lookup) => lookup.sampling,
        other => panic!("{other:?}"),
    };
    assert_eq!(image(&scene), Sampling::Nearest);
    let Surface::MetallicRoughness { base_color, .. } = used(&scene).surface else { panic!() };
    let near_the_border = base_color.at(scene.textures(), Vec2::new(0.49, 0.5));
    assert!((near_the_border.r - linear(51)).abs() < 1e-6, "{near_the_border:?}");
    for filter in [json!(9729), json!(null)] {
        let mut d = Document::triangle();
        d.add_uvs("TEXCOORD_0");
        let texture = d.add_texture(TEXELS);
        d.json["samplers"] = json!([{ "magFilter": filter, "minFilter": 9728 }]);
        d.json["textures"][texture]["sampler"] = json!(0);
        d.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorTexture": { "index": 0 } });
        assert_eq!(image(&d.load().unwrap()), Sampling::Bilinear);
    }
}

#[test]
fn specular_textures_multiply_the_reflectance() {
    let specular = json!({
        "specularFactor": 0.5, "specularTexture": { "index": 0 },
        "specularColorFactor": [1, 0.5, 1], "specularColorTexture": { "index": 0 },
    });
    let scene = textured(json!({ "extensions": { "KHR_materials_specular": specular } }));
    assert!(notes(&scene).is_empty(), "{:?}", notes(&scene));
    let Surface::MetallicRoughness { specular_f0, .. } = used(&scene).surface else { panic!() };
    let [left, right] = color(&scene, specular_f0);
    near([left.r, left.g], [0.04 * linear(51), 0.02 * linear(102)]);
    near([right.r, right.b], [0.04, 0.0]);
}

/// A dielectric with specular strength `s` becomes a mix: the share `s` has a specular reflection,
/// the rest is diffuse only. The metal part keeps its full reflection.
#[test]
fn the_strength_of_a_reflection_is_a_share() {
    for (metallic, share, metal) in [(0.0, 0.25, 0.0), (0.5, 0.625, 0.8)] {
        let (scene, surface) = {
            let mut material =
                dielectric(0.5, json!({ "KHR_materials_specular": { "specularFactor": 0.25 } }));
            material["pbrMetallicRoughness"]["metallicFactor"] = json!(metallic);
            let mut d = Document::triangle();
            d.json["materials"][0] = material;
            let scene = d.load().unwrap();
            let surface = used(&scene).surface;
            (scene, surface)
        };
        let Surface::Mix { first, second, amount } = surface else { panic!("{surface:?}") };
        let [below, above] = [first, second].map(|id| scene.materials()[id.index()].surface);
        assert_eq!(below, Surface::Lambert { reflectance: BASE.into() });
        let Surface::MetallicRoughness { metallic, specular_f0, .. } = above else { panic!("{above:?}") };
        near([amount.factor, metallic.factor], [share, metal]);
        near([specular_f0.factor.r, specular_f0.factor.b], [0.04, 0.04]);
    }
}

#[test]
fn transmission_without_thickness_is_a_pane_of_the_base_colour() {
    let extensions = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 1.33 } });
    let (pane, said) = surface_of(dielectric(0.05, extensions));
    let white = Rgb::WHITE.into();
    let Surface::ThinGlass { ior, reflectance, transmittance, facets } = pane else { panic!("{pane:?}") };
    assert_eq!((reflectance, transmittance, facets), (white, BASE.into(), 0.0.into()));
    // The two faces together reflect as much as one face of index 1.33.
    let [one, each] = [1.33, ior].map(|n: f32| ((n - 1.0) / (n + 1.0)).powi(2));
    assert!((2.0 * each / (1.0 + each) / one - 1.0).abs() < 1e-4, "{ior}");
    assert!(matches!(said.as_slice(), [(NoteKind::Approximated, m)] if m.contains("two faces")), "{said:?}");
    // A dielectric that reflects everything lets no light in.
    let extensions = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 0 } });
    assert_eq!(surface_of(dielectric(0.05, extensions)).0.kind(), "metallic-roughness");
    let extensions = json!({ "KHR_materials_transmission": { "transmissionFactor": 1 } });
    let (rough, said) = surface_of(dielectric(0.5, extensions));
    let Surface::ThinGlass { facets, .. } = rough else { panic!("{rough:?}") };
    assert!(facets == 0.25.into() && said.is_empty(), "{facets:?} {said:?}");
}

#[test]
fn transmission_of_a_share_is_a_mix_and_metal_lets_nothing_through() {
    let glass = json!({ "KHR_materials_transmission": { "transmissionFactor": 0.5, "transmissionTexture": { "index": 0 } } });
    let parts = |pbr: Value| {
        let scene = textured(json!({ "name": "m", "pbrMetallicRoughness": pbr, "extensions": glass }));
        assert_eq!(notes(&scene).len(), 1, "of the pane: {:?}", notes(&scene));
        let Surface::Mix { first, second, amount } = used(&scene).surface else {
            panic!("{:?}", used(&scene))
        };
        let [first, second] = [first, second].map(|id| scene.materials()[id.index()].clone());
        assert_eq!((first.name.as_str(), second.name.as_str()), ("m without glass", "m, glass"));
        assert_eq!((first.surface.kind(), second.surface.kind()), ("metallic-roughness", "thin glass"));
        number(&scene, amount)
    };
    near(parts(json!({ "metallicFactor": 0, "roughnessFactor": 0 })), [0.5 * 0.2, 0.5]);
    near(parts(json!({ "metallicFactor": 0.75, "roughnessFactor": 0 })), [0.125 * 0.2, 0.125]);
    // Metalness is the blue channel: 0.8 on the left, 0 on the right.
    let pbr =
        json!({ "metallicFactor": 0.5, "roughnessFactor": 0, "metallicRoughnessTexture": { "index": 0 } });
    near(parts(pbr), [0.5 * 0.2 * 0.6, 0.5]);
}

#[test]
fn transmission_with_thickness_is_solid_glass_that_absorbs() {
    let with = |volume: Value| {
        surface_of(dielectric(
            0.0,
            json!({ "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_volume": volume }),
        ))
    };
    let (clear, said) = with(json!({ "thicknessFactor": 2, "attenuationColor": [0.5, 0.5, 0.5] }));
    assert_eq!(
        clear,
        Surface::Glass { ior: 1.5, reflectance: Rgb::WHITE, transmittance: BASE, facets: 0.0.into() }
    );
    assert!(said.is_empty(), "an infinite distance absorbs nothing: {said:?}");
    let (tinted, _) =
        with(json!({ "thicknessFactor": 4, "attenuationDistance": 2, "attenuationColor": [1, 0.5, 0] }));
    let Surface::Glass { transmittance, .. } = tinted else { panic!("{tinted:?}") };
    // Two crossings absorb as much as four metres: (0.5)².
    near([transmittance.r, transmittance.g], [0.5, 0.6 * 0.5]);
    assert_eq!(transmittance.b, 0.0);
    let (thin, _) = with(json!({ "thicknessFactor": 0, "attenuationDistance": 2 }));
    assert_eq!(thin.kind(), "thin glass");
    let (wrong, said) =
        with(json!({ "thicknessFactor": 1, "attenuationDistance": 0, "attenuationColor": [0, 0, 0] }));
    assert!(matches!(wrong, Surface::Glass { transmittance: BASE, .. }), "{wrong:?}");
    assert!(matches!(said.as_slice(), [(NoteKind::Repaired, _)]), "{said:?}");
}

#[test]
fn leaves_let_light_through_on_a_share() {
    let leaf = json!({
        "diffuseTransmissionFactor": 0.5, "diffuseTransmissionTexture": { "index": 0 },
        "diffuseTransmissionColorFactor": [1, 0.5, 1], "diffuseTransmissionColorTexture": { "index": 0 },
    });
    let scene = textured(dielectric(1.0, json!({ "KHR_materials_diffuse_transmission": leaf })));
    let Surface::Mix { first, second, amount } = used(&scene).surface else { panic!() };
    near(number(&scene, amount), [0.5 * 0.6, 0.5]);
    assert_eq!(scene.materials()[first.index()].surface.kind(), "metallic-roughness");
    let Surface::Translucent { reflectance, transmittance } = scene.materials()[second.index()].surface
    else {
        panic!()
    };
    assert!(reflectance.factor.is_black());
    near(color(&scene, transmittance).map(|c| c.g), [0.5 * linear(102), 0.5]);
}

#[test]
fn clear_coats_lie_over_dielectrics_and_metals() {
    let coat = json!({ "KHR_materials_clearcoat": {
        "clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.5, "clearcoatRoughnessTexture": { "index": 0 },
    } });
    for metal in [0.0, 0.3, 1.0] {
        let core = json!({ "metallicFactor": metal, "roughnessFactor": 0.9 });
        let scene = textured(json!({ "pbrMetallicRoughness": core, "extensions": coat }));
        assert_eq!(notes(&scene), []);
        let Surface::Clearcoat { base, amount, alpha, model } = used(&scene).surface else { panic!() };
        assert_eq!((amount, model), (0.7.into(), CoatModel::Layer));
        near(number(&scene, alpha), [(0.5_f32 * 0.4).powi(2), 0.25]);
        let Surface::MetallicRoughness { metallic, roughness, .. } = scene.materials()[base.index()].surface
        else {
            panic!()
        };
        assert_eq!((metallic.factor, roughness.factor), (metal, 0.9));
    }
}

/// A sheen under a coat, with a texel of (255, 102, 128) and opacity 0.6. The coat attenuates both
/// the sheen and the base.
#[test]
fn sheen_lies_on_the_base_and_under_a_coat() {
    let sheen = json!({
        "sheenColorFactor": [0.5, 0.8, 1], "sheenColorTexture": { "index": 0 },
        "sheenRoughnessFactor": 0.9, "sheenRoughnessTexture": { "index": 0 },
    });
    let coat = json!({ "clearcoatFactor": 0.5 });
    let extensions = json!({ "KHR_materials_sheen": sheen, "KHR_materials_clearcoat": coat });
    let scene = textured(dielectric(0.4, extensions));
    assert_eq!(notes(&scene), []);
    let Surface::Clearcoat { base, .. } = used(&scene).surface else { panic!() };
    let Surface::Sheen { base, color: tint, roughness } = scene.materials()[base.index()].surface else {
        panic!()
    };
    near(color(&scene, tint).map(|c| c.g), [0.8 * linear(102), 0.8]);
    near(number(&scene, roughness), [0.9 * 0.6, 0.9]);
    assert_eq!(scene.materials()[base.index()].surface.kind(), "metallic-roughness");

    let fine = json!({ "KHR_materials_sheen": { "sheenColorFactor": [1, 1, 1] } });
    let scene = textured(dielectric(0.4, fine));
    assert_eq!(notes(&scene).len(), 1);
    let none = json!({ "KHR_materials_sheen": { "sheenRoughnessFactor": 1 } });
    assert_eq!(used(&textured(dielectric(0.4, none))).surface.kind(), "metallic-roughness");
}

#[test]
fn anisotropy_has_a_strength_and_a_direction() {
    let brushed = json!({ "KHR_materials_anisotropy": {
        "anisotropyStrength": 0.5, "anisotropyRotation": 0.3, "anisotropyTexture": { "index": 0 },
    } });
    let scene = textured(dielectric(0.5, brushed));
    let material = used(&scene);
    let Surface::MetallicRoughness { roughness, anisotropy, .. } = material.surface else { panic!() };
    assert_eq!(roughness.factor, 0.5);
    // The anisotropy has a texture; its strength is the blue channel.
    let (texture, channel) = anisotropy.texture.unwrap();
    assert_eq!((anisotropy.factor, channel), (0.5, Channel::B));
    assert_eq!(material.tangent, Some(TangentInput { rotation: 0.3, direction: Some(texture) }));

    let even = json!({ "KHR_materials_anisotropy": { "anisotropyRotation": 0.3 } });
    let scene = textured(dielectric(0.5, even));
    assert_eq!(used(&scene).tangent, None);
}

/// Glass with anisotropic roughness: `α` is 0.25 across and `0.25 + 0.75/4` along the direction.
#[test]
fn glass_is_brushed_where_nothing_of_it_is_textured() {
    let extensions = |texture: Value| {
        json!({
            "KHR_materials_anisotropy": { "anisotropyStrength": 0.5, "anisotropyTexture": texture },
            "KHR_materials_transmission": { "transmissionFactor": 1 },
            "KHR_materials_volume": { "thicknessFactor": 1 },
        })
    };
    let facets = |texture| {
        let scene = textured(dielectric(0.5, extensions(texture)));
        let Surface::Glass { facets, .. } = used(&scene).surface else { panic!() };
        (facets.alpha.factor, facets.across.map(|across| across.factor))
    };
    assert_eq!(facets(Value::Null), (0.4375, Some(0.25)));
    assert_eq!(facets(json!({ "index": 0 })), (0.25, None));
}

#[test]
fn specular_glossiness_is_a_diffuse_part_and_a_reflectance() {
    let (surface, _) = surface_of(json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.8, 0.4, 0.2, 1], "specularFactor": [0.5, 0.25, 0], "glossinessFactor": 0.75,
    } } }));
    let Surface::MetallicRoughness { base_color, metallic, roughness, specular_f0, .. } = surface else {
        panic!()
    };
    assert_eq!((base_color.factor, metallic.factor), (Rgb::new(0.4, 0.2, 0.1), 0.0));
    assert_eq!((roughness.factor, specular_f0.factor), (0.25, Rgb::new(0.5, 0.25, 0.0)));

    let scene =
        textured(json!({ "alphaMode": "BLEND", "extensions": { "KHR_materials_pbrSpecularGlossiness": {
        "diffuseTexture": { "index": 0 }, "specularFactor": [0.5, 0.5, 0.5], "glossinessFactor": 0.5,
        "specularGlossinessTexture": { "index": 0 },
    } } }));
    let material = used(&scene);
    let Surface::MetallicRoughness { base_color, roughness, specular_f0, .. } = material.surface else {
        panic!()
    };
    near(number(&scene, roughness), [1.0 - 0.5 * 0.6, 0.5]);
    near(color(&scene, specular_f0).map(|c| c.r), [0.5 * linear(51), 0.5]);
    near(color(&scene, base_color).map(|c| c.g), [linear(102) * (1.0 - 0.5 * linear(102)), 0.5]);
    let alpha = material.alpha.unwrap();
    assert_eq!(alpha.value.texture.unwrap().1, Channel::A);
    near([LEFT, RIGHT].map(|uv| alpha.at(scene.textures(), uv)), [0.6, 1.0]);
}

#[test]
fn unlit_surfaces_are_diffuse_and_so_are_dielectrics_without_reflection() {
    let (unlit, said) = surface_of(dielectric(0.5, json!({ "KHR_materials_unlit": {} })));
    assert_eq!(unlit, Surface::Lambert { reflectance: BASE.into() });
    assert!(matches!(said.as_slice(), [(NoteKind::Approximated, m)] if m.contains("unlit")), "{said:?}");
    let specular = json!({ "KHR_materials_specular": { "specularFactor": 0 } });
    let (diffuse, said) = surface_of(dielectric(0.5, specular));
    assert_eq!((diffuse, said), (Surface::Lambert { reflectance: BASE.into() }, vec![]));
}

/// The triangle with vertex colours from the given bytes.
fn vertex_colours(bytes: &[u8], component: u32, kind: &str) -> Document {
    let mut d = Document::triangle();
    let view = d.view(bytes);
    let colors = json!({ "bufferView": view, "componentType": component, "normalized": component != 5126, "count": 3, "type": kind });
    let colors = d.push("accessors", colors);
    d.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    d.json["materials"][0] =
        json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 0.5, 0.5] } });
    d
}

#[test]
fn vertex_colours_that_are_all_the_same_multiply_the_base_colour() {
    let base = |d: &Document| {
        let scene = d.load().unwrap();
        let Surface::MetallicRoughness { base_color, .. } = used(&scene).surface else { panic!() };
        let alpha = used(&scene).alpha.map(|a| a.value.factor);
        (base_color.factor, alpha.unwrap(), notes(&scene))
    };
    let bytes = vertex_colours(&[51, 102, 204, 51].repeat(3), 5121, "VEC4");
    let (color, alpha, said) = base(&bytes);
    near([color.r, color.g], [0.2, 0.4]);
    near([color.b, alpha], [0.4, 0.1]);
    assert!(said.is_empty(), "{said:?}");
    let shorts: Vec<u8> = [13107_u16, 0, 65535].repeat(3).iter().flat_map(|v| v.to_le_bytes()).collect();
    let (color, alpha, _) = base(&vertex_colours(&shorts, 5123, "VEC3"));
    near([color.r, alpha], [0.2, 0.5]);
    let float: Vec<u8> = [2.0_f32, 0.25, 1.0].repeat(3).iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(base(&vertex_colours(&float, 5126, "VEC3")).0, Rgb::new(2.0, 0.25, 0.5));
}

#[test]
fn vertex_colours_that_differ_become_their_mean_for_each_primitive() {
    let mut d = vertex_colours(&[255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 0, 255], 5121, "VEC4");
    let plain = json!({ "attributes": { "POSITION": 0 }, "material": 0 });
    d.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(plain);
    let scene = d.load().unwrap();
    assert!(only_note(&scene, NoteKind::Approximated, "attribute \"COLOR_0\""), "{:?}", notes(&scene));
    let colors: Vec<Rgb> = scene
        .meshes()
        .iter()
        .map(|mesh| match scene.materials()[mesh.material.index()].surface {
            Surface::MetallicRoughness { base_color, .. } => base_color.factor,
            other => panic!("{other:?}"),
        })
        .collect();
    near([colors[0].r, colors[0].g], [1.0 / 3.0; 2]);
    assert_eq!((colors[0].b, colors[1]), (0.0, Rgb::new(1.0, 1.0, 0.5)));

    let nan: Vec<u8> = [f32::NAN; 9].iter().flat_map(|v| v.to_le_bytes()).collect();
    let scene = vertex_colours(&nan, 5126, "VEC3").load().unwrap();
    assert!(only_note(&scene, NoteKind::Repaired, "vertex colours"), "{:?}", notes(&scene));
}
