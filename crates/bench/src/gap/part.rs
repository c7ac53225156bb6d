//! The cases of a plan that a directory holds.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use gapbench_pixel::{Case, Plan};
use serde::{Deserialize, Serialize};

use crate::gap::args::BenchArgs;
use evpose_report::gap::files;

/// File of the cases of a directory, written before its first case is identified.
const NAME: &str = "bench.json";

/// Part of a plan.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Part {
    /// Seed of the plan.
    pub(super) seed: u64,
    /// Cases, by their names that say nothing.
    pub(super) cases: Vec<String>,
}

impl Part {
    pub(super) fn new(seed: u64, cases: &[Case]) -> Self {
        Self { seed, cases: cases.iter().map(|case| case.id.clone()).collect() }
    }

    /// The part of a directory; none where no naming was begun.
    pub(super) fn read(dir: &Path) -> Result<Option<Self>> {
        let path = dir.join(NAME);
        if !path.is_file() {
            return Ok(None);
        }
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        serde_json::from_str(&text).map(Some).with_context(|| path.display().to_string())
    }

    /// Writes it; going on in a directory of another part is an error.
    pub(super) fn claim(&self, dir: &Path, is_resumed: bool) -> Result<()> {
        if is_resumed && let Some(known) = Self::read(dir)? {
            ensure!(
                known == *self,
                "{} is of other cases (plan {}); take another directory, or the same --plan, \
                 --shard, --only and --limit",
                dir.display(),
                known.seed
            );
            return Ok(());
        }
        files::write_json(dir, NAME, self)
    }
}

/// The cases that were asked for.
pub(super) fn cases(args: &BenchArgs, seed: u64) -> Result<Vec<Case>> {
    let (part, parts) = shard(&args.shard)?;
    let kind = |case: &Case| serde_json::to_value(case.kind).unwrap_or_default();
    let is_wanted = |case: &Case| {
        args.only.is_empty() || args.only.iter().any(|only| kind(case).as_str() == Some(only))
    };
    let cases = Plan::from_seed(seed).into_iter().filter(is_wanted);
    let of_shard = cases.skip(part - 1).step_by(parts);
    let cases: Vec<Case> = of_shard.take(args.limit.unwrap_or(usize::MAX)).collect();
    ensure!(!cases.is_empty(), "no case of the plan is left");
    Ok(cases)
}

/// Parses `I/N`, where I counts from one.
pub(super) fn shard(text: &str) -> Result<(usize, usize)> {
    text.split_once('/')
        .and_then(|(i, n)| Some((i.parse::<usize>().ok()?, n.parse::<usize>().ok()?)))
        .filter(|(i, n)| (1..=*n).contains(i))
        .with_context(|| format!("--shard {text}: expected I/N, for example 1/4"))
}

/// Whether there is but one part.
pub(super) fn is_whole(text: &str) -> bool {
    shard(text).is_ok_and(|(_, parts)| parts == 1)
}

/// The seed that was typed, or that of a file.
pub(super) fn seed(plan: &str) -> Result<u64> {
    if let Ok(seed) = plan.parse() {
        return Ok(seed);
    }
    let text = std::fs::read_to_string(plan)
        .with_context(|| format!("--plan {plan}: neither a seed nor a file"))?;
    let table: toml::Table = text.parse().with_context(|| plan.to_owned())?;
    let seed = table.get("seed").and_then(toml::Value::as_integer);
    seed.and_then(|seed| u64::try_from(seed).ok())
        .with_context(|| format!("{plan}: no line `seed = N`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_of_one_part_is_not_gone_on_with_as_another() -> Result<()> {
        let dir = tempfile::tempdir()?;
        let part = |seed| Part { seed, cases: vec!["a".to_owned()] };
        part(1).claim(dir.path(), true)?;
        part(1).claim(dir.path(), true)?;
        assert!(part(2).claim(dir.path(), true).is_err());
        part(2).claim(dir.path(), false)?;
        assert_eq!(Part::read(dir.path())?, Some(part(2)));
        Ok(())
    }

    #[test]
    fn shards_count_from_one_and_end_at_their_number() {
        assert_eq!(shard("2/4").ok(), Some((2, 4)));
        assert!(["0/4", "5/4", "1", "a/b", "1/0"].iter().all(|text| shard(text).is_err()));
        assert!(is_whole("1/1") && !is_whole("1/2"));
    }
}
