//! Plans of `coverage` and `experiment`.

use std::fs;
use std::path::{Path, PathBuf};

use tashika::experiment::{Cell, Grouping};
use tashika::integrator::{ControlOptions, Ingredient, MANY_PAIRS, Promise, SumMethod};
use tashika::request::Request;

use super::{Asked, Common, StagePlan, TransportPlan};
use crate::args::{
    AblationArgs, CommonArgs, CoverageArgs, EqualQualityArgs, ExperimentArgs, Iwasaki2019Args, MeasureArgs,
    ScalingArgs, StageArgs,
};
use crate::exit::Failure;
use crate::values::measured;

/// Options of all measurements.
#[derive(Debug)]
pub struct MeasurePlan {
    /// Scene, camera, size.
    pub stage: StagePlan,
    /// Seed of gather points, lights and the choice of pixels.
    pub seed: u64,
    /// Methods with their errors, confidences and seeds.
    pub cells: Vec<Cell>,
    /// Options of every command.
    pub common: Common,
}

/// Destination of the files of a measurement.
enum Outputs<'a> {
    /// Files, each by its name.
    Files(&'a [&'a Path]),
    /// All files in one folder.
    Folder(&'a Folder),
}

/// Options that the methods are run with.
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

/// Checked arguments of `coverage`.
#[derive(Debug)]
pub struct CoveragePlan {
    /// Options of all measurements.
    pub measure: MeasurePlan,
    /// Gather points and lights.
    pub asked: Asked,
    /// Number of pixels, drawn at random.
    pub pixels: u64,
    /// Groupings of pixels that are reported besides all pixels.
    pub by: Vec<Grouping>,
    /// Page to write.
    pub html: Option<PathBuf>,
    /// File to write with the rows for spreadsheets.
    pub csv: Option<PathBuf>,
}

impl CoveragePlan {
    /// Checks the arguments, and that the outputs can be written.
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

/// Checked arguments of `experiment`.
#[derive(Debug)]
pub enum ExperimentPlan {
    /// Images, reference and errors.
    Iwasaki2019(Iwasaki2019Plan),
    /// Rays against lights and gather points.
    Scaling(ScalingPlan),
    /// Cost of each method at equal quality.
    EqualQuality(EqualQualityPlan),
    /// Our method without each of its ingredients.
    Ablation(AblationPlan),
    /// Light transport, by our method and by a path tracer.
    Transport(TransportPlan),
}

impl ExperimentPlan {
    /// Checks the arguments, and that the outputs can be written; makes the folder.
    pub fn new(args: &ExperimentArgs) -> Result<Self, Failure> {
        Ok(match args {
            ExperimentArgs::Iwasaki2019(args) => Self::Iwasaki2019(Iwasaki2019Plan::new(args)?),
            ExperimentArgs::Scaling(args) => Self::Scaling(ScalingPlan::new(args)?),
            ExperimentArgs::EqualQuality(args) => Self::EqualQuality(EqualQualityPlan::new(args)?),
            ExperimentArgs::Ablation(args) => Self::Ablation(AblationPlan::new(args)?),
            ExperimentArgs::Transport(args) => Self::Transport(TransportPlan::new(args)?),
        })
    }

    /// Options of every command.
    pub fn common(&self) -> &Common {
        match self {
            Self::Iwasaki2019(plan) => &plan.measure.common,
            Self::Scaling(plan) => &plan.measure.common,
            Self::EqualQuality(plan) => &plan.measure.common,
            Self::Ablation(plan) => &plan.measure.common,
            Self::Transport(plan) => &plan.common,
        }
    }
}

/// Whole images of all methods.
#[derive(Debug)]
pub struct Iwasaki2019Plan {
    /// Options of all measurements.
    pub measure: MeasurePlan,
    /// Gather points and lights.
    pub asked: Asked,
    /// Number of pixels whose exact sums are computed; `None` for all.
    pub pixels: Option<u64>,
    /// Folder that all files are written to.
    pub folder: Folder,
}

impl Iwasaki2019Plan {
    fn new(args: &Iwasaki2019Args) -> Result<Self, Failure> {
        let request = Request {
            // With a file of lights, the file determines the number of lights.
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
    /// Options of all measurements.
    pub measure: MeasurePlan,
    /// For each number of lights, each number of gather points.
    pub asked: Vec<Vec<Asked>>,
    /// Number of pixels, drawn at random.
    pub pixels: u64,
    /// Folder that the tables are written to.
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

/// Cost of each method at equal quality.
#[derive(Debug)]
pub struct EqualQualityPlan {
    /// Options of all measurements; the searches begin at the errors of the cells.
    pub measure: MeasurePlan,
    /// Gather points and lights.
    pub asked: Asked,
    /// Number of pixels, drawn at random.
    pub pixels: u64,
    /// Share of the pixels that has to be within the tolerance.
    pub share: f64,
    /// Folder that the tables are written to.
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

/// The calibrated method, whole and without each of its ingredients.
#[derive(Debug)]
pub struct AblationPlan {
    /// Options of all measurements.
    pub measure: MeasurePlan,
    /// Gather points and lights.
    pub asked: Asked,
    /// Number of pixels, drawn at random.
    pub pixels: u64,
    /// Folder that the tables are written to.
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
    /// Takes the path of a folder, which need not exist yet.
    pub(super) fn new(path: &Path) -> Self {
        Self(path.to_owned())
    }

    /// Path of a file in the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Path of the table for scripts.
    pub fn json(&self) -> PathBuf {
        self.file("table.json")
    }

    /// Path of the table for people.
    pub fn markdown(&self) -> PathBuf {
        self.file("table.md")
    }

    /// Path of the table for spreadsheets.
    pub fn csv(&self) -> PathBuf {
        self.file("table.csv")
    }

    /// Path of the page.
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
