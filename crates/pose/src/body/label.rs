//! Annotations of the person in an image, the targets of training.

use glam::Vec2;

/// Visibility of a keypoint, as in COCO.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Visibility {
    /// Not labelled: its position is undefined.
    #[default]
    Unlabelled,
    /// Labelled and occluded.
    Hidden,
    /// Labelled and visible.
    Visible,
}

/// A joint of a label.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Keypoint {
    /// Column and row relative to the width and the height of the image.
    pub position: Vec2,
    /// Whether it is labelled, and occluded.
    pub visibility: Visibility,
}

impl Keypoint {
    /// Whether it is labelled.
    pub fn is_labelled(&self) -> bool {
        self.visibility != Visibility::Unlabelled
    }
}

/// The annotated person of an image. All lengths are relative to the image.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BodyLabel {
    /// Its joints, in the order of networks; thirteen of them as published.
    pub keypoints: Vec<Keypoint>,
    /// The middle of the person.
    pub center: Vec2,
    /// Size of the head, if it is known; in pixels in MPII's annotations.
    pub head_size: Option<f32>,
    /// Size of the head relative to the image, if it is known.
    pub head_size_scaled: Option<f32>,
    /// Length of the torso, if it is known.
    pub torso_size: Option<f32>,
    /// Middles of other persons in the image.
    pub other_centers: Vec<Vec2>,
    /// Joints of other persons: for each joint, where others have it.
    pub other_keypoints: Vec<Vec<Vec2>>,
}
