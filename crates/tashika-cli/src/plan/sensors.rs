//! Plan of `sensors`.

use std::path::{Path, PathBuf};

use tashika::io::{LoadOptions, load_sensor_points};
use tashika::math::DVec3;
use tashika::request::{CameraChange, ClaimName, Framing, Request};
use tashika::scene::SensorPoint;
use tashika::sensors::{SensorGridRequest, SensorRequest};

use super::{Asked, Cameras, Common, SceneSource, StagePlan, has_ending, is_standard_stream, with_ending};
use crate::args::SensorsArgs;
use crate::exit::Failure;

/// Either a list, or a rule for making one.
#[derive(Clone, Debug)]
pub enum SensorsFrom {
    /// Sensors of a file.
    Points(Vec<SensorPoint>),
    /// A grid over a surface.
    Grid(SensorGridRequest),
}

/// Checked arguments of `sensors`.
#[derive(Debug)]
pub struct SensorsPlan {
    /// Scene. Its first camera gives only the medium of the sensors.
    pub stage: StagePlan,
    /// Sensors, or the grid that they follow from.
    pub sensors: SensorsFrom,
    /// Options of the measurement.
    pub request: SensorRequest,
    /// Request for one sensor, and the share of the sensors that is measured.
    pub asked: Asked,
    /// Unit vector to the zenith, if daylight factors are computed.
    pub daylight_up: Option<DVec3>,
    /// Table to write; `-` is standard output.
    pub csv: PathBuf,
    /// Page to write.
    pub html: Option<PathBuf>,
    /// True if sensors that ran out of budget do not change the exit code.
    pub accept_budget: bool,
    /// Options of every command.
    pub common: Common,
}

impl SensorsPlan {
    /// Checks the arguments, and that the outputs can be written.
    pub fn new(args: &SensorsArgs) -> Result<Self, Failure> {
        let scene = SceneSource::new(Some(&args.scene), &args.scene_args)?;
        let stage = StagePlan {
            scene,
            strict: args.strict,
            cameras: Cameras::new(&[]),
            change: CameraChange::default(),
            framing: Framing::default(),
        };
        let request = request(args)?;
        // The number of sensors is known after the scene is read.
        let asked = Asked::new(request.of(1)?, None)?;
        let asked = Asked { share: args.tiles.clone().unwrap_or_default(), ..asked };
        if args.jointly && !asked.share.is_whole() {
            return Err(Failure::usage("--jointly is about all sensors; with --tiles, set --confidence"));
        }
        let is_printed = is_standard_stream(&args.output);
        let csv = if is_printed { args.output.clone() } else { with_ending(&args.output, "csv")? };
        if is_printed && args.common.json.as_deref().is_some_and(is_standard_stream) {
            return Err(Failure::usage("--json -: standard output has the table; -o names a file for it"));
        }
        if let Some(html) = args.html.as_deref().filter(|path| !has_ending(path, "html")) {
            return Err(Failure::option("html", html.display(), "a file name ending in .html"));
        }
        let outputs: Vec<&Path> =
            [(!is_printed).then_some(csv.as_path()), args.html.as_deref()].into_iter().flatten().collect();
        let inputs: Vec<&Path> = stage.inputs(args.points.as_deref());
        let common = Common::new(&args.common, &outputs, &inputs)?;
        // The file is small, so that its faults are reported before the scene is read.
        let sensors = match (&args.points, &args.grid) {
            (Some(file), _) => SensorsFrom::Points(load_sensor_points(file, &LoadOptions::default())?),
            (None, Some(grid)) => SensorsFrom::Grid(grid.clone()),
            (None, None) => return Err(Failure::usage("--points or --grid names the sensors")),
        };
        Ok(Self {
            stage,
            sensors,
            request,
            asked,
            daylight_up: args.daylight_factor.then_some(if args.up == "z" { DVec3::Z } else { DVec3::Y }),
            csv,
            html: args.html.clone(),
            accept_budget: args.budget.accept_budget,
            common,
        })
    }
}

fn request(args: &SensorsArgs) -> Result<SensorRequest, Failure> {
    let request = Request {
        method: args.method.name()?,
        claim: args.claim.map(ClaimName::from),
        error: args.error,
        absolute: args.absolute,
        confidence: args.confidence,
        max_pairs: args.max_pairs,
        paths: args.paths,
        vpls: args.lights.vpls,
        clamp: args.lights.set.clamp,
        instants: args.lights.set.instants,
        seed: args.seed,
        ..Request::default()
    };
    Ok(SensorRequest { request, photometry: args.photometry, jointly: args.jointly })
}
