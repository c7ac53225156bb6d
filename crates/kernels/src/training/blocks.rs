//! The shape of a batch in the layout nChw16c.

use rayon::prelude::*;

use crate::simd::LANES;

/// Shape of a batch in nChw16c, `[batch][channels / 16][height][width][16]`.
///
/// Lanes of the last block beyond `channels` hold zero in every batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blocks {
    /// Images.
    pub batch: usize,
    /// Channels, without those that pad the last block.
    pub channels: usize,
    /// Height in pixels.
    pub height: usize,
    /// Width in pixels.
    pub width: usize,
}

impl Blocks {
    /// Blocks of channels.
    pub fn blocks(&self) -> usize {
        self.channels.div_ceil(LANES)
    }

    /// Values of one block of an image.
    pub fn block(&self) -> usize {
        self.height * self.width * LANES
    }

    /// Values of an image, padding included.
    pub fn image(&self) -> usize {
        self.blocks() * self.block()
    }

    /// Values of the batch, padding included.
    pub fn value_count(&self) -> usize {
        self.batch * self.image()
    }

    /// The shape of every `stride`-th row and column.
    pub(super) fn strided(self, stride: usize) -> Self {
        let [height, width] = [self.height, self.width].map(|side| side.div_ceil(stride));
        Self { height, width, ..self }
    }

    /// A batch of this shape from `[batch, channels, height, width]`.
    ///
    /// # Panics
    /// If there are more or fewer values.
    pub fn from_planes(&self, planes: &[f32]) -> Vec<f32> {
        let pixels = self.height * self.width;
        assert_eq!(planes.len(), self.batch * self.channels * pixels, "planes of this size");
        let mut values = vec![0.0; self.value_count()];
        if values.is_empty() {
            return values;
        }
        let images = planes.par_chunks(self.channels * pixels);
        values.par_chunks_mut(self.image()).zip(images).for_each(|(image, planes)| {
            let blocks = image.chunks_exact_mut(self.block());
            for (block, planes) in blocks.zip(planes.chunks(LANES * pixels)) {
                // Lanes without a channel keep the zero that they were made with.
                for (lane, plane) in planes.chunks_exact(pixels).enumerate() {
                    for (line, value) in block.as_chunks_mut::<LANES>().0.iter_mut().zip(plane) {
                        line[lane] = *value;
                    }
                }
            }
        });
        values
    }

    /// The channels of a batch as `[batch, channels, height, width]`.
    ///
    /// # Panics
    /// If there are more or fewer values.
    pub fn to_planes(&self, values: &[f32]) -> Vec<f32> {
        let pixels = self.height * self.width;
        assert_eq!(values.len(), self.value_count(), "blocks of this size");
        let mut planes = vec![0.0; self.batch * self.channels * pixels];
        let of_image = self.channels * pixels;
        if planes.is_empty() {
            return planes;
        }
        planes.par_chunks_mut(of_image).zip(values.par_chunks(self.image())).for_each(
            |(planes, image)| {
                let blocks = image.chunks_exact(self.block());
                for (planes, block) in planes.chunks_mut(LANES * pixels).zip(blocks) {
                    for (lane, plane) in planes.chunks_exact_mut(pixels).enumerate() {
                        for (value, line) in plane.iter_mut().zip(block.as_chunks::<LANES>().0) {
                            *value = line[lane];
                        }
                    }
                }
            },
        );
        planes
    }
}
