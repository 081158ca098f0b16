//! Traversal of the trees by a single segment or ray.

use std::borrow::Borrow;

use glam::Vec3;

use super::Hit;
use super::beam::{Slope, limit};
use super::bvh::{Bvh, MAX_WAITING, Node};
use super::exact::{ray_meets, segment_meets};
use super::moving::Deformed;
use super::occluders::{Leaf, Occluders};
use super::segments::Glass;
use super::trees::{Met, Placed, Tree, Trees};
use super::triangle::{Block, Lines, Triangle, barycentric, blocked, flag, met};
use crate::math::Ray;
use crate::math::simd::{F32x8, WIDTH, each, for_bits, prefetch};
use crate::rng::{self, Purpose};
use crate::scene::{InstanceId, Scene};

/// Stack of nodes to visit. Each entry also stores the parameter at which the ray enters the node,
/// or the lanes that enter it.
pub(super) type Stack<T> = [(u32, T); MAX_WAITING];

/// Memory that is reused by successive traversals: the stacks, since clearing them would take as
/// long as a short traversal, and the occluders.
pub(super) struct Waiting {
    pub top: Box<Stack<f32>>,
    pub below: Box<Stack<f32>>,
    pub packets_top: Box<Stack<u32>>,
    pub packets_below: Box<Stack<u32>>,
    /// Leaves of the world tree that blocked recent segments; `None` if they are not to be tested.
    pub occluders: Option<Occluders>,
}

impl Waiting {
    pub fn new(occluders: Option<Occluders>) -> Self {
        Self {
            top: Box::new([(0, 0.0); MAX_WAITING]),
            below: Box::new([(0, 0.0); MAX_WAITING]),
            packets_top: Box::new([(0, 0); MAX_WAITING]),
            packets_below: Box::new([(0, 0); MAX_WAITING]),
            occluders,
        }
    }
}

/// A segment between two points, or from a point to infinity.
#[derive(Clone, Copy)]
pub(super) struct Segment {
    pub origin: Vec3,
    /// Vector from start to end, or the direction to infinity.
    pub direction: Vec3,
    /// End of the segment; unused if the segment goes to infinity.
    pub target: Vec3,
}

impl Segment {
    /// Creates the segment between two points.
    #[inline(always)]
    pub fn between(origin: Vec3, target: Vec3) -> Self {
        Self { origin, direction: target - origin, target }
    }

    /// Creates the segment from a point to infinity.
    #[inline(always)]
    pub fn towards(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, target: origin }
    }

    /// Transforms the segment into the space of an instance.
    #[inline(always)]
    pub fn in_space_of<const BOUNDED: bool>(&self, placed: &Placed) -> Self {
        let point = |p: Vec3| Vec3::from(placed.points(p.to_array()));
        if BOUNDED {
            Self::between(point(self.origin), point(self.target))
        } else {
            let direction = Vec3::from(placed.directions(self.direction.to_array()));
            Self::towards(point(self.origin), direction)
        }
    }

    /// Returns true if the segment meets a triangle, by exact arithmetic.
    #[inline(always)]
    pub fn meets<const BOUNDED: bool>(&self, t: &Triangle) -> bool {
        segment_meets(&t.v, self.origin, self.direction, BOUNDED.then_some(self.target))
    }

    #[inline(always)]
    pub fn slope<F: F32x8>(&self) -> Slope<F> {
        Slope::new(self.origin.to_array(), self.direction.to_array())
    }

    #[inline(always)]
    pub fn lines<F: F32x8>(&self) -> Lines<F> {
        Lines {
            origin: each!(|axis| F::splat(self.origin[axis])),
            direction: each!(|axis| F::splat(self.direction[axis])),
            target: each!(|axis| F::splat(self.target[axis])),
        }
    }
}

/// Context in which the transmittance of a surface is evaluated.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub scene: &'a Scene,
    pub glass: Glass,
    /// Instance in whose space the tree lies; `None` in world space.
    pub instance: Option<u32>,
    /// Time, as a share of the time that the shutter is open; ignored for static geometry.
    pub share: f32,
}

impl Place<'_> {
    /// Share of the light along a segment that a triangle stops at its intersection with the
    /// segment.
    #[inline(never)]
    pub fn stopped(&self, block: &Block, slot: usize, origin: Vec3, direction: Vec3) -> f32 {
        let t = block.triangle(slot);
        if t.flags & flag::TRANSPARENT == 0 {
            return 1.0;
        }
        let b = barycentric(origin, direction, &t);
        let passes = self.glass == Glass::Passes;
        match self.instance {
            None => self.scene.stopped(InstanceId::at(t.instance), t.index, b, direction, passes),
            Some(instance) => {
                let instance = InstanceId::at(instance);
                self.scene.stopped_at(self.share, instance, t.index, b, direction, passes)
            }
        }
    }
}

