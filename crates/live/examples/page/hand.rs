//! A hand that turns and grasps, with its mesh.

use std::f32::consts::PI;
use std::sync::Mutex;

use evpose_body::{BodyModel, PosedBody, ShapedBody};
use evpose_core::{Micros, Pinhole};
use evpose_live::page::{HandMesh, Skeleton};
use evpose_pose::HandParams;
use evpose_pose::PoseEstimate;
use evpose_pose::metric::HandPoints;
use glam::{Quat, Vec2, Vec3};

use crate::actor::{Actor, Outline, SENSOR};

pub(crate) struct Hand {
    model: BodyModel,
    person: ShapedBody,
    memory: Mutex<PosedBody>,
}

/// The camera stands at the origin of the world and looks along -z.
fn camera() -> Pinhole {
    Pinhole::from_vertical_fov(SENSOR, 40.0)
}

fn params(t: Micros) -> HandParams {
    let s = t.as_seconds() as f32;
    let grasp = 0.5 * (1.9 * s).sin();
    let turn = Quat::from_rotation_z(-0.5 * PI + 0.3 * (0.9 * s).sin())
        * Quat::from_rotation_x(0.5 * PI + 0.7 * (0.7 * s).sin());
    HandParams {
        articulation: [grasp, 0.6 * (1.3 * s).sin(), 0.4 * (2.3 * s).cos(), 0.0, 0.2 * grasp, 0.0],
        translation_m: Vec3::new(0.02 * (1.1 * s).sin(), -0.075 + 0.012 * (1.7 * s).cos(), -0.32),
        rotation: turn.to_scaled_axis(),
    }
}

impl Hand {
    pub(crate) fn new() -> Self {
        let model = BodyModel::procedural_arm();
        let person = model.shaped(&[]);
        Self { model, person, memory: Mutex::default() }
    }

    fn posed<T>(&self, t: Micros, read: impl FnOnce(&PosedBody) -> T) -> T {
        let mut body = self.memory.lock().expect("nobody panics with it");
        self.model.pose_hand(&self.person, &params(t), &mut body);
        read(&body)
    }

    fn outline_at(&self, t: Micros) -> Vec<Vec2> {
        let camera = camera();
        self.posed(t, |body| {
            let seen = |v: &Vec3| camera.image_from_camera(*v).unwrap_or(Vec2::NAN);
            body.vertices_m.iter().map(seen).collect()
        })
    }
}

impl Actor for Hand {
    fn skeleton(&self) -> Skeleton {
        Skeleton::Hand
    }

    fn mesh(&self) -> Option<HandMesh> {
        let (model, person, camera) = (self.model.clone(), self.person.clone(), camera());
        let faces = model.faces.clone();
        let mut body = PosedBody::default();
        let vertices = move |params: &HandParams| {
            model.pose_hand(&person, params, &mut body);
            let wrist_m = -params.translation_m.z;
            let seen = |v: &Vec3| {
                let at = camera.image_from_camera(*v)?;
                Some(at.extend(-v.z * camera.focal_px / wrist_m))
            };
            body.vertices_m.iter().map(seen).collect()
        };
        Some(HandMesh { faces, vertices: Box::new(vertices) })
    }

    fn pose(&self, t: Micros) -> PoseEstimate {
        let camera = camera();
        let world_m = self.posed(t, |body| body.evaluation_points(&self.model));
        let image_px = world_m.map(|point| camera.image_from_camera(point));
        let points = Box::new(HandPoints { world_m, image_px });
        let camera_m = Box::new(world_m.map(|at| Vec3::new(at.x, -at.y, -at.z)));
        PoseEstimate::Hand { params: params(t), points, camera_m }
    }

    fn outline(&self, t: Micros, later: Micros) -> Outline {
        let (before, now) = (self.outline_at(t), self.outline_at(later));
        let faces = self.model.faces.iter().map(|face| {
            let [a, b, _] = face.map(|vertex| vertex as usize);
            [[before[a], before[b]], [now[a], now[b]]]
        });
        Outline { strokes: faces.collect(), radius_px: 0.0 }
    }
}
