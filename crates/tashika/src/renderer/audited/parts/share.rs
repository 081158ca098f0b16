//! A share of a picture's tiles, and the truths of its audited pixels.

use super::super::foreseen::{importance_of, share_outside};
use super::super::truth::{Around, Truth};
use super::super::truths::Source;
use super::super::verdict::{Tolerance, shown};
use super::super::{FEWEST_PASSES as FEWEST_OF_WHOLE, MOST_PATHS, describe};
use super::draw::{count, draw};
use crate::error::Result;
use crate::film::{Film, Samples, Window, keys, planes};
use crate::integrator::{ControlOptions, Integrator, PathSampler};
use crate::picture::Picture;
use crate::reconstruction::{Halves, Reconstructed};
use crate::render::{
    Begun, Finished, RenderOptions, Rendered, begin_pictures, picture_tiles, resume_pictures,
};
use crate::renderer::Prepared;
use crate::renderer::observer::{Phase, during};
use crate::request::AuditTerms;

/// Largest ratio of the predicted share outside to the permitted share at which a tile is good
/// enough. Chosen with a margin, since there is no second analysis: at a ratio of ½, 11 of 600
/// pixels of a staircase were outside, where 16 may be.
pub(super) const MAX_TILE_OUTSIDE: f64 = 0.25;
/// Fewest passes of a tile.
const FEWEST_PASSES: u32 = 4;
/// Limit on the paths of a tile, as a multiple of its share by area of the limit of a whole
/// picture.
const MOST_OF_TILE: u64 = 4;
/// Assumed distance between the values of a pixel in the whole picture and in the tile, over the
/// error that the tile predicts. If values that close to the tile's may be on either side of the
/// tolerance, the next stage of the truth is computed.
const NEAR: f64 = 0.5;

/// Renders the share. `begin` receives the film with which the render begins, and returns it with
/// the finished tiles.
pub(in crate::renderer::audited) fn render(
    prepared: &Prepared<'_>,
    method: &dyn Integrator,
    sampler: &dyn PathSampler,
    options: &ControlOptions,
    terms: &AuditTerms,
    begin: impl FnOnce(Film) -> Result<Begun>,
) -> Result<Rendered> {
    let (setting, window, observer) = (prepared.setting(), prepared.window, prepared.observer);
    let terms = AuditTerms { looks: 1, ..*terms };
    let tolerance = Tolerance::to(options);
    let seed = setting.view.seed;
    let count = count(sampler, &window, &terms, seed);
    let share = RenderOptions { window, share: prepared.share.clone() };
    let mut film = begin_pictures(&setting, method, &share, &[planes::HALVES, planes::TRUTH])?;
    describe(prepared, &terms, film.metadata_mut());
    film.metadata_mut().set(keys::AUDIT_DRAWN, count);
    film.metadata_mut().set(keys::ERROR_ABSOLUTE, tolerance.absolute);
    let begun = begin(film)?;
    let source = Source::of(prepared, &ControlOptions { seed, ..*options }, &tolerance)?;
    let mut drawn = vec![false; window.area() as usize];
    draw(&window, count, seed).iter().for_each(|[x, y]| drawn[window.index(*x, *y)] = true);
    let phase = Phase::Pixels { method: "paths", window, is_of_a_sum: false, promises: false };
    let (tiles, cancel) = (picture_tiles(&share), observer.cancel());
    let watch = |done: &Finished<'_>| observer.tile(done);
    source.with_sampler(|of_truths| {
        let work = Work { prepared, sampler, terms, tolerance, seed, source: &source, of_truths, drawn };
        let resume = || resume_pictures(begun, &tiles, &|tile| work.tile(tile), &watch, cancel);
        Ok(during(observer, phase, resume))
    })
}

/// Inputs of the tiles.
struct Work<'p> {
    prepared: &'p Prepared<'p>,
    sampler: &'p dyn PathSampler,
    terms: AuditTerms,
    tolerance: Tolerance,
    seed: u64,
    source: &'p Source<'p>,
    /// Sampler of the paths of truths.
    of_truths: &'p dyn PathSampler,
    /// True for pixels of the window that are drawn for the audit, row by row.
    drawn: Vec<bool>,
}

