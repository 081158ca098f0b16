//! `tashika farm`: a render as a job for the engine of a render farm, with shares of the tiles on
//! many machines and then a merge.
//!
//! Every step is a command line of this program. An engine only needs to run command lines on
//! machines that share a folder, and to restart steps whose worker is lost. A restarted share
//! resumes from its checkpoint, and gives the same bits.

mod job;
mod openjd;
mod slurm;

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use tashika::io::write_file;

use crate::exit::{Failure, Outcome};
use crate::plan::{Common, Farm, FarmPlan};
use crate::progress::metered;
use crate::summary::{Rows, counted, write_json};
use job::Job;

/// Summary of the written job, as JSON.
#[derive(Debug, Serialize)]
struct Report {
    shares: u32,
    image: PathBuf,
    files: Vec<PathBuf>,
}

/// Writes the files of the job.
pub fn run(plan: &FarmPlan) -> Result<Outcome, Failure> {
    metered(&plan.common, |_| work(plan))
}

fn work(plan: &FarmPlan) -> Result<Outcome, Failure> {
    if let Some(scene) = plan.render.stage.scene.missing_file() {
        let message =
            format!("{}: there is no such scene; a job names it as all machines find it", scene.display());
        return Err(Failure::file(message));
    }
    let job = Job::new(plan)?;
    let made = match plan.farm {
        Farm::OpenJd => openjd::files(&job),
        Farm::Slurm => slurm::files(&job),
    };
    if let Some((name, _)) = made.iter().find(|(name, _)| fs::symlink_metadata(job.folder.join(name)).is_ok())
    {
        let there = job.folder.join(name);
        let message = format!("{} is of a job that is there; --out names another folder", there.display());
        return Err(Failure::file(message));
    }
    fs::create_dir_all(&job.folder)
        .map_err(|e| Failure::file(format!("cannot write {}: {e}", job.folder.display())))?;
    let mut files = Vec::new();
    for (name, text) in made {
        let path = job.folder.join(name);
        write_file(&path, text.as_bytes())?;
        make_executable(&path)?;
        files.push(path);
    }
    let report = Report { shares: plan.shares, image: job.image.clone(), files };
    tell(&plan.common, &report, plan.farm)?;
    Ok(Outcome::Done)
}

fn tell(common: &Common, report: &Report, farm: Farm) -> Result<(), Failure> {
    if let Some(path) = &common.json {
        write_json(path, report)?;
    }
    if !common.prints_rows() {
        return Ok(());
    }
    let mut rows = Rows::default();
    rows.push(
        "job",
        format!("{}, then {}", counted(report.shares.into(), "share", "shares"), report.image.display()),
    );
    let files: Vec<String> = report.files.iter().map(|f| f.display().to_string()).collect();
    rows.push("files", files.join(", "));
    let first = report.files.first().map(|f| f.display().to_string()).unwrap_or_default();
    rows.push(
        "to run",
        match farm {
            Farm::OpenJd => {
                format!("openjd run {first} --step Merge --run-dependencies, or submit the folder")
            }
            Farm::Slurm => format!("sh {first}"),
        },
    );
    rows.print()
}

/// Makes scripts executable.
#[cfg_attr(not(unix), expect(unused_variables))]
fn make_executable(path: &Path) -> Result<(), Failure> {
    #[cfg(unix)]
    if path.extension().is_some_and(|e| e == "sh") {
        use std::os::unix::fs::PermissionsExt;
        let set = fs::set_permissions(path, fs::Permissions::from_mode(0o755));
        set.map_err(|e| Failure::file(format!("cannot write {}: {e}", path.display())))?;
    }
    Ok(())
}
