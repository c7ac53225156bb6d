//! Training of networks of bodies, several at once.
//!
//! One training does not use many cores well: the work between its large operations is
//! single-threaded. Two trainings on one thread each finish a quarter sooner than one after the
//! other on both threads, so every training has its share of the threads.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::{Context, Result};
use evpose_nn::DeviceKind;
use evpose_train::body::{BodyFrames, train_body};
use evpose_train::{ProgressCallback, TrainOptions};
use indicatif::ProgressBar;
use serde::{Deserialize, Serialize};

use super::Network;
use super::Stages;
use evpose_cli::json::{read_result, write_result};
use evpose_cli::progress::{bar, say};
use evpose_cli::recorded;

/// A chain of trainings: a network, and those that start from it.
type Chain = (Vec<Network>, Stages);

/// State shared by the workers.
struct TrainingQueue<'a> {
    out: &'a Path,
    /// Data to train on, instead of that of a seed.
    given: Option<&'a Path>,
    device: DeviceKind,
    /// Progress in images over all trainings.
    progress: ProgressBar,
    queue: Mutex<VecDeque<Chain>>,
}

/// Trains networks, and those that they start from, under the seeds of `stages`, `jobs` at once.
/// Finished networks are kept. The second stage is trained on `given`, or on the recordings of a seed,
/// which are simulated where they are missing.
///
/// # Errors
/// If a network cannot be trained, or the directory is of another config.
pub fn train_all(
    out: &Path,
    networks: &[Network],
    stages: &[Stages],
    (jobs, device): (usize, DeviceKind),
    given: Option<&Path>,
) -> Result<()> {
    // Before networks are trained side by side, two of which would simulate the same recordings.
    if given.is_none() {
        for stages in stages {
            recorded::prepare(&stages.finetune, &train_data(out, stages.finetune.seed))?;
        }
    }
    let queue = queue(out, networks, stages);
    let missing: Vec<&Network> = queue.iter().flat_map(|(chain, _)| chain).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let images = |stages: &Stages, network: Network| {
        let training = network.config(stages).training;
        training.steps * training.batch_size as u64
    };
    let all = queue.iter().flat_map(|(chain, s)| chain.iter().map(|n| images(s, *n))).sum();
    let jobs = jobs.clamp(1, queue.len());
    let threads = (rayon::current_num_threads() / jobs).max(1);
    say(format!("{} networks to train, {jobs} at once, threads of each: {threads}", missing.len()));
    let progress = bar("training", all, "images");
    let trainings = TrainingQueue { out, given, device, progress, queue: Mutex::new(queue) };
    let results: Vec<Result<()>> = std::thread::scope(|scope| {
        let worker = || {
            // A pool of its own: the global one would mix the work of all networks.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
            pool.install(|| trainings.work())
        };
        let workers: Vec<_> = (0..jobs).map(|_| scope.spawn(worker)).collect();
        let joined = workers.into_iter().map(|worker| worker.join());
        // A panic of a worker is one of the study.
        joined.map(|ended| ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    });
    trainings.progress.finish_and_clear();
    results.into_iter().collect()
}

/// Number of concurrent trainings: as asked for, else one per thread of the CPU, at most four, and one
/// on other devices.
#[must_use]
pub fn concurrent(jobs: Option<u16>, device: DeviceKind) -> usize {
    match (jobs, device) {
        (Some(jobs), _) => usize::from(jobs),
        (None, DeviceKind::Flex) => rayon::current_num_threads().min(4),
        (None, _) => 1,
    }
}

/// Chains of untrained networks, the longest first, which shortens the time in which workers are
/// idle.
fn queue(out: &Path, networks: &[Network], stages: &[Stages]) -> VecDeque<Chain> {
    let mut chains: Vec<Vec<Network>> = Vec::new();
    for &network in networks {
        // Networks with the same beginning form a chain behind it: it is trained once.
        let first = network.starts_from().unwrap_or(network);
        let chain = match chains.iter_mut().find(|chain| chain[0] == first) {
            Some(chain) => chain,
            None => {
                chains.push(vec![first]);
                chains.last_mut().expect("just pushed")
            }
        };
        if !chain.contains(&network) {
            chain.push(network);
        }
    }
    let missing = |chain: &[Network], seed: u64| -> Vec<Network> {
        let is_missing = |n: &Network| !is_finished(&directory(out, n.name(), seed));
        chain.iter().copied().filter(is_missing).collect()
    };
    let mut queue: Vec<Chain> = chains
        .iter()
        .flat_map(|chain| stages.iter().map(move |s| (missing(chain, s.finetune.seed), s.clone())))
        .filter(|(chain, _)| !chain.is_empty())
        .collect();
    queue.sort_by_key(|(chain, _)| std::cmp::Reverse(chain.len()));
    queue.into()
}

impl TrainingQueue<'_> {
    /// Trains chains until the queue is empty. A failure clears the queue.
    fn work(&self) -> Result<()> {
        loop {
            let next = self.queue.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
            let Some((chain, stages)) = next else { return Ok(()) };
            for network in chain {
                if let Err(error) = self.train(network, &stages) {
                    self.queue.lock().unwrap_or_else(PoisonError::into_inner).clear();
                    return Err(error);
                }
            }
        }
    }

    fn train(&self, network: Network, stages: &Stages) -> Result<()> {
        let began = Instant::now();
        let seed = stages.finetune.seed;
        let run = directory(self.out, network.name(), seed);
        let mut config = network.config(stages);
        config.start_from =
            network.starts_from().map(|first| directory(self.out, first.name(), seed));
        let data = self.given.map_or_else(|| train_data(self.out, seed), Path::to_owned);
        let frames = BodyFrames::load(&config, &data, &|_| {})?;
        // Resumes, so that an interrupted study goes on with the network that it was at.
        let options = TrainOptions {
            device: self.device,
            resume: true,
            plain: true,
            progress: Some(self.progress_callback()),
            pause_after: None,
        };
        let summary = train_body(&config, frames, &run, &options)
            .with_context(|| format!("training {}", run.display()))?;
        // Without new samples the network was finished before, and no speed was measured.
        let all = config.training.steps as f64 * config.training.batch_size as f64;
        mark_finished(&run, (summary.samples > 0).then(|| all / summary.samples_per_second))?;
        self.progress.suspend(|| {
            say(format!(
                "    {}, seed {seed}: trained in {:.1} min, {:.0} images/s",
                network.name(),
                began.elapsed().as_secs_f64() / 60.0,
                summary.samples_per_second
            ));
        });
        Ok(())
    }

    /// A callback that advances the bar by the samples of one training.
    fn progress_callback(&self) -> ProgressCallback {
        let (bar, counted) = (self.progress.clone(), Mutex::new(0));
        ProgressCallback::new(move |progress| {
            let mut counted = counted.lock().unwrap_or_else(PoisonError::into_inner);
            bar.inc(progress.samples.saturating_sub(*counted));
            *counted = progress.samples;
        })
    }
}

