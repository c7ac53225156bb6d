//! `evpose gap payoff`, with tiny settings.

use crate::harness::{BODY_TINY, Sandbox, TINY, bytes};

/// An ideal pixel with these effects beside.
fn sensor(effects: &str) -> String {
    format!(
        "[[effect]]\nname = \"logarithmic\"\ndark_offset = 0.001\n\n[[effect]]\nname = \
         \"level_crossing\"\nthreshold_on = 0.2\nthreshold_off = 0.2\n\n{effects}"
    )
}

/// Output of `evpose gap run`, and the camera that was measured.
pub(crate) fn gap_run(sandbox: &Sandbox) {
    let leak = |rate: f64| sensor(&format!("[[effect]]\nname = \"leak_on\"\nrate_hz = {rate}\n"));
    std::fs::create_dir(sandbox.path("gap")).unwrap();
    let verdict = r#"{"schema": 2, "verdict": "effects", "effects": [{"name": "leak_on"}]}"#;
    for (name, text) in [
        ("gap/verdict.json", verdict.to_owned()),
        ("gap/model.toml", sensor("")),
        ("gap/corrected.toml", leak(19.0)),
        ("camera.toml", leak(20.0)),
    ] {
        sandbox.write(name, text);
    }
}

fn payoff<'a>(changes: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    let mut args = vec!["gap", "payoff", "gap", "--out", "payoff"];
    args.extend(changes.iter().flat_map(|change| ["--set", change]));
    args.extend(more);
    args
}

#[test]
fn a_correction_is_worth_the_difference_of_two_networks_and_a_study_resumes() {
    let sandbox = Sandbox::new();
    gap_run(&sandbox);
    let usual = ["--camera", "camera.toml", "--stride-ms", "20", "--threads", "2"];
    let said =
        sandbox.ok(&payoff(TINY, &[&usual[..], &["--upper-bound", "--seeds", "2"]].concat()));
    for part in ["AUC 2D", "MPJPE mm", "corrected - given", "AUC 2D by seed: seed 1", "leak_on"] {
        assert!(said.contains(part), "{part} is missing in\n{said}");
    }
    let found = sandbox.json("payoff/payoff.json");
    assert_eq!(found["models"], serde_json::json!(["given", "corrected", "camera"]));
    assert_eq!((&found["recordings"], &found["task"]), (&2.into(), &"hand".into()));
    // The area under the 3D curve: so short a training hits no point in the image.
    let row = &found["rows"][1];
    assert_eq!(row["key"], "auc_3d");
    let value = |model: &str| row["scores"][model]["estimate"].as_f64().unwrap();
    let difference = value("corrected") - value("given");
    assert!((row["difference"]["estimate"].as_f64().unwrap() - difference).abs() < 1e-12, "{row}");
    // Other data, another network.
    assert_ne!(value("corrected"), value("given"), "{row}");
    let page = sandbox.text("payoff/report.html");
    assert!(page.contains("<svg") && page.contains("leak_on") && page.contains("</html>"));
    for name in ["config.toml", "run.toml", "models/given.toml", "models/camera.toml"] {
        assert!(sandbox.path("payoff").join(name).is_file(), "{name}");
    }
    // Scenes are the same, events are not.
    let data = |model: &str, file: &str| {
        bytes(&sandbox.path(&format!("payoff/seed-1/{model}/data/{file}")))
    };
    assert!(data("given", "0000.meta") == data("corrected", "0000.meta"));
    assert!(data("given", "0000.evc") != data("corrected", "0000.evc"));

    // Again, with what is there, and on the recordings as a directory.
    let error = sandbox.fails(&payoff(TINY, &usual));
    assert!(error.contains("--resume"), "{error}");
    let network = sandbox.path("payoff/seed-2/corrected/network/best.bpk");
    let written = std::fs::metadata(&network).unwrap().modified().unwrap();
    let given = sandbox.path("payoff/seed-1/given/network/best.bpk");
    let first = bytes(&given);
    std::fs::remove_file(&given).unwrap();
    let again = ["--data", "payoff/held-out", "--stride-ms", "20", "--seeds", "2", "--resume"];
    sandbox.ok(&payoff(TINY, &again));
    let on_directory = sandbox.json("payoff/payoff.json");
    assert_eq!(on_directory["rows"][1]["difference"], row["difference"]);
    assert_eq!(on_directory["rows"][1]["difference_by_seed"], row["difference_by_seed"]);
    assert_eq!(std::fs::metadata(&network).unwrap().modified().unwrap(), written);
    assert!(bytes(&given) == first, "a training that is finished once more is the same");
    let other = ["--camera", "camera.toml", "--resume", "--set", "training.steps=24"];
    let error = sandbox.fails(&payoff(TINY, &other));
    assert!(error.contains("config.toml differs"), "{error}");
}

#[test]
fn bodies_are_compared_by_the_same_command() {
    let sandbox = Sandbox::new();
    gap_run(&sandbox);
    let bodies = ["--camera", "camera.toml", "--task", "body", "--set", "training.steps=4"];
    let said = sandbox.ok(&payoff(BODY_TINY, &bodies));
    assert!(said.contains("PCK@0.4") && said.contains("MPJPE px"), "{said}");
    let found = sandbox.json("payoff/payoff.json");
    assert_eq!((&found["task"], &found["recordings"]), (&"body".into(), &2.into()));
    assert_eq!(found["rows"][0]["key"], "auc");
}

#[test]
fn inputs_of_a_payoff_that_cannot_be_used_are_named() {
    let sandbox = Sandbox::new();
    gap_run(&sandbox);
    let refused = |args: &[&str], part: &str| {
        let said = sandbox.fails(args);
        assert!(said.contains(part), "{args:?}: {said}");
    };
    refused(&payoff(&[], &[]), "--camera");
    refused(&payoff(&[], &["--camera", "nowhere.toml"]), "nowhere.toml");
    refused(&payoff(&[], &["--data", "gap", "--upper-bound"]), "cannot be used with");
    refused(&payoff(&[], &["--data", "gap", "--task", "foot"]), "hand");
    let other = ["--data", "gap", "--task", "body", "--config", "quick"];
    refused(&payoff(&[], &other), "must be \"body\", and is \"hand\"");
    refused(&payoff(&[], &["--data", "nowhere"]), "nowhere: no directory");
    // A corrected model that is the model itself.
    std::fs::copy(sandbox.path("gap/model.toml"), sandbox.path("gap/corrected.toml")).unwrap();
    refused(&payoff(&[], &["--camera", "camera.toml"]), "nothing to compare");
    std::fs::remove_file(sandbox.path("gap/verdict.json")).unwrap();
    refused(&payoff(&[], &["--camera", "camera.toml"]), "evpose gap run");
    assert!(!sandbox.path("payoff").exists());
}
