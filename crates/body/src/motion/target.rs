//! Random target poses.
//!
//! # Model
//! `θ = ξ·gain + offset` for each of the generator's 78 parameters, ξ uniform and independent:
//! small for the 66 angles of the body and the left hand's coefficients, U(-2, 2) for the right
//! hand's. Gains pick out the arm: elbow (entries 57 to 59) and wrist (63 to 65), radians.
//!
//! # Source
//! EventHands, supplement Sec. 4.4, and its released simulator, which differ; see [`Variant`].

use evpose_core::CounterRng;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::pose::{GENERATOR_PARAMETERS, RIGHT_COEFFICIENTS};

/// Rotation of the pelvis about z.
const PELVIS_Z: usize = 2;
/// Rotation of the right collar about z: lowers the arm.
const COLLAR_Z: usize = 44;
/// Rotation of the right shoulder about z.
const SHOULDER_Z: usize = 53;
/// Twist of the right elbow, about the forearm.
const ELBOW_X: usize = 57;
/// Bend of the right elbow.
const ELBOW_Y: usize = 58;
/// Rotation of the right elbow about z.
const ELBOW_Z: usize = 59;
/// First of the three angles of the right wrist.
const WRIST_X: usize = 63;

/// Half-width of the right hand's coefficients.
pub(super) const ARTICULATION_RANGE: f32 = 2.0;
/// Half-width of all other draws in the program.
const PROGRAM_RANGE: f32 = 0.02;
/// Half-width of all other draws in the paper.
const PAPER_RANGE: f32 = 0.2;
/// The forearm is never near its middle twist: this much is added on one side or the other.
const TWIST_OFFSET: f32 = 1.4;
/// Twist of a forearm that turns the palm, or the back of the hand, towards the camera; without a twist it is the thumb.
const SHOWN_TWIST: f32 = std::f32::consts::FRAC_PI_2;

/// Distribution of the targets.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Variant {
    /// The released program, which made the released data. The arm comes from the side; draws are
    /// U(-0.02, 0.02), and the twist of 1.4 rad goes against the sign of what was drawn.
    #[default]
    Code,
    /// The text: draws are U(-0.2, 0.2), and the sign of the twist is a draw of its own. Taken by
    /// the word, it turns elbow and wrist by up to 20 and 8 rad.
    Paper,
    /// The text's second data set, with the arm from the bottom of the image and the elbow not
    /// bent. With the draws of the program, as those of the text cannot be meant.
    Bottom,
    /// Not published: as [`Self::Code`], with the palm or the back of the hand towards the camera to 0.5 rad, as
    /// people show gestures, and the elbow's and wrist's bends halved. One in five of the program's hands is seen so.
    Shown,
}

/// A pose of the generator: what a motion starts from, aims at and returns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// The 78 pose parameters, see [`crate::BodyPose::from_generator`].
    pub parameters: [f32; GENERATOR_PARAMETERS],
    /// Displacement of the body in metres.
    pub translation_m: Vec3,
}

/// A part of the body that can rest while others move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// The place of the arm, and all of the body but wrist and fingers.
    Arm,
    /// The three angles of the wrist.
    Wrist,
    /// The articulation of the hand.
    Fingers,
}

impl Part {
    pub(super) const ALL: [Self; 3] = [Self::Arm, Self::Wrist, Self::Fingers];
}

impl Target {
    /// The T-pose with resting hands where the model stands.
    pub const REST: Self =
        Self { parameters: [0.0; GENERATOR_PARAMETERS], translation_m: Vec3::ZERO };

