//! Poses, the filters that smooth them over time, and the metrics that judge them. No Burn.
//!
//! * [`HandParams`]: the 12 numbers EventHands regresses.
//! * [`HandSide`], [`Mirror`]: left hands as mirrored right ones.
//! * [`body`]: the maps that a network tells of a body, and the joints in them.
//! * [`EVALUATION_JOINTS`]: the 21 points of the hand that are evaluated, in their published order,
//!   and [`HAND_BONES`] between them.
//! * [`filter`]: smoothing over time.
//! * [`metric`]: errors, curves under which areas are taken, and intervals.
//! * [`stream`]: the halves of the stream from events to poses, [`PoseEstimate`]: a pose of any task.
//! * [`rotation`]: axis-angle vectors, matrices, distances.

pub mod body;
mod error;
mod estimate;
pub mod filter;
mod hand_params;
pub mod metric;
pub mod rotation;
mod side;
pub mod stream;

pub use error::PoseError;
pub use estimate::PoseEstimate;
pub use hand_params::{EVALUATION_JOINTS, HAND_BONES, HandParams, PARAMETERS};
pub use side::{HandSide, Mirror};
