//! Fingers that move by themselves: anatomical angles, named gestures, and motion between them.
//!
//! * [`HandAngles`]: four angles of each digit, their limits and couplings ([`angles`]).
//! * [`GESTURES`]: hands that people make, as a table of angles ([`gesture`]).
//! * [`FingerMotion`]: gestures, mixtures of them and random hands, one after the other ([`motion`]).
//! * [`FingerAxes`]: the axes of a model's joints, by which angles become rotations ([`axes`]).
//!
//! The six articulation coefficients of the published motion move all fingers together; here every
//! finger has its own target. [`HandBasis::coefficients`] says which coefficients come closest.
//!
//! [`HandBasis::coefficients`]: crate::HandBasis::coefficients

pub mod angles;
pub mod axes;
mod coefficients;
pub mod gesture;
pub mod motion;
#[cfg(test)]
mod tests;

pub use angles::HandAngles;
pub use axes::{FingerAxes, HandRotations};
pub use gesture::{GESTURES, Gesture};
pub use motion::FingerMotion;

use serde::{Deserialize, Serialize};

/// Source of the motion of fingers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fingers {
    /// Random articulation coefficients, as published.
    #[default]
    Components,
    /// Gestures: [`FingerMotion`].
    Gestures,
}

impl Fingers {
    /// Whether fingers move as published.
    pub fn is_components(&self) -> bool {
        *self == Self::Components
    }
}
