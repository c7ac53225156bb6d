//! A perspective crop about a hand: the canonical view as a turned camera with a longer lens sees it.
//!
//! # Model
//! A camera turned about its own centre by `A` sees the ray `d` along `A d`, whatever is how far
//! away. A lens that is `s` times as long shows a hand at the depth `z` as the network's own lens
//! shows it at `z / s`, but for the perspective within the hand. So the network sees hands of all
//! distances and directions at one size, upright, and in the middle; its pose becomes that of the
//! view by the inverse of both.
//!
//! A pixel of the network takes the largest value among the pixels of the view that it covers: of
//! an LNES, that is the newest event.
//!
//! # Source
//! Crops by a turned camera: Yu et al., *PCLs: Geometry-aware Neural Reconstruction of 3D Pose with
//! Perspective Crop Layers*, CVPR 2021. Events in place of colours, and the roll, are ours.

use evpose_core::SensorSize;
use evpose_pose::HandParams;
use evpose_pose::rotation::{axis_angle_from_matrix, matrix_from_axis_angle};
use evpose_sim::raster::Camera;
use glam::{Affine3A, Mat3, Vec3};

/// Depth in metres below which there is no crop about a hand.
const MIN_DEPTH_M: f32 = 0.05;
/// Share of a hand's length that must lie across the optical axis for it to have a direction.
const MIN_ACROSS: f32 = 0.3;
/// Indices of [`EVALUATION_JOINTS`](evpose_pose::EVALUATION_JOINTS).
const WRIST: usize = 0;
const MIDDLE_KNUCKLE: usize = 9;

/// A turn of the canonical camera and a zoom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PerspectiveCrop {
    /// In the frame of the camera: x right, y up, looking along -z.
    turn: Mat3,
    /// Focal length over that of the network's image of the whole view.
    zoom: f32,
}

impl PerspectiveCrop {
    /// The whole view.
    pub const WHOLE: Self = Self { turn: Mat3::IDENTITY, zoom: 1.0 };

    /// A turn and a zoom.
    pub fn new(turn: Mat3, zoom: f32) -> Self {
        Self { turn, zoom }
    }

    /// Its turn, in the frame of the camera.
    pub fn turn(&self) -> Mat3 {
        self.turn
    }

    /// Factor by which the crop is magnified.
    pub fn zoom(&self) -> f32 {
        self.zoom
    }

    /// The crop about a hand whose evaluated points lie at `points_m` in the frame of the camera:
    /// its middle in the middle, its middle finger upwards, as large as at `distance_m` but at most
    /// `max_zoom` times the whole view. [`Self::WHOLE`] if it is behind the camera.
    pub fn at(points_m: &[Vec3; 21], distance_m: f32, max_zoom: f32) -> Self {
        let middle = middle_of(points_m);
        if !middle.is_finite() || -middle.z < MIN_DEPTH_M {
            return Self::WHOLE;
        }
        let to_centre = turn_to_axis(middle);
        let along = to_centre * (points_m[MIDDLE_KNUCKLE] - points_m[WRIST]);
        // A hand that points at the camera has no direction in its image.
        let roll = if along.truncate().length() > MIN_ACROSS * along.length() {
            Mat3::from_rotation_z(along.x.atan2(along.y))
        } else {
            Mat3::IDENTITY
        };
        // A zoom below 1 would show what lies beyond the view.
        Self::new(roll * to_centre, (middle.length() / distance_m).clamp(1.0, max_zoom))
    }

