//! One number or several at once, on several instruction sets.
//!
//! [`Real`] has the operations of formulas that are written once, for a single number and for
//! vectors. [`Vector`] adds loads, stores and masks. Every operation is a single IEEE operation, a
//! selection, or an exact change of bits, and no product is fused with a sum. All implementations
//! therefore give the same bits. `portable` implements vectors as plain arrays; `tests` compares
//! the other implementations with it.
//!
//! Code for vectors implements [`Work`] and is generic over [`Vectors`]. It is run by a [`Level`],
//! which only the detection of an instruction set can create: see `level`.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod level;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg_attr(not(any(target_arch = "x86_64", target_arch = "aarch64")), expect(dead_code))]
mod pair;
mod portable;
mod prefetch;
mod real;
#[cfg(test)]
mod tests;

pub use level::{Level, Work};
pub use portable::Portable;
pub use prefetch::prefetch;
pub use real::{F32x8, F32x16, Real, Vector, Vectors};

/// Number of boxes of a node, and of triangles of a leaf.
pub const WIDTH: usize = 8;

/// Largest number of lanes of a vector.
pub const MOST_LANES: usize = 16;

/// Array of the values of an expression for 0, 1 and 2. A macro, since a closure may become a
/// separate function, which is not compiled for the instruction set of its caller.
#[macro_export]
#[doc(hidden)]
macro_rules! each {
    (|$axis:ident| $value:expr) => {
        [
            {
                let $axis = 0;
                $value
            },
            {
                let $axis = 1;
                $value
            },
            {
                let $axis = 2;
                $value
            },
        ]
    };
}
pub use each;

/// Runs a block for each bit that is set, from the lowest; `below` is the number of bits, a power
/// of two. A macro for the same reason as [`each`].
#[macro_export]
#[doc(hidden)]
macro_rules! for_bits {
    ($bits:expr, below $below:expr, |$bit:ident| $body:block) => {
        let mut rest: u32 = $bits;
        while rest != 0 {
            let $bit = rest.trailing_zeros() as usize & ($below - 1);
            rest &= rest - 1;
            $body
        }
    };
}
pub use for_bits;
