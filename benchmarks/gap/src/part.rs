//! The cases of a plan that a directory holds.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use gapbench_pixel::{Case, Plan, Tier};
use serde::{Deserialize, Serialize};

use crate::args::{ChosenCases, PlanArgs};
use crate::files;

/// File of the cases of a directory, written before its first case is identified.
const NAME: &str = "bench.json";

/// A plan, by what it is made from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct PlanId {
    pub(super) seed: u64,
    /// Its composition; files from before there were two are of plain plans.
    #[serde(default = "plain")]
    pub(super) tier: Tier,
}

fn plain() -> Tier {
    Tier::Plain
}

impl PlanId {
    pub(super) fn new(args: &PlanArgs) -> Result<Self> {
        Self::of_seed(&args.plan, args.tier)
    }

    /// The plan of a seed that was typed, or that of a file.
    pub(super) fn of_seed(plan: &str, tier: Tier) -> Result<Self> {
        Ok(Self { seed: seed(plan)?, tier })
    }

    pub(super) fn cases(self) -> Vec<Case> {
        Plan::from_seed(self.seed, self.tier)
    }

    pub(super) fn tier_name(self) -> &'static str {
        tier_name(self.tier)
    }
}

pub(super) fn tier_name(tier: Tier) -> &'static str {
    match tier {
        Tier::Home => "home",
        Tier::Plain => "plain",
    }
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Part {
    #[serde(flatten)]
    pub(super) plan: PlanId,
    /// Cases, by their names that say nothing.
    pub(super) cases: Vec<String>,
}

impl Part {
    pub(super) fn new(plan: PlanId, cases: &[Case]) -> Self {
        Self { plan, cases: cases.iter().map(|case| case.id.clone()).collect() }
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
                "{} is of other cases (plan {}, tier {}); take another directory, or the same --plan, \
                 --tier, --shard, --only and --limit",
                dir.display(),
                known.plan.seed,
                known.plan.tier_name()
            );
            return Ok(());
        }
        files::write_json(dir, NAME, self)
    }
}

pub(super) fn cases(args: &ChosenCases, plan: PlanId) -> Result<Vec<Case>> {
    let (part, parts) = shard(&args.plan.shard)?;
    let kind = |case: &Case| serde_json::to_value(case.kind).unwrap_or_default();
    let is_wanted = |case: &Case| {
        args.only.is_empty() || args.only.iter().any(|only| kind(case).as_str() == Some(only))
    };
    let cases = plan.cases().into_iter().filter(is_wanted);
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

pub(super) fn is_whole(text: &str) -> bool {
    shard(text).is_ok_and(|(_, parts)| parts == 1)
}

fn seed(plan: &str) -> Result<u64> {
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
        let plan = |seed| PlanId { seed, tier: Tier::Home };
        let part = |seed| Part { plan: plan(seed), cases: vec!["a".to_owned()] };
        part(1).claim(dir.path(), true)?;
        part(1).claim(dir.path(), true)?;
        assert!(part(2).claim(dir.path(), true).is_err());
        part(2).claim(dir.path(), false)?;
        assert_eq!(Part::read(dir.path())?, Some(part(2)));
        let other = Part { plan: PlanId { seed: 2, tier: Tier::Plain }, ..part(2) };
        assert!(other.claim(dir.path(), true).is_err());
        Ok(())
    }

    #[test]
    fn a_file_without_a_tier_is_of_a_plain_plan() -> Result<()> {
        let part: Part = serde_json::from_str(r#"{"seed": 3, "cases": ["a"]}"#)?;
        assert_eq!(part.plan, PlanId { seed: 3, tier: Tier::Plain });
        Ok(())
    }

    #[test]
    fn shards_count_from_one_and_end_at_their_number() {
        assert_eq!(shard("2/4").ok(), Some((2, 4)));
        assert!(["0/4", "5/4", "1", "a/b", "1/0"].iter().all(|text| shard(text).is_err()));
        assert!(is_whole("1/1") && !is_whole("1/2"));
    }
}
