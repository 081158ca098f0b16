//! Tests of the visibility of lights measured by pilot segments.

use std::sync::Arc;

use crate::accel::Tracer;
use crate::contribution::ContributionKernel;
use crate::cut::{Pilot, PilotVisibility};
use crate::gather::{GatherOptions, View};
use crate::math::Vec3;
use crate::scene::builtin;
use crate::tree::{LightTree, LightTreeBuilder};
use crate::vpl::{Provenance, Vpl, VplKind, VplOptions, VplSet};

/// The view of the built-in box. Half of the lights are its VPLs; the other half are outside of the
/// box and not visible from inside.
fn with_pilot<T>(work: impl FnOnce(&Pilot<'_>) -> T) -> T {
    let tracer = Tracer::new(Arc::new(builtin::tiny()));
    let traced = VplSet::trace(&tracer, &VplOptions { count: 300, ..VplOptions::default() }).unwrap();
    let mut lights = traced.lights().to_vec();
    let outside = |light: &Vpl| Vpl {
        position: light.position + Vec3::new(0.0, 50.0, 0.0),
        kind: VplKind::Omni,
        ..*light
    };
    lights.extend(traced.lights().iter().map(outside));
    let tree = LightTree::build(&VplSet::new(lights, Provenance::default()), LightTreeBuilder::default());
    let gather = GatherOptions { points: 2, ..GatherOptions::default() };
    let view = View { camera: &tracer.scene().cameras()[0], size: [40, 24], gather, seed: 2 };
    work(&Pilot { tracer: &tracer, view, lights: &tree, contribution: ContributionKernel::new(0.05) })
}

/// Expected visibility of every cluster of lights, in depth-first order.
fn visibilities(pilot: &Pilot<'_>, visibility: &PilotVisibility, cell: [u32; 2]) -> Vec<f64> {
    let about = visibility.about(pilot, cell);
    let prior = about.prior();
    pilot.lights.depth_first().map(|cluster| prior.importance_visibility(&cluster)).collect()
}

#[test]
fn lights_behind_walls_are_expected_to_be_dark_and_others_are_not() {
    with_pilot(|pilot| {
        let visibility = PilotVisibility::new(pilot, 1);
        let expected = visibilities(pilot, &visibility, [1, 0]);
        let (mut inside, mut outside) = ((0.0, 0.0), (0.0, 0.0));
        for (cluster, p) in pilot.lights.depth_first().zip(&expected) {
            if cluster.count == 1 {
                let high = pilot.lights.light(cluster.first).position.y > 25.0;
                let sums = if high { &mut outside } else { &mut inside };
                *sums = (sums.0 + p, sums.1 + 1.0);
            }
        }
        assert!(inside.1 > 100.0 && outside.1 > 100.0);
        let (inside, outside) = (inside.0 / inside.1, outside.0 / outside.1);
        assert!(outside < 0.02 && inside > 0.5, "{inside} inside, {outside} outside");
    });
}

#[test]
fn a_cell_is_the_same_whoever_asks_first_and_another_with_another_seed() {
    with_pilot(|pilot| {
        let [one, other, third] = [1, 1, 2].map(|seed| PilotVisibility::new(pilot, seed));
        let first = visibilities(pilot, &one, [0, 0]);
        visibilities(pilot, &other, [2, 1]);
        visibilities(pilot, &other, [1, 1]);
        assert_eq!(first, visibilities(pilot, &other, [0, 0]));
        assert_ne!(first, visibilities(pilot, &third, [0, 0]));
    });
}

#[test]
fn what_it_costs_is_told() {
    with_pilot(|pilot| {
        // Each of the 600 lights is a cluster, and a cell has 8 points. There is a segment for each
        // light and point that face each other. The cost is shared by the 16 × 8 pixels of cell
        // `[1, 1]`.
        let visibility = PilotVisibility::new(pilot, 1);
        let cost = visibility.about(pilot, [1, 1]).segments_per_pixel;
        assert!((5..=600 * 8 / 128 + 1).contains(&cost), "{cost}");
    });
}
