//! The main job, small.

use serde_json::Value;

use crate::harness::{Sandbox, bytes, tiny};

/// Columns of the report's table: the number of `metrics.json`, and its digits.
const COLUMNS: [(&str, usize); 7] = [
    ("translation_mm", 1),
    ("rotation_deg", 1),
    ("articulation", 3),
    ("auc_3d", 3),
    ("auc_2d", 3),
    ("fingers/states", 3),
    ("acceleration_m_s2", 0),
];

/// The text of each cell in the report's rows that begin with `name`.
fn cells(report: &str, name: &str) -> Vec<String> {
    let begin = format!("<tr><td>{name} ");
    let row = report.split_once(&begin).map_or("", |(_, row)| row).split_once("</tr>");
    let row = row.map_or("", |(row, _)| row).replace("<small>", "").replace("</small>", "");
    row.split("</td><td>").skip(1).map(|cell| cell.replace("</td>", "").trim().to_owned()).collect()
}

/// The report's table, and what it says in words, are the metrics beside it.
fn is_of_its_metrics(report: &str, metrics: &Value) {
    let text = |interval: &Value, digits: usize| {
        let part = |name: &str| format!("{:.digits$}", interval[name].as_f64().unwrap_or(f64::NAN));
        format!("{} [{}, {}]", part("estimate"), part("low"), part("high"))
    };
    let methods = metrics["held_out"].as_object().unwrap();
    for (method, scores) in methods {
        // A network that sees no hand has no errors.
        let stored = COLUMNS.map(|(column, digits)| {
            let of_hands = scores.pointer(&format!("/{column}")).filter(|value| value.is_object());
            of_hands.map_or_else(|| "-".to_owned(), |value| text(value, digits))
        });
        assert_eq!(cells(report, method), stored, "{method}");
    }
    let ratios = &metrics["trained_over_mean_pose"];
    let stored = ["translation", "rotation", "articulation"].map(|name| text(&ratios[name], 3));
    assert_eq!(cells(report, "trained / mean_pose")[..3], stored);
}

/// Nothing is loaded from elsewhere: the only address is the name of SVG.
fn is_self_contained(report: &str) {
    // A report must be readable without a network.
    for (at, _) in report.match_indices("://") {
        assert!(
            report[at..].starts_with("://www.w3.org/2000/svg\""),
            "{}",
            &report[at - 9..at + 30]
        );
    }
    for (at, _) in report.match_indices("src=") {
        assert!(report[at + 4..].starts_with("\"data:"), "{}", &report[at..at + 30]);
    }
    assert!(
        !report.contains("<script") && !report.contains("<link") && !report.contains("@import")
    );
}

#[test]
fn the_demo_ends_with_metrics_and_a_report_and_its_checkpoint_can_be_used() {
    let sandbox = Sandbox::new();
    let output = sandbox.ok(&tiny(&["demo", "--out", "demo", "--stride-ms", "10"]));
    let next = output.trim_end().lines().last().unwrap();
    assert!(next.starts_with("next:    evpose infer --checkpoint demo/train"), "{output}");

    let metrics = sandbox.json("demo/metrics.json");
    for method in ["mean_pose", "untrained", "trained", "trained_kalman"] {
        for number in ["translation_mm", "rotation_deg", "articulation", "auc_3d", "auc_2d"] {
            let interval = &metrics["held_out"][method][number];
            let part = |name: &str| interval[name].as_f64().unwrap_or(f64::NAN);
            let (low, estimate, high) = (part("low"), part("estimate"), part("high"));
            assert!(low <= estimate && estimate <= high, "{method}.{number}: {interval}");
        }
    }
    let report = sandbox.text("demo/report.html");
    // Two of correct points, and the learning curves.
    assert!(report.matches("<svg").count() > 2 && report.ends_with("</html>\n"));
    for image in ["data:image/gif;base64,R0lGOD", "data:image/png;base64,iVBORw0KGgo"] {
        assert!(report.contains(image), "the report lacks {image}");
    }
    is_of_its_metrics(&report, &metrics);
    is_self_contained(&report);
    let translation = |name: &str| metrics["held_out"][name]["translation_mm"]["estimate"].clone();
    assert_ne!(translation("trained"), translation("untrained"), "it has learned something");
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
    let poses = sandbox.text("poses.csv");
    let joints = sandbox.text("joints.csv");
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
    // By its path, as in a checkout.
    std::fs::create_dir(sandbox.path("checkpoints")).unwrap();
    std::fs::copy(shipped, sandbox.path("checkpoints/hand.bpk")).unwrap();
    let demo = ["demo", "--minutes", "1", "--out", "shown", "--stride-ms", "20"];
    let small = ["--set", "evaluation.sequences=2", "--set", "evaluation.seconds=0.4"];
    let output = sandbox.ok(&[&demo[..], &small].concat());
    assert!(output.contains("hand.bpk") && output.contains("report.html"), "{output}");
    assert!(output.contains("nothing was trained"), "{output}");
    let next = output.trim_end().lines().last().unwrap();
    assert!(next.starts_with("next:    evpose demo --minutes 9"), "{output}");
    for file in ["config.toml", "run.toml", "frames.png"] {
        assert!(sandbox.path("shown").join(file).exists(), "{file} is missing");
    }
    let report = sandbox.text("shown/report.html");
    let metrics = sandbox.json("shown/metrics.json");
    is_of_its_metrics(&report, &metrics);
    // No section without content.
    assert!(report.contains("Nothing was trained") && !report.contains("Learning curves"));
    let message = sandbox.fails(&["demo", "--minutes", "0"]);
    assert!(message.contains("--minutes"), "{message}");
}
