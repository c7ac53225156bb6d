//! The program as a user runs it, with a stand-in for `evpose`.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::Path;
use std::process::{Command, Output};

/// Runs `gapbench` with the words of a line in a directory.
fn gapbench(dir: &Path, line: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gapbench"));
    command.current_dir(dir).args(line.split_whitespace()).output().unwrap()
}

fn text(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes)).concat()
}

#[test]
fn inputs_that_cannot_be_used_end_with_two_and_say_why() {
    let dir = tempfile::tempdir().unwrap();
    for (line, part) in [
        ("run --plan 7 --shard 3/2 --out out", "--shard"),
        ("run --plan nothing.toml --out out", "nothing.toml"),
        ("run --plan 7 --tier hme --out out", "home"),
        ("run --plan 7 --out out --evpose nowhere/evpose", "cargo build --release"),
        ("cases --plan 7 --shard 0/2 --out out", "--shard"),
        ("own --plan seven --sets 1 --out out", "seven"),
        ("score nowhere", "nowhere"),
        ("outside nowhere --out there", "nowhere"),
        ("real rec.raw --out out --evpose nowhere/evpose", "cargo build --release"),
        ("calibrate nowhere --out fit.json", "nowhere"),
    ] {
        let output = gapbench(dir.path(), line);
        assert_eq!(output.status.code(), Some(2), "{line}: {}", text(&output));
        assert!(text(&output).contains(part), "{line}: {}", text(&output));
    }
    assert!(!dir.path().join("out").exists());
}

#[test]
fn cases_are_files_of_measurements_and_have_their_truth_only_if_it_is_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    for (flags, is_open) in [("", false), ("--truth", true)] {
        let line =
            format!("cases --plan 7 --tier plain --only null --limit 1 {flags} --out {is_open}");
        let output = gapbench(dir.path(), &line);
        assert!(output.status.success(), "{}", text(&output));
        let cases = dir.path().join(is_open.to_string()).join("cases");
        let case = cases.read_dir().unwrap().next().unwrap().unwrap().path();
        for name in ["measured.npz", "scene.json", "frames.npy"] {
            assert!(case.join("train").join(name).is_file(), "{name}");
            assert!(case.join("validation").join(name).is_file(), "{name}");
        }
        assert_eq!(case.join("truth.json").is_file(), is_open);
    }
}

/// Answer of the stand-in to every recording, and its evidence.
const VERDICT: &str = r#"{"schema": 3, "verdict": "effects", "effects": [{"name": "leak_on", "kind": "effect",
    "parameters": {"rate_hz": {"value": 2.0, "lo90": 1.5, "hi90": 2.5, "unit": "Hz"}}, "probability": 0.9,
    "confusable_with": []}], "unexplained": {"fraction": 0.1, "p": 0.5, "is_significant": false,
    "nearest_stage": "", "sentence": "", "shares": {}, "responses": []}, "gap_before": {"value": 3.5, "lo": 2, "hi": 4},
    "gap_after": {"value": 0.5, "lo": 0.2, "hi": 0.9}, "grr": 0.75, "p": 0.01,
    "where": {"sentence": "", "shares": {}, "responses": []}, "stage_shares": {}, "limits": [], "untestable": {},
    "c2st_before": null, "c2st_after": null, "notes": []}"#;
const EVIDENCE: &str = r#"{"effects": {"leak_on": {"log_odds": 5.0, "gap_after": 0.5}}, "errors": {"leak_on":
    {"rate_hz": {"curvature": 0.1, "widened": 1.0, "blocks": 0.2, "runs": 0.1}}},
    "contenders": [[["leak_on", 120.5], ["hot_pixels", 300.0]]], "events": 1234}"#;

// One test: a process that another test starts meanwhile would hold the script open.
#[cfg(unix)]
#[test]
fn a_row_is_what_the_program_wrote_and_a_run_that_failed_is_gone_on_with() {
    use std::os::unix::fs::PermissionsExt as _;

    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    std::fs::write(path("verdict.json"), VERDICT).unwrap();
    std::fs::write(path("evidence.json"), EVIDENCE).unwrap();
    let script = "#!/bin/sh
if [ \"$1\" = --version ]; then echo 'evpose 1.0 (commit 0123abc)'; exit; fi
echo \"$*\" >> arguments.txt
while [ \"$1\" != --out ]; do shift; done
[ -e broken ] || cp verdict.json evidence.json \"$2\"
exit 11
";
    std::fs::write(path("evpose"), script).unwrap();
    std::fs::set_permissions(path("evpose"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let line =
        "run --plan 7 --tier plain --only null --limit 2 --out out --threads 1 --evpose ./evpose";
    std::fs::write(path("broken"), "").unwrap();
    let output = gapbench(dir.path(), line);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let said = text(&output);
    assert!(said.contains("exit status: 11") && said.contains("output.txt"), "{said}");
    std::fs::remove_file(path("broken")).unwrap();
    let output = gapbench(dir.path(), &format!("{line} --resume"));
    assert!(output.status.success(), "{}", text(&output));
    let rows = std::fs::read_to_string(path("out/results.jsonl")).unwrap();
    let rows: Vec<serde_json::Value> =
        rows.lines().map(|row| serde_json::from_str(row).unwrap()).collect();
    assert_eq!(rows.len(), 2);
    let (verdict, evidence): (serde_json::Value, serde_json::Value) =
        (serde_json::from_str(VERDICT).unwrap(), serde_json::from_str(EVIDENCE).unwrap());
    for row in &rows {
        for (key, value) in [
            ("verdict", &verdict["verdict"]),
            ("effects", &verdict["effects"]),
            ("gap_before", &verdict["gap_before"]["value"]),
            ("gap_after", &verdict["gap_after"]["value"]),
            ("grr", &verdict["grr"]),
            ("evidence", &evidence["effects"]),
            ("errors", &evidence["errors"]),
            ("tried", &evidence["contenders"]),
            ("events", &evidence["events"]),
            ("threads", &1.into()),
            ("commit", &"0123abc".into()),
        ] {
            assert_eq!(row[key], *value, "{key}");
        }
    }
    // Files of the cases without labels, as the program was asked to compare them.
    let arguments = std::fs::read_to_string(path("arguments.txt")).unwrap();
    let last = arguments.lines().last().unwrap();
    let case = format!("out/cases/{}", rows[1]["id"].as_str().unwrap());
    let [train, validation] = ["train", "validation"].map(|part| format!("{case}/{part}"));
    let inputs = format!(
        "--measured {train}/measured.npz --scene {train} --validate {validation}/measured.npz --validate-scene \
         {validation}"
    );
    assert!(
        last.starts_with("gap run --model ideal --quick --seed 1") && last.contains(&inputs),
        "{last}"
    );
    // Every null has a name that is wrong.
    let scores = std::fs::read_to_string(path("out/scores.json")).unwrap();
    let scores: serde_json::Value = serde_json::from_str(&scores).unwrap();
    assert_eq!((&scores["nulls_named"]["of"], &scores["nulls_named"]["n"]), (&2.into(), &2.into()));
    assert!(!path("out/cases").exists() && !path("out/reports").exists());
}
