use std::fs;

use evpose_core::{Event, Micros};
use proptest::prelude::*;

use super::*;
use crate::golden::check;
use crate::open::Format;
use crate::sample::{event, read_all};
use crate::{Columns, EventSource, Input, IoError, OpenOptions, open_as, read_as};

/// A word of the 24-bit codec.
fn word(x: u32, y: u32, on: bool, channel: u32) -> u32 {
    channel << 22 | y << 12 | x << 1 | u32::from(!on)
}

fn source_of(format: Format, bytes: &[u8], options: &OpenOptions) -> Box<dyn EventSource> {
    (format.open)(Input::memory("data.log", bytes.to_vec()), options).unwrap()
}

/// All events, remarks, and the fault that ended it.
fn all_of(bytes: &[u8], options: &OpenOptions) -> (Columns, Vec<String>, Option<IoError>) {
    match (LOG.open)(Input::memory("data.log", bytes.to_vec()), options) {
        Ok(mut source) => read_all(&mut *source),
        Err(fault) => (Columns::new(), Vec::new(), Some(fault)),
    }
}

/// Bottles of 2 ms in text.
fn text(events: &[(u32, u32)], tick_us: f64) -> String {
    let mut lines = String::new();
    for (k, bottle) in events.chunk_by(|a, b| a.0 / 25_000 == b.0 / 25_000).enumerate() {
        let values: Vec<_> = bottle.iter().map(|(t, word)| format!("{t} {word}")).collect();
        let time = 1e-6 * tick_us * f64::from(bottle[0].0);
        lines += &format!("{k} {time:.6} AE ({})\n", values.join(" "));
    }
    lines
}

/// A bottle of binary values.
fn packed(time: &str, values: &[u32]) -> Vec<u8> {
    let mut line = format!("3 {time} AE 1998 \"").into_bytes();
    for byte in values.iter().flat_map(|value| value.to_le_bytes()) {
        match byte {
            0 => line.extend_from_slice(b"\\0"),
            b'\n' => line.extend_from_slice(b"\\n"),
            b'\r' => line.extend_from_slice(b"\\r"),
            b'"' | b'\\' => line.extend_from_slice(&[b'\\', byte]),
            _ => line.push(byte),
        }
    }
    line.extend_from_slice(b"\"\n");
    line
}

/// Events of 100 ms, whose bytes are all there are.
fn sample() -> Vec<(u32, u32)> {
    let word = |k| word(k * 7 % 640, k * 11 % 480, k % 3 == 0, 0);
    (0..400).map(|k| (k * 3131, word(k))).collect()
}

fn events_of(sample: &[(u32, u32)], tick_us: f64) -> impl Iterator<Item = Event> {
    sample.iter().map(move |&(t, word)| {
        let (x, y) = ((word >> 1 & 0x7ff) as u16, (word >> 12 & 0x3ff) as u16);
        event((f64::from(t) * tick_us).round() as i64, x, y, word & 1 == 0)
    })
}

#[test]
fn the_length_of_a_tick_is_measured_by_the_times_of_bottles() {
    for tick_us in [0.08, 1.0] {
        let log = text(&sample(), tick_us);
        let (columns, remarks, fault) = all_of(log.as_bytes(), &OpenOptions::default());
        assert!(fault.is_none() && columns.iter().eq(events_of(&sample(), tick_us)));
        assert!(remarks.is_empty(), "{remarks:?}");
        let facts = source_of(LOG, log.as_bytes(), &OpenOptions::default()).header().facts.clone();
        assert_eq!(facts[1].1, format!("{tick_us} µs (by the times of its bottles)"));
        // Whoever knows better is believed.
        let options = OpenOptions { tick_us: Some(0.5), ..OpenOptions::default() };
        let (columns, ..) = all_of(log.as_bytes(), &options);
        assert!(columns.iter().eq(events_of(&sample(), 0.5)));
    }
    // One bottle decides nothing.
    let (columns, remarks, _) = all_of(b"0 0.000080 AE (1000 3)\n", &OpenOptions::default());
    assert_eq!(columns.t, [Micros(80)]);
    assert!(remarks[0].starts_with("a tick is taken to be 0.08 µs"), "{remarks:?}");
}

#[test]
fn a_mark_of_byte_order_is_no_content_of_a_log() {
    let log = format!("\u{feff}{}", text(&sample(), 1.0));
    let input = Input::memory("data.log", log.as_bytes().to_vec());
    let read = read_as(input, &OpenOptions::default()).unwrap();
    assert!(read.format == "yarp" && read.stream.iter().eq(events_of(&sample(), 1.0)));
    let skeleton = format!("\u{feff}0 0.5 SKLT ({})\n", ["1"; 26].join(" "));
    let read = read_skeletons_from(Input::memory("data.log", skeleton.into_bytes()));
    assert_eq!(read.unwrap().len(), 1);
}

