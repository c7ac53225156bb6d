//! Every command that goes on where it was killed, killed before each of its writes in turn.
//!
//! Files have their final name once they are whole, and nothing else is written between: so these are all the states
//! in which a kill can leave a directory, but for files with temporary names.
#![cfg(debug_assertions)]

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::harness::{Sandbox, bytes, stderr, tiny, tiny_body};
use crate::own_labels::person;
use crate::payoff::gap_run;
use crate::prepare::mpii;

/// Endings of files of a result that are the same bytes in every run of a command. Others hold times or machines.
const SAME: [&str; 10] = [
    "bpk",
    "csv",
    "evc",
    "raw",
    "meta",
    "png",
    "sha256",
    "metrics.jsonl",
    "config.toml",
    "poses.json",
];

/// The files of a directory that must be the same, and the values of the results of studies without times.
fn contents(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut contents = BTreeMap::new();
    let mut directories = vec![directory.to_owned()];
    while let Some(inner) = directories.pop() {
        for entry in std::fs::read_dir(&inner).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(directory).unwrap().to_str().unwrap().to_owned();
            if path.is_dir() {
                directories.push(path);
            } else if SAME.iter().any(|ending| name.ends_with(ending)) {
                contents.insert(name, bytes(&path));
            } else if name.ends_with(".json") && inner == directory {
                let mut value: Value = serde_json::from_slice(&bytes(&path)).unwrap();
                remove_times(&mut value);
                contents.insert(name, value.to_string().into_bytes());
            }
        }
    }
    contents
}

/// Removes what a result has of the speed of a machine, of what else it did, and of the command, which has `--resume`.
fn remove_times(value: &mut Value) {
    let is_time = |name: &str| {
        let of_run = ["load_before", "command"].contains(&name);
        of_run || name.ends_with("_s") || name.ends_with("_ms") || name.contains("time")
    };
    match value {
        Value::Object(fields) => {
            fields.retain(|name, _| !is_time(name));
            // Measured rates of a network are results of a study, by name.
            fields.retain(|_, value| {
                value.get("measure").and_then(Value::as_str) != Some("poses_per_s")
            });
            fields.values_mut().for_each(remove_times);
        }
        Value::Array(values) => {
            values.retain(|value| value["measure"] != "poses_per_s");
            values.iter_mut().for_each(remove_times);
        }
        _ => {}
    }
}

/// Kills `command` before each of its writes, goes on with `resumed` added, and compares with a run that was not
/// killed. `command` makes the directory `out`. Returns the count of kills.
fn kill_at_every_write(sandbox: &Sandbox, command: &[&str], resumed: &[&str]) -> u64 {
    let out = sandbox.path("out");
    sandbox.ok(command);
    let whole = contents(&out);
    assert!(!whole.is_empty(), "nothing to compare");
    let mut kills = 0;
    loop {
        std::fs::remove_dir_all(&out).unwrap();
        let mut killed = sandbox.evpose(command);
        let output = killed.env("EVPOSE_ABORT_AT_WRITE", (kills + 1).to_string()).output().unwrap();
        // A run that ends before its kill has no write left to be killed at.
        if output.status.success() {
            assert!(contents(&out) == whole, "not the same twice");
            return kills;
        }
        assert_eq!(output.status.code(), None, "no kill: {}", stderr(&output));
        kills += 1;
        let output = sandbox.evpose(&[command, resumed].concat()).output().unwrap();
        assert!(output.status.success(), "killed before write {kills}:\n{}", stderr(&output));
        let found = contents(&out);
        let names = whole.keys().chain(found.keys());
        let differing: Vec<&String> =
            names.filter(|name| whole.get(*name) != found.get(*name)).collect();
        assert!(differing.is_empty(), "killed before write {kills}: {differing:?} differ");
    }
}

/// Trainings of two validations.
const SHORT: &[&str] =
    &["--set", "training.steps=2", "--set", "training.steps_per_validation=1", "--threads", "2"];

#[test]
fn simulate() {
    let command = tiny(&["simulate", "quick", "--out", "out"]);
    let kills = kill_at_every_write(&Sandbox::new(), &command, &["--resume"]);
    // Config and origin, five files of each of two sequences, the manifest.
    assert_eq!(kills, 13);
}

#[test]
#[ignore = "a minute: two runs for each write"]
fn simulate_bodies() {
    let command = tiny_body(&["simulate", "finetune", "--out", "out"]);
    assert_eq!(kill_at_every_write(&Sandbox::new(), &command, &["--resume"]), 15);
}

