//! Damaged and hostile Mitsuba files. Loading gives an error that names the fault and its place, or
//! a scene with a note. It never panics, and never takes more memory or time than the size of the
//! files justifies.
//!
//! A mutated file may still be valid, so the mutation tests only require that loading returns, and
//! that errors name the file. They do not prove that no other bytes cause a panic.

use tashika::error::{Error, Result};
use tashika::scene::{NoteKind, Scene};

use super::mitsuba::{Files, four_colours, load_in, serialized, vol, xml};

use crate::cases::lenient;

/// A scene that uses every feature that the loader reads.
const RICH: &str = r##"<default name="spp" value="4"/><default name="kind" value="volpath"/>
<integrator type="$kind"><integer name="max_depth" value="8"/></integrator>
<sensor type="thinlens" id="view"><float name="fov" value="40"/><float name="aperture_radius" value="0.1"/>
<float name="focus_distance" value="3"/><transform name="to_world"><lookat origin="0,1,-5" target="0,0,0" up="0,1,0"/></transform>
<sampler type="independent"><integer name="sample_count" value="${spp}"/></sampler>
<film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor>
<texture type="bitmap" id="wood"><string name="filename" value="a.png"/><transform name="to_uv"><scale x="2" y="3"/></transform></texture>
<bsdf type="twosided" id="floor"><bsdf type="roughplastic"><ref id="wood" name="diffuse_reflectance"/><float name="alpha" value="0.2"/></bsdf></bsdf>
<bsdf type="mixturebsdf" id="mix"><string name="weights" value="0.5, 0.5"/><ref id="floor"/><bsdf type="conductor"><string name="material" value="Cu"/></bsdf></bsdf>
<bsdf type="mask" id="leaf"><texture type="checkerboard" name="opacity"/><bsdf type="difftrans"/></bsdf>
<shape type="rectangle"><ref id="floor"/><transform name="to_world"><rotate x="1" angle="-90"/><scale value="5"/></transform></shape>
<shape type="serialized"><string name="filename" value="m.serialized"/><integer name="shape_index" value="0"/><ref id="mix"/></shape>
<shape type="shapegroup" id="g"><shape type="sphere"><float name="radius" value="0.5"/><ref id="leaf"/></shape></shape>
<shape type="instance"><ref id="g"/><transform name="to_world"><matrix value="1 0 0 2 0 1 0 0 0 0 1 0 0 0 0 1"/></transform></shape>
<shape type="cube"><bsdf type="diffuse"><spectrum name="reflectance" value="400:0.1, 500:0.5, 700:0.9"/></bsdf>
<emitter type="area"><blackbody name="radiance" temperature="3000" scale="0.01"/></emitter></shape>
<emitter type="spot"><float name="cutoff_angle" value="30"/></emitter>
<medium type="homogeneous" id="fog"><rgb name="sigma_t" value="1, 2, 3"/><rgb name="albedo" value="0.5"/>
<phase type="hg"><float name="g" value="0.3"/></phase></medium>
<shape type="disk"><bsdf type="null"/><ref name="interior" id="fog"/></shape>
<medium type="heterogeneous" id="smoke"><volume type="gridvolume" name="sigma_t"><string name="filename" value="a.vol"/>
<transform name="to_world"><scale x="2" y="1" z="3"/></transform><boolean name="use_grid_bbox" value="true"/></volume>
<volume type="gridvolume" name="albedo"><string name="filename" value="a.vol"/></volume><float name="scale" value="2"/></medium>
<shape type="cube"><bsdf type="null"/><ref name="interior" id="smoke"/></shape>
<emitter type="sun"><float name="turbidity" value="4"/></emitter>"##;

fn load_bytes(bytes: &[u8], files: Files<'_>) -> Result<Scene> {
    let mut all = vec![("scene.xml", bytes)];
    all.extend_from_slice(files);
    load_in(&all).1
}

fn load(body: &str) -> Result<Scene> {
    load_bytes(xml("3.0.0", body).as_bytes(), &[])
}

/// The message of an error of kind `Invalid`.
#[track_caller]
fn invalid(body: &str) -> String {
    match load(body) {
        Err(error @ Error::Invalid { .. }) => error.to_string(),
        other => panic!("{body}: {other:?}"),
    }
}

/// Pseudorandom numbers; the same in every run.
struct Numbers(u64);

impl Numbers {
    /// Returns a number from 0 to `n` − 1.
    fn below(&mut self, n: usize) -> usize {
        // Steele, Lea, Flood. "Fast Splittable Pseudorandom Number Generators." OOPSLA 2014.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// Loads many versions of the scene file in one folder.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.png"), four_colours()).unwrap();
        std::fs::write(folder.path().join("m.serialized"), serialized()).unwrap();
        std::fs::write(folder.path().join("a.vol"), vol([1, 2, 1], 3, &[0.5; 6])).unwrap();
        Self(folder)
    }

    fn load(&self, bytes: &[u8]) -> Result<Scene> {
        let path = self.0.path().join("scene.xml");
        let _ = std::fs::remove_file(&path);
        std::fs::write(&path, bytes).unwrap();
        tashika::io::load_scene(&path, &lenient())
    }
}

