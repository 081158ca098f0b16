//! What is rendered: a scene, a view, lights, and a method.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;
use tashika::accel::Tracer;
use tashika::film::Window;
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{GuidedLights, Integrator, LightTransport, LitBy, Method, Setting, Truth};
use tashika::io::{LoadOptions, load_scene};
use tashika::render::{RenderOptions, Rendered, TileShare, render};
use tashika::request::{Integration, Request};
use tashika::scene::{Camera, Scene, builtin};
use tashika::tree::{LightTree, LightTreeBuilder};
use tashika::vpl::VplSet;

/// What is rendered, as it is typed. What is not said is as the program has it.
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
    #[arg(long)]
    pub points: Option<u64>,
    /// VPLs
    #[arg(long)]
    pub vpls: Option<u64>,
    /// Method
    #[arg(long, default_value = "tashika")]
    pub method: Method,
    /// What the error is the distance from: transport, clamped or vpl
    #[arg(long, value_parser = truth)]
    pub truth: Option<Truth>,
    /// Relative error
    #[arg(long)]
    pub error: Option<f64>,
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
    /// Rays.
    pub tracer: Tracer,
    lit: Lit,
    integration: Integration,
    gather: GatherOptions,
    camera: Camera,
}

/// The lights of a subject.
enum Lit {
    Set(VplSet, LightTree),
    Guided(GuidedLights),
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
        let SubjectArgs { method, truth, error, vpls, points, .. } = *args;
        let request =
            Request { method: Some(method), truth, error, vpls, gather: points, ..Request::default() };
        let resolved = request.resolve()?;
        let (integration, gather) = (resolved.integration.sized(args.size), resolved.gather);
        let camera = tracer.scene().cameras()[0].clone();
        let view = View { camera: &camera, size: args.size, gather, seed: request.seed };
        let lit = match &integration {
            Integration::ManyLights { lights: Some(options), .. } => {
                let set = VplSet::trace(&tracer, options)?;
                let tree = LightTree::build(&set, LightTreeBuilder::default());
                Lit::Set(set, tree)
            }
            Integration::Transport { lights: Some(options), truth, .. } => {
                Lit::Guided(GuidedLights::trace(&tracer, options, *truth, &view)?)
            }
            _ => unreachable!("a method of lights that are not given traces them"),
        };
        Ok(Self { args: args.clone(), tracer, lit, integration, gather, camera })
    }

    /// What integrators need.
    pub fn setting<'a>(&'a self, tracer: &'a Tracer) -> Setting<'a> {
        let Self { camera, gather, .. } = self;
        Setting { tracer, view: View { camera, size: self.args.size, gather: *gather, seed: 1 } }
    }

    /// The one set of VPLs and its tree, if the render is a sum over it.
    pub fn set(&self) -> Option<(&VplSet, &LightTree)> {
        match &self.lit {
            Lit::Set(set, tree) => Some((set, tree)),
            Lit::Guided(_) => None,
        }
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
        match (&self.integration, &self.lit) {
            (Integration::ManyLights { method, options, .. }, Lit::Set(set, tree)) => {
                let lit = LitBy { set, tree: Some(tree) };
                self.render_by(tracer, method.integrator(lit, options).as_ref())
            }
            (Integration::Transport { options, .. }, Lit::Guided(lights)) => {
                self.render_by(tracer, &LightTransport::new(tracer, lights, options))
            }
            _ => unreachable!("lights are made for the integration"),
        }
    }

    fn render_by(&self, tracer: &Tracer, integrator: &dyn Integrator) -> Rendered {
        let window = RenderOptions { window: self.window(), share: TileShare::default() };
        let never = AtomicBool::new(false);
        render(&self.setting(tracer), integrator, &window, &|_| (), &never)
            .expect("options are those of a render")
    }

    /// How many VPLs there are.
    pub fn lights(&self) -> u64 {
        match &self.lit {
            Lit::Set(set, _) => set.len() as u64,
            Lit::Guided(lights) => lights.count(),
        }
    }

    /// One line about it.
    pub fn describe(&self) -> String {
        let [width, height] = self.args.size;
        let window = self.window();
        let about = match &self.integration {
            Integration::ManyLights { method, options, .. } => format!("{method}, error {}", options.error),
            Integration::Transport { truth, options, .. } => {
                format!("{}, truth {truth}, error {}", self.args.method, options.error)
            }
            Integration::Path(_) => "path".to_owned(),
        };
        format!(
            "{}, {width}x{height} ({}x{} in the middle), {} VPLs, {} gather points, {about}",
            self.tracer.scene().name(),
            window.width,
            window.height,
            self.lights(),
            self.gather.points,
        )
    }
}
