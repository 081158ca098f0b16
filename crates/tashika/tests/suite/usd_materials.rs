//! Materials, textures and cameras of USD, in numbers.

use glam::{Vec2, Vec3};
use tashika::color::Rgb;
use tashika::io::LoadOptions;
use tashika::scene::{
    AlphaMode, Channel, Material, NormalInput, NoteKind, Pixels, Projection, Scene, Surface, Texture, Wrap,
};

use super::gltf::notes;
use super::usd::{load, load_with, quad};

/// A quad whose `UsdPreviewSurface` has the given inputs, beside other shaders.
fn text(inputs: &str, shaders: &str) -> String {
    format!(
        "{}def Material \"M\" {{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader \"S\" {{\n uniform token info:id = \"UsdPreviewSurface\"\n{inputs}\n token outputs:surface\n }}
    {shaders}
}}",
        quad(
            "W",
            "rel material:binding = </M>
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = \"vertex\" )
    texCoord2f[] primvars:other = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = \"vertex\" )"
        )
    )
}

/// A texture of 2 × 2 texels: red and green above blue and white.
fn texture(name: &str, more: &str) -> String {
    format!(
        "def Shader \"{name}\" {{\n uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @t.tga@
 token inputs:wrapS = \"repeat\"\n token inputs:wrapT = \"clamp\"\n {more}\n }}\n"
    )
}

fn tga() -> Vec<u8> {
    let mut bytes = vec![0; 18];
    // Uncompressed colours with opacity, rows from the top.
    (bytes[2], bytes[12], bytes[14], bytes[16], bytes[17]) = (2, 2, 2, 32, 0x28);
    for [r, g, b, a] in [[255, 0, 0, 255], [0, 255, 0, 51], [0, 0, 255, 255], [255, 255, 255, 255]] {
        bytes.extend([b, g, r, a]);
    }
    bytes
}

fn scene(inputs: &str, shaders: &str) -> Scene {
    load_with(&text(inputs, shaders), &[("t.tga", &tga())], &LoadOptions::default()).unwrap()
}

fn material(scene: &Scene) -> &Material {
    scene.material_of(scene.instance_ids().next().unwrap())
}

#[test]
fn both_workflows_are_metallic_roughness() {
    let all = scene(
        "color3f inputs:diffuseColor = (0.1, 0.2, 0.3)\n float inputs:metallic = 0.25\n float inputs:roughness = 0.75\n float inputs:ior = 2",
        "",
    );
    let Surface::MetallicRoughness { base_color, metallic, roughness, specular_f0, .. } =
        material(&all).surface
    else {
        panic!()
    };
    assert_eq!(base_color, Rgb::new(0.1, 0.2, 0.3).into());
    assert_eq!((metallic, roughness), (0.25.into(), 0.75.into()));
    assert!((specular_f0.factor.r - 1.0 / 9.0).abs() < 1e-6);
    assert_eq!(notes(&all), []);
    let specular = scene(
        "int inputs:useSpecularWorkflow = 1\n color3f inputs:specularColor = (0.5, 0.25, 0)\n float inputs:metallic = 1",
        "",
    );
    let Surface::MetallicRoughness { base_color, metallic, specular_f0, roughness, .. } =
        material(&specular).surface
    else {
        panic!()
    };
    assert_eq!((metallic, roughness), (0.0.into(), 0.5.into()));
    assert_eq!(specular_f0, Rgb::new(0.5, 0.25, 0.0).into());
    assert_eq!(base_color, Rgb::gray(0.18).into(), "the default");
}

