//! The project's checks, the same on a laptop and in CI.
//!
//! `cargo xtask ci` runs what every change must pass; `cargo xtask slow` what takes long or needs
//! what not every machine has. The last line is the total of all tests.

mod circles;
mod figures;
mod files;
mod gpu;
mod lines;
mod links;
mod mutants;
mod named_paths;
mod needs;
mod packages;
mod run;
mod slurm;
mod steps;
mod totals;
mod words;

use std::process::ExitCode;

use run::Choice;

const USAGE: &str = "\
usage: cargo xtask ci|quick|slow [--only TEXT] [--from N] [--list]
       cargo xtask setup | words [CRATE…] [--list] | circles [CRATE…] | lines | links
       cargo xtask mutants [CRATE [K/N|again]] | figures [--check] | guides | gpu
       cargo xtask slurm [PROGRAM]

  ci    formatting, lints with all optional features, documentation, all tests, what the
        benchmark is built from (what CI runs)
  quick what ci checks without building, then lints and unit tests of small crates: minutes
  slow  tests with all optional features, and of what takes long: blind recordings, all commands of
        the guides, kernels under AddressSanitizer, packages; fuzz targets and cuda compile
        --only TEXT   steps that have it in their name
        --from N      from step N on
        --list        names the steps
  setup   installs programs that tests run: Chromium, valgrind, Mesa's Vulkan (Debian, as root; CI
          does it by itself). Tests are ignored without them
  words   words that docs/glossary.md replaces: counts by crate, by file for a PATH or crate;
          --list shows each use and the standard word
  circles files of a crate that import each other; every circle of the crates that are named
  lines   lines of Rust by crate, and the limit of the command line
  links   links of pages that lead nowhere, paths that ARCHITECTURE.md names and are not there
  mutants tries mutants of a crate with cargo-mutants, every N-th one from the K-th on or those that
          survived, and writes benches/mutants.md; hours for all crates
  figures writes figures of README.md and the guides from results below benches/; --check compares
  guides  runs the commands of README.md and the guides, of one page with EVPOSE_PAGE=NAME, and writes
          their outputs into the pages
  gpu     a program to carry to a machine with a GPU: see docs/guide/gpu.md
  slurm   configs/jobs/simulate.slurm, shortened, on a cluster of one node: a worker is killed and
          started again, and the files are those of a run without shards (Debian, as root:
          apt-get install slurmctld slurmd slurm-client); PROGRAM is target/release/evpose";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let Some((command, args)) = args.split_first() else {
        say(USAGE);
        // Wrong usage has an exit code of its own.
        return ExitCode::from(2);
    };
    let result = match command.as_str() {
        "ci" => return run_steps(steps::CI, args),
        "quick" => return run_steps(&[&steps::CI[..steps::UNBUILT], steps::QUICK].concat(), args),
        "slow" => return run_steps(steps::SLOW, args),
        "setup" => {
            packages::install(say);
            Ok(())
        }
        "words" => words::run(args, say),
        "circles" => circles::run(args, say),
        "lines" => lines::run(args, say),
        "links" => links::run(say),
        "mutants" => mutants::run(args, say),
        "figures" => figures::run(args, say),
        "gpu" => gpu::run(args, say),
        "slurm" => slurm::run(args, say),
        "guides" => return run_steps(&[steps::GUIDES], args),
        _ => {
            say(USAGE);
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("{error:#}"));
            ExitCode::FAILURE
        }
    }
}

fn run_steps(steps: &[steps::Step], args: &[String]) -> ExitCode {
    let choice = match Choice::parse(args) {
        Ok(choice) => choice,
        Err(error) => {
            say(&format!("{error:#}\n{USAGE}"));
            return ExitCode::from(2);
        }
    };
    // Nothing is installed on a machine of somebody who did not ask for it.
    if !choice.is_list && std::env::var_os("CI").is_some_and(|value| !value.is_empty()) {
        packages::install(say);
    }
    run::run(steps, &choice, say)
}

#[expect(clippy::print_stdout, reason = "a command-line tool")]
fn say(line: &str) {
    println!("{line}");
}
