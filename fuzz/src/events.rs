//! Recordings: every entry of the registry, the registry itself, and all that AEDAT 4.0 holds.

use std::io::{Cursor, Write};

use evpose_core::{EventStream, Micros, TimeWindow};
use evpose_io::aedat4::{Content, Packets};
use evpose_io::{
    Columns, EventSource, FORMATS, Input, IoError, OpenOptions, Windows, read_as, source,
};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::check;

/// More events than this are not gathered: a file may list a compressed chunk many times over, and is
/// then read batch by batch.
const MAX_EVENTS: usize = 1 << 21;
/// No batch is longer, whatever is in a file: 256 MiB of 16 bytes each, which a packet may hold.
const LONGEST_BATCH: usize = 1 << 24;

/// Reads `bytes` as a file of a format, to its end, and from the middle of its time once more.
///
/// # Panics
/// If a format misbehaves: it has no end, events before a fault are miscounted, a fault has no place,
/// or reading again gives something else.
pub fn read(format: &str, bytes: &[u8]) {
    let Some(format) = FORMATS.find(format) else { panic!("no format is called {format}") };
    let input = Input::memory("fuzz", bytes.to_vec());
    let mut source = match (format.open)(input, &OpenOptions::default()) {
        Ok(source) => source,
        Err(error) => return check(&error, bytes.len()),
    };
    let (columns, end) = gather(source.as_mut(), bytes.len());
    let _ = source.remarks();
    let Some(&t) = columns.t.get(columns.len() / 2) else { return };
    let mut again = Columns::new();
    let went = source.seek(t).and_then(|()| source.next(&mut again));
    // Behind a fault there may be more, to which an index leads.
    if end == ReadEnd::OfFile && went.is_ok() && !again.is_empty() {
        let first = again.event(0);
        assert!(columns.iter().any(|event| event == first), "an event that was not there");
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ReadEnd {
    OfFile,
    Fault,
    Limit,
}

/// Everything up to the end, the first fault, or as much as is gathered.
fn gather(source: &mut dyn EventSource, length: usize) -> (Columns, ReadEnd) {
    let mut columns = Columns::new();
    loop {
        let before = columns.len();
        let read = source.next(&mut columns);
        let lengths = [columns.x.len(), columns.y.len(), columns.polarity.len()];
        assert_eq!(lengths, [columns.len(); 3], "columns of different lengths");
        assert!(columns.len() - before <= LONGEST_BATCH, "a batch of {}", columns.len() - before);
        match read {
            Ok(()) if columns.len() == before => return (columns, ReadEnd::OfFile),
            Ok(()) if columns.len() > MAX_EVENTS => return (columns, ReadEnd::Limit),
            Ok(()) => {}
            Err(error) => {
                check(&error, length);
                if let IoError::Damaged { events, .. } = error {
                    assert_eq!(events, columns.len() as u64, "events before the fault: {error}");
                }
                return (columns, ReadEnd::Fault);
            }
        }
    }
}

/// Reads `bytes` as a user would: recognised by content, whole, then window by window.
///
/// # Panics
/// If what is salvaged of a file that is whole is something else.
pub fn any(bytes: &[u8]) {
    let input = || Input::memory("fuzz", bytes.to_vec());
    let salvaging = OpenOptions { salvage: true, ..OpenOptions::default() };
    let mut whole_source = match source(input(), &salvaging) {
        Ok((_, source)) => source,
        Err(error) => return check(&error, bytes.len()),
    };
    if gather(whole_source.as_mut(), bytes.len()).1 == ReadEnd::Limit {
        return;
    }
    let salvaged = read_as(input(), &salvaging);
    match (read_as(input(), &OpenOptions::default()), &salvaged) {
        (Ok(whole), Ok(salvaged)) => assert_eq!(whole, *salvaged, "nothing was to be salvaged"),
        (Ok(_), Err(error)) => panic!("salvaging lost a whole file: {error}"),
        (Err(error), _) => check(&error, bytes.len()),
    }
    let Ok((_, source)) = source(input(), &salvaging) else { return };
    let Ok(mut windows) = Windows::from_source(source, &salvaging) else { return };
    let Some(mut start) = windows.start() else { return };
    let mut events = EventStream::empty(windows.sensor());
    // Times may span all of 64 bits: no more than a few windows, each where there is something.
    for _ in 0..16 {
        let end = Micros(start.0.saturating_add(10_000));
        if windows.read(TimeWindow { start, end }, &mut events).is_err() {
            return;
        }
        assert!(events.iter().all(|e| start <= e.t && e.t < end), "an event outside its window");
        if !matches!(windows.is_over_at(end), Ok(false)) {
            break;
        }
        start = windows.next_after(end);
    }
    let _ = (windows.end(), windows.remarks());
}

/// Reads everything that an AEDAT 4.0 file holds: events, frames, inertial samples, triggers.
///
/// # Panics
/// If a frame is of another size than it says.
pub fn packets(bytes: &[u8]) {
    let mut packets = match Packets::from_input(Input::memory("fuzz", bytes.to_vec())) {
        Ok(packets) => packets,
        Err(error) => return check(&error, bytes.len()),
    };
    let _ = (packets.streams().len(), packets.compression());
    let mut events = 0;
    for packet in &mut packets {
        match packet {
            Ok(packet) => {
                if let Content::Events(columns) = &packet.content {
                    events += columns.len() as u64;
                }
            }
            Err(error) => {
                check(&error, bytes.len());
                if let IoError::Damaged { events: reported, .. } = error {
                    assert_eq!(reported, events, "events before the fault: {error}");
                }
            }
        }
    }
    assert!(packets.next().is_none(), "a packet behind the end");
}

/// Reads `bytes`, cut before every magic of NumPy's, as arrays of an archive whose checksums are right:
/// of the changes that a fuzzer makes to an archive itself, those refuse almost all.
///
/// # Panics
/// As [`read`].
pub fn arrays(bytes: &[u8]) {
    const NAMES: [&str; 6] = ["t", "x", "y", "p", "width", "height"];
    let places = bytes.windows(6).enumerate().filter(|(_, six)| six == b"\x93NUMPY");
    let starts: Vec<usize> = places.map(|(at, _)| at).take(NAMES.len()).collect();
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (k, &start) in starts.iter().enumerate() {
        let end = starts.get(k + 1).copied().unwrap_or(bytes.len());
        let name = if starts.len() == 1 { "events" } else { NAMES[k] };
        zip.start_file(format!("{name}.npy"), stored).expect("room in memory");
        zip.write_all(&bytes[start..end]).expect("room in memory");
    }
    read("npz", &zip.finish().expect("room in memory").into_inner());
}
