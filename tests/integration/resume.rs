//! Runs that are killed, and runs that diverge.

use std::time::{Duration, Instant};

use crate::harness::{Sandbox, bytes, tiny};

/// Lines of `metrics.jsonl`, 0 while there is none.
fn lines(sandbox: &Sandbox, run: &str) -> usize {
    let path = sandbox.path(run).join("metrics.jsonl");
    std::fs::read_to_string(path).map_or(0, |text| text.lines().count())
}

#[test]
fn a_killed_run_resumes_to_the_bit() {
    let sandbox = Sandbox::new();
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
    let train = |out: &'static str| tiny(&["train", "quick", "--data", "data", "--out", out]);
    let threads = ["--threads", "2"];
    sandbox.ok(&[&train("whole")[..], &threads].concat());

    // Killed three times at moments nobody chose: after checkpoints, or in the middle of a step.
    let arguments = [&train("killed")[..], &["--resume"], &threads].concat();
    for kill in 0..3 {
        let before = lines(&sandbox, "killed");
        let mut child = sandbox.start(&arguments);
        let deadline = Instant::now() + Duration::from_secs(120);
        while lines(&sandbox, "killed") <= before && child.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "no progress in run {kill}");
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(7 * kill));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert!(!sandbox.path("killed/last.bpk").exists(), "the kills came too late to test anything");
    sandbox.ok(&arguments);

    for file in [
        "metrics.jsonl",
        "last.bpk",
        "best.bpk",
        "checkpoint/model-4.bpk",
        "checkpoint/optimizer-4.bpk",
    ] {
        let (whole, killed) = (sandbox.path("whole").join(file), sandbox.path("killed").join(file));
        assert!(bytes(&whole) == bytes(&killed), "{file} differs after resuming");
    }
}

#[test]
fn a_loss_that_is_no_number_stops_the_run_and_keeps_the_checkpoint() {
    let sandbox = Sandbox::new();
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
    let mut arguments = tiny(&["train", "quick", "--data", "data", "--out", "run"]);
    arguments.extend(["--set", "training.learning_rate=1e30"]);
    let message = sandbox.fails(&arguments);
    assert!(message.contains("the loss became"), "{message}");
    assert!(!sandbox.path("run/last.bpk").exists());
}

#[test]
fn a_run_directory_is_not_overwritten() {
    let sandbox = Sandbox::new();
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
    let arguments = tiny(&["train", "quick", "--data", "data", "--out", "run"]);
    sandbox.ok(&arguments);
    let message = sandbox.fails(&arguments);
    // The remedy is in the message, not only the fault.
    assert!(
        message.contains("add --resume to continue") && !message.contains("cannot"),
        "{message}"
    );
    let mut other = [&arguments[..], &["--resume"]].concat();
    other.extend(["--set", "training.learning_rate=0.5"]);
    let message = sandbox.fails(&other);
    let named = "training.learning_rate is 0.001 there, not 0.5";
    assert!(message.contains("run/config.toml") && message.contains(named), "{message}");
}

#[test]
fn two_devices_train_on_the_same_windows_and_resume_to_the_bit() {
    let sandbox = Sandbox::new();
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
    let train = |out: &'static str| tiny(&["train", "quick", "--data", "data", "--out", out]);
    let two = ["--set", "training.devices=2", "--set", "training.strategy=main-device"];
    sandbox.ok(&[&train("whole")[..], &two].concat());
    // Each device reports its half of every batch: twelve steps, and a validation after each third.
    assert_eq!(lines(&sandbox, "whole"), 12 * 2 + 4 * 2);

    let arguments = [&train("killed")[..], &two, &["--resume"]].concat();
    let mut child = sandbox.start(&arguments);
    let deadline = Instant::now() + Duration::from_secs(120);
    while !sandbox.path("killed/checkpoint/schedule-2.bpk").exists() {
        assert!(Instant::now() < deadline && child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!sandbox.path("killed/last.bpk").exists(), "the kill came too late to test anything");
    sandbox.ok(&arguments);
    for file in ["last.bpk", "checkpoint/model-4.bpk", "checkpoint/optimizer-4.bpk"] {
        let (whole, killed) = (sandbox.path("whole").join(file), sandbox.path("killed").join(file));
        assert!(bytes(&whole) == bytes(&killed), "{file} differs after resuming");
    }
}

#[test]
fn devices_that_cannot_work_together_are_refused_before_anything_is_written() {
    let sandbox = Sandbox::new();
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
    let train = tiny(&["train", "quick", "--data", "data", "--out", "run"]);
    for (change, why) in [
        ("training.devices=2", "main-device"),
        ("training.devices=3", "divide training.batch_size"),
        ("training.devices=0", "at least 1"),
    ] {
        let message = sandbox.fails(&[&train[..], &["--set", change]].concat());
        assert!(message.contains(why), "{message}");
    }
    assert!(!sandbox.path("run").exists());
}
