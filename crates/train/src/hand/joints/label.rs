//! The joints of a sample: where they lie in its image, and how deep.

use evpose_core::SensorSize;
use evpose_nn::{HandHead, JointNet};
use evpose_pose::{EVALUATION_JOINTS, HandParams};
use evpose_sim::raster::Camera;
use evpose_task::TaskError;
use evpose_task::hand::{HandConfig, HandView, JointGrid, PerspectiveCrop};
use glam::{Vec2, Vec3};

use crate::hand::dataset::{HandSequence, SampleError};

/// Count of joints.
const JOINTS: usize = EVALUATION_JOINTS.len();
/// The knuckle of the middle finger, to which the palm reaches from the wrist.
const MIDDLE_KNUCKLE: usize = 9;
/// Joints inside of the image with which there is a hand for certain: a third.
const MIN_INSIDE: usize = JOINTS / 3;
/// Active pixels of both channels below which an image shows nothing: a fingertip that moves makes more.
const MIN_ACTIVE: usize = 24;
/// Active pixels of both channels about a hand with which it is worth a step of training: an outline has more.
const MIN_ACTIVE_OF_HAND: usize = 80;
/// Shortest palm, in metres: keeps depths finite whatever a file says.
const MIN_PALM_M: f32 = 1e-3;

/// The joints in the image of a sample, in the order of [`EVALUATION_JOINTS`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLabel {
    /// Column and row in cells of the heatmaps, 0 the middle of the first.
    pub positions: [Vec2; JOINTS],
    /// How far behind the wrist, in lengths of the palm of this hand.
    pub depths: [f32; JOINTS],
    /// Whether a joint lies in the image.
    pub inside: [bool; JOINTS],
    /// Whether there is a hand in the image; none for one of which little is.
    pub presence: Option<bool>,
}

impl JointLabel {
    /// The label of points in the frame of a camera, whose image has the cells of `grid`.
    pub(crate) fn new(points_m: &[Vec3; JOINTS], grid: &JointGrid) -> Self {
        let palm_m = points_m[MIDDLE_KNUCKLE].distance(points_m[0]).max(MIN_PALM_M);
        let positions = points_m.map(|point_m| grid.position(point_m));
        let inside = positions.map(|position| position.is_some_and(|at| grid.contains(at)));
        let presence = match inside.iter().filter(|is_inside| **is_inside).count() {
            0 => Some(false),
            MIN_INSIDE.. => Some(true),
            _ => None,
        };
        Self {
            positions: positions.map(Option::unwrap_or_default),
            depths: points_m.map(|point_m| (points_m[0].z - point_m.z) / palm_m),
            inside,
            presence,
        }
    }

    /// The label where the image is `seen`: of a hand at rest nobody can say that it is there.
    #[must_use]
    pub(crate) fn as_seen(self, seen: &[f32]) -> Self {
        let is_seen = seen.iter().filter(|value| **value > 0.0).count() >= MIN_ACTIVE;
        let presence = self.presence.filter(|is_present| is_seen || !is_present);
        Self { presence, ..self }
    }

    /// Whether the image `seen`, `[channels][rows][columns]` of `size`, teaches something: in the box about the joints
    /// there are events, or there are some at all where there is no hand.
    pub(crate) fn is_instructive(&self, seen: &[f32], size: SensorSize) -> bool {
        let is_active = |value: &&f32| **value > 0.0;
        if self.presence == Some(false) {
            return seen.iter().filter(is_active).count() >= MIN_ACTIVE;
        }
        let inside = self.positions.iter().zip(self.inside).filter(|(_, is_inside)| *is_inside);
        let (low, high) = inside.fold((Vec2::INFINITY, Vec2::ZERO), |(low, high), (at, _)| {
            (low.min(*at), high.max(*at))
        });
        // Cells count from the middle of the first: half a cell more on both sides covers them.
        let px = |cells: f32, pixels: u16| {
            ((cells * JointNet::STRIDE as f32) as usize).min(pixels.into())
        };
        let (left, right) = (px(low.x, size.width), px(high.x + 1.0, size.width));
        let (top, bottom) = (px(low.y, size.height), px(high.y + 1.0, size.height));
        let rows = seen.chunks_exact(size.width.into()).enumerate();
        let rows =
            rows.filter(|(row, _)| (top..bottom).contains(&(row % usize::from(size.height))));
        let active =
            rows.map(|(_, row)| row[left.min(right)..right].iter().filter(is_active).count());
        active.sum::<usize>() >= MIN_ACTIVE_OF_HAND
    }

