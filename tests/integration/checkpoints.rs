//! The networks that ship, before people and hands that are simulated for the test.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::harness::{Sandbox, bytes, stderr};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("checkpoints").join(name)
}

fn path(name: &str) -> String {
    shipped(name).to_str().expect("a path of text").to_owned()
}

fn json(sandbox: &Sandbox, name: &str) -> serde_json::Value {
    serde_json::from_slice(&bytes(&sandbox.path(name))).expect("JSON")
}

#[test]
fn what_ships_is_what_its_sums_say() {
    let sums = String::from_utf8(bytes(&shipped("SHA256SUMS"))).expect("text");
    assert_eq!(sums.lines().count(), 4);
    for line in sums.lines() {
        let (sum, name) = line.split_once("  ").expect("as sha256sum writes them");
        let digest = Sha256::digest(bytes(&shipped(name)));
        let hex: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex, sum, "{name}");
    }
}

/// People that are simulated for the test are found.
fn finds_people(name: &str) {
    let sandbox = Sandbox::new();
    let network = path(name);
    let simulate = ["simulate", "finetune", "--held-out", "--out", "held", "--seed", "77"];
    sandbox.ok(&[&simulate[..], &["--sequences", "3", "--seconds", "1.2"]].concat());
    sandbox.ok(&["eval", "--checkpoint", &network, "--data", "held", "--json", "metrics.json"]);
    let evaluated = json(&sandbox, "metrics.json");
    let pck_40 =
        |method: &str| evaluated[method]["raw"]["pck"][1]["estimate"].as_f64().expect(method);
    let (found, mean) = (pck_40("network"), pck_40("mean_pose"));
    assert!(found > mean + 0.25, "PCK@0.4 {found}, of the mean pose {mean}");

    let poses =
        ["infer", "--checkpoint", &network, "--events", "held/0001.raw", "--out", "poses.csv"];
    sandbox.ok(&poses);
    let drawn =
        ["view", "held/0001.raw", "--of", "eros", "--joints", "poses.csv", "--out", "seen.png"];
    sandbox.ok(&drawn);
    assert!(bytes(&sandbox.path("seen.png")).len() > 10_000);
}

#[test]
fn the_quick_body_finds_people_it_has_not_seen() {
    finds_people("body-quick.bpk");
}

#[test]
fn the_body_finds_people_it_has_not_seen() {
    finds_people("body.bpk");
}

/// Recordings that no simulation of this project made: better than the mean pose, by much.
#[test]
fn the_body_finds_people_of_others() {
    let sandbox = Sandbox::new();
    let foreign = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/development/bodies");
    let foreign = foreign.to_str().expect("a path of text");
    let network = path("body.bpk");
    let eval = ["eval", "--checkpoint", &network, "--data", foreign, "--stride-ms", "100"];
    sandbox.ok(&[&eval[..], &["--json", "metrics.json"]].concat());
    let evaluated = json(&sandbox, "metrics.json");
    let pck_40 =
        |method: &str| evaluated[method]["raw"]["pck"][1]["estimate"].as_f64().expect(method);
    let (found, mean) = (pck_40("network"), pck_40("mean_pose"));
    assert!(found > mean + 0.15, "PCK@0.4 {found}, of the mean pose {mean}");
}

/// Hands that are simulated for the test at `scale` of 240x180 pixels are found.
fn finds_hands(name: &str, scale: &str) {
    let sandbox = Sandbox::new();
    let network = path(name);
    let simulate = ["simulate", "quick", "--held-out", "--out", "held", "--seed", "77"];
    let size = format!("simulation.image_scale={scale}");
    let options = ["--sequences", "3", "--seconds", "1", "--set", &size];
    sandbox.ok(&[&simulate[..], &options].concat());
    let eval = ["eval", "--checkpoint", &network, "--data", "held", "--stride-ms", "10"];
    sandbox.ok(&[&eval[..], &["--json", "metrics.json"]].concat());
    let evaluated = json(&sandbox, "metrics.json");
    let translation_mm = |method: &str| {
        evaluated["held_out"][method]["translation_mm"]["estimate"].as_f64().expect(method)
    };
    let (found, mean) = (translation_mm("trained"), translation_mm("mean_pose"));
    assert!(found < 0.6 * mean, "{found} mm, of the mean pose {mean} mm");
}

#[test]
fn the_quick_hand_finds_hands_it_has_not_seen() {
    finds_hands("hand-quick.bpk", "0.25");
}

#[test]
fn the_hand_finds_hands_it_has_not_seen() {
    finds_hands("hand.bpk", "0.4");
}

/// The program alone, as `cargo install` leaves it: away from the checkout.
#[test]
fn an_installed_program_has_its_networks() {
    let sandbox = Sandbox::new();
    let program = sandbox.path(&format!("evpose{}", std::env::consts::EXE_SUFFIX));
    std::fs::copy(env!("CARGO_BIN_EXE_evpose"), &program).expect("a copy of the program");
    let run = |args: &[&str]| {
        let mut command = std::process::Command::new(&program);
        command.current_dir(sandbox.path("")).env("EVPOSE_DATA", sandbox.path("data"));
        command.args(args).output().expect("the program starts")
    };
    for name in ["hand", "body", "hand-quick", "body-quick"] {
        let output = run(&["export", "--checkpoint", name, "--onnx", "network.onnx"]);
        assert!(output.status.success(), "{name}: {}", stderr(&output));
        let unpacked = format!("data/{}/checkpoints/{name}.bpk", env!("CARGO_PKG_VERSION"));
        assert!(bytes(&sandbox.path(&unpacked)) == bytes(&shipped(&format!("{name}.bpk"))));
    }
    let output = run(&["export", "--checkpoint", "foot", "--onnx", "network.onnx"]);
    assert!(!output.status.success());
}

#[test]
fn a_training_starts_from_a_shipped_network_by_its_name() {
    let sandbox = Sandbox::new();
    let changes = [
        "simulation.sequences=2",
        "simulation.seconds=0.6",
        "simulation.step_hz=250",
        "simulation.label_hz=50",
        "simulation.sensor_size={ width = 96, height = 72 }",
        "simulation.surroundings.source={ procedural = 3 }",
        "data.first_ms=100",
        "data.min_joints=4",
        "data.validation_share=0.5",
        "training.batch_size=2",
        "training.steps=1",
        "training.steps_per_validation=1",
        "training.validation_samples=2",
    ];
    let train = ["train", "finetune", "--plain", "--out", "run", "--start-from", "body-quick"];
    let set: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
    let said = sandbox.ok(&[&train[..], &set].concat());
    assert!(said.contains("checkpoint: run"), "{said}");
}

#[test]
#[ignore = "compiles the program once more: minutes"]
fn an_installed_program_finds_its_networks() {
    let sandbox = Sandbox::new();
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let mut install = std::process::Command::new(cargo);
    install.args(["install", "--locked", "--offline", "--path", env!("CARGO_MANIFEST_DIR")]);
    // In the profile of the tests, whose crates are compiled already.
    install.args(cfg!(debug_assertions).then_some("--debug"));
    let output = install.arg("--root").arg(sandbox.path("installed")).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    std::fs::create_dir(sandbox.path("elsewhere")).unwrap();
    for network in ["hand", "body"] {
        let output = std::process::Command::new(sandbox.path("installed/bin/evpose"))
            .args(["export", "--checkpoint", network, "--onnx", "network.onnx"])
            .current_dir(sandbox.path("elsewhere"))
            .env("EVPOSE_DATA", sandbox.path("data-directory"))
            .output()
            .unwrap();
        assert!(output.status.success(), "{network}: {}", stderr(&output));
    }
}
