//! Subject of a benchmark: a scene, a view, lights, and a method.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use tashika::accel::Tracer;
use tashika::film::Window;
use tashika::integrator::{MANY_PAIRS, Setting, SumMethod, Truth};
use tashika::io::{LoadOptions, load_scene};
use tashika::render::Rendered;
use tashika::renderer::{AuditedJob, Job, Prepared, Renderer};
use tashika::request::{Framing, Request};
use tashika::scene::{Scene, builtin};
use tashika::tree::LightTree;
use tashika::vpl::VplSet;

/// Options of the subject. Options that are not given have the program's defaults.
#[derive(Args, Clone, Debug)]
pub struct SubjectArgs {
    /// Scene file; the built-in room if none is given
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// Width and height of the image, e.g. 256x256
    #[arg(long, default_value = "256x256", value_parser = size)]
    pub size: [u32; 2],
    /// Side in pixels of the square in the middle of the image that is rendered; all if not given
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub crop: Option<u32>,
    /// Number of gather points a pixel
    #[arg(long)]
    pub points: Option<u64>,
    /// Number of VPLs to trace, to within a few percent
    #[arg(long)]
    pub vpls: Option<u64>,
    /// Method by its name, such as tashika or iwasaki2019
    #[arg(long, default_value = "tashika")]
    pub method: SumMethod,
    /// Truth that the error is measured against: transport, clamped or vpl
    #[arg(long, value_parser = truth)]
    pub truth: Option<Truth>,
    /// Relative error of a pixel at which it is finished
    #[arg(long)]
    pub error: Option<f64>,
}

/// Options that every benchmark has.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    /// Scene, view, lights and method.
    #[command(flatten)]
    pub subject: SubjectArgs,
    /// Number of rounds that are measured
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub rounds: u32,
    /// Flag that cargo adds
    #[arg(long, hide = true)]
    bench: bool,
}

fn truth(text: &str) -> Result<Truth, String> {
    let named = Truth::ALL.into_iter().find(|truth| truth.to_string() == text);
    named.ok_or_else(|| format!("expected {}", Truth::ALL.map(|truth| truth.to_string()).join(", ")))
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.filter(|sides| sides.iter().all(|&s| s > 0)).ok_or_else(|| "expected e.g. 256x256".to_owned())
}

/// A scene that is ready to be rendered.
pub struct Subject {
    args: SubjectArgs,
    /// Ray tracer over the scene.
    pub tracer: Tracer,
    prepared: Prepared<'static>,
}

/// Reads the scene that the options name; the built-in room if they name none.
pub fn scene(args: &SubjectArgs) -> Result<Arc<Scene>, Box<dyn Error>> {
    Ok(Arc::new(match &args.scene {
        None => builtin::room(),
        Some(path) => load_scene(path, &LoadOptions::default())?,
    }))
}

impl Subject {
    /// Reads the scene and prepares its render.
    pub fn new(args: &SubjectArgs) -> Result<Self, Box<dyn Error>> {
        Self::of(Tracer::new(scene(args)?), args)
    }

    /// Prepares a render with this tracer.
    pub fn of(tracer: Tracer, args: &SubjectArgs) -> Result<Self, Box<dyn Error>> {
        let SubjectArgs { method, truth, error, vpls, points, size, crop, .. } = *args;
        // If a largest cut is set, short sums are estimated too, instead of being computed whole.
        let is_our_sum = matches!(method, SumMethod::Tashika(_)) && truth == Some(Truth::Vpl);
        let max_pairs = is_our_sum.then_some(MANY_PAIRS);
        let request = Request {
            method: method.into(),
            truth,
            error,
            max_pairs,
            vpls,
            gather: points,
            ..Request::default()
        };
        let framing = Framing { size: Some(size), crop: Some(middle(size, crop)) };
        let prepared = Renderer::on(&tracer).request(request).framing(framing).prepare()?;
        Ok(Self { args: args.clone(), tracer, prepared })
    }

    /// Setting for integrators, with `tracer` for all rays.
    pub fn setting<'a>(&'a self, tracer: &'a Tracer) -> Setting<'a> {
        Setting { tracer, ..self.prepared.setting() }
    }

    /// Set of VPLs and its tree, if the render is a sum over one set.
    pub fn set(&self) -> Option<(&VplSet, &LightTree)> {
        let lights = self.prepared.job().light_set().ok()?;
        Some((lights.set(), lights.tree()))
    }

    /// Part of the image that is rendered.
    pub fn window(&self) -> Window {
        self.prepared.window()
    }

    /// Renders with `tracer`, which is the subject's tracer or a copy of it with a listener.
    pub fn render(&self, tracer: &Tracer) -> Rendered {
        self.prepared.on(tracer).render().expect("options are those of a render")
    }

    /// Number of VPLs of the render.
    pub fn lights(&self) -> u64 {
        self.prepared.job().provenance().map_or(0, |lights| lights.direct + lights.indirect)
    }

    /// Describes scene, size, lights and method in one line.
    pub fn describe(&self) -> String {
        let [width, height] = self.args.size;
        let window = self.window();
        let about = match self.prepared.job() {
            Job::Sum { method, options, .. } => format!("{method}, error {}", options.error),
            Job::Transport { truth, options, .. } => {
                format!("{}, truth {truth}, error {}", self.args.method, options.error)
            }
            Job::Audited(AuditedJob { options, .. }) => {
                format!("{}, audited, error {}", self.args.method, options.error)
            }
            Job::Path { .. } => "path".to_owned(),
        };
        format!(
            "{}, {width}x{height} ({}x{} in the middle), {} VPLs, {} gather points, {about}",
            self.tracer.scene().name(),
            window.width,
            window.height,
            self.lights(),
            self.prepared.setting().view.gather.points,
        )
    }
}

/// Window in the middle of an image, at most `side` pixels wide and high; all of it if `None`.
fn middle([width, height]: [u32; 2], side: Option<u32>) -> Window {
    let side = side.unwrap_or(u32::MAX);
    let (w, h) = (side.min(width), side.min(height));
    Window { x: (width - w) / 2, y: (height - h) / 2, width: w, height: h }
}