    /// Writes the two channels of the network's image of `size`, `out`, from those of the view,
    /// `values`, before `camera`.
    pub fn fill(&self, camera: &Camera, values: &[f32], size: SensorSize, out: &mut [f32]) {
        let source = camera.sensor();
        let pinhole = camera.pinhole();
        let scale = f32::from(size.height) / f32::from(source.height);
        let focal_px = self.zoom * scale * pinhole.focal_px;
        let centre_px = scale * pinhole.principal_px;
        // Half a pixel of the crop in pixels of the view; at least half a pixel, so that no event is skipped.
        let covered = (0.5 * pinhole.focal_px / focal_px).max(0.5);
        let from_crop = self.turn.transpose();
        let (width, height) = (usize::from(source.width), usize::from(source.height));
        // Pixels whose middle is covered. To truncate is one instruction; `ceil` and `floor` are calls.
        let range = |at: f32, end: usize| {
            let (first, last) = (at - covered - 0.5, at + covered - 0.5);
            let whole = first.max(0.0) as usize;
            let end = if last < 0.0 { 0 } else { (last as usize + 1).min(end) };
            (whole + usize::from((whole as f32) < first)).min(end)..end
        };
        let (off, on) = values.split_at(source.pixels());
        let (out_off, out_on) = out.split_at_mut(size.pixels());
        let rows = out_off.chunks_exact_mut(size.width.into());
        let rows = rows.zip(out_on.chunks_exact_mut(size.width.into())).enumerate();
        for (row, (out_off, out_on)) in rows {
            let y = (row as f32 + 0.5 - centre_px.y) / focal_px;
            for (column, out) in out_off.iter_mut().zip(out_on).enumerate() {
                let x = (column as f32 + 0.5 - centre_px.x) / focal_px;
                // The largest value is of the newest event, which the network would see in a view of this size.
                let mut newest = [0.0f32; 2];
                let ray = from_crop * Vec3::new(x, -y, -1.0);
                if let Some(from_px) = pinhole.image_from_camera(ray) {
                    let columns = range(from_px.x, width);
                    for row in range(from_px.y, height) {
                        let of_row = row * width + columns.start..row * width + columns.end;
                        for (off, on) in off[of_row.clone()].iter().zip(&on[of_row]) {
                            // Not `max`, which asks for NaN twice.
                            newest[0] = if *off > newest[0] { *off } else { newest[0] };
                            newest[1] = if *on > newest[1] { *on } else { newest[1] };
                        }
                    }
                }
                [*out.0, *out.1] = newest;
            }
        }
    }

    /// The pose that the hand of a pose in the view has for the network.
    pub fn crop_from_view(&self, camera: &Camera, pose: &HandParams) -> HandParams {
        // A longer lens shows what a smaller depth would show; positions across stay.
        let nearer = Vec3::new(1.0, 1.0, 1.0 / self.zoom);
        moved(camera, pose, self.turn, |position_m| nearer * (self.turn * position_m))
    }

    /// The inverse: a pose in the view from that of the network.
    pub fn view_from_crop(&self, camera: &Camera, pose: &HandParams) -> HandParams {
        let back = self.turn.transpose();
        let further = Vec3::new(1.0, 1.0, self.zoom);
        moved(camera, pose, back, |position_m| back * (further * position_m))
    }
}

fn middle_of(points_m: &[Vec3; 21]) -> Vec3 {
    let low = points_m.iter().fold(Vec3::INFINITY, |low, &point| low.min(point));
    let high = points_m.iter().fold(Vec3::NEG_INFINITY, |high, &point| high.max(point));
    0.5 * (low + high)
}

/// The turn that brings a position before the camera to its optical axis.
fn turn_to_axis(position_m: Vec3) -> Mat3 {
    Mat3::from_quat(glam::Quat::from_rotation_arc(position_m.normalize(), Vec3::NEG_Z))
}

