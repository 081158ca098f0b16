//! `tashika experiment`: the figures and curves of the literature, one command each.

mod ablation;
mod equal_quality;
mod iwasaki2019;
mod scaling;
mod transport;

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::plan::ExperimentPlan;
use crate::progress::metered;

/// Runs the experiment of the plan.
pub fn run(plan: &ExperimentPlan) -> Result<Outcome, Failure> {
    interrupt::listen(plan.common());
    metered(plan.common(), |meter| match plan {
        ExperimentPlan::Iwasaki2019(plan) => iwasaki2019::work(plan, meter),
        ExperimentPlan::Scaling(plan) => scaling::work(plan, meter),
        ExperimentPlan::EqualQuality(plan) => equal_quality::work(plan, meter),
        ExperimentPlan::Ablation(plan) => ablation::work(plan, meter),
        ExperimentPlan::Transport(plan) => transport::work(plan, meter),
    })
}
