use std::fs::{self, File};

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use proptest::prelude::*;

use super::*;
use crate::IoError;
use crate::sample::file;

const SENSOR: SensorSize = SensorSize { width: 300, height: 20 };
type Frames = Vec<Vec<(u16, u16, Polarity)>>;

fn written(frames: &Frames) -> Vec<u8> {
    let (_directory, path) = file("hand.evc", []);
    let mut writer = EvcWriter::create(&path, SENSOR).unwrap();
    for frame in frames {
        writer.frame_of(frame.iter().copied()).unwrap();
    }
    writer.finish().unwrap();
    fs::read(path).unwrap()
}

/// The events of `frames` in the order of the file.
fn in_file_order(frames: &[Vec<(u16, u16, Polarity)>]) -> Vec<EvcEvent> {
    let sorted = frames.iter().zip(0..).flat_map(|(events, frame)| {
        let mut events = events.clone();
        events.sort_by_key(|&(x, y, _)| (std::cmp::Reverse(y), x));
        events.into_iter().map(move |(x, y, polarity)| EvcEvent { frame, x, y, polarity })
    });
    sorted.collect()
}

fn arbitrary_frames(most: usize) -> impl Strategy<Value = Frames> {
    let polarity = any::<bool>().prop_map(Polarity::from_on);
    prop::collection::vec(prop::collection::vec((0u16..300, 0u16..20, polarity), 0..4), 1..most)
}

/// Written out by hand from the description of the format.
#[test]
fn a_file_has_the_published_bytes() {
    let frames = vec![
        vec![
            (2, 1, Polarity::On),
            (2, 1, Polarity::On),
            (258, 19, Polarity::Off),
            (1, 19, Polarity::On),
        ],
        vec![],
        vec![(0, 0, Polarity::Off)],
    ];
    let want: [[u8; 4]; 8] = [
        [0, 0, 0, 255],
        [1, 0, 19, 1],
        [2, 1, 19, 0],
        [2, 0, 1, 1],
        [2, 0, 1, 1],
        [0, 0, 0, 255],
        [0, 0, 0, 255],
        [0, 0, 0, 0],
    ];
    assert_eq!(written(&frames), want.concat());
}

#[test]
fn an_unknown_polarity_is_named_with_its_byte_and_what_is_readable_before_it() {
    let mut bytes = written(&vec![vec![(1, 1, Polarity::On)]; 60]);
    bytes[57 * 8 + 7] = 7;
    let (_directory, path) = file("hand.evc", &bytes);
    let message = EvcReader::open_with(&path, SENSOR).unwrap_err().to_string();
    assert_eq!(
        message,
        format!(
            "{}: byte 460: polarity 7 is none of 0, 1, 255 (frames 0..57, 57 events readable before it)",
            path.display()
        )
    );
    let (reader, fault) = EvcReader::open_prefix(&path, SENSOR).unwrap();
    assert_eq!((reader.frames(), reader.events(), reader.on_events()), (57, 57, 57));
    assert!(fault.is_some());
}

#[test]
fn an_event_outside_the_sensor_is_refused_on_both_sides() {
    let (_directory, path) = file("hand.evc", written(&vec![vec![(250, 1, Polarity::On)]]));
    let error = EvcReader::open(&path).unwrap_err();
    let want = EvcFault::OutsideSensor { x: 250, y: 1, sensor: SensorSize::DAVIS240C };
    assert!(matches!(error, IoError::Evc { byte: 4, fault, .. } if fault == want), "{error}");

    let mut writer = EvcWriter::create(&path, SENSOR).unwrap();
    for (x, y) in [(300, 0), (0, 20), (0, 256)] {
        assert!(matches!(writer.frame_of([(x, y, Polarity::On)]), Err(IoError::Unwritable { .. })));
    }
    let tall = SensorSize { width: 1, height: 257 };
    assert!(matches!(EvcWriter::create(&path, tall), Err(IoError::SensorTooTall { .. })));
}

#[test]
fn a_file_that_does_not_begin_with_a_marker_is_refused() {
    let (_directory, path) = file("hand.evc", [1, 0, 1, 1, 0, 0, 0, 255]);
    let error = EvcReader::open(&path).unwrap_err();
    assert!(
        matches!(error, IoError::Evc { byte: 0, fault: EvcFault::NoMarker { polarity: 1 }, .. }),
        "{error}"
    );
}

#[test]
fn a_file_that_changes_under_the_reader_is_an_error() {
    let bytes = written(&vec![vec![(1, 1, Polarity::On)]; 100]);
    let (_directory, path) = file("hand.evc", &bytes);
    let reader = EvcReader::open_with(&path, SENSOR).unwrap();
    let mut window = EvcWindow::new();
    for faulty in [vec![7; bytes.len()], vec![0; bytes.len()], vec![255; bytes.len()], vec![]] {
        fs::write(&path, faulty).unwrap();
        assert!(reader.read_frames(3..90, &mut window).is_err());
        assert_eq!(window.events().count(), 0);
    }
}

