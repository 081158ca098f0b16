//! Every row of the USD loader's table, each in a separate file.

use tashika::io::{Feature, LoadOptions, Support, features, load_scene};
use tashika::scene::NoteKind;

use super::gltf::{notes, write};
use super::usd::{SAMPLES, quad, whole};

fn rows() -> &'static [Feature] {
    features().into_iter().find(|f| f.format == "USD").expect("a table of USD").rows
}

/// A quad whose material has the given inputs, beside other shaders.
fn surface(inputs: &str, shaders: &str) -> String {
    let st = "texCoord2f[] primvars:st = [(0, 0)] ( interpolation = \"constant\" )";
    let mesh = quad("W", &format!("rel material:binding = </M>\n {st}"));
    format!(
        "{mesh}def Material \"M\" {{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader \"S\" {{\n uniform token info:id = \"UsdPreviewSurface\"\n{inputs}\n token outputs:surface\n }}
    {shaders}
}}"
    )
}

/// A quad whose material has a texture as colour.
fn textured(more: &str, shaders: &str) -> String {
    surface("color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>", &(texture("T", more) + shaders))
}

fn texture(name: &str, more: &str) -> String {
    format!(
        "def Shader \"{name}\" {{\n uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @t.pfm@\n {more}\n }}\n"
    )
}

/// A quad with a MaterialX material. Its surface has the given inputs; `nodes` are further nodes.
fn materialx(definition: &str, inputs: &str, nodes: &str) -> String {
    let st = "texCoord2f[] primvars:st = [(0, 0)] ( interpolation = \"constant\" )";
    let mesh = quad("W", &format!("rel material:binding = </M>\n {st}"));
    format!(
        "{mesh}def Material \"M\" {{
    token outputs:mtlx:surface.connect = </M/S.outputs:out>
    def Shader \"S\" {{\n uniform token info:id = \"{definition}\"\n{inputs}\n }}
    {nodes}
}}"
    )
}

/// A quad with a Standard Surface whose colour is the node `T`.
fn with_node(definition: &str, inputs: &str, more: &str) -> String {
    let node = format!("def Shader \"T\" {{ uniform token info:id = \"{definition}\"\n {inputs} }}\n{more}");
    materialx(STANDARD, "color3f inputs:base_color.connect = </M/T.outputs:out>", &node)
}

const STANDARD: &str = "ND_standard_surface_surfaceshader";

/// A quad and a light of the given type.
fn light(kind: &str, inputs: &str) -> String {
    let light = format!("def {kind} \"L\" {{\n {inputs}\n }}\n");
    quad("W", "") + &light
}

/// A quad with a transform operation.
fn moved(op: &str, more: &str) -> String {
    let order = "uniform token[] xformOpOrder = [\"xformOp:translate\"]";
    format!("def Xform \"W\" {{\n {op}\n {order}\n {more}\n {} }}\n", quad("Q", ""))
}

