//! Words, primitives, commands and errors.

use super::super::words::Primitive;
use super::*;

fn primitive(text: &str) -> Primitive {
    definition(text).primitive
}

#[test]
fn primitives_are_words_in_any_number_of_lines() {
    let p = primitive("# head\n\nvoid 'plastic'\n\t\"a name\"\n2 a 'b c' 1 7\n3 # three\n 1 -.5 2e1\n");
    assert_eq!((p.modifier.as_str(), p.kind.as_str(), p.name.as_str()), ("void", "plastic", "a name"));
    assert_eq!((p.strings, p.reals), (vec!["a".to_owned(), "b c".to_owned()], vec![1.0, -0.5, 20.0]));
    assert_eq!(p.line, 3);
}

#[test]
fn the_last_definition_before_a_surface_is_its_material() {
    let text = "void plastic a 0 0 5 .1 .1 .1 0 0\na sphere one 0 0 4 0 0 0 1\n\
        void plastic a 0 0 5 .2 .2 .2 0 0\na sphere two 0 0 4 3 0 0 1\n\
        void alias b a\nvoid plastic a 0 0 5 .3 .3 .3 0 0\nb sphere three 0 0 4 6 0 0 1\n\
        void polygon nothing 0 0 9 0 0 0 1 0 0 0 1 0\n";
    let scene = scene(text);
    assert_eq!(names(&scene), ["one", "two", "three"], "surfaces of void are invisible");
    let reflectance = |id| match scene.material_of(id).surface {
        crate::scene::Surface::Lambert { reflectance } => reflectance.factor.to_array()[0],
        other => panic!("{other:?}"),
    };
    assert_eq!(scene.instance_ids().map(reflectance).collect::<Vec<_>>(), [0.1, 0.2, 0.2]);
}

#[test]
fn an_alias_has_its_own_modifiers_or_inherits_them() {
    let base = "void brightdata d 4 corr a.dat source.cal src_theta 0 0\nd light lamp 0 0 3 1 1 1\n\
        void light plain 0 0 3 1 1 1\n";
    let data = "1 0 180 2 1 1";
    for (alias, points) in [
        ("inherit alias m lamp", true),
        ("void alias m lamp", false),
        ("d alias m plain", true),
        ("void alias m plain", false),
    ] {
        let text = format!("{base}{alias}\nm sphere s 0 0 4 0 0 0 1\n");
        let scene = load(&[("scene.rad", &text), ("a.dat", data)]).unwrap();
        assert_eq!(
            (scene.emitters().len(), scene.area_emitters().count()),
            if points { (1, 0) } else { (0, 1) },
            "{alias}"
        );
    }
}

#[test]
fn errors_name_file_and_line() {
    for (text, expected) in [
        ("grey polygon p 0 0 6 0 0 0 1 1 1", "scene.rad:2: a polygon of 6 numbers"),
        ("grey polygon p 0 0 10 0 0 0 1 1 1 2 2 2 3", "scene.rad:2: a polygon of 10 numbers"),
        (
            "grey sphere p 0 0 5 0 0 0 1 1",
            "scene.rad:2: 5 real arguments of sphere \"p\"; expected 4 of them",
        ),
        ("\ngrey sphere p 0 0\n4 0 0 x 1", "scene.rad:4: \"x\"; expected a real argument of a sphere"),
        ("grey sphere p 0 0 4 0 0 nan 1", "scene.rad:2: \"nan\""),
        ("grey sphere p 0 0 4 0 0", "scene.rad:2: the end of the file in the primitive of line 2"),
        ("grey sphere p 0 0 4000000000 0 0", "the end of the file in the primitive of line 2"),
        ("grey sphere p 99999999999999 a", "the end of the file in the primitive of line 2"),
        ("grey sphere p -1 0 0", "\"-1\"; expected the number of strings of a sphere"),
        ("grey sphere", "the end of the file"),
        ("grey sphere 'p 0 0 4 0 0 0 1", "a quotation mark"),
        (
            "gray sphere p 0 0 4 0 0 0 1",
            "scene.rad:2: modifier \"gray\"; expected a known name: did you mean \"grey\"?",
        ),
        ("other sphere p 0 0 4 0 0 0 1", "scene.rad:2: modifier \"other\"; expected a name that"),
        (
            "void plastic a 0 0 5 1 1 1 0 0\na plastic b 0 0 5 1 1 1 0 0\nzz plastic c 0 0 0",
            "scene.rad:4: modifier \"zz\"",
        ),
        (
            "grey spere p 0 0 4 0 0 0 1",
            "scene.rad:2: type \"spere\"; expected a known name: did you mean \"sphere\"?",
        ),
        (
            "grey sphere p 0 0 4 0 0 0 1 2\ngrey cone c",
            "scene.rad:2: type \"grey\" of \"cone\"; expected a type of the reference manual",
        ),
        ("void alias b c", "scene.rad:2: modifier \"c\""),
        (
            "void plastic b 0 0 4 1 1 1 0\nb sphere p 0 0 4 0 0 0 1",
            "scene.rad:2: 4 real arguments of plastic \"b\"; expected 5",
        ),
        ("void glass b 0 0 4 1 1 1 -1\nb sphere p 0 0 4 0 0 0 1", "scene.rad:2: index of refraction -1"),
        ("void light b 0 0 3 1 -1 1\nb sphere p 0 0 4 0 0 0 1", "scene.rad:2: radiance [1.0, -1.0, 1.0]"),
    ] {
        // The second line of the file is the first of the text.
        let message = error(&[("scene.rad", &format!("{GREY}{text}"))]);
        assert!(message.contains(expected), "{text}: {message}");
    }
}

