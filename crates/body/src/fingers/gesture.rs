//! Hands that people make, by name.
//!
//! Angles are those of photographs of hands, by eye; a thumb that touches fingers has the angles at
//! which its pad meets them on the procedural hand without going through them. Letters are those of
//! the American manual alphabet. Nobody makes a gesture twice in the same way:
//! [`HandAngles::varied`].

use super::HandAngles;
use super::angles::DIP_PER_PIP;

/// A hand that people make.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gesture {
    /// Its name, one word.
    pub name: &'static str,
    /// Angles of thumb, index, middle, ring and pinky, in degrees.
    pub degrees: [[f32; 4]; 5],
}

impl Gesture {
    /// Its angles.
    pub fn angles(&self) -> HandAngles {
        HandAngles::from_fn(|digit, k| self.degrees[digit][k].to_radians())
    }

    /// The gesture of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        GESTURES.iter().find(|gesture| gesture.name == name)
    }
}

/// A finger of this spread, MCP and PIP flexion, whose DIP joint goes with the PIP joint.
const fn finger(spread: f32, mcp: f32, pip: f32) -> [f32; 4] {
    [spread, mcp, pip, pip * DIP_PER_PIP]
}

const fn gesture(name: &'static str, thumb: [f32; 4], fingers: [[f32; 4]; 4]) -> Gesture {
    let [index, middle, ring, pinky] = fingers;
    Gesture { name, degrees: [thumb, index, middle, ring, pinky] }
}

// Fingers of a fist.
const INDEX: [f32; 4] = [-1.0, 82.0, 100.0, 60.0];
const MIDDLE: [f32; 4] = [0.0, 86.0, 102.0, 62.0];
const RING: [f32; 4] = [0.0, 86.0, 102.0, 62.0];
const PINKY: [f32; 4] = [2.0, 86.0, 96.0, 60.0];
/// A finger that is stretched, with this spread.
const fn straight(spread: f32) -> [f32; 4] {
    [spread, -4.0, 4.0, 2.0]
}
/// The thumb on the middle phalanx of the ring finger.
const ON_RING: [f32; 4] = [70.0, 42.0, 53.0, 20.0];

