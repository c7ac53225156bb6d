//! The ablation, small.

use std::process::Stdio;
use std::sync::LazyLock;
use std::time::Duration;

use crate::harness::{Sandbox, bytes, stderr, tiny};

/// Two trained rows and one that differs in evaluation only, under two seeds.
fn ablate<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut args = tiny(&["ablate", "hand", "--rows", "eoi,no-filter", "--seeds", "2"]);
    // Windows of the longest row are full from 300 ms on.
    args.extend(["--set", "evaluation.seconds=0.5", "--stride-ms", "10", "--out", out]);
    args.extend(more);
    args
}

fn outcome(sandbox: &Sandbox, out: &str) -> serde_json::Value {
    serde_json::from_slice(&bytes(&sandbox.path(out).join("ablation.json"))).unwrap()
}

/// The part of an outcome that does not depend on the speed of the machine.
fn figures(outcome: &serde_json::Value) -> serde_json::Value {
    let rows = outcome["rows"].as_array().unwrap().iter();
    let rows: Vec<_> = rows.map(|row| [&row["name"], &row["per_seed"]]).collect();
    serde_json::json!([rows, outcome["findings"]])
}

/// The ablation whole, which others are compared with, and what it said.
static WHOLE: LazyLock<(Sandbox, String)> = LazyLock::new(|| {
    let sandbox = Sandbox::new();
    let said = sandbox.ok(&ablate("whole", &[]));
    (sandbox, said)
});

#[test]
fn an_ablation_ends_with_a_table_curves_and_verdicts_and_survives_being_killed() {
    let (of_whole, said) = &*WHOLE;
    let outcome_whole = outcome(of_whole, "whole");
    let rows = outcome_whole["rows"].as_array().unwrap();
    let names: Vec<_> = rows.iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["lnes-100", "eoi", "no-filter", "mean-pose"]);
    for row in rows {
        for measure in ["auc_2d", "auc_3d", "mpjpe_mm"] {
            let part = |name: &str| row["means"][measure][name].as_f64().unwrap();
            let (low, estimate, high) = (part("low"), part("estimate"), part("high"));
            assert!(low <= estimate && estimate <= high, "{row}");
        }
    }
    for row in &rows[..3] {
        assert_eq!(row["means"]["parameters"], rows[0]["means"]["parameters"], "one network");
        assert!(row["means"]["poses_per_s"]["estimate"].as_f64().unwrap() > 0.0);
    }
    assert_eq!(rows[0]["means"]["parameters_as_published"]["estimate"], 11_182_725.0);
    assert_eq!(outcome_whole["findings"][0]["published"], "LNES beats EOI at 100 ms");
    assert!(rows[1]["per_seed"] != rows[0]["per_seed"], "another input, other poses");
    assert!(rows[2]["per_seed"] != rows[0]["per_seed"], "the filter does something");

    assert!(said.contains("| no-filter") && said.contains("| mean-pose"), "{said}");
    let markdown = of_whole.text("whole/ablation.md");
    assert!(markdown.contains("| worse than lnes-100 |"), "{markdown}");
    let page = of_whole.text("whole/ablation.html");
    assert!(page.contains("<svg") && page.contains("</html>"));
    assert!(!page.contains("<script src") && !page.contains("<link"), "self-contained");
    for file in ["config.toml", "run.toml", "data/seed-1/train/0000.evc", "data/seed-2/held-out"] {
        assert!(of_whole.path("whole").join(file).exists(), "{file} is missing");
    }

    let sandbox = Sandbox::new();
    // Killed in the middle of the second row, whose first training has begun.
    let begun = sandbox.path("killed/rows/eoi/seed-1/metrics.jsonl");
    sandbox.kill(&ablate("killed", &[]), || begun.exists(), Duration::ZERO);
    let unjudged = sandbox.path("killed/rows/eoi/seed-1/trial.json");
    assert!(!unjudged.exists(), "the kill came too late to test anything");
    let kept = bytes(&sandbox.path("killed/rows/lnes-100/seed-2/trial.json"));

    let message = sandbox.fails(&ablate("killed", &[]));
    assert!(message.contains("--resume"), "{message}");
    let other = ablate("killed", &["--resume", "--set", "training.steps=13"]);
    let message = sandbox.fails(&other);
    assert!(message.contains("config.toml differs"), "{message}");

    sandbox.ok(&ablate("killed", &["--resume"]));
    assert_eq!(figures(&outcome(&sandbox, "killed")), figures(&outcome_whole));
    // Times in it would differ if it had been made again.
    assert!(bytes(&sandbox.path("killed/rows/lnes-100/seed-2/trial.json")) == kept);

    // Killed after the training, before its evaluation.
    std::fs::remove_file(&unjudged).unwrap();
    std::fs::remove_file(sandbox.path("killed/rows/eoi/seed-1/trained.json")).unwrap();
    sandbox.ok(&ablate("killed", &["--resume"]));
    assert_eq!(figures(&outcome(&sandbox, "killed")), figures(&outcome_whole));
}

#[test]
fn shards_of_an_ablation_share_recordings_and_end_with_the_table_of_one_process() {
    let sandbox = Sandbox::new();
    let whole = figures(&outcome(&WHOLE.0, "whole"));
    // Four trials: the first shard has two, of different seeds, whose recordings the others need too.
    let shards = ["1/3", "2/3", "3/3"].map(|shard| {
        let mut command = sandbox.evpose(&ablate("parts", &["--shard", shard]));
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    });
    for shard in shards {
        let output = shard.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
    }
    assert_eq!(figures(&outcome(&sandbox, "parts")), whole, "whoever ends last writes all of it");
    assert!(sandbox.fails(&ablate("parts", &["--shard", "1/3"])).contains("--resume"));

    // A trial of the first shard is missing: the second says so, and a run without shards makes it.
    std::fs::remove_file(sandbox.path("parts/rows/eoi/seed-2/trial.json")).unwrap();
    let said = sandbox.ok(&ablate("parts", &["--shard", "2/3", "--resume"]));
    assert!(said.contains("of other shards are not finished: eoi, seed 2"), "{said}");
    let rows = outcome(&sandbox, "parts")["rows"].as_array().unwrap().len();
    assert_eq!(rows, 3, "the full method, the same without a filter, the mean pose");
    sandbox.ok(&ablate("parts", &["--resume"]));
    assert_eq!(figures(&outcome(&sandbox, "parts")), whole);
}

#[test]
fn what_cannot_be_run_is_said_before_anything_is() {
    let sandbox = Sandbox::new();
    // Refused before anything is simulated or trained: rows take hours.
    let args = tiny(&["ablate", "hand", "--rows", "vgg11-bn", "--out", "x"]);
    let message = sandbox.fails(&args);
    assert!(message.contains("row vgg11-bn") && message.contains("network.backbone"), "{message}");
    let args = tiny(&["ablate", "hand", "--rows", "inception-v3", "--out", "x"]);
    let message = sandbox.fails(&args);
    assert!(message.contains("row inception-v3") && message.contains("75 pixels"), "{message}");
    let message = sandbox.fails(&["ablate", "hand", "--rows", "lnes-99", "--out", "x"]);
    assert!(message.contains("lnes-100") && message.contains("mnasnet"), "{message}");
    let other = ["ablate", "hand", "--set", "representation.window_ms=50", "--out", "x"];
    let message = sandbox.fails(&other);
    assert!(message.contains("representation"), "{message}");
    // A refused command leaves nothing behind.
    assert!(!sandbox.path("x").exists());
    assert!(sandbox.ok(&["ablate", "hand", "--help"]).contains("evpose ablate hand"));
}
