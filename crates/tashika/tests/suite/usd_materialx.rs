//! MaterialX in USD, in numbers: supported surfaces, networks of nodes, and the choice between a
//! material's surfaces.

use glam::Vec2;
use tashika::color::Rgb;
use tashika::io::LoadOptions;
use tashika::scene::{AlphaMode, Channel, ColorInput, Material, NormalInput, Scene, Surface};

use super::gltf::notes;
use super::usd::{load_with, quad};

const STANDARD: &str = "ND_standard_surface_surfaceshader";
const OPEN: &str = "ND_open_pbr_surface_surfaceshader";
const GLTF: &str = "ND_gltf_pbr_surfaceshader";

/// A node of a network.
fn node(name: &str, id: &str, inputs: &str) -> String {
    format!("def Shader \"{name}\" {{ uniform token info:id = \"{id}\"\n {inputs} }}\n")
}

/// A TGA of 2 × 2 texels, rows from the top; `v` runs up: red and green above blue and half grey.
fn tga() -> Vec<u8> {
    let mut bytes = vec![0; 18];
    (bytes[2], bytes[12], bytes[14], bytes[16], bytes[17]) = (2, 2, 2, 24, 0x20);
    for [r, g, b] in [[255, 0, 0], [0, 255, 0], [0, 0, 255], [51, 51, 51]] {
        bytes.extend([b, g, r]);
    }
    bytes
}

fn load(text: &str) -> Scene {
    load_with(text, &[("t.tga", &tga())], &LoadOptions::default()).unwrap()
}

/// A quad whose material has the given outputs and shaders.
fn bound(outputs: &str, shaders: &str) -> String {
    let st = "texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = \"vertex\" )
    texCoord2f[] primvars:other = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = \"vertex\" )";
    quad("W", &format!("rel material:binding = </M>\n {st}"))
        + &format!("def Material \"M\" {{ {outputs}\n {shaders} }}")
}

fn scene(definition: &str, inputs: &str, nodes: &str) -> Scene {
    let shaders = node("S", definition, inputs) + nodes;
    load(&bound("token outputs:mtlx:surface.connect = </M/S.outputs:out>", &shaders))
}

fn material(scene: &Scene) -> &Material {
    scene.material_of(scene.instance_ids().next().unwrap())
}

fn color_of(scene: &Scene) -> ColorInput {
    let Surface::MetallicRoughness { base_color, .. } = material(scene).surface else { panic!() };
    base_color
}

/// Value of a colour at coordinates whose `v` runs up.
fn at(scene: &Scene, color: ColorInput, [u, v]: [f32; 2]) -> [f32; 3] {
    color.at(scene.textures(), Vec2::new(u, 1.0 - v)).to_array()
}

#[track_caller]
fn near(found: [f32; 3], expected: [f32; 3]) {
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} for {expected:?}");
}

/// Unset inputs have the values of the node definition.
#[test]
fn surfaces_have_their_own_defaults() {
    let f0 = 0.04;
    for (definition, color, metal, rough) in
        [(STANDARD, 0.8, 0.0, 0.2), (OPEN, 0.8, 0.0, 0.3), (GLTF, 1.0, 1.0, 1.0)]
    {
        let found = scene(definition, "", "");
        let Surface::MetallicRoughness { base_color, metallic, roughness, specular_f0, .. } =
            material(&found).surface
        else {
            panic!("{definition}")
        };
        assert_eq!(base_color, Rgb::gray(color).into(), "{definition}");
        assert_eq!((metallic, roughness), (metal.into(), rough.into()), "{definition}");
        near(specular_f0.factor.to_array(), [f0; 3]);
        assert_eq!(notes(&found), [], "{definition}");
        assert!(material(&found).emission.is_none() && material(&found).alpha.is_none());
    }
}

