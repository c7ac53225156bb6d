//! Simulates, trains and evaluates.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result, anyhow, ensure};
use evpose_cli::bad_input::BadInput;
use evpose_cli::machine::Machine;
use evpose_cli::progress::{say, training_bar};
use evpose_cli::run_info::{COMMIT, CONFIG};
use evpose_cli::tasks::{PoseExperiment, PoseTask, StartWeights, experiment, task_by_name};
use evpose_task::BEST;
use serde::{Deserialize, Serialize};

use crate::payoff::args::PayoffArgs;
use crate::payoff::models::{CAMERA, Findings, Models};
use crate::payoff::report;
use crate::payoff::table::{ModelScores, PairedTable};
use crate::study::{self, Study, StudyDirectory, StudyPlan, TrialIndex, Trials, Written};

/// Version of the layout of `payoff.json`.
const SCHEMA: u32 = 1;

/// The result of a study, as `payoff.json` holds it.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Payoff {
    schema: u32,
    gap: Findings,
    /// Task, network and length of the training.
    task: &'static str,
    network: String,
    /// Names of the models that networks were trained on, as given first.
    pub(crate) models: Vec<&'static str>,
    /// Seeds of simulation and training.
    pub(crate) seeds: Vec<u64>,
    /// Directory of the recordings of the evaluation.
    evaluated_on: String,
    /// Milliseconds between evaluated poses; none for the task's default.
    stride_ms: Option<u32>,
    /// Scores and differences.
    #[serde(flatten)]
    pub(crate) table: PairedTable,
    commit: &'static str,
    machine: Machine,
    /// Elapsed time of this process, in seconds.
    elapsed_s: f64,
}

impl Payoff {
    /// How it was made, for the page.
    pub(crate) fn facts(&self) -> Vec<(&'static str, String)> {
        vec![
            ("gap run", self.gap.run.clone()),
            ("verdict", self.gap.verdict.clone()),
            ("effects and parameters", self.gap.effects.join(", ")),
            ("network", self.network.clone()),
            ("evaluated on", self.evaluated_on.clone()),
            ("seeds", study::listed(&self.seeds)),
            ("commit", self.commit.to_owned()),
            ("machine", self.machine.to_string()),
            ("time of the last process", format!("{:.0} s", self.elapsed_s)),
        ]
    }
}

/// Runs `evpose gap payoff`.
///
/// # Errors
/// If a model, a config or a recording cannot be read, a training fails, or `--out` holds another
/// study.
pub fn run(args: &PayoffArgs) -> Result<()> {
    let started = Instant::now();
    args.study.open()?;
    let models = Models::load(args)?;
    // Before hours are spent on the simulation.
    if let Some(data) = args.data.as_ref().filter(|data| !data.is_dir()) {
        let problem = anyhow!("{}: no directory of recordings", data.display());
        return Err(problem.context(BadInput));
    }
    let (task, base) = experiment_of(args)?;
    ensure!(
        base.trains_on_recordings(),
        "config field `data.source`: a network that is to learn from events trains on recordings"
    );
    let seeds = args.seeds.all(base.seed())?;
    let directory = args.study.directory();
    say(format!("network: {}", base.description()));
    say(format!("verdict: {} {}", models.findings.verdict, models.findings.effects.join(", ")));
    let files = models.files();
    let mut inputs: Vec<_> =
        files.iter().map(|(name, text)| (name.as_str(), text.clone())).collect();
    inputs.push((CONFIG, base.to_toml()?));
    let plan = StudyPlan {
        args: &args.study,
        seed: base.seed(),
        inputs,
        rows: study::strings(models.trained.iter().map(|model| model.name)),
        seeds: study::seed_names(&seeds),
        files: ["payoff.json", "payoff.md", "report.html"],
    };
    let study = PayoffStudy { args, task, base: &*base, models, seeds, directory, started };
    plan.run(&study).map(|_| ())
}

struct PayoffStudy<'a> {
    args: &'a PayoffArgs,
    task: &'static dyn PoseTask,
    base: &'a dyn PoseExperiment,
    models: Models,
    seeds: Vec<u64>,
    directory: StudyDirectory,
    started: Instant,
}

#[derive(Debug, Serialize, Deserialize)]
struct Trained {
    /// Duration of the training in the process that ended it.
    seconds: f64,
}

