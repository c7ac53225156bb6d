use std::fs;
use std::path::Path;

use evpose_core::{Event, EventStream, Micros, Plane, Polarity, SensorSize};
use evpose_io::{OpenOptions, TimeUnit};
use evpose_sensor::{SensorConfig, SensorModel};

use super::*;

const SIZE: SensorSize = SensorSize { width: 40, height: 30 };

/// Blobs of light at places without any symmetry, which move and grow.
fn light(x: usize, y: usize, t_s: f64) -> f64 {
    let blob = |cx: f64, cy: f64, r: f64, vx: f64, vy: f64| {
        let (dx, dy) = (x as f64 - cx - vx * t_s, y as f64 - cy - vy * t_s);
        (-(dx * dx + dy * dy) / (r * r)).exp()
    };
    0.1 + 0.7 * blob(6.0, 5.0, 5.0, 18.0, 7.0) + 0.5 * blob(30.0, 22.0, 7.0, -5.0, -16.0)
}

/// Events of the ideal sensor in 0.6 s.
fn reference() -> EventStream {
    let mut run = SensorModel::from_config(&SensorConfig::default()).unwrap().start(SIZE, 1);
    let mut all = EventStream::empty(SIZE);
    for k in 0..=300 {
        let mut plane = Plane::for_sensor(SIZE, 0.0);
        for (i, value) in plane.data_mut().iter_mut().enumerate() {
            *value = light(i % 40, i / 40, f64::from(k) * 0.002) as f32;
        }
        for event in run.expose(&plane, Micros(i64::from(k) * 2_000)).unwrap().iter() {
            all.push(event).unwrap();
        }
    }
    all
}

fn recording(events: EventStream) -> LoadedRecording {
    let tick = Micros(1);
    LoadedRecording { events, outside: 0, tick, provenance: Vec::new(), notes: Vec::new() }
}

/// A scene directory of 20 frames of 4 x 3 pixels at 100 frames per second.
fn directory(json: &str, frames: usize) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("scene.json"), json).unwrap();
    let size = SensorSize { width: 4, height: 3 };
    let frames: Vec<Vec<u8>> = (0..frames).map(|k| vec![100 + k as u8; 12]).collect();
    evpose_io::frames::write_codes(&dir.path().join("frames.npy"), size, &frames).unwrap();
    dir
}

const JSON: &str = r#"{"width": 4, "height": 3, "fps": 100.0, "duration_s": 0.2}"#;

#[test]
fn a_description_may_begin_with_a_mark_of_byte_order() {
    let dir = directory(&format!("\u{feff}{JSON}"), 21);
    assert_eq!(load_scene(dir.path()).unwrap().scene.planes().len(), 21);
}

#[test]
fn a_scene_directory_becomes_planes_of_light() {
    let json = r#"{"width": 4, "height": 3, "fps": 100, "duration_s": 0.2, "white": 200.0,
        "lens": "f/2", "nominal": {"C_on": 0.2, "C_off": 0.25, "sigma_C": 0.0, "noise_on_hz": 1}}"#;
    let loaded = load_scene(directory(json, 21)).unwrap();
    assert_eq!(loaded.scene.size(), SensorSize { width: 4, height: 3 });
    assert_eq!((loaded.scene.planes().len(), loaded.scene.duration()), (21, Micros(200_000)));
    assert_eq!(loaded.scene.planes()[10].data()[5], 110.0 / 200.0);
    let nominal = Nominal {
        threshold_on: Some(0.2),
        threshold_off: Some(0.25),
        threshold_sigma: Some(0.0),
        noise_on_hz: Some(1.0),
        noise_off_hz: None,
    };
    assert_eq!(loaded.nominal, Some(nominal));
    assert_eq!(loaded.notes.len(), 1);
    assert!(loaded.notes[0].contains("`lens` is not used"));
}

