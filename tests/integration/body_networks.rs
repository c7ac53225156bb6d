//! Networks of bodies before `export`, `quantize` and int8 inference.

use std::path::Path;

use evpose_infer::onnx::Message as _;
use evpose_infer::onnx::proto::ModelProto;
use sha2::{Digest as _, Sha256};

use crate::harness::{Sandbox, bytes, tiny_body};

#[test]
fn a_body_is_exported_quantized_evaluated_and_used() {
    let sandbox = Sandbox::new();
    let crop = ["--set", "decoding.second_pass={ side = 1.5, min_side = 0.3 }"];
    let train = tiny_body(&["train", "pretrain", "--out", "run", "--plain"]);
    sandbox.ok(&[&train[..], &crop, &["--set", "training.steps=2"]].concat());
    sandbox.ok(&tiny_body(&["simulate", "finetune", "--out", "data"]));

    let said = sandbox.ok(&["export", "--checkpoint", "run", "--onnx", "body.onnx"]);
    assert!(said.contains("move_enet of width 0.25, input batchx3x32x32"), "{said}");
    let graph = ModelProto::decode(&*bytes(&sandbox.path("body.onnx"))).unwrap().graph.unwrap();
    assert_eq!(graph.output.len(), 4);
    // Its own config is not needed: the file describes itself.
    std::fs::remove_file(sandbox.path("run/config.toml")).unwrap();
    sandbox.ok(&["export", "--checkpoint", "run", "--onnx", "again.onnx"]);
    assert!(bytes(&sandbox.path("body.onnx")) == bytes(&sandbox.path("again.onnx")));

    let infer = |precision: &str| {
        let events = ["--events", "data/0000.raw", "--precision", precision];
        let out = format!("{precision}.csv");
        let args = [&["infer", "--checkpoint", "run/best.bpk", "--out", &out], &events[..]];
        (sandbox.evpose(&args.concat()).output().unwrap(), sandbox.path(&out))
    };
    let (refused, _) = infer("int8");
    let message = crate::harness::stderr(&refused);
    assert!(message.contains("int8.json") && message.contains("evpose quantize"), "{message}");
    let quantize = ["quantize", "--checkpoint", "run", "--data", "data", "--windows", "6"];
    let evaluate = ["--evaluate", "data", "--stride-ms", "50", "--json", "quantized.json"];
    let said = sandbox.ok(&[&quantize[..], &evaluate].concat());
    let report = sandbox.json("quantized.json");
    for (row, name) in ["f32", "bf16", "int8"].into_iter().enumerate() {
        assert_eq!(report["precisions"][row]["precision"], name);
        assert!(said.lines().any(|line| line.starts_with(name)), "{said}");
    }
    // The ranges of a run are those of its best network, by whichever path.
    for precision in ["f32", "int8"] {
        let (output, poses) = infer(precision);
        assert!(output.status.success(), "{}", crate::harness::stderr(&output));
        assert!(bytes(&poses).len() > 1_000);
    }
    sandbox.ok(&["eval", "--checkpoint", "run", "--data", "data", "--precision", "int8"]);
}

/// A body is not offered to the reader of hands, whose message would be of another file.
#[test]
fn a_body_that_cannot_be_read_is_refused_as_a_body() {
    let sandbox = Sandbox::new();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("checkpoints/body-quick.bpk");
    let mut file = bytes(&shipped);
    let field = b"side_px";
    let at = file.windows(field.len()).position(|part| part == field).unwrap();
    // A field of a later version: as long, so that no length in the file changes.
    file[at..at + field.len()].copy_from_slice(b"side_py");
    sandbox.write("newer.bpk", &file);
    std::fs::create_dir(sandbox.path("run")).unwrap();
    sandbox.write("run/best.bpk", &file);
    // The bytes are said to be intact.
    let digest = Sha256::digest(&file);
    for (folder, name) in [("", "newer.bpk"), ("run/", "best.bpk")] {
        sandbox.write(&format!("{folder}SHA256SUMS"), format!("{digest:x}  {name}\n"));
    }
    std::fs::create_dir(sandbox.path("data")).unwrap();
    // A file and a directory: both find the task in the file.
    for checkpoint in ["newer.bpk", "run"] {
        let infer = ["infer", "--precision", "int8", "--events", "a.raw", "--out", "a.csv"];
        for command in
            [&["export", "--onnx", "body.onnx"][..], &["quantize", "--data", "data"], &infer]
        {
            let message = sandbox.fails(&[command, &["--checkpoint", checkpoint]].concat());
            assert!(message.contains("the body network"), "{message}");
            assert!(message.contains("side_py"), "{message}");
            assert!(!message.contains("evpose.model"), "{message}");
        }
    }
}

#[test]
fn a_network_that_there_is_not_is_refused_with_the_names_that_there_are() {
    let sandbox = Sandbox::new();
    for command in [&["export", "--onnx", "foot.onnx"][..], &["quantize", "--data", "data"]] {
        let message = sandbox.fails(&[command, &["--checkpoint", "foot"]].concat());
        assert!(message.contains("foot: no such file or run directory"), "{message}");
        assert!(message.contains("shipped network") && message.contains("body"), "{message}");
    }
}
