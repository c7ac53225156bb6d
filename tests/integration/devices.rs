//! Devices on the command line: every command honours `--device` or says that it cannot.

use crate::harness::Sandbox;

#[test]
fn devices_are_listed_and_those_left_out_name_their_feature() {
    let sandbox = Sandbox::new();
    let listed = sandbox.ok(&["info", "--devices"]);
    assert!(listed.starts_with("flex "), "{listed}");
    let kinds = ["ndarray", "wgpu", "cuda"];
    assert!(kinds.iter().all(|kind| listed.lines().any(|line| line.starts_with(kind))), "{listed}");
    let left_out = listed.contains("rebuild with `--features cuda`");
    assert_eq!(left_out, !cfg!(feature = "cuda"), "{listed}");
    let message = sandbox.fails(&["infer", "--device", "tpu"]);
    assert!(message.contains("info --devices"), "{message}");
}

#[test]
fn options_of_our_engine_are_refused_where_burn_is_timed() {
    let sandbox = Sandbox::new();
    for option in [["--precision", "bf16"], ["--level", "portable"], ["--threads", "1,2"]] {
        let timed = ["bench", "infer", "--config", "quick", "--burn"];
        let message = sandbox.fails(&[&timed[..], &option].concat());
        assert!(message.contains("for our engine"), "{option:?}: {message}");
    }
}
