//! Speed and memory of the renderer compared with goals. Each goal is a row; all rows are measured
//! in one run.
//!
//!     cargo bench -p tashika-bench --bench ladder -- --scene SCENE --embree libembree4.so.4
//!
//! The built-in room is always measured; `--scene` adds another scene. Rows that need Embree are
//! omitted without `--embree`, and the row of Mitsuba without `--mitsuba` (the head of
//! `scripts/mitsuba_beside.py` lists the scenes that it takes). Ratios are formed within each
//! round; a row prints the median over the rounds.
//!
//! Choose the window with `--crop` and the rows with `--only`. Some work is done once for each cell
//! of 16x16 pixels. In a window of only a few cells its share of the time is too large. In large
//! windows, whole sums of many terms take long.

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use tashika::accel::Tracer;
use tashika::integrator::{Promise, SumMethod, Truth};
use tashika::render::with_threads;
use tashika_bench::embree::{Build, Call, Library4, Segment, Traced};
use tashika_bench::measure::{Timed, Variant, cpu_seconds, in_turns, median};
use tashika_bench::recording::{Recording, segments_of};
use tashika_bench::subject::{BenchArgs, Subject, SubjectArgs, scene};

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

#[derive(Parser, Debug)]
struct Args {
    #[command(flatten)]
    common: BenchArgs,
    /// Library of Embree 4 to compare with
    #[arg(long)]
    embree: Option<PathBuf>,
    /// Scene for Mitsuba 3 to compare with, run by `--python`
    #[arg(long)]
    mitsuba: Option<PathBuf>,
    /// Python interpreter that has Mitsuba
    #[arg(long, default_value = "python3")]
    python: PathBuf,
    /// Measure only rows whose names contain this text
    #[arg(long, default_value = "")]
    only: String,
    /// Render the scene and print the peak of memory, for the row of that name
    #[arg(long, hide = true)]
    tell_peak: bool,
}

/// Row of the table: a goal and its measurement.
struct Rung {
    name: &'static str,
    goal: &'static str,
    /// Returns the measured values as text; `None` if a library or scene that it needs was not
    /// named.
    measure: fn(&Args, &SubjectArgs) -> Result<Option<String>>,
}

const RUNGS: [Rung; 11] = [
    Rung {
        name: "render / (its rays and segments alone), default method",
        goal: "<= 2.0",
        measure: rays_alone,
    },
    Rung {
        name: "occlusion as rendered, of Embree's single ray / of its best packets",
        goal: ">= 1.3 / >= 1.0",
        measure: occlusion,
    },
    Rung {
        name: "time a pixel, sum over 10^6 VPLs x 128 points against 10^4 x 16",
        goal: "<= 1.5 x",
        measure: large_sums,
    },
    Rung { name: "rays of a sum over 10^7 VPLs against 10^5", goal: "<= 1.5 x", measure: many_lights },
    Rung { name: "1 to 256 gather points, rays / time of a sum", goal: "<= 1.5 x", measure: many_points },
    Rung {
        name: "whole sum against ours, 20,000 / 160,000 / 800,000 terms a pixel",
        goal: ">= 3 / >= 10 / >= 40 x",
        measure: whole_sums,
    },
    Rung { name: "certified rays against those of iwasaki2019", goal: "<= 1", measure: certified },
    Rung { name: "1 to 2 threads", goal: ">= 1.95", measure: threads },
    Rung {
        name: "Mitsuba's time until as many pixels are right, over ours",
        goal: ">= 4 x",
        measure: mitsuba,
    },
    Rung { name: "tree for rays, of Embree's build", goal: "<= 1.5 x", measure: tree_for_rays },
    Rung { name: "peak of memory", goal: "<= 250 MiB", measure: peak },
];

fn main() -> Result<()> {
    let args = Args::parse();
    if args.tell_peak {
        let subject = subject(&args.common.subject)?;
        drop(black_box(subject.render(&subject.tracer)));
        println!("{}", peak_of_this_process()?);
        return Ok(());
    }
    let mut subjects = vec![SubjectArgs { scene: None, ..args.common.subject.clone() }];
    subjects.extend(args.common.subject.scene.is_some().then(|| args.common.subject.clone()));
    println!("| | scene | measured | goal |\n|---|---|---|---|");
    for Rung { name, goal, measure } in RUNGS.iter().filter(|rung| rung.name.contains(&args.only)) {
        for subject in &subjects {
            let named = subject
                .scene
                .as_deref()
                .and_then(Path::file_stem)
                .map_or("room".into(), |s| s.to_string_lossy());
            if let Some(measured) = measure(&args, subject)? {
                println!("| {name} | {named} | {measured} | {goal} |");
            }
        }
    }
    Ok(())
}