#[test]
fn coats_emission_and_opacity() {
    let coated = scene("float inputs:clearcoat = 0.5\n float inputs:clearcoatRoughness = 0.3", "");
    let Surface::Clearcoat { amount, alpha, base, .. } = material(&coated).surface else { panic!() };
    assert_eq!(amount, 0.5.into());
    assert!((alpha.factor - 0.09).abs() < 1e-6);
    assert!(matches!(coated.materials()[base.index()].surface, Surface::MetallicRoughness { .. }));
    let shining = scene("color3f inputs:emissiveColor = (5, 0, 1)", "");
    let emission = material(&shining).emission.unwrap();
    assert_eq!((emission.radiance.factor, emission.two_sided), (Rgb::new(5.0, 0.0, 1.0), false));
    let twice = text("color3f inputs:emissiveColor = (5, 0, 1)", "")
        .replace("{\n    uniform token sub", "{\n bool doubleSided = 1\n uniform token sub");
    assert!(material(&load(&twice).unwrap()).emission.unwrap().two_sided);
    let holes = scene(
        "float inputs:opacity.connect = </M/T.outputs:a>\n float inputs:opacityThreshold = 0.4",
        &texture("T", ""),
    );
    let alpha = material(&holes).alpha.unwrap();
    assert_eq!(alpha.mode, AlphaMode::Mask { cutoff: 0.4 });
    assert_eq!(alpha.value.texture.unwrap().1, Channel::A);
    let gone = scene("float inputs:opacity = 0.25\n token inputs:opacityMode = \"presence\"", "");
    let alpha = material(&gone).alpha.unwrap();
    assert_eq!((alpha.mode, alpha.value), (AlphaMode::Blend, 0.25.into()));
    let clear = scene("float inputs:opacity = 0.25\n float inputs:ior = 1.5", "");
    let Surface::Mix { first, second, amount } = material(&clear).surface else { panic!() };
    assert_eq!(amount, 0.25.into());
    assert!(matches!(clear.materials()[first.index()].surface, Surface::ThinGlass { .. }));
    assert!(matches!(clear.materials()[second.index()].surface, Surface::MetallicRoughness { .. }));
    assert_eq!(notes(&clear).len(), 1);
}

/// Textures are looked up with the wrapping, scale, bias, rotation, channel and decoding that the
/// file states.
#[test]
fn textures_are_looked_up_as_the_file_says() {
    let reader = "def Shader \"R\" { uniform token info:id = \"UsdPrimvarReader_float2\"\n token inputs:varname = \"other\" }";
    let turn = "def Shader \"X\" { uniform token info:id = \"UsdTransform2d\"\n float2 inputs:in.connect = </M/R.outputs:result>
 float2 inputs:scale = (0.5, 0.25)\n float inputs:rotation = 90\n float2 inputs:translation = (0.125, 0.5) }";
    let st = "float2 inputs:st.connect = </M/X.outputs:result>";
    let shaders = format!(
        "{}{reader}\n{turn}",
        texture("T", &format!("token inputs:sourceColorSpace = \"raw\"\n {st}"))
    );
    let found = scene("color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>", &shaders);
    assert_eq!(notes(&found), []);
    let Surface::MetallicRoughness { base_color, .. } = material(&found).surface else { panic!() };
    let Texture::Image(image) = found.textures().nodes[base_color.texture.unwrap().index()] else { panic!() };
    assert_eq!(image.wrap, [Wrap::Repeat, Wrap::Clamp]);
    assert!(matches!(found.images()[image.image.index()].pixels, Pixels::Linear8(_)));
    // st = (1, 1) is scaled to (0.5, 0.25), turned to (−0.25, 0.5) and moved to (−0.125, 1). Here v
    // runs down.
    let place = image.transform.0.transform_point2(Vec2::new(1.0, 0.0));
    assert!((place - Vec2::new(-0.125, 0.0)).length() < 1e-6, "{place}");
    let place = image.transform.0.transform_point2(Vec2::new(0.0, 1.0));
    assert!((place - Vec2::new(0.125, 0.5)).length() < 1e-6, "{place}");
    // The upper left texel is red: st is (0.25, 0.75), as v runs up.
    let plain = scene("color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>", &texture("T", ""));
    let Surface::MetallicRoughness { base_color, .. } = material(&plain).surface else { panic!() };
    let at = |scene: &Scene, u: f32, v: f32| base_color.at(scene.textures(), Vec2::new(u, 1.0 - v));
    assert_eq!(at(&plain, 0.25, 0.75), Rgb::new(1.0, 0.0, 0.0));
    assert_eq!(at(&plain, 0.25, 0.25), Rgb::new(0.0, 0.0, 1.0));
    let scaled =
        texture("T", "float4 inputs:scale = (0.5, 0.5, 0.5, 1)\n float4 inputs:bias = (0.25, 0, 0, 0)");
    let biased = scene("color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>", &scaled);
    let Surface::MetallicRoughness { base_color, .. } = material(&biased).surface else { panic!() };
    let found = base_color.at(biased.textures(), Vec2::new(0.25, 0.25));
    assert!((Vec3::from(found.to_array()) - Vec3::new(0.75, 0.0, 0.0)).length() < 1e-6);
    let green = scene(
        "float inputs:roughness.connect = </M/T.outputs:g>",
        &texture("T", "token inputs:sourceColorSpace = \"raw\"\n float4 inputs:scale = (1, 0.5, 1, 1)"),
    );
    let Surface::MetallicRoughness { roughness, .. } = material(&green).surface else { panic!() };
    assert_eq!((roughness.factor, roughness.texture.unwrap().1), (0.5, Channel::G));
}

