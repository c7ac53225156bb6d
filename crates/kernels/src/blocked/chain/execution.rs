//! Execution of a chain on the output rows of one thread.

use std::ops::Range;

use super::{Chain, ChainInput, Link};
use crate::blocked::image::{Line, OVERREAD};
use crate::blocked::pool::max_pool_rows;
use crate::blocked::views::{F32Dst, F32Src};
use crate::simd::LANES;

/// Memory of the bands, from one thread's first band on.
#[derive(Clone, Copy)]
pub(super) struct BandMemory(pub(super) *mut Line);

// SAFETY: each thread writes its own range.
unsafe impl Send for BandMemory {}
// SAFETY: as above.
unsafe impl Sync for BandMemory {}

impl BandMemory {
    /// The memory from a line on.
    pub(super) fn from(self, line: usize) -> Self {
        Self(self.0.wrapping_add(line))
    }
}

pub(super) struct ChainExec<'a> {
    pub(super) chain: &'a Chain,
    pub(super) input: ChainInput<'a>,
    pub(super) residual: Option<F32Src>,
    pub(super) output: F32Dst,
    pub(super) memory: BandMemory,
}

impl ChainExec<'_> {
    /// Computes output rows `rows`.
    ///
    /// # Safety
    /// The rows are of the output, and nobody else writes them; the memory is this thread's.
    pub(super) unsafe fn run(&self, rows: Range<usize>) {
        let links = self.chain.links.len();
        // The rows that each band holds at present.
        let mut held: Vec<Range<isize>> = vec![0..0; links - 1];
        for first in rows.clone().step_by(self.chain.rows_at_once) {
            let last = (first + self.chain.rows_at_once).min(rows.end);
            // From the last layer to the first: each needs the windows of the rows of the next.
            let mut needed = vec![first as isize..last as isize; links];
            for at in (1..links).rev() {
                needed[at - 1] = self.chain.links[at].input_rows(&needed[at]);
            }
            for at in 0..links {
                // SAFETY: the caller's; bands have room for the rows that are needed at once.
                unsafe {
                    let new = if at + 1 < links {
                        let new = self.shift_band(at, &held[at], &needed[at]);
                        held[at] = needed[at].clone();
                        new
                    } else {
                        needed[at].start as usize..needed[at].end as usize
                    };
                    if !new.is_empty() {
                        self.run_link(at, new, &needed);
                    }
                }
            }
        }
    }

    /// Makes band `at`, which holds rows `old`, begin at the first of rows `needed`: moves the
    /// rows that both contain and zeroes the border and the rows outside of the image. Returns the
    /// rows to compute.
    ///
    /// # Safety
    /// As [`run`](Self::run).
    unsafe fn shift_band(
        &self,
        at: usize,
        old: &Range<isize>,
        needed: &Range<isize>,
    ) -> Range<usize> {
        let band = &self.chain.bands[at];
        let height = self.chain.sizes[at + 1][1] as isize;
        // Rows that both contain are moved; those behind them are computed.
        let kept = needed.start.max(old.start)..needed.end.min(old.end);
        let has_kept = !kept.is_empty();
        let missing = if has_kept { kept.end } else { needed.start }..needed.end;
        let memory = self.memory.from(band.first);
        // SAFETY: the caller's; kept rows are inside the band before and after the move.
        unsafe {
            for block in 0..band.blocks {
                let first = memory.from(block * band.block_pitch).0;
                let row = |row: isize, of: &Range<isize>| {
                    first.add((row - of.start) as usize * band.row_pitch)
                };
                if has_kept && old.start != needed.start {
                    let (from, to) = (row(kept.start, old), row(kept.start, needed));
                    std::ptr::copy(from, to, kept.len() * band.row_pitch);
                }
                // Of new rows the border is zero, of rows outside of the image all is.
                for y in missing.clone() {
                    let row = row(y, needed);
                    if (0..height).contains(&y) && !band.is_nchw {
                        // The layer overwrites the rest of the row.
                        row.write_bytes(0, band.border);
                        row.add(band.row_pitch - OVERREAD - band.border)
                            .write_bytes(0, band.border);
                    } else {
                        row.write_bytes(0, band.row_pitch);
                    }
                }
            }
        }
        missing.start.clamp(0, height) as usize..missing.end.clamp(0, height) as usize
    }

    /// Computes rows `rows` of a layer's output.
    ///
    /// # Safety
    /// As [`run`](Self::run); the rows that they depend on are in the band before.
    unsafe fn run_link(&self, at: usize, rows: Range<usize>, needed: &[Range<isize>]) {
        let link = &self.chain.links[at];
        let first = rows.start as isize;
        let (output, residual) = if at + 1 == needed.len() {
            (self.output, self.residual.map(|image| image.with_first_row(first)))
        } else {
            // Views of a band are shifted so that rows have the same index as in the whole image.
            (self.band(at).with_first_row(-needed[at].start), None)
        };
        let input = match self.input {
            // Only the first layer reads the input: others read the band before.
            ChainInput::Image(image) if at == 0 => image.src(),
            ChainInput::Nchw(image) if at == 0 => {
                if let Link::Nchw(conv, activation) = link {
                    // SAFETY: the caller's.
                    return unsafe { conv.rows(image, *activation, output, rows) };
                }
                image.src()
            }
            _ => {
                let is_nchw = self.chain.bands[at - 1].is_nchw;
                F32Src::from_dst(self.band(at - 1), is_nchw).with_first_row(-needed[at - 1].start)
            }
        };
        let input_of_rows = input.with_first_row(first * link.window()[1] as isize);
        let output_of_rows = output.with_first_row(first);
        // SAFETY: the caller's.
        unsafe {
            match link {
                Link::Nchw(..) => unreachable!("the first takes nchw"),
                Link::Conv(conv, activation) => {
                    conv.rows(input_of_rows, residual, *activation, output_of_rows, rows.len());
                }
                Link::Depthwise(conv, activation) => {
                    conv.rows(input_of_rows, *activation, output_of_rows, rows.len());
                }
                Link::MaxPool(pool) => {
                    let [channels, height, _] = self.chain.sizes[at];
                    let windows: Vec<Range<usize>> =
                        rows.map(|row| pool.window_of(row, height)).collect();
                    let windows = [windows.as_slice(), &self.chain.columns[at]];
                    let blocks = channels.div_ceil(LANES);
                    max_pool_rows(self.chain.level, input, windows, output_of_rows, blocks);
                }
            }
        }
    }

    /// Destination view of the band after a layer; its row 0 is the first that the band holds.
    fn band(&self, at: usize) -> F32Dst {
        let band = &self.chain.bands[at];
        let pixel = if band.is_nchw { 1 } else { LANES };
        let first: *mut f32 = self.memory.from(band.first).0.cast();
        let pixels = first.wrapping_add(band.border * pixel);
        let [row_pitch, block_pitch] =
            [band.row_pitch, band.block_pitch].map(|lines| lines * LANES);
        F32Dst { pixels, row_pitch, block_pitch, width: self.chain.sizes[at + 1][2] }
    }
}
