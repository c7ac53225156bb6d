//! MAT-files of SciPy, and damaged files.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::io::Read as _;

use evpose_containers::mat::{MatClass, MatError, MatFile, MatValue};
use proptest::prelude::*;

const KINDS: &[u8] = include_bytes!("golden/mat/kinds.mat");
const COMPRESSED: &[u8] = include_bytes!("golden/mat/kinds_compressed.mat");
const BIG_ENDIAN: &[u8] = include_bytes!("golden/mat/big_endian.mat");

fn both(check: impl Fn(&MatFile)) {
    for bytes in [KINDS, COMPRESSED] {
        check(&MatFile::parse(bytes).unwrap());
    }
}

#[test]
fn values_of_all_classes_are_those_that_scipy_wrote() {
    both(|file| {
        let integers = |name: &str| file.variable(name).unwrap().integers().unwrap();
        let column_by_column = |min: i64, max: i64| vec![min, 3, 1, 4, 2, max];
        assert_eq!(integers("int8"), column_by_column(i8::MIN.into(), i8::MAX.into()));
        assert_eq!(integers("uint8"), column_by_column(0, u8::MAX.into()));
        assert_eq!(integers("int16"), column_by_column(i16::MIN.into(), i16::MAX.into()));
        assert_eq!(integers("uint16"), column_by_column(0, u16::MAX.into()));
        assert_eq!(integers("int32"), column_by_column(i32::MIN.into(), i32::MAX.into()));
        assert_eq!(integers("uint32"), column_by_column(0, u32::MAX.into()));
        assert_eq!(integers("int64"), column_by_column(i64::MIN, i64::MAX));
        let wide = file.variable("uint64").unwrap();
        assert_eq!(wide.index(5).unwrap().scalar().unwrap(), u64::MAX as f64);
        let message = wide.integers().unwrap_err().to_string();
        assert_eq!(message, "uint64: expected integers, found an array of uint64 of 2×3");
        let values = |name: &str| file.variable(name).unwrap().values().unwrap();
        assert_eq!(values("single"), [f64::from(0.1_f32), f64::NEG_INFINITY]);
        assert_eq!(values("double"), [1.5, 2.5, std::f64::consts::PI]);
        assert_eq!(values("yes"), [1.0, 0.0, 1.0]);
        assert!(file.variable("yes").unwrap().is_logical());
        assert_eq!(file.variable("double").unwrap().dimensions(), [3, 1]);
        assert!(values("empty").is_empty());
        assert_eq!(file.variable("empty").unwrap().dimensions(), [0, 3]);
        let cube = file.variable("cube").unwrap();
        assert_eq!(cube.dimensions(), [2, 3, 4]);
        // Row-major in NumPy: element (1, 2, 3) is the last, (1, 0, 0) the second.
        assert_eq!((values("cube")[23], values("cube")[1]), (23.0, 12.0));
    });
}

#[test]
fn text_is_that_of_scipy() {
    both(|file| {
        let text = |name: &str| file.variable(name).unwrap().text();
        assert_eq!(text("ascii").unwrap(), "image.jpg");
        assert_eq!(text("unicode").unwrap(), "Grüße 猫 🐈");
        assert_eq!(text("nothing").unwrap(), "");
        let message = text("two_lines").unwrap_err().to_string();
        assert_eq!(message, "two_lines: expected one line of text, found text of 2×2");
        assert!(text("double").is_err());
        assert!(file.variable("ascii").unwrap().values().is_err());
    });
}

#[test]
fn structures_and_cells_hold_what_scipy_put_into_them() {
    both(|file| {
        let points = file.variable("points").unwrap();
        let point = points.field("point").unwrap();
        assert_eq!((point.len(), point.field_names().len()), (2, 3));
        let [first, second] = [0, 1].map(|i| point.index(i).unwrap());
        assert_eq!(first.field("y").unwrap().scalar().unwrap(), 2.0);
        assert_eq!(first.field("note").unwrap().text().unwrap(), "first");
        assert_eq!(second.field("x").unwrap().scalar().unwrap(), 3.0);
        assert!(second.filled_field("y").unwrap().is_none());
        assert!(second.filled_field("z").unwrap().is_none());
        let deepest = points.field("deep").unwrap().field("deeper").unwrap();
        assert_eq!(deepest.field("deepest").unwrap().integer().unwrap(), 42);
        let cell = file.variable("cell").unwrap();
        assert_eq!(cell.index(0).unwrap().scalar().unwrap(), 7.0);
        assert_eq!(cell.index(1).unwrap().text().unwrap(), "seven");
        let kinds: Vec<_> = cell.elements().unwrap().map(|value| value.class()).collect();
        assert_eq!(kinds, [MatClass::F64, MatClass::Char, MatClass::Cell]);
        assert!(file.variable("no_points").unwrap().is_empty());
        assert_eq!(file.variable("no_points").unwrap().field_names(), ["x"]);
    });
}

