//! Simulated sequences: determinism, labels, episodes and noise.

use std::sync::atomic::{AtomicU64, Ordering};

use evpose_body::fingers::Fingers;
use evpose_core::{EventStream, Micros, SensorSize};
use evpose_io::{EvcReader, JointsReader, MetaReader};
use evpose_sensor::SensorConfig;
use evpose_sim::config::{Hands, SensorChoice};
use evpose_sim::{Simulation, SimulationConfig, Simulator, record, record_all};
use glam::Vec3;

use crate::support::tree;

/// A small image, so that tests are quick.
fn small() -> SimulationConfig {
    let mut config = SimulationConfig { image_scale: 0.25, ..SimulationConfig::default() };
    config.skin.texels = 64;
    config
}

/// The ideal sensor: no noise.
fn without_noise(mut config: SimulationConfig) -> SimulationConfig {
    let mut sensor = SensorConfig::preset("eventhands").unwrap();
    sensor.effects.retain(|effect| effect.name != "uniform_noise");
    config.sensor = SensorChoice::Chain(sensor);
    config
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let config = SimulationConfig { sequences: 3, seconds: 0.15, ..small() };
    let runs = [1, 2].map(|threads| {
        let directory = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let simulation = Simulation::new(&config, 7).unwrap();
        let progress = AtomicU64::new(0);
        let count = |frames| {
            progress.fetch_add(frames, Ordering::Relaxed);
        };
        pool.install(|| record_all(&simulation, directory.path(), &count)).unwrap();
        assert_eq!(progress.into_inner(), 3 * 150);
        tree(directory.path())
    });
    assert!(runs[0] == runs[1]);
    for ending in ["evc", "meta"] {
        let [a, b] = ["0000", "0002"].map(|name| &runs[0][&format!("{name}.{ending}")]);
        assert_ne!(a, b, "sequences differ");
    }
}

#[test]
fn files_hold_the_events_and_the_label_of_each_frame() {
    let config = SimulationConfig { sequences: 1, seconds: 0.1, ..small() };
    let directory = tempfile::tempdir().unwrap();
    let simulation = Simulation::new(&config, 3).unwrap();
    let run = record_all(&simulation, directory.path(), &|_| {}).unwrap();
    let recorded = &run.sequences[0];
    let events = EvcReader::open_with(&recorded.events_path, config.image_size()).unwrap();
    let labels = MetaReader::open(&recorded.labels_path).unwrap();
    assert_eq!((events.frames(), labels.records(), recorded.frames), (100, 100, 100));
    let mut simulator = simulation.sequence(0).unwrap();
    let mut total = 0;
    for frame in 0..100 {
        let step = simulator.advance().unwrap();
        assert_eq!((step.frame, step.t), (frame, Micros(frame as i64 * 1_000)));
        total += step.events.len() as u64;
        assert_eq!(labels.read_hand(frame).unwrap(), step.label, "frame {frame}");
    }
    assert_eq!(recorded.events, total);
}

/// Larger than an `.evc` file holds, with events between the steps.
#[test]
fn sensors_of_more_than_256_rows_are_recorded_with_the_time_stamps_of_their_events() {
    let mut config = SimulationConfig { sequences: 1, seconds: 0.05, ..small() };
    (config.sensor_size, config.image_scale) = (SensorSize { width: 346, height: 260 }, 1.0);
    config.sensor = SensorChoice::Preset("davis346".to_owned());
    for (format, file) in
        [(None, "0000.raw"), (Some("npz"), "0000.npz"), (Some("aedat4"), "0000.aedat4")]
    {
        config.format = format.map(str::to_owned);
        let directory = tempfile::tempdir().unwrap();
        let simulation = Simulation::new(&config, 3).unwrap();
        let run = record_all(&simulation, directory.path(), &|_| {}).unwrap();
        assert_eq!(run.sequences[0].events_path, directory.path().join(file));
        assert!(record_all(&simulation, directory.path(), &|_| {}).unwrap().reused == 1);
        assert!(evpose_sim::set::verify(directory.path(), &|_| {}).unwrap().finished);
        let read = evpose_io::open(directory.path().join(file)).unwrap();
        let mut simulator = simulation.sequence(0).unwrap();
        let mut written = EventStream::empty(config.sensor_size);
        for _ in 0..50 {
            let events = simulator.advance().unwrap().events;
            written.extend_columns(events.t(), events.x(), events.y(), events.polarity()).unwrap();
        }
        assert!(written.len() > 1_000 && read.stream.sensor() == config.sensor_size, "{file}");
        assert!(written.t().iter().any(|t| t.0 % 1_000 > 0), "between steps");
        let sorted = |stream: &EventStream| {
            let mut events: Vec<_> =
                stream.iter().map(|e| (e.t, e.y, e.x, e.polarity.is_on())).collect();
            events.sort_unstable();
            events
        };
        assert!(sorted(&read.stream) == sorted(&written), "{file}");
        assert_eq!(run.sequences[0].events, written.len() as u64);
    }
}

