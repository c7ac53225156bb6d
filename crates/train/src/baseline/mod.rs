//! The networks that MoveEnet is compared with: trained and evaluated as it is.
//!
//! * [`baseline_frames`]: the images of recordings, with what the network learns from them.
//! * [`train_baseline`]: a run in its directory, resumable to the bit.
//! * [`evaluate_baseline`]: evaluation of a network on recordings, on the image and in metres.

mod batches;
mod blur;
mod evaluation;
mod learner;
mod training;

pub use evaluation::{BaselineResults, evaluate_baseline};
pub use training::{baseline_frames, train_baseline};
