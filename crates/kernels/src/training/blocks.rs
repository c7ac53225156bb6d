//! The shape of a batch in blocks of sixteen channels.

use rayon::prelude::*;

use crate::simd::LANES;

/// Shape of a batch `[batch][channels / 16][height][width][16]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blocks {
    /// Images.
    pub batch: usize,
    /// Channels that hold something.
    pub channels: usize,
    /// Rows.
    pub height: usize,
    /// Columns.
    pub width: usize,
}

impl Blocks {
    /// Blocks of channels.
    pub fn blocks(&self) -> usize {
        self.channels.div_ceil(LANES)
    }

    /// Numbers of one block of an image.
    pub fn block(&self) -> usize {
        self.height * self.width * LANES
    }

    /// Numbers of an image.
    pub fn image(&self) -> usize {
        self.blocks() * self.block()
    }

    /// Numbers of the batch, with those that fill blocks up.
    pub fn numbers(&self) -> usize {
        self.batch * self.image()
    }

    /// From `[batch, channels, height, width]`.
    ///
    /// # Panics
    /// If there are more or fewer values.
    pub fn from_planes(&self, planes: &[f32]) -> Vec<f32> {
        let pixels = self.height * self.width;
        assert_eq!(planes.len(), self.batch * self.channels * pixels, "planes of this size");
        let mut values = vec![0.0; self.numbers()];
        if values.is_empty() {
            return values;
        }
        let images = planes.par_chunks(self.channels * pixels);
        values.par_chunks_mut(self.image()).zip(images).for_each(|(image, planes)| {
            let blocks = image.chunks_exact_mut(self.block());
            for (block, planes) in blocks.zip(planes.chunks(LANES * pixels)) {
                for (lane, plane) in planes.chunks_exact(pixels).enumerate() {
                    for (line, value) in block.as_chunks_mut::<LANES>().0.iter_mut().zip(plane) {
                        line[lane] = *value;
                    }
                }
            }
        });
        values
    }

    /// To `[batch, channels, height, width]`.
    ///
    /// # Panics
    /// If there are more or fewer values.
    pub fn to_planes(&self, values: &[f32]) -> Vec<f32> {
        let pixels = self.height * self.width;
        assert_eq!(values.len(), self.numbers(), "blocks of this size");
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
