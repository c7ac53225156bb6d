//! Packets of events: records of 16 bytes.
//!
//! | offset | type | meaning |
//! |---|---|---|
//! | 0 | `i64` | time in µs |
//! | 8 | `i16` | column |
//! | 10 | `i16` | row |
//! | 12 | `bool` | ON |

use evpose_core::{Micros, Polarity};
use evpose_cpu::vectorize;

use super::build::{Builder, Field};
use super::flat::{Broken, Table};
use crate::Columns;

/// Bytes of an event.
const EVENT: usize = 16;
/// Events that stay in the first-level cache while one column after the other is filled.
const AT_ONCE: usize = 1024;

/// Appends the events of a packet that are there, and says how many are missing.
pub(super) fn decode(bytes: &[u8], columns: &mut Columns) -> Result<usize, Broken> {
    let list = Table::root(bytes)?.vector(0)?;
    // Records that are there in part are counted as missing, below.
    let events = list.there(EVENT).as_chunks::<EVENT>().0;
    columns.reserve(events.len());
    vectorize(
        #[inline(always)]
        || {
            // Column by column over a piece that stays in the cache: each loop is one of vectors.
            for events in events.chunks(AT_ONCE) {
                let fields = events.iter();
                columns.t.extend(fields.clone().map(|event| Micros(time(event))));
                columns
                    .x
                    .extend(fields.clone().map(|event| u16::from_le_bytes([event[8], event[9]])));
                columns
                    .y
                    .extend(fields.clone().map(|event| u16::from_le_bytes([event[10], event[11]])));
                columns.polarity.extend(fields.map(|event| Polarity::from_on(event[12] != 0)));
            }
        },
    );
    Ok(list.count - events.len())
}

fn time(event: &[u8; EVENT]) -> i64 {
    let &[a, b, c, d, e, f, g, h, ..] = event;
    i64::from_le_bytes([a, b, c, d, e, f, g, h])
}

/// Writes a packet of events number `range` of the columns.
pub(super) fn encode<'a>(
    builder: &'a mut Builder,
    (t, x, y, polarity): (&[Micros], &[u16], &[u16], &[Polarity]),
) -> &'a [u8] {
    builder.begin(*b"EVTS");
    let place = builder.root(&[Field::Next]);
    let bytes = builder.vector(place, t.len(), 8);
    bytes.reserve(t.len() * EVENT);
    for (((t, x), y), polarity) in t.iter().zip(x).zip(y).zip(polarity) {
        let mut event = [0; EVENT];
        event[..8].copy_from_slice(&t.0.to_le_bytes());
        event[8..10].copy_from_slice(&x.to_le_bytes());
        event[10..12].copy_from_slice(&y.to_le_bytes());
        // The 3 bytes behind stay zero: the struct is padded to the alignment of its time.
        event[12] = *polarity as u8;
        bytes.extend_from_slice(&event);
    }
    builder.finish()
}
