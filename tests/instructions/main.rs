//! Instructions that ten kernels execute, counted by callgrind and compared with stored counts.
//!
//! Times differ from run to run and from machine to machine; counts do not, so that a regression of a few
//! percent shows on a busy machine. Where there is no valgrind, or the program was built in another way than the
//! stored counts were made with (compiler, level of vector instructions, incremental compilation, which inlines
//! less), the tests are ignored, with the reason.
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
use std::sync::OnceLock;

use anyhow::{Context, Result, ensure};
use evpose_kernels::Level;
use libtest_mimic::{Arguments, Completion, Trial};

use kernels::{KERNELS, measured};
use stored::{Conditions, StoredCounts};

/// Increase beyond which a kernel counts as slower.
const TOLERANCE: f64 = 0.03;
/// The argument with which this program runs one kernel, under valgrind.
const RUN: &str = "--run-kernel";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.as_slice() {
        // The program is its own child, which runs under valgrind.
        [run, name] if run == RUN => run_kernel(name),
        [first, ..] if first == "--store" => store(),
        _ => return run_tests(),
    };
    result.map_or_else(
        |error| {
            print(&format!("error: {error:#}"));
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
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

/// A test of each kernel.
fn run_tests() -> ExitCode {
    let tests = KERNELS.iter().map(|kernel| {
        Trial::ignorable_test(kernel.name, || {
            compare(kernel.name).map_err(|error| format!("{error:#}").into())
        })
    });
    libtest_mimic::run(&Arguments::from_args(), tests.collect()).exit_code()
}

/// Compares a kernel with its stored count, where that can be done.
fn compare(kernel: &str) -> Result<Completion> {
    // Compiler and valgrind are asked once, for all kernels.
    static OBSTACLE: OnceLock<Option<String>> = OnceLock::new();
    let stored = StoredCounts::read()?;
    let before = *stored.counts.get(kernel).context("a kernel without a stored count")?;
    // Counts depend on the build, the system and the vector instructions that valgrind has.
    if let Some(reason) = OBSTACLE.get_or_init(|| obstacle(&stored.conditions)) {
        return Ok(Completion::ignored_with(reason));
    }
    let now = count(kernel)?;
    let change = now as f64 / before as f64 - 1.0;
    print(&format!("{kernel:24} {now:>12} instructions {:+.2} %", 100.0 * change));
    ensure!(
        change <= TOLERANCE,
        "{:.1} % more instructions, over {:.0} %; if that is meant, `cargo test --test instructions -- --store`",
        100.0 * change,
        100.0 * TOLERANCE
    );
    Ok(Completion::Completed)
}

/// Why counts cannot be compared with those that were stored.
fn obstacle(stored: &Conditions) -> Option<String> {
    match conditions() {
        Ok(here) if here == *stored => None,
        Ok(here) => {
            let texts = |of: &Conditions| {
                let units = if of.is_incremental { "incremental" } else { "not incremental" };
                [of.compiler.clone(), of.level.clone(), units.to_owned(), of.system.clone()]
            };
            let pairs = texts(stored).into_iter().zip(texts(&here));
            let different = pairs.filter(|(stored, here)| stored != here);
            let different =
                different.map(|(stored, here)| format!("{here}, stored counts {stored}"));
            Some(different.collect::<Vec<_>>().join("; "))
        }
        Err(reason) => Some(format!("{reason:#}")),
    }
}

/// Stores the counts of this machine.
fn store() -> Result<()> {
    let counts = KERNELS.iter().map(|kernel| Ok((kernel.name.to_owned(), count(kernel.name)?)));
    StoredCounts { conditions: conditions()?, counts: counts.collect::<Result<_>>()? }.write()
}

/// The compiler, and the level of vector instructions that valgrind offers.
fn conditions() -> Result<Conditions> {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = Command::new(rustc).arg("--version").output().context("running rustc")?;
    let level = valgrind(&["--tool=none"], "level")?;
    Ok(Conditions {
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
        // Counted inside the measured function alone: setting up costs more than it.
        "--collect-atstart=no",
        "--toggle-collect=*kernels::measured*",
    ];
    let output = valgrind(&options, name)?;
    let text = String::from_utf8_lossy(&output.stderr);
    let collected = text.lines().find_map(|line| line.split_once("Collected : "));
    let (_, count) = collected.with_context(|| format!("no count in what it printed:\n{text}"))?;
    let count: u64 = count.trim().parse().context("a count")?;
    // An inlined or renamed function would count nothing, and pass for ever.
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

#[expect(clippy::print_stdout, reason = "counts are shown, changed or not")]
fn print(line: &str) {
    println!("{line}");
}
