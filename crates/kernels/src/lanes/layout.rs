//! Between images one after another and images side by side.

use crate::conv2d::Conv2d;

/// Lanes of the widest vector.
const WIDEST: usize = 16;

/// Where the planes of a convolution's input lie: images padded, pixel by pixel, lanes innermost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Planes {
    /// Rows and columns of the images.
    size: [usize; 2],
    padding: usize,
    pub(super) channels: usize,
    pub(super) lanes: usize,
}

impl Planes {
    pub(super) fn of_input(conv: &Conv2d, lanes: usize) -> Self {
        Self {
            size: [conv.height, conv.width],
            padding: conv.padding,
            channels: conv.channels_in,
            lanes,
        }
    }

    pub(super) fn of_output(conv: &Conv2d, lanes: usize) -> Self {
        Self { size: conv.output(), padding: 0, channels: conv.channels_out, lanes }
    }

    /// Columns of a padded plane.
    pub(super) fn columns(&self) -> usize {
        self.size[1] + 2 * self.padding
    }

    /// Pixels of a padded plane.
    pub(super) fn area(&self) -> usize {
        (self.size[0] + 2 * self.padding) * self.columns()
    }

    /// Numbers of a group of images side by side.
    pub(super) fn len(&self) -> usize {
        self.channels * self.area() * self.lanes
    }

    /// Numbers of one image.
    fn image(&self) -> usize {
        self.channels * self.size[0] * self.size[1]
    }

    /// Lays images, at most one for each lane, side by side in `planes`; borders and lanes without
    /// an image become zero.
    pub(super) fn spread(&self, images: &[f32], planes: &mut [f32]) {
        let count = images.len() / self.image();
        if count < self.lanes {
            planes.fill(0.0);
        } else {
            self.zero_borders(planes);
        }
        self.rows(|source, target| {
            let width = self.size[1];
            let mut rows = [&images[..0]; WIDEST];
            for (lane, row) in rows[..count].iter_mut().enumerate() {
                *row = &images[lane * self.image() + source..][..width];
            }
            let pixels = planes[target..][..width * self.lanes].chunks_exact_mut(self.lanes);
            for (x, pixel) in pixels.enumerate() {
                for (value, row) in pixel.iter_mut().zip(&rows[..count]) {
                    *value = row[x];
                }
            }
        });
    }

    /// Zeroes what lies around the images.
    fn zero_borders(&self, planes: &mut [f32]) {
        let row = self.columns() * self.lanes;
        let (above, beside) = (self.padding * row, self.padding * self.lanes);
        if self.padding == 0 {
            return;
        }
        for plane in planes.chunks_exact_mut(self.area() * self.lanes) {
            let (first, rest) = plane.split_at_mut(above);
            let (image, last) = rest.split_at_mut(self.size[0] * row);
            first.fill(0.0);
            last.fill(0.0);
            for row in image.chunks_exact_mut(row) {
                row[..beside].fill(0.0);
                row[self.size[1] * self.lanes + beside..].fill(0.0);
            }
        }
    }

    /// The inverse of [`spread`](Self::spread).
    pub(super) fn gather(&self, planes: &[f32], images: &mut [f32]) {
        let (width, size) = (self.size[1], self.image());
        self.rows(|source, target| {
            let pixels = &planes[target..][..width * self.lanes];
            for (lane, image) in images.chunks_exact_mut(size).enumerate() {
                let row = &mut image[source..][..width];
                for (value, pixel) in row.iter_mut().zip(pixels.chunks_exact(self.lanes)) {
                    *value = pixel[lane];
                }
            }
        });
    }

    /// Calls `row(in an image, in the planes)` with the first number of every row of pixels.
    fn rows(&self, mut row: impl FnMut(usize, usize)) {
        let [height, width] = self.size;
        for channel in 0..self.channels {
            for y in 0..height {
                let padded = channel * self.area() + (y + self.padding) * self.columns();
                row((channel * height + y) * width, (padded + self.padding) * self.lanes);
            }
        }
    }
}

/// The weight `[channels_out, channels_in, ky, kx]` in the order a kernel reads it:
/// `[rows / tile, inner, taps, tile]`, missing rows zero. `rows` are output channels and `inner`
/// input channels, or the other way round with `transposed`.
pub(super) fn packed<const TILE: usize>(
    conv: &Conv2d,
    weight: &[f32],
    transposed: bool,
) -> Vec<[f32; TILE]> {
    let taps = conv.kernel[0] * conv.kernel[1];
    let (rows, inner) = if transposed {
        (conv.channels_in, conv.channels_out)
    } else {
        (conv.channels_out, conv.channels_in)
    };
    let mut packed = vec![[0.0; TILE]; rows.div_ceil(TILE) * inner * taps];
    for (index, weight) in weight.chunks_exact(taps).enumerate() {
        let (out, input) = (index / conv.channels_in, index % conv.channels_in);
        let (row, column) = if transposed { (input, out) } else { (out, input) };
        for (tap, weight) in weight.iter().enumerate() {
            packed[(row / TILE * inner + column) * taps + tap][row % TILE] = *weight;
        }
    }
    packed
}

/// Where each tap of the kernel lies in a padded plane, from the tap at its corner.
pub(super) fn taps(conv: &Conv2d, planes: &Planes) -> Vec<usize> {
    let [rows, columns] = conv.kernel;
    (0..rows)
        .flat_map(|y| (0..columns).map(move |x| (y, x)))
        .map(|(y, x)| y * planes.columns() + x)
        .collect()
}

/// For every output, row by row, where its corner tap lies in a padded plane.
pub(super) fn corners(conv: &Conv2d, planes: &Planes) -> Vec<usize> {
    let [rows, columns] = conv.output();
    let corner = |y: usize, x: usize| (y * planes.columns() + x) * conv.stride;
    (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))).map(|(y, x)| corner(y, x)).collect()
}

/// Tiles of `TILE` outputs that cover `pixels`: the first output of each and how many of its first
/// ones an earlier tile has done. The last tile is moved back to end with the last output.
pub(super) fn tiles<const TILE: usize>(pixels: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..pixels.div_ceil(TILE)).map(move |tile| {
        let first = (tile * TILE).min(pixels.saturating_sub(TILE));
        (first, tile * TILE - first)
    })
}
