//! The angles of a hand's joints as anatomy names them, with limits and couplings.
//!
//! # Model
//! Four angles a digit, in radians, zero being a straight digit along the middle metacarpal:
//!
//! | | 0 | 1 | 2 | 3 |
//! |---|---|---|---|---|
//! | thumb | palmar abduction, out of the palm's plane | CMC flexion across the palm, negative towards the side | MCP flexion | IP flexion |
//! | fingers | spread towards the thumb's side | MCP flexion | PIP flexion | DIP flexion |
//!
//! Joints are not independent: the tendon that bends a DIP joint bends its PIP joint as well, by
//! half as much again, the ring finger follows its neighbours, and bent fingers cannot spread.
//!
//! # Source
//! Lee, Kunii: *Model-based analysis of hand posture* (IEEE Computer Graphics and Applications
//! 15(5), 1995) and Lin, Wu, Huang: *Modeling the constraints of human hand motion* (Workshop on
//! Human Motion, 2000) for DIP = 2/3 PIP and the kinds of limits. Their values here are ours: those
//! that the gestures of [`GESTURES`](super::GESTURES) need, and the ring finger's share by eye.

use evpose_core::CounterRng;

/// Number of digits: thumb, index, middle, ring, pinky.
pub const DIGITS: usize = 5;
/// Index of the thumb.
pub const THUMB: usize = 0;
const INDEX: usize = 1;
const MIDDLE: usize = 2;
const RING: usize = 3;
const PINKY: usize = 4;

/// DIP flexion per PIP flexion.
pub const DIP_PER_PIP: f32 = 2.0 / 3.0;
/// Share of the ring finger's flexion that is that of its neighbours: tendons connect them.
const RING_FOLLOWS: f32 = 0.35;
/// MCP flexion at which fingers no longer spread: the ligaments beside the joint are taut.
const NO_SPREAD_RAD: f32 = 1.5;

/// Least and largest angles of the thumb, in degrees.
const THUMB_LIMITS_DEG: [[f32; 2]; 4] = [[0.0, 75.0], [-80.0, 48.0], [-15.0, 60.0], [-25.0, 80.0]];
/// Least and largest angles of a finger, in degrees.
const FINGER_LIMITS_DEG: [[f32; 2]; 4] =
    [[-28.0, 28.0], [-25.0, 95.0], [-5.0, 112.0], [-8.0, 78.0]];

/// Angles of the joints of a hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandAngles {
    /// Angles of thumb, index, middle, ring and pinky, in radians; columns as in the table of the
    /// [module](self).
    pub digits: [[f32; 4]; DIGITS],
}

impl HandAngles {
    /// Every angle by its digit and column.
    pub fn from_fn(mut angle: impl FnMut(usize, usize) -> f32) -> Self {
        Self { digits: std::array::from_fn(|digit| std::array::from_fn(|k| angle(digit, k))) }
    }

    /// Least and largest value of an angle, in radians.
    pub fn limits(digit: usize, k: usize) -> [f32; 2] {
        let limits = if digit == THUMB { THUMB_LIMITS_DEG } else { FINGER_LIMITS_DEG };
        limits[k].map(f32::to_radians)
    }

    /// The nearest hand within the limits of its joints.
    #[must_use]
    pub fn clamped(&self) -> Self {
        Self::from_fn(|digit, k| {
            let [low, high] = Self::limits(digit, k);
            self.digits[digit][k].clamp(low, high)
        })
    }

    /// The hand with the couplings of a hand that takes no care: the ring finger follows its
    /// neighbours in part, and fingers that are bent do not spread.
    #[must_use]
    pub fn coupled(&self) -> Self {
        let mut digits = self.digits;
        let (middle, pinky) = (digits[MIDDLE], digits[PINKY]);
        // Spread is every finger's own.
        let flexions = digits[RING].iter_mut().zip(middle.iter().zip(&pinky)).skip(1);
        for (ring, (middle, pinky)) in flexions {
            *ring += RING_FOLLOWS * (0.5 * (middle + pinky) - *ring);
        }
        for finger in &mut digits[INDEX..] {
            let [low, high] = FINGER_LIMITS_DEG[0].map(f32::to_radians);
            let free = 1.0 - (finger[1] / NO_SPREAD_RAD).clamp(0.0, 1.0);
            finger[0] = finger[0].clamp(low * free, high * free);
        }
        Self { digits }
    }

