//! Which instructions trees are built and rays are traced with: the best there are, or a forced level, passed on as a
//! value.
//!
//! The vectors are those of `fearless_simd`: the same code for every level, compiled once for each. Every operation used
//! here rounds as its scalar twin does and no multiplication is fused with an addition, so all levels give the same
//! answers and count the same visits, bit for bit.

mod instructions;

use fearless_simd::{Fallback, Level, SimdFloat, prelude::*};

use super::config::BuildConfig;

pub use instructions::Instructions;

/// A set of instructions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SimdLevel {
    /// The best that the processor has.
    #[default]
    Auto,
    Scalar,
    #[serde(rename = "sse4.2")]
    Sse42,
    /// With FMA (which is not used), BMI and POPCNT.
    Avx2,
    /// That of Ice Lake and later. Left out of development builds on machines without it (`build.rs`).
    Avx512,
    Neon,
}

impl SimdLevel {
    pub const ALL: [Self; 6] = [Self::Auto, Self::Scalar, Self::Sse42, Self::Avx2, Self::Avx512, Self::Neon];

    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Scalar => "scalar",
            Self::Sse42 => "sse4.2",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
            Self::Neon => "neon",
        }
    }

    /// One line for lists and tooltips.
    pub fn description(self) -> &'static str {
        match self {
            Self::Auto => "the best that the processor has",
            Self::Scalar => "one number at a time, as far as the compiler keeps to it",
            Self::Sse42 => "four numbers at a time, on x86",
            Self::Avx2 => "eight numbers at a time, on x86 from about 2013 on",
            Self::Avx512 => "the newer instructions for eight numbers, on x86 from Ice Lake and Zen 4 on",
            Self::Neon => "four numbers at a time, on ARM",
        }
    }

    /// Whether this processor has it.
    pub fn is_available(self) -> bool {
        SimdToken::new(self).is_some()
    }
}

/// Proof that a level is there.
#[derive(Clone, Copy, Debug)]
pub enum SimdToken {
    Scalar(Fallback),
    #[cfg(target_arch = "x86_64")]
    Sse42(fearless_simd::Sse4_2),
    #[cfg(target_arch = "x86_64")]
    Avx2(fearless_simd::Avx2),
    #[cfg(has_avx512)]
    Avx512(fearless_simd::Avx512),
    #[cfg(target_arch = "aarch64")]
    Neon(fearless_simd::Neon),
}

impl SimdToken {
    /// `None` if this processor does not have that level.
    pub fn new(level: SimdLevel) -> Option<Self> {
        let found = Level::new();
        match level {
            SimdLevel::Auto => {
                [SimdLevel::Neon, SimdLevel::Avx512, SimdLevel::Avx2, SimdLevel::Sse42, SimdLevel::Scalar]
                    .into_iter()
                    .find_map(Self::new)
            }
            SimdLevel::Scalar => Some(Self::Scalar(Fallback::new())),
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Sse42 => found.as_sse4_2().map(Self::Sse42),
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx2 => found.as_avx2().map(Self::Avx2),
            #[cfg(has_avx512)]
            SimdLevel::Avx512 => found.as_avx512().map(Self::Avx512),
            #[cfg(not(has_avx512))]
            SimdLevel::Avx512 => None,
            #[cfg(target_arch = "aarch64")]
            SimdLevel::Neon => found.as_neon().map(Self::Neon),
            #[cfg(not(target_arch = "x86_64"))]
            SimdLevel::Sse42 | SimdLevel::Avx2 => None,
            #[cfg(not(target_arch = "aarch64"))]
            SimdLevel::Neon => None,
        }
    }

    /// The level of a checked build configuration; the best there is if the processor does not have it.
    pub fn of(config: &BuildConfig) -> Self {
        let found = Self::new(config.simd).or_else(|| Self::new(SimdLevel::Auto));
        found.unwrap_or(Self::Scalar(Fallback::new()))
    }

    pub fn level(self) -> SimdLevel {
        match self {
            Self::Scalar(_) => SimdLevel::Scalar,
            #[cfg(target_arch = "x86_64")]
            Self::Sse42(_) => SimdLevel::Sse42,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => SimdLevel::Avx2,
            #[cfg(has_avx512)]
            Self::Avx512(_) => SimdLevel::Avx512,
            #[cfg(target_arch = "aarch64")]
            Self::Neon(_) => SimdLevel::Neon,
        }
    }
}

/// Keeps the code for a rare level out of its caller.
#[inline(never)]
pub fn apart<R>(run: impl FnOnce() -> R) -> R {
    run()
}

/// Runs an expression compiled for a level, with its token.
#[macro_export]
macro_rules! at_level {
    ($simd:expr, $token:ident => $body:expr) => {
        match $simd {
            $crate::accel::simd::SimdToken::Scalar($token) => $crate::accel::simd::apart(|| $body),
            #[cfg(target_arch = "x86_64")]
            $crate::accel::simd::SimdToken::Sse42($token) => fearless_simd::Simd::vectorize(
                $token,
                #[inline(always)]
                || $body,
            ),
            #[cfg(target_arch = "x86_64")]
            $crate::accel::simd::SimdToken::Avx2($token) => fearless_simd::Simd::vectorize(
                $token,
                #[inline(always)]
                || $body,
            ),
            #[cfg(has_avx512)]
            $crate::accel::simd::SimdToken::Avx512($token) => fearless_simd::Simd::vectorize(
                $token,
                #[inline(always)]
                || $body,
            ),
            #[cfg(target_arch = "aarch64")]
            $crate::accel::simd::SimdToken::Neon($token) => fearless_simd::Simd::vectorize(
                $token,
                #[inline(always)]
                || $body,
            ),
        }
    };
}

/// In every lane `a` where it is greater, else `b`: also where `a` is NaN.
#[inline(always)]
pub fn greater_or<S: fearless_simd::Simd, V: SimdFloat<S, Element = f32>>(simd: S, a: V, b: V) -> V {
    if max_takes_second(simd) { a.max(b) } else { a.simd_gt(b).select(a, b) }
}

/// In every lane `a` where it is less, else `b`: also where `a` is NaN.
#[inline(always)]
pub fn less_or<S: fearless_simd::Simd, V: SimdFloat<S, Element = f32>>(simd: S, a: V, b: V) -> V {
    if max_takes_second(simd) { a.min(b) } else { a.simd_lt(b).select(a, b) }
}

/// Whether the level's `max` and `min` answer the second operand when one is NaN or both are zeros: those of x86 do.
#[inline(always)]
fn max_takes_second<S: fearless_simd::Simd>(simd: S) -> bool {
    cfg!(target_arch = "x86_64") && !simd.level().is_fallback()
}
