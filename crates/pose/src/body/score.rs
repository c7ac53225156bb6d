//! The score of a pose of a person: whether somebody is there.

use evpose_core::Micros;

use super::{BODY_JOINTS, BodyJoint};

/// Joints that the score of a pose is of: as many as are left of a person who is cut off at the chest.
const SCORED_JOINTS: usize = 6;

/// Score of a pose, 0 to 1: the mean of the six highest scores of its joints, so that a body that is
/// partly out of view scores as well as a whole one. Joints that were not detected count as 0.
pub fn pose_score(scores: &[f32; BODY_JOINTS]) -> f32 {
    let mut sorted = *scores;
    sorted.sort_by(|a, b| b.total_cmp(a));
    sorted[..SCORED_JOINTS].iter().sum::<f32>() / SCORED_JOINTS as f32
}

/// The same of decoded joints.
pub fn score_of_joints(joints: &[BodyJoint]) -> f32 {
    let mut scores = [0.0; BODY_JOINTS];
    scores.iter_mut().zip(joints).for_each(|(score, joint)| *score = joint.score);
    pose_score(&scores)
}

/// Scores of poses, smoothed over time: somebody who is there stays for a while, and what noise looks
/// like for one image is gone in the next.
///
/// # Model
/// An exponential mean over event time, `s += (1 - exp(-dt / tau)) (x - s)`, which begins with the first
/// score.
#[derive(Debug, Clone, Copy)]
pub struct PresenceScore {
    tau_s: f64,
    last: Option<(Micros, f32)>,
}

impl PresenceScore {
    /// A mean with the time constant `tau_s` in seconds, 0 for none.
    pub fn new(tau_s: f64) -> Self {
        Self { tau_s, last: None }
    }

    /// The smoothed score at `t`, not before the last, of a pose that scores `score` by itself.
    pub fn update(&mut self, t: Micros, score: f32) -> f32 {
        let smoothed = match self.last {
            Some((before, mean)) if self.tau_s > 0.0 => {
                // A negative duration would give the new score a negative weight.
                let dt_s = (t - before).as_seconds().max(0.0);
                mean + (1.0 - (-dt_s / self.tau_s).exp()) as f32 * (score - mean)
            }
            _ => score,
        };
        self.last = Some((t, smoothed));
        smoothed
    }

    /// Forgets all scores.
    pub fn reset(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_scores_by_its_best_joints() {
        let mut scores = [0.1; BODY_JOINTS];
        assert!((pose_score(&scores) - 0.1).abs() < 1e-6);
        scores[7..].fill(0.7);
        assert!((pose_score(&scores) - 0.7).abs() < 1e-6, "half of a body");
        scores[7..10].fill(0.0);
        assert!((pose_score(&scores) - 0.4).abs() < 1e-6, "{}", pose_score(&scores));
    }

    #[test]
    fn a_score_follows_within_the_time_constant_whatever_the_rate() {
        for step in [1_000, 10_000] {
            let mut presence = PresenceScore::new(0.1);
            assert!((presence.update(Micros(0), 0.0)).abs() < 1e-6);
            let mut smoothed = 0.0;
            for k in 1..=100_000 / step {
                smoothed = presence.update(Micros(k * step), 1.0);
            }
            assert!((smoothed - (1.0 - (-1.0_f32).exp())).abs() < 1e-3, "{smoothed}");
            presence.reset();
            assert!((presence.update(Micros(0), 0.8) - 0.8).abs() < 1e-6);
        }
        let mut none = PresenceScore::new(0.0);
        none.update(Micros(0), 0.0);
        assert!((none.update(Micros(1), 0.9) - 0.9).abs() < 1e-6);
    }
}
