//! What is rendered: a scene, a view, lights, and a method.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;
use tashika::accel::Tracer;
use tashika::film::Window;
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{ControlOptions, LitBy, Method, Setting};
use tashika::io::{LoadOptions, load_scene};
use tashika::render::{RenderOptions, Rendered, TileShare, render};
use tashika::scene::{Camera, Scene, builtin};
use tashika::tree::{LightTree, LightTreeBuilder};
use tashika::vpl::{VplOptions, VplSet};

/// What is rendered, as it is typed.
#[derive(Args, Clone, Debug)]
pub struct SubjectArgs {
    /// Scene file; the built-in room if none is given
    #[arg(long)]
    pub scene: Option<PathBuf>,
    /// Width and height of the image, e.g. 256x256
    #[arg(long, default_value = "256x256", value_parser = size)]
    pub size: [u32; 2],
    /// Side of the square in the middle of the image that is rendered (pixels); all if not given
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub crop: Option<u32>,
    /// Gather points a pixel
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub points: u32,
    /// VPLs
    #[arg(long, default_value_t = 55_000)]
    pub vpls: u64,
    /// Method
    #[arg(long, default_value = "tashika")]
    pub method: Method,
    /// Relative error
    #[arg(long, default_value_t = 0.02)]
    pub error: f64,
}

/// What every benchmark takes.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    /// What is rendered.
    #[command(flatten)]
    pub subject: SubjectArgs,
    /// Rounds that count
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub rounds: u32,
    /// What cargo adds
    #[arg(long, hide = true)]
    bench: bool,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides.filter(|sides| sides.iter().all(|&s| s > 0)).ok_or_else(|| "expected e.g. 256x256".to_owned())
}

/// A scene that is ready to be rendered.
pub struct Subject {
    args: SubjectArgs,
    /// Rays.
    pub tracer: Tracer,
    /// VPLs.
    pub lights: VplSet,
    /// The tree over them.
    pub tree: LightTree,
    camera: Camera,
}

/// Reads the scene that was typed.
pub fn scene(args: &SubjectArgs) -> Result<Arc<Scene>, Box<dyn Error>> {
    Ok(Arc::new(match &args.scene {
        None => builtin::room(),
        Some(path) => load_scene(path, &LoadOptions::default())?,
    }))
}

impl Subject {
    /// Makes everything that a render needs.
    pub fn new(args: &SubjectArgs) -> Result<Self, Box<dyn Error>> {
        Self::of(Tracer::new(scene(args)?), args)
    }

    /// Makes everything that a render with this tracer needs.
    pub fn of(tracer: Tracer, args: &SubjectArgs) -> Result<Self, Box<dyn Error>> {
        let lights = VplSet::trace(&tracer, &VplOptions { count: args.vpls, ..VplOptions::default() })?;
        let tree = LightTree::build(&lights, LightTreeBuilder::default());
        let camera = tracer.scene().cameras()[0].clone();
        Ok(Self { args: args.clone(), tracer, lights, tree, camera })
    }

    /// What integrators need.
    pub fn setting<'a>(&'a self, tracer: &'a Tracer) -> Setting<'a> {
        let gather = GatherOptions { points: self.args.points, ..GatherOptions::default() };
        Setting { tracer, view: View { camera: &self.camera, size: self.args.size, gather, seed: 1 } }
    }

    /// The part of the image that is rendered.
    pub fn window(&self) -> Window {
        let [width, height] = self.args.size;
        let side = self.args.crop.unwrap_or(u32::MAX);
        let (w, h) = (side.min(width), side.min(height));
        Window { x: (width - w) / 2, y: (height - h) / 2, width: w, height: h }
    }

    /// Renders, with this tracer or one that is heard.
    pub fn render(&self, tracer: &Tracer) -> Rendered {
        let options = ControlOptions { error: self.args.error, ..ControlOptions::default() };
        let lit = LitBy { set: &self.lights, tree: Some(&self.tree) };
        let integrator = self.args.method.integrator(lit, &options);
        let window = RenderOptions { window: self.window(), share: TileShare::default() };
        let never = AtomicBool::new(false);
        render(&self.setting(tracer), integrator.as_ref(), &window, &|_| (), &never)
            .expect("options are those of a render")
    }

    /// One line about it.
    pub fn describe(&self) -> String {
        let SubjectArgs { size: [width, height], points, error, .. } = &self.args;
        let window = self.window();
        format!(
            "{}, {width}x{height} ({}x{} in the middle), {} VPLs, {points} gather points, {:?}, error {error}",
            self.tracer.scene().name(),
            window.width,
            window.height,
            self.lights.len(),
            self.args.method,
        )
    }
}
