//! AEDAT 3.0 and 3.1, as caer writes it and DVS128 Gesture is distributed.
//!
//! A header of lines that begin with `#`, up to `#!END-HEADER`, then packets of events of one type: 28
//! bytes say which and how many, little-endian as everything.
//!
//! | bytes of a packet's header | |
//! |---|---|
//! | 0..2, 2..4 | type (1: polarity), source |
//! | 4..8 | bytes of an event |
//! | 8..12, 12..16 | place of the time stamp in an event; wraparounds of 31 bits before |
//! | 16..20, 20..24, 24..28 | events there is room for, events, valid ones |
//!
//! Of a polarity event, bit 0 says whether it is valid, bit 1 its polarity, bits 2 to 16 the row, bits
//! 17 to 31 the column; then comes the time in microseconds, of 31 bits. Packets of other types are
//! passed over and counted. Compressed files (`#Format: SerializedTS`) are refused.
//!
//! # Source
//! <https://docs.inivation.com/software/software-advanced-usage/file-formats/aedat-3.1.html>

use evpose_core::{Event, Micros, Polarity, SensorSize};

use crate::open::{Format, no_labels};
use crate::{
    BlockSource, Columns, DecodeFault, DecodeResult, Decoder, EventSource, Header, Input, IoError,
    OpenOptions,
};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "aedat3",
    summary: "iniVation's AEDAT 3.0 and 3.1, as DVS128 Gesture",
    endings: &[".aedat"],
    probe: |head| head.starts_with(b"#!AER-DAT3"),
    open,
    create: None,
    labels: no_labels,
};

/// Ends the header.
const END: &[u8] = b"#!END-HEADER";
/// Longest header.
const MAX_HEADER: usize = 1 << 16;
/// Bytes of a packet's header, and of a polarity event.
const PACKET: usize = 28;
const EVENT: usize = 8;
/// Type of events of brightness.
const POLARITY: u16 = 1;
/// Largest packet that is believed.
const MAX_EVENTS: u32 = 1 << 24;
/// Sensors by what the header calls them.
const SENSORS: [(&str, SensorSize); 4] = [
    ("DVS128", SensorSize { width: 128, height: 128 }),
    ("DAVIS240", SensorSize { width: 240, height: 180 }),
    ("DAVIS346", SensorSize { width: 346, height: 260 }),
    ("DAVIS640", SensorSize { width: 640, height: 480 }),
];

fn open(mut input: Input, _: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let head = input.head(MAX_HEADER)?;
    let damaged = |reason: &'static str| IoError::damaged(&input.path, 0, reason);
    let end = head.windows(END.len()).position(|bytes| bytes == END);
    let end = end.ok_or_else(|| damaged("the header has no end"))?;
    let text = String::from_utf8_lossy(&head[..end]).into_owned();
    let value =
        |name: &str| text.lines().find_map(|line| line.strip_prefix(name)?.split(':').nth(1));
    if value("#Format").is_some_and(|format| format.trim() != "RAW") {
        return Err(damaged("compressed AEDAT 3 is not read: DV makes AEDAT 4 of it"));
    }
    let line = head[end..].iter().position(|byte| *byte == b'\n').map_or(END.len(), |at| at + 1);
    // The header names the camera alone, and the size of its sensor follows from that.
    let usual_sensor = value("#Source").and_then(|source| {
        SENSORS.iter().find(|(name, _)| source.contains(name)).map(|(_, size)| *size)
    });
    let header = Header { usual_sensor, ..Header::default() };
    Ok(Box::new(BlockSource::new(input, (end + line) as u64, header, Packets::default())))
}

/// Packets as they follow each other.
#[derive(Debug, Clone, Default)]
struct Packets {
    /// Events that the packet has left, their size, and what is added to their times.
    left: u32,
    size: usize,
    offset_us: i64,
    is_polarity: bool,
    /// Bytes of a packet of another type that are still to be passed over.
    skipped: u64,
    others: u64,
    invalid: u64,
}

impl Packets {
    /// Takes the header of a packet.
    fn begin(&mut self, header: &[u8; PACKET]) -> Result<(), &'static str> {
        let at =
            |k: usize| u32::from_le_bytes([header[k], header[k + 1], header[k + 2], header[k + 3]]);
        (self.size, self.left) = (at(4) as usize, at(20));
        // Times of events have 31 bits; the header counts their overflows.
        self.offset_us = i64::from(at(12)) << 31;
        self.is_polarity = u16::from_le_bytes([header[0], header[1]]) == POLARITY;
        if self.is_polarity && self.size != EVENT {
            return Err("polarity events of another size than 8 bytes");
        }
        if self.size == 0 || self.left > MAX_EVENTS {
            return Err("no header of a packet");
        }
        if !self.is_polarity {
            self.others += u64::from(self.left);
            self.skipped = u64::from(self.left) * self.size as u64;
            self.left = 0;
        }
        Ok(())
    }
}

