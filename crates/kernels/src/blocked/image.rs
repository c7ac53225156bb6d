//! Images with their channels in blocks of sixteen.

use super::conv::Output;
use super::planes::Planes;
use crate::simd::LANES;

/// Sixteen channels of a pixel, a cache line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Line(pub(crate) [f32; LANES]);

impl Line {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);
}

/// Pixels beyond the right and lower border that a kernel may read, and whose values do not matter: tiles
/// of outputs end where they like.
pub(super) const BEYOND: usize = 4;

/// An image `[channels / 16][height][width][16]` with a border of zeros around it, so that no kernel
/// asks whether a pixel is inside.
///
/// Channels that fill the last block up are zero in every image that an operation of this module wrote.
#[derive(Debug, Clone)]
pub struct Image {
    channels: usize,
    height: usize,
    width: usize,
    border: usize,
    lines: Vec<Line>,
}

impl Image {
    /// An image of zeros with a border of so many pixels.
    pub fn zeros(channels: usize, height: usize, width: usize, border: usize) -> Self {
        let mut image = Self { channels, height, width, border, lines: Vec::new() };
        image.lines = vec![Line::ZERO; image.blocks() * image.block_pitch()];
        image
    }

    /// Channels that hold something.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Rows without the border.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Columns without the border.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels of zeros on each side.
    pub fn border(&self) -> usize {
        self.border
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.lines.as_slice())
    }

    pub(crate) fn blocks(&self) -> usize {
        self.channels.div_ceil(LANES)
    }

    /// Lines from a row to the next.
    pub(crate) fn row_pitch(&self) -> usize {
        self.width + 2 * self.border + BEYOND
    }

    /// Lines from a block of channels to the next.
    pub(crate) fn block_pitch(&self) -> usize {
        (self.height + 2 * self.border + BEYOND) * self.row_pitch()
    }

    /// Where the pixel at row 0 and column 0 of the first block is, in lines.
    pub(crate) fn origin(&self) -> usize {
        self.border * self.row_pitch() + self.border
    }

    /// The sixteen channels of a pixel `padding` above and to the left of row `y` and column `x`.
    ///
    /// # Panics
    /// If that is outside.
    pub(crate) fn tap(&self, block: usize, y: usize, x: usize, padding: usize) -> *const f32 {
        let at = block * self.block_pitch() + self.origin() + y * self.row_pitch() + x;
        self.lines[at - padding * (self.row_pitch() + 1)..].as_ptr().cast()
    }

    /// The first pixel, through which all are written.
    pub(crate) fn first_mut(&mut self) -> *mut f32 {
        let origin = self.origin();
        self.lines[origin..].as_mut_ptr().cast()
    }

    /// Whether nothing was written to the border and the channels that fill the last block up.
    #[cfg(test)]
    pub(super) fn is_zero_outside(&self) -> bool {
        let mut planes = vec![0.0; self.channels * self.height * self.width];
        self.write_planes(&mut planes);
        let mut inside = Self::zeros(self.channels, self.height, self.width, self.border);
        inside.read_planes(&planes);
        inside.lines == self.lines
    }

    pub(super) fn lines(&self) -> &[Line] {
        &self.lines
    }

    pub(super) fn lines_mut(&mut self) -> &mut [Line] {
        &mut self.lines
    }

    pub(super) fn place(&self, channel: usize, y: usize, x: usize) -> (usize, usize) {
        let line = channel / LANES * self.block_pitch() + self.origin() + y * self.row_pitch() + x;
        (line, channel % LANES)
    }

    /// Fills it from `[channels][height][width]`.
    ///
    /// # Panics
    /// If there are more or fewer values.
    pub fn read_planes(&mut self, planes: &[f32]) {
        assert_eq!(planes.len(), self.channels * self.height * self.width, "planes of this size");
        for channel in 0..self.channels {
            for y in 0..self.height {
                let (first, lane) = self.place(channel, y, 0);
                let row = &planes[(channel * self.height + y) * self.width..][..self.width];
                for (line, value) in self.lines[first..].iter_mut().zip(row) {
                    line.0[lane] = *value;
                }
            }
        }
    }

    /// The least and the largest value.
    pub fn extremes(&self) -> [f32; 2] {
        let mut ends = [f32::INFINITY, f32::NEG_INFINITY];
        for block in 0..self.blocks() {
            let channels = LANES.min(self.channels - block * LANES);
            for y in 0..self.height {
                let (first, _) = self.place(block * LANES, y, 0);
                for line in &self.lines[first..first + self.width] {
                    for value in &line.0[..channels] {
                        ends = [ends[0].min(*value), ends[1].max(*value)];
                    }
                }
            }
        }
        ends
    }

    /// Writes it as `[channels][height][width]`.
    ///
    /// # Panics
    /// If there is room for more or fewer values.
    pub fn write_planes(&self, planes: &mut [f32]) {
        assert_eq!(planes.len(), self.channels * self.height * self.width, "planes of this size");
        for (channel, plane) in planes.chunks_mut((self.height * self.width).max(1)).enumerate() {
            self.write_plane(channel, plane);
        }
    }

    /// Writes a channel as `[height][width]`.
    pub(super) fn write_plane(&self, channel: usize, plane: &mut [f32]) {
        for (y, row) in plane.chunks_mut(self.width.max(1)).enumerate() {
            let (first, lane) = self.place(channel, y, 0);
            for (value, line) in row.iter_mut().zip(&self.lines[first..]) {
                *value = line.0[lane];
            }
        }
    }
}