    /// Draws a random pose.
    pub fn draw(variant: Variant, rng: &mut CounterRng) -> Self {
        let range = if variant == Variant::Paper { PAPER_RANGE } else { PROGRAM_RANGE };
        let mut parameters = std::array::from_fn(|entry| {
            let range = if entry < RIGHT_COEFFICIENTS { range } else { ARTICULATION_RANGE };
            rng.uniform(-range, range)
        });
        // Gains of the released program: they pick out the arm.
        parameters[ELBOW_X] *= if variant == Variant::Shown { 25.0 } else { 100.0 };
        parameters[ELBOW_Z] *= 10.0;
        let bend = if variant == Variant::Shown { 20.0 } else { 40.0 };
        if variant != Variant::Bottom {
            parameters[ELBOW_Y] *= bend;
        }
        for angle in &mut parameters[WRIST_X..WRIST_X + 3] {
            *angle *= bend;
        }

        let twist_is_negative = match variant {
            Variant::Code => parameters[ELBOW_X] > 0.0,
            Variant::Paper | Variant::Bottom | Variant::Shown => rng.chance(0.5),
        };
        let twist = if variant == Variant::Shown { SHOWN_TWIST } else { TWIST_OFFSET };
        parameters[ELBOW_X] += if twist_is_negative { -twist } else { twist };
        // Offsets of the released program as well.
        parameters[COLLAR_Z] += 0.2;
        parameters[SHOULDER_Z] += 0.1;
        parameters[ELBOW_Z] += 0.5;
        if variant == Variant::Bottom {
            parameters[PELVIS_Z] -= 2.3;
            parameters[ELBOW_X] -= 3.8;
        }

        let mut between = |low: [f32; 3], high: [f32; 3]| {
            Vec3::from_array(std::array::from_fn(|axis| rng.uniform(low[axis], high[axis])))
        };
        let translation_m = match variant {
            Variant::Code | Variant::Paper | Variant::Shown => {
                between([-0.3, -0.3, -0.09], [0.3, 0.3, 0.09])
            }
            Variant::Bottom => between([-1.5, -0.52, -0.09], [-0.9, 0.08, 0.09]),
        };
        Self { parameters, translation_m }
    }

    /// The point at `b` in [0, 1] of the quadratic Bezier curve over three poses, parameter by
    /// parameter.
    pub fn bezier([start, middle, end]: &[Self; 3], b: f32) -> Self {
        let [p, q, r] = [(1.0 - b) * (1.0 - b), 2.0 * b * (1.0 - b), b * b];
        Self {
            parameters: std::array::from_fn(|i| {
                p * start.parameters[i] + q * middle.parameters[i] + r * end.parameters[i]
            }),
            translation_m: p * start.translation_m
                + q * middle.translation_m
                + r * end.translation_m,
        }
    }

    /// Brings the articulation from the published range to that between `low` and `high`.
    pub(super) fn stretch_articulation(&mut self, low: &[f32; 6], high: &[f32; 6]) {
        let coefficients = &mut self.parameters[RIGHT_COEFFICIENTS..];
        for ((coefficient, low), high) in coefficients.iter_mut().zip(low).zip(high) {
            // Of the published range the factor is 1 and the offset 0: not a bit changes.
            let factor = (high - low) / (2.0 * ARTICULATION_RANGE);
            *coefficient = *coefficient * factor + 0.5 * (high + low);
        }
    }

    /// Takes over one part of another pose.
    pub(super) fn copy_part(&mut self, part: Part, from: &Self) {
        match part {
            Part::Arm => {
                self.translation_m = from.translation_m;
                // The wrist's three values are a part of their own.
                for range in [0..WRIST_X, WRIST_X + 3..RIGHT_COEFFICIENTS] {
                    self.parameters[range.clone()].copy_from_slice(&from.parameters[range]);
                }
            }
            Part::Wrist => {
                let wrist = WRIST_X..WRIST_X + 3;
                self.parameters[wrist.clone()].copy_from_slice(&from.parameters[wrist]);
            }
            Part::Fingers => {
                self.parameters[RIGHT_COEFFICIENTS..]
                    .copy_from_slice(&from.parameters[RIGHT_COEFFICIENTS..]);
            }
        }
    }

