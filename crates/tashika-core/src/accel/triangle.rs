//! The triangle test, in one implementation for eight triangles against one segment and for one
//! triangle against sixteen segments.

use glam::Vec3;

use crate::math::gamma;
use crate::math::simd::{F32x8, Vector, WIDTH, each};

/// Bits of [`Triangle::flags`].
pub(super) mod flag {
    /// Segments may be stopped in part; the material decides.
    pub const TRANSPARENT: u32 = 1;
    /// Rays may pass through holes; the material decides.
    pub const HOLES: u32 = 2;
}

/// Corners, numbers and flags of a triangle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Triangle {
    /// Corners (m).
    pub v: [Vec3; 3],
    /// Instance of the triangle; unused inside instanced trees.
    pub instance: u32,
    /// Index of the triangle in its mesh.
    pub index: u32,
    /// Bits of [`flag`].
    pub flags: u32,
}

/// Triangles of a leaf. Unused slots hold NaN, so that nothing meets them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// Coordinates by corner and axis (m).
    v: [[[f32; WIDTH]; 3]; 3],
    instance: [u32; WIDTH],
    index: [u32; WIDTH],
    flags: [u32; WIDTH],
}

/// Several vectors, component by component.
pub(super) type Vectors3<F> = [F; 3];

impl Block {
    /// Creates a block of at most [`WIDTH`] triangles.
    pub fn new(triangles: impl ExactSizeIterator<Item = Triangle>) -> Self {
        assert!(triangles.len() <= WIDTH, "more triangles than a leaf holds");
        let mut block = Self {
            v: [[[f32::NAN; WIDTH]; 3]; 3],
            instance: [0; WIDTH],
            index: [0; WIDTH],
            flags: [0; WIDTH],
        };
        for (slot, t) in triangles.enumerate() {
            for (corner, v) in t.v.iter().enumerate() {
                for axis in 0..3 {
                    block.v[corner][axis][slot] = v[axis];
                }
            }
            (block.instance[slot], block.index[slot], block.flags[slot]) = (t.instance, t.index, t.flags);
        }
        block
    }

    /// One of the triangles.
    #[inline(always)]
    pub fn triangle(&self, slot: usize) -> Triangle {
        let v = [0, 1, 2].map(|corner| {
            let axes = &self.v[corner];
            Vec3::new(axes[0][slot], axes[1][slot], axes[2][slot])
        });
        Triangle { v, instance: self.instance[slot], index: self.index[slot], flags: self.flags[slot] }
    }

    /// Computes the quantities of the test for all triangles of the block.
    #[inline(always)]
    pub fn planes<F: F32x8>(&self) -> Planes<F> {
        Planes::new(&each!(|corner| each!(|axis| F::load(&self.v[corner][axis]))))
    }

    /// Interpolates the corners linearly towards those of another block. The bits are those of
    /// [`between`](crate::scene::between).
    #[inline(always)]
    pub fn towards<F: F32x8>(&self, other: &Self, share: f32) -> Self {
        let (of_self, of_other) = (F::splat(1.0 - share), F::splat(share));
        let mut block = *self;
        for corner in 0..3 {
            for axis in 0..3 {
                let (a, b) = (F::load(&self.v[corner][axis]), F::load(&other.v[corner][axis]));
                block.v[corner][axis] = (a * of_self + b * of_other).array();
            }
        }
        block
    }
}

/// Segments or rays, one per lane; all lanes may hold the same segment.
#[derive(Clone, Copy)]
pub(super) struct Lines<F> {
    /// Starts (m).
    pub origin: Vectors3<F>,
    /// Vectors from start to end, or directions to infinity.
    pub direction: Vectors3<F>,
    /// Ends (m); unused for segments to infinity.
    pub target: Vectors3<F>,
}

/// Quantities of triangles that do not depend on the segment.
///
/// # Error of the signed volume `(v₀ − p) · n`
/// A component `n_i` is a difference of two products. Let `P_i` be the sum of their absolute
/// values; then the error of `n_i` is at most `γ₄ P_i` (two differences, a product, a difference).
/// The volume multiplies each by a component of `v₀ − p` (one rounding, and one of the product) and
/// adds them up (two more). Its error is therefore at most
///
/// ```text
/// γ₈ Σ |v₀ − p|_i P_i
/// ```
///
/// The constant below is rounded up, which covers the rounding of the bound itself. Underflow of
/// products adds at most [`UNDERFLOW`] to each component of `n` and to the sum.
///
/// # Error of the edge functions
/// Edge functions are computed relative to the corner `v₀`. With `a = v₀ − o` and `q = a × d` they
/// are
///
/// ```text
/// V = e₂ · q      W = −e₁ · q      U = d · n − V − W
/// ```
///
/// In this form the distance from `o` enters the error only once: no two products with nearly equal
/// corners are subtracted from each other. `V` is a sum of products of three factors `|eᵢ dⱼ aₖ|`
/// with different `i, j, k`, whose total is at most `‖e₂‖_∞ ‖d‖₁ ‖a‖₁`, and has seven roundings.
/// The same holds for `W`. `U` has two roundings more, and those of `d · n`. All errors are below
///
/// ```text
/// 10 u ‖a‖₁ ‖d‖₁ (‖e₁‖_∞ + ‖e₂‖_∞) + 10 u Σ |d|_i P_i
/// ```
#[derive(Clone, Copy)]
pub(super) struct Planes<F> {
    v0: Vectors3<F>,
    /// Two edges from the first corner.
    e: [Vectors3<F>; 2],
    n: Vectors3<F>,
    /// `‖e₁‖_∞ + ‖e₂‖_∞`.
    size: F,
    /// Bound of the error of the volume per unit of length of `v₀ − p`, by component.
    per_length: Vectors3<F>,
}

