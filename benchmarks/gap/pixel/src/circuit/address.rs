//! Addresses of the draws that belong to single events.

/// Length of a cell of [`NoiseAddress::Time`], s.
const CELL_S: f64 = 8e-3;

/// Address of the draws of jitter and of comparator noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum NoiseAddress {
    /// The count of events so far: of the recording for jitter, of the pixel for comparators. One
    /// event more gives all later ones other draws, so that only effects that appear alone can be
    /// compared.
    #[default]
    Count,
    /// The cell of 8 ms in which the event lies, and its place among the events of the pixel in that
    /// cell: one event more leaves the draws of all other cells alone. Recordings with and without
    /// an effect then differ by the effect, whatever else the camera has.
    Time,
}

/// Place of an event in its cell.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CellCounter {
    cell: u64,
    ordinal: u64,
}

impl CellCounter {
    /// Index of the draw of the next event of a pixel, which is at `t_s`.
    pub(crate) fn index(&mut self, t_s: f64) -> u64 {
        let cell = (t_s.max(0.0) / CELL_S) as u64 + 1;
        self.ordinal = if cell == self.cell { self.ordinal + 1 } else { 0 };
        self.cell = cell;
        cell << 24 | self.ordinal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn indices(times_s: &[f64]) -> Vec<u64> {
        let mut counter = CellCounter::default();
        times_s.iter().map(|t_s| counter.index(*t_s)).collect()
    }

    #[test]
    fn one_event_more_leaves_the_draws_of_other_cells_alone() {
        let before = indices(&[0.001, 0.002, 0.05, 0.3]);
        let after = indices(&[0.001, 0.0015, 0.002, 0.05, 0.3]);
        assert_eq!(before[..2], after[..2]);
        assert_eq!(before[2..], after[3..]);
        let mut distinct = after;
        distinct.dedup();
        assert_eq!(distinct.len(), 5);
    }
}
