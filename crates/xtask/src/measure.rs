//! Scripts that measure, or write the numbers that tests hold the project to.

use std::fs;

use clap::ValueEnum;

use crate::shell::{Outcome, Shell};

/// A measurement.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Measure {
    /// Pictures of Mitsuba files beside Mitsuba's own: SIZE PATHS SCENE.xml...
    Pictures,
    /// What moves beside the mean of Mitsuba's that stand: SIZE PATHS SCENE.xml [--objects|OPTIONS...]
    Moving,
    /// Mitsuba's direct light by points on emitters beside that by directions: SIZE SAMPLES SCENE.xml...
    Direct,
    /// How long Mitsuba takes until as many pixels are right
    Beside,
    /// Disjoint intervals of two seeds: [--seeds N] [--truth FOLDER] [--limit SHARE] SCENE... [-- OPTION...]
    Seeds,
    /// Writes the book's gallery, with what its pictures claim and what was measured: WORK [--scenes FOLDER] [NAME...]
    Gallery,
    /// Writes what Mitsuba's materials reflect, by Mitsuba 3
    Materials,
    /// Writes what materials of the other formats reflect, by their formulas
    Formulas,
    /// Writes the metals that Mitsuba knows by name
    Metals,
    /// Writes the properties of USD's schemas, by Pixar's own library
    Schemas,
    /// Writes the table of light through rough boundaries
    Boundary,
    /// Writes the table of light that fibres return
    Sheen,
}

impl Measure {
    /// Its script, and the file that it writes, if what it prints is one.
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

    /// Runs it; a table is written when it is whole.
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
