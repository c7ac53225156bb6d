//! `evpose gap run`, as users start it: a process for every recording, and the files that it leaves.

use std::ffi::OsStr;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use serde::de::DeserializeOwned;

use crate::bad_input::BadInput;
use crate::files;
use crate::terminal::say;

/// Names the program, where no argument does.
const VARIABLE: &str = "EVPOSE";
/// Both output streams of a run, among its files.
const OUTPUT: &str = "output.txt";

/// The program that is evaluated.
#[derive(Debug, clap::Args)]
pub(crate) struct ProgramArgs {
    /// The program that is evaluated [default: that of the variable EVPOSE, else target/release/evpose of this
    /// repository, else `evpose` of the PATH]
    #[arg(long, value_name = "PATH")]
    evpose: Option<PathBuf>,
    /// CPU threads; all cores by default
    #[arg(long)]
    pub(crate) threads: Option<usize>,
}

#[derive(Debug)]
pub(crate) struct Program {
    path: PathBuf,
    threads: Option<usize>,
    /// The commit that it was built from.
    pub(crate) commit: String,
}

#[derive(Debug)]
pub(crate) struct EndedRun {
    /// Seconds from start to exit, as users wait for it.
    pub(crate) seconds: f64,
    status: ExitStatus,
    report: PathBuf,
}

impl Program {
    /// The program that arguments and environment name, asked for its version.
    pub(crate) fn find(args: &ProgramArgs) -> Result<Self> {
        let name = format!("evpose{}", std::env::consts::EXE_SUFFIX);
        let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/release").join(&name);
        let of_variable = || std::env::var_os(VARIABLE).map(PathBuf::from);
        let path = args
            .evpose
            .clone()
            .or_else(of_variable)
            .unwrap_or_else(|| built.canonicalize().unwrap_or_else(|_| name.into()));
        let program = Self::open(path, args.threads)?;
        say(format!("program   {}, commit {}", program.path.display(), program.commit));
        Ok(program)
    }

    fn open(path: PathBuf, threads: Option<usize>) -> Result<Self> {
        let commit = commit(&path).with_context(|| {
            format!(
                "{} cannot be started: `cargo build --release` builds the program, --evpose PATH or {VARIABLE} \
                 names another",
                path.display()
            )
        });
        let commit = commit.context(BadInput)?;
        Ok(Self { path, threads, commit })
    }

    pub(crate) fn threads(&self) -> usize {
        self.threads.unwrap_or_else(rayon::current_num_threads)
    }

    /// Runs `evpose gap run` with these arguments, which writes into the directory `report`. What an
    /// earlier run left there is removed: it must not pass for that of this one.
    pub(crate) fn gap_run(&self, arguments: &[&OsStr], report: &Path) -> Result<EndedRun> {
        files::remove(report)?;
        files::create(report)?;
        let output = report.join(OUTPUT);
        let file =
            File::create(&output).with_context(|| format!("creating {}", output.display()))?;
        // Both streams go to one file, in the order in which they were written.
        let errors = file.try_clone().context("sharing the output file")?;
        let mut command = Command::new(&self.path);
        command.args(["gap", "run", "--model", "ideal"]).args(arguments).arg("--out").arg(report);
        if let Some(threads) = self.threads {
            command.arg("--threads").arg(threads.to_string());
        }
        let begin = Instant::now();
        // A question of the program would wait for an answer that nobody gives.
        let status = command.stdin(Stdio::null()).stdout(file).stderr(errors).status();
        let seconds = begin.elapsed().as_secs_f64();
        let status = status.with_context(|| format!("starting {}", self.path.display()))?;
        Ok(EndedRun { seconds, status, report: report.to_owned() })
    }
}

impl EndedRun {
    /// Reads a file of JSON that the run has written. Whatever the exit code, the file counts: answers
    /// have codes of their own.
    pub(crate) fn read<T: DeserializeOwned>(&self, name: &str) -> Result<T> {
        let path = self.report.join(name);
        let ended = || {
            let output = self.report.join(OUTPUT);
            format!("`evpose gap run` ended with {}; see {}", self.status, output.display())
        };
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string());
        let text = text.with_context(ended)?;
        serde_json::from_str(&text).with_context(|| path.display().to_string()).with_context(ended)
    }
}

/// The commit that a program was built from, as `--version` says it.
fn commit(program: &Path) -> Result<String> {
    let output = Command::new(program).arg("--version").stdin(Stdio::null()).output()?;
    let said = String::from_utf8_lossy(&output.stdout);
    ensure!(output.status.success(), "--version ended with {}", output.status);
    let commit = said.split_once("(commit ").and_then(|(_, behind)| behind.split_once(')'));
    let (commit, _) =
        commit.with_context(|| format!("--version says no commit: {}", said.trim()))?;
    Ok(commit.to_owned())
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    /// A program that answers `--version`; else it prints its arguments, complains, writes a file into
    /// the directory behind `--out` and ends with 11.
    const STAND_IN: &str = "#!/bin/sh
if [ \"$1\" = --version ]; then echo 'evpose 1.0 (commit 0123abc)'; exit; fi
echo \"$*\"; echo oh >&2
while [ \"$1\" != --out ]; do shift; done
echo '[1, 2]' > \"$2/a.json\"
exit 11
";

    // One test: a process that another test starts meanwhile would hold the script open.
    #[test]
    fn arguments_reach_the_program_and_its_files_are_read_whatever_its_exit_code() -> Result<()> {
        let dir = tempfile::tempdir()?;
        let (script, report) = (dir.path().join("evpose"), dir.path().join("report"));
        std::fs::write(&script, STAND_IN)?;
        std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755))?;
        let program = Program::open(script, Some(3))?;
        assert_eq!((program.commit.as_str(), program.threads()), ("0123abc", 3));
        files::create(&report)?;
        files::write(&report, "stale.json", b"[]")?;
        let ended = program.gap_run(&["--measured", "a b.npz"].map(OsStr::new), &report)?;
        assert_eq!(ended.read::<Vec<u32>>("a.json")?, [1, 2]);
        let expected = format!(
            "gap run --model ideal --measured a b.npz --out {} --threads 3\noh\n",
            report.display()
        );
        assert_eq!(std::fs::read_to_string(report.join(OUTPUT))?, expected);
        let error = ended.read::<Vec<u32>>("stale.json").unwrap_err().to_string();
        assert!(error.contains("exit status: 11") && error.contains(OUTPUT), "{error}");
        // Neither of these is the program.
        for path in [dir.path().join("nowhere"), "/bin/echo".into()] {
            let error = Program::open(path, None).unwrap_err();
            assert!(error.is::<BadInput>());
            assert!(format!("{error:#}").contains("cargo build --release"), "{error:#}");
        }
        Ok(())
    }
}