/// Eight times half the smallest positive `f32`: more than the error of a few sums of products that
/// underflow.
const UNDERFLOW: f32 = f32::from_bits(4);

impl<F: Vector> Planes<F> {
    #[inline(always)]
    fn new(v: &[Vectors3<F>; 3]) -> Self {
        let e = [sub(v[1], v[0]), sub(v[2], v[0])];
        let p = permanent(e[0], e[1]);
        let per_length = each!(|axis| p[axis] * F::splat(gamma(10)) + F::splat(UNDERFLOW));
        Self { v0: v[0], e, n: cross(e[0], e[1]), size: largest(e[0]) + largest(e[1]), per_length }
    }

    /// `(v₀ − p) · n` from `a = v₀ − p`.
    #[inline(always)]
    fn volume(&self, a: Vectors3<F>) -> F {
        dot(a, self.n)
    }

    /// Bound of the error of [`Planes::volume`].
    #[inline(always)]
    fn error(&self, a: Vectors3<F>) -> F {
        dot([a[0].abs(), a[1].abs(), a[2].abs()], self.per_length) + F::splat(UNDERFLOW)
    }

    /// Among the lanes `across` whose segment crosses the plane, returns those in which the line
    /// from `v₀ − a` along `d` meets the triangle; `slope` is `d · n`.
    #[inline(always)]
    fn inside(&self, a: Vectors3<F>, d: Vectors3<F>, slope: F, across: Met) -> Met {
        let q = cross(a, d);
        let second = dot(self.e[1], q);
        let third = F::splat(0.0) - dot(self.e[0], q);
        // `first` is NaN if any of the three is NaN. As the last operand it then makes the minimum
        // and maximum NaN, too.
        let first = slope - second - third;
        let least = second.min(third).min(first);
        let most = second.max(third).max(first);
        let lengths = sum_of_sizes(a) * sum_of_sizes(d) + F::splat(SMALLEST_LENGTHS);
        let of_slope = self.error(d) * F::splat(1.25);
        let error = lengths * self.size * F::splat(gamma(12)) + of_slope + F::splat(f32::MIN_POSITIVE);
        let zero = F::splat(0.0);
        let outside = F::bits((zero - least).min(most).gt(error));
        let certain = across.certain & F::bits(least.max(zero - most).gt(error));
        Met { certain, doubtful: across.any() & !outside & !certain }
    }

    /// Lanes in which two numbers have the same sign, each given with its error bound. The numbers
    /// are `T₀`, and `−T₁` or `d · n`.
    #[inline(always)]
    fn same_sign([start, start_error]: [F; 2], [end, end_error]: [F; 2]) -> Met {
        let (size, end, zero) = (start.abs(), end.flipped_by(start), F::splat(0.0));
        let certain = F::bits((size - start_error).min(end - end_error).gt(zero));
        let possible = F::bits(zero.le((start_error - size).max(end + end_error)));
        Met { certain, doubtful: possible & !certain }
    }
}

impl<F: F32x8> Planes<F> {
    /// Stores the quantities as arrays, from which those of single triangles are taken.
    #[inline(always)]
    pub fn arrays(&self) -> Planes<[f32; WIDTH]> {
        Planes {
            v0: each!(|axis| self.v0[axis].array()),
            e: [each!(|axis| self.e[0][axis].array()), each!(|axis| self.e[1][axis].array())],
            n: each!(|axis| self.n[axis].array()),
            size: self.size.array(),
            per_length: each!(|axis| self.per_length[axis].array()),
        }
    }
}

impl Planes<[f32; WIDTH]> {
    /// Broadcasts the quantities of one triangle to all lanes.
    #[inline(always)]
    pub fn of<F: Vector>(&self, slot: usize) -> Planes<F> {
        Planes {
            v0: each!(|axis| F::splat(self.v0[axis][slot])),
            e: [each!(|axis| F::splat(self.e[0][axis][slot])), each!(|axis| F::splat(self.e[1][axis][slot]))],
            n: each!(|axis| F::splat(self.n[axis][slot])),
            size: F::splat(self.size[slot]),
            per_length: each!(|axis| F::splat(self.per_length[axis][slot])),
        }
    }
}

