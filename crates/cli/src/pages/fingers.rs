//! The states of fingers that a network sees, and the gestures that it confuses.

use evpose_pose::metric::{DIGITS, FingerSummary, HandSummary};

use crate::progress::say;

/// True gestures that are listed, and what each is taken for.
const GESTURES: usize = 16;
const TAKEN_FOR: usize = 4;

/// Prints the states of the fingers of methods by name, and the gestures of the one called `detailed`.
pub fn print<'a>(methods: impl IntoIterator<Item = (&'a str, &'a HandSummary)>, detailed: &str) {
    let with_fingers: Vec<(&str, &FingerSummary)> = methods
        .into_iter()
        .filter_map(|(name, summary)| Some((name, summary.fingers.as_ref()?)))
        .collect();
    // The truth is the same for all of them, and so is the majority.
    let Some((_, first)) = with_fingers.first() else { return };
    say(format!(
        "\nfingers extended, bent or between as they truly are (a hand always in the most frequent states: {:.3})",
        first.majority
    ));
    let digits: String = DIGITS.iter().map(|digit| format!("{digit:>8}")).collect();
    say(format!("{:<27}{:>8}{digits}{:>16}", "", "all", "all five right"));
    for (name, fingers) in &with_fingers {
        let each: String = fingers.each.iter().map(|share| format!("{share:>8.3}")).collect();
        let (all, gesture) = (fingers.states.estimate, fingers.gesture.estimate);
        say(format!("{name:<27}{all:>8.3}{each}{gesture:>16.3}"));
    }
    if let Some((_, fingers)) = with_fingers.iter().find(|(name, _)| *name == detailed) {
        say(format!("gestures of {detailed}: T I M R P are extended, - is between, . bent"));
        confusion(fingers).iter().for_each(say);
    }
}

/// A line for each of the most frequent true gestures.
fn confusion(fingers: &FingerSummary) -> Vec<String> {
    let mut truths: Vec<(&str, u64)> = Vec::new();
    for line in &fingers.gestures {
        match truths.iter_mut().find(|(truth, _)| *truth == line.truth) {
            Some((_, count)) => *count += line.count,
            None => truths.push((&line.truth, line.count)),
        }
    }
    truths.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let row = |(truth, count): (&str, u64)| {
        let of_truth = fingers.gestures.iter().filter(|line| line.truth == truth);
        let share = |count: u64, of: u64| 100.0 * count as f64 / of as f64;
        let taken: Vec<String> = of_truth
            .take(TAKEN_FOR)
            .map(|line| format!("{} {:.0} %", line.predicted, share(line.count, count)))
            .collect();
        format!("  {truth:<7}{count:>8} hands: {}", taken.join(", "))
    };
    truths.into_iter().take(GESTURES).map(row).collect()
}

#[cfg(test)]
mod tests {
    use evpose_core::stats::interval::Interval;
    use evpose_pose::metric::GestureConfusion;

    use super::*;

    #[test]
    fn a_gesture_is_listed_once_with_what_it_is_taken_for() {
        let share = Interval { estimate: 0.5, low: None, high: None };
        let line = |truth: &str, predicted: &str, count| GestureConfusion {
            truth: truth.to_owned(),
            predicted: predicted.to_owned(),
            count,
        };
        let gestures =
            vec![line(".IM..", ".IM..", 6), line(".....", ".....", 5), line(".IM..", ".....", 2)];
        let (states, gesture) = (share, share);
        let fingers = FingerSummary { states, each: [0.5; 5], gesture, majority: 0.4, gestures };
        assert_eq!(
            confusion(&fingers),
            [
                "  .IM..         8 hands: .IM.. 75 %, ..... 25 %",
                "  .....         5 hands: ..... 100 %"
            ]
        );
    }
}
