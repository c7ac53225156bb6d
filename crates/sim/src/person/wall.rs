//! The wall behind people: a picture, and things that move before it.
//!
//! # Model
//! The wall is a plane of constant z. The ray through a pixel meets it at a place whose coordinates are
//! quotients of linear functions of the pixel's, so a camera may stand and turn as it likes. Nothing on
//! the wall is lit; pictures are repeated beyond their borders.

use std::sync::{Arc, OnceLock};

use evpose_core::{CounterRng, LookAt, Pinhole, Plane};
use glam::{Mat3, Vec2, Vec3, Vec3A};

use super::config::SurroundingsConfig;
use crate::raster::PixelRect;
use crate::scene::luminance;
use crate::texture::{PicturePool, Texture};

/// The code of white.
const WHITE: f32 = 255.0;

/// The pictures of a pool as linear luminance, each made when it is first needed.
#[derive(Debug)]
pub(super) struct Pictures {
    pool: PicturePool,
    gamma: f32,
    lights: Vec<OnceLock<Arc<Plane<f32>>>>,
}

impl Pictures {
    pub(super) fn new(pool: PicturePool, gamma: f32) -> Self {
        let lights = (0..pool.len()).map(|_| OnceLock::new()).collect();
        Self { pool, gamma, lights }
    }

    /// Any of them.
    fn any(&self, rng: &mut CounterRng) -> Arc<Plane<f32>> {
        let index = rng.below(self.lights.len());
        let light = || Arc::new(linear(self.pool.picture(index), self.gamma));
        Arc::clone(self.lights[index].get_or_init(light))
    }
}

fn linear(picture: &Texture, gamma: f32) -> Plane<f32> {
    let mut values = Plane::filled(picture.width(), picture.height(), 0.0);
    let (width, height) = (picture.width() as f32, picture.height() as f32);
    for y in 0..values.height() {
        for (x, value) in values.row_mut(y).iter_mut().enumerate() {
            let uv = Vec2::new((x as f32 + 0.5) / width, (y as f32 + 0.5) / height);
            let linear = picture.sample(uv).to_array().map(|code| code.powf(gamma));
            *value = luminance(Vec3A::from_array(linear));
        }
    }
    values
}

/// A picture's light, repeated beyond its borders.
#[derive(Debug, Clone)]
struct Light {
    values: Arc<Plane<f32>>,
    level: f32,
}

impl Light {
    fn uniform(value: f32) -> Self {
        Self { values: Arc::new(Plane::filled(1, 1, value)), level: 1.0 }
    }

    /// Interpolated between four texels.
    fn at(&self, uv: Vec2) -> f32 {
        let (width, height) = (self.values.width(), self.values.height());
        let x = (uv.x - uv.x.floor()) * width as f32 + (width as f32 - 0.5);
        let y = (uv.y - uv.y.floor()) * height as f32 + (height as f32 - 0.5);
        let (left, top) = (x as usize, y as usize);
        let (fx, fy) = (x - left as f32, y - top as f32);
        let wrap = |i: usize, n: usize| i % n;
        let (above, below) =
            (self.values.row(wrap(top, height)), self.values.row(wrap(top + 1, height)));
        let (left, right) = (wrap(left, width), wrap(left + 1, width));
        let upper = above[left] + (above[right] - above[left]) * fx;
        let lower = below[left] + (below[right] - below[left]) * fx;
        self.level * (upper + (lower - upper) * fy)
    }
}

/// A thing that moves before the wall.
#[derive(Debug, Clone)]
struct Thing {
    light: Light,
    /// Where it is on average, and how far and how fast it swings along both axes: metres, radians a
    /// second, radians.
    middle_m: Vec2,
    swing_m: Vec2,
    rates: Vec2,
    phases: Vec2,
    half_m: Vec2,
    is_round: bool,
    window: f32,
}

