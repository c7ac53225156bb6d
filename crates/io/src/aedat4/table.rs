//! The data table at the end of a file: where every packet is, and what times it spans.

use evpose_core::Micros;

use super::build::{Builder, Field};
use super::flat::{Broken, Table, identifier};

/// A packet, as the table knows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry {
    /// Offset of its body in the file.
    pub(super) body: i64,
    pub(super) stream: i32,
    /// Bytes of its body.
    pub(super) size: i32,
    /// Events, samples or triggers in it; 1 for a frame.
    pub(super) elements: i64,
    pub(super) first: Micros,
    pub(super) last: Micros,
}

pub(super) fn decode(bytes: &[u8]) -> Result<Vec<Entry>, Broken> {
    if identifier(bytes)? != *b"FTAB" {
        return Err(Broken { at: 8, reason: "it is none" });
    }
    let entry = |table: Table<'_>| {
        let long = |slot| Ok(table.i64(slot)?.unwrap_or(0));
        let [stream, size] = table.pair(1)?;
        let (first, last) = (Micros(long(3)?), Micros(long(4)?));
        Ok(Entry { body: long(0)?, stream, size, elements: long(2)?, first, last })
    };
    Table::root(bytes)?.vector(0)?.tables()?.map(|table| entry(table?)).collect()
}

pub(super) fn encode<'a>(builder: &'a mut Builder, entries: &[Entry]) -> &'a [u8] {
    builder.begin(*b"FTAB");
    let place = builder.root(&[Field::Next]);
    let fields = |entry: &Entry| {
        [
            Field::Long(entry.body),
            // The schema has the two in one struct.
            Field::Pair([entry.stream, entry.size]),
            Field::Long(entry.elements),
            Field::Long(entry.first.0),
            Field::Long(entry.last.0),
        ]
    };
    builder.tables(place, entries.iter().map(fields));
    builder.finish()
}
