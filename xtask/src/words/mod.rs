//! `cargo xtask words`: refuses words that the glossary replaces.
//!
//! Identifiers are split into their parts (`judge_frames`, `JudgeFrames` → `judge frames`), so that
//! one pattern covers names, comments, help texts and Markdown.

mod allowed;
mod list;
mod scan;
mod split;

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::files;
use scan::{Finding, Scanner};

/// Prints how many refused words each crate holds, and each file of the crates or paths that are
/// named; with `--list` every use.
///
/// # Errors
/// If a refused word is found, or a file cannot be read.
pub(crate) fn run(args: &[String], say: fn(&str)) -> Result<()> {
    let is_listing = args.iter().any(|arg| arg == "--list");
    let within: Vec<&String> = args.iter().filter(|arg| !arg.starts_with("--")).collect();
    let is_chosen =
        |path: &str| within.is_empty() || within.iter().any(|part| is_within(path, part));
    let scanner = Scanner::new()?;
    let mut findings = Vec::new();
    let mut definitions = BTreeMap::<String, Vec<(String, usize)>>::new();
    for path in files::tracked()?.into_iter().filter(|path| is_text(path)) {
        let text = std::fs::read_to_string(&path).with_context(|| format!("reading {path}"))?;
        if is_chosen(&path) {
            findings.extend(scanner.scan(&path, &text));
        }
        // Of every file: the other place of a name may lie outside of those chosen.
        for (index, line) in text.lines().enumerate() {
            if let Some(name) = scanner.single_name(line) {
                definitions.entry(name.to_owned()).or_default().push((path.clone(), index + 1));
            }
        }
    }
    findings.extend(repeated(definitions).into_iter().filter(|finding| is_chosen(&finding.path)));
    if is_listing {
        for Finding { path, line, word, instead } in &findings {
            say(&format!("{path}:{line}: `{word}`: {instead}"));
        }
    }
    summarize(&findings, !within.is_empty(), say);
    if findings.is_empty() {
        return Ok(());
    }
    bail!("words of docs/glossary.md's left column; `cargo xtask words CRATE --list` shows each");
}

/// Public types and constants that share their name with one of another meaning.
fn repeated(definitions: BTreeMap<String, Vec<(String, usize)>>) -> Vec<Finding> {
    let repeated = definitions.into_iter().filter(|(_, places)| places.len() > 1);
    repeated
        .flat_map(|(name, places)| {
            places.into_iter().map(move |(path, line)| Finding {
                path,
                line,
                word: name.clone(),
                instead: "one public meaning per name over the workspace",
            })
        })
        .collect()
}

fn summarize(findings: &[Finding], with_files: bool, say: fn(&str)) {
    let mut by_place = BTreeMap::<String, usize>::new();
    for finding in findings {
        if with_files {
            *by_place.entry(finding.path.clone()).or_default() += 1;
        } else {
            *by_place.entry(files::place(&finding.path)).or_default() += 1;
        }
    }
    for (place, count) in &by_place {
        say(&format!("{count:>6}  {place}"));
    }
    say(&format!("{:>6}  refused words in all", findings.len()));
}

/// Whether a path lies in a folder, or in a crate given by its name.
fn is_within(path: &str, part: &str) -> bool {
    let part = part.trim_end_matches('/');
    let name = part.strip_prefix("evpose-").unwrap_or(part);
    let is_below = |folder: &str| {
        path.strip_prefix(folder).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    };
    is_below(part) || is_below(&format!("crates/{name}"))
}

/// Sources, documentation and configs; the glossary and the word list have to name what they
/// refuse.
fn is_text(path: &str) -> bool {
    // Results of the benchmark are pages of the program that was measured.
    const OWN: [&str; 3] = ["docs/glossary.md", "xtask/src/words/", "benches/gap/plan-"];
    let is_known = ["rs", "md", "toml", "js", "html"]
        .iter()
        .any(|known| Path::new(path).extension().is_some_and(|extension| extension == *known));
    is_known && !OWN.iter().any(|own| path.starts_with(own)) && Path::new(path).is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crates_are_chosen_by_name_or_path() {
        assert!(is_within("crates/io/src/lib.rs", "io"));
        assert!(is_within("crates/io/src/lib.rs", "evpose-io"));
        assert!(is_within("crates/io/src/lib.rs", "crates/io/src/"));
        assert!(!is_within("crates/ios/src/lib.rs", "io"));
    }

    #[test]
    fn a_name_is_repeated_from_its_second_definition_on() {
        let place = |path: &str| (path.to_owned(), 1);
        let of = |paths: &[&str]| {
            BTreeMap::from([("Stage".to_owned(), paths.iter().map(|path| place(path)).collect())])
        };
        assert_eq!(repeated(of(&["a.rs"])).len(), 0);
        assert_eq!(repeated(of(&["a.rs", "b.rs"])).len(), 2);
    }
}