/// Directory of a network's run.
#[must_use]
pub fn directory(out: &Path, network: &str, seed: u64) -> PathBuf {
    out.join("networks").join(network).join(format!("seed-{seed}"))
}

/// Directory of the recordings to train on, of a seed.
#[must_use]
pub fn train_data(out: &Path, seed: u64) -> PathBuf {
    out.join("data").join(format!("seed-{seed}")).join("train")
}

/// File with the duration of a training, which marks a finished network.
const TRAINED: &str = "trained.json";

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Trained {
    seconds: Option<f64>,
}

/// Whether a network is finished.
#[must_use]
pub fn is_finished(run: &Path) -> bool {
    run.join(TRAINED).exists()
}

/// Marks a network as finished, with the duration of its training in seconds.
///
/// # Errors
/// If the mark cannot be written.
pub fn mark_finished(run: &Path, seconds: Option<f64>) -> Result<()> {
    write_result(&run.join(TRAINED), &Trained { seconds })
}

/// Duration of the training of a finished network in seconds; none if it was interrupted.
///
/// # Errors
/// If its file cannot be read.
pub fn training_s(run: &Path) -> Result<Option<f64>> {
    let trained: Option<Trained> = read_result(&run.join(TRAINED))?;
    Ok(trained.and_then(|trained| trained.seconds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ablate::bodies::rows;

    #[test]
    fn every_network_is_trained_once_and_after_the_one_it_starts_from() {
        let stages = Stages {
            pretrain: evpose_task::body::BodyConfig::default(),
            finetune: evpose_task::body::BodyConfig::default(),
        };
        let networks: Vec<Network> = rows::ROWS.iter().map(|row| row.network).collect();
        let queue = queue(Path::new("nowhere"), &networks, &[stages]);
        let mut before: Vec<Network> = Vec::new();
        for (chain, _) in queue {
            for network in chain {
                assert!(!before.contains(&network), "{network:?} twice");
                if let Some(first) = network.starts_from() {
                    assert!(before.contains(&first), "{network:?} before {first:?}");
                }
                before.push(network);
            }
        }
        assert!(rows::ROWS.iter().all(|row| before.contains(&row.network)));
    }
}
