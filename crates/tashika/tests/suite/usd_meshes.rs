//! Meshes of USD: primvars and their interpolation, subsets of faces, named shapes, transforms.

use glam::{DMat4, DVec3, Vec2, Vec3};
use tashika::color::Rgb;
use tashika::scene::{NoteKind, Scene, Surface};

use super::gltf::notes;
use super::usd::{corners, load, quad};

/// Two quads side by side with six points, and a material that needs `st`.
fn pair(more: &str) -> String {
    format!(
        "def Scope \"L\" {{ def Material \"M\" {{
    token outputs:surface.connect = </L/M/S.outputs:surface>
    def Shader \"S\" {{
        uniform token info:id = \"UsdPreviewSurface\"
        color3f inputs:diffuseColor.connect = </L/M/T.outputs:rgb>
        token outputs:surface
    }}
    def Shader \"T\" {{
        uniform token info:id = \"UsdUVTexture\"
        asset inputs:file = @t.pfm@
    }}
}} }}
def Mesh \"W\" {{
    rel material:binding = </L/M>
    uniform token subdivisionScheme = \"none\"
    int[] faceVertexCounts = [4, 4]
    int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0), (2, 1, 0)]
    {more}
}}\n"
    )
}

fn with_texture(text: &str) -> Scene {
    let pfm: Vec<u8> = b"PF 1 1 -1\n".iter().copied().chain([0; 12]).collect();
    let options = tashika::io::LoadOptions::default();
    super::usd::load_with(text, &[("t.pfm", &pfm)], &options).unwrap()
}

/// Texture coordinates of a face at a point of the pair, `v` up.
fn uv(scene: &Scene, face: usize, point: [f32; 2]) -> Vec2 {
    let mesh = &scene.meshes()[0];
    let at = Vec3::new(point[0], point[1], 0.0);
    let triangles = &mesh.triangles()[2 * face..2 * face + 2];
    let vertex = triangles.iter().flatten().find(|&&i| mesh.positions()[i as usize] == at).unwrap();
    let uv = mesh.uvs()[*vertex as usize];
    Vec2::new(uv.x, 1.0 - uv.y)
}

#[test]
fn values_vary_as_their_interpolation_says() {
    let uvs = |n: usize| (0..n).map(|i| format!("({i}, {})", 10 * i)).collect::<Vec<_>>().join(", ");
    // Indices of the values that the lower middle point (1, 0) has in the left and in the right
    // face.
    for (kind, count, left, right) in [
        ("constant", 1, 0, 0),
        ("uniform", 2, 0, 1),
        ("vertex", 6, 1, 1),
        ("varying", 6, 1, 1),
        ("faceVarying", 8, 1, 4),
    ] {
        let st = format!("texCoord2f[] primvars:st = [{}] ( interpolation = \"{kind}\" )", uvs(count));
        let scene = with_texture(&pair(&st));
        let found = [0, 1].map(|face| uv(&scene, face, [1.0, 0.0]));
        let expected = [left, right].map(|i| Vec2::new(i as f32, 10.0 * i as f32));
        assert_eq!(found, expected, "{kind}");
        assert_eq!(notes(&scene), [], "{kind}");
        // The same values with indices in reverse order.
        let indices: Vec<String> = (0..count).rev().map(|i| i.to_string()).collect();
        let st = format!("{st}\nint[] primvars:st:indices = [{}]", indices.join(", "));
        let scene = with_texture(&pair(&st));
        let found = [0, 1].map(|face| uv(&scene, face, [1.0, 0.0]));
        let expected =
            [left, right].map(|i| Vec2::new((count - 1 - i) as f32, 10.0 * (count - 1 - i) as f32));
        assert_eq!(found, expected, "{kind} with indices");
    }
    for wrong in [
        "texCoord2f[] primvars:st = [(0, 0)] ( interpolation = \"vertex\" )",
        "texCoord2f[] primvars:st = [(0, 0)] ( interpolation = \"constant\" )\nint[] primvars:st:indices = [1]",
        "texCoord2f[] primvars:st = [(0, 0)] ( interpolation = \"constant\" )\nint[] primvars:st:indices = [-1]",
        "float[] primvars:st = [0, 0, 0, 0, 0, 0] ( interpolation = \"vertex\" )",
    ] {
        let scene = with_texture(&pair(wrong));
        let said = notes(&scene);
        assert!(
            said.iter().any(|(k, m)| *k == NoteKind::Repaired && m.contains("do not fit")),
            "{wrong}: {said:?}"
        );
        assert!(scene.meshes()[0].uvs().is_empty());
    }
}

