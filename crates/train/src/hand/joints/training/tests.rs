//! A training of joints from a recording to poses.

use evpose_core::SensorSize;
use evpose_io::{HandJointsWriter, JointsReader};
use evpose_nn::parameters::read;
use evpose_nn::{DeviceKind, HandHead};
use evpose_pose::HandSide;
use evpose_sim::{Simulation, record_all};
use evpose_task::hand::{CameraTurnConfig, HandConfig, HandView, TwoPassConfig};

use crate::{HandDataset, Method, TrainOptions, evaluate, train_hand};

use super::*;

fn config() -> HandConfig {
    let mut config = HandConfig::default();
    config.simulation.image_scale = 0.4;
    config.simulation.sequences = 2;
    config.simulation.seconds = 0.4;
    config.simulation.skin.texels = 64;
    config.two_pass = Some(TwoPassConfig {
        size: SensorSize { width: 64, height: 32 },
        empty_probability: 0.2,
        ..TwoPassConfig::default()
    });
    config.simulation.sensor_size = SensorSize { width: 240, height: 120 };
    config.camera_turns = CameraTurnConfig { roll_deg: 30.0, tilt_deg: 5.0 };
    config.network.backbone = HandHead::BACKBONE.to_owned();
    config.network.head = HandHead::Joints;
    config.network.width = 0.125;
    config.training.batch_size = 4;
    config.training.steps = 4;
    config.training.steps_per_validation = 2;
    config.training.validation_s = 0.15;
    config.training.validation_samples = 4;
    config.training.estimate_filter = true;
    config.evaluation.first_ms = 200;
    // So few steps teach nobody what a hand is.
    config.detection.min_presence = 0.0;
    config
}

#[test]
fn a_network_of_joints_trains_goes_on_and_is_evaluated() {
    let config = config();
    let directory = tempfile::tempdir().unwrap();
    let [data, run, next] = ["data", "run", "next"].map(|name| directory.path().join(name));
    record_all(&Simulation::new(&config.simulation, 1).unwrap(), &data, &|_| {}).unwrap();
    let options = TrainOptions::new(DeviceKind::Flex);
    let summary = train_hand(&config, &data, &run, &options).unwrap();
    assert_eq!(summary.samples, 16);
    let metrics = std::fs::read_to_string(run.join("metrics.jsonl")).unwrap();
    assert!(metrics.contains("divergence") && metrics.contains("presence"), "{metrics}");

    let best = HandCheckpoint::load(&run, &Device::flex()).unwrap();
    assert_eq!(best.config.network, config.network);
    let set = HandDataset::open(&data, &config).unwrap();
    let mut trained = best.predictor(Device::flex()).unwrap();
    let mut methods = [Method { name: "trained", predictor: &mut trained, filtered: None }];
    let results = evaluate(&config, &set, &mut methods, 50, &mut |_| {}).unwrap();
    let poses = &results[0].tracks[0].poses;
    assert_eq!(results[0].tracks[0].frames, [200, 250, 300, 350]);
    for joints in poses.iter().map(|pose| pose.joints.unwrap()) {
        assert!(joints.camera_m.iter().all(|at_m| at_m.is_finite() && at_m.z < 0.0));
        assert!((0.0..=1.0).contains(&joints.presence));
    }
    let summary = results[0].evaluation.summary(&config.evaluation.bootstrap);
    assert!(summary.fingers.unwrap().majority > 0.3);
    assert!(poses.iter().all(|pose| pose.params.to_array().iter().all(|value| value.is_finite())));

    let mut from = config;
    from.start_from = Some(run);
    from.training.learning_rate = 1e-12;
    train_hand(&from, &data, &next, &options).unwrap();

    // Without a step, the presence alone is another one.
    let (fitted, mut fit) = (directory.path().join("fitted"), from.clone());
    (fit.training.steps, fit.training.presence_samples) = (0, 96);
    train_hand(&fit, &data, &fitted, &options).unwrap();
    let fitted = HandCheckpoint::load(&fitted, &Device::flex()).unwrap();
    let differ = read(&best.network).into_iter().zip(read(&fitted.network));
    let differ = differ.filter(|(before, after)| before.1 != after.1);
    let paths: Vec<String> = differ.map(|(before, _)| before.0.path).collect();
    assert_eq!(paths, ["presence.weight", "presence.bias"]);

    from.network.width = 0.25;
    let error = train_hand(&from, &data, &directory.path().join("wider"), &options).unwrap_err();
    assert!(error.to_string().contains("width"), "{error}");
}

/// Points in a file beside the labels come before those of the labels.
#[test]
fn recorded_joints_come_before_those_of_the_label() {
    let config = HandConfig { two_pass: None, ..config() };
    let config = HandConfig { camera_turns: CameraTurnConfig::default(), ..config };
    let directory = tempfile::tempdir().unwrap();
    record_all(&Simulation::new(&config.simulation, 1).unwrap(), directory.path(), &|_| {})
        .unwrap();
    let _ = std::fs::remove_file(directory.path().join("0000.joints.npy"));
    let labels = || {
        let set = HandDataset::open(directory.path(), &config).unwrap();
        [120, 130].map(|index| set.plain_sample(index).unwrap().joints.unwrap())
    };
    let of_poses = labels();
    let view = HandView::new(&config).unwrap();
    let set = HandDataset::open(directory.path(), &config).unwrap();
    let path = JointsReader::path_of(&directory.path().join("0000"));
    let frames = set.sequences()[0].frames();
    let mut file = HandJointsWriter::create(path, frames).unwrap();
    for frame in 0..frames {
        let sequence = &set.sequences()[0];
        let betas = sequence.betas(sequence.episode_of(frame));
        let points = view.points(HandSide::Right, &sequence.pose(frame).unwrap(), betas);
        let mut points_m = view.camera_points(&points.world_m);
        if frame == 130 {
            // A finger that no articulation makes.
            points_m[2] += glam::Vec3::new(0.0, 0.05, 0.0);
        }
        file.frame(&points_m).unwrap();
    }
    file.finish().unwrap();
    let of_file = labels();
    for joint in 0..21 {
        let off = of_file[0].positions[joint].distance(of_poses[0].positions[joint]);
        assert!(off < 1e-3, "{joint}: {off}");
    }
    let moved = of_file[1].positions[2].distance(of_poses[1].positions[2]);
    assert!(moved > 0.5, "{moved} cells");
    assert!(of_file[1].positions[3].distance(of_poses[1].positions[3]) < 1e-3);
}

/// Beside the labelled hand is nobody, or the other one, of which nothing is known.
#[test]
fn an_empty_crop_of_two_hands_says_nothing_about_presence() {
    let unknown = [false, true].map(|another_hand| {
        let mut config = config();
        config.simulation.another_hand = another_hand;
        config.two_pass.as_mut().unwrap().empty_probability = 0.9;
        let directory = tempfile::tempdir().unwrap();
        let simulation = Simulation::new(&config.simulation, 1).unwrap();
        record_all(&simulation, directory.path(), &|_| {}).unwrap();
        let set = HandDataset::open(directory.path(), &config).unwrap();
        let label = |index| *set.plain_sample(index).unwrap().joints.unwrap();
        (0..set.len()).step_by(9).filter(|index| label(*index).presence.is_none()).count()
    });
    assert!(unknown[1] > unknown[0] + 10, "{unknown:?}");
}