/// A set of instances and the tree over them.
pub(super) trait Instances {
    type Placed: Borrow<Placed>;

    /// Tree over the instances; each leaf is one instance.
    fn top(&self) -> &Bvh;

    /// Instance that is a leaf of the tree.
    fn placed(&self, leaf: u32) -> Self::Placed;

    /// Tree of a shared mesh.
    fn tree(&self, number: u32) -> &Tree;

    /// The triangles of a tree at the time of the traversal; `None` if the mesh does not deform.
    fn deformed<'t>(&self, tree: &'t Tree) -> Option<Deformed<'t>>;
}

/// Static instances.
pub(super) struct Standing<'a>(pub &'a Trees);

impl<'a> Instances for Standing<'a> {
    type Placed = &'a Placed;

    #[inline(always)]
    fn top(&self) -> &Bvh {
        &self.0.top
    }

    #[inline(always)]
    fn placed(&self, leaf: u32) -> &'a Placed {
        &self.0.placed[leaf as usize]
    }

    #[inline(always)]
    fn tree(&self, number: u32) -> &Tree {
        &self.0.shared[number as usize]
    }

    #[inline(always)]
    fn deformed<'t>(&self, _: &'t Tree) -> Option<Deformed<'t>> {
        None
    }
}

/// Transmittance of static geometry along a segment.
#[inline(always)]
pub(super) fn visible<F: F32x8, const BOUNDED: bool>(
    trees: &Trees,
    scene: &Scene,
    glass: Glass,
    s: &Segment,
    waiting: &mut Waiting,
) -> f32 {
    let world = Place { scene, glass, instance: None, share: 0.0 };
    let mut nobody = Leaf::default();
    let occluder = match &mut waiting.occluders {
        Some(occluders) => {
            let occluder = occluders.of(s.direction);
            if passes_leaf::<F, BOUNDED>(&trees.world, *occluder, s, &world) <= 0.0 {
                return 0.0;
            }
            occluder
        }
        None => &mut nobody,
    };
    let visible = pass::<F, BOUNDED>(&trees.world, 0, s, 1.0, &world, &mut waiting.below, occluder);
    if visible > 0.0 && !trees.placed.is_empty() {
        pass_placed::<F, BOUNDED>(&Standing(trees), 0, s, visible, &world, waiting)
    } else {
        visible
    }
}

/// Product of `visible` and the transmittance of the instances below a node.
#[inline(always)]
pub(super) fn pass_placed<F: F32x8, const BOUNDED: bool>(
    instances: &impl Instances,
    root: u32,
    s: &Segment,
    mut visible: f32,
    place: &Place<'_>,
    waiting: &mut Waiting,
) -> f32 {
    let limit = limit(if BOUNDED { 1.0 } else { f32::INFINITY });
    let slope = s.slope::<F>();
    let mut top = 1;
    waiting.top[0].0 = root;
    while top > 0 {
        top -= 1;
        let node = &instances.top().nodes[waiting.top[top].0 as usize];
        let (met, _) = slope.meets_children(node, limit);
        let inner = met & node.inner;
        for_bits!(met ^ inner, below WIDTH, |slot| {
            let placed = instances.placed(node.first[slot]);
            let p: &Placed = placed.borrow();
            let local = s.in_space_of::<BOUNDED>(p);
            let place = Place { instance: Some(p.instance), ..*place };
            let tree = instances.tree(p.tree);
            let (below, mut occluder) = (&mut waiting.below, Leaf::default());
            visible = match instances.deformed(tree) {
                None => pass::<F, BOUNDED>(tree, 0, &local, visible, &place, below, &mut occluder),
                Some(tree) => pass::<F, BOUNDED>(&tree, 0, &local, visible, &place, below, &mut occluder),
            };
            if visible <= 0.0 {
                return 0.0;
            }
        });
        push_children(node, inner, &mut waiting.top, &mut top);
    }
    visible
}

