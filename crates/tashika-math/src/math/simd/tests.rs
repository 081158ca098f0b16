//! Vectors of every level compared with plain arrays.

use super::*;
use crate::rng::{Purpose, Stream};

/// Sixteen random numbers of all kinds: zeros of both signs, infinities, NaN, ordinary numbers.
/// Some are equal.
fn numbers(s: &mut Stream) -> [f32; 16] {
    let special = [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1.0, -1.0, f32::MIN_POSITIVE];
    std::array::from_fn(|_| match s.below(3) {
        0 => special[s.below(special.len() as u64) as usize],
        _ => (s.uniform() - 0.5) * 4.0,
    })
}

/// Results of operations on sixteen pairs of numbers: bits of numbers, and masks.
#[derive(Debug, Default, PartialEq)]
struct Results {
    numbers: Vec<Vec<u32>>,
    masks: Vec<(u32, bool)>,
}

/// Applies every operation to sixteen pairs of numbers, one vector of pairs at a time.
#[inline(always)]
fn results<F: Vector>(a: &[f32; 16], b: &[f32; 16]) -> Results {
    let mut results = Results::default();
    for first in (0..16).step_by(F::LANES) {
        let (a, b) = (F::load_from(&a[first..]), F::load_from(&b[first..]));
        let (le, gt) = (a.le(b), a.gt(b));
        let (m, e) = (a.abs() + F::splat(f32::MIN_POSITIVE)).mantissa_and_exponent();
        let power = (b.flipped_by(a) * F::splat(60.0)).max(F::splat(-126.0)).min(F::splat(127.0));
        let of_mask = F::select(F::mask(0x5ac3), a, b);
        let contracted = a * b + b;
        let all = [
            a + b,
            a - b,
            a * b,
            a / b,
            a.min(b),
            a.max(b),
            a.abs(),
            a.sqrt(),
            a.flipped_by(b),
            F::splat(2.5),
            F::select(le, a, b),
            m,
            e,
            power.exp2_of_integer(),
            of_mask,
            contracted,
            F::load(&a.array()),
        ];
        results.numbers.resize(all.len(), Vec::new());
        for (row, vector) in results.numbers.iter_mut().zip(all) {
            let mut stored = [0.0; MOST_LANES];
            vector.store_to(&mut stored);
            // All NaN count as equal: their payloads may differ.
            let bits = |x: &f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
            row.extend(stored[..F::LANES].iter().map(bits));
        }
        let mut some = [7.0; 5];
        (a + b).store_to(&mut some);
        results.numbers.push(some.map(f32::to_bits).to_vec());
        let both = F::and(le, F::splat(0.5).gt(a));
        let given = F::mask(0xb2c5 >> first & ((1 << F::LANES) - 1));
        for mask in [le, gt, both, given, F::mask(0)] {
            results.masks.push((F::bits(mask), F::any(mask)));
        }
    }
    results
}

/// The results of vectors of eight and of sixteen numbers, and of the widest.
struct All<'a>(&'a [f32; 16], &'a [f32; 16]);

impl Work for All<'_> {
    type Output = [Results; 3];

    #[inline(always)]
    fn run<V: Vectors>(self) -> [Results; 3] {
        let All(a, b) = self;
        [results::<V::Eight>(a, b), results::<V::Sixteen>(a, b), results::<V::Widest>(a, b)]
    }
}

#[test]
fn vectors_are_their_scalar_twins() {
    let mut s = Stream::new(1, Purpose::Test, 0);
    for _ in 0..10_000 {
        let (a, b) = (numbers(&mut s), numbers(&mut s));
        // A sum that holds NaN is stored as it is; its payload may differ.
        let finite = a.map(|x| if x.is_finite() { x } else { 3.0 });
        let b = b.map(|x| if x.is_nan() { 0.25 } else { x });
        let eight = results::<Portable<8>>(&finite, &b);
        let sixteen = results::<Portable<16>>(&finite, &b);
        for level in Level::all() {
            let [of_eight, of_sixteen, widest] = level.run(All(&finite, &b));
            assert_eq!(of_eight, eight, "{level:?}: {finite:?} and {b:?}");
            assert_eq!(of_sixteen, sixteen, "{level:?}: {finite:?} and {b:?}");
            assert!(widest == eight || widest == sixteen, "{level:?}: {finite:?} and {b:?}");
        }
    }
}

/// NaN is never less and never greater; a minimum or maximum with a NaN is its second argument.
#[test]
fn vectors_treat_nan_as_their_scalar_twins_do() {
    struct Nan;
    impl Work for Nan {
        type Output = [[u32; 16]; 2];

        #[inline(always)]
        fn run<V: Vectors>(self) -> Self::Output {
            #[inline(always)]
            fn of<F: Vector>(array: impl Fn(F) -> [f32; 16]) -> [u32; 16] {
                let nan = F::splat(f32::NAN);
                let one = F::splat(1.0);
                let masks = [nan.le(one), one.le(nan), nan.gt(one), one.gt(nan), nan.le(nan), nan.gt(nan)];
                let numbers = [nan.min(one), one.min(nan), nan.max(one), one.max(nan)];
                let mut all = [0; 16];
                for (to, mask) in all.iter_mut().zip(masks) {
                    *to = F::bits(mask);
                }
                for (to, vector) in all[6..].iter_mut().zip(numbers) {
                    *to = u32::from(array(vector)[0].is_nan());
                }
                all
            }
            let of_eight = of::<V::Eight>(|v| std::array::from_fn(|i| v.array()[i % 8]));
            [of_eight, of::<V::Sixteen>(|v| v.array())]
        }
    }
    let expected = [0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0];
    for level in Level::all() {
        assert_eq!(level.run(Nan), [expected; 2], "{level:?}");
    }
}

#[test]
fn the_best_level_comes_first_and_arrays_last() {
    let all = Level::all();
    assert_eq!(all.first(), Some(&Level::best()));
    assert_eq!(all.last(), Some(&Level::PORTABLE));
    let differ = all.iter().enumerate().all(|(i, a)| all[..i].iter().all(|b| a != b));
    assert!(differ, "{all:?}");
}

#[test]
fn a_number_is_its_mantissa_times_a_power_of_two() {
    let mut s = Stream::new(2, Purpose::Test, 0);
    for _ in 0..10_000 {
        let x = f32::from_bits(1 << 23 | s.below(254 << 23) as u32);
        let (m, e) = x.mantissa_and_exponent();
        assert!((0.707..1.4143).contains(&m), "{x:e}: {m}");
        assert_eq!(
            f64::from(m)
                * f64::from((e * 0.5).floor().exp2_of_integer())
                * f64::from((e - (e * 0.5).floor()).exp2_of_integer()),
            f64::from(x)
        );
    }
}
