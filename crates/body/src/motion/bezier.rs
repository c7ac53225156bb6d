//! Smooth motion between random targets, step by step.
//!
//! # Model
//! Every second a new quadratic Bezier curve begins at the present pose, with two random targets as
//! its other control points; position is continuous, velocity is not. A longer
//! [`MotionConfig::period_s`] slows all speeds in proportion; with [`MotionConfig::pause_s`] the
//! arm rests at the end of each curve. When the wrist leaves the view a new curve begins at once,
//! and again whenever the curve does not bring it nearer; the clock runs on. All 78 parameters and
//! the displacement follow the curve one by one, axis-angles included.
//!
//! Hands of people also rest in part: with [`MotionConfig::stay_probability`] the arm, the wrist and the
//! fingers each keep their pose for a curve, with [`MotionConfig::minimum_jerk`] a curve begins and
//! ends at rest (Flash, Hogan: *The coordination of arm movements*, J. Neurosci. 5(7), 1985), and
//! [`MotionConfig::articulation_low`] and `articulation_high` reach from flat hands to fists.
//!
//! # Source
//! EventHands, released simulator. There a wrist outside gets a new curve every step, so that it
//! trembles back towards the mean of all targets, and motion begins in the T-pose, above the image.
//! [`MotionConfig::parity`] does the same. Its sequences last eleven hours, so that the beginning
//! is nothing; ours may last seconds, so that they begin in the middle: see
//! [`BezierMotion::settle`].

use evpose_core::CounterRng;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::target::{ARTICULATION_RANGE, Part};
use super::{Target, Variant, ViewTest};
use crate::fingers::Fingers;

/// Curves before a recording. Three targets of four lie outside the view; after this many curves
/// the arm has come back, and its poses are spread like those of an endless motion.
const SETTLING_CURVES: u32 = 4;

/// How the arm moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MotionConfig {
    /// Distribution of the targets.
    pub variant: Variant,
    /// Duration of a curve in seconds; published: 1.
    pub period_s: f64,
    /// How long the arm then rests before the next; published: 0.
    pub pause_s: f64,
    /// Probability that the arm keeps its pose during a curve, and equally the wrist and the fingers;
    /// published: 0.
    pub stay_probability: f32,
    /// Whether a curve begins and ends at rest, along the same path; published: no.
    pub minimum_jerk: bool,
    /// Smallest articulation coefficients of targets; published: -2.
    pub articulation_low: [f32; 6],
    /// Largest articulation coefficients of targets; published: 2.
    pub articulation_high: [f32; 6],
    /// Source of the motion of the fingers; published: the articulation coefficients.
    #[serde(skip_serializing_if = "Fingers::is_components")]
    pub fingers: Fingers,
    /// Follow the quirks of the released program: the beginning in the T-pose, a new curve every
    /// step while the wrist is outside. Its view test is [`ViewTest::new`]'s `parity`.
    pub parity: bool,
}

impl Default for MotionConfig {
    fn default() -> Self {
        Self {
            variant: Variant::default(),
            period_s: 1.0,
            pause_s: 0.0,
            stay_probability: 0.0,
            minimum_jerk: false,
            articulation_low: [-ARTICULATION_RANGE; 6],
            articulation_high: [ARTICULATION_RANGE; 6],
            fingers: Fingers::Components,
            parity: false,
        }
    }
}

impl MotionConfig {
    /// Steps of a curve, and from the beginning of one to that of the next.
    fn steps(&self, step_hz: u32) -> [u32; 2] {
        let steps = |s: f64| (s * f64::from(step_hz)).round() as u32;
        let curve = steps(self.period_s).max(1);
        [curve, curve.saturating_add(steps(self.pause_s))]
    }

    /// A random target.
    fn target(&self, rng: &mut CounterRng) -> Target {
        let mut target = Target::draw(self.variant, rng);
        target.stretch_articulation(&self.articulation_low, &self.articulation_high);
        target
    }
}