/// Transmittance of one leaf of a tree; 1 if the segment misses its box.
#[inline(always)]
fn passes_leaf<F: F32x8, const BOUNDED: bool>(
    tree: &Tree,
    leaf: Leaf,
    s: &Segment,
    place: &Place<'_>,
) -> f32 {
    let slot = leaf.slot as usize & (WIDTH - 1);
    // The leaf may have been stored for another tree and may not exist in this one.
    let Some(node) = tree.nodes.get(leaf.node as usize) else { return 1.0 };
    let is_leaf = node.count[slot] > 0;
    let (met, _) = s.slope::<F>().meets_children(node, limit(if BOUNDED { 1.0 } else { f32::INFINITY }));
    if !is_leaf || met & (1 << slot) == 0 {
        return 1.0;
    }
    let block = &tree.blocks[node.first[slot] as usize];
    pass_block::<F, BOUNDED>(block, &s.lines(), s, 1.0, place)
}

/// Product of `visible` and the transmittance of the triangles of a block.
#[inline(always)]
pub(super) fn pass_block<F: F32x8, const BOUNDED: bool>(
    block: &Block,
    lines: &Lines<F>,
    s: &Segment,
    mut visible: f32,
    place: &Place<'_>,
) -> f32 {
    let met = blocked::<F, BOUNDED>(&block.planes(), lines);
    let mut left = met.any();
    while left != 0 && visible > 0.0 {
        let slot = left.trailing_zeros() as usize & (WIDTH - 1);
        left &= left - 1;
        if !met.is_doubtful_at(slot) || s.meets::<BOUNDED>(&block.triangle(slot)) {
            visible *= 1.0 - place.stopped(block, slot, s.origin, s.direction);
        }
    }
    visible
}

/// Product of `visible` and the transmittance of the triangles below a node. If the product becomes
/// zero, `occluder` receives the leaf that made it zero.
#[inline(always)]
pub(super) fn pass<F: F32x8, const BOUNDED: bool>(
    of: &impl Met,
    root: u32,
    s: &Segment,
    mut visible: f32,
    place: &Place<'_>,
    waiting: &mut Stack<f32>,
    occluder: &mut Leaf,
) -> f32 {
    let tree = of.tree();
    if tree.nodes.is_empty() {
        return visible;
    }
    let limit = limit(if BOUNDED { 1.0 } else { f32::INFINITY });
    let (slope, lines) = (s.slope::<F>(), s.lines::<F>());
    let mut top = 1;
    waiting[0].0 = root;
    while top > 0 {
        top -= 1;
        let number = waiting[top].0;
        let node = &tree.nodes[number as usize];
        let (met, _) = slope.meets_children(node, limit);
        let inner = met & node.inner;
        let leaves = met ^ inner;
        for_bits!(leaves, below WIDTH, |slot| {
            prefetch(&tree.blocks[node.first[slot] as usize]);
        });
        for_bits!(inner, below WIDTH, |slot| {
            prefetch(&tree.nodes[node.first[slot] as usize]);
        });
        for_bits!(leaves, below WIDTH, |slot| {
            let block = of.block::<F>(node.first[slot]);
            visible = pass_block::<F, BOUNDED>(block.borrow(), &lines, s, visible, place);
            if visible <= 0.0 {
                *occluder = Leaf { node: number, slot: slot as u32 };
                return 0.0;
            }
        });
        push_children(node, inner, waiting, &mut top);
    }
    visible
}

/// Pushes the first child last, so that all traversals reach leaves in the same order.
#[inline(always)]
fn push_children(node: &Node, mut inner: u32, waiting: &mut Stack<f32>, top: &mut usize) {
    while inner != 0 {
        let slot = (u32::BITS - 1 - inner.leading_zeros()) as usize;
        inner ^= 1 << slot;
        waiting[*top].0 = node.first[slot & (WIDTH - 1)];
        *top += 1;
    }
}

/// The first surface along a ray; see [`Tracer::closest_hit`](super::Tracer::closest_hit).
#[inline(always)]
pub(super) fn closest_hit<F: F32x8>(
    trees: &Trees,
    scene: &Scene,
    ray: &Ray,
    key: u64,
    waiting: &mut Waiting,
) -> Option<Hit> {
    let s = Segment::towards(ray.origin, ray.direction);
    let mut nearest = Nearest { t_max: ray.t_max, hit: None, scene, key };
    nearest.look::<F>(&trees.world, &s, None, &mut waiting.below);
    if !trees.placed.is_empty() {
        nearest.look_at_placed::<F>(&Standing(trees), &s, waiting);
    }
    nearest.hit
}

/// Bit that marks the numbers of leaves on a stack.
const LEAF: u32 = 1 << 31;

/// The nearest hit so far.
pub(super) struct Nearest<'a> {
    pub t_max: f32,
    pub hit: Option<Hit>,
    pub scene: &'a Scene,
    pub key: u64,
}

