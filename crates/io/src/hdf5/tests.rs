use std::fs;
use std::path::PathBuf;

use crate::{Input, OpenOptions};

fn golden(name: &str) -> Vec<u8> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/hdf5");
    fs::read(folder.join(name)).unwrap()
}

#[test]
fn a_file_is_known_by_its_signature_behind_another_programs_block_too() {
    let file = golden("prophesee-plain.hdf5");
    for before in [0, 512, 2048] {
        let moved = [vec![0; before], file.clone()].concat();
        assert!((super::FORMAT.probe)(&moved[..4096]));
    }
    assert!(!(super::FORMAT.probe)(&file[1..]));
}

#[cfg(not(feature = "hdf5"))]
#[test]
fn a_build_that_does_not_read_such_files_says_how_to_get_one_that_does() {
    let input = Input::memory("drive.h5", golden("dsec-zstd.h5"));
    let refused = crate::read_as(input, &OpenOptions::default()).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "drive.h5: HDF5 is not read by this build: build it with `--features hdf5`"
    );
}

#[cfg(feature = "hdf5")]
mod reading {
    use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
    use proptest::prelude::*;
    use sha2::{Digest, Sha256};

    use super::{Input, OpenOptions, golden};
    use crate::sample::read_all;
    use crate::{Columns, EventSource, IoError, SensorOrigin, read_as};

    /// Files, their events and the digest of those, as README.md there lists them.
    fn listed() -> Vec<(String, usize, String)> {
        let readme = String::from_utf8(golden("README.md")).unwrap();
        let of_entry = |entry: &str| {
            let (names, rest) = entry.split_once(" (").unwrap();
            let count: usize = rest.split_once(" events)").unwrap().0.parse().unwrap();
            let digest = rest.trim_end().rsplit('`').nth(1).unwrap();
            let names = names.split(", ").map(|name| name.trim_matches('*'));
            names.map(|name| (name.to_owned(), count, digest.to_owned())).collect::<Vec<_>>()
        };
        let mut files: Vec<_> = readme.split("\n* ").skip(1).flat_map(of_entry).collect();
        files.retain(|(name, ..)| name != "dsec-snappy.h5");
        assert_eq!(files.len(), 25);
        files
    }

    fn source(name: &str, bytes: Vec<u8>) -> Result<Box<dyn EventSource>, IoError> {
        (crate::hdf5::FORMAT.open)(Input::memory(name, bytes), &OpenOptions::default())
    }

    /// Everything to the end or to the first fault.
    fn events(source: &mut dyn EventSource) -> (Columns, Option<IoError>) {
        let (columns, _, fault) = read_all(source);
        (columns, fault)
    }

    fn whole(name: &str) -> Columns {
        let (columns, fault) = events(source(name, golden(name)).unwrap().as_mut());
        assert!(fault.is_none(), "{name}: {fault:?}");
        columns
    }

