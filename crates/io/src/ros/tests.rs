//! Recordings of other programs: see `tests/golden/ros`.

use std::fs;

use evpose_core::{Micros, SensorSize};

use crate::golden::check;
use crate::{Input, IoError, OpenOptions, Recording, Windows, open_as, read_as};

fn path(name: &str) -> String {
    format!("{}/tests/golden/ros/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn of_topic(name: &str, topic: Option<&str>) -> Result<Recording, IoError> {
    let topic = topic.map(str::to_owned);
    open_as(path(name), &OpenOptions { topic, ..OpenOptions::default() })
}

#[test]
fn recordings_of_other_programs_are_read_event_for_event() {
    let files = [
        ("evt3-zstd.mcap", "mcap"),
        ("mono-plain.mcap", "mcap"),
        ("dvs-ros1-lz4.mcap", "mcap"),
        ("dvs-plain.bag", "rosbag"),
        ("libcaer-bz2.bag", "rosbag"),
        ("prophesee-lz4.bag", "rosbag"),
        ("evt3-sqlite/evt3-sqlite.db3", "rosbag2"),
    ];
    check("ros", &files);
}

#[test]
fn triggers_and_missing_messages_are_counted_and_the_sensor_is_that_of_the_messages() {
    let read = of_topic("evt3-zstd.mcap", None).unwrap();
    assert_eq!(read.stream.sensor(), SensorSize { width: 64, height: 48 });
    let said = |start: &str| read.remarks.iter().any(|remark| remark.starts_with(start));
    assert!(said("1 messages are missing") && said("2 edges of trigger"), "{:?}", read.remarks);
}

#[test]
fn of_several_topics_of_events_one_is_chosen() {
    let error = of_topic("two-topics.mcap", None).unwrap_err().to_string();
    for part in ["2 topics", "--topic", "/caer/events", "5 messages", "/dvs/events", "2 messages"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let read = |topic| of_topic("two-topics.mcap", Some(topic)).map(|read| read.stream.len());
    assert_eq!(read("/caer/events").unwrap(), 600);
    assert_eq!(read("/dvs/events").unwrap(), 240);
    assert!(read("/other").unwrap_err().to_string().contains("/caer/events"));
    let events = "events.txt";
    let options = OpenOptions { topic: Some("/dvs".to_owned()), ..OpenOptions::default() };
    let error = read_as(Input::memory(events, b"1 1 1 1\n2 1 1 1\n".to_vec()), &options);
    assert!(error.unwrap_err().to_string().contains("--topic"));
}

#[test]
fn windows_in_any_order_are_those_of_the_whole_recording() {
    let name = "evt3-zstd.mcap";
    let whole = of_topic(name, None).unwrap().stream;
    let mut windows = Windows::open(path(name), &OpenOptions::default()).unwrap();
    let mut events = crate::EventStream::empty(whole.sensor());
    for start in [16_790_000, 16_771_000, 16_780_000, 16_770_000] {
        let window = crate::TimeWindow { start: Micros(start), end: Micros(start + 6_000) };
        windows.read(window, &mut events).unwrap();
        assert!(!events.is_empty() && events == whole.slice(window), "{start}");
    }
}

#[test]
fn a_file_whose_recorder_was_killed_is_damaged_and_its_events_are_salvaged() {
    let bytes = fs::read(path("mono-plain.mcap")).unwrap();
    // Within the last message.
    let cut = bytes.windows(4).rposition(|word| word == b"mono").unwrap() + 20;
    let read = |salvage| {
        let options = OpenOptions { salvage, ..OpenOptions::default() };
        read_as(Input::memory("cut.mcap", bytes[..cut].to_vec()), &options)
    };
    let error = read(false).unwrap_err().to_string();
    assert!(error.contains("480 events readable"), "{error}");
    assert_eq!(read(true).unwrap().stream.len(), 480);
}

#[test]
fn a_bag_that_is_a_folder_is_read_by_its_name_and_its_files_follow_each_other() {
    let read = of_topic("evt3-sqlite", None).unwrap();
    assert_eq!((read.format, read.stream.len()), ("rosbag2", 600));
    // A second file, whose clock goes on: here that of the first, and so its clock starts again.
    let folder = tempfile::tempdir().unwrap();
    for name in ["bag_0.db3", "bag_10.db3", "stray.db3"] {
        fs::copy(path("evt3-sqlite/evt3-sqlite.db3"), folder.path().join(name)).unwrap();
    }
    let metadata = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.db3\n    - \
                    bag_10.db3\n";
    fs::write(folder.path().join("metadata.yaml"), metadata).unwrap();
    let sorted = OpenOptions { restarts: crate::Restarts::Sort, ..OpenOptions::default() };
    assert_eq!(open_as(folder.path(), &sorted).unwrap().stream.len(), 1200);
    fs::write(folder.path().join("bag_10.db3-wal"), b"unmerged").unwrap();
    let error = open_as(folder.path(), &sorted).unwrap_err().to_string();
    assert!(error.contains("wal_checkpoint"), "{error}");
}

#[test]
fn a_bag_without_an_index_is_read_through() {
    let mut bytes = fs::read(path("dvs-plain.bag")).unwrap();
    // The place of the index, eight bytes, becomes 0: that of a recorder that was killed.
    let at = bytes.windows(10).position(|word| word == b"index_pos=").unwrap() + 10;
    let index = u64::from_le_bytes(*bytes[at..].first_chunk().unwrap());
    bytes[at..at + 8].fill(0);
    bytes.truncate(index as usize);
    let read = read_as(Input::memory("killed.bag", bytes), &OpenOptions::default()).unwrap();
    assert_eq!((read.format, read.stream.len()), ("rosbag", 600));
}

#[test]
fn what_is_written_is_read_event_for_event() {
    let folder = tempfile::tempdir().unwrap();
    let whole = of_topic("evt3-zstd.mcap", None).unwrap().stream;
    for sensor in [whole.sensor(), SensorSize { width: 3000, height: 48 }] {
        let events = crate::EventStream::from_events(sensor, whole.iter()).unwrap();
        let path = folder.path().join("out.mcap");
        let mut sink = crate::create(&path, sensor).unwrap();
        sink.write(&events).unwrap();
        sink.finish().unwrap();
        let read = open_as(&path, &OpenOptions::default()).unwrap();
        assert_eq!((read.format, &read.stream), ("mcap", &events));
        assert_eq!(read.remarks, Vec::<String>::new());
    }
    let path = folder.path().join("nothing.mcap");
    crate::create(&path, whole.sensor()).unwrap().finish().unwrap();
    let empty = open_as(&path, &OpenOptions::default()).unwrap().stream;
    assert_eq!((empty.len(), empty.sensor()), (0, whole.sensor()));
}

#[test]
fn times_of_the_calendar_are_written_and_count_from_the_first_event() {
    let folder = tempfile::tempdir().unwrap();
    let whole = of_topic("mono-plain.mcap", None).unwrap().stream;
    let late = |e: crate::Event| crate::Event { t: Micros(e.t.0 + 1_700_000_000_123_456), ..e };
    let events = crate::EventStream::from_events(whole.sensor(), whole.iter().map(late)).unwrap();
    let path = folder.path().join("out.mcap");
    let mut sink = crate::create(&path, events.sensor()).unwrap();
    sink.write(&events).unwrap();
    sink.finish().unwrap();
    assert_eq!(open_as(&path, &OpenOptions::default()).unwrap().stream, whole);
    let facts = crate::info(&path, &OpenOptions::default()).unwrap().facts;
    let zero = ("time 0", "1700000000.123456 s after 1970 began".to_owned());
    assert!(facts.contains(&zero), "{facts:?}");
}

#[test]
fn other_topics_are_listed_beside_the_one_that_is_read() {
    let facts = crate::info(path("evt3-zstd.mcap"), &OpenOptions::default()).unwrap().facts;
    let others = facts.iter().find(|(name, _)| *name == "topics").map(|(_, text)| text.as_str());
    assert_eq!(others, Some("also /cam/image (sensor_msgs/msg/Image, 5 messages)"));
    let facts = crate::info(path("mono-plain.mcap"), &OpenOptions::default()).unwrap().facts;
    assert!(facts.iter().all(|(name, _)| *name != "topics"), "{facts:?}");
}

#[test]
fn images_are_on_the_clock_of_the_events() {
    let path = path("evt3-zstd.mcap");
    let frames = super::images(path.as_ref(), &OpenOptions::default()).unwrap();
    let frames: Vec<_> = frames.map(Result::unwrap).collect();
    let events = of_topic("evt3-zstd.mcap", None).unwrap().stream;
    // Each was stamped with the first event of its fifth of them, as the packet of these was.
    let firsts: Vec<Micros> = (0..5).map(|k| events.t()[k * 120]).collect();
    assert_eq!(frames.iter().map(|frame| frame.t).collect::<Vec<_>>(), firsts);
    assert_eq!((frames[2].width, frames[2].height), (16, 12));
    let code = |x: usize, y: usize, k: usize| ((x * 3 + y * 5 + 7 * k) % 256) as u8;
    assert_eq!(frames[2].pixels[5 * 16 + 7], code(7, 5, 2));
    let error = super::images("none.mcap".as_ref(), &OpenOptions::default());
    assert!(error.is_err());
}

#[test]
fn files_of_marks_alone_are_damage_of_their_kind() {
    for (mark, kind) in [
        (&b"\x89MCAP0\r\n"[..], "MCAP: no record begins here"),
        (b"#ROSBAG V2.0\n", "bag of ROS 1: the bag has no header"),
        (b"SQLite format 3\0", "bag of ROS 2 in SQLite: no size of pages"),
    ] {
        let bytes = [mark, &[0; 120]].concat();
        let error = read_as(Input::memory("log.mcap", bytes), &OpenOptions::default());
        let error = error.unwrap_err().to_string();
        assert!(error.starts_with("log.mcap: byte ") && error.contains(kind), "{error}");
    }
}
