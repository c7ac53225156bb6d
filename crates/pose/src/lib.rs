//! Poses of hands and bodies, temporal filters, and metrics with confidence intervals. No Burn.
//!
//! * [`HandParams`]: the 12 parameters that EventHands regresses.
//! * [`HandSide`], [`Mirror`]: left hands as mirrored right ones.
//! * [`body`]: joints decoded from the maps of a network, their velocities, and the fusion of both.
//! * [`EVALUATION_JOINTS`]: the 21 points of the hand that are evaluated, in their published order,
//!   and [`HAND_BONES`] between them.
//! * [`filter`]: smoothing over time.
//! * [`metric`]: errors, curves under which areas are taken, and intervals.
//! * [`stream`]: the halves of the stream from events to poses, [`PoseEstimate`]: a pose of any task.
//! * [`rotation`]: axis-angle vectors, matrices, distances.
//!
//! ```
//! use evpose_pose::metric::HandEvaluation;
//! use evpose_pose::metric::SequenceScores;
//! use evpose_pose::{HandParams, PARAMETERS};
//! use evpose_core::stats::bootstrap::BootstrapConfig;
//!
//! // The regressed values of a network: articulation, wrist in metres, rotation in radians.
//! let truth = HandParams::from_array([0.0; PARAMETERS]);
//! let mut predicted = truth;
//! predicted.translation_m.x = 0.03;
//!
//! // Two sequences of one frame each.
//! let mut scores = SequenceScores::default();
//! scores.push_parameters(&predicted, &truth);
//! let evaluation = HandEvaluation { sequences: vec![scores.clone(), scores] };
//! let error = evaluation.summary(&BootstrapConfig::default()).translation_mm.expect("frames");
//! assert!((error.estimate - 30.0).abs() < 1e-3);
//! assert_eq!(error.low, error.high, "equal sequences have no spread");
//! ```

pub mod body;
mod error;
mod estimate;
pub mod filter;
mod hand_params;
mod hand_pose;
mod layout;
pub mod metric;
pub mod rotation;
mod side;
pub mod stream;

pub use error::PoseError;
pub use estimate::{JointFrame, PoseEstimate, PoseOrigin};
pub use hand_params::{EVALUATION_JOINTS, HAND_BONES, HandParams, PARAMETER_NAMES, PARAMETERS};
pub use hand_pose::{DIGIT_JOINTS, HandJoints, HandPose};
pub use layout::{POSE_LAYOUTS, PoseLayout};
pub use side::{HandSide, Mirror};