#[test]
fn errors_say_where_in_the_words_of_matlab() {
    both(|file| {
        let message = |result: Result<MatValue<'_>, MatError>| result.unwrap_err().to_string();
        let points = file.variable("points").unwrap();
        let point = points.field("point").unwrap();
        assert_eq!(
            message(point.index(1).unwrap().field("z")),
            "points.point(2) has no field `z`: it has `x`, `y`, `note`"
        );
        assert_eq!(
            message(point.field("x")),
            "points.point: expected one structure, found a structure of 1×2"
        );
        assert_eq!(message(point.index(2)), "points.point has no element 3: it has 2");
        let empty = point.index(1).unwrap().field("y").unwrap();
        assert_eq!(
            empty.scalar().unwrap_err().to_string(),
            "points.point(2).y: expected one real number, found an array of double of 0×0"
        );
        let inner = file.variable("cell").unwrap().index(2).unwrap();
        assert_eq!(inner.index(1).unwrap().path(), "cell{3}{2}");
        let sparse = file.variable("sparse").unwrap();
        assert_eq!((sparse.class(), sparse.path()), (MatClass::Sparse, "sparse".to_owned()));
        assert!(sparse.values().unwrap_err().to_string().contains("is a sparse matrix"));
        assert!(sparse.elements().is_err());
        let complex = file.variable("complex").unwrap().values().unwrap_err().to_string();
        assert!(complex.contains("complex 1×1"), "{complex}");
        assert!(message(file.variable("Points")).contains("`points`"));
    });
}

#[test]
fn big_endian_files_and_narrow_values_are_read() {
    let file = MatFile::parse(BIG_ENDIAN).unwrap();
    let values = |name: &str| file.variable(name).unwrap().values().unwrap();
    assert_eq!(values("narrow"), [1.0, 2.0, 250.0]);
    assert_eq!(file.variable("narrow").unwrap().class(), MatClass::F64);
    assert_eq!(values("signed"), [-300.0, 5.0]);
    assert_eq!(values("real"), [0.1, -1e300]);
    assert_eq!(file.variable("text").unwrap().text().unwrap(), "né");
    let s = file.variable("s").unwrap();
    let [first, second] = [0, 1].map(|i| s.index(i).unwrap());
    assert_eq!(first.field("x").unwrap().integer().unwrap(), 7);
    assert_eq!(first.field("id").unwrap().text().unwrap(), "3");
    assert!(second.field("x").unwrap().is_empty());
    assert_eq!(second.field("id").unwrap().scalar().unwrap(), 2.5);
}

#[test]
fn errors_for_other_versions_explain_how_to_save_the_file() {
    let version_4 = include_bytes!("golden/mat/version4.mat");
    assert_eq!(MatFile::parse(version_4).unwrap_err(), MatError::Version4);
    let mut hdf5 = vec![0; 512];
    hdf5[..19].copy_from_slice(b"MATLAB 7.3 MAT-file");
    hdf5[124..128].copy_from_slice(b"\0\x02IM");
    let error = MatFile::parse(&hdf5).unwrap_err();
    assert_eq!(error, MatError::Version73);
    assert!(error.to_string().contains("-v7"));
    hdf5.extend(b"\x89HDF\r\n\x1a\n");
    hdf5[124..128].fill(0);
    assert_eq!(MatFile::parse(&hdf5).unwrap_err(), MatError::Version73);
    assert_eq!(MatFile::parse(b"%PDF-1.4").unwrap_err(), MatError::NotMat);
    assert_eq!(MatFile::parse(&[0x20; 200]).unwrap_err(), MatError::NotMat);
}

/// A file of these elements, little-endian.
fn file_of(elements: &[u8]) -> Vec<u8> {
    let mut bytes = vec![b' '; 116];
    bytes.extend([0, 0, 0, 0, 0, 0, 0, 0, 0, 1, b'I', b'M']);
    bytes.extend(elements);
    bytes
}

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

fn array(class: u32, sizes: &[i32], body: &[u8]) -> Vec<u8> {
    let flags = [class.to_le_bytes(), [0; 4]].concat();
    let sizes: Vec<u8> = sizes.iter().flat_map(|size| size.to_le_bytes()).collect();
    let parts = [element(6, &flags), element(5, &sizes), element(1, b"v"), body.to_vec()];
    element(14, &parts.concat())
}

