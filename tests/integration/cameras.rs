//! Shipped networks before cameras that they were not trained for.

use evpose_io::MetaReader;
use evpose_io::poses::read_poses;
use evpose_pose::JointFrame;
use glam::Vec2;

use crate::harness::{Sandbox, shipped, stderr};

/// Mean distance of the predicted wrist from the true one, in metres, when the same hand is
/// recorded at `scale` of 240x180 pixels, which are `size`.
fn wrist_error_m(sandbox: &Sandbox, scale: &str, size: &str) -> f32 {
    let (folder, change) = (format!("at{scale}"), format!("simulation.image_scale={scale}"));
    let simulate = ["simulate", "quick", "--held-out", "--seed", "78", "--sequences", "1"];
    let out = ["--seconds", "0.6", "--out", &folder, "--set", &change];
    sandbox.ok(&[&simulate[..], &out].concat());
    // As a recording of somebody: with a size, without a configuration.
    let (events, recording) = (format!("{folder}/0000.evc"), format!("{folder}/rec.npz"));
    sandbox.ok(&["convert", &events, &recording, "--sensor", size]);
    let network = shipped("hand-quick.bpk");
    let infer = ["infer", "--checkpoint", &network, "--events", &recording, "--unfiltered"];
    let joints = format!("{folder}/joints.csv");
    sandbox
        .ok(&[&infer[..], &["--camera", "45deg", "--out", "poses.csv", "--joints", &joints]]
            .concat());
    let truth = MetaReader::open(sandbox.path(&format!("{folder}/0000.meta"))).unwrap();
    let (mut sum_m, mut count) = (0.0, 0);
    for pose in read_poses(&sandbox.path("poses.csv")).unwrap().poses.iter().step_by(20) {
        let wrist_m = pose.params.unwrap().translation_m;
        // Record `k` is the pose at the end of frame `k`.
        let frame = (pose.t.0 / 1000) as u64 - 1;
        sum_m += wrist_m.distance(truth.read_hand(frame).unwrap().translation_m);
        count += 1;
    }
    sum_m / count as f32
}

#[test]
fn a_hand_is_found_as_well_before_a_sensor_of_four_times_the_size() {
    let sandbox = Sandbox::new();
    let native_m = wrist_error_m(&sandbox, "0.25", "60x45");
    for (scale, size) in [("0.5", "120x90"), ("1.0", "240x180")] {
        let error_m = wrist_error_m(&sandbox, scale, size);
        assert!(error_m < 1.5 * native_m + 0.01, "{scale}: {error_m} m, native {native_m} m");
    }
}

#[test]
fn positions_come_back_in_the_pixels_of_the_sensor_and_guesses_are_said() {
    let sandbox = Sandbox::new();
    let mut text = String::from("# 640 480\n");
    for k in 0..4_000_i32 {
        let t_s = 1e-4 * f64::from(k);
        text += &format!("{t_s:.6} {} {} 1\n", 300 + k % 40, 200 + (k / 40) % 60);
    }
    sandbox.write("rec.txt", text);
    sandbox.ok(&["convert", "rec.txt", "rec.npz", "--sensor", "640x480"]);
    let network = shipped("hand-quick.bpk");
    let infer = ["infer", "--checkpoint", &network, "--events", "rec.npz", "--out", "poses.csv"];
    let (code, said) = sandbox.ends(&[&infer[..], &["--joints", "j.csv"]].concat());
    assert!(code == Some(0) && said.contains("45 degrees is assumed"), "{said}");
    let joints = read_poses(&sandbox.path("j.csv")).unwrap();
    let pose = joints.poses.last().unwrap();
    // Far beyond the 60x45 pixels of the network.
    assert!(pose.joints[0].image_px.unwrap().x > 60.0, "{pose:?}");
    // Joints in metres are those in pixels before a camera of 45 degrees, and the table says so.
    assert_eq!(joints.frame, Some(JointFrame::Camera));
    let focal_px = 240.0 / (0.5 * 45.0_f32.to_radians()).tan();
    for joint in &pose.joints {
        let (at_px, at_m) = (joint.image_px.unwrap(), joint.position_m.unwrap());
        let projected = focal_px * Vec2::new(at_m.x, at_m.y) / at_m.z + Vec2::new(320.0, 240.0);
        assert!(at_m.z > 0.0 && projected.distance(at_px) < 0.5, "{at_m} {at_px} {projected}");
    }
    let poses = read_poses(&sandbox.path("poses.csv")).unwrap();
    let whole = poses.poses.last().unwrap();
    assert!(whole.params.is_some() && pose.params.is_none());
    assert_eq!(whole.joints, pose.joints);
    let refused = sandbox.fails(&[&infer[..], &["--camera", "dvs129"]].concat());
    assert!(refused.contains("davis346") && refused.contains("45deg"), "{refused}");
}

