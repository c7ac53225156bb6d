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

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn tiles_are_rectangles_of_about_the_same_size_that_cover_the_image() {
        for (width, height) in [(1, 1), (3, 2), (8, 8), (9, 17), (64, 48), (346, 260)] {
            let tiles = Tiles::for_sensor(SensorSize { width, height });
            let (width, height) = (usize::from(width), usize::from(height));
            let (columns, rows) = (width.min(8), height.min(8));
            assert_eq!(tiles.count(), columns * rows);
            let mut pixels = BTreeMap::new();
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                *pixels.entry(tiles.at(x, y)).or_insert(0) += 1;
                // Whole rows of tiles before it, whole columns before it.
                assert_eq!(tiles.at(x, y), tiles.at(0, y) + tiles.at(x, 0));
                assert_eq!(
                    (tiles.at(x, 0), tiles.at(0, y)),
                    (x * 8 / width.max(8), y * 8 / height.max(8) * columns)
                );
            }
            assert!(pixels.keys().copied().eq(0..tiles.count()), "{width}x{height}");
            let (least, most) = (
                width / columns * (height / rows),
                width.div_ceil(columns) * height.div_ceil(rows),
            );
            assert!(pixels.values().all(|n| (least..=most).contains(n)), "{width}x{height}");
        }
    }
}
