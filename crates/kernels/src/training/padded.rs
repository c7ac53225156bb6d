//! Images with a border of zeros, in memory that is reused.

use evpose_cpu::vectorize;

use super::blocks::Blocks;
use super::norm::{NormalizedInput, ScaleShift};
use crate::blocked::Line;
use crate::simd::LANES;

/// Images `[image][channels / 16][height + border][width + border][16]`.
#[derive(Default)]
pub(super) struct Padded {
    lines: Vec<Line>,
}

/// Strides of padded images, in `f32`: of rows, blocks of channels and images.
#[derive(Clone, Copy)]
pub(super) struct Pitches {
    pub(super) row: usize,
    pub(super) block: usize,
    pub(super) image: usize,
    border: usize,
}

impl Pitches {
    /// Pitches of images of this shape with `border` pixels of zeros on each side.
    pub(super) fn new(shape: &Blocks, border: usize) -> Self {
        let row = (shape.width + 2 * border) * LANES;
        let block = row * (shape.height + 2 * border);
        Self { row, block, image: block * shape.blocks(), border }
    }

    pub(super) fn block_lines(&self) -> usize {
        self.block / LANES
    }

    pub(super) fn lines(&self, images: usize) -> usize {
        images * self.image / LANES
    }
}

/// Writes an image of `shape`, normalised by the input's norm, with its border.
pub(super) fn pad(shape: &Blocks, input: NormalizedInput<'_>, pitches: Pitches, to: &mut [Line]) {
    let planes = to.chunks_exact_mut(pitches.block_lines());
    for (block, (plane, values)) in planes.zip(input.values.chunks_exact(shape.block())).enumerate()
    {
        pad_block(shape, values, input.block_norm(block), pitches, plane);
    }
}

/// Writes one block of an image of `shape`, normalised if there is a norm, with its border.
pub(super) fn pad_block(
    shape: &Blocks,
    values: &[f32],
    norm: Option<ScaleShift>,
    pitches: Pitches,
    plane: &mut [Line],
) {
    let norm = norm.map(|norm| norm.strips());
    let row_lines = pitches.row / LANES;
    let border = pitches.border;
    let (above, rest) = plane.split_at_mut(border * row_lines);
    let (rows, below) = rest.split_at_mut(shape.height * row_lines);
    // The memory is reused, and borders may hold other values.
    above.fill(Line::ZERO);
    below.fill(Line::ZERO);
    let rows = rows.chunks_exact_mut(row_lines);
    for (row, values) in rows.zip(values.chunks_exact(shape.width * LANES)) {
        row[..border].fill(Line::ZERO);
        row[border + shape.width..].fill(Line::ZERO);
        let inside = &mut row[border..border + shape.width];
        let Some(norm) = &norm else {
            Line::values_mut(inside).copy_from_slice(values);
            continue;
        };
        vectorize(
            #[inline(always)]
            || {
                norm.write(values, Line::values_mut(inside));
            },
        );
    }
}

impl Padded {
    /// Memory for `lines` lines of any content.
    pub(super) fn room(&mut self, lines: usize) -> &mut [Line] {
        if self.lines.len() < lines {
            self.lines.resize(lines, Line::ZERO);
        }
        &mut self.lines[..lines]
    }
}
