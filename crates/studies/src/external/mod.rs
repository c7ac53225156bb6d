//! Networks of others that estimate poses on images, run from their ONNX files.
//!
//! The systems that MoveEnet is compared with are run, not imitated: files are the user's, the
//! runtime is tract (feature `onnx`), and decoders are ours ([`evpose_pose::body`]).
//!
//! * [`OpenPose`]: OpenPose's networks of 18 or 25 parts, and lightweight OpenPose.
//! * [`MoveNet`]: Google's single-pose models.
//! * [`ImageNetwork`]: all of them, from a grey image to thirteen joints.
//! * [`Letterbox`]: an image in the input of a network, its aspect ratio kept.
//!
//! ```
//! use std::path::Path;
//! use evpose_studies::external::MoveNet;
//!
//! // Without the file, or without the feature, the error says what to do.
//! let error = MoveNet::open(Path::new("movenet.onnx")).err().map(|error| error.to_string());
//! assert!(error.is_some_and(|error| error.starts_with("movenet.onnx: ")));
//! ```

mod letterbox;
mod movenet;
mod openpose;
#[cfg_attr(not(feature = "onnx"), path = "no_runtime.rs")]
mod runtime;

use anyhow::Result;
use evpose_core::Plane;
use evpose_pose::body::{BODY_JOINTS, BodyJoint};

pub use letterbox::Letterbox;
pub use movenet::MoveNet;
pub use openpose::OpenPose;

/// A network that finds the joints of a person on an image.
pub trait ImageNetwork: Send + Sync {
    /// The thirteen joints, in the order of networks, relative to the width and the height of a
    /// grey image.
    ///
    /// # Errors
    /// If the network cannot be run.
    fn joints(&self, image: &Plane<u8>) -> Result<[BodyJoint; BODY_JOINTS]>;

    /// The network in a line: kind, size of its input.
    fn description(&self) -> String;
}
