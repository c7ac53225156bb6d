//! The networks that ship, as files. How accurate they are is tested in `accuracy.rs`.

use sha2::{Digest, Sha256};

use crate::harness::{BODY_TINY, Sandbox, bytes, shipped, stderr};

#[test]
fn what_ships_is_what_its_sums_say() {
    let sums = std::fs::read_to_string(shipped("SHA256SUMS")).expect("text");
    assert_eq!(sums.lines().count(), 4);
    for line in sums.lines() {
        let (sum, name) = line.split_once("  ").expect("as sha256sum writes them");
        let digest = Sha256::digest(bytes(shipped(name).as_ref()));
        assert_eq!(format!("{digest:x}"), sum, "{name}");
    }
}

/// Of a network that shipped before checkpoints had a digest, and of one that ends with it.
#[test]
fn no_flipped_bit_of_a_checkpoint_gives_poses() {
    let sandbox = Sandbox::new();
    sandbox.ok(&["average", "hand-quick", "hand-quick", "--out", "own.bpk"]);
    sandbox.write("a.txt", "240 180\n0.0 3 7 1\n0.3 9 8 0\n0.6 9 8 0\n");
    let infer = ["infer", "--checkpoint", "x.bpk", "--events", "a.txt", "--out", "poses.csv"];
    for path in [shipped("hand-quick.bpk").into(), sandbox.path("own.bpk")] {
        let whole = bytes(&path);
        let size = whole.len();
        let spread = (1..16).map(|k| k * size / 16 + k);
        // Magic number, version, sizes, names of tensors, tensors, and the digest with its tag.
        let flipped = (0..8)
            .chain([15, 200, 900, 2_000])
            .chain(spread)
            .chain([90, 72, 65, 30, 1].map(|k| size - k));
        for (count, byte) in flipped.enumerate() {
            let mut damaged = whole.clone();
            damaged[byte] ^= 1 << (count % 8);
            sandbox.write("x.bpk", damaged);
            let said = sandbox.fails(&infer);
            assert!(
                said.contains("x.bpk: damaged: ") && !said.contains("panicked"),
                "{byte}: {said}"
            );
            assert!(!sandbox.path("poses.csv").exists(), "{byte}");
        }
        sandbox.write("x.bpk", whole);
        sandbox.ok(&["info", "x.bpk"]);
    }
}

/// The program alone, as `cargo install` leaves it: away from the checkout.
#[test]
fn an_installed_program_has_its_networks() {
    let sandbox = Sandbox::new();
    let program = sandbox.path(&format!("evpose{}", std::env::consts::EXE_SUFFIX));
    std::fs::copy(env!("CARGO_BIN_EXE_evpose"), &program).expect("a copy of the program");
    let run = |args: &[&str]| {
        let mut command = std::process::Command::new(&program);
        // A data directory of its own: the user's networks are not touched.
        command.current_dir(sandbox.path("")).env("EVPOSE_DATA", sandbox.path("data"));
        command.args(args).output().expect("the program starts")
    };
    for name in ["hand", "body", "hand-quick", "body-quick"] {
        let output = run(&["export", "--checkpoint", name, "--onnx", "network.onnx"]);
        assert!(output.status.success(), "{name}: {}", stderr(&output));
        let unpacked = format!("data/{}/checkpoints/{name}.bpk", env!("CARGO_PKG_VERSION"));
        // Unpacked once, byte for byte.
        let shipped = shipped(&format!("{name}.bpk"));
        assert!(bytes(&sandbox.path(&unpacked)) == bytes(shipped.as_ref()));
        let info = String::from_utf8(run(&["info", name]).stdout).expect("text");
        let (_, card) = info.split_once(&format!("# `{name}`\n")).expect("a card");
        assert!(["**Terms**", "AUC", "**Limits**"].iter().all(|part| card.contains(part)));
        // Comments in a card are for its writers.
        assert!(!card.contains("<!--"), "{card}");
    }
    let output = run(&["export", "--checkpoint", "foot", "--onnx", "network.onnx"]);
    assert!(!output.status.success());
}

#[test]
fn the_mean_of_a_network_and_itself_is_that_network_and_other_shapes_have_none() {
    let sandbox = Sandbox::new();
    sandbox.ok(&["average", "body-quick", "body-quick", "--out", "mean.bpk"]);
    let onnx = |network: &str| {
        sandbox.ok(&["export", "--checkpoint", network, "--onnx", "network.onnx"]);
        bytes(&sandbox.path("network.onnx"))
    };
    let (mean, own) = (onnx("mean.bpk"), onnx("body-quick"));
    // Half of a denormal number is rounded.
    let differing = mean.iter().zip(&own).filter(|(mean, own)| mean != own).count();
    assert!(mean.len() == own.len() && 1000 * differing < own.len(), "{differing} bytes");
    assert_eq!(
        sandbox.ok(&["info", "mean.bpk"]).lines().nth(1),
        sandbox.ok(&["info", "body-quick"]).lines().nth(1)
    );
    sandbox.fails(&["average", "body", "hand", "--out", "no.bpk"]);
    assert!(!sandbox.path("no.bpk").exists());
}

#[test]
fn a_training_starts_from_a_shipped_network_by_its_name() {
    let sandbox = Sandbox::new();
    let train = ["train", "finetune", "--plain", "--out", "run", "--start-from", "body-quick"];
    let short = ["training.steps=1", "training.steps_per_validation=1"];
    // The network and its images are those that ship.
    let is_of_shipped =
        |change: &&&str| !["image.", "network."].iter().any(|of| change.starts_with(of));
    let changes = BODY_TINY.iter().filter(is_of_shipped).chain(&short);
    let set: Vec<&str> = changes.flat_map(|change| ["--set", change]).collect();
    let said = sandbox.ok(&[&train[..], &set].concat());
    assert!(said.contains("checkpoint: run"), "{said}");
}

#[test]
fn joints_of_images_are_also_evaluated_as_their_labels_put_them() {
    let sandbox = Sandbox::new();
    std::fs::create_dir_all(sandbox.path("clip/images")).expect("folders");
    image::GrayImage::new(64, 48).save(sandbox.path("clip/images/0.png")).expect("an image");
    // Joints at places that no two share.
    let places = (0..13).flat_map(|joint| [0.5, 0.05 + 0.07 * f64::from(joint), 2.0]);
    let keypoints: Vec<f64> = places.collect();
    let pose = serde_json::json!([{ "img_name": "0.png", "keypoints": keypoints,
        "center": [0.5, 0.5], "head_size": 0.1, "torso_size": 0.3 }]);
    sandbox.write("clip/poses.json", pose.to_string());
    let network = shipped("body-quick.bpk");
    let eval = ["eval", "--checkpoint", &network, "--data", "clip"];
    let said = sandbox.ok(&eval);
    assert!(said.contains("filtered") && !said.contains("as labels"), "{said}");
    let said = sandbox.ok(&[&eval[..], &["--joints", "dhp19", "--json", "eval.json"]].concat());
    assert!(said.contains("as labels"), "{said}");
    let json = sandbox.json("eval.json");
    assert!(json["placed"]["raw"]["pck"].is_array(), "{json}");
    // A convention that is not known is named with those that are.
    assert!(sandbox.fails(&[&eval[..], &["--joints", "mpii"]].concat()).contains("dhp19"));
}
