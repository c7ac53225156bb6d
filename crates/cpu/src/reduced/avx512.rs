//! Dot products of two bfloat16 values or four bytes, with the extensions of AVX-512 for them.

use std::arch::x86_64::{
    __m512, __m512bh, __m512i, _mm_loadu_si128, _mm512_broadcast_i32x4, _mm512_cvtepi32_ps,
    _mm512_dpbf16_ps, _mm512_dpbusd_epi32, _mm512_loadu_si512, _mm512_permutexvar_epi32,
    _mm512_set1_epi32, _mm512_setzero_ps, _mm512_setzero_si512, _mm512_shuffle_epi8,
};
use std::mem::transmute;

use super::{Bf16, DotProduct};
use crate::lanes16::avx512::Zmm;

/// Pixels of a register tile: products take their values from a register, and beside the
/// accumulators of twelve pixels and two blocks there are too few registers to load them ahead.
const TILE: [usize; 2] = [12, 10];

/// Four unsigned bytes by four signed ones (`vpdpbusd`), with AVX512-VNNI.
pub(super) struct Vnni;

impl DotProduct for Vnni {
    type Element = u8;
    type Lanes = Zmm;
    type Accumulator = __m512i;
    type Weights = __m512i;
    type Values = __m512i;
    const DEPTH: usize = 4;
    const TILE: [usize; 2] = TILE;
    const HAS_PIXEL_ROWS: bool = true;

    #[inline(always)]
    unsafe fn zero() -> __m512i {
        unsafe { _mm512_setzero_si512() }
    }

    #[inline(always)]
    unsafe fn weights(from: *const u8) -> __m512i {
        unsafe { _mm512_loadu_si512(from.cast()) }
    }

    #[inline(always)]
    unsafe fn values(from: *const u8) -> __m512i {
        unsafe { _mm512_set1_epi32(from.cast::<i32>().read_unaligned()) }
    }

    #[inline(always)]
    unsafe fn add(acc: __m512i, values: __m512i, weights: __m512i) -> __m512i {
        unsafe { _mm512_dpbusd_epi32(acc, values, weights) }
    }

    #[inline(always)]
    unsafe fn to_f32(acc: __m512i) -> Zmm {
        unsafe { Zmm(_mm512_cvtepi32_ps(acc)) }
    }

    #[inline(always)]
    unsafe fn pixel_row(from: *const u8) -> __m512i {
        // Four channels of every pixel go to each of four lanes, then change places in it.
        const LANES: [i32; 16] = [0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15];
        const BYTES: [i32; 4] = [0x0C08_0400, 0x0D09_0501, 0x0E0A_0602, 0x0F0B_0703];
        unsafe {
            let lanes = _mm512_loadu_si512(LANES.as_ptr().cast());
            let bytes = _mm512_broadcast_i32x4(_mm_loadu_si128(BYTES.as_ptr().cast()));
            let pixels = _mm512_loadu_si512(from.cast());
            _mm512_shuffle_epi8(_mm512_permutexvar_epi32(lanes, pixels), bytes)
        }
    }
}

/// The bits of a register as 32 bfloat16 values.
#[inline(always)]
fn as_bf16(bits: __m512i) -> __m512bh {
    // SAFETY: registers of one size, of which any bits are valid.
    unsafe { transmute::<__m512i, __m512bh>(bits) }
}

/// Two bfloat16 values by two (`vdpbf16ps`), with AVX512-BF16.
pub(super) struct Avx512Bf16;

impl DotProduct for Avx512Bf16 {
    type Element = Bf16;
    type Lanes = Zmm;
    type Accumulator = __m512;
    type Weights = __m512i;
    type Values = __m512i;
    const DEPTH: usize = 2;
    const TILE: [usize; 2] = TILE;

    #[inline(always)]
    unsafe fn zero() -> __m512 {
        unsafe { _mm512_setzero_ps() }
    }

    #[inline(always)]
    unsafe fn weights(from: *const u8) -> __m512i {
        unsafe { _mm512_loadu_si512(from.cast()) }
    }

    #[inline(always)]
    unsafe fn values(from: *const Bf16) -> __m512i {
        unsafe { _mm512_set1_epi32(from.cast::<i32>().read_unaligned()) }
    }

    #[inline(always)]
    unsafe fn add(acc: __m512, values: __m512i, weights: __m512i) -> __m512 {
        unsafe { _mm512_dpbf16_ps(acc, as_bf16(values), as_bf16(weights)) }
    }

    #[inline(always)]
    unsafe fn to_f32(acc: __m512) -> Zmm {
        Zmm(acc)
    }
}
