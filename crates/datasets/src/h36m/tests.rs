//! Comparison with files in the published layout and values of other programs; see
//! `tests/golden/h36m`.

use std::path::{Path, PathBuf};

use evpose_core::{Event, EventStream, Micros, Plane, Polarity, SensorSize};
use evpose_io::frames::write_codes;
use evpose_io::{Encoding, FrameSource};
use evpose_pose::body::{BODY_JOINTS, network_from_file, number};
use evpose_sensor::{SensorConfig, SensorModel};
use glam::{IVec2, Vec2};

use super::resize::Resizer;
use super::*;
use crate::recording::{ErosFrameOptions, LabelledRecording, write_eros_frames};

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name)
}

fn walking() -> ClipName {
    "cam2_S9_Walking_1".parse().unwrap()
}

#[test]
fn a_published_clip_is_read() {
    let folder = golden("h36m/yarp");
    assert_eq!(published_clips(&folder).unwrap(), [walking()]);
    let clip = read_published(&folder, &walking(), None).unwrap();
    assert!(clip.remarks.is_empty(), "{:?}", clip.remarks);
    let LabelledRecording { name, events, bodies } = clip.recording;
    assert_eq!((name.as_str(), events.sensor()), ("cam2_S9_Walking_1", SENSOR));
    let want = (0..220_u16).map(|k| Event {
        t: Micros(397 * i64::from(k)),
        x: (17 * k) % 640,
        y: (29 * k) % 480,
        polarity: Polarity::from_on(k % 3 == 0),
    });
    assert!(events.iter().eq(want));
    assert_eq!(bodies.len(), 5);
    for (g, body) in bodies.iter().enumerate() {
        assert_eq!(body.t, Micros(20_000 * g as i64));
        let joints: [_; BODY_JOINTS] = std::array::from_fn(|j| {
            Some(Vec2::new((20 * j + g) as f32, (300 - 10 * j + 2 * g) as f32))
        });
        assert_eq!(body.points_px, network_from_file(&joints));
    }
    // Ticks 12.5 times as long, where somebody says so.
    let clip = read_published(&folder, &walking(), Some(1.0)).unwrap();
    assert_eq!(clip.recording.events.t()[2], Micros(9925));
}

#[test]
fn what_was_written_is_read_back() {
    let published = read_published(&golden("h36m/yarp"), &walking(), None).unwrap().recording;
    let directory = tempfile::tempdir().unwrap();
    let name = ClipName::new(4, 11, "Taking Photo").unwrap();
    let mut recording = LabelledRecording { name: name.to_string(), ..published };
    recording.bodies[1].points_px[number::HEAD] = None;
    recording.bodies[2].points_px[number::HIP_L] = None;
    write_published(directory.path(), &name, &recording).unwrap();
    assert_eq!(published_clips(directory.path()).unwrap(), std::slice::from_ref(&name));
    let found = read_published(directory.path(), &name, None).unwrap();
    assert_eq!(found.recording, recording);
    assert!(found.remarks.is_empty(), "{:?}", found.remarks);
    let labels = directory.path().join("cam4_S11_Taking_Photo/ch4GT50Hzskeleton");
    let log = std::fs::read_to_string(labels.join("data.log")).unwrap();
    let lines: Vec<&str> = log.lines().collect();
    assert!(lines[0].starts_with("0 0000.0 SKLT (0 300 20 290 "), "{}", lines[0]);
    assert!(lines[1].starts_with("1 000.02 SKLT (-1 -1 21 292 "), "{}", lines[1]);
    assert!(lines[1].contains(") -1.0 89.44"), "{}", lines[1]);
    assert!(lines[2].ends_with(") -1.0 -1.0"), "{}", lines[2]);
    let info = std::fs::read_to_string(labels.join("info.log")).unwrap();
    assert_eq!(info, "Type: Bottle;\n[0.0] /file/ch4GT50Hzskeleton:o [connected]\n");
}