impl Nearest<'_> {
    /// Searches instances for a nearer hit; there must be at least one instance.
    #[inline(always)]
    pub fn look_at_placed<F: F32x8>(
        &mut self,
        instances: &impl Instances,
        s: &Segment,
        waiting: &mut Waiting,
    ) {
        let slope = s.slope::<F>();
        let mut top = 1;
        waiting.top[0] = (0, 0.0);
        while top > 0 {
            top -= 1;
            let (number, near) = waiting.top[top];
            if near > limit(self.t_max) {
                continue;
            }
            if number & LEAF != 0 {
                let placed = instances.placed(number ^ LEAF);
                let p: &Placed = placed.borrow();
                let local = s.in_space_of::<false>(p);
                let (tree, instance) = (instances.tree(p.tree), Some(p.instance));
                match instances.deformed(tree) {
                    None => self.look::<F>(tree, &local, instance, &mut waiting.below),
                    Some(tree) => self.look::<F>(&tree, &local, instance, &mut waiting.below),
                }
                continue;
            }
            let node = &instances.top().nodes[number as usize];
            let (met, near) = slope.meets_children(node, limit(self.t_max));
            push_sorted(node, met, near, &mut waiting.top, &mut top);
        }
    }

    /// Searches one tree for a nearer hit.
    #[inline(always)]
    fn look<F: F32x8>(
        &mut self,
        of: &impl Met,
        s: &Segment,
        instance: Option<u32>,
        waiting: &mut Stack<f32>,
    ) {
        let tree = of.tree();
        if tree.nodes.is_empty() {
            return;
        }
        let (slope, lines) = (s.slope::<F>(), s.lines::<F>());
        let mut top = 1;
        waiting[0] = (0, 0.0);
        while top > 0 {
            top -= 1;
            let (number, near) = waiting[top];
            if near > limit(self.t_max) {
                continue;
            }
            if number & LEAF == 0 {
                let node = &tree.nodes[number as usize];
                let (met, near) = slope.meets_children(node, limit(self.t_max));
                for_bits!(met, below WIDTH, |slot| {
                    let first = node.first[slot] as usize;
                    if node.is_inner(slot) {
                        prefetch(&tree.nodes[first]);
                    } else {
                        prefetch(&tree.blocks[first]);
                    }
                });
                push_sorted(node, met, near, waiting, &mut top);
                continue;
            }
            let block = of.block::<F>(number ^ LEAF);
            let block: &Block = block.borrow();
            let (met, parameters) = met::<F>(&block.planes(), &lines);
            let mut left = met.any();
            if left == 0 {
                continue;
            }
            let parameters = parameters.array();
            while left != 0 {
                let slot = left.trailing_zeros() as usize & (WIDTH - 1);
                left &= left - 1;
                let parameter = if met.is_doubtful_at(slot) {
                    ray_meets(&block.triangle(slot).v, s.origin, s.direction)
                } else {
                    Some(parameters[slot])
                };
                if let Some(parameter) = parameter
                    && parameter < self.t_max
                {
                    self.take(&block.triangle(slot), instance, s, parameter);
                }
            }
        }
    }

    /// Records a hit that is nearer than the last, unless the opacity of its surface lets the ray
    /// pass.
    fn take(&mut self, t: &Triangle, instance: Option<u32>, s: &Segment, parameter: f32) {
        let instance = instance.unwrap_or(t.instance);
        let b = barycentric(s.origin, s.direction, t);
        if t.flags & flag::HOLES != 0 {
            let opacity = self.scene.opacity(InstanceId::at(instance), t.index, b);
            let place = u64::from(instance) << 32 | u64::from(t.index);
            let u = (rng::key(self.key, Purpose::Opacity, place) >> 40) as f32 * (1.0 / (1 << 24) as f32);
            if u >= opacity {
                return;
            }
        }
        self.t_max = parameter;
        self.hit =
            Some(Hit { t: parameter, instance: InstanceId::at(instance), triangle: t.index, barycentric: b });
    }
}

/// Pushes the children by decreasing distance, so that the nearest is visited first.
#[inline(always)]
fn push_sorted<F: F32x8>(node: &Node, mut met: u32, near: F, waiting: &mut Stack<f32>, top: &mut usize) {
    let near = near.array();
    let base = *top;
    while met != 0 {
        let slot = met.trailing_zeros() as usize & (WIDTH - 1);
        met &= met - 1;
        let leaf = if node.is_inner(slot) { 0 } else { LEAF };
        let mut at = *top;
        while at > base && waiting[at - 1].1 < near[slot] {
            waiting[at] = waiting[at - 1];
            at -= 1;
        }
        waiting[at] = (node.first[slot] | leaf, near[slot]);
        *top += 1;
    }
}
