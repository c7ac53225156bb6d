//! The accuracy of the networks that ship, on parts of the sets whose results `evpose bench accuracy` stored: the
//! same recordings, so that a figure falls only if the network, or what is between events and poses, does.

use std::fs;
use std::path::{Path, PathBuf};

use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{Device, Distribution, Tensor};
use evpose_task::body::BodyCheckpoint;
use evpose_task::hand::HandCheckpoint;
use serde_json::Value;
use sha2::{Digest as _, Sha256};

use crate::harness::{Sandbox, bytes};

/// Points of PCK and AUC that a figure may differ by: 2 of 100.
const TOLERANCE: f64 = 0.02;

/// A figure of a task: its name, and its place in the scores of a recording.
type Figure = (&'static str, &'static str);

const OF_BODIES: &[Figure] = &[("PCK@0.4", "/pck/1/estimate"), ("AUC", "/auc/estimate")];
const OF_HANDS: &[Figure] = &[("AUC 2D", "/auc_2d/estimate"), ("AUC 3D", "/auc_3d/estimate")];

fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The stored accuracy on a set.
struct Stored(Value);

impl Stored {
    fn of(set: &str) -> Self {
        let text = bytes(&root(&format!("benches/accuracy/{set}.json")));
        Self(serde_json::from_slice(&text).unwrap())
    }

    fn network(&self, name: &str) -> &Value {
        let networks = self.0["networks"].as_array().unwrap();
        networks.iter().find(|network| network["name"] == name).unwrap()
    }

    /// The words of the evaluation, with the place of the set.
    fn evaluation(&self, name: &str, set: &Path) -> Vec<String> {
        let command = self.network(name)["evaluation"].as_str().unwrap();
        let set = set.to_str().unwrap();
        let words = command.split(' ').skip(1);
        words.map(|word| if word == "SET" { set } else { word }.to_owned()).collect()
    }
}

/// The scores of each recording by its name without an ending.
fn by_recording(result: &Value) -> Vec<(String, &Value)> {
    let recordings = result["recordings"].as_array().unwrap();
    let name = |scores: &Value| {
        let name = scores["file"].as_str().or(scores["name"].as_str()).unwrap();
        name.split('.').next().unwrap().to_owned()
    };
    recordings.iter().map(|scores| (name(scores), scores)).collect()
}

/// Figures of a network, the means over recordings, that are further from the stored ones than [`TOLERANCE`].
fn differences(
    sandbox: &Sandbox,
    stored: &Stored,
    name: &str,
    file: &Path,
    set: &Path,
) -> Vec<String> {
    let mut words = stored.evaluation(name, set);
    words.extend(
        ["--checkpoint", file.to_str().unwrap(), "--json", "result.json"].map(str::to_owned),
    );
    sandbox.ok(&words.iter().map(String::as_str).collect::<Vec<_>>());
    let result = sandbox.json("result.json");
    let (now, network) = (by_recording(&result), stored.network(name));
    let before = by_recording(&network["result"]);
    let figures = if network["task"] == "body" { OF_BODIES } else { OF_HANDS };
    let mean = |of: &dyn Fn(&str) -> Option<f64>| {
        // A recording in which nothing is measured, such as one with nobody, has no figure.
        let values: Vec<f64> = now.iter().filter_map(|(recording, _)| of(recording)).collect();
        assert!(!values.is_empty(), "{name}: nothing was measured");
        values.iter().sum::<f64>() / values.len() as f64
    };
    let mut wrong = Vec::new();
    for (figure, pointer) in figures {
        let value = |all: &[(String, &Value)], recording: &str| {
            let found = all.iter().find(|(name, _)| name == recording);
            let (_, scores) = found.unwrap_or_else(|| panic!("{recording} is not stored"));
            scores.pointer(pointer).and_then(Value::as_f64)
        };
        let [now, before] = [
            mean(&|recording| value(&now, recording)),
            mean(&|recording| value(&before, recording)),
        ];
        if (now - before).abs() > TOLERANCE {
            wrong.push(format!("{name}: {figure} is {now:.3}, stored is {before:.3}"));
        }
    }
    wrong
}

