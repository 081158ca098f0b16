//! Inherited values of USD prims: materials, purposes, visibility and display colours, also of
//! subsets and prototypes.

use std::collections::BTreeMap;

use tashika::color::Rgb;
use tashika::io::LoadOptions;
use tashika::scene::{NoteKind, Scene, Surface};

use super::gltf::notes;
use super::usd::{corners, load, load_with, quad};

/// A scope with materials that are red, green and blue.
const LOOKS: &str = r#"def Scope "L" {
    def Material "red" { token outputs:surface.connect = </L/red/S.outputs:surface>
        def Shader "S" { uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (1, 0, 0) } }
    def Material "green" { token outputs:surface.connect = </L/green/S.outputs:surface>
        def Shader "S" { uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0, 1, 0) } }
    def Material "blue" { token outputs:surface.connect = </L/blue/S.outputs:surface>
        def Shader "S" { uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0, 0, 1) } }
}
"#;

const STRONG: &str = "( bindMaterialAs = \"strongerThanDescendants\" )";

fn color(surface: &Surface) -> Rgb {
    match surface {
        Surface::MetallicRoughness { base_color, .. } => base_color.factor,
        Surface::Lambert { reflectance } => reflectance.factor,
        other => panic!("{other:?}"),
    }
}

/// Returns the name, the lowest `x` and the colour of each instance.
fn colors(scene: &Scene) -> Vec<(String, f32, [f32; 3])> {
    let of = |id| {
        let points = scene.mesh_of(id).positions().iter();
        let to_world = scene.instances()[id.index()].to_world;
        let left = points.map(|p| to_world.transform_point3(*p).x).fold(f32::INFINITY, f32::min);
        (scene.object_name(id).to_owned(), left, color(&scene.material_of(id).surface).to_array())
    };
    let mut all: Vec<_> = scene.instance_ids().map(of).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all
}

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const GREEN: [f32; 3] = [0.0, 1.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

/// Returns a mesh of two quads. `more` is added to the mesh; `subset` is the content of a subset
/// with the second quad.
fn two_faces(more: &str, subset: &str) -> String {
    format!(
        r#"def Mesh "M" {{
    uniform token subdivisionScheme = "none"
    point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0), (2, 1, 0)]
    int[] faceVertexCounts = [4, 4]
    int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]
    {more}
    def GeomSubset "F" {{ uniform token familyName = "materialBind"
        int[] indices = [1]
        {subset} }}
}}"#
    )
}

fn found(text: &str) -> Vec<[f32; 3]> {
    let scene = load(&format!("{LOOKS}{text}")).unwrap();
    assert_eq!(notes(&scene), [], "{text}");
    colors(&scene).into_iter().map(|(_, _, color)| color).collect()
}

#[test]
fn bindings_that_are_stronger_than_descendants_hold_for_subsets() {
    let bind = |material: &str, more: &str| format!("rel material:binding = </L/{material}> {more}\n");
    let weak = two_faces(&bind("blue", ""), &bind("red", ""));
    assert_eq!(found(&weak), [BLUE, RED]);
    let strong = format!("def Xform \"X\" {{ {}{weak} }}", bind("green", STRONG));
    assert_eq!(found(&strong), [GREEN]);
    let mesh = two_faces(&bind("blue", STRONG), &bind("red", ""));
    assert_eq!(found(&mesh), [BLUE]);
    // Bindings of purpose `full` take precedence, also for subsets.
    let full = two_faces(&bind("blue", ""), "rel material:binding:full = </L/green>\n");
    assert_eq!(found(&full), [BLUE, GREEN]);
    let above = two_faces("rel material:binding:full = </L/green>\n", &bind("red", ""));
    assert_eq!(found(&above), [GREEN]);
}

