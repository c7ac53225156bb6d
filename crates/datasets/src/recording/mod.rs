//! Recordings of one camera with the joints of the one person in them, whatever data set they are
//! of.
//!
//! * [`LabelledRecording`]: events and the joints at instants.
//! * [`body_label`]: joints in pixels as the label of an image.
//! * [`write_eros_frames`]: the EROS images that a network is trained on, an image for each
//!   instant.
//! * [`FrameSet`]: those of many recordings, some to train and some to test on.

mod eros_frames;
mod frame_set;
mod label;

use evpose_core::{EventStream, Micros};
use evpose_pose::body::BodyPoints;

pub use eros_frames::{ErosFrameOptions, ErosStyle, write_eros_frames};
pub use frame_set::FrameSet;
pub use label::{TorsoRule, body_label};

/// Events of one camera and where the joints of the person were.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelledRecording {
    /// Stem of its files: `S1_2_5_ch3`, `cam2_S9_Walking_1`.
    pub name: String,
    /// The events. Their first instant is that of `bodies`.
    pub events: EventStream,
    /// The joints, in order of time.
    pub bodies: Vec<TimedBody>,
}

/// The joints of a person at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedBody {
    /// When, on the clock of the events.
    pub t: Micros,
    /// Positions in pixels.
    pub points_px: BodyPoints,
}
