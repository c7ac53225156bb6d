//! A person of a scene: shape, clothes, activity and place, with a renderer of their own.

use evpose_body::activity::{Activity, Performance};
use evpose_body::{PosedBody, ShapedBody};
use evpose_core::{CounterRng, Plane, SensorSize};
use glam::{Vec3, Vec3A};

use super::config::PeopleConfig;
use super::joints::{BodyJoints3, joints_m};
use super::shared::Shared;
use crate::raster::{Camera, Mesh, PixelRect};
use crate::scene::{Backdrop, FrameResponse, Lighting, Renderer, Scene};
use crate::texture::paint_clothes;

/// The streams of a person's random draws.
pub(super) struct MemberStreams {
    pub(super) shape: CounterRng,
    pub(super) activity: CounterRng,
    pub(super) clothes: CounterRng,
    pub(super) outfit: CounterRng,
}

/// A person with an activity at a place.
#[derive(Debug)]
pub(super) struct CastMember {
    /// Index of the body among those of the run.
    body: usize,
    pub(super) betas: Vec<f32>,
    performance: Performance,
    pub(super) shaped: ShapedBody,
    posed: PosedBody,
    clothes: CounterRng,
    /// Position of the person, relative to the origin.
    pub(super) place_m: Vec3,
    /// Rotation of the person about the vertical axis through the origin, in radians.
    pub(super) turn_rad: f32,
    renderer: Option<Renderer>,
}

impl CastMember {
    /// Draws a person who does `activity` for `seconds` at `place_m`.
    pub(super) fn draw(
        shared: &Shared,
        config: &PeopleConfig,
        activity: &Activity,
        seconds: f32,
        place_m: Vec3,
        mut streams: MemberStreams,
    ) -> Self {
        let body = streams.outfit.below(shared.bodies.len());
        let range = config.shape_range;
        let betas: Vec<f32> = (0..shared.bodies[body].model.shape_directions_m.len())
            .map(|_| streams.shape.uniform(-range, range))
            .collect();
        Self {
            body,
            shaped: shared.bodies[body].model.shaped(&betas),
            betas,
            performance: Performance::draw(
                activity,
                &mut streams.activity,
                seconds,
                config.stillness,
            ),
            posed: PosedBody::default(),
            clothes: streams.clothes,
            place_m,
            turn_rad: 0.0,
            renderer: None,
        }
    }

    /// Dresses the person for a camera and a light.
    pub(super) fn dress(
        &mut self,
        shared: &Shared,
        camera: Camera,
        px_per_m: f32,
        lighting: Lighting,
        light_level: f32,
    ) {
        let body = &shared.bodies[self.body];
        let scene = Scene {
            camera,
            lighting,
            skin: paint_clothes(&mut self.clothes).mip_level(body.metres_per_texture, px_per_m),
            backdrop: Backdrop::uniform(camera.sensor(), Vec3A::ZERO),
            response: FrameResponse::Clipped,
        };
        self.renderer = Some(Renderer::new(scene, body.is_closed, light_level));
    }

    /// Takes the posture of `t_s` seconds.
    pub(super) fn pose_at(&mut self, shared: &Shared, t_s: f32) {
        let body = &shared.bodies[self.body].model;
        let figure = self.performance.at(t_s);
        let mut pose = figure.pose(body, &self.shaped, &mut self.posed);
        pose.translation_m += self.place_m;
        body.pose(&self.shaped, &pose, &mut self.posed);
        if self.turn_rad != 0.0 {
            self.posed.turn(self.turn_rad);
        }
    }

    /// Renders the person before a backdrop of which `rect` has changed: `paint` writes it.
    ///
    /// # Panics
    /// If the person is not dressed.
    pub(super) fn render(
        &mut self,
        shared: &Shared,
        camera: Camera,
        rect: PixelRect,
        paint: impl FnOnce(&mut Plane<f32>),
    ) -> &Plane<f32> {
        let body = &shared.bodies[self.body].model;
        let renderer = self.renderer.as_mut().expect("dressed before it is rendered");
        renderer.set_camera(camera);
        if !rect.is_empty() {
            renderer.repaint(rect, paint);
        }
        renderer.render(&Mesh {
            vertices_m: &self.posed.vertices_m,
            normals: &self.posed.normals,
            uvs: &body.uvs,
            faces: &body.faces,
        })
    }

    /// Joints of the last posture in metres, turned like the person.
    pub(super) fn joints_m(&self) -> BodyJoints3 {
        joints_m(&self.posed)
    }
}

/// The whole image.
pub(super) fn whole_image(sensor: SensorSize) -> PixelRect {
    let (right, bottom) = (usize::from(sensor.width), usize::from(sensor.height));
    PixelRect { left: 0, top: 0, right, bottom }
}
