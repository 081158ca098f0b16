//! Jobs for render farms.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

use super::CommonArgs;
use crate::values;

/// Engine that runs the job.
#[derive(Debug, Subcommand)]
pub enum FarmArgs {
    /// Write a bundle of Open Job Description, for render farms: template.json
    #[command(after_help = OPENJD_EXAMPLES)]
    Openjd(FarmJobArgs),
    /// Write scripts for Slurm: submit.sh and those that it submits
    #[command(after_help = SLURM_EXAMPLES)]
    Slurm(FarmJobArgs),
}

#[derive(Debug, ClapArgs)]
pub struct FarmJobArgs {
    /// Number of shares of the tiles, each a task; about ten for each worker balance the load well
    #[arg(long, value_name = "N", value_parser = values::count, default_value = "16")]
    pub shares: u64,

    /// Folder for the job, its lights and its parts, which all machines see under this name; made
    /// if it does not exist
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub out: PathBuf,

    /// Command that runs tashika on the machines
    #[arg(long, value_name = "PROGRAM", default_value = "tashika", help_heading = "Machine")]
    pub program: String,

    #[command(flatten)]
    pub common: CommonArgs,

    /// Render command, as typed for one machine
    #[arg(last = true, required = true, value_name = "render ...")]
    pub line: Vec<String>,
}

const OPENJD_EXAMPLES: &str = "\
Examples:
  tashika farm openjd --shares 64 --out /shared/job -- render kitchen.pbrt --error 2% -o kitchen.exr
  openjd check /shared/job/template.json
  openjd run /shared/job/template.json --step Merge --run-dependencies";

const SLURM_EXAMPLES: &str = "\
Examples:
  tashika farm slurm --shares 64 --out /shared/job -- render kitchen.pbrt --error 2% -o kitchen.exr
  sh /shared/job/submit.sh";
