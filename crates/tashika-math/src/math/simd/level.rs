//! Instruction sets, and work that is compiled for each of them.
//!
//! A [`Level`] proves that the machine has an instruction set: it holds a token, which only the
//! detection of the set can create. Outside of `simd` the vector types of a set cannot be named,
//! except plain arrays: a level passes them to [`Work::run`] as a type parameter. Safe code
//! therefore cannot use the vectors of a set that the machine lacks.

use std::sync::OnceLock;

use super::portable::PortableVectors;
use super::real::Vectors;

/// Work that is compiled for every instruction set.
pub trait Work {
    /// Result of the work; the same bits on every set.
    type Output;

    /// Does the work. It has to be `#[inline(always)]`, and so has every function on vectors that
    /// it calls: a separate function is not compiled for the instruction set of its caller.
    fn run<V: Vectors>(self) -> Self::Output;
}

/// An instruction set that this machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(Set);

/// The sets, each with the evidence that the machine has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(super::avx2::Token),
    #[cfg(target_arch = "x86_64")]
    Avx512(super::avx512::Token),
    #[cfg(target_arch = "aarch64")]
    Neon(super::neon::Token),
}

impl Level {
    /// Plain arrays, which every machine has.
    pub const PORTABLE: Self = Self(Set::Portable);

    /// The best level of this machine, detected once.
    #[inline]
    pub fn best() -> Self {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| Self::all()[0])
    }

    /// All levels of this machine, the best first.
    pub fn all() -> Vec<Self> {
        let mut sets = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            sets.extend(super::avx512::Token::detect().map(Set::Avx512));
            sets.extend(super::avx2::Token::detect().map(Set::Avx2));
        }
        #[cfg(target_arch = "aarch64")]
        sets.extend(super::neon::Token::detect().map(Set::Neon));
        sets.push(Set::Portable);
        sets.into_iter().map(Self).collect()
    }

    /// Runs some work with the vectors of this set.
    #[inline]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        match self.0 {
            Set::Portable => work.run::<PortableVectors>(),
            #[cfg(target_arch = "x86_64")]
            Set::Avx2(token) => token.run(work),
            #[cfg(target_arch = "x86_64")]
            Set::Avx512(token) => token.run(work),
            #[cfg(target_arch = "aarch64")]
            Set::Neon(token) => token.run(work),
        }
    }
}

/// Token of an instruction set: its detection, and the code that is compiled for the set.
macro_rules! token {
    ($vectors:ty, $detected:ident: $($feature:tt),*) => {
        /// Evidence that the machine has this instruction set: only [`Token::detect`] makes it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) struct Token(());

        impl Token {
            /// Detects the set on this machine.
            pub fn detect() -> Option<Self> {
                let found = true $(&& std::arch::$detected!($feature))*;
                found.then_some(Self(()))
            }

            /// Runs some work, compiled for the set.
            #[inline]
            pub fn run<W: $crate::math::simd::Work>(self, work: W) -> W::Output {
                $(#[target_feature(enable = $feature)])*
                fn compiled<W: $crate::math::simd::Work>(work: W) -> W::Output {
                    work.run::<$vectors>()
                }
                // SAFETY: a token is made only where all of these features were found.
                unsafe { compiled(work) }
            }
        }
    };
}
pub(super) use token;
