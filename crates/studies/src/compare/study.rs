//! `evpose compare body`, and `evpose ablate body`: all systems under all seeds.

use std::collections::BTreeMap;

use anyhow::{Result, bail};
use evpose_cli::progress::say;
use evpose_cli::shipped::sha256;
use evpose_nn::DeviceKind;
use serde::Serialize;

use crate::compare::args::{BodyStudyArgs, NetworkFiles};
use crate::compare::data::Data;
use crate::compare::ordering::Ordering;
use crate::compare::predictor::ReadySystem;
use crate::compare::stages::Stages;
use crate::compare::system::{DataSet, Figure, System, Weights};
use crate::compare::trial::{self, Candidate, Trial};
use crate::compare::{baselines, networks};
use crate::study::{
    self, Outcome, Study, StudyPlan, StudyReport, StudyRow, TrialIndex, Trials, VERDICTS, Written,
    metric, pck_charts,
};

/// Systems that are compared, and how they are called.
#[derive(Debug)]
pub(crate) struct Protocol {
    pub(crate) title: &'static str,
    /// Heading of the names of systems.
    pub(crate) system: &'static str,
    /// Folder of the results of trials.
    pub(crate) folder: &'static str,
    pub(crate) files: [&'static str; 3],
    pub(crate) orderings: &'static [Ordering],
    /// Note on the table of orderings.
    pub(crate) about_orderings: &'static str,
}

/// Why systems do not run, by their names.
type Missing = BTreeMap<&'static str, String>;

/// Trains, evaluates and writes what is missing of the systems `chosen`.
pub(crate) fn run(
    protocol: &'static Protocol,
    args: &BodyStudyArgs,
    chosen: Vec<&'static System>,
    data: Data,
    files: &NetworkFiles,
) -> Result<()> {
    args.study.open()?;
    let stages = data.stages(Stages::load(&args.stages, &args.study.overrides)?);
    // Before anything is simulated or trained.
    let missing = missing(files, &data, &chosen)?;
    let mut inputs = vec![("data.json", serde_json::to_string_pretty(&data)? + "\n")];
    inputs.extend(stages.inputs()?);
    // The first input is that of the data, which is no config.
    let configs: Vec<String> = inputs[1..].iter().map(|(_, config)| config.clone()).collect();
    let seeds = args.seeds.all(stages.finetune.seed)?;
    for (name, reason) in &missing {
        say(format!("{name} does not run: {reason}"));
    }
    let systems: Vec<&System> =
        chosen.iter().copied().filter(|system| !missing.contains_key(system.name)).collect();
    let digests = systems.iter().map(|system| files.of(system).map(sha256).transpose());
    let plan = StudyPlan {
        args: &args.study,
        seed: stages.finetune.seed,
        inputs,
        rows: study::strings(systems.iter().map(|system| system.name)),
        seeds: study::seed_names(&seeds),
        files: protocol.files,
    };
    let study = SystemStudy {
        protocol,
        args,
        data,
        files,
        weights: digests.collect::<Result<_>>()?,
        systems,
        chosen,
        missing,
        by_seed: seeds.iter().map(|&seed| stages.with_seed(seed)).collect(),
        seeds,
        configs: configs.join("\n"),
    };
    plan.run(&study).map(|_| ())
}

struct SystemStudy<'a> {
    protocol: &'static Protocol,
    args: &'a BodyStudyArgs,
    data: Data,
    files: &'a NetworkFiles,
    chosen: Vec<&'static System>,
    /// Those of them that run.
    systems: Vec<&'static System>,
    /// Digests of the files of their weights: a file may be replaced under the same name.
    weights: Vec<Option<String>>,
    missing: Missing,
    seeds: Vec<u64>,
    by_seed: Vec<Stages>,
    configs: String,
}

/// A system as tables see it.
#[derive(Debug, Serialize)]
pub(crate) struct SystemRow {
    name: &'static str,
    about: &'static str,
    images: &'static str,
    missing: Option<String>,
    published: &'static [Figure],
}

impl StudyRow for SystemRow {
    fn name(&self) -> &'static str {
        self.name
    }

    fn about(&self) -> &'static str {
        self.about
    }

    fn missing(&self) -> Option<&str> {
        self.missing.as_deref()
    }

    fn cells(&self) -> Vec<(&'static str, String)> {
        // `DHP19: PCK@0.4 0.97, …; eH3.6M: …`
        let of_set = |set: DataSet| {
            let figures = self.published.iter().filter(|figure| figure.data_set == set);
            let name = |key| metric::<Trial>(key).map_or(key, |metric| metric.heading);
            let figures: Vec<String> = figures
                .map(|figure| format!("{} {}", name(figure.measure), figure.value))
                .collect();
            (!figures.is_empty()).then(|| format!("{}: {}", set.name(), figures.join(", ")))
        };
        let sets = [DataSet::Dhp19, DataSet::Eh36m, DataSet::Online].into_iter();
        let published = sets.filter_map(of_set).collect::<Vec<_>>().join("; ");
        vec![("input", self.images.to_owned()), ("published", published)]
    }
}

