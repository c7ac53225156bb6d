//! Nobody is reported where nobody is: pure noise, next to no events, and a person.

use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity};
use evpose_io::poses::{TimedPose, read_poses};
use evpose_pose::PoseOrigin;

use crate::harness::{Sandbox, shipped, stderr};

/// Writes a second of `count` events anywhere on 346x260 pixels.
fn noise(sandbox: &Sandbox, name: &str, count: u64) {
    let mut text = String::from("346 260\n");
    let mut state = 1u64;
    let mut below = |range: u64| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % range
    };
    for k in 0..count {
        let t_s = k as f64 / count as f64;
        text += &format!("{t_s:.6} {} {} {}\n", below(346), below(260), below(2));
    }
    sandbox.write(name, text);
}

/// The rows of a network of bodies, and the notes of the command, which fails if all of them are of nobody.
fn infer(
    sandbox: &Sandbox,
    network: &str,
    events: &str,
    more: &[&str],
) -> (Vec<TimedPose>, String) {
    let network = shipped(network);
    let infer = ["infer", "--checkpoint", &network, "--events", events];
    let output =
        sandbox.evpose(&[&infer[..], &["--out", "poses.csv"], more].concat()).output().unwrap();
    let poses = read_poses(&sandbox.path("poses.csv")).unwrap().poses;
    assert_eq!(output.status.success(), detected(&poses) > 0, "{}", stderr(&output));
    let origins = poses.iter().map(|pose| pose.origin == Some(PoseOrigin::Nobody));
    assert!(origins.eq(poses.iter().map(TimedPose::is_nobody)));
    (poses, stderr(&output))
}

fn detected(poses: &[TimedPose]) -> usize {
    poses.iter().filter(|pose| pose.body_px().iter().any(Option::is_some)).count()
}

#[test]
fn there_is_nobody_in_noise() {
    let sandbox = Sandbox::new();
    // One, and five events per pixel and second.
    for (name, count) in [("weak.txt", 90_000), ("strong.txt", 450_000)] {
        noise(&sandbox, name, count);
        let (poses, said) = infer(&sandbox, "body.bpk", name, &["--stride-ms", "100"]);
        assert_eq!(detected(&poses), 0, "{name}: of {} poses", poses.len());
        // Each step with its count, and how to go on.
        assert!(said.contains(&format!("{count} events are left of the recording")), "{said}");
        assert!(said.contains("after the noise filter"), "{said}");
    }
    // Without a minimum, the maxima of the maps are somebody.
    let none = ["--stride-ms", "100", "--min-score", "0"];
    let (poses, _) = infer(&sandbox, "body-quick.bpk", "strong.txt", &none);
    assert!(poses.len() > 5 && detected(&poses) > 3, "{} of {}", detected(&poses), poses.len());
}

#[test]
fn nothing_is_said_before_there_was_something_to_see() {
    let sandbox = Sandbox::new();
    // Sixty events in a second are too few for a pose.
    noise(&sandbox, "empty.txt", 60);
    let (poses, said) = infer(&sandbox, "body.bpk", "empty.txt", &["--stride-ms", "100"]);
    assert_eq!((poses.len(), detected(&poses)), (9, 0), "{said}");
    assert!(said.contains("9 of 9 times had too few of them"), "{said}");
    assert!(said.contains("record for longer") || said.contains("in company"), "{said}");
    for network in ["body.bpk", "hand.bpk"] {
        let network = shipped(network);
        let live = ["live", "--source", "empty.txt", "--checkpoint", &network, "--speed", "max"];
        sandbox.ok(&[&live[..], &["--json", "poses.jsonl"]].concat());
        let poses = sandbox.text("poses.jsonl");
        assert!(poses.is_empty(), "{network}: {poses}");
    }
    let hand = shipped("hand.bpk");
    let infer = ["infer", "--checkpoint", &hand, "--events", "empty.txt", "--out", "hand.csv"];
    let said = sandbox.fails(&[&infer[..], &["--stride-ms", "100"]].concat());
    assert!(said.contains("nobody is in view") && said.contains("9 of 9 times"), "{said}");
    let rows = read_poses(&sandbox.path("hand.csv")).unwrap().poses;
    assert!(rows.iter().all(|row| row.origin == Some(PoseOrigin::Nobody)), "{rows:?}");
    let regressor = shipped("hand-quick.bpk");
    let infer = ["infer", "--checkpoint", &regressor, "--events", "empty.txt", "--out", "x.csv"];
    for option in [["--min-score", "0.5"], ["--rotations", "rotations.csv"]] {
        let said = sandbox.fails(&[&infer[..], &option].concat());
        assert!(said.contains("is for networks of joints"), "{said}");
    }
}

