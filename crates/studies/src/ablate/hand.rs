//! `evpose ablate hand`: all rows under all seeds.

use std::time::Instant;

use anyhow::{Context, Result};
use evpose_task::Experiment as _;
use evpose_task::hand::HandConfig;

use super::args::AblateHandArgs;
use super::directories::StudyDirectory;
use super::outcome::{Outcome, Trials};
use super::rows::{self, Row};
use super::selection::selected;
use super::{networks_table, page, table, trial};
use crate::study::ResultFiles;
use evpose_cli::configs;
use evpose_cli::progress::{note, say};

pub(super) fn run(args: &AblateHandArgs) -> Result<()> {
    let started = Instant::now();
    args.study.open()?;
    let mut base: HandConfig = configs::load(&args.config, &args.study.overrides)?;
    rows::check(&base)?;
    // All rows are evaluated on the same poses: from the first full window of the longest.
    base.evaluation.first_ms = base.evaluation.first_ms.max(rows::longest_window_ms(&base));
    let (rows, too_small) = selected(&args.rows, &base);
    for row in too_small {
        note(format!(
            "note: row {} is left out: images have {}; choose a larger simulation.image_scale",
            row.name,
            base.network_size()
        ));
    }
    for row in &rows {
        row.config(&base).validate().with_context(|| format!("row {}", row.name))?;
    }
    let seeds = args.seeds.all(base.seed)?;
    let directory = StudyDirectory::open(&args.study.out, &base, args.study.resume)?;
    let results = ResultFiles::new(&args.study.out, "ablation");
    args.study.say_place();
    // Simulated once a seed, for all rows.
    for &seed in &seeds {
        directory.simulate(&base, seed)?;
    }

    let trained: Vec<&Row> = rows.iter().copied().filter(|row| row.is_filtered()).collect();
    let mut trials = Trials::new();
    for (index, row) in trained.iter().enumerate() {
        let begun = Instant::now();
        let mut of_row = Vec::new();
        for &seed in &seeds {
            say(format!("row {}/{}: {}, seed {seed}", index + 1, trained.len(), row.name));
            let config = row.config(&HandConfig { seed, ..base.clone() });
            let kind = args.study.device.device;
            let trial =
                trial::run(&directory, row.name, &config, seeds.len(), args.stride_ms, kind)?;
            let figures = trial.filtered.figures;
            say(format!("    AUC 2D {:.3}, AUC 3D {:.3}", figures.auc_2d, figures.auc_3d));
            of_row.push(trial);
        }
        trials.insert(row.name, of_row);
        // After every row, so that an interrupted study has results.
        let outcome = Outcome::new(&args.config, &seeds, args.stride_ms, &rows, &trials)?;
        let page = page::html(&outcome, &base.to_toml()?)?;
        results.write(&outcome, &table::markdown(&outcome), &page)?;
        say(format!("    row done in {:.1} min", begun.elapsed().as_secs_f64() / 60.0));
    }

    let outcome = Outcome::new(&args.config, &seeds, args.stride_ms, &rows, &trials)?;
    say("");
    say(table::aligned(&outcome));
    say(table::legend(&outcome));
    if let Some(networks) = networks_table::aligned(&outcome) {
        say("");
        say(networks);
        say(networks_table::LEGEND);
    }
    say("");
    results.say_written(started);
    Ok(())
}
