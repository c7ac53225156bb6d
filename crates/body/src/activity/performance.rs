//! An activity as somebody does it: with a posture of their own, a sway, and pauses.

use evpose_core::CounterRng;

use super::rhythm::{Sway, ease};
use super::{Activity, Figure, Motion};

/// How much postures differ among people, in radians.
const POSTURE_SD: f32 = 0.06;
/// How far the body sways while it does something, in radians.
const SWAY: f32 = 0.025;
/// How long it takes to stop and to go on, in seconds.
const STOPPING_S: f32 = 0.25;

/// Somebody doing something.
pub struct Performance {
    motion: Motion,
    /// When the motion stops and goes on, in seconds, alternately.
    turns_s: Vec<f32>,
    /// Time of the motion at each of `turns_s`.
    passed_s: Vec<f32>,
    postures: [f32; 12],
    sways: [Sway; 12],
}

impl Performance {
    /// One person's way of doing `activity` for `seconds`. For `stillness` of the time, on average,
    /// the person stands still in the midst of it, but for a sway: the parts that an event camera
    /// is blind for.
    pub fn draw(activity: &Activity, rng: &mut CounterRng, seconds: f32, stillness: f32) -> Self {
        let motion = (activity.draw)(rng);
        let (mut turns_s, mut passed_s) = (Vec::new(), Vec::new());
        let (mut t_s, mut own_s, mut moves) = (0.0, 0.0, true);
        let pause_s = 1.2;
        if stillness > 0.0 {
            // With this, pauses are `stillness` of the time.
            let moving_s = pause_s * (1.0 - stillness) / stillness;
            while t_s < seconds {
                let for_s = if moves { moving_s } else { pause_s } * rng.uniform(0.5, 1.5);
                t_s += for_s;
                // The activity's own time stands in a pause, and goes on from there.
                own_s += if moves { for_s } else { 0.0 };
                turns_s.push(t_s);
                passed_s.push(own_s);
                moves = !moves;
            }
        }
        let postures = [(); 12].map(|()| POSTURE_SD * rng.normal().clamp(-2.5, 2.5));
        let sways = [(); 12].map(|()| Sway::draw(rng, 0.6));
        Self { motion, turns_s, passed_s, postures, sways }
    }

    /// The posture at a time in seconds.
    pub fn at(&self, t_s: f32) -> Figure {
        let (own_s, moving) = self.own_time(t_s);
        let mut figure = (self.motion)(own_s);
        // Nobody stands quite still.
        let sway = SWAY * (0.15 + 0.85 * moving);
        let more: [f32; 12] =
            std::array::from_fn(|k| self.postures[k] + sway * self.sways[k].at(t_s));
        // People stoop, and do not lean back all the time.
        figure.spine[0] += more[0].abs();
        figure.spine[1] += 0.7 * more[1];
        figure.spine[2] += more[2];
        figure.head[0] += more[3];
        figure.head[2] += 2.0 * more[4];
        figure.heading += more[5];
        for (arm, more) in figure.arms.iter_mut().zip(more[6..].chunks(3)) {
            arm.flexion += 1.5 * more[0];
            arm.abduction += more[1].abs();
            arm.elbow += 1.5 * more[2].abs();
        }
        figure
    }

    /// The motion's own time, and whether it goes on (1) or rests (0).
    fn own_time(&self, t_s: f32) -> (f32, f32) {
        let turns = self.turns_s.partition_point(|&turn_s| turn_s <= t_s);
        if self.turns_s.is_empty() {
            return (t_s, 1.0);
        }
        // It begins in motion, and each turn changes that.
        let moves = turns.is_multiple_of(2);
        let (since_s, passed_s) = match turns.checked_sub(1) {
            Some(last) => (t_s - self.turns_s[last], self.passed_s[last]),
            // The beginning is at full pace, as long after a turn.
            None => (t_s + STOPPING_S, -STOPPING_S),
        };
        // After a turn the pace changes over a while: its integral is the time that passes.
        let x = (since_s / STOPPING_S).min(1.0);
        let eased_s = STOPPING_S * x * x * x * (x * (x - 3.0) + 2.5);
        let lag_s = 0.5 * STOPPING_S;
        let (own_s, moving) = if moves {
            (passed_s + lag_s + eased_s + (since_s - STOPPING_S).max(0.0), ease(x))
        } else {
            (passed_s + STOPPING_S * x - eased_s, 1.0 - ease(x))
        };
        (own_s, moving)
    }
}

impl std::fmt::Debug for Performance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Performance").field("turns_s", &self.turns_s).finish_non_exhaustive()
    }
}
