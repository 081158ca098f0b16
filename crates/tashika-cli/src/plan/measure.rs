//! What is to be done by `coverage` and `experiment`.

use std::fs;
use std::path::{Path, PathBuf};

use tashika::experiment::{Cell, Grouping};
use tashika::integrator::{ControlOptions, Ingredient, MANY_PAIRS, Promise, SumMethod};
use tashika::request::Request;

use super::{Asked, Common, StagePlan, TransportPlan};
use crate::args::{
    AblationArgs, CommonArgs, CoverageArgs, EqualQualityArgs, ExperimentArgs, MeasureArgs, ScalingArgs,
    SeedArgs, StageArgs,
};
use crate::exit::Failure;
use crate::values::measured;

/// What all measurements have.
#[derive(Debug)]
pub struct MeasurePlan {
    /// Scene, camera, size.
    pub stage: StagePlan,
    /// Seed of gather points, lights and the choice of pixels.
    pub seed: u64,
    /// Methods with what they are told.
    pub cells: Vec<Cell>,
    /// What every command has.
    pub common: Common,
}

/// Where a measurement is written to.
enum Outputs<'a> {
    /// Files, each by its name.
    Files(&'a [&'a Path]),
    /// All to a folder.
    Folder(&'a Folder),
}

/// What methods are told.
struct Told<'a> {
    errors: &'a [f64],
    confidences: &'a [f64],
    max_pairs: Option<u64>,
    seeds: u64,
}

impl MeasurePlan {
    fn new(
        stage: &StageArgs,
        args: &MeasureArgs,
        told: &Told<'_>,
        lights: Option<&Path>,
        outputs: Outputs<'_>,
    ) -> Result<Self, Failure> {
        let stage = StagePlan::new(stage, None)?;
        if told.seeds == 0 {
            return Err(Failure::option("seeds", 0, "1 or more"));
        }
        let methods = if args.methods.is_empty() { measured().collect() } else { args.methods.clone() };
        let common = Cell {
            method: SumMethod::Exact,
            options: ControlOptions { max_pairs: told.max_pairs, ..ControlOptions::default() },
            tolerance: 0.0,
            seeds: told.seeds,
        };
        for &error in told.errors {
            ControlOptions { error, ..common.options }.validate()?;
        }
        for &confidence in told.confidences {
            ControlOptions { confidence, ..common.options }.validate()?;
        }
        let cells = Cell::grid(&methods, told.errors, told.confidences, &common);
        let inputs = stage.inputs(lights);
        let common = match outputs {
            Outputs::Files(paths) => Common::new(&args.common, paths, &inputs)?,
            Outputs::Folder(folder) => folder.common(&args.common, &inputs)?,
        };
        Ok(Self { stage, seed: args.seed, cells, common })
    }
}

/// A measurement of coverage.
#[derive(Debug)]
pub struct CoveragePlan {
    /// What all measurements have.
    pub measure: MeasurePlan,
    /// Gather points and lights.
    pub asked: Asked,
    /// Pixels at random.
    pub pixels: u64,
    /// What they are grouped by, besides.
    pub by: Vec<Grouping>,
    /// Page to write.
    pub html: Option<PathBuf>,
    /// Rows for spreadsheets to write.
    pub csv: Option<PathBuf>,
}

impl CoveragePlan {
    /// Checks what was typed, and that the outputs can be written.
    pub fn new(args: &CoverageArgs) -> Result<Self, Failure> {
        let asked = Asked::of_a_sum(&args.source, &args.gather, args.measure.seed)?;
        let told = Told {
            errors: &args.error,
            confidences: &args.confidence,
            max_pairs: args.pairs.max_pairs,
            seeds: args.trials.seeds,
        };
        let outputs: Vec<&Path> = args.html.iter().chain(&args.csv).map(PathBuf::as_path).collect();
        let measure =
            MeasurePlan::new(&args.stage, &args.measure, &told, asked.vpl_file(), Outputs::Files(&outputs))?;
        Ok(Self {
            measure,
            asked,
            pixels: args.trials.pixels,
            by: args.by.clone(),
            html: args.html.clone(),
            csv: args.csv.clone(),
        })
    }
}

