//! Sums, and channels put elsewhere.

use std::ops::Range;

use super::conv::Output;
use super::image::Image;
use super::thread_pool::ThreadPool;
use super::tile::{Activation, activated};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Writes `activation(one + other)` to `output`; without `other`, `activation(one)`.
///
/// # Panics
/// If sizes differ.
pub fn add(
    thread_pool: &ThreadPool,
    level: Level,
    one: &Image,
    other: Option<&Image>,
    activation: Activation,
    output: &mut Image,
) {
    assert_same(one, output);
    other.iter().for_each(|other| assert_same(one, other));
    let rows = output.height();
    let units = output.blocks() * rows;
    let out = Output::of(output);
    thread_pool.run(&|part| {
        let work = Sums { one, other, activation, out, rows, units: part.chunk(units) };
        // SAFETY: images are of one size, rows of the parts are disjoint, and the level is one of
        // this processor's.
        unsafe { level.run(&work) };
    });
}

fn assert_same(one: &Image, other: &Image) {
    let size = |image: &Image| [image.channels(), image.height(), image.width()];
    assert_eq!(size(one), size(other), "images of one size");
}

/// Some rows, block after block.
struct Sums<'a> {
    one: &'a Image,
    other: Option<&'a Image>,
    activation: Activation,
    out: Output,
    rows: usize,
    units: Range<usize>,
}

impl Kernel for Sums<'_> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        for unit in self.units.clone() {
            let (block, y) = (unit / self.rows, unit % self.rows);
            let one = self.one.tap(block, y, 0, 0);
            let other = self.other.map(|other| other.tap(block, y, 0, 0));
            // SAFETY: the caller's.
            unsafe {
                let to = self.out.pixel(block, y, 0);
                for at in (0..self.out.width).map(|x| x * LANES) {
                    let mut sum = V::load(one.add(at));
                    if let Some(other) = other {
                        sum = sum.add(V::load(other.add(at)));
                    }
                    activated(sum, self.activation).store(to.add(at));
                }
            }
        }
    }
}

/// Writes channel `source(k)` to channel `k` of `output`, for all of its channels.
///
/// # Panics
/// If heights or widths differ or there is no such channel.
pub fn gather<'a>(output: &mut Image, source: impl Fn(usize) -> (&'a Image, usize)) {
    let (height, width) = (output.height(), output.width());
    for channel in 0..output.channels() {
        let (image, from) = source(channel);
        assert_eq!([image.height(), image.width()], [height, width], "images of one size");
        assert!(from < image.channels(), "channel {from} of {}", image.channels());
        for y in 0..height {
            let (to, to_lane) = output.place(channel, y, 0);
            let (from, from_lane) = image.place(from, y, 0);
            let lines = output.lines_mut()[to..to + width].iter_mut();
            for (to, from) in lines.zip(&image.lines()[from..from + width]) {
                to.0[to_lane] = from.0[from_lane];
            }
        }
    }
}

/// Writes all values of `input`, channel by channel, to the channels of the single pixel of
/// `output`.
///
/// # Panics
/// If there are more or fewer.
pub fn flatten(input: &Image, output: &mut Image) {
    assert_eq!([output.height(), output.width()], [1, 1], "a single pixel");
    let mut values = vec![0.0; output.channels()];
    input.write_planes(&mut values);
    output.read_planes(&values);
}
