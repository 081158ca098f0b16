//! Time of a render by part of the library, and the functions that take the most time.
//!
//!     cargo bench -p tashika-bench --bench profile -- --scene SCENE --crop 32
//!
//! The call stack is sampled up to a thousand times a second of processor time. A sample is
//! attributed to the innermost function of the library, so that calls to other libraries and to the
//! system are attributed to their caller. An inlined function is treated like any other, except
//! operations on vectors (`math::simd`), which are attributed to their caller.

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::collections::HashMap;
use std::error::Error;
use std::hint::black_box;

use clap::Parser;
use pprof::{ProfilerGuardBuilder, Report, Symbol};
use tashika::render::with_threads;
use tashika_bench::subject::{BenchArgs, Subject};

/// Samples a second of processor time, at most.
const FREQUENCY: i32 = 1000;
/// Number of functions in the printed table.
const FUNCTIONS: usize = 25;
/// Text before and after the suffix of a crate's name in the path of its sources.
const SOURCES: [&str; 2] = ["crates/tashika", "/src/"];
/// Suffix of this crate, whose functions are not counted.
const OWN: &str = "-bench";
/// Suffixes of the crates that are one module, which has the name of the crate.
const ONE_MODULE: [&str; 2] = ["-report", "-stats"];
/// Module whose functions count for their callers.
const VECTORS: &str = "math::simd";

#[derive(Parser, Debug)]
struct Args {
    #[command(flatten)]
    common: BenchArgs,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    let subject = Subject::new(&args.common.subject)?;
    println!("{}\n", subject.describe());
    let guard = ProfilerGuardBuilder::default()
        .frequency(FREQUENCY)
        .blocklist(&["libc", "libgcc", "pthread", "vdso"])
        .build()?;
    with_threads(1, || {
        for _ in 0..args.common.rounds {
            drop(black_box(subject.render(&subject.tracer)));
        }
    })?;
    let report = guard.report().build()?;
    tell(&report);
    Ok(())
}

/// Prints the shares of modules and functions.
fn tell(report: &Report) {
    let mut all = 0;
    let (mut modules, mut functions) = (HashMap::new(), HashMap::new());
    for (frames, &count) in &report.data {
        all += count;
        let symbols = || frames.frames.iter().flatten();
        let (module, function) = symbols()
            .find_map(|symbol| Some((module(symbol)?, symbol.name())))
            .unwrap_or_else(|| ("elsewhere".to_owned(), String::new()));
        let function = function.split('<').next().unwrap_or_default();
        *functions.entry(format!("{module}: {function}")).or_insert(0) += count;
        *modules.entry(module).or_insert(0) += count;
    }
    println!("{all} samples\n");
    table("Module", modules, all, usize::MAX);
    table("Function", functions, all, FUNCTIONS);
}

/// Module of the library that contains a function's source, such as `cut::listed`; `None` if the
/// source is not the library's.
fn module(symbol: &Symbol) -> Option<String> {
    let path = symbol.filename.as_ref()?.to_str()?;
    let (_, named) = path.rsplit_once(SOURCES[0])?;
    let (name, within) = named.split_once(SOURCES[1])?;
    let within = within.trim_end_matches(".rs").trim_end_matches("/mod").replace('/', "::");
    let module = if ONE_MODULE.contains(&name) { format!("{}::{within}", &name[1..]) } else { within };
    (name != OWN && !module.starts_with(VECTORS)).then_some(module)
}

fn table(title: &str, counts: HashMap<String, isize>, all: isize, most: usize) {
    let mut rows: Vec<(String, isize)> = counts.into_iter().collect();
    rows.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    println!("| {title} | share |\n|---|---:|");
    for (name, count) in rows.into_iter().take(most) {
        println!("| {name} | {:.1} % |", 100.0 * count as f64 / all as f64);
    }
    println!();
}
