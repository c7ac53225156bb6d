//! `gapbench outside`: recordings that other programs made of scenes whose light is known.
//!
//! ```text
//! identify   every case by `evpose gap run`, as a process of its own; a row a case
//!   -> opened   the truth of each case that has a row
//!   -> score    precision and recall of names, exact sets, times -> tables
//! names      names of the catalogue that are right for what is hidden in a recording
//! ```

mod args;
#[cfg(test)]
mod example;
mod identify;
mod names;
mod opened;
mod row;
mod score;
mod tables;
mod truth;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::bad_input::BadInput;
use crate::files;
use crate::terminal::say;
pub(super) use args::OutsideArgs;
pub(super) use opened::Opened;
use row::Row;
pub(super) use tables::key;

use super::naming::RESULTS;
use super::{jsonl, part, stored};

/// `gapbench outside`.
pub(super) fn run(args: &OutsideArgs) -> Result<()> {
    files::create(&args.out)?;
    let Some(dir_of_cases) = &args.cases else {
        // Without cases, stored results are scored again.
        let opened = read(&args.score).context(BadInput)?;
        let scores = score::score_cases(&opened, stored::names(&args.score, &args.out));
        tables::lines(&scores).iter().for_each(say);
        return tables::write(&args.out, &opened, &scores);
    };
    let cases = identify::cases(dir_of_cases).context(BadInput)?;
    let dirs: Vec<PathBuf> = if args.score.is_empty() {
        let (of, parts) = part::shard(&args.shard).context(BadInput)?;
        // Interleaved, so that shards are alike even where names sort by generator.
        let of_shard = cases.iter().skip(of - 1).step_by(parts);
        let of_shard: Vec<PathBuf> =
            of_shard.take(args.limit.unwrap_or(usize::MAX)).cloned().collect();
        identify::run(args, &of_shard)?;
        if of_shard.len() < cases.len() && !args.partial {
            say("done; score all shards with `gapbench outside ... --score DIR...`");
            return Ok(());
        }
        vec![args.out.clone()]
    } else {
        args.score.clone()
    };
    let rows = merge(&dirs, &cases, args.partial).context(BadInput)?;
    let truths = args.truth.as_ref().unwrap_or(dir_of_cases);
    let opened = opened::open(rows, dir_of_cases, truths).context(BadInput)?;
    let scores = score::score_cases(&opened, Vec::new());
    tables::lines(&scores).iter().for_each(say);
    tables::write(&args.out, &opened, &scores)?;
    if !args.score.is_empty() {
        write_merged(&args.out, &opened)?;
    }
    say(format!("written to {}", args.out.display()));
    Ok(())
}

/// Writes the rows of all shards as one file, and their truths as another: the data that the scores
/// are of.
fn write_merged(out: &Path, opened: &[Opened]) -> Result<()> {
    let text: Result<String> = opened.iter().map(|case| jsonl::line(&case.row)).collect();
    files::write(out, RESULTS, text?.as_bytes())?;
    let text: Result<String> = opened.iter().map(|case| jsonl::line(&case.stored())).collect();
    files::write(out, opened::TRUTHS, text?.as_bytes())
}

/// Cases of stored folders, in the order of their names.
pub(super) fn read(dirs: &[PathBuf]) -> Result<Vec<Opened>> {
    let mut opened = Vec::new();
    for dir in dirs {
        opened.extend(opened::read(dir)?);
    }
    jsonl::sort(&mut opened, |case| &case.row.id)?;
    Ok(opened)
}

#[cfg(test)]
pub(super) fn scores(dirs: &[PathBuf]) -> Result<score::OutsideScores> {
    Ok(score::score_cases(&read(dirs)?, Vec::new()))
}

pub(super) fn derived(dirs: &[PathBuf], names: Vec<String>) -> Result<Vec<(&'static str, String)>> {
    let opened = read(dirs)?;
    tables::texts(&opened, &score::score_cases(&opened, names))
}

/// Rows of all directories, by case. Each case is there once; all of them are, unless `is_partial`.
fn merge(dirs: &[PathBuf], cases: &[PathBuf], is_partial: bool) -> Result<Vec<Row>> {
    let known: HashSet<String> = cases.iter().map(|case| identify::id(case)).collect();
    let mut rows: Vec<Row> = Vec::new();
    for dir in dirs {
        rows.extend(jsonl::read::<Row>(&dir.join(RESULTS))?);
    }
    jsonl::sort(&mut rows, |row| &row.id)?;
    // Rows of other cases would count for rates of these.
    if let Some(row) = rows.iter().find(|row| !known.contains(&row.id)) {
        anyhow::bail!("case {} is not among these cases", row.id);
    }
    // Each known, none twice: the difference is what is missing.
    let open = known.len() - rows.len();
    ensure!(
        open == 0 || is_partial,
        "{open} of {} cases are not done; go on with --resume, or use --partial",
        known.len()
    );
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dir_of(rows: &[Row]) -> Result<tempfile::TempDir> {
        let dir = tempfile::tempdir()?;
        let lines: Result<String> =
            rows.iter().map(|row| Ok(format!("{}\n", serde_json::to_string(row)?))).collect();
        std::fs::write(dir.path().join(RESULTS), lines?)?;
        Ok(dir)
    }

    #[test]
    fn truths_stay_closed_while_cases_are_open_and_no_case_counts_twice() -> Result<()> {
        let rows: Vec<Row> = example::opened().into_iter().map(|opened| opened.row).collect();
        let cases: Vec<PathBuf> = rows.iter().map(|row| Path::new("cases").join(&row.id)).collect();
        let (first, rest) = (dir_of(&rows[..2])?, dir_of(&rows[2..])?);
        let dirs = [first.path().to_owned(), rest.path().to_owned()];
        assert_eq!(merge(&dirs, &cases, false)?.len(), rows.len());
        assert!(merge(&dirs[..1], &cases, false).unwrap_err().to_string().contains("not done"));
        assert_eq!(merge(&dirs[..1], &cases, true)?.len(), 2);
        let twice = [dirs[0].clone(), dirs[0].clone()];
        assert!(merge(&twice, &cases, true).unwrap_err().to_string().contains("twice"));
        assert!(merge(&dirs, &cases[1..], true).unwrap_err().to_string().contains("not among"));
        Ok(())
    }
}
