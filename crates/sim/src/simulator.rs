//! One sequence, step by step: pose, rendering, label, exposure, events.

use std::sync::Arc;
use std::time::Instant;

use evpose_body::motion::ViewTest;
use evpose_body::{PosedBody, ShapedBody};
use evpose_core::{EventStream, LookAt, Micros, Plane, seed_for};
use evpose_pose::rotation::{axis_angle_from_matrix, matrix_from_axis_angle};
use evpose_pose::{HandParams, HandSide, Mirror};
use evpose_sensor::SensorRun;
use glam::{Affine3A, Mat3, Vec3A};

use crate::actor::{Actor, HandPoints3, mirror_before};
use crate::config::SimulationConfig;
use crate::episode::starts_episode;
use crate::moving_hand::MovingHand;
use crate::other_hand::OtherHand;
use crate::raster::{Camera, Mesh};
use crate::scene::{Backdrop, Renderer, Scene};
use crate::simulation::{Shared, Simulation};
use crate::stopwatch::{SimulationPart, Stopwatch};
use crate::{Episode, RecordingTime, SimError};

/// Simulator of one sequence of a hand, advanced one step at a time.
///
/// # Source
/// EventHands simulator: advance the pose, render, write the label, compare with the reference
/// level. The label of frame k is the pose at its end; its events happened since the pose of frame
/// k - 1.
#[derive(Debug)]
pub struct Simulator {
    shared: Arc<Shared>,
    config: SimulationConfig,
    label_from_world: Option<Affine3A>,
    seed: u64,
    side: HandSide,
    /// Mirror before the camera, which a displaced one has at another place than the configured.
    mirror: Mirror,
    camera: Camera,
    view: ViewTest,
    hand: MovingHand,
    /// One that is in view, too, and has no label.
    other: Option<OtherHand>,
    sensor: SensorRun,
    surroundings: Surroundings,
    next: u64,
    stopwatch: Stopwatch,
    time: RecordingTime,
}

/// An episode's parameters, shaped body and renderer.
#[derive(Debug)]
pub(crate) struct Surroundings {
    episode: Episode,
    pub(crate) shaped: ShapedBody,
    pub(crate) renderer: Renderer,
}

/// One step of a sequence of a hand.
#[derive(Debug, Clone, Copy)]
pub struct HandStep<'a> {
    /// Index of the frame, from 0.
    pub frame: u64,
    /// Time at its end, when the sensor was exposed. Frame 0 is at time zero.
    pub t: Micros,
    /// Frame that the sensor was exposed to: linear luminance, relative to reference white.
    pub luminance: &'a Plane<f32>,
    /// Events of the step.
    pub events: &'a EventStream,
    /// Pose parameters of the hand.
    pub label: HandParams,
    /// Evaluated points in the world, in metres, in the order of
    /// [`evpose_pose::EVALUATION_JOINTS`].
    pub points_m: HandPoints3,
    /// The episode the frame belongs to.
    pub episode: &'a Episode,
}

