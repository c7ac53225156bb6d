//! 8 lanes in a register of AVX2.

use std::arch::x86_64::{__m128i, __m256, __m256i};

use pulp::bytemuck::cast;
use pulp::x86::V3;

use super::{LANES_8, Lanes8};

/// Proof that the processor has AVX2.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Avx2(pub(crate) V3);

/// Predicate of `a < b`, false where either is NaN, without an exception (`_CMP_LT_OQ`).
const LT_OQ: i32 = 0x11;
/// Predicate of `a <= b` in the same way (`_CMP_LE_OQ`).
const LE_OQ: i32 = 0x12;

impl Lanes8 for Avx2 {
    type F = __m256;
    type I = __m256i;

    lanes! {
        load(self, from: [f32; LANES_8]) -> __m256 = cast(from);
        store(self, a: __m256) -> [f32; LANES_8] = cast(a);
        splat(self, a: f32) -> __m256 = self.0.avx._mm256_set1_ps(a);
        add(self, a: __m256, b: __m256) -> __m256 = self.0.avx._mm256_add_ps(a, b);
        sub(self, a: __m256, b: __m256) -> __m256 = self.0.avx._mm256_sub_ps(a, b);
        mul(self, a: __m256, b: __m256) -> __m256 = self.0.avx._mm256_mul_ps(a, b);
        div(self, a: __m256, b: __m256) -> __m256 = self.0.avx._mm256_div_ps(a, b);
        sqrt(self, a: __m256) -> __m256 = self.0.avx._mm256_sqrt_ps(a);
        min(self, a: __m256, b: __m256) -> __m256 = self.0.avx._mm256_min_ps(a, b);
        max(self, a: __m256, b: __m256) -> __m256 = self.0.avx._mm256_max_ps(a, b);
        lt(self, a: __m256, b: __m256) -> __m256i = cast(self.0.avx._mm256_cmp_ps::<LT_OQ>(a, b));
        le(self, a: __m256, b: __m256) -> __m256i = cast(self.0.avx._mm256_cmp_ps::<LE_OQ>(a, b));
        floor(self, a: __m256) -> __m256 = self.0.avx._mm256_floor_ps(a);
        to_i(self, a: __m256) -> __m256i = self.0.avx._mm256_cvttps_epi32(a);
        to_f(self, a: __m256i) -> __m256 = self.0.avx._mm256_cvtepi32_ps(a);
        to_bits(self, a: __m256) -> __m256i = cast(a);
        from_bits(self, a: __m256i) -> __m256 = cast(a);
        load_i(self, from: [i32; LANES_8]) -> __m256i = cast(from);
        store_i(self, a: __m256i) -> [i32; LANES_8] = cast(a);
        splat_i(self, a: i32) -> __m256i = self.0.avx._mm256_set1_epi32(a);
        add_i(self, a: __m256i, b: __m256i) -> __m256i = self.0.avx2._mm256_add_epi32(a, b);
        sub_i(self, a: __m256i, b: __m256i) -> __m256i = self.0.avx2._mm256_sub_epi32(a, b);
        mul_i(self, a: __m256i, b: __m256i) -> __m256i = self.0.avx2._mm256_mullo_epi32(a, b);
        max_i(self, a: __m256i, b: __m256i) -> __m256i = self.0.avx2._mm256_max_epi32(a, b);
        min_i(self, a: __m256i, b: __m256i) -> __m256i = self.0.avx2._mm256_min_epi32(a, b);
        gt_i(self, a: __m256i, b: __m256i) -> __m256i = self.0.avx2._mm256_cmpgt_epi32(a, b);
        and(self, a: __m256i, b: __m256i) -> __m256i = self.0.avx2._mm256_and_si256(a, b);
        or(self, a: __m256i, b: __m256i) -> __m256i = self.0.avx2._mm256_or_si256(a, b);
        and_not(self, a: __m256i, b: __m256i) -> __m256i = self.0.avx2._mm256_andnot_si256(b, a);
        sign_mask(self, a: __m256i) -> __m256i = self.0.avx2._mm256_srai_epi32::<31>(a);
        to_bitmask(self, mask: __m256i) -> u32 = self.0.avx._mm256_movemask_ps(cast(mask)) as u32;
    }

