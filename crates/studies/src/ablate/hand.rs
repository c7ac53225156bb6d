//! `evpose ablate hand`: all rows under all seeds.

use std::path::Path;

use anyhow::{Context, Result};
use clap::builder::{PossibleValue, PossibleValuesParser};
use evpose_cli::configs;
use evpose_cli::progress::{note, say};
use evpose_cli::ranges::count;
use evpose_cli::recorded;
use evpose_cli::run_info::CONFIG;
use evpose_pose::metric::Pck;
use evpose_report::chart::{self, Series};
use evpose_report::colour::palette;
use evpose_sim::SequenceSet;
use evpose_task::Experiment as _;
use evpose_task::hand::HandConfig;

use super::rows::{self, BACKBONES, Group, MEAN_POSE, Published, ROWS, Row, selected};
use super::trial::{CURVE_STRIDE, Metrics, RowTrial, Trial, TrialRun};
use crate::study::{
    self, Finding, Outcome, Relation, SeedArgs, Study, StudyArgs, StudyPlan, StudyReport,
    StudyTable, TrialIndex, Trials, VERDICTS, Written, exclusively,
};

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose ablate hand --out runs/ablation\n  \
    evpose ablate hand --out runs/ablation --resume\n  \
    evpose ablate hand --rows lnes-33,eoi,no-filter --seeds 5 --out runs/inputs\n  \
    evpose ablate hand --rows backbones --seeds 1 --stride-ms 5 --out runs/networks \\\n      \
    --set simulation.image_scale=0.42 --set simulation.sequences=240 --set network.width=0.0625 \\\n      \
    --set training.steps=1000 --set training.steps_per_validation=100\n\n\
    Every row is the full method with one thing changed. Sequences are simulated once for each seed \
    and shared by all rows; the full method always runs, since every row is compared with it. More \
    rows and seeds can be added to a directory later, with --resume. `backbones` stands for all rows of \
    other networks; Inception v3 is left out where images have less than 75 pixels a side.")]
pub struct AblateHandArgs {
    /// A TOML file, or an embedded config: `ablation`, `quick`, `eventhands`
    #[arg(long, default_value = "ablation")]
    config: String,
    /// Rows to run, comma-separated [default: all]
    #[arg(long, value_delimiter = ',', value_parser = row_names())]
    rows: Vec<String>,
    #[command(flatten)]
    seeds: SeedArgs,
    /// Milliseconds between the poses that are evaluated and filtered
    #[arg(long, default_value_t = 1, value_parser = count::<u32>())]
    stride_ms: u32,
    #[command(flatten)]
    study: StudyArgs,
}

fn row_names() -> PossibleValuesParser {
    let group = PossibleValue::new(BACKBONES).help("every row of another network");
    let rows = ROWS.iter().map(|row| PossibleValue::new(row.name).help(row.about));
    PossibleValuesParser::new(rows.chain([group]).collect::<Vec<_>>())
}

pub(super) fn run(args: &AblateHandArgs) -> Result<()> {
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
        // An invalid row would end the study hours later, after the training of those before it.
        row.config(&base).validate().with_context(|| format!("row {}", row.name))?;
    }
    let seeds = args.seeds.all(base.seed)?;
    // Only these are trained: without the filter, the network is that of the full method.
    let trained: Vec<&Row> = rows.iter().copied().filter(|row| row.is_filtered()).collect();
    let plan = StudyPlan {
        args: &args.study,
        seed: base.seed,
        inputs: vec![(CONFIG, base.to_toml()?)],
        rows: study::strings(trained.iter().map(|row| row.name)),
        seeds: study::seed_names(&seeds),
        files: ["ablation.json", "ablation.md", "ablation.html"],
    };
    plan.run(&HandAblation { args, base, rows, trained, seeds }).map(|_| ())
}

struct HandAblation<'a> {
    args: &'a AblateHandArgs,
    /// Of the full method.
    base: HandConfig,
    rows: Vec<&'static Row>,
    /// Those with a network of their own.
    trained: Vec<&'static Row>,
    seeds: Vec<u64>,
}

impl HandAblation<'_> {
    fn trial(&self, (row, seed): TrialIndex) -> TrialRun {
        let (row, seed, study) = (self.trained[row], self.seeds[seed], self.args.study.directory());
        TrialRun {
            row: row.name,
            config: row.config(&HandConfig { seed, ..self.base.clone() }),
            run: study.path(&format!("rows/{}/seed-{seed}", row.name)),
            train: study.data(seed, "train"),
            held_out: study.data(seed, "held-out"),
            stride_ms: self.args.stride_ms,
            device: self.args.study.device.device,
        }
    }
}

