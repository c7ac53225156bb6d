//! Records of an address and a time.

use evpose_core::{Micros, Polarity};

use super::header::{Layout, Recorder};
use super::special::SpecialEvent;
use crate::time_stamp::{HalfPeriodFall, WraparoundCounter};
use crate::{Columns, DecodeResult, Decoder};

/// Cameras that an address of 4 bits distinguishes.
const CAMERAS: usize = 16;
/// Bits of a time stamp.
const TIME_BITS: u32 = 32;

/// Decoder of consecutive records.
#[derive(Debug, Clone)]
pub(super) struct Records {
    layout: Layout,
    /// Bytes of an address.
    address: usize,
    /// The last column and the last row.
    last: [u16; 2],
    /// The camera that is read, where addresses hold one.
    pub(super) camera: Option<u8>,
    /// Time stamps, in microseconds.
    counter: WraparoundCounter,
    /// Counts of skipped records: of other cameras, special events, frame and motion readings.
    others: [u64; CAMERAS],
    special: u64,
    frames: u64,
    motion: u64,
}

/// A decoded address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Word {
    Event {
        x: u16,
        y: u16,
        is_on: bool,
    },
    Special,
    /// A pixel of a frame.
    Frame,
    /// A value of a motion sample.
    Motion,
}

impl Records {
    pub(super) fn new(recorder: &Recorder) -> Self {
        let last = [recorder.sensor.width - 1, recorder.sensor.height - 1];
        Self {
            layout: recorder.layout,
            address: recorder.address,
            last,
            camera: None,
            counter: WraparoundCounter::new(TIME_BITS, HalfPeriodFall::StepBack),
            others: [0; CAMERAS],
            special: 0,
            frames: 0,
            motion: 0,
        }
    }

    /// Bytes of a record.
    fn length(&self) -> usize {
        self.address + 4
    }

    /// Calls `each` with the address and the time of every whole record; returns the bytes of these
    /// records.
    #[inline(always)]
    fn each(&mut self, bytes: &[u8], mut each: impl FnMut(&mut Self, u32, Micros)) -> usize {
        let long = bytes.as_chunks::<8>().0.iter().map(|record| {
            let [a, b, c, d, t @ ..] = *record;
            (u32::from_be_bytes([a, b, c, d]), u32::from_be_bytes(t))
        });
        let short = bytes.as_chunks::<6>().0.iter().map(|record| {
            let [a, b, t @ ..] = *record;
            (u16::from_be_bytes([a, b]).into(), u32::from_be_bytes(t))
        });
        // Decided once for all records: the size of an address is that of the file.
        if self.address == 4 {
            long.for_each(|(address, t)| {
                let t = self.unwrap(t);
                each(self, address, t);
            });
        } else {
            short.for_each(|(address, t)| {
                let t = self.unwrap(t);
                each(self, address, t);
            });
        }
        // Whole records only: the next block begins with the rest.
        bytes.len() / self.length() * self.length()
    }

    #[inline(always)]
    fn unwrap(&mut self, stamp: u32) -> Micros {
        Micros(self.counter.advance_to_nearest(stamp.into()))
    }

    #[inline(always)]
    fn word(&self, address: u32) -> Word {
        let [x, y, is_on] = match self.layout {
            Layout::Davis => {
                match (address >> 31 == 1, address >> 10 & 1 == 1, address >> 11 & 1 == 1) {
                    (false, false, _) => {}
                    (false, true, _) => return Word::Special,
                    (true, true, true) => return Word::Motion,
                    (true, ..) => return Word::Frame,
                }
                [address >> 12 & 0x3ff, address >> 22 & 0x1ff, address >> 11 & 1]
            }
            Layout::Dvs128 if address >> 15 & 1 == 1 => return Word::Special,
            Layout::Dvs128 => [address >> 1 & 0x7f, address >> 8 & 0x7f, !address & 1],
            Layout::Dvs640 => [address >> 1 & 0x3ff, address >> 11 & 0x3ff, address & 1],
        };
        // Counted from the other side; a coordinate outside the sensor becomes one that no sensor
        // has.
        let mirrored = |value: u32, last: u16| last.checked_sub(value as u16).unwrap_or(u16::MAX);
        Word::Event {
            x: mirrored(x, self.last[0]),
            y: mirrored(y, self.last[1]),
            is_on: is_on == 1,
        }
    }

    /// The lowest camera of the events of `bytes`.
    pub(super) fn first_camera(mut self, bytes: &[u8]) -> Option<u8> {
        let mut first = None;
        self.each(bytes, |records, address, _| {
            if let Word::Event { .. } = records.word(address) {
                let camera = camera(address);
                // The lowest number, not the first event: which camera fires first is chance.
                first = Some(first.map_or(camera, |other: u8| other.min(camera)));
            }
        });
        first
    }

    /// Appends the special events of whole records; returns the bytes of these records.
    pub(super) fn special_events(&mut self, bytes: &[u8], events: &mut Vec<SpecialEvent>) -> usize {
        self.each(bytes, |records, address, t| {
            if records.word(address) == Word::Special {
                events.push(SpecialEvent { t, address });
            }
        })
    }
}

/// The camera of an address, where it holds one.
fn camera(address: u32) -> u8 {
    (address & 0xf) as u8
}

impl Decoder for Records {
    fn decode(&mut self, bytes: &[u8], _: bool, columns: &mut Columns) -> DecodeResult {
        columns.reserve(bytes.len() / self.length());
        let length = self.each(bytes, |records, address, t| match records.word(address) {
            Word::Event { x, y, is_on } => {
                // Only files of stereo cameras have a camera in the address; in others these bits
                // are coordinates.
                if records.camera.is_some_and(|wanted| wanted != camera(address)) {
                    records.others[usize::from(camera(address))] += 1;
                    return;
                }
                columns.t.push(t);
                columns.x.push(x);
                columns.y.push(y);
                columns.polarity.push(Polarity::from_on(is_on));
            }
            Word::Special => records.special += 1,
            Word::Frame => records.frames += 1,
            Word::Motion => records.motion += 1,
        });
        Ok(length)
    }

    fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        let others = self.others.iter().enumerate().filter(|(_, count)| **count > 0);
        for (camera, count) in others {
            remarks.push(format!("{count} events of camera {camera} are passed over"));
        }
        for (count, what) in [
            (self.special, "special events (external pins)"),
            (self.frames, "readings of frames"),
            (self.motion, "readings of the motion sensor"),
        ] {
            if count > 0 {
                remarks.push(format!("{count} {what} are passed over"));
            }
        }
        remarks
    }
}
