//! Recordings made here: faults, and what no file of other programs has.

use std::fs;
use std::path::{Path, PathBuf};

use evpose_core::{Event, Micros, Polarity, SensorSize};

use super::fields::Serialisation;
use super::mcap::{CHANNEL, CHUNK, DATA_END, FOOTER, MAGIC, MESSAGE, SCHEMA, STATISTICS};
use super::message::{EventType, MessageDecoder};
use super::writer::Bytes;
use crate::{Columns, EventStream, Input, IoError, OpenOptions, Recording, open_as, read_as};

/// The time of ROS of events in nanoseconds, and in seconds.
const BASE_NS: u64 = BASE_S as u64 * 1_000_000_000;
const BASE_S: u32 = 1_700_000_000;
const PACKET: &str = "event_camera_msgs/msg/EventPacket";
const IMAGE: &str = "sensor_msgs/msg/Image";

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/ros").join(name)
}

fn salvaged(path: &Path) -> Result<Recording, IoError> {
    open_as(path, &OpenOptions { salvage: true, ..OpenOptions::default() })
}

/// Messages are of ROS 1: fields without gaps.
fn packet(stamp_s: u32, number: u64, encoding: &str, events: &[u8]) -> Vec<u8> {
    let header = Bytes::default().u32(0).u32(stamp_s).u32(0).text("camera").u32(48).u32(64);
    header.u64(number).u64(BASE_NS).text(encoding).bytes(&[0]).sized(events).0
}

/// An image of four grey pixels.
fn image(stamp_s: u32) -> Vec<u8> {
    let header = Bytes::default().u32(0).u32(stamp_s).u32(0).text("camera").u32(2).u32(2);
    header.text("mono8").bytes(&[0]).u32(2).sized(&[1, 2, 3, 4]).0
}

