//! Decoding of transfers into events.

use evpose_core::{Event, Micros, Polarity};
use evpose_io::Columns;
use neuromorphic_drivers::adapters::Adapter;
use neuromorphic_drivers::types;

/// Appends the events of a transfer. Frames, inertial samples and triggers are skipped.
pub(super) fn decode(adapter: &mut Adapter, bytes: &[u8], columns: &mut Columns) {
    let push = |event: types::PolarityEvent<u64, u16, u16>| {
        let types::PolarityEvent { t, x, y, polarity } = event;
        let polarity = Polarity::from_on(polarity == types::Polarity::On);
        columns.push(Event { t: Micros(t as i64), x, y, polarity });
    };
    match adapter {
        Adapter::Davis346(adapter) => adapter.convert(bytes, push, |_| {}, |_| {}, |_| {}),
        Adapter::Dvxplorer(adapter) => adapter.convert(bytes, push, |_| {}, |_| {}),
        Adapter::Evt3(adapter) => adapter.convert(bytes, push, |_| {}),
    }
}

#[cfg(test)]
mod tests;
