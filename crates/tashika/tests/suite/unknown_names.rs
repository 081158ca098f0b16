//! Names that a format does not have. Each gives a note with its line, or an error if it is a slip
//! of an existing name.

use tashika::error::Error;
use tashika::io::{FormatFeatures, features};
use tashika::scene::{NoteKind, Scene};

use super::mitsuba::{example, files_of_examples, load_in, xml};
use super::pbrt::{Folder, V3, V4, notes, refusal};
use super::pbrt_appearance::{folder_of_features, scene_with};

/// A name that is similar to no other.
const BOGUS: &str = "quux_flavour";

fn format(name: &str) -> FormatFeatures {
    features().into_iter().find(|format| format.format == name).unwrap()
}

/// Returns the line of the text that contains the name.
fn line_of_bogus(text: &str) -> u32 {
    1 + text[..text.find(BOGUS).unwrap()].matches('\n').count() as u32
}

/// Returns the counts and lines of the notes on `BOGUS`, and the number of all other notes, except
/// those on defaults.
fn told(scene: &Scene) -> (Vec<(u64, Option<u32>)>, usize) {
    let notes: Vec<_> = scene.notes().iter().filter(|n| n.kind != NoteKind::Defaulted).collect();
    let about = notes.iter().filter(|n| n.message.contains(BOGUS) && n.kind == NoteKind::Ignored);
    (about.map(|n| (n.count, n.first.line)).collect(), notes.len())
}

#[test]
fn pbrt_notes_a_parameter_that_a_plugin_does_not_know() {
    let folder = folder_of_features();
    let mut plugins = 0;
    for row in format("pbrt").rows.iter().filter(|row| !row.name.contains(' ')) {
        let begin = match row.kind {
            "camera" => "Camera",
            "film" => "Film",
            "shape" => "Shape",
            "light" => "LightSource",
            "area light" => "AreaLightSource",
            "material" => "Material",
            "texture" => "\"spectrum\"",
            "medium" => "\"string type\"",
            _ => continue,
        };
        let plain = scene_with(row);
        let named = format!("{begin} \"{}\"", row.name);
        assert!(plain.contains(&named), "{plain}");
        let text = plain.replacen(&named, &format!("{named}\n\"float {BOGUS}\" 1"), 1);
        let (before, after) = (folder.load(&plain).unwrap(), folder.load(&text).unwrap());
        let expected = (vec![(1, Some(line_of_bogus(&text)))], told(&before).1 + 1);
        assert_eq!(told(&after), expected, "{text}: {:?}", notes(&after));
        plugins += 1;
    }
    assert!(plugins > 70, "{plugins}");
    // Directives without effect on the picture.
    for directive in
        ["Sampler \"halton\"", "PixelFilter \"box\"", "Accelerator \"bvh\"", "Integrator \"path\"", "Option"]
    {
        let text = format!("{directive} \"float {BOGUS}\" 1\n{V4}");
        assert_eq!(told(&folder.load(&text).unwrap()), (vec![(1, Some(1))], 1), "{text}");
    }
    let text = format!("{V4} Attribute \"shape\" \"float {BOGUS}\" 1 Shape \"sphere\" Shape \"disk\"");
    assert_eq!(told(&folder.load(&text).unwrap()).0, [(1, Some(2))]);
}

#[test]
fn mitsuba_notes_a_parameter_that_a_plugin_does_not_know() {
    let files = files_of_examples();
    let load = |body: &str| {
        let text = xml("3.0.0", body);
        let mut all: Vec<_> = files.iter().map(|(name, bytes)| (*name, &bytes[..])).collect();
        all.push(("scene.xml", text.as_bytes()));
        let scene = load_in(&all).1.unwrap_or_else(|error| panic!("{error}\n{text}"));
        (text, scene)
    };
    // A spectral film has one spectrum for each channel, with any name.
    let free = ["specfilm", "max_smooth_angle"];
    let mut plugins = 0;
    for row in format("Mitsuba").rows {
        if row.name.contains(' ') || free.contains(&row.name) {
            continue;
        }
        let plain = example(row.kind, row.name);
        let typed = plain.find(&format!("type=\"{}\"", row.name)).unwrap();
        let tag = plain[..typed].rsplit('<').next().unwrap().trim();
        let end = typed + plain[typed..].find('>').unwrap();
        let parameter = format!("\n<float name=\"{BOGUS}\" value=\"1\"/>");
        let body = match plain[..end].strip_suffix('/') {
            Some(open) => format!("{open}>{parameter}</{tag}>{}", &plain[end + 1..]),
            None => format!("{}{parameter}{}", &plain[..=end], &plain[end + 1..]),
        };
        let ((_, before), (text, after)) = (load(&plain), load(&body));
        let expected = (vec![(1, Some(line_of_bogus(&text)))], told(&before).1 + 1);
        assert_eq!(told(&after), expected, "{text}: {:?}", notes(&after));
        plugins += 1;
    }
    assert!(plugins > 90, "{plugins}");
    for (tag, plugin) in [("integrator", "path"), ("sampler", "independent"), ("rfilter", "gaussian")] {
        let parameter = format!("<{tag} type=\"{plugin}\"><float name=\"{BOGUS}\" value=\"1\"/></{tag}>");
        let body = match tag {
            "sampler" => format!("<sensor type=\"perspective\">{parameter}</sensor>"),
            "rfilter" => {
                format!("<sensor type=\"perspective\"><film type=\"hdrfilm\">{parameter}</film></sensor>")
            }
            _ => parameter,
        };
        assert_eq!(told(&load(&body).1), (vec![(1, Some(2))], 1), "{body}");
    }
}