    /// The label of an image from which the hand was taken.
    #[must_use]
    pub(crate) fn without_hand(self) -> Self {
        Self { inside: [false; JOINTS], presence: Some(false), ..self }
    }
}

/// Makes the labels of a data set for networks of joints.
#[derive(Debug)]
pub(crate) struct JointLabeller {
    view: HandView,
    camera: Camera,
    size: SensorSize,
}

impl JointLabeller {
    /// That of a config; none if its network is a regressor.
    ///
    /// # Errors
    /// If the hand model cannot be read.
    pub(crate) fn new(config: &HandConfig) -> Result<Option<Self>, TaskError> {
        if config.network.head != HandHead::Joints {
            return Ok(None);
        }
        let (view, camera) = (HandView::new(config)?, config.simulation.camera());
        Ok(Some(Self { view, camera, size: config.network_size() }))
    }

    /// The points of a frame in metres, in the frame of the camera: as recorded, or those of the hand of its
    /// label where they were not.
    pub(crate) fn points_m(
        &self,
        sequence: &HandSequence,
        frame: u64,
        pose: &HandParams,
    ) -> Result<[Vec3; JOINTS], SampleError> {
        if let Some(joints) = &sequence.joints {
            return Ok(joints.read(frame)?.map(Vec3::from_array));
        }
        let betas = sequence.betas(sequence.episode_of(frame));
        let points = self.view.points(sequence.hand(), pose, betas);
        Ok(self.view.camera_points(&points.world_m))
    }

    /// The label of points in the view for a sample that shows a crop of it.
    pub(crate) fn label(&self, points_m: &[Vec3; JOINTS], crop: &PerspectiveCrop) -> JointLabel {
        let grid = JointGrid::new(&self.camera, self.size, crop.zoom());
        JointLabel::new(&points_m.map(|point_m| crop.turn() * point_m), &grid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> JointGrid {
        let camera = HandConfig::default().simulation.camera();
        JointGrid::new(&camera, SensorSize { width: 128, height: 96 }, 1.0)
    }

    #[test]
    fn a_point_on_the_axis_lies_in_the_middle_and_depths_count_in_palms() {
        let mut points_m = [Vec3::new(0.0, 0.0, -0.4); JOINTS];
        points_m[MIDDLE_KNUCKLE] = Vec3::new(0.0, 0.08, -0.4);
        points_m[3] = Vec3::new(0.0, 0.0, -0.44);
        let label = JointLabel::new(&points_m, &grid());
        assert!(label.positions[0].distance(Vec2::new(15.5, 11.5)) < 1e-4);
        assert!(label.positions[MIDDLE_KNUCKLE].y < 11.0, "up is up");
        assert_eq!(label.depths[0], 0.0);
        assert!((label.depths[3] - 0.5).abs() < 1e-5, "{}", label.depths[3]);
        assert_eq!((label.inside, label.presence), ([true; JOINTS], Some(true)));
    }

    #[test]
    fn windows_are_instructive_by_what_is_seen_of_the_hand() {
        let size = SensorSize { width: 128, height: 96 };
        let at = |k: usize| Vec3::new(0.01 * (k % 5) as f32, 0.01 * (k / 5) as f32, -0.4);
        let label = JointLabel::new(&std::array::from_fn(at), &grid());
        let image = |columns: std::ops::Range<usize>| {
            let mut seen = vec![0.0; 2 * size.pixels()];
            columns.for_each(|x| (36..48).for_each(|y| seen[y * 128 + x] = 0.5));
            seen
        };
        assert!(label.is_instructive(&image(60..72), size));
        assert!(!label.is_instructive(&image(100..106), size), "events beside the hand");
        assert!(!label.is_instructive(&image(0..0), size));
        let nobody = label.without_hand();
        assert!(nobody.is_instructive(&image(100..106), size));
        assert!(!nobody.is_instructive(&image(0..0), size));
    }

    #[test]
    fn hands_beside_the_image_are_none_and_those_at_its_border_are_not_certain() {
        let with = |inside: usize| {
            let at = |k: usize| match k {
                _ if k < inside => Vec3::new(0.0, 0.0, -0.5),
                _ if k.is_multiple_of(2) => Vec3::new(9.0, 0.0, -0.5),
                _ => Vec3::new(0.0, 0.0, 0.5),
            };
            JointLabel::new(&std::array::from_fn(at), &grid())
        };
        assert_eq!(with(0).presence, Some(false));
        assert_eq!(with(3).presence, None);
        assert_eq!(with(7).presence, Some(true));
        assert_eq!(with(3).inside.iter().filter(|is_inside| **is_inside).count(), 3);
        assert!(with(0).positions.iter().all(|position| position.is_finite()));
    }
}
