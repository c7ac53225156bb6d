use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use proptest::prelude::*;

use super::*;
use crate::sample::event;
use crate::wire::Wire;
use crate::{Columns, Input, IoError, OpenOptions, Recording, open, read_as};

const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

/// Event number `k`.
fn nth(k: i64) -> Event {
    event(3 * k, (7 * k % 346) as u16, (11 * k % 260) as u16, k % 3 == 0)
}

fn stream(range: std::ops::Range<i64>) -> EventStream {
    EventStream::from_events(SENSOR, range.map(nth)).unwrap()
}

/// A stream of these packets.
fn written(packets: &[EventStream]) -> Vec<u8> {
    let mut writer = FramedWriter::begin("test", Vec::new(), SENSOR).unwrap();
    packets.iter().for_each(|packet| writer.push(packet).unwrap());
    writer.into_inner()
}

/// All events of a stream that comes in pieces, and how it ended.
fn read(bytes: &[u8], piece: usize) -> (Columns, u64, Result<(), IoError>) {
    let wire = Wire::new(bytes.chunks(piece).map(<[u8]>::to_vec), true);
    let mut columns = Columns::new();
    let mut reader = match FramedReader::open("test", wire) {
        Ok(reader) => reader,
        Err(error) => return (columns, 0, Err(error)),
    };
    loop {
        match reader.next(&mut columns) {
            Ok(true) => {}
            Ok(false) => return (columns, reader.malformed(), Ok(())),
            Err(error) => return (columns, reader.malformed(), Err(error)),
        }
    }
}

fn file(bytes: &[u8], salvage: bool) -> Result<Recording, IoError> {
    let options = OpenOptions { salvage, ..OpenOptions::default() };
    read_as(Input::memory("test.evs", bytes.to_vec()), &options)
}

#[test]
fn every_byte_is_as_documented() {
    // What the Python program of the module's description sends, struct.pack by struct.pack.
    let bytes = b"EVPOSE1\n\x5a\x01\x04\x01\0\0\0\0\
        EVTS\x02\0\0\0\xfb\xff\xff\xff\xff\xff\xff\xff\
        \0\0\0\0\x59\x01\x03\x81\
        \x07\0\0\0\x01\x00\x02\x00\
        EVTS\0\0\0\0\0\0\0\0\0\0\0\0";
    let want = [event(-5, 345, 259, true), event(2, 1, 2, false)];
    for piece in [1, 3, 1000] {
        let (columns, malformed, ended) = read(bytes, piece);
        ended.unwrap();
        assert_eq!((columns.iter().collect::<Vec<_>>(), malformed), (want.to_vec(), 0));
    }
    let events = EventStream::from_events(SENSOR, want).unwrap();
    assert_eq!(written(&[events])[..], bytes[..48]);
}

#[test]
fn nothing_is_waited_for_that_is_not_needed() {
    let bytes = written(&[stream(0..50), stream(50..51)]);
    let first = 16 + 16 + 50 * 8;
    // Neither for the packet behind, of which a part has come, nor for the end.
    for cut in [first, first + 3, first + 16, first + 23] {
        let wire = Wire::new([bytes[..20].to_vec(), bytes[20..cut].to_vec()], false);
        let mut reader = FramedReader::open("test", wire).unwrap();
        assert_eq!(reader.sensor(), SENSOR);
        let mut columns = Columns::new();
        assert!(reader.next(&mut columns).unwrap());
        assert_eq!(columns.len(), 50, "{cut}");
    }
}

#[test]
fn packets_that_came_at_once_are_given_by_the_millisecond() {
    let packet = |t: i64| EventStream::from_events(SENSOR, [event(t, 1, 1, true)]).unwrap();
    let bytes = written(&[0, 300, 999, 1_000, 1_500, 40, 60].map(packet));
    let mut reader = FramedReader::open("test", &bytes[..]).unwrap();
    let mut columns = Columns::new();
    let lengths = [3, 5, 7].map(|_| {
        assert!(reader.next(&mut columns).unwrap());
        columns.len()
    });
    assert_eq!(lengths, [3, 5, 7]);
    assert!(!reader.next(&mut columns).unwrap());
}

