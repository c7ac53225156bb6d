//! `evpose compare clips`: what pre-training and fine-tuning are worth on real images, one clip left out at a time.
//!
//! # Source
//! Goyal et al., CVPRW 2023: pre-trained on stills, fine-tuned on recordings of DHP19, evaluated on others. They held
//! out subjects; clips of one subject say less of other people.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use burn::tensor::Device;
use evpose_cli::configs;
use evpose_cli::json::write_json;
use evpose_cli::progress::{bar, say, training_bar};
use evpose_cli::provenance::Provenance;
use evpose_cli::recorded;
use evpose_cli::run_info::CONFIG;
use evpose_cli::shipped::{checkpoint_path, sha256};
use evpose_core::Micros;
use evpose_core::stats::bootstrap::BootstrapConfig;
use evpose_pose::metric::body::BodyEvaluation;
use evpose_report::chart::{self, Chart, ChartAxis, Series};
use evpose_report::colour::palette;
use evpose_task::body::{BodyCheckpoint, BodyConfig, BodyPredictor, BodyPredictorOptions};
use evpose_task::{BEST, Experiment as _, LAST};
use evpose_train::body::{
    BodyFrames, evaluate_frames, first_network, holds_annotations, train_body_validated_on,
};
use evpose_train::{read_history, validation_means};
use serde::{Deserialize, Serialize};

use super::system::{DataSet, MOVE_ENET, SYSTEMS};
use super::trial::Trial;
use crate::study::{
    self, Study, StudyArgs, StudyPlan, StudyReport, StudyTable, TrialIndex, Trials, Written,
    metric, strings,
};
use evpose_cli::outputs::OutputFile;

/// Settings of every fine-tuning, before those of `--set`. Nothing is chosen or calibrated by the clip left out, and
/// labelled images have no events that could be erased.
const FINE_TUNING: [&str; 7] = [
    "data.source=annotations",
    "data.min_joints=1",
    "augmentation.rest_probability=0.0",
    "training.calibrate_confidence=false",
    "training.learning_rate=5e-4",
    "training.steps=200",
    "training.steps_per_validation=50",
];

/// Thresholds of the PCK, in percent of the torso's diagonal.
const PERCENTS: [usize; 2] = [20, 40];

/// Arguments of `evpose compare clips`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose compare clips dhp19_eros --out runs/clips\n  \
    evpose compare clips dhp19_eros --start body,runs/stills --out runs/clips --resume\n\n\
    Every network is evaluated on each clip as it is, and fine-tuned on the other clips; another is trained on these \
    from initial weights.")]
pub struct CompareClipsArgs {
    /// A folder of clips, each with `poses.json` and `images`
    clips: PathBuf,
    /// Networks to start from: run directories, .bpk files, or names of shipped ones, of the config's shape
    #[arg(long, value_name = "NETWORK", value_delimiter = ',', default_values = ["body"])]
    start: Vec<PathBuf>,
    /// The config of the network and its fine-tuning: a file, or an embedded one
    #[arg(long, default_value = "body-wide")]
    config: String,
    /// Also write the results here
    #[arg(long, value_name = "FILE")]
    json: Option<OutputFile>,
    #[command(flatten)]
    study: StudyArgs,
}

/// A network as it is, or trained on all clips but the one that it is evaluated on.
struct Row {
    name: String,
    /// None for initial weights.
    start: Option<PathBuf>,
    /// SHA-256 of the file of `start`.
    digest: String,
    is_trained: bool,
}

