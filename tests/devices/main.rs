//! Programs on wgpu, as a user runs them; ignored where there is no adapter, with the reason.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

#[path = "../integration/harness.rs"]
#[allow(dead_code, reason = "shared with the other tests of the program, which use all of it")]
mod harness;

use std::process::{ExitCode, Output};
use std::time::{Duration, Instant};

use evpose_io::poses::read_poses;
use evpose_nn::{Availability, DeviceKind};
use evpose_train::read_history;
use libtest_mimic::{Arguments, Completion, Trial};

use crate::harness::{Sandbox, bytes, stderr, tiny, tiny_body};

const GPU: [&str; 2] = ["--device", "wgpu"];

fn main() -> ExitCode {
    // A test harness of its own: whether a machine has an adapter is known only at run time.
    let on_adapters: [(&str, fn()); 3] = [
        (
            "poses_of_hands_and_bodies_are_those_of_the_cpu",
            poses_of_hands_and_bodies_are_those_of_the_cpu,
        ),
        ("a_training_goes_on_from_device_to_device", a_training_goes_on_from_device_to_device),
        ("bodies_train_as_on_the_cpu", bodies_train_as_on_the_cpu),
    ];
    let mut trials = vec![Trial::ignorable_test(
        "a_missing_adapter_is_an_error_that_says_what_is_missing",
        || Ok(a_missing_adapter_is_an_error_that_says_what_is_missing()),
    )];
    // Ignored with the reason, instead of passed: a log shows what was not tested.
    trials.extend(on_adapters.map(|(name, test)| {
        Trial::ignorable_test(name, move || {
            match Availability::of(DeviceKind::Wgpu { adapter: None }) {
                Availability::Adapters(_) => {
                    test();
                    Ok(Completion::Completed)
                }
                Availability::Missing { reason } => Ok(Completion::ignored_with(reason)),
                Availability::NotBuilt => Err("the feature wgpu is off".into()),
            }
        })
    }));
    libtest_mimic::run(&Arguments::from_args(), trials).exit_code()
}

/// Most and mean of the differences of all joints of two files of poses, in pixels; the same joints
/// of the same times are there.
fn distances_px(sandbox: &Sandbox, [a, b]: [&str; 2]) -> [f32; 2] {
    let [a, b] = [a, b].map(|name| read_poses(&sandbox.path(name)).unwrap().poses);
    assert!(!a.is_empty() && a.len() == b.len());
    let mut distances = Vec::new();
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(a.t, b.t);
        for (a, b) in a.joints.iter().zip(&b.joints) {
            assert_eq!(a.image_px.is_some(), b.image_px.is_some());
            distances.extend(a.image_px.zip(b.image_px).map(|(a, b)| a.distance(b)));
        }
    }
    // Two files without joints would agree.
    assert!(!distances.is_empty());
    let mean = distances.iter().sum::<f32>() / distances.len() as f32;
    [distances.iter().copied().fold(0.0, f32::max), mean]
}

fn poses_of_hands_and_bodies_are_those_of_the_cpu() {
    let sandbox = Sandbox::new();
    let few = ["simulation.sequences=1", "simulation.seconds=0.3"];
    let set = few.iter().flat_map(|change| ["--set", change]);
    let simulated = ["simulate", "quick", "--out", "data"].into_iter().chain(set);
    sandbox.ok(&simulated.collect::<Vec<_>>());
    for (checkpoint, more) in [
        ("hand-quick", &[][..]),
        ("body-quick", &["--stride-ms", "20", "--min-score", "0", "--confidence", "0"]),
    ] {
        let infer = ["infer", "--checkpoint", checkpoint, "--events", "data/0000.evc"];
        let infer = [&infer[..], more, &["--camera", "45deg"]].concat();
        sandbox.ok(&[&infer[..], &["--out", "cpu.csv"]].concat());
        sandbox.ok(&[&infer[..], &["--out", "gpu.csv"], &GPU].concat());
        let [most, mean] = distances_px(&sandbox, ["cpu.csv", "gpu.csv"]);
        println!("{checkpoint}: at most {most} px, {mean} px on average");
        // Maxima of two cells that are equal but for rounding may be either.
        assert!(most < 1.0 && mean < 0.01, "{checkpoint}: at most {most} px, {mean} px on average");
        let cpu = bytes(&sandbox.path("cpu.csv"));
        assert!(cpu != bytes(&sandbox.path("gpu.csv")), "{checkpoint}: the CPU inferred both");
        let reduced = [&infer[..], &["--out", "no.csv", "--precision", "bf16"], &GPU].concat();
        let message = sandbox.fails(&reduced);
        assert!(message.contains("--precision bf16 is for our engine"), "{message}");
    }
}

