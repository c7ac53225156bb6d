//! A person of a scene: shape, clothes, activity and place, with a renderer of their own.

use evpose_body::activity::{Activity, Performance};
use evpose_body::mocap::Capture;
use evpose_body::{PosedBody, ShapedBody};
use evpose_core::{CounterRng, Plane};
use glam::{Vec3, Vec3A};

use super::config::PeopleConfig;
use super::joints::{BodyJoints3, joints_m};
use super::shared::{BodyChoice, Shared};
use crate::SimError;
use crate::raster::{Camera, Mesh, PixelRect};
use crate::scene::{Backdrop, FrameResponse, Lighting, Renderer, Scene};
use crate::texture::paint_clothes;

pub(super) struct MemberStreams {
    pub(super) shape: CounterRng,
    pub(super) activity: CounterRng,
    pub(super) clothes: CounterRng,
    pub(super) outfit: CounterRng,
    pub(super) capture: CounterRng,
}

#[derive(Debug)]
enum Movement {
    Activity(Box<Performance>),
    Captured(Capture),
}

#[derive(Debug)]
pub(super) struct CastMember {
    body: BodyChoice,
    pub(super) betas: Vec<f32>,
    movement: Movement,
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
    /// Draws a person who does `activity`, or moves as somebody was captured, for `seconds` at
    /// `place_m`.
    ///
    /// # Errors
    /// Captured motion that cannot be read.
    pub(super) fn draw(
        shared: &Shared,
        config: &PeopleConfig,
        activity: &Activity,
        seconds: f32,
        place_m: Vec3,
        mut streams: MemberStreams,
    ) -> Result<Self, SimError> {
        let body = shared.draw_body(config.body_share, &mut streams.outfit);
        let model = &shared.body(body).model;
        // The number of coefficients depends on the body, which has a stream of its own.
        let range = config.shape_range;
        let betas: Vec<f32> =
            (0..model.shape_coefficients()).map(|_| streams.shape.uniform(-range, range)).collect();
        let movement = match &shared.motions {
            Some(motions) if streams.capture.chance(config.motion_share) => {
                Movement::Captured(motions.draw(&mut streams.capture, seconds)?)
            }
            _ => {
                // Drawn only where it is used: each stream has its own draws, so that others do not
                // shift.
                let performance =
                    Performance::draw(activity, &mut streams.activity, seconds, config.stillness);
                Movement::Activity(Box::new(performance))
            }
        };
        Ok(Self {
            body,
            shaped: model.shaped(&betas),
            betas,
            movement,
            posed: PosedBody::default(),
            clothes: streams.clothes,
            place_m,
            turn_rad: 0.0,
            renderer: None,
        })
    }

    pub(super) fn captured(&self) -> Option<&str> {
        match &self.movement {
            Movement::Captured(capture) => Some(capture.name()),
            Movement::Activity(_) => None,
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
        let body = shared.body(self.body);
        let scene = Scene {
            camera,
            lighting,
            skin: paint_clothes(&mut self.clothes).mip_level(body.metres_per_texture, px_per_m),
            // The background is painted by the scene, which knows what moves in front of the
            // camera.
            backdrop: Backdrop::uniform(camera.sensor(), Vec3A::ZERO),
            response: FrameResponse::Clipped,
        };
        self.renderer = Some(Renderer::new(scene, body.is_closed(self.body), light_level));
    }

    /// Takes the posture of `t_s` seconds.
    pub(super) fn pose_at(&mut self, shared: &Shared, t_s: f32) {
        let body = &shared.body(self.body).model;
        let mut pose = match &self.movement {
            Movement::Activity(performance) => {
                performance.at(t_s).pose(body, &self.shaped, &mut self.posed)
            }
            Movement::Captured(capture) => capture.pose(t_s, body, &self.shaped, &mut self.posed),
        };
        pose.translation_m += self.place_m;
        body.pose(&self.shaped, &pose, &mut self.posed);
        if self.turn_rad != 0.0 {
            self.posed.turn(self.turn_rad);
        }
    }

    /// Renders the person before a backdrop that has changed within `rect`: `paint` writes it.
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
        let body = shared.body(self.body);
        let renderer = self.renderer.as_mut().expect("dressed before it is rendered");
        renderer.set_camera(camera);
        // Before a background at rest nothing is to be painted, which is most of the time.
        if !rect.is_empty() {
            renderer.repaint(rect, paint);
        }
        renderer.render(&Mesh {
            vertices_m: &self.posed.vertices_m,
            normals: &self.posed.normals,
            uvs: &body.model.uvs,
            faces: body.faces(self.body),
        })
    }

    /// Joints of the last posture in metres, turned like the person.
    pub(super) fn joints_m(&self) -> BodyJoints3 {
        joints_m(&self.posed)
    }
}
