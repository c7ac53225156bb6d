//! The background plane behind people: a tiled image, with [`Distractor`]s that move before it.
//!
//! # Model
//! The plane has constant z. The ray through a pixel meets it at a point whose coordinates are
//! quotients of linear functions of the pixel coordinates (a homography), so the camera may be
//! anywhere and may rotate. Neither the plane nor the distractors are lit.

use evpose_core::{CounterRng, LookAt, Pinhole, Plane};
use glam::{Mat3, Vec2, Vec3};

use super::config::SurroundingsConfig;
use super::distractor::Distractor;
use super::luminance_image::{LuminanceImage, LuminancePool};
use crate::raster::PixelRect;

// Ranges chosen by eye: the image covers the whole view at rest, and its centre is somewhere in it.

/// Size of the image relative to the view.
const SCALE: [f32; 2] = [1.0, 1.7];
/// Position of the view's centre in the image, across and up, as shares of its size.
const CENTRE: [[f32; 2]; 2] = [[0.3, 0.7], [0.35, 0.65]];
/// Luminance of a background without an image.
const PLAIN: [f32; 2] = [0.05, 0.9];

/// Bounding rectangle of the part of the plane that a camera at rest sees, in metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaneView {
    pub(super) centre_m: Vec2,
    pub(super) extent_m: Vec2,
}

/// A plane of constant z with an image and distractors.
#[derive(Debug, Clone)]
pub(super) struct BackgroundPlane {
    z_m: f32,
    image: LuminanceImage,
    /// Lower left corner of the image on the plane, in metres.
    corner_m: Vec2,
    size_m: Vec2,
    distractors: Vec<Distractor>,
    /// Bounding rectangle of the distractors in the last frame.
    last_bounds: PixelRect,
    /// Camera pose of the last frame.
    last_placement: Option<LookAt>,
}

impl BackgroundPlane {
    /// Draws a plane at `z_m`; a camera at rest sees `view`, and `level` multiplies all luminance.
    pub(super) fn draw(
        config: &SurroundingsConfig,
        images: &LuminancePool,
        z_m: f32,
        view: &PlaneView,
        level: f32,
        rng: &mut CounterRng,
    ) -> Self {
        let uniform = |rng: &mut CounterRng, [low, high]: [f32; 2]| rng.uniform(low, high);
        // In extents of the view: details look equally large at any distance of the plane.
        let size_m = view.extent_m * uniform(rng, SCALE);
        let centre = Vec2::new(uniform(rng, CENTRE[0]), uniform(rng, CENTRE[1]));
        // A wall of one colour has no edges: events come from the person alone.
        let image = if rng.chance(config.plain) {
            LuminanceImage::uniform(level * uniform(rng, PLAIN))
        } else {
            LuminanceImage { values: images.draw(rng), level }
        };
        let count = if rng.chance(config.moving) && config.distractors > 0 {
            1 + rng.below(config.distractors)
        } else {
            0
        };
        // Drawn last: their number varies, and no other draw may depend on it.
        let distractor = |_| Distractor::draw(rng, images, view, level);
        Self {
            z_m,
            image,
            corner_m: view.centre_m - size_m * centre,
            size_m,
            distractors: (0..count).map(distractor).collect(),
            last_bounds: PixelRect::EMPTY,
            last_placement: None,
        }
    }

    /// Draws a plane at `z_m` that is invisible but for up to `count` objects, most of them at rest.
    pub(super) fn foreground(
        images: &LuminancePool,
        z_m: f32,
        view: &PlaneView,
        level: f32,
        count: usize,
        rng: &mut CounterRng,
    ) -> Self {
        let object = |_| Distractor::draw(rng, images, view, level).at_rest_or_not(rng);
        Self {
            z_m,
            // Never painted: `cover` samples the objects alone.
            image: LuminanceImage::uniform(0.0),
            corner_m: view.centre_m,
            size_m: view.extent_m,
            distractors: (0..count).map(object).collect(),
            last_bounds: PixelRect::EMPTY,
            last_placement: None,
        }
    }

