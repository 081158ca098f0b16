//! Joining of parts: the picture that they form, and its single analysis.

use std::path::Path;

use super::super::foreseen::half_widths;
use super::super::verdict::{
    Analysis, AuditedPixel, Pictured, Stated, Tolerance, Verdict, count_true, describe, shown,
};
use super::draw::draw;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::film::{Film, Key, Metadata, PixelRecord, Plane, PlaneSpec, RenderFilm, Value, keys, planes};
use crate::reconstruction::{Halves, Reconstructed, Smoother};
use crate::render::Merged;
use crate::request::AuditTerms;

/// Finishes joined parts: an audited picture is reconstructed and audited, any other film stays as
/// it is. Does nothing while pixels are missing, so that the result can be joined with further
/// parts. Runs on the current thread pool.
///
/// * `smoother`: the smoother for which the parts of an audited picture were rendered, or `None`
///   for our own. Ignored for other films.
///
/// # Errors
/// A smoother other than that of the parts; parts that this program did not write; any error of the
/// smoother.
pub fn finish_merged(merged: &mut Merged, smoother: Option<&dyn Smoother>) -> Result<()> {
    if merged.missing_pixels > 0 {
        return Ok(());
    }
    if merged.film.plane(planes::HALVES).is_some() {
        merged.film = Parts::of(&merged.film, &merged.first)?.finished(smoother)?;
    }
    Ok(())
}

/// All parts, as read from the joined film.
struct Parts<'f> {
    film: &'f Film,
    halves: Halves,
    passes: u32,
    terms: AuditTerms,
    tolerance: Tolerance,
    /// For each pixel of the window, row by row: true if it is of the population that audited
    /// pixels were drawn from.
    population: Vec<bool>,
    audited: Vec<AuditedPixel>,
    /// Total number of rays of all truths.
    rays: u64,
}

impl<'f> Parts<'f> {
    /// * `name`: path of a part, for messages.
    fn of(film: &'f Film, name: &Path) -> Result<Self> {
        let metadata = film.metadata();
        let number = |key: Key, is_good: &dyn Fn(f64) -> bool, expected: &str| {
            let number = metadata.number(key).filter(|number| is_good(*number));
            number.ok_or_else(|| {
                let found = format!("a part of an audited picture whose `{key}` is {}", told(metadata, key));
                Error::invalid(Location::file(name), found, expected)
            })
        };
        let share = |key: Key, from: f64| {
            number(key, &|share| share >= from && share > 0.0 && share < 1.0, "a share of 1")
        };
        let size = |key: Key| number(key, &|size| size >= 0.0 && size.is_finite(), "a number, at least 0");
        let terms = AuditTerms {
            share: share(keys::AUDIT_SHARE, 0.0)?,
            assurance: share(keys::AUDIT_ASSURANCE, 0.5)?,
            looks: (size(keys::AUDIT_MOST_LOOKS)? as u32).max(1),
            ..AuditTerms::default()
        };
        let tolerance = Tolerance { error: size(keys::ERROR)?, absolute: size(keys::ERROR_ABSOLUTE)? };
        let halves = samples(film, &planes::HALVES, name)?;
        let truths = samples(film, &planes::TRUTH, name)?;
        let population = shown(film);
        let terms = AuditTerms { population: Some(count_true(&population)), ..terms };
        let drawn = draw(&film.window(), size(keys::AUDIT_DRAWN)? as u64, seed(metadata, name)?);
        let audited = audited(film, truths, &population, &drawn, name)?;
        Ok(Self {
            film,
            halves: Halves { a: half(film, halves, 0)?, b: half(film, halves, 4)? },
            passes: halves.chunks_exact(CHANNELS).map(|pixel| pixel[8] as u32).max().unwrap_or(0),
            terms,
            tolerance,
            population,
            audited,
            rays: truths.chunks_exact(planes::TRUTH.channels.len()).map(|truth| truth[3] as u64).sum(),
        })
    }