/// The figures of networks are those that are stored.
fn hold(sandbox: &Sandbox, stored: &Stored, names: &[&str], set: &Path) {
    let wrong = names.iter().flat_map(|name| {
        let file = root(&format!("checkpoints/{name}.bpk"));
        let digest = format!("{:x}", Sha256::digest(bytes(&file)));
        let is_stored = stored.network(name)["sha256"] == digest;
        let of_another =
            format!("{name} is not the network whose accuracy is stored: `evpose bench accuracy`");
        let differences = differences(sandbox, stored, name, &file, set);
        differences.into_iter().chain((!is_stored).then_some(of_another))
    });
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A few recordings of the home set of a task, simulated: those of one shard, byte by byte those whose
/// figures are stored.
fn home(sandbox: &Sandbox, stored: &Stored, task: &str, shard: &str) -> PathBuf {
    let simulated = stored.0["simulated"].as_array().unwrap();
    let simulated = simulated.iter().find(|simulated| simulated["task"] == task).unwrap();
    let command = simulated["simulation"].as_str().unwrap();
    // The command that is stored with the figures makes the recordings that they are of.
    let words = command.split(' ').skip(1).chain(["--out", "home", "--shard", shard]);
    sandbox.ok(&words.collect::<Vec<_>>());
    let directory = sandbox.path("home");
    let manifest = simulated["manifest"].as_array().unwrap();
    for line in manifest.iter().map(|line| line.as_str().unwrap()) {
        let (stored, name) = line.split_once("  ").unwrap();
        // Only files of this shard were made.
        let Ok(content) = fs::read(directory.join(name)) else { continue };
        let digest = format!("{:x}", Sha256::digest(content));
        assert_eq!(digest, stored, "{name} is not the recording whose accuracy is stored");
    }
    directory
}

/// Some recordings of the development set, by their names.
fn development(sandbox: &Sandbox, kind: &str, recordings: &[&str]) -> PathBuf {
    let to = sandbox.path("development").join(kind);
    fs::create_dir_all(&to).unwrap();
    for entry in fs::read_dir(root("datasets/development").join(kind)).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if recordings.iter().any(|recording| name.starts_with(&format!("{recording}."))) {
            fs::copy(&path, to.join(name)).unwrap();
        }
    }
    sandbox.path("development")
}

#[test]
fn people_are_found_at_home_as_stored() {
    let (sandbox, stored) = (Sandbox::new(), Stored::of("home"));
    let home = home(&sandbox, &stored, "body", "1/20");
    hold(&sandbox, &stored, &["body", "body-quick"], &home);
}

#[test]
fn hands_are_found_at_home_as_stored() {
    let (sandbox, stored) = (Sandbox::new(), Stored::of("home"));
    let home = home(&sandbox, &stored, "hand", "1/20");
    hold(&sandbox, &stored, &["hand", "hand-quick"], &home);
}

#[test]
fn people_of_the_development_set_are_found_as_stored() {
    let (sandbox, stored) = (Sandbox::new(), Stored::of("development"));
    let set = development(&sandbox, "bodies", &["00", "08"]);
    hold(&sandbox, &stored, &["body", "body-quick"], &set);
}

#[test]
fn hands_of_the_development_set_are_found_as_stored() {
    let (sandbox, stored) = (Sandbox::new(), Stored::of("development"));
    let set = development(&sandbox, "hands", &["00"]);
    hold(&sandbox, &stored, &["hand", "hand-quick"], &set);
}

#[test]
#[ignore = "needs the EROS images of DHP19, which may not be passed on: EVPOSE_REAL=DIR"]
fn people_before_a_real_camera_are_found_as_stored() {
    let set = std::env::var_os("EVPOSE_REAL")
        .expect("$EVPOSE_REAL: a folder of clips, each with poses.json and images");
    hold(&Sandbox::new(), &Stored::of("real"), &["body", "body-quick"], Path::new(&set));
}

/// Multiplies every weight by a number about 1.
struct Noise {
    spread: f64,
}

impl ModuleMapper for Noise {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        param.map(|weights| {
            let noise = weights.random_like(Distribution::Normal(1.0, self.spread));
            weights * noise
        })
    }
}

/// A control of the tests above: with noise on the weights, figures are out of tolerance.
#[test]
fn noise_on_the_weights_is_seen() {
    // So much noise that few recordings are enough to show it.
    let device = Device::flex();
    device.seed(5);
    let noise = &mut Noise { spread: 0.3 };
    let (sandbox, stored) = (Sandbox::new(), Stored::of("development"));

    let mut body = BodyCheckpoint::load(&root("checkpoints/body.bpk"), &device).unwrap();
    body.network = body.network.map(noise);
    body.save(&sandbox.path("body.bpk")).unwrap();
    let set = development(&sandbox, "bodies", &["00"]);
    let wrong = differences(&sandbox, &stored, "body", &sandbox.path("body.bpk"), &set);
    assert!(!wrong.is_empty(), "the body's accuracy did not fall");

    let mut hand = HandCheckpoint::load(&root("checkpoints/hand-quick.bpk"), &device).unwrap();
    hand.network = hand.network.map(noise);
    hand.save(&sandbox.path("hand.bpk")).unwrap();
    let set = development(&sandbox, "hands", &["00"]);
    let wrong = differences(&sandbox, &stored, "hand-quick", &sandbox.path("hand.bpk"), &set);
    assert!(!wrong.is_empty(), "the hand's accuracy did not fall");
}
