//! Where things are in the texture of the procedural arm.
//!
//! The layout has no seams: u runs along the limb, the same for all five digits, and v around it
//! from the back (0) over either side to the palm (1), as the angle between the rest pose's normal
//! and the back of the hand, divided by π. Both sides of a digit, and all digits, share texels.
//!
//! A crease across the joints is a line of constant u with v near 1, a nail the patch of u in
//! [`U_NAIL`] with v below [`V_NAIL`], the palm's lines lie between [`U_WRIST`] and [`U_KNUCKLE`].
//! For patterns that must not repeat, take the rest position ([`crate::BodyModel::template_m`]).

/// The inner end of the upper arm.
pub const U_SHOULDER: f32 = 0.0;
/// The elbow.
pub const U_ELBOW: f32 = 0.15;
/// The wrist.
pub const U_WRIST: f32 = 0.35;
/// First joints of the fingers; second joint of the thumb.
pub const U_KNUCKLE: f32 = 0.60;
/// Second joints of the fingers.
pub const U_MIDDLE_JOINT: f32 = 0.75;
/// Third joints of all digits.
pub const U_END_JOINT: f32 = 0.87;
/// Tips.
pub const U_TIP: f32 = 1.0;
/// The nails, from root to edge.
pub const U_NAIL: [f32; 2] = [0.925, 0.99];
/// The nails reach this far to either side.
pub const V_NAIL: f32 = 0.30;
