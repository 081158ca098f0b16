//! Time of tracing only the rays and segments of a render again, compared with the whole render and
//! with Embree 4 on the same segments.
//!
//!     cargo bench -p tashika-bench --bench tracing -- --scene SCENE --crop 64 \
//!       --embree libembree4.so.4

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::error::Error;
use std::hint::black_box;
use std::path::PathBuf;

use clap::Parser;
use tashika::accel::Tracer;
use tashika::math::Ray;
use tashika::render::with_threads;
use tashika_bench::embree::{Build, Call, Library4, Segment, Traced};
use tashika_bench::measure::{Timed, Variant, in_turns};
use tashika_bench::recording::{Recording, segments_of};
use tashika_bench::subject::{BenchArgs, Subject};

#[derive(Parser, Debug)]
struct Args {
    #[command(flatten)]
    common: BenchArgs,
    /// Library of Embree 4 to compare with
    #[arg(long)]
    embree: Option<PathBuf>,
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let args = Args::parse();
    with_threads(1, || work(&args))?
}

fn work(args: &Args) -> Result<(), Box<dyn Error + Send + Sync>> {
    let told = |e: Box<dyn Error>| e.to_string();
    let subject = Subject::new(&args.common.subject).map_err(told)?;
    println!("{}\n", subject.describe());
    let recording = Recording::of(&subject.tracer, |tracer| drop(subject.render(tracer)));
    println!(
        "{} segments in {} batches, {} rays\n",
        recording.segments(),
        recording.batches.len(),
        recording.rays.len()
    );

    let (tracer, scene) = (&subject.tracer, subject.tracer.scene());
    compare_levels(tracer, &recording);
    let mut variants = vec![
        Variant::new("render", || drop(black_box(subject.render(tracer)))),
        Variant::new("its segments", || _ = black_box(recording.trace_segments(tracer))),
        Variant::new("its rays", || _ = black_box(recording.trace_rays(tracer))),
    ];
    let timed = in_turns(&mut variants, args.common.rounds);
    table("Whole render", "processor time (s)", &timed, 1.0);
    println!("render / (segments + rays): {:.2}\n", timed[0].seconds / (timed[1].seconds + timed[2].seconds));
    drop(variants);

    let Some(path) = &args.embree else { return Ok(()) };
    let library = Library4::load(path)?;
    let [fast, robust] = [false, true].map(|robust| library.build(scene, Build { robust, threads: 1 }));
    let batches: Vec<Vec<Segment>> = recording.batches.iter().map(segments_of).collect();
    let all = |traced: &Traced<'_>, call| {
        let mut visibility = Vec::new();
        for batch in &batches {
            traced.visibility(batch, call, &mut visibility);
            black_box(&visibility);
        }
    };
    let mut variants = vec![Variant::new("Embree, rtcOccluded1", || all(&fast, Call::Single))];
    variants.push(Variant::new("Embree, rtcOccluded1, robust", || all(&robust, Call::Single)));
    variants.push(Variant::new("Embree, rtcOccluded16", || all(&fast, Call::Packet)));
    variants.push(Variant::new("Embree, rtcOccluded16, coherent", || all(&fast, Call::CoherentPacket)));
    variants
        .push(Variant::new("Embree, rtcOccluded16, coherent, robust", || all(&robust, Call::CoherentPacket)));
    variants.push(Variant::new("tashika", || _ = black_box(recording.trace_segments(tracer))));
    table(
        "Segments",
        "M/s",
        &in_turns(&mut variants, args.common.rounds),
        recording.segments() as f64 * 1e-6,
    );
    drop(variants);

    let rays: Vec<Segment> = recording
        .rays
        .iter()
        .map(|(r, _)| Segment { origin: r.origin, direction: r.direction, t_max: r.t_max })
        .collect();
    let hits = |traced: &Traced<'_>| {
        let mut parameters = Vec::new();
        traced.closest_hits(&rays, &mut parameters);
        black_box(&parameters);
    };
    let mut variants = vec![
        Variant::new("Embree, rtcIntersect1", || hits(&fast)),
        Variant::new("Embree, rtcIntersect1, robust", || hits(&robust)),
        Variant::new("tashika", || _ = black_box(recording.trace_rays(tracer))),
    ];
    table("Closest hits", "M/s", &in_turns(&mut variants, args.common.rounds), rays.len() as f64 * 1e-6);
    drop(variants);

    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    let mut differ = 0;
    for (batch, segments) in recording.batches.iter().zip(&batches) {
        tracer.visibility(batch, &mut ours);
        robust.visibility(segments, Call::Single, &mut theirs);
        differ += ours.iter().zip(&theirs).filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).count();
    }
    println!("{differ} of {} segments are answered otherwise by Embree, robust", recording.segments());
    Ok(())
}

/// Compares the tracer with its scalar twin. Prints the number of visibilities that differ in any
/// bit, and the number of hits that differ.
fn compare_levels(tracer: &Tracer, recording: &Recording) {
    let plain = tracer.plain();
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    let mut differ = 0;
    for batch in &recording.batches {
        tracer.visibility(batch, &mut ours);
        plain.visibility(batch, &mut theirs);
        differ += ours.iter().zip(&theirs).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
    }
    let hits = |tracer: &Tracer, (ray, key): &(Ray, u64)| tracer.closest_hit(ray, *key);
    let rays = recording.rays.iter().filter(|ray| hits(tracer, ray) != hits(&plain, ray)).count();
    let (segments, all) = (recording.segments(), recording.rays.len());
    println!("{differ} of {segments} segments and {rays} of {all} rays differ from the scalar twin's\n");
}

fn table(title: &str, unit: &str, timed: &[Timed], work: f64) {
    println!("| {title} | {unit} | relative speed | range |\n|---|---|---|---|");
    for t in timed {
        let value = if unit == "M/s" { work / t.seconds } else { t.seconds };
        println!("| {} | {value:.3} | {:.2} | {:.2}–{:.2} |", t.name, t.speed, t.range[0], t.range[1]);
    }
    println!();
}
