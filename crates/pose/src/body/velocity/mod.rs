//! Velocities of the joints of a body in the image, measured from the events around them.
//!
//! * [`TripletVelocity`]: from the times at which edges came past three pixels in a row.
//! * [`TripletVelocityConfig`], [`FlowAverage`]: its radius, tolerance and average.
//! * [`JointVelocity`]: the velocity of a joint, and the samples it is the mean of.

mod active_events;
mod average;
mod config;
#[cfg(test)]
mod tests;
mod triplet;

pub use config::{FlowAverage, TripletVelocityConfig, WHOLE_SKELETON_GAIN};
pub use triplet::{JointVelocity, TripletVelocity};