impl Study for SystemStudy<'_> {
    type Trial = Trial;
    type Outcome = Outcome<SystemRow, Trial>;

    fn path(&self, (system, seed): TrialIndex) -> String {
        let (system, seed) = (self.systems[system].name, self.seeds[seed]);
        format!("{}/{system}/seed-{seed}.json", self.protocol.folder)
    }

    fn is_current(&self, (system, _): TrialIndex, stored: &Trial) -> Result<bool> {
        // Another file of weights is another system.
        Ok(stored.weights == self.weights[system])
    }

    fn prepare(&self, trials: &[TrialIndex]) -> Result<()> {
        let trials: Vec<(&System, &Stages)> = trials
            .iter()
            .map(|&(system, seed)| (self.systems[system], &self.by_seed[seed]))
            .collect();
        let directory = self.args.study.directory();
        // All networks are trained first, several at once; evaluation is short.
        let networks =
            trials.iter().filter_map(|(system, stages)| Some((system.network()?, *stages)));
        let jobs = networks::concurrent(self.args.jobs, self.device());
        let given = self.data.given_train();
        networks::train_all(&directory, networks, (jobs, self.device()), given)?;
        for (system, stages) in trials {
            // One after the other: each uses all threads.
            if let Weights::Baseline(kind) = system.weights {
                let baseline = (system.name, kind);
                baselines::train(baseline, &directory, &self.data, stages, self.device())?;
            }
        }
        Ok(())
    }

    fn run(&self, (index, seed): TrialIndex) -> Result<(Trial, String)> {
        let (system, stages) = (self.systems[index], &self.by_seed[seed]);
        let (study, file) = (&self.args.study.directory(), self.files.of(system));
        let candidate = Candidate { study, data: &self.data, system, file, stages };
        let trial = trial::run(&candidate, self.weights[index].clone())?;
        let line = format!("PCK@0.4 {:.3}, PCK@0.8 {:.3}", trial.pck[0], trial.pck[2]);
        Ok((trial, line))
    }

    fn outcome(&self, trials: &Trials<Trial>) -> Result<Written<Self::Outcome>> {
        let row = |system: &&System| {
            let missing = self.missing.get(system.name).cloned();
            let trials = trials.get(system.name).cloned();
            // A system without trials is shown with the reason.
            let trials = trials.or_else(|| missing.as_ref().map(|_| Vec::new()))?;
            let row = SystemRow {
                name: system.name,
                about: system.about,
                images: system.images.name(),
                missing,
                published: system.published,
            };
            Some((row, trials))
        };
        // Statements about systems that were not asked for are left out.
        let is_there = |name: &str| self.chosen.iter().any(|system| system.name == name);
        let orderings = self.protocol.orderings.iter();
        let orderings = orderings.filter(|o| is_there(o.system) && is_there(o.other));
        let findings = orderings.map(|ordering| ordering.finding(&self.chosen)).collect();
        let rows = self.chosen.iter().filter_map(row).collect();
        let outcome = Outcome::new(&self.seeds, self.data.words(), rows, findings);
        let report = self.report(&outcome)?;
        Ok(Some((outcome, report)))
    }
}

impl SystemStudy<'_> {
    fn device(&self) -> DeviceKind {
        self.args.study.device.device
    }

    fn report(&self, outcome: &Outcome<SystemRow, Trial>) -> Result<StudyReport> {
        let legend = format!(
            "Evaluated on {}. Means over seeds {} with 95% intervals of Student's t. PCK: share of the 13 joints \
             within a fraction of the torso's diagonal; MPJPE in pixels of the images; in mm of one camera for \
             systems that estimate depth, of others triangulated where the recordings have two calibrated cameras. \
             poses/s: from image to joints on one thread of {}, the representation not included. Published figures \
             are of other people before other cameras. Verdicts follow from the interval of the difference, seed by \
             seed: {VERDICTS}.",
            outcome.data,
            study::listed(&outcome.seeds),
            outcome.machines.join(" and "),
        );
        let rows = outcome.rows.iter();
        let curves: Vec<(&str, &[f64])> = rows
            .filter_map(|row| Some((row.row.name, row.curves.get("curve")?.as_slice())))
            .collect();
        Ok(StudyReport {
            title: self.protocol.title.to_owned(),
            about: "Trained and evaluated by evpose on this machine, on people that are in no training set."
                .to_owned(),
            tables: vec![
                outcome.all_rows(self.protocol.system, &legend),
                outcome.missing_rows(),
                outcome.all_findings(self.protocol.about_orderings),
                pck_charts(&curves)?,
            ],
            details: vec![
                ("Rows".to_owned(), outcome.descriptions()),
                ("Configs of both stages of MoveEnet".to_owned(), self.configs.clone()),
            ],
        })
    }
}

/// Systems that cannot be run, and why. A file that cannot be opened is an error.
fn missing(files: &NetworkFiles, data: &Data, systems: &[&'static System]) -> Result<Missing> {
    let mut missing = Missing::new();
    for system in systems {
        let missing_file = match (system.weights, files.of(system)) {
            (Weights::File(kind), None) => Some(kind.how_to_get().to_owned()),
            (Weights::File(kind), Some(path)) => {
                // Opened now: a wrong file should not end the study hours later.
                ReadySystem::file(kind, path)?;
                None
            }
            _ => None,
        };
        if let Some(reason) = missing_file.or_else(|| data.missing_input(system)) {
            missing.insert(system.name, reason);
        }
    }
    // Some systems may be missing, but not all.
    if missing.len() == systems.len() {
        let reasons: Vec<String> =
            missing.iter().map(|(name, reason)| format!("{name}: {reason}")).collect();
        bail!("no system can be run. {}", reasons.join("; "));
    }
    Ok(missing)
}
