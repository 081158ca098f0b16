//! `tashika vpl`.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use indicatif::HumanCount;
use serde::Serialize;
use tashika::accel::Tracer;
use tashika::io::{load_vpls, save_vpls};
use tashika::vpl::{Provenance, VplKind, VplSet};

use crate::exit::{Failure, Outcome};
use crate::plan::{Common, VplPlan, VplTask};
use crate::progress::{Meter, metered};
use crate::summary::{Rows, counted, write_json};

/// Summary of a set of VPLs, as JSON.
#[derive(Debug, Serialize)]
struct Report<'a> {
    count: u64,
    kinds: Kinds,
    /// Number of times at which there are lights.
    instants: usize,
    provenance: &'a Provenance,
    /// Seconds for tracing or reading.
    seconds: f64,
    file: Option<PathBuf>,
}

#[derive(Debug, Default, Serialize)]
struct Kinds {
    omni: u64,
    oriented: u64,
    spot: u64,
    /// Lights whose intensity is an image.
    image: u64,
    directional: u64,
    /// Lights in participating media.
    volume: u64,
}

/// Traces and writes a set of VPLs, or reads one, and prints its summary.
pub fn run(plan: &VplPlan) -> Result<Outcome, Failure> {
    metered(&plan.common, |meter| work(plan, meter))
}

fn work(plan: &VplPlan, meter: &Meter) -> Result<Outcome, Failure> {
    let begun;
    let (set, file) = match &plan.task {
        VplTask::Trace { scene, options, output } => {
            meter.phase(&format!("reading {}", scene.label()));
            let tracer = Tracer::new(Arc::new(scene.load()?));
            meter.phase(&format!("tracing about {}", counted(options.count, "VPL", "VPLs")));
            begun = Instant::now();
            (VplSet::trace(&tracer, options)?, output)
        }
        VplTask::Inspect(path) => {
            begun = Instant::now();
            (load_vpls(path)?, &Some(path.clone()))
        }
    };
    let seconds = begun.elapsed().as_secs_f64();
    meter.finish();
    if let VplTask::Trace { output: Some(path), .. } = &plan.task {
        save_vpls(path, &set)?;
    }
    tell(&plan.common, &set, seconds, file.as_deref())
}

/// Prints the summary of a set that took `seconds` to trace or to read.
pub fn tell(common: &Common, set: &VplSet, seconds: f64, file: Option<&Path>) -> Result<Outcome, Failure> {
    let report = Report {
        count: set.len() as u64,
        kinds: kinds(set),
        instants: set.instants().len(),
        provenance: set.provenance(),
        seconds,
        file: file.map(Path::to_owned),
    };
    if let Some(path) = &common.json {
        write_json(path, &report)?;
    }
    if common.prints_rows() {
        rows(&report).print()?;
    }
    Ok(Outcome::Done)
}

fn kinds(set: &VplSet) -> Kinds {
    let mut kinds = Kinds::default();
    for light in set.lights() {
        *match light.kind {
            VplKind::Omni => &mut kinds.omni,
            VplKind::Oriented => &mut kinds.oriented,
            VplKind::Spot(_) => &mut kinds.spot,
            VplKind::Image(_) => &mut kinds.image,
            VplKind::Directional => &mut kinds.directional,
            VplKind::Volume(_) => &mut kinds.volume,
        } += 1;
    }
    kinds
}

fn rows(report: &Report<'_>) -> Rows {
    let mut rows = Rows::default();
    let p = report.provenance;
    rows.push("scene", &*p.scene);
    rows.push(
        "lights",
        format!("{} (asked for {})", counted(report.count, "VPL", "VPLs"), HumanCount(p.requested)),
    );
    rows.push("", format!("{} direct, {} indirect", HumanCount(p.direct), HumanCount(p.indirect)));
    let k = &report.kinds;
    let kinds = [
        ("oriented", k.oriented),
        ("omni", k.omni),
        ("spot", k.spot),
        ("image", k.image),
        ("directional", k.directional),
        ("in media", k.volume),
    ];
    let present = kinds.iter().filter(|(_, n)| *n > 0);
    let present: Vec<String> = present.map(|(kind, n)| format!("{} {kind}", HumanCount(*n))).collect();
    if !present.is_empty() {
        rows.push("", present.join(", "));
    }
    rows.push(
        "paths",
        format!("{}, at most {} surfaces long, seed {}", HumanCount(p.paths), p.max_depth, p.seed),
    );
    if report.instants > 1 {
        rows.push("instants", format!("{}, each with lights of its own", report.instants));
    }
    rows.push(
        "clamp",
        if p.clamp_distance > 0.0 { format!("{:.4} m", p.clamp_distance) } else { "off".to_owned() },
    );
    rows.push(
        "glossy",
        format!("{:.1} % of the reflected flux: carried on, not shown", 100.0 * p.glossy_share),
    );
    rows.push("seconds", format!("{:.2}", report.seconds));
    if let Some(file) = &report.file {
        rows.push("file", file.display().to_string());
    }
    rows
}
