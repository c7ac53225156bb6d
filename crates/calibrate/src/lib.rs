//! Numbers of an event camera, from recordings made for it.
//!
//! * [`threshold`]: frames and events of a moving pattern; contrast thresholds by totals (what all
//!   events together stand for) and by the steps of single pixels.
//! * [`noise`]: a recording of a scene at rest; background rates and hot pixels.
//!
//! Every number comes with an interval. Intervals are bootstrapped over parts of the image, or of
//! time, within which events resemble each other.

mod error;
pub mod noise;
mod steps;
pub mod threshold;
mod tiles;

pub use error::CalibrateError;
pub use evpose_pose::metric::Interval;
