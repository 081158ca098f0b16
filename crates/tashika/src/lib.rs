//! # tashika: a many-light renderer that knows its own error
//!
//! Given a tolerance and a confidence, each pixel is rendered until it is within the tolerance. It
//! states its error interval and the reason why work on it ended.
//!
//! ```
//! use tashika::{Claim, Renderer, RenderFilm, scene::builtin};
//!
//! let image = Renderer::new(builtin::tiny()).error(0.2).size([16, 12]).vpls(20_000).render()?;
//! let pixel = RenderFilm::of(&image.film).at(3, 5);
//! assert_eq!(pixel.claim, Claim::Calibrated);
//! println!("{} ± {} W·m⁻²·sr⁻¹", pixel.radiance.luminance(), pixel.half_width);
//! # Ok::<(), tashika::Error>(())
//! ```
//!
//! | to | use |
//! |---|---|
//! | read a scene | [`load_scene`] (pbrt, Mitsuba, glTF, USD, OBJ, Radiance), with [`LoadOptions`](io::LoadOptions); [`Scene::notes`] lists departures from the file |
//! | make one | [`SceneBuilder`](scene::SceneBuilder); [`scene::builtin`] has two |
//! | render | [`Renderer`], by any [`MethodName`](request::MethodName); [`Observer`](renderer::Observer) watches and ends it |
//! | measure illuminance | [`sensors`]: points and grids, with the interval of each |
//! | measure glare | [`glare`]: UGR and DGP of a fisheye image, with intervals |
//! | judge a film | [`Prepared::audit`](renderer::Prepared::audit), [`report::compare`] |
//! | read a film | [`RenderFilm`], [`Film`] and its [`planes`](film::planes); [`Claim`] and [`Stop`]: the claim of a pixel and the reason why work on it ended |
//! | write it | [`write_exr`], [`io::write_png`]; pages are [`report::render_page`] |
//! | write a method of one's own | [`Integrator`](integrator::Integrator); the example `own_method` |
//! | use the statistics alone | [`stats::stratified`]: intervals of strata, calibrated and certified |
//!
//! Examples that run are in `examples/`: `render`, `own_method`, `certificate`. Lengths are in
//! metres, radiance in W·m⁻²·sr⁻¹, colours linear Rec. 709. All work runs on the current thread
//! pool; the same request gives the same bits on any number of threads.
//!
//! The other modules are the building blocks of these. They are public for experiments, and their
//! interfaces may change with every version.
//!
//! # Crates
//! Each crate can be used alone, with only the dependencies that it needs. This crate re-exports
//! all of them. Its module `io` exists only with the feature `formats`, which is on by default.
//!
//! | crate | modules |
//! |---|---|
//! | `tashika-math` | [`math`], [`rng`], [`warp`] |
//! | `tashika-stats` | [`stats`] |
//! | `tashika-film` | [`color`], [`error`], [`film`], [`reconstruction`] |
//! | `tashika-scene` | [`bsdf`], [`scene`] |
//! | `tashika-core` | [`accel`], [`bounds`], [`compensation`], [`contribution`], [`cut`], [`gather`], [`guidance`], [`integrator`], [`media`], [`picture`], [`render`], [`request`], [`tree`], [`vpl`] |
//! | `tashika-formats` | [`io`], except lights and finished tiles |
//! | `tashika-report` | [`report`] |
//! | `tashika` | [`experiment`], [`glare`], [`io`], [`renderer`], [`sensors`] |
//!
//! # Layers
//! Listed from the bottom layer. A module uses only modules in the rows above its own; Cargo
//! enforces this between crates, and the test `tidy` within them.
//!
//! | layer | modules |
//! |---|---|
//! | 0 | [`math`], [`color`], [`rng`], [`warp`], [`stats`], [`error`] |
//! | 1 | [`bsdf`], [`film`] |
//! | 2 | [`scene`], [`accel`], [`media`] |
//! | 3 | [`vpl`], [`gather`], [`contribution`] |
//! | 4 | [`bounds`], [`guidance`] |
//! | 5 | [`tree`] |
//! | 6 | [`cut`], [`compensation`] |
//! | 7 | [`integrator`] |
//! | 8 | [`reconstruction`], [`render`], [`report`], [`request`] |
//! | 9 | [`experiment`], [`io`], [`picture`] |
//! | 10 | [`renderer`] |
//! | 11 | [`glare`], [`sensors`] |
#![forbid(unsafe_code)]

pub mod experiment;
pub mod glare;
#[cfg(feature = "formats")]
pub mod io;
pub mod renderer;
pub mod sensors;

pub use tashika_core::{
    accel, bounds, compensation, contribution, cut, gather, guidance, integrator, media, picture, render,
    request, tree, vpl,
};
pub use tashika_film::{color, error, film, reconstruction};
pub use tashika_math::{math, rng, warp};
pub use tashika_report as report;
pub use tashika_scene::{bsdf, scene};
pub use tashika_stats as stats;

pub use error::{Error, Result};
pub use film::{Claim, Film, RenderFilm, Stop};
#[cfg(feature = "formats")]
pub use io::{load_scene, write_exr};
pub use renderer::Renderer;
pub use scene::Scene;

/// The example of the README, compiled and run as a test of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
pub struct Readme;
