//! The states of fingers, extended or bent: a person sees them first of a hand.
//!
//! # Model
//! The bend of a joint is the angle between the bone before it and the bone behind it. A finger is *extended*
//! where its bends at MCP, PIP and DIP add up to less than 60 degrees, *bent* above 150 and *between* otherwise;
//! the thumb by MCP and IP, 40 and 65. The five states together are the gesture, as far as states say it: `.IM..`
//! is a victory sign, `.....` a fist.

use std::collections::BTreeMap;

use evpose_core::stats::bootstrap::Totals;
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Names of the digits, in the order of all tables here.
pub const DIGITS: [&str; 5] = ["thumb", "index", "middle", "ring", "pinky"];

/// The points of a digit from the wrist to the tip, as indices of
/// [`EVALUATION_JOINTS`](crate::EVALUATION_JOINTS).
const CHAINS: [[usize; 5]; 5] = [
    [0, 18, 19, 20, 1],
    [0, 6, 7, 8, 2],
    [0, 9, 10, 11, 3],
    [0, 15, 16, 17, 4],
    [0, 12, 13, 14, 5],
];
/// Letters of extended digits in the name of a gesture.
const LETTERS: [char; 5] = ['T', 'I', 'M', 'R', 'P'];

/// The state of a digit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FingerState {
    /// Stretched.
    Extended,
    /// Neither.
    Between,
    /// Bent into the palm.
    Bent,
}

impl FingerState {
    /// The state of a digit whose bends add up to this, in degrees.
    fn of_bend(digit: usize, bend_deg: f32) -> Self {
        let [extended, bent] = if digit == 0 { [40.0, 65.0] } else { [60.0, 150.0] };
        match bend_deg {
            bend if bend < extended => Self::Extended,
            bend if bend > bent => Self::Bent,
            _ => Self::Between,
        }
    }
}

/// The states of all digits of a hand whose evaluated points these are, in any frame and unit.
pub fn finger_states(points: &[Vec3; 21]) -> [FingerState; 5] {
    std::array::from_fn(|digit| {
        let chain = CHAINS[digit].map(|joint| points[joint]);
        // The thumb's first joint, the CMC, turns it across the palm and does not bend it.
        let first = if digit == 0 { 2 } else { 1 };
        let bend = |k: usize| {
            (chain[k] - chain[k - 1]).angle_between(chain[k + 1] - chain[k]).to_degrees()
        };
        FingerState::of_bend(digit, (first..4).map(bend).filter(|deg| deg.is_finite()).sum())
    })
}

/// The gesture of states: a letter for each extended digit, `-` for one that is between, `.` for a bent one.
pub fn gesture_of(states: &[FingerState; 5]) -> String {
    let letter = |(state, letter): (&FingerState, char)| match state {
        FingerState::Extended => letter,
        FingerState::Between => '-',
        FingerState::Bent => '.',
    };
    states.iter().zip(LETTERS).map(letter).collect()
}

/// How often states and gestures were taken for each other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FingerScores {
    /// Whether the state was right, a digit at a time.
    pub right: [Totals; 5],
    /// Whether all five were right.
    pub all_right: Totals,
    /// Counts of hands by true and by predicted states.
    confusion: BTreeMap<([FingerState; 5], [FingerState; 5]), u64>,
}

/// A line of the table of gestures.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct GestureConfusion {
    /// The true gesture, see [`gesture_of`].
    pub truth: String,
    /// The gesture that it was taken for.
    pub predicted: String,
    /// Count of hands.
    pub count: u64,
}

impl FingerScores {
    /// Scores one hand by its points.
    pub fn push(&mut self, predicted: &[Vec3; 21], truth: &[Vec3; 21]) {
        let (predicted, truth) = (finger_states(predicted), finger_states(truth));
        let is_right = |(a, b): (&FingerState, &FingerState)| if a == b { 1.0 } else { 0.0 };
        for (totals, pair) in self.right.iter_mut().zip(predicted.iter().zip(&truth)) {
            totals.push(is_right(pair));
        }
        self.all_right.push(if predicted == truth { 1.0 } else { 0.0 });
        *self.confusion.entry((truth, predicted)).or_default() += 1;
    }

    /// Scores a hand that was not predicted: all of it is wrong.
    pub fn push_missing(&mut self) {
        self.right.iter_mut().for_each(|totals| totals.push(0.0));
        self.all_right.push(0.0);
    }

    /// Adds those of another sequence.
    pub fn merge(&mut self, other: &Self) {
        for (pair, count) in &other.confusion {
            *self.confusion.entry(*pair).or_default() += count;
        }
        let totals = |all: &mut Totals, other: &Totals| {
            all.sum += other.sum;
            all.count += other.count;
        };
        self.right.iter_mut().zip(&other.right).for_each(|(all, other)| totals(all, other));
        totals(&mut self.all_right, &other.all_right);
    }

