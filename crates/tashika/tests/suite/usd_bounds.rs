//! USD files in which prims double repeatedly, in any way. Work and memory are bounded in
//! proportion to the bytes of the file.
//!
//! Each text here stands for more than 2³⁰ prims, opinions or instances. Without the bounds the
//! tests would not end.

use super::usd::{load, quad};

/// Number of doublings.
const LEVELS: usize = 30;

/// Returns prims `/L1` and so on, each with two children that are composed of the previous prim.
fn nested(arc: &str) -> String {
    let prim = |name: &str, below: usize| format!("def Xform \"{name}\" ( {arc} = </L{below}> ) {{ }}\n");
    let level = |i: usize| format!("class \"L{i}\" {{\n{}{}}}\n", prim("a", i - 1), prim("b", i - 1));
    let levels: String = (1..=LEVELS).map(level).collect();
    quad("L0", "") + &levels + &prim("W", LEVELS)
}

/// Returns prims each of which is composed of two others.
fn listed(arc: &str) -> String {
    let level = |i: usize| {
        let below = i - 1;
        let prim = |name: &str| format!("class \"{name}{i}\" ( {arc} = [</a{below}>, </b{below}>] ) {{ }}\n");
        prim("a") + &prim("b")
    };
    let levels: String = (1..=LEVELS).map(level).collect();
    quad("a0", "") + &quad("b0", "") + &levels + &format!("def Xform \"W\" ( {arc} = </a{LEVELS}> ) {{ }}\n")
}

/// Returns the error of a text and checks that it has a location.
fn refused(text: &str) -> String {
    let error = load(text).unwrap_err().to_string();
    let (_, place) = error.split_once("s.usda:").unwrap_or_else(|| panic!("no file: {error}"));
    let line = place.split(':').next().and_then(|line| line.parse::<usize>().ok());
    assert!(line.is_some(), "no line: {error}");
    assert!(place.contains(": /"), "no prim: {error}");
    error
}

#[test]
fn prims_that_double_are_refused_with_what_doubles() {
    for arc in ["references", "payload", "inherits", "specializes"] {
        for text in [nested(arc), listed(arc)] {
            let error = refused(&text);
            assert!(error.contains("times, by references"), "{arc}: {error}");
        }
    }
    let variant = |i: usize| {
        format!(
            "class \"L{i}\" ( variants = {{ string v = \"x\" }}\n prepend variantSets = \"v\" ) {{ variantSet \"v\" = {{ \"x\" {{
    def \"a\" ( references = </L{0}> ) {{ }}\n def \"b\" ( references = </L{0}> ) {{ }} }} }} }}\n",
            i - 1
        )
    };
    let levels: String = (1..=LEVELS).map(variant).collect();
    refused(&(quad("L0", "") + &levels + &format!("def \"W\" ( references = </L{LEVELS}> ) {{ }}\n")));
    let shared = nested("instanceable = true\n references");
    refused(&shared);
}

#[test]
fn instances_are_bounded_by_the_bytes_of_the_file() {
    // 20,000 cubes at 20,000 points each, in a text of one megabyte.
    let cubes: String = (0..20_000).map(|i| format!("def Cube \"c{i}\" {{ }}\n")).collect();
    let points = |each: &str| vec![each; 20_000].join(", ");
    let text = format!(
        "def Xform \"P\" {{\n{cubes}}}\ndef PointInstancer \"W\" {{ rel prototypes = </P>\n int[] protoIndices = [{}]\n point3f[] positions = [{}] }}\n",
        points("0"),
        points("(0, 0, 0)")
    );
    let error = refused(&text);
    assert!(error.contains("more bytes of geometry"), "{error}");
}

#[test]
fn copies_of_copies_of_usual_numbers_are_read() {
    // 40 × 40 × 20 prims in a text of 8 kB.
    let repeat = |name: &str, of: &str| -> String {
        (0..40).map(|i| format!("def Xform \"{name}{i}\" ( references = </{of}> ) {{ }}\n")).collect()
    };
    let leaves: String = (0..20).map(|i| quad(&format!("q{i}"), "")).collect();
    let text = format!(
        "class \"A\" {{ {leaves} }}\nclass \"B\" {{ {} }}\ndef \"W\" {{ {} }}\n",
        repeat("b", "A"),
        repeat("w", "B")
    );
    assert_eq!(load(&text).unwrap().instances().len(), 40 * 40 * 20);
}
