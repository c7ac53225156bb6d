//! Files as they are written here, with one bit changed: reading says so, or gives what was written.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::fs;
use std::path::Path;

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::aedat4::{Compression, Stream, StreamKind, Writer};
use evpose_io::{Input, OpenOptions, read_as};

const FLIPS: usize = 2_000;
const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

fn recording() -> EventStream {
    let event = |k: i64| Event {
        t: Micros(1_700_000_000_000_000 + 13 * k + k % 7),
        x: (37 * k % 346) as u16,
        y: (k * k % 260) as u16,
        polarity: Polarity::from_on(k % 3 == 0),
    };
    EventStream::from_events(SENSOR, (0..8_000).map(event)).unwrap()
}

fn write_zstandard(path: &Path, events: &EventStream) {
    let (name, source) = ("events".to_owned(), "camera".to_owned());
    let stream = Stream { id: 0, kind: StreamKind::Events, name, source, size: Some(SENSOR) };
    let mut writer = Writer::create(path, Compression::Zstd, &[stream]).unwrap();
    writer.events(0, events).unwrap();
    writer.finish().unwrap();
}

#[test]
fn no_changed_bit_changes_events_unseen() {
    let folder = tempfile::tempdir().unwrap();
    let events = recording();
    let mut files = vec!["lz4.aedat4", "events.npz", "zstd.aedat4"];
    if cfg!(feature = "hdf5") {
        files.push("events.h5");
    }
    for name in files {
        let path = folder.path().join(name);
        match name {
            "zstd.aedat4" => write_zstandard(&path, &events),
            _ => evpose_io::format_for(&path).unwrap().write(&path, &events).unwrap(),
        }
        let file = fs::read(&path).unwrap();
        // xorshift64: the same flips every time.
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut unseen = Vec::new();
        for k in 0..FLIPS {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            // Half of them where structure stands: the first and the last kilobyte.
            let edge = state as usize % 2_048;
            let edge = if edge < 1_024 { edge } else { file.len() - edge + 1_023 };
            let byte = if k % 2 == 0 { edge } else { (state >> 12) as usize % file.len() };
            let bit = (state >> 40) % 8;
            let mut flipped = file.clone();
            flipped[byte] ^= 1 << bit;
            let read = read_as(Input::memory(name, flipped), &OpenOptions::default());
            if let Ok(read) = read
                && read.remarks.is_empty()
                && read.stream != events
            {
                unseen.push((byte, bit));
            }
        }
        assert!(unseen.is_empty(), "{name}: {} of {FLIPS} unseen: {unseen:?}", unseen.len());
    }
}
