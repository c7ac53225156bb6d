//! Help, messages, and errors of bad input.

use crate::harness::{Sandbox, bytes, tiny};

#[test]
fn help_says_where_to_start() {
    let sandbox = Sandbox::new();
    insta::assert_snapshot!("help", sandbox.ok(&["--help"]));
}

#[test]
fn every_command_has_an_example() {
    let sandbox = Sandbox::new();
    for command in [
        "demo",
        "simulate",
        "events",
        "train",
        "eval",
        "infer",
        "export",
        "info",
        "represent",
        "view",
        "convert",
        "sensor",
        "prepare",
        "check-labels",
    ] {
        let help = sandbox.ok(&[command, "--help"]);
        assert!(help.contains(&format!("evpose {command}")), "{command}:\n{help}");
    }
}

#[cfg(not(feature = "wgpu"))]
#[test]
fn a_device_that_was_not_built_in_names_its_feature() {
    let sandbox = Sandbox::new();
    let message = sandbox.fails(&["bench", "infer", "--device", "wgpu"]);
    assert!(message.contains("--features wgpu"), "{message}");
}

#[test]
fn messages_say_what_was_asked_and_each_cause_once() {
    let sandbox = Sandbox::new();
    let typo = sandbox.fails(&["simulate", "fintune", "--out", "x"]);
    assert!(typo.contains("did you mean finetune") && typo.contains("eventhands"), "{typo}");
    // Too short to train on, which does not matter here.
    let short = ["--set", "simulation.seconds=0.2", "--set", "simulation.image_scale=0.15"];
    let simulate = ["simulate", "eventhands", "--sequences", "1", "--out", "short"];
    sandbox.ok(&[&simulate[..], &short].concat());
    let train = ["train", "eventhands", "--data", "short", "--out", "r"];
    let train = sandbox.fails(&[&train[..], &short[..2]].concat());
    assert!(train.contains("training.validation_s"), "{train}");
    let missing = sandbox.fails(&["info", "nofile"]);
    assert_eq!(missing.matches("No such file").count(), 1, "{missing}");
    let unknown =
        sandbox.fails(&["infer", "--checkpoint", "nofile", "--events", "x", "--out", "y"]);
    assert_eq!(unknown.matches("nofile").count(), 1, "{unknown}");
    assert!(unknown.contains("no shipped network"), "{unknown}");
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let sandbox = Sandbox::new();
    for (out, threads) in [("one", "1"), ("two", "2")] {
        sandbox.ok(&tiny(&["simulate", "quick", "--out", out, "--threads", threads]));
    }
    for name in ["0000.evc", "0000.meta", "0001.evc", "0001.meta", "0001.toml", "config.toml"] {
        let (one, two) = (sandbox.path("one").join(name), sandbox.path("two").join(name));
        assert!(bytes(&one) == bytes(&two), "{name} differs");
    }
    sandbox.ok(&tiny(&["simulate", "quick", "--out", "other", "--seed", "9"]));
    assert!(bytes(&sandbox.path("one/0000.evc")) != bytes(&sandbox.path("other/0000.evc")));
}

#[test]
fn info_describes_a_recording_and_refuses_a_damaged_one() {
    let sandbox = Sandbox::with_hands();
    let info = sandbox.ok(&["info", "data/0000.evc"]);
    assert!(info.contains("evc"), "{info}");
    let mut damaged = bytes(&sandbox.path("data/0000.evc"));
    damaged[403] = 7; // a polarity that does not exist
    sandbox.write("damaged.evc", &damaged);
    let message = sandbox.fails(&["info", "damaged.evc"]);
    assert!(message.contains("damaged.evc") && message.contains("byte 40"), "{message}");
    let train = tiny(&["train", "quick", "--data", ".", "--out", "run"]);
    let message = sandbox.fails(&train);
    assert!(message.contains("damaged"), "{message}");
}

#[test]
fn completions_know_the_commands_in_every_shell() {
    let sandbox = Sandbox::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = sandbox.ok(&["completions", shell]);
        for word in ["check-labels", "quantize", "checkpoint"] {
            assert!(script.contains(word), "{shell}: no {word}");
        }
    }
    assert!(sandbox.fails(&["completions", "cmd"]).contains("powershell"));
}

#[test]
fn manual_pages_are_one_of_the_program_and_one_of_each_command() {
    let sandbox = Sandbox::new();
    let said = sandbox.ok(&["man", "--out", "man/man1"]);
    assert!(said.contains("evpose.1"), "{said}");
    let page = sandbox.text("man/man1/evpose-gap-run.1");
    assert!(page.contains(".TH") && page.contains("measured"), "{page}");
    assert!(sandbox.path("man/man1/evpose.1").exists());
}
