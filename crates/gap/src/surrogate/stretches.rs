//! Quiet stretches: blocks of pixels and slices of time with no more events than the background.
//!
//! # Method
//! The image is divided into blocks of 8 x 8 pixels, time into slices of 50 ms. The lower quartile
//! of the counts of all cells (block and slice) estimates the background. A cell is disturbed if
//! its count, or that of a neighbour in image or time, is clearly above the background, because
//! little happens in the surroundings of what moves slowly. A stretch is a run of undisturbed
//! slices of a block.

use super::train::Train;

/// Side of a block, pixels.
const BLOCK: usize = 8;
/// Length of a slice, microseconds.
const SLICE_US: i64 = 50_000;
/// A count is clearly above the background by this many standard deviations of a Poisson count, and
/// this many events more.
const MAX_DEVIATIONS: f64 = 4.0;
const MAX_EXCESS: f64 = 2.0;

/// The events of one pixel in one quiet stretch.
#[derive(Debug, Clone)]
pub(super) struct Stretch {
    /// Index of the pixel, row by row.
    pub(super) pixel: u32,
    pub(super) from_us: i64,
    pub(super) to_us: i64,
    /// Time and polarity (ON is true) of its events, in order of time.
    pub(super) events: Vec<(i64, bool)>,
}

/// Cells of a recording: all blocks and slices.
struct Grid {
    start_us: i64,
    width: usize,
    height: usize,
    /// Blocks in a row of blocks, and rows of blocks.
    across: usize,
    down: usize,
    slices: usize,
}

impl Grid {
    fn for_train(train: &Train) -> Self {
        let (start_us, end_us) = train.span_us();
        let (width, height) = (train.width(), usize::from(train.size.height));
        Self {
            start_us,
            width,
            height,
            across: width.div_ceil(BLOCK),
            down: height.div_ceil(BLOCK),
            slices: ((end_us - start_us) / SLICE_US) as usize,
        }
    }

    fn blocks(&self) -> usize {
        self.across * self.down
    }

    fn block(&self, pixel: u32) -> usize {
        let pixel = pixel as usize;
        pixel / self.width / BLOCK * self.across + pixel % self.width / BLOCK
    }

    fn slice(&self, t_us: i64) -> usize {
        ((t_us - self.start_us) / SLICE_US) as usize
    }

    /// Pixels of a block; those at the right and lower border are smaller.
    fn pixels(&self, block: usize) -> usize {
        BLOCK.min(self.width - block % self.across * BLOCK)
            * BLOCK.min(self.height - block / self.across * BLOCK)
    }

    /// Counts of all cells, block by block.
    fn counts(&self, train: &Train) -> Vec<u32> {
        let mut counts = vec![0; self.blocks() * self.slices];
        for mark in &train.marks {
            let of_block = &mut counts[self.block(mark.pixel) * self.slices..][..self.slices];
            // The last, incomplete slice is left out.
            if let Some(count) = of_block.get_mut(self.slice(mark.t_us)) {
                *count += 1;
            }
        }
        counts
    }

    /// Marks the cells that are busy, or next to a busy one in image or time.
    fn disturbed(&self, counts: &[u32]) -> Vec<bool> {
        let mut sorted = counts.to_vec();
        // The lower quartile, since in most recordings more than half of the cells see something.
        let (_, quartile, _) = sorted.select_nth_unstable(counts.len() / 4);
        let background = f64::from(*quartile);
        let limit = background + MAX_DEVIATIONS * background.sqrt() + MAX_EXCESS;
        let mut disturbed = vec![false; counts.len()];
        for (cell, _) in counts.iter().enumerate().filter(|(_, n)| f64::from(**n) > limit) {
            let (block, slice) = (cell / self.slices, cell % self.slices);
            let (x, y) = (block % self.across, block / self.across);
            for row in y.saturating_sub(1)..(y + 2).min(self.down) {
                for column in x.saturating_sub(1)..(x + 2).min(self.across) {
                    let at = (row * self.across + column) * self.slices;
                    let slices = slice.saturating_sub(1)..(slice + 2).min(self.slices);
                    // Neighbours as well: what moves into the next cell has a few events there
                    // already.
                    disturbed[at + slices.start..at + slices.end].fill(true);
                }
            }
        }
        disturbed
    }
}

/// Finds all quiet stretches of pixels with events, and the total time of all quiet cells in pixel
/// seconds. None if the recording is shorter than a slice.
pub(super) fn quiet_stretches(train: &Train) -> Option<(Vec<Stretch>, f64)> {
    let grid = Grid::for_train(train);
    if grid.slices == 0 {
        return None;
    }
    let disturbed = grid.disturbed(&grid.counts(train));
    let slices = grid.slices;
    let mut pixel_s = 0.0;
    // First slice of the stretch that each cell belongs to, and the slice behind its last.
    let mut bounds: Vec<Option<(usize, usize)>> = vec![None; disturbed.len()];
    for block in 0..grid.blocks() {
        let mut from = 0;
        while from < slices {
            let is_disturbed = |slice: &usize| disturbed[block * slices + slice];
            let to = (from..slices).find(is_disturbed).unwrap_or(slices);
            bounds[block * slices + from..block * slices + to].fill(Some((from, to)));
            pixel_s += grid.pixels(block) as f64 * (to - from) as f64 * SLICE_US as f64 * 1e-6;
            from = to + 1;
        }
    }
    // Index of the current stretch of every pixel.
    let mut current: Vec<Option<usize>> = vec![None; grid.width * grid.height];
    let mut stretches: Vec<Stretch> = Vec::new();
    for mark in &train.marks {
        let slice = grid.slice(mark.t_us);
        let cell = (slice < slices).then(|| grid.block(mark.pixel) * slices + slice);
        let Some((from, to)) = cell.and_then(|cell| bounds[cell]) else { continue };
        let from_us = grid.start_us + from as i64 * SLICE_US;
        let event = (mark.t_us, mark.is_on);
        let known = &mut current[mark.pixel as usize];
        match known.filter(|i| stretches[*i].from_us == from_us) {
            Some(i) => stretches[i].events.push(event),
            None => {
                *known = Some(stretches.len());
                let to_us = grid.start_us + to as i64 * SLICE_US;
                let pixel = mark.pixel;
                stretches.push(Stretch { pixel, from_us, to_us, events: vec![event] });
            }
        }
    }
    Some((stretches, pixel_s))
}
