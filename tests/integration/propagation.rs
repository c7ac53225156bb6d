//! Propagated and held poses are never worse than the last one of the network: at 1 kHz, of people and of hands, on
//! recordings of this simulator and of others.

use std::path::{Path, PathBuf};

use evpose_core::Micros;
use evpose_io::JointsReader;
use evpose_io::poses::{PoseJoint, read_poses};
use evpose_pose::PoseOrigin;
use glam::Vec2;

use crate::harness::{Sandbox, shipped};

/// Joints as they are seen at a time: in pixels, or by their rays for want of pixels.
type Seen = (Micros, Vec<Option<Vec2>>);

/// The ray of a joint in front of the camera, which needs no intrinsics.
fn ray(joint: &PoseJoint) -> Option<Vec2> {
    joint.position_m.map(|at_m| at_m.truncate() / at_m.z)
}

/// The labels beside a recording.
fn labels(recording: &Path) -> Vec<Seen> {
    let stem = recording.with_extension("");
    if let Ok(joints) = JointsReader::open(JointsReader::path_of(&stem)) {
        let frames = 0..joints.frames();
        let points = frames.map(|frame| {
            let points = joints.read(frame).expect("as simulated");
            // There, y points up and the camera looks along -z.
            let seen = points.map(|[x, y, z]| Some(Vec2::new(x, -y) / -z));
            (Micros(1_000 * (frame as i64 + 1)), seen.to_vec())
        });
        return points.collect();
    }
    let hand = stem.with_extension("joints.csv");
    let (table, seen): (_, fn(&PoseJoint) -> Option<Vec2>) = match hand.exists() {
        true => (hand, ray),
        false => (stem.with_extension("poses.csv"), |joint| joint.image_px),
    };
    let poses = read_poses(&table).expect("labels").poses;
    poses.iter().map(|pose| (pose.t, pose.joints.iter().map(seen).collect())).collect()
}

/// The labels at `t`, between two of them.
fn label_at(labels: &[Seen], t: Micros) -> Option<Vec<Option<Vec2>>> {
    let next = labels.partition_point(|(at, _)| *at < t);
    let ((from, before), (to, after)) = (labels.get(next.checked_sub(1)?)?, labels.get(next)?);
    let part = (t.0 - from.0) as f32 / (to.0 - from.0) as f32;
    let joints = before.iter().zip(after);
    Some(joints.map(|(a, b)| Some((*a)?.lerp((*b)?, part))).collect())
}

/// The sums over joints of the errors of propagated or held poses, and of the last of the network's.
fn errors(sandbox: &Sandbox, network: &str, recording: &Path, origin: PoseOrigin) -> [f64; 2] {
    let source = recording.to_str().expect("a name of text");
    sandbox.run(
        "live --speed max --stride-ms 40 --propagate-hz 1000 --csv poses.csv",
        &["--source", source, "--checkpoint", &shipped(network)],
    );
    let labels = labels(recording);
    let is_hand = origin == PoseOrigin::Held;
    let (mut last, mut sums) = (Vec::new(), [0.0; 2]);
    for pose in read_poses(&sandbox.path("poses.csv")).expect("as written").poses {
        let seen = |joint: &PoseJoint| if is_hand { ray(joint) } else { joint.image_px };
        let joints: Vec<Option<Vec2>> = pose.joints.iter().map(seen).collect();
        match pose.origin {
            Some(PoseOrigin::Network | PoseOrigin::Nobody) => last = joints,
            of => {
                assert_eq!(of, Some(origin), "{source}");
                let Some(truth) = label_at(&labels, pose.t) else { continue };
                // Joints that one of them leaves out would make the other look worse.
                for ((between, held), truth) in joints.iter().zip(&last).zip(truth) {
                    let Some(((between, held), truth)) = between.zip(*held).zip(truth) else {
                        continue;
                    };
                    sums[0] += f64::from(between.distance(truth));
                    sums[1] += f64::from(held.distance(truth));
                }
            }
        }
    }
    sums
}

/// The recordings of a directory, by name.
fn recordings(directory: &Path, ending: &str) -> Vec<PathBuf> {
    let files = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let is_one = |path: &PathBuf| path.extension().is_some_and(|found| found == ending);
    let mut files: Vec<PathBuf> = files.filter(is_one).collect();
    files.sort();
    files
}

#[test]
fn between_two_poses_of_the_network_none_is_worse_than_the_last_one() {
    none_is_worse_on_every(3);
}

#[test]
#[ignore = "a minute: `cargo xtask slow` runs it"]
fn between_two_poses_of_the_network_none_is_worse_on_any_recording() {
    none_is_worse_on_every(1);
}

/// On every so-many-th recording of other simulators, and on some of our own.
fn none_is_worse_on_every(nth: usize) {
    let sandbox = Sandbox::new();
    sandbox.run(
        "simulate finetune --held-out --out people --sequences 4 --seconds 1.5 --set simulation.step_hz=500",
        &[],
    );
    sandbox.run(
        "simulate quick --held-out --out hands --sequences 4 --set simulation.image_scale=0.8",
        &[],
    );
    let others = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/development");
    for (set, ending, nth, network, origin) in [
        (sandbox.path("people"), "raw", 1, "body.bpk", PoseOrigin::Propagated),
        (others.join("bodies"), "npz", nth, "body.bpk", PoseOrigin::Propagated),
        (sandbox.path("hands"), "evc", 1, "hand.bpk", PoseOrigin::Held),
        (others.join("hands"), "npz", nth, "hand.bpk", PoseOrigin::Held),
    ] {
        let files = recordings(&set, ending);
        assert!(files.len() >= 4, "{}", set.display());
        let mut sums = [0.0; 2];
        for file in files.iter().step_by(nth) {
            let of_file = errors(&sandbox, network, file, origin);
            sums = [sums[0] + of_file[0], sums[1] + of_file[1]];
        }
        let [between, held] = sums;
        assert!(held > 0.0 && between <= held, "{}: {between} for {held}", set.display());
    }
}
