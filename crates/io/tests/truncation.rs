//! Every format, cut at every byte: what is read of the rest is the beginning of what was there, and
//! where something is missing, a typed error says from which byte on. And with other bytes: nothing
//! panics, and reading ends.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::aedat4::{Aedat4Packet, Packets};
use evpose_io::yarp::read_skeletons_from;
use evpose_io::{Columns, EventSource, FORMATS, Format, Input, IoError, OpenOptions, read_as};
use proptest::prelude::*;
use proptest::sample::Index;

/// Places at which a sample is cut: all, or so many that lie evenly.
const CUTS: usize = 4096;

/// Formats by folder of `tests/golden`; those of `expelliarmus` are of two.
const GOLDEN: &[(&str, &str)] = &[
    ("aedat2", "aedat2"),
    ("aedat4", "aedat4"),
    ("expelliarmus/events.dat", "dat"),
    ("expelliarmus/evt2.raw", "evt2"),
    ("hdf5", "hdf5"),
    ("nmnist", "nmnist"),
    ("numpy/records.npy", "npy"),
    ("numpy/records.npz", "npz"),
    ("numpy/records-compressed.npz", "npz"),
    ("ros/evt3-zstd.mcap", "mcap"),
    ("ros/mono-plain.mcap", "mcap"),
    ("ros/dvs-ros1-lz4.mcap", "mcap"),
    ("ros/dvs-plain.bag", "rosbag"),
    ("ros/libcaer-bz2.bag", "rosbag"),
    ("ros/prophesee-lz4.bag", "rosbag"),
    ("ros/evt3-sqlite/evt3-sqlite.db3", "rosbag2"),
    ("text/seconds.txt", "text"),
    ("text/nanoseconds.txt", "text"),
    ("text/named.csv", "csv"),
    ("text/pandas.csv", "csv"),
    ("yarp", "yarp"),
];

/// Ends of names of files there that are no sample: descriptions, and codecs that are refused.
const UNREAD: &[&str] = &[".md", "snappy.h5"];

/// Sizes of records in bytes, of formats that write one for each event.
const RECORDS: &[(&str, usize)] = &[("dat", 8), ("nmnist", 5)];

fn is_read(format: &Format) -> bool {
    format.name != "hdf5" || cfg!(feature = "hdf5")
}

/// A tick that a file does not state is measured by its content; here, it is given.
fn options() -> OpenOptions {
    OpenOptions { tick_us: Some(0.08), ..OpenOptions::default() }
}

/// Samples of every format: what other programs wrote, and what is written here.
fn samples() -> BTreeMap<&'static str, Vec<(String, Vec<u8>)>> {
    let mut samples: BTreeMap<_, Vec<_>> = FORMATS.iter().map(|f| (f.name, Vec::new())).collect();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    for (place, format) in GOLDEN {
        let place = golden.join(place);
        let paths = if place.is_dir() {
            fs::read_dir(&place).unwrap().map(|entry| entry.unwrap().path()).collect()
        } else {
            vec![place]
        };
        for path in paths {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if UNREAD.iter().any(|unread| name.ends_with(unread)) {
                continue;
            }
            let sample = (name, fs::read(path).unwrap());
            samples.get_mut(format).unwrap().push(sample);
        }
    }
    // No format needs more time than 1 ms or another order than that of rows.
    let sensor = SensorSize { width: 34, height: 34 };
    let event = |k: i64| Event {
        t: Micros(1000 * (k / 4)),
        x: (k % 4) as u16,
        y: 5,
        polarity: Polarity::from_on(k % 3 == 0),
    };
    let stream = EventStream::from_events(sensor, (0..120).map(event)).unwrap();
    let directory = tempfile::tempdir().unwrap();
    for format in FORMATS.iter().filter(|format| format.create.is_some()) {
        let path = directory.path().join("written");
        format.write(&path, &stream).unwrap();
        let sample = ("written".to_owned(), fs::read(path).unwrap());
        samples.get_mut(format.name).unwrap().push(sample);
    }
    let word = |k: u32| ((k % 34) << 12) | ((k % 17) << 1) | (k % 2);
    let record = |k: u32| [(100 * k).to_le_bytes(), word(k).to_le_bytes()].concat();
    let binary = ("made".to_owned(), (0..60).flat_map(record).collect());
    samples.get_mut("yarp-binary").unwrap().push(binary);
    // A packet of 60 events of eight bytes, of type 1.
    let head = b"#!AER-DAT3.1\r\n#Format: RAW\r\n#Source 1: DVS128\r\n#!END-HEADER\r\n".to_vec();
    let packet = [0x0001_0001_u32, 8, 4, 0, 60, 60, 60].map(u32::to_le_bytes).concat();
    let event =
        |k: u32| [(k % 34) << 17 | (k % 17) << 2 | 1, 100 * k].map(u32::to_le_bytes).concat();
    let made = [head, packet, (0..60).flat_map(event).collect()].concat();
    samples.get_mut("aedat3").unwrap().push(("made".to_owned(), made));
    let head = [b"Event Stream", &[2, 0, 0, 1, 34, 0, 34, 0][..]].concat();
    let event = |k: u8| [80 | (k % 2), k % 34, 0, k % 17, 0];
    let made = [head, (0..60).flat_map(event).collect()].concat();
    samples.get_mut("es").unwrap().push(("made".to_owned(), made));
    let head = b"% evt 4.0\n% format EVT4;height=34;width=34\n% end\n".to_vec();
    let word = |k: u32| match k % 4 {
        0 => 0xE << 28 | k,
        1 => 0xD << 28 | 5 << 22 | 2 << 11 | 7,
        // The mask of the vector before.
        2 => 0b1001,
        _ => 0xA << 28 | 9 << 22 | (k % 34) << 11 | 8,
    };
    let made = [head, (0..60).flat_map(|k| word(k).to_le_bytes()).collect()].concat();
    samples.get_mut("evt4").unwrap().push(("made".to_owned(), made));
    samples
}

