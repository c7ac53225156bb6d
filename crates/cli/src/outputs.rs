//! Files that a command writes.
//!
//! An argument that names one has the type [`OutputFile`], by which [`refuse_shared`] knows it: no file is written
//! twice by one command, nor written while it is read.

use std::ffi::OsString;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::builder::ValueParser;
use clap::error::ErrorKind;
use clap::{ArgMatches, Command, value_parser};
use evpose_core::{atomic_write, is_same_file};

/// Path of a file that a command writes; `-` and addresses are no files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputFile(PathBuf);

impl From<OsString> for OutputFile {
    fn from(path: OsString) -> Self {
        Self(path.into())
    }
}

impl From<&str> for OutputFile {
    fn from(path: &str) -> Self {
        Self(path.into())
    }
}

impl From<PathBuf> for OutputFile {
    fn from(path: PathBuf) -> Self {
        Self(path)
    }
}

impl Deref for OutputFile {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl AsRef<Path> for OutputFile {
    fn as_ref(&self) -> &Path {
        &self.0
    }
}

/// Writes a file through a temporary name, so that an aborted command leaves none that looks whole.
///
/// # Errors
/// If it cannot be written; the message names it.
pub fn write_file(path: &Path, content: impl AsRef<[u8]>) -> anyhow::Result<()> {
    atomic_write(path, content.as_ref()).with_context(|| format!("writing {}", path.display()))
}

/// A path among the arguments.
struct Named {
    /// The argument, as its user writes it.
    flag: String,
    path: PathBuf,
    is_output: bool,
}

/// Compares all files that the arguments of a command name, before any is opened: an output may be no other output
/// and no input, under whatever name.
///
/// # Errors
/// If two are one file; the message has both arguments.
pub fn refuse_shared(command: &Command, matches: &ArgMatches) -> Result<(), clap::Error> {
    if let Some((name, matches)) = matches.subcommand() {
        let command = command.find_subcommand(name);
        return command.map_or(Ok(()), |command| refuse_shared(command, matches));
    }
    let named = named(command, matches);
    for (index, output) in named.iter().enumerate().filter(|(_, named)| named.is_output) {
        let others = named.iter().enumerate().filter(|(other, named)| {
            // Two outputs are compared once.
            *other != index && (!named.is_output || *other > index)
        });
        for (_, other) in others {
            if are_one(output, other) {
                let message = format!(
                    "{} and {} are one file, {}: name another",
                    output.flag,
                    other.flag,
                    other.path.display()
                );
                return Err(command.clone().error(ErrorKind::ArgumentConflict, message));
            }
        }
    }
    Ok(())
}

/// Whether writing `output` would touch `other`.
fn are_one(output: &Named, other: &Named) -> bool {
    let standard = Path::new("-");
    if output.path == standard && other.path == standard {
        // As an input it is another stream.
        return other.is_output;
    }
    let [a, b] = [output, other].map(Named::place);
    // Any word may be a path: one that leads to no file names nothing that could be lost.
    if !other.is_output && !b.exists() {
        return false;
    }
    // Folders hold files of both kinds.
    !a.is_dir() && is_same_file(&a, &b)
}

impl Named {
    /// The path, of `-` that of the file that the stream is redirected to or from.
    fn place(&self) -> PathBuf {
        let stream = if self.is_output { "/dev/stdout" } else { "/dev/stdin" };
        if self.path == Path::new("-") { stream.into() } else { self.path.clone() }
    }
}

/// Files that are read where their folder is named: logs of YARP, arrays of EVIMO2, the best network of a run.
const READ_OF_FOLDERS: [&str; 6] = [
    "data.log",
    "binaryevents.log",
    "dataset_events_t.npy",
    "dataset_events_xy.npy",
    "dataset_events_p.npy",
    "best.bpk",
];
/// Endings of the files of a bag of ROS 2, which its `metadata.yaml` names.
const OF_BAGS: [&str; 4] = [".mcap", ".db3", ".zstd", "metadata.yaml"];
/// Files that are written where their folder is named: logs of YARP. Masks have names of their own.
const WRITTEN_TO_FOLDERS: [&str; 2] = ["data.log", "info.log"];

/// The files that stand for a folder, as an input or an output.
fn files_of_folder(folder: &Path, is_output: bool) -> Vec<PathBuf> {
    let is_bag = folder.join("metadata.yaml").is_file();
    let is_meant = |name: &str| {
        if is_output {
            WRITTEN_TO_FOLDERS.contains(&name) || is_mask(name)
        } else {
            READ_OF_FOLDERS.contains(&name)
                || (is_bag && OF_BAGS.iter().any(|end| name.ends_with(end)))
        }
    };
    let files = folder.read_dir().into_iter().flatten().flatten();
    files
        .filter(|file| file.file_name().to_str().is_some_and(is_meant))
        .map(|file| file.path())
        .collect()
}

/// Whether a name is one of those that `clean --masks` gives: `1-hot.toml`.
fn is_mask(name: &str) -> bool {
    let number = name.strip_suffix(".toml").and_then(|stem| stem.split_once('-'));
    number.is_some_and(|(number, _)| number.parse::<u32>().is_ok())
}

/// All values that may be paths, and for folders the files in them that are meant. Of inputs such as `mask:file=hot.toml,outside=clip`, what is behind each sign, too.
fn named(command: &Command, matches: &ArgMatches) -> Vec<Named> {
    let is = |parser: &ValueParser, of: ValueParser| parser.type_id() == of.type_id();
    let mut named = Vec::new();
    for argument in command.get_arguments().filter(|argument| argument.get_action().takes_values())
    {
        let id = argument.get_id().as_str();
        let is_output = is(argument.get_value_parser(), value_parser!(OutputFile).into());
        let flag = argument.get_long().map_or(id.to_uppercase(), |long| format!("--{long}"));
        for value in matches.get_raw(id).into_iter().flatten() {
            let text = value.to_string_lossy();
            let parts = text.split(',').filter_map(|part| part.split_once('='));
            // An output is one path, whatever signs its name has.
            let behind = parts.map(|(_, path)| path.into()).filter(|_| !is_output);
            let paths = std::iter::once(PathBuf::from(value)).chain(behind);
            for path in paths {
                let inside = files_of_folder(&path, is_output);
                let paths = std::iter::once(path).chain(inside);
                named.extend(paths.map(|path| Named { flag: flag.clone(), path, is_output }));
            }
        }
    }
    named
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Program {
        #[command(subcommand)]
        _command: Sub,
    }

    #[derive(clap::Subcommand)]
    enum Sub {
        Live {
            input: PathBuf,
            #[arg(long)]
            with: Vec<String>,
            #[arg(long)]
            json: Option<OutputFile>,
            #[arg(long)]
            csv: Option<OutputFile>,
        },
    }

    fn checked(words: &[&str]) -> Result<(), String> {
        let command = Program::command();
        let words = ["evpose", "live"].iter().chain(words);
        let matches = command.clone().try_get_matches_from(words).expect("known arguments");
        refuse_shared(&command, &matches).map_err(|error| error.to_string())
    }

    #[test]
    fn folders_stand_for_the_files_in_them() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name).to_str().expect("text").to_owned();
        for name in [
            "cam/data.log",
            "evimo/dataset_events_p.npy",
            "run/best.bpk",
            "run/report.json",
            "bag/metadata.yaml",
            "bag/bag_0.db3",
            "masks/1-hot.toml",
        ] {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(path, "").expect("written");
        }
        let (cam, bag, run, masks) = (at("cam"), at("bag"), at("run"), at("masks"));
        let mask = format!("mask:file={}", at("masks/1-hot.toml"));
        let cases: [&[&str]; 7] = [
            &[&cam, "--json", &cam],
            &[&cam, "--json", &at("cam/data.log")],
            &[&at("cam/data.log"), "--json", &cam],
            &[&at("evimo"), "--csv", &at("evimo/dataset_events_p.npy")],
            &[&run, "--csv", &at("run/best.bpk")],
            &[&bag, "--csv", &at("bag/bag_0.db3")],
            &[&bag, "--with", &mask, "--json", &masks],
        ];
        for words in cases {
            let message = checked(words).expect_err("shared");
            assert!(message.contains("are one file"), "{message}");
        }
        // Files beside those that are read are no inputs, and a folder may take what it has no file of.
        assert_eq!(checked(&[&run, "--json", &at("run/report.json"), "--csv", &bag]), Ok(()));
        assert_eq!(checked(&[&run, "--json", &run]), Ok(()));
    }

    #[test]
    fn an_output_is_no_input_and_no_other_output() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name).to_str().expect("text").to_owned();
        for name in ["a", "mask"] {
            std::fs::write(at(name), "").expect("written");
        }
        std::fs::hard_link(at("a"), at("b")).expect("linked");
        let (a, b, new, mask) = (at("a"), at("b"), at("new"), at("mask"));
        let again = at("./new");
        let with = format!("mask:file={mask}");
        let dated = at("date=1");
        std::fs::write(&dated, "").expect("written");
        let later = format!("{with},outside=clip");
        let cases: [(&[&str], &[&str]); 6] = [
            (&[&a, "--json", &a], &["--json", "INPUT"]),
            (&[&dated, "--json", &dated], &["--json", "INPUT"]),
            (&[&a, "--with", &later, "--json", &mask], &["--json", "--with"]),
            (&[&a, "--csv", &b], &["--csv", "INPUT"]),
            (&[&a, "--with", &with, "--json", &mask], &["--json", "--with"]),
            (&[&a, "--json", &new, "--csv", &again], &["--json", "--csv"]),
        ];
        for (words, flags) in cases {
            let message = checked(words).expect_err("shared");
            assert!(flags.iter().all(|flag| message.contains(flag)), "{message}");
        }
        assert!(checked(&[&a, "--json", "-", "--csv", "-"]).is_err());
        assert_eq!(checked(&["-", "--json", "-"]), Ok(()));
        // A name that is no path, such as that of a representation.
        assert_eq!(checked(&[&a, "--with", "lnes", "--json", "lnes"]), Ok(()));
        assert_eq!(checked(&[&a, "--with", &with, "--json", &new, "--csv", &at("other")]), Ok(()));
        assert_eq!(checked(&[&a, "--json", "/dev/null", "--csv", "/dev/null"]), Ok(()));
    }
}
