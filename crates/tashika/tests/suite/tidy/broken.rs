//! Snippets that break each rule, so that no rule passes for seeing nothing.

use super::rules::*;
use super::tables::*;
use super::workspace::File;

/// A file of the module `name`, in the crate of renderers.
fn snippet(name: &str, text: &str) -> File {
    snippet_of("tashika-core", name, text)
}

/// A file of the module `name` of a crate.
fn snippet_of(library: &str, name: &str, text: &str) -> File {
    let module = name.split("::").map(str::to_owned).collect();
    File::new(&format!("crates/{library}/src/{}.rs", name.replace("::", "/")), text, Some(module), false)
}

#[test]
fn a_broken_layer_is_seen_in_every_pair_of_modules() {
    for user in MODULES {
        for used in MODULES {
            let n = used.name;
            let ways = [
                format!("//! Doc.\nuse crate::{n}::Thing;"),
                format!("//! Doc.\nuse crate::{{\n    {n}::{{self, Thing}},\n}};"),
                format!("//! Doc.\nfn f() -> crate::{n}::Thing {{ super::super::{n}::make() }}"),
            ];
            let allowed = allows(user, used);
            for text in ways {
                let wrong = layers(&snippet(&format!("{}::part", user.name), &text));
                assert_eq!(wrong.is_empty(), allowed, "{} using {n}: {wrong:?}", user.name);
                assert!(
                    wrong
                        .iter()
                        .all(|w| w.starts_with("crates/tashika-core/src/") && w.contains("must not use"))
                );
            }
        }
        let above = MODULES.iter().filter(|m| m.layer > user.layer);
        assert!(above.into_iter().all(|m| !allows(user, m)), "{} may use a higher layer", user.name);
        let known = |name: &&str| MODULES.iter().any(|m| m.name == *name);
        assert!(user.beside.iter().chain(user.never).all(known), "{} speaks of no module", user.name);
    }
    assert_eq!(layers(&snippet("film", "use crate::*;")).len(), 1, "the root hides what is named");
    assert_eq!(layers(&snippet("film", "#[cfg(test)] mod tests { use crate::io::read_exr; }")).len(), 0);
    assert_eq!(layers(&snippet("newcomer", "")).len(), 1, "a module needs a layer");
    let by_crate = |text| layers(&snippet("bounds", text)).len();
    assert_eq!(by_crate("use tashika_scene::{bsdf::Bsdf, scene::Scene};"), 1, "another way to the same");
    assert_eq!(by_crate("use tashika_film::*;"), 1);
    assert_eq!(by_crate("use tashika_stats::Moments; use tashika_math::math::Vec3;"), 0);
    let in_report = |text| layers(&snippet_of("tashika-report", "report::page", text)).len();
    assert_eq!(in_report("use crate::{compare, film::Film}; use super::page::Page;"), 0);
    assert_eq!(in_report("use crate::{count, io::write_png};"), 1);
}

#[test]
fn broken_rules_are_seen() {
    let text = "mod all; mod base; mod exact; mod path; pub use base::Base; pub use exact::Exact; pub struct Setting;";
    let owner = snippet("integrator", text);
    let row = SideBySide { owner: "integrator.rs", common: &["base"], lists: &["all"] };
    let used_by = |file, text| side_by_side(&snippet(file, text), &owner, &row).len();
    assert_eq!(used_by("integrator::all", "use super::{Exact, path::Path};"), 0);
    assert_eq!(used_by("integrator::base", "use super::Exact;"), 1);
    let sibling = |text| used_by("integrator::path", text);
    assert_eq!(sibling("use super::Base;"), 0);
    assert_eq!(sibling("use super::{Exact, Setting};"), 1);
    assert_eq!(sibling("fn f() { crate::integrator::exact::g() }"), 1);
    assert_eq!(sibling("use super::{Path, Setting, path::g};"), 0);

    let names = |module, text| foreign(&snippet(module, text)).len();
    assert_eq!(names("gather", "use smallvec::SmallVec;"), 1);
    assert_eq!(names("integrator::exact", "use rayon::prelude::*;"), 1);
    assert_eq!(names("render", "use rayon::prelude::*;"), 0);
    assert_eq!(foreign(&snippet_of("tashika-math", "rng", "use libm::sin;")).len(), 1);
    assert_eq!(names("scene", "fn f() { std::fs::read(image) }"), 1);
    assert_eq!(names("film", "use std::{env, net::TcpStream};"), 2);
    assert_eq!(
        names("io::files", "use std::fs::File; use ::image::load; const P: f64 = std::f64::consts::PI;"),
        0
    );

    let found = |module, text| words(&snippet_of("tashika-formats", module, text)).len();
    assert_eq!(found("render", r#"fn f() { eprintln!("{}", Instant::now().elapsed()); }"#), 2);
    assert_eq!(found("vpl", "use std::collections::{BTreeMap, HashMap, HashSet};"), 2);
    assert_eq!(
        found("io::obj::mtl", "use std::collections::HashMap; #[cfg(test)] mod t { fn f() { dbg!(1); } }"),
        0
    );
    let differs = |text| elementary(&snippet("scene", text)).len();
    assert_eq!(
        differs("let y = x.to_radians().sin(); let q = Quat::from_rotation_y(y); v.iter().map(f64::cos)"),
        3
    );
    assert_eq!(differs("let y = sin(x); let exp = log.sqrt(); impl Log { fn log(&self) {} }"), 0);
    let looked_up = |text: &str| schema(&snippet("render", &format!("fn f() {{ {text} }}"))).len();
    assert_eq!(looked_up(r#"film.plane("stop"); film.plane_mut("").set_u32(x, y, &[0]);"#), 2);
    assert_eq!(
        looked_up(r#"film.metadata().text("seed"); metadata.set("error", 1.0); m.set("scene", s)"#),
        3
    );
    assert_eq!(looked_up(r#"let plane = |name| film.plane(name); plane("claim"); f("half_width")"#), 2);
    assert_eq!(looked_up(r#"film.plane(planes::STOP); Error::option("seed", 1, ""); row.text("error")"#), 0);
    assert_eq!(
        schema(&snippet_of("tashika-film", "film::record::keys", r#"const K: &str = "audit.of";"#)).len(),
        0
    );
    assert_eq!(unsafe_code(&snippet("rng", "#[cfg(test)] mod t { unsafe fn f() {} }")).len(), 1);

    let kept = |text: &str| upkeep(&snippet("rng", text)).len();
    assert_eq!(kept("use std::fmt;"), 1);
    assert_eq!(kept(&format!("//! Doc.\n// A {}: later.", UNFINISHED[0])), 1);
    assert_eq!(kept(&format!("//! Doc.\n{}", "\n".repeat(MOST_LINES))), 1);
    assert_eq!(kept("//! Doc.\nconst A_HACKNEY_CARRIAGE: u8 = 1; // nothing left"), 0);

    let entries = bibliography(
        "# R\n\n- **noether1918** Noether, E. 1918.\n  \"Title.\"\n- **ito2001** Itō, A., O'Hara, B. 2001.\n",
    );
    let cited = |text| references(&snippet("rng", text), &entries).len();
    assert_eq!(
        cited(
            "//! As Noether 1918, (Itō and O'Hara\n//! 2001), [^ito2001]; Itō et al. (2001); in 1999, of 2.5 2010."
        ),
        0
    );
    assert_eq!(cited("//! Gauss 1801, Noether 1919, Gauss et al.\n//! 1801, [^gauss1801]"), 4);
}
