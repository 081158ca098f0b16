//! Tests of the estimates for random lights and points, from samples of a cut, against sums over
//! all terms.

use std::sync::Arc;

use super::{TRANSPORT, lights, points};
use crate::accel::{SegmentBatch, Tracer};
use crate::bounds::UpperAnalytic;
use crate::bsdf::{Bsdf, Lambert};
use crate::color::{Controlled, Rgb};
use crate::cut::{
    Clusters, CutMemory, InheritedCut, OfPoint, Population, Rank, StrataOptions, VisibilityPrior, gather_tree,
};
use crate::gather::GatherPoint;
use crate::math::{Frame, Vec3};
use crate::rng::{Purpose, Stream};
use crate::scene::builtin;
use crate::stats::Moments;
use crate::vpl::{Vpl, VplKind};

/// Estimates by many cuts of `pairs` pairs, and the truth: the contribution of each light to each
/// point, and the shares of the points.
struct Known {
    populations: Vec<Population>,
    /// For each light: true if it is given, and its terms by point.
    terms: Vec<(bool, Vec<f64>)>,
    /// Unoccluded terms by light and point.
    unoccluded: Vec<Vec<f64>>,
    shares: Vec<f64>,
}

fn is_given(light: &Vpl) -> bool {
    light.kind == VplKind::Omni
}

/// * `worth`: see [`InheritedCut::population`].
fn known(pairs: u64, runs: u64, worth: f64) -> Known {
    let tracer = Tracer::new(Arc::new(builtin::tiny()));
    let mut s = Stream::new(9, Purpose::Test, 7);
    let lights = lights(400, &mut s);
    let mut points = points(12, &mut s);
    let frame = Frame::about(Vec3::Z);
    let bsdf = Bsdf::Lambert(Lambert { reflectance: Rgb::gray(0.5) });
    let alike = GatherPoint { frame, bsdf, weight: Rgb::gray(1.0 / 12.0), ..points[0] };
    for point in &mut points {
        *point = GatherPoint { position: point.position, ..alike };
    }
    let points = gather_tree::<UpperAnalytic>(&points);
    let part = Controlled::Luminance.parts()[0];
    let unoccluded = |light: &Vpl| {
        let of_point = |point: &GatherPoint| part.of(TRANSPORT.unoccluded(point, light));
        points.points().iter().map(of_point).collect::<Vec<f64>>()
    };
    let terms = (0..400).map(|light| {
        let light = lights.light(light);
        let mut batch = SegmentBatch::default();
        batch.push_fan(light.apex(), points.points().iter().map(|point| point.position));
        let mut visibility = Vec::new();
        tracer.visibility(&batch, &mut visibility);
        let value = |(unoccluded, seen): (f64, &f32)| unoccluded * f64::from(*seen);
        (is_given(&light), unoccluded(&light).into_iter().zip(&visibility).map(value).collect())
    });
    let terms = terms.collect();
    let unoccluded = (0..400).map(|light| unoccluded(&lights.light(light))).collect();
    let root = f64::from(points.nodes()[0].weight);
    let shares = (0..12).map(|point| f64::from(points.point(point).weight.max_channel()) / root).collect();
    let clusters = Clusters { lights: &lights, points: &points, contribution: TRANSPORT };
    let (controlled, prior) = (Controlled::Luminance, VisibilityPrior::NONE);
    let options = StrataOptions { inherits: true, tabulates: true, corrects: true, controlled, prior };
    let run = |number| {
        let mut memory = CutMemory::default();
        let stream = Stream::new(5, Purpose::Cut, number);
        let mut cut =
            InheritedCut::new(clusters, Rank::Upper, options, &tracer, stream, &mut memory).unwrap();
        cut.grow(pairs);
        cut.population(0, is_given, worth)
    };
    Known { populations: (0..runs).map(run).collect(), terms, unoccluded, shares }
}