#[test]
fn layers_have_the_words_of_each_surface() {
    let words = [
        (STANDARD, "base", "metalness", "specular_IOR", "specular", "coat", "sheen", "sheen_color"),
        (
            OPEN,
            "base_weight",
            "base_metalness",
            "specular_ior",
            "specular_weight",
            "coat_weight",
            "fuzz_weight",
            "fuzz_color",
        ),
    ];
    for (definition, base, metalness, ior, specular, coat, sheen, sheen_color) in words {
        let inputs = format!(
            "color3f inputs:base_color = (0.5, 0.25, 1)\n float inputs:{base} = 0.5\n float inputs:{metalness} = 0.25
 float inputs:specular_roughness = 0.5\n float inputs:{ior} = 2\n float inputs:{specular} = 0.5
 color3f inputs:specular_color = (1, 0.5, 0)\n float inputs:{coat} = 0.75\n float inputs:coat_roughness = 0.5
 float inputs:{sheen} = 0.5\n color3f inputs:{sheen_color} = (1, 0, 0.5)"
        );
        let found = scene(definition, &inputs, "");
        let Surface::Clearcoat { base, amount, alpha, .. } = material(&found).surface else { panic!() };
        assert_eq!((amount, alpha), (0.75.into(), 0.25.into()));
        let Surface::Sheen { base, color, .. } = found.materials()[base.index()].surface else { panic!() };
        assert_eq!(color, Rgb::new(0.5, 0.0, 0.25).into());
        let Surface::MetallicRoughness { base_color, metallic, roughness, specular_f0, .. } =
            found.materials()[base.index()].surface
        else {
            panic!()
        };
        assert_eq!(base_color, Rgb::new(0.25, 0.125, 0.5).into());
        assert_eq!((metallic, roughness), (0.25.into(), 0.5.into()));
        near(specular_f0.factor.to_array(), [0.5 / 9.0, 0.25 / 9.0, 0.0]);
    }
    let cloth = scene(GLTF, "color3f inputs:sheen_color = (0, 0.5, 0)\n float inputs:clearcoat = 1", "");
    let Surface::Clearcoat { base, .. } = material(&cloth).surface else { panic!() };
    let Surface::Sheen { color, .. } = cloth.materials()[base.index()].surface else { panic!() };
    assert_eq!(color, Rgb::new(0.0, 0.5, 0.0).into());
}

#[test]
fn what_lets_light_through_is_glass_or_a_pane() {
    let inputs = "float inputs:transmission = 1\n color3f inputs:transmission_color = (0.25, 1, 0.5)";
    let solid = scene(STANDARD, inputs, "");
    let Surface::Glass { ior, transmittance, facets, .. } = material(&solid).surface else { panic!() };
    assert_eq!((ior, transmittance), (1.5, Rgb::new(0.25, 1.0, 0.5)));
    assert!((facets.alpha.factor - 0.04).abs() < 1e-6);
    let deep = scene(STANDARD, &format!("{inputs}\n float inputs:transmission_depth = 2"), "");
    let Surface::Glass { transmittance, .. } = material(&deep).surface else { panic!() };
    near(transmittance.to_array(), [0.5, 1.0, 0.5_f32.sqrt()]);
    let pane = scene(STANDARD, &format!("{inputs}\n bool inputs:thin_walled = 1"), "");
    let Surface::ThinGlass { ior, transmittance, .. } = material(&pane).surface else { panic!() };
    assert_eq!((ior, transmittance), (1.5, Rgb::new(0.25, 1.0, 0.5).into()));
    // The metal does not transmit.
    let partly =
        scene(OPEN, "float inputs:transmission_weight = 0.5\n float inputs:base_metalness = 0.5", "");
    let Surface::Mix { first, second, amount } = material(&partly).surface else { panic!() };
    assert_eq!(amount, 0.25.into());
    assert!(matches!(partly.materials()[first.index()].surface, Surface::MetallicRoughness { .. }));
    assert!(matches!(partly.materials()[second.index()].surface, Surface::Glass { .. }));
    let of_gltf =
        "float inputs:metallic = 0\n float inputs:transmission = 1\n color3f inputs:base_color = (1, 0, 0)";
    let thin = scene(GLTF, of_gltf, "");
    let Surface::ThinGlass { transmittance, .. } = material(&thin).surface else { panic!() };
    assert_eq!(transmittance, Rgb::new(1.0, 0.0, 0.0).into());
    let thick = scene(GLTF, &format!("{of_gltf}\n float inputs:thickness = 1"), "");
    assert!(matches!(material(&thick).surface, Surface::Glass { .. }));
}

