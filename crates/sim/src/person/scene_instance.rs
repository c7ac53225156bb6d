//! The scene of one sequence: a person with an activity, a background plane and a camera.

use evpose_body::activity::{ACTIVITIES, Activity, Performance, activity_by_name};
use evpose_body::{PosedBody, ShapedBody};
use evpose_core::{CounterRng, LookAt, Pinhole, Plane};
use glam::{Vec2, Vec3A};

use super::background_plane::BackgroundPlane;
use super::camera_path::CameraPath;
use super::joints::{BodyJoints3, joints_m};
use super::shared::Shared;
use crate::raster::{Camera, Mesh};
use crate::scene::{Backdrop, FrameResponse, Renderer, Scene};
use crate::texture::paint_clothes;

/// Distance of the near plane in metres; no camera is drawn that close to a person.
const NEAR_M: f32 = 0.1;

/// A person, an activity, a background and a camera, rendered at any time.
#[derive(Debug)]
pub(super) struct SceneInstance {
    pub(super) activity: &'static Activity,
    pub(super) betas: Vec<f32>,
    performance: Performance,
    shaped: ShapedBody,
    posed: PosedBody,
    path: CameraPath,
    pinhole: Pinhole,
    camera: Camera,
    background: BackgroundPlane,
    renderer: Renderer,
}

impl SceneInstance {
    /// Draws scene `index`, which lasts `seconds`. Each part has a random stream of its own.
    pub(super) fn draw(shared: &Shared, seed: u64, index: u64, seconds: f32) -> Self {
        let Shared { config, body, images, .. } = shared;
        let part = |name| CounterRng::new(seed, name, index);
        let name = &config.activities[index as usize % config.activities.len()];
        // `PeopleConfig::validate` has checked the name.
        let activity = activity_by_name(name).unwrap_or(&ACTIVITIES[0]);
        let mut shape = part("person shape");
        let betas: Vec<f32> = (0..body.shape_directions_m.len())
            .map(|_| shape.uniform(-config.shape_range, config.shape_range))
            .collect();
        let shaped = body.shaped(&betas);
        let performance =
            Performance::draw(activity, &mut part("person activity"), seconds, config.stillness);
        let (path, pinhole) =
            CameraPath::draw(config, shared.height_m(&shaped), &mut part("person camera"));
        let placement = *path.at_rest();
        let mut around = part("person surroundings");
        // A person's reach to the depth of a large room.
        let z_m = -around.uniform(0.8, 4.0);
        let sensor = config.sensor_size;
        let size_px = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
        let view = BackgroundPlane::view(z_m, &placement, &pinhole, size_px);
        let level = config.light_level;
        let background =
            BackgroundPlane::draw(&config.surroundings, images, z_m, &view, level, &mut around);
        let camera = Camera::new(sensor, pinhole, &placement, NEAR_M);
        let px_per_m = pinhole.focal_px / placement.eye_m.z;
        let scene = Scene {
            camera,
            lighting: config.lights.draw(&mut part("person lights")),
            skin: paint_clothes(&mut part("person clothes"))
                .mip_level(shared.metres_per_texture, px_per_m),
            backdrop: Backdrop::uniform(sensor, Vec3A::ZERO),
            response: FrameResponse::Clipped,
        };
        let renderer = Renderer::new(scene, shared.is_closed, level);
        let posed = PosedBody::default();
        Self {
            activity,
            betas,
            performance,
            shaped,
            posed,
            path,
            pinhole,
            camera,
            background,
            renderer,
        }
    }

    /// Renders the scene at `t_s` seconds: linear luminance relative to white.
    pub(super) fn light(&mut self, shared: &Shared, t_s: f32) -> &Plane<f32> {
        let body = &shared.body;
        let pose = self.performance.at(t_s).pose(body, &self.shaped, &mut self.posed);
        body.pose(&self.shaped, &pose, &mut self.posed);
        let placement: LookAt = self.path.at(t_s);
        let sensor = self.camera.sensor();
        self.camera = Camera::new(sensor, self.pinhole, &placement, NEAR_M);
        self.renderer.set_camera(self.camera);
        let size_px = [usize::from(sensor.width), usize::from(sensor.height)];
        let rect = self.background.dirty_rect(t_s, &placement, &self.pinhole, size_px);
        let (background, pinhole) = (&self.background, &self.pinhole);
        if !rect.is_empty() {
            self.renderer.repaint(rect, |frame| {
                background.paint(t_s, &placement, pinhole, rect, frame);
            });
        }
        let mesh = Mesh {
            vertices_m: &self.posed.vertices_m,
            normals: &self.posed.normals,
            uvs: &body.uvs,
            faces: &body.faces,
        };
        self.renderer.render(&mesh)
    }

    /// Camera of the last frame.
    pub(super) fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Joints of the last frame in the world, in metres.
    pub(super) fn joints_m(&self) -> BodyJoints3 {
        joints_m(&self.posed)
    }
}