impl Row {
    fn directory(&self) -> String {
        self.name.replace([' ', ','], "-")
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct ClipScores {
    clip: String,
    images: usize,
    pck_20: f64,
    pck_40: f64,
    auc: f64,
    mpjpe_px: f64,
    /// Optimiser steps, and PCK@0.2 of one pass on this clip after them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    learning_curve: Vec<(u64, f64)>,
}

#[derive(Debug, Serialize)]
struct RowScores {
    name: String,
    /// Means over clips.
    pck_20: f64,
    pck_40: f64,
    auc: f64,
    mpjpe_px: f64,
    /// The lowest PCK@0.4 of a clip.
    worst_pck_40: f64,
    clips: Vec<ClipScores>,
}

impl RowScores {
    fn new(name: String, clips: Vec<ClipScores>) -> Self {
        let mean =
            |of: fn(&ClipScores) -> f64| clips.iter().map(of).sum::<f64>() / clips.len() as f64;
        Self {
            // Clips weigh alike, so that a long one does not decide.
            pck_20: mean(|clip| clip.pck_20),
            pck_40: mean(|clip| clip.pck_40),
            auc: mean(|clip| clip.auc),
            mpjpe_px: mean(|clip| clip.mpjpe_px),
            worst_pck_40: clips.iter().map(|clip| clip.pck_40).fold(f64::INFINITY, f64::min),
            name,
            clips,
        }
    }
}

#[derive(Debug, Serialize)]
struct Outcome {
    #[serde(flatten)]
    provenance: Provenance,
    steps: u64,
    batch_size: usize,
    rows: Vec<RowScores>,
    /// Published figures of MoveEnet on other subjects of DHP19.
    published: Vec<(&'static str, f64)>,
}

/// Trains, evaluates and writes the missing results.
pub(super) fn run(args: &CompareClipsArgs) -> Result<()> {
    let device = args.study.open()?;
    let provenance = Provenance::this();
    let overrides: Vec<String> =
        FINE_TUNING.iter().map(|&set| set.to_owned()).chain(args.study.overrides.clone()).collect();
    let mut config: BodyConfig = configs::load(&args.config, &overrides)?;
    // Each row says for itself where its training starts.
    config.start_from = None;
    // The clip left out is what the training validates on: it may not end it.
    config.training.early_stop.window = 0;
    let clips = Clip::all(&args.clips, &config)?;
    let rows = rows_of(args, &config, &device)?;
    let plan = StudyPlan {
        args: &args.study,
        seed: config.seed,
        inputs: vec![("inputs.txt", inputs(&rows, &clips)), (CONFIG, config.to_toml()?)],
        rows: strings(rows.iter().map(|row| &row.name)),
        seeds: clips.iter().map(|clip| format!("clip {}", clip.name)).collect(),
        files: ["clips.json", "clips.md", "clips.html"],
    };
    let outcome = plan.run(&ClipStudy { args, device, provenance, config, rows, clips })?;
    outcome.map_or(Ok(()), |outcome| write_json(args.json.as_deref(), &outcome))
}

struct ClipStudy<'a> {
    args: &'a CompareClipsArgs,
    device: Device,
    provenance: Provenance,
    config: BodyConfig,
    rows: Vec<Row>,
    clips: Vec<Clip>,
}

impl Study for ClipStudy<'_> {
    type Trial = ClipScores;
    type Outcome = Outcome;

    fn path(&self, (row, clip): TrialIndex) -> String {
        format!("{}/{}/scores.json", self.rows[row].directory(), self.clips[clip].name)
    }

    fn run(&self, trial: TrialIndex) -> Result<(ClipScores, String)> {
        let scores = self.scores(trial)?;
        let line = format!("PCK@0.4 {:.3}, PCK@0.2 {:.3}", scores.pck_40, scores.pck_20);
        Ok((scores, line))
    }

    fn outcome(&self, trials: &Trials<ClipScores>) -> Result<Written<Outcome>> {
        if trials.is_empty() {
            return Ok(None);
        }
        let scores = |row: &Row| Some((row.name.clone(), trials.get(&row.name)?.clone()));
        let rows = self.rows.iter().filter_map(scores);
        let outcome = Outcome {
            provenance: self.provenance.clone(),
            steps: self.config.training.steps,
            batch_size: self.config.training.batch_size,
            rows: rows.map(|(name, clips)| RowScores::new(name, clips)).collect(),
            published: published(),
        };
        let report = StudyReport {
            title: "Pre-training and fine-tuning on real images".to_owned(),
            about: "Each clip is evaluated by networks that were trained on the others.".to_owned(),
            tables: vec![outcome.table(), outcome.learning_curves()?],
            details: vec![("Config of the fine-tuning".to_owned(), self.config.to_toml()?)],
        };
        Ok(Some((outcome, report)))
    }
}

/// The rows of the study: initial weights trained, then every start as it is and trained.
fn rows_of(args: &CompareClipsArgs, config: &BodyConfig, device: &Device) -> Result<Vec<Row>> {
    let row = |name: &str, start: Option<&PathBuf>, digest: &str, is_trained| Row {
        name: name.to_owned(),
        start: start.cloned(),
        digest: digest.to_owned(),
        is_trained,
    };
    let mut rows = vec![row("from nothing", None, "", true)];
    for start in &args.start {
        let mut path = checkpoint_path(start)?;
        // The digest is of a file, which a run directory is not.
        if path.is_dir() {
            path = path.join(BEST);
        }
        let config = BodyConfig { start_from: Some(path.clone()), ..config.clone() };
        // Made in vain: a start that does not fit is refused before hours of training.
        first_network(&config, device).with_context(|| format!("--start {}", start.display()))?;
        let digest = sha256(&path)?;
        let name = start.file_name().unwrap_or_default().to_string_lossy();
        let name = name.trim_end_matches(".bpk");
        rows.push(row(name, Some(&path), &digest, false));
        rows.push(row(&format!("{name}, fine-tuned"), Some(&path), &digest, true));
    }
    // Rows of one directory would take each other's trials for their own.
    let mut names: Vec<String> = rows.iter().map(Row::directory).collect();
    names.sort();
    names.dedup();
    ensure!(
        names.len() == rows.len(),
        "--start: two networks have one name: copy one to another file"
    );
    Ok(rows)
}

/// Digests of the inputs of a study, whose directory takes no others.
fn inputs(rows: &[Row], clips: &[Clip]) -> String {
    // Each start has two rows, unchanged and trained: it is listed once.
    let starts = rows.iter().filter(|row| row.start.is_some() && !row.is_trained);
    let starts = starts.map(|row| format!("start {} {}\n", row.name, row.digest));
    let clips = clips.iter().map(|clip| format!("clip {} {}\n", clip.name, clip.frames.digest()));
    starts.chain(clips).collect()
}

struct Clip {
    name: String,
    frames: BodyFrames,
}

impl Clip {
    /// All clips in a folder, by name.
    fn all(folder: &Path, config: &BodyConfig) -> Result<Vec<Self>> {
        let in_folder = || folder.display().to_string();
        let mut paths = Vec::new();
        for entry in folder.read_dir().with_context(in_folder)? {
            paths.push(entry.with_context(in_folder)?.path());
        }
        paths.retain(|path| holds_annotations(path));
        // Folders list their entries in an order of their own.
        paths.sort();
        ensure!(
            paths.len() > 1,
            "{}: {} clips; one is left out, so that two are needed, each with `poses.json` and `images`",
            folder.display(),
            paths.len()
        );
        let read = |path: PathBuf| -> Result<Self> {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            Ok(Self { name, frames: recorded::frames(config, &path)? })
        };
        paths.into_iter().map(read).collect()
    }
}

impl ClipStudy<'_> {
    /// Scores of a row on the clip that is left out.
    fn scores(&self, trial: TrialIndex) -> Result<ClipScores> {
        let (row, left_out, config) = (&self.rows[trial.0], &self.clips[trial.1], &self.config);
        let run = self.args.study.out.join(row.directory()).join(&left_out.name);
        let mut others = BodyFrames::default();
        for clip in self.clips.iter().filter(|clip| clip.name != left_out.name) {
            others.append(clip.frames.clone());
        }
        // Nothing is taken from the clip that the row is evaluated on.
        let mean_pose = others.mean_pose();
        let mut learning_curve = Vec::new();
        let path = match &row.start {
            Some(start) if !row.is_trained => start.clone(),
            start => {
                say(format!("{}: training on all clips but {}", row.name, left_out.name));
                let config = BodyConfig { start_from: start.clone(), ..config.clone() };
                let (progress, callback) = training_bar(&row.name);
                let options = study::options(self.args.study.device.device, callback);
                train_body_validated_on(left_out.frames.clone(), &config, others, &run, &options)
                    .with_context(|| format!("training {}", run.display()))?;
                progress.finish_and_clear();
                let history = read_history(&run.join("metrics.jsonl"))?;
                let training = &config.training;
                let step_of = |interval| interval as u64 * training.steps_per_validation;
                let of = |(interval, pck)| (step_of(interval).min(training.steps), pck);
                learning_curve =
                    validation_means(&history, "accuracy").into_iter().map(of).collect();
                // The best one was chosen by the clip left out.
                run.join(LAST)
            }
        };
        let mut checkpoint = BodyCheckpoint::load(&path, &self.device)?;
        // Rows differ in their training alone.
        checkpoint.config.decoding = config.decoding;
        let predictor = BodyPredictor::new(&checkpoint, BodyPredictorOptions::default(), None)?;
        let mut frames = left_out.frames.clone();
        for (index, frame) in (0..).zip(&mut frames.frames) {
            // Images are evaluated one by one, and none is in the part of a sequence that the protocol leaves out.
            (frame.sequence, frame.t) = (index, Micros::SECOND);
        }
        let progress =
            bar(&format!("{} on {}", row.name, left_out.name), frames.len() as u64, "images");
        let (evaluation, _) =
            evaluate_frames(&predictor, &frames, &mean_pose, &|_, _| progress.inc(1))?;
        progress.finish_and_clear();
        clip_scores(left_out, &evaluation, learning_curve)
    }
}