/// A file with the feature of a row and with nothing else that gives a note.
fn example(kind: &str, name: &str) -> String {
    let plain = quad("W", "");
    let head = |metadata: &str| format!("#usda 1.0\n(\n {metadata}\n)\n{plain}");
    match (kind, name) {
        ("stage", "metersPerUnit") => head("metersPerUnit = 0.1"),
        ("stage", "upAxis") => head("upAxis = \"Z\""),
        ("stage", _) => head("timeCodesPerSecond = 30\n framesPerSecond = 12"),
        ("composition", "subLayers") => head("subLayers = [@other.usda@]"),
        ("composition", "relocates") => head("relocates = { </A>: </B> }"),
        ("composition", "clips") => plain + "def Xform \"X\" ( clips = { dictionary default = { string primPath = \"/X\" } } ) { }",
        ("composition", "layer offset") => head("subLayers = [@other.usda@ (offset = 1)]"),
        ("composition", "references") => "def \"W\" ( references = @other.usda@ ) { }".to_owned(),
        ("composition", "payload") => "def \"W\" ( payload = @other.usda@</Other> ) { }".to_owned(),
        ("composition", "inherits" | "specializes") => {
            format!("class \"C\" {{ {plain} }}\ndef \"W\" ( {name} = </C> ) {{ }}")
        }
        ("composition", "variants") => format!(
            "def \"W\" ( variants = {{ string v = \"x\" }}\n prepend variantSets = \"v\" ) {{
    variantSet \"v\" = {{ \"x\" {{ {plain} }} \"y\" {{ }} }} }}"
        ),
        ("composition", "over") => {
            "def \"W\" ( references = @other.usda@ ) { over \"Q\" { token visibility = \"inherited\" } }".to_owned()
        }
        ("composition", "instanceable") => {
            "def \"W\" ( instanceable = true\n references = @other.usda@ ) { }".to_owned()
        }
        ("attribute", "timeSamples") => {
            moved("double3 xformOp:translate.timeSamples = { 1: (1, 0, 0), 2: (2, 0, 0) }", "")
        }
        ("attribute", "spline") => moved(
            "double3 xformOp:translate = (1, 0, 0)",
            "double xformOp:rotateX = 0\n double xformOp:rotateX.spline = { 1: 5; curve linear, }\n uniform token[] xformOpOrder = [\"xformOp:rotateX\"]",
        ),
        ("attribute", "xformOpOrder") => moved(
            "double3 xformOp:translate = (1, 0, 0)",
            "uniform token[] xformOpOrder = [\"!resetXformStack!\", \"!invert!xformOp:translate\"]",
        ),
        ("attribute", "xformOpOrder without Xform") => {
            moved("double3 xformOp:translate = (1, 0, 0)", "").replace("def Xform", "def Scope")
        }
        ("attribute", "renderVisibility") => quad("W", "token renderVisibility = \"visible\""),
        ("attribute", "model:drawMode") => quad("W", "uniform token model:drawMode = \"cards\""),
        ("attribute", "colorSpace:name") => quad("W", "uniform token colorSpace:name = \"lin_ap1_scene\""),
        ("attribute", "lod:heuristics") => quad("W", "uniform int lod:default:index = 1"),
        ("attribute", "of other renderers") => quad("W", "int primvars:arnold:subdiv_iterations = 2"),
        ("attribute", "default") => moved("double3 xformOp:translate = (1, 0, 0)", ""),
        ("attribute", "visibility") => quad("V", "token visibility = \"invisible\"") + &plain,
        ("attribute", "purpose") => quad("V", "uniform token purpose = \"proxy\"") + &plain,
        ("prim", "Mesh") => plain,
        ("prim", "GeomSubset") => {
            let subset = "def GeomSubset \"P\" { int[] indices = [0]\n rel material:binding = </M> }";
            surface("", "").replacen("rel material", &format!("{subset}\n rel material"), 1)
        }
        ("prim", "GeomSubset of other elements" | "GeomSubset of another family") => {
            let field = if name.ends_with("family") { "familyName = \"odd\"" } else { "elementType = \"point\"" };
            let subset = format!("def GeomSubset \"P\" {{ uniform token {field}\n rel material:binding = </M> }}");
            surface("", "").replacen("rel material:binding = </M>", &subset, 1)
        }
        ("prim", "PointInstancer" | "PointInstancer in a PointInstancer") => {
            let points = |name: &str, prototype: &str, more: &str| {
                format!(
                    "def PointInstancer \"{name}\" {{ rel prototypes = <{prototype}>\n int[] protoIndices = [0]\n point3f[] positions = [(1, 0, 0)]\n {more} }}\n"
                )
            };
            let one = points("P", "/W", "");
            if name == "PointInstancer" { plain + &one } else { plain + &points("N", "/P", "") + &one }
        }
        ("prim", _) => format!("{plain}def {name} \"P\" {{ }}"),
        ("mesh", "subdivisionScheme") => quad("W", "uniform token subdivisionScheme = \"catmullClark\""),
        ("mesh", "orientation") => quad("W", "uniform token orientation = \"leftHanded\""),
        ("mesh", "holeIndices") => {
            "def Mesh \"W\" { uniform token subdivisionScheme = \"none\"\n int[] faceVertexCounts = [3, 3]\n int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]\n point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n int[] holeIndices = [1] }".to_owned()
        }
        ("mesh", "orientation of a shape") => "def Cube \"W\" { uniform token orientation = \"leftHanded\" }".to_owned(),
        ("mesh", "doubleSided") => quad("W", "uniform bool doubleSided = true"),
        ("primvar", "normals") => quad("W", "normal3f[] primvars:normals = [(0, 0, 1)] ( interpolation = \"uniform\" )"),
        ("primvar", "st") => textured("", ""),
        ("primvar", "displayOpacity") => {
            quad("W", "float[] primvars:displayOpacity = [0.25, 1, 1, 1] ( interpolation = \"vertex\" )")
        }
        ("primvar", "displayColor") => {
            quad("W", "color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] ( interpolation = \"uniform\" )")
        }
        ("material", "material:binding") => surface("", "").replace("rel material:binding", "rel material:binding:full"),
        ("material", "material:binding:collection") => {
            quad("W", "rel material:binding:collection:a = [</W.collection:a>, </M>]")
        }
        ("material", "UsdPreviewSurface") => surface("", ""),
        ("material", "another surface of MaterialX" | "another surface") => {
            let output = if name == "another surface" { "outputs:surface" } else { "outputs:mtlx:surface" };
            let shader = "def Shader \"S\" { uniform token info:id = \"standard_surface\" }";
            quad("W", "rel material:binding = </M>")
                + &format!("def Material \"M\" {{ token {output}.connect = </M/S.outputs:out>\n {shader} }}")
        }
        ("material", "outputs:volume") => {
            surface("", "").replace("token outputs:surface.connect", "token outputs:volume.connect = </M/S.outputs:v>\n token outputs:surface.connect")
        }
        ("UsdPreviewSurface", "diffuseColor" | "emissiveColor") => {
            surface(&format!("color3f inputs:{name} = (0.5, 0.25, 0)"), "")
        }
        ("UsdPreviewSurface", "useSpecularWorkflow") => surface("int inputs:useSpecularWorkflow = 1", ""),
        ("UsdPreviewSurface", "normal") => surface("normal3f inputs:normal = (0, 0, 1)", ""),
        ("UsdPreviewSurface", "ior") => surface("float inputs:ior = 1.3", ""),
        ("UsdPreviewSurface", "opacityThreshold") => {
            surface("float inputs:opacity = 0.5\n float inputs:opacityThreshold = 0.25", "")
        }
        ("UsdPreviewSurface", "UsdPrimvarReader as a value") => surface(
            "color3f inputs:diffuseColor.connect = </M/R.outputs:result>",
            "def Shader \"R\" { uniform token info:id = \"UsdPrimvarReader_float3\" }",
        ),
        ("UsdPreviewSurface", "another shader") => surface(
            "color3f inputs:diffuseColor.connect = </M/R.outputs:result>",
            "def Shader \"R\" { uniform token info:id = \"Noise\" }",
        ),
        ("UsdPreviewSurface", _) => surface(&format!("float inputs:{name} = 0.5"), ""),
        ("MaterialX", "standard_surface" | "open_pbr_surface" | "gltf_pbr" | "ND_UsdPreviewSurface") => {
            let definition = if name.starts_with("ND_") { name.to_owned() } else { format!("ND_{name}") };
            materialx(&format!("{definition}_surfaceshader"), "", "")
        }
        ("MaterialX", "image") => with_node("ND_image_color3", "asset inputs:file = @t.pfm@", ""),
        ("MaterialX", "place2d") => with_node(
            "ND_image_color3",
            "asset inputs:file = @t.pfm@\n float2 inputs:texcoord.connect = </M/P.outputs:out>",
            "def Shader \"P\" { uniform token info:id = \"ND_place2d_vector2\"\n float2 inputs:scale = (2, 2) }",
        ),
        ("MaterialX", "multiply") => {
            with_node("ND_multiply_color3FA", "color3f inputs:in1 = (0.5, 0.5, 0)\n float inputs:in2 = 0.5", "")
        }
        ("MaterialX", "normalmap") => materialx(
            STANDARD,
            "float3 inputs:normal.connect = </M/N.outputs:out>",
            "def Shader \"N\" { uniform token info:id = \"ND_normalmap_float\"\n float3 inputs:in.connect = </M/T.outputs:out> }
    def Shader \"T\" { uniform token info:id = \"ND_image_vector3\"\n asset inputs:file = @t.pfm@ }",
        ),
        ("MaterialX", "subsurface") => materialx(STANDARD, "float inputs:subsurface = 0.5", ""),
        ("MaterialX", "transmission depth") => {
            materialx(STANDARD, "float inputs:transmission = 1\n float inputs:transmission_depth = 0.5", "")
        }
        ("MaterialX", "textures of the tint of solid glass") => materialx(
            STANDARD,
            "float inputs:transmission = 1\n color3f inputs:transmission_color.connect = </M/T.outputs:out>",
            "def Shader \"T\" { uniform token info:id = \"ND_image_color3\"\n asset inputs:file = @t.pfm@ }",
        ),
        ("MaterialX", "diffuse roughness") => materialx(STANDARD, "float inputs:diffuse_roughness = 0.5", ""),
        ("MaterialX", "anisotropy") => materialx(STANDARD, "float inputs:specular_anisotropy = 0.5", ""),
        ("MaterialX", "scattering inside") => {
            materialx(STANDARD, "float inputs:transmission = 0.5\n color3f inputs:transmission_scatter = (0, 0.1, 0)", "")
        }
        ("MaterialX", "dispersion") => materialx(STANDARD, "float inputs:transmission = 0.5\n float inputs:transmission_dispersion = 20", ""),
        ("MaterialX", "extra roughness") => {
            materialx(STANDARD, "float inputs:transmission = 0.5\n float inputs:transmission_extra_roughness = 0.5", "")
        }
        ("MaterialX", "colour and index of the coat") => materialx(STANDARD, "float inputs:coat = 1\n float inputs:coat_IOR = 1.6", ""),
        ("MaterialX", "normals of the coat") => materialx(
            STANDARD,
            "float inputs:coat = 1\n float3 inputs:coat_normal.connect = </M/T.outputs:out>",
            "def Shader \"T\" { uniform token info:id = \"ND_image_vector3\"\n asset inputs:file = @t.pfm@ }",
        ),
        ("MaterialX", "thin film") => materialx(STANDARD, "float inputs:thin_film_thickness = 300", ""),
        ("UsdUVTexture", "file" | "wrapS") => textured("token inputs:wrapS = \"mirror\"", ""),
        ("UsdUVTexture", "scale") => textured("float4 inputs:scale = (0.5, 1, 1, 1)", ""),
        ("UsdUVTexture", "sourceColorSpace") => textured("token inputs:sourceColorSpace = \"raw\"", ""),
        ("UsdUVTexture", "sourceColorSpace auto") => {
            surface("float inputs:roughness.connect = </M/T.outputs:g>", &texture("T", ""))
        }
        ("UsdUVTexture", "UsdPrimvarReader_float2" | "UsdTransform2d") => {
            let st = "def Shader \"R\" { uniform token info:id = \"UsdPrimvarReader_float2\"\n string inputs:varname = \"st\" }
    def Shader \"X\" { uniform token info:id = \"UsdTransform2d\"\n float2 inputs:in.connect = </M/R.outputs:result>\n float2 inputs:scale = (2, 2) }";
            let from = if name == "UsdTransform2d" { "X" } else { "R" };
            textured(&format!("float2 inputs:st.connect = </M/{from}.outputs:result>"), st)
        }
        ("UsdUVTexture", "st from another shader") => textured(
            "float2 inputs:st.connect = </M/R.outputs:result>",
            "def Shader \"R\" { uniform token info:id = \"Noise\" }",
        ),
        ("UsdUVTexture", "second set of coordinates") => {
            let second = "float2 inputs:st.connect = </M/R.outputs:result>\n token inputs:sourceColorSpace = \"raw\"";
            surface(
                "color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>\n float inputs:roughness.connect = </M/U.outputs:r>",
                &(texture("T", "")
                    + &texture("U", second)
                    + "def Shader \"R\" { uniform token info:id = \"UsdPrimvarReader_float2\"\n string inputs:varname = \"uv\" }"),
            )
        }
        ("UsdUVTexture", "scale and bias of normals") => {
            surface("normal3f inputs:normal.connect = </M/T.outputs:rgb>", &texture("T", ""))
        }
        ("UsdUVTexture", "bias below 0 or of opacity") => textured("float4 inputs:bias = (-0.5, 0, 0, 0)", ""),
        ("UsdUVTexture", "one channel as a colour") => {
            surface("color3f inputs:diffuseColor.connect = </M/T.outputs:r>", &texture("T", ""))
        }
        ("camera", "clippingPlanes") => plain + "def Camera \"C\" { float4[] clippingPlanes = [(0, 0, 1, 1)] }",
        ("camera", "exposure") => plain + "def Camera \"C\" { float exposure = 2 }",
        ("camera", "shutter:open") => plain + "def Camera \"C\" { double shutter:open = -0.25 }",
        ("camera", "backPlate") => plain + "def Camera \"C\" { asset backPlate:x:image = @t.pfm@ }",
        ("camera", _) => plain + "def Camera \"C\" { float fStop = 4\n float focusDistance = 5 }",
        ("light", "DistantLight") => light("DistantLight", "float inputs:angle = 0"),
        ("light", "inputs:angle") => light("DistantLight", ""),
        ("light", "DomeLight") => light("DomeLight", "asset inputs:texture:file = @t.pfm@"),
        ("light", "inputs:texture:format") => {
            light("DomeLight", "asset inputs:texture:file = @t.pfm@\n token inputs:texture:format = \"angular\"")
        }
        ("light", "second DomeLight texture") => {
            light("DomeLight", "asset inputs:texture:file = @t.pfm@")
                + "def DomeLight \"V\" { asset inputs:texture:file = @t.pfm@ }"
        }
        ("light", "inputs:normalize") => light("RectLight", "bool inputs:normalize = true"),
        ("light", "inputs:colorTemperature") => {
            light("RectLight", "bool inputs:enableColorTemperature = true\n float inputs:colorTemperature = 3000")
        }
        ("light", "inputs:shaping:cone:angle") => light("SphereLight", "float inputs:shaping:cone:angle = 30"),
        ("light", "shaping of other lights") => light("RectLight", "float inputs:shaping:cone:angle = 30"),
        ("light", "inputs:shaping:ies:angleScale") => light("SphereLight", "float inputs:shaping:ies:angleScale = 1"),
        ("light", "inputs:shaping:ies:normalize") => light("SphereLight", "bool inputs:shaping:ies:normalize = true"),
        ("light", "inputs:shadow") => light("RectLight", "bool inputs:shadow:enable = false"),
        ("light", "treatAsLine") => light("CylinderLight", "bool treatAsLine = true"),
        ("light", "inputs:shaping:focus") => light("SphereLight", "float inputs:shaping:focus = 2"),
        ("light", "inputs:shaping:ies:file") => light("SphereLight", "asset inputs:shaping:ies:file = @lamp.ies@"),
        ("light", "inputs:diffuse" | "inputs:specular") => light("RectLight", &format!("float {name} = 0")),
        ("light", "light:filters") => light("RectLight", "rel light:filters = </F>"),
        ("light", "collection:lightLink") => light("RectLight", "rel collection:lightLink:includes = </W>"),
        ("light", "MeshLightAPI") => plain.replace("\"W\"", "\"W\" ( prepend apiSchemas = [\"MeshLightAPI\"] )"),
        ("light", "light of a prototype") => {
            "def PointInstancer \"P\" { rel prototypes = </P/X>\n int[] protoIndices = [0]\n point3f[] positions = [(1, 0, 0)]
    def Xform \"X\" { QUAD def DistantLight \"L\" { float inputs:angle = 0 } } }".replace("QUAD", &plain)
        }
        ("light", kind) => light(kind, ""),
        ("no effect", "extent") => quad("W", "float3[] extent = [(0, 0, 0), (1, 1, 0)]"),
        ("no effect", "clippingRange") => plain + "def Camera \"C\" { float2 clippingRange = (0.1, 5) }",
        ("no effect", "velocities") => quad("W", "vector3f[] velocities = [(0, 0, 0)]"),
        ("no effect", "portals") => light("DomeLight", "rel portals = </W>"),
        ("no effect", "physics") => quad("W", "bool physics:collisionEnabled = true"),
        ("no effect", _) => plain,
        _ => panic!("no example of {kind} {name}"),
    }
}

