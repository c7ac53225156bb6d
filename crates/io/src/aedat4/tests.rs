mod golden;
mod hostile;
mod round_trip;
mod seeking;
mod streaming;

use std::fs;

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};

use super::*;
use crate::{Columns, EventSource, Input, IoError, OpenOptions, Recording, detect_format, read_as};

const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

/// Unix time of the first event.
const START: i64 = 1_700_000_000_000_000;

fn stream(id: i32, kind: StreamKind) -> Stream {
    let (name, source) = (format!("the {kind} <{id}>"), format!("camera & {id}"));
    let size = matches!(kind, StreamKind::Events | StreamKind::Frames).then_some(SENSOR);
    Stream { id, kind, name, source, size }
}

fn streams() -> Vec<Stream> {
    [
        (0, StreamKind::Events),
        (1, StreamKind::Frames),
        (2, StreamKind::Imu),
        (3, StreamKind::Triggers),
        (7, StreamKind::Events),
    ]
    .map(|(id, kind)| stream(id, kind))
    .to_vec()
}

/// Event number `k` of a camera before which something moves.
fn event(k: i64) -> Event {
    let (x, y) = ((7 * k + k / 5) % 346, (11 * k) % 260);
    let polarity = Polarity::from_on(k % 3 > 0);
    Event { t: Micros(START + 10 * k), x: x as u16, y: y as u16, polarity }
}

fn events(range: std::ops::Range<i64>) -> Content {
    Content::Events(range.map(event).collect())
}

/// A file of `packets`.
fn file(compression: Compression, streams: &[Stream], packets: &[Aedat4Packet]) -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("recording.aedat4");
    let mut writer = Writer::create(&path, compression, streams).unwrap();
    packets.iter().for_each(|packet| writer.packet(packet).unwrap());
    writer.finish().unwrap();
    fs::read(path).unwrap()
}

/// A little of everything.
fn recording() -> Vec<Aedat4Packet> {
    let frame = Frame {
        t: Micros(START + 50),
        readout_start: Micros(0),
        readout_end: Micros(0),
        exposure_start: Micros(START),
        exposure_end: Micros(START + 100),
        format: PixelFormat::GREY,
        width: 4,
        height: 3,
        position: (1, -2),
        origin: 1,
        pixels: (0..12).collect(),
    };
    let imu = ImuSample {
        t: Micros(START + 60),
        temperature_c: 36.5,
        acceleration_g: [0.0, -1.0, 0.5],
        rotation_deg_per_s: [1.0, 2.0, 3.0],
        field_ut: [20.0, 30.0, -40.0],
    };
    let trigger = Trigger { t: Micros(START + 70), kind: TriggerKind::ExternalFalling };
    [
        (0, events(0..40)),
        (1, Content::Frame(frame)),
        (7, events(0..3)),
        (2, Content::Imu(vec![imu; 3])),
        (0, events(40..41)),
        (3, Content::Triggers(vec![trigger; 2])),
        (0, events(41..90)),
    ]
    .map(|(stream, content)| Aedat4Packet { stream, content })
    .to_vec()
}

fn open(bytes: &[u8], options: &OpenOptions) -> Result<Recording, IoError> {
    read_as(Input::memory("recording.aedat4", bytes.to_vec()), options)
}

fn source(bytes: &[u8]) -> Box<dyn EventSource> {
    let input = Input::memory("recording.aedat4", bytes.to_vec());
    crate::open::unordered(input, &OpenOptions::default()).unwrap().1
}

fn packets(bytes: &[u8]) -> Vec<Result<Aedat4Packet, IoError>> {
    Packets::from_input(Input::memory("recording.aedat4", bytes.to_vec())).unwrap().collect()
}

/// The same file as if its recorder had been killed.
fn killed(mut bytes: Vec<u8>) -> Vec<u8> {
    let table = header::read(&mut Input::memory("x", bytes.clone())).unwrap().table.unwrap();
    let place = bytes.windows(8).position(|eight| eight == table.to_le_bytes()).unwrap();
    bytes[place..place + 8].copy_from_slice(&(-1_i64).to_le_bytes());
    bytes.truncate(table as usize);
    bytes
}

#[test]
fn another_camera_of_a_file_is_read_where_it_is_asked_for() {
    let bytes = file(Compression::Lz4, &streams(), &recording());
    let camera = |camera| OpenOptions { camera, ..OpenOptions::default() };
    for (asked, events, other) in
        [(None, 90, "camera 1"), (Some(0), 90, "camera 1"), (Some(1), 3, "camera 0")]
    {
        let read = open(&bytes, &camera(asked)).unwrap();
        assert_eq!((read.stream.len(), read.stream.sensor()), (events, SENSOR));
        assert!(matches!(&read.remarks[..], [one] if one.ends_with(other)), "{:?}", read.remarks);
    }
    let message = open(&bytes, &camera(Some(2))).unwrap_err().to_string();
    assert_eq!(message, "recording.aedat4: no camera 2: the file has 2 of them");
}

