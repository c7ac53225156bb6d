//! Refused words of one file.

use anyhow::{Context, Result};
use regex::Regex;

use super::allowed::ALLOWED;
use super::list::{Form, SINGLE_NAMES, WORDS, Word};
use super::split;

/// A use of a refused word.
pub(super) struct Finding {
    pub(super) path: String,
    pub(super) line: usize,
    pub(super) word: String,
    pub(super) instead: &'static str,
}

/// The word list, compiled.
pub(super) struct Scanner {
    patterns: Vec<(Regex, Option<Regex>, &'static Word)>,
    definition: Regex,
}

impl Scanner {
    /// # Errors
    /// If a pattern of the list is no regular expression.
    pub(super) fn new() -> Result<Self> {
        let compile = |pattern: &'static str| Regex::new(pattern).context(pattern);
        let patterns = WORDS
            .iter()
            .map(|word| {
                let except = Some(word.except).filter(|except| !except.is_empty());
                Ok((compile(word.pattern)?, except.map(compile).transpose()?, word))
            })
            .collect::<Result<_>>()?;
        let definition = Regex::new(&format!(
            r"^\s*pub (struct|enum|trait|type|const) ({})\b",
            SINGLE_NAMES.join("|")
        ))?;
        Ok(Self { patterns, definition })
    }

    /// Refused words of a file, line by line.
    pub(super) fn scan(&self, path: &str, text: &str) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut was_doc = false;
        for (index, line) in text.lines().enumerate() {
            let split = split::spaced(line);
            let doc = doc_text(line);
            // Only the first line of a paragraph is its opening.
            let opening = doc.filter(|_| !was_doc).map(str::to_lowercase);
            was_doc = doc.is_some_and(|doc| !doc.trim().is_empty());
            if is_alias(line) {
                continue;
            }
            for (pattern, except, word) in &self.patterns {
                if is_allowed(path, line, word) {
                    continue;
                }
                let Some(text) = (match word.form {
                    Form::Split => Some(split.as_str()),
                    Form::Source => Some(line),
                    Form::DocOpening => opening.as_deref(),
                }) else {
                    continue;
                };
                findings.extend(hits(pattern, except.as_ref(), text).map(|hit| Finding {
                    path: path.to_owned(),
                    line: index + 1,
                    word: hit.trim().to_owned(),
                    instead: word.instead,
                }));
            }
        }
        findings
    }

    /// The name among [`SINGLE_NAMES`] that a line defines for the public.
    pub(super) fn single_name<'t>(&self, line: &'t str) -> Option<&'t str> {
        self.definition.captures(line)?.get(2).map(|name| name.as_str())
    }
}

/// Matches that are no part of an exception.
fn hits<'t>(
    pattern: &Regex,
    except: Option<&Regex>,
    text: &'t str,
) -> impl Iterator<Item = &'t str> {
    let right: Vec<_> = except.map_or_else(Vec::new, |except| {
        except.find_iter(text).map(|right| right.range()).collect()
    });
    let found: Vec<_> = pattern.find_iter(text).collect();
    found.into_iter().filter_map(move |hit| {
        // An exception may be longer or shorter than the hit, so any overlap excuses it.
        let is_right = right.iter().any(|r| r.start < hit.end() && hit.start() < r.end);
        (!is_right).then(|| hit.as_str())
    })
}

fn doc_text(line: &str) -> Option<&str> {
    let line = line.trim_start();
    let text = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))?;
    Some(text.strip_prefix(' ').unwrap_or(text))
}

/// Whether a line declares an alias: the spelling of a file that stays as it is.
fn is_alias(line: &str) -> bool {
    line.contains("alias")
}

fn is_allowed(path: &str, line: &str, word: &Word) -> bool {
    let begins = |beginnings: &[&str]| beginnings.iter().any(|begin| path.starts_with(begin));
    let is_elsewhere = !word.paths.is_empty() && !begins(word.paths);
    is_elsewhere
        || ALLOWED.iter().any(|exception| {
            exception.word == word.name
                && path.starts_with(exception.path)
                && line.contains(exception.line)
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words_of(text: &str) -> Vec<String> {
        words_in("crates/live/src/none.rs", text)
    }

    fn words_in(path: &str, text: &str) -> Vec<String> {
        let scanner = Scanner::new().unwrap();
        scanner.scan(path, text).into_iter().map(|finding| finding.word).collect()
    }

    #[test]
    fn parts_of_identifiers_are_words() {
        assert_eq!(words_of("fn judge_frames() {}"), ["judge"]);
        assert_eq!(words_of("struct HowFar;"), ["HowFar"]);
        assert_eq!(words_of("let kernel = misjudgea();"), Vec::<String>::new());
    }

    #[test]
    fn documentation_does_not_begin_with_what() {
        assert_eq!(words_of("/// What a pixel stores."), ["what"]);
        assert_eq!(words_of("/// State of a pixel,\n/// which it stores."), Vec::<String>::new());
        assert_eq!(words_of("/// A state.\n///\n/// What it is for."), ["what"]);
    }

    #[test]
    fn right_uses_pass() {
        let none = Vec::<String>::new();
        assert_eq!(words_of("// Random numbers, and different numbers of threads."), none);
        assert_eq!(words_of("// The 12 numbers of a hand."), ["numbers of a hand", "numbers"]);
        assert_eq!(words_of("let time_surface = TimeSurface::new();"), none);
        assert_eq!(words_of("#[serde(alias = \"deaf_s\")]"), none);
        assert_eq!(words_in("crates/body/src/face.rs", "let eye = 1;"), none);
    }

    #[test]
    fn every_exception_is_of_a_word_of_the_list() {
        for exception in ALLOWED {
            assert!(WORDS.iter().any(|word| word.name == exception.word), "{}", exception.word);
        }
    }
}