/// All gestures.
pub const GESTURES: [Gesture; 32] = [
    gesture(
        "rest",
        [24.0, -36.0, 14.0, 18.0],
        [
            finger(0.0, 18.0, 28.0),
            finger(0.0, 24.0, 34.0),
            finger(-1.0, 28.0, 36.0),
            finger(-3.0, 30.0, 34.0),
        ],
    ),
    gesture(
        "flat",
        [6.0, -30.0, 4.0, 0.0],
        [
            finger(1.0, 2.0, 4.0),
            finger(0.0, 2.0, 4.0),
            finger(-2.0, 2.0, 4.0),
            finger(-4.0, 2.0, 4.0),
        ],
    ),
    gesture(
        "open",
        [26.0, -52.0, -5.0, -10.0],
        [
            finger(12.0, -8.0, 2.0),
            finger(1.0, -8.0, 2.0),
            finger(-10.0, -8.0, 2.0),
            finger(-22.0, -8.0, 2.0),
        ],
    ),
    gesture("fist", [67.0, 7.0, 36.0, 46.0], [INDEX, MIDDLE, RING, PINKY]),
    gesture("thumb", [8.0, -74.0, -10.0, -15.0], [INDEX, MIDDLE, RING, PINKY]),
    gesture("point", [72.0, 5.0, 47.0, 35.0], [straight(0.0), MIDDLE, RING, PINKY]),
    gesture("victory", ON_RING, [straight(13.0), straight(-10.0), RING, PINKY]),
    gesture("three", [15.0, -58.0, -5.0, -12.0], [straight(9.0), straight(-6.0), RING, PINKY]),
    gesture(
        "four",
        [55.0, 25.0, 40.0, 30.0],
        [straight(10.0), straight(2.0), straight(-7.0), straight(-16.0)],
    ),
    gesture("shaka", [12.0, -72.0, -8.0, -15.0], [INDEX, MIDDLE, RING, straight(-24.0)]),
    gesture("horns", [72.0, 12.0, 39.0, 56.0], [straight(5.0), MIDDLE, RING, straight(-10.0)]),
    gesture("love", [14.0, -66.0, -5.0, -12.0], [straight(6.0), MIDDLE, RING, straight(-18.0)]),
    gesture(
        "ok",
        [55.0, -15.0, 18.0, 22.0],
        [
            [-2.0, 48.0, 58.0, 20.0],
            finger(-2.0, 20.0, 22.0),
            finger(-6.0, 10.0, 14.0),
            finger(-16.0, 2.0, 6.0),
        ],
    ),
    gesture(
        "pinch",
        [57.0, 0.0, 19.0, -5.0],
        [
            [-2.0, 56.0, 44.0, 10.0],
            finger(0.0, 66.0, 76.0),
            finger(0.0, 74.0, 84.0),
            finger(2.0, 76.0, 84.0),
        ],
    ),
    gesture(
        "tripod",
        [53.0, 5.0, 18.0, -10.0],
        [
            [-2.0, 50.0, 46.0, 12.0],
            [-2.0, 56.0, 48.0, 16.0],
            finger(0.0, 72.0, 82.0),
            finger(2.0, 78.0, 86.0),
        ],
    ),
    gesture(
        "cylinder",
        [62.0, -12.0, 8.0, 18.0],
        [
            finger(2.0, 46.0, 54.0),
            finger(0.0, 50.0, 54.0),
            finger(-1.0, 54.0, 54.0),
            finger(-2.0, 58.0, 52.0),
        ],
    ),
    gesture(
        "sphere",
        [55.0, -24.0, 4.0, 14.0],
        [
            finger(14.0, 34.0, 34.0),
            finger(3.0, 34.0, 36.0),
            finger(-8.0, 36.0, 38.0),
            finger(-18.0, 38.0, 38.0),
        ],
    ),
    gesture(
        "hook",
        [10.0, -34.0, 10.0, 10.0],
        [
            finger(0.0, 4.0, 92.0),
            finger(0.0, 4.0, 94.0),
            finger(0.0, 6.0, 94.0),
            finger(0.0, 8.0, 90.0),
        ],
    ),
    gesture(
        "claw",
        [30.0, -50.0, 5.0, 40.0],
        [
            finger(10.0, -6.0, 66.0),
            finger(1.0, -6.0, 68.0),
            finger(-8.0, -6.0, 68.0),
            finger(-18.0, -6.0, 66.0),
        ],
    ),
    // Bent at the knuckles alone.
    gesture(
        "roof",
        [20.0, -30.0, 8.0, 5.0],
        [
            finger(0.0, 78.0, 4.0),
            finger(0.0, 82.0, 4.0),
            finger(0.0, 84.0, 4.0),
            finger(0.0, 84.0, 4.0),
        ],
    ),
    // The thumb on the side of the index finger, as on a key.
    gesture(
        "key",
        [30.0, -26.0, 10.0, 10.0],
        [
            [3.0, 58.0, 66.0, 40.0],
            finger(0.0, 66.0, 76.0),
            finger(0.0, 72.0, 80.0),
            finger(2.0, 76.0, 80.0),
        ],
    ),
    gesture("A", [18.0, -24.0, 4.0, 4.0], [INDEX, MIDDLE, RING, PINKY]),
    gesture(
        "B",
        [40.0, 30.0, 50.0, 30.0],
        [straight(1.0), straight(0.0), straight(-2.0), straight(-4.0)],
    ),
    gesture(
        "C",
        [48.0, -20.0, 5.0, 15.0],
        [
            [-1.0, 30.0, 48.0, 28.0],
            [0.0, 30.0, 48.0, 28.0],
            [0.0, 32.0, 48.0, 28.0],
            [1.0, 34.0, 46.0, 28.0],
        ],
    ),
    gesture(
        "D",
        [72.0, 20.0, 42.0, -5.0],
        [straight(1.0), [-2.0, 56.0, 58.0, 22.0], [0.0, 58.0, 60.0, 24.0], [2.0, 64.0, 60.0, 28.0]],
    ),
    gesture("I", [72.0, 4.0, 49.0, 31.0], [INDEX, MIDDLE, RING, straight(-8.0)]),
    gesture("L", [5.0, -76.0, -8.0, -12.0], [straight(2.0), MIDDLE, RING, PINKY]),
    gesture(
        "O",
        [72.0, 1.0, 36.0, 6.0],
        [
            [-2.0, 56.0, 58.0, 20.0],
            [0.0, 58.0, 58.0, 20.0],
            [2.0, 62.0, 56.0, 22.0],
            [5.0, 68.0, 50.0, 24.0],
        ],
    ),
    // Crossed: the middle finger lies on the index.
    gesture("R", ON_RING, [finger(-7.0, -4.0, 4.0), finger(9.0, 14.0, 12.0), RING, PINKY]),
    gesture("U", ON_RING, [straight(3.0), straight(-1.0), RING, PINKY]),
    gesture(
        "W",
        [57.0, 46.0, 42.0, 11.0],
        [straight(11.0), straight(1.0), straight(-10.0), finger(-2.0, 72.0, 80.0)],
    ),
    gesture("X", [70.0, 7.0, 41.0, 42.0], [[0.0, 6.0, 86.0, 48.0], MIDDLE, RING, PINKY]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_gesture_is_a_hand_that_joints_allow_and_none_is_there_twice() {
        for (index, gesture) in GESTURES.iter().enumerate() {
            let angles = gesture.angles();
            assert_eq!(angles, angles.clamped(), "{}", gesture.name);
            assert_eq!(Gesture::named(gesture.name), Some(gesture));
            for other in &GESTURES[..index] {
                let pairs = gesture.degrees.as_flattened().iter().zip(other.degrees.as_flattened());
                let furthest_deg = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(furthest_deg >= 9.0, "{} and {}", gesture.name, other.name);
            }
        }
        assert_eq!(Gesture::named("nothing"), None);
    }
}