fn a_training_goes_on_from_device_to_device() {
    let sandbox = Sandbox::with_hands();
    let train = |out: &'static str| {
        let args = tiny(&["train", "quick", "--data", "data", "--out", out, "--plain"]);
        [&args[..], &["--set", "training.steps=24"]].concat()
    };
    sandbox.ok(&train("whole"));
    let resumed = [&train("mixed")[..], &["--resume"]].concat();
    // Killed behind a checkpoint each time; the next run goes on elsewhere.
    for (device, until) in [(&[][..], 2), (&GPU, 5)] {
        let mut child = sandbox.start(&[&resumed[..], device].concat());
        let state = sandbox.path("mixed/checkpoint").join(format!("schedule-{until}.bpk"));
        let deadline = Instant::now() + Duration::from_secs(300);
        while !state.exists() {
            assert!(Instant::now() < deadline && child.try_wait().unwrap().is_none());
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        // Otherwise the last run would have nothing to resume.
        assert!(!sandbox.path("mixed/last.bpk").exists(), "the kill came too late");
    }
    sandbox.ok(&resumed);
    let difference = difference_of_losses(&sandbox, ["whole", "mixed"]);
    // Bits differ between devices: equal losses would mean that only one computed.
    assert!(difference > 0.0, "every step was computed on the CPU");
    assert!(difference < 0.02, "{difference}");
}

/// The largest difference of the values of any step of two runs, relative to the value, at least
/// 0.01.
fn difference_of_losses(sandbox: &Sandbox, runs: [&str; 2]) -> f64 {
    let [a, b] = runs.map(|run| read_history(&sandbox.path(run).join("metrics.jsonl")).unwrap());
    assert!(!a.is_empty() && a.len() == b.len());
    let mut most = 0.0f64;
    for (a, b) in a.iter().zip(&b) {
        assert_eq!((a.interval, a.batch), (b.interval, b.batch));
        for ((name, a), (_, b)) in a.values.iter().zip(&b.values) {
            assert!(a.is_finite() && b.is_finite(), "{name}: {a}, {b}");
            most = most.max((a - b).abs() / a.abs().max(0.01));
        }
    }
    println!("{runs:?}: losses differ by {most:.1e}");
    most
}

fn bodies_train_as_on_the_cpu() {
    let sandbox = Sandbox::new();
    let train = |out: &'static str| {
        let args = tiny_body(&["train", "pretrain", "--out", out, "--plain"]);
        [&args[..], &["--set", "training.steps=4"]].concat()
    };
    sandbox.ok(&train("cpu"));
    sandbox.ok(&[&train("gpu")[..], &GPU].concat());
    let difference = difference_of_losses(&sandbox, ["cpu", "gpu"]);
    assert!(difference > 0.0 && difference < 0.02, "{difference}");
}

fn a_missing_adapter_is_an_error_that_says_what_is_missing() -> Completion {
    let sandbox = Sandbox::new();
    let without_drivers = |args: &[&str]| -> Output {
        let mut command = sandbox.evpose(args);
        for variable in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            command.env(variable, "/nowhere/none.json");
        }
        // Neither OpenGL, which is tried next.
        command.env("__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere/none.json");
        command.output().unwrap()
    };
    let listed = without_drivers(&["info", "--devices"]);
    let listed = String::from_utf8(listed.stdout).unwrap();
    if listed.contains("wgpu:0") {
        return Completion::ignored_with("no variable takes the adapters of this system away");
    }
    assert!(listed.contains("wgpu      none: "), "{listed}");
    let output = without_drivers(&["bench", "infer", "--config", "quick", "--device", "wgpu"]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("no wgpu device: ") && !message.contains("panicked"), "{message}");
    let message = sandbox.fails(&["bench", "infer", "--config", "quick", "--device", "wgpu:99"]);
    assert!(message.contains("wgpu") && !message.contains("panicked"), "{message}");
    Completion::Completed
}