#[test]
fn train() {
    let sandbox = Sandbox::with_hands();
    let train = tiny(&["train", "quick", "--data", "data", "--out", "out", "--plain"]);
    let filter = ["--set", "training.estimate_filter=true"];
    let kills =
        kill_at_every_write(&sandbox, &[&train[..], SHORT, &filter].concat(), &["--resume"]);
    // Config, history, two checkpoints with their times, the last and the best network, curves, origin.
    assert_eq!(kills, 2 + 2 * 4 + 2 + 2);
}

#[test]
#[ignore = "a minute: two runs for each write"]
fn train_bodies() {
    let train = tiny_body(&["train", "pretrain", "--out", "out", "--plain"]);
    let kills = kill_at_every_write(&Sandbox::new(), &[&train[..], SHORT].concat(), &["--resume"]);
    assert!(kills >= 14, "{kills}");
}

#[test]
#[ignore = "a quarter of an hour: two runs for each write"]
fn tune() {
    let sandbox = Sandbox::with_hands();
    sandbox.write("over.toml", "training.learning_rate = { choose = [1e-3] }\n");
    let tune =
        ["tune", "quick", "--over", "over.toml", "--data", "data", "--out", "out", "--trials", "2"];
    let filter = ["--set", "training.estimate_filter=true"];
    let command = [&tiny(&tune)[..], SHORT, &filter].concat();
    let kills = kill_at_every_write(&sandbox, &command, &["--resume"]);
    assert!(kills >= 2 * 12, "{kills}");
}

#[test]
#[ignore = "a quarter of an hour: two runs for each write"]
fn payoff() {
    let sandbox = Sandbox::new();
    gap_run(&sandbox);
    let payoff =
        ["gap", "payoff", "gap", "--camera", "camera.toml", "--seeds", "1", "--out", "out"];
    let filter = ["--set", "training.estimate_filter=true", "--stride-ms", "20"];
    let command = [&tiny(&payoff)[..], SHORT, &filter].concat();
    let kills = kill_at_every_write(&sandbox, &command, &["--resume"]);
    assert!(kills >= 2 * (11 + 12), "{kills}");
}

#[test]
#[ignore = "a quarter of an hour: two runs for each write"]
fn ablate() {
    let ablate = ["ablate", "hand", "--rows", "no-filter", "--seeds", "1", "--out", "out"];
    let longer = ["--stride-ms", "10", "--set", "evaluation.seconds=0.5"];
    let command = [&tiny(&ablate)[..], SHORT, &longer].concat();
    let kills = kill_at_every_write(&Sandbox::new(), &command, &["--resume"]);
    assert!(kills >= 2 * 11 + 12, "{kills}");
}

#[test]
#[ignore = "a quarter of an hour: two runs for each write"]
fn compare_body() {
    let compare = ["compare", "body", "--systems", "move-enet,mean-pose", "--out", "out"];
    let short = ["--steps", "2", "--seeds", "1"];
    let command = [&tiny_body(&compare)[..], &short].concat();
    let kills = kill_at_every_write(&Sandbox::new(), &command, &["--resume"]);
    assert!(kills >= 20, "{kills}");
}

#[test]
#[ignore = "a quarter of an hour: two runs for each write"]
fn compare_clips() {
    let sandbox = Sandbox::new();
    crate::compare::write_clips(&sandbox);
    let start = ["train", "pretrain", "--data", "clips/a", "--out", "start"];
    let annotated = ["--set", "data.source=annotations", "--data", "clips/b"];
    sandbox.ok(&[&tiny_body(&start)[..], &annotated].concat());
    let clips =
        ["compare", "clips", "clips", "--config", "pretrain", "--start", "start", "--out", "out"];
    let kills =
        kill_at_every_write(&sandbox, &[&tiny_body(&clips)[..], SHORT].concat(), &["--resume"]);
    assert!(kills >= 2 * 2 * 10, "{kills}");
}

/// The same command once more is the resume.
#[test]
fn prepare() {
    let kills = kill_at_every_write(&mpii(), &["prepare", "mpii", "MPII", "--out", "out"], &[]);
    assert!(kills >= 2, "{kills}");
    let people =
        ["prepare", "people", "foreign/0000.npz", "--labels", "foreign/0000.csv", "--out", "out"];
    assert!(kill_at_every_write(&person(), &people, &[]) >= 3);
}