#[test]
fn clips_that_no_log_can_hold_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let empty = |sensor| LabelledRecording {
        name: String::new(),
        events: EventStream::empty(sensor),
        bodies: Vec::new(),
    };
    let write = |recording| write_published(directory.path(), &walking(), &recording);
    let failed = write(empty(SensorSize::DAVIS240C)).unwrap_err().to_string();
    assert!(failed.contains("240x180"), "{failed}");
    let mut early = empty(SENSOR);
    early.events.push(Event { t: Micros(-5), x: 0, y: 0, polarity: Polarity::On }).unwrap();
    let failed = write(early).unwrap_err().to_string();
    assert!(failed.contains("-5"), "{failed}");
    assert_eq!(published_clips(directory.path()).unwrap(), []);
}

#[test]
fn a_clip_becomes_frames_and_annotations() {
    let clip = read_published(&golden("h36m/yarp"), &walking(), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let options = ErosFrameOptions::PUBLISHED;
    let annotations = write_eros_frames(&clip.recording, &options, folder.path()).unwrap();
    let names: Vec<&str> = annotations.iter().map(|a| a.image.as_str()).collect();
    assert_eq!(names, [2, 3, 4].map(|k| format!("cam2_S9_Walking_1_{k:05}.png")));
    let label = &annotations[0].label;
    assert_eq!(label.keypoints.len(), BODY_JOINTS);
    assert_eq!(label.keypoints[number::HEAD].position, Vec2::new(2.0 / 640.0, 304.0 / 480.0));
    // Wrists are joints 7 and 8 of a file, shoulders 1 and 2: (100, -50) and (140, -70) px apart.
    let length = |x: f32, y: f32| (x / 640.0).hypot(y / 480.0);
    let want = 0.5 * (length(100.0, 50.0) + length(140.0, 70.0));
    assert!((label.torso_size.unwrap() - want).abs() < 1e-6);
}

/// A file of the tests of `evpose-containers`.
fn cdf_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../containers/tests/golden/cdf").join(name)
}

#[test]
fn poses_are_read_and_files_of_other_variables_are_not() {
    for file in ["one_record.cdf", "records.cdf", "whole.cdf"] {
        let poses = read_poses(&cdf_file(file)).unwrap();
        assert_eq!(poses.len(), 7);
        assert_eq!(poses[6][31], Vec2::new(662.25, 663.25), "{file}");
    }
    let failed = read_poses(&cdf_file("cube.cdf")).unwrap_err().to_string();
    assert!(failed.contains("cube.cdf") && failed.contains("`Pose`"), "{failed}");
}

/// `cv2.resize(…, INTER_AREA)` of OpenCV 5.0.0 on `(37 x + 101 y) mod 251 / 251`, at six pixels.
#[test]
fn parts_are_resized_as_opencv_does_it() {
    const PIXELS: [(usize, usize); 6] =
        [(0, 0), (639, 0), (0, 479), (639, 479), (200, 100), (77, 333)];
    let code = |x: usize, y: usize| ((x * 37 + y * 101) % 251) as f32 / 251.0;
    let data = (0..1000).flat_map(|y| (0..1002).map(move |x| code(x, y))).collect();
    let frame = Plane::from_vec(1002, 1000, data).unwrap();
    let mut out = Plane::for_sensor(SENSOR, 0.0);
    for ([left, right, top, bottom], want) in [
        ([113, 115, 190, 230], [0.206_452, 0.246_895, 0.224_174, 0.264_617, 0.439_376, 0.684_078]),
        ([0, 2, 40, 60], [0.336_467, 0.493_280, 0.709_907, 0.525_386, 0.595_028, 0.427_623]),
        ([200, 162, 300, 220], [0.199_203, 0.394_422, 0.944_223, 0.139_442, 0.920_319, 0.545_817]),
    ] {
        let crop = Crop { left, right, top, bottom };
        Resizer::new(&crop, IVec2::new(1002, 1000)).resize(&frame, &mut out);
        for ((x, y), want) in PIXELS.into_iter().zip(want) {
            let found = *out.at(x, y);
            assert!((found - want).abs() < 2e-6, "{crop} ({x}, {y}): {found}, {want}");
        }
    }
}

const VIDEO: SensorSize = SensorSize { width: 1000, height: 900 };
/// Half the size of what it is resized from.
const CROP: Crop = Crop { left: 20, right: 340, top: 300, bottom: 120 };