    /// Bounding rectangle of the image corners on the plane at `z_m`.
    pub(super) fn view(
        z_m: f32,
        placement: &LookAt,
        pinhole: &Pinhole,
        size_px: Vec2,
    ) -> PlaneView {
        let rays = Rays::new(z_m, placement, pinhole);
        let corners = [Vec2::ZERO, Vec2::new(size_px.x, 0.0), Vec2::new(0.0, size_px.y), size_px]
            .map(|px| rays.point_m(px));
        let low = corners.into_iter().fold(Vec2::MAX, Vec2::min);
        let high = corners.into_iter().fold(Vec2::MIN, Vec2::max);
        PlaneView { centre_m: 0.5 * (low + high), extent_m: high - low }
    }

    /// Rectangle of pixels to repaint for a camera at `placement` at `t_s`: the whole image if the
    /// camera moved since the last call, else the distractors' old and new bounds.
    pub(super) fn dirty_rect(
        &mut self,
        t_s: f32,
        placement: &LookAt,
        pinhole: &Pinhole,
        whole: PixelRect,
    ) -> PixelRect {
        let has_moved = self.last_placement != Some(*placement);
        self.last_placement = Some(*placement);
        let Some(bounds) = self.distractor_bounds(t_s, placement, pinhole, whole) else {
            return whole;
        };
        // The old bounds as well: what a distractor has left behind shows the background again.
        let before = std::mem::replace(&mut self.last_bounds, bounds);
        if has_moved { whole } else { union(before, bounds) }
    }

    /// Bounding rectangle of all distractors on the image; none if a corner is behind the camera.
    fn distractor_bounds(
        &self,
        t_s: f32,
        placement: &LookAt,
        pinhole: &Pinhole,
        whole: PixelRect,
    ) -> Option<PixelRect> {
        let image_from_plane = |point_m: Vec2| {
            let in_camera_m =
                placement.camera_from_world().transform_point3(point_m.extend(self.z_m));
            pinhole.image_from_camera(in_camera_m)
        };
        let mut rect = PixelRect::EMPTY;
        for distractor in &self.distractors {
            let (mut low, mut high) = (Vec2::MAX, Vec2::MIN);
            for corner_m in distractor.corners_m(distractor.centre_m(t_s)) {
                // A corner behind the camera has no image: the caller repaints everything then.
                let at_px = image_from_plane(corner_m)?;
                (low, high) = (low.min(at_px), high.max(at_px));
            }
            let first = |x: f32| x.floor().max(0.0) as usize;
            let part = PixelRect {
                left: first(low.x).min(whole.right),
                top: first(low.y).min(whole.bottom),
                right: (first(high.x) + 1).min(whole.right),
                bottom: (first(high.y) + 1).min(whole.bottom),
            };
            rect = union(rect, part);
        }
        Some(rect)
    }

    /// Paints the pixels of `rect` with the luminance of the plane.
    pub(super) fn paint(
        &self,
        t_s: f32,
        placement: &LookAt,
        pinhole: &Pinhole,
        rect: PixelRect,
        frame: &mut Plane<f32>,
    ) {
        self.paint_pixels(t_s, placement, pinhole, rect, frame, |point_m, covering, _| {
            covering.unwrap_or_else(|| {
                let uv = (point_m - self.corner_m) / self.size_m;
                self.image.sample(Vec2::new(uv.x, 1.0 - uv.y))
            })
        });
    }

    /// Paints the objects of the plane over a frame.
    pub(super) fn cover(
        &self,
        t_s: f32,
        placement: &LookAt,
        pinhole: &Pinhole,
        whole: PixelRect,
        frame: &mut Plane<f32>,
    ) {
        let rect = self.distractor_bounds(t_s, placement, pinhole, whole).unwrap_or(whole);
        self.paint_pixels(t_s, placement, pinhole, rect, frame, |_, covering, behind| {
            covering.unwrap_or(behind)
        });
    }

