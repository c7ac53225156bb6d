//! `gapbench score DIR`: scores and tables of stored results, from their rows and their opened
//! labels, without recordings.
//!
//! A folder of `DIR` holds `results.jsonl` beside `labels.jsonl` (cases of a plan) or `truths.jsonl`
//! (recordings of other programs). A pool holds derived files alone: its `scores.json` lists the
//! folders beside it that it is of. Pages of `DIR` show derived files between
//! `<!-- generated: FILE -->` and `<!-- end -->`.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

use super::naming::RESULTS;
use super::opened::Opened;
use super::own::{self, OwnRow};
use super::row::Row;
use super::truth::Truth;
use super::{calibrate, jsonl, outside, score, table};
use crate::files::{self, SCORES, TABLE};
use crate::terminal::say;

/// A line a case, with its opened label.
pub(super) const LABELS: &str = "labels.jsonl";
/// Answer key of recordings of other programs.
const KEY: &str = "outside-key.md";
/// Marks of a derived file in a page.
const BEGIN: &str = "<!-- generated: ";
const END: &str = "<!-- end -->";

#[derive(Deserialize)]
struct Pool {
    folders: Vec<String>,
}

/// Names of folders as a pool has them; none for the folder `out` itself.
pub(super) fn names(dirs: &[PathBuf], out: &Path) -> Vec<String> {
    if dirs.iter().any(|dir| dir == out) {
        return Vec::new();
    }
    let name = |dir: &PathBuf| dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
    dirs.iter().map(name).collect()
}

/// Cases of folders with stored labels, in the order of their names, and runs of our own model.
pub(super) fn cases(dirs: &[PathBuf]) -> Result<(Vec<Opened>, Vec<OwnRow>)> {
    let (mut opened, mut own) = (Vec::new(), Vec::new());
    for dir in dirs {
        let labels = dir.join(LABELS);
        ensure!(labels.is_file(), "{}: not there; give --plan to open labels", labels.display());
        let truths: Vec<Truth> = jsonl::read(&labels)?;
        let mut truths: HashMap<String, Truth> =
            truths.into_iter().map(|truth| (truth.id.clone(), truth)).collect();
        for row in jsonl::read::<Row>(&dir.join(RESULTS))? {
            // Each label is used up, so that a case whose row is there twice is an error.
            let truth = truths.remove(&row.id);
            let truth =
                truth.with_context(|| format!("{}: no line of {}", labels.display(), row.id))?;
            opened.push(Opened { truth, row });
        }
        if dir.join(own::NAME).is_file() {
            own.extend(own::read(&dir.join(own::NAME))?);
        }
    }
    jsonl::sort(&mut opened, |case| &case.row.id)?;
    let tier = opened.first().map(|case| case.truth.plan.tier);
    // Tiers have targets of their own.
    ensure!(opened.iter().all(|case| Some(case.truth.plan.tier) == tier), "plans of two tiers");
    Ok((opened, own))
}

pub(super) fn lines(opened: &[Opened]) -> Result<[(&'static str, String); 2]> {
    let rows: Result<String> = opened.iter().map(|case| jsonl::line(&case.row)).collect();
    let labels: Result<String> = opened.iter().map(|case| jsonl::line(&case.truth)).collect();
    Ok([(RESULTS, rows?), (LABELS, labels?)])
}

/// Folders of a directory that hold results of a plan, of other programs, or of a pool of either;
/// by their paths, with the folders that each is of.
fn folders(root: &Path) -> Result<Vec<(PathBuf, Vec<PathBuf>)>> {
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(root).with_context(|| format!("reading {}", root.display()))? {
        let dir = entry.with_context(|| format!("reading {}", root.display()))?.path();
        let of = if dir.join(RESULTS).is_file() {
            // A folder with rows is its own source; a pool has only the names of its folders.
            vec![dir.clone()]
        } else if dir.join(SCORES).is_file() {
            let path = dir.join(SCORES);
            let text =
                std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            let pool: Pool =
                serde_json::from_str(&text).with_context(|| path.display().to_string())?;
            pool.folders.iter().map(|name| root.join(name)).collect()
        } else {
            continue;
        };
        folders.push((dir, of));
    }
    folders.sort();
    Ok(folders)
}

/// Folders that hold rows: of plans, and of other programs.
pub(super) fn sources(root: &Path) -> Result<[Vec<PathBuf>; 2]> {
    let own = folders(root)?.into_iter().filter(|(dir, of)| of.as_slice() == [dir.clone()]);
    let (plans, others) = own.map(|(dir, _)| dir).partition(|dir| dir.join(LABELS).is_file());
    Ok([plans, others])
}

pub(super) fn derived(root: &Path) -> Result<BTreeMap<PathBuf, String>> {
    let mut all = BTreeMap::new();
    for (dir, of) in folders(root)? {
        if of.iter().all(|dir| dir.join(LABELS).is_file()) {
            let (opened, own) = cases(&of)?;
            let scores = score::score_cases(&opened, own::summary(&own), names(&of, &dir));
            all.insert(dir.join(SCORES), files::json(&scores)?);
            all.insert(dir.join(TABLE), table::markdown(&scores));
        } else {
            for (name, text) in outside::derived(&of, names(&of, &dir))? {
                all.insert(dir.join(name), text);
            }
        }
    }
    all.insert(root.join(KEY), outside::key());
    all.insert(root.join(calibrate::NAME), calibrate::Fit::of_stored(root)?.markdown());
    // Pages last: they show what was derived above.
    for entry in std::fs::read_dir(root).with_context(|| format!("reading {}", root.display()))? {
        let path = entry.with_context(|| format!("reading {}", root.display()))?.path();
        // Derived pages are whole; others have marked parts.
        if path.extension().is_some_and(|end| end == "md") && !all.contains_key(&path) {
            let text =
                std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            let text =
                with_blocks(&text, root, &all).with_context(|| path.display().to_string())?;
            all.insert(path, text);
        }
    }
    Ok(all)
}

/// A page with the derived files that it shows.
fn with_blocks(text: &str, root: &Path, derived: &BTreeMap<PathBuf, String>) -> Result<String> {
    let mut page = String::new();
    let mut is_inside = false;
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix(BEGIN) {
            let name = rest.trim_end_matches("-->").trim();
            let Some(shown) = derived.get(&root.join(name)) else { bail!("{name} is not derived") };
            page += &format!("{line}\n\n{}\n\n{END}\n", shown.trim_end());
            is_inside = true;
        } else if line == END && is_inside {
            // The end was written with the new content; the old one is skipped.
            is_inside = false;
        } else if !is_inside {
            page += &format!("{line}\n");
        }
    }
    // Or the rest of the page would be lost.
    ensure!(!is_inside, "a generated part without {END}");
    Ok(page)
}

/// Writes every derived file of a directory.
pub(super) fn again(root: &Path) -> Result<()> {
    for (path, text) in derived(root)? {
        let is_same = std::fs::read_to_string(&path).is_ok_and(|old| old == text);
        if !is_same {
            evpose_core::atomic_write(&path, text.as_bytes())
                .with_context(|| format!("writing {}", path.display()))?;
            say(format!("written   {}", path.display()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