#[test]
fn the_header_names_the_source_and_the_streams() {
    let bytes = file(Compression::Zstd, &streams(), &[]);
    let source = source(&bytes);
    let want = [
        ("source", "camera & 0"),
        ("packing", "ZSTD"),
        ("streams", "0 events 346x260, 1 frames 346x260, 2 imu, 3 triggers, 7 events 346x260"),
    ];
    let facts: Vec<_> = source.header().facts.iter().map(|(name, f)| (*name, f.as_str())).collect();
    assert_eq!(facts, want);
    assert_eq!(source.header().sensor, Some(SENSOR));
}

#[test]
fn a_file_whose_recorder_was_killed_is_read_to_its_end() {
    for compression in [Compression::None, Compression::Lz4, Compression::Zstd] {
        let bytes = killed(file(compression, &streams()[..4], &recording()[..2]));
        let read = open(&bytes, &OpenOptions::default()).unwrap();
        assert_eq!(read.stream.iter().collect::<Vec<_>>(), (0..40).map(event).collect::<Vec<_>>());
        assert!(read.remarks[0].starts_with("the file has no data table"), "{:?}", read.remarks);
    }
}

#[test]
fn streams_that_no_header_names_are_detected_by_their_packets() {
    // Every stream that the XML names gets a number that it cannot have.
    let mut bytes = file(Compression::None, &streams(), &recording());
    let places: Vec<usize> = (0..bytes.len() - 5)
        .filter(|&k| bytes[k..].starts_with(b"name=\"") && bytes[k + 6].is_ascii_digit())
        .collect();
    places.iter().for_each(|&place| bytes[place + 6] = b'x');
    // Other programs' headers have no checksum.
    let sums: Vec<usize> = (0..bytes.len()).filter(|&k| bytes[k..].starts_with(b"xxh32")).collect();
    sums.iter().for_each(|&place| bytes[place] = b'y');
    let read = open(&bytes, &OpenOptions::default()).unwrap();
    assert_eq!((places.len(), read.stream.len()), (5, 90));
    let camera = OpenOptions { camera: Some(1), ..OpenOptions::default() };
    assert_eq!(open(&bytes, &camera).unwrap().stream.len(), 3);
}

#[test]
fn settings_of_other_programs_among_the_streams_are_passed_over() {
    let text = "<dv><node name=\"outInfo\"><node name=\"jAERConfigSnapshot\"><attr key=\"a\">7</attr>\
        </node><node name=\"4\"><attr key=\"typeIdentifier\">EVTS</attr><node name=\"info\">\
        <attr key=\"sizeX\">640</attr><attr key=\"sizeY\">480</attr></node></node></node></dv>";
    let found = header::streams(text);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].id, found[0].kind), (4, StreamKind::Events));
    assert_eq!(found[0].size, Some(SensorSize { width: 640, height: 480 }));
}

#[test]
fn files_of_other_versions_are_refused_with_their_version() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("old.aedat");
    for version in ["1.0", "2.0", "3.1"] {
        let begin = format!("#!AER-DAT{version}\r\n# This is a raw AE data file - do not edit\r\n");
        assert!(!(FORMAT.probe)(begin.as_bytes()));
        assert_eq!(other_version(begin.as_bytes()), Some(version));
        fs::write(&path, begin).unwrap();
        assert!(!detect_format(&path).is_ok_and(|format| format.name == FORMAT.name));
    }
    fs::write(&path, "#!AER-DAT5.0\r\n\u{1}\0\u{1}\0").unwrap();
    let message = crate::open(&path).unwrap_err().to_string();
    assert!(message.contains("AEDAT 5.0 is not read"), "{message}");
}

#[test]
fn what_the_format_cannot_hold_is_not_written() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("recording.aedat4");
    let create = |compression, streams: &[Stream]| Writer::create(&path, compression, streams);
    let message = |result: Result<Writer, IoError>| result.err().unwrap().to_string();
    let high = message(create(Compression::Lz4High, &streams()));
    assert!(high.ends_with("there is no compressor for LZ4_HIGH here"), "{high}");
    let twice = message(create(
        Compression::None,
        &[stream(4, StreamKind::Imu), stream(4, StreamKind::Imu)],
    ));
    assert!(twice.ends_with("two streams of number 4"), "{twice}");
    let large = SensorSize { width: 32_769, height: 1 };
    let mut wide = stream(0, StreamKind::Events);
    wide.size = Some(large);
    assert!(message(create(Compression::None, &[wide])).contains("32769x1"));
    assert!((FORMAT.create.unwrap())(&path, large).is_err());

    let mut writer = create(Compression::None, &streams()).unwrap();
    let mut refused = |stream, content, why: &str| {
        let message = writer.packet(&Aedat4Packet { stream, content }).unwrap_err().to_string();
        assert!(message.contains(why), "{message}");
    };
    let far = Event { x: 32_768, ..event(0) };
    refused(0, Content::Events(Columns::from_iter([far])), "column or row 32768");
    refused(1, events(0..1), "events in stream 1, which holds frames");
    refused(5, events(0..1), "no stream 5");
    let Content::Frame(frame) = recording()[1].content.clone() else { unreachable!() };
    refused(1, Content::Frame(Frame { width: 5, ..frame.clone() }), "5x3 pixels with 12 bytes");
    let format = PixelFormat { depth: Depth::U8, channels: 5 };
    refused(1, Content::Frame(Frame { format, ..frame }), "more than 4 channels");
    drop(writer);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}
