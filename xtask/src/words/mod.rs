//! `cargo xtask words`: refuses words that the glossary replaces.
//!
//! Identifiers are split into their parts (`judge_frames`, `JudgeFrames` → `judge frames`), so that one
//! pattern covers names, comments, help texts and Markdown.

mod allowed;
mod list;
mod split;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};
use regex::Regex;

use allowed::ALLOWED;
use list::WORDS;

/// A use of a refused word.
struct Finding {
    path: String,
    line: usize,
    word: String,
    instead: &'static str,
}

/// Prints how many refused words each crate holds, with `--list` every one of them. Arguments that are no
/// flags restrict the search to paths that contain one of them.
///
/// # Errors
/// If a refused word is found, or a file cannot be read.
pub(crate) fn run(args: &[String], say: fn(&str)) -> Result<()> {
    let is_listing = args.iter().any(|arg| arg == "--list");
    let within: Vec<&String> = args.iter().filter(|arg| !arg.starts_with("--")).collect();
    let patterns = patterns()?;
    let mut findings = Vec::new();
    for path in tracked_files()? {
        if is_text(&path) && (within.is_empty() || within.iter().any(|part| path.contains(*part))) {
            let text = std::fs::read_to_string(&path).with_context(|| format!("reading {path}"))?;
            scan(&path, &text, &patterns, &mut findings);
        }
    }
    if is_listing {
        for Finding { path, line, word, instead } in &findings {
            say(&format!("{path}:{line}: `{word}`: {instead}"));
        }
    }
    let mut by_crate = BTreeMap::<String, usize>::new();
    for finding in &findings {
        *by_crate.entry(place(&finding.path)).or_default() += 1;
    }
    for (place, count) in &by_crate {
        say(&format!("{count:>6}  {place}"));
    }
    say(&format!("{:>6}  refused words in all", findings.len()));
    if findings.is_empty() {
        return Ok(());
    }
    bail!("words of docs/glossary.md's left column; `cargo xtask words --list` shows each");
}

fn patterns() -> Result<Vec<(Regex, &'static list::Word)>> {
    let compile = |word: &'static list::Word| {
        let pattern = Regex::new(word.pattern).with_context(|| word.pattern.to_owned())?;
        Ok((pattern, word))
    };
    WORDS.iter().map(compile).collect()
}

/// Adds the refused words of a file.
fn scan(
    path: &str,
    text: &str,
    patterns: &[(Regex, &'static list::Word)],
    findings: &mut Vec<Finding>,
) {
    for (index, line) in text.lines().enumerate() {
        let spaced = split::spaced(line);
        for (pattern, word) in patterns {
            for hit in pattern.find_iter(&spaced) {
                if !is_allowed(path, line, word.name) {
                    findings.push(Finding {
                        path: path.to_owned(),
                        line: index + 1,
                        word: hit.as_str().trim().to_owned(),
                        instead: word.instead,
                    });
                }
            }
        }
    }
}

fn is_allowed(path: &str, line: &str, word: &str) -> bool {
    ALLOWED.iter().any(|exception| {
        exception.word == word && path.starts_with(exception.path) && line.contains(exception.line)
    })
}

fn tracked_files() -> Result<Vec<String>> {
    let output = Command::new("git").args(["ls-files"]).output().context("running git")?;
    Ok(String::from_utf8(output.stdout)?.lines().map(str::to_owned).collect())
}

/// Sources, documentation and configs; the glossary and the word list have to name what they refuse, and
/// what the change log says of earlier versions is history.
fn is_text(path: &str) -> bool {
    const OWN: [&str; 3] = ["docs/glossary.md", "xtask/src/words/", "CHANGELOG.md"];
    let is_known = ["rs", "md", "toml", "js", "html"]
        .iter()
        .any(|known| Path::new(path).extension().is_some_and(|extension| extension == *known));
    is_known && !OWN.iter().any(|own| path.starts_with(own)) && Path::new(path).is_file()
}

/// The crate of a file, or its top folder.
fn place(path: &str) -> String {
    let depth = if path.starts_with("crates/") { 2 } else { 1 };
    path.split('/').take(depth).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words_of(line: &str) -> Vec<String> {
        let mut findings = Vec::new();
        let Ok(patterns) = patterns() else { return Vec::new() };
        scan("crates/none.rs", line, &patterns, &mut findings);
        findings.into_iter().map(|finding| finding.word).collect()
    }

    #[test]
    fn parts_of_identifiers_are_words() {
        assert_eq!(words_of("fn judge_frames() {}"), ["judge"]);
        assert_eq!(words_of("struct HowFar;"), ["how far"]);
        assert_eq!(words_of("let kernel = prejudge();"), Vec::<String>::new());
    }

    #[test]
    fn documentation_does_not_begin_with_what() {
        assert_eq!(words_of("/// What a pixel keeps."), ["/// what"]);
        assert_eq!(words_of("/// State of a pixel: what it keeps."), Vec::<String>::new());
    }

    #[test]
    fn every_exception_is_of_a_word_of_the_list() {
        for exception in ALLOWED {
            assert!(WORDS.iter().any(|word| word.name == exception.word), "{}", exception.word);
        }
    }
}
