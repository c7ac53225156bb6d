//! Files that a command writes.
//!
//! An argument that names one has the type [`OutputFile`], by which [`refuse_shared`] knows it: no file is written
//! twice by one command, nor written while it is read.

use std::ffi::OsString;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use clap::builder::ValueParser;
use clap::error::ErrorKind;
use clap::{ArgMatches, Command, value_parser};
use evpose_core::is_same_file;

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

/// All values that may be paths. Of inputs such as `mask:file=hot.toml,outside=clip`, what is behind each sign, too.
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
            let behind = parts.map(|(_, path)| path.into()).filter(|_| !is_output);
            let paths = std::iter::once(value.into()).chain(behind);
            named.extend(paths.map(|path| Named { flag: flag.clone(), path, is_output }));
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
