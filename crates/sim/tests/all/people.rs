//! Sequences of people: reproducibility, labels and files.

use std::fs;

use evpose_core::SensorSize;
use evpose_sim::config::{BodySource, MotionSource, SensorChoice};
use evpose_sim::person::{
    People, PeopleConfig, PersonInfo, PoseTable, RecordingPlace, record_people,
};
use evpose_sim::set::verify;
use evpose_sim::{Shard, SimError};

use crate::support::tree;

/// Small and short, before a camera without noise.
fn config() -> PeopleConfig {
    PeopleConfig {
        sequences: 3,
        seconds: 0.3,
        step_hz: 250,
        label_hz: 50,
        sensor_size: SensorSize { width: 96, height: 72 },
        sensor: SensorChoice::Preset("ideal".to_owned()),
        moving_cameras: 0.0,
        stillness: 0.0,
        ..PeopleConfig::default()
    }
}

fn still_walls(mut config: PeopleConfig) -> PeopleConfig {
    config.surroundings.moving = 0.0;
    config
}

#[test]
fn shards_leave_the_bytes_of_the_whole_run_and_digests_that_hold() {
    let people = People::new(&config(), 3).unwrap();
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let recorded = record_people(&people, whole.path(), Shard::WHOLE, &|_| {}).unwrap();
    assert!(recorded.finished && recorded.events > 0);
    for part in ["2/2", "1/2"] {
        record_people(&people, parts.path(), part.parse().unwrap(), &|_| {}).unwrap();
    }
    assert_eq!(tree(whole.path()), tree(parts.path()));
    // Events, poses, what was drawn.
    assert_eq!(verify(whole.path(), &|_| {}).unwrap().files, 9);
    let again = record_people(&people, whole.path(), Shard::WHOLE, &|_| {}).unwrap();
    assert_eq!((again.sequences, again.reused), (0, 3));
    fs::write(whole.path().join("0001.poses.csv"), "t_us").unwrap();
    assert!(matches!(verify(whole.path(), &|_| {}), Err(SimError::Damaged { .. })));
}

#[test]
fn labels_are_where_the_joints_are_seen_and_come_at_their_pace() {
    let people = People::new(&config(), 5).unwrap();
    let directory = tempfile::tempdir().unwrap();
    record_people(&people, directory.path(), Shard::WHOLE, &|_| {}).unwrap();
    let table = PoseTable::read(&directory.path().join("0000.poses.csv")).unwrap();
    let times: Vec<i64> = table.rows.iter().map(|row| row.t.0).collect();
    assert_eq!(times, (0..15).map(|k| 20_000 * k).collect::<Vec<_>>());
    for row in &table.rows {
        // Upright: the head is above the ankles, on the image as in the world.
        let (head, ankle) = (row.joints_px[0], row.joints_px[11]);
        if let Some((head, ankle)) = head.zip(ankle) {
            assert!(head.y < ankle.y);
        }
        assert!(row.joints_m[0].y > row.joints_m[11].y);
    }
}

#[test]
fn somebody_before_a_still_wall_makes_all_events_near_them() {
    let config = still_walls(config());
    let people = People::new(&config, 9).unwrap();
    for sequence in 0..3 {
        let (mut near, mut all) = (0, 0);
        people
            .play::<SimError>(sequence, |step| {
                let joints: Vec<_> = step.joints_px.iter().flatten().collect();
                for event in step.events.iter() {
                    let at = glam::Vec2::new(f32::from(event.x), f32::from(event.y));
                    all += 1;
                    near += usize::from(joints.iter().any(|joint| joint.distance(at) < 25.0));
                }
                Ok(())
            })
            .unwrap();
        assert!(all > 50 && near as f32 > 0.97 * all as f32, "{sequence}: {near} of {all}");
    }
}

#[test]
fn people_are_as_tall_on_the_image_as_the_config_says() {
    let mut config = still_walls(config());
    config.activities = vec!["waving".to_owned()];
    for share in [0.4, 0.8] {
        config.height_share = [share; 2];
        let people = People::new(&config, 2).unwrap();
        for sequence in 0..3 {
            let mut simulator = people.sequence(sequence).unwrap();
            let step = simulator.advance().unwrap();
            let (head, ankle) = (step.joints_px[0].unwrap(), step.joints_px[11].unwrap());
            // From the middle of the head to an ankle is five sixths of somebody who stands.
            let seen = (ankle.y - head.y) / 72.0 / share;
            assert!((0.72..0.95).contains(&seen), "{share}: {seen}");
        }
    }
}

#[test]
fn a_camera_in_the_hand_sees_the_wall_move_and_one_that_stands_does_not() {
    let count = |moving_cameras: f32| {
        let mut config = still_walls(config());
        config.moving_cameras = moving_cameras;
        config.camera_turn_deg = 3.0;
        config.surroundings.plain = 0.0;
        let people = People::new(&config, 4).unwrap();
        let mut events = 0;
        people
            .play::<SimError>(0, |step| {
                events += step.events.len();
                Ok(())
            })
            .unwrap();
        events
    };
    let (standing, held) = (count(0.0), count(1.0));
    assert!(held > 3 * standing, "{held} {standing}");
}