#[test]
fn a_network_of_joints_says_how_sure_it_is_and_turns_every_joint() {
    let sandbox = Sandbox::new();
    let network = shipped("hand.bpk");
    let events = format!("{}/datasets/development/hands/06.npz", env!("CARGO_MANIFEST_DIR"));
    let infer = ["infer", "--checkpoint", &network, "--events", &events, "--camera", "45deg"];
    let infer = [&infer[..], &["--stride-ms", "100", "--out", "hands.csv"]].concat();
    sandbox.ok(&[&infer[..], &["--rotations", "rotations.csv"]].concat());
    let rows = read_poses(&sandbox.path("hands.csv")).unwrap().poses;
    let hands: Vec<_> = rows.iter().filter(|row| !row.is_nobody()).collect();
    assert!(hands.len() > rows.len() / 2, "{} of {}", hands.len(), rows.len());
    assert!(hands.iter().all(|row| row.score.is_some_and(|score| (0.5..=1.0).contains(&score))));
    let rotations = sandbox.text("rotations.csv");
    let lines: Vec<&str> = rotations.lines().collect();
    assert_eq!(lines.len(), 1 + hands.len(), "a line of each hand");
    for line in &lines[1..] {
        let values: Vec<f32> = line.split(',').map(|value| value.parse().unwrap()).collect();
        assert_eq!(values.len(), 1 + 6 + 45);
        // No joint of a digit turns by half a turn.
        let turns = values[7..].chunks(3).map(|axis| axis.iter().map(|x| x * x).sum::<f32>());
        assert!(turns.map(f32::sqrt).all(|turn| turn < 3.1), "{line}");
    }
    let said = sandbox.fails(&[&infer[..], &["--min-score", "1"]].concat());
    assert!(said.contains("nobody is in view"), "{said}");
}

#[test]
fn a_person_is_found_and_thresholds_leave_out_what_scores_lower() {
    let sandbox = Sandbox::new();
    let simulate = ["simulate", "finetune", "--held-out", "--sequences", "2", "--seconds", "1"];
    let changes = ["--set", "simulation.step_hz=250", "--set", "simulation.label_hz=50"];
    sandbox.ok(&[&simulate[..], &changes, &["--out", "held"]].concat());
    let stride = ["--stride-ms", "50"];
    let (poses, _) = infer(&sandbox, "body.bpk", "held/0001.raw", &stride);
    assert!(detected(&poses) > poses.len() * 3 / 4, "{} of {}", detected(&poses), poses.len());
    let strict = [&stride[..], &["--min-score", "0.6"]].concat();
    let (strict, _) = infer(&sandbox, "body.bpk", "held/0001.raw", &strict);
    // Rows stay, so that times do not depend on the threshold.
    assert_eq!(strict.len(), poses.len(), "rows are kept");
    let joints = |poses: &[TimedPose]| -> usize {
        poses.iter().map(|pose| pose.body_px().iter().flatten().count()).sum()
    };
    assert!(joints(&strict) < joints(&poses), "{} of {}", joints(&strict), joints(&poses));
    for (strict, pose) in strict.iter().zip(&poses) {
        assert_eq!(strict.score, pose.score);
        for joint in &strict.joints {
            let score = joint.score.unwrap_or_default();
            assert!(joint.image_px.is_none() || (score >= 0.6 && strict.score >= Some(0.6)));
        }
    }
    let beyond = ["--checkpoint", "x", "--events", "y", "--out", "z", "--min-score", "2"];
    let refused = sandbox.fails(&[&["infer"], &beyond[..]].concat());
    assert!(refused.contains("0 to 1"), "{refused}");
    let network = shipped("body.bpk");
    let eval = ["eval", "--checkpoint", &network, "--stride-ms", "100", "--data"];
    let said = sandbox.ok(&[&eval[..], &["held"]].concat());
    assert!(said.contains("people not found") && !said.contains("nobody in view"), "{said}");
    // A camera that moves before nobody: events without a person.
    let empty = ["--set", "simulation.framing=nobody", "--set", "evaluation.moving_cameras=1"];
    sandbox.ok(&[&simulate[..], &changes, &empty, &["--out", "empty"]].concat());
    let said = sandbox.ok(&[&eval[..], &["empty"]].concat());
    assert!(
        said.contains("nobody in view") && said.contains("false detections per minute"),
        "{said}"
    );
}