#[test]
fn sizes_that_cannot_be_are_refused_before_anything_is_allocated() {
    let refused = |bytes: Vec<u8>, words: &str| {
        let message = MatFile::parse(&file_of(&bytes)).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    };
    let huge = [i32::MAX, i32::MAX];
    refused(array(6, &huge, &element(9, &[0; 8])), "elements are expected, there are 8 bytes");
    refused(array(1, &huge, &[]), "arrays cannot be in 0 bytes");
    refused(array(6, &[i32::MAX; 3], &[]), "more elements than can be counted");
    refused(array(4, &huge, &element(16, b"abcdefgh")), "elements are expected");
    let names = |names: &[u8]| [element(5, &8_i32.to_le_bytes()), element(1, names)].concat();
    refused(array(2, &huge, &names(b"x\0\0\0\0\0\0\0")), "arrays cannot be in 0 bytes");
    refused(array(2, &huge, &names(b"")), "structures without any field");
    refused(array(6, &[-1, 2], &[]), "a size of -1");
    refused(array(6, &[3], &[]), "two or more int32");
    refused(array(40, &[1, 1], &[]), "no array is of class 40");
    refused(array(8, &[1, 1], &element(9, &[0; 8])), "an array of int8 stored as type 9");
    refused([14_u32.to_le_bytes(), u32::MAX.to_le_bytes()].concat(), "of 4294967295 bytes");
    refused(element(9, &[0; 8]), "a variable is expected, this is of type 9");
}

#[test]
fn no_depth_of_nesting_takes_the_stack() {
    let nested = |depth: usize| {
        (0..depth)
            .fold(array(6, &[1, 1], &element(9, &[0; 8])), |inner, _| array(1, &[1, 1], &inner))
    };
    assert!(MatFile::parse(&file_of(&nested(64))).is_ok());
    let error = MatFile::parse(&file_of(&nested(5000))).unwrap_err();
    assert!(matches!(error, MatError::TooDeep { limit: 64, .. }), "{error}");
}

#[test]
fn what_is_compressed_takes_no_more_than_allowed() {
    assert!(MatFile::parse_within(COMPRESSED, 8000).is_ok());
    // A variable of zeros, a thousandth of it in the file.
    let mut bomb = COMPRESSED[..128].to_vec();
    let mut zeros = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::copy(&mut std::io::repeat(0).take(300 << 20), &mut zeros).unwrap();
    let zeros = zeros.finish().unwrap();
    bomb.extend(15_u32.to_le_bytes());
    bomb.extend((zeros.len() as u32).to_le_bytes());
    bomb.extend(zeros);
    let error = MatFile::parse(&bomb).unwrap_err();
    assert!(matches!(error, MatError::TooLarge { limit: 0x1000_0000, .. }), "{error}");
    let error = MatFile::parse_within(COMPRESSED, 400).unwrap_err();
    assert!(matches!(error, MatError::TooLarge { limit: 400, .. }), "{error}");
}

#[test]
fn a_file_that_ends_anywhere_is_an_error_or_has_fewer_variables() {
    for bytes in [KINDS, COMPRESSED, BIG_ENDIAN] {
        let whole = MatFile::parse(bytes).unwrap().names().count();
        let mut between = 0;
        for end in 0..bytes.len() {
            match MatFile::parse(&bytes[..end]) {
                Ok(file) => {
                    assert!(file.names().count() < whole);
                    between += 1;
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
        // Only where a variable ends does a file end: before the first, and behind each but the last.
        assert_eq!(between, whole);
    }
}

/// Calls every accessor of a value and of all nested ones.
fn access_all(value: MatValue<'_>) {
    let _ = (value.path(), value.values(), value.integers(), value.text(), value.scalar());
    if let (MatClass::Cell | MatClass::Struct, Ok(elements)) = (value.class(), value.elements()) {
        for element in elements {
            for name in value.field_names() {
                access_all(element.field(name).unwrap());
            }
            if value.class() == MatClass::Cell {
                access_all(element);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn damaged_files_never_panic(
        which in 0..3_usize,
        changes in proptest::collection::vec((128..3000_usize, any::<u8>()), 1..4),
    ) {
        let mut bytes = [KINDS, COMPRESSED, BIG_ENDIAN][which].to_vec();
        for (at, value) in changes {
            let at = 128 + (at - 128) % (bytes.len() - 128);
            bytes[at] = value;
        }
        if let Ok(file) = MatFile::parse_within(&bytes, 1 << 20) {
            for name in file.names() {
                access_all(file.variable(name).unwrap());
            }
        }
    }
}
