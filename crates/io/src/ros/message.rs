//! Messages that hold events.
//!
//! | type | events |
//! |---|---|
//! | `event_camera_msgs/EventPacket` (older: `event_array_msgs/EventArray`) | bytes in an encoding that the message names |
//! | `dvs_msgs/EventArray`, `prophesee_event_msgs/EventArray` | a list of `uint16 x, uint16 y, time ts, bool polarity` |
//!
//! | encoding | an event |
//! |---|---|
//! | `evt3` | words of [EVT 3.0](crate::evt), going on from message to message |
//! | `mono` | 64 bits: nanoseconds after `time_base`, column 32 to 47, row 48 to 62, polarity 63 |
//! | `libcaer` | 32 bits: polarity 1, row 2 to 16, column 17 to 31; then microseconds after `time_base`, 31 bits |
//! | `libcaer_cmp` | words of 16 bits, as EVT 3.0 with rows and columns exchanged, times after `time_base` |
//! | `trigger` | edges at a trigger input, which are no events: counted |
//!
//! # Source
//! <https://github.com/ros-event-camera/event_camera_msgs>, `event_camera_codecs` for the encodings;
//! <https://github.com/uzh-rpg/rpg_dvs_ros>; <https://github.com/prophesee-ai/prophesee_ros_wrapper>

use std::borrow::Cow;

use evpose_core::{Event, Micros, Polarity, SensorSize};

use zrip::decompress_with_limit;

use super::fields::{Fields, Reason, Serialisation};
use crate::evt::Evt3Decoder;
use crate::{Columns, Decoder};

/// Bytes of an event in a list, at least.
const LISTED: usize = 13;
/// How a message begins that the recorder of ROS 2 packed, and bytes that one may become.
const ZSTANDARD: &[u8] = b"\x28\xb5\x2f\xfd";
const MAX_BYTES: usize = 1 << 28;
/// Events of a packet that are believed, 67 million: two bytes may be twelve of them.
const MAX_EVENTS: usize = 1 << 26;
/// Bytes of EVT 3.0 between two looks at their count.
const SLICE: usize = 1 << 20;

/// A message itself, or what the recorder of ROS 2 packed it from.
pub(super) fn unpacked(message: &[u8]) -> Result<Cow<'_, [u8]>, Reason> {
    if !message.starts_with(ZSTANDARD) {
        return Ok(message.into());
    }
    let message = decompress_with_limit(message, MAX_BYTES);
    Ok(message.map_err(|fault| format!("Zstandard: {fault}"))?.into())
}

/// Types of messages with events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EventType {
    Packet,
    List,
}

impl EventType {
    /// The type by its name, `package/Name` or `package/msg/Name`.
    pub(super) fn by_name(name: &str) -> Option<Self> {
        match (name.split('/').next()?, name.rsplit('/').next()?) {
            ("event_camera_msgs", "EventPacket") | ("event_array_msgs", "EventArray") => {
                Some(Self::Packet)
            }
            ("dvs_msgs" | "prophesee_event_msgs", "EventArray") => Some(Self::List),
            _ => None,
        }
    }
}

/// Turns messages of a topic into events, their times microseconds of the sensor.
#[derive(Debug, Clone)]
pub(super) struct MessageDecoder {
    kind: EventType,
    serialisation: Serialisation,
    evt3: Evt3Decoder,
    /// The size that the first message states.
    pub(super) sensor: Option<SensorSize>,
    /// Encoding of the first message with events.
    pub(super) encoding: Option<&'static str>,
    /// Time of the header of the first message with events, microseconds since 1970.
    pub(super) header_us: Option<i64>,
    next_number: Option<u64>,
    missing: u64,
    triggers: u64,
    unknown: u64,
}

impl MessageDecoder {
    pub(super) fn new(kind: EventType, serialisation: Serialisation) -> Self {
        Self {
            kind,
            serialisation,
            evt3: Evt3Decoder::new(None),
            sensor: None,
            encoding: None,
            header_us: None,
            next_number: None,
            missing: 0,
            triggers: 0,
            unknown: 0,
        }
    }

    /// Appends the events of a message; before a fault, those that stand before it.
    pub(super) fn decode(&mut self, message: &[u8], columns: &mut Columns) -> Result<(), Reason> {
        let message = unpacked(message)?;
        let mut fields = Fields::new(&message, self.serialisation)?;
        let header_us = fields.header_us()?;
        let (height, width) = (fields.u32()?, fields.u32()?);
        if let (Ok(width @ 1..), Ok(height @ 1..)) = (u16::try_from(width), u16::try_from(height)) {
            self.sensor = self.sensor.or(Some(SensorSize { width, height }));
        }
        let before = columns.len();
        let decoded = match self.kind {
            EventType::Packet => self.packet(&mut fields, columns),
            EventType::List => {
                self.encoding = Some("list");
                list(&mut fields, columns)
            }
        };
        // A message without events says nothing about the time of the first event.
        if columns.len() > before {
            self.header_us = self.header_us.or(Some(header_us));
        }
        decoded
    }