/// Everything up to the end or the first fault.
fn events_of(format: &Format, bytes: &[u8]) -> (Columns, Option<SensorSize>, Option<IoError>) {
    let input = Input::memory("cut", bytes.to_vec());
    let mut columns = Columns::new();
    let mut source = match (format.open)(input, &options()) {
        Ok(source) => source,
        Err(error) => return (columns, None, Some(error)),
    };
    let error = read_on(source.as_mut(), &mut columns);
    (columns, source.header().sensor, error)
}

fn read_on(source: &mut dyn EventSource, columns: &mut Columns) -> Option<IoError> {
    loop {
        let before = columns.len();
        match source.next(columns) {
            Ok(()) if columns.len() == before => return None,
            Ok(()) => {}
            Err(error) => return Some(error),
        }
    }
}

/// Cuts from the longest to the shortest.
fn cuts(length: usize) -> impl Iterator<Item = usize> {
    let count = length.min(CUTS);
    (0..count).rev().map(move |k| k * length / count)
}

fn check_fault(error: &IoError, cut: usize, events: usize, what: &str) {
    let byte = error.byte().unwrap_or_else(|| panic!("{what}: no place: {error}"));
    assert!(byte <= cut as u64, "{what}: {error}");
    if let IoError::Damaged { events: reported, .. } = error {
        assert_eq!(*reported, events as u64, "{what}: {error}");
    }
}

