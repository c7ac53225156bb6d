//! Event Stream, the format of `event_stream`, loris and faery: five bytes an event.
//!
//! | bytes of the header | |
//! |---|---|
//! | 0..12, 12..15 | `Event Stream`, version 2.0.0 |
//! | 15 | type: 1 (DVS), 2 (ATIS); 0 (any bytes) and 4 (colours) have no events of contrast |
//! | 16..18, 18..20 | columns and rows |
//!
//! An event is a byte of time and polarity, then column and row from below, 16 bits each. Of a DVS's
//! byte, bit 0 is the polarity and bits 1 to 7 the microseconds since the event before; 255 stands for
//! 127 µs and no event, 254 for nothing. Of an ATIS's, bit 0 is set for the edges of exposures, which
//! are counted, bit 1 is the polarity and bits 2 to 7 are the microseconds; from 252 on, the lower two
//! bits are as many times 63 µs.
//!
//! # Source
//! `sepia.hpp` and `es/decoder.rs` of <https://github.com/neuromorphicsystems/event_stream> and
//! <https://github.com/aestream/faery>, read for the format. Rows are counted from below as the former
//! states it; what faery makes of other formats without turning it lies upside down.

use evpose_core::{Event, Micros, Polarity, SensorSize};

use crate::open::{Format, no_labels};
use crate::{
    BlockSource, Columns, DecodeResult, Decoder, EventSource, Header, Input, IoError, OpenOptions,
};

/// The registry's entry.
pub(crate) const FORMAT: Format = Format {
    name: "es",
    summary: "Event Stream of loris and faery: DVS and ATIS",
    endings: &[".es"],
    probe: |head| head.starts_with(MAGIC),
    open,
    create: None,
    labels: no_labels,
};

const MAGIC: &[u8] = b"Event Stream";
/// Major version.
const VERSION: u8 = 2;
/// Types that have events of contrast.
const DVS: u8 = 1;
const ATIS: u8 = 2;
/// Bytes of the header, and of an event.
const HEADER: usize = 20;
const EVENT: usize = 5;

fn open(mut input: Input, _: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let head = input.head(HEADER)?;
    let fault = |byte, reason: String| IoError::damaged(&input.path, byte, reason);
    let (version, kind) = (head.get(MAGIC.len()).copied(), head.get(MAGIC.len() + 3).copied());
    if let Some(version) = version.filter(|version| *version != VERSION) {
        return Err(fault(12, format!("Event Stream of version {version}, and 2 is read")));
    }
    let is_atis = match kind {
        Some(DVS) => false,
        Some(ATIS) => true,
        Some(0) => return Err(fault(15, "generic bytes with a time, no events of pixels".into())),
        Some(kind) => {
            return Err(fault(
                15,
                format!("events of type {kind} (4: colours) are none of contrast"),
            ));
        }
        None => return Err(fault(0, "the file ends within its header".into())),
    };
    let Some([width, height]) = head
        .get(16..HEADER)
        .map(|sizes| sizes.as_chunks::<2>().0)
        .and_then(|sizes| sizes.as_array())
    else {
        return Err(fault(16, "the file ends within its header".into()));
    };
    let [width, height] = [width, height].map(|side| u16::from_le_bytes(*side));
    if width == 0 || height == 0 {
        return Err(fault(16, format!("a sensor of {width}x{height}")));
    }
    let sensor = Some(SensorSize { width, height });
    let camera = if is_atis { "ATIS" } else { "DVS" };
    let facts = vec![("camera", camera.to_owned()), ("rows", "counted from below".to_owned())];
    let header = Header { sensor, facts, ..Header::default() };
    let decoder = Events { is_atis, height, t: 0, exposures: 0 };
    Ok(Box::new(BlockSource::new(input, HEADER as u64, header, decoder)))
}

