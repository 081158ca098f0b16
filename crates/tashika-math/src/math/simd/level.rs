//! Instruction sets, and running work that is compiled for each of them.
//!
//! A [`Level`] is evidence: it holds the token of its instruction set, and tokens are made by
//! looking for the set in the machine and in no other way. The vectors of a set cannot be named
//! outside of `simd`, but for plain arrays: [`Work::run`] gets them as a type, from a level. So what
//! is safe can neither claim that the machine has a set nor use the vectors of one that it lacks.

use std::sync::OnceLock;

use super::portable::PortableVectors;
use super::real::Vectors;

/// Work that is compiled for every instruction set.
pub trait Work {
    /// What comes of it; the same bits on every set.
    type Output;

    /// Does it. Has to be `#[inline(always)]`, as all that works on vectors below it: a function of
    /// its own is not compiled for the instruction set of its caller.
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
    /// What every machine has.
    pub const PORTABLE: Self = Self(Set::Portable);

    /// The best that this machine has, looked for once.
    #[inline]
    pub fn best() -> Self {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| Self::all()[0])
    }

    /// All that this machine has, the best first.
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

    /// Does some work with the vectors of this set.
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

/// A token of an instruction set: what finds it, and what is compiled for it.
macro_rules! token {
    ($vectors:ty, $detected:ident: $($feature:tt),*) => {
        /// Evidence that the machine has this instruction set: only [`Token::detect`] makes it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) struct Token(());

        impl Token {
            /// Looks for the set.
            pub fn detect() -> Option<Self> {
                let found = true $(&& std::arch::$detected!($feature))*;
                found.then_some(Self(()))
            }

            /// Does some work, compiled for the set.
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