impl Work<'_> {
    /// Film of a tile; `None` if cancelled.
    fn tile(&self, tile: &Window) -> Option<Film> {
        let (picture, reconstructed) = self.picture(tile)?;
        let inside = "tiles are inside of the image";
        let mut film = picture.film().expect(inside);
        let truths = self.truths(&picture, &film, &reconstructed)?;
        film.add_plane(&planes::HALVES, halves(&picture.halves().expect(inside), picture.passes()));
        film.add_plane(&planes::TRUTH, Samples::F32(truths));
        Some(film)
    }

    /// Makes passes until the tile is good enough.
    fn picture(&self, tile: &Window) -> Option<(Picture<'_>, Reconstructed)> {
        let mut picture = Picture::new(self.sampler, *tile, self.seed);
        let mut importance: Option<Vec<f32>> = None;
        loop {
            if !picture.pass(importance.as_deref(), 1.0, self.prepared.observer.cancel()) {
                return None;
            }
            let reconstructed = picture.reconstruct(None).expect("tiles are inside of the image");
            let errors = importance_of(&reconstructed, &self.tolerance);
            if self.is_enough(&picture, tile, &errors) {
                return Some((picture, reconstructed));
            }
            importance = Some(errors);
        }
    }

    fn is_enough(&self, picture: &Picture<'_>, tile: &Window, importance: &[f32]) -> bool {
        let passes = picture.passes();
        let is_good = share_outside(importance) <= MAX_TILE_OUTSIDE * (1.0 - self.terms.share);
        let most = u128::from(MOST_OF_TILE * MOST_PATHS) * u128::from(tile.area())
            / u128::from(self.prepared.window.area());
        let is_done = passes >= FEWEST_OF_WHOLE && 2 * u128::from(picture.paths()) > most;
        passes >= AuditTerms::MAX_PASSES || passes >= FEWEST_PASSES && is_good || is_done
    }

    /// Truths of the audited pixels of a tile, in the layout of [`planes::TRUTH`].
    fn truths(&self, picture: &Picture<'_>, film: &Film, reconstructed: &Reconstructed) -> Option<Vec<f32>> {
        let tile = film.window();
        let channels = planes::TRUTH.channels.len();
        let mut samples = vec![0.0; channels * tile.area() as usize];
        let shown = shown(film);
        for (k, (x, y)) in tile.pixels().enumerate() {
            if !(self.drawn[self.prepared.window.index(x, y)] && shown[k]) {
                continue;
            }
            let around = Around::of(picture, [x, y], &reconstructed.radiance, &self.tolerance);
            let near = NEAR * f64::from(reconstructed.importance_error[k]);
            samples[channels * k..][..channels].copy_from_slice(&self.truth([x, y], around, near)?);
        }
        Some(samples)
    }

    /// Truth of a pixel, in as many stages as are needed to decide on which side of the tolerance
    /// the pixel is; `None` if cancelled.
    ///
    /// * `around`: estimates from the tile's picture; `near`: assumed distance of the pixel in the
    ///   whole picture from the pixel in the tile.
    fn truth(&self, pixel: [u32; 2], around: Around, near: f64) -> Option<[f32; 4]> {
        let luminance = around.luminance;
        let may_be = [luminance, (luminance - near).max(0.0), luminance + near];
        let mut truth = Truth::new(pixel, around);
        let mut stage = 0;
        loop {
            if !self.source.advance(&mut [&mut truth], self.of_truths, &|_| {}) {
                return None;
            }
            stage += 1;
            let audited = truth.audited(&self.tolerance);
            let is_open = may_be.iter().any(|luminance| audited.is_open(*luminance, &self.tolerance));
            if !is_open || stage == Source::STAGES {
                let [low, high] = audited.interval.map_or([0.0, f32::INFINITY], outwards);
                return Some([low, high, stage as f32, truth.rays() as f32]);
            }
        }
    }
}

/// Rounds both ends of an interval outwards.
fn outwards([low, high]: [f64; 2]) -> [f32; 2] {
    let [below, above] = [low, high].map(|end| end as f32);
    [
        if f64::from(below) > low { below.next_down() } else { below },
        if f64::from(above) < high { above.next_up() } else { above },
    ]
}

/// Samples of [`planes::HALVES`].
fn halves(halves: &Halves, passes: u32) -> Samples {
    let Halves { a, b } = halves;
    let errors = |film: &Film| film.plane(planes::STANDARD_ERROR)?.f32_samples().map(<[f32]>::to_vec);
    let [of_a, of_b] = [a, b].map(|film| {
        let colors = film.colors().into_iter().flatten().map(|color| color.to_array());
        colors.zip(errors(film).unwrap_or_default())
    });
    let samples = of_a.zip(of_b).flat_map(|((a, error_of_a), (b, error_of_b))| {
        [a[0], a[1], a[2], error_of_a, b[0], b[1], b[2], error_of_b, passes as f32]
    });
    Samples::F32(samples.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_rounded_outwards() {
        for [low, high] in [[0.1, 0.7], [0.3, 0.3], [0.0, 1.0], [1.0 + 1e-12, 2.0 - 1e-12]] {
            let [below, above] = outwards([low, high]);
            assert!(f64::from(below) <= low && high <= f64::from(above), "{low} {high}");
            assert!(f64::from(below.next_up()) > low && high > f64::from(above.next_down()), "{low} {high}");
        }
    }
}
