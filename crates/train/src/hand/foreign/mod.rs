//! Recordings that no simulation of this project made: other hands, cameras and pixels, with joints
//! for labels instead of parameters.
//!
//! A directory holds, for each recording, `07.npz` (or any other format of events), `07.joints.csv`
//! and `07.toml`: size and calibration of the camera, the side of the hand, and credits.

mod evaluation;
mod joint_table;
mod recording;

pub use evaluation::{
    ForeignHandResults, ForeignHandView, evaluate_foreign_hands, foreign_hand_views,
};
pub use joint_table::{HandJointRow, HandJointTable};
pub use recording::{ForeignHand, foreign_hands};