    /// Picture with its claims.
    fn finished(&self, smoother: Option<&dyn Smoother>) -> Result<Film> {
        let asked = self.film.metadata().text(keys::DENOISER);
        let given = smoother.map(Smoother::name);
        if asked != given.as_deref() {
            let expected = format!("{}, for which the parts were rendered", asked.unwrap_or("own"));
            return Err(Error::option("denoiser", given.as_deref().unwrap_or("own"), expected));
        }
        let reconstructed: Reconstructed =
            self.halves.reconstruct(smoother)?.expect("halves have the planes of records");
        let half_widths = half_widths(&reconstructed, &self.tolerance);
        let mut film = Film::new(self.film.size(), self.film.window(), PixelRecord::PLANES)?;
        *film.metadata_mut() = self.film.metadata().clone();
        film.metadata_mut().set(keys::PASSES, self.passes);
        // Other requested planes, such as mattes.
        let is_for_merging =
            |plane: &Plane| [planes::HALVES.name, planes::TRUTH.name].contains(&plane.name());
        for plane in self.film.planes().iter().filter(|plane| !is_for_merging(plane)) {
            if film.plane(plane.name()).is_none() {
                film.take_plane(plane.clone());
            }
        }
        let picture = Pictured {
            plain: RenderFilm::of(self.film),
            reconstructed: &reconstructed,
            half_widths: &half_widths,
        };
        if self.audited.is_empty() {
            picture.store(&mut film, |k, _| match self.population[k] {
                true => Stated::NOTHING,
                false => Stated::BACKGROUND,
            });
            return Ok(film);
        }
        let Self { audited, tolerance, .. } = self;
        let look = Analysis::at(audited, tolerance, &film.window(), &reconstructed.radiance, &half_widths);
        let verdict = Verdict {
            look: &look,
            terms: &self.terms,
            tolerance,
            population: &self.population,
            looks: 1,
            passes: self.passes,
        };
        verdict.store(&picture, &mut film);
        film.metadata_mut().set(keys::AUDIT_RAYS, self.rays);
        describe(audited, tolerance, &mut film);
        Ok(film)
    }
}

/// Number of channels of [`planes::HALVES`]: four for each half, and the number of passes.
const CHANNELS: usize = planes::HALVES.channels.len();

/// Samples of a plane that every part must have.
fn samples<'f>(film: &'f Film, spec: &PlaneSpec, name: &Path) -> Result<&'f [f32]> {
    let plane = film.plane(spec.name).filter(|plane| plane.channels() == spec.channels);
    plane.and_then(Plane::f32_samples).ok_or_else(|| {
        let found = format!("a part of an audited picture without its plane `{}`", spec.name);
        let expected = format!("floating-point channels {}", spec.channels.join(", "));
        Error::invalid(Location::file(name), found, expected)
    })
}

/// One half of the picture. Its features are those of the whole picture.
///
/// * `first`: index of the half's first channel.
fn half(film: &Film, halves: &[f32], first: usize) -> Result<Film> {
    let read = RenderFilm::of(film);
    let mut half = Film::new(film.size(), film.window(), PixelRecord::PLANES)?;
    for ((x, y), samples) in film.window().pixels().zip(halves.chunks_exact(CHANNELS)) {
        let [r, g, b, standard_error] = std::array::from_fn(|k| samples[first + k]);
        let record = PixelRecord { radiance: Rgb::new(r, g, b), standard_error, ..read.at(x, y) };
        record.store(&mut half, x, y);
    }
    Ok(half)
}

/// Audited pixels, in the order of the draw.
fn audited(
    film: &Film,
    truths: &[f32],
    population: &[bool],
    drawn: &[[u32; 2]],
    name: &Path,
) -> Result<Vec<AuditedPixel>> {
    let window = film.window();
    let channels = planes::TRUTH.channels.len();
    let wrong = |[x, y]: [u32; 2], found: &str| {
        let found = format!("{found} at pixel {x},{y}");
        let expected =
            "truths of the pixels that the seed draws, and of no others: parts as they were rendered";
        Error::invalid(Location::file(name), found, expected)
    };
    let mut is_drawn = vec![false; window.area() as usize];
    let mut audited = Vec::new();
    for pixel in drawn {
        let at = window.index(pixel[0], pixel[1]);
        is_drawn[at] = population[at];
        if !population[at] {
            continue;
        }
        let [low, high, stage] = std::array::from_fn(|k| truths[channels * at + k]);
        if !(stage >= 1.0 && low <= high) {
            return Err(wrong(*pixel, "no truth"));
        }
        let interval = high.is_finite().then(|| [low, high].map(f64::from));
        audited.push(AuditedPixel { pixel: *pixel, interval });
    }
    let is_other = |at: &usize| truths[channels * at + 2] != 0.0 && !is_drawn[*at];
    match window.pixels().enumerate().find(|(at, _)| is_other(at)) {
        Some((_, (x, y))) => Err(wrong([x, y], "a truth")),
        None => Ok(audited),
    }
}

/// Seed of the render that made the parts.
fn seed(metadata: &Metadata, name: &Path) -> Result<u64> {
    let seed = match metadata.get(keys::SEED) {
        Some(Value::Int(seed)) => u64::try_from(*seed).ok(),
        Some(Value::Text(digits)) => digits.parse().ok(),
        _ => None,
    };
    seed.ok_or_else(|| {
        let found = format!("a part whose `{}` is {}", keys::SEED, told(metadata, keys::SEED));
        Error::invalid(Location::file(name), found, format!("0 to {}", u64::MAX))
    })
}

fn told(metadata: &Metadata, key: Key) -> String {
    metadata.get(key).map_or_else(|| "missing".to_owned(), ToString::to_string)
}
