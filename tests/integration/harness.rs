//! Runs the real binary in a fresh directory.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Changes that make the quick config small enough for a test: seconds instead of minutes.
pub(crate) const TINY: &[&str] = &[
    "simulation.image_scale=0.15",
    "simulation.sequences=2",
    "simulation.seconds=0.4",
    "network.width=0.0625",
    "training.batch_size=4",
    "training.steps=12",
    "training.steps_per_validation=3",
    "training.validation_s=0.12",
    "training.validation_samples=8",
    "evaluation.sequences=2",
    "evaluation.seconds=0.2",
    "evaluation.bootstrap.resamples=50",
];

/// Changes that make the configs of bodies small enough for a test.
pub(crate) const BODY_TINY: &[&str] = &[
    "simulation.sequences=3",
    "simulation.seconds=0.5",
    "simulation.step_hz=250",
    "simulation.label_hz=50",
    "simulation.sensor_size={ width = 96, height = 72 }",
    "simulation.surroundings.source={ procedural = 3 }",
    "data.stills=12",
    "data.first_ms=100",
    "data.min_joints=4",
    "data.validation_share=0.3",
    "image.side_px=32",
    "network.width=0.25",
    "network.expansion=2",
    "training.batch_size=4",
    "training.steps=8",
    "training.steps_per_validation=2",
    "training.validation_samples=4",
    "evaluation.sequences=2",
    "evaluation.seconds=0.5",
    "evaluation.bootstrap.resamples=50",
];

/// The benchmark of the gap workflow, a program of another package: built when it is first asked for, with the
/// profile of the program and beside it.
pub(crate) static GAPBENCH: LazyLock<PathBuf> = LazyLock::new(|| {
    let built = Path::new(env!("CARGO_BIN_EXE_evpose")).parent().unwrap();
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    command.args(["build", "--quiet", "--locked", "--package=gapbench"]);
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .arg("--target-dir")
        .arg(built.parent().unwrap());
    if built.ends_with("release") {
        command.arg("--release");
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "building gapbench:\n{}", stderr(&output));
    built.join(format!("gapbench{}", std::env::consts::EXE_SUFFIX))
});

/// The path of a file in the directory of networks that ship.
pub(crate) fn shipped(name: &str) -> String {
    format!("{}/checkpoints/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A directory that is gone when the test ends.
pub(crate) struct Sandbox {
    dir: tempfile::TempDir,
}

impl Sandbox {
    pub(crate) fn new() -> Self {
        Self { dir: tempfile::tempdir().unwrap() }
    }

    /// One with small recordings of hands in `data`.
    pub(crate) fn with_hands() -> Self {
        let sandbox = Self::new();
        sandbox.ok(&tiny(&["simulate", "quick", "--out", "data"]));
        sandbox
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(bytes(&self.path(name))).unwrap()
    }

    pub(crate) fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&bytes(&self.path(name))).unwrap()
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// `evpose` with these arguments, not yet started.
    pub(crate) fn evpose(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_evpose"));
        command.current_dir(self.dir.path()).args(args).stdin(Stdio::null());
        command.env("EVPOSE_DATA", self.path("data-directory"));
        command
    }

    /// Runs to the end and wants success; returns standard output.
    pub(crate) fn ok(&self, args: &[&str]) -> String {
        stdout_of(&mut self.evpose(args))
    }

    /// As [`Self::ok`], of `gapbench` with the words of a line, which evaluates the program built for the tests.
    pub(crate) fn gapbench(&self, line: &str) -> String {
        let mut command = Command::new(&*GAPBENCH);
        command.current_dir(self.dir.path()).args(line.split_whitespace());
        stdout_of(command.env("EVPOSE", env!("CARGO_BIN_EXE_evpose")).stdin(Stdio::null()))
    }

    /// As [`Self::ok`], with the words of a line and `more`.
    pub(crate) fn run(&self, line: &str, more: &[&str]) -> String {
        self.ok(&[&line.split_whitespace().collect::<Vec<_>>(), more].concat())
    }

    /// Runs to the end and wants failure; returns standard error.
    pub(crate) fn fails(&self, args: &[&str]) -> String {
        let output = self.evpose(args).output().unwrap();
        assert!(!output.status.success(), "evpose {} succeeded", args.join(" "));
        stderr(&output)
    }

    /// Runs to the end. Returns the exit code, and what was said on both outputs.
    pub(crate) fn ends(&self, args: &[&str]) -> (Option<i32>, String) {
        let output = self.evpose(args).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(&output);
        (output.status.code(), said)
    }

    pub(crate) fn start(&self, args: &[&str]) -> Child {
        self.evpose(args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    /// Kills the command `later` than something has `begun`. Who calls it sees by what is missing whether that was too
    /// late.
    pub(crate) fn kill(&self, args: &[&str], begun: impl Fn() -> bool, later: Duration) {
        let mut child = self.start(args);
        let deadline = Instant::now() + Duration::from_secs(300);
        while !begun() && child.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "no progress of evpose {}", args.join(" "));
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(later);
        child.kill().unwrap();
        child.wait().unwrap();
    }
}

/// A command with the tiny config's changes.
pub(crate) fn tiny<'a>(args: &[&'a str]) -> Vec<&'a str> {
    with(TINY, args)
}

/// A command with the tiny changes of bodies.
pub(crate) fn tiny_body<'a>(args: &[&'a str]) -> Vec<&'a str> {
    with(BODY_TINY, args)
}

fn with<'a>(changes: &[&'a str], args: &[&'a str]) -> Vec<&'a str> {
    args.iter().copied().chain(changes.iter().flat_map(|change| ["--set", change])).collect()
}

/// Standard output of a command that succeeds.
fn stdout_of(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}:\n{}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub(crate) fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}
