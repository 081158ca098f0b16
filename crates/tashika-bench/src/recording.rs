//! Rays and segments of a render, in the order in which they were traced.

use std::sync::{Arc, Mutex, PoisonError};

use tashika::accel::{Apex, Listener, SegmentBatch, Tracer};
use tashika::math::Ray;

/// Queries that a tracer received.
#[derive(Debug, Default)]
pub struct Recording {
    /// Batches of segments whose visibility was queried.
    pub batches: Vec<SegmentBatch>,
    /// Rays whose closest hit was queried, with the keys of their holes.
    pub rays: Vec<(Ray, u64)>,
}

/// Listener that stores every query.
#[derive(Debug, Default)]
struct Recorder(Mutex<Recording>);

impl Listener for Recorder {
    fn segments(&self, batch: &SegmentBatch) {
        if !batch.is_empty() {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).batches.push(batch.clone());
        }
    }

    fn ray(&self, ray: &Ray, key: u64) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).rays.push((*ray, key));
    }
}

impl Recording {
    /// Records the queries that `work` makes to the tracer that is passed to it.
    pub fn of(tracer: &Tracer, work: impl FnOnce(&Tracer)) -> Self {
        let recorder = Arc::new(Recorder::default());
        work(&tracer.with_listener(Arc::clone(&recorder) as Arc<dyn Listener>));
        let recorder = Arc::into_inner(recorder).expect("nobody listens any more");
        recorder.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of segments in all batches.
    pub fn segments(&self) -> usize {
        self.batches.iter().map(SegmentBatch::len).sum()
    }

    /// Traces all segments again, batch by batch, and returns the sum of their visibilities.
    pub fn trace_segments(&self, tracer: &Tracer) -> f64 {
        let mut visibility = Vec::new();
        let mut sum = 0.0;
        for batch in &self.batches {
            tracer.visibility(batch, &mut visibility);
            sum += visibility.iter().map(|&v| f64::from(v)).sum::<f64>();
        }
        sum
    }

    /// Traces all rays again and returns the number of hits.
    pub fn trace_rays(&self, tracer: &Tracer) -> usize {
        self.rays.iter().filter(|(ray, key)| tracer.closest_hit(ray, *key).is_some()).count()
    }
}

/// Segments of a batch, in order, in the form that Embree takes.
pub fn segments_of(batch: &SegmentBatch) -> Vec<crate::embree::Segment> {
    let mut segments = Vec::with_capacity(batch.len());
    for fan in batch.fans() {
        for &target in &batch.targets()[fan.targets.start as usize..fan.targets.end as usize] {
            segments.push(match fan.apex {
                Apex::Point(apex) => {
                    crate::embree::Segment { origin: apex, direction: target - apex, t_max: 1.0 }
                }
                Apex::Direction(direction) => {
                    crate::embree::Segment { origin: target, direction, t_max: f32::INFINITY }
                }
            });
        }
    }
    segments
}
