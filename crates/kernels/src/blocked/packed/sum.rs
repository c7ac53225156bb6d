//! Sums, and images kept otherwise.

use std::ops::Range;

use super::held::{From, Held, HeldMut, To};
use crate::blocked::thread_pool::ThreadPool;
use crate::blocked::tile::{Activation, activated};
use crate::simd::{Kernel, LANES, Lanes, Level};

/// Writes `activation(one + other)` to `output`, each kept in its own way; without `other`,
/// `activation(one)`, which with none is the image itself.
///
/// # Panics
/// If sizes differ.
pub fn add_held(
    thread_pool: &ThreadPool,
    level: Level,
    one: Held<'_>,
    other: Option<Held<'_>>,
    activation: Activation,
    mut output: HeldMut<'_>,
) {
    let size = output.size();
    assert_eq!(one.size(), size, "images of one size");
    assert!(other.is_none_or(|other| other.size() == size), "images of one size");
    let [channels, rows, width] = size;
    let units = channels.div_ceil(LANES) * rows;
    let (one, other, to) = (one.from(), other.map(|other| other.from()), output.to());
    thread_pool.run(&|part| {
        let work = Sums { one, other, activation, to, rows, width, units: part.chunk(units) };
        // SAFETY: images are of one size, rows of the parts are disjoint, and the level is one of
        // this processor's.
        unsafe { level.run(&work) };
    });
}

/// Some rows, block after block.
struct Sums {
    one: From,
    other: Option<From>,
    activation: Activation,
    to: To,
    rows: usize,
    width: usize,
    units: Range<usize>,
}

impl Kernel for Sums {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        for unit in self.units.clone() {
            let (block, y) = (unit / self.rows, unit % self.rows);
            let (one, to) = (self.one.at(block, y), self.to.at(block, y));
            let other = self.other.map(|other| (other, other.at(block, y)));
            for x in (0..self.width).map(|x| x * LANES) {
                // SAFETY: the caller's.
                unsafe {
                    let mut sum: V = self.one.load(one + x);
                    if let Some((from, at)) = other {
                        sum = sum.add(from.load(at + x));
                    }
                    self.to.store(activated(sum, self.activation), to + x);
                }
            }
        }
    }
}
