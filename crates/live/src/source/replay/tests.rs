use std::path::PathBuf;

use evpose_core::{Event, EventStream, Polarity};
use evpose_io::Restarts;

use super::*;

const SENSOR: SensorSize = SensorSize { width: 32, height: 24 };

fn event(t: i64) -> Event {
    Event { t: Micros(t), x: (t % 32) as u16, y: 3, polarity: Polarity::On }
}

/// A recording of events at these times.
fn recording(folder: &tempfile::TempDir, times: impl IntoIterator<Item = i64>) -> PathBuf {
    let path = folder.path().join("recording.evs");
    let events = EventStream::from_events(SENSOR, times.into_iter().map(event)).unwrap();
    evpose_io::format_for(&path).unwrap().write(&path, &events).unwrap();
    path
}

/// One recording behind another, in a file: time jumps back.
fn joined(folder: &tempfile::TempDir, parts: &[Vec<i64>]) -> PathBuf {
    let mut text = "32 24\n".to_owned();
    for t in parts.iter().flatten() {
        text += &format!("{t} {} 3 1\n", t % 32);
    }
    let path = folder.path().join("joined.txt");
    std::fs::write(&path, text).unwrap();
    path
}

fn fast() -> ReplayOptions {
    ReplayOptions { speed: f64::INFINITY, ..ReplayOptions::default() }
}

/// The times of the packets, and how it ended.
fn packets(path: &Path, options: ReplayOptions) -> (Vec<Vec<i64>>, Result<(), LiveError>) {
    let mut replay = Replay::open(path, options).unwrap();
    let (mut all, mut columns) = (Vec::new(), Columns::new());
    loop {
        columns.clear();
        let read = replay.next(&mut columns);
        if !columns.is_empty() {
            all.push(columns.t.iter().map(|t| t.0).collect());
        }
        match read {
            Ok(Some(_)) => {}
            Ok(None) => return (all, Ok(())),
            Err(error) => return (all, Err(error)),
        }
    }
}

#[test]
fn packets_end_where_their_time_does() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(&folder, [100, 600, 1_099, 1_100, 2_500, 9_000, 9_999, 10_000]);
    let (packets, ended) = packets(&path, fast());
    ended.unwrap();
    let want: [&[i64]; 4] = [&[100, 600, 1_099], &[1_100], &[2_500], &[9_000, 9_999]];
    assert_eq!(packets[..4], want);
    assert_eq!(packets[4..], [[10_000]]);
}

#[test]
fn what_is_played_again_goes_on_where_it_ended() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(&folder, [5_000, 5_500, 7_000]);
    let (packets, ended) = packets(&path, ReplayOptions { times: 3, ..fast() });
    ended.unwrap();
    let want = [5_000, 5_500, 7_000, 8_000, 8_500, 10_000, 11_000, 11_500, 13_000];
    assert_eq!(packets.concat(), want);
}

#[test]
fn a_span_counts_in_the_time_of_the_recording_and_over_its_repetitions() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(&folder, [5_000, 5_500, 7_000]);
    for (span, want) in [
        (2_000, [5_000, 5_500].as_slice()),
        (2_001, &[5_000, 5_500, 7_000]),
        (5_001, &[5_000, 5_500, 7_000, 8_000, 8_500, 10_000]),
    ] {
        let span = Some(Micros(span));
        let mut replay = Replay::open(&path, ReplayOptions { times: 9, span, ..fast() }).unwrap();
        let (mut columns, horizon) = (Columns::new(), replay.horizon().unwrap());
        while replay.next(&mut columns).unwrap().is_some() {
            assert_eq!(horizon.load(Ordering::Relaxed), columns.t.last().unwrap().0);
        }
        assert!(columns.t.iter().map(|t| t.0).eq(want.iter().copied()), "{:?}", columns.t);
    }
}

#[test]
fn every_repetition_has_the_packets_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    // A gap moves the grid of packets: the last one would end after the next repetition begins.
    let path = recording(&folder, [5_100, 5_900, 10_250, 10_260]);
    let mut replay = Replay::open(&path, ReplayOptions { times: 3, ..fast() }).unwrap();
    assert!(replay.is_lossless());
    let (mut columns, mut packets) = (Columns::new(), Vec::new());
    while replay.next(&mut columns).unwrap().is_some() {
        let times: Vec<i64> = columns.t.iter().map(|t| t.0).collect();
        packets.push((replay.repetition(), times));
        columns.clear();
    }
    let first = [[5_100, 5_900], [10_250, 10_260]];
    let shifted = |k: u64| {
        first.iter().map(move |packet| {
            (k, packet.iter().map(|t| t + 6_000 * k as i64).collect::<Vec<i64>>())
        })
    };
    assert_eq!(packets, (0..3).flat_map(shifted).collect::<Vec<_>>());
}

