//! Figures of all benchmarks in one form.

use serde::{Deserialize, Serialize};

/// One figure, beside peers and the limit of the machine.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Figure {
    /// The benchmark that measured it: `infer`, `repr`, …
    pub(crate) benchmark: String,
    /// The work that was measured.
    pub(crate) work: String,
    pub(crate) unit: String,
    pub(crate) lower_is_better: bool,
    /// Ours.
    pub(crate) value: f64,
    /// The value at which the machine would be the limit, if there is one: arithmetic at its measured peak, or
    /// memory at its measured bandwidth.
    pub(crate) limit: Option<f64>,
    /// Peers in the same run.
    pub(crate) peers: Vec<PeerFigure>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PeerFigure {
    pub(crate) name: String,
    pub(crate) value: f64,
    /// Speed of ours relative to the peer.
    pub(crate) ratio: f64,
}

impl Figure {
    /// A time, of which less is better.
    pub(crate) fn time(benchmark: &str, work: impl Into<String>, unit: &str, value: f64) -> Self {
        Self { lower_is_better: true, ..Self::rate(benchmark, work, unit, value) }
    }

    /// A rate, of which more is better.
    pub(crate) fn rate(benchmark: &str, work: impl Into<String>, unit: &str, value: f64) -> Self {
        Self {
            benchmark: benchmark.to_owned(),
            work: work.into(),
            unit: unit.to_owned(),
            lower_is_better: false,
            value,
            limit: None,
            peers: Vec::new(),
        }
    }

    /// Adds a peer by its value.
    pub(crate) fn beside(mut self, name: impl Into<String>, value: f64) -> Self {
        let ratio = self.speed_over(value);
        self.peers.push(PeerFigure { name: name.into(), value, ratio });
        self
    }

    /// Speed of ours relative to another value of the same unit.
    pub(crate) fn speed_over(&self, other: f64) -> f64 {
        if self.lower_is_better { other / self.value } else { self.value / other }
    }

    /// Whether another run measured the same.
    pub(crate) fn is_same_work(&self, other: &Self) -> bool {
        (&self.benchmark, &self.work, &self.unit) == (&other.benchmark, &other.work, &other.unit)
    }
}

/// A number of threads, in words.
pub(crate) fn threads(count: usize) -> String {
    if count == 1 { "1 thread".to_owned() } else { format!("{count} threads") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_say_how_much_faster_ours_is() {
        let time = Figure::time("infer", "a network", "ms", 2.0).beside("other", 3.0);
        assert!((time.peers[0].ratio - 1.5).abs() < 1e-12);
        let rate = Figure::rate("repr", "a plane", "M events/s", 300.0).beside("other", 100.0);
        assert!((rate.peers[0].ratio - 3.0).abs() < 1e-12);
    }
}
