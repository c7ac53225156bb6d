use std::fs;
use std::io::Write;

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use proptest::prelude::*;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::*;
use crate::golden::check;
use crate::sample::{event, file, npy};
use crate::{Input, IoError, OpenOptions, SensorOrigin, open, open_with, read_as};

const SENSOR: SensorSize = SensorSize { width: 300, height: 20 };

/// An array as NumPy writes it: type, shape, bytes.
type Array<'a> = (&'a str, &'a str, &'a str, Vec<u8>);

/// An archive as `numpy.savez_compressed` writes it.
fn archive(arrays: &[Array<'_>]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut zip = ZipWriter::new(&mut bytes);
    for (name, descr, shape, data) in arrays {
        zip.start_file(format!("{name}.npy"), SimpleFileOptions::default()).unwrap();
        let quote = if descr.starts_with('[') { "" } else { "'" };
        let header = format!(
            "{{'descr': {quote}{descr}{quote}, 'fortran_order': False, 'shape': {shape}, }}"
        );
        zip.write_all(b"\x93NUMPY\x01\x00\xf6\x00").unwrap();
        zip.write_all(format!("{header:<245}\n").as_bytes()).unwrap();
        zip.write_all(data).unwrap();
    }
    zip.finish().unwrap();
    bytes.into_inner()
}

fn three_events<'a>() -> Vec<Array<'a>> {
    vec![
        ("t", "<i8", "(3,)", [5i64, 7, 7].iter().flat_map(|t| t.to_le_bytes()).collect()),
        ("x", "<i2", "(3,)", vec![1, 0, 2, 0, 3, 0]),
        ("y", "<u2", "(3,)", vec![4, 0, 5, 0, 6, 0]),
        ("p", "|b1", "(3,)", vec![1, 0, 1]),
        ("width", "<i8", "()", 240i64.to_le_bytes().to_vec()),
        ("height", "<i4", "(1,)", 180i32.to_le_bytes().to_vec()),
    ]
}

fn fault_of(arrays: &[Array<'_>]) -> (String, NpzFault, usize) {
    let (_directory, path) = file("hand.npz", archive(arrays));
    match open(&path).unwrap_err() {
        IoError::Npz { array, fault, values, .. } => (array, fault, values),
        other => panic!("{other}"),
    }
}

#[test]
fn the_types_numpy_writes_are_read() {
    let (_directory, path) = file("hand.npz", archive(&three_events()));
    let recording = open(&path).unwrap();
    let want = [event(5, 1, 4, true), event(7, 2, 5, false), event(7, 3, 6, true)];
    assert_eq!(recording.stream, EventStream::from_events(SensorSize::DAVIS240C, want).unwrap());
    assert_eq!(recording.sensor_origin, SensorOrigin::Stated);
    assert_eq!(recording.outside, 0);
}

/// More than a piece of them, in every type that each column may have.
#[test]
fn the_type_of_a_column_does_not_matter() {
    const EVENTS: i64 = 70_000;
    let bytes = |descr: &str, values: &dyn Fn(i64) -> i64| -> Vec<u8> {
        let size: usize = descr[2..].parse().unwrap();
        let value = |k| {
            let mut bytes = match (&descr[1..2], size) {
                ("f", 4) => (values(k) as f32).to_le_bytes().to_vec(),
                ("f", _) => (values(k) as f64).to_le_bytes().to_vec(),
                _ => values(k).to_le_bytes()[..size].to_vec(),
            };
            if descr.starts_with('>') {
                bytes.reverse();
            }
            bytes
        };
        (0..EVENTS).flat_map(value).collect()
    };
    let (t, x, y, p) = (|k| k / 2, |k| k % 120, |k| 7 * k % 100, |k| k % 3 % 2);
    let event = |k| {
        let (x, y) = (x(k) as u16, y(k) as u16);
        Event { t: Micros(t(k)), x, y, polarity: Polarity::from_on(p(k) == 1) }
    };
    let sensor = SensorSize { width: 120, height: 100 };
    let want = EventStream::from_events(sensor, (0..EVENTS).map(event)).unwrap();
    let times = ["<i8", ">i8", "<i4", "<u4", ">u8", "<f8", "<f4", ">f4"];
    let places = ["<u2", ">u2", "<i2", "|u1", "|i1", "<i8", "<f4", ">f8"];
    let polarities = ["|u1", "|b1", "|i1", "<i2", ">u2", "<i8", "<f4", "<u4"];
    for ((t_type, place), polarity) in times.into_iter().zip(places).zip(polarities) {
        let columns = [
            ("t", t_type, bytes(t_type, &t)),
            ("x", place, bytes(place, &x)),
            ("y", place, bytes(place, &y)),
            ("p", polarity, bytes(polarity, &p)),
        ];
        let shape = format!("({EVENTS},)");
        let arrays: Vec<Array<'_>> = columns
            .iter()
            .map(|(name, descr, bytes)| (*name, *descr, shape.as_str(), bytes.clone()))
            .collect();
        let (_directory, path) = file("hand.npz", archive(&arrays));
        assert!(open(&path).unwrap().stream == want, "{t_type} {place} {polarity}");
        // The same as records, whose fields lie between each other.
        let descr = columns.iter().map(|(name, descr, _)| format!("('{name}', '{descr}')"));
        let descr = format!("[{}]", descr.collect::<Vec<_>>().join(", "));
        let mut records = Vec::new();
        for k in 0..EVENTS as usize {
            for (_, _, bytes) in &columns {
                let size = bytes.len() / EVENTS as usize;
                records.extend_from_slice(&bytes[k * size..][..size]);
            }
        }
        let (_directory, path) = file("hand.npz", archive(&[("events", &descr, &shape, records)]));
        assert!(open(&path).unwrap().stream == want, "{descr}");
    }
}

#[test]
fn events_outside_the_sensor_are_counted_and_those_out_of_order_sorted() {
    let mut arrays = three_events();
    arrays[0].3 = [5i64, 7, 6].iter().flat_map(|t| t.to_le_bytes()).collect();
    arrays[1].3 = vec![0xff, 0xff, 2, 0, 3, 0];
    let (_directory, path) = file("hand.npz", archive(&arrays));
    let recording = open(&path).unwrap();
    assert_eq!(recording.stream.t(), [Micros(6), Micros(7)]);
    assert_eq!(recording.outside, 1);
}

#[test]
fn records_with_padding_and_titles_are_read_as_numpy_reads_them() {
    let padded = "[('t', '<i8'), ('x', '<i2'), ('y', '<i2'), ('p', '|u1'), ('', '|V3')]";
    let titled = "[('t', '<u8'), ('x', '<u2'), ('y', '<u2'), (('p', 'on'), '|b1')]";
    for (descr, padding) in [(padded, 3), (titled, 0)] {
        let row = |t: i64, x: u16, p: u8| {
            let place = [t.to_le_bytes().to_vec(), x.to_le_bytes().to_vec(), vec![7, 0, p]];
            [place.concat(), vec![0xaa; padding]].concat()
        };
        let bytes = npy(descr, "(2,)", &[row(5, 3, 1), row(9, 4, 0)].concat());
        let read = read_as(Input::memory("events.npy", bytes), &OpenOptions::default()).unwrap();
        let event = |t, x, polarity| Event { t: Micros(t), x, y: 7, polarity };
        let want = [event(5, 3, Polarity::On), event(9, 4, Polarity::Off)];
        assert_eq!(read.stream.iter().collect::<Vec<_>>(), want, "{descr}");
    }
}

#[test]
fn missing_arrays_are_named() {
    let mut arrays = three_events();
    arrays.remove(4);
    arrays.remove(0);
    let (_directory, path) = file("hand.npz", archive(&arrays));
    assert_eq!(
        open(&path).unwrap_err().to_string(),
        format!("{}: no array t, width (found: height, p, x, y)", path.display())
    );
}

#[test]
fn a_polarity_is_0_or_1_or_minus_1_or_1() {
    let mut arrays = three_events();
    let polarities = |arrays: &[Array<'_>]| {
        let (_directory, path) = file("hand.npz", archive(arrays));
        open(&path).unwrap().stream.polarity().to_vec()
    };
    let want = polarities(&arrays);
    arrays[3] = ("p", "|i1", "(3,)", vec![1, 0xff, 1]);
    assert_eq!(polarities(&arrays), want);
    arrays[3].3[1] = 2;
    assert_eq!(fault_of(&arrays), ("p".to_owned(), NpzFault::Value(2), 1));
}

/// The three events in seconds, and as other programs have them.
#[test]
fn what_other_programs_save_is_read() {
    let f8 = |values: &[f64]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let mut arrays = three_events();
    arrays[0].3 = [5i64, 7, 9].iter().flat_map(|t| t.to_le_bytes()).collect();
    let (_directory, path) = file("hand.npz", archive(&arrays));
    let want = open(&path).unwrap().stream;
    let size = || three_events().split_off(4);
    let with = |mut arrays: Vec<Array<'static>>| {
        arrays.extend(size());
        archive(&arrays)
    };
    let rows = [
        ([5.0, 1.0, 4.0, 1.0], [7.0, 2.0, 5.0, 0.0], [9.0, 3.0, 6.0, 1.0]),
        ([1.0, 4.0, 5.0, 1.0], [2.0, 5.0, 7.0, -1.0], [3.0, 6.0, 9.0, 1.0]),
        ([1.0, 4.0, 1.0, 5.0], [2.0, 5.0, 0.0, 7.0], [3.0, 6.0, 1.0, 9.0]),
    ];
    let mut files: Vec<Vec<u8>> = rows
        .iter()
        .map(|(a, b, c)| with(vec![("events", "<f8", "(3, 4)", f8(&[*a, *b, *c].concat()))]))
        .collect();
    // Seconds, and names of their own.
    files.push(with(vec![
        ("ts", "<f8", "(3,)", f8(&[5e-6, 7e-6, 9e-6])),
        ("xs", "|u1", "(3, 1)", vec![1, 2, 3]),
        ("ys", "<f8", "(3,)", f8(&[4.0, 5.0, 6.0])),
        ("polarity", "|b1", "(3,)", vec![1, 0, 1]),
    ]));
    // Records.
    let record = |t: i64, x: u8, y: u8, p: u8| [&[x, y, p][..], &t.to_le_bytes()].concat();
    let data = [record(5, 1, 4, 1), record(7, 2, 5, 0), record(9, 3, 6, 1)].concat();
    let fields = "[('x', '|u1'), ('y', '|u1'), ('p', '|b1'), ('t', '<i8')]";
    files.push(with(vec![("events", fields, "(3,)", data)]));
    // Columns one behind the other.
    files.push(with(vec![(
        "events",
        "<f8",
        "(4, 3)",
        f8(&[5.0, 7.0, 9.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 1.0, 0.0, 1.0]),
    )]));
    // As `numpy.savez(file, records)` calls it, in another order, of other types.
    let big = |t: i32, x: u16, y: i32, p: f32| {
        let (p, t, y) = (p.to_le_bytes(), t.to_be_bytes(), y.to_be_bytes());
        [&p[..], &t, &x.to_be_bytes(), &y].concat()
    };
    let data = [big(5, 1, 4, 1.0), big(7, 2, 5, -1.0), big(9, 3, 6, 1.0)].concat();
    let fields = "[('pol', '<f4'), ('ts', '>i4'), ('x', '>u2'), ('y', '>i4')]";
    files.push(with(vec![("arr_0", fields, "(3,)", data.clone())]));
    files.push(with(vec![("recording", fields, "(3,)", data)]));
    for (i, bytes) in files.iter().enumerate() {
        let (_directory, path) = file("hand.npz", bytes);
        assert_eq!(open(&path).unwrap().stream, want, "file {i}");
    }
}

#[test]
fn without_a_size_the_sensor_is_given_or_inferred_and_half_a_size_is_a_fault() {
    let mut arrays = three_events();
    arrays.truncate(4);
    let (_directory, path) = file("hand.npz", archive(&arrays));
    let recording = open_with(&path, Some(SENSOR)).unwrap();
    assert_eq!((recording.stream.sensor(), recording.sensor_origin), (SENSOR, SensorOrigin::Given));
    let recording = open(&path).unwrap();
    assert_eq!(recording.stream.sensor(), SensorSize { width: 4, height: 7 });
    assert_eq!(recording.sensor_origin, SensorOrigin::Inferred);
    arrays.push(("width", "<i8", "()", 240i64.to_le_bytes().to_vec()));
    let (_directory, path) = file("hand.npz", archive(&arrays));
    let message = open(&path).unwrap_err().to_string();
    assert!(message.contains("no array height (found: p, t, width, x, y)"), "{message}");
}

#[test]
fn columns_that_are_in_no_known_order_are_refused_with_those_there_are() {
    let data: Vec<u8> = (0..400u32).map(|k| (k * k * 7 % 101) as u8).collect();
    let (_directory, path) = file("hand.npz", archive(&[("events", "|u1", "(100, 4)", data)]));
    let message = open(&path).unwrap_err().to_string();
    assert!(message.contains("array `events`") && message.contains("x y t p"), "{message}");
}

#[test]
fn columns_of_other_types_shapes_and_lengths_are_refused() {
    let mut arrays = three_events();
    arrays[0].1 = "<c8";
    assert_eq!(fault_of(&arrays), ("t".to_owned(), NpzFault::Type("'<c8'".to_owned()), 0));
    let mut arrays = three_events();
    arrays[1] = ("x", "|u1", "(3, 2)", vec![1, 0, 2, 0, 3, 0]);
    assert_eq!(fault_of(&arrays), ("x".to_owned(), NpzFault::Shape, 0));
    let mut arrays = three_events();
    arrays[3] = ("p", "|u1", "(2,)", vec![1, 0]);
    assert_eq!(fault_of(&arrays), ("p".to_owned(), NpzFault::Length { got: 2, of: 3 }, 2));
}

#[test]
fn a_single_array_without_the_fields_of_events_is_refused_by_its_name() {
    let fields = "[('t', '|u1'), ('x', '|u1'), ('y', '|u1')]";
    let (array, fault, _) = fault_of(&[("arr_0", fields, "(1,)", vec![1, 2, 3])]);
    let want = NpzFault::Columns(
        "no field p (found: t, x, y): say which it is, as --columns p=NAME".to_owned(),
    );
    assert_eq!((array.as_str(), fault), ("arr_0", want));
    // Several arrays may be anything.
    let two = [("arr_0", "|u1", "(1,)", vec![1]), ("arr_1", "|u1", "(1,)", vec![1])];
    let (_directory, path) = file("hand.npz", archive(&two));
    let message = open(&path).unwrap_err().to_string();
    assert!(message.contains("no array t, x, y, p (found: arr_0, arr_1)"), "{message}");
}

#[test]
fn a_header_that_claims_more_than_there_is_allocates_nothing() {
    let mut arrays = three_events();
    arrays[0].2 = "(9000000000000000000,)";
    let (array, fault, values) = fault_of(&arrays);
    assert!(matches!((array.as_str(), fault, values), ("t", NpzFault::TooLarge { .. }, 0)));
    arrays[0].2 = "(9000000,)";
    let cut = read_as(Input::memory("cut.npz", archive(&arrays)), &OpenOptions::default());
    let cut = cut.unwrap_err().to_string();
    assert!(cut.contains("array `t`, 3 values from there: "), "{cut}");
    arrays[0].2 = "(9999999999, 9999999999, 9999999999)";
    assert_eq!(fault_of(&arrays).1, NpzFault::Shape);
}

#[test]
fn arrays_of_nothing_end() {
    // As many rows as anybody likes, of no bytes each.
    let mut arrays = three_events();
    arrays[0].2 = "(9000000000000000000, 0)";
    arrays[0].3.clear();
    assert_eq!(fault_of(&arrays).1, NpzFault::Shape);
    arrays[0].1 = "[]";
    arrays[0].2 = "(3,)";
    let error = read_as(Input::memory("a.npz", archive(&arrays)), &OpenOptions::default());
    assert!(matches!(error, Err(IoError::Npz { .. } | IoError::Damaged { .. })), "{error:?}");
}

#[test]
fn headers_that_would_overrun_the_parser_are_not_given_to_it() {
    let mut arrays = three_events();
    let deep = format!("[('t', {}'<i8'{})]", "[".repeat(2000), "]".repeat(2000));
    for (descr, shape) in [
        ("<i8", "(3,), 'shape': (9999999999, 9999999999, 9999999999)"),
        ("<i8", "(3,), 'sh\\x61pe': (9999999999, 9999999999, 9999999999)"),
        ("<i8", "(0, 9223372036854775808, 9223372036854775808)"),
        (&deep, "(3,)"),
    ] {
        (arrays[0].1, arrays[0].2) = (descr, shape);
        let array = npy(&format!("'{descr}'"), shape, &[]);
        let (_directory, path) = file("hand.npz", &array);
        let error = open(&path).unwrap_err();
        assert!(matches!(error, IoError::Npz { .. } | IoError::Damaged { .. }), "{error}");
    }
}

#[test]
fn an_archive_cut_at_any_byte_is_a_typed_error() {
    let bytes = archive(&three_events());
    let (_directory, path) = file("hand.npz", &bytes);
    for cut in (0..bytes.len()).rev() {
        fs::File::options().write(true).open(&path).unwrap().set_len(cut as u64).unwrap();
        let error = open(&path).unwrap_err();
        match error {
            IoError::Damaged { byte, .. } => assert_eq!(byte, cut as u64),
            // Too short to detect the format.
            IoError::UnknownFormat { .. } | IoError::NoRecording { .. } => {
                assert!(cut < 4, "{cut}");
            }
            other => panic!("{cut}: {other}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_stream_survives_the_archive(
        mut times in prop::collection::vec(any::<i64>(), 0..40), seed in 0..60_000_u16,
    ) {
        times.sort_unstable();
        let events = times.iter().zip(seed..).map(|(&t, n)| Event {
            t: Micros(t), x: n % 300, y: n % 20, polarity: Polarity::from_on(n % 3 == 0),
        });
        let stream = EventStream::from_events(SENSOR, events)?;
        let (_directory, path) = file("hand.npz", []);
        FORMAT.write(&path, &stream).unwrap();
        prop_assert_eq!(&open(&path).unwrap().stream, &stream);
        NPY.write(&path, &stream).unwrap();
        let back = open_with(&path, Some(SENSOR)).unwrap();
        prop_assert_eq!((back.format, back.stream), ("npy", stream));
    }
}

/// A change may go unseen in a date or an unused size; the events are then unharmed.
#[test]
fn a_changed_bit_is_an_error_or_does_no_harm() {
    let bytes = archive(&three_events());
    let (_directory, path) = file("hand.npz", &bytes);
    let clean = open(&path).unwrap();
    for at in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[at] ^= 1 << (at % 8);
        fs::write(&path, changed).unwrap();
        if let Ok(recording) = open(&path) {
            assert_eq!(recording, clean, "byte {at}");
        }
    }
}

/// As that of gzip and Zstandard: `--salvage` and scripts see damage, not another kind of file.
#[test]
fn damaged_archives_of_arrays_are_damage_with_its_byte() {
    let bytes = archive(&three_events());
    let begin = |name: &str| {
        let mut zip = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
        zip.by_name(name).unwrap().data_start().unwrap()
    };
    for name in ["t.npy", "p.npy"] {
        let begin = begin(name);
        let mut changed = bytes.clone();
        changed[begin as usize + 20] ^= 0x10;
        let damage = read_as(Input::memory("a.npz", changed), &OpenOptions::default()).unwrap_err();
        assert!(damage.is_damage() && damage.byte() == Some(begin), "{damage}");
        assert!(damage.to_string().contains(&name[..1]), "{damage}");
    }
    let mut evimo = three_events();
    evimo.truncate(1);
    evimo[0].0 = EVIMO[0];
    evimo.push((EVIMO[1], "|u1", "(3, 2)", vec![1, 1, 2, 2, 3, 3]));
    evimo.push((EVIMO[2], "|u1", "(3,)", vec![1, 0, 1]));
    let mut evimo = archive(&evimo);
    assert!(read_as(Input::memory("e.npz", evimo.clone()), &OpenOptions::default()).is_ok());
    // Within the first array, behind its name of 20 bytes.
    evimo[70] ^= 0x10;
    let damage = read_as(Input::memory("e.npz", evimo), &OpenOptions::default()).unwrap_err();
    assert!(damage.is_damage() && damage.to_string().contains(EVIMO[0]), "{damage}");
}

/// See `tests/golden/numpy`.
#[test]
fn structured_arrays_that_numpy_wrote_hold_the_events_that_it_was_given() {
    let files = [("records.npy", "npy"), ("records.npz", "npz"), ("records-compressed.npz", "npz")];
    check("numpy", &files);
}

#[test]
fn times_that_cannot_be_are_doubted() {
    let array = |descr: &str, t: &dyn Fn(i64) -> Vec<u8>| {
        let fields = format!("[('t', '{descr}'), ('x', '<u2'), ('y', '<u2'), ('p', '|u1')]");
        let rows: Vec<u8> = (0..300).flat_map(|k| [t(k), vec![3, 0, 2, 0, 1]].concat()).collect();
        let bytes = npy(&fields, "(300,)", &rows);
        let input = Input::memory("events.npy", bytes);
        read_as(input, &OpenOptions::default()).unwrap().remarks.join("; ")
    };
    let whole =
        |begin: i64, step: i64| array("<i8", &move |k| (begin + step * k).to_le_bytes().to_vec());
    assert_eq!(whole(1_700_000_000_000_000, 1_000), "");
    assert!(whole(0, 7_000_000).contains("fewer than ten a second"));
    assert!(whole(1_700_000_000_000_000_000, 1_000).contains("of the year"));
    let seconds = |begin: f64| {
        array("<f4", &move |k| ((begin + 0.001 * k as f64) as f32).to_le_bytes().to_vec())
    };
    assert_eq!(seconds(0.0), "");
    assert!(seconds(1_605_537_536.0).contains("floats of 32 bits"));
}

#[test]
fn an_archive_that_unpacks_to_gigabytes_is_refused_before_it_is_unpacked() {
    // Zeros, of which deflate makes a thousandth.
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default();
    for (name, kind, bytes) in [("t", "<i8", 8), ("x", "<u2", 2), ("y", "<u2", 2), ("p", "|u1", 1)]
    {
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(&npy(&format!("'{kind}'"), "(40000000,)", &[])).unwrap();
        let zeros = std::io::Read::take(std::io::repeat(0), bytes * 4_000_000);
        std::io::copy(&mut { zeros }, &mut zip).unwrap();
    }
    let bytes = zip.finish().unwrap().into_inner();
    let error = read_as(Input::memory("bomb.npz", bytes), &OpenOptions::default());
    let error = error.unwrap_err().to_string();
    assert!(error.contains("320000000 bytes") && error.contains("268435456 at most"), "{error}");
}

#[test]
fn the_three_arrays_of_evimo_are_read_from_an_archive_and_from_a_folder() {
    let times = [0.25_f64, 0.5, 0.500_001].map(f64::to_le_bytes).concat();
    let pixels = [3_u16, 4, 639, 479, 1, 2].map(u16::to_le_bytes).concat();
    let arrays = [
        npy("'<f8'", "(3,)", &times),
        npy("'<u2'", "(3, 2)", &pixels),
        npy("'|u1'", "(3,)", &[1, 0, 1]),
    ];
    let folder = tempfile::tempdir().unwrap();
    let mut zip = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, array) in EVIMO.iter().zip(&arrays) {
        fs::write(folder.path().join(format!("{name}.npy")), array).unwrap();
        zip.start_file(format!("{name}.npy"), SimpleFileOptions::default()).unwrap();
        zip.write_all(array).unwrap();
    }
    let archive = folder.path().join("events.npz");
    fs::write(&archive, zip.finish().unwrap().into_inner()).unwrap();
    let want =
        [event(250_000, 3, 4, true), event(500_000, 639, 479, false), event(500_001, 1, 2, true)];
    for path in [archive, folder.path().to_owned(), folder.path().join("dataset_events_xy.npy")] {
        let read = open(&path).unwrap();
        assert_eq!(read.stream.iter().collect::<Vec<_>>(), want, "{}", path.display());
    }
}