#[test]
fn real_time_is_kept_and_scaled() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(&folder, (0..101).map(|k| 1_000 * k));
    for (speed, min_ms) in [(1.0, 100), (2.0, 50)] {
        let began = Instant::now();
        let mut replay =
            Replay::open(&path, ReplayOptions { speed, ..ReplayOptions::default() }).unwrap();
        let (mut columns, mut due) = (Columns::new(), Vec::new());
        while let Some(host_time) = replay.next(&mut columns).unwrap() {
            assert!(host_time <= Instant::now(), "nothing comes before it is due");
            due.push(host_time);
        }
        assert!(began.elapsed() >= Duration::from_millis(min_ms));
        let lasted = due[due.len() - 1] - due[0];
        // A machine that is busy for long sets its clock back.
        let expected = Duration::from_millis(min_ms) + replay.slipped();
        assert_eq!((due.len(), lasted), (101, expected));
    }
}

#[test]
fn a_recording_that_is_read_too_slowly_is_late_for_a_while_at_most() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(&folder, (0..11).map(|k| 10_000 * k));
    let mut replay = Replay::open(&path, ReplayOptions::default()).unwrap();
    let mut columns = Columns::new();
    replay.next(&mut columns).unwrap().unwrap();
    assert_eq!(replay.slipped(), Duration::ZERO);
    std::thread::sleep(Duration::from_millis(300));
    let host_time = replay.next(&mut columns).unwrap().unwrap();
    assert!(host_time.elapsed() < Duration::from_millis(250), "it happens now");
    let slipped = replay.slipped();
    assert!(slipped >= Duration::from_millis(290), "{slipped:?}");
    // From here on it goes at its pace again.
    let next = replay.next(&mut columns).unwrap().unwrap();
    assert!(next >= host_time + Duration::from_millis(10));
}

#[test]
fn where_the_clock_starts_again_a_replay_asks_which_part_is_meant() {
    let folder = tempfile::tempdir().unwrap();
    let late = (0..400).map(|k| 60_000_000 + 1_000 * k).collect();
    let path = joined(&folder, &[late, (0..400).map(|k| 1_000 * k).collect()]);
    let (_, ended) = packets(&path, fast());
    let message = ended.unwrap_err().to_string();
    assert!(message.contains("event 400") && message.contains("--part 1"), "{message}");
    for (restarts, events) in [(Restarts::Part(2), 400), (Restarts::Join, 800)] {
        let open = OpenOptions { restarts, ..OpenOptions::default() };
        let (packets, ended) = packets(&path, ReplayOptions { open, ..fast() });
        ended.unwrap();
        assert_eq!(packets.iter().map(Vec::len).sum::<usize>(), events);
    }
}

#[test]
fn events_of_one_time_do_not_fill_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(&folder, std::iter::repeat_n(7, 600_000));
    let (packets, ended) = packets(&path, fast());
    ended.unwrap();
    let lengths: Vec<usize> = packets.iter().map(Vec::len).collect();
    assert_eq!(lengths, [MAX_EVENTS, MAX_EVENTS, 600_000 - 2 * MAX_EVENTS]);
}

#[test]
fn a_cut_recording_is_given_to_its_end_before_its_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = recording(&folder, (0..1_000).map(|k| 100 * k));
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 20]).unwrap();
    let (packets, ended) = packets(&path, fast());
    assert!(packets.concat().into_iter().eq((0..997).map(|k| 100 * k)));
    let message = ended.unwrap_err().to_string();
    assert!(message.contains("997 events readable before it"), "{message}");
}

#[test]
fn impossible_times_and_settings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = joined(&folder, &[vec![0, 10, i64::MAX - 5]]);
    let message = packets(&path, fast()).1.unwrap_err().to_string();
    assert!(message.contains("no recording lasts so long"), "{message}");
    for options in [
        ReplayOptions { speed: 0.0, ..fast() },
        ReplayOptions { speed: f64::NAN, ..fast() },
        ReplayOptions { packet: Micros(0), ..fast() },
    ] {
        assert!(matches!(Replay::open(&path, options), Err(LiveError::Setting { .. })));
    }
}