    /// Articulation coefficients of the right hand.
    pub fn articulation(&self) -> [f32; 6] {
        std::array::from_fn(|k| self.parameters[RIGHT_COEFFICIENTS + k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smallest and largest value of every parameter over many draws.
    fn ranges(variant: Variant) -> [[f32; 2]; GENERATOR_PARAMETERS] {
        let mut ranges = [[f32::INFINITY, f32::NEG_INFINITY]; GENERATOR_PARAMETERS];
        for k in 0..20_000 {
            let target = Target::draw(variant, &mut CounterRng::new(1, "target", k));
            for ([low, high], value) in ranges.iter_mut().zip(target.parameters) {
                *low = low.min(value);
                *high = high.max(value);
            }
        }
        ranges
    }

    fn assert_fills([low, high]: [f32; 2], [want_low, want_high]: [f32; 2]) {
        let slack = 0.01 * (want_high - want_low);
        assert!(low >= want_low - 1e-5 && low < want_low + slack, "{low} for {want_low}");
        assert!(high <= want_high + 1e-5 && high > want_high - slack, "{high} for {want_high}");
    }

    #[test]
    fn the_program_fills_the_published_ranges() {
        let ranges = ranges(Variant::Code);
        assert_fills(ranges[0], [-0.02, 0.02]);
        assert_fills(ranges[COLLAR_Z], [0.18, 0.22]);
        assert_fills(ranges[SHOULDER_Z], [0.08, 0.12]);
        assert_fills(ranges[ELBOW_X], [-1.4, 1.4]);
        assert_fills(ranges[ELBOW_Y], [-0.8, 0.8]);
        assert_fills(ranges[ELBOW_Z], [0.3, 0.7]);
        for entry in [63, 64, 65] {
            assert_fills(ranges[entry], [-0.8, 0.8]);
        }
        assert_fills(ranges[71], [-0.02, 0.02]);
        assert_fills(ranges[72], [-2.0, 2.0]);
        assert_fills(ranges[77], [-2.0, 2.0]);
    }

    /// Entry 57 is -1.4 plus a positive draw, or +1.4 plus a negative one, of at most 2: both
    /// halves overlap in [-0.6, 0.6], where values are twice as frequent.
    #[test]
    fn the_twist_of_the_program_goes_against_its_draw() {
        let n = 20_000;
        let draws = (0..n).map(|k| {
            Target::draw(Variant::Code, &mut CounterRng::new(2, "target", k)).parameters[ELBOW_X]
        });
        let inside = draws.filter(|twist| twist.abs() < 0.6).count() as f32 / n as f32;
        assert!((inside - 0.6).abs() < 0.02, "{inside}");
    }

    #[test]
    fn the_paper_turns_the_elbow_by_twenty_radians() {
        let ranges = ranges(Variant::Paper);
        assert_fills(ranges[ELBOW_X], [-21.4, 21.4]);
        assert_fills(ranges[ELBOW_Z], [-1.5, 2.5]);
        assert_fills(ranges[63], [-8.0, 8.0]);
    }

    #[test]
    fn the_bottom_set_turns_the_body_and_leaves_the_elbow_straight() {
        let ranges = ranges(Variant::Bottom);
        assert_fills(ranges[PELVIS_Z], [-2.32, -2.28]);
        assert_fills(ranges[ELBOW_Y], [-0.02, 0.02]);
        assert_fills(ranges[ELBOW_X], [-7.2, -0.4]);
        let target = Target::draw(Variant::Bottom, &mut CounterRng::new(1, "target", 0));
        assert!((-1.5..=-0.9).contains(&target.translation_m.x));
    }

    #[test]
    fn shown_hands_have_palm_or_back_towards_the_camera() {
        let twists = (0..1000).map(|k| {
            let target = Target::draw(Variant::Shown, &mut CounterRng::new(1, "target", k));
            assert!(target.parameters[ELBOW_Y].abs() <= 0.4);
            assert!(target.parameters[WRIST_X].abs() <= 0.4);
            target.parameters[ELBOW_X]
        });
        let twists: Vec<f32> = twists.collect();
        assert!(twists.iter().all(|twist| (1.07..2.08).contains(&twist.abs())));
        let palms = twists.iter().filter(|twist| **twist > 0.0).count();
        assert!((400..600).contains(&palms), "{palms}");
    }

    #[test]
    fn a_curve_begins_and_ends_at_its_ends_and_leaves_towards_the_middle() {
        let points =
            [0, 1, 2].map(|k| Target::draw(Variant::Code, &mut CounterRng::new(3, "t", k)));
        assert_eq!(Target::bezier(&points, 0.0), points[0]);
        assert_eq!(Target::bezier(&points, 1.0), points[2]);
        let half = Target::bezier(&points, 0.5).parameters[70];
        let want = 0.25 * points[0].parameters[70]
            + 0.5 * points[1].parameters[70]
            + 0.25 * points[2].parameters[70];
        assert!((half - want).abs() < 1e-7);
    }
}
