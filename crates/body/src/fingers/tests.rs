//! Gestures on skeletons: the procedural right hand, and its mirror image.

use std::sync::LazyLock;

use evpose_pose::HandSide;
use glam::Vec3;

use super::angles::{HandAngles, THUMB};
use super::{FingerAxes, GESTURES, Gesture};
use crate::skeleton::{LEFT_HAND, LEFT_WRIST};
use crate::{BodyModel, BodyPose, PosedBody, ShapedBody};

static ARM: LazyLock<(BodyModel, ShapedBody)> = LazyLock::new(|| {
    let model = BodyModel::procedural_arm();
    let shaped = model.shaped(&[]);
    (model, shaped)
});

/// Joints of the hand of `side` with these angles, each digit with its tip (of the right hand), in
/// the order of the angles.
fn posed(side: HandSide, angles: &HandAngles) -> [[Vec3; 4]; 5] {
    let (mut model, shaped) = ARM.clone();
    if !side.is_right() {
        (model.wrist, model.right_hand.first_joint) = (LEFT_WRIST, LEFT_HAND);
    }
    let mut pose = BodyPose::rest(&model);
    let rotations = FingerAxes::new(&model, &shaped, side).rotations(angles);
    pose.set_hand_rotations(&model.right_hand, &rotations);
    let mut body = PosedBody::default();
    model.pose(&shaped, &pose, &mut body);
    let points = body.evaluation_points(&model);
    // The order of evaluated joints: index, middle, pinky, ring, thumb.
    let first = [18, 6, 9, 15, 12];
    std::array::from_fn(|digit| {
        let base = first[digit];
        [points[base], points[base + 1], points[base + 2], points[1 + digit]]
    })
}

fn with(digit: usize, values: [f32; 4]) -> HandAngles {
    let mut angles = HandAngles::from_fn(|_, _| 0.0);
    angles.digits[digit] = values;
    angles
}

/// Right hand at rest: distal is -x, palmar -y and radial z, up to the slope of the middle knuckle.
#[test]
fn angles_are_those_of_the_bones() {
    for digit in 1..5 {
        for [spread, mcp, pip] in
            [[0.0, 0.0, 0.0], [0.3, 0.0, 0.5], [0.0, 1.3, 1.1], [-0.2, 0.6, 0.0]]
        {
            let [a, b, c, _] = posed(HandSide::Right, &with(digit, [spread, mcp, pip, 0.0]))[digit];
            let (first, second) = ((b - a).normalize(), (c - b).normalize());
            // Out of the palm's plane by the flexion, but for what spread tilts.
            let palmar = -first.y;
            assert!((palmar - (mcp.sin() * spread.cos())).abs() < 0.12, "{digit}: {palmar} {mcp}");
            // In the plane by the spread, where it is not flexed.
            let aside = first.z.atan2(-first.x);
            assert!(mcp > 0.0 || (aside - spread).abs() < 0.04, "{digit}: {aside} {spread}");
            let bent = first.angle_between(second);
            assert!((bent - pip).abs() < 0.05, "{digit}: {bent} {pip}");
        }
    }
    for [abduction, flexion] in [[0.1, -0.6], [0.9, 0.0], [0.5, -1.2]] {
        let [a, b, ..] =
            posed(HandSide::Right, &with(THUMB, [abduction, flexion, 0.0, 0.0]))[THUMB];
        let bone = (b - a).normalize();
        assert!((bone.y + f32::sin(abduction)).abs() < 0.05, "{bone}");
        assert!((bone.z.atan2(-bone.x) + flexion).abs() < 0.1, "{bone}");
    }
}

#[test]
fn left_hands_are_mirror_images() {
    for gesture in &GESTURES {
        let [right, left] =
            [HandSide::Right, HandSide::Left].map(|side| posed(side, &gesture.angles()));
        for (digit, (right, left)) in right.iter().zip(&left).enumerate() {
            // Tips are vertices, of the right hand alone.
            for (a, b) in right.iter().zip(left).take(3) {
                let mirrored = Vec3::new(-a.x, a.y, a.z);
                assert!(mirrored.distance(*b) < 1e-5, "{} {digit}: {a} {b}", gesture.name);
            }
        }
    }
}

#[test]
fn gestures_are_what_their_names_say() {
    let hand = |name: &str| posed(HandSide::Right, &Gesture::named(name).unwrap().angles());
    let tips_mm = |name: &str, a: usize, b: usize| {
        let hand = hand(name);
        1e3 * hand[a][3].distance(hand[b][3])
    };
    let [thumb, index, middle, ring, pinky] = [0, 1, 2, 3, 4];
    // Pads touch a few millimetres behind the tips.
    for (name, other) in
        [("ok", index), ("pinch", index), ("O", index), ("O", middle), ("D", middle)]
    {
        assert!(tips_mm(name, thumb, other) < 16.0, "{name}: {}", tips_mm(name, thumb, other));
    }
    assert!(tips_mm("victory", index, middle) > 50.0 && tips_mm("U", index, middle) < 35.0);
    assert!(tips_mm("shaka", thumb, pinky) > 150.0 && tips_mm("fist", thumb, pinky) < 80.0);
    // In front of the knuckle or bent back to the palm.
    let is_stretched = |name: &str, digit: usize| {
        let [knuckle, .., tip] = hand(name)[digit];
        1e3 * knuckle.distance(tip) > 65.0
    };
    for (name, want) in [
        ("fist", [false; 4]),
        ("open", [true; 4]),
        ("point", [true, false, false, false]),
        ("victory", [true, true, false, false]),
        ("W", [true, true, true, false]),
        ("horns", [true, false, false, true]),
        ("I", [false, false, false, true]),
    ] {
        assert_eq!(
            [index, middle, ring, pinky].map(|digit| is_stretched(name, digit)),
            want,
            "{name}"
        );
    }
}

/// Nearest distance of two segments, by samples.
fn distance_m([a, b]: [Vec3; 2], [c, d]: [Vec3; 2]) -> f32 {
    let at = |from: Vec3, to: Vec3, k: usize| from.lerp(to, k as f32 / 16.0);
    let pairs = (0..=16).flat_map(|i| (0..=16).map(move |j| (i, j)));
    pairs.map(|(i, j)| at(a, b, i).distance(at(c, d, j))).fold(f32::INFINITY, f32::min)
}

/// Bones of the thumb have radii of about 10 mm, those of fingers of 8 mm.
#[test]
fn no_thumb_goes_through_a_finger() {
    for gesture in &GESTURES {
        let hand = posed(HandSide::Right, &gesture.angles());
        // The last segment without the ball of the tip.
        let bone = |digit: usize, k: usize| {
            let [from, to] = [hand[digit][k], hand[digit][k + 1]];
            [from, if k == 2 { from.lerp(to, 0.7) } else { to }]
        };
        for digit in 1..5 {
            for k in 0..3 {
                for of_thumb in [1, 2] {
                    let between_mm = 1e3 * distance_m(bone(THUMB, of_thumb), bone(digit, k));
                    assert!(between_mm > 11.0, "{} {digit} {k}: {between_mm} mm", gesture.name);
                }
            }
        }
    }
}
