//! The sets: where their recordings are, or how they are simulated.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use evpose_cli::tasks::args::SimulateArgs;

use super::BenchAccuracyArgs;
use super::digest;
use super::record::Simulated;

/// A set of recordings with known poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum SetName {
    /// Held-out people and hands of this simulator
    Home,
    /// Recordings of other simulators that networks were tuned by
    Development,
    /// Images of real event cameras (`--real`)
    Real,
    /// Recordings of other simulators that nothing is tuned by (`--open-foreign`)
    Foreign,
}

/// How the home set of each task is simulated.
const HOME: [(&str, &str); 2] = [
    ("body", "simulate finetune --held-out --sequences 20 --seconds 2"),
    ("hand", "simulate quick --held-out --sequences 20 --set simulation.image_scale=0.8"),
];
/// Arguments of the evaluation of each task, beside the set's.
const EVALUATION: [(&str, &str); 2] = [("body", ""), ("hand", "--stride-ms 10")];
/// The directory of a manifest.
const MANIFEST: &str = "manifest.sha256";

/// A set that is at hand.
pub(super) struct Prepared {
    pub(super) digest: String,
    pub(super) simulated: Vec<Simulated>,
    /// The argument of `evpose eval` that takes the set, and its value, by task.
    data: Vec<(&'static str, &'static str, PathBuf)>,
    /// The set whose labels put joints elsewhere.
    labels: Option<&'static str>,
}

impl SetName {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Home => "home",
            Self::Development => "development",
            Self::Real => "real",
            Self::Foreign => "foreign",
        }
    }

    /// Simulates the set into `scratch`, or looks for it where `args` say.
    ///
    /// # Errors
    /// If it cannot be simulated, or is not there.
    pub(super) fn prepare(self, args: &BenchAccuracyArgs, scratch: &Path) -> Result<Prepared> {
        let (directory, data): (&Path, &[(&str, &str)]) = match self {
            Self::Home => return home(scratch),
            Self::Development => {
                (&args.development, &[("body", "--foreign"), ("hand", "--foreign")])
            }
            Self::Foreign if !args.open_foreign => bail!(super::CLOSED),
            Self::Foreign => (&args.foreign, &[("body", "--foreign"), ("hand", "--foreign")]),
            Self::Real => {
                let directory = args.real.as_deref();
                (
                    directory.context("real images cannot be passed on: --real DIR")?,
                    &[("body", "--data")],
                )
            }
        };
        // A missing set is an error: a record without it would look complete.
        ensure!(directory.is_dir(), "{}: no such directory", directory.display());
        Ok(Prepared {
            digest: digest::of_path(directory)?,
            simulated: Vec::new(),
            data: data.iter().map(|(task, flag)| (*task, *flag, directory.to_owned())).collect(),
            labels: (self == Self::Real).then_some("dhp19"),
        })
    }
}

fn home(scratch: &Path) -> Result<Prepared> {
    let (mut simulated, mut data, mut manifests) = (Vec::new(), Vec::new(), String::new());
    for (task, command) in HOME {
        let directory = scratch.join(task);
        let out = directory.to_string_lossy();
        // The first word is the command, which is printed with the rest but not parsed.
        let words = command.split(' ').skip(1).chain(["--out", &out]);
        evpose_cli::tasks::task_by_name(task)?.simulate(&parsed::<SimulateArgs>(words)?)?;
        let text =
            std::fs::read_to_string(directory.join(MANIFEST)).context("reading the manifest")?;
        manifests += &text;
        simulated.push(Simulated {
            task,
            simulation: format!("evpose {command}"),
            manifest: text.lines().map(str::to_owned).collect(),
        });
        data.push((task, "--data", directory));
    }
    // Of the manifests, which hold the digests of all files.
    Ok(Prepared { digest: digest::of_bytes(manifests.as_bytes()), simulated, data, labels: None })
}

impl Prepared {
    /// Arguments of `evpose eval` for a task's networks, without the checkpoint.
    pub(super) fn evaluation(&self, task: &str) -> Option<Vec<String>> {
        let (_, flag, directory) = self.data.iter().find(|(of, ..)| *of == task)?;
        let mut words = vec![(*flag).to_owned(), directory.to_string_lossy().into_owned()];
        let own = EVALUATION.iter().find(|(of, _)| *of == task).map_or("", |(_, words)| words);
        words.extend(own.split_whitespace().map(str::to_owned));
        words.extend(self.labels.iter().flat_map(|set| ["--joints", set]).map(str::to_owned));
        Some(words)
    }

    /// The command of [`Self::evaluation`], without the place of the recordings on this machine.
    pub(super) fn shown(words: &[String]) -> String {
        let shown = words.iter().enumerate().map(|(k, word)| if k == 1 { "SET" } else { word });
        std::iter::once("evpose eval").chain(shown).collect::<Vec<_>>().join(" ")
    }
}

/// Arguments of a command from their words.
///
/// # Errors
/// If it has no such arguments.
pub(super) fn parsed<'a, A: clap::Args>(words: impl IntoIterator<Item = &'a str>) -> Result<A> {
    let command = A::augment_args(clap::Command::new("evpose").no_binary_name(true));
    Ok(A::from_arg_matches(&command.try_get_matches_from(words)?)?)
}
