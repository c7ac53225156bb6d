//! `gapbench own`: recordings that are runs of our own model.
//!
//! Scenes and nominal background are those of the plan's nulls. Nulls without background are left
//! out: there the model makes the same events every time, and a probability of one says nothing.
//! More sets than nulls go through the nulls again with other seeds.

use std::collections::HashSet;
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use evpose_core::{Plane, seed_for};
use evpose_gap::LightSequence;
use evpose_gap::input::Nominal;
use evpose_gap::workflow::own_run;
use evpose_sensor::SensorConfig;
use gapbench_pixel::{Case, CaseKind, FPS, FRAMES, Which};
use rayon::prelude::*;
use serde::Serialize;

use super::jsonl::whole_lines;
use super::part::{self, PlanId};
use super::stats::{Rate, Uniformity, uniformity};
use crate::args::OwnArgs;
use crate::bad_input::BadInput;
use crate::files;
use crate::terminal::{bar, say};
use crate::use_threads;
use evpose_report::format::{percent, short};

/// A line a recording.
pub(super) const NAME: &str = "pvalues.csv";
const HEADER: &str = "set,case,p,events,seconds";
/// Replicates of each, as in a full run of the workflow.
const REPLICATES: usize = 199;
/// Probabilities up to this are called significant.
const LEVEL: f64 = 0.05;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct OwnRow {
    pub(super) set: usize,
    /// The null that lent its scene.
    pub(super) case: String,
    pub(super) p: f64,
    pub(super) events: usize,
    pub(super) seconds: f64,
}

#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct OwnSummary {
    /// Recordings that would be called significant at 5 %.
    pub(super) significant: Rate,
    pub(super) uniformity: Uniformity,
    pub(super) replicates: usize,
}

/// `gapbench own`: records and tests recordings, or the part of them that `--shard` says.
pub(super) fn run(args: &OwnArgs) -> Result<()> {
    use_threads(args.threads)?;
    let plan = PlanId::new(&args.plan).context(BadInput)?;
    let (of, parts) = part::shard(&args.plan.shard).context(BadInput)?;
    files::create(&args.out)?;
    // Without noise all runs have the same events, and p would not be uniform.
    let is_noisy = |case: &Case| case.nominal.noise_on_hz > 0.0 || case.nominal.noise_off_hz > 0.0;
    let nulls: Vec<Case> = plan
        .cases()
        .into_iter()
        .filter(|case| case.kind == CaseKind::Null && is_noisy(case))
        .collect();
    ensure!(!nulls.is_empty(), "no null of the plan has background");
    let path = args.out.join(NAME);
    let known = if args.resume && path.is_file() { read(&path)? } else { Vec::new() };
    // A line that was cut off is dropped, so that the next begins on a line of its own.
    files::write(&args.out, NAME, text(&known).as_bytes())?;
    let done: HashSet<usize> = known.iter().map(|row| row.set).collect();
    let open: Vec<usize> =
        (of - 1..args.sets).step_by(parts).filter(|set| !done.contains(set)).collect();
    let mut file = std::fs::OpenOptions::new()
        .append(true)
        .open(&path)
        .with_context(|| format!("opening {}", path.display()))?;
    let model = SensorConfig::preset("ideal")?;
    let progress = bar("testing", open.len() as u64, "recordings");
    for set in open {
        let begin = Instant::now();
        let case = &nulls[set % nulls.len()];
        // By number of the set: shards give the same recordings as one run.
        let seed = seed_for(plan.seed, "recording of our own", set as u64);
        let found = own_run(scene(case)?, &model, Some(&nominal(case)), REPLICATES as u64, seed)?;
        let row = OwnRow {
            set,
            case: case.id.clone(),
            p: found.p,
            events: found.events,
            seconds: begin.elapsed().as_secs_f64(),
        };
        // Written at once, so that an interrupted run goes on from here.
        file.write_all(line(&row).as_bytes()).context("writing pvalues.csv")?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    // Read back: rows of earlier runs count, too.
    if let Some(summary) = summary(&read(&path)?) {
        lines(&summary).iter().for_each(say);
    }
    say(format!("written to {}", path.display()));
    Ok(())
}

fn scene(case: &Case) -> Result<LightSequence> {
    let scene = case.scene(Which::Train);
    let (width, height) = (gapbench_pixel::event::WIDTH, gapbench_pixel::event::HEIGHT);
    let planes = (0..FRAMES)
        .into_par_iter()
        .map(|k| Plane::from_vec(width, height, scene.frame(k, FPS)))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(LightSequence::new(FPS, planes)?)
}

fn nominal(case: &Case) -> Nominal {
    Nominal {
        threshold_on: Some(case.nominal.c_on),
        threshold_off: Some(case.nominal.c_off),
        threshold_sigma: Some(case.nominal.sigma_c),
        noise_on_hz: Some(case.nominal.noise_on_hz),
        noise_off_hz: Some(case.nominal.noise_off_hz),
    }
}

fn line(row: &OwnRow) -> String {
    format!("{},{},{},{},{:.3}\n", row.set, row.case, row.p, row.events, row.seconds)
}

pub(super) fn text(rows: &[OwnRow]) -> String {
    let lines: String = rows.iter().map(line).collect();
    format!("{HEADER}\n{lines}")
}

/// Reads recordings; a last line that was cut off is left out.
pub(super) fn read(path: &Path) -> Result<Vec<OwnRow>> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let row = |(i, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(',').collect();
        let parsed = || {
            let [set, case, p, events, seconds] = cells.as_slice() else { return None };
            Some(OwnRow {
                set: set.parse().ok()?,
                case: (*case).to_owned(),
                p: p.parse().ok()?,
                events: events.parse().ok()?,
                seconds: seconds.parse().ok()?,
            })
        };
        parsed().with_context(|| format!("{}: line {}: not `{HEADER}`", path.display(), i + 1))
    };
    whole_lines(&text).lines().enumerate().skip(1).map(row).collect()
}