#[test]
fn packed_bottles_with_times_and_without_are_distinguished() {
    let sample = sample();
    let bottle = |events: &[(u32, u32)]| {
        let time = format!("{:.6}", f64::from(events[0].0) * 8e-8);
        packed(&time, &events.iter().flat_map(|(t, word)| [*t, *word]).collect::<Vec<_>>())
    };
    let with_times: Vec<u8> = sample.chunks(50).flat_map(bottle).collect();
    let (columns, remarks, fault) = all_of(&with_times, &OpenOptions::default());
    assert!(fault.is_none() && columns.iter().eq(events_of(&sample, 0.08)), "{fault:?}");
    assert!(remarks.is_empty(), "{remarks:?}");

    let words: Vec<u32> = sample.iter().map(|(_, word)| *word).collect();
    let bottle = |(k, words): (usize, &[u32])| packed(&format!("0.{k:02}0000"), words);
    let without: Vec<u8> = words.chunks(51).enumerate().flat_map(bottle).collect();
    let (columns, remarks, fault) = all_of(&without, &OpenOptions::default());
    let want = events_of(&sample, 0.0).zip(0..);
    let want = want.map(|(event, k)| Event { t: Micros(k / 51 * 10_000), ..event });
    assert!(fault.is_none() && columns.iter().eq(want));
    assert_eq!(remarks, ["400 words come without a time and have that of their bottle"]);
}

#[test]
fn a_corner_is_an_event_of_the_newer_codec_and_none_of_the_24_bits() {
    let corner = word(1234, 1000, true, 0) | 1 << 25;
    let (columns, ..) = all_of(&packed("0.5", &[100, corner]), &OpenOptions::default());
    assert!(columns.iter().eq([event(8, 1234, 1000, true)]));
    let log = format!("0 0.5 AE (100 {corner} 200 {} 300 4)\n", 1 << 24);
    let (columns, remarks, _) = all_of(log.as_bytes(), &OpenOptions::default());
    assert!(columns.iter().eq([event(24, 2, 0, true)]));
    assert_eq!(remarks[1], "2 words that are no events are passed over");
}

#[test]
fn the_channel_is_the_camera() {
    let events: Vec<_> =
        (0..40).map(|k| (k * 1000, word(k, k, true, u32::from(k % 4 == 0)))).collect();
    let log = text(&events, 1.0);
    for (camera, want) in [(None, 30), (Some(0), 30), (Some(1), 10), (Some(7), 0)] {
        let options = OpenOptions { camera, ..OpenOptions::default() };
        let (columns, remarks, _) = all_of(log.as_bytes(), &options);
        assert_eq!(columns.len(), want);
        assert!(remarks[0].starts_with(&format!("{} events of camera", 40 - want)), "{remarks:?}");
    }
    let right: Vec<_> = events.iter().map(|(t, word)| (*t, word | 1 << 22)).collect();
    let (columns, remarks, _) = all_of(text(&right, 1.0).as_bytes(), &OpenOptions::default());
    assert_eq!((columns.len(), remarks.len()), (40, 0));
}

#[test]
fn times_wrap_around_at_the_power_of_two_above_the_largest() {
    for bits in [24, 31, 32] {
        let period = 1_u64 << bits;
        let times =
            [period - 30_000, period - 3, period + 5, period + 4, 2 * period - 2, 2 * period];
        let events: Vec<_> =
            times.iter().map(|t| format!("{} 3", (t % period) as u32 as i32)).collect();
        let log = format!("0 0.5 AE ({})\n", events.join(" "));
        let options = OpenOptions { tick_us: Some(1.0), ..OpenOptions::default() };
        let (columns, remarks, fault) = all_of(log.as_bytes(), &options);
        assert!(fault.is_none(), "{fault:?}");
        assert_eq!(columns.t, times.map(|t| Micros(t as i64)), "{bits}");
        assert_eq!(remarks, ["times wrapped around 2 times"]);
    }
}

#[test]
fn bottles_of_other_kinds_are_counted() {
    let log = "0 0.001 AE (1000 3)\n\
               1 0.002 SKLT (1 2) -1 3\n\
               2 0.003 IMUS (5 6\n\
               \n\
               3 0.004 LAE (2000 5 77 3000 7 78)\n\
               4 0.005 FLOW (4000 9 1 -2)\n\
               5 0.006 frame_1.png [rgb]\n\
               6 0.007 IMUS ()\n\
               7 0.008 AE ()";
    let options = OpenOptions { tick_us: Some(1.0), ..OpenOptions::default() };
    let (columns, remarks, fault) = all_of(log.as_bytes(), &options);
    assert!(fault.is_none(), "{fault:?}");
    let want = [(1000, 1), (2000, 2), (3000, 3), (4000, 4)].map(|(t, x)| event(t, x, 0, false));
    assert!(columns.iter().eq(want), "{columns:?}");
    let want = ["2 bottles IMUS", "1 bottles SKLT", "1 bottles frame_1.png"];
    assert_eq!(remarks, want.map(|what| format!("{what} are passed over")));
}

