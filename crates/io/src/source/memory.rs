//! Events of formats that are read whole.

use evpose_core::Micros;

use super::{EventSource, Header};
use crate::{Columns, IoError};

/// Events in a batch.
const BATCH: usize = 1 << 16;

/// A recording in memory, as a source.
#[derive(Debug)]
pub struct MemorySource {
    header: Header,
    columns: Columns,
    next: usize,
    remarks: Vec<String>,
}

impl MemorySource {
    /// A source of `columns`.
    pub fn new(header: Header, columns: Columns, remarks: Vec<String>) -> Self {
        Self { header, columns, next: 0, remarks }
    }
}

impl EventSource for MemorySource {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        let end = self.columns.len().min(self.next + BATCH);
        columns.t.extend_from_slice(&self.columns.t[self.next..end]);
        columns.x.extend_from_slice(&self.columns.x[self.next..end]);
        columns.y.extend_from_slice(&self.columns.y[self.next..end]);
        columns.polarity.extend_from_slice(&self.columns.polarity[self.next..end]);
        self.next = end;
        Ok(())
    }

    fn take_all(&mut self) -> Option<Columns> {
        (self.next == 0).then(|| std::mem::take(&mut self.columns))
    }

    fn seek(&mut self, t: Micros) -> Result<(), IoError> {
        let found = self.columns.t.iter().position(|&at| at >= t);
        self.next = found.unwrap_or(self.columns.len());
        Ok(())
    }

    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity};

    use super::*;

    #[test]
    fn all_is_handed_over_once_and_only_before_anything_was_read() {
        let event = |t| Event { t: Micros(t), x: 1, y: 2, polarity: Polarity::On };
        let events: Columns = (0..5).map(event).collect();
        let mut source = MemorySource::new(Header::default(), events.clone(), Vec::new());
        assert_eq!(source.take_all(), Some(events.clone()));
        let mut rest = Columns::new();
        source.next(&mut rest).unwrap();
        assert!(rest.is_empty());
        let mut source = MemorySource::new(Header::default(), events, Vec::new());
        source.next(&mut rest).unwrap();
        assert_eq!((rest.len(), source.take_all()), (5, None));
    }
}