#[test]
fn the_squares_of_what_lights_add_are_told_from_above() {
    for pairs in [4, 60, 600] {
        let Known { populations, terms, shares, .. } = known(pairs, 1500, f64::INFINITY);
        let (mut squares, mut upper, mut fourth, mut largest) = (0.0, 0.0, 0.0, 0.0_f64);
        for (_, by_point) in terms.iter().filter(|(is_given, _)| !is_given) {
            squares += by_point.iter().sum::<f64>().powi(2);
            for (c, share) in by_point.iter().zip(&shares) {
                upper += share * (c / share).powi(2);
                fourth += share * (c / share).powi(4);
                largest = largest.max(c / share);
            }
        }
        let [mut told, mut of_fourth] = [Moments::default(); 2];
        for population in &populations {
            told.push(population.importance_by_lights);
            of_fourth.push(population.importance_fourth);
            assert!(population.importance_largest <= largest * (1.0 + 1e-5));
        }
        for (told, truth) in [(told, upper), (of_fourth, fourth)] {
            let close = (told.mean() - truth).abs() < 4.42 * told.standard_error() + 1e-5 * truth;
            assert!(close && told.standard_error() < 0.1 * truth, "{pairs}: {} for {truth}", told.mean());
        }
        let found = populations.iter().filter(|p| p.importance_largest > 0.5 * largest).count();
        assert!(pairs < 600 || found > populations.len() / 2, "{found} know of the largest");
        assert!(squares < upper);
    }
}

/// The estimates use points other than those of the samples, and assume that a light that is
/// visible from one point is visible from all. They are closer to the truth, and still above it.
#[test]
fn what_lights_add_is_told_by_other_points() {
    for pairs in [60, 600] {
        let Known { populations, terms, unoccluded, shares } = known(pairs, 1500, 0.0);
        let (mut squares, mut truth, mut upper) = (0.0, 0.0, 0.0);
        for ((_, by_point), unoccluded) in
            terms.iter().zip(&unoccluded).filter(|((is_given, _), _)| !is_given)
        {
            squares += by_point.iter().sum::<f64>().powi(2);
            for (j, (c, share)) in by_point.iter().zip(&shares).enumerate() {
                // Through glass a light is partly visible.
                let seen = if unoccluded[j] > 0.0 { c / unoccluded[j] } else { 0.0 };
                truth += c * seen * unoccluded.iter().sum::<f64>();
                upper += share * (c / share).powi(2);
            }
        }
        let mut told = Moments::default();
        populations.iter().for_each(|population| told.push(population.importance_by_lights));
        let error = (told.mean() - truth).abs();
        assert!(error < 4.42 * told.standard_error() + 0.01 * truth, "{pairs}: {} for {truth}", told.mean());
        assert!(told.standard_error() < 0.03 * truth);
        assert!(squares < truth && truth < upper, "{squares} {truth} {upper}");
    }
}

/// Squared differences between consecutive points, minus the noise of samples, agree with the
/// truth.
#[test]
fn differences_between_points_are_told_without_the_noise_of_samples() {
    for pairs in [60, 600] {
        let Known { populations, terms, .. } = known(pairs, 1500, f64::INFINITY);
        let by_point: Vec<f64> = (0..12).map(|j| terms.iter().map(|(_, of)| of[j]).sum()).collect();
        let truth: f64 = by_point.chunks(2).map(|pair| (pair[0] - pair[1]).powi(2)).sum();
        let (mut told, mut with_noise) = (Moments::default(), Moments::default());
        for population in &populations {
            let of_pair = |pair: &[OfPoint]| (pair[0].value - pair[1].value).powi(2);
            let squares: f64 = population.points.chunks(2).map(of_pair).sum();
            let noise: f64 = population.points.iter().map(|point| point.noise).sum();
            told.push(squares - noise);
            with_noise.push(squares);
        }
        let ratio = told.mean() / truth;
        assert!(ratio > 0.75 && ratio < 1.25, "{pairs}: {ratio} ± {}", told.standard_error() / truth);
        if pairs == 60 {
            let ratio = with_noise.mean() / truth;
            assert!(ratio > 1.5, "samples are noisy enough for that to matter: {ratio}");
        }
    }
}