/// An experiment.
#[derive(Debug)]
pub enum ExperimentPlan {
    /// Images, reference and errors.
    Seed(SeedPlan),
    /// Rays against lights and gather points.
    Scaling(ScalingPlan),
    /// Cost of the same quality.
    EqualQuality(EqualQualityPlan),
    /// What each ingredient of our method is worth.
    Ablation(AblationPlan),
    /// Light transport, by us and by a path tracer.
    Transport(TransportPlan),
}

impl ExperimentPlan {
    /// Checks what was typed, and that the outputs can be written; makes the folder.
    pub fn new(args: &ExperimentArgs) -> Result<Self, Failure> {
        Ok(match args {
            ExperimentArgs::Seed(args) => Self::Seed(SeedPlan::new(args)?),
            ExperimentArgs::Scaling(args) => Self::Scaling(ScalingPlan::new(args)?),
            ExperimentArgs::EqualQuality(args) => Self::EqualQuality(EqualQualityPlan::new(args)?),
            ExperimentArgs::Ablation(args) => Self::Ablation(AblationPlan::new(args)?),
            ExperimentArgs::Transport(args) => Self::Transport(TransportPlan::new(args)?),
        })
    }

    /// What every command has.
    pub fn common(&self) -> &Common {
        match self {
            Self::Seed(plan) => &plan.measure.common,
            Self::Scaling(plan) => &plan.measure.common,
            Self::EqualQuality(plan) => &plan.measure.common,
            Self::Ablation(plan) => &plan.measure.common,
            Self::Transport(plan) => &plan.common,
        }
    }
}

/// Whole images of all methods.
#[derive(Debug)]
pub struct SeedPlan {
    /// What all measurements have.
    pub measure: MeasurePlan,
    /// Gather points and lights.
    pub asked: Asked,
    /// Pixels whose exact sums are computed; none: all.
    pub pixels: Option<u64>,
    /// Where everything goes.
    pub folder: Folder,
}

impl SeedPlan {
    fn new(args: &SeedArgs) -> Result<Self, Failure> {
        let request = Request {
            // Of a file, that is how many there are.
            vpls: args.vpl_file.is_none().then_some(args.vpls),
            clamp: args.set.clamp,
            instants: args.set.instants,
            gather: Some(args.gather),
            filter: args.filter.filter,
            seed: args.measure.seed,
            ..Request::of_a_sum()
        };
        let asked = Asked::new(request, args.vpl_file.as_deref())?;
        let folder = Folder::new(&args.out);
        let told = Told {
            errors: &[args.tolerance.error],
            confidences: &[args.tolerance.confidence],
            max_pairs: args.pairs.max_pairs,
            seeds: 1,
        };
        let measure =
            MeasurePlan::new(&args.stage, &args.measure, &told, asked.vpl_file(), Outputs::Folder(&folder))?;
        Ok(Self { measure, asked, pixels: args.pixels, folder })
    }
}

/// Costs against numbers of lights and of gather points.
#[derive(Debug)]
pub struct ScalingPlan {
    /// What all measurements have.
    pub measure: MeasurePlan,
    /// For each number of lights, each number of gather points.
    pub asked: Vec<Vec<Asked>>,
    /// Pixels at random.
    pub pixels: u64,
    /// Where the tables go.
    pub folder: Folder,
}

impl ScalingPlan {
    fn new(args: &ScalingArgs) -> Result<Self, Failure> {
        let request = Request {
            clamp: args.set.clamp,
            instants: args.set.instants,
            filter: args.filter.filter,
            seed: args.measure.seed,
            ..Request::of_a_sum()
        };
        let of = |vpls: u64| {
            let of = |points: &u64| {
                Asked::new(Request { vpls: Some(vpls), gather: Some(*points), ..request.clone() }, None)
            };
            args.gather.iter().map(of).collect()
        };
        let asked = args.vpls.iter().map(|vpls| of(*vpls)).collect::<Result<_, _>>()?;
        let folder = Folder::new(&args.out);
        let told = Told {
            errors: &[args.tolerance.error],
            confidences: &[args.tolerance.confidence],
            max_pairs: args.pairs.max_pairs,
            seeds: args.trials.seeds,
        };
        let measure = MeasurePlan::new(&args.stage, &args.measure, &told, None, Outputs::Folder(&folder))?;
        Ok(Self { measure, asked, pixels: args.trials.pixels, folder })
    }
}

