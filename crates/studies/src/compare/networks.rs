//! Training of networks of bodies, several at once.
//!
//! One training does not use many cores well: the work between its large operations is
//! single-threaded. Two trainings on one thread each finish a quarter sooner than one after the
//! other on both threads, so every training has its share of the threads.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use anyhow::Result;
use evpose_nn::DeviceKind;
use evpose_task::body::BodyConfig;
use evpose_train::ProgressCallback;
use evpose_train::body::{BodyFrames, train_body};
use indicatif::ProgressBar;

use super::stages::{Network, Stages};
use crate::study::{StudyDirectory, Training, exclusively};
use evpose_cli::progress::{bar, say};
use evpose_cli::recorded;

pub(crate) const TRAIN: &str = "train";

/// A chain of trainings: a network, and those that start from it.
type Chain<'a> = (Vec<Network>, &'a Stages);

/// State shared by the workers.
struct TrainingQueue<'a> {
    directory: &'a StudyDirectory,
    /// Data to train on, instead of that of a seed.
    given: Option<&'a Path>,
    device: DeviceKind,
    progress: ProgressBar,
    queue: Mutex<VecDeque<Chain<'a>>>,
}

/// Trains networks, each under the seed of its stages, and those that they start from, `jobs` at once.
/// Finished networks are kept. The second stage is trained on `given`, or on the recordings of a seed,
/// which are simulated where they are missing.
pub(crate) fn train_all<'a>(
    directory: &'a StudyDirectory,
    networks: impl Iterator<Item = (Network, &'a Stages)>,
    (jobs, device): (usize, DeviceKind),
    given: Option<&'a Path>,
) -> Result<()> {
    let queue = queue(directory, networks);
    if queue.is_empty() {
        return Ok(());
    }
    // Before networks are trained side by side, two of which would simulate the same recordings.
    if given.is_none() {
        for (_, stages) in &queue {
            simulate(&stages.finetune, &directory.data(stages.finetune.seed, TRAIN))?;
        }
    }
    let missing: usize = queue.iter().map(|(chain, _)| chain.len()).sum();
    let all =
        queue.iter().flat_map(|(chain, s)| chain.iter().map(move |n| samples(&n.config(s)))).sum();
    let jobs = jobs.clamp(1, queue.len());
    let threads = (rayon::current_num_threads() / jobs).max(1);
    say(format!("{missing} networks to train, {jobs} at once, threads of each: {threads}"));
    let progress = bar("training", all, "images");
    let trainings = TrainingQueue { directory, given, device, progress, queue: Mutex::new(queue) };
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
pub(crate) fn concurrent(jobs: Option<u16>, device: DeviceKind) -> usize {
    match (jobs, device) {
        (Some(jobs), _) => usize::from(jobs),
        (None, DeviceKind::Flex) => rayon::current_num_threads().min(4),
        (None, _) => 1,
    }
}

/// Chains of untrained networks, the longest first, which shortens the time in which workers are
/// idle.
fn queue<'a>(
    directory: &StudyDirectory,
    networks: impl Iterator<Item = (Network, &'a Stages)>,
) -> VecDeque<Chain<'a>> {
    let mut chains: Vec<(Network, Chain<'a>)> = Vec::new();
    for (network, stages) in networks {
        // Networks with the same beginning form a chain behind it: it is trained once.
        let (first, seed) = (network.starts_from().unwrap_or(network), stages.finetune.seed);
        let is_it = |(other, chain): &(Network, Chain<'_>)| {
            *other == first && chain.1.finetune.seed == seed
        };
        let at = chains.iter().position(is_it).unwrap_or_else(|| {
            chains.push((first, (vec![first], stages)));
            chains.len() - 1
        });
        let chain = &mut chains[at].1.0;
        if !chain.contains(&network) {
            chain.push(network);
        }
    }
    for (_, (chain, stages)) in &mut chains {
        let run =
            |network: &Network| self::directory(directory, network.name(), stages.finetune.seed);
        chain.retain(|network| !Training::is_finished(&run(network)));
    }
    let mut queue: Vec<Chain<'a>> = chains.into_iter().map(|(_, chain)| chain).collect();
    queue.retain(|(chain, _)| !chain.is_empty());
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
                if let Err(error) = self.train(network, stages) {
                    // Others finish the training at hand, which a later start finds.
                    self.queue.lock().unwrap_or_else(PoisonError::into_inner).clear();
                    return Err(error);
                }
            }
        }
    }

    fn train(&self, network: Network, stages: &Stages) -> Result<()> {
        let began = Instant::now();
        let seed = stages.finetune.seed;
        let directory = |network: Network| directory(self.directory, network.name(), seed);
        let run = directory(network);
        let mut config = network.config(stages);
        config.start_from = network.starts_from().map(directory);
        let data = self.given.map_or_else(|| self.directory.data(seed, TRAIN), Path::to_owned);
        let training = Training { run: &run, device: self.device, samples: samples(&config) };
        let trained = training.once(self.progress_callback(), |options| {
            let frames = BodyFrames::load(&config, &data, &|_| {})?;
            Ok(train_body(&config, frames, &run, options)?)
        })?;
        let minutes = began.elapsed().as_secs_f64() / 60.0;
        let speed = trained.map_or_else(String::new, |speed| format!(", {speed:.0} images/s"));
        // The bar is suspended, or it would be drawn into the line.
        self.progress.suspend(|| {
            say(format!("    {}, seed {seed}: trained in {minutes:.1} min{speed}", network.name()));
        });
        Ok(())
    }

    fn progress_callback(&self) -> ProgressCallback {
        let (bar, counted) = (self.progress.clone(), Mutex::new(0));
        ProgressCallback::new(move |progress| {
            let mut counted = counted.lock().unwrap_or_else(PoisonError::into_inner);
            // A training counts from its own start, while the bar runs over all of them.
            bar.inc(progress.samples.saturating_sub(*counted));
            *counted = progress.samples;
        })
    }
}

pub(crate) fn directory(study: &StudyDirectory, network: &str, seed: u64) -> PathBuf {
    study.path(&format!("networks/{network}/seed-{seed}"))
}

/// Simulates the recordings of `config` where they are missing, by one shard while others wait.
pub(crate) fn simulate(config: &BodyConfig, data: &Path) -> Result<()> {
    exclusively(data, || recorded::prepare(config, data))
}

fn samples(config: &BodyConfig) -> u64 {
    config.training.steps * config.training.batch_size as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::system::SYSTEMS;

    #[test]
    fn every_network_is_trained_once_and_after_the_one_it_starts_from() {
        let stages = Stages { pretrain: BodyConfig::default(), finetune: BodyConfig::default() };
        let networks: Vec<Network> = SYSTEMS.iter().filter_map(|system| system.network()).collect();
        let directory = StudyDirectory::new(Path::new("nowhere"));
        let queue = queue(&directory, networks.iter().map(|network| (*network, &stages)));
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
        assert!(networks.iter().all(|network| before.contains(network)));
    }
}
