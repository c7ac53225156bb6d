//! Simulates, trains and evaluates.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail, ensure};
use evpose_cli::bad_input::BadInput;
use evpose_cli::json::write_json;
use evpose_cli::machine::Machine;
use evpose_cli::progress::{say, training_bar};
use evpose_cli::run_info::{COMMIT, CONFIG};
use evpose_cli::tasks::{
    EvaluationScores, PoseExperiment, PoseTask, StartWeights, experiment, task_by_name,
};
use evpose_train::TrainOptions;
use serde::Serialize;

use crate::payoff::args::PayoffArgs;
use crate::payoff::directory::StudyDirectory;
use crate::payoff::models::{CAMERA, Findings, Models, NamedModel};
use crate::payoff::table::{ModelScores, PairedTable};
use crate::payoff::{page, text};
use crate::study;

/// Version of the layout of `payoff.json`.
const SCHEMA: u32 = 1;
const JSON: &str = "payoff.json";
const PAGE: &str = "report.html";

/// The result of a study, as `payoff.json` holds it.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Payoff {
    schema: u32,
    /// The gap run.
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
    let inputs = inputs(&*base, &models)?;
    let directory = StudyDirectory::open(&args.study.out, base.seed(), &inputs, args.study.resume)?;
    args.study.say_place();
    say(format!("network: {}", base.description()));
    say(format!("verdict: {} {}", models.findings.verdict, models.findings.effects.join(", ")));
    let recordings = recordings(args, &*base, &models, &directory)?;

    let mut scores: Vec<ModelScores> = models
        .trained
        .iter()
        .map(|model| ModelScores { model: model.name, by_seed: Vec::new() })
        .collect();
    // Seed after seed: an interrupted study has all networks of the first seeds.
    for &seed in &seeds {
        for (model, scores) in models.trained.iter().zip(&mut scores) {
            let study = Trial { args, task, experiment: base.with_seed(seed), seed };
            scores.by_seed.push(study.run(model, &directory, &recordings)?);
        }
    }

    let payoff = Payoff {
        schema: SCHEMA,
        task: task.name(),
        network: base.description(),
        models: models.trained.iter().map(|model| model.name).collect(),
        seeds,
        evaluated_on: recordings.display().to_string(),
        stride_ms: args.stride_ms,
        table: PairedTable::new(&scores, &base.bootstrap())?,
        gap: models.findings.clone(),
        commit: COMMIT,
        machine: Machine::this(),
        elapsed_s: started.elapsed().as_secs_f64(),
    };
    let html = page::html(&payoff, &models.trained, &base.to_toml()?)?;
    let path = directory.result(PAGE);
    study::write(&path, &html)?;
    write_json(Some(&directory.result(JSON)), &payoff)?;
    say("");
    text::lines(&payoff).iter().for_each(say);
    say("");
    say(format!("done in {:.1} minutes", payoff.elapsed_s / 60.0));
    say(format!("values: {}", directory.result(JSON).display()));
    say(format!("report: {}", path.display()));
    Ok(())
}

/// The task and the experiment of the arguments.
fn experiment_of(args: &PayoffArgs) -> Result<(&'static dyn PoseTask, Box<dyn PoseExperiment>)> {
    /// The task without --task and --config.
    const USUAL: &str = "hand";
    let start = args.start_from.as_deref().map_or(StartWeights::Initial, StartWeights::Run);
    match (&args.task, &args.config) {
        (None, Some(config)) => experiment(&args.study.config(config), start),
        (task, config) => {
            let task = task_by_name(task.as_deref().unwrap_or(USUAL))?;
            let studied = task.studied()?;
            let config = args.study.config(config.as_deref().unwrap_or(studied.quick_config()));
            Ok((task, studied.experiment(&config, start)?))
        }
    }
}

/// The files that say what is compared.
fn inputs(base: &dyn PoseExperiment, models: &Models) -> Result<Vec<(String, String)>> {
    let file = |name: &str| format!("models/{name}.toml");
    let mut inputs = vec![(CONFIG.to_owned(), base.to_toml()?)];
    inputs.extend(models.trained.iter().map(|m| (file(m.name), m.sensor.to_toml())));
    if let Some(camera) = models.camera.as_ref().filter(|_| models.trained.len() < 3) {
        inputs.push((file(CAMERA), camera.to_toml()));
    }
    Ok(inputs)
}

/// The directory of the recordings of the measured camera, simulated where it is known.
fn recordings(
    args: &PayoffArgs,
    base: &dyn PoseExperiment,
    models: &Models,
    directory: &StudyDirectory<'_>,
) -> Result<PathBuf> {
    match (&args.data, &models.camera) {
        // Real recordings come first.
        (Some(data), _) => Ok(data.clone()),
        (None, Some(camera)) => {
            let held_out = directory.held_out();
            say("simulating held-out recordings of the measured camera");
            say(format!(
                "    {}",
                base.held_out().with_sensor(camera).simulate(&held_out, "camera")?
            ));
            Ok(held_out)
        }
        (None, None) => bail!("--data or --camera: recordings of the measured camera are needed"),
    }
}

/// One network: a model under a seed.
struct Trial<'a> {
    args: &'a PayoffArgs,
    task: &'static dyn PoseTask,
    experiment: Box<dyn PoseExperiment>,
    seed: u64,
}

impl Trial<'_> {
    fn run(
        &self,
        model: &NamedModel,
        directory: &StudyDirectory<'_>,
        recordings: &Path,
    ) -> Result<EvaluationScores> {
        let (name, seed) = (model.name, self.seed);
        let (data, network) = (directory.data(seed, name), directory.network(seed, name));
        // The same experiment: only the sensor's model differs.
        let experiment = self.experiment.with_sensor(&model.sensor);
        say(format!("model {name}, seed {seed}: simulating"));
        say(format!("    {}", experiment.simulate(&data, name)?));
        say(format!("model {name}, seed {seed}: training"));
        let began = Instant::now();
        let (progress, callback) = training_bar(name);
        let options = TrainOptions {
            device: self.args.study.device.device,
            resume: true,
            plain: true,
            progress: Some(callback),
            pause_after: None,
        };
        let trained = experiment.train(&data, &network, &options);
        progress.finish_and_clear();
        trained.with_context(|| format!("training in {}", network.display()))?;
        say(format!("    {:.0} s", began.elapsed().as_secs_f64()));
        say(format!("model {name}, seed {seed}: evaluating on {}", recordings.display()));
        // Read back from its directory: a resumed study may find it trained already.
        let opened = self.task.open(&network, &self.args.study.device.device.resolve()?)?;
        opened.network()?.scores(recordings, self.args.stride_ms)
    }
}