impl Study for HandAblation<'_> {
    type Trial = Trial;
    type Outcome = HandOutcome;

    fn path(&self, (row, seed): TrialIndex) -> String {
        format!("rows/{}/seed-{}/trial.json", self.trained[row].name, self.seeds[seed])
    }

    fn is_current(&self, trial: TrialIndex, stored: &Trial) -> Result<bool> {
        // Training and evaluation are stored apart: another stride needs no training.
        Ok(self.trial(trial).is_trained()? && stored.stride_ms == self.args.stride_ms)
    }

    fn prepare(&self, trials: &[TrialIndex]) -> Result<()> {
        // Simulated once a seed, for all rows.
        for (index, &seed) in self.seeds.iter().enumerate() {
            if trials.iter().any(|trial| trial.1 == index) {
                let (config, study) =
                    (HandConfig { seed, ..self.base.clone() }, self.args.study.directory());
                simulate(&config, &study.data(seed, "train"))?;
                simulate(&config.held_out(), &study.data(seed, "held-out"))?;
            }
        }
        Ok(())
    }

    fn run(&self, trial: TrialIndex) -> Result<(Trial, String)> {
        let trial = self.trial(trial).finish()?;
        let Metrics { auc_2d, auc_3d, .. } = trial.filtered.figures;
        Ok((trial, format!("AUC 2D {auc_2d:.3}, AUC 3D {auc_3d:.3}")))
    }

    fn outcome(&self, trials: &Trials<Trial>) -> Result<Written<Self::Outcome>> {
        let Some(outcome) = outcome(&self.rows, &self.seeds, trials) else { return Ok(None) };
        let report = self.report(&outcome)?;
        Ok(Some((outcome, report)))
    }
}

impl HandAblation<'_> {
    fn report(&self, outcome: &HandOutcome) -> Result<StudyReport> {
        let legend = format!(
            "Means over seeds {} with 95% intervals of Student's t, a pose every {} ms. AUC: larger is better; errors \
             and the lowest validation loss: smaller. poses/s: the network alone, one window at a time, at the width \
             of the config; `evpose bench infer --network all` times all of them at full width. Verdicts follow from \
             the interval of the difference between two rows, seed by seed: {VERDICTS}. Timed on {}.",
            study::listed(&outcome.seeds),
            self.args.stride_ms,
            outcome.machines.join(" and "),
        );
        let mut tables = vec![
            outcome.all_rows("row", &legend),
            outcome.all_findings(
                "Statements of the supplement of EventHands, and their tests: the difference between the row and the \
                 one it is compared with.",
            ),
        ];
        for (group, title, note) in CHARTS {
            tables.extend(curves(outcome, group, title, note)?);
        }
        Ok(StudyReport {
            title: "What each part of the hand method is worth".to_owned(),
            about: "Every row is the full method with one thing changed, simulated, trained and evaluated by evpose \
                    on this machine."
                .to_owned(),
            tables,
            details: vec![
                ("Rows".to_owned(), outcome.descriptions()),
                ("Config of the full method".to_owned(), self.base.to_toml()?),
            ],
        })
    }
}

type HandOutcome = Outcome<&'static Row, RowTrial>;

/// Measures that statements about accuracy are tested with, and those about speed.
const ACCURACY: &[&str] = &["auc_2d", "auc_3d"];
const SPEED: &[&str] = &["poses_per_s"];

