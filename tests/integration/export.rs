//! Networks as files for other runtimes.

use evpose_infer::onnx::Message as _;
use evpose_infer::onnx::proto::ModelProto;

use crate::harness::{Sandbox, bytes, tiny};

#[test]
fn a_network_is_exported_before_and_after_training() {
    let sandbox = Sandbox::new();
    let weight = |name: &str| {
        let graph = ModelProto::decode(&*bytes(&sandbox.path(name))).unwrap().graph.unwrap();
        let weights = graph.initializer.into_iter();
        weights.into_iter().find(|tensor| tensor.name == "conv1.weight").unwrap()
    };
    let said =
        sandbox.ok(&["export", "quick", "--set", "network.width=0.0625", "--onnx", "a.onnx"]);
    assert!(said.contains("a.onnx: resnet18 of width 0.0625, input batchx2x"), "{said}");
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
    sandbox.ok(&tiny(&["train", "quick", "--data", "data", "--out", "run"]));
    sandbox.ok(&["export", "--checkpoint", "run", "--onnx", "trained/b.onnx"]);
    let (untrained, trained) = (weight("a.onnx"), weight("trained/b.onnx"));
    assert_eq!(untrained.dims, [3, 2, 3, 3]);
    assert_eq!(untrained.dims, trained.dims);
    assert_ne!(untrained.raw_data, trained.raw_data);
}

/// All that somebody needs to run the file who has nothing else.
#[test]
fn an_exported_network_says_how_it_is_run() {
    let sandbox = Sandbox::new();
    let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("checkpoints");
    for (name, outputs, order) in [
        ("hand", &["parameters"][..], ("parameters", "rotation_z_rad")),
        ("body", &["heatmaps", "centers", "regressions", "offsets"], ("joints", "ankle_r")),
    ] {
        let checkpoint = shipped.join(format!("{name}-quick.bpk"));
        let checkpoint = checkpoint.to_str().unwrap();
        sandbox.ok(&["export", "--checkpoint", checkpoint, "--onnx", "a.onnx"]);
        let model = ModelProto::decode(&*bytes(&sandbox.path("a.onnx"))).unwrap();
        let graph = model.graph.unwrap();
        assert_eq!(graph.input[0].name, "events");
        let names: Vec<&str> = graph.output.iter().map(|info| info.name.as_str()).collect();
        assert_eq!(names, outputs);
        let entry = |key: &str| {
            let found = model.metadata_props.iter().find(|entry| entry.key == key);
            found.unwrap_or_else(|| panic!("{name}: no {key}")).value.clone()
        };
        assert_eq!(entry("task"), name);
        assert!(entry(order.0).ends_with(order.1), "{}", entry(order.0));
        for key in ["representation", "view", "denoise", "normalisation", "decoding", "passes"] {
            assert!(!entry(key).is_empty(), "{name}: {key}");
        }
        assert!(entry("config").contains(&format!("task = \"{name}\"")));
        // As checked in for releases.
        let sums = String::from_utf8(bytes(&shipped.join("SHA256SUMS"))).unwrap();
        let line = sums.lines().find(|line| line.ends_with(&format!("{name}-quick.bpk"))).unwrap();
        assert!(line.starts_with(&entry("checkpoint_sha256")), "{line}");
    }
}

#[test]
fn every_backbone_is_exported() {
    let sandbox = Sandbox::new();
    for name in [
        "resnet18",
        "resnet34",
        "mobilenet_v2",
        "vgg11_bn",
        "vgg13_bn",
        "vgg16_bn",
        "vgg19_bn",
        "shufflenet_v2",
        "mnasnet",
        "inception_v3",
    ] {
        let backbone = format!("network.backbone={name}");
        // Inception v3 needs 75 pixels a side.
        let changes = [&backbone, "network.width=0.0625", "simulation.image_scale=0.42"];
        let mut args = vec!["export", "eventhands", "--onnx", "a.onnx"];
        args.extend(changes.iter().flat_map(|change| ["--set", change]));
        let said = sandbox.ok(&args);
        assert!(said.contains(name) && said.contains("input batchx2x76x101"), "{said}");
        let graph = ModelProto::decode(&*bytes(&sandbox.path("a.onnx"))).unwrap().graph.unwrap();
        // An export that stops half way has fewer.
        assert!(graph.node.len() >= 30, "{name}: {} operators", graph.node.len());
    }
}

#[test]
fn there_is_nothing_to_export_without_a_network() {
    let sandbox = Sandbox::new();
    let message = sandbox.fails(&["export", "--onnx", "a.onnx"]);
    assert!(message.contains("<CONFIG>"), "{message}");
    let message = sandbox.fails(&["export", "quick", "--checkpoint", "run", "--onnx", "a.onnx"]);
    assert!(message.contains("cannot be used with"), "{message}");
    assert!(!sandbox.path("a.onnx").exists());
}