#[test]
fn a_person_is_found_where_polarities_are_lost() {
    let sandbox = Sandbox::new();
    let simulate = ["simulate", "finetune", "--held-out", "--sequences", "2", "--seconds", "2"];
    let size = ["--set", "simulation.sensor_size={width=640,height=480}", "--out", "vga"];
    let changes = ["--set", "simulation.step_hz=250", "--set", "simulation.label_hz=50"];
    sandbox.ok(&[&simulate[..], &changes, &size].concat());
    let events = evpose_io::open(sandbox.path("vga/0001.raw")).unwrap().stream;
    let mut rng = CounterRng::new(1, "polarities", 0);
    let mut inferred = |name: &str, of: &mut dyn FnMut(&mut CounterRng, Polarity) -> Polarity| {
        let other = |event: Event| Event { polarity: of(&mut rng, event.polarity), ..event };
        let other = EventStream::from_events(events.sensor(), events.iter().map(other)).unwrap();
        let path = sandbox.path(name);
        evpose_io::format_for(&path).unwrap().write(&path, &other).unwrap();
        let (mut poses, said) =
            infer(&sandbox, "body.bpk", name, &["--stride-ms", "50", "--unfiltered"]);
        // Until polarities are evaluated, random ones cancel, and an image remembers: poses of the second
        // second count.
        poses.retain(|pose| pose.t > Micros::SECOND);
        (poses, said)
    };
    let truth = read_poses(&sandbox.path("vga/0001.poses.csv")).unwrap().poses;
    // Of joints from the nearest labels, which are 20 ms apart.
    let error_px = |poses: &[TimedPose]| {
        let of = |pose: &TimedPose| {
            let label = truth.iter().min_by_key(|label| (label.t - pose.t).0.abs()).unwrap();
            let both = pose.body_px().into_iter().zip(label.body_px());
            both.filter_map(|(found, joint)| Some(found?.distance(joint?))).collect::<Vec<_>>()
        };
        let mut errors: Vec<f32> = poses.iter().flat_map(of).collect();
        errors.sort_by(f32::total_cmp);
        errors[errors.len() / 2]
    };
    let (normal, said) = inferred("normal.npz", &mut |_, polarity| polarity);
    assert!(detected(&normal) > 10 && !said.contains("polarities"), "{said}");
    for share_on in [1.0, 0.0, 0.5] {
        let mut drawn = |rng: &mut CounterRng, _| Polarity::from_on(rng.chance(share_on));
        let (poses, said) = inferred("lost.npz", &mut drawn);
        assert!(said.contains("polarities say nothing"), "{said}");
        assert!(detected(&poses) + 2 >= detected(&normal), "{share_on}: {}", detected(&poses));
        let (own_px, normal_px) = (error_px(&poses), error_px(&normal));
        assert!(own_px < 1.2 * normal_px + 1.0, "{share_on}: {own_px} px, not {normal_px} px");
    }
}
