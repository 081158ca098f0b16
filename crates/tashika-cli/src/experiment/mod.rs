//! `tashika experiment`: the figures and curves of the literature, one command each.

mod ablation;
mod equal_quality;
mod scaling;
mod seed;

use tashika::render::with_threads;

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::plan::{ExperimentPlan, MeasurePlan};

/// Runs the experiment that was asked for.
pub fn run(plan: &ExperimentPlan) -> Result<Outcome, Failure> {
    interrupt::listen();
    let MeasurePlan { common, .. } = match plan {
        ExperimentPlan::Seed(plan) => &plan.measure,
        ExperimentPlan::Scaling(plan) => &plan.measure,
        ExperimentPlan::EqualQuality(plan) => &plan.measure,
        ExperimentPlan::Ablation(plan) => &plan.measure,
    };
    with_threads(common.threads, || match plan {
        ExperimentPlan::Seed(plan) => seed::work(plan),
        ExperimentPlan::Scaling(plan) => scaling::work(plan),
        ExperimentPlan::EqualQuality(plan) => equal_quality::work(plan),
        ExperimentPlan::Ablation(plan) => ablation::work(plan),
    })?
}
