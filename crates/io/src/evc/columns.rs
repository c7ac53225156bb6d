//! Records turned into columns, a first-level cache at a time.

use evpose_core::{CoreError, EventStream, Micros, Polarity};

use super::RECORD;

/// Events after which the columns are handed on: 13 bytes each.
const FULL: usize = 2048;

/// Events on their way from records to a stream.
#[derive(Debug, Default)]
pub(super) struct Columns {
    t: Vec<Micros>,
    x: Vec<u16>,
    y: Vec<u16>,
    polarity: Vec<Polarity>,
}

impl Columns {
    /// Appends records of events at time `t`.
    pub(super) fn decode(&mut self, t: Micros, records: &[[u8; RECORD]]) {
        self.t.resize(self.t.len() + records.len(), t);
        self.x.extend(records.iter().map(|&[low, high, ..]| u16::from_le_bytes([low, high])));
        self.y.extend(records.iter().map(|&[_, _, y, _]| u16::from(y)));
        self.polarity.extend(records.iter().map(|&[.., p]| Polarity::from_on(p == 1)));
    }

    pub(super) fn is_full(&self) -> bool {
        self.t.len() >= FULL
    }

    /// Appends everything to `stream` and is empty.
    pub(super) fn move_to(&mut self, stream: &mut EventStream) -> Result<(), CoreError> {
        stream.extend_columns(&self.t, &self.x, &self.y, &self.polarity)?;
        self.t.clear();
        self.x.clear();
        self.y.clear();
        self.polarity.clear();
        Ok(())
    }
}
