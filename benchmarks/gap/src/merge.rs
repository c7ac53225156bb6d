//! Rows of all parts of a plan, each case once.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
use gapbench_pixel::Case;

use super::jsonl;
use super::naming::RESULTS;
use super::own::{self, OwnRow};
use super::part::Part;
use super::row::Row;

#[derive(Debug)]
pub(super) struct Merged {
    /// In the order of the names of cases.
    pub(super) rows: Vec<Row>,
    /// Recordings of our own model.
    pub(super) own: Vec<OwnRow>,
}

/// Reads directories. All cases that they are to hold must be there, unless `is_partial`.
pub(super) fn merge(dirs: &[PathBuf], cases: &[Case], is_partial: bool) -> Result<Merged> {
    let (mut files, mut own) = (Vec::new(), Vec::new());
    for dir in dirs {
        let (results, of_own) = (dir.join(RESULTS), dir.join(own::NAME));
        ensure!(
            results.is_file() || of_own.is_file(),
            "{}: neither {RESULTS} nor {}; is this a directory of `gapbench run`?",
            dir.display(),
            own::NAME
        );
        if of_own.is_file() {
            own.extend(own::read(&of_own)?);
        }
        if results.is_file() {
            if !is_partial {
                all_done(dir, &results)?;
            }
            files.push(results);
        }
    }
    // Sets are few: comparing all with all is the shortest way.
    let twice = own.iter().enumerate().find(|(i, row)| own[..*i].iter().any(|o| o.set == row.set));
    if let Some((_, row)) = twice {
        bail!("set {} of our own model is there twice; leave one directory out", row.set);
    }
    Ok(Merged { rows: rows(&files, cases)?, own })
}

/// Reads files of results. A case that is not of the plan, or there twice, is an error.
pub(super) fn rows(files: &[PathBuf], cases: &[Case]) -> Result<Vec<Row>> {
    let known: HashSet<&str> = cases.iter().map(|case| case.id.as_str()).collect();
    let mut from: HashMap<String, &Path> = HashMap::new();
    let mut all = Vec::new();
    for file in files {
        for row in jsonl::read::<Row>(file)? {
            ensure!(
                known.contains(row.id.as_str()),
                "{}: case {} is not of this plan; is --plan right?",
                file.display(),
                row.id
            );
            if let Some(other) = from.insert(row.id.clone(), file) {
                bail!(
                    "case {} is in {} and in {}; leave one of them out",
                    row.id,
                    other.display(),
                    file.display()
                );
            }
            all.push(row);
        }
    }
    // By case, not by file: the table does not depend on how cases were spread over shards.
    all.sort_by(|a, b| a.id.cmp(&b.id));
    Ok(all)
}

/// Labels stay closed as long as cases are open.
fn all_done(dir: &Path, results: &Path) -> Result<()> {
    let Some(part) = Part::read(dir)? else {
        bail!("{}: no bench.json says which cases it is to hold; use --partial", dir.display());
    };
    let rows: Vec<Row> = jsonl::read(results)?;
    let done: HashSet<&str> = rows.iter().map(|row| row.id.as_str()).collect();
    // Of the cases that the directory claimed, not of the plan: shards are complete one by one.
    let open = part.cases.iter().filter(|id| !done.contains(id.as_str())).count();
    ensure!(
        open == 0,
        "{}: {open} of {} cases are not done; go on with `gapbench run --resume`, or use --partial",
        dir.display(),
        part.cases.len()
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use crate::part::PlanId;

    /// Directories with the rows of these cases each, to hold `all` of them.
    fn dirs(parts: &[&[usize]], all: bool) -> Result<(tempfile::TempDir, Vec<PathBuf>, Vec<Case>)> {
        let root = tempfile::tempdir()?;
        let opened = example::opened();
        let cases = example::PLAN.cases();
        let mut dirs = Vec::new();
        for (i, part) in parts.iter().enumerate() {
            let dir = root.path().join(i.to_string());
            std::fs::create_dir_all(&dir)?;
            let of_part: Vec<Case> = part.iter().map(|k| cases[*k].clone()).collect();
            Part::new(example::PLAN, if all { &of_part } else { &cases[..9] })
                .claim(&dir, false)?;
            let mut text = String::new();
            for case in &of_part {
                let row = opened.iter().find(|opened| opened.row.id == case.id);
                text += &format!("{}\n", serde_json::to_string(&row.map(|row| &row.row))?);
            }
            std::fs::write(dir.join(RESULTS), text)?;
            dirs.push(dir);
        }
        Ok((root, dirs, cases))
    }

    #[test]
    fn parts_are_put_together_in_the_order_of_the_plan() -> Result<()> {
        let (_root, dirs, cases) = dirs(&[&[3, 1], &[0, 2]], true)?;
        let merged = merge(&dirs, &cases, false)?;
        let ids: Vec<&str> = merged.rows.iter().map(|row| row.id.as_str()).collect();
        assert_eq!(ids, cases[..4].iter().map(|case| case.id.as_str()).collect::<Vec<_>>());
        Ok(())
    }

    #[test]
    fn a_case_that_is_there_twice_is_refused() -> Result<()> {
        let (_root, dirs, cases) = dirs(&[&[0, 1], &[1, 2]], true)?;
        let error = merge(&dirs, &cases, false).unwrap_err().to_string();
        assert!(error.contains(&cases[1].id) && error.contains("leave one"), "{error}");
        Ok(())
    }

    #[test]
    fn a_case_of_another_plan_is_refused() -> Result<()> {
        let (_root, dirs, _) = dirs(&[&[0]], true)?;
        let others = PlanId { seed: example::PLAN.seed + 1, ..example::PLAN }.cases();
        assert!(merge(&dirs, &others, false).unwrap_err().to_string().contains("not of this plan"));
        Ok(())
    }

    #[test]
    fn labels_stay_closed_while_cases_are_open() -> Result<()> {
        let (_root, dirs, cases) = dirs(&[&[0, 1]], false)?;
        let error = merge(&dirs, &cases, false).unwrap_err().to_string();
        assert!(error.contains("7 of 9 cases are not done"), "{error}");
        assert_eq!(merge(&dirs, &cases, true)?.rows.len(), 2);
        Ok(())
    }

    #[test]
    fn a_directory_without_results_is_refused() -> Result<()> {
        let dir = tempfile::tempdir()?;
        assert!(merge(&[dir.path().to_owned()], &[], true).is_err());
        Ok(())
    }
}