#[test]
fn a_long_packet_comes_in_parts() {
    let count = 300_000_u32;
    let mut bytes = layout::header(SENSOR).to_vec();
    bytes.extend(layout::Head { count, base: Micros(1_000) }.bytes());
    bytes.extend((0..count).flat_map(|k| layout::encode(k, 1, 2, Polarity::On)));
    let mut reader = FramedReader::open("test", &bytes[..]).unwrap();
    let (mut all, mut part) = (Columns::new(), Columns::new());
    while reader.next(&mut part).unwrap() {
        assert!(part.len() <= (1 << 16) + (1 << 15), "{}", part.len());
        part.iter().for_each(|event| all.push(event));
        part.clear();
    }
    assert!(all.iter().eq((0..i64::from(count)).map(|k| event(1_000 + k, 1, 2, true))));
}

#[test]
fn what_is_no_packet_is_passed_over_to_the_next() {
    let packets = [stream(0..40), stream(40..80), stream(80..120)];
    let bytes = written(&packets);
    let second = 16 + 16 + 40 * 8;
    let spoilt = |spoil: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = bytes.clone();
        spoil(&mut bytes);
        bytes
    };
    let noise: Vec<u8> = (0..999_u32).map(|k| ((k * k) >> 3) as u8).collect();
    let cases = [
        // A marker, a count, a base, and noise in front of a packet.
        (spoilt(&|b| b[second] = b'X'), 80),
        (spoilt(&|b| b[second + 7] = 0xff), 80),
        (spoilt(&|b| b[second + 15] = 0x7f), 80),
        (spoilt(&|b| drop(b.splice(second..second, noise.iter().copied()))), 120),
    ];
    for (case, (bytes, left)) in cases.iter().enumerate() {
        for piece in [1, 13, 1 << 20] {
            let (columns, malformed, ended) = read(bytes, piece);
            ended.unwrap();
            assert_eq!((columns.len(), malformed), (*left, 1), "{case}");
        }
        let error = file(bytes, false).unwrap_err();
        assert_eq!(error.byte(), Some(second as u64), "{error}");
        let salvaged = file(bytes, true).unwrap();
        assert_eq!(salvaged.stream.len(), *left);
        assert!(salvaged.remarks[0].contains("passed over at 1 places"), "{:?}", salvaged.remarks);
    }
}

#[test]
fn a_cut_stream_gives_what_there_is_and_says_where_it_ends() {
    let bytes = written(&[stream(0..5), stream(5..9)]);
    let (first, second) = (16 + 16 + 5 * 8, 16 + 16 + 5 * 8 + 16 + 4 * 8);
    assert_eq!(bytes.len(), second);
    for cut in 0..bytes.len() {
        let (columns, malformed, ended) = read(&bytes[..cut], 7);
        let whole = match cut {
            ..32 => 0,
            _ if cut < first => (cut - 32) / 8,
            _ if cut < first + 16 => 5,
            _ => 5 + (cut - first - 16) / 8,
        };
        assert!(columns.iter().eq((0..whole as i64).map(nth)), "{cut}: {}", columns.len());
        assert_eq!((malformed, ended.is_ok()), (0, cut == 16 || cut == first), "{cut}");
        if let Err(error) = ended {
            let IoError::Damaged { byte, events, .. } = error else { panic!("{error}") };
            assert!(byte <= cut as u64 && events == whole as u64, "{cut}: {byte}, {events}");
            assert!(file(&bytes[..cut], false).is_err(), "{cut}");
        }
    }
}

