//! What is to be done by `experiment transport`.

use std::path::PathBuf;

use tashika::integrator::{ControlOptions, PathStop, Truth};
use tashika::request::Request;

use super::{Common, Folder, StagePlan};
use crate::args::{TransportArgs, TransportMethod};
use crate::exit::Failure;

/// Light transport, by us and by a path tracer.
#[derive(Debug)]
pub struct TransportPlan {
    /// Scene, camera, size.
    pub stage: StagePlan,
    /// Gather points and lights, of the first seed and for the strictest error.
    pub request: Request,
    /// Who.
    pub methods: Vec<TransportMethod>,
    /// What they are told, one after the other; at least one.
    pub options: Vec<ControlOptions>,
    /// Paths a pixel at most.
    pub most_paths: u32,
    /// The truth of an earlier run.
    pub reference: Option<PathBuf>,
    /// Pixels at random.
    pub pixels: u64,
    /// Seed of everything.
    pub seed: u64,
    /// Times that each pixel is rendered, at least one; the seeds count up from that.
    pub seeds: u64,
    /// Where the tables go.
    pub folder: Folder,
    /// What every command has.
    pub common: Common,
}

impl TransportPlan {
    /// Checks what was typed, and that the outputs can be written; makes the folder.
    pub fn new(args: &TransportArgs) -> Result<Self, Failure> {
        if args.seeds == 0 {
            return Err(Failure::option("seeds", 0, "1 or more"));
        }
        let stage = StagePlan::new(&args.stage, None)?;
        let request = Request {
            truth: Some(Truth::Transport),
            // For the strictest.
            error: args.error.iter().copied().min_by(f64::total_cmp),
            vpls: args.lights.vpls,
            clamp: args.lights.set.clamp,
            instants: args.lights.set.instants,
            gather: args.gather.points,
            filter: args.gather.filter.filter,
            seed: args.seed,
            ..Request::default()
        };
        request.check()?;
        request.resolve()?;
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

    /// The rule that a careful user of a path tracer would stop by.
    pub fn stops_by_itself(&self, options: &ControlOptions) -> PathStop {
        PathStop::until(*options, self.most_paths)
    }
}
