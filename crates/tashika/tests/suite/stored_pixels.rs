//! Pixels of every method, compared with the values in `stored_pixels.txt`: a value changes only by
//! a decision.
//!
//! The table has the shortest decimals that read back to the same bits, so that equal text means
//! equal bits. One table is valid for debug and release builds, and for all instruction sets. If
//! values are meant to change, this command rewrites the table:
//!
//!     TASHIKA_UPDATE_GOLDEN=pixels cargo test --release -p tashika --test suite stored_pixels
//!
//! Such a change belongs under *Value changes* in CHANGELOG.md.

use std::fmt::Write as _;
use std::{env, fs};

use tashika::accel::Tracer;
use tashika::color::{Controlled, Rgb};
use tashika::film::Window;
use tashika::gather::View;
use tashika::integrator::{
    ControlOptions, GuidedLights, Ingredient, Integrator, LightTransport, PathStop, PathTracer, Setting,
    SumMethod, Truth,
};
use tashika::math::Vec3;
use tashika::scene::{Emitter, Scene, builtin};
use tashika::tree::LightSet;
use tashika::vpl::{VplOptions, VplSet};

use crate::cases::{add_ceiling_lamp, diffuse_room, view};

const TABLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/suite/stored_pixels.txt");
const SIZE: [u32; 2] = [6, 4];
const PIXELS: [[u32; 2]; 6] = [[1, 1], [2, 1], [4, 1], [1, 2], [3, 3], [4, 2]];
const VPLS: u64 = 1500;

/// A scene with its settings, rendered by every method.
struct Stored {
    name: &'static str,
    tracer: Tracer,
    points: u32,
    options: ControlOptions,
}

/// The built-in room, whose surfaces are of several kinds, and a diffuse room. In the diffuse room
/// the error of all channels is controlled, and some pixels reach the limit of pairs.
fn stored() -> [Stored; 2] {
    let mut diffuse = diffuse_room();
    add_ceiling_lamp(&mut diffuse, 5.0);
    let position = Vec3::new(-0.5, 1.6, 0.5);
    diffuse.add_emitter(Emitter::Point { position, intensity: Rgb::new(0.5, 0.4, 0.3) }).unwrap();
    let options = ControlOptions { error: 0.05, ..ControlOptions::default() };
    let controlled = Controlled::Channels;
    [
        Stored { name: "tiny", tracer: Tracer::new(builtin::tiny().into()), points: 5, options },
        Stored {
            name: "diffuse",
            tracer: Tracer::new(diffuse.build().unwrap().into()),
            points: 2,
            options: ControlOptions { error: 0.03, controlled, max_pairs: Some(900), ..options },
        },
    ]
}

impl Stored {
    fn view<'a>(&self, scene: &'a Scene) -> View<'a> {
        view(scene, SIZE, self.points, 5)
    }

    /// Lines of the table for one method.
    fn lines(&self, method: &str, integrator: &dyn Integrator, table: &mut String) {
        let scene = self.tracer.scene().clone();
        let setting = Setting { tracer: &self.tracer, view: self.view(&scene) };
        let of_view = integrator.begin(setting);
        for [x, y] in PIXELS {
            let pixel = Window { x, y, width: 1, height: 1 };
            let estimate = &of_view.tile(&pixel)[0];
            let (Rgb { r, g, b }, half_width) = (estimate.radiance, estimate.half_width);
            let counts = (estimate.stop, estimate.pairs, estimate.rays);
            writeln!(
                table,
                "{} | {method} | {x} {y} | {r:?} {g:?} {b:?} | {half_width:?} | {:?} | {:?} {} {}",
                self.name, estimate.standard_error, counts.0, counts.1, counts.2
            )
            .unwrap();
        }
    }

    fn all_methods(&self, table: &mut String) {
        let vpls = VplOptions { count: VPLS, seed: 9, ..VplOptions::default() };
        let lights = LightSet::new(VplSet::trace(&self.tracer, &vpls).unwrap());
        for method in SumMethod::ALL.into_iter().chain(Ingredient::ALL.map(SumMethod::Without)) {
            let integrator = method.integrator(&lights, &self.options).unwrap();
            self.lines(method.name(), &*integrator, table);
        }
        self.lines("path", &PathTracer::new(&self.tracer, PathStop::Count(8), 16).unwrap(), table);
        let scene = self.tracer.scene().clone();
        for truth in [Truth::Clamped, Truth::Transport] {
            let lights = GuidedLights::trace(&self.tracer, &vpls, truth, &self.view(&scene)).unwrap();
            let options = ControlOptions { error: 0.2, ..self.options };
            let integrator = LightTransport::new(&self.tracer, &lights, &options);
            self.lines(&format!("light transport, {truth}"), &integrator, table);
        }
    }
}

#[test]
fn every_method_gives_the_stored_pixels() {
    let mut table =
        String::from("scene | method | pixel | radiance | half-width | standard error | stop, pairs, rays\n");
    stored().iter().for_each(|stored| stored.all_methods(&mut table));
    if env::var("TASHIKA_UPDATE_GOLDEN").is_ok_and(|name| name == "pixels") {
        fs::write(TABLE, &table).unwrap();
    }
    let kept = fs::read_to_string(TABLE).unwrap_or_default();
    let changed: Vec<String> = table
        .lines()
        .zip(kept.lines().chain(std::iter::repeat("nothing")))
        .filter(|(now, kept)| now != kept)
        .map(|(now, kept)| format!("now {now}\nwas {kept}"))
        .collect();
    assert!(
        changed.is_empty() && table.lines().count() == kept.lines().count(),
        "{} lines of stored_pixels.txt changed; if that is meant, TASHIKA_UPDATE_GOLDEN=pixels writes it anew:\n{}",
        changed.len(),
        changed.join("\n")
    );
}