fn subject(args: &SubjectArgs) -> Result<Subject> {
    Ok(Subject::new(args).map_err(|e| e.to_string())?)
}

/// Sum over one set of `vpls` VPLs at `points` gather points a pixel, by `method`.
fn sum(of: &SubjectArgs, method: SumMethod, vpls: u64, points: u64) -> Result<Subject> {
    let [vpls, points] = [vpls, points].map(Some);
    subject(&SubjectArgs { method, truth: Some(Truth::Vpl), vpls, points, ..of.clone() })
}

const OURS: SumMethod = SumMethod::Tashika(Promise::Calibrated);

fn whole_render(of: &Subject) {
    drop(black_box(of.render(&of.tracer)));
}

/// Times whole renders of `subjects` in turns on one thread.
fn renders(args: &Args, subjects: &[&Subject]) -> Result<Vec<Timed>> {
    Ok(with_threads(1, || {
        let variants = subjects.iter().map(|&of| Variant::new("", || whole_render(of)));
        in_turns(&mut variants.collect::<Vec<_>>(), args.common.rounds)
    })?)
}

fn rays(of: &Subject) -> f64 {
    of.render(&of.tracer).totals.rays as f64
}

fn ratio(timed: &Timed) -> String {
    format!("{:.2} ({:.2}-{:.2})", timed.speed, timed.range[0], timed.range[1])
}

fn rays_alone(args: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let of = subject(of)?;
    let timed = with_threads(1, || {
        let recording = Recording::of(&of.tracer, |tracer| drop(of.render(tracer)));
        in_turns(
            &mut [
                Variant::new("alone", || {
                    black_box(recording.trace_segments(&of.tracer));
                    black_box(recording.trace_rays(&of.tracer));
                }),
                Variant::new("render", || whole_render(&of)),
            ],
            args.common.rounds,
        )
    })?;
    let [most, least] = timed[1].range.map(|speed| 1.0 / speed);
    Ok(Some(format!("{:.2} ({least:.2}-{most:.2})", 1.0 / timed[1].speed)))
}

fn occlusion(args: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let Some(path) = &args.embree else { return Ok(None) };
    let (of, library) = (subject(of)?, Library4::load(path)?);
    let embree = library.build(of.tracer.scene(), Build { robust: false, threads: 1 });
    let timed = with_threads(1, || {
        let recording = Recording::of(&of.tracer, |tracer| drop(of.render(tracer)));
        let batches: Vec<Vec<Segment>> = recording.batches.iter().map(segments_of).collect();
        let all = |embree: &Traced<'_>, call| {
            let mut visibility = Vec::new();
            for batch in &batches {
                embree.visibility(batch, call, &mut visibility);
                black_box(&visibility);
            }
        };
        in_turns(
            &mut [
                Variant::new("ours", || _ = black_box(recording.trace_segments(&of.tracer))),
                Variant::new("single", || all(&embree, Call::Single)),
                Variant::new("packets", || all(&embree, Call::Packet)),
                Variant::new("coherent packets", || all(&embree, Call::CoherentPacket)),
            ],
            args.common.rounds,
        )
    })?;
    let of_ours = |timed: &Timed| 1.0 / timed.speed;
    let packets = of_ours(&timed[2]).min(of_ours(&timed[3]));
    Ok(Some(format!("{:.2} / {packets:.2}", of_ours(&timed[1]))))
}

fn large_sums(args: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let (large, small) = (sum(of, OURS, 1_000_000, 128)?, sum(of, OURS, 10_000, 16)?);
    Ok(Some(ratio(&renders(args, &[&large, &small])?[1])))
}

fn many_lights(_: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let points = 64;
    let [many, few] = [10_000_000, 100_000].map(|vpls| sum(of, OURS, vpls, points).map(|of| rays(&of)));
    Ok(Some(format!("{:.2}", many? / few?)))
}

fn many_points(args: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let vpls = 100_000;
    let (many, one) = (sum(of, OURS, vpls, 256)?, sum(of, OURS, vpls, 1)?);
    let times = renders(args, &[&many, &one])?;
    Ok(Some(format!("{:.2} / {}", rays(&many) / rays(&one), ratio(&times[1]))))
}

fn whole_sums(args: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let speed = |(vpls, points): (u64, u64)| -> Result<String> {
        let [whole, ours] = [SumMethod::Exact, OURS].map(|method| sum(of, method, vpls, points));
        Ok(ratio(&renders(args, &[&whole?, &ours?])?[1]))
    };
    let speeds: Result<Vec<String>> =
        [(5_000, 4), (10_000, 16), (50_000, 16)].map(speed).into_iter().collect();
    Ok(Some(speeds?.join(" / ")))
}

