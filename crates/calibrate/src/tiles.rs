//! Parts of the image that are drawn with replacement: what makes one pixel of a pattern wrong
//! makes its neighbours wrong too.

use evpose_core::SensorSize;

/// Tiles along either axis, no smaller than a pixel.
const ALONG: usize = 8;

/// The image in tiles, row by row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tiles {
    size: SensorSize,
    columns: usize,
    rows: usize,
}

impl Tiles {
    pub(crate) fn for_sensor(size: SensorSize) -> Self {
        let (columns, rows) =
            (ALONG.min(usize::from(size.width)), ALONG.min(usize::from(size.height)));
        Self { size, columns, rows }
    }

    /// How many there are.
    pub(crate) fn count(self) -> usize {
        self.columns * self.rows
    }

    /// The tile of a pixel.
    pub(crate) fn at(self, x: usize, y: usize) -> usize {
        let column = x * self.columns / usize::from(self.size.width);
        let row = y * self.rows / usize::from(self.size.height);
        row * self.columns + column
    }
}
