//! Implementation of a new method, which samples the terms of the many-light sum uniformly. It is
//! compared with the whole sum and with a published method.
//!
//!     cargo run --release --example own_method

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::path::Path;

use tashika::Renderer;
use tashika::accel::SegmentBatch;
use tashika::color::RgbSum;
use tashika::contribution::ContributionKernel;
use tashika::error::Result;
use tashika::film::{Claim, Film, Metadata, PixelRecord, Stop, Window};
use tashika::integrator::{Estimates, Integrator, Setting, SumMethod};
use tashika::report::{Named, Tolerance, compare};
use tashika::rng::{Purpose, Stream};
use tashika::scene::builtin;
use tashika::stats::Moments;
use tashika::vpl::VplSet;

/// Method that draws `terms` terms of a pixel's sum, each with the same probability.
///
/// ```text
/// L̂ = B + N/n Σ_k w_j M_ji G_ji V_ji I_i       N terms, of which n are drawn
/// ```
struct Evenly<'a> {
    lights: &'a VplSet,
    terms: u64,
}

impl Integrator for Evenly<'_> {
    fn name(&self) -> &'static str {
        "evenly"
    }

    fn describe(&self, _metadata: &mut Metadata) {}

    fn begin<'v>(&'v self, setting: Setting<'v>) -> Box<dyn Estimates + 'v> {
        Box::new(move |tile: &Window| tile.pixels().map(|(x, y)| self.pixel(&setting, [x, y])).collect())
    }
}

impl Evenly<'_> {
    fn pixel(&self, setting: &Setting<'_>, [x, y]: [u32; 2]) -> PixelRecord {
        let pixel = setting.view.pixel(setting.tracer, [x, y]);
        let contribution =
            ContributionKernel::new(self.lights.provenance().clamp_distance).within(setting.tracer.scene());
        // Random numbers depend on the pixel alone, so that threads and tiles do not change the
        // image.
        let index = u64::from(y) << 32 | u64::from(x);
        let mut stream = Stream::new(setting.view.seed, Purpose::Test, index);
        let (lights, points) = (self.lights.lights(), &pixel.points);
        let all = lights.len() as u64 * points.len() as u64;
        let drawn: Vec<_> = (0..self.terms.min(all))
            .map(|_| {
                (
                    &lights[stream.below(lights.len() as u64) as usize],
                    &points[stream.below(points.len() as u64) as usize],
                )
            })
            .collect();
        let mut batch = SegmentBatch::default();
        for (light, point) in &drawn {
            batch.push_fan(light.apex(), [point.position]);
        }
        let mut visibility = Vec::new();
        setting.tracer.visibility(&batch, &mut visibility);
        let (mut sum, mut moments) = (RgbSum::default(), Moments::default());
        for ((light, point), visible) in drawn.iter().zip(visibility) {
            let term = contribution.unoccluded(point, light) * (visible * all as f32);
            sum.add(term);
            moments.push(f64::from(term.luminance()));
        }
        let mut sum = sum.scaled(1.0 / drawn.len().max(1) as f64);
        sum.add(pixel.background);
        PixelRecord {
            radiance: sum.total(),
            standard_error: moments.standard_error() as f32,
            claim: Claim::None,
            stop: Stop::Complete,
            pairs: drawn.len() as u64,
            rays: drawn.len() as u64,
            ..pixel.features.into()
        }
    }
}

/// Share of the pixels that are within 10 % of the reference.
fn within(film: &Film, reference: &Film) -> Result<f64> {
    let [image, reference] = [film, reference].map(|film| Named { name: Path::new("film"), film });
    let found = compare(image, reference, &Tolerance { relative: 0.1, absolute: 0.0 })?;
    Ok(found.within as f64 / found.pixels as f64)
}

fn main() -> Result<()> {
    let renderer = Renderer::new(builtin::tiny()).size([48, 32]).vpls(5000).gather_points(4);
    let whole = renderer.clone().method(SumMethod::Exact).prepare()?;
    let lights = whole.job().light_set()?;
    let reference = whole.render()?;

    let evenly = Evenly { lights: lights.set(), terms: 400 };
    let ours = whole.render_with(&evenly)?;
    let published = renderer.method(SumMethod::Iwasaki2019).error(0.1).lights(lights.clone()).render()?;
    for (name, rendered) in [("evenly", &ours), ("iwasaki2019", &published)] {
        let rays = rendered.totals.rays as f64 / rendered.totals.tally.rendered() as f64;
        let share = 100.0 * within(&rendered.film, &reference.film)?;
        println!("{name}: {rays:.0} rays a pixel, {share:.1} % of the pixels within 10 %");
    }
    Ok(())
}