#[test]
fn bindings_to_what_is_no_material_show_the_display_colour() {
    // Rule of `ComputeBoundMaterial`: the nearest binding applies, even if its material is missing.
    let text = |path: &str| {
        let own = format!("rel material:binding = <{path}>\ncolor3f[] primvars:displayColor = [(1, 0, 0)]");
        format!("{LOOKS}def Xform \"X\" {{ rel material:binding = </L/green>\n{} }}", quad("Q", &own))
    };
    for path in ["/L/gone", "/L", "/L/red/S"] {
        let scene = load(&text(path)).unwrap();
        assert_eq!(colors(&scene)[0].2, RED, "{path}");
        assert_eq!(notes(&scene).len(), 1, "{path}");
        // A subset then has the material of its mesh.
        let subset =
            two_faces("rel material:binding = </L/blue>\n", &format!("rel material:binding = <{path}>"));
        let scene = load(&format!("{LOOKS}{subset}")).unwrap();
        assert_eq!((scene.instances().len(), colors(&scene)[0].2), (1, BLUE), "{path}");
        let said = notes(&scene);
        assert!(matches!(&said[..], [(NoteKind::Repaired, m)] if m.contains("not there")), "{said:?}");
    }
    assert_eq!(colors(&load(&text("/L/blue")).unwrap())[0].2, BLUE);
}

#[test]
fn subsets_of_other_elements_and_families_do_not_bind() {
    for (more, row) in [
        ("uniform token elementType = \"point\"", "GeomSubset of other elements"),
        ("uniform token familyName = \"odd\"", "GeomSubset of another family"),
    ] {
        let text = two_faces("", &format!("rel material:binding = </L/red>\n{more}"));
        let text = text.replacen("uniform token familyName = \"materialBind\"", "", 1);
        let scene = load(&format!("{LOOKS}{text}")).unwrap();
        assert_eq!(scene.instances().len(), 1, "{more}");
        assert!(notes(&scene).iter().any(|(_, m)| m.contains(row)), "{:?}", notes(&scene));
    }
}

/// Returns an instancer of two prototypes at `x = 0` and `x = 10`. The first prototype is below the
/// instancer, the second elsewhere.
fn instancer(more: &str, below: &str, elsewhere: &str) -> String {
    format!(
        r#"def PointInstancer "P" {{
    rel prototypes = [</P/Own/A>, </lib/B>]
    int[] protoIndices = [0, 1]
    point3f[] positions = [(0, 0, 0), (10, 0, 0)]
    {more}
    def Scope "Own" {{ {below}
        {} }}
}}
def Scope "lib" {{ token visibility = "invisible"
    {elsewhere}
    {} }}"#,
        quad("A", ""),
        quad("B", "")
    )
}

#[test]
fn prototypes_are_what_they_are_in_their_own_place() {
    let bind = |material: &str| format!("rel material:binding = </L/{material}>\n");
    assert_eq!(found(&instancer("", &bind("red"), &bind("green"))), [RED, GREEN]);
    // Only the first prototype is below the instancer.
    let grey = found(&instancer(&bind("blue"), "", ""));
    assert_eq!(grey[0], BLUE);
    assert!(grey[1] != BLUE, "{grey:?}");
    let strong = format!("rel material:binding = </L/blue> {STRONG}\n");
    assert_eq!(found(&instancer(&strong, &bind("red"), &bind("green"))), [BLUE, GREEN]);
    // Display colours and purposes are inherited in the same way.
    let shown = |color: &str| format!("color3f[] primvars:displayColor = [{color}]\n");
    assert_eq!(found(&instancer("", &shown("(1, 0, 0)"), &shown("(0, 1, 0)"))), [RED, GREEN]);
    let guide = "uniform token purpose = \"guide\"\n";
    assert_eq!(found(&instancer("", &(bind("red") + guide), &bind("green"))), [GREEN]);
    assert_eq!(found(&instancer("", &bind("red"), &(bind("green") + guide))), [RED]);
    assert!(load(&(instancer(guide, "", "") + &quad("Q", ""))).unwrap().instances().len() == 1);
}