    /// All digits together.
    pub fn states(&self) -> Totals {
        let sum = |all: Totals, one: &Totals| Totals {
            sum: all.sum + one.sum,
            count: all.count + one.count,
        };
        self.right.iter().fold(Totals::default(), sum)
    }

    /// Share of the right states of a hand that is always in the most frequent true states: what a constant
    /// can reach. None without hands.
    pub fn majority(&self) -> Option<f64> {
        let mut counts = [[0u64; 3]; 5];
        for ((truth, _), count) in &self.confusion {
            for (digit, state) in truth.iter().enumerate() {
                counts[digit][*state as usize] += count;
            }
        }
        let most: u64 = counts.iter().map(|states| states.iter().max().copied().unwrap_or(0)).sum();
        let all: u64 = counts.iter().flatten().sum();
        (all > 0).then(|| most as f64 / all as f64)
    }

    /// The table of gestures, most frequent pairs first.
    pub fn gestures(&self) -> Vec<GestureConfusion> {
        let line = |((truth, predicted), &count): (&([FingerState; 5], [FingerState; 5]), &u64)| {
            GestureConfusion { truth: gesture_of(truth), predicted: gesture_of(predicted), count }
        };
        let mut lines: Vec<GestureConfusion> = self.confusion.iter().map(line).collect();
        // Stable, so that equal counts stay in the order of their states.
        lines.sort_by_key(|line| std::cmp::Reverse(line.count));
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EVALUATION_JOINTS;

    /// A hand in a plane, each digit bent by `bend_deg` at each of its counted joints.
    fn hand(bend_deg: [f32; 5]) -> [Vec3; 21] {
        let mut points = [Vec3::ZERO; 21];
        for (digit, chain) in CHAINS.iter().enumerate() {
            let mut angle_rad = 0.0f32;
            // Straight on from the wrist, so that only the stated bends count.
            let along = |angle: f32| Vec3::new(0.0, angle.cos(), angle.sin());
            let mut at = 0.08 * along(0.0);
            for (k, &joint) in chain.iter().enumerate().skip(1) {
                points[joint] = at;
                let is_counted = digit > 0 || k >= 2;
                angle_rad += if is_counted { bend_deg[digit].to_radians() } else { 0.0 };
                at += 0.03 * along(angle_rad);
            }
        }
        points
    }

    #[test]
    fn chains_follow_the_bones_of_the_hand() {
        for (name, chain) in DIGITS.iter().zip(CHAINS) {
            let of = |k: usize| format!("{name}{k}");
            let names = chain.map(|joint| EVALUATION_JOINTS[joint].to_owned());
            assert_eq!(names, ["wrist".to_owned(), of(1), of(2), of(3), format!("{name}_tip")]);
        }
    }

    #[test]
    fn states_follow_from_the_sum_of_the_bends() {
        use FingerState::{Bent, Between, Extended};
        // Of fingers three times, of the thumb twice.
        let states = finger_states(&hand([19.0, 19.0, 21.0, 49.0, 51.0]));
        assert_eq!(states, [Extended, Extended, Between, Between, Bent]);
        assert_eq!(finger_states(&hand([21.0, 0.0, 0.0, 0.0, 0.0]))[0], Between);
        assert_eq!(finger_states(&hand([33.0, 0.0, 0.0, 0.0, 0.0]))[0], Bent);
        assert_eq!(gesture_of(&states), "TI--.");
    }

    #[test]
    fn scores_count_digits_and_gestures() {
        let (fist, victory) =
            (hand([40.0, 60.0, 60.0, 60.0, 60.0]), hand([40.0, 0.0, 0.0, 60.0, 60.0]));
        let mut scores = FingerScores::default();
        scores.push(&fist, &fist);
        scores.push(&fist, &victory);
        scores.push(&victory, &victory);
        assert_eq!(scores.right.map(|of| of.sum), [3.0, 2.0, 2.0, 3.0, 3.0]);
        assert_eq!((scores.all_right.sum, scores.all_right.count), (2.0, 3));
        // Two of three are victory signs: a constant one has 13 of 15 states right.
        assert!((scores.majority().unwrap() - 13.0 / 15.0).abs() < 1e-12);
        let mut twice = scores.clone();
        twice.merge(&scores);
        let lines = twice.gestures();
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| line.count == 2));
        assert!(lines.iter().any(|line| line.truth == ".IM.." && line.predicted == "....."));
        assert_eq!(twice.states().mean(), scores.states().mean());
    }
}
