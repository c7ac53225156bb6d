//! Runs that are killed, and runs that diverge.

use std::time::{Duration, Instant};

use crate::harness::{Sandbox, bytes, tiny, tiny_body};

/// Lines of `metrics.jsonl`, 0 while there is none.
fn lines(sandbox: &Sandbox, run: &str) -> usize {
    let path = sandbox.path(run).join("metrics.jsonl");
    std::fs::read_to_string(path).map_or(0, |text| text.lines().count())
}

#[test]
fn a_killed_run_resumes_to_the_bit() {
    let sandbox = Sandbox::with_hands();
    let train = |out: &'static str| tiny(&["train", "quick", "--data", "data", "--out", out]);
    let threads = ["--threads", "2"];
    sandbox.ok(&[&train("whole")[..], &threads].concat());

    // Killed three times at moments nobody chose: after checkpoints, or in the middle of a step.
    let arguments = [&train("killed")[..], &["--resume"], &threads].concat();
    for kill in 0..3 {
        let before = lines(&sandbox, "killed");
        let progressed = || lines(&sandbox, "killed") > before;
        sandbox.kill(&arguments, progressed, Duration::from_millis(7 * kill));
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
    let sandbox = Sandbox::with_hands();
    let mut arguments = tiny(&["train", "quick", "--data", "data", "--out", "run"]);
    arguments.extend(["--set", "training.learning_rate=1e30"]);
    let message = sandbox.fails(&arguments);
    assert!(message.contains("the loss became"), "{message}");
    assert!(!sandbox.path("run/last.bpk").exists());
}

/// The weights after the only step are infinite, and the loss of that step is not.
#[test]
fn a_validation_loss_that_is_no_number_is_an_error_that_says_the_step() {
    let sandbox = Sandbox::new();
    let arguments = tiny_body(&["train", "pretrain", "--out", "run", "--plain"]);
    let one_step =
        ["training.learning_rate=1e30", "training.steps=1", "training.steps_per_validation=1"];
    let one_step = one_step.iter().flat_map(|change| ["--set", change]);
    let message = sandbox.fails(&arguments.into_iter().chain(one_step).collect::<Vec<_>>());
    assert!(message.contains("the validation loss became NaN at step 1;"), "{message}");
    assert!(!sandbox.path("run/best.bpk").exists());
}

#[test]
fn damaged_checkpoints_are_passed_over_and_named() {
    let sandbox = Sandbox::with_hands();
    let train = tiny(&["train", "quick", "--data", "data", "--out", "run", "--plain"]);
    sandbox.ok(&train);
    let path = |name: &str| sandbox.path("run").join(name);
    let results = ["best.bpk", "last.bpk", "metrics.jsonl", "checkpoint/optimizer-4.bpk"];
    let whole = results.map(|name| bytes(&path(name)));
    let resume = [&train[..], &["--resume"]].concat();
    let damage = |part: &str, how: &dyn Fn(&mut Vec<u8>)| {
        let name = format!("checkpoint/{part}.bpk");
        let mut damaged = bytes(&path(&name));
        how(&mut damaged);
        std::fs::write(path(&name), damaged).unwrap();
    };
    let flip = |bytes: &mut Vec<u8>| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 4;
    };
    let cut = |bytes: &mut Vec<u8>| bytes.truncate(bytes.len() / 3);
    let empty = |bytes: &mut Vec<u8>| bytes.clear();
    for (part, how) in [
        ("model-4", &flip as &dyn Fn(&mut Vec<u8>)),
        ("optimizer-4", &flip),
        ("schedule-4", &flip),
        ("model-4", &cut),
        ("optimizer-4", &cut),
        ("schedule-4", &empty),
    ] {
        damage(part, how);
        let (code, said) = sandbox.ends(&resume);
        assert_eq!(code, Some(0), "{part}: {said}");
        assert!(said.contains(&format!("{part}.bpk: damaged")), "{part}: {said}");
        assert!(said.contains("from the checkpoint before, of validation 3"), "{said}");
        for (name, whole) in results.iter().zip(&whole) {
            assert!(bytes(&path(name)) == *whole, "{part}: {name} differs");
        }
    }
    // Of a best network that is damaged, the best of the others takes the place.
    let history = evpose_train::read_history(&path("metrics.jsonl")).unwrap();
    let losses = evpose_train::validation_losses(&history);
    let (best, _) = losses.iter().min_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    damage(&format!("model-{best}"), &flip);
    let (code, said) = sandbox.ends(&resume);
    assert!(code == Some(0) && said.contains(&format!("model-{best}.bpk: damaged")), "{said}");
    // Without an undamaged one, nothing is trained.
    damage("optimizer-3", &flip);
    damage("model-4", &cut);
    let message = sandbox.fails(&resume);
    assert!(message.contains("model-4.bpk: damaged") && !message.contains("panicked"), "{message}");
}

