//! People in the world: several simulated cameras, triangulation, tables of joints in metres.

use evpose_io::poses::read_poses;
use evpose_pose::JointFrame;
use evpose_sim::person::{PoseTable, RecordingPlace};

use crate::harness::{Sandbox, shipped, stderr};

/// One scene before two cameras.
fn studio(sandbox: &Sandbox) {
    let change = "simulation.sensor_size={ width = 173, height = 130 }";
    let simulate = ["simulate", "studio", "--sequences", "2", "--seconds", "1", "--out", "room"];
    sandbox.ok(&[&simulate[..], &["--set", change]].concat());
}

#[test]
fn two_cameras_give_joints_in_metres_near_the_true_ones() {
    let sandbox = Sandbox::new();
    studio(&sandbox);
    let network = shipped("body-quick.bpk");
    let infer = ["infer", "--checkpoint", &network, "--events", "room/0000.raw", "room/0001.raw"];
    let said = sandbox.ok(&[&infer[..], &["--stride-ms", "100", "--out", "people.csv"]].concat());
    assert!(said.contains("2 cameras") && said.contains("reprojection error"), "{said}");
    let poses = read_poses(&sandbox.path("people.csv")).unwrap();
    assert_eq!(poses.frame, Some(JointFrame::World));
    let truth = PoseTable::read(&sandbox.path("room/0000.poses.csv")).unwrap();
    let (mut sum_m, mut count) = (0.0, 0);
    for pose in &poses.poses {
        // Recordings begin with their first event.
        let row = truth.rows.iter().min_by_key(|row| (row.t.0 - pose.t.0).abs()).unwrap();
        for (joint, at_m) in pose.joints.iter().zip(row.joints_m) {
            let Some(found_m) = joint.position_m else { continue };
            sum_m += found_m.distance(at_m);
            count += 1;
        }
    }
    let mean_m = sum_m / count.max(1) as f32;
    assert!(count > 40 && mean_m < 0.3, "{mean_m} m over {count}");

    // The same cameras as a file of a rig.
    let mut rig = String::new();
    for sequence in ["0000", "0001"] {
        let info = RecordingPlace::read(&sandbox.path(&format!("room/{sequence}.toml"))).unwrap();
        rig += "[[camera]]\n";
        rig += &toml::to_string(&info.camera.unwrap()).unwrap();
    }
    sandbox.write("rig.toml", rig);
    let again = ["--stride-ms", "100", "--cameras", "rig.toml", "--out", "again.csv"];
    sandbox.ok(&[&infer[..], &again].concat());
    let again = read_poses(&sandbox.path("again.csv")).unwrap();
    for (a, b) in poses.poses.iter().zip(&again.poses) {
        let positions = |pose: &evpose_io::poses::TimedPose| {
            pose.joints.iter().map(|joint| joint.position_m).collect::<Vec<_>>()
        };
        assert_eq!(positions(a), positions(b));
    }
    let evaluated = sandbox.ok(&["eval", "--checkpoint", &network, "--data", "room"]);
    assert!(evaluated.contains("1 scenes of 2 cameras"), "{evaluated}");
    assert!(evaluated.contains("filtered      MPJPE "), "{evaluated}");
}

#[test]
fn cameras_that_are_missing_or_too_few_are_errors() {
    let sandbox = Sandbox::new();
    studio(&sandbox);
    // A recording without its sidecar has no camera.
    std::fs::copy(sandbox.path("room/0001.raw"), sandbox.path("other.raw")).unwrap();
    let network = shipped("body-quick.bpk");
    let fails = |args: &[&str]| {
        let infer = ["infer", "--checkpoint", &network, "--out", "people.csv", "--events"];
        sandbox.fails(&[&infer[..], args].concat())
    };
    let said = fails(&["room/0000.raw", "other.raw"]);
    assert!(said.contains("other.toml") && said.contains("--cameras"), "{said}");
    // One camera, where two recordings need two.
    let rig = "[[camera]]\nprojection = [[300.0, 0.0, -173.0, 519.0], [0.0, -300.0, -130.0, 690.0], \
               [0.0, 0.0, -1.0, 3.0]]\n";
    sandbox.write("rig.toml", rig);
    let said = fails(&["room/0000.raw", "other.raw", "--cameras", "rig.toml"]);
    assert!(said.contains("1 cameras for 2 recordings"), "{said}");
    let said = fails(&["room/0000.raw", "other.raw", "--fused", "fused.csv"]);
    assert!(said.contains("--cameras"), "{said}");
    let said = fails(&["room/0000.raw", "--cameras", "rig.toml"]);
    assert!(said.contains("one recording"), "{said}");
    let hand = network.replace("body-quick", "hand-quick");
    let infer = [
        "infer",
        "--checkpoint",
        &hand,
        "--out",
        "p.csv",
        "--events",
        "room/0000.raw",
        "other.raw",
    ];
    let said = stderr(&sandbox.evpose(&infer).output().unwrap());
    assert!(said.contains("are for `body`"), "{said}");
}
