//! The lights of a render, as its method needs them.

use tashika::integrator::GuidedLights;
use tashika::request::Integration;
use tashika::tree::LightTree;
use tashika::vpl::VplSet;

use crate::exit::Failure;
use crate::plan::{Lights, RenderPlan};
use crate::progress::Meter;
use crate::stage::{Stage, light_tree, timed};
use crate::summary::{LightsReport, Seconds, counted};

/// The lights of a render.
pub enum Lit {
    /// None: paths find them.
    Emitters,
    /// One set, in a tree if the method needs one.
    Set(VplSet, Option<LightTree>),
    /// One set, guided to the view.
    Guided(GuidedLights),
}

impl Lit {
    /// Traces them, or takes those of a file.
    pub fn new(
        plan: &RenderPlan,
        stage: &Stage,
        stored: Option<VplSet>,
        meter: &Meter,
        seconds: &mut Seconds,
    ) -> Result<Self, Failure> {
        Ok(match (&plan.integration, &plan.lights) {
            (Integration::Transport { lights: Some(lights), truth, .. }, _) => {
                meter.phase(&format!("tracing about {}", counted(lights.count, "VPL", "VPLs")));
                let view = stage.setting(plan.gather, plan.seed).view;
                let trace = || GuidedLights::trace(&stage.tracer, lights, *truth, &view);
                Self::Guided(timed(&mut seconds.vpls, trace)?)
            }
            (Integration::Transport { lights: None, truth, .. }, Some(lights)) => {
                let set = stage.lights(lights, stored, meter, seconds)?;
                let view = stage.setting(plan.gather, plan.seed).view;
                let given = || GuidedLights::given(&stage.tracer, &set, *truth, &view);
                Self::Guided(timed(&mut seconds.trees, given)?)
            }
            (Integration::ManyLights { method, .. }, Some(lights)) => {
                let set = stage.lights(lights, stored, meter, seconds)?;
                let tree = method.needs_tree().then(|| light_tree(&set, meter, seconds));
                Self::Set(set, tree)
            }
            _ => Self::Emitters,
        })
    }

    /// How pixels are computed with these lights.
    pub fn integration(&self, asked: &Integration, points: u32) -> Integration {
        match self {
            Self::Set(set, _) => asked.over(set.len(), points),
            Self::Emitters | Self::Guided(_) => asked.clone(),
        }
    }

    /// What is told about them.
    pub fn report(&self, plan: &RenderPlan) -> Option<LightsReport> {
        let of = match self {
            Self::Emitters => return None,
            Self::Set(set, _) => set.provenance(),
            Self::Guided(lights) => lights.provenance(),
        };
        Some(LightsReport {
            count: of.direct + of.indirect,
            direct: of.direct,
            indirect: of.indirect,
            clamp_m: of.clamp_distance,
            seed: of.seed,
            file: plan.lights.as_ref().and_then(Lights::file).map(ToOwned::to_owned),
        })
    }
}