#[test]
fn normal_maps_are_numbers_and_those_without_an_image_fall_back() {
    let usual = "float4 inputs:scale = (2, 2, 2, 1)\n float4 inputs:bias = (-1, -1, -1, 0)";
    let map = scene("normal3f inputs:normal.connect = </M/T.outputs:rgb>", &texture("T", usual));
    assert_eq!(notes(&map), []);
    let Some(NormalInput::Map { texture: found, scale }) = material(&map).normal else { panic!() };
    assert_eq!(scale, 1.0);
    let Texture::Image(image) = map.textures().nodes[found.index()] else { panic!() };
    assert!(matches!(map.images()[image.image.index()].pixels, Pixels::Linear8(_)));
    let gone = text(
        "color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>",
        &texture("T", "float4 inputs:fallback = (0.5, 0.25, 0, 1)"),
    );
    let lenient = LoadOptions { allow_missing: true, ..LoadOptions::default() };
    let scene = load_with(&gone, &[], &lenient).unwrap();
    let Surface::MetallicRoughness { base_color, .. } = material(&scene).surface else { panic!() };
    assert_eq!(base_color, Rgb::new(0.5, 0.25, 0.0).into());
    assert_eq!(notes(&scene)[0].0, NoteKind::Missing);
    let error = load(&gone).unwrap_err().to_string();
    assert!(
        error.contains("image \"t.tga\" could not be read (no such file): its fallback is used"),
        "{error}"
    );
}

#[test]
fn missing_files_are_named_where_they_are_named() {
    let surface = "color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>
color3f inputs:emissiveColor.connect = </M/U.outputs:rgb>";
    let shaders =
        "def Shader \"T\" { uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @own.png@ }
def Shader \"U\" { uniform token info:id = \"UsdUVTexture\"\n asset inputs:file.connect = </M.inputs:map> }";
    let text = text(surface, shaders).replacen(
        "def Material \"M\" {",
        "def Material \"M\" {\nasset inputs:map = @map.png@",
        1,
    )
        + "def DomeLight \"D\" {\n float inputs:intensity = 1\n asset inputs:texture:file = @sky.hdr@\n}
def RectLight \"R\" {\n float inputs:intensity = 1\n asset inputs:texture:file = @rect.png@\n}
def SphereLight \"I\" {\n float inputs:intensity = 1\n asset inputs:shaping:ies:file = @lamp.ies@\n}\n";
    let text = super::usd::whole(&text);
    let error = load(&text).unwrap_err().to_string();
    for file in ["own.png", "map.png", "sky.hdr", "rect.png", "lamp.ies"] {
        let line = 1 + text.lines().position(|line| line.contains(file)).unwrap();
        let place = format!("s.usda:{line}: ");
        let said = error.lines().find(|line| line.contains(file)).unwrap_or_else(|| panic!("{error}"));
        assert!(said.contains(&place), "{file} is at {line}: {said}");
    }
}

