//! The bytes of headers, of packets' heads, and of events.

use std::borrow::Cow;

use evpose_core::{Micros, Polarity, SensorSize};
use evpose_cpu::vectorize;

use crate::Columns;

/// Magic bytes of a stream.
pub const MAGIC: &[u8; 8] = b"EVPOSE1\n";
/// Bytes of what stands before the packets.
pub(super) const HEADER: usize = 16;

/// Magic bytes of a packet.
pub(super) const MARKER: &[u8; 4] = b"EVTS";
/// Bytes of what stands before its events.
pub(super) const HEAD: usize = 16;
/// Bytes of an event.
pub(super) const EVENT: usize = 8;

/// Events of a packet, at most: a sender that lives does not wait for more, and a count beyond is
/// noise.
pub(super) const MAX_EVENTS: u32 = 1 << 22;
/// Times lie so far from 0 at most, about 36,000 years: their differences are times, too.
pub(super) const LONGEST_US: i64 = 1 << 60;
/// Rows have 15 bits.
pub(super) const MAX_ROWS: u16 = 1 << 15;

/// Events that stay in the first-level cache while one column after the other is filled.
const AT_ONCE: usize = 1024;

/// The sensor that a header states, or the byte of the fault in it.
pub(super) fn sensor_of(header: &[u8; HEADER]) -> Result<SensorSize, (u64, Cow<'static, str>)> {
    let [a, b, c, d, e, f, g, h, rest @ ..] = *header;
    if [a, b, c, d, e, f, g, h] != *MAGIC {
        return Err((0, "the stream does not begin with `EVPOSE1`".into()));
    }
    let [w0, w1, h0, h1, reserved @ ..] = rest;
    let sensor =
        SensorSize { width: u16::from_le_bytes([w0, w1]), height: u16::from_le_bytes([h0, h1]) };
    if sensor.pixels() == 0 || sensor.height > MAX_ROWS {
        return Err((8, format!("a sensor of {sensor}").into()));
    }
    // Reserved bytes let a later version say that older readers would misread it.
    if reserved != [0; 4] {
        return Err((12, "the stream is of a later version: its reserved bytes are not 0".into()));
    }
    Ok(sensor)
}

/// The header of a stream.
pub(super) fn header(sensor: SensorSize) -> [u8; HEADER] {
    let mut bytes = [0; HEADER];
    bytes[..8].copy_from_slice(MAGIC);
    bytes[8..10].copy_from_slice(&sensor.width.to_le_bytes());
    bytes[10..12].copy_from_slice(&sensor.height.to_le_bytes());
    bytes
}

/// Head of a packet, before its events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Head {
    pub(super) count: u32,
    pub(super) base: Micros,
}

impl Head {
    /// The head that bytes are, if they are one.
    pub(super) fn parse(bytes: &[u8; HEAD]) -> Option<Self> {
        let [a, b, c, d, c0, c1, c2, c3, base @ ..] = *bytes;
        let head = Self {
            count: u32::from_le_bytes([c0, c1, c2, c3]),
            base: Micros(i64::from_le_bytes(base)),
        };
        let is_head = [a, b, c, d] == *MARKER
            && head.count <= MAX_EVENTS
            && (-LONGEST_US..=LONGEST_US).contains(&head.base.0);
        is_head.then_some(head)
    }

    pub(super) fn bytes(self) -> [u8; HEAD] {
        let mut bytes = [0; HEAD];
        bytes[..4].copy_from_slice(MARKER);
        bytes[4..8].copy_from_slice(&self.count.to_le_bytes());
        bytes[8..].copy_from_slice(&self.base.0.to_le_bytes());
        bytes
    }
}

/// Appends events.
pub(super) fn decode(base: Micros, events: &[[u8; EVENT]], columns: &mut Columns) {
    columns.reserve(events.len());
    vectorize(
        #[inline(always)]
        || {
            for events in events.chunks(AT_ONCE) {
                // A loop per column is vectorized; one loop that fills four columns is not.
                let words = events.iter().map(|event| u64::from_le_bytes(*event));
                columns.t.extend(words.clone().map(|w| Micros(base.0 + i64::from(w as u32))));
                columns.x.extend(words.clone().map(|w| (w >> 32) as u16));
                columns.y.extend(words.clone().map(|w| (w >> 48) as u16 & (MAX_ROWS - 1)));
                columns.polarity.extend(words.map(|w| Polarity::from_on(w >> 63 != 0)));
            }
        },
    );
}

/// An event, `since` microseconds behind the base of its packet.
pub(super) fn encode(since: u32, x: u16, y: u16, polarity: Polarity) -> [u8; EVENT] {
    let row = u64::from(y) | u64::from(polarity.is_on()) << 15;
    (u64::from(since) | u64::from(x) << 32 | row << 48).to_le_bytes()
}
