//! Unary elementwise operators: affine and sigmoid.

use std::ops::Range;

use super::ThreadPool;
use super::image::{Image, Line};
use super::views::F32Dst;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Writes `scale * input + shift` to `output`.
///
/// # Panics
/// If sizes differ.
pub fn affine(
    thread_pool: &ThreadPool,
    level: Level,
    input: &Image,
    [scale, shift]: [f32; 2],
    output: &mut Image,
) {
    apply(thread_pool, level, input, UnaryOp::Affine { scale, shift }, output);
}

/// Writes `1 / (1 + exp(-input))` to `output`, exact to a few units in the last place.
///
/// # Panics
/// If sizes differ.
pub fn sigmoid(thread_pool: &ThreadPool, level: Level, input: &Image, output: &mut Image) {
    apply(thread_pool, level, input, UnaryOp::Sigmoid, output);
}

/// Function of single values.
#[derive(Debug, Clone, Copy)]
enum UnaryOp {
    Affine { scale: f32, shift: f32 },
    Sigmoid,
}

fn apply(thread_pool: &ThreadPool, level: Level, input: &Image, op: UnaryOp, output: &mut Image) {
    let size = |image: &Image| [image.channels(), image.height(), image.width()];
    assert_eq!(size(input), size(output), "images of one size");
    let rows_per_block = output.height();
    let rows = output.blocks() * rows_per_block;
    let dst = output.dst();
    thread_pool.run(&|part| {
        let kernel = UnaryRows { input, op, dst, rows_per_block, rows: part.chunk(rows) };
        // SAFETY: images are of one size, rows of the parts are disjoint, and the level is one of
        // this processor's.
        unsafe { level.run(&kernel) };
    });
}

/// Kernel over a range of rows, counted over all channel blocks.
struct UnaryRows<'a> {
    input: &'a Image,
    op: UnaryOp,
    dst: F32Dst,
    rows_per_block: usize,
    rows: Range<usize>,
}

impl Kernel for UnaryRows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        for row in self.rows.clone() {
            let (block, y) = (row / self.rows_per_block, row % self.rows_per_block);
            let from = self.input.tap(block, y, 0, 0);
            // f(0) is not 0: lanes that pad the last block are masked, so that they stay zero.
            let channels = self.input.channels() - block * LANES;
            let mask = Line(std::array::from_fn(|lane| f32::from(lane < channels)));
            // SAFETY: the caller's.
            unsafe {
                let to = self.dst.pixel(block, y, 0);
                let mask = V::load(mask.0.as_ptr());
                for at in (0..self.dst.width).map(|x| x * LANES) {
                    let value = match self.op {
                        UnaryOp::Affine { scale, shift } => {
                            V::load(from.add(at)).mul_add(V::splat(scale), V::splat(shift))
                        }
                        UnaryOp::Sigmoid => {
                            // LLVM vectorises this loop, but not `map`.
                            let mut pixel = from.add(at).cast::<[f32; LANES]>().read();
                            pixel.iter_mut().for_each(|value| *value = sigmoid_of(*value));
                            V::load(pixel.as_ptr())
                        }
                    };
                    value.mul(mask).store(to.add(at));
                }
            }
        }
    }
}

/// Sigmoid of a value, without branches so that LLVM vectorises it.
///
/// # Model
/// `exp(-x)` is `2^n exp(r)` with the integer `n` nearest to `-x / ln 2` and `|r| <= ln 2 / 2`, for
/// which seven terms of the Taylor series are exact to the last place. The range reduction is Cody
/// and Waite's: *Software Manual for the Elementary Functions*, 1980, Chap. 6.
#[inline(always)]
fn sigmoid_of(value: f32) -> f32 {
    /// Beyond this, the sigmoid is 0 or 1 to within 1e-37.
    const MAX_INPUT: f32 = 87.0;
    /// 1.5 * 2^23: adding it rounds a value to the nearest integer, which is then in the low bits.
    const ROUNDING: f32 = 12_582_912.0;
    /// ln 2 as a sum of two parts; the first has few digits, so that its multiples are exact.
    const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
    /// Bits of an `f32` below the exponent.
    const MANTISSA_BITS: u32 = 23;
    /// Exponent bits of 1.0.
    const EXPONENT_BIAS: u32 = 127;
    // Within these limits the exponent below stays that of a normal number.
    let x = (-value).clamp(-MAX_INPUT, MAX_INPUT);
    let rounded = x * std::f32::consts::LOG2_E + ROUNDING;
    let n = rounded - ROUNDING;
    let rest = x - n * LN_2[0] - n * LN_2[1];
    let tail = ((rest / 5040.0 + 1.0 / 720.0) * rest + 1.0 / 120.0) * rest + 1.0 / 24.0;
    let series = (((tail * rest + 1.0 / 6.0) * rest + 0.5) * rest + 1.0) * rest + 1.0;
    let exponent = rounded.to_bits().wrapping_add(EXPONENT_BIAS) << MANTISSA_BITS;
    1.0 / (1.0 + series * f32::from_bits(exponent))
}