#[test]
fn the_undamaged_scene_is_sound() {
    let scene = Folder::new().load(xml("3.0.0", RICH).as_bytes()).unwrap();
    assert_eq!((scene.instances().len(), scene.emitters().len(), scene.area_emitters().count()), (6, 2, 1));
    assert!(scene.has_media());
    let unused =
        scene.notes().iter().find(|n| n.message.contains("not used") || n.kind == NoteKind::Repaired);
    assert_eq!(unused, None);
}

#[test]
fn truncated_at_every_byte() {
    let whole = xml("3.0.0", RICH);
    let folder = Folder::new();
    for length in 0..whole.trim_end().len() {
        let error = folder.load(&whole.as_bytes()[..length]).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{length}: {error}");
    }
}

#[test]
fn mutated_bytes_and_values_do_not_panic() {
    let whole = xml("3.0.0", RICH).into_bytes();
    let folder = Folder::new();
    let mut numbers = Numbers(1);
    let mut errors = 0;
    let hostile: [&[u8]; 12] = [
        b"nan",
        b"-1",
        b"1e999",
        b"0",
        b"99999999999999999999",
        b"",
        b"$",
        b"$x",
        b"../x",
        b"floor",
        b"1 2",
        b"-1e30",
    ];
    for round in 0..3000 {
        let mut mutated = whole.clone();
        if round % 2 == 0 {
            for _ in 0..=numbers.below(3) {
                let place = numbers.below(mutated.len());
                mutated[place] = match numbers.below(3) {
                    0 => mutated[place] ^ (1 << numbers.below(8)),
                    1 => numbers.below(256) as u8,
                    _ => b"0123456789-<>\"=/ $:"[numbers.below(19)],
                };
            }
        } else {
            // Replaces the value of one attribute.
            let quotes: Vec<usize> =
                mutated.iter().enumerate().filter(|(_, b)| **b == b'"').map(|(i, _)| i).collect();
            let pair = 2 * numbers.below(quotes.len() / 2);
            let value = hostile[numbers.below(hostile.len())];
            mutated.splice(quotes[pair] + 1..quotes[pair + 1], value.iter().copied());
        }
        if let Err(error) = folder.load(&mutated) {
            errors += 1;
            assert!(
                ["scene.xml", "m.serialized", "a.vol"].iter().any(|file| error.to_string().contains(file)),
                "{error}"
            );
        }
    }
    assert!((300..2990).contains(&errors), "{errors}: the mutations are neither harmless nor all fatal");
}

#[test]
fn errors_name_line_column_value_and_what_is_expected() {
    let text = invalid("<shape type=\"sphere\">\n  <float name=\"radius\" value=\"x\"/></shape>");
    assert!(text.contains("scene.xml:3:3: <float> of value \"x\"; expected a finite number"), "{text}");
    for (body, part) in [
        ("<shape type=\"sphere\"><float name=\"radius\" value=\"nan\"/></shape>", "finite"),
        (
            "<shape type=\"cube\"><transform name=\"to_world\"><matrix value=\"1 2 3\"/></transform></shape>",
            "16 or 9",
        ),
        ("<bsdf type=\"diffuse\"><rgb value=\"1\"/></bsdf>", "without a name"),
        ("<bsdf type=\"diffuse\"><rgb name=\"reflectance\"/></bsdf>", "without a value"),
        ("<ref/>", "without id"),
    ] {
        let text = invalid(body);
        assert!(text.contains(part) && text.contains("scene.xml:2:"), "{text}");
    }
    // A mesh outside the folder is not read; it counts as missing.
    let outside = "<shape type=\"obj\"><string name=\"filename\" value=\"../m.obj\"/></shape>";
    let scene = load(outside).unwrap();
    let note = scene.notes().iter().find(|note| note.kind == NoteKind::Missing).unwrap();
    assert!(note.message.contains("allow-outside") && note.first.line == Some(2), "{note:?}");
}

#[test]
fn files_that_are_no_scenes_say_so() {
    let refused = |bytes: &[u8]| load_bytes(bytes, &[]).unwrap_err().to_string();
    assert!(refused(b"<html><body/></html>").contains("not a Mitsuba scene"));
    assert!(refused(b"").contains("well-formed XML"));
    assert!(refused(b"\x89PNG\r\n\x1a\n\0\0\0").contains("scene.xml"));
    assert!(refused(b"<scene version=\"new\"/>").contains("a version such as"));
    let bomb = b"<!DOCTYPE s [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">]><scene version=\"3.0.0\">&b;</scene>";
    assert!(refused(bomb).contains("document type"), "entities are not expanded");
    assert!(load_bytes(b"<scene/>", &[]).is_ok(), "an empty scene is one");
}