fn certified(_: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let method = |method| sum(of, method, 10_000, 16).map(|of| rays(&of));
    let (ours, published) =
        (method(SumMethod::Tashika(Promise::Certified))?, method(SumMethod::Iwasaki2019)?);
    Ok(Some(format!("{:.2}", ours / published)))
}

fn threads(args: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let of = subject(of)?;
    let seconds = |threads| {
        let begun = Instant::now();
        with_threads(threads, || whole_render(&of)).map(|()| begun.elapsed().as_secs_f64())
    };
    seconds(2)?;
    let mut speeds = Vec::new();
    for _ in 0..args.common.rounds {
        speeds.push(seconds(1)? / seconds(2)?);
    }
    let speed = median(&mut speeds);
    Ok(Some(format!("{speed:.2} ({:.2}-{:.2})", speeds[0], speeds[speeds.len() - 1])))
}

/// Renders the scene and measures the processor time of the render. The script then reads the
/// image, and prints the time that Mitsuba takes to bring the same number of pixels within the
/// tolerance.
fn mitsuba(args: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let (Some(file), None) = (&args.mitsuba, &of.scene) else { return Ok(None) };
    let error = of.error.unwrap_or(0.02);
    let of = SubjectArgs {
        scene: Some(file.clone()),
        size: [64; 2],
        crop: None,
        error: Some(error),
        ..of.clone()
    };
    let of = subject(&of)?;
    let (rendered, seconds) = with_threads(1, || {
        let begun = cpu_seconds();
        let rendered = of.render(&of.tracer);
        (rendered, cpu_seconds() - begun)
    })?;
    let folder = std::env::temp_dir().join(format!("tashika-ladder-{}", std::process::id()));
    fs::create_dir_all(&folder)?;
    let ours = folder.join("ours.exr");
    tashika::io::write_exr(&ours, &rendered.film)?;
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/mitsuba_beside.py");
    let told = Command::new(&args.python)
        .arg(script)
        .arg(file)
        .arg(&ours)
        .args(["--error", &error.to_string()])
        .output();
    fs::remove_dir_all(&folder)?;
    let told = String::from_utf8(told?.stdout)?;
    // The last row of the script's table: samples, seconds, share of right pixels.
    let theirs =
        told.lines().last().and_then(|row| row.split('|').nth(2)).and_then(|s| s.trim().parse::<f64>().ok());
    let theirs =
        theirs.ok_or("the script of Mitsuba told no time: it needs the packages that its head names")?;
    Ok(Some(format!("{:.2} ({theirs:.1} s : {seconds:.1} s)", theirs / seconds)))
}

fn tree_for_rays(args: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let Some(path) = &args.embree else { return Ok(None) };
    let (scene, library) = (scene(of).map_err(|e| e.to_string())?, Library4::load(path)?);
    let threads = std::thread::available_parallelism()?.get();
    let seconds = |work: &mut dyn FnMut()| {
        let begun = Instant::now();
        work();
        begun.elapsed().as_secs_f64()
    };
    let ratios = with_threads(threads, || {
        let mut ratios = Vec::new();
        for _ in 0..args.common.rounds {
            let ours = seconds(&mut || drop(Tracer::new(Arc::clone(&scene))));
            let build = Build { robust: false, threads: threads as u32 };
            ratios.push(ours / seconds(&mut || drop(library.build(&scene, build))));
        }
        ratios
    });
    let mut ratios = ratios?;
    let ratio = median(&mut ratios);
    Ok(Some(format!("{ratio:.2} ({:.2}-{:.2})", ratios[0], ratios[ratios.len() - 1])))
}

/// Peak memory of a separate process that only makes the default render.
fn peak(_: &Args, of: &SubjectArgs) -> Result<Option<String>> {
    let mut process = Command::new(std::env::current_exe()?);
    process.arg("--tell-peak");
    if let Some(scene) = &of.scene {
        process.arg("--scene").arg(scene);
    }
    let [width, height] = of.size;
    process.args(["--size", &format!("{width}x{height}")]);
    if let Some(crop) = of.crop {
        process.args(["--crop", &crop.to_string()]);
    }
    let output = process.output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    Ok(Some(format!("{} MiB", String::from_utf8(output.stdout)?.trim())))
}

/// Peak resident memory of this process (MiB), from Linux's `VmHWM`.
fn peak_of_this_process() -> Result<u64> {
    let status = fs::read_to_string("/proc/self/status")?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = peak.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    Ok(kilobytes.ok_or("the system tells no peak of memory")? >> 10)
}
