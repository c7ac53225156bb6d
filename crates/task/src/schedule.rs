//! Learning rate schedule and early stopping.

use std::collections::BTreeMap;

use burn::optim::lr_scheduler::{LrScheduler, LrSchedulerRecord};
use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::experiment::require;

/// The number format of a training's convolutions. Parameters, normalisations, losses and validation are in 32 bits
/// in all of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrainingPrecision {
    /// 32 bits.
    #[default]
    F32,
    /// The upper half of 32 bits.
    Bf16,
    /// IEEE's 16 bits; the loss is scaled, so that small gradients are not lost.
    F16,
}

impl TrainingPrecision {
    /// Whether it is the default, which configs leave out.
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// A learning rate schedule: linear warm-up, then steps at milestones or a cosine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Schedule {
    /// Steps of the warm-up, which begins at a hundredth of the rate.
    pub warm_up_steps: u64,
    /// Shares of the training after which it is multiplied by `factor`.
    pub milestones: Vec<f64>,
    /// Factor of the rate at each milestone.
    pub factor: f64,
    /// Instead of milestones: falls along half a cosine, to a hundredth at the end.
    pub cosine: bool,
}

impl Schedule {
    /// The same rate all the time.
    pub fn constant() -> Self {
        Self { milestones: Vec::new(), ..Self::default() }
    }
}

impl Default for Schedule {
    /// As published: a tenth after 70 and 100 of 300 epochs.
    fn default() -> Self {
        Self {
            warm_up_steps: 0,
            milestones: vec![70.0 / 300.0, 100.0 / 300.0],
            factor: 0.1,
            cosine: false,
        }
    }
}

/// The share of the rate at the end of a cosine and at the start of a warm-up.
const MIN_SHARE: f64 = 0.01;

impl Schedule {
    /// Checks ranges and combinations of values.
    ///
    /// # Errors
    /// The first field that makes no sense.
    pub fn validate(&self) -> Result<(), TaskError> {
        let are_shares = self.milestones.iter().all(|at| (0.0..=1.0).contains(at));
        let message = "are shares of the training, from 0 to 1";
        let is_valid = self.factor > 0.0 && self.factor <= 1.0;
        require(&[
            (are_shares, "training.schedule.milestones", message),
            (is_valid, "training.schedule.factor", "must be above 0 and at most 1"),
        ])
    }

    /// The learning rate over a training of `steps` steps, `learning_rate` at factor 1.
    pub fn rate(&self, learning_rate: f64, steps: u64) -> ScheduledRate {
        ScheduledRate { schedule: self.clone(), learning_rate, steps, next: 0 }
    }

    /// The factor of the initial rate in step `step` (from 0) of `steps`.
    pub fn share(&self, step: u64, steps: u64) -> f64 {
        let part = step as f64 / steps as f64;
        let warm = match self.warm_up_steps {
            0 => 1.0,
            warm_up => MIN_SHARE + (1.0 - MIN_SHARE) * (step as f64 / warm_up as f64).min(1.0),
        };
        let fallen = if self.cosine {
            MIN_SHARE + (1.0 - MIN_SHARE) * (0.5 + 0.5 * (std::f64::consts::PI * part).cos())
        } else {
            self.factor.powi(self.milestones.iter().filter(|&&at| at <= part).count() as i32)
        };
        warm * fallen
    }
}

/// A [`Schedule`] as a scheduler of Burn.
#[derive(Debug, Clone)]
pub struct ScheduledRate {
    /// Factor over time.
    pub schedule: Schedule,
    /// Learning rate at factor 1.
    pub learning_rate: f64,
    /// Steps of the training.
    pub steps: u64,
    /// The next step.
    pub next: u64,
}

const NEXT: &str = "next_step";

impl LrScheduler for ScheduledRate {
    fn step(&mut self) -> f64 {
        let share = self.schedule.share(self.next, self.steps);
        self.next += 1;
        self.learning_rate * share
    }

