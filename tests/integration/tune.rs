//! `evpose tune`, with tiny settings.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use crate::harness::{Sandbox, bytes, stderr, tiny, tiny_body};

const OVER: &str = "[training]\nlearning_rate = { log_uniform = [1e-4, 1e-2] }\nbatch_size = { choose \
                    = [2, 4] }\n";

/// A sandbox with recordings and a file of ranges.
fn sandbox(over: &str) -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("over.toml", over);
    sandbox
}

fn hands<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut args = tiny(&["tune", "quick", "--over", "over.toml", "--data", "data", "--out", out]);
    if !more.contains(&"--trials") {
        args.extend(["--trials", "3"]);
    }
    args.extend(["--threads", "2"]);
    args.extend(more);
    args
}

fn bodies<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut args = tiny_body(&["tune", "pretrain", "--over", "over.toml", "--out", out]);
    args.extend(["--trials", "4", "--method", "halving", "--eta", "2", "--rank", "accuracy"]);
    args.extend(["--set", "training.steps=4", "--set", "training.steps_per_validation=1"]);
    args.extend(more);
    args
}

/// Every file of a directory and of those in it by its path, but for logs of waiting times.
fn tree(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut directories = vec![directory.to_owned()];
    while let Some(inner) = directories.pop() {
        for entry in std::fs::read_dir(&inner).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(directory).unwrap().to_str().unwrap().to_owned();
            if path.is_dir() {
                directories.push(path);
            } else if !name.ends_with("loading.jsonl") {
                files.insert(name, bytes(&path));
            }
        }
    }
    files
}

/// Names of the files in which two directories differ.
fn differences(sandbox: &Sandbox, one: &str, other: &str) -> Vec<String> {
    let [one, other] = [one, other].map(|name| tree(&sandbox.path(name)));
    let names = one.keys().chain(other.keys());
    let mut names: Vec<String> =
        names.filter(|name| one.get(*name) != other.get(*name)).cloned().collect();
    names.dedup();
    names
}

fn outcome(sandbox: &Sandbox, out: &str) -> serde_json::Value {
    serde_json::from_slice(&bytes(&sandbox.path(out).join("tune.json"))).unwrap()
}

#[test]
fn a_search_of_hands_is_the_same_in_one_process_in_shards_and_after_a_kill() {
    let sandbox = sandbox(OVER);
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
    let said = sandbox.ok(&hands("whole", &[]));
    for part in ["rung 1: 3 trials to step 12", "trial 2: training.learning_rate = ", "best.toml"] {
        assert!(said.contains(part), "{part} is missing in\n{said}");
    }
    let found = outcome(&sandbox, "whole");
    assert_eq!((&found["task"], &found["is_complete"]), (&"hand".into(), &true.into()));
    let trials = found["trials"].as_array().unwrap();
    let scores: Vec<f64> = trials.iter().map(|trial| trial["score"].as_f64().unwrap()).collect();
    assert!(scores.len() == 3 && scores.is_sorted(), "{scores:?}");
    // The score is the lowest loss that the training logged.
    let best = &trials[0];
    let run = format!("whole/trials/{:04}/run", best["trial"].as_u64().unwrap());
    let losses = best["validations"].as_array().unwrap().iter();
    let losses: Vec<f64> = losses.map(|v| v["values"]["loss"].as_f64().unwrap()).collect();
    assert_eq!((losses.len(), losses.iter().copied().reduce(f64::min)), (4, Some(scores[0])));
    // Trial 0 is the config as it is, and the best config is that of the best run.
    let base = trials.iter().find(|trial| trial["trial"] == 0).unwrap();
    assert_eq!(base["values"]["training.learning_rate"], 0.001);
    let config = sandbox.text("whole/best.toml");
    let of_run = sandbox.text(&format!("{run}/config.toml"));
    assert!(config.starts_with("# Trial ") && config.ends_with(&of_run), "{config}");
    let page = sandbox.text("whole/tune.html");
    assert_eq!(page.matches("<svg").count(), 3, "two parameters and one rung");
    assert!(
        !sandbox.path(&run).join("checkpoint").exists()
            && sandbox.path(&run).join("best.bpk").exists()
    );
    let table = sandbox.text("whole/trials.csv");
    assert_eq!(table.lines().count(), 4);

    // Trained as a config of its own, it is the same network.
    sandbox.ok(&["train", "whole/best.toml", "--data", "data", "--out", "again", "--plain"]);
    let again = bytes(&sandbox.path("again/best.bpk"));
    assert!(again == bytes(&sandbox.path(&run).join("best.bpk")), "another network");

    // Two shards at once.
    let shards = ["1/2", "2/2"].map(|shard| {
        let mut command = sandbox.evpose(&hands("parts", &["--shard", shard]));
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    });
    for shard in shards {
        let output = shard.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
    }
    assert_eq!(differences(&sandbox, "whole", "parts"), Vec::<String>::new());

    // Killed in its second trial.
    let begun = sandbox.path("killed/trials/0001/run/checkpoint/schedule-1.bpk");
    sandbox.kill(&hands("killed", &[]), || begun.exists(), Duration::ZERO);
    assert!(!sandbox.path("killed/trials/0001/rung-1.json").exists(), "the kill came too late");
    assert_eq!(outcome(&sandbox, "killed")["is_complete"], false);
    assert!(sandbox.fails(&hands("killed", &[])).contains("--resume"));
    sandbox.ok(&hands("killed", &["--resume"]));
    assert_eq!(differences(&sandbox, "whole", "killed"), Vec::<String>::new());
    let other = hands("killed", &["--resume", "--set", "training.steps=9"]);
    let message = sandbox.fails(&other);
    assert!(message.contains("differs from what is given"), "{message}");
}