#[test]
fn a_sensor_that_the_file_does_not_state_is_of_its_sidecar_given_or_inferred_and_said() {
    let sandbox = Sandbox::new();
    let simulate = ["simulate", "quick", "--held-out", "--sequences", "1", "--seconds", "0.3"];
    let size = ["--set", "simulation.image_scale=1.0", "--out", "data"];
    sandbox.ok(&[&simulate[..], &size].concat());
    let networks = [shipped("hand-quick.bpk"), shipped("body-quick.bpk")];
    let infer = |network: &str, more: &[&str]| {
        let infer = ["infer", "--checkpoint", network, "--events", "data/0000.evc"];
        let output = ["--out", "poses.csv"];
        sandbox.evpose(&[&infer[..], &output, more].concat()).output().unwrap()
    };
    for network in &networks {
        // The sidecar beside the recording states the sensor.
        let beside = infer(network, &[]);
        let said = stderr(&beside);
        assert!(beside.status.success() && !said.contains("outside"), "{said}");
        assert!(!said.contains("does not state"), "{said}");
        let other = infer(network, &["--sensor", "60x45"]);
        let said = stderr(&other);
        assert!(!other.status.success() && said.contains("states a sensor of 240x180"), "{said}");
    }
    // Without it the events alone are left.
    std::fs::remove_file(sandbox.path("data/0000.toml")).unwrap();
    for network in &networks {
        let given = infer(network, &["--sensor", "240x180", "--salvage", "--camera", "45deg"]);
        assert!(given.status.success(), "{}", stderr(&given));
        let guessed = infer(network, &[]);
        let said = stderr(&guessed);
        assert!(guessed.status.success() && said.contains("does not state its sensor"), "{said}");
        assert!(said.contains("--sensor") && !said.contains("outside"), "{said}");
        let small = infer(network, &["--sensor", "60x45"]);
        let said = stderr(&small);
        assert!(!small.status.success() && said.contains("outside a sensor of 60x45"), "{said}");
    }
}

#[test]
fn recordings_without_a_pose_are_errors_that_say_how_long_they_must_be() {
    let sandbox = Sandbox::new();
    let mut text = String::from("60 45\n");
    // Ten milliseconds: shorter than the window of the hand and the stride of the body.
    (0..100).for_each(|k| text += &format!("{:.6} {} 7 1\n", 1e-4 * f64::from(k), k % 60));
    sandbox.write("short.txt", text);
    sandbox.write("none.txt", "60 45\n");
    let [hand, body] = ["hand-quick.bpk", "body-quick.bpk"].map(shipped);
    let infer = |network: &str, events: &str| {
        let infer = ["infer", "--checkpoint", network, "--events", events, "--out", "poses.csv"];
        sandbox.evpose(&infer).output().unwrap()
    };
    // A hand has a pose all the same, with a warning.
    let short = infer(&hand, "short.txt");
    let said = stderr(&short);
    assert!(short.status.success() && said.contains("lasts 9.9 ms"), "{said}");
    assert!(said.contains("100 ms"), "{said}");
    let short = infer(&body, "short.txt");
    let said = stderr(&short);
    assert!(!short.status.success() && said.contains("lasts 9.9 ms"), "{said}");
    assert!(said.contains("--stride-ms"), "{said}");
    for network in [&hand, &body] {
        let none = infer(network, "none.txt");
        let said = stderr(&none);
        assert!(!none.status.success() && said.contains("no events"), "{said}");
    }
}
