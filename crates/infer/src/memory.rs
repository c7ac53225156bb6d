//! Memory planning: values that do not live at the same time share a buffer.

use crate::buffer::{Buffer, StorageType};
use crate::shapes::Shape;

/// Index of a buffer.
pub(crate) type Slot = usize;

/// Allocator of the buffers of a plan.
///
/// Only values of one shape, border and compatible storage type share a buffer: no step writes to a
/// border, so that it stays zero.
#[derive(Debug, Default)]
pub(crate) struct BufferAllocator {
    /// Shape, border and storage type of each buffer.
    layouts: Vec<(Shape, usize, StorageType)>,
    free: Vec<Slot>,
}

impl BufferAllocator {
    /// Allocates a buffer until it is [released](Self::release).
    pub(crate) fn allocate(&mut self, shape: Shape, border: usize, storage: StorageType) -> Slot {
        let fits = |slot: &Slot| {
            let (slot_shape, slot_border, slot_storage) = self.layouts[*slot];
            (slot_shape, slot_border) == (shape, border) && slot_storage.is_compatible_with(storage)
        };
        if let Some(at) = self.free.iter().position(fits) {
            return self.free.swap_remove(at);
        }
        self.layouts.push((shape, border, storage));
        self.layouts.len() - 1
    }

    /// Makes a buffer available to later values.
    pub(crate) fn release(&mut self, slot: Slot) {
        self.free.push(slot);
    }

    /// All buffers, zero.
    pub(crate) fn buffers(&self) -> Vec<Buffer> {
        let buffer = |(shape, border, storage): &(Shape, usize, StorageType)| {
            Buffer::zeros(*shape, *border, *storage)
        };
        self.layouts.iter().map(buffer).collect()
    }
}
