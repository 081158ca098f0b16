//! Times of the parts of a pixel, each alone: gather points, their tree, bounds of pairs, lists of
//! terms, and the pixel as a whole.
//!
//!     cargo bench -p tashika-bench --bench parts -- --scene SCENE --points 16
//!
//! Each part is run for the pixels of the window, with the lights of the subject.

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::error::Error;
use std::hint::black_box;

use clap::Parser;
use tashika::bounds::{UpperAnalytic, UpperScattering};
use tashika::contribution::ContributionKernel;
use tashika::cut::{Clusters, Rank, Refinement, RefinementMemory, RefinementOptions, gather_tree};
use tashika::gather::{GatherPoint, PixelSum};
use tashika::render::with_threads;
use tashika::tree::{GatherTree, LightTree};
use tashika::vpl::VplSet;
use tashika_bench::measure::{Variant, in_turns};
use tashika_bench::subject::{BenchArgs, Subject};

/// Number of splits of each cut whose bounds are measured.
const SPLITS: usize = 1000;
/// Number of lights in each list of terms that is measured.
const LISTED: usize = 512;

#[derive(Parser, Debug)]
struct Args {
    #[command(flatten)]
    common: BenchArgs,
}

/// Work that is done for every pixel.
struct Part<'a> {
    name: &'static str,
    /// Unit of work in which `per_pixel` is counted.
    unit: &'static str,
    /// Mean number of units in a pixel.
    per_pixel: f64,
    work: Box<dyn Fn() + 'a>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    let subject = Subject::new(&args.common.subject)?;
    println!("{}\n", subject.describe());
    let (set, tree) = subject.set().ok_or("parts are those of a sum: --truth vpl")?;
    with_threads(1, || measure(&subject, set, tree, args.common.rounds))?;
    Ok(())
}

fn measure(subject: &Subject, set: &VplSet, tree: &LightTree, rounds: u32) {
    let view = subject.setting(&subject.tracer).view;
    let gather = || -> Vec<PixelSum> {
        subject.window().pixels().map(|(x, y)| view.pixel(&subject.tracer, [x, y])).collect()
    };
    // Pixels without gather points are skipped.
    let pixels: Vec<Vec<GatherPoint>> =
        gather().into_iter().map(|pixel| pixel.points).filter(|points| !points.is_empty()).collect();
    let trees: Vec<GatherTree<UpperScattering<UpperAnalytic>>> =
        pixels.iter().map(|points| gather_tree(points)).collect();
    let contribution = ContributionKernel::new(set.provenance().clamp_distance);
    let clusters = |points| Clusters { lights: tree, points, contribution };
    let lights = tree.lights();
    let listed = LISTED.min(lights.len());
    let refine = |tabulated: u64| {
        let mut memory = RefinementMemory::default();
        let mut splits = 0;
        for points in &trees {
            let options = RefinementOptions { rank: Rank::Upper, finest: 2, tabulated };
            let refinement = Refinement::new(clusters(points), options, &mut memory);
            let Some(mut refinement) = refinement else { continue };
            splits += (0..SPLITS).map_while(|_| refinement.split_next()).count();
        }
        splits
    };
    let per_pixel = |count: usize| count as f64 / pixels.len() as f64;
    let points: usize = pixels.iter().map(Vec::len).sum();
    let parts = [
        Part {
            name: "whole pixels",
            unit: "pixel",
            per_pixel: 1.0,
            work: Box::new(|| drop(black_box(subject.render(&subject.tracer)))),
        },
        Part {
            name: "gather points",
            unit: "point",
            per_pixel: per_pixel(points),
            work: Box::new(|| drop(black_box(gather()))),
        },
        Part {
            name: "trees over them",
            unit: "point",
            per_pixel: per_pixel(points),
            work: Box::new(|| {
                for points in &pixels {
                    black_box(gather_tree::<UpperAnalytic>(points));
                }
            }),
        },
        Part {
            name: "splits of pairs by their bounds",
            unit: "split",
            per_pixel: per_pixel(refine(0)),
            work: Box::new(|| _ = black_box(refine(0))),
        },
        Part {
            name: "splits of pairs, small ones tabulated",
            unit: "split",
            per_pixel: per_pixel(refine(1024)),
            work: Box::new(|| _ = black_box(refine(1024))),
        },
        Part {
            name: "lists of terms",
            unit: "term",
            per_pixel: per_pixel(points * listed),
            work: Box::new(|| {
                let mut luminances = Vec::new();
                for (number, points) in pixels.iter().enumerate() {
                    let first = number * LISTED % (lights.len() - listed + 1);
                    luminances.clear();
                    contribution.list(points, lights, first..first + listed, &mut luminances);
                    black_box(&luminances);
                }
            }),
        },
    ];
    let mut variants: Vec<Variant<'_>> =
        parts.iter().map(|part| Variant::new(part.name, || (part.work)())).collect();
    println!("| part | unit | ns | of a pixel | share of a pixel | range |\n|---|---|---:|---:|---:|---|");
    for (timed, part) in in_turns(&mut variants, rounds).iter().zip(&parts) {
        let ns = timed.seconds * 1e9 / pixels.len() as f64 / part.per_pixel;
        let [most, least] = timed.range.map(|speed| 1.0 / speed);
        println!(
            "| {} | {} | {ns:.1} | {:.0} | {:.3} | {least:.3}–{most:.3} |",
            part.name,
            part.unit,
            part.per_pixel,
            1.0 / timed.speed
        );
    }
}
