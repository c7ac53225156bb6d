use evpose_core::{Event, EventStream, Polarity};
use glam::Vec2;

use super::super::TimedBody;
use super::*;

const SENSOR: SensorSize = SensorSize { width: 30, height: 22 };

fn golden(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/eros_frames").join(name)
}

/// Bodies every 20 ms from 20 ms on.
fn recording(bodies: usize) -> LabelledRecording {
    let table = std::fs::read_to_string(golden("events.csv")).unwrap();
    let events = table.lines().map(|line| {
        let values: Vec<i64> = line.split(',').map(|value| value.parse().unwrap()).collect();
        let [x, y] = [1, 2].map(|k: usize| values[k] as u16);
        Event { t: Micros(values[0]), x, y, polarity: Polarity::On }
    });
    let body = |k: usize| TimedBody {
        t: Micros(20_000 * (k as i64 + 1)),
        points_px: [Some(Vec2::new(3.0 * k as f32, 11.0)); 13],
    };
    LabelledRecording {
        name: "p".to_owned(),
        events: EventStream::from_events(SENSOR, events).unwrap(),
        bodies: (0..bodies).map(body).collect(),
    }
}

fn pixels(path: &Path) -> Vec<u8> {
    image::open(path).unwrap().into_luma8().into_raw()
}

/// See `tests/golden/eros_frames`.
#[test]
fn published_frames_are_those_of_numpy_and_opencv() {
    let folder = tempfile::tempdir().unwrap();
    let options =
        ErosFrameOptions { every: NonZeroUsize::new(2).unwrap(), ..ErosFrameOptions::PUBLISHED };
    let annotations = write_eros_frames(&recording(5), &options, folder.path()).unwrap();
    let names: Vec<&str> = annotations.iter().map(|a| a.image.as_str()).collect();
    assert_eq!(names, ["p_00002.png", "p_00004.png"]);
    for name in names {
        assert_eq!(pixels(&folder.path().join(name)), pixels(&golden(name)), "{name}");
    }
    assert_eq!(annotations[0].t_s, Some(0.06));
    assert_eq!(annotations[0].label.keypoints[5].position, Vec2::new(0.2, 0.5));
}

#[test]
fn frames_of_the_online_program_are_what_its_framer_draws() {
    let folder = tempfile::tempdir().unwrap();
    let recording = recording(4);
    let options = ErosFrameOptions { first: 3, ..ErosFrameOptions::default() };
    write_eros_frames(&recording, &options, folder.path()).unwrap();
    let mut eros = Eros::new(SENSOR, ErosConfig::ONLINE);
    let until = TimeWindow { start: Micros(0), end: Micros(80_001) };
    eros.push(&recording.events.slice(until));
    let mut want = vec![0; SENSOR.pixels()];
    ErosFramer::new(SENSOR, 30, 22).blurred(&eros, &mut want);
    assert_eq!(pixels(&folder.path().join("p_00003.png")), want);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn an_instant_without_joints_has_no_frame_but_its_events_count() {
    let folder = tempfile::tempdir().unwrap();
    let mut recording = recording(5);
    recording.bodies[3].points_px = [None; 13];
    let annotations =
        write_eros_frames(&recording, &ErosFrameOptions::PUBLISHED, folder.path()).unwrap();
    let names: Vec<&str> = annotations.iter().map(|a| a.image.as_str()).collect();
    assert_eq!(names, ["p_00002.png", "p_00004.png"]);
    assert_eq!(pixels(&folder.path().join("p_00004.png")), pixels(&golden("p_00004.png")));
}
