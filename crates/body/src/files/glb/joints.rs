//! The hand joints of WebXR, with the joint of the 16-joint model that each maps to.
//!
//! # Source
//! W3C, *WebXR Hand Input Module*, section 2.2: 25 joints; the y axis of a joint points out of the
//! back of the hand.

/// Number of joints of a hand, its wrist included.
pub(super) const HAND_SIZE: usize = 16;

/// Names, and the joint of the model that moves what they move: metacarpals other than the thumb's
/// move with the wrist, tips with the joint before them.
pub(super) const JOINTS: [(&str, usize); 25] = [
    ("wrist", 0),
    ("thumb-metacarpal", 13),
    ("thumb-phalanx-proximal", 14),
    ("thumb-phalanx-distal", 15),
    ("thumb-tip", 15),
    ("index-finger-metacarpal", 0),
    ("index-finger-phalanx-proximal", 1),
    ("index-finger-phalanx-intermediate", 2),
    ("index-finger-phalanx-distal", 3),
    ("index-finger-tip", 3),
    ("middle-finger-metacarpal", 0),
    ("middle-finger-phalanx-proximal", 4),
    ("middle-finger-phalanx-intermediate", 5),
    ("middle-finger-phalanx-distal", 6),
    ("middle-finger-tip", 6),
    ("ring-finger-metacarpal", 0),
    ("ring-finger-phalanx-proximal", 10),
    ("ring-finger-phalanx-intermediate", 11),
    ("ring-finger-phalanx-distal", 12),
    ("ring-finger-tip", 12),
    ("pinky-finger-metacarpal", 0),
    ("pinky-finger-phalanx-proximal", 7),
    ("pinky-finger-phalanx-intermediate", 8),
    ("pinky-finger-phalanx-distal", 9),
    ("pinky-finger-tip", 9),
];

/// Whether a joint of this name is required: the others follow a neighbour.
pub(super) fn is_needed(name: &str) -> bool {
    let follows = name.ends_with("-tip") || name.ends_with("finger-metacarpal");
    !follows
}
