//! A format of body labels, and the labels as they are read.

use std::path::Path;

use evpose_core::bytes_without_bom;
use evpose_pose::body::BodyPoints;

use crate::import::ImportError;
use crate::import::clock::ImageTime;

/// Labels of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelledImage {
    /// Time of the image in its recording.
    pub time: ImageTime,
    /// Width and height of the image that the labels are on, in pixels; none where it is not known.
    pub size_px: Option<[f32; 2]>,
    /// Joints of each person, in pixels; empty for an image without annotations.
    pub persons: Vec<BodyPoints>,
}

/// A format of body labels. Adding one is a file with its `FORMAT` and a line of
/// [`BODY_LABEL_FORMATS`](super::BODY_LABEL_FORMATS).
#[derive(Debug)]
pub struct BodyLabelFormat {
    /// Name, as `--format` takes it.
    pub name: &'static str,
    /// Content in a few words.
    pub summary: &'static str,
    /// Whether a file is of this format, by its path and its first bytes.
    pub(super) detect: fn(&Path, &[u8]) -> bool,
    /// Reads the labels of a file, in its order.
    pub(super) read: fn(&Path) -> Result<Vec<LabelledImage>, ImportError>,
}

/// Whether a path has an ending, in either case.
pub(super) fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending))
}

/// The first character of a text that is not white space.
pub(super) fn first_character(start: &[u8]) -> Option<u8> {
    bytes_without_bom(start).iter().copied().find(|byte| !byte.is_ascii_whitespace())
}
