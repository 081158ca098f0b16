//! The workbench: tasks that check, measure and show the project from a checkout.
//!
//!     cargo xtask ci                              all checks before a change, except the tests
//!     cargo xtask measure pictures SIZE PATHS SCENE.xml...    pictures beside Mitsuba's
//!     cargo xtask dist [FOLDER]                   the program, its wheel and packages for others
//!     cargo xtask pages [FOLDER]                  pages in a browser
//!     cargo xtask sheet LIST FOLDER SHEET.png     small pictures of many scenes on one sheet
//!
//! `.ci/run` is `cargo xtask ci` and then the tests.
#![forbid(unsafe_code)]

mod ci;
mod dist;
mod measure;
mod parts;
mod shell;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use shell::{Outcome, Shell};

/// The workbench of tashika
#[derive(Debug, Parser)]
#[command(bin_name = "cargo xtask", arg_required_else_help = true)]
struct Args {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Check everything that has to hold before a change is taken, except the tests
    Ci,
    /// Measure with a script of `scripts`, or write a table of the library or its tests
    Measure {
        /// Name of the measurement
        what: measure::Measure,
        /// Arguments of the script
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// Make the files for distribution: archive, wheel, Debian package, bill of materials, sums
    Dist {
        /// Folder to write the files to
        #[arg(default_value = "target/distribution")]
        folder: PathBuf,
    },
    /// Make pages, and show them in a browser
    Pages {
        /// Folder to write the screenshots to
        #[arg(default_value = "target/pages")]
        folder: PathBuf,
    },
    /// Put small pictures of many scenes on one sheet
    Sheet {
        /// File with the path of a scene below the folder on each line
        list: PathBuf,
        /// Folder that has the scenes
        folder: PathBuf,
        /// PNG to write
        sheet: PathBuf,
    },
}

fn run(args: &Args) -> Outcome<()> {
    let shell = Shell::new()?;
    match &args.task {
        Task::Ci => ci::run(&shell),
        Task::Measure { what, rest } => what.run(&shell, rest),
        Task::Dist { folder } => dist::run(&shell, folder),
        Task::Pages { folder } => {
            let program = shell.program()?;
            ci::pages(&shell, &ci::python_of_readers(&shell)?, &program, folder)
        }
        Task::Sheet { list, folder, sheet } => shell
            .cargo("run --locked --release --quiet -p tashika --example contact_sheet --")
            .args([list, folder, sheet])
            .run(),
    }
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            shell::print_error(&message);
            ExitCode::FAILURE
        }
    }
}
