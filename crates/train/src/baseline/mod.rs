//! The networks that MoveEnet is compared with: trained as it is.
//!
//! * [`baseline_frames`]: the images of recordings, with what the network learns from them.
//! * [`train_baseline`]: a run in its directory, resumable to the bit.

mod batches;
mod blur;
mod loss;
mod training;

pub use training::{baseline_frames, train_baseline};
