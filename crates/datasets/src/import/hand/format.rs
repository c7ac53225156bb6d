//! A format of hand labels, and the labels as they are read.

use evpose_core::Micros;
use evpose_pose::{HandParams, JointFrame};
use glam::{Vec2, Vec3};

use crate::import::ImportError;
use crate::import::table::Table;

/// Choice among the labels that a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LabelChoice {
    /// Joints on the image are read, even if there are some in metres.
    pub on_image: bool,
    /// Frame of joints in metres, of tables that do not state it; the camera's if none. One that a table
    /// contradicts is an error.
    pub frame: Option<JointFrame>,
}

/// Joints of a hand, in the order of [`evpose_pose::EVALUATION_JOINTS`]; none where not labelled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HandJoints {
    /// In metres, in a frame of coordinates.
    Metres([Option<Vec3>; 21], JointFrame),
    /// In pixels of the sensor.
    Pixels([Option<Vec2>; 21]),
}

/// A label of a hand at a time stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabelledHand<T> {
    /// Time stamp.
    pub t: Micros,
    /// Joints or parameters at that time.
    pub label: T,
}

/// Labels of a hand, in the order of time.
#[derive(Debug, Clone, PartialEq)]
pub enum HandLabels {
    /// Parameters in the world of the simulation.
    Parameters(Vec<LabelledHand<HandParams>>),
    /// Joints.
    Joints(Vec<LabelledHand<HandJoints>>),
}

/// A format of hand labels. Adding one is a file with its `FORMAT` and a line of
/// [`HAND_LABEL_FORMATS`](super::HAND_LABEL_FORMATS).
#[derive(Debug)]
pub struct HandLabelFormat {
    /// Name in messages.
    pub name: &'static str,
    /// Content in a few words.
    pub summary: &'static str,
    /// Whether a table is of this format, by the names of its columns.
    pub(super) detect: fn(&[String]) -> bool,
    /// Reads the labels of a table.
    pub(super) read: fn(&Table, LabelChoice) -> Result<HandLabels, ImportError>,
}
