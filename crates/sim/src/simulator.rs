//! One sequence, step by step: pose, picture, label, exposure, events.

use std::sync::Arc;

use evpose_body::motion::{BezierMotion, ViewTest};
use evpose_body::{BodyModel, BodyPose, PosedBody, ShapedBody};
use evpose_core::{CounterRng, EventStream, Micros, Plane, seed_for};
use evpose_pose::{EVALUATION_JOINTS, HandParams};
use evpose_sensor::SensorRun;
use glam::{Vec3, Vec3A};

use crate::config::SimulationConfig;
use crate::episode::begins_at;
use crate::raster::{Camera, Mesh};
use crate::scene::{Backdrop, Renderer, Scene};
use crate::simulation::{Shared, Simulation};
use crate::texture::paint_skin;
use crate::{Episode, SimError};

/// Points of the hand that are evaluated.
const POINTS: usize = EVALUATION_JOINTS.len();

/// A hand before an event camera, advanced one step at a time.
///
/// # Source
/// EventHands simulator: advance the pose, render, write the label, compare with the memory. The
/// label of frame k is the pose at its end; its events happened since the pose of frame k - 1.
#[derive(Debug)]
pub struct Simulator {
    shared: Arc<Shared>,
    seed: u64,
    camera: Camera,
    motion: BezierMotion,
    view: ViewTest,
    posed: PosedBody,
    sensor: SensorRun,
    surroundings: Surroundings,
    /// Number of the next frame.
    next: u64,
}

/// What an episode looks like.
#[derive(Debug)]
pub(crate) struct Surroundings {
    episode: Episode,
    pub(crate) shaped: ShapedBody,
    pub(crate) renderer: Renderer,
}

/// One step of a sequence.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    /// Number of the frame, from 0.
    pub frame: u64,
    /// Time at its end, when the sensor was exposed. Frame 0 is at time zero.
    pub t: Micros,
    /// What the sensor was shown: linear luminance, relative to reference white.
    pub luminance: &'a Plane<f32>,
    /// What it answered.
    pub events: &'a EventStream,
    /// Pose of the hand.
    pub label: HandParams,
    /// The evaluated points in the world, in the order of [`EVALUATION_JOINTS`].
    pub points_m: [Vec3; POINTS],
    /// The episode the frame belongs to.
    pub episode: &'a Episode,
}

impl Simulator {
    /// The first sequence of a run with the procedural arm.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn new(config: &SimulationConfig, seed: u64) -> Result<Self, SimError> {
        Simulation::new(config, seed)?.sequence(0)
    }

    pub(crate) fn of_sequence(shared: Arc<Shared>, index: u64) -> Result<Self, SimError> {
        let seed = seed_for(shared.seed, "sequence", index);
        let config = &shared.config;
        let camera = config.camera();
        let mut motion =
            BezierMotion::new(config.motion, seed_for(seed, "motion", 0), config.step_hz);
        let view = ViewTest::new(
            &config.camera.placement(),
            &camera.pinhole(),
            camera.sensor(),
            config.motion.parity,
        );
        let surroundings = Surroundings::new(&shared, camera, seed, 0);
        let mut posed = PosedBody::default();
        motion.settle(&view, |target| {
            let pose =
                BodyPose::from_generator(&shared.body, &target.numbers, target.translation_m);
            shared.body.pose_joints(&surroundings.shaped, &pose, &mut posed);
            posed.joints[shared.body.wrist].translation.into()
        });
        let sensor = shared
            .sensor_model(surroundings.episode.threshold_offset)?
            .start(camera.sensor(), seed_for(seed, "sensor", 0));
        Ok(Self { shared, seed, camera, motion, view, posed, sensor, surroundings, next: 0 })
    }

    /// Simulates one step.
    ///
    /// # Errors
    /// If the sensor's thresholds, varied for a new episode, are out of its range.
    pub fn advance(&mut self) -> Result<Step<'_>, SimError> {
        let (frame, config) = (self.next, &self.shared.config);
        let lagging = config.parity.lagging_episode_clock;
        if frame > 0 && begins_at(frame, config.episode_frames(), lagging) {
            let next = self.surroundings.episode.index + 1;
            self.surroundings = Surroundings::new(&self.shared, self.camera, self.seed, next);
            let offset = self.surroundings.episode.threshold_offset;
            self.sensor.retune(&self.shared.sensor_model(offset)?)?;
        }
        let body = &self.shared.body;
        let Surroundings { episode, shaped, renderer } = &mut self.surroundings;
        let target = *self.motion.step();
        let pose = BodyPose::from_generator(body, &target.numbers, target.translation_m);
        body.pose(shaped, &pose, &mut self.posed);
        let label = self.posed.hand_params(body, target.articulation());
        // Where the wrist is now decides where it goes next; this frame is as it is.
        self.motion.call_back(&self.view, label.translation_m);
        let points_m = self.posed.evaluation_points(body);
        let t = Micros(frame as i64 * config.step().0);
        let luminance = renderer.render(&mesh(body, &self.posed));
        let events = self.sensor.expose(luminance, t)?;
        self.next += 1;
        Ok(Step { frame, t, luminance, events, label, points_m, episode })
    }

    /// The last frame in colour, linear and relative to reference white; before the first, the
    /// backdrop alone.
    pub fn picture(&mut self) -> Plane<Vec3A> {
        let mesh = mesh(&self.shared.body, &self.posed);
        self.surroundings.renderer.render_rgb(&mesh)
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The configuration of the run.
    pub fn config(&self) -> &SimulationConfig {
        &self.shared.config
    }

    /// The body that is simulated.
    pub fn body(&self) -> &BodyModel {
        &self.shared.body
    }
}

impl Surroundings {
    pub(crate) fn new(shared: &Shared, camera: Camera, sequence_seed: u64, index: u64) -> Self {
        let Shared { config, body, pictures, .. } = shared;
        let betas = body.shape_directions_m.len();
        let episode = Episode::draw(config, betas, pictures.len(), sequence_seed, index);
        let mut marks = CounterRng::new(sequence_seed, "episode skin marks", index);
        let picture = pictures.picture(episode.picture);
        let scene = Scene {
            camera,
            lighting: episode.lighting,
            skin: paint_skin(config.skin.texels, &episode.skin, &mut marks),
            backdrop: Backdrop::new(camera.sensor(), picture, episode.placement),
            response: config.frame,
        };
        Self {
            shaped: body.shaped(&episode.betas),
            renderer: Renderer::new(scene, shared.closed, config.light_level),
            episode,
        }
    }
}

pub(crate) fn mesh<'a>(body: &'a BodyModel, posed: &'a PosedBody) -> Mesh<'a> {
    Mesh {
        vertices_m: &posed.vertices_m,
        normals: &posed.normals,
        uvs: &body.uvs,
        faces: &body.faces,
    }
}
