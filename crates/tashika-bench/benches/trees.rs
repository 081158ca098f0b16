//! Time until the first ray: reading the scene, building the tree for rays (beside Embree's),
//! tracing VPLs and building the light tree.
//!
//!     cargo bench -p tashika-bench --bench trees -- --scene SCENE --vpls 1000000 \
//!       --embree libembree4.so.4
//!
//! Times are elapsed times on `--threads` threads. For trees for rays, the processor time of all
//! threads is also printed; on a busy machine it is the better measure.

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use tashika::accel::Tracer;
use tashika::render::with_threads;
use tashika::tree::{LightTree, LightTreeBuilder};
use tashika::vpl::{VplOptions, VplSet};
use tashika_bench::embree::{Build, Library4};
use tashika_bench::measure::{cpu_seconds_of_all, median};
use tashika_bench::subject::{BenchArgs, scene};

#[derive(Parser, Debug)]
struct Args {
    #[command(flatten)]
    common: BenchArgs,
    /// Library of Embree 4 to compare with
    #[arg(long)]
    embree: Option<PathBuf>,
    /// Number of threads that build and trace
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let args = Args::parse();
    with_threads(args.threads, || work(&args))?
}

fn work(args: &Args) -> Result<(), Box<dyn Error + Send + Sync>> {
    let (loaded, loading) = timed(|| scene(&args.common.subject).map_err(|e| e.to_string()));
    let loaded = loaded?;
    println!("{}, {} threads\n\n| step | s |\n|---|---|", loaded.name(), args.threads);
    println!("| reading | {loading:.2} |");

    let library = args.embree.as_deref().map(Library4::load).transpose()?;
    let (mut ours, mut theirs) = (Times::default(), Times::default());
    for _ in 0..args.common.rounds {
        ours.time(|| drop(Tracer::new(Arc::clone(&loaded))));
        if let Some(library) = &library {
            let build = Build { robust: false, threads: args.threads as u32 };
            theirs.time(|| drop(library.build(&loaded, build)));
        }
    }
    let tree = ours.medians();
    println!("| tree for rays | {:.3} |\n| its processor time | {:.3} |", tree[0], tree[1]);
    if library.is_some() {
        let embree = theirs.medians();
        println!(
            "| Embree's, medium quality | {:.3} |\n| its processor time | {:.3} |",
            embree[0], embree[1]
        );
        let ratios = [tree[0] / embree[0], tree[1] / embree[1]];
        println!("| ours / Embree's, processor time | {:.2}, {:.2} |", ratios[0], ratios[1]);
    }

    let tracer = Tracer::new(Arc::clone(&loaded));
    let size = tracer.size();
    let count = args.common.subject.vpls.unwrap_or(VplOptions::default().count);
    let options = VplOptions { count, ..VplOptions::default() };
    let (lights, tracing) = timed(|| VplSet::trace(&tracer, &options));
    let lights = lights?;
    let mut seconds = Vec::new();
    let mut bytes = 0;
    for _ in 0..args.common.rounds {
        let (tree, taken) = timed(|| LightTree::build(&lights, LightTreeBuilder::default()));
        seconds.push(taken);
        bytes = tree.bytes();
    }
    let (count, seconds) = (lights.len() as f64, median(&mut seconds));
    println!("| {count} VPLs | {tracing:.2} |\n| light tree | {seconds:.2} |");
    println!("| light tree, per million VPLs | {:.2} |\n", seconds / count * 1e6);
    println!(
        "{:.0} bytes a VPL in the light tree, {} MB in the trees for rays",
        bytes as f64 / count,
        size.bytes >> 20
    );
    Ok(())
}

/// Elapsed and processor time (s) of each repetition.
#[derive(Default)]
struct Times {
    elapsed: Vec<f64>,
    processor: Vec<f64>,
}

impl Times {
    fn time(&mut self, work: impl FnOnce()) {
        let begun = cpu_seconds_of_all();
        self.elapsed.push(timed(work).1);
        self.processor.push(cpu_seconds_of_all() - begun);
    }

    /// Medians of the elapsed and of the processor time (s).
    fn medians(&mut self) -> [f64; 2] {
        [median(&mut self.elapsed), median(&mut self.processor)]
    }
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let begun = Instant::now();
    let result = work();
    (result, begun.elapsed().as_secs_f64())
}
