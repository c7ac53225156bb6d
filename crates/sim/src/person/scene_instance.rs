//! The scene of one sequence: people with activities, a background plane, objects and a camera.

use evpose_body::activity::{TRAINING_ACTIVITIES, activity_by_name};
use evpose_core::{
    CounterRng, Distortion, LensCamera, LookAt, Pinhole, PlacedCamera, Plane, seed_for,
};
use evpose_pose::body::BodyPoints;
use glam::{Affine3A, DAffine3, DVec2, Vec2, Vec3};

use super::background_plane::BackgroundPlane;
use super::camera_path::CameraPath;
use super::cast_member::{CastMember, MemberStreams};
use super::config::{Framing, PeopleConfig};
use super::joints::{BodyJoints3, joints_px};
use super::shared::Shared;
use crate::SimError;
use crate::raster::{Camera, PixelRect};

/// Distance of the near plane in metres; no camera is drawn that close to a person.
const NEAR_M: f32 = 0.1;
/// Distance of objects before the person, relative to the camera's.
const OCCLUDER_DEPTH: f32 = 0.5;
/// Distance of other people behind the person, in metres.
const BEHIND_M: [f32; 2] = [0.8, 3.0];
/// Distance of other people to the side, in metres.
const ASIDE_M: [f32; 2] = [-2.2, 2.2];

/// People, a background, objects and a camera, rendered at any time.
#[derive(Debug)]
pub(super) struct SceneInstance {
    /// Name of the activity, or of the captured motion.
    pub(super) activity: String,
    /// The person with labels; none in an empty scene.
    is_present: bool,
    person: CastMember,
    /// Other people, the farthest first.
    companions: Vec<CastMember>,
    path: CameraPath,
    pinhole: Pinhole,
    camera: Camera,
    background: BackgroundPlane,
    foreground: Option<BackgroundPlane>,
    luminance: Plane<f32>,
    /// Angle of the camera about the person in radians. The scene is rendered as if the camera were
    /// before the person, and the person turned by as much the other way.
    angle_rad: f32,
}

impl SceneInstance {
    /// Draws scene `index`, which lasts `seconds`, before one of its cameras. Each part has a random
    /// stream of its own; those of the camera and of all that is around the person differ from camera
    /// to camera.
    ///
    /// # Errors
    /// Captured motion that cannot be read.
    pub(super) fn draw(
        shared: &Shared,
        config: &PeopleConfig,
        seed: u64,
        (index, camera_number): (u64, u64),
        seconds: f32,
    ) -> Result<Self, SimError> {
        let images = &shared.images;
        let part = |name| CounterRng::new(seed, name, index);
        let part_of_camera = |name| match camera_number {
            // Camera 0 draws without its number: runs of one camera stay as they were.
            0 => part(name),
            other => CounterRng::new(seed_for(seed, name, other), name, index),
        };
        let angle_deg = config.camera_angles_deg.get(camera_number as usize).copied();
        let angle_rad = angle_deg.unwrap_or(0.0).to_radians();
        // In turn, so that every activity is as frequent as any other.
        let name = &config.activities[index as usize % config.activities.len()];
        // `PeopleConfig::validate` has checked the name.
        let activity = activity_by_name(name).unwrap_or(&TRAINING_ACTIVITIES[0]);
        let streams = MemberStreams {
            shape: part("person shape"),
            activity: part("person activity"),
            clothes: part("person clothes"),
            outfit: part("person outfit"),
            capture: part("person capture"),
        };
        let mut person = CastMember::draw(shared, config, activity, seconds, Vec3::ZERO, streams)?;
        // The drawn body's height, not the mean's: framing is relative to it.
        let height_m = shared.height_m(&person.shaped);
        let (path, pinhole) =
            CameraPath::draw(config, height_m, &mut part_of_camera("person camera"));
        let placement = *path.at_rest();
        let mut around = part_of_camera("person surroundings");
        // By seed and index alone, so that every camera sees the same people.
        let mut companions = companions(shared, config, seed, index, seconds)?;
        // A person's reach to the depth of a large room, and behind everybody.
        let farthest_m = companions.iter().map(|one| -one.place_m.z).fold(0.0, f32::max);
        let z_m = -farthest_m - around.uniform(0.8, 4.0);
        let sensor = config.sensor_size;
        let size_px = Vec2::new(f32::from(sensor.width), f32::from(sensor.height));
        let view = BackgroundPlane::view(z_m, &placement, &pinhole, size_px);
        let level = config.light_level;
        let background =
            BackgroundPlane::draw(&config.surroundings, images, z_m, &view, level, &mut around);
        let foreground = (config.occluders > 0).then(|| {
            // A part of the way to the person, where less of a plane is visible.
            let z_m = OCCLUDER_DEPTH * placement.eye_m.z;
            let view = BackgroundPlane::view(z_m, &placement, &pinhole, size_px);
            let mut rng = part_of_camera("person occluders");
            BackgroundPlane::foreground(images, z_m, &view, level, config.occluders, &mut rng)
        });
        let camera = Camera::new(sensor, pinhole, &placement, NEAR_M);
        let mut lighting = config.lights.draw(&mut part("person lights"));
        if angle_rad != 0.0 {
            // The world turns, not the camera: the planes stay before it.
            person.turn_rad = -angle_rad;
            let turn = Affine3A::from_rotation_y(-angle_rad);
            for light in &mut lighting.lights {
                light.direction = turn.transform_vector3a(light.direction);
            }
        }
        for one in companions.iter_mut().chain([&mut person]) {
            // Texture levels depend on how large a person appears.
            let px_per_m = pinhole.focal_px / (placement.eye_m.z - one.place_m.z);
            one.dress(shared, camera, px_per_m, lighting, level);
        }
        Ok(Self {
            activity: person
                .captured()
                .map_or(activity.name.to_owned(), |name| format!("cmu {name}")),
            is_present: config.framing != Framing::Nobody,
            person,
            companions,
            path,
            pinhole,
            camera,
            background,
            foreground,
            luminance: Plane::for_sensor(sensor, 0.0),
            angle_rad,
        })
    }