/// Where inputs come from. Distances are in `f32`.
#[derive(Clone, Copy)]
pub(super) struct Input {
    /// At row 0 and column 0 of the first block.
    pixels: *const f32,
    pub(super) row_pitch: usize,
    /// In planes from one to the next.
    pub(super) block_pitch: usize,
    pub(super) is_planes: bool,
}

// SAFETY: an image that somebody holds a reference to, or rows that the thread itself wrote.
unsafe impl Send for Input {}
// SAFETY: as above.
unsafe impl Sync for Input {}

impl Input {
    pub(super) fn of(image: &Image) -> Self {
        let pixels = image.lines[image.origin()..].as_ptr().cast();
        let [row_pitch, block_pitch] =
            [image.row_pitch(), image.block_pitch()].map(|lines| lines * LANES);
        Self { pixels, row_pitch, block_pitch, is_planes: false }
    }

    pub(super) fn of_planes(planes: &Planes) -> Self {
        let (pixels, row_pitch, block_pitch) = planes.first();
        Self { pixels, row_pitch, block_pitch, is_planes: true }
    }

    /// Of rows that are laid out as those of an image, from the pixel at row 0 and column 0 on.
    pub(super) fn at(output: Output, is_planes: bool) -> Self {
        let Output { pixels, row_pitch, block_pitch, .. } = output;
        Self { pixels, row_pitch, block_pitch, is_planes }
    }

    /// The same with another row as row 0.
    pub(super) fn beginning_at(self, row: isize) -> Self {
        let pixels = self.pixels.wrapping_offset(row * self.row_pitch as isize);
        Self { pixels, ..self }
    }

    /// The sixteen channels of a pixel `padding` above and to the left of row `y` and column `x`.
    #[inline(always)]
    pub(super) fn tap(&self, block: usize, y: usize, x: usize, padding: usize) -> *const f32 {
        let pixel = if self.is_planes { 1 } else { LANES };
        let at = block * self.block_pitch + y * self.row_pitch + x * pixel;
        self.pixels.wrapping_add(at).wrapping_sub(padding * (self.row_pitch + pixel))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_come_back_and_the_border_stays_zero() {
        let (channels, height, width) = (19, 3, 5);
        let planes: Vec<f32> = (1..=channels * height * width).map(|v| v as f32).collect();
        let mut image = Image::zeros(channels, height, width, 2);
        image.read_planes(&planes);
        let mut back = vec![0.0; planes.len()];
        image.write_planes(&mut back);
        assert_eq!(back, planes);
        let inside: f32 = planes.iter().sum();
        let all: f32 = image.lines.iter().flat_map(|line| line.0).sum();
        assert!((all - inside).abs() < 1e-3 * inside);
        assert_eq!(image.lines.as_ptr().addr() % 64, 0);
    }
}
