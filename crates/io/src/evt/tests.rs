use std::fs;

use evpose_core::{Event, EventStream, Micros, SensorSize, TimeWindow};
use proptest::prelude::*;

use super::*;
use crate::sample::{event, read_all};
use crate::{
    Columns, Decoder, Input, IoError, OpenOptions, Recording, SensorOrigin, Windows, open, read_as,
    source,
};

const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

fn words16(words: &[u16]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

fn with_header(header: &str, data: &[u8]) -> Input {
    Input::memory("test.raw", [header.as_bytes(), data].concat())
}

const EVT3_HEADER: &str = "% evt 3.0\n% geometry 346x260\n% end\n";
const EVT2_HEADER: &str = "% evt 2.0\n% geometry 346x260\n% end\n";

fn read(input: Input) -> Recording {
    read_as(input, &OpenOptions::default()).unwrap()
}

/// Events in the order of the file, and remarks.
fn raw(input: Input, options: &OpenOptions) -> (Vec<Event>, Vec<String>) {
    let (columns, remarks, fault) = read_all(&mut *open::unordered(input, options).unwrap().1);
    assert!(fault.is_none(), "{fault:?}");
    (columns.iter().collect(), remarks)
}

#[test]
fn every_word_of_evt3_means_what_its_document_says() {
    let data = words16(&[
        0x8001, 0x6002, // 4098 µs
        0x0007, 0x2803, 0x2004, // row 7: ON at 3, OFF at 4
        0x3810, 0x4801, 0x4003, 0x5081, // ON from 16: 16, 27; 28, 29; 40, 47
        0x4001, // and on: 48
        0x6003, 0x3020,
        0x5FFF, // 4099 µs, OFF from 32: 32..40, upper bits of a vector of 8 unused
        0x3020, 0x4001, 0x4002, 0x4001, // no vector of 8 as third: 32, 45, 56
    ]);
    let (events, remarks) = raw(with_header(EVT3_HEADER, &data), &OpenOptions::default());
    let mut want = vec![event(4098, 3, 7, true), event(4098, 4, 7, false)];
    want.extend([16, 27, 28, 29, 40, 47, 48].map(|x| event(4098, x, 7, true)));
    want.extend((32..40).chain([32, 45, 56]).map(|x| event(4099, x, 7, false)));
    assert_eq!((events, remarks), (want, vec![]));
}

#[test]
fn vectors_beyond_the_coordinates_of_words_are_still_decoded() {
    let data = words16(&[
        0x8001, 0x6002, 0x0007, 0x2803, // 4098 µs, row 7: ON at 3
        0x3FF8, 0x4801, 0x4003, 0x5081, // ON from 2040
        0x2004,
    ]);
    let input = with_header("% evt 3.0\n% end\n", &data);
    let (events, _) = raw(input, &OpenOptions::default());
    let xs = [3, 2040, 2051, 2052, 2053, 2064, 2071];
    let mut want: Vec<Event> = xs.map(|x| event(4098, x, 7, true)).into();
    want.push(event(4098, 4, 7, false));
    assert_eq!(events, want);
}

#[test]
fn the_clock_of_evt3_turns_over_and_goes_back_as_in_the_vendors_decoder() {
    let data = words16(&[
        0x8FFF, 0x6FFF, 0x0001, 0x2001, // the last microsecond of a turn
        0x8000, 0x2002, // the low time is 0 until it comes
        0x6005, 0x2003, 0x6002, 0x2004, // back within one high time
        0x8000, 0x2005, // the same high time again changes nothing
        0x8001, 0x8000, 0x6007, 0x2006, // a small step back of the high time is one
    ]);
    let (events, _) = raw(with_header(EVT3_HEADER, &data), &OpenOptions::default());
    let turn = 1 << 24;
    let want = [turn - 1, turn, turn + 5, turn + 2, turn + 2, turn + 7];
    assert_eq!(events.iter().map(|e| e.t.0).collect::<Vec<_>>(), want);
}

#[test]
fn what_stands_before_time_and_place_is_counted_and_not_made_up() {
    let data = words16(&[
        0x0001, 0x2001, 0x3000, 0x4007, 0x6001, 0xA101, // before any time
        0x8001, 0x2002, 0x5003, 0x6001, 0x0002, 0x4001, // no row; then no base
        0x2003, 0xE014, 0xF001, 0xF002, 0x7003, 0xB000, 0xD000,
    ]);
    let (events, remarks) = raw(with_header(EVT3_HEADER, &data), &OpenOptions::default());
    assert_eq!(events, [event(4097, 3, 2, false)]);
    assert_eq!(
        remarks,
        [
            "4 events stand before the first time stamp: they are left out",
            "4 events stand before the first row or base: they are left out",
            "1 edges of trigger inputs are no events: they are left out",
            "4 words of monitoring data are passed over",
            "2 words of unknown types are passed over",
        ]
    );
}

#[test]
fn of_two_cameras_one_is_read_and_the_other_counted() {
    let data = words16(&[
        0x8000, 0x6001, 0x0805, 0x2001, 0x0006, 0x2002, 0x3000, 0x5003, 0x0805, 0x2003, 0x5001,
        0x1005, 0x2004, // a row that is none of events
    ]);
    let of = |camera| {
        let options = OpenOptions { camera, ..OpenOptions::default() };
        let (events, remarks) = raw(with_header(EVT3_HEADER, &data), &options);
        (events.iter().map(|e| (e.x, e.y)).collect::<Vec<_>>(), remarks)
    };
    let (slave, remarks) = of(None);
    assert_eq!(slave, [(1, 5), (3, 5), (8, 5)]);
    assert_eq!(of(Some(1)), (slave, remarks.clone()));
    assert_eq!(
        remarks,
        [
            "4 events are of another camera: they are left out",
            "1 words of unknown types are passed over",
        ]
    );
    let (master, remarks) = of(Some(0));
    assert_eq!(master, [(2, 6), (0, 6), (1, 6)]);
    assert!(remarks[0].starts_with("4 events are of another camera"), "{remarks:?}");
}

#[test]
fn every_word_of_evt2_and_its_twin_means_what_its_document_says() {
    let upper = |kind: u32, low: u32, x: u32, y: u32| kind << 28 | low << 22 | x << 11 | y;
    let uppers = [
        (upper(0, 1, 32, 3), 0b1001),
        (0x8000_0002, 0),
        (upper(1, 5, 64, 4), 0x8000_0001),
        (0xA000_0000 | 7 << 22 | 3 << 8 | 1, 0),
        (upper(0, 4, 32, 5), 2),
        (0x8FFF_FFFF, 0),
        (upper(0, 63, 32, 5), 1),
        (0x8000_0000, 0),
        (upper(1, 0, 32, 5), 1),
        (0xE000_0014, 0),
        (0xF000_0001, 0),
        (0x2000_0000, 0),
    ];
    let turn = 1 << 34;
    let remarks = |untimed| {
        vec![
            format!("{untimed} events stand before the first time stamp: they are left out"),
            "1 edges of trigger inputs are no events: they are left out".to_owned(),
            "2 words of monitoring data are passed over".to_owned(),
            "1 words of unknown types are passed over".to_owned(),
        ]
    };

    let data: Vec<u8> = uppers.iter().flat_map(|(word, _)| word.to_le_bytes()).collect();
    let want = [
        event(133, 64, 4, true),
        event(132, 32, 5, false),
        event(turn - 1, 32, 5, false),
        event(turn, 32, 5, true),
    ];
    let (events, found) = raw(with_header(EVT2_HEADER, &data), &OpenOptions::default());
    assert_eq!((&events[..], found), (&want[..], remarks(1)));

    let want = [
        event(133, 64, 4, true),
        event(133, 95, 4, true),
        event(132, 33, 5, false),
        event(turn - 1, 32, 5, false),
        event(turn, 32, 5, true),
    ];
    for (order, is_legacy) in [("little", false), ("legacy", true)] {
        let header = format!("% format EVT21;endianness={order};height=260;width=346\n% end\n");
        let data: Vec<u8> = uppers
            .iter()
            .flat_map(|&(upper, mask)| {
                let halves = if is_legacy { [upper, mask] } else { [mask, upper] };
                halves.map(u32::to_le_bytes).concat()
            })
            .collect();
        let (events, found) = raw(with_header(&header, &data), &OpenOptions::default());
        assert_eq!((&events[..], found), (&want[..], remarks(2)));
    }
}

fn encoded<E: WordEncoder>(events: &EventStream) -> Vec<u8> {
    let mut words = Vec::new();
    E::new(events.sensor()).encode(events, &mut words).unwrap();
    words
}

#[test]
fn the_encoding_is_detected_by_words_where_no_header_states_it() {
    let swapped = |words: Vec<u8>| -> Vec<u8> {
        words.as_chunks::<8>().0.iter().flat_map(|w| [&w[4..], &w[..4]].concat()).collect()
    };
    for stream in [synthetic::scattered(20_000), synthetic::edges(20_000)] {
        let cases = [
            (EVT2.name, encoded::<Evt2Encoder>(&stream)),
            (EVT21.name, encoded::<Evt21Encoder>(&stream)),
            (EVT21.name, swapped(encoded::<Evt21Encoder>(&stream))),
            (EVT3.name, encoded::<Evt3Encoder>(&stream)),
        ];
        for (name, data) in cases {
            for header in ["", "% serial_number 1\n", "% serial_number 1\n% end\n"] {
                let found = read(with_header(header, &data));
                assert_eq!((found.format, found.stream.t()), (name, stream.t()), "{header}");
                assert!(found.stream.iter().eq(stream.iter()), "{name} {header}");
            }
        }
        // EVT 2.1 that does not state its order.
        for data in [encoded::<Evt21Encoder>(&stream), swapped(encoded::<Evt21Encoder>(&stream))] {
            let found = read(with_header("% evt 2.1\n% system_ID 49\n% end\n", &data));
            assert!(found.stream.iter().eq(stream.iter()));
        }
    }
}

#[test]
fn what_is_no_event_file_is_not_taken_for_one() {
    let text = "% A comment of a program\nx = 1\n".repeat(200);
    let integers: Vec<u8> = (0..9000_u32).flat_map(|k| (k % 50).to_le_bytes()).collect();
    let floats: Vec<u8> = (0..9000).flat_map(|k| (k as f32).sqrt().to_le_bytes()).collect();
    let noise: Vec<u8> =
        (0..9000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    for bytes in [text.into_bytes(), integers, floats, noise, b"% ".to_vec(), b"%".to_vec()] {
        let opened = read_as(Input::memory("other", bytes), &OpenOptions::default());
        assert!(matches!(opened, Err(IoError::UnknownFormat { .. })), "{opened:?}");
    }
    let frames = with_header("% format HISTO3D;height=320;width=320\n% end\n", &[0; 64]);
    assert!(read_as(frames, &OpenOptions::default()).is_err());
}

#[test]
fn a_format_behind_what_probes_see_is_found_by_the_reader() {
    let lines = format!("% serial_number 7\n% comment {}\n", "x".repeat(3000)).repeat(2);
    let stream = synthetic::scattered(100);
    let data = encoded::<Evt2Encoder>(&stream);
    let input = with_header(&format!("{lines}% format EVT2;height=720;width=1280\n% end\n"), &data);
    let (format, mut source) = source(input, &OpenOptions::default()).unwrap();
    assert_eq!(format.name, "evt3");
    let facts = [("serial", "7"), ("encoding", "evt2")];
    assert_eq!(source.header().facts, facts.map(|(name, value)| (name, value.to_owned())));
    let mut columns = Columns::new();
    source.next(&mut columns).unwrap();
    assert!(columns.iter().eq(stream.iter()));
}

#[test]
fn what_the_words_cannot_hold_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("events.raw");
    let year_us = 365 * 24 * 3_600_000_000;
    for format in [EVT2, EVT21, EVT3] {
        for t in [-1, 100_000 * year_us] {
            let stream = EventStream::from_events(SENSOR, [event(t, 1, 1, true)]).unwrap();
            let refused = format.write(&path, &stream).unwrap_err().to_string();
            assert!(refused.contains(&format!("event at {t} µs")), "{refused}");
        }
        for size in [(2049, 1), (1, 2049)] {
            let sensor = SensorSize { width: size.0, height: size.1 };
            let refused = format.write(&path, &EventStream::empty(sensor)).unwrap_err();
            assert!(refused.to_string().contains("up to 2048x2048"), "{refused}");
        }
        let mut sink = format.create(&path, SensorSize { width: 10, height: 10 }).unwrap();
        let outside = EventStream::from_events(SENSOR, [event(0, 10, 1, true)]).unwrap();
        assert!(sink.write(&outside).is_err());
        drop(sink);
        assert!(!path.exists());
    }
}

#[test]
fn vectors_are_used_where_they_help_and_change_nothing() {
    let stream = synthetic::edges(50_000);
    let vectors = encoded::<Evt3Encoder>(&stream);
    let mut scalars = Vec::new();
    Evt3Encoder::new(stream.sensor()).without_vectors().encode(&stream, &mut scalars).unwrap();
    assert!(3 * vectors.len() < scalars.len(), "{} of {}", vectors.len(), scalars.len());
    for data in [vectors, scalars] {
        assert!(read(with_header("% evt 3.0\n", &data)).stream.iter().eq(stream.iter()));
    }
    let bytes = encoded::<Evt21Encoder>(&stream).len();
    assert!(bytes < 2 * stream.len(), "{bytes}");
}

#[test]
fn a_file_is_sought_in_by_time() {
    let directory = tempfile::tempdir().unwrap();
    let stream = synthetic::scattered(2_000_000);
    for format in [EVT2, EVT3] {
        let path = directory.path().join("events.raw");
        format.write(&path, &stream).unwrap();
        let mut windows = Windows::open(&path, &OpenOptions::default()).unwrap();
        let mut found = EventStream::empty(windows.sensor());
        for start in [1_900_000, 100, 1_200_000, 1_200_500, 500_000] {
            let window = TimeWindow { start: Micros(start), end: Micros(start + 700) };
            windows.read(window, &mut found).unwrap();
            assert_eq!(found, stream.slice(window), "{} {start}", format.name);
        }
    }
}

#[test]
fn an_end_of_line_behind_the_last_word_is_remarked_on() {
    let mut data = encoded::<Evt3Encoder>(&synthetic::scattered(10));
    data.push(b'\n');
    let found = read(with_header("% evt 3.0\n", &data));
    assert_eq!((found.stream.len(), found.remarks.len()), (10, 1));
}

/// Files of some 100 events in each encoding.
fn samples() -> Vec<(&'static str, Vec<u8>, Vec<Event>)> {
    let directory = tempfile::tempdir().unwrap();
    let stream = synthetic::edges(100);
    let make = |format: crate::Format| {
        let path = directory.path().join(format.name);
        format.write(&path, &stream).unwrap();
        (format.name, fs::read(path).unwrap(), stream.iter().collect())
    };
    [EVT2, EVT21, EVT3].map(make).to_vec()
}

#[test]
fn a_file_cut_at_any_byte_gives_an_error_or_the_exact_prefix() {
    for (name, bytes, events) in samples() {
        for cut in 0..bytes.len() {
            let input = Input::memory("cut.raw", bytes[..cut].to_vec());
            let salvage = OpenOptions { salvage: true, ..OpenOptions::default() };
            let Ok(found) = read_as(input, &salvage) else {
                // A head that ends before the header states the encoding.
                assert!(cut < 100, "{name} cut at {cut}");
                continue;
            };
            let count = found.stream.len();
            assert!(found.stream.iter().eq(events[..count].iter().copied()), "{name} {cut}");
            let input = Input::memory("cut.raw", bytes[..cut].to_vec());
            match read_as(input, &OpenOptions::default()) {
                Ok(whole) => assert_eq!(whole.stream, found.stream),
                Err(IoError::Damaged { byte, events, .. }) => {
                    assert!(byte < cut as u64 && cut as u64 - byte < 8, "{name} {cut} {byte}");
                    assert_eq!(events, count as u64);
                }
                Err(other) => panic!("{name} {cut}: {other}"),
            }
        }
    }
}

/// Any recording that words hold: out of raster order, with gaps of several wraparounds.
fn recordings() -> impl Strategy<Value = EventStream> {
    let step = prop_oneof![
        6 => Just(0_i64), 3 => 0_i64..100, 1 => 0_i64..100_000, 1 => 0_i64..40_000_000
    ];
    let pixel = prop_oneof![2 => Just(None), 1 => (0_u16..346, 0_u16..260).prop_map(Some)];
    let steps = (step, pixel, 1_u16..4, prop::bool::weighted(0.9));
    (0_i64..60_000_000, prop::collection::vec(steps, 0..300)).prop_map(|(start, steps)| {
        let (mut t, mut x, mut y, mut on) = (start, 0, 0, false);
        let events = steps.into_iter().map(|(step, pixel, right, same)| {
            t += step;
            (x, y) = pixel.unwrap_or(((x + right) % 346, y));
            on ^= !same;
            event(t, x, y, on)
        });
        EventStream::from_events(SENSOR, events).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn a_stream_survives_the_file(stream in recordings(), cut in 0_usize..300) {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("events.raw");
        for format in [EVT2, EVT21, EVT3] {
            // In two pieces, of which either may be empty.
            let mut sink = format.create(&path, SENSOR).unwrap();
            for half in [&mut stream.iter().take(cut) as &mut dyn Iterator<Item = Event>,
                &mut stream.iter().skip(cut)] {
                sink.write(&EventStream::from_events(SENSOR, half).unwrap()).unwrap();
            }
            sink.finish().unwrap();
            let back = open(&path).unwrap();
            prop_assert_eq!((back.format, back.sensor_origin), (format.name, SensorOrigin::Stated));
            prop_assert_eq!(&back.stream, &stream);
            // Times of any year are doubted, and nothing else.
            let is_doubt = |remark: &String| remark.contains("another unit");
            prop_assert!(back.remarks.iter().all(is_doubt), "{:?}", back.remarks);
        }
    }

    #[test]
    fn times_of_years_survive_evt2(
        mut times in prop::collection::vec(0_i64..2_000_000_000_000_000, 1..5)
    ) {
        times.sort_unstable();
        let events = times.iter().map(|&t| event(t, 0, 0, true));
        let stream = EventStream::from_events(SENSOR, events).unwrap();
        let found = read(with_header(EVT2_HEADER, &encoded::<Evt2Encoder>(&stream)));
        prop_assert_eq!(found.stream, stream);
    }

    #[test]
    fn pieces_give_what_the_whole_gives(
        words in prop::collection::vec(any::<u16>(), 0..1500),
        pieces in prop::collection::vec(1_usize..400, 1..9),
    ) {
        // Mostly words of events, so that more than a batch comes of them.
        let words: Vec<u16> =
            words.iter().map(|&w| if w & 3 == 0 { w } else { w & 0x7FFF }).collect();
        let data = words16(&[&[0x8001, 0x0001], &words[..]].concat());
        pieces_agree(Evt3Decoder::new(None), &data, &pieces);
        pieces_agree(Evt2Decoder::default(), &data, &pieces);
        pieces_agree(Evt21Decoder::new(false), &data, &pieces);
    }

    #[test]
    fn random_words_behind_a_header_never_panic(
        header in prop::sample::select(vec![EVT2_HEADER, EVT3_HEADER, "% evt 2.1\n", "% serial_number 1\n", "% a"]),
        bytes in prop::collection::vec(any::<u8>(), 0..600),
    ) {
        let _ = read_as(with_header(header, &bytes), &OpenOptions::default());
    }
}

fn pieces_agree(decoder: impl Decoder, data: &[u8], pieces: &[usize]) {
    let (mut whole, mut parts) = (Columns::new(), Columns::new());
    let (mut once, mut often) = (decoder.clone(), decoder);
    once.decode(data, true, &mut whole).unwrap();
    let (mut rest, mut piece) = (data, pieces.iter().cycle());
    while !rest.is_empty() {
        let length = rest.len().min(*piece.next().unwrap() + 8);
        let took = often.decode(&rest[..length], length == rest.len(), &mut parts).unwrap();
        rest = &rest[took..];
        if took == 0 {
            break;
        }
    }
    assert_eq!(whole, parts);
    assert_eq!(once.remarks(), often.remarks());
}