/// Frames with a grey square, brighter in the second one; columns 340 to 403 and rows 420 to 483.
fn video(directory: &Path) -> FrameSource {
    let path = directory.join("video.npy");
    let is_square = |x: u16, y: u16| (340..404).contains(&x) && (420..484).contains(&y);
    let frame = |code: u8| -> Vec<u8> {
        let pixels = (0..VIDEO.height).flat_map(|y| (0..VIDEO.width).map(move |x| (x, y)));
        pixels.map(|(x, y)| if is_square(x, y) { code } else { 50 }).collect()
    };
    write_codes(&path, VIDEO, &[50, 150, 150].map(frame)).unwrap();
    FrameSource::open(path, Encoding::Linear, None).unwrap()
}

#[test]
fn light_that_changes_becomes_events_where_and_when_it_does() {
    let directory = tempfile::tempdir().unwrap();
    let sensor = SensorConfig::preset("ideal").unwrap();
    let how = Synthesis { sensor, ..Synthesis::published(3).unwrap() };
    let events = events_of_frames(&mut video(directory.path()), &CROP, &how).unwrap();
    assert_eq!(events.sensor(), SENSOR);
    assert!(events.t().iter().all(|t| (1..=20_000).contains(&t.0)));
    assert!(events.polarity().iter().all(|polarity| polarity.is_on()));
    // The part begins at (20, 300) and is not resized.
    let mut counts = Plane::for_sensor(SENSOR, 0);
    events.iter().for_each(|event| *counts.at_mut(event.x.into(), event.y.into()) += 1);
    for y in 0..480 {
        for x in 0..640 {
            let is_square = (320..384).contains(&x) && (120..184).contains(&y);
            // Three times as bright: ln 3 is five thresholds of 0.2 and a half.
            assert_eq!(*counts.at(x, y), if is_square { 5 } else { 0 }, "({x}, {y})");
        }
    }
}

#[test]
fn the_published_sensor_can_be_built_and_is_repeatable() {
    let how = Synthesis::published(7).unwrap();
    let table = SensorModel::from_config(&how.sensor).unwrap();
    let active = table.describe().rows.iter().filter(|row| row.is_active).count();
    assert_eq!(active, how.sensor.effects.len());
    let directory = tempfile::tempdir().unwrap();
    let [a, b] = [7, 7].map(|seed| {
        let how = Synthesis { seed, steps: 4, ..how.clone() };
        events_of_frames(&mut video(directory.path()), &CROP, &how).unwrap()
    });
    assert_eq!(a, b);
    let is_near = |e: Event| (318..386).contains(&e.x) && (118..186).contains(&e.y);
    let near = a.iter().filter(|event| is_near(*event)).count();
    assert!(near > 64 * 64 && near as f64 > 0.99 * a.len() as f64, "{near} of {}", a.len());
}

#[test]
fn frames_that_do_not_fit_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let how = Synthesis::published(1).unwrap();
    let refused = |crop: Crop, how: &Synthesis| {
        events_of_frames(&mut video(directory.path()), &crop, how).unwrap_err().to_string()
    };
    let outside = Crop { left: -3, ..CROP };
    let failed = refused(outside, &how);
    assert!(failed.contains("-3,340,300,120") && failed.contains("1000x900"), "{failed}");
    let failed = refused(CROP, &Synthesis { steps: 20_001, ..how.clone() });
    assert!(failed.contains("20001 steps"), "{failed}");
    let failed =
        refused(CROP, &Synthesis { sensor: SensorConfig { effects: Vec::new() }, fps: 0.0, ..how });
    assert!(failed.contains("video.npy"), "{failed}");
}

#[test]
fn labels_lie_on_the_part_of_the_video() {
    let mut pose = [Vec2::ZERO; H36M_JOINTS];
    pose[14] = Vec2::new(340.0, 420.0);
    let frame_px = IVec2::new(1000, 900);
    let bodies = bodies_of_poses(&[pose; 3], &CROP, frame_px, CropRule::Paper, FPS);
    assert_eq!(bodies.iter().map(|body| body.t.0).collect::<Vec<_>>(), [0, 20_000, 40_000]);
    assert_eq!(bodies[2].points_px[number::HEAD], Some(Vec2::new(320.0, 120.0)));
    let bodies = bodies_of_poses(&[pose], &CROP, frame_px, CropRule::Published, FPS);
    // 639 columns and 479 rows are left there: 320.5 and 120.25, to whole pixels.
    assert_eq!(bodies[0].points_px[number::HEAD], Some(Vec2::new(321.0, 120.0)));
}
