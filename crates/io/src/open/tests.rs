use std::fs;

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use proptest::prelude::*;

use super::*;
use crate::{EvcWriter, MetaWriter};

/// Whole milliseconds and raster order, so that every format keeps all of it, up to the last pixel,
/// so that none takes the sensor to be smaller.
fn recording(sensor: SensorSize) -> EventStream {
    let events = (0..30).map(|k| Event {
        t: Micros(1000 * (3 + k / 2)),
        x: if k != 28 { (k % 2) as u16 } else { sensor.width - 1 },
        y: if k != 28 { 5 } else { sensor.height - 1 },
        polarity: Polarity::from_on(k % 3 > 0),
    });
    EventStream::from_events(sensor, events).unwrap()
}

#[test]
fn every_format_is_recognised_by_its_content_and_described_whatever_its_name() {
    let stream = recording(SensorSize::DAVIS240C);
    let directory = tempfile::tempdir().unwrap();
    for format in FORMATS.iter().filter(|format| format.create.is_some()) {
        let path = directory.path().join("recording.dat");
        format.write(&path, &stream).unwrap();
        let back = open(&path).unwrap();
        assert_eq!((back.format, back.stream), (format.name, stream.clone()));
        assert_eq!(back.outside, 0);
        let info = info(&path, &OpenOptions::default()).unwrap();
        assert_eq!((info.format, info.sensor), (format.name, SensorSize::DAVIS240C));
        assert_eq!((info.events, info.on_events), (30, 20));
        assert_eq!(info.span, Some((Micros(3_000), Micros(17_000))));
        assert!(info.labels.is_none());
        let head = fs::read(&path).unwrap();
        assert_eq!(FORMATS.iter().filter(|f| (f.probe)(&head)).count(), 1, "{}", format.name);
        assert_eq!(FORMATS.find(format.name).map(|f| f.name), Some(format.name));
    }
}

#[test]
fn a_description_mentions_labels_and_what_is_odd() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("hand.evc");
    let mut writer = EvcWriter::create(&path, SensorSize { width: 300, height: 200 }).unwrap();
    writer.stream(&recording(SensorSize::DAVIS240C), Micros(0)).unwrap();
    writer.frame_of([(290, 190, Polarity::On), (0, 0, Polarity::Off)]).unwrap();
    writer.finish().unwrap();
    let mut labels = MetaWriter::create_for_hands(path.with_extension("meta")).unwrap();
    labels.record(&[0.0; 12]).unwrap();
    labels.finish().unwrap();
    let text = info(&path, &OpenOptions::default()).unwrap().to_string();
    let folder = format!("{}/", directory.path().display());
    assert_eq!(
        text.replace(&folder, ""),
        "hand.evc\n\
         \x20 format    evc\n\
         \x20 sensor    291x191 (inferred from the events)\n\
         \x20 duration  0.019000 s\n\
         \x20 events    32, 65.6 % ON, 34.4 % OFF\n\
         \x20 rate      1.7 thousand events per second\n\
         \x20 events at 0.003000 s to 0.018000 s\n\
         \x20 labels    1 of 12 values in hand.meta\n\
         \x20 warning   events lie outside 240x180: the sensor is taken to be the smallest that holds them\n\
         \x20 warning   1 labels for 19 frames: one of the files is cut\n"
    );
}

#[test]
fn a_file_of_no_known_format_is_refused_with_the_formats_there_are() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("image.png");
    for content in [&b"hello\n"[..], b"\x0c\0\0\0"] {
        fs::write(&path, content).unwrap();
        let message = open(&path).unwrap_err().to_string();
        assert!(
            message.contains("the content is of no known format (npz, npy, evc, "),
            "{message}"
        );
    }
    assert!(matches!(open(directory.path().join("none")), Err(IoError::File { .. })));
    assert!(matches!(open(directory.path()), Err(IoError::File { .. })));
}

#[test]
fn times_at_the_ends_of_the_range_are_refused_and_near_them_described_without_a_panic() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("recording");
    let describe = |before_end: i64| {
        let ends = [i64::MIN + before_end, i64::MAX - before_end];
        fs::write(&path, ends.map(|t| format!("{t} 1 2 1\n")).concat()).unwrap();
        info(&path, &OpenOptions::default())
    };
    assert!(describe(0).unwrap_err().to_string().contains("no clock reaches"));
    assert_eq!(describe(2_000_000_000_000).unwrap().duration, Micros(i64::MAX));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_bytes_behind_any_beginning_never_panic(
        beginning in prop::sample::select(vec![&b"PK\x03\x04"[..], b"\0\0\0\xff", b"1 2 3 1\n", b""]),
        bytes in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("recording");
        fs::write(&path, [beginning, &bytes].concat()).unwrap();
        let _ = open(&path);
        let _ = info(&path, &OpenOptions::default());
    }
}
