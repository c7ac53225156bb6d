//! Comparison with another runtime, in interleaved bursts of runs.
//!
//! A pair is a burst of ours and one of the peer; their order alternates from pair to pair, so that
//! drift of the machine favours neither. The medians of the bursts of a pair are compared.

use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Result, ensure};
use clap::ValueEnum as _;
use evpose_core::stats::bootstrap::{BootstrapConfig, bootstrap};
use evpose_core::stats::interval::Interval;
use evpose_infer::{Engine, Precision};
use evpose_nn::graph::Graph;
use serde::Serialize;

use super::noise::Noise;
use super::peers::{Job, Peer, PeerName, peer};
use super::precision::tolerance;
use crate::all::PeerFigure;
use evpose_cli::progress::say;
use evpose_core::stats::quantile;

/// Timed runs of a burst.
const RUNS: usize = 7;
/// Minimum number and time of warm-up runs, after which caches and clock frequency are in a steady
/// state and threads are awake, each on its own core.
const WARM_UP: usize = 2;
const WARM_UP_TIME: Duration = Duration::from_millis(30);
/// Pause before a burst, after which spinning threads of the other program are asleep.
const IDLE_TIME: Duration = Duration::from_millis(100);

#[derive(Debug, Serialize)]
pub(super) struct Comparison {
    peer: String,
    version: String,
    settings: String,
    /// Maximum difference of outputs, relative to the largest.
    difference: f64,
    pairs: usize,
    /// Runs of a burst.
    runs: usize,
    /// Medians over all bursts.
    ours_ms: f64,
    theirs_ms: f64,
    /// Time of the peer over ours: median over pairs with a 95 % bootstrap interval.
    ratio: Interval,
    ours_noise: Noise,
    theirs_noise: Noise,
}

impl Comparison {
    pub(super) fn figure(&self) -> PeerFigure {
        PeerFigure { name: self.peer.clone(), value: self.theirs_ms, ratio: self.ratio.estimate }
    }
}

/// A network and an input to compare on.
pub(super) struct PeerBenchmark<'a> {
    pub(super) graph: &'a Graph,
    /// Channels, rows and columns.
    pub(super) shape: [usize; 3],
    pub(super) image: &'a [f32],
    pub(super) precision: Precision,
    pub(super) pairs: usize,
}

impl PeerBenchmark<'_> {
    /// Compares with each of the peers.
    ///
    /// # Errors
    /// If a peer is not available, or its outputs differ from ours.
    pub(super) fn run(&self, engine: &mut Engine, names: &[PeerName]) -> Result<Vec<Comparison>> {
        if names.is_empty() {
            return Ok(Vec::new());
        }
        // Peers get the same network as a file, which they optimise in their own way.
        let model = evpose_infer::onnx::encoded(self.graph, self.shape)?;
        let job = Job {
            model: &model,
            shape: self.shape,
            image: self.image,
            threads: engine.threads(),
            precision: self.precision,
        };
        let mut compared = Vec::with_capacity(names.len());
        for name in names {
            let comparison = self.against(engine, &word(*name), &mut *peer(*name, &job)?)?;
            comparison.say();
            compared.push(comparison);
        }
        Ok(compared)
    }

    fn against(&self, engine: &mut Engine, name: &str, peer: &mut dyn Peer) -> Result<Comparison> {
        // Before any time is taken: a wrong answer can be arbitrarily fast.
        let difference = max_difference(engine.run(self.image), &peer.outputs()?);
        let limit = peer.tolerance(tolerance(self.precision));
        ensure!(
            difference <= limit,
            "{name}: outputs differ by {difference:.1e} of the largest, \
             more than {limit:.0e}"
        );
        let (mut ours_ms, mut theirs_ms) = (Vec::new(), Vec::new());
        for pair in 0..self.pairs {
            // Who begins alternates: the second finds the processor in another state.
            for order in 0..2 {
                if (pair + order) % 2 == 0 {
                    let run = || {
                        std::hint::black_box(engine.run(self.image));
                        Ok(())
                    };
                    ours_ms.push(burst_ms(run)?);
                } else {
                    theirs_ms.push(burst_ms(|| peer.run())?);
                }
            }
        }
        Ok(Comparison {
            peer: name.to_owned(),
            version: peer.version().to_owned(),
            settings: peer.settings().to_owned(),
            difference,
            pairs: self.pairs,
            runs: RUNS,
            ours_ms: median(ours_ms.clone()),
            theirs_ms: median(theirs_ms.clone()),
            ratio: ratio(&ours_ms, &theirs_ms),
            ours_noise: Noise::from_times(&ours_ms),
            theirs_noise: Noise::from_times(&theirs_ms),
        })
    }
}

