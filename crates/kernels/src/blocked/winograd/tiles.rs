//! The steps of a tile: its inputs transformed, multiplied at every place, transformed back.

#![allow(clippy::needless_range_loop, reason = "columns become rows")]

use std::marker::PhantomData;
use std::ops::Range;

use super::Winograd;
use crate::blocked::conv::{Output, some};
use crate::blocked::image::Image;
use crate::blocked::packing::groups;
use crate::blocked::scheme::{MOST, Scheme};
use crate::blocked::team::Part;
use crate::blocked::tile::{Activation, Start, Taps, activated};
use crate::simd::{Kernel, LANES, Lanes};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    Inputs,
    Products,
    Outputs,
}

/// A step of some tiles.
pub(super) struct Tiles<'a, S> {
    pub(super) of: &'a Winograd,
    pub(super) input: &'a Image,
    pub(super) residual: Option<&'a Image>,
    pub(super) activation: Activation,
    pub(super) out: Output,
    pub(super) size: [usize; 2],
    /// Tiles of a row.
    pub(super) columns: usize,
    pub(super) tiles: Range<usize>,
    pub(super) part: Part,
    pub(super) step: Step,
    /// `[place][block][tile][16]` of the inputs, and behind them the same of the outputs.
    pub(super) inputs: *mut f32,
    /// Blocks of channels, in and out.
    pub(super) blocks: [usize; 2],
    pub(super) scheme: PhantomData<S>,
}

impl<S: Scheme> Kernel for Tiles<'_, S> {
    #[inline(always)]
    unsafe fn run<V: Lanes>(&self) {
        // SAFETY: the caller's.
        unsafe {
            match self.step {
                Step::Inputs => self.take::<V>(),
                Step::Products => self.multiply::<V>(),
                Step::Outputs => self.give::<V>(),
            }
        }
    }
}

impl<S: Scheme> Tiles<'_, S> {
    /// From a place to the next, of the inputs and of the outputs, in `f32`.
    fn pitches(&self) -> [usize; 2] {
        self.blocks.map(|blocks| blocks * self.tiles.len() * LANES)
    }

    fn outputs(&self) -> *mut f32 {
        let inputs = S::IN * S::IN * self.pitches()[0];
        // SAFETY: both are in the same memory.
        unsafe { self.inputs.add(inputs) }
    }

    /// Transforms the inputs.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn take<V: Lanes>(&self) {
        let [pitch, _] = self.pitches();
        for block in self.part.share(self.blocks[0]) {
            for (k, tile) in self.tiles.clone().enumerate() {
                let (y, x) = (tile / self.columns * S::OUT, tile % self.columns * S::OUT);
                let from = self.input.tap(block, y, x, 1);
                let row_pitch = self.input.row_pitch() * LANES;
                // SAFETY: inputs of a tile are inside the image, its border and what lies beyond.
                unsafe {
                    let to = self.inputs.add((block * self.tiles.len() + k) * LANES);
                    let zero = V::splat(0.0);
                    let mut columns = [[zero; MOST]; MOST];
                    for (x, column) in columns.iter_mut().enumerate().take(S::IN) {
                        let mut d = [zero; MOST];
                        for (y, d) in d.iter_mut().enumerate().take(S::IN) {
                            *d = V::load(from.add(y * row_pitch + x * LANES));
                        }
                        *column = S::inputs(d);
                    }
                    for y in 0..S::IN {
                        let row = S::inputs(std::array::from_fn(|x| columns[x][y]));
                        for (x, value) in row.iter().enumerate().take(S::IN) {
                            value.store(to.add((y * S::IN + x) * pitch));
                        }
                    }
                }
            }
        }
    }

    /// Multiplies at every place.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn multiply<V: Lanes>(&self) {
        let channels_in = self.of.shape.channels_in;
        let count = self.tiles.len();
        let [from_pitch, to_pitch] = self.pitches();
        let taps = Taps {
            blocks: self.blocks[0],
            block_pitch: count * LANES,
            last_channels: channels_in - (self.blocks[0] - 1) * LANES,
            kernel: 1,
            row_pitch: 0,
        };
        for place in self.part.share(S::IN * S::IN) {
            let mut first = place * channels_in * self.blocks[1];
            for blocks in groups(self.of.shape.channels_out, self.of.together) {
                let weights = self.of.weights[first..].as_ptr().cast::<f32>();
                first += channels_in * blocks.len();
                let most = V::TILE[blocks.len() - 1];
                let at_once = count.div_ceil(count.div_ceil(most));
                for k in (0..count).step_by(at_once) {
                    let tiles = at_once.min(count - k);
                    // SAFETY: the caller's; the places of these tiles are in the scratch.
                    unsafe {
                        let from = self.inputs.add(place * from_pitch + k * LANES);
                        let at = place * to_pitch + (blocks.start * count + k) * LANES;
                        let to = (self.outputs().add(at), count * LANES);
                        if blocks.len() == 2 {
                            some::<V, 2, 1>(tiles, &taps, from, weights, Start::Zero, to, None);
                        } else {
                            some::<V, 1, 1>(tiles, &taps, from, weights, Start::Zero, to, None);
                        }
                    }
                }
            }
        }
    }

    /// Transforms the outputs back.
    ///
    /// # Safety
    /// That of [`Kernel::run`].
    #[inline(always)]
    unsafe fn give<V: Lanes>(&self) {
        let [_, pitch] = self.pitches();
        let [height, width] = self.size;
        for block in self.part.share(self.blocks[1]) {
            for (k, tile) in self.tiles.clone().enumerate() {
                let (y0, x0) = (tile / self.columns * S::OUT, tile % self.columns * S::OUT);
                let (rows, columns) = (S::OUT.min(height - y0), S::OUT.min(width - x0));
                let residual = self
                    .residual
                    .map(|image| (image.tap(block, y0, x0, 0), image.row_pitch() * LANES));
                // SAFETY: pixels of the tile that are written are inside the output.
                unsafe {
                    let from = self.outputs().add((block * self.tiles.len() + k) * LANES);
                    let bias = V::load(self.of.bias[block].0.as_ptr());
                    let mut halves = [[V::splat(0.0); 4]; MOST];
                    for (x, half) in halves.iter_mut().enumerate().take(S::IN) {
                        let mut m = [V::splat(0.0); MOST];
                        for (y, m) in m.iter_mut().enumerate().take(S::IN) {
                            *m = V::load(from.add((y * S::IN + x) * pitch));
                        }
                        *half = S::outputs(m);
                    }
                    for y in 0..rows {
                        let row = S::outputs(std::array::from_fn(|x| halves[x][y]));
                        let to = self.out.pixel(block, y0 + y, x0);
                        for (x, value) in row.iter().enumerate().take(columns) {
                            let mut sum = value.add(bias);
                            if let Some((residual, row_pitch)) = residual {
                                sum = sum.add(V::load(residual.add(y * row_pitch + x * LANES)));
                            }
                            activated(sum, self.activation).store(to.add(x * LANES));
                        }
                    }
                }
            }
        }
    }
}
