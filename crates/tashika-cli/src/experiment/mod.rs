//! `tashika experiment`: the figures and curves of the literature, one command each.

mod ablation;
mod equal_quality;
mod scaling;
mod seed;
mod transport;

use tashika::render::with_threads;

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::plan::ExperimentPlan;

/// Runs the experiment that was asked for.
pub fn run(plan: &ExperimentPlan) -> Result<Outcome, Failure> {
    interrupt::listen();
    with_threads(plan.common().threads, || match plan {
        ExperimentPlan::Seed(plan) => seed::work(plan),
        ExperimentPlan::Scaling(plan) => scaling::work(plan),
        ExperimentPlan::EqualQuality(plan) => equal_quality::work(plan),
        ExperimentPlan::Ablation(plan) => ablation::work(plan),
        ExperimentPlan::Transport(plan) => transport::work(plan),
    })?
}