    fn to_record(&self) -> LrSchedulerRecord {
        LrSchedulerRecord::new().with_scalar(NEXT, self.next)
    }

    fn load_record(&mut self, record: LrSchedulerRecord) {
        self.next = record.scalar(NEXT).unwrap_or(self.next);
    }
}

/// Early stopping of a training.
///
/// # Model
/// After a validation, the mean loss of the last `window` is compared with that of the `window`
/// before. If it is not smaller, that counts; after more than `patience` of them, which need not
/// follow each other, the training ends.
///
/// # Source
/// MoveEnet's published training: windows of 10 after the 20th epoch, patience 10.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EarlyStop {
    /// Validations in each of the two means; 0 never ends early.
    pub window: usize,
    /// Comparisons without a smaller mean that are tolerated.
    pub patience: usize,
}

impl Default for EarlyStop {
    fn default() -> Self {
        Self { window: 10, patience: 10 }
    }
}

impl EarlyStop {
    /// Whether a training with these validation losses by interval ends after interval `interval`.
    pub fn ends(&self, losses: &BTreeMap<usize, f64>, interval: usize) -> bool {
        if self.window == 0 {
            return false;
        }
        let losses: Vec<f64> = losses.range(..=interval).map(|(_, &loss)| loss).collect();
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let stopped_falling = losses
            .windows(2 * self.window)
            .filter(|both| mean(&both[..self.window]) <= mean(&both[self.window..]));
        stopped_falling.count() > self.patience
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_schedule_falls_twice() {
        let schedule = Schedule::default();
        let at = |epoch: u64| schedule.share(epoch, 300);
        assert_eq!([at(0), at(69)], [1.0, 1.0]);
        assert!((at(70) - 0.1).abs() < 1e-12 && (at(99) - 0.1).abs() < 1e-12);
        assert!((at(100) - 0.01).abs() < 1e-12 && (at(299) - 0.01).abs() < 1e-12);
    }

    #[test]
    fn a_cosine_falls_to_a_hundredth_after_a_rise_from_one() {
        let schedule = Schedule { warm_up_steps: 10, cosine: true, ..Schedule::default() };
        assert!((schedule.share(0, 1_000) - 0.01).abs() < 1e-12);
        assert!((schedule.share(10, 1_000) - 1.0).abs() < 1e-3);
        assert!((schedule.share(500, 1_000) - 0.505).abs() < 1e-9);
        assert!(schedule.share(999, 1_000) < 0.0101);
        assert!(
            (0..990)
                .all(|step| schedule.share(step + 10, 1_000) >= schedule.share(step + 11, 1_000))
        );
    }

    #[test]
    fn a_resumed_schedule_goes_on() {
        let rate =
            ScheduledRate { schedule: Schedule::default(), learning_rate: 0.5, steps: 30, next: 0 };
        let mut whole = rate.clone();
        let rates: Vec<f64> = (0..30).map(|_| whole.step()).collect();
        let mut first = rate.clone();
        for _ in 0..9 {
            first.step();
        }
        let mut second = rate;
        second.load_record(first.to_record());
        assert_eq!((0..21).map(|_| second.step()).collect::<Vec<_>>(), rates[9..]);
    }

    #[test]
    fn a_training_whose_loss_falls_goes_on_and_one_that_rises_ends() {
        let stop = EarlyStop { window: 2, patience: 3 };
        let losses = |f: fn(usize) -> f64| (1..=20).map(|i| (i, f(i))).collect::<BTreeMap<_, _>>();
        let falling = losses(|i| 1.0 / i as f64);
        assert!((1..=20).all(|interval| !stop.ends(&falling, interval)));
        let rising = losses(|i| if i < 8 { 1.0 / i as f64 } else { i as f64 });
        let first = (1..=20).find(|&interval| stop.ends(&rising, interval));
        // The first four in which the newer half is larger end at 8, 9, 10 and 11.
        assert_eq!(first, Some(11));
        let never = EarlyStop { window: 0, patience: 0 };
        assert!(!never.ends(&rising, 20));
    }
}