#[test]
fn a_stream_survives_the_file_up_to_the_millisecond_and_the_order_inside_it() {
    let event = |t, x, y| Event { t: Micros(t), x, y, polarity: Polarity::On };
    let events = [event(5_000, 1, 1), event(5_999, 2, 2), event(6_000, 3, 3), event(9_500, 4, 4)];
    let stream = EventStream::from_events(SENSOR, events).unwrap();
    let (_directory, path) = file("hand.evc", []);
    let mut writer = EvcWriter::create(&path, SENSOR).unwrap();
    assert!(matches!(writer.stream(&stream, Micros(5_001)), Err(IoError::Unwritable { .. })));
    let since_1970 =
        EventStream::from_events(SENSOR, [event(1_700_000_000_000_000, 1, 1)]).unwrap();
    assert!(matches!(writer.stream(&since_1970, Micros(0)), Err(IoError::Unwritable { .. })));
    writer.stream(&stream, Micros(5_000)).unwrap();
    writer.finish().unwrap();
    let reader = EvcReader::open_with(&path, SENSOR).unwrap();
    let back = reader.read_stream(0..reader.frames()).unwrap();
    let want = [event(0, 2, 2), event(0, 1, 1), event(1_000, 3, 3), event(4_000, 4, 4)];
    assert_eq!(back, EventStream::from_events(SENSOR, want).unwrap());
}

#[test]
fn a_writer_that_is_dropped_leaves_nothing_behind() {
    let directory = tempfile::tempdir().unwrap();
    let mut writer = EvcWriter::create(directory.path().join("hand.evc"), SENSOR).unwrap();
    writer.frame_of([(1, 1, Polarity::On)]).unwrap();
    drop(writer);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}

proptest! {
    // Every case writes files.
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// More frames than several steps of the index.
    #[test]
    fn any_window_holds_exactly_its_frames(
        frames in arbitrary_frames(150), a in 0usize..150, b in 0usize..150,
    ) {
        let (_directory, path) = file("hand.evc", written(&frames));
        let reader = EvcReader::open_with(&path, SENSOR).unwrap();
        prop_assert_eq!(reader.frames(), frames.len() as u64);
        let (a, b) = (a.min(frames.len()), b.min(frames.len()));
        let (start, end) = (a.min(b), a.max(b));
        let mut window = EvcWindow::new();
        reader.read_frames(start as u64..end as u64, &mut window).unwrap();
        let want = in_file_order(&frames[start..end]);
        prop_assert_eq!(window.len(), want.len());
        prop_assert_eq!(window.events().collect::<Vec<_>>(), want);
    }

    #[test]
    fn frames_beyond_the_end_are_a_typed_error(frames in arbitrary_frames(40), beyond in 1u64..9) {
        let (_directory, path) = file("hand.evc", written(&frames));
        let reader = EvcReader::open_with(&path, SENSOR).unwrap();
        let end = reader.frames() + beyond;
        let refused = reader.read_frames(0..end, &mut EvcWindow::new());
        let named = matches!(refused, Err(IoError::NoSuchFrames { available, .. })
            if available == frames.len() as u64);
        prop_assert!(named);
    }

    /// Between two records a cut cannot be seen; inside one it is an error, and the whole frames
    /// before it are readable.
    #[test]
    fn a_file_cut_at_any_byte_gives_an_error_or_the_exact_prefix(frames in arbitrary_frames(6)) {
        let bytes = written(&frames);
        let (_directory, path) = file("hand.evc", &bytes);
        let all = in_file_order(&frames);
        for cut in (0..bytes.len()).rev() {
            File::options().write(true).open(&path).unwrap().set_len(cut as u64).unwrap();
            let (reader, fault) = EvcReader::open_prefix(&path, SENSOR).unwrap();
            prop_assert_eq!(fault.is_some(), cut == 0 || cut % 4 != 0);
            let mut window = EvcWindow::new();
            reader.read_frames(0..reader.frames(), &mut window).unwrap();
            let events: Vec<_> = window.events().collect();
            prop_assert_eq!(&events[..], &all[..events.len()]);
            if let Some(IoError::Evc { byte, frames, events: counted, .. }) = fault {
                prop_assert_eq!(byte, (cut - cut % 4) as u64);
                prop_assert_eq!(frames, reader.frames());
                prop_assert_eq!(counted, events.len() as u64);
                let whole = all.iter().filter(|e| u64::from(e.frame) < frames).count();
                prop_assert_eq!(events.len(), whole);
            } else {
                prop_assert_eq!(events.len() + reader.frames() as usize, cut / 4);
            }
        }
    }

    #[test]
    fn a_prefix_is_the_same_whatever_follows_it(
        frames in arbitrary_frames(100), noise in prop::collection::vec(any::<u8>(), 0..64), at in any::<prop::sample::Index>(),
    ) {
        let mut bytes = written(&frames);
        let at = at.index(bytes.len());
        bytes.splice(at.., noise);
        let (_directory, path) = file("hand.evc", &bytes);
        let (reader, _fault) = EvcReader::open_prefix(&path, SENSOR).unwrap();
        let mut window = EvcWindow::new();
        reader.read_frames(0..reader.frames(), &mut window).unwrap();
        let on = window.events().filter(|e| e.polarity.is_on()).count();
        prop_assert_eq!((window.len() as u64, on as u64), (reader.events(), reader.on_events()));
        // The frame that `at` falls into may have changed; those before it have not.
        let whole = bytes[..at].as_chunks::<4>().0.iter().filter(|r| r[3] == 255).count().saturating_sub(1);
        let want = in_file_order(&frames[..whole.min(frames.len())]);
        let got: Vec<_> = window.events().take(want.len()).collect();
        prop_assert_eq!(got, want);
    }
}
