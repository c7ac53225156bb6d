//! Bodies from simulation to poses, in small.

use evpose_io::poses::{TimedPose, read_poses};
use evpose_pose::PoseOrigin;
use evpose_pose::body::BodyPoints;

use crate::harness::{Sandbox, bytes, shipped, tiny_body};

#[test]
fn two_stages_of_training_then_poses_of_a_recording() {
    let sandbox = Sandbox::new();
    sandbox.ok(&tiny_body(&["train", "pretrain", "--out", "pre", "--plain"]));
    assert!(sandbox.path("pre/best.bpk").exists() && sandbox.path("pre/run.toml").exists());
    let finetune = ["train", "finetune", "--out", "fine", "--start-from", "pre", "--plain"];
    let output = sandbox.ok(&tiny_body(&finetune));
    assert!(output.contains("checkpoint: fine"), "{output}");
    assert!(sandbox.path("fine/data/manifest.sha256").exists());

    // Recordings that the training has not seen.
    let simulate = ["simulate", "finetune", "--held-out", "--out", "held", "--preview", "held.png"];
    sandbox.ok(&tiny_body(&simulate));
    let about = sandbox.ok(&["info", "held", "--verify"]);
    assert!(about.contains("2 of 2 complete") && about.contains("kicking"), "{about}");
    evaluate_recordings(&sandbox);
    infer_recording(&sandbox);
    let about = sandbox.ok(&["info", "fine/best.bpk"]);
    assert!(about.contains("bodies: 13 joints from eros") && about.contains("SHA-256"), "{about}");
}

fn evaluate_recordings(sandbox: &Sandbox) {
    let evaluated = sandbox.run(
        "eval --checkpoint fine --data held --json metrics.json --fusion --preview \
         predicted.png --curves pck.svg",
        &[],
    );
    for row in ["network", "filtered", "jitter", "mean pose", "last pose", "propagated", "wrist_l"]
    {
        assert!(evaluated.contains(row), "{row}: {evaluated}");
    }
    let report = sandbox.json("metrics.json");
    assert_eq!(report["network"]["sequences"], 2);
    assert_eq!(report["network"]["raw"]["curve"].as_array().unwrap().len(), 100);
    // An empty figure is smaller.
    for file in ["held.png", "predicted.png", "pck.svg"] {
        assert!(bytes(&sandbox.path(file)).len() > 1_000, "{file}");
    }
}

/// Batches of images change no pose, nor does the last one, which is not full.
fn infer_in_batches(sandbox: &Sandbox) {
    let infer = ["infer", "--checkpoint", "fine/best.bpk", "--events", "held/0000.raw"];
    let batched = ["--stride-ms", "20", "--batch", "7", "--out", "batched.csv"];
    let output = sandbox.ok(&[&infer[..], &batched].concat());
    assert!(output.contains("in batches of 7"), "{output}");
    // Byte for byte: latencies are not in them.
    assert!(bytes(&sandbox.path("poses.csv")) == bytes(&sandbox.path("batched.csv")));
}

/// The filter finds the same joints, and they tremble less.
fn infer_without_filter(sandbox: &Sandbox) {
    let infer = ["infer", "--checkpoint", "fine/best.bpk", "--events", "held/0000.raw"];
    let raw = ["--stride-ms", "20", "--unfiltered", "--out", "raw.csv"];
    sandbox.ok(&[&infer[..], &raw].concat());
    let [filtered, raw] = ["poses.csv", "raw.csv"].map(|name| {
        let poses = read_poses(&sandbox.path(name)).unwrap().poses;
        poses.iter().map(TimedPose::body_px).collect::<Vec<_>>()
    });
    let found = |poses: &[BodyPoints]| -> Vec<bool> {
        poses.iter().flatten().map(Option::is_some).collect()
    };
    // The filter moves joints: it neither adds nor removes one.
    assert_eq!(found(&filtered), found(&raw));
    let jitter_px = |poses: &[BodyPoints]| -> f32 {
        let of = |joint: usize, three: &[BodyPoints]| {
            // The second difference: a joint that moves evenly does not jitter.
            Some((three[0][joint]? - 2.0 * three[1][joint]? + three[2][joint]?).length())
        };
        poses.windows(3).flat_map(|three| (0..13).filter_map(|joint| of(joint, three))).sum()
    };
    assert!(jitter_px(&filtered) < 0.8 * jitter_px(&raw));
}