impl Thing {
    fn draw(rng: &mut CounterRng, pictures: &Pictures, view: &View, level: f32) -> Self {
        let extent = view.extent_m;
        Self {
            light: Light { values: pictures.any(rng), level: level * rng.uniform(0.4, 1.2) },
            middle_m: view.middle_m
                + extent * Vec2::new(rng.uniform(-0.5, 0.5), rng.uniform(-0.4, 0.4)),
            swing_m: extent * Vec2::new(rng.uniform(0.05, 0.45), rng.uniform(0.0, 0.12)),
            rates: Vec2::new(rng.uniform(0.5, 2.5), rng.uniform(0.5, 4.0)),
            phases: Vec2::new(rng.uniform(0.0, 6.3), rng.uniform(0.0, 6.3)),
            half_m: extent * Vec2::new(rng.uniform(0.03, 0.13), rng.uniform(0.04, 0.2)),
            is_round: rng.chance(0.5),
            window: rng.uniform(0.2, 0.6),
        }
    }

    fn centre_m(&self, t_s: f32) -> Vec2 {
        let angle = self.rates * t_s + self.phases;
        self.middle_m + self.swing_m * Vec2::new(angle.x.sin(), angle.y.sin())
    }

    /// Its light at a place of the wall, if it is there.
    fn at(&self, place_m: Vec2, centre_m: Vec2) -> Option<f32> {
        let inside = (place_m - centre_m) / self.half_m;
        let is_there = if self.is_round {
            inside.length_squared() <= 1.0
        } else {
            inside.abs().max_element() <= 1.0
        };
        is_there.then(|| self.light.at(0.5 * inside * self.window + 0.5))
    }
}

/// What of the wall a camera at rest sees.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    pub(super) middle_m: Vec2,
    pub(super) extent_m: Vec2,
}

/// The wall.
#[derive(Debug, Clone)]
pub(super) struct Wall {
    z_m: f32,
    light: Light,
    /// Where the picture's corner is, and how much of the wall it covers.
    corner_m: Vec2,
    size_m: Vec2,
    things: Vec<Thing>,
    /// Where things were drawn last.
    shown: PixelRect,
    /// From where the wall was seen last.
    seen_from: Option<LookAt>,
}

impl Wall {
    /// A wall at `z_m`, of which a camera at rest sees `view`; all its light is multiplied by `level`.
    pub(super) fn draw(
        config: &SurroundingsConfig,
        pictures: &Pictures,
        z_m: f32,
        view: &View,
        level: f32,
        rng: &mut CounterRng,
    ) -> Self {
        let scale = rng.uniform(1.0, 1.7);
        let size_m = view.extent_m * scale;
        let corner_m =
            view.middle_m - size_m * Vec2::new(rng.uniform(0.3, 0.7), rng.uniform(0.35, 0.65));
        let light = if rng.chance(config.plain) {
            Light::uniform(level * rng.uniform(0.05, 0.9))
        } else {
            Light { values: pictures.any(rng), level }
        };
        let count = if rng.chance(config.moving) && config.things > 0 {
            1 + rng.below(config.things)
        } else {
            0
        };
        let thing = |_| Thing::draw(rng, pictures, view, level);
        let things = (0..count).map(thing).collect();
        Self { z_m, light, corner_m, size_m, things, shown: PixelRect::EMPTY, seen_from: None }
    }

    /// What of the plane at `z_m` a camera sees, about.
    pub(super) fn view(z_m: f32, placement: &LookAt, pinhole: &Pinhole, size_px: Vec2) -> View {
        let rays = Rays::new(z_m, placement, pinhole);
        let corners = [Vec2::ZERO, Vec2::new(size_px.x, 0.0), Vec2::new(0.0, size_px.y), size_px]
            .map(|px| rays.place_m(px));
        let low = corners.into_iter().fold(Vec2::MAX, Vec2::min);
        let high = corners.into_iter().fold(Vec2::MIN, Vec2::max);
        View { middle_m: 0.5 * (low + high), extent_m: high - low }
    }

    /// Which pixels the wall changes when it is seen from `placement` at `t_s`: all where the camera
    /// moved, else those of things that move.
    pub(super) fn changed(
        &mut self,
        t_s: f32,
        placement: &LookAt,
        pinhole: &Pinhole,
        size_px: [usize; 2],
    ) -> PixelRect {
        let whole = PixelRect { left: 0, top: 0, right: size_px[0], bottom: size_px[1] };
        let moved = self.seen_from != Some(*placement);
        self.seen_from = Some(*placement);
        let Some(shown) = self.places(t_s, placement, pinhole, whole) else { return whole };
        let before = std::mem::replace(&mut self.shown, shown);
        if moved { whole } else { union(before, shown) }
    }