impl Decoder for Packets {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        let mut at = 0;
        loop {
            let rest = &bytes[at..];
            // A packet may be longer than a block, so that what is left to skip outlasts the call.
            if self.skipped > 0 {
                let passed = self.skipped.min(rest.len() as u64);
                self.skipped -= passed;
                at += passed as usize;
                if self.skipped > 0 {
                    return Ok(at);
                }
                continue;
            }
            if self.left == 0 {
                let Some(header) = rest.first_chunk::<PACKET>() else { return Ok(at) };
                self.begin(header).map_err(|reason| DecodeFault { at, reason: reason.into() })?;
                at += PACKET;
                continue;
            }
            if rest.len() < self.size {
                return Ok(at);
            }
            self.left -= 1;
            at += self.size;
            let Some(event) = rest.first_chunk::<EVENT>() else { return Ok(at) };
            let data = u32::from_le_bytes([event[0], event[1], event[2], event[3]]);
            let time = u32::from_le_bytes([event[4], event[5], event[6], event[7]]);
            // Filters of cAER mark what they remove instead of taking it out.
            if data & 1 == 0 {
                self.invalid += 1;
                continue;
            }
            columns.push(Event {
                t: Micros(self.offset_us + i64::from(time & 0x7fff_ffff)),
                x: (data >> 17) as u16,
                y: (data >> 2 & 0x7fff) as u16,
                polarity: Polarity::from_on(data & 2 != 0),
            });
        }
    }

    fn missing(&self) -> Option<String> {
        match (self.left, self.skipped) {
            (0, 0) => None,
            (0, bytes) => Some(format!("the file ends {bytes} bytes before the end of a packet")),
            (events, _) => Some(format!("the last packet promises {events} more events")),
        }
    }

    fn remarks(&self) -> Vec<String> {
        let count = |n: u64, what: &str| (n > 0).then(|| format!("{n} {what}"));
        [
            count(self.others, "events of frames, triggers and motion are passed over"),
            count(self.invalid, "events are marked as invalid: they are left out"),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_as;
    use crate::sample::event;

    fn packet(kind: u16, overflows: u32, events: &[[u32; 2]]) -> Vec<u8> {
        let n = events.len() as u32;
        let mut bytes = [kind.to_le_bytes(), 1_u16.to_le_bytes()].concat();
        for value in [8, 4, overflows, n, n, n] {
            bytes.extend(value.to_le_bytes());
        }
        events.iter().flatten().for_each(|value| bytes.extend(value.to_le_bytes()));
        bytes
    }

    fn word(x: u32, y: u32, on: u32) -> u32 {
        x << 17 | y << 2 | on << 1 | 1
    }

    fn file(packets: &[Vec<u8>]) -> Vec<u8> {
        let head = "#!AER-DAT3.1\r\n#Format: RAW\r\n#Source 1: DVS128\r\n#!END-HEADER\r\n";
        [head.as_bytes(), &packets.concat()].concat()
    }

    fn open(bytes: Vec<u8>) -> Result<crate::Recording, IoError> {
        read_as(Input::memory("user01.aedat", bytes), &OpenOptions::default())
    }

    #[test]
    fn packets_of_events_are_read_and_others_counted() {
        let first =
            packet(1, 0, &[[word(3, 7, 1), 100], [word(127, 0, 0), 105], [word(9, 9, 1) - 1, 106]]);
        let second = packet(1, 1, &[[word(5, 6, 1), 7]]);
        let read = open(file(&[first, packet(2, 0, &[[1, 2]]), second])).unwrap();
        let want =
            [event(100, 3, 7, true), event(105, 127, 0, false), event((1 << 31) + 7, 5, 6, true)];
        assert_eq!(read.stream.iter().collect::<Vec<_>>(), want);
        assert_eq!((read.format, read.stream.sensor()), ("aedat3", SENSORS[0].1));
        assert!(read.remarks[0].starts_with("1 events of frames"), "{:?}", read.remarks);
        assert!(read.remarks[1].starts_with("1 events are marked"), "{:?}", read.remarks);
    }

    #[test]
    fn a_cut_file_is_damage_and_never_a_panic() {
        let whole = file(&[packet(1, 0, &[[word(3, 7, 1), 100]; 5])]);
        let header = file(&[]).len();
        for cut in 60..whole.len() {
            // Behind the header and no packet, nothing is known to be missing.
            match open(whole[..cut].to_vec()) {
                Ok(read) => assert!(cut == header && read.stream.is_empty(), "{cut}"),
                Err(error) => assert!(error.is_damage(), "{cut}: {error}"),
            }
        }
        let cut = open(whole[..whole.len() - 2 * EVENT].to_vec()).unwrap_err().to_string();
        assert!(cut.contains("promises 2 more events (3 events readable"), "{cut}");
        let mut others = packet(2, 0, &[[1, 2]; 3]);
        others.truncate(others.len() - EVENT);
        let cut = open(file(&[others])).unwrap_err().to_string();
        assert!(cut.contains("8 bytes before the end of a packet"), "{cut}");
        let text = String::from_utf8_lossy(&whole).replace("RAW", "SerializedTS");
        assert!(open(text.into_bytes()).unwrap_err().to_string().contains("compressed"));
    }
}