    #[inline(always)]
    fn transpose(self, [a, b, c, d, e, f, g, h]: [__m256; LANES_8]) -> [__m256; LANES_8] {
        let avx = self.0.avx;
        // Pairs, fours, and the halves of the register.
        let (ab_low, ab_high) = (avx._mm256_unpacklo_ps(a, b), avx._mm256_unpackhi_ps(a, b));
        let (cd_low, cd_high) = (avx._mm256_unpacklo_ps(c, d), avx._mm256_unpackhi_ps(c, d));
        let (ef_low, ef_high) = (avx._mm256_unpacklo_ps(e, f), avx._mm256_unpackhi_ps(e, f));
        let (gh_low, gh_high) = (avx._mm256_unpacklo_ps(g, h), avx._mm256_unpackhi_ps(g, h));
        let first = [
            avx._mm256_shuffle_ps::<0x44>(ab_low, cd_low),
            avx._mm256_shuffle_ps::<0xee>(ab_low, cd_low),
            avx._mm256_shuffle_ps::<0x44>(ab_high, cd_high),
            avx._mm256_shuffle_ps::<0xee>(ab_high, cd_high),
        ];
        let second = [
            avx._mm256_shuffle_ps::<0x44>(ef_low, gh_low),
            avx._mm256_shuffle_ps::<0xee>(ef_low, gh_low),
            avx._mm256_shuffle_ps::<0x44>(ef_high, gh_high),
            avx._mm256_shuffle_ps::<0xee>(ef_high, gh_high),
        ];
        [
            avx._mm256_permute2f128_ps::<0x20>(first[0], second[0]),
            avx._mm256_permute2f128_ps::<0x20>(first[1], second[1]),
            avx._mm256_permute2f128_ps::<0x20>(first[2], second[2]),
            avx._mm256_permute2f128_ps::<0x20>(first[3], second[3]),
            avx._mm256_permute2f128_ps::<0x31>(first[0], second[0]),
            avx._mm256_permute2f128_ps::<0x31>(first[1], second[1]),
            avx._mm256_permute2f128_ps::<0x31>(first[2], second[2]),
            avx._mm256_permute2f128_ps::<0x31>(first[3], second[3]),
        ]
    }

    #[inline(always)]
    fn shift_right<const BITS: i32>(self, a: __m256i) -> __m256i {
        self.0.avx2._mm256_srli_epi32::<BITS>(a)
    }

    #[inline(always)]
    fn shift_right_signed<const BITS: i32>(self, a: __m256i) -> __m256i {
        self.0.avx2._mm256_srai_epi32::<BITS>(a)
    }

    #[inline(always)]
    fn gather_columns(self, [a, b, c, d, e, f, g, h]: [&[i32; 4]; LANES_8]) -> [__m256i; 4] {
        // Two rows a register, so that what follows need not cross its halves.
        let (a, b) = (self.join(a, e), self.join(b, f));
        let (c, d) = (self.join(c, g), self.join(d, h));
        let avx2 = self.0.avx2;
        let (ab_low, ab_high) =
            (avx2._mm256_unpacklo_epi32(a, b), avx2._mm256_unpackhi_epi32(a, b));
        let (cd_low, cd_high) =
            (avx2._mm256_unpacklo_epi32(c, d), avx2._mm256_unpackhi_epi32(c, d));
        [
            avx2._mm256_unpacklo_epi64(ab_low, cd_low),
            avx2._mm256_unpackhi_epi64(ab_low, cd_low),
            avx2._mm256_unpacklo_epi64(ab_high, cd_high),
            avx2._mm256_unpackhi_epi64(ab_high, cd_high),
        ]
    }

    #[inline(always)]
    fn scatter_columns(self, [a, b, c, d]: [__m256i; 4], out: &mut [[i32; 4]; LANES_8]) {
        let avx2 = self.0.avx2;
        // Each half of 128 bits is a transposition of 4x4 by itself.
        let (ab_low, ab_high) =
            (avx2._mm256_unpacklo_epi32(a, b), avx2._mm256_unpackhi_epi32(a, b));
        let (cd_low, cd_high) =
            (avx2._mm256_unpacklo_epi32(c, d), avx2._mm256_unpackhi_epi32(c, d));
        let first = avx2._mm256_unpacklo_epi64(ab_low, cd_low);
        let second = avx2._mm256_unpackhi_epi64(ab_low, cd_low);
        let third = avx2._mm256_unpacklo_epi64(ab_high, cd_high);
        let fourth = avx2._mm256_unpackhi_epi64(ab_high, cd_high);
        out[0] = cast(avx2._mm256_extracti128_si256::<0>(first));
        out[1] = cast(avx2._mm256_extracti128_si256::<0>(second));
        out[2] = cast(avx2._mm256_extracti128_si256::<0>(third));
        out[3] = cast(avx2._mm256_extracti128_si256::<0>(fourth));
        out[4] = cast(avx2._mm256_extracti128_si256::<1>(first));
        out[5] = cast(avx2._mm256_extracti128_si256::<1>(second));
        out[6] = cast(avx2._mm256_extracti128_si256::<1>(third));
        out[7] = cast(avx2._mm256_extracti128_si256::<1>(fourth));
    }

    #[inline(always)]
    fn select(self, mask: __m256i, a: __m256i, b: __m256i) -> __m256i {
        self.0.avx2._mm256_blendv_epi8(b, a, mask)
    }
}

impl Avx2 {
    /// Both halves of a register, each loaded by itself: joined in memory first, the load would
    /// wait for the stores.
    #[inline(always)]
    fn join(self, low: &[i32; 4], high: &[i32; 4]) -> __m256i {
        let low: __m128i = cast(*low);
        self.0
            .avx2
            ._mm256_inserti128_si256::<1>(self.0.avx._mm256_castsi128_si256(low), cast(*high))
    }
}