#[test]
fn emission_is_a_colour_times_its_strength_and_opacity_stops_light() {
    for (definition, strength, color) in [
        (STANDARD, "emission", "emission_color"),
        (OPEN, "emission_luminance", "emission_color"),
        (GLTF, "emissive_strength", "emissive"),
    ] {
        let inputs = format!("float inputs:{strength} = 20\n color3f inputs:{color} = (1, 0.5, 0)");
        let found = scene(definition, &inputs, "");
        assert_eq!(material(&found).emission.unwrap().radiance, Rgb::new(20.0, 10.0, 0.0).into());
    }
    let veil = scene(STANDARD, "color3f inputs:opacity = (0.25, 0.25, 0.25)", "");
    let alpha = material(&veil).alpha.unwrap();
    assert_eq!((alpha.value, alpha.mode), (0.25.into(), AlphaMode::Blend));
    let inputs = "float inputs:alpha = 0.5\n int inputs:alpha_mode = 1\n float inputs:alpha_cutoff = 0.25";
    assert_eq!(material(&scene(GLTF, inputs, "")).alpha.unwrap().mode, AlphaMode::Mask { cutoff: 0.25 });
    assert_eq!(material(&scene(GLTF, "float inputs:alpha = 0.5", "")).alpha, None, "opaque is its mode");
}

/// A graph of nodes: textures are multiplied by a colour, mixed and inverted, and one channel is
/// the roughness. All have the values of the nodes' formulas.
#[test]
fn networks_of_nodes_have_the_values_of_their_formulas() {
    let image = |name: &str, kind: &str, more: &str| {
        node(name, &format!("ND_image_{kind}"), &format!("asset inputs:file = @t.tga@ {more}\n"))
    };
    let nodes = image("I", "color3", "( colorSpace = \"lin_rec709\" )")
        + &node(
            "P",
            "ND_multiply_color3",
            "color3f inputs:in1.connect = </M/I.outputs:out>\n color3f inputs:in2 = (0.5, 1, 0.25)",
        )
        + &node("V", "ND_invert_color3", "color3f inputs:in.connect = </M/P.outputs:out>")
        + &node(
            "X",
            "ND_mix_color3",
            "color3f inputs:bg = (1, 1, 1)\n color3f inputs:fg.connect = </M/V.outputs:out>\n float inputs:mix = 0.25",
        )
        + &node("E", "ND_separate3_color3", "color3f inputs:in.connect = </M/I.outputs:out>");
    let inputs = "color3f inputs:base_color.connect = </M/X.outputs:out>
 float inputs:specular_roughness.connect = </M/E.outputs:outg>";
    let found = scene(STANDARD, inputs, &nodes);
    assert_eq!(notes(&found), []);
    let Surface::MetallicRoughness { base_color: mixed, roughness, .. } = material(&found).surface else {
        panic!()
    };
    // The upper left texel is red: ¾ + ¼ (1 − p), where p is the texel times the colour.
    near(at(&found, mixed, [0.25, 0.75]), [0.875, 1.0, 1.0]);
    near(at(&found, mixed, [0.75, 0.75]), [1.0, 0.75, 1.0]);
    near(at(&found, mixed, [0.75, 0.25]), [0.975, 0.95, 0.9875]);
    assert_eq!(roughness.texture.unwrap().1, Channel::G);
    let rough = |u, v: f32| roughness.at(found.textures(), Vec2::new(u, 1.0 - v));
    assert!((rough(0.75, 0.75) - 1.0).abs() < 1e-6 && rough(0.25, 0.75).abs() < 1e-6);
    // Colours without a colour space are sRGB.
    let plain =
        scene(STANDARD, "color3f inputs:base_color.connect = </M/I.outputs:out>", &image("I", "color3", ""));
    let grey = at(&plain, color_of(&plain), [0.75, 0.25])[0];
    assert!((grey - 0.0331).abs() < 1e-3, "{grey}");
    let map = image("I", "vector3", "")
        + &node(
            "N",
            "ND_normalmap_float",
            "float3 inputs:in.connect = </M/I.outputs:out>\n float inputs:scale = 0.5",
        );
    let bumpy = scene(OPEN, "float3 inputs:geometry_normal.connect = </M/N.outputs:out>", &map);
    assert!(matches!(material(&bumpy).normal, Some(NormalInput::Map { scale: 0.5, .. })));
}