    /// The rectangle around all things; none where some are seen from too far aside to tell.
    fn places(
        &self,
        t_s: f32,
        placement: &LookAt,
        pinhole: &Pinhole,
        whole: PixelRect,
    ) -> Option<PixelRect> {
        let image_from_wall = |place_m: Vec2| {
            let in_camera_m =
                placement.camera_from_world().transform_point3(place_m.extend(self.z_m));
            pinhole.image_from_camera(in_camera_m)
        };
        let mut rect = PixelRect::EMPTY;
        for thing in &self.things {
            let centre_m = thing.centre_m(t_s);
            let (mut low, mut high) = (Vec2::MAX, Vec2::MIN);
            for corner in
                [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(-1.0, 1.0), Vec2::ONE]
            {
                let at_px = image_from_wall(centre_m + corner * thing.half_m)?;
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

    /// Paints a rectangle of the image of the wall.
    pub(super) fn paint(
        &self,
        t_s: f32,
        placement: &LookAt,
        pinhole: &Pinhole,
        rect: PixelRect,
        image: &mut Plane<f32>,
    ) {
        let rays = Rays::new(self.z_m, placement, pinhole);
        let things: Vec<(&Thing, Vec2)> =
            self.things.iter().map(|thing| (thing, thing.centre_m(t_s))).collect();
        for y in rect.top..rect.bottom {
            let row = &mut image.row_mut(y)[rect.left..rect.right];
            for (x, pixel) in (rect.left..).zip(row) {
                let place_m = rays.place_m(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
                let thing =
                    things.iter().find_map(|(thing, centre_m)| thing.at(place_m, *centre_m));
                *pixel = thing.unwrap_or_else(|| {
                    let uv = (place_m - self.corner_m) / self.size_m;
                    self.light.at(Vec2::new(uv.x, 1.0 - uv.y))
                });
            }
        }
    }
}

/// Where the rays of pixels meet the wall: numerators and the denominator as linear functions.
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

    fn place_m(&self, pixel: Vec2) -> Vec2 {
        let pixel = pixel.extend(1.0);
        Vec2::new(self.x.dot(pixel), self.y.dot(pixel)) / self.w.dot(pixel)
    }
}

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

/// Luminance as eight bits of a photograph.
pub(super) fn encoded(luminance: f32, gamma: f32) -> u8 {
    (WHITE * luminance.clamp(0.0, 1.0).powf(1.0 / gamma) + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use evpose_core::SensorSize;

    use super::*;

    #[test]
    fn rays_meet_the_wall_where_the_camera_sees_their_pixels() {
        let placement = LookAt {
            eye_m: Vec3::new(0.4, 1.3, 3.5),
            centre_m: Vec3::new(-0.1, 0.9, 0.0),
            up: Vec3::new(0.05, 1.0, 0.0),
        };
        let sensor = SensorSize { width: 346, height: 260 };
        let pinhole = Pinhole::from_vertical_fov(sensor, 45.0);
        let rays = Rays::new(-1.5, &placement, &pinhole);
        for pixel in [Vec2::new(3.0, 250.0), Vec2::new(170.0, 20.0), Vec2::new(340.0, 130.0)] {
            let place_m = rays.place_m(pixel).extend(-1.5);
            let in_camera_m = placement.camera_from_world().transform_point3(place_m);
            let seen = pinhole.image_from_camera(in_camera_m).expect("before the camera");
            assert!(seen.distance(pixel) < 1e-2, "{pixel} {seen}");
        }
    }

    #[test]
    fn pictures_repeat_and_are_interpolated() {
        let light = Light {
            values: Arc::new(Plane::from_vec(2, 1, vec![0.0, 1.0]).expect("two texels")),
            level: 1.0,
        };
        for (u, want) in
            [(0.25, 0.0), (0.75, 1.0), (0.5, 0.5), (0.0, 0.5), (7.375, 0.25), (-0.25, 1.0)]
        {
            let got = light.at(Vec2::new(u, 0.3));
            assert!((got - want).abs() < 1e-5, "{u}: {got}");
        }
    }
}
