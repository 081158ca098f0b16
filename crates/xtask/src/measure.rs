//! Scripts that measure, or write tables of the library and its tests.

use std::fs;

use clap::ValueEnum;

use crate::shell::{Outcome, Shell};

/// Measurement by a script.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Measure {
    /// Compare pictures of Mitsuba files with Mitsuba's own: SIZE PATHS SCENE.xml...
    Pictures,
    /// Compare moving scenes with the mean of Mitsuba's pictures of still ones: SIZE PATHS
    /// SCENE.xml [--objects|OPTIONS...]
    Moving,
    /// Compare direct light in Mitsuba, sampled by points on emitters and by directions: SIZE
    /// SAMPLES SCENE.xml...
    Direct,
    /// Measure the time that Mitsuba needs for as many pixels within the tolerance as an image has:
    /// SCENE.xml IMAGE.exr [OPTION...]
    Beside,
    /// Count disjoint intervals of two seeds: [--seeds N] [--truth FOLDER] [--limit SHARE] SCENE...
    /// [-- OPTION...]
    Seeds,
    /// Write the book's gallery, with the claims and the measured errors of its pictures: WORK
    /// [--scenes FOLDER] [NAME...]
    Gallery,
    /// Write the reflectance of Mitsuba's materials, by Mitsuba 3
    Materials,
    /// Write the reflectance of materials of the other formats, by their formulas
    Formulas,
    /// Write the metals that Mitsuba knows by name
    Metals,
    /// Write the properties of USD's schemas, by Pixar's own library
    Schemas,
    /// Write the table of the transmittance of rough boundaries
    Boundary,
    /// Write the table of the albedo of fibres
    Sheen,
}

impl Measure {
    /// Returns the script, and the file that its output is written to, if there is one.
    fn script(self) -> (&'static str, Option<&'static str>) {
        match self {
            Self::Pictures => ("mitsuba_pictures.py", None),
            Self::Moving => ("mitsuba_moving.py", None),
            Self::Direct => ("mitsuba_direct.py", None),
            Self::Beside => ("mitsuba_beside.py", None),
            Self::Seeds => ("two_seeds.py", None),
            Self::Gallery => ("gallery.py", None),
            Self::Materials => {
                ("mitsuba_materials.py", Some("crates/tashika/tests/suite/mitsuba_materials.txt"))
            }
            Self::Formulas => {
                ("material_formulas.py", Some("crates/tashika/tests/suite/formula_materials.txt"))
            }
            Self::Metals => ("mitsuba_metals.py", Some("crates/tashika-formats/src/io/mitsuba/metals.rs")),
            Self::Schemas => ("usd_schemas.py", Some("crates/tashika-formats/src/io/usd/schemas.txt")),
            Self::Sheen => ("sheen_albedo.py", Some("crates/tashika-scene/src/bsdf/sheen/table.rs")),
            Self::Boundary => ("rough_boundary.py", Some("crates/tashika-scene/src/bsdf/boundary/table.rs")),
        }
    }

    /// Runs the script; a table is written when it is complete.
    pub fn run(self, shell: &Shell, rest: &[String]) -> Outcome<()> {
        let (script, table) = self.script();
        let python = shell.command("python3", "").arg(shell.script(script));
        match table {
            Some(table) => {
                let told = python.args(rest).output()?;
                let table = shell.root().join(table);
                fs::write(&table, told).map_err(|e| format!("{}: {e}", table.display()))
            }
            None if matches!(self, Self::Pictures | Self::Moving | Self::Gallery | Self::Seeds) => {
                python.arg(shell.program()?).args(rest).run()
            }
            None => python.args(rest).run(),
        }
    }
}
