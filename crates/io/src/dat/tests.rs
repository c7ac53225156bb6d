use evpose_core::{EventStream, SensorSize};
use proptest::prelude::*;

use super::*;
use crate::sample::event;
use crate::{Columns, Decoder, Input, OpenOptions, SensorOrigin, open, read_as};

const SENSOR: SensorSize = SensorSize { width: 640, height: 480 };

fn file(header: &str, kind: u8, records: &[[u32; 2]]) -> Input {
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend([kind, 8]);
    bytes.extend(records.iter().flatten().flat_map(|half| half.to_le_bytes()));
    Input::memory("test.dat", bytes)
}

fn read(input: Input) -> crate::Recording {
    read_as(input, &OpenOptions::default()).unwrap()
}

#[test]
fn every_field_means_what_its_document_says() {
    let records = [[5, 3 | 4 << 14 | 1 << 28], [7, 639 | 479 << 14]];
    let header = "% Data file containing CD events.\n% Date 2020-09-14 14:18:29\n% Version 2\n\
        % Width 640\n% Height 480\n";
    for kind in [EVENT_2D, EVENT_CD] {
        let found = read(file(header, kind, &records));
        assert!(found.stream.iter().eq([event(5, 3, 4, true), event(7, 639, 479, false)]));
        assert_eq!(found.sensor_origin, SensorOrigin::Stated);
        assert_eq!((found.stream.sensor(), found.format), (SENSOR, "dat"));
        assert!(found.remarks.is_empty());
    }
    let found = read(file("% Version 1\n% end\n", EVENT_2D, &[[5, 3 | 4 << 9 | 1 << 17]]));
    assert!(found.stream.iter().eq([event(5, 3, 4, true)]));
    let found = read(file("% Version 2\n", EVENT_2D, &[[5, 3 | 4 << 14 | 15 << 28]]));
    assert!(found.stream.iter().eq([event(5, 3, 4, true)]));
    assert_eq!(found.remarks, ["bits beside the fields of events are set, and passed over"]);
}

#[test]
fn edges_at_trigger_inputs_are_counted() {
    let found = read(file("% Version 2\n", EXT_TRIGGER, &[[5, 1], [9, 6 << 26]]));
    assert_eq!(found.stream.len(), 0);
    assert_eq!(found.remarks, ["2 edges of trigger inputs are no events: they are left out"]);
}

#[test]
fn other_events_are_refused_with_their_type() {
    let input = file("% Data file containing flow.\n% Version 2\n", 40, &[[0, 0]]);
    let refused = read_as(input, &OpenOptions::default()).unwrap_err();
    assert!(refused.to_string().contains("byte 41: events of type 40 and 8 bytes"), "{refused}");
}

#[test]
fn what_records_cannot_hold_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("events.dat");
    for times in [vec![-1], vec![1 << 32], vec![0, 1 << 32], vec![1 << 31, 4 << 31]] {
        let events = times.iter().map(|&t| event(t, 1, 1, true));
        let stream = EventStream::from_events(SENSOR, events).unwrap();
        let refused = FORMAT.write(&path, &stream).unwrap_err().to_string();
        assert!(refused.contains(&format!("event at {} µs", times[times.len() - 1])), "{refused}");
    }
    let sensor = SensorSize { width: 16385, height: 1 };
    assert!(FORMAT.write(&path, &EventStream::empty(sensor)).is_err());
    assert!(!path.exists());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_stream_survives_the_file(
        start in 0_i64..3 << 30,
        steps in prop::collection::vec((prop_oneof![0_i64..50, 0_i64..1 << 30], 0_u16..640, 0_u16..480), 0..60),
    ) {
        let mut t = start;
        let events = steps.iter().map(|&(step, x, y)| {
            t += step;
            event(t, x, y, (x ^ y) & 1 == 1)
        });
        let stream = EventStream::from_events(SENSOR, events).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("events.dat");
        FORMAT.write(&path, &stream).unwrap();
        let back = open(&path).unwrap();
        prop_assert_eq!((back.format, back.stream), ("dat", stream));
        prop_assert!(back.remarks.is_empty());
    }

    #[test]
    fn random_bytes_never_panic(
        kind in any::<u8>(), bytes in prop::collection::vec(any::<u8>(), 0..200)
    ) {
        for header in ["% Version 2\n", "% Version 0\n", "% Data file containing CD events\n"] {
            let _ = read_as(
                Input::memory("x", [header.as_bytes(), &[kind, 8], &bytes].concat()),
                &OpenOptions::default(),
            );
        }
        let mut decoder = DatDecoder::new(12, 8, None).unwrap();
        let took = decoder.decode(&bytes, true, &mut Columns::new());
        prop_assert_eq!(took, Ok(bytes.len() / 8 * 8));
    }
}
