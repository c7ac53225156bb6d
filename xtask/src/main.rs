//! The project's checks, the same on a laptop and in CI.
//!
//! `cargo xtask ci` runs what every change must pass; `cargo xtask slow` the checks that need
//! optional devices and Rerun's SDK. The last line is the total of all tests.

mod circles;
mod files;
mod gpu;
mod lines;
mod words;

use std::io::{BufRead, BufReader};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail};

/// Steps with their reasons.
const CI: &[Step] = &[
    Step { why: "one style", args: &["fmt", "--all", "--check"], env: &[] },
    Step {
        why: "files of a crate import each other in small circles only",
        args: &["xtask", "circles"],
        env: &[],
    },
    Step {
        why: "names and prose in the words of the glossary",
        args: &["xtask", "words"],
        env: &[],
    },
    Step { why: "the command line stays small", args: &["xtask", "lines"], env: &[] },
    Step {
        why: "lints, tests and benches included",
        args: &["clippy", "--workspace", "--all-targets", "--quiet", "--", "-D", "warnings"],
        env: &[],
    },
    Step {
        why: "documentation complete, its links alive",
        args: &["doc", "--workspace", "--no-deps", "--quiet"],
        env: &[("RUSTDOCFLAGS", "-D warnings")],
    },
    Step { why: "tests", args: &["test", "--workspace", "--no-fail-fast"], env: &[] },
    Step {
        why: "optional features: HDF5 recordings, Zstandard's library, hands of glTF files",
        args: &[
            "test",
            "--package=evpose-io",
            "--package=evpose-body",
            "--features=evpose-io/hdf5,evpose-io/zstd,evpose-body/gltf",
            "--no-fail-fast",
        ],
        env: &[],
    },
    Step {
        // Its recordings evaluate the gap workflow: a shared formula would be compared with itself.
        why: "the benchmark's pixel shares no code with the simulator",
        args: &[
            "tree",
            "--package",
            "gapbench-pixel",
            "--edges",
            "all",
            "--prefix",
            "none",
            "--quiet",
        ],
        env: &[],
    },
];

/// No crate of this name may be in the output of `cargo tree`.
const REFUSED: &str = "evpose";

const SLOW: &[Step] = &[
    Step {
        why: "twelve recordings in which an effect is hidden, or none",
        args: &["test", "--release", "--test=integration", "twelve_blind", "--", "--ignored"],
        env: &[],
    },
    Step {
        why: "every command of README.md and the guides runs, in small",
        args: &["test", "--release", "--test=integration", "all_pages_run", "--", "--ignored"],
        env: &[],
    },
    Step {
        why: "an installed program has its networks",
        args: &["test", "--release", "--test=integration", "installed", "--", "--ignored"],
        env: &[],
    },
    Step {
        why: "an engine beside a busy thread",
        args: &["test", "--package=evpose-infer", "--test=threads", "--", "--ignored"],
        env: &[],
    },
    Step {
        why: "ndarray and flex agree on the hand network",
        args: &["test", "--release", "--package", "evpose-nn", "--features", "ndarray"],
        env: &[],
    },
    Step {
        why: "files for the Rerun viewer, whose SDK takes minutes to build",
        args: &["test", "--package", "evpose-rerun", "--features", "sdk"],
        env: &[],
    },
    Step {
        // libusb is built along, which is C.
        why: "packets of cameras are decoded",
        args: &["test", "--package", "evpose-live", "--features", "cameras", "--lib"],
        env: &[],
    },
    Step {
        why: "other programs in the benchmarks compile",
        args: &["clippy", "--features=peers", "--all-targets", "--quiet", "--", "-D", "warnings"],
        env: &[],
    },
    Step {
        why: "networks have the same outputs in tract",
        args: &["test", "--release", "--features=peers", "--bin=evpose", "peers"],
        env: &[],
    },
    Step {
        // Not of the workspace; to run them takes a nightly compiler, to check them does not.
        why: "fuzz targets compile",
        args: &["check", "--manifest-path", "fuzz/Cargo.toml", "--all-targets"],
        env: &[],
    },
    Step {
        // A nightly compiler has to be installed. What runs is compiled for every level of instructions.
        why: "kernels read and write only what is theirs, under AddressSanitizer",
        args: &[
            "+nightly",
            "test",
            "--package=evpose-kernels",
            "--lib",
            "--tests",
            "--target=x86_64-unknown-linux-gnu",
        ],
        env: &[("RUSTFLAGS", "-Zsanitizer=address"), ("PROPTEST_CASES", "12")],
    },
    Step {
        // Without a network: in the order of dependencies, each with all versions and metadata. What
        // they hold is not compiled, and whether names are free is not asked.
        why: "every crate makes a package",
        args: &[
            "package",
            "--workspace",
            "--exclude=xtask",
            "--exclude=evpose-plugin",
            "--no-verify",
            "--offline",
            "--allow-dirty",
            "--quiet",
        ],
        env: &[],
    },
    Step {
        // Nothing is installed: without an adapter, each test says what is missing and how to get it.
        why: "every network infers and trains on wgpu as on the CPU",
        args: &[
            "test",
            "--package=evpose-nn",
            "--features=wgpu",
            "--test=wgpu",
            "--",
            "--nocapture",
            "--test-threads=1",
        ],
        env: &[],
    },
    Step {
        why: "programs on wgpu: poses of the CPU, trainings from device to device, a missing driver",
        args: &[
            "test",
            "--features=wgpu",
            "--test=integration",
            "devices::",
            "--",
            "--nocapture",
            "--test-threads=1",
        ],
        env: &[],
    },
    Step {
        // A dependency fetches a compiler when it builds, except for documentation.
        why: "cuda compiles",
        args: &["check", "--features", "cuda"],
        env: &[("DOCS_RS", "1")],
    },
];