/// A pose in the world whose rotation is turned and whose translation is mapped in the frame of
/// the camera.
fn moved(
    camera: &Camera,
    pose: &HandParams,
    turn: Mat3,
    position: impl Fn(Vec3) -> Vec3,
) -> HandParams {
    let camera_from_world = Affine3A::from_mat4(camera.camera_from_world());
    let world_from_camera = camera_from_world.inverse();
    // The turn is one in the frame of the camera, and the rotation one in the world.
    let rotation = Mat3::from(world_from_camera.matrix3)
        * turn
        * Mat3::from(camera_from_world.matrix3)
        * matrix_from_axis_angle(pose.rotation);
    let in_camera_m = camera_from_world.transform_point3(pose.translation_m);
    HandParams {
        translation_m: world_from_camera.transform_point3(position(in_camera_m)),
        rotation: axis_angle_from_matrix(rotation),
        ..*pose
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use crate::hand::{HandConfig, HandView, TwoPassConfig};

    use super::*;

    fn pose() -> HandParams {
        HandParams {
            articulation: [0.4, -0.3, 0.2, 0.0, 0.5, -0.1],
            translation_m: HandConfig::default().simulation.camera.centre_m
                + Vec3::new(0.08, 0.05, -0.3),
            rotation: Vec3::new(0.3, 1.1, -0.4),
        }
    }

    /// A hand before the canonical view, and the crop about it.
    fn cropped() -> (Camera, HandView, PerspectiveCrop) {
        let config = HandConfig::default();
        let view = HandView::new(&config).unwrap();
        let world_m = view.points(config.simulation.hands.side(0), &pose(), &[]).world_m;
        let crop = PerspectiveCrop::at(&view.camera_points(&world_m), 0.31, 4.0);
        (config.simulation.camera(), view, crop)
    }

    #[test]
    fn a_pose_comes_back_from_its_crop() {
        let (camera, _, crop) = cropped();
        assert!(crop.zoom() > 1.5);
        let back = crop.view_from_crop(&camera, &crop.crop_from_view(&camera, &pose()));
        assert!(back.translation_m.distance(pose().translation_m) < 1e-5);
        assert!(back.rotation.distance(pose().rotation) < 1e-4);
    }

    /// Values at the points of a hand are where the hand of the crop's pose has its points, up to
    /// the perspective within the hand.
    #[test]
    fn an_image_shows_the_hand_of_its_pose() {
        let (camera, view, crop) = cropped();
        let side = HandConfig::default().simulation.hands.side(0);
        let source = camera.sensor();
        let size = TwoPassConfig::default().size;
        let scale = f32::from(size.height) / f32::from(source.height);
        let from = view.points(side, &pose(), &[]).in_front().unwrap();
        let of_network = crop.crop_from_view(&camera, &pose());
        let to = view.points(side, &of_network, &[]).in_front().unwrap();
        for (point, (from, to)) in from.iter().zip(to).enumerate() {
            let mut values = vec![0.0; 2 * source.pixels()];
            let at = usize::from(source.width) * from.y as usize + from.x as usize;
            values[source.pixels() + at] = 1.0;
            let mut image = vec![0.0; 2 * size.pixels()];
            crop.fill(&camera, &values, size, &mut image);
            assert!(image[..size.pixels()].iter().all(|&value| value == 0.0));
            let lit = (0..size.pixels()).filter(|i| image[size.pixels() + i] > 0.0);
            let nearest = lit
                .map(|i| {
                    let (x, y) = (i % usize::from(size.width), i / usize::from(size.width));
                    (Vec2::new(x as f32, y as f32) + 0.5).distance(scale * to)
                })
                .fold(f32::INFINITY, f32::min);
            assert!(nearest < 6.0, "point {point}: {nearest} px");
        }
        // The wrist itself has no perspective of its own.
        let wrist = scale * to[0];
        assert!(wrist.x > 0.0 && wrist.y > f32::from(size.height) / 2.0, "{wrist}: below");
    }

    #[test]
    fn the_whole_view_is_pooled_by_its_newest_value() {
        let camera = HandConfig::default().simulation.camera();
        let source = camera.sensor();
        let size = SensorSize { width: source.width / 2, height: source.height / 2 };
        let values: Vec<f32> =
            (0..2 * source.pixels()).map(|i| ((i * 7919) % 1000) as f32 / 1000.0).collect();
        let mut image = vec![0.0; 2 * size.pixels()];
        PerspectiveCrop::WHOLE.fill(&camera, &values, size, &mut image);
        let width = usize::from(source.width);
        for (i, value) in image.iter().enumerate() {
            let (plane, i) = (i / size.pixels(), i % size.pixels());
            let (x, y) = (2 * (i % usize::from(size.width)), 2 * (i / usize::from(size.width)));
            let of = |x: usize, y: usize| values[plane * source.pixels() + y * width + x];
            let pooled = of(x, y).max(of(x + 1, y)).max(of(x, y + 1)).max(of(x + 1, y + 1));
            assert_eq!(*value, pooled, "pixel {x}, {y} of plane {plane}");
        }
    }
}