#[test]
fn instances_that_are_inactive_or_invisible_are_not_there() {
    let text = |metadata: &str, more: &str| {
        format!(
            r#"def PointInstancer "P" ( {metadata} ) {{
    rel prototypes = </P/A>
    int[] protoIndices = [0, 0, 0, 0]
    point3f[] positions = [(0, 0, 0), (10, 0, 0), (20, 0, 0), (30, 0, 0)]
    {more}
    {} }}"#,
            quad("A", "")
        )
    };
    let places = |metadata: &str, more: &str| -> Vec<f32> {
        let scene = load(&text(metadata, more)).unwrap();
        assert_eq!(notes(&scene), [], "{metadata} {more}");
        colors(&scene).iter().map(|(_, left, _)| left / 10.0).collect()
    };
    assert_eq!(places("", ""), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(places("prepend inactiveIds = [1]", ""), [0.0, 2.0, 3.0]);
    assert_eq!(places("inactiveIds = [0, 3]", "int64[] invisibleIds = [2]"), [1.0]);
    let ids = "int64[] ids = [7, 8, 9, -5]\n";
    assert_eq!(places("append inactiveIds = [8]", ids), [0.0, 2.0, 3.0]);
    assert_eq!(places("inactiveIds = [-5, 1]", &format!("{ids}int64[] invisibleIds = [7]")), [1.0, 2.0]);
}

#[test]
fn faces_that_are_holes_are_not_there() {
    for scheme in ["none", "catmullClark"] {
        let text = two_faces("int[] holeIndices = [1]\n", "").replace("\"none\"", &format!("\"{scheme}\""));
        let scene = load(&text).unwrap();
        assert_eq!(scene.meshes()[0].triangles().len(), 2, "{scheme}");
        assert!(scene.bounds().hi.x == 1.0, "{scheme}: {:?}", scene.bounds());
    }
    let subset = "rel material:binding = </L/red>\n";
    assert_eq!(found(&two_faces("int[] holeIndices = [0]\n", subset)), [RED]);
    let scene = load(&two_faces("int[] holeIndices = [7, -1, 0]\n", "")).unwrap();
    assert_eq!(scene.meshes()[0].triangles().len(), 2);
    assert!(notes(&scene).iter().any(|(kind, m)| *kind == NoteKind::Repaired && m.contains("holes")));
}

#[test]
fn constant_display_colours_and_opacities_are_inherited() {
    let below = |color: &str, own: &str| format!("def Xform \"X\" {{ {color}\n {} }}", quad("Q", own));
    let red = "color3f[] primvars:displayColor = [(1, 0, 0)]";
    assert_eq!(found(&below(red, "")), [RED]);
    assert_eq!(found(&below(&format!("{red} ( interpolation = \"constant\" )"), "")), [RED]);
    assert_eq!(found(&below(red, "color3f[] primvars:displayColor = [(0, 0, 1)]")), [BLUE]);
    // A value per vertex is not inherited by children, but overrides inherited values.
    let blocked = below(&format!("{red} ( interpolation = \"vertex\" )"), "");
    let blocked = format!("def Xform \"Y\" {{ {red}\n {blocked} }}");
    assert_eq!(found(&blocked), found(&quad("Q", "")));
    let grey = found(&quad("Q", ""))[0];
    assert_eq!(found(&below(&format!("{red} ( interpolation = \"vertex\" )"), "")), [grey]);
    // Only the palette entries that are used count.
    let palette =
        "color3f[] primvars:displayColor = [(0, 1, 0), (1, 0, 0)]\nint[] primvars:displayColor:indices = [1]";
    assert_eq!(found(&below(palette, "")), [RED]);
    let opacity = "float[] primvars:displayOpacity = [0.25]";
    let scene = load(&below(opacity, "")).unwrap();
    let material = scene.material_of(scene.instance_ids().next().unwrap());
    assert_eq!(material.alpha.as_ref().map(|alpha| alpha.value.factor), Some(0.25));
    assert_eq!(notes(&scene), []);
}

