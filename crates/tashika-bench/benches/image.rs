//! Time of a whole render on one thread and on several.
//!
//!     cargo bench -p tashika-bench --bench image -- --scene SCENE --crop 64 --threads 2

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::error::Error;
use std::time::Instant;

use clap::Parser;
use tashika::render::with_threads;
use tashika_bench::measure::median;
use tashika_bench::subject::{BenchArgs, Subject};

#[derive(Parser, Debug)]
struct Args {
    #[command(flatten)]
    common: BenchArgs,
    /// Number of threads to compare with one
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    let subject = Subject::new(&args.common.subject)?;
    let once = |threads: usize| {
        let begun = Instant::now();
        let rendered = with_threads(threads, || subject.render(&subject.tracer));
        rendered.map(|rendered| (begun.elapsed().as_secs_f64(), rendered.totals.rays))
    };
    let (_, rays) = once(1)?;
    let pixels = subject.window().area();
    println!("{}: {} rays a pixel", subject.describe(), rays / pixels);
    let mut speeds = Vec::new();
    for _ in 0..args.common.rounds {
        let (one, many) = (once(1)?.0, once(args.threads)?.0);
        println!("{one:.2} s on one thread, {many:.2} s on {}", args.threads);
        speeds.push(one / many);
    }
    println!("1 to {} threads: {:.2} times as fast", args.threads, median(&mut speeds));
    Ok(())
}
