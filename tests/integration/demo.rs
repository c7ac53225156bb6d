//! The main job, small.

use crate::harness::{Sandbox, bytes, tiny};

#[test]
fn the_demo_ends_with_metrics_and_a_report_and_its_checkpoint_can_be_used() {
    let sandbox = Sandbox::new();
    let output = sandbox.ok(&tiny(&["demo", "--out", "demo", "--stride-ms", "10"]));
    assert!(output.trim_end().ends_with("report.html"), "{output}");

    let metrics: serde_json::Value =
        serde_json::from_slice(&bytes(&sandbox.path("demo/metrics.json"))).unwrap();
    for method in ["mean_pose", "untrained", "trained", "trained_kalman"] {
        for number in ["translation_mm", "rotation_deg", "articulation", "auc_3d", "auc_2d"] {
            let interval = &metrics["held_out"][method][number];
            let part = |name: &str| interval[name].as_f64().unwrap_or(f64::NAN);
            let (low, estimate, high) = (part("low"), part("estimate"), part("high"));
            assert!(low <= estimate && estimate <= high, "{method}.{number}: {interval}");
        }
    }
    let report = String::from_utf8(bytes(&sandbox.path("demo/report.html"))).unwrap();
    for part in ["<svg", "data:image/gif", "data:image/png", "trained_kalman", "</html>"] {
        assert!(report.contains(part), "the report lacks {part}");
    }
    assert!(!report.contains("http://") || report.contains("www.w3.org"), "nothing from elsewhere");
    assert!(!report.contains("<script src") && !report.contains("<link"), "self-contained");
    for file in ["config.toml", "run.toml", "frames.png", "train/metrics.jsonl", "train/best.bpk"] {
        assert!(sandbox.path("demo").join(file).exists(), "{file} is missing");
    }

    let use_checkpoint =
        |args: &[&str]| sandbox.ok(&[args, &["--checkpoint", "demo/train"]].concat());
    let table = use_checkpoint(&["eval", "--data", "demo/data/held-out", "--stride-ms", "10"]);
    assert!(table.contains("trained_kalman"), "{table}");
    // The same metrics as the demo's own.
    let trained = metrics["held_out"]["trained"]["translation_mm"]["estimate"].as_f64().unwrap();
    assert!(table.contains(&format!("{trained:.1}")), "{trained} not in\n{table}");

    let recording = "demo/data/held-out/0000.evc";
    use_checkpoint(&[
        "infer",
        "--events",
        recording,
        "--out",
        "poses.csv",
        "--joints",
        "joints.csv",
    ]);
    let poses = String::from_utf8(bytes(&sandbox.path("poses.csv"))).unwrap();
    let joints = String::from_utf8(bytes(&sandbox.path("joints.csv"))).unwrap();
    let columns = |text: &str| text.lines().map(|l| l.split(',').count()).collect::<Vec<_>>();
    assert!(columns(&poses).iter().all(|&n| n == 5 + 12 + 21 * 5), "12 parameters, 21 joints");
    assert!(columns(&joints).iter().all(|&n| n == 5 + 21 * 5), "21 joints");
    let times: Vec<i64> = poses
        .lines()
        .skip(1)
        .map(|line| line.split(',').next().unwrap().parse().unwrap())
        .collect();
    assert!(times.len() >= 50, "{} poses of 200 ms", times.len());
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] == 1000), "one a millisecond");

    let view = ["view", recording, "--of", "lnes", "--frames", "2", "--out"];
    sandbox.ok(&[&view[..], &["plain.png"]].concat());
    let drawn = [&view[..], &["hand.png", "--joints", "joints.csv"]].concat();
    sandbox.ok(&[&drawn[..], &["--truth", "demo/data/held-out/0000.meta"]].concat());
    assert_ne!(bytes(&sandbox.path("plain.png")), bytes(&sandbox.path("hand.png")));
    let about = sandbox.ok(&["info", "demo/train/best.bpk"]);
    assert!(about.contains("hands: resnet18") && about.contains("[representation]"), "{about}");
}

#[test]
fn a_demo_of_a_minute_shows_the_network_that_ships() {
    let sandbox = Sandbox::new();
    let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("checkpoints/hand.bpk");
    std::fs::create_dir(sandbox.path("checkpoints")).unwrap();
    std::fs::copy(shipped, sandbox.path("checkpoints/hand.bpk")).unwrap();
    let demo = ["demo", "--minutes", "1", "--out", "shown", "--stride-ms", "20"];
    let small = ["--set", "evaluation.sequences=2", "--set", "evaluation.seconds=0.4"];
    let output = sandbox.ok(&[&demo[..], &small].concat());
    assert!(output.contains("hand.bpk") && output.trim_end().ends_with("report.html"), "{output}");
    for file in ["config.toml", "run.toml", "frames.png", "report.html", "metrics.json"] {
        assert!(sandbox.path("shown").join(file).exists(), "{file} is missing");
    }
    let message = sandbox.fails(&["demo", "--minutes", "0"]);
    assert!(message.contains("--minutes"), "{message}");
}
