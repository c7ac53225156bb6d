//! When a pose of a hand is reported.

use evpose_core::{Micros, SensorSize};
use evpose_pose::HandPose;
use serde::{Deserialize, Serialize};

/// The conditions for poses.
///
/// # Model
/// A network of joints says of every window how likely a hand is in it, which counts less where its joints are nowhere
/// in particular. Smoothed over a tenth of a second, this must come to `min_presence` before there is a pose, and
/// poses end where it falls below a twelfth of that. A regressor does not: it regresses a pose for every window, an empty one included: that
/// is the mean pose of its training, with or without a hand. So nothing is reported before a window has shown as
/// many active pixels as a hand that moves. Later windows are at rest or not, see [`HandConfig::hold`].
///
/// [`HandConfig::hold`]: super::HandConfig::hold
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandDetectionConfig {
    /// Pixels with an event in the window, as a share of those of the canonical view. 0 reports every
    /// window.
    pub min_active: f32,
    /// Smoothed likelihood of a hand, 0 to 1, from which on a network of joints has poses.
    pub min_presence: f32,
    /// Mean score of the joints of a network of joints, 0 to 1, below which the last pose is repeated: they are
    /// nowhere in particular, as of a hand of which next to nothing moves.
    pub min_score: f32,
    /// Active pixels in the box about the hand of a network of joints, relative to the larger side of the box,
    /// below which the last pose is repeated: what rests is not seen.
    pub min_evidence: f32,
}

impl Default for HandDetectionConfig {
    /// 130 of 240x180 pixels. `hold.rest_sum` of the shipped network takes a window that sums to 60 for
    /// one at rest, and active pixels of an LNES are one half on average.
    fn default() -> Self {
        Self { min_active: 0.003, min_presence: 0.3, min_score: 0.15, min_evidence: 8.0 }
    }
}

impl HandDetectionConfig {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Whether it makes sense.
    pub(super) fn is_valid(&self) -> bool {
        let shares = [self.min_active, self.min_presence, self.min_score];
        shares.iter().all(|share| (0.0..=1.0).contains(share)) && self.min_evidence >= 0.0
    }
}

/// Whether a recording has shown enough.
#[derive(Debug, Clone, Copy)]
pub(super) struct WarmUp {
    min_active_px: usize,
    is_over: bool,
}

impl WarmUp {
    pub(super) fn new(config: HandDetectionConfig, view: SensorSize) -> Self {
        let min_active_px = (config.min_active * view.pixels() as f32).ceil() as usize;
        Self { min_active_px, is_over: min_active_px == 0 }
    }

    /// The index of the first of several inputs, each `[2][rows][columns]` of `pixels` a channel, of
    /// which a pose is reported; their count if that is none of them.
    pub(super) fn first(&mut self, inputs: &[f32], pixels: usize) -> usize {
        // Once a hand has moved it may rest: later windows are not tested.
        if self.is_over {
            return 0;
        }
        let inputs = || inputs.chunks_exact(2 * pixels);
        let is_enough = |input: &[f32]| {
            let (first, second) = input.split_at(pixels);
            let pairs = first.iter().zip(second);
            pairs.filter(|(a, b)| **a != 0.0 || **b != 0.0).count() >= self.min_active_px
        };
        match inputs().position(is_enough) {
            Some(first) => {
                self.is_over = true;
                first
            }
            None => inputs().count(),
        }
    }

    pub(super) fn reset(&mut self) {
        self.is_over = self.min_active_px == 0;
    }
}

/// Time constant over which the presence is smoothed: single windows of a digit look like a hand, and some of a hand
/// that hardly moves do not.
const SMOOTHED_S: f64 = 0.1;
/// Weight of the first window of a recording.
const FIRST: f32 = 0.3;
/// A hand that was there is gone below this part of `min_presence`.
const GONE: f32 = 1.0 / 12.0;
/// Mean score of joints from which on the presence counts in full; below, by its square. Scores of hands are .3 to .5, those of a digit .2.
const SURE_SCORE: f32 = 0.25;

/// Whether there is a hand, by the presence of one window after the other.
#[derive(Debug, Clone, Copy)]
pub(super) struct PresenceGate {
    min_presence: f32,
    /// Time of the latest window, and the presence up to it.
    smoothed: Option<(Micros, f32)>,
    is_there: bool,
}

impl PresenceGate {
    pub(super) fn new(config: HandDetectionConfig) -> Self {
        Self { min_presence: config.min_presence, smoothed: None, is_there: false }
    }

    /// The presence at `t`, smoothed, and whether there is a hand; none of networks that do not say.
    pub(super) fn update(&mut self, t: Micros, pose: &HandPose) -> Option<(f32, bool)> {
        let presence = pose.presence()? * (pose.mean_score()? / SURE_SCORE).min(1.0).powi(2);
        Some(self.smooth(t, presence))
    }

    fn smooth(&mut self, t: Micros, presence: f32) -> (f32, bool) {
        let smoothed = match self.smoothed {
            None => FIRST * presence,
            Some((before, smoothed)) => {
                let passed_s = (t - before).as_seconds();
                smoothed + (1.0 - (-passed_s / SMOOTHED_S).exp()) as f32 * (presence - smoothed)
            }
        };
        self.smoothed = Some((t, smoothed));
        let limit = if self.is_there { GONE * self.min_presence } else { self.min_presence };
        self.is_there = smoothed >= limit;
        (smoothed, self.is_there)
    }

    pub(super) fn reset(&mut self) {
        (self.smoothed, self.is_there) = (None, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_has_to_stay_before_it_is_there_and_may_then_be_unclear_for_a_while() {
        let mut gate = PresenceGate::new(HandDetectionConfig::default());
        let mut seen = |times_ms: std::ops::Range<i64>, presence: f32| {
            let windows = times_ms.map(|ms| gate.smooth(Micros(1_000 * ms), presence).1);
            windows.filter(|is_there| *is_there).count()
        };
        assert_eq!(seen(0..10, 0.4), 0, "a glimpse");
        assert_eq!(seen(10..200, 0.1), 0);
        assert!(seen(200..400, 1.0) > 130);
        assert_eq!(seen(400..450, 0.0), 50, "unclear, and still there");
        assert!(seen(450..900, 0.0) < 400, "gone");
        gate.reset();
        assert_eq!(gate.smooth(Micros(0), 0.5), (0.5 * FIRST, false));
    }

    #[test]
    fn inputs_count_from_the_first_with_enough_active_pixels() {
        let view = SensorSize { width: 40, height: 25 };
        let input = |active: usize| {
            let mut values = vec![0.0; 2 * view.pixels()];
            // A pixel with both polarities is one.
            (0..active).for_each(|k| values[k] = 0.5);
            values[view.pixels()] = 0.25;
            values
        };
        let config = HandDetectionConfig { min_active: 0.01, ..HandDetectionConfig::default() };
        let mut warm_up = WarmUp::new(config, view);
        assert_eq!(warm_up.first(&[input(0), input(9)].concat(), view.pixels()), 2);
        assert_eq!(warm_up.first(&[input(9), input(10), input(0)].concat(), view.pixels()), 1);
        assert_eq!(warm_up.first(&input(0), view.pixels()), 0, "a hand may rest later");
        warm_up.reset();
        assert_eq!(warm_up.first(&input(9), view.pixels()), 1);
        let mut all = WarmUp::new(HandDetectionConfig { min_active: 0.0, ..config }, view);
        assert_eq!(all.first(&input(0), view.pixels()), 0);
    }
}