    fn packet(&mut self, fields: &mut Fields<'_>, columns: &mut Columns) -> Result<(), Reason> {
        let (number, base) = (fields.u64()?, fields.u64()?);
        let encoding = fields.text()?;
        if fields.u8()? != 0 {
            return Err("events in the byte order of a big-endian machine".into());
        }
        let bytes = fields.bytes()?;
        let missing = self.next_number.map_or(0, |next| number.saturating_sub(next));
        self.missing = self.missing.saturating_add(missing);
        // A sequence that begins again is that of a driver that was started again: its first words go on
        // with none before.
        if self.next_number.is_some_and(|next| number < next) {
            self.evt3.restart();
        }
        self.next_number = number.checked_add(1);
        let name = match encoding {
            "evt3" => {
                evt3(&mut self.evt3, bytes, columns, MAX_EVENTS)?;
                "evt3"
            }
            "mono" => {
                mono(bytes, base, columns)?;
                "mono"
            }
            "libcaer" => {
                libcaer(bytes, base, columns)?;
                "libcaer"
            }
            "libcaer_cmp" => {
                self.unknown += libcaer_words(bytes, base, columns, MAX_EVENTS)?;
                "libcaer_cmp"
            }
            "trigger" => {
                self.triggers += (bytes.len() / 8) as u64;
                return Ok(());
            }
            other => return Err(format!("events in the encoding `{other}` are not read").into()),
        };
        self.encoding = self.encoding.or(Some(name));
        Ok(())
    }

    pub(super) fn remarks(&self) -> impl Iterator<Item = String> {
        [
            (self.missing, "messages are missing in the sequence"),
            (self.triggers, "edges of trigger inputs are no events: they are left out"),
            (self.unknown, "words of unknown types are passed over"),
        ]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .chain(self.evt3.remarks())
    }
}

/// The microsecond of a time in nanoseconds.
fn micros(base_ns: u64, after_ns: u64) -> Micros {
    Micros((base_ns.saturating_add(after_ns) / 1_000).cast_signed())
}

/// A fault if a packet has more events than are believed.
fn believed(events: usize, most: usize) -> Result<(), Reason> {
    if events > most { Err(format!("a packet of more than {most} events").into()) } else { Ok(()) }
}

/// Decodes a packet in slices.
fn evt3(
    decoder: &mut Evt3Decoder,
    bytes: &[u8],
    columns: &mut Columns,
    most: usize,
) -> Result<(), Reason> {
    let (before, mut took) = (columns.len(), 0);
    // A packet of vectors is refused before its events fill the memory.
    for slice in bytes.chunks(SLICE) {
        took += decoder.decode(slice, false, columns).map_err(|fault| fault.reason)?;
        believed(columns.len() - before, most)?;
    }
    if took < bytes.len() { Err("a packet ends within a word of EVT 3.0".into()) } else { Ok(()) }
}

/// Words of 64 bits; a fault if the bytes end within one.
fn words(bytes: &[u8]) -> Result<impl Iterator<Item = u64>, Reason> {
    let (words, rest) = bytes.as_chunks::<8>();
    believed(words.len(), MAX_EVENTS)?;
    match rest {
        [] => Ok(words.iter().map(|word| u64::from_le_bytes(*word))),
        _ => Err("a packet ends within an event".into()),
    }
}

fn mono(bytes: &[u8], base: u64, columns: &mut Columns) -> Result<(), Reason> {
    words(bytes)?.for_each(|word| {
        columns.push(Event {
            t: micros(base, word & 0xFFFF_FFFF),
            x: (word >> 32) as u16,
            y: (word >> 48 & 0x7FFF) as u16,
            polarity: Polarity::from_on(word >> 63 == 1),
        });
    });
    Ok(())
}

fn libcaer(bytes: &[u8], mut base: u64, columns: &mut Columns) -> Result<(), Reason> {
    let mut before = 0;
    words(bytes)?.for_each(|word| {
        let time = word >> 32 & 0x7FFF_FFFF;
        // Within a packet, 31 bits of microseconds may begin again.
        if time < before {
            base = base.saturating_add((1 << 31) * 1_000);
        }
        before = time;
        columns.push(Event {
            t: micros(base, time * 1_000),
            x: (word >> 17 & 0x7FFF) as u16,
            y: (word >> 2 & 0x7FFF) as u16,
            polarity: Polarity::from_on(word >> 1 & 1 == 1),
        });
    });
    Ok(())
}

