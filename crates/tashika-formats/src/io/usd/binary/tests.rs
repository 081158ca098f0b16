//! Compares layers that Pixar's library wrote in both encodings, as text and as binary files.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::super::layer::{Layer, Stored};
use super::super::text;
use super::super::value::Value;
use super::*;

/// Path of a file that `scripts/usd_samples.py` wrote.
fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tashika/tests/suite/usd").join(name)
}

fn read(name: &str) -> Layer {
    let path = path(name);
    let bytes = std::fs::read(&path).unwrap();
    if name.ends_with('a') {
        return text::parse(&bytes, &path).unwrap();
    }
    let to = bytes.len();
    parse(Bytes { all: Rc::new(bytes), from: 0, to }, &path, 1 << 20).unwrap()
}

/// Compares values up to the precision of the text. It has six digits for halves, and for floats
/// enough digits to restore them.
fn alike(a: &Value, b: &Value) -> bool {
    let near = |a: &[f64], b: &[f64]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-6 * a.abs())
    };
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => near(&[*a], &[*b]),
        (Value::Tuple(a), Value::Tuple(b)) => near(a, b),
        (Value::Array { width: w, numbers: a }, Value::Array { width: v, numbers: b }) => {
            near(a, b) && (w == v || a.is_empty())
        }
        (a, b) => a == b,
    }
}

#[test]
fn both_encodings_have_the_same_values() {
    let (written, packed) = (read("values.usda"), read("values.usdc"));
    let of = |layer: &Layer, stored: &Stored| layer.value(stored, &Location::default()).unwrap();
    let (a, b) = (&written.prims[1].properties, &packed.prims[1].properties);
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    assert!(a.len() > 30, "{}", a.len());
    for (name, property) in a {
        let other = &b[name];
        if let Some(stored) = &property.value {
            let (a, b) = (of(&written, stored), of(&packed, other.value.as_ref().unwrap()));
            assert!(alike(&a, &b) && a != Value::Other, "{name}: {a:?} {b:?}");
        }
        assert_eq!(property.samples.len(), other.samples.len(), "{name}");
        for ((time, a), (t, b)) in property.samples.iter().zip(&other.samples) {
            assert!(time == t && alike(&of(&written, a), &of(&packed, b)), "{name} at {time}");
        }
    }
    assert_eq!(a["moving"].samples.len(), 3);
}

#[test]
fn both_encodings_say_the_same_of_prims() {
    let (written, packed) = (read("simple.usda"), read("simple.usdc"));
    assert_eq!(written.prims.len(), packed.prims.len());
    fn same(a: &Layer, b: &Layer, i: u32, j: u32) {
        let (p, q) = (&a.prims[i as usize], &b.prims[j as usize]);
        assert_eq!((p.specifier, &p.type_name, &p.schemas), (q.specifier, &q.type_name, &q.schemas));
        let names = |prim: &super::super::layer::PrimSpec| {
            prim.children.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>()
        };
        assert_eq!(names(p), names(q));
        for (name, property) in &p.properties {
            let other = &q.properties[name];
            assert_eq!(
                (&property.targets, &property.connections),
                (&other.targets, &other.connections),
                "{name}"
            );
            assert_eq!(property.interpolation, other.interpolation, "{name}");
        }
        for ((_, i), (_, j)) in p.children.iter().zip(&q.children) {
            same(a, b, *i, *j);
        }
    }
    // Prim 0 stands for the file itself: only its children and metadata are compared.
    for (name, i) in &written.prims[0].children {
        same(&written, &packed, *i, packed.prims[0].by_name[name]);
    }
    let metadata = |layer: &Layer| (layer.metadata.default_prim.clone(), layer.metadata.meters_per_unit);
    assert_eq!(metadata(&written), metadata(&packed));
    assert_eq!(metadata(&packed), (Some("World".into()), Some(1.0)));
}
