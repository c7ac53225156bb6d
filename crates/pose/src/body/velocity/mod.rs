//! How fast the joints of a body move in the image, told by the events about them.
//!
//! * [`TripletVelocity`]: from the times at which edges came past three pixels in a row.
//! * [`TripletVelocityConfig`], [`FlowAverage`]: how far it looks, and what it makes of what it sees.
//! * [`JointVelocity`]: what it says of a joint.

mod average;
mod config;
mod surface;
#[cfg(test)]
mod tests;
mod triplet;

pub use config::{FlowAverage, TripletVelocityConfig, WHOLE_SKELETON_GAIN};
pub use triplet::{JointVelocity, TripletVelocity};
