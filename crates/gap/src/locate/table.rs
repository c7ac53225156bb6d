//! Event counts of every occupied class, of the recording and of each run.

use crate::View;

use super::axis::{Axis, TILES};

/// Contingency table over all axes, sparse: only classes that have events.
#[derive(Debug)]
pub(super) struct Table {
    /// Levels of each occupied class, one bit per axis.
    pub(super) keys: Vec<u64>,
    /// `counts[s][i]`: events of class `i` in the recording (`s = 0`) or in run `s`.
    counts: Vec<Vec<f64>>,
    /// Sums of counts over all runs.
    sums: Vec<f64>,
}

/// One stream against runs: the recording against all runs, or a run against the others.
#[derive(Debug, Clone)]
pub(super) struct Sample {
    pub(super) events: Vec<f64>,
    /// Sums of counts over the runs that it is compared with.
    pub(super) sums: Vec<f64>,
    pub(super) runs: f64,
}

impl Table {
    pub(super) fn from_views(streams: &[&View<'_>]) -> Self {
        let classes = Axis::ALL.iter().map(|axis| axis.count()).product();
        // By index, since a map would be asked for every event.
        let mut places = vec![u32::MAX; classes];
        let mut keys = Vec::new();
        let mut counts: Vec<Vec<f64>> = Vec::with_capacity(streams.len());
        for view in streams {
            let mut own = vec![0.0; keys.len()];
            for event in view.events() {
                let (mut class, mut key) = (0, 0);
                for axis in Axis::ALL {
                    let level = axis.level_of(event, view);
                    class = class * axis.count() + level;
                    key |= 1 << (axis.shift() as usize + level);
                }
                // Only classes with events are stored: most combinations of levels never occur.
                if places[class] == u32::MAX {
                    places[class] = keys.len() as u32;
                    keys.push(key);
                    own.push(0.0);
                }
                own[places[class] as usize] += 1.0;
            }
            counts.push(own);
        }
        // Later streams have added classes.
        for own in &mut counts {
            own.resize(keys.len(), 0.0);
        }
        let sum = |i: usize| counts[1..].iter().map(|run| run[i]).sum();
        let sums = (0..keys.len()).map(sum).collect();
        Self { keys, counts, sums }
    }

    pub(super) fn runs(&self) -> usize {
        self.counts.len() - 1
    }

    /// The recording (`0`) or a run, against the other runs.
    pub(super) fn sample(&self, stream: usize) -> Sample {
        let events = self.counts[stream].clone();
        let others = self.runs() - usize::from(stream > 0);
        let sums = match stream {
            0 => self.sums.clone(),
            _ => self.sums.iter().zip(&events).map(|(sum, own)| sum - own).collect(),
        };
        Sample { events, sums, runs: others as f64 }
    }
}

pub(super) fn tile(key: u64) -> usize {
    Axis::Row.level(key) * TILES.0 + Axis::Column.level(key)
}