#[test]
fn float_frames_of_bytes_without_a_stated_white_are_fractions_of_white() {
    let dir = tempfile::tempdir().unwrap();
    let write = |values: [f32; 3]| {
        fs::write(dir.path().join("scene.json"), JSON).unwrap();
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (21, 3, 4), }";
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        for k in 0..21 * 12 {
            bytes.extend(values[k % 3].to_le_bytes());
        }
        fs::write(dir.path().join("frames.npy"), bytes).unwrap();
        load_scene(dir.path()).unwrap()
    };
    let light = |loaded: &LoadedScene| loaded.scene.planes()[3].data()[1];
    let loaded = write([20.0, 51.0, 230.0]);
    assert!((light(&loaded) - 0.2).abs() < 1e-6);
    assert!(loaded.notes[0].contains("`white` is not stated: it is taken to be 255"));
    assert!((light(&write([20.0, 51.0, 510.0])) - 0.1).abs() < 1e-6);
    assert_eq!(light(&write([0.1, 0.9, 1.5])), 0.9);
}

/// A grey image of 4 x 3 pixels, a fifth of white.
const PNG: &[u8] =
    b"\x89PNG\x0d\x0a\x1a\x0a\x00\x00\x00\x0dIHDR\x00\x00\x00\x04\x00\x00\x00\x03\x08\x00\x00\
    \x00\x00\x91\x9f\xf1\x1a\x00\x00\x00\x0eIDATx\xdac0\x06\x02\x068\x01\x00\x11\xfd\x02e]\
    \x07a\xec\x00\x00\x00\x00IEND\xaeB`\x82";

#[test]
fn images_are_frames_as_well() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("scene.json"), JSON).unwrap();
    let frames = dir.path().join("frames");
    fs::create_dir(&frames).unwrap();
    let error = load_scene(dir.path()).unwrap_err().to_string();
    assert!(error.contains("frames: no .png image"), "{error}");
    for k in 0..21 {
        fs::write(frames.join(format!("{k}.png")), PNG).unwrap();
    }
    let loaded = load_scene(dir.path()).unwrap();
    assert_eq!((loaded.scene.planes().len(), loaded.notes.len()), (21, 0));
    assert!((loaded.scene.planes()[7].data()[3] - 0.2).abs() < 1e-6);
    assert_eq!(loaded.frames_path, frames);
}

#[test]
fn one_frame_more_or_less_is_taken_and_said() {
    for (frames, notes) in [(19, 1), (20, 1), (21, 0)] {
        let loaded = load_scene(directory(JSON, frames)).unwrap();
        assert_eq!((loaded.scene.planes().len(), loaded.notes.len()), (frames, notes));
    }
    for frames in [18, 22] {
        let error = load_scene(directory(JSON, frames)).unwrap_err().to_string();
        assert!(error.contains("scene.json: field `duration_s`"), "{error}");
        assert!(error.contains(&format!("has {frames}")), "{error}");
    }
}

#[test]
fn a_wrong_field_is_named_with_its_file() {
    let replaced = |from: &str, to: &str| JSON.replace(from, to);
    for (json, field) in [
        (replaced("\"fps\": 100.0, ", ""), "field `fps`: missing"),
        (replaced("100.0", "\"100\""), "field `fps`: expected a positive number, found \"100\""),
        (replaced("0.2", "-0.2"), "field `duration_s`: expected a positive number, found -0.2"),
        (replaced(": 4", ": 4.5"), "field `width`: expected 1 to 65535 pixels, found 4.5"),
        (replaced(": 4", ": 5"), "field `width`: 5x3, but frames"),
        (
            replaced("\"width\": 4, \"height\": 3", "\"width\": 3, \"height\": 4"),
            "are 4x3: width and height are swapped",
        ),
        (replaced("}", ", \"white\": 0}"), "field `white`: expected a positive number, found 0"),
        (replaced("}", ", \"nominal\": 3}"), "field `nominal`: expected an object, { … }, found 3"),
        (
            replaced("}", ", \"nominal\": {\"C_ON\": 0.2}}"),
            "field `nominal.C_ON`: unknown; there are C_on, C_off",
        ),
        (
            replaced("}", ", \"nominal\": {\"sigma_C\": []}}"),
            "field `nominal.sigma_C`: expected a number not below zero, found []",
        ),
        (replaced("}", ""), "EOF while parsing"),
        ("[]".to_owned(), "expected an object"),
    ] {
        let error = load_scene(directory(&json, 21)).unwrap_err().to_string();
        assert!(error.contains("scene.json: ") && error.contains(field), "{error}");
    }
}