fn bytes_of(words: &[u16]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn message(file: &mut Bytes, channel: u16, message: &[u8]) {
    file.record(MESSAGE, Bytes::default().u16(channel).u32(0).u64(0).u64(0).bytes(message));
}

/// The begin of an MCAP file of topics and their types, numbered from 1.
fn mcap(topics: &[(&str, &str)]) -> Bytes {
    let mut file = Bytes(MAGIC.to_vec());
    for (id, (name, kind)) in (1..).zip(topics) {
        file.record(SCHEMA, Bytes::default().u16(id).text(kind).text("ros1msg").sized(&[]));
        file.record(CHANNEL, Bytes::default().u16(id).u16(id).text(name).text("ros1").u32(0));
    }
    file
}

fn end(file: &mut Bytes) {
    file.record(DATA_END, Bytes::default().u32(0));
}

#[test]
fn images_of_libcaer_are_on_the_clock_of_its_events_whenever_its_packets_arrived() {
    let word = [(5_u32 << 17 | 7 << 2 | 1).to_le_bytes(), [0; 4]].concat();
    let words = bytes_of(&[0x2005, 0x1000, 0x3807]);
    let evt3 = bytes_of(&[0x8001, 0x0007, 0x6000, 0x2805]);
    // The header is three seconds late: that counts where packets have another clock than images.
    for (encoding, events, expected_us) in [
        ("libcaer", word, 1_000_000),
        ("libcaer_cmp", words, 1_000_000),
        ("evt3", evt3, -1_995_904),
    ] {
        let mut file = mcap(&[("/camera/events", PACKET), ("/camera/image", IMAGE)]);
        message(&mut file, 1, &packet(BASE_S + 3, 0, encoding, &events));
        message(&mut file, 2, &image(BASE_S + 1));
        // As the recorder of ROS 2 packs messages one by one.
        message(&mut file, 2, &zrip::compress(&image(BASE_S + 1), 3).unwrap());
        end(&mut file);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera.mcap");
        fs::write(&path, file.0).unwrap();
        let images = super::images(&path, &OpenOptions::default()).unwrap();
        let read: Vec<_> = images.map(|frame| frame.map(|frame| frame.t.0).unwrap()).collect();
        assert_eq!(read, [expected_us; 2], "{encoding}");
    }
}

#[test]
fn images_before_a_fault_of_their_chunk_come_first() {
    let mut records = Bytes::default();
    message(&mut records, 2, &image(BASE_S));
    message(&mut records, 2, &image(BASE_S)[..40]);
    let mut file = mcap(&[("/camera/events", PACKET), ("/camera/image", IMAGE)]);
    message(&mut file, 1, &packet(BASE_S, 0, "libcaer", &[0; 8]));
    let chunk = Bytes::default().u64(0).u64(0).u64(records.0.len() as u64).u32(0).text("");
    let length = records.0.len() as u64;
    file.record(CHUNK, chunk.u64(length).bytes(&records.0));
    end(&mut file);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("camera.mcap");
    fs::write(&path, file.0).unwrap();
    let images = super::images(&path, &OpenOptions::default()).unwrap();
    assert_eq!(images.map(|frame| frame.is_ok()).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn a_driver_that_was_started_again_begins_a_new_clock() {
    let mut decoder = MessageDecoder::new(EventType::Packet, Serialisation::Ros1);
    let mut columns = Columns::new();
    let first = bytes_of(&[0x800A, 0x0007, 0x6003, 0x2805]);
    // An event before any time of the new driver, which the old one's is not.
    let second = bytes_of(&[0x2001, 0x8002, 0x0003, 0x6000, 0x2001]);
    decoder.decode(&packet(0, 5, "evt3", &first), &mut columns).unwrap();
    decoder.decode(&packet(0, 0, "evt3", &second), &mut columns).unwrap();
    let read: Vec<_> = columns.iter().map(|e| (e.t.0, e.x, e.y)).collect();
    assert_eq!(read, [(10 << 12 | 3, 5, 7), (2 << 12, 1, 3)]);
    let remarks: Vec<_> = decoder.remarks().collect();
    assert_eq!(remarks, ["1 events stand before the first time stamp: they are left out"]);
}

#[test]
fn a_summary_without_schemas_and_channels_does_not_hide_them() {
    let mut file = mcap(&[("/camera/events", PACKET)]);
    message(&mut file, 1, &packet(BASE_S, 0, "libcaer", &[0; 8]));
    end(&mut file);
    let summary = file.0.len() as u64;
    // One message, of channel 1.
    let counts = Bytes::default().u64(1).u16(1).u32(1).u32(0).u32(0).u32(0).u64(0).u64(0);
    file.record(STATISTICS, counts.sized(&Bytes::default().u16(1).u64(1).0));
    file.record(FOOTER, Bytes::default().u64(summary).u64(0).u32(0));
    let bytes = file.bytes(MAGIC).0;
    let read = read_as(Input::memory("a.mcap", bytes), &OpenOptions::default()).unwrap();
    assert_eq!(read.stream.len(), 1);
}

#[test]
fn damage_of_the_tables_of_a_later_file_is_that_of_this_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = fs::read(golden("evt3-sqlite/evt3-sqlite.db3")).unwrap();
    fs::write(folder.path().join("my bag_0.db3"), &bytes).unwrap();
    let metadata = |names: &[&str]| {
        let list: String = names.iter().map(|name| format!("    - {name}\n")).collect();
        let text = format!("information:\n  relative_file_paths:\n{list}  duration: 1\n");
        fs::write(folder.path().join("metadata.yaml"), text).unwrap();
    };
    metadata(&["my bag_0.db3", "'my bag_1.db3'"]);
    let error = salvaged(folder.path()).unwrap_err().to_string();
    assert!(error.contains("'my bag_1.db3'") && error.contains("not in the folder"), "{error}");
    // The type of the first page, behind the head of the file.
    bytes[100] = 0;
    fs::write(folder.path().join("my bag_1.db3"), &bytes).unwrap();
    let error = open_as(folder.path(), &OpenOptions::default()).unwrap_err().to_string();
    assert!(error.contains("my bag_1.db3: byte 0") && error.contains("600 events"), "{error}");
    assert_eq!(salvaged(folder.path()).unwrap().stream.len(), 600);
}

#[test]
fn a_database_that_is_no_bag_is_none_of_ros_rather_than_damaged() {
    let mut bytes = fs::read(golden("evt3-sqlite/evt3-sqlite.db3")).unwrap();
    let places: Vec<usize> = bytes[..4096]
        .windows(8)
        .enumerate()
        .filter(|(_, w)| w == b"messages")
        .map(|(k, _)| k)
        .collect();
    places.iter().for_each(|at| bytes[*at] = b'M');
    let error = read_as(Input::memory("a.db3", bytes), &OpenOptions::default()).unwrap_err();
    assert!(
        matches!(&error, IoError::Stream { reason, .. } if reason.contains("without the tables")),
        "{error}"
    );
}

#[test]
fn the_chunk_that_a_recorder_of_ros_1_was_at_when_it_was_killed_is_read() {
    let mut bytes = fs::read(golden("dvs-plain.bag")).unwrap();
    let index = bytes.windows(10).position(|word| word == b"index_pos=").unwrap() + 10;
    let data_end = u64::from_le_bytes(*bytes[index..].first_chunk().unwrap()) as usize;
    bytes[index..index + 8].fill(0);
    let length = |at: usize| u32::from_le_bytes(*bytes[at..].first_chunk().unwrap()) as usize;
    // The places of the last chunk: its head, its data and what is behind them.
    let (mut at, mut chunk) = (13, None);
    while at < data_end {
        let data = at + 4 + length(at);
        let next = data + 4 + length(data);
        let is_chunk = bytes[at..data].windows(4).any(|field| field == b"op=\x05");
        chunk = if is_chunk { Some((at, data, next)) } else { chunk };
        at = next;
    }
    let (at, data, next) = chunk.unwrap();
    let size = at + bytes[at..data].windows(5).position(|field| field == b"size=").unwrap() + 5;
    let records = bytes[data + 4..next].to_vec();
    bytes[size..size + 4].fill(0);
    bytes.truncate(data);
    bytes.extend([0; 4]);
    bytes.extend(records);
    let read = |bytes: &[u8], salvage| {
        let options = OpenOptions { salvage, ..OpenOptions::default() };
        read_as(Input::memory("killed.bag", bytes.to_vec()), &options)
    };
    assert_eq!(read(&bytes, false).unwrap().stream.len(), 600);
    let cut = &bytes[..bytes.len() - 9];
    assert!(read(cut, false).unwrap_err().to_string().contains("ends within a record"));
    assert_eq!(read(cut, true).unwrap().stream.len(), 480);
}

#[test]
fn times_that_messages_have_no_seconds_for_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let sensor = SensorSize { width: 64, height: 48 };
    for (t_s, is_written) in [(i32::MAX.into(), true), (i64::from(i32::MAX) + 1, false)] {
        let event = Event { t: Micros(t_s * 1_000_000), x: 1, y: 2, polarity: Polarity::On };
        let events = EventStream::from_events(sensor, [event]).unwrap();
        let mut sink = crate::create(folder.path().join("out.mcap"), sensor).unwrap();
        assert_eq!(sink.write(&events).is_ok(), is_written, "{t_s}");
    }
}