#[test]
fn circles_of_references_and_includes_are_errors() {
    for body in [
        "<bsdf type=\"twosided\" id=\"a\"><ref id=\"a\"/></bsdf><shape type=\"cube\"><ref id=\"a\"/></shape>",
        "<bsdf type=\"twosided\" id=\"a\"><ref id=\"b\"/></bsdf><bsdf type=\"mask\" id=\"b\"><ref id=\"a\"/></bsdf><shape type=\"cube\"><ref id=\"a\"/></shape>",
        "<texture type=\"scale\" id=\"t\"><ref id=\"t\"/></texture><shape type=\"cube\"><bsdf type=\"diffuse\"><ref id=\"t\" name=\"reflectance\"/></bsdf></shape>",
        "<shape type=\"merge\" id=\"s\"><ref id=\"s\"/></shape>",
    ] {
        let text = invalid(body);
        assert!(text.contains("refers to itself") && text.contains("scene.xml:2:"), "{text}");
    }
    let text = invalid("<include filename=\"scene.xml\"/>");
    assert!(text.contains("does it include itself"), "{text}");
    let missing = load("<shape type=\"cube\"><ref id=\"none\"/></shape>").unwrap();
    let note = missing.notes().iter().find(|n| n.kind == NoteKind::Repaired).unwrap();
    assert!(note.message.contains("\"none\", which is not defined"));
    assert!(matches!(load("<include filename=\"none.xml\"/>"), Err(Error::Io { .. })));
}

#[test]
fn nesting_is_limited_and_sharing_does_not_multiply() {
    for depth in [63, 100_000] {
        let deep = format!("{}{}", "<bsdf type=\"twosided\">".repeat(depth), "</bsdf>".repeat(depth));
        assert_eq!(load(&deep).is_ok(), depth < 64, "{depth}");
    }
    let mut chain = String::from("<bsdf type=\"diffuse\" id=\"m0\"/>");
    for i in 1..5000 {
        chain += &format!("<bsdf type=\"twosided\" id=\"m{i}\"><ref id=\"m{}\"/></bsdf>", i - 1);
    }
    let text = invalid(&format!("{chain}<shape type=\"cube\"><ref id=\"m4999\"/></shape>"));
    assert!(text.contains("deep in each other"), "{text}");
    // Each texture refers twice to the previous one, which makes 2³⁹ paths.
    let mut doubled = String::from("<texture type=\"checkerboard\" id=\"t0\"/>");
    for i in 1..40 {
        doubled += &format!(
            "<texture type=\"checkerboard\" id=\"t{i}\"><ref id=\"t{0}\" name=\"color0\"/><ref id=\"t{0}\" name=\"color1\"/></texture>",
            i - 1
        );
    }
    let body = format!(
        "{doubled}<shape type=\"cube\"><bsdf type=\"diffuse\"><ref id=\"t39\" name=\"reflectance\"/></bsdf></shape>"
    );
    // The builder may accept or refuse such a texture. This test only requires that loading
    // returns.
    drop(load(&body));
    let mut mixes = String::from("<bsdf type=\"diffuse\" id=\"m0\"/>");
    for i in 1..30 {
        mixes += &format!(
            "<bsdf type=\"blendbsdf\" id=\"m{i}\"><ref id=\"m{0}\"/><ref id=\"m{0}\"/></bsdf>",
            i - 1
        );
    }
    drop(load(&format!("{mixes}<shape type=\"cube\"><ref id=\"m29\"/></shape>")));
}

#[test]
fn includes_do_not_multiply_without_limit() {
    let twice = |name: &str| xml("3.0.0", &format!("<include filename=\"{name}\"/>").repeat(8));
    let (a, b, c, d) = (twice("b.xml"), twice("c.xml"), twice("d.xml"), twice("e.xml"));
    let e = xml("3.0.0", "");
    let files: Files<'_> =
        &[("b.xml", b.as_bytes()), ("c.xml", c.as_bytes()), ("d.xml", d.as_bytes()), ("e.xml", e.as_bytes())];
    let error = load_bytes(a.as_bytes(), files).unwrap_err().to_string();
    assert!(error.contains("at most") && error.contains(".xml:2:"), "{error}");
}

#[test]
fn instances_do_not_multiply_without_limit() {
    let cubes = "<shape type=\"cube\"/>".repeat(2000);
    let instances = "<shape type=\"instance\"><ref id=\"g\"/></shape>".repeat(2000);
    let error = load(&format!("<shape type=\"shapegroup\" id=\"g\">{cubes}</shape>{instances}")).unwrap_err();
    assert!(
        matches!(error, Error::Unsupported { .. }) && error.to_string().contains("placements"),
        "{error}"
    );
}

#[test]
fn serialized_meshes_that_claim_too_much_are_refused() {
    let mut raw = 0x1000_u32.to_le_bytes().to_vec();
    raw.push(0);
    [u64::from(u32::MAX), 1].iter().for_each(|n| raw.extend_from_slice(&n.to_le_bytes()));
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::Write::write_all(&mut encoder, &raw).unwrap();
    let mut bytes = vec![0x1c, 0x04, 4, 0];
    bytes.extend(encoder.finish().unwrap());
    let body = "<shape type=\"serialized\"><string name=\"filename\" value=\"m.serialized\"/></shape>";
    let error =
        load_bytes(xml("3.0.0", body).as_bytes(), &[("m.serialized", &bytes)]).unwrap_err().to_string();
    assert!(error.contains("counts that the data can hold"), "{error}");
}