#[test]
fn every_row_gives_its_note_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let pfm: Vec<u8> = b"PF 1 1 -1\n".iter().copied().chain(0.5_f32.to_le_bytes().repeat(3)).collect();
    let other = "#usda 1.0\n( defaultPrim = \"Other\" )\ndef Xform \"Other\" { QUAD }"
        .replace("QUAD", &quad("Q", ""));
    let lamp = "IESNA91\nTILT=NONE\n1 100 1 2 1 1 2 0 0 0\n1 1 10\n0 90\n0\n100 50\n";
    for (name, bytes) in
        [("t.pfm", pfm.as_slice()), ("other.usda", other.as_bytes()), ("lamp.ies", lamp.as_bytes())]
    {
        write(&folder.path().join(name), bytes);
    }
    for row in rows() {
        let path = if row.kind == "file" {
            // The contents of the encodings are tested elsewhere; a `.usd` file may be in either.
            let name = match row.name {
                "usd" => "simple.usdc".to_owned(),
                name => format!("simple.{name}"),
            };
            let path = folder.path().join(format!("simple.{}", row.name));
            std::fs::copy(std::path::Path::new(SAMPLES).join(name), &path).unwrap();
            std::fs::copy(std::path::Path::new(SAMPLES).join("chess.png"), folder.path().join("chess.png"))
                .unwrap();
            path
        } else {
            let path = folder.path().join("s.usda");
            write(&path, whole(&example(row.kind, row.name)).as_bytes());
            path
        };
        let scene = load_scene(&path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{row:?}: {e}"));
        assert!(!scene.instances().is_empty(), "{row:?}");
        let expected = match row.support {
            Support::Full => Vec::new(),
            Support::Approximated => vec![NoteKind::Approximated],
            Support::Ignored => vec![NoteKind::Ignored],
            Support::Refused => panic!("{row:?}"),
        };
        let message = format!("{} {:?}: {}", row.kind, row.name, row.how);
        let expected: Vec<_> = expected.into_iter().map(|kind| (kind, message.clone())).collect();
        assert_eq!(notes(&scene), expected, "{row:?}");
    }
}

#[test]
fn prims_of_unknown_types_are_noted_and_what_is_below_them_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.usda");
    let many: String = (0..60).map(|i| format!("def Odd{i} \"P{i}\" {{ }}\n")).collect();
    write(&path, whole(&format!("def Strange \"W\" {{ {} }}\n{many}", quad("Q", ""))).as_bytes());
    let scene = load_scene(&path, &LoadOptions::default()).unwrap();
    assert_eq!(scene.instances().len(), 1);
    let said = notes(&scene);
    assert!(
        said.iter().any(|(_, m)| m == "prim \"Strange\" is unknown: what is below it is read"),
        "{said:?}"
    );
    assert!(said.len() <= 51, "{}", said.len());
}