#[test]
fn commands_are_refused_by_name_and_never_run() {
    for (command, expected) in [
        ("!genbox grey box 1 1 1", "scene.rad:2: command \"!genbox\" is not supported; no command is run"),
        ("!gensky 6 21 12 +s", "command \"!gensky\""),
        ("!rm scene.rad", "command \"!rm\""),
        ("!xform -t 1 0 0 a.rad | rm", "command \"!rm\""),
        ("!genbox grey b 1 1 1 | xform -t 1 0 0", "command \"!genbox\""),
        ("!xform a.rad > b.rad", "'>' in a command"),
        ("!cat `ls`", "'`' in a command"),
        ("!", "command \"!\""),
        ("!xform -t 1 0 0", "scene.rad:2: a command without a file"),
        ("!xform -q a.rad", "option \"-q\"; expected options -t"),
        ("!xform -n", "-n at the end"),
        ("!cat a.rad | xform b.rad", "file \"b.rad\" of an xform that is piped into"),
        ("!cat ../a.rad", "../a.rad"),
        ("!cat /etc/passwd", "/etc/passwd"),
        ("!cat gone.rad", "gone.rad"),
    ] {
        let files = [("scene.rad", &*format!("{GREY}{command}\n")), ("a.rad", ""), ("b.rad", "")];
        let message = error(&files);
        assert!(message.contains(expected), "{command}: {message}");
    }
}

#[test]
fn files_that_include_themselves_are_refused() {
    let text = "!xform -t 1 0 0 scene.rad\n";
    let message = error(&[("scene.rad", text)]);
    assert!(message.contains("does it include itself?"), "{message}");
    let message =
        error(&[("scene.rad", "!cat a.rad"), ("a.rad", "\n!xform -a 2 b.rad"), ("b.rad", "!cat a.rad")]);
    assert!(message.contains("does it include itself?"), "{message}");
}

#[test]
fn copies_of_copies_are_limited() {
    let many = "!xform -a 1000000000 -t 1 0 0 -a 1000000000 -t 0 1 0 a.rad\n";
    for (content, expected) in
        [(String::new(), "at most 1048576 included files"), (GREY.repeat(40), "one more primitive")]
    {
        let message = error(&[("scene.rad", many), ("a.rad", &content)]);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn errors_in_included_files_name_that_file() {
    let message = error(&[("scene.rad", "!cat part/a.rad\n"), ("part/a.rad", "\nvoid foo x 0 0 0\n")]);
    assert!(message.contains("a.rad:2: type \"foo\""), "{message}");
    let message =
        error(&[("scene.rad", "!xform -f args a.rad\n"), ("a.rad", ""), ("args", "-t 0 0 1\n-t 0 x 0\n")]);
    assert!(message.contains("args:2: \"x\""), "{message}");
}

#[test]
fn any_bytes_are_a_scene_or_an_error() {
    let text = "void plastic grey 0 0 5 .5 .5 .5 .1 .1 'a b' # c\n!xform -n 'q' -a 2 -t 1 0 0 scene.rad\ngrey cone c 0 0 8 0 0 0 0 0 1 1 .5";
    for cut in 0..text.len() {
        let _ = load(&[("scene.rad", &text[..cut])]);
        let damaged: String =
            text[..cut].chars().chain(['é', '\u{0}', '"']).chain(text[cut..].chars().skip(1)).collect();
        let _ = load(&[("scene.rad", &damaged)]);
    }
}