/// Term added to `‖a‖₁ ‖d‖₁` that covers underflow in components of `q`.
const SMALLEST_LENGTHS: f32 = f32::MIN_POSITIVE * 64.0;

/// Lanes whose segment or ray meets a triangle.
#[derive(Clone, Copy)]
pub(super) struct Met {
    /// Lanes that certainly meet it.
    pub certain: u32,
    /// Lanes that have to be decided by exact arithmetic.
    pub doubtful: u32,
}

impl Met {
    const NOWHERE: Self = Self { certain: 0, doubtful: 0 };

    /// Lanes that certainly or possibly meet it.
    #[inline(always)]
    pub fn any(self) -> u32 {
        self.certain | self.doubtful
    }

    /// Returns true if exact arithmetic has to decide a lane.
    #[inline(always)]
    pub fn is_doubtful_at(self, place: usize) -> bool {
        self.doubtful >> place & 1 != 0
    }
}

/// Lanes whose segment a triangle blocks, by the two rules of [`accel`](crate::accel).
#[inline(always)]
pub(super) fn blocked<F: Vector, const BOUNDED: bool>(planes: &Planes<F>, s: &Lines<F>) -> Met {
    let a = sub(planes.v0, s.origin);
    let start = [planes.volume(a), planes.error(a)];
    let end = if BOUNDED {
        let e = sub(planes.v0, s.target);
        [F::splat(0.0) - planes.volume(e), planes.error(e)]
    } else {
        [planes.volume(s.direction), planes.error(s.direction)]
    };
    let across = Planes::same_sign(start, end);
    if across.any() == 0 {
        return Met::NOWHERE;
    }
    planes.inside(a, s.direction, planes.volume(s.direction), across)
}

/// Lanes whose ray meets a triangle, and the ray parameters, which are valid in the lanes that are
/// certain.
#[inline(always)]
pub(super) fn met<F: Vector>(planes: &Planes<F>, s: &Lines<F>) -> (Met, F) {
    let a = sub(planes.v0, s.origin);
    let start = [planes.volume(a), planes.error(a)];
    let slope = [planes.volume(s.direction), planes.error(s.direction)];
    let across = Planes::same_sign(start, slope);
    if across.any() == 0 {
        return (Met::NOWHERE, start[0]);
    }
    (planes.inside(a, s.direction, slope[0], across), start[0] / slope[0])
}

/// Barycentric weights of the point at which a line meets a triangle, each in `[0, 1]`.
///
/// The computation is in double precision. The point that the weights describe is off the line by
/// some 10⁻¹⁵ times the distance from the origin, divided by the sine of the angle at the first
/// corner and by the cosine of the angle between the line and the normal. Rounding of the weights
/// to single precision adds to that.
pub(super) fn barycentric(origin: Vec3, direction: Vec3, t: &Triangle) -> [f32; 3] {
    let [v0, v1, v2] = t.v.map(Vec3::as_dvec3);
    let d = direction.as_dvec3();
    let (e1, e2) = (v1 - v0, v2 - v0);
    let q = (v0 - origin.as_dvec3()).cross(d);
    let slope = d.dot(e1.cross(e2));
    let (second, third) = (e2.dot(q) / slope, -e1.dot(q) / slope);
    // Comparisons with NaN are false.
    let within = |weight: f64, most: f64| if weight > 0.0 { weight.min(most) } else { 0.0 };
    // The error of each weight grows with the length of the other edge; in a needle one of the
    // weights may be pure noise.
    let (second, third) = if e1.length_squared() < e2.length_squared() {
        let third = within(third, 1.0);
        (within(second, 1.0 - third), third)
    } else {
        let second = within(second, 1.0);
        (second, within(third, 1.0 - second))
    };
    [(1.0 - second - third).max(0.0) as f32, second as f32, third as f32]
}

#[inline(always)]
fn largest<F: Vector>(v: Vectors3<F>) -> F {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

/// `a × b`.
#[inline(always)]
fn cross<F: Vector>(a: Vectors3<F>, b: Vectors3<F>) -> Vectors3<F> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The cross product of absolute values with sums in place of differences.
#[inline(always)]
fn permanent<F: Vector>(a: Vectors3<F>, b: Vectors3<F>) -> Vectors3<F> {
    each!(|i| (a[(i + 1) % 3] * b[(i + 2) % 3]).abs() + (a[(i + 2) % 3] * b[(i + 1) % 3]).abs())
}

#[inline(always)]
fn dot<F: Vector>(a: Vectors3<F>, b: Vectors3<F>) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Sum of the absolute values.
#[inline(always)]
fn sum_of_sizes<F: Vector>(v: Vectors3<F>) -> F {
    v[0].abs() + v[1].abs() + v[2].abs()
}

#[inline(always)]
fn sub<F: Vector>(a: Vectors3<F>, b: Vectors3<F>) -> Vectors3<F> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