/// The outcome of the rows that have trials; none without the full method.
fn outcome(rows: &[&'static Row], seeds: &[u64], trials: &Trials<Trial>) -> Option<HandOutcome> {
    // Every row is compared with it, so that nothing can be said before it is complete.
    let full = trials.get(rows::FULL)?;
    // Rows that differ in evaluation alone share the trials of one network.
    let done: Vec<&Row> =
        rows.iter().copied().filter(|row| trials.contains_key(row.trained_as())).collect();
    let mut all: Vec<(&Row, Vec<RowTrial>)> = Vec::new();
    let mut findings = Vec::new();
    for &row in &done {
        let scores = |trial: &Trial| match row.is_filtered() {
            true => RowTrial::new(&trial.filtered, Some(trial)),
            false => RowTrial::new(&trial.unfiltered, Some(trial)),
        };
        all.push((row, trials.get(row.trained_as())?.iter().map(scores).collect()));
        // A statement about a row that did not run cannot be checked.
        let known = |of: &&Published| done.iter().any(|other| other.name == of.than);
        for &Published { relation, than, words } in row.published.iter().filter(known) {
            let measures = if relation == Relation::Slower { SPEED } else { ACCURACY };
            findings.extend(measures.iter().map(|&measure| Finding {
                row: row.name,
                relation,
                than,
                measure,
                published: words.to_owned(),
            }));
        }
    }
    // It depends on the training data alone, so that trials of any network would do.
    let mean_pose = full.iter().map(|trial| RowTrial::new(&trial.mean_pose, None)).collect();
    all.push((&MEAN_POSE, mean_pose));
    Some(Outcome::new(seeds, "held-out sequences".to_owned(), all, findings))
}

const CHARTS: [(Group, &str, &str); 3] = [
    (
        Group::Input,
        "Input of the network",
        "Windows of other lengths, and representations without time stamps.",
    ),
    (Group::Method, "Augmentation and filter", "Without augmentation, and without the filter."),
    (Group::Backbone, "The network", "Other backbones at the same relative width."),
];

/// Shares of correct points of a group of rows and the full method, mean over seeds, one curve a row.
fn curves(
    outcome: &HandOutcome,
    group: Group,
    title: &str,
    note: &str,
) -> Result<Option<StudyTable>> {
    let is_shown = |of: Group| of == group || of == Group::Full;
    let shown: Vec<_> = outcome.rows.iter().filter(|row| is_shown(row.row.group)).collect();
    // The full method alone would be a chart that compares nothing.
    if shown.len() < 2 {
        return Ok(None);
    }
    let chart = |title: &str, x: &str, key: &str| -> Result<String> {
        let curves = shown.iter().enumerate().filter_map(|(index, row)| {
            let points = row.curves.get(key)?.iter().enumerate();
            let points = points.map(|(i, &share)| (Pck::threshold(i * CURVE_STRIDE), share));
            Some(Series::line(row.row.name, palette(index), points.collect()))
        });
        Ok(chart::pck(title, x, curves.collect())?)
    };
    let curves = vec![
        chart("3D, relative to the wrist", "threshold in mm", "pck_3d")?,
        chart("2D", "threshold in percent of the palm", "pck_2d")?,
    ];
    Ok(Some(StudyTable::charts(title, note, curves)))
}

/// Simulates the missing sequences of a directory, by one shard while others wait.
fn simulate(config: &HandConfig, data: &Path) -> Result<()> {
    exclusively(data, || {
        let set = SequenceSet::of_hands(data, &config.simulation)?;
        // It is written last.
        if !set.manifest().exists() {
            let recorded = recorded::record(config, data, "simulating")?;
            say(format!("{}: {recorded}", data.display()));
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trials of one row whose areas are these, one a seed; unfiltered ones are 0.1 lower.
    fn trials(row: &str, areas: &[f64]) -> (String, Vec<Trial>) {
        let scores = |auc: f64| {
            serde_json::json!({
                "figures": {
                    "auc_2d": auc, "auc_3d": auc, "mpjpe_mm": 100.0 * (1.0 - auc),
                    "translation_mm": 30.0, "rotation_deg": 20.0, "articulation": 0.5,
                },
                "pck_2d": [0.0, auc], "pck_3d": [0.0, auc],
            })
        };
        let trial = |(seed, &auc): (usize, &f64)| {
            serde_json::from_value(serde_json::json!({
                "row": row, "seed": seed, "stride_ms": 1,
                "made": { "commit": "test", "machine": "one", "device": "flex" },
                "parameters": 7, "parameters_as_published": 70,
                "training_s": 60.0, "validation_loss": 1.0 - auc, "poses_per_s": 500.0,
                "filtered": scores(auc), "unfiltered": scores(auc - 0.1),
                "mean_pose": scores(0.1),
            }))
        };
        let trials = areas.iter().enumerate().map(trial).collect::<Result<_, _>>();
        (row.to_owned(), trials.expect("a trial"))
    }

    fn of(trials: &Trials<Trial>) -> HandOutcome {
        outcome(&ROWS, &[1, 2, 3], trials).expect("the full method")
    }

    #[test]
    fn the_row_without_filter_is_the_full_method_evaluated_otherwise() -> Result<()> {
        let full = trials(rows::FULL, &[0.5, 0.6, 0.7]);
        let outcome = of(&Trials::from([full, trials("no-augmentation", &[0.2, 0.3, 0.4])]));
        let names: Vec<_> = outcome.rows.iter().map(|row| row.row.name).collect();
        assert_eq!(names, [rows::FULL, "no-augmentation", "no-filter", "mean-pose"]);
        assert!((outcome.rows[2].means["auc_2d"].estimate - 0.5).abs() < 1e-9);
        assert!(!outcome.rows[3].means.contains_key("poses_per_s"));
        let findings = outcome.findings.iter().step_by(2);
        let tested: Vec<_> = findings.map(|f| (f.finding.row, f.finding.than)).collect();
        let of_augmentation = [rows::FULL, "no-filter"].map(|than| ("no-augmentation", than));
        assert_eq!(tested[..2], of_augmentation);
        assert_eq!(tested[2..], [("no-filter", rows::FULL)]);
        // The full method with and without filter, and without augmentation: two charts.
        let charts = curves(&outcome, Group::Method, "", "")?.map_or(0, |table| table.curves.len());
        assert_eq!((charts, curves(&outcome, Group::Backbone, "", "")?.is_none()), (2, true));
        Ok(())
    }

    #[test]
    fn a_network_is_slower_by_its_speed_and_not_by_its_accuracy() {
        let areas = [0.5, 0.6, 0.7];
        let both = of(&Trials::from([trials(rows::FULL, &areas), trials("resnet34", &areas)]));
        let of_network = both.findings.iter().filter(|f| f.finding.row == "resnet34");
        let measures: Vec<_> = of_network.map(|f| f.finding.measure).collect();
        assert_eq!(measures, ["auc_2d", "auc_3d", "poses_per_s"]);
        assert!(outcome(&[], &[1], &Trials::from([trials("eoi", &areas)])).is_none());
    }
}
