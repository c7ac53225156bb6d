//! Labels in the order of time.

use std::collections::HashMap;
use std::ops::Range;

use evpose_core::stats::quantile::upper_index;
use evpose_pose::body::{BodyPoints, torso};
use glam::Vec2;

use super::CheckOptions;
use crate::Annotation;
use crate::runs::runs;

/// A body at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackFrame {
    /// How to find it again: the image's file, say.
    pub name: String,
    /// When it was, in seconds, if that is known.
    pub t_s: Option<f64>,
    /// Its joints, in pixels or in any other unit that is the same in both directions.
    pub joints: BodyPoints,
}

impl TrackFrame {
    /// Position of a joint, if it is labelled and finite.
    pub(super) fn joint(&self, joint: usize) -> Option<Vec2> {
        self.joints[joint].filter(|point| point.is_finite())
    }
}

/// A body through time.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelTrack {
    /// How to find it again: the recording, say.
    pub name: String,
    /// The frames, in the order of time. A single one is a photograph: nothing is before or behind
    /// it.
    pub frames: Vec<TrackFrame>,
    /// Width and height of the image, in the unit of the joints, if they must be on it.
    pub image_size: Option<Vec2>,
}

/// Tracks of annotations, in the order in which they come: `sequence` names the one that each
/// belongs to.
///
/// Joints are brought from parts of an image of `image_size_px` into its pixels.
pub fn tracks_of<'a>(
    annotations: &'a [Annotation],
    image_size_px: Vec2,
    sequence: impl Fn(&'a Annotation) -> &'a str,
) -> Vec<LabelTrack> {
    let mut tracks: Vec<LabelTrack> = Vec::new();
    let mut known = HashMap::new();
    for annotation in annotations {
        let name = sequence(annotation);
        // Annotations of several recordings may be mixed in a file.
        let index = *known.entry(name).or_insert_with(|| {
            let (name, image_size) = (name.to_owned(), Some(image_size_px));
            tracks.push(LabelTrack { name, frames: Vec::new(), image_size });
            tracks.len() - 1
        });
        let mut joints = BodyPoints::default();
        for (joint, keypoint) in joints.iter_mut().zip(&annotation.label.keypoints) {
            *joint = keypoint.is_labelled().then(|| keypoint.position * image_size_px);
        }
        let frame = TrackFrame { name: annotation.image.clone(), t_s: annotation.t_s, joints };
        tracks[index].frames.push(frame);
    }
    tracks
}

impl LabelTrack {
    /// Position of a joint, if it is labelled and finite.
    pub(super) fn joint(&self, frame: usize, joint: usize) -> Option<Vec2> {
        self.frames[frame].joint(joint)
    }

    /// Length of the torso around each frame: the median of those near it, which one wrong joint
    /// does not change.
    pub(super) fn torsos(&self, options: &CheckOptions) -> Vec<Option<f32>> {
        let lengths: Vec<Option<f32>> = self
            .frames
            .iter()
            .map(|frame| torso(&frame.joints).filter(|length| length.is_finite() && *length > 0.0))
            .collect();
        let around = |frame: usize| {
            let first = frame.saturating_sub(options.torso_frames);
            let last = (frame + options.torso_frames).min(lengths.len() - 1);
            median(lengths[first..=last].iter().flatten().copied().collect())
        };
        (0..lengths.len()).map(around).collect()
    }

    /// Parts of the track without a gap, in which one frame follows the other.
    pub(super) fn segments(&self, options: &CheckOptions) -> Vec<Range<usize>> {
        runs(&self.frames, |before, now| match (before.t_s, now.t_s) {
            // A step back in time begins another segment, too.
            (Some(before), Some(now)) => (0.0..=options.gap_s).contains(&(now - before)),
            _ => true,
        })
    }
}

/// The median of some values, the higher of the two middle ones.
pub(super) fn median(mut values: Vec<f32>) -> Option<f32> {
    let middle = upper_index(values.len(), 1, 2);
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use evpose_pose::body::{BodyLabel, Keypoint, Visibility};

    use super::*;

    #[test]
    fn annotations_become_tracks_in_pixels() {
        let annotation = |image: &str| {
            let mut keypoints = vec![Keypoint::default(); 13];
            keypoints[3] =
                Keypoint { position: Vec2::new(0.5, 0.25), visibility: Visibility::Hidden };
            let label = BodyLabel { keypoints, ..BodyLabel::default() };
            Annotation { image: image.to_owned(), t_s: Some(1.0), label }
        };
        let annotations = [annotation("a/0.png"), annotation("b/0.png"), annotation("a/1.png")];
        let tracks = tracks_of(&annotations, Vec2::new(640.0, 480.0), |a| {
            a.image.split('/').next().unwrap()
        });
        let shape: Vec<_> = tracks.iter().map(|t| (t.name.as_str(), t.frames.len())).collect();
        assert_eq!(shape, [("a", 2), ("b", 1)]);
        let joints = &tracks[0].frames[1].joints;
        assert_eq!((joints[3], joints[4]), (Some(Vec2::new(320.0, 120.0)), None));
    }

    #[test]
    fn gaps_and_times_that_go_back_end_a_segment() {
        let frame = |t_s: f64| TrackFrame {
            name: String::new(),
            t_s: Some(t_s),
            joints: BodyPoints::default(),
        };
        let frames = [0.0, 0.02, 0.04, 1.0, 1.02, 0.5].map(frame).to_vec();
        let track = LabelTrack { name: String::new(), frames, image_size: None };
        assert_eq!(track.segments(&CheckOptions::default()), [0..3, 3..5, 5..6]);
    }
}