#[test]
fn purposes_are_inherited_and_visibility_hides_what_is_below() {
    let names = |text: &str| -> Vec<String> {
        let all: BTreeMap<_, _> = corners(&load(&(text.to_owned() + &quad("Z", ""))).unwrap());
        all.into_keys().filter(|name| name != "/Z").collect()
    };
    let in_scope = |more: &str, inner: &str| format!("def Xform \"X\" {{ {more}\n {} }}", quad("Q", inner));
    let purpose = |word: &str| format!("uniform token purpose = \"{word}\"");
    for (outer, inner, is_drawn) in [
        ("guide", "", false),
        ("proxy", "", false),
        ("render", "", true),
        ("guide", "default", true),
        ("guide", "render", true),
        ("default", "guide", false),
    ] {
        let inner_text = if inner.is_empty() { String::new() } else { purpose(inner) };
        let found = names(&in_scope(&purpose(outer), &inner_text));
        assert_eq!(!found.is_empty(), is_drawn, "{outer} {inner}");
    }
    let hidden = "token visibility = \"invisible\"";
    assert!(names(&in_scope(hidden, "token visibility = \"inherited\"")).is_empty());
    // Prims without a type have neither visibility nor purpose in the format.
    assert_eq!(names(&in_scope(hidden, "").replace("def Xform", "def")), ["/X/Q"]);
    assert_eq!(names(&in_scope(&purpose("guide"), "").replace("def Xform", "def")), ["/X/Q"]);
    let api = |more: &str| {
        let text = in_scope(&format!("{}\n{more}", purpose("render")), "");
        text.replacen("\"X\"", "\"X\" ( apiSchemas = [\"VisibilityAPI\"] )", 1)
    };
    assert_eq!(names(&api("")), ["/X/Q"]);
    assert!(names(&api("token renderVisibility = \"invisible\"")).is_empty());
}

#[test]
fn prims_that_are_no_transforms_do_not_move() {
    let op = "double3 xformOp:translate = (5, 0, 0)\nuniform token[] xformOpOrder = [\"xformOp:translate\"]";
    for (kind, left) in [("Xform", 5.0), ("Scope", 0.0), ("", 0.0)] {
        let scene = load(&format!("def {kind} \"X\" {{ {op}\n{} }}", quad("Q", ""))).unwrap();
        assert_eq!(colors(&scene)[0].1, left, "{kind}");
        assert_eq!(notes(&scene).is_empty(), kind == "Xform", "{kind}");
    }
}

#[test]
fn whole_numbers_hold_until_the_next_sample() {
    let text = format!(
        r#"def PointInstancer "P" {{
    rel prototypes = [</P/A>, </P/B>, </P/C>]
    int[] protoIndices.timeSamples = {{ 0: [0], 48: [2] }}
    point3f[] positions.timeSamples = {{ 0: [(0, 0, 0)], 48: [(10, 0, 0)] }}
    {}{}{} }}"#,
        quad("A", "color3f[] primvars:displayColor = [(1, 0, 0)]"),
        quad("B", "color3f[] primvars:displayColor = [(0, 1, 0)]"),
        quad("C", "color3f[] primvars:displayColor = [(0, 0, 1)]")
    );
    let at = |seconds: f64| {
        let options = LoadOptions { at: Some(seconds), ..LoadOptions::default() };
        colors(&load_with(&text, &[], &options).unwrap())[0].clone()
    };
    for (seconds, left, color) in [(0.0, 0.0, RED), (1.0, 5.0, RED), (2.0, 10.0, BLUE)] {
        assert_eq!(at(seconds), ("/P".to_owned(), left, color), "{seconds} s");
    }
}

#[test]
fn bindings_by_collections_are_noted_wherever_they_stand() {
    let bind = "rel material:binding:collection:a = [</X.collection:a>, </L/red>]\n";
    let collection = |text: String| {
        let scene = load(&format!("{LOOKS}{text}")).unwrap();
        notes(&scene).iter().any(|(_, message)| message.contains("material:binding:collection"))
    };
    assert!(collection(format!("def Xform \"X\" {{ {bind}{} }}", quad("Q", ""))));
    assert!(collection(two_faces("", bind)));
    assert!(collection(instancer("", bind, "")));
    assert!(!collection(quad("Q", "")));
}