/// Returns the count of words of unknown types.
fn libcaer_words(
    bytes: &[u8],
    base: u64,
    columns: &mut Columns,
    most: usize,
) -> Result<u64, Reason> {
    let before = columns.len();
    let (words, rest) = bytes.as_chunks::<2>();
    let (mut high, mut low, mut x, mut unknown) = (0, 0, 0, 0);
    // Row and polarity that the next vector begins at.
    let (mut vector_y, mut is_on) = (0, false);
    for word in words {
        let word = u16::from_le_bytes(*word);
        let (value, flag) = (word & 0x7FF, word & 0x800 != 0);
        let mut put = |y, is_on| {
            let t = micros(base, (high | low) * 1_000);
            columns.push(Event { t, x, y, polarity: Polarity::from_on(is_on) });
        };
        match word >> 12 {
            0 => high = u64::from(word & 0xFFF) << 12,
            1 => low = u64::from(word & 0xFFF),
            2 => x = value,
            3 => put(value, flag),
            4 => (vector_y, is_on) = (value, flag),
            5 => {
                (0..8)
                    .filter(|bit| word >> bit & 1 == 1)
                    .for_each(|bit| put(vector_y + bit, is_on));
                vector_y = (vector_y + 8) & 0x7FF;
                believed(columns.len() - before, most)?;
            }
            _ => unknown += 1,
        }
    }
    match rest {
        [] => Ok(unknown),
        _ => Err("a packet ends within a word".into()),
    }
}

fn list(fields: &mut Fields<'_>, columns: &mut Columns) -> Result<(), Reason> {
    let count = fields.u32()? as usize;
    // Asked for before there is anything of it: a length must not fill the memory.
    columns.reserve(count.min(fields.left() / LISTED));
    for _ in 0..count {
        let (x, y) = (fields.u16()?, fields.u16()?);
        let t = Micros(fields.time_us()?);
        let polarity = Polarity::from_on(fields.u8()? != 0);
        columns.push(Event { t, x, y, polarity });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn events(columns: &Columns) -> Vec<(i64, u16, u16, bool)> {
        columns.iter().map(|e| (e.t.0, e.x, e.y, e.polarity.is_on())).collect()
    }

    #[test]
    fn words_of_libcaer_that_begin_again_go_on() {
        let word = |t: u32, x: u32, y: u32, on: u32| {
            [(x << 17 | y << 2 | on << 1 | 1).to_le_bytes(), t.to_le_bytes()].concat()
        };
        let bytes = [word(0x7FFF_FFFF, 345, 259, 1), word(1, 0, 7, 0)].concat();
        let mut columns = Columns::new();
        libcaer(&bytes, 5_000, &mut columns).unwrap();
        let begin = 5 + 0x7FFF_FFFF;
        assert_eq!(events(&columns), [(begin, 345, 259, true), (begin + 2, 0, 7, false)]);
        assert!(libcaer(&bytes[..9], 0, &mut columns).is_err());
    }

    #[test]
    fn words_of_compressed_libcaer_are_rows_and_vectors_of_a_column() {
        let words: [u16; 8] = [0x2005, 0x1003, 0x3807, 0x0002, 0x1001, 0x4010, 0x5081, 0x6000];
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let mut columns = Columns::new();
        assert_eq!(libcaer_words(&bytes, 1_000_000, &mut columns, 3), Ok(1));
        let late = 1_000 + (2 << 12) + 1;
        assert_eq!(
            events(&columns),
            [(1_003, 5, 7, true), (late, 5, 16, false), (late, 5, 23, false)]
        );
        let error = libcaer_words(&bytes, 0, &mut columns, 2).unwrap_err();
        assert_eq!(error, "a packet of more than 2 events");
    }

    #[test]
    fn a_packet_of_evt_3_is_as_long_as_it_is_but_not_of_more_events_than_are_believed() {
        // High time, row, base; then vectors of twelve, more than a slice of them.
        let vectors = SLICE / 2 + 5;
        let words = [0x8001, 0x0007, 0x3000].into_iter().chain((0..vectors).map(|_| 0x4001_u16));
        let bytes: Vec<u8> = words.flat_map(u16::to_le_bytes).collect();
        let read = |most| {
            let mut columns = Columns::new();
            let read = evt3(&mut Evt3Decoder::new(None), &bytes, &mut columns, most);
            (read, columns.len())
        };
        assert_eq!(read(vectors), (Ok(()), vectors));
        assert!(read(vectors - 1).0.is_err());
        assert!(read(SLICE / 4).1 <= SLICE / 2);
    }

    #[test]
    fn a_list_that_claims_more_than_it_has_is_a_fault_behind_what_it_has() {
        let mut message = vec![0; 4 + 8 + 4];
        message.extend([180_u32, 240, 9].map(u32::to_le_bytes).concat());
        message.extend([3, 0, 4, 0, 2, 0, 0, 0, 0xE8, 3, 0, 0, 1]);
        let mut decoder = MessageDecoder::new(EventType::List, Serialisation::Ros1);
        let mut columns = Columns::new();
        assert!(decoder.decode(&message, &mut columns).is_err());
        assert_eq!(events(&columns), [(2_000_001, 3, 4, true)]);
        assert_eq!(decoder.sensor, Some(SensorSize::DAVIS240C));
    }
}
