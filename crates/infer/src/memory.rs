//! Which images share the same memory.

use crate::held::{Buffer, Kept};
use crate::shapes::Shape;

/// Where an image is kept.
pub(crate) type Slot = usize;

/// Images, given out and taken back while a plan is made.
///
/// Only images of one shape and border that are kept alike share memory: nothing then writes to a border,
/// which stays zero.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    kinds: Vec<(Shape, usize, Kept)>,
    free: Vec<Slot>,
}

impl Memory {
    /// An image of a shape with a border, until it is given back.
    pub(crate) fn take(&mut self, shape: Shape, border: usize, kept: Kept) -> Slot {
        let fits = |slot: &Slot| {
            let (of_shape, of_border, of_kept) = self.kinds[*slot];
            let is_alike = match (of_kept, kept) {
                (None, None) => true,
                (Some(one), Some(other)) => one.is_alike(other),
                _ => false,
            };
            (of_shape, of_border) == (shape, border) && is_alike
        };
        if let Some(at) = self.free.iter().position(fits) {
            return self.free.swap_remove(at);
        }
        self.kinds.push((shape, border, kept));
        self.kinds.len() - 1
    }

    /// Gives one back.
    pub(crate) fn give(&mut self, slot: Slot) {
        self.free.push(slot);
    }

    /// All of them.
    pub(crate) fn buffers(&self) -> Vec<Buffer> {
        let buffer =
            |(shape, border, kept): &(Shape, usize, Kept)| Buffer::zeros(*shape, *border, *kept);
        self.kinds.iter().map(buffer).collect()
    }
}