impl Simulator {
    /// Starts the first sequence of a run.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn new(config: &SimulationConfig, seed: u64) -> Result<Self, SimError> {
        Simulation::new(config, seed)?.sequence(0)
    }

    pub(crate) fn of_sequence(shared: Arc<Shared>, index: u64) -> Result<Self, SimError> {
        let seed = seed_for(shared.seed, "sequence", index);
        let config = shared.config_of(index)?;
        let (side, camera) = (config.hands.side(index), config.placed_camera());
        let view = ViewTest::new(
            &config.placement(),
            &camera.pinhole(),
            camera.sensor(),
            config.motion.parity,
        );
        let surroundings = Surroundings::new(&shared, &config, side, seed, 0)?;
        let (actor, shaped) = (&shared.actor, &surroundings.shaped);
        let hand = MovingHand::new(actor, shaped, &config, &view, (seed, 0));
        let other =
            config.another_hand.then(|| OtherHand::new(actor, shaped, &config, side, &view, seed));
        let sensor = config
            .sensor
            .model(surroundings.episode.threshold_offset)?
            .start(camera.sensor(), seed_for(seed, "sensor", 0));
        Ok(Self {
            shared,
            label_from_world: config.label_from_world(),
            mirror: mirror_before(&config.placement()),
            config,
            seed,
            side,
            camera,
            view,
            hand,
            other,
            sensor,
            surroundings,
            next: 0,
            stopwatch: Stopwatch::default(),
            time: RecordingTime::default(),
        })
    }

    /// Enables the stopwatch.
    #[must_use]
    pub fn timed(self) -> Self {
        Self { stopwatch: Stopwatch::running(), ..self }
    }

    /// Durations of the parts of the steps so far, if [`timed`](Self::timed).
    pub fn stopwatch(&self) -> &Stopwatch {
        &self.stopwatch
    }

    /// Time of the steps so far.
    pub fn time(&self) -> RecordingTime {
        self.time
    }

    /// Simulates one step.
    ///
    /// # Errors
    /// If the sensor's thresholds, varied for a new episode, are out of its range, or a file of
    /// skins can no longer be read.
    pub fn advance(&mut self) -> Result<HandStep<'_>, SimError> {
        let begun = Instant::now();
        let (frame, config) = (self.next, &self.config);
        let lagging = config.parity.lagging_episode_clock;
        // The first frame has its episode since the sequence began.
        if frame > 0 && starts_episode(frame, config.episode_frames(), lagging) {
            let next = self.surroundings.episode.index + 1;
            self.surroundings =
                Surroundings::new(&self.shared, config, self.side, self.seed, next)?;
            let offset = self.surroundings.episode.threshold_offset;
            // Pixels keep their reference levels from episode to episode, as those of a camera do.
            self.sensor.retune(&config.sensor.model(offset)?)?;
        }
        let (actor, mirror) = (&self.shared.actor, &self.mirror);
        let (side, watch) = (self.side, &mut self.stopwatch);
        watch.begin();
        let Surroundings { episode, shaped, renderer } = &mut self.surroundings;
        let before = (&self.view, mirror);
        let right = self.hand.step(actor, shaped, before, watch);
        let posed = &self.hand.posed;
        if let Some(other) = &mut self.other {
            other.step(actor, shaped, before, (posed, &right));
        }
        let mut label = if side.is_right() { right } else { mirror.hand(&right) };
        let mut points_m = actor.points(posed, side, mirror);
        if let Some(label_from_world) = &self.label_from_world {
            label = moved(&label, label_from_world);
            points_m = points_m.map(|point_m| label_from_world.transform_point3(point_m));
        }
        let t = Micros(frame as i64 * config.step().0);
        watch.lap(SimulationPart::Motion);
        let mesh = self.other.as_ref().map_or_else(|| mesh(actor, posed, side), OtherHand::mesh);
        renderer.rasterize(&mesh);
        watch.lap(SimulationPart::Raster);
        watch.sample_coverage(frame, self.camera.sensor().pixels(), || renderer.covered());
        let luminance = renderer.shade(&mesh);
        watch.lap(SimulationPart::Shading);
        let lit = Instant::now();
        let events = self.sensor.expose(luminance, t)?;
        watch.lap(SimulationPart::Sensor);
        self.time.rendering += lit - begun;
        self.time.sensor += lit.elapsed();
        self.next += 1;
        Ok(HandStep { frame, t, luminance, events, label, points_m, episode })
    }

    /// The last frame in colour, linear and relative to reference white; before the first, the
    /// backdrop alone.
    pub fn frame_rgb(&mut self) -> Plane<Vec3A> {
        let alone = || mesh(&self.shared.actor, &self.hand.posed, self.side);
        let mesh = self.other.as_ref().map_or_else(alone, OtherHand::mesh);
        self.surroundings.renderer.render_rgb(&mesh)
    }

    /// Camera of the recording.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The configuration of the sequence.
    pub fn config(&self) -> &SimulationConfig {
        &self.config
    }

    /// Side of the simulated hand.
    pub fn side(&self) -> HandSide {
        self.side
    }
}

impl Surroundings {
    pub(crate) fn new(
        shared: &Shared,
        config: &SimulationConfig,
        side: HandSide,
        sequence_seed: u64,
        index: u64,
    ) -> Result<Self, SimError> {
        let Shared { actor, backgrounds, skins, .. } = shared;
        let (body, camera) = (actor.body(), config.placed_camera());
        let betas = body.shape_coefficients();
        let episode = Episode::draw(config, betas, backgrounds.len(), sequence_seed, index);
        let background = backgrounds.image(episode.background);
        // At the distance of the view's centre: one texture level serves all poses.
        let LookAt { eye_m, centre_m, .. } = config.placement();
        let px_per_m = camera.pinhole().focal_px / eye_m.distance(centre_m);
        let skin = skins.paint(&config.skin, &episode.skin, sequence_seed, index)?;
        let scene = Scene {
            // The model is of one side: the other hand is the same seen in a mirror.
            camera: if actor.is_mirrored(side) { camera.mirrored() } else { camera },
            lighting: episode.lighting,
            skin: skin.mip_level(actor.metres_per_texture(), px_per_m),
            backdrop: Backdrop::new(camera.sensor(), background, episode.placement),
            response: config.frame,
        };
        Ok(Self {
            shaped: body.shaped(&episode.betas),
            renderer: Renderer::new(scene, actor.is_closed(), config.light_level),
            episode,
        })
    }
}

fn moved(hand: &HandParams, motion: &Affine3A) -> HandParams {
    let turned = Mat3::from(motion.matrix3) * matrix_from_axis_angle(hand.rotation);
    HandParams {
        translation_m: motion.transform_point3(hand.translation_m),
        rotation: axis_angle_from_matrix(turned),
        ..*hand
    }
}

/// The posed mesh of `actor` as a hand of `side`.
pub(crate) fn mesh<'a>(actor: &'a Actor, posed: &'a PosedBody, side: HandSide) -> Mesh<'a> {
    Mesh {
        vertices_m: &posed.vertices_m,
        normals: &posed.normals,
        uvs: &actor.body().uvs,
        faces: actor.faces(side),
    }
}
