//! The order of trials.

use std::cmp::Ordering;

/// A trial with its score; none for one that diverged.
pub(crate) type Scored = (u64, Option<f64>);

/// The order of two trials, the better first: by score, then by index. Trials without a score come
/// last.
pub(crate) fn order(one: &Scored, other: &Scored, higher_is_better: bool) -> Ordering {
    let by_score = match (one.1, other.1) {
        (Some(a), Some(b)) if higher_is_better => b.total_cmp(&a),
        (Some(a), Some(b)) => a.total_cmp(&b),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => Ordering::Equal,
    };
    by_score.then(one.0.cmp(&other.0))
}

/// The best `count` trials that have a score, in the order of their indices.
pub(crate) fn promoted(mut trials: Vec<Scored>, count: u64, higher_is_better: bool) -> Vec<u64> {
    trials.retain(|(_, score)| score.is_some());
    trials.sort_by(|one, other| order(one, other, higher_is_better));
    trials.truncate(count as usize);
    let mut promoted: Vec<u64> = trials.into_iter().map(|(trial, _)| trial).collect();
    promoted.sort_unstable();
    promoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_go_on_and_trials_that_diverged_do_not() {
        let trials =
            vec![(0, Some(0.3)), (1, None), (2, Some(0.1)), (3, Some(0.3)), (4, Some(0.5))];
        assert_eq!(promoted(trials.clone(), 2, false), [0, 2], "the earlier of equals");
        assert_eq!(promoted(trials.clone(), 2, true), [0, 4]);
        assert_eq!(promoted(trials, 9, false), [0, 2, 3, 4]);
    }
}
