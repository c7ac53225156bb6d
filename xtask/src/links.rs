//! `cargo xtask links`: links of Markdown pages lead to files and headings of the repository.
//!
//! Nothing is fetched: addresses of other sites are not checked, those of this repository are files of it.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::{files, named_paths};

/// The repository on the web, in pages that are also shown elsewhere.
const ADDRESSES: [&str; 3] = [
    "https://github.com/evpose/evpose/blob/HEAD/",
    "https://github.com/evpose/evpose/tree/HEAD/",
    "https://raw.githubusercontent.com/evpose/evpose/HEAD/",
];
/// Pages whose code spans name paths and registries.
const MAPS: [&str; 2] = ["ARCHITECTURE.md", "docs/decisions/"];
/// Contents of the book, which has every page below `docs`.
const SUMMARY: &str = "docs/SUMMARY.md";

/// Checks all Markdown pages.
///
/// # Errors
/// If a link leads nowhere, a map names a path that is not there, or the book lacks a page.
pub(crate) fn run(say: fn(&str)) -> Result<()> {
    let is_page = |path: &String| path.ends_with(".md") && Path::new(path).is_file();
    let pages: Vec<String> = files::tracked()?.into_iter().filter(is_page).collect();
    let (mut count, mut in_book, mut faults) = (0, BTreeSet::new(), Vec::new());
    for page in &pages {
        let text = std::fs::read_to_string(page).with_context(|| format!("reading {page}"))?;
        for (line, target) in links(&text) {
            count += 1;
            let file = file_of(page, target);
            faults.extend(fault(&file, target).map(|fault| format!("{page}:{line}: {fault}")));
            // The pages of the book are those that its summary links to.
            in_book.extend((page == SUMMARY).then_some(file));
        }
        if MAPS.iter().any(|map| page.starts_with(map)) {
            let absent = named_paths::absent(Path::new(""), &text);
            faults.extend(absent.iter().map(|absent| format!("{page}:{absent}")));
        }
    }
    let is_missing = |page: &&String| page.starts_with("docs/") && !in_book.contains(*page);
    let missing = pages.iter().filter(is_missing).filter(|page| *page != SUMMARY);
    faults.extend(missing.map(|page| format!("{SUMMARY}: no {page}")));
    ensure!(faults.is_empty(), "{}", faults.join("\n"));
    say(&format!("{count} links in {} pages", pages.len()));
    Ok(())
}

/// Lines of prose, each with its position from 1: not those of code blocks.
pub(crate) fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut is_code = false;
    (1..).zip(text.lines()).filter(move |(_, line)| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    })
}

/// Targets of links to this repository, with their lines.
fn links(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let targets = prose(text).flat_map(|(number, line)| {
        let ends = line.split("](").skip(1).filter_map(|behind| behind.split_once(')'));
        ends.map(move |(target, _)| (number, target))
    });
    // Any other target with a colon leads out of the repository.
    targets.filter(|(_, target)| {
        ADDRESSES.iter().any(|address| target.starts_with(address)) || !target.contains(':')
    })
}

fn file_of(page: &str, target: &str) -> String {
    let path = target.split('#').next().unwrap_or_default();
    if let Some(path) = ADDRESSES.iter().find_map(|address| path.strip_prefix(address)) {
        return path.to_owned();
    }
    let mut parts: Vec<&str> = page.split('/').collect();
    // A heading alone is one of the page, while a path begins in the folder of the page.
    parts.truncate(parts.len() - usize::from(!path.is_empty()));
    for part in path.split('/').filter(|part| !part.is_empty() && *part != ".") {
        if part == ".." { parts.truncate(parts.len().saturating_sub(1)) } else { parts.push(part) }
    }
    parts.join("/")
}

/// The fault of a link, if it has one.
fn fault(file: &str, target: &str) -> Option<String> {
    if !Path::new(file).exists() {
        return Some(format!("{target}: no such file"));
    }
    let (_, anchor) = target.split_once('#').filter(|_| file.ends_with(".md"))?;
    let text = std::fs::read_to_string(file).ok()?;
    let has_it = prose(&text).any(|(_, line)| line.starts_with('#') && anchor_of(line) == anchor);
    (!has_it).then(|| format!("{target}: no such heading"))
}

/// The anchor of a heading, as GitHub and mdBook make it.
fn anchor_of(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
    text.chars().filter(|c| c.is_alphanumeric() || "-_".contains(*c)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_of_prose_lead_from_their_page_to_files_and_headings() {
        let text = "[a](b.md#c) [d](https://e.org)\n```\n[f](g.md)\n```\n![h](../i.png), [j](#k)\n";
        let targets: Vec<_> = links(text).collect();
        assert_eq!(targets, [(1, "b.md#c"), (5, "../i.png"), (5, "#k")]);
        let files = targets.iter().map(|(_, target)| file_of("docs/guide/a.md", target));
        let expected = ["docs/guide/b.md", "docs/i.png", "docs/guide/a.md"];
        assert_eq!(files.collect::<Vec<_>>(), expected);
        assert_eq!(file_of("a.md", &format!("{}docs/x.md#y", ADDRESSES[0])), "docs/x.md");
        assert_eq!(anchor_of("## 8. The verdict, as `data`"), "8-the-verdict-as-data");
        assert!(fault("none.md", "none.md").is_some() && fault("Cargo.toml", "#a").is_none());
    }
}