/// A random motion: the same for the same seed, whatever else runs.
#[derive(Debug, Clone)]
pub struct BezierMotion {
    config: MotionConfig,
    seed: u64,
    steps_per_curve: u32,
    /// From the beginning of a curve to that of the next, with the rest between them.
    steps_between: u32,
    /// Steps since the beginning.
    steps: u64,
    /// Steps since the curve began.
    on_curve: u32,
    /// Curves begun.
    curves: u64,
    curve: [Target; 3],
    present: Target,
    /// How far outside the view the wrist was, a step ago.
    last_excess: f32,
}

impl BezierMotion {
    /// A motion of `step_hz` steps a second.
    ///
    /// # Panics
    /// If `step_hz` is zero.
    pub fn new(config: MotionConfig, seed: u64, step_hz: u32) -> Self {
        assert!(step_hz > 0, "a motion needs steps");
        let [steps_per_curve, steps_between] = config.steps(step_hz);
        // As published, all motions begin in the same pose.
        let start = if config.parity {
            Target::REST
        } else {
            config.target(&mut CounterRng::new(seed, "motion start", 0))
        };
        Self {
            config,
            seed,
            steps_per_curve,
            steps_between,
            steps: 0,
            on_curve: 0,
            curves: 0,
            curve: [start; 3],
            present: start,
            last_excess: 0.0,
        }
    }

    /// Moves on, unrecorded, to a random moment of the fifth curve: recordings then begin with
    /// poses like all others. Does nothing with [`MotionConfig::parity`].
    ///
    /// `wrist_m` finds the wrist of a pose.
    pub fn settle(&mut self, view: &ViewTest, mut wrist_m: impl FnMut(&Target) -> Vec3) {
        if self.config.parity {
            return;
        }
        let mut rng = CounterRng::new(self.seed, "motion phase", 0);
        let phase = rng.below(self.steps_between as usize) as u32;
        for _ in 0..SETTLING_CURVES * self.steps_between + phase {
            let at_m = wrist_m(self.step());
            self.call_back(view, at_m);
        }
    }

    /// Advances by one step and returns the pose there.
    pub fn step(&mut self) -> &Target {
        if self.steps.is_multiple_of(u64::from(self.steps_between)) {
            self.retarget(self.config.stay_probability);
        }
        self.steps += 1;
        self.on_curve += 1;
        let b = self.on_curve.min(self.steps_per_curve) as f32 / self.steps_per_curve as f32;
        let b = if self.config.minimum_jerk { minimum_jerk(b) } else { b };
        self.present = Target::bezier(&self.curve, b);
        &self.present
    }

    /// Begins a new curve at the present pose, in which each part stays with a probability.
    fn retarget(&mut self, stay_probability: f32) {
        let mut rng = CounterRng::new(self.seed, "motion target", self.curves);
        let [mut middle, mut end] = [(); 2].map(|()| self.config.target(&mut rng));
        let mut rng = CounterRng::new(self.seed, "motion stay", self.curves);
        for part in Part::ALL {
            if rng.chance(stay_probability) {
                middle.copy_part(part, &self.present);
                end.copy_part(part, &self.present);
            }
        }
        self.curve = [self.present, middle, end];
        self.on_curve = 0;
        self.curves += 1;
    }

    /// Begins a new curve if the wrist of the present pose lies outside `view` and does not come
    /// back; says whether it did. To be called once a step.
    pub fn call_back(&mut self, view: &ViewTest, wrist_m: Vec3) -> bool {
        let excess = view.excess(wrist_m);
        let comes_back = excess < self.last_excess && !self.config.parity;
        self.last_excess = excess.max(0.0);
        let called = excess > 0.0 && !comes_back;
        if called {
            self.retarget(0.0);
        }
        called
    }

    /// The pose of the last step.
    pub fn present(&self) -> &Target {
        &self.present
    }
}