#[test]
fn a_header_that_is_none_is_refused() {
    let message = |bytes: &[u8]| read(bytes, 100).2.unwrap_err().to_string();
    let mut bytes = layout::header(SENSOR);
    assert!(message(b"#!AER-DAT4.0\r\n    ").contains("byte 0: the stream does not begin with"));
    assert!(message(&bytes[..9]).contains("byte 9: the stream ends 9 bytes into its header"));
    bytes[15] = 1;
    assert!(message(&bytes).contains("byte 12: the stream is of a later version"));
    bytes[10..12].copy_from_slice(&[0, 0]);
    assert!(message(&bytes).contains("byte 8: a sensor of 346x0"));
    bytes[10..12].copy_from_slice(&[1, 0x80]);
    assert!(message(&bytes).contains("byte 8: a sensor of 346x32769"));
}

#[test]
fn what_the_format_cannot_hold_is_not_written() {
    let tall = SensorSize { width: 1, height: 32_769 };
    assert!(FramedWriter::begin("test", Vec::new(), tall).is_err());
    let mut writer = FramedWriter::begin("test", Vec::new(), SENSOR).unwrap();
    let large = SensorSize { width: 640, height: 480 };
    for bad in [event(0, 346, 0, true), event(1 << 61, 0, 0, true), event(i64::MIN, 0, 0, true)] {
        let events = EventStream::from_events(large, [bad]).unwrap();
        assert!(matches!(writer.push(&events), Err(IoError::Unwritable { .. })), "{bad:?}");
    }
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("no.evs");
    assert!((FORMAT.create.unwrap())(&path, tall).is_err());
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
}

#[test]
fn a_file_of_many_blocks_is_read_and_sought() {
    let events = stream(0..200_000);
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("long.evs");
    FORMAT.write(&path, &events).unwrap();
    let back = open(&path).unwrap();
    assert_eq!((back.format, &back.stream), ("framed", &events));
    let (_, mut source) =
        open::unordered(Input::file(&path).unwrap(), &OpenOptions::default()).unwrap();
    source.seek(Micros(450_000)).unwrap();
    let mut columns = Columns::new();
    source.next(&mut columns).unwrap();
    assert!(columns.t[0] <= Micros(450_000) && columns.t.contains(&Micros(450_000)));
}

proptest! {
    #[test]
    fn events_survive_in_any_pieces(
        steps in prop::collection::vec((0..1_u64 << 33, 0..346_u16, 0..260_u16, any::<bool>()), 0..60),
        begin in -(1_i64 << 59)..(1 << 59),
        split in 1..20_usize,
        piece in 1..200_usize,
    ) {
        let mut t = begin;
        let events: Vec<Event> = steps
            .iter()
            .map(|&(step, x, y, on)| {
                t += step as i64;
                event(t, x, y, on)
            })
            .collect();
        let packets: Vec<EventStream> = events
            .chunks(split)
            .map(|part| EventStream::from_events(SENSOR, part.iter().copied()).unwrap())
            .collect();
        let (columns, malformed, ended) = read(&written(&packets), piece);
        prop_assert!(ended.is_ok() && malformed == 0);
        prop_assert!(columns.iter().eq(events));
    }

    #[test]
    fn random_bytes_never_panic_or_give_what_was_not_there(
        bytes in prop::collection::vec(prop::sample::select(b"EVTS\0\0\0\x01\x02\xff".to_vec()), 0..400),
        piece in 1..50_usize,
    ) {
        let bytes = [&layout::header(SENSOR)[..], &bytes].concat();
        let (columns, _, _) = read(&bytes, piece);
        prop_assert!(columns.len() <= bytes.len() / 8);
        let _ = file(&bytes, false);
        let _ = file(&bytes, true);
    }
}

#[test]
fn a_sensor_larger_than_any_is_refused_with_the_header() {
    for (width, height, is_taken) in [(4096_u16, 4096_u16, true), (65_535, 32_768, false)] {
        let sides = [width.to_le_bytes(), height.to_le_bytes(), [0; 2], [0; 2]].concat();
        let header = [&MAGIC[..], &sides].concat();
        match FramedReader::open("stream", header.as_slice()) {
            Ok(_) => assert!(is_taken, "{width}"),
            Err(error) => {
                assert!(!is_taken && matches!(error, IoError::SensorTooLarge { .. }), "{error}");
            }
        }
    }
}
