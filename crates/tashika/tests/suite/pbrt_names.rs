//! Names in pbrt scenes. In version 3 a name refers to the last definition before it; in version 4
//! a definition may be anywhere.

use tashika::color::Rgb;
use tashika::scene::{NoteKind, Scene, Surface};

use super::pbrt::{Folder, TRIANGLE, V3, V4, notes, scene};

/// Returns the reflectances of the meshes' materials, in the order of the meshes.
fn reflectances(scene: &Scene) -> Vec<[f32; 3]> {
    let surfaces = scene.meshes().iter().map(|mesh| scene.materials()[mesh.material.index()].surface);
    let reflectance = |surface: Surface| match surface {
        Surface::Lambert { reflectance } => reflectance.factor.to_array(),
        other => panic!("{other:?}"),
    };
    surfaces.map(reflectance).collect()
}

const RED: &str = "\"rgb reflectance\" [0.75 0 0]";
const GREEN: &str = "\"rgb reflectance\" [0 0.5 0]";

fn diffuse(name: &str, parameters: &str) -> String {
    format!(" MakeNamedMaterial \"{name}\" \"string type\" \"diffuse\" {parameters}\n")
}

#[test]
fn version_4_takes_names_before_their_definition() {
    let texture = "Texture \"t\" \"spectrum\" \"constant\" \"rgb value\" [0 0.5 0]\n";
    let (red, green) = (diffuse("r", RED), diffuse("g", GREEN));
    let textured = diffuse("g", "\"texture reflectance\" \"t\"");
    let mix = "MakeNamedMaterial \"m\" \"string type\" \"mix\" \"string materials\" [\"r\" \"g\"] \"float amount\" 1\n";
    let scaled = "Texture \"u\" \"spectrum\" \"scale\" \"texture tex\" \"t\" \"float scale\" 1\n";
    let of_scaled = diffuse("g", "\"texture reflectance\" \"u\"");
    for text in [
        format!("NamedMaterial \"g\" {TRIANGLE} {green}"),
        format!("{textured} {texture} NamedMaterial \"g\" {TRIANGLE}"),
        // Definitions that are needed early use other definitions before and after them.
        format!("NamedMaterial \"g\" {TRIANGLE} {textured} {texture}"),
        format!("{texture} NamedMaterial \"g\" {TRIANGLE} {textured}"),
        format!("NamedMaterial \"g\" {TRIANGLE} {of_scaled} {scaled} {texture}"),
        format!("Material \"diffuse\" \"texture reflectance\" \"t\" {TRIANGLE} {texture}"),
    ] {
        let scene = scene(&format!("{V4} {text}"));
        assert_eq!(notes(&scene), [], "{text}");
        assert_eq!(reflectances(&scene), [[0.0, 0.5, 0.0]], "{text}");
    }
    // A mix whose parts are defined after it; the result is its second part.
    for text in [
        format!("{mix} {red} {green} NamedMaterial \"m\" {TRIANGLE}"),
        format!("NamedMaterial \"m\" {TRIANGLE} {mix} {red} {green}"),
    ] {
        let scene = scene(&format!("{V4} {text}"));
        assert_eq!(notes(&scene), [], "{text}");
        let Surface::Mix { first, second, amount } =
            scene.materials()[scene.meshes()[0].material.index()].surface
        else {
            panic!("a mix")
        };
        let of = |id: tashika::scene::MaterialId| match scene.materials()[id.index()].surface {
            Surface::Lambert { reflectance } => reflectance.factor,
            other => panic!("{other:?}"),
        };
        assert_eq!((of(first), of(second)), (Rgb::new(0.75, 0.0, 0.0), Rgb::new(0.0, 0.5, 0.0)));
        assert_eq!(amount.factor, 1.0);
    }
}

#[test]
fn media_and_objects_of_version_4_may_be_named_before_they_are_defined() {
    let fog = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_s\" [1 1 1] \"rgb sigma_a\" [0 0 0]";
    let text = format!(
        "Integrator \"volpath\" {V4} MediumInterface \"fog\" \"\" Material \"interface\" {TRIANGLE} {fog}"
    );
    let scene = scene(&text);
    assert_eq!((notes(&scene), scene.media().len()), (vec![], 1));
    let text = format!(
        "{V4} Translate 5 0 0 ObjectInstance \"a\" Translate -5 0 0 ObjectBegin \"a\" {TRIANGLE} ObjectEnd {TRIANGLE}"
    );
    let placed = super::pbrt::scene(&text);
    let mut xs: Vec<f32> = placed.instances().iter().map(|i| i.to_world.translation.x).collect();
    xs.sort_by(f32::total_cmp);
    assert_eq!((notes(&placed), xs), (vec![], vec![0.0, 5.0]));
}

#[test]
fn version_3_takes_what_was_defined_last_before() {
    let kd = |name: &str, color: &str| {
        format!(" MakeNamedMaterial \"{name}\" \"string type\" \"matte\" \"rgb Kd\" [{color}]\n")
    };
    let (red, green) = (kd("m", "0.75 0 0"), kd("m", "0 0.5 0"));
    let use_it = format!("NamedMaterial \"m\" {TRIANGLE}");
    let scene = scene(&format!("{V3} {red} {use_it} {green} {use_it} WorldEnd"));
    assert_eq!((notes(&scene), reflectances(&scene)), (vec![], vec![[0.75, 0.0, 0.0], [0.0, 0.5, 0.0]]));
    let texture = |color: &str| format!("Texture \"t\" \"color\" \"constant\" \"rgb value\" [{color}]\n");
    let use_it = format!("Material \"matte\" \"texture Kd\" \"t\" {TRIANGLE}");
    let scene = super::pbrt::scene(&format!(
        "{V3} {} {use_it} {} {use_it} WorldEnd",
        texture("0.75 0 0"),
        texture("0 0.5 0")
    ));
    assert_eq!((notes(&scene), reflectances(&scene)), (vec![], vec![[0.75, 0.0, 0.0], [0.0, 0.5, 0.0]]));
    // In pbrt-v3, a definition after its use counts as missing.
    let late = super::pbrt::scene(&format!("{V3} NamedMaterial \"m\" {TRIANGLE} {green} WorldEnd"));
    assert!(matches!(&notes(&late)[..], [(NoteKind::Repaired, m)] if m.contains("\"m\" is not defined")));
}

#[test]
fn names_that_use_themselves_are_not_defined() {
    let round = "Texture \"a\" \"spectrum\" \"scale\" \"texture tex\" \"b\" Texture \"b\" \"spectrum\" \"scale\" \"texture tex\" \"a\"";
    let text = format!("{V4} Material \"diffuse\" \"texture reflectance\" \"a\" {TRIANGLE} {round}");
    let scene = Folder::new().load(&text).unwrap();
    assert!(
        notes(&scene).iter().all(|(kind, m)| *kind == NoteKind::Repaired && m.contains("is not defined"))
    );
    assert!(!notes(&scene).is_empty());
    // A chain of 20,000 names is resolved without deep recursion.
    let chain: String = (0..20_000)
        .map(|i| format!("Texture \"t{i}\" \"spectrum\" \"scale\" \"texture tex\" \"t{}\"\n", i + 1))
        .collect();
    let text = format!("{V4} {chain} Texture \"t20000\" \"spectrum\" \"constant\"");
    assert_eq!(notes(&Folder::new().load(&text).unwrap()), []);
}
