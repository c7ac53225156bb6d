//! 16 lanes in two registers of AVX2, with FMA: the instructions of the 8 lanes, twice.

use std::arch::x86_64::{__m256, _MM_HINT_T1, _mm_prefetch, _mm256_loadu_ps, _mm256_storeu_ps};

use pulp::x86::V3;

use super::Lanes16;
use crate::lanes8::Lanes8 as _;
use crate::lanes8::avx2::Avx2;

/// Two registers of eight `f32`.
#[derive(Clone, Copy)]
pub(crate) struct Ymm2(__m256, __m256);

/// Operations of one register.
// SAFETY: whoever calls a method of `Lanes16` vouches for the instructions.
const YMM: Avx2 = Avx2(unsafe { V3::new_unchecked() });

/// Operations of two vectors, register by register.
macro_rules! binary {
    ($($name:ident),*) => {$(
        #[inline(always)]
        unsafe fn $name(self, other: Self) -> Self {
            Self(YMM.$name(self.0, other.0), YMM.$name(self.1, other.1))
        }
    )*};
}

// SAFETY of all: the contract of `Lanes16` is that of the instructions.
impl Lanes16 for Ymm2 {
    // 12 of 16 registers.
    const TILE: [usize; 2] = [6, 3];

    binary!(add, sub, mul, max, min);

    #[inline(always)]
    unsafe fn splat(value: f32) -> Self {
        let value = YMM.splat(value);
        Self(value, value)
    }

    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        unsafe { Self(_mm256_loadu_ps(from), _mm256_loadu_ps(from.add(8))) }
    }

    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe {
            _mm256_storeu_ps(to, self.0);
            _mm256_storeu_ps(to.add(8), self.1);
        }
    }

    #[inline(always)]
    unsafe fn mul_add(self, factor: Self, term: Self) -> Self {
        let fma = YMM.0.fma;
        Self(
            fma._mm256_fmadd_ps(self.0, factor.0, term.0),
            fma._mm256_fmadd_ps(self.1, factor.1, term.1),
        )
    }

    #[inline(always)]
    unsafe fn prefetch(from: *const f32) {
        unsafe { _mm_prefetch::<_MM_HINT_T1>(from.cast()) }
    }
}