    /// The hand at the share `shares[digit]` of the way to `to`, digit by digit.
    #[must_use]
    pub fn towards(&self, to: &Self, shares: &[f32; DIGITS]) -> Self {
        Self::from_fn(|digit, k| {
            let (from, to) = (self.digits[digit][k], to.digits[digit][k]);
            from + (to - from) * shares[digit]
        })
    }

    /// The hand as another person, or the same one less carefully, makes it: every joint differs by
    /// a few degrees times `sloppiness`, and DIP joints go with their PIP joints.
    #[must_use]
    pub fn varied(&self, sloppiness: f32, rng: &mut CounterRng) -> Self {
        let mut off = |sd_deg: f32| (sloppiness * sd_deg).to_radians() * rng.normal();
        // Some hands are closed more than others as a whole.
        let closed = off(4.0);
        let mut digits = self.digits;
        for (digit, angles) in digits.iter_mut().enumerate() {
            let changes = if digit == THUMB {
                [off(5.0), off(5.0), off(6.0), off(7.0)]
            } else {
                let pip = closed + off(6.0);
                [off(2.5), closed + off(5.0), pip, DIP_PER_PIP * pip + off(3.0)]
            };
            angles.iter_mut().zip(changes).for_each(|(angle, change)| *angle += change);
        }
        Self { digits }.clamped()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fingers::GESTURES;

    #[test]
    fn the_ring_finger_follows_and_bent_fingers_do_not_spread() {
        let mut hand = HandAngles::from_fn(|_, _| 0.0);
        hand.digits[MIDDLE][1] = 1.0;
        hand.digits[PINKY][1] = 1.0;
        hand.digits[INDEX] = [0.4, NO_SPREAD_RAD, 0.0, 0.0];
        hand.digits[PINKY][0] = -0.4;
        let coupled = hand.coupled();
        assert!((coupled.digits[RING][1] - RING_FOLLOWS).abs() < 1e-6);
        assert_eq!(coupled.digits[INDEX][0], 0.0);
        let free = (1.0 - 1.0 / NO_SPREAD_RAD) * 28.0_f32.to_radians();
        assert!((coupled.digits[PINKY][0] + free).abs() < 1e-6);
    }

    #[test]
    fn variations_are_within_limits_and_a_few_degrees_wide() {
        let fist = GESTURES[0].angles();
        let mut squares = [[0.0_f32; 4]; DIGITS];
        let n = 2_000;
        for draw in 0..n {
            let hand = fist.varied(1.0, &mut CounterRng::new(5, "variation", draw));
            assert_eq!(hand, hand.clamped());
            for (sum, (got, from)) in squares
                .as_flattened_mut()
                .iter_mut()
                .zip(hand.digits.as_flattened().iter().zip(fist.digits.as_flattened()))
            {
                *sum += (got - from).powi(2) / n as f32;
            }
        }
        // MCP of the middle finger: 4 and 5 degrees, independent.
        let sd_deg = squares[MIDDLE][1].sqrt().to_degrees();
        assert!((sd_deg - 6.4).abs() < 0.5, "{sd_deg}");
        assert_eq!(fist.varied(0.0, &mut CounterRng::new(5, "variation", 0)), fist);
    }

    #[test]
    fn digits_go_their_own_way() {
        let [a, b] = [0.0, 1.0].map(|angle| HandAngles::from_fn(|_, _| angle));
        let way = a.towards(&b, &[0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(way, HandAngles::from_fn(|digit, _| 0.25 * digit as f32));
    }
}