#[test]
fn frames_that_end_too_early_are_named() {
    let dir = directory(JSON, 21);
    let path = dir.path().join("frames.npy");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 30]).unwrap();
    let error = load_scene(&dir).unwrap_err().to_string();
    assert!(error.contains("frames.npy: truncated: 18 of its 21 frames"), "{error}");
    fs::remove_file(&path).unwrap();
    let error = load_scene(&dir).unwrap_err().to_string();
    assert!(error.contains("neither frames.npy nor a folder frames/"), "{error}");
}

/// As the file states it.
fn load(path: &Path, sensor: Option<SensorSize>) -> Result<LoadedRecording, crate::GapError> {
    load_recording(path, sensor, &OpenOptions::default())
}

fn write(path: &Path, events: &[(i64, u16, u16)]) {
    let lines: Vec<String> = events.iter().map(|(t, x, y)| format!("{t} {x} {y} 1")).collect();
    fs::write(path, lines.join("\n")).unwrap();
}

#[test]
fn a_recording_without_a_sensor_takes_the_scenes_as_far_as_it_fits() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("events.txt");
    let turned = SensorSize { width: 30, height: 40 };
    for (x, y, size) in
        [(39, 29, SIZE), (20, 35, turned), (60, 60, SensorSize { width: 61, height: 61 })]
    {
        write(&path, &[(0, 0, 0), (1, x, y)]);
        let loaded = load(&path, Some(SIZE)).unwrap();
        assert_eq!(loaded.events.sensor(), size);
        assert_eq!((loaded.events.len(), loaded.notes.len()), (2, 1));
    }
}

#[test]
fn a_recording_of_nothing_is_refused_and_a_disordered_one_counted() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("events.txt");
    fs::write(&path, "40 30\n").unwrap();
    let error = load(&path, None).unwrap_err().to_string();
    assert!(error.contains("events.txt: no events"), "{error}");
    write(&path, &[(0, 0, 0), (9, 1, 1), (5, 2, 2)]);
    let loaded = load(&path, Some(SIZE)).unwrap();
    assert!(loaded.notes[0].contains("1 events stood up to"), "{:?}", loaded.notes);
    assert!(loaded.events.t().is_sorted());
}

#[test]
fn a_recording_is_read_in_the_unit_and_the_axes_that_are_given() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("events.txt");
    write(&path, &[(0, 0, 0), (7, 2, 29)]);
    let options = OpenOptions {
        time_unit: Some(TimeUnit::Milliseconds),
        swap_xy: true,
        ..Default::default()
    };
    let events = load_recording(&path, Some(SIZE), &options).unwrap().events;
    assert_eq!(
        (events.t(), events.x(), events.y()),
        (&[Micros(0), Micros(7000)][..], &[0, 29][..], &[0, 2][..])
    );
}

#[test]
fn a_recording_of_the_scene_has_no_problems() {
    let reference = reference();
    let problems = Problems::find(&recording(reference.clone()), 0.6, &reference);
    assert!(problems.is_empty(), "{problems}");
}

#[test]
fn every_symmetry_is_undone_by_its_inverse() {
    for symmetry in Symmetry::all() {
        for pixel in [(0, 0), (39, 0), (7, 21)] {
            let there = symmetry.place(SIZE, pixel);
            assert_eq!(symmetry.inverse().place(symmetry.size(SIZE), there), pixel);
        }
    }
}

#[test]
fn each_of_the_sixteen_symmetries_is_detected_and_corrected() {
    let reference = reference();
    for symmetry in Symmetry::all() {
        let mixed = recording(symmetry.apply(&reference));
        let problems = Problems::find(&mixed, 0.6, &reference);
        let found = problems.list.iter().find_map(|problem| match problem {
            Problem::Orientation(orientation) => Some(orientation.best),
            _ => None,
        });
        assert_eq!(found.unwrap_or_default(), symmetry.inverse(), "{symmetry}: {problems}");
        assert!(!problems.is_uncorrectable());
        let repaired = problems.repair(&mixed.events);
        assert_eq!(repaired.sensor(), SIZE);
        let sorted = |events: &EventStream| {
            let mut all: Vec<_> = events.iter().map(|e| (e.t, e.x, e.y, e.polarity)).collect();
            all.sort_by_key(|(t, x, y, _)| (*t, *x, *y));
            all
        };
        assert_eq!(sorted(&repaired), sorted(&reference));
    }
}