/// Transforms of coordinates, computed by hand: `place2d` around its pivot in both orders, tiles,
/// and glTF's transform.
#[test]
fn textures_are_placed_as_their_nodes_say() {
    let map = |id: &str, inputs: &str, more: &str| {
        let texture = node("I", id, &format!("asset inputs:file = @t.tga@\n {inputs}"));
        let found =
            scene(STANDARD, "color3f inputs:base_color.connect = </M/I.outputs:out>", &(texture + more));
        assert_eq!(notes(&found), []);
        let texture = color_of(&found).texture.unwrap();
        let tashika::scene::Texture::Image(image) = found.textures().nodes[texture.index()] else { panic!() };
        // Converts back to coordinates whose v runs up.
        move |u: f32, v: f32| {
            let place = image.transform.0.transform_point2(Vec2::new(u, 1.0 - v));
            Vec2::new(place.x, 1.0 - place.y)
        }
    };
    let place = |inputs: &str| {
        let reader = node("G", "ND_geompropvalue_vector2", "string inputs:geomprop = \"other\"");
        let inputs = format!("float2 inputs:texcoord.connect = </M/G.outputs:out>\n {inputs}");
        let placed = node("P", "ND_place2d_vector2", &inputs);
        map("ND_image_color3", "float2 inputs:texcoord.connect = </M/P.outputs:out>", &(placed + &reader))
    };
    let close = |found: Vec2, expected: [f32; 2]| {
        assert!((found - Vec2::from(expected)).length() < 1e-5, "{found} for {expected:?}");
    };
    let numbers = "float2 inputs:pivot = (0.5, 0.5)\n float2 inputs:scale = (2, 4)\n float inputs:rotate = 90\n float2 inputs:offset = (0.1, 0.2)";
    // (1, 1) − p = (½, ½); divided by the scale (¼, ⅛); turned (⅛, −¼); minus the offset, plus p.
    close(place(numbers)(1.0, 1.0), [0.5 + 0.125 - 0.1, 0.5 - 0.25 - 0.2]);
    // (½, ½) − o = (0.4, 0.3); turned (0.3, −0.4); divided by the scale (0.15, −0.1).
    close(place(&format!("{numbers}\n int inputs:operationorder = 1"))(1.0, 1.0), [0.65, 0.4]);
    let tiled = map(
        "ND_tiledimage_color3",
        "float2 inputs:uvtiling = (4, 2)\n float2 inputs:uvoffset = (0.5, 0)\n float2 inputs:realworldimagesize = (2, 1)",
        "",
    );
    close(tiled(0.5, 0.25), [0.75, 0.5]);
    // glTF's transform runs down from the upper left: (¼, ¼) in its frame is scaled to (½, ¾) and
    // moved.
    let of_gltf = map(
        "ND_gltf_image_color3_color3_1_0",
        "float2 inputs:scale = (2, 3)\n float2 inputs:offset = (0.125, 0.0625)",
        "",
    );
    close(of_gltf(0.25, 0.75), [0.625, 1.0 - 0.8125]);
}

