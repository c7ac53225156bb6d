//! Micro-benchmarks on one core, interleaved with peer programs on the same input.

mod command;

use std::time::Instant;

use anyhow::{Result, bail};
use serde::Serialize;

pub use command::PeerCommand;

use crate::all::Figure;
use evpose_cli::progress::say;
use evpose_core::stats::quantile::{nearest_rank, outlier_count};

/// The contract of a peer, for help texts.
pub(crate) const PEERS: &str = "A peer is a shell command. It reads the files of the benchmark in the folder \
    $EVPOSE_BENCH and prints `CASE: VALUE` for the cases that it supports, in the unit of the case.";

/// A timed function.
pub(crate) type Run = Box<dyn FnMut() -> Result<()>>;

/// A benchmark case and its peers.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) unit: Unit,
    pub(crate) run: Run,
    pub(crate) peers: Vec<(&'static str, Run)>,
}

impl Case {
    /// A case that processes `events` events per pass.
    pub(crate) fn of_events(name: impl Into<String>, events: usize, run: Run) -> Self {
        Self { name: name.into(), unit: Unit::Events(events), run, peers: Vec::new() }
    }

    /// A case that renders one input per pass.
    pub(crate) fn of_image(name: impl Into<String>, run: Run) -> Self {
        Self { name: name.into(), unit: Unit::Image, run, peers: Vec::new() }
    }

    /// Adds a peer that does the same work.
    pub(crate) fn with_peer(mut self, peer: &'static str, run: Run) -> Self {
        self.peers.push((peer, run));
        self
    }
}

/// The cases whose names contain all of these words, ignoring case.
///
/// # Errors
/// If there are none.
pub(crate) fn matching(mut cases: Vec<Case>, words: &[String]) -> Result<Vec<Case>> {
    let names: Vec<String> = cases.iter().map(|case| case.name.clone()).collect();
    cases.retain(|case| is_named(&case.name, words));
    if cases.is_empty() {
        bail!(
            "no case has `{}` in its name; there are\n  {}",
            words.join("` and `"),
            names.join("\n  ")
        );
    }
    Ok(cases)
}

/// Whether a name contains all of these words, ignoring case.
pub(crate) fn is_named(name: &str, words: &[String]) -> bool {
    let name = name.to_lowercase();
    words.iter().all(|word| name.contains(&word.to_lowercase()))
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Unit {
    /// Millions of events per second, for so many events per pass.
    Events(usize),
    /// Microseconds.
    Image,
}

impl Unit {
    fn value(self, seconds: f64) -> f64 {
        match self {
            Self::Events(events) => events as f64 / seconds / 1e6,
            Self::Image => seconds * 1e6,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Events(_) => "M events/s",
            Self::Image => "µs",
        }
    }

    /// Speed of ours relative to the peer.
    fn ratio(self, ours: f64, theirs: f64) -> f64 {
        match self {
            Self::Events(_) => ours / theirs,
            Self::Image => theirs / ours,
        }
    }
}

#[derive(Debug, Serialize)]
pub(crate) struct CaseResult {
    case: String,
    unit: &'static str,
    /// Value of the median pass.
    value: f64,
    passes: usize,
    outliers: usize,
    peers: Vec<Peer>,
    #[serde(skip)]
    kind: Unit,
}

#[derive(Debug, Serialize)]
struct Peer {
    name: String,
    value: f64,
    /// Speed of ours relative to the peer.
    ratio: f64,
}

/// Times all cases, ours and their peers interleaved, and prints the results.
pub(crate) fn time(cases: Vec<Case>, passes: usize) -> Result<Vec<CaseResult>> {
    let mut lines = Vec::new();
    for mut case in cases {
        let mut times_s = vec![Vec::new(); 1 + case.peers.len()];
        // The first pass fills caches and allocates reused buffers; it is not timed.
        for pass in 0..=passes.max(1) {
            // Ours and the peers alternate, so that drift of the machine favours nobody.
            let others = case.peers.iter_mut().map(|(_, run)| run);
            for (run, times_s) in [&mut case.run].into_iter().chain(others).zip(&mut times_s) {
                let begin = Instant::now();
                run()?;
                if pass > 0 {
                    times_s.push(begin.elapsed().as_secs_f64());
                }
            }
        }
        times_s.iter_mut().for_each(|times| times.sort_by(f64::total_cmp));
        let value = |times: &[f64]| case.unit.value(nearest_rank(times, 0.5));
        let mut line = CaseResult {
            value: value(&times_s[0]),
            passes: times_s[0].len(),
            outliers: outlier_count(&times_s[0]),
            unit: case.unit.name(),
            kind: case.unit,
            case: case.name,
            peers: Vec::new(),
        };
        say(format!("{:46} {:9.1} {}", line.case, line.value, line.unit));
        for ((name, _), times) in case.peers.iter().zip(&times_s[1..]) {
            line.add((*name).to_owned(), value(times));
        }
        lines.push(line);
    }
    Ok(lines)
}

/// Runs peer commands on the files in `folder`, and adds their results to ours.
pub(crate) fn run_peers(
    peers: &[PeerCommand],
    folder: &std::path::Path,
    lines: &mut [CaseResult],
) -> Result<()> {
    for peer in peers {
        for (case, value) in peer.results(folder)? {
            // A peer may measure more than was asked for, which is no error.
            match lines.iter_mut().find(|line| line.case == case) {
                Some(line) => {
                    say(format!("{:46} {:9.1} {}", line.case, line.value, line.unit));
                    line.add(peer.name.clone(), value);
                }
                None => say(format!("warning   {}: there is no case `{case}`", peer.name)),
            }
        }
    }
    Ok(())
}

/// Warns if many passes were outliers.
pub(crate) fn warn_under_load(lines: &[CaseResult]) {
    if lines.iter().any(|line| line.outliers * 5 > line.passes) {
        say("warning   many passes were outliers: the machine was under load, measure again");
    }
}

impl CaseResult {
    pub(crate) fn figure(&self, benchmark: &str) -> Figure {
        let figure = match self.kind {
            Unit::Events(_) => Figure::rate(benchmark, &self.case, self.unit, self.value),
            Unit::Image => Figure::time(benchmark, &self.case, self.unit, self.value),
        };
        self.peers.iter().fold(figure, |figure, peer| figure.beside(&peer.name, peer.value))
    }

    pub(crate) fn is_of(&self, case: &str) -> bool {
        self.case == case
    }

    pub(crate) fn passes_per_second(&self) -> f64 {
        match self.kind {
            Unit::Events(events) => self.value * 1e6 / events as f64,
            Unit::Image => 1e6 / self.value,
        }
    }

    fn add(&mut self, name: String, value: f64) {
        let ratio = self.kind.ratio(self.value, value);
        say(format!("  {:44} {value:9.1} {}, ours {ratio:.1} times as fast", name, self.unit));
        self.peers.push(Peer { name, value, ratio });
    }
}