#[test]
fn episodes_change_person_and_surroundings_at_their_frames_and_not_the_motion() {
    let short = SimulationConfig { episode_s: 0.02, ..small() };
    let mut changing = Simulator::new(&short, 5).unwrap();
    let mut staying = Simulator::new(&small(), 5).unwrap();
    let mut last: Option<(Vec<f32>, [f32; 6])> = None;
    for frame in 0..65 {
        let step = changing.advance().unwrap();
        let (betas, articulation) = (step.episode.betas.clone(), step.label.articulation);
        assert_eq!(step.episode.index, frame / 20);
        if let Some((last_betas, last_articulation)) = last.replace((betas.clone(), articulation)) {
            assert_eq!(last_betas == betas, frame % 20 != 0, "frame {frame}");
            // A curve of degree two spans the range of 4 at no more than 8 a second.
            for (now, before) in articulation.iter().zip(last_articulation) {
                assert!((now - before).abs() <= 8.1e-3);
            }
        }
        let same = staying.advance().unwrap();
        assert_eq!(frame < 20, step.luminance == same.luminance, "frame {frame}");
    }
}

#[test]
fn a_static_scene_emits_noise_only_and_at_its_rate() {
    use evpose_core::Plane;
    use evpose_sensor::SensorModel;

    // The backdrop of a simulation, the hand being outside of the image.
    let size = SensorSize::DAVIS240C;
    let mut away = SimulationConfig::default();
    away.camera.eye_m.x += 50.0;
    away.camera.centre_m.x += 50.0;
    let mut simulator = Simulator::new(&away, 2).unwrap();
    let mut counts = [0_u64; 2];
    let frames = 500;
    let mut first: Option<Plane<f32>> = None;
    for _ in 0..frames {
        let step = simulator.advance().unwrap();
        let still = first.get_or_insert_with(|| step.luminance.clone());
        assert!(still == step.luminance);
        if step.frame > 0 {
            for event in step.events.iter() {
                counts[usize::from(event.polarity.is_on())] += 1;
            }
        }
    }
    let seconds = (frames - 1) as f64 * 1e-3;
    let expected = [2.2e-3, 55e-3].map(|hz| hz * size.pixels() as f64 * seconds);
    for (count, mean) in counts.into_iter().zip(expected) {
        let error = (count as f64 - mean).abs();
        assert!(error < 4.5 * mean.sqrt() + 1.0, "{counts:?} for {expected:?}");
    }
    // The same without the noise is silent.
    let sensor = without_noise(away).sensor.resolve().unwrap();
    let mut quiet = SensorModel::from_config(&sensor).unwrap().start(size, 0);
    let still = first.unwrap();
    quiet.expose(&still, Micros(0)).unwrap();
    // The published reference level starts at zero and catches up in whole thresholds, so it is
    // there after one exposure.
    for frame in 1..20 {
        assert!(quiet.expose(&still, Micros(frame * 1_000)).unwrap().is_empty());
    }
}

#[test]
fn events_appear_where_the_hand_moves() {
    let mut simulator = Simulator::new(&without_noise(small()), 4).unwrap();
    let mut before = None;
    let (mut changed, mut elsewhere) = (0, 0);
    for _ in 0..300 {
        let step = simulator.advance().unwrap();
        if let Some(before) = before.replace(step.luminance.clone()) {
            for event in step.events.iter() {
                let (x, y) = (usize::from(event.x), usize::from(event.y));
                if before.at(x, y) == step.luminance.at(x, y) {
                    elsewhere += 1;
                } else {
                    changed += 1;
                }
            }
        }
    }
    assert_eq!(elsewhere, 0);
    assert!(changed > 200, "{changed}");
}

#[test]
fn other_seeds_give_other_people_backgrounds_and_motions() {
    let steps = [1, 2].map(|seed| {
        let mut simulator = Simulator::new(&small(), seed).unwrap();
        let step = simulator.advance().unwrap();
        (step.label, step.episode.betas.clone(), step.luminance.clone())
    });
    let [a, b] = &steps;
    assert!(a.0 != b.0 && a.1 != b.1 && a.2 != b.2);
}