#[test]
fn normals_are_those_of_the_primvar_before_those_of_the_mesh() {
    let tilted = "normal3f[] normals = [(0, 1, 1), (0, 1, 1), (0, 1, 1), (0, 1, 1)]";
    let scene = load(&quad("W", tilted)).unwrap();
    let expected = Vec3::new(0.0, 1.0, 1.0).normalize();
    assert!(scene.meshes()[0].normals().iter().all(|n| (*n - expected).length() < 1e-6));
    let uniform =
        format!("{tilted}\nnormal3f[] primvars:normals = [(1, 0, 0)] ( interpolation = \"uniform\" )");
    let scene = load(&quad("W", &uniform)).unwrap();
    assert!(scene.meshes()[0].normals().iter().all(|n| *n == Vec3::X));
    assert_eq!(scene.meshes()[0].normals().len(), 4);
}

#[test]
fn left_handed_faces_run_the_other_way_round() {
    let normal = |more: &str| {
        let scene = load(&quad("W", more)).unwrap();
        let [a, b, c] = scene.meshes()[0].corners(0);
        (b - a).cross(c - a).z
    };
    assert!(normal("") > 0.0 && normal("uniform token orientation = \"leftHanded\"") < 0.0);
}

#[test]
fn subsets_have_their_faces_and_materials() {
    let material = |name: &str, color: &str| {
        format!("def Material \"{name}\" {{ token outputs:surface.connect = </{name}/S.outputs:surface>
    def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\n color3f inputs:diffuseColor = {color}\n token outputs:surface }} }}\n")
    };
    let text = format!(
        "{}{}{}",
        material("Red", "(1, 0, 0)"),
        material("Blue", "(0, 0, 1)"),
        pair(
            "rel material:binding = </Red>
    def GeomSubset \"Part\" { uniform token elementType = \"face\"\n int[] indices = [1]\n rel material:binding = </Blue> }"
        )
    );
    let scene = load(&text).unwrap();
    let found: Vec<(Rgb, f32)> = scene
        .instance_ids()
        .map(|id| {
            let Surface::MetallicRoughness { base_color, .. } = scene.material_of(id).surface else {
                panic!()
            };
            (base_color.factor, scene.mesh_of(id).bounds().lo.x)
        })
        .collect();
    assert_eq!(found, [(Rgb::new(0.0, 0.0, 1.0), 1.0), (Rgb::new(1.0, 0.0, 0.0), 0.0)]);
    assert_eq!(notes(&scene), []);
}

#[test]
fn bindings_hold_below_and_strong_ones_are_not_replaced() {
    let color = |binding: &str| {
        let text = format!(
            "def Xform \"W\" {{ rel material:binding = </Red> {binding}\n{} }}
def Material \"Red\" {{ token outputs:surface.connect = </Red/S.outputs:surface>
    def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\n color3f inputs:diffuseColor = (1, 0, 0)\n token outputs:surface }} }}
def Material \"Blue\" {{ token outputs:surface.connect = </Blue/N.outputs:out>
    color3f inputs:tint = (0, 0, 1)
    def NodeGraph \"N\" {{ token outputs:out.connect = </Blue/N/S.outputs:surface>
        color3f inputs:tint.connect = </Blue.inputs:tint>
        def Shader \"S\" {{ uniform token info:id = \"UsdPreviewSurface\"\n color3f inputs:diffuseColor.connect = </Blue/N.inputs:tint>\n token outputs:surface }} }} }}",
            quad("Q", "rel material:binding = </Blue>")
        );
        let scene = load(&text).unwrap();
        let id = scene.instance_ids().next().unwrap();
        let Surface::MetallicRoughness { base_color, .. } = scene.material_of(id).surface else { panic!() };
        base_color.factor
    };
    assert_eq!(color(""), Rgb::new(0.0, 0.0, 1.0));
    assert_eq!(color("( bindMaterialAs = \"strongerThanDescendants\" )"), Rgb::new(1.0, 0.0, 0.0));
}

