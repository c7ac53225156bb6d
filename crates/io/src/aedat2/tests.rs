use std::fs;

use evpose_core::{Micros, SensorSize};
use proptest::prelude::*;

use super::*;
use crate::golden::check;
use crate::sample::{event, read_all};
use crate::{Columns, SensorOrigin, read_as};

/// A file as jAER writes it.
fn file(version: &str, chip: &str, records: &[(u32, u32)]) -> Vec<u8> {
    let mut bytes = format!("#!AER-DAT{version}\r\n# This is a raw AE data file - do not edit\r\n");
    if !chip.is_empty() {
        bytes += &format!("# AEChip: eu.seebetter.ini.chips.{chip}\r\n");
    }
    bytes += "# Creation date: Fri Sep 22 14:06:27 AEST 2023\r\n#End Of ASCII Header\r\n";
    let mut bytes = bytes.into_bytes();
    for (address, t) in records {
        let skipped = if version.starts_with('1') { 2 } else { 0 };
        bytes.extend_from_slice(&address.to_be_bytes()[skipped..]);
        bytes.extend_from_slice(&t.to_be_bytes());
    }
    bytes
}

/// An address of a DAVIS.
fn davis(x: u32, y: u32, on: u32, camera: u32) -> u32 {
    y << 22 | x << 12 | on << 11 | camera
}

const SPECIAL: u32 = 1 << 10;
const FRAME: u32 = 1 << 31;
const MOTION: u32 = 1 << 31 | 3 << 10;
const DHP19: &str = "davis.MultiDAVIS346BCameraChip";

fn source_of(bytes: &[u8], options: &OpenOptions) -> Box<dyn EventSource> {
    open(Input::memory("file.aedat", bytes.to_vec()), options).unwrap()
}

/// All events, remarks, and the fault that ended it.
fn all_of(bytes: &[u8], options: &OpenOptions) -> (Columns, Vec<String>, Option<IoError>) {
    read_all(&mut *source_of(bytes, options))
}

#[test]
fn events_of_a_davis_are_turned_the_right_way_round_and_the_rest_is_counted() {
    let records = [
        (davis(0, 0, 1, 0), 5),
        (SPECIAL | 3, 6),
        (davis(345, 259, 0, 0), 7),
        (FRAME | davis(3, 3, 0, 77), 7),
        (MOTION, 7),
        (davis(346, 0, 1, 0), 9),
    ];
    let bytes = file("2.0", "davis.Davis346red", &records);
    let (columns, remarks, fault) = all_of(&bytes, &OpenOptions::default());
    let want = [event(5, 345, 259, true), event(7, 0, 0, false), event(9, u16::MAX, 259, true)];
    assert!(fault.is_none() && columns.iter().eq(want), "{columns:?}");
    assert_eq!(
        remarks,
        [
            "1 special events (external pins) are passed over",
            "1 readings of frames are passed over",
            "1 readings of the motion sensor are passed over",
        ]
    );
    let recording = read_as(Input::memory("x", bytes), &OpenOptions::default()).unwrap();
    assert_eq!((recording.format, recording.outside), ("aedat2", 1));
    assert_eq!(recording.stream.sensor(), SensorSize { width: 346, height: 260 });
    assert_eq!(recording.sensor_origin, SensorOrigin::Stated);
}

#[test]
fn one_of_four_cameras_is_read_and_the_others_are_counted() {
    let records: Vec<_> = (0..40).map(|k| (davis(k, 2 * k, k % 2, 1 + k % 3), 10 * k)).collect();
    let bytes = file("2.0", DHP19, &records);
    for camera in [None, Some(1), Some(2), Some(3), Some(0)] {
        let (columns, remarks, _) =
            all_of(&bytes, &OpenOptions { camera, ..OpenOptions::default() });
        // Camera 0 has no events: 1 is the first.
        let number = u32::from(camera.unwrap_or(1));
        let of_camera = (0..40_u32).filter(|k| 1 + k % 3 == number);
        let want = of_camera
            .map(|k| event(10 * i64::from(k), 345 - k as u16, 259 - 2 * k as u16, k % 2 == 1));
        assert!(columns.iter().eq(want), "{camera:?}");
        assert_eq!(remarks.len(), if number == 0 { 3 } else { 2 }, "{remarks:?}");
    }
    let (_, remarks, _) = all_of(&bytes, &OpenOptions::default());
    assert_eq!(remarks[0], "13 events of camera 2 are passed over");
    let facts = source_of(&bytes, &OpenOptions::default()).header().facts.clone();
    assert!(facts.contains(&("camera", "1".to_owned())), "{facts:?}");
}

#[test]
fn the_pulses_that_bound_a_movement_are_listed_on_the_clock_of_the_events() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("mov1.aedat");
    let records = [
        (davis(1, 1, 1, 0), u32::MAX - 2),
        (SPECIAL | 1, u32::MAX - 1),
        (davis(1, 1, 1, 3), 4),
        (SPECIAL | 2, 9),
    ];
    let bytes = file("2.0", DHP19, &records);
    fs::write(&path, &bytes).unwrap();
    let found = special_events(&path, &OpenOptions::default()).unwrap();
    let range = 1 << 32;
    let want = [(range - 2, SPECIAL | 1), (range + 9, SPECIAL | 2)];
    assert_eq!(found, want.map(|(t, address)| SpecialEvent { t: Micros(t), address }));
    let camera = Some(3);
    let (columns, ..) = all_of(&bytes, &OpenOptions { camera, ..OpenOptions::default() });
    assert_eq!(columns.t, [Micros(range + 4)]);

    fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    let fault = special_events(&path, &OpenOptions::default()).unwrap_err();
    let byte = bytes.len() as u64 - 8;
    assert!(matches!(fault, IoError::Damaged { byte: at, events: 1, .. } if at == byte), "{fault}");
    fs::write(&path, "1 2 3 1\n").unwrap();
    let fault = special_events(&path, &OpenOptions::default()).unwrap_err();
    assert!(matches!(fault, IoError::UnknownFormat { .. }));
}