fn infer_recording(sandbox: &Sandbox) {
    sandbox.run(
        "infer --checkpoint fine/best.bpk --events held/0000.raw --out poses.csv --stride-ms 20 \
         --skeletons skeletons --fused fused.csv",
        &[],
    );
    infer_in_batches(sandbox);
    let text = sandbox.text("poses.csv");
    assert!(text.starts_with("t_us,origin,latency_ms,score,head_u_px,head_v_px,head_score,"));
    // Four columns of the row, three of each joint.
    assert!(text.lines().all(|line| line.split(',').count() == 4 + 3 * 13), "{text}");
    let poses = read_poses(&sandbox.path("poses.csv")).unwrap().poses;
    assert!(poses.len() >= 20);
    assert!(poses.iter().all(|pose| pose.score.is_some() || pose.is_nobody()));
    assert!(poses.iter().all(|pose| pose.latency_ms.is_none()));
    assert!(poses.windows(2).all(|pair| (pair[1].t - pair[0].t).0 == 20_000));
    let log = sandbox.text("skeletons/data.log");
    assert_eq!(log.lines().count(), poses.len());
    infer_without_filter(sandbox);
    let infer = ["infer", "--checkpoint", "fine/best.bpk", "--events", "held/0000.raw"];
    let infer = [&infer[..], &["--stride-ms", "20", "--out"]].concat();
    let refused = sandbox.fails(&[&infer[..], &["poses.xlsx"]].concat());
    assert!(refused.contains(".csv (table)") && refused.contains(".parquet"), "{refused}");
    if cfg!(not(feature = "parquet")) {
        let refused = sandbox.fails(&[&infer[..], &["poses.parquet"]].concat());
        assert!(refused.contains("feature `parquet`"), "{refused}");
    }
    sandbox.ok(&[&infer[..], &["timed.csv", "--latencies"]].concat());
    let timed = read_poses(&sandbox.path("timed.csv")).unwrap().poses;
    assert!(timed.iter().all(|pose| pose.latency_ms.is_some() == pose.score.is_some()));
    for (format, out) in [("hpe-core", "poses.txt"), ("", "poses.json"), ("", "poses.jsonl")] {
        let given = if format.is_empty() { &[][..] } else { &["--format", format] };
        sandbox.ok(&[&infer[..], &[out], given].concat());
        let others = read_poses(&sandbox.path(out)).unwrap().poses;
        // The same poses in any format, apart from rounding.
        assert_eq!(others.len(), poses.len(), "{out}");
        for (a, b) in others.iter().zip(&poses) {
            assert_eq!(a.t, b.t, "{out}");
            for (a, b) in a.body_px().iter().zip(b.body_px()) {
                assert_eq!(a.is_some(), b.is_some(), "{out}");
                assert!(a.zip(b).is_none_or(|(a, b)| a.distance(b) < 1e-3), "{out}");
            }
        }
    }
    sandbox.run(
        "view held/0000.raw --of eros --joints poses.csv --truth held/0000.poses.csv --out \
         people.png",
        &[],
    );
    assert!(bytes(&sandbox.path("people.png")).len() > 1_000);
    let fused = read_poses(&sandbox.path("fused.csv")).unwrap().poses;
    // Between two poses of the network there are many propagated ones.
    assert!(fused.len() > 8 * poses.len());
    // Before the first there is nobody.
    let mut propagated = fused.iter().skip_while(|pose| pose.is_nobody());
    assert!(propagated.all(|pose| pose.origin == Some(PoseOrigin::Propagated)));
}

#[test]
fn what_is_for_hands_is_refused_for_bodies_and_the_other_way_round() {
    let sandbox = Sandbox::new();
    let message = sandbox.fails(&["train", "quick", "--plain"]);
    assert!(message.contains("--data") && message.contains("--out"), "{message}");
    let hand = &shipped("hand-quick.bpk");
    for (line, task) in [
        ("simulate finetune --out x --condition dark", "hand"),
        ("train quick --data a --data b --out x", "body"),
        ("infer --checkpoint HAND --events a.raw b.raw --out x.csv", "body"),
        ("infer --checkpoint HAND --events a.raw --out x --format yarp", "body"),
        ("live --checkpoint HAND --source a.raw --min-score 0.5", "body"),
    ] {
        // While arguments are parsed: no file is missing yet.
        let words: Vec<&str> =
            line.split(' ').map(|word| if word == "HAND" { hand } else { word }).collect();
        let (code, message) = sandbox.ends(&words);
        assert_eq!(code, Some(2), "{line}: {message}");
        assert!(message.contains(&format!("`{task}`")), "{line}: {message}");
    }
    let train = ["train", "finetune", "--out", "x", "--start-from", "nowhere", "--data", "nothing"];
    let message = sandbox.fails(&train);
    assert!(message.contains("nothing"), "{message}");
    let message = sandbox.fails(&["train", "pretrain", "--set", "image.side_px=100"]);
    assert!(message.contains("image.side_px"), "{message}");
}

#[test]
fn an_ablation_trains_what_its_rows_share_once_and_keeps_it() {
    let sandbox = Sandbox::new();
    let args = ["ablate", "body", "--steps", "2", "--seeds", "2", "--jobs", "2", "--out", "abl"];
    let output = sandbox.ok(&tiny_body(&args));
    assert!(output.contains("14 networks to train, 2 at once"), "{output}");
    let outcome = sandbox.json("abl/ablation.json");
    let rows = outcome["rows"].as_array().expect("rows");
    let names: Vec<&str> = rows.iter().filter_map(|row| row["name"].as_str()).collect();
    assert_eq!((names.len(), names[9]), (10, "mean-pose"), "{names:?}");
    for row in rows {
        assert_eq!(row["per_seed"].as_array().map(Vec::len), Some(2), "{row}");
        assert_eq!(row["curve"].as_array().map(Vec::len), Some(100), "{row}");
    }
    // The same network before another sensor has other scores.
    let of = |name: &str| &rows[names.iter().position(|n| *n == name).expect("a row")]["means"]["mpjpe_px"];
    assert_ne!(of("full"), of("vga"));
    let page = sandbox.text("abl/ablation.html");
    assert!(page.contains("<svg") && page.contains("wo-pretrain"));

    let (refused, again) = (sandbox.fails(&tiny_body(&args)), args.iter().chain(&["--resume"]));
    assert!(refused.contains("--resume"), "{refused}");
    let before = bytes(&sandbox.path("abl/ablation.json"));
    let output = sandbox.ok(&tiny_body(&again.copied().collect::<Vec<_>>()));
    assert!(!output.contains("networks to train"), "{output}");
    assert_eq!(bytes(&sandbox.path("abl/ablation.json")), before);
}
