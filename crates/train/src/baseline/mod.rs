//! The networks that MoveEnet is compared with: trained as it is.
//!
//! * [`baseline_frames`]: the images of recordings, with what the network learns from them.
//! * [`evaluate_baseline`]: the scores of what is inferred of recordings.
//! * [`train_baseline`]: a run in its directory, resumable to the bit.
//!
//! The file of its name has what one of the two has alone.

mod batches;
mod dhp19;
mod evaluation;
mod lift_mono;
mod loss;
mod training;

pub use evaluation::evaluate_baseline;
pub use training::{baseline_frames, train_baseline};