/// All recordings together; none of none.
pub(super) fn summary(rows: &[OwnRow]) -> Option<OwnSummary> {
    let ps: Vec<f64> = rows.iter().map(|row| row.p).collect();
    let uniformity = uniformity(&ps, REPLICATES + 1)?;
    // A probability of exactly one in twenty counts, however it was rounded.
    let significant = Rate::from_outcomes(ps.iter().map(|p| *p <= LEVEL + 1e-12));
    Some(OwnSummary { significant, uniformity, replicates: REPLICATES })
}

fn lines(summary: &OwnSummary) -> Vec<String> {
    let OwnSummary { significant, uniformity, .. } = summary;
    vec![
        format!(
            "significant at 5 %: {} of {}, {} ({} to {}); required 2 to 8 %",
            significant.of,
            significant.n,
            significant.share.map_or_else(|| "-".to_owned(), percent),
            percent(significant.lo95),
            percent(significant.hi95)
        ),
        format!(
            "uniform: largest difference {} (Kolmogorov and Smirnov), p = {}",
            short(uniformity.largest),
            short(uniformity.p)
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_as_they_were_written_and_a_torn_one_is_left_out() -> Result<()> {
        let dir = tempfile::tempdir()?;
        let path = dir.path().join(NAME);
        let row = |set| OwnRow { set, case: "ab12".into(), p: 0.035, events: 7, seconds: 1.5 };
        std::fs::write(&path, format!("{HEADER}\n{}{}2,ab", line(&row(0)), line(&row(1))))?;
        assert_eq!(read(&path)?, [row(0), row(1)]);
        std::fs::write(&path, format!("{HEADER}\n0,ab,x,7,1\n"))?;
        assert!(read(&path).unwrap_err().to_string().contains("line 2"));
        Ok(())
    }

    #[test]
    fn one_in_twenty_is_significant_where_probabilities_are_uniform() {
        let row = |set: usize| OwnRow {
            set,
            case: String::new(),
            p: (set + 1) as f64 / 200.0,
            events: 1,
            seconds: 0.0,
        };
        let summary = summary(&(0..200).map(row).collect::<Vec<_>>()).unwrap();
        assert_eq!((summary.significant.of, summary.significant.n), (10, 200));
        assert!(summary.uniformity.largest < 1e-9 && summary.uniformity.p > 0.999);
    }
}