/// Costs of the same quality.
#[derive(Debug)]
pub struct EqualQualityPlan {
    /// What all measurements have; the errors in the cells are where the searches begin.
    pub measure: MeasurePlan,
    /// Gather points and lights.
    pub asked: Asked,
    /// Pixels at random.
    pub pixels: u64,
    /// Share of them that has to be within the tolerance.
    pub share: f64,
    /// Where the tables go.
    pub folder: Folder,
}

impl EqualQualityPlan {
    fn new(args: &EqualQualityArgs) -> Result<Self, Failure> {
        let asked = Asked::of_a_sum(&args.source, &args.gather, args.measure.seed)?;
        if !(args.share > 0.0 && args.share <= 1.0) {
            return Err(Failure::option("share", args.share, "above 0, at most 1 (100%)"));
        }
        let folder = Folder::new(&args.out);
        let told = Told {
            errors: &[args.tolerance.error],
            confidences: &[args.tolerance.confidence],
            max_pairs: Some(args.max_pairs.unwrap_or(MANY_PAIRS)),
            seeds: args.trials.seeds,
        };
        let measure =
            MeasurePlan::new(&args.stage, &args.measure, &told, asked.vpl_file(), Outputs::Folder(&folder))?;
        Ok(Self { measure, asked, pixels: args.trials.pixels, share: args.share, folder })
    }
}

/// The calibrated method, and the same without each of its ingredients.
#[derive(Debug)]
pub struct AblationPlan {
    /// What all measurements have.
    pub measure: MeasurePlan,
    /// Gather points and lights.
    pub asked: Asked,
    /// Pixels at random.
    pub pixels: u64,
    /// Where the tables go.
    pub folder: Folder,
}

impl AblationPlan {
    fn new(args: &AblationArgs) -> Result<Self, Failure> {
        let asked = Asked::of_a_sum(&args.source, &args.gather, args.measure.seed)?;
        if !args.measure.methods.is_empty() {
            return Err(Failure::usage(
                "--methods does not go with ablation, which has methods of its own".to_owned(),
            ));
        }
        let folder = Folder::new(&args.out);
        let told = Told {
            errors: &[args.tolerance.error],
            confidences: &[args.tolerance.confidence],
            max_pairs: None,
            seeds: args.trials.seeds,
        };
        let mut measure =
            MeasurePlan::new(&args.stage, &args.measure, &told, asked.vpl_file(), Outputs::Folder(&folder))?;
        let first = measure.cells[0];
        let methods = std::iter::once(SumMethod::Tashika(Promise::Calibrated))
            .chain(Ingredient::ALL.map(SumMethod::Without));
        measure.cells = methods.map(|method| Cell { method, ..first }).collect();
        Ok(Self { measure, asked, pixels: args.trials.pixels, folder })
    }
}

/// A folder for the files of an experiment.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// A folder that may not be there yet.
    pub(super) fn new(path: &Path) -> Self {
        Self(path.to_owned())
    }

    /// Path of a file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// The table for scripts.
    pub fn json(&self) -> PathBuf {
        self.file("table.json")
    }

    /// The table for people.
    pub fn markdown(&self) -> PathBuf {
        self.file("table.md")
    }

    /// The table for spreadsheets.
    pub fn csv(&self) -> PathBuf {
        self.file("table.csv")
    }

    /// The page.
    pub fn html(&self) -> PathBuf {
        self.file("index.html")
    }

    /// Makes the folder, and checks that it can be written to.
    pub(super) fn common(&self, args: &CommonArgs, inputs: &[&Path]) -> Result<Common, Failure> {
        fs::create_dir_all(&self.0)
            .map_err(|e| Failure::file(format!("cannot write {}: {e}", self.0.display())))?;
        Common::new(args, &[&self.json(), &self.markdown(), &self.csv(), &self.html()], inputs)
    }
}
