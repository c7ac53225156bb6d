//! The last few rows of an image on its way from step to step, and what lies around a pixel.

/// Rows, each where that of `n` rows before was.
#[derive(Debug, Clone, Default)]
pub(super) struct Ring<T> {
    rows: Vec<Vec<T>>,
}

impl<T: Copy + Default> Ring<T> {
    /// Makes room for `rows` rows of `length` values, all zero.
    pub(super) fn reset(&mut self, rows: usize, length: usize) {
        self.rows.resize_with(rows, Vec::new);
        for row in &mut self.rows {
            row.clear();
            row.resize(length, T::default());
        }
    }

    /// Row `y`, if it is one of the last.
    pub(super) fn row(&self, y: usize) -> &[T] {
        &self.rows[y % self.rows.len()]
    }

    /// Buffer of row `y`.
    pub(super) fn row_mut(&mut self, y: usize) -> &mut [T] {
        let rows = self.rows.len();
        &mut self.rows[y % rows]
    }
}

/// The values at distances 0, 1, … to both sides of those of a row, along it or across it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Around<'a, T, const HALF: usize> {
    /// Before it; element 0 is the row itself.
    pub(super) before: [&'a [T]; HALF],
    /// Behind it; element 0 is the row itself.
    pub(super) behind: [&'a [T]; HALF],
}

impl<'a, T: Copy + Default, const HALF: usize> Around<'a, T, HALF> {
    /// Along a row that has `HALF - 1` values more at both of its ends.
    #[inline(always)]
    pub(super) fn along(padded: &'a [T]) -> Self {
        let reach = HALF - 1;
        let width = padded.len() - 2 * reach;
        Self {
            before: std::array::from_fn(
                #[inline(always)]
                |k| &padded[reach - k..][..width],
            ),
            behind: std::array::from_fn(
                #[inline(always)]
                |k| &padded[reach + k..][..width],
            ),
        }
    }

    /// Across row `y`; `inside` brings a row above or below the image back into it.
    pub(super) fn across(ring: &'a Ring<T>, y: usize, inside: impl Fn(isize) -> usize) -> Self {
        let row = |offset: isize| ring.row(inside(y as isize + offset));
        Self {
            before: std::array::from_fn(|k| row(-(k as isize))),
            behind: std::array::from_fn(|k| row(k as isize)),
        }
    }

    /// Cut to `width` values each, so that loops over them need no further checks.
    #[inline(always)]
    pub(super) fn cut(self, width: usize) -> Self {
        Self {
            before: self.before.map(
                #[inline(always)]
                |row| &row[..width],
            ),
            behind: self.behind.map(
                #[inline(always)]
                |row| &row[..width],
            ),
        }
    }
}