    /// Paints `colour` of the point of the plane, of what covers it, and of what was there.
    fn paint_pixels(
        &self,
        t_s: f32,
        placement: &LookAt,
        pinhole: &Pinhole,
        rect: PixelRect,
        frame: &mut Plane<f32>,
        colour: impl Fn(Vec2, Option<f32>, f32) -> f32,
    ) {
        // What the rays of a frame share is computed once.
        let rays = Rays::new(self.z_m, placement, pinhole);
        let distractors: Vec<(&Distractor, Vec2)> =
            self.distractors.iter().map(|one| (one, one.centre_m(t_s))).collect();
        for y in rect.top..rect.bottom {
            let row = &mut frame.row_mut(y)[rect.left..rect.right];
            for (x, pixel) in (rect.left..).zip(row) {
                // Centres of pixels lie at halves.
                let point_m = rays.point_m(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
                // The first distractor of the list is the nearest one.
                let covering =
                    distractors.iter().find_map(|(one, centre_m)| one.sample(point_m, *centre_m));
                *pixel = colour(point_m, covering, *pixel);
            }
        }
    }
}

/// Homography from pixels to the plane: both numerators and the denominator, linear in the
/// homogeneous pixel.
struct Rays {
    x: Vec3,
    y: Vec3,
    w: Vec3,
}

impl Rays {
    fn new(z_m: f32, placement: &LookAt, pinhole: &Pinhole) -> Self {
        let world_from_camera = Mat3::from_mat4(placement.camera_from_world()).transpose();
        let (f, c) = (pinhole.focal_px, pinhole.principal_px);
        // The ray of pixel (u, v, 1) in the camera, which looks along -z with y up.
        let camera_from_pixel =
            Mat3::from_cols(Vec3::X / f, Vec3::NEG_Y / f, Vec3::new(-c.x / f, c.y / f, -1.0));
        let rays = (world_from_camera * camera_from_pixel).transpose();
        let eye_m = placement.eye_m;
        let depth_m = z_m - eye_m.z;
        Self {
            x: eye_m.x * rays.z_axis + depth_m * rays.x_axis,
            y: eye_m.y * rays.z_axis + depth_m * rays.y_axis,
            w: rays.z_axis,
        }
    }

    /// Intersection of a pixel's ray with the plane, in metres.
    fn point_m(&self, pixel: Vec2) -> Vec2 {
        let pixel = pixel.extend(1.0);
        Vec2::new(self.x.dot(pixel), self.y.dot(pixel)) / self.w.dot(pixel)
    }
}

/// Smallest rectangle around both.
fn union(a: PixelRect, b: PixelRect) -> PixelRect {
    if a.is_empty() {
        return b;
    }
    if b.is_empty() {
        return a;
    }
    PixelRect {
        left: a.left.min(b.left),
        top: a.top.min(b.top),
        right: a.right.max(b.right),
        bottom: a.bottom.max(b.bottom),
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::SensorSize;

    use super::*;

    #[test]
    fn rays_meet_the_plane_where_the_camera_projects_their_pixels() {
        let placement = LookAt {
            eye_m: Vec3::new(0.4, 1.3, 3.5),
            centre_m: Vec3::new(-0.1, 0.9, 0.0),
            up: Vec3::new(0.05, 1.0, 0.0),
        };
        let sensor = SensorSize { width: 346, height: 260 };
        let pinhole = Pinhole::from_vertical_fov(sensor, 45.0);
        let rays = Rays::new(-1.5, &placement, &pinhole);
        for pixel in [Vec2::new(3.0, 250.0), Vec2::new(170.0, 20.0), Vec2::new(340.0, 130.0)] {
            let point_m = rays.point_m(pixel).extend(-1.5);
            let in_camera_m = placement.camera_from_world().transform_point3(point_m);
            let seen = pinhole.image_from_camera(in_camera_m).expect("before the camera");
            assert!(seen.distance(pixel) < 1e-2, "{pixel} {seen}");
        }
    }
}
