//! Functions of every value by itself.

use std::ops::Range;

use super::conv::Output;
use super::image::{Image, Line};
use super::thread_pool::ThreadPool;
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Writes `factor * input + offset` to `output`.
///
/// # Panics
/// If sizes differ.
pub fn affine(
    thread_pool: &ThreadPool,
    level: Level,
    input: &Image,
    [factor, offset]: [f32; 2],
    output: &mut Image,
) {
    mapped(thread_pool, level, input, Of::Affine { factor, offset }, output);
}

/// Writes `1 / (1 + exp(-input))` to `output`, right to a few units in the last place.
///
/// # Panics
/// If sizes differ.
pub fn sigmoid(thread_pool: &ThreadPool, level: Level, input: &Image, output: &mut Image) {
    mapped(thread_pool, level, input, Of::Sigmoid, output);
}

/// What becomes of a value.
#[derive(Debug, Clone, Copy)]
enum Of {
    Affine { factor: f32, offset: f32 },
    Sigmoid,
}

fn mapped(thread_pool: &ThreadPool, level: Level, input: &Image, of: Of, output: &mut Image) {
    let size = |image: &Image| [image.channels(), image.height(), image.width()];
    assert_eq!(size(input), size(output), "images of one size");
    let rows = output.height();
    let units = output.blocks() * rows;
    let out = Output::of(output);
    thread_pool.run(&|part| {
        let work = Rows { input, of, out, rows, units: part.chunk(units) };
        // SAFETY: images are of one size, rows of the parts are disjoint, and the level is one of
        // this processor's.
        unsafe { level.run(&work) };
    });
}

/// Some rows, block after block.
struct Rows<'a> {
    input: &'a Image,
    of: Of,
    out: Output,
    /// Of a block.
    rows: usize,
    units: Range<usize>,
}

impl Kernel for Rows<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        for unit in self.units.clone() {
            let (block, y) = (unit / self.rows, unit % self.rows);
            let from = self.input.tap(block, y, 0, 0);
            // Channels that fill the last block up stay zero.
            let channels = self.input.channels() - block * LANES;
            let inside = Line(std::array::from_fn(|lane| f32::from(lane < channels)));
            // SAFETY: the caller's.
            unsafe {
                let to = self.out.pixel(block, y, 0);
                let inside = V::load(inside.0.as_ptr());
                for at in (0..self.out.width).map(|x| x * LANES) {
                    let value = match self.of {
                        Of::Affine { factor, offset } => {
                            V::load(from.add(at)).mul_add(V::splat(factor), V::splat(offset))
                        }
                        Of::Sigmoid => {
                            // Compilers do sixteen at once of a loop, but not of `map`.
                            let mut pixel = from.add(at).cast::<[f32; LANES]>().read();
                            pixel.iter_mut().for_each(|value| *value = sigmoid_of(*value));
                            V::load(pixel.as_ptr())
                        }
                    };
                    value.mul(inside).store(to.add(at));
                }
            }
        }
    }
}

/// The sigmoid of a value without a branch, so that compilers do sixteen at once.
///
/// # Model
/// `exp(-x)` is `2^n exp(r)` with the whole `n` nearest to `-x / ln 2` and `|r| <= ln 2 / 2`, for
/// which seven terms of the series behind 1 are exact to the last place.
#[inline(always)]
fn sigmoid_of(value: f32) -> f32 {
    /// Beyond, the sigmoid is 0 or 1 to within 1e-37.
    const FARTHEST: f32 = 87.0;
    /// Added to a number, it leaves the nearest whole number in the last bits.
    const ROUNDING: f32 = 12_582_912.0;
    /// ln 2 in two parts, of which the first has few digits: its multiples are exact.
    const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
    /// Of the sign and the exponent.
    const MANTISSA_BITS: u32 = 23;
    const EXPONENT_OF_ONE: u32 = 127;
    let x = (-value).clamp(-FARTHEST, FARTHEST);
    let rounded = x * std::f32::consts::LOG2_E + ROUNDING;
    let whole = rounded - ROUNDING;
    let rest = x - whole * LN_2[0] - whole * LN_2[1];
    let tail = ((rest / 5040.0 + 1.0 / 720.0) * rest + 1.0 / 120.0) * rest + 1.0 / 24.0;
    let series = (((tail * rest + 1.0 / 6.0) * rest + 0.5) * rest + 1.0) * rest + 1.0;
    let exponent = rounded.to_bits().wrapping_add(EXPONENT_OF_ONE) << MANTISSA_BITS;
    1.0 / (1.0 + series * f32::from_bits(exponent))
}
