//! The program `tashika`.
//!
//! Arguments are read in two steps: [`args`] holds them as typed, and [`plan`] holds the work to
//! do, with every value checked. Each command then has one module. The library does all of the
//! computing; a command calls its public operations.
//!
//! Results go to standard output, progress and errors to standard error.
#![forbid(unsafe_code)]
// The lint forbids printing in the library. The program prints its results.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod args;
mod compare;
mod coverage;
mod exit;
mod experiment;
mod farm;
mod glare;
mod info;
mod interrupt;
mod measure;
mod merge;
mod notes;
mod plan;
mod progress;
mod render;
mod rescue;
mod sensors;
mod serve;
mod shell;
mod stage;
mod summary;
mod tev;
mod values;
mod view;
mod vpl;
mod watcher;

use std::process::ExitCode;

use args::{Args, Command};
use exit::{Failure, Outcome};

fn main() -> ExitCode {
    match run(&args::parsed()) {
        Ok(outcome) => outcome.into(),
        Err(failure) => {
            if !failure.is_told() {
                eprintln!("error: {}", progress::visible_lines(&failure.to_string()));
            }
            failure.into()
        }
    }
}

fn run(args: &Args) -> Result<Outcome, Failure> {
    match &args.command {
        Command::Render(typed) => render::run(&plan::RenderPlan::new(typed)?),
        Command::Sensors(typed) => sensors::run(&plan::SensorsPlan::new(typed)?),
        Command::Info(typed) => info::run(&plan::InfoPlan::new(typed)?),
        Command::Vpl(typed) => vpl::run(&plan::VplPlan::new(typed)?),
        Command::Farm(typed) => farm::run(&plan::FarmPlan::new(typed)?),
        Command::Merge(typed) => merge::run(&plan::MergePlan::new(typed)?),
        Command::View(typed) => view::run(&plan::ViewPlan::new(typed)?),
        Command::Glare(typed) => glare::run(&plan::GlarePlan::new(typed)?),
        Command::Compare(typed) => compare::run(&plan::ComparePlan::new(typed)?),
        Command::Coverage(typed) => coverage::run(&plan::CoveragePlan::new(typed)?),
        Command::Experiment(typed) => experiment::run(&plan::ExperimentPlan::new(typed)?),
        Command::Completions(typed) => shell::completions(typed.shell),
        Command::Man(typed) => shell::man(typed),
    }
}