/// The MaterialX surface of a material is used if all of it is supported. Otherwise the surface for
/// other renderers is used, and without one the supported part of the MaterialX surface.
#[test]
fn the_surface_that_is_understood_is_taken() {
    let material = |nodes: &str, outputs: &str| {
        let shaders = node("S", STANDARD, "color3f inputs:base_color.connect = </M/C.outputs:out>")
            + &node("U", "UsdPreviewSurface", "color3f inputs:diffuseColor = (0, 0, 1)")
            + nodes;
        let found = load(&bound(outputs, &shaders));
        (color_of(&found).factor.to_array(), notes(&found).len())
    };
    let both = "token outputs:mtlx:surface.connect = </M/S.outputs:out>\n token outputs:surface.connect = </M/U.outputs:surface>";
    let constant = node("C", "ND_constant_color3", "color3f inputs:value = (1, 0, 0)");
    let noise = node("C", "ND_noise2d_color3", "");
    assert_eq!(material(&constant, both), ([1.0, 0.0, 0.0], 0));
    assert_eq!(material(&noise, both), ([0.0, 0.0, 1.0], 0));
    let alone = "token outputs:mtlx:surface.connect = </M/S.outputs:out>";
    assert_eq!(material(&noise, alone), ([0.8; 3], 1));
}

/// Numbers outside the range of materials are moved to the nearest valid number, with a note.
#[test]
fn numbers_out_of_range_are_repaired() {
    let inputs = "float inputs:base = 3\n color3f inputs:base_color = (0.5, 2, -1)\n float inputs:sheen = 7
 float inputs:coat = 2\n float inputs:specular = 1000\n float inputs:specular_IOR = -4\n float inputs:emission = 1e38
 color3f inputs:emission_color = (1e30, 0, 0)\n float inputs:transmission = 9\n float inputs:specular_roughness = nan";
    for definition in [STANDARD, OPEN, GLTF] {
        let found = scene(definition, inputs, "");
        assert!(!notes(&found).is_empty(), "{definition}");
    }
    let bright = scene(STANDARD, "float inputs:base = 3\n color3f inputs:base_color = (0.5, 1, 0)", "");
    assert_eq!((color_of(&bright), notes(&bright).len()), (Rgb::new(0.5, 1.0, 0.0).into(), 1));
}

/// A cyclic network, and a network that doubles with each node, both end.
#[test]
fn endless_networks_end() {
    let circle = node("A", "ND_invert_color3", "color3f inputs:in.connect = </M/A.outputs:out>");
    let found = scene(STANDARD, "color3f inputs:base_color.connect = </M/A.outputs:out>", &circle);
    assert_eq!((color_of(&found), notes(&found).len()), (Rgb::gray(0.8).into(), 1));
    let mut doubling = node("N0", "ND_constant_color3", "color3f inputs:value = (1, 1, 1)");
    for n in 1..64 {
        let from = n - 1;
        let inputs = format!(
            "color3f inputs:in1.connect = </M/N{from}.outputs:out>\n color3f inputs:in2.connect = </M/N{from}.outputs:out>"
        );
        doubling += &node(&format!("N{n}"), "ND_multiply_color3", &inputs);
    }
    let found = scene(STANDARD, "color3f inputs:base_color.connect = </M/N63.outputs:out>", &doubling);
    assert!(!notes(&found).is_empty());
}

