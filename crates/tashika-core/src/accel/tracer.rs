//! The tracer of a scene.

use std::sync::Arc;

use super::around::OfEmitters;
use super::kernel;
use super::listener::Listener;
use super::segments::SegmentBatch;
use super::trees::Trees;
use crate::math::Ray;
use crate::math::simd::Level;
use crate::scene::{InstanceId, Scene};

/// A surface met by a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter of the intersection.
    pub t: f32,
    /// Instance whose surface was met.
    pub instance: InstanceId,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Barycentric weights of the triangle's corners, summing to 1.
    pub barycentric: [f32; 3],
}

/// Memory use of a tracer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TracerSize {
    /// Number of triangles; a triangle counts once for each tree that contains it.
    pub triangles: u64,
    /// Number of trees of shared meshes.
    pub shared_trees: u64,
    /// Memory of nodes and triangles (bytes).
    pub bytes: u64,
}

/// Closest hits and visibility in a scene. Clones share their trees.
#[derive(Clone, Debug)]
pub struct Tracer {
    scene: Arc<Scene>,
    trees: Arc<Trees>,
    level: Level,
    plain: bool,
    listener: Option<Arc<dyn Listener>>,
    /// Factors of emitters inside glass; `None` if no emitter is inside glass.
    pub(super) of_emitters: Option<Arc<OfEmitters>>,
}

impl Tracer {
    /// Builds the trees of `scene`, in parallel on the current thread pool. The result does not
    /// depend on the pool.
    pub fn new(scene: Arc<Scene>) -> Self {
        let trees = Arc::new(Trees::new(&scene));
        let tracer =
            Self { scene, trees, level: Level::best(), plain: false, listener: None, of_emitters: None };
        Self { of_emitters: OfEmitters::of(&tracer), ..tracer }
    }

    /// Returns a tracer over the same trees that reports its queries to `listener`.
    #[must_use]
    pub fn with_listener(&self, listener: Arc<dyn Listener>) -> Self {
        Self { listener: Some(listener), ..self.clone() }
    }

    /// Returns a tracer over the same trees that uses no vector instructions and remembers no
    /// occluders. Its answers are the same to the bit.
    #[must_use]
    pub fn plain(&self) -> Self {
        Self { level: Level::PORTABLE, plain: true, ..self.clone() }
    }

    /// The scene that is traced.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    pub(super) fn trees(&self) -> &Trees {
        &self.trees
    }

    /// Counts of triangles and trees, and the memory they use.
    pub fn size(&self) -> TracerSize {
        let trees = || self.trees.shared.iter().chain([&self.trees.world]);
        TracerSize {
            triangles: trees().map(|t| t.triangles()).sum(),
            shared_trees: self.trees.shared.len() as u64,
            bytes: trees().map(|t| t.bytes()).sum::<u64>()
                + size_of_val(&self.trees.top.nodes[..]) as u64
                + size_of_val(&self.trees.moving.top.nodes[..]) as u64,
        }
    }

    /// Returns the first static surface along `ray`.
    ///
    /// A surface of opacity `o < 1` is met with probability `o`. The decision depends only on
    /// `key`, the instance and the triangle, so rays with equal keys see the same holes.
    pub fn closest_hit(&self, ray: &Ray, key: u64) -> Option<Hit> {
        if let Some(listener) = &self.listener {
            listener.ray(ray, key);
        }
        kernel::closest_hit(self.level, &self.trees, &self.scene, ray, key)
    }

    /// Overwrites `visibility` with the transmittance of static geometry along each segment of
    /// `batch`, in order: 0 if blocked, 1 if free, between the two if surfaces are partly
    /// transparent.
    pub fn visibility(&self, batch: &SegmentBatch, visibility: &mut Vec<f32>) {
        if let Some(listener) = &self.listener {
            listener.segments(batch);
        }
        visibility.clear();
        visibility.reserve(batch.len());
        if self.plain {
            kernel::plain_visibility(&self.trees, &self.scene, batch, visibility);
        } else {
            kernel::visibility(self.level, &self.trees, &self.scene, batch, visibility);
        }
    }

    /// Returns the first surface along `ray`, static or moving, at a time given as a `share` of the
    /// time that the shutter is open, 0 to 1.
    #[inline]
    pub fn closest_hit_at(&self, ray: &Ray, key: u64, share: f32) -> Option<Hit> {
        let standing = self.closest_hit(ray, key);
        if self.trees.moving.movers.is_empty() {
            return standing;
        }
        kernel::closest_moving_hit(self.level, &self.trees, &self.scene, (ray, key), share, standing)
    }

    /// Like [`visibility`](Self::visibility), but includes moving geometry at a time given as a
    /// `share` of the time that the shutter is open, 0 to 1.
    #[inline]
    pub fn visibility_at(&self, batch: &SegmentBatch, share: f32, visibility: &mut Vec<f32>) {
        self.visibility(batch, visibility);
        if !self.trees.moving.movers.is_empty() {
            kernel::pass_moving(self.level, &self.trees, &self.scene, batch, share, visibility);
        }
    }
}