#[test]
fn photographs_differ_and_follow_from_seed_and_number() {
    let people = People::new(&config(), 8).unwrap();
    let still = |index| people.still(index).unwrap();
    assert_eq!(still(4), People::new(&config(), 8).unwrap().still(4).unwrap());
    assert_ne!(still(4).grey, still(5).grey);
    assert!(still(4).joints_px.iter().flatten().count() >= 8);
}

#[test]
fn what_nobody_can_do_is_refused_with_what_there_is() {
    let config = PeopleConfig { activities: vec!["flying".to_owned()], ..config() };
    let message = People::new(&config, 1).unwrap_err().to_string();
    assert!(message.contains("flying") && message.contains("boxing"), "{message}");
    let config = PeopleConfig { label_hz: 70, ..self::config() };
    assert!(People::new(&config, 1).unwrap_err().to_string().contains("label_hz"));
}

#[test]
fn without_their_folders_people_are_as_before_and_both_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let none = folder.path().join("none");
    let body = BodySource::MakeHuman(none.clone());
    let config = PeopleConfig { body, motion: MotionSource::Cmu(none), ..config() };
    let missing = config.missing_folders();
    assert!(missing[0].contains("simulation.body") && missing[1].contains("simulation.motion"));
    let still = |config: &PeopleConfig| People::new(config, 8).unwrap().still(4).unwrap();
    assert_eq!(still(&config), still(&self::config()));
    // A folder of something else is an error.
    let body = BodySource::MakeHuman(folder.path().to_owned());
    let message = People::new(&PeopleConfig { body, ..self::config() }, 8).unwrap_err().to_string();
    assert!(message.contains("base.obj"), "{message}");
}

fn several_cameras() -> PeopleConfig {
    let camera_angles_deg = vec![-45.0, 0.0, 90.0];
    PeopleConfig { camera_angles_deg, sequences: 6, ..config() }
}

#[test]
fn cameras_of_a_scene_see_the_same_person_from_their_angles() {
    let people = People::new(&several_cameras(), 5).unwrap();
    let directory = tempfile::tempdir().unwrap();
    record_people(&people, directory.path(), Shard::WHOLE, &|_| {}).unwrap();
    let of = |sequence: u64| {
        let stem = directory.path().join(format!("{sequence:04}"));
        let path = stem.with_extension("toml");
        let info: PersonInfo = toml::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        let place = RecordingPlace::read(&path).unwrap();
        assert_eq!((place.scene, place.camera), (info.scene, info.camera));
        (info, PoseTable::read(&stem.with_extension("poses.csv")).unwrap())
    };
    let (first, table) = of(0);
    for (sequence, angle_deg) in [(0, -45.0_f64), (1, 0.0), (2, 90.0)] {
        let (info, own) = of(sequence);
        assert_eq!((info.scene, &info.betas), (Some(0), &first.betas));
        let camera = info.camera.unwrap();
        let eye_m = camera.camera_from_world.inverse().translation;
        let seen_deg = eye_m.x.atan2(eye_m.z).to_degrees();
        assert!((seen_deg - angle_deg).abs() < 25.0, "{seen_deg} for {angle_deg}");
        let mut visible = 0;
        for (row, shared) in own.rows.iter().zip(&table.rows) {
            for ((at_m, shared_m), at_px) in
                row.joints_m.iter().zip(&shared.joints_m).zip(row.joints_px)
            {
                assert!(at_m.distance(*shared_m) < 2e-5, "{at_m} {shared_m}");
                let Some(at_px) = at_px else { continue };
                let projected = camera.image_from_world(at_m.as_dvec3()).unwrap();
                assert!(projected.as_vec2().distance(at_px) < 0.05, "{projected} {at_px}");
                visible += 1;
            }
        }
        assert!(visible > 100, "{visible}");
    }
    assert_ne!(of(3).0.betas, first.betas);
    assert_eq!(of(3).0.scene, Some(1));
}

/// The first camera alone sees what it would see without the others, if it stands before the person.
#[test]
fn a_camera_before_the_person_is_that_of_a_single_one() {
    let single = PeopleConfig { sequences: 1, ..config() };
    let several = PeopleConfig { camera_angles_deg: vec![0.0, 60.0], sequences: 2, ..config() };
    let light = |config: &PeopleConfig, sequence: u64| {
        let mut luminance = Vec::new();
        let people = People::new(config, 5).unwrap();
        people
            .play::<SimError>(sequence, |step| {
                luminance.extend_from_slice(step.luminance.data());
                Ok(())
            })
            .unwrap();
        luminance
    };
    assert!(light(&single, 0) == light(&several, 0));
    assert!(light(&single, 0) != light(&several, 1));
}

#[test]
fn fields_that_contradict_several_cameras_are_named() {
    let refused = |config: PeopleConfig| People::new(&config, 1).unwrap_err().to_string();
    let base = several_cameras;
    for (config, field) in [
        (PeopleConfig { sequences: 4, ..base() }, "sequences"),
        (PeopleConfig { moving_cameras: 0.1, ..base() }, "moving_cameras"),
        (PeopleConfig { companions: 1, ..base() }, "companions"),
        (PeopleConfig { camera_angles_deg: vec![200.0], ..base() }, "camera_angles_deg"),
    ] {
        let message = refused(config);
        assert!(message.contains(field), "{message}");
    }
}
