//! Scenes in which the default method needs paths. Its claims are compared with converged pictures
//! and with other seeds.

use std::sync::Arc;

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::film::{Claim, Film, Stop, keys, planes};
use tashika::render::{TileShare, with_threads};
use tashika::renderer::{AuditedJob, Job};
use tashika::request::MethodName;
use tashika::scene::Scene;

use crate::cases::luminances;
use crate::media::foggy_room;
use crate::moving_objects::workshop;

const SIZE: [u32; 2] = [10, 8];
const ERROR: f64 = 0.2;
const SEEDS: u64 = 3;

fn scenes() -> [(&'static str, Scene); 3] {
    [("fog", foggy_room()), ("moving", workshop(None, false)), ("moving in fog", workshop(None, true))]
}

fn promised(tracer: &Tracer, size: [u32; 2], error: f64, seed: u64) -> Film {
    let rendered = Renderer::on(tracer).size(size).error(error).seed(seed).render().unwrap();
    assert!(rendered.complete);
    rendered.film
}

/// Number of paths of each pixel.
fn paths(film: &Film) -> &[f32] {
    film.plane(planes::PAIRS).unwrap().f32_samples().unwrap()
}

/// Share of pixels whose interval contains the value of another film. The half-width of the
/// comparison is the root of the sum of both squared half-widths.
fn holding(film: &Film, other: &Film) -> f64 {
    let values = [film, other].map(luminances);
    let widths = [film, other].map(|film| {
        let plane = film.plane(planes::HALF_WIDTH).unwrap();
        plane.f32_samples().unwrap().iter().map(|h| f64::from(*h)).collect::<Vec<_>>()
    });
    let holds = |k: &usize| (values[0][*k] - values[1][*k]).abs() <= widths[0][*k].hypot(widths[1][*k]);
    (0..values[0].len()).filter(holds).count() as f64 / values[0].len() as f64
}

/// Fog and motion: pixels end when their interval is narrow enough, and they have claims. The
/// intervals contain the result of paths with nine times the work, and those of other seeds. Over
/// three films of 80 pixels each the expected share is 95 %; a share of 91 % or less has
/// probability 1/200.
#[test]
fn what_is_claimed_of_fog_and_of_what_moves_is_so() {
    for (name, scene) in scenes() {
        let tracer = Tracer::new(Arc::new(scene));
        let truth = promised(&tracer, SIZE, ERROR / 3.0, 100);
        let films: Vec<Film> = (1..=SEEDS).map(|seed| promised(&tracer, SIZE, ERROR, seed)).collect();
        let (mut kept, mut agreeing) = (0.0, 0.0);
        for (k, film) in films.iter().enumerate() {
            let metadata = film.metadata();
            assert_eq!(metadata.text(keys::METHOD), Some(MethodName::Path.name()));
            assert_eq!(metadata.text(keys::CLAIM), Some(Claim::Calibrated.code().name));
            assert!(metadata.number(keys::ERROR_ABSOLUTE).unwrap() > 0.0, "{name}: it is dark somewhere");
            for (plane, code) in
                [(planes::CLAIM, Claim::Calibrated.code()), (planes::STOP, Stop::RuleMet.code())]
            {
                let codes = film.plane(plane).unwrap().u32_samples().unwrap();
                assert!(codes.iter().all(|found| *found == code.id), "{name}: {} of {codes:?}", code.name);
            }
            kept += holding(film, &truth) / SEEDS as f64;
            agreeing += holding(film, &films[(k + 1) % films.len()]) / SEEDS as f64;
        }
        assert!(kept > 0.91, "{name}: {kept} hold the truth");
        assert!(agreeing > 0.91, "{name}: {agreeing} hold each other");
    }
}

/// Statistics of a neighbourhood do not depend on the pixel that requests them first, so that
/// threads and parts do not change the result.
#[test]
fn threads_and_shares_change_no_bit_of_what_is_claimed() {
    let tracer = Tracer::new(Arc::new(foggy_room()));
    let size = [40, 20];
    let whole = with_threads(1, || promised(&tracer, size, 0.5, 1)).unwrap();
    assert_eq!(with_threads(3, || promised(&tracer, size, 0.5, 1)).unwrap(), whole);
    let share = TileShare::new(2, 2).unwrap();
    let part = Renderer::on(&tracer).size(size).error(0.5).tiles(share).render().unwrap().film;
    let there = paths(&part).iter().zip(paths(&whole)).filter(|(part, _)| **part > 0.0);
    assert!(there.clone().count() > 0 && there.clone().all(|(part, whole)| part == whole));
}

/// Without a requested error, the picture of a scene that needs paths is audited.
#[test]
fn without_an_error_a_picture_by_paths_is_audited() {
    let tracer = Tracer::new(Arc::new(foggy_room()));
    let prepared = Renderer::on(&tracer).size([400, 400]).prepare().unwrap();
    let job = prepared.job();
    assert!(matches!(job, Job::Audited(AuditedJob { lights: None, .. })), "{job:?}");
}
