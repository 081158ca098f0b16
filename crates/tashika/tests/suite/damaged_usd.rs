//! Damaged USD files. Loading gives an error or a scene. It never panics, and never takes more
//! memory than the size of the file justifies.

use std::path::Path;

use tashika::error::Error;
use tashika::io::LoadOptions;

use super::gltf::load_in;
use super::usd::{SAMPLES, load, quad, whole};
use crate::cases::lenient;

struct Numbers(u64);

impl Numbers {
    /// A number below `n`, by a linear congruential generator.
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(SAMPLES).join(name)).unwrap()
}

/// Lenient options with a small limit on sizes. Sizes that a file claims may exceed the limit; then
/// nothing may be allocated for them.
fn small() -> LoadOptions {
    LoadOptions { max_file_bytes: 1 << 22, at: Some(1.0), ..lenient() }
}

#[test]
fn files_that_are_cut_off_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["simple.usdc", "simple.usdz", "packed.usdz", "simple.usda", "parts/chair.usdc"] {
        let all = bytes(name);
        let ending = name.rsplit('.').next().unwrap();
        // A text that ends before its first prim or after its last brace is valid.
        let last = all.iter().rposition(|b| !b.is_ascii_whitespace()).unwrap();
        let first =
            if ending == "usda" { all.windows(9).position(|w| w == b"def Xform").unwrap() + 1 } else { 0 };
        for length in (first..last).step_by(if ending == "usda" { 7 } else { 5 }) {
            let result = load_in(folder.path(), &format!("c.{ending}"), &all[..length], &small());
            assert!(result.is_err(), "{length} bytes of {name}");
        }
    }
}

#[test]
fn mutated_bytes_do_not_panic() {
    let folder = tempfile::tempdir().unwrap();
    let mut numbers = Numbers(1);
    for (name, rounds) in [
        ("simple.usda", 1500),
        ("composed.usda", 1000),
        ("simple.usdc", 3000),
        ("values.usdc", 3000),
        ("parts/chair.usdc", 3000),
        ("packed.usdz", 1500),
    ] {
        let whole = bytes(name);
        let ending = name.rsplit('.').next().unwrap();
        let mut errors = 0;
        for _ in 0..rounds {
            let mut mutated = whole.clone();
            for _ in 0..=numbers.below(3) {
                let place = numbers.below(mutated.len());
                mutated[place] = match numbers.below(3) {
                    0 => mutated[place] ^ (1 << numbers.below(8)),
                    1 => numbers.below(256) as u8,
                    _ => b"0123456789-{}[]()<>@\",:#"[numbers.below(24)],
                };
            }
            errors +=
                usize::from(load_in(folder.path(), &format!("m.{ending}"), &mutated, &small()).is_err());
        }
        assert!(errors > rounds / 20 && errors < rounds, "{name}: {errors} of {rounds}");
    }
}

/// Eight bytes of a file, at each position in turn, are replaced with the largest number. Among
/// them are sizes and offsets.
#[test]
fn claimed_sizes_are_held_against_the_bytes_that_are_there() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["simple.usdc", "parts/chair.usdc", "values.usdc", "packed.usdz"] {
        let whole = bytes(name);
        let ending = name.rsplit('.').next().unwrap();
        for at in (0..whole.len() - 8).step_by(4) {
            for claim in [u64::MAX, 1 << 40, 0x00ff_ffff_ffff] {
                let mut mutated = whole.clone();
                mutated[at..at + 8].copy_from_slice(&claim.to_le_bytes());
                let _ = load_in(folder.path(), &format!("m.{ending}"), &mutated, &small());
            }
        }
    }
}

#[test]
fn texts_name_the_line_and_what_was_expected() {
    for (text, line, expected) in [
        ("def Mesh \"W\" { int[] a = [1, 2 }", 6, "a value"),
        ("def Mesh \"W\"\n{\n  int a = \n}", 9, "a value"),
        ("def Mesh W { }", 6, "a string"),
        ("float a = 1", 6, "def, over or class"),
        ("def \"W\" ( references = 3 ) { }", 6, "@file@, </prim> or None"),
        ("def \"W\" { point3f[] p = [(1, 2, 3), (1, 2)] }", 6, "3, as before it"),
        ("def \"W/X\" { }", 6, "a name"),
        ("def \"W\" { float a.timeSamples = { nan: 1 } }", 6, "time codes"),
    ] {
        let error = load(text).unwrap_err().to_string();
        assert!(error.contains(&format!("s.usda:{line}: ")) && error.ends_with(expected), "{text}: {error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let error = load_in(folder.path(), "s.usda", b"def \"W\" { }", &small()).unwrap_err().to_string();
    assert!(error.ends_with("s.usda:1: a file that begins otherwise; expected #usda 1.0"), "{error}");
    let error = load_in(folder.path(), "s.usdc", b"PXR-USDC\x00\x02\x00\x00", &small()).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }), "{error}");
}

#[test]
fn deep_texts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let deep = |open: &str, close: &str, middle: &str| {
        format!("{}{middle}{}", open.repeat(100_000), close.repeat(100_000))
    };
    for text in [
        deep("def \"A\" {", "}", ""),
        format!("def \"A\" {{ float3[] a = {} }}", deep("[", "]", "")),
        format!("def \"A\" {{ float3[] a = {} }}", deep("(", ")", "1")),
    ] {
        assert!(load_in(folder.path(), "d.usda", whole(&text).as_bytes(), &small()).is_err());
    }
}

#[test]
fn faces_that_their_points_do_not_have_are_refused() {
    for (what, expected) in [
        ("int[] faceVertexIndices = [0, 1, 2, 4]", "an index from 0 to 3"),
        ("int[] faceVertexIndices = [0, 1, 2, -1]", "an index from 0 to 3"),
        ("int[] faceVertexCounts = [5]", "at most 4, as there are indices"),
        ("int[] faceVertexCounts = [-1, 5]", "at most 4, as there are indices"),
    ] {
        let error = load(&quad("W", what)).unwrap_err().to_string();
        assert!(error.contains("s.usda:6: /W.face") && error.ends_with(expected), "{what}: {error}");
    }
    let without = load(&quad("W", "point3f[] points = []")).unwrap();
    assert_eq!(without.instances().len(), 0);
}
