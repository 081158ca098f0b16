//! Reads ahead.

/// Hints that a value will be read soon. On processors without such an instruction, it does
/// nothing.
#[inline(always)]
pub fn prefetch<T>(what: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};

        /// Size of a line of the processor's cache (bytes).
        const CACHE_LINE: usize = 64;

        let begin = std::ptr::from_ref(what).cast::<i8>();
        for line in 0..size_of::<T>().div_ceil(CACHE_LINE) {
            // SAFETY: every processor of this architecture has the instruction, which reads nothing
            // that the program sees, wherever it points.
            #[allow(unsafe_code, reason = "an instruction without a safe function")]
            unsafe {
                _mm_prefetch::<_MM_HINT_T0>(begin.wrapping_add(line * CACHE_LINE));
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = what;
}
