//! Which images share the same memory.

use evpose_kernels::blocked::Image;

use crate::shapes::Shape;

/// Where an image is kept.
pub(crate) type Slot = usize;

/// Images, given out and taken back while a plan is made.
///
/// Only images of one shape and border share memory: nothing then writes to a border, which stays zero.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    kinds: Vec<(Shape, usize)>,
    free: Vec<Slot>,
}

impl Memory {
    /// An image of a shape with a border, until it is given back.
    pub(crate) fn take(&mut self, shape: Shape, border: usize) -> Slot {
        let kind = (shape, border);
        if let Some(at) = self.free.iter().position(|slot| self.kinds[*slot] == kind) {
            return self.free.swap_remove(at);
        }
        self.kinds.push(kind);
        self.kinds.len() - 1
    }

    /// Gives one back.
    pub(crate) fn give(&mut self, slot: Slot) {
        self.free.push(slot);
    }

    /// All of them.
    pub(crate) fn images(&self) -> Vec<Image> {
        let image = |([channels, height, width], border): &(Shape, usize)| {
            Image::zeros(*channels, *height, *width, *border)
        };
        self.kinds.iter().map(image).collect()
    }
}