#[test]
fn a_faulty_bottle_is_named_with_its_byte() {
    let cases = [
        ("0 0.1 AE (1 2 3)\n", 15, "the bottle ends within an event"),
        ("0 0.1 AE (1 2 3 x)\n", 16, "no number of 32 bits"),
        ("0 0.1 AE (1 2 3 4294967296)\n", 16, "no number of 32 bits"),
        ("0 0.1 AE (1 2)\nnonsense\n", 15, "a bottle begins with its number"),
        ("0 0.1 AE (1 2 3 4", 13, "the file ends 4 bytes into a record"),
        ("0 0.1 AE (1 2)\n1 0.1 AE \"abc\"\n", 28, "the bottle ends within an event"),
        ("0 0.1 AE (1 2)\n1 0.1 AE \"ab\\t\"\n", 27, "an unknown escape"),
        ("0 0.1 AE (1 2)\n1 0.1 AE \"ab\n", 27, "the line ends within a bottle"),
    ];
    for (log, byte, reason) in cases {
        let (columns, _, fault) = all_of(log.as_bytes(), &OpenOptions::default());
        let message = fault.unwrap().to_string();
        let want = format!("data.log: byte {byte}: {reason}");
        assert!(message.starts_with(&want), "{message}\n{want}");
        assert!(message.ends_with("(1 events readable before it)"), "{message}");
        assert_eq!(columns.len(), 1);
    }
    let (_, _, fault) = all_of(&b"1 0.1 ".repeat(2000), &OpenOptions::default());
    assert!(fault.unwrap().to_string().contains("no bottle in this line"));
}

#[test]
fn a_bottle_of_any_length_is_read() {
    let events: Vec<_> =
        (0..100_000).map(|k| (k / 10, word(k % 640, k % 480, k % 2 == 0, 0))).collect();
    let log = text(&events, 1.0);
    assert_eq!(log.lines().count(), 1);
    let options = OpenOptions { tick_us: Some(1.0), ..OpenOptions::default() };
    let (columns, _, fault) = all_of(log.as_bytes(), &options);
    assert!(fault.is_none() && columns.iter().eq(events_of(&events, 1.0)));
}

#[test]
fn a_first_bottle_that_is_cut_says_too_little_of_its_words() {
    let words: Vec<_> = (0..40).map(|k| word(k, k, true, 0)).collect();
    let bottle = packed("0.5", &words);
    // Four bytes a word and more: ten words of forty, which ascend as times do.
    let (columns, _, fault) = all_of(&bottle[..80], &OpenOptions::default());
    let fault = fault.unwrap();
    assert!(columns.is_empty() && fault.byte() == Some(80), "{fault}");
    assert!(fault.to_string().contains("whether its words come with times"), "{fault}");
}

#[test]
fn a_folder_is_opened_and_distinguished_from_text() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("data.log");
    fs::write(&path, text(&sample(), 0.08)).unwrap();
    let recording = open_as(directory.path(), &OpenOptions::default()).unwrap();
    assert_eq!((recording.format, recording.stream.len()), ("yarp", 400));
    fs::write(&path, "0.5 12 13 1\n0.6 12 13 0\n").unwrap();
    assert_eq!(open_as(&path, &OpenOptions::default()).unwrap().format, "text");
    for head in ["1 2.0 3 1\n", "1 2 AE (3 4)\n", "t x y p\n", "1.0 2.0 AE (3 4)\n", "", "5"] {
        assert!(!(LOG.probe)(head.as_bytes()), "{head}");
    }
    assert!((LOG.probe)(b"0 0000.0 SKLT (1 2") && (LOG.probe)(b"-1 0.5 AE 1998 \"\\0\xff"));
}

