//! Recordings of event cameras put right: events in, events out.
//!
//! * [`CLEANERS`], [`CleanRequest`]: all cleaners by name, with their parameters.
//! * [`Chain`]: several of them, one after the other, batch by batch, with counts of what each removed.
//! * [`Undistort`]: straightens the lens; [`CameraFile`] holds a camera.
//! * [`Background`]: removes events that no neighbour confirms.
//! * [`HotPixels`], [`Activity`]: finds pixels that fire without a cause; [`Mask`], [`Masking`]: removes them.
//! * [`Deflicker`]: removes single pixels where a lamp makes all of them fire.
//! * [`Checkup`]: what a recording alone tells of its axes, polarities and time stamps; [`symmetry`]: what
//!   it tells beside reference events of the same scene.
//!
//! What published programs do differently is a preset, with their name.

mod activity;
mod background;
mod camera_file;
mod chain;
mod checkup;
mod cleaner;
mod deflicker;
mod error;
mod hot;
mod mask;
mod masking;
mod registry;
mod settings;
mod spec;
pub mod symmetry;
mod undistort;

#[cfg(test)]
mod laws;

pub use activity::{Activity, HotPixel, HotRule};
pub use background::{Background, BackgroundOptions};
pub use camera_file::CameraFile;
pub use chain::{Chain, CleanReport};
pub use checkup::{Checkup, Findings, Fit};
pub use cleaner::{Cleaner, Note};
pub use deflicker::{Deflicker, DeflickerOptions, Rule};
pub use error::CleanError;
pub use hot::HotPixels;
pub use mask::{Mask, Rectangle};
pub use masking::Masking;
pub use registry::{CLEANERS, CleanRequest, cleaner_by_name};
pub use settings::{Kind, ParamSpec, Settings};
pub use spec::{Build, CleanerSpec};
pub use undistort::{Inverse, Outside, Rounding, TOLERANCE_PX, Undistort, UndistortOptions};
