//! Retention of checkpoints on disk: the last two, and the best so far.

use std::collections::BTreeMap;

use burn_train::checkpoint::{CheckpointingAction, CheckpointingStrategy};
use burn_train::metric::store::EventStoreClient;

use crate::history::History;

/// Saves after every interval and deletes what is neither recent nor best.
pub(crate) struct LastTwoAndBest(pub(crate) History);

/// The interval with the lowest validation loss, the earliest of equals.
pub(crate) fn best_interval(losses: &BTreeMap<usize, f64>) -> Option<usize> {
    let finite = losses.iter().filter(|(_, loss)| loss.is_finite());
    finite.min_by(|a, b| a.1.total_cmp(b.1)).map(|(&interval, _)| interval)
}

/// The checkpoints to delete once `interval` is saved: retained before, and no longer.
fn superseded(losses: &BTreeMap<usize, f64>, interval: usize) -> Vec<usize> {
    let retained = |now: usize| -> Vec<usize> {
        // The best as known then: a later loss must not change what was retained.
        let known = losses.range(..=now).map(|(&i, &loss)| (i, loss)).collect();
        [Some(now), now.checked_sub(1), best_interval(&known)].into_iter().flatten().collect()
    };
    let still = retained(interval);
    let mut gone: Vec<usize> =
        retained(interval - 1).into_iter().filter(|i| *i > 0 && !still.contains(i)).collect();
    gone.sort_unstable();
    gone.dedup();
    gone
}

impl CheckpointingStrategy for LastTwoAndBest {
    fn checkpointing(&mut self, interval: usize, _: &EventStoreClient) -> Vec<CheckpointingAction> {
        let gone = superseded(&self.0.losses_of_networks(), interval);
        let mut actions = vec![CheckpointingAction::Save];
        actions.extend(gone.into_iter().map(CheckpointingAction::Delete));
        actions
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_and_the_last_two_survive() {
        let losses = [5.0, 1.0, 3.0, 2.0, 0.5, 4.0];
        let all: BTreeMap<usize, f64> = (1..).zip(losses).collect();
        let mut on_disk: Vec<usize> = Vec::new();
        let mut after = Vec::new();
        for interval in 1..=losses.len() {
            let known = all.range(..=interval).map(|(&i, &l)| (i, l)).collect();
            on_disk.push(interval);
            on_disk.retain(|i| !superseded(&known, interval).contains(i));
            after.push(on_disk.clone());
        }
        assert_eq!(after[2], [2, 3]);
        assert_eq!(after[3], [2, 3, 4], "2 is the best, 3 and 4 the last two");
        assert_eq!(after[4], [4, 5], "5 is the best now: 2 may go");
        assert_eq!(after[5], [5, 6]);
    }
}
