//! Quantised networks.

use evpose_io::poses::read_poses;

use crate::harness::{Sandbox, bytes, tiny};

#[test]
fn a_network_is_quantized_evaluated_and_used() {
    let sandbox = Sandbox::with_hands();
    sandbox.ok(&tiny(&["train", "quick", "--data", "data", "--out", "run", "--plain"]));
    let infer = |precision: &str, out: &str| {
        let mut args = vec!["infer", "--checkpoint", "run", "--events", "data/0000.evc"];
        args.extend(["--unfiltered", "--precision", precision, "--out", out]);
        args.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let refused = infer("int8", "poses.csv");
    let refused: Vec<&str> = refused.iter().map(String::as_str).collect();
    let message = sandbox.fails(&refused);
    assert!(message.contains("int8.json") && message.contains("evpose quantize"), "{message}");

    let quantize = ["quantize", "--checkpoint", "run", "--data", "data", "--windows", "32"];
    let evaluate = ["--evaluate", "data", "--json", "quantized.json"];
    let said = sandbox.ok(&[quantize.as_slice(), &evaluate].concat());
    let report = sandbox.json("quantized.json");
    let command = report["command"].as_str().unwrap();
    assert!(command.starts_with("evpose quantize --checkpoint run"), "{command}");
    let error = |line: usize| {
        report["precisions"][line]["held_out"]["translation_mm"]["estimate"].as_f64().unwrap()
    };
    for (line, name) in ["f32", "bf16", "int8"].into_iter().enumerate() {
        assert_eq!(report["precisions"][line]["precision"], name);
        assert!(said.lines().any(|line| line.starts_with(name)), "{said}");
        assert!(report["precisions"][line]["latency_ms"].as_f64().unwrap() > 0.0);
        // A network that has hardly been trained says much the same of everything.
        assert!((error(line) / error(0) - 1.0).abs() < 0.05, "{said}");
    }

    let poses = |precision: &str| -> Vec<f64> {
        let out = format!("{precision}.csv");
        let args = infer(precision, &out);
        sandbox.ok(&args.iter().map(String::as_str).collect::<Vec<_>>());
        let poses = read_poses(&sandbox.path(&out)).unwrap().poses;
        poses.iter().flat_map(|pose| pose.params.unwrap().to_f64()).collect()
    };
    let [whole, half, byte] = ["f32", "bf16", "int8"].map(poses);
    assert_eq!(whole.len(), byte.len());
    assert!(whole != half && whole != byte && half != byte);

    // Ranges of other weights are not used.
    sandbox.ok(&tiny(&[
        "train", "quick", "--data", "data", "--out", "other", "--plain", "--set", "seed=9",
    ]));
    std::fs::copy(sandbox.path("run/int8.json"), sandbox.path("other/int8.json")).unwrap();
    let eval = ["eval", "--checkpoint", "other", "--data", "data", "--precision", "int8"];
    let message = sandbox.fails(&eval);
    assert!(message.contains("other weights"), "{message}");
}

#[test]
fn a_network_of_two_passes_is_exported_quantized_and_used() {
    let sandbox = Sandbox::new();
    let two_pass = ["--set", "two_pass={ size = { width = 24, height = 18 } }"];
    sandbox.ok(&[&tiny(&["simulate", "quick", "--out", "data"])[..], &two_pass].concat());
    let train = tiny(&["train", "quick", "--data", "data", "--out", "run", "--plain"]);
    sandbox.ok(&[&train[..], &two_pass].concat());
    let said = sandbox.ok(&["export", "--checkpoint", "run", "--onnx", "hand.onnx"]);
    assert!(said.contains("input batchx2x18x24"), "{said}");
    let quantize = ["quantize", "--checkpoint", "run", "--data", "data", "--windows", "8"];
    let said = sandbox.ok(&[&quantize[..], &["--evaluate", "data", "--stride-ms", "50"]].concat());
    assert!(said.lines().any(|line| line.starts_with("int8")), "{said}");
    let infer = ["infer", "--checkpoint", "run/best.bpk", "--events", "data/0000.evc"];
    sandbox.ok(&[&infer[..], &["--precision", "int8", "--out", "poses.csv"]].concat());
    assert!(bytes(&sandbox.path("poses.csv")).len() > 1_000);
}