impl PayoffStudy<'_> {
    fn trial(&self, (model, seed): TrialIndex) -> PathBuf {
        let model = self.models.trained[model].name;
        self.directory.path(&format!("seed-{}/{model}", self.seeds[seed]))
    }

    /// The directory of the recordings of the measured camera.
    fn recordings(&self) -> PathBuf {
        // Real recordings come first.
        self.args.data.clone().unwrap_or_else(|| self.directory.path("held-out"))
    }

    fn scores(&self, model: usize) -> Result<ModelScores> {
        let (name, recordings) = (self.models.trained[model].name, self.recordings());
        let device = self.args.study.device.device.resolve()?;
        let of_seed = |seed: usize| {
            say(format!(
                "{name}, seed {}: evaluating on {}",
                self.seeds[seed],
                recordings.display()
            ));
            let opened = self.task.open(&self.trial((model, seed)).join(NETWORK), &device)?;
            opened.network()?.scores(&recordings, self.args.stride_ms)
        };
        let by_seed = (0..self.seeds.len()).map(of_seed).collect::<Result<_>>()?;
        Ok(ModelScores { model: name, by_seed })
    }
}

/// Training run of a trial.
const NETWORK: &str = "network";

impl Study for PayoffStudy<'_> {
    type Trial = Trained;
    type Outcome = Payoff;

    fn path(&self, (model, seed): TrialIndex) -> String {
        format!("seed-{}/{}/trained.json", self.seeds[seed], self.models.trained[model].name)
    }

    fn is_current(&self, trial: TrialIndex, _: &Trained) -> Result<bool> {
        Ok(self.trial(trial).join(NETWORK).join(BEST).exists())
    }

    fn prepare(&self, _: &[TrialIndex]) -> Result<()> {
        let Some(camera) = self.models.camera.as_ref().filter(|_| self.args.data.is_none()) else {
            return Ok(());
        };
        say("held-out recordings of the measured camera");
        let (held_out, experiment) = (self.recordings(), self.base.held_out().with_sensor(camera));
        study::simulate(&*experiment, &held_out, CAMERA)
    }

    fn run(&self, trial: TrialIndex) -> Result<(Trained, String)> {
        let (model, seed) = (&self.models.trained[trial.0], self.seeds[trial.1]);
        // The same experiment: only the sensor's model differs.
        let experiment = self.base.with_seed(seed).with_sensor(&model.sensor);
        let (data, network) = (self.trial(trial).join("data"), self.trial(trial).join(NETWORK));
        study::simulate(&*experiment, &data, model.name)?;
        let began = Instant::now();
        let (progress, callback) = training_bar(model.name);
        let options = study::options(self.args.study.device.device, callback);
        let trained = experiment.train(&data, &network, &options);
        progress.finish_and_clear();
        trained.with_context(|| format!("training in {}", network.display()))?;
        let seconds = began.elapsed().as_secs_f64();
        Ok((Trained { seconds }, format!("trained in {seconds:.0} s")))
    }

    fn outcome(&self, trials: &Trials<Trained>) -> Result<Written<Payoff>> {
        // Differences are paired: before all models are trained there is nothing to subtract.
        if trials.len() < self.models.trained.len() {
            return Ok(None);
        }
        let scores =
            (0..trials.len()).map(|model| self.scores(model)).collect::<Result<Vec<_>>>()?;
        let payoff = Payoff {
            schema: SCHEMA,
            task: self.task.name(),
            network: self.base.description(),
            models: self.models.trained.iter().map(|model| model.name).collect(),
            seeds: self.seeds.clone(),
            evaluated_on: self.recordings().display().to_string(),
            stride_ms: self.args.stride_ms,
            table: PairedTable::new(&scores, &self.base.bootstrap())?,
            gap: self.models.findings.clone(),
            commit: COMMIT,
            machine: Machine::this(),
            elapsed_s: self.started.elapsed().as_secs_f64(),
        };
        let mut details = self.models.files();
        details.push((CONFIG.to_owned(), self.base.to_toml()?));
        let report = report::report(&payoff, details)?;
        Ok(Some((payoff, report)))
    }
}

fn experiment_of(args: &PayoffArgs) -> Result<(&'static dyn PoseTask, Box<dyn PoseExperiment>)> {
    /// The task without --task and --config.
    const USUAL: &str = "hand";
    let start = args.start_from.as_deref().map_or(StartWeights::Initial, StartWeights::Run);
    match (&args.task, &args.config) {
        // Without --task, the config itself says of which task it is.
        (None, Some(config)) => experiment(&args.study.config(config), start),
        (task, config) => {
            let task = task_by_name(task.as_deref().unwrap_or(USUAL))?;
            let studied = task.studied()?;
            let config = args.study.config(config.as_deref().unwrap_or(studied.quick_config()));
            Ok((task, studied.experiment(&config, start)?))
        }
    }
}