/// The labelled hand moves as it does alone, and is in front.
#[test]
fn another_hand_is_seen_behind_the_one_that_has_labels() {
    for hands in [Hands::Right, Hands::Left] {
        let run = |another_hand: bool| {
            let config = SimulationConfig { hands, another_hand, ..small() };
            let mut simulator = Simulator::new(&config, 5).unwrap();
            let camera = *simulator.camera();
            let steps: Vec<_> = (0..40)
                .map(|_| {
                    let step = simulator.advance().unwrap();
                    (step.label, step.points_m, step.luminance.clone())
                })
                .collect();
            (camera, steps)
        };
        let ((camera, alone), (_, both)) = (run(false), run(true));
        let mut differing = 0;
        for ((label, points_m, light), (its_label, its_points_m, its_light)) in
            alone.iter().zip(&both)
        {
            assert_eq!((label, points_m), (its_label, its_points_m), "{hands:?}");
            let pairs = light.data().iter().zip(its_light.data());
            differing += pairs.filter(|(a, b)| a != b).count();
            // The knuckles of the middle and the ring finger.
            for joint in [9, 15] {
                let Some(at_px) = camera.image_from_world(points_m[joint]) else { continue };
                let [x, y] = at_px.as_uvec2().to_array().map(|px| px as usize);
                if x < light.width() && y < light.height() {
                    assert_eq!(light.at(x, y), its_light.at(x, y), "{hands:?} at {at_px}");
                }
            }
        }
        assert!(differing > 40 * 20, "{hands:?}: {differing}");
    }
}

#[test]
fn the_rgb_frame_has_the_luminance_the_sensor_was_exposed_to() {
    let mut simulator = Simulator::new(&small(), 9).unwrap();
    for _ in 0..50 {
        simulator.advance().unwrap();
    }
    let luminance = simulator.advance().unwrap().luminance.clone();
    let frame = simulator.frame_rgb();
    for (rgb, seen) in frame.data().iter().zip(luminance.data()) {
        // The sensor's light is computed in another order: equal within rounding.
        let of_rgb = evpose_sim::scene::luminance(*rgb);
        assert!((of_rgb - seen).abs() < 1e-5, "{of_rgb} {seen}");
    }
}

/// A camera that is displaced, and a left hand: what its own camera sees, in its frame.
#[test]
fn joints_lie_in_the_frame_of_the_camera_that_records() {
    let mut config = SimulationConfig { sequences: 1, seconds: 0.05, ..small() };
    config.camera_pose.orbit_deg = [20.0, 10.0];
    config.camera_pose.roll_deg = 30.0;
    for (hands, fingers) in [(Hands::Right, Fingers::Components), (Hands::Left, Fingers::Gestures)]
    {
        (config.hands, config.motion.fingers) = (hands, fingers);
        let directory = tempfile::tempdir().unwrap();
        let simulation = Simulation::new(&config, 3).unwrap();
        let run = record_all(&simulation, directory.path(), &|_| {}).unwrap();
        let joints = JointsReader::open(directory.path().join("0000.joints.npy")).unwrap();
        assert_eq!(joints.frames(), run.sequences[0].frames);
        let mut simulator = simulation.sequence(0).unwrap();
        let camera = config.camera();
        for frame in 0..joints.frames() {
            let joints_m = joints.read(frame).unwrap().map(Vec3::from_array);
            let step = simulator.advance().unwrap();
            for (joint_m, point_m) in joints_m.into_iter().zip(step.points_m) {
                let at_px = camera.pinhole().image_from_camera(joint_m).unwrap();
                let seen_px = camera.image_from_world(point_m).unwrap();
                assert!(at_px.distance(seen_px) < 1e-3, "{at_px} {seen_px}");
            }
        }
    }
}

#[test]
fn fingers_that_move_by_themselves_are_rendered_where_their_joints_are() {
    let mut config = SimulationConfig { image_scale: 0.5, ..small() };
    config.motion.fingers = Fingers::Gestures;
    let mut simulator = Simulator::new(&config, 12).unwrap();
    let mut published =
        Simulator::new(&SimulationConfig { image_scale: 0.5, ..small() }, 12).unwrap();
    let (mut apart_mm, mut wrist_mm) = (0.0_f32, 0.0_f32);
    let mut changes = 0;
    for _ in 0..400 {
        let (step, other) = (simulator.advance().unwrap(), published.advance().unwrap());
        let between_mm = |k: usize| 1e3 * step.points_m[k].distance(other.points_m[k]);
        wrist_mm = wrist_mm.max(between_mm(0));
        apart_mm = apart_mm.max((1..6).map(between_mm).fold(0.0, f32::max));
        changes += usize::from(step.luminance != other.luminance);
        assert!(step.label.articulation.iter().all(|value| value.abs() < 12.0));
    }
    // The arm is the same, the fingers are not.
    assert!(wrist_mm < 1e-3 && apart_mm > 20.0, "{wrist_mm} {apart_mm}");
    assert!(changes > 390, "{changes}");
}

#[test]
fn steps_that_the_file_format_does_not_have_are_refused() {
    let config = SimulationConfig { step_hz: 2_000, ..small() };
    let mut simulator = Simulator::new(&config, 1).unwrap();
    assert_eq!(simulator.advance().unwrap().t, Micros(0));
    assert_eq!(simulator.advance().unwrap().t, Micros(500));
    let directory = tempfile::tempdir().unwrap();
    let refused = record(&mut simulator, 5, directory.path().join("fast"), &|_| {});
    let message = refused.unwrap_err().to_string();
    assert_eq!(message, "simulation.step_hz = 2000: recordings of hands have 1000 steps a second");
    assert!(tree(directory.path()).is_empty());
}