const USAGE: &str = "usage: cargo xtask ci|slow|words [CRATE…] [--list]|circles [CRATE…]|lines|gpu

  ci    formatting, lints, documentation, all tests, what the benchmark is built from (what CI runs)
  slow  twelve blind recordings; all commands of the guides; an installed program; the ndarray
        agreement test; files for Rerun; packets of cameras; networks in tract; kernels under
        AddressSanitizer; packages of all crates; networks and programs on wgpu, a GPU's or Mesa's
        software; peers, fuzz targets and cuda compile
  words  words that docs/glossary.md replaces: counts by crate, by file for a PATH or crate;
         --list shows each use and the standard word
  circles  files of a crate that import each other; every circle of the crates that are named
  lines  lines of Rust by crate, and the limit of the command line
  gpu    a program to carry to a machine with a GPU: see docs/guide/gpu.md";

struct Step {
    why: &'static str,
    args: &'static [&'static str],
    env: &'static [(&'static str, &'static str)],
}

/// Tests seen in the output of `cargo test`.
#[derive(Default)]
struct Totals {
    passed: u64,
    failed: u64,
    ignored: u64,
}

impl Totals {
    /// Adds a line like `test result: ok. 3 passed; 0 failed; 1 ignored; …`.
    fn add(&mut self, line: &str) {
        let Some((_, counts)) = line.split_once("test result: ") else { return };
        let words: Vec<&str> = counts.split([' ', ';', '.']).filter(|w| !w.is_empty()).collect();
        for pair in words.windows(2) {
            let Ok(count) = pair[0].parse::<u64>() else { continue };
            match pair[1] {
                "passed" => self.passed += count,
                "failed" => self.failed += count,
                "ignored" => self.ignored += count,
                _ => {}
            }
        }
    }
}

fn main() -> ExitCode {
    let steps = match std::env::args().nth(1).as_deref() {
        Some("ci") => CI,
        Some("slow") => SLOW,
        Some(check @ ("words" | "circles" | "lines" | "gpu")) => {
            let args: Vec<String> = std::env::args().skip(2).collect();
            let run = match check {
                "words" => words::run,
                "circles" => circles::run,
                "gpu" => gpu::run,
                _ => lines::run,
            };
            return match run(&args, say) {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => {
                    say(&format!("{error:#}"));
                    ExitCode::FAILURE
                }
            };
        }
        _ => {
            say(USAGE);
            return ExitCode::from(2);
        }
    };
    let mut totals = Totals::default();
    let mut failures = Vec::new();
    for step in steps {
        if let Err(error) = run(step, &mut totals) {
            say(&format!("FAILED: {error:#}"));
            failures.push(step.args.join(" "));
        }
    }
    for failure in &failures {
        say(&format!("failed: cargo {failure}"));
    }
    // A step that failed before it ran a test still counts as a failure.
    let failed = totals.failed.max(failures.len() as u64);
    say(&format!("{} passed, {failed} failed, {} skipped", totals.passed, totals.ignored));
    if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs one step, passing its output on and counting the tests in it.
fn run(step: &Step, totals: &mut Totals) -> Result<()> {
    say(&format!("== {} (cargo {})", step.why, step.args.join(" ")));
    let started = Instant::now();
    // Another toolchain is chosen by what rustup puts in front of cargo.
    let is_chosen = step.args[0].starts_with('+');
    let cargo = std::env::var("CARGO").ok().filter(|_| !is_chosen);
    let cargo = cargo.unwrap_or_else(|| "cargo".into());
    let mut child = Command::new(cargo)
        .args(step.args)
        .envs(step.env.iter().copied())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .context("starting cargo")?;
    let output = child.stdout.take().context("cargo's output")?;
    let mut refused = false;
    for line in BufReader::new(output).lines() {
        let line = line.context("reading cargo's output")?;
        totals.add(&line);
        refused |= is_refused(step.args, &line);
        say(&line);
    }
    let status = child.wait()?;
    say(&format!("== {:.0} s", started.elapsed().as_secs_f64()));
    if !status.success() {
        bail!("cargo {} ended with {status}", step.args.join(" "));
    }
    if refused {
        bail!("cargo {}: no crate called {REFUSED}* may be in it", step.args.join(" "));
    }
    Ok(())
}

/// Whether a line of `cargo tree --prefix none` names a crate that must not be there.
fn is_refused(args: &[&str], line: &str) -> bool {
    args.first() == Some(&"tree") && line.starts_with(REFUSED)
}

#[expect(clippy::print_stdout, reason = "a command-line tool")]
fn say(line: &str) {
    println!("{line}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_may_not_hold_crates_of_the_simulator() {
        let tree = ["tree", "--package", "gapbench-pixel"];
        assert!(is_refused(&tree, "evpose-sensor v0.1.0 (/here/evpose/crates/sensor)"));
        assert!(!is_refused(&tree, "gapbench-pixel v0.1.0 (/here/evpose/crates/gapbench-pixel)"));
        assert!(!is_refused(&["test"], "evpose-sensor v0.1.0"));
    }

    #[test]
    fn totals_add_up_over_test_binaries() {
        let mut totals = Totals::default();
        totals.add("test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out");
        totals.add("test result: FAILED. 2 passed; 4 failed; 0 ignored; 0 measured");
        totals.add("running 5 tests");
        assert_eq!((totals.passed, totals.failed, totals.ignored), (5, 4, 1));
    }
}
