use std::fs;

use evpose_core::EventStream;
use proptest::prelude::*;

use super::*;
use crate::golden::check;
use crate::sample::event;
use crate::{SensorOrigin, read_as};

fn record(t: u32, x: u8, y: u8, on: bool) -> [u8; RECORD] {
    let [_, high, middle, low] = t.to_be_bytes();
    [x, y, high & 0x7f | u8::from(on) << 7, middle, low]
}

/// A saccade over part of the sensor.
fn sample() -> Vec<[u8; RECORD]> {
    (0..40_u32)
        .map(|k| record(700 + 37 * k, (k % 34) as u8, (7 * k % 34) as u8, k % 3 == 0))
        .collect()
}

fn all_of(bytes: Vec<u8>) -> (Columns, Vec<String>) {
    let mut source = open(Input::memory("sample.bin", bytes), &OpenOptions::default()).unwrap();
    let mut columns = Columns::new();
    source.next(&mut columns).unwrap();
    (columns, source.remarks())
}

#[test]
fn records_are_read_as_published() {
    // The first records of a file of N-MNIST.
    let bytes = [[7, 15, 0x80, 0x02, 0x8e], [19, 18, 0x00, 0x0b, 0xb7], [21, 17, 0x7f, 0xff, 0xff]];
    let (columns, remarks) = all_of(bytes.concat());
    let want =
        [event(654, 7, 15, true), event(2999, 19, 18, false), event(8_388_607, 21, 17, false)];
    assert!(columns.iter().eq(want));
    assert!(remarks.is_empty());
}

#[test]
fn a_recording_is_recognised_and_its_sensor_assumed() {
    let recording =
        read_as(Input::memory("sample", sample().concat()), &OpenOptions::default()).unwrap();
    assert_eq!((recording.format, recording.stream.len()), ("nmnist", 40));
    assert_eq!(recording.stream.sensor(), USUAL);
    assert_eq!(recording.sensor_origin, SensorOrigin::Assumed);
}

#[test]
fn what_is_not_in_order_of_time_or_does_not_move_is_not_recognised() {
    let records = sample();
    assert!(probe(&records.concat()));
    assert!(!probe(&records[..MIN_RECORDS - 1].concat()));
    assert!(!probe(&[records.concat(), vec![1]].concat()));
    let mut swapped = records;
    swapped.swap(3, 4);
    assert!(!probe(&swapped.concat()));
    assert!(!probe(&[0; 400]) && !probe(&[1, 2, 3, 4, 5].repeat(20)));
    let still: Vec<_> = (0..40).map(|k| record(k, 5, 5, true)).collect();
    assert!(!probe(&still.concat()));
}

#[test]
fn marks_put_later_times_on_and_times_wrap_around() {
    let mark = [3, OVERFLOW_ROW, 0, 0, 12];
    let bytes = [
        record(10, 1, 1, true),
        mark,
        record(12, 2, 2, true),
        record(8_388_600, 3, 3, true),
        record(4, 4, 4, false),
    ]
    .concat();
    let (columns, remarks) = all_of(bytes);
    let times: Vec<_> = columns.t.iter().map(|t| t.0).collect();
    assert_eq!(times, [10, 8204, 8_396_792, 8_396_804]);
    assert_eq!(remarks.len(), 2);
    assert!(remarks[0].starts_with("1 records of row 240"), "{remarks:?}");
}

#[test]
fn what_the_format_cannot_hold_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("sample.bin");
    let write = |width, height, t| {
        let sensor = SensorSize { width, height };
        let events = EventStream::from_events(sensor, [event(t, 0, 0, true)]).unwrap();
        FORMAT.write(&path, &events).map_err(|fault| fault.to_string())
    };
    assert!(write(257, 34, 0).unwrap_err().contains("256 columns and 240 rows"));
    assert!(write(34, 241, 0).unwrap_err().contains("256 columns and 240 rows"));
    assert!(write(34, 34, -1).unwrap_err().contains("an event is at -1 µs"));
    assert!(write(34, 34, 1 << 23).unwrap_err().contains("an event is at 8388608 µs"));
    assert!(!path.exists());
    write(256, 240, (1 << 23) - 1).unwrap();
}

/// See `tests/golden/nmnist`.
#[test]
fn a_file_that_numpy_wrote_is_read_as_tonic_reads_it() {
    check("nmnist", &[("synthetic.bin", "nmnist")]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_stream_survives_the_file(
        mut events in prop::collection::vec((0..1_i64 << 23, 0..=255_u16, 0..240_u16, any::<bool>()), 0..60),
    ) {
        // Later times that differ by more than half the range come one after another.
        events.sort_unstable();
        let sensor = SensorSize { width: 256, height: 240 };
        let events = events.into_iter().map(|(t, x, y, on)| event(t, x, y, on));
        let stream = EventStream::from_events(sensor, events)?;
        let directory = tempfile::tempdir()?;
        let path = directory.path().join("sample.bin");
        FORMAT.write(&path, &stream).unwrap();
        let (columns, _) = all_of(fs::read(&path)?);
        prop_assert!(columns.iter().eq(stream.iter()));
    }
}
