//! Instructions that ten kernels execute, counted by callgrind and compared with stored counts.
//!
//! Times differ from run to run and from machine to machine; counts do not, so that a regression of a few
//! percent shows on a busy machine. Where there is no valgrind, or the program was built in another way than the
//! stored counts were made with (compiler, level of vector instructions, incremental compilation, which inlines
//! less), nothing is compared, and the output says why.
//!
//! ```console
//! $ CARGO_INCREMENTAL=0 cargo test --test instructions              # compare
//! $ CARGO_INCREMENTAL=0 cargo test --test instructions -- --store   # store counts: after a change that is meant
//! ```
//!
//! Both want a target directory in which nothing was compiled incrementally, as CI has it.

mod kernels;
#[path = "../../crates/bench/src/sensor/scene.rs"]
#[allow(dead_code, unreachable_pub, reason = "shared with the benchmarks, which use all of it")]
mod scene;
mod stored;

use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail, ensure};
use evpose_kernels::Level;

use kernels::{KERNELS, measured};
use stored::StoredCounts;

/// Increase beyond which a kernel counts as slower.
const TOLERANCE: f64 = 0.03;
/// The argument with which this program runs one kernel, under valgrind.
const RUN: &str = "--run-kernel";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.as_slice() {
        [run, name] if run == RUN => run_kernel(name),
        // As test harnesses do: a list is not a run.
        [first, ..] if first == "--list" => Ok(()),
        [first, ..] if first == "--store" => store(),
        _ => compare(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            print(&format!("error: {error:#}"));
            print("test result: FAILED. 0 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out");
            ExitCode::FAILURE
        }
    }
}

/// Prepares a kernel, runs it once to warm up, and once where callgrind counts.
fn run_kernel(name: &str) -> Result<()> {
    if name == "level" {
        print(&Level::best().to_string());
        return Ok(());
    }
    // Callgrind counts in the thread that enters the measured function.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    let kernel = KERNELS.iter().find(|kernel| kernel.name == name).context("a kernel")?;
    let mut run = (kernel.prepare)()?;
    run();
    measured(&mut *run);
    Ok(())
}

/// Compares all kernels with their stored counts.
fn compare() -> Result<()> {
    let stored = StoredCounts::read()?;
    let conditions = match conditions() {
        Ok(conditions) => conditions,
        Err(reason) => return skip(&format!("{reason:#}")),
    };
    if conditions != stored.conditions {
        return skip(&format!(
            "the counts are those of {:?}, this is {conditions:?}",
            stored.conditions
        ));
    }
    let mut slower = Vec::new();
    for kernel in KERNELS {
        let before = *stored.counts.get(kernel.name).context("a kernel without a stored count")?;
        let now = count(kernel.name)?;
        let change = now as f64 / before as f64 - 1.0;
        print(&format!("{:24} {now:>12} instructions {:+.2} %", kernel.name, 100.0 * change));
        if change > TOLERANCE {
            slower.push(kernel.name);
        }
    }
    if !slower.is_empty() {
        bail!(
            "more than {:.0} % more instructions: {}; if that is meant, `cargo test --test instructions -- \
             --store`",
            100.0 * TOLERANCE,
            slower.join(", ")
        );
    }
    let passed = KERNELS.len();
    print(&format!(
        "test result: ok. {passed} passed; 0 failed; 0 ignored; 0 measured; 0 filtered out"
    ));
    Ok(())
}

/// Says why nothing is compared.
fn skip(reason: &str) -> Result<()> {
    print(&format!("not compared: {reason}"));
    let ignored = KERNELS.len();
    print(&format!(
        "test result: ok. 0 passed; 0 failed; {ignored} ignored; 0 measured; 0 filtered out"
    ));
    Ok(())
}

/// Stores the counts of this machine.
fn store() -> Result<()> {
    let counts = KERNELS.iter().map(|kernel| Ok((kernel.name.to_owned(), count(kernel.name)?)));
    StoredCounts { conditions: conditions()?, counts: counts.collect::<Result<_>>()? }.write()
}

/// The compiler, and the level of vector instructions that valgrind offers.
fn conditions() -> Result<stored::Conditions> {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = Command::new(rustc).arg("--version").output().context("running rustc")?;
    let level = valgrind(&["--tool=none"], "level")?;
    Ok(stored::Conditions {
        compiler: String::from_utf8_lossy(&version.stdout).trim().to_owned(),
        level: String::from_utf8_lossy(&level.stdout).trim().to_owned(),
        is_incremental: option_env!("CARGO_INCREMENTAL") != Some("0"),
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
    })
}

/// Instructions of one run of a kernel.
fn count(name: &str) -> Result<u64> {
    let options = [
        "--tool=callgrind",
        "--callgrind-out-file=/dev/null",
        "--collect-atstart=no",
        "--toggle-collect=*kernels::measured*",
    ];
    let output = valgrind(&options, name)?;
    let text = String::from_utf8_lossy(&output.stderr);
    let collected = text.lines().find_map(|line| line.split_once("Collected : "));
    let (_, count) = collected.with_context(|| format!("no count in what it printed:\n{text}"))?;
    let count: u64 = count.trim().parse().context("a count")?;
    ensure!(count > 0, "{name}: the function that is measured was not found");
    Ok(count)
}

/// Runs this program on one kernel under valgrind.
fn valgrind(options: &[&str], kernel: &str) -> Result<std::process::Output> {
    let program = std::env::current_exe().context("finding this program")?;
    let output = Command::new("valgrind")
        .args(options)
        .arg(program)
        .args([RUN, kernel])
        .output()
        .context("valgrind does not run: install it to compare counts")?;
    ensure!(
        output.status.success(),
        "{kernel}: {}\n{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    Ok(output)
}

#[expect(clippy::print_stdout, reason = "a test without a harness prints its own results")]
fn print(line: &str) {
    println!("{line}");
}