#[test]
fn pbrt_refuses_a_slip_and_says_which_name_was_meant() {
    let mesh = "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0]";
    for (text, expected) in [
        (
            "\nShape \"spere\"",
            "scene.pbrt:3:1: shape \"spere\"; expected a known name: did you mean \"sphere\"?",
        ),
        (
            "Shape \"sphere\" \"float raduis\" 1",
            "scene.pbrt:2:16: shape \"sphere\": parameter \"raduis\"; expected a known name: did you mean \"radius\"?",
        ),
        ("Material \"difuse\"", "material \"difuse\"; expected a known name: did you mean \"diffuse\"?"),
        ("Material \"diffuse\" \"rgb reflectence\" [1 1 1]", "did you mean \"reflectance\"?"),
        ("LightSource \"infinit\"", "did you mean \"infinite\"?"),
        ("AreaLightSource \"difuse\"", "did you mean \"diffuse\"?"),
        ("Texture \"t\" \"spectrum\" \"imgemap\"", "did you mean \"imagemap\"?"),
        ("Shpae \"sphere\"", "directive \"Shpae\"; expected a known name: did you mean \"Shape\"?"),
        (
            "MakeNamedMaterial \"glass\" \"string type\" \"dielectric\" NamedMaterial \"glas\"",
            "material \"glas\"; expected a known name: did you mean \"glass\"?",
        ),
        (
            "Texture \"wood\" \"spectrum\" \"constant\" Material \"diffuse\" \"texture reflectance\" \"wodo\"",
            "did you mean \"wood\"?",
        ),
        ("ObjectBegin \"chair\" ObjectEnd ObjectInstance \"chiar\"", "did you mean \"chair\"?"),
        ("MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"fgo\" \"\"", "\"fog\"?"),
        ("Attribute \"shape\" \"float raduis\" 1", "did you mean \"radius\"?"),
    ] {
        let text = format!("{V4}{text}");
        let refused = refusal(&text);
        assert!(refused.contains(expected), "{text}: {refused}");
        assert!(matches!(Folder::new().load(&text), Err(Error::Invalid { .. })));
    }
    // Names of the other version, numbered names, and names that resemble no other give notes.
    for (text, count) in [
        (format!("{V4} Material \"diffuse\" \"rgb Ks\" [1 1 1]"), 1),
        (format!("{V3} Material \"matte\" \"rgb Ks\" [1 1 1] WorldEnd"), 1),
        (format!("{V4} MakeNamedMaterial \"m1\" \"string type\" \"diffuse\" NamedMaterial \"m2\""), 1),
        (format!("{V4} Shape \"sphere2\""), 1),
        (format!("{V4} Shape \"teapot\""), 1),
        (format!("{V4} {mesh} \"vector3 S\" [0 0 0]"), 0),
    ] {
        let scene = Folder::new().load(&text).unwrap();
        assert_eq!(notes(&scene).len(), count, "{text}: {:?}", notes(&scene));
    }
}

#[test]
fn mitsuba_refuses_a_slip_and_says_which_name_was_meant() {
    let refusal = |body: &str| {
        let text = xml("3.0.0", body);
        let (folder, scene) = load_in(&[("scene.xml", text.as_bytes())]);
        let error = scene.err().unwrap_or_else(|| panic!("{body}"));
        assert!(matches!(error, Error::Invalid { .. }), "{error}");
        error.to_string().replace(&format!("{}/", folder.path().display()), "")
    };
    for (body, expected) in [
        (
            "<shape type=\"spere\"/>",
            "scene.xml:2:1: shape \"spere\"; expected a known name: did you mean \"sphere\"?",
        ),
        (
            "<shape type=\"sphere\">\n<float name=\"raduis\" value=\"2\"/></shape>",
            "scene.xml:3:1: shape \"sphere\": parameter \"raduis\"; expected a known name: did you mean \"radius\"?",
        ),
        ("<shape type=\"cube\"><bsdf type=\"difuse\"/></shape>", "did you mean \"diffuse\"?"),
        (
            "<shape type=\"cube\"><bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectence\"/></bsdf></shape>",
            "nested object \"reflectence\"; expected a known name: did you mean \"reflectance\"?",
        ),
        ("<emitter type=\"piont\"/>", "did you mean \"point\"?"),
        ("<sensor type=\"perspektive\"/>", "did you mean \"perspective\"?"),
        ("<integrator type=\"path\"><integer name=\"max_dept\" value=\"2\"/></integrator>", "\"max_depth\"?"),
        (
            "<bsdf type=\"diffuse\" id=\"walls\"/><shape type=\"cube\"><ref id=\"wals\"/></shape>",
            "reference to \"wals\"; expected a known name: did you mean \"walls\"?",
        ),
        ("<shape type=\"cube\"><flaot name=\"x\" value=\"1\"/></shape>", "element \"flaot\""),
        (
            "<shape type=\"cube\"><transform name=\"to_world\"><roate y=\"1\"/></transform></shape>",
            "\"rotate\"?",
        ),
    ] {
        let refused = refusal(body);
        assert!(refused.contains(expected), "{body}: {refused}");
    }
    // Names in the spelling of older versions are known.
    let old = xml(
        "0.6.0",
        "<shape type=\"cube\"><transform name=\"toWorld\"/><float name=\"weight\" value=\"1\"/></shape>",
    );
    let scene = load_in(&[("scene.xml", old.as_bytes())]).1.unwrap();
    assert_eq!(notes(&scene).len(), 1, "{:?}", notes(&scene));
}
