//! 16 lanes in an array, for the vectors of the target's baseline.

use super::{LANES_16, Lanes16};

/// Sixteen `f32` in memory.
#[derive(Clone, Copy)]
pub(super) struct Array([f32; LANES_16]);

impl Array {
    #[inline(always)]
    fn zip(self, other: Self, op: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|lane| op(self.0[lane], other.0[lane])))
    }
}

// SAFETY of all: the contract of `Lanes16`; nothing here needs more than what any processor has.
impl Lanes16 for Array {
    // 12 of 16 registers of four `f32` each.
    const TILE: [usize; 2] = [3, 1];

    #[inline(always)]
    unsafe fn splat(value: f32) -> Self {
        Self([value; LANES_16])
    }

    #[inline(always)]
    unsafe fn load(from: *const f32) -> Self {
        Self(unsafe { from.cast::<[f32; LANES_16]>().read_unaligned() })
    }

    #[inline(always)]
    unsafe fn store(self, to: *mut f32) {
        unsafe { to.cast::<[f32; LANES_16]>().write_unaligned(self.0) }
    }

    #[inline(always)]
    unsafe fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    #[inline(always)]
    unsafe fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }

    #[inline(always)]
    unsafe fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }

    // Not `f32::mul_add`, which is a function call where the processor has no such instruction.
    #[inline(always)]
    unsafe fn mul_add(self, factor: Self, term: Self) -> Self {
        self.zip(factor, |a, b| a * b).zip(term, |product, term| product + term)
    }

    #[inline(always)]
    unsafe fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    unsafe fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    unsafe fn prefetch(_from: *const f32) {}
}