    /// Renders the scene at `t_s` seconds: linear luminance relative to white.
    pub(super) fn light(&mut self, shared: &Shared, t_s: f32) -> &Plane<f32> {
        self.person.pose_at(shared, t_s);
        let placement: LookAt = self.path.at(t_s);
        let sensor = self.camera.sensor();
        self.camera = Camera::new(sensor, self.pinhole, &placement, NEAR_M);
        let whole = PixelRect::whole(sensor);
        let changed = self.background.dirty_rect(t_s, &placement, &self.pinhole, whole);
        let (background, pinhole, camera) = (&self.background, &self.pinhole, self.camera);
        let mut cast: Vec<&mut CastMember> = self.companions.iter_mut().collect();
        for one in &mut cast {
            one.pose_at(shared, t_s);
        }
        if self.is_present {
            cast.push(&mut self.person);
        }
        // Everybody stands before what is behind them, from the farthest to the nearest.
        let mut seen: Option<&Plane<f32>> = None;
        for one in cast {
            // The first paints what changed of the background, the others all that is behind them.
            seen = Some(match seen {
                None => one.render(shared, camera, changed, |frame| {
                    background.paint(t_s, &placement, pinhole, changed, frame);
                }),
                Some(behind) => {
                    let copy = |frame: &mut Plane<f32>| frame.clone_from(behind);
                    one.render(shared, camera, whole, copy)
                }
            });
        }
        match (seen, &self.foreground) {
            (Some(seen), None) => return seen,
            (Some(seen), Some(_)) => self.luminance.clone_from(seen),
            (None, _) => {
                // Nobody was rendered: no frame holds the background of the step before.
                background.paint(t_s, &placement, pinhole, whole, &mut self.luminance);
            }
        }
        if let Some(foreground) = &self.foreground {
            // Nearest of all, so that it comes last.
            foreground.cover(t_s, &placement, pinhole, whole, &mut self.luminance);
        }
        &self.luminance
    }

    /// Shape coefficients of the person with labels.
    pub(super) fn betas(&self) -> &[f32] {
        &self.person.betas
    }

    /// Joints of the last frame on the image; none outside of it.
    pub(super) fn joints_px(&self) -> Option<BodyPoints> {
        self.is_present.then(|| joints_px(&self.person.joints_m(), &self.camera))
    }

    /// Joints of the last frame in the world, in metres; none in an empty scene.
    pub(super) fn joints_m(&self) -> Option<BodyJoints3> {
        let back = Affine3A::from_rotation_y(self.angle_rad);
        let in_world = |joint_m: Vec3| match self.angle_rad {
            0.0 => joint_m,
            _ => back.transform_point3(joint_m),
        };
        self.is_present.then(|| self.person.joints_m().map(in_world))
    }

    /// The camera in the world; none if it moves.
    pub(super) fn placed_camera(&self) -> Option<PlacedCamera> {
        let Pinhole { focal_px, principal_px } = self.pinhole;
        let lens = LensCamera {
            focal_px: DVec2::splat(focal_px.into()),
            principal_px: principal_px.as_dvec2(),
            distortion: Distortion::default(),
        };
        let camera_from_turned = self.path.at_rest().camera_from_world().as_dmat4();
        let turned_from_world = DAffine3::from_rotation_y(-f64::from(self.angle_rad));
        let camera_from_world = DAffine3::from_mat4(camera_from_turned) * turned_from_world;
        self.path.is_at_rest().then_some(PlacedCamera { lens, camera_from_world })
    }
}

/// Draws the other people of scene `index`, the farthest first.
fn companions(
    shared: &Shared,
    config: &PeopleConfig,
    seed: u64,
    index: u64,
    seconds: f32,
) -> Result<Vec<CastMember>, SimError> {
    let member = |k: usize| {
        // By number: a further companion leaves the others as they were.
        let part = |name| CounterRng::new(seed_for(seed, name, index), name, k as u64);
        let mut place = part("companion place");
        // Also those around the person: a training sees their limbs, too.
        let activity = &TRAINING_ACTIVITIES[place.below(TRAINING_ACTIVITIES.len())];
        let uniform = |rng: &mut CounterRng, [low, high]: [f32; 2]| rng.uniform(low, high);
        let place_m = Vec3::new(uniform(&mut place, ASIDE_M), 0.0, -uniform(&mut place, BEHIND_M));
        let streams = MemberStreams {
            shape: part("companion shape"),
            activity: part("companion activity"),
            clothes: part("companion clothes"),
            outfit: part("companion outfit"),
            capture: part("companion capture"),
        };
        CastMember::draw(shared, config, activity, seconds, place_m, streams)
    };
    let mut drawn = (0..config.companions).map(member).collect::<Result<Vec<_>, _>>()?;
    // There is no depth test between people: the nearer are painted over the farther.
    drawn.sort_by(|a, b| a.place_m.z.total_cmp(&b.place_m.z));
    Ok(drawn)
}