/// Median time of a burst.
fn burst_ms(mut run: impl FnMut() -> Result<()>) -> Result<f64> {
    // Threads of the other runtime spin for a while after its burst.
    sleep(IDLE_TIME);
    let begin = Instant::now();
    let mut runs = 0;
    // Runs fill the caches, time lets clock frequencies rise: each has a minimum.
    while runs < WARM_UP || begin.elapsed() < WARM_UP_TIME {
        run()?;
        runs += 1;
    }
    let mut times_ms = Vec::with_capacity(RUNS);
    for _ in 0..RUNS {
        let begin = Instant::now();
        run()?;
        times_ms.push(begin.elapsed().as_secs_f64() * 1e3);
    }
    // The median: an interruption by the system slows single runs down.
    Ok(median(times_ms))
}

/// Median over pairs of their time over ours.
fn ratio(ours: &[f64], theirs: &[f64]) -> Interval {
    let ratios: Vec<f64> = theirs.iter().zip(ours).map(|(theirs, ours)| theirs / ours).collect();
    // Pairs are resampled, not bursts: both bursts of a pair met the same machine.
    bootstrap(ratios.len(), &BootstrapConfig::default(), |drawn| {
        median(drawn.iter().map(|pair| ratios[*pair]).collect())
    })
}

/// The median of some times; NaN of none.
fn median(mut values: Vec<f64>) -> f64 {
    quantile::median(&mut values).unwrap_or(f64::NAN)
}

/// Maximum relative difference over all outputs.
pub(super) fn max_difference(ours: &[Vec<f32>], theirs: &[Vec<f32>]) -> f64 {
    if ours.len() != theirs.len() {
        return f64::INFINITY;
    }
    ours.iter()
        .zip(theirs)
        .map(|(ours, theirs)| output_difference(ours, theirs))
        .fold(0.0, f64::max)
}

/// Maximum difference of an output, relative to its largest value.
fn output_difference(ours: &[f32], theirs: &[f32]) -> f64 {
    if ours.len() != theirs.len() {
        return f64::INFINITY;
    }
    let largest = theirs.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
    let differences = ours.iter().zip(theirs).map(|(ours, theirs)| (ours - theirs).abs());
    // NaN counts as an infinite difference: once found, it stays, since no value compares with it.
    let larger = |most: f32, value| if most.is_nan() || value <= most { most } else { value };
    let most = differences.fold(0.0, larger);
    if most.is_nan() { f64::INFINITY } else { f64::from(most) / f64::from(largest) }
}

fn word(name: PeerName) -> String {
    name.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
}

impl Comparison {
    pub(super) fn say(&self) {
        say(format!("  against {} {}", self.peer, self.version));
        say(format!("    {}; outputs differ by {:.0e}", self.settings, self.difference));
        let Interval { estimate, low, high } = self.ratio;
        let bounds = match (low, high) {
            (Some(low), Some(high)) => format!(" [{low:.3}, {high:.3}]"),
            _ => String::new(),
        };
        say(format!(
            "    {:.2} ms, ours {:.2} ms: {estimate:.3} times ours{bounds}, {} pairs",
            self.theirs_ms, self.ours_ms, self.pairs
        ));
        for (whose, noise) in [("ours", self.ours_noise), ("theirs", self.theirs_noise)] {
            if let Some(warning) = noise.warning() {
                say(format!(
                    "    warning: {whose}: {warning}: the machine was under load, measure again"
                ));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_is_the_median_of_pairs() {
        // A machine that is twice as slow in the middle disturbs both of a pair.
        let ours: Vec<f64> = (0..24).map(|pair| if pair % 3 == 0 { 20.0 } else { 10.0 }).collect();
        let theirs: Vec<f64> = ours.iter().map(|ours| 1.5 * ours).collect();
        let Interval { estimate, low, high } = ratio(&ours, &theirs);
        assert_eq!((estimate, low, high), (1.5, Some(1.5), Some(1.5)));
    }

    #[test]
    fn the_median_of_an_even_count_is_the_midpoint() {
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
    }

    #[test]
    fn nan_and_missing_outputs_have_an_infinite_difference() {
        assert_eq!(output_difference(&[1.0, 2.5], &[1.0, 2.0]), 0.25);
        assert_eq!(output_difference(&[f32::NAN, 1.0], &[2.0, 1.0]), f64::INFINITY);
        assert_eq!(output_difference(&[1.0], &[1.0, 2.0]), f64::INFINITY);
    }
}
