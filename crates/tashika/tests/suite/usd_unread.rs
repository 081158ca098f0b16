//! Properties of USD files that are not read. Properties of schemas are noted by their row of the
//! table, others by name.

use tashika::scene::NoteKind;

use super::gltf::notes;
use super::usd::{load, quad};

fn said(text: &str) -> Vec<(NoteKind, String)> {
    notes(&load(text).unwrap_or_else(|e| panic!("{text}: {e}")))
}

#[test]
fn names_that_no_schema_has_are_noted_unless_they_are_the_users_own() {
    for (property, name) in [
        ("int[] holeIndexes = [0]", "holeIndexes"),
        ("float displaycolour = 1", "displaycolour"),
        ("rel materialBinding = </M>", "materialBinding"),
    ] {
        let expected = format!("attribute {name:?} is unknown: not read");
        assert_eq!(said(&quad("W", property)), [(NoteKind::Ignored, expected)], "{property}");
    }
    let light = quad("W", "") + "def RectLight \"L\" { float inputs:brightness = 2 }";
    let expected = "attribute \"inputs:brightness\" is unknown: not read";
    assert_eq!(said(&light), [(NoteKind::Ignored, expected.to_owned())]);
    for own in [
        "custom float mine = 1",
        "string userProperties:tag = \"a\"",
        "float[] primvars:age = [1] ( interpolation = \"constant\" )",
        "double studio:weight = 3",
        "bool physics:collisionEnabled = true",
    ] {
        assert_eq!(said(&quad("W", own)), [], "{own}");
    }
    // Many unknown names give a limited number of notes.
    let many: String = (0..80).map(|i| format!("int odd{i} = 1\n")).collect();
    assert_eq!(said(&quad("W", &many)).len(), 51);
}

#[test]
fn names_of_other_renderers_are_one_note() {
    let more = "int primvars:arnold:subdiv_iterations = 2\nbool ri:attributes:visibility = true\nint karma:object:x = 1";
    let found = said(&quad("W", more));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].1.starts_with("attribute \"of other renderers\""), "{found:?}");
}

#[test]
fn fallbacks_of_schemas_are_no_reason_for_a_note() {
    let camera =
        "def Camera \"C\" { float exposure = 0\n float exposure:iso = 100\n float2 clippingRange = (1, 100)
        float4[] clippingPlanes = []\n double shutter:open = 0 }";
    let light =
        "def RectLight \"L\" { bool inputs:shadow:enable = true\n color3f inputs:shadow:color = (0, 0, 0)
        float inputs:shaping:focus = 0\n uniform bool collection:lightLink:includeRoot = true }";
    assert_eq!(said(&(quad("W", "uniform token model:drawMode = \"inherited\"") + camera + light)), []);
}

#[test]
fn a_prim_of_a_layer_is_looked_at_once() {
    let copies: String = (0..50).map(|i| format!("def \"C{i}\" ( references = </W> ) {{ }}\n")).collect();
    let scene = load(&(quad("W", "int odd = 1") + &copies)).unwrap();
    let note = scene.notes().iter().find(|note| note.message.contains("odd")).unwrap();
    assert_eq!((scene.instances().len(), note.count), (51, 1));
}
