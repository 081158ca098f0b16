//! Certified intervals: a theorem guarantees that they cover the many-light sum
//! (docs/CERTIFICATE.md). Each is compared with the whole sum.
//!
//!     cargo run --release --example certificate

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use tashika::Renderer;
use tashika::error::Result;
use tashika::film::{Claim, RenderFilm};
use tashika::integrator::{Promise, SumMethod};
use tashika::scene::builtin;

fn main() -> Result<()> {
    let renderer = Renderer::new(builtin::tiny()).size([32, 32]).vpls(20_000).gather_points(4);
    let certified = renderer.clone().claim(Promise::Certified).error(0.05).confidence(0.99).render()?;
    let whole = renderer.method(SumMethod::Exact).render()?;

    let [estimates, truth] = [&certified, &whole].map(|rendered| RenderFilm::of(&rendered.film));
    let (mut claims, mut broken) = (0_u32, 0_u32);
    for (x, y) in certified.film.window().pixels() {
        let estimate = estimates.at(x, y);
        if estimate.claim == Claim::Certified {
            let distance = estimate.radiance.luminance() - truth.at(x, y).radiance.luminance();
            claims += 1;
            broken += u32::from(distance.abs() > estimate.half_width);
        }
    }
    let share = certified.totals.rays as f64 / whole.totals.rays as f64;
    println!("{claims} pixels are certified at 99 %, {broken} of them are not within their interval");
    println!("{:.0} % of the rays of the whole sum", 100.0 * share);
    assert!(
        claims > 0 && f64::from(broken) <= 0.01 * f64::from(claims),
        "the theorem allows one in a hundred"
    );
    Ok(())
}
