//! Plan of `farm`.

use std::path::{Path, PathBuf};

use clap::Parser;
use tashika::render::TileShare;

use super::{Cameras, Common, Frames, RenderPlan};
use crate::args::{Args, Command, FarmArgs};
use crate::exit::Failure;

/// Engine that runs a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Farm {
    /// Template of Open Job Description.
    OpenJd,
    /// Scripts that are submitted to Slurm.
    Slurm,
}

/// Checked arguments of a job.
#[derive(Debug)]
pub struct FarmPlan {
    /// Engine that runs the job.
    pub farm: Farm,
    /// Number of shares of the tiles.
    pub shares: u32,
    /// Folder that the job is written to.
    pub folder: PathBuf,
    /// Command that runs this program on the machines.
    pub program: String,
    /// Words of the render as typed, `render` first.
    pub words: Vec<String>,
    /// Word among these that names the scene.
    pub scene: Option<String>,
    /// Denoiser of an audited picture, by its name or its file, if one was given.
    pub denoiser: Option<PathBuf>,
    /// Plan of the render that was typed.
    pub render: RenderPlan,
    /// Options of every command.
    pub common: Common,
}

impl FarmPlan {
    /// Checks the arguments, including those of the render.
    pub fn new(args: &FarmArgs) -> Result<Self, Failure> {
        let (farm, job) = match args {
            FarmArgs::Openjd(job) => (Farm::OpenJd, job),
            FarmArgs::Slurm(job) => (Farm::Slurm, job),
        };
        let shares = u32::try_from(job.shares).unwrap_or(u32::MAX);
        let share = TileShare::new(1, shares)
            .map_err(|_| Failure::option("shares", job.shares, format!("1 to {}", TileShare::MOST)))?;
        let line = std::iter::once("tashika").chain(job.line.iter().map(String::as_str));
        let typed = Args::try_parse_from(line)
            .map_err(|e| Failure::usage(e.to_string().trim_start_matches("error: ").trim_end().to_owned()))?;
        let Command::Render(mut render) = typed.command else {
            let message =
                format!("a job is a render; expected `render ...` after --, found `{}`", job.line.join(" "));
            return Err(Failure::usage(message));
        };
        let of_one_machine =
            "--tiles, --serve, --tev and --audit are of one machine; leave them out of the job";
        if render.tiles.is_some() || render.serve || render.tev.is_some() {
            return Err(Failure::usage(of_one_machine));
        }
        let cameras = Cameras::new(&render.stage.camera.cameras);
        if cameras.several() {
            return Err(Failure::option(
                "camera",
                cameras.typed(),
                "one camera of a job; write a job for each",
            ));
        }
        if let Some(frames) = Frames::new(&render.frames)? {
            let expected = "one frame of a job, by --at; write a job for each";
            return Err(Failure::option("frames", frames.typed(), expected));
        }
        // The render is checked as the machines will run it: as a share. The job adds
        // `--checkpoint` to each share.
        render.tiles = Some(share);
        render.checkpoint = false;
        let plan = RenderPlan::new(&render)?;
        let is_audited = plan.asked.request.is_audited();
        if is_audited && shares == 1 {
            let expected = "2 or more of an audited picture; `tashika render` makes the whole";
            return Err(Failure::option("shares", shares, expected));
        }
        if render.audit.is_some() && !is_audited {
            return Err(Failure::usage(of_one_machine));
        }
        let inputs: Vec<&Path> = render.stage.scene.as_deref().map(Path::new).into_iter().collect();
        Ok(Self {
            farm,
            shares,
            folder: job.out.clone(),
            program: job.program.clone(),
            words: job.line.clone(),
            scene: render.stage.scene.clone(),
            common: Common::new(&job.common, &[], &inputs)?,
            denoiser: render.denoiser.clone().filter(|_| is_audited),
            render: plan,
        })
    }
}
