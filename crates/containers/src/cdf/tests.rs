//! Comparison with files of another program; see `tests/golden/cdf`.

use std::fs;
use std::path::Path;

use proptest::prelude::*;

use super::*;

fn golden(name: &str) -> Vec<u8> {
    fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/cdf").join(name)).unwrap()
}

fn values(file: &str, variable: &str) -> CdfArray {
    CdfFile::parse(golden(file)).unwrap().values(variable).unwrap()
}

fn poses() -> Vec<f64> {
    (0..7).flat_map(|i| (0..64).map(move |j| f64::from(100 * i + j) + 0.25)).collect()
}

#[test]
fn poses_are_read_from_every_layout() {
    for (file, records, sizes) in [
        ("one_record.cdf", 1, vec![7, 64]),
        ("records.cdf", 7, vec![64]),
        ("whole.cdf", 7, vec![64]),
    ] {
        let array = values(file, "Pose");
        assert_eq!((array.records, array.sizes), (records, sizes), "{file}");
        assert_eq!(array.values, poses(), "{file}");
    }
}

#[test]
fn values_of_other_types_and_dimensions_are_read() {
    let frame = values("records.cdf", "Frame");
    assert_eq!((frame.records, frame.sizes), (7, vec![]));
    assert_eq!(frame.values, [0.0, -3.0, -6.0, -9.0, -12.0, -15.0, -18.0]);
    for (file, sizes, count) in [("records.cdf", vec![2, 3], 12), ("cube.cdf", vec![2, 3, 4], 48)] {
        let cube = values(file, "Cube");
        assert_eq!((cube.records, cube.sizes), (2, sizes), "{file}");
        assert_eq!(cube.values, (0..count).map(f64::from).collect::<Vec<_>>(), "{file}");
    }
}

#[test]
fn errors_name_missing_and_unsupported_variables() {
    let file = CdfFile::parse(golden("records.cdf")).unwrap();
    assert_eq!(file.names().collect::<Vec<_>>(), ["Frame", "Pose", "Cube", "When"]);
    let failed = file.values("Poses").unwrap_err().to_string();
    assert!(failed.contains("`Poses`") && failed.contains("`Frame`, `Pose`"), "{failed}");
    let failed = file.values("When").unwrap_err();
    assert!(matches!(&failed, CdfError::Unsupported { what, .. } if what == "times"), "{failed}");

    let mut bytes = golden("records.cdf");
    assert_eq!(CdfFile::parse(b"{}".to_vec()).unwrap_err(), CdfError::NotCdf);
    bytes[..4].copy_from_slice(&[0xcd, 0xf2, 0x60, 0x02]);
    assert_eq!(CdfFile::parse(bytes.clone()).unwrap_err(), CdfError::Version2);
    bytes[..4].copy_from_slice(&[0xcd, 0xf3, 0x00, 0x01]);
    // The machine: a VAX.
    bytes[39] = 3;
    let failed = CdfFile::parse(bytes).unwrap_err();
    assert!(matches!(failed, CdfError::Unsupported { byte: 36, .. }), "{failed}");
}

#[test]
fn a_file_cut_at_any_byte_gives_an_error_or_all_of_it() {
    for name in ["one_record.cdf", "records.cdf", "whole.cdf"] {
        let bytes = golden(name);
        for cut in 0..bytes.len() {
            let result = CdfFile::parse(bytes[..cut].to_vec()).and_then(|file| file.values("Pose"));
            assert!(result.is_err() || result.unwrap().values == poses(), "{name} {cut}");
        }
    }
}

/// Offset of the descriptor of the variable `Pose` in `records.cdf`.
fn pose_record(bytes: &[u8]) -> usize {
    bytes.windows(6).position(|part| part == b"Pose\0\0").unwrap() - 84
}

#[test]
fn missing_records_are_reported() {
    let bytes = golden("records.cdf");
    let at = pose_record(&bytes);
    for (from, value, part) in [
        // Nine records, an index outside the file, dimensions of gigabytes, as many dimensions, a
        // loop.
        (at + 27, [8].as_slice(), "record 7 of the 9"),
        (at + 28, &[0x7f], "record is expected here"),
        (at + 344, &[0x7f], "more than"),
        (at + 340, &[0x7f], "dimensions"),
        (at + 12, &(at as u64).to_be_bytes(), "more variables"),
    ] {
        let mut bytes = bytes.clone();
        bytes[from..from + value.len()].copy_from_slice(value);
        let failed = CdfFile::parse(bytes).and_then(|file| file.values("Pose")).unwrap_err();
        assert!(failed.to_string().contains(part), "{part}: {failed}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn changed_bytes_never_panic(
        changes in prop::collection::vec(any::<(usize, u8)>(), 1..8), which in 0..4_usize,
    ) {
        let name = ["one_record.cdf", "records.cdf", "whole.cdf", "cube.cdf"][which];
        let mut bytes = golden(name);
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        if let Ok(file) = CdfFile::parse(bytes) {
            let names: Vec<String> = file.names().map(str::to_owned).collect();
            for name in names {
                if let Ok(array) = file.values(&name) {
                    let values_per_record: usize = array.sizes.iter().product();
                    prop_assert_eq!(array.values.len(), array.records * values_per_record);
                }
            }
        }
    }
}
