//! What `fearless_simd` has no name for. The only `unsafe` code of the project.
#![allow(unsafe_code)]

use fearless_simd::{Fallback, Simd};

use super::apart;

/// Bytes that a processor of today moves at once.
#[cfg(target_arch = "x86_64")]
const CACHE_LINE: usize = 64;

/// Instructions that a function can be compiled for.
pub trait Instructions: Simd {
    /// Runs `f`, compiled for these instructions, in a function of its own. Everything that `f` calls must be inlined.
    ///
    /// [`Simd::vectorize`] would be inlined where it is called once: what is rare would take the registers from the loop
    /// that calls it.
    fn apart<R>(self, f: impl FnOnce() -> R) -> R;

    /// Asks for a value to be brought near, if the level can; a hint without any other effect.
    fn prefetch<T>(self, slice: &[T], index: usize);
}

impl Instructions for Fallback {
    #[inline(always)]
    fn apart<R>(self, f: impl FnOnce() -> R) -> R {
        apart(f)
    }

    #[inline(always)]
    fn prefetch<T>(self, _: &[T], _: usize) {}
}

/// Implements [`Instructions`] for a token of `fearless_simd`, with the features that it stands for.
macro_rules! instructions {
    ($token:ty, $features:literal) => {
        impl Instructions for $token {
            #[inline(always)]
            fn apart<R>(self, f: impl FnOnce() -> R) -> R {
                #[inline(never)]
                #[target_feature(enable = $features)]
                fn compiled<R>(f: impl FnOnce() -> R) -> R {
                    f()
                }
                // SAFETY: a token exists only where the processor has these features.
                unsafe { compiled(f) }
            }

            #[inline(always)]
            fn prefetch<T>(self, slice: &[T], index: usize) {
                #[cfg(target_arch = "x86_64")]
                {
                    use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
                    let start = slice.as_ptr().wrapping_add(index).cast::<i8>();
                    let mut at = 0;
                    while at < size_of::<T>() {
                        // SAFETY: a prefetch reads nothing that the program sees, and never faults.
                        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(at)) };
                        at += CACHE_LINE;
                    }
                }
                #[cfg(not(target_arch = "x86_64"))]
                let _ = (slice, index);
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
instructions!(fearless_simd::Sse4_2, "fxsr,sse4.2,cmpxchg16b,popcnt");
#[cfg(target_arch = "x86_64")]
instructions!(fearless_simd::Avx2, "avx2,bmi1,bmi2,cmpxchg16b,f16c,fma,fxsr,lzcnt,movbe,popcnt,xsave");
#[cfg(has_avx512)]
instructions!(
    fearless_simd::Avx512,
    "adx,aes,avx512bitalg,avx512bw,avx512cd,avx512dq,avx512f,avx512ifma,avx512vbmi,avx512vbmi2,avx512vl,avx512vnni,avx512vpopcntdq,bmi1,bmi2,cmpxchg16b,fma,fxsr,gfni,lzcnt,movbe,pclmulqdq,popcnt,rdrand,rdseed,sha,vaes,vpclmulqdq,xsave,xsavec,xsaveopt,xsaves"
);
#[cfg(target_arch = "aarch64")]
instructions!(fearless_simd::Neon, "neon");