    /// Of each event its time in 64 bits, column and row in 16 and polarity in 8, little-endian.
    fn digest(columns: &Columns) -> String {
        let mut sum = Sha256::new();
        for event in columns.iter() {
            sum.update(event.t.0.to_le_bytes());
            sum.update(event.x.to_le_bytes());
            sum.update(event.y.to_le_bytes());
            sum.update([u8::from(event.polarity.is_on())]);
        }
        sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    #[test]
    fn columns_of_an_array_without_names_are_those_that_are_given() {
        let read = |columns: &str| {
            let columns = columns.parse().unwrap();
            let options = OpenOptions { columns, ..OpenOptions::default() };
            let stream = read_as(Input::memory("v2e.h5", golden("v2e-columns.h5")), &options)
                .unwrap()
                .stream;
            (stream.x().to_vec(), stream.y().to_vec())
        };
        let (x, y) = read("t=0,x=1,y=2,p=3");
        assert!(x != y);
        assert!(read("t=0,x=2,y=1,p=3") == (y, x));
    }

    #[test]
    fn files_of_other_libraries_hold_the_events_that_those_wrote() {
        for (name, count, sum) in listed() {
            let columns = whole(&name);
            assert_eq!((columns.len(), digest(&columns)), (count, sum), "{name}");
        }
    }

    #[test]
    fn reading_goes_on_from_any_time() {
        for (name, ..) in listed() {
            let all = whole(&name);
            let mut source = source(&name, golden(&name)).unwrap();
            let (first, last) = (all.t[0].0, all.t[all.len() - 1].0);
            for part in 0..=20 {
                let t = Micros(first - 5 + (last - first + 10) * part / 20);
                source.seek(t).unwrap();
                let (rest, fault) = events(source.as_mut());
                assert!(fault.is_none(), "{name}: {fault:?}");
                let from = all.len() - rest.len();
                assert!(all.t[..from].iter().all(|&before| before < t), "{name} at {t:?}");
                assert!(rest.iter().eq(all.iter().skip(from)), "{name} at {t:?}");
            }
        }
    }

    #[test]
    fn files_say_what_they_are() {
        let read = |name: &str| {
            let read = read_as(Input::memory(name, golden(name)), &OpenOptions::default()).unwrap();
            (read.stream.sensor(), read.sensor_origin, read.remarks)
        };
        let vga = SensorSize { width: 640, height: 480 };
        let triggers = "3 edges of external signals are passed over".to_owned();
        assert_eq!(read("prophesee-ecf.hdf5"), (vga, SensorOrigin::Stated, vec![triggers]));
        assert_eq!(read("e2vid-lzf.h5"), (vga, SensorOrigin::Stated, vec![]));
        assert_eq!(read("dsec-zstd.h5"), (vga, SensorOrigin::Assumed, vec![]));
        let source = source("a", golden("prophesee-ecf.hdf5")).unwrap();
        let facts = &source.header().facts;
        assert!(facts.contains(&("packing", "ECF".to_owned())), "{facts:?}");
        assert!(facts.contains(&("serial", "00001621".to_owned())), "{facts:?}");
    }

    #[test]
    fn one_camera_of_several_is_read_and_the_others_are_not_forgotten() {
        let of = |camera| {
            let input = Input::memory("mvsec.h5", golden("mvsec.h5"));
            read_as(input, &OpenOptions { camera, ..OpenOptions::default() })
        };
        let left = of(None).unwrap();
        let passed =
            "the events of /davis/right/events are passed over: they are those of camera 1";
        assert_eq!((left.stream.len(), left.remarks), (300, vec![passed.to_owned()]));
        let right = of(Some(1)).unwrap();
        assert_eq!((right.stream.len(), right.remarks), (5, vec![]));
        assert_eq!(of(Some(2)).unwrap_err().to_string(), "mvsec.h5: no camera 2, it has 2");
    }

    #[test]
    fn what_is_packed_by_a_codec_that_is_not_read_names_it() {
        let name = "dsec-snappy.h5";
        let (columns, fault) = events(source(name, golden(name)).unwrap().as_mut());
        let fault = fault.unwrap();
        assert!(columns.is_empty() && fault.is_damage());
        assert!(fault.to_string().contains("Snappy"), "{fault}");
    }

    #[test]
    fn a_size_beside_the_columns_is_a_hint() {
        let mut source = source("bitshuffle-lz4.h5", golden("bitshuffle-lz4.h5")).unwrap();
        // As RVT's, the file states the size beside the columns.
        assert_eq!(source.header().sensor, Some(SensorSize { width: 1280, height: 720 }));
        assert_eq!(events(source.as_mut()).0.len(), 1203);
        // Two values, a text and a fraction are no size.
        for name in ["size-two.h5", "size-text.h5", "size-half.h5"] {
            let read = read_as(Input::memory(name, golden(name)), &OpenOptions::default()).unwrap();
            let (sensor, origin) = (read.stream.sensor(), read.sensor_origin);
            let extent = SensorSize { width: 343, height: 256 };
            assert_eq!((sensor, origin), (extent, SensorOrigin::Inferred), "{name}");
        }
        // One that most events lie outside of is a contradiction.
        let mut other = golden("bitshuffle-none.h5");
        let width = other.windows(8).position(|bytes| bytes == 1280_i64.to_le_bytes()).unwrap();
        other[width..width + 8].copy_from_slice(&20_i64.to_le_bytes());
        let refused = read_as(Input::memory("a", other), &OpenOptions::default()).unwrap_err();
        assert!(matches!(refused, IoError::Outside { .. }), "{refused}");
    }

    /// The readable part of a damaged file must be a beginning of its content, and the damage
    /// reported.
    fn check(name: &str, bytes: Vec<u8>, all: &Columns) {
        let mut source = match source(name, bytes) {
            Ok(source) => source,
            Err(fault) => {
                assert!(matches!(fault, IoError::Damaged { events: 0, .. }), "{name}: {fault:?}");
                return;
            }
        };
        let (columns, fault) = events(source.as_mut());
        match fault {
            None => assert!(columns == *all, "{name}: events are lost in silence"),
            Some(IoError::Damaged { events, .. }) => {
                assert_eq!(events, columns.len() as u64, "{name}");
                assert!(columns.iter().eq(all.iter().take(columns.len())), "{name}");
            }
            Some(other) => panic!("{name}: {other}"),
        }
    }

    #[test]
    fn a_file_behind_another_programs_block_is_read_from_there() {
        for (name, before) in [("prophesee-ecf.hdf5", 512), ("prophesee-plain.hdf5", 2048)] {
            let moved = [vec![0; before], golden(name)].concat();
            let (columns, fault) = events(source(name, moved.clone()).unwrap().as_mut());
            assert!(fault.is_none() && columns == whole(name), "{name}: {fault:?}");
            for length in (0..moved.len()).step_by(97) {
                check(name, moved[..length].to_vec(), &columns);
            }
        }
    }

    #[test]
    fn chunks_that_end_early_keep_the_events_before() {
        let (bytes, all) = (golden("prophesee-plain.hdf5"), whole("prophesee-plain.hdf5"));
        let cut = bytes[..bytes.len() - 40].to_vec();
        let (columns, fault) = events(source("cut", cut).unwrap().as_mut());
        assert_eq!(columns.len(), all.len() - 3);
        let fault = fault.unwrap().to_string();
        assert!(fault.contains("chunk 0 ends after 197 of its 200 rows"), "{fault}");
    }

    /// More chunks than a node of their index holds, in batches that do not fit chunks.
    #[test]
    fn a_long_recording_survives_the_file_and_is_read_from_any_time() {
        let sensor = SensorSize { width: 1280, height: 720 };
        let count = 66 * (1 << 16) + 7;
        let event = |k: i64| Event {
            t: Micros(3 * k / 2 - 9_000_000_000),
            x: (k % 1280) as u16,
            y: (k % 719) as u16,
            polarity: Polarity::from_on(k % 3 == 0),
        };
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("long.h5");
        let mut sink = crate::create(&path, sensor).unwrap();
        for first in (0..count).step_by(250_001) {
            let batch = first..count.min(first + 250_001);
            sink.write(&EventStream::from_events(sensor, batch.map(event)).unwrap()).unwrap();
        }
        sink.finish().unwrap();
        let mut source =
            (crate::hdf5::FORMAT.open)(Input::file(&path).unwrap(), &OpenOptions::default())
                .unwrap();
        assert_eq!(source.header().sensor, Some(sensor));
        let (columns, fault) = events(source.as_mut());
        assert!(fault.is_none(), "{fault:?}");
        assert!(columns.iter().eq((0..count).map(event)));
        source.seek(event(count - 100).t).unwrap();
        let (rest, _) = events(source.as_mut());
        assert!(rest.len() >= 100 && rest.len() < 1 << 17, "{}", rest.len());
    }

    /// The one-dimensional dataset `name` of whole numbers, or the one value of a scalar.
    fn integers(path: &std::path::Path, name: &str) -> Vec<i64> {
        let file = hdf5_reader::Hdf5File::open(path).unwrap();
        let dataset = file.root_group().unwrap().dataset(name).unwrap();
        match dataset.dtype() {
            hdf5_reader::Datatype::FixedPoint { signed: true, .. } => {
                dataset.read_array::<i64>().unwrap().iter().copied().collect()
            }
            _ => dataset.read_array::<u64>().unwrap().iter().map(|&entry| entry as i64).collect(),
        }
    }

    /// As programs for DSEC go to a time: from the first event of its millisecond on.
    #[test]
    fn written_files_have_the_first_event_of_every_millisecond() {
        let sensor = SensorSize { width: 640, height: 480 };
        let directory = tempfile::tempdir().unwrap();
        // More milliseconds than a chunk of the index has, and a clock of the calendar.
        for (name, begin, step, count) in
            [("a.h5", 250, 70, 3_000), ("b.h5", 1_700_000_000_000_300, 350_001, 400)]
        {
            let event = |k: i64| Event {
                t: Micros(begin + k * step),
                x: (k % 640) as u16,
                y: 7,
                polarity: Polarity::On,
            };
            let stream = EventStream::from_events(sensor, (0..count).map(event)).unwrap();
            let path = directory.path().join(name);
            crate::hdf5::FORMAT.write(&path, &stream).unwrap();
            let offset = integers(&path, "t_offset");
            assert_eq!(offset, [if begin < 1_000 { 0 } else { begin }], "{name}");
            let index = integers(&path, "ms_to_idx");
            let times: Vec<i64> = stream.t().iter().map(|t| t.0 - offset[0]).collect();
            assert_eq!(index.len() as i64, times.last().unwrap() / 1_000 + 1, "{name}");
            for (ms, first) in (0..).zip(&index) {
                let want = times.partition_point(|t| *t < 1_000 * ms);
                assert_eq!(*first, want as i64, "{name}: {ms} ms");
            }
            assert_eq!(crate::open(&path).unwrap().stream, stream, "{name}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_stream_survives_the_file(
            mut times in prop::collection::vec(any::<i64>(), 0..40), seed in 0..60_000_u16,
        ) {
            times.sort_unstable();
            let events = times.iter().zip(seed..).map(|(&t, n)| Event {
                t: Micros(t), x: n % 300, y: n % 20, polarity: Polarity::from_on(n % 3 == 0),
            });
            let stream = EventStream::from_events(SensorSize { width: 300, height: 20 }, events)?;
            let directory = tempfile::tempdir().unwrap();
            let path = directory.path().join("events.h5");
            crate::hdf5::FORMAT.write(&path, &stream).unwrap();
            prop_assert_eq!(crate::open(&path).unwrap().stream, stream);
        }
    }
}