#[test]
fn two_trainings_do_not_share_a_directory() {
    let sandbox = Sandbox::with_hands();
    let train = tiny(&["train", "quick", "--data", "data", "--out", "run", "--plain"]);
    let long = ["--set", "training.steps=100000", "--set", "training.steps_per_validation=50000"];
    let mut first = sandbox.start(&[&train[..], &long].concat());
    let deadline = Instant::now() + Duration::from_secs(120);
    let lock = sandbox.path("run/run.lock");
    while !std::fs::read(&lock).is_ok_and(|id| !id.is_empty()) {
        assert!(Instant::now() < deadline && first.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(1));
    }
    let in_use = format!("run: process {} trains there", first.id());
    for more in [&[][..], &["--resume"]] {
        let message = sandbox.fails(&[&train[..], more].concat());
        assert!(message.contains(&in_use), "{message}");
    }
    first.kill().unwrap();
    first.wait().unwrap();
    // The id of the dead process is still there.
    assert!(!bytes(&lock).is_empty());
    sandbox.ok(&train);
}

#[test]
fn a_run_directory_is_not_overwritten() {
    let sandbox = Sandbox::with_hands();
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
    let sandbox = Sandbox::with_hands();
    let train = |out: &'static str| tiny(&["train", "quick", "--data", "data", "--out", out]);
    let two = ["--set", "training.devices=2", "--set", "training.strategy=main-device"];
    sandbox.ok(&[&train("whole")[..], &two].concat());
    // Each device reports its half of every batch: twelve steps, and a validation after each third.
    assert_eq!(lines(&sandbox, "whole"), 12 * 2 + 4 * 2);

    let arguments = [&train("killed")[..], &two, &["--resume"]].concat();
    let second = sandbox.path("killed/checkpoint/schedule-2.bpk");
    sandbox.kill(&arguments, || second.exists(), Duration::ZERO);
    assert!(!sandbox.path("killed/last.bpk").exists(), "the kill came too late to test anything");
    sandbox.ok(&arguments);
    for file in ["last.bpk", "checkpoint/model-4.bpk", "checkpoint/optimizer-4.bpk"] {
        let (whole, killed) = (sandbox.path("whole").join(file), sandbox.path("killed").join(file));
        assert!(bytes(&whole) == bytes(&killed), "{file} differs after resuming");
    }
}

#[test]
fn devices_that_cannot_work_together_are_refused_before_anything_is_written() {
    let sandbox = Sandbox::with_hands();
    let train = tiny(&["train", "quick", "--data", "data", "--out", "run"]);
    for (change, why) in [
        ("training.devices=2", "main-device"),
        ("training.devices=3", "divide training.batch_size"),
        ("training.devices=0", "from 1 to 64"),
    ] {
        let message = sandbox.fails(&[&train[..], &["--set", change]].concat());
        assert!(message.contains(why), "{message}");
    }
    assert!(!sandbox.path("run").exists());
}
