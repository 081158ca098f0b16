//! Plan of `experiment transport`.

use std::path::PathBuf;

use tashika::integrator::{ControlOptions, PathStop, Truth};
use tashika::request::Request;

use super::{Common, Folder, StagePlan};
use crate::args::{TransportArgs, TransportMethod};
use crate::exit::Failure;

/// Checked arguments of `experiment transport`.
#[derive(Debug)]
pub struct TransportPlan {
    /// Scene, camera, size.
    pub stage: StagePlan,
    /// Gather points and lights, for the first seed and the strictest error.
    pub request: Request,
    /// Estimators that are measured.
    pub methods: Vec<TransportMethod>,
    /// Options of the estimators, one for each error; at least one.
    pub options: Vec<ControlOptions>,
    /// Largest number of paths a pixel.
    pub most_paths: u32,
    /// File with the truth of an earlier run.
    pub reference: Option<PathBuf>,
    /// Number of pixels, drawn at random.
    pub pixels: u64,
    /// First seed. It also chooses the pixels, and the seed of the truth is derived from it.
    pub seed: u64,
    /// Number of times that each pixel is rendered, at least one; the seeds count up from `seed`.
    pub seeds: u64,
    /// Folder that the tables and the truth are written to.
    pub folder: Folder,
    /// Options of every command.
    pub common: Common,
}

impl TransportPlan {
    /// Checks the arguments, and that the outputs can be written; makes the folder.
    pub fn new(args: &TransportArgs) -> Result<Self, Failure> {
        if args.seeds == 0 {
            return Err(Failure::option("seeds", 0, "1 or more"));
        }
        let stage = StagePlan::new(&args.stage, None)?;
        let request = Request {
            truth: Some(Truth::Transport),
            // The strictest error determines the defaults of the other options.
            error: args.error.iter().copied().min_by(f64::total_cmp),
            vpls: args.lights.vpls,
            clamp: args.lights.set.clamp,
            instants: args.lights.set.instants,
            gather: args.gather.points,
            filter: args.gather.filter.filter,
            seed: args.seed,
            ..Request::default()
        };
        request.validate()?;
        let confidence = args.confidence;
        let told = |error| ControlOptions { error, confidence, seed: args.seed, ..ControlOptions::default() };
        let options: Vec<ControlOptions> = args.error.iter().map(|error| told(*error)).collect();
        options.iter().try_for_each(ControlOptions::validate)?;
        let folder = Folder::new(&args.out);
        let inputs = stage.inputs(args.reference.as_deref());
        let common = folder.common(&args.common, &inputs)?;
        Ok(Self {
            most_paths: Request { paths: Some(args.paths), ..request.clone() }
                .path_count()?
                .unwrap_or(u32::MAX),
            request,
            methods: args.methods.clone(),
            options,
            reference: args.reference.clone(),
            pixels: args.pixels,
            seed: args.seed,
            seeds: args.seeds,
            folder,
            common,
            stage,
        })
    }

    /// Stopping rule that a careful user of a path tracer would choose.
    pub fn stops_by_itself(&self, options: &ControlOptions) -> PathStop {
        PathStop::until(*options, self.most_paths)
    }
}
