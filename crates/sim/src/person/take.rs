//! One person in one place before one camera.

use evpose_body::activity::{ACTIVITIES, Activity, Performance, activity_called};
use evpose_body::{PosedBody, ShapedBody};
use evpose_core::{CounterRng, LookAt, Pinhole, Plane};
use glam::{Vec2, Vec3A};

use super::camera_path::CameraPath;
use super::joints::{BodyJoints3, joints_m};
use super::people::Shared;
use super::wall::Wall;
use crate::raster::{Camera, Mesh};
use crate::scene::{Backdrop, FrameResponse, Renderer, Scene};
use crate::texture::paint_clothes;

/// What is nearer is not seen, in metres.
const NEAR_M: f32 = 0.1;

/// Somebody, what they do, where, and who looks at it.
#[derive(Debug)]
pub(super) struct Take {
    pub(super) activity: &'static Activity,
    pub(super) betas: Vec<f32>,
    performance: Performance,
    shaped: ShapedBody,
    posed: PosedBody,
    path: CameraPath,
    pinhole: Pinhole,
    camera: Camera,
    wall: Wall,
    renderer: Renderer,
}

impl Take {
    /// Draws take number `index`, which lasts for `seconds`. Each part has random numbers of its own.
    pub(super) fn draw(shared: &Shared, seed: u64, index: u64, seconds: f32) -> Self {
        let Shared { config, body, pictures, .. } = shared;
        let part = |name| CounterRng::new(seed, name, index);
        let name = &config.activities[index as usize % config.activities.len()];
        // Configurations are checked: the name is known.
        let activity = activity_called(name).unwrap_or(&ACTIVITIES[0]);
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
        let wall_z_m = -around.uniform(0.8, 4.0);
        let sensor = config.sensor_size;
        let size_px = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
        let view = Wall::view(wall_z_m, &placement, &pinhole, size_px);
        let level = config.light_level;
        let wall = Wall::draw(&config.surroundings, pictures, wall_z_m, &view, level, &mut around);
        let camera = Camera::new(sensor, pinhole, &placement, NEAR_M);
        let px_per_m = pinhole.focal_px / placement.eye_m.z;
        let scene = Scene {
            camera,
            lighting: config.lights.draw(&mut part("person lights")),
            skin: paint_clothes(&mut part("person clothes"))
                .reduced(shared.metres_per_texture, px_per_m),
            backdrop: Backdrop::uniform(sensor, Vec3A::ZERO),
            response: FrameResponse::Clipped,
        };
        let renderer = Renderer::new(scene, shared.is_closed, level);
        let posed = PosedBody::default();
        Self { activity, betas, performance, shaped, posed, path, pinhole, camera, wall, renderer }
    }

    /// The picture at a time in seconds: linear luminance relative to white.
    pub(super) fn light(&mut self, shared: &Shared, t_s: f32) -> &Plane<f32> {
        let body = &shared.body;
        let pose = self.performance.at(t_s).pose(body, &self.shaped, &mut self.posed);
        body.pose(&self.shaped, &pose, &mut self.posed);
        let placement: LookAt = self.path.at(t_s);
        let sensor = self.camera.sensor();
        self.camera = Camera::new(sensor, self.pinhole, &placement, NEAR_M);
        self.renderer.look_from(self.camera);
        let size_px = [usize::from(sensor.width), usize::from(sensor.height)];
        let rect = self.wall.changed(t_s, &placement, &self.pinhole, size_px);
        let (wall, pinhole) = (&self.wall, &self.pinhole);
        if !rect.is_empty() {
            self.renderer.repaint(rect, |image| wall.paint(t_s, &placement, pinhole, rect, image));
        }
        let mesh = Mesh {
            vertices_m: &self.posed.vertices_m,
            normals: &self.posed.normals,
            uvs: &body.uvs,
            faces: &body.faces,
        };
        self.renderer.render(&mesh)
    }

    /// The camera of the last picture.
    pub(super) fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The joints on the last picture, in the world.
    pub(super) fn joints_m(&self) -> BodyJoints3 {
        joints_m(&self.posed)
    }
}
