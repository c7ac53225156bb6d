//! The task of the example, through the commands, small: simulated, trained, scored, inferred, live.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

/// Errors by method and value.
type Errors = BTreeMap<String, BTreeMap<String, f64>>;

fn blob(directory: &Path, line: &str) -> Output {
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/blob.toml");
    let line = line.replace("CONFIG", config);
    let mut command = Command::new(env!("CARGO_BIN_EXE_evpose-blob"));
    command.args(line.split_whitespace()).current_dir(directory).output().unwrap()
}

fn ok(directory: &Path, line: &str) -> String {
    let output = blob(directory, line);
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(directory: &Path, line: &str, code: i32) -> String {
    let output = blob(directory, line);
    assert_eq!(output.status.code(), Some(code), "{line}");
    String::from_utf8(output.stderr).unwrap()
}

/// The values of a table by time stamp.
fn table(path: &Path) -> BTreeMap<i64, [f32; 3]> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at = |name: &str| names.iter().position(|known| *known == name).unwrap();
    let values = ["centre_u_px", "centre_v_px", "size_px"].map(at);
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            (cells[at("t_us")].parse().unwrap(), values.map(|cell| cells[cell].parse().unwrap()))
        })
        .collect()
}

/// Mean errors of the centre and of the size; the truth is linear between its rows.
fn errors(poses: &BTreeMap<i64, [f32; 3]>, truth: &BTreeMap<i64, [f32; 3]>) -> [f64; 2] {
    let (mut sums, mut count) = ([0.0; 2], 0.0);
    for (t, [u, v, size]) in poses {
        let before = truth.range(..=t).next_back();
        let Some(((before, from), (behind, to))) = before.zip(truth.range(t..).next()) else {
            continue;
        };
        let part = (t - before) as f32 / (behind - before).max(1) as f32;
        let [true_u, true_v, true_size] = [0, 1, 2].map(|k| from[k] + part * (to[k] - from[k]));
        sums[0] += f64::from((u - true_u).hypot(v - true_v));
        sums[1] += f64::from((size - true_size).abs());
        count += 1.0;
    }
    sums.map(|sum| sum / count)
}

#[test]
fn a_third_task_is_simulated_trained_scored_inferred_and_live() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    ok(at, "simulate CONFIG --out train --sequences 160 --seconds 0.5");
    ok(at, "simulate CONFIG --out test --sequences 1 --seconds 1.5 --held-out");
    let text = ok(at, "info test");
    assert!(text.contains("a disc that moves") && text.contains("1 of 1 complete"), "{text}");
    let text = ok(
        at,
        "train CONFIG --data train --out run --plain --set training.steps=180 \
         --set training.steps_per_validation=90",
    );
    assert!(text.contains("5760 samples") && text.contains("best.bpk"), "{text}");
    let text = ok(at, "info run/best.bpk");
    assert!(text.contains("blobs:") && text.contains("task = \"blob\""), "{text}");

    ok(at, "eval --checkpoint run --data test --json scores.json");
    let scores = std::fs::read_to_string(at.join("scores.json")).unwrap();
    let scores: Errors = serde_json::from_str(&scores).unwrap();
    let (network, mean) = (&scores["network"], &scores["mean pose"]);
    for name in ["centre_px", "size_px"] {
        assert!(network[name] < 0.6 * mean[name], "{name}: {network:?}, {mean:?}");
    }

    // What is scored is what is inferred.
    ok(at, "infer --checkpoint run --events test/0000.raw --out poses.csv");
    let (truth, poses) = (table(&at.join("test/0000.poses.csv")), table(&at.join("poses.csv")));
    assert!(poses.len() > 140, "{}", poses.len());
    let [centre, size] = errors(&poses, &truth);
    assert!((centre - network["centre_px"]).abs() < 1e-4, "{centre}, {network:?}");
    assert!((size - network["size_px"]).abs() < 1e-4, "{size}, {network:?}");

    // Online, inputs are taken at other times, of the same network.
    ok(at, "live --checkpoint run --source test/0000.raw --speed max --csv live.csv --stride-ms 5");
    let live = table(&at.join("live.csv"));
    assert!(live.len() > 100, "{}", live.len());
    let [centre, size] = errors(&live, &truth);
    assert!(centre < 0.6 * mean["centre_px"] && size < 0.6 * mean["size_px"], "{centre} {size}");

    let text = refused(at, "export --checkpoint run --onnx blob.onnx", 1);
    assert!(text.contains("task `blob` are not exported"), "{text}");
    for line in ["eval --checkpoint run --data no --fusion", "train CONFIG --start-from run"] {
        let text = refused(at, line, 2);
        let flag = line.split(' ').find(|word| ["--fusion", "--start-from"].contains(word));
        let said = format!("{} is not for the task `blob`", flag.unwrap());
        assert!(text.contains(&said), "{text}");
    }
    let text = refused(at, "live --checkpoint run --source test/0000.raw --task hand", 1);
    assert!(text.contains("of the task `blob`, not `hand`"), "{text}");
}

#[test]
fn a_task_is_a_folder_of_six_files_and_five_hundred_lines_at_most() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let lines = files.map(|path| std::fs::read_to_string(path).unwrap().lines().count());
    let lines: Vec<usize> = lines.collect();
    assert!(lines.len() <= 6 && lines.iter().sum::<usize>() <= 500, "{lines:?}");
}