/// A document with a graph that has an input, inherited attributes and a missing node.
const DOCUMENT: &str = r#"<?xml version="1.0"?>
<materialx version="1.39" colorspace="lin_rec709" fileprefix="./">
  <nodegraph name="NG_paint">
    <input name="tint" type="color3" value="0.5, 1, 0.25"/>
    <image name="I" type="color3"><input name="file" type="filename" value="t.tga" colorspace="srgb_texture"/></image>
    <multiply name="P" type="color3">
      <input name="in1" type="color3" nodename="I"/><input name="in2" type="color3" interfacename="tint"/>
    </multiply>
    <output name="color" type="color3" nodename="P"/>
  </nodegraph>
  <standard_surface name="SR_paint" type="surfaceshader">
    <input name="base" type="float" value="1"/>
    <input name="base_color" type="color3" nodegraph="NG_paint" output="color"/>
    <input name="coat" type="float" value="0.5"/>
  </standard_surface>
  <surfacematerial name="Paint" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="SR_paint"/>
  </surfacematerial>
  <open_pbr_surface name="SR_lamp" type="surfaceshader">
    <input name="emission_luminance" type="float" value="10"/>
    <input name="emission_color" type="color3" value="0.5, 0, 1" colorspace="srgb_texture"/>
    <input name="base_color" type="color3" nodename="gone"/>
  </open_pbr_surface>
  <surfacematerial name="Lamp" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="SR_lamp"/>
  </surfacematerial>
</materialx>
"#;

/// A quad with a material of [`DOCUMENT`], or of another document that replaces it.
fn referring(material: &str, document: &str) -> tashika::error::Result<Scene> {
    let text = quad(
        "W",
        "rel material:binding = </M>
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = \"vertex\" )",
    ) + &format!("def \"M\" ( references = @look.mtlx@</MaterialX/Materials/{material}> ) {{ }}");
    load_with(&text, &[("look.mtlx", document.as_bytes()), ("t.tga", &tga())], &LoadOptions::default())
}

#[test]
fn documents_that_stages_refer_to_are_read() {
    let paint = referring("Paint", DOCUMENT).unwrap();
    assert_eq!(notes(&paint), []);
    let Surface::Clearcoat { base, amount, .. } = material(&paint).surface else { panic!() };
    assert_eq!(amount, 0.5.into());
    let Surface::MetallicRoughness { base_color, .. } = paint.materials()[base.index()].surface else {
        panic!()
    };
    near(at(&paint, base_color, [0.25, 0.75]), [0.5, 0.0, 0.0]);
    near(at(&paint, base_color, [0.75, 0.75]), [0.0, 1.0, 0.0]);
    // A fifth of the way from black to white, decoded from sRGB.
    assert!((at(&paint, base_color, [0.75, 0.25])[1] - 0.0331).abs() < 1e-3);
    let lamp = referring("Lamp", DOCUMENT).unwrap();
    let radiance = material(&lamp).emission.unwrap().radiance.factor.to_array();
    assert!((radiance[0] - 2.1404).abs() < 1e-3 && radiance[1..] == [0.0, 10.0], "{radiance:?}");
    assert_eq!((color_of(&lamp), notes(&lamp).len()), (Rgb::gray(0.8).into(), 1), "a node is not there");
}

#[test]
fn damaged_documents_are_refused_with_their_line() {
    let told = |document: &str| referring("Paint", document).unwrap_err().to_string();
    let error = told(&DOCUMENT.replace("</nodegraph>", "</graph>"));
    assert!(error.contains("look.mtlx:10") && error.contains("XML"), "{error}");
    let error = told("<?xml version=\"1.0\"?><scene/>");
    assert!(error.contains("<scene>") && error.contains("materialx"), "{error}");
    // Any other damage gives a scene or an error.
    let bytes = DOCUMENT.as_bytes();
    for at in 0..bytes.len() {
        let mut damaged = bytes.to_vec();
        damaged[at] = [b'<', b'"', b' ', 0xff][at % 4];
        let text = String::from_utf8_lossy(&damaged).into_owned();
        for material in ["Paint", "Lamp"] {
            drop(referring(material, &text));
        }
    }
}
