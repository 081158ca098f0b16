//! `tashika experiment transport`: intervals about light transport, by our method and by a path
//! tracer that stops at its own interval.

use std::time::Instant;

use tashika::experiment::{Column, Pixels, Pool, Row, Subject, Told, converged, until_converged};
use tashika::film::{Film, Window};
use tashika::gather::View;
use tashika::integrator::{ControlOptions, GuidedLights, Integrator, LightTransport, PathTracer, Setting};
use tashika::io::{read_exr, write_exr};
use tashika::render::TileShare;
use tashika::report::{Named, Tolerance, compare, percent_of_share, percent_of_tolerance};
use tashika::request::{Framed, Request};
use tashika::vpl::VplOptions;

use crate::args::TransportMethod;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::measure::{Bench, Findings, about_intervals, quantities, scenery};
use crate::plan::{Asked, TransportPlan};
use crate::progress::Meter;
use crate::stage::Stage;
use crate::summary::{Seconds, counted};
use crate::watcher::Watcher;

const COLUMNS: &[Column] = &[
    Column::Method,
    Column::Error,
    Column::Confidence,
    Column::Trials,
    Column::Within,
    Column::Claims,
    Column::Median,
    Column::P95,
    Column::Worst,
    Column::Budget,
    Column::Rays,
    Column::Seconds,
];

/// Mask that is combined with the seed for the truth, so that no estimate uses the random numbers
/// of the truth.
const OTHER_SEED: u64 = 0x7_2074;

/// Runs the methods with every error.
pub fn work(plan: &TransportPlan, meter: &Meter) -> Result<Outcome, Failure> {
    let mut seconds = Seconds::default();
    // A file that cannot be read fails before any work.
    let stored = plan.reference.as_ref().map(|file| read_exr(file)).transpose()?;
    let stage = Stage::load(&plan.stage, meter, &mut seconds)?;
    let pixels = Pixels::of(Window::full(stage.framed.size), Some(plan.pixels), plan.seed)?;
    let mut trials: Vec<Trials<'_>> = plan
        .methods
        .iter()
        .flat_map(|method| plan.options.iter().map(|options| Trials::new(*method, options)))
        .collect();
    let mut findings = Findings {
        title: format!("{}: light transport, by two methods", stage.scene.name()),
        above: vec![scenery(&stage, &pixels)],
        rows: Vec::new(),
        of: trials.len(),
        columns: COLUMNS,
        below: about_intervals(),
        images: Vec::new(),
        reference: None,
    };
    let (mut vpls, mut tracing, mut traced) = (0, 0.0, 0);
    let watcher = Watcher::new(meter, seconds);
    let gather = plan.request.gather_options()?;
    interrupt::with_flag(|cancel| -> Result<(), Failure> {
        let bench = Bench { meter, cancel };
        let truth = match &stored {
            Some(film) => Some(film.clone()),
            None => truth(plan, &bench, &stage, &pixels)?,
        };
        let Some(truth) = truth else { return Ok(()) };
        for number in 0..plan.seeds {
            let seed = plan.seed.wrapping_add(number);
            let request = Request { seed, ..plan.request.clone() };
            let asked = Asked {
                request,
                vpl_file: None,
                share: TileShare::default(),
                smoother: None,
                mattes: None,
                motion_vectors: false,
                groups: None,
            };
            let begun = Instant::now();
            let prepared = stage.prepare(&asked, None, meter, &watcher)?;
            let lights = prepared.job().guided_lights()?;
            tracing += begun.elapsed().as_secs_f64();
            traced += 1;
            vpls = lights.count();
            for trials in &mut trials {
                if !trials.render(
                    plan,
                    &bench,
                    &Drawn { setting: prepared.setting(), lights, number },
                    &pixels,
                    &truth,
                )? {
                    return Ok(());
                }
            }
        }
        Ok(())
    })?;
    // After an interruption, the results so far are reported.
    let begun = trials.iter().filter(|trials| !trials.films.is_empty());
    findings.rows = begun.map(|trials| trials.row(&stage, vpls, gather.points)).collect();
    findings.below.extend(trials.iter().filter_map(Trials::disjoint));
    if traced > 0 {
        let lights = quantities(vpls, &gather);
        let (tracing, seeds) = (tracing / f64::from(traced), counted(plan.seeds, "seed", "seeds"));
        findings.above.push(format!("{lights}, traced in {tracing:.1} s; {seeds}"));
    }
    let fewest = trials.iter().map(|trials| trials.films.len() as u64).min().unwrap_or(0);
    if fewest < plan.seeds {
        findings
            .below
            .push(format!("Interrupted: {fewest} of {} are whole.", counted(plan.seeds, "seed", "seeds")));
    }
    let outcome = findings.finish(&plan.common, Some(&plan.folder), meter)?;
    Ok(if fewest < plan.seeds { Outcome::Interrupted } else { outcome })
}