fn clip_scores(
    left_out: &Clip,
    evaluation: &BodyEvaluation,
    learning_curve: Vec<(u64, f64)>,
) -> Result<ClipScores> {
    // Only estimates are kept, so that resampling would be in vain.
    let no_interval = BootstrapConfig { resamples: 0, seed: 0 };
    let scores = evaluation.summary(&PERCENTS, &no_interval)?.raw;
    let value = |interval: Option<evpose_core::stats::interval::Interval>| {
        interval.map(|interval| interval.estimate).context("no pose could be evaluated")
    };
    Ok(ClipScores {
        clip: left_out.name.clone(),
        images: left_out.frames.len(),
        pck_20: value(scores.pck[0])?,
        pck_40: value(scores.pck[1])?,
        auc: value(scores.auc)?,
        mpjpe_px: value(scores.mpjpe_px)?,
        learning_curve,
    })
}

/// Figures of DHP19 in MoveEnet's paper.
fn published() -> Vec<(&'static str, f64)> {
    let figures = SYSTEMS.find(MOVE_ENET).into_iter().flat_map(|system| system.published);
    let figures = figures.filter(|figure| figure.data_set == DataSet::Dhp19);
    let named = |key| metric::<Trial>(key).map_or(key, |metric| metric.heading);
    figures.map(|figure| (named(figure.measure), figure.value)).collect()
}

