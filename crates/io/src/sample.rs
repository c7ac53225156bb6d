//! Events of tests, and all that a source has.

use evpose_core::{Event, Micros, Polarity};

use crate::{Columns, EventSource, IoError};

pub(crate) fn event(t: i64, x: u16, y: u16, on: bool) -> Event {
    Event { t: Micros(t), x, y, polarity: Polarity::from_on(on) }
}

/// All events, remarks, and the fault that ended them.
pub(crate) fn read_all(source: &mut dyn EventSource) -> (Columns, Vec<String>, Option<IoError>) {
    let mut columns = Columns::new();
    let fault = source.read_rest(&mut columns).err();
    (columns, source.remarks(), fault)
}