/// Path-traces the truth of the pixels; `None` if interrupted.
fn truth(
    plan: &TransportPlan,
    bench: &Bench<'_>,
    stage: &Stage,
    pixels: &Pixels,
) -> Result<Option<Film>, Failure> {
    let strictest =
        plan.options.iter().min_by(|a, b| a.error.total_cmp(&b.error)).expect("there is an error");
    let length = until_converged(strictest, plan.most_paths);
    let path = PathTracer::new(&stage.tracer, length, VplOptions::default().path_depth())?;
    bench.meter.phase(&format!("path tracing the truth of {}", counted(pixels.count(), "pixel", "pixels")));
    let Framed { camera, size, .. } = &stage.framed;
    let gather = plan.request.gather_options()?;
    let view = View { camera, size: *size, gather, seed: plan.seed ^ OTHER_SEED };
    let setting = Setting { tracer: &stage.tracer, view };
    let rendered = pixels.render(&setting, &path, &|p| bench.meter.update(p), bench.cancel)?;
    if !rendered.complete {
        return Ok(None);
    }
    write_exr(&plan.folder.file("reference.exr"), &rendered.film)?;
    Ok(Some(rendered.film))
}

/// View and lights of one seed.
struct Drawn<'a> {
    setting: Setting<'a>,
    lights: &'a GuidedLights,
    /// Index of the seed, from 0.
    number: u64,
}

/// Results of a method with one error, for several seeds.
struct Trials<'a> {
    method: TransportMethod,
    options: &'a ControlOptions,
    tolerance: Tolerance,
    pool: Pool,
    films: Vec<Film>,
    seconds: f64,
    /// Number of pairs of intervals that two seeds claim for the same pixel, and number of disjoint
    /// pairs among them.
    pairs: [u64; 2],
}

impl<'a> Trials<'a> {
    fn new(method: TransportMethod, options: &'a ControlOptions) -> Self {
        let tolerance = Tolerance { relative: options.error, absolute: options.absolute_error };
        let pool = Pool::new(tolerance);
        Self { method, options, tolerance, pool, films: Vec::new(), seconds: 0.0, pairs: [0; 2] }
    }

    fn name(&self) -> &'static str {
        match self.method {
            TransportMethod::Tashika => "tashika",
            TransportMethod::Path => "path",
        }
    }

    /// Renders the pixels with one seed; returns false if interrupted.
    fn render(
        &mut self,
        plan: &TransportPlan,
        bench: &Bench<'_>,
        drawn: &Drawn<'_>,
        pixels: &Pixels,
        truth: &Film,
    ) -> Result<bool, Failure> {
        let Drawn { setting, lights, number } = *drawn;
        let options = ControlOptions { seed: self.options.seed.wrapping_add(number), ..*self.options };
        let depth = VplOptions::default().path_depth();
        let integrator: Box<dyn Integrator> = match self.method {
            TransportMethod::Tashika => Box::new(LightTransport::new(setting.tracer, lights, &options)),
            TransportMethod::Path => {
                Box::new(PathTracer::new(setting.tracer, plan.stops_by_itself(&options), depth)?)
            }
        };
        bench.meter.phase(&format!("{}, error {}", self.name(), percent_of_tolerance(options.error)));
        let begun = Instant::now();
        let rendered =
            pixels.render(&setting, integrator.as_ref(), &|p| bench.meter.update(p), bench.cancel)?;
        self.seconds += begun.elapsed().as_secs_f64();
        if !rendered.complete {
            return Ok(false);
        }
        let of_seed = if number > 0 { format!("-{}", number + 1) } else { String::new() };
        let file = plan.folder.file(&format!("{}-{}{of_seed}.exr", self.name(), options.error));
        write_exr(&file, &rendered.film)?;
        self.pool.add(&rendered.film, &converged(truth, &self.tolerance))?;
        for other in &self.films {
            let [one, other] = [&rendered.film, other].map(|film| Named { name: &file, film });
            if let Some(intervals) = compare(one, other, &self.tolerance)?.intervals {
                self.pairs[0] += intervals.claimed_in_both;
                self.pairs[1] += intervals.disjoint;
            }
        }
        self.films.push(rendered.film);
        Ok(true)
    }

    fn row(&self, stage: &Stage, vpls: u64, gather: u32) -> Row {
        let seeds = self.films.len() as u64;
        let subject = Subject {
            scene: stage.scene.name().to_owned(),
            vpls,
            gather,
            // Pixels whose truth is too uncertain are not counted.
            pixels: self.pool.trials() / seeds,
            group: None,
        };
        let told = Told {
            method: self.name(),
            tolerance: self.options.error,
            error: self.options.error,
            confidence: Some(self.options.confidence),
            max_pairs: None,
            seeds,
        };
        Row::new(&subject, told, &self.pool, self.seconds)
    }

    /// Sentence about the share of disjoint pairs of claims; `None` if there are no pairs.
    fn disjoint(&self) -> Option<String> {
        let [pairs, disjoint] = self.pairs;
        (pairs > 0).then(|| {
            format!(
                "{}, error {}: {} of {pairs} pairs of claims of two seeds are disjoint, {}.",
                self.name(),
                percent_of_tolerance(self.options.error),
                disjoint,
                percent_of_share(disjoint as f64 / pairs as f64)
            )
        })
    }
}