impl Outcome {
    fn table(&self) -> StudyTable {
        let rows = self.rows.iter().map(|row| {
            let mut cells = vec![row.name.clone()];
            cells.extend([row.pck_40, row.pck_20, row.auc].map(|value| format!("{value:.3}")));
            cells.push(format!("{:.1}", row.mpjpe_px));
            cells.extend(row.clips.iter().map(|clip| format!("{:.3}", clip.pck_40)));
            cells
        });
        let clips = self.rows.first().into_iter().flat_map(|row| &row.clips);
        let columns = ["network", "PCK@0.4", "PCK@0.2", "AUC", "MPJPE px"].into_iter();
        let published: Vec<String> =
            self.published.iter().map(|(name, value)| format!("{name} {value}")).collect();
        let note = format!(
            "Means over clips; behind them PCK@0.4 of each. Each clip is evaluated by a network that was trained on \
             the others, in {} steps of {} images. Published of MoveEnet on other subjects of DHP19, trained on more \
             of them: {}.",
            self.steps,
            self.batch_size,
            published.join(", ")
        );
        let columns = columns.chain(clips.map(|clip| clip.clip.as_str()));
        StudyTable::new("All networks", columns, rows, &note)
    }

    /// Means over clips.
    fn learning_curves(&self) -> Result<StudyTable> {
        let trained = self.rows.iter().filter(|row| !row.clips[0].learning_curve.is_empty());
        let series = trained.enumerate().map(|(index, row)| {
            let curves = row.clips.iter().map(|clip| &clip.learning_curve);
            let mean = |(at, (step, _)): (usize, &(u64, f64))| {
                let values = curves.clone().filter_map(|curve| curve.get(at)).map(|(_, pck)| pck);
                (*step as f64, values.sum::<f64>() / row.clips.len() as f64)
            };
            let points = row.clips[0].learning_curve.iter().enumerate().map(mean).collect();
            Series::line(&row.name, palette(index), points)
        });
        let chart = Chart {
            title: "Learning curves on the clip left out".to_owned(),
            x: ChartAxis::new("optimiser steps").from_zero(),
            y: ChartAxis::new("PCK@0.2 of one pass").from_zero(),
            series: series.collect(),
        };
        let curves = vec![chart::curves(&chart)?];
        Ok(StudyTable::charts("Learning curves", "Means over clips.", curves))
    }
}
