//! A hand that moves by the generators: its wrist and arm, and its fingers.

use evpose_body::fingers::{FingerMotion, Fingers};
use evpose_body::motion::{BezierMotion, ViewTest};
use evpose_body::{BodyPose, PosedBody, ShapedBody};
use evpose_core::seed_for;
use evpose_pose::{HandParams, Mirror};

use crate::actor::Actor;
use crate::config::SimulationConfig;
use crate::stopwatch::{SimulationPart, Stopwatch};

/// Its motion, and its pose after the last step.
#[derive(Debug)]
pub(crate) struct MovingHand {
    motion: BezierMotion,
    /// The motion of the fingers, if they move by themselves.
    fingers: Option<FingerMotion>,
    pub(crate) posed: PosedBody,
}

impl MovingHand {
    /// Hand `index` of the sequence of a seed, in view of the camera.
    pub(crate) fn new(
        actor: &Actor,
        shaped: &ShapedBody,
        config: &SimulationConfig,
        view: &ViewTest,
        (seed, index): (u64, u64),
    ) -> Self {
        let motion_seed = seed_for(seed, "motion", index);
        let mut motion = BezierMotion::new(config.motion, motion_seed, config.step_hz);
        let fingers = (config.motion.fingers == Fingers::Gestures).then(|| {
            let seed = seed_for(seed, "fingers", index);
            FingerMotion::new(seed, config.step_hz, config.motion.period_s)
        });
        let mut posed = PosedBody::default();
        // The first pose has to be in view; only its joints are needed to know that.
        motion.settle(view, |target| {
            let (body, shaped) = actor.driven_body(shaped);
            let pose = BodyPose::from_generator(body, &target.parameters, target.translation_m);
            body.pose_joints(shaped, &pose, &mut posed);
            posed.joints[body.wrist].translation.into()
        });
        Self { motion, fingers, posed }
    }

    /// Moves on by a step, and returns the pose parameters of the right hand; `mirror` is the one before the camera.
    pub(crate) fn step(
        &mut self,
        actor: &Actor,
        shaped: &ShapedBody,
        (view, mirror): (&ViewTest, &Mirror),
        watch: &mut Stopwatch,
    ) -> HandParams {
        let target = *self.motion.step();
        let (driven, _) = actor.driven_body(shaped);
        let pose = BodyPose::from_generator(driven, &target.parameters, target.translation_m);
        let gesture = self.fingers.as_mut().map(|motion| actor.gesture(shaped, motion.step()));
        let articulation = gesture.map_or(target.articulation(), |(_, closest)| closest);
        let fingers = gesture.as_ref().map(|(rotations, _)| rotations);
        watch.lap(SimulationPart::Motion);
        let right = actor.apply_pose(shaped, pose, articulation, fingers, mirror, &mut self.posed);
        watch.lap(SimulationPart::Skinning);
        // A wrist that left the image changes the next target; this frame is as it is.
        self.motion.call_back(view, right.translation_m);
        right
    }
}