/// World area of the only mesh of a scene.
fn area(scene: &Scene) -> f64 {
    let id = scene.instance_ids().next().unwrap();
    let triangles = scene.mesh_of(id).triangles().len() as u32;
    let of = |t: u32| {
        let [a, b, c] = scene.world_corners(id, t).map(|p| p.as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    };
    (0..triangles).map(of).sum()
}

#[test]
fn shapes_have_their_areas_and_axes() {
    use std::f64::consts::PI;
    let slant = (0.5_f64 * 0.5 + 9.0).sqrt();
    for (shape, expected, size) in [
        ("Cube \"W\" { double size = 3 }", 54.0, [3.0, 3.0, 3.0]),
        ("Sphere \"W\" { double radius = 2 }", 16.0 * PI, [4.0, 4.0, 4.0]),
        ("Plane \"W\" { double width = 2\n double length = 3 }", 6.0, [2.0, 3.0, 0.0]),
        (
            "Plane \"W\" { double width = 2\n double length = 3\n uniform token axis = \"X\" }",
            6.0,
            [0.0, 3.0, 2.0],
        ),
        (
            "Plane \"W\" { double width = 2\n double length = 3\n uniform token axis = \"Y\" }",
            6.0,
            [2.0, 0.0, 3.0],
        ),
        ("Cylinder \"W\" { double radius = 0.5\n double height = 3 }", PI * (3.0 + 0.5), [1.0, 1.0, 3.0]),
        (
            "Cylinder \"W\" { double radius = 0.5\n double height = 3\n uniform token axis = \"X\" }",
            PI * 3.5,
            [3.0, 1.0, 1.0],
        ),
        ("Cone \"W\" { double radius = 0.5\n double height = 3 }", PI * 0.5 * (slant + 0.5), [1.0, 1.0, 3.0]),
    ] {
        let scene = load(&format!("def {shape}")).unwrap();
        // Cones are not exact, and the semi-axes of polygons differ from those of circles.
        assert!((area(&scene) / expected - 1.0).abs() < 2e-3, "{shape}: {} {expected}", area(&scene));
        let bounds = scene.bounds();
        assert!((bounds.size() - Vec3::from(size)).length() < 0.02, "{shape}: {bounds:?}");
        assert!(((bounds.lo + bounds.hi) * 0.5).length() < 0.01, "{shape}: {bounds:?}");
    }
}

/// USD's matrices act on row vectors. The product computed by hand is therefore the transpose of
/// the product for columns.
#[test]
fn operations_multiply_in_their_order() {
    let ops = "double3 xformOp:translate = (1, 2, 3)
    float3 xformOp:rotateXYZ = (90, 0, 90)
    float3 xformOp:scale = (2, 3, 4)
    double3 xformOp:translate:pivot = (5, 0, 0)
    uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:translate:pivot\", \"xformOp:rotateXYZ\", \"xformOp:scale\", \"!invert!xformOp:translate:pivot\"]";
    let scene = load(&format!("def Xform \"W\" {{ {ops}\n{} }}", quad("Q", ""))).unwrap();
    let row = |m: [[f64; 4]; 4]| DMat4::from_cols_array_2d(&m);
    let [x, y, z, w] =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let moved = |t: [f64; 3]| row([x, y, z, [t[0], t[1], t[2], 1.0]]);
    let scale = row([[2.0, 0.0, 0.0, 0.0], [0.0, 3.0, 0.0, 0.0], [0.0, 0.0, 4.0, 0.0], w]);
    // Images of the axes, row by row: the rotation about x takes y to z; that about z takes x to y.
    let about_x = row([x, z, [0.0, -1.0, 0.0, 0.0], w]);
    let about_z = row([y, [-1.0, 0.0, 0.0, 0.0], z, w]);
    // Columns here are the rows of USD, so that the factors are in the opposite order.
    let all =
        moved([1.0, 2.0, 3.0]) * moved([5.0, 0.0, 0.0]) * about_z * about_x * scale * moved([-5.0, 0.0, 0.0]);
    let found = &corners(&scene)["/W/Q"];
    for (found, p) in found.iter().zip([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]) {
        let expected = all.transform_point3(DVec3::from_array(p)).as_vec3();
        assert!((*found - expected).length() < 1e-5, "{found} {expected}");
    }
    // By hand: (1, 0, 0) minus the pivot is (−4, 0, 0), scaled (−8, 0, 0), turned (0, −8, 0), moved
    // back (6, −6, 3).
    assert!((found[1] - Vec3::new(6.0, -6.0, 3.0)).length() < 1e-5, "{}", found[1]);
}

#[test]
fn what_is_hidden_is_not_drawn() {
    let drawn = |more: &str| {
        let scene = load(&format!("def Xform \"W\" {{ {more}\n{} }}", quad("Q", ""))).unwrap();
        scene.instances().len()
    };
    for (more, expected) in [
        ("", 1),
        ("token visibility = \"invisible\"", 0),
        ("uniform token purpose = \"render\"", 1),
        ("uniform token purpose = \"guide\"", 0),
        ("uniform token purpose = \"proxy\"", 0),
    ] {
        assert_eq!(drawn(more), expected, "{more}");
    }
    for text in ["over \"W\" { REST }", "class \"W\" { REST }", "def \"W\" ( active = false ) { REST }"] {
        let scene = load(&text.replace("REST", &quad("Q", ""))).unwrap();
        assert_eq!(scene.instances().len(), 0, "{text}");
    }
    let own = quad("Q", "uniform token purpose = \"default\"");
    let scene = load(&format!("def Xform \"W\" {{ uniform token purpose = \"guide\"\n{own} }}")).unwrap();
    assert_eq!(scene.instances().len(), 1, "its own purpose counts");
}

#[test]
fn points_place_their_prototypes() {
    let text = format!(
        "def PointInstancer \"W\" {{
    rel prototypes = [</W/A>, </B>]
    int[] protoIndices = [0, 1, 0, 1]
    point3f[] positions = [(0, 0, 0), (10, 0, 0), (20, 0, 0), (30, 0, 0)]
    quath[] orientations = [(1, 0, 0, 0), (0, 0, 0, 1), (1, 0, 0, 0), (1, 0, 0, 0)]
    float3[] scales = [(1, 1, 1), (2, 2, 2), (1, 1, 1), (1, 1, 1)]
    int64[] ids = [7, 8, 9, 10]
    int64[] invisibleIds = [9]
    {}
}}
def Xform \"B\" {{ double3 xformOp:translate = (0, 5, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n {} }}",
        quad("A", ""),
        quad("Q", "")
    );
    let scene = load(&text).unwrap();
    let all = corners(&scene);
    // B is drawn itself; A is drawn only by its instances.
    assert_eq!(all.keys().collect::<Vec<_>>(), ["/B/Q", "/W"]);
    let first: Vec<Vec3> = all["/W"].chunks(4).map(|c| c[1]).collect();
    // Half a turn about z with a scale of two takes (1, 5, 0) to (−2, −10, 0).
    let expected = [[1.0, 0.0, 0.0], [8.0, -10.0, 0.0], [31.0, 5.0, 0.0]].map(Vec3::from);
    assert!(
        first.len() == 3 && first.iter().zip(expected).all(|(a, b)| (*a - b).length() < 1e-4),
        "{first:?}"
    );
    let error = load(&text.replace("protoIndices = [0, 1", "protoIndices = [0, 2")).unwrap_err().to_string();
    assert!(error.ends_with("prototype 2; expected a number below 2"), "{error}");
}