#[test]
fn prims_without_a_material_show_their_colour() {
    let color = |text: &str| {
        let scene = load(text).unwrap();
        let Surface::Lambert { reflectance } = material(&scene).surface else { panic!() };
        (reflectance.factor, notes(&scene).len())
    };
    assert_eq!(color(&quad("W", "")), (Rgb::gray(0.5), 0));
    assert_eq!(
        color(&quad("W", "color3f[] primvars:displayColor = [(1, 0.5, 0)]")),
        (Rgb::new(1.0, 0.5, 0.0), 0)
    );
    let inherited =
        format!("def Xform \"W\" {{ color3f[] primvars:displayColor = [(0, 0.5, 0)]\n {} }}", quad("Q", ""));
    assert_eq!(color(&inherited), (Rgb::new(0.0, 0.5, 0.0), 0));
    let varies = "color3f[] primvars:displayColor = [(1, 0, 0), (0, 0, 0), (0, 0, 0), (1, 0, 0)] ( interpolation = \"vertex\" )";
    assert_eq!(color(&quad("W", varies)), (Rgb::new(0.5, 0.0, 0.0), 1));
    let materialx = quad(
        "W",
        "rel material:binding = </M>\n color3f[] primvars:displayColor = [(1, 0.5, 0)]",
    ) + "def Material \"M\" { token outputs:mtlx:surface.connect = </M/S.outputs:out>\n def Shader \"S\" { uniform token info:id = \"ND_lama_surface\" } }";
    assert_eq!(color(&materialx), (Rgb::new(1.0, 0.5, 0.0), 1));
}

/// Two copies of an asset share equal materials and their meshes. A copy with other opinions has
/// another material.
#[test]
fn copies_share_materials_until_they_differ() {
    let asset =
        format!("class \"A\" {{ {} }}\n", text("float inputs:roughness = 0.25", "").replace("</M", "</A/M"));
    let copies = |over: &str| {
        let text = format!(
            "{asset}def \"B\" ( references = </A> ) {{ }}\ndef \"C\" ( references = </A> ) {{ {over} }}"
        );
        let scene = load(&text).unwrap();
        let meshes: Vec<_> = scene.instances().iter().map(|i| i.mesh).collect();
        assert_eq!(meshes.len(), 2);
        meshes[0] == meshes[1]
    };
    assert!(copies(""));
    assert!(!copies("over \"M\" { over \"S\" { float inputs:roughness = 0.5 } }"));
}

#[test]
fn cameras_have_their_field_of_view_lens_and_offset() {
    let camera = |more: &str| {
        let text = format!("#usda 1.0\n( metersPerUnit = 0.1\n upAxis = \"Z\" )\ndef Xform \"W\" {{ def Camera \"Main\" {{\n {more}
 double3 xformOp:translate = (10, 20, 30)\n uniform token[] xformOpOrder = [\"xformOp:translate\"] }} }}");
        load(&text).unwrap().cameras()[0].clone()
    };
    let usual = camera(
        "float focalLength = 50\n float verticalAperture = 100\n float horizontalAperture = 200\n float horizontalApertureOffset = 20\n float verticalApertureOffset = 20",
    );
    assert_eq!(usual.name, "Main");
    let Projection::Perspective { vertical_fov } = usual.projection else { panic!() };
    assert!((vertical_fov - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    assert!((usual.shift - Vec2::new(0.1, 0.2)).length() < 1e-6);
    assert!((usual.position() - Vec3::new(1.0, 3.0, -2.0)).length() < 1e-6);
    // The camera looks along −z of the file, which is down.
    assert!((usual.to_world.transform_vector3(Vec3::NEG_Z) - Vec3::NEG_Y).length() < 1e-6);
    assert_eq!(usual.lens.radius, 0.0);
    let open = camera("float focalLength = 50\n float fStop = 2.5\n float focusDistance = 7");
    // The focal length is 50 tenths of a decimetre, 0.5 m. The radius is that divided by twice the
    // f-number.
    assert!((open.lens.radius - 0.1).abs() < 1e-6 && (open.lens.focus_distance - 0.7).abs() < 1e-6);
    let flat = camera("token projection = \"orthographic\"\n float verticalAperture = 300");
    let Projection::Orthographic { height } = flat.projection else { panic!() };
    assert!((height - 3.0).abs() < 1e-6);
}