#[test]
fn what_is_read_of_a_cut_recording_is_how_it_begins() {
    for (name, samples) in samples() {
        let format = FORMATS.find(name).unwrap();
        if !is_read(format) {
            continue;
        }
        assert!(!samples.is_empty(), "{name} has no sample");
        for (sample, bytes) in samples {
            let (whole, sensor, error) = events_of(format, &bytes);
            assert!(error.is_none() && !whole.is_empty(), "{sample}: {error:?}");
            let mut most = whole.len();
            let record = RECORDS.iter().find(|(of, _)| *of == name && sample == "written");
            for cut in cuts(bytes.len()) {
                let what = format!("{name} {sample} cut at {cut} of {}", bytes.len());
                let (columns, stated, error) = events_of(format, &bytes[..cut]);
                assert!(columns.iter().eq(whole.iter().take(columns.len())), "{what}");
                assert!(columns.len() <= most, "{what}: more events of less of it");
                assert!(columns.is_empty() || stated == sensor, "{what}: {stated:?}");
                error.iter().for_each(|error| check_fault(error, cut, columns.len(), &what));
                if let Some((_, size)) = record
                    && let Some(behind) = cut.checked_sub(bytes.len() - whole.len() * size)
                {
                    let place = (behind % size > 0).then_some((cut - behind % size) as u64);
                    let found = (columns.len(), error.and_then(|error| error.byte()));
                    assert_eq!(found, (behind / size, place), "{what}");
                }
                most = columns.len();
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn changed_bytes_never_panic_and_reading_ends(
        sample in any::<Index>(),
        changes in prop::collection::vec((any::<Index>(), any::<u8>()), 1..20),
        cut in prop::option::of(any::<Index>()),
    ) {
        static SAMPLES: OnceLock<Vec<(&str, Vec<u8>)>> = OnceLock::new();
        let all = SAMPLES.get_or_init(|| {
            let of = |(name, samples): (&'static str, Vec<(String, Vec<u8>)>)| {
                samples.into_iter().map(move |(_, bytes)| (name, bytes))
            };
            samples().into_iter().flat_map(of).collect()
        });
        let (name, mut bytes) = all[sample.index(all.len())].clone();
        for (at, byte) in changes {
            let length = bytes.len();
            bytes[at.index(length)] = byte;
        }
        bytes.truncate(cut.map_or(bytes.len(), |cut| cut.index(bytes.len())));
        for options in [options(), OpenOptions::default()] {
            let input = Input::memory("changed", bytes.clone());
            if let Ok(mut source) = (FORMATS.find(name).unwrap().open)(input, &options) {
                let mut columns = Columns::new();
                let fault = read_on(source.as_mut(), &mut columns);
                if let Some(IoError::Damaged { events, .. }) = fault {
                    prop_assert_eq!(events, columns.len() as u64);
                }
                let _ = source.seek(Micros(2_000));
            }
        }
        let _ = read_as(Input::memory("changed", bytes), &OpenOptions::default());
    }
}

/// As a user meets them: by content, and read whole or not at all.
#[test]
fn a_cut_recording_of_any_name_is_an_error_with_a_place_or_begins_like_the_whole() {
    for (name, samples) in samples() {
        if !is_read(FORMATS.find(name).unwrap()) {
            continue;
        }
        let (sample, bytes) = &samples[0];
        let read = |bytes: &[u8]| read_as(Input::memory("cut", bytes.to_vec()), &options());
        let whole = read(bytes).unwrap();
        for cut in cuts(bytes.len()).step_by(3) {
            let what = format!("{name} {sample} cut at {cut}");
            match read(&bytes[..cut]) {
                // Of the few bytes that are left of one, another format may be recognised.
                Ok(part) if part.format != whole.format => assert!(cut < 64, "{what}"),
                Ok(part) => {
                    let begins = part.stream.iter().eq(whole.stream.iter().take(part.stream.len()));
                    assert!(begins, "{what}");
                }
                Err(error) => {
                    assert!(error.byte().is_some_and(|b| b <= cut as u64), "{what}: {error}");
                }
            }
        }
    }
}

#[test]
fn packets_of_a_cut_file_are_those_that_are_whole() {
    for (sample, bytes) in &samples()["aedat4"] {
        let packets = |bytes: &[u8]| Packets::from_input(Input::memory("cut", bytes.to_vec()));
        let whole: Vec<Aedat4Packet> = packets(bytes).unwrap().map(Result::unwrap).collect();
        for cut in cuts(bytes.len()) {
            let what = format!("{sample} cut at {cut}");
            let (mut read, mut fault) = (Vec::new(), None);
            match packets(&bytes[..cut]) {
                Err(error) => fault = Some(error),
                Ok(packets) => packets.for_each(|packet| match packet {
                    Ok(packet) => read.push(packet),
                    Err(error) => fault = Some(error),
                }),
            }
            assert!(read == whole[..read.len()], "{what}");
            assert!(read.len() == whole.len() || fault.is_some(), "{what}: lost in silence");
            fault.iter().for_each(|f| assert!(f.byte().is_some_and(|b| b <= cut as u64), "{what}"));
        }
    }
}

#[test]
fn skeletons_of_a_cut_log_are_those_that_are_whole() {
    let joints = "1.5 20.25 ".repeat(13);
    let log = format!("0 0.12 SKLT ({joints}) -1.0 104.3\n1 0.24 SKLT ({joints}) 35.5 40\n");
    let read =
        |cut: usize| read_skeletons_from(Input::memory("data.log", log.as_bytes()[..cut].to_vec()));
    let whole = read(log.len()).unwrap();
    for cut in 0..log.len() {
        match read(cut) {
            Ok(skeletons) => assert_eq!(skeletons, whole[..skeletons.len()], "{cut}"),
            Err(error) => check_fault(&error, cut, log[..cut].matches('\n').count(), "skeletons"),
        }
    }
}