/// The share of the way at the share `x` of the time, of the smoothest movement between two rests.
fn minimum_jerk(x: f32) -> f32 {
    x * x * x * (x * (6.0 * x - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use evpose_core::{LookAt, Pinhole, SensorSize};
    use glam::Vec2;

    use super::*;
    use crate::{BodyModel, BodyPose, PosedBody};

    fn motion(seed: u64) -> BezierMotion {
        BezierMotion::new(MotionConfig::default(), seed, 1000)
    }

    fn path(mut motion: BezierMotion, steps: usize) -> Vec<Target> {
        (0..steps).map(|_| *motion.step()).collect()
    }

    fn distance(a: &Target, b: &Target) -> f32 {
        let differences = a.parameters.iter().zip(b.parameters).map(|(a, b)| (a - b).abs());
        differences.fold(a.translation_m.distance(b.translation_m), f32::max)
    }

    /// The fastest parameter spans 4 within a curve of degree two: at most 2·4 a second.
    #[test]
    fn motion_is_continuous_across_curves() {
        for pair in path(motion(4), 5_000).windows(2) {
            assert!(distance(&pair[0], &pair[1]) <= 8.1e-3);
        }
    }

    #[test]
    fn a_curve_takes_a_second_and_ends_at_its_target() {
        let mut motion = motion(5);
        for _ in 0..1000 {
            motion.step();
        }
        assert_eq!(motion.curves, 1);
        assert_eq!(motion.present, motion.curve[2]);
        motion.step();
        assert_eq!(motion.curves, 2);
    }

    #[test]
    fn parts_that_stay_keep_their_pose_and_the_others_move() {
        let config =
            MotionConfig { stay_probability: 0.5, minimum_jerk: true, ..MotionConfig::default() };
        let path = path(BezierMotion::new(config, 8, 100), 40_000);
        let mut stays = [0; 3];
        for curve in path.chunks(100) {
            let (first, last) = (&curve[49], &curve[99]);
            let still = |entry: usize| first.parameters[entry] == last.parameters[entry];
            let parts = [57, 63, 72].map(still);
            assert_eq!(parts[0], first.translation_m == last.translation_m);
            assert_eq!(parts[1], still(65));
            assert_eq!(parts[2], still(77));
            for (count, stay) in stays.iter_mut().zip(parts) {
                *count += usize::from(stay);
            }
        }
        assert!(stays.iter().all(|stay| (160..240).contains(stay)), "{stays:?}");
    }

    #[test]
    fn a_minimum_jerk_curve_begins_and_ends_at_rest_on_the_same_path() {
        let config = MotionConfig { minimum_jerk: true, ..MotionConfig::default() };
        let eased = path(BezierMotion::new(config, 5, 1000), 1000);
        let even = path(motion(5), 1000);
        let speed =
            |k: usize| distance(&eased[k], &eased[k + 1]) / distance(&even[k], &even[k + 1]);
        assert!(speed(2) < 0.01 && speed(996) < 0.01, "{} {}", speed(2), speed(996));
        assert!(distance(&eased[499], &even[499]) < 1e-5);
        assert!((minimum_jerk(0.5) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn targets_fill_the_range_of_articulation() {
        let config = MotionConfig {
            articulation_low: [-1.0, -2.0, -2.0, -2.0, -2.0, -2.0],
            articulation_high: [4.0, 2.0, 2.0, 2.0, 2.0, 3.0],
            ..MotionConfig::default()
        };
        let drawn = |k: u64| config.target(&mut CounterRng::new(3, "t", k)).articulation();
        let targets: Vec<_> = (0..4_000).map(drawn).collect();
        for (k, (low, high)) in [(0, (-1.0, 4.0)), (1, (-2.0, 2.0)), (5, (-2.0, 3.0))] {
            let smallest = targets.iter().map(|t| t[k]).fold(f32::INFINITY, f32::min);
            let largest = targets.iter().map(|t| t[k]).fold(f32::NEG_INFINITY, f32::max);
            assert!(smallest >= low && smallest < low + 0.01, "{k}: {smallest}");
            assert!(largest <= high && largest > high - 0.01, "{k}: {largest}");
        }
    }

    /// The same curves in ten times the steps: a tenth of the speed everywhere.
    #[test]
    fn a_longer_period_slows_the_same_path() {
        let config = MotionConfig { period_s: 10.0, ..MotionConfig::default() };
        let slow = path(BezierMotion::new(config, 12, 1000), 20_000);
        let fast = path(motion(12), 2_000);
        for (k, pose) in fast.iter().enumerate() {
            assert!(distance(pose, &slow[10 * k + 9]) < 1e-5, "{k}");
        }
    }

    #[test]
    fn the_arm_rests_at_the_end_of_a_curve_for_the_pause() {
        let config = MotionConfig { period_s: 0.5, pause_s: 0.25, ..MotionConfig::default() };
        let path = path(BezierMotion::new(config, 13, 1000), 1_500);
        let rests = |from: usize| path[from..from + 251].windows(2).all(|pair| pair[0] == pair[1]);
        assert!(rests(499) && rests(1_249));
        assert!(path[749] != path[750] && path[498] != path[499], "it moves before and after");
        let moves = path[750..1_249].windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!(moves, 498);
    }

    #[test]
    fn a_retarget_leaves_the_pose_and_the_clock_alone() {
        let mut motion = motion(6);
        for _ in 0..300 {
            motion.step();
        }
        let before = motion.present;
        motion.retarget(0.0);
        assert_eq!(motion.present, before);
        assert!(distance(motion.step(), &before) <= 8.1e-3);
        for _ in 301..1000 {
            motion.step();
        }
        assert_eq!(motion.curves, 2);
        motion.step();
        assert_eq!(motion.curves, 3, "the next curve begins at the full second");
    }

    #[test]
    fn the_seed_decides_and_nothing_else() {
        assert_eq!(path(motion(7), 1_500), path(motion(7), 1_500));
        assert_ne!(path(motion(7), 10), path(motion(8), 10));
    }

    #[test]
    fn the_published_program_begins_in_the_t_pose() {
        let config = MotionConfig { parity: true, ..MotionConfig::default() };
        let mut motion = BezierMotion::new(config, 9, 1000);
        assert_eq!(*motion.present(), Target::REST);
        // One step on, the curve has left by at most 2·0.001 of the way to its middle.
        assert!(distance(motion.step(), &Target::REST) < 2.1e-3 * 2.0);
    }

    /// Follows the wrist of the procedural arm before the published camera.
    fn wrist_in_image(seed: u64, steps: usize) -> (usize, usize) {
        let model = BodyModel::procedural_arm();
        let person = model.shaped(&[]);
        let sensor = SensorSize::DAVIS240C;
        let camera = Pinhole::from_vertical_fov(sensor, 45.0);
        let look_at = LookAt {
            eye_m: Vec3::new(-0.45, -0.05, 0.4),
            centre_m: Vec3::new(-0.65, -0.05, 0.0),
            up: Vec3::Y,
        };
        let view = ViewTest::new(&look_at, &camera, sensor, false);
        let mut body = PosedBody::default();
        let mut wrist_m = |target: &Target| {
            let pose = BodyPose::from_generator(&model, &target.parameters, target.translation_m);
            model.pose_joints(&person, &pose, &mut body);
            Vec3::from(body.joints[model.wrist].translation)
        };
        let mut motion = motion(seed);
        motion.settle(&view, &mut wrist_m);
        let (mut inside, mut called) = (0, 0);
        for _ in 0..steps {
            let at_m = wrist_m(motion.step());
            called += usize::from(motion.call_back(&view, at_m));
            let in_camera_m = look_at.camera_from_world().transform_point3(at_m);
            let pixel = camera.image_from_camera(in_camera_m);
            inside += usize::from(pixel.is_some_and(|pixel| {
                pixel.cmpge(Vec2::ZERO).all() && pixel.cmplt(Vec2::new(240.0, 180.0)).all()
            }));
        }
        (inside, called)
    }

    #[test]
    fn the_wrist_stays_in_the_image_without_trembling() {
        let (inside, called) = wrist_in_image(11, 20_000);
        assert!(inside > 19_600, "{inside} of 20000 steps in the image");
        assert!(called < 200, "called back {called} times in 20 s");
    }
    /// Without settling, three of four would begin outside.
    #[test]
    fn recordings_begin_with_the_wrist_in_the_image() {
        let begun = (0..40).map(|seed| wrist_in_image(seed, 1).0).sum::<usize>();
        assert!(begun >= 37, "{begun} of 40");
    }
}
