//! 8 lanes in an array, for the baseline of the target; the reference of the tests.

use std::array::from_fn;

use super::{LANES_8, Lanes8};

/// Any processor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Portable;

#[inline(always)]
fn mask(is_set: bool) -> i32 {
    -i32::from(is_set)
}

impl Lanes8 for Portable {
    type F = [f32; LANES_8];
    type I = [i32; LANES_8];

    lanes! {
        load(self, from: [f32; LANES_8]) -> Self::F = from;
        store(self, a: Self::F) -> [f32; LANES_8] = a;
        add(self, a: Self::F, b: Self::F) -> Self::F = from_fn(|k| a[k] + b[k]);
        sub(self, a: Self::F, b: Self::F) -> Self::F = from_fn(|k| a[k] - b[k]);
        mul(self, a: Self::F, b: Self::F) -> Self::F = from_fn(|k| a[k] * b[k]);
        div(self, a: Self::F, b: Self::F) -> Self::F = from_fn(|k| a[k] / b[k]);
        sqrt(self, a: Self::F) -> Self::F = a.map(f32::sqrt);
        lt(self, a: Self::F, b: Self::F) -> Self::I = from_fn(|k| mask(a[k] < b[k]));
        le(self, a: Self::F, b: Self::F) -> Self::I = from_fn(|k| mask(a[k] <= b[k]));
        floor(self, a: Self::F) -> Self::F = a.map(f32::floor);
        to_i(self, a: Self::F) -> Self::I = a.map(|a| a as i32);
        to_f(self, a: Self::I) -> Self::F = a.map(|a| a as f32);
        to_bits(self, a: Self::F) -> Self::I = a.map(|a| a.to_bits() as i32);
        from_bits(self, a: Self::I) -> Self::F = a.map(|a| f32::from_bits(a as u32));
        load_i(self, from: [i32; LANES_8]) -> Self::I = from;
        store_i(self, a: Self::I) -> [i32; LANES_8] = a;
        add_i(self, a: Self::I, b: Self::I) -> Self::I = from_fn(|k| a[k].wrapping_add(b[k]));
        sub_i(self, a: Self::I, b: Self::I) -> Self::I = from_fn(|k| a[k].wrapping_sub(b[k]));
        mul_i(self, a: Self::I, b: Self::I) -> Self::I = from_fn(|k| a[k].wrapping_mul(b[k]));
        max_i(self, a: Self::I, b: Self::I) -> Self::I = from_fn(|k| a[k].max(b[k]));
        min_i(self, a: Self::I, b: Self::I) -> Self::I = from_fn(|k| a[k].min(b[k]));
        gt_i(self, a: Self::I, b: Self::I) -> Self::I = from_fn(|k| mask(a[k] > b[k]));
        and(self, a: Self::I, b: Self::I) -> Self::I = from_fn(|k| a[k] & b[k]);
        or(self, a: Self::I, b: Self::I) -> Self::I = from_fn(|k| a[k] | b[k]);
        and_not(self, a: Self::I, b: Self::I) -> Self::I = from_fn(|k| a[k] & !b[k]);
        sign_mask(self, a: Self::I) -> Self::I = a.map(|a| a >> 31);
    }

    #[inline(always)]
    fn splat(self, a: f32) -> Self::F {
        [a; LANES_8]
    }

    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        from_fn(|k| if a[k] < b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        from_fn(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }

    #[inline(always)]
    fn transpose(self, rows: [Self::F; LANES_8]) -> [Self::F; LANES_8] {
        from_fn(|i| from_fn(|k| rows[k][i]))
    }

    #[inline(always)]
    fn splat_i(self, a: i32) -> Self::I {
        [a; LANES_8]
    }

    #[inline(always)]
    fn shift_right<const BITS: i32>(self, a: Self::I) -> Self::I {
        a.map(|a| ((a as u32) >> BITS) as i32)
    }

    #[inline(always)]
    fn shift_right_signed<const BITS: i32>(self, a: Self::I) -> Self::I {
        a.map(|a| a >> BITS)
    }

    #[inline(always)]
    fn to_bitmask(self, mask: Self::I) -> u32 {
        (0..LANES_8).fold(0, |bits, k| bits | (u32::from(mask[k] < 0) << k))
    }

    #[inline(always)]
    fn gather_columns(self, rows: [&[i32; 4]; LANES_8]) -> [Self::I; 4] {
        from_fn(|i| from_fn(|k| rows[k][i]))
    }

    #[inline(always)]
    fn scatter_columns(self, columns: [Self::I; 4], out: &mut [[i32; 4]; LANES_8]) {
        *out = from_fn(|k| columns.map(|column| column[k]));
    }

    #[inline(always)]
    fn select(self, mask: Self::I, a: Self::I, b: Self::I) -> Self::I {
        from_fn(|k| if mask[k] < 0 { a[k] } else { b[k] })
    }
}
