//! Files of the viewer, read back by the SDK under the documented entity paths.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_live::rerun::{
    FrameContents, PoseFrame, PoseLayout, PoseRecording, PoseStatus, RerunError, RerunRecording,
    SendCounts, TIMELINE,
};
use re_sdk::StoreKind;
use re_sdk::external::re_log_encoding::DecoderApp;
use re_sdk::log::{Chunk, LogMsg};

const SENSOR: SensorSize = SensorSize { width: 8, height: 6 };
const INTERVAL: Micros = Micros(1_000);
const FRAMES: i64 = 5;

/// A dot that goes to the right, ON before it and OFF behind it; two of three events are ON.
fn events(frame: i64) -> EventStream {
    let column = frame as u16 + 1;
    let at = |k: i64, x, polarity| Event { t: Micros(frame * INTERVAL.0 + k), x, y: 2, polarity };
    let events = [
        at(0, column, Polarity::On),
        at(1, column, Polarity::On),
        at(2, column - 1, Polarity::Off),
    ];
    EventStream::from_events(SENSOR, events).unwrap()
}

fn send(recording: &mut RerunRecording, frame: i64, events: &EventStream) {
    let t = Micros((frame + 1) * INTERVAL.0);
    let frame = FrameContents { t, length: INTERVAL, events, event_image: b"a PNG file" };
    recording.send(&frame).unwrap();
}

/// Of every entity: rows in time, their latest time in ns, and the values of its components.
type Entities = BTreeMap<String, (usize, i64, usize)>;

fn read(path: &Path) -> Entities {
    let mut entities = Entities::new();
    let file = BufReader::new(File::open(path).unwrap());
    for message in DecoderApp::decode_eager(file).unwrap() {
        let LogMsg::ArrowMsg(store, message) = message.unwrap() else { continue };
        if store.kind() != StoreKind::Recording {
            continue;
        }
        let chunk = Chunk::from_arrow_msg(&message).unwrap();
        let (rows, last, values) = entities.entry(chunk.entity_path().to_string()).or_default();
        for (name, times) in chunk.timelines() {
            assert_eq!(name.as_str(), TIMELINE, "the only timeline");
            *rows += times.times_raw().len();
            *last = times.times_raw().iter().copied().fold(*last, i64::max);
        }
        if !chunk.is_static() {
            *values +=
                chunk.components().list_arrays().map(|list| list.values().len()).sum::<usize>();
        }
    }
    entities
}

#[test]
fn a_file_holds_every_event_image_event_and_rate_at_the_time_of_the_sensor() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("dot.rrd");
    let mut recording = RerunRecording::create(&path, "dot", SENSOR).unwrap();
    for frame in 0..FRAMES {
        send(&mut recording, frame, &events(frame));
    }
    assert!(!path.exists(), "the file appears when it is finished");
    assert_eq!(recording.finish().unwrap(), SendCounts { events: 15, points: 15 });
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1, "no temporary file stays");

    let entities = read(&path);
    let end_ns = FRAMES * INTERVAL.0 * 1000;
    // An event image has its bytes and its type.
    for (name, values) in [
        ("/event_image", 10),
        ("/events/on", 10),
        ("/events/off", 5),
        ("/rate/on", 5),
        ("/rate/off", 5),
    ] {
        assert_eq!(entities[name], (FRAMES as usize, end_ns, values), "{name}");
    }
    assert_eq!(entities["/events/sensor"].0, 0, "the sensor is the same at all times");
}

#[test]
fn of_very_many_events_every_second_is_a_point() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("many.rrd");
    let many = (0..150_000).map(|k| Event { t: Micros(k), x: 1, y: 1, polarity: Polarity::On });
    let many = EventStream::from_events(SENSOR, many).unwrap();
    let mut recording = RerunRecording::create(&path, "many", SENSOR).unwrap();
    send(&mut recording, 0, &many);
    assert_eq!(recording.finish().unwrap(), SendCounts { events: 150_000, points: 75_000 });
    assert_eq!(read(&path)["/events/on"].2, 75_000);
}

#[test]
fn a_dropped_recording_leaves_no_file() {
    let directory = tempfile::tempdir().unwrap();
    let mut recording =
        RerunRecording::create(&directory.path().join("a.rrd"), "a", SENSOR).unwrap();
    send(&mut recording, 0, &events(0));
    drop(recording);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}

#[test]
fn unwritable_paths_and_invalid_addresses_are_errors() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("file");
    fs::write(&file, "").unwrap();
    let refused = RerunRecording::create(&file.join("a.rrd"), "a", SENSOR).err().unwrap();
    assert!(matches!(refused, RerunError::File { .. }), "{refused}");
    assert!(refused.to_string().contains("a.rrd"), "{refused}");

    let refused = RerunRecording::connect(Some("no place"), "a", SENSOR).err().unwrap();
    assert!(refused.to_string().contains("expected HOST:PORT"), "{refused}");
    // Nothing listens on port 1.
    let refused = RerunRecording::connect(Some("127.0.0.1:1"), "a", SENSOR).err().unwrap();
    assert!(matches!(refused, RerunError::Viewer { .. }), "{refused}");
}

#[test]
fn a_file_of_poses_holds_bones_meshes_latencies_and_rates() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("poses.rrd");
    let layout = PoseLayout { bones: vec![[0, 1], [1, 2]], faces: vec![[0, 1, 2]] };
    let mut recording = PoseRecording::create(&path, "poses", SENSOR, layout).unwrap();
    for frame in 1..=FRAMES {
        let joints = [Some([1.0, 2.0]), Some([3.0, 4.0]), None];
        // No inferred pose in the second frame.
        let p99_ms = (frame != 2).then_some(3.5);
        let network = PoseStatus { joints_px: &joints, p99_ms, per_s: 100.0 };
        let propagated = PoseStatus { joints_px: &[], p99_ms: None, per_s: 0.0 };
        let vertices = [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 2.0]];
        recording
            .send(&PoseFrame {
                t: Micros(frame * INTERVAL.0),
                events_px: [&[[0.5, 0.5]], &[[1.5, 0.5], [2.5, 0.5]]],
                events_per_s: [1e3, 2e3],
                poses: [network, propagated],
                mesh_vertices: Some(&vertices),
            })
            .unwrap();
    }
    recording.finish().unwrap();
    let entities = read(&path);
    let (frames, end_ns) = (FRAMES as usize, FRAMES * INTERVAL.0 * 1000);
    for (name, rows, values) in [
        ("/events/off", frames, frames),
        ("/events/on", frames, 2 * frames),
        // Of two bones one has both of its joints.
        ("/events/network", frames, frames),
        ("/events/propagated", frames, 0),
        ("/latency/network", frames - 1, frames - 1),
        ("/poses/network", frames, frames),
        ("/rate/on", frames, frames),
        // Three vertices and a triangle.
        ("/hand", frames, 4 * frames),
    ] {
        assert_eq!(entities[name], (rows, end_ns, values), "{name}");
    }
    assert_eq!(entities["/latency/propagated"].2, 0, "without poses no latency");
}