#[test]
fn bodies_are_halved_and_shards_meet_at_the_end_of_each_rung() {
    let sandbox = sandbox("training.learning_rate = { log_uniform = [1e-4, 1e-2] }\n");
    let said = sandbox.ok(&bodies("whole", &[]));
    assert!(said.contains("rung 3: 1 trials to step 4"), "{said}");
    let found = outcome(&sandbox, "whole");
    let trials = found["trials"].as_array().unwrap();
    let rungs: Vec<u64> = trials.iter().map(|trial| trial["rung"].as_u64().unwrap()).collect();
    assert_eq!(rungs, [3, 2, 1, 1]);
    let validations = |trial: &serde_json::Value| trial["validations"].as_array().unwrap().len();
    assert_eq!(trials.iter().map(validations).collect::<Vec<_>>(), [4, 2, 1, 1]);
    let score = |trial: &serde_json::Value| trial["score"].as_f64().unwrap();
    // Those that ended at the first rung were no better there than those that went on.
    let first = |trial: u64| -> serde_json::Value {
        let path = format!("whole/trials/{trial:04}/rung-1.json");
        sandbox.json(&path)
    };
    let accuracy = |index: usize| {
        let result = first(trials[index]["trial"].as_u64().unwrap());
        result["validations"][0]["values"]["accuracy"].as_f64().unwrap()
    };
    assert!(accuracy(0).min(accuracy(1)) >= accuracy(2).max(accuracy(3)));
    assert!(score(&trials[2]) >= score(&trials[3]));

    // A training of its own, not stopped on its way, is the same.
    let best = trials[0]["trial"].as_u64().unwrap();
    sandbox.ok(&["train", "whole/best.toml", "--out", "again", "--plain"]);
    let run = sandbox.path(&format!("whole/trials/{best:04}/run"));
    assert!(bytes(&sandbox.path("again/best.bpk")) == bytes(&run.join("best.bpk")));

    // A rung ends when the trials of all shards are there; then the shards are started again.
    let mut rounds = 0;
    while !sandbox.path("parts/tune.json").exists()
        || outcome(&sandbox, "parts")["is_complete"] != true
    {
        for shard in ["1/2", "2/2"] {
            sandbox.ok(&bodies("parts", &["--shard", shard, "--resume"]));
        }
        rounds += 1;
        assert!(rounds <= 3, "no end");
    }
    assert!(rounds > 1, "two shards have nothing to wait for");
    // The first shard once more, to leave no checkpoints behind.
    sandbox.ok(&bodies("parts", &["--shard", "1/2", "--resume"]));
    assert_eq!(differences(&sandbox, "whole", "parts"), Vec::<String>::new());
}

#[test]
fn a_trial_that_diverges_is_ranked_last_and_ends_nothing() {
    let sandbox = sandbox("training.learning_rate = { choose = [1e30] }\n");
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
    let said = sandbox.ok(&hands("search", &[]));
    assert!(said.contains("diverged"), "{said}");
    let found = outcome(&sandbox, "search");
    let trials = found["trials"].as_array().unwrap();
    let order: Vec<u64> = trials.iter().map(|trial| trial["trial"].as_u64().unwrap()).collect();
    assert_eq!(order, [0, 1, 2]);
    assert_eq!((&trials[1]["status"], &trials[1]["score"]), (&"diverged".into(), &().into()));
}

#[test]
fn what_cannot_be_searched_is_said_with_line_and_field_before_anything_is_written() {
    let refused = |over: &str, more: &[&str], parts: &[&str]| {
        let sandbox = sandbox(over);
        std::fs::create_dir(sandbox.path("data")).unwrap();
        let message = sandbox.fails(&hands("search", more));
        for part in parts {
            assert!(message.contains(part), "{part} is missing in\n{message}");
        }
        assert!(!sandbox.path("search").exists());
    };
    let unknown = "[training]\nlearning_rates = { uniform = [1, 2] }\n";
    refused(unknown, &[], &["over.toml, line 2", "`training.learning_rates`", "learning_rate"]);
    let wrong = "training.batch_size = { uniform = [1, 2] }\n";
    refused(wrong, &[], &["line 1", "`training.batch_size`", "1.0"]);
    refused("training.steps = 5\n", &[], &["line 1", "`training.steps`", "choose"]);
    refused("seed = { integer = [1, 9] }\n", &[], &["line 1", "`seed`", "shared"]);
    let shared = "simulation.seconds = { integer = [1, 9] }\n";
    refused(shared, &[], &["`simulation.seconds`", "recordings"]);
    let loss = "loss.articulation = { uniform = [0.1, 1] }\n";
    refused(loss, &[], &["`loss.articulation`", "--rank articulation, translation, rotation"]);
    refused(OVER, &["--rank", "accuracy"], &["--rank accuracy", "loss, articulation"]);
    refused(OVER, &["--method", "halving", "--eta", "9"], &["nothing to halve"]);
    let steps = "training.steps = { integer = [4, 8] }\n";
    refused(steps, &["--method", "halving", "--eta", "2"], &["`training.steps`", "random"]);

    // Values that are valid one by one, and not together.
    let both = "[training]\nbatch_size = { choose = [3, 4] }\ndevices = { choose = [1, 4] }\n";
    let message = {
        let sandbox = sandbox(both);
        std::fs::create_dir(sandbox.path("data")).unwrap();
        sandbox.fails(&hands("search", &["--trials", "20"]))
    };
    assert!(message.contains("trial ") && message.contains("training.devices"), "{message}");

    let sandbox = sandbox(OVER);
    let message = sandbox.fails(&["tune", "quick", "--over", "nowhere.toml", "--out", "x"]);
    assert!(message.contains("nowhere.toml"), "{message}");
    assert!(sandbox.fails(&hands("x", &[])).contains("data: no such directory"));
}
