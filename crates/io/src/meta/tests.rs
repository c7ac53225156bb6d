use std::fs::{self, File};

use evpose_pose::HandParams;
use proptest::prelude::*;

use super::fault::MAX_VALUES;
use super::*;
use crate::IoError;
use crate::sample::file;

fn written(records: &[[f64; 12]]) -> Vec<u8> {
    let (_directory, path) = file("hand.meta", []);
    let mut writer = MetaWriter::create_for_hands(&path).unwrap();
    for record in records {
        writer.record(record).unwrap();
    }
    writer.finish().unwrap();
    fs::read(path).unwrap()
}

/// Written out by hand from the description of the format.
#[test]
fn a_file_has_the_published_bytes() {
    let (_directory, path) = file("hand.meta", []);
    let mut writer = MetaWriter::create(&path, 2).unwrap();
    writer.record(&[1.0, -2.0]).unwrap();
    writer.finish().unwrap();
    let want = [2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0xc0, 0x04, 0x0d];
    assert_eq!(fs::read(path).unwrap(), want);
}

#[test]
fn a_hand_comes_back() {
    let hand = HandParams::from_array(std::array::from_fn(|i| i as f32 * 0.25));
    let (_directory, path) = file("hand.meta", written(&[[0.0; 12], hand.to_f64(), [0.0; 12]]));
    let reader = MetaReader::open(&path).unwrap();
    assert_eq!((reader.values(), reader.records()), (12, 3));
    assert_eq!(reader.read_hand(1).unwrap(), hand);
    assert!(matches!(reader.read_hand(3), Err(IoError::NoSuchFrames { available: 3, .. })));
    let mut values = Vec::new();
    reader.read_record(1, &mut values).unwrap();
    assert_eq!(values, hand.to_f64());
}

#[test]
fn wrong_magic_bytes_are_named_with_their_place() {
    let mut bytes = written(&[[0.0; 12]; 3]);
    bytes[4 + 98 + 97] = 9;
    let (_directory, path) = file("hand.meta", &bytes);
    let error = MetaReader::open(&path).unwrap().read_hands(0..3).unwrap_err().to_string();
    let want = "byte 198: a record ends with 4, 9 instead of 4, 13 (1 records readable before it)";
    assert_eq!(error, format!("{}: {want}", path.display()));
}

#[test]
fn a_label_that_is_not_a_number_is_refused() {
    let mut record = [0.0; 12];
    record[7] = f64::NAN;
    let (_directory, path) = file("hand.meta", written(&[[0.0; 12], record]));
    let error = MetaReader::open(&path).unwrap().read_hand(1).unwrap_err();
    assert!(
        matches!(error, IoError::Meta { byte: 158, fault: MetaFault::NotFinite { value: 7 }, .. }),
        "{error}"
    );
}

#[test]
fn a_count_no_label_has_is_refused_before_anything_is_allocated() {
    for count in [0, -1, i32::MAX, i32::MIN, (MAX_VALUES + 1) as i32] {
        let (_directory, path) = file("hand.meta", [&count.to_le_bytes()[..], &[0; 100]].concat());
        let error = MetaReader::open(&path).unwrap_err();
        let named = matches!(error, IoError::Meta { byte: 0, fault: MetaFault::Count(n), .. } if n == count);
        assert!(named, "{error}");
    }
}

#[test]
fn records_that_are_no_hands_are_not_read_as_hands() {
    let (_directory, path) = file("hand.meta", []);
    let mut writer = MetaWriter::create(&path, 3).unwrap();
    writer.record(&[1.0, 2.0, 3.0]).unwrap();
    assert!(matches!(writer.record(&[1.0]), Err(IoError::Unwritable { .. })));
    writer.finish().unwrap();
    let error = MetaReader::open(&path).unwrap().read_hand(0).unwrap_err();
    assert!(matches!(error, IoError::Meta { fault: MetaFault::NotAHand { values: 3 }, .. }));
}

#[test]
fn a_file_cut_at_any_byte_gives_an_error_or_the_exact_prefix() {
    let records: [[f64; 12]; 3] =
        std::array::from_fn(|k| std::array::from_fn(|i| (12 * k + i) as f64));
    let bytes = written(&records);
    let (_directory, path) = file("hand.meta", &bytes);
    for cut in (0..=bytes.len()).rev() {
        File::options().write(true).open(&path).unwrap().set_len(cut as u64).unwrap();
        let Ok((reader, fault)) = MetaReader::open_prefix(&path) else {
            assert!(cut < 4);
            continue;
        };
        let whole = (cut - 4) / 98;
        assert_eq!(fault.is_some(), (cut - 4) % 98 != 0);
        assert_eq!(reader.records(), whole as u64);
        assert_eq!(reader.read_hands(0..whole as u64).unwrap(), records[..whole]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let (_directory, path) = file("hand.meta", &bytes);
        if let Ok((reader, _)) = MetaReader::open_prefix(&path) {
            let _ = reader.read_hands(0..reader.records());
            let _ = reader.read_record(0, &mut Vec::new());
        }
    }
}