#[test]
fn binary_events_are_recognised_and_read() {
    let sample = sample();
    let log: Vec<u8> = sample
        .iter()
        .flat_map(|(t, word)| [t.to_le_bytes(), word.to_le_bytes()].concat())
        .collect();
    let recording = read_as(Input::memory("x", log.clone()), &OpenOptions::default()).unwrap();
    assert_eq!(recording.format, "yarp-binary");
    assert!(recording.stream.iter().eq(events_of(&sample, 0.08)));
    assert!(recording.remarks[0].starts_with("a tick is taken to be 0.08 µs"));
    let options = OpenOptions { tick_us: Some(1.0), ..OpenOptions::default() };
    let recording = read_as(Input::memory("x", log.clone()), &options).unwrap();
    assert!(recording.stream.iter().eq(events_of(&sample, 1.0)) && recording.remarks.is_empty());

    let probe = BINARY.probe;
    assert!(probe(&log[..64]) && !probe(&log[..56]) && !probe(&log[..65]));
    assert!(!probe(&[0; 400]) && !probe(&[7; 400]) && !probe(&[1, 2, 3, 0].repeat(100)));
    for cut in 0..300 {
        let mut source = source_of(BINARY, &log[..cut], &OpenOptions::default());
        let mut columns = Columns::new();
        let mut result = source.next(&mut columns);
        if result.is_ok() {
            result = source.next(&mut columns);
        }
        assert!(columns.iter().eq(events_of(&sample, 0.08).take(cut / 8)));
        assert_eq!(result.is_ok(), cut % 8 == 0);
    }
}

#[test]
fn skeletons_are_read() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("data.log");
    let values: Vec<_> = (0..26).map(|k| (10 * k).to_string()).collect();
    let (close, wide) = (values.join(" "), values.join("   "));
    let log = format!(
        "0 0000.0 SKLT ({close}) -1.0 104.3\n\n1 000.02 SKLT ( {wide} ) 35.5 -1.0\n2 000.04 SKLT ({close})\n"
    );
    fs::write(&path, &log).unwrap();
    let found = read_skeletons(directory.path()).unwrap();
    let facts: Vec<_> = found.iter().map(|s| (s.t.0, s.head_size_px, s.torso_size_px)).collect();
    assert_eq!(facts, [(0, None, Some(104.3)), (20_000, Some(35.5), None), (40_000, None, None)]);
    assert!(found.iter().all(|s| s.confidences.is_none()));
    assert!(found.iter().all(|s| s.joints[0] == [0.0, 10.0] && s.joints[12] == [240.0, 250.0]));
    for (log, byte) in [
        (format!("0 0000.0 SKLT ({close}) -1.0 104.3\n1 0.1 SKLT ({close} 5)\n"), 0),
        (format!("0 0.0 SKLT ({close})\n1 0.1 AE ({close})\n"), 1),
        (format!("0 0.0 SKLT ({close})\n1 0.1 SKLT (1 2 3)\n"), 1),
        (format!("0 0.0 SKLT ({close})\n1 0.1 SKLT (1 2\n"), 1),
        (format!("0 0.0 SKLT ({close})\n1 0.1 SKLT ({close}) 35.5 10"), 1),
    ] {
        fs::write(&path, &log).unwrap();
        let line = log.find('\n').unwrap() as u64 + 1;
        let fault = read_skeletons(&path).unwrap_err();
        assert!(
            matches!(fault, IoError::Damaged { byte: at, events: 1, .. } if at == line),
            "{byte} {fault}"
        );
    }
}

#[test]
fn skeletons_of_a_network_come_with_confidences() {
    let values: Vec<_> = (0..39).map(|k| format!("{k}.5")).collect();
    let log = format!("0 1700000000.123456 SKLT ({})\n", values.join(" "));
    let found = read_skeletons_from(Input::memory("data.log", log.into_bytes())).unwrap();
    assert_eq!((found[0].joints[12], found[0].torso_size_px), ([24.5, 25.5], None));
    let confidences = found[0].confidences.unwrap();
    assert_eq!((confidences[0], confidences[12]), (26.5, 38.5));
}

/// See `tests/golden/yarp`.
#[test]
fn logs_of_bimvee_are_read_as_it_reads_them() {
    let files = ["text-80ns.log", "text-1us.log", "packed-80ns.log", "packed-without-times.log"];
    check("yarp", &files.map(|name| (name, "yarp")));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_events_are_read_back_from_each_kind_of_log(
        events in prop::collection::vec((0..1_000_000_u32, 0..2048_u32, 0..1024_u32, any::<bool>()), 1..60),
    ) {
        let mut t = 0_u32;
        let events: Vec<_> = events.iter().map(|&(step, x, y, on)| {
            t += step;
            (t, word(x, y, on, 0))
        }).collect();
        let values: Vec<_> = events.iter().flat_map(|(t, word)| [*t, *word]).collect();
        let options = OpenOptions { tick_us: Some(0.08), ..OpenOptions::default() };
        let packed: Vec<u8> = values.chunks(16).flat_map(|part| packed("0.1", part)).collect();
        for log in [text(&events, 0.08).into_bytes(), packed] {
            let (columns, _, fault) = all_of(&log, &options);
            prop_assert!(fault.is_none() && columns.iter().eq(events_of(&events, 0.08)));
        }
    }
}
