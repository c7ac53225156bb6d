//! Random motion of fingers from gesture to gesture.
//!
//! # Model
//! A move goes from the present hand to a random one: a gesture as somebody makes it, a mixture of
//! two, or fingers that each bend as they like. Every digit has its own beginning and duration within
//! the move, and goes along a minimum-jerk path (Flash, Hogan: *The coordination of arm movements*,
//! J. Neurosci. 5(7), 1985). A thumb that goes in front of the fingers comes last, one that
//! leaves them goes first. Between moves the hand rests, or does not.
//!
//! Moves take from a tenth of a [period](crate::motion::MotionConfig::period_s) to more than
//! a whole one, log-uniform, but no joint is faster than fingers are.
//!
//! Times and shares are ours, not measured.

use evpose_core::CounterRng;

use super::angles::{DIGITS, DIP_PER_PIP, HandAngles, THUMB};
use super::gesture::GESTURES;

/// Fastest angular velocity of a joint: a finger that is stretched closes in a seventh of a second.
const MAX_RAD_PER_S: f32 = 25.0;
/// Peak velocity of a minimum-jerk path relative to its mean.
const PEAK_PER_MEAN: f32 = 1.875;
/// Shortest and longest duration of a move, in periods.
const MOVE_PERIODS: [f32; 2] = [0.1, 1.2];
/// Probability of a rest after a move, and its shortest and longest duration in periods.
const REST_PROBABILITY: f32 = 0.6;
const REST_PERIODS: [f32; 2] = [0.05, 0.8];
/// Share of the move at whose end the last digit begins, at most.
const LATEST_START: f32 = 0.3;
/// Shares of targets that are a gesture, and a mixture of two.
const GESTURE_SHARE: f32 = 0.6;
const MIXTURE_SHARE: f32 = 0.25;
/// Difference of its abduction from which on a thumb goes in front of the fingers, in radians.
const THUMB_CROSSES_RAD: f32 = 0.35;

/// A random motion of fingers: the same for the same seed, whatever else runs.
#[derive(Debug, Clone)]
pub struct FingerMotion {
    seed: u64,
    step_hz: f32,
    period_s: f32,
    /// Moves begun.
    moves: u64,
    current: Move,
    /// Steps since the move began.
    on_move: u32,
    present: HandAngles,
}

/// One move and the rest after it.
#[derive(Debug, Clone, Copy)]
struct Move {
    from: HandAngles,
    to: HandAngles,
    /// Steps before each digit begins, and that it takes.
    begins: [f32; DIGITS],
    takes: [f32; DIGITS],
    /// Steps until the next move begins.
    steps: u32,
}

impl FingerMotion {
    /// A motion of `step_hz` steps a second, whose moves take about `period_s`. It begins at a random
    /// moment of a move.
    pub fn new(seed: u64, step_hz: u32, period_s: f64) -> Self {
        let mut rng = CounterRng::new(seed, "fingers start", 0);
        let present = target(&mut rng);
        let (step_hz, period_s) = (step_hz as f32, period_s as f32);
        let current = Move::draw(&present, step_hz, period_s, &mut rng);
        let begun = rng.below(current.steps as usize) as u32;
        let mut motion = Self { seed, step_hz, period_s, moves: 0, current, on_move: 0, present };
        (0..begun).for_each(|_| {
            motion.step();
        });
        motion
    }

    /// Advances by one step and returns the hand there.
    pub fn step(&mut self) -> &HandAngles {
        if self.on_move == self.current.steps {
            self.moves += 1;
            let mut rng = CounterRng::new(self.seed, "fingers move", self.moves);
            self.current = Move::draw(&self.present, self.step_hz, self.period_s, &mut rng);
            self.on_move = 0;
        }
        self.on_move += 1;
        self.present = self.current.at(self.on_move);
        &self.present
    }
}

impl Move {
    fn draw(from: &HandAngles, step_hz: f32, period_s: f32, rng: &mut CounterRng) -> Self {
        let to = target(rng);
        let mut log_uniform = |[low, high]: [f32; 2]| low * (high / low).powf(rng.unit());
        let duration_s = period_s * log_uniform(MOVE_PERIODS);
        let rest_s = period_s * log_uniform(REST_PERIODS);
        let rest_s = if rng.chance(REST_PROBABILITY) { rest_s } else { 0.0 };
        let lifted = to.digits[THUMB][0] - from.digits[THUMB][0];
        let begins_s: [f32; DIGITS] = std::array::from_fn(|digit| {
            let share = match digit {
                THUMB if lifted > THUMB_CROSSES_RAD => 1.0,
                THUMB if lifted < -THUMB_CROSSES_RAD => 0.0,
                _ => rng.unit(),
            };
            LATEST_START * duration_s * share
        });
        let takes_s: [f32; DIGITS] = std::array::from_fn(|digit| {
            let pairs = from.digits[digit].iter().zip(to.digits[digit]);
            let furthest_rad = pairs.map(|(from, to)| (to - from).abs()).fold(0.0, f32::max);
            let fastest_s = PEAK_PER_MEAN * furthest_rad / MAX_RAD_PER_S;
            let own_s = (duration_s - begins_s[digit]) * rng.uniform(0.6, 1.0);
            own_s.max(fastest_s)
        });
        let ends_s = begins_s.iter().zip(takes_s).map(|(begin, take)| begin + take);
        let steps = ((ends_s.fold(0.0, f32::max) + rest_s) * step_hz).ceil();
        Self {
            from: *from,
            to,
            begins: begins_s.map(|s| s * step_hz),
            // At least a step: a move of no length is over at once.
            takes: takes_s.map(|s| (s * step_hz).max(1.0)),
            steps: steps.max(1.0) as u32,
        }
    }

