//! Small files that would cause much work: each is rejected with an error that names the limit and
//! the location.
//!
//! Without its limit, each construct took more than a second or more than a gigabyte of memory per
//! megabyte of input. These tests do not measure time; `scripts/fuzz_program.py --scale` times
//! these families of files and eighty others.

use std::fmt::Write;

use tashika::error::{Error, Result};
use tashika::scene::Scene;

use super::cases::lenient;
use super::textures;

fn load(name: &str, text: &str) -> Result<Scene> {
    textures::load(name, text, &[], &lenient())
}

fn mitsuba(body: &str) -> String {
    let error = load("a.xml", &format!("<scene version=\"3.0.0\">\n{body}</scene>")).unwrap_err();
    assert!(matches!(error, Error::Invalid { .. }), "{error}");
    error.to_string()
}

/// Joins the results of `make` for 0 to `n − 1`.
fn joined(n: usize, make: impl Fn(usize) -> String) -> String {
    (0..n).map(make).collect()
}

#[test]
fn namespaces_and_attributes_of_xml_are_limited() {
    // Without the limit, 322 kB of this took over a minute. Then the 6000 declarations are divided
    // among six elements that enclose the others.
    let elements = joined(6000, |i| format!("<n{i}:x xmlns:m{i}=\"v\"/>"));
    let declared = |from: usize, to: usize| joined(to - from, |i| format!(" xmlns:n{0}=\"u{0}\"", from + i));
    let error = mitsuba(&format!("<shape{}>{elements}</shape>", declared(0, 6000)));
    assert!(error.contains("a.xml:2:1: an element with 6000 attributes; expected at most 1024"), "{error}");
    let around = joined(6, |i| format!("<shape{}>", declared(1000 * i, 1000 * (i + 1))));
    let error = mitsuba(&format!("{around}{elements}{}", "</shape>".repeat(6)));
    assert!(error.contains("a.xml:2:1: 1000 declarations of namespaces; expected at most 64"), "{error}");
    let attributes = joined(300_000, |i| format!(" a{i}=\"\""));
    let error = mitsuba(&format!("<shape{attributes}/>"));
    assert!(error.contains("a.xml:2:1: an element with 300000 attributes; expected at most 1024"), "{error}");
    let stage = "#usda 1.0\ndef \"M\" ( references = @a.mtlx@</MaterialX/Materials/M> ) { }\n";
    let document = format!("<materialx version=\"1.38\">\n<constant{attributes}/></materialx>");
    let files: &[(&str, &[u8])] = &[("a.mtlx", document.as_bytes())];
    let scene = textures::load("a.usda", stage, files, &lenient());
    let said = match scene {
        Err(error) => error.to_string(),
        Ok(scene) => scene.notes().iter().map(|note| format!("{}: {}\n", note.first, note.message)).collect(),
    };
    assert!(said.contains("an element with 300000 attributes; expected at most 1024"), "{said}");
}

#[test]
fn defaults_that_double_say_what_doubles() {
    let doubling = joined(40, |i| format!("<default name=\"b{}\" value=\"$b{i}$b{i}\"/>\n", i + 1));
    let error = mitsuba(&format!("<default name=\"b0\" value=\"xx\"/>\n{doubling}"));
    // The default `b0` in line 2 has two characters, and each further default doubles the previous
    // one. After twenty doublings, `b20` in line 22 exceeds the limit.
    let expected = "a.xml:22:1: the attribute value of <default>, more than 1048576 bytes long where $b19 is \
                    replaced; expected a shorter text: does one default double another?";
    assert!(error.ends_with(expected), "{error}");
    // A long default that replaces `$b` a thousand times.
    let long = "x".repeat(1 << 20);
    let error = mitsuba(&format!(
        "<default name=\"b\" value=\"{long}\"/>\n{}",
        "<shape type=\"$b\"/>\n".repeat(1000)
    ));
    let expected = "more bytes of attributes with replaced names; expected at most 67108864 bytes";
    assert!(error.contains("a.xml:67:1") && error.contains(expected), "{error}");
}

#[test]
fn materials_of_materialx_have_names_of_a_limited_length() {
    // Each input stores the path of its material.
    let name = "m".repeat(20_000);
    let inputs = joined(20_000, |i| format!("<input name=\"i{i}\" nodename=\"n\"/>"));
    let document = format!(
        "<materialx version=\"1.38\">\n<surfacematerial name=\"{name}\">{inputs}</surfacematerial></materialx>"
    );
    let stage = "#usda 1.0\ndef \"M\" ( references = @a.mtlx@</MaterialX/Materials/M> ) { }\n";
    let scene = textures::load("a.usda", stage, &[("a.mtlx", document.as_bytes())], &lenient());
    let said = match scene {
        Err(error) => error.to_string(),
        Ok(scene) => scene.notes().iter().map(|note| note.message).collect(),
    };
    assert!(said.contains("a name of 20000 bytes; expected at most 1024"), "{said}");
}

#[test]
fn defaults_of_pbrt_are_limited_in_all() {
    // Each saved state and each shape copies the parameters given by `Attribute`.
    let text = joined(8000, |i| format!("AttributeBegin Attribute \"shape\" \"float a{i}\" 1\n"));
    let error = load("a.pbrt", &format!("WorldBegin\n{text}")).unwrap_err().to_string();
    assert!(error.contains("bytes of parameters by Attribute; expected at most 32768"), "{error}");
    let line: u32 = error.split(':').nth(1).and_then(|line| line.parse().ok()).unwrap();
    assert!((100..1000).contains(&line), "{error}");
    let mut long = String::from("WorldBegin Attribute \"shape\" \"float P\" [");
    (0..9000).for_each(|i| write!(long, "{i} ").unwrap());
    let error = load("a.pbrt", &(long + "]")).unwrap_err().to_string();
    assert!(error.contains("bytes of parameters by Attribute"), "{error}");
}