#[test]
fn a_dvs128_has_addresses_of_its_own_in_both_versions() {
    let records = [(0x0000, 10), (0x7fff, 20), (0x8000, 21), (1 << 8 | 2 << 1, 30)];
    let want = [event(10, 127, 127, true), event(20, 0, 0, false), event(30, 125, 126, true)];
    for version in ["1.0", "2.0"] {
        let bytes = file(version, "retina.DVS128", &records);
        let (columns, remarks, fault) = all_of(&bytes, &OpenOptions::default());
        assert!(fault.is_none() && columns.iter().eq(want), "{version}: {columns:?}");
        assert_eq!(remarks, ["1 special events (external pins) are passed over"]);
    }
}

#[test]
fn a_chip_that_is_not_stated_is_detected_by_its_addresses_or_the_callers_sensor() {
    let size = |width, height| SensorSize { width, height };
    let cases = [
        (1 << 8 | 2 << 1, size(128, 128)),
        (479 << 11 | 639 << 1 | 1, size(640, 480)),
        (davis(239, 179, 1, 0), size(240, 180)),
        (davis(240, 179, 1, 0), size(346, 260)),
    ];
    for (address, sensor) in cases {
        let bytes = file("2.0", "", &[(address, 1)]);
        let recording = read_as(Input::memory("x", bytes), &OpenOptions::default()).unwrap();
        assert_eq!((recording.stream.sensor(), recording.stream.len()), (sensor, 1));
        assert_eq!(recording.sensor_origin, SensorOrigin::Assumed);
    }
    let sensor = Some(size(400, 300));
    let options = OpenOptions { sensor, ..OpenOptions::default() };
    let recorded = file("2.0", "davis.Davis400", &[(davis(399, 0, 1, 0), 1)]);
    let recording = read_as(Input::memory("x", recorded.clone()), &options).unwrap();
    assert!(recording.stream.iter().eq([event(1, 0, 299, true)]));
    assert_eq!(recording.sensor_origin, SensorOrigin::Given);
    let fault = read_as(Input::memory("x", recorded), &OpenOptions::default()).unwrap_err();
    assert!(fault.to_string().contains("the sensor of the chip Davis400 is not known"), "{fault}");
}

#[test]
fn a_record_that_begins_as_a_line_of_the_header_is_a_record() {
    // The byte of `#` in a row of 140, and the byte that ends a line in the time.
    let address = davis(7, 140, 1, 0);
    assert_eq!(address.to_be_bytes()[0], b'#');
    let bytes = file("2.0", "davis.Davis346B", &[(address, 10), (davis(8, 9, 0, 0), 11)]);
    let end = b"#End Of ASCII Header\r\n";
    let at = bytes.windows(end.len()).position(|window| window == end).unwrap();
    let without_end = [&bytes[..at], &bytes[at + end.len()..]].concat();
    for bytes in [bytes, without_end] {
        let (columns, ..) = all_of(&bytes, &OpenOptions::default());
        assert!(columns.iter().eq([event(10, 338, 119, true), event(11, 337, 250, false)]));
    }
}

#[test]
fn earlier_stamps_are_passed_on_and_wrapped_ones_unwrapped() {
    let a = davis(1, 1, 1, 0);
    let bytes = file("2.0", "davis.Davis240C", &[(a, 100), (a, 90), (a, 4_294_967_290), (a, 3)]);
    // A stamp before the first is a little earlier, not almost a whole period later.
    let (columns, ..) = all_of(&bytes, &OpenOptions::default());
    assert_eq!(columns.t, [100, 90, -6, 3].map(Micros));
}

/// See `tests/golden/aedat2`.
#[test]
fn files_of_v2e_hold_the_events_that_it_was_given() {
    let files = ["davis346.aedat", "davis240.aedat", "dvs640.aedat"];
    check("aedat2", &files.map(|name| (name, "aedat2")));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_events_of_any_camera_are_read_back(
        events in prop::collection::vec((0..346_u32, 0..260_u32, 0..2_u32, 0..4_u32, 0..i32::MAX), 0..60),
        start in any::<u32>(),
    ) {
        let mut t = start;
        let mut unwrapped = i64::from(start);
        let (mut records, mut want) = (Vec::new(), Vec::new());
        for (k, &(x, y, on, camera, step)) in events.iter().enumerate() {
            let step = if k == 0 { 0 } else { step };
            t = t.wrapping_add(step as u32);
            unwrapped += i64::from(step);
            records.push((davis(x, y, on, camera), t));
            if camera == 2 {
                want.push(event(unwrapped, 345 - x as u16, 259 - y as u16, on == 1));
            }
        }
        let options = OpenOptions { camera: Some(2), ..OpenOptions::default() };
        let (columns, ..) = all_of(&file("2.0", DHP19, &records), &options);
        prop_assert!(columns.iter().eq(want));
    }

    #[test]
    fn changed_bytes_never_panic(
        changes in prop::collection::vec(any::<(usize, u8)>(), 1..20), cut in any::<usize>(),
    ) {
        let records: Vec<_> = (0..30).map(|k| (davis(k, k, k % 2, k % 4), 10 * k)).collect();
        let mut bytes = file("2.0", DHP19, &records);
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        bytes.truncate(cut % (bytes.len() + 1));
        let _ = read_as(Input::memory("x", bytes.clone()), &OpenOptions::default());
        let _ = special::read(Input::memory("x", bytes), &OpenOptions::default());
    }
}