    /// The hand some steps after the beginning.
    fn at(&self, step: u32) -> HandAngles {
        let share = |digit: usize| {
            let x = (step as f32 - self.begins[digit]) / self.takes[digit];
            minimum_jerk(x.clamp(0.0, 1.0))
        };
        self.from.towards(&self.to, &std::array::from_fn(share))
    }
}

/// The share of the way at the share `x` of the time.
fn minimum_jerk(x: f32) -> f32 {
    x * x * x * (x * (6.0 * x - 15.0) + 10.0)
}

/// A random hand.
fn target(rng: &mut CounterRng) -> HandAngles {
    let kind = rng.unit();
    let sloppiness = rng.uniform(0.3, 1.6);
    let mut gesture = || GESTURES[rng.below(GESTURES.len())].angles();
    let hand = if kind < GESTURE_SHARE {
        return gesture().varied(sloppiness, rng);
    } else if kind < GESTURE_SHARE + MIXTURE_SHARE {
        let (a, b) = (gesture(), gesture());
        a.towards(&b, &std::array::from_fn(|_| rng.unit()))
    } else {
        curled(rng)
    };
    hand.coupled().varied(sloppiness, rng)
}

/// A hand each of whose digits is bent as it likes.
fn curled(rng: &mut CounterRng) -> HandAngles {
    let mut digits = HandAngles::from_fn(|digit, k| {
        let [low, high] = HandAngles::limits(digit, k);
        rng.uniform(low, high)
    })
    .digits;
    // One tendon bends two joints.
    digits[THUMB + 1..].iter_mut().for_each(|finger| finger[3] = DIP_PER_PIP * finger[2]);
    HandAngles { digits }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HZ: u32 = 1000;

    fn path(seed: u64, steps: usize) -> Vec<HandAngles> {
        let mut motion = FingerMotion::new(seed, HZ, 1.0);
        (0..steps).map(|_| *motion.step()).collect()
    }

    fn furthest(a: &HandAngles, b: &HandAngles) -> f32 {
        let pairs = a.digits.as_flattened().iter().zip(b.digits.as_flattened());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn no_joint_is_faster_than_fingers_are_or_beyond_its_limits() {
        for hand in [1, 2].map(|seed| path(seed, 20_000)) {
            for pair in hand.windows(2) {
                // A step of a millisecond at the fastest.
                assert!(furthest(&pair[0], &pair[1]) <= 1.01e-3 * MAX_RAD_PER_S);
                assert!(furthest(&pair[1], &pair[1].clamped()) < 1e-5);
            }
        }
    }

    #[test]
    fn hands_move_and_rest_and_fingers_go_their_own_way() {
        let hands = path(3, 60_000);
        let still = hands.windows(2).filter(|pair| pair[0] == pair[1]).count();
        assert!((9_000..42_000).contains(&still), "{still} of 60000 steps at rest");
        // Correlation of the flexion of index and pinky: alike in some gestures, not in others.
        let flexion = |digit: usize| -> Vec<f32> {
            hands.iter().map(|hand| hand.digits[digit][1] + hand.digits[digit][2]).collect()
        };
        let (index, pinky) = (flexion(1), flexion(4));
        let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
        let covariance = |a: &[f32], b: &[f32]| {
            let (ma, mb) = (mean(a), mean(b));
            a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum::<f32>() / a.len() as f32
        };
        let r = covariance(&index, &pinky)
            / (covariance(&index, &index) * covariance(&pinky, &pinky)).sqrt();
        assert!(r < 0.7, "{r}");
        assert!(covariance(&index, &index).sqrt() > 0.6);
    }

    #[test]
    fn a_longer_period_has_slower_moves() {
        let travelled = |period_s: f64| -> f32 {
            let mut motion = FingerMotion::new(4, HZ, period_s);
            let hands: Vec<_> = (0..40_000).map(|_| *motion.step()).collect();
            hands.windows(2).map(|pair| furthest(&pair[0], &pair[1])).sum()
        };
        let ratio = travelled(0.5) / travelled(2.0);
        assert!((2.5..5.5).contains(&ratio), "{ratio}");
    }

    #[test]
    fn the_seed_decides_and_nothing_else() {
        assert_eq!(path(7, 3_000), path(7, 3_000));
        assert_ne!(path(7, 10), path(8, 10));
    }
}