/// Events as they follow each other.
#[derive(Debug, Clone)]
struct Events {
    is_atis: bool,
    height: u16,
    /// Time of the last event.
    t: i64,
    /// Edges of exposures.
    exposures: u64,
}

impl Events {
    /// Microseconds of the first byte of an event, and whether there is an event.
    fn advance(&mut self, byte: u8) -> bool {
        let (us, is_event) = match (self.is_atis, byte) {
            (true, 252..) => (63 * i64::from(byte & 3), false),
            (true, _) => (i64::from(byte >> 2), true),
            (false, 255) => (127, false),
            (false, 254) => (0, false),
            (false, _) => (i64::from(byte >> 1), true),
        };
        self.t += us;
        is_event
    }
}

impl Decoder for Events {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        let mut at = 0;
        while let Some(&first) = bytes.get(at) {
            // A cut event must not advance the time: it comes again, with more behind it.
            let is_event = first < if self.is_atis { 252 } else { 254 };
            let event = bytes[at..].first_chunk::<EVENT>();
            if is_event && event.is_none() {
                break;
            }
            self.advance(first);
            let Some([_, x0, x1, y0, y1]) = event.filter(|_| is_event) else {
                at += 1;
                continue;
            };
            at += EVENT;
            if self.is_atis && first & 1 == 1 {
                self.exposures += 1;
                continue;
            }
            let (x, y) = (u16::from_le_bytes([*x0, *x1]), u16::from_le_bytes([*y0, *y1]));
            let is_on = first & if self.is_atis { 2 } else { 1 } != 0;
            // A row beyond the sensor stays beyond it.
            let y = (self.height - 1).checked_sub(y).unwrap_or(u16::MAX);
            columns.push(Event { t: Micros(self.t), x, y, polarity: Polarity::from_on(is_on) });
        }
        Ok(at)
    }

    fn remarks(&self) -> Vec<String> {
        let exposures = self.exposures;
        let remark = format!("{exposures} edges of exposures are no events: they are left out");
        (exposures > 0).then_some(remark).into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_as;
    use crate::sample::event;

    fn open(kind: u8, events: &[u8]) -> Result<crate::Recording, IoError> {
        let head = [MAGIC, &[2, 0, 0, kind, 0x40, 1, 240, 0]].concat();
        let input = Input::memory("x.es", [&head, events].concat());
        read_as(input, &OpenOptions::default())
    }

    #[test]
    fn events_of_a_dvs_are_read_from_the_lowest_row_up() {
        let bytes = [5 << 1 | 1, 7, 1, 0, 0, 255, 254, 3 << 1, 2, 0, 239, 0];
        let read = open(1, &bytes).unwrap();
        let want = [event(5, 263, 239, true), event(135, 2, 0, false)];
        assert_eq!(read.stream.iter().collect::<Vec<_>>(), want);
        assert_eq!(read.stream.sensor(), SensorSize { width: 320, height: 240 });
        for cut in 1..bytes.len() {
            match open(1, &bytes[..cut]) {
                Ok(read) => assert!((5..=7).contains(&cut) && read.stream.len() == 1, "{cut}"),
                Err(error) => assert!(error.is_damage(), "{cut}"),
            }
        }
    }

    #[test]
    fn exposures_of_an_atis_are_counted_and_other_types_named() {
        let bytes = [5 << 2 | 2, 7, 0, 0, 0, 0xfe, 1 << 2 | 1, 1, 0, 1, 0, 2 << 2, 2, 0, 3, 0];
        let read = open(2, &bytes).unwrap();
        let want = [event(5, 7, 239, true), event(5 + 126 + 1 + 2, 2, 236, false)];
        assert_eq!(read.stream.iter().collect::<Vec<_>>(), want);
        assert!(read.remarks[0].starts_with("1 edges of exposures"), "{:?}", read.remarks);
        assert!(open(0, &[]).unwrap_err().to_string().contains("generic"));
        assert!(open(4, &[]).unwrap_err().to_string().contains("colours"));
    }
}