#[test]
fn late_and_noisy_events_are_no_orientation_mismatch() {
    let reference = reference();
    for late_us in [5_000, 30_000, 60_000] {
        let late = units::shifted(&reference, Micros(late_us));
        let mut rng = evpose_core::CounterRng::new(3, "noise", 0);
        let mut all: Vec<Event> = late.iter().filter(|_| rng.chance(0.5)).collect();
        for _ in 0..20_000 {
            let t = Micros(rng.below(600_000) as i64);
            let (x, y) = (rng.below(40) as u16, rng.below(30) as u16);
            all.push(Event { t, x, y, polarity: Polarity::from_on(rng.chance(0.7)) });
        }
        all.sort_by_key(|event| event.t);
        let noisy = EventStream::from_events(SIZE, all).unwrap();
        let orientation = symmetry::find(&noisy, &reference).unwrap();
        assert!(!orientation.is_clear, "{orientation:?}");
    }
}

#[test]
fn other_units_are_said_and_undone() {
    let reference = reference();
    for factor in [1e3, 1e6, 1e-3] {
        let wrong = recording(units::divided(&reference, 1.0 / factor));
        let problems = Problems::find(&wrong, 0.6, &reference);
        assert_eq!(problems.list[0], Problem::Unit { too_long_by: factor }, "{problems}");
        let repaired = problems.repair(&wrong.events);
        let resolution_us = (1.0 / factor).max(1.0) as i64;
        for (a, b) in repaired.t().iter().zip(reference.t()) {
            assert!((a.0 - b.0).abs() <= resolution_us);
        }
    }
    let seconds = recording(units::divided(&reference, 1e6));
    assert!(Problems::find(&seconds, 0.6, &reference).is_uncorrectable());
}

#[test]
fn a_recording_with_the_time_of_day_is_laid_on_the_scene() {
    let reference = reference();
    for shift_us in [1_700_000_000_000_000, 300_000, -400_000] {
        let shifted = recording(units::shifted(&reference, Micros(shift_us)));
        let problems = Problems::find(&shifted, 0.6, &reference);
        assert!(matches!(problems.list[..], [Problem::Start { .. }]), "{problems}");
        let repaired = problems.repair(&shifted.events);
        assert!((repaired.t()[0].0 - reference.t()[0].0).abs() <= 4_000);
    }
}

#[test]
fn a_few_milliseconds_are_left_to_the_clock() {
    let reference = reference();
    let late = recording(units::shifted(&reference, Micros(8_000)));
    assert!(Problems::find(&late, 0.6, &reference).is_empty());
}

#[test]
fn recordings_that_are_too_long_or_too_short_are_said() {
    let reference = reference();
    let short = reference.iter().filter(|event| event.t < Micros(400_000));
    let short = recording(EventStream::from_events(SIZE, short).unwrap());
    let problems = Problems::find(&short, 0.6, &reference);
    assert!(matches!(problems.list[..], [Problem::Duration { .. }]), "{problems}");
    let again = units::shifted(&reference, Micros(600_000));
    let long =
        recording(EventStream::from_events(SIZE, reference.iter().chain(again.iter())).unwrap());
    let problems = Problems::find(&long, 0.6, &reference);
    assert!(matches!(problems.list[..], [Problem::Duration { .. }]), "{problems}");
}

#[test]
fn another_sensor_is_said_and_hopeless() {
    let reference = reference();
    let larger = SensorSize { width: 50, height: 50 };
    let other = recording(EventStream::from_events(larger, reference.iter()).unwrap());
    let problems = Problems::find(&other, 0.6, &reference);
    assert!(problems.is_uncorrectable());
    let said = problems.to_string();
    assert!(said.contains("a sensor of 50x50, the scene of one of 40x30"), "{said}");
}
